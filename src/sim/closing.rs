//! When a gap closes: by looks that no contact can hide between, and, near a contact, at whole numbers of a unit.
//!
//! Both are counted from zero and not from where a search begins, so that what is found does not depend on that: a search may leave out
//! whatever is known to be free.

use super::geometry::Footprint;

/// A moment is found to this, s, as is a place, m: a whole power of two, so that multiples of it have no rounding.
const UNIT: f64 = 1.0 / (1_u64 << 40) as f64;

/// A gap is worked out to this, m, and far better.
pub(super) const ROUNDING_OF_GAPS: f64 = 1e-6;

/// Outlines that are nearer than this are looked at by their sides alone, m.
const FAR: f64 = 0.5;

/// Between two outlines, m: no more than it is, and 0 or less where they touch.
pub(super) fn gap_between(one: &Footprint, other: &Footprint) -> f64 {
    let of_sides = one.separation(other);
    if of_sides <= FAR {
        return of_sides;
    }
    of_sides.max((other.centre - one.centre).norm() - one.radius() - other.radius())
}

/// Where a gap is at least so wide it is not worked out better than roughly, m.
const WIDE: f64 = 0.02;

/// The first moment between two at which a gap closes that grows no faster than `fastest` (m/s), s, and is no smaller than it is
/// `roughly`. It is looked at both ends and
/// at multiples of `least` (s, a power of two): what only grazes between two of them is no contact. Where it is `expected` to close it is looked at
/// sooner, which changes nothing of what is found.
pub(super) fn closes(
    gap: impl Fn(f64) -> f64,
    roughly: impl Fn(f64) -> f64,
    fastest: f64,
    (from, to): (f64, f64),
    least: f64,
    expected: Option<f64>,
) -> Option<f64> {
    let (mut before, mut time) = ((from, f64::INFINITY), from);
    // A power of two, by which nothing is rounded.
    let most = 1.0 / least;
    loop {
        let least_left = roughly(time);
        let left = if least_left > WIDE { least_left } else { gap(time) };
        if left <= 0.0 {
            return Some(if time > from {
                moment(gap, before, (time, left), expected).min(to)
            } else {
                time
            });
        }
        // Nothing that is farther apart than all that is left of the way closes any more.
        if time >= to || left > fastest * (to - time) * (1.0 + 1e-9) + ROUNDING_OF_GAPS {
            return None;
        }
        before = (time, left);
        let following = (time * most).floor() + 1.0;
        time = (((time + left / fastest) * most).floor().max(following) * least).min(to);
    }
}

/// The last multiple of `least` up to a moment.
pub(super) fn look_before(moment: f64, least: f64) -> f64 {
    (moment / least).floor() * least
}

/// Looks by the false position, at most; what is left is found by halves.
const AIMED: usize = 24;

/// The first whole number of units at which a gap is closed that is open at one moment and closed at another.
fn moment(
    gap: impl Fn(f64) -> f64,
    (open, left): (f64, f64),
    (closed, inside): (f64, f64),
    expected: Option<f64>,
) -> f64 {
    let mut between = Bracket::new(((open / UNIT).floor(), left), ((closed / UNIT).ceil(), inside));
    let look = |at: f64| gap(at * UNIT);
    if let Some(expected) = expected.map(|moment| (moment / UNIT).round()) {
        // It is right to a unit or two, for rounding.
        for at in [expected, expected - 1.0, expected + 1.0] {
            between.learn(at, look);
        }
    }
    for aimed in 0.. {
        let Some(at) = between.next(aimed < AIMED) else { break };
        between.learn(at, look);
    }
    between.high * UNIT
}

/// Where a gap is open and where it is closed, in units: either may be farther out than was looked by a part of one.
struct Bracket {
    low: f64,
    high: f64,
    /// Values by which it is aimed: one that stays twice in a row counts for half (Illinois).
    left: f64,
    inside: f64,
    /// For how many looks the open end has stayed; below 0, the closed one.
    stayed: i32,
}

impl Bracket {
    fn new((low, left): (f64, f64), (high, inside): (f64, f64)) -> Self {
        Self { low, high, left, inside, stayed: 0 }
    }

