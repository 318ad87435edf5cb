//! The rows of a file that is drawn from: a CSV whose header says what its columns are called and in which unit they are.

use std::collections::HashMap;
use std::path::Path;

use super::places::TextPlaces;
use crate::units;
use crate::value::ValueKind;
use scenario::{Dimension, Notation, Value, VariedValue};

/// More rows than this are taken for a mistake.
const MOST_ROWS: usize = 1_000_000;

/// What the column of weights is called.
pub const WEIGHT: &str = "weight";

/// What stands in such a file.
pub struct ReadTable {
    /// What all of its columns are called, those that are not read among them.
    pub header: Vec<String>,
    pub columns: Vec<TableColumn>,
    pub rows: Vec<Vec<VariedValue>>,
    /// One a row.
    pub weights: Vec<f64>,
}

/// A column that gives values to a name.
pub struct TableColumn {
    pub name: String,
    pub kind: ValueKind,
    pub notation: Option<Notation>,
}

/// What is wrong with a file, and what to do about it.
pub type Wrong = (String, String);

/// The file of that path, with those of its columns that are `wanted`.
///
/// # Errors
/// If it cannot be read, or is no table that could be drawn from: what is wrong in which line, and the cure.
pub fn read(path: &str, wanted: impl Fn(&str) -> bool, places: &TextPlaces) -> Result<ReadTable, Wrong> {
    let file = Path::new(path).file_name().map_or(path.into(), |name| name.to_string_lossy().into_owned());
    let text = places.files.text_of(path, &["csv"]).map_err(|error| {
        (
            format!("{file}: {error}"),
            "name a CSV file beside this one, such as `\"exposure.csv\"`".to_string(),
        )
    })?;
    parse(&text, wanted).map_err(|(line, message, hint)| {
        let place = if line == 0 { file } else { format!("{file}, line {line}") };
        (format!("{place}: {message}"), hint)
    })
}

/// A line (0: the whole file), what is wrong there, and the cure.
type WrongLine = (u64, String, String);

fn wrong<T>(line: u64, message: impl Into<String>, hint: impl Into<String>) -> Result<T, WrongLine> {
    Err((line, message.into(), hint.into()))
}

fn parse(text: &str, wanted: impl Fn(&str) -> bool) -> Result<ReadTable, WrongLine> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let malformed = |error: csv::Error| {
        let line = error.position().map_or(0, csv::Position::line);
        (line, "this is no CSV".to_string(), format!("separate cells with commas: {error}"))
    };
    let header = reader.headers().map_err(malformed)?.clone();
    let first = header.position().map_or(1, csv::Position::line);
    let heads = heads(&header, first)?;
    let mut cells: Vec<(u64, Vec<String>)> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(malformed)?;
        let line = record.position().map_or(0, csv::Position::line);
        if record.len() != heads.len() {
            let message = format!("{} cells in a table of {} columns", record.len(), heads.len());
            return wrong(line, message, "give every column a cell");
        }
        if cells.len() == MOST_ROWS {
            return wrong(line, format!("more than {MOST_ROWS} rows"), "weigh rows that are alike together");
        }
        cells.push((line, record.iter().map(str::to_string).collect()));
    }
    if cells.is_empty() {
        return wrong(
            0,
            "a table without rows, of which nothing can be drawn",
            "write a row under its header",
        );
    }
    table(heads, wanted, &cells)
}

/// A name, and the unit in square brackets behind it.
struct Head {
    name: String,
    unit: Option<units::UnitEntry>,
}

fn heads(header: &csv::StringRecord, line: u64) -> Result<Vec<Head>, WrongLine> {
    let mut heads: Vec<Head> = Vec::new();
    if header.is_empty() {
        return wrong(
            0,
            "an empty file, of which nothing can be drawn",
            "write a header and rows: `tta [s],weight`",
        );
    }
    for cell in header {
        let (name, unit) = match cell.split_once('[') {
            Some((name, unit)) => (name.trim(), unit.strip_suffix(']').map(str::trim)),
            None => (cell, None),
        };
        let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if !is_name || cell.contains('[') && unit.is_none() {
            let message = format!("`{cell}` is no name of a column");
            return wrong(line, message, "head columns with names and units: `tta [s],speed [km/h],weight`");
        }
        let unit = match unit {
            None => None,
            Some(symbol) => match units::unit_of(symbol) {
                Some(unit) => Some(unit),
                None => {
                    return wrong(
                        line,
                        format!("there is no unit `{symbol}`"),
                        "`scenario-runner explain E0401` lists units",
                    );
                }
            },
        };
        if heads.iter().any(|known| known.name == name) {
            return wrong(line, format!("two columns are called `{name}`"), "call every column differently");
        }
        heads.push(Head { name: name.to_string(), unit });
    }
    if heads.iter().all(|head| head.name == WEIGHT) {
        return wrong(line, "no column gives values", "head columns with names and units: `tta [s],weight`");
    }
    Ok(heads)
}

