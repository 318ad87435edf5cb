//! What is said to a program and what it answers, as lines of JSON or as rows of doubles.

use std::time::Duration;

use serde_json::{Map, Value as Json, json};

use super::quote::quoted;
use super::strict_json;
use scenario::{
    Answer, Crossing, CrossingKind, ParameterKind, RoadUserKind, STOP_LINE, SeenSignal, Settings, Shape,
    SignalState, Value, VehicleSetup, World,
};
use scenario::{FaultKind, ProgramFault};
use sim::{
    Command, CrossingView, EgoState, Mode, Observation, Order, RoadView, SeenPedestrian, SeenVehicle,
    SpeedPlan, toward,
};

/// Columns of the rows of runs.
pub const RUNS: [&str; 16] = [
    "slot",
    "time",
    "new",
    "cruise_speed",
    "distance_to_crossing",
    "speed",
    "acceleration",
    "length",
    "width",
    "lane_width",
    "speed_limit",
    "crossing_width",
    "pedestrian_priority",
    "signal",
    "right_kerb",
    "left_kerb",
];

/// Columns behind [`RUNS`] in rows of runs, for programs that ask for how lanes run: others know how long a row is. Those who ask are
/// told the names, so that more may follow.
pub const LANES: [&str; 7] =
    ["travelled", "curvature", "gradient", "amber", "stop_line", "lateral_offset", "heading_error"];

/// Columns of the rows of pedestrians.
pub const PEDESTRIANS: [&str; 10] = ["row", "id", "x", "y", "vx", "vy", "ax", "ay", "length", "width"];

/// Columns behind [`PEDESTRIANS`], for programs that ask for what people ride.
pub const KINDS: [&str; 1] = ["kind"];

/// Columns of the rows of vehicles.
pub const VEHICLES: [&str; 8] = ["row", "id", "x", "y", "vx", "vy", "length", "width"];

/// Columns of the rows that tell programs that ask for lanes how these bend ahead.
pub const CURVATURE_AHEAD: [&str; 3] = ["row", "distance", "curvature"];

/// Columns of the rows of crossings, for programs that ask for them.
pub const CROSSINGS: [&str; 6] =
    ["row", "distance", "width", "pedestrian_priority", "right_edge", "left_edge"];

/// What a program asks to be told in frames beside what all are told: those who do not ask have never heard of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MoreTables {
    /// How lanes run.
    pub lanes: bool,
    /// What people ride.
    pub kinds: bool,
    /// Every crossing, in the order in which the vehicle comes to them.
    pub crossings: bool,
}

impl MoreTables {
    /// All that there are.
    pub const ALL: Self = Self { lanes: true, kinds: true, crossings: true };

    /// Of the names in a hello; others are of runners to come.
    pub fn named(names: &[String]) -> Self {
        let is_named = |name: &str| names.iter().any(|one| one == name);
        Self { lanes: is_named("lanes"), kinds: is_named("kinds"), crossings: is_named("crossings") }
    }
}

/// More than a line or frame of a program's answer may have, bytes.
pub const LONGEST: usize = 1 << 20;

/// Points of a speed plan in rows of doubles.
const PLAN_POINTS: usize = 16;

/// A run that is to be opened.
pub struct Opened<'a> {
    /// By which it is spoken of until it is closed.
    pub slot: usize,
    /// Below 2^53, and of nothing that tells which run it is.
    pub seed: u64,
    /// The vehicle that is driven.
    pub setup: &'a VehicleSetup,
    /// Where that is.
    pub world: &'a World,
}

/// A decision that is asked for.
#[derive(Clone, Copy)]
pub struct DueDecision<'a> {
    /// Of its run.
    pub slot: usize,
    /// Whether it is the first of its run.
    pub is_new: bool,
    /// What is seen from the vehicle.
    pub seen: &'a Observation,
    /// Until the next decision, s.
    pub period: f64,
    /// At a signal: whether vehicles have green.
    pub signal: Option<bool>,
}

