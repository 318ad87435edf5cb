//! What gates and comparisons found, for the terminal.

use std::fmt::Write;

use anstyle::{AnsiColor, Style};

use super::format::{count, in_notation, quantity, share};
use super::table::paint;
use files::escape::{terminal, terminal_line};
use lang::Excerpt;
use results::judge::baseline::some;
use results::{
    BlindPlace, ChangedRun, Check, CheckOutcome, ComparedSubject, GateReport, GateState, GateVerdict, Power,
    SuiteIdentity, SuiteReport, TrialChange, Verdict,
};
use scenario::significant;

/// More runs than this are counted, not named.
pub const MOST_RUNS_NAMED: usize = 5;
/// Comparisons of which the trial is named that got worse though all together did not.
const MOST_TRIALS_NAMED: usize = 5;

const STRING: &str = "writing to a string cannot fail";

/// How to see one run again.
pub type Replay<'a> = &'a dyn Fn(&str) -> Option<String>;

/// A gate with its verdict, a table of comparisons and what happened in those that regressed. Unless `all`, comparisons
/// that held or are the same are counted only.
pub fn render_gate(verdict: &GateVerdict, replay: Replay, all: bool, colour: bool) -> String {
    let paint = |text: &str, style: Style| paint(&terminal_line(text), style, colour);
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
        writeln!(text, "  {}", terminal(&line)).expect(STRING);
    }
    let shown: Vec<&Check> = verdict.checks.iter().filter(|check| all || !check.outcome.is_fine()).collect();
    let mut place = "";
    let rows: Vec<(&Check, [String; 6])> =
        shown.iter().map(|check| (*check, cells(check).map(|cell| terminal_line(&cell)))).collect();
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
            writeln!(text, "      {}", terminal_line(&line)).expect(STRING);
        }
    }
    text
}

pub const HEADINGS: [&str; 6] = ["", "base", "candidate", "change", "tolerated", "would have caught"];

/// Every gate of every suite, for the terminal; empty without gates.
pub fn render_gates(suites: &[SuiteReport], colour: bool) -> String {
    let mut text = String::new();
    for (report, gate) in suites.iter().flat_map(|one| one.gates.iter().map(move |gate| (one, gate))) {
        write!(text, "\n{}", render_gate_report(&report.identity, gate, colour)).expect(STRING);
    }
    text
}

