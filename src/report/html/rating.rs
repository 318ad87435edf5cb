//! A suite's ratings on the page: the points, the cells in their colours, and what was not assessed.

use serde::Serialize;

use crate::rating::{RatingTable, cells_in_words, points_in_words, points_rows, rating_mark, rating_notes};
use results::{RatingReport, RatingState, SuiteReport, Verdict};

#[derive(Debug, Serialize)]
pub struct RatingSection {
    name: String,
    doc: String,
    /// The class of its colour.
    state: &'static str,
    mark: &'static str,
    word: &'static str,
    /// What it came to, in a line.
    summary: String,
    /// What stands in the cells.
    about: String,
    headings: Vec<String>,
    rows: Vec<Row>,
    points: Vec<[String; 4]>,
    notes: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Row {
    name: String,
    cells: Vec<Cell>,
}

#[derive(Debug, Serialize)]
struct Cell {
    /// Empty where the scenario has no such cell.
    text: String,
    state: &'static str,
}

impl RatingSection {
    pub fn all(report: &SuiteReport) -> Vec<Self> {
        report.ratings.iter().map(Self::new).collect()
    }

    fn new(report: &RatingReport) -> Self {
        let state = match report.verdict() {
            Some(Verdict::Passed) => "passed",
            Some(Verdict::Inconclusive) => "inconclusive",
            Some(Verdict::Failed) => "failed",
            None if report.is_open() => "inconclusive",
            None => "skipped",
        };
        let (mark, word) = rating_mark(report);
        let mut section = Self {
            name: report.rating.name.clone(),
            doc: report.rating.doc.clone().unwrap_or_default(),
            state,
            mark,
            word,
            summary: String::new(),
            about: String::new(),
            headings: Vec::new(),
            rows: Vec::new(),
            points: Vec::new(),
            notes: Vec::new(),
        };
        let result = match &report.state {
            RatingState::Rated(result) => result,
            RatingState::NotJudged(why) => {
                section.summary = why.to_string();
                return section;
            }
        };
        let table = RatingTable::new(&report.rating, result);
        section.summary = points_in_words(result);
        section.about = cells_in_words(&report.rating);
        section.headings = table.headings;
        section.rows = table
            .rows
            .into_iter()
            .map(|row| {
                let cell = |cell: Option<crate::rating::RatingCell>| match cell {
                    Some(cell) => Cell { state: cell.class(), text: cell.text },
                    None => Cell { text: String::new(), state: "" },
                };
                Row { name: row.name, cells: row.cells.into_iter().map(cell).collect() }
            })
            .collect();
        section.points = points_rows(&report.rating, result);
        section.notes = rating_notes(&report.rating, result);
        section
    }
}
