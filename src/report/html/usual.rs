//! How bad the encounters of a search are against how usual they are, on the page: a chart, and a line for each on the front.

use serde::Serialize;

use super::figure::HtmlFigure;
use super::space::{MeasuredQuantity, SpaceDimension};
use super::told::quoted;
use crate::chart::{Danger, OnFront, PointMark};
use crate::usual::{basis, one_in, parts, tail_text, who};
use results::{SearchResult, SuiteReport, UsualEncounters};
use scenario::{Keep, Relation, Search};

#[derive(Debug, Serialize)]
pub struct UsualSection {
    sentences: Vec<String>,
    figures: Vec<HtmlFigure>,
    /// Whether encounters have several parts that are drawn.
    parts: bool,
    rows: Vec<UsualRow>,
}

/// An encounter on the front.
#[derive(Debug, Serialize)]
struct UsualRow {
    id: String,
    one_in: String,
    plausibility: String,
    observed: String,
    fresh: String,
    who: String,
    place: Vec<String>,
    parts: String,
    replay: String,
}

impl UsualSection {
    /// `None` where nothing says how encounters are drawn.
    pub fn new(report: &SuiteReport, search: &Search, result: &SearchResult) -> Option<Self> {
        let usual = result.usual.as_ref()?;
        let objective = MeasuredQuantity::objective(&search.objective);
        let dimensions = SpaceDimension::all(&search.over);
        let id = |index: usize| format!("front-{}-{}-{}", report.identity.suite, search.name, index + 1);
        let row = |(index, one): (usize, &results::FrontPoint)| {
            let found = &result.found[one.found];
            let point = &found.evaluations[one.evaluation].0;
            UsualRow {
                id: id(index),
                one_in: one_in(one.plausibility),
                plausibility: tail_text(one.plausibility),
                observed: objective.number(Some(one.value)),
                fresh: match one.fresh {
                    Some(fresh) => format!("{} ({})", objective.rough(fresh, 3), one.fresh_runs),
                    None => "–".into(),
                },
                who: who(found),
                place: point.iter().zip(&dimensions).map(|(value, one)| one.number(value)).collect(),
                parts: parts(one),
                replay: report.identity.replay_command(&one.key),
            }
        };
        let rows: Vec<UsualRow> = usual.front.iter().enumerate().map(row).collect();
        let targets: Vec<String> = rows.iter().map(|row| format!("#{}", row.id)).collect();
        let chart = chart(search, result, usual, &objective, &targets);
        let note = "How bad every evaluated encounter was against how rare it is: further right is rarer. Where several runs are one \
                    evaluation, what they share counts. Values are as observed, and the worst of many are partly luck: fresh runs in the \
                    same encounter stand beside them.";
        let figure = HtmlFigure::new("Danger against plausibility", note, vec![chart.to_svg()]);
        Some(Self {
            sentences: basis(usual).iter().map(|sentence| quoted(sentence)).collect(),
            figures: vec![figure.with_legend(chart.legend())],
            parts: usual.of.len() > 1,
            rows,
        })
    }
}

fn chart(
    search: &Search,
    result: &SearchResult,
    usual: &UsualEncounters,
    objective: &MeasuredQuantity,
    targets: &[String],
) -> Danger {
    let initial = search.budget.initial as usize;
    let mut tried = Vec::new();
    for (index, found) in result.found.iter().enumerate() {
        let each = found.evaluations.iter().zip(&found.plausibilities).enumerate();
        for (evaluation, ((_, value), plausibility)) in each {
            let (Some(value), Some(share)) = (value, plausibility.filter(|share| *share > 0.0)) else {
                continue;
            };
            if usual.front.iter().any(|one| one.found == index && one.evaluation == evaluation) {
                continue;
            }
            let mark = if evaluation < initial { PointMark::Initial } else { PointMark::Proposed };
            tried.push((1.0 / share, objective.charted(*value), mark));
        }
    }
    let front = usual.front.iter().zip(targets).map(|(one, target)| OnFront {
        one_in: 1.0 / one.plausibility,
        value: objective.charted(one.value),
        title: format!("{}: {}", one_in(one.plausibility), objective.text(Some(one.value))),
        target: target.clone(),
    });
    let rarest = search.keep.iter().find_map(|keep| match keep {
        Keep::Plausibility { relation: Relation::Greater | Relation::GreaterOrEqual, bound }
            if *bound > 0.0 =>
        {
            Some(1.0 / bound)
        }
        _ => None,
    });
    Danger {
        title: search.name.clone(),
        y: objective.quantity(),
        goal: search.objective.direction,
        tried,
        front: front.collect(),
        rules: objective.kept(search),
        rarest,
    }
}
