//! Where one unit is run: a trial from its first case to its verdict, a block to its result.

use std::mem;
use std::path::PathBuf;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use super::unit::{Unit, Work};
use crate::corpus::{self, case_hash};
use crate::experiment::{EarlierResults, ExperimentError, Laboratory, Progress, run_block};
use crate::judge::{self, PerRun, judge, per_run};
use crate::plan::PlannedTrial;
use crate::project::PlannedSuite;
use crate::registry::Registry;
use crate::results::{
    BlockReport, BlockState, Cut, Outcome, Recorded, RecordedReport, RecordedState, Requests, Rerun, Skip,
    SuiteIdentity, TrialReport, TrialState, UnitReport, Verdict,
};
use crate::run::{
    FreeFlows, Panicked, Ran, RunError, SharedTrial, Stop, TrialError, Unwatched, departures, run_case,
};
use crate::scenario::{Block, Case};
use crate::sim::Trace;

/// Given the course of every run of a trial.
pub type Watch<'a> = dyn Fn(&Case, &Trace) + Sync + 'a;

/// Everything that units share.
pub struct Workshop<'a> {
    suites: &'a [PlannedSuite],
    /// One per suite.
    laboratories: Vec<Laboratory<'a>>,
    /// Every metric that anything in any of the suites asks for: all runs are measured alike.
    requests: Requests,
    registry: Registry,
    stop: Stop,
    watch: Option<&'a Watch<'a>>,
}

impl<'a> Workshop<'a> {
    /// `journals` is where searches and tunes keep what they have evaluated.
    pub fn new(
        suites: &'a [PlannedSuite],
        journals: Option<PathBuf>,
        stop: &Stop,
        registry: &Registry,
    ) -> Self {
        let mut laboratories: Vec<_> = suites
            .iter()
            .map(|suite| Laboratory::new(&suite.suite, journals.clone(), registry).stopped_by(stop.clone()))
            .collect();
        let mut requests = Requests::defaults(registry);
        for laboratory in &laboratories {
            laboratory.requests.iter().for_each(|request| requests.add(request));
        }
        for laboratory in &mut laboratories {
            laboratory.requests = requests.clone();
        }
        let registry = registry.clone();
        Self { suites, laboratories, requests, registry, stop: stop.clone(), watch: None }
    }

    /// With somebody who is given the course of every run of a trial.
    pub fn watched_by(mut self, watch: &'a Watch<'a>) -> Self {
        self.watch = Some(watch);
        self
    }

    /// What the suites may name.
    pub fn registry(&self) -> &Registry {
        &self.registry
    }

    /// What is measured in every run, in the order of the outcomes' metrics.
    pub fn requests(&self) -> &Requests {
        &self.requests
    }

    pub fn free_flows(&self, suite: usize) -> &FreeFlows {
        &self.laboratories[suite].free_flows
    }

    /// What there is to tell besides the results, such as that the end of a journal was cut off.
    pub fn notices(&self) -> Vec<String> {
        let notices = self.laboratories.iter().map(|one| &one.notices);
        let taken =
            notices.map(|notices| mem::take(&mut *notices.lock().unwrap_or_else(PoisonError::into_inner)));
        taken.flatten().collect()
    }

    pub fn stop(&self) -> &Stop {
        &self.stop
    }

