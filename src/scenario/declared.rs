//! What a user declared: suites and scenarios whose values may still depend on variations.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use files::hexadecimal;

use super::{
    Calibrate, ControllerModel, Criterion, DeclaredBend, DeclaredDraw, DeclaredGround, DeclaredOtherRoad,
    DeclaredSignal, DeclaredStream, Distribution, DynamicsModel, Estimate, Evaluate, EvaluationError,
    Expression, Gate, Individuals, MetricReference, Notation, Origin, PedestrianModel, PerceptionModel,
    PopulationShare, Rating, Reference, Road, RoadUserKind, Search, Side, Statement, TrafficStream, Tune,
    Value, VariedValue, VehicleReference, Written,
};

/// A suite: scenarios and what holds for all of them. A bare `.scn` file becomes a suite named after the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Suite {
    /// As it calls itself; a suite of a bare file is called after the file.
    pub name: String,
    /// What stands before its name in keys, where another suite of that name is in the same invocation: `a/`. Seeds are derived from keys
    /// without it, so that runs are the same whatever else is run.
    #[serde(skip)]
    pub apart: String,
    /// What it says of itself, in a sentence.
    pub doc: Option<String>,
    /// What the seed of every run is derived from.
    pub seed: u64,
    /// What was set from outside and is not as the files say: `av.speed=40km/h`, sorted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// Controllers in the place of those that its scenarios name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tested: Vec<TestedInstead>,
    /// Wall-clock limit per trial in s.
    pub time_limit: Option<f64>,
    /// In the order of files and of declaration within a file; names are unique.
    pub scenarios: Vec<Scenario>,
    /// Known to the blocks below, but not run by themselves, by name; names are unique together with those above.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub supporting: Vec<Scenario>,
    /// In the order in which they are declared.
    #[serde(default)]
    pub searches: Vec<Search>,
    /// In the order in which they are declared.
    #[serde(default)]
    pub tunes: Vec<Tune>,
    /// In the order in which they are declared.
    #[serde(default)]
    pub evaluates: Vec<Evaluate>,
    /// In the order in which they are declared.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub calibrates: Vec<Calibrate>,
    /// In the order in which they are declared.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub estimates: Vec<Estimate>,
    /// In the order in which they are declared.
    #[serde(default)]
    pub statements: Vec<Statement>,
    /// In the order in which they are declared.
    #[serde(default)]
    pub gates: Vec<Gate>,
    /// In the order in which they are declared.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ratings: Vec<Rating>,
    /// Those that its files declare, by name: programs that decide.
    #[serde(skip)]
    pub controllers: Vec<Reference<ControllerModel>>,
    /// The unit in which it compares a metric to something, the first where there are several; metrics that it compares in SI
    /// units are not there. For messages and reports only.
    #[serde(skip)]
    pub notations: Vec<(MetricReference, Notation)>,
    /// What it was read from, by name: whoever shows results tells by that whether they are of the texts of today.
    #[serde(skip)]
    pub texts: Vec<TextDigest>,
    /// Where it is declared.
    pub origin: Origin,
}

/// A file as it was when a suite was read from it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TextDigest {
    /// As it was named.
    pub file: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}

/// By which bytes are known: their SHA-256 in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

impl Suite {
    /// What its keys begin with.
    pub fn key_name(&self) -> String {
        format!("{}{}", self.apart, self.name)
    }

    /// One of its keys as it is where no other suite has its name: what seeds are derived from.
    pub fn own_key<'k>(&self, key: &'k str) -> &'k str {
        key.strip_prefix(self.apart.as_str()).unwrap_or(key)
    }

    /// The unit in which people are shown a metric; `None`: the SI unit.
    pub fn notation(&self, label: &str) -> Option<Notation> {
        self.notations.iter().find(|(metric, _)| metric.label() == label).map(|(_, notation)| *notation)
    }

    /// One of its scenarios, or of those that only its blocks know.
    pub fn scenario(&self, name: &str) -> Option<&Scenario> {
        self.scenarios.iter().chain(&self.supporting).find(|scenario| scenario.name == name)
    }
}

/// A controller in the place of those that scenarios name for every vehicle of a name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TestedInstead {
    /// The name of the vehicles.
    pub vehicle: String,
    /// With its settings: `my_av { braking_distance: 8 m }`.
    pub controller: String,
    /// The controllers that the scenarios name, each once.
    pub instead_of: Vec<String>,
    /// In how many scenarios of how many there is such a vehicle, if not in all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub partly: Option<(usize, usize)>,
}

