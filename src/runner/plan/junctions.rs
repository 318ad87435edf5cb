//! Roads that lie over the road of a scenario, in the plane.

use super::check::check_number;
use super::error::PlanError;
use super::places::{ground, line, metres, refuse_return};
use super::variables::{Variables, number};
use scenario::geometry::{GeometryError, Piece};
use scenario::limits;
use scenario::{Bend, CROSSES, DeclaredOtherRoad, Dimension, PedestrianSetup, Road, Scenario, World, show};

/// How far before and behind the junction the line of a road goes that is straight and endless, m: beyond its ends it goes straight on.
const STRAIGHT: f64 = 100.0;

/// The roads that lie over the road of a scenario, where variations have these values.
///
/// # Errors
/// A number out of its range, a path too tight for its lanes or that comes back to itself, a junction that is not on the path of either road,
/// and two straight roads of which one runs along the other.
pub(super) fn other_roads(
    scenario: &Scenario,
    main: &Road,
    variables: &Variables,
) -> Result<Vec<Road>, PlanError> {
    scenario.other_roads.iter().map(|declared| placed(scenario, main, declared, variables)).collect()
}

/// By which what a road says is known in [`Scenario::written`].
fn known_as(road: &Road) -> String {
    format!("road {}", road.name)
}

fn placed(
    scenario: &Scenario,
    main: &Road,
    declared: &DeclaredOtherRoad,
    variables: &Variables,
) -> Result<Road, PlanError> {
    let (own, name) = (&declared.origin, known_as(&declared.road));
    let value = |expression| number(expression, variables, own);
    let (road, under) = (&declared.road.name, &main.name);
    let checked = |key: &str, what: &str, found: f64, limit: limits::Limit| {
        check_number(
            scenario,
            &format!("{name}.{key}"),
            &format!("{what} of road `{road}`"),
            found,
            limit,
            own,
        )
    };
    let (at, angle) = (value(&declared.at)?, value(&declared.angle)?);
    checked("angle", "the angle", angle, limits::JUNCTION_ANGLE)?;
    match &main.bend {
        None => {
            checked("at", "the place of the junction", at, limits::CROSSING_PLACE)?;
        }
        Some(bend) => {
            checked("at", "the place of the junction", at, limits::STATION)?;
            let length = bend.line.length();
            if at > length {
                let message = format!(
                    "road `{road}` meets `{under}` {} behind the end of its path",
                    metres(at - length)
                );
                let hint = format!("the path of `{under}` is {} long: let `at` be less", metres(length));
                return Err(PlanError::new(own, message).with_hint(hint));
            }
        }
    }
    let (pieces, station) = match &declared.meets {
        None => (vec![Piece::line(2.0 * STRAIGHT)], STRAIGHT),
        Some(meets) => {
            let station = value(meets)?;
            checked("meets", "what lies before the junction", station, limits::STATION)?;
            let own_line = line(scenario, &declared.road, (&declared.pieces, &name, own), variables)?;
            if station > own_line.length() {
                let behind = metres(station - own_line.length());
                let message = format!("road `{road}` never meets `{under}`: that is {behind} behind its end");
                let length = metres(own_line.length());
                let hint = format!("its path is {length} long: let `meets` be less, or the path longer");
                return Err(PlanError::new(own, message).with_hint(hint));
            }
            (own_line.pieces().copied().collect(), station)
        }
    };
    if declared.pieces.is_empty() && main.bend.is_none() && libm::sin(angle).abs() < CROSSES {
        let shown = show(
            angle,
            scenario.written.get(&format!("{name}.angle")).and_then(|one| one.notation),
            Dimension::ANGLE,
        );
        let message = format!("road `{road}` runs along `{under}`, at {shown} to it");
        return Err(PlanError::new(own, message).with_hint(
            "let them meet at 20 deg or more, as with `angle: 90 deg`; a road that joins another has a `path`",
        ));
    }
    let refused = |error: GeometryError| PlanError::new(own, error.to_string());
    let bend = Some(Bend::through(main.met_at(at), angle, &pieces, station).map_err(refused)?);
    let ground = ground(scenario, (declared.ground.as_ref(), &name), variables)?;
    let found = Road { bend, ground, ..declared.road.clone() };
    refuse_return(&found, own)?;
    Ok(found)
}

/// Whether everybody can be in a world with several roads.
///
/// # Errors
/// Somebody who walks as they see vehicles come, where one comes on another road than theirs; and somebody who waits for a vehicle on
/// another road whose lane they do not cross.
pub(super) fn check_people(scenario: &Scenario, world: &World) -> Result<(), PlanError> {
    let Some(elsewhere) = world.vehicles.iter().find(|car| car.road > 0) else { return Ok(()) };
    for (declared, setup) in scenario.pedestrians.iter().zip(&world.pedestrians) {
        let PedestrianSetup { name, model, kind, .. } = setup;
        let fixed = model.model.known().is_some_and(|known| (known.is_fixed)(&model.settings));
        if !fixed {
            let message = format!(
                "`{}` of {} `{name}` minds vehicles of its own road alone, and `{}` drives on `{}`",
                model.model,
                kind.word(),
                elsewhere.name,
                world.road_of(elsewhere).name
            );
            return Err(PlanError::new(&declared.model.origin, message).with_hint(
                "where roads cross, people are `scripted`, or a `timeline` that compares nothing of vehicles",
            ));
        }
        if setup.follows.is_some() {
            let message = format!(
                "{} `{name}` walks along a lane that bends, and `{}` drives on `{}`",
                kind.word(),
                elsewhere.name,
                world.road_of(elsewhere).name
            );
            return Err(PlanError::new(&declared.origin, message).with_hint(
                "where roads lie over each other people go straight to their goals: let it cross, or take a road without `path`",
            ));
        }
        let waits = |car: &&scenario::VehicleSetup| declared.awaits().any(|name| name == car.name);
        let awaited = world.vehicles.iter().filter(|car| car.road > 0).find(waits);
        if let Some(car) = awaited.filter(|car| world.crosses_from(setup, car).is_none()) {
            let message = format!(
                "the way of {} `{name}` does not lead across the lane of `{}` on road `{}`",
                kind.word(),
                car.name,
                world.road_of(car).name
            );
            return Err(PlanError::new(&declared.origin, message)
                .with_hint("let it appear at a time, `appears at 2 s`, or wait for another vehicle"));
        }
    }
    Ok(())
}