/// What was decided.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// What the vehicle is to do.
    pub order: Order,
    /// What the program is up to.
    pub mode: Mode,
    /// The curvature that it steers, 1/m, if it does.
    pub curvature: Option<f64>,
    /// The speed that it said, m/s, where the order is what brings the vehicle to one.
    pub speed: Option<f64>,
}

/// What came of one of several that were asked for.
pub type Answered = Result<Decision, ProgramFault>;

/// Runs to be opened, as JSON.
pub fn open(runs: &[Opened]) -> Json {
    json!({ "open": runs.iter().map(opened).collect::<Vec<_>>() })
}

/// One of them.
pub fn opened(run: &Opened) -> Json {
    let Opened { slot, seed, setup, world } = run;
    let (road, path) = (world.road_of(setup), world.path_of(setup));
    let declared = setup.controller.model.declaration();
    let whole = |name: &str| {
        declared
            .and_then(|declared| declared.parameter(name))
            .is_some_and(|parameter| matches!(parameter.kind, ParameterKind::Whole { .. }))
    };
    let own = road.lanes[setup.lane].direction;
    let lanes: Vec<Json> = (0..road.lanes.len())
        .map(|lane| {
            let y = path.from_world(road.path(lane).point(0.0)).y;
            json!({"y": y, "direction": if road.lanes[lane].direction == own { 1 } else { -1 }})
        })
        .collect();
    let boxes: Vec<Json> = world
        .road
        .boxes
        .iter()
        .map(|body| {
            let place = path.from_world([body.x, body.y].into());
            let mut found = json!({"x": place.x, "y": place.y, "length": body.length, "width": body.width});
            if setup.road > 0 {
                let along = path.turned(place.x, body.along());
                found["heading"] = json!(libm::atan2(along.y, along.x));
            }
            found
        })
        .collect();
    let kind = |crossing: &Crossing| match crossing.kind {
        CrossingKind::Zebra => "zebra",
        CrossingKind::Unmarked => "unmarked",
        CrossingKind::Signalised { .. } => "signalised",
    };
    let (right, left) = path.kerbs(road);
    let others = road.other_crossings.iter().map(|other| {
        let x = path.at_line(other.along);
        json!({"name": other.name, "kind": kind(&other.crossing), "width": other.crossing.width, "x": x})
    });
    let mut opened = json!({
        "slot": slot,
        "seed": seed,
        "step": world.step,
        "parameters": parameters(&setup.controller.settings, whole),
        "cruise_speed": setup.speed,
        "vehicle": {"length": setup.length, "width": setup.width},
        "road": {
            "lane_width": road.lane_width,
            "speed_limit": road.speed_limit,
            "lanes": lanes,
            "crossing": {"kind": kind(&road.crossing), "width": road.crossing.width, "x": 0.0},
            "kerbs": {"right": right, "left": left},
            "boxes": boxes,
        },
    });
    if !road.other_crossings.is_empty() {
        opened["road"]["other_crossings"] = others.collect();
    }
    opened
}

fn parameters(settings: &Settings, whole: impl Fn(&str) -> bool) -> Json {
    let value = |name: &str, value: &Value| match value {
        Value::Flag(flag) => json!(flag),
        Value::Number(number) if whole(name) => json!(*number as i64),
        Value::Number(number) => json!(number),
        Value::Word(word) => json!(word),
    };
    Json::Object(settings.0.iter().map(|(name, one)| (name.clone(), value(name, one))).collect())
}

/// Decisions to be taken, as JSON.
pub fn step(asked: &[DueDecision]) -> Json {
    json!({ "step": asked.iter().map(scene).collect::<Vec<_>>() })
}

