//! A compact table per scenario for the terminal: variation values down, the criteria's metrics across.

use std::cmp::Ordering;
use std::collections::HashMap;

use anstyle::{AnsiColor, Style};

use super::digest::{Digest, written_unit};
use super::figures::short_name;
use super::wording::{closest_calls, judged_words};
use files::escape::{terminal, terminal_line};
use results::{
    MOST_SHOWN, Requests, ScenarioSummary, Standing, SuiteReport, TrialReport, TrialState, Verdict,
};
use scenario::{Criterion, Metric, MetricReference, Notation, Origin, Worst};

/// Wider labels are cut.
const WIDEST_LABEL: usize = 40;

/// What is shown of trials without criteria.
const HEADLINES: [&str; 5] = ["collision", "gap_accepted", "pet", "max_deceleration", "time_lost"];

/// A metric as it is shown.
pub struct Column<'r> {
    /// In the outcomes.
    pub index: usize,
    pub metric: &'r Metric,
    pub label: String,
    /// That of the first criterion about it; `None` for the SI unit.
    pub unit: Option<Notation>,
    /// Of a criterion over a group its members, each with where its value is in the outcomes; otherwise nobody.
    pub members: Vec<MemberColumn<'r>>,
}

/// One of those that a criterion over a group is about.
pub struct MemberColumn<'r> {
    pub name: String,
    index: usize,
    reference: &'r MetricReference,
}

impl Column<'_> {
    /// What stands above it, in two lines.
    pub fn heading(&self) -> (String, String) {
        Digest::heading(self.metric, &self.label, self.unit)
    }

    /// What it came to in a trial; of a group what it came to for the member of whom it is worst, and who that is.
    pub fn cell(&self, trial: &TrialReport) -> String {
        let of = |index| Digest::new(self.metric, self.unit, &trial.outcomes, index).short();
        match self.worst_member(trial) {
            None => of(self.index),
            Some(member) => format!("{} {}", of(member.index), member.name),
        }
    }

    /// Of a group: the member of whom the verdict is worst; of those whose verdicts are alike, the one with the worst value in any run.
    fn worst_member(&self, trial: &TrialReport) -> Option<&MemberColumn<'_>> {
        let worse = |value: f64| if self.metric.worst == Worst::Smallest { -value } else { value };
        let worst = |member: &MemberColumn| {
            let values = trial.outcomes.iter().filter_map(|run| run.metrics[member.index]);
            values.map(worse).fold(f64::NEG_INFINITY, f64::max)
        };
        let key = |member: &MemberColumn| (verdict_on(trial, member.reference), worst(member));
        // The first of those that are equal.
        self.members.iter().reduce(|one, other| {
            let (known, new) = (key(one), key(other));
            if (new.0, new.1).partial_cmp(&(known.0, known.1)) == Some(Ordering::Greater) {
                other
            } else {
                one
            }
        })
    }

    /// The worst verdict of a trial on it.
    fn verdict(&self, trial: &TrialReport, requests: &Requests) -> Option<Verdict> {
        match &self.members[..] {
            [] => worst(trial, self.index, requests),
            members => members.iter().filter_map(|member| verdict_on(trial, member.reference)).max(),
        }
    }
}

/// The metrics that the criteria of these scenarios' trials are about, in the order of the trials; without criteria those that tell
/// most.
pub fn columns<'r>(scenarios: &'r [&ScenarioSummary], requests: &'r Requests) -> Vec<Column<'r>> {
    let mut columns: Vec<Column> = Vec::new();
    let mut applied: Vec<_> = scenarios.iter().flat_map(|scenario| &scenario.criteria).collect();
    applied.sort_by_key(|applied| applied.first);
    let criteria = || applied.iter().flat_map(|applied| &applied.criteria);
    let headlines = requests.iter().filter(|reference| HEADLINES.contains(&reference.name()));
    let headlines = headlines.filter(|_| criteria().next().is_none());
    for reference in criteria().map(|criterion| criterion.claim.metric()).chain(headlines) {
        if let (Some(index), Some(metric)) = (requests.index(reference), reference.known())
            && !columns.iter().any(|known| known.index == index)
        {
            let unit = written_unit(criteria(), reference, metric);
            columns.push(Column { index, metric, label: reference.label(), unit, members: Vec::new() });
        }
    }
    for written in of_groups(criteria(), requests) {
        let is_of = |column: &Column| written.members.iter().any(|member| member.index == column.index);
        let Some(place) = columns.iter().position(is_of) else { continue };
        let (metric, unit) = (columns[place].metric, columns[place].unit);
        columns.retain(|column| !is_of(column));
        columns.insert(
            place,
            Column {
                index: written.members[0].index,
                metric,
                label: written.label,
                unit,
                members: written.members,
            },
        );
    }
    columns
}

