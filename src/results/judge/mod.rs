//! Criteria over a trial's outcomes: verdicts, with how far from failing and which runs were worst. Baselines, and gates
//! that compare with them.

pub mod baseline;
mod confidence;
#[cfg(test)]
mod coverage;
mod criteria;
pub mod gate;
mod horizon;
mod nearest;
mod neighbour;
mod not_as_declared;
mod overlap;
mod per_run;
mod possible;
mod rating;
mod seen;
mod span;
mod stopping;
mod untested;

pub use confidence::{Bounds, decide};
pub use criteria::{aggregate, aggregate_against, judge, objective_against, undecided};
pub use horizon::cut_off_runs;
pub use nearest::RunStanding;
pub use neighbour::nearest_passing;
pub use overlap::measured_beside;
pub use per_run::{PerRun, per_run};
pub use possible::{Possible, possible};
pub use rating::judge_rating;
pub use seen::{Seen, holds, holds_undefined};
pub use span::{ValueSpan, open_runs, span_of};
pub use stopping::Watch;
pub use untested::{comparison_untested_by, has_encounter, untested_by};
