//! Where the optimiser's randomness comes from: one portable generator per proposal and purpose, so nothing depends on order.

use rand::rngs::ChaCha8Rng;

use numbers::random::generator;

/// What a stream of random numbers is used for. Each purpose of each proposal has a stream of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    Design = 0,
    Candidates = 1,
    Hedge = 3,
    Weights = 4,
}

const PURPOSES: u64 = 8;

/// The generator of one purpose at one proposal (or 0 for what belongs to the whole run).
pub(super) fn stream(seed: u64, proposal: u64, purpose: Purpose) -> ChaCha8Rng {
    generator(seed, proposal * PURPOSES + purpose as u64)
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    #[test]
    fn streams_differ_and_repeat() {
        let draw = |seed, proposal, purpose| stream(seed, proposal, purpose).random::<u64>();
        assert_eq!(draw(1, 2, Purpose::Design), draw(1, 2, Purpose::Design));
        assert_ne!(draw(1, 2, Purpose::Design), draw(1, 3, Purpose::Design));
        assert_ne!(draw(1, 2, Purpose::Design), draw(1, 2, Purpose::Candidates));
        assert_ne!(draw(1, 2, Purpose::Design), draw(2, 2, Purpose::Design));
    }
}
