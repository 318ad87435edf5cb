//! What one run came to.

use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::critical::{ByMetric, Critical};
use super::requests::Requests;
use numbers::json;
use scenario::agent::ScriptStep;
use scenario::{Criterion, Draw, Individual};
use sim::Ending;
use sim::measure::{Open, Presence};

/// The result of one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The run's key, which `scenario-runner replay` takes.
    pub key: String,
    /// The run's seed.
    #[serde(with = "json::whole")]
    pub seed: u64,
    /// The people who walked in it.
    pub individuals: Vec<Individual>,
    /// What its scenario drew for it, people last; empty of one that draws nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drawn: Vec<Draw>,
    /// When it ended, and why.
    pub ending: Ending,
    /// One per request, in their order; `None` where the metric does not exist in this run.
    pub metrics: Vec<Option<f64>>,
    /// When and for whom metrics had these values, of those for which there is something to say and that somebody may
    /// still ask for.
    #[serde(default, skip_serializing_if = "ByMetric::is_empty", with = "super::written_criticals")]
    pub critical: ByMetric<Critical>,
    /// What every vehicle and pedestrian had to do with each other, and the vehicles that a criterion names together.
    #[serde(default)]
    pub presences: Vec<PairPresence>,
    /// Steps of scripts that never began.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub waiting_steps: Vec<WaitingStep>,
    /// Vehicles whose body left their carriageway.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_road: Vec<Arc<str>>,
    /// Streams whose last vehicle had passed before somebody went across.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outlasted: Vec<Outlasted>,
    /// What the horizon, or a contact that ends runs, cut off, if that is anything.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cut_off: Option<Box<CutOff>>,
    /// See [`sim::Fingerprint`].
    #[serde(with = "json::hexadecimal")]
    pub fingerprint: u64,
    /// Wall-clock time that it took; 0 in blocks, whose results are the same bytes however long they took.
    #[serde(default, skip_serializing_if = "Duration::is_zero")]
    pub wall_time: Duration,
}

impl Outcome {
    /// What the metric with this index could still have come to, if the run ended before it was decided.
    pub fn open(&self, index: usize) -> Option<Open> {
        self.cut_off.as_ref()?.open.get(index).copied()
    }

    /// Whether it ended before somebody was through whom a vehicle had yet to meet: what criteria on meetings hold was not seen.
    pub fn hides_meetings(&self) -> bool {
        self.cut_off.as_ref().is_some_and(|cut| !cut.unfinished.is_empty() || !cut.on_course.is_empty())
    }

    /// What a vehicle and another road user had to do with each other; `None` if nothing is known of them.
    pub fn presence(&self, vehicle: &str, other: &str) -> Option<Presence> {
        let is_it = |pair: &&PairPresence| {
            (&*pair.vehicle, &*pair.other) == (vehicle, other)
                || pair.of_vehicles && (&*pair.vehicle, &*pair.other) == (other, vehicle)
        };
        self.presences.iter().find(is_it).map(|pair| pair.presence)
    }

    /// Forgets the critical instants of all metrics but those that criteria are about: there is one for each metric of each
    /// of maybe a million runs, and nobody asks for the others.
    pub fn forget_unasked(&mut self, criteria: &[Criterion], requests: &Requests) {
        let asked = |index: usize| {
            criteria.iter().any(|criterion| requests.as_slice().get(index) == Some(criterion.claim.metric()))
        };
        self.critical.retain(asked);
    }
}

/// A vehicle and another road user, and what they had to do with each other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairPresence {
    /// The vehicle's name.
    pub vehicle: Arc<str>,
    /// The name of the pedestrian, or of another vehicle that a criterion names together with this one.
    pub other: Arc<str>,
    /// Whether the other is a vehicle.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub of_vehicles: bool,
    /// How close they came.
    pub presence: Presence,
}

/// A step of a script that never began in a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct WaitingStep {
    /// The vehicle or pedestrian that follows the script.
    pub of: Arc<str>,
    /// The step.
    pub step: ScriptStep,
}

/// A stream whose last vehicle had passed before a pedestrian went across: which gap they would have taken was not seen.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outlasted {
    /// The stream's name.
    pub stream: Arc<str>,
    /// The pedestrian's name.
    pub pedestrian: Arc<str>,
}

/// What was going on when the horizon or a contact ended a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CutOff {
    /// What the metrics could still have come to that were not decided.
    pub open: ByMetric<Open>,
    /// Road users that were there, had not been hit, and had not arrived: pedestrians beyond all lanes, vehicles at the finish line, and of a
    /// stream only vehicles that stand.
    pub stranded: Vec<Arc<str>>,
    /// Who would have touched, the first first.
    pub on_course: Vec<OnCourse>,
    /// Whose encounters were not over.
    pub unfinished: Vec<Unfinished>,
}

/// A vehicle that had yet to pass, and a pedestrian who was not across its lane, had not been hit by it, or had yet to appear; or two
/// vehicles of which one was not through where their ways cross.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unfinished {
    /// The vehicle's name.
    pub vehicle: Arc<str>,
    /// The name of the pedestrian, or of the other vehicle.
    pub pedestrian: Arc<str>,
}

/// A vehicle and something else that would have touched, had both moved on as they did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OnCourse {
    /// The vehicle's name.
    pub vehicle: Arc<str>,
    /// The name of a pedestrian, another vehicle or a box.
    pub with: Arc<str>,
    /// From the end of the run to their contact, s.
    pub time: f64,
}
