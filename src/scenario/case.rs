//! One concrete run: every expression evaluated, every parameter filled in.

use std::fmt;
use std::sync::Arc;

use nalgebra::Vector2;
use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

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
    /// Its scenario's name.
    pub scenario: String,
    /// The values of its variations, in the order in which they are declared.
    pub variation: Vec<Assignment>,
    /// The parameter sets drawn for pedestrians, in the order of the pedestrians that have one.
    pub individuals: Vec<Individual>,
    /// Counted from 1.
    pub repetition: u32,
    /// What every random stream of the run is derived from.
    #[serde(with = "json::whole")]
    pub seed: u64,
    /// Shared by all repetitions.
    pub world: Arc<World>,
}

/// A variation's name with the value it has in a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Assignment {
    /// Of the variation.
    pub name: String,
    /// The value as it was written, without spaces: `6s`. It is the part of the key.
    pub label: String,
    /// SI units.
    pub value: Value,
}

/// One person: a parameter set of a population.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Individual {
    /// The pedestrian who is that person, by name.
    pub pedestrian: String,
    /// `standard`, or the path of the file that the sets are in.
    pub population: String,
    /// Its number in the population, counted from 1.
    pub number: u32,
    /// By the names of the model's parameters, SI units.
    pub parameters: Settings,
}

/// What the simulation needs to know of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct World {
    /// Where everybody moves.
    pub road: Road,
    /// In the order in which they are declared, which is that of every index of a vehicle.
    pub vehicles: Vec<VehicleSetup>,
    /// In the order in which they are declared, which is that of every index of a pedestrian.
    pub pedestrians: Vec<PedestrianSetup>,
    /// s
    pub step: f64,
    /// s
    pub horizon: f64,
    /// Distance of the finish line behind the middle of the crossing in m.
    pub finish: f64,
    /// Whether a collision ends the run.
    pub end_on_collision: bool,
}

/// A registered model, controller, dynamics or perception with every declared parameter resolved.
///
/// Written down with what runs, where a file declares that: it is part of what the run is.
#[derive(Deserialize)]
#[serde(bound = "")]
pub struct ModelSetup<T> {
    /// The entry of the registry.
    #[serde(rename = "name")]
    pub model: Reference<T>,
    /// A value for every parameter, apart from numbers declared without a default that nobody set.
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

impl<T: Registered> Serialize for ModelSetup<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let runs = self.model.known().and_then(Registered::runs);
        let mut fields = serializer.serialize_struct("ModelSetup", 2 + usize::from(runs.is_some()))?;
        fields.serialize_field("name", &self.model)?;
        fields.serialize_field("settings", &self.settings)?;
        if let Some(runs) = &runs {
            fields.serialize_field("runs", runs)?;
        }
        fields.end()
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

/// A vehicle of a world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VehicleSetup {
    /// As the scenario calls it.
    pub name: String,
    /// What drives it.
    pub controller: ModelSetup<ControllerModel>,
    /// How it follows what its controller asks for.
    pub dynamics: ModelSetup<DynamicsModel>,
    /// m
    pub length: f64,
    /// m
    pub width: f64,
    /// Index into [`Road::lanes`].
    pub lane: usize,
    /// Speed of the steady cruise at the start in m/s; also what a controller takes as its wanted speed by default.
    pub speed: f64,
    /// Where it is at time 0.
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
    TimeToArrival {
        /// s
        time: f64,
        /// The part of the vehicle that arrives.
        reference: VehicleReference,
        /// The line's place, m in the world frame.
        x: f64,
    },
}

/// The part of a vehicle that distances and times to arrival are measured from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VehicleReference {
    /// The middle of its length and width.
    #[default]
    Centre,
    /// The middle of its front edge.
    Front,
}

impl VehicleReference {
    /// How far it is ahead of the centre of a vehicle of this length, m.
    pub fn ahead_of_centre(self, length: f64) -> f64 {
        match self {
            Self::Centre => 0.0,
            Self::Front => length / 2.0,
        }
    }
}

/// A pedestrian of a world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PedestrianSetup {
    /// As the scenario calls them.
    pub name: String,
    /// What decides how they walk.
    pub model: ModelSetup<PedestrianModel>,
    /// Their footprint.
    pub shape: Shape,
    /// Where they start, seen across the road.
    pub side: Side,
    /// The centre of their footprint when they appear.
    pub start: Position,
    /// Where they want to go.
    pub goal: Position,
    /// When they enter the world.
    pub appears: Appearance,
    /// How far ahead of the centre of their footprint the point is that they are measured by, m; negative behind it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub reference: f64,
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

/// A pedestrian's footprint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// Looks alike from everywhere.
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
    /// Along the road, m; 0 is the middle of the crossing.
    pub x: f64,
    /// Across the road, m; 0 is the centre of lane 0.
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
    TimeToArrival {
        /// Index into [`World::vehicles`].
        vehicle: usize,
        /// The part of the vehicle that arrives.
        reference: VehicleReference,
        /// s
        time: f64,
    },
    /// At the very moment, also within a step, from which on vehicle `vehicle` would take `time` (s) at the speed that it has until its
    /// front is at `place` (m) of its path.
    Meeting {
        /// Index into [`World::vehicles`].
        vehicle: usize,
        /// s
        time: f64,
        /// m
        place: f64,
    },
}
