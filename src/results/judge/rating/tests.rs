//! What would make a rating green that is not.

use std::time::Duration;

use super::*;
use crate::judge::judge;
use crate::{Cut, CutBy, CutOff, PairPresence, Standing, Stopping, Unfinished, UnitError};
use scenario::{
    Assignment, Expression, Origin, PointsCriterion, Relation, Scoring, TagPoints, Weight, WeightedValues,
};
use sim::Ending;
use sim::measure::{Closeness, Open, Presence};

const KM_H: f64 = 1.0 / 3.6;

/// As Euro NCAP weighs 20, 30 and 40 km/h; one point for `standard`, a quarter for `extended`.
fn rating() -> Arc<Rating> {
    let when = |relation, pace: f64| VariationCondition {
        variable: "pace".into(),
        relation,
        bound: Expression::number(pace * KM_H),
    };
    let weights = |when: VariationCondition, bands: &[(f64, f64)]| {
        let bands = bands
            .iter()
            .map(|(below, weight)| Weight { of: WeightedValues::Below(below * KM_H), weight: *weight });
        let none = Weight { of: WeightedValues::Exactly(0.0), weight: 1.0 };
        Weights {
            when: vec![when],
            lines: std::iter::once(none).chain(bands).collect(),
            text: String::new(),
            origin: Origin::default(),
        }
    };
    let points = |tag: &str, maximum, by| TagPoints { tag: tag.into(), maximum, by };
    Arc::new(Rating {
        name: "protocol".into(),
        doc: None,
        measure: models::known::measured("impact_speed"),
        notation: None,
        weights: vec![
            weights(when(Relation::LessOrEqual, 20.0), &[]),
            weights(when(Relation::Equal, 30.0), &[(10.0, 0.25)]),
            weights(when(Relation::Equal, 40.0), &[(10.0, 0.5), (20.0, 0.25)]),
        ],
        points: vec![
            points("standard", 1.0, Scoring::MeanWeight),
            points("extended", 0.25, Scoring::Share { steps: vec![0.5, 1.0] }),
        ],
        not_assessed: Vec::new(),
        criteria: vec![PointsCriterion {
            tag: None,
            relation: Relation::GreaterOrEqual,
            bound: 1.0,
            text: "points >= 1".into(),
            origin: Origin::default(),
        }],
        origin: Origin::default(),
    })
}

fn requests() -> Requests {
    let mut requests = Requests::default();
    requests.add(&models::known::measured("impact_speed"));
    requests
}

/// A run that ended with everybody across and this speed of impact, km/h.
fn outcome(speed: Option<f64>) -> Outcome {
    Outcome {
        key: "s/a/rep=1".into(),
        seed: 1,
        individuals: Vec::new(),
        drawn: Vec::new(),
        ending: Ending { reason: StopReason::Completed, time: 20.0 },
        metrics: vec![speed.map(|speed| speed * KM_H)],
        critical: Default::default(),
        presences: vec![PairPresence {
            vehicle: "av".into(),
            other: "dummy".into(),
            of_vehicles: false,
            presence: Presence { closest: Closeness::Met, moved: true, passed: false },
        }],
        waiting_steps: Vec::new(),
        left_road: Vec::new(),
        outlasted: Vec::new(),
        cut_off: Default::default(),
        fingerprint: 0,
        wall_time: Duration::ZERO,
    }
}

fn trial(tag: &str, pace: f64, outcomes: Vec<Outcome>) -> TrialReport {
    let trial = Trial {
        key: format!("s/{tag}/pace={pace}km/h"),
        scenario: tag.into(),
        doc: None,
        tags: vec![tag.into(), "nightly".into()],
        variation: vec![Assignment {
            name: "pace".into(),
            value: Value::Number(pace * KM_H),
            label: format!("{pace}km/h"),
        }],
        runs: outcomes.len(),
        first_run: "s/a/rep=1".into(),
        rounds: None,
        criteria: [].into(),
        declared: 0,
        origin: Origin::default(),
    };
    let verdict = judge(&[], &[], &Requests::default());
    TrialReport {
        trial: Arc::new(trial),
        outcomes,
        state: TrialState::Judged(verdict),
        departures: Vec::new(),
        wall_time: Duration::ZERO,
    }
}