/// One of them.
pub fn scene(asked: &DueDecision) -> Json {
    let DueDecision { slot, is_new, seen, signal, period: _ } = asked;
    let Observation { time, ego, cruise_speed, road, pedestrians, vehicles } = *seen;
    let mut view = Map::new();
    for (name, value) in [
        ("lane_width", json!(road.lane_width)),
        ("speed_limit", json!(road.speed_limit)),
        ("crossing_width", json!(road.crossing_width)),
        ("pedestrian_priority", json!(road.pedestrian_priority)),
        ("right_kerb", json!(road.right_kerb)),
        ("left_kerb", json!(road.left_kerb)),
    ] {
        view.insert(name.into(), value);
    }
    if !road.curvature_ahead.is_empty() {
        view.insert("curvature_ahead".into(), json!(road.curvature_ahead));
    }
    if let Some(gradient) = road.gradient {
        view.insert("gradient".into(), json!(gradient));
    }
    // One at which people wait beyond the kerbs is what the fields above say.
    let [right, left] = [road.right_kerb, road.left_kerb];
    let is_all = |one: &CrossingView| (one.right_edge, one.left_edge) == (right, left);
    if road.crossings.len() > 1 || !road.crossings.iter().all(is_all) {
        view.insert("crossings".into(), json!(road.crossings));
    }
    if let Some(green) = signal {
        view.insert("signal".into(), json!(green));
    }
    if let Some(seen) = road.signal {
        view.insert("amber".into(), json!(seen.state == SignalState::Amber));
        view.insert("stop_line".into(), json!(seen.stop_line));
    }
    let people: Vec<Json> = pedestrians
        .iter()
        .map(|one| {
            let (length, width) = one.shape.extents();
            let mut person = json!({
                "id": one.id, "x": one.position.x, "y": one.position.y, "vx": one.velocity.x, "vy": one.velocity.y,
                "ax": one.acceleration.x, "ay": one.acceleration.y, "length": length, "width": width,
            });
            // Who says nothing of it is on foot.
            if !one.kind.is_pedestrian() {
                person["kind"] = json!(one.kind);
            }
            person
        })
        .collect();
    let cars: Vec<Json> = vehicles
        .iter()
        .map(|one| {
            json!({
                "id": one.id, "x": one.position.x, "y": one.position.y, "vx": one.velocity.x, "vy": one.velocity.y,
                "length": one.length, "width": one.width,
            })
        })
        .collect();
    let mut own = json!({
        "distance_to_crossing": ego.distance_to_crossing, "speed": ego.speed, "acceleration": ego.acceleration,
        "length": ego.length, "width": ego.width, "travelled": ego.travelled,
    });
    for (name, value) in [
        ("curvature", ego.curvature),
        ("lateral_offset", ego.lateral_offset),
        ("heading_error", ego.heading_error),
    ] {
        if value != 0.0 {
            own[name] = json!(value);
        }
    }
    json!({
        "slot": slot, "time": time, "new": is_new, "cruise_speed": cruise_speed, "ego": own,
        "road": view, "pedestrians": people, "vehicles": cars,
    })
}

