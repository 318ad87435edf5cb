//! Roads over each other: vehicles on different roads against closed forms and brute force, what does not matter, and what cannot be.

use std::sync::{Arc, Mutex};

use files::Memory;
use models::standard;
use nalgebra::Vector2;
use results::{Outcome, Requests};
use runner::plan::plan;
use runner::run::{FreeFlows, Unwatched, run_case};
use scenario::registry::Registry;
use scenario::{Case, Chance, CommandKind, ControllerModel, Declaration};
use sim::{Command, Controller, ControllerError, Observation, Schedule};

use crate::support::text::{case, planned};

const METRICS: [&str; 7] = [
    "vehicle_pet(av, other)",
    "entered_first(av, other)",
    "vehicle_ttc(av, other)",
    "vehicle_distance(av, other)",
    "collision(av, other)",
    "vehicle_pet(other, av)",
    "entered_first(other, av)",
];

/// The outcome of the first run of a text, and what came of the metrics that its criteria are about, by their labels.
fn outcome(text: &str, registry: &Registry) -> (Outcome, Vec<(String, Option<f64>)>) {
    let files = Memory::default().with("a.scn", text);
    let loaded = lang::load("a.scn".as_ref(), registry, &files);
    let suite = loaded.unwrap_or_else(|failure| panic!("{text}\n{:?}", failure.diagnostics)).suite;
    let plan = plan(&suite).unwrap_or_else(|errors| panic!("{text}\n{errors:?}"));
    let mut requests = Requests::default();
    requests.include(&suite.scenarios[0].criteria);
    let case: Case = plan.trial(0).cases.first();
    let outcome = run_case(&case, &requests, &FreeFlows::default(), &mut Unwatched).unwrap();
    let values = requests.iter().map(|one| one.label()).zip(outcome.metrics.iter().copied()).collect();
    (outcome, values)
}

struct Found(Vec<(String, Option<f64>)>);

impl Found {
    fn of(&self, label: &str) -> Option<f64> {
        let plain = label.replace(' ', "");
        let found = self.0.iter().find(|(known, _)| known.replace(' ', "") == plain);
        found.unwrap_or_else(|| panic!("{label} is not among {:?}", self.0)).1
    }
}

fn found(text: &str) -> Found {
    Found(outcome(text, &standard()).1)
}

const SIZES: [(f64, f64); 2] = [(4.5, 1.8), (7.0, 2.4)];

/// Two vehicles that meet 20 m behind the crossing, at this angle (deg), each with its speed (m/s) and its way to there (m).
fn crossing(angle: f64, av: (f64, f64), other: (f64, f64)) -> String {
    let criteria: String = METRICS.iter().map(|metric| claim(metric)).collect();
    format!(
        "road main {{ lanes forward, backward; lane_width 3.5 m; speed_limit 100 km/h; crossing unmarked }}
         road side {{ over main {{ at: 20 m, angle: {angle} deg }}; lanes forward; lane_width 3.5 m; speed_limit 100 km/h }}
         scenario a {{
           road main
           vehicle av {{ controller constant_speed; size 4.5 m x 1.8 m; speed {} m/s; start {} m before crossing }}
           vehicle other {{ on side; controller constant_speed; size 7 m x 2.4 m; speed {} m/s; start {} m before junction }}
           finish 60 m
           expect {{ {criteria} }}
         }}",
        av.0,
        av.1 - 20.0,
        other.0,
        other.1
    )
}

/// A criterion that asks for a metric.
fn claim(metric: &str) -> String {
    match metric.split('(').next() {
        Some("entered_first" | "collision") => format!("no {metric}\n"),
        Some("vehicle_ttc") => format!("{metric} > 0.01 s undefined passes\n"),
        Some("vehicle_distance") => format!("{metric} > 0.01 m\n"),
        _ => format!("{metric} > 0.01 s\n"),
    }
}

/// Half of the way on which a body is where another could be.
fn half(own: (f64, f64), other: (f64, f64), angle: f64) -> f64 {
    let (sine, cosine) = (libm::sin(angle).abs(), libm::cos(angle).abs());
    own.0 / 2.0 + (other.1 / 2.0 + own.1 / 2.0 * cosine) / sine
}

type Corners = [Vector2<f64>; 4];

