//! What a suite's runs came to, kept to compare later runs with.

mod file;
mod pairing;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::written_counts::is_zero;
use crate::{Requests, is_use, is_value};
use scenario::registry::Registry;
use scenario::{ControllerModel, DynamicsModel, Metric, ModelSetup, PerceptionModel, Reference, Settings};

pub use file::BaselineError;
pub use pairing::{Incompatible, Pairing, WorldPart, pair, some};

/// The metrics of every run of a suite, with what decides whether other runs may be compared with them.
///
/// What is tested, controllers with their parameters, dynamics and perception, is listed but may change: that is what
/// a comparison is for. Everything else of the cases is held by the [`Parts`] of each trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Baseline {
    /// The suite's name.
    pub suite: String,
    /// As [`scenario::Suite::apart`]; nothing of one that was written.
    #[serde(skip)]
    pub apart: String,
    /// That of the suite.
    pub seed: u64,
    /// What was set on the command line instead of what the files say: `av.speed=40km/h`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// The version of scenario-runner that ran it.
    pub tool: String,
    /// Digests of everybody in the populations that people were drawn from, by the names of their files.
    pub populations: BTreeMap<String, String>,
    /// Which version it was, of those of them that ship with the program.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub population_versions: BTreeMap<String, u32>,
    /// Names and versions that programs under test say of themselves, by what the files call them.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub programs: BTreeMap<String, String>,
    /// What runs as each declared controller, by what the files call it: `python3 av.py, gives acceleration`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub what_runs: BTreeMap<String, String>,
    /// Programs under test that do not decide the same each time, by what the files call them, each with how that is known: what differed when
    /// runs were made twice, or that the declaration says so.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub nondeterministic: BTreeMap<String, String>,
    /// What was measured in every run, in the order of each run's values.
    pub metrics: Vec<RecordedMetric>,
    /// The different sets of vehicles that trials have, in the order in which trials first use them.
    pub vehicles: Vec<Vec<TestedVehicle>>,
    /// Sorted by key.
    pub trials: Vec<RecordedTrial>,
}

/// A metric as it was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedMetric {
    /// As reports call it, such as `pet` or `max_deceleration(window=0.5)`.
    pub label: String,
    /// The metric's name.
    pub name: Reference<Metric>,
    /// The SI unit, `yes or no`, or the words it takes.
    pub unit: String,
    /// Every parameter with its value, so that a changed default is seen.
    pub settings: Settings,
    /// Vehicle and pedestrian whom it is of; `None`: the worst pair.
    pub pair: Option<(String, String)>,
}

impl RecordedMetric {
    /// Whether both are of one metric, measured alike: a parameter that one of them does not name is what it was before it could be set.
    pub fn is_as(&self, other: &Self) -> bool {
        let entry = self.name.known().or(other.name.known());
        let parameters = entry.map_or(&[][..], |metric| &metric.declaration.parameters);
        let completed = |metric: &Self| {
            let mut settings = metric.settings.clone();
            for parameter in parameters {
                let is_said = metric.settings.get(&parameter.name).is_some();
                if let Some(before) = parameter.before.as_ref().filter(|_| !is_said) {
                    settings.set(&*parameter.name, before.clone());
                }
            }
            Self { settings, ..metric.clone() }
        };
        completed(self) == completed(other)
    }
}

/// A vehicle with everything about it that is under test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TestedVehicle {
    /// As the scenario calls it.
    pub name: String,
    /// What drives it, with every parameter.
    pub controller: ModelSetup<ControllerModel>,
    /// What it drives, with every parameter.
    pub dynamics: ModelSetup<DynamicsModel>,
    /// `None`: perfect perception.
    pub sees: Option<ModelSetup<PerceptionModel>>,
    /// m
    pub length: f64,
    /// m
    pub width: f64,
    /// Whether it stops for a signal's red.
    #[serde(default, skip_serializing_if = "is_false")]
    pub obeys_signals: bool,
}

fn is_false(flag: &bool) -> bool {
    !flag
}

/// All runs of one trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RecordedTrial {
    /// Without the suite's name: `carla_walker/tta=6s`.
    pub key: String,
    /// The scenario's name.
    pub scenario: String,
    /// Whether there is no chance in it: other seeds give the same runs, bit for bit.
    pub certain: bool,
    /// Changes when any bit of any run's course does; 16 hexadecimal digits.
    pub fingerprint: String,
    /// Changes when the seed of any run does; 12 hexadecimal digits. Baselines of version 0.1 do not say.
    pub seeds: Option<String>,
    /// How many of its runs the horizon ended before somebody was through whom a vehicle had yet to meet, or anything ended on a
    /// collision course: what they would have come to is not known.
    #[serde(skip_serializing_if = "is_zero")]
    pub cut_off: usize,
    /// Models in it that are others than were published, in words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// What decides its runs besides what is tested.
    pub parts: Parts,
    /// Index into [`Baseline::vehicles`].
    pub vehicles: usize,
    /// What follows the trial's key in the keys of its runs: `rep=2`, `individual=17/rep=2`.
    pub runs: Vec<String>,
    /// One row per metric of [`Baseline::metrics`], one value per run; `None` where the metric does not exist.
    pub values: Vec<Vec<Option<f64>>>,
}

