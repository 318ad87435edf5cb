//! What candidates would do in many runs, from few: what those do who are like them, and what is their own.
//!
//! Of few runs a candidate's share is as much luck as it is the candidate's, and weights lean towards who was lucky. So the share is
//! replaced by its best linear prediction: a quadratic regression on the candidates' coordinates, and of what is left as much as is
//! theirs, I − N S⁻¹ of it, S being the covariance of what is left and N the part of it that is noise, which is known, since it is that of
//! counts (linear Bayes, or credibility: Bühlmann and Straub 1970; Efron and Morris, JASA 70, 1975).

use super::maximum_entropy::{factor, solved};

/// In how many of `runs` runs of a condition something held, for every candidate and condition.
pub struct HeldCounts<'a> {
    /// A row per candidate, a number per condition.
    pub held: &'a [Vec<u32>],
    /// In how many of the runs it can be said whether it held, in the form of `held`; without rows in all of them.
    pub defined: &'a [Vec<u32>],
    /// Of each candidate in every condition, at least 2.
    pub runs: u32,
}

/// Shares of all runs, and of pairs of runs in which both held, of every candidate in every condition: a row per candidate, a number per
/// condition.
#[derive(Debug, Clone, PartialEq)]
pub struct CandidateShares {
    /// In which it held.
    pub shares: Vec<Vec<f64>>,
    /// Of pairs of runs in which both held.
    pub pairs: Vec<Vec<f64>>,
    /// In which it can be said whether it held: 1 everywhere in a condition in which it can in every run of everybody.
    pub defined: Vec<Vec<f64>>,
    /// Of pairs of runs in both of which that can be said.
    pub defined_pairs: Vec<Vec<f64>>,
}

/// Fewer candidates than so many for each coefficient say nothing of their neighbours: their shares stay as they are.
const FOR_A_COEFFICIENT: usize = 10;
/// The noise of pairs of runs is known from so many on.
const FEWEST_RUNS: u32 = 4;

