//! What gates and comparisons found, for the terminal.

use std::fmt::Write;

use anstyle::{AnsiColor, Style};

use super::format::{count, quantity, share};
use super::replay::replay_command;
use super::{Excerpt, GateReport, GateState, SuiteIdentity, SuiteReport};
use crate::judge::Verdict;
use crate::judge::baseline::{Incompatible, Part};
use crate::judge::gate::{ChangedRun, Check, CheckOutcome, GateVerdict, Power, Subject};
use crate::metrics;
use crate::scenario::significant;

/// More runs than this are counted, not named.
pub const MOST_RUNS_NAMED: usize = 5;

const STRING: &str = "writing to a string cannot fail";

/// How to see one run again.
pub type Replay<'a> = &'a dyn Fn(&str) -> Option<String>;

/// A gate with its verdict, a table of comparisons and what happened in those that regressed. Unless `all`, comparisons
/// that held are counted only.
pub fn render_gate(verdict: &GateVerdict, replay: Replay, all: bool, colour: bool) -> String {
    let paint =
        |text: &str, style: Style| if colour { format!("{style}{text}{style:#}") } else { text.to_string() };
    let mut text = String::new();
    let mark = format!("{} {}", outcome_mark(verdict.verdict), outcome_word(verdict.verdict));
    writeln!(
        text,
        "{} {}",
        paint(&verdict.gate, Style::new().bold()),
        paint(&mark, verdict_style(verdict.verdict))
    )
    .expect(STRING);
    for line in context(verdict) {
        writeln!(text, "  {line}").expect(STRING);
    }
    let shown: Vec<&Check> =
        verdict.checks.iter().filter(|check| all || check.outcome != CheckOutcome::Held).collect();
    let mut place = "";
    let rows: Vec<(&Check, [String; 6])> = shown.iter().map(|check| (*check, cells(check))).collect();
    let widths: [usize; 6] = std::array::from_fn(|column| {
        let cells = rows.iter().map(|(_, row)| row[column].chars().count());
        cells.chain([HEADINGS[column].chars().count()]).max().unwrap_or(0)
    });
    for (check, row) in &rows {
        if check.place != place {
            place = &check.place;
            let heading = drawn(&HEADINGS.map(str::to_string), &widths, "  ");
            let title = paint(place, Style::new().bold());
            writeln!(text, "\n  {title}\n{}", paint(&heading, Style::new().dimmed())).expect(STRING);
        }
        let line = drawn(row, &widths, check_mark(check.outcome));
        writeln!(text, "{}", paint(&line, check_style(check.outcome))).expect(STRING);
    }
    for check in shown.iter().filter(|check| check.outcome == CheckOutcome::Regressed) {
        writeln!(text, "\n  {}", paint(&sentence(check), AnsiColor::Red.on_default())).expect(STRING);
        for line in flips(check, replay) {
            writeln!(text, "      {line}").expect(STRING);
        }
    }
    text
}

pub const HEADINGS: [&str; 6] = ["", "base", "candidate", "change", "tolerated", "would have caught"];

/// Every gate of every suite, for the terminal; empty without gates.
pub fn render_gates(reports: &[SuiteReport], colour: bool) -> String {
    let mut text = String::new();
    for (report, gate) in reports.iter().flat_map(|one| one.gates.iter().map(move |gate| (one, gate))) {
        write!(text, "\n{}", render_gate_report(&report.identity, gate, colour)).expect(STRING);
    }
    text
}

/// One gate in full, with its key in front.
pub fn render_gate_report(suite: &SuiteIdentity, gate: &GateReport, colour: bool) -> String {
    match &gate.state {
        GateState::Judged(verdict) => {
            let replay = |key: &str| Some(replay_command(suite, key));
            format!("gate {}", render_gate(verdict, &replay, false, colour))
        }
        GateState::Refused(refusal) => {
            let title = format!("gate `{}` cannot be judged: {}", gate.gate.name, refusal.message);
            let excerpt = Excerpt {
                title: &title,
                origin: &gate.gate.origin,
                label: "",
                notes: &refusal.reasons,
                help: Some(&refusal.help),
            };
            excerpt.render(colour) + "\n"
        }
        GateState::Skipped(message) => format!("gate {} is not judged: {message}\n", gate.gate.name),
    }
}

