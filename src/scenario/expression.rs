//! Arithmetic over variations, evaluated once per case.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::Value;

/// A value that may depend on variations. Dimensions were checked when the text was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Expression {
    /// The same in every case, SI units.
    Constant(Value),
    /// The value of the variation of this name.
    Variable(String),
    /// Of a number.
    Negated(Box<Expression>),
    /// Of two numbers.
    Binary {
        /// What is done with them.
        operator: BinaryOperator,
        /// The number before the operator.
        left: Box<Expression>,
        /// The number after the operator.
        right: Box<Expression>,
    },
}

/// The four kinds of arithmetic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BinaryOperator {
    /// `+`
    Add,
    /// `-`
    Subtract,
    /// `*`
    Multiply,
    /// `/`
    Divide,
}

/// Why an expression has no value in a case.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum EvaluationError {
    /// It names a variation that the case has no value of.
    #[error("`{0}` has no value here")]
    Unbound(String),
    /// A word or a flag stands where it calculates, or where only a number makes sense; its text.
    #[error("arithmetic needs numbers, but found `{0}`")]
    NotANumber(String),
    /// A number or a flag stands where a model is named; its text.
    #[error("a name is needed here, but found `{0}`")]
    NotAWord(String),
    /// It divides by 0, or is larger than a number can be.
    #[error("the result of the arithmetic is not a finite number")]
    NotFinite,
}

impl Expression {
    /// A constant in SI units.
    pub const fn number(number: f64) -> Self {
        Self::Constant(Value::Number(number))
    }

    /// The value with every variable looked up in `variables`.
    pub fn evaluate(&self, variables: &BTreeMap<String, Value>) -> Result<Value, EvaluationError> {
        match self {
            Self::Constant(value) => Ok(value.clone()),
            Self::Variable(name) => {
                variables.get(name).cloned().ok_or_else(|| EvaluationError::Unbound(name.clone()))
            }
            Self::Negated(operand) => Ok(Value::Number(-operand.evaluate_number(variables)?)),
            Self::Binary { operator, left, right } => {
                let left = left.evaluate_number(variables)?;
                let right = right.evaluate_number(variables)?;
                let result = match operator {
                    BinaryOperator::Add => left + right,
                    BinaryOperator::Subtract => left - right,
                    BinaryOperator::Multiply => left * right,
                    BinaryOperator::Divide => left / right,
                };
                if result.is_finite() { Ok(Value::Number(result)) } else { Err(EvaluationError::NotFinite) }
            }
        }
    }

    /// As [`Self::evaluate`], for places where only a number makes sense.
    pub fn evaluate_number(&self, variables: &BTreeMap<String, Value>) -> Result<f64, EvaluationError> {
        match self.evaluate(variables)? {
            Value::Number(number) => Ok(number),
            other => Err(EvaluationError::NotANumber(other.to_string())),
        }
    }

    /// The names of the variables it depends on, in order of appearance.
    pub fn variables(&self) -> Vec<&str> {
        match self {
            Self::Constant(_) => Vec::new(),
            Self::Variable(name) => vec![name],
            Self::Negated(operand) => operand.variables(),
            Self::Binary { left, right, .. } => {
                let mut names = left.variables();
                names.extend(right.variables());
                names
            }
        }
    }
}

impl From<f64> for Expression {
    fn from(number: f64) -> Self {
        Self::number(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_over_variables() {
        let variables = BTreeMap::from([("tta".to_string(), Value::Number(6.0))]);
        let doubled = Expression::Binary {
            operator: BinaryOperator::Multiply,
            left: Box::new(Expression::Variable("tta".into())),
            right: Box::new(2.0.into()),
        };
        assert_eq!(doubled.evaluate_number(&variables), Ok(12.0));
        assert_eq!(doubled.variables(), ["tta"]);
        assert_eq!(doubled.evaluate(&BTreeMap::new()), Err(EvaluationError::Unbound("tta".into())));
    }

    #[test]
    fn division_by_zero_is_an_error() {
        let division = Expression::Binary {
            operator: BinaryOperator::Divide,
            left: Box::new(1.0.into()),
            right: Box::new(0.0.into()),
        };
        assert_eq!(division.evaluate(&BTreeMap::new()), Err(EvaluationError::NotFinite));
    }
}
