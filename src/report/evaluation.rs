//! What evaluations measured, for the terminal: a row per condition, the source's row below it.

use std::fmt::Write;

use super::columns::columns;
use super::format::in_written_unit;
use super::wording::untested_words;
use results::judge::cut_off_runs;
use results::{ConditionResult, Difference, EvaluateResult, ParameterValue, UntestedMeasures};
use scenario::{Aggregate, Notation, Target};

const STRING: &str = "writing to a string cannot fail";

/// The unit that somebody wrote, and the SI unit.
type Unit = (Option<Notation>, String);

fn show(value: f64, (written, unit): &Unit) -> String {
    in_written_unit(value, *written, unit)
}

/// The table of conditions: what was measured, by how much more than in the first condition, and what a source reports.
pub fn render_evaluate(result: &EvaluateResult) -> String {
    let mut text = format!("evaluate {}: {} cases, ", result.name, result.cases);
    text += &match result.fresh {
        0 => "each once under its own seed\n".to_string(),
        1 => "each once under a fresh seed\n".to_string(),
        runs => format!("each {runs} times under fresh seeds\n"),
    };
    let units: Vec<Unit> =
        result.measures.iter().map(|measure| (measure.notation, measure.aggregate.unit())).collect();
    let parameters = result.conditions.iter().map(|one| &one.parameters).find(|all| !all.is_empty());
    let parameters: Vec<String> = parameters.into_iter().flatten().map(heading).collect();
    let mut headings = vec![String::new()];
    headings.extend(parameters.iter().cloned());
    headings.extend(result.measures.iter().map(|measure| measure.text.clone()));
    let mut lines = vec![headings];
    let unset = || vec![String::new(); parameters.len()];
    let reported = |values: &[f64]| {
        let values = values.iter().zip(&units).map(|(value, unit)| show(*value, unit));
        ["  reported".to_string()].into_iter().chain(unset()).chain(values).collect()
    };
    for condition in &result.conditions {
        lines.push(measured(condition, parameters.len(), &units));
        if let Some(values) = &condition.reported {
            lines.push(reported(values));
        }
        if condition.differences.iter().any(Option::is_some) {
            let changes =
                condition.differences.iter().zip(&units).map(|(one, unit)| change(one.as_ref(), unit));
            lines.push(["  change".to_string()].into_iter().chain(unset()).chain(changes).collect());
        }
    }
    text += &columns(&lines);
    for condition in &result.conditions {
        if let Some(reason) = &condition.missing {
            writeln!(text, "  {} was not run: {reason}", condition.name).expect(STRING);
        }
        if let Some(caveat) = &condition.caveat {
            writeln!(text, "  {} is {caveat}", condition.name).expect(STRING);
        }
    }
    for line in without_value(result) {
        writeln!(text, "  {line}").expect(STRING);
    }
    if let [first, _, ..] = result.conditions.as_slice() {
        let (first, pairs) = (&first.name, "case by case, with an interval at 95 % where there is one");
        writeln!(text, "  change: from {first}, {pairs}").expect(STRING);
    }
    if let Some(source) = &result.source {
        writeln!(text, "  reported: {source}").expect(STRING);
    }
    text
}

