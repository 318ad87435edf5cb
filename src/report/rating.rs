//! What ratings came to: a row for each scenario, a column for each value that weights are about, then the points.

use std::collections::BTreeMap;
use std::fmt::Write;

use anstyle::{AnsiColor, Style};

use super::columns::columns;
use super::format::count;
use super::table::paint;
use super::wording::{verdict_mark, verdict_word};
use files::escape::{terminal, terminal_line};
use results::{
    CellWorth, EarnedPoints, RatedCell, RatingReport, RatingResult, RatingState, SuiteReport, Verdict,
};
use scenario::{Assignment, Rating, Scoring, Value, Weights, significant};

const STRING: &str = "writing to a string cannot fail";

/// Cells that are not assessed are named up to so many.
const MOST_NAMED: usize = 5;

/// A table of cells.
pub struct RatingTable {
    /// What the columns are of, then a value each; a rating whose weights are the same everywhere has one column.
    pub headings: Vec<String>,
    pub rows: Vec<RatingRow>,
}

pub struct RatingRow {
    /// The scenario and the values of what no column is of.
    pub name: String,
    /// `None` where the scenario has no such cell.
    pub cells: Vec<Option<RatingCell>>,
}

pub struct RatingCell {
    /// `0.25 (8.3)`, `1 (–)` without contact, `?` where nothing is known.
    pub text: String,
    /// 0 to 1; `None`: not assessed.
    pub weight: Option<f64>,
}

impl RatingTable {
    pub fn new(rating: &Rating, result: &RatingResult) -> Self {
        let variable = column_variable(rating, result);
        let mut headings: Vec<(&Assignment, String)> = Vec::new();
        for cell in &result.cells {
            if let Some(one) = variable.and_then(|name| assigned(cell, name))
                && headings.iter().all(|(known, _)| known.value != one.value)
            {
                headings.push((one, one.label.clone()));
            }
        }
        headings.sort_by(|(one, _), (other, _)| {
            let number = |one: &Assignment| one.value.as_number();
            number(one)
                .zip(number(other))
                .map_or(std::cmp::Ordering::Equal, |(one, other)| one.total_cmp(&other))
        });
        let mut rows: Vec<RatingRow> = Vec::new();
        for cell in &result.cells {
            let others = cell.variation.iter().filter(|one| Some(one.name.as_str()) != variable);
            let others = others.map(|one| format!(" {}={}", one.name, one.label));
            let name = cell.scenario.clone() + &others.collect::<String>();
            let column = match variable.and_then(|name| assigned(cell, name)) {
                Some(own) => headings.iter().position(|(known, _)| known.value == own.value).unwrap_or(0),
                None => 0,
            };
            // A row of the same name with that place taken is another scenario's; names are unique otherwise.
            let free = rows.iter_mut().find(|row| row.name == name && row.cells[column].is_none());
            let row = match free {
                Some(row) => row,
                None => {
                    let cells = (0..headings.len().max(1)).map(|_| None).collect();
                    rows.push(RatingRow { name, cells });
                    rows.last_mut().expect("it was put there")
                }
            };
            row.cells[column] = Some(RatingCell::new(rating, cell));
        }
        let first = match variable {
            Some(name) => name.to_string(),
            None => String::new(),
        };
        let headings = match headings.is_empty() {
            true => vec![first, "weight".to_string()],
            false => [vec![first], headings.into_iter().map(|(_, label)| label).collect()].concat(),
        };
        Self { headings, rows }
    }
}

/// What the first `when` is about, if every cell varies that.
fn column_variable<'r>(rating: &'r Rating, result: &RatingResult) -> Option<&'r str> {
    let mut about = rating.weights.iter().flat_map(|weights| &weights.when).map(|one| one.variable.as_str());
    about.find(|name| result.cells.iter().all(|cell| assigned(cell, name).is_some()))
}

fn assigned<'c>(cell: &'c RatedCell, name: &str) -> Option<&'c Assignment> {
    cell.variation.iter().find(|one| one.name == name)
}

impl RatingCell {
    fn new(rating: &Rating, cell: &RatedCell) -> Self {
        let CellWorth::Weighed { weight, value, absent, .. } = &cell.worth else {
            return Self { text: "?".to_string(), weight: None };
        };
        let value = match value {
            Some(_) if *absent => "–".to_string(),
            Some(value) => in_its_band(rating, cell, *value),
            None => "–".to_string(),
        };
        Self { text: format!("{} ({value})", significant(*weight, 4)), weight: Some(*weight) }
    }

