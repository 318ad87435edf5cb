//! The reports of a session that go elsewhere than to the terminal.

use std::collections::HashMap;
use std::env;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use rayon::prelude::*;

use crate::cli::record::record;
use crate::dispatch::Workshop;
use crate::report::{
    Chosen, Recording, SuiteReport, annotations, choose_runs, step_summary, to_html, to_json, to_junit,
    to_tap,
};
use crate::run::Outcome;
use crate::scenario::Case;

#[derive(Debug, Args)]
pub struct OutputArguments {
    /// Write a JUnit XML report.
    #[arg(long, value_name = "PATH")]
    junit: Option<PathBuf>,

    /// Write all results as JSON.
    #[arg(long, value_name = "PATH")]
    json: Option<PathBuf>,

    /// Write a TAP 14 report.
    #[arg(long, value_name = "PATH")]
    tap: Option<PathBuf>,

    /// Print GitHub annotations and append to the step's summary [default: in GitHub Actions only].
    #[arg(long)]
    github: bool,

    /// Write one HTML file with tables, charts and animations of the worst runs.
    #[arg(long, value_name = "PATH")]
    html: Option<PathBuf>,
}

/// Writes whatever was asked for, and returns what could not be written.
pub fn write(arguments: &OutputArguments, workshop: &Workshop, reports: &[SuiteReport]) -> Vec<String> {
    let mut complaints = Vec::new();
    let mut write = |path: &Option<PathBuf>, content: &dyn Fn() -> Result<String, String>| {
        let Some(path) = path else { return };
        let written = content().and_then(|text| save(path, &text).map_err(|error| error.to_string()));
        if let Err(error) = written {
            complaints.push(format!("cannot write {}: {error}", path.display()));
        }
    };
    let requests = workshop.requests();
    write(&arguments.junit, &|| to_junit(reports, requests).map_err(|error| error.to_string()));
    write(&arguments.json, &|| Ok(to_json(reports, requests)));
    write(&arguments.tap, &|| Ok(to_tap(reports)));
    write(&arguments.html, &|| html(workshop, reports));
    if arguments.github || env::var_os("GITHUB_ACTIONS").is_some_and(|value| value == "true") {
        complaints.extend(tell_github(workshop, reports));
    }
    complaints
}

/// Annotations go to stdout; the summary goes to the file that GitHub names.
fn tell_github(workshop: &Workshop, reports: &[SuiteReport]) -> Option<String> {
    // A closed pipe is the reader's choice, not an error.
    let _ = io::stdout().write_all(annotations(reports).as_bytes());
    let path = env::var_os("GITHUB_STEP_SUMMARY").filter(|path| !path.is_empty())?;
    let summary = step_summary(reports, workshop.requests());
    let opened = fs::OpenOptions::new().create(true).append(true).open(&path);
    let error = opened.and_then(|mut file| file.write_all(summary.as_bytes())).err()?;
    Some(format!("cannot write {}: {error}", Path::new(&path).display()))
}

/// The HTML report, for which some runs are run again to record their course.
fn html(workshop: &Workshop, reports: &[SuiteReport]) -> Result<String, String> {
    let chosen = reports
        .iter()
        .enumerate()
        .flat_map(|(suite, report)| choose_runs(report).into_iter().map(move |chosen| (suite, chosen)));
    let chosen: Vec<_> = chosen.collect();
    let outcomes: HashMap<&str, (&Case, &Outcome)> = reports
        .iter()
        .flat_map(|report| &report.trials)
        .flat_map(|trial| trial.trial.cases.iter().zip(&trial.outcomes))
        .map(|(case, outcome)| (case.key.as_str(), (case, outcome)))
        .collect();
    let again = |(suite, chosen): (usize, Chosen)| {
        let (case, outcome) = outcomes[chosen.key.as_str()];
        let recorded = record(case, workshop.requests(), workshop.free_flows(suite))
            .map_err(|error| error.to_string())?;
        if recorded.outcome.fingerprint != outcome.fingerprint {
            return Err(format!("{} went differently when it was repeated: please report this", case.key));
        }
        Ok((chosen, Recording::new(case, &recorded.trace, recorded.events)))
    };
    let recordings: Vec<_> = chosen.into_par_iter().map(again).collect::<Result<_, String>>()?;
    Ok(to_html(reports, workshop.requests(), &recordings))
}

/// Writes a file, making the folders it is to be in.
fn save(path: &Path, text: &str) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::write(path, text)
}
