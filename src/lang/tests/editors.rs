//! What editors ask of the language: names, renames, hints, colours and fixes, over what ships and over small texts.

use std::path::{Path, PathBuf};

use files::{Disk, Files, Memory};
use models::standard;
use proptest::prelude::*;
use proptest::sample::select;
use regex_lite::Regex;

use crate::symbols::Symbols;
use crate::syntax::ast::{self, View};
use crate::texts::Texts;
use crate::{Code, SymbolKind, coloured, fixes, hints, references, rename, rename_place};

const BASE: &str = "\
let pace = 5 km/h
road street { lanes forward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra; parked van { along: 20 m, beside: 1 m } }
define base(delay = 2 s) {
  road street
  vehicle av { controller idm_aeb; speed 30 km/h; start 40 m before crossing }
  pedestrian walkers times 3 { model scripted { speed: pace }; start 2 m from kerb; appears at tta + delay }
  expect { no collision(av, walkers_2); pet(av, walkers) >= 1 s }
}
";

const WALK: &str = "\
use \"base.scn\"
scenario walk : base(delay: 1 s) {
  vary tta in [1 s, 2 s]
  vehicle av { speed 36 km/h }
  expect { no collision(av, van) when tta = 1 s }
}
scenario other : base {
  vary tta in [3 s]
}
search nearest {
  in walk
  over tta in 1 s .. 4 s
  minimise min(pet)
  budget 10 evaluations
}
statement slower {
  claim mean(pet) of walk >= 1 s
}
";

const SUITE: &str = "\
suite all {
  scenarios \"walk.scn\"
  test idm_aeb as av
  expect { no collision(av) }
}
";

fn files() -> Memory {
    Memory::default().with("base.scn", BASE).with("walk.scn", WALK).with("all.suite", SUITE)
}

fn others() -> Vec<PathBuf> {
    ["base.scn", "walk.scn", "all.suite"].map(PathBuf::from).to_vec()
}

/// The lines on which a name stands, with `!` where it is given.
fn lines(file: &str, text: &str, at: &str, behind: usize) -> Vec<String> {
    let offset = text.find(at).unwrap() + behind;
    let (found, sources) = references(Path::new(file), offset, &others(), &standard(), &files()).unwrap();
    let place = |one: &crate::NamedPlace| {
        let source = sources.get(one.span.source);
        let mark = if one.defines { "!" } else { "" };
        format!("{}:{}{mark}", source.name, sources.location(one.span).line)
    };
    found.iter().map(place).collect()
}

#[test]
fn names_are_followed_over_files_bases_suites_and_blocks() {
    let mut found = lines("walk.scn", WALK, "vehicle av", 8);
    found.sort();
    assert_eq!(
        found,
        [
            "all.suite:3",
            "all.suite:4",
            "base.scn:5!",
            "base.scn:7",
            "base.scn:7",
            "walk.scn:4!",
            "walk.scn:5"
        ]
    );
    let mut found = lines("walk.scn", WALK, "tta", 0);
    found.sort();
    // What a base leaves open is the name of all that build on it.
    assert_eq!(found, ["base.scn:6", "walk.scn:12", "walk.scn:3!", "walk.scn:5", "walk.scn:8!"]);
    assert_eq!(lines("base.scn", BASE, "walkers", 0), ["base.scn:6!", "base.scn:7", "base.scn:7"]);
    assert_eq!(lines("base.scn", BASE, "pace", 0), ["base.scn:1!", "base.scn:6"]);
    assert_eq!(lines("base.scn", BASE, "delay", 0), ["base.scn:3!", "base.scn:6", "walk.scn:2"]);
    assert_eq!(lines("base.scn", BASE, "van", 0), ["base.scn:2!", "walk.scn:5"]);
    assert_eq!(lines("base.scn", BASE, "street", 0), ["base.scn:2!", "base.scn:4"]);
    assert_eq!(lines("walk.scn", WALK, "walk :", 0), ["walk.scn:2!", "walk.scn:11", "walk.scn:17"]);
    for built_in in ["idm_aeb", "collision", "zebra", "road street", "scripted", "speed: "] {
        assert_eq!(lines("base.scn", BASE, built_in, 1), [""; 0], "{built_in}");
    }
}

