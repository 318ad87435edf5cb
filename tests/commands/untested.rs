//! What was never put to the test, as users meet it at the command line: warned of, and with `--deny untested` not green.

use std::path::Path;

use crate::support::program::{scenario_runner, stderr, stdout};

/// A zebra with a lane each way.
const ROAD: &str =
    "road r { lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }\n";

/// What a run of `text` says, and with which code it ends where untested criteria are denied.
fn denied(text: &str, more: &[&str]) -> (Option<i32>, String) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.scn"), format!("{ROAD}{text}")).unwrap();
    run(folder.path(), &[&["run", "--deny", "untested"], more, &["a.scn"]].concat())
}

fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = scenario_runner(folder, arguments);
    (output.status.code(), format!("{}{}", stdout(&output), stderr(&output)))
}

#[track_caller]
fn assert_untested(text: &str, words: &[&str]) {
    let (code, said) = denied(text, &[]);
    assert_eq!(code, Some(102), "{said}");
    for words in words {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[track_caller]
fn assert_tested(text: &str) {
    let (code, said) = denied(text, &[]);
    assert_eq!(code, Some(0), "{said}");
    assert!(!said.contains("untested"), "{said}");
}

const AV: &str = "vehicle av { controller yielding; speed 36 km/h; start 70 m before crossing }";
const WALKER: &str =
    "pedestrian walker { model scripted { speed: 1.4 m/s }; start 2 m from kerb; appears at 1 s }";

#[test]
fn a_car_that_meets_nobody_is_not_tested_by_another_one_that_does() {
    // The second car comes by; `av` stands 40 m away long before.
    let both = |criteria: &str| {
        format!(
            "scenario s {{ road r
  {WALKER}
  vehicle av {{ controller constant_deceleration {{ time: 0 s, deceleration: 12 m/s^2 }}; speed 10 m/s; start 95 m before crossing }}
  vehicle other {{ controller yielding; speed 36 km/h; lane 1; start 60 m before crossing }}
  expect {{ {criteria} }}
}}"
        )
    };
    assert_tested(&both("no collision; no collision(other)"));
    assert_untested(
        &both("no collision(av)"),
        &["`no collision(av)` passed untested: `walker` was in the way of `av`, but not within 5 s of it"],
    );
    assert_untested(&both("min_ttc(av, walker) >= 1 s"), &["passed untested"]);
}

#[test]
fn every_person_is_met_or_named() {
    let two = |criteria: &str| {
        format!(
            "scenario s {{ road r
  {AV}
  {WALKER}
  pedestrian late {{ model scripted {{ speed: 1.4 m/s }}; start 2 m from kerb; along 3 m; appears at 40 s }}
  expect {{ {criteria} }}
}}"
        )
    };
    let words = "name the pairs that you mean, as in `no collision(av, walker)`";
    assert_untested(&two("no collision"), &["`late` was not there while `av` had yet to pass", words]);
    assert_untested(&two("no collision(av, walker); pet >= 0 s undefined passes"), &[]);
    assert_tested(&two("no collision(av, walker)"));
    // What the car does alone is tested by one of them.
    assert_tested(&two("max_deceleration <= 9 m/s^2"));
}

#[test]
fn a_person_who_never_appears_tests_nothing() {
    let of = |criteria: &str| {
        let walker = WALKER.replace("appears at 1 s", "appears at 300 s");
        format!(
            "scenario s {{ road r
  {AV}
  {walker}
  expect {{ {criteria} }} }}"
        )
    };
    let absent = "`walker` did not appear in the run";
    for criteria in
        ["no collision(av)", "impact_speed(av) <= 1 m/s", "rate(collision(av)) <= 0 %", "no collision"]
    {
        assert_untested(&of(criteria), &[absent]);
    }
    assert_untested(&of("max_deceleration <= 9 m/s^2"), &["did not move while a pedestrian was"]);
    // An order between a car and a pedestrian that never appears declares nothing.
    assert_untested(&of("no collision; passed_first = none"), &[absent]);
}

