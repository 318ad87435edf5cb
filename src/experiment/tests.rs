//! Searches and tunes over real simulations, small ones.

use super::*;
use crate::scenario::{
    Aggregate, Budget, CaseSet, Crossing, CrossingKind, DeclaredAppearance, DeclaredVehicleStart, Direction,
    Expression, Goal, Individuals, InitialDesign, Lane, Method, MetricReference, Model, Objective, Origin,
    Part, Pedestrian, Population, Range, RangeValues, Relation, Road, SampleSize, Search, Settings, Side,
    Target, Tune, Variation, VariedValue, Vehicle, VehicleReference, WhenUndefined,
};
use crate::scenario::{Comparison as Condition, Value};

fn metric(name: &str) -> MetricReference {
    MetricReference { name: name.into(), settings: Settings::default(), pair: None }
}

fn condition(name: &str, relation: Relation, bound: f64) -> Condition {
    Condition { metric: metric(name), relation, bound: bound.into(), when_undefined: WhenUndefined::Fails }
}

fn model(name: &str, settings: &[(&str, Value)]) -> Model {
    let settings =
        settings.iter().map(|(name, value)| (name.to_string(), Expression::Constant(value.clone())));
    Model { name: name.into(), settings: settings.collect(), origin: Origin::default() }
}

fn scenario() -> Scenario {
    let label = |value: f64| VariedValue { value: Value::Number(value), label: format!("{value}s") };
    Scenario {
        name: "encounter".into(),
        doc: None,
        tags: Vec::new(),
        road: Road {
            name: String::new(),
            lane_width: 4.0,
            lanes: vec![Lane { direction: Direction::Forward }, Lane { direction: Direction::Backward }],
            speed_limit: 30.0 / 3.6,
            kerbs: true,
            crossing: Crossing { kind: CrossingKind::Zebra, width: 4.0 },
            boxes: Vec::new(),
        },
        vehicles: vec![Vehicle {
            name: "av".into(),
            controller: model("carla_behavior", &[("obstacle_distance", Value::Word("extended".into()))]),
            dynamics: None,
            size: None,
            speed: (30.0 / 3.6).into(),
            start: DeclaredVehicleStart::Automatic,
            lane: 0,
            sees: None,
            origin: Origin::default(),
        }],
        pedestrians: vec![Pedestrian {
            name: "walker".into(),
            model: model("commotions", &[]),
            shape: None,
            side: Side::Near,
            start_from_lane_centre: 4.0.into(),
            along: 0.0.into(),
            goal_beyond_kerb: 2.0.into(),
            appears: DeclaredAppearance::TimeToArrival {
                vehicle: "av".into(),
                reference: VehicleReference::Centre,
                time: Expression::Variable("tta".into()),
            },
            individuals: Some(Individuals {
                selection: Population::Count(3),
                population: "standard".into(),
                origin: Origin::default(),
            }),
            origin: Origin::default(),
        }],
        variations: vec![Variation::Grid {
            names: vec!["tta".into()],
            rows: vec![vec![label(6.0)], vec![label(9.0)]],
        }],
        repeat: 2,
        criteria: Vec::new(),
        step: 0.025,
        horizon: 60.0,
        finish: 60.0,
        end_on_collision: true,
        origin: Origin::default(),
    }
}

fn budget(evaluations: u32) -> Budget {
    Budget {
        evaluations,
        initial: 5,
        initial_design: InitialDesign::Random,
        method: Method::Bayesian,
        batch: 2,
    }
}

fn range(target: Target, low: f64, high: f64, unit: &str) -> Range {
    Range { target, values: RangeValues::Real { low, high }, unit: unit.into(), origin: Origin::default() }
}

fn suite() -> Suite {
    let search = Search {
        name: "low_pet".into(),
        doc: None,
        scenario: "encounter".into(),
        individuals: None,
        together: false,
        objective: Objective {
            direction: Goal::Minimise,
            aggregate: Aggregate::Mean(metric("pet")),
            text: "minimise pet".into(),
        },
        over: vec![range(Target::Variation("tta".into()), 6.0, 18.0, "s")],
        budget: budget(9),
        runs: 1,
        keep: Some(condition("pet", Relation::Less, 100.0)),
        origin: Origin::default(),
    };
    let parameter = Target::Setting {
        road_user: "av".into(),
        part: Part::Controller,
        parameter: "braking_distance".into(),
    };
    let tune = Tune {
        name: "braking".into(),
        doc: None,
        on: CaseSet::Search("low_pet".into()),
        over: vec![range(parameter, 4.0, 25.0, "m")],
        objectives: vec![Objective {
            direction: Goal::Minimise,
            aggregate: Aggregate::Mean(metric("time_lost")),
            text: "minimise mean(time_lost)".into(),
        }],
        constraints: vec![condition("min_distance", Relation::Greater, 0.0)],
        budget: budget(8),
        early_stop: true,
        compare_with_default: true,
        origin: Origin::default(),
    };
    Suite {
        name: "paper".into(),
        doc: None,
        seed: 11,
        time_limit: None,
        scenarios: vec![scenario()],
        searches: vec![search],
        tunes: vec![tune],
        evaluates: Vec::new(),
        statements: Vec::new(),
        gates: Vec::new(),
        origin: Origin::default(),
    }
}

fn run(suite: &Suite, journals: Option<std::path::PathBuf>) -> (SearchResult, TuneResult) {
    let laboratory = Laboratory::new(suite, journals);
    let found = run_search(&laboratory, &suite.searches[0], &Silent).unwrap();
    let mut results = Results::default();
    results.blocks.insert(found.name.clone(), BlockResult::Search(found.clone()));
    let tuned = run_tune(&laboratory, &suite.tunes[0], &results, &Silent).unwrap();
    (found, tuned)
}

