//! What weighed runs say of a probability: a bound that holds without assumptions, and an estimate that has to be refused where its
//! own runs speak against it.

use std::collections::BTreeMap;

use super::space::{RarePlace, RareSpace};
use crate::distributions::{binomial_at_least, binomial_at_most, student_quantile};
use crate::inference::{Interval, upper_bound};

/// A run with the event, and what it weighs.
#[derive(Debug, Clone, PartialEq)]
pub struct WeighedHit {
    /// Its number among the runs that are asked for, from 0.
    pub run: usize,
    /// Runs of one number are moved from one run, and so tell less than others; of methods that move none, the run's own.
    pub lineage: usize,
    /// What its chance beyond the point is; see [`RarePoint`](super::RarePoint).
    pub chance: usize,
    /// Its coordinates.
    pub point: Vec<f64>,
    /// In runs of its replicate: those of weight 1 are drawn as without a method.
    pub weight: f64,
    /// In which coordinates it is near others.
    pub(super) place: RarePlace,
}

/// What one replicate came to: independent of the others, and unbiased.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplicateRuns {
    /// The mean of the weights of its runs, 0 for those without the event.
    pub probability: f64,
    /// How many runs were made for it.
    pub runs: usize,
    /// The number of its first run.
    pub first: usize,
    /// How many of its runs, the first ones, are drawn as without a method, chosen before anything is known of them.
    pub nominal_runs: u64,
    /// The numbers of those of them that have the event.
    pub nominal_hits: Vec<usize>,
    /// Its runs with the event.
    pub hits: Vec<WeighedHit>,
    /// By how much more of its nominal runs are of encounters that can be than of all replicates together, in their mean of these; 0 where
    /// none is [left out](leaving_out).
    pub surplus: f64,
}

impl ReplicateRuns {
    /// What it adds to a ratio of means of this value, of which the probability is the numerator: the numerator and what it is divided by vary
    /// from replicate to replicate. The mean over all replicates is the value.
    ///
    /// Source: W. G. Cochran, Sampling Techniques, 1977, section 6.3: the variance of a ratio by its linear part.
    pub(super) fn of_ratio(&self, value: f64) -> f64 {
        self.probability - value * self.surplus
    }

    /// Of a part of the event alone, which the runs that it holds for (by their numbers) have: as unbiased as of the whole.
    pub fn only(&self, has: impl Fn(usize) -> bool) -> Self {
        let hits: Vec<WeighedHit> = self.hits.iter().filter(|hit| has(hit.run)).cloned().collect();
        // Nothing has a positive sum: `sum` of nothing is -0.
        let sum = hits.iter().fold(0.0, |sum, hit| sum + hit.weight);
        Self {
            probability: sum / self.runs.max(1) as f64,
            runs: self.runs,
            first: self.first,
            nominal_runs: self.nominal_runs,
            nominal_hits: self.nominal_hits.iter().copied().filter(|run| has(*run)).collect(),
            hits,
            surplus: self.surplus,
        }
    }
}

/// The same replicates of the encounters that can be: runs of these numbers, in order, are left out, and none of them has the event. What is
/// left is divided by its share of everything, which the nominal runs tell.
pub fn leaving_out(replicates: &[ReplicateRuns], left_out: &[usize]) -> Vec<ReplicateRuns> {
    let within = |first: usize, runs: u64| {
        let place = |run: usize| left_out.partition_point(|one| *one < run);
        (place(first + runs as usize) - place(first)) as u64
    };
    let kept_of = |one: &ReplicateRuns| one.nominal_runs - within(one.first, one.nominal_runs);
    let drawn: u64 = replicates.iter().map(|one| one.nominal_runs).sum();
    let kept: u64 = replicates.iter().map(kept_of).sum();
    let scale = if kept > 0 { drawn as f64 / kept as f64 } else { 1.0 };
    let mean = kept as f64 / replicates.len() as f64;
    let one = |one: &ReplicateRuns| {
        let surplus = kept_of(one) as f64 - one.nominal_runs as f64 / scale;
        let hit = |hit: &WeighedHit| WeighedHit { weight: hit.weight * scale, ..hit.clone() };
        ReplicateRuns {
            probability: one.probability * scale,
            nominal_runs: kept_of(one),
            nominal_hits: one.nominal_hits.clone(),
            hits: one.hits.iter().map(hit).collect(),
            surplus: if kept > 0 { surplus / mean } else { 0.0 },
            ..*one
        }
    };
    replicates.iter().map(one).collect()
}

