//! One run that somebody asks for, as plain data, and what comes of it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::build::RunError;
use super::case::{Unwatched, run_changed};
use super::free_flow::FreeFlows;
use super::panic::Panicked;
use results::{Outcome, Requests};
use scenario::{Case, DeclaredProgram};
use sim::measure::{RecordedDetails, RunDetails};
use sim::{Ending, GivenCommand, Observer, RunChange, Snapshot, Step, Timeline, TimelineEvent, Trace};

/// What is read off runs, with what runs from the same start share.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct MeasuredMetrics {
    /// The metrics, in the order of every outcome's values.
    pub requests: Requests,
    /// Worked out again wherever they are not known: they only save time, and are not written down.
    #[serde(skip)]
    pub free_flows: Arc<FreeFlows>,
}

impl MeasuredMetrics {
    /// Of metrics of which nothing is known in free flow.
    pub fn new(requests: Requests) -> Arc<Self> {
        Arc::new(Self { requests, free_flows: Arc::default() })
    }

    /// Of those that are among the asked, with the same free flows.
    pub fn only(&self, asked: &Requests) -> Arc<Self> {
        Arc::new(Self { requests: self.requests.only(asked), free_flows: self.free_flows.clone() })
    }
}

/// What was asked for: what is known besides makes no difference.
impl PartialEq for MeasuredMetrics {
    fn eq(&self, other: &Self) -> bool {
        self.requests == other.requests
    }
}

/// What is wanted of a run besides its outcome.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Wanted {
    /// Nothing more.
    #[default]
    Outcome,
    /// And what programs decided.
    Decisions,
    /// And what programs decided, and where everybody was at every step.
    Trace,
    /// And what happened.
    TraceAndEvents,
    /// And what every vehicle was told.
    Commands,
    /// And what happened, and what reports draw besides.
    Details,
    /// And what happened, what every vehicle was told, and what reports draw besides.
    Everything,
}

impl Wanted {
    /// Whether what every vehicle was told is wanted.
    pub(super) fn has_commands(self) -> bool {
        matches!(self, Self::Commands | Self::Everything)
    }
}

/// Where in its [`Round`](super::Round) a run belongs, to whoever asked for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct JobPlace {
    /// Which of the sequences of runs that are made side by side.
    pub sequence: usize,
    /// Which run of the sequence.
    pub run: usize,
}

/// A run to be made: plain data, so that it may be made on any thread, or by another process. See [`Job::to_bytes`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Job {
    /// Handed back with what comes of the job.
    pub place: JobPlace,
    /// Everything that decides the run.
    pub case: Case,
    /// What is read off it.
    pub measured: Arc<MeasuredMetrics>,
    /// What is told of it besides the outcome.
    pub wanted: Wanted,
    /// Whether programs decide in no other run at the same time, in a process that has not made this run.
    #[serde(default)]
    pub alone: bool,
    /// What goes otherwise in it than the case has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub change: Option<Box<RunChange>>,
}

/// What came of a job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Done {
    /// That of the job.
    pub place: JobPlace,
    /// That of the job.
    pub case: Case,
    /// The run, or why it did not come to its end.
    pub result: Result<Ran, JobFailure>,
}

/// What came of a run that came to its end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ran {
    /// What the run came to.
    pub outcome: Outcome,
    /// Empty unless it was wanted, as are the events.
    pub trace: Trace,
    /// In the order of time.
    pub events: Vec<TimelineEvent>,
    /// What programs decided, in the order of time.
    #[serde(default)]
    pub decisions: Vec<LoggedDecision>,
    /// What each vehicle was told from time 0 on, where that was wanted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub commands: Vec<Vec<GivenCommand>>,
    /// What reports draw besides where everybody was, where that was wanted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub details: Option<Box<RunDetails>>,
}

/// What a program decided for a vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LoggedDecision {
    /// Its place among the vehicles of the world.
    pub vehicle: usize,
    /// On what was seen then, s.
    pub time: f64,
    /// An acceleration (m/s²); or throttle and brake; or times (s) and speeds (m/s) of a plan.
    pub values: Vec<f64>,
}

/// Why a run did not come to its end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum JobFailure {
    /// A model or a controller does not go on.
    Error(RunError),
    /// A bug: caught, so that the other runs go on.
    Panicked(Panicked),
}

