//! Parameters whose distribution among people is known: the weighted candidates have it, too.

use super::super::error::ExperimentError;
use super::candidates::WeighedCandidates;
use super::trial::failed;
use numbers::inference::{WeightBound, nearest_mixture};
use results::CalibratedParameter;
use scenario::{Calibrate, MatchedParameter, significant};

/// A bound is missed by more of its width than rounding makes.
const MISSED: f64 = 1.0 + 1e-3;

/// What of the candidates' parameters is bounded.
#[derive(Default)]
pub struct BoundedParameters {
    /// One for each statistic.
    pub bounds: Vec<WeightBound>,
    /// A candidate a row: what it adds to each mean.
    pub rows: Vec<Vec<f64>>,
}

impl BoundedParameters {
    /// Those of a block.
    ///
    /// # Errors
    /// Where candidates do not differ in a parameter, and where no weights give it the distribution.
    pub fn of(block: &Calibrate, candidates: &WeighedCandidates) -> Result<Self, ExperimentError> {
        let mut columns = Vec::new();
        for matched in &block.parameters {
            let own = candidates.values(&matched.parameter);
            let differ = own.as_ref().is_some_and(|own| own.iter().any(|value| *value != own[0]));
            let Some(own) = own.filter(|_| differ) else {
                let MatchedParameter { parameter, statistic, .. } = matched;
                let reason = format!(
                    "the {} of `{parameter}` is to be matched, in which the candidates do not differ",
                    statistic.word()
                );
                let hint = format!(
                    "take candidates with values of their own: \
                     `scenario-runner calibrate --design published --draw \"{parameter}=normal(MEAN, DEVIATION)\" …`, \
                     or a population that has `{parameter}`"
                );
                return Err(failed(reason, Some(&hint)));
            };
            columns.push(own.iter().map(|value| matched.statistic.feature(*value)).collect::<Vec<_>>());
        }
        let bound = |matched: &MatchedParameter| {
            let (low, high) = matched.bounds();
            WeightBound { value: (low + high) / 2.0, within: (high - low) / 2.0 }
        };
        let rows = (0..candidates.rows.len()).map(|row| columns.iter().map(|column| column[row]).collect());
        let found = Self { bounds: block.parameters.iter().map(bound).collect(), rows: rows.collect() };
        found.reachable(block)?;
        Ok(found)
    }

    /// An error where no weights of the candidates keep all bounds, whatever else they match.
    fn reachable(&self, block: &Calibrate) -> Result<(), ExperimentError> {
        if self.bounds.is_empty() {
            return Ok(());
        }
        let weights = nearest_mixture(&self.rows, &[], &self.bounds).weights;
        let missed: Vec<String> = self
            .missed(&weights)
            .map(|index| {
                let matched = &block.parameters[index];
                let near = number(matched.statistic.of_mean(self.mean(&weights, index)), &matched.unit);
                format!("{}, and the nearest mixture has {near}", wanted(matched))
            })
            .collect();
        if missed.is_empty() {
            return Ok(());
        }
        let reason = format!("no mixture of the candidates is as people are: {}", missed.join("; "));
        Err(failed(reason, Some("take candidates over other ranges, or a wider `within`")))
    }

    /// Which bounds these weights do not keep.
    pub fn missed(&self, weights: &[f64]) -> impl Iterator<Item = usize> {
        let apart = |index: &usize| {
            let WeightBound { value, within } = self.bounds[*index];
            (self.mean(weights, *index) - value).abs() > MISSED * within
        };
        (0..self.bounds.len()).filter(apart)
    }

    fn mean(&self, weights: &[f64], index: usize) -> f64 {
        self.rows.iter().zip(weights).map(|(row, weight)| weight * row[index]).sum()
    }

    /// What the statistics of a block are by these weights, and by equal ones.
    pub fn found(&self, block: &Calibrate, weights: &[f64]) -> Vec<CalibratedParameter> {
        let equal = vec![1.0 / self.rows.len() as f64; self.rows.len()];
        let of = |(index, matched): (usize, &MatchedParameter)| CalibratedParameter {
            parameter: matched.parameter.clone(),
            statistic: matched.statistic.word().to_string(),
            unit: matched.unit.clone(),
            wanted: matched.value,
            within: matched.within,
            equal: matched.statistic.of_mean(self.mean(&equal, index)),
            fitted: matched.statistic.of_mean(self.mean(weights, index)),
        };
        block.parameters.iter().enumerate().map(of).collect()
    }
}

/// Such as `the mean of ped_free_speed is to be 1.34 m/s ± 0.03 m/s`.
fn wanted(matched: &MatchedParameter) -> String {
    let MatchedParameter { parameter, statistic, value, within, unit } = matched;
    let (value, within) = (number(*value, unit), number(*within, unit));
    format!("the {} of `{parameter}` is to be {value} ± {within}", statistic.word())
}

fn number(value: f64, unit: &str) -> String {
    format!("{} {unit}", significant(value, 4)).trim_end().to_string()
}