fn table(
    heads: Vec<Head>,
    wanted: impl Fn(&str) -> bool,
    cells: &[(u64, Vec<String>)],
) -> Result<ReadTable, WrongLine> {
    let header = heads.iter().map(|head| head.name.clone()).collect();
    let mut weights = vec![1.0; cells.len()];
    let mut columns = Vec::new();
    let mut rows: Vec<Vec<VariedValue>> = vec![Vec::new(); cells.len()];
    let number = |cell: &str| cell.parse::<f64>().ok().filter(|number| number.is_finite());
    for (index, head) in heads.into_iter().enumerate().filter(|(_, head)| wanted(&head.name)) {
        let name = &head.name;
        if *name == WEIGHT {
            let is_share = head.unit.is_some_and(|unit| unit.dimension == Dimension::NUMBER);
            if head.unit.is_some() && !is_share {
                return wrong(1, "weights have no unit", "head the column `weight`");
            }
            for (row, (line, cells)) in cells.iter().enumerate() {
                let cell = &cells[index];
                weights[row] = match number(cell) {
                    Some(weight) if weight >= 0.0 => weight,
                    _ => {
                        let message = format!("`{cell}` is no weight");
                        return wrong(*line, message, "write a number of at least 0");
                    }
                };
            }
            continue;
        }
        // Words stand in columns without a unit, of which not every cell is a number.
        let are_words = head.unit.is_none() && cells.iter().any(|(_, cells)| number(&cells[index]).is_none());
        for (row, (line, cells)) in cells.iter().enumerate() {
            let cell = &cells[index];
            let value = if are_words {
                let is_word = cell.starts_with(|c: char| c.is_ascii_alphabetic())
                    && cell.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
                if !is_word {
                    let message = format!("`{cell}` in the column `{name}` is neither a number nor a word");
                    return wrong(*line, message, "write a number, or one word in every row");
                }
                VariedValue { value: Value::Word(cell.clone()), label: cell.clone() }
            } else {
                let Some(written) = number(cell) else {
                    let message = format!("`{cell}` in the column `{name}` is no number");
                    return wrong(
                        *line,
                        message,
                        "write a number without its unit, which stands in the header",
                    );
                };
                let symbol = head.unit.map_or("", |unit| unit.symbol);
                let value = head.unit.map_or(written, |unit| unit.to_si(written));
                VariedValue { value: Value::Number(value), label: format!("{cell}{symbol}") }
            };
            rows[row].push(value);
        }
        let dimension = head.unit.map_or(Dimension::NUMBER, |unit| unit.dimension);
        let kind = if are_words { ValueKind::Word } else { ValueKind::Number(dimension) };
        let notation = head.unit.map(|unit| unit.notation());
        columns.push(TableColumn { name: head.name, kind, notation });
    }
    let sum: f64 = weights.iter().sum();
    if sum == 0.0 {
        return wrong(0, "all weights are 0, so that no row can be drawn", "give a row a weight above 0");
    }
    if !sum.is_finite() {
        return wrong(
            0,
            "the weights come to more than a number can be",
            "divide all of them by the largest",
        );
    }
    Ok(ReadTable { header, columns, rows, weights })
}

impl ReadTable {
    /// The column of each name.
    pub fn by_name(&self) -> HashMap<&str, usize> {
        self.columns.iter().enumerate().map(|(index, column)| (column.name.as_str(), index)).collect()
    }

    /// Its rows without all but these columns.
    pub fn of_columns(&self, columns: &[usize]) -> Vec<Vec<VariedValue>> {
        self.rows.iter().map(|row| columns.iter().map(|column| row[*column].clone()).collect()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_have_the_units_of_their_columns() {
        let table = parse(
            "# counted by hand\ntta [s],speed [km/h],who,weight\n6,36,child,2\n8.5,18,adult,0\n",
            |_| true,
        )
        .unwrap_or_else(|_| panic!());
        assert_eq!(table.weights, [2.0, 0.0]);
        let row: Vec<_> = table.rows[0].iter().map(|one| (one.value.clone(), one.label.as_str())).collect();
        assert_eq!(
            row,
            [(Value::Number(6.0), "6s"), (Value::Number(10.0), "36km/h"), ("child".into(), "child")]
        );
        let plain = parse("n\n1\n2\n3\n", |_| true).unwrap_or_else(|_| panic!());
        assert_eq!(plain.weights, [1.0; 3]);
        // What is in the cells of others is theirs.
        let some = parse("id,date,n\n7,2024-05-01,1\n8,2024-05-02,2\n", |name| name == "n");
        let some = some.unwrap_or_else(|_| panic!());
        assert_eq!(
            (some.header, some.rows.len(), some.columns.len()),
            (vec!["id".into(), "date".into(), "n".into()], 2, 1)
        );
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        let said = |text: &str| {
            let (line, message, hint) = parse(text, |_| true).err().unwrap_or_else(|| panic!("{text}"));
            format!("{line}: {message} ({hint})")
        };
        let all = [
            "",
            "tta [s]\n",
            "tta [s],weight\n6,-1\n",
            "tta [s],weight\n6,0\n7,0\n",
            "tta [s],weight\n6,nan\n",
            "tta [s],weight\n6,1e308\n7,1e308\n",
            "tta [s]\n6\nx\n",
            "tta [s]\n6 s\n",
            "tta [parsec]\n6\n",
            "tta [s,speed\n6,7\n",
            "tta [s],tta [s]\n6,7\n",
            "weight\n1\n",
            "tta [s],speed [m/s]\n6\n",
            "who\nchild\n3 m\n",
        ];
        insta::assert_snapshot!(all.map(said).join("\n"));
    }
}
