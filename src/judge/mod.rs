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
mod single;
mod span;
mod stopping;
mod trivial;
mod vacuity;

pub use criteria::{aggregate, aggregate_against, counted, judge, undecided};
pub use horizon::cut_off_runs;
pub use nearest::RunStanding;
pub use per_run::{PerRun, per_run};
pub use seen::{Seen, holds, holds_undefined};
pub use span::{Span, open_runs, span_of};
pub use stopping::Watch;

use crate::lang::{Diagnostic, Sources};
use crate::scenario::Suite;

/// Everything that is wrong with what a suite claims, before anything runs: criteria that can never pass, cannot fail, apply to
/// nothing or ask too few runs, and lanes that are blocked. What cannot be planned is left to planning.
pub fn examine_claims(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let mut found = budget::examine_criteria(suite, sources);
    found.extend(trivial::examine_bounds(suite, sources));
    found.extend(single::examine_single_runs(suite, sources));
    found.extend(lanes::examine_lanes(suite, sources));
    found
}
