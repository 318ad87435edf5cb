//! `scenario-runner why KEY`: the story of a run, and what would have come of it had something gone otherwise.

use std::path::PathBuf;

use clap::Args;

use super::Exit;
use super::one_case::{CaseArguments, FoundCase, could_not_run};
use files::escape::shell_path;
use report::console::{stderr, stdout, takes_blocks};
use report::{WhyRun, read_results, render_moment, render_why, why_json};
use results::judge::nearest_passing;
use runner::run::{MeasuredMetrics, RunBatch, Stop};
use runner::why::story;
use scenario::registry::Registry;

/// The story of a run, and what would have come of it had something gone otherwise
///
/// Tells in ten to twenty lines who was shown whom when, what everybody did, how the run stands to each criterion and by how much. Of a
/// run that speaks against a criterion, or in which a vehicle touched something, it also tells what would have come of it: with the
/// vehicle braking 0.5 s earlier or decelerating evenly, with the person 0.2 s later, with no pedestrian there. Each of these is a run of its own, in which
/// everybody reacts as they do on the same noise. Programs that decide in it run in each of them, with the permission that `replay`
/// needs.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  scenario-runner why zebra/late/tta=6s/individual=17/rep=2        of suites/zebra.suite
  scenario-runner why walk/walk/rep=3 walk.scn                     of that file
  scenario-runner why KEY --among results.json                     with the nearest run that passed, of those results
  scenario-runner why KEY --json                                   as JSON

Exit codes: 0 told, whether the run passes or not, 3 the files have errors, 4 no such run, 100 it does not come to its end")]
pub struct WhyArguments {
    #[command(flatten)]
    case: CaseArguments,

    /// Results that a run wrote with `--json`: the nearest run that passed is looked for in them.
    #[arg(long, value_name = "RESULTS")]
    among: Option<PathBuf>,

    /// Say it as JSON, with all events and every deceleration that was tried.
    #[arg(long)]
    json: bool,
}

pub fn why(arguments: &WhyArguments, registry: &Registry) -> Exit {
    let told = arguments.case.load("why", registry).and_then(|project| {
        let found = arguments.case.find(project.suites())?;
        tell(arguments, &found, registry)
    });
    told.unwrap_or_else(|exit| exit)
}

fn tell(arguments: &WhyArguments, found: &FoundCase, registry: &Registry) -> Result<Exit, Exit> {
    let FoundCase { suite, case, criteria } = found;
    let results = arguments.among.as_ref().map(|path| {
        read_results(path, registry).map_err(|error| {
            writeln!(stderr(), "error: cannot read {}: {error}", path.display());
            let file = shell_path(&suite.file);
            writeln!(stderr(), "help: `--among` takes what `scenario-runner {file} --json` wrote");
            Exit::Usage
        })
    });
    let results = results.transpose()?;
    let threads = arguments.case.run.programs.threads(Some(1), [&suite.suite])?;
    let (measured, stop) = (MeasuredMetrics::new(found.requests(registry)), Stop::default());
    let batch = RunBatch { executor: &threads, measured: &measured, stop: &stop };
    let story = match story(batch, case, criteria) {
        Ok(story) => story,
        Err(error) => return Ok(could_not_run(&error)),
    };
    let unknown = match &results {
        Some(_) => format!("none of `{}` in those results", case.scenario),
        None => {
            let file = shell_path(&suite.file);
            format!("not known; `scenario-runner {file} --json results.json`, then `--among results.json`")
        }
    };
    let nearest = results.as_ref().and_then(|results| nearest_passing(results, case));
    let run = WhyRun {
        case,
        values: &found.values(),
        criteria,
        requests: &measured.requests,
        story: &story,
        nearest: nearest.as_ref().ok_or(&unknown),
    };
    if arguments.json {
        writeln!(stdout(), "{:#}", why_json(&run));
    } else {
        write!(stdout(), "{}", render_why(&run));
        if takes_blocks() {
            write!(stdout(), "{}", render_moment(&run));
        }
    }
    Ok(Exit::Success)
}
