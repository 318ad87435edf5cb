//! Evaluations of what was searched and tuned.

use super::*;
use results::ConditionResult;

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
    let table = report::render_evaluate(result);
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
fn tuned_parameters_round_trip_as_a_condition() {
    let mut suite = evaluated_suite();
    let results = run_all(&suite);
    let tuned = results.tune("braking").unwrap();
    let saved = ParameterFile::of(&suite, &suite.tunes[0], tuned).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("braking.json");
    std::fs::write(&path, saved.write()).unwrap();
    assert_eq!(ParameterFile::read(&path, &files::Disk).unwrap(), saved);
    let runs = |results: &EarlierResults| {
        let runs = &results.evaluate("final").unwrap().conditions[1].runs;
        runs.iter().map(|run| run.outcome.fingerprint).collect::<Vec<_>>()
    };
    let before = runs(&results);
    suite.evaluates[0].conditions[1].parameters = ParameterSet::Saved(path.to_string_lossy().into_owned());
    assert_eq!(runs(&run_all(&suite)), before);
    suite.evaluates[0].conditions[1].parameters = ParameterSet::Saved("nowhere.json".into());
    let context = Context::new(&suite, threads(), &standard());
    let missing = run_evaluate(&context, &suite.evaluates[0], &results, &Silent).unwrap_err();
    assert!(missing.to_string().starts_with("cannot read the parameters of nowhere.json"), "{missing}");
}
