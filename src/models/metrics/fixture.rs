//! Encounters with known motion, for tests.

use nalgebra::Vector2;

use super::metrics;
use scenario::{Appearance, MetricReference, Settings, Value, VehicleSetup, World};
use sim::measure::{FreeFlow, Measurement, Open, Presence, Reading};
use sim::{
    Abreast, Contacts, Ending, Longitudinal, Minds, Mode, Observer, PedestrianState, Snapshot, Step,
    StopReason, VehicleState, fixture,
};

/// The world of [`fixture`] at this step and horizon, s.
pub fn world(step: f64, horizon: f64) -> World {
    World { step, horizon, ..fixture::world() }
}

/// Motion along a line from (place, speed), in stretches of (duration, acceleration); at rest it stays at rest.
#[derive(Clone)]
pub struct Profile {
    pub place: f64,
    pub speed: f64,
    pub stretches: Vec<(f64, f64)>,
}

impl Profile {
    pub fn new(place: f64, speed: f64, stretches: &[(f64, f64)]) -> Self {
        Self { place, speed, stretches: stretches.to_vec() }
    }

    /// Place and speed at a time.
    pub fn at(&self, time: f64) -> (f64, f64) {
        let (mut place, mut speed, mut left) = (self.place, self.speed, time);
        for &(duration, acceleration) in self.stretches.iter().chain(&[(f64::INFINITY, 0.0)]) {
            let mut part = left.min(duration);
            left -= part;
            if acceleration < 0.0 {
                part = part.min(-speed / acceleration);
            }
            place += speed * part + acceleration * part * part / 2.0;
            speed += acceleration * part;
        }
        (place, speed)
    }
}

/// A walk along straight lines through (time, x, y); it stays where it ends.
#[derive(Clone)]
pub struct Walk(pub Vec<(f64, f64, f64)>);

impl Walk {
    fn at(&self, time: f64) -> (Vector2<f64>, Vector2<f64>) {
        for pair in self.0.windows(2) {
            let ((t0, x0, y0), (t1, x1, y1)) = (pair[0], pair[1]);
            // The velocity of a corner is that of the way before, as the state at the end of a step holds it.
            if time <= t1 + 1e-9 {
                let velocity = Vector2::new(x1 - x0, y1 - y0) / (t1 - t0);
                return (Vector2::new(x0, y0) + velocity * (time - t0), velocity);
            }
        }
        let (_, x, y) = *self.0.last().expect("a walk has a place");
        (Vector2::new(x, y), Vector2::zeros())
    }
}

/// The free flow of a car that passes the finish line of [`world`] after 12 s at 10 m/s.
pub const FREE_FLOW: FreeFlow = FreeFlow { finish_time: Some(12.0), finish_speed: 10.0 };

/// The readings of one encounter, by request. Walks at 1.25 m/s when free.
pub fn measure(world: &World, requests: &[MetricReference], car: &Profile, walk: &Walk) -> Vec<Reading> {
    measure_traffic(world, requests, std::slice::from_ref(car), walk)
}

/// The readings of one pedestrian and several cars, by request.
pub fn measure_traffic(
    world: &World,
    requests: &[MetricReference],
    cars: &[Profile],
    walk: &Walk,
) -> Vec<Reading> {
    observe(world, requests, cars, walk).readings()
}

/// What the pedestrian and the car had to do with each other.
pub fn presence(world: &World, car: &Profile, walk: &Walk) -> Presence {
    observe(world, &[], std::slice::from_ref(car), walk).presences()[0].2
}

/// What is measured of one pedestrian and several cars.
pub fn observe(world: &World, requests: &[MetricReference], cars: &[Profile], walk: &Walk) -> Measurement {
    let mut measurement = Measurement::new(world, requests, &[FREE_FLOW], &[1.25]);
    let steps = (world.horizon / world.step).round() as usize;
    let mut contacts = Contacts::new(world);
    let modes = vec![Mode::NONE; cars.len()];
    let mut ending = Ending { reason: StopReason::Horizon, time: world.horizon };
    let mut before = snapshot(world, cars, walk, 0.0);
    measurement.begin(&before);
    for k in 0..steps {
        let time = k as f64 * world.step;
        let after = snapshot(world, cars, walk, (k + 1) as f64 * world.step);
        contacts.find(&before, &after, world.step);
        let collision = contacts.collision().filter(|_| world.end_on_collision);
        if let Some(moment) = collision {
            contacts.end_at(moment);
        }
        let step = Step {
            time,
            duration: world.step,
            before: &before,
            after: &after,
            whole: &after,
            pedestrian_modes: &[Mode::NONE],
            vehicle_modes: &modes,
            motions: &[],
            contacts: contacts.found(),
            sightings: &[],
            abreast: &Abreast::default(),
            views: Default::default(),
            may_go: None,
            minds: Minds::default(),
        };
        if let Some(moment) = collision {
            measurement.observe(&Step { duration: moment, after: &step.at(moment), ..step });
            ending = Ending { reason: StopReason::Collision, time: time + moment };
            break;
        }
        measurement.observe(&step);
        before = after;
    }
    measurement.end(&ending, &before);
    measurement
}

/// What every metric with its defaults could still come to when time is up.
pub fn open_of(world: &World, car: &Profile, walk: &Walk) -> impl Fn(&str) -> Option<Open> + use<> {
    let requests: Vec<_> = metrics().iter().map(|metric| request(&metric.declaration.name, [])).collect();
    let readings = measure(world, &requests, car, walk);
    move |name| {
        let index = requests.iter().position(|request| request.name() == name).expect("a metric's name");
        readings[index].open
    }
}

/// The worst values of every metric with its defaults, and a way to look them up.
pub fn measure_all(world: &World, car: &Profile, walk: &Walk) -> impl Fn(&str) -> Option<f64> + use<> {
    let requests: Vec<_> = metrics().iter().map(|metric| request(&metric.declaration.name, [])).collect();
    let readings = measure(world, &requests, car, walk);
    move |name| {
        let index = requests.iter().position(|request| request.name() == name).expect("a metric's name");
        readings[index].worst.and_then(|worst| worst.value)
    }
}

pub fn request<const N: usize>(name: &str, settings: [(&str, Value); N]) -> MetricReference {
    MetricReference { settings: Settings::from(settings), ..crate::known::measured(name) }
}

fn snapshot(world: &World, cars: &[Profile], walk: &Walk, time: f64) -> Snapshot {
    let vehicle = |(setup, car): (&VehicleSetup, &Profile)| {
        let (travelled, speed) = car.at(time);
        let motion = Longitudinal { travelled, speed, acceleration: 0.0 };
        VehicleState::new(world.path_of(setup), motion, (setup.length, setup.width))
    };
    let person = &world.pedestrians[0];
    let (position, velocity) = walk.at(time);
    Snapshot {
        vehicles: world.vehicles.iter().zip(cars).map(vehicle).collect(),
        pedestrians: vec![PedestrianState {
            position,
            velocity,
            acceleration: Vector2::zeros(),
            heading: Vector2::new(0.0, person.side.walking_sign()),
            shape: person.shape,
            present: match person.appears {
                Appearance::At(moment) => time >= moment - 1e-9,
                Appearance::TimeToArrival { .. } | Appearance::Meeting { .. } => true,
            },
        }],
    }
}
