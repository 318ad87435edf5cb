//! Who is weighed: a Latin hypercube over the ranges of the model, or a population; and who of a scenario they are.

use super::super::error::ExperimentError;
use numbers::design::Slices;
use numbers::random::{Stream, derive_seed};
use scenario::population::Population;
use scenario::{
    Calibrate, CandidateSource, DeclaredPedestrian, Individuals, PedestrianModel, PopulationShare, Scenario,
    Settings, Value,
};

/// Parameter sets to be weighed.
pub struct WeighedCandidates {
    pub model: String,
    pub variant: Option<String>,
    pub names: Vec<String>,
    pub rows: Vec<Vec<f64>>,
    /// Where they come from.
    pub words: String,
}

/// The pedestrian of a scenario that the candidates are.
pub fn weighed(scenario: &Scenario) -> Option<&DeclaredPedestrian> {
    let mut people = scenario.pedestrians.iter();
    let takes = |person: &&DeclaredPedestrian| {
        person.model.first.entry().is_some_and(|model| model.takes_individuals)
    };
    people.clone().find(|person| person.individuals.is_some()).or_else(|| people.find(takes))
}

fn failed(reason: String, hint: &str) -> ExperimentError {
    ExperimentError::Calibration { reason, hint: (!hint.is_empty()).then(|| hint.to_string()) }
}

/// The pedestrian of a scenario that the candidates are, with their model and what the scenario says of it.
fn person_of(
    scenario: &Scenario,
) -> Result<(&DeclaredPedestrian, &PedestrianModel, Settings), ExperimentError> {
    let no_model = || failed(format!("nobody of `{}` takes individuals", scenario.name), "");
    let person = weighed(scenario).ok_or_else(no_model)?;
    let model: &PedestrianModel = person.model.first.entry().ok_or_else(no_model)?;
    let mut said = Settings::default();
    for (name, value) in &person.model.settings {
        if let scenario::Expression::Constant(value) = value {
            said.set(name.clone(), value.clone());
        }
    }
    Ok((person, model, said))
}

fn variant_of(said: &Settings) -> Option<String> {
    match said.get(scenario::population::VARIANT) {
        Some(Value::Word(word)) => Some(word.clone()),
        _ => None,
    }
}

/// A population by the name of its file.
pub fn file_name(population: &str) -> String {
    let name = std::path::Path::new(population).file_name();
    name.map_or_else(|| population.to_string(), |name| name.to_string_lossy().into_owned())
}

/// What the pedestrian of a scenario who the candidates are has for a parameter of which people do not say anything.
pub fn unsaid(scenario: &Scenario, parameter: &str) -> Option<f64> {
    let (_, model, said) = person_of(scenario).ok()?;
    model.declaration.fill_in(&said).ok()?.get(parameter)?.as_number()
}

impl WeighedCandidates {
    /// A population for the pedestrian of `scenario` that the candidates are, with the variant of its model.
    pub fn population(
        people: &Individuals,
        scenario: &Scenario,
    ) -> Result<(Population, Option<String>), ExperimentError> {
        let (_, model, said) = person_of(scenario)?;
        let variant = variant_of(&said);
        let text = people.text.as_ref().map(|text| text.as_deref().map_err(String::as_str));
        let read = Population::parse(&people.population, text, &model.declaration, variant.as_deref());
        let read = read.map_err(|error| failed(error.to_string(), ""))?;
        let variant = read.variant.clone().or(variant);
        Ok((read, variant))
    }

