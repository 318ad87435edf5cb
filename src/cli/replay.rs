//! `scenario-runner replay KEY`: one run again, with its event timeline, and whether it is the same run.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use clap::Args;

use super::Exit;
use super::load;
use super::record::{Recorded, record};
use super::run::LastRun;
use crate::corpus::{case_hash, corpus_path};
use crate::dispatch::{Prepared, Work, units};
use crate::report::{render_replay, write_trace};
use crate::run::{FreeFlows, Requests, Unwatched, run_case};
use crate::scenario::Case;

#[derive(Debug, Args)]
pub struct ReplayArguments {
    /// The run's key, as reports give it: `zebra/carla_walker/tta=6s/rep=2`.
    key: String,

    /// The suite or scenario it belongs to [default: the files in suites/ whose name is the key's first part].
    #[arg(value_name = "FILE")]
    files: Vec<String>,

    /// Replaces the seed of the suite.
    #[arg(long, value_name = "SEED")]
    seed: Option<u64>,

    /// Fail unless the run has this fingerprint.
    #[arg(long, value_name = "HEX")]
    fingerprint: Option<String>,

    /// Write the course of the run as CSV into this file.
    #[arg(long, value_name = "PATH")]
    trace: Option<PathBuf>,
}

pub fn replay(arguments: &ReplayArguments) -> Exit {
    let files = match &arguments.files[..] {
        [] => match default_file(&arguments.key) {
            Some(file) => vec![file],
            None => {
                eprintln!(
                    "error: no file is named, and there is no suite for `{}` in suites/",
                    arguments.key
                );
                eprintln!("help: name it, as in `scenario-runner replay KEY suites/zebra.suite`");
                return Exit::Usage;
            }
        },
        files => files.to_vec(),
    };
    let suites = match load::load_all(&files.iter().collect::<Vec<_>>(), arguments.seed, false) {
        Ok(suites) => suites,
        Err(exit) => return exit,
    };
    match find(&suites, &arguments.key) {
        Ok(found) => replay_case(arguments, &found),
        Err(NotFound::Stale(reason)) => {
            eprintln!("error: `{}` cannot be run any more: {reason}", arguments.key);
            Exit::NothingSelected
        }
        Err(NotFound::Nearest(nearest)) => {
            eprintln!("error: no run is called `{}`", arguments.key);
            if let Some(key) = nearest {
                eprintln!("help: the nearest name is `{key}`");
            }
            Exit::NothingSelected
        }
    }
}

/// A run that is to be replayed.
struct Found<'a> {
    suite: &'a Prepared,
    case: Case,
}

enum NotFound {
    /// It was recorded, but the files have nothing for it any more.
    Stale(String),
    Nearest(Option<String>),
}

/// What the run is expected to be.
struct Expected {
    fingerprint: String,
    /// Of the case, where that is known.
    case: Option<String>,
    /// Where that is from, to be put after `as`.
    source: String,
}

fn replay_case(arguments: &ReplayArguments, found: &Found) -> Exit {
    let Found { suite, case } = found;
    let mut requests = Requests::defaults();
    suite.plan.trials.iter().for_each(|trial| requests.include(&trial.criteria));
    let free_flows = FreeFlows::default();
    let runs = record(case, &requests, &free_flows)
        .and_then(|recorded| Ok((recorded, run_case(case, &requests, &free_flows, &mut Unwatched)?)));
    let (Recorded { outcome, trace, events }, again) = match runs {
        Ok(runs) => runs,
        Err(error) => {
            eprintln!("error: {}: {error}", case.key);
            return Exit::Scenario;
        }
    };
    print!("{}", render_replay(case, &outcome, &events, &requests));
    if let Some(path) = &arguments.trace {
        let written = fs::File::create(path)
            .and_then(|file| write_trace(&case.world, &trace, io::BufWriter::new(file)));
        if let Err(error) = written {
            eprintln!("error: cannot write {}: {error}", path.display());
            return Exit::Output;
        }
    }
    if again.fingerprint != outcome.fingerprint {
        eprintln!("error: it went differently when it was repeated: please report this");
        return Exit::Failed;
    }
    let fingerprint = hexadecimal(outcome.fingerprint);
    match expected(arguments, found) {
        None => println!("  run twice: the same, bit for bit"),
        Some(expected) if expected.fingerprint == fingerprint => {
            println!("  the same run, bit for bit, as {}", expected.source);
        }
        Some(Expected { case: Some(was), source, .. }) if was != hexadecimal(case_hash(case)) => {
            println!("  run twice: the same, bit for bit; but not as {source}: the case has changed since");
        }
        Some(Expected { fingerprint: was, source, .. }) => {
            eprintln!("error: this is not the same run as {source}, which had fingerprint {was}");
            eprintln!("help: the files, the seed or the version of scenario-runner have changed since");
            return Exit::Failed;
        }
    }
    Exit::Success
}

/// What is known of the run: what the user says, what was recorded, or what the last session saw.
fn expected(arguments: &ReplayArguments, Found { suite, case }: &Found) -> Option<Expected> {
    if let Some(fingerprint) = &arguments.fingerprint {
        let source = "the one that was asked for".to_string();
        return Some(Expected { fingerprint: fingerprint.clone(), case: None, source });
    }
    let is_it = |key: &str, unit_key: String| case.key == key || case.key == unit_key;
    let mut recorded = suite.recorded.iter().filter(|one| is_it(&one.key, one.unit_key()));
    if let Some(recorded) = recorded.find(|one| one.seed == case.seed) {
        let source = format!("the one recorded in {}", corpus_path(Path::new(&suite.file)).display());
        let fingerprint = hexadecimal(recorded.fingerprint);
        return Some(Expected { fingerprint, case: Some(hexadecimal(recorded.case)), source });
    }
    let seen = LastRun::read().runs.get(&LastRun::run_name(&case.key, case.seed))?.clone();
    let source = "when its suite was last run".to_string();
    Some(Expected { fingerprint: seen.fingerprint, case: Some(seen.case), source })
}

fn hexadecimal(number: u64) -> String {
    format!("{number:016x}")
}

fn default_file(key: &str) -> Option<String> {
    let path = format!("suites/{}.suite", key.split('/').next()?);
    fs::exists(&path).ok()?.then_some(path)
}

/// The case of that key with its suite: one of the plan, or a recorded one by the key of its unit.
fn find<'a>(suites: &'a [Prepared], key: &str) -> Result<Found<'a>, NotFound> {
    for unit in units(suites).iter().filter(|unit| unit.key == key) {
        if let Work::Recorded(recorded) = unit.work {
            let suite = &suites[unit.suite];
            let mut case =
                recorded.revive(&suite.suite).map_err(|stale| NotFound::Stale(stale.to_string()))?;
            case.key = key.to_string();
            return Ok(Found { suite, case });
        }
    }
    let cases = || {
        suites.iter().flat_map(|suite| {
            suite.plan.trials.iter().flat_map(move |trial| trial.cases.iter().map(move |case| (suite, case)))
        })
    };
    let found = cases().find(|(_, case)| case.key == key);
    found.map(|(suite, case)| Found { suite, case: case.clone() }).ok_or_else(|| {
        let similarity = |known: &str| (strsim::normalized_levenshtein(known, key) * 1e6) as u64;
        let nearest = cases().map(|(_, case)| case.key.as_str()).max_by_key(|known| similarity(known));
        NotFound::Nearest(nearest.map(str::to_string))
    })
}
