//! A suite's gates on the page: the verdict, what did not hold, and what held folded away.

use serde::Serialize;

use super::figure::HtmlFigure;
use crate::chart::{Forest, ForestRow, LegendEntry, Look};
use crate::gate::{
    HEADINGS, MOST_RUNS_NAMED, cells, changed, check_mark, context, outcome_word, relative,
    render_gate_report, sentence,
};
use results::{
    Check, CheckOutcome, ComparedSubject, GateReport, GateState, GateVerdict, NotJudged, SuiteIdentity,
    SuiteReport, Verdict,
};

/// More differences of one unit than this are not drawn.
const MOST_DRAWN: usize = 24;

#[derive(Debug, Serialize)]
pub struct GateSection {
    name: String,
    doc: String,
    baseline: String,
    rules: Vec<String>,
    /// The class of its colour.
    state: &'static str,
    mark: &'static str,
    word: &'static str,
    /// What it came to, in a line.
    summary: String,
    /// Why it is not judged.
    failure: Option<String>,
    context: Vec<String>,
    headings: [&'static str; HEADINGS.len()],
    regressions: Vec<Regression>,
    /// What changed, with intervals and tolerances.
    figure: Option<HtmlFigure>,
    /// Comparisons that did not hold.
    open: Vec<Row>,
    held: Vec<Row>,
}

/// A comparison.
#[derive(Debug, Serialize)]
struct Row {
    place: String,
    state: &'static str,
    mark: &'static str,
    cells: [String; HEADINGS.len()],
}

#[derive(Debug, Serialize)]
struct Regression {
    sentence: String,
    /// How many runs got worse and better.
    counts: String,
    runs: Vec<String>,
    command: Option<String>,
}

impl GateSection {
    pub fn all(report: &SuiteReport) -> Vec<Self> {
        report.gates.iter().map(|gate| Self::new(&report.identity, gate)).collect()
    }

    fn new(suite: &SuiteIdentity, report: &GateReport) -> Self {
        let (state, mark, word) = match &report.state {
            GateState::NotJudged(NotJudged::NotSelected) => ("skipped", "–", "not judged"),
            GateState::NotJudged(_) => ("inconclusive", "?", "not judged"),
            GateState::Refused(_) => ("error", "!", "cannot be judged"),
            GateState::Judged(verdict) => match verdict.verdict {
                Verdict::Passed => ("passed", "✓", outcome_word(verdict.verdict)),
                Verdict::Inconclusive => ("inconclusive", "?", outcome_word(verdict.verdict)),
                Verdict::Failed => ("failed", "✗", outcome_word(verdict.verdict)),
            },
        };
        let mut section = Self {
            name: report.gate.name.clone(),
            doc: report.gate.doc.clone().unwrap_or_default(),
            baseline: report.gate.baseline.clone(),
            rules: report.gate.rules.iter().map(|rule| rule.text.clone()).collect(),
            state,
            mark,
            word,
            summary: String::new(),
            failure: None,
            context: Vec::new(),
            headings: HEADINGS,
            regressions: Vec::new(),
            figure: None,
            open: Vec::new(),
            held: Vec::new(),
        };
        match &report.state {
            GateState::NotJudged(why) => section.summary = why.to_string(),
            GateState::Refused(refusal) => {
                section.summary = refusal.message.clone();
                section.failure = Some(render_gate_report(suite, report, false));
            }
            GateState::Judged(verdict) => section.fill(suite, verdict),
        }
        section
    }

