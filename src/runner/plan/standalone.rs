//! One case as a scenario of its own: everything put in that it draws or varies.

use super::error::PlanError;
use super::variables::{Variables, variables};
use scenario::{
    Assignment, DeclaredPedestrian, DeclaredVehicleStart, Expression, Individual, Model, Origin, Scenario,
    Settings, Vehicle,
};

/// `scenario` without variations, individuals and repetitions: its only run has the case's values, its people's
/// parameters as settings, and its seed.
///
/// # Errors
/// If an expression cannot be evaluated with these values.
pub fn standalone(
    scenario: &Scenario,
    variation: &[Assignment],
    individuals: &[Individual],
    seed: u64,
) -> Result<Scenario, PlanError> {
    let variables = variables(variation);
    let mut own = scenario.clone();
    (own.variations, own.draws) = (Vec::new(), Vec::new());
    (own.repeat, own.runs, own.seed) = (1, None, Some(seed));
    if let Some(bend) = &mut own.bend {
        bend.expressions_mut().into_iter().try_for_each(|(value, origin)| fix(value, &variables, origin))?;
    }
    if let Some(ground) = &mut own.ground {
        ground
            .expressions_mut()
            .into_iter()
            .try_for_each(|(value, origin)| fix(value, &variables, origin))?;
    }
    for place in &mut own.other_crossings {
        fix(&mut place.at, &variables, &place.origin)?;
    }
    for other in &mut own.other_roads {
        other.expressions_mut().into_iter().try_for_each(|(value, origin)| fix(value, &variables, origin))?;
    }
    if let Some(signal) = &mut own.signal {
        signal
            .expressions_mut()
            .into_iter()
            .try_for_each(|(value, origin)| fix(value, &variables, origin))?;
    }
    for car in &mut own.vehicles {
        if let DeclaredVehicleStart::Stream(stream) = &mut car.start {
            let listed = stream.with_drawn_gaps(&variables, scenario.horizon);
            *stream = listed.map_err(|error| PlanError::new(&car.origin, error.to_string()))?;
        }
        fix_vehicle(car, &variables)?;
    }
    for person in &mut own.pedestrians {
        fix_pedestrian(person, &variables)?;
        let individual = individuals.iter().find(|one| one.pedestrian == person.name);
        if let Some(individual) = individual {
            add_individual(person, individual);
        }
        person.individuals = None;
    }
    Ok(own)
}

fn fix_vehicle(car: &mut Vehicle, variables: &Variables) -> Result<(), PlanError> {
    choose(&mut car.controller, variables)?;
    car.dynamics.iter_mut().try_for_each(|model| choose(model, variables))?;
    car.sees.iter_mut().try_for_each(|model| choose(model, variables))?;
    car.expressions_mut().into_iter().try_for_each(|(value, origin)| fix(value, variables, origin))
}

fn fix_pedestrian(person: &mut DeclaredPedestrian, variables: &Variables) -> Result<(), PlanError> {
    choose(&mut person.model, variables)?;
    person.expressions_mut().into_iter().try_for_each(|(value, origin)| fix(value, variables, origin))
}

fn choose<T>(model: &mut Model<T>, variables: &Variables) -> Result<(), PlanError> {
    let chosen = model.chosen(variables).map_err(|error| PlanError::new(&model.origin, error.to_string()))?;
    (model.first, model.varied_by) = (chosen, None);
    (model.varied, model.others) = (Vec::new(), Vec::new());
    Ok(())
}

fn fix(expression: &mut Expression, variables: &Variables, origin: &Origin) -> Result<(), PlanError> {
    let value = expression.evaluate(variables).map_err(|error| PlanError::new(origin, error.to_string()))?;
    *expression = Expression::Constant(value);
    Ok(())
}

/// What the scenario says wins over the individual, and what the model would have anyway needs not be said.
fn add_individual(person: &mut DeclaredPedestrian, individual: &Individual) {
    let mut said = Settings::default();
    for (name, value) in &person.model.settings {
        if let Expression::Constant(value) = value {
            said.set(name.clone(), value.clone());
        }
    }
    let declaration = person.model.first.declaration();
    let usual = declaration.and_then(|declaration| declaration.resolve(&said).ok()).unwrap_or_default();
    for (name, value) in &individual.parameters.0 {
        if !said.0.contains_key(name) && usual.0.get(name) != Some(value) {
            person.model.settings.push((name.clone(), Expression::Constant(value.clone())));
        }
    }
}
