//! What people did, a condition a row: the CSV files that `calibrate` reads.
//!
//! `#` before comments; then a header with `scenario`, the names of what the scenario varies, `share`, `trials`, `persons` and
//! `persons_0` to `persons_N`: how many persons did so in 0 to N of their trials. Where persons had different numbers of trials, `error`,
//! `pair_share` and `pair_error` say what was worked out of them. The format is in `docs/populations.md`.

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
    /// How many of them did so in 0, 1, … of their trials; empty where errors are said.
    pub by_count: Vec<u32>,
    /// What was worked out of persons, where their counts are not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub errors: Option<ObservedErrors>,
}

/// How well it is known what people did, in place of their counts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ObservedErrors {
    /// Standard error of the share, by drawing persons anew.
    pub error: f64,
    /// The share of pairs of a person's trials in which both held, 0 to 1, with its standard error.
    pub pairs: Option<(f64, f64)>,
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
    /// The columns of persons by their counts are not those of 0 to N, N from 2 to 60, and there is no column `error` either.
    #[error(
        "the columns of persons by their counts are {0} where `persons_0`, `persons_1` and so on are expected, or a column `error`"
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
    /// A share in percent.
    #[error("row {row}, column `{column}`: `{found}` is no share between 0 and 1; did you mean {meant}?")]
    Percent {
        /// Counted from 1.
        row: usize,
        /// The column.
        column: String,
        /// What stands there.
        found: String,
        /// The same as a share.
        meant: String,
    },
    /// Nobody was observed, or never.
    #[error("row {row}: nobody was observed, column `{column}` is 0")]
    Nobody {
        /// Counted from 1.
        row: usize,
        /// `trials` or `persons`.
        column: &'static str,
    },
    /// Counts of persons and an error, or neither.
    #[error("row {row} says {} persons by their counts {} an `error`", if *both { "both" } else { "neither" }, if *both { "and" } else { "nor" })]
    Errors {
        /// Counted from 1.
        row: usize,
        /// Both, not neither.
        both: bool,
    },
    /// A share of pairs without its error, or an error without its share.
    #[error("row {row} says `{said}` and no `{missing}`")]
    HalfPairs {
        /// Counted from 1.
        row: usize,
        /// The column that is said.
        said: &'static str,
        /// The one that is not.
        missing: &'static str,
    },
    /// A share of pairs that the share of trials does not allow.
    #[error(
        "row {row}: in {pairs} of pairs of a person's trials both hold, but where it holds in {share} of trials that is between {low:.4} and {share}"
    )]
    Pairs {
        /// Counted from 1.
        row: usize,
        /// Column `pair_share`.
        pairs: f64,
        /// Column `share`.
        share: f64,
        /// What it is where persons do not differ: the square of the share.
        low: f64,
    },
    /// Fewer trials than persons.
    #[error("row {row}: {trials} trials of {persons} persons, of whom each has one at least")]
    MorePersons {
        /// Counted from 1.
        row: usize,
        /// Column `trials`.
        trials: u32,
        /// Column `persons`.
        persons: u32,
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
            Self::Percent { .. } => "shares and their errors are written between 0 and 1",
            Self::Cell { column, .. } if column == "share" || column == "pair_share" => {
                "write a share between 0 and 1, such as 0.4297"
            }
            Self::Cell { column, .. } if column == "error" || column == "pair_error" => {
                "write a standard error above 0 and at most 0.5; where nobody did it, a third of the one-sided 95 % bound"
            }
            Self::Cell { .. } => "counts are whole numbers from 0 on",
            Self::Nobody { .. } => {
                "leave the row out: of a condition in which nobody was observed nothing is known"
            }
            Self::Errors { both: true, .. } => {
                "leave out the one or the other: of counts the error is worked out"
            }
            Self::Errors { .. } => {
                "fill in `persons_0` and so on, or `error` where persons had different numbers of trials"
            }
            Self::HalfPairs { .. } => "say both `pair_share` and `pair_error`, or neither",
            Self::Pairs { .. } => {
                "`pair_share` is the share of pairs of a person's trials in which both hold, and no deviation between persons"
            }
            Self::MorePersons { .. } => "`persons` are those who had a trial in which the condition was met",
            Self::Persons { .. } => "count every person once, by how many of their trials it held in",
            Self::Trials { .. } => {
                "at most one trial may be missing for each person; where more are, say `error`, and `pair_share` with `pair_error`, in place of counts"
            }
            Self::Share { .. } => {
                "the share is that of trials: the sum of count times persons, divided by the trials"
            }
            Self::Repeated { .. } => "join the two rows",
        }
    }
}

