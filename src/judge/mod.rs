//! Criteria over a trial's outcomes: verdicts, with how far from failing and which runs were worst.

mod budget;
mod confidence;
mod criteria;
mod per_run;
pub mod statistics;
mod verdict;

pub use budget::{Needed, examine_criteria, runs_needed};
pub use criteria::{Finding, Measure, TrialVerdict, WorstRun, aggregate, holds, judge};
pub use per_run::{PerRun, per_run};
pub use verdict::Verdict;
