//! When a pedestrian who is to meet a vehicle has to appear, so that a vehicle that keeps its speed hits it where the scenario says.
//!
//! From its start the pedestrian walks until its reference point is at that share of the vehicle's width; for how long, its own model says,
//! alone in the world. The vehicle's front is then at the pedestrian's near flank. Impact and reference points are those of Euro NCAP's
//! protocols for vulnerable road users.

use scenario::{
    Appearance, DeclaredAppearance, DeclaredPedestrian, DeclaredVehicleStart, Dimension, Origin, Path,
    PedestrianContext, PedestrianSetup, Scenario, Shape, VehicleSetup, VehicleStart, World, limits, show,
};
use sim::{Longitudinal, VehicleState, hit_along, hit_at, walking_time};

use super::check::{check_number, check_numbers, check_share};
use super::error::PlanError;
use super::places::course_beside;
use super::streams::no_vehicle;
use super::variables::{Variables, number};

/// Leaves room for rounding in places, m.
const ROUNDING: f64 = 1e-9;

/// The last of a way along a lane, by which it is known how fast somebody is at its end, m.
const LAST_WAY: f64 = 0.1;

/// Steps to the place beside a lane from which somebody is hit at the share that is asked for, at most; …
const STEPS: usize = 60;

/// … they end where the share is right to this.
const ROUNDING_OF_SHARES: f64 = 1e-9;

/// Lets everybody in the world who is to meet a vehicle appear in time for it.
///
/// # Errors
/// Where the model minds others, where the vehicle stands, and where they would have to appear before the run begins.
pub(super) fn meet(scenario: &Scenario, variables: &Variables, world: &mut World) -> Result<(), PlanError> {
    for (index, declared) in scenario.pedestrians.iter().enumerate() {
        let DeclaredAppearance::Meets { vehicle, share, after } = &declared.appears else { continue };
        // What is no number, or too large, is told before anybody walks with it.
        check_numbers(scenario, world)?;
        let said = said(scenario, declared);
        let car = world.vehicles.iter().position(|car| car.name == *vehicle);
        let car = car.ok_or_else(|| no_vehicle(vehicle, &said))?;
        let share = number(share, variables, &said)?;
        check_share(scenario, declared, share, &said)?;
        let Some(after) = after else {
            world.pedestrians[index].appears = meeting(scenario, world, index, car, share, &said)?;
            continue;
        };
        let after = number(after, variables, &said)?;
        check_way_walked(scenario, declared, after, &said)?;
        if world.pedestrians[index].follows.is_some() {
            let end = put_beside(scenario, world, (index, car), (share, after), &said)?;
            world.pedestrians[index].appears =
                meeting_along(scenario, world, (index, car), (after, Some(end)), &said)?;
            continue;
        }
        let (path, setup) = (world.path_of(&world.vehicles[car]), &mut world.pedestrians[index]);
        // Who walks along the lane is at that place across it all the time.
        let beyond = world.vehicles[car].width * (share - 0.5);
        let y = path.point(0.0).y + setup.side.walking_sign() * beyond;
        (setup.start.y, setup.goal.y) = (y, y);
        world.pedestrians[index].appears =
            meeting_along(scenario, world, (index, car), (after, None), &said)?;
    }
    Ok(())
}

/// Where the scenario says that they meet.
fn said(scenario: &Scenario, declared: &DeclaredPedestrian) -> Origin {
    let written = scenario.written.get(&format!("{}.meets", declared.name));
    written.map_or_else(|| declared.origin.clone(), |value| value.origin.clone())
}

/// Whether the way after which they are met is one.
fn check_way_walked(
    scenario: &Scenario,
    declared: &DeclaredPedestrian,
    after: f64,
    said: &Origin,
) -> Result<(), PlanError> {
    let (name, kind) = (&declared.name, declared.kind.word());
    let what = format!("the way after which {kind} `{name}` is met");
    check_number(scenario, &format!("{name}.after"), &what, after, limits::FURTHER, said)
}

