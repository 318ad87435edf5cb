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

/// The deviates of one moment, drawn once however often they are read: each reader starts at the first.
#[derive(Debug)]
pub struct DrawnOnce<'a, D> {
    drawn: &'a mut Vec<f64>,
    read: usize,
    source: &'a mut D,
}

impl<'a, D: StandardNormals> DrawnOnce<'a, D> {
    /// The deviates `drawn` so far, to be read on after the first `read`; more come from `source`.
    pub fn from(drawn: &'a mut Vec<f64>, read: usize, source: &'a mut D) -> Self {
        Self { drawn, read, source }
    }

    /// How many were read.
    pub fn read(&self) -> usize {
        self.read
    }

    /// The moment is over: those that were read are used up. Others, which only somebody who did not decide has read,
    /// are the first of the next moment, so that they shift nothing.
    pub fn forget_read(self) {
        self.drawn.drain(..self.read);
    }
}

impl<D: StandardNormals> StandardNormals for DrawnOnce<'_, D> {
    fn next_normal(&mut self) -> f64 {
        if self.read == self.drawn.len() {
            self.drawn.push(self.source.next_normal());
        }
        self.read += 1;
        self.drawn[self.read - 1]
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

impl StandardNormals for numbers::random::Stream {
    fn next_normal(&mut self) -> f64 {
        self.normal()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reader_reads_the_same_deviates_and_only_those_that_counted_are_used_up() {
        let recorded = [1.0, 2.0, 3.0, 4.0];
        let mut source = RecordedDraws::new(&recorded);
        let mut drawn = Vec::new();
        let mut moment = |count: usize, counts: bool| {
            let mut reader = DrawnOnce::from(&mut drawn, 0, &mut source);
            let read: Vec<f64> = (0..count).map(|_| reader.next_normal()).collect();
            if counts {
                reader.forget_read();
            }
            read
        };
        assert_eq!(moment(3, false), [1.0, 2.0, 3.0]);
        assert_eq!(moment(1, true), [1.0]);
        assert_eq!(moment(3, true), [2.0, 3.0, 4.0]);
        assert!(drawn.is_empty() && source.is_used_up());
    }
}