/// What a rename makes of the three files, or why it is refused.
fn renamed(file: &str, text: &str, at: &str, behind: usize, new: &str) -> Result<String, String> {
    let offset = text.find(at).unwrap() + behind;
    let mut all: Vec<(&str, String)> =
        vec![("base.scn", BASE.into()), ("walk.scn", WALK.into()), ("all.suite", SUITE.into())];
    let rename = rename(Path::new(file), offset, new, &others(), &standard(), &files())?;
    let mut edits = rename.edits;
    edits.sort_by_key(|edit| edit.range.start);
    for edit in edits.iter().rev() {
        let (_, text) = all.iter_mut().find(|(name, _)| *name == edit.file).unwrap();
        text.replace_range(edit.range.clone(), &edit.text);
    }
    Ok(all.into_iter().map(|(_, text)| text).collect())
}

#[test]
fn a_rename_changes_every_place_and_nothing_else() {
    let all = format!("{BASE}{WALK}{SUITE}");
    let word = |old: &str| Regex::new(&format!(r"\b{old}\b")).unwrap();
    for (file, text, at, behind, old) in [
        ("walk.scn", WALK, "vehicle av", 8, "av"),
        ("all.suite", SUITE, "as av", 5, "av"),
        ("base.scn", BASE, "tta", 0, "tta"),
        ("base.scn", BASE, "pace", 4, "pace"),
        ("walk.scn", WALK, "delay", 2, "delay"),
        ("walk.scn", WALK, "walk :", 0, "walk"),
        ("walk.scn", WALK, "nearest", 0, "nearest"),
        ("base.scn", BASE, "street", 0, "street"),
    ] {
        let expected = word(old).replace_all(&all, "fresh").replace("fresh.scn", "walk.scn");
        assert_eq!(renamed(file, text, at, behind, "fresh").unwrap(), expected, "{old}");
    }
    let group = renamed("base.scn", BASE, "walkers", 0, "people").unwrap();
    assert!(group.contains("collision(av, people_2); pet(av, people)"), "{group}");
}

#[test]
fn a_rename_is_refused_with_its_reason() {
    let refused = |file, text, at, behind, new| renamed(file, text, at, behind, new).unwrap_err();
    for (new, why) in [("1st", "is no name"), ("in", "is no name"), ("a b", "is no name"), ("", "is no name")]
    {
        assert!(refused("walk.scn", WALK, "vehicle av", 8, new).contains(why), "{new}");
    }
    for (file, text, at, behind, new, why) in [
        ("walk.scn", WALK, "vehicle av", 8, "walkers", "is a pedestrian already, in base.scn:6"),
        ("walk.scn", WALK, "vehicle av", 8, "van", "already"),
        ("walk.scn", WALK, "walk :", 0, "other", "is a scenario already, in walk.scn:7"),
        ("walk.scn", WALK, "walk :", 0, "nearest", "already"),
        ("base.scn", BASE, "pace", 4, "tta", "already"),
        ("base.scn", BASE, "pace", 4, "delay", "already"),
        ("base.scn", BASE, "idm_aeb", 0, "other", "here stands none"),
        ("base.scn", BASE, "speed", 0, "other", "here stands none"),
    ] {
        let said = refused(file, text, at, behind, new);
        assert!(said.contains(why), "{at} -> {new}: {said}");
    }
    // Where something cannot be read that may be the name, nothing is changed.
    let broken = files().with("broken.scn", "scenario b : base {\n  vehicle av { speeed 3 }\n}\n");
    let mut all = others();
    all.push("broken.scn".into());
    let offset = WALK.find("vehicle av").unwrap() + 8;
    let said = rename(Path::new("walk.scn"), offset, "ego", &all, &standard(), &broken).unwrap_err();
    assert!(said.contains("`broken.scn`") && said.contains("mend that first"), "{said}");
    // Nor where not all is read.
    let large = files().with("large.scn", format!("# {}\n", "x".repeat(4 << 20)).as_str());
    let mut all = others();
    all.push("large.scn".into());
    let said = rename(Path::new("walk.scn"), offset, "ego", &all, &standard(), &large).unwrap_err();
    assert!(said.contains("not every file"), "{said}");
    assert!(references(Path::new("walk.scn"), offset, &all, &standard(), &large).is_err());
    let own = "controller own {\n  command \"a\"\n  parameter gap = 5 m in 1 m .. 30 m\n}\n";
    let one = Memory::default().with("own.scn", own);
    let said = rename_place(Path::new("own.scn"), own.find("gap").unwrap(), &standard(), &one).unwrap_err();
    assert!(said.contains("a program knows"), "{said}");
}

