//! A made-up session for the tests of every format: two scenarios, three times to arrival, a few runs each.

mod gate;

use std::time::{Duration, SystemTime};

use nalgebra::Vector2;

use super::{
    BlockReport, BlockState, Chosen, RecordedReport, RecordedState, Recording, Rerun, Skip, Stopping,
    SuiteIdentity, SuiteReport, TrialReport, TrialState,
};
use crate::corpus::Recorded;
use crate::experiment::{
    Block, BlockResult, Candidate, CaseRun, ClaimResult, ClaimValues, Conclusion, ConditionResult, Course,
    CoursePoint, Difference, EvaluateResult, Found, ParameterValue, SavedCase, SavedSet, SearchResult,
    StatementResult, TrendPoint, TuneResult, Violations,
};
use crate::judge::statistics::Interval;
use crate::judge::{Reason, Stopping as Stopped, TrialVerdict, Vacuity, Verdict, judge, per_run};
use crate::metrics::{MetricKind, Presence, metric};
use crate::optimise::{self, SlicePoint};
use crate::plan::Trial;
use crate::run::{Critical, Outcome, Requests};
use crate::scenario::{
    Aggregate, Appearance, Assignment, Body, Budget, Case, CaseSet, Claim, Comparison, Criterion, Crossing,
    CrossingKind, Direction, Gate, Goal, Individual, InitialDesign, Lane, Measure, Method, MetricReference,
    ModelSetup, Objective, Origin, Part, PedestrianSetup, Position, Range, RangeValues, Relation, Road,
    Search, Settings, Shape, Side, Standing, Target, TrendDirection, Tune, Value, VehicleSetup, VehicleStart,
    WhenUndefined, World,
};
use crate::sim::{Ending, Event, Happening, Sample, StopReason, Trace};

/// The trials, and what reports borrow from.
pub struct Session {
    trials: Vec<Trial>,
    search: Search,
    tune: Tune,
    recorded: Recorded,
    gate: Gate,
    pub requests: Requests,
}

const RUNS: u32 = 6;

impl Session {
    pub fn new() -> Self {
        let mut trials = Vec::new();
        for scenario in ["commotions_carla", "walker_<carla>"] {
            for tta in [6.0, 10.0, 14.0] {
                trials.push(trial(scenario, tta));
            }
        }
        let mut requests = Requests::default();
        trials.iter().for_each(|trial: &Trial| requests.include(&trial.criteria));
        let (search, tune) = blocks();
        Self { recorded: recorded(&trials[0].cases[1]), trials, search, tune, gate: gate::gate(), requests }
    }

