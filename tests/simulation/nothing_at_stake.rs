//! Nothing at stake is never green: with a vehicle that stands at its start, or that began beyond every pedestrian's way, no criterion and
//! no rating of what ships is fulfilled and put to the test.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use files::Disk;
use models::standard;
use nalgebra::Vector2;
use rayon::prelude::*;
use results::judge::{judge, judge_rating};
use results::{CellWorth, Outcome, RatingState, Requests, TrialReport, TrialState, Verdict};
use runner::plan::{self, Plan, PlannedTrial};
use runner::run::{FreeFlows, Unwatched, run_case};
use scenario::{Case, ModelSetup, Scope, Settings, Stake, Suite, VehicleSetup, VehicleStart, World};

/// How nothing is at stake.
#[derive(Debug, Clone, Copy)]
enum Idle {
    /// Every vehicle stands at its start from the first moment.
    Stands,
    /// Every vehicle starts this far beyond the ways of all pedestrians, m.
    Beyond(f64),
}

const IDLE: [Idle; 2] = [Idle::Stands, Idle::Beyond(50.0)];

fn suites() -> Vec<(PathBuf, Suite)> {
    let patterns =
        ["suites/*.suite", "suites/paper/*.suite", "scenarios/*/*.scn", "templates/*/scenarios/*.scn"];
    let files = patterns.into_iter().flat_map(|pattern| glob::glob(pattern).expect("a pattern"));
    let files: Vec<PathBuf> = files.map(|path| path.expect("a path")).collect();
    let load = |path: &PathBuf| {
        let loaded = lang::load(Path::new(path), &standard(), &Disk);
        loaded.ok().map(|loaded| (path.clone(), loaded.suite))
    };
    files.iter().filter_map(load).collect()
}

/// Trials of a plan that have every criterion of it: the first and the last of each scenario, and each with a criterion that none
/// before it has.
fn trials(plan: &Plan) -> Vec<PlannedTrial> {
    let mut known: Vec<(String, String)> = Vec::new();
    let mut chosen = Vec::new();
    for scenario in plan.scenarios() {
        let (last, mut is_first) = (scenario.len().saturating_sub(1), true);
        for index in 0..scenario.len().min(200) {
            let trial = scenario.trial(index);
            let mut is_new = false;
            for criterion in trial.criteria.iter() {
                let key = (trial.scenario.clone(), criterion.text.clone());
                if !known.contains(&key) {
                    known.push(key);
                    is_new = true;
                }
            }
            if is_new || is_first || index == last {
                chosen.push(trial);
            }
            is_first = false;
        }
    }
    chosen
}

/// The case with vehicles that put nothing to the test.
fn idle(case: &Case, how: Idle) -> Case {
    let mut case = case.clone();
    let world = Arc::make_mut(&mut case.world);
    match how {
        Idle::Stands => {
            let registry = standard();
            let constant = registry.controllers().get("constant_speed").expect("it ships").clone();
            let settings = constant.declaration.resolve(&Settings::default()).expect("its defaults");
            for vehicle in &mut world.vehicles {
                vehicle.start = VehicleStart::Distance(before_crossing(&vehicle.start, vehicle.speed));
                vehicle.speed = 0.0;
                vehicle.controller =
                    ModelSetup { model: constant.clone().into(), settings: settings.clone() };
            }
        }
        Idle::Beyond(distance) => {
            let beyond: Vec<f64> =
                world.vehicles.iter().map(|vehicle| farthest(world, vehicle) + distance).collect();
            for (vehicle, place) in world.vehicles.iter_mut().zip(beyond) {
                vehicle.start = VehicleStart::Distance(-place - vehicle.length / 2.0);
            }
        }
    }
    case
}

/// About how far before the crossing a vehicle starts, m: where exactly makes no difference to one that stands.
fn before_crossing(start: &VehicleStart, speed: f64) -> f64 {
    match start {
        VehicleStart::Distance(distance) => *distance,
        VehicleStart::TimeToArrival { time, .. } => time * speed,
    }
}

/// The farthest place along a vehicle's way that a pedestrian starts at or goes to, m.
fn farthest(world: &World, vehicle: &VehicleSetup) -> f64 {
    let path = world.path_of(vehicle);
    let ends = world.pedestrians.iter().flat_map(|person| [person.start, person.goal]);
    ends.map(|place| path.along(Vector2::from(place))).fold(0.0, f64::max)
}