fn shipped() -> Vec<PathBuf> {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../");
    let mut all: Vec<PathBuf> = ["scenarios/**/*.scn", "suites/**/*.suite"]
        .iter()
        .flat_map(|pattern| Disk.matching(&format!("{root}{pattern}")).unwrap())
        .map(|path| path.canonicalize().unwrap())
        .collect();
    all.sort();
    assert!(all.len() > 50, "{}", all.len());
    all
}

/// Names in what ships that are neither given by a file nor by the registry would be silently left out of a rename.
#[test]
fn every_name_of_what_ships_is_found_or_is_a_word_of_the_registry() {
    let registry = standard();
    let mut unknown = Vec::new();
    for path in shipped() {
        let mut files = Texts::new(&registry, &Disk);
        let Some(file) = files.open(&path, None, &mut Vec::new()) else { continue };
        let symbols = Symbols::of(&mut files);
        let tree = files.tree(file);
        for node in tree.nodes().filter(|node| ast::Name::cast(*node).is_some()) {
            let text = node.text();
            let ships = registry.controllers().get(text).is_some()
                || registry.pedestrians().get(text).is_some()
                || registry.dynamics().get(text).is_some()
                || registry.metrics().get(text).is_some();
            let is_known = symbols
                .occurrences
                .iter()
                .any(|one| one.span.source == node.span().source && one.span.start == node.span().start);
            if !ships && !is_known {
                unknown.push(format!(
                    "{}:{} {text}",
                    path.display(),
                    files.sources.location(node.span()).line
                ));
            }
        }
    }
    let unknown: Vec<&String> =
        unknown.iter().filter(|one| !KNOWN.iter().any(|word| one.ends_with(word))).collect();
    assert!(unknown.is_empty(), "{unknown:#?}");
}

/// Populations and distributions that ship, and conditions that the language gives: they stand where a name may stand.
const KNOWN: &[&str] = &[" standard", " humans", " default"];

/// Whatever is renamed, what is loaded is what was loaded, but for the name.
#[test]
fn what_ships_means_the_same_after_a_rename() {
    let registry = standard();
    let origins = Regex::new(
        r#"Origin \{ file: "[^"]*", line: \d+, column: \d+, source_line: "(?:[^"\\]|\\.)*", length: \d+ \}"#,
    )
    .unwrap();
    let mut tried = 0;
    for (index, path) in shipped().into_iter().enumerate() {
        // Each name takes two loads of everything that the file uses.
        // These two name tunes, evaluations and roads, which no other of every tenth file does.
        let is_of_its_own = ["paper/tune.scn", "rules/fmvss_127.scn"].iter().any(|own| path.ends_with(own));
        if !(index % 10 == 0 || is_of_its_own) || std::fs::metadata(&path).unwrap().len() > 20_000 {
            continue;
        }
        let mut files = Texts::new(&registry, &Disk);
        let Some(file) = files.open(&path, None, &mut Vec::new()) else { continue };
        let source = files.tree(file).source;
        let symbols = Symbols::of(&mut files);
        let own: Vec<_> = symbols.occurrences.iter().filter(|one| one.span.source == source).collect();
        let mut seen = std::collections::BTreeSet::new();
        for one in own.iter().filter(|one| seen.insert(one.symbol)) {
            if one.kind == SymbolKind::ProgramParameter {
                continue;
            }
            let old = files.sources.text(one.span).to_string();
            // What is kept by name stays in its order.
            let new = &format!("{old}0");
            let made = rename(&path, one.span.start, new, &[], &registry, &Disk)
                .unwrap_or_else(|error| panic!("{}: {old}: {error}", path.display()));
            tried += 1;
            let mut texts: Vec<(String, String)> = Vec::new();
            let mut edits = made.edits.clone();
            edits.sort_by_key(|edit| std::cmp::Reverse(edit.range.start));
            for edit in edits {
                if !texts.iter().any(|(file, _)| *file == edit.file) {
                    texts.push((edit.file.clone(), std::fs::read_to_string(&edit.file).unwrap()));
                }
                let (_, text) = texts.iter_mut().find(|(file, _)| *file == edit.file).unwrap();
                text.replace_range(edit.range.clone(), &edit.text);
            }
            let mut with = files::Overlay::of(&Disk);
            for (file, text) in &texts {
                with = with.with(Path::new(file), text);
            }
            let meaning = |files: &dyn Files| {
                let loaded = crate::load(&path, &registry, files).map(|mut loaded| {
                    loaded.suite.texts.clear();
                    loaded.suite
                });
                let text = match loaded {
                    Ok(suite) => format!("{suite:?}"),
                    Err(failure) => failure.diagnostics.iter().map(|one| one.code.name()).collect(),
                };
                let text = origins.replace_all(&text, "");
                let old = Regex::new(&format!(r"\b{old}(_\d+)?\b")).unwrap();
                old.replace_all(&text, format!("{new}$1")).into_owned()
            };
            let (before, after) = (meaning(&Disk), meaning(&with));
            assert!(before == after, "{}: {old}", path.display());
        }
    }
    assert!(tried > 25, "{tried}");
}

