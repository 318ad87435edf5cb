//! The in-lane stop: for who is in the ego's path, or about to be (§2.2, §5.3).

use super::debounce::{Debounce, Delays};
use super::site::Ego;
use super::tracker::TrackedTarget;
use scenario::Settings;

/// Longest prediction of a pedestrian who cuts in, s.
const LONGEST_CUT_IN: f64 = 1.0;

/// Deceleration at which he is assumed to stop, m/s².
const CUT_IN_DECELERATION: f64 = 1.0;

/// The crossing-transient check: distance kept, least speed, time before arrival.
const TRANSIENT_DISTANCE: f64 = 3.0;
const TRANSIENT_SPEED: f64 = 2.0;
const TRANSIENT_TIME: f64 = 1.0;

/// tan 30°: beyond that angle to the path he crosses it.
const CROSSING_SLOPE: f64 = 0.577_350_269_189_625_8;

#[derive(Debug, Clone, Copy)]
pub struct LaneConstants {
    margin: f64,
    margin_at_crosswalk: f64,
    lateral_margin: f64,
    delays: Delays,
}

/// What is remembered of one pedestrian.
#[derive(Debug, Clone, Copy, Default)]
pub struct StopObstacle {
    in_the_way: Debounce,
    /// s of his side that faces the ego when he was last in the way, m.
    last: f64,
}

impl LaneConstants {
    pub fn new(settings: &Settings) -> Self {
        Self {
            margin: settings.number("lane_stop_margin"),
            margin_at_crosswalk: settings.number("lane_stop_margin_at_crosswalk"),
            lateral_margin: settings.number("lane_lateral_margin"),
            delays: Delays { on: settings.number("lane_on_delay"), off: settings.number("lane_off_delay") },
        }
    }

    /// From the bumper to what it stops for, m.
    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// Whether a pedestrian is in the way now.
    pub fn blocks(&self, target: &TrackedTarget, ego: &Ego) -> bool {
        let near_side = target.position.x - target.half_size;
        if target.position.x + target.half_size <= ego.front {
            return false;
        }
        let reach = ego.half_width + self.lateral_margin + target.half_size;
        let touches_after = |time: f64| (target.position.y + target.velocity.y * time).abs() < reach;
        let cut_in = (target.velocity.norm() / (2.0 * CUT_IN_DECELERATION)).clamp(0.0, LONGEST_CUT_IN);
        if !touches_after(0.0) && !touches_after(cut_in) {
            return false;
        }
        let crosses = target.velocity.y.abs() > CROSSING_SLOPE * target.velocity.x.abs();
        let arrival = (near_side - ego.front - TRANSIENT_DISTANCE) / ego.speed.max(TRANSIENT_SPEED);
        let transient = crosses && arrival > TRANSIENT_TIME && !touches_after(arrival - TRANSIENT_TIME);
        !transient
    }
}

impl StopObstacle {
    /// Where the bumper shall stop for this pedestrian (s in m). `crosswalk_stop`: the stop for the crosswalk, if any.
    pub fn stop(
        &mut self,
        target: &TrackedTarget,
        time: f64,
        ego: &Ego,
        crosswalk_stop: Option<f64>,
        constants: &LaneConstants,
    ) -> Option<f64> {
        let blocks = constants.blocks(target, ego);
        if blocks {
            self.last = target.position.x - target.half_size;
        }
        if !self.in_the_way.update(blocks, time, constants.delays) {
            return None;
        }
        let between =
            crosswalk_stop.is_some_and(|stop| (self.last - constants.margin..self.last).contains(&stop));
        Some(self.last - if between { constants.margin_at_crosswalk } else { constants.margin })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::super::site::tests::ego;
    use super::*;
    use crate::vehicle::autoware::autoware;

    const CRUISE: f64 = 30.0 / 3.6;

    fn constants() -> LaneConstants {
        LaneConstants::new(&autoware().declaration.resolve(&Settings::default()).unwrap())
    }

    fn target(x: f64, y: f64, vy: f64) -> TrackedTarget {
        TrackedTarget { position: Vector2::new(x, y), velocity: Vector2::new(0.0, vy), half_size: 0.25 }
    }

    #[test]
    fn the_path_is_wider_than_the_ego_and_only_ahead() {
        // 0.948 + 0.3 + 0.25 = 1.498 m
        let here = ego(-20.0, CRUISE);
        assert!(constants().blocks(&target(0.0, -1.49, 0.0), &here));
        assert!(constants().blocks(&target(0.0, 1.49, 0.0), &here));
        assert!(!constants().blocks(&target(0.0, -1.51, 0.0), &here));
        assert!(!constants().blocks(&target(-20.3, 0.0, 0.0), &here));
    }

    #[test]
    fn who_cuts_in_counts_as_far_as_he_needs_to_stop() {
        // 1.4 m/s: 0.7 s and 0.98 m ahead. Seen from 12 m the transient check stays out.
        let here = ego(-11.0, CRUISE);
        assert!(constants().blocks(&target(0.0, -2.47, 1.4), &here));
        assert!(!constants().blocks(&target(0.0, -2.49, 1.4), &here));
        assert!(!constants().blocks(&target(0.0, -2.47, -1.4), &here));
    }

    #[test]
    fn who_will_have_crossed_is_no_obstacle() {
        // 40 m ahead: arrival in (39.75 - 3) / 8.33 = 4.41 s; 3.41 s later he is 4.8 m farther.
        let here = ego(-40.0, CRUISE);
        assert!(!constants().blocks(&target(0.0, -1.0, 1.4), &here));
        assert!(constants().blocks(&target(0.0, -1.0, 0.5), &here));
        // 20 m ahead: arrival in 2.01 s; 1.01 s later he is at 0.41 m.
        assert!(constants().blocks(&target(0.0, -1.0, 1.4), &ego(-20.0, CRUISE)));
    }

    #[test]
    fn stops_5_m_before_or_3_m_with_a_crosswalk_stop_in_between() {
        let here = ego(-20.0, CRUISE);
        let stop_of = |crosswalk: Option<f64>| {
            let mut obstacle = StopObstacle::default();
            (0..5)
                .map(|k| {
                    let time = f64::from(k) * 0.1;
                    obstacle.stop(&target(0.0, 0.0, 0.0), time, &here, crosswalk, &constants())
                })
                .collect::<Vec<_>>()
        };
        assert_eq!(stop_of(None), [None, None, None, Some(-5.25), Some(-5.25)]);
        assert_eq!(stop_of(Some(-5.5))[4], Some(-5.25));
        assert_eq!(stop_of(Some(-5.0))[4], Some(-3.25));
    }

    #[test]
    fn the_stop_stays_a_second_after_the_way_is_free() {
        let here = ego(-20.0, CRUISE);
        let mut obstacle = StopObstacle::default();
        let mut stopped = Vec::new();
        for k in 0..20 {
            let y = if k < 5 { 0.0 } else { 3.0 };
            let stop = obstacle.stop(&target(0.0, y, 0.0), f64::from(k) * 0.1, &here, None, &constants());
            stopped.push(stop.is_some());
        }
        assert!(stopped[3..15].iter().all(|&stop| stop) && !stopped[15]);
    }
}