#[test]
fn a_car_that_never_arrives_excuses_nothing_by_who_goes_first() {
    let of = |controller: &str, first: &str| {
        format!(
            "scenario s {{ road r
  vehicle av {{ controller {controller}; speed 10 m/s; start 70 m before crossing }}
  pedestrian stays {{ model scripted {{ speed: 1 m/s, stop_after: 0.5 m, stop_for: 100 s }}; start 2 m from kerb; appears at 1 s }}
  horizon 20 s
  expect {{ no collision; passed_first = {first} }}
}}"
        )
    };
    assert_tested(&of("constant_speed", "vehicle"));
    assert_untested(
        &of("constant_deceleration { time: 0 s, deceleration: 3 m/s^2 }", "none"),
        &["`no collision` passed untested: `stays` did not come into the way of `av`"],
    );
}

#[test]
fn two_vehicles_are_tested_where_they_had_to_do_with_each_other() {
    let of = |other: &str| {
        format!(
            "scenario s {{ road r
  vehicle av {{ controller constant_speed; speed 36 km/h; start 100 m before crossing }}
  vehicle van {{ controller constant_speed; {other} }}
  {WALKER}
  expect {{ no collision(av, van); vehicle_distance(van, av) >= 0.5 m }}
}}"
        )
    };
    // 35.6 m between the bodies are 3.6 s, and 75.6 m are 7.6 s; both are as fast, so that neither is on a collision course.
    assert_tested(&of("speed 36 km/h; start 60 m before crossing"));
    let apart = "`van` did not come into the way of `av`";
    assert_untested(&of("speed 36 km/h; start 20 m before crossing"), &[apart]);
    // On a collision course, however far.
    assert_tested(&of("speed 32 km/h; start 20 m before crossing"));
    // In the other lane.
    assert_untested(&of("speed 36 km/h; lane 1; start 60 m before crossing"), &[apart]);
}

#[test]
fn a_time_between_centres_is_warned_of_where_bodies_overlap() {
    let of = |size: &str| {
        format!(
            "scenario s {{ road r
  vehicle av {{ controller constant_speed; size {size}; speed 5 m/s; start 40 m before crossing }}
  pedestrian walker {{ model scripted {{ speed: 2 m/s }}; start 4 m from lane centre; appears at 8 s }}
  expect {{ pet >= 1.5 s; no collision }}
}}"
        )
    };
    let words = "the bodies were in the shared area at the same time in 1 of 1 run";
    assert!(denied(&of("12 m x 2.5 m"), &[]).1.contains(words));
    let (code, said) = denied(&of("4 m x 1.8 m"), &[]);
    assert!(code == Some(0) && !said.contains(words), "{said}");
}

#[test]
fn a_flag_that_needs_a_red_light_says_so_in_all_its_forms() {
    let base = format!(
        "define b {{ road r
  {AV}
  {WALKER} }}"
    );
    for criteria in ["no ran_red", "rate(ran_red) <= 1 %", "count(ran_red) = 0"] {
        let text = format!("{base}\nscenario s : b {{ expect {{ {criteria} }} }}");
        assert_untested(&text, &["nothing that it is about was at stake", "warning[W0961]"]);
    }
}

