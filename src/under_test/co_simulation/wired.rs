//! A variable of a functional mock-up unit and the signal or parameter that it stands for.

use ::fmu::Kind;
use serde::{Deserialize, Serialize};

/// A variable that stands for a signal or a parameter. A number `n` of it is `n * numerator / denominator` in SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Wired {
    /// As the file calls it.
    pub name: String,
    /// As the unit calls it.
    pub variable: String,
    pub reference: u32,
    pub kind: Kind,
    pub numerator: f64,
    pub denominator: f64,
    /// Words, and the numbers that stand for them.
    pub items: Vec<(String, i64)>,
}

impl Wired {
    /// The number of the variable that is `si` in SI units.
    pub fn of_si(&self, si: f64) -> f64 {
        si * self.denominator / self.numerator
    }

    /// The number in SI units.
    pub fn to_si(&self, number: f64) -> f64 {
        number * self.numerator / self.denominator
    }
}
