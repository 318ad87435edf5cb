//! Where the noise comes from: standard-normal draws, injected so that recorded ones can be replayed.

/// A source of standard-normal draws, asked in the order of §3 and §8.
pub trait StandardNormals {
    /// The next draw from N(0, 1).
    fn next_normal(&mut self) -> f64;
}

impl<S: StandardNormals + ?Sized> StandardNormals for &mut S {
    fn next_normal(&mut self) -> f64 {
        (**self).next_normal()
    }
}

/// Draws recorded elsewhere, replayed in order.
#[derive(Clone, Debug)]
pub struct RecordedDraws<'a> {
    draws: &'a [f64],
    taken: usize,
}

impl<'a> RecordedDraws<'a> {
    /// Replays `draws` from the first.
    pub fn new(draws: &'a [f64]) -> Self {
        Self { draws, taken: 0 }
    }

    /// How many draws were asked for, which may be more than were recorded.
    pub fn taken(&self) -> usize {
        self.taken
    }

    /// Whether exactly the recorded draws were asked for.
    pub fn is_used_up(&self) -> bool {
        self.taken == self.draws.len()
    }
}

impl StandardNormals for RecordedDraws<'_> {
    /// The next recorded draw; NaN, which spreads into everything, when there are no more.
    fn next_normal(&mut self) -> f64 {
        let draw = self.draws.get(self.taken).copied().unwrap_or(f64::NAN);
        self.taken += 1;
        draw
    }
}

impl StandardNormals for crate::sim::random::Stream {
    fn next_normal(&mut self) -> f64 {
        self.normal()
    }
}
