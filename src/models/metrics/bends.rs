//! Bends: what is measured on a path beside a line is what is measured on a straight road, and what geometry says of a bend.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use nalgebra::{Rotation2, Vector2};

use super::fixture::{FREE_FLOW, request};
use super::metrics;
use crate::{known, standard};
use scenario::geometry::{Piece, Pose, ReferenceLine};
use scenario::{
    Appearance, Bend, ControllerContext, Direction, ModelSetup, PedestrianContext, Position, Settings, Shape,
    Side, TrafficStream, Value, VehicleStart, World,
};
use sim::measure::Measurement;
use sim::{Driven, Observer, RoadUsers, Snapshot, Step, fixture, simulate};

/// Every metric with its defaults, of a run.
fn measured(world: &World) -> Vec<(String, Option<f64>)> {
    let names: Vec<String> = metrics().iter().map(|metric| metric.declaration.name.to_string()).collect();
    let requests: Vec<_> = names.iter().map(|name| known::measured(name)).collect();
    let mut measurement = Measurement::new(world, &requests, &[FREE_FLOW], &[1.4]);
    simulate(&Arc::new(world.clone()), road_users(world), &mut measurement).unwrap();
    names.into_iter().zip(measurement.values()).collect()
}

fn road_users(world: &World) -> RoadUsers {
    let vehicles = world.vehicles.iter().map(|setup| {
        let context =
            ControllerContext { settings: &setup.controller.settings, setup, world, rank: 0, seed: 1 };
        let controller = (setup.controller.model.known().unwrap().build)(&context).unwrap();
        let dynamics = (setup.dynamics.model.known().unwrap().build)(&setup.dynamics.settings).unwrap();
        let perception = setup.sees.as_ref().map(|sees| {
            (sees.model.known().unwrap().build)(&sees.settings, &context, controller.schedule()).unwrap()
        });
        Driven { perception, ..Driven::new(controller, dynamics) }
    });
    let pedestrians = world.pedestrians.iter().map(|setup| {
        let context = PedestrianContext { settings: &setup.model.settings, setup, world, rank: 0, seed: 1 };
        (setup.model.model.known().unwrap().build)(&context).unwrap()
    });
    RoadUsers { vehicles: vehicles.collect(), pedestrians: pedestrians.collect() }
}

/// A car of `controller` that comes on lane 0 of two, and a person of `model` who crosses from `side`.
fn world(controller: &str, model: &str, settings: &[(&str, f64)], side: Side, start: f64) -> World {
    let registry = standard();
    let mut world = fixture::world();
    world.road.lanes.push(scenario::Lane { direction: Direction::Backward });
    let car = &mut world.vehicles[0];
    let entry = registry.controllers().get(controller).unwrap();
    car.controller = ModelSetup::resolved(entry, &Settings::default()).unwrap();
    let dynamics = entry.default_dynamics.known().unwrap();
    let dynamics = registry.dynamics().get(&dynamics.declaration.name).unwrap();
    car.dynamics = ModelSetup::resolved(dynamics, &Settings::default()).unwrap();
    car.start = VehicleStart::Distance(start);
    // A stream of one: whoever goes has met its first and last vehicle.
    world.streams = vec![TrafficStream { name: "cars".into(), vehicles: vec![0], arrivals: vec![1.0] }];
    let person = &mut world.pedestrians[0];
    let given = settings.iter().map(|(name, value)| (name.to_string(), Value::Number(*value)));
    let entry = registry.pedestrians().get(model).unwrap();
    person.model = ModelSetup::resolved(entry, &Settings(given.collect())).unwrap();
    person.shape = Shape::Rectangle { length: 0.6, width: 0.5 };
    person.side = side;
    let (near, far) = (Position { x: 0.0, y: -4.0 }, Position { x: 0.0, y: 8.0 });
    (person.start, person.goal) = if side == Side::Near { (near, far) } else { (far, near) };
    world.horizon = 30.0;
    world
}

