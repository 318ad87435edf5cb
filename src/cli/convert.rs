//! `scenario-runner convert`: scenario files to YAML and back.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::Exit;
use crate::lang::{self, Sources, Style};

#[derive(Debug, Args)]
pub struct ConvertArguments {
    /// A scenario file or suite in either form.
    file: PathBuf,
    /// The form to write.
    #[arg(long, value_enum)]
    to: Form,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Form {
    Scn,
    Yaml,
}

pub fn convert(arguments: &ConvertArguments) -> Exit {
    let text = match std::fs::read_to_string(&arguments.file) {
        Ok(text) => text,
        Err(error) => {
            eprintln!("error: cannot read `{}`: {error}", arguments.file.display());
            return Exit::Usage;
        }
    };
    let mut sources = Sources::default();
    let source = sources.add(arguments.file.display().to_string(), text.as_str());
    let is_yaml =
        arguments.file.extension().is_some_and(|extension| extension == "yaml" || extension == "yml");
    let converted = match (is_yaml, arguments.to) {
        (true, Form::Scn) => lang::from_yaml(source, &text),
        (false, Form::Yaml) => lang::to_yaml(source, &text),
        _ => {
            eprintln!("error: `{}` has that form already", arguments.file.display());
            return Exit::Usage;
        }
    };
    match converted {
        Ok(text) => match std::io::stdout().write_all(text.as_bytes()) {
            Ok(()) => Exit::Success,
            Err(_) => Exit::Output,
        },
        Err(diagnostics) => {
            let colour = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
            eprint!("{}", lang::render_all(&diagnostics, &sources, Style { colour }));
            Exit::Scenario
        }
    }
}