/// In how many runs a measure has no value: `mean(pet) of default: no value in 3 of 40 runs, …`; and in how many
/// what it measures was not over.
pub fn without_value(result: &EvaluateResult) -> Vec<String> {
    let of = |condition: &'_ ConditionResult| {
        let measures = result.measures.iter().zip(&condition.undecided).zip(&condition.measured);
        let said = measures.filter(|((_, undecided), _)| **undecided > 0);
        said.map(|((measure, undecided), value)| {
            let counted = match (&measure.aggregate, value) {
                (Aggregate::Rate(_) | Aggregate::Count(_), _) => "which count as their comparison says",
                (_, Some(_)) => "which count as what is worst for it, or not at all where nothing is worse",
                (_, None) => "which could be as bad as anything",
            };
            let (name, runs) = (&condition.name, condition.runs.len());
            format!("{} of {name}: no value in {undecided} of {runs} runs, {counted}", measure.text)
        })
        .collect::<Vec<_>>()
    };
    let cut_off = |condition: &'_ ConditionResult| {
        let said = result.measures.iter().filter_map(|measure| {
            let outcomes = condition.runs.iter().map(|run| &run.outcome);
            let cut_off = cut_off_runs(measure.aggregate.metric(), outcomes);
            let (name, runs) = (&condition.name, condition.runs.len());
            (cut_off > 0).then(|| {
                format!(
                    "{} of {name}: {cut_off} of {runs} runs were cut off before the encounter was over",
                    measure.text
                )
            })
        });
        said.collect::<Vec<_>>()
    };
    let untested = result.untested().into_iter().map(|UntestedMeasures { condition, measures, reason }| {
        format!("{} of {condition}: untested: {}", measures.join(", "), untested_words(&reason))
    });
    let notes = result.conditions.iter().flat_map(|one| [of(one), cut_off(one)].concat());
    notes.chain(untested).collect()
}

fn measured(condition: &ConditionResult, parameters: usize, units: &[Unit]) -> Vec<String> {
    let mut line = vec![condition.name.clone()];
    line.extend(condition.parameters.iter().map(setting));
    line.resize(1 + parameters, "–".to_string());
    let values = condition.measured.iter().zip(units);
    line.extend(values.map(|(value, unit)| value.map_or("–".to_string(), |value| show(value, unit))));
    line
}

fn heading(parameter: &ParameterValue) -> String {
    match &parameter.target {
        Target::Variation(name) => name.clone(),
        Target::Setting { parameter, .. } => parameter.clone(),
    }
}

fn setting(parameter: &ParameterValue) -> String {
    match &parameter.value {
        None => if parameter.varies { "varies" } else { "not set" }.to_string(),
        Some(value) => match value.as_number() {
            Some(number) => in_written_unit(number, parameter.notation, &parameter.unit),
            None => value.to_string(),
        },
    }
}

/// Such as `+2.5 s [2.1, 2.9]`.
fn change(difference: Option<&Difference>, unit: &Unit) -> String {
    let Some(Difference { value, interval, .. }) = difference else { return "–".to_string() };
    let sign = if *value > 0.0 { "+" } else { "" };
    let mut text = format!("{sign}{}", show(*value, unit));
    if let Some(interval) = interval {
        let symbol = unit.0.as_ref().map_or(unit.1.as_str(), |written| written.symbol.as_str());
        let bare = |value: f64| show(value, unit).trim_end_matches(symbol).trim_end().to_string();
        write!(text, " [{}, {}]", bare(interval.low), bare(interval.high)).expect(STRING);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::evaluation;
    use numbers::inference::Interval;

    #[test]
    fn conditions_stand_above_what_is_reported_of_them() {
        insta::assert_snapshot!(render_evaluate(&evaluation()));
    }

    #[test]
    fn changes_read_with_sign_and_interval() {
        let difference =
            |value, low, high| Difference { value, interval: Some(Interval { low, high }), pairs: 9 };
        let si = |unit: &str| (None, unit.to_string());
        assert_eq!(change(Some(&difference(2.5, 2.0, 3.0)), &si("s")), "+2.5 s [2, 3]");
        assert_eq!(change(Some(&difference(-0.66, -0.8, -0.5)), &si("%")), "-66 % [-80, -50]");
        assert_eq!(change(None, &si("s")), "–");
        let kmh = (
            Some(Notation { symbol: scenario::Symbol::new("km/h"), numerator: 5.0, denominator: 18.0 }),
            "m/s".to_string(),
        );
        assert_eq!(change(Some(&difference(2.5, 2.0, 3.0)), &kmh), "+9 km/h [7.2, 10.8]");
    }
}