/// Three standard cells and two extended ones in which nobody is hit.
fn avoided() -> Vec<TrialReport> {
    let standard = [20.0, 30.0, 40.0].map(|pace| trial("standard", pace, vec![outcome(None)]));
    let extended = [30.0, 40.0].map(|pace| trial("extended", pace, vec![outcome(None)]));
    standard.into_iter().chain(extended).collect()
}

fn judged(trials: &[TrialReport]) -> RatingReport {
    judge_rating(&rating(), "s", trials, &[], &requests())
}

fn result(report: &RatingReport) -> &RatingResult {
    match &report.state {
        RatingState::Rated(result) => result,
        RatingState::NotJudged(why) => panic!("it is not judged: {why}"),
    }
}

/// Of a session in which one cell is so.
fn with(place: usize, change: impl FnOnce(&mut TrialReport)) -> RatingReport {
    let mut trials = avoided();
    change(&mut trials[place]);
    judged(&trials)
}

/// Points are undefined, what was expected of them inconclusive, and the reason is told.
fn assert_not_assessed(report: &RatingReport, why: &str) {
    let result = result(report);
    let (_, said) =
        result.not_assessed().next().unwrap_or_else(|| panic!("every cell is assessed, not: {why}"));
    assert!(said.contains(why), "{said}");
    assert_eq!(result.points, None, "{why}");
    assert_eq!(report.standing(), Standing::Judged(Verdict::Inconclusive));
}

#[test]
fn who_hits_nobody_earns_everything() {
    let report = judged(&avoided());
    let result = result(&report);
    assert_eq!((result.points, result.maximum), (Some(1.25), 1.25));
    assert_eq!(report.standing(), Standing::Judged(Verdict::Passed));
    assert!(result.cells.iter().all(|cell| cell.worth.weight() == Some(1.0)));
}

#[test]
fn bands_are_those_of_the_speed_and_their_edge_is_worse() {
    let weight = |place: usize, speed: f64| {
        let report = with(place, |trial| trial.outcomes = vec![outcome(Some(speed))]);
        result(&report).cells[place].worth.weight().unwrap()
    };
    // At 20, 30 and 40 km/h.
    assert_eq!([0.0, 0.001, 5.0].map(|speed| weight(0, speed)), [1.0, 0.0, 0.0]);
    assert_eq!([0.0, 9.999, 10.0, 15.0].map(|speed| weight(1, speed)), [1.0, 0.25, 0.0, 0.0]);
    assert_eq!([0.0, 9.999, 10.0, 19.999, 20.0].map(|speed| weight(2, speed)), [1.0, 0.5, 0.25, 0.25, 0.0]);
}

#[test]
fn shares_are_lowered_and_means_are_not() {
    let mut trials = avoided();
    trials[1].outcomes = vec![outcome(Some(5.0))];
    trials[3].outcomes = vec![outcome(Some(25.0))];
    let report = judged(&trials);
    let tags = &result(&report).tags;
    assert_eq!(tags[0].points, Some(2.25 / 3.0));
    assert_eq!(tags[1].points, Some(0.125));
    assert_eq!(report.standing(), Standing::Judged(Verdict::Failed));
}

#[test]
fn a_cell_that_came_to_nothing_leaves_the_points_undefined() {
    let report = with(4, |trial| {
        trial.outcomes.clear();
        trial.state = TrialState::Errored(UnitError::from("av: controller exited".to_string()));
    });
    assert_not_assessed(&report, "controller exited");
    let result = result(&report);
    assert_eq!((result.tags[0].points, result.tags[1].points), (Some(1.0), None));
    assert_eq!((result.tags[1].cells, result.tags[1].not_assessed), (2, 1));

    let cut = Cut::TimeLimit { limit: Duration::from_secs(1), finished: 1, runs: 2 };
    assert_eq!(cut.by(), CutBy::TimeLimit);
    // Also with runs of which a part was done.
    let report = with(0, |trial| trial.state = TrialState::NotFinished(cut));
    assert_not_assessed(&report, "time limit of 1 s exceeded");
    let report = with(0, |trial| trial.outcomes.clear());
    assert_not_assessed(&report, "no run was made");
}