impl fmt::Display for TestedInstead {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { vehicle, controller, instead_of, partly } = self;
        write!(out, "{vehicle}: {controller} instead of {}", instead_of.join(", "))?;
        partly.map_or(Ok(()), |(scenarios, all)| write!(out, " in {scenarios} of {all} scenarios"))
    }
}

/// A scenario as it is declared: the trials that it stands for come from its variations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scenario {
    /// As files and keys call it.
    pub name: String,
    /// What it says of itself, in a sentence.
    pub doc: Option<String>,
    /// What filters may select it by.
    pub tags: Vec<String>,
    /// Where everybody moves, straight, with its boxes along it and its ground unsaid.
    pub road: Road,
    /// How that road bends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bend: Option<DeclaredBend>,
    /// How steep it is and how well tyres hold on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground: Option<DeclaredGround>,
    /// Where the road's other crossings are, in their order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other_crossings: Vec<DeclaredPlace>,
    /// What of its crossing's signal depends on variations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signal: Option<DeclaredSignal>,
    /// Roads that lie over its road, on which some of its vehicles drive, in the order in which these say so.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other_roads: Vec<DeclaredOtherRoad>,
    /// In order; their names and those of pedestrians are all different.
    pub vehicles: Vec<Vehicle>,
    /// In order.
    pub pedestrians: Vec<DeclaredPedestrian>,
    /// Crossed with each other in order; the last varies fastest.
    pub variations: Vec<Variation>,
    /// What every run draws, in order: what one depends on stands before it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub draws: Vec<DeclaredDraw>,
    /// Runs per variation and individual, at least 1; not said where `runs` is.
    pub repeat: u32,
    /// `None`: as many runs as `repeat` makes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub runs: Option<RunBudget>,
    /// Of the first run of each trial and person itself; `None`: made from the suite's, as those of all other runs are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Including those that the suite adds.
    pub criteria: Vec<Criterion>,
    /// Simulation step in s.
    pub step: f64,
    /// Simulated time after which a run ends, in s.
    pub horizon: f64,
    /// Distance of the finish line behind the crossing's middle in m.
    pub finish: f64,
    /// Whether a collision ends a run.
    pub end_on_collision: bool,
    /// How its numbers were written, by name: `av.speed`, `av.controller.braking_distance`, `tta`. For messages only.
    #[serde(skip)]
    pub written: BTreeMap<String, Written>,
    /// Where it is declared.
    pub origin: Origin,
}

impl Scenario {
    /// What declares a vehicle of this name, which may be one of a stream.
    pub fn vehicle(&self, name: &str) -> Option<&Vehicle> {
        let stream = TrafficStream::of_member(name);
        let declares = |car: &&Vehicle| match car.start {
            DeclaredVehicleStart::Stream(_) => stream.is_some_and(|(stream, _)| stream == car.name),
            _ => car.name == name,
        };
        self.vehicles.iter().find(declares)
    }

    /// Its streams, each as what declares all of its vehicles.
    pub fn streams(&self) -> impl Iterator<Item = &Vehicle> {
        self.vehicles.iter().filter(|car| matches!(car.start, DeclaredVehicleStart::Stream(_)))
    }

    /// Whether its runs differ in what they draw: values, or people.
    pub fn is_drawn(&self) -> bool {
        !self.draws.is_empty() || self.draws_people()
    }

    /// Whether every run is of somebody else, drawn from a population.
    pub fn draws_people(&self) -> bool {
        let drawn = |individuals: &Individuals| individuals.selection == PopulationShare::Drawn;
        self.pedestrians.iter().any(|person| person.individuals.as_ref().is_some_and(drawn))
    }
}

/// Where a crossing is that is not the origin of all places.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeclaredPlace {
    /// Along a straight road from the middle of the first crossing, on a path from its beginning, m.
    pub at: Expression,
    /// Where it is written.
    pub origin: Origin,
}

/// `runs 50 .. 2000`: the runs of a trial are added until its criteria are decided.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunBudget {
    /// At least 1.
    pub least: u32,
    /// At least `least`.
    pub most: u32,
    /// Where it is written.
    pub origin: Origin,
}

