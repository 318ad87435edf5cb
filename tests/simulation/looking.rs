//! Pedestrians that are there before they may go: they stand and look, and what they have seen counts.

use proptest::prelude::*;
use runner::run::{RunError, road_users};
use sim::{Fault, Observer, Step, simulate};

use crate::support::text::{case, measured, of, planned};

/// A car at 50 km/h that is `lead` s away at the start, and a pedestrian.
fn street(lead: f64, walker: &str) -> String {
    format!(
        "scenario a {{
  road {{ lanes forward; lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked }}
  vehicle av {{ controller constant_speed; speed 50 km/h; start {lead} s before crossing }}
  pedestrian walker {{ start 2 m from kerb; {walker} }}
  horizon 20 s
}}"
    )
}

/// How far the pedestrian has come after each step, and what it was up to.
#[derive(Default)]
struct Way {
    places: Vec<f64>,
    modes: Vec<String>,
    /// In how many steps it weighed anything.
    thoughts: usize,
}

impl Observer for Way {
    fn observe(&mut self, step: &Step) {
        self.places.push(step.after.pedestrians[0].position.y);
        self.modes.push(step.pedestrian_modes[0].as_str().to_string());
        let looks = !step.may_go(0);
        self.thoughts += usize::from(looks && step.minds.state(0).is_some());
    }
}

fn way(text: &str) -> Result<Way, Fault> {
    let case = case(text);
    let (world, mut way) = (case.world.clone(), Way::default());
    simulate(&world, road_users(&world, case.seed).unwrap(), &mut way).map(|_| way)
}

/// When the pedestrian had moved for the first time, s.
fn sets_off(way: &Way) -> Option<f64> {
    let first = way.places.iter().position(|place| *place != way.places[0])?;
    Some(first as f64 * 0.025)
}

/// Models that react.
const REACTING: [&str; 4] = ["commotions", "carla_walker", "social_force", "jaywalker"];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn a_pedestrian_stands_while_it_looks_and_a_look_of_0_s_changes_nothing(
        model in prop::sample::select(&REACTING[..]),
        steps in 1u32..120,
        lead in 3.0..9.0f64,
    ) {
        let look = f64::from(steps) * 0.025;
        let text = street(lead, &format!("model {model}; looks for {look} s"));
        let way = way(&text).unwrap();
        let looking = way.modes.iter().take_while(|mode| *mode == "looking").count();
        prop_assert_eq!(looking, steps as usize);
        prop_assert!(way.places[..looking].iter().all(|place| *place == way.places[0]));
        prop_assert!(way.modes[looking..].iter().all(|mode| mode != "looking"));
        let initiation = of(&text, "crossing_initiation_time");
        let off = way.places.iter().position(|place| *place != way.places[0]).map(|step| step as f64 * 0.025);
        if let (Some(initiation), Some(off)) = (initiation, off) {
            prop_assert!((initiation - (off - look)).abs() < 0.06, "{} s, off at {} s after {} s", initiation, off, look);
        }
        let without = measured(&street(lead, &format!("model {model}")));
        let none = measured(&street(lead, &format!("model {model}; looks for 0 s")));
        prop_assert_eq!(without, none);
    }
}

/// Of the people of `humans` that may go when a car is 2 s away, 2.3 m from the lane's centre, far fewer are hit after a look of 3 s.
#[test]
fn what_was_seen_counts() {
    let hits = |look: f64| {
        let hit = |person: u32| {
            let text = format!(
                "scenario a {{
  road {{ lanes forward; lane_width 3.5 m; speed_limit 30 km/h; crossing unmarked }}
  vehicle av {{ controller constant_speed; speed 30 km/h; start {} s before crossing }}
  pedestrian walker {{ model commotions; individual {} of humans; start 2.3 m from lane centre; looks for {look} s }}
  horizon 15 s
}}",
                2.0 + look,
                1 + 41 * person
            );
            of(&text, "collision") == Some(1.0)
        };
        (0..240).filter(|person| hit(*person)).count()
    };
    let (at_first_sight, looked) = (hits(0.0), hits(3.0));
    assert!(at_first_sight >= 12 && looked * 4 <= at_first_sight, "{at_first_sight} and {looked} of 240");
}

/// The published inhibition leaks away only slowly; a look ends at once.
#[test]
fn a_look_is_not_an_inhibited_entry() {
    // Just outside of where waiting ends: farther away entering is not what a step off leads to.
    let near = |walker: &str| street(20.0, walker).replace("2 m from kerb", "2.2 m from lane centre");
    let off = |walker: &str| sets_off(&way(&near(walker)).unwrap()).unwrap();
    let looked = off("model commotions; looks for 2 s");
    let inhibited = off("model commotions { entry_inhibited_until: 2 s }");
    assert!((2.0..2.5).contains(&looked), "{looked} s");
    assert!(inhibited > looked + 0.2, "{inhibited} s");
}

#[test]
fn the_earlier_of_arrival_and_time_lets_them_go() {
    let off = |lead: f64, may_go: &str| {
        let model = "model scripted { speed: 1 m/s }";
        sets_off(&way(&street(lead, &format!("{model}; may go when {may_go}"))).unwrap()).unwrap()
    };
    // The car is 5 s away after 3 s.
    assert_eq!(off(8.0, "time_to_arrival(av) = 5 s, or after 10 s"), 3.0);
    assert_eq!(off(8.0, "time_to_arrival(av) = 5 s, or after 2 s"), 2.0);
    // One that drives away never arrives.
    let away =
        street(8.0, "model scripted; appears at 10 s; may go when time_to_arrival(av) = 0 s, or after 3 s");
    let fault = way(&away).map(|_| ()).unwrap_err();
    assert!(matches!(fault, Fault::PastArrival(past) if past.to_go), "{fault}");
}

