//! `-E EXPRESSION`: filter expressions on the command line.

use std::sync::Arc;

use clap::Args;

use super::Exit;
use lang::filter::{Each, Filters, SCENARIO, Show, Subject};
use lang::{self, Style};
use report::console::stderr;
use results::Recorded;
use runner::experiment::{Need, needs};
use runner::plan::{Plan, PlannedTrial};
use scenario::{Block, Case, CaseSet, Scenario, Suite};

/// For commands that may be about some of what is loaded.
#[derive(Debug, Clone, Default, Args)]
pub struct FilterArguments {
    /// Take only what this expression selects, such as 'tag(paper) & !model(jaywalker)'; given several times, what any
    /// of them selects. `scenario-runner help filter` explains the language.
    #[arg(short = 'E', long = "filter", value_name = "EXPRESSION")]
    expressions: Vec<String>,
}

impl FilterArguments {
    /// The expressions, read; what is wrong with them goes to stderr.
    pub fn read(&self, colour: bool) -> Result<Filters, Exit> {
        Filters::parse(&self.expressions).map_err(|failure| {
            stderr().styled(&failure.render(Style { colour }));
            Exit::Usage
        })
    }
}

/// Warns of predicates that match none of the subjects, which `each` shows one after the other.
pub fn warn(filters: &Filters, each: &Each, colour: bool) {
    for warning in filters.warnings(each) {
        stderr().styled(&format!("{}\n\n", lang::render(&warning, &filters.sources, Style { colour })));
    }
}

/// Shows what a filter may ask about a trial of the suite that was loaded from `file`.
pub fn with_trial<T>(suite: &str, file: &str, trial: &PlannedTrial, show: impl FnOnce(&Subject) -> T) -> T {
    let Case { world, variation, .. } = trial.cases.first();
    show(&Subject {
        suite,
        kind: SCENARIO,
        name: &trial.scenario,
        tags: &trial.tags,
        models: world.pedestrians.iter().map(|walker| walker.model.model.name()).collect(),
        controllers: world.vehicles.iter().map(|car| car.controller.model.name()).collect(),
        files: vec![&trial.origin.file, file],
        variation: &variation,
    })
}

/// What a filter may ask about a run that failed before: what it may ask about its scenario.
pub fn recorded<'a>(suite: &'a Suite, file: &'a str, recorded: &'a Recorded) -> Subject<'a> {
    let scenario = suite.scenarios.iter().find(|scenario| scenario.name == recorded.scenario);
    let walkers = scenario.iter().flat_map(|scenario| &scenario.pedestrians);
    let cars = scenario.iter().flat_map(|scenario| &scenario.vehicles);
    Subject {
        suite: &suite.name,
        kind: SCENARIO,
        name: &recorded.scenario,
        tags: scenario.map_or(&[], |scenario| &scenario.tags),
        models: walkers.map(|walker| walker.model.first.name()).collect(),
        controllers: cars.map(|car| car.controller.first.name()).collect(),
        files: scenario.map(|scenario| &*scenario.origin.file).into_iter().chain([file]).collect(),
        variation: &recorded.variation,
    }
}

/// What a filter may ask about a block: it has the tags, models and controllers of the scenarios that it works on.
pub fn block<'a>(suite: &'a Suite, file: &'a str, block: &'a Block) -> Subject<'a> {
    let scenarios = scenarios_of(suite, block);
    let cars = scenarios.iter().flat_map(|scenario| &scenario.vehicles);
    let walkers = scenarios.iter().flat_map(|scenario| &scenario.pedestrians);
    Subject {
        suite: &suite.name,
        kind: block.kind(),
        name: block.name(),
        tags: scenarios.first().map_or(&[], |scenario| &scenario.tags),
        models: walkers.map(|walker| walker.model.first.name()).collect(),
        controllers: cars.map(|car| car.controller.first.name()).collect(),
        files: vec![&block.origin().file, file],
        variation: &[],
    }
}

/// The scenarios that a block works on, by itself or through the blocks that it needs.
fn scenarios_of<'a>(suite: &'a Suite, block: &Block) -> Vec<&'a Scenario> {
    let set = match block {
        Block::Search(_) | Block::Calibrate(_) | Block::Estimate(_) | Block::Statement(_) => None,
        Block::Tune(tune) => Some(&tune.on),
        Block::Evaluate(evaluate) => Some(&evaluate.on),
    };
    let name = match (block, set) {
        (Block::Search(search), _) => Some(search.scenario.as_str()),
        (Block::Estimate(estimate), _) => Some(estimate.scenario.as_str()),
        (_, Some(CaseSet::Scenario(scenario) | CaseSet::Sample { scenario, .. })) => Some(scenario.as_str()),
        _ => None,
    };
    let mut scenarios: Vec<&Scenario> =
        suite.scenarios.iter().filter(|scenario| name == Some(scenario.name.as_str())).collect();
    if let Block::Calibrate(calibrate) = block {
        scenarios
            .extend(suite.scenarios.iter().filter(|scenario| calibrate.scenarios.contains(&scenario.name)));
    }
    for need in needs(block) {
        match need {
            Need::Scenario(name) => {
                scenarios.extend(suite.scenarios.iter().find(|scenario| scenario.name == name))
            }
            Need::Block(name) => {
                let needed = Block::all(suite).into_iter().find(|other| other.name() == name);
                scenarios.extend(needed.iter().flat_map(|needed| scenarios_of(suite, needed)));
            }
        }
    }
    scenarios
}

/// Shows everything that a filter may select of a suite: its trials, then its blocks.
pub fn each_subject(suite: &Suite, plan: &Plan, blocks: &[Arc<Block>], file: &str, show: &mut Show) {
    plan.trials().for_each(|planned| with_trial(&suite.name, file, &planned, &mut *show));
    blocks.iter().for_each(|found| show(&block(suite, file, found)));
}