/// A model, controller, dynamics or perception with the settings that were given.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Model<T> {
    /// With [`Self::varied_by`], the first of those that it takes.
    #[serde(rename = "name")]
    pub first: Reference<T>,
    /// The variation whose words replace the name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub varied_by: Option<String>,
    /// What the words of that variation stand for; empty without one.
    #[serde(skip)]
    pub varied: Vec<Reference<T>>,
    /// What else it may be where a search or a saved case gives that variation words of its own; empty without one.
    #[serde(skip)]
    pub others: Vec<Reference<T>>,
    /// Those that were given, by name, SI units.
    pub settings: Vec<(String, Expression)>,
    /// Where it is written.
    pub origin: Origin,
}

/// A vehicle as it is declared, or all vehicles of a stream.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Vehicle {
    /// As the scenario calls it.
    pub name: String,
    /// What drives it, or what a variation puts there.
    pub controller: Model<ControllerModel>,
    /// `None`: the controller's default dynamics.
    pub dynamics: Option<Model<DynamicsModel>>,
    /// Length and width in m; `None`: those of the dynamics.
    pub size: Option<(Expression, Expression)>,
    /// Speed of the steady cruise in m/s.
    pub speed: Expression,
    /// Speed at the start in m/s; `None`: that of the cruise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub initial_speed: Option<Expression>,
    /// Where it is at time 0.
    pub start: DeclaredVehicleStart,
    /// The name of the road that it drives on, where that lies over the scenario's own; `None`: on that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub road: Option<String>,
    /// Index into [`Road::lanes`].
    pub lane: usize,
    /// Which point of it follows its lane.
    #[serde(default, skip_serializing_if = "DeclaredFollowing::is_centre")]
    pub follows: DeclaredFollowing,
    /// `sees { … }`: what the controller's perception leaves out; `None` is perfect perception.
    pub sees: Option<Model<PerceptionModel>>,
    /// Whether it stops for a signal's red; `None`: as its controller does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub obeys_signals: Option<bool>,
    /// Whether it is meant that its controller is blind to other vehicles.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub ignores_vehicles: bool,
    /// Where it is declared.
    pub origin: Origin,
}

/// Which point of a vehicle follows its lane, whose direction the vehicle has.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DeclaredFollowing {
    /// The middle of its length.
    #[default]
    Centre,
    /// Its rear axle, [`REAR_AXLE`] of its length behind the centre.
    RearAxle,
    /// A point so far behind its centre, m.
    Behind(Expression),
}

impl DeclaredFollowing {
    fn is_centre(&self) -> bool {
        *self == Self::Centre
    }
}

/// How far the rear axle of a vehicle of which nothing is said is behind its centre, as a share of its length.
pub const REAR_AXLE: f64 = 0.3;

/// Where a vehicle starts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DeclaredVehicleStart {
    /// As far out as the earliest pedestrian that waits for a time to arrival needs it.
    Automatic,
    /// Centre this far before the middle of the crossing, m.
    Distance(Expression),
    /// At this time to arrival (of the centre at the middle of the crossing), s.
    TimeToArrival(Expression),
    /// It stands for many that come one after the other.
    Stream(DeclaredStream),
}

/// A pedestrian as they are declared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeclaredPedestrian {
    /// As the scenario calls them.
    pub name: String,
    /// Whether they walk or ride.
    #[serde(default, skip_serializing_if = "RoadUserKind::is_pedestrian")]
    pub kind: RoadUserKind,
    /// What decides how they walk, or what a variation puts there.
    pub model: Model<PedestrianModel>,
    /// `None`: that of their kind.
    pub shape: Option<DeclaredShape>,
    /// The side of the road that they start from.
    pub side: Side,
    /// Distance of the start from the centre of lane 0 (near) or of the last lane (far), m.
    pub start_from_lane_centre: Expression,
    /// The name of the crossing that they use; `None`: the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crosses: Option<String>,
    /// Whether they wait on every refuge of their way.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub waits_on_refuges: bool,
    /// Place along the road in m; 0 is the middle of the crossing that they use.
    pub along: Expression,
    /// Distance of the goal beyond the opposite kerb in m.
    pub goal_beyond_kerb: Expression,
    /// How far their way is turned to their left from straight across the road, about the point where it meets the centre of the first
    /// lane, rad.
    #[serde(default = "straight_across", skip_serializing_if = "is_straight_across")]
    pub turned: Expression,
    /// That they walk along the lane that they start in; `None`: across the road.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub walks: Option<WalksAlong>,
    /// When they enter the world.
    pub appears: DeclaredAppearance,
    /// When they may go, once they are there.
    #[serde(default, skip_serializing_if = "DeclaredMayGo::is_at_once")]
    pub may_go: DeclaredMayGo,
    /// Whether it is meant that they may start where waiting is not an option for their model.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub may_start_inside: bool,
    /// How far ahead of the centre of their footprint the point is that they are measured by, m.
    pub reference: Expression,
    /// `None`: the parameters that the model's settings say.
    pub individuals: Option<Individuals>,
    /// Whether they wait for a signal's green; `None`: as their model does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub obeys_signals: Option<bool>,
    /// `None`: of no group.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<Membership>,
    /// Where they are declared.
    pub origin: Origin,
}

