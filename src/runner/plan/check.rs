//! Every resolved world is checked here, whole and once, however its values came in: written, listed, drawn, given by a
//! template or a person, set on the command line, or chosen by a search or a tune.

use super::error::PlanError;
use super::overlap::refuse_overlaps;
use scenario::limits::{self, Limit};
use scenario::{
    Appearance, Body, CrossingKind, DeclaredPedestrian, DeclaredVehicleStart, Dimension, MayGo, ModelSetup,
    Origin, ParameterKind, PedestrianSetup, Registered, Road, Scenario, Shape, TrafficSignal, Value,
    VehicleSetup, VehicleStart, World, out_of_range, show,
};

/// What to do about a pedestrian that may go only when the run is over.
pub const LOOKS_TOO_LONG: &str = "let it look less long or appear earlier, or raise `horizon`";

/// Whether the world, which `scenario` was resolved to, can be run: every number finite and within its limits, nobody
/// inside another body.
///
/// # Errors
/// The first number that is not, at the place that says it and in the unit it is written in; else the first two bodies that
/// are inside each other.
pub fn check(scenario: &Scenario, world: &World) -> Result<(), PlanError> {
    check_numbers(scenario, world)?;
    refuse_overlaps(scenario, world)
}

/// Whether every number of the world is finite and within its limits.
///
/// # Errors
/// The first that is not.
pub fn check_numbers(scenario: &Scenario, world: &World) -> Result<(), PlanError> {
    let checker = Checker::of(scenario);
    let own = &scenario.origin;
    checker.within(&["step"], || "the simulation step".into(), world.step, limits::STEP, own)?;
    checker.within(&["horizon"], || "the horizon".into(), world.horizon, limits::HORIZON, own)?;
    checker.within(&["finish"], || "the finish line".into(), world.finish, limits::FINISH, own)?;
    checker.road(world)?;
    for vehicle in &world.vehicles {
        checker.vehicle(vehicle, world)?;
    }
    for (index, person) in world.pedestrians.iter().enumerate() {
        checker.pedestrian(index, person, world)?;
    }
    Ok(())
}

/// Whether the share of a vehicle's width at which somebody meets it is one.
///
/// # Errors
/// If it is not, where the scenario says it.
pub fn check_share(
    scenario: &Scenario,
    declared: &DeclaredPedestrian,
    share: f64,
    own: &Origin,
) -> Result<(), PlanError> {
    let (name, kind) = (&declared.name, declared.kind.word());
    let what = format!("the share of the vehicle's width at which {kind} `{name}` meets it");
    Checker::of(scenario).within(&[name, "meets"], || what, share, limits::MEETS, own)
}

/// Whether a number of the road is in its range.
///
/// # Errors
/// If it is not, where the scenario says it under `name`, else at `own`.
pub fn check_number(
    scenario: &Scenario,
    name: &str,
    what: &str,
    found: f64,
    limit: Limit,
    own: &Origin,
) -> Result<(), PlanError> {
    Checker::of(scenario).within(&[name], || what.into(), found, limit, own)
}

/// Whether the numbers are in their ranges that say where somebody walks whose way is not simply across a straight road: the start from
/// the lane's centre, the place along the road and the goal beyond the kerb (m), and how far the way is turned (rad).
///
/// # Errors
/// If one is not.
pub fn check_places(
    scenario: &Scenario,
    declared: &DeclaredPedestrian,
    (start, along, goal): (f64, f64, f64),
    turned: f64,
) -> Result<(), PlanError> {
    let (checker, name, own) = (Checker::of(scenario), &declared.name, &declared.origin);
    let kind = declared.kind.word();
    let within = |key: &str, what: &str, found: f64, limit: Limit| {
        let what = || format!("the {what} of {kind} `{name}`");
        checker.within(&[name, key], what, found, limit, own)
    };
    within("start", "start", start, checker.start_limit(name))?;
    within("along", "place along the road", along, limits::ALONG)?;
    within("goal", "goal", goal, limits::GOAL)?;
    within("turned", "turn of the way", turned, limits::TURNED)
}

/// Of somebody who would not cross the road.
pub(super) fn starts_beyond(scenario: &Scenario, declared: &DeclaredPedestrian) -> PlanError {
    let (name, kind) = (&declared.name, declared.kind.word());
    let said = scenario.written.get(&format!("{name}.start"));
    let origin = said.map_or(&declared.origin, |said| &said.origin);
    PlanError::new(origin, format!("{kind} `{name}` starts beyond its goal"))
        .with_hint("a positive distance from the kerb is away from the road")
}

/// A distance that was worked out again from places in the world, without what rounding did to it.
fn tidy(metres: f64) -> f64 {
    if metres.abs() < 1e6 { (metres * 1e9).round() / 1e9 } else { metres }
}

