//! What a calibration came to: weights of candidates, and how well they do what people did.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::json;

use scenario::population::{Population, VEHICLE_SPEEDS};

/// Weights of candidates, and how well they do what people did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CalibrateResult {
    /// As the suite calls it.
    pub name: String,
    /// What the suite says of it, in a sentence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doc: Option<String>,
    /// What was matched, such as `rate(gap_accepted)`.
    pub matched: String,
    /// To what: the file's name.
    pub observations: String,
    /// Where the candidates come from, in words.
    pub candidates: String,
    /// The model that the candidates are parameter sets of.
    pub model: String,
    /// Its variant, if it has variants.
    pub variant: Option<String>,
    /// The names of the columns.
    pub parameters: Vec<String>,
    /// One row per candidate, in SI units.
    pub individuals: Vec<Vec<f64>>,
    /// One per candidate, of sum 1.
    pub weights: Vec<f64>,
    /// Of the population: see [`Population::digest`].
    pub digest: String,
    /// How many candidates of equal weight vary a mean as much.
    pub effective_size: f64,
    /// A row of the observations each, in the order of the scenarios and of what they vary.
    pub conditions: Vec<CalibratedCondition>,
    /// What was known besides of how parameters are distributed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub matched_parameters: Vec<CalibratedParameter>,
    /// In how many parts conditions were held back.
    pub folds: u32,
    /// Root mean square error of shares in conditions that were held back part by part; `None` where none were.
    pub folds_rms: Option<f64>,
    /// The same, of each condition alone held back; `None` of a single condition.
    pub left_out_rms: Option<f64>,
    /// Root mean square error of shares under noise that no weight has seen.
    pub fresh_rms: f64,
    /// Runs of every candidate in every condition, and as many of fresh noise.
    pub runs: u32,
    /// The suite's seed.
    pub seed: u64,
    /// The speeds of vehicles that people were observed with, in rising order, m/s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub vehicle_speeds: Vec<f64>,
    /// Other populations in the same conditions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub compared: Vec<ComparedPopulation>,
    /// Weights for observations that are drawn again from the persons, as other persons might have been observed.
    pub resampled: Vec<Vec<f64>>,
    /// What has to be known of it.
    pub warnings: Vec<String>,
}

/// A condition, as people and as candidates did in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CalibratedCondition {
    /// The scenario.
    pub scenario: String,
    /// What varies, such as `gap=3s`.
    pub values: String,
    /// The matched rate, where there are several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<String>,
    /// How many trials were observed.
    pub trials: u32,
    /// Of how many persons.
    pub persons: u32,
    /// Share of the candidates' runs in which the metric does not exist or was cut off, by weight.
    pub undefined: f64,
    /// Which runs the shares are of, where not all count.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counted: Option<CountedRuns>,
    /// The share of trials.
    pub share: CalibratedShare,
    /// The share of pairs of a person's trials in which both hold; `None` where it is not known of people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread: Option<CalibratedShare>,
}

/// The runs that shares are of, where not all count.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CountedRuns {
    /// Their share of all, by the weights, 0 to 1.
    pub share: f64,
    /// On how many runs of equal weight the share under fresh noise rests.
    pub runs: f64,
    /// Of how many candidates of equal weight.
    pub candidates: f64,
}

/// A population that was put into the conditions of a calibration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ComparedPopulation {
    /// Its name, or its file's.
    pub name: String,
    /// See [`Population::digest`].
    pub digest: String,
    /// How many of them, each a row of its own.
    pub individuals: usize,
    /// Runs of each in every condition.
    pub runs: u32,
    /// Share of runs and share of pairs of a person's runs, of each condition in their order, 0 to 1; `None` where nobody was left to do it.
    pub shares: Vec<(Option<f64>, Option<f64>)>,
    /// What the matched statistics of parameters are among them, SI units, in their order; `None` where nobody says it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<Option<f64>>,
}

/// A statistic of a parameter as it was to be matched and as it is among the candidates, SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CalibratedParameter {
    /// As the model declares it.
    pub parameter: String,
    /// `mean`, or `deviation`: the root mean square distance from the mean that was to be matched.
    pub statistic: String,
    /// Of the numbers.
    pub unit: String,
    /// What it was to be.
    pub wanted: f64,
    /// How far from it at most.
    pub within: f64,
    /// Of all candidates, equally weighed.
    pub equal: f64,
    /// By the weights.
    pub fitted: f64,
}

