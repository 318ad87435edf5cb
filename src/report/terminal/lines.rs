//! Lines on their way to the terminal, and what did not pass among them.

use anstyle::Style;

use crate::table::paint;

/// Lines that are written or about to be.
#[derive(Debug)]
pub(super) struct Lines {
    pub colour: bool,
    /// Not written yet.
    pub text: String,
    /// Written or about to be.
    pub count: usize,
    /// Whether the last of them is empty.
    gap: bool,
    /// The row of characters that is being written, if one is.
    row: Option<Row>,
}

/// A row of characters, one for each unit.
#[derive(Debug, Clone, Copy)]
struct Row {
    marks: usize,
    /// Units that are done.
    done: usize,
    /// All there are.
    all: usize,
}

/// Columns of a row of characters with the count behind it.
const ROW: usize = 80;

impl Row {
    /// ` [ 70/164]`
    fn count(self) -> String {
        let digits = self.all.to_string().len();
        format!(" [{:>digits$}/{}]", self.done, self.all)
    }

    fn is_full(self) -> bool {
        self.marks + self.count().len() >= ROW
    }
}

/// A unit that did not pass.
#[derive(Debug)]
pub(super) struct Bad {
    pub key: String,
    pub line: String,
    /// All there is to say about it.
    pub text: String,
    /// The number of the last line of that; `None` if it was not shown.
    pub shown: Option<usize>,
}

impl Lines {
    pub fn new(colour: bool) -> Self {
        Self { colour, text: String::new(), count: 0, gap: true, row: None }
    }

    /// One more character of a row, for the unit with which `done` of `all` are done.
    pub fn mark(&mut self, (mark, style): (char, Style), done: usize, all: usize) {
        let marks = self.row.map_or(0, |row| row.marks) + 1;
        let row = Row { marks, done, all };
        self.text.push_str(&paint(&mark.to_string(), style, self.colour));
        self.row = Some(row);
        if row.is_full() {
            self.end_row();
        }
    }

    /// Ends the row of characters that is being written, with the count in its place.
    pub fn end_row(&mut self) {
        let Some(row) = self.row.take() else { return };
        let count = row.count();
        let space = ROW.saturating_sub(row.marks + count.len());
        self.say(&format!("{}{count}", " ".repeat(space)));
    }

    pub fn say(&mut self, line: &str) {
        self.end_row();
        self.count += 1 + line.matches('\n').count();
        self.gap = line.is_empty() || line.ends_with('\n');
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// An empty line, unless there is one already.
    pub fn gap(&mut self) {
        self.end_row();
        if !self.gap {
            self.say("");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::status::{self, mark};
    use super::*;
    use results::{Standing, Verdict};

    fn rows(units: usize, all: usize) -> Lines {
        let mut lines = Lines::new(false);
        let passed = mark(Standing::Judged(Verdict::Passed));
        (1..=units).for_each(|done| lines.mark(passed, done, all));
        lines
    }

    #[test]
    fn rows_are_eighty_wide_with_the_count_behind_them() {
        let mut lines = rows(164, 164);
        assert_eq!(lines.count, 2, "what is not full is not ended");
        lines.end_row();
        let written: Vec<&str> = lines.text.lines().collect();
        assert!(written.iter().all(|row| row.len() == ROW), "{written:#?}");
        assert!(written[0].ends_with(". [ 70/164]") && written[1].ends_with(". [140/164]"), "{written:#?}");
        assert_eq!(written[2], format!("{}{} [164/164]", ".".repeat(24), " ".repeat(46)));
        assert_eq!(lines.count, 3);
        // Every unit has its character, in whatever row.
        assert_eq!(lines.text.matches('.').count(), 164);
        lines.end_row();
        assert_eq!(lines.count, 3, "a row is ended once");
    }

    #[test]
    fn a_row_that_is_just_full_has_no_empty_one_behind_it() {
        // 80 columns less ` [72/72]`.
        let mut lines = rows(72, 72);
        lines.end_row();
        assert_eq!(lines.text, format!("{} [72/72]\n", ".".repeat(72)));
    }

    #[test]
    fn whatever_else_is_said_stands_below_the_row() {
        let mut lines = rows(3, 9);
        lines.gap();
        lines.say("Stopping");
        let written: Vec<&str> = lines.text.lines().collect();
        assert!(written[0].starts_with("...  ") && written[0].ends_with(" [3/9]"), "{written:?}");
        assert_eq!(written[1..], ["", "Stopping"]);
    }

    #[test]
    fn colours_take_no_columns() {
        let mut lines = Lines::new(true);
        (1..=80).for_each(|done| lines.mark(('F', status::BAD), done, 80));
        lines.end_row();
        assert_eq!(lines.text.lines().count(), 2);
        assert_eq!(lines.text.matches('F').count(), 80);
    }
}
