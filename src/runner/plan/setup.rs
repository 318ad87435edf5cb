//! One world of a scenario: expressions evaluated, settings resolved, places worked out.

use std::sync::Arc;

use super::check::check;
use super::error::PlanError;
use super::junctions::{check_people, other_roads};
use super::meeting::meet;
use super::places::{crossing_used, road, stops, way};
use super::streams::{Streams, no_vehicle, streams, vehicles};
use super::variables::{Variables, number};
use scenario::{
    AT_THE_CROSSING, Appearance, ControllerModel, Declaration, DeclaredAppearance, DeclaredFollowing,
    DeclaredMayGo, DeclaredPedestrian, DeclaredShape, DeclaredVehicleStart, Dimension, Expression,
    Individual, MayGo, Model, ModelSetup, Origin, ParameterKind, PedestrianSetup, REAR_AXLE, Road, Scenario,
    SettingError, Settings, Shape, SignalConduct, SignalError, Value, Vehicle, VehicleReference,
    VehicleSetup, VehicleStart, World, show,
};

/// The checked world of `scenario` where the variations have the values `variables`, with these people in it.
pub fn world(scenario: &Scenario, variables: &Variables, people: &[Individual]) -> Result<World, PlanError> {
    let world = unchecked(scenario, variables, people)?;
    check(scenario, &world)?;
    Ok(world)
}

/// As [`world`], but for its numbers and overlaps: for whom a plan has checked it, as it does those of all its trials.
pub fn unchecked(
    scenario: &Scenario,
    variables: &Variables,
    people: &[Individual],
) -> Result<World, PlanError> {
    let road = road(scenario, variables)?;
    let other_roads = other_roads(scenario, &road, variables)?;
    let Streams { driven, streams } = streams(scenario, variables)?;
    let names: Vec<&str> = driven.iter().map(|driven| driven.name.as_str()).collect();
    let pedestrians = scenario
        .pedestrians
        .iter()
        .map(|declared| pedestrian_setup((scenario, &names), &road, declared, variables, people))
        .collect::<Result<Vec<_>, _>>()?;
    let setup = |declared: &Vehicle| vehicle_setup(scenario, (&road, &pedestrians), declared, variables);
    let vehicles = vehicles(scenario, &driven, setup)?;
    let mut world = World {
        road,
        other_roads,
        vehicles,
        pedestrians,
        streams,
        step: scenario.step,
        horizon: scenario.horizon,
        finish: scenario.finish,
        end_on_collision: scenario.end_on_collision,
    };
    check_people(scenario, &world)?;
    meet(scenario, variables, &mut world)?;
    for (index, driven) in driven.iter().enumerate() {
        let declared = &scenario.vehicles[driven.declared];
        if matches!(declared.start, DeclaredVehicleStart::Automatic) {
            world.vehicles[index].start = automatic_start(index, &world).ok_or_else(|| {
                let message = format!("nothing says where vehicle `{}` starts", declared.name);
                let hint =
                    "give it `start 80 m before crossing`, or let a pedestrian appear at its time to arrival";
                PlanError::new(&declared.origin, message).with_hint(hint)
            })?;
        }
    }
    Ok(world)
}

