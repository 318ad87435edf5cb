//! One pedestrian and one vehicle at a zebra, in the real world loop: the setting of the checks of pedestrian models.
//!
//! Lane 4 m wide, kerbs at -2 m and +6 m, the pedestrian from -4 m to +8 m at x = 0, the vehicle 4.9 m by 2.1 m.

use std::sync::{Arc, LazyLock};

use models::pedestrian::PedestrianContext;
use models::standard;
use scenario::registry::Registry;
use scenario::{
    Appearance, Direction, MayGo, ModelSetup, PedestrianSetup, Position, Reference, Road, Settings, Shape,
    Side, Value, VehicleReference, VehicleSetup, VehicleStart, World,
};
use sim::{
    Command, Controller, ControllerError, Driven, Ending, Mode, Observation, Observer, RoadUsers, Schedule,
    Step, StopReason, simulate,
};

/// The registry, made once: every road user of every run is from it.
static REGISTRY: LazyLock<Registry> = LazyLock::new(standard);

/// 30 km/h
pub const SPEED: f64 = 30.0 / 3.6;
pub const STEPS: [f64; 4] = [0.02, 0.01, 0.04, 0.05];

/// Between two decisions of a car, s.
pub const PERIOD: f64 = 0.02;

/// What drives the vehicle.
#[derive(Clone, Copy)]
pub enum Car {
    Constant,
    /// Brakes at 6 m/s² while its bumper is at most this far (m) from the crossing line and the pedestrian is on its
    /// lane; else regains its speed at 2 m/s².
    Brakes {
        at: f64,
    },
}

impl Controller for Car {
    fn schedule(&self) -> Schedule {
        Schedule::every(PERIOD)
    }

    fn act(&mut self, seen: &Observation) -> Result<Command, ControllerError> {
        let Self::Brakes { at } = *self else { return Ok(Command::Acceleration(0.0)) };
        let bumper = seen.ego.distance_to_crossing - seen.ego.length / 2.0;
        let on_lane = seen.pedestrians.iter().any(|person| person.position.y.abs() <= 2.0);
        Ok(Command::Acceleration(if on_lane && (0.0..=at).contains(&bumper) {
            -6.0
        } else if seen.ego.speed < seen.cruise_speed {
            2.0
        } else {
            0.0
        }))
    }
}

/// A run to be.
#[derive(Clone)]
pub struct Zebra {
    pub model: &'static str,
    pub settings: Settings,
    pub car: Car,
    /// When the front bumper reaches the crossing line at constant speed, s.
    pub arrival: f64,
    /// s
    pub step: f64,
    pub seed: u64,
    pub end_on_collision: bool,
    /// s
    pub horizon: f64,
}

impl Zebra {
    pub fn new(model: &'static str, settings: Settings) -> Self {
        Self {
            model,
            settings,
            car: Car::Constant,
            arrival: 10.0,
            step: 0.02,
            seed: 1,
            end_on_collision: true,
            horizon: 40.0,
        }
    }

    pub fn run(&self) -> Course {
        let world = self.world();
        let declared = REGISTRY.pedestrians().get(self.model).expect("a registered model").clone();
        let settings = declared.declaration.resolve(&self.settings).expect("good settings");
        let setup = &world.pedestrians[0];
        let context =
            PedestrianContext { settings: &settings, setup, world: &world, rank: 0, seed: self.seed };
        let ideal = REGISTRY.dynamics().get("ideal").expect("registered dynamics").clone();
        let users = RoadUsers {
            vehicles: vec![Driven::new(
                Box::new(self.car),
                (ideal.build)(&Settings::default()).expect("ideal dynamics"),
            )],
            pedestrians: vec![(declared.build)(&context).expect("a pedestrian")],
        };
        let mut course = Course { points: Vec::new(), ending: None };
        let ending = simulate(&Arc::new(world), users, &mut course).expect("a car that can decide");
        course.ending = Some(ending);
        course
    }

    fn world(&self) -> World {
        World {
            road: Road::zebra(&[Direction::Forward, Direction::Backward], SPEED),
            other_roads: Vec::new(),
            vehicles: vec![VehicleSetup {
                name: "av".into(),
                controller: none("test"),
                dynamics: none("ideal"),
                length: 4.9,
                width: 2.1,
                road: 0,
                lane: 0,
                speed: SPEED,
                initial_speed: None,
                start: VehicleStart::TimeToArrival {
                    time: self.arrival,
                    reference: VehicleReference::Front,
                    x: 0.0,
                },
                behind: 0.0,
                sees: None,
                obeys_signals: false,
            }],
            pedestrians: vec![PedestrianSetup {
                kind: Default::default(),
                name: "walker".into(),
                model: none(self.model),
                shape: Shape::Disc { radius: 0.3 },
                side: Side::Near,
                start: Position { x: 0.0, y: -4.0 },
                goal: Position { x: 0.0, y: 8.0 },
                follows: None,
                stops: Vec::new(),
                crossing: 0,
                appears: Appearance::At(0.0),
                may_go: MayGo::AtOnce,
                reference: 0.0,
                obeys_signals: false,
            }],
            streams: Vec::new(),
            step: self.step,
            horizon: self.horizon,
            finish: 1e6,
            end_on_collision: self.end_on_collision,
        }
    }
}

