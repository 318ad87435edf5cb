//! From what candidates did to weights: the fit, conditions held back, other persons, and what no mixture reaches.

use super::candidates::WeighedCandidates;
use super::observed::Observed;
use super::parameters::BoundedParameters;
use super::record::HeldRuns;
use numbers::inference::{
    CandidateShares, EntropyWeights, HeldCounts, RatioFeatures, WeightTarget, nearest_ratios, ratio_weights,
    weighed_ratio,
};
use numbers::random::{Draws, Stream, derive_seed};
use scenario::ObservedRow;

/// Populations of persons drawn again.
pub const RESAMPLED: usize = 20;
/// A target that the nearest mixture misses by more errors than this is out of reach.
const OUT_OF_REACH: f64 = 2.0;

/// What candidates did: shares of runs, and of pairs of runs, of every condition; a candidate a row, a number for each condition.
pub struct Features {
    held: Vec<Vec<f64>>,
    pairs_held: Vec<Vec<f64>>,
    /// In which it can be said whether it held.
    defined: Vec<Vec<f64>>,
    pairs_defined: Vec<Vec<f64>>,
}

impl Features {
    /// As counted in the runs, of which those that are `defined` count; without rows all do.
    pub fn counted(done: &[Vec<HeldRuns>], defined: &[Vec<u32>], runs: u32) -> Self {
        HeldCounts { held: &held(done), defined, runs }.shares().into()
    }

    /// As predicted from the runs of each and of others with parameters like theirs, so that weights do not lean towards who was lucky.
    pub fn predicted(
        done: &[Vec<HeldRuns>],
        defined: &[Vec<u32>],
        runs: u32,
        candidates: &WeighedCandidates,
    ) -> Self {
        HeldCounts { held: &held(done), defined, runs }.smoothed(&candidates.coordinates()).into()
    }

    /// The share of a condition by weights: of the runs that count; `None` where none do.
    pub fn share(&self, weights: &[f64], condition: usize) -> Option<f64> {
        let features = RatioFeatures { held: &self.held, defined: &self.defined };
        weighed_ratio(features, weights, condition)
    }

    /// The share of pairs of a person's runs in which both hold, of those that both count.
    pub fn spread(&self, weights: &[f64], condition: usize) -> Option<f64> {
        let features = RatioFeatures { held: &self.pairs_held, defined: &self.pairs_defined };
        weighed_ratio(features, weights, condition)
    }

    /// What candidates do about each target, and how often it can be said.
    fn of(&self, targets: &[Target]) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let columns = |shares: &[Vec<f64>], pairs: &[Vec<f64>]| {
            let row = |(shares, pairs): (&Vec<f64>, &Vec<f64>)| {
                let of =
                    |one: &Target| if one.is_spread { pairs[one.condition] } else { shares[one.condition] };
                targets.iter().map(of).collect()
            };
            shares.iter().zip(pairs).map(row).collect()
        };
        (columns(&self.held, &self.pairs_held), columns(&self.defined, &self.pairs_defined))
    }
}

impl From<CandidateShares> for Features {
    fn from(CandidateShares { shares, pairs, defined, defined_pairs }: CandidateShares) -> Self {
        Self { held: shares, pairs_held: pairs, defined, pairs_defined: defined_pairs }
    }
}

fn held(done: &[Vec<HeldRuns>]) -> Vec<Vec<u32>> {
    done.iter().map(|row| row.iter().map(|one| one.held).collect()).collect()
}

/// What weights are to match.
struct Target {
    condition: usize,
    /// Not the share of trials, but of pairs of a person's trials.
    is_spread: bool,
    wanted: WeightTarget,
}

