//! Candidates: grids, random designs over ranges, and parameter sets that give some parameters while others vary.

use std::fmt;

use thiserror::Error;

use crate::pedestrian::commotions::parameters::{fitted_by, published_range};
use crate::pedestrian::commotions::{Parameters, Variant};
use numbers::design::Slices;
use numbers::random::{Draws, Stream, derive_seed};
use scenario::{Declaration, SettingError, Text, Value};

/// The values a parameter may take: log-spaced between two ends.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterRange {
    /// The parameter.
    pub name: Text,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// How many values a grid has, both ends included.
    pub levels: usize,
}

impl ParameterRange {
    /// The value at a share of the way from low to high, on a log scale.
    fn at(&self, share: f64) -> f64 {
        six_digits(self.low * libm::pow(self.high / self.low, share))
    }

    /// The value of a grid's level, counted from 0.
    fn level(&self, level: usize) -> f64 {
        if self.levels < 2 {
            return self.low;
        }
        if level + 1 == self.levels {
            return self.high;
        }
        self.at(level as f64 / (self.levels - 1) as f64)
    }
}

/// The published grid of the parameters that a variant fits (§9.1): ten log-spaced values each.
pub fn published_grid(variant: &Variant) -> Vec<ParameterRange> {
    let range = |name| {
        let (low, high) = published_range(name);
        ParameterRange { name: name.into(), low, high, levels: 10 }
    };
    fitted_by(variant).into_iter().map(range).collect()
}

/// How candidates are taken from the ranges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Design {
    /// Every combination of the levels.
    Grid,
    /// This many different combinations of the levels, drawn at random.
    FromGrid(usize),
    /// This many, log-uniform and independent.
    LogUniform(usize),
    /// This many in a Latin hypercube on log scales.
    LatinHypercube(usize),
}

impl fmt::Display for Design {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Grid => write!(f, "grid"),
            Self::FromGrid(count) => write!(f, "{count} at random from the grid"),
            Self::LogUniform(count) => write!(f, "{count} log-uniform"),
            Self::LatinHypercube(count) => write!(f, "{count} in a Latin hypercube (log scales)"),
        }
    }
}

/// Parameter sets to be judged: names, and one row of values each.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidates {
    /// The parameters.
    pub names: Vec<String>,
    /// Their values.
    pub rows: Vec<Vec<f64>>,
}

/// Why there are no candidates.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CandidateError {
    /// A range names no parameter.
    #[error("there is no parameter `{0}`")]
    UnknownParameter(String),
    /// A range reaches outside what the parameter may be.
    #[error(transparent)]
    OutOfRange(#[from] SettingError),
    /// A range on a log scale from or across zero.
    #[error("the range of `{name}` is {low} .. {high}; it must be positive and rising")]
    BadRange {
        /// The parameter.
        name: Text,
        /// Its low end.
        low: f64,
        /// Its high end.
        high: f64,
    },
    /// A range or draw of a parameter that the candidates have already.
    #[error("the candidates have values of `{0}`: leave out its range or draw")]
    Given(Text),
    /// A distribution with values that the parameter may not have.
    #[error(
        "{draw}: {reason}; `truncated_normal(mean, standard deviation, low, high)` and `uniform(low, high)` say where they end"
    )]
    BadDraw {
        /// In words.
        draw: String,
        /// What is wrong.
        reason: String,
    },
    /// More candidates than a grid has combinations, or than anybody waits for.
    #[error("{wanted} candidates are more than the {most} there can be")]
    TooMany {
        /// Wanted.
        wanted: usize,
        /// Possible.
        most: usize,
    },
}

fn check_ranges<'r>(
    ranges: impl Iterator<Item = &'r ParameterRange>,
    model: &Declaration,
) -> Result<(), CandidateError> {
    for range in ranges {
        let ParameterRange { name, low, high, .. } = range.clone();
        let parameter =
            model.parameter(&name).ok_or_else(|| CandidateError::UnknownParameter(name.to_string()))?;
        parameter.check(&model.name, &Value::Number(low))?;
        parameter.check(&model.name, &Value::Number(high))?;
        if !(low > 0.0 && high >= low) {
            return Err(CandidateError::BadRange { name, low, high });
        }
    }
    Ok(())
}