/// On which scale the interval of replicates is symmetric.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RareScale {
    /// As Student's interval of a mean.
    Linear,
    /// Of the logarithm, by its derivative: it cannot reach below 0.
    Logarithmic,
    /// The exact interval of a share, of runs that all weigh the same.
    Exact,
}

/// Why an estimate is refused.
#[derive(Debug, Clone, PartialEq)]
pub enum RareRefusal {
    /// No run has the event.
    NoHits,
    /// So many hits of equal weight would say as much as those that there are; fewer than [`LEAST_EFFECTIVE`].
    FewHits(f64),
    /// One run has this share of the sum of weights, [`LARGEST_SHARE`] or more.
    OneRun(f64),
    /// Runs drawn as without a method have the event so much more or less often that chance does so with at most this probability.
    Contradicted(f64),
    /// Standard deviation of the replicates, in their mean: [`LARGEST_DEVIATION`] or more.
    Spread(f64),
    /// In the second half hits were found away from all of the first half; their share of its weight.
    NewCluster(f64),
}

/// Hits of equal weight that an estimate must be worth.
pub const LEAST_EFFECTIVE: f64 = 100.0;
/// Of the sum of weights, that one run must not have.
pub const LARGEST_SHARE: f64 = 0.05;
/// What is less likely by chance is a contradiction.
pub const CONTRADICTION: f64 = 1e-3;
/// Of the replicates' standard deviation in their mean.
pub const LARGEST_DEVIATION: f64 = 0.5;
/// Less weight than this is no cluster.
const CLUSTER_SHARE: f64 = 0.01;

/// What may be said of the probability.
#[derive(Debug, Clone, PartialEq)]
pub struct RareEstimate {
    /// The mean of the replicates.
    pub value: f64,
    /// Standard error of the mean; infinite of a single one.
    pub error: f64,
    /// On which scale intervals are.
    pub scale: RareScale,
    /// Of how many replicates.
    pub replicates: usize,
    /// Standard deviation of the replicates, in their mean, with that of what they are divided by where runs are left out; 0 of a mean of 0.
    pub relative_deviation: f64,
    /// So many hits of equal weight would say as much: (Σ w)² / Σ w²; where some of them were moved from one run, no more than would
    /// spread as the replicates do.
    ///
    /// Source: L. Kish, Survey Sampling, 1965.
    pub effective_size: f64,
    /// The largest weight in the sum of all, of a run or of those that were moved from one.
    pub largest_share: f64,
    /// Runs with the event.
    pub hits: usize,
    /// Runs drawn as without a method, and how many of them have the event.
    pub nominal: (u64, u64),
    /// How likely chance is to give so many nominal hits or more, or so few or fewer, whichever is less likely, twice, if the value is right.
    pub contradiction: f64,
    /// Why it must not be believed; empty where nothing speaks against it.
    pub refusals: Vec<RareRefusal>,
    /// Clusters of hits, the heaviest first: their share of the weight, and the index of their heaviest hit among all of all replicates.
    pub clusters: Vec<(f64, usize)>,
}

impl RareEstimate {
    /// From all replicates, of which there is at least one.
    pub fn of(space: &RareSpace, replicates: &[ReplicateRuns], scale: RareScale) -> Self {
        let count = replicates.len() as f64;
        let value = replicates.iter().map(|one| one.probability).sum::<f64>() / count;
        let apart = replicates.iter().map(|one| one.of_ratio(value) - value);
        let squares: f64 = apart.map(|apart| apart * apart).sum();
        let deviation = if replicates.len() < 2 { f64::INFINITY } else { (squares / (count - 1.0)).sqrt() };
        let relative_deviation = if value > 0.0 { deviation / value } else { 0.0 };
        let weights = || replicates.iter().flat_map(weights_of);
        let sum: f64 = weights().sum();
        let squares: f64 = weights().map(|weight| weight * weight).sum();
        let kish = if squares > 0.0 { sum * sum / squares } else { 0.0 };
        let lineages: Vec<BTreeMap<usize, f64>> = replicates.iter().map(by_lineage).collect();
        let largest = lineages.iter().flat_map(BTreeMap::values).copied().fold(0.0, f64::max);
        let hits: usize = replicates.iter().map(|one| one.hits.len()).sum();
        let related = lineages.iter().map(BTreeMap::len).sum::<usize>() < hits;
        // Hits of one lineage say less than so many. So many hits of equal weight would spread as the replicates do.
        let spread = count / (relative_deviation * relative_deviation);
        let runs = replicates.iter().map(|one| one.nominal_runs).sum();
        let events = replicates.iter().map(|one| one.nominal_hits.len() as u64).sum();
        let likely = value.min(1.0);
        let contradiction = (2.0
            * binomial_at_least(events, runs, likely).min(binomial_at_most(events, runs, likely)))
        .min(1.0);
        let mut estimate = Self {
            value,
            error: deviation / count.sqrt(),
            scale,
            replicates: replicates.len(),
            relative_deviation,
            effective_size: if related { kish.min(spread) } else { kish },
            largest_share: if sum > 0.0 { largest / sum } else { 0.0 },
            hits,
            nominal: (runs, events),
            contradiction,
            refusals: Vec::new(),
            clusters: Vec::new(),
        };
        let clusters = Clusters::of(space, replicates);
        estimate.refusals = estimate.speaking_against(&clusters);
        estimate.clusters = clusters.heaviest(replicates);
        estimate
    }