    fn fill(&mut self, suite: &SuiteIdentity, verdict: &GateVerdict) {
        let mut context = context(verdict);
        self.summary = context.remove(0);
        self.context = context;
        self.figure = forest(suite, &verdict.checks);
        for check in &verdict.checks {
            if check.outcome == CheckOutcome::Regressed {
                self.regressions.push(Regression::new(suite, check));
            }
            let rows = if check.outcome.is_fine() { &mut self.held } else { &mut self.open };
            rows.push(Row::new(check));
        }
    }
}

/// The differences of comparisons, those of means and those of shares; none if nothing changed.
fn forest(suite: &SuiteIdentity, checks: &[Check]) -> Option<HtmlFigure> {
    // What is new is no difference: a single run of it decides.
    let changed = checks
        .iter()
        .filter(|check| check.outcome != CheckOutcome::Same && check.subject != ComparedSubject::New);
    let (drawn, of_zero): (Vec<&Check>, Vec<&Check>) =
        changed.partition(|check| relative(check, check.tolerance).is_some());
    let (means, shares): (Vec<&Check>, Vec<&Check>) =
        drawn.into_iter().partition(|check| check.subject == ComparedSubject::Mean);
    let (mut panels, mut looks, mut left_out) = (Vec::new(), Vec::new(), of_zero.len());
    for (title, axis, mut checks) in
        [("means", "change (% of the base)", means), ("shares of runs", "change (percentage points)", shares)]
    {
        checks.sort_by_key(|check| outcome_look(check.outcome).0);
        left_out += checks.len().saturating_sub(MOST_DRAWN);
        checks.truncate(MOST_DRAWN);
        looks.extend(checks.iter().map(|check| outcome_look(check.outcome)));
        let rows: Vec<ForestRow> = checks.into_iter().filter_map(|check| forest_row(suite, check)).collect();
        if !rows.is_empty() {
            panels.push(Forest { title: title.into(), axis: axis.into(), rows }.to_svg());
        }
    }
    if panels.is_empty() {
        return None;
    }
    looks.sort_unstable();
    looks.dedup();
    let legend = looks.into_iter().map(|(look, label)| LegendEntry {
        swatch: Look::series(look).swatch(false, true),
        label: label.into(),
    });
    let mut note = "Candidate minus base, with the interval of the table; a line without a cap goes on. The dashed line is what is \
                    tolerated: what lies beyond it, seen from zero, is worse. What is the same is not drawn."
        .to_string();
    if left_out > 0 {
        note += &format!(" {left_out} more are in the tables only.");
    }
    Some(HtmlFigure::new("What changed", note, panels).with_legend(legend.collect()))
}

/// The look and its words, what matters most first.
fn outcome_look(outcome: CheckOutcome) -> (usize, &'static str) {
    match outcome {
        CheckOutcome::Regressed => (1, "✗ regressed"),
        CheckOutcome::NotShown => (2, "? not shown either way"),
        CheckOutcome::Held | CheckOutcome::Same => (3, "✓ held"),
    }
}

fn forest_row(suite: &SuiteIdentity, check: &Check) -> Option<ForestRow> {
    let [label, base, candidate, change, tolerated, _] = cells(check);
    let name = format!("{} {label}, {}", check_mark(check.outcome), check.place);
    let mut title = format!("{name}: {base} -> {candidate}, {change}, tolerated {tolerated}");
    if let Some(worst) = check.worse_runs.first() {
        title += &format!("; {}", suite.replay_command(&worst.key));
    }
    let scaled = |value: f64| relative(check, value);
    let interval = match check.interval {
        Some((low, high)) => Some((scaled(low)?, scaled(high)?)),
        None => None,
    };
    Some(ForestRow {
        name,
        difference: scaled(check.candidate - check.base)?,
        interval,
        tolerated: scaled(if check.larger_is_worse { check.tolerance } else { -check.tolerance })?,
        look: Look::series(outcome_look(check.outcome).0),
        title,
    })
}

impl Row {
    fn new(check: &Check) -> Self {
        let state = match check.outcome {
            CheckOutcome::Same | CheckOutcome::Held => "passed",
            CheckOutcome::NotShown => "",
            CheckOutcome::Regressed => "failed",
        };
        Self { place: check.place.clone(), state, mark: check_mark(check.outcome), cells: cells(check) }
    }
}

impl Regression {
    fn new(suite: &SuiteIdentity, check: &Check) -> Self {
        let (worse, better) = (&check.worse_runs, &check.better_runs);
        Self {
            sentence: sentence(check),
            counts: format!(
                "{} of {} runs got worse, {} better; the worst:",
                worse.len(),
                check.runs,
                better.len()
            ),
            runs: worse.iter().take(MOST_RUNS_NAMED).map(|run| changed(check, run)).collect(),
            command: worse.first().map(|run| suite.replay_command(&run.key)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Session;

    #[test]
    fn what_is_drawn_is_what_the_table_says() {
        let report = Session::new().report();
        let judged = |gate: &GateReport| match &gate.state {
            GateState::Judged(verdict) => Some((**verdict).clone()),
            _ => None,
        };
        let verdicts: Vec<GateVerdict> = report.gates.iter().filter_map(judged).collect();
        let of = |outcome| verdicts.iter().flat_map(|one| &one.checks).find(|check| check.outcome == outcome);
        let regressed = of(CheckOutcome::Regressed).expect("one regressed");
        let row = forest_row(&report.identity, regressed).expect("its base is not 0");
        let expected = 100.0 * (regressed.candidate - regressed.base) / regressed.base.abs();
        assert_eq!(row.difference, expected);
        // Less is worse, so that it is worse below the tolerance.
        assert!(!regressed.larger_is_worse && row.tolerated < 0.0 && row.difference < row.tolerated);
        let shown = cells(regressed);
        assert!(row.title.contains(&shown[3]) && row.title.contains("replay"), "{}", row.title);
        let (low, high) = row.interval.expect("there is chance in it");
        assert!(low <= row.difference && row.difference <= high);
        // Nothing is drawn of what is the same, and a mean of 0 has no per cent.
        let same: Vec<Check> = verdicts.iter().flat_map(|one| one.checks.clone()).collect();
        let same: Vec<Check> = same.into_iter().filter(|check| check.outcome == CheckOutcome::Same).collect();
        assert!(forest(&report.identity, &same).is_none());
        let of_zero = Check { base: 0.0, ..regressed.clone() };
        assert!(forest(&report.identity, std::slice::from_ref(&of_zero)).is_none());
        let figure = forest(&report.identity, &[regressed.clone(), of_zero]).expect("one is drawn");
        assert!(figure.note.contains("1 more are in the tables only"), "{}", figure.note);
        assert_eq!((figure.panels.len(), figure.legend.len()), (1, 1));
    }
}
