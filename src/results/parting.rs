//! Two runs on the same noise, laid side by side: where their courses part, and what both came to.

use serde::Serialize;

use super::outcome::Outcome;
use super::recording::Recording;
use super::story::ContactMoment;
use sim::{Command, Ending, Happening};

/// Beyond this two places are apart, m.
pub const PARTED_LENGTH: f64 = 0.1;
/// Beyond this two velocities are apart, m/s.
pub const PARTED_SPEED: f64 = 0.1;

/// Two runs on the same noise, side by side.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TwoRuns {
    /// The one.
    pub a: OneOfTwo,
    /// The other.
    pub b: OneOfTwo,
    /// What the two cases have otherwise, a few words each. None where nothing of the run depends on what was to be otherwise.
    pub differs: Vec<String>,
    /// The first moment at which anything differs; `None` where the courses are the same bit for bit.
    pub first: Option<Parting>,
    /// The first moment at which a place is more than 0.1 m apart or a velocity more than 0.1 m/s, somebody is there in one only, or one
    /// has ended.
    pub apart: Option<Parting>,
    /// What everybody does, at moments that are spread over the longer run.
    pub moments: Vec<SharedMoment>,
}

impl TwoRuns {
    /// Whether they are the same run, bit for bit.
    pub fn are_one(&self) -> bool {
        self.first.is_none()
    }
}

/// What one of two runs came to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OneOfTwo {
    /// All that was measured.
    #[serde(skip)]
    pub outcome: Outcome,
    /// Every contact of a vehicle, in the order of time.
    pub contacts: Vec<ContactMoment>,
    /// Its course, to be drawn.
    #[serde(skip)]
    pub recording: Recording,
}

/// A moment at which two runs part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parting {
    /// s
    pub time: f64,
    /// All that differs at that moment and did not before: where everybody is first, then sights, decisions and activities.
    pub by: Vec<PartsBy>,
}

/// Something that differs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartsBy {
    /// The road user's name; empty for the run as a whole.
    pub who: String,
    /// What it is.
    pub what: PartedIn,
}

/// What may differ of a road user.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PartedIn {
    /// It is there in one run only.
    Presence {
        /// Whether it is there in A; else it is in B.
        in_a: bool,
    },
    /// Where it is, or how it moves.
    Motion {
        /// How far apart the two are, m.
        apart: f64,
        /// How fast the two move against each other, m/s.
        relative_speed: f64,
        /// Its speed in A, m/s.
        a: f64,
        /// Its speed in B, m/s.
        b: f64,
    },
    /// What happens to it at this moment: whom it is shown to, what it touches. `None` where that is not so in that run.
    Event {
        /// In A.
        a: Option<Happening>,
        /// In B.
        b: Option<Happening>,
    },
    /// What a vehicle is told.
    Decision {
        /// In A; `None` before its first decision.
        a: Option<Command>,
        /// In B.
        b: Option<Command>,
    },
    /// The run as a whole: one ends, or each for another reason.
    Ending {
        /// How A ends.
        a: Ending,
        /// How B ends.
        b: Ending,
    },
}

/// A run against what a baseline keeps of it: the metrics of each run, with nine digits, and no course.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AgainstBaseline {
    /// What the run is made of otherwise than it was, a few words each.
    pub differs: Vec<String>,
    /// Whether the courses are the same bit for bit; `None` where that cannot be told, of a trial with several runs: a baseline keeps one
    /// number for the courses of all.
    pub same_course: Option<bool>,
    /// Every metric that is measured now and was then, in the order in which it is measured.
    pub metrics: Vec<MetricThen>,
    /// The metrics that are measured now and were not then, or otherwise.
    pub new: Vec<String>,
}

/// A metric of a run, then and now.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MetricThen {
    /// Its place among what is measured now.
    pub index: usize,
    /// SI units, nine digits.
    pub then: Option<f64>,
    /// With as many digits.
    pub now: Option<f64>,
}

/// What everybody does at one moment of both runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SharedMoment {
    /// s
    pub time: f64,
    /// Everybody, vehicles first.
    pub each: Vec<InBoth>,
}

/// A road user at one moment of both runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InBoth {
    /// Its name.
    pub who: String,
    /// In A; `None` where it is not there, or the run is over.
    pub a: Option<Doing>,
    /// In B.
    pub b: Option<Doing>,
}

/// Where a road user is, and what it does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Doing {
    /// m
    pub x: f64,
    /// m
    pub y: f64,
    /// m/s
    pub speed: f64,
    /// The model's own word for what it is up to.
    pub activity: String,
}
