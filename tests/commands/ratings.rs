//! Ratings as a user meets them: points, verdicts and exit codes, and what is said of cells that are not there.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::Value;

use crate::support::program::{code, scenario_runner, stderr, stdout};

/// Three speeds and two places of the front; `more` statements of the scenario and of the rating.
fn suite(scenario: &str, rating: &str) -> String {
    format!(
        "suite rated {{
  scenario crossing {{
    tags crossing, unverified
    road {{ lane_width 3.5 m; speed_limit 60 km/h; crossing unmarked }}
    vehicle av {{ controller yielding; size 4.358 m x 1.815 m; speed pace; start 8 s before crossing }}
    pedestrian dummy {{
      model scripted {{ speed: 5 km/h, acceleration_way: 1 m }}
      size 0.6 m x 0.5 m
      start 4 m from lane centre
      meets av at impact
    }}
    vary pace in [20 km/h, 30 km/h, 40 km/h]
    vary impact in [25 %, 75 %]
    end on collision
    {scenario}
  }}
  rating protocol {{
    measure impact_speed(component: along)
    weights when pace <= 20 km/h {{ 0 km/h: 1 }}
    weights when pace > 20 km/h {{ 0 km/h: 1, below 10 km/h: 0.25 }}
    points crossing 2
    not assessed \"night cells: there is no light model\"
    {rating}
  }}
}}
"
    )
}

fn folder(suite: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("rated.suite"), suite).unwrap();
    folder
}

fn run(folder: &tempfile::TempDir, more: &[&str]) -> Output {
    let arguments = [&["rated.suite", "--no-progress", "--status-level", "none"], more].concat();
    scenario_runner(folder.path(), &arguments)
}

/// What a terminal shows of ratings.
fn rating_of(output: &Output) -> String {
    let text = stdout(output);
    text[text.find("\nrating ").unwrap_or_else(|| panic!("{text}"))..].trim_start().to_string()
}

#[test]
fn points_are_a_verdict_where_something_is_expected_of_them() {
    let folder = folder(&suite("", "expect { points >= 1.5 }"));
    let good = run(&folder, &["--json", "good.json", "--junit", "good.xml", "--html", "good.html"]);
    assert_eq!(code(&good), 0, "{}{}", stdout(&good), stderr(&good));
    assert!(rating_of(&good).contains("2 of 2 points that the cells would earn"), "{}", rating_of(&good));
    let bad =
        run(&folder, &["--controller", "av=constant_speed", "--json", "bad.json", "--junit", "bad.xml"]);
    assert_eq!(code(&bad), 100, "{}{}", stdout(&bad), stderr(&bad));
    assert!(rating_of(&bad).contains("✗ points >= 1.5 failed: 0"), "{}", rating_of(&bad));

    // The same is said later, by the file alone.
    for (name, output) in [("good.json", &good), ("bad.json", &bad)] {
        let again = scenario_runner(folder.path(), &["report", name]);
        assert_eq!(code(&again), code(output));
        assert_eq!(rating_of(&again), rating_of(output));
        let results: Value = serde_json::from_slice(&fs::read(folder.path().join(name)).unwrap()).unwrap();
        let rating = &results["suites"][0]["ratings"][0];
        let (verdict, points) = if name == "good.json" { ("passed", 2.0) } else { ("failed", 0.0) };
        assert_eq!((rating["verdict"].as_str(), rating["points"].as_f64()), (Some(verdict), Some(points)));
        assert_eq!(rating["result"]["cells"].as_array().unwrap().len(), 6);
    }
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(read("good.xml").contains("<testcase name=\"rated/rating=protocol\""));
    assert!(
        read("bad.xml").contains("<failure message=\"points &gt;= 1.5\" type=\"points\">"),
        "{}",
        read("bad.xml")
    );
    assert!(read("good.html").contains("id=\"suite-1-rating-1\""));
}

#[test]
fn without_an_expectation_nothing_is_judged() {
    let folder = folder(&suite("", ""));
    let output = run(&folder, &[]);
    assert_eq!(code(&output), 102, "{}", stderr(&output));
    assert!(stderr(&output).contains("a rating has a verdict if"), "{}", stderr(&output));
    insta::assert_snapshot!(rating_of(&output));
    // What else is judged decides.
    let folder = self::folder(&suite("expect { no collision }", ""));
    assert_eq!(code(&run(&folder, &[])), 0);
}

/// Each of these would be green if the cells that are there stood for those that are not.
#[test]
fn cells_that_are_not_there_are_never_green() {
    let with_criterion = suite("expect { no collision }", "expect { points >= 1 }");
    let whole = folder(&with_criterion);
    assert_eq!(code(&run(&whole, &[])), 0);
    for (left_out, said) in [
        (vec!["pace=20km/h"], "4 of 6 cells were not run"),
        (vec!["--partition", "slice:1/2"], "of 6 cells were not run"),
        (vec!["--set", "pace=20km/h"], "with pace=20km/h these are not the cells that it is about"),
        (vec!["--set", "dummy.model.speed=1m/s"], "these are not the cells that it is about"),
    ] {
        let output = run(&whole, &left_out);
        let said_of = rating_of(&output);
        assert_eq!(code(&output), 102, "{left_out:?}: {said_of}");
        assert!(
            said_of.starts_with("rating protocol is NOT JUDGED: ") && said_of.contains(said),
            "{said_of}"
        );
    }
    // A horizon before they meet: nobody was hit, and nothing is known.
    let cut = folder(&suite("horizon 3 s; expect { max_deceleration <= 9 m/s^2 }", "expect { points >= 1 }"));
    let output = run(&cut, &[]);
    assert_eq!(code(&output), 102, "{}", rating_of(&output));
    assert!(
        rating_of(&output).contains("points that the cells would earn: undefined of 2"),
        "{}",
        rating_of(&output)
    );
    // What is tested may have other parameters, and cells more runs.
    for fine in [["--set", "av.controller.kerb_distance=1m"], ["--repeat", "2"]] {
        let output = run(&whole, &fine);
        assert_ne!(rating_of(&output).find("points >= 1 passed"), None, "{}", rating_of(&output));
    }
}