fn vehicle_setup(
    scenario: &Scenario,
    (road, pedestrians): (&Road, &[PedestrianSetup]),
    declared: &Vehicle,
    variables: &Variables,
) -> Result<VehicleSetup, PlanError> {
    let number = |expression: &Expression| number(expression, variables, &declared.origin);
    let controller = chosen(&declared.controller, "controller", variables)?;
    let (dynamics, dynamics_settings) = match &declared.dynamics {
        Some(model) => {
            let found = chosen(model, "vehicle dynamics", variables)?;
            let settings = resolve(&found.declaration, model, variables)?;
            (found, settings)
        }
        None => {
            let default = &controller.default_dynamics;
            let found = default.entry().cloned().ok_or_else(|| {
                PlanError::new(&declared.origin, format!("there are no vehicle dynamics called `{default}`"))
            })?;
            let settings = found.declaration.resolve(&Settings::default());
            (found, settings.map_err(|error| PlanError::new(&declared.origin, error.to_string()))?)
        }
    };
    if !dynamics.takes.contains(&controller.gives) {
        let origin = declared.dynamics.as_ref().map_or(&declared.origin, |model| &model.origin);
        let message = format!(
            "dynamics `{}` do not take what controller `{}` gives ({:?})",
            dynamics.declaration.name, controller.declaration.name, controller.gives
        );
        let hint = format!("use `dynamics {}`", controller.default_dynamics);
        return Err(PlanError::new(origin, message.to_lowercase()).with_hint(hint));
    }
    let (length, width) = match &declared.size {
        Some((length, width)) => (number(length)?, number(width)?),
        None => dynamics.size,
    };
    let behind = match &declared.follows {
        DeclaredFollowing::Centre => 0.0,
        DeclaredFollowing::RearAxle => REAR_AXLE * length,
        DeclaredFollowing::Behind(behind) => number(behind)?,
    };
    let speed = number(&declared.speed)?;
    let initial_speed = declared.initial_speed.as_ref().map(number).transpose()?;
    let start = match &declared.start {
        DeclaredVehicleStart::Distance(distance) => VehicleStart::Distance(number(distance)?),
        DeclaredVehicleStart::TimeToArrival(time) => {
            VehicleStart::TimeToArrival { time: number(time)?, reference: VehicleReference::Centre, x: 0.0 }
        }
        // Known once it is known when pedestrians appear, and of a stream which of its vehicles it is.
        DeclaredVehicleStart::Automatic | DeclaredVehicleStart::Stream(_) => VehicleStart::Distance(0.0),
    };
    let sees = match &declared.sees {
        Some(model) => {
            let perception = chosen(model, "perception", variables)?;
            let settings = resolve(&perception.declaration, model, variables)?;
            Some(ModelSetup { model: perception.into(), settings })
        }
        None => None,
    };
    let said = signals_said(scenario, &declared.name, &declared.origin);
    let obeys = conduct(controller.signals, declared.obeys_signals, &controller.declaration, said)?;
    Ok(VehicleSetup {
        // On other roads there are none.
        obeys_signals: obeys && road.has_signal() && declared.road.is_none(),
        name: declared.name.clone(),
        controller: ModelSetup {
            settings: controller_settings(
                &controller.declaration,
                &declared.controller,
                variables,
                pedestrians,
            )?,
            model: controller.into(),
        },
        dynamics: ModelSetup { model: dynamics.into(), settings: dynamics_settings },
        length,
        width,
        road: match &declared.road {
            None => 0,
            Some(name) => 1 + other_road(scenario, name, &declared.origin)?,
        },
        lane: declared.lane,
        behind,
        speed,
        initial_speed,
        start,
        sees,
    })
}

/// The number of a road among those that lie over the scenario's own.
fn other_road(scenario: &Scenario, name: &str, origin: &Origin) -> Result<usize, PlanError> {
    let found = scenario.other_roads.iter().position(|other| other.road.name == name);
    found.ok_or_else(|| {
        PlanError::new(origin, format!("no road called `{name}` lies over the scenario's road"))
    })
}

/// What a controller is set to, where it says so as somebody who walks.
fn controller_settings(
    declaration: &Declaration,
    model: &Model<ControllerModel>,
    variables: &Variables,
    pedestrians: &[PedestrianSetup],
) -> Result<Settings, PlanError> {
    let mut given = evaluate(model, variables)?;
    let names = declaration.parameters.iter().filter(|one| matches!(one.kind, ParameterKind::Pedestrian));
    for parameter in names {
        let Some(Value::Word(name)) = given.get(&parameter.name).cloned() else { continue };
        let what = format!("`{}` of `{}`", parameter.name, declaration.name);
        let walker = pedestrians.iter().find(|one| one.name == name).ok_or_else(|| {
            PlanError::new(&model.origin, format!("{what} names `{name}`, and there is no such pedestrian"))
                .with_hint("name a pedestrian of the scenario")
        })?;
        if walker.model.model.name() != declaration.name {
            let message = format!("{what} names `{name}`, whose model is `{}`", walker.model.model);
            return Err(PlanError::new(&model.origin, message)
                .with_hint(format!("give `{name}` the model `{}`", declaration.name)));
        }
        for (name, value) in &walker.model.settings.0 {
            given.0.entry(name.clone()).or_insert_with(|| value.clone());
        }
    }
    declaration.fill_in(&given).map_err(|error| refused(&model.origin, &error))
}

