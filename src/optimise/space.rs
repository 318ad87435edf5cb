//! The search space: real, integer, logarithmic and categorical dimensions, and their mapping to the unit cube.

use serde::{Deserialize, Serialize};

use super::Error;

/// Most dimensions a space may have; the surrogate's defaults are for one to ten.
pub const LARGEST_DIMENSION_COUNT: usize = 10;

/// One named dimension of the search space. Bounds are inclusive and in the caller's own unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchDimension {
    /// Name shown in errors and reports.
    pub name: String,
    /// The values it can take.
    pub range: Range,
}

/// The values a dimension can take.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Range {
    /// Any number from `low` to `high`.
    Real {
        /// The smallest value.
        low: f64,
        /// The largest value, above `low`.
        high: f64,
    },
    /// Any positive number from `low` to `high`, searched on a logarithmic scale.
    Log {
        /// The smallest value, above 0.
        low: f64,
        /// The largest value, above `low`.
        high: f64,
    },
    /// Any whole number from `low` to `high`.
    Integer {
        /// The smallest value.
        low: i64,
        /// The largest value, above `low`.
        high: i64,
    },
    /// One of the named choices; no order between them.
    Categorical {
        /// At least one, each once.
        choices: Vec<String>,
    },
}

/// The value of one dimension at a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Coordinate {
    /// Of an integer dimension.
    Integer(i64),
    /// Of a real or a logarithmic dimension.
    Real(f64),
    /// The chosen name, of a categorical dimension.
    Category(String),
}

/// One value per dimension, in the order of the space.
pub type Point = Vec<Coordinate>;

impl Coordinate {
    /// The value as a number; a category has none.
    pub fn number(&self) -> Option<f64> {
        match self {
            Coordinate::Real(value) => Some(*value),
            Coordinate::Integer(value) => Some(*value as f64),
            Coordinate::Category(_) => None,
        }
    }
}

impl std::fmt::Display for Coordinate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Coordinate::Real(value) => write!(f, "{value}"),
            Coordinate::Integer(value) => write!(f, "{value}"),
            Coordinate::Category(value) => write!(f, "{value}"),
        }
    }
}

impl SearchDimension {
    /// A real dimension from `low` to `high`.
    pub fn real(name: &str, low: f64, high: f64) -> Self {
        SearchDimension { name: name.to_owned(), range: Range::Real { low, high } }
    }

    /// A positive real dimension searched on a logarithmic scale.
    pub fn log(name: &str, low: f64, high: f64) -> Self {
        SearchDimension { name: name.to_owned(), range: Range::Log { low, high } }
    }

    /// A whole-number dimension from `low` to `high`, both included.
    pub fn integer(name: &str, low: i64, high: i64) -> Self {
        SearchDimension { name: name.to_owned(), range: Range::Integer { low, high } }
    }

    /// A dimension of named choices.
    pub fn categorical<S: Into<String>>(name: &str, choices: impl IntoIterator<Item = S>) -> Self {
        let choices = choices.into_iter().map(Into::into).collect();
        SearchDimension { name: name.to_owned(), range: Range::Categorical { choices } }
    }

    /// Number of values of a discrete dimension.
    pub fn levels(&self) -> Option<u64> {
        match &self.range {
            Range::Real { .. } | Range::Log { .. } => None,
            Range::Integer { low, high } => Some(high.abs_diff(*low).saturating_add(1)),
            Range::Categorical { choices } => Some(choices.len() as u64),
        }
    }

    /// Is this a dimension of named choices?
    pub fn is_categorical(&self) -> bool {
        matches!(self.range, Range::Categorical { .. })
    }

    /// The nearest unit coordinate that stands for a value: itself, or the centre of a discrete value's cell.
    pub fn snap(&self, unit: f64) -> f64 {
        let unit = unit.clamp(0.0, 1.0);
        match self.levels() {
            None => unit,
            Some(levels) => {
                let levels = levels as f64;
                ((unit * levels).floor().min(levels - 1.0) + 0.5) / levels
            }
        }
    }

    /// The value that a unit coordinate stands for.
    pub fn value(&self, unit: f64) -> Coordinate {
        let unit = unit.clamp(0.0, 1.0);
        match &self.range {
            Range::Real { low, high } => Coordinate::Real((low + unit * (high - low)).clamp(*low, *high)),
            Range::Log { low, high } => {
                let (from, to) = (libm::log(*low), libm::log(*high));
                Coordinate::Real(libm::exp(from + unit * (to - from)).clamp(*low, *high))
            }
            Range::Integer { low, high } => {
                Coordinate::Integer(low.saturating_add(self.cell(unit) as i64).min(*high))
            }
            Range::Categorical { choices } => Coordinate::Category(choices[self.cell(unit)].clone()),
        }
    }

