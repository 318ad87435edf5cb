//! `scenario-runner init`: a commented starter project.

use std::path::{Path, PathBuf};

use clap::Args;

use super::Exit;
use report::console::{stderr, stdout};

#[derive(Debug, Args)]
#[command(after_help = "\
Nothing is overwritten: if one of the files is there already, nothing is written and the program says which.

Examples:
  scenario-runner init                  into the current folder
  scenario-runner init tests/scenarios  into a folder, which is made if it is not there
  scenario-runner init --list           only show which files it would be")]
pub struct InitArguments {
    /// The folder.
    #[arg(default_value = ".")]
    folder: PathBuf,
    /// Only show which files would be written.
    #[arg(long, visible_alias = "dry-run")]
    list: bool,
}

/// Where each file of the project goes, what it is, and its text.
const FILES: &[(&str, &str, &str)] = &[
    (
        "scenarios/roads/street.scn",
        "roads that the scenarios use",
        include_str!("../../templates/starter/scenarios/roads/street.scn"),
    ),
    (
        "scenarios/zebra.scn",
        "people at a zebra crossing, and the controller under test",
        include_str!("../../templates/starter/scenarios/zebra.scn"),
    ),
    (
        "scenarios/hidden.scn",
        "somebody steps out from behind a parked van",
        include_str!("../../templates/starter/scenarios/hidden.scn"),
    ),
    (
        "suites/every_change.suite",
        "what runs on every change",
        include_str!("../../templates/starter/suites/every_change.suite"),
    ),
    (
        "suites/nightly.suite",
        "a search for the worst arrival times",
        include_str!("../../templates/starter/suites/nightly.suite"),
    ),
    (
        ".github/workflows/scenarios.yml",
        "runs the first suite on every push",
        include_str!("../../templates/starter/.github/workflows/scenarios.yml"),
    ),
    (".gitignore", "reports and traces", include_str!("../../templates/starter/gitignore")),
    ("README.md", "what is what, and what to do next", include_str!("../../templates/starter/README.md")),
];

pub fn init(arguments: &InitArguments) -> Exit {
    let at = |name: &str| arguments.folder.join(name);
    // A dangling link is in the way too.
    let in_the_way: Vec<PathBuf> =
        FILES.iter().map(|(name, ..)| at(name)).filter(|path| path.symlink_metadata().is_ok()).collect();
    if arguments.list {
        let width = FILES.iter().map(|(name, ..)| at(name).display().to_string().len()).max().unwrap_or(0);
        for (name, what, _) in FILES {
            let path = at(name);
            let taken = if in_the_way.contains(&path) { " (is there already)" } else { "" };
            writeln!(stdout(), "{:width$}  {what}{taken}", path.display());
        }
        return Exit::Success;
    }
    if !in_the_way.is_empty() {
        let taken: Vec<_> = in_the_way.iter().map(|path| path.display().to_string()).collect();
        writeln!(
            stderr(),
            "error: nothing is written, because these are there already: {}",
            taken.join(", ")
        );
        writeln!(
            stderr(),
            "help: name another folder, as in `scenario-runner init tests/scenarios`, or move them away"
        );
        return Exit::Usage;
    }
    for (name, _, text) in FILES {
        if let Err(error) = files::create_new(&at(name), text) {
            writeln!(stderr(), "error: cannot write `{}`: {error}", at(name).display());
            return Exit::Output;
        }
        writeln!(stdout(), "wrote {}", at(name).display());
    }
    let change = if arguments.folder == Path::new(".") {
        String::new()
    } else {
        format!("  cd {}\n", arguments.folder.display())
    };
    writeln!(
        stdout(),
        "\nNow:\n{change}  scenario-runner suites/every_change.suite       # runs, and passes\n  \
         then put your controller into scenarios/zebra.scn; README.md says what else there is"
    );
    Exit::Success
}
