//! Runs of which the results are there: an executor that answers from them. What is not there is made by another one and kept, or refused.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, Scope};
use std::time::{Duration, Instant};

use super::executor::{Executor, Round};
use super::job::{Done, Job, JobPlace, Wanted, programs};
use super::panic::Panicked;
use super::run_digest::{RunDigest, RunDigests};
use super::shared_rounds::{AbsentRun, Pace, Sharing, Turn, Waiting};
use super::stop::Stop;
use super::stored_run::StoredRun;
use scenario::DeclaredProgram;
use under_test::{AnswerClock, ProgramUse};

/// Results by the digests of their runs, to be read from several threads.
pub trait RunResults: Sync {
    /// What came of a run; `None` if it is not there.
    ///
    /// # Errors
    /// In words, if it is there and cannot be read.
    fn find(&self, run: &RunDigest) -> Result<Option<StoredRun>, String>;

    /// Takes in what came of a run that was not there.
    fn keep(&self, run: RunDigest, stored: StoredRun);

    /// Whether there is something of a run, without asking for it.
    fn holds(&self, run: &RunDigest) -> bool {
        matches!(self.find(run), Ok(Some(_)))
    }

    /// Forgets what is there of a run, which says of itself that it is of another one: `key` will be made.
    fn forget(&self, run: &RunDigest, key: &str) {
        let _ = (run, key);
    }

    /// Looks at what others have made since, who make the same runs at the same time; not each time that it is asked, and more often with `now`, before
    /// a run is made that is another's. `run` is how long one takes.
    fn sharing(&self, run: Duration, now: bool) -> Sharing {
        let _ = (run, now);
        Sharing::ALONE
    }
}

/// What happens with runs of which there is no result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AbsentRuns {
    /// They are made, and kept; and so are those of which what is there is of another run.
    Made,
    /// Nothing more begins: results without them would be of something else.
    Refused,
}

/// So many runs are looked up together by another thread.
const TOGETHER: usize = 64;

/// So long nobody looks at what others have made, who waits for them.
const MOMENT: Duration = Duration::from_millis(2);

/// Another executor, asked for those runs alone of which there is no result, or of which more is wanted than was kept. The latter must come to
/// what was kept, to the bit.
pub struct FromResults<'e> {
    executor: &'e dyn Executor,
    digests: &'e RunDigests,
    results: &'e dyn RunResults,
    absent: AbsentRuns,
    /// How many threads look runs up before a session asks for them.
    ahead: usize,
    stop: Stop,
    uses: Vec<(Arc<DeclaredProgram>, String)>,
    troubles: Mutex<Vec<String>>,
    /// Of the runs that are made.
    pace: Pace,
    /// Rounds under way.
    rounds: AtomicUsize,
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
        Self {
            executor,
            digests,
            results,
            absent,
            ahead: 0,
            stop: stop.clone(),
            uses: Vec::new(),
            troubles: Mutex::default(),
            pace: Pace::new(),
            rounds: AtomicUsize::new(0),
        }
    }

    /// With so many threads that look up what may be asked for next, so that results are asked for of which nobody turns out to have need.
    pub fn reading_ahead(self, threads: usize) -> Self {
        Self { ahead: threads, ..self }
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
        self.rounds.fetch_add(1, Ordering::Relaxed);
        thread::scope(|scope| {
            self.executor.run(&mut AnsweredRound {
                round,
                all: self,
                under_way: HashMap::new(),
                found: VecDeque::new(),
                waiting: Waiting::default(),
                ahead: Ahead { scope, readers: None, asked: 0, given: 0, told: BTreeMap::new() },
            });
        });
        self.rounds.fetch_sub(1, Ordering::Relaxed);
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

struct AnsweredRound<'r, 's, 'v, 'e> {
    round: &'r mut dyn Round,
    all: &'s FromResults<'e>,
    under_way: HashMap<JobPlace, UnderWay>,
    /// What comes next, in the order of the round.
    found: VecDeque<FoundRun>,
    /// What nobody has made, as far as is known.
    waiting: Waiting,
    ahead: Ahead<'s, 'v>,
}

struct UnderWay {
    run: RunDigest,
    wanted: Wanted,
    /// What was kept, of which more is wanted.
    known: Option<StoredRun>,
}

/// A run that was looked up.
struct FoundRun {
    job: Job,
    run: RunDigest,
    known: Result<Option<StoredRun>, String>,
    /// To find it.
    took: Duration,
}

/// What other threads look up, some runs at a time.
struct Ahead<'s, 'v> {
    scope: &'s Scope<'s, 'v>,
    readers: Option<Readers>,
    /// How many times some were asked for, and given back in their order.
    asked: usize,
    given: usize,
    told: BTreeMap<usize, Vec<FoundRun>>,
}

struct Readers {
    ask: Sender<(usize, Vec<Job>)>,
    told: Receiver<(usize, Vec<FoundRun>)>,
}

impl FromResults<'_> {
    fn look_up(&self, job: Job) -> FoundRun {
        let begun = Instant::now();
        // A thread that panicked would be waited for in vain.
        let found = Panicked::catch(|| {
            let run = self.digests.of(&job);
            (run, self.results.find(&run))
        });
        let (run, known) = found.unwrap_or_else(|panicked| (RunDigest([0; 32]), Err(panicked.to_string())));
        FoundRun { job, run, known, took: begun.elapsed() }
    }

    fn look_up_all(&self, jobs: Vec<Job>) -> Vec<FoundRun> {
        jobs.into_iter().map(|job| self.look_up(job)).collect()
    }
}

