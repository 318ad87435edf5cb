//! Scenarios drawn: every one that ships, what is drawn of names, and what cannot be drawn.

use std::fs;
use std::path::Path;

use files::Disk;
use models::standard;
use report::Sketch;
use runner::plan::plan;

use crate::support::program::{code, scenario_runner, stderr, stdout};

/// Size of a sketch where standard output is not a terminal, in characters.
const COLUMNS: usize = 100;
const ROWS: usize = 60;

const SCENARIO: &str = "scenario walk {
  road { lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra { width: 4 m } }
  vehicle av { start 40 m before crossing; speed 36 km/h; controller constant_speed; sees { range: 80 m } }
  pedestrian walker { model scripted { speed: 1.5 m/s }; start 2 m from kerb; appears at gap }
  vary gap in [1 s, 2 s]
  expect { passed_first = vehicle }
}
scenario other {
  road { lanes forward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra { width: 4 m } }
  vehicle av { start 90 m before crossing; speed 36 km/h; controller constant_speed }
  pedestrian walker { model scripted; start 2 m from kerb; appears when time_to_arrival(av) = 3 s }
  expect { no collision }
}
";

fn place(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.scn"), text).unwrap();
    folder
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The library draws every scenario; the program draws the first one of each suite and must show the same.
#[test]
fn every_scenario_that_ships_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let svg = folder.path().join("a.svg");
    let mut drawn = 0;
    let mut suites: Vec<_> =
        fs::read_dir(root().join("suites")).unwrap().map(|entry| entry.unwrap().path()).collect();
    suites.retain(|path| path.extension().is_some_and(|ending| ending == "suite"));
    for suite in suites {
        let file = suite.display().to_string();
        let suite =
            lang::load(&suite, &standard(), &Disk).unwrap_or_else(|_| panic!("{file} has errors")).suite;
        let plan = plan(&suite).unwrap_or_else(|errors| panic!("{file}: {}", errors[0].message));
        let first_trial =
            |name: &str| plan.trials().find(|trial| trial.scenario == name && !trial.cases.is_empty());
        for (index, name) in suite.scenarios.iter().map(|scenario| &scenario.name).enumerate() {
            let case = first_trial(name).expect("a trial with a run").cases.first();
            let sketch = Sketch::of(&case);
            let (text, picture) = (sketch.to_text(COLUMNS, ROWS), sketch.to_svg());
            assert!(
                text.contains("before the crossing") && text.contains("If all keep their speed:"),
                "{name}:\n{text}"
            );
            assert!(text.lines().all(|line| line.chars().count() <= COLUMNS), "{name}:\n{text}");
            let mut reader = quick_xml::Reader::from_str(&picture);
            while !matches!(reader.read_event().unwrap(), quick_xml::events::Event::Eof) {}
            assert!(
                picture.contains("class=\"vehicle")
                    && picture.contains("class=\"pedestrian") != case.world.pedestrians.is_empty()
                    && !picture.contains("NaN"),
                "{name}:\n{picture}"
            );
            drawn += 1;
            if index == 0 {
                let said = scenario_runner(root(), &["sketch", &file, name]);
                assert_eq!(code(&said), 0, "{name}: {}", stderr(&said));
                assert_eq!(stdout(&said), text, "{name}");
                let made =
                    scenario_runner(root(), &["sketch", &file, name, "-o", &svg.display().to_string()]);
                assert_eq!(code(&made), 0, "{name}: {}", stderr(&made));
                assert_eq!(fs::read_to_string(&svg).unwrap(), picture, "{name}");
            }
        }
    }
    assert!(drawn > 20, "{drawn} scenarios");
}

