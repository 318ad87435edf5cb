//! What `calibrate` blocks declare: candidates who are weighed until they do what people did.

use serde::{Deserialize, Serialize};

use super::{Comparison, Individuals, MetricReference, Observations, Origin};

/// Weighs candidates so that they do in scenarios what people did who were observed there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Calibrate {
    /// As the suite calls it, and the population that comes of it.
    pub name: String,
    /// What the suite says of it, in a sentence.
    pub doc: Option<String>,
    /// Who is weighed.
    pub candidates: CandidateSource,
    /// The scenarios whose conditions people were observed in, at least one.
    pub scenarios: Vec<String>,
    /// What people did, at least one rate. Rows of several may be about the same scenario.
    pub rates: Vec<MatchedRate>,
    /// How many of their errors targets are to be matched within; 1: as well as they are known.
    #[serde(default = "one_error", skip_serializing_if = "is_one_error")]
    pub within: f64,
    /// What is known besides of how their parameters are distributed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<MatchedParameter>,
    /// In how many parts conditions are held back in turn; 0: in none.
    pub folds: u32,
    /// Runs of every candidate in every condition, at least 2.
    pub runs: u32,
    /// Populations that are put into the same conditions to be shown beside.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub compared: Vec<Individuals>,
    /// Where it is declared.
    pub origin: Origin,
}

/// A rate that people were observed with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MatchedRate {
    /// What is counted of every run; it says itself what an undefined run counts as.
    pub condition: Comparison,
    /// Whether undefined runs are not counted: shares are then of the other runs, as those of people are of the trials in which they
    /// were still there.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub only_defined: bool,
    /// Only runs in which this holds count, such as those in which the person is still there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counted_where: Option<Comparison>,
    /// In canonical words, such as `rate(gap_accepted)`.
    pub text: String,
    /// What people did.
    pub observations: Observations,
    /// How many of its errors the spread between persons is to be matched within; `None`: it is not matched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread_within: Option<f64>,
}

impl MatchedRate {
    /// Whether only some runs count.
    pub fn counts_some(&self) -> bool {
        self.only_defined || self.counted_where.is_some()
    }

    /// The metrics that are asked of a run.
    pub fn metrics(&self) -> impl Iterator<Item = &MetricReference> {
        let counted_where = self.counted_where.as_ref();
        [&self.condition].into_iter().chain(counted_where).map(|one| &one.metric)
    }

    /// The same, to be changed.
    pub fn metrics_mut(&mut self) -> impl Iterator<Item = &mut MetricReference> {
        let counted_where = self.counted_where.as_mut();
        [&mut self.condition].into_iter().chain(counted_where).map(|one| &mut one.metric)
    }

    /// Whether people were observed in a scenario of this name.
    pub fn is_about(&self, scenario: &str) -> bool {
        self.observations.is_about(scenario)
    }

    /// How many numbers of people are matched.
    pub fn targets(&self) -> usize {
        self.observations.targets(self.spread_within.is_some())
    }
}

impl Calibrate {
    /// How many numbers are matched, of people and of their parameters.
    pub fn targets(&self) -> usize {
        self.rates.iter().map(MatchedRate::targets).sum::<usize>() + self.parameters.len()
    }

    /// How many conditions people were observed in.
    pub fn conditions(&self) -> usize {
        self.rates.iter().map(|rate| rate.observations.rows.len()).sum()
    }
}

/// Where candidates come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CandidateSource {
    /// This many in a Latin hypercube on log scales, over the ranges that the model says.
    LatinHypercube(u32),
    /// Those of a population, all or some.
    Population(Individuals),
}

/// What is known of how a parameter is distributed among people: the weighted candidates have it, too.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MatchedParameter {
    /// As the model declares it.
    pub parameter: String,
    /// What of its distribution.
    pub statistic: ParameterStatistic,
    /// What that is to be, SI units.
    pub value: f64,
    /// How far from it at most, SI units, above 0.
    pub within: f64,
    /// The unit of the parameter, SI.
    pub unit: String,
}

/// A number of a distribution, which is a weighted mean.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ParameterStatistic {
    /// The mean.
    Mean,
    /// The root of the mean square distance from this value, which is the mean that is matched: the standard deviation where the
    /// mean is met.
    DeviationFrom(f64),
}

impl ParameterStatistic {
    /// As blocks call it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::DeviationFrom(_) => "deviation",
        }
    }

    /// What a value of the parameter adds to the weighted mean.
    pub fn feature(self, value: f64) -> f64 {
        match self {
            Self::Mean => value,
            Self::DeviationFrom(mean) => (value - mean) * (value - mean),
        }
    }

    /// The statistic, of the weighted mean of [`Self::feature`].
    pub fn of_mean(self, mean: f64) -> f64 {
        match self {
            Self::Mean => mean,
            Self::DeviationFrom(_) => libm::sqrt(mean.max(0.0)),
        }
    }
}

impl MatchedParameter {
    /// Between which values the weighted mean of the [feature](ParameterStatistic::feature) has to lie.
    pub fn bounds(&self) -> (f64, f64) {
        let Self { value, within, .. } = *self;
        match self.statistic {
            ParameterStatistic::Mean => (value - within, value + within),
            ParameterStatistic::DeviationFrom(_) => {
                let low = (value - within).max(0.0);
                (low * low, (value + within) * (value + within))
            }
        }
    }
}

fn one_error() -> f64 {
    1.0
}

fn is_one_error(within: &f64) -> bool {
    *within == 1.0
}