#[test]
fn cells_that_were_left_out_leave_it_unjudged() {
    let skip = |trial: &mut TrialReport, why: Skip| {
        trial.outcomes.clear();
        trial.state = TrialState::Skipped(why);
    };
    for why in [Skip::NotSelected, Skip::Stopped(Stopping::Interrupted), Skip::Stopped(Stopping::MaxFail(1))]
    {
        let report = with(2, |trial| skip(trial, why));
        assert_eq!(report.state, RatingState::NotJudged(NotRated::Part { left_out: 1, cells: 5 }));
        assert!(report.is_open(), "it may be that it would have failed");
        assert_eq!((report.verdict(), report.standing()), (None, Standing::Skipped));
    }
    let mut trials = avoided();
    trials.iter_mut().for_each(|trial| skip(trial, Skip::NotSelected));
    assert_eq!(judged(&trials).state, RatingState::NotJudged(NotRated::NotSelected));
    assert!(!judged(&trials).is_open());
    // Other trials of the suite do not stand for its cells.
    trials.push(trial("other", 50.0, vec![outcome(None)]));
    assert_eq!(judged(&trials).state, RatingState::NotJudged(NotRated::Part { left_out: 5, cells: 5 }));
    assert!(judged(&trials).is_open());
}

#[test]
fn a_run_without_contact_in_which_nothing_could_happen_is_not_green() {
    let run = |change: fn(&mut Outcome)| with(1, |trial| change(&mut trial.outcomes[0]));
    let report = run(|outcome| outcome.presences[0].presence.closest = Closeness::Absent);
    assert_not_assessed(&report, "nobody appeared");
    let report = run(|outcome| outcome.presences[0].presence.closest = Closeness::Abreast);
    assert_not_assessed(&report, "no pedestrian came into the way of a vehicle");
    let report = run(|outcome| outcome.presences[0].presence.closest = Closeness::InTheWay);
    assert_not_assessed(&report, "nothing was at stake");
    let report = run(|outcome| outcome.ending.reason = StopReason::Collision);
    assert_not_assessed(&report, "a contact ended");
    let report = run(|outcome| {
        outcome.ending = Ending { reason: StopReason::Horizon, time: 60.0 };
        let unfinished = vec![Unfinished { vehicle: "av".into(), pedestrian: "dummy".into() }];
        outcome.cut_off = Some(Box::new(CutOff { unfinished, ..CutOff::default() }));
    });
    assert_not_assessed(&report, "cut off at 60 s, before `av` and `dummy` were past each other");
    let report = run(|outcome| {
        let open = [Some(Open { low: 0.0, high: f64::INFINITY })].into_iter().collect();
        outcome.cut_off = Some(Box::new(CutOff { open, ..CutOff::default() }));
    });
    assert_not_assessed(&report, "before `impact_speed` was decided");
    // One that the horizon ended when they were past each other was decided.
    let report = run(|outcome| outcome.ending = Ending { reason: StopReason::Horizon, time: 60.0 });
    assert_eq!(result(&report).points, Some(1.25));
}

#[test]
fn a_missing_value_counts_as_none_only_where_that_is_the_best_there_is() {
    let of = |measure: &str, undefined: bool| {
        let mut rating = (*rating()).clone();
        rating.measure = models::known::measured(measure);
        if undefined {
            let line = Weight { of: WeightedValues::Undefined, weight: 0.5 };
            rating.weights.iter_mut().for_each(|weights| weights.lines.insert(0, line));
        }
        let mut requests = Requests::default();
        requests.add(&rating.measure);
        judge_rating(&Arc::new(rating), "s", &avoided(), &[], &requests)
    };
    assert_eq!(result(&of("impact_speed", false)).points, Some(1.25));
    // The line says it otherwise.
    assert_eq!(result(&of("impact_speed", true)).tags[0].points, Some(0.5));
    // Of a time to collision 0 would be the worst; nobody who never arrives has lost no time.
    assert_not_assessed(&of("min_ttc", false), "`min_ttc` does not exist");
    assert_not_assessed(&of("time_lost", false), "`time_lost` does not exist");
    assert_eq!(result(&of("min_ttc", true)).tags[0].points, Some(0.5));
    // What was not measured is not worth anything.
    let report = judge_rating(&rating(), "s", &avoided(), &[], &Requests::default());
    assert_not_assessed(&report, "was not measured");
}

