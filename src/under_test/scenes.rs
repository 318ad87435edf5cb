//! Ten scenes that any controller has to get along with, whatever it answers: what `try` shows to a program.

use serde_json::{Value as Json, json};

use super::conversation::{AskedDecision, Conversation};
use scenario::{STOP_LINE, SeenSignal, Shape, SignalState};
use sim::{CrossingView, EgoState, Observation, RoadView, SeenPedestrian, SeenVehicle};

/// Decisions of a scene.
const TURNS: usize = 40;

/// m/s
const LIMIT: f64 = 30.0 / 3.6;

/// A body that moves evenly: place relative to the crossing (m) and velocity (m/s), along the lane and to its left.
type Body = [f64; 4];

/// A scene in which everything moves evenly.
struct Sketch {
    name: &'static str,
    /// Of the vehicle before the crossing at the beginning, m.
    distance: f64,
    /// Of the vehicle, m/s.
    speed: f64,
    people: Vec<Body>,
    /// Turns before anybody is there.
    later: usize,
    vehicles: Vec<Body>,
    is_signalised: bool,
    /// Of the road, per metre.
    gradient: Option<f64>,
    /// Places behind the crossing (m) at which the lane's curvature (1/m) changes.
    bends: Vec<(f64, f64)>,
    /// Time in free flow before, s.
    settles: f64,
}

fn sketch(name: &'static str, people: &[Body]) -> Sketch {
    Sketch {
        name,
        distance: 35.0,
        speed: 8.0,
        people: people.to_vec(),
        later: 0,
        vehicles: Vec::new(),
        is_signalised: false,
        gradient: None,
        bends: Vec::new(),
        settles: 0.0,
    }
}

fn sketches() -> [Sketch; 10] {
    let many: Vec<Body> =
        (0..10).map(|one| [0.3 * f64::from(one) - 1.5, -3.0 - 0.4 * f64::from(one), 0.0, 1.2]).collect();
    [
        sketch("nobody is there", &[]),
        sketch("somebody waits at the kerb", &[[0.0, -2.3, 0.0, 0.0]]),
        sketch("somebody crosses from the right", &[[0.5, -3.5, 0.0, 1.4]]),
        sketch("somebody crosses from the left", &[[-0.5, 7.0, 0.1, -1.4]]),
        sketch("ten people cross", &many),
        Sketch {
            distance: 25.0,
            later: 12,
            ..sketch("somebody steps out close ahead", &[[0.0, -1.5, 0.0, 2.0]])
        },
        Sketch { distance: 4.0, speed: 0.0, ..sketch("it stands before somebody", &[[0.0, 0.2, 0.0, 0.0]]) },
        Sketch {
            vehicles: vec![[60.0, 4.0, -8.0, 0.0]],
            gradient: Some(0.05),
            bends: vec![(10.0, 0.0), (30.0, 0.02), (60.0, 0.02), (60.0, 0.0)],
            ..sketch("another vehicle comes towards it", &[])
        },
        Sketch {
            is_signalised: true,
            ..sketch("the signal is red and turns green", &[[0.0, -2.5, 0.0, 0.0]])
        },
        Sketch {
            distance: -6.0,
            settles: 1.0,
            ..sketch("the crossing lies behind it", &[[0.0, 1.0, 0.0, 1.4]])
        },
    ]
}

/// The scenes, with these settings of the controller, a decision each `period` (s).
pub fn scenes(controller: &str, settings: &Json, period: f64, step: f64) -> Vec<Conversation> {
    let conversation = |sketch: &Sketch| Conversation {
        name: sketch.name.to_string(),
        controller: controller.to_string(),
        open: opening(sketch, settings, step),
        turns: (0..TURNS).map(|turn| sketch.turn(turn, period)).collect(),
        refused: None,
    };
    sketches().iter().map(conversation).collect()
}

fn opening(sketch: &Sketch, settings: &Json, step: f64) -> Json {
    let kind = if sketch.is_signalised { "signalised" } else { "zebra" };
    json!({
        // Of nothing but the scene, so that who draws numbers draws the same again.
        "seed": 6_120_398_128_u64 + sketch.name.len() as u64,
        "step": step,
        "parameters": settings,
        "cruise_speed": LIMIT,
        "vehicle": {"length": 4.5, "width": 1.8},
        "road": {
            "lane_width": 4.0,
            "speed_limit": LIMIT,
            "lanes": [{"y": 0.0, "direction": 1}, {"y": 4.0, "direction": -1}],
            "crossing": {"kind": kind, "width": 4.0, "x": 0.0},
            "kerbs": {"right": -2.0, "left": 6.0},
            "boxes": [{"x": -12.0, "y": -3.2, "length": 5.0, "width": 2.0}],
        },
    })
}

