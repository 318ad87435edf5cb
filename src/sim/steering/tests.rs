use std::sync::Arc;

use nalgebra::Vector2;
use proptest::prelude::*;
use scenario::Direction;
use scenario::geometry::{CurvedPath, Pose, ReferenceLine};

use super::*;

const STEP: f64 = 0.025;

fn steering(grip: f64) -> Steering {
    Steering { axle: 1.35, behind: 0.0, grip, slope: 0.0 }
}

fn car(path: Path, speed: f64) -> VehicleState {
    let motion = Longitudinal { travelled: 0.0, speed, acceleration: 0.0 };
    VehicleState::new(path, motion, (4.5, 1.8))
}

fn straight(direction: Direction) -> Path {
    Path::straight(0.0, direction)
}

/// An arc about `radius` m that is as long as it may be.
fn bend(radius: f64) -> Path {
    let pieces = [Piece::line(20.0), Piece::arc(radius, 3.0), Piece::line(20.0)];
    let line = ReferenceLine::new(Pose::origin(), &pieces).unwrap();
    Path::curved(CurvedPath::new(Arc::new(line), 0.0, Direction::Forward, 0.0).unwrap())
}

/// Drives on at an acceleration (m/s²), with what is asked at each time.
fn drive(
    car: &mut VehicleState,
    how: &Steering,
    acceleration: f64,
    (seconds, step): (f64, f64),
    asked: impl Fn(f64, &VehicleState) -> Option<f64>,
) {
    for index in 0..(seconds / step).round() as usize {
        let (before, asked) = (car.motion, asked(index as f64 * step, car));
        car.motion.accelerate(acceleration, step);
        how.follow(car, before, asked, step);
    }
}

fn rear(car: &VehicleState) -> Vector2<f64> {
    let steered = car.steered.unwrap();
    steered.centre - steered.heading * steered.axle
}

#[test]
fn a_held_curvature_is_a_circle_of_the_rear_axle() {
    let mut car = car(straight(Direction::Forward), 5.0);
    let how = steering(9.0);
    drive(&mut car, &how, 0.0, (2.0, STEP), |_, _| Some(0.1));
    let centre = rear(&car) + car.steered.unwrap().left() * 10.0;
    for _ in 0..400 {
        drive(&mut car, &how, 0.0, (STEP, STEP), |_, _| Some(0.1));
        assert!(((rear(&car) - centre).norm() - 10.0).abs() < 1e-9);
        // The centre of the body goes round farther out, and over ground as fast as that makes it.
        let out = libm::hypot(10.0, 1.35);
        assert!((car.velocity().norm() - 5.0 * out / 10.0).abs() < 1e-9);
        assert!((car.heading().norm() - 1.0).abs() < 1e-15);
    }
}

#[test]
fn wheels_take_their_time_and_go_no_farther_than_they_do() {
    let mut car = car(straight(Direction::Forward), 1.0);
    let how = steering(9.0);
    let mut last = 0.0;
    for index in 1..200 {
        drive(&mut car, &how, 0.0, (STEP, STEP), |_, _| Some(5.0));
        let angle = car.steered.unwrap().steering_angle;
        assert!(angle - last <= FASTEST * STEP + 1e-12);
        assert!((angle - (FASTEST * STEP * f64::from(index)).min(LARGEST)).abs() < 1e-9);
        last = angle;
    }
    // The outer front corner of a car of 4.74 m x 1.76 m then goes round within 5.85 m.
    let axle = REAR_AXLE * 4.74;
    let radius = 2.0 * axle / libm::tan(LARGEST);
    let corner = libm::hypot(radius + 0.88, axle + 2.37);
    assert!((5.80..=5.87).contains(&corner), "{corner} m");
}

#[test]
fn tyres_hold_so_much_in_all_directions_together() {
    for (grip, braking) in [(9.0, 0.0), (9.0, 4.0), (9.0, 8.5), (4.0, 3.0)] {
        let mut car = car(straight(Direction::Forward), 15.0);
        let how = steering(grip);
        for _ in 0..60 {
            drive(&mut car, &how, -braking, (STEP, STEP), |_, _| Some(0.2));
            let lateral = car.steered.unwrap().curvature * car.motion.speed * car.motion.speed;
            assert!(libm::hypot(lateral, braking) <= grip + 1e-9, "{lateral} and {braking} of {grip} m/s²");
        }
    }
    // Who brakes by all that they hold, or more, goes straight on.
    let mut locked = car(straight(Direction::Forward), 15.0);
    drive(&mut locked, &steering(5.0), -6.0, (1.0, STEP), |_, _| Some(0.2));
    assert_eq!(locked.steered.unwrap().offset, 0.0);
}

