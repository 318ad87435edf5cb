//! What evaluations tell, and the history the models learn from.

use serde::{Deserialize, Serialize};

use super::Error;
use super::definition::Definition;
use super::space::Point;
use super::surrogate::Noise;

/// Numbers beyond this count as undefined: their squares overflow.
const LARGEST_VALUE: f64 = 1e150;

/// One objective's value at a point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ObjectiveValue {
    /// The value in its own unit and direction; `None` (or NaN) when it is undefined there or the candidate was abandoned.
    pub value: Option<f64>,
    /// Variance of the value's error, when repetitions gave one; otherwise the model estimates a common one.
    pub noise_variance: Option<f64>,
}

/// One constraint's margin at a point: how far it is from being violated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Margin {
    /// Worst margin over the set; ≥ 0 is feasible; `None` (or NaN) when undefined.
    pub value: Option<f64>,
    /// The candidate was abandoned: the worst margin is this or lower.
    pub censored: bool,
    /// The constraint is kept, though nothing says by how much: what it bounds never arose.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub kept: bool,
}

impl Margin {
    /// Of a candidate that was not abandoned.
    pub fn of(value: Option<f64>) -> Self {
        Self { value, censored: false, kept: false }
    }

    /// Of a constraint that is kept, though nothing says by how much.
    pub fn kept() -> Self {
        Self { value: None, censored: false, kept: true }
    }

    /// Is the constraint known to be kept?
    pub fn is_kept(&self) -> bool {
        !self.censored && (self.kept || self.value.is_some_and(|value| value >= 0.0))
    }
}

/// All that one evaluation tells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// One measurement per objective of the definition.
    pub objectives: Vec<ObjectiveValue>,
    /// One margin per constraint of the definition.
    pub margins: Vec<Margin>,
    /// How many independent repetitions the values are means of.
    pub repetitions: u32,
    /// How many of its parts were left out because they cannot be evaluated.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub left_out: u32,
}

fn is_zero(number: &u32) -> bool {
    *number == 0
}

impl Evaluation {
    /// One unconstrained objective, evaluated once.
    pub fn of(value: f64) -> Self {
        Evaluation::constrained(value, &[])
    }

    /// One objective and margins, evaluated once, not abandoned.
    pub fn constrained(value: f64, margins: &[f64]) -> Self {
        Evaluation {
            objectives: vec![ObjectiveValue { value: Some(value), noise_variance: None }],
            margins: margins.iter().map(|&value| Margin::of(Some(value))).collect(),
            repetitions: 1,
            left_out: 0,
        }
    }

    /// An evaluation without any defined value: it failed, or its metric does not exist there.
    pub fn undefined(definition: &Definition) -> Self {
        let margin = Margin::of(None);
        Evaluation {
            objectives: vec![
                ObjectiveValue { value: None, noise_variance: None };
                definition.objectives.len()
            ],
            margins: vec![margin; definition.constraints],
            repetitions: 1,
            left_out: 0,
        }
    }

    /// Is some margin known to be negative?
    pub fn is_violated(&self) -> bool {
        self.margins.iter().any(|margin| margin.value.is_some_and(|value| value < 0.0))
    }

    /// Are all objectives defined and all margins known to be ≥ 0?
    pub fn is_feasible(&self) -> bool {
        self.objectives.iter().all(|measurement| measurement.value.is_some()) && self.keeps_constraints()
    }

    /// Are all constraints known to be kept?
    pub fn keeps_constraints(&self) -> bool {
        self.margins.iter().all(Margin::is_kept)
    }

    /// Checks it against the definition and turns numbers that are not finite into undefined ones.
    ///
    /// # Errors
    /// [`Error::Evaluation`] if it does not fit.
    pub fn checked(mut self, definition: &Definition) -> Result<Self, Error> {
        let refuse = |reason: String| Err(Error::Evaluation(reason));
        if self.objectives.len() != definition.objectives.len() {
            let (got, expected) = (self.objectives.len(), definition.objectives.len());
            return refuse(format!("it has {got} objective values where the definition has {expected}"));
        }
        if self.margins.len() != definition.constraints {
            let (got, expected) = (self.margins.len(), definition.constraints);
            return refuse(format!("it has {got} constraint margins where the definition has {expected}"));
        }
        if self.repetitions == 0 {
            return refuse("it is a mean of 0 repetitions; give at least 1".to_owned());
        }
        let usable = |value: f64| value.abs() <= LARGEST_VALUE;
        for measurement in &mut self.objectives {
            measurement.value = measurement.value.filter(|&value| usable(value));
            if let Some(variance) = measurement.noise_variance
                && !(variance >= 0.0 && usable(variance))
            {
                return refuse(format!("its noise variance {variance} is not a finite number ≥ 0"));
            }
        }
        for margin in &mut self.margins {
            margin.value = margin.value.filter(|&value| usable(value));
        }
        Ok(self)
    }
}

