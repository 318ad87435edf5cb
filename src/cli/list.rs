//! `scenario-runner list`: the scenarios and blocks of suites.

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::path::PathBuf;

use clap::Args;

use super::Exit;
use crate::experiment::Block;
use crate::lang::{self, Style};
use crate::plan;

#[derive(Debug, Args)]
pub struct ListArguments {
    /// Suites and scenarios.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// List the tags instead, with how many scenarios have each.
    #[arg(long)]
    tags: bool,
}

pub fn list(arguments: &ListArguments) -> Exit {
    let mut exit = Exit::Success;
    let mut tags: BTreeMap<String, usize> = BTreeMap::new();
    for file in &arguments.files {
        let suite = match lang::load(file) {
            Ok(loaded) => loaded.suite,
            Err(failure) => {
                let colour = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
                eprint!("{}", failure.render(Style { colour }));
                exit = Exit::Scenario;
                continue;
            }
        };
        let plan = match plan::plan(&suite) {
            Ok(plan) => plan,
            Err(errors) => {
                for error in errors {
                    eprintln!("error: {}:{}: {error}", error.origin.file, error.origin.line);
                }
                exit = Exit::Scenario;
                continue;
            }
        };
        for scenario in &suite.scenarios {
            for tag in &scenario.tags {
                *tags.entry(tag.clone()).or_default() += 1;
            }
            if arguments.tags {
                continue;
            }
            let trials: Vec<_> = plan.trials.iter().filter(|trial| trial.scenario == scenario.name).collect();
            let runs: usize = trials.iter().map(|trial| trial.cases.len()).sum();
            let shown: String = scenario.tags.iter().map(|tag| format!(" #{tag}")).collect();
            println!("{}/{}  {} trials, {runs} runs{shown}", suite.name, scenario.name, trials.len());
            if let Some(doc) = &scenario.doc {
                println!("    {doc}");
            }
        }
        for block in Block::all(&suite).iter().filter(|_| !arguments.tags) {
            println!("{}{}", block.key(&suite.name), evaluations(block));
            if let Some(doc) = block.doc() {
                println!("    {doc}");
            }
        }
    }
    if arguments.tags {
        for (tag, count) in tags {
            println!("{tag}  {count}");
        }
    }
    exit
}

/// How much a block evaluates, where that is said; to be appended.
fn evaluations(block: &Block) -> String {
    match block {
        Block::Search(search) => format!("  {} evaluations", search.budget.evaluations),
        Block::Tune(tune) => format!("  {} evaluations", tune.budget.evaluations),
        _ => String::new(),
    }
}
