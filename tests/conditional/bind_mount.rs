//! Files that are mounted by themselves, as containers do: nothing can be renamed over them, so they are written in place.
//!
//! Only root mounts anything; without that these tests are counted as ignored, never as passed.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::support::program::{code, stderr};
use libtest_mimic::Trial;

/// Runs a script in which `$PROGRAM` is the program, with mounts that nobody else sees and that end with it.
fn alone(folder: &Path, script: &str) -> Output {
    Command::new("unshare")
        .args(["--mount", "sh", "-e", "-c", script])
        .env("PROGRAM", env!("CARGO_BIN_EXE_scenario-runner"))
        .env("NO_COLOR", "1")
        .current_dir(folder)
        .output()
        .expect("there is a shell")
}

fn may_mount() -> bool {
    let Ok(folder) = tempfile::tempdir() else { return false };
    let unshare = Command::new("unshare").args(["--mount", "true"]).output();
    unshare.is_ok_and(|output| output.status.success())
        && alone(folder.path(), "touch one two; mkdir small; mount --bind one two; mount -t tmpfs none small")
            .status
            .success()
}

/// A scenario with many comments that the formatter indents, so that it gets longer.
fn scenario() -> String {
    let comments = "# thoughts\n".repeat(4000);
    format!(
        "scenario walk {{\n{comments}road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}\n}}\n"
    )
}

/// Everything that lies in the folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn a_file_that_is_mounted_is_written_in_place() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::create_dir(folder.join("host")).unwrap();
    fs::write(folder.join("host/real.scn"), scenario()).unwrap();
    fs::write(folder.join("mounted.scn"), "").unwrap();
    let output = alone(folder, "mount --bind host/real.scn mounted.scn; exec \"$PROGRAM\" fmt mounted.scn");
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = fs::read_to_string(folder.join("host/real.scn")).unwrap();
    assert!(text.contains("\n  # thoughts\n  road {"), "it is formatted: {}", &text[..200]);
    assert_eq!(names(folder), ["host", "mounted.scn"], "nothing is left behind");
}

fn where_the_new_one_does_not_fit_the_old_one_stays() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("old.scn"), scenario()).unwrap();
    fs::write(folder.join("mounted.scn"), "").unwrap();
    fs::create_dir(folder.join("small")).unwrap();
    // Enough for the old one, not for the new one: what is written beside it fits, what is written in place does not.
    let script = "mount -t tmpfs -o size=48k none small
        cp old.scn small/real.scn
        mount --bind small/real.scn mounted.scn
        code=0
        \"$PROGRAM\" fmt mounted.scn || code=$?
        cmp small/real.scn old.scn
        exit $code";
    let output = alone(folder, script);
    assert_eq!(code(&output), 110, "{}", stderr(&output));
    assert!(stderr(&output).contains("cannot write `mounted.scn`"), "{}", stderr(&output));
    assert_eq!(names(folder), ["mounted.scn", "old.scn", "small"], "nothing is left behind");
}

pub fn tests() -> Vec<Trial> {
    let mounts = may_mount();
    if !mounts {
        eprintln!("SKIPPED: nothing can be mounted here; only root may, in a namespace of its own");
    }
    let test = |name: &str, run: fn()| {
        let run = move || {
            run();
            Ok(())
        };
        Trial::test(name, run).with_ignored_flag(!mounts)
    };
    vec![
        test("a_file_that_is_mounted_is_written_in_place", a_file_that_is_mounted_is_written_in_place),
        test(
            "where_the_new_one_does_not_fit_the_old_one_stays",
            where_the_new_one_does_not_fit_the_old_one_stays,
        ),
    ]
}
