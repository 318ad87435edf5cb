//! Runs that failed, kept in a file beside their suite (`zebra.failures` beside `zebra.suite`) and run first from then on.
//!
//! A record says what decided the run in the terms of the scenario, so that it outlives another seed of the suite; and it
//! has the hash of the case and the fingerprint of the run, so that it can be said whether it is still the same one.

mod file;
mod record;

pub use file::{CorpusError, corpus_path, is_unchecked, read_corpus, write_corpus};
pub use record::{Stale, case_hash, criteria, record, revive};