/// The corners of a vehicle that is so far (m) before where it crosses the other and heads at this angle (rad).
fn corners((length, width): (f64, f64), before: f64, angle: f64) -> Corners {
    let ahead = Vector2::new(libm::cos(angle), libm::sin(angle));
    let left = Vector2::new(-ahead.y, ahead.x);
    [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)]
        .map(|(x, y)| ahead * (x * length / 2.0 - before) + left * (y * width / 2.0))
}

/// From a point to a line between two others.
fn to_line(point: Vector2<f64>, from: Vector2<f64>, to: Vector2<f64>) -> f64 {
    let way = to - from;
    let share = ((point - from).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
    (point - from - way * share).norm()
}

/// Between two polygons that are apart: from the corners of each to the sides of the other.
fn between(one: &Corners, other: &Corners) -> f64 {
    let sides = |of: &Corners| (0..4).map(|index| (of[index], of[(index + 1) % 4])).collect::<Vec<_>>();
    let from = |points: &Corners, sides: &[(Vector2<f64>, Vector2<f64>)]| {
        points
            .iter()
            .flat_map(|point| sides.iter().map(|(from, to)| to_line(*point, *from, *to)))
            .fold(f64::INFINITY, f64::min)
    };
    from(one, &sides(other)).min(from(other, &sides(one)))
}

/// By brute force in steps of 0.1 ms: when each vehicle first and last has a corner or a side in the strip of the other.
fn stays(angle: f64, both: [(f64, f64); 2]) -> [(f64, f64); 2] {
    let headings = [0.0, angle];
    let stay = |index: usize| {
        let (speed, way) = both[index];
        let (own, other) = (headings[index], headings[1 - index]);
        let across = Vector2::new(-libm::sin(other), libm::cos(other));
        let inside = |time: f64| {
            let sides = corners(SIZES[index], way - speed * time, own).map(|corner| corner.dot(&across));
            let (low, high) = sides
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(*at), high.max(*at)));
            low <= SIZES[1 - index].1 / 2.0 && high >= -SIZES[1 - index].1 / 2.0
        };
        let times = (0..200_000).map(|step| f64::from(step) * 1e-4).filter(|time| inside(*time));
        times.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), time| (from.min(time), to.max(time)))
    };
    [stay(0), stay(1)]
}

#[test]
fn constant_speeds_against_closed_forms_and_brute_force() {
    for (degrees, av, other) in [
        (90.0, (10.0, 50.0), (8.0, 20.0)),
        (90.0, (10.0, 50.0), (8.0, 60.0)),
        (60.0, (10.0, 50.0), (12.5, 30.0)),
        (60.0, (8.0, 40.0), (8.0, 65.0)),
        (120.0, (10.0, 50.0), (8.0, 20.0)),
        (-45.0, (12.0, 50.0), (8.0, 70.0)),
    ] {
        let angle = f64::to_radians(degrees);
        let found = found(&crossing(degrees, av, other));
        let arrives = |(speed, way): (f64, f64)| way / speed;
        let (one, two) = (half(SIZES[0], SIZES[1], angle), half(SIZES[1], SIZES[0], angle));
        let first = arrives(av) - one / av.0 < arrives(other) - two / other.0;
        let exact = match first {
            true => arrives(other) - two / other.0 - (arrives(av) + one / av.0),
            false => arrives(av) - one / av.0 - (arrives(other) + two / other.0),
        };
        let pet = found.of("vehicle_pet(av, other)").unwrap();
        assert!((pet - exact.max(0.0)).abs() < 1e-9 && exact > 0.0, "{degrees}°: {pet}, not {exact}");
        assert_eq!(found.of("vehicle_pet(other, av)"), Some(pet), "{degrees}°");
        assert_eq!(found.of("entered_first(av, other)"), Some(f64::from(first)), "{degrees}°");
        assert_eq!(found.of("entered_first(other, av)"), Some(f64::from(!first)), "{degrees}°");
        assert_eq!(found.of("collision(av, other)"), Some(0.0), "{degrees}°");
        assert_eq!(found.of("vehicle_ttc(av, other)"), None, "{degrees}°: they only pass");
        let [(av_in, av_out), (other_in, other_out)] = stays(angle, [av, other]);
        let brute = (other_in - av_out).max(av_in - other_out);
        assert!((pet - brute).abs() < 3e-4, "{degrees}°: {pet}, not {brute}");
        // The distance by brute force in steps of a millisecond.
        let apart = (0..12_000).map(|step| f64::from(step) * 1e-3).map(|time| {
            between(
                &corners(SIZES[0], av.1 - av.0 * time, 0.0),
                &corners(SIZES[1], other.1 - other.0 * time, angle),
            )
        });
        let (least, distance) =
            (apart.fold(f64::INFINITY, f64::min), found.of("vehicle_distance(av, other)").unwrap());
        assert!((distance - least).abs() < 1e-3, "{degrees}°: {distance} m, not {least} m");
    }
}

