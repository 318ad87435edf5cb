//! Numbers on the command line that would be mistakes.

use clap::builder::RangedU64ValueParser;

/// More threads than this are no help on any machine, and no machine starts them at will.
const MOST_THREADS: u64 = 1024;

/// For the number of threads.
pub fn threads() -> RangedU64ValueParser<usize> {
    RangedU64ValueParser::new().range(1..=MOST_THREADS)
}

/// For how many there are to be of something, of which none would be nothing to do.
pub fn some() -> RangedU64ValueParser<usize> {
    RangedU64ValueParser::new().range(1..)
}
