//! Runs without pedestrians, shared by every run from the same start.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use sha2::{Digest, Sha256};

use super::build::{RunError, road_users};
use scenario::World;
use sim::measure::FreeFlow;
use sim::{Observer, Step, simulate};

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
        let mut empty = world.clone();
        empty.pedestrians.clear();
        empty.road = empty.road.unnamed();
        let text = serde_json::to_vec(&empty).expect("plain data serialises");
        let hash: [u8; 32] = Sha256::digest(text).into();
        if let Some(found) = self.lock().get(&hash) {
            return Ok(found.clone());
        }
        // Two threads may both simulate the same free flow; they find the same.
        let flows = Arc::new(drive(&Arc::new(empty))?);
        let mut known = self.lock();
        if known.len() >= MOST_KNOWN {
            known.clear();
        }
        known.insert(hash, flows.clone());
        drop(known);
        Ok(flows)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<[u8; 32], Arc<Vec<FreeFlow>>>> {
        self.known.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// Free flow has no chance in it but a controller's own, so any seed does: the same one for all.
const SEED: u64 = 0;

fn drive(world: &Arc<World>) -> Result<Vec<FreeFlow>, RunError> {
    let users = road_users(world, SEED)?;
    let mut finishes = Finishes { line: world.finish, flows: vec![None; world.vehicles.len()] };
    simulate(world, users, &mut finishes).map_err(|fault| RunError::of_fault(world, fault, true))?;
    let missing = FreeFlow { finish_time: None, finish_speed: 0.0 };
    Ok(finishes.flows.into_iter().map(|flow| flow.unwrap_or(missing)).collect())
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