/// Far enough out that the pedestrian who waits for the earliest arrival appears at time 0.
fn automatic_start(index: usize, world: &World) -> Option<VehicleStart> {
    let (speed, length) = (world.vehicles[index].placing_speed(), world.vehicles[index].length);
    let path = world.path_of(&world.vehicles[index]);
    let waiting = world.pedestrians.iter().filter_map(|pedestrian| match pedestrian.appears {
        Appearance::TimeToArrival { vehicle, reference, time } if vehicle == index => {
            Some((time, reference, path.line_of(pedestrian.met_by(&path))))
        }
        Appearance::Meeting { vehicle, time, place } if vehicle == index => {
            Some((time, VehicleReference::Front, path.line_of(place)))
        }
        _ => None,
    });
    let travelled = |(time, reference, x): &(f64, VehicleReference, f64)| {
        let ahead = reference.ahead_of_centre(length);
        path.at_line(*x) - time * speed - ahead
    };
    waiting
        .min_by(|left, right| travelled(left).total_cmp(&travelled(right)))
        .map(|(time, reference, x)| VehicleStart::TimeToArrival { time, reference, x })
}

fn pedestrian_setup(
    (scenario, vehicles): (&Scenario, &[&str]),
    road: &Road,
    declared: &DeclaredPedestrian,
    variables: &Variables,
    people: &[Individual],
) -> Result<PedestrianSetup, PlanError> {
    let number = |expression: &Expression| number(expression, variables, &declared.origin);
    let model = chosen(&declared.model, "pedestrian model", variables)?;
    let (start, goal, follows) = way(scenario, road, declared, variables)?;
    let shape = match &declared.shape {
        None => declared.kind.body(),
        Some(DeclaredShape::Disc { radius }) => Shape::Disc { radius: number(radius)? },
        Some(DeclaredShape::Rectangle { length, width }) => {
            Shape::Rectangle { length: number(length)?, width: number(width)? }
        }
    };
    let appears = match &declared.appears {
        DeclaredAppearance::At(time) => Appearance::At(number(time)?),
        DeclaredAppearance::TimeToArrival { vehicle, reference, time } => {
            let vehicle = vehicle_named(vehicles, vehicle, &declared.origin)?;
            Appearance::TimeToArrival { vehicle, reference: *reference, time: number(time)? }
        }
        // Known once the vehicle is.
        DeclaredAppearance::Meets { .. } => Appearance::At(0.0),
    };
    let may_go = may_go(vehicles, declared, variables)?;
    let mut given = evaluate(&declared.model, variables)?;
    if let Some(person) = people.iter().find(|person| person.pedestrian == declared.name) {
        // What the scenario says wins over the individual.
        for (name, value) in &person.parameters.0 {
            given.0.entry(name.clone()).or_insert_with(|| value.clone());
        }
    }
    let settings =
        model.declaration.fill_in(&given).map_err(|error| refused(&declared.model.origin, &error))?;
    let (signals, declaration) = (model.signals, model.declaration.clone());
    let mut setup = PedestrianSetup {
        obeys_signals: false,
        name: declared.name.clone(),
        kind: declared.kind,
        model: ModelSetup { model: model.into(), settings },
        shape,
        side: declared.side,
        start,
        goal,
        follows,
        stops: stops(road, declared, (start, goal))?,
        crossing: crossing_used(road, declared)?.0,
        appears,
        may_go,
        reference: number(&declared.reference)?,
    };
    refuse_useless_look(scenario, declared, &setup)?;
    if setup.follows.is_some() && setup.keeps_clear().is_some() {
        let (kind, name, model) = (declared.kind.word(), &declared.name, &setup.model.model);
        let message = format!(
            "{kind} `{name}` walks along the lane of a road that bends, and `{model}` decides for itself where it walks"
        );
        return Err(PlanError::new(&declared.model.origin, message).with_hint(
            "take `scripted` or `timeline` without `keeps_clear`, which go where they are told to, or a road without `path`",
        ));
    }
    let (said, origin) = (declared.obeys_signals, signals_said(scenario, &declared.name, &declared.origin));
    let obeys = conduct(signals, said, &declaration, origin)?;
    if !obeys || !road.has_signal() {
        return Ok(setup);
    }
    let met = setup.meets_signal(road);
    if let (Some(true), false) = (said, met) {
        let message = format!(
            "{} `{}` does not step onto the road at the crossing, so that there is no signal to obey",
            declared.kind.word(),
            declared.name
        );
        let hint = format!(
            "leave `obeys signals` out, or let the way begin at most {} from the middle of the crossing",
            show(
                road.numbered_crossing(setup.crossing).1.width / 2.0 + AT_THE_CROSSING,
                None,
                Dimension::LENGTH
            )
        );
        return Err(PlanError::new(origin, message).with_hint(hint));
    }
    setup.obeys_signals = met;
    Ok(setup)
}

