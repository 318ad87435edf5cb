//! What a search found.

use serde::{Deserialize, Serialize};

use super::cases::{CaseRun, SavedCase, SavedSet};
use super::finding::Finding;
use super::verdict::Verdict;
use super::written_counts::is_zero;
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
    /// What the search expects of the runs that it kept; `None` of one that expects nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub judged: Option<JudgedSearch>,
    /// How many runs of its evaluations are left out, of [encounters that cannot be](NO_ENCOUNTER).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub left_out: usize,
}

/// When an encounter cannot be, so that its run is left out.
pub const NO_ENCOUNTER: &str = "a pedestrian appears inside another body, waits for a time to arrival that is past, or could not go before the run ended";

/// What became of the expectations of a search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JudgedSearch {
    /// The search kept some runs; otherwise the best observed ones are judged.
    pub of_kept: bool,
    /// Every run that is judged, by itself; none where nothing was found.
    pub runs: Vec<JudgedRun>,
}

/// A run that a search found, against what the search expects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JudgedRun {
    /// Of the run in which it was found: `replay` takes it.
    pub key: String,
    /// Whose it is, by its index in what was found.
    pub found: usize,
    /// One for each criterion, in order.
    pub findings: Vec<Finding>,
    /// In how many of the runs with fresh seeds at the same point every criterion holds. Decides nothing.
    pub fresh_holding: usize,
    /// How many of those there are.
    pub fresh_runs: usize,
}

impl JudgedRun {
    /// The worst of the findings.
    pub fn verdict(&self) -> Verdict {
        self.findings.iter().map(|finding| finding.verdict).max().unwrap_or(Verdict::Passed)
    }
}

impl JudgedSearch {
    /// The worst of the runs; inconclusive without any.
    fn verdict(&self) -> Verdict {
        self.runs.iter().map(JudgedRun::verdict).max().unwrap_or(Verdict::Inconclusive)
    }

    /// How many runs have this verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.runs.iter().filter(|run| run.verdict() == verdict).count()
    }

    /// Some criterion passed without being put to the test.
    pub fn is_untested(&self) -> bool {
        self.runs.iter().flat_map(|run| &run.findings).any(|finding| finding.untested.is_some())
    }

    /// `2 of 3 kept runs`, or `the best observed run, since nothing was kept`.
    fn of_which(&self, runs: usize) -> String {
        let all = self.runs.len();
        match (self.of_kept, all) {
            (true, 1) => "the kept run".to_string(),
            (true, _) => format!("{runs} of {all} kept runs"),
            (false, 1) => "the best observed run, since nothing was kept".to_string(),
            (false, _) => format!("{runs} of {all} best observed runs, since nothing was kept"),
        }
    }

    /// Why no run is judged.
    pub fn nothing(&self) -> &'static str {
        "nothing was found that could be judged"
    }

    /// Why it did not pass; `None` if it did.
    fn failure(&self) -> Option<String> {
        let verdict = self.verdict();
        if verdict == Verdict::Passed {
            return None;
        }
        let Some(first) = self.runs.iter().find(|run| run.verdict() == verdict) else {
            return Some(self.nothing().to_string());
        };
        let mut criteria: Vec<String> = Vec::new();
        for finding in self.runs.iter().flat_map(|run| &run.findings).filter(|one| one.verdict == verdict) {
            let named = format!("`{}`", finding.criterion);
            if !criteria.contains(&named) {
                criteria.push(named);
            }
        }
        let what = match (verdict, criteria.len()) {
            (Verdict::Inconclusive, _) => "cannot be decided in",
            (_, 1) => "does not hold in",
            _ => "do not hold in",
        };
        let (criteria, of) = (criteria.join(", "), self.of_which(self.count(verdict)));
        Some(format!("{criteria} {what} {of}: {}", first.key))
    }
}

impl SearchResult {
    /// The number of evaluations, of all people together.
    pub fn evaluations(&self) -> usize {
        self.found.iter().map(|found| found.evaluations.len()).sum()
    }

    /// Its verdict; `None` of a search that found something and expects nothing.
    pub(super) fn verdict(&self) -> Option<Verdict> {
        match &self.judged {
            _ if self.has_no_value() => Some(Verdict::Inconclusive),
            judged => judged.as_ref().map(JudgedSearch::verdict),
        }
    }

    /// Why it did not pass, or why that cannot be said; `None` otherwise.
    pub(super) fn failure(&self) -> Option<String> {
        if self.has_no_value() {
            return Some(format!("no evaluation has a value of `{}`: nothing was found", self.objective));
        }
        self.judged.as_ref().and_then(JudgedSearch::failure)
    }

    fn has_no_value(&self) -> bool {
        let mut values = self.found.iter().flat_map(|found| &found.evaluations);
        values.all(|(_, value)| value.is_none())
    }
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