/// A criterion as it is written of a group, where it is one of each of the members.
pub struct OfGroup<'r> {
    /// `pet(av, walkers_1…5)`
    pub label: String,
    pub members: Vec<MemberColumn<'r>>,
}

/// Those criteria that are written once and hold of several people: what is judged of each of them stands at one place of the file.
pub fn of_groups<'r>(
    criteria: impl Iterator<Item = &'r Criterion>,
    requests: &'r Requests,
) -> Vec<OfGroup<'r>> {
    let mut written: Vec<(&Origin, Vec<(usize, &MetricReference)>)> = Vec::new();
    for criterion in criteria {
        let reference = criterion.claim.metric();
        let Some(index) = requests.index(reference) else { continue };
        match written.iter_mut().find(|(origin, _)| **origin == criterion.origin) {
            None => written.push((&criterion.origin, vec![(index, reference)])),
            Some((_, all)) if all.iter().any(|(known, _)| *known == index) => {}
            Some((_, all)) => all.push((index, reference)),
        }
    }
    written.into_iter().filter_map(|(_, all)| of_group(&all)).collect()
}

fn of_group<'r>(all: &[(usize, &'r MetricReference)]) -> Option<OfGroup<'r>> {
    let labels: Vec<String> = all.iter().map(|(_, reference)| reference.label()).collect();
    let [first, others @ ..] = &labels[..] else { return None };
    let alike = |one: &str, other: &str| one.chars().zip(other.chars()).take_while(|(a, b)| a == b).count();
    let shared = others.iter().map(|other| alike(first, other)).min()?;
    let begins = first.chars().take(shared).collect::<String>().rfind(['(', ' '])? + 1;
    let (before, rest) = first.split_at(begins);
    let after = &rest[rest.find([',', ')'])?..];
    let name = |label: &str| Some(label.strip_prefix(before)?.strip_suffix(after)?.to_string());
    let names: Vec<String> = labels.iter().map(|label| name(label)).collect::<Option<_>>()?;
    let numbered = |name: &String| {
        let (group, number) = name.rsplit_once('_')?;
        Some((group.to_string(), number.parse::<usize>().ok()?))
    };
    let numbered: Vec<(String, usize)> = names.iter().map(numbered).collect::<Option<_>>()?;
    let group = &numbered[0].0;
    if numbered.iter().any(|(other, _)| other != group) {
        return None;
    }
    let numbers: Vec<usize> = numbered.iter().map(|(_, number)| *number).collect();
    let follow = numbers.windows(2).all(|pair| pair[1] == pair[0] + 1);
    let said = match follow {
        true => format!("{}…{}", numbers[0], numbers[numbers.len() - 1]),
        false => numbers.iter().map(usize::to_string).collect::<Vec<_>>().join(","),
    };
    let label = format!("{before}{group}_{said}{after}");
    let members = all.iter().zip(names).map(|((index, reference), name)| MemberColumn {
        name,
        index: *index,
        reference,
    });
    Some(OfGroup { label, members: members.collect() })
}

/// The worst verdict on a metric.
fn verdict_on(trial: &TrialReport, reference: &MetricReference) -> Option<Verdict> {
    let TrialState::Judged(judged) = &trial.state else { return None };
    let verdicts = trial.trial.criteria.iter().zip(&judged.findings);
    let about = verdicts.filter(|(criterion, _)| criterion.claim.metric() == reference);
    about.map(|(_, finding)| finding.verdict).max()
}

