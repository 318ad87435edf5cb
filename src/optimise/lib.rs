//! Bayesian optimisation by ask and tell: where to evaluate an expensive, noisy, constrained function next.
//!
//! [`Optimiser::ask`] proposes points, [`Optimiser::tell`] takes evaluations in; nothing here knows simulations or threads. The
//! method and the measurements behind it are in `docs/optimisation.md`.
//!
//! ```
//! use scenario_runner_optimise::{Definition, SearchDimension, Evaluation, Optimiser, Space};
//!
//! let space = Space::new(vec![SearchDimension::real("time_to_arrival", 2.0, 8.0)])?;
//! let mut optimiser = Optimiser::new(Definition { budget: 25, ..Definition::new(space, 7) })?;
//! while optimiser.stop_reason().is_none() {
//!     for proposal in optimiser.ask(1) {
//!         let time = proposal.point[0].number().unwrap();
//!         optimiser.tell(proposal.id, Evaluation::of((time - 5.0).powi(2)))?;
//!     }
//! }
//! let best = optimiser.best_predicted()?.unwrap();
//! assert!((best.point[0].number().unwrap() - 5.0).abs() < 0.1);
//! # Ok::<(), scenario_runner_optimise::Error>(())
//! ```

// What `clippy.toml` bans is banned from what is shipped; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

mod acquisition;
mod definition;
mod design;
mod findings;
mod history;
mod journal;
mod knowledge_gradient;
mod maximise;
mod models;
mod optimiser;
mod pareto;
mod random;
mod reference;
mod space;
pub mod surrogate;
#[cfg(test)]
mod tests;

pub use acquisition::Acquisition;
pub use definition::{Definition, Goal, ImprovementStop, InitialDesign, Method};
pub use findings::{Prediction, SlicePoint};
pub use history::{EvaluatedPoint, Evaluation, Margin, ObjectiveValue};
pub use journal::{Journal, run};
pub use optimiser::{OptimisationEnd, Optimiser, Proposal, ProposalOrigin};
pub use space::{Coordinate, LARGEST_DIMENSION_COUNT, Point, Range, SearchDimension, Space};

/// What can go wrong in the optimiser. Bad numbers told by evaluations are not among it: they count as undefined.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The space or a point has a wrong number of dimensions, or two of one name.
    #[error("{0}")]
    Dimensions(String),
    /// A dimension's range holds no choice.
    #[error("the range of dimension `{dimension}` is unusable: {reason}")]
    Range {
        /// Its name.
        dimension: String,
        /// What is wrong with the range, in words.
        reason: String,
    },
    /// A value is not in its dimension's range.
    #[error("dimension `{dimension}` is given {value}, expected {expected}")]
    Value {
        /// Its name.
        dimension: String,
        /// The value, as text.
        value: String,
        /// The values that fit, in words.
        expected: String,
    },
    /// A setting makes no sense.
    #[error("the optimisation cannot be run: {0}")]
    Definition(String),
    /// An evaluation does not fit the definition.
    #[error("the evaluation does not fit: {0}")]
    Evaluation(String),
    /// An evaluation of something that was not asked for, or was told already.
    #[error("proposal {0} is not pending: it was never asked for or is told already")]
    Unasked(u64),
    /// The surrogate cannot be fitted to these data.
    #[error("the surrogate cannot be fitted: {0}")]
    Surrogate(String),
    /// The journal cannot be read or written.
    #[error("journal {0}")]
    Journal(#[from] files::LogError),
    /// The journal holds something else than this run's evaluations.
    #[error("journal {path}, line {line}: {reason}")]
    JournalContent {
        /// The journal.
        path: String,
        /// Counted from 1; the header is the first.
        line: usize,
        /// What does not fit, in words.
        reason: String,
    },
}