/// A point that was evaluated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EvaluatedPoint {
    /// The proposal's number, from 0 in the order of asking.
    pub id: u64,
    /// Unit coordinates.
    pub(super) unit: Vec<f64>,
    /// Where.
    pub point: Point,
    /// What came out.
    pub evaluation: Evaluation,
}

impl EvaluatedPoint {
    /// Is some margin known to be negative?
    pub fn is_violated(&self) -> bool {
        self.evaluation.is_violated()
    }

    /// Are all objectives defined and all margins known to be ≥ 0?
    pub fn is_feasible(&self) -> bool {
        self.evaluation.is_feasible()
    }

    /// Is something undefined that no violated constraint explains?
    pub fn is_undefined(&self) -> bool {
        let undefined = self.evaluation.objectives.iter().any(|measurement| measurement.value.is_none())
            || self.evaluation.margins.iter().any(|margin| margin.value.is_none() && !margin.kept);
        undefined && !self.is_violated()
    }
}

/// A value at a distinct place: duplicates merged into their mean, weighted by repetitions.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Datum {
    pub unit: Vec<f64>,
    pub value: f64,
    /// Noise of the mean; `known` in the square of the value's unit.
    pub noise: Noise,
    repetitions: f64,
}

/// Merges the values of trials at the same place, in order of first appearance.
pub(super) fn merged<'a>(values: impl Iterator<Item = (&'a EvaluatedPoint, f64, Option<f64>)>) -> Vec<Datum> {
    let mut data: Vec<Datum> = Vec::new();
    for (trial, value, variance) in values {
        let count = f64::from(trial.evaluation.repetitions);
        let noise = match variance {
            Some(known) => Noise { shared: 0.0, known },
            None => Noise { shared: 1.0 / count, known: 0.0 },
        };
        match data.iter_mut().find(|datum| datum.unit == trial.unit) {
            None => data.push(Datum { unit: trial.unit.clone(), value, noise, repetitions: count }),
            Some(datum) => {
                let all = datum.repetitions + count;
                let (old, new) = (datum.repetitions / all, count / all);
                datum.value = old * datum.value + new * value;
                datum.noise.shared = old * old * datum.noise.shared + new * new * noise.shared;
                datum.noise.known = old * old * datum.noise.known + new * new * noise.known;
                datum.repetitions = all;
            }
        }
    }
    data
}

#[cfg(test)]
mod tests {
    use super::super::space::{SearchDimension, Space};
    use super::*;

    fn trial(x: f64, value: f64, repetitions: u32) -> EvaluatedPoint {
        let evaluation = Evaluation { repetitions, ..Evaluation::of(value) };
        EvaluatedPoint { id: 0, unit: vec![x], point: vec![], evaluation }
    }

    #[test]
    fn trap_duplicates_become_a_mean_with_less_noise() {
        let trials = [trial(0.5, 1.0, 1), trial(0.2, 9.0, 1), trial(0.5, 4.0, 2)];
        let data = merged(trials.iter().map(|t| (t, t.evaluation.objectives[0].value.unwrap(), None)));
        assert_eq!(data.len(), 2);
        assert_eq!(data[0].value, 3.0);
        assert!((data[0].noise.shared - 1.0 / 3.0).abs() < 1e-15);
        let known = merged(trials.iter().map(|t| (t, 0.0, Some(0.09))));
        assert_eq!(known[0].noise.shared, 0.0);
        assert!((known[0].noise.known - 0.05).abs() < 1e-15);
    }

    #[test]
    fn numbers_that_are_not_finite_are_undefined_and_mismatches_are_errors() {
        let space = Space::new(vec![SearchDimension::real("x", 0.0, 1.0)]).unwrap();
        let definition = Definition { constraints: 1, ..Definition::new(space, 0) };
        let evaluation = Evaluation::constrained(f64::NAN, &[f64::INFINITY]).checked(&definition).unwrap();
        assert_eq!(evaluation, Evaluation::undefined(&definition));
        assert!(Evaluation::of(1.0).checked(&definition).is_err());
        let none = Evaluation { repetitions: 0, ..Evaluation::constrained(1.0, &[1.0]) };
        assert!(none.checked(&definition).is_err());
        let mut negative = Evaluation::constrained(1.0, &[1.0]);
        negative.objectives[0].noise_variance = Some(-1.0);
        assert!(negative.checked(&definition).is_err());
    }

    #[test]
    fn an_abandoned_candidate_is_violated_and_not_undefined() {
        let mut abandoned = trial(0.5, f64::NAN, 1);
        abandoned.evaluation.objectives[0].value = None;
        assert!(abandoned.is_undefined());
        abandoned.evaluation.margins = vec![Margin { censored: true, ..Margin::of(Some(-0.2)) }];
        assert!(abandoned.is_violated() && !abandoned.is_undefined() && !abandoned.is_feasible());
    }
}
