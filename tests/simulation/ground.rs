//! Roads that are steep or slippery, from their text to what is measured: way and speed of a stop by closed form, whoever stands is held,
//! up one way is down the other, and what no vehicle needs changes no bit.

use proptest::prelude::*;
use runner::plan::plan;
use runner::run::road_users;
use sim::{Longitudinal, Observer, Snapshot, Step, simulate};

use crate::support::text::{case, loaded, measured, of};

const G: f64 = 9.80665;

/// The road of these tests, on such ground, and who is on it.
fn street(ground: &str, users: &str) -> String {
    format!(
        "scenario a {{
  road {{ lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra; {ground} }}
  horizon 40 s; finish 60 m
  {users}
}}"
    )
}

/// How every vehicle moves, at the beginning and after each step.
#[derive(Default)]
struct Moves(Vec<Vec<Longitudinal>>);

impl Observer for Moves {
    fn begin(&mut self, start: &Snapshot) {
        self.0.push(start.vehicles.iter().map(|car| car.motion).collect());
    }

    fn observe(&mut self, step: &Step) {
        self.0.push(step.after.vehicles.iter().map(|car| car.motion).collect());
    }
}

fn moves(text: &str) -> Vec<Vec<Longitudinal>> {
    let case = case(text);
    let (world, mut moves) = (case.world.clone(), Moves::default());
    let users = road_users(&world, case.seed).unwrap();
    simulate(&world, users, &mut moves).unwrap();
    moves.0
}

/// A pedestrian who is in nobody's way.
const FAR: &str =
    "pedestrian walker { model scripted { speed: 1.5 m/s }; start 9 m from kerb; appears at 39 s }";

fn braking(deceleration: f64, dynamics: &str, lane: usize) -> String {
    format!(
        "vehicle av {{ controller constant_deceleration {{ deceleration: {deceleration} m/s^2, time: 0 s }}; dynamics {dynamics}
    speed 15 m/s; start 90 m before crossing; lane {lane} }}
  {FAR}"
    )
}

#[test]
fn stops_are_as_long_as_the_textbook_says() {
    let mut stopped = 0;
    for gradient in [-10.0, -5.0, 0.0, 5.0, 10.0] {
        for friction in [None, Some(0.2), Some(0.5), Some(1.2)] {
            for deceleration in [2.0, 5.0, 9.0] {
                for lane in [0, 1] {
                    let said = friction.map(|friction| format!("friction {friction}")).unwrap_or_default();
                    let ground = format!("gradient {gradient} %; {said}");
                    let found = moves(&street(&ground, &braking(deceleration, "ideal", lane)));
                    // Uphill for lane 0 is downhill for lane 1.
                    let up = if lane == 0 { gradient } else { -gradient } / 100.0;
                    let held = friction.map_or(deceleration, |friction| deceleration.min(friction * G));
                    let brakes = held + G * libm::sin(libm::atan(up));
                    let way = 15.0 * 15.0 / (2.0 * brakes);
                    let (first, last) = (found[0][0], found.last().unwrap()[0]);
                    let place = format!("{ground}, {deceleration} m/s², lane {lane}");
                    // 2 s are not enough to stand on any of them.
                    let (early, time) = (found[80][0], 2.0);
                    if brakes * time < 15.0 {
                        let expected = 15.0 * time - brakes * time * time / 2.0;
                        assert!((early.travelled - first.travelled - expected).abs() < 1e-9, "{place}");
                        assert!((early.speed - 15.0 + brakes * time).abs() < 1e-9, "{place}");
                        assert!((early.acceleration + brakes).abs() < 1e-9, "{place}");
                    }
                    if way < 140.0 {
                        stopped += 1;
                        let found = last.travelled - first.travelled;
                        assert!((found - way).abs() < 1e-9, "{place}: {found} m, not {way}");
                        assert_eq!((last.speed, last.acceleration), (0.0, 0.0), "{place}");
                    }
                }
            }
        }
    }
    assert!(stopped > 90, "{stopped} stopped");
}