/// The index of a vehicle among those of the world, which have these names.
fn vehicle_named(vehicles: &[&str], name: &str, origin: &Origin) -> Result<usize, PlanError> {
    vehicles.iter().position(|known| *known == name).ok_or_else(|| no_vehicle(name, origin))
}

/// When a pedestrian may go.
fn may_go(
    vehicles: &[&str],
    declared: &DeclaredPedestrian,
    variables: &Variables,
) -> Result<MayGo, PlanError> {
    let number = |expression: &Expression| number(expression, variables, &declared.origin);
    Ok(match &declared.may_go {
        DeclaredMayGo::AtOnce => MayGo::AtOnce,
        DeclaredMayGo::After(time) => match number(time)? {
            0.0 => MayGo::AtOnce,
            time => MayGo::After(time),
        },
        DeclaredMayGo::TimeToArrival { vehicle, reference, time, or_after } => MayGo::TimeToArrival {
            vehicle: vehicle_named(vehicles, vehicle, &declared.origin)?,
            reference: *reference,
            time: number(time)?,
            or_after: number(or_after)?,
        },
    })
}

/// A look changes nothing but the start of a pedestrian that walks the same whatever it sees.
fn refuse_useless_look(
    scenario: &Scenario,
    declared: &DeclaredPedestrian,
    setup: &PedestrianSetup,
) -> Result<(), PlanError> {
    let is_fixed = setup.model.model.known().is_some_and(|model| (model.is_fixed)(&setup.model.settings));
    if !is_fixed || !matches!(setup.may_go, MayGo::After(_)) {
        return Ok(());
    }
    let (kind, name, model) = (declared.kind.word(), &declared.name, &setup.model.model);
    let said = scenario.written.get(&format!("{name}.looks"));
    let origin = said.map_or(&declared.origin, |said| &said.origin);
    let message = format!("{kind} `{name}` looks, and `{model}` walks the same whatever it sees");
    Err(PlanError::new(origin, message).with_hint(
        "take a model that reacts, such as `commotions`; or say when it sets off, as `scripted` does with `delay`",
    ))
}

/// Where a scenario says what somebody does about signals.
fn signals_said<'a>(scenario: &'a Scenario, name: &str, own: &'a Origin) -> &'a Origin {
    scenario.written.get(&format!("{name}.signals")).map_or(own, |said| &said.origin)
}

/// Whether a model stops for red where a scenario says so much of it.
fn conduct(
    signals: SignalConduct,
    said: Option<bool>,
    declaration: &Declaration,
    origin: &Origin,
) -> Result<bool, PlanError> {
    let refused = |error: SignalError| PlanError::new(origin, error.message).with_hint(error.hint);
    signals.obeys(said, &declaration.name).map_err(refused)
}

fn resolve<T>(
    declaration: &Declaration,
    model: &Model<T>,
    variables: &Variables,
) -> Result<Settings, PlanError> {
    declaration.fill_in(&evaluate(model, variables)?).map_err(|error| refused(&model.origin, &error))
}

/// A name that a declaration does not know; values are checked in the resolved world.
fn refused(origin: &Origin, error: &SettingError) -> PlanError {
    PlanError::new(origin, error.to_string())
}

fn evaluate<T>(model: &Model<T>, variables: &Variables) -> Result<Settings, PlanError> {
    let mut settings = Settings::default();
    for (name, expression) in &model.settings {
        let value = expression.evaluate(variables).map_err(|error| {
            PlanError::new(&model.origin, format!("`{name}` of `{}`: {error}", model.first))
        })?;
        settings.set(name.clone(), value);
    }
    Ok(settings)
}

/// What a model is where variations have these values.
fn chosen<T>(model: &Model<T>, kind: &str, variables: &Variables) -> Result<Arc<T>, PlanError> {
    let chosen = model.chosen(variables).map_err(|error| PlanError::new(&model.origin, error.to_string()))?;
    let unknown = || PlanError::new(&model.origin, format!("there is no {kind} called `{chosen}`"));
    chosen.entry().cloned().ok_or_else(unknown)
}
