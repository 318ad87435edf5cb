//! One concrete run: every expression evaluated, every parameter filled in.

use std::fmt;
use std::sync::Arc;

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::{
    ControllerModel, DynamicsModel, PedestrianModel, PerceptionModel, Reference, Registered, Road,
    SettingError, Settings, Side, Value,
};
use numbers::json;

/// One run. Everything that decides its outcome is in here.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Stable name such as `zebra/carla_walker/tta=6s/individual=17/rep=2`: names the run in every report, seeds it,
    /// and is what `scenario-runner replay` takes.
    pub key: String,
    pub scenario: String,
    pub variation: Vec<Assignment>,
    /// The parameter sets drawn for pedestrians, in the order of the pedestrians that have one.
    pub individuals: Vec<Individual>,
    pub repetition: u32,
    #[serde(with = "json::whole")]
    pub seed: u64,
    /// Shared by all repetitions.
    pub world: Arc<World>,
}

/// A variation's name with the value it has in a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Assignment {
    pub name: String,
    pub label: String,
    pub value: Value,
}

/// One person: a parameter set of a population.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Individual {
    pub pedestrian: String,
    pub population: String,
    /// Its number in the population, counted from 1.
    pub number: u32,
    pub parameters: Settings,
}

/// What the simulation needs to know of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct World {
    pub road: Road,
    pub vehicles: Vec<VehicleSetup>,
    pub pedestrians: Vec<PedestrianSetup>,
    /// s
    pub step: f64,
    /// s
    pub horizon: f64,
    /// Distance of the finish line behind the middle of the crossing in m.
    pub finish: f64,
    pub end_on_collision: bool,
}

/// A registered model, controller, dynamics or perception with every declared parameter resolved.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub struct ModelSetup<T> {
    #[serde(rename = "name")]
    pub model: Reference<T>,
    pub settings: Settings,
}

impl<T: Registered> ModelSetup<T> {
    /// An entry with these settings, and its defaults for the others.
    ///
    /// # Errors
    /// The first setting that does not fit what the entry declares.
    pub fn resolved(entry: &Arc<T>, given: &Settings) -> Result<Self, SettingError> {
        Ok(Self { settings: entry.declaration().resolve(given)?, model: entry.into() })
    }
}

impl<T> fmt::Debug for ModelSetup<T> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("ModelSetup").field("name", &self.model).field("settings", &self.settings).finish()
    }
}

impl<T> Clone for ModelSetup<T> {
    fn clone(&self) -> Self {
        Self { model: self.model.clone(), settings: self.settings.clone() }
    }
}

impl<T> PartialEq for ModelSetup<T> {
    fn eq(&self, other: &Self) -> bool {
        self.model == other.model && self.settings == other.settings
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VehicleSetup {
    pub name: String,
    pub controller: ModelSetup<ControllerModel>,
    pub dynamics: ModelSetup<DynamicsModel>,
    /// m
    pub length: f64,
    /// m
    pub width: f64,
    /// Index into [`Road::lanes`].
    pub lane: usize,
    /// Speed of the steady cruise at the start in m/s; also what a controller takes as its wanted speed by default.
    pub speed: f64,
    pub start: VehicleStart,
    /// `None`: perfect perception.
    pub sees: Option<ModelSetup<PerceptionModel>>,
}

/// Where a vehicle's centre is at time 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VehicleStart {
    /// This many metres before the middle of the crossing.
    Distance(f64),
    /// At the time to arrival `time` (s) at the line across the road at world `x` (m), for a part of the vehicle and
    /// at the speed it cruises at once settled.
    TimeToArrival { time: f64, reference: VehicleReference, x: f64 },
}

/// The part of a vehicle that distances and times to arrival are measured from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VehicleReference {
    #[default]
    Centre,
    Front,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PedestrianSetup {
    pub name: String,
    pub model: ModelSetup<PedestrianModel>,
    pub shape: Shape,
    pub side: Side,
    pub start: Position,
    pub goal: Position,
    pub appears: Appearance,
}

/// A pedestrian's footprint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    Disc {
        /// m
        radius: f64,
    },
    /// Turns with the pedestrian's heading.
    Rectangle {
        /// Along the heading, m.
        length: f64,
        /// Across the heading, m.
        width: f64,
    },
}

/// A place in the world frame (see [`Road`]) in m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Position {
    pub x: f64,
    pub y: f64,
}

impl From<Position> for Vector2<f64> {
    fn from(Position { x, y }: Position) -> Self {
        Self::new(x, y)
    }
}

/// When a pedestrian enters the world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Appearance {
    /// At a time in s.
    At(f64),
    /// At the first step at which the time to arrival of vehicle `vehicle` at the pedestrian's place along the road
    /// is at most `time` (s).
    TimeToArrival { vehicle: usize, reference: VehicleReference, time: f64 },
}
