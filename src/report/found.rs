//! What a search found, for the terminal: everybody, or of many people how it spreads and who has it worst.

use std::fmt::Write;

use super::columns::columns;
use super::shown_value::{WITHOUT_VALUE, value};
use super::usual::{render_usual, tail_text, who};
use super::wording::{run_value, verdict_word};
use numbers::summary::quantile;
use results::{Finding, Found, JudgedRun, NO_ENCOUNTER, SearchResult};
use scenario::{Goal, ShownIn};

/// Up to this many people each have a line.
const MOST_LINES: usize = 20;
/// How many of more people have one: the worst.
const WORST: usize = 10;
/// What is said of the others.
const LEVELS: [(&str, f64); 5] =
    [("smallest", 0.0), ("10 %", 0.1), ("median", 0.5), ("90 %", 0.9), ("largest", 1.0)];

/// One line per person: where the worst is, what was seen there, what is believed, and what fresh seeds give. Of many people
/// the quantiles over all of them and the worst ten, on fresh seeds.
pub fn render_search(result: &SearchResult) -> String {
    let mut text = format!("search {}: {}\n", result.name, result.objective);
    if result.found.len() <= MOST_LINES {
        text += &people(result, &result.found.iter().collect::<Vec<_>>());
    } else {
        text += &spread(result);
        let worst = worst(result);
        let (shown, all) = (worst.len(), result.found.len());
        writeln!(
            text,
            "the worst {shown} of {all} on fresh seeds; everybody is in the HTML and JSON reports:"
        )
        .expect(STRING);
        text += &people(result, &worst);
    }
    let evaluations = || result.found.iter().flat_map(|found| &found.evaluations);
    let unknown = evaluations().filter(|(_, value)| value.is_none()).count();
    if unknown > 0 {
        let all = evaluations().count();
        writeln!(text, "{unknown} of {all} evaluations have no value: {WITHOUT_VALUE}").expect(STRING);
    }
    text += &left_out_words(result).map_or_else(String::new, |said| format!("{said}\n"));
    text += &kept(result);
    text += &judged(result);
    text += &render_usual(result);
    text
}

/// Runs against what the search expects, those that did not pass first; with how much of that is left with fresh seeds.
fn judged(result: &SearchResult) -> String {
    let Some(judged) = &result.judged else { return String::new() };
    let mut text = match (judged.runs.is_empty(), judged.of_kept) {
        (true, _) => format!("{}\n", judged.nothing()),
        (_, true) => "expected of what was kept, run by run:\n".to_string(),
        (_, false) => "nothing was kept; expected of the best observed, run by run:\n".to_string(),
    };
    let mut runs: Vec<&JudgedRun> = judged.runs.iter().collect();
    runs.sort_by_key(|run| std::cmp::Reverse(run.verdict()));
    for run in runs.iter().take(MOST_LINES) {
        let said = run.findings.iter().map(said).collect::<Vec<_>>().join("; ");
        let (holding, of) = (run.fresh_holding, run.fresh_runs);
        writeln!(text, "  {said}; holds in {holding} of {of} runs with fresh seeds").expect(STRING);
        writeln!(text, "    {}", run.key).expect(STRING);
    }
    if runs.len() > MOST_LINES {
        writeln!(text, "  and {} more", runs.len() - MOST_LINES).expect(STRING);
    }
    text
}

/// A criterion with what became of it in the run: `pet >= 1.5 s failed (pet 0 s)`.
pub(super) fn said(finding: &Finding) -> String {
    let run = finding.worst.first().or(finding.closest.as_ref());
    let value = run.map(|run| format!(" ({})", run_value(finding, run))).unwrap_or_default();
    let untested = if finding.untested.is_some() { ", untested" } else { "" };
    format!("`{}` {}{value}{untested}", finding.criterion, verdict_word(finding.verdict))
}

/// How many runs of evaluations are left out, if any is.
pub(super) fn left_out_words(result: &SearchResult) -> Option<String> {
    (result.left_out > 0).then(|| {
        let runs =
            if result.left_out == 1 { "1 run is".into() } else { format!("{} runs are", result.left_out) };
        format!("{runs} left out, since there is no such encounter: {NO_ENCOUNTER}")
    })
}

