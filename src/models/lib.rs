//! Everything that ships for scenarios to name.

// What `clippy.toml` bans is banned from what is shipped; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

pub mod calibrate;
pub mod metrics;
pub mod pedestrian;
pub mod vehicle;

use scenario::registry::{Registry, RegistryError};

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
#[doc(hidden)]
pub mod known {
    use super::standard;
    use scenario::{Metric, MetricReference, Reference};

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
