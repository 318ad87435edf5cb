//! Executors change nothing: trials, searches, tunes, evaluations, gates and shrinking come to the same, byte for byte, on any
//! number of threads, whatever comes first, in any order of completion, and through bytes as to and from other processes; errors and panics,
//! too. So do the suites that ship, to the committed fingerprint.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use files::Disk;
use models::standard;
use results::judge::per_run;
use results::{TrialState, Unheard, Verdict};
use runner::plan::plan;
use runner::project::{PlannedSuite, Project};
use runner::run::{Executor, Serialised, Shuffled, Stop, Threads, note_places};
use runner::session::{Orders, Runner, judge_gates, measured_trials, units};
use runner::shrink::{KnobPlace, shrink};
use scenario::registry::Registry;
use scenario::{Chance, CommandKind, ControllerModel, Declaration, Dimension, Parameter};
use serde_json::Value;
use sim::{Command, Controller, ControllerError, Observation, Schedule};

/// Keeps its speed until it cannot decide any more.
struct Frail {
    /// s
    from: f64,
    panics: bool,
}

impl Controller for Frail {
    fn schedule(&self) -> Schedule {
        Schedule::every(0.1)
    }

    fn act(&mut self, seen: &Observation) -> Result<Command, ControllerError> {
        let over = seen.time >= self.from;
        assert!(!(over && self.panics), "nothing is left at {} s", seen.time);
        match over {
            true => Err(ControllerError::with_hint("lane is None", "give it a map")),
            false => Ok(Command::Acceleration(0.0)),
        }
    }
}

fn registry() -> Registry {
    let declaration = Declaration::new("frail", "Cannot decide from some time on.")
        .source("a test")
        .number("from", Dimension::TIME, 1000.0, (0.0, 1000.0), "When it cannot decide any more.")
        .with(Parameter::flag("panics", false, "Whether that is a bug.", "a test"));
    let frail = ControllerModel::new(declaration, CommandKind::Acceleration, |context| {
        // In free flow it can always decide.
        let alone = context.world.pedestrians.is_empty();
        let from = if alone { f64::INFINITY } else { context.settings.number("from") };
        Ok(Box::new(Frail { from, panics: context.settings.flag("panics") }))
    });
    standard().with_controller(frail.chance(Chance::Never)).expect("a controller more")
}

/// Trials of fixed and of open length, what builds on them and on each other, and a gate.
const SUITE: &str = r#"suite everything {
  seed 20261122
  scenario walker {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller carla_behavior; speed 30 km/h }
    pedestrian walker {
      model carla_walker
      start 2 m from kerb
      appears when time_to_arrival(av) = tta
    }
    vary tta in [3 s, 4 s, 5 s]
    repeat 4
    expect { max_deceleration <= 2 m/s^2; no collision }
  }
  scenario open {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller carla_behavior; speed 30 km/h }
    pedestrian walker {
      model carla_walker
      start 2 m from kerb
      appears when time_to_arrival(av) = tta
    }
    vary tta in [3 s, 12 s]
    runs 10 .. 40
    expect { rate(pet > 0.1 s) >= 50 % with 95 % confidence; rate(pet > 2 s) <= 50 % with 95 % confidence }
  }
  gate braking {
    baseline "everything.json"
    max_deceleration not worse by more than 5 % with 95 % confidence
    min_distance not worse by more than 5 % with 95 % confidence
  }
}
search found {
  in walker
  minimise pet
  over tta in 3 s .. 9 s
  repeat 2
  budget 6 evaluations, 3 random first
}
tune good {
  on found
  over av.controller.braking_distance in 4 m .. 12 m
  minimise mean(time_lost)
  subject to max_deceleration <= 3 m/s^2
  stop early
  budget 5 evaluations, 3 random first
  compare with default
}
evaluate both {
  on walker
  with default, good
}
statement slower {
  claim mean(pet) of walker > 0 s
}
"#;

