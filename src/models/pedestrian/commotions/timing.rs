//! When a road user enters and leaves the conflict space (§4), and the acceleration to be at a point at a time (§5).

use super::state::State;

/// Time (s) to cover the distance `x` (m) from speed `v` with constant acceleration `a` (§4).
///
/// −∞ when the point is already reached, +∞ when it never will be.
#[inline]
pub fn time_to_cover(x: f64, v: f64, a: f64) -> f64 {
    if x <= 0.0 {
        return f64::NEG_INFINITY;
    }
    if v == 0.0 && a <= 0.0 {
        return f64::INFINITY;
    }
    if a == 0.0 {
        return x / v;
    }
    if a < 0.0 && v * v / (-2.0 * a) <= x {
        return f64::INFINITY;
    }
    (-v + (v * v + 2.0 * a * x).sqrt()) / a
}

/// When a road user enters and leaves the conflict space (s from now).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ConflictPassage {
    /// Time until the front reaches the conflict space; −∞ if it has.
    pub entry: f64,
    /// Time until the rear has left it; −∞ if it has, +∞ if it never will.
    pub exit: f64,
}

impl ConflictPassage {
    /// The passage of a road user that keeps its speed ("speed form") or, with `with_acceleration`, its
    /// acceleration ("acceleration form").
    #[inline]
    pub fn of(state: &State, half_extent: f64, with_acceleration: bool) -> Self {
        let a = if with_acceleration { state.acceleration } else { 0.0 };
        Self {
            entry: time_to_cover(state.distance - half_extent, state.speed, a),
            exit: time_to_cover(state.distance + half_extent, state.speed, a),
        }
    }
}

/// The acceleration that brings a road user of speed `v` over the distance `x` in the time `t`, and how
/// long to keep it (§5). `None` where `t ≤ 0`.
///
/// Where stopping exactly at the point takes less time than `t`, stopping is the answer.
#[inline]
pub fn acceleration_to_be_at(v: f64, x: f64, t: f64) -> Option<(f64, f64)> {
    if t <= 0.0 {
        return None;
    }
    let acceleration = if t == f64::INFINITY {
        if x == 0.0 {
            return Some((-sign(v) * f64::EPSILON, t));
        }
        if v == 0.0 {
            return Some((sign(x) * f64::EPSILON, t));
        }
        -sign(v * x) * f64::EPSILON
    } else {
        2.0 * (x - v * t) / (t * t)
    };
    if x > 0.0 && v > 0.0 && acceleration < 0.0 {
        let stopping = -(v * v) / (2.0 * x);
        let duration = v / -stopping;
        if duration < t {
            return Some((stopping, duration));
        }
    }
    Some((acceleration, t))
}

/// −1, 0 or 1: unlike `f64::signum`, 0 has no sign.
fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_corner_cases_of_covering_a_distance() {
        assert_eq!(time_to_cover(0.0, 1.0, 0.0), f64::NEG_INFINITY);
        assert_eq!(time_to_cover(1.0, 0.0, 0.0), f64::INFINITY);
        assert_eq!(time_to_cover(1.0, 0.0, -1.0), f64::INFINITY);
        assert_eq!(time_to_cover(3.0, 1.5, 0.0), 2.0);
        // Stops exactly at the point: it is never reached.
        assert_eq!(time_to_cover(2.0, 2.0, -1.0), f64::INFINITY);
        assert_eq!(time_to_cover(2.0, 0.0, 1.0), 2.0);
    }

    #[test]
    fn the_corner_cases_of_being_somewhere_in_time() {
        assert_eq!(acceleration_to_be_at(1.0, 1.0, 0.0), None);
        assert_eq!(acceleration_to_be_at(1.0, 1.0, -2.0), None);
        assert_eq!(acceleration_to_be_at(1.0, 0.0, f64::INFINITY), Some((-f64::EPSILON, f64::INFINITY)));
        assert_eq!(acceleration_to_be_at(0.0, -3.0, f64::INFINITY), Some((-f64::EPSILON, f64::INFINITY)));
        // Nothing is ever reached at infinity while moving: stop there instead.
        assert_eq!(acceleration_to_be_at(2.0, 4.0, f64::INFINITY), Some((-0.5, 4.0)));
        assert_eq!(acceleration_to_be_at(2.0, -4.0, f64::INFINITY), Some((f64::EPSILON, f64::INFINITY)));
    }

    proptest! {
        #[test]
        fn an_arrival_time_is_an_arrival(x in 0.01..200.0, v in 0.0..30.0, a in -4.0..4.0) {
            let t = time_to_cover(x, v, a);
            if t.is_finite() {
                prop_assert!((v * t + a * t * t / 2.0 - x).abs() < 1e-6 * x.max(1.0));
            }
        }

        #[test]
        fn the_acceleration_found_leads_there(x in 0.01..100.0, v in 0.0..20.0, t in 0.1..30.0) {
            let (a, duration) = acceleration_to_be_at(v, x, t).unwrap();
            prop_assert!(duration <= t);
            prop_assert!((v * duration + a * duration * duration / 2.0 - x).abs() < 1e-9 * x.max(1.0));
        }
    }
}
