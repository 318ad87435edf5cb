//! Registered models and the worlds that they are built for: each names the other.

use std::fmt;
use std::sync::Arc;

use nalgebra::Vector2;
use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

use super::agent::{CommandKind, Controller, Dynamics, ModelError, Pedestrian, Perception, Schedule};
use super::{
    Appearance, Attention, Chance, Declaration, DeclaredProgram, Dimension, MayGo, Parameter, Path, Position,
    Reference, Registered, Road, RoadUserKind, SettingError, Settings, Shape, Side, SignalConduct, Text,
    TrafficStream, VehicleStart,
};

/// What the simulation needs to know of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct World {
    /// Where everybody moves.
    pub road: Road,
    /// Roads that lie over it, on which vehicles drive and nobody walks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other_roads: Vec<Road>,
    /// In the order in which they are declared, which is that of every index of a vehicle.
    pub vehicles: Vec<VehicleSetup>,
    /// Those of them that come one after the other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub streams: Vec<TrafficStream>,
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
    /// Which of the world's roads it drives on: 0 is [`World::road`], and then come [`World::other_roads`].
    #[serde(default, skip_serializing_if = "is_first")]
    pub road: usize,
    /// Index into [`Road::lanes`].
    pub lane: usize,
    /// Speed of the steady cruise in m/s; also what a controller takes as its wanted speed by default.
    pub speed: f64,
    /// Speed at the start in m/s; `None`: that of the cruise, once it has settled.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub initial_speed: Option<f64>,
    /// Where it is at time 0.
    pub start: VehicleStart,
    /// How far the point that follows its lane is behind its centre, m.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub behind: f64,
    /// `None`: perfect perception.
    pub sees: Option<ModelSetup<PerceptionModel>>,
    /// Whether it stops for the red of the crossing's signal; never where there is none.
    #[serde(default, skip_serializing_if = "is_false")]
    pub obeys_signals: bool,
}

impl VehicleSetup {
    /// The speed with which it begins, m/s.
    pub fn speed_at_start(&self) -> f64 {
        self.initial_speed.unwrap_or(self.speed)
    }

    /// The speed by which a start is placed that is said as a time to arrival, m/s: no time is past there, whichever of its speeds is larger.
    pub fn placing_speed(&self) -> f64 {
        self.speed.max(self.speed_at_start())
    }

    /// Whether its controller may steer it off its lane; whoever is in no registry may.
    pub fn may_steer(&self) -> bool {
        self.controller.model.entry().is_none_or(|controller| controller.steers)
    }

    /// Where it drives on a road.
    pub fn path(&self, road: &Road) -> Path {
        road.path(self.lane).followed(self.behind)
    }
}

/// The setting of people who are told where to go by which they keep clear of others.
const KEEPS_CLEAR: &str = "keeps_clear";

/// Who steps onto the road at most this far beside a crossing crosses at it, m.
pub const AT_THE_CROSSING: f64 = 1.0;

/// Whoever moves at less than this sine of the angle (20°) against a lane moves along it and does not cross it.
pub const CROSSES: f64 = 0.34;

/// A pedestrian of a world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PedestrianSetup {
    /// As the scenario calls them.
    pub name: String,
    /// Whether they walk or ride.
    #[serde(default, skip_serializing_if = "RoadUserKind::is_pedestrian")]
    pub kind: RoadUserKind,
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
    /// The course that they follow from their start to their goal who walk along the lane of a road that bends; `None` of who go straight
    /// on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub follows: Option<Path>,
    /// The middles of refuges on which they wait on their way, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stops: Vec<Position>,
    /// The number of the crossing that they use, see [`Road::crossings`].
    #[serde(default, skip_serializing_if = "is_first")]
    pub crossing: usize,
    /// When they enter the world.
    pub appears: Appearance,
    /// When they may go, once they are there.
    #[serde(default, skip_serializing_if = "MayGo::is_at_once")]
    pub may_go: MayGo,
    /// How far ahead of the centre of their footprint the point is that they are measured by, m; negative behind it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub reference: f64,
    /// Whether they wait for their green before they step onto the road; never where no signal stands in their way.
    #[serde(default, skip_serializing_if = "is_false")]
    pub obeys_signals: bool,
}

impl PedestrianSetup {
    /// How far (m) they keep clear of boxes and other people; `None`: they do not.
    pub fn keeps_clear(&self) -> Option<f64> {
        (self.model.model.known()?.keeps_clear)(&self.model.settings)
    }