fn straight_across() -> Expression {
    Expression::number(0.0)
}

fn is_straight_across(turned: &Expression) -> bool {
    *turned == straight_across()
}

/// That somebody walks along the lane that is outermost on their side, as far beside its centre as they start from it or as whom they are
/// to meet makes it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WalksAlong {
    /// In the direction of that lane's traffic, not against it.
    pub with_traffic: bool,
    /// How far from their start their goal is, m.
    pub further: Expression,
}

/// That somebody is one of a group: `pedestrian walkers times 5 { … }`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Membership {
    /// As the scenario calls the group.
    pub group: String,
    /// From 0.
    pub index: u32,
    /// How many members the group has.
    pub size: u32,
}

impl Membership {
    /// What the scenario calls them: `walkers_1` is the first of `walkers`.
    pub fn member_name(&self) -> String {
        format!("{}_{}", self.group, self.index + 1)
    }

    /// The groups among people, in order, each with the names of its members.
    pub fn groups<'a>(
        people: impl IntoIterator<Item = (&'a str, Option<&'a Self>)>,
    ) -> Vec<(&'a str, Vec<&'a str>)> {
        let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
        for (name, membership) in people {
            let Some(membership) = membership else { continue };
            match groups.iter_mut().find(|(group, _)| *group == membership.group) {
                Some((_, members)) if members.contains(&name) => {}
                Some((_, members)) => members.push(name),
                None => groups.push((&membership.group, vec![name])),
            }
        }
        groups
    }
}

/// A pedestrian's footprint, m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DeclaredShape {
    /// Looks alike from everywhere.
    Disc {
        /// m
        radius: Expression,
    },
    /// Turns with the pedestrian's heading.
    Rectangle {
        /// Along the heading, m.
        length: Expression,
        /// Across the heading, m.
        width: Expression,
    },
}

/// When a pedestrian enters the world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DeclaredAppearance {
    /// At a time in s.
    At(Expression),
    /// When a vehicle's time to arrival at the crossing has fallen to this, s.
    TimeToArrival {
        /// Its name.
        vehicle: String,
        /// The part of the vehicle that arrives.
        reference: VehicleReference,
        /// s
        time: Expression,
    },
    /// So that a vehicle that keeps its speed hits them at this share of its width, from the side that they come from.
    Meets {
        /// Its name.
        vehicle: String,
        /// 0 to 1
        share: Expression,
        /// How far they have walked by then, m: of somebody who walks along a lane, who could be met anywhere on it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        after: Option<Expression>,
    },
}

/// When a pedestrian that is there may go.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DeclaredMayGo {
    /// As soon as it appears.
    #[default]
    AtOnce,
    /// So long after it has appeared, s: it looks.
    After(Expression),
    /// When a vehicle's time to arrival has fallen to `time`, or so long after it has appeared.
    TimeToArrival {
        /// Its name.
        vehicle: String,
        /// The part of the vehicle that arrives.
        reference: VehicleReference,
        /// s
        time: Expression,
        /// s
        or_after: Expression,
    },
}

impl DeclaredMayGo {
    fn is_at_once(&self) -> bool {
        *self == Self::AtOnce
    }
}

impl DeclaredPedestrian {
    /// The vehicles whose arrival they await, to appear or to go.
    pub fn awaits(&self) -> impl Iterator<Item = &str> {
        let to_go = match &self.may_go {
            DeclaredMayGo::TimeToArrival { vehicle, .. } => Some(vehicle.as_str()),
            DeclaredMayGo::AtOnce | DeclaredMayGo::After(_) => None,
        };
        self.appears.awaits().into_iter().chain(to_go)
    }

    /// Whether a name is theirs, or that of their group.
    pub fn is(&self, name: &str) -> bool {
        self.name == name || self.group.as_ref().is_some_and(|membership| membership.group == name)
    }
}

