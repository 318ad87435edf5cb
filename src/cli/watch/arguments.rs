//! What `watch` is told on the command line.

use clap::Args;

use crate::cli::run::conduct::ConductArguments;
use crate::cli::run::select::SelectArguments;

#[derive(Debug, Args)]
#[command(after_help = "\
A suite is run again when what it read has changed: its file, files that it uses or includes, populations, tables, baselines, recorded
failures, and the programs that decide in it. It is stopped first if it is under way. What did not pass comes first. Files that a program
under test reads by itself are not known: Enter runs everything again.

Keys, where standard input is a terminal:
  Enter, a   run everything again
  f          run again what did not pass
  / or p     a filter expression, as with -E; an empty one selects everything
  o          write an HTML report of the last run, and open it
  w          list what is watched
  h or ?     these keys
  q          quit

It ends by `q` with exit code 0, and by Ctrl-C, SIGTERM or the loss of its terminal with 105.

Examples:
  scenario-runner watch                                       the suites of this folder
  scenario-runner watch suites/zebra.suite                    one of them
  scenario-runner watch suites/zebra.suite -E 'tag(paper)'    some of it")]
pub struct WatchArguments {
    /// Suites (.suite) and scenarios (.scn, .yaml) to watch; any other word selects trials and blocks whose name contains it. Without any
    /// file, the suites of this folder and down to two below it, or the scenarios if there are no suites.
    #[arg(value_name = "FILE|FILTER")]
    pub words: Vec<String>,

    #[command(flatten)]
    pub select: SelectArguments,

    #[command(flatten)]
    pub conduct: ConductArguments,

    /// Look for changes several times a second instead of being told by the system, which tells of none on some network file systems and
    /// in some containers.
    #[arg(long)]
    pub poll: bool,
}
