//! `scenario-runner fmt`: the one style of scenario files.

use std::path::{Path, PathBuf};

use clap::Args;

use super::Exit;
use files::escape::shell_path;
use lang::{self, Sources, Style};
use report::console::{stderr, stdout};

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
        let named = shell_path(&file.to_string_lossy());
        writeln!(stderr(), "error: `{}` is YAML, which has no one style", file.display());
        writeln!(stderr(), "help: `scenario-runner convert {named} --to scn` turns it into what has");
        return Exit::Usage;
    }
    let text = match files::read_text(file) {
        Ok(text) => text,
        Err(error) => {
            writeln!(stderr(), "error: cannot read `{}`: {error}", file.display());
            return Exit::Usage;
        }
    };
    match formatted(&file.display().to_string(), &text) {
        None => Exit::Scenario,
        Some(after) if after == text => Exit::Success,
        Some(_) if check => {
            writeln!(stdout(), "{}", file.display());
            Exit::Unformatted
        }
        Some(after) => match files::write(file, after) {
            Ok(()) => Exit::Success,
            Err(error) => {
                writeln!(stderr(), "error: cannot write `{}`: {error}", file.display());
                Exit::Output
            }
        },
    }
}

fn standard_input(check: bool) -> Exit {
    let text = match files::read_standard_input() {
        Ok(text) => text,
        Err(error) => {
            writeln!(stderr(), "error: cannot read standard input: {error}");
            return Exit::Usage;
        }
    };
    match formatted("<stdin>", &text) {
        None => Exit::Scenario,
        Some(after) if check => {
            if after == text {
                Exit::Success
            } else {
                Exit::Unformatted
            }
        }
        Some(after) => {
            stdout().verbatim(&after);
            Exit::Success
        }
    }
}

fn formatted(name: &str, text: &str) -> Option<String> {
    let mut sources = Sources::default();
    let source = sources.add(name, text);
    lang::format(source, text)
        .map_err(|diagnostics| {
            let colour = stderr().takes_colour();
            stderr().styled(&lang::render_all(&diagnostics, &sources, Style { colour }));
        })
        .ok()
}
