//! What a scenario draws in each of its runs: every draw and every choice of a person has a coordinate between 0 and 1, so that a run is
//! a function of a point.

use std::sync::Arc;

use super::error::PlanError;
use super::individuals::{file_name, read};
use super::setup;
use super::variables::Variables;
use scenario::population::Population as People;
use scenario::{
    Draw, DrawSource, DrawnValue, Individual, PopulationShare, Scenario, Value, World, at_share, significant,
};
use sim::random::declared;

/// What lies farther out in a distribution than all but this share may be impossible: it is left out of what is drawn.
pub const OUTERMOST: f64 = 1e-7;

/// So often at most is a run drawn again; that it takes two is less likely than once in a million runs.
const MOST_ATTEMPTS: u64 = 100;

/// Whether a coordinate of a point lies outermost.
pub fn is_outermost(point: &[f64]) -> bool {
    point.iter().any(|share| share.min(1.0 - share) < OUTERMOST)
}

/// All that a scenario draws, with the populations that it draws people from.
#[derive(Debug)]
pub struct RunDraws {
    axes: Vec<Axis>,
}

/// A coordinate of a run: what is drawn with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DrawAxis {
    /// The names of the values, or the pedestrian's with `.individual`.
    pub names: Vec<String>,
    /// How many rows or people there are, of what is not a distribution of numbers.
    pub options: Option<usize>,
}

#[derive(Debug)]
struct Axis {
    /// Names its stream among those of a run.
    stream: String,
    of: AxisOf,
}

#[derive(Debug)]
enum AxisOf {
    /// Index into [`Scenario::draws`].
    Declared(usize),
    /// Index into [`Scenario::pedestrians`].
    Person(usize, People),
}

/// What came of the draws of a run.
#[derive(Debug, Clone)]
pub struct DrawnRun {
    pub drawn: Vec<Draw>,
    /// With those who are the same in all runs, in the order of the pedestrians.
    pub individuals: Vec<Individual>,
    pub world: Arc<World>,
}

impl RunDraws {
    /// `None` of a scenario that draws nothing. What `given` has a value of is not drawn, and neither is whoever is `known`.
    ///
    /// # Errors
    /// If a population cannot be read.
    pub fn of(
        scenario: &Scenario,
        given: &Variables,
        known: &[Individual],
    ) -> Result<Option<Self>, PlanError> {
        let mut axes = Vec::new();
        for (index, draw) in scenario.draws.iter().enumerate() {
            if draw.names.iter().any(|name| !given.contains_key(name)) {
                axes.push(Axis { stream: draw.stream().to_string(), of: AxisOf::Declared(index) });
            }
        }
        for (index, person) in scenario.pedestrians.iter().enumerate() {
            let Some(individuals) = &person.individuals else { continue };
            let is_known = known.iter().any(|one| one.pedestrian == person.name);
            if individuals.selection == PopulationShare::Drawn && !is_known {
                let people = read(person, individuals)?;
                let stream = format!("{}.individual", person.name);
                axes.push(Axis { stream, of: AxisOf::Person(index, people) });
            }
        }
        Ok(Some(Self { axes }).filter(|draws| !draws.axes.is_empty()))
    }

    /// What has a coordinate, in order.
    pub fn axes(&self, scenario: &Scenario) -> Vec<DrawAxis> {
        let axis = |axis: &Axis| match &axis.of {
            AxisOf::Declared(index) => {
                let draw = &scenario.draws[*index];
                DrawAxis { names: draw.names.clone(), options: options(&draw.from) }
            }
            AxisOf::Person(_, people) => {
                DrawAxis { names: vec![axis.stream.clone()], options: Some(people.len()) }
            }
        };
        self.axes.iter().map(axis).collect()
    }

    /// The point of the run with this seed. Each coordinate comes from a stream of its own.
    fn point(&self, seed: u64, attempt: u64) -> Vec<f64> {
        self.axes.iter().map(|axis| declared(seed, &axis.stream, attempt).uniform()).collect()
    }

