//! Streams of vehicles: the same as their vehicles by hand, and the same again however they are said.

use std::path::Path;

use lang::write_scenario;
use proptest::prelude::*;
use runner::plan::{plan, standalone};
use scenario::{Case, World};

use crate::support::text::{case, loaded, measured, planned};

const WALKER: &str = "pedestrian walker { model commotions; start 2.3 m from lane centre; looks for 1 s }";

fn street(traffic: &str, rest: &str) -> String {
    format!(
        "scenario a {{
  road {{ lanes forward, backward; lane_width 2.25 m; speed_limit 30 km/h; crossing unmarked }}
  {traffic}
  {WALKER}
  horizon 12 s
  {rest}
}}"
    )
}

fn cars(gaps: &str) -> String {
    format!(
        "stream cars {{ controller constant_speed; speed 30 km/h; size 4.3 m x 1.8 m; first 2 s before crossing; gaps {gaps} }}
  stream far {{ repeats cars, 1.5 s later; lane 1 }}"
    )
}

/// The world without what says that its vehicles are those of streams.
fn by_hand(case: &Case) -> World {
    World { streams: Vec::new(), ..(*case.world).clone() }
}

fn arrivals(case: &Case, stream: &str) -> Vec<f64> {
    case.world.streams.iter().find(|one| one.name == stream).unwrap().arrivals.clone()
}

#[test]
fn a_stream_is_its_vehicles_by_hand() {
    let stream = case(&street(&cars("3 s, 4 s, then 2.5 s"), ""));
    let block = |name: String, arrival: f64, lane: usize| {
        format!(
            "vehicle {name} {{ controller constant_speed; speed 30 km/h; size 4.3 m x 1.8 m; lane {lane}; start {arrival} s before crossing }}\n"
        )
    };
    // Up to the first that arrives after 12 s.
    let near = [2.0, 5.0, 9.0, 11.5, 14.0];
    let far = [3.5, 6.5, 10.5, 13.0];
    let near = near.iter().enumerate().map(|(index, at)| block(format!("cars_{}", index + 1), *at, 0));
    let far = far.iter().enumerate().map(|(index, at)| block(format!("far_{}", index + 1), *at, 1));
    let vehicles: String = near.chain(far).collect();
    assert_eq!(by_hand(&stream), *case(&street(&vehicles, "")).world);
    let [near, far] = &stream.world.streams[..] else { panic!("two streams") };
    assert_eq!((near.name.as_str(), &near.vehicles[..]), ("cars", &[0, 1, 2, 3, 4][..]));
    assert_eq!((far.name.as_str(), &far.vehicles[..]), ("far", &[5, 6, 7, 8][..]));
    assert_eq!(far.arrivals, [3.5, 6.5, 10.5, 13.0]);
}

#[test]
fn drawn_gaps_are_others_in_every_run_and_the_same_in_the_same_run() {
    let text = street(&cars("2 s, then drawn from choice(2.5 s, 3.5 s, 4.5 s)"), "repeat 20");
    let suite = loaded(&text);
    let runs: Vec<Case> = plan(&suite).unwrap().trial(0).cases.iter().collect();
    let again: Vec<Case> = plan(&suite).unwrap().trial(0).cases.iter().collect();
    assert_eq!(runs, again);
    let mut seen: Vec<Vec<u64>> =
        runs.iter().map(|run| arrivals(run, "cars").iter().map(|at| at.to_bits()).collect()).collect();
    seen.sort();
    seen.dedup();
    assert!(seen.len() > 10, "{} of 20 runs differ", seen.len());
    for run in &runs {
        let (near, far) = (arrivals(run, "cars"), arrivals(run, "far"));
        assert_eq!(near[..2], [2.0, 4.0]);
        // What repeats a stream has its gaps.
        assert!(near.iter().zip(&far).all(|(near, far)| (far - near - 1.5).abs() < 1e-9), "{near:?} {far:?}");
    }
}

#[test]
fn a_run_written_down_as_a_scenario_of_its_own_is_the_same_run() {
    for gaps in ["3 s, 4 s, then 2.5 s", "2 s, then drawn from uniform(2 s, 6 s)", "4 s, 3 s"] {
        let suite = loaded(&street(&cars(gaps), "repeat 3"));
        let plan = plan(&suite).unwrap();
        for case in plan.trial(0).cases.iter() {
            let values: Vec<_> = case.variation.iter().cloned().chain(case.drawn_values()).collect();
            let own = standalone(&suite.scenarios[0], &values, &case.individuals, case.seed).unwrap();
            let written = write_scenario(&own, &[], &[], Path::new(""));
            let again = planned(&written).unwrap_or_else(|error| panic!("{written}\n{error}"));
            assert_eq!(*again.world, *case.world, "{written}");
            assert_eq!(again.seed, case.seed);
        }
    }
}

#[test]
fn what_says_a_stream_anew_says_it_of_what_repeats_it() {
    let text = |own: &str| {
        let base = street(&cars("3 s, then 4 s"), "").replacen("scenario a", "define base()", 1);
        format!("{base}\nscenario a : base {{ {own} }}")
    };
    let slower = case(&text("stream cars { speed 20 km/h; gaps 5 s, then 6 s }"));
    let speed = |name: &str| slower.world.vehicles.iter().find(|car| car.name == name).unwrap().speed;
    assert!((speed("cars_1") - 20.0 / 3.6).abs() < 1e-12 && speed("far_2") == speed("cars_1"));
    assert_eq!(arrivals(&slower, "far"), [3.5, 8.5, 14.5]);
    let far = case(&text("stream far { first 4 s before crossing; gaps 2.5 s, then 9 s }"));
    assert_eq!(arrivals(&far, "far"), [4.0, 6.5, 15.5]);
    assert_eq!(arrivals(&far, "cars"), [2.0, 5.0, 9.0, 13.0]);
}

#[test]
fn gaps_may_vary_and_a_pedestrian_may_wait_for_a_vehicle_of_a_stream() {
    let text = street(
        &cars("3 s, gap, then 2.5 s"),
        "vary gap in [4 s, 6.5 s]\n pedestrian walker { looks for 0 s; appears when time_to_arrival(cars_2) = 2 s }",
    );
    let text = text.replacen(WALKER, "", 1).replacen(
        "pedestrian walker {",
        "pedestrian walker { model commotions; start 2.3 m from lane centre;",
        1,
    );
    let plan = plan(&loaded(&text)).unwrap();
    let second = |trial: usize| arrivals(&plan.trial(trial).cases.first(), "cars")[2];
    assert_eq!((plan.len(), second(0), second(1)), (2, 9.0, 11.5));
    let error = planned(&text.replace("cars_2", "cars_9")).unwrap_err();
    assert!(error.contains("no vehicle called `cars_9`"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn the_order_in_which_streams_are_declared_changes_nothing(
        gap in 25u32..60,
        seed in 0u32..1000,
    ) {
        let near = format!("stream cars {{ controller constant_speed; speed 30 km/h; first 2 s before crossing; gaps 3 s, {} s, then 2.5 s }}", f64::from(gap) / 10.0);
        let far = "stream far { controller constant_speed; speed 30 km/h; lane 1; first 3 s before crossing; gaps 3 s, then 5 s }";
        let rest = format!("seed {seed}");
        let one = measured(&street(&format!("{near}\n{far}"), &rest));
        let other = measured(&street(&format!("{far}\n{near}"), &rest));
        prop_assert_eq!(one.values, other.values);
        prop_assert_eq!(one.ending, other.ending);
    }
}
