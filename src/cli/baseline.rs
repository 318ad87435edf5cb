//! `scenario-runner baseline save|show|diff`: what runs came to, as files to commit.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum};

use super::Exit;
use super::interrupt::stop_on_interrupt;
use super::programs::{ProgramArguments, VerifyArguments};
use super::set::SetArguments;
use super::{measured, project};
use report::console::{stderr, stdout};
use report::{Form, count, render_baseline, render_difference, render_sight};
use results::judge::gate::judge_gate;
use runner::baseline::measured_metrics;
use scenario::registry::Registry;

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  scenario-runner baseline save zebra.suite          record, where the suite's gates look for it
  scenario-runner baseline show zebra.json           every metric of every trial
  scenario-runner baseline diff old.json new.json    what is not the same

A baseline is a text file to commit. From then on `scenario-runner zebra.suite` judges the gates of
the suite against it. After a change that is meant to change something, record it anew.")]
pub struct BaselineArguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Run a suite and write every run's metrics, for gates and `compare` to compare with.
    Save {
        /// The suite or scenario.
        file: String,

        /// Where to write it [default: what the suite's gates name, else baselines/SUITE.json].
        #[arg(long, value_name = "PATH")]
        out: Option<PathBuf>,

        /// Replaces the seed of the suite.
        #[arg(long, value_name = "SEED")]
        seed: Option<u64>,

        #[command(flatten)]
        set: SetArguments,

        #[command(flatten)]
        programs: ProgramArguments,

        #[command(flatten)]
        verify: VerifyArguments,

        /// Replace the file also if it is no baseline, or one of another suite.
        #[arg(long)]
        force: bool,
    },
    /// Print what a baseline holds.
    Show {
        path: PathBuf,

        #[arg(long, value_enum, default_value_t = Format::Terminal)]
        format: Format,
    },
    /// Print what differs between two baselines, without a verdict; `compare` gives one.
    Diff {
        /// What was.
        base: PathBuf,

        /// What is now.
        candidate: PathBuf,

        #[arg(long, value_enum, default_value_t = Format::Terminal)]
        format: Format,
    },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    Terminal,
    /// For a pull request.
    Markdown,
}

impl From<Format> for Form {
    fn from(format: Format) -> Self {
        match format {
            Format::Terminal => Self::Terminal,
            Format::Markdown => Self::Markdown,
        }
    }
}

pub fn baseline(arguments: &BaselineArguments, registry: &Registry) -> Exit {
    let result = match &arguments.action {
        Action::Save { file, out, seed, set, programs, verify, force } => {
            save(file, out.as_deref(), *seed, set, (programs, *verify), *force, registry)
        }
        Action::Show { path, format } => measured::read_baseline(path, registry)
            .map(|baseline| write!(stdout(), "{}", render_baseline(&baseline, (*format).into()))),
        Action::Diff { base, candidate, format } => diff(base, candidate, *format, registry),
    };
    result.err().unwrap_or(Exit::Success)
}

fn save(
    file: &str,
    out: Option<&Path>,
    seed: Option<u64>,
    set: &SetArguments,
    (programs, verify): (&ProgramArguments, VerifyArguments),
    force: bool,
    registry: &Registry,
) -> Result<(), Exit> {
    let suite = measured::load_suite(file, seed, set, registry)?;
    let paths = match out {
        Some(path) => vec![path.to_owned()],
        None => measured::default_paths(file, &suite),
    };
    for path in &paths {
        if out.is_none() {
            project::holds(file, path)?;
        }
        if !force {
            project::may_be_replaced(path, &suite.name)?;
        }
    }
    let stop = stop_on_interrupt();
    let requests = measured_metrics(&suite, registry);
    let measured = measured::run_suite(&suite, &requests, "baseline", &stop, programs, verify);
    let interrupted = matches!(measured, Err(Exit::Interrupted)) || stop.is_requested();
    if interrupted {
        writeln!(stderr(), "interrupted: nothing saved");
        return Err(Exit::Interrupted);
    }
    let baseline = measured?;
    for path in &paths {
        measured::save(path, &baseline.text())?;
        writeln!(
            stdout(),
            "{}: {}, {}, seed {}; commit it",
            path.display(),
            count(baseline.trials.len(), "trial"),
            count(baseline.runs(), "run"),
            baseline.seed
        );
    }
    let cut_off: usize = baseline.trials.iter().map(|trial| trial.cut_off).sum();
    if cut_off > 0 {
        writeln!(
            stderr(),
            "warning: {} ended before all had met: no gate passes for such runs; give `horizon` more time",
            count(cut_off, "run")
        );
    }
    for gate in &suite.gates {
        // With itself it can always be compared, but for metrics that the gate names and no run has.
        if let Ok(seen) = judge_gate(gate, &baseline, &baseline, false) {
            write!(stdout(), "{}", render_sight(&seen));
        }
    }
    Ok(())
}

fn diff(base: &Path, candidate: &Path, format: Format, registry: &Registry) -> Result<(), Exit> {
    let (base, candidate) =
        (measured::read_baseline(base, registry)?, measured::read_baseline(candidate, registry)?);
    write!(stdout(), "{}", render_difference(&base, &candidate, format.into()));
    Ok(())
}
