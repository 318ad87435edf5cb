//! `scenario-runner exec MANIFEST --results DIR`: the runs of a share of a plan.

use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use clap::Args;
use serde_json::json;

use super::interrupt::stop_on_interrupt;
use super::on_engine::{EngineArguments, Shares};
use super::planned::{PlannedProject, permission_digest, said};
use super::programs::ProgramArguments;
use super::run::conduct::Colour;
use super::run::partition::Partition;
use super::{Exit, number};
use report::console::{stderr, stdout};
use runner::session;
use runner::shards::{BatchProgress, Executed, Execution, Planner, UnitBatch, canary};
use scenario::registry::Registry;

/// Makes the runs of a share of a plan and writes what came of them: a file for each batch, of about a second of work. Nothing is judged.
///
/// A batch that is there is left alone, so that the same command goes on where it was killed; several may write into one folder, also the same
/// batches. Without `--partition` it is the whole plan. Whoever has made its share helps others in the same folder with the searches, tunes and other
/// blocks that they are at: each makes some of the runs of a round.
#[derive(Debug, Args)]
#[command(after_help = "\
Exit code 0 says that all results of the share are there, whatever they are; `merge` judges.

Examples:
  scenario-runner exec manifest.jsonl --results results                             all of it
  scenario-runner exec manifest.jsonl --partition slice:3/40 --results results      share 3 of 40
  scenario-runner exec manifest.jsonl --on slurm --results results                  by a cluster")]
pub struct ExecArguments {
    /// What `plan` wrote.
    #[arg(value_name = "MANIFEST")]
    manifest: PathBuf,

    /// The share: `slice:3/40` takes every fortieth batch, `hash:3/40` chooses by their digests.
    #[arg(long, value_name = "slice:M/N|hash:M/N")]
    partition: Option<Partition>,

    /// Where the results go.
    #[arg(long, value_name = "DIR")]
    results: PathBuf,

    /// Number of threads, at most 1024 [default: one per core]. Results do not depend on it.
    #[arg(long, short = 'j', visible_alias = "jobs", value_name = "N", value_parser = number::threads())]
    test_threads: Option<usize>,

    #[command(flatten)]
    engine: EngineArguments,

    #[command(flatten)]
    programs: ProgramArguments,

    /// Let the programs of the plan run if they are those that had this digest when it was made, as `plan` printed it.
    #[arg(long, value_name = "DIGEST", conflicts_with = "allow_run")]
    allow_run_digest: Option<String>,

    /// Leave batches alone that are there, though commands decide in them: what else such a program reads than the files that its declaration
    /// names nobody knows.
    #[arg(long)]
    reuse: bool,

    /// End when the share is made. Without this a worker goes on with what others are at in the same folder, if that is decided in rounds of runs (`tune`,
    /// `evaluate`, `search`, `estimate`, `calibrate`, trials with `runs N .. M`): they share the runs of each round, and their results are the same bytes. It
    /// ends where nobody is at such a thing, or where it is no help.
    #[arg(long)]
    own_share_only: bool,

    /// Help others only if this file is there when the share is made. `--on` uses it for slices: once the last of them has begun, none waits for the cores of
    /// one that goes on with others' runs.
    #[arg(long, value_name = "FILE", conflicts_with = "own_share_only")]
    join_once: Option<PathBuf>,

    /// When to use colours.
    #[arg(long, value_enum, default_value_t = Colour::Auto)]
    color: Colour,
}

pub fn exec(arguments: &ExecArguments, registry: &Registry) -> Exit {
    executed(arguments, registry).unwrap_or_else(|exit| exit)
}

fn executed(arguments: &ExecArguments, registry: &Registry) -> Result<Exit, Exit> {
    let colour = arguments.color.wanted(stderr());
    let planned = PlannedProject::open(&arguments.manifest, colour, registry)?;
    let permission = arguments.permission(&planned)?;
    if let Some(engine) = arguments.engine.on {
        make_results_folder(&arguments.results)?;
        let (manifest, results) = (&arguments.manifest, &arguments.results);
        let shares = Shares {
            manifest,
            results,
            planned: &planned,
            permission: &permission,
            reuse: arguments.reuse,
            own_share_only: arguments.own_share_only,
        };
        return arguments.engine.make(engine, &shares);
    }
    let suites = planned.project.suites();
    let threads = permission.threads(arguments.test_threads, suites.iter().map(|one| &one.suite))?;
    let canary = canary(registry).map_err(|error| said(&error))?;
    let units = session::units(suites);
    let planner = Planner::new(&planned.project, &units, &threads, &planned.digests);
    make_results_folder(&arguments.results)?;
    let stop = stop_on_interrupt();
    let mine = |number: usize, id: &str| arguments.partition.is_none_or(|share| share.holds(number, id));
    let log = WorkLog::new(&arguments.results);
    let joins = || !arguments.own_share_only && arguments.join_once.as_ref().is_none_or(|file| file.exists());
    let execution = Execution {
        planner: &planner,
        manifest: &planned.manifest,
        executor: &threads,
        verify: planned.verify.runs(),
        folder: &arguments.results,
        mine: &mine,
        reuse: arguments.reuse || planned.programs.iter().all(|(program, _)| program.is_known_whole()),
        canary: &canary,
        worker: &log.worker,
        joins: &joins,
        stop: &stop,
    };
    let executed =
        execution.run(&|batch, progress| log.note(batch, progress)).map_err(|error| said(&error))?;
    writeln!(stdout(), "{}: {}", arguments.results.display(), in_words(&executed));
    Ok(Exit::Success)
}