#[test]
fn hints_say_what_is_not_written() {
    let text = "\
let pace = 5 km/h
let word = normal
let half = pace / 2
scenario a {
  let own = pace * 2
  vary tta in [1 s, 2 min]
  vary pace in [1 m/s, 2 m/s]
  vehicle av { speed 30 km/h; start half * 3 s before crossing; controller idm_aeb }
  pedestrian w { model scripted { speed: pace }; start 2 m from kerb; appears at tta; along each(50 cm) }
  expect { pet >= 1.5 s in 95 % of runs }
}
";
    let found = hints(Path::new("a.scn"), text, &standard(), &Memory::default().with("a.scn", text));
    let shown: Vec<String> = found
        .iter()
        .map(|hint| {
            let line = text[..hint.at].rsplit('\n').next().unwrap();
            format!("{}{}", line.trim(), hint.text)
        })
        .collect();
    assert_eq!(
        shown,
        [
            "let pace = 5 km/h= 1.389 m/s",
            "let half = pace / 2= 0.6944 m/s",
            "vary tta in [1 s, 2 min= 120 s",
            "vehicle av { speed 30 km/h= 8.333 m/s",
            "vehicle av { speed 30 km/h; start half * 3 s= 2.083 m",
            "pedestrian w { model scripted { speed: pace }; start 2 m from kerb; appears at tta; along each(50 cm= 0.5 m",
        ]
    );
}

#[test]
fn words_are_coloured_by_what_they_are() {
    let files = files();
    let found = coloured(Path::new("walk.scn"), WALK, &standard(), &files);
    assert!(found.windows(2).all(|two| two[0].end <= two[1].start));
    let shown: Vec<String> = found
        .iter()
        .take_while(|one| !WALK[..one.start].contains("scenario other"))
        .map(|one| {
            format!("{} {:?}{}", &WALK[one.start..one.end], one.colour, if one.defines { "!" } else { "" })
        })
        .collect();
    insta::assert_snapshot!(shown.join("\n"));
    // Of what cannot be read there are no words of the language.
    let broken = "scenario a {\n  vehicle av { speeed 30 km/h }\n}\n";
    let found = coloured(Path::new("b.scn"), broken, &standard(), &files);
    assert!(found.iter().all(|one| !broken[one.start..].starts_with("speeed")), "{found:?}");
}