impl HeldCounts<'_> {
    /// As counted: without bias, and with all their noise.
    pub fn shares(&self) -> CandidateShares {
        let rows = |counts: &[Vec<u32>], factors: u32| -> Vec<Vec<f64>> {
            let share = |count: &u32| falling(*count, factors) / falling(self.runs, factors);
            counts.iter().map(|row| row.iter().map(share).collect()).collect()
        };
        let everywhere = || self.held.iter().map(|row| vec![1.0; row.len()]).collect::<Vec<_>>();
        let (defined, defined_pairs) = if self.defined.is_empty() {
            (everywhere(), everywhere())
        } else {
            (rows(self.defined, 1), rows(self.defined, 2))
        };
        CandidateShares { shares: rows(self.held, 1), pairs: rows(self.held, 2), defined, defined_pairs }
    }

    /// The conditions in which it cannot be said of every run whether it held.
    fn partly_defined(&self, count: usize) -> Vec<usize> {
        let partly = |at: &usize| self.defined.iter().any(|row| row[*at] != self.runs);
        (0..count).filter(partly).collect()
    }

    /// Predicted with what is known of candidates whose `coordinates` are like theirs; the means over all candidates stay what they are.
    /// As counted where there are too few candidates, or too few runs. How often it can be said is predicted beside how often it
    /// held, so that runs of which nothing can be said tell nothing of what is done in the others.
    ///
    /// # Panics
    /// If there is not a row of coordinates for each candidate.
    pub fn smoothed(&self, coordinates: &[Vec<f64>]) -> CandidateShares {
        assert_eq!(coordinates.len(), self.held.len(), "coordinates for each candidate");
        let counted = self.shares();
        let count = counted.shares.first().map_or(0, Vec::len);
        let partly = self.partly_defined(count);
        let columns = 2 * (count + partly.len());
        let design = quadratic(coordinates);
        let terms = design.first().map_or(0, Vec::len);
        if self.runs < FEWEST_RUNS || count == 0 || self.held.len() < FOR_A_COEFFICIENT * (terms + columns) {
            return counted;
        }
        let of_partly = |row: &Vec<f64>| partly.iter().map(|at| row[*at]).collect::<Vec<_>>();
        let rows: Vec<Vec<f64>> = (0..self.held.len())
            .map(|one| {
                let CandidateShares { shares, pairs, defined, defined_pairs } = &counted;
                let defined = [of_partly(&defined[one]), of_partly(&defined_pairs[one])].concat();
                [shares[one].as_slice(), &pairs[one], &defined].concat()
            })
            .collect();
        let Some(regressed) = regressed(&design, &rows) else { return counted };
        let left: Vec<Vec<f64>> = rows
            .iter()
            .zip(&regressed)
            .map(|(row, by)| row.iter().zip(by).map(|(value, by)| value - by).collect())
            .collect();
        let free = (left.len() - terms) as f64;
        let mut spread = products(&left, &left);
        spread.iter_mut().flatten().for_each(|one| *one /= free);
        // Where all do the same there is nothing to predict, and nothing to divide by.
        (0..columns).for_each(|at| spread[at][at] += NEXT_TO_NOTHING);
        let noise = self.noise(count, &partly);
        let factors = factor(spread);
        let own = |row: &Vec<f64>| -> Vec<f64> {
            let solved = solved(&factors, row);
            (0..columns).map(|at| row[at] - dot(&noise[at], &solved)).collect()
        };
        let mut predicted = counted;
        for (index, (row, by)) in left.iter().zip(&regressed).enumerate() {
            let all: Vec<f64> = own(row).iter().zip(by).map(|(own, by)| own + by).collect();
            let (held, defined) = all.split_at(2 * count);
            predicted.shares[index].copy_from_slice(&held[..count]);
            predicted.pairs[index].copy_from_slice(&held[count..]);
            for (place, at) in partly.iter().enumerate() {
                predicted.defined[index][*at] = defined[place];
                predicted.defined_pairs[index][*at] = defined[partly.len() + place];
            }
        }
        predicted
    }

    /// The covariance of the noise of shares and, behind them, of pairs, and behind both of how often it can be said, over all candidates:
    /// that of a share of n independent runs is p(1 − p)/n, and so on for pairs, with powers of p estimated without bias by falling
    /// factorials.
    fn noise(&self, count: usize, partly: &[usize]) -> Vec<Vec<f64>> {
        let size = 2 * (count + partly.len());
        let mut noise = vec![vec![0.0; size]; size];
        let (runs, candidates) = (f64::from(self.runs), self.held.len() as f64);
        // Of an event that is part of another, or the same: both shares, share with pairs either way round, both pairs.
        let joint = |inner: u32, outer: u32| {
            let power = |inside: u32, outside: u32| {
                falling(inner, inside) * falling(outer.saturating_sub(inside), outside)
                    / falling(self.runs, inside + outside)
            };
            let both = |ones: f64| ones / (runs * (runs - 1.0));
            [
                (power(1, 0) - power(1, 1)) / runs,
                2.0 * (power(1, 1) - power(1, 2)) / runs,
                2.0 * (power(2, 0) - power(2, 1)) / runs,
                both(4.0 * (runs - 2.0) * (power(2, 1) - power(2, 2)) + 2.0 * (power(2, 0) - power(2, 2))),
            ]
        };
        for (index, row) in self.held.iter().enumerate() {
            for (at, held) in row.iter().enumerate() {
                let power = |power: u32| falling(*held, power) / falling(self.runs, power);
                let (one, two, three, four) = (power(1), power(2), power(3), power(4));
                let both = 2.0 * (two - three) / runs;
                let pairs =
                    (4.0 * (runs - 2.0) * (three - four) + 2.0 * (two - four)) / (runs * (runs - 1.0));
                noise[at][at] += (one - two) / runs / candidates;
                noise[at][count + at] += both / candidates;
                noise[count + at][at] += both / candidates;
                noise[count + at][count + at] += pairs / candidates;
            }
            for (place, at) in partly.iter().enumerate() {
                let (held, defined) = (row[*at], self.defined[index][*at]);
                let (share, pair) = (2 * count + place, 2 * count + partly.len() + place);
                let mut add = |one: usize, other: usize, covariance: f64| {
                    noise[one][other] += covariance / candidates;
                    if one != other {
                        noise[other][one] += covariance / candidates;
                    }
                };
                let [shares, with_pairs, pairs_with, pairs] = joint(held, defined);
                add(*at, share, shares);
                add(*at, pair, with_pairs);
                add(count + *at, share, pairs_with);
                add(count + *at, pair, pairs);
                let [shares, _, pairs_with, pairs] = joint(defined, defined);
                add(share, share, shares);
                add(share, pair, pairs_with);
                add(pair, pair, pairs);
            }
        }
        noise
    }
}

/// A variance of shares that is none.
const NEXT_TO_NOTHING: f64 = 1e-9;

/// n (n − 1) … of so many factors.
fn falling(n: u32, factors: u32) -> f64 {
    (0..factors).map(|by| f64::from(n) - f64::from(by)).product()
}

