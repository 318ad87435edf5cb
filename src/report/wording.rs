//! What findings and comparisons say, in parts for tables and charts, each number with its unit.

use std::collections::HashSet;

use super::TrialReport;
use super::chart::Rule;
use super::format::{quantity, share};
use crate::judge::{Finding, Measure, Reason, Stopping, Vacuity, Verdict, WorstRun};
use crate::metrics::{self, MetricKind};
use crate::scenario::{Comparison, Relation, significant};

/// What was found: `holds in 18 of 20 runs`, `85 %`, `1.62 s`; `–` if no run has a value.
pub fn observed(finding: &Finding) -> String {
    match (finding.measure, finding.observed) {
        (Measure::EveryRun, _) => format!("holds in {} of {} runs", finding.holding, finding.runs),
        (_, None) => "–".to_string(),
        (Measure::Share, Some(value)) => share(value),
        (Measure::Count, Some(value)) => format!("{value} of {} runs", finding.runs),
        (Measure::Value, Some(value)) => in_unit(finding, value),
    }
}

/// What it was compared to.
pub fn bound(finding: &Finding) -> String {
    match finding.measure {
        Measure::EveryRun => "every run".to_string(),
        Measure::Share => share(finding.bound),
        Measure::Count => significant(finding.bound, 4),
        Measure::Value => in_unit(finding, finding.bound),
    }
}

/// The interval of the estimate, such as `[71 %, 94 %]`.
pub fn interval(finding: &Finding) -> Option<String> {
    let (low, high) = finding.interval?;
    let show = |value| match finding.measure {
        Measure::EveryRun | Measure::Share => share(value),
        Measure::Count => significant(value, 4),
        Measure::Value => in_unit(finding, value),
    };
    Some(format!("[{}, {}]", show(low), show(high)))
}

/// How far from failing, with its sign: `+0.12 s`, `-5 points`.
pub fn margin(finding: &Finding) -> Option<String> {
    let margin = finding.margin?;
    let size = match finding.measure {
        Measure::Share => format!("{} points", significant(margin.abs() * 100.0, 3)),
        Measure::Count => format!("{} runs", significant(margin.abs(), 4)),
        Measure::EveryRun | Measure::Value => in_unit(finding, margin.abs()),
    };
    Some(signed(margin, size))
}

fn signed(margin: f64, size: String) -> String {
    format!("{}{size}", if margin < 0.0 { "-" } else { "+" })
}

/// A comparison with a constant bound: `pet < 1.5 s`, `no collision`, `passed_first = pedestrian`.
pub fn comparison_text(comparison: &Comparison) -> String {
    let (label, bound) = (comparison.metric.label(), comparison.constant_bound());
    let metric = metrics::metric(&comparison.metric.name);
    let flag = metric.is_some_and(|metric| metric.kind == MetricKind::Flag);
    match comparison.relation {
        Relation::Equal | Relation::NotEqual if flag => {
            let set = (bound != 0.0) == (comparison.relation == Relation::Equal);
            if set { label } else { format!("no {label}") }
        }
        relation => {
            let bound = metric.map_or_else(|| significant(bound, 4), |metric| quantity(metric, Some(bound)));
            format!("{label} {} {bound}", relation.symbol())
        }
    }
}

/// The bound of a comparison as a line in a chart of its metric.
pub fn comparison_rule(comparison: &Comparison) -> Rule {
    let sign = match comparison.relation {
        Relation::GreaterOrEqual => "≥",
        Relation::LessOrEqual => "≤",
        Relation::NotEqual => "≠",
        other => other.symbol(),
    };
    let bound = comparison.constant_bound();
    let shown = match metrics::metric(&comparison.metric.name) {
        Some(metric) if matches!(metric.kind, MetricKind::Quantity(_)) => quantity(metric, Some(bound)),
        _ => significant(bound, 4),
    };
    Rule { value: bound, label: format!("{sign} {shown}") }
}

