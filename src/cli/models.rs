//! `scenario-runner models`: what is registered, and which controllers a file declares.

use std::path::Path;

use clap::Args;

use super::{Exit, load};
use files::Disk;
use lang::Style;
use report::console::{stderr, stdout};
use report::{render_declared, render_model, render_models};
use scenario::registry::Registry;

#[derive(Debug, Args)]
pub struct ModelsArguments {
    /// Show everything about this one: parameters, units, defaults, ranges, sources.
    #[arg(value_name = "NAME")]
    name: Option<String>,

    /// A file (.suite, .scn, .yaml) with the controllers that it declares or brings along. Nothing of it is started.
    #[arg(value_name = "FILE")]
    file: Option<String>,
}

pub fn models(arguments: &ModelsArguments, registry: &Registry) -> Exit {
    let (name, file) = match (&arguments.name, &arguments.file) {
        (Some(file), None) if load::names_a_file(file) => (None, Some(file)),
        (name, file) => (name.as_ref(), file.as_ref()),
    };
    let known = match file.map_or_else(|| Ok(registry.clone()), |file| with_declared(file, registry)) {
        Ok(known) => known,
        Err(exit) => return exit,
    };
    match name {
        None => {
            write!(stdout(), "{}", render_models(&known));
            known.controllers().iter().for_each(|model| write!(stdout(), "{}", render_declared(model)));
        }
        Some(name) => match render_model(name, &known) {
            Some(text) => {
                write!(stdout(), "{text}");
                let own = known.controllers().get(name);
                own.into_iter().for_each(|model| write!(stdout(), "{}", render_declared(model)));
            }
            None => {
                writeln!(stderr(), "error: nothing is called `{name}`");
                let similar = |known: &&str| (strsim::jaro_winkler(known, name) * 1000.0) as u32;
                let all = known.declarations().into_iter().flat_map(|(_, declarations)| declarations);
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

/// What is registered, with the controllers that a file declares or brings along.
fn with_declared(file: &str, registry: &Registry) -> Result<Registry, Exit> {
    if !load::names_a_file(file) {
        writeln!(stderr(), "error: {file} is no scenario file");
        writeln!(stderr(), "help: files end in .suite, .scn or .yaml");
        return Err(Exit::Usage);
    }
    lang::with_controllers(Path::new(file), registry, &Disk).map_err(|failure| {
        stderr().styled(&format!("{}\n", failure.render(Style { colour: stderr().takes_colour() })));
        Exit::Scenario
    })
}