/// 1, each coordinate, their squares and products, all of about the same size; coordinates in which nobody differs are left out.
fn quadratic(coordinates: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let number = coordinates.len() as f64;
    let scaled: Vec<Vec<f64>> = (0..coordinates.first().map_or(0, Vec::len))
        .filter_map(|at| {
            let mean = coordinates.iter().map(|row| row[at]).sum::<f64>() / number;
            let square = |row: &Vec<f64>| (row[at] - mean) * (row[at] - mean);
            let deviation = libm::sqrt(coordinates.iter().map(square).sum::<f64>() / number);
            (deviation > 1e-9 * mean.abs().max(1e-9))
                .then(|| coordinates.iter().map(|row| (row[at] - mean) / deviation).collect())
        })
        .collect();
    let terms = |row: usize| {
        let linear: Vec<f64> = scaled.iter().map(|column| column[row]).collect();
        let mut terms = vec![1.0];
        terms.extend(&linear);
        for (at, one) in linear.iter().enumerate() {
            terms.extend(linear[at..].iter().map(|other| one * other));
        }
        terms
    };
    (0..coordinates.len()).map(terms).collect()
}

/// What the terms say of each row, by least squares; `None` where they are not independent.
fn regressed(design: &[Vec<f64>], rows: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let normal = products(design, design);
    let largest = (0..normal.len()).map(|at| normal[at][at]).fold(0.0, f64::max);
    let factors = factor(normal);
    if (0..factors.len()).any(|at| factors[at][at] * factors[at][at] < 1e-9 * largest) {
        return None;
    }
    // A row of coefficients for each feature.
    let coefficients: Vec<Vec<f64>> =
        transposed(&products(design, rows)).iter().map(|right| solved(&factors, right)).collect();
    let predict = |terms: &Vec<f64>| coefficients.iter().map(|by| dot(terms, by)).collect();
    Some(design.iter().map(predict).collect())
}

/// Sums over rows of products of their columns.
fn products(one: &[Vec<f64>], other: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let (lines, columns) = (one.first().map_or(0, Vec::len), other.first().map_or(0, Vec::len));
    let mut sums = vec![vec![0.0; columns]; lines];
    for (one, other) in one.iter().zip(other) {
        for (line, by) in sums.iter_mut().zip(one) {
            line.iter_mut().zip(other).for_each(|(sum, value)| *sum += by * value);
        }
    }
    sums
}