/// Another way to the same: the acceleration of dead time and lag, held by the tyres, in steps of 10 µs.
#[test]
fn a_lag_is_held_by_the_tyres_from_the_moment_on_that_it_asks_for_more() {
    for (gradient, friction) in [(0.0, 0.3), (0.06, 0.3), (-0.06, 0.3), (0.1, 1.5), (-0.1, 0.55)] {
        let ground = format!("gradient {gradient}; friction {friction}");
        let found = moves(&street(&ground, &braking(6.0, "delay_lag", 0)));
        let (dt, mut way, mut speed) = (1e-5, 0.0, 15.0);
        let slope = G * libm::sin(libm::atan(gradient));
        for index in 0.. {
            let time = f64::from(index) * dt + dt / 2.0;
            let asked = -6.0 * (1.0 - (-((time - 0.1) / 0.1).max(0.0)).exp());
            let realised = asked.max(-friction * G) - slope;
            way += speed * dt + realised * dt * dt / 2.0;
            speed += realised * dt;
            if speed <= 0.0 {
                break;
            }
        }
        let last = found.last().unwrap()[0];
        let stopped = last.travelled - found[0][0].travelled;
        assert_eq!(last.speed, 0.0);
        assert!((stopped - way).abs() < 1e-3, "{ground}: {stopped} m, not {way}");
        // It never gains speed again where it is about to stand, as by a lag that forgot what was asked.
        let least = -friction * G - slope;
        for pair in found.windows(2).filter(|pair| pair[1][0].speed > 0.0).skip(12) {
            assert!(pair[1][0].acceleration < 0.0 && pair[1][0].acceleration > least - 1e-9, "{ground}");
        }
    }
}

#[test]
fn up_one_way_is_down_the_other() {
    for controller in ["yielding", "careful_human", "idm_aeb", "carla_behavior", "constant_speed", "autoware"]
    {
        let cars = |lane: usize| {
            street(
                &format!("gradient {} %; friction 0.6", if lane == 0 { 7 } else { -7 }),
                &format!(
                    "vehicle av {{ controller {controller}; speed 30 km/h; start 50 m before crossing; lane {lane} }}
  {FAR}"
                ),
            )
        };
        let (up, mirrored) = (moves(&cars(0)), moves(&cars(1)));
        assert_eq!(up, mirrored, "{controller}");
        let other = cars(0).replace("gradient 7 %", "gradient -7 %");
        assert_ne!(up, moves(&other), "{controller}");
    }
}

#[test]
fn whoever_stands_does_not_roll() {
    let meets = "vehicle av { controller yielding; speed 30 km/h; start 50 m before crossing }
  pedestrian walker { model scripted { speed: 0.4 m/s }; start 0.5 m from kerb; appears at 2 s }";
    for ground in
        ["gradient 10 %", "gradient -10 %", "gradient 10 %; friction 0.4", "gradient -20 %; friction 0.5"]
    {
        let found = moves(&street(ground, meets));
        let stands = found.windows(2).filter(|pair| pair[0][0].speed == 0.0 && pair[1][0].speed == 0.0);
        let standing: Vec<_> =
            stands.inspect(|pair| assert_eq!(pair[0][0].travelled, pair[1][0].travelled)).collect();
        assert!(standing.len() > 40, "{ground}: it stands in {} steps", standing.len());
        assert!(found.windows(2).all(|pair| pair[1][0].travelled >= pair[0][0].travelled), "{ground}");
        // And drives on when nobody is there any more.
        assert!(found.last().unwrap()[0].travelled >= 60.0, "{ground}: {:?}", found.last());
    }
    // On ice it cannot, nor with a controller that asks for less than gravity takes.
    for ground in ["gradient 12 %; friction 0.1", "gradient 25 %"] {
        assert_eq!(moves(&street(ground, meets)).last().unwrap()[0].speed, 0.0, "{ground}");
    }
}

#[test]
fn metrics_see_what_the_ground_leaves_of_the_braking() {
    let found = |ground: &str, name: &str| of(&street(ground, &braking(8.0, "ideal", 0)), name).unwrap();
    for (ground, expected) in [
        ("", 8.0),
        ("friction 0.5", 0.5 * G),
        ("friction 0.2", 0.2 * G),
        ("gradient 10 %", 8.0 + G * libm::sin(libm::atan(0.1))),
        ("gradient -10 %; friction 0.5", 0.5 * G - G * libm::sin(libm::atan(0.1))),
    ] {
        assert!((found(ground, "max_deceleration") - expected).abs() < 1e-9, "{ground}");
        let sudden = if expected > 2.5 { 1.0 } else { 0.0 };
        assert_eq!(found(ground, "sudden_speed_change"), sudden, "{ground}");
    }
}

/// Of free flow on the same ground; against that of a level road each would have lost or gained time.
#[test]
fn nobody_loses_time_to_the_ground() {
    for ground in ["gradient 10 %", "gradient -10 %; friction 0.1", ""] {
        let car = format!(
            "vehicle av {{ controller careful_human; speed 30 km/h; start 50 m before crossing }}
  {FAR}"
        );
        assert_eq!(of(&street(ground, &car), "time_lost"), Some(0.0), "{ground}");
    }
}

