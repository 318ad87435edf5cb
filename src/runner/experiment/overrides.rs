//! Points of a search space put into a scenario.

use super::error::ExperimentError;
use scenario::{
    Assignment, Case, Expression, ModelSetup, Origin, ParameterKind, Part, RangeValues, Registered, Scenario,
    SearchRange, Target, Value,
};

/// The optimiser's dimension for a declared range.
pub fn dimension(range: &SearchRange) -> optimise::SearchDimension {
    let values = match &range.values {
        RangeValues::Real { low, high } => optimise::Range::Real { low: *low, high: *high },
        RangeValues::Logarithmic { low, high } => optimise::Range::Log { low: *low, high: *high },
        RangeValues::Whole { low, high } => optimise::Range::Integer { low: *low, high: *high },
        RangeValues::Words(words) => optimise::Range::Categorical { choices: words.clone() },
    };
    optimise::SearchDimension { name: range.target.to_string(), range: values }
}

/// The space of all declared ranges, in their order.
pub fn space(ranges: &[SearchRange]) -> Result<optimise::Space, optimise::Error> {
    optimise::Space::new(ranges.iter().map(dimension).collect())
}

/// The same ranges wherever they are written.
pub fn without_origins(ranges: &[SearchRange]) -> Vec<SearchRange> {
    ranges.iter().map(|range| SearchRange { origin: Origin::default(), ..range.clone() }).collect()
}

/// The coordinate of a range that stands for a value; `None` of a value of another kind.
pub fn coordinate(range: &SearchRange, value: &Value) -> Option<optimise::Coordinate> {
    match (&range.values, value) {
        (RangeValues::Real { .. } | RangeValues::Logarithmic { .. }, Value::Number(number)) => {
            Some(optimise::Coordinate::Real(*number))
        }
        (RangeValues::Whole { .. }, Value::Number(number)) if number.fract() == 0.0 => {
            Some(optimise::Coordinate::Integer(*number as i64))
        }
        (RangeValues::Words(_), Value::Word(word)) => Some(optimise::Coordinate::Category(word.clone())),
        _ => None,
    }
}

/// A value of the optimiser as a value of a scenario.
pub fn value(value: &optimise::Coordinate) -> Value {
    match value {
        optimise::Coordinate::Integer(number) => Value::Number(*number as f64),
        optimise::Coordinate::Real(number) => Value::Number(*number),
        optimise::Coordinate::Category(word) => Value::Word(word.clone()),
    }
}

/// The variations that a point fixes, with labels that name the exact values.
pub fn assignments(ranges: &[SearchRange], point: &[optimise::Coordinate]) -> Vec<Assignment> {
    let fixed = ranges.iter().zip(point).filter_map(|(range, chosen)| match &range.target {
        Target::Variation(name) => Some(Assignment {
            name: name.clone(),
            label: format!("{chosen}{}", range.unit),
            value: value(chosen),
        }),
        Target::Setting { .. } => None,
    });
    fixed.collect()
}

/// All that a point fixes: `av.controller.gap = 5m, late = 0.3s`.
pub fn in_words(ranges: &[SearchRange], point: &[optimise::Coordinate]) -> String {
    let each = ranges.iter().zip(point);
    let said = each.map(|(range, chosen)| format!("{} = {chosen}{}", range.target, range.unit));
    said.collect::<Vec<_>>().join(", ")
}

/// The settings that a point fixes.
pub fn settings(ranges: &[SearchRange], point: &[optimise::Coordinate]) -> Vec<(Target, Value)> {
    let fixed = ranges.iter().zip(point).filter(|(range, _)| matches!(range.target, Target::Setting { .. }));
    fixed.map(|(range, chosen)| (range.target.clone(), value(chosen))).collect()
}

/// Writes settings into a scenario, over its own.
pub fn apply(scenario: &mut Scenario, settings: &[(Target, Value)]) -> Result<(), ExperimentError> {
    for (target, value) in settings {
        let Target::Setting { road_user, part, parameter } = target else { continue };
        let missing = ExperimentError::UnknownTarget(target.to_string(), scenario.name.clone());
        let all = settings_mut(scenario, road_user, *part);
        if all.is_empty() {
            return Err(missing);
        }
        for said in all {
            said.retain(|(name, _)| name != parameter);
            said.push((parameter.clone(), Expression::Constant(value.clone())));
        }
    }
    Ok(())
}

/// `scenario` without the variations whose values the ranges replace.
pub fn without_variations(scenario: &Scenario, ranges: &[SearchRange]) -> Scenario {
    let searched = |name: &String| {
        ranges.iter().any(|range| matches!(&range.target, Target::Variation(target) if target == name))
    };
    let mut changed = scenario.clone();
    changed.variations.retain(|variation| !variation.names().iter().any(searched));
    changed
}

/// What a scenario says of the parameters of a road user's part; of every member, where that is a group.
fn settings_mut<'a>(
    scenario: &'a mut Scenario,
    road_user: &str,
    part: Part,
) -> Vec<&'a mut Vec<(String, Expression)>> {
    if part == Part::Model {
        let people = scenario.pedestrians.iter_mut().filter(|one| one.is(road_user));
        return people.map(|person| &mut person.model.settings).collect();
    }
    let vehicle = scenario.vehicles.iter_mut().find(|one| one.name == road_user);
    let said = vehicle.and_then(|vehicle| match part {
        Part::Dynamics => vehicle.dynamics.as_mut().map(|model| &mut model.settings),
        Part::Sees => vehicle.sees.as_mut().map(|model| &mut model.settings),
        Part::Controller | Part::Model => Some(&mut vehicle.controller.settings),
    });
    said.into_iter().collect()
}

/// What a case of a scenario sets a parameter to, with its unit: of a group, every member.
pub fn resolved(target: &Target, scenario: &Scenario, case: &Case) -> Vec<Option<(Value, String)>> {
    let Target::Setting { road_user, part, parameter } = target else { return vec![None] };
    if *part == Part::Model {
        let meant = scenario.pedestrians.iter().filter(|one| one.is(road_user));
        let named = |name: &str| case.world.pedestrians.iter().find(|one| one.name == name);
        return meant.map(|one| value_in(&named(&one.name)?.model, parameter)).collect();
    }
    let car = case.world.vehicles.iter().find(|one| one.name == *road_user);
    vec![car.and_then(|car| match part {
        Part::Controller => value_in(&car.controller, parameter),
        Part::Dynamics => value_in(&car.dynamics, parameter),
        _ => value_in(car.sees.as_ref()?, parameter),
    })]
}

/// A parameter of a model, with its unit.
fn value_in<T: Registered>(setup: &ModelSetup<T>, parameter: &str) -> Option<(Value, String)> {
    let declaration = setup.model.declaration()?;
    let unit = declaration.parameter(parameter).map(|known| &known.kind);
    let unit = match unit {
        Some(ParameterKind::Number { dimension, .. }) => dimension.si_unit(),
        _ => String::new(),
    };
    Some((setup.settings.get(parameter)?.clone(), unit))
}
