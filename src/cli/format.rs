//! `scenario-runner fmt`: the one style of scenario files.

use std::io::{IsTerminal, Read, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use super::Exit;
use crate::lang::{self, Sources, Style};

#[derive(Debug, Args)]
pub struct FormatArguments {
    /// Scenario files and suites; `-` formats standard input to standard output.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Write nothing and fail if a file is not in the style.
    #[arg(long)]
    check: bool,
}

pub fn format(arguments: &FormatArguments) -> Exit {
    let mut exit = Exit::Success;
    for file in &arguments.files {
        let outcome =
            if file == Path::new("-") { standard_input(arguments.check) } else { one(file, arguments.check) };
        if outcome != Exit::Success {
            exit = outcome;
        }
    }
    exit
}

fn one(file: &Path, check: bool) -> Exit {
    if file.extension().is_some_and(|extension| extension == "yaml" || extension == "yml") {
        let file = file.display();
        eprintln!("error: `{file}` is YAML, which has no one style");
        eprintln!("help: `scenario-runner convert {file} --to scn` turns it into what has");
        return Exit::Usage;
    }
    let text = match std::fs::read_to_string(file) {
        Ok(text) => text,
        Err(error) => {
            eprintln!("error: cannot read `{}`: {error}", file.display());
            return Exit::Usage;
        }
    };
    match formatted(&file.display().to_string(), &text) {
        None => Exit::Scenario,
        Some(after) if after == text => Exit::Success,
        Some(_) if check => {
            println!("{}", file.display());
            Exit::Unformatted
        }
        Some(after) => match std::fs::write(file, after) {
            Ok(()) => Exit::Success,
            Err(error) => {
                eprintln!("error: cannot write `{}`: {error}", file.display());
                Exit::Output
            }
        },
    }
}

fn standard_input(check: bool) -> Exit {
    let mut text = String::new();
    if let Err(error) = std::io::stdin().read_to_string(&mut text) {
        eprintln!("error: cannot read standard input: {error}");
        return Exit::Usage;
    }
    match formatted("<stdin>", &text) {
        None => Exit::Scenario,
        Some(after) if check => {
            if after == text {
                Exit::Success
            } else {
                Exit::Unformatted
            }
        }
        Some(after) => match std::io::stdout().write_all(after.as_bytes()) {
            Ok(()) => Exit::Success,
            Err(_) => Exit::Output,
        },
    }
}

fn formatted(name: &str, text: &str) -> Option<String> {
    let mut sources = Sources::default();
    let source = sources.add(name, text);
    lang::format(source, text)
        .map_err(|diagnostics| {
            let colour = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
            eprint!("{}", lang::render_all(&diagnostics, &sources, Style { colour }));
        })
        .ok()
}