impl<'s> Ahead<'s, '_> {
    /// Threads that end with what asks them.
    fn readers(&mut self, all: &'s FromResults) -> &Readers {
        let scope = self.scope;
        self.readers.get_or_insert_with(|| {
            let ((ask, asked), (tell, told)) = (channel::<(usize, Vec<Job>)>(), channel());
            let asked = Arc::new(Mutex::new(asked));
            for _ in 0..all.ahead {
                let (asked, tell) = (asked.clone(), tell.clone());
                scope.spawn(move || {
                    let next = || asked.lock().unwrap_or_else(PoisonError::into_inner).recv();
                    while let Ok((number, jobs)) = next() {
                        if tell.send((number, all.look_up_all(jobs))).is_err() {
                            break;
                        }
                    }
                });
            }
            Readers { ask, told }
        })
    }

    fn ask(&mut self, all: &'s FromResults, jobs: Vec<Job>) {
        let number = self.asked;
        self.asked += 1;
        if let Err(unasked) = self.readers(all).ask.send((number, jobs)) {
            self.told.insert(number, all.look_up_all(unasked.0.1));
        }
    }

    /// The next of what was asked for, waited for if need be.
    fn next(&mut self) -> Option<Vec<FoundRun>> {
        loop {
            if let Some(found) = self.told.remove(&self.given) {
                self.given += 1;
                return Some(found);
            }
            let readers = self.readers.as_ref().filter(|_| self.given < self.asked)?;
            let (number, found) = readers.told.recv().expect("whoever was asked answers, or has panicked");
            self.told.insert(number, found);
        }
    }
}

impl AnsweredRound<'_, '_, '_, '_> {
    /// The next run that the round wants, looked up.
    fn found(&mut self) -> Option<FoundRun> {
        if self.all.ahead == 0 {
            return self.round.next().map(|job| self.all.look_up(job));
        }
        loop {
            if let Some(found) = self.found.pop_front() {
                // By what those before it came to it may not be needed.
                if self.round.is_wanted(found.job.place) {
                    return Some(found);
                }
                continue;
            }
            while self.ahead.asked - self.ahead.given <= self.all.ahead {
                let jobs = self.some();
                let is_last = jobs.len() < TOGETHER;
                match jobs.is_empty() {
                    true => {}
                    // Of few there is nothing to share out.
                    false if is_last && self.ahead.asked == self.ahead.given => {
                        self.found = self.all.look_up_all(jobs).into();
                    }
                    false => self.ahead.ask(self.all, jobs),
                }
                if is_last {
                    break;
                }
            }
            if self.found.is_empty() {
                self.found = self.ahead.next()?.into();
            }
        }
    }