/// Each: a text, its error, and the fix that is to be taken of those that there are.
const FIXABLE: &[(Code, &str, &str)] = &[
    (Code::UnknownUnit, "let a = 30 kmh\n", "Write `km/h`"),
    (Code::UnknownStatement, "let a = 1\nscenaro a {\n}\n", "Write `scenario`"),
    (Code::UnknownName, "let pace = 1 m\nlet b = pase * 2\n", "Write `pace`"),
    (Code::UnclosedString, "use \"a.scn\n", "Write `\"a.scn\"`"),
    (Code::UnopenedBracket, "let a = 1\n}\n", "Remove `}`"),
    (
        Code::UnclosedBracket,
        "scenario a {\n  vehicle av {\n    speed 3 m/s\n\n  expect { no collision }\n}\n",
        "Close it with `}`",
    ),
    (Code::UnknownMetric, "SCENE  expect { no colision }\n}\n", "Write `collision`"),
    (
        Code::UnknownController,
        "FIRST  vehicle av { controller idm_aeeb; speed 3 m/s; start 9 m before crossing }\nREST}\n",
        "Write `idm_aeb`",
    ),
    (
        Code::UnknownParameter,
        "FIRST  vehicle av { controller carla_behavior { braking_distanc: 5 m }; speed 3 m/s; start 9 m before crossing }\nREST}\n",
        "Write `braking_distance`",
    ),
    (
        Code::MissingUnit,
        "FIRST  vehicle av { controller idm_aeb; speed 3; start 9 m before crossing }\nREST}\n",
        "Write `3 m/s`",
    ),
    (
        Code::MissingStatement,
        "FIRST  vehicle av { controller idm_aeb; start 9 m before crossing }\nREST}\n",
        "Say `speed",
    ),
    (
        Code::RepeatedStatement,
        "FIRST  vehicle av { controller idm_aeb; speed 3 m/s; speed 4 m/s; start 9 m before crossing }\nREST}\n",
        "Remove `speed 4 m/s",
    ),
    (Code::UnusedName, "SCENE  let idle = 3 m\n  expect { no collision }\n}\n", "Remove `let idle = 3 m`"),
    (Code::NoCriteria, "SCENE}\n", "Say `expect { no collision }`"),
    (
        Code::UnknownRoad,
        "road street { lane_width 4 m; speed_limit 9 m/s; crossing zebra }\nscenario a {\n  road stret\nREST  vehicle av { controller idm_aeb; speed 3 m/s; start 9 m before crossing }\n}\n",
        "Write `street`",
    ),
    (Code::UnknownVehicle, "SCENE  expect { no collision(va) }\n}\n", "Write `av`"),
];

#[test]
fn each_fix_takes_its_error_away() {
    let rest = "  pedestrian walker { model scripted; start 2 m from kerb; appears at 1 s }\n";
    let first = "scenario a {\n  road { lane_width 4 m; speed_limit 9 m/s; crossing zebra }\n";
    let scene = format!(
        "{first}  vehicle av {{ controller idm_aeb; speed 3 m/s; start 9 m before crossing }}\n{rest}"
    );
    for (code, text, title) in FIXABLE {
        let mut text = text.replace("SCENE", &scene).replace("FIRST", first).replace("REST", rest);
        let errors = |text: &str| {
            let files = Memory::default().with("a.scn", text);
            let found = crate::examine(Path::new("a.scn"), &standard(), &files).found;
            found.iter().filter(|one| one.code == *code).count()
        };
        let before = errors(&text);
        assert!(before > 0, "{code}: {text}");
        let files = Memory::default().with("a.scn", text.as_str());
        let found = fixes(Path::new("a.scn"), &text, 0..text.len(), &standard(), &files);
        let fix = found.iter().find(|fix| fix.code == *code && fix.title.starts_with(title));
        let fix = fix.unwrap_or_else(|| panic!("{code}: {found:#?}"));
        text.replace_range(fix.range.clone(), &fix.text);
        assert_eq!(errors(&text), before - 1, "{code}:\n{text}");
    }
}

proptest! {
    /// At every place of every text there is an answer, whatever the text.
    #[test]
    fn no_text_is_too_broken_to_be_asked_about(pieces in proptest::collection::vec(select(super::PIECES), 0..40)) {
        let text = pieces.concat();
        let (path, registry) = (Path::new("a.scn"), standard());
        let files = Memory::default().with("a.scn", text.as_str());
        hints(path, &text, &registry, &files);
        let found = coloured(path, &text, &registry, &files);
        prop_assert!(found.windows(2).all(|two| two[0].end <= two[1].start));
        fixes(path, &text, 0..text.len(), &registry, &files);
        for offset in (0..=text.len()).filter(|at| text.is_char_boundary(*at)).step_by(7) {
            references(path, offset, &[], &registry, &files).unwrap();
            let _ = rename(path, offset, "entirely_new", &[], &registry, &files);
        }
    }
}
