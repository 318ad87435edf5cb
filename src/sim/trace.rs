//! The recorded course of a run, for those who ask for it.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::observer::{Observer, Step};
use super::perceived::PerceivedView;
use super::solid::Solid;
use scenario::agent::{Mode, Motion, Snapshot};

/// One road user at one time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// s
    pub time: f64,
    /// Index of the road user: vehicles first, then pedestrians.
    pub who: usize,
    /// World frame, m.
    pub position: Vector2<f64>,
    /// Unit vector in which a vehicle drives, or a pedestrian faces.
    pub heading: Vector2<f64>,
    /// Where a vehicle is on its path, m; `None` of pedestrians.
    pub travelled: Option<f64>,
    /// m/s
    pub velocity: Vector2<f64>,
    /// Along the road for vehicles, along the heading for pedestrians, m/s².
    pub acceleration: f64,
    /// The model's own word for what it is up to.
    pub mode: Mode,
}

/// What makes a sample more than one of many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TraceMark {
    /// It is the first of its road user, who was nowhere before.
    Appears,
    /// Its road user was displaced in the step before it, besides walking.
    Jumps,
    /// It is the moment at which the road user begins to touch something.
    Touches(Solid),
    /// The vehicle of this index, which does not see everything, is shown its road user from then on.
    Seen(usize),
    /// It is not shown it any more.
    Lost(usize),
}

/// Records every state of every road user that is present: after every step, and at every moment inside one at which two
/// bodies begin to touch. The last is that of the moment at which the run ends.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Trace {
    /// In the order of time, and at one time in the order of the world, vehicles first.
    pub samples: Vec<Sample>,
    /// By index of the sample, in order.
    pub marks: Vec<(usize, TraceMark)>,
    /// What controllers were told of others and was not so, in the order of the steps; one without anybody says that all is so from
    /// then on. Nothing where it always is.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub perceived: Vec<PerceivedView>,
    /// Which pedestrians have a sample already.
    seen: Vec<bool>,
}

/// Moments that are nearer than this are the same, s.
const SAME: f64 = 1e-9;

impl Trace {
    fn record(&mut self, time: f64, state: &Snapshot, modes: impl Fn(usize) -> Mode) {
        let cars = state.vehicles.len();
        self.samples.extend(state.vehicles.iter().enumerate().map(|(who, car)| Sample {
            time,
            who,
            position: car.position(),
            heading: car.heading(),
            travelled: Some(car.motion.travelled),
            velocity: car.velocity(),
            acceleration: car.motion.acceleration,
            mode: modes(who),
        }));
        for index in 0..state.pedestrians.len() {
            if state.pedestrians[index].present {
                self.record_pedestrian(time, state, index, modes(cars + index));
            }
        }
    }

    fn record_pedestrian(&mut self, time: f64, state: &Snapshot, index: usize, mode: Mode) {
        let person = &state.pedestrians[index];
        self.samples.push(Sample {
            time,
            who: state.vehicles.len() + index,
            position: person.position,
            heading: person.heading,
            travelled: None,
            velocity: person.velocity,
            acceleration: person.acceleration.dot(&person.heading),
            mode,
        });
    }

    /// What controllers were told that was not so, and that it is so from a decision on.
    fn record_perceived(&mut self, step: &Step) {
        for vehicle in 0..step.before.vehicles.len() {
            let Some(view) = step.perceived(vehicle) else { continue };
            let before = self.perceived.iter().rev().find(|one| one.vehicle == vehicle);
            if !view.others.is_empty() || before.is_some_and(|before| !before.others.is_empty()) {
                self.perceived.push(view);
            }
        }
    }

