//! The jerk-limited stopping distance.

/// Limits of a stop. All positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrakingLimits {
    /// m/s²
    pub deceleration: f64,
    /// Of the onset, m/s³.
    pub negative_jerk: f64,
    /// Of the release at the end, m/s³.
    pub positive_jerk: f64,
}

impl BrakingLimits {
    /// The same with every limit `factor` times as large.
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            deceleration: self.deceleration * factor,
            negative_jerk: self.negative_jerk * factor,
            positive_jerk: self.positive_jerk * factor,
        }
    }
}

/// Distance (m) to standstill from `speed` (m/s) and `acceleration` (m/s²): onset with constant jerk, constant
/// deceleration, release with constant jerk so that speed and acceleration vanish together.
///
/// Too slow for the full deceleration, the constant part falls out; already braking too hard for a release that
/// ends at zero, the release alone is left and the vehicle stands before it is over. Source: Autoware
/// `autoware_motion_utils`, distance.cpp; specification §1.6.
pub fn stopping_distance(speed: f64, acceleration: f64, limits: BrakingLimits) -> f64 {
    if speed <= 0.0 {
        return 0.0;
    }
    let floor = -limits.deceleration;
    let release = limits.positive_jerk;
    let onset = if acceleration > floor { -limits.negative_jerk } else { release };
    let reached = Phase::of_jerk(speed, acceleration, onset, (floor - acceleration) / onset);
    let speed_at_release = floor * floor / (2.0 * release);
    let hold = (speed_at_release - reached.speed) / floor;
    if hold >= 0.0 {
        let held = reached.speed * hold + floor * hold * hold / 2.0;
        let released = Phase::of_jerk(speed_at_release, floor, release, -floor / release);
        return reached.distance + held + released.distance;
    }
    let jerk = -limits.negative_jerk;
    let square =
        (acceleration * acceleration / (2.0 * jerk) - speed) * (2.0 * release * jerk / (release - jerk));
    let peak = -square.max(0.0).sqrt();
    if peak <= acceleration {
        let reached = Phase::of_jerk(speed, acceleration, jerk, (peak - acceleration) / jerk);
        let released = Phase::of_jerk(reached.speed, peak, release, -peak / release);
        return reached.distance + released.distance;
    }
    let root = (acceleration * acceleration - 2.0 * release * speed).max(0.0).sqrt();
    Phase::of_jerk(speed, acceleration, release, (-acceleration - root) / release).distance
}

/// The end of a stretch of constant jerk.
struct Phase {
    distance: f64,
    speed: f64,
}

impl Phase {
    fn of_jerk(speed: f64, acceleration: f64, jerk: f64, time: f64) -> Self {
        Self {
            distance: time * (speed + time * (acceleration / 2.0 + time * jerk / 6.0)),
            speed: speed + time * (acceleration + time * jerk / 2.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const CRUISE: f64 = 30.0 / 3.6;
    const WEAK: BrakingLimits = BrakingLimits { deceleration: 1.2, negative_jerk: 1.2, positive_jerk: 10.0 };
    const STRONG: BrakingLimits =
        BrakingLimits { deceleration: 1.5, negative_jerk: 1.5, positive_jerk: 10.0 };
    const NORMAL: BrakingLimits = BrakingLimits { deceleration: 1.0, negative_jerk: 1.0, positive_jerk: 1.0 };

    #[test]
    fn stated_distances_at_30_km_h() {
        assert!((stopping_distance(CRUISE, 0.0, WEAK) - 33.1).abs() < 0.05);
        assert!((stopping_distance(CRUISE, 0.0, STRONG) - 27.3).abs() < 0.05);
    }

    #[test]
    fn symmetric_jerk_has_a_short_form() {
        // D = v/2 (v/|a| + |a|/j)
        for (speed, limits) in [(CRUISE, NORMAL), (5.0, NORMAL.scaled(2.0))] {
            let expected =
                speed / 2.0 * (speed / limits.deceleration + limits.deceleration / limits.negative_jerk);
            assert!((stopping_distance(speed, 0.0, limits) - expected).abs() < 1e-12);
        }
    }

    /// Follows the law in small steps: as late a release as still ends at zero speed and acceleration.
    fn integrated(speed: f64, acceleration: f64, limits: BrakingLimits) -> f64 {
        let dt = 1e-4;
        let (mut v, mut a, mut x) = (speed, acceleration, 0.0);
        while v > 0.0 {
            let releasing = a < 0.0 && v <= a * a / (2.0 * limits.positive_jerk);
            let wanted = if releasing { 0.0 } else { -limits.deceleration };
            let jerk = if wanted > a { limits.positive_jerk } else { -limits.negative_jerk };
            let next = if (wanted - a).abs() <= jerk.abs() * dt { wanted } else { a + jerk * dt };
            x += v * dt + a * dt * dt / 2.0;
            v += (a + next) / 2.0 * dt;
            a = next;
            if releasing && a >= 0.0 {
                break;
            }
        }
        x
    }

    proptest! {
        #[test]
        fn agrees_with_stepwise_integration(speed in 0.1..15.0, acceleration in -4.0..1.0) {
            for limits in [WEAK, STRONG, NORMAL] {
                let exact = stopping_distance(speed, acceleration, limits);
                let stepped = integrated(speed, acceleration, limits);
                prop_assert!((exact - stepped).abs() < 0.02, "{} {}", exact, stepped);
            }
        }
    }
}