/// Puts somebody who follows a bend so far beside the lane's centre that the vehicle's front hits them at a share of its width after so much (m) of
/// their way: the place (m) of the front then.
fn put_beside(
    scenario: &Scenario,
    world: &mut World,
    (person, vehicle): (usize, usize),
    (share, after): (f64, f64),
    said: &Origin,
) -> Result<f64, PlanError> {
    let (car, declared) = (&world.vehicles[vehicle], &scenario.pedestrians[person]);
    let setup = &world.pedestrians[person];
    let (path, walks) = (world.path_of(car), setup.follows.as_ref());
    let (Some(lane), Some(walks), Some(bend)) =
        (path.course(), walks.and_then(|walks| walks.course()), world.road.bend.clone())
    else {
        return Err(elsewhere(setup, &car.name, said));
    };
    if lane.line() != &*bend.line {
        return Err(elsewhere(setup, &car.name, said));
    }
    let (from, to) = (walks.project(setup.start.into()).place, walks.project(setup.goal.into()).place);
    let (along, further) = (world.road.along(setup.start.into()), to - from);
    let direction = walks.direction();
    let sign = setup.side.walking_sign();
    let state = on_its_path(car, &path);
    let mut setup = setup.clone();
    let mut y = lane.offset() + sign * car.width * (share - 0.5);
    for _ in 0..STEPS {
        let placed = course_beside(&bend, (declared, said), (y, direction), (along, further))?;
        (setup.start, setup.goal, setup.follows) = placed;
        let Some((place, found)) = hit_along(&state, &setup, after) else { break };
        let aside = sign * (share - found) * car.width;
        if aside.abs() <= ROUNDING_OF_SHARES * car.width {
            world.pedestrians[person] = setup;
            return Ok(place + state.length / 2.0);
        }
        y += aside;
    }
    let message = format!(
        "nowhere beside its lane does the front of `{}` hit {} `{}` at {} % of its width",
        car.name,
        setup.kind.word(),
        setup.name,
        show(share * 100.0, None, Dimension::NUMBER)
    );
    Err(PlanError::new(said, message).with_hint(
        "let it be met where the road bends less, or say `start` and `appears` instead of `meets`",
    ))
}

/// Of somebody who walks along the lane in which the vehicle comes from behind or towards them, its front at a place (m) then on a bend.
fn meeting_along(
    scenario: &Scenario,
    world: &World,
    (person, vehicle): (usize, usize),
    (after, end): (f64, Option<f64>),
    said: &Origin,
) -> Result<Appearance, PlanError> {
    let (setup, car) = (&world.pedestrians[person], &world.vehicles[vehicle]);
    let (name, kind, other) = (&setup.name, setup.kind.word(), &car.name);
    if car.speed <= 0.0 {
        return Err(stands(other, said));
    }
    // How far they walk, and where they are after so much of it: the place abreast of that in the vehicle's lane, m.
    let path = world.path_of(car);
    let (further, abreast): (f64, Box<dyn Fn(f64) -> f64>) = match &setup.follows {
        None => {
            let way = setup.goal.x - setup.start.x;
            let ahead = path.heading(0.0).x * way.signum();
            let from = path.along(setup.start.into());
            (way.abs(), Box::new(move |walked| from + ahead * walked))
        }
        Some(course) => {
            let (from, to) = (course.along(setup.start.into()), course.along(setup.goal.into()));
            (to - from, Box::new(move |walked| path.along(course.point(from + walked))))
        }
    };
    if after > further {
        let message =
            format!("{kind} `{name}` is to meet `{other}` {} beyond its goal", metres(after - further));
        let hint = format!("let its goal be at least {} further", metres(after));
        return Err(PlanError::new(said, message).with_hint(hint));
    }
    let Some(time) = alone(world, setup, after, &scenario.pedestrians[person].model.origin)? else {
        return Err(never_walks(setup, other, after, said));
    };
    let (start, met) = (abreast(0.0), abreast(after));
    // Where the front comes to the near end of the body.
    let end = end.unwrap_or(met - setup.shape.extents().0 / 2.0);
    // A vehicle catches up with whom it is behind at first and faster than at last.
    let short = after.min(LAST_WAY) / 2.0;
    let earlier = alone(world, setup, after - short, &scenario.pedestrians[person].model.origin)?;
    let last = earlier.map_or(0.0, |earlier| (met - abreast(after - short)) / (time - earlier));
    let fastest = last.max((met - start) / time);
    if car.speed <= fastest * (1.0 + ROUNDING) {
        let message = format!("vehicle `{other}` is too slow to catch up with {kind} `{name}`");
        let shown = show(fastest, None, Dimension::SPEED);
        let hint = format!("let it be faster than {shown}, as fast as `{name}` is");
        return Err(PlanError::new(said, message).with_hint(hint));
    }
    in_time(scenario, world, (person, vehicle), (time, end), said)
}