/// One gate in full, with its key in front.
pub fn render_gate_report(suite: &SuiteIdentity, gate: &GateReport, colour: bool) -> String {
    match &gate.state {
        GateState::Judged(verdict) => {
            let replay = |key: &str| Some(suite.replay_command(key));
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
        GateState::NotJudged(why) => {
            format!("gate {} is NOT JUDGED: {}\n", terminal_line(&gate.gate.name), terminal(&why.to_string()))
        }
    }
}

/// Everything about a gate that is not about a single comparison, a sentence each.
pub fn context(verdict: &GateVerdict) -> Vec<String> {
    let mut lines = vec![format!(
        "{} over {}: {} regressed, {} held, {}{} not shown either way",
        count(verdict.checks.len(), "comparison"),
        count(verdict.runs, "run"),
        verdict.count(CheckOutcome::Regressed),
        verdict.count(CheckOutcome::Held),
        match verdict.count(CheckOutcome::Same) {
            0 => String::new(),
            same => format!("{same} the same, "),
        },
        verdict.count(CheckOutcome::NotShown),
    )];
    let by_chance = !verdict.nondeterministic.is_empty();
    lines.extend(verdict.looks.map(|looks| match looks.ended_it_of {
        Some(all) => format!(
            "sequential: failed after {} of {}, at look {}; what else there may be was not compared",
            verdict.runs,
            count(all, "run"),
            looks.made,
        ),
        None => format!(
            "sequential: no doubt at {} before all runs were there, on which a tenth of the error is spent",
            count(looks.made, "look"),
        ),
    }));
    lines.push(match (verdict.nothing_changed, verdict.same_seeds, verdict.same_people) {
        (true, ..) if by_chance => {
            "every run went exactly as before, which with what is not deterministic may be chance".to_string()
        }
        (true, ..) => "every run went exactly as before".to_string(),
        (_, true, _) if by_chance => {
            "the seeds are the same, but what is tested does not decide the same each time: pairs differ by chance too, so that only \
                              larger changes are seen"
                .to_string()
        }
        (_, true, _) => "paired on the same seeds: pairs differ by what is tested only".to_string(),
        (_, false, true) => {
            "the seeds differ: pairs differ by chance too, so that only larger changes are seen, and how much larger is not known; with \
                              the same seeds the same runs show far smaller ones"
                .to_string()
        }
        (_, false, false) => {
            "the seeds and so the people differ: people are compared with other people, so that only \
                              larger changes are seen"
                .to_string()
        }
    });
    if !verdict.changes.is_empty() {
        let changes: Vec<_> = verdict.changes.iter().map(ToString::to_string).collect();
        lines.push(format!("tested: {}", changes.join(", ")));
    }
    let others = verdict.family - verdict.primary;
    if verdict.primary > 0 && others > 0 {
        lines.push(format!(
            "{} of primary rules may err in half of the cases in which the gate may, {} in the other half",
            count(verdict.primary, "comparison"),
            if others == 1 { "the other".to_string() } else { format!("{others} others") },
        ));
    }
    lines.extend(verdict.nondeterministic.iter().map(|one| format!("warning: {one}")));
    lines.extend(blindness(verdict));
    lines.extend(cancelled(verdict));
    for new in [&verdict.new_trials, &verdict.new_metrics] {
        if !new.is_empty() {
            lines.push(format!("not compared, since the base lacks them: {}", some(new)));
        }
    }
    if !verdict.unnamed_flags.is_empty() {
        let first = &verdict.unnamed_flags[0];
        lines.push(format!(
            "not compared, since what is true or false needs a rule of its own, such as `{first} not worse`: {}",
            verdict.unnamed_flags.join(", ")
        ));
    }
    if !verdict.without_values.is_empty() {
        lines.push(format!("not compared, since no run has them: {}", verdict.without_values.join(", ")));
    }
    lines
}

/// Why a gate in which nothing regressed does not pass, a sentence each: what could not have failed, and runs of which nobody knows what they
/// would have come to.
pub fn blindness(verdict: &GateVerdict) -> Vec<String> {
    let cut_off = (verdict.cut_off > 0).then(|| {
        format!(
            "{} ended before all had met, of which nobody knows what would have come: give `horizon` more time",
            count(verdict.cut_off, "run"),
        )
    });
    let rules = verdict.blind_rules.iter();
    let rules = rules.map(|rule| format!("`{rule}` could not have failed: {}", why_blind(verdict, rule)));
    let places = verdict.blind_places.iter().map(|BlindPlace { rule, scenario, units, needed }| {
        let why = too_few(verdict, rule, *units, *needed);
        format!("`{rule}` could not have failed in {scenario}, where something changed: {why}")
    });
    cut_off.into_iter().chain(rules).chain(places).collect()
}

fn why_blind(verdict: &GateVerdict, rule: &str) -> String {
    let of_rule = |check: &&Check| verdict.rules.get(check.rule).is_some_and(|text| text == rule);
    let needed = verdict.checks.iter().filter(of_rule).filter_map(|check| match check.power {
        Power::Blind { needed } => Some((needed, check.units)),
        _ => None,
    });
    match needed.max() {
        Some((needed, units)) => too_few(verdict, rule, units, needed),
        None if rule.trim_start_matches(PRIMARY).starts_with("no new ") && !verdict.same_seeds => {
            "the seeds differ, and only of a run on the same seed can be said that something in it is new"
                .to_string()
        }
        None => "it compares nothing".to_string(),
    }
}

/// What a rule begins with that has an error of its own.
const PRIMARY: &str = "primary ";

fn too_few(verdict: &GateVerdict, rule: &str, units: usize, needed: usize) -> String {
    if needed == 0 {
        return "nobody can say which way is worse".to_string();
    }
    format!(
        "{} nothing among {}; it takes {needed} or more (`repeat`)",
        if units == 1 { "1 run shows".to_string() } else { format!("{units} runs show") },
        match rule.starts_with(PRIMARY) {
            true => count(verdict.primary, "primary comparison"),
            false => count(verdict.family - verdict.primary, "comparison"),
        },
    )
}

/// Trials that got worse by more than is tolerated over all trials, though the comparison over all of them does not say
/// so: those that got better may hide them.
fn cancelled(verdict: &GateVerdict) -> Vec<String> {
    let hidden = verdict.checks.iter().filter(|check| check.outcome != CheckOutcome::Regressed);
    let mut hidden: Vec<(f64, &Check, &TrialChange)> = hidden
        .filter_map(|check| {
            let trial = check.worst_trial.as_ref()?;
            let beyond = trial.worse_by - check.tolerance;
            let scale = if check.base == 0.0 { trial.worse_by } else { check.base.abs() };
            (beyond > 1e-6 * check.tolerance && trial.worse_by > 0.0).then_some((
                beyond / scale,
                check,
                trial,
            ))
        })
        .collect();
    hidden.sort_by(|one, other| other.0.total_cmp(&one.0));
    let more = hidden.len().saturating_sub(MOST_TRIALS_NAMED);
    let line = |(_, check, trial): &(f64, &Check, &TrialChange)| {
        format!(
            "worse in one trial, if not over all: {} in {}, {} -> {} (over all of {}: {} -> {})",
            label(check),
            trial.key,
            show(check, trial.base),
            show(check, trial.candidate),
            check.place,
            show(check, check.base),
            show(check, check.candidate),
        )
    };
    let mut lines: Vec<String> = hidden.iter().take(MOST_TRIALS_NAMED).map(line).collect();
    if more > 0 {
        lines.push(format!("and {more} more comparisons are worse in one trial than over all of them"));
    }
    lines
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
        ComparedSubject::Existence => format!("{} exists", check.label),
        ComparedSubject::New => format!("new {}", check.label),
        ComparedSubject::Mean | ComparedSubject::Rate => check.label.clone(),
    }
}

