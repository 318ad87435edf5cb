//! `scenario-runner replay KEY`: one run again, with its event timeline.

use std::fs;
use std::io;
use std::path::PathBuf;

use clap::Args;

use super::Exit;
use super::load;
use super::record::{Recorded, record};
use crate::dispatch::Prepared;
use crate::plan::Plan;
use crate::report::{render_replay, write_trace};
use crate::run::{FreeFlows, Requests};
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
    let loaded = match load::load_all(&files.iter().collect::<Vec<_>>(), arguments.seed, false) {
        Ok(loaded) => loaded,
        Err(exit) => return exit,
    };
    match find(&loaded, &arguments.key) {
        Ok((plan, case)) => replay_case(arguments, plan, case),
        Err(nearest) => {
            eprintln!("error: no run is called `{}`", arguments.key);
            if let Some(key) = nearest {
                eprintln!("help: the nearest name is `{key}`");
            }
            Exit::NothingSelected
        }
    }
}

fn replay_case(arguments: &ReplayArguments, plan: &Plan, case: &Case) -> Exit {
    let mut requests = Requests::defaults();
    plan.trials.iter().for_each(|trial| requests.include(&trial.criteria));
    let Recorded { outcome, trace, events } = match record(case, &requests, &FreeFlows::default()) {
        Ok(recorded) => recorded,
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
    match &arguments.fingerprint {
        Some(expected) if *expected != format!("{:016x}", outcome.fingerprint) => {
            eprintln!("error: this is not the run that had fingerprint {expected}");
            eprintln!("help: the files, the seed or the version of scenario-runner have changed since");
            Exit::Failed
        }
        Some(_) => {
            println!("  the same run, bit for bit");
            Exit::Success
        }
        None => Exit::Success,
    }
}

fn default_file(key: &str) -> Option<String> {
    let path = format!("suites/{}.suite", key.split('/').next()?);
    fs::exists(&path).ok()?.then_some(path)
}

/// The case of that key with its plan, or else the nearest key there is.
fn find<'a>(loaded: &'a [Prepared], key: &str) -> Result<(&'a Plan, &'a Case), Option<&'a str>> {
    let cases = || {
        loaded.iter().flat_map(|suite| {
            suite.plan.trials.iter().flat_map(|trial| trial.cases.iter().map(|case| (&suite.plan, case)))
        })
    };
    cases().find(|(_, case)| case.key == key).ok_or_else(|| {
        let similarity = |known: &str| (strsim::normalized_levenshtein(known, key) * 1e6) as u64;
        cases().map(|(_, case)| case.key.as_str()).max_by_key(|known| similarity(known))
    })
}
