//! What people did, a condition a row: the CSV files that `calibrate` reads.
//!
//! `#` before comments; then a header with `scenario`, the names of what the scenario varies, `share`, `trials`, `persons` and
//! `persons_0` to `persons_N`: how many persons did so in 0 to N of their trials. The format is in `docs/populations.md`.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Every row of a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Observations {
    /// The file, for messages.
    pub file: String,
    /// In the order of the file.
    pub rows: Vec<ObservedRow>,
}

/// What people did in a condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObservedRow {
    /// Counted from 1, without header and comments.
    pub row: usize,
    /// The scenario.
    pub scenario: String,
    /// What varies and its value, as the scenario writes it; spaces do not matter.
    pub values: Vec<(String, String)>,
    /// Share of trials, 0 to 1.
    pub share: f64,
    /// How many trials.
    pub trials: u32,
    /// Of how many persons.
    pub persons: u32,
    /// How many of them did so in 0, 1, … of their trials.
    pub by_count: Vec<u32>,
}

/// What is wrong with a file of observations, and where.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ObservationError {
    /// It is no CSV.
    #[error("{0}")]
    Csv(String),
    /// A column that has to be there is not.
    #[error("there is no column `{0}`")]
    NoColumn(&'static str),
    /// A column stands there twice.
    #[error("the column `{0}` stands there twice")]
    RepeatedColumn(String),
    /// The columns of persons by their counts are not those of 0 to N, N at least 2.
    #[error(
        "the columns of persons by their counts are {0} where `persons_0`, `persons_1` and so on are expected"
    )]
    Counts(String),
    /// There are no rows.
    #[error("there is no row")]
    Empty,
    /// A cell is no number of its kind.
    #[error("row {row}, column `{column}`: `{found}` is no {expected}")]
    Cell {
        /// Counted from 1.
        row: usize,
        /// The column.
        column: String,
        /// What stands there.
        found: String,
        /// What is expected, in words.
        expected: &'static str,
    },
    /// The persons by their counts are not as many as there are persons.
    #[error(
        "row {row}: the columns `persons_0` to `persons_{most}` add up to {found}, but there are {persons} persons"
    )]
    Persons {
        /// Counted from 1.
        row: usize,
        /// The last column.
        most: usize,
        /// The sum.
        found: u32,
        /// Column `persons`.
        persons: u32,
    },
    /// There are more trials than persons have, or fewer than one apart for each of them.
    #[error("row {row}: {trials} trials are not those of {persons} persons with {most} trials each")]
    Trials {
        /// Counted from 1.
        row: usize,
        /// Column `trials`.
        trials: u32,
        /// Column `persons`.
        persons: u32,
        /// Trials of a person.
        most: usize,
    },
    /// The share is not that of the counts.
    #[error(
        "row {row}: the share is {share}, but the counts by person say {held} of {trials} trials, {counted:.4}"
    )]
    Share {
        /// Counted from 1.
        row: usize,
        /// Column `share`.
        share: f64,
        /// Trials in which it held.
        held: u32,
        /// Column `trials`.
        trials: u32,
        /// What the counts say.
        counted: f64,
    },
    /// Two rows are about the same condition.
    #[error("row {row} is about the same condition as row {first}")]
    Repeated {
        /// Counted from 1.
        row: usize,
        /// The earlier one.
        first: usize,
    },
}

impl ObservationError {
    /// What to do about it.
    pub fn hint(&self) -> &'static str {
        match self {
            Self::Csv(_) | Self::NoColumn(_) | Self::RepeatedColumn(_) | Self::Counts(_) | Self::Empty => {
                "the header is `scenario, gap, share, trials, persons, persons_0, … persons_4` where `gap` varies and a person has 4 trials"
            }
            Self::Cell { column, .. } if column == "share" => "write a share between 0 and 1, such as 0.4297",
            Self::Cell { .. } => "counts are whole numbers from 0 on",
            Self::Persons { .. } => "count every person once, by how many of their trials it held in",
            Self::Trials { .. } => "at most one trial less than all may be missing for each person",
            Self::Share { .. } => {
                "the share is that of trials: the sum of count times persons, divided by the trials"
            }
            Self::Repeated { .. } => "join the two rows",
        }
    }
}

/// Of a share that is written with four digits.
const ROUNDED: f64 = 6e-5;

impl Observations {
    /// The rows in a text; `file` is kept for messages.
    ///
    /// # Errors
    /// The first thing that is wrong, with row, column and numbers.
    pub fn parse(file: &str, text: &str) -> Result<Self, ObservationError> {
        let mut reader =
            csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
        let malformed = |error: csv::Error| ObservationError::Csv(error.to_string());
        let header: Vec<String> = reader.headers().map_err(malformed)?.iter().map(str::to_owned).collect();
        let mut seen = BTreeSet::new();
        if let Some(twice) = header.iter().find(|name| !seen.insert(name.as_str())) {
            return Err(ObservationError::RepeatedColumn(twice.clone()));
        }
        for needed in ["scenario", "share", "trials", "persons"] {
            if !seen.contains(needed) {
                return Err(ObservationError::NoColumn(needed));
            }
        }
        let counts: Vec<&String> = header.iter().filter(|name| name.starts_with("persons_")).collect();
        let expected = (0..counts.len()).map(|count| format!("persons_{count}"));
        if counts.len() < 3 || !counts.iter().zip(expected).all(|(found, expected)| **found == expected) {
            let listed: Vec<_> = counts.iter().map(|name| format!("`{name}`")).collect();
            let listed = if listed.is_empty() { "none".to_string() } else { listed.join(", ") };
            return Err(ObservationError::Counts(listed));
        }
        let mut rows: Vec<ObservedRow> = Vec::new();
        for (index, record) in reader.records().enumerate() {
            let row = observation(index + 1, &header, &record.map_err(malformed)?)?;
            if let Some(first) = rows.iter().find(|one| one.is_about_what(&row)) {
                return Err(ObservationError::Repeated { row: row.row, first: first.row });
            }
            rows.push(row);
        }
        if rows.is_empty() {
            return Err(ObservationError::Empty);
        }
        Ok(Self { file: file.to_string(), rows })
    }
}

