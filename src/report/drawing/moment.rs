//! Everybody at one moment of a recorded run.

use nalgebra::Vector2;

use scenario::{Shape, World};
use sim::geometry::Footprint;
use sim::{Sample, Trace};

/// Where everybody is at one moment, and where they came from.
pub(crate) struct Moment {
    /// s
    pub(crate) time: f64,
    /// Vehicles first, then pedestrians; `None` before somebody appears.
    pub(crate) users: Vec<Option<Seen>>,
}

/// A road user at one moment.
pub(crate) struct Seen {
    pub(crate) outline: Footprint,
    /// m/s
    pub(crate) speed: f64,
    /// Where it was before, m.
    pub(crate) trail: Vec<Vector2<f64>>,
}

/// Between two points of a trail, s.
const INTERVAL: f64 = 0.1;

impl Moment {
    /// What is recorded of a world's run at a time (s), between two samples as far between.
    pub(crate) fn of(world: &World, trace: &Trace, time: f64) -> Self {
        let count = world.vehicles.len() + world.pedestrians.len();
        let users = (0..count).map(|who| seen(world, trace, who, time)).collect();
        Self { time, users }
    }
}

/// When a recorded run ended, s.
pub(crate) fn end_of(trace: &Trace) -> f64 {
    trace.samples.last().map_or(0.0, |sample| sample.time)
}

fn shape(world: &World, who: usize) -> Shape {
    match world.vehicles.get(who) {
        Some(car) => Shape::Rectangle { length: car.length, width: car.width },
        None => world.pedestrians[who - world.vehicles.len()].shape,
    }
}

fn seen(world: &World, trace: &Trace, who: usize, time: f64) -> Option<Seen> {
    let own: Vec<&Sample> = trace.samples.iter().filter(|sample| sample.who == who).collect();
    let after = own.iter().position(|sample| sample.time >= time - 1e-9).unwrap_or(own.len().checked_sub(1)?);
    let next = own[after];
    let before = match after.checked_sub(1) {
        // Who appears later is not there yet.
        None if next.time > time + 1e-9 => return None,
        None => next,
        Some(before) => own[before],
    };
    let span = next.time - before.time;
    let part = if span > 0.0 { ((time - before.time) / span).clamp(0.0, 1.0) } else { 1.0 };
    let heading = before.heading.lerp(&next.heading, part).try_normalize(1e-9).unwrap_or(next.heading);
    let centre = before.position.lerp(&next.position, part);
    let mut trail: Vec<Vector2<f64>> = Vec::new();
    let mut due = f64::NEG_INFINITY;
    for sample in own.iter().take_while(|sample| sample.time < time) {
        if sample.time >= due {
            trail.push(sample.position);
            due = sample.time + INTERVAL;
        }
    }
    trail.push(centre);
    let speed = before.velocity.lerp(&next.velocity, part).norm();
    Some(Seen { outline: Footprint { centre, heading, shape: shape(world, who) }, speed, trail })
}
