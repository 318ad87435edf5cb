//! One run that somebody asks for, as plain data, and what comes of it.

use std::sync::Arc;

use super::build::RunError;
use super::case::{Unwatched, run_case};
use super::free_flow::FreeFlows;
use super::panic::Panicked;
use results::{Outcome, Requests};
use scenario::Case;
use sim::{Ending, Observer, Snapshot, Step, Timeline, TimelineEvent, Trace};

/// What is read off runs, with what runs from the same start share.
#[derive(Debug, Default)]
pub struct MeasuredMetrics {
    /// The metrics, in the order of every outcome's values.
    pub requests: Requests,
    /// Worked out again wherever they are not known: they only save time.
    pub free_flows: FreeFlows,
}

impl MeasuredMetrics {
    /// Of metrics of which nothing is known in free flow.
    pub fn new(requests: Requests) -> Arc<Self> {
        Arc::new(Self { requests, free_flows: FreeFlows::default() })
    }
}

/// What is wanted of a run besides its outcome.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wanted {
    /// Nothing more.
    #[default]
    Outcome,
    /// And where everybody was at every step.
    Trace,
    /// And what happened.
    TraceAndEvents,
}

/// Where in its [`Round`](super::Round) a run belongs, to whoever asked for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct JobPlace {
    /// Which of the sequences of runs that are made side by side.
    pub sequence: usize,
    /// Which run of the sequence.
    pub run: usize,
}

/// A run to be made: plain data, so that it may be made on any thread, or by another process.
#[derive(Debug, Clone)]
pub struct Job {
    /// Handed back with what comes of the job.
    pub place: JobPlace,
    /// Everything that decides the run.
    pub case: Case,
    /// What is read off it.
    pub measured: Arc<MeasuredMetrics>,
    /// What is told of it besides the outcome.
    pub wanted: Wanted,
}

/// What came of a job.
#[derive(Debug)]
pub struct Done {
    /// That of the job.
    pub place: JobPlace,
    /// That of the job.
    pub case: Case,
    /// The run, or why it did not come to its end.
    pub result: Result<Ran, JobFailure>,
}

/// What came of a run that came to its end.
#[derive(Debug)]
pub struct Ran {
    /// What the run came to.
    pub outcome: Outcome,
    /// Empty unless it was wanted, as are the events.
    pub trace: Trace,
    /// In the order of time.
    pub events: Vec<TimelineEvent>,
}

/// Why a run did not come to its end.
#[derive(Debug)]
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
        let Self { place, case, measured, wanted } = self;
        let MeasuredMetrics { requests, free_flows } = &*measured;
        let run = || match wanted {
            Wanted::Outcome => {
                let outcome = run_case(&case, requests, free_flows, &mut Unwatched)?;
                Ok(Ran { outcome, trace: Trace::default(), events: Vec::new() })
            }
            Wanted::Trace => {
                let mut trace = Trace::default();
                let outcome = run_case(&case, requests, free_flows, &mut trace)?;
                Ok(Ran { outcome, trace, events: Vec::new() })
            }
            Wanted::TraceAndEvents => {
                let mut both = Both { timeline: Timeline::new(&case.world), trace: Trace::default() };
                let outcome = run_case(&case, requests, free_flows, &mut both)?;
                Ok(Ran { outcome, trace: both.trace, events: both.timeline.into_events() })
            }
        };
        let result = match Panicked::catch(run) {
            Ok(ran) => ran.map_err(JobFailure::Error),
            Err(panicked) => Err(JobFailure::Panicked(panicked)),
        };
        Done { place, case, result }
    }
}

struct Both<'a> {
    timeline: Timeline<'a>,
    trace: Trace,
}

impl Observer for Both<'_> {
    fn begin(&mut self, start: &Snapshot) {
        self.timeline.begin(start);
        self.trace.begin(start);
    }

    fn observe(&mut self, step: &Step) {
        self.timeline.observe(step);
        self.trace.observe(step);
    }

    fn end(&mut self, ending: &Ending, last: &Snapshot) {
        self.timeline.end(ending, last);
        self.trace.end(ending, last);
    }
}