/// A decision to be taken, of its JSON: what is seen, whether it is the first, and whether vehicles have green.
pub fn read_scene(scene: &Json) -> Option<(Observation, bool, Option<bool>)> {
    let number = |of: &Json, name: &str| of.get(name)?.as_f64();
    let pair = |of: &Json, x: &str, y: &str| Some([number(of, x)?, number(of, y)?].into());
    let id = |of: &Json| usize::try_from(of.get("id")?.as_u64()?).ok();
    let (ego, road) = (scene.get("ego")?, scene.get("road")?);
    let person = |one: &Json| {
        Some(SeenPedestrian {
            id: id(one)?,
            kind: match one.get("kind") {
                Some(kind) => serde_json::from_value(kind.clone()).ok()?,
                None => RoadUserKind::Pedestrian,
            },
            position: pair(one, "x", "y")?,
            velocity: pair(one, "vx", "vy")?,
            acceleration: pair(one, "ax", "ay")?,
            shape: Shape::Rectangle { length: number(one, "length")?, width: number(one, "width")? },
        })
    };
    let vehicle = |one: &Json| {
        Some(SeenVehicle {
            id: id(one)?,
            position: pair(one, "x", "y")?,
            velocity: pair(one, "vx", "vy")?,
            length: number(one, "length")?,
            width: number(one, "width")?,
        })
    };
    let change = |one: &Json| Some((one.get(0)?.as_f64()?, one.get(1)?.as_f64()?));
    let curvature_ahead = match road.get("curvature_ahead") {
        None => Vec::new(),
        Some(told) => told.as_array()?.iter().map(change).collect::<Option<_>>()?,
    };
    let distance_to_crossing = number(ego, "distance_to_crossing")?;
    let crossings: Vec<CrossingView> = match road.get("crossings") {
        Some(told) => serde_json::from_value(told.clone()).ok()?,
        None => vec![CrossingView {
            distance: distance_to_crossing,
            width: number(road, "crossing_width")?,
            pedestrian_priority: road.get("pedestrian_priority")?.as_bool()?,
            right_edge: number(road, "right_kerb")?,
            left_edge: number(road, "left_kerb")?,
        }],
    };
    let seen = Observation {
        time: number(scene, "time")?,
        ego: EgoState {
            distance_to_crossing,
            speed: number(ego, "speed")?,
            acceleration: number(ego, "acceleration")?,
            length: number(ego, "length")?,
            width: number(ego, "width")?,
            // Older ones do not say it.
            travelled: number(ego, "travelled").unwrap_or(-distance_to_crossing),
            curvature: number(ego, "curvature").unwrap_or(0.0),
            lateral_offset: number(ego, "lateral_offset").unwrap_or(0.0),
            heading_error: number(ego, "heading_error").unwrap_or(0.0),
        },
        cruise_speed: number(scene, "cruise_speed")?,
        road: RoadView {
            lane_width: number(road, "lane_width")?,
            speed_limit: number(road, "speed_limit")?,
            crossing_width: number(road, "crossing_width")?,
            pedestrian_priority: road.get("pedestrian_priority")?.as_bool()?,
            right_kerb: number(road, "right_kerb")?,
            left_kerb: number(road, "left_kerb")?,
            signal: signal(road),
            gradient: number(road, "gradient"),
            curvature_ahead,
            crossings,
        },
        pedestrians: scene.get("pedestrians")?.as_array()?.iter().map(person).collect::<Option<_>>()?,
        vehicles: scene.get("vehicles")?.as_array()?.iter().map(vehicle).collect::<Option<_>>()?,
    };
    Some((seen, scene.get("new")?.as_bool()?, road.get("signal").and_then(Json::as_bool)))
}

/// What the signal shows; older ones know neither amber nor where the line is.
fn signal(road: &Json) -> Option<SeenSignal> {
    let state = match road.get("signal")?.as_bool()? {
        true => SignalState::Green,
        false if road.get("amber").and_then(Json::as_bool) == Some(true) => SignalState::Amber,
        false => SignalState::Red,
    };
    Some(SeenSignal { state, stop_line: road.get("stop_line").and_then(Json::as_f64).unwrap_or(STOP_LINE) })
}

/// A frame of text.
pub fn text_frame(text: &str, into: &mut Vec<u8>) {
    into.clear();
    words(&[text.len() as u32 + 4, 0], into);
    into.extend_from_slice(text.as_bytes());
}

fn words(numbers: &[u32], into: &mut Vec<u8>) {
    numbers.iter().for_each(|number| into.extend_from_slice(&number.to_le_bytes()));
}

