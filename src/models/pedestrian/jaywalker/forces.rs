//! The forces that move the jaywalker, per unit of mass: goal, oncoming vehicles, the evasive stop, the retreat.

use nalgebra::Vector2;

use super::declaration::Walking;
use scenario::Settings;
use sim::{PedestrianState, VehicleState};

/// Slows down towards the end of a retreat as if braking at this, m/s².
const RETREAT_BRAKING: f64 = 4.0;
/// The retreat ends when this much of it is left, m.
const RETREAT_END: f64 = 0.1;

/// Scales `vector` down to the length `limit` if it is longer.
pub fn clipped(vector: Vector2<f64>, limit: f64) -> Vector2<f64> {
    let length = vector.norm();
    if length > limit { vector * (limit / length) } else { vector }
}

/// Towards the desired velocity at a constant rate, at most reaching it within the step; m/s².
pub fn destination(walking: &Walking, way: Vector2<f64>, velocity: Vector2<f64>, step: f64) -> Vector2<f64> {
    let missing = way * walking.desired_speed - velocity;
    let size = missing.norm();
    if size < 1e-9 {
        return Vector2::zeros();
    }
    let magnitude = (walking.desired_speed / walking.relaxation_time).min(size / step);
    clipped(missing * (magnitude / size), walking.max_acceleration)
}

/// A stop under way: a linear ramp of speed to rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopForce {
    /// When it began, s.
    pub since: f64,
    /// Velocity at its beginning, m/s.
    pub velocity: Vector2<f64>,
    /// s
    pub duration: f64,
}

impl StopForce {
    /// Absorbs the rounding of summed times, s.
    const TOLERANCE: f64 = 1e-9;

    pub fn has_finished(&self, time: f64) -> bool {
        time - self.since >= self.duration - Self::TOLERANCE
    }

    pub fn force(&self, time: f64, velocity: Vector2<f64>, step: f64) -> Vector2<f64> {
        let left = (1.0 - (time - self.since) / self.duration).max(0.0);
        (self.velocity * left - velocity) / step
    }
}

/// A retreat under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Retreat {
    /// Where it leads, m.
    pub point: Vector2<f64>,
    /// Unit vector.
    pub way: Vector2<f64>,
    arrived: bool,
}

impl Retreat {
    /// From `position` back along `way` by `distance` (m), or less when `off_centre` (m from the lane's centre) exceeds
    /// one metre.
    pub fn new(position: Vector2<f64>, way: Vector2<f64>, distance: f64, off_centre: f64) -> Self {
        let reach = distance.min(distance / off_centre.max(1e-6));
        Self { point: position + way * reach, way, arrived: false }
    }

    pub fn force(
        &mut self,
        walking: &Walking,
        position: Vector2<f64>,
        velocity: Vector2<f64>,
        step: f64,
    ) -> Vector2<f64> {
        let left = (self.point - position).dot(&self.way);
        self.arrived |= left <= RETREAT_END;
        let speed = if self.arrived {
            0.0
        } else {
            walking.desired_speed.min(libm::sqrt(2.0 * RETREAT_BRAKING * left))
        };
        (self.way * speed - velocity) / (0.1 * walking.relaxation_time).max(step)
    }
}

/// Repulsion by a contour around and ahead of a vehicle.
///
/// Yang, Ozguner & Redmill 2020 in the jaywalker's form: unit mass, angle to the walking direction, nothing inside the
/// contour. With `original`, a mass of 75 kg, a contour wider by the margin, and the body radius off the distance.
#[derive(Debug, Clone, Copy)]
pub struct Yang {
    strength: f64,
    decay: f64,
    anisotropy: f64,
    rear_margin: f64,
    front_margin: f64,
    front_time: f64,
    original: bool,
}

impl Yang {
    /// kg
    const MASS: f64 = 75.0;
    /// m
    const BODY_RADIUS: f64 = 0.3;

