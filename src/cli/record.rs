//! One run with everything there is to see of it.

use crate::results::{Outcome, Requests};
use crate::run::{FreeFlows, RunError, run_case};
use crate::scenario::Case;
use crate::sim::{Ending, Event, Observer, Snapshot, Step, Timeline, Trace};

/// A run's outcome with its course and its events.
pub struct Recorded {
    pub outcome: Outcome,
    pub trace: Trace,
    pub events: Vec<Event>,
}

/// Runs a case and records it; the outcome is that of an unwatched run.
pub fn record(case: &Case, requests: &Requests, free_flows: &FreeFlows) -> Result<Recorded, RunError> {
    let mut watchers = Watchers { timeline: Timeline::new(&case.world), trace: Trace::default() };
    let outcome = run_case(case, requests, free_flows, &mut watchers)?;
    Ok(Recorded { outcome, trace: watchers.trace, events: watchers.timeline.into_events() })
}

struct Watchers<'a> {
    timeline: Timeline<'a>,
    trace: Trace,
}

impl Observer for Watchers<'_> {
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