/// Decisions to be taken, as a frame of rows; with more for those who ask for that.
pub fn step_frame(asked: &[DueDecision], more: MoreTables, into: &mut Vec<u8>) {
    let pedestrians: usize = asked.iter().map(|one| one.seen.pedestrians.len()).sum();
    let vehicles: usize = asked.iter().map(|one| one.seen.vehicles.len()).sum();
    let bends = |one: &DueDecision| if more.lanes { one.seen.road.curvature_ahead.len() } else { 0 };
    let places = |one: &DueDecision| if more.crossings { one.seen.road.crossings.len() } else { 0 };
    let changes: usize = asked.iter().map(bends).sum();
    let crossings: usize = asked.iter().map(places).sum();
    let doubles = asked.len() * (RUNS.len() + if more.lanes { LANES.len() } else { 0 })
        + pedestrians * (PEDESTRIANS.len() + if more.kinds { KINDS.len() } else { 0 })
        + vehicles * VEHICLES.len()
        + changes * CURVATURE_AHEAD.len()
        + crossings * CROSSINGS.len();
    into.clear();
    let counts = [asked.len(), pedestrians, vehicles, changes, crossings].map(|count| count as u32);
    words(&[28 + 8 * doubles as u32, 1, counts[0], counts[1], counts[2], counts[3], counts[4], 0], into);
    let mut row =
        |values: &[f64]| values.iter().for_each(|value| into.extend_from_slice(&value.to_le_bytes()));
    for DueDecision { slot, is_new, seen, signal, period: _ } in asked {
        let (ego, road) = (&seen.ego, &seen.road);
        row(&[
            *slot as f64,
            seen.time,
            f64::from(*is_new),
            seen.cruise_speed,
            ego.distance_to_crossing,
            ego.speed,
            ego.acceleration,
            ego.length,
            ego.width,
            road.lane_width,
            road.speed_limit,
            road.crossing_width,
            f64::from(road.pedestrian_priority),
            signal.map_or(f64::NAN, f64::from),
            road.right_kerb,
            road.left_kerb,
        ]);
        if more.lanes {
            let of_signal = |number: fn(SeenSignal) -> f64| road.signal.map_or(f64::NAN, number);
            row(&[
                ego.travelled,
                ego.curvature,
                road.gradient.unwrap_or(f64::NAN),
                of_signal(|seen| f64::from(seen.state == SignalState::Amber)),
                of_signal(|seen| seen.stop_line),
                ego.lateral_offset,
                ego.heading_error,
            ]);
        }
    }
    for (index, one) in asked.iter().enumerate() {
        for seen in &one.seen.pedestrians {
            let ((length, width), at) = (seen.shape.extents(), seen.position);
            let (velocity, acceleration) = (seen.velocity, seen.acceleration);
            row(&[
                index as f64,
                seen.id as f64,
                at.x,
                at.y,
                velocity.x,
                velocity.y,
                acceleration.x,
                acceleration.y,
                length,
                width,
            ]);
            if more.kinds {
                row(&[kind_number(seen.kind)]);
            }
        }
    }
    for (index, one) in asked.iter().enumerate() {
        for seen in &one.seen.vehicles {
            let (at, velocity) = (seen.position, seen.velocity);
            row(&[index as f64, seen.id as f64, at.x, at.y, velocity.x, velocity.y, seen.length, seen.width]);
        }
    }
    for (index, one) in asked.iter().enumerate() {
        for (distance, curvature) in &one.seen.road.curvature_ahead[..bends(one)] {
            row(&[index as f64, *distance, *curvature]);
        }
    }
    for (index, one) in asked.iter().enumerate() {
        for seen in &one.seen.road.crossings[..places(one)] {
            let priority = f64::from(seen.pedestrian_priority);
            row(&[index as f64, seen.distance, seen.width, priority, seen.right_edge, seen.left_edge]);
        }
    }
}

/// What rows of doubles have for what somebody rides.
fn kind_number(kind: RoadUserKind) -> f64 {
    match kind {
        RoadUserKind::Pedestrian => 1.0,
        RoadUserKind::Cyclist => 2.0,
        RoadUserKind::Escooter => 3.0,
    }
}