/// Everything about a gate that is not about a single comparison, a sentence each.
pub fn context(verdict: &GateVerdict) -> Vec<String> {
    let mut lines = vec![format!(
        "{} over {}: {} regressed, {} held, {} not shown either way",
        count(verdict.checks.len(), "comparison"),
        count(verdict.runs, "run"),
        verdict.count(CheckOutcome::Regressed),
        verdict.count(CheckOutcome::Held),
        verdict.count(CheckOutcome::NotShown),
    )];
    lines.push(match (verdict.nothing_changed, verdict.same_seeds, verdict.same_people) {
        (true, ..) => "every run went exactly as before".to_string(),
        (_, true, _) => "paired on the same seeds: pairs differ by what is tested only".to_string(),
        (_, false, true) => {
            "the seeds differ: pairs differ by chance too, so that only larger changes are seen".to_string()
        }
        (_, false, false) => {
            "the seeds and so the people differ: people are compared with other people, so that only \
                              larger changes are seen"
                .to_string()
        }
    });
    if !verdict.changes.is_empty() {
        lines.push(format!("tested: {}", verdict.changes.join(", ")));
    }
    for rule in &verdict.blind_rules {
        lines.push(format!("`{rule}` could not have failed: {}", why_blind(verdict, rule)));
    }
    for new in [&verdict.new_trials, &verdict.new_metrics] {
        if !new.is_empty() {
            lines.push(format!("not compared, since the base lacks them: {}", some(new)));
        }
    }
    if !verdict.without_values.is_empty() {
        lines.push(format!("not compared, since no run has them: {}", verdict.without_values.join(", ")));
    }
    lines
}

fn why_blind(verdict: &GateVerdict, rule: &str) -> String {
    let of_rule = |check: &&Check| verdict.rules.get(check.rule).is_some_and(|text| text == rule);
    let needed = verdict.checks.iter().filter(of_rule).filter_map(|check| match check.power {
        Power::Blind { needed } => Some((needed, check.units)),
        _ => None,
    });
    match needed.max() {
        Some((needed, units)) => format!(
            "{units} runs show nothing among {} comparisons; it takes {needed} or more (`repeat`)",
            verdict.family
        ),
        None => "it compares nothing".to_string(),
    }
}

/// A comparison in cells, after [`HEADINGS`].
pub fn cells(check: &Check) -> [String; 6] {
    let change = show_difference(check, check.candidate - check.base);
    let interval = check
        .interval
        .map(|(low, high)| format!(" [{}, {}]", show_difference(check, low), show_difference(check, high)));
    [
        label(check),
        show(check, check.base),
        show(check, check.candidate),
        format!("{change}{}", interval.unwrap_or_default()),
        amount(check, check.tolerance),
        caught(check),
    ]
}

/// What is compared: `pet`, `pet exists`, `collision`.
pub fn label(check: &Check) -> String {
    match check.subject {
        Subject::Existence => format!("{} exists", check.label),
        _ => check.label.clone(),
    }
}

/// What would have been caught, in words for a cell.
pub fn caught(check: &Check) -> String {
    match check.power {
        Power::Everything => "anything more".to_string(),
        Power::Shift(size) => amount(check, size),
        Power::Share(size) => format!("{} of runs", share(size)),
        Power::Blind { needed } => format!("nothing: needs {needed} runs"),
        Power::None => "–".to_string(),
    }
}

/// A regression in a sentence.
pub fn sentence(check: &Check) -> String {
    let why = match check.adjusted_p_value {
        None => "there is no chance in it".to_string(),
        Some(p) => format!("p = {} after Holm's correction", significant(p, 2)),
    };
    format!(
        "{} in {}: {} -> {}, worse by {} where {} is tolerated; {why}",
        label(check),
        check.place,
        show(check, check.base),
        show(check, check.candidate),
        amount(check, check.worse_by()),
        amount(check, check.tolerance),
    )
}

/// Which runs changed, worst first, with a command to see the first of them again.
pub fn flips(check: &Check, replay: Replay) -> Vec<String> {
    let mut lines = Vec::new();
    for (runs, what) in [(&check.worse_runs, "worse"), (&check.better_runs, "better")] {
        if runs.is_empty() {
            continue;
        }
        lines.push(format!("{} of {} runs got {what}", runs.len(), check.runs));
        if what == "worse" {
            lines.extend(runs.iter().take(MOST_RUNS_NAMED).map(|run| format!("  {}", changed(check, run))));
            let more = runs.len().saturating_sub(MOST_RUNS_NAMED);
            if more > 0 {
                lines.push(format!("  and {more} more"));
            }
        }
    }
    if let Some(command) = check.worse_runs.first().and_then(|run| replay(&run.key)) {
        lines.push(format!("replay: {command}"));
    }
    lines
}