struct Checker<'a> {
    scenario: &'a Scenario,
    /// The names of what the scenario has otherwise than it was written.
    offset: Vec<&'a str>,
}

impl<'a> Checker<'a> {
    fn of(scenario: &'a Scenario) -> Self {
        let offset = scenario.written.iter().filter(|(_, said)| said.offset != 0.0);
        Self { scenario, offset: offset.map(|(name, _)| name.as_str()).collect() }
    }

    /// A number that the scenario says under a name of these parts, or else at `fallback`; asked `what` it is where it is out of its
    /// range.
    fn within(
        &self,
        name: &[&str],
        what: impl FnOnce() -> String,
        found: f64,
        limit: Limit,
        fallback: &Origin,
    ) -> Result<(), PlanError> {
        self.number(name, what, found, (limit.dimension, limit.range), fallback)
    }

    fn number(
        &self,
        name: &[&str],
        what: impl FnOnce() -> String,
        found: f64,
        (dimension, (low, high)): (Dimension, (f64, f64)),
        fallback: &Origin,
    ) -> Result<(), PlanError> {
        // There are many numbers in many trials: their names are put together where that may matter.
        let may_be_offset =
            name.last().is_some_and(|last| self.offset.iter().any(|written| written.ends_with(last)));
        if !may_be_offset && (low..=high).contains(&found) {
            return Ok(());
        }
        let said = self.scenario.written.get(&name.join("."));
        let offset = said.map_or(0.0, |said| said.offset);
        let found = if offset == 0.0 { found } else { tidy(found - offset) };
        if (low..=high).contains(&found) {
            return Ok(());
        }
        let notation = said.and_then(|said| said.notation);
        let (message, range) = out_of_range(&what(), found, (low, high), dimension, notation);
        let hint = format!("keep it {range} for all values of what it depends on");
        Err(PlanError::new(said.map_or(fallback, |said| &said.origin), message).with_hint(hint))
    }

    /// Roads have the same numbers in all worlds.
    fn road(&self, world: &World) -> Result<(), PlanError> {
        let (road, own) = (&world.road, &self.scenario.origin);
        self.within(
            &["road", "lane_width"],
            || "the lane width".into(),
            road.lane_width,
            limits::LANE_WIDTH,
            own,
        )?;
        self.within(
            &["road", "speed_limit"],
            || "the speed limit".into(),
            road.speed_limit,
            limits::SPEED_LIMIT,
            own,
        )?;
        let signal = match road.crossing.kind {
            CrossingKind::Signalised(signal) => {
                signal.check().map_err(|error| PlanError::new(own, error.message).with_hint(error.hint))?;
                let TrafficSignal {
                    cycle,
                    pedestrian_green_from,
                    pedestrian_green,
                    amber,
                    clearance,
                    stop_line,
                } = signal;
                [cycle, pedestrian_green_from, pedestrian_green, amber, clearance, stop_line]
            }
            CrossingKind::Zebra | CrossingKind::Unmarked => [0.0; 6],
        };
        let bodies = road.boxes.iter().flat_map(|Body { x, y, length, width, .. }| [*x, *y, *length, *width]);
        for number in bodies.chain(signal).chain([road.crossing.width]) {
            self.finite(|| "a number of the road".into(), number, own)?;
        }
        Ok(())
    }

    fn finite(&self, what: impl FnOnce() -> String, found: f64, origin: &Origin) -> Result<(), PlanError> {
        if found.is_finite() {
            return Ok(());
        }
        let what = what();
        Err(PlanError::new(origin, format!("{what} is {found}, which is no number to calculate with"))
            .with_hint("check what it is calculated from"))
    }

