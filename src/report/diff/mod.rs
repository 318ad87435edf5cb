//! Two runs on the same noise, side by side: where they part, what both came to, and the same as JSON.

mod against_baseline;
mod came_to;
mod course;
mod parts;
mod sides;

use serde_json::{Value, json};

use super::replay::RunReason;
use super::why::Standing;
use came_to::{criteria_lines, metrics};
use course::table;
use results::OneOfTwo;

pub use against_baseline::{BaselineDiff, baseline_diff_json, render_baseline_diff};
pub(crate) use came_to::{CriterionInBoth, criteria, metric_pairs};
pub(crate) use course::{contact_words, contacts, course, endings};
pub(crate) use parts::{by, partings};
pub(crate) use sides::LETTERS;
pub use sides::{DiffSide, RunDiff};

/// Two runs in words, in ten to thirty lines.
pub fn render_diff(run: &RunDiff) -> String {
    let mut text = String::new();
    let mut line = |content: &str| {
        text.push_str(content.trim_end());
        text.push('\n');
    };
    line(&format!("{}: {}", run.key, verdict(run.standings())));
    for (letter, side) in LETTERS.into_iter().zip(&run.sides) {
        let is_named = side.case.key != run.key;
        let named = if is_named { format!("  (as {})", side.case.key) } else { String::new() };
        line(&format!("  {letter}  {}{named}", side.otherwise));
    }
    line(&format!("  both with {}", shared(run)));
    if !run.two.differs.is_empty() {
        line(&format!("  what they are made of differs in {}", run.two.differs.join("; ")));
    }
    partings(run).iter().for_each(|(said, _)| line(&format!("  {said}")));
    table(run).iter().for_each(|row| line(&format!("  {row}")));
    line(&format!("  {}", contacts(run.two)));
    line(&format!("  {}", endings(run.outcomes())));
    criteria_lines(&run.reasons()).iter().for_each(|said| line(&format!("  {said}")));
    metrics(run).iter().for_each(|said| line(&format!("  {said}")));
    run.remarks.iter().for_each(|remark| line(&format!("  {remark}")));
    text
}

/// How a run stands, after its name.
fn alone(standing: Standing) -> &'static str {
    match standing {
        Standing::Failed => "fails",
        Standing::SpokenAgainst => "speaks against what its trial is to have",
        Standing::CutOff => "ends before somebody was met",
        Standing::Passed => "passes",
        Standing::NotJudged => "has nothing asked of it",
    }
}

/// Whether the verdict of the run changes.
pub(crate) fn verdict([a, b]: [Standing; 2]) -> String {
    match a == b {
        true => format!("the verdict is the same, each {}", alone(a)),
        false => format!("the verdict changes, A {}, B {}", alone(a), alone(b)),
    }
}

/// What both have alike: values, people and the seed.
pub(crate) fn shared(run: &RunDiff) -> String {
    let [a, b] = &run.sides;
    let both = a.values.iter().filter(|one| b.values.contains(one));
    let mut said: Vec<String> = both.map(|(name, value)| format!("{name} {value}")).collect();
    let people = a.case.individuals.iter().filter(|one| b.case.individuals.contains(one));
    said.extend(
        people.map(|one| format!("{} is individual {} of {}", one.pedestrian, one.number, one.population)),
    );
    said.push(format!("seed {}", a.case.seed));
    said.join(", ")
}

fn reason_json(one: &RunReason) -> Value {
    json!({ "criterion": one.criterion, "standing": one.verb.to_lowercase(), "words": one.words, "time": one.time })
}

/// The same as JSON: SI units, everything.
pub fn diff_json(run: &RunDiff) -> Value {
    let ([a, b], standings) = (run.reasons(), run.standings());
    let side = |index: usize, one: &OneOfTwo, reasons: &[RunReason]| {
        let DiffSide { otherwise, case, values, .. } = &run.sides[index];
        let values: serde_json::Map<String, Value> =
            values.iter().map(|(name, value)| (name.clone(), value.clone().into())).collect();
        let criteria: Vec<Value> = reasons.iter().map(reason_json).collect();
        json!({
            "otherwise": otherwise,
            "key": case.key,
            "values": values,
            "individuals": case.individuals,
            "fingerprint": format!("{:016x}", one.outcome.fingerprint),
            "standing": standings[index].word(),
            "ending": one.outcome.ending,
            "cut_off": one.outcome.cut_off,
            "contacts": one.contacts,
            "criteria": criteria,
        })
    };
    let metrics: Vec<Value> = metric_pairs(run)
        .iter()
        .map(|pair| {
            json!({
                "metric": pair.reference.label(),
                "a": pair.values[0],
                "b": pair.values[1],
                "decided": { "a": pair.decided[0], "b": pair.decided[1] },
                "same": pair.is_same(),
            })
        })
        .collect();
    json!({
        "layout": 1,
        "key": run.key,
        "seed": run.sides[0].case.seed,
        "same": run.two.are_one(),
        "verdict_changes": standings[0] != standings[1],
        "differs": run.two.differs,
        "parts": run.two.first,
        "parts_visibly": run.two.apart,
        "a": side(0, &run.two.a, &a),
        "b": side(1, &run.two.b, &b),
        "moments": run.two.moments,
        "metrics": metrics,
        "remarks": run.remarks,
    })
}