    /// One trial of every state: the last two are an error and a skipped one. The second was run until it
    /// was decided, and something in the third was not put to the test.
    pub fn report(&self) -> SuiteReport<'_> {
        let count = self.trials.len();
        let state = |(index, trial): (usize, &Trial)| match count - index {
            2 => (Vec::new(), TrialState::Errored(format!("{}: time limit of 10 s exceeded", trial.key))),
            1 => (Vec::new(), TrialState::Skipped(Skip::Stopped(Stopping::MaxFail(2)))),
            _ => {
                let outcomes = self.outcomes(trial);
                let mut judged = judge(&trial.criteria, &outcomes, &self.requests);
                if let Some(passed) = judged.findings.iter_mut().find(|one| one.verdict == Verdict::Passed)
                    && index == 2
                {
                    passed.vacuous = Some(Vacuity::NobodyEntered);
                }
                let runs = outcomes.len();
                let stopping = Stopped { least: 4, most: 20, runs, reason: Reason::Decided };
                let stopping = (index == 1).then_some(stopping);
                (outcomes, TrialState::Judged(TrialVerdict { stopping, ..judged }))
            }
        };
        let trials = self.trials.iter().enumerate().map(|(index, trial)| {
            let (outcomes, state) = state((index, trial));
            TrialReport { trial, outcomes, state, wall_time: Duration::from_millis(250) }
        });
        SuiteReport {
            identity: SuiteIdentity { suite: "zebra", file: "suites/zebra.suite", seed: u64::MAX },
            started: SystemTime::UNIX_EPOCH + Duration::from_secs(1_795_250_000),
            wall_time: Duration::from_millis(1500),
            recorded: self.reruns(),
            trials: trials.collect(),
            blocks: self.blocks(),
            gates: gate::reports(&self.gate),
        }
    }

    /// A run that still fails, one that does not, and one that cannot be run any more.
    fn reruns(&self) -> Vec<RecordedReport<'_>> {
        let trial = &self.trials[0];
        let outcome = self.outcomes(trial).remove(1);
        let judged = |least: f64| {
            let criteria: Vec<_> =
                trial.criteria.iter().filter_map(per_run).filter(|one| one.decisive).collect();
            let mut criteria: Vec<_> = criteria.into_iter().map(|one| one.criterion).collect();
            for criterion in &mut criteria {
                if criterion.claim.metric().name == "pet" {
                    criterion.claim.bounds_mut().into_iter().for_each(|bound| *bound = least.into());
                }
            }
            judge(&criteria, std::slice::from_ref(&outcome), &self.requests)
        };
        let ran = |least: f64, same_case| {
            let outcome = outcome.clone();
            RecordedState::Ran(Box::new(Rerun {
                judged: judged(least),
                outcome,
                same_case,
                against: Vec::new(),
            }))
        };
        let gone = Skip::Stale("there is no scenario `commotions_carla` any more".into());
        let states = [ran(1.5, true), ran(0.5, false), RecordedState::Skipped(gone)];
        let report = |(index, state): (usize, RecordedState)| RecordedReport {
            recorded: &self.recorded,
            // A run is recorded once in a real file.
            key: format!("{}{}", self.recorded.unit_key(), ["", "_2", "_3"][index]),
            state,
            wall_time: Duration::from_millis(3),
        };
        states.into_iter().enumerate().map(report).collect()
    }

    /// One block of every state: with a result, with one that fails, with an error and a skipped one.
    fn blocks(&self) -> Vec<BlockReport<'_>> {
        let (search, tune) = (Block::Search(&self.search), Block::Tune(&self.tune));
        let error = "`walker`: there is no population called `standard`".to_string();
        let reason = Skip::Needs { key: "zebra/search=low_pet_2".into(), happened: "could not be run" };
        let states = [
            (search, BlockState::Finished(Box::new(BlockResult::Search(found(&self.search))))),
            (tune, BlockState::Finished(Box::new(BlockResult::Tune(tuned(&self.tune))))),
            (search, BlockState::Errored(error)),
            (tune, BlockState::Skipped(reason)),
        ];
        let mut reports = Vec::new();
        for (index, (block, state)) in states.into_iter().enumerate() {
            // Names are unique in a real suite.
            let key = format!("{}{}", block.key("zebra"), ["", "", "_2", "_2"][index]);
            reports.push(BlockReport { block, key, state, wall_time: Duration::from_millis(750) });
        }
        reports
    }

    /// A straight course for every chosen run.
    pub fn record(&self, chosen: Vec<Chosen>) -> Vec<(Chosen, Recording<'_>)> {
        let cases = || self.trials.iter().flat_map(|trial| &trial.cases);
        let recording = |chosen: Chosen| {
            let case = cases().find(|case| case.key == chosen.key).expect("a chosen run is one of the runs");
            (chosen, course(case))
        };
        chosen.into_iter().map(recording).collect()
    }

    fn outcomes(&self, trial: &Trial) -> Vec<Outcome> {
        let outcome = |case: &Case| {
            let (run, tta) = (f64::from(case.repetition), case.variation[0].value.as_number().unwrap_or(0.0));
            let value = |reference: &MetricReference| match reference.name.as_str() {
                "collision" => Some(0.0),
                "pet" => (case.repetition != 3).then_some(tta / 8.0 + 0.25 * run),
                "passed_first" => Some(word(if run + tta > 13.0 { "pedestrian" } else { "vehicle" })),
                "gap_accepted" => Some(f64::from(u8::from(run + tta > 13.0))),
                _ => Some(10.0 / tta + 0.2 * run),
            };
            Outcome {
                key: case.key.clone(),
                seed: case.seed,
                individuals: case.individuals.clone(),
                ending: Ending { reason: StopReason::Completed, time: 20.0 },
                metrics: self.requests.iter().map(value).collect(),
                critical: self.requests.iter().map(|_| critical(run)).collect(),
                presences: vec![("walker".into(), Presence { appeared: true, entered: true })],
                fingerprint: 0x0123_4567_89ab_cdef,
                wall_time: Duration::from_millis(3),
            }
        };
        trial.cases.iter().map(outcome).collect()
    }
}

