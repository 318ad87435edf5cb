//! The crosswalk module's decision about one pedestrian: pass first, pass later, yield or ignore (§1.3, §1.4).

use nalgebra::Vector2;

use super::crossing::CollisionPoint;
use super::site::{Ego, Site};
use super::tracker::TrackedTarget;
use scenario::Settings;

/// Below this speed the ego stands, m/s.
pub const STANDING: f64 = 1e-3;

/// How near the default stop the ego must stand to count as yielding, m (stop_position_threshold).
const AT_STOP_LINE: f64 = 1.0;

/// A pedestrian nearer to the attention area is never ignored, m.
const NEVER_IGNORED_WITHIN: f64 = 0.5;

#[derive(Debug, Clone, Copy)]
pub struct DecisionConstants {
    pass_first_margin: f64,
    pass_first_additional: f64,
    pass_later_margin: f64,
    pass_later_additional: f64,
    ego_min_assumed_speed: f64,
    min_object_velocity: f64,
    stop_object_velocity: f64,
    /// (distance, timeout) near and far, m and s.
    no_intention: [(f64, f64); 2],
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Stance {
    #[default]
    Yield,
    PassFirst,
    PassLater,
    Ignore,
}

/// The state kept for one pedestrian.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct YieldingDecision {
    pub stance: Stance,
    /// Since when both have stood, s.
    both_stand_since: Option<f64>,
}

/// What a decision is made from.
#[derive(Debug, Clone, Copy)]
pub struct YieldingConflict<'a> {
    /// s
    pub time: f64,
    pub ego: &'a Ego,
    pub site: &'a Site,
    /// Whether the ego has stood at the stop line for long enough.
    pub ego_yields: bool,
    pub target: &'a TrackedTarget,
    pub point: CollisionPoint,
    /// Half the stretch of the lane where paths count, m.
    pub attention: f64,
}

impl DecisionConstants {
    pub fn new(settings: &Settings) -> Self {
        Self {
            pass_first_margin: settings.number("ego_pass_first_margin"),
            pass_first_additional: settings.number("ego_pass_first_additional_margin"),
            pass_later_margin: settings.number("ego_pass_later_margin"),
            pass_later_additional: settings.number("ego_pass_later_additional_margin"),
            ego_min_assumed_speed: settings.number("ego_min_assumed_speed"),
            min_object_velocity: settings.number("min_object_velocity"),
            stop_object_velocity: settings.number("stop_object_velocity_threshold"),
            no_intention: [
                (settings.number("no_intention_near_distance"), settings.number("no_intention_near_timeout")),
                (settings.number("no_intention_far_distance"), settings.number("no_intention_far_timeout")),
            ],
        }
    }

    /// Time until the ego's rear has passed the collision point, s. Autoware calls it time to collision.
    pub fn time_to_clear(&self, ego: &Ego, point: &CollisionPoint) -> f64 {
        (point.place - ego.rear).max(0.0) / ego.speed.max(self.ego_min_assumed_speed)
    }

    /// Time until the pedestrian is at the collision point, s. Autoware calls it time to vehicle.
    pub fn time_to_walk(&self, target: &TrackedTarget, point: &CollisionPoint) -> f64 {
        point.walk.max(0.0) / target.velocity.norm().max(self.min_object_velocity)
    }

    /// How long both may stand before a pedestrian at this distance (m) from the crosswalk is ignored, s.
    fn patience(&self, distance: f64) -> f64 {
        let [(near, near_timeout), (far, far_timeout)] = self.no_intention;
        if distance <= near {
            near_timeout
        } else if distance >= far {
            far_timeout
        } else {
            near_timeout + (far_timeout - near_timeout) * (distance - near) / (far - near)
        }
    }
}

impl YieldingDecision {
    /// One cycle with a collision point.
    pub fn update(&mut self, conflict: &YieldingConflict, constants: &DecisionConstants) {
        let YieldingConflict { time, ego, site, target, point, attention, .. } = *conflict;
        let stands = target.velocity.norm() < constants.stop_object_velocity;
        if stands && conflict.ego_yields {
            let since = *self.both_stand_since.get_or_insert(time);
            let to_crosswalk = outside(
                target.position,
                (-site.half_width, site.half_width),
                (site.right_kerb, site.left_kerb),
            );
            let to_attention =
                outside(target.position, (-attention, attention), (-ego.half_width, ego.half_width));
            if time - since >= constants.patience(to_crosswalk) - 1e-6 && to_attention > NEVER_IGNORED_WITHIN
            {
                self.stance = Stance::Ignore;
                return;
            }
        } else {
            self.both_stand_since = None;
        }
        if stands && self.stance == Stance::Ignore {
            return;
        }
        let to_clear = constants.time_to_clear(ego, &point);
        let to_walk = constants.time_to_walk(target, &point);
        let first = constants.pass_first_margin
            + if self.stance == Stance::PassFirst { 0.0 } else { constants.pass_first_additional };
        let later = constants.pass_later_margin
            + if self.stance == Stance::PassLater { 0.0 } else { constants.pass_later_additional };
        self.stance = if to_clear + first < to_walk {
            Stance::PassFirst
        } else if to_walk + later < to_clear {
            Stance::PassLater
        } else {
            Stance::Yield
        };
    }
}

/// Whether the ego has stood at the stop line for as long as counts as yielding.
#[derive(Debug, Clone, Copy)]
pub struct YieldingStanding {
    timeout: f64,
    since: Option<f64>,
}

impl YieldingStanding {
    pub fn new(settings: &Settings) -> Self {
        Self { timeout: settings.number("timeout_ego_stop_for_yield"), since: None }
    }