/// The criteria that are green though nothing is at stake, as `how: trial: criterion`. A case that cannot be run is refused.
fn green(trial: &PlannedTrial, how: Idle, requests: &Requests) -> Vec<String> {
    let Some(outcome) = run_idle(trial, how, requests) else { return Vec::new() };
    let judged = judge(&trial.criteria, std::slice::from_ref(&outcome), requests);
    let about_people = |scope: Scope| matches!(scope, Scope::Pair | Scope::Contact | Scope::Pedestrian);
    let is_box =
        |name: &str| outcome.presences.iter().all(|pair| &*pair.other != name && &*pair.vehicle != name);
    let green = judged.findings.iter().zip(trial.criteria.iter()).filter(|(finding, criterion)| {
        let reference = criterion.claim.metric();
        let named = reference.pair.as_ref().map(|(_, other)| other.as_str());
        let is_of_box =
            reference.several.is_empty() && named.is_some_and(|name| !name.is_empty() && is_box(name));
        finding.verdict == Verdict::Passed
            && finding.untested.is_none()
            && reference
                .known()
                .is_some_and(|metric| about_people(metric.scope) && metric.stake != Stake::Appearance)
            && !is_of_box
            && !outcome.presences.is_empty()
    });
    green.map(|(finding, _)| format!("{how:?}: {}: {}", trial.key, finding.criterion)).collect()
}

fn run_idle(trial: &PlannedTrial, how: Idle, requests: &Requests) -> Option<Outcome> {
    let case = idle(&trial.cases.get(0), how);
    run_case(&case, requests, &FreeFlows::default(), &mut Unwatched).ok()
}

#[test]
fn no_criterion_that_ships_is_green_with_nothing_at_stake() {
    let mut looked_at = 0;
    let mut found = Vec::new();
    for (path, suite) in suites() {
        // What cannot be planned is looked at elsewhere.
        let Ok(plan) = plan::plan(&suite) else { continue };
        let trials = trials(&plan);
        let mut requests = Requests::defaults(&standard());
        trials.iter().for_each(|trial| requests.include(&trial.criteria));
        looked_at += trials.len();
        let of = |trial: &PlannedTrial| {
            let each = IDLE.into_iter().flat_map(|how| green(trial, how, &requests));
            each.map(|one| format!("{}: {one}", path.display())).collect::<Vec<_>>()
        };
        found.extend(trials.par_iter().flat_map(of).collect::<Vec<_>>());
    }
    assert!(looked_at > 200, "only {looked_at} trials");
    assert!(found.is_empty(), "{} are green with nothing at stake:\n{}", found.len(), found.join("\n"));
}

#[test]
fn no_rating_that_ships_earns_points_with_nothing_at_stake() {
    let mut cells = 0;
    for (path, suite) in suites() {
        if suite.ratings.is_empty() {
            continue;
        }
        let plan = plan::plan(&suite).expect("it is right");
        let mut requests = Requests::defaults(&standard());
        suite.ratings.iter().for_each(|rating| requests.add(&rating.measure));
        for how in IDLE {
            let report = |trial: &PlannedTrial| {
                let outcome = run_idle(trial, how, &requests)?;
                Some(TrialReport {
                    trial: trial.trial.clone(),
                    state: TrialState::Judged(judge(&[], std::slice::from_ref(&outcome), &requests)),
                    outcomes: vec![outcome],
                    departures: Vec::new(),
                    wall_time: std::time::Duration::ZERO,
                })
            };
            let reports: Vec<TrialReport> = trials(&plan).par_iter().filter_map(report).collect();
            for rating in &suite.ratings {
                let judged = judge_rating(&Arc::new(rating.clone()), &suite.name, &reports, &[], &requests);
                let RatingState::Rated(result) = judged.state else {
                    panic!("{}: not rated", path.display())
                };
                for cell in &result.cells {
                    cells += 1;
                    let is_open = matches!(cell.worth, CellWorth::NotAssessed(_));
                    assert!(is_open, "{}: {how:?}: {} is worth {:?}", path.display(), cell.key, cell.worth);
                }
            }
        }
    }
    assert!(cells > 10, "only {cells} cells");
}
