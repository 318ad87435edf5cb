//! Sequences of runs side by side: each takes in what came of its runs in their order, whoever ended first, until it has
//! enough.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use super::executor::{Executor, Round};
use super::job::{Done, Job, JobPlace};
use super::stop::Stop;

/// Runs that are taken in one after the other. What it concludes depends on those taken in alone, so that it does not matter
/// how many were made in vain behind them.
pub trait Sequence: Send {
    /// How many runs there may be.
    fn runs(&self) -> usize;

    /// The run with this index.
    fn job(&mut self, place: JobPlace) -> Job;

    /// Takes in the next one. [`ControlFlow::Break`] if no more are needed.
    fn take(&mut self, done: Done) -> ControlFlow<()>;

    /// How far runs may be ahead of what was taken in: what came of them needs memory, and may be in vain.
    fn ahead(&self) -> usize {
        256
    }

    /// Asked between runs, `taken` of which were taken in: [`ControlFlow::Break`] ends it without the rest.
    fn between(&mut self, taken: usize) -> ControlFlow<()> {
        let _ = taken;
        ControlFlow::Continue(())
    }
}

/// Where sequences come from, and where they go.
pub trait Sequences: Send {
    type One: Sequence;

    /// The next one that may begin, if there is one now.
    fn open(&mut self) -> Option<Self::One>;

    /// Takes one back that is over: `taken` of its runs were taken in, all that there may be unless it wanted no more.
    fn close(&mut self, one: Self::One, taken: usize);
}

/// Runs sequences until none is left, or somebody wishes to stop; those that have begun by then are closed with the runs that
/// came to their end.
pub fn run_sequences(executor: &dyn Executor, sequences: &mut impl Sequences, stop: &Stop) {
    let mut side_by_side = SideBySide { sequences, open: BTreeMap::new(), opened: 0, begun_below: 0, stop };
    executor.run(&mut side_by_side);
    for (_, Open { one, taken, .. }) in std::mem::take(&mut side_by_side.open) {
        side_by_side.sequences.close(one, taken);
    }
}

struct SideBySide<'s, S: Sequences> {
    sequences: &'s mut S,
    open: BTreeMap<usize, Open<S::One>>,
    opened: usize,
    /// All runs of those before this one were begun.
    begun_below: usize,
    stop: &'s Stop,
}

/// A sequence under way.
struct Open<T> {
    one: T,
    runs: usize,
    /// How many runs were begun.
    begun: usize,
    /// How many were taken in.
    taken: usize,
    /// Those that are done and not taken in yet.
    done: BTreeMap<usize, Done>,
}

impl<S: Sequences> SideBySide<'_, S> {
    /// A run of a sequence that is open. Those that are over in between are closed.
    fn begin(&mut self) -> Option<Job> {
        let mut over = Vec::new();
        let mut job = None;
        let all_begun = self.open.range(self.begun_below..).take_while(|(_, open)| open.begun == open.runs);
        self.begun_below = all_begun.last().map_or(self.begun_below, |(number, _)| number + 1);
        for (number, open) in self.open.range_mut(self.begun_below..) {
            if open.begun == open.runs || open.begun - open.taken >= open.one.ahead() {
                continue;
            }
            if open.one.between(open.taken).is_break() {
                over.push(*number);
                continue;
            }
            let place = JobPlace { sequence: *number, run: open.begun };
            open.begun += 1;
            job = Some(Job { place, ..open.one.job(place) });
            break;
        }
        over.into_iter().for_each(|number| self.close(number));
        job
    }

    fn close(&mut self, number: usize) {
        if let Some(Open { one, taken, .. }) = self.open.remove(&number) {
            self.sequences.close(one, taken);
        }
    }
}

impl<S: Sequences> Round for SideBySide<'_, S> {
    fn next(&mut self) -> Option<Job> {
        loop {
            if self.stop.is_requested() {
                return None;
            }
            if let Some(job) = self.begin() {
                return Some(job);
            }
            let one = self.sequences.open()?;
            let runs = one.runs();
            if runs == 0 {
                self.sequences.close(one, 0);
                continue;
            }
            self.open.insert(self.opened, Open { one, runs, begun: 0, taken: 0, done: BTreeMap::new() });
            self.opened += 1;
        }
    }

    fn done(&mut self, done: Done) {
        let JobPlace { sequence, run } = done.place;
        // Of one that is over nobody asks any more.
        let Some(open) = self.open.get_mut(&sequence) else { return };
        open.done.insert(run, done);
        let mut over = false;
        while let (false, Some(next)) = (over, open.done.remove(&open.taken)) {
            open.taken += 1;
            over = open.one.take(next).is_break() || open.taken == open.runs;
        }
        if over || open.one.between(open.taken).is_break() {
            self.close(sequence);
        }
    }
    fn is_wanted(&mut self, place: JobPlace) -> bool {
        let Some(open) = self.open.get_mut(&place.sequence).filter(|_| !self.stop.is_requested()) else {
            return false;
        };
        let is_over = open.one.between(open.taken).is_break();
        if is_over {
            self.close(place.sequence);
        }
        !is_over
    }
}