    /// Those of a calibration of which `scenario` is one.
    pub fn of(block: &Calibrate, scenario: &Scenario, seed: u64) -> Result<Self, ExperimentError> {
        let (person, model, said) = person_of(scenario)?;
        let variant = variant_of(&said);
        let mut found = match &block.candidates {
            CandidateSource::LatinHypercube(count) => {
                let settings =
                    model.declaration.fill_in(&said).map_err(|error| failed(error.to_string(), ""))?;
                Self::hypercube(model, &settings, *count as usize, seed).ok_or_else(|| {
                    failed(
                        format!("nobody knows over which ranges people of `{}` lie", model.declaration.name),
                        "give a population: `candidates all of \"people.csv\"`",
                    )
                })?
            }
            CandidateSource::Population(people) => {
                let (read, variant) = Self::population(people, scenario)?;
                let mut rows = read.individuals;
                let all = rows.len();
                if let PopulationShare::Count(count) = people.selection {
                    if count as usize > all {
                        let reason =
                            format!("{count} candidates of `{}`, which has {all}", people.population);
                        return Err(failed(reason, &format!("take at most {all}")));
                    }
                    Stream::seeded(derive_seed(seed, "candidates")).draw(&mut rows, count as usize);
                }
                let words = format!("{} of the {all} of {}", rows.len(), file_name(&people.population));
                Self { model: read.model, variant, names: read.parameters, rows, words }
            }
        };
        found.variant = found.variant.or(variant);
        if let Some((name, _)) = person.model.settings.iter().find(|(name, _)| found.names.contains(name)) {
            let reason = format!(
                "`{}` of `{}` is said in the scenario, so that no candidate has its own",
                name, person.name
            );
            return Err(failed(reason, &format!("leave `{name}` out of the model's settings")));
        }
        let targets = block.targets();
        if found.rows.len() < targets {
            let reason = format!("{} candidates are fewer than the {targets} targets", found.rows.len());
            return Err(failed(reason, "take some hundreds for each target"));
        }
        Ok(found)
    }

    /// `count` rows in a Latin hypercube on log scales; `None` where the model says no ranges.
    fn hypercube(model: &PedestrianModel, settings: &Settings, count: usize, seed: u64) -> Option<Self> {
        let ranges = (model.individual_ranges)(settings);
        if ranges.is_empty() {
            return None;
        }
        let mut stream = Stream::seeded(derive_seed(seed, "candidates"));
        let slices: Vec<Slices> = ranges.iter().map(|_| Slices::drawn(count, &mut stream)).collect();
        let rows = (0..count)
            .map(|index| {
                let value = |((_, low, high), slices): (&(_, f64, f64), &Slices)| {
                    let share = slices.place(index, &mut stream);
                    six_digits(low * libm::pow(high / low, share))
                };
                ranges.iter().zip(&slices).map(value).collect()
            })
            .collect();
        let said: Vec<_> = ranges.iter().map(|(name, low, high)| format!("{name} {low}..{high}")).collect();
        Some(Self {
            model: model.declaration.name.to_string(),
            variant: match settings.get(scenario::population::VARIANT) {
                Some(Value::Word(word)) => Some(word.clone()),
                _ => None,
            },
            names: ranges.iter().map(|(name, ..)| name.to_string()).collect(),
            rows,
            words: format!("{count} in a Latin hypercube (log scales) over {}", said.join(", ")),
        })
    }

    /// The parameters of the candidate with this index.
    pub fn settings(&self, index: usize) -> Settings {
        let mut settings = Settings::default();
        if let Some(variant) = &self.variant {
            settings.set(scenario::population::VARIANT, Value::Word(variant.clone()));
        }
        for (name, value) in self.names.iter().zip(&self.rows[index]) {
            settings.set(name.clone(), Value::Number(*value));
        }
        settings
    }

    /// What each has for a parameter; `None` where they do not say.
    pub fn values(&self, parameter: &str) -> Option<Vec<f64>> {
        let column = self.names.iter().position(|name| name == parameter)?;
        Some(self.rows.iter().map(|row| row[column]).collect())
    }

    /// Where each stands among the others: logarithms of parameters that are positive for everybody, and the others as they are. Their order
    /// is that of the names, so that it does not matter how a file is laid out.
    pub fn coordinates(&self) -> Vec<Vec<f64>> {
        let mut columns: Vec<usize> = (0..self.names.len()).collect();
        columns.sort_by_key(|column| &self.names[*column]);
        let positive: Vec<bool> =
            (0..self.names.len()).map(|column| self.rows.iter().all(|row| row[column] > 0.0)).collect();
        let place = |row: &Vec<f64>| {
            columns
                .iter()
                .map(|column| if positive[*column] { libm::log(row[*column]) } else { row[*column] })
                .collect()
        };
        self.rows.iter().map(place).collect()
    }

    /// What noise the candidate has, wherever it stands among the others.
    pub fn noise(&self, index: usize) -> String {
        let mut named: Vec<_> = self.names.iter().zip(&self.rows[index]).collect();
        named.sort_by_key(|(name, _)| *name);
        named.iter().map(|(name, value)| format!("{name}={:016x},", value.to_bits())).collect()
    }
}

fn six_digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
