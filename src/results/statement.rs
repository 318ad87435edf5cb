//! What a statement came to.

use serde::{Deserialize, Serialize};

use scenario::{DeclaredStanding, Relation, TrendDirection};

/// What a statement came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StatementResult {
    pub name: String,
    /// What the source says.
    pub doc: Option<String>,
    pub source: Option<String>,
    /// The numbers that the source gives, in words.
    pub reported: Option<String>,
    pub conclusion: Conclusion,
    pub claims: Vec<ClaimResult>,
    /// What the suite declares to be known of it.
    pub standing: DeclaredStanding,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Conclusion {
    /// Every claim holds.
    Reproduced,
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
    pub values: ClaimValues,
    /// SI unit of the values; `%` says that they are shares in 0..1.
    pub unit: String,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClaimValues {
    Compared { left: Option<f64>, relation: Relation, right: Option<f64> },
    Trend { direction: TrendDirection, variable: String, points: Vec<TrendPoint> },
}

/// The aggregate at one value of the variation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrendPoint {
    pub label: String,
    pub at: f64,
    /// `None` where no run gives one.
    pub value: Option<f64>,
    pub runs: usize,
}

impl StatementResult {
    /// Why the run fails: the results say otherwise than the statement's declared standing.
    pub fn surprise(&self) -> Option<String> {
        match (&self.standing, &self.conclusion) {
            (DeclaredStanding::Reproduced, Conclusion::Reproduced)
            | (DeclaredStanding::Differs(_), Conclusion::NotReproduced)
            | (DeclaredStanding::NotComparable(_), _) => None,
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
}