/// How many runs at the worst points are kept, of how many.
fn kept(result: &SearchResult) -> String {
    // Of whom nothing was found there is no run.
    let runs: usize = result.found.iter().map(|found| found.kept.len().max(1)).sum();
    let what = if runs == result.found.len() { "" } else { " runs" };
    format!("{} of {runs}{what} kept\n", result.kept.cases.len())
}

fn people(result: &SearchResult, found: &[&Found]) -> String {
    let headings = ["", "where", "observed", "model", "fresh seeds", "first", "evaluations"];
    let mut lines = vec![headings.map(String::from).to_vec()];
    if says_plausibility(result) {
        lines[0].push("plausibility".into());
    }
    lines.extend(found.iter().map(|found| line(result, found)));
    columns(&lines)
}

/// Whether of somebody it is known how usual they are.
fn says_plausibility(result: &SearchResult) -> bool {
    result.found.iter().any(|found| found.plausibility.is_some())
}

fn line(result: &SearchResult, found: &Found) -> Vec<String> {
    let point = found.best.iter().flatten().enumerate();
    let point = point.map(|(index, (name, at))| format!("{name} {}", value(result.shown_in.get(index), at)));
    let unit = &result.objective_in;
    let of_objective = |value: Option<f64>| value.map_or("–".into(), |value| unit.show(value));
    let mut line = vec![
        who(found),
        point.collect::<Vec<_>>().join(", "),
        of_objective(found.observed),
        found
            .predicted
            .map_or("–".into(), |(mean, sd)| format!("{} ± {}", unit.number(mean), unit.show(sd))),
        format!("{} ({})", of_objective(found.fresh), found.fresh_runs),
        found.passed_first.as_deref().unwrap_or("–").to_string(),
        found.evaluations.len().to_string(),
    ];
    if says_plausibility(result) {
        line.push(found.plausibility.map_or("–".into(), tail_text));
    }
    line
}

/// Quantiles over everybody of what each line says, and how many were first.
fn spread(result: &SearchResult) -> String {
    let found = &result.found;
    let mut lines = vec![vec![String::new()]];
    lines[0].extend(LEVELS.iter().map(|(name, _)| (*name).to_string()));
    lines[0].push("people".into());
    let mut row = |name: &str, unit: &ShownIn, values: Vec<f64>| {
        let mut sorted = values;
        sorted.sort_by(f64::total_cmp);
        let mut line = vec![name.to_string()];
        let shown = |value: Option<f64>| value.map_or("–".to_string(), |value| unit.show(value));
        line.extend(LEVELS.iter().map(|(_, level)| shown(quantile(&sorted, *level))));
        line.push(sorted.len().to_string());
        lines.push(line);
    };
    let names = found.iter().find_map(|one| one.best.as_ref()).into_iter().flatten();
    for (index, (name, _)) in names.enumerate() {
        let values = found.iter().filter_map(|one| one.best.as_ref()?.get(index)?.1.number());
        let values: Vec<f64> = values.collect();
        // Words have no quantiles.
        if !values.is_empty() {
            row(name, result.shown_in.get(index).unwrap_or(&ShownIn::default()), values);
        }
    }
    let unit = &result.objective_in;
    row("observed", unit, found.iter().filter_map(|one| one.observed).collect());
    row("model", unit, found.iter().filter_map(|one| Some(one.predicted?.0)).collect());
    row("fresh seeds", unit, found.iter().filter_map(|one| one.fresh).collect());
    if says_plausibility(result) {
        let unit = ShownIn::new(None, "%");
        row("plausibility", &unit, found.iter().filter_map(|one| one.plausibility).collect());
    }
    let mut text = columns(&lines);
    let mut first: Vec<(&str, usize)> = Vec::new();
    for who in found.iter().map(|one| one.passed_first.as_deref().unwrap_or("nobody")) {
        match first.iter_mut().find(|(name, _)| *name == who) {
            Some((_, count)) => *count += 1,
            None => first.push((who, 1)),
        }
    }
    first.sort_by_key(|(who, count)| (std::cmp::Reverse(*count), *who));
    let first: Vec<_> = first.iter().map(|(who, count)| format!("{who} {count}")).collect();
    writeln!(text, "first at the conflict point: {}", first.join(", ")).expect(STRING);
    text
}