/// Half a second later in every run.
fn critical(run: f64) -> Critical {
    Critical { time: Some(7.25 + run / 2.0), vehicle: Some("av".into()), pedestrian: Some("walker".into()) }
}

/// The number that `passed_first` has for a word.
fn word(word: &str) -> f64 {
    let Some(MetricKind::Category(words)) = metric("passed_first").map(|metric| metric.kind) else {
        panic!("`passed_first` is a category");
    };
    words.iter().position(|known| *known == word).map_or(f64::NAN, |index| index as f64)
}

fn recorded(case: &Case) -> Recorded {
    Recorded {
        key: case.key.clone(),
        scenario: case.scenario.clone(),
        seed: case.seed,
        variation: case.variation.clone(),
        people: vec![("walker".into(), 2, "standard".into())],
        case: 0xfedc_ba98_7654_3210,
        fingerprint: 0x0123_4567_89ab_cdef,
        against: vec!["pet >= 1.5 s: pet 0.83 s".into()],
    }
}

/// A search over the arrival time and a tune on what it found.
fn blocks() -> (Search, Tune) {
    let metric =
        |name: &str| MetricReference { name: name.into(), settings: Settings::default(), pair: None };
    let range = |target, low, high, unit: &str| Range {
        target,
        values: RangeValues::Real { low, high },
        unit: unit.into(),
        origin: Origin::default(),
    };
    let objective =
        |aggregate, text: &str| Objective { direction: Goal::Minimise, aggregate, text: text.into() };
    let constraint = |name: &str, relation, bound: f64| Comparison {
        metric: metric(name),
        relation,
        bound: bound.into(),
        when_undefined: WhenUndefined::Fails,
    };
    let budget = Budget {
        evaluations: 3,
        initial: 2,
        initial_design: InitialDesign::Random,
        method: Method::Bayesian,
        batch: 1,
    };
    let origin = |line, text: &str| Origin {
        file: "zebra.suite".into(),
        line,
        column: 1,
        source_line: text.into(),
        length: text.chars().count() - 2,
    };
    let parameter = Target::Setting {
        road_user: "av".into(),
        part: Part::Controller,
        parameter: "braking_distance".into(),
    };
    let search = Search {
        name: "low_pet".into(),
        doc: None,
        scenario: "commotions_carla".into(),
        individuals: None,
        together: false,
        objective: objective(Aggregate::Mean(metric("pet")), "minimise mean(pet)"),
        over: vec![range(Target::Variation("tta".into()), 6.0, 18.0, "s")],
        budget: budget.clone(),
        runs: 1,
        keep: None,
        origin: origin(8, "search low_pet {"),
    };
    let tune = Tune {
        name: "braking_distance".into(),
        doc: None,
        on: CaseSet::Search("low_pet".into()),
        over: vec![range(parameter, 4.0, 25.0, "m")],
        objectives: vec![objective(Aggregate::Mean(metric("time_lost")), "minimise mean(time_lost)")],
        constraints: vec![
            constraint("pet", Relation::GreaterOrEqual, 1.0),
            constraint("collision", Relation::Equal, 0.0),
        ],
        budget,
        fresh: 0,
        early_stop: true,
        otherwise_fewest_violations: false,
        compare_with_default: true,
        origin: origin(16, "tune braking_distance {"),
    };
    (search, tune)
}

/// What a search over one person found.
pub fn search_result() -> SearchResult {
    found(&blocks().0)
}