/// An answer as a program would say it in JSON.
pub fn said(decision: &Decision) -> Json {
    let mut said = match (&decision.order, decision.speed) {
        (_, Some(speed)) => json!({ "speed": speed }),
        (Order::Command(Command::Acceleration(value)), None) => json!({ "acceleration": value }),
        (Order::Command(Command::Pedals { throttle, brake }), None) => {
            json!({"throttle": throttle, "brake": brake})
        }
        (Order::Plan(plan), None) => json!({ "speed_plan": plan.points() }),
    };
    let mode = decision.mode.as_str();
    if !mode.is_empty() {
        said["mode"] = json!(mode);
    }
    if let Some(curvature) = decision.curvature {
        said["curvature"] = json!(curvature);
    }
    said
}

/// What a program answers: decisions in the order in which they were asked for, or which runs it cannot decide in.
pub enum Reply {
    Decided(Vec<Answered>),
    /// Slots, and why.
    Refused(Vec<(usize, String)>),
}

/// Lines that a program may say before its hello.
pub const MOST_LINES_BEFORE_HELLO: usize = 100;

/// What was said before anything was asked would be taken for the answer to what is asked next: a program never speaks first.
pub fn unasked(said: &[u8]) -> ProgramFault {
    garbage(format!("it said more than it was asked for: {}", quoted(said)))
}

/// What is wrong with a line that is longer than [`LONGEST`].
pub fn too_long(line: &[u8]) -> String {
    format!("a line of more than 1 MiB that begins with {}", quoted(line))
}

/// How many bytes of a frame follow its length, or what is wrong with that.
pub fn frame_size(length: [u8; 4]) -> Result<usize, String> {
    let size = u32::from_le_bytes(length) as usize;
    if (4..=LONGEST).contains(&size) {
        return Ok(size);
    }
    Err(format!("a frame of {size} bytes, which begins with {}", quoted(&length)))
}

/// There was no answer within its time.
pub fn late(limit: Duration) -> ProgramFault {
    ProgramFault::new(FaultKind::Timeout, format!("no answer within {} s", limit.as_secs_f64()))
}

pub fn garbage(message: impl Into<String>) -> ProgramFault {
    ProgramFault::new(FaultKind::Garbage, message)
}

/// The runs that a text says cannot be decided in, if it says that.
pub fn refused(value: &Json) -> Option<Vec<(usize, String)>> {
    let listed = value.get("error").or_else(|| value.get("failed"))?.as_array()?;
    let one = |error: &Json| {
        let slot = usize::try_from(error.get("slot")?.as_u64()?).ok()?;
        let message = error.get("message").and_then(Json::as_str).unwrap_or("no reason is given");
        Some((slot, message.to_string()))
    };
    listed.iter().map(one).collect()
}

/// Why nothing can be asked of the process any more, if a text that refuses runs says so: `"last": true`.
pub fn last_refusal(value: &Json) -> Option<ProgramFault> {
    value.get("last")?.as_bool().filter(|is_last| *is_last)?;
    let (_, message) = refused(value)?.into_iter().next()?;
    Some(ProgramFault::new(FaultKind::Refused, message))
}

