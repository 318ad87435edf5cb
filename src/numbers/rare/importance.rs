//! Multiple importance sampling: a pilot says where to look, a mixture of what it found, of what is drawn and of what lies farther out is
//! drawn from, and every run weighs what it would be drawn with over what it was drawn with.
//!
//! Source: T. Hesterberg, Technometrics 37, 1995 (a tenth as it is drawn, so that no weight is above ten); A. Owen & Y. Zhou,
//! J. Am. Stat. Assoc. 95, 2000.

use super::REPLICATES;
use super::estimate::{ReplicateRuns, WeighedHit};
use super::pilot::Pilot;
use super::proposal::{Component, log_mixture};
use super::sampling::{RareOutcome, RarePoint, RareRound, RareSampling, pilot_runs, plateau, replicate_runs};
use super::space::{RarePlace, RareSpace};
use crate::random::{Stream, derive_seed};

/// One of so many runs is drawn as it is drawn without a method, and as many farther out in all directions.
const DEFENSIVE: usize = 10;

/// Points where the event is likely, weighed.
#[derive(Debug)]
pub struct ImportanceSampling {
    space: RareSpace,
    seed: u64,
    budget: usize,
    pilot: Option<Pilot>,
    /// What is drawn from, the first as without a method, and how many runs of a replicate are of each.
    components: Vec<(usize, Component)>,
    /// Of the replicate that is asked for.
    asked: Vec<(usize, RarePlace)>,
    /// Runs that were asked for.
    done: usize,
    plateau: f64,
    replicates: Vec<ReplicateRuns>,
}

impl ImportanceSampling {
    /// With so many runs in all, at least [`FEWEST_RUNS`](super::FEWEST_RUNS).
    pub fn new(space: RareSpace, budget: usize, seed: u64) -> Self {
        let pilot = Pilot::new(space.clone(), pilot_runs(budget), derive_seed(seed, "pilot"));
        Self {
            space,
            seed,
            budget,
            pilot: Some(pilot),
            components: Vec::new(),
            asked: Vec::new(),
            done: 0,
            plateau: 0.0,
            replicates: Vec::new(),
        }
    }

    /// How many of so many runs are drawn as they are drawn without a method.
    pub fn nominal_runs_of(budget: usize) -> usize {
        replicate_runs(budget).div_ceil(DEFENSIVE) * REPLICATES
    }

    /// Runs of each replicate.
    fn size(&self) -> usize {
        replicate_runs(self.budget)
    }

    /// Of each replicate, drawn as without a method.
    fn nominal_size(&self) -> usize {
        self.size().div_ceil(DEFENSIVE)
    }

    /// So many runs of each replicate from each component, the pilot's in proportion to their shares.
    fn share_out(&mut self, found: Vec<(f64, Component)>) {
        let defensive = self.nominal_size();
        let rest = self.size().saturating_sub(2 * defensive);
        self.components =
            vec![(defensive, Component::nominal(&self.space)), (defensive, Component::wide(&self.space))];
        let (mut share, mut before) = (0.0, 0);
        for (own, component) in found {
            share += own;
            let until = ((share * rest as f64).round() as usize).min(rest);
            self.components.push((until - before, component));
            before = until;
        }
        // What rounding left.
        if let Some(last) = self.components.last_mut() {
            last.0 += rest - before;
        }
    }
}

impl RareSampling for ImportanceSampling {
    fn ask(&mut self) -> Option<RareRound> {
        if let Some(pilot) = &mut self.pilot {
            if let Some(places) = pilot.ask() {
                let point = |(chance, place)| RarePoint { chance, point: self.space.point(place) };
                let points = (self.done..).zip(&places).map(point).collect();
                return Some(RareRound { points, is_pilot: true });
            }
            let (found, first) = (pilot.components(), pilot.first());
            self.plateau = plateau(&first);
            self.pilot = None;
            self.share_out(found);
        }
        let replicate = self.replicates.len();
        if replicate == REPLICATES {
            return None;
        }
        let mut stream = Stream::numbered(self.seed, 1 + replicate as u64);
        let mut asked = Vec::with_capacity(self.size());
        for (index, (runs, component)) in self.components.iter().enumerate() {
            asked.extend((0..*runs).map(|_| (index, component.draw(&mut stream))));
        }
        self.asked = asked;
        let point = |(chance, (_, place)): (usize, &(usize, RarePlace))| RarePoint {
            chance,
            point: self.space.point(place),
        };
        let points = (self.done..).zip(&self.asked).map(point).collect();
        Some(RareRound { points, is_pilot: false })
    }

    fn tell(&mut self, outcomes: &[RareOutcome]) {
        let first = self.done;
        self.done += outcomes.len();
        if let Some(pilot) = &mut self.pilot {
            return pilot.tell(outcomes);
        }
        let runs = outcomes.len();
        let (mut nominal_runs, mut nominal_hits, mut hits) = (0, Vec::new(), Vec::new());
        for (run, ((component, place), outcome)) in
            (first..).zip(std::mem::take(&mut self.asked).into_iter().zip(outcomes))
        {
            let is_nominal = component == 0;
            nominal_runs += u64::from(is_nominal);
            if !outcome.event {
                continue;
            }
            nominal_hits.extend(is_nominal.then_some(run));
            let parts = self.components.iter().map(|(own, component)| (*own as f64 / runs as f64, component));
            let weight = libm::exp(-log_mixture(parts, &place));
            let point = self.space.point(&place);
            hits.push(WeighedHit { run, lineage: run, chance: run, point, weight, place });
        }
        self.replicates.push(ReplicateRuns {
            probability: hits.iter().map(|hit| hit.weight).sum::<f64>() / runs as f64,
            runs,
            first,
            nominal_runs,
            nominal_hits,
            hits,
            surplus: 0.0,
        });
    }

    fn replicates(&self) -> &[ReplicateRuns] {
        &self.replicates
    }

    fn budget(&self) -> usize {
        pilot_runs(self.budget) + self.size() * REPLICATES
    }

    fn nominal_runs(&self) -> usize {
        self.nominal_size() * REPLICATES
    }

    fn plateau(&self) -> f64 {
        self.plateau
    }
}
