//! Every file of numbers about people and traffic says where they come from and under which licence.

#![allow(clippy::disallowed_methods, reason = "reads its own sources")]

use std::fs;
use std::path::{Path, PathBuf};

use crate::house::complain;

/// Where such files lie. What `baselines` hold are our own results, and tests make up what they need.
const FOLDERS: [&str; 4] = ["scenarios", "templates", "examples", "src/scenario/population"];

fn data(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            data(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "csv" || ending == "json") {
            found.push(path);
        }
    }
}

/// What a file does not say of its numbers: its source, its licence.
fn lacks(path: &Path, text: &str) -> Vec<&'static str> {
    let said = if path.extension().is_some_and(|ending| ending == "json") {
        let read: serde_json::Value = serde_json::from_str(text).unwrap();
        let source = read["source"].as_str().unwrap_or_default();
        if source.is_empty() { String::new() } else { format!("source: {source}") }
    } else {
        text.lines().filter(|line| line.starts_with('#')).collect::<Vec<_>>().join("\n")
    };
    let said = said.to_lowercase();
    let mut lacking = Vec::new();
    if !said.contains("source: ") {
        lacking.push("source");
    }
    if !["licence", "cc by"].iter().any(|word| said.contains(word)) {
        lacking.push("licence");
    }
    lacking
}

#[test]
fn files_of_numbers_name_source_and_licence() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    FOLDERS.iter().for_each(|folder| data(&root.join(folder), &mut files));
    let mut names: Vec<String> =
        files.iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect();
    names.sort();
    for known in ["candidates.json", "exposure.csv", "human_crossing.csv", "humans.json", "standard.json"] {
        assert!(names.iter().any(|name| name == known), "{known} is not among {names:?}");
    }
    let lacking = files.iter().flat_map(|path| {
        let text = fs::read_to_string(path).unwrap();
        lacks(path, &text).into_iter().map(move |what| format!("{} names no {what}", path.display()))
    });
    complain(lacking.collect());
}

#[test]
fn what_a_file_does_not_say_is_seen() {
    let of = |name: &str, text: &str| lacks(Path::new(name), text);
    assert_eq!(of("people.csv", "T_delta\n20\n"), ["source", "licence"]);
    assert_eq!(of("people.csv", "# Source: a survey.\nlicence\n20\n"), ["licence"]);
    assert_eq!(of("people.csv", "# Source: a survey, CC BY 4.0.\nT_delta\n20\n"), [""; 0]);
    assert_eq!(of("people.json", r#"{"note": "CC BY 4.0"}"#), ["source", "licence"]);
    assert_eq!(of("people.json", r#"{"source": "a survey", "note": "CC BY 4.0"}"#), ["licence"]);
    assert_eq!(of("people.json", r#"{"source": "a survey, CC BY 4.0"}"#), [""; 0]);
}
