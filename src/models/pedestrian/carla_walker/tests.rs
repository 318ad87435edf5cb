//! Timings and reactions that follow from the walker's code.

use super::*;
use crate::pedestrian::test_walk::Walk;
use scenario::Value;

fn walk(pairs: &[(&str, Value)]) -> Walk {
    let mut settings = Settings::from(pairs);
    if settings.get("kerb_wait").is_none() {
        settings.set("kerb_wait", Value::Number(0.0));
    }
    Walk::new(&carla_walker(), settings)
}

fn number(value: f64) -> Value {
    Value::Number(value)
}

fn word(word: &str) -> Value {
    Value::Word(word.into())
}

#[test]
fn timings_without_traffic() {
    for release in ["recent", "old"] {
        let mut walk = walk(&[("release", word(release))]);
        let times = [-2.0, 0.0, 2.0].map(|y| walk.time_to_reach(y));
        for (found, expected) in times.iter().zip([1.43, 2.86, 4.29]) {
            assert!((found - expected).abs() < 0.006, "{times:?}");
        }
    }
}

#[test]
fn slows_down_before_the_goal_and_stays_there() {
    let mut walk = walk(&[]);
    walk.go(30.0);
    assert!((walk.position().y - 6.0).abs() < 1e-6 && walk.position().y <= 6.0);
}

#[test]
fn pauses_one_metre_before_the_kerb_for_the_wait() {
    for (release, place) in [("recent", -3.0), ("old", -4.0)] {
        let mut walk = walk(&[("release", word(release)), ("kerb_wait", number(3.0))]);
        walk.go(2.0);
        assert_eq!(walk.pedestrian.mode(), "checking");
        assert!((walk.position().y - place).abs() < 0.036, "{}", walk.position().y);
        assert!((walk.time_to_reach(0.0) - 2.86 - 3.0).abs() < 0.006);
    }
}

#[test]
fn the_wait_is_a_mixture() {
    let n = 2000;
    let waits: Vec<_> = (0..n)
        .map(|seed| {
            let mut walk = Walk::seeded(&carla_walker(), Settings::default(), seed).unwrap();
            walk.step = 0.1;
            walk.time_to_reach(0.0) - 4.0 / 1.4
        })
        .collect();
    let without = waits.iter().filter(|wait| **wait < 0.01).count() as f64 / n as f64;
    assert!((without - 0.7).abs() < 0.04, "{without}");
    let mean = waits.iter().sum::<f64>() / (n as f64 * (1.0 - without));
    assert!((mean - 6.5).abs() < 0.5, "{mean}");
    assert!(waits.iter().all(|wait| *wait < 13.2));
}

/// A standing car whose centre is `x` along the road from the pedestrian.
fn mode_beside_car(x: f64, time: f64, pairs: &[(&str, Value)]) -> Mode {
    let mut walk = walk(pairs);
    walk.add_car(x, 0.0);
    walk.go(time);
    walk.pedestrian.mode()
}

#[test]
fn waits_only_for_very_near_vehicles() {
    // From 3 m before the lane's centre: 6 m around and 70 degrees from straight across.
    let edge = (36.0f64 - 9.0).sqrt();
    let seen = |x: f64| {
        let pairs = [("vehicles_nearby", word("static"))];
        mode_beside_car(x, 2.0, &pairs) == "checking"
    };
    assert!(seen(edge - 0.1) && seen(-edge + 0.1));
    assert!(!seen(edge + 0.1) && !seen(-edge - 0.1));
    // 4.5 to 5.2 m along the road from 3 to 4 m beside the lane's centre.
    assert!((4.4..5.3).contains(&edge) && (4.4..5.3).contains(&(36.0f64 - 16.0).sqrt()));
}

#[test]
fn a_car_six_metres_away_is_ignored_and_hits() {
    let mut walk = walk(&[("vehicles_nearby", word("static"))]);
    // At the lane's centre line after 2.86 s; so is the car's front, having been 15 m away at the kerb check.
    walk.add_car(-2.6 * 30.0 / 3.6, 30.0 / 3.6);
    walk.go(4.0);
    assert_eq!(walk.pedestrian.mode(), "hit");
    let place = walk.position();
    walk.go(5.0);
    assert_eq!(walk.position(), place);
}

#[test]
fn gives_up_after_the_timeout() {
    let car_stays = |release, time| {
        mode_beside_car(2.0, time, &[("release", word(release)), ("vehicles_nearby", word("static"))])
    };
    assert_eq!(car_stays("old", 4.9), "checking");
    assert_eq!(car_stays("old", 5.2), "walking_away");
    assert_eq!(car_stays("recent", 59.0), "checking");
    assert_eq!(car_stays("recent", 61.5), "walking_away");
}

#[test]
fn stands_while_a_margin_overlaps() {
    // Already on the road when a car stops right before it.
    let mut walk = walk(&[("vehicles_nearby", word("static")), ("checks", Value::Flag(false))]);
    walk.add_car(-3.0, 0.0);
    walk.go(10.0);
    // Margin: half the width, 0.8 m and its own radius; it stands within one step behind that line.
    let line = -(2.007 / 2.0 + 0.8 + 0.3);
    assert!((line..line + 0.036).contains(&walk.position().y), "{}", walk.position().y);
    walk.vehicles.clear();
    walk.go(10.0);
    assert!(walk.position().y > 5.0);
}

