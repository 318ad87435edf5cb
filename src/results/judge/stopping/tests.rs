//! When trials have enough runs, over made-up outcomes.

use std::time::Duration;

use super::*;
use numbers::random::Stream;
use scenario::{Expression, MetricReference, Origin, Reach, Rounds};
use sim::{Ending, StopReason};

const ROUNDS: Rounds = Rounds { size: 4, least: 20, most: 400 };

fn pet() -> MetricReference {
    models::known::measured("pet")
}

fn requests() -> Requests {
    let mut requests = Requests::default();
    requests.add(&pet());
    requests
}

fn criterion(claim: Claim) -> Criterion {
    Criterion {
        claim,
        when: Vec::new(),
        text: "pet".into(),
        reach: Reach::default(),
        origin: Origin::default(),
    }
}

/// `pet >= bound in … of runs with 95 % confidence`
fn share(bound: f64, share: f64) -> Criterion {
    criterion(Claim::Runs { comparison: at_least(bound), share: Some(share), confidence: Some(0.95) })
}

/// `pet >= 1 s` in every run
fn every_run() -> Criterion {
    criterion(Claim::Runs { comparison: at_least(1.0), share: None, confidence: None })
}

fn at_least(bound: f64) -> Comparison {
    Comparison {
        metric: pet(),
        relation: Relation::GreaterOrEqual,
        bound: Expression::number(bound),
        when_undefined: WhenUndefined::Fails,
    }
}

/// `quantile(level, pet) … bound with 95 % confidence`
fn quantile(level: f64, relation: Relation, bound: f64) -> Criterion {
    criterion(Claim::Aggregate {
        aggregate: Aggregate::Quantile(level, pet()),
        relation,
        bound: Expression::number(bound),
        when_undefined: WhenUndefined::Fails,
        confidence: Some(0.95),
    })
}

fn trial(criteria: Vec<Criterion>, rounds: Option<Rounds>) -> Trial {
    Trial {
        variation: Vec::new(),
        runs: 1,
        first_run: "a/b/rep=1".into(),
        key: "a/b".into(),
        scenario: "b".into(),
        doc: None,
        tags: Vec::new(),
        rounds,
        declared: criteria.len(),
        criteria: criteria.into(),
        origin: Origin::default(),
    }
}

fn outcomes(values: impl IntoIterator<Item = Option<f64>>) -> Vec<Outcome> {
    let outcome = |value| Outcome {
        key: "a/b/rep=1".into(),
        seed: 1,
        individuals: Vec::new(),
        drawn: Vec::new(),
        ending: Ending { reason: StopReason::Completed, time: 10.0 },
        metrics: vec![value],
        critical: Default::default(),
        presences: Vec::new(),
        waiting_steps: Vec::new(),
        left_road: Vec::new(),
        outlasted: Vec::new(),
        cut_off: Default::default(),
        fingerprint: 0,
        wall_time: Duration::ZERO,
    };
    values.into_iter().map(outcome).collect()
}

/// Given `ahead` outcomes at a time.
fn watched(criteria: Vec<Criterion>, rounds: Rounds, outcomes: &[Outcome], ahead: usize) -> TrialVerdict {
    let (trial, requests) = (trial(criteria, Some(rounds)), requests());
    let mut watch = Watch::new(&Arc::new(trial.clone()), &requests);
    let mut given = 0;
    let enough = loop {
        given = (given + ahead).min(outcomes.len());
        match watch.enough(&outcomes[..given]) {
            Some(enough) => break enough,
            None if given == outcomes.len() => break given,
            None => {}
        }
    };
    watch.verdict(&outcomes[..enough])
}

#[test]
fn a_clear_case_takes_as_few_runs_as_can_show_it_however_many_ran_ahead() {
    let all = outcomes((0..400).map(|_| Some(2.0)));
    let verdicts: Vec<_> =
        [1, 7, 64, 400].map(|ahead| watched(vec![share(1.0, 0.9)], ROUNDS, &all, ahead)).into();
    // 43 runs that all hold show 90 %; 44 make whole rounds.
    assert_eq!(verdicts[0].verdict, Verdict::Passed);
    let stopping = RunsTaken { least: 20, most: 400, runs: 44, reason: Reason::Decided };
    assert_eq!(verdicts[0].stopping, Some(stopping));
    assert_eq!((verdicts[0].findings[0].runs, verdicts[0].findings[0].holding), (44, 44));
    assert!(verdicts.iter().all(|verdict| *verdict == verdicts[0]));
    let none = outcomes((0..400).map(|_| Some(0.5)));
    let failed = watched(vec![share(1.0, 0.9)], ROUNDS, &none, 10);
    // Nobody looks earlier.
    assert_eq!((failed.verdict, failed.stopping.map(|one| one.runs)), (Verdict::Failed, Some(20)));
}