/// More candidates than this are taken for a mistake.
const MOST_CANDIDATES: usize = 10_000_000;

impl Candidates {
    /// The same candidates with more parameters, each over its range in strata on a log scale: who has which value is drawn by `seed`.
    ///
    /// # Errors
    /// For ranges that cannot be, and for parameters that the candidates have.
    pub fn with_ranges(
        mut self,
        ranges: &[ParameterRange],
        seed: u64,
        model: &Declaration,
    ) -> Result<Self, CandidateError> {
        check_ranges(ranges.iter(), model)?;
        for range in ranges {
            if self.names.iter().any(|name| *name == range.name) {
                return Err(CandidateError::Given(range.name.clone()));
            }
            let mut stream = Stream::seeded(derive_seed(seed, &format!("candidates/{}", range.name)));
            let slices = Slices::drawn(self.rows.len(), &mut stream);
            for (index, row) in self.rows.iter_mut().enumerate() {
                row.push(range.at(slices.place(index, &mut stream)));
            }
            self.names.push(range.name.to_string());
        }
        Ok(self)
    }

    /// The candidates of a design over `ranges`, crossed with the rows of `base`, which gives other parameters.
    ///
    /// A range of a parameter that `base` gives is left out. Without a base, pass one with a single empty row.
    ///
    /// # Errors
    /// For ranges that cannot be, and for more candidates than there can be.
    pub fn design(
        base: &Self,
        ranges: &[ParameterRange],
        design: Design,
        seed: u64,
        model: &Declaration,
    ) -> Result<Self, CandidateError> {
        let ranges: Vec<&ParameterRange> =
            ranges.iter().filter(|range| !base.names.iter().any(|name| *name == range.name)).collect();
        check_ranges(ranges.iter().copied(), model)?;
        let sets = base.rows.len();
        let combinations =
            ranges.iter().fold(sets, |product, range| product.saturating_mul(range.levels.max(1)));
        let (count, most) = match design {
            Design::Grid => (combinations, MOST_CANDIDATES),
            Design::FromGrid(count) => (count, combinations.min(MOST_CANDIDATES)),
            Design::LogUniform(count) | Design::LatinHypercube(count) => (count, MOST_CANDIDATES),
        };
        if count > most {
            return Err(CandidateError::TooMany { wanted: count, most });
        }
        let mut stream = Stream::seeded(derive_seed(seed, "candidates"));
        // A combination's number in mixed radix: the base's row, then a level per range.
        let combination = |mut number: usize| {
            let mut row = base.rows[number % sets].clone();
            number /= sets;
            for range in &ranges {
                row.push(range.level(number % range.levels.max(1)));
                number /= range.levels.max(1);
            }
            row
        };
        let rows = match design {
            Design::Grid => (0..count).map(combination).collect(),
            Design::FromGrid(_) => {
                let mut chosen = std::collections::BTreeSet::new();
                while chosen.len() < count {
                    chosen.insert(stream.index(combinations));
                }
                chosen.into_iter().map(combination).collect()
            }
            Design::LogUniform(_) => (0..count)
                .map(|_| {
                    let mut row = base.rows[stream.index(sets)].clone();
                    row.extend(ranges.iter().map(|range| range.at(stream.uniform())));
                    row
                })
                .collect(),
            Design::LatinHypercube(_) => {
                let slices: Vec<Slices> = ranges.iter().map(|_| Slices::drawn(count, &mut stream)).collect();
                // Rows of the base in turn, in random order.
                let turns = stream.shuffled(count);
                (0..count)
                    .map(|index| {
                        let mut row = base.rows[turns[index] % sets].clone();
                        for (range, slices) in ranges.iter().zip(&slices) {
                            row.push(range.at(slices.place(index, &mut stream)));
                        }
                        row
                    })
                    .collect()
            }
        };
        let varied = ranges.iter().map(|range| range.name.to_string());
        Ok(Self { names: base.names.iter().cloned().chain(varied).collect(), rows })
    }

    /// Nothing given: the base of a design that varies everything.
    pub fn nothing_given() -> Self {
        Self { names: Vec::new(), rows: vec![Vec::new()] }
    }