/// Trials that err or panic at some moment, and such as no run begins of.
const BROKEN: &str = r#"suite broken {
  seed 20261123
  scenario errs {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller frail { from: moment }; speed 30 km/h; start 50 m before crossing }
    pedestrian walker { model scripted; start 2 m from kerb; appears at 1 s }
    vary moment in [0.35 s, 2 s, 1000 s]
    repeat 3
    expect { no collision }
  }
  scenario panics {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller frail { from: moment, panics: true }; speed 30 km/h; start 50 m before crossing }
    pedestrian walker { model scripted; start 2 m from kerb; appears at 1 s }
    vary moment in [0.35 s, 2 s, 1000 s]
    repeat 3
    expect { no collision }
  }
  scenario refused {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller constant_speed; speed 30 km/h; start 50 m before crossing }
    pedestrian walker {
      model jaywalker { stop_time_min: least, stop_time_max: 300 ms }
      start 2 m from kerb
      appears at 1 s
    }
    vary least in [200 ms, 400 ms]
    repeat 3
    expect { no collision }
  }
}
"#;

fn prepared(folder: &Path) -> [PlannedSuite; 2] {
    ["everything.suite", "broken.suite"].map(|file| {
        let suite = lang::load(&folder.join(file), &registry(), &Disk)
            .unwrap_or_else(|failure| panic!("{}", failure.render(lang::Style::default())))
            .suite;
        let plan = plan(&suite).unwrap();
        PlannedSuite { file: file.into(), suite, plan, recorded: Vec::new() }
    })
}

/// Without what depends on the clock.
fn timeless(value: &mut Value) {
    match value {
        Value::Object(members) => {
            members.retain(|name, _| !matches!(name.as_str(), "wall_time" | "started"));
            members.values_mut().for_each(timeless);
        }
        Value::Array(items) => items.iter_mut().for_each(timeless),
        _ => {}
    }
}

/// Everything that is chosen, held to the end.
fn orders<'o>(chosen: &'o [bool], first: &'o [bool]) -> Orders<'o> {
    Orders {
        chosen,
        first,
        max_failures: None,
        every_trial: true,
        memory: None,
        lenient: false,
        pilot: false,
    }
}

/// Everything that the suite comes to, and what its first failing run shrinks to; `is_first` says of each unit whether it comes before those
/// that do not.
fn run_by(executor: &dyn Executor, folder: &Path, is_first: fn(usize) -> bool) -> (String, String) {
    let suites = prepared(folder);
    let session = Runner::new(&suites, executor, &registry()).journals(folder.join("journal"));
    let units = units(&suites);
    let chosen = vec![true; units.len()];
    let first: Vec<bool> = (0..units.len()).map(is_first).collect();
    let mut reports = session.run(&units, &orders(&chosen, &first), &mut Unheard);
    let baseline = folder.join("everything.json");
    if !baseline.exists() {
        let trials: Vec<_> = reports[0].trials.iter().collect();
        fs::write(&baseline, measured_trials(&session, 0, &trials).unwrap().text()).unwrap();
    }
    judge_gates(&session, &mut reports, false, &mut results::Unheard);
    let failing = reports[0].trials.iter().find_map(|trial| match &trial.state {
        TrialState::Judged(judged) if judged.verdict == Verdict::Failed => Some((trial, &judged.findings)),
        _ => None,
    });
    let (trial, findings) = failing.expect("some trial fails");
    let (at, finding) =
        findings.iter().enumerate().find(|(_, finding)| finding.verdict == Verdict::Failed).unwrap();
    let outcome = trial.outcomes.iter().find(|one| one.key == finding.worst[0].key).unwrap();
    let place = KnobPlace {
        scenario: suites[0].suite.scenario(&trial.trial.scenario).unwrap().clone(),
        variation: trial.trial.variation.clone(),
        individuals: outcome.individuals.clone(),
        key: outcome.key.clone(),
        seed: outcome.seed,
    };
    let criterion = per_run(&trial.trial.criteria[at]).expect("a single run may speak against it");
    let shrunk = shrink(place, &criterion, &registry(), executor, &Stop::default(), &mut |_, _| ()).unwrap();
    let shrunk = format!("{:?} {:?} {:x}", shrunk.moves, shrunk.left_out, shrunk.outcome.fingerprint);
    let mut all = serde_json::to_value(&reports).unwrap();
    timeless(&mut all);
    (serde_json::to_string_pretty(&all).unwrap(), shrunk)
}

