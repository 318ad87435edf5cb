//! What `search` and `tune` blocks declare: adversarial cases to find, controller parameters to optimise.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize};

pub use optimise::{Goal, InitialDesign};

use super::{
    Aggregate, Comparison, Criterion, Individuals, Notation, Origin, Relation, Symbol, Value, significant,
};

/// Finds the values of variations (or model parameters) at which a metric is worst, per individual or for all.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Search {
    /// As the suite calls it.
    pub name: String,
    /// What the suite says of it, in a sentence.
    pub doc: Option<String>,
    /// The scenario that is varied.
    pub scenario: String,
    /// Replaces the scenario's own individuals.
    pub individuals: Option<Individuals>,
    /// One search over the whole population instead of one per individual.
    pub together: bool,
    /// What is worst where.
    pub objective: Objective,
    /// The dimensions of the space, at least one.
    pub over: Vec<SearchRange>,
    /// How many evaluations, and how they are chosen.
    pub budget: Budget,
    /// Runs per evaluation with different seeds, at least 1.
    pub runs: u32,
    /// All that a found case must be to belong to the named set; of nothing every best case does.
    #[serde(default, deserialize_with = "keep")]
    pub keep: Vec<Keep>,
    /// What every run that is kept has to fulfil; the search is not judged without.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub expect: Vec<Criterion>,
    /// Where it is declared.
    pub origin: Origin,
}

/// What a found case must be to be kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
// There are few of them and nobody moves them about.
#[allow(clippy::large_enum_variant)]
pub enum Keep {
    /// What is measured of its run.
    Metric {
        /// With a constant bound.
        comparison: Comparison,
        /// The unit that the bound is written in.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        written_in: Option<Notation>,
    },
    /// How usual the encounter is: the share of all encounters, as they are declared to be drawn, that are no more usual. One of which that
    /// cannot be said is not kept.
    Plausibility {
        /// How it must compare.
        relation: Relation,
        /// Between 0 and 1.
        bound: f64,
    },
}

/// Several conditions, or as it was once written down: one or none.
fn keep<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Keep>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    #[allow(clippy::large_enum_variant)]
    enum Written {
        Several(Vec<Keep>),
        One(Comparison),
        Nothing(()),
    }
    Ok(match Written::deserialize(from)? {
        Written::Several(several) => several,
        Written::One(comparison) => vec![Keep::Metric { comparison, written_in: None }],
        Written::Nothing(()) => Vec::new(),
    })
}

impl Search {
    /// What is asked of metrics of the cases that are kept, with the unit that each bound is written in.
    pub fn kept_metrics(&self) -> impl Iterator<Item = (&Comparison, Option<Notation>)> {
        self.keep.iter().filter_map(|one| match one {
            Keep::Metric { comparison, written_in } => Some((comparison, *written_in)),
            Keep::Plausibility { .. } => None,
        })
    }

    /// Whether only encounters that are usual enough, or unusual enough, are kept.
    pub fn asks_for_plausibility(&self) -> bool {
        self.keep.iter().any(|one| matches!(one, Keep::Plausibility { .. }))
    }
}

/// Optimises controller parameters over a set of cases.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tune {
    /// As the suite calls it.
    pub name: String,
    /// What the suite says of it, in a sentence.
    pub doc: Option<String>,
    /// The cases that each candidate runs.
    pub on: CaseSet,
    /// The dimensions of the space, at least one.
    pub over: Vec<SearchRange>,
    /// One or two; with two the result is a Pareto front.
    pub objectives: Vec<Objective>,
    /// Must hold in every run of the set.
    pub constraints: Vec<Comparison>,
    /// The units that their bounds are written in, in their order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constraints_in: Vec<Option<Notation>>,
    /// Candidates of the user's own, which come after what the scenarios declare and before all others. What one of them leaves out is as
    /// declared.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tries: Vec<Vec<(Target, Value)>>,
    /// How many candidates, and how they are chosen.
    pub budget: Budget,
    /// Runs of every case under fresh seeds, the same for every candidate; 0: once, with the case's own seed.
    #[serde(default)]
    pub fresh: u32,
    /// Abandon a candidate at its first violation instead of running every case.
    pub early_stop: bool,
    /// Where no candidate is feasible, take the one with which the fewest runs violate a constraint.
    #[serde(default)]
    pub otherwise_fewest_violations: bool,
    /// Report a before/after table against the parameters that the scenario declares.
    pub compare_with_default: bool,
    /// Where it is declared.
    pub origin: Origin,
}

/// The cases that a `tune` is judged on, or an `evaluate` compares.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CaseSet {
    /// What a search of this name kept.
    Search(String),
    /// The best cases of every individual of a search, kept or not.
    Bests(String),
    /// Every case of a scenario.
    Scenario(String),
    /// This many cases of a scenario, drawn by the suite's seed.
    Sample {
        /// Its name.
        scenario: String,
        /// How many.
        count: SampleSize,
    },
    /// A saved set; a path resolved against the file that names it.
    Saved(String),
}

/// How many cases a sample has.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SampleSize {
    /// This many, at least 1.
    Number(u32),
    /// As many as a search of this name kept.
    AsManyAs(String),
}

/// What an optimisation makes small or large.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Objective {
    /// Which way it gets better; for a search, worse for the vehicle.
    pub direction: Goal,
    /// Over the runs of an evaluation; a bare metric in the text means its mean.
    pub aggregate: Aggregate,
    /// In canonical words, such as `minimise mean(time_lost)`.
    pub text: String,
    /// The unit in which its block compares the metric to something: what people are shown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub notation: Option<Notation>,
}

