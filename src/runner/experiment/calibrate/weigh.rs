//! From what candidates did to weights: the fit, conditions held back, other persons, and what no mixture reaches.

use super::candidates::WeighedCandidates;
use super::observed::Observed;
use super::parameters::BoundedParameters;
use super::record::HeldRuns;
use numbers::inference::{
    CandidateShares, EntropyWeights, HeldCounts, WeightTarget, maximum_entropy_within, nearest_mixture,
};
use numbers::random::{Draws, Stream, derive_seed};
use scenario::ObservedRow;

/// Populations of persons drawn again.
const RESAMPLED: usize = 20;
/// A target that the nearest mixture misses by more errors than this is out of reach.
const OUT_OF_REACH: f64 = 2.0;

/// What candidates did: shares of runs, and of pairs of runs, of every condition.
pub struct Features {
    /// A candidate a row: a number for each condition.
    pub shares: Vec<Vec<f64>>,
    pub spreads: Vec<Vec<f64>>,
}

impl Features {
    /// As counted in the runs.
    pub fn counted(done: &[Vec<HeldRuns>], runs: u32) -> Self {
        HeldCounts { held: &held(done), runs }.shares().into()
    }

    /// As predicted from the runs of each and of others with parameters like theirs, so that weights do not lean towards who was lucky.
    pub fn predicted(done: &[Vec<HeldRuns>], runs: u32, candidates: &WeighedCandidates) -> Self {
        HeldCounts { held: &held(done), runs }.smoothed(&candidates.coordinates()).into()
    }

    /// One for each target: the shares of those conditions, and their spreads if those are matched.
    fn of(&self, conditions: &[usize], spread: bool) -> Vec<Vec<f64>> {
        let row = |(shares, spreads): (&Vec<f64>, &Vec<f64>)| {
            let shares = conditions.iter().map(|condition| shares[*condition]);
            let spreads = conditions.iter().filter(|_| spread).map(|condition| spreads[*condition]);
            shares.chain(spreads).collect()
        };
        self.shares.iter().zip(&self.spreads).map(row).collect()
    }
}

impl From<CandidateShares> for Features {
    fn from(CandidateShares { shares, pairs }: CandidateShares) -> Self {
        Self { shares, spreads: pairs }
    }
}

fn held(done: &[Vec<HeldRuns>]) -> Vec<Vec<u32>> {
    done.iter().map(|row| row.iter().map(|one| one.held).collect()).collect()
}

/// The weighted mean of a column.
pub fn mean(rows: &[Vec<f64>], weights: &[f64], column: usize) -> f64 {
    rows.iter().zip(weights).map(|(row, weight)| weight * row[column]).sum()
}

fn targets(observed: &[Observed], conditions: &[usize], spread: bool) -> Vec<WeightTarget> {
    let shares = conditions.iter().map(|condition| observed[*condition].share);
    let spreads = conditions.iter().filter(|_| spread).map(|condition| observed[*condition].spread);
    shares.chain(spreads).collect()
}

/// What is matched, and by whom.
pub struct Weighing<'a> {
    pub features: &'a Features,
    pub observed: &'a [Observed],
    pub rows: &'a [&'a ObservedRow],
    pub spread: bool,
    /// What is known of their distribution, whatever conditions are left out.
    pub parameters: &'a BoundedParameters,
    /// How many errors of targets are their tolerance.
    pub within: f64,
    /// The same of spreads.
    pub spread_within: f64,
}