impl Sketch {
    fn turn(&self, turn: usize, period: f64) -> AskedDecision {
        let elapsed = turn as f64 * period;
        let distance = self.distance - self.speed * elapsed;
        let place = |body: &Body| [distance + body[0] + body[2] * elapsed, body[1] + body[3] * elapsed];
        let person = |(id, body): (usize, &Body)| SeenPedestrian {
            kind: Default::default(),
            id,
            position: place(body).into(),
            velocity: [body[2], body[3]].into(),
            acceleration: [0.0, 0.0].into(),
            shape: Shape::Disc { radius: 0.25 },
        };
        let vehicle = |(id, body): (usize, &Body)| SeenVehicle {
            id,
            position: place(body).into(),
            velocity: [body[2], body[3]].into(),
            length: 4.5,
            width: 1.8,
        };
        let is_green = 2 * turn >= TURNS;
        let is_there = turn >= self.later;
        let seen = Observation {
            time: elapsed - self.settles,
            ego: EgoState {
                distance_to_crossing: distance,
                speed: self.speed,
                acceleration: 0.0,
                length: 4.5,
                width: 1.8,
                travelled: -distance,
                curvature: 0.0,
                lateral_offset: 0.0,
                heading_error: 0.0,
            },
            cruise_speed: LIMIT,
            road: RoadView {
                lane_width: 4.0,
                speed_limit: LIMIT,
                crossing_width: 4.0,
                pedestrian_priority: !self.is_signalised || !is_green,
                signal: self.is_signalised.then_some(SeenSignal {
                    state: if is_green { SignalState::Green } else { SignalState::Red },
                    stop_line: STOP_LINE,
                }),
                right_kerb: -2.0,
                left_kerb: 6.0,
                gradient: self.gradient,
                curvature_ahead: self.bends.iter().map(|(place, bend)| (place + distance, *bend)).collect(),
                crossings: vec![CrossingView {
                    distance,
                    width: 4.0,
                    pedestrian_priority: !self.is_signalised || !is_green,
                    right_edge: -2.0,
                    left_edge: 6.0,
                }],
            },
            pedestrians: self.people.iter().enumerate().filter(|_| is_there).map(person).collect(),
            vehicles: self.vehicles.iter().enumerate().map(vehicle).collect(),
        };
        AskedDecision { seen, is_new: turn == 0, signal: self.is_signalised.then_some(is_green), said: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::{self, DueDecision, MoreTables};
    use scenario::RoadUserKind;
    use std::collections::BTreeSet;

    #[test]
    fn there_are_ten_and_each_is_another() {
        let scenes = scenes("own", &json!({}), 0.1, 0.025);
        let shown: BTreeSet<String> = scenes.iter().map(|one| format!("{:?}", one.turns[20].seen)).collect();
        let names: BTreeSet<&str> = scenes.iter().map(|one| one.name.as_str()).collect();
        assert_eq!((scenes.len(), shown.len(), names.len()), (10, 10, 10));
        let near = scenes.iter().filter(|one| {
            one.turns.iter().any(|turn| {
                turn.seen
                    .pedestrians
                    .iter()
                    .any(|who| (0.0..15.0).contains(&who.position.x) && who.position.y.abs() < 2.0)
            })
        });
        assert!(near.count() >= 4, "somebody is in the way in some of them");
        assert!(
            scenes.iter().any(|one| one.turns[0].seen.time < 0.0)
                && scenes.iter().any(|one| one.turns[0].signal.is_some())
        );
    }

    #[test]
    fn scenes_are_read_as_they_are_written() {
        for scene in scenes("own", &json!({}), 0.1, 0.025) {
            for turn in 0..scene.turns.len() {
                let due = scene.due(turn, 3, 0.1);
                let written = wire::scene(&due);
                let (seen, is_new, signal) = wire::read_scene(&written).unwrap();
                let read = DueDecision { slot: 3, is_new, seen: &seen, period: 0.1, signal };
                assert_eq!(wire::scene(&read), written);
                let (mut rows, mut again) = (Vec::new(), Vec::new());
                wire::step_frame(&[due], MoreTables::ALL, &mut rows);
                wire::step_frame(&[read], MoreTables::ALL, &mut again);
                assert_eq!(rows, again);
            }
        }
        assert!(wire::read_scene(&json!({"time": 1.0})).is_none());
    }

    /// Those who have never heard of a table are not sent it, so that their frames are as long as they know.
    #[test]
    fn how_lanes_bend_is_told_to_those_who_read_it() {
        let scenes = scenes("own", &json!({}), 0.1, 0.025);
        let bends = scenes.iter().find(|one| !one.turns[0].seen.road.curvature_ahead.is_empty()).unwrap();
        let (mut rows, mut fewer) = (Vec::new(), Vec::new());
        let due = bends.due(0, 0, 0.1);
        wire::step_frame(&[due, due], MoreTables::named(&["lanes".into()]), &mut rows);
        wire::step_frame(&[due, due], MoreTables::default(), &mut fewer);
        assert_eq!((rows[20], fewer[20]), (8, 0));
        let (lanes, changes) = (2 * wire::LANES.len(), 8 * wire::CURVATURE_AHEAD.len());
        assert_eq!(rows.len(), fewer.len() + 8 * (lanes + changes));
        // Who does not ask finds rows as long as ever, those of the first run at the beginning of both.
        assert_eq!(rows[32..32 + 8 * wire::RUNS.len()], fewer[32..32 + 8 * wire::RUNS.len()]);
        assert_eq!(rows[32 + 8 * wire::RUNS.len()..][..8], (-35.0f64).to_le_bytes());
        let written = wire::scene(&due);
        assert_eq!(written["road"]["curvature_ahead"][1], json!([65.0, 0.02]));
        assert_eq!(
            (written["road"]["gradient"].as_f64(), written["ego"]["travelled"].as_f64()),
            (Some(0.05), Some(-35.0))
        );
        // Of what is nothing JSON is silent, and what older records do not say is worked out.
        let plain = scenes[0].due(3, 0, 0.1);
        let mut written = wire::scene(&plain);
        assert!(
            written["road"].get("curvature_ahead").is_none() && written["road"].get("gradient").is_none()
        );
        assert!(written["ego"].get("curvature").is_none());
        written["ego"].as_object_mut().unwrap().remove("travelled");
        assert_eq!(&wire::read_scene(&written).unwrap().0, plain.seen);
    }

    /// The same of who rides and of crossings, of which a frame has all and JSON those that its other fields do not tell.
    #[test]
    fn who_rides_and_every_crossing_is_told_to_those_who_read_it() {
        let asked = |named: &[&str], seen: &Observation| {
            let named: Vec<String> = named.iter().map(ToString::to_string).collect();
            let due = DueDecision { slot: 3, is_new: false, seen, period: 0.1, signal: None };
            let mut rows = Vec::new();
            wire::step_frame(&[due], MoreTables::named(&named), &mut rows);
            let at = |place: usize| f64::from_le_bytes(rows[place..place + 8].try_into().unwrap());
            (
                rows.len(),
                rows[24],
                (36..rows.len()).step_by(8).map(|place| at(place - 4)).collect::<Vec<f64>>(),
            )
        };
        let turns = scenes("own", &json!({}), 0.1, 0.025).into_iter().flat_map(|scene| scene.turns);
        let mut seen = turns.map(|turn| turn.seen).find(|seen| !seen.pedestrians.is_empty()).unwrap();
        seen.vehicles.clear();
        seen.road.crossings = [(-4.5, true), (20.0, false)]
            .map(|(distance, pedestrian_priority)| CrossingView {
                distance,
                width: 3.0,
                pedestrian_priority,
                right_edge: -2.0,
                left_edge: 1.5,
            })
            .to_vec();
        let (plain, _, rows) = asked(&["later"], &seen);
        assert_eq!((plain, rows.len()), (32 + 8 * rows.len(), 16 + 10 * seen.pedestrians.len()));
        for (kind, number) in RoadUserKind::ALL.into_iter().zip([1.0, 2.0, 3.0]) {
            seen.pedestrians[0].kind = kind;
            let (length, crossings, told) = asked(&["kinds"], &seen);
            assert_eq!((length, crossings), (plain + 8 * seen.pedestrians.len(), 0));
            assert_eq!(told[16 + 10], number, "{kind:?}");
        }
        let (length, crossings, told) = asked(&["crossings"], &seen);
        assert_eq!((length, crossings), (plain + 2 * 8 * 6, 2));
        assert_eq!(told[rows.len()..][..6], [0.0, -4.5, 3.0, 1.0, -2.0, 1.5]);
        assert_eq!(told[rows.len() + 6..], [0.0, 20.0, 3.0, 0.0, -2.0, 1.5]);
    }

    /// Nobody who walks says so, so that programs of before see what they saw.
    #[test]
    fn who_rides_says_so_and_nobody_else_does() {
        for kind in RoadUserKind::ALL {
            let turns = scenes("own", &json!({}), 0.1, 0.025).into_iter().flat_map(|scene| scene.turns);
            let mut asked = turns.into_iter().find(|turn| !turn.seen.pedestrians.is_empty()).unwrap();
            asked.seen.pedestrians[0].kind = kind;
            let AskedDecision { seen, is_new, signal, .. } = &asked;
            let written =
                wire::scene(&DueDecision { slot: 3, is_new: *is_new, seen, period: 0.1, signal: *signal });
            let said = written["pedestrians"][0].get("kind").and_then(Json::as_str);
            assert_eq!(said, (kind != RoadUserKind::Pedestrian).then(|| kind.word()));
            assert_eq!(wire::read_scene(&written).unwrap().0.pedestrians[0].kind, kind);
            let mut wrong = written;
            wrong["pedestrians"][0]["kind"] = json!("horse");
            assert!(wire::read_scene(&wrong).is_none());
        }
    }
}
