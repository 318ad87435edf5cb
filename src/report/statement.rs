//! Statements for the terminal: reproduced or not, with the numbers of both sides.

use std::fmt::Write;

use super::format::in_written_unit;
use results::{ClaimResult, ClaimValues, Conclusion, StatementResult};
use scenario::{DeclaredStanding, TrendDirection};

const STRING: &str = "writing to a string cannot fail";

/// One statement with its claims.
pub fn render_statement(result: &StatementResult) -> String {
    let mark = if result.surprise().is_some() { "✗ " } else { "" };
    let mut text = format!("{mark}statement {}: {}\n", result.name, conclusion_words(&result.conclusion));
    if let Some(doc) = &result.doc {
        writeln!(text, "  “{doc}”").expect(STRING);
    }
    match (&result.source, &result.reported) {
        (Some(source), Some(reported)) => writeln!(text, "  {source}: {reported}").expect(STRING),
        (Some(one), None) | (None, Some(one)) => writeln!(text, "  {one}").expect(STRING),
        (None, None) => {}
    }
    for claim in &result.claims {
        writeln!(text, "  {} {}: {}", claim_mark(claim), claim.text, claim_values(claim)).expect(STRING);
    }
    match &result.standing {
        DeclaredStanding::Reproduced => {}
        DeclaredStanding::Differs(reason) => writeln!(text, "  differs: {reason}").expect(STRING),
        DeclaredStanding::NotComparable(reason) => {
            writeln!(text, "  not comparable: {reason}").expect(STRING)
        }
    }
    if let Some(surprise) = result.surprise() {
        writeln!(text, "  fails: {surprise}").expect(STRING);
    }
    text
}

/// All statements, a line each, and how many came to what.
pub fn render_statements(results: &[&StatementResult]) -> String {
    let word = |result: &&StatementResult| conclusion_words(&result.conclusion);
    let width = results.iter().map(|result| result.name.chars().count()).max().unwrap_or(0);
    let mut text = String::from("statements\n");
    for result in results {
        let name = &result.name;
        write!(text, "  {name:<width$}  {:<14}", word(result)).expect(STRING);
        if let Some(surprise) = result.surprise() {
            write!(text, "  fails: {surprise}").expect(STRING);
        } else if let Some(why) = result.failure() {
            write!(text, "  {why}").expect(STRING);
        }
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    let count = |words: &str| results.iter().filter(|result| word(result) == words).count();
    let counts = ["reproduced", "not reproduced", "not comparable", "untested"];
    let shown = counts.into_iter().filter(|words| *words != "untested" || count(words) > 0);
    let counts: Vec<_> = shown.map(|words| format!("{} {words}", count(words))).collect();
    writeln!(text, "  {} of {} statements", counts.join(", "), results.len()).expect(STRING);
    text
}

/// `reproduced`, `untested`, `not reproduced` or `not comparable`.
pub fn conclusion_words(conclusion: &Conclusion) -> &'static str {
    match conclusion {
        Conclusion::Reproduced => "reproduced",
        Conclusion::Untested => "untested",
        Conclusion::NotReproduced => "not reproduced",
        Conclusion::NotComparable(_) => "not comparable",
    }
}

/// One letter that needs no colour.
pub fn claim_mark(claim: &ClaimResult) -> &'static str {
    match claim.holds {
        Some(true) => "✓",
        Some(false) => "✗",
        None => "?",
    }
}

/// The numbers that decide a claim: `4.9 s > 2.5 s`, or `10 % at 6s, 55 % at 10s`.
pub fn claim_values(claim: &ClaimResult) -> String {
    let written = lang::unit_in_claim(&claim.text, &claim.unit);
    let show = |value: Option<f64>| {
        value.map_or("–".to_string(), |value| in_written_unit(value, written, &claim.unit))
    };
    let values = match &claim.values {
        ClaimValues::Compared { left, relation, right } => {
            let relation = if claim.holds == Some(false) { relation.opposite() } else { *relation };
            format!("{} {} {}", show(*left), relation.symbol(), show(*right))
        }
        ClaimValues::Trend { direction, points, .. } => {
            let points: Vec<_> =
                points.iter().map(|point| format!("{} at {}", show(point.value), point.label)).collect();
            let word = match direction {
                TrendDirection::Rises => "rises",
                TrendDirection::Falls => "falls",
            };
            if points.is_empty() { format!("nothing {word}") } else { points.join(", ") }
        }
    };
    match &claim.undefined {
        Some(reason) => format!("{values} ({reason})"),
        None => values,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::statement;
    use scenario::Relation;

    #[test]
    fn claims_are_shown_in_the_unit_that_they_are_written_in() {
        let claim = |text: &str, left, right| ClaimResult {
            text: text.into(),
            holds: Some(true),
            undefined: None,
            untested: None,
            values: ClaimValues::Compared {
                left: Some(left),
                relation: Relation::LessOrEqual,
                right: Some(right),
            },
            unit: "m/s".into(),
        };
        let slow = claim("mean(impact_speed) of all <= 20 km/h", 1.739_636_827_058_043_3, 20.0 / 3.6);
        assert_eq!(claim_values(&slow), "6.263 km/h <= 20 km/h");
        // The unit of a condition is not that of the claim.
        let other = claim("mean(impact_speed) of all when speed >= 30 km/h <= 5 m/s", 2.0, 5.0);
        assert_eq!(claim_values(&other), "2 m/s <= 5 m/s");
        let none = claim("mean(impact_speed) of slow <= mean(impact_speed) of fast", 2.0, 5.0);
        assert_eq!(claim_values(&none), "2 m/s <= 5 m/s");
    }

    #[test]
    fn a_statement_shows_both_sides_and_why_it_fails() {
        let differs = DeclaredStanding::Differs("the car is heavier".into());
        let unexpected = statement(DeclaredStanding::Reproduced, Conclusion::NotReproduced);
        let revise = statement(differs.clone(), Conclusion::Reproduced);
        let known = statement(differs, Conclusion::NotReproduced);
        insta::assert_snapshot!([&unexpected, &revise, &known].map(render_statement).join("\n"));
        insta::assert_snapshot!(render_statements(&[&unexpected, &revise, &known]));
    }
}
