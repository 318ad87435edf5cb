//! Footprints in the plane: when they touch and how far apart they are.
//!
//! A vehicle is a rectangle along its path, a box one along the road where it stands; a pedestrian is a disc or a rectangle along its heading.

use nalgebra::Vector2;

use scenario::agent::{PedestrianState, VehicleState};
use scenario::{Body, Shape};

/// A body's outline at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    /// World frame, m.
    pub centre: Vector2<f64>,
    /// Unit vector along the length of a rectangle.
    pub heading: Vector2<f64>,
    /// Its kind and size.
    pub shape: Shape,
}

impl From<&VehicleState> for Footprint {
    #[inline]
    fn from(vehicle: &VehicleState) -> Self {
        let shape = Shape::Rectangle { length: vehicle.length, width: vehicle.width };
        let (centre, heading) = match vehicle.keeps_straight() {
            // A rectangle is the same from either end, so that both directions of travel have the same bits.
            true => (vehicle.position(), Vector2::x()),
            false => vehicle.pose(),
        };
        Self { centre, heading, shape }
    }
}

impl From<&PedestrianState> for Footprint {
    fn from(person: &PedestrianState) -> Self {
        Self { centre: person.position, heading: person.heading, shape: person.shape }
    }
}

impl From<&Body> for Footprint {
    fn from(body: &Body) -> Self {
        let shape = Shape::Rectangle { length: body.length, width: body.width };
        Self { centre: Vector2::new(body.x, body.y), heading: body.along(), shape }
    }
}

impl Footprint {
    /// The farthest that it reaches from its centre, m.
    pub fn radius(&self) -> f64 {
        match self.shape {
            Shape::Disc { radius } => radius,
            Shape::Rectangle { length, width } => Vector2::new(length, width).norm() / 2.0,
        }
    }

    /// Smaller by `depth` (m) on every side, but never less than a point.
    pub fn shrunk(&self, depth: f64) -> Self {
        let less = |extent: f64| (extent - 2.0 * depth).max(0.0);
        let shape = match self.shape {
            Shape::Disc { radius } => Shape::Disc { radius: (radius - depth).max(0.0) },
            Shape::Rectangle { length, width } => {
                Shape::Rectangle { length: less(length), width: less(width) }
            }
        };
        Self { shape, ..*self }
    }

    /// Whether a place is inside it, and not at its edge.
    pub fn is_over(&self, place: Vector2<f64>) -> bool {
        let offset = place - self.centre;
        match self.shape {
            Shape::Disc { radius } => offset.norm_squared() < radius * radius,
            Shape::Rectangle { length, width } => {
                let own = self.own_frame(offset);
                own.x.abs() < length / 2.0 && own.y.abs() < width / 2.0
            }
        }
    }

    /// Whether `line` (m) from a point passes through it. To touch it is not enough.
    pub fn is_crossed(&self, from: Vector2<f64>, line: Vector2<f64>) -> bool {
        let (length, width) = match self.shape {
            Shape::Disc { radius } => {
                let to_centre = self.centre - from;
                let squared = line.norm_squared();
                let nearest =
                    if squared > 0.0 { (to_centre.dot(&line) / squared).clamp(0.0, 1.0) } else { 0.0 };
                return (to_centre - line * nearest).norm_squared() < radius * radius;
            }
            Shape::Rectangle { length, width } => (length, width),
        };
        let (offset, line) = (self.own_frame(from - self.centre), self.own_frame(line));
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for (offset, along, half) in [(offset.x, line.x, length / 2.0), (offset.y, line.y, width / 2.0)] {
            if along == 0.0 {
                if offset.abs() > half {
                    return false;
                }
                continue;
            }
            let (one, other) = ((-half - offset) / along, (half - offset) / along);
            enter = enter.max(one.min(other));
            leave = leave.min(one.max(other));
        }
        enter < leave
    }

