//! Units that are made of runs: trials, from their first run to their verdict, and runs that failed before.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::shared::Runner;
use crate::corpus::{self, case_hash};
use crate::plan::PlannedTrial;
use crate::run::{Done, Job, JobFailure, JobPlace, Panicked, Ran, RunError, Sequence, departures, programs};
use results::judge::{self, PerRun, judge, per_run};
use results::{
    Cut, Outcome, Recorded, RecordedReport, RecordedState, Rerun, RunFault, Skip, TrialReport, TrialState,
    UnitError, UnitReport, Verdict,
};
use scenario::{Case, Criterion};

/// A unit under way that is made of runs.
pub enum UnitRun<'s, 'a> {
    Trial(Box<TrialRun<'s, 'a>>),
    Recorded(Box<RecordedRun<'s, 'a>>),
}

impl UnitRun<'_, '_> {
    /// What became of it once `taken` of its runs were taken in.
    pub fn report(self, taken: usize) -> UnitReport {
        match self {
            Self::Trial(trial) => UnitReport::Trial(trial.report(taken)),
            Self::Recorded(recorded) => UnitReport::Recorded(recorded.report()),
        }
    }
}

impl Sequence for UnitRun<'_, '_> {
    fn runs(&self) -> usize {
        match self {
            Self::Trial(trial) => trial.trial.cases.len(),
            Self::Recorded(recorded) => usize::from(recorded.ended.is_none()),
        }
    }

    fn job(&mut self, place: JobPlace) -> Job {
        let (runner, suite, case, number) = match self {
            Self::Trial(one) => {
                (one.runner, one.suite, one.trial.cases.get(place.run), one.number + place.run)
            }
            // Each of them is made twice.
            Self::Recorded(one) => (one.runner, one.suite, one.case.take().expect("it is run once"), 0),
        };
        let wanted = runner.first_runs(suite).wanted(number, &case);
        runner.job(place, case, wanted)
    }

    fn take(&mut self, done: Done) -> ControlFlow<()> {
        match self {
            Self::Trial(trial) => trial.take(done),
            Self::Recorded(recorded) => recorded.take(done),
        }
    }

    fn between(&mut self, taken: usize) -> ControlFlow<()> {
        match self {
            Self::Trial(trial) => trial.keep_limit(taken),
            Self::Recorded(_) => ControlFlow::Continue(()),
        }
    }
}

/// A trial under way.
pub struct TrialRun<'s, 'a> {
    runner: &'s Runner<'a>,
    suite: usize,
    trial: PlannedTrial,
    /// Of its first run among those of its scenario.
    number: usize,
    begun: Instant,
    time_limit: Option<Duration>,
    /// Whether its wall time is measured here; else whoever made its runs has done so.
    is_timed: bool,
    watch: judge::Watch<'s>,
    outcomes: Vec<Outcome>,
    /// Whether the outcomes are enough, though there could be more.
    enough: bool,
    /// Why it has no verdict.
    broken: Option<TrialState>,
    /// The runs that programs kept from their ends, each with all that is said of it.
    faults: Vec<(RunFault, String)>,
    /// Told of every run that was taken in.
    told: Box<dyn FnMut() + Send + 's>,
}

impl<'s, 'a> TrialRun<'s, 'a> {
    pub fn new(
        runner: &'s Runner<'a>,
        suite: usize,
        trial: PlannedTrial,
        told: Box<dyn FnMut() + Send + 's>,
    ) -> Self {
        Self {
            runner,
            suite,
            number: runner.first_runs(suite).number(&trial.scenario, trial.cases.len()),
            begun: Instant::now(),
            time_limit: runner.suites()[suite].plan.time_limit.map(Duration::from_secs_f64),
            is_timed: runner.is_timed(),
            watch: judge::Watch::new(&trial.trial, runner.requests()),
            outcomes: Vec::with_capacity(trial.certain_runs()),
            trial,
            enough: false,
            broken: None,
            faults: Vec::new(),
            told,
        }
    }

