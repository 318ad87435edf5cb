//! Everything that ships for scenarios to name.

use crate::registry::{Registry, RegistryError};
use crate::{metrics, pedestrian, vehicle};

/// The registry of all models, controllers, dynamics and metrics that ship.
///
/// # Panics
/// Never: a test holds that they fit each other.
pub fn standard() -> Registry {
    all().expect("what ships fits together")
}

fn all() -> Result<Registry, RegistryError> {
    let mut registry = Registry::new(vehicle::perception())?;
    for model in pedestrian::models() {
        registry = registry.with_pedestrian(model)?;
    }
    // Before controllers, which name those that they drive.
    for model in vehicle::dynamics() {
        registry = registry.with_dynamics(model)?;
    }
    for model in vehicle::controllers() {
        registry = registry.with_controller(model)?;
    }
    for model in metrics::metrics() {
        registry = registry.with_metric(model)?;
    }
    Ok(registry)
}

/// What ships, by name, for tests.
#[cfg(test)]
pub mod known {
    use super::standard;
    use crate::scenario::{Metric, MetricReference, Reference};

    pub fn metric(name: &str) -> Reference<Metric> {
        standard().metrics().get(name).unwrap_or_else(|| panic!("there is no metric `{name}`")).into()
    }

    /// With its defaults, for everybody.
    pub fn measured(name: &str) -> MetricReference {
        MetricReference::plain(metric(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_ships_fits_together() {
        assert!(all().is_ok(), "{}", all().err().map(|error| error.to_string()).unwrap_or_default());
    }
}