/// One person's worst arrival.
fn found(search: &Search) -> SearchResult {
    let tta = |value| vec![optimise::Value::Real(value)];
    let slice = |value: f64| SlicePoint {
        value: optimise::Value::Real(value),
        mean: value / 4.0,
        lower: value / 4.0 - 0.5,
        upper: value / 4.0 + 0.5,
        feasibility: 1.0,
    };
    let found = Found {
        individuals: vec![person(17)],
        best: Some(vec![("tta".into(), optimise::Value::Real(6.5))]),
        observed: Some(1.25),
        predicted: Some((1.5, 0.125)),
        fresh: Some(1.75),
        fresh_runs: 20,
        passed_first: Some("pedestrian"),
        evaluations: vec![(tta(12.0), Some(3.0)), (tta(18.0), None), (tta(6.5), Some(1.25))],
        stop: Some(optimise::StopReason::Budget { evaluations: 3 }),
        slices: vec![vec![slice(6.0), slice(12.0), slice(18.0)]],
        runs: vec![case_run(6.5)],
        kept: vec![true],
        courses: vec![Course {
            over: "tta".into(),
            points: vec![CoursePoint { at: 6.0, smallest: 1.0, mean: 1.5, largest: 2.0, runs: 10 }],
        }],
    };
    SearchResult {
        name: search.name.clone(),
        objective: search.objective.text.clone(),
        direction: search.objective.direction,
        metrics: vec!["pet".into()],
        found: vec![found],
        kept: SavedSet {
            name: search.name.clone(),
            source: "search low_pet of suite zebra".into(),
            cases: Vec::new(),
        },
    }
}

/// A tune for which nothing was feasible.
fn tuned(tune: &Tune) -> TuneResult {
    let candidate = |value: f64| Candidate {
        point: vec![optimise::Value::Real(value)],
        objectives: vec![None],
        margins: vec![Some(-0.25), None],
        feasible: false,
    };
    TuneResult {
        name: tune.name.clone(),
        objectives: tune.objectives.iter().map(|objective| objective.text.clone()).collect(),
        constraints: vec!["pet >= 1".into(), "collision = 0".into()],
        cases: 1,
        fresh: 0,
        parameters: vec!["av.controller.braking_distance".into()],
        chosen: None,
        violations: None,
        pareto: Vec::new(),
        evaluations: vec![candidate(4.0), candidate(25.0), candidate(12.0)],
        stop: Some(optimise::StopReason::Budget { evaluations: 3 }),
        slices: Vec::new(),
        comparison: None,
    }
}

pub fn person(number: u32) -> Individual {
    Individual {
        pedestrian: "walker".into(),
        population: "standard".into(),
        number,
        parameters: Settings::default(),
    }
}

fn trial(scenario: &str, tta: f64) -> Trial {
    let key = format!("zebra/{scenario}/tta={tta}s");
    let case = |repetition: u32| {
        let number = 1 + repetition % 3;
        Case {
            key: format!("{key}/individual={number}/rep={repetition}"),
            scenario: scenario.into(),
            variation: vec![Assignment {
                name: "tta".into(),
                label: format!("{tta}s"),
                value: Value::Number(tta),
            }],
            individuals: vec![person(number)],
            repetition,
            seed: u64::from(repetition),
            world: world().into(),
        }
    };
    let origin = Origin { file: "zebra.scn".into(), line: 3, column: 1, ..Origin::default() };
    Trial {
        scenario: scenario.into(),
        doc: Some("A pedestrian meets a vehicle & looks.".into()),
        tags: vec!["zebra".into()],
        cases: (1..=RUNS).map(case).collect(),
        rounds: None,
        criteria: criteria(),
        origin,
        key,
    }
}