    fn cell(&self, unit: f64) -> usize {
        let levels = self.levels().unwrap_or(1) as f64;
        (unit * levels).floor().min(levels - 1.0) as usize
    }

    /// The unit coordinate of a value.
    ///
    /// # Errors
    /// [`Error::Value`] when the value is of another kind or out of range.
    pub fn unit(&self, value: &Coordinate) -> Result<f64, Error> {
        let outside = |expected: String| Error::Value {
            dimension: self.name.clone(),
            value: value.to_string(),
            expected,
        };
        match &self.range {
            Range::Real { low, high } => match value.number() {
                Some(number) if number >= *low && number <= *high => Ok((number - low) / (high - low)),
                _ => Err(outside(format!("a number from {low} to {high}"))),
            },
            Range::Log { low, high } => match value.number() {
                Some(number) if number >= *low && number <= *high => {
                    let from = libm::log(*low);
                    Ok(((libm::log(number) - from) / (libm::log(*high) - from)).clamp(0.0, 1.0))
                }
                _ => Err(outside(format!("a number from {low} to {high}"))),
            },
            Range::Integer { low, high } => match value {
                Coordinate::Integer(number) if number >= low && number <= high => {
                    let levels = self.levels().unwrap_or(1) as f64;
                    Ok((number.abs_diff(*low) as f64 + 0.5) / levels)
                }
                _ => Err(outside(format!("a whole number from {low} to {high}"))),
            },
            Range::Categorical { choices } => match value {
                Coordinate::Category(name) => match choices.iter().position(|choice| choice == name) {
                    Some(index) => Ok((index as f64 + 0.5) / choices.len() as f64),
                    None => Err(outside(format!("one of {}", choices.join(", ")))),
                },
                _ => Err(outside(format!("one of {}", choices.join(", ")))),
            },
        }
    }

    fn check(&self) -> Result<(), Error> {
        let empty = |reason: String| Error::Range { dimension: self.name.clone(), reason };
        match &self.range {
            Range::Real { low, high } | Range::Log { low, high }
                if !low.is_finite() || !high.is_finite() || !(high - low).is_finite() =>
            {
                Err(empty(format!("its bounds {low} and {high} must be finite")))
            }
            Range::Real { low, high } if low >= high => {
                Err(empty(format!("its low bound {low} is not below its high bound {high}")))
            }
            Range::Log { low, high } if *low <= 0.0 || low >= high => {
                Err(empty(format!("it needs 0 < low < high, not {low} and {high}")))
            }
            // Beyond 2^53 whole numbers can no longer be told apart in the unit cube.
            Range::Integer { low, high } if low >= high || high.abs_diff(*low) >= 1 << 53 => Err(empty(
                format!("it needs at least two and less than 2^53 whole numbers, not {low} to {high}"),
            )),
            Range::Categorical { choices } if choices.len() < 2 => {
                Err(empty(format!("it needs at least two choices, not {}", choices.len())))
            }
            Range::Categorical { choices } => {
                match (1..choices.len()).find(|&i| choices[..i].contains(&choices[i])) {
                    Some(i) => Err(empty(format!("its choice `{}` is given twice", choices[i]))),
                    None => Ok(()),
                }
            }
            _ => Ok(()),
        }
    }
}

/// One to ten dimensions. Checked when it is made, so that everything after may rely on it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<SearchDimension>", into = "Vec<SearchDimension>")]
pub struct Space {
    dimensions: Vec<SearchDimension>,
}

impl TryFrom<Vec<SearchDimension>> for Space {
    type Error = Error;

    fn try_from(dimensions: Vec<SearchDimension>) -> Result<Self, Error> {
        Space::new(dimensions)
    }
}

impl From<Space> for Vec<SearchDimension> {
    fn from(space: Space) -> Self {
        space.dimensions
    }
}

impl Space {
    /// A space of these dimensions.
    ///
    /// # Errors
    /// [`Error::Dimensions`] unless there are one to ten with different names; [`Error::Range`] for a range that is empty,
    /// holds one value only, or has bounds that are not finite.
    pub fn new(dimensions: Vec<SearchDimension>) -> Result<Self, Error> {
        if dimensions.is_empty() || dimensions.len() > LARGEST_DIMENSION_COUNT {
            return Err(Error::Dimensions(format!(
                "a search space has 1 to {LARGEST_DIMENSION_COUNT} dimensions, not {}",
                dimensions.len()
            )));
        }
        for (i, dimension) in dimensions.iter().enumerate() {
            if dimensions[..i].iter().any(|other| other.name == dimension.name) {
                return Err(Error::Dimensions(format!("dimension `{}` is given twice", dimension.name)));
            }
            dimension.check()?;
        }
        Ok(Space { dimensions })
    }

