//! What methods ask for and are told.

use super::REPLICATES;
use super::estimate::ReplicateRuns;

/// One of so many runs is of the pilot, at most [`MOST_PILOT`].
const PILOT: usize = 4;
const MOST_PILOT: usize = 10_000;

/// Of so many runs, those of a pilot.
pub fn pilot_runs(budget: usize) -> usize {
    (budget / PILOT).min(MOST_PILOT)
}

/// Of so many runs, those of each replicate after a pilot, at most.
pub fn replicate_runs(budget: usize) -> usize {
    (budget - pilot_runs(budget)) / REPLICATES
}

/// A run that a method wants.
#[derive(Debug, Clone, PartialEq)]
pub struct RarePoint {
    /// Which chance beyond the point the run has, from 0: runs of one number have the same.
    pub chance: usize,
    /// One coordinate an axis, above 0 and below 1.
    pub point: Vec<f64>,
}

/// What became of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RareOutcome {
    /// Whether the event happened.
    pub event: bool,
    /// How far it was from that: the less, the nearer. Infinite where nothing says so, never NaN.
    pub score: f64,
}

impl RareOutcome {
    /// Of runs with the event, less than that of all others.
    pub(super) fn level(self) -> f64 {
        if self.event { f64::NEG_INFINITY } else { self.score }
    }
}

/// Runs that are asked for together.
#[derive(Debug, Clone, PartialEq)]
pub struct RareRound {
    /// In the order in which their outcomes are told.
    pub points: Vec<RarePoint>,
    /// Whether it only finds out where to look, and nothing is estimated from it.
    pub is_pilot: bool,
}

/// A method. Nothing but the outcomes and the seed decides what it asks for.
pub trait RareSampling: Send + Sync {
    /// The next round; `None` once there are no more. Asked once for each round.
    fn ask(&mut self) -> Option<RareRound>;

    /// What became of the last round's runs, in their order.
    fn tell(&mut self, outcomes: &[RareOutcome]);

    /// What was told so far of runs that count.
    fn replicates(&self) -> &[ReplicateRuns];

    /// Runs that it may ask for in all, at most.
    fn budget(&self) -> usize;

    /// Runs that are drawn as they are drawn without a method, as far as the method knows: those that [`ReplicateRuns::nominal_runs`]
    /// counts in the end.
    fn nominal_runs(&self) -> usize;

    /// The share of the first runs without the event that are as far from it as another, farther than none: where most are, nothing
    /// leads to the event.
    fn plateau(&self) -> f64;
}

/// The share of those without the event whose score is the commonest.
pub fn plateau(outcomes: &[RareOutcome]) -> f64 {
    let mut scores: Vec<f64> = outcomes.iter().filter(|one| !one.event).map(|one| one.score).collect();
    scores.sort_by(f64::total_cmp);
    let commonest = scores.chunk_by(|one, other| one == other).map(<[f64]>::len).max().unwrap_or(0);
    if commonest < 2 { 0.0 } else { commonest as f64 / scores.len() as f64 }
}