fn criteria() -> Vec<Criterion> {
    let runs = |line, name: &str, relation: Relation, bound: f64, share, text: &str| Criterion {
        claim: Claim::Runs {
            comparison: Comparison {
                metric: MetricReference { name: name.into(), settings: Settings::default(), pair: None },
                relation,
                bound: bound.into(),
                when_undefined: WhenUndefined::Passes,
            },
            share,
            confidence: None,
        },
        when: Vec::new(),
        text: text.into(),
        origin: Origin {
            file: "zebra.scn".into(),
            line,
            column: 5,
            source_line: format!("    {text}"),
            length: text.chars().count(),
        },
    };
    vec![
        runs(21, "collision", Relation::Equal, 0.0, None, "no collision"),
        runs(22, "pet", Relation::GreaterOrEqual, 1.5, None, "pet >= 1.5 s"),
        runs(
            23,
            "max_deceleration",
            Relation::LessOrEqual,
            2.5,
            Some(0.8),
            "max_deceleration <= 2.5 m/s^2 in 80 % of runs",
        ),
        runs(24, "gap_accepted", Relation::Equal, 1.0, Some(0.1), "gap_accepted in 10 % of runs"),
        runs(25, "passed_first", Relation::NotEqual, word("none"), None, "passed_first != none"),
    ]
}

fn world() -> World {
    let model = |name: &str| ModelSetup { name: name.into(), settings: Settings::default() };
    World {
        road: Road {
            name: "street".into(),
            lane_width: 4.0,
            lanes: vec![Lane { direction: Direction::Forward }, Lane { direction: Direction::Backward }],
            speed_limit: 30.0 / 3.6,
            kerbs: true,
            crossing: Crossing { kind: CrossingKind::Zebra, width: 4.0 },
            boxes: vec![Body { x: -9.0, y: -3.2, length: 4.5, width: 1.8 }],
        },
        vehicles: vec![VehicleSetup {
            name: "av".into(),
            controller: model("carla_behavior"),
            dynamics: model("ideal"),
            length: 4.5,
            width: 1.9,
            lane: 0,
            speed: 30.0 / 3.6,
            start: VehicleStart::Distance(50.0),
            sees: None,
        }],
        pedestrians: vec![PedestrianSetup {
            name: "walker".into(),
            model: model("scripted"),
            shape: Shape::Disc { radius: 0.3 },
            side: Side::Near,
            start: Position { x: 0.0, y: -4.0 },
            goal: Position { x: 0.0, y: 8.0 },
            appears: Appearance::At(1.0),
        }],
        step: 0.025,
        horizon: 60.0,
        finish: 50.0,
        end_on_collision: false,
    }
}

/// Both move at constant speed; the pedestrian a little faster in later repetitions.
fn course(case: &Case) -> Recording<'_> {
    let mut trace = Trace::default();
    let pace = 0.8 + 0.2 * f64::from(case.repetition);
    for step in 0..=400 {
        let time = f64::from(step) * 0.025;
        let (car, person) = (Vector2::new(8.0, 0.0), Vector2::new(0.0, pace));
        let sample = |who, position: Vector2<f64>, velocity| Sample {
            time,
            who,
            position,
            velocity,
            acceleration: 0.0,
            mode: "",
        };
        trace.samples.push(sample(0, Vector2::new(-50.0 + car.x * time, 0.0), car));
        if time >= 1.0 {
            trace.samples.push(sample(1, Vector2::new(0.0, -4.0 + person.y * (time - 1.0)), person));
        }
    }
    let event = |time, who: &str, what| Event { time, who: who.into(), what };
    let events = vec![
        event(1.0, "walker", Happening::Appears),
        event(6.25, "av", Happening::PassesCrossing { speed: 8.0 }),
    ];
    Recording::new(case, &trace, events)
}

/// A run at an arrival time, which gives a post-encroachment time of a fifth of it.
fn case_run(tta: f64) -> CaseRun {
    let value = Value::Number(tta);
    let case = SavedCase {
        key: format!("zebra/low_pet/individual=17/tta={tta}s/rep=1"),
        scenario: "commotions_carla".into(),
        variation: vec![Assignment { name: "tta".into(), label: format!("{tta}s"), value }],
        settings: Vec::new(),
        individuals: vec![person(17)],
        seed: 1,
        value: Some(tta / 5.0),
    };
    let outcome = Outcome {
        key: case.key.clone(),
        seed: case.seed,
        individuals: case.individuals.clone(),
        ending: Ending { reason: StopReason::Completed, time: 20.0 },
        metrics: vec![Some(tta / 5.0)],
        critical: Vec::new(),
        presences: Vec::new(),
        fingerprint: 0x0123_4567_89ab_cdef,
        wall_time: Duration::from_millis(3),
    };
    CaseRun { case, outcome, passed_first: Some("pedestrian") }
}

