//! `scenario-runner plan FILE… --out MANIFEST`: what there is to be run, in units that many machines share.

use std::path::{Path, PathBuf};

use clap::Args;

use super::filter;
use super::planned::{own_build, permission_digest, planned_programs, programs, run_digests, said, texts};
use super::programs::{ProgramArguments, VerifyArguments, say_all};
use super::run::conduct::Colour;
use super::run::select::{self, SubjectArguments};
use super::run::{hints, targets};
use super::set::SetArguments;
use super::{Exit, load, number};
use files::escape::shell_path;
use lang::filter::Show;
use report::console::{stderr, stdout};
use runner::run::Threads;
use runner::session;
use runner::shards::{ManifestHeader, Planner, WrittenManifest, canary, write_manifest};
use scenario::registry::Registry;

/// Writes down what there is to be run: a line a unit, which is some runs of a trial, what a search makes for a person, or another block as a whole.
///
/// A manifest holds for the program that wrote it and the files as they are: `exec` and `merge` refuse it with any other. The same files and
/// program give the same manifest, byte for byte, so that every machine may make its own.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  scenario-runner plan suites/paper.suite --out manifest.jsonl    all of it
  scenario-runner exec manifest.jsonl --partition slice:3/40 --results results
                                                                  on machine 3 of 40
  scenario-runner merge manifest.jsonl --results results --junit junit.xml
                                                                  where all results are

docs/scale.md has a laptop, a CI matrix and a cluster.")]
pub struct PlanArguments {
    /// Suites (.suite) and scenarios (.scn, .yaml); any other word selects trials and blocks whose name contains it.
    #[arg(required = true, value_name = "FILE|FILTER")]
    words: Vec<String>,

    #[command(flatten)]
    filters: SubjectArguments,

    /// Replaces the seed of every suite.
    #[arg(long, value_name = "SEED")]
    seed: Option<u64>,

    #[command(flatten)]
    set: SetArguments,

    #[command(flatten)]
    programs: ProgramArguments,

    #[command(flatten)]
    verify: VerifyArguments,

    /// Where the manifest goes.
    #[arg(long, value_name = "MANIFEST")]
    out: PathBuf,

    /// Number of threads, at most 1024 [default: one per core]. The manifest does not depend on it.
    #[arg(long, short = 'j', visible_alias = "jobs", value_name = "N", value_parser = number::threads())]
    test_threads: Option<usize>,

    /// When to use colours.
    #[arg(long, value_enum, default_value_t = Colour::Auto)]
    color: Colour,
}

pub fn plan(arguments: PlanArguments, registry: &Registry) -> Exit {
    planned(arguments, registry).unwrap_or_else(|exit| exit)
}

fn planned(arguments: PlanArguments, registry: &Registry) -> Result<Exit, Exit> {
    let PlanArguments { words, filters, seed, set, programs: permission, verify, out, .. } = arguments;
    let colour = arguments.color.wanted(stderr());
    let (names, others): (Vec<_>, Vec<_>) = words.iter().partition(|word| load::names_a_file(word));
    if names.is_empty() {
        return Err(hints::project());
    }
    hints::one_filter(&others)?;
    let expressions = filters.expressions.read(colour)?;
    let project = load::load_all(&names, seed, &set, colour, registry)?;
    let suites = project.suites();
    if let Err(complaint) = targets::check(&[("--out", out.as_path())], &targets::read_by(suites)) {
        writeln!(stderr(), "error: {complaint}");
        return Err(Exit::Usage);
    }
    let units = session::units(suites);
    let each = |show: &mut Show| {
        units.iter().for_each(|unit| select::with_subject(suites, &unit, &mut *show));
    };
    filter::warn(&expressions, &each, colour);
    let word = others.first().map(|word| word.as_str());
    let chosen = session::with_needs(
        &units,
        select::select(suites, &units, &expressions, word, (&filters, None), None),
    );
    if !chosen.contains(&true) {
        writeln!(stderr(), "error: no trial is selected");
        writeln!(stderr(), "help: `run --list` shows the names of all trials and blocks");
        return Err(Exit::NothingSelected);
    }
    let own = programs(&project)?;
    if !own.is_empty() {
        let permission = permission.permission()?;
        say_all(&own.iter().filter_map(|(program, _)| permission.check(program).err()).collect::<Vec<_>>())?;
    }
    let build = own_build()?;
    let threads = arguments.test_threads.map_or_else(Threads::all, Threads::new);
    let digests = run_digests(&build, &verify, &own);
    let planner = Planner::new(&project, &units, &threads, &digests);
    let canary = canary(registry).map_err(|error| said(&error))?;
    let mut header = ManifestHeader::new(build, canary);
    header.files = names.into_iter().cloned().collect();
    header.seed = seed;
    header.set = suites.first().map_or_else(Vec::new, |one| one.suite.set.clone());
    header.verify_runs = verify.word();
    header.texts = texts(&project);
    header.programs = planned_programs(&own);
    let allowed = (!own.is_empty()).then(|| permission_digest(&header.programs));
    let written = write_manifest(&out, header, planner.plan(&chosen), &units).map_err(|error| {
        writeln!(stderr(), "error: cannot write {}: {error}", out.display());
        Exit::Output
    })?;
    told(&out, written, allowed.as_deref());
    Ok(Exit::Success)
}

/// Says what is in the manifest, and what to do with it.
fn told(out: &Path, WrittenManifest { units, batches, seconds }: WrittenManifest, allowed: Option<&str>) {
    writeln!(
        stdout(),
        "{}: {units} units in {batches} batches, about {:.0} s on one core",
        out.display(),
        seconds.ceil()
    );
    let option = allowed.map_or_else(String::new, |digest| format!(" --allow-run-digest {digest}"));
    let manifest = shell_path(&out.to_string_lossy());
    writeln!(stdout(), "  scenario-runner exec {manifest} --partition slice:1/1 --results results{option}");
    writeln!(stdout(), "  scenario-runner merge {manifest} --results results");
}
