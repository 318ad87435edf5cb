//! Autonomous emergency braking and the emergency stop that it ends in (§2.4, §5.3).

use super::site::Ego;
use super::tracker::TrackedTarget;
use scenario::Settings;

/// How much wider than the ego the band is on each side, m (expand_width, negative as configured).
const EXPAND_WIDTH: f64 = -0.2;

#[derive(Debug, Clone, Copy)]
pub struct EmergencyBrake {
    enabled: bool,
    response_time: f64,
    deceleration: f64,
    object_deceleration: f64,
    offset: f64,
    hold: f64,
    last_trigger: Option<f64>,
}

impl EmergencyBrake {
    pub fn new(settings: &Settings) -> Self {
        Self {
            enabled: settings.flag("aeb"),
            response_time: settings.number("aeb_response_time"),
            deceleration: settings.number("aeb_deceleration"),
            object_deceleration: settings.number("aeb_object_deceleration"),
            offset: settings.number("aeb_offset"),
            hold: settings.number("aeb_hold"),
            last_trigger: None,
        }
    }

    /// Whether the emergency stop is on, given everybody that a point cloud shows. To be called at every tick.
    pub fn update(&mut self, time: f64, ego: &Ego, targets: impl Iterator<Item = TrackedTarget>) -> bool {
        if !self.enabled {
            return false;
        }
        if targets.into_iter().any(|target| self.triggers(ego, &target)) {
            self.last_trigger = Some(time);
        }
        self.last_trigger.is_some_and(|last| time - last <= self.hold + 1e-6)
    }

    fn triggers(&self, ego: &Ego, target: &TrackedTarget) -> bool {
        let distance = target.position.x - target.half_size - ego.front;
        let in_band = target.position.y.abs() < ego.half_width + EXPAND_WIDTH + target.half_size;
        let ahead = target.position.x + target.half_size > ego.front;
        in_band && ahead && distance < self.trigger_distance(ego.speed, target.velocity.x)
    }

    /// Distance below which somebody moving at `object_speed` along the lane triggers, m.
    fn trigger_distance(&self, speed: f64, object_speed: f64) -> f64 {
        speed * self.response_time + speed * speed / (2.0 * self.deceleration)
            - object_speed * object_speed.abs() / (2.0 * self.object_deceleration)
            + self.offset
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::super::site::tests::ego;
    use super::*;
    use crate::vehicle::autoware::autoware;
    use scenario::Value;

    fn brake() -> EmergencyBrake {
        let on = Settings::from([("aeb", Value::Flag(true))]);
        EmergencyBrake::new(&autoware().declaration.resolve(&on).unwrap())
    }

    fn standing(y: f64) -> TrackedTarget {
        TrackedTarget { position: Vector2::new(0.0, y), velocity: Vector2::zeros(), half_size: 0.25 }
    }

    #[test]
    fn triggers_at_20_9_m_in_the_narrowed_band() {
        let speed = 30.0 / 3.6;
        assert!((brake().trigger_distance(speed, 0.0) - 20.9).abs() < 0.05);
        assert!((brake().trigger_distance(speed, 1.0) - 20.4).abs() < 0.05);
        let at = |gap: f64, y: f64| brake().triggers(&ego(-0.25 - gap, speed), &standing(y));
        assert!(at(20.8, 0.0) && !at(21.0, 0.0));
        // 0.948 - 0.2 + 0.25 = 0.998 m
        assert!(at(15.0, -0.99) && at(15.0, 0.99) && !at(15.0, 1.01));
    }

    #[test]
    fn holds_for_3_s() {
        let mut brake = brake();
        let here = ego(-15.0, 30.0 / 3.6);
        assert!(brake.update(0.0, &here, [standing(0.0)].into_iter()));
        assert!(brake.update(3.0, &here, [standing(5.0)].into_iter()));
        assert!(!brake.update(3.1, &here, std::iter::empty()));
    }
}
