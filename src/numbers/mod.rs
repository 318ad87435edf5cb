//! Numbers that chance has a part in: seeds and streams, designs, distributions, summaries, intervals and tests.
//!
//! Pure functions: the same numbers in give the same numbers out. What is random is drawn from a given seed. The room knows
//! nothing of simulations and imports no other one.

pub mod design;
pub mod distributions;
pub mod inference;
pub mod json;
pub mod random;
pub mod summary;