    /// Time in s until it and `other` first touch if the other moves at `velocity` (m/s) as seen from this one; 0 if
    /// they touch now, `None` if they never will. Neither turns.
    pub fn first_contact(&self, other: &Self, velocity: Vector2<f64>) -> Option<f64> {
        let offset = other.centre - self.centre;
        match (self.shape, other.shape) {
            (Shape::Disc { radius }, Shape::Disc { radius: others }) => {
                circle_contact(offset, velocity, radius + others)
            }
            (Shape::Disc { .. }, Shape::Rectangle { .. }) => other.first_contact(self, -velocity),
            (Shape::Rectangle { length, width }, Shape::Disc { radius }) => {
                // A rectangle rounded by the disc: two rectangles and a circle at each corner.
                let half = Vector2::new(length / 2.0, width / 2.0);
                let (offset, velocity) = (self.own_frame(offset), self.own_frame(velocity));
                let long = box_contact(offset, velocity, half + Vector2::new(radius, 0.0));
                let wide = box_contact(offset, velocity, half + Vector2::new(0.0, radius));
                let corners = CORNERS
                    .map(|corner| circle_contact(offset - half.component_mul(&corner), velocity, radius));
                corners.into_iter().chain([long, wide]).flatten().reduce(f64::min)
            }
            (Shape::Rectangle { .. }, Shape::Rectangle { .. }) => {
                let mut interval = Interval::always();
                for axis in [self.heading, self.across(), other.heading, other.across()] {
                    let reach = self.reach(axis) + other.reach(axis);
                    interval = interval.within(offset.dot(&axis), velocity.dot(&axis), reach);
                }
                interval.first()
            }
        }
    }

    /// How far it and another are apart, m, as far as their sides tell: 0 or less where they touch, and no more than the distance between
    /// them elsewhere.
    pub(super) fn separation(&self, other: &Self) -> f64 {
        let offset = other.centre - self.centre;
        match (self.shape, other.shape) {
            (Shape::Disc { radius }, Shape::Disc { radius: others }) => offset.norm() - radius - others,
            (Shape::Disc { .. }, Shape::Rectangle { .. }) => other.separation(self),
            (Shape::Rectangle { length, width }, Shape::Disc { radius }) => {
                let (own, half) = (self.own_frame(offset), Vector2::new(length, width) / 2.0);
                let outside = distance_to_box(own, half);
                (if outside > 0.0 { outside } else { (own.abs() - half).max() }) - radius
            }
            (Shape::Rectangle { .. }, Shape::Rectangle { .. }) => {
                let beyond =
                    |axis: Vector2<f64>| offset.dot(&axis).abs() - self.reach(axis) - other.reach(axis);
                let axes = [self.heading, self.across(), other.heading, other.across()];
                axes.into_iter().map(beyond).fold(f64::NEG_INFINITY, f64::max)
            }
        }
    }

    pub(super) fn across(&self) -> Vector2<f64> {
        Vector2::new(-self.heading.y, self.heading.x)
    }

    fn own_frame(&self, vector: Vector2<f64>) -> Vector2<f64> {
        Vector2::new(vector.dot(&self.heading), vector.dot(&self.across()))
    }

    /// From the nearest point of a rectangle to a place, m; zero within it.
    pub(super) fn nearest_to(&self, place: Vector2<f64>) -> Vector2<f64> {
        let (length, width) = self.shape.extents();
        let own = self.own_frame(place - self.centre);
        let beyond = Vector2::new(
            own.x - own.x.clamp(-length / 2.0, length / 2.0),
            own.y - own.y.clamp(-width / 2.0, width / 2.0),
        );
        self.heading * beyond.x + self.across() * beyond.y
    }

    /// How far it reaches from its centre along an axis, m.
    pub(super) fn reach(&self, axis: Vector2<f64>) -> f64 {
        match self.shape {
            Shape::Disc { radius } => radius,
            Shape::Rectangle { length, width } => {
                (length * axis.dot(&self.heading).abs() + width * axis.dot(&self.across()).abs()) / 2.0
            }
        }
    }
}