/// `1.2 s -> 0.3 s  zebra/walker/tta=6s/rep=2`.
pub fn changed(check: &Check, run: &ChangedRun) -> String {
    let value =
        |value| metrics::metric(&check.metric).map_or("?".to_string(), |metric| quantity(metric, value));
    format!("{} -> {}  {}", value(run.base), value(run.candidate), run.key)
}

/// Why two baselines may not be compared, a sentence each.
pub fn render_reason(reason: &Incompatible) -> String {
    let in_trials = |trials: &[String]| match trials {
        [one] => format!("in {one}"),
        many => format!("in {} trials: {}", many.len(), some(many)),
    };
    match reason {
        Incompatible::OtherSuite { base, candidate } => {
            format!("it is of suite `{base}`, and this is suite `{candidate}`")
        }
        Incompatible::NothingInCommon { base, candidate } => {
            format!("suite `{base}` and suite `{candidate}` have no trial in common")
        }
        Incompatible::Vanished(trials) => format!("trials are gone: {}", some(trials)),
        Incompatible::New(trials) => format!("trials are new: {}", some(trials)),
        Incompatible::MetricMissing(label) => format!("the base has no metric `{label}`"),
        Incompatible::MetricDiffers(label) => format!("`{label}` was measured with other parameters"),
        Incompatible::Runs(trials) => {
            format!("there are other runs (`repeat` or individuals) {}", in_trials(trials))
        }
        Incompatible::Part { part, trials } => {
            let what = match part {
                Part::Road => "the road differs",
                Part::Pedestrians => {
                    "the pedestrians differ (model, parameters, start, goal or when they appear)"
                }
                Part::People => "the individuals differ (the population's file)",
                Part::Traffic => "the vehicles' speed, lane or start differs",
                Part::Simulation => "step, horizon or finish line differs",
            };
            format!("{what} {}", in_trials(trials))
        }
    }
}

fn some(names: &[String]) -> String {
    let shown: Vec<_> = names.iter().take(3).map(String::as_str).collect();
    let more = names.len() - shown.len();
    let shown = shown.join(", ");
    if more > 0 { format!("{shown} and {more} more") } else { shown }
}

/// A mean in the metric's unit, or a share.
fn show(check: &Check, value: f64) -> String {
    match check.subject {
        Subject::Mean => metrics::metric(&check.metric)
            .map_or_else(|| significant(value, 4), |metric| quantity(metric, Some(value))),
        Subject::Rate | Subject::Existence => share(value),
    }
}

/// A difference with its sign: relative where it is one of means.
fn show_difference(check: &Check, value: f64) -> String {
    if value.is_infinite() {
        return "?".to_string();
    }
    let sign = if value < 0.0 { "-" } else { "+" };
    format!("{sign}{}", amount(check, value.abs()))
}

/// A size without a sign: `5.2 %` of a mean, `0.3 s` of a mean of 0, `3 points` of a share.
fn amount(check: &Check, size: f64) -> String {
    match check.subject {
        Subject::Mean if check.base != 0.0 => {
            format!("{} %", significant(100.0 * size / check.base.abs(), 3))
        }
        Subject::Mean => show(check, size),
        Subject::Rate | Subject::Existence => format!("{} points", significant(100.0 * size, 3)),
    }
}

pub fn outcome_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Passed => "passed",
        Verdict::Inconclusive => "inconclusive",
        Verdict::Failed => "regressed",
    }
}

pub fn outcome_mark(verdict: Verdict) -> &'static str {
    super::wording::verdict_mark(verdict)
}

pub fn check_mark(outcome: CheckOutcome) -> &'static str {
    match outcome {
        CheckOutcome::Held => "✓",
        CheckOutcome::NotShown => "?",
        CheckOutcome::Regressed => "✗",
    }
}

fn verdict_style(verdict: Verdict) -> Style {
    match verdict {
        Verdict::Passed => AnsiColor::Green.on_default(),
        Verdict::Inconclusive => AnsiColor::Yellow.on_default(),
        Verdict::Failed => AnsiColor::Red.on_default(),
    }
}

fn check_style(outcome: CheckOutcome) -> Style {
    match outcome {
        CheckOutcome::Held => AnsiColor::Green.on_default(),
        CheckOutcome::NotShown => Style::new(),
        CheckOutcome::Regressed => AnsiColor::Red.on_default(),
    }
}

/// A line of a table: a mark, the first cell to the left, the others to the right.
fn drawn(cells: &[String; 6], widths: &[usize; 6], mark: &str) -> String {
    let mut line = format!("  {mark:<2}{:<1$}", cells[0], widths[0]);
    for (cell, width) in cells.iter().zip(widths).skip(1) {
        write!(line, "  {cell:>width$}").expect(STRING);
    }
    line.trim_end().to_string()
}