/// The shares of these conditions and behind them those of pairs that are known and matched.
fn targets(observed: &[Observed], conditions: &[usize], spread_within: &[Option<f64>]) -> Vec<Target> {
    let shares = conditions.iter().map(|condition| {
        let wanted = observed[*condition].share;
        Target { condition: *condition, is_spread: false, wanted }
    });
    let spreads = conditions.iter().filter_map(|condition| {
        let wanted = observed[*condition].spread.filter(|_| spread_within[*condition].is_some())?;
        Some(Target { condition: *condition, is_spread: true, wanted })
    });
    shares.chain(spreads).collect()
}

/// What is matched, and by whom.
pub struct Weighing<'a> {
    pub features: &'a Features,
    pub observed: &'a [Observed],
    pub rows: &'a [&'a ObservedRow],
    /// What is known of their distribution, whatever conditions are left out.
    pub parameters: &'a BoundedParameters,
    /// How many errors of targets are their tolerance.
    pub within: f64,
    /// The same of the spread of each condition; `None` where it is not matched.
    pub spread_within: &'a [Option<f64>],
}

impl Weighing<'_> {
    fn all(&self) -> Vec<usize> {
        (0..self.observed.len()).collect()
    }

    /// The weights, of which the targets of these conditions know nothing.
    fn without(&self, left_out: &[usize]) -> Option<EntropyWeights> {
        let kept: Vec<usize> = self.all().into_iter().filter(|one| !left_out.contains(one)).collect();
        self.matched(&kept, self.observed)
    }

    /// Weights for what was observed in these conditions; `None` where none are found. Spreads that have a tolerance of their own have it
    /// as their error.
    fn matched(&self, conditions: &[usize], observed: &[Observed]) -> Option<EntropyWeights> {
        let mut targets = targets(observed, conditions, self.spread_within);
        for spread in targets.iter_mut().filter(|one| one.is_spread) {
            let within = self.spread_within[spread.condition].unwrap_or(self.within);
            if within != self.within {
                spread.wanted.error *= within / self.within;
            }
        }
        let (held, defined) = self.features_of(&targets);
        let features = RatioFeatures { held: &held, defined: &defined };
        let wanted: Vec<WeightTarget> = targets.iter().map(|one| one.wanted).collect();
        ratio_weights(self.within, features, &wanted, &self.parameters.bounds)
    }

    /// One for each target, and behind them what is bounded; and how often each target can be told.
    fn features_of(&self, targets: &[Target]) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let (mut held, defined) = self.features.of(targets);
        held.iter_mut().zip(&self.parameters.rows).for_each(|(row, bounded)| row.extend(bounded));
        (held, defined)
    }

    pub fn weights(&self) -> Option<EntropyWeights> {
        self.without(&[])
    }

    /// In words, every target that no mixture reaches, with what comes nearest.
    pub fn out_of_reach(&self) -> Vec<String> {
        let targets = targets(self.observed, &self.all(), self.spread_within);
        let (held, defined) = self.features_of(&targets);
        let features = RatioFeatures { held: &held, defined: &defined };
        let wanted: Vec<WeightTarget> = targets.iter().map(|one| one.wanted).collect();
        let Some(nearest) = nearest_ratios(features, &wanted, &self.parameters.bounds) else {
            return vec!["there is a condition in which no two runs of any candidate count".to_string()];
        };
        let mut found = Vec::new();
        for (mismatch, Target { condition, is_spread, wanted }) in nearest.mismatches.iter().zip(&targets) {
            if mismatch.abs() > OUT_OF_REACH {
                let what = if *is_spread { "the spread between individuals" } else { "the share" };
                found.push(format!(
                    "{what} of {} is {} ± {}, and the nearest mixture has {}",
                    self.rows[*condition].in_words(),
                    percent(wanted.value),
                    percent(wanted.error),
                    percent((wanted.value + mismatch * wanted.error).clamp(0.0, 1.0)),
                ));
            }
        }
        found
    }

    /// What is predicted of a condition by weights that know nothing of it: share and spread.
    pub fn left_out(&self) -> Option<Vec<Predicted>> {
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
        let apart = |((share, _), one): (&Predicted, &Observed)| Some((*share)? - one.share.value);
        let apart: Option<Vec<f64>> = predicted.iter().zip(self.observed).map(apart).collect();
        Some(rms(apart?.into_iter()))
    }

    fn held_back(&self, parts: &[Vec<usize>]) -> Option<Vec<Predicted>> {
        if parts.len() < 2 {
            return None;
        }
        let mut predicted = vec![(None, None); self.observed.len()];
        for part in parts {
            let Some(EntropyWeights { weights, .. }) = self.without(part) else { continue };
            for condition in part {
                predicted[*condition] =
                    (self.features.share(&weights, *condition), self.features.spread(&weights, *condition));
            }
        }
        Some(predicted)
    }

    /// Weights for persons drawn again, of each drawing for which some are found.
    pub fn resampled(&self, seed: u64) -> Vec<Vec<f64>> {
        let all = self.all();
        let again = |number: usize| {
            let mut stream = Stream::seeded(derive_seed(seed, &format!("persons/{number}")));
            let observed: Vec<Observed> =
                self.rows.iter().map(|row| Observed::resampled(row, &mut stream)).collect();
            Some(self.matched(&all, &observed)?.weights)
        };
        (0..RESAMPLED).filter_map(again).collect()
    }
}

