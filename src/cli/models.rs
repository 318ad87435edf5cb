//! `scenario-runner models`: the registries.

use clap::Args;

use super::Exit;
use crate::console::{stderr, stdout};
use crate::report::{registered_names, render_model, render_models};

#[derive(Debug, Args)]
pub struct ModelsArguments {
    /// Show everything about this one: parameters, units, defaults, ranges, sources.
    name: Option<String>,
}

pub fn models(arguments: &ModelsArguments) -> Exit {
    match &arguments.name {
        None => write!(stdout(), "{}", render_models()),
        Some(name) => match render_model(name) {
            Some(text) => write!(stdout(), "{text}"),
            None => {
                writeln!(stderr(), "error: nothing is called `{name}`");
                let similar = |known: &&str| (strsim::jaro_winkler(known, name) * 1000.0) as u32;
                if let Some(nearest) = registered_names().into_iter().max_by_key(similar) {
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
