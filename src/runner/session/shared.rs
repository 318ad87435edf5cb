//! What the units of a session share: their suites, what is measured, and whatever makes their runs.

use std::mem;
use std::path::PathBuf;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use super::unit::{Unit, Work};
use crate::experiment::{
    BlockProgress, Context, EarlierResults, ExperimentError, Silent, asked_by, run_block, search_group,
};
use crate::plan::PlannedTrial;
use crate::project::PlannedSuite;
use crate::run::{
    Executor, FirstRuns, Job, JobPlace, MeasuredMetrics, Panicked, Ran, RunBatch, RunError, Stop, VerifyRuns,
    Wanted, departures,
};
use files::{Disk, Files};
use results::judge::measured_beside;
use results::{
    BlockReport, BlockState, Cut, Outcome, RecordedReport, RecordedState, Requests, Skip, SuiteIdentity,
    TrialReport, TrialState, TriedSeed, UnitError, UnitReport,
};
use scenario::registry::Registry;
use scenario::{Block, Case, Search};
use sim::Trace;

/// Given the course of every run of a trial.
pub type RunWatch<'a> = dyn Fn(&Case, &Trace) + Sync + 'a;

/// Everything that units share.
pub struct Runner<'a> {
    suites: &'a [PlannedSuite],
    executor: &'a dyn Executor,
    /// What blocks share, one per suite.
    contexts: Vec<Context<'a>>,
    /// Every metric that has a default, or that anything in any of the suites asks for: all runs are measured alike.
    measured: Arc<MeasuredMetrics>,
    registry: Registry,
    files: Arc<dyn Files>,
    stop: Stop,
    watch: Option<&'a RunWatch<'a>>,
    /// Whether the wall time of trials is measured here.
    is_timed: bool,
    /// By suite.
    earlier_seeds: Vec<Vec<TriedSeed>>,
}

impl<'a> Runner<'a> {
    /// One whose runs `executor` makes. The suites name what is in `registry`.
    pub fn new(suites: &'a [PlannedSuite], executor: &'a dyn Executor, registry: &Registry) -> Self {
        let mut contexts: Vec<_> =
            suites.iter().map(|suite| Context::new(&suite.suite, executor, registry)).collect();
        let mut requests = Requests::defaults(registry);
        for context in &contexts {
            context.requests().iter().for_each(|request| requests.add(request));
        }
        let measured = MeasuredMetrics::new(requests);
        contexts.iter_mut().for_each(|context| context.measured = measured.clone());
        let (registry, stop) = (registry.clone(), Stop::default());
        Self {
            suites,
            executor,
            contexts,
            measured,
            registry,
            files: Arc::new(Disk),
            stop,
            watch: None,
            is_timed: true,
            earlier_seeds: Vec::new(),
        }
    }

    /// With no other metrics than those that something in the suites asks for.
    pub fn measuring_what_is_asked(mut self) -> Self {
        let mut asked = Requests::default();
        for suite in self.suites {
            asked_by(&suite.suite).iter().for_each(|metric| asked.add(metric));
        }
        if let Some(beside) = measured_beside(&asked, &self.measured.requests) {
            asked.add(beside);
        }
        self.measured = self.measured.only(&asked);
        self.contexts.iter_mut().for_each(|context| context.measured = self.measured.clone());
        self
    }

    /// With a folder where searches and tunes keep what they have evaluated.
    pub fn journals(mut self, folder: PathBuf) -> Self {
        // What a program has decided is no evaluation to go on from: the program may be another by then.
        let lasting = self.contexts.iter_mut().filter(|context| context.suite.controllers.is_empty());
        lasting.for_each(|context| context.journals = Some(folder.clone()));
        self
    }

    /// With some of the runs in which programs decide made a second time; without this none is.
    pub fn verifying(mut self, verify: VerifyRuns) -> Self {
        self.contexts.iter_mut().for_each(|context| context.first_runs = FirstRuns::new(verify));
        self
    }

    /// With files other than those of the disk, in which blocks and gates find what they refer to.
    pub fn reading(mut self, files: &Arc<dyn Files>) -> Self {
        self.contexts.iter_mut().for_each(|context| context.files = files.clone());
        self.files = files.clone();
        self
    }

    /// With somebody who may wish that no more runs begin.
    pub fn stopped_by(mut self, stop: &Stop) -> Self {
        self.contexts.iter_mut().for_each(|context| context.stop = stop.clone());
        self.stop = stop.clone();
        self
    }

    /// With somebody who is given the course of every run of a trial.
    pub fn watched_by(mut self, watch: &'a RunWatch<'a>) -> Self {
        self.watch = Some(watch);
        self
    }

    /// Where the wall time of trials says nothing, such as over runs that were made before: no `time_limit` is kept but by those who made them.
    pub fn timeless(mut self) -> Self {
        self.is_timed = false;
        self
    }

    /// Whether the wall time of trials is measured here.
    pub(super) fn is_timed(&self) -> bool {
        self.is_timed
    }

    /// With the seeds that each suite was run with before, for reports to say.
    pub fn after_seeds(mut self, earlier: Vec<Vec<TriedSeed>>) -> Self {
        self.earlier_seeds = earlier;
        self
    }

    /// What the suites may name.
    pub fn registry(&self) -> &Registry {
        &self.registry
    }

    /// Where what blocks and gates refer to is read.
    pub fn files(&self) -> &dyn Files {
        &*self.files
    }

    /// What is measured in every run, in the order of the outcomes' metrics.
    pub fn requests(&self) -> &Requests {
        &self.measured.requests
    }

