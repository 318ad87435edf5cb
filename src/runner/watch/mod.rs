//! Suites that are run again when what they read has changed: what is to run, and since when nothing changes any more.
//!
//! Both are data that are told what happens and say what is to be done. They look at no file, run nothing and know no clock.

mod agenda;
mod quiet;

pub use agenda::{Agenda, Extent, SuiteState};
pub use quiet::Quiet;