#[test]
fn executors_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let text = SUITE.replace("\"everything.json\"", &format!("{:?}", folder.path().join("everything.json")));
    fs::write(folder.path().join("everything.suite"), text).unwrap();
    fs::write(folder.path().join("broken.suite"), BROKEN).unwrap();
    note_places();
    let (alone, shrunk) = run_by(&Threads::new(1), folder.path(), |_| false);
    assert!(!shrunk.starts_with("[]"), "something is moved: {shrunk}");
    for word in
        ["\"decided\"", "\"budget\"", "\"search\"", "\"tune\"", "\"evaluate\"", "\"statement\"", "\"gates\""]
    {
        assert!(alone.contains(word), "there is no {word} in the results");
    }
    for words in
        ["`av` cannot decide at 2 s: lane is None", "nothing is left at 2 s", "is above `stop_time_max`"]
    {
        assert!(alone.contains(words), "nothing says {words:?} in the results");
    }
    let threads =
        |threads| (format!("{threads} threads"), Box::new(Threads::new(threads)) as Box<dyn Executor>);
    let shuffled = |seed| (format!("order {seed}"), Box::new(Shuffled::seeded(seed)) as Box<dyn Executor>);
    let serialised: [(String, Box<dyn Executor>); 2] = [
        ("bytes".into(), Box::new(Serialised::new(Threads::new(2), registry()))),
        ("bytes in another order".into(), Box::new(Serialised::new(Shuffled::seeded(3), registry()))),
    ];
    let executors = [2, 16].map(threads).into_iter().chain((0..3).map(shuffled)).chain(serialised);
    let firsts: [fn(usize) -> bool; 3] = [|_| false, |unit| unit % 2 == 1, |unit| unit > 6];
    for ((name, executor), is_first) in executors.zip(firsts.into_iter().cycle()) {
        let (all, same) = run_by(&*executor, folder.path(), is_first);
        let differing = alone.lines().zip(all.lines()).find(|(left, right)| left != right);
        assert_eq!(differing, None, "with {name}");
        assert!(alone == all && shrunk == same, "with {name}");
    }
}

/// Every run of a suite that ships, and each of its blocks, with its fingerprint.
fn fingerprints(executor: &dyn Executor, file: &str) -> BTreeMap<String, u64> {
    let project =
        Project::open(Path::new(file), &standard(), &Disk).unwrap_or_else(|error| panic!("{error}"));
    let session = Runner::new(project.suites(), executor, &standard());
    let units = units(project.suites());
    let chosen = vec![true; units.len()];
    let reports = session.run(&units, &orders(&chosen, &[]), &mut Unheard).remove(0);
    let runs = reports.trials.iter().flat_map(|trial| &trial.outcomes);
    let runs = runs.map(|outcome| (outcome.key.to_string(), outcome.fingerprint));
    let blocks = reports.blocks.iter().map(|block| {
        let result = block.result().unwrap_or_else(|| panic!("{} comes to nothing", block.key));
        (block.key.to_string(), result.fingerprint())
    });
    runs.chain(blocks).collect()
}

/// Those that are committed. What differs between targets is compared where it was recorded.
fn committed(file: &str) -> BTreeMap<String, u64> {
    let target = format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS);
    let path = Path::new("tests/fingerprints").join(target).join(format!("{}.txt", file.replace('/', "-")));
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let line = |line: &str| {
        let (bits, key) = line.split_once(' ').expect("a fingerprint and a name");
        (key.to_string(), u64::from_str_radix(bits, 16).expect("hexadecimal digits"))
    };
    text.lines().map(line).filter(|(key, _)| !key.starts_with("metric ")).collect()
}

#[test]
#[cfg_attr(
    not(all(target_arch = "x86_64", target_os = "linux")),
    ignore = "nothing is recorded for this target"
)]
fn suites_that_ship_keep_their_bits_over_threads_and_orders() {
    let suites = [
        "zebra",
        "zebra_unsafe",
        "un_r152",
        "fmvss_127",
        "un_r157",
        "euro_ncap_vru",
        "euro_ncap_robustness",
        "streets",
        "matrix",
        "nhtsa_precrash",
    ];
    // `tests/suites.rs` makes the same runs with a thread for each core.
    let threads = [1, 3, 16];
    let compare = |name: &str, executor: &dyn Executor, suite: &str| {
        let file = format!("suites/{suite}.suite");
        let (found, kept) = (fingerprints(executor, &file), committed(&file));
        assert!(!kept.is_empty() && found == kept, "{file} with {name}");
    };
    for (suite, threads) in suites.iter().zip(threads.into_iter().cycle()) {
        compare(&format!("{threads} threads"), &Threads::new(threads), suite);
        compare("a random order", &Shuffled::seeded(11), suite);
    }
}
