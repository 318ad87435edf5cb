//! `scenario-runner replay KEY`: one run again, with its event timeline, and whether it is the same run.

use std::path::{Path, PathBuf};

use clap::Args;

use super::Exit;
use super::one_case::{CaseArguments, FoundCase, could_not_run};
use super::run::LastRun;
use super::run::watch::Columns;
use files::WholeFile;
use report::console::{stderr, stdout};
use report::{ReplayIntroduction, render_replay, replay_reasons, write_trace_with};
use runner::corpus::{case_hash, corpus_path};
use runner::run::{MeasuredMetrics, Ran, RunBatch, Stop, Wanted, WentDifferently, went_differently};
use scenario::registry::Registry;

#[derive(Debug, Args)]
pub struct ReplayArguments {
    #[command(flatten)]
    case: CaseArguments,

    /// Fail unless the run has this fingerprint.
    #[arg(long, value_name = "HEX")]
    fingerprint: Option<String>,

    /// Write the course of the run as CSV into this file.
    #[arg(long, value_name = "PATH")]
    trace: Option<PathBuf>,

    /// What `--trace` writes of everybody: with `full` also how far along the road from the crossing, how far beside the centre line
    /// of lane 0, and where they face.
    #[arg(long, value_enum, value_name = "COLUMNS", default_value_t = Columns::Plain, requires = "trace")]
    trace_columns: Columns,
}

pub fn replay(arguments: &ReplayArguments, registry: &Registry) -> Exit {
    let replayed = arguments.case.load("replay", registry).and_then(|project| {
        let found = arguments.case.find(project.suites())?;
        replay_case(arguments, &found, registry)
    });
    replayed.unwrap_or_else(|exit| exit)
}

/// What the run is expected to be.
struct Expected {
    fingerprint: String,
    /// Of the case, where that is known.
    case: Option<String>,
    /// Where that is from, to be put after `as`.
    source: String,
}

fn replay_case(arguments: &ReplayArguments, found: &FoundCase, registry: &Registry) -> Result<Exit, Exit> {
    let FoundCase { suite, case, .. } = found;
    let (threads, measured, stop) = (
        arguments.case.run.programs.threads(Some(1), [&suite.suite])?,
        MeasuredMetrics::new(found.requests(registry)),
        Stop::default(),
    );
    let batch = RunBatch { executor: &threads, measured: &measured, stop: &stop };
    let runs = batch
        .one(case, Wanted::TraceAndEvents)
        .and_then(|ran| Ok((ran, batch.one(case, Wanted::Outcome)?.outcome)));
    let (Ran { outcome, trace, events, .. }, again) = match runs {
        Ok(runs) => runs,
        Err(error) => {
            return Ok(could_not_run(&error));
        }
    };
    let requests = &measured.requests;
    let reasons = replay_reasons(&found.criteria, &outcome, requests);
    let introduction = ReplayIntroduction { values: found.values(), reasons };
    write!(stdout(), "{}", render_replay(case, &introduction, &outcome, &events, requests));
    if let Some(path) = &arguments.trace {
        let written = WholeFile::create(path).and_then(|mut file| {
            write_trace_with(&case.world, &trace, arguments.trace_columns.into(), &mut file)?;
            file.commit()
        });
        if let Err(error) = written {
            writeln!(stderr(), "error: cannot write {}: {error}", path.display());
            return Ok(Exit::Output);
        }
    }
    if again.fingerprint != outcome.fingerprint {
        match went_differently(case) {
            WentDifferently::Bug(reason) => {
                writeln!(stderr(), "error: {reason}");
                return Ok(Exit::Failed);
            }
            WentDifferently::Program(reason) => writeln!(stderr(), "warning: {reason}"),
            WentDifferently::Known => {}
        }
        writeln!(stdout(), "  run twice: not the same; what is shown here may not come out the same again");
        let is_it = |wanted: &String| {
            let wanted = wanted.strip_prefix("0x").unwrap_or(wanted);
            [again.fingerprint, outcome.fingerprint].map(hexadecimal).iter().any(|one| one == wanted)
        };
        let is_asked_for = arguments.fingerprint.as_ref().is_none_or(is_it);
        return Ok(if is_asked_for { Exit::Success } else { Exit::Failed });
    }
    let fingerprint = hexadecimal(outcome.fingerprint);
    match expected(arguments, found) {
        None => writeln!(stdout(), "  run twice: the same, bit for bit"),
        Some(expected) if expected.fingerprint == fingerprint => {
            writeln!(stdout(), "  the same run, bit for bit, as {}", expected.source);
        }
        Some(Expected { case: Some(was), source, .. }) if was != hexadecimal(case_hash(case)) => {
            writeln!(
                stdout(),
                "  run twice: the same, bit for bit; but not as {source}: the case has changed since"
            );
        }
        Some(Expected { fingerprint: was, source, .. }) => {
            writeln!(stderr(), "error: this is not the same run as {source}, which had fingerprint {was}");
            writeln!(
                stderr(),
                "help: the files, the seed or the version of scenario-runner have changed since"
            );
            return Ok(Exit::Failed);
        }
    }
    Ok(Exit::Success)
}

/// What is known of the run: what the user says, what was recorded, or what the last session saw.
fn expected(arguments: &ReplayArguments, FoundCase { suite, case, .. }: &FoundCase) -> Option<Expected> {
    if let Some(fingerprint) = &arguments.fingerprint {
        let source = "the one that was asked for".to_string();
        // As `--csv` writes it.
        let fingerprint = fingerprint.strip_prefix("0x").unwrap_or(fingerprint).to_string();
        return Some(Expected { fingerprint, case: None, source });
    }
    let own = suite.suite.own_key(&case.key);
    let is_it = |key: &str, unit_key: String| own == key || own == unit_key;
    let mut recorded = suite.recorded.iter().filter(|one| is_it(&one.key, one.unit_key()));
    if let Some(recorded) = recorded.find(|one| one.seed == case.seed) {
        let source = format!("the one recorded in {}", corpus_path(Path::new(&suite.file)).display());
        let fingerprint = hexadecimal(recorded.fingerprint);
        return Some(Expected { fingerprint, case: Some(hexadecimal(recorded.case)), source });
    }
    let seen = LastRun::read().seen(suite, &case.key, case.seed)?.clone();
    let source = "when its suite was last run".to_string();
    Some(Expected { fingerprint: seen.fingerprint, case: Some(seen.case), source })
}

fn hexadecimal(number: u64) -> String {
    format!("{number:016x}")
}