    /// Whatever makes the runs.
    pub fn executor(&self) -> &'a dyn Executor {
        self.executor
    }

    /// For runs besides those of the units.
    pub fn batch(&self) -> RunBatch<'_> {
        RunBatch { executor: self.executor, measured: &self.measured, stop: &self.stop }
    }

    /// What there is to tell besides the results, such as that the end of a journal was cut off.
    pub fn notices(&self) -> Vec<String> {
        let notices = self.contexts.iter().map(|one| &one.notices);
        let taken =
            notices.map(|notices| mem::take(&mut *notices.lock().unwrap_or_else(PoisonError::into_inner)));
        taken.flatten().collect()
    }

    /// The wish that no more runs begin.
    pub fn stop(&self) -> &Stop {
        &self.stop
    }

    /// The suites that are run, in their order.
    pub fn suites(&self) -> &'a [PlannedSuite] {
        self.suites
    }

    /// How reports call the suite of this index, and how to run it again.
    pub fn identity(&self, suite: usize) -> SuiteIdentity {
        let prepared = &self.suites[suite];
        SuiteIdentity {
            suite: prepared.suite.key_name(),
            file: prepared.file.clone(),
            seed: prepared.plan.seed,
            set: prepared.suite.set.clone(),
            tested: prepared.suite.tested.clone(),
            earlier_seeds: self.earlier_seeds.get(suite).cloned().unwrap_or_default(),
            texts: prepared.suite.texts.clone(),
        }
    }

    /// The runs of a suite that are made a second time.
    pub(crate) fn first_runs(&self, suite: usize) -> &FirstRuns {
        &self.contexts[suite].first_runs
    }

    /// A run of a unit.
    pub(crate) fn job(&self, place: JobPlace, case: Case, wanted: Wanted) -> Job {
        let wanted = self.wanted(wanted);
        Job { place, case, measured: self.measured.clone(), wanted, alone: false, change: None }
    }

    /// What is wrong with the run of a case, in the units of the scenario; if it had begun, with how to see it again.
    pub(super) fn told(&self, suite: usize, case: &Case, error: &RunError) -> String {
        let scenario = self.suites[suite].suite.scenario(&case.scenario);
        let told = scenario.map_or_else(|| error.to_string(), |scenario| error.told(scenario));
        if !error.had_begun() {
            return told;
        }
        let help = error.hint().map_or_else(String::new, |hint| format!("\nhelp: {hint}"));
        format!("{told}{help}\nreplay: {}", self.identity(suite).replay_command(&case.key))
    }

    /// What is wanted of a run: its course, too, if somebody is given that.
    pub(super) fn wanted(&self, wanted: Wanted) -> Wanted {
        if self.watch.is_some() { Wanted::Trace } else { wanted }
    }

    /// Gives the course of a run to whoever wants it; one that is remembered has none, and was given before.
    pub(super) fn watched(&self, case: &Case, ran: &Ran) {
        if let Some(watch) = self.watch.filter(|_| !ran.trace.samples.is_empty()) {
            watch(case, &ran.trace);
        }
    }

    /// Runs one block, which finds what it needs in `results`.
    pub(super) fn block(
        &self,
        suite: usize,
        block: &Arc<Block>,
        results: &EarlierResults,
        progress: &dyn BlockProgress,
    ) -> BlockReport {
        let begun = Instant::now();
        let context = &self.contexts[suite];
        let state = match Panicked::catch(|| run_block(block, context, results, progress)) {
            Ok(Ok(result)) => BlockState::Finished(Box::new(result)),
            Ok(Err(ExperimentError::Stopped)) => {
                BlockState::NotFinished(Cut::Block(match &context.journals {
                    Some(folder) => {
                        format!("interrupted; the same command goes on from {}", folder.display())
                    }
                    None => "interrupted".to_string(),
                }))
            }
            Ok(Err(error)) => {
                let message = match error.hint() {
                    Some(hint) => format!("{error} ({hint})"),
                    None => error.to_string(),
                };
                let faults: Vec<_> = error.run_fault().into_iter().collect();
                BlockState::Errored(UnitError { message, faults, finished: Vec::new() })
            }
            Err(panicked) => BlockState::Errored(panicked.to_string().into()),
        };
        let key = block.key(&self.suites[suite].suite.key_name());
        BlockReport { block: block.clone(), key, state, wall_time: begun.elapsed() }
    }

    /// Makes the runs of a search that are for one of its groups of people.
    pub(crate) fn search_group(&self, suite: usize, search: &Search, group: usize) {
        // Whoever searches for all comes to the same error, and tells it.
        let _ = Panicked::catch(|| search_group(&self.contexts[suite], search, group, &Silent));
    }

    /// The report of a trial of which some runs were made, and no more are.
    pub(super) fn cut_off(trial: &PlannedTrial, outcomes: Vec<Outcome>, cut: Cut) -> UnitReport {
        UnitReport::Trial(TrialReport {
            trial: trial.trial.clone(),
            outcomes,
            state: TrialState::NotFinished(cut),
            departures: departures(trial),
            wall_time: Duration::ZERO,
        })
    }

    /// The report of a unit that is not run.
    pub fn skipped(&self, unit: &Unit<'a>, reason: Skip) -> UnitReport {
        match &unit.work {
            Work::Recorded(recorded) => UnitReport::Recorded(RecordedReport {
                recorded: Arc::new((*recorded).clone()),
                key: unit.key.clone(),
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
                key: unit.key.clone(),
                state: BlockState::Skipped(reason),
                wall_time: Duration::ZERO,
            }),
        }
    }
}
