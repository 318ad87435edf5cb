//! What a statement came to.

use serde::{Deserialize, Serialize};

use super::finding::Untested;
use super::verdict::Verdict;
use scenario::{DeclaredStanding, Relation, TrendDirection};

/// What a statement came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StatementResult {
    /// As the suite calls it.
    pub name: String,
    /// What the source says.
    pub doc: Option<String>,
    /// Where the source says it, such as `Wang et al., experiment 2`.
    pub source: Option<String>,
    /// The numbers that the source gives, in words.
    pub reported: Option<String>,
    /// Whether it is reproduced.
    pub conclusion: Conclusion,
    /// What became of each claim, in order.
    pub claims: Vec<ClaimResult>,
    /// What the suite declares to be known of it.
    pub standing: DeclaredStanding,
}

/// What a statement's claims come to together.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Conclusion {
    /// Every claim holds.
    Reproduced,
    /// Every claim holds, and nothing was at stake in the runs that one of them is about.
    Untested,
    /// At least one does not.
    NotReproduced,
    /// None is known not to hold, but not all can be looked at: the reason.
    NotComparable(String),
}

/// One claim with the numbers that decide it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClaimResult {
    /// In canonical words.
    pub text: String,
    /// `None` if that cannot be said.
    pub holds: Option<bool>,
    /// Why it cannot be said.
    pub undefined: Option<String>,
    /// Why it holds of nothing: in no run that it measures was anything at stake.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub untested: Option<Untested>,
    /// The numbers that decide it.
    pub values: ClaimValues,
    /// SI unit of the values; `%` says that they are shares in 0..1.
    pub unit: String,
}

/// The numbers of a claim, in the unit that [`ClaimResult`] states.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClaimValues {
    /// Of two quantities.
    Compared {
        /// `None` where no run gives one.
        left: Option<f64>,
        /// How the two must compare.
        relation: Relation,
        /// `None` where no run gives one.
        right: Option<f64>,
    },
    /// Of an aggregate along a variation.
    Trend {
        /// Which way it must move.
        direction: TrendDirection,
        /// The variation's name.
        variable: String,
        /// In ascending order of the variation's values.
        points: Vec<TrendPoint>,
    },
}

/// The aggregate at one value of the variation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrendPoint {
    /// The value of the variation as it was written.
    pub label: String,
    /// The value of the variation, SI units.
    pub at: f64,
    /// `None` where no run gives one.
    pub value: Option<f64>,
    /// Runs that the aggregate is over.
    pub runs: usize,
}

impl StatementResult {
    /// Why the run fails: the results say otherwise than the statement's declared standing.
    pub fn surprise(&self) -> Option<String> {
        match (&self.standing, &self.conclusion) {
            (DeclaredStanding::Reproduced, Conclusion::Reproduced)
            | (DeclaredStanding::Differs(_), Conclusion::NotReproduced)
            | (DeclaredStanding::NotComparable(_), _)
            | (_, Conclusion::Untested) => None,
            (DeclaredStanding::Reproduced, Conclusion::NotReproduced) => {
                Some("is not reproduced".to_string())
            }
            (DeclaredStanding::Reproduced, Conclusion::NotComparable(reason)) => {
                Some(format!("is not comparable: {reason}"))
            }
            (DeclaredStanding::Differs(reason), Conclusion::Reproduced) => Some(format!(
                "is reproduced, though declared to differ ({reason}): revise the reason or take it out"
            )),
            (DeclaredStanding::Differs(_), Conclusion::NotComparable(reason)) => {
                Some(format!("is not comparable, though declared to differ: {reason}"))
            }
        }
    }
    /// Whether it stands as declared; inconclusive where its claims hold of runs in which nothing was at stake.
    pub fn verdict(&self) -> Verdict {
        match (self.surprise(), &self.conclusion) {
            (Some(_), _) => Verdict::Failed,
            (None, Conclusion::Untested) => Verdict::Inconclusive,
            (None, _) => Verdict::Passed,
        }
    }

    /// Why it has not passed; `None` if it has.
    pub fn failure(&self) -> Option<String> {
        self.surprise().or_else(|| {
            let claim = self.claims.iter().find(|claim| claim.untested.is_some())?;
            let untested = self.conclusion == Conclusion::Untested;
            untested.then(|| {
                format!("`{}` is untested: nothing was at stake in the runs that it measures", claim.text)
            })
        })
    }
}