#[test]
fn who_comes_at_once_touches_and_nothing_is_left_between() {
    for degrees in [90.0, 60.0, -120.0] {
        let found = found(&crossing(degrees, (10.0, 50.0), (10.0, 51.0)));
        assert_eq!(found.of("collision(av, other)"), Some(1.0), "{degrees}°");
        for metric in ["vehicle_pet(av, other)", "vehicle_ttc(av, other)", "vehicle_distance(av, other)"] {
            assert_eq!(found.of(metric), Some(0.0), "{degrees}°: {metric}");
        }
    }
}

#[test]
fn a_time_to_collision_is_known_from_the_start() {
    // At a right angle: the front of one at the flank of the other, which is there already.
    let text =
        crossing(90.0, (10.0, 50.0), (10.0, 51.0)).replace("finish 60 m", "finish 60 m; horizon 0.1 s");
    let touches = 51.0 / 10.0 - (7.0 / 2.0 + 1.8 / 2.0) / 10.0;
    let found = found(&text).of("vehicle_ttc(av, other)").unwrap();
    assert!((found - (touches - 0.1)).abs() < 1e-9, "{found}, not {}", touches - 0.1);
}

#[test]
fn mirrored_and_swapped_roads_give_the_same_numbers() {
    for (degrees, av, other) in [(60.0, (10.0, 50.0), (8.0, 60.0)), (90.0, (9.0, 50.0), (8.0, 20.0))] {
        let one = found(&crossing(degrees, av, other));
        let mirrored = found(&crossing(-degrees, av, other));
        // The road of the one is that of the other.
        let swapped = crossing(-degrees, other, av)
            .replace("size 4.5 m x 1.8 m", "size X")
            .replace("size 7 m x 2.4 m", "size 4.5 m x 1.8 m")
            .replace("size X", "size 7 m x 2.4 m")
            .replace("vehicle av", "vehicle Y")
            .replace("vehicle other", "vehicle av")
            .replace("vehicle Y", "vehicle other");
        let swapped = found(&swapped);
        // And the road below is a path that does not bend.
        let placed = crossing(degrees, av, other)
            .replace("crossing unmarked", "crossing unmarked { at: 130 m }; path { straight 300 m }")
            .replace("at: 20 m,", "at: 150 m,");
        let placed = found(&placed);
        for again in [&mirrored, &swapped, &placed] {
            for metric in METRICS {
                let (one, again) = (one.of(metric), again.of(metric));
                let same = one.zip(again).map_or(one == again, |(one, again)| (one - again).abs() < 1e-9);
                assert!(same, "{degrees}°, {metric}: {one:?} and {again:?}");
            }
        }
    }
}

#[test]
fn a_vehicle_on_another_road_that_never_comes_near_changes_nothing() {
    let text = |far: bool| {
        let (road, car) = match far {
            true => (
                "road side { over main { at: 900 m, angle: 70 deg }; lane_width 3 m; speed_limit 100 km/h }",
                "vehicle other { on side; controller constant_speed; speed 30 m/s; start 30 m before junction }",
            ),
            false => ("", ""),
        };
        format!(
            "road main {{ lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
             {road}
             scenario a {{
               road main
               vehicle av {{ controller yielding; speed 30 km/h; start 60 m before crossing; sees {{ range: 60 m, latency: 0.1 s }} }}
               {car}
               pedestrian walker {{ model scripted {{ speed: 1.4 m/s }}; start 3 m from kerb; appears at 1 s }}
               expect {{
                 no collision(av)
                 min_distance(av, walker) > 0.1 m
                 pet(av, walker) > 0.1 s
                 pet_area(av, walker) > 0.1 s
                 min_ttc(av, walker) > 0.1 s undefined passes
                 drac(av, walker) < 9 m/s^2 undefined passes
                 max_deceleration(av) < 9 m/s^2
                 max_jerk(av) < 900 m/s^3
                 travel_time(av) < 50 s
                 time_lost(av) < 50 s
                 pedestrian_delay(av, walker) < 50 s
                 crossing_duration(av, walker) < 50 s
               }}
             }}"
        )
    };
    let ((with, values), (without, plain)) =
        (outcome(&text(true), &standard()), outcome(&text(false), &standard()));
    assert_eq!(with.ending, without.ending);
    for ((name, one), (_, other)) in values.iter().zip(&plain) {
        assert_eq!(one.map(f64::to_bits), other.map(f64::to_bits), "{name}: {one:?} and {other:?}");
    }
    assert!(plain.iter().filter(|(_, value)| value.is_some()).count() > 8, "{plain:?}");
}