/// Verdict, what was found, its interval and margin, and the run that is worst or nearest to failing.
pub fn in_words(finding: &Finding) -> String {
    let parts = [
        Some(format!("{}: {}", verdict_word(finding.verdict), observed(finding))),
        interval(finding),
        margin(finding).map(|margin| format!("margin {margin}")),
        nearest_run(finding),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// The run that speaks most against the criterion, or else comes nearest to that:
/// `closest: pet 1.92 s (+0.42 s) at 7.33 s, av and walker, in zebra/walk/rep=3`.
pub fn nearest_run(finding: &Finding) -> Option<String> {
    let worst = finding.worst.first().map(|run| ("worst", run));
    let (what, run) = worst.or(finding.closest.as_ref().map(|run| ("closest", run)))?;
    Some(format!("{what}: {}, in {}", run_in_words(finding, run), run.key))
}

/// What a run's metric was, how far from speaking against the criterion, when and for whom:
/// `pet 0.83 s (-0.67 s) at 7.33 s, av and walker`.
pub fn run_in_words(finding: &Finding, run: &WorstRun) -> String {
    let margin = run.margin.map(|margin| format!(" ({})", signed(margin, in_unit(finding, margin.abs()))));
    format!("{}{}{}", run_value(finding, run), margin.unwrap_or_default(), critical(run))
}

/// `pet 0.83 s`
pub fn run_value(finding: &Finding, run: &WorstRun) -> String {
    metrics::metric(&finding.metric).map_or_else(
        || "?".to_string(),
        |metric| format!("{} {}", finding.metric, quantity(metric, run.value)),
    )
}

/// Of the criteria that no run of these trials speaks against, the run that comes nearest to it:
/// `closest to \`pet >= 1.5 s\`: pet 1.92 s (+0.42 s) at 7.33 s, av and walker, in zebra/walk/rep=3`.
pub fn closest_calls(trials: &[&TrialReport]) -> Vec<String> {
    let mut criteria: Vec<(&str, Option<(&Finding, &WorstRun)>)> = Vec::new();
    for finding in trials.iter().flat_map(|trial| trial.findings()) {
        let closest = finding.closest.as_ref().map(|run| (finding, run));
        match criteria.iter_mut().find(|(criterion, _)| *criterion == finding.criterion) {
            None => criteria.push((&finding.criterion, closest)),
            Some((_, nearest)) => {
                let margin = |one: &(&Finding, &WorstRun)| one.1.margin.unwrap_or(f64::INFINITY);
                *nearest = nearest.zip(closest).map(
                    |(known, new)| {
                        if margin(&new) < margin(&known) { new } else { known }
                    },
                );
            }
        }
    }
    let said = criteria.into_iter().filter_map(|(criterion, nearest)| {
        let (finding, run) = nearest?;
        Some(format!("closest to `{criterion}`: {}, in {}", run_in_words(finding, run), run.key))
    });
    said.collect()
}

/// When and for whom a run's metric was what it was: ` at 7.33 s, av and walker`, ` of av`, or nothing.
fn critical(run: &WorstRun) -> String {
    let Some(critical) = &run.critical else { return String::new() };
    let who: Vec<&str> =
        [&critical.vehicle, &critical.pedestrian].into_iter().flatten().map(|name| &**name).collect();
    match (critical.time, who.join(" and ")) {
        (Some(time), who) if who.is_empty() => format!(" at {time:.2} s"),
        (Some(time), who) => format!(" at {time:.2} s, {who}"),
        (None, who) if who.is_empty() => String::new(),
        (None, who) => format!(" of {who}"),
    }
}

/// Why a trial whose runs are added until it is decided had so many of them.
pub fn stopping(stopping: &Stopping) -> String {
    let Stopping { runs, most, .. } = stopping;
    match stopping.reason {
        Reason::Decided => format!("decided after {runs} of at most {most} runs"),
        Reason::Budget => format!("not decided by all {runs} runs"),
        Reason::NothingToDecide => format!("ended after {runs} runs, as no criterion has a confidence"),
    }
}

/// The criteria of a trial that passed without being put to the test, to be warned of:
/// `\`pet >= 1.5 s\` passed untested: nobody came into a vehicle's lane in any of 20 runs`.
pub fn untested(findings: &[Finding]) -> Vec<String> {
    let reasons = [
        (Vacuity::NobodyAppeared, "no pedestrian appeared"),
        (Vacuity::NobodyEntered, "no pedestrian came into a vehicle's lane"),
    ];
    let said = reasons.iter().filter_map(|(reason, what)| {
        let vacuous: Vec<_> = findings.iter().filter(|one| one.vacuous == Some(*reason)).collect();
        let mut criteria: Vec<_> = vacuous.iter().map(|one| format!("`{}`", one.criterion)).collect();
        // What a scenario and a claim about it both state is still one criterion.
        let mut named = HashSet::new();
        criteria.retain(|criterion| named.insert(criterion.clone()));
        let runs = match vacuous.first()?.runs {
            1 => "the run".to_string(),
            runs => format!("any of {runs} runs"),
        };
        Some(format!("{} passed untested: {what} in {runs}", criteria.join(", ")))
    });
    said.collect()
}

/// One word.
pub fn verdict_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Passed => "passed",
        Verdict::Inconclusive => "inconclusive",
        Verdict::Failed => "failed",
    }
}

/// One letter that needs no colour.
pub fn verdict_mark(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Passed => "✓",
        Verdict::Inconclusive => "?",
        Verdict::Failed => "✗",
    }
}

/// A value in the unit of the finding's metric. Differences and aggregates of flags are shares of runs.
fn in_unit(finding: &Finding, value: f64) -> String {
    match metrics::metric(&finding.metric) {
        Some(metric) if matches!(metric.kind, metrics::MetricKind::Quantity(_)) => {
            quantity(metric, Some(value))
        }
        _ => significant(value, 4),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{MetricReference, Settings, WhenUndefined};

    #[test]
    fn comparisons_read_as_they_are_written() {
        let text = |name: &str, relation, bound: f64| {
            let metric = MetricReference { name: name.into(), settings: Settings::default(), pair: None };
            let when_undefined = WhenUndefined::Fails;
            comparison_text(&Comparison { metric, relation, bound: bound.into(), when_undefined })
        };
        assert_eq!(text("pet", Relation::Less, 1.5), "pet < 1.5 s");
        assert_eq!(text("collision", Relation::Equal, 0.0), "no collision");
        assert_eq!(text("collision", Relation::NotEqual, 0.0), "collision");
        assert_eq!(text("passed_first", Relation::Equal, 1.0), "passed_first = pedestrian");
    }
}
