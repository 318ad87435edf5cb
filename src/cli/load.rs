//! Files to plans: what every command that runs something begins with.

use std::path::Path;

use super::Exit;
use super::set::SetArguments;
use crate::console::stderr;
use crate::corpus::{corpus_path, is_unchecked, read_corpus};
use crate::dispatch::Prepared;
use crate::experiment::rehearse_searches;
use crate::judge::examine_claims;
use crate::lang::{self, Code, Diagnostic, Override, Severity, Sources};
use crate::plan::{Plan, PlanError, PlannedTrial, plan};
use crate::registry::Registry;
use crate::report::Excerpt;
use crate::run::{Departing, Obstacle, Stage, departing, rehearse, rehearse_trials};
use crate::scenario::{Suite, show};

/// Whether a word of the command line is meant as a file.
pub fn names_a_file(word: &str) -> bool {
    let extension = Path::new(word).extension().and_then(|extension| extension.to_str());
    matches!(extension, Some("suite" | "scn" | "yaml" | "yml"))
}

/// Loads, checks and plans every file; all errors of all files go to stderr.
pub fn load_all(
    files: &[&String],
    seed: Option<u64>,
    set: &SetArguments,
    colour: bool,
    registry: &Registry,
) -> Result<Vec<Prepared>, Exit> {
    let set = set.all().map_err(|name| {
        writeln!(stderr(), "error: `{name}` is set twice");
        writeln!(stderr(), "help: leave out one of the two");
        Exit::Usage
    })?;
    let mut loaded = Vec::new();
    let mut failed = false;
    for file in files {
        match load(file, seed, &set, colour, registry) {
            Ok(suite) => loaded.push(suite),
            Err(()) => failed = true,
        }
    }
    if failed { Err(Exit::Scenario) } else { Ok(loaded) }
}

/// Everything that is to be said about a file before it is run; `text` stands for what is on disk.
pub fn examine(path: &Path, text: Option<&str>, registry: &Registry) -> (Vec<Diagnostic>, Sources) {
    let lang::Examined { suite, mut found, sources } = lang::examine(path, text, registry);
    if let Some(suite) = &suite {
        found.extend(examine_claims(suite, &sources));
        let obstacles = rehearse(suite).into_iter().chain(rehearse_searches(suite));
        found.extend(obstacles.filter_map(|obstacle| finding(obstacle, &sources)));
        found.extend(examine_models(suite, &sources));
        found.sort_by_key(|diagnostic| (diagnostic.span().source, diagnostic.span().start));
    }
    (found, sources)
}

fn load(
    file: &str,
    seed: Option<u64>,
    set: &[Override],
    colour: bool,
    registry: &Registry,
) -> Result<Prepared, ()> {
    let lang::Loaded { mut suite, sources, warnings } = read(file, set, colour, registry)?;
    suite.seed = seed.unwrap_or(suite.seed);
    refuse_hopeless(&suite, &sources, colour)?;
    let plan = plan(&suite).map_err(|errors| show_plan_errors(&errors, colour))?;
    build_everybody(&suite, &plan, colour)?;
    for doubt in examine_models(&suite, &sources) {
        stderr().styled(&format!("{}\n\n", lang::render(&doubt, &sources, lang::Style { colour })));
    }
    let is_set_aside = warnings.iter().any(|warning| warning.code == Code::SetAside);
    refuse_nothing_asked(&suite, &plan, is_set_aside)?;
    let mut recorded = read_corpus(&corpus_path(Path::new(file))).map_err(|error| {
        writeln!(stderr(), "error: {error}");
        writeln!(stderr(), "help: {}", error.help());
    })?;
    if is_unchecked(&corpus_path(Path::new(file))) {
        writeln!(
            stderr(),
            "note: {} has no checksums yet, so that a changed digit in it is not noticed; `--record-failures` adds them",
            corpus_path(Path::new(file)).display()
        );
    }
    if !set.is_empty() && !recorded.is_empty() {
        writeln!(
            stderr(),
            "note: recorded failures of {file} are left out: they are runs of what the files say"
        );
        recorded.clear();
    }
    Ok(Prepared { file: file.to_string(), suite, plan, recorded })
}

