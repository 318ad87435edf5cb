//! Multilevel splitting: runs that come near the event are gone on from, level by level, and what part of them gets from each level to the
//! next multiplies to the probability.
//!
//! The levels are those that a pilot found, which is thrown away, so that every replicate is unbiased whatever they are. A level is the set
//! of runs that are no farther from the event than it says, so that equal scores are never told apart. Within a level some of the runs
//! that got there begin a chain each, whose members all count. A chain is made of steps that leave what is drawn as it is drawn: a
//! normal coordinate goes a part of its way to a new one, a category is drawn anew, and in one of two the chance beyond the point, too. What
//! would come to lie beyond the level stays where it was.
//!
//! Source: H. Kahn & T. E. Harris, Natl. Bur. Stand. Appl. Math. Ser. 12, 1951; S. K. Au & J. L. Beck, Probab. Eng. Mech. 16, 2001 (chains);
//! P. Del Moral, Feynman-Kac Formulae, 2004 (a product of shares at fixed levels is unbiased); H.-D. Dau & N. Chopin, J. R. Stat. Soc. B 84,
//! 2022 (so it is if all members of chains count); C.-E. Bréhier et al., Ann. Appl. Probab. 26, 2016 (ties).

use super::REPLICATES;
use super::estimate::{ReplicateRuns, WeighedHit};
use super::proposal::Component;
use super::sampling::{RareOutcome, RarePoint, RareRound, RareSampling, pilot_runs, plateau, replicate_runs};
use super::space::{RarePlace, RareSpace};
use crate::random::{Stream, derive_seed};

/// Batches of the pilot: with a quarter of the runs getting from each level to the next, 4⁻¹¹ is reached.
const BATCHES: usize = 12;
/// One of so many runs of the pilot gets to the next level.
const KEPT: usize = 4;
/// One of so many runs of a replicate is drawn as it is drawn without a method.
const NOMINAL: usize = 10;
/// Moves of each chain.
const MOVES: usize = 5;
/// Moves are made longer or shorter until this part of them is taken.
///
/// Source: A. Gelman, G. Roberts & W. Gilks, Bayesian Stat. 5, 1996 (of one coordinate).
const TAKEN: f64 = 0.44;

/// A run, and where it comes from.
#[derive(Debug, Clone)]
struct Particle {
    run: usize,
    place: RarePlace,
    chance: usize,
    /// The number of the run drawn as without a method that it was moved from, move by move.
    ancestor: usize,
    outcome: RareOutcome,
}

/// No run is farther from the event than this in it.
#[derive(Debug, Clone, Copy)]
struct Level {
    at_most: f64,
    /// How far moves lead within it, above 0 and at most 1: a new draw.
    scale: f64,
}

#[derive(Debug)]
enum Phase {
    /// Looks for levels.
    Pilot,
    /// Makes a replicate, whose runs are in a level, in none at first.
    Replicate {
        level: Option<usize>,
    },
    Over,
}

/// Runs that come nearer and nearer to the event.
#[derive(Debug)]
pub struct SplittingSampling {
    space: RareSpace,
    seed: u64,
    budget: usize,
    levels: Vec<Level>,
    phase: Phase,
    stream: Stream,
    /// All that count in the level.
    particles: Vec<Particle>,
    /// The last members of chains, and moves that they have made, all and such as were taken.
    heads: Vec<Particle>,
    moves: usize,
    taken: usize,
    /// Where the heads may move to, or runs drawn as without a method, as asked for.
    asked: Vec<Particle>,
    /// Runs that were asked for.
    done: usize,
    /// The number of the first run of the replicate, and the part of runs that got as far as it is.
    first: usize,
    share: f64,
    /// Of the replicate, as in [`ReplicateRuns`].
    nominal_runs: u64,
    nominal_hits: Vec<usize>,
    plateau: f64,
    replicates: Vec<ReplicateRuns>,
}

impl SplittingSampling {
    /// With so many runs in all, at least [`FEWEST_RUNS`](super::FEWEST_RUNS).
    pub fn new(space: RareSpace, budget: usize, seed: u64) -> Self {
        Self {
            space,
            seed,
            budget,
            levels: Vec::new(),
            phase: Phase::Pilot,
            stream: Stream::seeded(derive_seed(seed, "pilot")),
            particles: Vec::new(),
            heads: Vec::new(),
            moves: 0,
            taken: 0,
            asked: Vec::new(),
            done: 0,
            first: 0,
            share: 1.0,
            nominal_runs: 0,
            nominal_hits: Vec::new(),
            plateau: 0.0,
            replicates: Vec::new(),
        }
    }