/// The same world with its road made of a line, turned by `angle` (rad) about the origin.
fn made_of_a_line(world: &World, angle: f64) -> World {
    let turned = Rotation2::new(angle);
    let start = Pose { point: turned * Vector2::new(-250.0, 0.0), heading: angle, curvature: 0.0 };
    let pieces = [Piece::line(200.0), Piece::line(200.0)];
    let line = Arc::new(ReferenceLine::new(start, &pieces).unwrap());
    let mut world = world.clone();
    world.road.bend = Some(Bend { line, crossing: 250.0 });
    for person in &mut world.pedestrians {
        for place in [&mut person.start, &mut person.goal] {
            let at = turned * Vector2::new(place.x, place.y);
            *place = Position { x: at.x, y: at.y };
        }
    }
    world
}

fn assert_alike(one: &World, other: &World, tolerance: f64, what: &str) {
    for ((name, found), (_, expected)) in measured(other).into_iter().zip(measured(one)) {
        match (found, expected) {
            (Some(found), Some(expected)) => {
                let apart = (found - expected).abs();
                assert!(
                    apart <= tolerance * (1.0 + expected.abs()),
                    "{what}: {name} is {found}, not {expected}"
                );
            }
            (None, None) => {}
            other => panic!("{what}: {name} is {other:?}"),
        }
    }
}

#[test]
fn a_line_measures_the_same_however_it_is_turned() {
    // Odd numbers: what is decided where something is exactly reached may be decided a step later for rounding.
    let scripted: &[(&str, f64)] = &[("speed", 1.577)];
    let people =
        [("scripted", scripted), ("scripted", &[("delay", 1.013)]), ("social_force", &[("noise", 0.0)])];
    let mut values = 0;
    for controller in ["constant_speed", "carla_behavior", "yielding", "careful_human", "idm_aeb"] {
        for (model, settings) in people {
            for (side, lane, start) in [
                (Side::Near, 0, 25.137),
                (Side::Near, 0, 31.071),
                (Side::Near, 0, 60.313),
                (Side::Far, 0, 66.119),
                (Side::Far, 1, 28.211),
                (Side::Near, 1, 62.017),
            ] {
                let mut straight = world(controller, model, settings, side, start);
                straight.vehicles[0].lane = lane;
                // Whether somebody comes nearer to a standing car is asked there, which at a right angle rounding decides.
                if controller == "idm_aeb" {
                    straight.pedestrians[0].goal.x = 0.317;
                } else if lane == 1 {
                    let reference = scenario::VehicleReference::Front;
                    straight.pedestrians[0].appears =
                        Appearance::TimeToArrival { vehicle: 0, reference, time: 2.3137 };
                }
                values += measured(&straight).iter().filter(|(_, value)| value.is_some()).count();
                for degrees in [0.0, 37.0, 90.0] {
                    let line = made_of_a_line(&straight, f64::to_radians(degrees));
                    let what = format!("{controller}, {model}, {side:?}, lane {lane}, {start} m, {degrees}°");
                    assert_alike(&straight, &line, 1e-9, &what);
                }
            }
        }
    }
    assert!(values > 1000, "{values} values were compared");
}

/// How near the two come, m: it is defined in every run.
fn nearest(world: &World) -> f64 {
    measured(world).into_iter().find(|(name, _)| name == "min_distance").unwrap().1.unwrap()
}

/// Some decisions are a matter of rounding, on straight roads as well: whether somebody stops at the edge of the conflict space, or comes nearer to
/// a car that stands exactly abreast. What comes of a run that begins less than 1 pm elsewhere is as good.
fn as_good_as(world: &World) -> Vec<f64> {
    let other = |offset: i32| {
        let mut other = world.clone();
        let VehicleStart::Distance(start) = other.vehicles[0].start else { unreachable!() };
        other.vehicles[0].start = VehicleStart::Distance(start + 1e-13 * f64::from(offset));
        other.pedestrians[0].start.y *= 1.0 + 2e-16 * f64::from(offset);
        other.pedestrians[0].start.x += 1e-14 * f64::from(offset);
        nearest(&other)
    };
    (-6..7).map(other).collect()
}

