//! Files to plans: what every command that runs something begins with.

use std::path::Path;

use super::Exit;
use crate::corpus::{corpus_path, read_corpus};
use crate::dispatch::Prepared;
use crate::judge::examine_criteria;
use crate::lang::{self, Code, Diagnostic, Severity, Sources};
use crate::plan::{Plan, PlanError, plan};
use crate::report::Excerpt;
use crate::run::{Obstacle, Stage, rehearse, rehearse_trials};
use crate::scenario::Suite;

/// Whether a word of the command line is meant as a file.
pub fn names_a_file(word: &str) -> bool {
    let extension = Path::new(word).extension().and_then(|extension| extension.to_str());
    matches!(extension, Some("suite" | "scn" | "yaml" | "yml"))
}

/// Loads, checks and plans every file; all errors of all files go to stderr.
pub fn load_all(files: &[&String], seed: Option<u64>, colour: bool) -> Result<Vec<Prepared>, Exit> {
    let mut loaded = Vec::new();
    let mut failed = false;
    for file in files {
        match load(file, seed, colour) {
            Ok(suite) => loaded.push(suite),
            Err(()) => failed = true,
        }
    }
    if failed { Err(Exit::Scenario) } else { Ok(loaded) }
}

/// Everything that is to be said about a file before it is run; `text` stands for what is on disk.
pub fn examine(path: &Path, text: Option<&str>) -> (Vec<Diagnostic>, Sources) {
    let lang::Examined { suite, mut found, sources } = lang::examine(path, text);
    if let Some(suite) = &suite {
        found.extend(examine_criteria(suite, &sources));
        found.extend(rehearse(suite).into_iter().filter_map(|obstacle| finding(obstacle, &sources)));
        found.sort_by_key(|diagnostic| (diagnostic.span().source, diagnostic.span().start));
    }
    (found, sources)
}

fn load(file: &str, seed: Option<u64>, colour: bool) -> Result<Prepared, ()> {
    let lang::Loaded { mut suite, sources, .. } = read(file, colour)?;
    suite.seed = seed.unwrap_or(suite.seed);
    refuse_hopeless(&suite, &sources, colour)?;
    let plan = plan(&suite).map_err(|errors| show_plan_errors(&errors, colour))?;
    build_everybody(&suite, &plan, colour)?;
    let recorded = read_corpus(&corpus_path(Path::new(file))).map_err(|error| {
        eprintln!("error: {error}");
        eprintln!("help: restore the file from version control, or delete it to forget these failures");
    })?;
    Ok(Prepared { file: file.to_string(), suite, plan, recorded })
}

/// Shows on stderr why a suite cannot be planned.
pub fn show_plan_errors(errors: &[PlanError], colour: bool) {
    for error in errors {
        let excerpt = Excerpt {
            title: &error.message,
            origin: &error.origin,
            label: "",
            notes: &[],
            help: error.hint.as_deref(),
        };
        eprintln!("{}\n", excerpt.render(colour));
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

/// Criteria that no run could make pass are not worth a run.
fn refuse_hopeless(suite: &Suite, sources: &Sources, colour: bool) -> Result<(), ()> {
    let found = examine_criteria(suite, sources);
    for diagnostic in &found {
        eprintln!("{}\n", lang::render(diagnostic, sources, lang::Style { colour }));
    }
    if found.iter().any(|one| one.severity == Severity::Error) { Err(()) } else { Ok(()) }
}

/// Builds road users once, so that what a model cannot do is said before anything runs.
fn build_everybody(suite: &Suite, plan: &Plan, colour: bool) -> Result<(), ()> {
    let obstacles = rehearse_trials(suite, &plan.trials);
    for obstacle in &obstacles {
        let notes: Vec<String> = obstacle.note().into_iter().collect();
        let excerpt = Excerpt {
            title: &obstacle.message,
            origin: &obstacle.origin,
            label: "",
            notes: &notes,
            help: obstacle.hint.as_deref(),
        };
        eprintln!("{}\n", excerpt.render(colour));
    }
    if obstacles.is_empty() { Ok(()) } else { Err(()) }
}

/// Loads and checks one file; warnings and errors go to stderr.
pub fn read(file: &str, colour: bool) -> Result<lang::Loaded, ()> {
    let style = lang::Style { colour };
    match lang::load(Path::new(file)) {
        Ok(loaded) => {
            for warning in &loaded.warnings {
                eprintln!("{}\n", lang::render(warning, &loaded.sources, style));
            }
            Ok(loaded)
        }
        Err(failure) => {
            eprint!("{}", failure.render(style));
            Err(())
        }
    }
}
