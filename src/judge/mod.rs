//! Criteria over a trial's outcomes: verdicts, with how far from failing and which runs were worst. Baselines, and gates
//! that compare with them.

pub mod baseline;
mod budget;
mod confidence;
#[cfg(test)]
mod coverage;
mod criteria;
pub mod gate;
mod horizon;
mod lanes;
mod nearest;
mod per_run;
mod seen;
pub mod statistics;
mod stopping;
mod vacuity;
mod verdict;

pub use budget::examine_criteria;
pub use criteria::{Finding, Measure, Regarding, TrialVerdict, aggregate, judge};
pub use horizon::{Horizon, Stranded};
pub use lanes::examine_lanes;
pub use nearest::{RunStanding, WorstRun};
pub use per_run::{PerRun, per_run};
pub use seen::{Seen, holds, holds_undefined};
pub use stopping::{Reason, Stopping, Watch};
pub use vacuity::Vacuity;
pub use verdict::Verdict;
