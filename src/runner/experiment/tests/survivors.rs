//! Runs that come to nothing: none of them makes a candidate, a condition or a worst case look better.

use std::time::Duration;

use super::*;
use report::{render_evaluate, render_search, render_tune};
use results::{ByMetric, CutOff, Outcome};
use sim::measure::Open;
use sim::{Ending, StopReason};

/// One outcome a value; a pair is what a run was cut off between.
enum Came {
    To(f64),
    Nothing,
    Between(f64, f64),
}

use Came::{Between, Nothing, To};

fn outcomes(context: &Context, came: &[Came]) -> Vec<Outcome> {
    let count = context.requests().iter().count();
    let outcome = |came: &Came| {
        let (value, open) = match came {
            To(value) => (Some(*value), None),
            Nothing => (None, None),
            Between(low, high) => (None, Some(Open { low: *low, high: *high })),
        };
        Outcome {
            key: "a/b/rep=1".into(),
            seed: 1,
            individuals: Vec::new(),
            drawn: Vec::new(),
            ending: Ending { reason: StopReason::Horizon, time: 60.0 },
            metrics: vec![value; count],
            critical: ByMetric::default(),
            presences: Vec::new(),
            waiting_steps: Vec::new(),
            left_road: Vec::new(),
            outlasted: Vec::new(),
            cut_off: Some(Box::new(CutOff { open: (0..count).map(|_| open).collect(), ..CutOff::default() })),
            fingerprint: 0,
            wall_time: Duration::ZERO,
        }
    };
    came.iter().map(outcome).collect()
}

const FOREVER: f64 = f64::INFINITY;

#[test]
fn an_objective_counts_runs_without_a_value_against_its_goal() {
    let suite = suite();
    let context = Context::new(&suite, threads(), &standard());
    let of = |goal, aggregate: Aggregate, came: &[Came]| {
        context.objective(&aggregate, goal, &outcomes(&context, came))
    };
    let least = |name, came: &[Came]| of(Goal::Minimise, Aggregate::Mean(metric(name)), came);
    let most = |name, came: &[Came]| of(Goal::Maximise, Aggregate::Mean(metric(name)), came);
    assert_eq!(least("time_lost", &[To(2.0), To(4.0)]), (Some(3.0), Some(1.0)));
    // One that waits for ever, and one that never gets there, is no small loss of time.
    assert_eq!(least("time_lost", &[To(2.0), To(4.0), Between(10.0, FOREVER)]), (None, None));
    assert_eq!(least("time_lost", &[To(2.0), To(4.0), Nothing]), (None, None));
    assert_eq!(least("time_lost", &[To(2.0), To(4.0), Between(5.0, 6.0)]).0, Some(4.0));
    // The same the other way: at least what it was so far, and not more than that.
    assert_eq!(most("time_lost", &[To(2.0), To(4.0), Between(9.0, FOREVER)]).0, Some(5.0));
    assert_eq!(most("pet", &[To(2.0), To(4.0), Between(0.0, FOREVER)]).0, Some(2.0));
    // Where neither is sure there is nothing to count.
    assert_eq!(least("pet", &[To(2.0), To(4.0), Nothing]).0, Some(3.0));
    // Ranks take it exactly.
    let median = |came: &[Came]| of(Goal::Minimise, Aggregate::Median(metric("time_lost")), came).0;
    assert_eq!(median(&[To(2.0), To(4.0), Nothing]), Some(4.0));
    assert_eq!(median(&[To(2.0), Nothing, Nothing]), None);
    let late = || Aggregate::Rate(condition("pet", Relation::Less, 1.5));
    let rate = |goal| of(goal, late(), &[To(1.0), To(2.0), Between(0.0, FOREVER), To(3.0)]).0;
    assert_eq!((rate(Goal::Minimise), rate(Goal::Maximise)), (Some(0.5), Some(0.25)));
}

