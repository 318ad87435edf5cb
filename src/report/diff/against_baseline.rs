//! A run beside what a baseline keeps of it, in words and as JSON.

use serde_json::{Value, json};

use super::came_to::{MetricPair, metric_lines};
use super::{DiffSide, alone, reason_json};
use crate::replay::run_reasons;
use crate::why::Standing;
use results::{AgainstBaseline, MetricThen, Outcome, Requests};
use scenario::Criterion;

/// A run beside what a baseline keeps of it.
pub struct BaselineDiff<'a> {
    /// The baseline's file.
    pub baseline: &'a str,
    /// The run as it is now.
    pub now: DiffSide<'a>,
    /// What it came to now.
    pub outcome: &'a Outcome,
    /// What is measured in it now.
    pub requests: &'a Requests,
    /// What is not the same.
    pub against: &'a AgainstBaseline,
    /// What has to be known besides, a sentence each.
    pub remarks: &'a [String],
}

impl BaselineDiff<'_> {
    fn pairs(&self) -> Vec<MetricPair<'_>> {
        let pair = |one: &MetricThen| {
            let reference = &self.requests.as_slice()[one.index];
            // Whether what was then was decided is not kept, so that it is said of neither.
            let (values, decided) = ([one.then, one.now], [true; 2]);
            Some(MetricPair { reference, metric: reference.known()?, values, decided })
        };
        self.against.metrics.iter().filter_map(pair).collect()
    }
}

/// A run beside what a baseline keeps of it, in words.
pub fn render_baseline_diff(run: &BaselineDiff) -> String {
    let mut text = String::new();
    let mut line = |content: &str| {
        text.push_str(content.trim_end());
        text.push('\n');
    };
    let BaselineDiff { against, now, outcome, .. } = run;
    let reasons = run_reasons(now.criteria, outcome, run.requests);
    line(&format!("{}: now {}", now.case.key, alone(Standing::of(&reasons, outcome))));
    line(&format!(
        "  A  as {} keeps it: its metrics with nine digits, no course and no verdict",
        run.baseline
    ));
    line(&format!(
        "  B  now{}",
        if now.otherwise.is_empty() { String::new() } else { format!(", {}", now.otherwise) }
    ));
    let mut values: Vec<String> = now.values.iter().map(|(name, value)| format!("{name} {value}")).collect();
    values.push(format!("seed {}", now.case.seed));
    line(&format!("  with {}", values.join(", ")));
    match against.differs.is_empty() {
        true => line("  made of the same as then"),
        false => line(&format!("  what it is made of differs in {}", against.differs.join("; "))),
    }
    line(match against.same_course {
        Some(true) => "  the course is the same, bit for bit",
        Some(false) => "  the course is another; where they part is not kept",
        None => {
            "  whether the course is the same cannot be told: the baseline keeps one number for the courses of all runs of the trial"
        }
    });
    for reason in &reasons {
        line(&format!("  `{}`: now {}, {}", reason.criterion, reason.verb, reason.words));
    }
    let criteria: Vec<&Criterion> = now.criteria.iter().collect();
    metric_lines(&run.pairs(), &criteria).iter().for_each(|said| line(&format!("  {said}")));
    if !against.new.is_empty() {
        line(&format!("  not in the baseline, or measured otherwise: {}", against.new.join(", ")));
    }
    run.remarks.iter().for_each(|remark| line(&format!("  {remark}")));
    text
}

/// The same as JSON.
pub fn baseline_diff_json(run: &BaselineDiff) -> Value {
    let BaselineDiff { against, now, outcome, .. } = run;
    let reasons = run_reasons(now.criteria, outcome, run.requests);
    let metrics: Vec<Value> = run
        .pairs()
        .iter()
        .map(|pair| json!({ "metric": pair.reference.label(), "a": pair.values[0], "b": pair.values[1], "same": pair.is_same() }))
        .collect();
    json!({
        "layout": 1,
        "key": now.case.key,
        "seed": now.case.seed,
        "baseline": run.baseline,
        "same_course": against.same_course,
        "differs": against.differs,
        "standing": Standing::of(&reasons, outcome).word(),
        "criteria": reasons.iter().map(reason_json).collect::<Vec<_>>(),
        "metrics": metrics,
        "not_in_baseline": against.new,
        "remarks": run.remarks,
    })
}