fn observation(
    row: usize,
    header: &[String],
    record: &csv::StringRecord,
) -> Result<ObservedRow, ObservationError> {
    let bad = |column: &str, found: &str, expected| ObservationError::Cell {
        row,
        column: column.to_string(),
        found: found.to_string(),
        expected,
    };
    let whole = |column: &str, found: &str| {
        found.parse::<u32>().map_err(|_| bad(column, found, "whole number from 0 on"))
    };
    let mut one = ObservedRow {
        row,
        scenario: String::new(),
        values: Vec::new(),
        share: 0.0,
        trials: 0,
        persons: 0,
        by_count: Vec::new(),
    };
    for (column, found) in header.iter().zip(record) {
        match column.as_str() {
            "scenario" => one.scenario = found.to_string(),
            "share" => {
                let share = found.parse().ok().filter(|share| (0.0..=1.0).contains(share));
                one.share = share.ok_or_else(|| bad(column, found, "share between 0 and 1"))?;
            }
            "trials" => one.trials = whole(column, found)?,
            "persons" => one.persons = whole(column, found)?,
            count if count.starts_with("persons_") => one.by_count.push(whole(column, found)?),
            _ => one.values.push((column.clone(), found.to_string())),
        }
    }
    let (most, found) = (one.by_count.len() - 1, one.by_count.iter().sum());
    if found != one.persons || found == 0 {
        return Err(ObservationError::Persons { row, most, found, persons: one.persons });
    }
    let all = one.persons * most as u32;
    if one.trials > all || one.trials + one.persons <= all {
        return Err(ObservationError::Trials { row, trials: one.trials, persons: one.persons, most });
    }
    let held = one.by_count.iter().zip(0..).map(|(persons, count)| persons * count).sum::<u32>();
    let counted = f64::from(held) / f64::from(one.trials);
    if (counted - one.share).abs() > ROUNDED {
        let (share, trials) = (one.share, one.trials);
        return Err(ObservationError::Share { row, share, held, trials, counted });
    }
    Ok(one)
}

impl ObservedRow {
    fn is_about_what(&self, other: &Self) -> bool {
        self.scenario == other.scenario && other.values.iter().all(|(name, value)| self.is_at(name, value))
    }

    /// Whether that variation has that value here.
    pub fn is_at(&self, name: &str, label: &str) -> bool {
        let bare = |text: &str| text.chars().filter(|one| !one.is_whitespace()).collect::<String>();
        self.values.iter().any(|(known, value)| known == name && bare(value) == bare(label))
    }

    /// Such as `crossing_plain, gap 3 s`.
    pub fn in_words(&self) -> String {
        let values = self.values.iter().map(|(name, value)| format!(", {name} {value}"));
        self.scenario.clone() + &values.collect::<String>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "scenario, gap, share, trials, persons, persons_0, persons_1, persons_2";

    fn parse(row: &str) -> Result<Observations, ObservationError> {
        Observations::parse("people.csv", &format!("# people\n{HEADER}\n{row}\n"))
    }

    #[test]
    fn rows_are_read() {
        let read = parse("plain, 3 s, 0.5, 8, 4, 1, 2, 1").unwrap();
        let row = &read.rows[0];
        assert_eq!((row.trials, row.persons, row.by_count.as_slice()), (8, 4, [1, 2, 1].as_slice()));
        assert!(row.is_at("gap", "3s") && !row.is_at("gap", "4s"));
        assert_eq!(row.in_words(), "plain, gap 3 s");
    }

    #[test]
    fn what_is_wrong_says_where() {
        let said = [
            parse("plain, 3 s, 1.5, 8, 4, 1, 2, 1"),
            parse("plain, 3 s, half, 8, 4, 1, 2, 1"),
            parse("plain, 3 s, NaN, 8, 4, 1, 2, 1"),
            parse("plain, 3 s, 0.5, 8, 4, 1, 2, 2"),
            parse("plain, 3 s, 0.5, 8, 4, 1, -2, 1"),
            parse("plain, 3 s, 0.5, 4, 4, 1, 2, 1"),
            parse("plain, 3 s, 0.5, 9, 4, 1, 2, 1"),
            parse("plain, 3 s, 0.6, 8, 4, 1, 2, 1"),
            parse("plain, 3 s, 0.5, 8, 4, 1, 2, 1\nplain, 3s, 0.5, 8, 4, 1, 2, 1"),
            parse("plain, 3 s, 0.5, 8"),
            parse("# nobody"),
            Observations::parse("p", "scenario, share, trials\n"),
            Observations::parse("p", "scenario, share, trials, persons, persons_1, persons_0, persons_2\n"),
            Observations::parse("p", "scenario, gap, gap, share, trials, persons\n"),
        ];
        let said: Vec<_> = said
            .into_iter()
            .map(|one| {
                let error = one.unwrap_err();
                format!("{error} ({})", error.hint())
            })
            .collect();
        insta::assert_snapshot!(said.join("\n"));
    }
}
