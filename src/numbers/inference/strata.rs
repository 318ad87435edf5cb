//! Values in strata: which strata there are is no matter of chance, so the error of their mean is that within them.
//!
//! Source: W. G. Cochran, Sampling Techniques, 3rd edition, 1977, sections 5.3 to 5.5 and 5A.12 (collapsed strata); degrees of freedom:
//! F. E. Satterthwaite, Biometrics Bulletin 2, 1946.

use super::Interval;
use crate::distributions::student_quantile;
use crate::random::Stream;

/// Strata with fewer values stand together as one, whose spread then holds the differences between them, too: of so few resampling
/// knows too little.
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

    /// Each group is a stratum, but for small ones.
    pub fn new(groups: Vec<Vec<f64>>) -> Self {
        let pooled = || Self::one(groups.concat());
        let (large, small): (Vec<_>, Vec<_>) = groups.iter().partition(|group| group.len() >= LEAST);
        let rest: Vec<f64> = small.into_iter().flatten().copied().collect();
        let mut strata: Vec<Vec<f64>> = large.into_iter().cloned().collect();
        match strata.last_mut() {
            None => return pooled(),
            Some(last) if rest.len() < LEAST => last.extend(rest),
            Some(_) => strata.push(rest),
        }
        let mut end = 0;
        let mut ends = Vec::with_capacity(strata.len());
        for stratum in &strata {
            end += stratum.len();
            ends.push(end);
        }
        let found = Self { values: strata.concat(), ends };
        // Strata of equal values know of no others, which a mean over different ones does not hide.
        if found.estimate().error == 0.0 { pooled() } else { found }
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
        self.estimate_of(&self.values)
    }

    fn estimate_of(&self, values: &[f64]) -> Estimate {
        let whole = Estimate::of(values);
        match self.ends.len() {
            1 => whole,
            _ => Estimate { error: self.variances(values).map(|(own, _)| own).sum::<f64>().sqrt(), ..whole },
        }
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

    /// By how many of its own standard errors the mean of each resample, drawn within strata, is off this one; infinite where a resample
    /// has no spread. Endless.
    pub fn deviations(&self, seed: u64) -> impl Iterator<Item = f64> {
        let mut stream = Stream::seeded(seed);
        let mut sample = self.values.clone();
        let centre = self.estimate().value;
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
            let again = self.estimate_of(&sample);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_that_within_strata() {
        // By hand: variances 1 and 4 of five each, so (1/5 + 4/5)/4.
        let shape = [
            -1.264_911_064_067_351_8,
            -0.632_455_532_033_675_9,
            0.0,
            0.632_455_532_033_675_9,
            1.264_911_064_067_351_8,
        ];
        let groups = vec![shape.to_vec(), shape.iter().map(|one| 100.0 + 2.0 * one).collect()];
        let strata = Strata::new(groups.clone());
        let found = strata.estimate();
        assert!((found.value - 50.0).abs() < 1e-12 && (found.error - 0.5).abs() < 1e-9, "{found:?}");
        // (1/20 + 4/20)^2 / ((1/20)^2/4 + (4/20)^2/4).
        assert!((strata.freedom() - 0.0625 / (0.0025 / 4.0 + 0.04 / 4.0)).abs() < 1e-9);
        assert!(Strata::one(groups.concat()).estimate().error > 15.0);
    }

    #[test]
    fn small_strata_stand_together_and_equal_ones_do_not_count_as_certain() {
        let small = Strata::new(vec![vec![1.0], vec![2.0, 3.0], vec![5.0; 2]]);
        assert_eq!(small.ends, [5]);
        let mixed = Strata::new(vec![vec![1.0], (0..6).map(f64::from).collect(), vec![2.0]]);
        assert_eq!((mixed.ends.clone(), mixed.values.len()), (vec![8], 8));
        let two = Strata::new(vec![vec![1.0; 2], (0..6).map(f64::from).collect(), vec![2.0; 3]]);
        assert_eq!(two.ends, [6, 11]);
        // Nothing varies within them: the difference between them is all there is to go by.
        let equal = Strata::new(vec![vec![0.0; 10], vec![1.0; 10]]);
        assert_eq!(equal.ends, [20]);
        assert!(equal.estimate().error > 0.1);
    }
}
