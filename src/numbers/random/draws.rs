//! What designs draw, from a stream of ours or as `rand` does: both have seeds that users stored.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;

use super::Stream;

/// Uniform draws, and orders made of them.
pub trait Draws {
    /// Uniform between 0 and 1.
    fn uniform(&mut self) -> f64;

    /// Uniform in 0..count; `count` is not 0.
    fn index(&mut self, count: usize) -> usize;

    /// 0..count in random order.
    fn shuffled(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            order.swap(last, self.index(last + 1));
        }
        order
    }
}

/// In the open interval: 0 never comes.
impl Draws for Stream {
    fn uniform(&mut self) -> f64 {
        Stream::uniform(self)
    }

    fn index(&mut self, count: usize) -> usize {
        Stream::index(self, count)
    }
}

/// As `rand` draws them: 0 may come, and no index is likelier than another.
impl Draws for ChaCha8Rng {
    fn uniform(&mut self) -> f64 {
        self.random()
    }

    fn index(&mut self, count: usize) -> usize {
        self.random_range(0..count)
    }
}
