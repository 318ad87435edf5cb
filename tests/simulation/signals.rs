//! Crossings with a signal, from their text to what is measured: who obeys stops before the line and goes at green, whoever cannot stop drives
//! through, people wait at the kerb, and a crossing without a signal keeps every bit.

use models::standard;
use proptest::prelude::*;
use results::Requests;
use runner::plan::plan;
use runner::run::{FreeFlows, Unwatched, road_users, run_case};
use scenario::{SignalState, TrafficSignal};
use sim::{Longitudinal, Observer, PedestrianState, Snapshot, Step, simulate};

use crate::support::text::{case, checked, planned};

const OBEYING: [&str; 6] =
    ["yielding", "careful_human", "idm_aeb", "carla_behavior", "commotions", "autoware"];

const WALKING: [&str; 4] = ["scripted", "commotions", "carla_walker", "social_force"];

const SIGNAL: &str = "signalised { cycle: 60 s, pedestrian_green: 15 s, pedestrian_green_from: 40 s, amber: 3 s, clearance: 4 s }";

fn street(crossing: &str, users: &str) -> String {
    format!(
        "scenario a {{
  road {{ lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing {crossing} }}
  horizon 130 s; finish 60 m
  {users}
}}"
    )
}

/// A pedestrian who walks before any vehicle comes.
const EARLY: &str = "pedestrian early { model scripted; start 1 m from kerb; ignores signals }";

fn car(controller: &str, more: &str) -> String {
    format!("vehicle av {{ controller {controller}; {more} }}\n")
}

#[derive(Default)]
struct Course(Vec<(f64, Vec<Longitudinal>, Vec<PedestrianState>)>);

impl Observer for Course {
    fn begin(&mut self, start: &Snapshot) {
        self.0.push((0.0, start.vehicles.iter().map(|car| car.motion).collect(), start.pedestrians.clone()));
    }

    fn observe(&mut self, step: &Step) {
        let (time, after) = (step.time + step.duration, step.after);
        self.0.push((time, after.vehicles.iter().map(|car| car.motion).collect(), after.pedestrians.clone()));
    }
}

/// Where everybody is, the signal, and how far the front of the vehicle is from the line when its centre is at the crossing, m.
fn course(text: &str) -> (Course, TrafficSignal, f64) {
    let case = case(text);
    let (world, mut course) = (case.world.clone(), Course::default());
    simulate(&world, road_users(&world, case.seed).unwrap(), &mut course).unwrap();
    let signal = *world.road.crossing.signal().expect("it has one");
    let beyond = world.vehicles[0].length / 2.0 + world.road.crossing.width / 2.0 + signal.stop_line;
    (course, signal, beyond)
}

/// The state of the signal when the front came over the line, and how far beyond the line it was while it stood (m, at most).
fn crossed(text: &str) -> (Option<SignalState>, f64) {
    let (course, signal, beyond) = course(text);
    let front = |motion: &Longitudinal| motion.travelled + beyond;
    let over = course.0.windows(2).find(|two| front(&two[0].1[0]) <= 0.0 && front(&two[1].1[0]) > 0.0);
    let stood =
        course.0.iter().filter(|(_, cars, _)| cars[0].speed == 0.0).map(|(_, cars, _)| front(&cars[0]));
    (over.map(|two| signal.state(two[0].0)), stood.fold(f64::NEG_INFINITY, f64::max))
}

#[test]
fn whoever_obeys_stops_at_red_and_goes_at_green() {
    for controller in OBEYING {
        for (lane, speed) in [(0, 30), (1, 30), (0, 50)] {
            let car =
                car(controller, &format!("lane {lane}; speed {speed} km/h; start 46 s before crossing"));
            let text = street(SIGNAL, &format!("{car} {EARLY}"));
            let (state, stood) = crossed(&text);
            assert_eq!(state, Some(SignalState::Green), "{controller} {lane} {speed}");
            // Every one of them came to stand, before the line and not far from it.
            let near = if controller == "carla_behavior" { -40.0 } else { -3.0 };
            assert!((near..=0.0).contains(&stood), "{controller} {lane} {speed}: {stood}");
        }
    }
}

