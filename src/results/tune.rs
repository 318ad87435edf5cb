//! What a tune chose.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::cases::MetricSummary;
use super::finding::Untested;
use optimise::{self, OptimisationEnd, SlicePoint};
use scenario::ShownIn;

/// What a tune came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TuneResult {
    /// As the suite calls it.
    pub name: String,
    /// In canonical words, such as `minimise mean(time_lost)`; one or two.
    pub objectives: Vec<String>,
    /// In canonical words.
    pub constraints: Vec<String>,
    /// Number of cases in the set.
    pub cases: usize,
    /// Runs of every case under fresh seeds; 0: once, with the case's own seed.
    pub fresh: u32,
    /// The parameters that are tuned, as a scenario would name them.
    pub parameters: Vec<String>,
    /// How the values of each are shown.
    pub shown_in: Vec<ShownIn>,
    /// How the objectives are shown.
    pub objectives_in: Vec<ShownIn>,
    /// How the margins of the constraints are shown.
    pub margins_in: Vec<ShownIn>,
    /// The chosen candidate; `None` if no candidate was ever feasible and the block does not say `otherwise`.
    pub chosen: Option<Candidate>,
    /// By how much the first objective of the chosen candidate differs from that of the declared values, on runs with fresh seeds;
    /// `None` where the declared values are chosen, or break a constraint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub change: Option<f64>,
    /// Where the chosen candidate is not feasible: in how many runs of the set it violates a constraint.
    pub violations: Option<Violations>,
    /// With two objectives: the candidates that no other beats in both.
    pub pareto: Vec<Candidate>,
    /// In how many runs of the set with fresh seeds the chosen candidate violates a constraint, or each of those that no other beats;
    /// empty without constraints.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fresh_violations: Vec<Violations>,
    /// Constraints that nothing put to the test in the runs with fresh seeds of what is chosen, or of one of those that no other beats.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub untested: Vec<UntestedConstraint>,
    /// Every candidate in order; the first is what the scenarios declare.
    pub evaluations: Vec<Candidate>,
    /// Why nothing more was proposed; `None` if the tune did not get there.
    pub stop: Option<OptimisationEnd>,
    /// The surrogate of the first objective through the chosen candidate, one slice per parameter.
    pub slices: Vec<Vec<SlicePoint>>,
    /// What the scenarios declare against the chosen candidate.
    pub comparison: Option<BeforeAndAfter>,
}

/// Values of the parameters with what they give on the set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Where it comes from.
    #[serde(default, skip_serializing_if = "CandidateOrigin::is_method")]
    pub origin: CandidateOrigin,
    /// One value per parameter, in the order of [`TuneResult::parameters`]; empty of what is declared where that is not one value for all
    /// cases.
    pub point: Vec<optimise::Coordinate>,
    /// One per objective, SI units; `None` where no run gives one.
    pub objectives: Vec<Option<f64>>,
    /// Worst margin over the set per constraint; negative is violated, `None` cannot be said.
    pub margins: Vec<Option<f64>>,
    /// Whether it keeps every constraint on the set; so it does one without a margin if what that bounds never arose.
    pub keeps_constraints: bool,
    /// Whether it does, and every objective has a value.
    pub feasible: bool,
}

/// Where a candidate comes from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CandidateOrigin {
    /// The scenarios: the values that they declare.
    Declared,
    /// The user: `try { … }`.
    Tried,
    /// The method.
    #[default]
    Method,
}

impl CandidateOrigin {
    fn is_method(&self) -> bool {
        *self == Self::Method
    }
}

impl Candidate {
    /// Keeps every constraint, but an objective has no value.
    pub fn has_no_value(&self) -> bool {
        self.objectives.contains(&None) && self.keeps_constraints
    }
}

impl TuneResult {
    /// The values that the scenarios declare are chosen.
    pub fn keeps_declared(&self) -> bool {
        self.chosen.as_ref().is_some_and(|chosen| chosen.origin == CandidateOrigin::Declared)
    }

    /// In how many runs with fresh seeds what is chosen violates a constraint, the most of several; `None` if in none.
    pub fn broken_on_fresh(&self) -> Option<Violations> {
        let broken = self.fresh_violations.iter().filter(|one| one.runs > 0);
        broken.max_by_key(|one| one.runs).copied()
    }

    /// That what is chosen breaks a constraint with fresh seeds, in a sentence.
    pub fn broken_on_fresh_words(&self) -> Option<String> {
        let Violations { runs, of } = self.broken_on_fresh()?;
        let which = match self.chosen {
            Some(_) => "the chosen candidate",
            None => "a candidate on the front",
        };
        Some(format!("{which} breaks a constraint on the fresh seeds, in {runs} of {of} runs"))
    }

    /// What has to be known of what is chosen: that it breaks a constraint somewhere.
    pub fn caveat(&self) -> Option<String> {
        let fresh = || {
            let Violations { runs, of } = self.broken_on_fresh()?;
            Some(format!("infeasible with fresh seeds: breaks a constraint in {runs} of {of} runs"))
        };
        self.violations.map(|violations| violations.to_string()).or_else(fresh)
    }

    /// Why nothing is chosen; `None` if something is.
    pub fn nothing_chosen(&self) -> Option<&'static str> {
        if self.chosen.is_some() || !self.pareto.is_empty() {
            return None;
        }
        let unknown = self.evaluations.iter().filter(|one| one.has_no_value()).count();
        Some(match unknown {
            0 => "no candidate keeps every constraint: nothing is chosen",
            all if all == self.evaluations.len() => "no candidate has a value: nothing is chosen",
            _ => "no candidate that keeps every constraint has a value: nothing is chosen",
        })
    }

    /// Why it is not what was asked for; `None` if it is.
    pub(super) fn failure(&self) -> Option<String> {
        if let Some(why) = self.nothing_chosen() {
            return Some(why.to_string());
        }
        if let Some(violations) = &self.violations {
            return Some(format!("what is chosen is {violations}"));
        }
        self.broken_on_fresh_words()
    }
}

/// A constraint about which nothing was at stake.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct UntestedConstraint {
    /// In canonical words.
    pub constraint: String,
    /// Why.
    pub reason: Untested,
}

/// Runs in which a constraint is violated, of those that were made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Violations {
    /// Those that violate one.
    pub runs: usize,
    /// All that were made.
    pub of: usize,
}

impl fmt::Display for Violations {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { runs, of } = self;
        write!(
            out,
            "infeasible: breaks a constraint in {runs} of {of} runs of its tune, and no candidate in fewer"
        )
    }
}

/// Before and after, on the same runs and on fresh ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BeforeAndAfter {
    /// How each of the metrics is shown, in their order; flags as shares.
    #[serde(default)]
    pub shown_in: Vec<ShownIn>,
    /// With the parameters that the scenario declares, on the cases of the tune.
    pub before: Vec<MetricSummary>,
    /// With the chosen candidate, on the cases of the tune.
    pub after: Vec<MetricSummary>,
    /// The same cases with other seeds: what remains once the luck of the selection is gone.
    pub before_fresh: Vec<MetricSummary>,
    /// With the chosen candidate, on the same cases with other seeds.
    pub after_fresh: Vec<MetricSummary>,
}