    /// The run with this seed, and its point. One whose draws lie [outermost](OUTERMOST) and are not possible is drawn again.
    ///
    /// # Errors
    /// If other draws are not possible.
    pub fn run(
        &self,
        scenario: &Scenario,
        variables: &Variables,
        fixed: &[Individual],
        seed: u64,
    ) -> Result<(Vec<f64>, DrawnRun), PlanError> {
        let mut attempt = 0;
        loop {
            let point = self.point(seed, attempt);
            attempt += 1;
            match self.at(scenario, variables, fixed, &point) {
                Ok(run) => return Ok((point, run)),
                Err(error) if !is_outermost(&point) || attempt == MOST_ATTEMPTS => return Err(error),
                Err(_) => {}
            }
        }
    }

    /// The values and people at a point with one coordinate an axis.
    ///
    /// # Errors
    /// If nothing can be drawn from a distribution.
    pub fn values(
        &self,
        scenario: &Scenario,
        variables: &mut Variables,
        point: &[f64],
    ) -> Result<(Vec<Draw>, Vec<Individual>), PlanError> {
        let (mut drawn, mut individuals) = (Vec::new(), Vec::new());
        for (axis, share) in self.axes.iter().zip(point) {
            let mut add = |name: &str, label: String, value: Value| {
                drawn.push(Draw { name: name.to_string(), label, value, share: *share });
            };
            match &axis.of {
                AxisOf::Declared(index) => {
                    let draw = &scenario.draws[*index];
                    match &draw.from {
                        DrawSource::Distribution { distribution, unit } => {
                            let name = &draw.names[0];
                            let known = distribution.known(variables).map_err(|error| {
                                PlanError::new(&draw.origin, format!("`{name}` cannot be drawn: {error}"))
                                    .with_hint("let its numbers fit for all values of what they depend on")
                            })?;
                            let (value, label) = match known.quantile(*share) {
                                DrawnValue::Number(number) => {
                                    (Value::Number(number), format!("{}{unit}", significant(number, 5)))
                                }
                                DrawnValue::Listed(option) => (option.value.clone(), option.label.clone()),
                            };
                            variables.insert(name.clone(), value.clone());
                            add(name, label, value);
                        }
                        DrawSource::Table(table) => {
                            let row = &table.rows[at_share(*share, &table.weights)];
                            for (name, one) in draw.names.iter().zip(row) {
                                if !variables.contains_key(name) {
                                    variables.insert(name.clone(), one.value.clone());
                                    add(name, one.label.clone(), one.value.clone());
                                }
                            }
                        }
                    }
                }
                AxisOf::Person(index, people) => {
                    let person = &scenario.pedestrians[*index];
                    let number = ((share * people.len() as f64) as usize).min(people.len() - 1) + 1;
                    let population = person.individuals.as_ref().map(|one| file_name(&one.population));
                    add(&axis.stream, number.to_string(), Value::Number(number as f64));
                    individuals.push(Individual {
                        pedestrian: person.name.clone(),
                        population: population.unwrap_or_default(),
                        number: number as u32,
                        parameters: people.individual(number).unwrap_or_default(),
                    });
                }
            }
        }
        Ok((drawn, individuals))
    }

    /// The run at a point with one coordinate an axis.
    ///
    /// # Errors
    /// If there is no such run.
    pub fn at(
        &self,
        scenario: &Scenario,
        variables: &Variables,
        fixed: &[Individual],
        point: &[f64],
    ) -> Result<DrawnRun, PlanError> {
        let mut variables = variables.clone();
        let (drawn, people) = self.values(scenario, &mut variables, point)?;
        let of = |name: &str| fixed.iter().chain(&people).find(|one| one.pedestrian == name).cloned();
        let individuals: Vec<_> = scenario.pedestrians.iter().filter_map(|person| of(&person.name)).collect();
        let world = Arc::new(setup::world(scenario, &variables, &individuals)?);
        Ok(DrawnRun { drawn, individuals, world })
    }