#[test]
fn whoever_ignores_signals_drives_through() {
    for controller in OBEYING {
        let car = car(controller, "speed 30 km/h; start 46 s before crossing; ignores signals");
        let (state, stood) = crossed(&street(SIGNAL, &format!("{car} {EARLY}")));
        assert_eq!(state, Some(SignalState::Red), "{controller}");
        // `autoware` stops for people who stand at a crossing.
        assert!(controller == "autoware" || stood == f64::NEG_INFINITY, "{controller}: {stood}");
    }
    for controller in ["constant_speed", "constant_deceleration { time: 100 s }"] {
        let car = car(controller, "speed 30 km/h; start 46 s before crossing");
        let (state, _) = crossed(&street(SIGNAL, &format!("{car} {EARLY}")));
        assert_eq!(state, Some(SignalState::Red), "{controller}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Who could stop at 3.048 m/s² after 1 s (`careful_human`: 1.15 s, `yielding`: 3.4 m/s² at once) when amber began does not cross the
    /// line in red; neither does anybody come to stand beyond it.
    #[test]
    fn nobody_crosses_the_line_in_red_who_could_stop(
        driver in 0..3usize, distance in 1.0..120.0, speed in 3.0..20.0, amber in 0.0..4.0, lane in 0..2u32, line in 0.0..3.0,
    ) {
        let (controller, reaction, deceleration) =
            [("yielding", 0.0, 3.4), ("careful_human", 1.15, 3.048), ("idm_aeb", 1.0, 3.048)][driver];
        // When amber, or red without it, begins its front is so far from the line.
        let begins = 30.0 - amber;
        let start = distance + 2.0 + 4.5 / 2.0 + line + speed * begins;
        let crossing = format!(
            "signalised {{ cycle: 60 s, pedestrian_green: 15 s, pedestrian_green_from: 30 s, amber: {amber} s, clearance: 2 s, stop_line: {line} m }}"
        );
        let car = car(
            controller,
            &format!("size 4.5 m x 1.8 m; lane {lane}; speed {speed} m/s; start {start} m before crossing"),
        );
        let text = street(&crossing, &format!("{car} {EARLY}"));
        let (state, stood) = crossed(&text);
        // The vehicle decides 40 times a second, so that amber may be seen a little later.
        let needs = speed * (reaction + 0.025) + speed * speed / (2.0 * deceleration);
        if distance > needs {
            prop_assert_eq!(state, Some(SignalState::Green));
        }
        prop_assert!(stood <= 0.0, "{} beyond the line", stood);
    }

    /// Without a signal it makes no difference what is said of it, and with one nothing of its lamps matters to who ignores it.
    #[test]
    fn what_nobody_looks_at_changes_nothing(
        controller in 0..6usize, zebra: bool, start in 40.0..120.0, amber in 0.0..4.0, clearance in 0.0..5.0,
    ) {
        let controller = OBEYING[controller];
        let crossing = if zebra { "zebra" } else { "unmarked" };
        let walker = |more: &str| format!("pedestrian walker {{ model scripted; start 1 m from kerb; appears at 3 s; {more} }}");
        let run = |crossing: &str, said: &str| {
            let car = car(controller, &format!("speed 30 km/h; start {start} m before crossing; {said}"));
            let case = case(&street(crossing, &format!("{car} {}", walker(said))));
            let requests = Requests::defaults(&standard());
            let outcome = run_case(&case, &requests, &FreeFlows::default(), &mut Unwatched).unwrap();
            (case.key, outcome.fingerprint, outcome.metrics)
        };
        let plain = run(crossing, "");
        prop_assert_eq!(&plain, &run(crossing, "obeys signals"));
        prop_assert_eq!(&plain, &run(crossing, "ignores signals"));
        let lamps = |amber: f64, clearance: f64| {
            format!("signalised {{ pedestrian_green: 20 s, amber: {amber} s, clearance: {clearance} s }}")
        };
        prop_assert_eq!(run(&lamps(0.0, 0.0), "ignores signals"), run(&lamps(amber, clearance), "ignores signals"));
    }
}

/// Vehicles that hardly move when red begins, and one that has just passed the line.
#[test]
fn past_the_line_the_crossing_is_cleared() {
    for controller in OBEYING {
        // At 40 s the front of a 4.5 m long car is 2 m beyond the line, without amber.
        let start = 8.0 * 40.0 + 2.25 + 3.2 - 2.0;
        let car =
            car(controller, &format!("size 4.5 m x 1.8 m; speed 8 m/s; start {start} m before crossing"));
        let crossing = "signalised { cycle: 60 s, pedestrian_green: 15 s, pedestrian_green_from: 40 s }";
        let (course, _, _) = course(&street(crossing, &format!("{car} {EARLY}")));
        let slowest = course.0.iter().map(|(_, cars, _)| cars[0].speed).fold(f64::INFINITY, f64::min);
        assert!(slowest > 7.5, "{controller}: {slowest}");
    }
}

#[test]
fn people_step_onto_the_road_at_green_and_go_on_when_it_ends() {
    for model in WALKING {
        for side in ["near", "far"] {
            let person = |appears: f64, more: &str| {
                format!(
                    "pedestrian walker {{ model {model}; from {side} side; start 3 m from kerb; appears at {appears} s; {more} }}"
                )
            };
            let entered = |appears: f64, more: &str| {
                let car = car("constant_speed", "speed 10 m/s; start 1200 m before crossing");
                let (course, signal, _) =
                    course(&street(SIGNAL, &format!("{car} {}", person(appears, more))));
                let on_road =
                    |person: &PedestrianState| person.present && (-1.75..5.25).contains(&person.position.y);
                let first =
                    course.0.iter().position(|(_, _, people)| on_road(&people[0])).expect("they cross");
                let left = course.0[first..].iter().find(|(_, _, people)| !on_road(&people[0]));
                (signal, course.0[first].0, left.expect("they get across").0)
            };
            // From 40 s to 55 s they have green.
            let (signal, from, to) = entered(10.0, "");
            assert!(signal.people_have_green(from) && (40.0..42.5).contains(&from), "{model} {side}: {from}");
            assert!(to - from < 10.0, "{model} {side}: {from} .. {to}");
            let (_, from, to) = entered(51.0, "");
            assert!(
                (52.0..55.1).contains(&from) && (55.0..65.0).contains(&to),
                "{model} {side}: {from} .. {to}"
            );
            let (_, from, _) = entered(10.0, "ignores signals");
            assert!(from < 20.0, "{model} {side}: {from}");
        }
    }
}

/// Beside the crossing there is no signal to wait for.
#[test]
fn who_crosses_elsewhere_waits_for_nothing() {
    let at = |along: f64, said: &str| {
        let users = format!(
            "{} pedestrian walker {{ model scripted; along {along} m; start 1 m from kerb; {said} }}",
            car("yielding", "speed 30 km/h; start 46 s before crossing")
        );
        planned(&street(SIGNAL, &users)).map(|case| case.world.pedestrians[0].obeys_signals)
    };
    assert_eq!([0.0, 2.9, -2.9].map(|along| at(along, "")), [Ok(true), Ok(true), Ok(true)]);
    assert_eq!([3.1, -20.0].map(|along| at(along, "")), [Ok(false), Ok(false)]);
    assert!(at(3.1, "obeys signals").unwrap_err().contains("does not step onto the road at the crossing"));
}

#[test]
fn who_cannot_obey_says_so() {
    let refused = |users: &str| planned(&street(SIGNAL, users)).unwrap_err();
    for (controller, what) in [
        ("constant_speed", "looks at no signals"),
        ("constant_deceleration", "looks at no signals"),
        ("timeline { steps: \"at 1 s stop\" }", "looks at no signals"),
    ] {
        let car = car(controller, "speed 30 km/h; start 46 s before crossing; obeys signals");
        let error = refused(&format!("{car} {EARLY}"));
        assert!(error.contains(what) || error.contains("steps"), "{error}");
    }
    let av = car("yielding", "speed 30 km/h; start 46 s before crossing");
    let error =
        refused(&format!("{av} pedestrian w {{ model interceptor; start 1 m from kerb; obeys signals }}"));
    assert!(error.contains("looks at no signals"), "{error}");
    // Nobody knows when somebody is where who waits for green.
    let met = |more: &str| {
        planned(&street(
            SIGNAL,
            &format!(
                "vehicle av {{ controller yielding; speed 30 km/h }}\n pedestrian w {{ model scripted; start 1 m from kerb; meets av at 50 %; {more} }}"
            ),
        ))
    };
    assert!(met("").unwrap_err().contains("ignores signals"));
    assert!(met("ignores signals").is_ok());
}

#[test]
fn what_varies_of_a_signal_is_looked_at_in_every_world() {
    let text = |vary: &str, setting: &str| {
        street(
            &format!("signalised {{ cycle: 60 s, pedestrian_green: 40 s, {setting} }}"),
            &format!("{vary}\n{} {EARLY}", car("yielding", "speed 30 km/h; start 46 s before crossing")),
        )
    };
    let errors =
        |text: &str| plan(&checked(text).unwrap()).map(|_| ()).map_err(|errors| format!("{:?}", errors[0]));
    assert_eq!(errors(&text("vary x in [1 s, 19 s]", "amber: x")), Ok(()));
    let error = errors(&text("vary x in [1 s, 15 s]", "amber: x, clearance: 6 s")).unwrap_err();
    assert!(error.contains("longer together than its cycle") && error.contains("61 s"), "{error}");
    assert!(checked(&text("", "amber: 15 s, clearance: 6 s")).unwrap_err().contains("longer together"));
}

/// Around a bend the line is where the crossing is, in either lane, and with a car that answers late.
#[test]
fn around_a_bend_it_stops_before_the_line_too() {
    let bend = "path { straight 300 m; clothoid 20 m to radius 40 m left; arc 60 deg; clothoid 20 m to straight; straight 300 m }";
    for lane in [0, 1] {
        for controller in ["yielding", "careful_human", "idm_aeb"] {
            for dynamics in ["ideal", "delay_lag"] {
                let crossing = SIGNAL.replace("signalised {", "signalised { at: 345 m,");
                let users = format!(
                    "vehicle av {{ controller {controller}; dynamics {dynamics}; lane {lane}; speed 30 km/h; start 46 s before crossing }}\n {EARLY}"
                );
                let text = street(&crossing, &users).replace("road {", &format!("road {{ {bend};"));
                let (state, stood) = crossed(&text);
                assert_eq!(state, Some(SignalState::Green), "{controller} {dynamics} {lane}");
                assert!((-3.0..=0.0).contains(&stood), "{controller} {dynamics} {lane}: {stood}");
            }
        }
    }
}

/// Amber changes no bit of a run in which nobody is before the line while it is shown, nor the clearance of one that is through before red.
#[test]
fn what_is_over_before_amber_does_not_depend_on_it() {
    let run = |lamps: &str| {
        let crossing = format!(
            "signalised {{ cycle: 60 s, pedestrian_green: 15 s, pedestrian_green_from: 40 s, {lamps} }}"
        );
        let car = car("idm_aeb", "speed 30 km/h; start 20 s before crossing");
        let mut case =
            case(&street(&crossing, &format!("{car} {EARLY}")).replace("horizon 130 s", "horizon 30 s"));
        case.seed = 1;
        let outcome =
            run_case(&case, &Requests::defaults(&standard()), &FreeFlows::default(), &mut Unwatched).unwrap();
        (outcome.fingerprint, outcome.metrics)
    };
    let plain = run("amber: 0 s");
    for lamps in ["amber: 3 s", "amber: 5 s, clearance: 9 s", "stop_line: 3 m"] {
        assert_eq!(run(lamps), plain, "{lamps}");
    }
}

/// Who waits at red has not walked what they meant to.
#[test]
fn a_script_goes_on_from_the_kerb() {
    let users = format!(
        "{} pedestrian walker {{ model scripted {{ speed: 1 m/s, acceleration_way: 0.5 m, stop_after: 3 m, stop_for: 2 s }}; start 1 m from kerb; appears at 10 s }}",
        car("constant_speed", "speed 10 m/s; start 900 m before crossing")
    );
    let (course, _, _) = course(&street(SIGNAL, &users));
    let stands: Vec<f64> = course
        .0
        .iter()
        .filter(|(time, _, people)| {
            *time > 41.0 && people[0].velocity.norm() == 0.0 && people[0].position.y < 3.0
        })
        .map(|(_, _, people)| people[0].position.y)
        .collect();
    // 3 m from where it began, wherever it waited meanwhile: 0.25 m beyond the centre of the near lane.
    assert!(!stands.is_empty() && stands.iter().all(|y| (y - 0.25).abs() < 1e-6), "{stands:?}");
}

/// Of several crossings the one that is next is obeyed, and by people the one that they use.
#[test]
fn each_crossing_has_its_own_signal() {
    let school = SIGNAL.replace("signalised {", "crossing school signalised { at: 60 m,");
    let users = |more: &str| {
        format!(
            "vehicle av {{ controller idm_aeb; speed 30 km/h; start 39 s before crossing; {more} }}\n pedestrian walker {{ model scripted; crosses school; start 1 m from kerb; appears at 10 s }}"
        )
    };
    let run = |more: &str| {
        let text = street(&format!("zebra; {school}"), &users(more)).replace("finish 60 m", "finish 120 m");
        let case = case(&text);
        assert!(case.world.pedestrians[0].obeys_signals, "{text}");
        let mut course = Course::default();
        simulate(&case.world, road_users(&case.world, case.seed).unwrap(), &mut course).unwrap();
        course
    };
    let course = run("");
    let (_, signal) = (
        0,
        *case(&street(SIGNAL, &users("").replace("crosses school; ", "")))
            .world
            .road
            .crossing
            .signal()
            .unwrap(),
    );
    let stood =
        course.0.iter().filter(|(_, cars, _)| cars[0].speed < 0.1).map(|(_, cars, _)| cars[0].travelled);
    let stood: Vec<f64> = stood.collect();
    // Before the second crossing, 60 m behind the first.
    assert!(!stood.is_empty() && stood.iter().all(|at| (45.0..60.0).contains(at)), "{stood:?}");
    let entered =
        course.0.iter().find(|(_, _, people)| people[0].present && people[0].position.y > -1.75).unwrap();
    assert!(signal.people_have_green(entered.0), "{}", entered.0);
    let through = run("ignores signals");
    assert!(through.0.iter().all(|(_, cars, _)| cars[0].speed > 7.0));
}
