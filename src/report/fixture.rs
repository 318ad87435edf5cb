//! A made-up session for the tests of every format: two scenarios, three times to arrival, a few runs each.

mod blocks;
pub mod gate;
pub mod rating;
mod trials;

use std::sync::Arc;
use std::time::{Duration, SystemTime};

use blocks::{blocks, found, tuned};
pub use blocks::{calibration, evaluation, search_result, statement};
use results::{
    BlockReport, BlockResult, BlockState, Critical, Cut, Outcome, PairPresence, Program, Reason, Recorded,
    RecordedReport, RecordedState, Requests, Rerun, Results, RunsTaken as Stopped, Skip, Stopping,
    SuiteIdentity, SuiteReport, TrialReport, TrialState, TrialVerdict, Untested, UntestedPair, Verdict,
    choose_runs,
};
pub use trials::person;
use trials::{course, trial, word};

use crate::diff::{DiffSide, RunDiff};
use results::judge::{judge, per_run};
use results::{
    Chosen, ContactMoment, Doing, InBoth, OneOfTwo, PartedIn, Parting, PartsBy, Recording, SharedMoment,
    TwoRuns,
};
use runner::plan::PlannedTrial;
use scenario::{Block, Case, Gate, MetricReference, Rating, Search, TextDigest, Tune};
use sim::measure::{Closeness, Presence};
use sim::{Ending, Happening, StopReason, TimelineEvent};

/// The trials, and what reports borrow from.
pub struct Session {
    trials: Vec<PlannedTrial>,
    search: Search,
    tune: Tune,
    recorded: Arc<Recorded>,
    gate: Arc<Gate>,
    rating: Arc<Rating>,
    pub requests: Requests,
    /// The suite's name and file.
    suite: String,
    file: String,
}

impl Session {
    pub fn new() -> Self {
        let mut trials = Vec::new();
        for scenario in ["commotions_carla", "walker_<carla>"] {
            for tta in [6.0, 10.0, 14.0] {
                trials.push(trial(scenario, tta));
            }
        }
        let mut requests = Requests::default();
        trials.iter().for_each(|trial: &PlannedTrial| requests.include(&trial.criteria));
        let (search, tune) = blocks();
        Self {
            recorded: Arc::new(recorded(&trials[0].cases.get(1))),
            trials,
            search,
            tune,
            gate: Arc::new(gate::gate()),
            rating: Arc::new(rating::rating()),
            requests,
            suite: "zebra".into(),
            file: "suites/zebra.suite".into(),
        }
    }

    /// The same session with names, files, words and texts that end in `text`.
    pub fn with_names(text: &str) -> Self {
        let mut session = Self::new();
        let name = |name: &mut String| name.push_str(text);
        let shared = |name: &mut Arc<str>| *name = format!("{name}{text}").into();
        for planned in &mut session.trials {
            let trial = Arc::make_mut(&mut planned.trial);
            let key = std::mem::take(&mut trial.key);
            trial.key = format!("{key}{text}");
            trial.doc.iter_mut().chain(&mut trial.tags).for_each(name);
            name(&mut trial.scenario);
            trial.first_run = trial.first_run.replace(&key, &trial.key);
            for one in &mut trial.variation {
                [&mut one.name, &mut one.label].into_iter().for_each(name);
            }
            let mut cases: Vec<_> = planned.cases.iter().collect();
            for case in &mut cases {
                case.key = case.key.replace(&key, &trial.key);
                name(&mut case.scenario);
                for one in &mut case.variation {
                    [&mut one.name, &mut one.label].into_iter().for_each(name);
                }
            }
            planned.cases = cases.into();
            for criterion in Arc::make_mut(&mut trial.criteria) {
                let origin = &mut criterion.origin;
                name(&mut criterion.text);
                [&mut origin.file, &mut origin.source_line].into_iter().for_each(shared);
            }
            shared(&mut trial.origin.file);
        }
        let recorded = Arc::make_mut(&mut session.recorded);
        let gate = Arc::make_mut(&mut session.gate);
        [&mut recorded.key, &mut recorded.scenario].into_iter().chain(&mut recorded.against).for_each(name);
        [&mut session.search.name, &mut session.tune.name, &mut gate.name].into_iter().for_each(name);
        gate.rules.iter_mut().for_each(|rule| name(&mut rule.text));
        let rating = Arc::make_mut(&mut session.rating);
        [&mut rating.name].into_iter().chain(&mut rating.doc).chain(&mut rating.not_assessed).for_each(name);
        rating.points.iter_mut().for_each(|points| name(&mut points.tag));
        [&mut session.suite, &mut session.file].into_iter().for_each(name);
        session
    }

