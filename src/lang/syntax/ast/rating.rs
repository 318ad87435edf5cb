//! Ratings: what values are worth, and which tags earn how many points by that.

use super::super::entry::{BlockEntry, BlockKind, StatementEntry, YamlShape, statement};
use super::{DOC, Doc, Expression, Metric, Name, Relation, Tag, Text, When};
#[cfg(test)]
use super::{Holds, Made};
use super::{Node, Rule, View};

views! {
    /// `rating NAME { … }`
    Rating = rating { name: Name, block: RatingBlock }
    RatingBlock = rating_block {
        doc: (Doc),
        measure: (RatedMetric),
        weights: [Weights],
        points: [Points],
        not_assessed: [NotAssessed],
        expects: [ExpectPoints],
    }
    /// `measure impact_speed`
    RatedMetric = rated_metric { metric: Metric }
    /// `weights when speed = 30 km/h { 0 km/h: 1, below 10 km/h: 0.25 }`
    Weights = weights { when: (When), block: WeightsBlock }
    WeightsBlock = weights_block { lines: [Weight] }
    /// `below 10 km/h: 0.25`
    Weight = weight { is_undefined: {kw_undefined}, bound: (WeightBound), values: [Expression] }
    /// `below`, `at most`, `above` or `at least`
    WeightBound = weight_bound { is_below: {kw_below}, is_above: {kw_above}, is_at_most: {kw_most}, is_at_least: {kw_least} }
    /// `points cpna 1, cpfa 1`
    Points = points { each: [PointsOfTag], by_share: (ByShare) }
    PointsOfTag = points_of_tag { tag: Tag, points: Expression }
    /// `by share in steps 50 %, 75 %, 100 %`
    ByShare = by_share { steps: [Expression] }
    /// `not assessed "why"`
    NotAssessed = not_assessed { what: Text }
    /// `expect { points >= 3 }`
    ExpectPoints = expect_points { block: ExpectPointsBlock }
    ExpectPointsBlock = expect_points_block { criteria: [PointsCriterion] }
    /// `points of cpna >= 0.5`
    PointsCriterion = points_criterion { tag: (Tag), relation: Relation, bound: Expression }
}

pub(super) const RATING: StatementEntry = statement(
    "rating",
    Rule::rating,
    "rating NAME { … }",
    "Points that the cells of the suite would earn, by what was measured in them.",
)
.key("ratings", YamlShape::Named)
.opens(BlockKind::Rating);

pub static RATING_BLOCK: BlockEntry = BlockEntry {
    kind: BlockKind::Rating,
    rule: Rule::rating_block,
    name: "a `rating`",
    heads: &[DOC],
    statements: &[
        statement(
            "measure",
            Rule::rated_metric,
            "measure impact_speed(component: along)",
            "What the weights are of: a quantity, in every run of a cell.",
        )
        .key("measure", YamlShape::Words)
        .needed("measure", "measure impact_speed"),
        statement(
            "weights",
            Rule::weights,
            "weights when speed = 30 km/h { 0 km/h: 1, below 10 km/h: 0.25 }`, `weights { at least 1.7 s: 1 }` or `weights { undefined: 1, above 2 s: 0.5 }",
            "What values are worth, in the cells that `when` is about; the first line that fits counts, and what fits none is worth 0.",
        )
        .key("weights", YamlShape::Weights)
        .needed("weights", "weights { 0 km/h: 1, below 10 km/h: 0.25 }")
        .repeats(),
        statement(
            "points",
            Rule::points,
            "points cpna 1, cpfa 1` or `points cpna_extended 0.125 by share in steps 50 %, 75 %, 100 %",
            "What the cells of scenarios with a tag earn at most: by their mean weight, or by the share of them that is worth anything.",
        )
        .key("points", YamlShape::Words)
        .needed("points", "points TAG 1")
        .repeats(),
        statement(
            "not assessed",
            Rule::not_assessed,
            "not assessed \"night cells: there is no light model\"",
            "What belongs to the rule and is not tested, with the reason; shown in every report.",
        )
        .key("not_assessed", YamlShape::Text)
        .repeats(),
        statement(
            "expect",
            Rule::expect_points,
            "expect { points >= 3 }",
            "What the points must be; without it a rating has no verdict.",
        )
        .key("expect", YamlShape::Statements)
        .opens(BlockKind::ExpectPoints)
        .repeats(),
    ],
};

pub static EXPECT_POINTS: BlockEntry = BlockEntry {
    kind: BlockKind::ExpectPoints,
    rule: Rule::expect_points_block,
    name: "`expect` of a `rating`",
    heads: &[],
    statements: &[statement(
        "",
        Rule::points_criterion,
        "points >= 3` or `points of cpna >= 0.5",
        "A bound on all points, or on those of a tag.",
    )
    .repeats()],
};