/// Two conditions and one that could not be run.
pub fn evaluation() -> EvaluateResult {
    let target = Target::Setting {
        road_user: "av".into(),
        part: Part::Controller,
        parameter: "braking_distance".into(),
    };
    let parameter = |value: f64| ParameterValue {
        target: target.clone(),
        value: Some(Value::Number(value)),
        varies: false,
        unit: "m".into(),
    };
    let metric = MetricReference { name: "pet".into(), settings: Settings::default(), pair: None };
    let measure = |aggregate, text: &str| Measure { aggregate, text: text.into(), unit: "s".into() };
    let difference = |interval| Some(Difference { value: 0.5, interval, pairs: 2 });
    let condition = |name: &str, distance, measured: f64| ConditionResult {
        name: name.into(),
        parameters: vec![parameter(distance)],
        missing: None,
        caveat: None,
        measured: vec![Some(measured), Some(measured - 0.25)],
        reported: None,
        differences: Vec::new(),
        runs: vec![case_run(5.0 * measured), case_run(5.0 * measured + 1.0)],
    };
    let tuned = ConditionResult {
        differences: vec![difference(Some(Interval { low: 0.25, high: 0.75 })), difference(None)],
        caveat: Some(Violations { runs: 2, of: 63 }.to_string()),
        ..condition("tuned", 12.5, 1.75)
    };
    let missing = ConditionResult {
        parameters: Vec::new(),
        missing: Some("tune `braking` chose nothing".into()),
        measured: vec![None, None],
        differences: vec![None, None],
        runs: Vec::new(),
        ..condition("braking", 0.0, 0.0)
    };
    EvaluateResult {
        name: "final".into(),
        doc: None,
        source: Some("Wang et al., Table 1".into()),
        metrics: vec!["pet".into()],
        measures: vec![
            measure(Aggregate::Mean(metric.clone()), "mean(pet)"),
            measure(Aggregate::Min(metric), "min(pet)"),
        ],
        cases: 2,
        fresh: 0,
        conditions: vec![
            ConditionResult { reported: Some(vec![2.48, 1.05]), ..condition("default", 5.0, 1.25) },
            tuned,
            missing,
        ],
    }
}

/// A statement with a claim of each kind: one holds, one does not, of one nobody can say.
pub fn statement(standing: Standing, conclusion: Conclusion) -> StatementResult {
    let point = |label: &str, at, value| TrendPoint { label: label.into(), at, value, runs: 20 };
    let claims = vec![
        ClaimResult {
            text: "rate(gap_accepted) of people rises with tta".into(),
            holds: Some(true),
            undefined: None,
            values: ClaimValues::Trend {
                direction: TrendDirection::Rises,
                variable: "tta".into(),
                points: vec![point("6s", 6.0, Some(0.1)), point("18s", 18.0, Some(1.0))],
            },
            unit: "%".into(),
        },
        ClaimResult {
            text: "mean(pet) of final.tuned > mean(pet) of final.default".into(),
            holds: Some(false),
            undefined: None,
            values: ClaimValues::Compared { left: Some(2.0), relation: Relation::Greater, right: Some(2.48) },
            unit: "s".into(),
        },
        ClaimResult {
            text: "min(pet) of nobody >= 1.5 s".into(),
            holds: None,
            undefined: Some("no run of `nobody` is asked about".into()),
            values: ClaimValues::Compared {
                left: None,
                relation: Relation::GreaterOrEqual,
                right: Some(1.5),
            },
            unit: "s".into(),
        },
    ];
    StatementResult {
        name: "gaps_rise".into(),
        doc: Some("The more time there is, the more people accept the gap.".into()),
        source: Some("Wang et al., experiment 1".into()),
        reported: Some("about 10 % at 6 s".into()),
        conclusion,
        claims,
        standing,
    }
}