fn text(results: &(SearchResult, TuneResult)) -> String {
    serde_json::to_string(results).unwrap()
}

#[test]
fn a_search_and_a_tune_on_what_it_found() {
    let suite = suite();
    let (found, tuned) = run(&suite, None);
    assert_eq!(found.found.len(), 3);
    for one in &found.found {
        assert_eq!(one.evaluations.len(), 9);
        let values = one.evaluations.iter().filter_map(|(_, value)| *value);
        assert_eq!(one.observed, values.reduce(f64::min), "the best is the smallest that was seen");
        assert!(one.fresh.is_some() && one.predicted.is_some() && one.passed_first.is_some());
    }
    assert_eq!(found.kept.cases.len(), 3);
    assert_eq!(tuned.cases, 3);
    assert_eq!(tuned.evaluations.len(), 8);
    let chosen = tuned.chosen.as_ref().unwrap();
    assert!(chosen.feasible && chosen.objectives[0].is_some());
    let comparison = tuned.comparison.unwrap();
    let pet = |table: &[MetricSummary]| table.iter().find(|row| row.metric == "pet").unwrap().mean.unwrap();
    // The table before is over the very runs that the search kept.
    let kept: Vec<f64> = found.kept.cases.iter().map(|case| case.value.unwrap()).collect();
    assert!((pet(&comparison.before) - kept.iter().sum::<f64>() / 3.0).abs() < 1e-12);
    assert_ne!(pet(&comparison.before), pet(&comparison.before_fresh));
}

#[test]
fn threads_change_nothing() {
    let suite = suite();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| text(&run(&suite, None)))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn a_run_that_was_cut_off_resumes_to_the_same_result() {
    let suite = suite();
    let folder = tempfile::tempdir().unwrap();
    let undisturbed = text(&run(&suite, None));
    let laboratory = Laboratory::new(&suite, Some(folder.path().to_owned()));
    // Dies in the middle of the search.
    struct Dies;
    impl Progress for Dies {
        fn evaluated(&self, done: usize, _all: usize, _best: Option<f64>) {
            assert!(done < 13, "killed");
        }
    }
    let killed = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        run_search(&laboratory, &suite.searches[0], &Dies)
    }));
    assert!(killed.is_err());
    assert!(std::fs::read_dir(folder.path()).unwrap().count() > 0, "journals are left behind");
    assert_eq!(text(&run(&suite, Some(folder.path().to_owned()))), undisturbed);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "and removed in the end");
}

#[test]
fn a_run_that_is_asked_to_stop_leaves_a_journal_without_the_evaluations_that_it_gave_up() {
    let suite = suite();
    let folder = tempfile::tempdir().unwrap();
    let undisturbed = text(&run(&suite, None));
    let laboratory = Laboratory::new(&suite, Some(folder.path().to_owned()));
    struct Stops<'a>(&'a crate::run::Stop);
    impl Progress for Stops<'_> {
        fn evaluated(&self, done: usize, _all: usize, _value: Option<f64>) {
            if done == 13 {
                self.0.request();
            }
        }
    }
    let stopped = run_search(&laboratory, &suite.searches[0], &Stops(&laboratory.stop));
    assert!(matches!(stopped, Err(ExperimentError::Stopped)));
    let lines = |path: std::path::PathBuf| std::fs::read_to_string(path).unwrap().lines().count();
    let files = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
    // A line of each journal says what it belongs to.
    let recorded: usize = files.map(|path| lines(path) - 1).sum();
    assert!((13..27).contains(&recorded), "{recorded} of 27 evaluations are recorded");
    assert_eq!(text(&run(&suite, Some(folder.path().to_owned()))), undisturbed);
}

#[test]
fn sets_of_cases_round_trip_and_can_be_tuned_on() {
    let mut suite = suite();
    let (found, tuned) = run(&suite, None);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("low_pet.json");
    std::fs::write(&path, CaseFile::write(&found.kept)).unwrap();
    assert_eq!(CaseFile::read(&path).unwrap(), found.kept);
    suite.tunes[0].on = CaseSet::Saved(path.to_string_lossy().into_owned());
    let laboratory = Laboratory::new(&suite, None);
    let again = run_tune(&laboratory, &suite.tunes[0], &Results::default(), &Silent).unwrap();
    assert_eq!(serde_json::to_string(&again).unwrap(), serde_json::to_string(&tuned).unwrap());
}

#[test]
fn an_empty_set_and_an_unsatisfiable_constraint_are_said_plainly() {
    let mut suite = suite();
    suite.searches[0].keep = Some(condition("pet", Relation::Less, -1.0));
    let laboratory = Laboratory::new(&suite, None);
    let early = run_tune(&laboratory, &suite.tunes[0], &Results::default(), &Silent);
    assert_eq!(early.unwrap_err().to_string(), "`low_pet` has not been run, but is needed");
    let nothing = run_search(&laboratory, &suite.searches[0], &Silent).unwrap();
    let mut results = Results::default();
    results.blocks.insert("low_pet".into(), BlockResult::Search(nothing));
    let empty = run_tune(&laboratory, &suite.tunes[0], &results, &Silent);
    assert_eq!(empty.unwrap_err().to_string(), "the set of cases `low_pet` is empty");
    suite.tunes[0].on = CaseSet::Sample { scenario: "encounter".into(), count: SampleSize::Number(2) };
    suite.tunes[0].constraints = vec![condition("min_distance", Relation::Greater, 1e6)];
    let laboratory = Laboratory::new(&suite, None);
    let result = run_tune(&laboratory, &suite.tunes[0], &Results::default(), &Silent).unwrap();
    assert!(result.chosen.is_none() && result.evaluations.iter().all(|one| !one.feasible));
}
