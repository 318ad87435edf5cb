//! The checks of the social force pedestrian and the interceptor (specification §9 beside the jaywalker's).

use crate::support::zebra::{Car, Checks, PERIOD, SPEED, STEPS, Zebra, number, settings, word};
use scenario::Settings;

/// Times hold within this, s.
const TIME: f64 = 0.15;
/// Positions hold within this, m.
const PLACE: f64 = 0.25;

fn social(step: f64, delay: f64) -> Zebra {
    let given = settings([("desired_speed", number(1.34)), ("start_delay", number(delay))]);
    Zebra { step, arrival: 6.0, ..Zebra::new("social_force", given) }
}

#[test]
fn social_force_crosses_first_or_waits() {
    let mut checks = Checks::default();
    for step in STEPS {
        let first = social(step, 0.0).run();
        checks.near("9a start 0: y = 0", step, first.passes(0.0).map(|(time, _)| time), 3.5, TIME);
        let across = first.first(|point| point.bumper <= 0.0).is_some_and(|point| point.y > 1.35);
        checks.holds("9a start 0: crosses first", step, across && first.collision().is_none());
        checks.within("9a start 0: speed", step, first.max(|point| point.speed), 0.0, 1.742);
        for delay in [2.0, 2.5, 3.0, 3.5, 4.0] {
            let course = social(step, delay).run();
            let passing = course.first(|point| point.bumper <= 0.0).map(|point| point.y);
            checks.within(&format!("9a start {delay}: y as the bumper passes"), step, passing, -2.8, -2.3);
            let middle = course.passes(0.0).map(|(time, _)| time);
            checks.within(&format!("9a start {delay}: y = 0"), step, middle, 8.2 - TIME, 8.5 + TIME);
            checks.within(
                &format!("9a start {delay}: speed"),
                step,
                course.max(|point| point.speed.abs()),
                0.0,
                1.742,
            );
            checks.holds(&format!("9a start {delay}: no collision"), step, course.collision().is_none());
        }
    }
    checks.finish();
}

fn interceptor(step: f64, given: Settings) -> Zebra {
    Zebra { step, ..Zebra::new("interceptor", given) }
}

#[test]
fn interceptor_is_hit_by_a_constant_vehicle() {
    let mut checks = Checks::default();
    for step in STEPS {
        for (mode, commits, place) in [("fast", 8.85, 0.0), ("any", 7.85, 0.1)] {
            let course = interceptor(step, settings([("mode", word(mode))])).run();
            let committed = course.enters("committed");
            checks.near(
                &format!("9b {mode}: commits"),
                step,
                committed.map(|point| point.time),
                commits,
                TIME,
            );
            if mode == "fast" {
                let bumper = committed.map(|point| point.bumper);
                checks.near("9b fast: bumper then", step, bumper, 9.7, TIME * SPEED);
            }
            checks.near(&format!("9b {mode}: hit"), step, course.collision(), 10.0, 0.1);
            let last = course.points.last().map(|point| point.y + point.speed * step);
            let tolerance = if mode == "fast" { 0.4 } else { PLACE };
            checks.near(&format!("9b {mode}: hit at y"), step, last, place, tolerance);
        }
    }
    checks.finish();
}

#[test]
fn interceptor_before_a_braking_vehicle() {
    let mut checks = Checks::default();
    for step in STEPS {
        for at in [8.0, 9.0, 10.0, 15.0] {
            let course = Zebra { car: Car::Brakes { at }, ..interceptor(step, Settings::default()) }.run();
            checks.holds(&format!("9b brakes at {at}: no collision"), step, course.collision().is_none());
            let finished = course.enters("finished").map(|point| point.time);
            checks.within(&format!("9b brakes at {at}: finished"), step, finished, 0.0, 17.0 + TIME);
        }
        let course = Zebra { car: Car::Brakes { at: 6.0 }, ..interceptor(step, Settings::default()) }.run();
        let speed = course.collision().and_then(|_| course.points.last()).map(|point| point.car_speed);
        // The specification's "about 1.9 m/s" hangs on when the vehicle decides: up to one period's way within 6 m, at any
        // step. From 6 m sharp to the body 0.3 m before the line it would still do 1.0 m/s.
        let left = |late: f64| (SPEED * SPEED - 2.0 * 6.0 * (6.0 - late - 0.3)).sqrt();
        let (low, high) = (left(0.0), left(SPEED * PERIOD) + 6.0 * PERIOD);
        checks.within("9b brakes at 6: vehicle speed when hit", step, speed, low, high);
    }
    checks.finish();
}
