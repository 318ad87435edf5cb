//! `scenario-runner sketch FILE [NAME]`: a scenario from above, before it runs or at moments of its run.

use std::path::{Path, PathBuf};

use clap::Args;

use super::Exit;
use super::load;
use super::one_case::could_not_run;
use super::programs::ProgramArguments;
use super::set::SetArguments;
use report::Sketch;
use report::console::{stderr, stdout};
use results::Requests;
use runner::project::PlannedSuite;
use runner::run::{MeasuredMetrics, RunBatch, Stop, Wanted};
use scenario::Case;
use scenario::registry::Registry;

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  scenario-runner sketch scenarios/zebra.scn                 the first scenario, as text
  scenario-runner sketch suites/zebra.suite occluded -o o.svg that scenario, as a file for browsers
  scenario-runner sketch scenarios/zebra.scn --at 2.5s       runs it, and shows that moment
  scenario-runner sketch scenarios/zebra.scn --strip -o s.svg six moments of its run

Without --at and --strip nothing runs. What is said of courses that meet holds as long as all keep their speed.")]
pub struct SketchArguments {
    /// The suite (.suite) or scenarios (.scn, .yaml).
    file: String,

    /// Which one: a scenario, trial or run by its name, or the first whose name contains this [default: the first].
    name: Option<String>,

    /// Write an SVG file instead of text, for light and dark.
    #[arg(long, short = 'o', value_name = "PATH")]
    svg: Option<PathBuf>,

    /// Run it and draw this moment, such as `2.5s`; may be repeated.
    #[arg(long, value_name = "TIME", value_parser = seconds, conflicts_with = "strip")]
    at: Vec<f64>,

    /// Run it and draw six moments, from the first at which a pedestrian is there to the last at which a vehicle is near the crossing.
    #[arg(long)]
    strip: bool,

    /// Replaces the seed of the suite.
    #[arg(long, value_name = "SEED")]
    seed: Option<u64>,

    #[command(flatten)]
    set: SetArguments,

    #[command(flatten)]
    programs: ProgramArguments,
}

/// A time on the command line, s.
fn seconds(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let (number, factor) = match text.strip_suffix("ms") {
        Some(number) => (number, 1e-3),
        None => (text.strip_suffix('s').unwrap_or(text), 1.0),
    };
    let time = number.trim().parse::<f64>().map_err(|_| "a time is a number with s or ms, as in 2.5s")?;
    if (0.0..=1e6).contains(&time) { Ok(time * factor) } else { Err("a time is 0 s or more".to_string()) }
}

pub fn sketch(arguments: &SketchArguments, registry: &Registry) -> Exit {
    drawn(arguments, registry).unwrap_or_else(|exit| exit)
}

fn drawn(arguments: &SketchArguments, registry: &Registry) -> Result<Exit, Exit> {
    let colour = stderr().takes_colour();
    let files = [&arguments.file];
    let project = load::load_all(&files, arguments.seed, &arguments.set, colour, registry)?;
    let suite = &project.suites()[0];
    let (case, others) = find(suite, arguments.name.as_deref())?;
    if others > 1 {
        writeln!(
            stderr(),
            "note: {} is the first of {others} runs that are meant; name another to see it",
            case.key
        );
    }
    let sketch = if arguments.strip || !arguments.at.is_empty() {
        moments(arguments, suite, &case)?
    } else {
        Sketch::of(&case)
    };
    match &arguments.svg {
        None => {
            let (columns, rows) = terminal();
            write!(stdout(), "{}", sketch.to_text(columns, rows));
        }
        Some(path) => save(path, &sketch.to_svg())?,
    }
    Ok(Exit::Success)
}

fn save(path: &Path, svg: &str) -> Result<(), Exit> {
    files::write(path, svg).map_err(|error| {
        writeln!(stderr(), "error: cannot write {}: {error}", path.display());
        Exit::Output
    })
}

