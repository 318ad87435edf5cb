//! The properties of `fuzz/` on stable Rust: changed copies of what the repository holds, each made from its number.
//!
//! `FUZZ_CASES` is how many there are for each property; a failure names the case and prints the text.

use std::panic;
use std::path::PathBuf;

use super::properties;

use numbers::random::Stream;
use rayon::prelude::*;

/// Cases per property unless `FUZZ_CASES` says otherwise.
const CASES: u64 = 1500;

fn cases() -> u64 {
    std::env::var("FUZZ_CASES").map_or(CASES, |count| count.parse().expect("FUZZ_CASES is a whole number"))
}

/// The texts of the files with one of these endings.
fn seeds(extensions: &[&str]) -> Vec<String> {
    let mut paths: Vec<PathBuf> = ["scenarios", "suites", "templates", "tests/language"]
        .iter()
        .flat_map(|folder| extensions.iter().map(move |extension| format!("{folder}/**/*.{extension}")))
        .flat_map(|pattern| glob::glob(&pattern).unwrap().map(Result::unwrap))
        .collect();
    paths.sort();
    let text = |path: &PathBuf| std::fs::read_to_string(path).unwrap();
    paths.iter().map(text).filter(|text| text.len() < 20_000).collect()
}

/// Pieces that break things.
const PIECES: &[&str] = &[
    "{",
    "}",
    "(",
    ")",
    "[",
    "]",
    "\"",
    "\\",
    "#",
    "\n",
    "\r\n",
    ";",
    ",",
    ":",
    "..",
    "=",
    "-",
    "- ",
    "* ",
    "!",
    "/",
    "0",
    "-1",
    "1e308",
    "1e-400",
    "99999999999999999999",
    "0x",
    "%",
    "²",
    "é",
    "\u{feff}",
    "\u{0}",
    "\t",
    "𝄞",
    "km/h",
    "m/s^2",
    " in ",
    " when ",
    "null",
    "~",
    "&a",
    "*a",
    "<<",
    "? ",
    "|\n",
    ">\n",
    "not ",
    "/(/",
];

/// A place between two characters.
fn place(stream: &mut Stream, text: &str) -> usize {
    let mut at = stream.index(text.len() + 1);
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// A word, a line or a few characters somewhere in a text.
fn part<'t>(stream: &mut Stream, text: &'t str) -> &'t str {
    let at = place(stream, text);
    beginning(stream, &text[at..])
}

/// What a text begins with.
fn beginning<'t>(stream: &mut Stream, rest: &'t str) -> &'t str {
    let end = match stream.index(4) {
        0 => rest.find('\n').map_or(rest.len(), |end| end + 1),
        1 => rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len()),
        2 => rest.find('}').map_or(rest.len(), |end| end + 1),
        _ => place(stream, &rest[..rest.char_indices().nth(8).map_or(rest.len(), |(end, _)| end)]),
    };
    &rest[..end]
}

/// A copy of one of the seeds with some changes.
fn changed(stream: &mut Stream, seeds: &[String]) -> String {
    let mut text = seeds[stream.index(seeds.len())].clone();
    for _ in 0..stream.index(6) {
        let at = place(stream, &text);
        match stream.index(7) {
            0 => {
                let length = beginning(stream, &text[at..]).len();
                text.replace_range(at..at + length, "");
            }
            1 => text.insert_str(at, PIECES[stream.index(PIECES.len())]),
            2 => {
                let other = &seeds[stream.index(seeds.len())];
                let piece = part(stream, other).to_string();
                text.insert_str(at, &piece);
            }
            3 => {
                let piece = part(stream, &text).to_string();
                text.insert_str(at, &piece);
            }
            4 => {
                let length = beginning(stream, &text[at..]).len();
                let other = &seeds[stream.index(seeds.len())];
                let other = part(stream, other).to_string();
                text.replace_range(at..at + length, &other);
            }
            5 => text.truncate(at),
            _ => {
                let piece = beginning(stream, &text[at..]).to_string();
                text.insert_str(at, &piece.repeat(1 + stream.index(40)));
            }
        }
    }
    text
}

/// Asserts that a property holds for every case.
fn hold(name: &str, seeds: &[String], property: fn(&str)) {
    assert!(!seeds.is_empty());
    seeds.iter().for_each(|text| property(text));
    let failed = (0..cases()).into_par_iter().find_map_any(|case| {
        let text = changed(&mut Stream::seeded(case), seeds);
        panic::catch_unwind(|| property(&text)).is_err().then_some((case, text))
    });
    if let Some((case, text)) = failed {
        panic!("{name}, case {case}, fails for\n-----\n{text}\n-----\n{text:?}");
    }
}

#[test]
fn no_scenario_file_makes_the_checker_or_the_editor_panic() {
    hold("scn", &seeds(&["scn", "suite"]), properties::scn);
}

#[test]
fn no_yaml_makes_the_checker_panic_and_the_way_back_is_the_way_there() {
    hold("yaml", &seeds(&["yaml"]), properties::yaml);
}

#[test]
fn formatting_twice_is_formatting_once() {
    hold("format", &seeds(&["scn", "suite"]), properties::format);
}

#[test]
fn no_filter_makes_the_reader_panic() {
    let strip =
        |text: String| text.lines().map(|line| line.split("#~").next().unwrap().to_string() + "\n").collect();
    hold("filter", &seeds(&["filter"]).into_iter().map(strip).collect::<Vec<_>>(), properties::filter);
}