    /// The colour of its weight, as protocols paint them: green is all, red nothing.
    pub fn class(&self) -> &'static str {
        match self.weight {
            None => "inconclusive",
            Some(weight) if weight >= 1.0 => "passed",
            Some(weight) if weight > 0.0 => "",
            Some(_) => "failed",
        }
    }
}

/// A value with so many digits that it stands on the side of each of its cell's bounds on which it is: 9.998 is not 10 where 10 is
/// worse.
fn in_its_band(rating: &Rating, cell: &RatedCell, value: f64) -> String {
    let shown = |si: f64| rating.notation.map_or(si, |unit| unit.of_si(si));
    let value = shown(value);
    let values: BTreeMap<String, Value> =
        cell.variation.iter().map(|one| (one.name.clone(), one.value.clone())).collect();
    let speaks = |weights: &&Weights| weights.when.iter().all(|one| one.holds(&values) == Ok(true));
    let lines = rating.weights.iter().filter(speaks).flat_map(|weights| &weights.lines);
    let bounds: Vec<f64> = lines.filter_map(|line| line.of.bound()).map(shown).collect();
    let keeps_sides = |text: &String| {
        let read: f64 = text.parse().unwrap_or(f64::NAN);
        bounds.iter().all(|bound| read.partial_cmp(bound) == value.partial_cmp(bound))
    };
    let mut texts = (3..=15).map(|digits| significant(value, digits));
    texts.clone().find(keeps_sides).or(texts.next_back()).unwrap_or_default()
}

/// `3.58 of 4 points that the cells would earn`, or that they are undefined.
pub fn points_in_words(result: &RatingResult) -> String {
    let maximum = significant(result.maximum, 4);
    match result.points {
        Some(points) => format!("{} of {maximum} points that the cells would earn", significant(points, 4)),
        None => format!("points that the cells would earn: undefined of {maximum}"),
    }
}

/// What the cells hold: `weight (impact_speed(component=along) in km/h)`.
pub fn cells_in_words(rating: &Rating) -> String {
    let unit = rating.notation.map_or_else(|| rating.measure.unit(), |unit| unit.symbol.to_string());
    let of = match unit.is_empty() {
        true => rating.measure.label(),
        false => format!("{} in {unit}", rating.measure.label()),
    };
    format!("cells: weight ({of}; – without contact)")
}

/// A row for each tag and one for all: what it earns, of how much, by how many cells.
pub fn points_rows(rating: &Rating, result: &RatingResult) -> Vec<[String; 4]> {
    let number =
        |points: Option<f64>| points.map_or("undefined".to_string(), |points| significant(points, 4));
    let row = |(one, declared): (&EarnedPoints, &scenario::TagPoints)| {
        let how = match &declared.by {
            Scoring::MeanWeight => "mean weight of",
            Scoring::Share { .. } => "share above 0 of",
        };
        let missing = match one.not_assessed {
            0 => String::new(),
            missing => format!(", {missing} not assessed"),
        };
        let (points, maximum) = (number(one.points), significant(one.maximum, 4));
        [one.tag.clone(), points, maximum, format!("{how} {}{missing}", count(one.cells, "cell"))]
    };
    let each = result.tags.iter().zip(&rating.points).map(row);
    let all = ["all".to_string(), number(result.points), significant(result.maximum, 4), String::new()];
    each.chain([all]).collect()
}

/// What else a reader has to know, a sentence each: what was expected, what is not known and what was not tested.
pub fn rating_notes(rating: &Rating, result: &RatingResult) -> Vec<String> {
    let mut notes: Vec<String> = Vec::new();
    for finding in &result.findings {
        let said = finding.points.map_or("undefined".to_string(), |points| significant(points, 6));
        let (mark, word) = (verdict_mark(finding.verdict), verdict_word(finding.verdict));
        notes.push(format!("{mark} {} {word}: {said}", finding.criterion));
    }
    let missing: Vec<_> = result.not_assessed().collect();
    for (cell, why) in missing.iter().take(MOST_NAMED) {
        notes.push(format!("not assessed: {}: {why}", cell.key));
    }
    if missing.len() > MOST_NAMED {
        notes.push(format!("and {} more cells that are not assessed", missing.len() - MOST_NAMED));
    }
    notes.extend(rating.not_assessed.iter().map(|what| format!("not assessed: {what}")));
    let unverified = result.unverified();
    if !unverified.is_empty() {
        notes.push(format!("unverified, not read in the rule itself: numbers of {}", unverified.join(", ")));
    }
    notes
}

