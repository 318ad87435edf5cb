//! Pedestrians and vehicles in the way of a vehicle: on a collision course at constant velocities.

use scenario::{CROSSES, Shape};
use sim::{EgoState, SeenPedestrian, SeenVehicle};

/// Two numbers (m, s, m/s, m/s²) that are compared count as equal if they differ by at most this: whole speeds and places meet thresholds
/// exactly, and rounding must not decide then.
pub const TIE: f64 = 1e-6;

/// A pedestrian on a collision course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hazard {
    /// From the front bumper to the pedestrian's near edge along the road, m; 0 when beside the vehicle.
    pub gap: f64,
    /// Until the gap is closed at the present speeds, s; infinite when it does not close.
    pub time_to_collision: f64,
}

/// A pedestrian that approaches a standing vehicle at most this fast (m/s) walks past it: at a right angle that speed is rounding.
const NOT_CLOSING: f64 = 1e-9;

/// The hazard that a pedestrian is if the vehicle's swept strip, widened by `margin` m on each side, and the
/// pedestrian's footprint meet while the vehicle passes, both keeping their velocity. A vehicle that stands
/// meets pedestrians that are in the strip now alone.
pub fn collision_course(ego: &EgoState, pedestrian: &SeenPedestrian, margin: f64) -> Option<Hazard> {
    let strip = Strip::before(ego, pedestrian, margin)?;
    let gap = strip.gap;
    let closing = ego.speed - pedestrian.velocity.x;
    if closing <= NOT_CLOSING {
        return strip.has(pedestrian).then_some(Hazard { gap, time_to_collision: f64::INFINITY });
    }
    let meets = strip.meets(pedestrian, |way| way / closing);
    meets.then_some(Hazard { gap, time_to_collision: gap / closing })
}

/// Whether a pedestrian is in the swept strip of a vehicle that stands, widened by `margin` m on each side, or will be while the vehicle
/// passes if it sets off now with `acceleration` (m/s²); with the gap to them, m.
pub fn met_when_setting_off(
    ego: &EgoState,
    pedestrian: &SeenPedestrian,
    margin: f64,
    acceleration: f64,
) -> Option<f64> {
    let strip = Strip::before(ego, pedestrian, margin)?;
    let meets = strip.meets(pedestrian, |way| (2.0 * way / acceleration).sqrt());
    (strip.has(pedestrian) || meets).then_some(strip.gap)
}

/// The strip that a vehicle sweeps, widened by the size of a pedestrian that its rear has yet to pass.
struct Strip {
    /// From the front bumper to the pedestrian's near edge, m; 0 when beside the vehicle.
    gap: f64,
    /// The way of the vehicle until its rear is past the pedestrian, m.
    clear_after: f64,
    /// m
    half_width: f64,
}

impl Strip {
    /// `None` of a pedestrian behind the vehicle.
    fn before(ego: &EgoState, pedestrian: &SeenPedestrian, margin: f64) -> Option<Self> {
        let (x, radius) = (pedestrian.position.x, half_size(pedestrian.shape));
        let clear_after = x + radius + ego.length / 2.0;
        (clear_after >= -TIE).then(|| Self {
            gap: (x - radius - ego.length / 2.0).max(0.0),
            clear_after: clear_after.max(0.0),
            half_width: ego.width / 2.0 + radius + margin,
        })
    }

    fn has(&self, pedestrian: &SeenPedestrian) -> bool {
        pedestrian.position.y.abs() <= self.half_width + TIE
    }

    /// Whether a pedestrian is in the strip while the vehicle passes, which takes `duration` s for a way in m.
    fn meets(&self, pedestrian: &SeenPedestrian, duration: impl Fn(f64) -> f64) -> bool {
        let after = |way: f64| pedestrian.position.y + pedestrian.velocity.y * duration(way);
        let (first, last) = (after(self.gap), after(self.clear_after));
        first.min(last) <= self.half_width + TIE && first.max(last) >= -self.half_width - TIE
    }
}

/// A vehicle ahead in the lane, or about to be, that stands or drives along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VehicleAhead {
    /// From bumper to bumper, m.
    pub gap: f64,
    /// Along the lane, m/s; negative if it comes towards.
    pub speed: f64,
    /// Until the gap is closed at the present speeds, s; infinite when it does not close.
    pub time_to_collision: f64,
}

