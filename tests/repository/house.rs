//! The rules of the house that can be read off its sources: which room may know which, and how files and names look.
//!
//! What is compiled for tests alone may look around freely.

#![allow(clippy::disallowed_methods, reason = "reads its own sources")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The packages and which of them each may know, in the order in which they stand on each other. Cargo keeps the arrows: what is not in
/// a manifest cannot be imported.
pub(crate) const PACKAGES: [(&str, &[&str]); 16] = [
    ("grammar", &[]),
    ("reader", &["grammar"]),
    ("numbers", &[]),
    ("files", &[]),
    ("optimise", &["numbers", "files"]),
    ("scenario", &["numbers", "files", "optimise"]),
    ("sim", &["numbers", "scenario"]),
    ("results", &["numbers", "files", "optimise", "scenario", "sim"]),
    ("models", &["numbers", "files", "scenario", "sim"]),
    ("lang", &["grammar", "reader", "files", "scenario"]),
    ("fmu", &["files"]),
    ("under_test", &["files", "scenario", "sim", "fmu"]),
    ("engines", &["files"]),
    ("runner", &["numbers", "files", "optimise", "scenario", "sim", "under_test", "results", "lang"]),
    ("report", &["numbers", "files", "optimise", "scenario", "sim", "results", "lang"]),
    (
        FRONT,
        &[
            "numbers",
            "files",
            "scenario",
            "sim",
            "under_test",
            "engines",
            "results",
            "models",
            "lang",
            "runner",
            "report",
        ],
    ),
];

/// The package at the top: the front door, the program and suites as tests.
const FRONT: &str = "scenario-runner";

/// The rooms of packages that have several, each of which knows only rooms before it. What lies in no folder of its own is the room
/// that is called like its package.
const ROOMS: [(&str, &[&str]); 8] = [
    ("files", &["escape", "files"]),
    ("scenario", &["scenario", "population", "registry"]),
    ("sim", &["sim", "measure"]),
    ("results", &["results", "judge"]),
    ("models", &["metrics", "pedestrian", "vehicle", "calibrate", "models"]),
    (
        "runner",
        &[
            "plan",
            "run",
            "baseline",
            "corpus",
            "shrink",
            "why",
            "experiment",
            "diff",
            "project",
            "gap_choice",
            "session",
            "shards",
            "watch",
            "runner",
        ],
    ),
    ("report", &["console", "svg", "drawing", "report"]),
    (FRONT, &["testing", "cli", FRONT]),
];

/// Lines of a file, at most.
const LONGEST: usize = 800;

pub(crate) struct Source {
    pub(crate) path: PathBuf,
    pub(crate) package: String,
    room: String,
    /// All of it.
    pub(crate) text: String,
    /// Without comments and what is compiled for tests.
    code: String,
}

pub(crate) fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut paths = Vec::new();
    walk(&root, &mut paths);
    paths.sort();
    let texts: BTreeMap<PathBuf, String> =
        paths.iter().map(|path| (path.clone(), fs::read_to_string(path).unwrap())).collect();
    let for_tests: BTreeSet<PathBuf> =
        texts.iter().flat_map(|(path, text)| test_modules(path, text)).collect();
    let is_for_tests =
        |path: &Path| for_tests.iter().any(|module| path.with_extension("").starts_with(module));
    texts
        .into_iter()
        .filter(|(path, _)| !is_for_tests(path))
        .map(|(path, text)| {
            let inside = path.strip_prefix(&root).unwrap();
            let (package, room) = place(inside);
            Source { package, room, code: code(&text), path: inside.to_path_buf(), text }
        })
        .collect()
}

/// The package and the room of a file, by its path below `src`.
fn place(inside: &Path) -> (String, String) {
    let mut parts = inside.iter().map(|part| part.to_string_lossy().trim_end_matches(".rs").to_string());
    let first = parts.next().unwrap();
    let (package, inner) = match PACKAGES.iter().any(|(name, _)| *name == first) {
        true => (first, parts.next()),
        false => (FRONT.to_string(), Some(first)),
    };
    let room = inner.filter(|inner| rooms(&package).contains(&inner.as_str()));
    (package.clone(), room.unwrap_or(package))
}

