//! What holds for every text: the bodies of the fuzz targets, which the test suite runs too (`tests/repository/fuzz.rs`).

use std::path::Path;

use files::{Disk, Overlay};
use lang::filter::{Filters, SCENARIO, Show, Subject};
use lang::{self, Sources, Style};
use models::standard;
use scenario::{Assignment, Value};

/// A file name in a folder that does not exist, so that the texts' own file names lead nowhere.
fn nowhere(name: &str) -> std::path::PathBuf {
    Path::new("/nowhere/at/all").join(name)
}

/// Whether a text looks for files in places where there may be some.
fn leaves_its_folder(text: &str) -> bool {
    text.contains("..") && text.contains('"') || text.contains("\"/") || text.contains("**")
}

fn shown(checked: Result<lang::Loaded, lang::Failure>) {
    match checked {
        Ok(loaded) => {
            lang::render_all(&loaded.warnings, &loaded.sources, Style { colour: true });
            // What was checked can be stored.
            serde_json::to_string(&loaded.suite).expect("a suite is plain data");
        }
        Err(failure) => {
            assert!(!failure.diagnostics.is_empty(), "a failure says why");
            for finding in &failure.diagnostics {
                let span = finding.span();
                let text = &failure.sources.get(span.source).text;
                assert!(span.start <= span.end && text.get(span.start..span.end).is_some(), "{finding:?}");
            }
            failure.render(Style::default());
        }
    }
}

/// Checks a text as a scenario file and as a suite, and asks what an editor asks.
pub fn scn(text: &str) {
    if leaves_its_folder(text) {
        return;
    }
    shown(lang::load(&nowhere("fuzz.scn"), &standard(), &Overlay::new(&Disk, &nowhere("fuzz.scn"), text)));
    shown(lang::load(
        &nowhere("fuzz.suite"),
        &standard(),
        &Overlay::new(&Disk, &nowhere("fuzz.suite"), text),
    ));
    let (tree, _) = lang::Tree::parse(Sources::default().add("", ""), text.into());
    let places = text.char_indices().map(|(at, _)| at).step_by(text.len() / 8 + 1);
    for at in places.chain([text.len()]) {
        lang::hover(&tree, at, &standard());
        lang::complete(&nowhere("fuzz.scn"), text, at, &standard(), &Disk);
        lang::definition(&nowhere("fuzz.scn"), text, at, &standard(), &Disk);
    }
}

/// Checks a YAML text; what has a form as a scenario file has the same form again on the way back.
pub fn yaml(text: &str) {
    if leaves_its_folder(text) {
        return;
    }
    shown(lang::load(&nowhere("fuzz.yaml"), &standard(), &Overlay::new(&Disk, &nowhere("fuzz.yaml"), text)));
    let source = Sources::default().add("", "");
    if let Ok(scn) = lang::from_yaml(source, text)
        && let Ok(yaml) = lang::to_yaml(source, &scn)
    {
        let again = lang::from_yaml(source, &yaml)
            .unwrap_or_else(|found| panic!("{yaml}\nis refused: {found:?}\nbut came from\n{scn}"));
        let twice = lang::to_yaml(source, &again)
            .unwrap_or_else(|found| panic!("{again}\nis refused: {found:?}\nbut came from\n{yaml}"));
        assert_eq!(twice, yaml, "from\n{scn}");
    }
}

/// Formats a text twice.
pub fn format(text: &str) {
    let mut sources = Sources::default();
    let source = sources.add("fuzz.scn", text);
    match lang::format(source, text) {
        Ok(once) => {
            let twice = lang::format(source, &once);
            assert_eq!(twice.as_ref().ok(), Some(&once), "formatted again");
            if let (Ok(before), Ok(after)) = (lang::to_yaml(source, text), lang::to_yaml(source, &once)) {
                assert_eq!(before, after, "the formatted text says something else");
            }
        }
        Err(found) => assert!(!found.is_empty(), "a refusal says why"),
    }
}

/// Asks something about the trial that filters are tried on.
pub fn ask_of_trial<T>(ask: impl FnOnce(&Subject) -> T) -> T {
    ask(&Subject {
        suite: "zebra",
        kind: SCENARIO,
        name: "walk",
        tags: &[String::from("paper")],
        models: vec!["scripted"],
        controllers: vec!["idm_aeb"],
        files: vec!["scenarios/zebra/walk.scn"],
        variation: &[Assignment { name: "tta".into(), label: "6s".into(), value: Value::Number(6.0) }],
    })
}

/// Reads a filter expression and asks it about a trial.
pub fn filter(text: &str) {
    match Filters::parse(&[text]) {
        Ok(filters) => {
            let opposite = format!("!({text})");
            let opposite = Filters::parse(&[opposite.as_str()]);
            ask_of_trial(|trial| {
                // Only the brackets around it can be one too many.
                if let Ok(opposite) = &opposite {
                    assert_ne!(filters.matches(trial), opposite.matches(trial), "{text}");
                }
                filters.warnings(&|show: &mut Show| show(trial));
            });
        }
        Err(failure) => {
            assert!(!failure.diagnostics.is_empty(), "a failure says why");
            failure.render(Style::default());
        }
    }
}