#[test]
fn a_step_that_never_begins_is_named_in_the_trial() {
    let of = |distance: &str| {
        format!(
            "scenario s {{ road r
  {WALKER}
  vehicle av {{ controller timeline {{ steps: \"when distance < d1 stop\"; d1: {distance} }}; speed 36 km/h; start 70 m before crossing }}
  expect {{ no collision; max_deceleration <= 4 m/s^2 }}
}}"
        )
    };
    assert_tested(&of("30 m"));
    assert_untested(
        &of("-5 m"),
        &["step 1 of `av`, `when distance < d1 stop`, began in no run: what it brings about is untested"],
    );
    // The same of a person.
    assert_untested(
        &format!(
            "scenario s {{ road r
  {AV}
  pedestrian walker {{ model timeline {{ steps: \"at t1 resume; when walked > d1 stop\"; t1: 0.5 s; d1: 100 m }}; start 2 m from kerb; appears at 1 s }}
  expect {{ no collision }}
}}"
        ),
        &["step 2 of `walker`, `when walked > d1 stop`, began in no run"],
    );
}

#[test]
fn estimates_statements_and_evaluations_say_that_nothing_was_at_stake() {
    let scenario = |appears: &str| {
        format!(
            "scenario s {{ road r
  {AV}
  pedestrian walker {{ model scripted {{ speed: pace }}; start 3 m from kerb; appears at {appears} }}
  draw pace from uniform(1 m/s, 2 m/s)
  repeat 4; horizon 40 s
  expect {{ }}
}}\n"
        )
    };
    let estimate =
        "estimate hit { of s; event collision; budget 2000 runs, by crude; claim guaranteed <= 5 % }";
    let statement =
        "statement st { \"few are hit\"; source \"free choice\"; claim rate(collision) of s <= 1 % }";
    let evaluate = "evaluate ev { on s; with default; measure rate(collision) }";
    let words = [
        (estimate, "none of 2000 runs of `s` had an encounter"),
        (statement, "nothing was at stake in the runs that it measures"),
        (evaluate, "rate(collision) of default: untested: `walker` did not appear"),
    ];
    for (block, words) in words {
        assert_untested(&format!("{}{block}", scenario("300 s")), &[words]);
        let (code, said) = denied(&format!("{}{block}", scenario("1 s")), &[]);
        assert!(code == Some(0) && !said.contains("untested"), "{block}: {code:?} {said}");
    }
    // An estimate and a statement are not green without `--deny untested`, either.
    for block in [estimate, statement] {
        let folder = tempfile::tempdir().unwrap();
        let text = format!("{ROAD}{}{block}", scenario("300 s"));
        std::fs::write(folder.path().join("a.scn"), text).unwrap();
        let (code, said) = run(folder.path(), &["run", "a.scn"]);
        assert_eq!(code, Some(102), "{said}");
    }
}

#[test]
fn it_is_said_in_how_many_runs_a_pair_was_met() {
    let text = format!(
        "scenario s {{ road r
  {AV}
  pedestrian walker {{ model scripted {{ speed: 1.4 m/s }}; start 2 m from kerb; appears at late }}
  draw late from choice(1 s, 200 s)
  repeat 20; horizon 30 s
  expect {{ rate(collision) <= 10 % }}
}}"
    );
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.scn"), format!("{ROAD}{text}")).unwrap();
    let (code, said) = run(folder.path(), &["run", "a.scn", "--json", "r.json", "--html", "r.html"]);
    assert_eq!(code, Some(0), "{said}");
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("r.json")).unwrap()).unwrap();
    let finding = &json["suites"][0]["trials"][0]["findings"][0];
    let tested = finding["tested"].as_u64().expect("some of them met");
    assert!((1..20).contains(&tested), "{finding}");
    let html = std::fs::read_to_string(folder.path().join("r.html")).unwrap();
    assert!(html.contains(&format!("met in {tested} of 20 runs")));
}

#[test]
fn a_car_that_leaves_its_carriageway_is_warned_of_and_counted() {
    // A van that is longer than the bend is wide.
    let of = |kerbs: &str, criteria: &str| {
        format!(
            "road bend {{ path {{ straight 60 m; turn right {{ radius: 8 m, clothoid: 22.85 deg, arc: 44.3 deg }}; straight 60 m }}; lane_width 3 m; speed_limit 30 km/h; crossing zebra {{ at: 90 m }}; {kerbs} }}
scenario s {{ road bend
  vehicle van {{ controller constant_speed; size 12 m x 2.5 m; speed 5 m/s; start 80 m before crossing }}
  {WALKER}
  expect {{ {criteria} }}
}}"
        )
    };
    let (code, said) = denied(&of("", "max_deceleration <= 1 m/s^2"), &[]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("`van` left its carriageway in 1 of 1 run"), "{said}");
    assert!(said.contains("in 1 a vehicle left the road"), "{said}");
    for (kerbs, criteria) in [
        ("no kerbs", "max_deceleration <= 1 m/s^2"),
        ("", "max_deceleration <= 1 m/s^2; rate(kerb_contact) >= 0 %"),
    ] {
        let (_, said) = denied(&of(kerbs, criteria), &[]);
        assert!(!said.contains("left"), "{kerbs} {criteria}: {said}");
    }
}
