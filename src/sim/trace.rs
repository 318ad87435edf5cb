//! The recorded course of a run, for those who ask for it.

use nalgebra::Vector2;

use super::observer::{Observer, Step};
use super::state::Snapshot;

/// One road user at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// s
    pub time: f64,
    /// Index of the road user: vehicles first, then pedestrians.
    pub who: usize,
    /// World frame, m.
    pub position: Vector2<f64>,
    /// m/s
    pub velocity: Vector2<f64>,
    /// Along the road for vehicles, along the heading for pedestrians, m/s².
    pub acceleration: f64,
    pub mode: &'static str,
}

/// Records every state of every road user that is present.
#[derive(Debug, Default)]
pub struct Trace {
    pub samples: Vec<Sample>,
}

impl Trace {
    fn record(&mut self, time: f64, state: &Snapshot, modes: impl Fn(usize) -> &'static str) {
        let cars = state.vehicles.len();
        self.samples.extend(state.vehicles.iter().enumerate().map(|(who, car)| Sample {
            time,
            who,
            position: car.position(),
            velocity: car.velocity(),
            acceleration: car.motion.acceleration,
            mode: modes(who),
        }));
        let present = state.pedestrians.iter().enumerate().filter(|(_, person)| person.present);
        self.samples.extend(present.map(|(index, person)| Sample {
            time,
            who: cars + index,
            position: person.position,
            velocity: person.velocity,
            acceleration: person.acceleration.dot(&person.heading),
            mode: modes(cars + index),
        }));
    }
}

impl Observer for Trace {
    fn begin(&mut self, start: &Snapshot) {
        self.record(0.0, start, |_| "");
    }

    fn observe(&mut self, step: &Step) {
        let cars = step.vehicle_modes.len();
        self.record(step.time + step.duration, step.after, |who| {
            if who < cars { step.vehicle_modes[who] } else { step.pedestrian_modes[who - cars] }
        });
    }
}
