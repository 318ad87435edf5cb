//! A `calibrate` on the page: people beside candidates, the population and others, as a figure and in a table.

use serde::Serialize;

use super::figure::HtmlFigure;
use crate::calibration::{
    counted_sentence, draw_calibration, headings, parameter_headings, parameter_rows, rows,
};
use results::CalibrateResult;

#[derive(Debug, Serialize)]
pub struct CalibrateSection {
    sentences: Vec<String>,
    warnings: Vec<String>,
    tables: Vec<Table>,
    figures: Vec<HtmlFigure>,
}

#[derive(Debug, Serialize)]
struct Table {
    headings: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl CalibrateSection {
    pub fn new(result: &CalibrateResult) -> Self {
        let table =
            |what: &str, shares: bool| Table { headings: headings(result, what), rows: rows(result, shares) };
        let note = "Each point is a condition: the share of trials of people, and of runs of populations.";
        let mut tables = vec![table("share", true), table("spread between individuals", false)];
        tables.retain(|table| !table.rows.is_empty());
        if !result.matched_parameters.is_empty() {
            tables.push(Table { headings: parameter_headings(result), rows: parameter_rows(result) });
        }
        Self {
            sentences: sentences(result),
            warnings: result.warnings.clone(),
            tables,
            figures: vec![HtmlFigure::new(result.matched.clone(), note, vec![draw_calibration(result)])],
        }
    }

    /// What it came to, in a line.
    pub fn summary(result: &CalibrateResult) -> String {
        format!(
            "{} to {}: effective size {:.0} of {}, shares at most {:.1} points from people under fresh noise, digest {}",
            result.matched,
            result.observations,
            result.effective_size,
            result.weights.len(),
            100.0 * result.worst_fresh(),
            result.digest
        )
    }
}

fn sentences(result: &CalibrateResult) -> Vec<String> {
    let mut sentences = vec![
        format!("{}.", CalibrateSection::summary(result)),
        format!("Candidates: {}; {} runs of each in every condition.", result.candidates, result.runs),
    ];
    let mut errors = vec![format!("{:.1} points under fresh noise", 100.0 * result.fresh_rms)];
    errors.extend(result.left_out_rms.map(|rms| format!("{:.1} of conditions left out", 100.0 * rms)));
    errors.extend(result.folds_rms.map(|rms| format!("{:.1} in {} folds", 100.0 * rms, result.folds)));
    sentences.push(format!("Root mean square error: {}.", errors.join(", ")));
    sentences.extend(counted_sentence(result));
    for one in &result.compared {
        sentences.push(format!(
            "{}: {} individuals, {} runs of each, digest {}.",
            one.name, one.individuals, one.runs, one.digest
        ));
    }
    sentences
}
