//! `scenario-runner explain`: what a code means.

use clap::Args;

use super::{Exit, help};
use lang::{self, Code, filter};
use report::console::{stderr, stdout};

#[derive(Debug, Args)]
pub struct ExplainArguments {
    /// Such as E0401, or `filter` for the language of filter expressions; without it, all codes are listed.
    code: Option<String>,
}

pub fn explain(arguments: &ExplainArguments) -> Exit {
    let Some(name) = &arguments.code else {
        for code in Code::ALL {
            writeln!(stdout(), "{}  {}", code.name(), code.title());
        }
        return Exit::Success;
    };
    if name == help::FILTER {
        write!(stdout(), "{}", filter::reference());
        return Exit::Success;
    }
    match Code::find(name) {
        Some(code) => {
            writeln!(stdout(), "{}: {}\n", code.name(), code.title());
            for line in wrapped(&code.explanation(), 100) {
                writeln!(stdout(), "{line}");
            }
            Exit::Success
        }
        None => {
            writeln!(stderr(), "error: there is no code `{name}`");
            match lang::nearest(name, Code::ALL.iter().map(|code| code.name())) {
                Some(near) => {
                    writeln!(
                        stderr(),
                        "help: did you mean `{near}`? `scenario-runner explain` lists them all"
                    )
                }
                None => writeln!(stderr(), "help: `scenario-runner explain` lists them all"),
            }
            Exit::Usage
        }
    }
}

/// The words in lines of at most `width` characters.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last_mut().filter(|line| line.chars().count() + word.chars().count() < width);
        match line {
            Some(line) => {
                if !line.is_empty() {
                    line.push(' ');
                }
                line.push_str(word);
            }
            None => lines.push(word.to_string()),
        }
    }
    lines
}
