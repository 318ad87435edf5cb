//! What of a case can be moved, and where it is declared to be: its nominal value.

use crate::plan::{PlanError, Variables, concrete_case, variables};
use scenario::{
    Assignment, Case, Dimension, DrawSource, Individual, KnownDistribution, ParameterKind, Scenario, Value,
    Variation, VariedValue,
};

/// A case in the terms of its scenario, while it is being moved.
#[derive(Debug, Clone, PartialEq)]
pub struct KnobPlace {
    /// Without the road users that were left out.
    pub scenario: Scenario,
    /// The values of its variations there.
    pub variation: Vec<Assignment>,
    /// The people who walk there.
    pub individuals: Vec<Individual>,
    /// That of the case where it began; it stays.
    pub key: String,
    /// That of the case where it began; it stays.
    pub seed: u64,
}

impl KnobPlace {
    /// The case there.
    ///
    /// # Errors
    /// If its values do not go together.
    pub fn case(&self) -> Result<Case, PlanError> {
        let (variation, individuals) = (self.variation.clone(), self.individuals.clone());
        concrete_case(&self.scenario, self.key.clone(), variation, individuals, 1, self.seed)
    }
}

/// A number of a case that may be moved.
#[derive(Debug, Clone, PartialEq)]
pub struct Knob {
    /// `tta`, `walker.T_delta`
    pub name: String,
    /// What is declared, SI units.
    pub nominal: f64,
    /// What says so: `the middle of its range`.
    pub why: &'static str,
    /// The words that a variation gave it in, such as `6s`.
    pub label: Option<String>,
    /// Of a person's parameter.
    pub dimension: Option<Dimension>,
    whose: Whose,
}

#[derive(Debug, Clone, PartialEq)]
enum Whose {
    /// Index into [`KnobPlace::variation`].
    Variation(usize),
    /// Index into [`KnobPlace::individuals`], and the parameter's name.
    Person(usize, String),
}

impl Knob {
    /// Its value at a place of the case that it was made of, SI units.
    pub fn value(&self, place: &KnobPlace) -> f64 {
        let value = match &self.whose {
            Whose::Variation(index) => place.variation[*index].value.as_number(),
            Whose::Person(index, name) => {
                place.individuals[*index].parameters.0.get(name).and_then(Value::as_number)
            }
        };
        value.expect("a knob is made of a number")
    }

    /// Gives it a value at a place of the case that it was made of, SI units.
    pub fn set(&self, place: &mut KnobPlace, number: f64) {
        match &self.whose {
            Whose::Variation(index) => place.variation[*index].value = Value::Number(number),
            Whose::Person(index, name) => {
                place.individuals[*index].parameters.set(name.clone(), Value::Number(number));
            }
        }
    }
}

/// Every number that can be moved: those of variations in their order, then those of people. Words and flags stay, and so
/// do values that `vary together` gives only in rows, and what the scenario itself fixes.
pub fn knobs(place: &KnobPlace) -> Vec<Knob> {
    let mut found = Vec::new();
    for (index, assignment) in place.variation.iter().enumerate() {
        let varied = place.scenario.variations.iter().find_map(|variation| {
            nominal(variation, &assignment.name, &variables(&place.variation))
                .filter(|_| assignment.value.as_number().is_some())
        });
        let varied = varied.or_else(|| drawn(place, assignment));
        found.extend(varied.map(|(nominal, why)| Knob {
            name: assignment.name.clone(),
            nominal,
            why,
            label: Some(assignment.label.clone()),
            dimension: None,
            whose: Whose::Variation(index),
        }));
    }
    for (index, individual) in place.individuals.iter().enumerate() {
        let declared = place.scenario.pedestrians.iter().find(|one| one.name == individual.pedestrian);
        let Some(declared) = declared else { continue };
        let Some(model) = declared.model.first.declaration() else { continue };
        for name in individual.parameters.0.keys() {
            let is_fixed = declared.model.settings.iter().any(|(fixed, _)| fixed == name);
            let default = match model.parameter(name).map(|parameter| &parameter.kind) {
                Some(ParameterKind::Number { default, dimension, .. }) => default.zip(Some(*dimension)),
                _ => None,
            };
            let value = individual.parameters.0.get(name).and_then(Value::as_number);
            if let (false, Some((nominal, dimension)), Some(_)) = (is_fixed, default, value) {
                found.push(Knob {
                    name: format!("{}.{name}", individual.pedestrian),
                    nominal,
                    why: "its default",
                    label: None,
                    dimension: Some(dimension),
                    whose: Whose::Person(index, name.clone()),
                });
            }
        }
    }
    found
}

