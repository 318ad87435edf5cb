//! What the examples have in common: a file of scenarios run with a registry, and what came of it in tables.

use std::error::Error;

use scenario_runner::Disk;
use scenario_runner::Project;
use scenario_runner::registry::Registry;
use scenario_runner::report::{render_block, render_tables};
use scenario_runner::results::{BlockState, Unheard};
use scenario_runner::{Selection, Session};

/// Runs everything in a file that may name what is in `registry`.
pub fn tables(file: &str, registry: &Registry) -> Result<String, Box<dyn Error>> {
    let project = Project::open(file, registry, &Disk)?;
    let results = Session::new(&project).run(&Selection::all(), &mut Unheard)?;
    let report = &results.suites[0];
    let mut text = render_tables(report, &results.requests, false);
    for block in &report.blocks {
        match &block.state {
            BlockState::Finished(result) => text += &render_block(result),
            _ => return Err("a block was not run to its end".into()),
        }
    }
    Ok(text)
}