/// People come as near in the one world as in the other, in most of so many runs; in the others as rounding could have made it, or nearly.
fn assert_same_people(pairs: &[(World, World, String)]) {
    let mut same = 0;
    for (one, other, what) in pairs {
        let (expected, found) = (nearest(one), nearest(other));
        if (found - expected).abs() < 1e-6 {
            same += 1;
            continue;
        }
        let as_good = as_good_as(one);
        let (low, high) =
            as_good.iter().fold((expected, expected), |(low, high), one| (low.min(*one), high.max(*one)));
        // Each decision, 0.1 s after the other, may fall differently, so that it comes to something between, or nearly.
        assert!(low - 0.1 < found && found < high + 0.1, "{what}: {found} m, not {low} m to {high} m");
    }
    assert!(4 * same >= 3 * pairs.len(), "{same} of {}", pairs.len());
}

#[test]
fn people_cross_a_line_as_a_straight_road_however_it_is_turned() {
    for model in ["commotions", "carla_walker", "jaywalker", "interceptor"] {
        assert_same_people(&lines_crossed_by(model));
    }
}

/// Straight roads and the same made of a line.
fn lines_crossed_by(model: &str) -> Vec<(World, World, String)> {
    let mut pairs = Vec::new();
    for controller in ["constant_speed", "carla_behavior", "yielding", "careful_human"] {
        for (side, lane, start) in [
            (Side::Near, 0, 25.137),
            (Side::Near, 0, 31.071),
            (Side::Near, 0, 60.313),
            (Side::Far, 0, 66.119),
            (Side::Far, 1, 28.211),
            (Side::Near, 1, 62.017),
        ] {
            let mut straight = world(controller, model, &[], side, start);
            straight.vehicles[0].lane = lane;
            for degrees in [0.0, 37.0, 90.0] {
                let line = made_of_a_line(&straight, f64::to_radians(degrees));
                let what = format!("{controller}, {model}, {side:?}, lane {lane}, {start} m, {degrees}°");
                pairs.push((straight.clone(), line, what));
            }
        }
    }
    pairs
}

#[test]
fn people_cross_a_right_bend_as_the_mirror_image_of_a_left_one() {
    let mut pairs = Vec::new();
    let mut crossed = Vec::new();
    for (controller, start) in
        [("constant_speed", 14.0), ("constant_speed", 26.0), ("careful_human", 25.0), ("yielding", 21.3)]
    {
        for (radius, skew) in [(20.0, 0.0), (12.0, 0.0), (20.0, 2.5), (12.0, -2.5)] {
            let mut straight = world(controller, "commotions", &[], Side::Near, start);
            straight.road.lanes.truncate(1);
            (straight.vehicles[0].speed, straight.finish) = (5.0, 12.0);
            straight.pedestrians[0].goal.x = skew;
            let (left, mut right) = (on_circle(&straight, radius, 30.0), on_circle(&straight, -radius, 30.0));
            let person = &mut right.pedestrians[0];
            let pose = right.road.bend.as_ref().unwrap().line.pose(30.0);
            let mirrored = |place: Position| {
                let beside = (Vector2::from(place) - pose.point).dot(&pose.normal());
                let point = Vector2::from(place) - pose.normal() * (2.0 * beside);
                Position { x: point.x, y: point.y }
            };
            (person.start, person.goal, person.side) =
                (mirrored(person.start), mirrored(person.goal), Side::Far);
            crossed.push(nearest(&left));
            pairs.push((left, right, format!("{controller}, {start} m, {radius} m, {skew} m")));
        }
    }
    assert_same_people(&pairs);
    // The bend and the angle make a difference.
    crossed.sort_by(f64::total_cmp);
    crossed.dedup_by(|one, other| (*one - *other).abs() < 1e-6);
    assert!(crossed.len() > 8, "{crossed:?}");
}

