//! `scenario-runner list`: the scenarios and blocks of suites, with tags and counts.

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::path::Path;

use clap::Args;

use super::Exit;
use super::filter::{self, FilterArguments};
use super::load;
use crate::experiment::Block;
use crate::lang::filter::Subject;
use crate::lang::{self, Style};
use crate::plan::{self, Plan, Trial};
use crate::scenario::Suite;

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  scenario-runner list suites/*.suite                        everything with tags and counts
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
    #[command(flatten)]
    filter: FilterArguments,
}

/// A line about a scenario or block.
struct Line {
    name: String,
    counts: String,
    tags: Vec<String>,
    doc: Option<String>,
}

pub fn list(arguments: &ListArguments) -> Exit {
    let colour = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    let filters = match arguments.filter.read(colour) {
        Ok(filters) => filters,
        Err(exit) => return exit,
    };
    let mut exit = Exit::Success;
    let mut suites: Vec<(&str, Suite, Plan)> = Vec::new();
    for file in &arguments.files {
        match planned(file, colour) {
            Some((suite, plan)) => suites.push((file, suite, plan)),
            None => exit = Exit::Scenario,
        }
    }
    let subjects: Vec<Subject> =
        suites.iter().flat_map(|(file, suite, plan)| filter::subjects(suite, plan, file)).collect();
    filter::warn(&filters, &subjects, colour);
    let mut lines = Vec::new();
    for (file, suite, plan) in &suites {
        for scenario in &suite.scenarios {
            let selected = |trial: &&Trial| {
                trial.scenario == scenario.name && filters.matches(&filter::trial(&suite.name, file, trial))
            };
            let trials: Vec<&Trial> = plan.trials.iter().filter(selected).collect();
            if !trials.is_empty() {
                let runs = trials.iter().map(|trial| trial.cases.len()).sum();
                let at_most = if scenario.runs.is_some() { "at most " } else { "" };
                lines.push(Line {
                    name: format!("{}/{}", suite.name, scenario.name),
                    counts: format!("{}, {at_most}{}", count(trials.len(), "trial"), count(runs, "run")),
                    tags: scenario.tags.clone(),
                    doc: scenario.doc.clone(),
                });
            }
        }
        for block in Block::all(suite) {
            let subject = filter::block(suite, file, &block);
            if filters.matches(&subject) {
                lines.push(Line {
                    name: block.key(&suite.name),
                    counts: evaluations(&block),
                    tags: Vec::new(),
                    doc: block.doc().map(str::to_string),
                });
            }
        }
    }
    if lines.is_empty() && exit == Exit::Success {
        eprintln!("error: nothing is selected");
        eprintln!("help: without -E, everything is listed");
        return Exit::NothingSelected;
    }
    if arguments.tags {
        show_tags(&lines)
    } else {
        show(&lines)
    }
    exit
}

/// How much a block evaluates, where that is said.
fn evaluations(block: &Block) -> String {
    match block {
        Block::Search(search) => count(search.budget.evaluations as usize, "evaluation"),
        Block::Tune(tune) => count(tune.budget.evaluations as usize, "evaluation"),
        _ => String::new(),
    }
}

fn planned(file: &str, colour: bool) -> Option<(Suite, Plan)> {
    let suite = match lang::load(Path::new(file)) {
        Ok(loaded) => loaded.suite,
        Err(failure) => {
            eprint!("{}", failure.render(Style { colour }));
            return None;
        }
    };
    match plan::plan(&suite) {
        Ok(plan) => Some((suite, plan)),
        Err(errors) => {
            load::show_plan_errors(&errors, colour);
            None
        }
    }
}

fn show(lines: &[Line]) {
    let width = |of: fn(&Line) -> &str| lines.iter().map(|line| of(line).chars().count()).max().unwrap_or(0);
    let (names, counts) = (width(|line| &line.name), width(|line| &line.counts));
    for line in lines {
        let tags: String = line.tags.iter().map(|tag| format!(" #{tag}")).collect();
        let shown = format!("{:names$}  {:counts$} {tags}", line.name, line.counts);
        println!("{}", shown.trim_end());
        if let Some(doc) = &line.doc {
            println!("    {doc}");
        }
    }
}

fn show_tags(lines: &[Line]) {
    let mut tags: BTreeMap<&str, usize> = BTreeMap::new();
    for tag in lines.iter().flat_map(|line| &line.tags) {
        *tags.entry(tag).or_default() += 1;
    }
    let width = tags.keys().map(|tag| tag.chars().count()).max().unwrap_or(0);
    for (tag, scenarios) in tags {
        println!("{tag:width$}  {}", count(scenarios, "scenario"));
    }
}

fn count(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}