/// A line of JSON as an answer to `asked`.
pub fn read_line(line: &[u8], gives: Answer, asked: &[DueDecision]) -> Result<Reply, ProgramFault> {
    let value = strict_json::read(line).map_err(|wrong| garbage(format!("{} {wrong}", quoted(line))))?;
    if let Some(fault) = last_refusal(&value) {
        return Err(fault);
    }
    if let Some(slots) = refused(&value) {
        return Ok(Reply::Refused(slots));
    }
    let Some(answers) = value.get("answer").and_then(Json::as_array) else {
        return Err(garbage(format!("{} is no answer", quoted(line))));
    };
    if answers.len() != asked.len() {
        return Err(garbage(format!("it answered for {} runs, asked for {}", answers.len(), asked.len())));
    }
    let number = |answer: &Json, name: &str| match answer.get(name) {
        Some(value) => {
            value.as_f64().ok_or_else(|| bad_value(format!("`{name}` is {value}, which is no number")))
        }
        None => Err(garbage(format!("an answer has no `{name}`: {}", quoted(answer.to_string().as_bytes())))),
    };
    let decision = |(answer, asked): (&Json, &DueDecision)| {
        let order = match gives {
            Answer::Acceleration => acceleration(number(answer, "acceleration")?),
            Answer::Pedals => pedals(number(answer, "throttle")?, number(answer, "brake")?),
            Answer::Speed => speed(number(answer, "speed")?, asked),
            Answer::SpeedPlan => {
                let points = answer.get("speed_plan").and_then(Json::as_array);
                let points = points.ok_or_else(|| garbage("an answer has no `speed_plan`"))?;
                let point = |point: &Json| match point.as_array().map(Vec::as_slice) {
                    Some([time, speed]) => Some((time.as_f64()?, speed.as_f64()?)),
                    _ => None,
                };
                let points: Option<Vec<_>> = points.iter().map(point).collect();
                plan(points.ok_or_else(|| bad_value("a point of a plan is no pair of numbers"))?)
            }
        }?;
        let mode = match answer.get("mode") {
            None | Some(Json::Null) => "",
            Some(Json::String(word)) => word,
            Some(other) => return Err(bad_value(format!("`mode` is {other}, which is no word"))),
        };
        let speed = answer.get("speed").and_then(Json::as_f64).filter(|_| gives == Answer::Speed);
        let curvature = match answer.get("curvature") {
            None | Some(Json::Null) => None,
            Some(_) => Some(steered(number(answer, "curvature")?)?),
        };
        Ok(Decision { order, mode: Mode::from(mode.to_string()), curvature, speed })
    };
    each(answers.iter().zip(asked).map(decision))
}

/// What is no value ends its run; what is no answer ends the process.
fn each(all: impl Iterator<Item = Answered>) -> Result<Reply, ProgramFault> {
    let one = |answer: Answered| match answer {
        Err(fault) if fault.kind.is_final() => Err(fault),
        other => Ok(other),
    };
    all.map(one).collect::<Result<_, _>>().map(Reply::Decided)
}

/// A frame (without its length) as an answer to `asked`.
pub fn read_frame(
    frame: &[u8],
    gives: Answer,
    asked: &[DueDecision],
    modes: &[Mode],
) -> Result<Reply, ProgramFault> {
    let word = |index: usize| {
        frame
            .get(4 * index..4 * index + 4)
            .map(|bytes| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    };
    match word(0) {
        Some(0) => {
            let text = &frame[4..];
            let value =
                strict_json::read(text).map_err(|wrong| garbage(format!("{} {wrong}", quoted(text))))?;
            if let Some(fault) = last_refusal(&value) {
                return Err(fault);
            }
            let slots = refused(&value).map(Reply::Refused);
            return slots.ok_or_else(|| garbage(format!("{} is no answer", quoted(text))));
        }
        Some(2) => {}
        _ => return Err(garbage(format!("{} is no frame of an answer", quoted(frame)))),
    }
    let own = match gives {
        Answer::Acceleration | Answer::Speed => 1,
        Answer::Pedals => 2,
        Answer::SpeedPlan => 2 * PLAN_POINTS,
    };
    let (runs, columns) = (word(1).unwrap_or(0) as usize, word(2).unwrap_or(0) as usize);
    if runs != asked.len() || !(own..=own + 2).contains(&columns) || frame.len() != 12 + 8 * runs * columns {
        return Err(garbage(format!(
            "a frame of {} bytes with {runs} rows of {columns} columns, where {} rows of {} were due, or of {} with a curvature",
            frame.len(),
            asked.len(),
            own + 1,
            own + 2
        )));
    }
    let double = |bytes: &[u8]| {
        f64::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3], bytes[4], bytes[5], bytes[6], bytes[7]])
    };
    let decision = |(row, asked): (&[u8], &DueDecision)| {
        let value = |column: usize| double(&row[8 * column..8 * column + 8]);
        let order = match gives {
            Answer::Acceleration => acceleration(value(0)),
            Answer::Pedals => pedals(value(0), value(1)),
            Answer::Speed => speed(value(0), asked),
            Answer::SpeedPlan => {
                let points = (0..PLAN_POINTS).map(|point| (value(2 * point), value(2 * point + 1)));
                plan(points.take_while(|(time, speed)| !(time.is_nan() && speed.is_nan())).collect())
            }
        }?;
        let mode = if columns > own { known_mode(value(own), modes)? } else { Mode::NONE };
        let speed = (gives == Answer::Speed).then(|| value(0));
        let curvature = Some(own + 1).filter(|column| *column < columns).map(value);
        let curvature = curvature.filter(|value| !value.is_nan()).map(steered).transpose()?;
        Ok(Decision { order, mode, curvature, speed })
    };
    each(frame[12..].chunks_exact(8 * columns.max(1)).zip(asked).map(decision))
}