#[test]
fn what_a_sensor_sees_does_not_depend_on_how_the_line_is_turned() {
    let sees = |pairs: &[(&str, f64)]| {
        let given = pairs.iter().map(|(name, value)| (name.to_string(), Value::Number(*value)));
        Some(ModelSetup::resolved(standard().perception(), &Settings(given.collect())).unwrap())
    };
    let mut apart = 0;
    for pairs in [&[("range", 15.0)], &[("field_of_view", 0.3)], &[("latency", 0.5)]] {
        let mut straight = world("yielding", "scripted", &[("speed", 1.577)], Side::Near, 40.137);
        let seen_at_once = measured(&straight);
        straight.vehicles[0].sees = sees(pairs);
        apart += usize::from(measured(&straight) != seen_at_once);
        for angle in [0.0, 0.6, FRAC_PI_2] {
            assert_alike(&straight, &made_of_a_line(&straight, angle), 1e-9, &format!("{pairs:?} {angle}"));
        }
    }
    assert_eq!(apart, 3, "each of them makes a difference");
}

/// A road that is a circle about `radius` (m) for 5/6 of it, whose crossing is so far (m) behind its beginning.
fn circle(radius: f64, crossing: f64) -> Bend {
    let line = ReferenceLine::new(Pose::origin(), &[Piece::arc(radius, PI * 5.0 / 3.0)]).unwrap();
    Bend { line: Arc::new(line), crossing }
}

/// A car that comes along the circle and a person who crosses it along its radius, the crossing being anywhere on it.
fn on_circle(straight: &World, radius: f64, crossing: f64) -> World {
    let mut world = straight.clone();
    let bend = circle(radius, crossing);
    let pose = bend.line.pose(crossing);
    world.road.bend = Some(bend);
    for person in &mut world.pedestrians {
        for place in [&mut person.start, &mut person.goal] {
            let at = pose.point + pose.tangent() * place.x + pose.normal() * place.y;
            *place = Position { x: at.x, y: at.y };
        }
    }
    world
}

#[test]
fn a_circle_is_the_same_at_every_place_of_it() {
    for (controller, start) in [("constant_speed", 14.0), ("constant_speed", 26.0), ("careful_human", 25.0)] {
        for lane in [0, 1] {
            let mut straight = world(controller, "scripted", &[("speed", 1.5)], Side::Near, start);
            straight.vehicles[0].lane = lane;
            (straight.vehicles[0].speed, straight.finish) = (5.0, 12.0);
            let one = on_circle(&straight, 20.0, 40.0);
            for crossing in [47.3, 55.0, 62.0] {
                let other = on_circle(&straight, 20.0, crossing);
                assert_alike(
                    &one,
                    &other,
                    1e-7,
                    &format!("{controller}, {start} m, lane {lane}, {crossing} m"),
                );
            }
            let mirrored = |world: &World| {
                let mut world = world.clone();
                world.road.lanes.truncate(1);
                world
            };
            if lane == 0 {
                let (left, mut right) = (mirrored(&one), mirrored(&on_circle(&straight, -20.0, 40.0)));
                // Who comes from the near side to the left bend comes from the far side to the right one.
                let person = &mut right.pedestrians[0];
                let at = |place: Position| {
                    let pose = right.road.bend.as_ref().unwrap().line.pose(40.0);
                    let beside = (Vector2::from(place) - pose.point).dot(&pose.normal());
                    let point = pose.point - pose.normal() * beside;
                    Position { x: point.x, y: point.y }
                };
                (person.start, person.goal, person.side) = (at(person.start), at(person.goal), Side::Far);
                assert_alike(&left, &right, 1e-7, &format!("{controller}, {start} m, mirrored"));
            }
        }
    }
}

/// Where everybody is, after every step.
#[derive(Default)]
struct Course(Vec<(f64, Snapshot)>);

impl Observer for Course {
    fn observe(&mut self, step: &Step) {
        self.0.push((step.time + step.duration, step.after.clone()));
    }
}