/// Time in s until the footprints first touch if the pedestrian moves at `relative_velocity` (m/s, pedestrian minus
/// vehicle); 0 if they touch now, `None` if they never will.
pub fn first_contact(
    vehicle: &VehicleState,
    pedestrian: &PedestrianState,
    relative_velocity: Vector2<f64>,
) -> Option<f64> {
    Footprint::from(vehicle).first_contact(&pedestrian.into(), relative_velocity)
}

/// Smallest distance between the footprints in m; 0 when they touch or overlap.
pub fn distance(vehicle: &VehicleState, pedestrian: &PedestrianState) -> f64 {
    if !vehicle.keeps_straight() {
        return apart(&vehicle.into(), &pedestrian.into());
    }
    // Along the axes of a straight road, which are the world's.
    let offset = pedestrian.position - vehicle.position();
    let touch = || first_contact(vehicle, pedestrian, Vector2::zeros()).is_some();
    let half = Vector2::new(vehicle.length / 2.0, vehicle.width / 2.0);
    distance_from_box(half, offset, (pedestrian.heading, pedestrian.shape), touch)
}

/// Smallest distance between two outlines, m; 0 when they touch or overlap.
pub fn apart(one: &Footprint, other: &Footprint) -> f64 {
    let (length, width) = match (one.shape, other.shape) {
        (Shape::Rectangle { length, width }, _) => (length, width),
        (Shape::Disc { .. }, Shape::Rectangle { .. }) => return apart(other, one),
        (Shape::Disc { radius }, Shape::Disc { radius: others }) => {
            return ((other.centre - one.centre).norm() - radius - others).max(0.0);
        }
    };
    let (offset, heading) = (one.own_frame(other.centre - one.centre), one.own_frame(other.heading));
    let touch = || one.first_contact(other, Vector2::zeros()).is_some();
    distance_from_box(Vector2::new(length, width) / 2.0, offset, (heading, other.shape), touch)
}

/// From a rectangle that reaches `half` along the axes to a shape that lies at `offset` from its middle and has this heading, m.
fn distance_from_box(
    half: Vector2<f64>,
    offset: Vector2<f64>,
    (heading, shape): (Vector2<f64>, Shape),
    touch: impl Fn() -> bool,
) -> f64 {
    match shape {
        Shape::Disc { radius } => (distance_to_box(offset, half) - radius).max(0.0),
        Shape::Rectangle { length, width } => {
            if touch() {
                return 0.0;
            }
            // The nearest points of two separate rectangles include a corner of one of them.
            let across = Vector2::new(-heading.y, heading.x);
            let own_half = Vector2::new(length / 2.0, width / 2.0);
            let from_corner = |corner: Vector2<f64>| {
                let place = offset + heading * (own_half.x * corner.x) + across * (own_half.y * corner.y);
                distance_to_box(place, half)
            };
            let to_corner = |corner: Vector2<f64>| {
                let place = half.component_mul(&corner) - offset;
                distance_to_box(Vector2::new(place.dot(&heading), place.dot(&across)), own_half)
            };
            CORNERS
                .iter()
                .flat_map(|&corner| [from_corner(corner), to_corner(corner)])
                .fold(f64::INFINITY, f64::min)
        }
    }
}

const CORNERS: [Vector2<f64>; 4] =
    [Vector2::new(1.0, 1.0), Vector2::new(1.0, -1.0), Vector2::new(-1.0, 1.0), Vector2::new(-1.0, -1.0)];

/// A stretch of time.
struct Interval {
    from: f64,
    to: f64,
}

impl Interval {
    fn always() -> Self {
        Self { from: f64::NEG_INFINITY, to: f64::INFINITY }
    }

    /// The part during which |offset + speed * t| <= reach.
    fn within(self, offset: f64, speed: f64, reach: f64) -> Self {
        if speed == 0.0 {
            return if offset.abs() <= reach {
                self
            } else {
                Self { from: f64::INFINITY, to: f64::NEG_INFINITY }
            };
        }
        let (enter, leave) = ((-reach - offset) / speed, (reach - offset) / speed);
        Self { from: self.from.max(enter.min(leave)), to: self.to.min(enter.max(leave)) }
    }