    pub fn new(settings: &Settings) -> Self {
        Self {
            strength: settings.number("yang_strength"),
            decay: settings.number("yang_decay"),
            anisotropy: settings.number("yang_anisotropy"),
            rear_margin: settings.number("yang_rear_margin"),
            front_margin: settings.number("yang_front_margin"),
            front_time: settings.number("yang_front_time"),
            original: settings.flag("yang_original"),
        }
    }

    /// On a pedestrian that walks along the unit vector `walking`, m/s².
    pub fn force(
        &self,
        vehicle: &VehicleState,
        ego: &PedestrianState,
        walking: Vector2<f64>,
    ) -> Vector2<f64> {
        let place = vehicle.turned(ego.position - vehicle.position());
        let contour = self.contour(vehicle);
        if is_inside(&contour, place) {
            return Vector2::zeros();
        }
        let away = place - nearest_point(&contour, place);
        let distance = away.norm();
        if distance == 0.0 {
            return Vector2::zeros();
        }
        let outward = vehicle.turned_back(away / distance);
        let cosine = -outward.dot(&walking);
        let view = self.anisotropy + (1.0 - self.anisotropy) * (1.0 + cosine) / 2.0;
        let (distance, mass) =
            if self.original { (distance - Self::BODY_RADIUS, Self::MASS) } else { (distance, 1.0) };
        outward * (self.strength * libm::exp(-self.decay * distance) * view / mass)
    }

    /// Counter-clockwise in the vehicle frame.
    fn contour(&self, vehicle: &VehicleState) -> [Vector2<f64>; 5] {
        let rear = -(vehicle.length / 2.0 + self.rear_margin);
        let front = vehicle.length / 2.0 + self.rear_margin + self.front_margin;
        let nose = front + self.front_time * vehicle.motion.speed;
        let side = vehicle.width / 2.0 + if self.original { self.rear_margin } else { 0.0 };
        [(rear, -side), (front, -side), (nose, 0.0), (front, side), (rear, side)]
            .map(|(x, y)| Vector2::new(x, y))
    }
}

fn edges(contour: &[Vector2<f64>; 5]) -> impl Iterator<Item = (Vector2<f64>, Vector2<f64>)> {
    (0..5).map(|index| (contour[index], contour[(index + 1) % 5]))
}

/// Whether a point lies within a convex, counter-clockwise contour.
fn is_inside(contour: &[Vector2<f64>; 5], point: Vector2<f64>) -> bool {
    edges(contour).all(|(from, to)| (to - from).perp(&(point - from)) >= 0.0)
}