    fn speaking_against(&self, clusters: &Clusters) -> Vec<RareRefusal> {
        let mut found = Vec::new();
        // Runs of equal weight have an exact interval, whatever they are.
        if self.scale == RareScale::Exact {
            return found;
        }
        if self.hits == 0 {
            found.push(RareRefusal::NoHits);
        } else {
            if self.effective_size < LEAST_EFFECTIVE {
                found.push(RareRefusal::FewHits(self.effective_size));
            }
            if self.largest_share >= LARGEST_SHARE {
                found.push(RareRefusal::OneRun(self.largest_share));
            }
            if self.relative_deviation >= LARGEST_DEVIATION {
                found.push(RareRefusal::Spread(self.relative_deviation));
            }
        }
        if self.contradiction <= CONTRADICTION {
            found.push(RareRefusal::Contradicted(self.contradiction));
        }
        if clusters.new_share > CLUSTER_SHARE {
            found.push(RareRefusal::NewCluster(clusters.new_share));
        }
        found
    }

    /// Where the probability lies at this confidence (0..1), if nothing speaks against the estimate: replicates are taken for draws of a
    /// distribution whose mean behaves as Student's of a normal one.
    pub fn interval(&self, confidence: f64) -> Interval {
        let each = 0.5 + confidence / 2.0;
        Interval { low: self.lower(each), high: self.upper(each) }
    }

    /// The probability is at most this, at one-sided `confidence`.
    pub fn upper(&self, confidence: f64) -> f64 {
        self.end(confidence, 1.0)
    }

    /// The probability is at least this, at one-sided `confidence`.
    pub fn lower(&self, confidence: f64) -> f64 {
        self.end(confidence, -1.0)
    }

    fn end(&self, confidence: f64, side: f64) -> f64 {
        let (runs, hits) = self.nominal;
        if self.scale == RareScale::Exact {
            return if side > 0.0 {
                upper_bound(hits, runs, confidence)
            } else {
                crate::inference::lower_bound(hits, runs, confidence)
            };
        }
        // Of no hits nothing has a spread, and nothing but the nominal runs bounds it.
        if self.value <= 0.0 || self.replicates < 2 || !self.error.is_finite() {
            return if side > 0.0 { 1.0 } else { 0.0 };
        }
        let half = student_quantile(confidence, self.replicates as f64 - 1.0) * self.error;
        let end = match self.scale {
            RareScale::Logarithmic => self.value * libm::exp(side * half / self.value),
            RareScale::Linear | RareScale::Exact => self.value + side * half,
        };
        end.clamp(0.0, 1.0)
    }

    /// The probability is at most this at one-sided `confidence`, whatever the method did: by the nominal runs alone.
    ///
    /// Source: C. J. Clopper & E. S. Pearson, Biometrika 26, 1934.
    pub fn guaranteed(&self, confidence: f64) -> f64 {
        let (runs, hits) = self.nominal;
        if runs == 0 { 1.0 } else { upper_bound(hits, runs, confidence) }
    }

    /// A region that no nominal run fell into has at most this probability, at `confidence`: about 3 / n at 95 %. No method finds every
    /// region.
    pub fn unseen(&self, confidence: f64) -> f64 {
        if self.nominal.0 == 0 { 1.0 } else { upper_bound(0, self.nominal.0, confidence) }
    }
}