    /// How much (m) farther than where bodies can meet they have to stand to be able to wait, and the setting that says so; `None`: they can
    /// wait anywhere.
    pub fn keeps_off(&self) -> Option<(&'static str, f64)> {
        let keeps_off = self.model.model.known()?.keeps_off?;
        Some(keeps_off(&self.model.settings))
    }

    /// Whether they step onto the road where a signal of the crossing that they use stands: within [`AT_THE_CROSSING`] of its extent. Who
    /// walks along a lane does not.
    pub fn meets_signal(&self, road: &Road) -> bool {
        let (place, crossing) = road.numbered_crossing(self.crossing);
        if crossing.signal().is_none() || !self.crosses(road) {
            return false;
        }
        let (start, goal) = (Vector2::from(self.start), Vector2::from(self.goal));
        // Who starts on the road is there already.
        let entry = road.kerb_ahead(self.side, start, goal - start).unwrap_or(start);
        (road.along(entry) - place).abs() <= crossing.width / 2.0 + AT_THE_CROSSING
    }

    /// The place (m) of a path at which they meet it; abreast of where they set out if they walk along it or never come to it.
    pub fn met_by(&self, path: &Path) -> f64 {
        match self.follows {
            Some(_) => path.along(self.start.into()),
            None => path.met_by(self.start, self.goal),
        }
    }

    /// Whether their way leads across the lanes of a road; otherwise it leads along them.
    pub fn crosses(&self, road: &Road) -> bool {
        let (ahead, across) = (self.goal.x - self.start.x, self.goal.y - self.start.y);
        // On bends ways lead across the road, but for those that follow it.
        self.follows.is_none()
            && (road.bend.is_some() || ahead == 0.0 || across.abs() >= CROSSES * libm::hypot(ahead, across))
    }
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

fn is_first(number: &usize) -> bool {
    *number == 0
}

fn is_false(flag: &bool) -> bool {
    !flag
}

/// Builds a controller for a run.
pub type BuildController =
    Arc<dyn Fn(&ControllerContext) -> Result<Box<dyn Controller>, ModelError> + Send + Sync>;

/// Builds the dynamics of a vehicle, from settings that are resolved against their declaration.
pub type BuildDynamics = Arc<dyn Fn(&Settings) -> Result<Box<dyn Dynamics>, ModelError> + Send + Sync>;

/// Builds a pedestrian for a run.
pub type BuildPedestrian =
    Arc<dyn Fn(&PedestrianContext) -> Result<Box<dyn Pedestrian>, ModelError> + Send + Sync>;

/// Builds the perception that settings describe (resolved against its declaration) for a controller that decides at the
/// moments of a schedule.
pub type BuildPerception = Arc<
    dyn Fn(&Settings, &ControllerContext, Schedule) -> Result<Box<dyn Perception>, ModelError> + Send + Sync,
>;

/// A registered controller.
pub struct ControllerModel {
    /// Its name and parameters, for checker, pages and tunes.
    pub declaration: Declaration,
    /// The dynamics of a vehicle that declares none. A registry resolves it when it takes the controller in.
    pub default_dynamics: Reference<DynamicsModel>,
    /// What its vehicle's dynamics must take.
    pub gives: CommandKind,
    /// Whether it draws.
    pub chance: Chance,
    /// What it does about the signal of a crossing.
    pub signals: SignalConduct,
    /// What else it looks at.
    pub attention: Attention,
    /// Whether it may answer a curvature.
    pub steers: bool,
    /// Makes one for a run.
    pub build: BuildController,
    /// The program that decides, of one that was declared in a file: it is not built, but asked.
    pub program: Option<Arc<DeclaredProgram>>,
}

/// What a controller is built from.
#[derive(Clone, Copy)]
pub struct ControllerContext<'a> {
    /// Resolved against the controller's declaration.
    pub settings: &'a Settings,
    /// The vehicle that it drives.
    pub setup: &'a VehicleSetup,
    /// Everything else of the run.
    pub world: &'a World,
    /// The vehicle's place among the names of its kind, by which it draws.
    pub rank: usize,
    /// The run's seed, for `sim::random::stream`.
    pub seed: u64,
}

