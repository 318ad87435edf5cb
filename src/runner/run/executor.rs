//! Where runs are made: an executor takes jobs, makes them wherever it likes, and gives back what came of each.

use super::job::{Done, Job, JobPlace};
use under_test::ProgramUse;

/// Makes runs. What they come to depends on neither when nor where they are made, so that executors differ in time only.
pub trait Executor: Sync {
    /// Makes the runs of a round, until it gives no more and all that it gave are done. A round is asked for a job whenever
    /// one may begin, and for more after every one that is done, since that may be what it has waited for; it is told
    /// what is done in any order, on any thread, but never at the same time.
    ///
    /// Several threads may call this at once: they share what there is to run on.
    fn run(&self, round: &mut dyn Round);

    /// How many runs it makes at the same time, at least 1: so many things are worth being under way.
    fn parallelism(&self) -> usize;

    /// What programs under test were used for up to now; none where no programs are asked.
    fn program_uses(&self) -> Vec<ProgramUse> {
        Vec::new()
    }

    /// Does `work` that is no run, such as finding the next proposals of searches, where rayon's current pool is what it may
    /// take of this machine.
    fn host(&self, work: &mut (dyn FnMut() + Send)) {
        work();
    }
}

impl<E: Executor + ?Sized> Executor for &E {
    fn run(&self, round: &mut dyn Round) {
        (**self).run(round);
    }

    fn parallelism(&self) -> usize {
        (**self).parallelism()
    }

    fn program_uses(&self) -> Vec<ProgramUse> {
        (**self).program_uses()
    }

    fn host(&self, work: &mut (dyn FnMut() + Send)) {
        (**self).host(work);
    }
}

/// Runs of which none has to wait for what another one comes to.
pub trait Round: Send {
    /// A run that may be made now; `None` if there is none, at least until another one is done.
    fn next(&mut self) -> Option<Job>;

    /// Takes what came of one of them.
    fn done(&mut self, done: Done);

    /// Whether somebody still waits for a run that was given: of one that takes long this may be asked meanwhile.
    fn is_wanted(&mut self, place: JobPlace) -> bool {
        let _ = place;
        true
    }
}

impl dyn Executor + '_ {
    /// What `work` gives, done by [`Executor::host`].
    pub fn think<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        let (mut work, mut result) = (Some(work), None);
        self.host(&mut || result = work.take().map(|work| work()));
        result.expect("a host does the work once")
    }
}