#[test]
fn a_constraint_holds_only_however_a_run_would_have_gone_on() {
    let suite = suite();
    let context = Context::new(&suite, threads(), &standard());
    let margin = |name, relation, bound, came: &[Came]| {
        context.margin(&condition(name, relation, bound), &outcomes(&context, came)).value
    };
    let lost = |bound, came: &[Came]| margin("time_lost", Relation::LessOrEqual, bound, came);
    assert_eq!(lost(5.0, &[To(2.0), To(4.0)]), Some(1.0));
    // Too long already; not known; known to be short enough.
    assert_eq!(lost(5.0, &[To(2.0), Between(10.0, FOREVER)]), Some(-5.0));
    assert_eq!(lost(20.0, &[To(2.0), Between(10.0, FOREVER)]), None);
    assert_eq!(lost(20.0, &[To(2.0), Between(10.0, 12.0)]), Some(8.0));
    assert_eq!(margin("pet", Relation::GreaterOrEqual, 1.5, &[To(2.0), Between(3.0, FOREVER)]), Some(0.5));
    assert_eq!(margin("pet", Relation::GreaterOrEqual, 1.5, &[To(2.0), Between(1.0, FOREVER)]), Some(-0.5));
    assert_eq!(lost(5.0, &[To(2.0), Nothing]), None);
}

/// The evaluated suite with too little time for the car to get to its finish line in every run.
fn hasty() -> Suite {
    let mut suite = evaluated_suite();
    suite.scenarios[0].horizon = 14.0;
    suite.scenarios[0].finish = 100.0;
    suite.evaluates[0].conditions.retain(|one| !matches!(one.parameters, ParameterSet::Tuned(_)));
    suite.evaluates[0].measures[0] = aggregate(Aggregate::Mean(metric("time_lost")), "mean(time_lost)");
    suite.evaluates[0].reported.clear();
    suite.searches[0].objective = Objective {
        direction: Goal::Minimise,
        aggregate: Aggregate::Mean(metric("time_lost")),
        text: "minimise mean(time_lost)".into(),
        notation: None,
    };
    suite.searches[0].keep = Vec::new();
    suite
}

#[test]
fn reports_say_how_many_runs_have_no_value() {
    let suite = hasty();
    let context = Context::new(&suite, threads(), &standard());
    let search = run_search(&context, &suite.searches[0], &Silent).unwrap();
    let evaluations: usize = search.found.iter().map(|one| one.evaluations.len()).sum();
    assert!(search.found.iter().all(|one| one.evaluations.iter().all(|(_, value)| value.is_none())));
    let text = render_search(&search);
    assert!(text.contains(&format!("{evaluations} of {evaluations} evaluations have no value")), "{text}");

    let mut suite = hasty();
    suite.evaluates[0].on = CaseSet::Scenario("encounter".into());
    suite.evaluates[0]
        .measures
        .push(aggregate(Aggregate::Mean(metric("min_distance")), "mean(min_distance)"));
    suite.tunes[0].on = CaseSet::Scenario("encounter".into());
    let context = Context::new(&suite, threads(), &standard());
    let result = run_evaluate(&context, &suite.evaluates[0], &EarlierResults::default(), &Silent).unwrap();
    let default = &result.conditions[0];
    let runs = default.runs.len();
    assert_eq!((default.measured[0], default.undecided[0]), (None, runs));
    assert!(default.measured[3].is_some() && default.undecided[3] == 0);
    assert_eq!(result.conditions[1].differences[0], None);
    let text = render_evaluate(&result);
    let said = format!("mean(time_lost) of default: no value in {runs} of {runs} runs");
    assert!(text.contains(&said), "{text}");

    let tuned = run_tune(&context, &suite.tunes[0], &EarlierResults::default(), &Silent).unwrap();
    assert!(tuned.evaluations.iter().all(|one| one.objectives == [None]));
    assert!(tuned.evaluations.iter().all(|one| !one.feasible) && tuned.chosen.is_none());
    let text = render_tune(&tuned);
    assert!(text.contains("no candidate has a value") && text.contains("nothing is chosen"), "{text}");
}