    pub fn suites(&self) -> &'a [PlannedSuite] {
        self.suites
    }

    pub fn identity(&self, suite: usize) -> SuiteIdentity {
        let prepared = &self.suites[suite];
        SuiteIdentity {
            suite: prepared.plan.suite.clone(),
            file: prepared.file.clone(),
            seed: prepared.plan.seed,
            set: prepared.suite.set.clone(),
        }
    }

    /// Runs and judges one trial of the suite with index `suite`. `done` is called after every run.
    pub fn trial(&self, suite: usize, shared: &SharedTrial<'a>, done: &dyn Fn()) -> TrialReport {
        let begun = Instant::now();
        let trial = shared.trial;
        let limit = self.suites[suite].plan.time_limit.map(Duration::from_secs_f64);
        let run = |case: &Case| self.case_of(suite, trial, case);
        let done = |case: &Case, ran: &Ran| {
            self.watched(case, ran);
            done();
        };
        let mut watch = judge::Watch::new(trial, &self.requests);
        let enough = |outcomes: &[Outcome]| watch.enough(outcomes).is_some();
        // One broken model must not take the results of all others along.
        let outcomes = Panicked::catch(|| shared.run_all(limit, &self.stop, enough, run, done));
        let (outcomes, state) = match outcomes {
            Ok(Ok(outcomes)) => {
                let judged = watch.verdict(&outcomes);
                (outcomes, TrialState::Judged(judged))
            }
            Ok(Err(TrialError::Stopped { finished, runs })) => {
                (Vec::new(), TrialState::NotFinished(Cut::Trial { finished, runs }))
            }
            Ok(Err(TrialError::TimeLimit { limit, finished, runs })) => {
                (Vec::new(), TrialState::NotFinished(Cut::TimeLimit { limit, finished, runs }))
            }
            Ok(Err(TrialError::Run { key, error })) => (
                Vec::new(),
                TrialState::Errored(format!("{key}: {}", self.told(suite, &trial.scenario, &error))),
            ),
            Err(panicked) => {
                let case = panicked.case.clone().unwrap_or_else(|| trial.key.clone());
                let message = Panicked { case: Some(case), ..panicked }.to_string();
                (Vec::new(), TrialState::Errored(message))
            }
        };
        TrialReport {
            trial: trial.trial.clone(),
            outcomes,
            state,
            departures: departures(trial),
            wall_time: begun.elapsed(),
        }
    }

    /// Runs one case of a trial that another thread sees to.
    pub fn help(&self, suite: usize, shared: &SharedTrial, index: usize) {
        shared.run(index, |case| self.case_of(suite, shared.trial, case));
    }

    /// A run of a trial, of which no more is kept than its criteria need.
    fn case_of(&self, suite: usize, trial: &PlannedTrial, case: &Case) -> Result<Ran, RunError> {
        let mut ran = self.case(suite, case)?;
        ran.outcome.forget_unasked(&trial.criteria, &self.requests);
        Ok(ran)
    }

    /// What is wrong, in the units of the scenario.
    fn told(&self, suite: usize, scenario: &str, error: &RunError) -> String {
        let scenario = self.suites[suite].suite.scenario(scenario);
        scenario.map_or_else(|| error.to_string(), |scenario| error.told(scenario))
    }

    fn case(&self, suite: usize, case: &Case) -> Result<Ran, RunError> {
        let free_flows = self.free_flows(suite);
        if self.watch.is_none() {
            let outcome = run_case(case, &self.requests, free_flows, &mut Unwatched)?;
            return Ok(Ran { outcome, trace: None });
        }
        let mut trace = Trace::default();
        let outcome = run_case(case, &self.requests, free_flows, &mut trace)?;
        Ok(Ran { outcome, trace: Some(trace) })
    }

    /// Gives the course of a run to whoever wants it.
    fn watched(&self, case: &Case, ran: &Ran) {
        if let (Some(watch), Some(trace)) = (self.watch, &ran.trace) {
            watch(case, trace);
        }
    }

    /// Runs a recorded run again, under the key of its unit.
    pub fn recorded(&self, suite: usize, key: &str, recorded: &Recorded) -> RecordedReport {
        let begun = Instant::now();
        let state = match Panicked::catch(|| self.rerun(suite, key, recorded)) {
            Ok(state) => state,
            Err(panicked) => RecordedState::Errored(panicked.to_string()),
        };
        RecordedReport {
            recorded: Arc::new(recorded.clone()),
            key: key.to_string(),
            state,
            wall_time: begun.elapsed(),
        }
    }

    fn rerun(&self, suite: usize, key: &str, recorded: &Recorded) -> RecordedState {
        let declared = &self.suites[suite].suite;
        let revived = corpus::revive(recorded, declared)
            .and_then(|case| Ok((case, corpus::criteria(recorded, declared)?)));
        let (mut case, criteria) = match revived {
            Ok(revived) => revived,
            Err(stale) => return RecordedState::Skipped(Skip::Stale(stale.to_string())),
        };
        case.key = key.to_string();
        let outcome = match self.case(suite, &case) {
            Ok(ran) => {
                self.watched(&case, &ran);
                ran.outcome
            }
            Err(error) => return RecordedState::Errored(self.told(suite, &recorded.scenario, &error)),
        };
        let (decisive, others): (Vec<_>, Vec<_>) =
            criteria.iter().filter_map(per_run).partition(|one| one.decisive);
        let judged = |criteria: Vec<PerRun>| {
            let criteria: Vec<_> = criteria.into_iter().map(|one| one.criterion).collect();
            judge(&criteria, std::slice::from_ref(&outcome), &self.requests)
        };
        let (decided, others) = (judged(decisive), judged(others));
        RecordedState::Ran(Box::new(Rerun {
            same_case: case_hash(&case) == recorded.case,
            judged: decided,
            against: others.findings.into_iter().filter(|one| one.verdict != Verdict::Passed).collect(),
            outcome,
        }))
    }

    /// Runs one block, which finds what it needs in `results`.
    pub fn block(
        &self,
        suite: usize,
        block: &Arc<Block>,
        results: &EarlierResults,
        progress: &dyn Progress,
    ) -> BlockReport {
        let begun = Instant::now();
        let laboratory = &self.laboratories[suite];
        let state = match Panicked::catch(|| run_block(block, laboratory, results, progress)) {
            Ok(Ok(result)) => BlockState::Finished(Box::new(result)),
            Ok(Err(ExperimentError::Stopped)) => {
                BlockState::NotFinished(Cut::Block(match &laboratory.journals {
                    Some(folder) => {
                        format!("interrupted; the same command goes on from {}", folder.display())
                    }
                    None => "interrupted".to_string(),
                }))
            }
            Ok(Err(error)) => BlockState::Errored(match error.hint() {
                Some(hint) => format!("{error} ({hint})"),
                None => error.to_string(),
            }),
            Err(panicked) => BlockState::Errored(panicked.to_string()),
        };
        let key = block.key(&self.suites[suite].suite.name);
        BlockReport { block: block.clone(), key, state, wall_time: begun.elapsed() }
    }
}