    /// Where to look next, if anywhere: by the false position, or half way.
    fn next(&self, aim: bool) -> Option<f64> {
        if self.high - self.low <= 1.0 {
            return None;
        }
        let way = if aim && self.left.is_finite() {
            ((self.high - self.low) * (self.left / (self.left - self.inside))).ceil()
        } else {
            ((self.high - self.low) / 2.0).floor()
        };
        Some((self.low + way).clamp(self.low + 1.0, self.high - 1.0))
    }

    /// Looks where it is not known yet.
    fn learn(&mut self, at: f64, look: impl Fn(f64) -> f64) {
        if at <= self.low || at >= self.high {
            return;
        }
        let value = look(at);
        if value <= 0.0 {
            (self.high, self.inside) = (at, value);
            self.stayed = self.stayed.max(0) + 1;
            if self.stayed > 1 {
                self.left /= 2.0;
            }
        } else {
            (self.low, self.left) = (at, value);
            self.stayed = self.stayed.min(0) - 1;
            if self.stayed < -1 {
                self.inside /= 2.0;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use proptest::prelude::*;

    use super::*;

    fn unknown(_: f64) -> f64 {
        f64::NEG_INFINITY
    }

    proptest! {
        /// Gaps that close evenly, ever faster or ever slower, wherever it is begun and whatever is expected.
        #[test]
        fn what_is_found_is_the_first_unit_that_is_closed(
            at in 0.01..9.0, speed in 0.1..8.0, bent in -0.4..0.4, begun in 0.0..1.0, missed in -3.0..3.0_f64, rough in 0.0..0.3,
        ) {
            // It grows by no more than twice its speed at the moment as long as it is no farther away than this.
            let gap = |time: f64| (at - time) * speed * (1.0 + bent * (at - time) / 10.0);
            let looks = Cell::new(0);
            let counted = |time: f64| { looks.set(looks.get() + 1); gap(time) };
            let found = closes(counted, unknown, 2.0 * speed, (0.0, 10.0), 1.0 / 256.0, None).unwrap();
            prop_assert!(gap(found) <= 0.0 && gap(found - UNIT) > 0.0, "{found} is not the first");
            prop_assert_eq!((found / UNIT).fract(), 0.0);
            let from = look_before(begun * at, 1.0 / 256.0);
            let anew = looks.replace(0);
            let again = closes(counted, unknown, 2.0 * speed, (from, 10.0), 1.0 / 256.0, Some(found)).unwrap();
            prop_assert_eq!(again.to_bits(), found.to_bits());
            prop_assert!(looks.get() <= anew + 1, "{} looks, {anew} without what was expected", looks.get());
            // However little is known of it roughly.
            let roughly = |time: f64| gap(time) - rough * (1.0 + libm::sin(time * 50.0));
            let wrong = closes(gap, roughly, 2.0 * speed, (from, 10.0), 1.0 / 256.0, Some(found + missed)).unwrap();
            prop_assert_eq!(wrong.to_bits(), found.to_bits());
        }
    }

    #[test]
    fn what_stays_open_or_is_closed_from_the_beginning() {
        let least = 1.0 / 256.0;
        assert_eq!(closes(|time| 1.0 + time, unknown, 1.0, (0.0, 10.0), least, None), None);
        assert_eq!(closes(|time| 1.0 - time, unknown, 1.0, (0.0, 0.9), least, Some(0.5)), None);
        assert_eq!(closes(|_| -0.1, unknown, 1.0, (0.3, 10.0), least, None), Some(0.3));
        // Nobody moves.
        assert_eq!(closes(|_| 1.0, unknown, 0.0, (0.0, 10.0), least, None), None);
        assert_eq!(closes(|_| f64::NAN, unknown, 1.0, (0.0, 0.1), least, None), None);
        // Touched for less than two looks are apart, between them.
        let graze = |time: f64| ((time - 1.001).abs() - 1e-4) * 5.0;
        assert_eq!(closes(graze, unknown, 5.0, (0.0, 10.0), least, None), None);
    }
}
