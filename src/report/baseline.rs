//! Baselines for people: what one holds, and what differs between two.

use std::fmt::Write;

use super::format::{count, quantity, share};
use files::escape::markdown;
use numbers::summary::mean;
use results::judge::baseline::{Baseline, RecordedMetric, RecordedTrial, pair};
use results::judge::gate::{OFTEN, share_of_one, vehicle_changes};
use results::{Change, Check, ComparedSubject, GateVerdict, Power};
use scenario::MetricKind;

const STRING: &str = "writing to a string cannot fail";

/// How a table is to look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Aligned text, for a fixed width.
    Terminal,
    /// For comments on pull requests.
    Markdown,
}

/// What a gate will see of later changes, as its comparison of a baseline with itself tells: said before anybody relies on it.
pub fn render_sight(gate: &GateVerdict) -> String {
    let mut text = format!("gate {}, if no run gets better:\n", gate.gate);
    for (index, rule) in gate.rules.iter().enumerate() {
        let own: Vec<&Check> = gate.checks.iter().filter(|check| check.rule == index).collect();
        if own.is_empty() {
            writeln!(text, "  `{rule}` compares nothing").expect(STRING);
        }
        for here in own.chunk_by(|one, next| one.place == next.place) {
            let place = &here[0].place;
            let flags = here.iter().filter_map(|check| seen_of_flag(check));
            for line in flags.chain(seen_of_quantities(here)) {
                writeln!(text, "  {place}: {line} (`{rule}`)").expect(STRING);
            }
        }
    }
    text
}

/// From which rise on, or fall, something is seen that is true or false.
fn seen_of_flag(check: &Check) -> Option<String> {
    let (label, cases) = (&check.label, share(OFTEN));
    let least = match (check.subject, check.power) {
        (ComparedSubject::Mean | ComparedSubject::Existence, _) => return None,
        (ComparedSubject::New, _) => share_of_one(check.units),
        (_, Power::Share(least)) => least,
        (_, Power::Everything) => return Some(format!("without chance, any change of {label} is seen")),
        (_, Power::Blind { needed }) => {
            let more = format!("it takes {needed} {} (`repeat`)", units(check));
            return Some(format!(
                "with these {} {} no change of {label} is seen; {more}",
                check.units,
                units(check)
            ));
        }
        (_, Power::Shift(_) | Power::OtherSeeds | Power::None) => return None,
    };
    let (change, to) = match check.larger_is_worse {
        true => ("rise", (check.base + least).min(1.0)),
        false => ("fall", (check.base - least).max(0.0)),
    };
    let seeds = if check.subject == ComparedSubject::New { ", on the same seeds" } else { "" };
    let (from, to) = (share(check.base), share(to));
    Some(format!(
        "with these {} {} a {change} of {label} from {from} to about {to} is seen in {cases} of cases{seeds}",
        check.units,
        units(check)
    ))
}

/// In how many runs quantities have to get worse for that to be seen.
fn seen_of_quantities(checks: &[&Check]) -> Vec<String> {
    let means = || checks.iter().filter(|check| check.subject == ComparedSubject::Mean);
    let shares = || {
        means().filter_map(|check| {
            Some((if let Power::Share(least) = check.power { least } else { return None }, check))
        })
    };
    let mut lines = Vec::new();
    if let Some((least, check)) = shares().reduce(|one, next| if next.0 < one.0 { next } else { one }) {
        let what = quantities(shares().count());
        lines.push(format!(
            "{what} that get worse in fewer than about {} of {} are not seen",
            share(least),
            units(check)
        ));
    }
    let blind = || means().filter(|check| check.needed() > 0);
    if let Some(check) = blind().max_by_key(|check| check.needed()) {
        let what = quantities(blind().count());
        lines.push(format!(
            "no change of {what} is seen; it takes {} {} (`repeat`)",
            check.needed(),
            units(check)
        ));
    }
    lines
}

/// What is independent of each other.
fn units(check: &Check) -> &'static str {
    if check.units < check.runs { "people" } else { "runs" }
}