    fn some(&mut self) -> Vec<Job> {
        let mut jobs = Vec::new();
        while let Some(job) = if jobs.len() < TOGETHER { self.round.next() } else { None } {
            jobs.push(job);
        }
        jobs
    }
}

impl AnsweredRound<'_, '_, '_, '_> {
    /// Answers a run that was looked up, or gives it back if it is absent, unless nothing more begins.
    fn settle(&mut self, found: FoundRun) -> ControlFlow<(), Option<AbsentRun>> {
        let FoundRun { job, run, known, took } = found;
        let known = match known {
            Ok(Some(stored)) if !stored.is_of(&job) => match self.all.absent {
                AbsentRuns::Made => {
                    self.all.results.forget(&run, &job.case.key);
                    None
                }
                AbsentRuns::Refused => {
                    self.all.end_with(format!(
                        "what is kept as the result of {} is of another run",
                        job.case.key
                    ));
                    return ControlFlow::Break(());
                }
            },
            Ok(Some(stored)) if stored.is_enough(job.wanted) => {
                let Job { place, case, wanted, .. } = job;
                self.round.done(Done { place, case, result: stored.told(wanted, took) });
                return ControlFlow::Continue(None);
            }
            Ok(None) if self.all.absent == AbsentRuns::Refused => {
                self.all.end_with(format!("there is no result of {}", job.case.key));
                return ControlFlow::Break(());
            }
            Ok(known) => known,
            Err(why) => {
                self.all.end_with(format!("{}: {why}", job.case.key));
                return ControlFlow::Break(());
            }
        };
        ControlFlow::Continue(Some(AbsentRun { job, run, known }))
    }

    /// The next run of the round that is absent.
    fn absent(&mut self) -> Option<AbsentRun> {
        loop {
            let found = self.found()?;
            match self.settle(found) {
                ControlFlow::Continue(None) => {}
                ControlFlow::Continue(absent) => return absent,
                ControlFlow::Break(()) => return None,
            }
        }
    }

    /// Answers those that others have made since, and has as many wait as there should.
    fn renew(&mut self, sharing: &Sharing) {
        if sharing.heard != self.waiting.heard {
            self.waiting.heard = sharing.heard;
            let is_made = |one: &AbsentRun| one.known.is_none() && self.all.results.holds(&one.run);
            let (made, left) = std::mem::take(&mut self.waiting.runs).into_iter().partition(is_made);
            self.waiting.runs = left;
            let made: Vec<AbsentRun> = made;
            for AbsentRun { job, run, .. } in made {
                self.waiting.since = None;
                let begun = Instant::now();
                let known = self.all.results.find(&run);
                let found = FoundRun { job, run, known, took: begun.elapsed() };
                if let ControlFlow::Continue(Some(absent)) = self.settle(found) {
                    self.waiting.runs.push(absent);
                }
            }
        }
        let most = Waiting::most(sharing, self.all.parallelism(), self.all.pace.run());
        while self.waiting.runs.len() < most {
            let Some(absent) = self.absent() else { break };
            self.waiting.runs.push(absent);
        }
    }

    /// Whether a moment was waited for a run that another worker is likely to be making: only where nobody here has anything else to do, and where this
    /// worker has made something of the round, so that the other one is not far behind.
    fn has_waited(&mut self, sharing: &Sharing) -> bool {
        let is_idle = sharing.may_wait
            && self.under_way.is_empty()
            && self.waiting.given > 0
            && self.all.rounds.load(Ordering::Relaxed) == 1
            && !self.all.stop.is_requested();
        let since = *self.waiting.since.get_or_insert_with(Instant::now);
        if is_idle && self.all.pace.may_wait(since.elapsed()) {
            thread::sleep(MOMENT);
            return true;
        }
        self.all.pace.waited_in_vain(since.elapsed());
        self.waiting.since = None;
        false
    }
}