    fn vehicle(&self, setup: &VehicleSetup, world: &World) -> Result<(), PlanError> {
        let declared = self.scenario.vehicle(&setup.name);
        let declared = declared.expect("a world has the vehicles of its scenario");
        let (name, own) = (&setup.name, &declared.origin);
        let of = |what: &str| format!("the {what} of vehicle `{name}`");
        let within =
            |key: &str, found: f64, limit: Limit| self.within(&[name, key], || of(key), found, limit, own);
        within("length", setup.length, limits::SIZE)?;
        within("width", setup.width, limits::SIZE)?;
        within("speed", setup.speed, limits::VEHICLE_SPEED)?;
        if let Some(speed) = setup.initial_speed {
            let what = || of("speed at the start");
            self.within(&[name, "initial_speed"], what, speed, limits::VEHICLE_SPEED, own)?;
        }
        within("follows", setup.behind, limits::BEHIND)?;
        if setup.lane >= world.road_of(setup).lanes.len() {
            let message = format!("the road has no lane {} for vehicle `{name}`", setup.lane);
            return Err(PlanError::new(own, message).with_hint("lanes count from 0"));
        }
        match setup.start {
            VehicleStart::Distance(distance) => within("start", distance, limits::VEHICLE_START)?,
            VehicleStart::TimeToArrival { time, x, .. } => {
                // One that nobody states is that of a pedestrian, who is checked under the own name.
                if !matches!(declared.start, DeclaredVehicleStart::Automatic) {
                    within("start", time, limits::VEHICLE_ARRIVAL)?;
                }
                self.finite(|| of("start"), x, own)?;
                if setup.placing_speed() == 0.0 {
                    let message = format!("vehicle `{name}` stands still, so that it has no time to arrival");
                    let hint = "give it a speed, or a place: `start 80 m before crossing`";
                    return Err(PlanError::new(own, message).with_hint(hint));
                }
            }
        }
        self.settings((name, "controller"), &setup.controller, &declared.controller.origin)?;
        let origin = declared.dynamics.as_ref().map_or(own, |model| &model.origin);
        self.settings((name, "dynamics"), &setup.dynamics, origin)?;
        if let Some(sees) = &setup.sees {
            let origin = declared.sees.as_ref().map_or(own, |model| &model.origin);
            self.settings((name, "sees"), sees, origin)?;
        }
        Ok(())
    }

    fn pedestrian(&self, index: usize, setup: &PedestrianSetup, world: &World) -> Result<(), PlanError> {
        let declared = &self.scenario.pedestrians[index];
        let (name, own, road) = (&setup.name, &declared.origin, &world.road);
        let kind = setup.kind.word();
        let of = |what: &str| format!("the {what} of {kind} `{name}`");
        let within = |key: &str, what: &str, found: f64, limit: Limit| {
            self.within(&[name, key], || of(what), found, limit, own)
        };
        match setup.shape {
            Shape::Disc { radius } => within("radius", "radius", radius, limits::RADIUS)?,
            Shape::Rectangle { length, width } => {
                within("length", "length", length, limits::SIZE)?;
                within("width", "width", width, limits::SIZE)?;
            }
        }
        let at = road.numbered_crossing(setup.crossing).0;
        let beyond =
            |car: &&VehicleSetup| setup.crossing > 0 && world.path_of(car).at_line(at) > world.finish;
        if let Some(car) = world.vehicles.iter().find(beyond) {
            let message = format!(
                "the crossing that {kind} `{name}` uses lies behind the finish line of vehicle `{}`, which may never come to it",
                car.name
            );
            let beyond = show(world.path_of(car).at_line(at).ceil() + 20.0, None, Dimension::LENGTH);
            return Err(PlanError::new(own, message).with_hint(format!("say `finish {beyond}`")));
        }
        // Where else somebody walks was checked where it was put into the plane.
        let aslant = (setup.goal.x - setup.start.x).abs() > 0.0;
        if road.bend.is_none() && !aslant {
            self.straight_across(setup, road, declared)?;
        }
        for number in [setup.start.x, setup.start.y, setup.goal.x, setup.goal.y] {
            self.finite(|| of("way"), number, own)?;
        }
        match setup.appears {
            Appearance::At(time) => {
                let what = || format!("the time at which {kind} `{name}` appears");
                self.within(&[name, "appears"], what, time, limits::APPEARS_AT, own)?;
            }
            Appearance::TimeToArrival { time, .. } => {
                let what = || format!("the time to arrival at which {kind} `{name}` appears");
                self.within(&[name, "appears"], what, time, limits::APPEARS_WHEN, own)?;
            }
            Appearance::Meeting { time, place, .. } => {
                let needed = || format!("the time that {kind} `{name}` needs to meet its vehicle");
                self.finite(needed, time, own)?;
                let met = || format!("the place at which {kind} `{name}` meets its vehicle");
                self.finite(met, place, own)?;
            }
        }
        self.may_go(setup, declared)?;
        within("reference", "reference point", setup.reference, limits::REFERENCE)?;
        self.settings((name, "model"), &setup.model, &declared.model.origin)
    }

