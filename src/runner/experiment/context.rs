//! What every experiment of a suite shares, and who is told how far it is.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::error::ExperimentError;
use super::needs::measured;
use crate::run::{Build, Executor, FirstRuns, MeasuredMetrics, Stop, VerifyRuns};
use files::{Disk, Files};
use results::Requests;
use scenario::registry::Registry;
use scenario::{MatchedRate, MetricReference, Scenario, Suite};

/// What every experiment of a suite shares.
pub struct Context<'a> {
    /// The suite that it is in.
    pub suite: &'a Suite,
    /// What is read off every run.
    pub measured: Arc<MeasuredMetrics>,
    /// What makes the runs.
    pub executor: &'a dyn Executor,
    /// Where what blocks refer to is read: saved cases and parameters.
    pub files: Arc<dyn Files>,
    /// Where journals are kept; `None` keeps none.
    pub journals: Option<PathBuf>,
    /// Looked at before every run.
    pub stop: Stop,
    /// Which of the runs in which programs decide are made a second time.
    pub first_runs: FirstRuns,
    /// What to tell whoever runs it, such as that the end of a journal was cut off.
    pub notices: Mutex<Vec<String>>,
    /// Worked out when it is first asked for.
    pub(super) program: OnceLock<Result<String, String>>,
}

impl<'a> Context<'a> {
    /// With every metric that has a default, and whatever else anything in the suite asks for.
    pub fn new(suite: &'a Suite, executor: &'a dyn Executor, registry: &Registry) -> Self {
        let mut requests = Requests::defaults(registry);
        asked_by(suite).iter().for_each(|metric| requests.add(metric));
        Self {
            suite,
            measured: MeasuredMetrics::new(requests),
            executor,
            files: Arc::new(Disk),
            journals: None,
            stop: Stop::default(),
            first_runs: FirstRuns::new(VerifyRuns::None),
            notices: Mutex::default(),
            program: OnceLock::new(),
        }
    }

    /// The same for runs of which nobody looks at any other metric than these; what there is to tell is told to the whole.
    pub(super) fn reading_only<'m>(&self, metrics: impl IntoIterator<Item = &'m MetricReference>) -> Self {
        let mut asked = Requests::default();
        metrics.into_iter().for_each(|metric| asked.add(metric));
        Self {
            suite: self.suite,
            measured: self.measured.only(&asked),
            executor: self.executor,
            files: self.files.clone(),
            journals: self.journals.clone(),
            stop: self.stop.clone(),
            first_runs: self.first_runs.clone(),
            notices: Mutex::default(),
            program: OnceLock::new(),
        }
    }

    pub(super) fn tell(&self, notice: Option<&str>) {
        let mut notices = self.notices.lock().unwrap_or_else(PoisonError::into_inner);
        notices.extend(notice.map(str::to_string));
    }

    /// Which program makes the runs: its own bytes decide. An error if they cannot be read.
    pub(super) fn program(&self) -> Result<&str, &str> {
        let identity = || Build::here().map(|build| build.identity()).map_err(|error| error.to_string());
        self.program.get_or_init(identity).as_deref().map_err(String::as_str)
    }

    /// What is measured in every run, in the order of the outcomes' metrics.
    pub fn requests(&self) -> &Requests {
        &self.measured.requests
    }

    pub(super) fn scenario(&self, name: &str) -> Result<&'a Scenario, ExperimentError> {
        self.suite
            .scenarios
            .iter()
            .chain(&self.suite.supporting)
            .find(|scenario| scenario.name == name)
            .ok_or_else(|| ExperimentError::UnknownScenario(name.to_string()))
    }
}

/// Every metric that anything in the suite asks for.
pub fn asked_by(suite: &Suite) -> Requests {
    let mut requests = Requests::default();
    suite.scenarios.iter().for_each(|scenario| requests.include(&scenario.criteria));
    for search in &suite.searches {
        requests.add(search.objective.aggregate.metric());
        search.kept_metrics().for_each(|(keep, _)| requests.add(&keep.metric));
        requests.include(&search.expect);
    }
    for tune in &suite.tunes {
        tune.objectives.iter().for_each(|objective| requests.add(objective.aggregate.metric()));
        tune.constraints.iter().for_each(|constraint| requests.add(&constraint.metric));
    }
    for evaluate in &suite.evaluates {
        evaluate.measures.iter().for_each(|measure| requests.add(measure.aggregate.metric()));
    }
    for estimate in &suite.estimates {
        [&estimate.event.metric].into_iter().chain(&estimate.score).for_each(|one| requests.add(one));
    }
    let rates = suite.calibrates.iter().flat_map(|calibrate| &calibrate.rates);
    rates.flat_map(MatchedRate::metrics).for_each(|metric| requests.add(metric));
    for statement in &suite.statements {
        measured(statement).iter().for_each(|one| requests.add(one.aggregate.metric()));
    }
    let rules = suite.gates.iter().flat_map(|gate| &gate.rules);
    rules.filter_map(|rule| rule.metric.as_ref()).for_each(|metric| requests.add(metric));
    suite.ratings.iter().for_each(|rating| requests.add(&rating.measure));
    requests
}

/// Told while an experiment runs, from several threads.
pub trait BlockProgress: Sync {
    /// `done` of `all` evaluations are finished; `best` is the best objective value so far, if there is one.
    fn evaluated(&self, done: usize, all: usize, best: Option<f64>);

    /// The same of an estimate: its value so far, and between what it lies at 95 %.
    fn evaluated_within(&self, done: usize, all: usize, value: f64, within: (f64, f64)) {
        let _ = within;
        self.evaluated(done, all, Some(value));
    }
}

/// Nobody watches.
pub struct Silent;

impl BlockProgress for Silent {
    fn evaluated(&self, _done: usize, _all: usize, _best: Option<f64>) {}
}
