//! What there is to tell of one run: who saw whom when, what happened, and what would have come of it had something gone otherwise.

use serde::Serialize;

use super::outcome::Outcome;
use sim::{TimelineEvent, Trace};

/// The story of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Story {
    /// What it came to.
    #[serde(skip)]
    pub outcome: Outcome,
    /// Where everybody was.
    #[serde(skip)]
    pub trace: Trace,
    /// What happened, in the order of time.
    pub events: Vec<TimelineEvent>,
    /// Who was first shown whom, in the order of time.
    pub first_seen: Vec<FirstSeen>,
    /// The first contact that a vehicle had a part in.
    pub contact: Option<ContactMoment>,
    /// What would have come of it.
    pub otherwise: Vec<WhatIf>,
}

/// The first time at which a vehicle was shown a pedestrian.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FirstSeen {
    /// The vehicle's name.
    pub vehicle: String,
    /// The pedestrian's name.
    pub pedestrian: String,
    /// s; `None` if it never was.
    pub time: Option<f64>,
    /// From the vehicle's centre to the pedestrian's then, m.
    pub distance: Option<f64>,
    /// The vehicle's then, m/s.
    pub speed: Option<f64>,
    /// Whether it sees everything at once, so that this is when the pedestrian appears.
    pub sees_everything: bool,
}

/// A contact of a vehicle; of two vehicles that touch, of the one that moves towards the other faster.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ContactMoment {
    /// s
    pub time: f64,
    /// The vehicle's name.
    pub vehicle: String,
    /// What it touches.
    pub with: String,
    /// How fast the two move against each other, m/s.
    pub relative_speed: f64,
    /// The vehicle's, m/s.
    pub speed: f64,
    /// Where the centre of what it touches is, m, if that is a pedestrian; else where its own is.
    pub place: (f64, f64),
}

/// What would have come of a run if something had gone otherwise, everybody else reacting as they do on the same noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WhatIf {
    /// What goes otherwise.
    pub what: Otherwise,
    /// What came of it.
    pub came: CameOf,
}

/// What goes otherwise.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Otherwise {
    /// A vehicle is told to brake earlier.
    BrakesEarlier {
        /// Its name.
        vehicle: String,
        /// s
        by: f64,
        /// The moment from which on it is, s.
        from: Option<f64>,
    },
    /// A vehicle decelerates evenly from a moment on.
    Decelerates {
        /// Its name.
        vehicle: String,
        /// s
        from: Option<f64>,
        /// Whether that is when the vehicle began to brake for the other party; else it is when the vehicle first saw it.
        is_first_braking: bool,
    },
    /// A pedestrian appears later.
    AppearsLater {
        /// Their name.
        pedestrian: String,
        /// s
        by: f64,
    },
    /// No pedestrian appears.
    NobodyAppears,
}

/// What came of something that goes otherwise.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CameOf {
    /// It does not apply to the run.
    DoesNotApply {
        /// Why.
        because: String,
    },
    /// A run was made.
    Run(Box<OtherwiseRun>),
    /// Runs were made at several decelerations, the smallest first.
    Decelerations(Vec<TriedDeceleration>),
}

/// How a run at one deceleration went.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TriedDeceleration {
    /// m/s²
    pub deceleration: f64,
    /// What came of it.
    #[serde(flatten)]
    pub run: OtherwiseRun,
}

/// How a run went in which something went otherwise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OtherwiseRun {
    /// Whether it has all that is wanted of it, if anything is.
    pub passes: bool,
    /// How many criteria want something of it; those on meetings do not where nobody comes.
    pub criteria: usize,
    /// What it does not have, in canonical words.
    pub against: Vec<String>,
    /// What it came to, if it came to its end.
    #[serde(skip)]
    pub outcome: Option<Outcome>,
    /// How fast a vehicle touched something, m/s; `None` if none did.
    pub contact: Option<f64>,
    /// Whether it ended before somebody was through whom a vehicle had yet to meet.
    pub cut_off: bool,
    /// Why it did not come to its end, if it did not; then nothing else is said.
    pub error: Option<String>,
}

/// A run that passed among others that were made.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Neighbour {
    /// Its key.
    pub key: String,
    /// What it has otherwise: name, the value there, and the value here.
    pub differences: Vec<(String, String, String)>,
}
