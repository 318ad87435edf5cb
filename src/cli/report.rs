//! `scenario-runner report`: reports of results that were written before.

use std::path::PathBuf;

use clap::Args;

use super::Exit;
use super::run::conduct::Colour;
use super::run::{exit, output};
use report::console::{stderr, stdout};
use report::{StatusLevel, Terminal, read_results, render_gates, render_ratings};
use scenario::registry::Registry;

/// Makes reports of results that a run wrote with `--json`. Nothing is run.
///
/// The reports are those that the run itself would have written, byte for byte, and the exit code is the one that it
/// earned by its verdicts. The terminal shows what it showed at its end: a line a unit, what did not pass and the summary. Results of version 0.1 have neither courses nor criteria, so their pages have fewer pictures;
/// those with searches, tunes or other blocks have to be run again.
#[derive(Debug, Args)]
pub struct ReportArguments {
    /// What `--json` wrote.
    #[arg(value_name = "RESULTS")]
    results: PathBuf,

    #[command(flatten)]
    output: output::OutputArguments,

    /// When to use colours.
    #[arg(long, value_enum, default_value_t = Colour::Auto)]
    color: Colour,
}

pub fn report(arguments: &ReportArguments, registry: &Registry) -> Exit {
    let path = arguments.results.to_string_lossy();
    if let Err(complaint) = super::run::targets::check(&arguments.output.files(), &[&path]) {
        writeln!(stderr(), "error: {complaint}");
        writeln!(stderr(), "help: name another file; nothing was written");
        return Exit::Usage;
    }
    let results = match read_results(&arguments.results, registry) {
        Ok(results) => results,
        Err(error) => {
            writeln!(stderr(), "error: cannot report {path}: {error}");
            return Exit::Usage;
        }
    };
    let colour = arguments.color.wanted(stdout());
    Terminal::new(StatusLevel::Pass, colour, None).tell_results(&results);
    stdout().styled(&render_ratings(&results.suites, colour));
    stdout().styled(&render_gates(&results.suites, colour));
    // The run has told GitHub already.
    let complaints = output::write(&arguments.output, &results, false);
    for complaint in &complaints {
        writeln!(stderr(), "error: {complaint}");
    }
    if results.suites.iter().any(|suite| suite.interrupted) {
        Exit::Interrupted
    } else if complaints.is_empty() {
        exit(results.overall())
    } else {
        Exit::Output
    }
}