/// A share and a share of pairs; `None` where nobody was left to do it, or no weights were found.
type Predicted = (Option<f64>, Option<f64>);

/// Root mean square.
pub fn rms(errors: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = errors.len() as f64;
    libm::sqrt(errors.map(|one| one * one).sum::<f64>() / count)
}

/// Such as `42.9 %`.
pub fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::ObservedErrors;

    const GAPS: [f64; 5] = [3.0, 3.0, 4.0, 5.0, 6.5];
    const RUNS: u32 = 20;

    /// The chance that somebody who asks for gaps of `asked` is there for each gap of the sequence, and that they are and take it.
    fn truth(asked: f64) -> Vec<(f64, f64)> {
        let mut there = 1.0;
        let gap = |gap: &f64| {
            let takes = 1.0 / (1.0 + libm::exp((asked - gap) / 0.4));
            let now = (there, there * takes);
            there *= 1.0 - takes;
            now
        };
        GAPS.iter().map(gap).collect()
    }

    /// What a mixture does in each gap, of those who are still there: share, and share of pairs.
    fn mixture(asked: &[f64], weights: &[f64]) -> Vec<(f64, f64)> {
        let sum = |gap: usize, of: &dyn Fn((f64, f64)) -> f64| -> f64 {
            asked.iter().zip(weights).map(|(asked, weight)| weight * of(truth(*asked)[gap])).sum()
        };
        let ratio = |gap: usize, power: i32| {
            sum(gap, &|(_, took)| took.powi(power)) / sum(gap, &|(there, _)| there.powi(power))
        };
        (0..GAPS.len()).map(|gap| (ratio(gap, 1), ratio(gap, 2))).collect()
    }

    /// In how many runs each took each gap, and was not there any more.
    fn simulated(asked: &[f64], seed: u64) -> Vec<Vec<HeldRuns>> {
        let mut stream = Stream::seeded(seed);
        let candidate = |asked: &f64| {
            let mut done = vec![HeldRuns::default(); GAPS.len()];
            for _ in 0..RUNS {
                let mut is_there = true;
                for (gap, one) in GAPS.iter().zip(&mut done) {
                    let takes = stream.uniform() < 1.0 / (1.0 + libm::exp((asked - gap) / 0.4));
                    one.not_counted += u32::from(!is_there);
                    one.held += u32::from(is_there && takes);
                    is_there &= !takes;
                }
            }
            done
        };
        asked.iter().map(candidate).collect()
    }

    #[test]
    fn people_who_were_offered_a_sequence_of_gaps_are_found_again() {
        let asked: Vec<f64> =
            (0..600).map(|one| 2.5 * libm::pow(8.0 / 2.5, f64::from(one) / 599.0)).collect();
        let normal = |asked: &f64| libm::exp(-(asked - 5.0) * (asked - 5.0) / 2.0);
        let sum: f64 = asked.iter().map(normal).sum();
        let people: Vec<f64> = asked.iter().map(|one| normal(one) / sum).collect();
        let wanted = mixture(&asked, &people);
        let error = 0.02;
        let row = |(index, (share, pairs)): (usize, &(f64, f64))| ObservedRow {
            row: index + 1,
            scenario: "sequence".into(),
            values: Vec::new(),
            share: *share,
            trials: 600,
            persons: 60,
            by_count: Vec::new(),
            errors: Some(ObservedErrors { error, pairs: Some((*pairs, error)) }),
        };
        let rows: Vec<ObservedRow> = wanted.iter().enumerate().map(row).collect();
        let rows: Vec<&ObservedRow> = rows.iter().collect();
        let observed: Vec<Observed> = rows.iter().map(|row| Observed::of(row)).collect();
        let candidates = WeighedCandidates {
            model: String::new(),
            variant: None,
            names: vec!["asked".into()],
            rows: asked.iter().map(|asked| vec![*asked]).collect(),
            words: String::new(),
        };
        let done = simulated(&asked, 11);
        let defined: Vec<Vec<u32>> =
            done.iter().map(|row| row.iter().map(|one| RUNS - one.not_counted).collect()).collect();
        let weighed = |defined: &[Vec<u32>]| {
            let features = Features::predicted(&done, defined, RUNS, &candidates);
            let weighing = Weighing {
                features: &features,
                observed: &observed,
                rows: &rows,
                parameters: &BoundedParameters::default(),
                within: 1.0,
                spread_within: &[Some(1.0); GAPS.len()],
            };
            (weighing.out_of_reach(), weighing.weights().map(|found| found.weights))
        };
        let (missed, weights) = weighed(&defined);
        assert_eq!(missed, Vec::<String>::new());
        let weights = weights.expect("there are weights");
        for ((share, pairs), (wanted, pairs_wanted)) in mixture(&asked, &weights).iter().zip(&wanted) {
            assert!((share - wanted).abs() < error, "{share} for {wanted}");
            assert!((pairs - pairs_wanted).abs() < 1.5 * error, "{pairs} for {pairs_wanted}");
        }
        let mean = |weights: &[f64]| asked.iter().zip(weights).map(|(one, weight)| one * weight).sum::<f64>();
        assert!((mean(&weights) - mean(&people)).abs() < 0.15, "{} {}", mean(&weights), mean(&people));
        // As not taking it, those who are gone make others of the people, or nobody at all.
        let (missed, weights) = weighed(&[]);
        let apart = weights.map_or(1.0, |weights| (mean(&weights) - mean(&people)).abs());
        assert!(!missed.is_empty() || apart > 0.5, "{missed:?} {apart}");
        // In another order the same weights.
        let turned: Vec<Vec<HeldRuns>> = done.iter().rev().cloned().collect();
        let turned_defined: Vec<Vec<u32>> = defined.iter().rev().cloned().collect();
        let features = Features::counted(&turned, &turned_defined, RUNS);
        let usual = Features::counted(&done, &defined, RUNS);
        let by_hand = |features: &Features, gap: usize| features.share(&vec![1.0 / 600.0; 600], gap).unwrap();
        for gap in 0..GAPS.len() {
            assert!((by_hand(&features, gap) - by_hand(&usual, gap)).abs() < 1e-12);
            let counts = |of: &dyn Fn(&HeldRuns) -> u32| -> f64 {
                done.iter().map(|row| f64::from(of(&row[gap]))).sum()
            };
            let direct = counts(&|one| one.held) / counts(&|one| RUNS - one.not_counted);
            assert!((by_hand(&usual, gap) - direct).abs() < 1e-12);
        }
    }
}