    /// The dimensions, in order.
    pub fn dimensions(&self) -> &[SearchDimension] {
        &self.dimensions
    }

    /// Number of different points, when every dimension is discrete.
    pub fn size(&self) -> Option<u64> {
        self.dimensions.iter().try_fold(1u64, |size, d| Some(size.saturating_mul(d.levels()?)))
    }

    /// Snaps unit coordinates in place to coordinates that stand for a point.
    pub fn snap(&self, unit: &mut [f64]) {
        for (coordinate, dimension) in unit.iter_mut().zip(&self.dimensions) {
            *coordinate = dimension.snap(*coordinate);
        }
    }

    /// The point that unit coordinates stand for.
    pub fn point(&self, unit: &[f64]) -> Point {
        self.dimensions.iter().zip(unit).map(|(dimension, &unit)| dimension.value(unit)).collect()
    }

    /// The unit coordinates of a point.
    ///
    /// # Errors
    /// [`Error::Value`] for a value of another kind or out of range, [`Error::Dimensions`] for a wrong number of values.
    pub fn unit(&self, point: &[Coordinate]) -> Result<Vec<f64>, Error> {
        if point.len() != self.dimensions.len() {
            return Err(Error::Dimensions(format!(
                "the point has {} values, the space {} dimensions",
                point.len(),
                self.dimensions.len()
            )));
        }
        self.dimensions.iter().zip(point).map(|(dimension, value)| dimension.unit(value)).collect()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn mixed() -> Space {
        Space::new(vec![
            SearchDimension::real("time", 6.0, 18.0),
            SearchDimension::log("gain", 1e-3, 1e3),
            SearchDimension::integer("count", -2, 4),
            SearchDimension::categorical("kind", ["a", "b", "c"]),
        ])
        .unwrap()
    }

    #[test]
    fn empty_ranges_are_errors_that_name_the_dimension() {
        let bad = [
            SearchDimension::real("x", 2.0, 2.0),
            SearchDimension::real("x", 3.0, 2.0),
            SearchDimension::real("x", f64::NAN, 2.0),
            SearchDimension::real("x", -f64::MAX, f64::MAX),
            SearchDimension::log("x", 0.0, 2.0),
            SearchDimension::integer("x", 4, 4),
            SearchDimension::integer("x", i64::MIN, i64::MAX),
            SearchDimension::categorical("x", ["only"]),
            SearchDimension::categorical("x", ["a", "b", "a"]),
        ];
        for dimension in bad {
            let error = Space::new(vec![dimension.clone()]).expect_err(&format!("{dimension:?}"));
            assert!(error.to_string().contains("`x`"), "{error}");
        }
        assert!(Space::new(vec![]).is_err());
        assert!(
            Space::new((0..11).map(|i| SearchDimension::real(&i.to_string(), 0.0, 1.0)).collect()).is_err()
        );
        assert!(
            Space::new(vec![SearchDimension::real("x", 0.0, 1.0), SearchDimension::real("x", 0.0, 1.0)])
                .is_err()
        );
    }

    #[test]
    fn points_outside_are_errors() {
        let space = mixed();
        let good = space.point(&[0.5, 0.5, 0.5, 0.5]);
        for (i, bad) in [
            Coordinate::Real(19.0),
            Coordinate::Real(f64::NAN),
            Coordinate::Real(0.5),
            Coordinate::Category("d".into()),
        ]
        .into_iter()
        .enumerate()
        {
            let mut point = good.clone();
            point[i] = bad;
            assert!(matches!(space.unit(&point), Err(Error::Value { .. })), "{point:?}");
        }
        assert!(space.unit(&good[..3]).is_err());
    }

    proptest! {
        #[test]
        fn a_snapped_coordinate_and_its_point_stand_for_each_other(unit in prop::array::uniform4(0.0..=1.0f64)) {
            let space = mixed();
            let mut snapped = unit.to_vec();
            space.snap(&mut snapped);
            let point = space.point(&snapped);
            let back = space.unit(&point).unwrap();
            for (a, b) in snapped.iter().zip(&back) {
                prop_assert!((a - b).abs() < 1e-12, "{a} {b}");
            }
            // Discrete coordinates are the same bits, so that duplicates are found by equality.
            prop_assert_eq!(&snapped[2..], &back[2..]);
            prop_assert_eq!(&point, &space.point(&unit));
            let text = serde_json::to_string(&point).unwrap();
            prop_assert_eq!(point, serde_json::from_str::<Point>(&text).unwrap());
        }
    }
}
