//! Blocks over real simulations, small ones.

use super::*;
use crate::scenario::{self, Comparison as Bound, Value};
use crate::scenario::{
    Aggregate, Budget, CaseSet, Crossing, CrossingKind, DeclaredAppearance, DeclaredVehicleStart, Direction,
    Evaluate, Expression, Goal, Individuals, InitialDesign, Lane, Measure, Measured, Method, MetricReference,
    Model, Objective, Origin, OutcomesOf, ParameterSet, Part, Pedestrian, Population, Quantity, Range,
    RangeValues, Relation, Road, SampleSize, Search, Settings, Side, Standing, Statement, StatementClaim,
    StatementClaimKind, Target, TrendDirection, Tune, Variation, VariationCondition, VariedValue, Vehicle,
    VehicleReference, WhenUndefined,
};

fn metric(name: &str) -> MetricReference {
    MetricReference { name: name.into(), settings: Settings::default(), pair: None }
}

fn condition(name: &str, relation: Relation, bound: f64) -> Bound {
    Bound { metric: metric(name), relation, bound: bound.into(), when_undefined: WhenUndefined::Fails }
}

fn model(name: &str, settings: &[(&str, Value)]) -> Model {
    let settings =
        settings.iter().map(|(name, value)| (name.to_string(), Expression::Constant(value.clone())));
    Model { name: name.into(), varied_by: None, settings: settings.collect(), origin: Origin::default() }
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
        runs: None,
        seed: None,
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

fn braking_distance() -> Target {
    Target::Setting { road_user: "av".into(), part: Part::Controller, parameter: "braking_distance".into() }
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
    let tune = Tune {
        name: "braking".into(),
        doc: None,
        on: CaseSet::Search("low_pet".into()),
        over: vec![range(braking_distance(), 4.0, 25.0, "m")],
        objectives: vec![Objective {
            direction: Goal::Minimise,
            aggregate: Aggregate::Mean(metric("time_lost")),
            text: "minimise mean(time_lost)".into(),
        }],
        constraints: vec![condition("min_distance", Relation::Greater, 0.0)],
        budget: budget(8),
        fresh: 0,
        early_stop: true,
        otherwise_fewest_violations: false,
        compare_with_default: true,
        origin: Origin::default(),
    };
    Suite {
        name: "paper".into(),
        doc: None,
        seed: 11,
        time_limit: None,
        scenarios: vec![scenario()],
        supporting: Vec::new(),
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

#[test]
fn where_nothing_is_feasible_the_fewest_violations_can_be_chosen() {
    let mut suite = suite();
    let tune = &mut suite.tunes[0];
    tune.on = CaseSet::Scenario("encounter".into());
    tune.early_stop = false;
    tune.otherwise_fewest_violations = true;
    let tuned = |suite: &Suite| {
        let laboratory = Laboratory::new(suite, None);
        run_tune(&laboratory, &suite.tunes[0], &Results::default(), &Silent).unwrap()
    };
    // What every run violates is broken equally by all: then the objective decides.
    suite.tunes[0].constraints = vec![condition("min_distance", Relation::Greater, 1e6)];
    let result = tuned(&suite);
    let chosen = result.chosen.unwrap();
    let Violations { runs, of } = result.violations.unwrap();
    assert!(!chosen.feasible && runs == of && of == result.cases);
    let least = result.evaluations.iter().filter_map(|one| one.objectives[0]).min_by(f64::total_cmp);
    assert_eq!(chosen.objectives[0], least);

    // Where something is feasible the clause changes nothing.
    suite.tunes[0].constraints = vec![condition("min_distance", Relation::GreaterOrEqual, 0.0)];
    let result = tuned(&suite);
    assert!(result.chosen.unwrap().feasible && result.violations.is_none());
}

#[test]
fn a_strict_constraint_is_violated_at_its_bound() {
    let suite = suite();
    let laboratory = Laboratory::new(&suite, None);
    let cases = laboratory.cases_of("encounter").unwrap();
    let case = laboratory.revive(&cases[0], &[], "key".into(), None).unwrap();
    let outcomes = [laboratory.run_one(&case).unwrap()];
    // Nobody is hit, so that `collision` is 0.
    let margin = |relation| laboratory.margin(&condition("collision", relation, 0.0), &outcomes).unwrap();
    assert!(margin(Relation::Less) < 0.0 && margin(Relation::Greater) < 0.0);
    assert!(margin(Relation::LessOrEqual) >= 0.0 && margin(Relation::Equal) > 0.0);
}

#[test]
fn stopping_early_costs_no_accuracy() {
    let mut suite = suite();
    suite.tunes[0].on = CaseSet::Scenario("encounter".into());
    let tuned = |early_stop, most_lost| {
        let mut suite = suite.clone();
        suite.tunes[0].early_stop = early_stop;
        suite.tunes[0].constraints = vec![condition("time_lost", Relation::LessOrEqual, most_lost)];
        let laboratory = Laboratory::new(&suite, None);
        run_tune(&laboratory, &suite.tunes[0], &Results::default(), &Silent).unwrap()
    };
    // A bound that some of the random first candidates keep and others do not; they are the same for every bound.
    let mut lost: Vec<f64> =
        tuned(false, 0.0).evaluations[..5].iter().map(|one| -one.margins[0].unwrap()).collect();
    lost.sort_by(f64::total_cmp);
    assert!(lost[0] < lost[4], "{lost:?}");
    let bound = (lost[0] + lost[4]) / 2.0;
    let (early, late) = (tuned(true, bound), tuned(false, bound));
    let pairs = || early.evaluations.iter().zip(&late.evaluations).take(5);
    assert!(pairs().any(|(_, late)| late.feasible) && pairs().any(|(_, late)| !late.feasible));
    for (early, late) in pairs() {
        assert_eq!((&early.point, early.feasible), (&late.point, late.feasible));
        match late.feasible {
            true => assert_eq!(early, late),
            false => {
                assert!(early.margins[0].unwrap() >= late.margins[0].unwrap());
                assert!(early.objectives[0].is_none_or(|value| Some(value) == late.objectives[0]));
            }
        }
    }
}

fn aggregate(aggregate: Aggregate, text: &str) -> Measure {
    Measure { aggregate, text: text.into(), unit: String::new() }
}

/// The suite with an evaluation of its search and tune.
fn evaluated_suite() -> Suite {
    let condition = |name: &str, parameters| scenario::Condition {
        name: name.into(),
        parameters,
        origin: Origin::default(),
    };
    let mut suite = suite();
    suite.evaluates = vec![Evaluate {
        name: "final".into(),
        doc: None,
        on: CaseSet::Bests("low_pet".into()),
        conditions: vec![
            condition("default", ParameterSet::Declared),
            condition("tuned", ParameterSet::Tuned("braking".into())),
            condition("far", ParameterSet::Given(vec![(braking_distance(), Value::Number(25.0))])),
        ],
        fresh: 0,
        measures: vec![
            aggregate(Aggregate::Mean(metric("pet")), "mean(pet)"),
            aggregate(Aggregate::Min(metric("pet")), "min(pet)"),
            aggregate(
                Aggregate::Rate(self::condition("sudden_speed_change", Relation::Equal, 1.0)),
                "rate(sudden_speed_change)",
            ),
        ],
        source: Some("a paper".into()),
        reported: vec![("default".into(), vec![2.48, 1.05, 0.83])],
        origin: Origin::default(),
    }];
    suite
}

/// Every block of a suite in order, with the runs of its scenario.
fn run_all(suite: &Suite) -> Results {
    let laboratory = Laboratory::new(suite, None);
    let mut results = Results::default();
    let cases: Vec<_> = crate::plan::plan_scenario(suite, &suite.scenarios[0])
        .unwrap()
        .into_iter()
        .flat_map(|trial| trial.cases)
        .collect();
    let outcomes = laboratory.run_all(&cases).unwrap();
    results.scenarios.insert("encounter".into(), cases.into_iter().zip(outcomes).collect());
    for block in Block::all(suite) {
        for need in block.needs() {
            match need {
                Need::Block(name) => assert!(results.blocks.contains_key(&name), "{name} comes first"),
                Need::Scenario(name) => assert!(results.scenarios.contains_key(&name)),
            }
        }
        let result = block.run(&laboratory, &results, &Silent).unwrap();
        results.blocks.insert(block.name().into(), result);
    }
    results
}

#[test]
fn an_evaluation_runs_the_same_cases_under_every_condition() {
    let suite = evaluated_suite();
    let results = run_all(&suite);
    let found = results.search("low_pet").unwrap();
    let result = results.evaluate("final").unwrap();
    assert_eq!((result.cases, result.conditions.len()), (3, 3));
    let [default, tuned, far] = result.conditions.as_slice() else { panic!("three conditions") };
    // Under the declared parameters the runs are those that the search found.
    for (run, one) in default.runs.iter().zip(&found.found) {
        assert_eq!(run.outcome.fingerprint, one.runs[0].outcome.fingerprint);
        assert_eq!(run.passed_first, one.passed_first);
        assert_eq!(one.observed, one.runs[0].case.value);
    }
    let mean = found.found.iter().map(|one| one.observed.unwrap()).sum::<f64>() / 3.0;
    assert!((default.measured[0].unwrap() - mean).abs() < 1e-12);
    assert!(default.differences.is_empty() && tuned.differences.len() == 3);
    let change = far.differences[0].unwrap();
    assert!((change.value - (far.measured[0].unwrap() - default.measured[0].unwrap())).abs() < 1e-12);
    assert_eq!(change.pairs, 3);
    assert!(far.differences[1].unwrap().interval.is_none(), "an extreme has no interval");
    assert!(far.differences[2].unwrap().interval.is_some());
    let value = |condition: &ConditionResult| condition.parameters[0].value.clone();
    assert_eq!((value(default), value(far)), (Some(Value::Number(5.0)), Some(Value::Number(25.0))));
    let chosen = results.tune("braking").unwrap().chosen.clone().unwrap().point[0].number();
    assert_eq!(value(tuned), chosen.map(Value::Number));
    assert_eq!(default.reported.as_deref(), Some([2.48, 1.05, 0.83].as_slice()));
    let table = crate::report::render_evaluate(result);
    assert!(table.contains("braking_distance") && table.contains("reported: a paper"), "{table}");
}

#[test]
fn fresh_seeds_are_the_same_under_every_condition() {
    let mut suite = evaluated_suite();
    suite.evaluates[0].fresh = 4;
    let results = run_all(&suite);
    let result = results.evaluate("final").unwrap();
    let [default, _, far] = result.conditions.as_slice() else { panic!("three conditions") };
    assert_eq!(default.runs.len(), 12);
    let seeds = |condition: &ConditionResult| -> Vec<u64> {
        condition.runs.iter().map(|run| run.case.seed).collect()
    };
    assert_eq!(seeds(default), seeds(far));
    let distinct: std::collections::HashSet<u64> = seeds(default).into_iter().collect();
    assert_eq!(distinct.len(), 12);
    assert_eq!(far.differences[2].unwrap().pairs, 3, "a case counts once");
}

#[test]
fn a_condition_may_be_another_scenario_with_the_same_cases() {
    let mut suite = evaluated_suite();
    let mut other = suite.scenarios[0].clone();
    other.name = "far".into();
    let reach = ("braking_distance".to_string(), Expression::Constant(Value::Number(25.0)));
    other.vehicles[0].controller.settings.push(reach);
    suite.scenarios.push(other);
    suite.evaluates[0].conditions[1].parameters = ParameterSet::Scenario("far".into());
    let results = run_all(&suite);
    let [default, other, given] = results.evaluate("final").unwrap().conditions.as_slice() else {
        panic!("three conditions")
    };
    let fingerprints = |condition: &ConditionResult| {
        condition.runs.iter().map(|run| run.outcome.fingerprint).collect::<Vec<_>>()
    };
    assert_eq!(fingerprints(other), fingerprints(given));
    assert_ne!(fingerprints(other), fingerprints(default));
    assert!(other.runs.iter().all(|run| run.case.scenario == "far"));
    assert_eq!(other.parameters[0].value, Some(Value::Number(25.0)));
}

#[test]
fn a_tune_that_chose_nothing_leaves_its_condition_empty() {
    let mut suite = evaluated_suite();
    suite.tunes[0].constraints = vec![condition("min_distance", Relation::Greater, 1e6)];
    suite.statements = vec![statement(
        vec![compares(measured(Aggregate::Mean(metric("pet")), of("tuned")), Relation::Greater, 0.0)],
        Standing::Reproduced,
    )];
    let results = run_all(&suite);
    let tuned = &results.evaluate("final").unwrap().conditions[1];
    assert_eq!(tuned.missing.as_deref(), Some("tune `braking` chose nothing"));
    assert!(tuned.runs.is_empty() && tuned.measured == [None; 3] && tuned.differences == [None; 3]);
    assert!(results.blocks["braking"].failure().is_some());
    let failure = results.blocks["gaps_rise"].failure();
    assert_eq!(failure.as_deref(), Some("is not comparable: tune `braking` chose nothing"));
}

fn of(condition: &str) -> OutcomesOf {
    OutcomesOf::Condition { evaluate: "final".into(), condition: condition.into() }
}

fn measured(aggregate: Aggregate, of: OutcomesOf) -> Quantity {
    Quantity::Measured(Measured { aggregate, of, when: Vec::new() })
}

fn compares(left: Quantity, relation: Relation, right: f64) -> StatementClaimKind {
    StatementClaimKind::Compares { left, relation, right: Quantity::Number(right) }
}

fn statement(claims: Vec<StatementClaimKind>, standing: Standing) -> Statement {
    let claim = |kind| StatementClaim { kind, text: "a claim".into(), origin: Origin::default() };
    Statement {
        name: "gaps_rise".into(),
        doc: None,
        source: None,
        reported: None,
        claims: claims.into_iter().map(claim).collect(),
        standing,
        origin: Origin::default(),
    }
}

/// What one statement comes to over the results of its suite.
fn conclude(claims: Vec<StatementClaimKind>, standing: Standing) -> StatementResult {
    let mut suite = evaluated_suite();
    suite.statements = vec![statement(claims, standing)];
    let mut results = run_all(&suite);
    match results.blocks.remove("gaps_rise") {
        Some(BlockResult::Statement(result)) => result,
        other => panic!("not a statement: {other:?}"),
    }
}

#[test]
fn claims_hold_or_not_by_the_numbers() {
    let when =
        |relation, bound: f64| VariationCondition { variable: "tta".into(), relation, bound: bound.into() };
    let people = || OutcomesOf::Scenario("encounter".into());
    let pet = || Aggregate::Mean(metric("pet"));
    let late = Measured { aggregate: pet(), of: people(), when: vec![when(Relation::GreaterOrEqual, 9.0)] };
    let early = Measured { aggregate: pet(), of: people(), when: vec![when(Relation::Less, 9.0)] };
    let lows = Aggregate::Count(condition("pet", Relation::GreaterOrEqual, 0.0));
    let nobody = Measured {
        aggregate: lows.clone(),
        of: OutcomesOf::Search("low_pet".into()),
        when: vec![when(Relation::Greater, 18.0)],
    };
    let trend = |direction, aggregate| StatementClaimKind::Trend {
        measured: Measured { aggregate, of: people(), when: Vec::new() },
        direction,
        variable: "tta".into(),
    };
    let ratio = Quantity::Binary {
        operator: scenario::BinaryOperator::Divide,
        left: Box::new(Quantity::Measured(late.clone())),
        right: Box::new(Quantity::Measured(late.clone())),
    };
    let chosen = Quantity::Chosen { tune: "braking".into(), target: braking_distance() };
    let result = conclude(
        vec![
            StatementClaimKind::Compares {
                left: Quantity::Measured(late),
                relation: Relation::Greater,
                right: Quantity::Measured(early),
            },
            trend(TrendDirection::Rises, pet()),
            trend(TrendDirection::Falls, pet()),
            compares(measured(lows, OutcomesOf::Search("low_pet".into())), Relation::Equal, 3.0),
            compares(Quantity::Measured(nobody), Relation::Equal, 0.0),
            compares(ratio, Relation::Equal, 1.0),
            compares(chosen, Relation::GreaterOrEqual, 4.0),
        ],
        Standing::Reproduced,
    );
    let holds: Vec<_> = result.claims.iter().map(|claim| claim.holds).collect();
    let rising = holds[1] == Some(true);
    assert_eq!(holds[0], Some(rising), "two values of tta: the trend is the comparison");
    assert_eq!(holds[2], Some(!rising));
    assert_eq!(holds[3..], [Some(true); 4]);
    let units: Vec<_> = result.claims.iter().map(|claim| claim.unit.as_str()).collect();
    assert_eq!(units, ["s", "s", "s", "", "", "", "m"]);
    assert_eq!(result.conclusion, Conclusion::NotReproduced, "one of the trends must be wrong");
    assert_eq!(result.surprise().as_deref(), Some("is not reproduced"));
}

#[test]
fn the_outcome_must_agree_with_the_declared_standing() {
    let all = || measured(Aggregate::Count(condition("pet", Relation::GreaterOrEqual, 0.0)), of("default"));
    let true_claim = || vec![compares(all(), Relation::Equal, 3.0)];
    let false_claim = || vec![compares(all(), Relation::Equal, 2.0)];
    let undefined = || {
        vec![compares(measured(Aggregate::Mean(metric("impact_speed")), of("default")), Relation::Less, 1.0)]
    };
    let differs = || Standing::Differs("a reason".into());
    assert_eq!(conclude(true_claim(), Standing::Reproduced).surprise(), None);
    assert_eq!(conclude(false_claim(), differs()).surprise(), None);
    let revise = conclude(true_claim(), differs()).surprise().unwrap();
    assert!(revise.contains("is reproduced, though declared to differ (a reason)"), "{revise}");
    let unknown = conclude(undefined(), Standing::Reproduced);
    let reason = "`impact_speed` exists in too few of the 3 runs of `final.default`";
    assert_eq!(unknown.conclusion, Conclusion::NotComparable(reason.into()));
    assert!(unknown.surprise().is_some());
    // What is known to be false stays so, whatever else cannot be said.
    let both = conclude([false_claim(), undefined()].concat(), differs());
    assert_eq!((both.conclusion.clone(), both.surprise()), (Conclusion::NotReproduced, None));
    let incomparable = Standing::NotComparable("no such thing here".into());
    assert_eq!(conclude(Vec::new(), incomparable).surprise(), None);
}

#[test]
fn courses_follow_those_who_were_kept() {
    let suite = suite();
    let (found, _) = run(&suite, None);
    for one in &found.found {
        let [course] = one.courses.as_slice() else { panic!("one dimension") };
        assert_eq!((course.over.as_str(), course.points.len()), ("tta", 25));
        assert!(
            course.points.iter().all(|point| point.smallest <= point.mean && point.mean <= point.largest)
        );
        assert!(course.points.windows(2).all(|pair| pair[0].at < pair[1].at));
    }
}

#[test]
fn tuned_parameters_round_trip_as_a_condition() {
    let mut suite = evaluated_suite();
    let results = run_all(&suite);
    let tuned = results.tune("braking").unwrap();
    let saved = ParameterFile::of(&suite, &suite.tunes[0], tuned).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("braking.json");
    std::fs::write(&path, saved.write()).unwrap();
    assert_eq!(ParameterFile::read(&path).unwrap(), saved);
    let runs = |results: &Results| {
        let runs = &results.evaluate("final").unwrap().conditions[1].runs;
        runs.iter().map(|run| run.outcome.fingerprint).collect::<Vec<_>>()
    };
    let before = runs(&results);
    suite.evaluates[0].conditions[1].parameters = ParameterSet::Saved(path.to_string_lossy().into_owned());
    assert_eq!(runs(&run_all(&suite)), before);
    suite.evaluates[0].conditions[1].parameters = ParameterSet::Saved("nowhere.json".into());
    let laboratory = Laboratory::new(&suite, None);
    let missing = run_evaluate(&laboratory, &suite.evaluates[0], &results, &Silent).unwrap_err();
    assert!(missing.to_string().starts_with("cannot read the parameters of nowhere.json"), "{missing}");
}