/// Somebody who walks along a lane is nobody to a car that never gets there, or that they walk beside.
#[test]
fn cells_along_a_lane_that_never_met_are_not_assessed() {
    let points = |walks: &str, more: &str| {
        let text = suite(more, "expect { points >= 1 }");
        let crossing = "start 4 m from lane centre\n      meets av at impact";
        assert!(text.contains(crossing));
        let folder =
            folder(&text.replace(crossing, &format!("walks with traffic; goal 30 m further; {walks}")));
        let output = run(&folder, &[]);
        (code(&output), rating_of(&output))
    };
    let met = points("meets av at impact after 5 m", "");
    assert!(met.0 == 0 && met.1.contains("2 of 2 points"), "{met:?}");
    for (walks, more, said) in [
        // Cut off before the car is there.
        ("meets av at impact after 5 m", "horizon 5 s", "was cut off at 5 s"),
        // On the pavement, whom no car would hit.
        ("start 4 m from lane centre", "", "no pedestrian came into the way of a vehicle"),
        ("start 0.45 m from lane centre; appears at 50 s", "horizon 40 s", "nobody appeared"),
    ] {
        let (code, said_of) = points(walks, more);
        assert_eq!(code, 102, "{walks}: {said_of}");
        assert!(said_of.contains("points that the cells would earn: undefined of 2"), "{said_of}");
        assert!(said_of.contains(said), "{walks}: {said_of}");
    }
}

#[test]
fn a_rating_is_listed_and_asked_for_again() {
    let folder = folder(&suite("", "expect { points >= 1.5 }"));
    let listed = stdout(&scenario_runner(folder.path(), &["list", "rated.suite"]));
    assert!(listed.contains("rated/rating=protocol"), "{listed}");
    assert!(listed.contains("6 cells"), "{listed}");
    // It takes all cells to judge it, so all are run again where it failed.
    let text =
        suite("", "expect { points >= 1.5 }").replace("controller yielding", "controller constant_speed");
    let folder = self::folder(&text);
    assert_eq!(code(&run(&folder, &[])), 100);
    let again = run(&folder, &["--last-failed"]);
    assert_eq!(code(&again), 100, "{}", stderr(&again));
    assert!(rating_of(&again).contains("0 of 2 points"), "{}", rating_of(&again));
}

fn shipped() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("suites/euro_ncap_vru.suite")
}

/// The score table of a fixed controller.
#[test]
fn euro_ncap_cells_of_a_braking_car() {
    let folder = tempfile::tempdir().unwrap();
    let suite = shipped();
    let arguments = ["--controller", "av=idm_aeb", "--no-progress", "--status-level", "none"];
    let output = scenario_runner(folder.path(), &[&[suite.to_str().unwrap()], &arguments[..]].concat());
    insta::assert_snapshot!(rating_of(&output));
}

/// A car that keeps its speed is hit where the cell says, within 0.1 % of its width; in every cell, standard and extended.
#[test]
fn euro_ncap_cells_hit_where_they_say() {
    let folder = tempfile::tempdir().unwrap();
    let suite = shipped();
    let arguments = ["--controller", "av=constant_speed", "--json", "results.json", "--no-progress"];
    scenario_runner(folder.path(), &[&[suite.to_str().unwrap()], &arguments[..]].concat());
    let results: Value =
        serde_json::from_slice(&fs::read(folder.path().join("results.json")).unwrap()).unwrap();
    let trials = results["suites"][0]["trials"].as_array().unwrap();
    let mut places = Vec::new();
    for trial in trials {
        let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value} in {}", trial["key"]));
        let metrics = &trial["runs"][0]["metrics"];
        let (wanted, found) = (number(&trial["variation"]["impact"]), number(&metrics["impact_point"]));
        assert!((found - wanted).abs() <= 0.001, "{}: {found} and not {wanted}", trial["key"]);
        let (pace, speed) =
            (number(&trial["variation"]["pace"]), number(&metrics["impact_speed(component=along)"]));
        // Along a car that turns the dummy of CPTA walks with it or against it; those of CPLA and CBLA are before it.
        let is = |name: &str| trial["key"].as_str().unwrap().contains(name);
        let away = match () {
            () if is("/cpla") => 5.0 / 3.6,
            () if is("/cbla") && is("_fast") => 20.0 / 3.6,
            () if is("/cbla") => 15.0 / 3.6,
            () => 0.0,
        };
        let closing = pace - away;
        assert!(is("/cpta") || (closing - speed).abs() < 1e-9, "{}: {speed} and not {closing}", trial["key"]);
        places.push(wanted);
    }
    // 5 + 5 + 3 places at six speeds, five in each of four turns in two directions, and four along the lane at eight speeds; then
    // cyclists: three times five at six speeds, and four along the lane at seven.
    assert_eq!(places.len(), 78 + 40 + 32 + 90 + 28);
    assert_eq!(results["suites"][0]["ratings"][0]["points"], 0.0);
}
