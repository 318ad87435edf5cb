//! What is measured of a run while it happens: the encounters that every metric needs, and the meters of those requested.
//!
//! What each metric that ships means stands beside the models; here is what all of them are read off.

mod details;
mod edges;
mod encounter;
mod events;
mod followed;
mod jerk;
mod measurement;
mod passage;
mod presence;
mod sliding;
mod speed_drop;
mod steered_pair;
mod stream_way;
mod vehicle_pair;

use std::cell::RefCell;

use serde::{Deserialize, Serialize};

use crate::{Snapshot, Solid, Step};
use numbers::json;
use scenario::{Absence, Meters, Scope, Settings, World, Worst};

pub use details::{
    PairDetails, PassingTimes, PersonDetails, RecordedDetails, RunDetails, StepReadings, VisitTimes,
};
pub use edges::EdgeContact;
pub use encounter::{Contact, Encounter, Encounters, Entry, LaneCrossing, strip};
pub use events::{Passing, Visit, half_extent, half_extent_along, least_of, lerp, part_within, rising};
pub use followed::{Followed, FollowedDrop, FollowedJerk};
pub use jerk::Jerk;
pub use measurement::{Measurement, Reading, SubjectValue};
pub use passage::{Passage, Reached};
pub use presence::{Closeness, MEETING_TIME, Presence};
pub use speed_drop::SpeedDrop;
pub use stream_way::{Slot, StreamWay};

/// Builds the meter of one subject.
type BuildMeter = Box<dyn Fn(&MetricContext) -> Box<dyn Meter> + Send + Sync>;

/// How a metric is measured: by a meter for each subject.
pub fn meters(build: impl Fn(&MetricContext) -> Box<dyn Meter> + Send + Sync + 'static) -> Meters {
    Meters::new::<BuildMeter>(Box::new(build))
}

/// Reads one metric for one subject (a pair, a stream and a pedestrian, a vehicle or a pedestrian) off a run.
pub trait Meter: Send {
    /// Called after every step, once `encounters` knows of it. A run that ends on collision ends with a shorter step.
    fn observe(&mut self, _step: &Step, _encounters: &Encounters) {}

    /// The value at the end; `None` when it does not exist in this run.
    fn value(&self, encounters: &Encounters) -> Option<f64>;

    /// What it could still come to where the run is over at `end`, time being up or others having touched; `None` where it is decided. Extremes of what was seen so
    /// far, such as a smallest distance, are decided at any time.
    fn open(&self, _encounters: &Encounters, _end: &End) -> Option<Open> {
        None
    }

    /// When it took that value, s: the critical instant. `None` for what has no single one, such as a time lost.
    fn instant(&self, _encounters: &Encounters) -> Option<f64> {
        None
    }

    /// What it is the worst over time of, in the last step. Whoever says something else than [`InStep::AtTheEnd`] has at any time the worst of all steps
    /// until then as its value. Asked of runs that are drawn alone.
    fn in_step(&self, _encounters: &Encounters) -> InStep {
        InStep::AtTheEnd
    }
}

/// What a metric is the worst over time of, in one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InStep {
    /// It is no such worst, but a sum, or a time between two events: before they are over there is none of it.
    AtTheEnd,
    /// There is none of it in the step.
    Nothing,
    /// The worst in the step.
    Worst(f64),
}

impl From<Option<f64>> for InStep {
    fn from(worst: Option<f64>) -> Self {
        worst.map_or(Self::Nothing, Self::Worst)
    }
}

/// The state in which the horizon, or a contact that ends runs, ends a run.
#[derive(Debug, Clone, Copy)]
pub struct End<'a> {
    /// s
    pub time: f64,
    /// Everybody at that time.
    pub state: &'a Snapshot,
}

/// Between which values a metric would have come to lie, had its run not been cut off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Open {
    /// Negative infinity where nothing bounds it.
    #[serde(with = "json::low")]
    pub low: f64,
    /// Infinite where nothing bounds it.
    #[serde(with = "json::high")]
    pub high: f64,
}

impl Open {
    /// Nothing bounds it from above.
    pub fn at_least(low: f64) -> Self {
        Self { low, high: f64::INFINITY }
    }
}

/// What a meter is built from.
#[derive(Clone, Copy)]
pub struct MetricContext<'a> {
    /// Resolved against the metric's declaration.
    pub settings: &'a Settings,
    /// Everything that decides the run, but its seed.
    pub world: &'a World,
    /// Index of the vehicle; 0 for a metric of pedestrians or of streams.
    pub vehicle: usize,
    /// Index of the stream; 0 for a metric of anybody else.
    pub stream: usize,
    /// Index of the pedestrian; 0 for a metric of vehicles.
    pub pedestrian: usize,
    /// Whom or what it is measured with, or the pedestrian that it is measured for.
    pub with: Option<Solid>,
    /// The vehicle's run without pedestrians.
    pub free_flow: Option<FreeFlow>,
    /// The speed at which the pedestrian would walk without traffic, m/s.
    pub free_speed: Option<f64>,
    /// What is to be followed for the meter, which reads it off the [`Encounters`].
    pub followed: &'a RefCell<Followed>,
}

impl MetricContext<'_> {
    /// Lets times to collision be worked out.
    pub fn look_ahead(&self) {
        self.followed.borrow_mut().look_ahead();
    }
}

/// What a vehicle does without pedestrians from the same start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeFlow {
    /// Time at which its centre passes the finish line, s; `None` if it never does.
    pub finish_time: Option<f64>,
    /// Its speed there, m/s.
    pub finish_speed: f64,
}

/// `one` - `other`, two times or two places that were each summed up over many steps: exactly 0 where they differ by the
/// rounding of such sums only, so that nobody is late by 2e-15 s.
pub fn difference(one: f64, other: f64) -> f64 {
    /// s or m; a thousand times the rounding of an hour at the shortest step.
    const ROUNDING: f64 = 1e-9;
    let difference = one - other;
    if difference.abs() < ROUNDING { 0.0 } else { difference }
}