/// How a rating stands, in a word with its mark.
pub fn rating_mark(report: &RatingReport) -> (&'static str, &'static str) {
    match (&report.state, report.verdict()) {
        (RatingState::NotJudged(_), _) if report.is_open() => ("?", "not judged"),
        (RatingState::NotJudged(_), _) => ("–", "not judged"),
        (RatingState::Rated(_), Some(verdict)) => (verdict_mark(verdict), verdict_word(verdict)),
        (RatingState::Rated(_), None) => ("–", "nothing expected"),
    }
}

/// Every rating of every suite, for the terminal; empty without ratings.
pub fn render_ratings(suites: &[SuiteReport], colour: bool) -> String {
    let mut text = String::new();
    for rating in suites.iter().flat_map(|one| &one.ratings) {
        write!(text, "\n{}", render_rating(rating, colour)).expect(STRING);
    }
    text
}

/// One rating in full.
pub fn render_rating(report: &RatingReport, colour: bool) -> String {
    let name = terminal_line(&report.rating.name);
    let result = match &report.state {
        RatingState::Rated(result) => result,
        RatingState::NotJudged(why) => {
            return format!("rating {name} is NOT JUDGED: {}\n", terminal(&why.to_string()));
        }
    };
    let bold = |text: &str| paint(text, Style::new().bold(), colour);
    let (mark, word) = rating_mark(report);
    let style = match report.verdict() {
        Some(Verdict::Passed) => AnsiColor::Green.on_default(),
        Some(Verdict::Inconclusive) => AnsiColor::Yellow.on_default(),
        Some(Verdict::Failed) => AnsiColor::Red.on_default(),
        None => Style::new().dimmed(),
    };
    let mut text = format!("rating {} {}\n", bold(&name), paint(&format!("{mark} {word}"), style, colour));
    writeln!(text, "  {}", points_in_words(result)).expect(STRING);
    if let Some(doc) = &report.rating.doc {
        writeln!(text, "  {}", terminal_line(doc)).expect(STRING);
    }
    writeln!(text, "  {}\n", terminal_line(&cells_in_words(&report.rating))).expect(STRING);
    let table = RatingTable::new(&report.rating, result);
    let line = |text: &String| terminal_line(text);
    let heading = table.headings.iter().map(line).collect();
    let row = |row: &RatingRow| {
        let cells =
            row.cells.iter().map(|cell| cell.as_ref().map_or(String::new(), |cell| cell.text.clone()));
        [terminal_line(&row.name)].into_iter().chain(cells).collect()
    };
    let lines: Vec<Vec<String>> = std::iter::once(heading).chain(table.rows.iter().map(row)).collect();
    text += &columns(&lines);
    text.push('\n');
    let rows = points_rows(&report.rating, result);
    let points = rows.iter().map(|[tag, points, maximum, how]| {
        vec![terminal_line(tag), points.clone(), "of".to_string(), maximum.clone(), how.clone()]
    });
    text += &columns(&points.collect::<Vec<_>>());
    for note in rating_notes(&report.rating, result) {
        writeln!(text, "  {}", terminal_line(&note)).expect(STRING);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    use crate::fixture::rating::{rating, reports};

    #[test]
    fn a_value_is_shown_on_its_side_of_every_bound() {
        let rating = Arc::new(rating());
        let RatingState::Rated(result) = &reports(&rating)[0].state else { panic!("the first is judged") };
        let shown = |speed: f64| in_its_band(&rating, &result.cells[1], speed / 3.6);
        assert_eq!([shown(0.0), shown(8.2549), shown(12.345)], ["0", "8.25", "12.3"]);
        assert_eq!([shown(9.998), shown(9.99996), shown(10.0001)], ["9.998", "9.99996", "10.0001"]);
        assert_eq!(shown(0.0004), "0.0004");
        // Bounds of other cells are none of its.
        let mut other = result.cells[1].clone();
        other.variation.clear();
        assert_eq!(in_its_band(&rating, &other, 9.998 / 3.6), "10");
    }
}