/// The worst people, the very worst first, by what fresh seeds say, or else what was observed.
fn worst(result: &SearchResult) -> Vec<&Found> {
    let badness = |found: &Found| {
        let value = found.fresh.or(found.observed)?;
        Some(match result.direction {
            Goal::Minimise => value,
            Goal::Maximise => -value,
        })
    };
    let mut ranked: Vec<(f64, &Found)> =
        result.found.iter().filter_map(|found| Some((badness(found)?, found))).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked.into_iter().take(WORST).map(|(_, found)| found).collect()
}

const STRING: &str = "writing to a string cannot fail";

#[cfg(test)]
mod tests {
    use super::super::fixture::{person, search_result};
    use super::*;
    use optimise::Coordinate;

    /// A search over `count` people; person 7 has the smallest value on fresh seeds, person 9 nothing at all.
    fn over(count: u32) -> SearchResult {
        let mut result = search_result();
        let one = |number: u32| {
            let mut found = result.found[0].clone();
            let value = f64::from((number * 37 + 40) % 101) / 20.0;
            found.individuals = vec![person(number)];
            found.best = Some(vec![("tta".into(), Coordinate::Real(6.0 + value))]);
            (found.observed, found.predicted) = (Some(value), Some((value + 0.5, 0.1)));
            found.fresh = Some(if number == 7 { 0.125 } else { value + 0.625 });
            let first = if number.is_multiple_of(3) { "vehicle" } else { "pedestrian" };
            found.passed_first = Some(first.into());
            if number == 9 {
                (found.best, found.observed, found.predicted, found.fresh) = (None, None, None, None);
                (found.passed_first, found.fresh_runs) = (None, 0);
            }
            found
        };
        result.found = (1..=count).map(one).collect();
        result
    }

    #[test]
    fn few_people_each_have_a_line() {
        let text = render_search(&over(20));
        // One evaluation of each has no value, which is a line of its own.
        assert_eq!(text.lines().count(), 1 + 1 + 20 + 1 + 1, "{text}");
        assert!(text.contains("20 of 60 evaluations have no value: "), "{text}");
    }

    #[test]
    fn runs_that_are_kept_are_counted_among_runs() {
        let said = |kept: &[bool]| {
            let mut result = over(20);
            for found in &mut result.found {
                found.runs = vec![found.runs[0].clone(); kept.len()];
                found.kept = kept.to_vec();
            }
            // Of whom nothing was found.
            (result.found[8].runs, result.found[8].kept) = (Vec::new(), Vec::new());
            result.kept.cases = result.found.iter().flat_map(Found::kept_cases).cloned().collect();
            render_search(&result)
        };
        assert!(said(&[true]).contains("\n19 of 20 kept\n"));
        assert!(said(&[true, false, true]).contains("\n38 of 58 runs kept\n"));
    }

    #[test]
    fn of_many_people_the_spread_and_the_worst_are_shown() {
        insta::assert_snapshot!(render_search(&over(100)));
    }

    #[test]
    fn the_worst_are_the_largest_where_the_search_maximises() {
        let mut result = over(100);
        let numbers = |result: &SearchResult| {
            worst(result).iter().map(|found| found.individuals[0].number).collect::<Vec<_>>()
        };
        let smallest = numbers(&result);
        assert_eq!((smallest[0], smallest.len()), (7, 10));
        result.direction = Goal::Maximise;
        let largest = numbers(&result);
        let fresh = |number: u32| result.found[number as usize - 1].fresh.unwrap();
        assert!(largest.windows(2).all(|pair| fresh(pair[0]) >= fresh(pair[1])), "{largest:?}");
        assert!(!largest.contains(&7) && !largest.contains(&9));
    }
    #[test]
    fn how_usual_somebody_is_stands_there_where_it_is_known() {
        let mut result = over(3);
        assert!(!render_search(&result).contains("plausibility"), "nothing is known of anybody");
        (result.found[0].plausibility, result.found[2].plausibility) = (Some(0.034), Some(0.5));
        let text = render_search(&result);
        let ends: Vec<&str> = text.lines().skip(1).take(4).map(str::trim_end).collect();
        for (line, end) in ends.iter().zip(["plausibility", "3.4 %", "–", "50 %"]) {
            assert!(line.ends_with(end), "{text}");
        }
        let texts = [0.0, 0.0004, 0.034, 0.5, 1.0].map(tail_text);
        assert_eq!(texts, ["0 %", "< 0.1 %", "3.4 %", "50 %", "100 %"]);
    }
}
