//! Criteria over a trial's outcomes: verdicts, with how far from failing and which runs were worst. Baselines, and gates
//! that compare with them.

pub mod baseline;
mod budget;
mod confidence;
mod criteria;
pub mod gate;
mod nearest;
mod per_run;
pub mod statistics;
mod stopping;
mod vacuity;
mod verdict;

pub use budget::examine_criteria;
pub use criteria::{Finding, Measure, TrialVerdict, aggregate, holds, judge};
pub use nearest::{RunStanding, WorstRun};
pub use per_run::{PerRun, per_run};
pub use stopping::{Reason, Stopping, Watch};
pub use vacuity::Vacuity;
pub use verdict::Verdict;
