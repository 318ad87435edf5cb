//! What was read from bytes holds names alone: here they become the entries of a registry again.

use std::sync::Arc;

use thiserror::Error;

use super::{EntryKind, Registry, Table};
use crate::{Case, MetricReference, ModelSetup, Reference, Registered, World};

/// A name that a registry does not have. Nothing stands in for what it names.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("there is no {kind} called `{name}`")]
pub struct UnknownEntry {
    /// What it should be.
    pub kind: EntryKind,
    /// What is named.
    pub name: String,
}

impl Registry {
    /// Lets the references of `world` stand for the entries of their names.
    ///
    /// # Errors
    /// The first name that the registry does not have; the world may be resolved in part then.
    pub fn resolve_world(&self, world: &mut World) -> Result<(), UnknownEntry> {
        let World {
            road: _,
            other_roads: _,
            streams: _,
            vehicles,
            pedestrians,
            step: _,
            horizon: _,
            finish: _,
            end_on_collision: _,
        } = world;
        for vehicle in vehicles {
            of_table(EntryKind::Controller, &mut vehicle.controller.model, &self.controllers)?;
            of_table(EntryKind::VehicleDynamics, &mut vehicle.dynamics.model, &self.dynamics)?;
            if let Some(ModelSetup { model, .. }) = &mut vehicle.sees {
                let only = Some(&self.perception).filter(|known| known.declaration().name == model.name());
                becomes(EntryKind::Perception, model, only)?;
            }
        }
        for pedestrian in pedestrians {
            of_table(EntryKind::PedestrianModel, &mut pedestrian.model.model, &self.pedestrians)?;
        }
        Ok(())
    }

    /// Lets a metric stand for the entry of its name.
    ///
    /// # Errors
    /// If the registry does not have it.
    pub fn resolve_metric(&self, metric: &mut MetricReference) -> Result<(), UnknownEntry> {
        of_table(EntryKind::Metric, &mut metric.metric, &self.metrics)
    }
}

impl Case {
    /// The same, with everything that its world names resolved: of one that was read, only the names are known.
    ///
    /// # Errors
    /// The first name that the registry does not have.
    pub fn resolved(mut self, registry: &Registry) -> Result<Self, UnknownEntry> {
        registry.resolve_world(Arc::make_mut(&mut self.world))?;
        Ok(self)
    }
}

fn of_table<T: Registered>(
    kind: EntryKind,
    reference: &mut Reference<T>,
    table: &Table<T>,
) -> Result<(), UnknownEntry> {
    let entry = table.get(reference.name());
    becomes(kind, reference, entry)
}

fn becomes<T: Registered>(
    kind: EntryKind,
    reference: &mut Reference<T>,
    entry: Option<&Arc<T>>,
) -> Result<(), UnknownEntry> {
    let unknown = || UnknownEntry { kind, name: reference.name().to_string() };
    *reference = entry.ok_or_else(unknown)?.into();
    Ok(())
}