    /// The parameters of the candidates, numbered from 1; everything else has its default.
    ///
    /// # Errors
    /// If a name is no parameter.
    pub fn parameters(&self) -> Result<Vec<(usize, Parameters)>, CandidateError> {
        let row = |(index, row): (usize, &Vec<f64>)| {
            let mut parameters = Parameters::default();
            for (name, value) in self.names.iter().zip(row) {
                let field =
                    parameters.get_mut(name).ok_or_else(|| CandidateError::UnknownParameter(name.clone()))?;
                *field = *value;
            }
            Ok((index + 1, parameters))
        };
        self.rows.iter().enumerate().map(row).collect()
    }
}

/// The number with six significant digits, so that what a file says is what was judged.
pub(super) fn six_digits(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::pedestrian::commotions::model::commotions;

    const RANGES: [ParameterRange; 2] = [
        ParameterRange { name: Text::Borrowed("T_delta"), low: 10.0, high: 100.0, levels: 10 },
        ParameterRange { name: Text::Borrowed("T"), low: 0.1, high: 0.5, levels: 10 },
    ];

    fn design(base: &Candidates, design: Design) -> Result<Candidates, CandidateError> {
        Candidates::design(base, &RANGES, design, 1, &commotions().declaration)
    }

    fn bits(rows: &[Vec<f64>]) -> BTreeSet<Vec<u64>> {
        rows.iter().map(|row| row.iter().map(|x| x.to_bits()).collect()).collect()
    }

    #[test]
    fn a_grid_is_the_published_one_and_its_samples_are_in_it() {
        let grid = design(&Candidates::nothing_given(), Design::Grid).unwrap();
        assert_eq!(grid.names, ["T_delta", "T"]);
        assert_eq!((grid.rows.len(), bits(&grid.rows).len()), (100, 100));
        assert!(grid.rows.iter().any(|row| row[0] == 12.9155 && row[1] == 0.119581));
        let some = design(&Candidates::nothing_given(), Design::FromGrid(40)).unwrap();
        assert_eq!(bits(&some.rows).len(), 40);
        assert!(bits(&some.rows).is_subset(&bits(&grid.rows)));
    }

    #[test]
    fn a_base_gives_its_parameters_and_the_rest_varies() {
        let base = Candidates { names: vec!["T_delta".into()], rows: vec![vec![11.0], vec![22.0]] };
        let crossed = design(&base, Design::Grid).unwrap();
        assert_eq!(crossed.names, ["T_delta", "T"]);
        assert_eq!(crossed.rows.len(), 20);
        let (number, parameters) = crossed.parameters().unwrap()[1].clone();
        assert_eq!((number, parameters.discount_half_life, parameters.evidence_time), (2, 22.0, 0.1));
    }

    #[test]
    fn a_latin_hypercube_has_one_candidate_in_every_stratum() {
        let hypercube = design(&Candidates::nothing_given(), Design::LatinHypercube(50)).unwrap();
        for (column, range) in RANGES.iter().enumerate() {
            let strata: BTreeSet<usize> = hypercube
                .rows
                .iter()
                .map(|row| (50.0 * (row[column] / range.low).ln() / (range.high / range.low).ln()) as usize)
                .collect();
            // Rounding to six digits may move a value over the edge of its stratum.
            assert!(strata.len() >= 49, "{}", strata.len());
        }
    }

    #[test]
    fn impossible_designs_say_why() {
        let none = Candidates::nothing_given();
        assert_eq!(
            design(&none, Design::FromGrid(101)),
            Err(CandidateError::TooMany { wanted: 101, most: 100 })
        );
        let with = |name: &'static str, low, high| {
            let ranges = [ParameterRange { name: name.into(), low, high, levels: 3 }];
            Candidates::design(&none, &ranges, Design::Grid, 1, &commotions().declaration)
                .unwrap_err()
                .to_string()
        };
        assert_eq!(with("T_delta", 0.5, 10.0), "`T_delta` of `commotions` is 0.5, outside 1 .. 300 s");
        assert_eq!(
            with("beta_V", 0.0, 10.0),
            "the range of `beta_V` is 0 .. 10; it must be positive and rising"
        );
        assert_eq!(with("beta", 1.0, 10.0), "there is no parameter `beta`");
    }
}
