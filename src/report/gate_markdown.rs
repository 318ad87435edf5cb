//! What gates and comparisons found, in Markdown for a pull request.

use std::fmt::Write;

use super::gate::{
    HEADINGS, MOST_RUNS_NAMED, Replay, cells, changed, check_mark, context, outcome_word, sentence,
};
use files::escape::{markdown, markdown_code};
use results::{Check, CheckOutcome, GateVerdict, Verdict};

const STRING: &str = "writing to a string cannot fail";

/// A section: the verdict, a table of what did not hold, and what held or is the same folded away.
pub fn gate_markdown(verdict: &GateVerdict, replay: Replay) -> String {
    let sign = match verdict.verdict {
        Verdict::Passed => "✅",
        Verdict::Inconclusive => "❔",
        Verdict::Failed => "❌",
    };
    let mut text = format!("### {sign} {}: {}\n\n", markdown(&verdict.gate), outcome_word(verdict.verdict));
    for line in context(verdict) {
        writeln!(text, "- {}", markdown(&line)).expect(STRING);
    }
    text.push('\n');
    let of = |wanted: &dyn Fn(CheckOutcome) -> bool| -> Vec<&Check> {
        verdict.checks.iter().filter(|check| wanted(check.outcome)).collect()
    };
    table(&mut text, &of(&|outcome| !outcome.is_fine()));
    for check in of(&|outcome| outcome == CheckOutcome::Regressed) {
        writeln!(text, "**{}**\n", markdown(&sentence(check))).expect(STRING);
        runs(&mut text, check, replay);
    }
    let held = of(&|outcome| outcome.is_fine());
    if !held.is_empty() {
        writeln!(text, "<details><summary>{} that held or are the same</summary>\n", held.len())
            .expect(STRING);
        table(&mut text, &held);
        text.push_str("</details>\n");
    }
    text.trim_end().to_string() + "\n"
}

fn table(text: &mut String, checks: &[&Check]) {
    if checks.is_empty() {
        return;
    }
    writeln!(text, "| | where |{}|", HEADINGS.map(|heading| format!(" {heading} ")).join("|")).expect(STRING);
    writeln!(text, "|---|---|---|{}", "--:|".repeat(HEADINGS.len() - 1)).expect(STRING);
    for check in checks {
        let cells = cells(check).map(|cell| format!(" {} ", markdown(&cell)));
        writeln!(text, "| {} | {} |{}|", check_mark(check.outcome), markdown(&check.place), cells.join("|"))
            .expect(STRING);
    }
    text.push('\n');
}

fn runs(text: &mut String, check: &Check, replay: Replay) {
    let counts = (check.worse_runs.len(), check.better_runs.len());
    writeln!(text, "{} of {} runs got worse, {} better:\n", counts.0, check.runs, counts.1).expect(STRING);
    for run in check.worse_runs.iter().take(MOST_RUNS_NAMED) {
        writeln!(text, "- {}", markdown(&changed(check, run))).expect(STRING);
    }
    if let Some(command) = check.worse_runs.first().and_then(|run| replay(&run.key)) {
        writeln!(text, "\n{}", markdown_code(&command)).expect(STRING);
    }
    text.push('\n');
}
