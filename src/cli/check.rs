//! `scenario-runner check`: errors and warnings without running anything.

use std::collections::HashSet;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::Exit;
use files::Disk;
use lang::{self, Diagnostic, Severity, Sources};
use report::console::{stderr, stdout};
use report::{Repository, findings};
use runner::project::examine;
use scenario::registry::Registry;

#[derive(Debug, Args)]
pub struct CheckArguments {
    /// Suites and scenarios.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// How findings are written: to be read, or for other programs.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// As a compiler does, on stderr.
    Text,
    /// One object with all findings.
    Json,
    /// Workflow commands that GitHub shows beside the changed lines.
    Github,
    /// SARIF 2.1.0, for code scanning.
    Sarif,
}

/// Checks every file and shows all findings of all files.
pub fn check(arguments: &CheckArguments, registry: &Registry) -> Exit {
    let mut checked: Vec<(Vec<Diagnostic>, Sources)> = Vec::new();
    for file in &arguments.files {
        checked.push(examine(file, registry, &Disk));
    }
    forget_repeated(&mut checked);
    let failed = checked.iter().flat_map(|(found, _)| found).any(|found| found.severity == Severity::Error);
    let text = match arguments.format {
        Format::Text => {
            show(&checked, arguments.files.len());
            String::new()
        }
        Format::Json => findings::json(&checked),
        Format::Github => findings::github(&checked, &Repository::here()),
        Format::Sarif => findings::sarif(&checked, &Repository::here()),
    };
    stdout().verbatim(&text);
    if failed { Exit::Scenario } else { Exit::Success }
}

/// Files that several of the checked files use have their findings shown once.
fn forget_repeated(checked: &mut [(Vec<Diagnostic>, Sources)]) {
    let mut seen = HashSet::new();
    for (diagnostics, sources) in checked {
        diagnostics.retain(|diagnostic| {
            let span = diagnostic.span();
            seen.insert((sources.get(span.source).name.clone(), span.start, diagnostic.message.clone()))
        });
    }
}

fn show(checked: &[(Vec<Diagnostic>, Sources)], files: usize) {
    let style = lang::Style { colour: stderr().takes_colour() };
    let mut all = Vec::new();
    for (diagnostics, sources) in checked {
        for diagnostic in diagnostics {
            stderr().styled(&format!("{}\n\n", lang::render(diagnostic, sources, style)));
            all.push(diagnostic);
        }
    }
    let checked = if files == 1 { "1 file".to_string() } else { format!("{files} files") };
    writeln!(
        stderr(),
        "checked {checked}: {}",
        lang::count(all.iter().map(|diagnostic| diagnostic.severity))
    );
}
