//! Runs of which the results are there: an executor that answers from them. What is not there is made by another one and kept, or refused.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::executor::{Executor, Round};
use super::job::{Done, Job, JobFailure, JobPlace, LoggedDecision, Ran, Wanted, programs};
use super::run_digest::{RunDigest, RunDigests};
use super::stop::Stop;
use results::Outcome;
use scenario::{DeclaredProgram, ProgramKind};
use under_test::{AnswerClock, ProgramUse};

/// What came of a run, without what depends on the clock: equal runs are equal bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredRun {
    /// Whether what programs decided is there.
    decisions: bool,
    result: Result<Ran, JobFailure>,
}

impl StoredRun {
    /// Of what came of a job of which that was wanted. Courses are not kept.
    pub fn of(wanted: Wanted, result: &Result<Ran, JobFailure>) -> Self {
        let decisions = !matches!(wanted, Wanted::Outcome);
        let result = result.as_ref().map_err(Clone::clone).map(|ran| {
            let mut outcome = ran.outcome.clone();
            outcome.wall_time = Duration::ZERO;
            bare(outcome, if decisions { ran.decisions.clone() } else { Vec::new() })
        });
        Self { decisions, result }
    }

    /// What [`Self::from_bytes`] reads: MessagePack with names of fields, which carries every number to its last bit.
    pub fn to_bytes(&self) -> Vec<u8> {
        rmp_serde::to_vec_named(self).expect("plain data is encoded, and memory takes it")
    }

    /// What [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// In the words of the decoder, if the bytes are something else.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        rmp_serde::from_slice(bytes).map_err(|error| error.to_string())
    }

    /// Whether it says of itself that it came of that job.
    fn is_of(&self, job: &Job) -> bool {
        self.result.as_ref().map_or(true, |Ran { outcome, .. }| {
            (outcome.key.as_str(), outcome.seed) == (job.case.key.as_str(), job.case.seed)
                && outcome.metrics.len() == job.measured.requests.iter().count()
        })
    }

    fn is_enough(&self, wanted: Wanted) -> bool {
        // A run that did not come to its end has nothing more to tell.
        self.result.is_err() || wanted == Wanted::Outcome || self.decisions && wanted == Wanted::Decisions
    }

    fn told(self, wanted: Wanted) -> Result<Ran, JobFailure> {
        self.result.map(|ran| match wanted {
            Wanted::Outcome => Ran { decisions: Vec::new(), ..ran },
            _ => ran,
        })
    }
}

/// Results by the digests of their runs, to be read from several threads.
pub trait RunResults: Sync {
    /// What came of a run; `None` if it is not there.
    ///
    /// # Errors
    /// In words, if it is there and cannot be read.
    fn find(&self, run: &RunDigest) -> Result<Option<StoredRun>, String>;

    /// Takes in what came of a run that was not there.
    fn keep(&self, run: RunDigest, stored: StoredRun);
}

/// What happens with runs of which there is no result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AbsentRuns {
    /// They are made, and kept.
    Made,
    /// Nothing more begins: results without them would be of something else.
    Refused,
}

/// Another executor, asked for those runs alone of which there is no result, or of which more is wanted than was kept. The latter must come to
/// what was kept, to the bit.
pub struct FromResults<'e> {
    executor: &'e dyn Executor,
    digests: &'e RunDigests,
    results: &'e dyn RunResults,
    absent: AbsentRuns,
    stop: Stop,
    uses: Vec<(Arc<DeclaredProgram>, String)>,
    troubles: Mutex<Vec<String>>,
}

impl<'e> FromResults<'e> {
    /// What is absent ends everything by `stop`, if it is refused.
    pub fn new(
        executor: &'e dyn Executor,
        digests: &'e RunDigests,
        results: &'e dyn RunResults,
        absent: AbsentRuns,
        stop: &Stop,
    ) -> Self {
        let (uses, troubles) = (Vec::new(), Mutex::default());
        Self { executor, digests, results, absent, stop: stop.clone(), uses, troubles }
    }

    /// With the programs that were asked when the results were made, and what they called themselves; how long they took is not known here.
    pub fn with_programs(self, uses: Vec<(Arc<DeclaredProgram>, String)>) -> Self {
        Self { uses, ..self }
    }

