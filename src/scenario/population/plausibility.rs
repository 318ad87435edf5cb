//! Where a person stands in a population: how many of it are no more usual.

use std::sync::OnceLock;

use super::{Population, SHIPPED, SHIPPED_MODEL, VARIANT};
use crate::{Declaration, Settings, Value};
use numbers::distributions::KernelDensity;

/// How usual parameter sets are in a population: a density of the logarithms of its parameters.
#[derive(Debug, Clone)]
pub struct Plausibility {
    model: String,
    variant: Option<String>,
    /// Of the density, with their columns' names.
    varied: Vec<String>,
    /// What everybody has.
    alike: Vec<(String, f64)>,
    density: KernelDensity,
}

/// Of those that ship, in their order.
static KNOWN: [OnceLock<Option<Plausibility>>; SHIPPED.len()] = [const { OnceLock::new() }; SHIPPED.len()];

impl Plausibility {
    /// Of the population of this name that ships: read and worked out once, when the first asks. `None` of every other name, and for every
    /// model but that of its people, of whom nothing is read.
    pub fn of_shipped(name: &str, model: &Declaration) -> Option<&'static Self> {
        let place = SHIPPED.iter().position(|(known, ..)| *known == name)?;
        if model.name != SHIPPED_MODEL {
            return None;
        }
        let known = &KNOWN[place];
        if known.get().is_none() {
            // A model of the same name that cannot be such people leaves them to the one that can.
            let population = Population::parse(name, None, model, None).ok()?;
            known.get_or_init(|| Self::of(&population));
        }
        known.get()?.as_ref()
    }

    /// Of a population; `None` where its people are too few or too much alike to have a density, or have values without a logarithm.
    pub fn of(population: &Population) -> Option<Self> {
        let rows = &population.individuals;
        let equal = vec![1.0; rows.len()];
        let weights = if population.weights.is_empty() { &equal } else { &population.weights };
        let first = rows.first()?;
        let is_alike = |column: usize| rows.iter().all(|row| row[column] == first[column]);
        let named = population.parameters.iter().enumerate();
        let (alike, varied): (Vec<_>, Vec<_>) = named.partition(|(column, _)| is_alike(*column));
        let points: Vec<Vec<f64>> = rows
            .iter()
            .map(|row| varied.iter().map(|(column, _)| libm::log(row[*column])).collect())
            .collect();
        if points.iter().flatten().any(|one| !one.is_finite()) {
            return None;
        }
        Some(Self {
            model: population.model.clone(),
            variant: population.variant.clone(),
            varied: varied.into_iter().map(|(_, name)| name.clone()).collect(),
            alike: alike.into_iter().map(|(column, name)| (name.clone(), first[column])).collect(),
            density: KernelDensity::new(&points, weights)?,
        })
    }

    /// The share of the population that is no more usual than a person of these parameters: 0 where nobody is like them, and for half
    /// of the population below one half. `None` of those of whom the population says nothing: of another model or variant, without one of its
    /// parameters, or with another value than the default of a parameter that it does not have.
    pub fn tail(&self, model: &Declaration, person: &Settings) -> Option<f64> {
        let known = |name: &str| {
            name == VARIANT
                || self.varied.iter().any(|one| one == name)
                || self.alike.iter().any(|(one, _)| one == name)
        };
        let usual = |name: &str, value: &Value| {
            let default = model.parameter(name).and_then(|parameter| parameter.default_value());
            default.as_ref() == Some(value)
        };
        if model.name != self.model {
            return None;
        }
        if let (Some(own), Some(Value::Word(word))) = (&self.variant, person.get(VARIANT))
            && own != word
        {
            return None;
        }
        if person.0.iter().any(|(name, value)| !known(name) && !usual(name, value)) {
            return None;
        }
        let number = |name: &str| match person.get(name) {
            Some(Value::Number(number)) => Some(*number),
            _ => None,
        };
        for (name, value) in &self.alike {
            if number(name)? != *value {
                return Some(0.0);
            }
        }
        let values: Option<Vec<f64>> = self.varied.iter().map(|name| number(name)).collect();
        let point: Vec<f64> = values?.into_iter().map(libm::log).collect();
        if point.iter().any(|one| !one.is_finite()) {
            return Some(0.0);
        }
        Some(self.density.tail(&point))
    }
}