impl ControllerModel {
    /// One that may draw, for vehicles that follow accelerations exactly or, given pedals, are a car between the
    /// measured ones.
    pub fn new(
        declaration: Declaration,
        gives: CommandKind,
        build: impl Fn(&ControllerContext) -> Result<Box<dyn Controller>, ModelError> + Send + Sync + 'static,
    ) -> Self {
        let dynamics = match gives {
            CommandKind::Acceleration => "ideal",
            CommandKind::Pedals => "generic",
        };
        Self {
            declaration,
            default_dynamics: Reference::unresolved(dynamics),
            gives,
            chance: Chance::Always,
            signals: SignalConduct::Own,
            attention: Attention::Own,
            steers: false,
            build: Arc::new(build),
            program: None,
        }
    }

    /// One that a program is asked for. It is told a seed and nobody knows whether it draws from it, so it is taken to.
    pub fn of_program(declaration: Declaration, program: DeclaredProgram) -> Self {
        let refusal = "it is a program, which is asked and not built";
        Self {
            program: Some(Arc::new(program.clone())),
            steers: true,
            ..Self::new(declaration, program.gives.command(), move |_| Err(ModelError::new(refusal)))
        }
    }

    /// The same, with other dynamics for vehicles that declare none.
    pub fn driving(self, dynamics: &str) -> Self {
        Self { default_dynamics: Reference::unresolved(dynamics), ..self }
    }

    /// With what is known of whether it draws; [`Self::new`] takes it that it always may.
    pub fn chance(self, chance: Chance) -> Self {
        Self { chance, ..self }
    }

    /// One that may [steer](Controller::curvature); [`Self::new`] takes it that it does not. A program may.
    pub fn steering(self) -> Self {
        Self { steers: true, ..self }
    }

    /// With what it does about the signal of a crossing; [`Self::new`] takes it that it decides by itself. One that obeys finds in
    /// [`VehicleSetup::obeys_signals`] whether it is to.
    pub fn signals(self, signals: SignalConduct) -> Self {
        Self { signals, ..self }
    }

    /// With what it looks at besides signals, of which `check` warns where it is blind to what is there; [`Self::new`] takes it that it
    /// decides by itself.
    pub fn attention(self, attention: Attention) -> Self {
        Self { attention, ..self }
    }
}

/// Registered longitudinal dynamics.
pub struct DynamicsModel {
    /// Their name and parameters, for checker, pages and tunes.
    pub declaration: Declaration,
    /// The kinds of commands that they follow.
    pub takes: Vec<CommandKind>,
    /// Length and width of the vehicle it describes, m.
    pub size: (f64, f64),
    /// Makes them for a run, from settings that are resolved against the declaration.
    pub build: BuildDynamics,
}

impl DynamicsModel {
    /// `size` is length and width of the vehicle, m.
    pub fn new(
        declaration: Declaration,
        takes: &[CommandKind],
        size: (f64, f64),
        build: impl Fn(&Settings) -> Result<Box<dyn Dynamics>, ModelError> + Send + Sync + 'static,
    ) -> Self {
        Self { declaration, takes: takes.to_vec(), size, build: Arc::new(build) }
    }
}

/// A registered perception: what stands between the world and a controller.
pub struct PerceptionModel {
    /// Its name and parameters, for checker and pages.
    pub declaration: Declaration,
    /// Whether it draws.
    pub chance: Chance,
    /// Makes one for a vehicle's controller in a run.
    pub build: BuildPerception,
}

/// The setting that says how far from where bodies can meet a pedestrian waits, and how far (m) that is.
pub type KeepsOff = fn(&Settings) -> (&'static str, f64);

/// A registered pedestrian model.
pub struct PedestrianModel {
    /// Its name and parameters, for checker, pages and tunes.
    pub declaration: Declaration,
    /// Whether its parameter sets may come from a population of individuals.
    pub takes_individuals: bool,
    /// Over which ranges (SI units, above 0) parameter sets of people lie, with these settings; empty where that is not known.
    pub individual_ranges: fn(&Settings) -> Vec<(Text, f64, f64)>,
    /// Whether it draws.
    pub chance: Chance,
    /// Whether with these settings it walks the same whatever others do, so that it is known beforehand when it will be where.
    pub is_fixed: fn(&Settings) -> bool,
    /// How far (m) with these settings it keeps clear of boxes and other people, whatever it wants; `None`: it goes where it is told to.
    pub keeps_clear: fn(&Settings) -> Option<f64>,
    /// Nearer than this (m) to where the bodies of a vehicle and itself can meet it cannot wait with these settings, and the setting that says
    /// so; `None`: it can wait anywhere.
    pub keeps_off: Option<KeepsOff>,
    /// What it makes of the time for which it looks before it may go.
    pub look: LookEffect,
    /// Whether it can wait on refuges: on each leg of its way it minds only whom it meets before the leg's end.
    pub walks_in_legs: bool,
    /// What it does about the signal of a crossing. Nobody who obeys steps onto the road without green, whatever their model wants.
    pub signals: SignalConduct,
    /// Makes one for a run.
    pub build: BuildPedestrian,
}

/// What a pedestrian model makes of the time for which it looks before it may go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LookEffect {
    /// It decides by what is there at the moment: a look only lets it go later.
    Delays,
    /// What it sees counts: its first decision uses what it saw.
    Counts,
}