fn nearest_point(contour: &[Vector2<f64>; 5], point: Vector2<f64>) -> Vector2<f64> {
    let on_edge = |(from, to): (Vector2<f64>, Vector2<f64>)| {
        let edge = to - from;
        let part = match edge.norm_squared() {
            0.0 => 0.0,
            length => ((point - from).dot(&edge) / length).clamp(0.0, 1.0),
        };
        from + edge * part
    };
    edges(contour)
        .map(on_edge)
        .min_by(|one, other| (point - one).norm_squared().total_cmp(&(point - other).norm_squared()))
        .unwrap_or(point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pedestrian::jaywalker::declaration::declaration;
    use scenario::{Direction, Path, Shape, Value};
    use sim::Longitudinal;

    fn walking() -> Walking {
        Walking::new(&declaration().resolve(&Settings::default()).unwrap())
    }

    fn yang(original: bool) -> Yang {
        let given = Settings::from([("yang_original", Value::Flag(original))]);
        Yang::new(&declaration().resolve(&given).unwrap())
    }

    /// Its front bumper at x = 0, 30 km/h.
    fn car(direction: Direction) -> VehicleState {
        VehicleState::new(
            Path::straight(0.0, direction),
            Longitudinal { travelled: -2.45, speed: 8.33, acceleration: 0.0 },
            (4.9, 2.1),
        )
    }

    fn person(x: f64, y: f64) -> PedestrianState {
        PedestrianState {
            position: Vector2::new(x, y),
            velocity: Vector2::new(0.0, 1.0),
            acceleration: Vector2::zeros(),
            heading: Vector2::y(),
            shape: Shape::Disc { radius: 0.3 },
            present: true,
        }
    }

    /// Specification, check 11.
    #[test]
    fn yang_spot_values() {
        let near = |found: Vector2<f64>, x: f64, y: f64| {
            assert!((found - Vector2::new(x, y)).amax() < 2e-3 * y.abs().max(1.0), "{found}");
        };
        let force = |x, y| yang(false).force(&car(Direction::Forward), &person(x, y), Vector2::y());
        near(force(0.0, -2.5), 0.0, -17.57);
        near(force(12.0, -2.5), 0.113, -1.251);
        assert_eq!(force(5.0, 0.0), Vector2::zeros());
        // The same, turned by half a turn.
        let turned = yang(false).force(&car(Direction::Backward), &person(-12.0, 2.5), -Vector2::y());
        near(turned, -0.113, 1.251);
    }

    /// Specification, check 11.
    #[test]
    fn yang_distances() {
        let contour = yang(false).contour(&car(Direction::Forward));
        for (x, y, expected) in [(0.0, -2.5, 1.45), (12.0, -2.5, 2.459)] {
            let place = Vector2::new(x + 2.45, y);
            let distance = (place - nearest_point(&contour, place)).norm();
            assert!((distance - expected).abs() < 1e-3, "{distance}");
        }
        assert!((contour[2].x - 2.45 - 12.35).abs() < 0.01);
    }

    #[test]
    fn yang_original_is_far_weaker() {
        let at =
            |original| yang(original).force(&car(Direction::Forward), &person(0.0, -2.5), Vector2::y()).y;
        // The wider contour and the radius bring it nearer by 0.5151 m.
        let expected = at(false) * libm::exp(2.613755 * (0.2151011 + 0.3)) / 75.0;
        assert!((at(true) / expected - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_goal_pulls_with_4_m_s2_and_never_overshoots() {
        let pull = |speed: f64, step| destination(&walking(), Vector2::y(), Vector2::new(0.0, speed), step).y;
        assert_eq!((pull(0.0, 0.02), pull(3.0, 0.02)), (4.0, -4.0));
        assert!((pull(1.99, 0.02) * 0.02 - 0.01).abs() < 1e-12);
        assert_eq!(pull(2.0, 0.02), 0.0);
    }

    #[test]
    fn a_retreat_leads_off_the_lane_and_stays_there() {
        for y in [-2.0, -1.0, -0.7, -1e-9] {
            let retreat = Retreat::new(Vector2::new(0.0, y), -Vector2::y(), 3.0, y.abs());
            assert!(retreat.point.y <= -3.0, "{y}: {}", retreat.point.y);
        }
        let mut retreat = Retreat::new(Vector2::new(0.0, -0.7), -Vector2::y(), 3.0, 0.7);
        let (mut position, mut velocity) = (Vector2::new(0.0, -0.7), Vector2::new(0.0, 3.0));
        let step = 0.02;
        for _ in 0..500 {
            let force = clipped(retreat.force(&walking(), position, velocity, step), 9.5);
            velocity += force * step;
            position += velocity * step;
        }
        assert!(velocity.norm() < 1e-6);
        assert!((position.y + 3.7).abs() < 0.1, "{}", position.y);
    }

    #[test]
    fn a_stop_is_a_linear_ramp() {
        let stop = StopForce { since: 1.0, velocity: Vector2::new(0.0, 2.0), duration: 0.8 };
        let mut velocity = stop.velocity;
        let mut distance = 0.0;
        let step = 0.001;
        for index in 0..=800 {
            velocity += stop.force(1.0 + f64::from(index) * step, velocity, step) * step;
            distance += velocity.y * step;
        }
        assert!(velocity.norm() < 1e-9 && (distance - 0.8).abs() < 2e-3, "{distance}");
        assert!(!stop.has_finished(1.79) && stop.has_finished(1.8));
    }
}