#[test]
fn the_worst_run_of_a_cell_counts() {
    let runs = [None, Some(8.0), Some(4.0), None].map(outcome);
    let report = with(2, |trial| trial.outcomes = runs.to_vec());
    let CellWorth::Weighed { weight, value, absent, runs, .. } = &result(&report).cells[2].worth else {
        panic!("it was assessed")
    };
    assert_eq!((*weight, *value, *absent, *runs), (0.5, Some(8.0 * KM_H), false, 4));
    // One run of which nothing is known could have been the worst.
    let mut unknown = outcome(None);
    unknown.presences[0].presence.closest = Closeness::Absent;
    let report = with(2, |trial| trial.outcomes = vec![outcome(Some(50.0)), unknown]);
    assert_not_assessed(&report, "nobody appeared");
}

#[test]
fn a_cell_that_no_weights_are_about_is_not_assessed() {
    let report = with(0, |trial| {
        let trial = Arc::make_mut(&mut trial.trial);
        trial.variation[0].value = Value::Number(35.0 * KM_H);
    });
    assert_not_assessed(&report, "no weights are about this cell");
    let report = with(0, |trial| Arc::make_mut(&mut trial.trial).variation.clear());
    assert_not_assessed(&report, "no weights are about this cell");
}

#[test]
fn values_from_outside_make_other_cells_unless_they_are_of_what_is_tested() {
    let judged = |set: &[&str]| {
        let set: Vec<String> = set.iter().map(ToString::to_string).collect();
        judge_rating(&rating(), "s", &avoided(), &set, &requests())
    };
    for own in [
        "controller av=mine",
        "use mine.scn",
        "av.controller.gap=5 m",
        "av.sees.range=40m",
        "av.dynamics.delay=0.1s",
        "repeat=3",
    ] {
        assert_eq!(judged(&[own]).verdict(), Some(Verdict::Passed), "{own}");
    }
    for other in
        ["pace=20km/h", "av.speed=20km/h", "dummy.model.speed=1m/s", "step=1ms", "horizon=1s", "repeats=3"]
    {
        let report = judged(&["av.controller.gap=5 m", other]);
        assert_eq!(report.state, RatingState::NotJudged(NotRated::OtherCells(vec![other.to_string()])));
        assert!(report.is_open());
    }
}

#[test]
fn points_that_are_equal_but_for_rounding_are_equal() {
    let mut rating = (*rating()).clone();
    let tags = ["standard", "extended"];
    rating.points =
        tags.map(|tag| TagPoints { tag: tag.into(), maximum: 0.1, by: Scoring::MeanWeight }).to_vec();
    rating.points[1].maximum = 0.2;
    rating.criteria[0].bound = 0.3;
    assert_ne!(0.1 + 0.2, 0.3);
    let report = judge_rating(&Arc::new(rating.clone()), "s", &avoided(), &[], &requests());
    assert_eq!(report.verdict(), Some(Verdict::Passed));
    rating.criteria[0].relation = Relation::Greater;
    let report = judge_rating(&Arc::new(rating.clone()), "s", &avoided(), &[], &requests());
    assert_eq!(report.verdict(), Some(Verdict::Failed));
    rating.criteria.clear();
    let report = judge_rating(&Arc::new(rating), "s", &avoided(), &[], &requests());
    assert_eq!((report.verdict(), report.standing(), report.is_open()), (None, Standing::NotJudged, false));
}