    /// When a pedestrian may go: in the run, at least.
    fn may_go(&self, setup: &PedestrianSetup, declared: &DeclaredPedestrian) -> Result<(), PlanError> {
        let (name, own, kind) = (&setup.name, &declared.origin, setup.kind.word());
        let of = |what: &'static str| move || format!("the time {what} {kind} `{name}` may go");
        let (key, longest) = match setup.may_go {
            MayGo::AtOnce => return Ok(()),
            MayGo::After(time) => {
                let what = || format!("the time for which {kind} `{name}` looks");
                self.within(&[name, "looks"], what, time, limits::LOOKS, own)?;
                ("looks", time)
            }
            MayGo::TimeToArrival { time, or_after, .. } => {
                self.within(&[name, "may_go"], of("to arrival at which"), time, limits::MAY_GO_WHEN, own)?;
                self.within(&[name, "or_after"], of("after which"), or_after, limits::LOOKS, own)?;
                ("or_after", or_after)
            }
        };
        let from = match setup.appears {
            Appearance::At(time) => time,
            Appearance::TimeToArrival { .. } | Appearance::Meeting { .. } => 0.0,
        };
        if from + longest < self.scenario.horizon {
            return Ok(());
        }
        let said = self.scenario.written.get(&format!("{name}.{key}"));
        let time = |value| show(value, said.and_then(|said| said.notation), Dimension::TIME);
        let message = format!(
            "{kind} `{name}` may go at {} at the latest, and the run is over at {}",
            time(from + longest),
            time(self.scenario.horizon)
        );
        Err(PlanError::new(said.map_or(own, |said| &said.origin), message).with_hint(LOOKS_TOO_LONG))
    }

    /// Of somebody who walks straight across a straight road.
    fn straight_across(
        &self,
        setup: &PedestrianSetup,
        road: &Road,
        declared: &DeclaredPedestrian,
    ) -> Result<(), PlanError> {
        let (name, own, kind) = (&setup.name, &declared.origin, setup.kind.word());
        let within = |key: &str, what: &str, found: f64, limit: Limit| {
            let what = || format!("the {what} of {kind} `{name}`");
            self.within(&[name, key], what, found, limit, own)
        };
        let sign = setup.side.walking_sign();
        let start = sign * (road.outer_lane_centre(setup.side) - setup.start.y);
        let goal = sign * (setup.goal.y - road.kerb(setup.side.opposite()));
        within("start", "start", tidy(start), self.start_limit(name))?;
        let (at, _) = road.numbered_crossing(setup.crossing);
        let along = if setup.crossing == 0 { setup.start.x } else { tidy(setup.start.x - at) };
        within("along", "place along the road", along, limits::ALONG)?;
        within("goal", "goal", tidy(goal), limits::GOAL)?;
        if sign * (setup.goal.y - setup.start.y) <= 0.0 {
            return Err(starts_beyond(self.scenario, declared));
        }
        Ok(())
    }

    /// The limit of a start; a scenario that was not read from a text says it from the lane's centre.
    fn start_limit(&self, name: &str) -> Limit {
        let said = self.scenario.written.contains_key(&format!("{name}.start"));
        let (low, high) = limits::PEDESTRIAN_START.range;
        let half = if said { 0.0 } else { self.scenario.road.lane_width / 2.0 };
        Limit { range: (low, high + half), ..limits::PEDESTRIAN_START }
    }

    /// Every value of a model, those of people and presets included.
    fn settings<T: Registered>(
        &self,
        (who, part): (&str, &str),
        setup: &ModelSetup<T>,
        origin: &Origin,
    ) -> Result<(), PlanError> {
        let Some(declaration) = setup.model.declaration() else {
            let message = format!("there is nothing called `{}`", setup.model);
            return Err(
                PlanError::new(origin, message).with_hint("`scenario-runner models` lists what there is")
            );
        };
        for parameter in &declaration.parameters {
            let Some(value) = setup.settings.get(&parameter.name) else { continue };
            let Err(error) = parameter.check(&declaration.name, value) else { continue };
            let name: &[&str] = &[who, part, &parameter.name];
            let what = || format!("`{}` of `{}`", parameter.name, declaration.name);
            match (value, &parameter.kind) {
                (Value::Number(found), ParameterKind::Number { dimension, range, .. }) => {
                    self.number(name, what, *found, (*dimension, *range), origin)?;
                }
                (Value::Number(found), ParameterKind::Whole { range: (low, high), .. })
                    if found.fract() == 0.0 =>
                {
                    let range = (*low as f64, *high as f64);
                    self.number(name, what, *found, (Dimension::NUMBER, range), origin)?;
                }
                (Value::Number(found), ParameterKind::Whole { .. }) => {
                    let shown = show(*found, None, Dimension::NUMBER);
                    let origin =
                        self.scenario.written.get(&name.join(".")).map_or(origin, |said| &said.origin);
                    return Err(PlanError::new(
                        origin,
                        format!("{} is {shown}, but must be a whole number", what()),
                    )
                    .with_hint("let it be whole for all combinations of values"));
                }
                _ => {
                    return Err(PlanError::new(origin, error.to_string()).with_hint(format!(
                        "`scenario-runner models {}` says what it takes",
                        declaration.name
                    )));
                }
            }
        }
        Ok(())
    }
}
