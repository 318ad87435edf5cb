//! `scenario-runner models`: what is registered.

use clap::Args;

use super::Exit;
use report::console::{stderr, stdout};
use report::{render_model, render_models};
use scenario::registry::Registry;

#[derive(Debug, Args)]
pub struct ModelsArguments {
    /// Show everything about this one: parameters, units, defaults, ranges, sources.
    name: Option<String>,
}

pub fn models(arguments: &ModelsArguments, registry: &Registry) -> Exit {
    match &arguments.name {
        None => write!(stdout(), "{}", render_models(registry)),
        Some(name) => match render_model(name, registry) {
            Some(text) => write!(stdout(), "{text}"),
            None => {
                writeln!(stderr(), "error: nothing is called `{name}`");
                let similar = |known: &&str| (strsim::jaro_winkler(known, name) * 1000.0) as u32;
                let all = registry.declarations().into_iter().flat_map(|(_, declarations)| declarations);
                if let Some(nearest) = all.map(|one| &*one.name).max_by_key(similar) {
                    writeln!(
                        stderr(),
                        "help: the nearest name is `{nearest}`; `scenario-runner models` lists them all"
                    );
                }
                return Exit::Usage;
            }
        },
    }
    Exit::Success
}
