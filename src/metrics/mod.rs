//! Metrics: numbers read off a run while it happens, one file a family, and their registry.

mod measurement;

use crate::scenario::{Declaration, Dimension, Settings, World};
use crate::sim::{Ending, Step};

pub use measurement::Measurement;

/// A registered metric.
pub struct Metric {
    pub declaration: Declaration,
    pub kind: MetricKind,
    pub scope: Scope,
    /// Which of several values, one per pair, is the one that counts for the run.
    pub worst: Worst,
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
    Pair,
    Vehicle,
    Pedestrian,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Worst {
    Smallest,
    Largest,
}

/// Reads one metric for one vehicle and one pedestrian off a run.
pub trait Meter: Send {
    /// Called after every step.
    fn observe(&mut self, step: &Step);

    /// The value at the end; `None` when it does not exist in this run.
    fn value(&self, ending: &Ending) -> Option<f64>;
}

/// What a meter is built from.
#[derive(Clone, Copy)]
pub struct MetricContext<'a> {
    /// Resolved against the metric's declaration.
    pub settings: &'a Settings,
    pub world: &'a World,
    /// Index of the vehicle.
    pub vehicle: usize,
    /// Index of the pedestrian.
    pub pedestrian: usize,
    /// The vehicle's run without pedestrians.
    pub free_flow: Option<FreeFlow>,
}

/// What a vehicle does without pedestrians from the same start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeFlow {
    /// Time at which its centre passes the finish line, s; `None` if it never does.
    pub finish_time: Option<f64>,
    /// Its speed there, m/s.
    pub finish_speed: f64,
}

/// Every metric there is, by name.
pub static METRICS: &[&Metric] = &[];

/// The metric of that name.
pub fn metric(name: &str) -> Option<&'static Metric> {
    METRICS.iter().copied().find(|metric| metric.declaration.name == name)
}