/// What its hits weigh in the mean of the replicates: of replicates of different sizes, not what they weigh within.
fn weights_of(replicate: &ReplicateRuns) -> impl Iterator<Item = f64> {
    let runs = replicate.runs.max(1) as f64;
    replicate.hits.iter().map(move |hit| hit.weight / runs)
}

/// The same of all hits that were moved from one run.
fn by_lineage(replicate: &ReplicateRuns) -> BTreeMap<usize, f64> {
    let mut found = BTreeMap::new();
    for (hit, weight) in replicate.hits.iter().zip(weights_of(replicate)) {
        *found.entry(hit.lineage).or_insert(0.0) += weight;
    }
    found
}

/// Hits that are near each other.
struct Clusters {
    /// Share of the second half's weight away from all hits of the first half.
    new_share: f64,
    /// Of every hit.
    of: Vec<usize>,
    count: usize,
}

impl Clusters {
    fn of(space: &RareSpace, replicates: &[ReplicateRuns]) -> Self {
        let (first, second) = replicates.split_at(replicates.len() / 2);
        let cover = cover(space, first.iter().flat_map(|one| &one.hits));
        let (mut sum, mut new) = (0.0, 0.0);
        for replicate in second {
            for (hit, weight) in replicate.hits.iter().zip(weights_of(replicate)) {
                sum += weight;
                if !cover.iter().any(|known| space.distance(known, &hit.place) <= space.apart()) {
                    new += weight;
                }
            }
        }
        let new_share = if sum > 0.0 && !first.is_empty() { new / sum } else { 0.0 };
        let all: Vec<&WeighedHit> = replicates.iter().flat_map(|one| &one.hits).collect();
        let cover = self::cover(space, all.iter().copied());
        let (group, count) = joined(space, &cover);
        let nearest = |hit: &&WeighedHit| {
            let distances = cover.iter().map(|known| space.distance(known, &hit.place));
            let nearest = distances.enumerate().min_by(|one, other| one.1.total_cmp(&other.1));
            group[nearest.map_or(0, |(index, _)| index)]
        };
        let of = if cover.is_empty() { Vec::new() } else { all.iter().map(nearest).collect() };
        Self { new_share, of, count }
    }

    /// Clusters by their share of the weight, each with its heaviest hit.
    fn heaviest(&self, replicates: &[ReplicateRuns]) -> Vec<(f64, usize)> {
        let weights: Vec<f64> = replicates.iter().flat_map(weights_of).collect();
        let all: f64 = weights.iter().sum();
        let mut clusters = vec![(0.0, usize::MAX); self.count];
        for (hit, (weight, cluster)) in weights.iter().zip(&self.of).enumerate() {
            let own = &mut clusters[*cluster];
            own.0 += weight / all;
            if own.1 == usize::MAX || *weight > weights[own.1] {
                own.1 = hit;
            }
        }
        clusters.retain(|one| one.1 != usize::MAX);
        clusters.sort_by(|one, other| other.0.total_cmp(&one.0).then(one.1.cmp(&other.1)));
        clusters
    }
}

/// Some of the hits, of which one is within a half of [`RareSpace::apart`] from every other.
fn cover<'a>(space: &RareSpace, hits: impl Iterator<Item = &'a WeighedHit>) -> Vec<RarePlace> {
    let mut cover: Vec<RarePlace> = Vec::new();
    for hit in hits {
        if cover.len() < MOST_COVERED
            && !cover.iter().any(|known| space.distance(known, &hit.place) <= 0.5 * space.apart())
        {
            cover.push(hit.place.clone());
        }
    }
    cover
}

/// Beyond, hits are everywhere.
const MOST_COVERED: usize = 2000;

/// Places that a chain of others joins are of one group: the group of each, and how many there are.
fn joined(space: &RareSpace, places: &[RarePlace]) -> (Vec<usize>, usize) {
    let mut group = vec![usize::MAX; places.len()];
    let mut count = 0;
    for first in 0..places.len() {
        if group[first] != usize::MAX {
            continue;
        }
        group[first] = count;
        let mut open = vec![first];
        while let Some(one) = open.pop() {
            for other in 0..places.len() {
                if group[other] == usize::MAX && space.distance(&places[one], &places[other]) <= space.apart()
                {
                    group[other] = count;
                    open.push(other);
                }
            }
        }
        count += 1;
    }
    (group, count)
}