    /// One trial of every state: the last two are an error and a skipped one. The second was run until it
    /// was decided, and something in the third was not put to the test.
    pub fn report(&self) -> SuiteReport {
        let count = self.trials.len();
        let state = |(index, trial): (usize, &PlannedTrial)| match count - index {
            2 => (
                Vec::new(),
                TrialState::Errored(format!("{}: time limit of 10 s exceeded", trial.key).into()),
            ),
            1 => (Vec::new(), TrialState::Skipped(Skip::Stopped(Stopping::MaxFail(2)))),
            _ => {
                let outcomes = self.outcomes(trial);
                let mut judged = judge(&trial.criteria, &outcomes, &self.requests);
                if let Some(passed) = judged.findings.iter_mut().find(|one| one.verdict == Verdict::Passed)
                    && index == 2
                {
                    let pair = UntestedPair {
                        vehicle: Some("av".into()),
                        other: "walker".into(),
                        closest: Closeness::Together,
                    };
                    passed.untested = Some(Untested::Pairs { pairs: vec![pair], instead: None });
                }
                let runs = outcomes.len();
                let stopping = Stopped { least: 4, most: 20, runs, reason: Reason::Decided };
                let stopping = (index == 1).then_some(stopping);
                (outcomes, TrialState::Judged(TrialVerdict { stopping, ..judged }))
            }
        };
        let trials = self.trials.iter().enumerate().map(|(index, trial)| {
            let (outcomes, state) = state((index, trial));
            TrialReport {
                trial: trial.trial.clone(),
                outcomes,
                state,
                departures: Vec::new(),
                wall_time: Duration::from_millis(250),
            }
        });
        SuiteReport {
            identity: SuiteIdentity {
                suite: self.suite.clone(),
                file: self.file.clone(),
                seed: u64::MAX,
                set: Vec::new(),
                tested: Vec::new(),
                earlier_seeds: Vec::new(),
                texts: vec![TextDigest { file: self.file.clone(), sha256: "0f".repeat(32) }],
            },
            program: Program::this(),
            started: SystemTime::UNIX_EPOCH + Duration::from_secs(1_795_250_000),
            wall_time: Duration::from_millis(1500),
            recorded: self.reruns(),
            trials: trials.collect(),
            summary: None,
            controllers: Vec::new(),
            people: Vec::new(),
            blocks: self.blocks(),
            gates: gate::reports(&self.gate),
            ratings: rating::reports(&self.rating),
            interrupted: false,
        }
    }

    /// A session that somebody interrupted: a trial is finished, one was cut off by the time limit, one by the
    /// interruption, and a search with it; the rest has not begun.
    pub fn interrupted(&self) -> SuiteReport {
        let mut report = self.report();
        let skip = || Skip::Stopped(Stopping::Interrupted);
        report.trials[1].outcomes.clear();
        let limit = Duration::from_secs(10);
        report.trials[1].state = TrialState::NotFinished(Cut::TimeLimit { limit, finished: 3, runs: 6 });
        report.trials[2].outcomes.clear();
        report.trials[2].state = TrialState::NotFinished(Cut::Trial { finished: 5, runs: 6 });
        for trial in &mut report.trials[3..] {
            trial.outcomes.clear();
            trial.state = TrialState::Skipped(skip());
        }
        let words = "interrupted; the same command goes on from here".to_string();
        report.blocks[0].state = BlockState::NotFinished(Cut::Block(words));
        for block in &mut report.blocks[1..] {
            block.state = BlockState::Skipped(skip());
        }
        report.recorded.clear();
        report.gates.clear();
        report.ratings.clear();
        report.interrupted = true;
        report
    }