    /// The point in the middle of everything.
    pub fn middle(&self) -> Vec<f64> {
        vec![0.5; self.axes.len()]
    }

    /// Where an axis is declared, and by which name errors call it.
    pub fn place<'s>(&'s self, scenario: &'s Scenario, axis: usize) -> (&'s scenario::Origin, &'s str) {
        match &self.axes[axis].of {
            AxisOf::Declared(index) => {
                let draw = &scenario.draws[*index];
                (&draw.origin, &draw.names[0])
            }
            AxisOf::Person(index, _) => {
                let person = &scenario.pedestrians[*index];
                let origin = person.individuals.as_ref().map_or(&person.origin, |one| &one.origin);
                (origin, &self.axes[axis].stream)
            }
        }
    }

    /// What the rows or people of an axis weigh, in their order; `None` of a distribution of numbers.
    pub fn weights(&self, scenario: &Scenario, axis: usize) -> Option<Vec<f64>> {
        match &self.axes[axis].of {
            AxisOf::Person(_, people) => Some(vec![1.0; people.len()]),
            AxisOf::Declared(index) => match &scenario.draws[*index].from {
                DrawSource::Table(table) => Some(table.weights.clone()),
                DrawSource::Distribution { distribution, .. } => match distribution {
                    scenario::Distribution::Weighted { weights, .. } => Some(weights.clone()),
                    listed => listed.options().map(|options| vec![1.0; options.len()]),
                },
            },
        }
    }

    /// The shares in the middle of each row or person that an axis has; `None` of a distribution of numbers.
    pub fn option_shares(&self, scenario: &Scenario, axis: usize) -> Option<Vec<f64>> {
        let equal = |count: usize| (0..count).map(|one| (one as f64 + 0.5) / count as f64).collect();
        let weighted = |weights: &[f64]| {
            let all: f64 = weights.iter().sum();
            let mut before = 0.0;
            let middles = weights.iter().map(|weight| {
                before += weight;
                (weight > &0.0).then_some((before - 0.5 * weight) / all)
            });
            middles.flatten().collect()
        };
        Some(match &self.axes[axis].of {
            AxisOf::Person(_, people) => equal(people.len()),
            AxisOf::Declared(index) => match &scenario.draws[*index].from {
                DrawSource::Table(table) => weighted(&table.weights),
                DrawSource::Distribution {
                    distribution: scenario::Distribution::Choice(options), ..
                } => equal(options.len()),
                DrawSource::Distribution {
                    distribution: scenario::Distribution::Weighted { weights, .. },
                    ..
                } => weighted(weights),
                DrawSource::Distribution { .. } => return None,
            },
        })
    }

    /// Whether only one thing can come of an axis where variations have these values, with those of the draws before it in the middle.
    pub fn is_constant(&self, scenario: &Scenario, variables: &Variables, axis: usize) -> bool {
        match &self.axes[axis].of {
            AxisOf::Person(_, people) => people.len() == 1,
            AxisOf::Declared(index) => match &scenario.draws[*index].from {
                DrawSource::Table(table) => {
                    let mut drawn =
                        table.rows.iter().zip(&table.weights).filter(|(_, weight)| **weight > 0.0);
                    let first = drawn.next();
                    drawn.all(|(row, _)| first.is_some_and(|(first, _)| first == row))
                }
                DrawSource::Distribution { distribution, .. } => {
                    let mut variables = variables.clone();
                    // What cannot be drawn there is found elsewhere.
                    let _ = self.values(scenario, &mut variables, &self.middle()[..axis]);
                    distribution.known(&variables).is_ok_and(|known| known.is_constant())
                }
            },
        }
    }

    /// How many axes there are.
    pub fn len(&self) -> usize {
        self.axes.len()
    }
}

/// How many rows or options there are; `None` of a distribution of numbers.
fn options(source: &DrawSource) -> Option<usize> {
    match source {
        DrawSource::Distribution { distribution, .. } => distribution.options().map(<[_]>::len),
        DrawSource::Table(table) => Some(table.rows.len()),
    }
}
