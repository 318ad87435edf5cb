//! Values in strata: which strata there are is no matter of chance, so the error of their mean is that within them.
//!
//! Source: W. G. Cochran, Sampling Techniques, 3rd edition, 1977, sections 5.3 to 5.5 and 5A.12 (collapsed strata); degrees of freedom:
//! F. E. Satterthwaite, Biometrics Bulletin 2, 1946.

use super::Interval;
use crate::distributions::student_quantile;
use crate::random::Stream;

/// Strata of which fewer values are off the commonest one stand together as one, whose spread then holds the differences between them,
/// too: of so few resampling knows too little, and would often miss them all.
const LEAST: usize = 5;

/// One less than a round number, so that the wanted quantiles are resamples themselves.
const RESAMPLES: usize = 1999;

/// A mean and its standard error.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimate {
    pub value: f64,
    pub error: f64,
}

impl Estimate {
    /// Of at least two values.
    pub fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let value = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|one| (one - value) * (one - value)).sum();
        // Equal values have no spread, whatever the rounding of their sum says.
        let squares = if squares <= 1e-24 * n * value * value { 0.0 } else { squares };
        Self { value, error: (squares / (n - 1.0) / n).sqrt() }
    }

    /// From the sorted deviations of resamples, and Student's distribution with this freedom. An end is infinite where nothing bounds it.
    pub fn interval(&self, deviations: &[f64], freedom: f64, confidence: f64) -> Interval {
        let each = (1.0 - confidence) / 2.0;
        let student = student_quantile(1.0 - each, freedom);
        let place = (each * (deviations.len() + 1) as f64).floor().max(1.0) as usize;
        let (least, most) = (deviations[place - 1], deviations[deviations.len() - place]);
        Interval {
            low: self.value - most.max(student) * self.error,
            high: self.value - least.min(-student) * self.error,
        }
    }
}

/// Values, those of a stratum next to each other.
#[derive(Debug, Clone)]
pub(super) struct Strata {
    values: Vec<f64>,
    /// Where each stratum ends.
    ends: Vec<usize>,
}

impl Strata {
    /// All values in one stratum.
    pub fn one(values: Vec<f64>) -> Self {
        Self { ends: vec![values.len()], values }
    }

    /// Each group is a stratum, but for those in which too little differs, which stand together.
    pub fn new(groups: Vec<Vec<f64>>) -> Self {
        let pooled = || Self::one(groups.concat());
        let (large, small): (Vec<_>, Vec<_>) = groups.iter().partition(|group| differing(group) >= LEAST);
        let rest: Vec<f64> = small.into_iter().flatten().copied().collect();
        let mut strata: Vec<Vec<f64>> = large.into_iter().cloned().collect();
        // What is the same throughout adds no error of its own; of one value nobody knows which.
        let by_themselves = rest.len() > 1 && (differing(&rest) == 0 || differing(&rest) >= LEAST);
        match strata.last_mut() {
            None => return pooled(),
            Some(_) if by_themselves => strata.push(rest),
            Some(last) => last.extend(rest),
        }
        let mut end = 0;
        let mut ends = Vec::with_capacity(strata.len());
        for stratum in &strata {
            end += stratum.len();
            ends.push(end);
        }
        Self { values: strata.concat(), ends }
    }

    pub fn values(&self) -> &[f64] {
        &self.values
    }

    fn strata<'a>(&'a self, values: &'a [f64]) -> impl Iterator<Item = &'a [f64]> {
        let mut begin = 0;
        self.ends.iter().map(move |end| &values[std::mem::replace(&mut begin, *end)..*end])
    }

    /// The variance that each stratum adds to that of the mean, with its degrees of freedom.
    fn variances<'a>(&'a self, values: &'a [f64]) -> impl Iterator<Item = (f64, f64)> {
        let count = values.len() as f64;
        self.strata(values).map(move |stratum| {
            let own = stratum.len() as f64;
            let weighted = own / count * Estimate::of(stratum).error;
            (weighted * weighted, own - 1.0)
        })
    }

    /// The mean of all values, at least two, and its standard error.
    pub fn estimate(&self) -> Estimate {
        let whole = Estimate::of(&self.values);
        match self.ends.len() {
            1 => whole,
            _ => Estimate {
                error: self.variances(&self.values).map(|(own, _)| own).sum::<f64>().sqrt(),
                ..whole
            },
        }
    }

    /// Of a resample. A stratum of which it has one value only counts with the error that is known of it: that one was drawn
    /// throughout does not make it certain.
    fn estimate_of(&self, sample: &[f64], known: &[f64]) -> Estimate {
        if self.ends.len() == 1 {
            return Estimate::of(sample);
        }
        let own = self.variances(sample).zip(known);
        let variance: f64 = own.map(|((own, _), known)| if own == 0.0 { *known } else { own }).sum();
        Estimate { value: sample.iter().sum::<f64>() / sample.len() as f64, error: variance.sqrt() }
    }

    /// Of Student's distribution.
    pub fn freedom(&self) -> f64 {
        if self.ends.len() == 1 {
            return self.values.len() as f64 - 1.0;
        }
        let (sum, squares) = self
            .variances(&self.values)
            .fold((0.0, 0.0), |(sum, squares), (own, freedom)| (sum + own, squares + own * own / freedom));
        sum * sum / squares
    }

    /// By how many of its own standard errors the mean of each resample, drawn within strata, is off this one; infinite where there is
    /// one stratum and a resample of it has no spread. Endless.
    pub fn deviations(&self, seed: u64) -> impl Iterator<Item = f64> {
        let mut stream = Stream::seeded(seed);
        let mut sample = self.values.clone();
        let centre = self.estimate().value;
        let known: Vec<f64> = self.variances(&self.values).map(|(own, _)| own).collect();
        std::iter::repeat_with(move || {
            let mut begin = 0;
            for end in &self.ends {
                let own = &self.values[begin..*end];
                // 32 bits choose among any number of runs there may be, with a bias below 1e-5 of the choice's probability.
                let chosen = |bits: u64| own[(((bits & 0xffff_ffff) * own.len() as u64) >> 32) as usize];
                for pair in sample[begin..*end].chunks_mut(2) {
                    let bits = stream.bits();
                    pair[0] = chosen(bits);
                    if let Some(second) = pair.get_mut(1) {
                        *second = chosen(bits >> 32);
                    }
                }
                begin = *end;
            }
            let again = self.estimate_of(&sample, &known);
            if again.value == centre { 0.0 } else { (again.value - centre) / again.error }
        })
    }

    /// The first resamples' deviations, sorted.
    pub fn resampled(&self, seed: u64) -> Vec<f64> {
        let mut deviations: Vec<f64> = self.deviations(seed).take(RESAMPLES).collect();
        deviations.sort_by(f64::total_cmp);
        deviations
    }
}

