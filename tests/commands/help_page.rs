//! `docs/command_line.md` is what the program says of its commands. `UPDATE_DOCS=1 cargo test --test commands help_page` rewrites it.

use std::path::Path;

use crate::support::generated::stands_in;
use crate::support::program::{code, scenario_runner, stdout};

const BEFORE: &str = "\
# The command line

What the program says of each command, as `scenario-runner help COMMAND` prints it. How runs are chosen, what is shown and what exit codes mean is told in
[running suites](running.md), what reports hold in [reports](reports.md).
";

/// The commands that a help lists.
fn commands(help: &str) -> Vec<String> {
    let listed = help.split("\nCommands:\n").nth(1).unwrap_or_default().split("\n\n").next().unwrap();
    let named = listed.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    named.filter_map(|line| line.split_whitespace().next()).map(str::to_string).collect()
}

/// The section of a command, and of those that it has itself.
fn push(page: &mut String, words: &[&str], level: usize) {
    // `help` knows commands and no commands of commands.
    let asked = match words {
        [] => vec!["help"],
        [command] => vec!["help", command],
        _ => [words, &["--help"]].concat(),
    };
    let output = scenario_runner(Path::new(env!("CARGO_MANIFEST_DIR")), &asked);
    assert_eq!(code(&output), 0, "{asked:?}");
    let help = stdout(&output);
    let heading =
        if words.is_empty() { "All commands".to_string() } else { format!("`{}`", words.join(" ")) };
    let marks = "#".repeat(level);
    let typed = asked.join(" ");
    page.push_str(&format!(
        "\n{marks} {heading}\n\n```sh\nscenario-runner {typed}\n```\n\n```text\n{}\n```\n",
        help.trim_end()
    ));
    for command in commands(&help).iter().filter(|command| *command != "help") {
        push(page, &[words, &[command]].concat(), level + usize::from(!words.is_empty()));
    }
}

#[test]
fn the_page_says_what_the_program_says() {
    let mut page = BEFORE.to_string();
    push(&mut page, &[], 2);
    assert!(page.contains("\n## `run`\n") && page.contains("\n### `baseline save`\n"), "{page}");
    stands_in("docs/command_line.md", &page);
}