    fn take(&mut self, done: Done) -> ControlFlow<()> {
        let Done { case, result, .. } = done;
        let ran = match result {
            Ok(ran) => ran,
            Err(JobFailure::Error(RunError::TimeLimit)) => {
                let finished = self.outcomes.len() + self.faults.len();
                return self.over_limit(self.time_limit.unwrap_or_default(), finished);
            }
            Err(JobFailure::Error(error)) => {
                let told = format!("{}: {}", case.key, self.runner.told(self.suite, &case, &error));
                return match error.run_fault(&case.key) {
                    Some(fault) => self.faulted(fault, told),
                    None => self.breaks(TrialState::Errored(told.into())),
                };
            }
            Err(JobFailure::Panicked(panicked)) => return self.panicked(panicked),
        };
        // One broken model must not take the results of all others along, nor whoever watches it.
        match Panicked::catch(|| self.see(&case, ran)) {
            Ok(true) => ControlFlow::Break(()),
            Ok(false) => ControlFlow::Continue(()),
            Err(panicked) => self.panicked(panicked),
        }
    }

    /// Whether the runs are enough with this one, of which no more is kept than the criteria need.
    fn see(&mut self, case: &Case, mut ran: Ran) -> bool {
        let first_runs = self.runner.first_runs(self.suite);
        if first_runs.takes(self.number + self.outcomes.len() + self.faults.len(), case) {
            first_runs.keep(case, &mut ran);
        }
        ran.outcome.forget_unasked(&self.trial.criteria, self.runner.requests());
        self.runner.watched(case, &ran);
        (self.told)();
        self.outcomes.push(ran.outcome);
        self.enough = if self.faults.is_empty() {
            self.watch.enough(&self.outcomes).is_some()
        } else {
            self.has_certain_runs()
        };
        self.enough
    }

    /// A run that a program kept from its end: the others are made all the same, but none is added to decide what is not judged.
    fn faulted(&mut self, fault: RunFault, told: String) -> ControlFlow<()> {
        (self.told)();
        self.faults.push((fault, told));
        if self.has_certain_runs() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Whether all runs were made that are made in any case.
    fn has_certain_runs(&self) -> bool {
        self.outcomes.len() + self.faults.len() >= self.trial.certain_runs()
    }

    fn panicked(&mut self, panicked: Panicked) -> ControlFlow<()> {
        let case = panicked.case.clone().unwrap_or_else(|| self.trial.key.clone());
        self.breaks(TrialState::Errored(Panicked { case: Some(case), ..panicked }.to_string().into()))
    }

    fn breaks(&mut self, why: TrialState) -> ControlFlow<()> {
        self.broken = Some(why);
        ControlFlow::Break(())
    }

    fn keep_limit(&mut self, finished: usize) -> ControlFlow<()> {
        let over = self.time_limit.filter(|limit| self.is_timed && self.begun.elapsed() > *limit);
        over.map_or(ControlFlow::Continue(()), |limit| self.over_limit(limit, finished))
    }

    fn over_limit(&mut self, limit: Duration, finished: usize) -> ControlFlow<()> {
        let runs = self.trial.cases.len();
        self.breaks(TrialState::NotFinished(Cut::TimeLimit { limit, finished, runs }))
    }

    fn report(self, finished: usize) -> TrialReport {
        let Self { trial, watch, outcomes, enough, broken, faults, begun, .. } = self;
        let runs = trial.cases.len();
        let (outcomes, state) = match broken {
            Some(why @ TrialState::Errored(_)) => (Vec::new(), why),
            // Whatever cut it off: it has not passed.
            _ if !faults.is_empty() => {
                let (faults, told): (_, Vec<String>) = faults.into_iter().unzip();
                (Vec::new(), TrialState::Errored(UnitError::of_faults(faults, &told, outcomes)))
            }
            Some(why) => (Vec::new(), why),
            None if finished < runs && !enough => {
                (Vec::new(), TrialState::NotFinished(Cut::Trial { finished, runs }))
            }
            None => {
                let judged = watch.verdict(&outcomes);
                (outcomes, TrialState::Judged(judged))
            }
        };
        TrialReport {
            trial: trial.trial.clone(),
            outcomes,
            state,
            departures: departures(&trial),
            wall_time: begun.elapsed(),
        }
    }
}

/// A recorded run that is made again, under the key of its unit.
pub struct RecordedRun<'s, 'a> {
    runner: &'s Runner<'a>,
    suite: usize,
    key: String,
    recorded: &'a Recorded,
    criteria: Vec<Criterion>,
    begun: Instant,
    case: Option<Case>,
    ended: Option<RecordedState>,
}

impl<'s, 'a> RecordedRun<'s, 'a> {
    pub fn new(runner: &'s Runner<'a>, suite: usize, key: &str, recorded: &'a Recorded) -> Self {
        let declared = &runner.suites()[suite].suite;
        let begun = Instant::now();
        let revived = Panicked::catch(|| {
            let case = corpus::revive(recorded, declared)?;
            Ok((Case { key: key.to_string(), ..case }, corpus::criteria(recorded, declared)?))
        });
        let ended = |state| (None, Vec::new(), Some(state));
        let (case, criteria, ended) = match revived {
            Ok(Ok((case, criteria))) => (Some(case), criteria, None),
            Ok(Err(stale)) => {
                let stale: corpus::Stale = stale;
                ended(RecordedState::Skipped(Skip::Stale(stale.to_string())))
            }
            Err(panicked) => ended(RecordedState::Errored(panicked.to_string().into())),
        };
        Self { runner, suite, key: key.to_string(), recorded, criteria, begun, case, ended }
    }

