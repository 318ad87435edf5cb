//! Who rides is met, hit and counted as who walks is, and seen as what they are.

use std::sync::{Arc, Mutex};

use files::Memory;
use models::standard;
use results::Requests;
use runner::plan::plan;
use runner::run::{FreeFlows, Unwatched, road_users, run_case};
use scenario::registry::Registry;
use scenario::{Chance, CommandKind, ControllerModel, Declaration, RoadUserKind, Scenario, Shape};
use sim::{Command, Controller, ControllerError, Observation, Observer, Schedule, Snapshot, Step, simulate};

/// A controller that keeps its speed and remembers whom it saw.
struct Looks(Arc<Mutex<Vec<RoadUserKind>>>);

impl Controller for Looks {
    fn schedule(&self) -> Schedule {
        Schedule::every(0.1)
    }

    fn act(&mut self, seen: &Observation) -> Result<Command, ControllerError> {
        let mut known = self.0.lock().unwrap();
        for person in &seen.pedestrians {
            if !known.contains(&person.kind) {
                known.push(person.kind);
            }
        }
        Ok(Command::Acceleration(0.0))
    }
}

fn registry() -> (Registry, Arc<Mutex<Vec<RoadUserKind>>>) {
    let kinds = Arc::new(Mutex::new(Vec::new()));
    let seen = kinds.clone();
    let looks = ControllerModel::new(
        Declaration::new("looks", "Keeps its speed.").source("test"),
        CommandKind::Acceleration,
        move |_| Ok(Box::new(Looks(seen.clone()))),
    );
    (standard().with_controller(looks.chance(Chance::Never)).unwrap(), kinds)
}

fn loaded(text: &str, registry: &Registry) -> scenario::Suite {
    let files = Memory::default().with("a.scn", text);
    let loaded = lang::load("a.scn".as_ref(), registry, &files);
    loaded.unwrap_or_else(|failure| panic!("{text}\n{:?}", failure.diagnostics)).suite
}

/// Everybody whom `people` describes, before a car that keeps its speed: the scenario, and the value of metrics in its run.
fn run(people: &str) -> (Scenario, impl Fn(&str) -> Option<f64> + use<>, scenario::World, Vec<RoadUserKind>) {
    let (registry, kinds) = registry();
    let suite = loaded(
        &format!(
            "
scenario street {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked }}
  vehicle av {{ controller looks; speed 36 km/h; size 4.4 m x 1.8 m; start 60 m before crossing }}
  {people}
}}"
        ),
        &registry,
    );
    let plan = plan(&suite).unwrap_or_else(|errors| panic!("{people}\n{}", errors[0]));
    let trial = plan.trial(0);
    let case = trial.cases.first();
    let requests = Requests::defaults(&registry);
    let outcome = run_case(&case, &requests, &FreeFlows::default(), &mut Unwatched).unwrap();
    let names: Vec<String> = requests.iter().map(|request| request.metric.name().to_string()).collect();
    let value = move |metric: &str| outcome.metrics[names.iter().position(|name| name == metric).unwrap()];
    let seen = kinds.lock().unwrap().clone();
    (suite.scenarios[0].clone(), value, (*case.world).clone(), seen)
}

const RIDES: &str =
    "model scripted { speed: 15 km/h, acceleration_way: 3 m }; start 12 m from lane centre; meets av at 25 %";

#[test]
fn who_rides_has_a_body_and_a_point_of_their_own() {
    let body = |people: &str| {
        let (_, _, world, _) = run(people);
        (world.pedestrians[0].kind, world.pedestrians[0].shape, world.pedestrians[0].reference)
    };
    let bicycle = Shape::Rectangle { length: 1.89, width: 0.5 };
    assert_eq!(body(&format!("cyclist rider {{ {RIDES} }}")), (RoadUserKind::Cyclist, bicycle, 0.015));
    let scooter = Shape::Rectangle { length: 1.2, width: 0.6 };
    assert_eq!(body(&format!("escooter rider {{ {RIDES} }}")), (RoadUserKind::Escooter, scooter, 0.0));
    // Of another body nobody knows where its cranks are.
    let long = Shape::Rectangle { length: 2.5, width: 0.8 };
    assert_eq!(
        body(&format!("cyclist rider {{ {RIDES}; size 2.5 m x 0.8 m }}")),
        (RoadUserKind::Cyclist, long, 0.0)
    );
    let said = body(&format!("cyclist rider {{ {RIDES}; reference 0 m ahead of centre }}"));
    assert_eq!(said, (RoadUserKind::Cyclist, bicycle, 0.0));
}