#[test]
fn who_looks_along_the_own_lane_hits_what_comes_from_the_side() {
    for (driver, hits) in [
        ("constant_speed", 1.0),
        ("yielding", 1.0),
        ("careful_human", 1.0),
        ("idm_aeb", 1.0),
        ("idm_aeb { crossing_vehicles: true, field_of_view: 120 deg, trigger: 1.6 s }", 0.0),
    ] {
        let text = crossing(90.0, (10.0, 50.0), (10.0, 52.0)).replacen(
            "controller constant_speed",
            &format!("controller {driver}"),
            1,
        );
        assert_eq!(found(&text).of("collision(av, other)"), Some(hits), "{driver}");
    }
}

struct Watches(Arc<Mutex<Vec<Observation>>>);

impl Controller for Watches {
    fn schedule(&self) -> Schedule {
        Schedule::every(0.1)
    }

    fn act(&mut self, seen: &Observation) -> Result<Command, ControllerError> {
        self.0.lock().unwrap().push(seen.clone());
        Ok(Command::Acceleration(0.0))
    }
}

#[test]
fn a_controller_is_shown_who_comes_from_the_side() {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let shown = seen.clone();
    let watches = ControllerModel::new(
        Declaration::new("watches", "Watches.").source("test"),
        CommandKind::Acceleration,
        move |_| Ok(Box::new(Watches(shown.clone()))),
    );
    let registry = standard().with_controller(watches.chance(Chance::Never)).unwrap();
    // From either road, in its own frame: ahead along the lane, and to its left.
    let side = crossing(60.0, (10.0, 50.0), (8.0, 60.0));
    outcome(&side.replacen("controller constant_speed", "controller watches", 1), &registry);
    let first = seen.lock().unwrap().iter().find(|seen| seen.time == 0.0).cloned().unwrap();
    let (sine, cosine) = (libm::sin(f64::to_radians(60.0)), 0.5);
    let near = |one: Vector2<f64>, x: f64, y: f64| (one - Vector2::new(x, y)).norm() < 1e-9;
    let other = first.vehicles[0];
    assert!(near(other.position, 50.0 - 60.0 * cosine, -60.0 * sine), "{:?}", other.position);
    assert!(near(other.velocity, 8.0 * cosine, 8.0 * sine), "{:?}", other.velocity);
    seen.lock().unwrap().clear();
    let from_side = side.replace("on side; controller constant_speed", "on side; controller watches");
    outcome(&from_side, &registry);
    let first = seen.lock().unwrap().iter().find(|seen| seen.time == 0.0).cloned().unwrap();
    let av = first.vehicles[0];
    assert!(near(av.position, 60.0 - 50.0 * cosine, 50.0 * sine), "{:?}", av.position);
    assert!(near(av.velocity, 10.0 * cosine, -10.0 * sine), "{:?}", av.velocity);
    // On its road there is no crossing: in the place of one is where the roads meet.
    assert_eq!((first.ego.distance_to_crossing, first.road.crossing_width), (60.0, 0.0));
    assert!(!first.road.pedestrian_priority && first.road.lane_width == 3.5);
}

#[test]
fn everybody_is_solid_for_everybody() {
    // Who walks across the main road walks along the lane of the other road there.
    let text = "road main { lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked }
        road side { over main { at: 20 m }; lane_width 3.5 m; speed_limit 50 km/h }
        scenario a {
          road main
          vehicle av { controller constant_speed; speed 10 m/s; start 150 m before crossing }
          vehicle other { on side; controller constant_speed; speed 10 m/s; start 40 m before junction }
          pedestrian walker { model scripted { speed: 1 m/s }; along 20 m; start 2 m from kerb; appears at 0 s }
          expect {
            no collision(other, walker)
            min_distance(other, walker) > 0 m
            pet(other, walker) > 0 s undefined passes
            no collision(av, walker)
          }
        }";
    let found = found(text);
    assert_eq!(found.of("collision(other, walker)"), Some(1.0));
    assert_eq!(found.of("min_distance(other, walker)"), Some(0.0));
    assert_eq!(found.of("collision(av, walker)"), Some(0.0));
}

