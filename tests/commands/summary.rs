//! A run whose reports do not name every trial holds only what did not pass: it must say, remember and end the same.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::support::program::{code, scenario_runner, stderr, stdout};

/// Many trials of which some fail, some have other criteria and some none; many that pass; few; two that stand alone; and some whose
/// runs a block needs.
const SUITE: &str = r#"suite mixed {
  seed 3
  scenario many {
    road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
    vehicle av { controller constant_speed; start 40 m before crossing; speed speed }
    pedestrian walker { model carla_walker; start 1 m from kerb; appears at late }
    vary late in 0 s .. 2.8 s step 0.2 s
    vary speed in [30 km/h, 40 km/h, 50 km/h]
    repeat 5
    horizon 6 s
    expect {
      no collision when late >= 2 s
      pet >= 1 s when late <= 1 s
      rate(collision) < 50 % with 95 % confidence when late < 0.3 s
      max_deceleration <= 9 m/s^2 when speed > 35 km/h
    }
  }
  scenario sampled {
    road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
    vehicle av { controller constant_speed; start 40 m before crossing; speed speed }
    pedestrian walker { model scripted; start 1 m from kerb; appears at late }
    vary late in uniform(0 s, 4 s) 40 times
    vary speed in [36 km/h, 72 km/h]
    horizon 4 s
    expect { no collision }
  }
  scenario safe {
    road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
    vehicle av { controller constant_speed; start 40 m before crossing; speed 50 km/h }
    pedestrian walker { model scripted; start 1 m from kerb; appears at late }
    vary late in 8 s .. 12 s step 0.1 s
    horizon 12 s
    expect { no collision; min_distance >= 0.5 m undefined passes }
  }
  scenario few {
    road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
    vehicle av { controller constant_speed; start 40 m before crossing; speed 50 km/h }
    pedestrian walker { model scripted; start 1 m from kerb; appears at late }
    vary late in [0 s, 9 s]
    expect { max_deceleration <= 9 m/s^2 }
  }
  scenario one {
    road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
    vehicle av { controller constant_speed; start 40 m before crossing; speed 50 km/h }
    pedestrian walker { model scripted; start 1 m from kerb; appears at 0 s }
    expect { max_deceleration <= 9 m/s^2; min_distance >= 0.1 m undefined passes }
  }
  scenario other {
    road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
    vehicle av { controller constant_speed; start 40 m before crossing; speed 40 km/h }
    pedestrian walker { model scripted; start 1 m from kerb; appears at 0 s }
    expect { min_distance >= 0.1 m undefined passes; no collision }
  }
  statement slow { claim mean(time_lost) of safe <= 1 s }
}
"#;

const MEMORY: &str = ".scenario-runner/last-run.json";
const FAILURES: &str = "mixed.failures";

/// How a session ended, what it said without times, and what it left in files.
type Told = (Option<i32>, String, String, Vec<Option<String>>);

fn told(folder: &Path, output: &Output) -> Told {
    let without_times = |text: String| {
        let mut parts = text.split('[');
        let mut told = parts.next().unwrap_or_default().to_string();
        for part in parts {
            let is_time =
                |time: &str| time.ends_with('s') && time.trim_end_matches('s').trim().parse::<f64>().is_ok();
            match part.split_once(']') {
                Some((time, rest)) if is_time(time) => told += &format!("[time]{rest}"),
                _ => told += &format!("[{part}"),
            }
        }
        told
    };
    let remembered = [MEMORY, FAILURES].map(|file| fs::read_to_string(folder.join(file)).ok()).to_vec();
    (output.status.code(), without_times(stdout(output)), without_times(stderr(output)), remembered)
}

/// With these options, where every trial is held for a report and where none is asked for.
fn both(folder: &Path, options: &[&str]) -> [Told; 2] {
    let before = [MEMORY, FAILURES].map(|file| (folder.join(file), fs::read(folder.join(file)).ok()));
    [&["--tap", "all.tap"][..], &[]].map(|report| {
        for (path, before) in &before {
            match before {
                Some(before) => fs::write(path, before).unwrap(),
                None => drop(fs::remove_file(path)),
            }
        }
        let base = ["mixed.suite", "-j", "1", "--no-progress"];
        told(folder, &scenario_runner(folder, &[&base[..], options, report].concat()))
    })
}

#[test]
fn what_passed_is_counted_and_nothing_else_changes() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mixed.suite"), SUITE).unwrap();
    let mut said = Vec::new();
    for options in [
        &[][..],
        &["--status-level", "none"],
        &["--last-failed"],
        &["safe"],
        &["--last-failed"],
        &["late=2s"],
        &["slow", "--exact"],
        &["mixed/slow"],
        &["--partition", "slice:2/3"],
        &["--max-fail", "3"],
        &["--last-failed"],
        &["--set", "av.speed=10km/h", "safe"],
        &["--deny", "untested", "few"],
        &["--deny", "untested", "safe"],
        &["sampled"],
        &["--record-failures", "sampled"],
        &["--record-failures", "many"],
        &["--prune-failures"],
    ] {
        let [whole, counted] = both(folder.path(), options);
        assert!(counted == whole, "{options:?}:\n{}{}\nis not\n{}{}", counted.1, counted.2, whole.1, whole.2);
        said.push(counted);
    }
    let first = &said[0].1;
    assert!(first.contains("41 of 41 trials passed and are not shown"), "{first}");
    assert!(first.contains("of 45 trials passed,") && first.contains("were not judged"), "{first}");
    assert!(first.contains("failed in") && first.contains("closest to"), "{first}");
    assert_eq!(said[0].0, Some(100), "{}", said[0].2);
    // What passed was told apart from what did not, or everything would be run again.
    assert!(said[2].1.len() < first.len() / 2, "{}", said[2].1);
}

/// Whoever lets results hold only what did not pass cannot take them for everything.
#[test]
fn reports_of_each_trial_refuse_what_is_counted() {
    use scenario_runner::results::{Overall, Unheard};
    use scenario_runner::{Memory, Project, Selection, Session, models, report};

    let files = Memory::default().with("mixed.suite", SUITE);
    let project = Project::open("mixed.suite", &models::standard(), &files).unwrap();
    let session = Session::new(&project).courses(false).every_trial(false);
    let safe = session.run(&Selection::containing("mixed/safe"), &mut Unheard).unwrap();
    assert!(safe.suites[0].trials.is_empty());
    assert_eq!(safe.overall(), Overall::Passed);
    for refused in [report::write_json(&safe, Vec::new()), report::write_tap(&safe, &mut Vec::new())] {
        let why = refused.unwrap_err().to_string();
        assert!(why.contains("mixed hold 0 of 170 trials"), "{why}");
    }
    let few = session.run(&Selection::containing("mixed/few"), &mut Unheard).unwrap();
    assert_eq!(few.suites[0].trials.len(), 2);
}

#[test]
fn suites_with_gates_hold_every_trial() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let gated = SUITE.replace(
        "  statement slow",
        "  gate calm { baseline \"calm.json\"; no new collision }\n  statement slow",
    );
    fs::write(at("mixed.suite"), SUITE).unwrap();
    let saved = scenario_runner(folder.path(), &["baseline", "save", "mixed.suite", "--out", "calm.json"]);
    assert_eq!(code(&saved), 0, "{}", stderr(&saved));
    fs::write(at("mixed.suite"), gated).unwrap();
    let [whole, counted] = both(folder.path(), &[]);
    assert_eq!(counted, whole);
    assert!(counted.1.contains("calm"), "{}", counted.1);
}
