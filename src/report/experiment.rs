//! What the blocks of a suite came to, for the terminal; tunes, and tuned parameters as a file to `use`.

use std::fmt::Write;

use super::calibration::render_calibrate;
use super::columns::columns;
use super::estimation::render_estimate;
use super::evaluation::render_evaluate;
use super::found::render_search;
use super::shown_value::{WITHOUT_VALUE, digits, value};
use super::statement::render_statement;
use super::wording::untested_words;
use optimise::Coordinate;
use results::{BlockResult, Candidate, CandidateOrigin, MetricSummary, TuneResult, UntestedConstraint};
use scenario::{ShownIn, Tune};

/// A block's result in a few lines or a table.
pub fn render_block(result: &BlockResult) -> String {
    match result {
        BlockResult::Search(search) => render_search(search),
        BlockResult::Tune(tune) => render_tune(tune),
        BlockResult::Evaluate(evaluate) => render_evaluate(evaluate),
        BlockResult::Calibrate(calibrate) => render_calibrate(calibrate),
        BlockResult::Estimate(estimate) => render_estimate(estimate),
        BlockResult::Statement(statement) => render_statement(statement),
    }
}

/// The chosen candidate, or why there is none, with the table of before and after.
pub fn render_tune(result: &TuneResult) -> String {
    let mut text =
        format!("tune {}: {} over {} cases\n", result.name, result.objectives.join(", "), result.cases);
    if !result.constraints.is_empty() {
        writeln!(text, "  subject to {}", result.constraints.join(", ")).expect(STRING);
    }
    let (all, unknown) =
        (result.evaluations.len(), result.evaluations.iter().filter(|one| one.has_no_value()));
    let unknown = unknown.count();
    if unknown == all && result.nothing_chosen().is_some() {
        writeln!(text, "  no candidate has a value, {WITHOUT_VALUE}: nothing is chosen").expect(STRING);
        return text;
    }
    let feasible = result.evaluations.iter().filter(|candidate| candidate.feasible).count();
    writeln!(text, "  {feasible} of {all} candidates are feasible").expect(STRING);
    if unknown > 0 {
        writeln!(text, "  {unknown} that keep every constraint have no value: {WITHOUT_VALUE}")
            .expect(STRING);
    }
    if let Some(chosen) = &result.chosen {
        if let Some(violations) = &result.violations {
            writeln!(text, "  {violations}").expect(STRING);
        }
        writeln!(text, "  chosen: {}", candidate(result, chosen)).expect(STRING);
        writeln!(text, "  {}", against_declared(result)).expect(STRING);
    }
    if let Some(why) = result.nothing_chosen() {
        writeln!(text, "  {why}").expect(STRING);
    }
    for one in &result.pareto {
        let declared = match one.origin {
            CandidateOrigin::Declared if !one.point.is_empty() => "what is declared, ",
            _ => "",
        };
        writeln!(text, "  front: {declared}{}", candidate(result, one)).expect(STRING);
    }
    if let Some(broken) = result.broken_on_fresh_words() {
        writeln!(text, "  {broken}").expect(STRING);
    }
    for why in untested_constraints(result) {
        writeln!(text, "  {why}").expect(STRING);
    }
    if let Some(comparison) = &result.comparison {
        let headings = ["", "before", "after", "before, fresh", "after, fresh"];
        let mut lines = vec![headings.map(String::from).to_vec()];
        let tables = [&comparison.after, &comparison.before_fresh, &comparison.after_fresh];
        for (index, before) in comparison.before.iter().enumerate() {
            let unit = comparison.shown_in.get(index);
            let others = tables.map(|table| summary(&table[index], unit));
            let [after, before_fresh, after_fresh] = others;
            lines.push(vec![before.metric.clone(), summary(before, unit), after, before_fresh, after_fresh]);
        }
        text += &columns(&lines);
        text.push_str("  mean (min .. max) over the cases; fresh: the same cases with other seeds\n");
    }
    text
}