/// A share as observed and as computed, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CalibratedShare {
    /// Of people.
    pub observed: f64,
    /// Its standard error, by drawing persons anew.
    pub error: f64,
    /// Of all candidates, equally weighed.
    pub equal: f64,
    /// By the weights, in the runs that they are from.
    pub fitted: f64,
    /// By the weights, in other runs.
    pub fresh: f64,
    /// By weights that do not know the condition; `None` of a single condition, and where they leave nobody to do it.
    pub left_out: Option<f64>,
    /// Whether the weights were to match it.
    pub matched: bool,
}

impl CalibratedCondition {
    /// The scenario and its values, such as `crossing gap=3s`.
    pub fn place(&self) -> String {
        format!("{} {}", self.scenario, self.values).trim_end().to_string()
    }

    /// The same, followed by the rate where several are matched.
    pub fn in_words(&self) -> String {
        self.rate.as_ref().map_or_else(|| self.place(), |rate| format!("{}: {rate}", self.place()))
    }
}

impl CalibrateResult {
    /// The largest error of a share under fresh noise.
    pub fn worst_fresh(&self) -> f64 {
        let error = |one: &CalibratedCondition| (one.share.fresh - one.share.observed).abs();
        self.conditions.iter().map(error).fold(0.0, f64::max)
    }

    /// What the weights are good for elsewhere.
    pub fn population(&self) -> Population {
        let conditions: Vec<_> = self
            .conditions
            .iter()
            .map(|one| {
                let mut told = json!({
                    "scenario": one.scenario,
                    "values": one.values,
                    "observed": one.share.observed,
                    "error": one.share.error,
                    "fresh": one.share.fresh,
                    "left_out": one.share.left_out,
                });
                if let Some(spread) = &one.spread {
                    told["spread_observed"] = json!(spread.observed);
                    told["spread_error"] = json!(spread.error);
                    told["spread_fresh"] = json!(spread.fresh);
                }
                if let Some(rate) = &one.rate {
                    told["rate"] = json!(rate);
                }
                if let Some(counted) = one.counted {
                    told["counted"] = json!(counted);
                }
                told
            })
            .collect();
        let provenance = [
            ("tool", json!(format!("scenario-runner {} calibrate {}", env!("CARGO_PKG_VERSION"), self.name))),
            ("matched", json!(self.matched)),
            ("observations", json!(self.observations)),
            ("candidates", json!(self.candidates)),
            ("runs", json!(self.runs)),
            ("seed", json!(self.seed)),
            ("effective_size", json!(self.effective_size)),
            ("fresh_rms", json!(self.fresh_rms)),
            ("left_out_rms", json!(self.left_out_rms)),
            ("conditions", json!(conditions)),
            ("warnings", json!(self.warnings)),
        ];
        let mut provenance = BTreeMap::from(provenance.map(|(name, value)| (name.to_owned(), value)));
        if !self.matched_parameters.is_empty() {
            provenance.insert("matched_parameters".to_owned(), json!(self.matched_parameters));
        }
        if !self.vehicle_speeds.is_empty() {
            provenance.insert(VEHICLE_SPEEDS.to_owned(), json!(self.vehicle_speeds));
        }
        Population {
            model: self.model.clone(),
            variant: self.variant.clone(),
            source: match &self.doc {
                Some(doc) => format!("calibrated to {} by maximum entropy: {doc}", self.observations),
                None => format!("calibrated to {} by maximum entropy", self.observations),
            },
            provenance,
            parameters: self.parameters.clone(),
            individuals: self.individuals.clone(),
            weights: self.weights.clone(),
        }
    }

    /// The population with weights that other persons might have given, numbered from 0; `None` beyond those there are.
    pub fn resampled_population(&self, number: usize) -> Option<Population> {
        let weights = self.resampled.get(number)?.clone();
        let mut population = Population { weights, ..self.population() };
        population.source = format!("{}, persons drawn again ({})", population.source, number + 1);
        population.provenance.retain(|name, _| {
            !["effective_size", "fresh_rms", "left_out_rms", "conditions", "warnings"]
                .contains(&name.as_str())
        });
        Some(population)
    }
}