/// The rooms of a package, in order.
fn rooms(package: &str) -> &'static [&'static str] {
    ROOMS.iter().find(|(name, _)| *name == package).map_or(&[], |(_, rooms)| rooms)
}

fn walk(folder: &Path, paths: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            walk(&path, paths);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            paths.push(path);
        }
    }
}

/// The modules in other files that a file declares for tests alone, as paths without ending.
fn test_modules(path: &Path, text: &str) -> Vec<PathBuf> {
    let folder = match path.file_stem().unwrap().to_str().unwrap() {
        "mod" | "lib" | "main" => path.parent().unwrap().to_path_buf(),
        _ => path.with_extension(""),
    };
    let lines: Vec<&str> = text.lines().collect();
    let declared = |pair: &[&str]| {
        let is_for_tests = pair[0].trim().starts_with("#[cfg(test)]");
        let name = pair[1].trim().trim_start_matches("pub ").trim_start_matches("pub(crate) ");
        let name = name.strip_prefix("mod ")?.strip_suffix(';')?;
        is_for_tests.then(|| folder.join(name))
    };
    lines.windows(2).filter_map(declared).collect()
}

fn code(text: &str) -> String {
    let end = text
        .find("#[cfg(test)]\nmod ")
        .filter(|at| text[*at..].lines().nth(1).is_some_and(|line| line.ends_with('{')));
    let lines = text[..end.unwrap_or(text.len())].lines();
    lines.filter(|line| !line.trim_start().starts_with("//")).map(|line| format!("{line}\n")).collect()
}

/// The rooms that are named by paths such as `crate::sim::Step` and `crate::{sim, metrics}`.
fn known_rooms(code: &str) -> BTreeSet<String> {
    let mut rooms = BTreeSet::new();
    for (at, start) in code.match_indices("crate::") {
        let rest = &code[at + start.len()..];
        let word = |text: &str| -> String {
            text.chars().take_while(|one| one.is_alphanumeric() || *one == '_').collect()
        };
        let Some(group) = rest.strip_prefix('{') else {
            rooms.insert(word(rest));
            continue;
        };
        let mut depth = 0;
        let mut begins = true;
        for (at, one) in group.char_indices() {
            match one {
                '}' if depth == 0 => break,
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => begins = true,
                _ if begins && !one.is_whitespace() => {
                    rooms.insert(word(&group[at..]));
                    begins = false;
                }
                _ => {}
            }
        }
    }
    rooms
}

pub(crate) fn complain(broken: Vec<String>) {
    assert!(broken.is_empty(), "\n{}\n", broken.join("\n"));
}

/// The packages of ours that a manifest names, for what is shipped.
fn known_packages(manifest: &str) -> BTreeSet<String> {
    let section = manifest.split("\n[").find(|section| section.starts_with("dependencies]"));
    let names =
        section.into_iter().flat_map(str::lines).filter_map(|line| line.split(['.', ' ', '=']).next());
    names.filter(|name| PACKAGES.iter().any(|(package, _)| package == name)).map(str::to_string).collect()
}

pub(crate) fn manifest(package: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = match package {
        FRONT => root.to_path_buf(),
        "grammar" => root.join("grammar"),
        _ => root.join("src").join(package),
    };
    fs::read_to_string(folder.join("Cargo.toml")).unwrap()
}

#[test]
fn packages_know_only_those_below_them() {
    let mut below = BTreeSet::new();
    for (package, known) in PACKAGES {
        let found = known_packages(&manifest(package));
        let listed: BTreeSet<String> = known.iter().map(ToString::to_string).collect();
        assert_eq!(found, listed, "what `{package}` depends on");
        assert!(found.is_subset(&below), "`{package}` depends on what stands above it");
        below.insert(package.to_string());
    }
}