/// A vehicle at the beginning of places, at the speed that it keeps.
fn on_its_path(car: &VehicleSetup, path: &Path) -> VehicleState {
    let motion = Longitudinal { travelled: 0.0, speed: car.speed_at_start(), acceleration: 0.0 };
    VehicleState::new(path.clone(), motion, (car.length, car.width))
}

fn elsewhere(setup: &PedestrianSetup, other: &str, said: &Origin) -> PlanError {
    let (name, kind) = (&setup.name, setup.kind.word());
    PlanError::new(said, format!("{kind} `{name}` walks along another road than `{other}` drives on"))
        .with_hint("let it meet a vehicle of the road that it walks along, or say `start` and `appears` instead of `meets`")
}

fn metres(length: f64) -> String {
    show(length, None, Dimension::LENGTH)
}

fn stands(other: &str, said: &Origin) -> PlanError {
    let message = format!("vehicle `{other}` stands still, so that nobody can be in time to meet it");
    PlanError::new(said, message).with_hint("give it a speed")
}

fn never_walks(setup: &PedestrianSetup, other: &str, way: f64, said: &Origin) -> PlanError {
    let (name, kind) = (&setup.name, setup.kind.word());
    let message = format!("{kind} `{name}` never walks the {} to where it is to meet `{other}`", metres(way));
    PlanError::new(said, message).with_hint("its speed, its goal and where it stops decide how far it comes")
}

/// The appearance of somebody who takes so long (s) to where the vehicle's front is at a place (m), if that is within the run.
fn in_time(
    scenario: &Scenario,
    world: &World,
    (person, vehicle): (usize, usize),
    (time, place): (f64, f64),
    said: &Origin,
) -> Result<Appearance, PlanError> {
    let (setup, car) = (&world.pedestrians[person], &world.vehicles[vehicle]);
    let (name, kind) = (&setup.name, setup.kind.word());
    let (other, path) = (&car.name, world.path_of(car));
    // It would be there as early as this at the larger of its speeds.
    let latest = place - time * car.placing_speed() - car.length / 2.0;
    let starts = match car.start {
        // As far out as they need it.
        _ if is_automatic(scenario, other) => latest,
        VehicleStart::Distance(distance) => -distance,
        VehicleStart::TimeToArrival { time, reference, x } => {
            path.at_line(x) - time * car.placing_speed() - reference.ahead_of_centre(car.length)
        }
    };
    if starts > latest + ROUNDING {
        let message = format!("{kind} `{name}` would have to appear before the run begins to meet `{other}`");
        let hint = format!("`{other}` has to start {} before the crossing, or nowhere said", metres(-latest));
        return Err(PlanError::new(said, message).with_hint(hint));
    }
    Ok(Appearance::Meeting { vehicle, time, place })
}

