//! Runs made on threads of this process.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rayon::{Scope, ThreadPool, ThreadPoolBuilder};

use super::executor::{Executor, Round};
use super::job::{Done, Job, JobPlace};
use super::lockstep::{JobSource, run_with_programs};
use scenario::DeclaredProgram;
use under_test::{ProcessPool, ProgramUse};

/// So many threads, whatever is run on them side by side.
pub struct Threads {
    pool: ThreadPool,
    /// Rounds and other work that want threads now.
    wanting: AtomicUsize,
    /// Where programs are that decide in runs.
    processes: Option<Arc<ProcessPool>>,
}

impl Threads {
    /// `threads` of them, at least one; fewer if the system gives no more.
    ///
    /// # Panics
    /// If it gives none.
    pub fn new(threads: usize) -> Self {
        let threads = threads.max(1);
        match ThreadPoolBuilder::new().num_threads(threads).build() {
            Ok(pool) => Self { pool, wanting: AtomicUsize::new(0), processes: None },
            Err(error) if threads == 1 => panic!("no thread can be started: {error}"),
            // Results do not depend on how many there are.
            Err(_) => Self::new(threads / 2),
        }
    }

    /// One for each core.
    pub fn all() -> Self {
        Self::new(std::thread::available_parallelism().map_or(1, usize::from))
    }

    /// The same, which asks the programs of a pool in runs in which programs decide; without one such runs are errors.
    pub fn with_processes(self, pool: Arc<ProcessPool>) -> Self {
        Self { processes: Some(pool), ..self }
    }

    /// How many threads a round may have while others want some, too.
    fn share(&self) -> usize {
        let wanting = self.wanting.load(Ordering::Relaxed).max(1);
        self.parallelism().div_ceil(wanting)
    }

    fn wanted<T>(&self, work: impl FnOnce() -> T) -> T {
        struct Wanting<'t>(&'t AtomicUsize);
        impl Drop for Wanting<'_> {
            fn drop(&mut self) {
                self.0.fetch_sub(1, Ordering::Relaxed);
            }
        }
        self.wanting.fetch_add(1, Ordering::Relaxed);
        let _wanting = Wanting(&self.wanting);
        work()
    }
}

impl Executor for Threads {
    fn run(&self, round: &mut dyn Round) {
        let turn = Mutex::new(Turn { round, running: 0 });
        let call = Call { threads: self, turn: &turn };
        self.wanted(|| self.pool.in_place_scope(|scope| call.fill(&mut call.lock(), scope)));
    }

    fn parallelism(&self) -> usize {
        self.pool.current_num_threads()
    }

    fn program_uses(&self) -> Vec<ProgramUse> {
        self.processes.as_ref().map_or_else(Vec::new, |pool| pool.uses())
    }

    fn host(&self, work: &mut (dyn FnMut() + Send)) {
        self.wanted(|| self.pool.install(work));
    }
}

/// A round under way.
#[derive(Clone, Copy)]
struct Call<'c, 'r> {
    threads: &'c Threads,
    turn: &'c Mutex<Turn<'r>>,
}

struct Turn<'r> {
    round: &'r mut dyn Round,
    /// Threads that make runs of it.
    running: usize,
}

impl<'c, 'r: 'c> Call<'c, 'r> {
    fn lock(&self) -> MutexGuard<'c, Turn<'r>> {
        self.turn.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives every thread a run that the round may have and there is a run for.
    fn fill(self, turn: &mut Turn, scope: &Scope<'c>) {
        while turn.running < self.threads.share() {
            let Some(job) = turn.round.next() else { break };
            turn.running += 1;
            scope.spawn(move |scope| self.work(job, scope));
        }
    }

    /// Makes a run, and then others, until there are no more or others are to have the thread.
    fn work(self, first: Job, scope: &Scope<'c>) {
        let mut jobs = vec![first];
        let mut pace = RunPace::default();
        loop {
            let programs = jobs.last().and_then(|last| self.programs(last));
            let asking = programs.and_then(|programs| Some((jobs.pop()?, programs)));
            let begun = Instant::now();
            let done: Vec<Done> = jobs.drain(..).map(|job| job.run()).collect();
            pace.took(begun.elapsed(), done.len());
            if let Some((job, (pool, programs))) = asking {
                done.into_iter().for_each(|done| self.lock().round.done(done));
                run_with_programs(pool, programs, job, &mut CallJobs { call: self, scope });
                self.lock().running -= 1;
                return;
            }
            let mut turn = self.lock();
            // Should whoever is told panic, this thread is not at work any more.
            turn.running -= 1;
            done.into_iter().for_each(|done| turn.round.done(done));
            if turn.running >= self.threads.share() {
                return;
            }
            let Some(next) = turn.round.next() else { return };
            turn.running += 1;
            jobs.push(next);
            self.fill(&mut turn, scope);
            // A thread by itself waits for nobody, and makes no run in vain.
            let at_once = if self.threads.parallelism() > 1 { pace.at_once() } else { 1 };
            while jobs.len() < at_once && jobs.last().is_none_or(|last| self.programs(last).is_none()) {
                let Some(next) = turn.round.next() else { break };
                jobs.push(next);
            }
        }
    }

    /// The programs that decide in a run, and where they are.
    fn programs(&self, job: &Job) -> Option<(&'c ProcessPool, Vec<Arc<DeclaredProgram>>)> {
        let pool = self.threads.processes.as_deref()?;
        Some((pool, job.programs())).filter(|(_, programs)| !programs.is_empty())
    }
}

/// How many runs a thread makes before it looks for more. Runs of microseconds would mostly wait for each other's turn.
#[derive(Default)]
struct RunPace {
    /// What a run of the last ones took, s; 0 before the first.
    run: f64,
}

/// s: what is lost at most where others wait for the last runs of a round.
const TURN: f64 = 0.000_5;

/// However short they are.
const MOST_AT_ONCE: f64 = 32.0;

impl RunPace {
    fn took(&mut self, time: Duration, runs: usize) {
        if runs > 0 {
            self.run = time.as_secs_f64() / runs as f64;
        }
    }

    fn at_once(&self) -> usize {
        (TURN / self.run.max(TURN / MOST_AT_ONCE)) as usize
    }
}

/// Where a thread that asks programs in many runs gets and leaves them.
struct CallJobs<'s, 'c, 'r, 'p> {
    call: Call<'c, 'r>,
    scope: &'p Scope<'s>,
}

impl<'c, 'r: 'c> JobSource for CallJobs<'c, 'c, 'r, '_> {
    fn next(&mut self) -> Option<Job> {
        let mut turn = self.call.lock();
        // Others want threads: those that it has are enough.
        if turn.running > self.call.threads.share() { None } else { turn.round.next() }
    }

    fn done(&mut self, done: Done) {
        let mut turn = self.call.lock();
        turn.running -= 1;
        turn.round.done(done);
        turn.running += 1;
        self.call.fill(&mut turn, self.scope);
    }

    fn is_wanted(&mut self, place: JobPlace) -> bool {
        self.call.lock().round.is_wanted(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_short_runs_are_taken_several_at_a_time() {
        let at_once = |run: Duration| {
            let mut pace = RunPace::default();
            pace.took(run * 4, 4);
            // Nothing was made, as where a program decides in the only run.
            pace.took(Duration::from_secs(1), 0);
            pace.at_once()
        };
        assert_eq!(at_once(Duration::from_secs(1)), 0);
        assert_eq!(at_once(Duration::from_micros(400)), 1);
        assert_eq!(at_once(Duration::from_micros(48)), 10);
        assert_eq!(at_once(Duration::ZERO), 32);
    }
}