/// The mode of that index of those in the hello; -1 is none.
fn known_mode(index: f64, modes: &[Mode]) -> Result<Mode, ProgramFault> {
    if index == -1.0 {
        return Ok(Mode::NONE);
    }
    let place = (index.fract() == 0.0 && index >= 0.0).then_some(index as usize);
    place.and_then(|place| modes.get(place)).cloned().ok_or_else(|| match modes.len() {
        0 => bad_value(format!("a mode of {index}, and its hello has no `modes`: -1 is none")),
        many => bad_value(format!(
            "a mode of {index}, which is neither -1 nor a whole number of 0 .. {}",
            many - 1
        )),
    })
}

fn bad_value(message: impl Into<String>) -> ProgramFault {
    ProgramFault::new(FaultKind::BadValue, message)
}

fn acceleration(value: f64) -> Result<Order, ProgramFault> {
    if value.is_finite() && value.abs() <= 50.0 {
        Ok(Order::Command(Command::Acceleration(value)))
    } else {
        Err(bad_value(format!("an acceleration of {value} m/s², outside -50 .. 50 m/s²")))
    }
}

/// A curvature that somebody may ask for; what the vehicle makes of it is its own.
fn steered(curvature: f64) -> Result<f64, ProgramFault> {
    if curvature.abs() <= 10.0 {
        Ok(curvature)
    } else {
        Err(bad_value(format!("a curvature of {curvature} 1/m, outside -10 .. 10 1/m")))
    }
}

fn pedals(throttle: f64, brake: f64) -> Result<Order, ProgramFault> {
    if (0.0..=1.0).contains(&throttle) && (0.0..=1.0).contains(&brake) {
        Ok(Order::Command(Command::Pedals { throttle, brake }))
    } else {
        Err(bad_value(format!("throttle {throttle} and brake {brake}, outside 0 .. 1")))
    }
}

fn speed(value: f64, asked: &DueDecision) -> Result<Order, ProgramFault> {
    if (0.0..=100.0).contains(&value) {
        let acceleration = toward(value, asked.seen.ego.speed, asked.period);
        Ok(Order::Command(Command::Acceleration(acceleration)))
    } else {
        Err(bad_value(format!("a speed of {value} m/s, outside 0 .. 100 m/s")))
    }
}

fn plan(points: Vec<(f64, f64)>) -> Result<Order, ProgramFault> {
    let plan = SpeedPlan::new(points).map_err(|error| bad_value(error.to_string()))?;
    Ok(Order::Plan(Box::new(plan)))
}