#[test]
fn separation_follows_the_formula() {
    let mut walk = walk(&[("checks", Value::Flag(false))]);
    walk.state().position = Vector2::new(0.0, 0.0);
    walk.add_car(-10.0, 0.0);
    let Motion::Walk(velocity) = walk.step() else { panic!() };
    // Margin's front 3.257 m ahead of the centre, so 6.743 m away; pushed along x by 10 m times the weight.
    let clearance = 10.0 - 2.257 - 1.0;
    let push = 10.0 * 0.5 * (1.0 - (clearance / 10.0f64).powi(2)) / clearance;
    let wanted = Vector2::new(push, 1.4);
    let expected = wanted * (1.4 * 1.4 / wanted.norm_squared());
    assert!((velocity - expected).norm() < 1e-9, "{velocity} {expected}");
    walk.vehicles[0].motion.travelled = -13.3;
    walk.state().position = Vector2::new(0.0, 0.0);
    assert_eq!(walk.step(), Motion::Walk(Vector2::new(0.0, 1.4)));
}

#[test]
fn a_slow_car_pushes_and_a_fast_one_hits() {
    let after = |speed: f64| {
        let mut walk = walk(&[("checks", Value::Flag(false))]);
        walk.state().position = Vector2::new(0.0, 0.0);
        walk.add_car(-4.0, speed);
        walk.go(8.0);
        (walk.pedestrian.mode(), walk.position())
    };
    assert_ne!(after(0.8).0, "hit");
    assert_eq!(after(8.0).0, "hit");
}

#[test]
fn snapping_moves_the_start() {
    let pairs = [("snap_min", number(0.7)), ("snap_max", number(0.7))];
    let mut walk = walk(&pairs);
    walk.step();
    assert!((walk.position().y + 4.7).abs() < 1e-9);
    // One tick later and 0.7 m farther.
    assert!((walk.time_to_reach(0.0) - (4.7 / 1.4 + 0.025)).abs() < 1e-6);
}

#[test]
fn ranges_upside_down_are_errors() {
    let settings = Settings::from([("snap_min", number(1.0))]);
    assert!(Walk::try_new(&carla_walker(), settings).is_err());
}

/// Back on its own pavement it used to stand for ever, in mode `walking`.
#[test]
fn nobody_stands_for_ever_where_he_turned_back_to() {
    let (mut turned_back, mut across) = (0, 0);
    for seed in 0..40 {
        let settings = Settings::from([("stuck_distance", number(3.0))]);
        let mut walk = Walk::seeded(&carla_walker(), settings, seed).unwrap();
        // On the road before a car that stopped; after 20 s it is gone.
        walk.state().position = Vector2::new(0.0, 0.0);
        walk.add_car(-3.0, 0.0);
        walk.go(20.0);
        walk.vehicles.clear();
        let (mut back, mut standing, mut longest) = (false, 0.0f64, 0.0f64);
        for _ in 0..40_000 {
            let before = walk.position();
            walk.step();
            back |= walk.position().y < -2.0;
            if walk.pedestrian.mode() == "arrived" {
                break;
            }
            let stands = walk.position() == before && walk.pedestrian.mode() != "checking";
            standing = if stands { standing + walk.step } else { 0.0 };
            longest = longest.max(standing);
        }
        turned_back += usize::from(back);
        across += usize::from(walk.pedestrian.mode() == "arrived" && walk.position().y > 5.9);
        assert!(longest < 5.0, "seed {seed}: stood for {longest} s in mode {}", walk.pedestrian.mode());
    }
    assert!(turned_back >= 3, "{turned_back}");
    assert_eq!(across, 40);
}

#[test]
fn says_that_it_has_arrived() {
    let mut walk = walk(&[]);
    walk.go(20.0);
    assert_eq!(walk.pedestrian.mode(), "arrived");
}

#[test]
fn turns_to_a_new_place_when_stuck() {
    // A car stands on its way; its margin pushes the walker out in front, where it hardly moves at first.
    let end = |stuck_time: f64, seed: u64| {
        let settings = Settings::from([
            ("checks", Value::Flag(false)),
            ("stuck_time", number(stuck_time)),
            ("stuck_distance", number(3.0)),
        ]);
        let mut walk = Walk::seeded(&carla_walker(), settings, seed).unwrap();
        walk.state().position = Vector2::new(0.0, 0.0);
        walk.add_car(-3.0, 0.0);
        walk.go(60.0);
        walk.position()
    };
    let places: Vec<_> = (0..10).map(|seed| end(4.0, seed)).collect();
    for place in &places {
        assert!((-4.5..6.5).contains(&place.y) && place.x.abs() < 20.5, "{place}");
    }
    assert!(places.iter().filter(|place| place.x.abs() > 2.0).count() >= 5);
    // Without the turn it gets across slowly, and the car still drives it off its goal a little.
    let place = end(0.0, 1);
    assert!((place - Vector2::new(0.0, 6.0)).norm() < 0.5, "{place}");
}