/// How many are not what most are.
fn differing(values: &[f64]) -> usize {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let most = sorted.chunk_by(|one, next| one == next).map(<[f64]>::len).max();
    values.len() - most.unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_that_within_strata() {
        // By hand: six each, with variances 3.5 and 14.
        let shape: Vec<f64> = (0..6).map(|k| f64::from(k) - 2.5).collect();
        let groups = vec![shape.clone(), shape.iter().map(|one| 100.0 + 2.0 * one).collect()];
        let strata = Strata::new(groups.clone());
        let found = strata.estimate();
        let (first, second) = (3.5 / 6.0 / 4.0, 14.0 / 6.0 / 4.0);
        let error = f64::sqrt(first + second);
        assert!((found.value - 50.0).abs() < 1e-12 && (found.error - error).abs() < 1e-12, "{found:?}");
        let freedom = (first + second) * (first + second) / ((first * first + second * second) / 5.0);
        assert!((strata.freedom() - freedom).abs() < 1e-9);
        assert!(Strata::one(groups.concat()).estimate().error > 14.0);
    }

    #[test]
    fn strata_in_which_little_differs_stand_together() {
        let ends = |groups: &[&[f64]]| Strata::new(groups.iter().map(|group| group.to_vec()).collect()).ends;
        let six: Vec<f64> = (0..6).map(f64::from).collect();
        let mut few = vec![0.0; 40];
        few[..4].copy_from_slice(&[1.0, 2.0, 3.0, 4.0]);
        // One run each: no strata.
        assert_eq!(ends(&[&[1.0], &[2.0], &[3.0]]), [3]);
        assert_eq!(ends(&[&[1.0], &[2.0, 3.0], &[5.0; 2]]), [5]);
        assert_eq!(ends(&[&[1.0], &six, &[2.0]]), [8]);
        assert_eq!(ends(&[&six, &few]), [46]);
        assert_eq!(ends(&[&six, &few, &few]), [6, 86]);
        // What is the same throughout has no error.
        assert_eq!(ends(&[&six, &[0.0; 40], &[0.0; 40]]), [6, 86]);
        // Nothing varies within them: the difference between them is all there is to go by.
        let equal = Strata::new(vec![vec![0.0; 10], vec![1.0; 10]]);
        assert_eq!(equal.ends, [20]);
        assert!(equal.estimate().error > 0.1);
    }

    /// Another way to the same number: the variance of the mean over very many resamples within strata, which is known to be
    /// (n - 1)/n of each stratum's own.
    #[test]
    fn resamples_spread_as_strata_do() {
        let mut stream = Stream::seeded(3);
        let groups: Vec<Vec<f64>> = [(5.0, 1.0, 30), (-40.0, 3.0, 60), (0.0, 0.5, 10)]
            .iter()
            .map(|(mean, std, count)| (0..*count).map(|_| mean + std * stream.normal()).collect())
            .collect();
        let strata = Strata::new(groups.clone());
        let by_hand: f64 = groups
            .iter()
            .map(|group| {
                let centre = group.iter().sum::<f64>() / group.len() as f64;
                group.iter().map(|one| (one - centre) * (one - centre)).sum::<f64>()
            })
            .sum::<f64>()
            / 1e4;
        let mut means = Vec::new();
        for _ in 0..20_000 {
            let drawn = groups.iter().flat_map(|group| {
                (0..group.len())
                    .map(|_| group[(stream.uniform() * group.len() as f64) as usize])
                    .collect::<Vec<_>>()
            });
            means.push(drawn.sum::<f64>() / 100.0);
        }
        let spread = crate::summary::std(&means).unwrap();
        assert!((spread * spread / by_hand - 1.0).abs() < 0.05, "{spread}");
        assert!((strata.estimate().error / spread - 1.0).abs() < 0.06);
        // Studentised, they spread a little more than a normal number does.
        let deviations: Vec<f64> = strata.deviations(1).take(5000).collect();
        let spread = crate::summary::std(&deviations).unwrap();
        assert!((0.97..1.2).contains(&spread), "{spread}");
    }

    #[test]
    fn a_resample_of_one_value_is_no_certainty() {
        let mut nearly = vec![1.0; 40];
        nearly[..5].fill(0.0);
        let strata = Strata::new(vec![nearly.clone(), nearly]);
        assert_eq!(strata.ends, [40, 80]);
        assert!(strata.deviations(5).take(20_000).all(f64::is_finite));
    }
}
