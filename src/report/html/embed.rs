//! Recorded runs as JSON inside the page, few digits and bounded in size.

use nalgebra::Vector2;
use serde_json::{Value, json};

use super::minds;
use super::pairs::user_look;
use super::plots::RunPlots;
use super::still::{Still, still};
use super::told::{RunTold, find, quoted};
use crate::drawing::{Mark, beside, stop_lines, view, world_marks};
use crate::replay::describe;
use files::escape::html_characters;
use results::{Chosen, Recording, Requests, SuiteReport, Verdict};
use scenario::{CrossingKind, Side, TrafficSignal};
use sim::{Happening, PerceivedOther, PerceivedView};

/// All of them together may take this much of the page, in bytes: what the script reads, and what is drawn over time.
const MOST_BYTES: usize = 3_000_000;

/// What the page's script reads.
pub struct Embedded {
    /// A JSON array that is safe inside a `script` element. The first is the worst failure, if there is one.
    pub json: String,
    pub count: usize,
    /// Keys of the runs in it.
    pub keys: Vec<String>,
    /// How many chosen runs would have made the page too large.
    pub left_out: usize,
    /// What is drawn of each over time.
    pub plots: Vec<RunPlots>,
    /// What the page shows before its script does: of the first run.
    pub first: Option<LeadRun>,
}

/// A run as it is shown without the script.
pub struct LeadRun {
    pub told: RunTold,
    pub still: Still,
    pub key: String,
    /// Replays it.
    pub command: String,
    /// Whether a criterion is not fulfilled because of it.
    pub is_failure: bool,
    /// Whether that is decided.
    pub is_certain: bool,
}

/// The runs that are to be animated, as many as fit; the worst failure comes first.
pub fn embed(reports: &[SuiteReport], requests: &Requests, recordings: &[(Chosen, Recording)]) -> Embedded {
    let mut drawn: Vec<(&Recording, &str, RunTold, Severity)> = Vec::new();
    for (chosen, recording) in recordings {
        let Some(reason) = &chosen.reason else { continue };
        let told = RunTold::new(reports, requests, recording);
        let severity = severity(reports, &recording.case.key, &told);
        drawn.push((recording, reason, told, severity));
    }
    if let Some(worst) = (0..drawn.len()).rev().max_by(|one, other| drawn[*one].3.cmp(&drawn[*other].3)) {
        let worst = drawn.remove(worst);
        drawn.insert(0, worst);
    }
    let (mut texts, mut plots): (Vec<String>, Vec<RunPlots>) = Default::default();
    let (mut bytes, mut left_out, mut keys, mut first) = (0, 0, Vec::new(), None);
    for (recording, reason, told, severity) in drawn {
        let command = replay(reports, &recording.case.key);
        let text = script_text(run(recording, reason, &command, &told));
        let drawn = RunPlots::new(reports, requests, recording, told.moment);
        let size = text.len() + drawn.size();
        if bytes + size > MOST_BYTES {
            left_out += 1;
            continue;
        }
        bytes += size;
        keys.push(recording.case.key.clone());
        plots.push(drawn);
        texts.push(text);
        let end = recording.times.last().copied().unwrap_or(0.0);
        first.get_or_insert_with(|| LeadRun {
            still: still(recording, told.moment.unwrap_or(end / 2.0)),
            key: recording.case.key.clone(),
            command: replay(reports, &recording.case.key),
            is_failure: severity.verdict > Verdict::Passed,
            is_certain: severity.verdict == Verdict::Failed,
            told,
        });
    }
    Embedded { json: format!("[{}]", texts.join(",\n")), count: texts.len(), keys, left_out, plots, first }
}

/// How bad a run is, to be compared: what its trial failed because of it, how fast bodies met in it, and the share of runs that are so.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Severity {
    verdict: Verdict,
    contact: f64,
    share: f64,
}

impl Severity {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let speed = self.contact.total_cmp(&other.contact);
        self.verdict.cmp(&other.verdict).then(speed).then(self.share.total_cmp(&other.share))
    }
}

