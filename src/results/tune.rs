//! What a tune chose.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::cases::MetricSummary;
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
    /// Where the chosen candidate is not feasible: in how many runs of the set it violates a constraint.
    pub violations: Option<Violations>,
    /// With two objectives: the candidates that no other beats in both.
    pub pareto: Vec<Candidate>,
    /// Every candidate in order.
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
    /// One value per parameter, in the order of [`TuneResult::parameters`].
    pub point: Vec<optimise::Coordinate>,
    /// One per objective, SI units; `None` where no run gives one.
    pub objectives: Vec<Option<f64>>,
    /// Worst margin over the set per constraint; negative is violated, `None` cannot be said.
    pub margins: Vec<Option<f64>>,
    /// Whether it keeps every constraint on the set.
    pub feasible: bool,
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
    /// Whether the chosen candidate keeps every constraint on the fresh runs too.
    pub feasible_fresh: bool,
}
