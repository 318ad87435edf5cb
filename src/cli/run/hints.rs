//! What somebody may have meant who named nothing that there is.

use std::path::{Path, PathBuf};

use clap::Command;

use crate::cli::exit::Exit;
use files::escape::{shell_path, terminal_line};
use report::console::stderr;

/// The command of `program` that a word is nearly.
pub fn command(word: &str, program: &Command) -> Option<String> {
    let names: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
    lang::nearest(word, names.iter().copied()).map(str::to_string)
}

/// What to say where a filter selects nothing, which is a whole name if it is `exact`; `command` is what the word may have been meant to be.
pub fn selection(word: Option<&str>, exact: bool, command: Option<String>, keys: &[&str]) -> Vec<String> {
    let Some(word) = word else { return Vec::new() };
    let parts = keys.iter().filter(|_| !exact).flat_map(|key| key.split('/')).chain(keys.iter().copied());
    let name = lang::nearest(word, parts).map(|near| format!("did you mean `{near}`?"));
    let command = command
        .map(|near| format!("words that are no files select trials; did you mean the command `{near}`?"));
    command.into_iter().chain(name).collect()
}

/// As many files are listed.
const MOST_LISTED: usize = 30;

/// Says which suites there are in this folder and how to run one; without any, which scenarios.
pub fn project() -> Exit {
    writeln!(stderr(), "error: no suite or scenario is named");
    let files = found_here();
    let Some(first) = files.first() else {
        writeln!(
            stderr(),
            "help: there are none in this folder; `scenario-runner init` writes a project that runs"
        );
        return Exit::Usage;
    };
    let is_suite = first.extension().is_some_and(|ending| ending == "suite");
    let what = if is_suite { "suites" } else { "scenario files" };
    let width = files.iter().take(MOST_LISTED).map(|file| file.display().to_string().chars().count());
    let width = width.max().unwrap_or(0);
    writeln!(stderr(), "help: there are these {what} here:");
    for file in files.iter().take(MOST_LISTED) {
        let doc = doc(file).unwrap_or_default();
        writeln!(
            stderr(),
            "{}",
            format!("  {:<width$}  {}", terminal_line(&file.display().to_string()), terminal_line(&doc))
                .trim_end()
        );
    }
    if files.len() > MOST_LISTED {
        writeln!(stderr(), "  and {} more", files.len() - MOST_LISTED);
    }
    let first = shell_path(&first.to_string_lossy());
    writeln!(stderr(), "help: run one of them by `scenario-runner {first}`");
    Exit::Usage
}

/// Refuses more words than one that name no file.
pub fn one_filter(filters: &[&String]) -> Result<(), Exit> {
    if filters.len() < 2 {
        return Ok(());
    }
    let filters: Vec<_> = filters.iter().map(|filter| format!("`{filter}`")).collect();
    writeln!(stderr(), "error: more than one filter: {}", filters.join(", "));
    writeln!(
        stderr(),
        "help: files end in .suite, .scn or .yaml; give one filter, and use --skip to leave trials out"
    );
    Err(Exit::Usage)
}

/// The suites of this folder and down to two below it; if there are none, the scenarios.
pub fn found_here() -> Vec<PathBuf> {
    ["suite", "scn"].into_iter().map(files_of).find(|files| !files.is_empty()).unwrap_or_default()
}

/// Files of a kind in this folder and down to two below it, hidden ones and what Cargo builds left out.
fn files_of(kind: &str) -> Vec<PathBuf> {
    let options = glob::MatchOptions { require_literal_leading_dot: true, ..Default::default() };
    let patterns = ["*", "*/*", "*/*/*"].map(|stem| format!("{stem}.{kind}"));
    let found = patterns.iter().filter_map(|pattern| glob::glob_with(pattern, options).ok()).flatten();
    let found = found.filter_map(Result::ok).filter(|path| path.is_file() && !path.starts_with("target"));
    found.collect()
}

/// What a suite says of itself.
fn doc(file: &Path) -> Option<String> {
    let text = files::read_text(file).ok()?;
    lang::suite_doc(&text)
}