/// Another vehicle as one ahead, if the strips that both sweep meet while both keep their velocity.
pub fn vehicle_ahead(ego: &EgoState, other: &SeenVehicle) -> Option<VehicleAhead> {
    /// Below this it stands, whatever way noise lets it seem to move, m/s.
    const STANDS: f64 = 0.5;
    let (position, velocity) = (other.position, other.velocity);
    let speed = velocity.norm();
    if position.x <= 0.0 || speed > STANDS && velocity.y.abs() >= CROSSES * speed {
        return None;
    }
    let gap = (position.x - (ego.length + other.length) / 2.0).max(0.0);
    let half_width = (ego.width + other.width) / 2.0;
    let closing = ego.speed - velocity.x;
    let closes = closing > NOT_CLOSING;
    let (arrives, leaves) = (gap / closing, (gap + ego.length + other.length) / closing);
    let beside = |time: f64| position.y + velocity.y * time;
    let (first, last) = if closes { (beside(arrives), beside(leaves)) } else { (position.y, position.y) };
    let meets = first.min(last) < half_width && first.max(last) > -half_width;
    meets.then_some(VehicleAhead {
        gap,
        speed: velocity.x,
        time_to_collision: if closes { arrives } else { f64::INFINITY },
    })
}

/// The larger half extent of a footprint, m.
pub fn half_size(shape: Shape) -> f64 {
    match shape {
        Shape::Disc { radius } => radius,
        Shape::Rectangle { length, width } => length.max(width) / 2.0,
    }
}

/// An acceleration that changes at a limited rate.
#[derive(Debug, Clone, Copy)]
pub struct Ramp {
    /// m/s²
    value: f64,
}

impl Ramp {
    pub fn from(acceleration: f64) -> Self {
        Self { value: acceleration }
    }

    /// The acceleration after `duration` s of moving towards `wanted` at `jerk` m/s³.
    pub fn toward(&mut self, wanted: f64, jerk: f64, duration: f64) -> f64 {
        let change = jerk * duration;
        self.value = wanted.clamp(self.value - change, self.value + change);
        self.value
    }
}

/// The acceleration that keeps a speed (m/s), between -`deceleration` and `acceleration` m/s².
pub fn keep_speed(speed: f64, wanted: f64, acceleration: f64, deceleration: f64) -> f64 {
    /// Speed error that asks for 1 m/s², s: errors vanish with this time constant.
    const TIME_CONSTANT: f64 = 0.5;
    ((wanted - speed) / TIME_CONSTANT).clamp(-deceleration, acceleration)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;

    fn ego(speed: f64) -> EgoState {
        EgoState {
            distance_to_crossing: 0.0,
            speed,
            acceleration: 0.0,
            length: 4.0,
            width: 2.0,
            travelled: 0.0,
            curvature: 0.0,
            lateral_offset: 0.0,
            heading_error: 0.0,
        }
    }

    fn walker(x: f64, y: f64, vy: f64) -> SeenPedestrian {
        SeenPedestrian {
            kind: Default::default(),
            id: 0,
            position: Vector2::new(x, y),
            velocity: Vector2::new(0.0, vy),
            acceleration: Vector2::zeros(),
            shape: Shape::Disc { radius: 0.25 },
        }
    }

    #[test]
    fn standing_in_the_way() {
        let hazard = collision_course(&ego(10.0), &walker(22.25, 0.0, 0.0), 0.0).unwrap();
        assert_eq!(hazard, Hazard { gap: 20.0, time_to_collision: 2.0 });
        assert!(collision_course(&ego(10.0), &walker(22.25, 1.26, 0.0), 0.0).is_none());
        assert!(collision_course(&ego(10.0), &walker(22.25, 1.26, 0.0), 0.1).is_some());
        assert!(collision_course(&ego(10.0), &walker(-3.0, 0.0, 0.0), 0.0).is_none());
    }

    #[test]
    fn crossing_meets_only_while_the_vehicle_passes() {
        // The front arrives after 2 s, the rear is past after 2.45 s; at 1 m/s the strip is 2.5 m wide.
        let meets = |y: f64| collision_course(&ego(10.0), &walker(22.25, y, 1.0), 0.0).is_some();
        assert!(!meets(-3.8) && meets(-3.6) && meets(-2.0) && meets(-0.8) && !meets(-0.7));
    }

    #[test]
    fn a_standing_vehicle_meets_those_before_it() {
        assert!(collision_course(&ego(0.0), &walker(3.0, 1.0, -1.0), 0.0).is_some());
        assert!(collision_course(&ego(0.0), &walker(3.0, 2.0, -1.0), 0.0).is_none());
        // Whatever rounding made of the right angle at which they walk.
        for ahead in [-1e-16, 0.0, 1e-16] {
            let before = |y: f64| {
                let mut walker = walker(3.0, y, -1.0);
                walker.velocity.x = ahead;
                collision_course(&ego(0.0), &walker, 0.0).is_some()
            };
            assert!(before(1.0) && !before(2.0), "{ahead}");
        }
    }

    #[test]
    fn ramps_are_limited_by_jerk() {
        let mut ramp = Ramp::from(0.0);
        assert_eq!(ramp.toward(-5.0, 10.0, 0.1), -1.0);
        assert_eq!(ramp.toward(-5.0, 10.0, 0.1), -2.0);
        assert_eq!(ramp.toward(-2.5, 10.0, 0.1), -2.5);
    }
}