impl<'a> Workshop<'a> {
    /// The report of a unit that is not run.
    pub fn skipped(&self, unit: &Unit<'a>, reason: Skip) -> UnitReport {
        match &unit.work {
            Work::Recorded(recorded) => UnitReport::Recorded(RecordedReport {
                recorded: Arc::new((*recorded).clone()),
                key: unit.key.to_string(),
                state: RecordedState::Skipped(reason),
                wall_time: Duration::ZERO,
            }),
            Work::Trial(trial) => UnitReport::Trial(TrialReport {
                trial: trial.trial.clone(),
                outcomes: Vec::new(),
                state: TrialState::Skipped(reason),
                departures: departures(trial),
                wall_time: Duration::ZERO,
            }),
            Work::Block(block) => UnitReport::Block(BlockReport {
                block: block.clone(),
                key: unit.key.to_string(),
                state: BlockState::Skipped(reason),
                wall_time: Duration::ZERO,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;
    use crate::files::Disk;
    use crate::lang;
    use crate::models::standard;
    use crate::plan::plan;

    /// There may be a million runs: each holds what it has of its own, and of that what somebody may still ask for.
    #[test]
    fn of_a_run_no_more_is_kept_than_its_trial_needs() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/zebra/carla_walker.scn");
        let suite = lang::load(&path, &standard(), &Disk)
            .unwrap_or_else(|_| panic!("{} is a scenario", path.display()))
            .suite;
        let plan = plan(&suite).unwrap();
        let suites = [PlannedSuite { file: "walker.scn".into(), suite, plan, recorded: Vec::new() }];
        let workshop = Workshop::new(&suites, None, &Stop::default(), &standard());
        let trial = &suites[0].plan.trials[0];
        let report = workshop.trial(0, &SharedTrial::new(trial), &|| ());
        let asked: Vec<_> = trial.criteria.iter().map(|one| one.claim.metric()).collect();
        let (mut kept, mut dropped) = (0, 0);
        for outcome in &report.outcomes {
            for (index, reference) in workshop.requests().iter().enumerate() {
                match outcome.critical.get(index) {
                    Some(_) => {
                        assert!(
                            asked.contains(&reference),
                            "nobody asks for the moment of {}",
                            reference.name()
                        );
                        kept += 1;
                    }
                    None => dropped += usize::from(outcome.metrics[index].is_some()),
                }
            }
            let walker = &outcome.presences[0].0;
            assert!(Arc::ptr_eq(walker, &report.outcomes[0].presences[0].0), "each run has names of its own");
        }
        assert!(kept > 0 && dropped > 0, "{kept} kept, {dropped} dropped");
    }
}
