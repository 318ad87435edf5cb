//! What is recorded of what controllers were told that was not so.

use std::sync::Arc;

use files::Memory;
use models::standard;
use nalgebra::Vector2;
use runner::plan::plan;
use runner::run::road_users;
use scenario::World;
use sim::{PerceivedView, Sample, Trace, simulate};

const STREET: &str = "lanes 2; crossing unmarked;";
const BEND: &str = "path { straight 150 m; arc 90 deg radius 40 m left; straight 150 m }; lanes 2; crossing unmarked { at: 180 m };";
const WALKER: &str =
    "pedestrian walker { model scripted { speed: 1 m/s, delay: 2 s }; start 0.5 m from kerb }";

/// The course of a scenario on this road with these road users.
fn run_on(road: &str, users: &str) -> (World, Trace) {
    let text = format!(
        "scenario street {{\n road {{ {road} lane_width 3.5 m; speed_limit 50 km/h; }}\n horizon 12 s\n{users}\n}}"
    );
    let files = Memory::default().with("a.scn", text.clone());
    let loaded = lang::load("a.scn".as_ref(), &standard(), &files);
    let suite = loaded.unwrap_or_else(|failure| panic!("{text}\n{:?}", failure.diagnostics)).suite;
    let plan = plan(&suite).unwrap_or_else(|errors| panic!("{text}\n{}", errors[0]));
    let world = plan.trial(0).cases.first().world.clone();
    let mut trace = Trace::default();
    simulate(&world, road_users(&world, 1).unwrap(), &mut trace).unwrap();
    (Arc::unwrap_or_clone(world), trace)
}

fn av(sees: &str) -> String {
    format!(
        "vehicle av {{ controller constant_speed; speed 18 km/h; start 60 m before crossing; {sees} }}\n{WALKER}"
    )
}

/// Where somebody was at a time, to the step.
fn at(trace: &Trace, who: usize, time: f64) -> &Sample {
    trace.samples.iter().find(|sample| sample.who == who && (sample.time - time).abs() < 1e-6).unwrap()
}

#[test]
fn late_perception_has_them_where_they_were() {
    for road in [STREET, BEND] {
        let (_, trace) = run_on(road, &av("sees { latency: 0.3 s }"));
        assert!(trace.perceived.len() > 50, "{road} {}", trace.perceived.len());
        let told = trace.perceived.iter().filter(|view| !view.others.is_empty());
        for PerceivedView { vehicle, time, age, others } in told.clone() {
            let age = age.unwrap();
            assert!(*vehicle == 0 && (age - 0.3).abs() < 1e-9 && others.len() == 1, "{age}");
            let (was, is) = (at(&trace, 1, time - age).position, at(&trace, 1, *time).position);
            assert!((others[0].position - was).norm() < 1e-6, "{road} {time}: {} {was}", others[0].position);
            assert!((others[0].off - (is - was).norm()).abs() < 1e-6, "{road} {time}: {}", others[0].off);
        }
        // Who stands is where they were, and nothing is told of that; once they walk, they are 0.3 m behind.
        let first = told.clone().next().unwrap();
        assert!(first.time > 2.0 - 1e-9 && first.time < 2.1, "{}", first.time);
        assert!(told.clone().any(|view| (view.others[0].off - 0.3).abs() < 1e-6));
        assert!(told.clone().all(|view| view.others[0].off < 0.3 + 1e-6));
    }
}

#[test]
fn noise_is_told_from_the_truth() {
    let (_, trace) = run_on(STREET, &av("sees { position_noise: 0.5 m }"));
    let off: Vec<f64> =
        trace.perceived.iter().flat_map(|view| view.others.iter().map(|one| one.off)).collect();
    let mean_square = off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64;
    // Two axes of 0.5 m.
    assert!(off.len() > 80 && (mean_square - 0.5).abs() < 0.15, "{} {mean_square}", off.len());
    for view in &trace.perceived {
        assert_eq!(view.age, Some(0.0));
        for other in &view.others {
            let is = at(&trace, other.who, view.time).position;
            let off: Vector2<f64> = other.position - is;
            assert!((off.norm() - other.off).abs() < 1e-6, "{} {}", off.norm(), other.off);
        }
    }
}

/// Runs without it have nothing recorded, and who is hidden is simply absent.
#[test]
fn nothing_is_recorded_of_who_is_told_the_truth() {
    for sees in ["", "sees { range: 500 m }", "sees { range: 15 m }", "sees { dropout: 0.5 }"] {
        let (_, trace) = run_on(STREET, &av(sees));
        assert_eq!(trace.perceived, [], "{sees}");
        let (_, trace) = run_on(BEND, &av(sees));
        assert_eq!(trace.perceived, [], "{sees}");
    }
}

#[test]
fn each_vehicle_is_told_of_its_own() {
    let users = format!(
        "vehicle first {{ controller constant_speed; speed 18 km/h; start 60 m before crossing; sees {{ latency: 0.5 s }} }}
vehicle second {{ controller constant_speed; speed 36 km/h; lane 1; start 60 m before crossing; sees {{ latency: 0.1 s }} }}
{WALKER}"
    );
    let (_, trace) = run_on(STREET, &users);
    for (vehicle, other, latency, speed) in [(0, 1, 0.5, 10.0), (1, 0, 0.1, 5.0)] {
        let views = trace.perceived.iter().filter(|view| view.vehicle == vehicle && view.time > 1.0);
        let off: Vec<f64> = views
            .flat_map(|view| view.others.iter().filter(|one| one.who == other).map(|one| one.off))
            .collect();
        assert!(off.len() > 10 && off.iter().all(|off| (off - latency * speed).abs() < 1e-6), "{off:?}");
        assert!(trace.perceived.iter().any(|view| view.vehicle == vehicle && view.others.len() == 2));
    }
}

/// A loss between two decisions ends what is told of somebody, and what stands in a recording is what was told last.
#[test]
fn what_is_lost_is_not_told_of() {
    let (_, trace) = run_on(STREET, &av("sees { latency: 0.2 s, dropout: 0.3 }"));
    let is_told = |time: f64| PerceivedView::last(&trace.perceived, 0, time).is_some();
    let ends = trace.perceived.iter().filter(|view| view.others.is_empty());
    assert!(ends.clone().count() > 5 && ends.clone().all(|view| !is_told(view.time)));
    for (index, view) in trace.perceived.iter().enumerate().filter(|(_, view)| view.others.is_empty()) {
        assert!(index > 0 && !trace.perceived[index - 1].others.is_empty(), "{}", view.time);
    }
}