#[test]
fn a_road_may_turn_into_another() {
    let text = "road main { lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked }
        road side {
          over main { at: 60 m, meets: 120 m, angle: 0 deg }
          path { straight 60 m; arc 90 deg radius 10 m right; straight 80 m }
          lane_width 3.5 m
          speed_limit 50 km/h
        }
        scenario a {
          road main
          vehicle av { controller constant_speed; speed 10 m/s; start 50 m before crossing }
          vehicle other { on side; controller constant_speed; speed 5 m/s; start 100 m before junction; follows by rear axle }
          finish 100 m
          expect { vehicle_distance(av, other) > 0 m; vehicle_pet(av, other) > 0 s; no collision(av, other) }
        }";
    let world = case(text).world.clone();
    let path = world.path_of(&world.vehicles[1]);
    assert!(path.point(10.0).y.abs() < 1e-9 && (path.heading(10.0).x - 1.0).abs() < 1e-12);
    assert!((path.heading(-100.0).y - 1.0).abs() < 1e-12, "it comes from the near side");
    let found = found(text);
    // They are in one lane at last: none crosses the other, which is no proof of anything.
    assert_eq!(found.of("vehicle_pet(av, other)"), None);
    assert!(found.of("vehicle_distance(av, other)").unwrap() > 0.0);
}

#[test]
fn whose_meeting_the_horizon_cuts_off_is_told() {
    let short = crossing(90.0, (10.0, 50.0), (8.0, 60.0)).replace("finish 60 m", "finish 60 m; horizon 2 s");
    let (cut, values) = outcome(&short, &standard());
    let cut_off = cut.cut_off.clone().expect("it was cut off");
    let pairs: Vec<_> = cut_off.unfinished.iter().map(|one| (&*one.vehicle, &*one.pedestrian)).collect();
    assert_eq!(pairs, [("av", "other")]);
    let pet = values.iter().position(|(label, _)| label.replace(' ', "") == "vehicle_pet(av,other)").unwrap();
    assert!(values[pet].1.is_none() && cut.open(pet).is_some_and(|open| open.low == 0.0), "{cut_off:?}");
}

#[test]
fn what_cannot_be_is_refused_with_a_cure() {
    let said = |from: &str, to: &str| {
        let text = crossing(90.0, (10.0, 50.0), (8.0, 60.0)).replace(from, to);
        planned(&text).expect_err(&text)
    };
    for (from, to, expected) in [
        ("angle: 90 deg", "angle: 10 deg", "runs along `main`"),
        ("angle: 90 deg", "angle: 170 deg", "runs along `main`"),
        ("angle: 90 deg }", "angle: 90 deg, meets: 80 m }; path { straight 60 m }", "never meets `main`"),
        ("start 60 m before junction", "start 60 m before crossing", "there is no crossing"),
        ("start 30 m before crossing", "start 30 m before junction", "counted from its crossing"),
        ("over main { at: 20 m", "over main { meets: 2 m", "meet"),
        ("on side;", "on mian;", "there is no road `mian`"),
        ("over main { at: 20 m, angle: 90 deg };", "crossing zebra;", "does not lie over main"),
        ("road main\n", "road side\n", "lies over `main`"),
        (
            "finish 60 m",
            "finish 60 m; pedestrian walker { model commotions; start 2 m from kerb; appears at 0 s }",
            "minds vehicles of its own road alone",
        ),
    ] {
        let error = said(from, to);
        assert!(error.contains(expected), "{from} -> {to}: {error}");
    }
    let text = crossing(90.0, (10.0, 20.0), (8.0, 2.0)).replace("at: 20 m", "at: 0 m");
    let error = planned(&text).expect_err(&text);
    assert!(error.contains("starts inside vehicle"), "{error}");
}