#[test]
fn what_is_decided_stays_while_others_take_more() {
    // The first 60 runs hold, later ones do not.
    let values = (0..400).map(|run| Some(if run < 60 { 2.0 } else { 0.5 }));
    let criteria = vec![share(1.0, 0.9), share(1.0, 0.99), every_run()];
    let verdict = watched(criteria, ROUNDS, &outcomes(values), 1);
    let found: Vec<_> =
        verdict.findings.iter().map(|finding| (finding.verdict, finding.runs, finding.holding)).collect();
    let runs = verdict.stopping.unwrap().runs;
    assert!((64..80).contains(&runs), "{runs}");
    assert_eq!(found, [(Verdict::Passed, 44, 44), (Verdict::Failed, runs, 60), (Verdict::Failed, runs, 60)]);
}

#[test]
fn a_budget_that_is_spent_leaves_it_open() {
    let values = (0..40).map(|run| Some(if run % 10 == 9 { 0.5 } else { 2.0 }));
    let rounds = Rounds { most: 40, ..ROUNDS };
    let verdict = watched(vec![share(1.0, 0.9)], rounds, &outcomes(values), 8);
    assert_eq!(verdict.verdict, Verdict::Inconclusive);
    assert_eq!(verdict.stopping.map(|one| (one.runs, one.reason)), Some((40, Reason::Budget)));
    let (low, high) = verdict.findings[0].interval.unwrap();
    assert!(low < 0.9 && high > 0.9);
}

#[test]
fn nothing_to_decide_takes_the_least_and_fixed_runs_are_never_enough() {
    let all = outcomes((0..400).map(|_| Some(2.0)));
    let verdict = watched(vec![every_run()], ROUNDS, &all, 400);
    let stopping = RunsTaken { least: 20, most: 400, runs: 20, reason: Reason::NothingToDecide };
    assert_eq!(verdict.stopping, Some(stopping));
    let (trial, requests) = (trial(vec![every_run()], None), requests());
    let mut watch = Watch::new(&Arc::new(trial.clone()), &requests);
    assert_eq!(watch.enough(&all), None);
    assert_eq!(watch.verdict(&all), super::super::judge(&trial.criteria, &all, &requests));
}

#[test]
fn quantiles_are_decided_by_the_values_there_are() {
    let values = |run: usize| (!run.is_multiple_of(3)).then_some(run as f64 / 100.0);
    let all = outcomes((0..400).map(values));
    for (relation, bound, expected) in [
        (Relation::GreaterOrEqual, 0.05, Verdict::Passed),
        (Relation::Greater, 3.9, Verdict::Failed),
        (Relation::LessOrEqual, 3.9, Verdict::Passed),
        (Relation::Less, 0.05, Verdict::Failed),
    ] {
        let verdict = watched(vec![quantile(0.5, relation, bound)], ROUNDS, &all, 50);
        assert_eq!(verdict.verdict, expected, "{relation:?} {bound}");
        assert_eq!(verdict.stopping.unwrap().reason, Reason::Decided);
        assert!(verdict.findings[0].undefined > 0);
    }
}

/// The share of experiments with that verdict.
fn chance(verdict: Verdict, criterion: &Criterion, rounds: Rounds, draw: impl Fn(&mut Stream) -> f64) -> f64 {
    const EXPERIMENTS: u32 = 400;
    let mut stream = Stream::seeded(20_261_121);
    let runs = (0..EXPERIMENTS).filter(|_| {
        let outcomes = outcomes((0..rounds.most).map(|_| Some(draw(&mut stream))));
        watched(vec![criterion.clone()], rounds, &outcomes, rounds.most).verdict == verdict
    });
    runs.count() as f64 / f64::from(EXPERIMENTS)
}

// `cargo bench --bench coverage` does this over 10,000 experiments and more runs.
#[test]
fn on_the_very_border_there_is_hardly_a_verdict() {
    let rounds = Rounds { size: 1, least: 1, most: 300 };
    let exponential = |stream: &mut Stream| -libm::log(stream.uniform());
    // Exactly 90 % are at least so large.
    let border = share(-libm::log(0.9), 0.9);
    let median = quantile(0.5, Relation::GreaterOrEqual, std::f64::consts::LN_2);
    for criterion in [border, median] {
        for verdict in [Verdict::Passed, Verdict::Failed] {
            let wrong = chance(verdict, &criterion, rounds, exponential);
            // Stated are 5 %; three standard errors of the simulation are 3.3 %.
            assert!(wrong <= 0.05 + 0.033, "{verdict:?}: {wrong}");
        }
    }
    // And off the border there is one, in time.
    let clear = chance(Verdict::Passed, &share(0.005, 0.9), rounds, exponential);
    assert!(clear > 0.95, "{clear}");
}
