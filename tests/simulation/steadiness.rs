//! What rounding must not decide: with noise of a nanometre, in a bend of 10 km, mirrored and moved along, a run has the same events, each
//! within a step of the simulation, though speeds and places are whole numbers, at which controllers meet their thresholds exactly.

use std::collections::BTreeMap;

use proptest::prelude::*;
use runner::run::road_users;
use sim::{Happening, Timeline, TimelineEvent, simulate};

use crate::support::text::planned;

/// Controllers that draw nothing; not `carla_behavior`, whose comparisons are those of its published source.
const DETERMINISTIC: [&str; 6] =
    ["autoware", "careful_human", "idm_aeb", "idm_aes", "yielding", "yielding { requires_priority: false }"];

/// A street: the course and lanes of its road, and the sides of the car and of the pedestrian.
#[derive(Clone, Copy)]
struct Street {
    path: &'static str,
    at: &'static str,
    lanes: (&'static str, usize),
    near: &'static str,
    noise: &'static str,
}

const PLAIN: Street =
    Street { path: "", at: "", lanes: ("forward, backward", 0), near: "from near side", noise: "0 m" };

/// The same in other ways.
const SAME: [(&str, Street); 5] = [
    ("with noise", Street { noise: "1e-9 m", ..PLAIN }),
    ("mirrored", Street { lanes: ("backward, forward", 1), near: "from far side", ..PLAIN }),
    ("moved along", Street { path: "path { straight 700 m }", at: "{ at: 300.7 m }", ..PLAIN }),
    (
        "in a bend to the left",
        Street { path: "path { arc 4 deg radius 10 km left }", at: "{ at: 300 m }", ..PLAIN },
    ),
    (
        "in a bend to the right",
        Street { path: "path { arc 4 deg radius 10 km right }", at: "{ at: 300 m }", ..PLAIN },
    ),
];

/// Whole numbers: km/h, m, m, 0.1 m/s, s.
#[derive(Debug, Clone, Copy)]
struct Meeting {
    speed: u32,
    start: u32,
    from_kerb: u32,
    along: i32,
    pace: u32,
    appears: u32,
}

fn events(controller: &str, street: &Street, meeting: &Meeting) -> Vec<TimelineEvent> {
    let Street { path, at, lanes: (lanes, lane), near, noise } = street;
    let Meeting { speed, start, from_kerb, along, pace, appears } = meeting;
    let text = format!(
        "scenario a {{
  road {{ {path}; lanes {lanes}; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra {at} }}
  horizon 40 s; finish 60 m
  vehicle av {{ controller {controller}; speed {speed} km/h; lane {lane}; start {start} m before crossing; sees {{ occlusion: false, position_noise: {noise} }} }}
  pedestrian p {{ model scripted {{ speed: {} m/s }}; {near}; start {from_kerb} m from kerb; along {along} m; appears at {appears} s }}
}}",
        f64::from(*pace) / 10.0
    )
    .replace("{ ;", "{");
    let case = planned(&text).unwrap_or_else(|error| panic!("{text}\n{error}"));
    let mut timeline = Timeline::new(&case.world);
    simulate(&case.world, road_users(&case.world, case.seed).unwrap(), &mut timeline).unwrap();
    timeline.into_events()
}

/// Of the simulation, s.
const STEP: f64 = 0.025;

/// The times of every kind of event of every road user, s.
fn moments(events: &[TimelineEvent]) -> BTreeMap<String, Vec<f64>> {
    let mut found: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for event in events {
        // Of an event that has numbers the first word.
        let what = format!("{:?}", event.what);
        let what = what.split(" {").next().unwrap_or_default();
        found.entry(format!("{} {what}", event.who)).or_default().push(event.time);
    }
    found
}

/// What of two runs is not the same within a step.
fn difference(one: &[TimelineEvent], other: &[TimelineEvent]) -> Option<String> {
    let (one, other) = (moments(one), moments(other));
    let kinds: Vec<_> = one.keys().chain(other.keys()).collect();
    kinds.into_iter().find_map(|kind| {
        let (a, b) = (one.get(kind), other.get(kind));
        let within = |(a, b): (&f64, &f64)| (a - b).abs() <= STEP + 1e-6;
        let same = a.zip(b).is_some_and(|(a, b)| a.len() == b.len() && a.iter().zip(b).all(within));
        (!same).then(|| format!("{kind}: {a:?} and {b:?}"))
    })
}

fn meeting() -> impl Strategy<Value = Meeting> {
    let numbers = (20_u32..=60, 40_u32..=90, 1_u32..=3, -2_i32..=2, 8_u32..=20, 0_u32..=6);
    numbers.prop_map(|(speed, start, from_kerb, along, pace, appears)| Meeting {
        speed,
        start,
        from_kerb,
        along,
        pace,
        appears,
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn rounding_decides_nothing(controller in prop::sample::select(DETERMINISTIC.to_vec()), meeting in meeting()) {
        let plain = events(controller, &PLAIN, &meeting);
        for (what, street) in &SAME {
            let other = events(controller, street, &meeting);
            let swerves = plain.iter().any(|event| matches!(event.what, Happening::Swerves { .. }));
            // A vehicle that steers back into its lane does so otherwise where the lane bends.
            if swerves && what.contains("bend") {
                continue;
            }
            prop_assert_eq!(difference(&plain, &other), None, "{} {}", controller, what);
        }
    }
}

/// At 36 km/h a quarter of a metre is driven in a step, so that the time to collision is a second exactly.
#[test]
fn a_trigger_that_is_met_exactly_is_met_with_noise_as_well() {
    for from_kerb in 1..=3 {
        for start in 40..=60 {
            let meeting = Meeting { speed: 36, start, from_kerb, along: 0, pace: 10, appears: 2 };
            let [plain, noisy] = [PLAIN, SAME[0].1].map(|street| events("idm_aeb", &street, &meeting));
            let brakes = |events: &[TimelineEvent]| moments(events).get("av Brakes").cloned();
            assert_eq!(brakes(&plain), brakes(&noisy), "{meeting:?}");
        }
    }
}
