//! The rules of the house that can be read off its sources: which room may know which, and how files and names look.
//!
//! What is compiled for tests alone may look around freely.

#![allow(clippy::disallowed_methods, reason = "reads its own sources")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The rooms, each of which knows only rooms before it.
const ROOMS: [&str; 26] = [
    "numbers",
    "escape",
    "files",
    "console",
    "optimise",
    "scenario",
    "registry",
    "sim",
    "metrics",
    "results",
    "pedestrian",
    "vehicle",
    "models",
    "calibrate",
    "lang",
    "plan",
    "run",
    "judge",
    "corpus",
    "shrink",
    "experiment",
    "project",
    "runner",
    "report",
    "cli",
    "testing",
];

/// Rooms that do not know each other, though their order would allow it: what is first may be replaced without the
/// second's knowing.
const STRANGERS: [(&str, &str); 10] = [
    ("report", "models"),
    ("report", "pedestrian"),
    ("report", "vehicle"),
    ("report", "runner"),
    ("report", "experiment"),
    ("lang", "models"),
    ("judge", "lang"),
    ("experiment", "lang"),
    ("metrics", "pedestrian"),
    ("testing", "cli"),
];

/// Lines of a file, at most.
const LONGEST: usize = 800;

struct Source {
    path: PathBuf,
    room: String,
    /// All of it.
    text: String,
    /// Without comments and what is compiled for tests.
    code: String,
}

fn sources() -> Vec<Source> {
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
            let room = inside.components().next().unwrap().as_os_str().to_string_lossy();
            let room = room.trim_end_matches(".rs").to_string();
            Source { room, code: code(&text), path: inside.to_path_buf(), text }
        })
        .collect()
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

fn complain(broken: Vec<String>) {
    assert!(broken.is_empty(), "\n{}\n", broken.join("\n"));
}

#[test]
fn no_room_knows_one_above_it() {
    let place = |room: &str| ROOMS.iter().position(|one| *one == room);
    let mut broken = Vec::new();
    for Source { path, room, code, .. } in sources() {
        let path = path.display();
        let Some(own) = place(&room) else {
            if !["lib", "main"].contains(&room.as_str()) {
                broken.push(format!("{path}: a room that stands in no order; put it into ROOMS"));
            }
            continue;
        };
        for known in known_rooms(&code).iter().filter(|known| **known != room) {
            match place(known) {
                Some(other) if other > own => {
                    broken.push(format!("{path}: `{room}` imports `{known}`, which is above it"))
                }
                _ if STRANGERS.contains(&(&room, known)) => {
                    broken.push(format!("{path}: `{room}` must not know `{known}`"))
                }
                _ => {}
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
    // Of these there is one a process: its standard streams, and a thread's own notes. What the language consists of is
    // compiled in with its grammar.
    const CONSTANT: [&str; 5] =
        ["console.rs", "run/panic.rs", "run/name.rs", "lang/units.rs", "lang/syntax/words/"];
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

/// Otherwise the rules above would hold of nothing.
#[test]
fn the_rooms_are_those_of_the_sources() {
    let found: BTreeSet<String> = sources().into_iter().map(|source| source.room).collect();
    let known = ROOMS.iter().chain(&["lib", "main"]).map(ToString::to_string);
    assert_eq!(found, known.collect());
    let of_no_room =
        STRANGERS.iter().flat_map(|(one, other)| [one, other]).filter(|room| !ROOMS.contains(room));
    assert_eq!(of_no_room.collect::<Vec<_>>(), Vec::<&&str>::new());
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