fn quantities(number: usize) -> String {
    if number == 1 { "1 quantity".to_string() } else { format!("{number} quantities") }
}

/// Suite, seed, version, what is tested, and every metric's mean per trial.
pub fn render_baseline(baseline: &Baseline, form: Form) -> String {
    let mut text = heading(baseline, form);
    for (name, title) in &baseline.programs {
        line(&mut text, form, &format!("controller {name}: {title}"));
    }
    for (name, what) in &baseline.what_runs {
        line(&mut text, form, &format!("controller {name} runs: {what}"));
    }
    text.push_str(&nondeterministic(baseline, form));
    for (index, vehicles) in baseline.vehicles.iter().enumerate() {
        for vehicle in vehicles {
            let drives = format!("{} on {}", vehicle.controller.model, vehicle.dynamics.model);
            let trials = baseline.trials.iter().filter(|trial| trial.vehicles == index).count();
            line(&mut text, form, &format!("{}: {drives} in {trials} trials", vehicle.name));
        }
    }
    for trial in &baseline.trials {
        for warning in &trial.warnings {
            line(&mut text, form, &format!("warning: {}: {warning}", trial.key));
        }
    }
    text.push('\n');
    let columns: Vec<(usize, &RecordedMetric)> = baseline
        .metrics
        .iter()
        .enumerate()
        .filter(|(index, _)| {
            baseline.trials.iter().any(|trial| trial.values[*index].iter().any(Option::is_some))
        })
        .collect();
    let mut rows = vec![["metric", "trial", "runs", "mean", "smallest", "largest"].map(String::from)];
    for (index, metric) in columns {
        for trial in &baseline.trials {
            let values: Vec<f64> = trial.values[index].iter().copied().flatten().collect();
            let show = |value: Option<f64>| shown(metric, value);
            let least = values.iter().copied().reduce(f64::min);
            let most = values.iter().copied().reduce(f64::max);
            rows.push([
                metric.label.clone(),
                trial.key.clone(),
                format!("{} of {}", values.len(), trial.runs.len()),
                summary(metric, &trial.values[index]),
                show(least),
                show(most),
            ]);
        }
    }
    text + &table(&rows, form)
}

/// What differs between two baselines, without a verdict: trials, cases, what is tested, and every metric whose values
/// are not the same.
pub fn render_difference(base: &Baseline, candidate: &Baseline, form: Form) -> String {
    let mut text = String::new();
    for (name, one) in [("base", base), ("candidate", candidate)] {
        line(&mut text, form, &format!("{name}: {}", identity(one)));
        text.push_str(&nondeterministic(one, form));
    }
    let reasons = match pair(base, candidate, false) {
        Ok(_) => Vec::new(),
        Err(reasons) => reasons,
    };
    for reason in &reasons {
        line(&mut text, form, &reason.to_string());
    }
    let both: Vec<(&RecordedTrial, &RecordedTrial)> = candidate
        .trials
        .iter()
        .filter_map(|trial| Some((base.trials.iter().find(|known| known.key == trial.key)?, trial)))
        .collect();
    let mut changes: Vec<Change> = Vec::new();
    for (before, after) in &both {
        for (before, after) in base.vehicles[before.vehicles].iter().zip(&candidate.vehicles[after.vehicles])
        {
            let new = vehicle_changes(before, after).into_iter().filter(|change| !changes.contains(change));
            let new: Vec<_> = new.collect();
            changes.extend(new);
        }
    }
    for change in &changes {
        line(&mut text, form, &format!("tested: {change}"));
    }
    let mut rows = vec![["metric", "trial", "runs that differ", "base", "candidate"].map(String::from)];
    for (column, metric) in candidate.metrics.iter().enumerate() {
        let Some(base_column) = base.metrics.iter().position(|known| known.label == metric.label) else {
            continue;
        };
        for (before, after) in &both {
            let (old, new) = (&before.values[base_column], &after.values[column]);
            let differing = old.iter().zip(new).filter(|(old, new)| old != new).count();
            let differing = differing + old.len().abs_diff(new.len());
            if differing > 0 {
                rows.push([
                    metric.label.clone(),
                    after.key.clone(),
                    format!("{differing} of {}", new.len()),
                    summary(metric, old),
                    summary(metric, new),
                ]);
            }
        }
    }
    if rows.len() == 1 && reasons.is_empty() {
        let same = both.iter().all(|(before, after)| before.fingerprint == after.fingerprint);
        let what =
            if same { "every run went exactly as before" } else { "every metric of every run is the same" };
        line(&mut text, form, what);
        return text;
    }
    if rows.len() > 1 {
        text.push('\n');
        text += &table(&rows, form);
    }
    text
}