    /// How many of so many runs are drawn as they are drawn without a method, at least.
    pub fn nominal_runs_of(budget: usize) -> usize {
        replicate_runs(budget) / NOMINAL * REPLICATES
    }

    /// Runs of each of the pilot's batches.
    fn batch(&self) -> usize {
        pilot_runs(self.budget) / BATCHES
    }

    /// Of each replicate, drawn as without a method: all of them where the event needs no levels.
    fn nominal_size(&self) -> usize {
        let size = replicate_runs(self.budget);
        if self.levels.is_empty() { size } else { size / NOMINAL }
    }

    /// Chains of each level.
    fn chains(&self) -> usize {
        let all = (replicate_runs(self.budget) - self.nominal_size()) / self.levels.len().max(1);
        (all / MOVES).max(1)
    }

    /// Runs as they are drawn without a method.
    fn drawn(&mut self, count: usize) -> Vec<Particle> {
        let nominal = Component::nominal(&self.space);
        let draw = |run: usize| Particle {
            run,
            place: nominal.draw(&mut self.stream),
            chance: run,
            ancestor: run,
            outcome: RareOutcome { event: false, score: f64::INFINITY },
        };
        (self.done..self.done + count).map(draw).collect()
    }

    /// Where every head may move to.
    fn moved(&mut self, scale: f64) -> Vec<Particle> {
        let nominal = Component::nominal(&self.space);
        let (stream, done) = (&mut self.stream, self.done);
        let step = |(index, from): (usize, &Particle)| {
            let new = nominal.draw(stream);
            let kept = (1.0 - scale * scale).sqrt();
            let z = from.place.z.iter().zip(&new.z).map(|(old, new)| kept * old + scale * new).collect();
            let mut categories = from.place.categories.clone();
            for (category, new) in categories.iter_mut().zip(&new.categories) {
                if stream.uniform() < scale {
                    *category = *new;
                }
            }
            let run = done + index;
            let chance = if stream.index(2) == 0 { from.chance } else { run };
            Particle { run, place: RarePlace { z, categories }, chance, ..from.clone() }
        };
        self.heads.iter().enumerate().map(step).collect()
    }

    /// Moves that stay within a level are taken; whether there are more to make.
    fn take(&mut self, at_most: f64) -> bool {
        for (head, moved) in self.heads.iter_mut().zip(self.asked.drain(..)) {
            if moved.outcome.level() <= at_most {
                *head = moved;
                self.taken += 1;
            }
        }
        self.particles.extend_from_slice(&self.heads);
        self.moves += 1;
        self.moves < MOVES
    }

    /// The particles that are within a level, and which part of all they are.
    fn within(&mut self, at_most: f64) -> f64 {
        let all = self.particles.len() as f64;
        self.particles.retain(|one| one.outcome.level() <= at_most);
        self.particles.len() as f64 / all
    }

    /// So many chains from the particles, each as often begun from as another but for one: by even steps from a random one.
    fn begin_chains(&mut self, count: usize) {
        let (from, begin) = (&self.particles, self.stream.uniform());
        let index = |one: usize| ((one as f64 + begin) * from.len() as f64 / count as f64) as usize;
        self.heads = (0..count).map(|one| from[index(one).min(from.len() - 1)].clone()).collect();
        self.particles = self.heads.clone();
        (self.moves, self.taken) = (0, 0);
    }

    /// The next level of the pilot; `None` where a quarter of its runs has the event, or none is nearer to it than others.
    fn next_level(&self) -> Option<f64> {
        let mut levels: Vec<f64> = self.particles.iter().map(|one| one.outcome.level()).collect();
        levels.sort_by(f64::total_cmp);
        let before = self.levels.last().map_or(f64::INFINITY, |level| level.at_most);
        let quarter = levels[levels.len().div_ceil(KEPT) - 1];
        let next = if quarter < before {
            Some(quarter)
        } else {
            levels.iter().rev().copied().find(|level| *level < before)
        };
        next.filter(|next| *next > f64::NEG_INFINITY)
    }

    fn tell_pilot(&mut self) {
        match self.levels.last().copied() {
            None => {
                self.particles = std::mem::take(&mut self.asked);
                let first: Vec<_> = self.particles.iter().map(|one| one.outcome).collect();
                self.plateau = plateau(&first);
            }
            Some(Level { at_most, scale }) => {
                if self.take(at_most) {
                    return;
                }
                let taken = self.taken as f64 / (MOVES * self.heads.len()) as f64;
                let adapted = (scale * libm::exp(2.0 * (taken - TAKEN))).clamp(0.05, 1.0);
                self.levels.last_mut().expect("it was found").scale = adapted;
            }
        }
        // No more levels than leave some runs for each.
        let most = replicate_runs(self.budget) / 10;
        let another = self.done + self.batch() <= pilot_runs(self.budget) && self.levels.len() < most;
        match self.next_level().filter(|_| another) {
            Some(at_most) => {
                let scale = self.levels.last().map_or(0.8, |level| level.scale);
                self.levels.push(Level { at_most, scale });
                self.within(at_most);
                self.begin_chains((self.batch() / MOVES).max(1));
            }
            None => self.begin_replicate(),
        }
    }