/// Whether the vehicle starts where people need it.
fn is_automatic(scenario: &Scenario, vehicle: &str) -> bool {
    scenario.vehicle(vehicle).is_some_and(|car| car.start == DeclaredVehicleStart::Automatic)
}

fn meeting(
    scenario: &Scenario,
    world: &World,
    person: usize,
    vehicle: usize,
    share: f64,
    said: &Origin,
) -> Result<Appearance, PlanError> {
    let (setup, car) = (&world.pedestrians[person], &world.vehicles[vehicle]);
    let (name, kind, other) = (&setup.name, setup.kind.word(), &car.name);
    let refused = |message: String, hint: String| Err(PlanError::new(said, message).with_hint(hint));
    if car.speed <= 0.0 {
        return Err(stands(other, said));
    }
    let path = world.path_of(car);
    let straight = path.course().is_none() && setup.start.x == setup.goal.x;
    // How far the pedestrian walks, and the place of the vehicle's front then: where it comes to the near flank.
    let (way, flank) = if straight {
        let way = car.width * (share - 0.5) - path.beyond(setup.start.into(), setup.side) - setup.reference;
        (way, path.along(setup.start.into()) - half_across(setup.shape))
    } else {
        let Some((way, centre)) = hit_at(&on_its_path(car, &path), setup, share) else {
            let message = format!("the way of {kind} `{name}` does not lead across the lane of `{other}`");
            return refused(
                message,
                "let it start on one side of the lane and walk to the other".to_string(),
            );
        };
        (way, centre + car.length / 2.0)
    };
    if way < 0.0 {
        let message = format!("{kind} `{name}` starts {} beyond where it is to meet `{other}`", metres(-way));
        return refused(message, "let it start farther away".to_string());
    }
    let Some(time) = alone(world, setup, way, &scenario.pedestrians[person].model.origin)? else {
        return Err(never_walks(setup, other, way, said));
    };
    in_time(scenario, world, (person, vehicle), (time, flank), said)
}

/// How long the pedestrian takes for so much of its way (m) with nobody else in the world, s; `None` if it does not walk that far.
fn alone(
    world: &World,
    setup: &PedestrianSetup,
    way: f64,
    origin: &Origin,
) -> Result<Option<f64>, PlanError> {
    let Some(model) = setup.model.model.known() else {
        return Err(PlanError::new(
            origin,
            format!("there is no pedestrian model called `{}`", setup.model.model),
        ));
    };
    if !(model.is_fixed)(&setup.model.settings) {
        let name = &model.declaration.name;
        let message = format!(
            "`{name}` may walk otherwise when it sees a vehicle, so nobody knows beforehand when it is where"
        );
        return Err(PlanError::new(origin, message)
            .with_hint("`meets` is for `scripted`, or a `timeline` that compares nothing of vehicles; say `appears` otherwise"));
    }
    if setup.obeys_signals {
        let message = format!(
            "`{}` waits for green at a signal, so nobody knows beforehand when it is where",
            setup.name
        );
        let hint = "let it say `ignores signals`, or `appears` instead of `meets`";
        return Err(PlanError::new(origin, message).with_hint(hint));
    }
    let world = World { vehicles: Vec::new(), pedestrians: vec![setup.clone()], ..world.clone() };
    let context =
        PedestrianContext { settings: &setup.model.settings, setup, world: &world, rank: 0, seed: 0 };
    let mut mind = (model.build)(&context)
        .map_err(|error| PlanError::new(origin, format!("`{}`: {error}", setup.name)))?;
    Ok(walking_time(&mut *mind, setup, &world, way, limits::VEHICLE_ARRIVAL.range.1))
}

/// How far a footprint that walks across the road reaches along it, m.
fn half_across(shape: Shape) -> f64 {
    match shape {
        Shape::Disc { radius } => radius,
        Shape::Rectangle { width, .. } => width / 2.0,
    }
}