/// One dimension of a search space.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchRange {
    /// What takes the values.
    pub target: Target,
    /// Which values it takes.
    pub values: RangeValues,
    /// SI unit shown in reports and labels; empty for plain numbers and words.
    pub unit: String,
    /// The unit that its bounds are written in, if that is another one: what people are shown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub notation: Option<Notation>,
    /// Where it is written.
    pub origin: Origin,
}

/// How the values of a range are shown to people.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ShownIn {
    notation: Option<Notation>,
    unit: String,
}

impl SearchRange {
    /// The unit that its values are shown in.
    pub fn shown_in(&self) -> ShownIn {
        ShownIn::new(self.notation, &self.unit)
    }
}

impl Tune {
    /// The unit that the bound of a constraint is written in.
    pub fn constraint_in(&self, index: usize) -> Option<Notation> {
        self.constraints_in.get(index).copied().flatten()
    }
}

/// Shares are numbers in 0..1 and shown in per cent.
const PER_CENT: Notation = Notation { symbol: Symbol::new("%"), numerator: 1.0, denominator: 100.0 };

impl ShownIn {
    /// In `notation`, else in the SI unit `unit`, which may be empty; `%` for shares in 0..1.
    pub fn new(notation: Option<Notation>, unit: &str) -> Self {
        let notation = notation.or((unit == "%").then_some(PER_CENT));
        Self { notation, unit: unit.to_string() }
    }

    /// A number in SI units with four significant digits and its unit.
    pub fn show(&self, si: f64) -> String {
        let unit = self.notation.as_ref().map_or(self.unit.as_str(), |notation| notation.symbol.as_str());
        format!("{} {unit}", self.number(si)).trim_end().to_string()
    }

    /// As [`Self::show`], without the unit.
    pub fn number(&self, si: f64) -> String {
        self.rounded(si, 4)
    }

    /// As [`Self::number`], with that many significant digits.
    pub fn rounded(&self, si: f64, digits: i32) -> String {
        significant(self.notation.map_or(si, |notation| notation.of_si(si)), digits)
    }
}

/// What a dimension varies.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// A variation of the scenario, whose own values it replaces.
    Variation(String),
    /// A parameter such as `av.controller.braking_distance`.
    Setting {
        /// The vehicle or pedestrian, by name.
        road_user: String,
        /// What of it is set.
        part: Part,
        /// As its declaration calls it.
        parameter: String,
    },
}

/// Which model of a road user a parameter belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// `controller` of a vehicle.
    Controller,
    /// `dynamics` of a vehicle.
    Dynamics,
    /// `sees` of a vehicle: its perception.
    Sees,
    /// `model` of a pedestrian.
    Model,
}

/// The values that a dimension of a search space takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RangeValues {
    /// SI units.
    Real {
        /// The smallest, SI units.
        low: f64,
        /// The largest, SI units.
        high: f64,
    },
    /// Searched on a logarithmic scale; both positive.
    Logarithmic {
        /// The smallest, SI units.
        low: f64,
        /// The largest, SI units.
        high: f64,
    },
    /// Whole numbers.
    Whole {
        /// The smallest.
        low: i64,
        /// The largest.
        high: i64,
    },
    /// One of these, in no order.
    Words(Vec<String>),
}

/// How many evaluations an optimisation makes, and how it chooses them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Budget {
    /// In all, the initial ones included.
    pub evaluations: u32,
    /// Those of the design that it begins with.
    pub initial: u32,
    /// How the first points spread.
    pub initial_design: InitialDesign,
    /// What proposes the points after them.
    pub method: SearchMethod,
    /// Evaluations proposed at a time.
    pub batch: u32,
}

/// What proposes points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SearchMethod {
    /// Surrogates that are Gaussian processes, each constraint with one of its own; see `docs/optimisation.md`.
    Bayesian,
    /// Infeasible evaluations as one large constant, as the founding paper does.
    GpMinimizeLike,
    /// Independent uniform points.
    Random,
    /// One Latin hypercube of the whole budget.
    LatinHypercube,
    /// Scrambled Sobol points.
    Sobol,
    /// A regular grid of as many points as the budget allows.
    Grid,
}

impl Target {
    /// Its whole name as that of a definition: `av_controller_braking_distance`.
    pub fn identifier(&self) -> String {
        self.to_string().replace('.', "_")
    }
}

impl fmt::Display for Target {
    /// As it is written in a scenario: `tta` or `av.controller.braking_distance`.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Variation(name) => name.fmt(out),
            Self::Setting { road_user, part, parameter } => {
                let part = match part {
                    Part::Controller => "controller",
                    Part::Dynamics => "dynamics",
                    Part::Sees => "sees",
                    Part::Model => "model",
                };
                write!(out, "{road_user}.{part}.{parameter}")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_shown_in_the_unit_that_was_written() {
        let kmh = Notation { symbol: Symbol::new("km/h"), numerator: 5.0, denominator: 18.0 };
        assert_eq!(ShownIn::new(Some(kmh), "m/s").show(50.0 / 3.6), "50 km/h");
        assert_eq!(ShownIn::new(None, "m/s").show(50.0 / 3.6), "13.89 m/s");
        assert_eq!(ShownIn::new(None, "%").show(0.85), "85 %");
        assert_eq!(ShownIn::new(None, "").show(3.0), "3");
        assert_eq!(ShownIn::new(Some(kmh), "m/s").number(10.0), "36");
    }
}
