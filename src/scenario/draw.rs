//! What a scenario draws anew in every run, and what came of that in one.

use serde::{Deserialize, Serialize};

use super::{Distribution, Origin, Value, VariedValue};

/// One `draw` statement: names that have another value in every run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeclaredDraw {
    /// What it gives values to: of a distribution one, of a table one for each column.
    pub names: Vec<String>,
    /// What the values are drawn from.
    pub from: DrawSource,
    /// Where it is written.
    pub origin: Origin,
}

/// What a draw is from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DrawSource {
    /// `draw x from normal(5 m, 1 m)`: numbers may depend on variations, and on draws before.
    Distribution {
        /// What its values are.
        distribution: Distribution,
        /// SI unit shown in labels.
        unit: String,
    },
    /// `draw together from "exposure.csv"`: rows of values that belong together.
    Table(DrawTable),
}

/// Rows of values, of which a run has one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DrawTable {
    /// The file, resolved against the one that names it.
    pub file: String,
    /// Names the stream, after its columns: what else is drawn changes no row.
    pub stream: String,
    /// A value for each name.
    pub rows: Vec<Vec<VariedValue>>,
    /// One a row: at least 0, some of them above. A row is as likely as its weight is of the sum of all.
    pub weights: Vec<f64>,
}

impl DeclaredDraw {
    /// What names its stream among those of a run.
    pub fn stream(&self) -> &str {
        match &self.from {
            DrawSource::Distribution { .. } => &self.names[0],
            DrawSource::Table(table) => &table.stream,
        }
    }

    /// The names that its values depend on.
    pub fn depends_on(&self) -> Vec<&str> {
        match &self.from {
            DrawSource::Distribution { distribution, .. } => distribution.variables(),
            DrawSource::Table(_) => Vec::new(),
        }
    }

    /// The values that one of its names takes; `None` if it does not draw the name, or not from a list.
    pub fn values_of(&self, name: &str) -> Option<Vec<&Value>> {
        let index = self.names.iter().position(|drawn| drawn == name)?;
        match &self.from {
            DrawSource::Distribution { distribution, .. } => {
                Some(distribution.options()?.iter().map(|option| &option.value).collect())
            }
            DrawSource::Table(table) => Some(table.rows.iter().map(|row| &row[index].value).collect()),
        }
    }
}

/// What was drawn in a run: a value of a declared draw, or who walks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Draw {
    /// Of the draw; of a person who is drawn the pedestrian's with `.individual`.
    pub name: String,
    /// The value in few digits with its unit, such as `6.2813s`.
    pub label: String,
    /// SI units; of a person the number in their population.
    pub value: Value,
    /// The share of the distribution that lies below, between 0 and 1: the coordinate of the run. Names that are drawn together have one.
    pub share: f64,
}

impl Draw {
    /// Whether it says who walks.
    pub fn is_person(&self) -> bool {
        self.name.ends_with(".individual")
    }
}
