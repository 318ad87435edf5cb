//! Criteria: metrics, what sums them up, and what they are compared to.

use super::super::entry::{BlockEntry, BlockKind, StatementEntry, YamlShape, statement};
use super::{Expression, Name, Settings};
#[cfg(test)]
use super::{Holds, Made};
use super::{Node, Rule, View};

views! {
    /// `expect { … }`
    Expect = expect { block: ExpectBlock }
    ExpectBlock = expect_block { criteria: [Criterion] }
    Criterion = criterion {
        aggregate_claim: (AggregateClaim),
        condition: (Condition),
        share: (Share),
        undefined: (Undefined),
        confidence: (Confidence),
        whom: (Whom),
        whens: [When],
    }
    /// `mean(time_lost) <= 3 s`
    AggregateClaim = aggregate_claim { aggregate: Aggregate, relation: Relation, bound: Expression }
    /// `rate(…)` or `count(…)`
    Rate = rate { condition: Condition, undefined: (Undefined) }
    /// `quantile(95 %, pet)`
    Quantile = quantile { level: Expression, metric: Metric }
    /// `mean(pet)`
    Statistic = statistic { name: StatisticName, metric: Metric }
    StatisticName = statistic_name {}
    /// `no collision`, `gap_accepted` or `pet >= 1.5 s`
    Condition = condition {
        is_negative: {kw_no},
        metric: Metric,
        relation: (Relation),
        bound: (Expression),
    }
    /// `pet(av, walker)`
    Metric = metric { name: Name, details: (Settings) }
    Relation = relation {}
    /// `in 80 % of runs`
    Share = share { value: Expression }
    /// `undefined passes`
    Undefined = undefined { passes: {kw_passes} }
    /// `with 95 % confidence`
    Confidence = confidence { value: Expression }
    /// `of all people`
    Whom = whom { are_all: {kw_all} }
    /// `when tta = 6 s and age = old`
    When = when | run_conditions { conditions: [WhenCondition] }
    WhenCondition = when_condition | run_condition { name: Name, relation: Relation, bound: Expression }
}

choices! {
    /// What sums up the runs of a trial.
    Aggregate = Rate | Quantile | Statistic;
}

impl<'t> Aggregate<'t> {
    /// What it sums up, unless that is a condition.
    pub fn metric(self) -> Option<Metric<'t>> {
        match self {
            Self::Rate(_) => None,
            Self::Quantile(of) => Some(of.metric()),
            Self::Statistic(of) => Some(of.metric()),
        }
    }

    /// What it is called.
    pub fn word(self) -> &'t str {
        self.text().split('(').next().unwrap_or_default().trim()
    }
}

impl Relation<'_> {
    pub fn meaning(self) -> scenario::Relation {
        match self.text() {
            "<" => scenario::Relation::Less,
            "<=" | "≤" => scenario::Relation::LessOrEqual,
            ">" => scenario::Relation::Greater,
            ">=" | "≥" => scenario::Relation::GreaterOrEqual,
            "!=" | "≠" => scenario::Relation::NotEqual,
            _ => scenario::Relation::Equal,
        }
    }
}

pub(super) const EXPECT: StatementEntry =
    statement("expect", Rule::expect, "expect { no collision }", "Criteria that runs must meet.")
        .key("expect", YamlShape::Statements)
        .opens(BlockKind::Expect);

pub static EXPECT_BLOCK: BlockEntry = BlockEntry {
    kind: BlockKind::Expect,
    rule: Rule::expect_block,
    name: "`expect`",
    heads: &[],
    statements: &[statement(
        "",
        Rule::criterion,
        "no collision`, `pet >= 1.5 s in 80 % of runs` or `mean(time_lost) <= 3 s",
        "A criterion.",
    )
    .repeats()],
};