/// Every scenario's table; scenarios without variations stand in one. Without `colour` plain text.
pub fn render_tables(report: &SuiteReport, requests: &Requests, colour: bool) -> String {
    let suite = report.identity.suite.as_str();
    let summary = report.summary();
    let mut held: HashMap<&str, Vec<&TrialReport>> = HashMap::new();
    for trial in report.trials.iter().filter(|trial| !trial.skipped()) {
        held.entry(&trial.trial.scenario).or_default().push(trial);
    }
    let mut held_of =
        |scenario: &ScenarioSummary| held.remove(scenario.scenario.as_str()).unwrap_or_default();
    let is_single = |scenario: &&ScenarioSummary| scenario.trials() == 1 && scenario.varied.is_empty();
    let (single, varied): (Vec<_>, Vec<_>) = summary.scenarios.iter().partition(is_single);
    let single_trials: Vec<_> = single.iter().flat_map(|scenario| held_of(scenario)).collect();
    let varied = varied.into_iter().map(|scenario| {
        let title = format!("{suite}/{}", scenario.scenario);
        table(&title, &[scenario], &held_of(scenario), requests, colour)
    });
    let mut tables: Vec<_> = varied.collect();
    tables.push(table(suite, &single, &single_trials, requests, colour));
    tables.retain(|table| !table.is_empty());
    tables.join("\n")
}

/// Of scenarios and those of their trials that were run and are held.
fn table(
    title: &str,
    scenarios: &[&ScenarioSummary],
    held: &[&TrialReport],
    requests: &Requests,
    colour: bool,
) -> String {
    let ran: usize = scenarios.iter().map(|scenario| scenario.ran()).sum();
    let crowded = ran > MOST_SHOWN;
    let not_passed = |trial: &&&TrialReport| !crowded || trial.verdict() != Some(Verdict::Passed);
    let rows: Vec<_> = held.iter().filter(not_passed).take(MOST_SHOWN).collect();
    let (Some(first), columns) = (scenarios.iter().find(|one| one.ran() > 0), columns(scenarios, requests))
    else {
        return String::new();
    };
    let names = &first.varied;
    let plain = Style::new();
    let muted = plain.dimmed();

    let mut lines: Vec<Vec<Cell>> = Vec::new();
    let headings = columns.iter().map(Column::heading);
    let (above, below): (Vec<_>, Vec<_>) = headings.unzip();
    let heading = |name: String, style: Style, labels: Vec<String>| -> Vec<Cell> {
        let labels = labels.iter().map(|label| Cell::new(label, style));
        [Cell::new(&name, style), Cell::empty()].into_iter().chain(labels).collect()
    };
    lines.push(heading(names.join(", "), plain.bold(), above));
    lines.push(heading(String::new(), muted, below));
    for trial in &rows {
        lines.push(row(trial, &columns, requests));
    }

    let widths: Vec<usize> = (0..columns.len() + 2)
        .map(|column| lines.iter().map(|line| line[column].text.chars().count()).max().unwrap_or(0))
        .collect();
    let bold = |text: &str| paint(text, plain.bold(), colour);
    let mut text = format!("{}\n", bold(&terminal_line(title)));
    for line in lines {
        let mut drawn = String::from(" ");
        for (column, (cell, width)) in line.iter().zip(&widths).enumerate() {
            let space = " ".repeat(width - cell.text.chars().count());
            let painted = paint(&cell.text, cell.style, colour);
            // Names and marks stand left, numbers right.
            drawn += &if column < 2 { format!(" {painted}{space} ") } else { format!("  {space}{painted}") };
        }
        text.push_str(drawn.trim_end());
        text.push('\n');
    }
    for call in closest_calls(scenarios) {
        text += &paint(&format!("  {call}"), muted, colour);
        text.push('\n');
    }
    if crowded {
        let standing = |standing| scenarios.iter().map(|one| one.standing(standing)).sum();
        let unjudged: usize = standing(Standing::NotJudged);
        let passed: usize = standing(Standing::Judged(Verdict::Passed));
        let hidden = ran - passed - unjudged - rows.len();
        let mut note = match (passed, unjudged) {
            (passed, 0) => format!("  {passed} of {ran} trials passed and are not shown"),
            (0, unjudged) => format!("  {unjudged} of {ran} trials were not judged and are not shown"),
            _ => format!(
                "  {passed} of {ran} trials passed, {unjudged} were not judged, and these are not shown"
            ),
        };
        if hidden > 0 {
            note += &format!(", nor are {hidden} that did not pass");
        }
        text += &paint(&note, muted, colour);
        text.push('\n');
    }
    text
}

