//! The blocks of a suite that build on each other: `search`, `tune`, `evaluate`, `estimate` and `statement`.
//!
//! A search looks for the values at which a metric is worst, person by person; a tune looks for controller parameters
//! that are best on a set of cases under constraints; an evaluation compares sets of parameters on the same cases; a
//! statement holds what a source says against all that. Each is a function of the suite and its seed: what
//! makes the runs, and when, changes nothing.

mod block;
mod calibrate;
mod cases;
mod claim;
mod context;
mod earlier;
mod error;
mod estimate;
mod evaluate;
mod journal;
mod journal_file;
mod needs;
mod overrides;
mod parameters;
mod plausible;
mod rehearsal;
mod rounds;
mod runs;
mod search;
mod searched;
mod statement;
#[cfg(test)]
mod tests;
mod tune;

pub use block::run_block;
pub use cases::CaseFile;
pub use context::{BlockProgress, Context, Silent, asked_by};
pub use earlier::EarlierResults;
pub use error::ExperimentError;
pub use needs::{Need, needs};
pub use overrides::apply as apply_settings;
pub use parameters::ParameterFile;
pub(crate) use rehearsal::{rehearse_searches, search_ends};
pub use search::run_search;
pub(crate) use search::search_group;
pub use searched::searched_case;
pub(crate) use searched::searched_groups;
