//! Criteria over a trial's outcomes: verdicts, with how far from failing and which runs were worst.

mod confidence;
mod criteria;
pub mod statistics;
mod verdict;

pub use criteria::{Finding, Measure, TrialVerdict, WorstRun, aggregate, holds, judge};
pub use verdict::Verdict;
