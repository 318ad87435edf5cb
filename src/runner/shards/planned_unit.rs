//! What there is to be run, in pieces that are each made by one worker.

use std::time::Duration;

use rayon::prelude::*;
use sha2::{Digest, Sha256};

use crate::experiment::searched_groups;
use crate::plan::PlannedTrial;
use crate::project::{PlannedSuite, Project};
use crate::run::{Executor, Job, JobPlace, RunDigest, RunDigests, Wanted, to_messagepack};
use crate::session::{Runner, UnitKind, Units, Work};
use scenario::{Block, Case, Search};

/// A step of the simulation of one road user, s: a rough number, by which batches are of about the same size.
const STEP: f64 = 1.5e-6;

/// What is the same for a run however long it is, s.
const RUN: f64 = 3e-5;

/// A decision of a program under test, where nobody has asked it yet, s.
const DECISION: f64 = 1e-3;

/// What a unit of which nobody knows how many runs it will be takes besides those that are certain, s: it is a batch of its own.
const UNDECIDED: f64 = 10.0;

/// What finding the next point of a search takes, s.
const PROPOSAL: f64 = 2e-3;

/// So much estimated work is one unit, s.
const SLICE: f64 = 1.0;

/// What there is to be made of a unit of the session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum UnitPart {
    /// Some runs of a trial.
    Runs {
        /// The first of them.
        first: u32,
        /// How many they are.
        runs: u32,
    },
    /// All of a trial, recorded run or block that decides itself which runs it makes.
    Whole,
    /// What a search makes for one of its groups of people, counted from 0.
    Group(u32),
}

/// A unit of a manifest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannedUnit {
    /// Of all that decides its runs.
    pub id: RunDigest,
    /// Its place among the units of the session.
    pub unit: u32,
    /// What of it.
    pub part: UnitPart,
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
    pub fn new(
        project: &'a Project,
        units: &'a Units<'a>,
        executor: &'a dyn Executor,
        digests: &'a RunDigests,
    ) -> Self {
        let runner = Runner::new(project.suites(), executor, project.registry()).reading(project.files());
        let said = |one: &PlannedSuite| {
            let suite = (&one.suite, &one.suite.texts);
            Sha256::digest(to_messagepack(&suite)).into()
        };
        let suites = project.suites().iter().map(said).collect();
        Self { project, units, digests, runner, suites }
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
        if let Some(groups) = self.groups(unit) {
            return (0..groups).map(|group| self.whole(unit, Some(group))).collect();
        }
        let trial = if self.has_fixed_runs(unit) { self.units.get(unit).trial() } else { None };
        let Some(trial) = trial else { return vec![self.whole(unit, None)] };
        let seconds = run_seconds(&trial.cases.first());
        let all = trial.cases.len();
        // Who is to say how long all of a trial takes has to make all of it.
        let most = match self.time_limit(unit) {
            Some(_) => all,
            None => (SLICE / seconds).clamp(1.0, 1000.0) as usize,
        };
        (0..all)
            .step_by(most)
            .map(|first| {
                let runs = most.min(all - first);
                PlannedUnit {
                    id: self.slice_id(unit, &trial, first, runs),
                    unit: unit as u32,
                    part: UnitPart::Runs { first: first as u32, runs: runs as u32 },
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

    /// Whether there may be units that decide themselves which runs they make.
    pub(super) fn has_undecided(&self) -> bool {
        let plans = || self.project.suites().iter().flat_map(|one| one.plan.scenarios());
        let is_undecided = |certain: usize, all: usize| certain != all;
        self.units.others().next().is_some()
            || plans().any(|scenario| is_undecided(scenario.certain_runs(), scenario.runs()))
    }

    /// A run of a trial as a session asks for it.
    pub(super) fn job(&self, case: Case, wanted: Wanted) -> Job {
        self.runner.job(JobPlace::default(), case, wanted)
    }

    /// That of a unit whose runs have these digests.
    fn slice_id(&self, unit: usize, trial: &PlannedTrial, first: usize, runs: usize) -> RunDigest {
        let digest = |run: usize| self.digests.of(&self.job(trial.cases.get(run), Wanted::Outcome));
        slice_id(self.time_limit(unit), (first..first + runs).map(digest))
    }

    /// How long a trial may take, wall time.
    pub(super) fn time_limit(&self, unit: usize) -> Option<Duration> {
        let plan = &self.project.suites()[self.units.suite(unit)].plan;
        plan.time_limit.map(Duration::from_secs_f64)
    }

    /// How many groups of people a unit is for, if it is a search for several that are each made by themselves. Where programs decide, which runs
    /// are made twice depends on all of it.
    pub(super) fn groups(&self, unit: usize) -> Option<usize> {
        let suite = &self.project.suites()[self.units.suite(unit)].suite;
        let UnitKind::Block(block) = self.units.kind(unit) else { return None };
        let Block::Search(search) = &**block else { return None };
        let groups = if suite.controllers.is_empty() { searched_groups(suite, search) } else { 1 };
        (groups > 1).then_some(groups)
    }

    /// How long the search for a group of people may take, s.
    fn group_seconds(&self, suite: usize, search: &Search) -> f64 {
        let plans = self.project.suites()[suite].plan.scenarios();
        let plan = plans.iter().find(|one| !one.is_empty() && one.scenario().name == search.scenario);
        let Some(plan) = plan else { return UNDECIDED };
        let evaluations = f64::from(search.budget.evaluations);
        let run = run_seconds(&plan.trial(0).cases.first());
        evaluations * (PROPOSAL + run * f64::from(search.runs))
    }

    /// A unit that decides itself which runs it makes, or what it makes for a group: all that it may read is in its digest.
    pub(super) fn whole(&self, unit: usize, group: Option<usize>) -> PlannedUnit {
        let of = self.units.get(unit);
        let (recorded, seconds) = match &of.work {
            Work::Recorded(recorded) => (Some(*recorded), RUN),
            Work::Trial(trial) => {
                (None, UNDECIDED + run_seconds(&trial.cases.first()) * trial.certain_runs() as f64)
            }
            Work::Block(block) => (
                None,
                match (&**block, group) {
                    (Block::Search(search), Some(_)) => self.group_seconds(of.suite, search),
                    _ => UNDECIDED,
                },
            ),
        };
        let data = (self.suites[of.suite], &of.key, recorded, group);
        let id = self.digests.of_all(self.runner.batch().measured, &data);
        let part = group.map_or(UnitPart::Whole, |group| UnitPart::Group(group as u32));
        PlannedUnit { id, unit: unit as u32, part, seconds: seconds as f32 }
    }
}

/// That of a unit whose runs have these digests. What took longer than another limit is another result.
pub fn slice_id(limit: Option<Duration>, runs: impl Iterator<Item = RunDigest>) -> RunDigest {
    let within = limit.map_or_else(String::new, |limit| format!("within {limit:?}\n"));
    let begun = Sha256::new().chain_update("runs\n").chain_update(within);
    let hash = runs.fold(begun, |hash, run| hash.chain_update(run.0));
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