    fn take(&mut self, done: Done) -> ControlFlow<()> {
        self.ended = Some(match done.result {
            Ok(ran) => Panicked::catch(|| self.judged(&done.case, ran))
                .unwrap_or_else(|panicked| RecordedState::Errored(panicked.to_string().into())),
            Err(JobFailure::Error(error)) => {
                let told = self.runner.told(self.suite, &done.case, &error);
                RecordedState::Errored(match error.run_fault(&done.case.key) {
                    Some(fault) => UnitError::of_faults(vec![fault], &[told], Vec::new()),
                    None => told.into(),
                })
            }
            Err(JobFailure::Panicked(panicked)) => RecordedState::Errored(panicked.to_string().into()),
        });
        ControlFlow::Break(())
    }

    fn judged(&self, case: &Case, mut ran: Ran) -> RecordedState {
        let first_runs = self.runner.first_runs(self.suite);
        if first_runs.takes(0, case) {
            first_runs.keep(case, &mut ran);
        }
        self.runner.watched(case, &ran);
        let outcome = ran.outcome;
        let (decisive, others): (Vec<_>, Vec<_>) =
            self.criteria.iter().filter_map(per_run).partition(|one| one.decisive);
        let judged = |criteria: Vec<PerRun>| {
            let criteria: Vec<_> = criteria.into_iter().map(|one| one.criterion).collect();
            judge(&criteria, std::slice::from_ref(&outcome), self.runner.requests())
        };
        let (decided, others) = (judged(decisive), judged(others));
        RecordedState::Ran(Box::new(Rerun {
            same_case: case_hash(case) == self.recorded.case,
            judged: decided,
            against: others.findings.into_iter().filter(|one| one.verdict != Verdict::Passed).collect(),
            outcome,
            may_differ: programs(case).iter().any(|program| program.may_differ()),
        }))
    }

    fn report(self) -> RecordedReport {
        let interrupted = || RecordedState::Skipped(Skip::Stopped(results::Stopping::Interrupted));
        RecordedReport {
            recorded: Arc::new(self.recorded.clone()),
            key: self.key,
            state: self.ended.unwrap_or_else(interrupted),
            wall_time: self.begun.elapsed(),
        }
    }
}
