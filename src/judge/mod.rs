//! Criteria over a trial's outcomes: verdicts, with how far from failing and which runs were worst.

mod confidence;
mod criteria;
pub mod statistics;

pub use criteria::{Finding, Measure, TrialVerdict, Verdict, WorstRun, aggregate, judge};
