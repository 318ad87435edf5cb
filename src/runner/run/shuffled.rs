//! An executor for tests: runs end in random order, on any thread.

use std::sync::Mutex;
use std::thread;

use super::executor::{Executor, Round};
use super::job::{Done, Job};
use numbers::random::Stream;

/// Makes up to a few dozen runs at once, on threads of their own, and tells of them in an order that the seed decides.
/// What depends on that order is wrong.
#[derive(Debug)]
pub struct Shuffled {
    stream: Mutex<Stream>,
}

/// Runs under way at most.
const MOST: usize = 40;
/// Threads that make them.
const THREADS: usize = 3;

impl Shuffled {
    /// The same seed gives the same order of the runs of a round.
    pub fn seeded(seed: u64) -> Self {
        Self { stream: Mutex::new(Stream::seeded(seed)) }
    }

    /// A number below `end`.
    fn below(&self, end: usize) -> usize {
        self.stream.lock().expect("nobody panics with it").index(end)
    }

    fn run_apart(&self, jobs: Vec<Job>) -> Vec<Done> {
        let mut hands: [Vec<Job>; THREADS] = Default::default();
        for job in jobs {
            hands[self.below(THREADS)].push(job);
        }
        thread::scope(|scope| {
            let hands = hands.map(|jobs| scope.spawn(|| jobs.into_iter().map(Job::run).collect::<Vec<_>>()));
            hands.into_iter().flat_map(|hand| hand.join().expect("a job gives its panics back")).collect()
        })
    }
}

impl Executor for Shuffled {
    fn run(&self, round: &mut dyn Round) {
        let mut ended: Vec<Done> = Vec::new();
        loop {
            let wanted = 1 + self.below(MOST);
            let jobs = (0..wanted).map_while(|_| round.next()).collect();
            ended.extend(self.run_apart(jobs));
            if ended.is_empty() {
                return;
            }
            // Some stay unknown until others, which begin later, are told.
            for _ in 0..=self.below(ended.len()) {
                round.done(ended.swap_remove(self.below(ended.len())));
            }
        }
    }

    fn parallelism(&self) -> usize {
        THREADS
    }
}