#[test]
fn no_room_knows_one_above_it() {
    let mut broken = Vec::new();
    for Source { path, package, room, code, .. } in sources() {
        let rooms = rooms(&package);
        let place = |room: &str| rooms.iter().position(|one| *one == room);
        let Some(own) = place(&room).filter(|own| own + 1 < rooms.len() || room != package) else { continue };
        for known in known_rooms(&code) {
            // What is no room is the package's own.
            let known = if rooms.contains(&known.as_str()) { known } else { package.clone() };
            if place(&known).is_some_and(|other| other > own) {
                broken.push(format!("{}: `{room}` imports `{known}`, which is above it", path.display()));
            }
        }
    }
    complain(broken);
}

#[test]
fn a_file_says_what_it_is_about_and_has_one_idea() {
    let broken = sources().into_iter().filter_map(|Source { path, text, .. }| {
        let lines = text.lines().count();
        let path = path.display();
        if !text.starts_with("//! ") {
            Some(format!("{path}: its first line does not say what it is about"))
        } else if lines > LONGEST {
            Some(format!("{path}: {lines} lines, more than {LONGEST}"))
        } else {
            None
        }
    });
    complain(broken.collect());
}

#[test]
fn a_name_stands_for_one_type() {
    let mut types: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for Source { path, code, .. } in sources() {
        for line in code.lines() {
            let Some(declared) = line.trim_start().strip_prefix("pub ") else { continue };
            let mut words = declared.split(|one: char| !one.is_alphanumeric() && one != '_');
            if let (Some("struct" | "enum" | "trait" | "type"), Some(name)) = (words.next(), words.next())
                // An associated type is its trait's.
                && !name.is_empty()
                && !(declared.starts_with("type ") && line.starts_with(' '))
            {
                types.entry(name.to_string()).or_default().push(path.display().to_string());
            }
        }
    }
    let twice = types.into_iter().filter(|(_, files)| files.len() > 1);
    complain(twice.map(|(name, files)| format!("`{name}` is declared in {}", files.join(", "))).collect());
}

/// What is registered is a value that is handed down: another of it may be made, and added to.
#[test]
fn nothing_is_registered_globally() {
    // Of these there is one a process: its standard streams, who gives it memory, and a thread's own notes. What the language
    // consists of is compiled in with its grammar, and so are the populations that ship.
    const CONSTANT: [&str; 8] = [
        "main.rs",
        "report/console.rs",
        "runner/run/panic.rs",
        "runner/run/name.rs",
        "lang/units.rs",
        "lang/syntax/ast/",
        "lang/syntax/words/",
        "scenario/population/plausibility.rs",
    ];
    let mut broken = Vec::new();
    for Source { path, code, .. } in sources() {
        let path = path.display().to_string();
        for line in code.lines().filter(|line| line.contains("static ") && line.contains(": ")) {
            let declared = line.trim_start().trim_start_matches("pub ").trim_start_matches("pub(crate) ");
            if declared.starts_with("static ") && !CONSTANT.iter().any(|constant| path.starts_with(constant))
            {
                broken.push(format!("{path}: {}", line.trim()));
            }
        }
    }
    complain(broken);
}

/// What is read, and whether it is there, is asked of the `Files` that whoever opens a project brings.
#[test]
fn the_language_and_the_runner_know_no_disk() {
    const DISK: [&str; 8] = [
        "files::read_",
        "read_kind(",
        "std::fs",
        "glob::glob",
        ".is_file()",
        ".is_dir()",
        ".exists()",
        "canonicalize(",
    ];
    let mut broken = Vec::new();
    for Source { path, package, code, .. } in sources() {
        let reads = DISK.iter().filter(|word| code.contains(*word));
        if ["lang", "runner"].contains(&package.as_str()) {
            broken.extend(reads.map(|word| format!("{}: `{word}`", path.display())));
        }
    }
    complain(broken);
}

