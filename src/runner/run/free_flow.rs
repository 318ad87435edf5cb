//! Runs without pedestrians, shared by every run from the same start.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use sha2::{Digest, Sha256};

use super::build::{RunError, nobody_asked, road_users};
use super::messagepack::to_messagepack;
use scenario::World;
use sim::measure::FreeFlow;
use sim::{Course, Observer, Progress, Step};

/// So many are known at a time: every trial of a million may have a start of its own, and those of one start follow each other.
const MOST_KNOWN: usize = 1 << 14;

/// The free-flow runs of a suite, one per distinct road, vehicles, parameters and start: each is simulated once, unless very many
/// others come in between.
#[derive(Debug, Default)]
pub struct FreeFlows {
    known: Mutex<HashMap<[u8; 32], Arc<Vec<FreeFlow>>>>,
}

impl FreeFlows {
    /// What each vehicle of `world` does when no pedestrian appears.
    pub fn of(&self, world: &World) -> Result<Arc<Vec<FreeFlow>>, RunError> {
        // Two threads may both simulate the same free flow; they find the same.
        let mut run = match self.begin(world)? {
            Begun::Known(flows) => return Ok(flows),
            Begun::Run(run) => run,
        };
        match run.go_on()? {
            Progress::Ended(_) => Ok(self.keep(*run)),
            Progress::Waits => {
                let waiting = run.course().asked().next().map_or(0, |(vehicle, _)| vehicle);
                let fault = run.course().fault(waiting, nobody_asked());
                Err(RunError::of_fault(&run.world, fault, true))
            }
        }
    }

    /// As [`Self::of`], where somebody outside may have to decide.
    pub(super) fn begin(&self, world: &World) -> Result<Begun, RunError> {
        let mut empty = world.clone();
        empty.pedestrians.clear();
        empty.road = empty.road.unnamed();
        let hash: [u8; 32] = Sha256::digest(to_messagepack(&empty)).into();
        if let Some(found) = self.lock().get(&hash) {
            return Ok(Begun::Known(found.clone()));
        }
        FreeFlowRun::start(hash, empty).map(|run| Begun::Run(Box::new(run)))
    }

    /// Keeps what a run that has come to its end found.
    pub(super) fn keep(&self, run: FreeFlowRun) -> Arc<Vec<FreeFlow>> {
        let missing = FreeFlow { finish_time: None, finish_speed: 0.0 };
        let flows = run.finishes.flows.into_iter().map(|flow| flow.unwrap_or(missing)).collect();
        let flows = Arc::new(flows);
        let mut known = self.lock();
        if known.len() >= MOST_KNOWN {
            known.clear();
        }
        known.insert(run.hash, Arc::clone(&flows));
        flows
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<[u8; 32], Arc<Vec<FreeFlow>>>> {
        self.known.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// Free flow has no chance in it but a controller's own, so any seed does: the same one for all.
pub(super) const SEED: u64 = 0;

/// A free flow that is known, or has to be driven.
pub(super) enum Begun {
    Known(Arc<Vec<FreeFlow>>),
    Run(Box<FreeFlowRun>),
}

/// A free flow under way, which waits wherever somebody outside decides.
pub(super) struct FreeFlowRun {
    hash: [u8; 32],
    pub world: Arc<World>,
    course: Course,
    finishes: Finishes,
}

impl FreeFlowRun {
    fn start(hash: [u8; 32], empty: World) -> Result<Self, RunError> {
        let world = Arc::new(empty);
        let users = road_users(&world, SEED)?;
        let finishes = Finishes { line: world.finish, flows: vec![None; world.vehicles.len()] };
        Ok(Self { hash, course: Course::start(world.clone(), users), world, finishes })
    }

    /// What tells it from others.
    pub fn hash(&self) -> [u8; 32] {
        self.hash
    }

    pub fn go_on(&mut self) -> Result<Progress, RunError> {
        self.course.next(&mut self.finishes).map_err(|fault| RunError::of_fault(&self.world, fault, true))
    }

    pub fn seen(&self) -> &Course {
        &self.course
    }

    /// Where somebody outside decides.
    pub fn course(&mut self) -> &mut Course {
        &mut self.course
    }
}

struct Finishes {
    line: f64,
    flows: Vec<Option<FreeFlow>>,
}

impl Observer for Finishes {
    fn observe(&mut self, step: &Step) {
        for (index, flow) in self.flows.iter_mut().enumerate() {
            let (before, after) = (step.before.vehicles[index].motion, step.after.vehicles[index].motion);
            if flow.is_none() && before.travelled < self.line && after.travelled >= self.line {
                let part = (self.line - before.travelled) / (after.travelled - before.travelled);
                *flow = Some(FreeFlow {
                    finish_time: Some(step.time + part * step.duration),
                    finish_speed: before.speed + part * (after.speed - before.speed),
                });
            }
        }
    }
}
