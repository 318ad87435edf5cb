//! Randomness: seeds from names, and streams of draws from seeds.

mod draws;
mod rank;
mod seed;
mod stream;

pub use draws::Draws;
pub use rank::ranks;
pub use seed::{derive_seed, digest_bits};
pub use stream::{Stream, generator};
