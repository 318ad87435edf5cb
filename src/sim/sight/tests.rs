//! What hides and what does not.

use proptest::prelude::*;

use super::*;

fn at(x: f64, y: f64) -> Vector2<f64> {
    Vector2::new(x, y)
}

fn turned(vector: Vector2<f64>, angle: f64) -> Vector2<f64> {
    let (sine, cosine) = libm::sincos(angle);
    at(cosine * vector.x - sine * vector.y, sine * vector.x + cosine * vector.y)
}

fn rectangle(centre: Vector2<f64>, length: f64, width: f64, angle: f64) -> Footprint {
    Footprint { centre, heading: turned(Vector2::x(), angle), shape: Shape::Rectangle { length, width } }
}

fn disc(centre: Vector2<f64>, radius: f64) -> Footprint {
    Footprint { centre, heading: Vector2::x(), shape: Shape::Disc { radius } }
}

/// From the origin.
fn hidden(body: &Footprint, movers: &[Footprint]) -> bool {
    is_hidden(Vector2::zeros(), body, movers.iter().copied(), std::iter::empty())
}

#[test]
fn a_bus_hides_whoever_is_behind_it_and_a_car_at_its_side_does_not() {
    let bus = rectangle(at(10.0, 0.0), 12.0, 2.5, std::f64::consts::FRAC_PI_2);
    let walker = disc(at(14.0, 1.0), 0.25);
    assert!(hidden(&walker, &[bus]));
    assert!(!hidden(&disc(at(6.0, 1.0), 0.25), &[bus]), "before it");
    assert!(!hidden(&disc(at(14.0, 12.0), 0.25), &[bus]), "beside it");
    assert!(!hidden(&disc(at(-14.0, 1.0), 0.25), &[bus]), "on the other side of the eye");
    assert!(!hidden(&bus, &[walker]), "who is behind it does not hide the bus");
}

/// As with a box: what covers from one side hides when it covers the centre, to the last bit.
#[test]
fn what_covers_from_one_side_hides_when_it_covers_the_centre() {
    let wall = |edge: f64| rectangle(at(5.0, edge - 10.0), 1.0, 20.0, 0.0);
    for radius in [0.1, 0.25, 1.0] {
        let walker = disc(at(20.0, 0.0), radius);
        assert!(!hidden(&walker, &[wall(-1e-9)]) && hidden(&walker, &[wall(1e-9)]), "{radius}");
        assert_eq!(hidden(&walker, &[wall(0.0)]), wall(0.0).is_crossed(at(0.0, 0.0), at(20.0, 0.0)));
    }
}

#[test]
fn a_narrow_body_hides_no_wide_one_but_several_together_do() {
    let bus = rectangle(at(20.0, 0.0), 2.5, 10.0, 0.0);
    let people: Vec<_> = (-8..=8).map(|k| disc(at(10.0, f64::from(k) * 0.4), 0.25)).collect();
    assert!(!hidden(&bus, &people[8..9]), "one person before its middle");
    assert!(!hidden(&bus, &people[7..10]));
    assert!(hidden(&bus, &people), "a row of them");
    let child = disc(at(12.0, 0.0), 0.2);
    assert!(hidden(&child, &people[8..9]), "a child behind a grown-up");
    assert!(!hidden(&people[8], &[child]), "but not the grown-up behind whom it is");
    // A narrow pole covers the centre of a grown-up, and of the five strips only that.
    assert!(!hidden(&disc(at(12.0, 0.0), 0.3), &[disc(at(11.0, 0.0), 0.05)]));
}

/// A box covers one half but for the centre, somebody the other half but for the centre: neither hides alone.
#[test]
fn boxes_and_who_moves_hide_together() {
    let walker = disc(at(20.0, 0.0), 0.5);
    let right = rectangle(at(10.0, -5.025), 1.0, 10.0, 0.0);
    let left = rectangle(at(10.0, 5.025), 1.0, 10.0, 0.0);
    let eye = Vector2::zeros();
    let covered = |movers: &[Footprint], boxes: &[Footprint]| {
        is_hidden(eye, &walker, movers.iter().copied(), boxes.iter().copied())
    };
    assert!(!covered(&[left], &[]) && !is_behind_a_box(eye, walker.centre, [right].into_iter()));
    assert!(covered(&[left], &[right]) && covered(&[left, right], &[]));
    assert!(!covered(&[], &[left, right]), "what boxes hide alone is their own rule");
}

#[test]
fn who_touches_or_overlaps_does_not_hide_what_is_inside() {
    let walker = disc(at(10.0, 0.0), 0.25);
    let car = rectangle(at(12.25, 0.0), 4.0, 1.8, 0.0);
    assert!(!hidden(&walker, &[car]), "it touches from behind");
    assert!(hidden(&walker, &[rectangle(at(7.75, 0.0), 4.0, 1.8, 0.0)]), "it touches from before");
    assert!(!hidden(&walker, &[rectangle(at(10.0, 0.0), 4.0, 1.8, 0.0)]), "it is run over");
    // Two in one place hide each other neither.
    let twin = disc(at(10.05, 0.02), 0.25);
    assert!(!hidden(&walker, &[twin]) && !hidden(&twin, &[walker]));
    assert!(!hidden(&walker, &[disc(at(0.1, 0.0), 0.25)]), "a body over the eye");
    assert!(!hidden(&disc(at(0.0, 0.0), 0.25), &[disc(at(0.1, 0.0), 0.05)]), "the eye is its centre");
}