#[test]
fn whoever_stands_beside_a_bend_is_on_no_collision_course_but_round_it_they_are() {
    let straight = world("constant_speed", "scripted", &[("speed", 0.0)], Side::Near, 22.0);
    let of = |world: &World, name: &str| measured(world).into_iter().find(|(one, _)| one == name).unwrap().1;
    let mut round = on_circle(&straight, 20.0, 40.0);
    let standing = |world: &mut World, beside: f64| {
        let pose = world.road.bend.as_ref().unwrap().line.pose(40.0);
        let at = pose.point + pose.normal() * beside;
        world.pedestrians[0].start = Position { x: at.x, y: at.y };
    };
    // Somebody who stands in the lane, 22 m of arc away: straight on they would be missed by far.
    standing(&mut round, 0.0);
    assert_eq!(of(&round, "collision"), Some(1.0));
    // Straight ahead of the car where it starts, and beside the bend: never on a collision course with it.
    let mut beside = on_circle(&straight, 20.0, 40.0);
    let ahead = beside.road.bend.as_ref().unwrap().line.pose(18.0);
    let at = ahead.point + ahead.tangent() * 14.0;
    beside.pedestrians[0].start = Position { x: at.x, y: at.y };
    assert_eq!((of(&beside, "min_ttc"), of(&beside, "collision")), (None, Some(0.0)));
}

/// A metric with a word for one of its parameters.
fn with_word(world: &World, name: &str, parameter: &str, word: &str) -> Option<f64> {
    let request = request(name, [(parameter, Value::Word(word.into()))]);
    let mut measurement = Measurement::new(world, &[request], &[FREE_FLOW], &[1.4]);
    simulate(&Arc::new(world.clone()), road_users(world), &mut measurement).unwrap();
    measurement.values()[0]
}

#[test]
fn straight_on_from_a_bend_other_people_are_met_than_along_it() {
    let mut straight = world("constant_speed", "scripted", &[("speed", 0.0)], Side::Near, 22.0);
    (straight.vehicles[0].speed, straight.horizon) = (5.0, 1.0);
    let mut standing = |beside: f64, ahead: f64| {
        straight.pedestrians[0].start = Position { x: 0.0, y: 0.0 };
        let mut round = on_circle(&straight, 20.0, 40.0);
        let line = round.road.bend.as_ref().unwrap().line.clone();
        let pose = line.pose(if ahead > 0.0 { 18.0 } else { 40.0 });
        let at = pose.point + pose.tangent() * ahead + pose.normal() * beside;
        round.pedestrians[0].start = Position { x: at.x, y: at.y };
        round
    };
    // Round the bend: 17 m of arc are left when time is up, less half the car and the person.
    let round = standing(0.0, 0.0);
    let course = with_word(&round, "min_ttc", "prediction", "course").unwrap();
    assert!((course - (17.0 - 2.0 - 0.3) / 5.0).abs() < 0.03, "{course} s");
    assert_eq!(with_word(&round, "min_ttc", "prediction", "straight"), None);
    assert_eq!(with_word(&round, "drac", "prediction", "straight"), None);
    assert!(with_word(&round, "drac", "prediction", "course").is_some());
    // Straight ahead of where it starts, beside the bend.
    let beside = standing(0.0, 14.0);
    assert_eq!(with_word(&beside, "min_ttc", "prediction", "course"), None);
    assert!(with_word(&beside, "min_ttc", "prediction", "straight").is_some());
    assert!(with_word(&beside, "drac", "prediction", "straight").is_some());
}