impl Job {
    /// Makes the run. The outcome is the same whatever else is wanted.
    pub fn run(self) -> Done {
        let Self { place, case, measured, wanted, alone: _, change } = self;
        let MeasuredMetrics { requests, free_flows } = &*measured;
        let mut watcher = Watcher::new(wanted, &case, requests);
        let run = || {
            let otherwise = (change.as_deref(), wanted.has_commands());
            let (outcome, commands) = run_changed(&case, otherwise, requests, free_flows, &mut watcher)?;
            Ok(Ran { commands, ..watcher.ran(outcome) })
        };
        let result = match Panicked::catch(run) {
            Ok(ran) => ran.map_err(JobFailure::Error),
            Err(panicked) => Err(JobFailure::Panicked(panicked)),
        };
        Done { place, case, result }
    }

    /// The programs that decide in it, in the order of their names.
    pub(super) fn programs(&self) -> Vec<Arc<DeclaredProgram>> {
        programs(&self.case)
    }
}

/// The programs that decide in the run of a case, in the order of their names.
pub fn programs(case: &Case) -> Vec<Arc<DeclaredProgram>> {
    let models = case.world.vehicles.iter().filter_map(|car| car.controller.model.known());
    let mut programs: Vec<_> = models.filter_map(|model| model.program.clone()).collect();
    programs.sort_by(|one, other| (&one.name, &one.file).cmp(&(&other.name, &other.file)));
    programs.dedup();
    programs
}

/// What to say of a run that went differently when it was repeated.
pub enum WentDifferently {
    /// No program decides in it: a bug of ours.
    Bug(String),
    /// A program that decides in it is not deterministic.
    Program(String),
    /// A program that decides in it says that of itself.
    Known,
}

/// What is to blame for a run that went differently when it was repeated.
pub fn went_differently(case: &Case) -> WentDifferently {
    let (key, programs) = (&case.key, programs(case));
    if programs.is_empty() {
        return WentDifferently::Bug(format!(
            "{key} went differently when it was repeated: please report this"
        ));
    }
    if programs.iter().any(|program| program.may_differ()) {
        return WentDifferently::Known;
    }
    let names: Vec<_> = programs.iter().map(|program| format!("`{}`", program.name)).collect();
    WentDifferently::Program(format!(
        "W1102: {key} went differently when it was repeated: {} is not deterministic; `nondeterministic` in its declaration says \
         that this is known",
        names.join(" or ")
    ))
}

/// Sees what is wanted of a run besides its outcome.
pub(super) enum Watcher {
    Nothing(Unwatched),
    Trace(Trace),
    Both(Box<Timeline>, Trace),
    Details(Box<RecordedDetails>, Box<Timeline>, Trace),
}

impl Watcher {
    pub fn new(wanted: Wanted, case: &Case, requests: &Requests) -> Self {
        match wanted {
            Wanted::Outcome | Wanted::Decisions => Self::Nothing(Unwatched),
            Wanted::Trace => Self::Trace(Trace::default()),
            Wanted::TraceAndEvents | Wanted::Commands => {
                Self::Both(Box::new(Timeline::new(&case.world)), Trace::default())
            }
            Wanted::Details | Wanted::Everything => {
                let (details, timeline) =
                    (RecordedDetails::new(&case.world, requests.as_slice()), Timeline::new(&case.world));
                Self::Details(Box::new(details), Box::new(timeline), Trace::default())
            }
        }
    }

    /// What was wanted of a run with that outcome.
    pub fn ran(self, outcome: Outcome) -> Ran {
        let (trace, events, details) = match self {
            Self::Nothing(_) => Default::default(),
            Self::Trace(trace) => (trace, Vec::new(), None),
            Self::Both(timeline, trace) => (trace, timeline.into_events(), None),
            Self::Details(details, timeline, trace) => {
                (trace, timeline.into_events(), Some(Box::new(details.into_details())))
            }
        };
        Ran { outcome, trace, events, decisions: Vec::new(), commands: Vec::new(), details }
    }

    fn each(&mut self, tell: impl Fn(&mut dyn Observer)) {
        match self {
            Self::Nothing(nobody) => tell(nobody),
            Self::Trace(trace) => tell(trace),
            Self::Both(timeline, trace) => {
                tell(&mut **timeline);
                tell(trace);
            }
            Self::Details(details, timeline, trace) => {
                tell(&mut **details);
                tell(&mut **timeline);
                tell(trace);
            }
        }
    }
}

impl Observer for Watcher {
    fn begin(&mut self, start: &Snapshot) {
        self.each(|one| one.begin(start));
    }

    fn observe(&mut self, step: &Step) {
        self.each(|one| one.observe(step));
    }

    fn end(&mut self, ending: &Ending, last: &Snapshot) {
        self.each(|one| one.end(ending, last));
    }
}