    /// Its first moment that is not in the past.
    fn first(self) -> Option<f64> {
        (self.from <= self.to && self.to >= 0.0).then(|| self.from.max(0.0))
    }
}

fn box_contact(offset: Vector2<f64>, velocity: Vector2<f64>, half: Vector2<f64>) -> Option<f64> {
    Interval::always().within(offset.x, velocity.x, half.x).within(offset.y, velocity.y, half.y).first()
}

fn circle_contact(offset: Vector2<f64>, velocity: Vector2<f64>, radius: f64) -> Option<f64> {
    let excess = offset.norm_squared() - radius * radius;
    if excess <= 0.0 {
        return Some(0.0);
    }
    let (a, b) = (velocity.norm_squared(), offset.dot(&velocity));
    let discriminant = b * b - a * excess;
    // Approaching, and near enough: the smaller root in the form that does not cancel.
    (b < 0.0 && discriminant >= 0.0).then(|| excess / (-b + discriminant.sqrt()))
}

fn distance_to_box(offset: Vector2<f64>, half: Vector2<f64>) -> f64 {
    Vector2::new((offset.x.abs() - half.x).max(0.0), (offset.y.abs() - half.y).max(0.0)).norm()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Longitudinal;
    use scenario::{Direction, Path};

    fn car() -> VehicleState {
        VehicleState::new(
            Path::straight(0.0, Direction::Forward),
            Longitudinal { travelled: 0.0, speed: 0.0, acceleration: 0.0 },
            (4.0, 2.0),
        )
    }

    fn person(x: f64, y: f64, turn: f64, shape: Shape) -> PedestrianState {
        PedestrianState {
            position: Vector2::new(x, y),
            velocity: Vector2::zeros(),
            acceleration: Vector2::zeros(),
            heading: Vector2::new(libm::cos(turn), libm::sin(turn)),
            shape,
            present: true,
        }
    }

    const DISC: Shape = Shape::Disc { radius: 0.5 };
    const SQUARE: Shape = Shape::Rectangle { length: 1.0, width: 1.0 };

    #[test]
    fn head_on_contact() {
        for shape in [DISC, SQUARE] {
            let ahead = person(10.0, 0.0, 0.0, shape);
            assert_eq!(first_contact(&car(), &ahead, Vector2::new(-5.0, 0.0)), Some(1.5));
            assert_eq!(first_contact(&car(), &ahead, Vector2::new(5.0, 0.0)), None);
            assert_eq!(distance(&car(), &ahead), 7.5);
            assert_eq!(first_contact(&car(), &person(2.2, 1.2, 0.0, shape), Vector2::zeros()), Some(0.0));
        }
    }

    #[test]
    fn a_disc_passes_the_corner_that_a_square_hits() {
        // Along x + y = c, past the corner at (2, 1): the disc reaches 0.5 m, the square half its diagonal.
        let contact =
            |c: f64, shape| first_contact(&car(), &person(c, 0.0, 0.0, shape), Vector2::new(-1.0, 1.0));
        assert!(contact(3.69, DISC).is_some() && contact(3.72, DISC).is_none());
        assert!(contact(3.99, SQUARE).is_some() && contact(4.01, SQUARE).is_none());
    }

    #[test]
    fn a_turned_square_reaches_farther() {
        let turned = person(4.0, 0.0, std::f64::consts::FRAC_PI_4, SQUARE);
        assert!((distance(&car(), &turned) - (2.0 - 0.5 * std::f64::consts::SQRT_2)).abs() < 1e-12);
    }

    fn outline(x: f64, y: f64, turn: f64, kind: u8) -> Footprint {
        let shape = match kind {
            0 => DISC,
            1 => SQUARE,
            _ => Shape::Rectangle { length: 4.0, width: 2.0 },
        };
        Footprint {
            centre: Vector2::new(x, y),
            heading: Vector2::new(libm::cos(turn), libm::sin(turn)),
            shape,
        }
    }

    proptest! {
        /// Held against the distance, which is worked out from corners.
        #[test]
        fn sides_tell_whether_outlines_touch_and_no_more_than_how_far_they_are_apart(
            x in -4.0..4.0, y in -4.0..4.0, turn in 0.0..6.3, own in 0.0..6.3, kinds in (0_u8..2, 0_u8..2),
        ) {
            let shape = |kind| if kind == 0 { DISC } else { Shape::Rectangle { length: 3.0, width: 1.2 } };
            let one = Footprint::from(&person(0.0, 0.0, own, shape(kinds.0)));
            let other = Footprint::from(&person(x, y, turn, shape(kinds.1)));
            let (told, apart) = (one.separation(&other), apart(&one, &other));
            prop_assert_eq!(told <= 0.0, apart == 0.0, "{} told, {} apart", told, apart);
            prop_assert!(told <= apart + 1e-12, "{told} told, {apart} apart");
            // It is exact for discs, and elsewhere never less than by the diagonal of a corner.
            prop_assert!(apart == 0.0 || told >= apart / std::f64::consts::SQRT_2 - 1e-12);
            prop_assert!(kinds == (1, 1) || apart == 0.0 || (told - apart).abs() < 1e-12);
            prop_assert!((other.separation(&one) - told).abs() < 1e-12);
        }

        #[test]
        fn contacts_are_the_same_from_either_side_and_however_the_world_is_turned(
            x in -8.0..8.0, y in -8.0..8.0, turn in 0.0..6.3, own in 0.0..6.3, all in 0.0..6.3,
            vx in -3.0..3.0, vy in -3.0..3.0, kinds in (0_u8..3, 0_u8..3),
        ) {
            let velocity = Vector2::new(vx, vy);
            let (one, other) = (outline(0.0, 0.0, own, kinds.0), outline(x, y, turn, kinds.1));
            let turned = nalgebra::Rotation2::new(all);
            let around = |body: Footprint| Footprint {
                centre: turned * body.centre, heading: turned * body.heading, ..body
            };
            let found = one.first_contact(&other, velocity);
            for again in [
                other.first_contact(&one, -velocity),
                around(one).first_contact(&around(other), turned * velocity),
            ] {
                match (found, again) {
                    (Some(found), Some(again)) => prop_assert!((found - again).abs() < 1e-6, "{found} {again}"),
                    // What just grazes may do so or not by the last bit.
                    (Some(time), None) | (None, Some(time)) => {
                        let at = Footprint { centre: other.centre + velocity * time, ..other };
                        prop_assert!(one.shrunk(1e-6).first_contact(&at.shrunk(1e-6), Vector2::zeros()).is_none());
                    }
                    (None, None) => {}
                }
            }
        }

        #[test]
        fn at_the_contact_time_they_touch(
            x in -8.0..8.0, y in -8.0..8.0, turn in 0.0..6.3, vx in -3.0..3.0, vy in -3.0..3.0, square: bool,
        ) {
            let shape = if square { SQUARE } else { DISC };
            let start = person(x, y, turn, shape);
            let velocity = Vector2::new(vx, vy);
            match first_contact(&car(), &start, velocity) {
                Some(time) if time > 0.0 && time < 100.0 => {
                    let at = |t: f64| { let p = start.position + velocity * t; person(p.x, p.y, turn, shape) };
                    prop_assert!(distance(&car(), &at(time)) < 1e-9);
                    prop_assert!(distance(&car(), &at(time * 0.99)) > 0.0);
                }
                Some(_) => {}
                None => for k in 0..200 {
                    let p = start.position + velocity * (f64::from(k) * 0.05);
                    prop_assert!(distance(&car(), &person(p.x, p.y, turn, shape)) > 0.0);
                },
            }
        }
    }
}