#[test]
fn a_bend_is_felt_by_its_radius_and_the_square_of_the_speed() {
    for (lane, radius) in [(0, 20.0), (1, 16.0)] {
        let mut straight = world("constant_speed", "scripted", &[("speed", 1.5)], Side::Near, 22.0);
        straight.vehicles[0].lane = lane;
        (straight.vehicles[0].speed, straight.finish) = (5.0, 12.0);
        let of = |world: &World| {
            let found = measured(world).into_iter().find(|(name, _)| name == "lateral_acceleration");
            found.unwrap().1.unwrap()
        };
        assert_eq!(of(&straight), 0.0);
        for side in [1.0, -1.0] {
            // To the right lane 1 is the outer one.
            let radius = if side < 0.0 && lane == 1 { 24.0 } else { radius };
            let found = of(&on_circle(&straight, 20.0 * side, 40.0));
            assert!((found - 25.0 / radius).abs() < 1e-9, "lane {lane}, {side}: {found} m/s²");
        }
        // A bend that is over within a step counts as any other.
        let pieces = [Piece::line(29.95), Piece::arc(5.0, 0.004), Piece::line(40.0)];
        let line = ReferenceLine::new(Pose::origin(), &pieces).unwrap();
        let mut short = straight.clone();
        (short.vehicles[0].speed, short.step) = (5.0, 0.05);
        short.road.lanes.truncate(1);
        short.vehicles[0].lane = 0;
        short.road.bend = Some(Bend { line: Arc::new(line), crossing: 35.0 });
        assert!((of(&short) - 5.0).abs() < 1e-9, "{}", of(&short));
    }
}

#[test]
fn the_area_of_a_turning_car_is_what_its_rectangle_touches() {
    // Disc of 0.25 m at 1.5 m/s along the radius; car of 4 m by 2 m at 5 m/s on a circle of 12 m.
    let (radius, speed, walk) = (12.0_f64, 5.0, 1.5);
    for (start, first) in [(4.0, "vehicle"), (30.0, "pedestrian")] {
        let mut straight = world("constant_speed", "scripted", &[("speed", walk)], Side::Near, start);
        straight.road.lanes.truncate(1);
        (straight.vehicles[0].speed, straight.finish, straight.step) = (speed, 20.0, 0.005);
        straight.pedestrians[0].shape = Shape::Disc { radius: 0.25 };
        straight.pedestrians[0].goal.y = 4.0;
        let world = on_circle(&straight, radius, 30.0);
        let found = measured(&world).into_iter().find(|(name, _)| name == "pet_area").unwrap().1.unwrap();
        // By hand: seen from the centre, the car's rectangle at angle 0 lies at (along, out) in [−2, 2] × [11, 13].
        let outside = (13.0_f64.powi(2) + 4.0).sqrt() - radius;
        let (enter, leave) = ((4.0 - outside - 0.25) / walk, (4.0 + 1.0 + 0.25) / walk);
        let touches = |angle: f64| {
            (0..=4000).any(|step| {
                let out = radius + outside + 0.25 - (outside + 1.5) * f64::from(step) / 4000.0;
                let (along, across) = (out * libm::sin(angle), out * libm::cos(angle));
                let gap =
                    Vector2::new((along.abs() - 2.0).max(0.0), ((across - radius).abs() - 1.0).max(0.0));
                gap.norm() <= 0.25
            })
        };
        let reach = (0..4000).map(|step| f64::from(step) * 1e-4).take_while(|angle| touches(*angle)).last();
        let reach = reach.unwrap() * radius;
        let (arrives, gone) = ((start - reach) / speed, (start + reach) / speed);
        let expected = if first == "vehicle" { enter - gone } else { arrives - leave };
        assert!((found - expected).abs() < 5e-3, "{first} first: {found} s, not {expected} s");
    }
}

#[test]
fn a_collision_in_a_bend_is_where_the_rectangles_touch() {
    let mut straight = world("constant_speed", "scripted", &[("speed", 1.5)], Side::Near, 16.0);
    (straight.vehicles[0].speed, straight.finish) = (5.0, 12.0);
    for (radius, step) in [(9.0, 0.025), (9.0, 0.005), (-9.0, 0.025)] {
        let mut world = on_circle(&straight, radius, 20.0);
        world.step = step;
        world.road.lanes.truncate(1);
        let mut course = Course::default();
        simulate(&Arc::new(world.clone()), road_users(&world), &mut course).unwrap();
        let (_, last) = course.0.last().unwrap();
        let gap = sim::geometry::distance(&last.vehicles[0], &last.pedestrians[0]);
        assert!(gap < 1e-8, "{radius}: {gap} m apart");
        let (_, before) = &course.0[course.0.len() - 2];
        assert!(sim::geometry::distance(&before.vehicles[0], &before.pedestrians[0]) > 0.0);
    }
}