/// A car that stops for a pedestrian never arrives, and a run that ends before the pedestrian might go shows nothing.
#[test]
fn a_run_that_ends_during_a_look_is_an_error() {
    let text = |or_after: f64| {
        format!(
            "scenario a {{
  road {{ lanes forward; lane_width 3.5 m; speed_limit 30 km/h; crossing zebra }}
  vehicle av {{ controller constant_deceleration {{ time: 3 s, deceleration: 5 m/s^2 }}; speed 30 km/h; start 60 m before crossing }}
  pedestrian walker {{ model commotions; start 2 m from kerb; appears at 1 s
    may go when time_to_arrival(av) = 1 s, or after {or_after} s }}
  horizon 12 s
}}"
        )
    };
    assert!(
        way(&text(6.0)).is_ok_and(|way| sets_off(&way).is_some_and(|moment| (7.0..8.0).contains(&moment)))
    );
    let planned = planned(&text(11.5)).unwrap_err();
    assert!(planned.contains("may go at 12.5 s at the latest, and the run is over at 12 s"), "{planned}");
    // Where it appears later than is known beforehand the run itself says so.
    let late = text(11.0)
        .replace("appears at 1 s", "appears when time_to_arrival(av) = 6 s")
        .replace("time_to_arrival(av) = 1 s, or after 11 s", "time_to_arrival(av) = 0.5 s, or after 11.9 s");
    let case = case(&late);
    let fault =
        simulate(&case.world, road_users(&case.world, case.seed).unwrap(), &mut Way::default()).unwrap_err();
    assert!(matches!(fault, Fault::NeverMayGo { pedestrian: 0, .. }), "{fault}");
    let error = RunError::of_fault(&case.world, fault, false);
    assert!(error.is_no_encounter() && error.had_begun());
}

/// Nothing is perceived of a vehicle that a box hides during the look, and all of it without the box.
#[test]
fn behind_a_box_a_look_sees_nothing() {
    let text = |wall: &str| {
        format!(
            "scenario a {{
  road {{ lanes forward; lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked; {wall} }}
  vehicle av {{ controller constant_speed; speed 50 km/h; start 6 s before crossing }}
  pedestrian walker {{ model commotions; start 2.6 m from lane centre; looks for 1 s }}
  horizon 15 s
}}"
        )
    };
    let hidden = way(&text("box wall { along: -3 m, across: -2.6 m, length: 4 m, width: 1.6 m }")).unwrap();
    assert_eq!((hidden.thoughts, way(&text("")).unwrap().thoughts), (0, 40));
}

/// A car that passes during the look was never met by a pedestrian that could have gone.
#[test]
fn what_passes_during_a_look_puts_nothing_to_the_test() {
    let presence = |look: &str| {
        let case = case(&street(3.0, &format!("model social_force; {look}")));
        let requests = results::Requests::defaults(&models::standard());
        let (flows, watched) = (runner::run::FreeFlows::default(), &mut runner::run::Unwatched);
        let outcome = runner::run::run_case(&case, &requests, &flows, watched).unwrap();
        outcome.presence("av", "walker").unwrap()
    };
    use sim::measure::Closeness;
    assert!(presence("").closest >= Closeness::Abreast);
    let looked = presence("looks for 8 s");
    assert!(looked.closest == Closeness::Apart && !looked.passed, "{looked:?}");
}

/// A pedestrian that is postponed may go at once if its moment is past by then: that is a run of its own, and no error.
#[test]
fn a_postponed_pedestrian_may_go_at_once() {
    let text = street(
        8.0,
        "model scripted { speed: 1 m/s }; appears when time_to_arrival(av) = 4 s; may go when time_to_arrival(av) = 4 s, or after 5 s",
    );
    let case = case(&text);
    let users = road_users(&case.world, case.seed).unwrap();
    let later = sim::RunChange::AppearsLater { pedestrian: 0, by: 0.2 };
    let mut course = sim::Course::start(case.world.clone(), users).changed(later);
    let mut way = Way::default();
    assert!(matches!(course.next(&mut way), Ok(sim::Progress::Ended(_))));
    assert!((sets_off(&way).unwrap() - 4.2).abs() < 0.026, "{:?}", sets_off(&way));
}

/// A run that ends during a look and in which the pedestrian was hit is no encounter that cannot be: a search or an estimate would lose the hit.
#[test]
fn a_pedestrian_that_is_hit_while_it_looks_is_hit() {
    let text = street(
        5.0,
        "model social_force; appears when time_to_arrival(av) = 4 s; may go when time_to_arrival(av) = 0 s, or after 19.5 s",
    );
    // It stands in the lane, and the car stops on it: the time to arrival never comes to 0 s.
    let stops = "constant_deceleration { distance: 3 m, deceleration: 5 m/s^2 }";
    let standing = |place: &str| {
        text.replace("start 2 m from kerb", &format!("start {place} from lane centre"))
            .replace("constant_speed", stops)
            .replace("speed 50 km/h", "speed 20 km/h")
    };
    assert!(matches!(way(&standing("3.75 m")).map(|_| ()), Err(Fault::NeverMayGo { .. })));
    assert!(way(&standing("0.9 m")).is_ok());
    assert_eq!(of(&standing("0.9 m"), "collision"), Some(1.0));
}

/// What a pedestrian loses to others does not depend on how long it looked, where a car is as far away when it may go.
#[test]
fn a_look_is_no_delay() {
    let delay = |look: f64| {
        let walker = format!("model social_force; looks for {look} s");
        of(&street(12.0 + look, &walker), "pedestrian_delay").unwrap()
    };
    assert!((delay(0.0) - delay(4.0)).abs() < 0.03, "{} s and {} s", delay(0.0), delay(4.0));
}