/// What would have been caught, in words for a cell.
pub fn caught(check: &Check) -> String {
    match check.power {
        Power::Everything => "anything more".to_string(),
        Power::Shift(size) => amount(check, size),
        Power::Share(size) => format!("{} of runs", share(size)),
        Power::Blind { needed } => format!("nothing: needs {needed} runs"),
        Power::OtherSeeds | Power::None => "–".to_string(),
    }
}

/// A regression in a sentence.
pub fn sentence(check: &Check) -> String {
    if check.subject == ComparedSubject::New {
        return format!(
            "{} in {}: {} that had none on the same seed; that needs no statistics",
            label(check),
            check.place,
            count(check.worse_runs.len(), "run"),
        );
    }
    let why = match check.adjusted_p_value {
        None => "there is no chance in it".to_string(),
        Some(p) => format!("p = {}, corrected for all comparisons", significant(p, 2)),
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
    let value = |value| in_its_unit(check, value).unwrap_or_else(|| "?".to_string());
    format!("{} -> {}  {}", value(run.base), value(run.candidate), run.key)
}

/// A value of the metric in the unit that its suite compares it in; `None` if nobody knows the metric.
fn in_its_unit(check: &Check, value: Option<f64>) -> Option<String> {
    match (value, check.notation) {
        (Some(value), Some(unit)) => Some(in_notation(value, unit)),
        (value, _) => check.metric.known().map(|metric| quantity(metric, value)),
    }
}

/// A mean in the metric's unit, or a share.
fn show(check: &Check, value: f64) -> String {
    match check.subject {
        ComparedSubject::Mean => in_its_unit(check, Some(value)).unwrap_or_else(|| significant(value, 4)),
        ComparedSubject::Rate | ComparedSubject::Existence | ComparedSubject::New => share(value),
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

/// A difference as a number of [`show_difference`]'s: in per cent of the base's mean or in points of a share. None of a mean of 0.
pub fn relative(check: &Check, difference: f64) -> Option<f64> {
    match check.subject {
        ComparedSubject::Mean if check.base == 0.0 => None,
        ComparedSubject::Mean => Some(100.0 * difference / check.base.abs()),
        ComparedSubject::Rate | ComparedSubject::Existence | ComparedSubject::New => Some(100.0 * difference),
    }
}

/// A size without a sign: `5.2 %` of a mean, `0.3 s` of a mean of 0, `3 points` of a share.
fn amount(check: &Check, size: f64) -> String {
    let unit = if check.subject == ComparedSubject::Mean { "%" } else { "points" };
    match relative(check, size) {
        Some(size) => format!("{} {unit}", significant(size, 3)),
        None => show(check, size),
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
        CheckOutcome::Same => "=",
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
        CheckOutcome::Same | CheckOutcome::Held => AnsiColor::Green.on_default(),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::gate::{compared, gate};

    #[test]
    fn a_trial_that_got_worse_is_named_though_the_others_hide_it() {
        let mut verdict = compared(&gate(), 0.0);
        assert!(!context(&verdict).iter().any(|line| line.contains("in one trial")));
        let hidden = |worse_by: f64| {
            let (key, base) = ("walker/tta=6s".to_string(), 3.0);
            Some(TrialChange { key, base, candidate: base - worse_by, worse_by })
        };
        verdict.checks[0].worst_trial = hidden(1.0);
        let said = context(&verdict);
        let said = said.iter().find(|line| line.contains("in one trial")).unwrap();
        let start = "worse in one trial, if not over all: pet in walker/tta=6s, 3 s -> 2 s (over all of ";
        assert!(said.starts_with(start), "{said}");
        // What is tolerated over all trials is so in one.
        verdict.checks[0].worst_trial = hidden(verdict.checks[0].tolerance);
        assert!(!context(&verdict).iter().any(|line| line.contains("in one trial")));
    }

    #[test]
    fn what_no_run_changed_is_the_same_and_not_held() {
        let verdict = compared(&gate(), 0.0);
        assert!(verdict.checks.iter().all(|check| check.outcome == CheckOutcome::Same));
        let said = &context(&verdict)[0];
        let all = verdict.checks.len();
        assert!(said.contains(&format!("0 regressed, 0 held, {all} the same, 0 not shown")), "{said}");
    }

    #[test]
    fn runs_that_ended_before_all_had_met_are_a_reason() {
        let mut verdict = compared(&gate(), 0.0);
        assert!(blindness(&verdict).is_empty());
        verdict.cut_off = 3;
        assert!(blindness(&verdict)[0].starts_with("3 runs ended before all had met"));
        assert!(context(&verdict).contains(&blindness(&verdict)[0]));
    }

    #[test]
    fn where_a_rule_sees_nothing_is_said() {
        let mut verdict = compared(&gate(), 0.0);
        let (rule, scenario) = (verdict.rules[0].clone(), "late_person".to_string());
        verdict.blind_places.push(BlindPlace { rule: rule.clone(), scenario, units: 6, needed: 11 });
        let said = blindness(&verdict);
        let start =
            format!("`{rule}` could not have failed in late_person, where something changed: 6 runs show");
        assert!(
            said[0].starts_with(&start) && said[0].ends_with("it takes 11 or more (`repeat`)"),
            "{said:?}"
        );
    }
}