fn severity(reports: &[SuiteReport], key: &str, told: &RunTold) -> Severity {
    let contact = told.contact.unwrap_or(-1.0);
    let none = Severity { verdict: Verdict::Passed, contact, share: 0.0 };
    let Some((trial, _)) = find(reports, key) else { return none };
    // What only many runs together fail, such as a spread, is no failure that a run would show.
    if told.contact.is_none() && told.why.iter().all(|one| one.class == "passed") {
        return none;
    }
    let named = trial.findings().iter().filter(|finding| finding.worst.iter().any(|run| run.key == key));
    let each = named.filter(|finding| finding.verdict != Verdict::Passed).map(|finding| Severity {
        verdict: finding.verdict,
        contact,
        share: 1.0 - finding.holding as f64 / finding.runs.max(1) as f64,
    });
    each.fold(none, |worst, one| if one.cmp(&worst).is_gt() { one } else { worst })
}

/// What to type to see a run again.
fn replay(reports: &[SuiteReport], key: &str) -> String {
    let belongs = |report: &&SuiteReport| {
        report.trials.iter().flat_map(|trial| &trial.outcomes).any(|known| known.key == key)
    };
    reports.iter().find(belongs).map_or_else(String::new, |report| report.identity.replay_command(key))
}

/// A run as the page's script reads it.
pub fn run(recording: &Recording, reason: &str, command: &str, told: &RunTold) -> Value {
    let case = &recording.case;
    let road = &case.world.road;
    let signal = match road.crossing.kind {
        CrossingKind::Signalised(TrafficSignal {
            cycle,
            pedestrian_green_from,
            pedestrian_green,
            amber,
            clearance,
            stop_line: _,
        }) => json!([cycle, pedestrian_green_from, pedestrian_green, amber, clearance]),
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
        let mut user = json!({
            "name": recording.name(who),
            "kind": if who < case.world.vehicles.len() { "vehicle" } else { "pedestrian" },
            "length": length,
            "width": width,
            "round": round,
            "x": numbers(|place| place.x),
            "y": numbers(|place| place.y),
            "v": numbers(|place| place.speed),
            "h": numbers(|place| place.heading),
        });
        if let Some(look) = user_look(recording, who) {
            user["look"] = look.class("").trim().into();
        }
        let person = who.checked_sub(case.world.vehicles.len()).map(|index| &case.world.pedestrians[index]);
        if let Some(person) = person.filter(|person| !person.kind.is_pedestrian()) {
            user["rides"] = person.kind.word().into();
        }
        let modes = modes(recording, who);
        if !modes.is_empty() {
            user["modes"] = modes.into();
        }
        let pedestrian = who.checked_sub(case.world.vehicles.len());
        if let Some(state) = pedestrian.and_then(|pedestrian| minds::embedded(recording, pedestrian)) {
            user["state"] = state;
        }
        if case.world.vehicles.get(who).is_some_and(|car| car.sees.is_some()) {
            user["shown"] = sightings(recording, who).into();
        }
        if let Some(perceived) = perceived(recording, who) {
            user["perceived"] = perceived;
        }
        user
    });
    let events = recording
        .events
        .iter()
        .map(|event| json!([rounded(event.time), event.who, quoted(&describe(&event.what))]));
    let pairs = recording.pairs().into_iter().map(|pair| {
        let points: Vec<Value> =
            pair.points.iter().map(|(car, person)| json!([rounded(*car), rounded(*person)])).collect();
        json!({ "vehicle": pair.vehicle, "pedestrian": pair.pedestrian, "points": points })
    });
    let mark = |mark: &Mark| {
        json!([mark.kind.class(), mark.closed, mark.points.iter().map(|one| point(*one)).collect::<Vec<_>>()])
    };
    let lamp = road.crossing.width / 2.0 + 0.8;
    // A straight road is shown as wide as the page likes.
    let (from, to) = road
        .bend
        .as_ref()
        .map_or((-250.0, 250.0), |bend| (-bend.crossing - 100.0, bend.line.length() - bend.crossing + 100.0));
    let is_shown_about_its_crossing =
        road.bend.is_none() && road.other_crossings.is_empty() && case.world.other_roads.is_empty();
    let view = (!is_shown_about_its_crossing).then(|| {
        let cars = case.world.vehicles.len();
        let places = |users: &[Vec<Option<results::Place>>]| -> Vec<Vector2<f64>> {
            users.iter().flatten().flatten().map(|place| Vector2::new(place.x, place.y)).collect()
        };
        let near = view(&case.world, places(&recording.users[..cars]), places(&recording.users[cars..]));
        json!([rounded(near.low.x), rounded(near.low.y), rounded(near.high.x), rounded(near.high.y)])
    });
    let view = view.unwrap_or(Value::Null);
    json!({
        "key": case.key,
        "reason": reason,
        "command": command,
        "sentence": told.sentence,
        "moment": told.moment,
        "why": told.why.iter().map(|one| json!([one.class, one.text, one.time])).collect::<Vec<_>>(),
        "times": recording.times.iter().map(|time| rounded(*time)).collect::<Vec<_>>(),
        "road": {
            "width": road.lane_width,
            "lanes": (0..road.lanes.len()).map(|lane| road.path(lane).heading(0.0).x).collect::<Vec<_>>(),
            "near": road.kerb(Side::Near),
            "far": road.kerb(Side::Far),
            "zebra": road.crossing.kind == CrossingKind::Zebra,
            "signal": signal,
            "crossing": road.crossing.width,
            "marks": world_marks(&case.world, from, to).iter().map(mark).collect::<Vec<_>>(),
            "stop_lines": stop_lines(road).iter().map(|line| line.iter().map(|one| point(*one)).collect::<Vec<_>>()).collect::<Vec<_>>(),
            "lamp": point(beside(road, road.kerb(Side::Near) - 0.9, lamp, lamp)[0]),
            "view": view,
            "middle": point(beside(road, (road.kerb(Side::Near) + road.kerb(Side::Far)) / 2.0, 0.0, 0.0)[0]),
        },
        "users": users.collect::<Vec<_>>(),
        "events": events.collect::<Vec<_>>(),
        "pairs": pairs.collect::<Vec<_>>(),
    })
}