#[test]
fn names_say_what_is_drawn() {
    let folder = place(SCENARIO);
    let key = |arguments: &[&str]| {
        let output = scenario_runner(folder.path(), &[&["sketch", "a.scn"], arguments].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        (stdout(&output).lines().next().unwrap().to_string(), stderr(&output))
    };
    let (first, note) = key(&[]);
    assert_eq!(first, "a/walk/gap=1s/rep=1");
    assert!(note.contains("is the first of 3 runs"), "{note}");
    assert_eq!(key(&["other"]), ("a/other/rep=1".to_string(), String::new()));
    assert_eq!(key(&["a/other"]).0, "a/other/rep=1");
    assert_eq!(key(&["gap=2s"]).0, "a/walk/gap=2s/rep=1");
    assert_eq!(key(&["a/walk/gap=2s/rep=1"]), ("a/walk/gap=2s/rep=1".to_string(), String::new()));
    let unknown = scenario_runner(folder.path(), &["sketch", "a.scn", "othr"]);
    assert_ne!(code(&unknown), 0);
    assert!(stderr(&unknown).contains("nothing in a.scn is called `othr`"), "{}", stderr(&unknown));
    assert!(stderr(&unknown).contains("the nearest names are `other`"), "{}", stderr(&unknown));
    // What cannot be planned is told as everywhere.
    fs::write(folder.path().join("b.scn"), SCENARIO.replace("40 m before", "-4000 km before")).unwrap();
    let wrong = scenario_runner(folder.path(), &["sketch", "b.scn"]);
    assert!(code(&wrong) == 3 && stderr(&wrong).contains("b.scn:3"), "{}", stderr(&wrong));
}

#[test]
fn moments_are_those_of_the_run() {
    let folder = place(SCENARIO);
    let said = |arguments: &[&str]| {
        let output = scenario_runner(folder.path(), &[&["sketch", "a.scn", "gap=1s"], arguments].concat());
        (code(&output), stdout(&output), stderr(&output))
    };
    let (ended, moment, _) = said(&["--at", "1.5s"]);
    assert_eq!(ended, 0);
    assert!(moment.contains("after 1.50 s: av 10.0 m/s, walker 1.5 m/s"), "{moment}");
    let (_, both, _) = said(&["--at", "1s", "--at", "500ms"]);
    assert!(both.contains("after 1.00 s:") && both.contains("after 0.50 s:"), "{both}");
    let (ended, _, why) = said(&["--at", "500s"]);
    assert!(ended == 2 && why.contains("the run ends after"), "{ended}: {why}");
    let (ended, strip, _) = said(&["--strip"]);
    assert!(ended == 0 && strip.matches("after ").count() == 7, "{strip}");
    assert_eq!(said(&["--strip", "--at", "1s"]).0, 2);
    assert_eq!(said(&["--at", "soon"]).0, 2);
}

#[test]
fn nothing_of_a_users_program_runs_without_permission() {
    let ran = |folder: &Path| folder.join("ran").exists();
    let folder = place(
        &(SCENARIO.replace("controller constant_speed; sees", "controller mine; sees")
            + "controller mine { command \"sh\", \"-c\", \"touch ran\"; gives acceleration; period 50 ms }\n"),
    );
    let drawn = scenario_runner(folder.path(), &["sketch", "a.scn", "walk"]);
    assert!(code(&drawn) == 0 && !ran(folder.path()), "{}", stderr(&drawn));
    let refused = scenario_runner(folder.path(), &["sketch", "a.scn", "walk", "--at", "1s"]);
    assert!(code(&refused) != 0 && !ran(folder.path()), "{}", stderr(&refused));
    assert!(stderr(&refused).contains("scenario-runner allow"), "{}", stderr(&refused));
}

#[test]
fn a_trace_has_more_columns_where_they_are_asked_for() {
    let folder = place(SCENARIO);
    let trace = |name: &str, more: &[&str]| {
        let arguments = ["replay", "a/other/rep=1", "a.scn", "--trace", name];
        let output = scenario_runner(folder.path(), &[&arguments, more].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let text = fs::read_to_string(folder.path().join(name)).unwrap();
        text.lines().map(str::to_string).collect::<Vec<_>>()
    };
    let (plain, full) = (trace("plain.csv", &[]), trace("full.csv", &["--trace-columns", "full"]));
    assert_eq!(plain[0], "time_s,who,x_m,y_m,vx_m_s,vy_m_s,acceleration_m_s2,mode,event");
    assert_eq!(full[0], format!("{},s_m,d_m,heading_rad", plain[0]));
    assert!(plain.len() > 100 && plain.len() == full.len());
    for (plain, full) in plain.iter().zip(&full).skip(1) {
        assert!(full.starts_with(plain.as_str()), "{plain} and {full}");
        let cells: Vec<&str> = full.split(',').collect();
        // A straight road's places are those of the plane.
        assert_eq!((cells[9], cells[10]), (cells[2], cells[3]));
        let heading: f64 = cells[11].parse().unwrap();
        assert_eq!(heading, if cells[1] == "av" { 0.0 } else { std::f64::consts::FRAC_PI_2 }, "{full}");
    }
    let alone = scenario_runner(folder.path(), &["a.scn", "--trace-columns", "full"]);
    assert!(code(&alone) == 2 && stderr(&alone).contains("--trace"), "{}", stderr(&alone));
}