#[test]
fn what_a_scenario_varies_the_road_has() {
    let text = "scenario a {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra; gradient slope; friction mu }
  vary slope in [-5 %, 5 %]
  vary mu in [0.25, 1]
  vehicle av { controller constant_deceleration { deceleration: 8 m/s^2, time: 0 s }; speed 10 m/s; start 90 m before crossing }
  pedestrian walker { model scripted; start 9 m from kerb; appears at 39 s }
}";
    let plan = plan(&loaded(text)).unwrap();
    let grounds: Vec<_> = plan.trials().map(|trial| trial.cases.first().world.road.ground).collect();
    let grounds: Vec<_> =
        grounds.iter().map(|ground| (ground.gradient.unwrap(), ground.friction.unwrap())).collect();
    assert_eq!(grounds, [(-0.05, 0.25), (-0.05, 1.0), (0.05, 0.25), (0.05, 1.0)]);
    let hashes: std::collections::BTreeSet<_> =
        plan.trials().map(|trial| runner::corpus::case_hash(&trial.cases.first())).collect();
    assert_eq!(hashes.len(), 4, "cases that differ in their ground alone are other cases");
}

#[test]
fn what_is_not_said_is_not_written() {
    let plain = case(&street("", &braking(5.0, "ideal", 0)));
    let written = serde_json::to_string(&plain.world.road).unwrap();
    assert!(!written.contains("ground"), "{written}");
    assert_eq!(serde_json::from_str::<scenario::Road>(&written).unwrap(), plain.world.road);
    let said = case(&street("gradient 5 %", &braking(5.0, "ideal", 0)));
    let written = serde_json::to_string(&said.world.road).unwrap();
    assert!(written.contains(r#""ground":{"gradient":0.05}"#), "{written}");
    assert_eq!(serde_json::from_str::<scenario::Road>(&written).unwrap(), said.world.road);
}

fn encounter(ground: &str, controller: &str, dynamics: &str, person: &str, tta: f64) -> String {
    street(
        ground,
        &format!(
            "vehicle av {{ controller {controller}; {dynamics}; speed 31 km/h }}
  pedestrian walker {{ model {person}; start 2.1 m from kerb; appears when time_to_arrival(av.front) = {tta} s }}"
        ),
    )
}

#[test]
fn a_level_road_on_which_tyres_hold_all_is_a_plain_one() {
    let cars = [
        ("constant_speed", ""),
        ("yielding", ""),
        ("careful_human", ""),
        ("idm_aeb", ""),
        ("carla_behavior", ""),
        ("carla_behavior", "dynamics prius"),
        ("autoware", ""),
        ("commotions", ""),
        ("yielding", "dynamics delay_lag"),
        ("idm_aeb", "dynamics delay_lag"),
    ];
    for (controller, dynamics) in cars {
        for person in ["scripted { speed: 1.4 m/s }", "commotions", "social_force"] {
            for tta in [1.8, 3.1, 5.3] {
                let plain = measured(&encounter("", controller, dynamics, person, tta));
                for ground in ["gradient 0 %; friction 1.5", "gradient 0 %", "friction 1.5"] {
                    let found = measured(&encounter(ground, controller, dynamics, person, tta));
                    assert_eq!(found, plain, "{ground}, {controller} {dynamics}, {person}, {tta} s");
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..Default::default() })]

    #[test]
    fn a_friction_that_nobody_needs_changes_nothing(
        needs in 0.5f64..6.9, spare in 0.001f64..0.5, dynamics in prop::sample::select(vec!["ideal", "delay_lag"]),
        tta in 0.5f64..4.0,
    ) {
        let friction = (needs / G + spare).clamp(0.05, 1.5);
        let text = |ground: &str| {
            street(ground, &format!(
                "vehicle av {{ controller constant_deceleration {{ deceleration: {needs} m/s^2, distance: 12 m }}
    dynamics {dynamics}; speed 14 m/s }}
  pedestrian walker {{ model scripted; start 2.1 m from kerb; appears when time_to_arrival(av.front) = {tta} s }}"
            ))
        };
        let plain = measured(&text(""));
        prop_assert_eq!(&measured(&text(&format!("friction {friction}"))), &plain);
        // And one that is needed does.
        let short = (needs / G * 0.8).max(0.05);
        if short * G < needs {
            prop_assert_ne!(&measured(&text(&format!("friction {short}"))).fingerprint, &plain.fingerprint);
        }
    }
}
