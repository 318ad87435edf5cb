//! Results: what became of suites, as plain data.
//!
//! Whoever runs suites makes them and every report is a function of them; they know nothing of either.

// What `clippy.toml` bans is banned from what is shipped; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

mod block;
mod calibrate;
mod cases;
mod chosen;
mod controller;
mod critical;
mod cut;
mod estimate;
mod evaluate;
mod event;
mod finding;
mod fingerprint;
mod gap_choice;
mod gate;
pub mod judge;
mod outcome;
mod overall;
mod parting;
mod places;
mod rating;
mod recorded;
mod recording;
mod requests;
mod resolve;
mod search;
mod skip;
mod standing;
mod statement;
mod story;
mod suite;
mod summary;
mod trial;
mod tune;
mod unit_error;
mod verdict;
mod written_counts;
mod written_criticals;
mod written_details;

/// Everything that became of a session. Every report is a function of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Results {
    /// What was measured in every run, in the order of the outcomes' metrics.
    pub requests: Requests,
    /// One per suite, in the order in which they were given.
    pub suites: Vec<SuiteReport>,
    /// The courses of those runs that are drawn, in the order in which they were [chosen](choose_runs).
    pub recordings: Vec<(Chosen, Recording)>,
    /// Whether what passed without being put to the test does not count as passed (`--deny untested`).
    pub denies_untested: bool,
}

pub use block::{BlockReport, BlockResult, BlockState};
pub use calibrate::{
    CalibrateResult, CalibratedCondition, CalibratedParameter, CalibratedShare, ComparedPopulation,
    CountedRuns,
};
pub use cases::{CaseRun, MetricSummary, SavedCase, SavedSet};
pub use chosen::{Chosen, choose_runs};
pub use controller::{AnswerTimes, DifferingRun, TestedController};
pub use critical::{ByMetric, Critical};
pub use cut::{Cut, CutBy};
pub use estimate::{
    ComparedEstimate, EstimateResult, EstimatedClaim, EstimatedCluster, EstimatedRun, EventsPerDistance,
    RatioInterval,
};
pub use evaluate::{ConditionResult, Difference, EvaluateResult, ParameterValue, UntestedMeasures};
pub use event::{Evaluations, Event, Reporter, Unheard, UnitReport, Workload};
pub use finding::{Finding, FindingMeasure, Regarding, Untested, UntestedPair, WorstRun};
pub use gap_choice::{
    ALL_PEOPLE, ChosenGap, ChosenGaps, FittedTo, GapChoices, GapChooser, GapCondition, GapMeasure, GapUnit,
    PEOPLE_GROUPS, PeopleAtGaps, PeopleNumber, PeopleNumbers,
};
pub use gate::{
    BlindPlace, Change, ChangedRun, Check, CheckOutcome, ComparedSubject, GateReport, GateState, GateVerdict,
    Looks, NotJudged, Power, Refusal, TrialChange,
};
pub use outcome::{CutOff, OnCourse, Outcome, Outlasted, PairPresence, Unfinished, WaitingStep};
pub use overall::Overall;
pub use parting::{
    AgainstBaseline, Doing, InBoth, MetricThen, OneOfTwo, PARTED_LENGTH, PARTED_SPEED, PartedIn, Parting,
    PartsBy, SharedMoment, TwoRuns,
};
pub use places::Place;
pub use rating::{
    CellWorth, EarnedPoints, NotRated, PointsFinding, RatedCell, RatingReport, RatingResult, RatingState,
};
pub use recorded::{Recorded, RecordedReport, RecordedState, Rerun};
pub use recording::{PairCourse, Recording};
pub use requests::Requests;
pub use resolve::UnknownMetric;
pub use search::{
    CoursePoint, Found, FrontPoint, JudgedRun, JudgedSearch, MetricCourse, NO_ENCOUNTER, SearchResult,
    UsualEncounters,
};
pub use skip::{Skip, Stopping};
pub use standing::Standing;
pub use statement::{ClaimResult, ClaimValues, Conclusion, StatementResult, TrendPoint};
pub use story::{
    CameOf, ContactMoment, FirstSeen, Neighbour, Otherwise, OtherwiseRun, Story, TriedDeceleration, WhatIf,
};
pub use suite::{
    PeopleUsed, Program, SuiteIdentity, SuiteReport, TriedSeed, is_use, is_value, record_command, set_options,
};
pub use summary::{
    AppliedCriteria, MOST_SHOWN, NearestRun, PassedTrial, ScenarioSummary, StandingCount, SuiteSummary,
};
pub use trial::{
    CourseOfRun, Horizon, LeftRoad, OutlastedRuns, Reason, RunsTaken, Stranded, TrialReport, TrialState,
    TrialVerdict,
};
pub use tune::{BeforeAndAfter, Candidate, CandidateOrigin, TuneResult, UntestedConstraint, Violations};
pub use unit_error::{RunFault, UnitError};
pub use verdict::Verdict;
