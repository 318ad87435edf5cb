//! Running the units of suites, which are trials and blocks: several at a time, each after what it needs.
//!
//! Runs are made by an executor, and whatever is made of them here depends on their order alone. One thread hears of
//! everything that happens and tells it on in order, so that reports need no locks.

mod coordinator;
mod courses;
mod earlier;
mod gates;
mod looks;
mod on_demand;
mod pilot;
mod project_run;
mod ratings;
mod reporting;
mod schedule;
mod selection;
mod shared;
mod tested_programs;
mod trials;
mod unit;
mod unit_begun;
mod unit_run;

pub use coordinator::Orders;
pub use earlier::Usable;
pub use gates::{gate_key, judge_gates, judge_one_gate, measured_trials};
pub use on_demand::OnDemand;
pub use project_run::{Session, SessionError};
pub use selection::Selection;
pub use shared::{RunWatch, Runner};
pub use tested_programs::{nondeterministic, second_runs, tested_controllers};
pub use unit::{Unit, UnitKind, Units, Work, units, with_needs};
