//! The numbers that follow from the agent's code: thresholds, limits, stops and cruise offsets.

use super::*;
use crate::vehicle::test_track::Track;
use scenario::{Settings, Value};

fn settings(pairs: &[(&str, Value)]) -> Settings {
    Settings::from(pairs)
}

fn word(word: &str) -> Value {
    Value::Word(word.into())
}

fn brakes(track: &mut Track) -> bool {
    matches!(track.decide(), Command::Pedals { brake, .. } if brake == 0.5)
}

/// Largest gap between bumper and a walker on the lane's centre line at which it brakes, m (0 if it never does).
fn trigger_gap(dynamics: &str, pairs: &[(&str, Value)]) -> f64 {
    let brakes_at = |gap: f64| {
        let mut track = Track::new(&carla_behavior(), settings(pairs), dynamics);
        let front = track.front();
        track.place_pedestrian(front + gap, 0.0);
        brakes(&mut track)
    };
    let (mut low, mut high) = (0.0, 60.0);
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if brakes_at(middle) { low = middle } else { high = middle }
    }
    low
}

#[test]
fn emergency_threshold_before_the_bumper() {
    // Half lengths 2.257 and 2.396 and the walker's 0.1875 on top of 5 m.
    assert!((trigger_gap("prius", &[]) - 7.45).abs() < 0.006);
    assert!((trigger_gap("model3", &[]) - 7.58).abs() < 0.006);
    let clean = [("obstacle_distance", word("clean"))];
    assert!((trigger_gap("prius", &clean) - 5.1875).abs() < 1e-9);
}

#[test]
fn stock_looks_no_farther_than_its_filter() {
    // What the filter lets through is believed to be at most 5.26 m (Prius) or 4.98 m (Model 3) away.
    for (dynamics, half_length, limit) in [("prius", 2.257, 5.26), ("model3", 2.396, 4.98)] {
        let stock = |distance: f64| {
            trigger_gap(
                dynamics,
                &[("obstacle_distance", word("stock")), ("braking_distance", Value::Number(distance))],
            )
        };
        let believed = stock(25.0) - half_length - 0.1875;
        assert!((believed - limit).abs() < 0.006, "{dynamics}: {believed}");
        assert_eq!(stock(5.3), stock(25.0));
        assert!((stock(4.9) - stock(4.0) - 0.9).abs() < 1e-9);
    }
    // Lincoln MKZ 2017: half length 2.451 m.
    assert!(((100.0f64 - 0.81).sqrt() - 2.0 * 2.451 - 0.1875 - 4.87).abs() < 0.006);
    assert!((trigger_gap("prius", &[("obstacle_distance", word("stock"))]) - 7.4445).abs() < 1e-9);
}

#[test]
fn extended_and_clean_reach_any_braking_distance() {
    for distance in [4.0, 10.0, 25.0] {
        let braking = ("braking_distance", Value::Number(distance));
        let extended = trigger_gap("prius", std::slice::from_ref(&braking));
        assert!((extended - (distance + 2.257 + 0.1875)).abs() < 1e-9, "{extended}");
        let clean = trigger_gap("prius", &[braking, ("obstacle_distance", word("clean"))]);
        assert!((clean - (distance + 0.1875)).abs() < 1e-9, "{clean}");
    }
}

#[test]
fn profiles_set_the_braking_distance() {
    let gap = |profile| trigger_gap("prius", &[("profile", word(profile))]);
    assert!((gap("cautious") - gap("normal") - 1.0).abs() < 1e-9);
    assert!((gap("normal") - gap("aggressive") - 1.0).abs() < 1e-9);
}

#[test]
fn only_walkers_in_the_lane_and_in_the_cone_count() {
    let brakes_for = |pairs: &[(&str, Value)], ahead: f64, y: f64| {
        let mut track = Track::new(&carla_behavior(), settings(pairs), "prius");
        let front = track.front();
        track.place_pedestrian(front + ahead, y);
        brakes(&mut track)
    };
    // The lane is 4 m wide; the kerb itself is still in it.
    assert!(brakes_for(&[], 5.0, 2.0) && brakes_for(&[], 5.0, -2.0));
    assert!(!brakes_for(&[], 5.0, 2.01) && !brakes_for(&[], 5.0, -2.01));
    // At 1 m the cone's edge is 1.73 m out; exactly ahead counts; behind the bumper nobody does.
    assert!(brakes_for(&[], 1.0, 1.73) && !brakes_for(&[], 1.0, 1.74));
    assert!(brakes_for(&[], 0.5, 0.0) && !brakes_for(&[], -0.1, 0.0));
    // The swept strip is as wide as the car and the walker.
    let polygon = [("lateral", word("polygon"))];
    assert!(brakes_for(&polygon, 5.0, 1.19) && !brakes_for(&polygon, 5.0, 1.2));
}