    /// A run that still fails, one that does not, and one that cannot be run any more.
    fn reruns(&self) -> Vec<RecordedReport> {
        let trial = &self.trials[0];
        let outcome = self.outcomes(trial).remove(1);
        let judged = |least: f64| {
            let criteria: Vec<_> =
                trial.criteria.iter().filter_map(per_run).filter(|one| one.decisive).collect();
            let mut criteria: Vec<_> = criteria.into_iter().map(|one| one.criterion).collect();
            for criterion in &mut criteria {
                if criterion.claim.metric().name() == "pet" {
                    criterion.claim.bounds_mut().into_iter().for_each(|bound| *bound = least.into());
                }
            }
            judge(&criteria, std::slice::from_ref(&outcome), &self.requests)
        };
        let ran = |least: f64, same_case| {
            let outcome = outcome.clone();
            RecordedState::Ran(Box::new(Rerun {
                may_differ: false,
                judged: judged(least),
                outcome,
                same_case,
                against: Vec::new(),
            }))
        };
        let gone = Skip::Stale("there is no scenario `commotions_carla` any more".into());
        let states = [ran(1.5, true), ran(0.5, false), RecordedState::Skipped(gone)];
        let report = |(index, state): (usize, RecordedState)| RecordedReport {
            recorded: self.recorded.clone(),
            // A run is recorded once in a real file.
            key: format!("{}{}", self.recorded.unit_key(), ["", "_2", "_3"][index]),
            state,
            wall_time: Duration::from_millis(3),
        };
        states.into_iter().enumerate().map(report).collect()
    }

