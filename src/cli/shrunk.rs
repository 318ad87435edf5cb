//! A shrunk case in words, and as a scenario file.

use std::path::Path;

use lang::{self, UNITS, UnitEntry};
use report::{run_words, with_unit};
use results::SuiteIdentity;
use results::judge::PerRun;
use runner::plan::{self, PlanError};
use runner::shrink::{Knob, Move, Shrunk};
use scenario::{Claim, significant};

/// What the second line of such a file says, before the version: by this it is known again.
pub const SHRUNK_BY: &str = "as a scenario of its own, by `scenario-runner shrink`";

/// What was done to the case and how it fails now.
pub fn render_shrunk(shrunk: &Shrunk, criterion: &PerRun) -> String {
    story(shrunk, criterion).into_iter().map(|line| line + "\n").collect()
}

/// The scenario file that will lie in `folder`, with where it comes from as a comment.
///
/// # Errors
/// If a value cannot be evaluated.
pub fn shrunk_file(
    shrunk: &Shrunk,
    criterion: &PerRun,
    suite: &SuiteIdentity,
    folder: &Path,
) -> Result<String, PlanError> {
    let place = &shrunk.place;
    let mut scenario = plan::standalone(&place.scenario, &place.variation, &place.individuals, place.seed)?;
    scenario.name += "_shrunk";
    let Claim::Runs { comparison, .. } = &criterion.criterion.claim else {
        unreachable!("what is wanted of each run is a comparison")
    };
    let mut remarks = vec![
        format!("The run `{}` of {} ({})", place.key, suite.file, suite.seed_words()),
        format!("{SHRUNK_BY} {}.", env!("CARGO_PKG_VERSION")),
        String::new(),
    ];
    remarks.extend(story(shrunk, criterion));
    Ok(lang::write_scenario(&scenario, &[lang::write_comparison(comparison)], &remarks, folder))
}

fn story(shrunk: &Shrunk, criterion: &PerRun) -> Vec<String> {
    let fails = run_words(criterion, &shrunk.outcome, &shrunk.requests);
    let mut lines = vec![format!("It fails `{}`: {fails}.", criterion.criterion.text)];
    let (moved, stayed): (Vec<&Move>, Vec<&Move>) = shrunk.moves.iter().partition(|one| one.to != one.from);
    if !moved.is_empty() {
        lines.push(format!("Moved towards nominal values as far as it still fails ({} runs):", shrunk.runs));
        let row = |one: &&Move| {
            let words = |value| number(&one.knob, value);
            let way = match one.share() {
                1.0 => "all the way".to_string(),
                share => {
                    format!("{} % of the way to {}", significant(100.0 * share, 2), words(one.knob.nominal))
                }
            };
            let ends = format!("{} -> {}", words(one.from), words(one.to));
            [one.knob.name.clone(), ends, format!("{way}, {}", one.knob.why)]
        };
        lines.extend(table(moved.iter().map(row)));
    }
    if !stayed.is_empty() {
        lines.push("Not moved, for it does not fail nearer to nominal:".to_string());
        let row = |one: &&Move| {
            let nominal = format!("nominal is {}, {}", number(&one.knob, one.knob.nominal), one.knob.why);
            [one.knob.name.clone(), number(&one.knob, one.to), nominal]
        };
        lines.extend(table(stayed.iter().map(row)));
    }
    if !shrunk.left_out.is_empty() {
        lines.push(format!("Left out, for it fails without: {}", shrunk.left_out.join(", ")));
    }
    if shrunk.stopped {
        lines.push("Interrupted: more might move.".to_string());
    }
    lines
}

/// Names to the left, values to the right, what is said of them behind.
fn table(rows: impl Iterator<Item = [String; 3]>) -> Vec<String> {
    let rows: Vec<_> = rows.collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let (names, values) = (width(0), width(1));
    rows.iter().map(|[name, value, said]| format!("  {name:<names$}  {value:>values$}  {said}")).collect()
}

/// A value in the unit in which it was given.
fn number(knob: &Knob, value: f64) -> String {
    if let Some(unit) = knob.label.as_deref().and_then(unit_of) {
        return format!("{} {}", significant(unit.of_si(value), 4), unit.symbol);
    }
    match knob.dimension {
        Some(dimension) => with_unit(value, dimension),
        None => significant(value, 4),
    }
}

/// The unit at the end of a label such as `6s` or `6.1235s#2`.
fn unit_of(label: &str) -> Option<&'static UnitEntry> {
    let words = label.split('#').next().unwrap_or(label);
    let symbol = words.trim_start_matches(|letter: char| letter.is_ascii_digit() || "+-._".contains(letter));
    UNITS.iter().find(|unit| unit.symbol == symbol.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_name_the_unit() {
        let symbol = |label| unit_of(label).map(|unit| unit.symbol);
        assert_eq!(symbol("6s"), Some("s"));
        assert_eq!(symbol("-6.1235m#2"), Some("m"));
        assert_eq!(symbol("30km/h"), Some("km/h"));
        assert_eq!(symbol("0.3"), None);
        assert_eq!(symbol("cautious"), None);
    }
}
