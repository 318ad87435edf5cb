//! Runs as they are drawn without a method.

use super::estimate::{ReplicateRuns, WeighedHit};
use super::sampling::{RareOutcome, RarePoint, RareRound, RareSampling, plateau};
use super::space::RareSpace;
use super::{REPLICATES, proposal::Component};
use crate::random::Stream;

/// All runs weigh the same, so that the exact interval of a share is that of the probability.
#[derive(Debug)]
pub struct CrudeSampling {
    space: RareSpace,
    seed: u64,
    budget: usize,
    asked: Vec<RarePoint>,
    done: usize,
    plateau: f64,
    replicates: Vec<ReplicateRuns>,
}

impl CrudeSampling {
    /// Of at least as many runs as there are replicates.
    pub fn new(space: RareSpace, budget: usize, seed: u64) -> Self {
        Self { space, seed, budget, asked: Vec::new(), done: 0, plateau: 0.0, replicates: Vec::new() }
    }
}

impl CrudeSampling {
    /// How many of so many runs are drawn as they are drawn without a method: all.
    pub fn nominal_runs_of(budget: usize) -> usize {
        budget
    }
}

impl RareSampling for CrudeSampling {
    fn ask(&mut self) -> Option<RareRound> {
        let replicate = self.replicates.len();
        if replicate == REPLICATES {
            return None;
        }
        let end = self.budget * (replicate + 1) / REPLICATES;
        let nominal = Component::nominal(&self.space);
        let mut stream = Stream::numbered(self.seed, 1 + replicate as u64);
        let point = |chance| RarePoint { chance, point: self.space.point(&nominal.draw(&mut stream)) };
        self.asked = (self.done..end).map(point).collect();
        Some(RareRound { points: self.asked.clone(), is_pilot: false })
    }

    fn tell(&mut self, outcomes: &[RareOutcome]) {
        if self.replicates.is_empty() {
            self.plateau = plateau(outcomes);
        }
        let hits: Vec<WeighedHit> = (self.done..)
            .zip(self.asked.drain(..).zip(outcomes))
            .filter(|(_, (_, outcome))| outcome.event)
            .map(|(run, (RarePoint { chance, point }, _))| WeighedHit {
                run,
                lineage: run,
                chance,
                weight: 1.0,
                place: self.space.place(&point),
                point,
            })
            .collect();
        let first = self.done;
        self.done += outcomes.len();
        self.replicates.push(ReplicateRuns {
            probability: hits.len() as f64 / outcomes.len() as f64,
            runs: outcomes.len(),
            first,
            nominal_runs: outcomes.len() as u64,
            nominal_hits: hits.iter().map(|hit| hit.run).collect(),
            hits,
            surplus: 0.0,
        });
    }

    fn replicates(&self) -> &[ReplicateRuns] {
        &self.replicates
    }

    fn budget(&self) -> usize {
        self.budget
    }

    fn nominal_runs(&self) -> usize {
        self.budget
    }

    fn plateau(&self) -> f64 {
        self.plateau
    }
}