/// How what is chosen stands to the values that the scenarios declare.
pub fn against_declared(result: &TuneResult) -> String {
    let declared = result.evaluations.first().filter(|one| one.origin == CandidateOrigin::Declared);
    let unit = result.objectives_in.first();
    let shown = |value: f64| unit.map_or_else(|| digits(value), |unit| unit.show(value));
    match (declared, &result.change) {
        _ if result.keeps_declared() => "nothing better than what is declared".to_string(),
        (Some(declared), _) if declared.has_no_value() => "what is declared has no value".to_string(),
        (Some(declared), _) if !declared.feasible => "what is declared breaks a constraint".to_string(),
        (_, Some(change)) => {
            let way = if *change < 0.0 { "less" } else { "more" };
            format!("with fresh seeds {} {way} than what is declared", shown(change.abs()))
        }
        _ => "better than what is declared".to_string(),
    }
}

/// `impact_speed <= 3 m/s is kept untested: \`walker\` did not come into the way of \`av\` with fresh seeds`.
pub fn untested_constraints(result: &TuneResult) -> Vec<String> {
    let said = |UntestedConstraint { constraint, reason }: &UntestedConstraint| {
        format!("{constraint} is kept untested: with fresh seeds {}", untested_words(reason))
    };
    result.untested.iter().map(said).collect()
}

fn digits_in(unit: Option<&ShownIn>, value: f64) -> String {
    unit.map_or_else(|| digits(value), |unit| unit.number(value))
}

/// The chosen parameters as definitions for a scenario to `use`, each under its whole name with `_` for `.`: two road users may
/// have a parameter of one name. Empty but for the first line if nothing was chosen.
pub fn tuned_parameters(result: &TuneResult, tune: &Tune) -> String {
    let mut text = format!("# Found by `tune {}`: {}.\n", result.name, result.objectives.join(", "));
    if let Some(violations) = &result.violations {
        writeln!(text, "# {violations}").expect(STRING);
    }
    for (range, value) in tune.over.iter().zip(result.chosen.iter().flat_map(|chosen| &chosen.point)) {
        let name = range.target.identifier();
        let unit = if range.unit.is_empty() { String::new() } else { format!(" {}", range.unit) };
        writeln!(text, "let {name} = {value}{unit}    # {}", range.target).expect(STRING);
    }
    text
}

const STRING: &str = "writing to a string cannot fail";

fn candidate(result: &TuneResult, candidate: &Candidate) -> String {
    let point = result.parameters.iter().zip(&candidate.point).enumerate();
    let shown = |(index, (name, at)): (usize, (&String, &Coordinate))| {
        format!("{name} {}", value(result.shown_in.get(index), at))
    };
    let point: Vec<_> = point.map(shown).collect();
    let all = |values: &[Option<f64>], shown_in: &[ShownIn]| -> Vec<String> {
        let one = |(index, value): (usize, &Option<f64>)| match (value, shown_in.get(index)) {
            (Some(value), Some(unit)) => unit.show(*value),
            (value, _) => number(*value),
        };
        values.iter().enumerate().map(one).collect()
    };
    let objectives = all(&candidate.objectives, &result.objectives_in);
    let margins = all(&candidate.margins, &result.margins_in);
    let margins =
        if margins.is_empty() { String::new() } else { format!(", margins {}", margins.join(", ")) };
    let point = if point.is_empty() { "what is declared".to_string() } else { point.join(", ") };
    format!("{point} gives {}{margins}", objectives.join(", "))
}

fn summary(summary: &MetricSummary, unit: Option<&ShownIn>) -> String {
    let digits = |value| digits_in(unit, value);
    let shown = |value| unit.map_or_else(|| digits(value), |unit| unit.show(value));
    let MetricSummary { runs, defined, .. } = summary;
    let of = if defined < runs { format!(" in {defined} of {runs}") } else { String::new() };
    match (summary.mean, summary.min, summary.max) {
        (Some(mean), Some(min), Some(max)) if min < max => {
            format!("{} ({} .. {}){of}", shown(mean), digits(min), digits(max))
        }
        (Some(mean), ..) => shown(mean) + &of,
        _ => "–".to_string(),
    }
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_string(), digits)
}