fn in_words(executed: &Executed) -> String {
    let Executed { made, skipped, runs, resumed, heard, joined, shared } = *executed;
    let some = |number: usize, words: &str| (number > 0).then(|| format!("{number} {words}"));
    let of_which =
        [some(resumed, "of which a journal held"), some(heard, "of which others have made meanwhile")];
    let of_which: Vec<String> = of_which.into_iter().flatten().collect();
    let of_which = if of_which.is_empty() { String::new() } else { format!(" ({})", of_which.join(", ")) };
    let there = some(skipped, "were there").map_or_else(String::new, |there| format!(", {there}"));
    let helped = match (joined, shared) {
        (0, 0) => String::new(),
        (0, _) => format!("; made {shared} runs of what others have written"),
        _ => format!("; helped others with {joined}, of which it made {shared} runs"),
    };
    format!("made {made} batches of {runs} runs{of_which}{there}{helped}")
}

fn make_results_folder(folder: &Path) -> Result<(), Exit> {
    files::make_folder(folder).map_err(|error| {
        writeln!(stderr(), "error: cannot create the folder {}: {error}", folder.display());
        Exit::Output
    })
}

impl ExecArguments {
    /// What is allowed to run: a manifest by itself allows nothing.
    fn permission(&self, planned: &PlannedProject) -> Result<ProgramArguments, Exit> {
        let Some(allowed) = &self.allow_run_digest else { return Ok(self.programs.clone()) };
        let found = permission_digest(&planned.manifest.header().programs);
        if *allowed == found {
            return Ok(ProgramArguments::everything());
        }
        writeln!(stderr(), "error: `--allow-run-digest`: the programs of this plan have the digest {found}");
        Err(Exit::Usage)
    }
}

/// What depends on clocks and machines, beside the results.
struct WorkLog {
    path: PathBuf,
    host: String,
    /// As no other process at the same folder is called.
    worker: String,
}

impl WorkLog {
    fn new(results: &Path) -> Self {
        let host = host();
        let worker = format!("{host}.{}", std::process::id());
        Self { path: results.join("log").join(format!("{worker}.jsonl")), host, worker }
    }

    fn note(&self, batch: &UnitBatch, progress: BatchProgress) {
        let line = match progress {
            BatchProgress::Skipped => return,
            BatchProgress::Damaged(why) => {
                writeln!(stderr(), "warning: {why}; it is made again");
                json!({ "damaged": why })
            }
            BatchProgress::Joined => {
                let names: Vec<&str> = batch.units.iter().map(|unit| &*unit.name).collect();
                writeln!(stderr(), "helps another worker with {}", names.join(", "));
                json!({ "joined": true })
            }
            BatchProgress::MadeElsewhere(own) => json!({ "own": own, "elsewhere": true }),
            BatchProgress::Left(own) => json!({ "own": own, "left": true }),
            BatchProgress::Made { runs, own, took, over_limit, path } => {
                for trial in over_limit {
                    writeln!(
                        stderr(),
                        "warning: {trial} took longer here than its `time_limit`: that is its result, which has not passed; without {} it is made \
                         again",
                        path.display()
                    );
                }
                let mut what = json!({ "runs": runs, "own": own, "seconds": took.as_secs_f64() });
                if !over_limit.is_empty() {
                    what["over_limit"] = over_limit.into();
                }
                what
            }
        };
        let at = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64());
        let line = json!({ "batch": batch.id, "host": self.host, "pid": std::process::id(), "at": at, "what": line });
        // Nothing depends on it.
        let folder = self.path.parent().map_or(Ok(()), files::make_folder);
        let _ = folder.and_then(|()| files::append_text(&self.path, &format!("{line}\n")));
    }
}

/// As this machine calls itself.
fn host() -> String {
    let name = std::env::var("HOSTNAME").ok().or_else(|| files::read_text(Path::new("/etc/hostname")).ok());
    let name = name.unwrap_or_default();
    let name: String =
        name.trim().chars().filter(|one| one.is_ascii_alphanumeric() || matches!(one, '-' | '_')).collect();
    if name.is_empty() { "host".to_string() } else { name }
}
