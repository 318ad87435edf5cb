//! Runs that were made before somebody asks for them.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::executor::{Executor, Round};
use super::job::{Done, Job, JobPlace, Ran, Wanted};
use results::Outcome;
use scenario::Case;
use under_test::ProgramUse;

/// Another executor, asked for all runs but those that are remembered: each of them is given back once, where no more than its outcome is
/// wanted.
pub struct Remembered<'e> {
    executor: &'e dyn Executor,
    /// Whether somebody was given the course of each.
    watched: bool,
    /// By their names.
    runs: Mutex<HashMap<String, (Case, Outcome)>>,
}

impl<'e> Remembered<'e> {
    /// With nothing remembered yet.
    pub fn new(executor: &'e dyn Executor) -> Self {
        Self { executor, watched: false, runs: Mutex::default() }
    }

    /// With courses of which somebody was told when the runs were made: whoever wants them gets none.
    #[must_use]
    pub fn watched(self, watched: bool) -> Self {
        Self { watched, ..self }
    }

    /// What a run came to, if it is remembered; then it is no more.
    pub fn recall(&self, case: &Case) -> Option<Outcome> {
        let mut runs = self.lock();
        // Suites of the same name may have runs of the same name.
        runs.get(&case.key).filter(|(known, _)| known == case)?;
        runs.remove(&case.key).map(|(_, outcome)| outcome)
    }

    /// Remembers what a run came to.
    pub fn keep(&self, case: Case, outcome: Outcome) {
        self.lock().insert(case.key.clone(), (case, outcome));
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<String, (Case, Outcome)>> {
        self.runs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take(&self, job: &Job) -> Option<Done> {
        let is_enough = job.wanted == Wanted::Outcome || self.watched && job.wanted == Wanted::Trace;
        if !is_enough || job.alone || job.change.is_some() {
            return None;
        }
        let outcome = self.recall(&job.case)?;
        let ran = Ran {
            outcome,
            trace: sim::Trace::default(),
            events: Vec::new(),
            decisions: Vec::new(),
            commands: Vec::new(),
            details: None,
        };
        Some(Done { place: job.place, case: job.case.clone(), result: Ok(ran) })
    }
}

impl Executor for Remembered<'_> {
    fn run(&self, round: &mut dyn Round) {
        self.executor.run(&mut Answered { round, remembered: self });
    }

    fn parallelism(&self) -> usize {
        self.executor.parallelism()
    }

    fn program_uses(&self) -> Vec<ProgramUse> {
        self.executor.program_uses()
    }

    fn host(&self, work: &mut (dyn FnMut() + Send)) {
        self.executor.host(work);
    }
}

/// A round of which some runs need not be made.
struct Answered<'r, 'e> {
    round: &'r mut dyn Round,
    remembered: &'r Remembered<'e>,
}

impl Round for Answered<'_, '_> {
    fn next(&mut self) -> Option<Job> {
        loop {
            let job = self.round.next()?;
            match self.remembered.take(&job) {
                Some(done) => self.round.done(done),
                None => return Some(job),
            }
        }
    }

    fn done(&mut self, done: Done) {
        self.round.done(done);
    }

    fn is_wanted(&mut self, place: JobPlace) -> bool {
        self.round.is_wanted(place)
    }
}
