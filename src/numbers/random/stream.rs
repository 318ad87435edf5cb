//! Streams of random draws: as many as there are numbers under one seed, portable and independent of execution order.
//!
//! ChaCha8 is seekable and named, so its bits are the same on every platform and in every version; the normal
//! deviates come from an inverse distribution function on `libm`, for the same reason.

use rand::Rng;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use crate::distributions::normal;

/// An endless sequence of draws.
#[derive(Debug)]
pub struct Stream(ChaCha8Rng);

/// The generator behind stream `number` of the 2^64 independent ones under `seed`, for what draws as `rand` does.
pub fn generator(seed: u64, number: u64) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(number);
    generator
}

impl Stream {
    /// The only stream of its seed, for planning and resampling.
    pub fn seeded(seed: u64) -> Self {
        Self::numbered(seed, 0)
    }

    /// Stream `number` of the 2^64 independent ones under `seed`.
    pub fn numbered(seed: u64, number: u64) -> Self {
        Self(generator(seed, number))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in the open interval (0, 1).
    pub fn uniform(&mut self) -> f64 {
        open_unit(self.0.next_u64())
    }

    /// Uniform in (low, high).
    pub fn uniform_in(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Uniform in 0..count; `count` must not be 0.
    pub fn index(&mut self, count: usize) -> usize {
        // The bias is below count / 2^52.
        ((self.uniform() * count as f64) as usize).min(count - 1)
    }

    /// Leaves `count` of the items (or all, if there are fewer), drawn without replacement, in the order of drawing. A
    /// smaller draw from the same stream is the beginning of a larger one.
    pub fn draw<T>(&mut self, items: &mut Vec<T>, count: usize) {
        let count = count.min(items.len());
        for place in 0..count {
            let other = place + self.index(items.len() - place);
            items.swap(place, other);
        }
        items.truncate(count);
    }

    /// Standard normal.
    pub fn normal(&mut self) -> f64 {
        normal::quantile(self.uniform())
    }
}

/// The middle of one of 2^52 equal cells of (0, 1), by the upper bits.
fn open_unit(bits: u64) -> f64 {
    ((bits >> 12) as f64 + 0.5) * (1.0 / (1u64 << 52) as f64)
}

#[cfg(test)]
mod tests {
    use super::super::Draws;
    use super::*;

    #[test]
    fn streams_differ_by_seed_and_number_and_repeat() {
        let first = |seed, number| Stream::numbered(seed, number).bits();
        assert_eq!(first(1, 2), first(1, 2));
        assert_ne!(first(1, 2), first(2, 2));
        assert_ne!(first(1, 2), first(1, 3));
        assert_eq!(Stream::seeded(9).bits(), ChaCha8Rng::seed_from_u64(9).next_u64());
    }

    #[test]
    fn uniform_draws_never_reach_the_ends() {
        assert!(open_unit(0) > 0.0 && open_unit(u64::MAX) < 1.0);
        let mut stream = Stream::seeded(3);
        assert!((0..10_000).map(|_| stream.uniform()).all(|u| u > 0.0 && u < 1.0));
    }

    #[test]
    fn orders_are_equally_likely() {
        let mut stream = Stream::seeded(11);
        let mut counts = std::collections::BTreeMap::new();
        for _ in 0..24_000 {
            *counts.entry(stream.shuffled(4)).or_insert(0_u32) += 1;
        }
        // 1000 of each of the 24, with a standard deviation of 31.
        assert_eq!(counts.len(), 24);
        assert!(counts.values().all(|count| (850..1150).contains(count)), "{counts:?}");
    }

    #[test]
    fn a_smaller_draw_begins_a_larger_one() {
        let draw = |count| {
            let mut items: Vec<u32> = (0..50).collect();
            Stream::seeded(4).draw(&mut items, count);
            items
        };
        assert_eq!(draw(7), draw(30)[..7]);
        let mut all = draw(80);
        all.sort_unstable();
        assert_eq!(all, (0..50).collect::<Vec<_>>());
    }

    #[test]
    fn moments_of_the_normal_draws() {
        let mut stream = Stream::seeded(7);
        let n = 200_000;
        let draws: Vec<_> = (0..n).map(|_| stream.normal()).collect();
        let mean = draws.iter().sum::<f64>() / f64::from(n);
        let variance = draws.iter().map(|z| z * z).sum::<f64>() / f64::from(n);
        assert!(mean.abs() < 0.01 && (variance - 1.0).abs() < 0.01, "{mean} {variance}");
    }
}