struct Cell {
    text: String,
    style: Style,
}

impl Cell {
    fn new(text: &str, style: Style) -> Self {
        Self { text: terminal_line(text), style }
    }

    fn empty() -> Self {
        Self { text: String::new(), style: Style::new() }
    }
}

fn row(trial: &TrialReport, columns: &[Column], requests: &Requests) -> Vec<Cell> {
    let name = short_name(trial);
    let name = if name.is_empty() { trial.trial.scenario.clone() } else { name };
    let (mark, style) = match judged_words(trial).zip(trial.verdict()) {
        Some(((word, mark), _)) if trial.claims_nothing() => {
            (format!("{mark} {word}"), style(Verdict::Inconclusive))
        }
        Some(((word, mark), verdict)) => (format!("{mark} {word}"), style(verdict)),
        None if matches!(trial.state, TrialState::NotFinished(_)) => {
            ("■ not finished".into(), style(Verdict::Failed))
        }
        None => ("! error".into(), style(Verdict::Failed)),
    };
    let name = super::chart::shortened(&terminal_line(&name), WIDEST_LABEL);
    let mut cells = vec![Cell::new(&name, Style::new()), Cell::new(&mark, style)];
    for column in columns {
        let text = column.cell(trial);
        let bad = column.verdict(trial, requests).filter(|verdict| *verdict != Verdict::Passed);
        cells.push(Cell::new(&text, bad.map_or(Style::new(), self::style)));
    }
    cells
}

/// The worst verdict on the metric with this index.
fn worst(trial: &TrialReport, index: usize, requests: &Requests) -> Option<Verdict> {
    let TrialState::Judged(judged) = &trial.state else { return None };
    // Findings come in the order of the criteria.
    let verdicts = trial.trial.criteria.iter().zip(&judged.findings);
    let about = verdicts.filter(|(criterion, _)| requests.index(criterion.claim.metric()) == Some(index));
    about.map(|(_, finding)| finding.verdict).max()
}

pub(super) fn style(verdict: Verdict) -> Style {
    match verdict {
        Verdict::Passed => AnsiColor::Green.on_default(),
        Verdict::Inconclusive => AnsiColor::Yellow.on_default(),
        Verdict::Failed => AnsiColor::Red.on_default(),
    }
}

/// Text in a style, with nothing in it that a terminal would obey.
pub(super) fn paint(text: &str, style: Style, colour: bool) -> String {
    let text = terminal(text);
    if colour && !text.is_empty() { format!("{style}{text}{style:#}") } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Session;

    #[test]
    fn one_table_per_scenario() {
        let session = Session::new();
        insta::assert_snapshot!(render_tables(&session.report(), &session.requests, false));
    }

    #[test]
    fn colours_change_nothing_but_colours() {
        let session = Session::new();
        let report = session.report();
        let coloured = render_tables(&report, &session.requests, true);
        assert!(coloured.contains("\u{1b}[31m"));
        let mut stripped = String::new();
        let mut escape = false;
        for letter in coloured.chars() {
            match letter {
                '\u{1b}' => escape = true,
                'm' if escape => escape = false,
                _ if escape => {}
                _ => stripped.push(letter),
            }
        }
        assert_eq!(stripped, render_tables(&report, &session.requests, false));
    }
}
