//! What there is to be run, in pieces that are each made by one worker.

use rayon::prelude::*;
use sha2::{Digest, Sha256};

use super::error::ShardError;
use crate::plan::PlannedTrial;
use crate::project::{PlannedSuite, Project};
use crate::run::{Executor, Job, JobPlace, RunDigest, RunDigests, Wanted};
use crate::session::{Runner, UnitKind, Units, Work};
use scenario::Case;

/// A step of the simulation of one road user, s: a rough number, by which batches are of about the same size.
const STEP: f64 = 1.5e-6;

/// What is the same for a run however long it is, s.
const RUN: f64 = 3e-5;

/// A decision of a program under test, where nobody has asked it yet, s.
const DECISION: f64 = 1e-3;

/// What a unit of which nobody knows how many runs it will be takes besides those that are certain, s: it is a batch of its own.
const UNDECIDED: f64 = 10.0;

/// So much estimated work is one unit, s.
const SLICE: f64 = 1.0;

/// A unit: some runs of a trial, or all of a trial, recorded run or block that decides itself how many they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannedUnit {
    /// Of all that decides its runs.
    pub id: RunDigest,
    /// Its place among the units of the session.
    pub unit: u32,
    /// The first of its runs.
    pub first: u32,
    /// How many they are; 0 of one that decides that itself.
    pub runs: u32,
    /// How long it may take on one core, s.
    pub seconds: f32,
}

/// Takes the units of a project to pieces.
pub struct Planner<'a> {
    pub(super) project: &'a Project,
    pub(super) units: &'a Units<'a>,
    pub(super) digests: &'a RunDigests,
    pub(super) runner: Runner<'a>,
    /// Of all that each suite says.
    suites: Vec<[u8; 32]>,
}

impl<'a> Planner<'a> {
    /// One for the units of a project, which `executor` may work out side by side; it makes no runs.
    ///
    /// # Errors
    /// If a verdict depends on how long runs take, which nobody could say of runs that were made on many machines.
    pub fn new(
        project: &'a Project,
        units: &'a Units<'a>,
        executor: &'a dyn Executor,
        digests: &'a RunDigests,
    ) -> Result<Self, ShardError> {
        if let Some(timed) = project.suites().iter().find(|one| one.plan.time_limit.is_some()) {
            let message = format!(
                "{}: `time_limit` is about the wall time of whole trials, which are made in parts here; leave it out to use many machines",
                timed.file
            );
            return Err(ShardError::OtherFiles { message });
        }
        let runner = Runner::new(project.suites(), executor, project.registry()).reading(project.files());
        let said = |one: &PlannedSuite| {
            let suite = (&one.suite, &one.suite.texts);
            let bytes = rmp_serde::to_vec_named(&suite).expect("plain data is encoded, and memory takes it");
            Sha256::digest(bytes).into()
        };
        let suites = project.suites().iter().map(said).collect();
        Ok(Self { project, units, digests, runner, suites })
    }

    /// The pieces of the chosen units, in no order that means anything.
    pub fn plan(&self, chosen: &[bool]) -> Vec<PlannedUnit> {
        let chosen: Vec<usize> = (0..chosen.len()).filter(|unit| chosen[*unit]).collect();
        self.runner.executor().think(|| {
            let pieces = chosen.par_iter().with_min_len(16).flat_map_iter(|unit| self.pieces(*unit));
            pieces.collect()
        })
    }

    fn pieces(&self, unit: usize) -> Vec<PlannedUnit> {
        if !self.has_fixed_runs(unit) {
            return vec![self.whole(unit)];
        }
        let Some(trial) = self.units.get(unit).trial() else { return vec![self.whole(unit)] };
        let seconds = run_seconds(&trial.cases.first());
        let most = (SLICE / seconds).clamp(1.0, 1000.0) as usize;
        let all = trial.cases.len();
        (0..all)
            .step_by(most)
            .map(|first| {
                let runs = most.min(all - first);
                PlannedUnit {
                    id: self.slice_id(&trial, first, runs),
                    unit: unit as u32,
                    first: first as u32,
                    runs: runs as u32,
                    seconds: (seconds * runs as f64) as f32,
                }
            })
            .collect()
    }

    /// Whether all runs of the unit that there may be are made in any case: gates compare all of them, however soon a trial is decided.
    fn has_fixed_runs(&self, unit: usize) -> bool {
        let gated = !self.project.suites()[self.units.suite(unit)].suite.gates.is_empty();
        match self.units.kind(unit) {
            UnitKind::Trial { scenario, .. } => gated || scenario.certain_runs() == scenario.runs(),
            UnitKind::Recorded | UnitKind::Block(_) => false,
        }
    }

    /// A run of a trial as a session asks for it.
    pub(super) fn job(&self, case: Case, wanted: Wanted) -> Job {
        self.runner.job(JobPlace::default(), case, wanted)
    }

    /// That of a unit whose runs have these digests.
    fn slice_id(&self, trial: &PlannedTrial, first: usize, runs: usize) -> RunDigest {
        let digest = |run: usize| self.digests.of(&self.job(trial.cases.get(run), Wanted::Outcome));
        slice_id((first..first + runs).map(digest))
    }

    /// A unit that decides itself which runs it makes: all that it may read is in its digest.
    pub(super) fn whole(&self, unit: usize) -> PlannedUnit {
        let of = self.units.get(unit);
        let (recorded, seconds) = match &of.work {
            Work::Recorded(recorded) => (Some(*recorded), RUN),
            Work::Trial(trial) => {
                (None, UNDECIDED + run_seconds(&trial.cases.first()) * trial.certain_runs() as f64)
            }
            Work::Block(_) => (None, UNDECIDED),
        };
        let data = (self.suites[of.suite], &of.key, recorded);
        let id = self.digests.of_all(self.runner.batch().measured, &data);
        PlannedUnit { id, unit: unit as u32, first: 0, runs: 0, seconds: seconds as f32 }
    }
}

/// That of a unit whose runs have these digests.
pub fn slice_id(runs: impl Iterator<Item = RunDigest>) -> RunDigest {
    let hash = runs.fold(Sha256::new().chain_update("runs\n"), |hash, run| hash.chain_update(run.0));
    RunDigest(hash.finalize().into())
}

/// How long a run may take, s, by what is simulated for how long.
fn run_seconds(case: &Case) -> f64 {
    let world = &case.world;
    let users = (world.vehicles.len() + world.pedestrians.len()) as f64;
    let decisions = |period: Option<f64>| DECISION * world.horizon / period.unwrap_or(world.step);
    let programs = crate::run::programs(case);
    let asked: f64 = programs.iter().map(|program| decisions(program.period)).sum();
    RUN + STEP * users * world.horizon / world.step + asked
}
