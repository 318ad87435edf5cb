//! A straight test track for unit tests of controllers: one vehicle, pedestrians that follow a script.

use nalgebra::Vector2;

use super::{ControllerContext, ControllerModel};
use scenario::{
    Appearance, Direction, MayGo, PedestrianSetup, Position, Road, Settings, Shape, Side, VehicleSetup,
    VehicleStart, World,
};
use sim::fixture::nobody;
use sim::{
    Command, Controller, Dynamics, EgoState, Longitudinal, Mode, Observation, RoadView, SeenPedestrian,
    SeenVehicle,
};

pub const ADULT: Shape = Shape::Rectangle { length: 0.375, width: 0.375 };
pub const CRUISE: f64 = 30.0 / 3.6;

/// What a track tells after each step.
#[derive(Debug, Clone)]
pub struct Sample {
    /// m/s
    pub speed: f64,
    pub command: Command,
    pub mode: Mode,
}

/// Controllers are built for this many.
const MOST_PEDESTRIANS: usize = 4;

type Script = Box<dyn Fn(f64) -> Option<(Vector2<f64>, Vector2<f64>)>>;

/// The vehicle starts at x = 0 in its lane at 30 km/h, unless told otherwise.
pub struct Track {
    pub controller: Box<dyn Controller>,
    dynamics: Box<dyn Dynamics>,
    pub motion: Longitudinal,
    pub observation: Observation,
    scripts: Vec<Script>,
    /// Middle of the crossing, m.
    pub crossing: f64,
    pub step: f64,
    time: f64,
    command: Command,
    decisions: u64,
}

impl Track {
    pub fn new(model: &ControllerModel, settings: Settings, dynamics: &str) -> Self {
        let resolved = model.declaration.resolve(&settings).unwrap();
        let mut all = super::dynamics().into_iter();
        let dynamics = all.find(|one| one.declaration.name == dynamics).unwrap();
        let (length, width) = dynamics.size;
        let mut world = world(length, width);
        world.pedestrians = vec![walker(); MOST_PEDESTRIANS];
        let context = ControllerContext {
            settings: &resolved,
            setup: &world.vehicles[0],
            world: &world,
            rank: 0,
            seed: 1,
        };
        let observation = Observation {
            time: 0.0,
            ego: EgoState {
                distance_to_crossing: 1e6,
                speed: CRUISE,
                acceleration: 0.0,
                length,
                width,
                travelled: -1e6,
                curvature: 0.0,
                lateral_offset: 0.0,
                heading_error: 0.0,
            },
            cruise_speed: CRUISE,
            road: RoadView {
                lane_width: 4.0,
                speed_limit: CRUISE,
                crossing_width: 4.0,
                pedestrian_priority: true,
                signal: None,
                right_kerb: -2.0,
                left_kerb: 6.0,
                gradient: None,
                curvature_ahead: Vec::new(),
                crossings: Vec::new(),
            },
            pedestrians: Vec::new(),
            vehicles: Vec::new(),
        };
        Self {
            controller: (model.build)(&context).unwrap(),
            dynamics: (dynamics.build)(&dynamics.declaration.resolve(&Settings::default()).unwrap()).unwrap(),
            motion: Longitudinal { travelled: 0.0, speed: CRUISE, acceleration: 0.0 },
            observation,
            scripts: Vec::new(),
            crossing: 1e6,
            step: 0.025,
            time: 0.0,
            command: Command::Acceleration(0.0),
            decisions: 0,
        }
    }

    pub fn front(&self) -> f64 {
        self.motion.travelled + self.observation.ego.length / 2.0
    }

    /// Somebody who stands for ever at a place of the track.
    pub fn place_pedestrian(&mut self, x: f64, y: f64) {
        self.script_pedestrian(move |_| Some((Vector2::new(x, y), Vector2::zeros())));
    }

    /// Somebody whose position and velocity on the track is a function of time; `None` while away.
    pub fn script_pedestrian(
        &mut self,
        script: impl Fn(f64) -> Option<(Vector2<f64>, Vector2<f64>)> + 'static,
    ) {
        self.scripts.push(Box::new(script));
    }

    /// What the controller sees now.
    pub fn observe(&mut self) -> &Observation {
        let seen = &mut self.observation;
        seen.time = self.time;
        seen.ego.distance_to_crossing = self.crossing - self.motion.travelled;
        seen.ego.travelled = self.motion.travelled - self.crossing;
        seen.ego.speed = self.motion.speed;
        seen.ego.acceleration = self.motion.acceleration;
        let origin = Vector2::new(self.motion.travelled, 0.0);
        seen.pedestrians.clear();
        seen.pedestrians.extend(self.scripts.iter().enumerate().filter_map(|(id, script)| {
            script(self.time).map(|(position, velocity)| SeenPedestrian {
                kind: Default::default(),
                id,
                position: position - origin,
                velocity,
                acceleration: Vector2::zeros(),
                shape: ADULT,
            })
        }));
        seen
    }

    /// A vehicle ahead, as seen now.
    pub fn see_vehicle(&mut self, x: f64, speed: f64) {
        let (position, velocity) = (Vector2::new(x, 0.0), Vector2::new(speed, 0.0));
        self.observation.vehicles = vec![SeenVehicle { id: 1, position, velocity, length: 4.5, width: 1.8 }];
    }

    pub fn decide(&mut self) -> Command {
        self.observe();
        self.controller.act(&self.observation).expect("built-in controllers can always decide")
    }

    pub fn advance(&mut self) -> Sample {
        if self.time >= self.controller.schedule().moment(self.decisions) - 1e-9 {
            self.command = self.decide();
            self.decisions += 1;
        }
        self.dynamics.advance(&mut self.motion, self.command, self.step);
        self.time += self.step;
        Sample { speed: self.motion.speed, command: self.command, mode: self.controller.mode() }
    }

    /// Drives on for a while (s).
    pub fn drive(&mut self, duration: f64) -> Vec<Sample> {
        (0..(duration / self.step).round() as usize).map(|_| self.advance()).collect()
    }
}

/// A straight road with one lane each way and a vehicle of this size.
pub fn world(length: f64, width: f64) -> World {
    World {
        road: Road::zebra(&[Direction::Forward, Direction::Backward], CRUISE),
        other_roads: Vec::new(),
        vehicles: vec![VehicleSetup {
            name: "av".into(),
            controller: nobody(),
            dynamics: nobody(),
            length,
            width,
            road: 0,
            lane: 0,
            speed: CRUISE,
            initial_speed: None,
            start: VehicleStart::Distance(100.0),
            behind: 0.0,
            sees: None,
            obeys_signals: false,
        }],
        pedestrians: Vec::new(),
        streams: Vec::new(),
        step: 0.025,
        horizon: 60.0,
        finish: 60.0,
        end_on_collision: true,
    }
}

/// Somebody who walks across from the near side.
pub fn walker() -> PedestrianSetup {
    PedestrianSetup {
        kind: Default::default(),
        name: "walker".into(),
        model: nobody(),
        shape: ADULT,
        side: Side::Near,
        start: Position { x: 0.0, y: -4.0 },
        goal: Position { x: 0.0, y: 6.0 },
        follows: None,
        stops: Vec::new(),
        crossing: 0,
        appears: Appearance::At(0.0),
        may_go: MayGo::AtOnce,
        reference: 0.0,
        obeys_signals: false,
    }
}
