//! Recorded runs as JSON inside the page, few digits and bounded in size.

use serde_json::{Value, json};

use crate::replay::describe;
use files::escape::html_characters;
use results::Chosen;
use results::Recording;
use results::SuiteReport;
use scenario::{CrossingKind, Side};

/// All of them together may take this much of the page, in bytes.
const MOST_BYTES: usize = 3_000_000;

/// What the page's script reads.
pub struct Embedded {
    /// A JSON array that is safe inside a `script` element.
    pub json: String,
    pub count: usize,
    /// Keys of the runs in it.
    pub keys: Vec<String>,
    /// How many chosen runs would have made the page too large.
    pub left_out: usize,
}

/// The runs that are to be animated, as many as fit.
pub fn embed(reports: &[SuiteReport], recordings: &[(Chosen, Recording)]) -> Embedded {
    let mut texts: Vec<String> = Vec::new();
    let (mut bytes, mut left_out, mut keys) = (0, 0, Vec::new());
    for (chosen, recording) in recordings {
        let Some(reason) = &chosen.reason else { continue };
        // `<` would let a name end the element.
        let text = plain(run(reports, recording, reason)).to_string().replace('<', "\\u003c");
        if bytes + text.len() > MOST_BYTES {
            left_out += 1;
            continue;
        }
        bytes += text.len();
        keys.push(chosen.key.clone());
        texts.push(text);
    }
    Embedded { json: format!("[{}]", texts.join(",\n")), count: texts.len(), keys, left_out }
}

fn run(reports: &[SuiteReport], recording: &Recording, reason: &str) -> Value {
    let case = &recording.case;
    let road = &case.world.road;
    let belongs = |report: &&SuiteReport| {
        report.trials.iter().flat_map(|trial| &trial.outcomes).any(|known| known.key == case.key)
    };
    let command = reports
        .iter()
        .find(belongs)
        .map_or_else(String::new, |report| report.identity.replay_command(&case.key));
    let signal = match road.crossing.kind {
        CrossingKind::Signalised { cycle, pedestrian_green_from, pedestrian_green } => {
            json!([cycle, pedestrian_green_from, pedestrian_green])
        }
        CrossingKind::Zebra | CrossingKind::Unmarked => Value::Null,
    };
    let users = recording.users.iter().enumerate().map(|(who, places)| {
        let (length, width, round) = recording.footprint(who);
        let numbers = |pick: fn(&results::Place) -> f64| -> Vec<Value> {
            places
                .iter()
                .map(|place| place.as_ref().map_or(Value::Null, |place| rounded(pick(place))))
                .collect()
        };
        json!({
            "name": recording.name(who),
            "kind": if who < case.world.vehicles.len() { "vehicle" } else { "pedestrian" },
            "length": length,
            "width": width,
            "round": round,
            "x": numbers(|place| place.x),
            "y": numbers(|place| place.y),
            "v": numbers(|place| place.speed),
            "h": numbers(|place| place.heading),
        })
    });
    let events =
        recording.events.iter().map(|event| json!([rounded(event.time), event.who, describe(&event.what)]));
    let pairs = recording.pairs().into_iter().map(|pair| {
        let points: Vec<Value> =
            pair.points.iter().map(|(car, person)| json!([rounded(*car), rounded(*person)])).collect();
        json!({ "vehicle": pair.vehicle, "pedestrian": pair.pedestrian, "points": points })
    });
    json!({
        "key": case.key,
        "reason": reason,
        "command": command,
        "times": recording.times.iter().map(|time| rounded(*time)).collect::<Vec<_>>(),
        "road": {
            "width": road.lane_width,
            "lanes": (0..road.lanes.len()).map(|lane| road.path(lane).heading(0.0).x).collect::<Vec<_>>(),
            "near": road.kerb(Side::Near),
            "far": road.kerb(Side::Far),
            "zebra": road.crossing.kind == CrossingKind::Zebra,
            "signal": signal,
            "crossing": road.crossing.width,
            "boxes": road.boxes.iter().map(|body| json!([body.x, body.y, body.length, body.width])).collect::<Vec<_>>(),
        },
        "users": users.collect::<Vec<_>>(),
        "events": events.collect::<Vec<_>>(),
        "pairs": pairs.collect::<Vec<_>>(),
    })
}

/// With strings that turn nothing around where the page shows them.
fn plain(value: Value) -> Value {
    match value {
        Value::String(text) => Value::String(html_characters(&text)),
        Value::Array(items) => items.into_iter().map(plain).collect(),
        Value::Object(fields) => fields.into_iter().map(|(name, value)| (name, plain(value))).collect(),
        other => other,
    }
}

/// To the centimetre (or centimetre per second, or hundredth of a radian): drawing needs no more.
fn rounded(value: f64) -> Value {
    let hundredths = (value * 100.0).round();
    if hundredths % 100.0 == 0.0 { json!((hundredths / 100.0) as i64) } else { json!(hundredths / 100.0) }
}