/// Suites as tests, the command line and the language server are what any Rust program could make of the front door: of what stands below
/// they use no more than that offers.
#[test]
fn suites_as_tests_and_the_command_line_use_the_front_door() {
    // What hidden commands are: the program itself, in another process.
    const BESIDES: [&str; 2] = ["under_test::fmu_host", "under_test::supervise_if_asked"];
    // Packages that the front door offers as a whole.
    const WHOLE: [&str; 5] = ["models", "report", "results", "scenario", "sim"];
    // Helpers for files and numbers are no part of what is run.
    const HELPERS: [&str; 2] = ["files", "numbers"];
    let offered = used(&sources().iter().find(|source| source.path == Path::new("lib.rs")).unwrap().code);
    assert!(offered.contains("runner::session::Session"), "the front door was not read: {offered:?}");
    assert!(WHOLE.iter().all(|package| offered.contains(*package)));
    let mut broken = Vec::new();
    for Source { path, room, code, .. } in sources() {
        if !["testing", "cli"].contains(&room.as_str()) {
            continue;
        }
        for name in used(&code) {
            let package = name.split("::").next().unwrap();
            let is_ours = PACKAGES.iter().any(|(known, _)| *known == package);
            let is_free =
                [&WHOLE[..], &HELPERS].concat().contains(&package) || BESIDES.contains(&name.as_str());
            if !is_ours || is_free {
                continue;
            }
            let of_a_module = through(&code, &name);
            let names = if of_a_module.is_empty() { BTreeSet::from([name]) } else { of_a_module };
            let is_offered = |name: &String| offered.iter().any(|known| name == known || within(name, known));
            let missing = names.iter().filter(|name| !is_offered(name));
            broken.extend(
                missing.map(|name| format!("{}: `{name}` is not offered by the front door", path.display())),
            );
        }
    }
    complain(broken);
}

/// Whether it is something of a type or of a module that is offered as a whole.
fn within(name: &str, offered: &str) -> bool {
    name.strip_prefix(offered).is_some_and(|rest| rest.starts_with("::"))
}

/// What code takes out of a module or package that it imports under its name, as whole paths: `plan::plan(…)` for `runner::plan`.
fn through(code: &str, module: &str) -> BTreeSet<String> {
    let name = module.rsplit("::").next().unwrap();
    if name.starts_with(char::is_uppercase) {
        return BTreeSet::new();
    }
    let beginning = format!("{name}::");
    let starts = code.match_indices(&beginning).map(|(at, _)| at);
    let own = starts.filter(|at| {
        !code[..*at].ends_with([':', '_'])
            && !code[..*at].ends_with(char::is_alphanumeric)
            && !code[..*at].rsplit(';').next().unwrap().trim_start().starts_with("use ")
    });
    let path = |at: usize| {
        let path = &code[at + name.len()..];
        let end = path.find(|c: char| c != ':' && c != '_' && !c.is_alphanumeric()).unwrap_or(path.len());
        format!("{module}{}", path[..end].trim_end_matches(':'))
    };
    own.map(path).collect()
}

/// Every name that `use` gives, as its whole path.
fn used(code: &str) -> BTreeSet<String> {
    fn flatten(before: &str, tree: &str, found: &mut BTreeSet<String>) {
        let tree = tree.trim();
        let Some((path, group)) = tree.split_once('{') else {
            let name = tree.split(" as ").next().unwrap().trim();
            let whole = format!("{before}{name}");
            found.insert(whole.trim_end_matches("::self").to_string());
            return;
        };
        let before = format!("{before}{path}");
        let (mut depth, mut start) = (0, 0);
        let group = group.strip_suffix('}').expect("a group ends");
        for (at, one) in group.char_indices().chain([(group.len(), ',')]) {
            match one {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    if !group[start..at].trim().is_empty() {
                        flatten(&before, &group[start..at], found);
                    }
                    start = at + 1;
                }
                _ => {}
            }
        }
    }
    let mut found = BTreeSet::new();
    for statement in code.split(';') {
        let lines: Vec<&str> = statement.trim_start().rsplit('\n').map(str::trim_start).collect();
        let Some(at) = lines.iter().position(|line| line.starts_with("use ") || line.starts_with("pub use "))
        else {
            continue;
        };
        let whole: String = lines[..=at].iter().rev().copied().collect();
        flatten("", whole.trim_start_matches("pub ").trim_start_matches("use "), &mut found);
    }
    found
}

