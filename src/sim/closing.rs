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

/// The first moment between two at which a gap closes that grows no faster than `fastest` (m/s), s. It is looked at both ends and
/// at multiples of `least` (s): what only grazes between two of them is no contact.
pub(super) fn closes(
    gap: impl Fn(f64) -> f64,
    fastest: f64,
    (from, to): (f64, f64),
    least: f64,
) -> Option<f64> {
    let (mut before, mut time) = ((from, f64::INFINITY), from);
    loop {
        let left = gap(time);
        if left <= 0.0 {
            return Some(if time > from { moment(gap, before, (time, left)).min(to) } else { time });
        }
        // Nothing that is farther apart than all that is left of the way closes any more.
        if time >= to || left > fastest * (to - time) * (1.0 + 1e-9) + ROUNDING_OF_GAPS {
            return None;
        }
        before = (time, left);
        let following = (time / least).floor() + 1.0;
        time = (((time + left / fastest) / least).floor().max(following) * least).min(to);
    }
}

/// The last multiple of `least` up to a moment.
pub(super) fn look_before(moment: f64, least: f64) -> f64 {
    (moment / least).floor() * least
}

/// Looks by the false position, at most; what is left is found by halves.
const AIMED: usize = 24;

/// The first whole number of units at which a gap is closed that is open at one moment and closed at another.
fn moment(gap: impl Fn(f64) -> f64, open: (f64, f64), closed: (f64, f64)) -> f64 {
    // In units. Either end may lie beyond the moment that it stands for by a part of one.
    let (mut low, mut high) = ((open.0 / UNIT).floor(), (closed.0 / UNIT).ceil());
    // Values by which it is aimed (Illinois): one that stays twice in a row counts for half.
    let (mut left, mut inside) = (open.1, closed.1);
    let mut stayed = 0_i32;
    for look in 0.. {
        if high - low <= 1.0 {
            break;
        }
        let aimed = if look < AIMED && left.is_finite() {
            // Exactly closed at the end: what is open is just before it.
            low + ((high - low) * (left / (left - inside))).ceil()
        } else {
            ((low + high) / 2.0).floor()
        };
        let at = aimed.clamp(low + 1.0, high - 1.0);
        let value = gap(at * UNIT);
        if value <= 0.0 {
            (high, inside) = (at, value);
            stayed = stayed.max(0) + 1;
            if stayed > 1 {
                left /= 2.0;
            }
        } else {
            (low, left) = (at, value);
            stayed = stayed.min(0) - 1;
            if stayed < -1 {
                inside /= 2.0;
            }
        }
    }
    high * UNIT
}