/// Hashes of what decides a trial's runs besides what is tested; 12 hexadecimal digits each.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parts {
    /// Lanes, kerbs, crossing, speed limit and boxes.
    pub road: String,
    /// Models with their settings, sizes, ways and when they appear.
    pub pedestrians: String,
    /// The individuals drawn from populations.
    pub people: String,
    /// How fast, in which lane and from where the vehicles come.
    pub traffic: String,
    /// Step, horizon, finish line, and what every run draws.
    pub simulation: String,
}

impl Baseline {
    /// The same, with what a registry knows of the metrics in it: of one that was read, only their names are known.
    pub fn resolved(mut self, registry: &Registry) -> Self {
        for metric in &mut self.metrics {
            if let Some(known) = registry.metrics().get(metric.name.name()) {
                metric.name = known.into();
            }
        }
        self
    }

    /// The full key of a run.
    pub fn run_key(&self, trial: &RecordedTrial, run: usize) -> String {
        format!("{}{}/{}/{}", self.apart, self.suite, trial.key, trial.runs[run])
    }

    /// Whether the command line said the same otherwise for both, in whatever order: values, and controllers in the place of others.
    pub fn has_set(&self, set: &[String]) -> bool {
        self.agrees(set, |one| !is_use(one))
    }

    /// Whether the same values were set for both, in whatever order, whichever controllers were tested with them.
    pub fn has_values(&self, set: &[String]) -> bool {
        self.agrees(set, is_value)
    }

    fn agrees(&self, set: &[String], counts: impl Fn(&str) -> bool) -> bool {
        let sorted = |set: &[String]| {
            let mut set: Vec<String> = set.iter().filter(|one| counts(one)).cloned().collect();
            set.sort_unstable();
            set
        };
        sorted(&self.set) == sorted(set)
    }

    /// Forgets all other metrics.
    pub fn keep_metrics(&mut self, wanted: &Requests) {
        let kept: Vec<bool> =
            self.metrics.iter().map(|metric| wanted.iter().any(|one| one.label() == metric.label)).collect();
        let mut keep = kept.iter();
        self.metrics.retain(|_| *keep.next().expect("there is one per metric"));
        for trial in &mut self.trials {
            let mut keep = kept.iter();
            trial.values.retain(|_| *keep.next().expect("there is a row per metric"));
        }
    }

    /// Of all trials.
    pub fn runs(&self) -> usize {
        self.trials.iter().map(|trial| trial.runs.len()).sum()
    }

    /// Its scenarios in the order of the trials.
    pub fn scenarios(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for trial in &self.trials {
            if !names.contains(&trial.scenario.as_str()) {
                names.push(&trial.scenario);
            }
        }
        names
    }
}

impl RecordedTrial {
    /// The part of a run's label that names its people; empty without individuals.
    pub fn person(&self, run: usize) -> &str {
        self.runs[run].rsplit_once("/rep=").map_or("", |(people, _)| people)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::{
        Absence, Declaration, Dimension, Meters, MetricKind, MetricRange, Parameter, Scope, Stake, Value,
        Worst,
    };

    fn parameter(name: &'static str) -> Parameter {
        Parameter::number(name, Dimension::TIME, 2.0, (0.0, 9.0), "Over which time.", "free choice")
    }

    /// A metric with these settings, of which `added` is the one that could not always be set.
    fn recorded(known: bool, settings: &[(&str, f64)]) -> RecordedMetric {
        let parameters = [parameter("window"), parameter("added").was(Value::Number(1.0))];
        let metric = Metric {
            declaration: Declaration::new("drag", "How much it drags.").parameters(parameters),
            kind: MetricKind::Quantity(Dimension::TIME),
            scope: Scope::Vehicle,
            worst: Worst::Largest,
            absence: Absence::Open,
            range: MetricRange::NotNegative,
            stake: Stake::Motion,
            meters: Meters::new(()),
        };
        RecordedMetric {
            label: "drag".into(),
            name: if known { (&std::sync::Arc::new(metric)).into() } else { Reference::unresolved("drag") },
            unit: "s".into(),
            settings: (&settings
                .iter()
                .map(|(name, value)| (*name, Value::Number(*value)))
                .collect::<Vec<_>>()[..])
                .into(),
            pair: None,
        }
    }

    #[test]
    fn what_could_not_be_set_when_it_was_recorded_is_what_it_was_then() {
        let before = recorded(false, &[("window", 2.0)]);
        assert!(before.is_as(&recorded(true, &[("window", 2.0), ("added", 1.0)])));
        assert!(recorded(true, &[("window", 2.0), ("added", 1.0)]).is_as(&before));
        assert!(!before.is_as(&recorded(true, &[("window", 2.0), ("added", 2.0)])), "measured otherwise");
        assert!(!before.is_as(&recorded(true, &[("window", 3.0), ("added", 1.0)])), "measured otherwise");
        // Of others nobody knows what they were.
        assert!(
            !recorded(false, &[("added", 1.0)]).is_as(&recorded(true, &[("window", 2.0), ("added", 1.0)]))
        );
    }
}
