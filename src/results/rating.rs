//! What became of a rating: what each cell is worth, and the points that the cells would earn.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::standing::Standing;
use crate::Verdict;
use scenario::{Assignment, Rating};

/// What became of a rating.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RatingReport {
    /// What the suite declares.
    pub rating: Arc<Rating>,
    /// Such as `euro_ncap_vru/rating=euro_ncap_2026`.
    pub key: String,
    /// What it came to.
    pub state: RatingState,
}

/// Whether the cells of a rating are all there, or why not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RatingState {
    /// Every cell was to be run.
    Rated(Box<RatingResult>),
    /// They are not those of the rule.
    NotJudged(NotRated),
}

/// Why there are no points at all.
#[derive(Debug, Clone, PartialEq, Eq, Error, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NotRated {
    /// Nothing of its suite was to be run.
    #[error("nothing of its suite was selected")]
    NotSelected,
    /// A filter, a share of several machines, or an early end left some out.
    #[error("{left_out} of {cells} cells were not run, and the points of some cells are not those of all")]
    Part {
        /// Cells that were not run.
        left_out: usize,
        /// Cells that the rating has.
        cells: usize,
    },
    /// Values that were set from outside make other runs than those that are rated.
    #[error("with {} these are not the cells that it is about", .0.join(", "))]
    OtherCells(Vec<String>),
}

/// What the cells of a rating came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RatingResult {
    /// In the order of the suite's trials.
    pub cells: Vec<RatedCell>,
    /// One per tag, in the order in which the rating says them.
    pub tags: Vec<EarnedPoints>,
    /// The points of all tags; `None`: those of a tag are undefined.
    pub points: Option<f64>,
    /// What the best weight in every cell would earn.
    pub maximum: f64,
    /// One per criterion, in their order.
    pub findings: Vec<PointsFinding>,
}

/// A cell: a trial with what it is worth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RatedCell {
    /// The trial's key.
    pub key: String,
    /// The trial's scenario.
    pub scenario: String,
    /// The tag by which it earns points.
    pub tag: String,
    /// Whether its scenario has the tag `unverified`: numbers that were not read in the rule itself.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub unverified: bool,
    /// The values of its variations.
    pub variation: Vec<Assignment>,
    /// What it is worth, or why that is not known.
    pub worth: CellWorth,
}

/// What a cell is worth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CellWorth {
    /// Its worst run: that of the smallest weight.
    Weighed {
        /// 0 to 1.
        weight: f64,
        /// SI units; `None` where the metric does not exist in that run and the rating says what that is worth.
        value: Option<f64>,
        /// That there was no contact, or whatever else the metric is about, so that the value is taken as 0.
        absent: bool,
        /// The run's key.
        run: String,
        /// Of so many.
        runs: usize,
    },
    /// Why nothing is known of it.
    NotAssessed(String),
}

/// The points of a tag.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EarnedPoints {
    /// As scenarios say it.
    pub tag: String,
    /// `None`: undefined, for a cell of it was not assessed.
    pub points: Option<f64>,
    /// What the best weight in every cell would earn.
    pub maximum: f64,
    /// Cells that have the tag; at least 1.
    pub cells: usize,
    /// Those of them that were not assessed.
    pub not_assessed: usize,
}

/// What became of a criterion about points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointsFinding {
    /// In canonical words: `points >= 3`.
    pub criterion: String,
    /// Inconclusive where the points are undefined.
    pub verdict: Verdict,
    /// The points that it is about; `None`: undefined.
    pub points: Option<f64>,
}

impl CellWorth {
    /// 0 to 1; `None`: not assessed.
    pub fn weight(&self) -> Option<f64> {
        match self {
            Self::Weighed { weight, .. } => Some(*weight),
            Self::NotAssessed(_) => None,
        }
    }
}

impl RatingResult {
    /// The worst of what was found; `None`: the rating expects nothing.
    pub fn verdict(&self) -> Option<Verdict> {
        self.findings.iter().map(|finding| finding.verdict).max()
    }

    /// Cells of which nothing is known, each with the reason.
    pub fn not_assessed(&self) -> impl Iterator<Item = (&RatedCell, &str)> {
        self.cells.iter().filter_map(|cell| match &cell.worth {
            CellWorth::NotAssessed(why) => Some((cell, why.as_str())),
            CellWorth::Weighed { .. } => None,
        })
    }

    /// Scenarios with numbers that were not read in the rule itself, each once.
    pub fn unverified(&self) -> Vec<&str> {
        let mut names: Vec<&str> =
            self.cells.iter().filter(|cell| cell.unverified).map(|cell| cell.scenario.as_str()).collect();
        names.dedup();
        names
    }
}

impl RatingReport {
    /// Such as `euro_ncap_vru/rating=euro_ncap_2026`.
    pub fn key_of(suite: &str, rating: &Rating) -> String {
        format!("{suite}/rating={}", rating.name)
    }

    /// What it came to; `None` where it is not judged or expects nothing.
    pub fn verdict(&self) -> Option<Verdict> {
        match &self.state {
            RatingState::Rated(result) => result.verdict(),
            RatingState::NotJudged(_) => None,
        }
    }

    /// Whether it expects something that was not judged though something of its suite was run: it may be that it would have
    /// failed.
    pub fn is_open(&self) -> bool {
        let why = match &self.state {
            RatingState::Rated(_) => return false,
            RatingState::NotJudged(why) => why,
        };
        !self.rating.criteria.is_empty() && *why != NotRated::NotSelected
    }

    /// How it stands, for counts and exit codes.
    pub fn standing(&self) -> Standing {
        match (&self.state, self.verdict()) {
            (RatingState::NotJudged(_), _) => Standing::Skipped,
            (RatingState::Rated(_), Some(verdict)) => Standing::Judged(verdict),
            (RatingState::Rated(_), None) => Standing::NotJudged,
        }
    }
}
