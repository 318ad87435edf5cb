//! Metrics: numbers read off a run while it happens, one file a family, and their registry.
//!
//! To add one: declare a [`Metric`] in the file of its family (or a new file) and list it in [`METRICS`]. Events inside
//! a step are interpolated linearly; a metric that does not exist in a run is `None`, never a magic number.

mod braking;
mod conflict;
mod contact;
mod crossing;
mod encounter;
#[cfg(test)]
mod fixture;
mod jerk;
mod measurement;
mod passage;
mod proximity;
mod range;
mod sliding;
#[cfg(test)]
mod tests;
mod travel;

use crate::numbers::json;
use serde::{Deserialize, Serialize};

use crate::scenario::{Aggregate, Declaration, Dimension, MetricReference, Settings, World};
use crate::sim::{Snapshot, Solid, Step};

pub use encounter::{
    Contact, Encounter, Encounters, Entry, LaneCrossing, MEETING_TIME, Passing, Presence, Visit,
};
pub(crate) use encounter::{along, half_extent};
pub use measurement::{Measurement, Reading, SubjectValue};
pub use passage::{Passage, Reached};
pub use range::{Range, limits};

/// A registered metric.
pub struct Metric {
    pub declaration: Declaration,
    pub kind: MetricKind,
    pub scope: Scope,
    /// Which of several values, one per pair, is the one that counts for the run.
    pub worst: Worst,
    pub absence: Absence,
    pub range: Range,
    pub build: fn(&MetricContext) -> Box<dyn Meter>,
}

/// What a metric's number means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MetricKind {
    Quantity(Dimension),
    /// 1 for true, 0 for false.
    Flag,
    /// The index of one of these words.
    Category(&'static [&'static str]),
}

/// Whom a metric is measured for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// A vehicle and a pedestrian.
    Pair,
    /// A vehicle and anything solid: a pedestrian, another vehicle or a box.
    Contact,
    Vehicle,
    Pedestrian,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Worst {
    Smallest,
    Largest,
}

/// What it says of a run that a metric does not exist in it, for criteria and for comparisons of runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Absence {
    /// The danger that it measures never arose.
    Good,
    /// Somebody never got to the end.
    Bad,
    /// Neither for sure, or it exists in every run.
    Open,
}

/// Reads one metric for one subject (a pair, a vehicle or a pedestrian) off a run.
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
}

/// The state in which the horizon, or a contact that ends runs, ends a run.
#[derive(Debug, Clone, Copy)]
pub struct End<'a> {
    /// s
    pub time: f64,
    pub state: &'a Snapshot,
}

/// Between which values a metric would have come to lie, had its run not been cut off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Open {
    #[serde(with = "json::low")]
    pub low: f64,
    /// Infinite where nothing bounds it.
    #[serde(with = "json::high")]
    pub high: f64,
}

impl Open {
    pub fn at_least(low: f64) -> Self {
        Self { low, high: f64::INFINITY }
    }
}

/// What a meter is built from.
#[derive(Clone, Copy)]
pub struct MetricContext<'a> {
    /// Resolved against the metric's declaration.
    pub settings: &'a Settings,
    pub world: &'a World,
    /// Index of the vehicle; 0 for a metric of pedestrians.
    pub vehicle: usize,
    /// Index of the pedestrian; 0 for a metric of vehicles.
    pub pedestrian: usize,
    /// Whom or what it is measured with, or the pedestrian that it is measured for.
    pub with: Option<Solid>,
    /// The vehicle's run without pedestrians.
    pub free_flow: Option<FreeFlow>,
    /// The speed at which the pedestrian would walk without traffic, m/s.
    pub free_speed: Option<f64>,
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
fn difference(one: f64, other: f64) -> f64 {
    /// s or m; a thousand times the rounding of an hour at the shortest step.
    const ROUNDING: f64 = 1e-9;
    let difference = one - other;
    if difference.abs() < ROUNDING { 0.0 } else { difference }
}

/// Every metric there is, by name.
pub static METRICS: &[&Metric] = &[
    &contact::COLLISION,
    &contact::IMPACT_SPEED,
    &conflict::PET,
    &conflict::PET_AREA,
    &conflict::PASSED_FIRST,
    &conflict::GAP_ACCEPTED,
    &conflict::TTA_AT_ENTRY,
    &proximity::MIN_TTC,
    &contact::MIN_DISTANCE,
    &proximity::DRAC,
    &braking::MAX_DECELERATION,
    &braking::SUDDEN_SPEED_CHANGE,
    &jerk::MAX_JERK,
    &jerk::RMS_JERK,
    &travel::TIME_LOST,
    &travel::TRAVEL_TIME,
    &travel::STOPPED_TIME,
    &crossing::CROSSING_INITIATION_TIME,
    &crossing::CROSSING_DURATION,
    &crossing::PEDESTRIAN_DELAY,
];

/// The metric of that name.
pub fn metric(name: &str) -> Option<&'static Metric> {
    METRICS.iter().copied().find(|metric| metric.declaration.name == name)
}

/// SI unit of an aggregate's value; `%` for a rate, which is a share in 0..1, and nothing for plain numbers.
pub fn unit_of(aggregate: &Aggregate) -> String {
    match aggregate {
        Aggregate::Rate(_) => "%".to_string(),
        Aggregate::Count(_) => String::new(),
        of_values => unit_of_metric(of_values.metric()),
    }
}

/// SI unit of a metric's values; nothing for those that are no quantities.
pub fn unit_of_metric(reference: &MetricReference) -> String {
    match metric(&reference.name).map(|metric| metric.kind) {
        Some(MetricKind::Quantity(dimension)) => dimension.si_unit(),
        _ => String::new(),
    }
}
