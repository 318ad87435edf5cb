//! Where the event happens, and where runs come near it: Sobol points, then cross-entropy from several starts.
//!
//! Every batch is weighed against all batches before it together, so that no run of the pilot is lost for those after it. Nothing is
//! estimated from these runs.
//!
//! Source: R. Rubinstein & D. Kroese, The Cross-Entropy Method, 2004; J.-M. Cornuet et al., Scand. J. Stat. 39, 2012 (weights of earlier
//! batches).

use super::proposal::{Component, diagonal, log_mixture, log_sum};
use super::sampling::RareOutcome;
use super::space::{RarePlace, RareSpace};
use crate::design::sobol_point;
use crate::random::Stream;

/// Regions that are looked into at most.
const MOST_STARTS: usize = 6;
/// Batches after the Sobol points.
const LEVELS: usize = 8;
/// Runs of a batch that lead on, of those that are of a start.
const ELITE: f64 = 0.2;
/// Variances of what is found are widened by this: weights in tails that are too thin are too large.
const WIDEN: f64 = 1.5;

/// Looks for the event.
#[derive(Debug)]
pub struct Pilot {
    space: RareSpace,
    seed: u64,
    /// Runs of each batch, the Sobol points first.
    sizes: Vec<usize>,
    batch: usize,
    starts: Vec<Component>,
    asked: Vec<RarePlace>,
    seen: Vec<Seen>,
    /// What batches were drawn from, each with its share of all runs of the pilot that there are so far, times their number.
    drawn: Vec<(f64, Component)>,
}

#[derive(Debug)]
struct Seen {
    place: RarePlace,
    outcome: RareOutcome,
    /// ln of the sum over what batches were drawn from of their runs times their density, over that which is drawn from.
    log_density: f64,
}

impl Pilot {
    pub fn new(space: RareSpace, runs: usize, seed: u64) -> Self {
        let first = (runs / 4).max(1);
        let rest = runs - first;
        let ends: Vec<usize> = (0..=LEVELS).map(|level| rest * level / LEVELS).collect();
        let sizes = [first].into_iter().chain(ends.windows(2).map(|pair| pair[1] - pair[0])).collect();
        Self {
            space,
            seed,
            sizes,
            batch: 0,
            starts: Vec::new(),
            asked: Vec::new(),
            seen: Vec::new(),
            drawn: Vec::new(),
        }
    }

    /// The next batch; `None` after the last.
    pub fn ask(&mut self) -> Option<Vec<RarePlace>> {
        let size = *self.sizes.get(self.batch)?;
        self.asked = if self.batch == 0 { self.sobol(size) } else { self.around_starts(size) };
        Some(self.asked.clone())
    }

    /// Evenly over everything that can be drawn.
    fn sobol(&mut self, size: usize) -> Vec<RarePlace> {
        self.drawn.push((size as f64, Component::nominal(&self.space)));
        let scramble = self.seed as u32 ^ (self.seed >> 32) as u32;
        // In the middle of its cell, so that none is at the edge.
        let half = 0.5 * crate::design::SOBOL_CELL;
        let point = |index| -> Vec<f64> {
            let corner = sobol_point(index, self.space.dimensions(), scramble);
            corner.into_iter().map(|share| share + half).collect()
        };
        (0..size).map(|index| self.space.place(&point(index))).collect()
    }

    /// Of every start the same number.
    fn around_starts(&mut self, size: usize) -> Vec<RarePlace> {
        let mut stream = Stream::numbered(self.seed, self.batch as u64);
        let count = self.starts.len();
        let mut places = Vec::with_capacity(size);
        for (index, start) in self.starts.iter().enumerate() {
            let own = size * (index + 1) / count - size * index / count;
            places.extend((0..own).map(|_| start.draw(&mut stream)));
            self.drawn.push((own as f64, start.clone()));
        }
        places
    }

    pub fn tell(&mut self, outcomes: &[RareOutcome]) {
        let told = self.asked.drain(..).zip(outcomes);
        self.seen.extend(told.map(|(place, outcome)| Seen { place, outcome: *outcome, log_density: 0.0 }));
        for one in &mut self.seen {
            let parts = self.drawn.iter().map(|(runs, component)| (*runs, component));
            one.log_density = log_mixture(parts, &one.place);
        }
        if self.batch == 0 {
            self.begin();
        }
        self.batch += 1;
        self.follow(self.batch + 1 >= self.sizes.len());
    }

    /// Starts are the points that are nearer the event than all of their neighbours.
    fn begin(&mut self) {
        let mut order: Vec<usize> = (0..self.seen.len()).collect();
        order.sort_by(|one, other| self.level(*one).total_cmp(&self.level(*other)).then(one.cmp(other)));
        let mut heads: Vec<usize> = Vec::new();
        for index in order {
            if heads.len() == MOST_STARTS || self.level(index) == f64::INFINITY {
                break;
            }
            let far = |head: &usize| {
                self.space.distance(&self.seen[*head].place, &self.seen[index].place) > self.space.apart()
            };
            if heads.iter().all(far) && self.is_best_of_neighbours(index) {
                heads.push(index);
            }
        }
        let shares = self.space.shares().to_vec();
        let around = |head: &usize| {
            let mean = self.seen[*head].place.z.clone();
            let covariance = diagonal(mean.len(), 1.0);
            Component::new(&self.space, mean, &covariance, shares.clone()).expect("a positive covariance")
        };
        self.starts = heads.iter().map(around).collect();
        if self.starts.is_empty() {
            // Nothing says where to look.
            self.starts.push(Component::wide(&self.space));
        }
    }

    fn level(&self, index: usize) -> f64 {
        self.seen[index].outcome.level()
    }

