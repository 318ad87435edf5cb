//! `scenario-runner init`: a commented starter project.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::Exit;
use files::escape::shell_path;
use report::console::{stderr, stdout};

#[derive(Debug, Args)]
#[command(after_help = "\
Nothing is overwritten: if one of the files is there already, nothing is written and the program says which.

Examples:
  scenario-runner init                  into the current folder
  scenario-runner init tests/scenarios  into a folder, which is made if it is not there
  scenario-runner init --list           only show which files it would be
  scenario-runner init --controller c   a controller of your own in C, and a scenario that it is tested in")]
pub struct InitArguments {
    /// The folder.
    #[arg(default_value = ".")]
    folder: PathBuf,
    /// Only show which files would be written.
    #[arg(long, visible_alias = "dry-run")]
    list: bool,
    /// Write a controller of one's own in that language instead, and a scenario that it is tested in.
    #[arg(long, value_enum, value_name = "LANGUAGE")]
    controller: Option<Language>,
}

/// What a controller of one's own is written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Language {
    Python,
    C,
    Rust,
}

/// Where a file goes, what it is, and its text.
type File = (&'static str, &'static str, &'static str);

/// Of projects with a controller of their own.
const CROSSING: File = (
    "scenarios/crossing.scn",
    "what the controller is tested in",
    include_str!("../../templates/controllers/scenarios/crossing.scn"),
);

/// A file of one language, which is called like its template unless said otherwise.
macro_rules! of_language {
    ($language:literal, $name:literal, $what:literal) => {
        of_language!($language, $name, $what, $name)
    };
    ($language:literal, $name:literal, $what:literal, $template:literal) => {
        ($name, $what, include_str!(concat!("../../templates/controllers/", $language, "/", $template)))
    };
}

const PYTHON: &[File] = &[
    of_language!("python", "controllers/my_av.py", "the controller"),
    of_language!("python", "controllers/my_av.scn", "its declaration"),
    CROSSING,
    of_language!("python", ".gitignore", "reports and traces", "gitignore"),
    of_language!("python", "README.md", "what is what, and what to do next"),
];

const C: &[File] = &[
    of_language!("c", "controllers/my_av.c", "the controller"),
    (
        "controllers/scenario_runner_av.h",
        "the protocol, which it includes",
        include_str!("../../sdk/c/scenario_runner_av.h"),
    ),
    of_language!("c", "controllers/my_av.scn", "its declaration"),
    CROSSING,
    of_language!("c", ".gitignore", "what is built, reports and traces", "gitignore"),
    of_language!("c", "README.md", "what is what, and what to do next"),
];

const RUST: &[File] = &[
    // Under another name, or the folder would be a package of its own among the templates.
    of_language!(
        "rust",
        "controllers/my_av/Cargo.toml",
        "the controller's manifest",
        "controllers/my_av/manifest.toml"
    ),
    of_language!("rust", "controllers/my_av/src/main.rs", "the controller"),
    of_language!("rust", "controllers/my_av.scn", "its declaration"),
    CROSSING,
    of_language!("rust", ".gitignore", "what is built, reports and traces", "gitignore"),
    of_language!("rust", "README.md", "what is what, and what to do next"),
];

impl Language {
    fn files(self) -> &'static [File] {
        match self {
            Self::Python => PYTHON,
            Self::C => C,
            Self::Rust => RUST,
        }
    }

    /// What has to be done before the program can be started.
    fn first(self) -> &'static str {
        match self {
            Self::Python => "",
            Self::C => "  cc -O2 -o controllers/my_av controllers/my_av.c\n",
            Self::Rust => "  cargo build --release --manifest-path controllers/my_av/Cargo.toml\n",
        }
    }
}

/// Of the project without a controller of its own.
const FILES: &[File] = &[
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
    let files = arguments.controller.map_or(FILES, Language::files);
    let at = |name: &str| arguments.folder.join(name);
    // A dangling link is in the way too.
    let in_the_way: Vec<PathBuf> =
        files.iter().map(|(name, ..)| at(name)).filter(|path| path.symlink_metadata().is_ok()).collect();
    if arguments.list {
        let width = files.iter().map(|(name, ..)| at(name).display().to_string().len()).max().unwrap_or(0);
        for (name, what, _) in files {
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
    for (name, _, text) in files {
        if let Err(error) = ::files::create_new(&at(name), text) {
            writeln!(stderr(), "error: cannot write `{}`: {error}", at(name).display());
            return Exit::Output;
        }
        writeln!(stdout(), "wrote {}", at(name).display());
    }
    let change = if arguments.folder == Path::new(".") {
        String::new()
    } else {
        format!("  cd {}\n", shell_path(&arguments.folder.to_string_lossy()))
    };
    if let Some(language) = arguments.controller {
        writeln!(
            stdout(),
            "\nNow:\n{change}{}  scenario-runner allow controllers/my_av.scn   # lets the program run\n  \
             scenario-runner scenarios/crossing.scn        # runs it, and passes\n  \
             README.md says how to let it fail, and what else there is",
            language.first()
        );
        return Exit::Success;
    }
    writeln!(
        stdout(),
        "\nNow:\n{change}  scenario-runner suites/every_change.suite       # runs, and passes\n  \
         then put your controller into scenarios/zebra.scn; README.md says what else there is"
    );
    Exit::Success
}
