//! When a vehicle reached which place: the record that answers for places known only later.

use serde::{Deserialize, Serialize};

/// The course of one vehicle along its lane.
///
/// A conflict point is known only once the pedestrian passes it, which may be after the vehicle. So one number per
/// step is kept: exact for any place, where a coarser record would have to guess near standstill.
#[derive(Debug, Clone)]
pub struct Passage {
    /// Time (s) and distance travelled (m), both rising; a standstill takes two knots however long it lasts.
    knots: Vec<(f64, f64)>,
}

/// When a place was reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reached {
    /// It lies at or behind the start.
    BeforeStart,
    /// s
    At(f64),
    /// It has not come so far.
    NotYet,
}

impl Passage {
    /// Room for a run of `steps` steps, so that none of them allocates.
    pub fn with_capacity(steps: usize) -> Self {
        Self { knots: Vec::with_capacity(steps + 1) }
    }

    /// Notes a step from (time, travelled) to the next.
    pub fn observe(&mut self, from: (f64, f64), to: (f64, f64)) {
        if self.knots.is_empty() {
            self.knots.push(from);
        }
        // Where a vehicle is steered back, the places that it comes by again were reached before.
        let to = (to.0, self.knots.last().map_or(to.1, |last| to.1.max(last.1)));
        match self.knots.as_mut_slice() {
            [.., before, last] if before.1 == last.1 && last.1 == to.1 => last.0 = to.0,
            _ => self.knots.push(to),
        }
    }

    /// When the centre first was `travelled` m behind the middle of the crossing; linear inside a step.
    pub fn reached(&self, travelled: f64) -> Reached {
        let next = self.knots.partition_point(|knot| knot.1 < travelled);
        match (next.checked_sub(1), self.knots.get(next)) {
            (_, None) => Reached::NotYet,
            (None, Some(_)) => Reached::BeforeStart,
            (Some(last), Some(&(to_time, to))) => {
                let (from_time, from) = self.knots[last];
                Reached::At(from_time + (travelled - from) / (to - from) * (to_time - from_time))
            }
        }
    }
}

impl Reached {
    /// s; `None` if it was not reached during the run.
    pub fn time(self) -> Option<f64> {
        match self {
            Self::At(time) => Some(time),
            Self::BeforeStart | Self::NotYet => None,
        }
    }

    /// As a moment that can be compared: minus infinity before the start, infinity if not yet.
    pub fn moment(self) -> f64 {
        match self {
            Self::BeforeStart => f64::NEG_INFINITY,
            Self::At(time) => time,
            Self::NotYet => f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standstill_delays_what_lies_behind_it_only() {
        let mut passage = Passage::with_capacity(4);
        let course = [(0.0, 0.0), (1.0, 4.0), (2.0, 4.0), (3.0, 4.0), (4.0, 4.0), (5.0, 6.0)];
        for pair in course.windows(2) {
            passage.observe(pair[0], pair[1]);
        }
        assert_eq!(passage.knots.len(), 4);
        assert_eq!(passage.reached(2.0), Reached::At(0.5));
        assert_eq!(passage.reached(4.0), Reached::At(1.0));
        assert_eq!(passage.reached(5.0), Reached::At(4.5));
        assert_eq!(passage.reached(-1.0), Reached::BeforeStart);
        assert_eq!(passage.reached(6.1), Reached::NotYet);
    }
}