    fn is_best_of_neighbours(&self, index: usize) -> bool {
        let distance = |other: &usize| self.space.distance(&self.seen[index].place, &self.seen[*other].place);
        let mut others: Vec<usize> = (0..self.seen.len()).filter(|other| *other != index).collect();
        let count = (2 * self.space.dimensions() + 2).min(others.len());
        if count == 0 {
            return true;
        }
        others.sort_by(|one, other| distance(one).total_cmp(&distance(other)).then(one.cmp(other)));
        others[..count].iter().all(|other| self.level(*other) >= self.level(index))
    }

    /// Moves every start to where those of its runs are that came nearest the event.
    fn follow(&mut self, last: bool) {
        let owner: Vec<usize> = self.seen.iter().map(|one| self.owner(&one.place)).collect();
        let least = 3 * (self.space.continuous() + 1) + 2;
        let size = self.sizes.get(self.batch.min(self.sizes.len() - 1)).copied().unwrap_or(0);
        let per_start = size as f64 / self.starts.len() as f64;
        let wanted = ((ELITE * per_start) as usize).max(least);
        let mut moved = Vec::with_capacity(self.starts.len());
        for (index, start) in self.starts.iter().enumerate() {
            let mut own: Vec<&Seen> =
                self.seen.iter().zip(&owner).filter(|(_, of)| **of == index).map(|(seen, _)| seen).collect();
            own.sort_by(|one, other| one.outcome.level().total_cmp(&other.outcome.level()));
            let events = own.iter().filter(|one| one.outcome.event).count();
            own.truncate(events.max(wanted));
            own.retain(|one| one.outcome.level() < f64::INFINITY);
            moved.push(if own.is_empty() { start.clone() } else { self.fitted(&own, start, last) });
        }
        self.starts = moved;
    }

    /// The start under whose density a place is likeliest.
    fn owner(&self, place: &RarePlace) -> usize {
        let ratios = self.starts.iter().map(|start| start.log_ratio(place));
        ratios.enumerate().max_by(|one, other| one.1.total_cmp(&other.1)).map_or(0, |(index, _)| index)
    }

    /// The component nearest to what is drawn among these places: their weighed mean and covariance, the fewer the places the nearer to
    /// the covariance of what is drawn.
    fn fitted(&self, own: &[&Seen], start: &Component, last: bool) -> Component {
        let logs: Vec<f64> = own.iter().map(|one| -one.log_density).collect();
        let sum = log_sum(&logs);
        let weights: Vec<f64> = logs.iter().map(|log| libm::exp(log - sum)).collect();
        let effective = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>();
        let dimensions = self.space.continuous();
        let weighed = |of: &dyn Fn(&RarePlace) -> f64| {
            own.iter().zip(&weights).map(|(one, weight)| weight * of(&one.place)).sum::<f64>()
        };
        let mean: Vec<f64> = (0..dimensions).map(|axis| weighed(&|place| place.z[axis])).collect();
        let shrink = (dimensions as f64 + 2.0) / (dimensions as f64 + 2.0 + effective);
        let widen = if last { WIDEN } else { 1.0 };
        let covariance: Vec<Vec<f64>> = (0..dimensions)
            .map(|row| {
                let entry = |column: usize| {
                    let own = weighed(&|place| (place.z[row] - mean[row]) * (place.z[column] - mean[column]));
                    let drawn = if row == column { 1.0 } else { 0.0 };
                    widen * ((1.0 - shrink) * own + shrink * drawn)
                };
                (0..dimensions).map(entry).collect()
            })
            .collect();
        let categories = self.space.shares().iter().enumerate().map(|(axis, shares)| {
            let options = shares.iter().filter(|share| **share > 0.0).count() as f64;
            let trust = 0.9 * effective / (effective + options);
            let mut mixed: Vec<f64> = shares.iter().map(|share| (1.0 - trust) * share).collect();
            for (one, weight) in own.iter().zip(&weights) {
                mixed[one.place.categories[axis]] += trust * weight;
            }
            mixed
        });
        let categories = categories.collect();
        Component::new(&self.space, mean, &covariance, categories).unwrap_or_else(|| start.clone())
    }
    /// What was found: components with their shares, of sum 1, half of it equal and half by how likely what they found is. Those that
    /// found no event are left out where others did, and so is one of two in the same place.
    pub fn components(&self) -> Vec<(f64, Component)> {
        let mut found: Vec<(f64, &Component)> = self.starts.iter().map(|start| (0.0, start)).collect();
        for one in self.seen.iter().filter(|one| one.outcome.event) {
            found[self.owner(&one.place)].0 += libm::exp(-one.log_density);
        }
        if found.iter().any(|one| one.0 > 0.0) {
            found.retain(|one| one.0 > 0.0);
        }
        found.sort_by(|one, other| other.0.total_cmp(&one.0));
        let mut kept: Vec<(f64, &Component)> = Vec::new();
        for (mass, component) in found {
            let same = |other: &&mut (f64, &Component)| {
                other.1.squared_distance(&component.mean) < 1.0 && self.space.shares().is_empty()
            };
            match kept.iter_mut().find(same) {
                Some(other) => other.0 += mass,
                None => kept.push((mass, component)),
            }
        }
        let sum: f64 = kept.iter().map(|one| one.0).sum();
        let (count, kept) = (kept.len() as f64, kept.into_iter());
        let share = |mass: f64| if sum > 0.0 { 0.5 / count + 0.5 * mass / sum } else { 1.0 / count };
        kept.map(|(mass, component)| (share(mass), component.clone())).collect()
    }

    /// What became of the Sobol points.
    pub fn first(&self) -> Vec<RareOutcome> {
        let first = self.sizes[0].min(self.seen.len());
        self.seen[..first].iter().map(|one| one.outcome).collect()
    }
}
