//! Verdicts as users meet them at the command line: stated confidence and what it takes.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the program in a folder.
fn scenario_runner(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_scenario-runner"))
        .args(arguments)
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .output()
        .expect("the binary runs")
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("output is UTF-8")
}

/// A street, a car and someone who crosses it, with what a test adds to the scenario.
fn walk(folder: &Path, more: &str) -> PathBuf {
    let text = format!(
        "scenario walk {{
  road {{ lane_width 4 m; speed_limit 30 km/h; crossing zebra }}
  vehicle av {{ controller carla_behavior; speed 30 km/h }}
  pedestrian walker {{ model carla_walker; start 2 m from kerb; appears when time_to_arrival(av) = 6 s }}
  {more}
}}
"
    );
    let path = folder.join("walk.scn");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn what_its_runs_can_never_show_is_refused_before_anything_runs() {
    let folder = tempfile::tempdir().unwrap();
    walk(folder.path(), "repeat 60; expect { pet >= 1 s in 99 % of runs with 95 % confidence }");
    for arguments in [&["walk.scn"][..], &["check", "walk.scn"]] {
        let output = scenario_runner(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
        assert!(stderr(&output).contains("error[E0611]"), "{}", stderr(&output));
        assert!(
            stderr(&output).contains("needs at least 299 runs; this trial has 60"),
            "{}",
            stderr(&output)
        );
        assert!(stderr(&output).contains("walk.scn:5:23"), "{}", stderr(&output));
        assert!(output.stdout.is_empty());
    }
}