impl Round for AnsweredRound<'_, '_, '_, '_> {
    fn next(&mut self) -> Option<Job> {
        let all = self.all;
        let mut sharing = all.results.sharing(all.pace.run(), false);
        let mut is_new = false;
        loop {
            self.renew(&sharing);
            let at = match self.waiting.turn(&sharing, all.parallelism()) {
                Turn::Nobody => return None,
                Turn::Own(at) => at,
                Turn::Others(_) | Turn::Begun(_) if !is_new => {
                    sharing = all.results.sharing(all.pace.run(), true);
                    is_new = true;
                    continue;
                }
                Turn::Begun(_) if self.has_waited(&sharing) => {
                    is_new = false;
                    continue;
                }
                Turn::Others(at) | Turn::Begun(at) => at,
            };
            let AbsentRun { job, run, known } = self.waiting.runs.remove(at);
            // By what those before it came to it may not be needed.
            if self.round.is_wanted(job.place) {
                (self.waiting.given, self.waiting.since) = (self.waiting.given + 1, None);
                self.under_way.insert(job.place, UnderWay { run, wanted: job.wanted, known });
                return Some(job);
            }
        }
    }

    fn done(&mut self, done: Done) {
        if let Ok(ran) = &done.result {
            self.all.pace.took(ran.outcome.wall_time);
        }
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
    let known = known.outcome_alone();
    let is_told = again.has_ended() && programs(&done.case).iter().any(|program| !program.is_known_whole());
    !is_told && again.to_bytes() != known.to_bytes()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::plan::plan;
    use crate::run::MeasuredMetrics;
    use files::Memory;
    use models::standard;
    use results::{Outcome, Requests};

    /// A run in which that controller decides.
    fn job(declared: &str, controller: &str) -> Job {
        let text = format!(
            "{declared}
scenario meet {{
  road {{ lane_width 4 m; speed_limit 30 km/h; crossing zebra }}
  vehicle av {{ controller {controller}; speed 30 km/h; start 30 m before crossing }}
  pedestrian walker {{ model scripted; start 2 m from kerb; appears at 0 s }}
  expect {{ max_deceleration <= 9 m/s^2 }}
}}
"
        );
        let files = Memory::default().with("meet.scn", text).with("own.wasm", "\0asm");
        let Ok(loaded) = lang::load(Path::new("meet.scn"), &standard(), &files) else {
            panic!("it is a scenario")
        };
        let case = plan(&loaded.suite).unwrap().trial(0).cases.first();
        let (place, measured) = (JobPlace::default(), MeasuredMetrics::new(Requests::defaults(&standard())));
        Job { place, case, measured, wanted: Wanted::Outcome, alone: false, change: None }
    }

    #[test]
    fn what_is_made_again_comes_to_what_was_kept_unless_a_command_is_told_of() {
        let built_in = job("", "constant_speed");
        let done = built_in.clone().run();
        let known = StoredRun::of(Wanted::Outcome, &done.result);
        assert!(known.is_of(&built_in) && !differs(&done, &known));
        let mut other = done.result.clone().unwrap();
        other.outcome.metrics[0] = Some(other.outcome.metrics[0].unwrap_or_default() + 1e-9);
        let place = JobPlace::default();
        for (declared, is_seen) in [
            (None, true),
            (Some("controller own { wasm \"own.wasm\" }"), true),
            (Some("controller own { command \"own\" }"), false),
        ] {
            let job = declared.map_or_else(|| built_in.clone(), |declared| job(declared, "own"));
            let again = Done { place, case: job.case.clone(), result: Ok(other.clone()) };
            assert_eq!(differs(&again, &known), is_seen, "{declared:?}");
            // Where nobody may start it, it comes to nothing, which is not told of as another decision.
            if declared.is_some() {
                assert!(job.clone().run().result.is_err() && differs(&job.run(), &known), "{declared:?}");
            }
        }
    }

    #[test]
    fn a_result_says_of_which_run_it_is() {
        let own = job("", "constant_speed");
        let result = own.clone().run().result.unwrap();
        let is_of = |change: fn(&mut Outcome)| {
            let mut changed = result.clone();
            change(&mut changed.outcome);
            StoredRun::of(Wanted::Outcome, &Ok(changed)).is_of(&own)
        };
        assert!(is_of(|_| ()));
        assert!(!is_of(|outcome| outcome.key += "0"));
        assert!(!is_of(|outcome| outcome.seed += 1));
        assert!(!is_of(|outcome| outcome.metrics.clear()));
        assert!(!is_of(|outcome| outcome.metrics.push(None)));
    }
}
