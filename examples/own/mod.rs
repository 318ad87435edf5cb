//! What the examples have in common: a file of scenarios run with a registry, and what came of it in tables.

use std::error::Error;

use scenario_runner::files::Disk;
use scenario_runner::project::Project;
use scenario_runner::registry::Registry;
use scenario_runner::report::{render_block, render_tables};
use scenario_runner::results::{BlockState, Event, Reporter};
use scenario_runner::run::Threads;
use scenario_runner::runner::{Orders, Session, units};

/// Runs everything in a file that may name what is in `registry`.
pub fn tables(file: &str, registry: &Registry) -> Result<String, Box<dyn Error>> {
    let project = Project::open(file, registry, &Disk)?;
    let threads = Threads::all();
    let session = Session::new(project.suites(), &threads, registry);
    let units = units(project.suites());
    let chosen = vec![true; units.len()];
    let orders = Orders { chosen: &chosen, first: &[], max_failures: None };
    let report = session.run(&units, &orders, &mut Silent).remove(0);
    let mut text = render_tables(&report, session.requests(), false);
    for block in &report.blocks {
        match &block.state {
            BlockState::Finished(result) => text += &render_block(result),
            _ => return Err("a block was not run to its end".into()),
        }
    }
    Ok(text)
}

struct Silent;

impl Reporter for Silent {
    fn tell(&mut self, _: &Event) {}
}