/// How large a terminal is, columns and rows; what is no terminal has no end of rows.
fn terminal() -> (usize, usize) {
    const USUAL: (usize, usize) = (100, 60);
    if !stdout().is_terminal() {
        return USUAL;
    }
    terminal_size::terminal_size().map_or(USUAL, |(columns, rows)| (columns.0.into(), rows.0.into()))
}

fn moments(arguments: &SketchArguments, suite: &PlannedSuite, case: &Case) -> Result<Sketch, Exit> {
    let threads = arguments.programs.threads(Some(1), [&suite.suite])?;
    let (measured, stop) = (MeasuredMetrics::new(Requests::default()), Stop::default());
    let batch = RunBatch { executor: &threads, measured: &measured, stop: &stop };
    let ran = batch.one(case, Wanted::Trace).map_err(|error| could_not_run(&error))?;
    let times = if arguments.strip { Sketch::strip(case, &ran.trace) } else { arguments.at.clone() };
    Sketch::of_moments(case, &ran.trace, &times).map_err(|error| {
        writeln!(stderr(), "error: {error}");
        writeln!(stderr(), "help: `--strip` draws moments up to its end");
        Exit::Usage
    })
}

/// The run that a name means, and how many it may mean. If there is none, says so on stderr.
fn find(suite: &PlannedSuite, name: Option<&str>) -> Result<(Case, usize), Exit> {
    let nothing = || {
        writeln!(stderr(), "error: nothing in {} can be drawn: it has no runs of its own", suite.file);
        Exit::NothingSelected
    };
    let all = || suite.plan.trials();
    let Some(name) = name.map(|name| suite.key_alone(name).unwrap_or(name)) else {
        let runs = all().map(|trial| trial.cases.len()).sum();
        let first = all().find(|trial| !trial.cases.is_empty()).ok_or_else(nothing)?;
        return Ok((first.cases.get(0), runs));
    };
    // A run by its whole key.
    for trial in all().filter(|trial| name.starts_with(&trial.key)) {
        let mut cases = (0..trial.cases.len()).map(|index| trial.cases.get(index));
        if let Some(case) = cases.find(|case| case.key == name) {
            return Ok((case, 1));
        }
    }
    let own = |scenario: &str| name == scenario || name == format!("{}/{scenario}", suite.suite.key_name());
    let ways: [&dyn Fn(&runner::plan::PlannedTrial) -> bool; 3] =
        [&|trial| trial.key == name, &|trial| own(&trial.scenario), &|trial| trial.key.contains(name)];
    for is_meant in ways {
        let mut meant = all().filter(|trial| is_meant(trial) && !trial.cases.is_empty());
        if let Some(first) = meant.next() {
            let runs = first.cases.len() + meant.map(|trial| trial.cases.len()).sum::<usize>();
            return Ok((first.cases.get(0), runs));
        }
    }
    writeln!(stderr(), "error: nothing in {} is called `{name}`", suite.file);
    let scenarios = suite.suite.scenarios.iter().map(|scenario| scenario.name.clone());
    let mut names: Vec<String> = scenarios.chain(all().map(|trial| trial.key.clone()).take(10_000)).collect();
    names.sort_by(|one, other| {
        let similarity = |known: &str| strsim::normalized_levenshtein(known, name);
        similarity(other).total_cmp(&similarity(one))
    });
    names.dedup();
    let nearest: Vec<String> = names.iter().take(3).map(|name| format!("`{name}`")).collect();
    if !nearest.is_empty() {
        writeln!(stderr(), "help: the nearest names are {}", nearest.join(", "));
    }
    Err(Exit::NothingSelected)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_seconds_unless_they_say_otherwise() {
        for (text, expected) in [("2.5s", 2.5), ("2.5 s", 2.5), ("250ms", 0.25), ("3", 3.0), ("0s", 0.0)] {
            assert_eq!(seconds(text), Ok(expected), "{text}");
        }
        for text in ["", "s", "soon", "-1s", "nan", "inf", "2.5 m"] {
            assert!(seconds(text).is_err(), "{text}");
        }
    }
}
