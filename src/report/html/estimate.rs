//! An `estimate` on the page: the two numbers, what speaks against them, and the runs that carry them.

use serde::Serialize;

use super::figure::HtmlFigure;
use crate::estimation::{alone, draw_estimate, number, percent, ratio, sentences, values};
use crate::wording::verdict_word;
use results::{EstimateResult, EstimatedRun, SuiteReport};

#[derive(Debug, Serialize)]
pub struct EstimateSection {
    sentences: Vec<String>,
    warnings: Vec<String>,
    claims: Vec<[String; 3]>,
    clusters: Vec<RunRow>,
    carrying: Vec<RunRow>,
    /// Of encounters in which one of two alone has the event.
    alone: Vec<AloneTable>,
    figures: Vec<HtmlFigure>,
}

#[derive(Debug, Serialize)]
struct AloneTable {
    title: String,
    runs: Vec<RunRow>,
}

#[derive(Debug, Serialize)]
struct RunRow {
    share: String,
    values: String,
    replay: String,
}

impl EstimateSection {
    pub fn new(report: &SuiteReport, result: &EstimateResult) -> Self {
        let row = |share: f64, run: &EstimatedRun| RunRow {
            share: percent(share),
            values: values(run),
            replay: report.identity.replay_command(&run.key),
        };
        let claims = result
            .claims
            .iter()
            .map(|one| [one.text.clone(), verdict_word(one.verdict).to_string(), one.reason.clone()]);
        let alone = result.compared.iter().flat_map(|compared| alone(result, compared));
        let alone = alone.map(|(title, runs)| AloneTable {
            title,
            runs: runs.iter().map(|run| row(run.share, run)).collect(),
        });
        let note =
            "Above: probabilities on a logarithmic scale. Below: what single runs weigh in the estimate.";
        Self {
            sentences: sentences(result).iter().map(|one| one.trim_start().to_string()).collect(),
            warnings: result.warnings.clone(),
            claims: claims.collect(),
            clusters: result.clusters.iter().map(|one| row(one.share, &one.run)).collect(),
            carrying: result.carrying.iter().map(|run| row(run.share, run)).collect(),
            alone: alone.collect(),
            figures: vec![HtmlFigure::new(result.event.clone(), note, vec![draw_estimate(result)])],
        }
    }

    /// What it came to, in a line.
    pub fn summary(result: &EstimateResult) -> String {
        let level = percent(result.confidence);
        let estimate = match result.refusals.first() {
            Some(why) => format!("the estimate is refused: {why}"),
            None => format!(
                "estimate {} [{}, {}]",
                number(result.value),
                number(result.interval.low),
                number(result.interval.high)
            ),
        };
        let along = result.per_1000_km.as_ref().map_or_else(String::new, |along| {
            format!("; per 1,000 km guaranteed at most {}", number(along.guaranteed))
        });
        let compared = result.compared.as_ref().map_or_else(String::new, |compared| {
            format!("; ratio to `{}`: {}", compared.scenario, ratio(compared))
        });
        format!(
            "{}: guaranteed at most {} at {level}; {estimate}{along}{compared}",
            result.event,
            number(result.guaranteed)
        )
    }
}