#[test]
fn it_stands_where_it_stops() {
    let mut car = car(straight(Direction::Forward), 3.0);
    let how = steering(9.0);
    drive(&mut car, &how, -1.0, (4.0, STEP), |_, _| Some(0.1));
    let stopped = (car.position(), car.heading());
    drive(&mut car, &how, -1.0, (1.0, STEP), |_, _| Some(-0.1));
    assert_eq!((car.position(), car.heading(), car.motion.speed), (stopped.0, stopped.1, 0.0));
}

#[test]
fn the_curvature_of_the_lane_keeps_it_and_so_does_to_ask_for_none() {
    for radius in [12.0, -30.0] {
        let path = bend(radius).followed(1.35);
        let mut told = car(path.clone(), 5.0);
        told.motion.travelled = 25.0;
        let mut untold = told.clone();
        let how = Steering { behind: 1.35, ..steering(9.0) };
        drive(&mut told, &how, 0.0, (2.0, STEP), |_, _| Some(1.0 / radius));
        assert!(told.steered.unwrap().offset.abs() < 1e-9, "{} m", told.steered.unwrap().offset);
        let on_it = path.pose(told.motion.travelled);
        assert!((told.position() - on_it.0).norm() < 1e-9 && (told.heading() - on_it.1).norm() < 1e-9);
        assert!((told.motion.travelled - 35.0).abs() < 1e-9);
        // From the first answer on, 1 m beside it, none at all goes on beside it.
        drive(&mut untold, &how, 0.0, (STEP, STEP), |_, _| Some(1.0 / radius));
        let beside = path.pose_beside(untold.motion.travelled, 1.0, 0.0);
        let steered = untold.steered.as_mut().unwrap();
        (steered.centre, steered.heading, steered.offset) = (beside.0, beside.1, 1.0);
        let curvature = 1.0 / (radius - 1.0);
        (steered.curvature, steered.steering_angle) = (curvature, libm::atan(curvature * 2.7));
        drive(&mut untold, &how, 0.0, (1.0, STEP), |_, _| None);
        let steered = untold.steered.unwrap();
        assert!((steered.offset - 1.0).abs() < 1e-6 && steered.heading_error.abs() < 1e-6, "{steered:?}");
    }
}

proptest! {
    /// A swerve out of lane and back comes to the same whatever the direction of the lane, to the other side mirrored, and by steps of
    /// another length to 1 cm.
    #[test]
    fn a_swerve_is_the_same_swerve(speed in 3.0_f64..20.0, curvature in 0.005_f64..0.1, braking in 0.0_f64..3.0) {
        let swerve = |sign: f64| move |time: f64, _: &VehicleState| -> Option<f64> {
            let way: f64 = if (0.5..1.5).contains(&time) { -curvature } else { curvature };
            Some(sign * way)
        };
        let how = steering(9.0);
        let of = |direction, sign: f64, step| {
            let mut car = car(straight(direction), speed);
            drive(&mut car, &how, -braking, (2.0, step), swerve(sign));
            let steered = car.steered.unwrap();
            (car.motion.travelled, steered.offset, steered.heading_error, car)
        };
        let one = of(Direction::Forward, 1.0, STEP);
        prop_assert!(one.1 > 0.0);
        let other = of(Direction::Forward, -1.0, STEP);
        prop_assert!((one.0 - other.0).abs() < 1e-9 && (one.1 + other.1).abs() < 1e-9);
        let back = of(Direction::Backward, 1.0, STEP);
        prop_assert!((one.0 - back.0).abs() < 1e-9 && (one.1 - back.1).abs() < 1e-9);
        prop_assert!((one.2 - back.2).abs() < 1e-9);
        prop_assert!((one.3.position() + back.3.position()).norm() < 1e-9);
        let finer = of(Direction::Forward, 1.0, STEP / 5.0);
        prop_assert!((one.1 - finer.1).abs() < 0.05 + 0.02 * one.1.abs(), "{} and {} m", one.1, finer.1);
    }

    /// What is between two states of a step is no farther from the way itself than 1 mm.
    #[test]
    fn between_two_states_it_is_on_its_way(speed in 1.0..25.0, curvature in -0.1..0.1) {
        let how = steering(9.0);
        let mut before = car(straight(Direction::Forward), speed);
        drive(&mut before, &how, 0.0, (1.0, STEP), |_, _| Some(curvature));
        let (mut after, mut half) = (before.clone(), before.clone());
        drive(&mut after, &how, 0.0, (STEP, STEP), |_, _| Some(curvature));
        drive(&mut half, &how, 0.0, (STEP / 2.0, STEP / 2.0), |_, _| Some(curvature));
        prop_assert!((before.between(&after, 0.5).position() - half.position()).norm() < 1e-3);
    }
}
