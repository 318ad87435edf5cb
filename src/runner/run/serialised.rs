//! An executor for tests: jobs, and what comes of them, go through bytes, as they do to and from another process.

use super::executor::{Executor, Round};
use super::job::{Done, Job};
use scenario::registry::Registry;

/// Another executor that is given each job, and gives back what came of it, written down and read back. What is lost on the
/// way is wrong.
#[derive(Debug)]
pub struct Serialised<E> {
    executor: E,
    registry: Registry,
}

impl<E> Serialised<E> {
    /// `registry` knows what the jobs name.
    pub fn new(executor: E, registry: Registry) -> Self {
        Self { executor, registry }
    }
}

impl<E: Executor> Executor for Serialised<E> {
    fn run(&self, round: &mut dyn Round) {
        self.executor.run(&mut SerialisedRound { round, registry: &self.registry });
    }

    fn parallelism(&self) -> usize {
        self.executor.parallelism()
    }

    fn host(&self, work: &mut (dyn FnMut() + Send)) {
        self.executor.host(work);
    }
}

struct SerialisedRound<'r> {
    round: &'r mut dyn Round,
    registry: &'r Registry,
}

impl Round for SerialisedRound<'_> {
    fn next(&mut self) -> Option<Job> {
        let job = self.round.next()?;
        let bytes = job.to_bytes();
        let read = Job::from_bytes(&bytes, self.registry).expect("what was written is read back");
        assert_eq!(read.to_bytes(), bytes, "a job is the same when it was read back");
        Some(read)
    }

    fn done(&mut self, done: Done) {
        let bytes = done.to_bytes();
        let read = Done::from_bytes(&bytes, self.registry).expect("what was written is read back");
        assert_eq!(read.to_bytes(), bytes, "what came of a job is the same when it was read back");
        self.round.done(read);
    }
}