impl Weighing<'_> {
    fn all(&self) -> Vec<usize> {
        (0..self.observed.len()).collect()
    }

    /// The weights, of which the targets of these conditions know nothing.
    fn without(&self, left_out: &[usize]) -> EntropyWeights {
        let kept: Vec<usize> = self.all().into_iter().filter(|one| !left_out.contains(one)).collect();
        self.matched(&kept, self.observed)
    }

    /// Weights for what was observed in these conditions. Spreads that have a tolerance of their own have it as their error.
    fn matched(&self, conditions: &[usize], observed: &[Observed]) -> EntropyWeights {
        let mut targets = targets(observed, conditions, self.spread);
        if self.spread_within != self.within {
            for spread in &mut targets[conditions.len()..] {
                spread.error *= self.spread_within / self.within;
            }
        }
        maximum_entropy_within(self.within, &self.features_of(conditions), &targets, &self.parameters.bounds)
    }

    /// One for each target of these conditions, and behind them what is bounded.
    fn features_of(&self, conditions: &[usize]) -> Vec<Vec<f64>> {
        let mut rows = self.features.of(conditions, self.spread);
        rows.iter_mut().zip(&self.parameters.rows).for_each(|(row, bounded)| row.extend(bounded));
        rows
    }

    pub fn weights(&self) -> EntropyWeights {
        self.without(&[])
    }

    /// In words, every target that no mixture reaches, with what comes nearest.
    pub fn out_of_reach(&self) -> Vec<String> {
        let all = self.all();
        let targets = targets(self.observed, &all, self.spread);
        let nearest = nearest_mixture(&self.features_of(&all), &targets, &self.parameters.bounds);
        let mut found = Vec::new();
        for (index, (mismatch, target)) in nearest.mismatches.iter().zip(&targets).enumerate() {
            if mismatch.abs() > OUT_OF_REACH {
                let what = if index < all.len() { "the share" } else { "the spread between individuals" };
                found.push(format!(
                    "{what} of {} is {} ± {}, and the nearest mixture has {}",
                    self.rows[index % all.len()].in_words(),
                    percent(target.value),
                    percent(target.error),
                    percent((target.value + mismatch * target.error).clamp(0.0, 1.0)),
                ));
            }
        }
        found
    }

    /// What is predicted of a condition by weights that know nothing of it: share and spread.
    pub fn left_out(&self) -> Option<Vec<(f64, f64)>> {
        self.held_back(&self.all().into_iter().map(|one| vec![one]).collect::<Vec<_>>())
    }

    /// Root mean square error of shares, in `folds` parts that are held back in turn.
    pub fn folds(&self, folds: u32, seed: u64) -> Option<f64> {
        let parts = folds as usize;
        if parts < 2 {
            return None;
        }
        let order = Stream::seeded(derive_seed(seed, "folds")).shuffled(self.observed.len());
        let part = |part: usize| order.iter().skip(part).step_by(parts).copied().collect::<Vec<_>>();
        let predicted = self.held_back(&(0..parts).map(part).collect::<Vec<_>>())?;
        Some(rms(predicted.iter().zip(self.observed).map(|((share, _), one)| share - one.share.value)))
    }

    fn held_back(&self, parts: &[Vec<usize>]) -> Option<Vec<(f64, f64)>> {
        if parts.len() < 2 {
            return None;
        }
        let mut predicted = vec![(0.0, 0.0); self.observed.len()];
        for part in parts {
            let weights = self.without(part).weights;
            for condition in part {
                predicted[*condition] = (
                    mean(&self.features.shares, &weights, *condition),
                    mean(&self.features.spreads, &weights, *condition),
                );
            }
        }
        Some(predicted)
    }

    /// Weights for persons drawn again.
    pub fn resampled(&self, seed: u64) -> Vec<Vec<f64>> {
        let all = self.all();
        let again = |number: usize| {
            let mut stream = Stream::seeded(derive_seed(seed, &format!("persons/{number}")));
            let observed: Vec<Observed> =
                self.rows.iter().map(|row| Observed::resampled(row, &mut stream)).collect();
            self.matched(&all, &observed).weights
        };
        (0..RESAMPLED).map(again).collect()
    }
}

/// Root mean square.
pub fn rms(errors: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = errors.len() as f64;
    libm::sqrt(errors.map(|one| one * one).sum::<f64>() / count)
}

/// Such as `42.9 %`.
pub fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}
