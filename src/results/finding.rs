//! What was found of one criterion of a trial.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::critical::Critical;
use super::written_counts::is_zero;
use crate::Verdict;
use numbers::json;
use scenario::{Metric, Origin, People, Reference};
use sim::measure::Closeness;

/// One criterion's verdict and what it rests on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// In canonical words, such as `no collision`.
    pub criterion: String,
    /// Where the criterion is written.
    pub origin: Origin,
    /// What the criterion comes to.
    pub verdict: Verdict,
    /// The metric that the criterion is about.
    pub metric: Reference<Metric>,
    /// What [`Self::observed`] is.
    pub measure: FindingMeasure,
    /// Where runs are added, those after which the criterion was decided: the trial may have had more for others.
    pub runs: usize,
    /// Runs in which the comparison holds, or, for aggregates of values, in which the metric exists.
    pub holding: usize,
    /// Runs in which the metric does not exist.
    pub undefined: usize,
    /// Runs that the horizon ended before the metric was decided: each counts as the worst that it could still have come to.
    pub cut_off: usize,
    /// Runs that ended, by the horizon or another's contact, before what the metric is about was over, so that an extreme of what
    /// was seen so far may have got worse.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub unseen: usize,
    /// The aggregate's value or the share of runs; `None` if no run gives one. Infinite where runs that have none decide.
    #[serde(with = "json::extended")]
    pub observed: Option<f64>,
    /// What it was compared to.
    pub bound: f64,
    /// Signed distance from failing in the unit of what was compared; negative when failing.
    #[serde(with = "json::extended")]
    pub margin: Option<f64>,
    /// Bounds on the estimate, each by itself at the stated confidence.
    #[serde(with = "json::interval")]
    pub interval: Option<(f64, f64)>,
    /// The stated confidence (0..1).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f64>,
    /// A confidence is stated, but all runs (and there are many) are the same bit for bit: what chance there is changed
    /// nothing, so that they may be worth no more than one.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub alike: bool,
    /// The bounds hold at about the stated confidence only: the metric has no limits that they could rest on.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub approximate: bool,
    /// Whom it speaks of, where a confidence is stated and the runs are of several people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub people: Option<Regarding>,
    /// The runs that speak most against the criterion, worst first.
    pub worst: Vec<WorstRun>,
    /// Where no run speaks against it, the one nearest to that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub closest: Option<WorstRun>,
    /// Of a criterion on the time between two centres that passed: runs in which their bodies used the shared area at the same time.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub overlapping: usize,
    /// The number of runs in which it was put to the test, where that is some of them and not all; of several pairs the smallest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tested: Option<usize>,
    /// Why it was never put to the test, if it passed without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub untested: Option<Untested>,
}

/// What a finding's `observed` and `bound` are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FindingMeasure {
    /// The share of runs that hold, where every run has to.
    EveryRun,
    /// The share of runs that hold.
    Share,
    /// The number of runs that hold.
    Count,
    /// An aggregate in the metric's own unit.
    Value,
}

/// Whom a finding speaks of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Regarding {
    /// Those who walked, or all whom they were taken from.
    pub whom: People,
    /// How many walked.
    pub people: usize,
    /// Whether every run is of somebody of their own, drawn with replacement.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub drawn: bool,
}

/// A run that a finding names.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WorstRun {
    /// The run's key.
    pub key: String,
    /// The metric's value; `None` where it does not exist.
    pub value: Option<f64>,
    /// Signed distance of the value from speaking against the criterion, in the metric's unit; negative where it does.
    /// `None` where there is no distance: of flags, words, and values that do not exist.
    #[serde(with = "json::extended")]
    pub margin: Option<f64>,
    /// Whether the horizon ended the run before the metric was decided; the value is then that of what was seen so far.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub cut_off: bool,
    /// When and for whom it was that; `None` where nobody asked or there is nothing to say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub critical: Option<Critical>,
}

/// Why a criterion that passed was never put to the test.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum Untested {
    /// In no run did the members of these pairs come as close to each other as it takes.
    Pairs {
        /// In the order of the scenario.
        pairs: Vec<UntestedPair>,
        /// The criterion about a pair that was put to the test.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        instead: Option<String>,
    },
    /// In no run did the vehicle move while it was together with a pedestrian.
    NoMotion {
        /// `None`: any vehicle.
        vehicle: Option<Arc<str>>,
    },
    /// In no run did the metric exist: nothing that it is about was at stake.
    NoValue,
    /// Some run ended with somebody on a collision course or an encounter not over: what would have come was not seen.
    CutOff,
}

/// A pair that was not put to the test.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct UntestedPair {
    /// The vehicle; `None`: any vehicle.
    pub vehicle: Option<Arc<str>>,
    /// The pedestrian or the other vehicle.
    pub other: Arc<str>,
    /// The closest that they came in any run.
    pub closest: Closeness,
}