#[test]
fn stock_takes_the_first_hit_of_the_list_and_clean_the_nearest() {
    let brakes_for = |mode: &str, near_first: bool| {
        let pairs = [("obstacle_distance", word(mode)), ("braking_distance", Value::Number(3.0))];
        let mut track = Track::new(&carla_behavior(), settings(&pairs), "prius");
        let front = track.front();
        let mut gaps = [2.0, 6.0];
        if !near_first {
            gaps.reverse();
        }
        for gap in gaps {
            track.place_pedestrian(front + gap, 0.0);
        }
        brakes(&mut track)
    };
    assert!(brakes_for("extended", true) && !brakes_for("extended", false));
    assert!(brakes_for("clean", true) && brakes_for("clean", false));
}

#[test]
fn cruise_keeps_a_small_offset() {
    // The throttle that holds the speed, 0.21 to 0.45, needs a speed error of that many km/h.
    for (dynamics, hold) in [("prius", 0.2107), ("model3", 0.394), ("mkz2020", 0.4527), ("generic", 0.3)] {
        let mut track = Track::new(&carla_behavior(), Settings::default(), dynamics);
        track.drive(10.0);
        let speeds: Vec<_> = track.drive(10.0).iter().map(|sample| sample.speed).collect();
        let mean = speeds.iter().sum::<f64>() / speeds.len() as f64;
        let below = 30.0 - mean * KMH;
        assert!((0.2..=0.46).contains(&below), "{dynamics}: {below} km/h");
        assert!((below - hold / 1.025).abs() < 0.02, "{dynamics}: {below} km/h");
    }
}

#[test]
fn the_stock_rule_gives_stock_speeds() {
    for (profile, speed) in [("cautious", 24.0), ("normal", 27.0), ("aggressive", 29.0)] {
        let pairs = [("profile", word(profile)), ("target_speed", word("stock"))];
        let mut track = Track::new(&carla_behavior(), settings(&pairs), "prius");
        let last = track.drive(30.0).pop().unwrap().speed * KMH;
        assert!((speed - 0.46..speed).contains(&last), "{profile}: {last} km/h");
    }
}

#[test]
fn a_standing_pedestrian_is_stopped_for_touched_or_hit() {
    // MKZ stops about 1 m short, Model 3 touches at about 2 m/s, the Prius is still at about 6 m/s.
    let drive = |dynamics| {
        let mut track = Track::new(&carla_behavior(), Settings::default(), dynamics);
        track.place_pedestrian(200.0, 0.0);
        let mut speed = track.motion.speed;
        while track.front() < 200.0 - 0.1875 && speed > 0.0 {
            speed = track.advance().speed;
        }
        (200.0 - 0.1875 - track.front(), speed)
    };
    let (left, speed) = drive("mkz2020");
    assert!(speed == 0.0 && (0.3..1.2).contains(&left), "{left} {speed}");
    assert!((1.0..2.7).contains(&drive("model3").1));
    assert!((5.5..6.5).contains(&drive("prius").1));
}

#[test]
fn it_holds_for_ever_and_goes_when_the_way_is_free() {
    let mut track = Track::new(&carla_behavior(), Settings::default(), "mkz2020");
    track.script_pedestrian(|time| {
        let y = if time < 30.0 { 0.0 } else { 3.0 };
        Some((nalgebra::Vector2::new(50.0, y), nalgebra::Vector2::zeros()))
    });
    let samples = track.drive(45.0);
    let at = |time: f64| samples[(time / 0.025) as usize].clone();
    assert_eq!((at(29.0).speed, at(29.0).mode), (0.0, "emergency_stop".into()));
    assert_eq!(at(30.1).command, Command::Pedals { throttle: 0.75, brake: 0.0 });
    assert!(at(44.0).speed > 8.0);
}

#[test]
fn it_decides_twenty_times_a_second() {
    let mut track = Track::new(&carla_behavior(), Settings::default(), "generic");
    assert_eq!(track.controller.schedule(), Schedule::every(0.05));
    let first = track.advance().command;
    assert_eq!(track.advance().command, first);
}

#[test]
fn it_follows_a_slower_vehicle_and_brakes_when_near() {
    let command = |x: f64, speed: f64| {
        let mut track = Track::new(&carla_behavior(), Settings::default(), "prius");
        track.see_vehicle(x, speed);
        let command = track.decide();
        (command, track.controller.mode())
    };
    // Centre 9 m ahead: rear 4.49 m before the bumper, believed within 5 m.
    assert_eq!(command(9.0, 5.0).1, "emergency_stop");
    // Rear 9.6 m ahead, believed 5.1 m: 3.3 m/s faster, so 1.5 s to collision: slower than the one ahead.
    assert_eq!(command(14.1, 5.0), (Command::Pedals { throttle: 0.0, brake: 0.3 }, "following".into()));
    // As fast as itself: 5.1 s, so keep that speed.
    assert_eq!(
        command(14.1, 30.0 / 3.6),
        (Command::Pedals { throttle: 0.0, brake: 0.0 }, "following".into())
    );
    assert_eq!(command(30.0, 5.0).1, "cruise");
}