    fn begin_replicate(&mut self) {
        let replicate = self.replicates.len();
        self.particles.clear();
        if replicate == REPLICATES {
            self.phase = Phase::Over;
            return;
        }
        self.phase = Phase::Replicate { level: None };
        self.stream = Stream::numbered(self.seed, 1 + replicate as u64);
        (self.first, self.share) = (self.done, 1.0);
    }

    /// The particles are where they shall be within their level: on to the next, or to the event.
    fn advance(&mut self, level: Option<usize>) {
        let next = level.map_or(0, |level| level + 1);
        let Some(Level { at_most, .. }) = self.levels.get(next).copied() else { return self.end_replicate() };
        self.share *= self.within(at_most);
        if self.particles.is_empty() {
            return self.end_replicate();
        }
        self.begin_chains(self.chains());
        self.phase = Phase::Replicate { level: Some(next) };
    }

    fn end_replicate(&mut self) {
        let runs = self.done - self.first;
        // Whoever has the event is within all levels, and the last share is theirs.
        if !self.particles.is_empty() {
            self.share *= self.within(f64::NEG_INFINITY);
        }
        let count = self.particles.len() as f64;
        let mut hits: Vec<WeighedHit> = Vec::new();
        for Particle { run, place, chance, ancestor, .. } in std::mem::take(&mut self.particles) {
            let weight = self.share * runs as f64 / count;
            match hits.iter_mut().find(|hit| hit.run == run) {
                Some(same) => same.weight += weight,
                None => {
                    let point = self.space.point(&place);
                    hits.push(WeighedHit { run, lineage: ancestor, chance, point, weight, place });
                }
            }
        }
        let probability = if hits.is_empty() { 0.0 } else { self.share };
        let (nominal_runs, nominal_hits) = (self.nominal_runs, std::mem::take(&mut self.nominal_hits));
        self.replicates.push(ReplicateRuns {
            probability,
            runs,
            first: self.first,
            nominal_runs,
            nominal_hits,
            hits,
            surplus: 0.0,
        });
        self.begin_replicate();
    }
}

impl RareSampling for SplittingSampling {
    fn ask(&mut self) -> Option<RareRound> {
        self.asked = match self.phase {
            Phase::Over => return None,
            Phase::Pilot => match self.levels.last().map(|level| level.scale) {
                None => self.drawn(self.batch()),
                Some(scale) => self.moved(scale),
            },
            Phase::Replicate { level: None } => self.drawn(self.nominal_size()),
            Phase::Replicate { level: Some(level) } => self.moved(self.levels[level].scale),
        };
        let point = |one: &Particle| RarePoint { chance: one.chance, point: self.space.point(&one.place) };
        let points = self.asked.iter().map(point).collect();
        Some(RareRound { points, is_pilot: matches!(self.phase, Phase::Pilot) })
    }

    fn tell(&mut self, outcomes: &[RareOutcome]) {
        self.done += outcomes.len();
        for (asked, outcome) in self.asked.iter_mut().zip(outcomes) {
            asked.outcome = *outcome;
        }
        match self.phase {
            Phase::Over => {}
            Phase::Pilot => self.tell_pilot(),
            Phase::Replicate { level: None } => {
                self.particles = std::mem::take(&mut self.asked);
                self.nominal_runs = self.particles.len() as u64;
                let hits = self.particles.iter().filter(|one| one.outcome.event);
                self.nominal_hits = hits.map(|one| one.run).collect();
                self.advance(None);
            }
            Phase::Replicate { level: Some(level) } => {
                if !self.take(self.levels[level].at_most) {
                    self.advance(Some(level));
                }
            }
        }
    }

    fn replicates(&self) -> &[ReplicateRuns] {
        &self.replicates
    }

    fn budget(&self) -> usize {
        pilot_runs(self.budget) + replicate_runs(self.budget) * REPLICATES
    }

    fn nominal_runs(&self) -> usize {
        self.nominal_size() * REPLICATES
    }

    fn plateau(&self) -> f64 {
        self.plateau
    }
}