#[test]
fn the_strips_of_a_turned_rectangle_lie_inside_it_and_are_evenly_wide() {
    for angle in [0.0, 0.3, 1.0, std::f64::consts::FRAC_PI_2, 2.5] {
        let body = rectangle(at(30.0, 4.0), 4.5, 1.8, angle);
        let sight = at(30.0, 4.0).normalize();
        let left = at(-sight.y, sight.x);
        let offsets = STRIPS.map(|share| {
            let point = middle_of_strip(&body, sight, share);
            assert!(body.is_over(point), "{angle} {share}");
            (point - body.centre).dot(&left)
        });
        for pair in offsets.windows(2) {
            assert!((pair[1] - pair[0] - 0.4 * body.reach(left)).abs() < 1e-9, "{angle}");
        }
        assert!((middle_of_strip(&body, sight, 0.0) - body.centre).norm() < 1e-12);
    }
}

fn body() -> impl Strategy<Value = Footprint> {
    let place = (2.0..40.0, -15.0..15.0).prop_map(|(x, y)| at(x, y));
    prop_oneof![
        (place.clone(), 0.1..0.5).prop_map(|(centre, radius)| disc(centre, radius)),
        (place, 0.5..12.0, 0.4..2.6, 0.0..6.3)
            .prop_map(|(centre, length, width, angle)| rectangle(centre, length, width, angle)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn neither_order_nor_mirror_nor_turn_matters(
        one in body(),
        movers in prop::collection::vec(body(), 1..5),
        angle in 0.0..6.3,
    ) {
        let before = hidden(&one, &movers);
        let mut other = movers.clone();
        other.reverse();
        prop_assert_eq!(hidden(&one, &other), before);
        let mirror = |vector: Vector2<f64>| at(vector.x, -vector.y);
        let mirrored = |body: &Footprint| Footprint {
            centre: mirror(body.centre), heading: mirror(body.heading), shape: body.shape
        };
        prop_assert_eq!(hidden(&mirrored(&one), &movers.iter().map(mirrored).collect::<Vec<_>>()), before);
        let turn = |body: &Footprint| Footprint {
            centre: turned(body.centre, angle), heading: turned(body.heading, angle), shape: body.shape
        };
        prop_assert_eq!(hidden(&turn(&one), &movers.iter().map(turn).collect::<Vec<_>>()), before);
    }

    #[test]
    fn one_more_uncovers_nobody_and_one_who_is_farther_or_beside_covers_nobody(
        one in body(),
        movers in prop::collection::vec(body(), 0..4),
        more in body(),
    ) {
        let before = hidden(&one, &movers);
        let mut all = movers.clone();
        all.push(more);
        prop_assert!(!before || hidden(&one, &all));
        let (mut farther, mut behind) = (movers.clone(), movers);
        farther.push(Footprint { centre: one.centre.normalize() * (one.centre.norm() + one.radius() + more.radius()), ..more });
        prop_assert_eq!(hidden(&one, &farther), before);
        // A long body beside the eye reaches behind it, too.
        behind.push(Footprint { centre: at(-more.radius() - one.radius(), more.centre.y), ..more });
        prop_assert_eq!(hidden(&one, &behind), before);
    }

    /// Between two points anybody who is between them is between them from either side.
    #[test]
    fn between_points_it_is_mutual(
        (here, there) in ((-40.0..0.0, -15.0..15.0), (2.0..40.0, -15.0..15.0)),
        movers in prop::collection::vec(body(), 1..4),
    ) {
        let (here, there) = (at(here.0, here.1), at(there.0, there.1));
        let sees = |eye, place| !is_hidden(eye, &disc(place, 1e-9), movers.iter().copied(), std::iter::empty());
        prop_assert_eq!(sees(here, there), sees(there, here));
    }
}

/// From a person at the kerb, a vehicle 20 m away on the next lane: what stands before it, of these lengths, and boxes.
#[test]
fn people_look_over_cars_and_past_people_but_not_over_buses_and_boxes() {
    use crate::fixture::world;
    use scenario::agent::{Longitudinal, VehicleState};
    use scenario::{Body, Direction, Path};

    let mut road = world().road;
    let people: Vec<_> = [at(0.0, -2.3), at(-1.0, -2.0)]
        .map(|position| scenario::agent::PedestrianState {
            position,
            velocity: at(0.0, 0.0),
            acceleration: at(0.0, 0.0),
            heading: Vector2::y(),
            shape: Shape::Disc { radius: 0.3 },
            present: true,
        })
        .to_vec();
    let vehicle = |place: f64, y: f64, length: f64| {
        VehicleState::new(
            Path::straight(y, Direction::Forward),
            Longitudinal { travelled: place, speed: 0.0, acceleration: 0.0 },
            (length, 1.8),
        )
    };
    let sees = |road: &scenario::Road, vehicles: &[VehicleState]| {
        let goal = scenario::Position { x: 0.0, y: 8.0 };
        let (crossing, legs) = (0, (0, 0));
        let scene = Scene {
            time: 0.0,
            step: 0.1,
            road,
            crossing,
            me: 0,
            goal,
            legs,
            vehicles,
            pedestrians: &people,
            held: false,
        };
        sees_vehicle(&scene, 0)
    };
    let far = vehicle(-20.0, 3.5, 4.5);
    assert!(sees(&road, std::slice::from_ref(&far)));
    for (length, seen) in [(4.5, true), (LOOKED_OVER, true), (5.51, false), (12.0, false)] {
        let before = vehicle(-2.0 - length / 2.0, 0.0, length);
        let beside = vehicle(2.0 + length / 2.0, 0.0, length);
        assert_eq!(sees(&road, &[far.clone(), before]), seen, "{length}");
        assert!(sees(&road, &[far.clone(), beside]), "{length}");
    }
    road.boxes = vec![Body { name: "box".into(), x: -8.0, y: 0.0, length: 4.5, width: 1.8, heading: 0.0 }];
    assert!(!sees(&road, std::slice::from_ref(&far)));
}