/// As [`nominal`], of what is drawn anew in every run. Values of a table belong together, and stay.
fn drawn(place: &KnobPlace, assignment: &Assignment) -> Option<(f64, &'static str)> {
    assignment.value.as_number()?;
    let draw = place.scenario.draws.iter().find(|draw| draw.names.contains(&assignment.name))?;
    match &draw.from {
        DrawSource::Distribution { distribution, .. } => {
            distribution.known(&variables(&place.variation)).ok()?.nominal()
        }
        DrawSource::Table(table) if draw.names.len() == 1 => {
            let values: Vec<VariedValue> = table.rows.iter().map(|row| row[0].clone()).collect();
            KnownDistribution::Weighted { options: &values, weights: &table.weights }.nominal()
        }
        DrawSource::Table(_) => None,
    }
}

/// The middle of what a variation gives a name, and what that is.
fn nominal(variation: &Variation, name: &str, values: &Variables) -> Option<(f64, &'static str)> {
    let index = variation.names().iter().position(|varied| varied == name)?;
    match variation {
        Variation::Grid { names, rows } if names.len() == 1 => {
            let values: Vec<VariedValue> = rows.iter().map(|row| row[0].clone()).collect();
            KnownDistribution::Choice(&values).nominal()
        }
        Variation::Grid { .. } => None,
        Variation::Sampled { samples, .. } => samples.distributions[index].known(values).ok()?.nominal(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::{Distribution, Samples, SamplingScheme};

    fn grid(names: &[&str], values: &[Value]) -> Variation {
        let row = |value: &Value| {
            names.iter().map(|_| VariedValue { value: value.clone(), label: value.to_string() }).collect()
        };
        Variation::Grid {
            names: names.iter().map(|name| (*name).to_string()).collect(),
            rows: values.iter().map(row).collect(),
        }
    }

    fn sampled(distribution: Distribution) -> Variation {
        let samples = Samples {
            count: 3,
            scheme: SamplingScheme::Random,
            distributions: vec![distribution],
            units: vec!["s".into()],
        };
        Variation::Sampled { names: vec!["tta".into()], samples }
    }

    fn middle(variation: &Variation) -> Option<f64> {
        nominal(variation, "tta", &Variables::new()).map(|(nominal, _)| nominal)
    }

    #[test]
    fn lists_have_their_median_whatever_their_order() {
        let numbers =
            |numbers: &[f64]| -> Vec<Value> { numbers.iter().copied().map(Value::Number).collect() };
        assert_eq!(middle(&grid(&["tta"], &numbers(&[9.0, 3.0, 5.0]))), Some(5.0));
        assert_eq!(middle(&grid(&["tta"], &numbers(&[6.0, 14.0, 10.0, 18.0]))), Some(12.0));
        assert_eq!(middle(&grid(&["tta"], &numbers(&[4.0]))), Some(4.0));
        assert_eq!(middle(&grid(&["pace"], &numbers(&[4.0]))), None);
        // Rows stay rows, words stay words.
        assert_eq!(middle(&grid(&["tta", "pace"], &numbers(&[4.0, 5.0]))), None);
        assert_eq!(middle(&grid(&["tta"], &[Value::Word("late".into())])), None);
    }

    #[test]
    fn distributions_have_their_middle() {
        assert_eq!(middle(&sampled(Distribution::Uniform { low: 2.0.into(), high: 5.0.into() })), Some(3.5));
        let normal = Distribution::Normal { mean: 7.0.into(), standard_deviation: 2.0.into() };
        assert_eq!(middle(&sampled(normal)), Some(7.0));
        let (mean, standard_deviation) = (7.0.into(), 2.0.into());
        let cut =
            Distribution::TruncatedNormal { mean, standard_deviation, low: 1.0.into(), high: 6.0.into() };
        assert_eq!(middle(&sampled(cut)), Some(6.0));
    }
}