/// What a pedestrian model is built from.
#[derive(Clone, Copy)]
pub struct PedestrianContext<'a> {
    /// Resolved against the model's declaration.
    pub settings: &'a Settings,
    /// The pedestrian who it is.
    pub setup: &'a PedestrianSetup,
    /// Everything else of the run.
    pub world: &'a World,
    /// The pedestrian's place among the names of its kind, by which it draws.
    pub rank: usize,
    /// The run's seed, for `sim::random::stream`.
    pub seed: u64,
}

impl PedestrianModel {
    /// One that may draw and knows no individuals.
    pub fn new(
        declaration: Declaration,
        build: impl Fn(&PedestrianContext) -> Result<Box<dyn Pedestrian>, ModelError> + Send + Sync + 'static,
    ) -> Self {
        Self {
            declaration,
            takes_individuals: false,
            individual_ranges: |_| Vec::new(),
            chance: Chance::Always,
            is_fixed: |_| false,
            keeps_clear: |_| Some(0.0),
            keeps_off: None,
            look: LookEffect::Delays,
            walks_in_legs: false,
            signals: SignalConduct::Obeys,
            build: Arc::new(build),
        }
    }

    /// The same, whose parameter sets may come from a population of individuals.
    pub fn with_individuals(self) -> Self {
        Self { takes_individuals: true, ..self }
    }

    /// The same, which cannot wait nearer than so much (m) to where bodies can meet; [`Self::new`] takes it that it can wait anywhere.
    pub fn keeping_off(self, keeps_off: KeepsOff) -> Self {
        Self { keeps_off: Some(keeps_off), ..self }
    }

    /// The same, for which it counts what it has seen before it may go; [`Self::new`] takes it that a look only lets it go later.
    pub fn believing(self) -> Self {
        Self { look: LookEffect::Counts, ..self }
    }

    /// The same, which can wait on refuges, see [`Pedestrian::begin_leg`].
    pub fn in_legs(self) -> Self {
        Self { walks_in_legs: true, ..self }
    }

    /// The same, with the ranges over which parameter sets of people lie.
    pub fn ranging(self, individual_ranges: fn(&Settings) -> Vec<(Text, f64, f64)>) -> Self {
        Self { individual_ranges, ..self }
    }

    /// With what is known of whether it draws; [`Self::new`] takes it that it always may.
    pub fn chance(self, chance: Chance) -> Self {
        Self { chance, ..self }
    }

    /// With what it does about the signal of a crossing; [`Self::new`] takes it that it obeys.
    pub fn signals(self, signals: SignalConduct) -> Self {
        Self { signals, ..self }
    }

    /// With what is known of whether it minds others; [`Self::new`] takes it that it does.
    pub fn fixed(self, is_fixed: fn(&Settings) -> bool) -> Self {
        Self { is_fixed, ..self }
    }

    /// The same, which goes where it is told to unless its setting `keeps_clear` says how far (m) it keeps from boxes and other people.
    pub fn told_where_to_go(mut self) -> Self {
        self.declaration = self.declaration.with(Parameter::optional(
            KEEPS_CLEAR,
            Dimension::LENGTH,
            (0.0, 1.0),
            "Distance that it keeps from boxes and other people whatever it is told, evading to its right; without it, it goes where it is told.",
            "free choice",
        ));
        Self { keeps_clear: |settings| settings.optional_number(KEEPS_CLEAR), ..self }
    }
}

macro_rules! registered {
    ($($model:ty $({ $runs:item })?),*) => {$(
        impl Registered for $model {
            fn declaration(&self) -> &Declaration {
                &self.declaration
            }
            $($runs)?
        }

        impl fmt::Debug for $model {
            fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.declaration.fmt(out)
            }
        }
    )*};
}

registered!(
    ControllerModel {
        fn runs(&self) -> Option<String> {
            self.program.as_ref().map(|program| program.identity())
        }
    },
    DynamicsModel,
    PerceptionModel,
    PedestrianModel
);
