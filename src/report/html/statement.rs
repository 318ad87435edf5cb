//! The statements of a source on the page: a line each, with both sides' numbers and whether it came out as declared.

use serde::Serialize;

use crate::statement::{claim_mark, claim_values, conclusion_words};
use results::{BlockReport, BlockResult, BlockState, Conclusion, StatementResult, SuiteReport};
use scenario::{Block, DeclaredStanding};

#[derive(Debug, Default, Serialize)]
pub struct Statements {
    rows: Vec<Row>,
    reproduced: usize,
    not_reproduced: usize,
    not_comparable: usize,
    /// Could not be looked at.
    unknown: usize,
    /// Came out otherwise than declared.
    surprises: usize,
}

#[derive(Debug, Serialize)]
struct Row {
    name: String,
    key: String,
    /// `reproduced`, `not reproduced`, `not comparable` or why nobody looked.
    words: &'static str,
    /// Of the style sheet.
    class: &'static str,
    mark: &'static str,
    /// What the source says.
    doc: String,
    source: String,
    reported: String,
    claims: Vec<Claim>,
    /// Why it differs or cannot be compared.
    reason: String,
    /// Whether it came out as declared.
    declared: bool,
    /// What is otherwise than declared; empty if nothing is.
    surprise: String,
}

#[derive(Debug, Serialize)]
struct Claim {
    mark: &'static str,
    /// For those who only hear the page.
    words: &'static str,
    text: String,
    values: String,
}

impl Statements {
    /// Every statement of a suite; `None` if it has none.
    pub fn new(report: &SuiteReport) -> Option<Self> {
        let mut all = Self::default();
        for block in &report.blocks {
            if let Block::Statement(statement) = &*block.block {
                all.add(block, statement.doc.as_deref().unwrap_or_default());
            }
        }
        (!all.rows.is_empty()).then_some(all)
    }

    fn add(&mut self, report: &BlockReport, doc: &str) {
        let result = match &report.state {
            BlockState::Finished(result) => match result.as_ref() {
                BlockResult::Statement(result) => result,
                _ => return,
            },
            BlockState::Errored(error) => {
                self.unknown += 1;
                return self.rows.push(Row::unknown(report, doc, "could not be looked at", &error.message));
            }
            BlockState::NotFinished(cut) => {
                self.unknown += 1;
                return self.rows.push(Row::unknown(report, doc, "not finished", &cut.to_string()));
            }
            BlockState::Skipped(reason) => {
                self.unknown += 1;
                return self.rows.push(Row::unknown(report, doc, "not looked at", &reason.to_string()));
            }
        };
        *match result.conclusion {
            Conclusion::Reproduced => &mut self.reproduced,
            Conclusion::NotReproduced => &mut self.not_reproduced,
            Conclusion::NotComparable(_) | Conclusion::Untested => &mut self.not_comparable,
        } += 1;
        self.surprises += usize::from(result.surprise().is_some());
        self.rows.push(Row::new(report, result));
    }
}

impl Row {
    fn new(report: &BlockReport, result: &StatementResult) -> Self {
        let (class, mark) = match result.conclusion {
            Conclusion::Reproduced => ("passed", "✓"),
            Conclusion::NotReproduced => ("failed", "✗"),
            Conclusion::NotComparable(_) | Conclusion::Untested => ("inconclusive", "–"),
        };
        let reason = match &result.standing {
            DeclaredStanding::Differs(reason) => format!("declared to differ: {reason}"),
            DeclaredStanding::NotComparable(reason) => reason.clone(),
            DeclaredStanding::Reproduced => String::new(),
        };
        let claim = |claim: &results::ClaimResult| Claim {
            mark: claim_mark(claim),
            words: match claim.holds {
                Some(true) => "holds",
                Some(false) => "does not hold",
                None => "cannot be said",
            },
            text: claim.text.clone(),
            values: claim_values(claim),
        };
        Self {
            name: result.name.clone(),
            key: report.key.clone(),
            words: conclusion_words(&result.conclusion),
            class,
            mark,
            doc: result.doc.clone().unwrap_or_default(),
            source: result.source.clone().unwrap_or_default(),
            reported: result.reported.clone().unwrap_or_default(),
            claims: result.claims.iter().map(claim).collect(),
            reason,
            declared: result.surprise().is_none(),
            surprise: result.surprise().unwrap_or_default(),
        }
    }

    fn unknown(report: &BlockReport, doc: &str, words: &'static str, reason: &str) -> Self {
        Self {
            name: report.block.name().to_string(),
            key: report.key.clone(),
            words,
            class: "skipped",
            mark: "–",
            doc: doc.to_string(),
            source: String::new(),
            reported: String::new(),
            claims: Vec::new(),
            reason: reason.to_string(),
            declared: false,
            surprise: String::new(),
        }
    }
}
