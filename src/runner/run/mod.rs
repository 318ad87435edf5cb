//! Executing cases: road users built from registered models, metrics read off, on whatever an executor runs them on.

mod batch;
mod build;
mod case;
mod case_run;
mod chance;
mod cut_off;
mod departure;
mod encoding;
mod executor;
mod first_runs;
mod free_flow;
mod from_results;
mod job;
mod lockstep;
mod messagepack;
mod name;
mod panic;
mod program_build;
mod program_run;
mod rehearsal;
mod remembered;
mod run_digest;
mod sequence;
mod serialised;
mod shared_rounds;
mod shuffled;
mod stop;
mod stored_run;
#[cfg(test)]
mod tests;
mod threads;

pub use batch::{BatchError, RunBatch};
pub use build::{RunError, road_users};
pub use case::{Unwatched, run_case};
pub use chance::{drawing, nothing_is_drawn};
pub(crate) use departure::Departing;
pub use departure::departures;
pub use encoding::{DecodingError, EncodedBy};
pub use executor::{Executor, Round};
pub use first_runs::{FirstRun, FirstRuns, VerifyRuns};
pub use free_flow::FreeFlows;
pub use from_results::{AbsentRuns, FromResults, RunResults};
pub use job::{
    Done, Job, JobFailure, JobPlace, LoggedDecision, MeasuredMetrics, Ran, Wanted, WentDifferently, programs,
    went_differently,
};
pub(crate) use messagepack::to_messagepack;
pub use panic::{Panicked, note_places};
pub use program_build::Build;
pub(crate) use rehearsal::{Obstacle, Rehearsal, Stage, rehearse, rehearse_trials};
pub(crate) use remembered::Remembered;
pub use run_digest::{RunDigest, RunDigests};
pub(crate) use sequence::{Sequence, Sequences, run_sequences};
pub use serialised::Serialised;
pub use shared_rounds::Sharing;
pub use shuffled::Shuffled;
pub use stop::Stop;
pub(crate) use stored_run::Disagreement;
pub use stored_run::StoredRun;
pub use threads::Threads;
