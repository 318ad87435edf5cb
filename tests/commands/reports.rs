//! All reports of a suite that fails, of one with a gate and of one with blocks, held line by line: what rebuilds the program may not
//! change what users and their tools read.
//!
//! Short reports stand in snapshots as they are. Of long ones there is a checksum a line, eight a row, so that a difference
//! shows where it begins. Wall times, dates and temporary places are taken out.

use std::fs;
use std::path::Path;

use crate::support::program::{code, scenario_runner, stderr, stdout};
use regex_lite::Regex;

/// Longer reports are held by checksums, bytes.
const SHORT: usize = 12_000;

/// The reports that are files, by their options.
const FILES: [&str; 6] = ["junit", "json", "tap", "html", "runs", "csv"];

/// Replaces what differs from run to run of the same suite.
fn settled(text: &str) -> String {
    let replaced = [
        // Terminal, TAP and the page.
        (r"\[ *\d+\.\d{3}s\]", "[TIME]"),
        (r"duration_ms: \d+", "duration_ms: 0"),
        (r", \d+\.\d{2} s<", ", TIME s<"),
        (r#"<td class="n">\d+\.\d{2}</td></tr>\n"#, "<td>TIME</td></tr>\n"),
        // JUnit.
        (r#" (time|timestamp)="[^"]*""#, r#" $1="…""#),
        // JSON.
        (r#""(wall_time_s|duration_s|(secs|nanos)(_since_epoch)?)": ?[0-9.e-]+"#, r#""$1": 0"#),
        (r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(\.\d+)?(Z|\+00:00| UTC)", "DATE"),
    ];
    replaced.iter().fold(text.to_string(), |text, (pattern, by)| {
        Regex::new(pattern).unwrap().replace_all(&text, *by).into_owned()
    })
}

/// The text itself where it is short, else a checksum a line.
fn held(text: &str) -> String {
    if text.len() <= SHORT {
        return text.to_string();
    }
    let sums: Vec<String> =
        text.lines().map(|line| format!("{:08x}", crc32fast::hash(line.as_bytes()))).collect();
    let rows: Vec<String> = sums
        .chunks(8)
        .enumerate()
        .map(|(row, sums)| format!("{:>6}  {}", row * 8 + 1, sums.join(" ")))
        .collect();
    format!("{} lines\n{}\n", sums.len(), rows.join("\n"))
}

/// The repository.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Runs the suite of a file in `root` with every report there is and holds each under the name of the suite.
fn hold(root: &Path, file: &str, ends_with: i32) {
    let folder = tempfile::tempdir().unwrap();
    let suite = Path::new(file).file_stem().unwrap().to_str().unwrap();
    let place = |kind: &str| folder.path().join(kind).display().to_string();
    let files: Vec<(String, String)> = FILES.iter().map(|kind| (format!("--{kind}"), place(kind))).collect();
    let journal = place("journal");
    let mut arguments = vec![file, "--test-threads", "1", "--no-progress", "--github"];
    // Nobody else may be using the journals of the project.
    arguments.extend(["--journal", journal.as_str()]);
    arguments.extend(files.iter().flat_map(|(option, path)| [option.as_str(), path.as_str()]));
    let output = scenario_runner(root, &arguments);
    assert_eq!(code(&output), ends_with, "{}", stderr(&output));
    let said = [stdout(&output), stderr(&output)].join("\n──────────── standard error\n");
    insta::assert_snapshot!(format!("{suite}.terminal"), held(&settled(&said)));
    for kind in FILES {
        let text = fs::read_to_string(place(kind)).unwrap();
        insta::assert_snapshot!(format!("{suite}.{kind}"), held(&settled(&text)));
    }
    // Made later of the results alone, they are the same byte for byte.
    let later = tempfile::tempdir().unwrap();
    let again = |kind: &str| later.path().join(kind).display().to_string();
    let files: Vec<(String, String)> = FILES.iter().map(|kind| (format!("--{kind}"), again(kind))).collect();
    let results = place("json");
    let mut arguments = vec!["report", results.as_str()];
    arguments.extend(files.iter().flat_map(|(option, path)| [option.as_str(), path.as_str()]));
    let shown = |text: &str| -> Vec<String> {
        // What is only said of what begins, and to GitHub.
        let begins = |line: &&str| line.trim_start().starts_with("Starting") || line.starts_with("::");
        let lines = text.lines().filter(|line| !begins(line)).map(|line| settled(line.trim_end()));
        lines.filter(|line| !line.is_empty()).collect()
    };
    let first = shown(&stdout(&output));
    let output = scenario_runner(root, &arguments);
    assert_eq!(code(&output), ends_with, "{}", stderr(&output));
    assert!(first.iter().any(|line| line.contains("Summary")), "{first:#?}");
    assert_eq!(shown(&stdout(&output)), first, "{suite}: the terminal shows something else");
    for kind in FILES {
        let (first, second) = (fs::read(place(kind)).unwrap(), fs::read(again(kind)).unwrap());
        assert!(first == second, "{suite}: the {kind} report made of the results is another one");
    }
}

#[test]
fn of_a_suite_that_fails() {
    hold(root(), "suites/zebra_unsafe.suite", 100);
}

/// The baseline is the one that the program itself saves in the folder of the suite.
#[test]
fn of_a_suite_with_a_gate() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("gated.suite"), include_str!("gated.suite")).unwrap();
    let saved = scenario_runner(folder.path(), &["baseline", "save", "gated.suite"]);
    assert_eq!(code(&saved), 0, "{}", stderr(&saved));
    hold(folder.path(), "gated.suite", 0);
}

#[test]
fn of_a_suite_with_blocks() {
    hold(root(), "tests/commands/arrival.suite", 0);
}
