//! What scenarios may name: pedestrian models, controllers, dynamics, perception and metrics, as one value.
//!
//! A registry is made once, by `models::standard` or by adding to it, and handed to whoever reads names:
//! checker, editor, documentation. What was checked holds the entries themselves.

mod check;
mod kind;
mod resolve;
mod table;

use std::fmt;
use std::sync::Arc;

use crate::{
    ControllerModel, Declaration, DynamicsModel, Metric, PedestrianModel, PerceptionModel, Reference,
    Registered,
};

pub use check::{RESERVED, RegistryError};
pub use kind::EntryKind;
pub use resolve::UnknownEntry;
pub use table::Table;

/// Everything that scenarios may name. Cheap to clone.
#[derive(Clone)]
pub struct Registry {
    pedestrians: Table<PedestrianModel>,
    controllers: Table<ControllerModel>,
    dynamics: Table<DynamicsModel>,
    perception: Arc<PerceptionModel>,
    metrics: Table<Metric>,
}

impl fmt::Debug for Registry {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let names = |declarations: Vec<&Declaration>| -> Vec<String> {
            declarations.iter().map(|declaration| declaration.name.to_string()).collect()
        };
        f.debug_map().entries(self.declarations().map(|(kind, all)| (kind, names(all)))).finish()
    }
}

impl Registry {
    /// Nothing but what `sees { … }` says.
    ///
    /// # Errors
    /// If the declaration is not one that scenarios can speak of.
    pub fn new(perception: PerceptionModel) -> Result<Self, RegistryError> {
        check::declaration(&perception.declaration)?;
        Ok(Self {
            pedestrians: Table::default(),
            controllers: Table::default(),
            dynamics: Table::default(),
            perception: Arc::new(perception),
            metrics: Table::default(),
        })
    }

    /// With one more pedestrian model.
    ///
    /// # Errors
    /// If there is one of its name already, or its declaration is not one that scenarios can speak of; as below.
    pub fn with_pedestrian(mut self, model: PedestrianModel) -> Result<Self, RegistryError> {
        self.pedestrians.add(EntryKind::PedestrianModel, model)?;
        Ok(self)
    }

    /// With one more controller, whose default dynamics must be there and take what it gives.
    ///
    /// # Errors
    /// As [`Self::with_pedestrian`], and if they are not or do not.
    pub fn with_controller(mut self, mut model: ControllerModel) -> Result<Self, RegistryError> {
        let named = model.default_dynamics.name();
        let unknown = || RegistryError::UnknownDynamics {
            controller: model.declaration.name.to_string(),
            dynamics: named.to_string(),
            nearest: self.dynamics.nearest(named),
        };
        let dynamics = self.dynamics.get(named).ok_or_else(unknown)?;
        if !dynamics.takes.contains(&model.gives) {
            return Err(RegistryError::UnfitDynamics {
                controller: model.declaration.name.to_string(),
                dynamics: named.to_string(),
            });
        }
        model.default_dynamics = Reference::from(dynamics);
        self.controllers.add(EntryKind::Controller, model)?;
        Ok(self)
    }

    /// With other vehicle dynamics besides.
    ///
    /// # Errors
    /// As [`Self::with_pedestrian`].
    pub fn with_dynamics(mut self, model: DynamicsModel) -> Result<Self, RegistryError> {
        self.dynamics.add(EntryKind::VehicleDynamics, model)?;
        Ok(self)
    }

    /// With one more metric.
    ///
    /// # Errors
    /// As [`Self::with_pedestrian`].
    pub fn with_metric(mut self, metric: Metric) -> Result<Self, RegistryError> {
        check::metric(&metric)?;
        self.metrics.add(EntryKind::Metric, metric)?;
        Ok(self)
    }

    /// With another perception instead.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_perception(self, perception: PerceptionModel) -> Result<Self, RegistryError> {
        check::declaration(&perception.declaration)?;
        Ok(Self { perception: Arc::new(perception), ..self })
    }

    /// Everything that `model` of a pedestrian may name.
    pub fn pedestrians(&self) -> &Table<PedestrianModel> {
        &self.pedestrians
    }

    /// Everything that `controller` of a vehicle may name.
    pub fn controllers(&self) -> &Table<ControllerModel> {
        &self.controllers
    }

    /// Everything that `dynamics` of a vehicle may name.
    pub fn dynamics(&self) -> &Table<DynamicsModel> {
        &self.dynamics
    }

    /// What `sees { … }` says.
    pub fn perception(&self) -> &Arc<PerceptionModel> {
        &self.perception
    }

    /// Everything that criteria, searches and reports may name.
    pub fn metrics(&self) -> &Table<Metric> {
        &self.metrics
    }

    /// Everything of a kind, with the kind's name for documentation.
    pub fn declarations(&self) -> [(&'static str, Vec<&Declaration>); 5] {
        [
            ("pedestrian models", self.pedestrians.declarations().collect()),
            ("controllers", self.controllers.declarations().collect()),
            ("vehicle dynamics", self.dynamics.declarations().collect()),
            ("perception", vec![self.perception.declaration()]),
            ("metrics", self.metrics.declarations().collect()),
        ]
    }
}