fn transposed(matrix: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let columns = matrix.first().map_or(0, Vec::len);
    (0..columns).map(|at| matrix.iter().map(|row| row[at]).collect()).collect()
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::{WeightTarget, maximum_entropy};
    use crate::random::Stream;

    type Rows<T> = Vec<Vec<T>>;

    /// Candidates of two coordinates, what they truly do in three conditions, and in how many of `runs` runs they did it. Half of what they
    /// are is not in their coordinates.
    fn candidates(seed: u64, number: usize, runs: u32) -> (Rows<f64>, Rows<f64>, Rows<u32>) {
        let mut stream = Stream::seeded(seed);
        let mut all = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..number {
            let place = vec![2.0 * stream.uniform() - 1.0, 10.0 * stream.uniform()];
            let own = 1.5 * (stream.uniform() - 0.5);
            let shares: Vec<f64> = (0..3)
                .map(|condition| {
                    let logit = f64::from(condition) - 2.0 + 2.0 * place[0] + 0.1 * place[1] + own;
                    1.0 / (1.0 + libm::exp(-logit))
                })
                .collect();
            let held = |share: &f64| (0..runs).map(|_| u32::from(stream.uniform() < *share)).sum();
            all.2.push(shares.iter().map(held).collect());
            all.0.push(place);
            all.1.push(shares);
        }
        all
    }

    fn mean(rows: &[Vec<f64>], weights: &[f64], at: usize) -> f64 {
        rows.iter().zip(weights).map(|(row, weight)| weight * row[at]).sum()
    }

    #[test]
    fn weights_are_not_taken_in_by_luck() {
        let (places, truth, held) = candidates(1, 3000, 10);
        let counts = HeldCounts { held: &held, defined: &[], runs: 10 };
        let targets = [0.15, 0.45, 0.8].map(|value| WeightTarget { value, error: 0.01 });
        let missed = |features: &CandidateShares| {
            let weights = maximum_entropy(&features.shares, &targets).weights;
            let apart = |at: usize| (mean(&truth, &weights, at) - mean(&features.shares, &weights, at)).abs();
            (0..3).map(apart).fold(0.0, f64::max)
        };
        let (counted, smoothed) = (missed(&counts.shares()), missed(&counts.smoothed(&places)));
        assert!(counted > 0.03, "by luck they are taken for {counted} more than they are");
        assert!(smoothed < 0.25 * counted, "{smoothed} after {counted}");
    }

    #[test]
    fn predictions_are_nearer_to_the_truth_and_have_the_same_mean() {
        let (places, truth, held) = candidates(2, 2000, 10);
        let counts = HeldCounts { held: &held, defined: &[], runs: 10 };
        let (counted, smoothed) = (counts.shares(), counts.smoothed(&places));
        let error = |rows: &[Vec<f64>], power: i32| {
            let squares = rows.iter().zip(&truth).flat_map(|(row, truth)| {
                row.iter().zip(truth).map(move |(found, share)| {
                    let apart = found - share.powi(power);
                    apart * apart
                })
            });
            (squares.sum::<f64>() / 6000.0).sqrt()
        };
        assert!(error(&smoothed.shares, 1) < 0.7 * error(&counted.shares, 1));
        assert!(error(&smoothed.pairs, 2) < 0.7 * error(&counted.pairs, 2));
        let equal = vec![1.0 / 2000.0; 2000];
        for at in 0..3 {
            assert!((mean(&counted.shares, &equal, at) - mean(&smoothed.shares, &equal, at)).abs() < 1e-9);
            assert!((mean(&counted.pairs, &equal, at) - mean(&smoothed.pairs, &equal, at)).abs() < 1e-9);
        }
    }

    #[test]
    fn noise_is_that_of_counts_drawn_again() {
        let mut stream = Stream::seeded(3);
        let (runs, share) = (12, 0.7);
        let held: Vec<Vec<u32>> =
            (0..40_000).map(|_| vec![(0..runs).map(|_| u32::from(stream.uniform() < share)).sum()]).collect();
        let counts = HeldCounts { held: &held, defined: &[], runs };
        let noise = counts.noise(1, &[]);
        let rows = counts.shares();
        let pairs: Vec<(f64, f64)> =
            rows.shares.iter().zip(&rows.pairs).map(|(one, other)| (one[0], other[0])).collect();
        let number = pairs.len() as f64;
        let centre =
            pairs.iter().fold((0.0, 0.0), |sum, one| (sum.0 + one.0 / number, sum.1 + one.1 / number));
        assert!((centre.0 - share).abs() < 0.005 && (centre.1 - share * share).abs() < 0.005);
        let found = pairs.iter().fold([0.0; 3], |sum, one| {
            let (a, b) = (one.0 - centre.0, one.1 - centre.1);
            [sum[0] + a * a / number, sum[1] + a * b / number, sum[2] + b * b / number]
        });
        for (found, expected) in found.iter().zip([noise[0][0], noise[0][1], noise[1][1]]) {
            assert!((found / expected - 1.0).abs() < 0.05, "{found} where {expected} is expected");
        }
    }

    /// Candidates as above who are not there in every run, and who are there less often the more often they do it.
    fn seldom_there(seed: u64, number: usize, runs: u32) -> (Rows<f64>, Rows<f64>, Rows<u32>, Rows<u32>) {
        let (places, truth, _) = candidates(seed, number, runs);
        let mut stream = Stream::seeded(seed + 1000);
        let (mut held, mut defined) = (Vec::new(), Vec::new());
        for shares in &truth {
            let mut counts = (Vec::new(), Vec::new());
            for share in shares {
                let (mut there, mut did) = (0, 0);
                for _ in 0..runs {
                    let (is_there, does) = (stream.uniform() > *share, stream.uniform() < *share);
                    there += u32::from(is_there);
                    did += u32::from(is_there && does);
                }
                counts.0.push(did);
                counts.1.push(there);
            }
            held.push(counts.0);
            defined.push(counts.1);
        }
        (places, truth, held, defined)
    }

    #[test]
    fn runs_of_which_nothing_can_be_said_tell_nothing_of_the_others() {
        let (places, truth, held, defined) = seldom_there(6, 3000, 10);
        let counts = HeldCounts { held: &held, defined: &defined, runs: 10 };
        let (counted, smoothed) = (counts.shares(), counts.smoothed(&places));
        let equal = vec![1.0 / 3000.0; 3000];
        let is_nearer = |counted: &Rows<f64>, smoothed: &Rows<f64>, of: &dyn Fn(f64) -> f64| {
            let error = |rows: &Rows<f64>| {
                let squares = rows.iter().zip(&truth).flat_map(|(row, truth)| {
                    row.iter().zip(truth).map(|(found, share)| (found - of(*share)) * (found - of(*share)))
                });
                (squares.sum::<f64>() / 9000.0).sqrt()
            };
            assert!(error(smoothed) < 0.7 * error(counted));
            for at in 0..3 {
                assert!((mean(counted, &equal, at) - mean(smoothed, &equal, at)).abs() < 1e-9);
            }
        };
        is_nearer(&counted.shares, &smoothed.shares, &|share| share * (1.0 - share));
        is_nearer(&counted.pairs, &smoothed.pairs, &|share| (share * (1.0 - share)).powi(2));
        is_nearer(&counted.defined, &smoothed.defined, &|share| 1.0 - share);
        is_nearer(&counted.defined_pairs, &smoothed.defined_pairs, &|share| (1.0 - share).powi(2));
    }

    #[test]
    fn where_all_can_be_said_nothing_changes_to_the_last_bit() {
        let (places, _, held) = candidates(7, 600, 8);
        let all = vec![vec![8; 3]; 600];
        let usual = HeldCounts { held: &held, defined: &[], runs: 8 };
        let same = HeldCounts { held: &held, defined: &all, runs: 8 };
        assert_eq!(usual.smoothed(&places), same.smoothed(&places));
        assert_eq!(usual.shares(), same.shares());
    }

    #[test]
    fn noise_of_runs_that_are_there_is_that_of_counts_drawn_again() {
        let mut stream = Stream::seeded(8);
        let (runs, there, does) = (9, 0.6, 0.7);
        let (mut held, mut defined) = (Vec::new(), Vec::new());
        for _ in 0..60_000 {
            let here = (0..runs).filter(|_| stream.uniform() < there).count() as u32;
            defined.push(vec![here]);
            held.push(vec![(0..here).map(|_| u32::from(stream.uniform() < does)).sum()]);
        }
        let counts = HeldCounts { held: &held, defined: &defined, runs };
        let noise = counts.noise(1, &[0]);
        let CandidateShares { shares, pairs, defined, defined_pairs } = counts.shares();
        let columns = [shares, pairs, defined, defined_pairs];
        let number = 60_000.0;
        let mean = |rows: &Rows<f64>| rows.iter().map(|row| row[0]).sum::<f64>() / number;
        for (one, left) in columns.iter().enumerate() {
            for (other, right) in columns.iter().enumerate() {
                let (low, high) = (mean(left), mean(right));
                let product = left.iter().zip(right).map(|(a, b)| (a[0] - low) * (b[0] - high));
                let found = product.sum::<f64>() / number;
                let expected = noise[one][other];
                assert!((found / expected - 1.0).abs() < 0.05, "{one} {other}: {found} for {expected}");
            }
        }
    }

    #[test]
    fn units_and_the_order_of_candidates_do_not_matter() {
        let (places, _, held) = candidates(4, 600, 8);
        let usual = HeldCounts { held: &held, defined: &[], runs: 8 }.smoothed(&places);
        let scaled: Vec<Vec<f64>> =
            places.iter().rev().map(|place| vec![place[1], 1000.0 * place[0] + 5.0]).collect();
        let turned: Vec<Vec<u32>> = held.iter().rev().cloned().collect();
        let other = HeldCounts { held: &turned, defined: &[], runs: 8 }.smoothed(&scaled);
        for (one, other) in usual.shares.iter().zip(other.shares.iter().rev()) {
            one.iter().zip(other).for_each(|(one, other)| assert!((one - other).abs() < 1e-9));
        }
    }

    #[test]
    fn few_candidates_or_alike_ones_stay_as_they_were_counted() {
        let (places, _, held) = candidates(5, 50, 8);
        let counts = HeldCounts { held: &held, defined: &[], runs: 8 };
        assert_eq!(counts.smoothed(&places), counts.shares());
        let (places, _, held) = candidates(5, 400, 3);
        let counts = HeldCounts { held: &held, defined: &[], runs: 3 };
        assert_eq!(counts.smoothed(&places), counts.shares());
        // Everybody alike, and always the same: nothing to learn, and nothing to stumble over.
        let held = vec![vec![8, 0]; 400];
        let counts = HeldCounts { held: &held, defined: &[], runs: 8 };
        let same = counts.smoothed(&vec![vec![1.0, 2.0]; 400]);
        assert!(same.shares.iter().all(|row| (row[0] - 1.0).abs() < 1e-9 && row[1].abs() < 1e-9));
    }
}