    /// Why what came of it all says nothing; empty if nothing is wrong.
    pub fn troubles(&self) -> Vec<String> {
        self.troubles.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn end_with(&self, trouble: String) {
        self.troubles.lock().unwrap_or_else(PoisonError::into_inner).push(trouble);
        self.stop.request();
    }
}

impl Executor for FromResults<'_> {
    fn run(&self, round: &mut dyn Round) {
        self.executor.run(&mut AnsweredRound { round, all: self, under_way: HashMap::new() });
    }

    fn parallelism(&self) -> usize {
        self.executor.parallelism()
    }

    fn program_uses(&self) -> Vec<ProgramUse> {
        if self.uses.is_empty() {
            return self.executor.program_uses();
        }
        let asked = |(program, title): &(Arc<DeclaredProgram>, String)| ProgramUse {
            program: program.clone(),
            title: title.clone(),
            answers: AnswerClock::default(),
        };
        self.uses.iter().map(asked).collect()
    }

    fn host(&self, work: &mut (dyn FnMut() + Send)) {
        self.executor.host(work);
    }
}

struct AnsweredRound<'r, 'e> {
    round: &'r mut dyn Round,
    all: &'r FromResults<'e>,
    under_way: HashMap<JobPlace, UnderWay>,
}

struct UnderWay {
    run: RunDigest,
    wanted: Wanted,
    /// What was kept, of which more is wanted.
    known: Option<StoredRun>,
}

impl Round for AnsweredRound<'_, '_> {
    fn next(&mut self) -> Option<Job> {
        loop {
            let job = self.round.next()?;
            let run = self.all.digests.of(&job);
            let known = match self.all.results.find(&run) {
                Ok(Some(stored)) if !stored.is_of(&job) => {
                    self.all.end_with(format!(
                        "what is kept as the result of {} is of another run",
                        job.case.key
                    ));
                    return None;
                }
                Ok(Some(stored)) if stored.is_enough(job.wanted) => {
                    let Job { place, case, wanted, .. } = job;
                    self.round.done(Done { place, case, result: stored.told(wanted) });
                    continue;
                }
                Ok(None) if self.all.absent == AbsentRuns::Refused => {
                    self.all.end_with(format!("there is no result of {}", job.case.key));
                    return None;
                }
                Ok(known) => known,
                Err(why) => {
                    self.all.end_with(format!("{}: {why}", job.case.key));
                    return None;
                }
            };
            self.under_way.insert(job.place, UnderWay { run, wanted: job.wanted, known });
            return Some(job);
        }
    }

    fn done(&mut self, done: Done) {
        match self.under_way.remove(&done.place) {
            Some(UnderWay { run, wanted, known: None }) => {
                self.all.results.keep(run, StoredRun::of(wanted, &done.result));
            }
            Some(UnderWay { known: Some(known), .. }) if differs(&done, &known) => {
                let key = &done.case.key;
                self.all.end_with(format!("{key} came to something else when it was made again here"));
            }
            _ => {}
        }
        self.round.done(done);
    }

    fn is_wanted(&mut self, place: JobPlace) -> bool {
        self.round.is_wanted(place)
    }
}

/// Whether a run came to something else than was kept of it, or to none. Commands that differ are told of by whoever asked.
fn differs(done: &Done, known: &StoredRun) -> bool {
    let again = StoredRun::of(Wanted::Outcome, &done.result);
    let known = StoredRun::of(Wanted::Outcome, &known.result);
    let may_differ = |program: &Arc<DeclaredProgram>| {
        matches!(program.kind, ProgramKind::Command(_)) || program.may_differ()
    };
    let is_told = again.result.is_ok() && programs(&done.case).iter().any(may_differ);
    !is_told && again.to_bytes() != known.to_bytes()
}

/// A run of which nothing else is told.
fn bare(outcome: Outcome, decisions: Vec<LoggedDecision>) -> Ran {
    Ran {
        outcome,
        decisions,
        trace: sim::Trace::default(),
        events: Vec::new(),
        commands: Vec::new(),
        details: None,
    }
}