fn heading(baseline: &Baseline, form: Form) -> String {
    let mut text = String::new();
    line(&mut text, form, &identity(baseline));
    text
}

/// Its programs that do not decide the same each time, a line each.
fn nondeterministic(baseline: &Baseline, form: Form) -> String {
    let mut text = String::new();
    for (name, how) in &baseline.nondeterministic {
        line(&mut text, form, &format!("warning: W1102: `{name}` is not deterministic: {how}"));
    }
    text
}

fn identity(baseline: &Baseline) -> String {
    let set = match &baseline.set[..] {
        [] => String::new(),
        set => format!(", with {}", set.join(", ")),
    };
    format!(
        "suite {}, seed {}{set}, {}, {}, scenario-runner {}",
        baseline.suite,
        baseline.seed,
        count(baseline.trials.len(), "trial"),
        count(baseline.runs(), "run"),
        baseline.tool
    )
}

fn line(text: &mut String, form: Form, content: &str) {
    match form {
        Form::Terminal => writeln!(text, "{content}").expect(STRING),
        Form::Markdown => writeln!(text, "- {}", markdown(content)).expect(STRING),
    }
}

/// Mean of a quantity, share of a flag, counts of words; with how many runs have it where not all do.
fn summary(metric: &RecordedMetric, row: &[Option<f64>]) -> String {
    let values: Vec<f64> = row.iter().copied().flatten().collect();
    let Some(centre) = mean(&values) else { return "–".to_string() };
    let text = match metric.name.known().map(|metric| &metric.kind) {
        Some(MetricKind::Flag) => share(centre),
        Some(MetricKind::Category(words)) => {
            let count = |index: usize| values.iter().filter(|value| **value as usize == index).count();
            let counts = words.iter().enumerate().map(|(index, word)| (word, count(index)));
            let counts =
                counts.filter(|(_, count)| *count > 0).map(|(word, count)| format!("{word} {count}"));
            counts.collect::<Vec<_>>().join(", ")
        }
        _ => shown(metric, Some(centre)),
    };
    if values.len() < row.len() { format!("{text} ({} of {})", values.len(), row.len()) } else { text }
}

fn shown(metric: &RecordedMetric, value: Option<f64>) -> String {
    metric.name.known().map_or_else(|| "?".to_string(), |metric| quantity(metric, value))
}

/// The first row is the heading; the first two columns stand left.
fn table<const N: usize>(rows: &[[String; N]], form: Form) -> String {
    let mut text = String::new();
    if form == Form::Markdown {
        for (index, row) in rows.iter().enumerate() {
            let cells = row.iter().map(|cell| format!(" {} ", markdown(cell))).collect::<Vec<_>>();
            writeln!(text, "|{}|", cells.join("|")).expect(STRING);
            if index == 0 {
                writeln!(text, "|---|---|{}", "--:|".repeat(N - 2)).expect(STRING);
            }
        }
        return text;
    }
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(width);
    for row in rows {
        let mut drawn = String::new();
        for (column, (cell, width)) in row.iter().zip(widths).enumerate() {
            let cell = if column < 2 { format!("{cell:<width$}") } else { format!("{cell:>width$}") };
            drawn += &cell;
            drawn += "  ";
        }
        writeln!(text, "{}", drawn.trim_end()).expect(STRING);
    }
    text
}
