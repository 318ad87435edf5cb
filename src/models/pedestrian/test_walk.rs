//! A zebra for unit tests of pedestrian models: one pedestrian, vehicles that keep their speed.

use nalgebra::Vector2;

use super::{PedestrianContext, PedestrianModel};
use scenario::{
    Appearance, Direction, MayGo, Path, PedestrianSetup, Position, Road, Settings, Shape, Side, World,
};
use sim::fixture::nobody;
use sim::{Longitudinal, ModelError, Motion, Pedestrian, PedestrianState, Scene, VehicleState};

/// One pedestrian from 4 m before the lane's centre to 6 m behind it, near kerb at -2 m.
pub struct Walk {
    pub pedestrian: Box<dyn Pedestrian>,
    pub vehicles: Vec<VehicleState>,
    states: Vec<PedestrianState>,
    pub world: World,
    pub time: f64,
    pub step: f64,
}

impl Walk {
    pub fn new(model: &PedestrianModel, settings: Settings) -> Self {
        Self::try_new(model, settings).unwrap()
    }

    pub fn try_new(model: &PedestrianModel, settings: Settings) -> Result<Self, ModelError> {
        Self::seeded(model, settings, 1)
    }

    pub fn seeded(model: &PedestrianModel, settings: Settings, seed: u64) -> Result<Self, ModelError> {
        let world = world();
        let pedestrian = build(model, &settings, &world, seed)?;
        let setup = &world.pedestrians[0];
        let state = PedestrianState {
            position: Vector2::new(setup.start.x, setup.start.y),
            velocity: Vector2::zeros(),
            acceleration: Vector2::zeros(),
            heading: Vector2::y(),
            shape: setup.shape,
            present: true,
        };
        Ok(Self { pedestrian, vehicles: Vec::new(), states: vec![state], world, time: 0.0, step: 0.025 })
    }

    /// Another pedestrian in the same place, for worlds that were changed.
    pub fn rebuild(&mut self, model: &PedestrianModel, settings: Settings) -> Result<(), ModelError> {
        self.pedestrian = build(model, &settings, &self.world, 1)?;
        Ok(())
    }

    /// A car 4.514 m long and 2.007 m wide with its centre at x, at a speed.
    pub fn add_car(&mut self, x: f64, speed: f64) {
        self.vehicles.push(VehicleState::new(
            Path::straight(0.0, Direction::Forward),
            Longitudinal { travelled: x, speed, acceleration: 0.0 },
            (4.514, 2.007),
        ));
    }

    /// Somebody else, whom nothing moves.
    pub fn add_person(&mut self, position: Vector2<f64>, velocity: Vector2<f64>) {
        self.states.push(PedestrianState { position, velocity, ..self.states[0] });
    }

    pub fn position(&self) -> Vector2<f64> {
        self.states[0].position
    }

    pub fn state(&mut self) -> &mut PedestrianState {
        &mut self.states[0]
    }

    pub fn step(&mut self) -> Motion {
        let motion = self.pedestrian.act(&Scene {
            time: self.time,
            step: self.step,
            road: &self.world.road,
            crossing: 0,
            me: 0,
            goal: self.world.pedestrians[0].goal,
            legs: (0, 0),
            vehicles: &self.vehicles,
            pedestrians: &self.states,
            held: false,
        });
        let state = &mut self.states[0];
        match motion {
            Motion::Walk(velocity) => {
                state.position += velocity * self.step;
                state.velocity = velocity;
            }
            Motion::Pushed { velocity, displacement } => {
                state.position += velocity * self.step + displacement;
                state.velocity = velocity;
            }
            Motion::Accelerate(acceleration) => {
                let way = state.heading;
                let speed = state.velocity.dot(&way);
                state.position +=
                    way * (self.step * speed + acceleration * self.step * self.step / 2.0).max(0.0);
                state.velocity = way * (speed + acceleration * self.step).max(0.0);
            }
        }
        for vehicle in &mut self.vehicles {
            vehicle.motion.travelled += vehicle.motion.speed * self.step;
        }
        self.time += self.step;
        motion
    }

    /// Goes on for a while (s).
    pub fn go(&mut self, duration: f64) {
        for _ in 0..(duration / self.step).round() as usize {
            self.step();
        }
    }

    /// Time at which y is first reached, interpolated within the step, s.
    pub fn time_to_reach(&mut self, y: f64) -> f64 {
        loop {
            let before = self.position().y;
            self.step();
            let after = self.position().y;
            if after >= y {
                return self.time - self.step * (after - y) / (after - before);
            }
            assert!(self.time < 100.0, "never reaches {y}");
        }
    }
}

fn build(
    model: &PedestrianModel,
    settings: &Settings,
    world: &World,
    seed: u64,
) -> Result<Box<dyn Pedestrian>, ModelError> {
    let resolved = model.declaration.resolve(settings).unwrap();
    let setup = &world.pedestrians[0];
    (model.build)(&PedestrianContext { settings: &resolved, setup, world, rank: 0, seed })
}

pub fn world() -> World {
    World {
        road: Road::zebra(&[Direction::Forward, Direction::Backward], 30.0 / 3.6),
        other_roads: Vec::new(),
        vehicles: Vec::new(),
        pedestrians: vec![PedestrianSetup {
            kind: Default::default(),
            name: "walker".into(),
            model: nobody(),
            shape: Shape::Rectangle { length: 0.375, width: 0.375 },
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
        }],
        streams: Vec::new(),
        step: 0.025,
        horizon: 60.0,
        finish: 60.0,
        end_on_collision: true,
    }
}
