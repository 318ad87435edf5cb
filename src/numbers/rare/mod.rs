//! Probabilities of rare events: where to look, what every run weighs, and what may be said of it.
//!
//! A run is a function of a point with one coordinate an axis, each uniform between 0 and 1. [`ImportanceSampling`],
//! [`SplittingSampling`] and [`CrudeSampling`] ask for points and are told what became of them; none knows what makes the runs.

mod crude;
mod estimate;
mod importance;
mod paired;
mod pilot;
mod proposal;
mod sampling;
mod space;
mod splitting;
#[cfg(test)]
mod tests;

pub use crude::CrudeSampling;
pub use estimate::{
    CONTRADICTION, LARGEST_DEVIATION, LARGEST_SHARE, LEAST_EFFECTIVE, RareEstimate, RareRefusal, RareScale,
    ReplicateRuns, WeighedHit, leaving_out,
};
pub use importance::ImportanceSampling;
pub use paired::{PairedEvent, PairedRareEstimate, RarePart};
pub use sampling::{RareOutcome, RarePoint, RareRound, RareSampling};
pub use space::{RareAxis, RareSpace};
pub use splitting::SplittingSampling;

/// Independent replicates that every estimate is made of, each unbiased.
pub const REPLICATES: usize = 20;

/// Fewer runs than this are not enough for [`REPLICATES`] that say anything.
pub const FEWEST_RUNS: usize = 1000;
