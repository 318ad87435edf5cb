//! A run whose reports do not name every trial holds only what did not pass: it must say, remember and end the same.

use std::fs;
use std::path::Path;
use std::process::Output;

use numbers::random::Stream;
use scenario_runner::results::{Overall, Unheard, Verdict};
use scenario_runner::{Memory, Project, Selection, Session, models, report};

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
  statement slow { claim mean(time_lost) of few <= 1 s }
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

/// Claims of all kinds about metrics of all families.
const CLAIMS: [&str; 18] = [
    "no collision",
    "impact_speed <= 3 m/s undefined passes",
    "pet >= 1 s",
    "pet_area >= 1 s undefined passes",
    "rate(gap_accepted) >= 50 %",
    "min(tta_at_entry) >= 1 s",
    "min_ttc >= 1 s undefined passes in 70 % of runs",
    "min_distance >= 1 m",
    "drac <= 5 m/s^2 undefined passes",
    "max_deceleration <= 2 m/s^2",
    "rate(sudden_speed_change) <= 20 %",
    "max_jerk <= 5 m/s^3",
    "mean(rms_jerk) <= 1 m/s^3",
    "mean(time_lost) <= 2 s",
    "travel_time <= 8 s",
    "max(stopped_time) <= 1 s",
    "crossing_duration <= 4 s undefined passes",
    "max_jerk(window: 0.4 s) <= 5 m/s^3",
];

fn claiming(claims: &str) -> Project {
    let text = format!(
        "\
suite claims {{
  scenario braking {{
    road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
    vehicle av {{ controller yielding; start 40 m before crossing; speed 40 km/h }}
    pedestrian walker {{ model scripted; start 1 m from kerb; appears at late }}
    vary late in [0 s, 0.8 s, 1.6 s, 2.4 s, 3.2 s, 6 s]
    horizon 7 s
    expect {{ {claims} }}
  }}
}}
"
    );
    let files = Memory::default().with("claims.suite", text.as_str());
    Project::open("claims.suite", &models::standard(), &files)
        .unwrap_or_else(|error| panic!("{claims}: {error}"))
}

/// Whatever is claimed, what is said of runs of which nothing else was measured is what is said of those with every metric.
#[test]
fn what_is_said_with_fewer_metrics_is_what_is_said_with_all() {
    let mut stream = Stream::seeded(2);
    let (mut failed, mut passed) = (0, 0);
    for round in 0..60 {
        let mut some = vec![CLAIMS[round % CLAIMS.len()]];
        // Each alone first: then nothing is measured that another asks for.
        let others = if round < CLAIMS.len() { 0 } else { stream.index(3) };
        some.extend((0..others).map(|_| CLAIMS[stream.index(CLAIMS.len())]));
        some.dedup();
        let project = claiming(&some.join("; "));
        let session = |every: bool| {
            let session = Session::new(&project).courses(false).every_trial(every);
            session.run(&Selection::all(), &mut Unheard).unwrap()
        };
        let (mut whole, mut asked) = (session(true), session(false));
        let measured = asked.requests.iter().count();
        // The time between bodies is measured beside that between centres.
        let beside = usize::from(some.iter().any(|claim| claim.contains("pet ")));
        assert!((1..=some.len() + beside).contains(&measured), "{some:?}: {measured} metrics");
        let places: Vec<usize> =
            asked.requests.iter().map(|one| whole.requests.index(one).unwrap()).collect();
        assert!(places.is_sorted(), "the order of columns is another");
        let (whole, asked) = (whole.suites.remove(0), asked.suites.remove(0));
        assert_eq!(asked.trials.len(), whole.trials.len());
        for (few, all) in asked.trials.iter().zip(&whole.trials) {
            assert_eq!(few.state, all.state, "{some:?}");
            for (few, all) in few.outcomes.iter().zip(&all.outcomes) {
                for (index, place) in places.iter().enumerate() {
                    let bits = |value: &Option<f64>| value.map(f64::to_bits);
                    assert_eq!(bits(&few.metrics[index]), bits(&all.metrics[*place]), "{some:?}");
                    assert_eq!(few.critical.get(index), all.critical.get(*place), "{some:?}");
                    assert_eq!(few.open(index), all.open(*place), "{some:?}");
                }
                assert_eq!((few.fingerprint, few.ending), (all.fingerprint, all.ending));
                assert_eq!(few.hides_meetings(), all.hides_meetings());
            }
            match few.verdict() {
                Some(Verdict::Failed) => failed += 1,
                Some(Verdict::Passed) => passed += 1,
                _ => {}
            }
        }
    }
    assert!(failed > 20 && passed > 20, "{failed} failed, {passed} passed");
}
