//! Where the optimiser's randomness comes from: one portable generator per proposal and purpose, so nothing depends on order.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// What a stream of random numbers is used for. Each purpose of each proposal has a stream of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    Design = 0,
    Candidates = 1,
    Fantasies = 2,
    Hedge = 3,
    Weights = 4,
}

const PURPOSES: u64 = 8;

/// The generator of one purpose at one proposal (or 0 for what belongs to the whole run).
pub(super) fn stream(seed: u64, proposal: u64, purpose: Purpose) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(proposal * PURPOSES + purpose as u64);
    generator
}

/// Independent standard normal numbers by the Box–Muller transform, with portable transcendental functions.
pub(super) fn fill_normal(generator: &mut ChaCha8Rng, out: &mut [f64]) {
    for pair in out.chunks_mut(2) {
        let uniform = 1.0 - generator.random::<f64>();
        let radius = (-2.0 * libm::log(uniform)).sqrt();
        let angle = std::f64::consts::TAU * generator.random::<f64>();
        pair[0] = radius * libm::cos(angle);
        if let Some(second) = pair.get_mut(1) {
            *second = radius * libm::sin(angle);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_and_repeat() {
        let draw = |seed, proposal, purpose| stream(seed, proposal, purpose).random::<u64>();
        assert_eq!(draw(1, 2, Purpose::Design), draw(1, 2, Purpose::Design));
        assert_ne!(draw(1, 2, Purpose::Design), draw(1, 3, Purpose::Design));
        assert_ne!(draw(1, 2, Purpose::Design), draw(1, 2, Purpose::Fantasies));
        assert_ne!(draw(1, 2, Purpose::Design), draw(2, 2, Purpose::Design));
    }

    #[test]
    fn normal_numbers_have_mean_zero_and_variance_one() {
        let mut numbers = vec![0.0; 20_001];
        fill_normal(&mut stream(3, 0, Purpose::Fantasies), &mut numbers);
        let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
        let variance = numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / numbers.len() as f64;
        assert!(mean.abs() < 0.025, "{mean}");
        assert!((variance - 1.0).abs() < 0.04, "{variance}");
    }
}
