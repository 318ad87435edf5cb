//! `scenario-runner convert`: scenario files to YAML and back.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::Exit;
use lang::{self, Sources, Style};
use report::console::{stderr, stdout};

#[derive(Debug, Args)]
pub struct ConvertArguments {
    /// A scenario file or suite in either form; `-` reads standard input.
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
    let is_standard_input = arguments.file == Path::new("-");
    let text =
        if is_standard_input { files::read_standard_input() } else { files::read_text(&arguments.file) };
    let text = match text {
        Ok(text) => text,
        Err(error) => {
            writeln!(stderr(), "error: cannot read `{}`: {error}", arguments.file.display());
            return Exit::Usage;
        }
    };
    let mut sources = Sources::default();
    let source = sources.add(arguments.file.display().to_string(), text.as_str());
    let is_yaml = if is_standard_input {
        arguments.to == Form::Scn
    } else {
        arguments.file.extension().is_some_and(|extension| extension == "yaml" || extension == "yml")
    };
    let converted = match (is_yaml, arguments.to) {
        (true, Form::Scn) => lang::from_yaml(source, &text),
        (false, Form::Yaml) => lang::to_yaml(source, &text),
        _ => {
            writeln!(stderr(), "error: `{}` has that form already", arguments.file.display());
            return Exit::Usage;
        }
    };
    match converted {
        Ok(text) => {
            stdout().verbatim(&text);
            Exit::Success
        }
        Err(diagnostics) => {
            let colour = stderr().takes_colour();
            stderr().styled(&lang::render_all(&diagnostics, &sources, Style { colour }));
            Exit::Scenario
        }
    }
}
