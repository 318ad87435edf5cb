//! What a search found.

use serde::{Deserialize, Serialize};

use super::cases::{CaseRun, SavedCase, SavedSet};
use optimise::{self, OptimisationEnd, SlicePoint};
use scenario::{Goal, Individual, ShownIn};

/// What a search found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchResult {
    /// As the suite calls it.
    pub name: String,
    /// In canonical words, such as `minimise mean(pet)`.
    pub objective: String,
    /// Which values of it are the worst: what the search looks for. The objective says it in words.
    pub direction: Goal,
    /// How the values of each range are shown.
    pub shown_in: Vec<ShownIn>,
    /// How the objective is shown.
    pub objective_in: ShownIn,
    /// Labels of the metrics of every run, in their order.
    pub metrics: Vec<String>,
    /// One per individual, or a single one for all.
    pub found: Vec<Found>,
    /// The cases to keep, in the order of the individuals.
    pub kept: SavedSet,
    /// What is known of how usual its encounters are; `None` where nothing is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub usual: Option<UsualEncounters>,
    /// How many runs of its evaluations are left out, since there are no such encounters: somebody appears inside another body, or would
    /// have to appear before the run begins.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub left_out: usize,
}

fn is_zero(number: &usize) -> bool {
    *number == 0
}

/// How bad encounters are against how usual they are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UsualEncounters {
    /// What the plausibility is of: what is drawn, and people.
    pub of: Vec<String>,
    /// What the search chooses though nothing says how it is distributed: the plausibility says nothing of it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub undeclared: Vec<String>,
    /// Evaluations that have a plausibility above 0 and a value.
    pub possible: usize,
    /// Evaluations of encounters that are never drawn: of plausibility 0.
    pub impossible: usize,
    /// Evaluations of which it cannot be said how usual they are.
    pub unknown: usize,
    /// Evaluations of encounters that are as usual as is asked of what is kept, among which the worst was looked for; `None` where nothing is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wanted: Option<usize>,
    /// Those of the possible ones that no other beats in both: none that is at least as usual is worse. The worst first.
    pub front: Vec<FrontPoint>,
}

/// An encounter such that none that is at least as usual is worse.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrontPoint {
    /// Whose it is, by its index in what was found.
    pub found: usize,
    /// Its index among the evaluations of that.
    pub evaluation: usize,
    /// The objective, as observed.
    pub value: f64,
    /// The share of all encounters that are no more usual, above 0: one in so many is at least as unusual.
    pub plausibility: f64,
    /// The same of what it is made of, by name.
    pub parts: Vec<(String, f64)>,
    /// The objective over fresh seeds in the same encounter.
    pub fresh: Option<f64>,
    /// In how many runs of that the metric exists and was decided before the horizon.
    pub fresh_runs: u32,
    /// Of its first run: `replay` takes it.
    pub key: String,
}

/// The worst that was found for a person (or for everybody).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Those who walk; empty where the scenario draws nobody from a population.
    pub individuals: Vec<Individual>,
    /// Where the best observed value is: one value per dimension, by name.
    pub best: Option<Vec<(String, optimise::Coordinate)>>,
    /// The objective there, as observed.
    pub observed: Option<f64>,
    /// What the surrogate believes of the same point: mean and standard deviation.
    pub predicted: Option<(f64, f64)>,
    /// The objective over fresh seeds at the same point.
    pub fresh: Option<f64>,
    /// In how many runs of that the metric exists and was decided before the horizon.
    pub fresh_runs: u32,
    /// Who passed first at the best point, in the words of the metric `passed_first`; `None` if that was not measured.
    pub passed_first: Option<String>,
    /// How usual the encounter at the best point is: the share of all encounters, as they are declared to be drawn, that are no more so; of
    /// several runs as far as they share it. `None` where nothing says how encounters are drawn, or not how usual this one is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plausibility: Option<f64>,
    /// Objective of every evaluation in order; `None` where it is undefined.
    pub evaluations: Vec<(Vec<optimise::Coordinate>, Option<f64>)>,
    /// How usual the encounter of each evaluation is; empty where nothing says how encounters are drawn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub plausibilities: Vec<Option<f64>>,
    /// Why nothing more was proposed; `None` if the search did not get there.
    pub stop: Option<OptimisationEnd>,
    /// The surrogate through the best point, one slice per dimension.
    pub slices: Vec<Vec<SlicePoint>>,
    /// The runs at the best point, kept or not.
    pub runs: Vec<CaseRun>,
    /// Which of them are kept.
    pub kept: Vec<bool>,
    /// What the metric does along each numeric dimension through the best point: where there is a condition to be kept,
    /// of some individuals that fulfil it.
    pub courses: Vec<MetricCourse>,
}

/// A metric along one dimension of a search, over fresh seeds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MetricCourse {
    /// The dimension's name.
    pub over: String,
    /// In rising order.
    pub points: Vec<CoursePoint>,
}

/// The runs at one value of a dimension; a value at which no run has the metric has no point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CoursePoint {
    /// The value of the dimension, SI units.
    pub at: f64,
    /// The metric's smallest value, SI units.
    pub smallest: f64,
    /// The metric's mean, SI units.
    pub mean: f64,
    /// The metric's largest value, SI units.
    pub largest: f64,
    /// How many of the runs have the metric.
    pub runs: usize,
}

impl Found {
    /// The runs at the best point that are kept.
    pub fn kept_cases(&self) -> impl Iterator<Item = &SavedCase> {
        self.runs.iter().zip(&self.kept).filter(|(_, kept)| **kept).map(|(run, _)| &run.case)
    }
}
