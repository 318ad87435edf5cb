//! `validate crosscdr`: what is refused before anything runs.

use std::fs;

use crate::support::program::{code, scenario_runner, stderr};

/// What it says of a command line in a folder with some files, and with which code it ends.
fn refused(arguments: &[&str]) -> (i32, String) {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("empty.json", "{}");
    write("hiker.json", r#"{ "targets": { "names": ["collision"] }, "what": "other people" }"#);
    write("text.json", "no facts");
    let arguments = [&["validate", "crosscdr"], arguments].concat();
    let output = scenario_runner(folder.path(), &arguments);
    (code(&output), stderr(&output))
}

#[test]
fn what_is_no_file_of_facts_is_named() {
    for (file, what) in [
        ("empty.json", "empty.json: there is no `targets`"),
        ("hiker.json", "there is no `alone, single gap 3.5 s, mean over persons` among `targets.names`"),
        ("text.json", "text.json: expected"),
        ("nothing.json", "cannot read nothing.json"),
    ] {
        let (code, said) = refused(&[file, "--population", "humans"]);
        assert!(code == 2 && said.starts_with("error: ") && said.contains(what), "{code} {said}");
    }
}

#[test]
fn nobody_and_none_are_refused() {
    for (arguments, what) in [
        (&["empty.json"][..], "--population"),
        (&["empty.json", "--model", "carla_walker", "--members", "0"], "--members"),
        (&["empty.json", "--model", "carla_walker", "--repetitions", "0"], "--repetitions"),
    ] {
        let (code, said) = refused(arguments);
        assert!(code == 2 && said.contains(what), "{code} {said}");
    }
}