    /// `to_stop`: distance from the bumper to the default stop, m. To be called at every tick.
    pub fn is_yielding(&mut self, time: f64, speed: f64, to_stop: f64) -> bool {
        if speed >= STANDING {
            self.since = None;
            return false;
        }
        let since = *self.since.get_or_insert(time);
        time - since >= self.timeout - 1e-6 && to_stop < AT_STOP_LINE
    }
}

/// Distance from a point to a rectangle, m.
fn outside(point: Vector2<f64>, along: (f64, f64), across: (f64, f64)) -> f64 {
    let gap = |value: f64, (low, high): (f64, f64)| (low - value).max(value - high).max(0.0);
    libm::hypot(gap(point.x, along), gap(point.y, across))
}

#[cfg(test)]
mod tests {
    use super::super::site::tests::{SITE, ego};
    use super::*;
    use crate::vehicle::autoware::autoware;

    const CRUISE: f64 = 30.0 / 3.6;

    fn constants() -> DecisionConstants {
        DecisionConstants::new(&autoware().declaration.resolve(&Settings::default()).unwrap())
    }

    fn standing_at(y: f64) -> (TrackedTarget, CollisionPoint) {
        let target =
            TrackedTarget { position: Vector2::new(0.0, y), velocity: Vector2::zeros(), half_size: 0.25 };
        (target, CollisionPoint { place: 0.0, walk: y.abs() })
    }

    /// An ego at cruise speed whose time to clear the crossing point is this.
    fn clearing_in(time: f64) -> Ego {
        ego(4.89 - time * CRUISE, CRUISE)
    }

    fn decide(decision: &mut YieldingDecision, time: f64, ego: &Ego, ego_yields: bool, y: f64) -> Stance {
        let (target, point) = standing_at(y);
        let conflict =
            YieldingConflict { time, ego, site: &SITE, ego_yields, target: &target, point, attention: 4.0 };
        decision.update(&conflict, &constants());
        decision.stance
    }

    #[test]
    fn times_of_a_waiting_pedestrian() {
        let (target, point) = standing_at(-4.0);
        assert!((constants().time_to_walk(&target, &point) - 2.9).abs() < 0.05);
        // The rear has to get past: the front at the crossing is still one length away from clear.
        assert!((constants().time_to_clear(&ego(0.0, CRUISE), &point) - 4.89 / CRUISE).abs() < 1e-12);
        assert!((constants().time_to_clear(&ego(0.0, 0.5), &point) - 4.89 / 2.0).abs() < 1e-12);
        assert_eq!(constants().time_to_clear(&ego(9.0, CRUISE), &point), 0.0);
    }

    #[test]
    fn yields_to_who_waits_from_16_4_s_on_and_after_a_later_phase_from_15_9_s() {
        let mut fresh = YieldingDecision::default();
        assert_eq!(decide(&mut fresh, 0.0, &clearing_in(16.3), false, -4.0), Stance::Yield);
        let mut fresh = YieldingDecision::default();
        assert_eq!(decide(&mut fresh, 0.0, &clearing_in(16.45), false, -4.0), Stance::PassLater);
        assert_eq!(decide(&mut fresh, 0.1, &clearing_in(15.95), false, -4.0), Stance::PassLater);
        assert_eq!(decide(&mut fresh, 0.2, &clearing_in(15.8), false, -4.0), Stance::Yield);
        for time in [0.1, 1.0, 5.0, 10.0, 15.0] {
            assert_eq!(
                decide(&mut YieldingDecision::default(), 0.0, &clearing_in(time), false, -4.0),
                Stance::Yield
            );
        }
    }

    #[test]
    fn passes_first_with_4_5_s_to_spare_and_keeps_to_it_down_to_4_s() {
        // He needs 10 / 1.39 = 7.19 s.
        let mut decision = YieldingDecision::default();
        assert_eq!(decide(&mut decision, 0.0, &clearing_in(2.8), false, -10.0), Stance::Yield);
        assert_eq!(decide(&mut decision, 0.1, &clearing_in(2.6), false, -10.0), Stance::PassFirst);
        assert_eq!(decide(&mut decision, 0.2, &clearing_in(3.1), false, -10.0), Stance::PassFirst);
        assert_eq!(decide(&mut decision, 0.3, &clearing_in(3.3), false, -10.0), Stance::Yield);
    }

    #[test]
    fn ignores_who_stands_longer_than_its_patience() {
        // 2 m from the crosswalk: 0.75 s.
        let here = ego(-5.5, 0.0);
        let mut decision = YieldingDecision::default();
        assert_eq!(decide(&mut decision, 0.0, &here, true, -4.0), Stance::Yield);
        assert_eq!(decide(&mut decision, 0.7, &here, true, -4.0), Stance::Yield);
        assert_eq!(decide(&mut decision, 0.75, &here, true, -4.0), Stance::Ignore);
        assert_eq!(decide(&mut decision, 0.85, &here, false, -4.0), Stance::Ignore);
        // At 1.4 m he is within 0.5 m of the ego's path.
        let mut near = YieldingDecision::default();
        decide(&mut near, 0.0, &here, true, -1.4);
        assert_eq!(decide(&mut near, 60.0, &here, true, -1.4), Stance::Yield);
    }

    #[test]
    fn yielding_means_standing_for_a_second_at_the_line() {
        let settings = autoware().declaration.resolve(&Settings::default()).unwrap();
        let mut standing = YieldingStanding::new(&settings);
        assert!(!standing.is_yielding(0.0, 0.0, 0.2));
        assert!(!standing.is_yielding(0.9, 0.0, 0.2));
        assert!(standing.is_yielding(1.0, 0.0, 0.2));
        assert!(!standing.is_yielding(1.1, 0.0, 1.2));
        assert!(!standing.is_yielding(1.2, 0.1, 0.2));
        assert!(!standing.is_yielding(1.3, 0.0, 0.2));
    }
}