impl DeclaredAppearance {
    /// The vehicle that it depends on.
    pub fn awaits(&self) -> Option<&str> {
        match self {
            Self::At(_) => None,
            Self::TimeToArrival { vehicle, .. } | Self::Meets { vehicle, .. } => Some(vehicle),
        }
    }
}

/// One `vary` line (or a `vary together` block, whose names move in step).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Variation {
    /// Each row holds one value per name.
    Grid {
        /// Of the variations that move in step; one for a single `vary`.
        names: Vec<String>,
        /// In the order in which trials come.
        rows: Vec<Vec<VariedValue>>,
    },
    /// Values drawn per row by the suite's seed.
    Sampled {
        /// Of the variations that are drawn together.
        names: Vec<String>,
        /// How they are drawn.
        samples: Samples,
    },
}

/// How a sampled variation draws; one distribution per name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Samples {
    /// Rows, at least 1.
    pub count: u32,
    /// How rows spread over the distributions.
    pub scheme: SamplingScheme,
    /// In the order of the names; numbers may depend on names before.
    pub distributions: Vec<Distribution>,
    /// SI unit shown in labels, one per name.
    pub units: Vec<String>,
}

/// How rows of values are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SamplingScheme {
    /// Independently of each other.
    Random,
    /// Each name's distribution is cut into as many equally likely parts as there are rows, and each part has one.
    LatinHypercube,
    /// Scrambled Sobol points, which fill the space evenly.
    Sobol,
}

impl<T> Model<T> {
    /// What it is where variations have the values `variables`.
    ///
    /// # Errors
    /// If the variation that decides has no value there, or none that is a word.
    pub fn chosen(&self, variables: &BTreeMap<String, Value>) -> Result<Reference<T>, EvaluationError> {
        let Some(variation) = &self.varied_by else { return Ok(self.first.clone()) };
        match variables.get(variation) {
            Some(Value::Word(word)) => {
                let known = self.varied.iter().chain(&self.others).find(|one| one.name() == word);
                Ok(known.cloned().unwrap_or_else(|| Reference::unresolved(word.as_str())))
            }
            Some(other) => Err(EvaluationError::NotAWord(other.to_string())),
            None => Err(EvaluationError::Unbound(variation.clone())),
        }
    }

    /// Everything that the scenario says it is in some run.
    pub fn all(&self) -> &[Reference<T>] {
        if self.varied_by.is_some() { &self.varied } else { std::slice::from_ref(&self.first) }
    }
}

impl<T> Clone for Model<T> {
    fn clone(&self) -> Self {
        let Self { first, varied_by, varied, others, settings, origin } = self;
        Self {
            first: first.clone(),
            varied_by: varied_by.clone(),
            varied: varied.clone(),
            others: others.clone(),
            settings: settings.clone(),
            origin: origin.clone(),
        }
    }
}

impl<T> PartialEq for Model<T> {
    fn eq(&self, other: &Self) -> bool {
        let Self { first, varied_by, varied, others, settings, origin } = self;
        *first == other.first
            && *varied_by == other.varied_by
            && *varied == other.varied
            && *others == other.others
            && *settings == other.settings
            && *origin == other.origin
    }
}

impl<T> fmt::Debug for Model<T> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { first, varied_by, varied, others, settings, origin } = self;
        out.debug_struct("Model")
            .field("name", first)
            .field("varied_by", varied_by)
            .field("varied", varied)
            .field("others", others)
            .field("settings", settings)
            .field("origin", origin)
            .finish()
    }
}

impl Variation {
    /// The values that one of its names takes; `None` if it does not vary the name, or draws it from a range.
    pub fn values_of(&self, name: &str) -> Option<Vec<&Value>> {
        let index = self.names().iter().position(|varied| varied == name)?;
        match self {
            Self::Grid { rows, .. } => Some(rows.iter().map(|row| &row[index].value).collect()),
            Self::Sampled { samples, .. } => {
                let options = samples.distributions[index].options()?;
                Some(options.iter().map(|option| &option.value).collect())
            }
        }
    }

    /// The names of other variations, or of earlier ones within it, that its values depend on.
    pub fn depends_on(&self) -> Vec<&str> {
        match self {
            Self::Grid { .. } => Vec::new(),
            Self::Sampled { samples, .. } => {
                samples.distributions.iter().flat_map(Distribution::variables).collect()
            }
        }
    }

    /// What it varies.
    pub fn names(&self) -> &[String] {
        match self {
            Self::Grid { names, .. } | Self::Sampled { names, .. } => names,
        }
    }
}