    /// Those who are there from the beginning of this step on.
    fn record_new(&mut self, step: &Step) {
        self.seen.resize(step.before.pedestrians.len(), false);
        let last = self.samples.last().map(|sample| sample.time);
        // The same moment is the same to the last bit, so that rows of one moment are known by their time.
        let time = last.filter(|last| (last - step.time).abs() < SAME).unwrap_or(step.time);
        for index in 0..self.seen.len() {
            if step.before.pedestrians[index].present && !self.seen[index] {
                self.seen[index] = true;
                self.marks.push((self.samples.len(), TraceMark::Appears));
                self.record_pedestrian(time, step.before, index, step.pedestrian_modes[index].clone());
            }
        }
    }

    /// Marks the samples of those who come into sight or are lost from it at the beginning of a step, or else within it: the last of each.
    fn mark_sightings(&mut self, step: &Step, at_the_beginning: bool) {
        let cars = step.before.vehicles.len();
        for sighting in step.sightings.iter().filter(|one| (one.moment < SAME) == at_the_beginning) {
            let who = match sighting.who {
                Solid::Vehicle(index) => index,
                Solid::Pedestrian(index) => cars + index,
                Solid::Box(_) => continue,
            };
            if sighting.moment <= step.duration
                && let Some(index) = self.samples.iter().rposition(|sample| sample.who == who)
            {
                let mark = if sighting.seen { TraceMark::Seen } else { TraceMark::Lost };
                self.marks.push((index, mark(sighting.vehicle)));
            }
        }
    }

    /// Marks the samples of the two that touch `moment` s after the beginning of the step, which were the last recorded.
    fn mark_contacts(&mut self, step: &Step, moment: f64) {
        let cars = step.before.vehicles.len();
        let Some(time) = self.samples.last().map(|sample| sample.time) else { return };
        for touch in step.contacts.iter().filter(|touch| touch.begins && touch.moment == moment) {
            for (one, other) in [(touch.first, touch.second), (touch.second, touch.first)] {
                let who = match one {
                    Solid::Vehicle(index) => index,
                    Solid::Pedestrian(index) => cars + index,
                    Solid::Box(_) => continue,
                };
                let recent = self.samples.iter().rev().take_while(|sample| sample.time == time);
                if let Some(back) = recent.into_iter().position(|sample| sample.who == who) {
                    self.marks.push((self.samples.len() - 1 - back, TraceMark::Touches(other)));
                }
            }
        }
    }
}

impl Observer for Trace {
    fn begin(&mut self, start: &Snapshot) {
        self.record(0.0, start, |_| Mode::NONE);
    }

    fn observe(&mut self, step: &Step) {
        let cars = step.vehicle_modes.len();
        let mode = |who: usize| {
            if who < cars {
                step.vehicle_modes[who].clone()
            } else {
                step.pedestrian_modes[who - cars].clone()
            }
        };
        let known = self.marks.len();
        self.record_new(step);
        self.record_perceived(step);
        self.mark_sightings(step, true);
        let mut moments: Vec<f64> =
            step.contacts.iter().filter(|touch| touch.begins).map(|touch| touch.moment).collect();
        moments.sort_by(f64::total_cmp);
        moments.dedup();
        for moment in &moments {
            // At the end of a step there is a row in any case, at its beginning there is one already.
            let (first, last) = (*moment < SAME, step.duration - *moment < SAME && step.duration > 0.0);
            if !first && !last {
                self.record(step.time + moment, &step.at(*moment), mode);
            }
            if !last {
                self.mark_contacts(step, *moment);
            }
        }
        if step.duration > 0.0 {
            let first = self.samples.len();
            self.record(step.time + step.duration, step.after, mode);
            for (index, sample) in self.samples.iter().enumerate().skip(first) {
                let motion = sample.who.checked_sub(cars).and_then(|person| step.motions.get(person));
                if matches!(motion, Some(Motion::Pushed { displacement, .. }) if displacement.norm() > 0.0) {
                    self.marks.push((index, TraceMark::Jumps));
                }
            }
            self.mark_sightings(step, false);
            for moment in moments.into_iter().filter(|moment| step.duration - *moment < SAME) {
                self.mark_contacts(step, moment);
            }
        }
        if self.marks.len() > known {
            self.marks.sort_by_key(|(index, _)| *index);
        }
    }
}
