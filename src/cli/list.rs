//! `scenario-runner list`: the scenarios, blocks, ratings and gates of suites, with tags and counts.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde_json::{Map, Value, json};

use super::Exit;
use super::filter::{self, FilterArguments};
use super::load;
use files::{Disk, Files};
use lang::filter::{SCENARIO, Show, Subject};
use lang::{self, Style};
use report::console::{stderr, stdout};
use runner::plan::{self, Plan, PlannedTrial, ScenarioPlan};
use runner::project::{key_prefixes, plan_notices};
use scenario::registry::Registry;
use scenario::{Block, Gate, Origin, Rating, Suite};

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  scenario-runner list suites/*.suite                        everything with tags and counts
  scenario-runner list suites/*.suite --format json          the same for other programs
  scenario-runner list suites/*.suite --tags                 the tags, to choose one
  scenario-runner list suites/*.suite -E 'model(commotions)' where that model walks

`scenario-runner run --list` prints the names of trials instead, one a line.")]
pub struct ListArguments {
    /// Suites (.suite) and scenarios (.scn, .yaml).
    #[arg(required = true, value_name = "FILE")]
    files: Vec<String>,
    /// List the tags instead, with how many scenarios have each.
    #[arg(long)]
    tags: bool,
    /// How it is written: to be read, or for other programs.
    #[arg(long, value_enum, default_value_t = Format::Text, conflicts_with = "tags")]
    format: Format,
    #[command(flatten)]
    filter: FilterArguments,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// A line for each.
    Text,
    /// One object with everything.
    Json,
}

/// A scenario, block, rating or gate.
struct Line<'a> {
    name: String,
    kind: &'static str,
    /// Of what, how many, in order.
    counts: Vec<(&'static str, usize)>,
    /// Whether the last count may turn out smaller.
    at_most: bool,
    tags: &'a [String],
    doc: Option<&'a str>,
    origin: &'a Origin,
}

pub fn list(arguments: &ListArguments, registry: &Registry) -> Exit {
    let colour = stderr().takes_colour();
    let filters = match arguments.filter.read(colour) {
        Ok(filters) => filters,
        Err(exit) => return exit,
    };
    let mut exit = Exit::Success;
    let mut suites: Vec<(&str, Suite, Plan)> = Vec::new();
    let mut known: HashSet<PathBuf> = HashSet::new();
    for file in arguments.files.iter().filter(|file| known.insert(Disk.identity(Path::new(file)))) {
        match planned(file, colour, registry) {
            Some((suite, plan)) => suites.push((file, suite, plan)),
            None => exit = Exit::Scenario,
        }
    }
    let names: Vec<_> = suites.iter().map(|(file, suite, _)| (*file, suite.name.as_str())).collect();
    for (prefix, (_, suite, _)) in key_prefixes(&names).into_iter().zip(&mut suites) {
        suite.apart = prefix;
    }
    let blocks: Vec<_> = suites.iter().map(|(_, suite, _)| Block::all(suite)).collect();
    let each = |show: &mut Show| {
        for ((file, suite, plan), blocks) in suites.iter().zip(&blocks) {
            filter::each_subject(suite, plan, blocks, file, show);
            suite.ratings.iter().for_each(|rating| show(&rating_subject(suite, file, rating)));
            suite.gates.iter().for_each(|gate| show(&gate_subject(suite, file, gate)));
        }
    };
    filter::warn(&filters, &each, colour);
    let mut lines = Vec::new();
    for ((file, suite, plan), blocks) in suites.iter().zip(&blocks) {
        let planned: HashMap<&str, &ScenarioPlan> =
            plan.scenarios().iter().map(|planned| (planned.scenario().name.as_str(), planned)).collect();
        for scenario in &suite.scenarios {
            let Some(planned) = planned.get(scenario.name.as_str()) else { continue };
            let selected = |trial: &PlannedTrial| {
                filter::with_trial(&suite.name, file, trial, |subject| filters.matches(subject))
            };
            let trials = match filters.is_empty() {
                true => planned.len(),
                false => planned.trials().filter(selected).count(),
            };
            if trials > 0 {
                let runs = trials * planned.runs();
                lines.push(Line {
                    name: format!("{}/{}", suite.key_name(), scenario.name),
                    kind: SCENARIO,
                    counts: vec![("trial", trials), ("run", runs)],
                    at_most: scenario.runs.is_some(),
                    tags: &scenario.tags,
                    doc: scenario.doc.as_deref(),
                    origin: &scenario.origin,
                });
            }
        }
        for block in blocks {
            let subject = filter::block(suite, file, block);
            if filters.matches(&subject) {
                lines.push(Line {
                    name: block.key(&suite.key_name()),
                    kind: block.kind(),
                    counts: size(block),
                    at_most: false,
                    tags: &[],
                    doc: block.doc(),
                    origin: block.origin(),
                });
            }
        }
        for rating in suite.ratings.iter().filter(|one| filters.matches(&rating_subject(suite, file, one))) {
            lines.push(Line {
                name: format!("{}/{RATING}={}", suite.key_name(), rating.name),
                kind: RATING,
                counts: vec![("cell", cells(plan, rating))],
                at_most: false,
                tags: &[],
                doc: rating.doc.as_deref(),
                origin: &rating.origin,
            });
        }
        for gate in suite.gates.iter().filter(|gate| filters.matches(&gate_subject(suite, file, gate))) {
            lines.push(Line {
                name: format!("{}/{GATE}={}", suite.key_name(), gate.name),
                kind: GATE,
                counts: vec![("rule", gate.rules.len())],
                at_most: false,
                tags: &[],
                doc: gate.doc.as_deref(),
                origin: &gate.origin,
            });
        }
    }
    if lines.is_empty() && exit == Exit::Success {
        writeln!(stderr(), "error: nothing is selected");
        writeln!(stderr(), "help: without -E, everything is listed");
        return Exit::NothingSelected;
    }
    match arguments.format {
        Format::Json => {
            let all = json!({ "version": 1, "listed": lines.iter().map(data).collect::<Vec<_>>() });
            stdout().verbatim(&format!("{all:#}\n"));
        }
        Format::Text if arguments.tags => show_tags(&lines),
        Format::Text => show(&lines),
    }
    exit
}

const GATE: &str = "gate";

/// What a filter may ask about a gate, which only `list` selects: a run judges every gate of its suite.
fn gate_subject<'a>(suite: &'a Suite, file: &'a str, gate: &'a Gate) -> Subject<'a> {
    Subject {
        suite: &suite.name,
        kind: GATE,
        name: &gate.name,
        tags: &[],
        models: Vec::new(),
        controllers: Vec::new(),
        files: vec![&gate.origin.file, file],
        variation: &[],
    }
}

const RATING: &str = "rating";

/// As [`gate_subject`], of a rating.
fn rating_subject<'a>(suite: &'a Suite, file: &'a str, rating: &'a Rating) -> Subject<'a> {
    Subject {
        suite: &suite.name,
        kind: RATING,
        name: &rating.name,
        tags: &[],
        models: Vec::new(),
        controllers: Vec::new(),
        files: vec![&rating.origin.file, file],
        variation: &[],
    }
}

/// The trials of scenarios with a tag that earns points.
fn cells(plan: &Plan, rating: &Rating) -> usize {
    let earns = |tag: &String| rating.points.iter().any(|points| points.tag == *tag);
    let rated = plan.scenarios().iter().filter(|planned| planned.scenario().tags.iter().any(earns));
    rated.map(|planned| planned.len()).sum()
}

/// How large a block is, by what it is made of.
fn size(block: &Block) -> Vec<(&'static str, usize)> {
    vec![match block {
        Block::Search(search) => ("evaluation", search.budget.evaluations as usize),
        Block::Tune(tune) => ("evaluation", tune.budget.evaluations as usize),
        Block::Calibrate(calibrate) => ("condition", calibrate.conditions()),
        Block::Estimate(estimate) => ("run", estimate.budget as usize),
        Block::Evaluate(evaluate) => ("condition", evaluate.conditions.len()),
        Block::Statement(statement) if statement.claims.is_empty() => return Vec::new(),
        Block::Statement(statement) => ("claim", statement.claims.len()),
    }]
}

fn planned(file: &str, colour: bool, registry: &Registry) -> Option<(Suite, Plan)> {
    let suite = match lang::load(Path::new(file), registry, &Disk) {
        Ok(loaded) => loaded.suite,
        Err(failure) => {
            stderr().styled(&failure.render(Style { colour }));
            return None;
        }
    };
    match plan::plan(&suite) {
        Ok(plan) => Some((suite, plan)),
        Err(errors) => {
            load::show(plan_notices(errors), colour);
            None
        }
    }
}

fn show(lines: &[Line]) {
    let names = lines.iter().map(|line| line.name.chars().count()).max().unwrap_or(0);
    let counts = lines.iter().map(|line| counts(line).chars().count()).max().unwrap_or(0);
    for line in lines {
        let tags: String = line.tags.iter().map(|tag| format!(" #{tag}")).collect();
        let shown = format!("{:names$}  {:counts$} {tags}", line.name, self::counts(line));
        writeln!(stdout(), "{}", shown.trim_end());
        if let Some(doc) = line.doc {
            writeln!(stdout(), "    {doc}");
        }
    }
}

/// Such as `3 trials, at most 60 runs`.
fn counts(line: &Line) -> String {
    let last = line.counts.len().saturating_sub(1);
    let each = line.counts.iter().enumerate().map(|(index, (what, number))| {
        let at_most = if line.at_most && index == last { "at most " } else { "" };
        format!("{at_most}{}", count(*number, what))
    });
    each.collect::<Vec<_>>().join(", ")
}

fn data(line: &Line) -> Value {
    let counts: Map<String, Value> =
        line.counts.iter().map(|(what, number)| (format!("{what}s"), json!(number))).collect();
    json!({
        "name": line.name, "kind": line.kind, "counts": counts, "at_most": line.at_most, "tags": line.tags,
        "doc": line.doc, "file": line.origin.file, "line": line.origin.line,
    })
}

fn show_tags(lines: &[Line]) {
    let mut tags: BTreeMap<&str, usize> = BTreeMap::new();
    for tag in lines.iter().flat_map(|line| line.tags) {
        *tags.entry(tag).or_default() += 1;
    }
    let width = tags.keys().map(|tag| tag.chars().count()).max().unwrap_or(0);
    for (tag, scenarios) in tags {
        writeln!(stdout(), "{tag:width$}  {}", count(scenarios, "scenario"));
    }
}

fn count(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}
