//! `scenario-runner merge MANIFEST --results DIR`: judges the results of a plan, and writes the reports of one machine.

use std::path::{Path, PathBuf, absolute};

use clap::Args;

use super::interrupt::stop_on_interrupt;
use super::planned::{PlannedProject, said};
use super::programs::ProgramArguments;
use super::run::conduct::{ConductArguments, ConductOrders, Conducted, ShownArguments};
use super::run::output::{self, OutputArguments, WrittenLines};
use super::run::{Deny, LastRun, in_github_actions, judged, targets};
use super::{Exit, number};
use files::escape::shell_word;
use files::{Disk, Files};
use report::console::stderr;
use runner::run::{AbsentRuns, Executor, FromResults, Threads};
use runner::session::{self, Selection};
use runner::shards::{ResultFiles, chosen};
use scenario::registry::Registry;

/// Judges the results of a plan and writes the reports that one machine would have written, byte for byte but for wall times, with its exit
/// codes. It makes no runs but those that reports draw, which must come to what they came to.
///
/// Results that are missing, cut off, of another build or another plan, or of which two say different things, are an error: nothing is judged
/// then, and no report is written.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  scenario-runner merge manifest.jsonl --results results
  scenario-runner merge manifest.jsonl --results results --junit junit.xml --html report.html")]
pub struct MergeArguments {
    /// What `plan` wrote.
    #[arg(value_name = "MANIFEST")]
    manifest: PathBuf,

    /// Where the results of all shares are.
    #[arg(long, value_name = "DIR")]
    results: PathBuf,

    #[command(flatten)]
    output: OutputArguments,

    /// Number of threads, at most 1024 [default: one per core]. Runs that reports draw are made again, and blocks think.
    #[arg(long, short = 'j', visible_alias = "jobs", value_name = "N", value_parser = number::threads())]
    test_threads: Option<usize>,

    #[command(flatten)]
    programs: ProgramArguments,

    #[command(flatten)]
    shown: ShownArguments,

    /// What does not count as passed, though by itself it does.
    #[arg(long, value_enum, value_name = "WHAT")]
    deny: Vec<Deny>,
}

pub fn merge(arguments: MergeArguments, registry: &Registry) -> Exit {
    merged(arguments, registry).unwrap_or_else(|exit| exit)
}

fn merged(arguments: MergeArguments, registry: &Registry) -> Result<Exit, Exit> {
    let MergeArguments { manifest, results: folder, output: reports, test_threads, programs, shown, deny } =
        arguments;
    let planned = PlannedProject::open(&manifest, false, registry)?;
    let conduct = ConductArguments::of_results(test_threads, programs, planned.verify, shown);
    let suites = planned.project.suites();
    let own = manifest.to_string_lossy();
    let read: Vec<&str> = targets::read_by(suites).into_iter().chain([&*own]).collect();
    let complaint =
        targets::check(&reports.files(), &read).err().or_else(|| among_results(&reports, &folder));
    if let Some(complaint) = complaint {
        writeln!(stderr(), "error: {complaint}");
        writeln!(stderr(), "help: name another file; nothing was written");
        return Err(Exit::Usage);
    }
    let units = session::units(suites);
    let chosen = chosen(&planned.manifest, &units).map_err(|error| said(&error))?;
    let (manifest, shown) = (shell_word(&own), shell_word(&folder.to_string_lossy()));
    let command = format!("`scenario-runner exec {manifest} --results {shown}`");
    let files = ResultFiles::open(&folder, &planned.manifest, &command).map_err(|error| said(&error))?;
    // Where programs decide, what reports draw is asked of them once more.
    let threads = match reports.draw_runs() {
        true => conduct.programs.threads(conduct.test_threads, suites.iter().map(|one| &one.suite))?,
        false => conduct.test_threads.map_or_else(Threads::all, Threads::new),
    };
    let stop = stop_on_interrupt();
    let asked = planned.programs.iter().filter_map(|(program, _)| {
        Some((program.clone(), files.title(&program.name, &program.file)?.to_string()))
    });
    let executor = FromResults::new(&threads, &planned.digests, &files, AbsentRuns::Refused, &stop)
        .with_programs(asked.collect())
        .reading_ahead(threads.parallelism());
    let mut lines = reports.begin_lines(&units, &chosen, in_github_actions()).map_err(|complaint| {
        writeln!(stderr(), "error: {complaint}");
        Exit::Output
    })?;
    let orders = ConductOrders {
        project: &planned.project,
        units: &units,
        selection: Selection::marked(chosen),
        executor: &executor,
        stop: &stop,
        watch: None,
        courses: reports.draw_runs(),
        every_trial: reports.need_every_trial(in_github_actions()),
        besides: lines.as_mut().map(WrittenLines::reporter),
        is_repeated: false,
        is_merged: true,
    };
    let Conducted { mut results, mut complaints, notices } = conduct.conduct(orders, &mut LastRun::read());
    results.denies_untested = deny.contains(&Deny::Untested);
    let troubles = executor.troubles();
    for trouble in &troubles {
        writeln!(stderr(), "error: {trouble}");
    }
    if !troubles.is_empty() {
        writeln!(stderr(), "error: the results are not those of this plan: no report was written");
        return Err(Exit::Usage);
    }
    if stop.is_requested() {
        writeln!(stderr(), "error: interrupted: no report was written");
    } else {
        complaints.extend(lines.and_then(WrittenLines::end));
        complaints.extend(output::write(&reports, &results, in_github_actions()));
    }
    for notice in &notices {
        writeln!(stderr(), "note: {notice}");
    }
    for complaint in &complaints {
        writeln!(stderr(), "error: {complaint}");
    }
    Ok(match () {
        () if stop.is_requested() => Exit::Interrupted,
        () if !complaints.is_empty() => Exit::Output,
        () => judged(&results),
    })
}

/// What to say of a report that would lie among the results, where it would take the place of some.
fn among_results(reports: &OutputArguments, results: &Path) -> Option<String> {
    let results = Disk.identity(results);
    // What is not there yet is where the nearest folder is that is there.
    let lies_there = |path: &Path| {
        let path = absolute(path).unwrap_or_else(|_| path.to_path_buf());
        path.ancestors().any(|one| Disk.identity(one) == results)
    };
    let (option, path) = reports.files().into_iter().find(|(_, path)| lies_there(path))?;
    Some(format!("{option} {} would lie among the results", path.display()))
}