/// Shows on stderr why a suite cannot be planned.
pub fn show_plan_errors(errors: &[PlanError], colour: bool) {
    for error in errors {
        let notes: Vec<String> = error.case.iter().map(|case| format!("in {case}")).collect();
        let excerpt = Excerpt {
            title: &error.message,
            origin: &error.origin,
            label: "",
            notes: &notes,
            help: error.hint.as_deref(),
        };
        stderr().styled(&format!("{}\n\n", excerpt.render(colour)));
    }
}

/// An obstacle as `check` shows it.
fn finding(obstacle: Obstacle, sources: &Sources) -> Option<Diagnostic> {
    let (code, label) = match obstacle.stage {
        Stage::Planning => (Code::CannotBePlanned, "cannot be planned"),
        Stage::Building => (Code::CannotBeBuilt, "cannot be run like this"),
    };
    let mut finding = Diagnostic::new(code, sources.span(&obstacle.origin)?, &obstacle.message).label(label);
    finding.notes.extend(obstacle.note());
    let hint = obstacle.hint.unwrap_or_else(|| format!("`scenario-runner explain {code}` says more"));
    Some(finding.hint(hint))
}

/// With the values that were set, a trial may be left without a criterion, and would pass whatever happens.
fn refuse_nothing_asked(suite: &Suite, plan: &Plan, is_set_aside: bool) -> Result<(), ()> {
    if suite.set.is_empty() {
        return Ok(());
    }
    let asks_something = |name: &str| {
        is_set_aside || suite.scenarios.iter().any(|one| one.name == name && !one.criteria.is_empty())
    };
    let idle = |trial: &&PlannedTrial| trial.criteria.is_empty() && asks_something(&trial.scenario);
    let Some(trial) = plan.trials.iter().find(idle) else { return Ok(()) };
    writeln!(stderr(), "error: with {} no criterion applies to {}", suite.set.join(", "), trial.key);
    writeln!(stderr(), "help: it would pass whatever happens; set a value that a criterion is about");
    Err(())
}

/// Models that are others than were published, to be warned of.
fn examine_models(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let doubt = |Departing { departure, case, origin, .. }: Departing| {
        let published = show(departure.published, None, departure.dimension);
        let doubt = Diagnostic::new(Code::AnotherModel, sources.span(&origin)?, departure.to_string())
            .label("another model than was published")
            .hint(format!(
                "say `{}: {published}`; with another value, say whose behaviour it is",
                departure.parameter
            ));
        Some(Diagnostic { notes: vec![format!("in {case}")], ..doubt })
    };
    departing(suite).into_iter().filter_map(doubt).collect()
}

/// Criteria that no run could make pass are not worth a run; lanes that are blocked are warned of.
fn refuse_hopeless(suite: &Suite, sources: &Sources, colour: bool) -> Result<(), ()> {
    let found = examine_claims(suite, sources);
    for diagnostic in &found {
        stderr().styled(&format!("{}\n\n", lang::render(diagnostic, sources, lang::Style { colour })));
    }
    if found.iter().any(|one| one.severity == Severity::Error) { Err(()) } else { Ok(()) }
}

/// Builds road users once, so that what a model cannot do is said before anything runs.
fn build_everybody(suite: &Suite, plan: &Plan, colour: bool) -> Result<(), ()> {
    let mut obstacles = rehearse_trials(suite, &plan.trials);
    obstacles.extend(rehearse_searches(suite));
    for obstacle in &obstacles {
        let notes: Vec<String> = obstacle.note().into_iter().collect();
        let excerpt = Excerpt {
            title: &obstacle.message,
            origin: &obstacle.origin,
            label: "",
            notes: &notes,
            help: obstacle.hint.as_deref(),
        };
        stderr().styled(&format!("{}\n\n", excerpt.render(colour)));
    }
    if obstacles.is_empty() { Ok(()) } else { Err(()) }
}

/// Loads and checks one file with the values that are set; warnings and errors go to stderr.
fn read(file: &str, set: &[Override], colour: bool, registry: &Registry) -> Result<lang::Loaded, ()> {
    let style = lang::Style { colour };
    match lang::load_set(Path::new(file), set, registry) {
        Ok(loaded) => {
            for warning in &loaded.warnings {
                stderr().styled(&format!("{}\n\n", lang::render(warning, &loaded.sources, style)));
            }
            Ok(loaded)
        }
        Err(failure) => {
            stderr().styled(&failure.render(style));
            Err(())
        }
    }
}
