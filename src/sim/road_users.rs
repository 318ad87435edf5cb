//! The minds and bodies of a run.

use scenario::agent::{Controller, Dynamics, Pedestrian, Perception, Schedule};

/// The minds and bodies of a run, in the order of the world's setups.
pub struct RoadUsers {
    /// In the order of [`World::vehicles`](scenario::World::vehicles).
    pub vehicles: Vec<Driven>,
    /// In the order of [`World::pedestrians`](scenario::World::pedestrians).
    pub pedestrians: Vec<Box<dyn Pedestrian>>,
}

/// A vehicle: who decides for it, what that is shown, and the dynamics that it drives.
pub struct Driven {
    /// A controller, or somebody outside.
    pub driver: Driver,
    /// `None`: everything is seen at once and exactly.
    pub perception: Option<Box<dyn Perception>>,
    /// How the vehicle follows commands.
    pub dynamics: Box<dyn Dynamics>,
}

impl Driven {
    /// A vehicle with a controller that sees everything.
    pub fn new(controller: Box<dyn Controller>, dynamics: Box<dyn Dynamics>) -> Self {
        Self { driver: Driver::Inside(controller), perception: None, dynamics }
    }
}

/// Who decides for a vehicle.
pub enum Driver {
    /// A controller that is asked while the run goes on.
    Inside(Box<dyn Controller>),
    /// Whoever drives the [`Course`](super::Course), which waits for each decision.
    Outside {
        /// When it decides; the command is held in between.
        schedule: Schedule,
        /// Time needed in free flow until vehicle and driver are in steady cruise, s.
        settling_time: f64,
    },
}

impl Driver {
    /// When it decides.
    pub fn schedule(&self) -> Schedule {
        match self {
            Self::Inside(controller) => controller.schedule(),
            Self::Outside { schedule, .. } => *schedule,
        }
    }

    /// Time that it needs in free flow, s.
    pub fn settling_time(&self) -> f64 {
        match self {
            Self::Inside(controller) => controller.settling_time(),
            Self::Outside { settling_time, .. } => *settling_time,
        }
    }

    /// Whether it may look at pedestrians or other vehicles.
    pub fn looks_at_others(&self) -> bool {
        match self {
            Self::Inside(controller) => controller.looks_at_others(),
            Self::Outside { .. } => true,
        }
    }
}
