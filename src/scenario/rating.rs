//! What `rating` blocks declare: what a table of weights makes of a value, and which scenarios earn how many points by that.

use serde::{Deserialize, Serialize};

use super::{MetricReference, Notation, Origin, Relation, VariationCondition};

/// Points that the cells of a suite would earn; a cell is a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rating {
    /// As the suite calls it.
    pub name: String,
    /// What the suite says of it, in a sentence.
    pub doc: Option<String>,
    /// What is measured in each run; a quantity.
    pub measure: MetricReference,
    /// The unit that its values are written in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub notation: Option<Notation>,
    /// What values are worth, by cells; of each cell of the rating one of them speaks.
    pub weights: Vec<Weights>,
    /// What the cells of a tag earn at most; no tag is there twice, and no scenario has two of them.
    pub points: Vec<TagPoints>,
    /// What belongs to the rule and is not tested, in words.
    pub not_assessed: Vec<String>,
    /// What the points must be; empty: the rating shows points and has no verdict.
    pub criteria: Vec<PointsCriterion>,
    /// Where it is declared.
    pub origin: Origin,
}

/// What values are worth in some cells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Weights {
    /// Of cells whose variations are so; empty: of all.
    pub when: Vec<VariationCondition>,
    /// A value falls to the first that it satisfies, and is worth nothing if there is none.
    pub lines: Vec<Weight>,
    /// In canonical words, such as `when speed = 30 km/h { 0 km/h: 1, below 10 km/h: 0.25 }`.
    pub text: String,
    /// Where it is written.
    pub origin: Origin,
}

/// What some values are worth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Weight {
    /// Which values.
    pub of: WeightedValues,
    /// 0 to 1.
    pub weight: f64,
}

/// Which values a weight is of, in the metric's SI unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WeightedValues {
    /// A run in which the metric does not exist.
    Undefined,
    /// Nothing else.
    Exactly(f64),
    /// Smaller ones.
    Below(f64),
    /// This and smaller ones.
    AtMost(f64),
    /// Larger ones.
    Above(f64),
    /// This and larger ones.
    AtLeast(f64),
}

/// What the cells of a tag earn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TagPoints {
    /// Of their scenarios.
    pub tag: String,
    /// With the best weight in every cell; above 0.
    pub maximum: f64,
    /// How weights become points.
    pub by: Scoring,
}

/// How the weights of cells become a share of the maximum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scoring {
    /// Their mean.
    MeanWeight,
    /// The share of cells whose weight is not 0.
    Share {
        /// Shares in ascending order: lowered to the last of them that it reaches, and to 0 below the first. Empty: it is not
        /// lowered.
        steps: Vec<f64>,
    },
}

/// What points must be.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointsCriterion {
    /// Those of one tag; `None`: all of them together.
    pub tag: Option<String>,
    /// How the two must compare.
    pub relation: Relation,
    /// Points.
    pub bound: f64,
    /// In canonical words: `points >= 3` or `points of cpna >= 0.5`.
    pub text: String,
    /// Where it is written.
    pub origin: Origin,
}

impl Rating {
    /// The points that the best weight in every cell would earn.
    pub fn maximum(&self) -> f64 {
        self.points.iter().map(|one| one.maximum).sum()
    }

    /// The points that a criterion can be about, at most.
    pub fn maximum_of(&self, tag: Option<&str>) -> f64 {
        self.points.iter().filter(|one| tag.is_none_or(|tag| one.tag == tag)).map(|one| one.maximum).sum()
    }
}

impl Weights {
    /// What a value is worth; `None`: the metric does not exist, and nothing is said of that.
    pub fn weight(&self, value: Option<f64>) -> Option<f64> {
        let line = self.lines.iter().find(|line| line.of.has(value));
        line.map(|line| line.weight).or(value.map(|_| 0.0))
    }
}

impl WeightedValues {
    /// Whether a value is one of them; `None` stands for the metric not existing.
    pub fn has(self, value: Option<f64>) -> bool {
        match (self, value) {
            (Self::Undefined, value) => value.is_none(),
            (_, None) => false,
            (Self::Exactly(bound), Some(value)) => value == bound,
            (Self::Below(bound), Some(value)) => value < bound,
            (Self::AtMost(bound), Some(value)) => value <= bound,
            (Self::Above(bound), Some(value)) => value > bound,
            (Self::AtLeast(bound), Some(value)) => value >= bound,
        }
    }

    /// The value that it names; none of a metric that does not exist.
    pub fn bound(self) -> Option<f64> {
        match self {
            Self::Undefined => None,
            Self::Exactly(bound)
            | Self::Below(bound)
            | Self::AtMost(bound)
            | Self::Above(bound)
            | Self::AtLeast(bound) => Some(bound),
        }
    }

