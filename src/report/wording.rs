//! What a finding says, in parts for tables: observed, bound, interval and margin, each with its unit.

use super::format::{quantity, share};
use crate::judge::{Finding, Measure, Verdict};
use crate::metrics;
use crate::scenario::significant;

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
    Some(format!("{}{size}", if margin < 0.0 { "-" } else { "+" }))
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