/// From when on (s) a road user is up to what, in its model's own words.
fn modes(recording: &Recording, who: usize) -> Vec<Value> {
    let of = recording.events.iter().filter(|event| event.who == recording.name(who));
    let modes = of.filter_map(|event| match &event.what {
        Happening::Mode(mode) => Some(json!([rounded(event.time), quoted(mode.as_str())])),
        _ => None,
    });
    modes.collect()
}

/// When (s) the controller of a vehicle that does not see everything begins to be shown another road user (by its index), or is not shown it any more.
fn sightings(recording: &Recording, who: usize) -> Vec<Value> {
    let name = recording.name(who);
    let index = |other: &str| (0..recording.users.len()).find(|index| recording.name(*index) == other);
    let changes = recording.events.iter().filter_map(|event| {
        let is_shown = match &event.what {
            Happening::ComesIntoSight { of } if of == name => true,
            Happening::IsLostFromSight { of } if of == name => false,
            _ => return None,
        };
        Some(json!([rounded(event.time), index(&event.who)?, is_shown]))
    });
    changes.collect()
}

fn point(point: Vector2<f64>) -> Value {
    json!([rounded(point.x), rounded(point.y)])
}

/// As it stands inside a `script` element.
pub fn script_text(value: Value) -> String {
    // `<` would let a name end the element.
    plain(value).to_string().replace('<', "\\u003c")
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

/// What the controller of a vehicle was told, as the page's script reads it: time, age or `null`, and of each of the others who it is, x, y, how far
/// off, and the speed; `None` where all was so.
fn perceived(recording: &Recording, vehicle: usize) -> Option<Value> {
    let views = recording.perceived.iter().filter(|view| view.vehicle == vehicle);
    let other = |other: &PerceivedOther| {
        let numbers = [other.position.x, other.position.y, other.off, other.speed].map(rounded);
        Value::Array([json!(other.who)].into_iter().chain(numbers).collect())
    };
    let view = |view: &PerceivedView| {
        let others = view.others.iter().filter(|one| one.who < recording.users.len());
        let age = view.age.map_or(Value::Null, rounded);
        json!([rounded(view.time), age, others.map(other).collect::<Vec<_>>()])
    };
    let views: Vec<Value> = views.map(view).collect();
    (!views.is_empty()).then(|| views.into())
}

/// To the centimetre (or centimetre per second, or hundredth of a radian): drawing needs no more.
pub(super) fn rounded(value: f64) -> Value {
    let hundredths = (value * 100.0).round();
    if hundredths % 100.0 == 0.0 { json!((hundredths / 100.0) as i64) } else { json!(hundredths / 100.0) }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use scenario::geometry::{Piece, Pose, ReferenceLine};
    use scenario::{Bend, Case, Position};
    use sim::{Mode, PerceivedOther, PerceivedView, Sample, TimelineEvent, Trace};

    /// A car that drives round a turn at 5 m/s, from 25 m before a crossing in its middle, and somebody who crosses it at 1 m/s.
    fn recorded() -> Recording {
        let [one, arc, other] = Piece::turn(1500.0, 9.0, 0.36, 0.85);
        let crossing = 30.0 + one.length + arc.length / 2.0;
        let pieces = [Piece::line(30.0), one, arc, other, Piece::line(40.0)];
        let line = ReferenceLine::new(Pose::origin(), &pieces).unwrap();
        let pose = line.pose(crossing);
        let mut world = sim::fixture::world();
        let person = &mut world.pedestrians[0];
        for place in [&mut person.start, &mut person.goal] {
            let at = pose.point + pose.normal() * place.y;
            *place = Position { x: at.x, y: at.y };
        }
        world.road.bend = Some(Bend { line: Arc::new(line), crossing });
        let path = world.road.path(0);
        let mut trace = Trace::default();
        for step in 0..=320 {
            let time = f64::from(step) * 0.025;
            let place = -25.0 + 5.0 * time;
            let (position, heading) = path.pose(place);
            let of = |who, position, heading: Vector2<f64>, travelled, speed: f64| Sample {
                time,
                who,
                position,
                heading,
                travelled,
                velocity: heading * speed,
                acceleration: 0.0,
                mode: Mode::NONE,
            };
            trace.samples.push(of(0, position, heading, Some(place), 5.0));
            let walked = pose.point + pose.normal() * (time - 4.0);
            trace.samples.push(of(1, walked, pose.normal(), None, 1.0));
        }
        let case = Case {
            key: "streets/turn/rep=1".into(),
            scenario: "turn".into(),
            variation: Vec::new(),
            individuals: Vec::new(),
            drawn: Vec::new(),
            impossible: None,
            repetition: 1,
            seed: 1,
            world: Arc::new(world),
        };
        Recording::new(&case, &trace, Vec::new())
    }

    /// The same, of which the car's controller is told that somebody is elsewhere, from 2 s to 3 s.
    fn perceiving() -> Recording {
        let position = Vector2::new(1.5, -2.25);
        let other = PerceivedOther { who: 1, position, off: 0.36, speed: 1.2 };
        let view = |time, age, others| PerceivedView { vehicle: 0, time, age, others };
        let perceived = vec![view(2.0, Some(0.3), vec![other]), view(3.0, None, Vec::new())];
        Recording { perceived, ..recorded() }
    }

    fn shown(recording: &Recording) -> Value {
        run(recording, "example", "", &RunTold::new(&[], &Requests::default(), recording))
    }

    #[test]
    fn a_run_on_a_bend_is_shown_along_it() {
        let recording = recorded();
        let shown = shown(&recording);
        let view: Vec<f64> =
            shown["road"]["view"].as_array().unwrap().iter().map(|one| one.as_f64().unwrap()).collect();
        let number = |value: &Value| value.as_f64().unwrap();
        // The crossing is in the picture, in its middle or not, and so is everybody who is near it.
        let middle: Vec<f64> = shown["road"]["middle"].as_array().unwrap().iter().map(number).collect();
        assert!(view[0] < middle[0] && middle[0] < view[2] && view[1] < middle[1] && middle[1] < view[3]);
        for who in [0, 1] {
            for (x, y) in shown["users"][who]["x"]
                .as_array()
                .unwrap()
                .iter()
                .zip(shown["users"][who]["y"].as_array().unwrap())
            {
                assert!(
                    (view[0]..=view[2]).contains(&number(x)) && (view[1]..=view[3]).contains(&number(y)),
                    "{x} {y}"
                );
            }
        }
        // It turns by 90° in the end, and its kerbs are lines of many chords.
        let headings: Vec<f64> = shown["users"][0]["h"].as_array().unwrap().iter().map(number).collect();
        assert!(headings[0] == 0.0 && (headings[headings.len() - 1] - 1.57).abs() < 0.011, "{headings:?}");
        assert!(headings.windows(2).all(|pair| pair[0] <= pair[1]));
        let marks = shown["road"]["marks"].as_array().unwrap();
        let kerbs = marks.iter().filter(|mark| mark[0] == "kerb");
        assert!(
            kerbs.clone().count() == 2 && kerbs.clone().all(|kerb| kerb[2].as_array().unwrap().len() > 10)
        );
        // Distances are along the lane and along the way: the car is at the crossing after 5 s, the person after 4 s.
        let points = shown["pairs"][0]["points"].as_array().unwrap();
        assert!((number(&points[0][0]) + 25.0).abs() < 0.01 && (number(&points[0][1]) + 4.0).abs() < 0.01);
        let at = |time: usize| &points[time * 10];
        assert!(number(&at(5)[0]).abs() < 0.011 && number(&at(4)[1]).abs() < 0.011, "{} {}", at(5), at(4));
    }

    #[test]
    fn what_somebody_is_up_to_and_what_a_vehicle_is_shown_go_along() {
        let mut recording = recorded();
        let event = |time: f64, who: usize, what: Happening| TimelineEvent {
            time,
            who: recorded().name(who).to_string(),
            what,
        };
        let car = recording.name(0).to_string();
        recording.events = vec![
            event(0.5, 1, Happening::ComesIntoSight { of: "somebody else".into() }),
            event(1.0, 0, Happening::Mode(Mode::new("brakes"))),
            event(1.5, 1, Happening::ComesIntoSight { of: car.clone() }),
            event(2.0, 1, Happening::Mode(Mode::new("walking"))),
            event(2.5, 1, Happening::IsLostFromSight { of: car }),
        ];
        let drawn = shown(&recording);
        assert_eq!(drawn["users"][0]["modes"], json!([[1, "brakes"]]));
        assert_eq!(drawn["users"][1]["modes"], json!([[2, "walking"]]));
        // Of who sees everything nothing has to be said.
        assert_eq!(drawn["users"][0]["shown"], Value::Null);
        assert_eq!(sightings(&recording, 0), [json!([1.5, 1, true]), json!([2.5, 1, false])]);
    }

    #[test]
    fn what_a_controller_is_told_that_is_not_so_goes_along() {
        let recording = perceiving();
        let drawn = shown(&recording);
        assert_eq!(
            drawn["users"][0]["perceived"],
            json!([[2, 0.3, [[1, 1.5, -2.25, 0.36, 1.2]]], [3, null, []]])
        );
        assert_eq!(drawn["users"][1]["perceived"], Value::Null);
        assert_eq!(shown(&recorded())["users"][0]["perceived"], Value::Null);
        // Without the script it is drawn and told while it holds, and named as what it is.
        for (time, count) in [(1.9, 0), (2.0, 1), (2.9, 1), (3.0, 0)] {
            let still = still(&recording, time);
            assert_eq!(still.content.matches("class=\"ghost pedestrian").count(), count, "{time}");
            assert_eq!(still.perceived.len(), count, "{time}");
        }
        let still = still(&recording, 2.5);
        let (car, person) = (recording.name(0), recording.name(1));
        assert!(still.content.contains(&format!("<title>{person} as perceived by {car}</title>")));
        let words =
            format!("{car} perceives {person} 0.36 m from where they are, moving at 1.2 m/s, 0.3 s late");
        assert_eq!(still.perceived, [words]);
    }

    #[test]
    fn what_is_read_back_is_drawn_the_same() {
        let recording = perceiving();
        let text = serde_json::to_string(&recording).unwrap();
        let back: Recording = serde_json::from_str(&text).unwrap();
        assert_eq!(shown(&back), shown(&recording));
        if let Some(path) = option_env!("LOOK_AT") {
            std::fs::write(path, shown(&recording).to_string()).unwrap();
        }
    }
}