    /// One block of every state: with a result, with one that fails, with an error and a skipped one.
    fn blocks(&self) -> Vec<BlockReport> {
        let (search, tune) =
            (Arc::new(Block::Search(self.search.clone())), Arc::new(Block::Tune(self.tune.clone())));
        let error = "`walker`: there is no population called `standard`".to_string();
        let reason =
            Skip::Needs { key: "zebra/search=low_pet_2".into(), happened: "could not be run".into() };
        let states = [
            (search.clone(), BlockState::Finished(Box::new(BlockResult::Search(found(&self.search))))),
            (tune.clone(), BlockState::Finished(Box::new(BlockResult::Tune(tuned(&self.tune))))),
            (search, BlockState::Errored(error.into())),
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

    /// A report with the courses of its runs, as a session hands it on.
    pub fn results(&self, report: SuiteReport) -> Results {
        let recordings = self.record(choose_runs(&report));
        Results { requests: self.requests.clone(), suites: vec![report], recordings, denies_untested: false }
    }

    /// A report without the courses of its runs.
    pub fn unrecorded(&self, report: SuiteReport) -> Results {
        Results {
            requests: self.requests.clone(),
            suites: vec![report],
            recordings: Vec::new(),
            denies_untested: false,
        }
    }

    /// Every trial a hundred times over.
    pub fn long_report(&self) -> SuiteReport {
        let mut report = self.report();
        report.trials = (0..100).flat_map(|_| self.report().trials).collect();
        report
    }

    /// A straight course for every chosen run.
    pub fn record(&self, chosen: Vec<Chosen>) -> Vec<(Chosen, Recording)> {
        let cases = || self.trials.iter().flat_map(|trial| trial.cases.iter());
        let recording = |chosen: Chosen| {
            let case = cases().find(|case| case.key == chosen.key).expect("a chosen run is one of the runs");
            (chosen, course(&case))
        };
        chosen.into_iter().map(recording).collect()
    }

    /// A run made in two ways: in B the pedestrian is faster, and is touched.
    pub fn two(&self) -> TwoRuns {
        let trial = &self.trials[0];
        let (case, outcomes) = (trial.cases.get(0), self.outcomes(trial));
        let side = |index: usize| {
            let recording = Recording { case: case.clone(), ..course(&trial.cases.get(index)) };
            let outcome = Outcome { key: case.key.clone(), seed: case.seed, ..outcomes[index].clone() };
            OneOfTwo { outcome, contacts: Vec::new(), recording }
        };
        let (a, mut b) = (side(0), side(2));
        let (vehicle, with) = ("av".to_string(), "walker".to_string());
        b.contacts.push(ContactMoment {
            time: 6.25,
            vehicle: vehicle.clone(),
            with: with.clone(),
            relative_speed: 8.0,
            speed: 8.0,
            place: (0.0, 0.0),
        });
        let what = Happening::Collides { with: vehicle, relative_speed: 8.0 };
        b.recording.events.push(TimelineEvent { time: 6.25, who: with.clone(), what });
        let parting = |time, apart| Parting {
            time,
            by: vec![PartsBy {
                who: with.clone(),
                what: PartedIn::Motion { apart, relative_speed: 0.4, a: 1.0, b: 1.4 },
            }],
        };
        let doing = |y| Doing { x: 0.0, y, speed: 1.0, activity: "walks".into() };
        let moment = |time, a, b| SharedMoment {
            time,
            each: vec![InBoth { who: with.clone(), a: Some(doing(a)), b: Some(doing(b)) }],
        };
        TwoRuns {
            a,
            b,
            differs: vec!["av.controller: carla_behavior -> idm_<aeb>".into()],
            first: Some(parting(1.025, 0.01)),
            apart: Some(parting(1.25, 0.1)),
            moments: vec![moment(0.0, -4.0, -4.0), moment(1.25, -3.75, -3.65), moment(6.25, 1.25, 3.35)],
        }
    }

    /// What it is told with; B is otherwise by what is said.
    pub fn with_diff<T>(&self, otherwise: &str, tell: impl FnOnce(&RunDiff) -> T) -> T {
        let (two, trial) = (self.two(), &self.trials[0]);
        let case = trial.cases.get(0);
        let values = [("tta".to_string(), "6 s".to_string())];
        let side =
            |otherwise| DiffSide { otherwise, case: &case, values: &values, criteria: &trial.criteria };
        tell(&RunDiff {
            key: &case.key,
            sides: [side("controller av=carla_behavior"), side(otherwise)],
            requests: &self.requests,
            two: &two,
            remarks: &[format!("B is made on the noise of `{}`", case.key)],
        })
    }

    fn outcomes(&self, trial: &PlannedTrial) -> Vec<Outcome> {
        let outcome = |case: &Case| {
            let (run, tta) = (f64::from(case.repetition), case.variation[0].value.as_number().unwrap_or(0.0));
            let value = |reference: &MetricReference| match reference.name() {
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
                drawn: Vec::new(),
                ending: Ending { reason: StopReason::Completed, time: 20.0 },
                metrics: self.requests.iter().map(value).collect(),
                critical: self.requests.iter().map(|_| Some(critical(run))).collect(),
                presences: vec![PairPresence {
                    vehicle: "av".into(),
                    other: "walker".into(),
                    of_vehicles: false,
                    presence: Presence { closest: Closeness::Met, moved: true, passed: true },
                }],
                waiting_steps: Vec::new(),
                left_road: Vec::new(),
                outlasted: Vec::new(),
                cut_off: Default::default(),
                fingerprint: 0x0123_4567_89ab_cdef,
                wall_time: Duration::from_millis(3),
            }
        };
        trial.cases.iter().map(|case| outcome(&case)).collect()
    }
}

/// Takes bytes, and notes how many there were in all and at most at once.
#[derive(Default)]
pub struct Meter {
    pub all: usize,
    pub at_once: usize,
}

impl std::io::Write for Meter {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.all += bytes.len();
        self.at_once = self.at_once.max(bytes.len());
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Half a second later in every run.
fn critical(run: f64) -> Critical {
    let (vehicle, pedestrian) = (Some("av".into()), Some("walker".into()));
    Critical { time: Some(7.25 + run / 2.0), vehicle, pedestrian, other: None }
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