/// The states at the beginning of a step, and what the pedestrian decided there.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    pub time: f64,
    pub x: f64,
    pub y: f64,
    /// Speed along y so far, m/s.
    pub velocity: f64,
    /// Decided speed along y, m/s.
    pub speed: f64,
    /// Decided change of velocity per second, m/s².
    pub acceleration: f64,
    pub mode: Mode,
    /// From the vehicle's front bumper to the crossing line, m.
    pub bumper: f64,
    pub car_speed: f64,
}

/// How a run went.
#[derive(Debug)]
pub struct Course {
    pub points: Vec<Point>,
    ending: Option<Ending>,
}

impl Observer for Course {
    fn observe(&mut self, step: &Step) {
        let (person, car) = (&step.before.pedestrians[0], &step.before.vehicles[0]);
        let velocity = step.after.pedestrians[0].velocity;
        self.points.push(Point {
            time: step.time,
            x: person.position.x,
            y: person.position.y,
            velocity: person.velocity.y,
            speed: velocity.y,
            acceleration: (velocity - person.velocity).norm() / step.duration,
            mode: step.pedestrian_modes[0].clone(),
            bumper: car.distance_to(0.0, VehicleReference::Front),
            car_speed: car.motion.speed,
        });
    }
}

impl Course {
    /// When the footprints met, if they did, s. Only runs that end on collision know.
    pub fn collision(&self) -> Option<f64> {
        self.ending.filter(|ending| ending.reason == StopReason::Collision).map(|ending| ending.time)
    }

    /// The first point at which `holds`.
    pub fn first(&self, holds: impl Fn(&Point) -> bool) -> Option<&Point> {
        self.points.iter().find(|point| holds(point))
    }

    /// The first point at which it is in a mode.
    pub fn enters(&self, mode: &str) -> Option<&Point> {
        self.first(|point| point.mode == mode)
    }

    /// The first point from `time` on at which `holds`.
    pub fn after(&self, time: f64, holds: impl Fn(&Point) -> bool) -> Option<&Point> {
        self.first(|point| point.time >= time - 1e-9 && holds(point))
    }

    /// The modes in their order, one for each visit.
    pub fn visits(&self) -> Vec<&str> {
        let mut modes: Vec<_> = self.points.iter().map(|point| point.mode.as_str()).collect();
        modes.dedup();
        modes
    }

    pub fn max(&self, of: impl Fn(&Point) -> f64) -> f64 {
        self.points.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
    }

    /// When (s) and how fast (m/s) it first passes `y`, interpolated within the step.
    pub fn passes(&self, y: f64) -> Option<(f64, f64)> {
        self.points.windows(2).find(|pair| pair[0].y < y && pair[1].y >= y).map(|pair| {
            let part = (y - pair[0].y) / (pair[1].y - pair[0].y);
            let between = |of: fn(&Point) -> f64| of(&pair[0]) + part * (of(&pair[1]) - of(&pair[0]));
            (between(|point| point.time), between(|point| point.velocity))
        })
    }
}

/// The settings of a model.
pub fn settings<const N: usize>(pairs: [(&str, Value); N]) -> Settings {
    Settings::from(pairs)
}

pub fn word(word: &str) -> Value {
    Value::Word(word.into())
}

pub fn number(number: f64) -> Value {
    Value::Number(number)
}

/// The rows of a table of checks; `finish` fails if any does not hold.
#[derive(Default)]
pub struct Checks(Vec<String>);

impl Checks {
    /// `measured` is within `tolerance` of `expected`.
    pub fn near(
        &mut self,
        what: &str,
        step: f64,
        measured: impl Into<Option<f64>>,
        expected: f64,
        tolerance: f64,
    ) {
        let measured = measured.into();
        let good = measured.is_some_and(|measured| (measured - expected).abs() <= tolerance + 1e-9);
        self.row(good, what, step, &format!("expected {expected} +-{tolerance}, measured {measured:.3?}"));
    }

    /// `measured` lies within an inclusive range.
    pub fn within(&mut self, what: &str, step: f64, measured: impl Into<Option<f64>>, low: f64, high: f64) {
        let measured = measured.into();
        let good = measured.is_some_and(|measured| (low - 1e-9..=high + 1e-9).contains(&measured));
        self.row(good, what, step, &format!("expected {low} .. {high}, measured {measured:.3?}"));
    }

    pub fn holds(&mut self, what: &str, step: f64, good: bool) {
        self.row(good, what, step, if good { "holds" } else { "does not hold" });
    }

    fn row(&mut self, good: bool, what: &str, step: f64, finding: &str) {
        println!("{step:4} s  {what}: {finding}");
        if !good {
            self.0.push(format!("at {step} s, {what}: {finding}"));
        }
    }

    pub fn finish(self) {
        assert!(self.0.is_empty(), "\n{}", self.0.join("\n"));
    }
}

/// A model that is given to the run by itself.
fn none<T>(name: &str) -> ModelSetup<T> {
    ModelSetup { model: Reference::unresolved(name), settings: Settings::default() }
}