/// Of a share that is written with four digits.
const ROUNDED: f64 = 6e-5;
/// Of a person, where persons are counted.
const MOST_TRIALS: usize = 60;
/// Columns, in a message.
const MOST_LISTED: usize = 8;
/// No share is known worse.
const LARGEST_ERROR: f64 = 0.5;

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
        let are_missing = counts.is_empty() && seen.contains("error");
        if !are_missing
            && (!(3..=MOST_TRIALS + 1).contains(&counts.len())
                || !counts.iter().zip(expected).all(|(found, expected)| **found == expected))
        {
            let listed: Vec<_> = counts.iter().map(|name| format!("`{name}`")).collect();
            let listed = match listed.as_slice() {
                [] => "none".to_string(),
                [first, .., last] if listed.len() > MOST_LISTED => {
                    format!("{first} to {last}, {} of them", listed.len())
                }
                _ => listed.join(", "),
            };
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

    /// Whether a row is about a scenario of this name.
    pub fn is_about(&self, scenario: &str) -> bool {
        self.rows.iter().any(|row| row.scenario == scenario)
    }

    /// How many numbers weights are to match: the shares and, with `spread`, those of pairs that are known.
    pub fn targets(&self, spread: bool) -> usize {
        let pairs = self.rows.iter().filter(|row| spread && row.has_pairs());
        self.rows.len() + pairs.count()
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
    let share =
        |column: &str, found: &str| match found.parse() {
            Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
            _ => Err(percent(row, column, found, 1.0)
                .unwrap_or_else(|| bad(column, found, "share between 0 and 1"))),
        };
    let error = |column: &str, found: &str| match found.parse() {
        Ok(error) if error > 0.0 && error <= LARGEST_ERROR => Ok(error),
        _ => Err(percent(row, column, found, LARGEST_ERROR)
            .unwrap_or_else(|| bad(column, found, "error above 0 and at most 0.5"))),
    };
    let mut one = ObservedRow {
        row,
        scenario: String::new(),
        values: Vec::new(),
        share: 0.0,
        trials: 0,
        persons: 0,
        by_count: Vec::new(),
        errors: None,
    };
    let (mut own_error, mut pair_share, mut pair_error) = (None, None, None);
    let counts = || header.iter().zip(record).filter(|(column, _)| column.starts_with("persons_"));
    let are_counted = counts().any(|(_, found)| !found.is_empty());
    for (column, found) in header.iter().zip(record) {
        match column.as_str() {
            "scenario" => one.scenario = found.to_string(),
            "share" => one.share = share(column, found)?,
            "trials" => one.trials = whole(column, found)?,
            "persons" => one.persons = whole(column, found)?,
            "error" | "pair_share" | "pair_error" if found.is_empty() => {}
            "error" => own_error = Some(error(column, found)?),
            "pair_share" => pair_share = Some(share(column, found)?),
            "pair_error" => pair_error = Some(error(column, found)?),
            count if count.starts_with("persons_") => {
                if are_counted {
                    one.by_count.push(whole(column, found)?);
                }
            }
            _ => one.values.push((column.clone(), found.to_string())),
        }
    }
    for (column, number) in [("trials", one.trials), ("persons", one.persons)] {
        if number == 0 {
            return Err(ObservationError::Nobody { row, column });
        }
    }
    match (own_error, are_counted) {
        (None, true) if pair_share.or(pair_error).is_none() => counted(&one)?,
        (Some(error), false) => {
            let half = |said, missing| ObservationError::HalfPairs { row, said, missing };
            let pairs = match (pair_share, pair_error) {
                (Some(share), Some(error)) => Some((share, error)),
                (None, None) => None,
                (Some(_), None) => return Err(half("pair_share", "pair_error")),
                (None, Some(_)) => return Err(half("pair_error", "pair_share")),
            };
            one.errors = Some(ObservedErrors { error, pairs });
            worked_out(&one, pairs)?;
        }
        (_, both) => return Err(ObservationError::Errors { row, both }),
    }
    Ok(one)
}

/// What was meant by a number beyond `largest`, if it is one in percent.
fn percent(row: usize, column: &str, found: &str, largest: f64) -> Option<ObservationError> {
    let bare = found.strip_suffix('%').map(str::trim_end);
    let number: f64 = bare.unwrap_or(found).parse().ok()?;
    let is_percent = number > 0.0 && number <= 100.0 * largest && (bare.is_some() || number > largest);
    is_percent.then(|| ObservationError::Percent {
        row,
        column: column.to_string(),
        found: found.to_string(),
        meant: super::significant(number / 100.0, 6),
    })
}

/// Whether the counts of persons are those of the other columns.
fn counted(one: &ObservedRow) -> Result<(), ObservationError> {
    let ObservedRow { row, share, trials, persons, ref by_count, .. } = *one;
    let most = by_count.len() - 1;
    let sum = |of: &dyn Fn(u64, u64) -> u64| -> u64 {
        (0..).zip(by_count).map(|(count, persons)| of(count, u64::from(*persons))).sum()
    };
    let short = |number: u64| u32::try_from(number).unwrap_or(u32::MAX);
    let found = sum(&|_, persons| persons);
    if found != u64::from(persons) {
        return Err(ObservationError::Persons { row, most, found: short(found), persons });
    }
    let all = found * most as u64;
    if u64::from(trials) > all || u64::from(trials) + found <= all {
        return Err(ObservationError::Trials { row, trials, persons, most });
    }
    let held = sum(&|count, persons| count * persons);
    let counted = held as f64 / f64::from(trials);
    if (counted - share).abs() > ROUNDED {
        return Err(ObservationError::Share { row, share, held: short(held), trials, counted });
    }
    Ok(())
}

/// Errors of a share of pairs beyond which it cannot be one of the share of trials.
const PAIRS_APART: f64 = 3.0;

/// Whether what was worked out of persons can be.
fn worked_out(one: &ObservedRow, pairs: Option<(f64, f64)>) -> Result<(), ObservationError> {
    let ObservedRow { row, share, trials, persons, .. } = *one;
    if trials < persons {
        return Err(ObservationError::MorePersons { row, trials, persons });
    }
    if let Some((pairs, error)) = pairs {
        // Means over persons and over trials may differ a little, and estimates by chance.
        let (low, high) = (share * share - PAIRS_APART * error, share + PAIRS_APART * error);
        if !(low..=high).contains(&pairs) {
            return Err(ObservationError::Pairs { row, pairs, share, low: share * share });
        }
    }
    Ok(())
}

impl ObservedRow {
    /// Whether it says in which share of pairs of a person's trials both held.
    pub fn has_pairs(&self) -> bool {
        self.errors.is_none_or(|errors| errors.pairs.is_some())
    }

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

    /// A row of a file that has both forms.
    fn said(row: &str) -> Result<Observations, ObservationError> {
        let header = "scenario, gap, share, trials, persons, error, pair_share, pair_error, \
                      persons_0, persons_1, persons_2";
        Observations::parse("people.csv", &format!("{header}\n{row}\n"))
    }

    fn count_columns(most: usize) -> String {
        (0..=most).map(|count| format!("persons_{count}")).collect::<Vec<_>>().join(", ")
    }

    #[test]
    fn persons_may_have_many_trials() {
        for most in [5, 15, 60] {
            let counts: Vec<_> = (0..=most).map(|count| if count == most { "2" } else { "0" }).collect();
            let text = format!(
                "scenario, share, trials, persons, {}\nplain, 1, {}, 2, {}\n",
                count_columns(most),
                2 * most,
                counts.join(", ")
            );
            let read = Observations::parse("people.csv", &text).unwrap();
            assert_eq!((read.rows[0].by_count.len(), read.targets(true)), (most + 1, 2));
        }
    }

    #[test]
    fn what_was_worked_out_of_persons_stands_for_counts() {
        let rows = "plain, 4 s, 0.223, 435, 30, 0.0513, 0.1302, 0.0451, , , \n\
                    plain, 5 s, 0.5, 8, 4, , , , 1, 2, 1\n\
                    plain, 6 s, 0, 60, 30, 0.03, , , , , ";
        let read = said(rows).unwrap();
        let errors = |row: usize| read.rows[row].errors;
        assert_eq!(errors(0), Some(ObservedErrors { error: 0.0513, pairs: Some((0.1302, 0.0451)) }));
        assert_eq!((errors(1), read.rows[1].by_count.as_slice()), (None, [1, 2, 1].as_slice()));
        assert_eq!(errors(2), Some(ObservedErrors { error: 0.03, pairs: None }));
        assert!(read.rows[1].has_pairs() && !read.rows[2].has_pairs());
        assert_eq!((read.targets(false), read.targets(true)), (3, 5));
        let without = "scenario, share, trials, persons, error\nplain, 0.8, 433, 30, 0.05\n";
        assert!(Observations::parse("p", without).unwrap().rows[0].by_count.is_empty());
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
            parse("plain, 3 s, 59, 8, 4, 1, 2, 1"),
            parse("plain, 3 s, 0.5 %, 8, 4, 1, 2, 1"),
            parse("plain, 3 s, 0.5, 0, 4, 1, 2, 1"),
            parse("plain, 3 s, 0.5, 8, 0, 0, 0, 0"),
            parse("plain, 3 s, 0.5, 8, 4, 1, , 1"),
            parse("plain, 3 s, 0.5, 8, 4, , , "),
            parse("plain, 3 s, 0.5, 8, 4000000000, 4000000000, 294967300, 0"),
            parse("plain, 3 s, 0.5, 8"),
            parse("# nobody"),
            Observations::parse("p", "scenario, share, trials\n"),
            Observations::parse("p", "scenario, share, trials, persons, persons_1, persons_0, persons_2\n"),
            Observations::parse("p", "scenario, gap, gap, share, trials, persons\n"),
            Observations::parse("p", &format!("scenario, share, trials, persons, {}\n", count_columns(61))),
            said("plain, 3 s, 0.5, 40, 8, 0.05, 0.3, 0.05, 8, 0, 0"),
            said("plain, 3 s, 0.5, 40, 8, , , , , , "),
            said("plain, 3 s, 0.5, 40, 8, , 0.3, , 8, 0, 0"),
            said("plain, 3 s, 0.5, 40, 8, 0.05, 0.3, , , , "),
            said("plain, 3 s, 0.5, 40, 8, 0.05, , 0.02, , , "),
            said("plain, 3 s, 0.5, 40, 8, 5.1, , , , , "),
            said("plain, 3 s, 0.5, 40, 8, 51, , , , , "),
            said("plain, 3 s, 0.5, 40, 8, 0, , , , , "),
            said("plain, 3 s, 0.5, 40, 8, 0.05, 30, 0.02, , , "),
            said("plain, 3 s, 0.7963, 437, 30, 0.0475, 0.2426, 0.0437, , , "),
            said("plain, 3 s, 0.0799, 437, 30, 0.042, 0.21, 0.03, , , "),
            said("plain, 3 s, 0.5, 7, 8, 0.05, , , , , "),
            said("plain, 3 s, 0.5, 0, 8, 0.05, , , , , "),
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