#[test]
fn who_rides_is_hit_and_counted_as_somebody_on_foot_with_that_body() {
    let rides = run(&format!("cyclist rider {{ {RIDES} }}"));
    let walks = run(&format!(
        "pedestrian rider {{ {RIDES}; size 1.89 m x 0.5 m; reference 0.015 m ahead of centre }}"
    ));
    for metric in [
        "collision",
        "impact_speed",
        "impact_point",
        "min_ttc",
        "drac",
        "time_headway",
        "pet",
        "min_distance",
    ] {
        assert_eq!(rides.1(metric), walks.1(metric), "{metric}");
    }
    assert_eq!(rides.1("collision"), Some(1.0));
    assert!((rides.1("impact_point").unwrap() - 0.25).abs() < 1e-9);
    // The same world but for what they are.
    assert_ne!(rides.2, walks.2);
    assert_eq!(serde_json::to_value(&walks.2).unwrap()["pedestrians"][0].get("kind"), None);
    assert_eq!(serde_json::to_value(&rides.2).unwrap()["pedestrians"][0]["kind"], "cyclist");
}

#[test]
fn controllers_see_what_somebody_is() {
    let (_, _, _, seen) = run(&format!(
        "cyclist one {{ {RIDES} }}
  escooter two {{ model scripted; start 6 m from lane centre; along 8 m }}
  pedestrian three {{ model scripted; start 6 m from lane centre; along 16 m }}"
    ));
    for kind in RoadUserKind::ALL {
        assert!(seen.contains(&kind), "{kind:?} is not among {seen:?}");
    }
    let (_, _, _, seen) = run("pedestrian three { model scripted; start 6 m from lane centre }");
    assert_eq!(seen, [RoadUserKind::Pedestrian]);
}

#[test]
fn who_rides_is_written_and_read_back() {
    for people in [
        format!("cyclist rider {{ {RIDES} }}"),
        format!("cyclist rider {{ {RIDES}; reference 0 m ahead of centre }}"),
        format!("cyclist rider {{ {RIDES}; size 1.89 m x 0.5 m }}"),
        format!("escooter rider {{ {RIDES}; reference 0.1 m behind centre }}"),
        "cyclist rider { model scripted; from far side; walks against traffic; goal 30 m further; meets av at 25 % after 5 m }".to_string(),
        "cyclist riders times 2 { model scripted; start 12 m from lane centre; along each(0 m, 4 m) }".to_string(),
    ] {
        let (registry, _) = registry();
        let (scenario, ..) = run(&people);
        let written = lang::write_scenario(&scenario, &[], &[], "".as_ref());
        let mut again = loaded(&written, &registry).scenarios.remove(0);
        for (known, read) in scenario.pedestrians.iter().zip(&mut again.pedestrians) {
            assert_eq!((known.kind, &known.shape, &known.reference), (read.kind, &read.shape, &read.reference), "{written}");
            assert_eq!((&known.walks, &known.appears), (&read.walks, &read.appears), "{written}");
        }
        assert_eq!(scenario.pedestrians.len(), again.pedestrians.len());
    }
}

#[test]
fn a_cyclist_who_yields_waits_at_red_and_brakes_before_it() {
    let street = |conduct: &str| {
        let text = format!(
            "
scenario street {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing signalised {{ cycle: 60 s, pedestrian_green: 20 s, pedestrian_green_from: 15 s }} }}
  vehicle av {{ controller constant_speed; speed 36 km/h; start 300 m before crossing }}
  cyclist rider {{ model yielding_cyclist; start 30 m from lane centre; {conduct} signals }}
  horizon 60 s
}}"
        );
        let plan = plan(&loaded(&text, &standard())).unwrap();
        let case = plan.trial(0).cases.first();
        let mut course = Course::default();
        simulate(&case.world, road_users(&case.world, case.seed).unwrap(), &mut course).unwrap();
        course
    };
    let obeys = street("obeys");
    let before_green: Vec<_> = obeys.0.iter().filter(|(time, ..)| *time < 15.0).collect();
    // Kerb at -1.75 m, half a bicycle and 0.5 m before it.
    let stands = before_green.last().unwrap().1;
    assert!((-1.75 - 0.945 - 0.9..=-1.75 - 0.945 - 0.5 + 1e-9).contains(&stands), "{stands}");
    // It brakes as it can, and is not stopped at once by the rule that keeps everybody off the road in red.
    assert!(obeys.0.windows(2).all(|two| two[0].2 - two[1].2 < 3.4 * 0.025 + 1e-9));
    assert!(obeys.0.iter().any(|(time, place, _)| *time < 25.0 && *place > 2.0));
    let ignores = street("ignores");
    assert!(ignores.0.iter().any(|(time, place, _)| *time < 7.0 && *place > 2.0));
}

/// Time (s), place across the road (m) and speed (m/s) of the first who rides, after each step.
#[derive(Default)]
struct Course(Vec<(f64, f64, f64)>);

impl Observer for Course {
    fn begin(&mut self, _: &Snapshot) {}

    fn observe(&mut self, step: &Step) {
        let rider = &step.after.pedestrians[0];
        self.0.push((step.time + step.duration, rider.position.y, rider.velocity.y));
    }
}
