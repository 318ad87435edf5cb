//! A suite's gates on the page: the verdict, what did not hold, and what held folded away.

use serde::Serialize;

use crate::gate::{
    HEADINGS, MOST_RUNS_NAMED, cells, changed, check_mark, context, outcome_word, render_gate_report,
    sentence,
};
use results::{
    Check, CheckOutcome, GateReport, GateState, GateVerdict, NotJudged, SuiteIdentity, SuiteReport, Verdict,
};

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
        for check in &verdict.checks {
            if check.outcome == CheckOutcome::Regressed {
                self.regressions.push(Regression::new(suite, check));
            }
            let rows = if check.outcome.is_fine() { &mut self.held } else { &mut self.open };
            rows.push(Row::new(check));
        }
    }
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