/// Otherwise the rules above would hold of nothing.
#[test]
fn the_rooms_are_those_of_the_sources() {
    let found: BTreeSet<String> = sources().into_iter().map(|source| source.package).collect();
    let known =
        PACKAGES.iter().map(|(package, _)| package.to_string()).filter(|package| package != "grammar");
    assert_eq!(found, known.collect());
    for (package, rooms) in ROOMS {
        let found: BTreeSet<String> = sources()
            .into_iter()
            .filter(|source| source.package == package)
            .map(|source| source.room)
            .collect();
        assert_eq!(found, rooms.iter().map(ToString::to_string).collect(), "the rooms of `{package}`");
    }
}

/// What no `main.rs` names would never run, and nobody would miss it.
#[test]
fn every_file_of_tests_is_one_of_its_program() {
    let mut broken = Vec::new();
    for folder in ["commands", "conditional", "repository", "simulation"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(folder);
        let main = fs::read_to_string(folder.join("main.rs")).unwrap();
        let named = |name: &str| main.lines().any(|line| line == format!("mod {name};"));
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            if path.extension().is_some_and(|extension| extension == "rs") && name != "main" && !named(&name)
            {
                broken.push(format!("{}: `mod {name};` is missing in main.rs", path.display()));
            }
        }
    }
    complain(broken);
}

#[test]
fn places_and_manifests_are_read_as_cargo_does() {
    let of = |path: &str| place(Path::new(path));
    assert_eq!(of("runner/run/job.rs"), ("runner".to_string(), "run".to_string()));
    assert_eq!(of("runner/baseline.rs"), ("runner".to_string(), "baseline".to_string()));
    assert_eq!(of("lang/lib.rs"), ("lang".to_string(), "lang".to_string()));
    assert_eq!(of("cli/run/mod.rs"), (FRONT.to_string(), "cli".to_string()));
    assert_eq!(of("main.rs"), (FRONT.to_string(), FRONT.to_string()));
    let manifest = "[package]\nname = \"x\"\n\n[dependencies]\nsim.workspace = true\nserde = \"1\"\n\n[dev-dependencies]\nmodels.workspace = true\n";
    assert_eq!(known_packages(manifest).into_iter().collect::<Vec<_>>(), ["sim"]);
}

#[test]
fn uses_are_read_as_the_compiler_does() {
    let code =
        "pub mod a {\n    pub use x::{\n        B, c::{self, D as E},\n    };\n}\nuse y;\nlet z = 1;\n";
    assert_eq!(used(code).into_iter().collect::<Vec<_>>(), ["x::B", "x::c", "x::c::D", "y"]);
}

#[test]
fn what_is_taken_out_of_a_module_is_seen() {
    let code = "use runner::plan::{self, Plan};\nlet a = plan::plan(&b);\nlet c = my_plan::other();\nlet d = x::plan::third();\nplan::fourth()";
    let found = through(code, "runner::plan");
    assert_eq!(found.into_iter().collect::<Vec<_>>(), ["runner::plan::fourth", "runner::plan::plan"]);
    assert!(through(code, "runner::plan::Plan").is_empty());
    assert!(within("lang::Style::default", "lang::Style") && !within("lang::Styles", "lang::Style"));
}

#[test]
fn paths_are_read_as_the_compiler_does() {
    let found = known_rooms(
        "use crate::sim::Step;\nuse crate::{metrics::{self, Meter}, plan};\nlet x = crate::run::go();",
    );
    assert_eq!(found.into_iter().collect::<Vec<_>>(), ["metrics", "plan", "run", "sim"]);
    let text = "use crate::a;\n// crate::b\n#[cfg(test)]\nmod tests {\n    use crate::c;\n}\n";
    assert_eq!(code(text), "use crate::a;\n");
    assert_eq!(
        test_modules(Path::new("src/x/mod.rs"), "#[cfg(test)]\npub mod fixture;\nmod y;\n"),
        [Path::new("src/x/fixture")]
    );
}
