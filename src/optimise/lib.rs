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
mod choice;
mod definition;
mod design;
mod error;
mod findings;
mod history;
mod journal;
mod knowledge_gradient;
mod maximise;
mod models;
mod optimiser;
mod pareto;
#[cfg(test)]
mod plateau_tests;
mod random;
mod reference;
mod space;
pub mod surrogate;
#[cfg(test)]
mod tests;

pub use acquisition::Acquisition;
pub use choice::{Reevaluated, SamplingError, WorseBy, choose};
pub use definition::{Definition, Goal, ImprovementStop, InitialDesign, Method};
pub use error::Error;
pub use findings::{Fitted, Prediction, SlicePoint};
pub use history::{EvaluatedPoint, Evaluation, Margin, ObjectiveValue};
pub use journal::{Journal, run};
pub use optimiser::{OptimisationEnd, Optimiser, Proposal, ProposalOrigin};
pub use pareto::non_dominated;
pub use space::{Coordinate, LARGEST_DIMENSION_COUNT, Point, Range, SearchDimension, Space};
