//! Running the units of suites, which are trials and blocks: several at a time, each after what it needs.
//!
//! Workers run units; one thread hears of everything that happens and tells it on in order, so that reports need no
//! locks. A worker that has no unit to begin runs cases of the trials under way; the worker that began a trial takes in what
//! came of them in their order. So results do not depend on the number of workers.

mod dispatcher;
mod gates;
mod kept;
mod schedule;
mod unit;
mod workshop;

pub use dispatcher::{Orders, dispatch};
pub use gates::{gate_key, judge_gates, judge_one_gate, measured_trials};
pub use kept::Kept;
pub use unit::{Unit, Work, units, with_needs};
pub use workshop::{Watch, Workshop};