#[test]
fn who_crosses_both_roads_is_measured_against_the_lane_of_each() {
    // The other road leads from lower left to upper right through (20, 0) m; its far side is to the left of that, on the near side of
    // whom it crosses. Somebody walks straight across the main road at 24 m, and over the other lane at (24, 4) m.
    for (angle, along) in [(45.0, 24.0), (-135.0, 24.0)] {
        let text = format!(
            "road main {{ lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked }}
             road side {{ over main {{ at: 20 m, angle: {angle} deg }}; lane_width 3 m; speed_limit 50 km/h }}
             scenario a {{
               road main
               vehicle av {{ controller constant_speed; speed 10 m/s; start 300 m before crossing }}
               vehicle other {{ on side; controller constant_speed; speed 10 m/s; start 40 m before junction }}
               pedestrian walker {{ model scripted {{ speed: 1 m/s }}; along {along} m; start 2 m from kerb; goal 4 m beyond kerb; appears at 0 s }}
               expect {{
                 pet(other, walker) > 0.1 s
                 passed_first(other, walker) = vehicle
                 no collision(other, walker)
               }}
             }}"
        );
        let found = found(&text);
        let behind = f64::signum(angle) * 4.0 * std::f64::consts::SQRT_2;
        let expected = (2.0 + 1.75 + 4.0) - (40.0 + behind) / 10.0;
        let pet = found.of("pet(other, walker)").unwrap();
        assert!((pet - expected).abs() < 1e-9, "{angle}°: {pet}, not {expected}");
        assert_eq!(found.of("passed_first(other, walker)"), Some(2.0), "{angle}°");
        assert_eq!(found.of("collision(other, walker)"), Some(0.0), "{angle}°");
    }
}

#[test]
fn a_house_at_the_corner_hides_either_from_the_other() {
    // The earliest moment at which a vehicle that sees is shown the other, s.
    let first = |house: bool, from_side: bool| {
        let seen = Arc::new(Mutex::new(Vec::new()));
        let shown = seen.clone();
        let watches = ControllerModel::new(
            Declaration::new("watches", "Watches.").source("test"),
            CommandKind::Acceleration,
            move |_| Ok(Box::new(Watches(shown.clone()))),
        );
        let registry = standard().with_controller(watches.chance(Chance::Never)).unwrap();
        let house =
            if house { "box house { along: 0 m, across: -20 m, length: 30 m, width: 30 m }" } else { "" };
        let looks = "controller watches; sees { range: 200 m, field_of_view: 180 deg }";
        let text = crossing(90.0, (10.0, 50.0), (10.0, 50.0))
            .replace("crossing unmarked }", &format!("crossing unmarked; {house} }}"));
        let text = match from_side {
            true => text.replace("on side; controller constant_speed", &format!("on side; {looks}")),
            false => text.replacen("controller constant_speed", looks, 1),
        };
        outcome(&text, &registry);
        let seen = seen.lock().unwrap();
        seen.iter().find(|seen| seen.time >= 0.0 && !seen.vehicles.is_empty()).map(|seen| seen.time)
    };
    for from_side in [false, true] {
        assert_eq!(first(false, from_side), Some(0.0));
        // The corner of the house is 5 m beside either lane: they see each other about 5 m before the junction's middle, but for their length.
        let late = first(true, from_side).unwrap();
        assert!((3.0..5.0).contains(&late), "{late} s");
    }
}

/// Keeps its speed, and steers by so much (1/m) if it does.
struct Steers(Option<f64>);

impl Controller for Steers {
    fn schedule(&self) -> Schedule {
        Schedule::every(0.1)
    }

    fn act(&mut self, _: &Observation) -> Result<Command, ControllerError> {
        Ok(Command::Acceleration(0.0))
    }

    fn curvature(&self) -> Option<f64> {
        self.0
    }
}

/// Where a lane is crossed says nothing of who left it: no number is better than one of where nobody drove.
#[test]
fn of_who_is_steered_nothing_is_said_that_its_lane_would_say() {
    let of = |curvature: Option<f64>| {
        let steers = ControllerModel::new(
            Declaration::new("steers", "Steers.").source("test"),
            CommandKind::Acceleration,
            move |_| Ok(Box::new(Steers(curvature))),
        );
        let registry = standard().with_controller(steers.steering().chance(Chance::Never)).unwrap();
        let text = crossing(90.0, (10.0, 50.0), (10.0, 80.0));
        Found(outcome(&text.replacen("controller constant_speed", "controller steers", 1), &registry).1)
    };
    let (keeps, steered) = (of(None), of(Some(0.0)));
    for metric in ["vehicle_pet(av, other)", "entered_first(av, other)", "vehicle_pet(other, av)"] {
        assert!(keeps.of(metric).is_some() && steered.of(metric).is_none(), "{metric}");
    }
    assert_eq!(keeps.of("vehicle_distance(av, other)"), steered.of("vehicle_distance(av, other)"));
}