    /// Whether all of `other`'s values are among its own.
    pub fn covers(self, other: Self) -> bool {
        match (self, other) {
            (Self::Undefined, Self::Undefined) => true,
            (Self::Undefined, _) | (_, Self::Undefined) => false,
            (own, Self::Exactly(value)) => own.has(Some(value)),
            (Self::Below(own), Self::Below(other))
            | (Self::AtMost(own), Self::Below(other) | Self::AtMost(other)) => other <= own,
            (Self::Below(own), Self::AtMost(other)) => other < own,
            (Self::Above(own), Self::Above(other))
            | (Self::AtLeast(own), Self::Above(other) | Self::AtLeast(other)) => other >= own,
            (Self::Above(own), Self::AtLeast(other)) => other > own,
            _ => false,
        }
    }
}

impl Scoring {
    /// The share (0..1) of the maximum that cells of these weights earn; there is at least one.
    pub fn share(&self, weights: &[f64]) -> f64 {
        let cells = weights.len() as f64;
        match self {
            Self::MeanWeight => weights.iter().sum::<f64>() / cells,
            Self::Share { steps } => {
                let good = weights.iter().filter(|weight| **weight > 0.0).count() as f64;
                if steps.is_empty() {
                    return good / cells;
                }
                // A step is reached by whole cells: `75 %` of four is three of them, however that is rounded.
                let reached = steps.iter().filter(|step| good + 1e-9 >= **step * cells);
                reached.fold(0.0, |last, step| f64::max(last, *step))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a car at 40 km/h, in km/h.
    fn weights() -> Weights {
        let of = [
            (WeightedValues::Exactly(0.0), 1.0),
            (WeightedValues::Below(10.0), 0.5),
            (WeightedValues::Below(20.0), 0.25),
        ];
        Weights {
            when: Vec::new(),
            lines: of.into_iter().map(|(of, weight)| Weight { of, weight }).collect(),
            text: String::new(),
            origin: Origin::default(),
        }
    }

    /// The edge of a band belongs to the worse one.
    #[test]
    fn a_value_falls_to_the_first_line_that_it_satisfies() {
        let worth = |value: f64| weights().weight(Some(value)).unwrap();
        let expected = [
            (0.0, 1.0),
            (f64::MIN_POSITIVE, 0.5),
            (9.999, 0.5),
            (10.0, 0.25),
            (19.99, 0.25),
            (20.0, 0.0),
            (60.0, 0.0),
        ];
        for (value, weight) in expected {
            assert_eq!(worth(value), weight, "{value}");
        }
        assert_eq!(weights().weight(None), None, "nothing is said of a metric that does not exist");
    }

    #[test]
    fn a_line_that_no_value_reaches_is_known() {
        use WeightedValues::{Above, AtLeast, AtMost, Below, Exactly, Undefined};
        for (first, then) in [
            (Below(20.0), Below(10.0)),
            (Below(20.0), Below(20.0)),
            (Below(20.0), AtMost(10.0)),
            (AtMost(20.0), Below(20.0)),
            (Below(20.0), Exactly(0.0)),
            (Above(1.0), AtLeast(2.0)),
            (AtLeast(1.0), Above(1.0)),
            (Undefined, Undefined),
        ] {
            assert!(first.covers(then), "{first:?} {then:?}");
        }
        for (first, then) in [
            (Below(10.0), Below(20.0)),
            (Below(20.0), AtMost(20.0)),
            (Below(20.0), Exactly(20.0)),
            (Above(1.0), AtLeast(1.0)),
            (Below(20.0), Above(1.0)),
            (Undefined, Exactly(0.0)),
            (AtMost(0.0), Undefined),
        ] {
            assert!(!first.covers(then), "{first:?} {then:?}");
        }
    }

    #[test]
    fn shares_are_lowered_to_the_last_step_that_they_reach() {
        let by = Scoring::Share { steps: vec![0.5, 0.75, 1.0] };
        let of = |good: usize, all: usize| {
            let weights: Vec<f64> = (0..all).map(|cell| if cell < good { 0.25 } else { 0.0 }).collect();
            (by.share(&weights), Scoring::Share { steps: Vec::new() }.share(&weights))
        };
        assert_eq!(of(0, 12), (0.0, 0.0));
        assert_eq!(of(5, 12).0, 0.0);
        assert_eq!(of(6, 12), (0.5, 0.5));
        assert_eq!(of(8, 12).0, 0.5);
        assert_eq!(of(9, 12), (0.75, 0.75));
        assert_eq!(of(11, 12).0, 0.75);
        assert_eq!(of(12, 12), (1.0, 1.0));
        // Three of thirty are a tenth, whichever way that is rounded.
        assert_eq!(
            Scoring::Share { steps: vec![0.1] }.share(&[[1.0; 3].as_slice(), &[0.0; 27]].concat()),
            0.1
        );
        assert_eq!(Scoring::MeanWeight.share(&[1.0, 0.5, 0.0]), 0.5);
    }
}
