//! `scenario-runner watch` at a terminal: what its keys do, and that the terminal is as it was afterwards.
//!
//! The terminal is made by `script` of util-linux; without that these tests are counted as ignored, never as passed.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

use libtest_mimic::Trial;
use tempfile::TempDir;

/// No line is waited for longer.
const PATIENCE: Duration = Duration::from_secs(120);

/// A scenario that passes and one that fails.
const SCENARIOS: &str = "scenario good {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed 30 km/h; start 40 m before crossing }
  pedestrian walker { model scripted; start 4 m from kerb; appears at 3 s }
  expect { min_distance >= 0.1 m }
}
scenario bad {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed 30 km/h; start 40 m before crossing }
  pedestrian walker { model scripted; start 4 m from kerb; appears at 3 s }
  expect { min_distance >= 9.1 m }
}
";

/// The program at a terminal.
struct AtTerminal {
    folder: TempDir,
    child: Child,
    lines: Receiver<String>,
    said: Vec<String>,
}

impl AtTerminal {
    fn begin() -> Self {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a.scn"), SCENARIOS).unwrap();
        fs::write(at("xdg-open"), "#!/bin/sh\necho \"$@\" > opened.new\nmv opened.new opened\n").unwrap();
        fs::set_permissions(at("xdg-open"), fs::Permissions::from_mode(0o755)).unwrap();
        // Who asks for the end of the program with Ctrl-C does not mean the shell.
        let inner = "trap : INT
stty -a > before
sh -c 'echo $$ > id; exec \"$PROGRAM\" watch a.scn --no-progress'
echo \"ended with $?\"
stty -a > after
echo 'terminal let go'
";
        fs::write(at("inner.sh"), inner).unwrap();
        let path = format!("{}:{}", folder.path().display(), std::env::var("PATH").unwrap_or_default());
        let mut child = Command::new("script")
            .args(["-qfc", "sh inner.sh", "/dev/null"])
            .current_dir(folder.path())
            .env("NO_COLOR", "1")
            .env("PATH", path)
            .env("PROGRAM", env!("CARGO_BIN_EXE_scenario-runner"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (sender, lines) = mpsc::channel();
        let out = child.stdout.take().unwrap();
        thread::spawn(move || {
            for line in BufReader::new(out).split(b'\n') {
                let Ok(line) = line else { return };
                _ = sender.send(String::from_utf8_lossy(&line).trim_end().to_string());
            }
        });
        Self { folder, child, lines, said: Vec::new() }
    }

    fn press(&mut self, keys: &str) {
        self.child.stdin.as_mut().unwrap().write_all(keys.as_bytes()).unwrap();
    }

    /// The next line with these words, waited for.
    fn line(&mut self, words: &str) -> String {
        let end = Instant::now() + PATIENCE;
        loop {
            let line = self.lines.recv_timeout(end.saturating_duration_since(Instant::now()));
            let line = line.unwrap_or_else(|_| panic!("nobody said `{words}`:\n{}", self.said.join("\n")));
            self.said.push(line.clone());
            if line.contains(words) {
                return line;
            }
        }
    }

    /// How it ended, once the terminal is found to be as it was.
    fn ended(mut self) -> String {
        let line = self.line("ended with");
        // How `script` itself ends is its own affair: it may meet the terminal's end before the shell's.
        self.line("terminal let go");
        let mode = |name: &str| fs::read_to_string(self.folder.path().join(name)).unwrap();
        assert_eq!(mode("before"), mode("after"));
        assert!(mode("after").contains(" icanon") && mode("after").contains(" echo "));
        line
    }
}

impl Drop for AtTerminal {
    fn drop(&mut self) {
        _ = self.child.kill();
        _ = self.child.wait();
    }
}

fn keys_do_what_the_help_says() {
    let mut watch = AtTerminal::begin();
    assert!(watch.line("watch: a.scn").ends_with("failed, 2 units"));
    watch.line("h for help");
    watch.press("w");
    watch.line("watch: 2 files");
    watch.line("a.scn");
    watch.press("h");
    watch.line("list what is watched");
    watch.press("/scenario(good)\n");
    assert!(watch.line("watch: a.scn").ends_with("passed, 1 of 2 units"));
    watch.press("ptag(\n");
    watch.line("the filter stays as it was");
    watch.press("\n");
    assert!(watch.line("watch: a.scn").ends_with("passed, 1 of 2 units"));
    watch.press("/\n");
    assert!(watch.line("watch: a.scn").ends_with("failed, 2 units"));
    watch.press("f");
    assert!(watch.line("watch: a.scn").ends_with("failed, 1 of 2 units"));
    watch.press("o");
    watch.line("wrote .scenario-runner/watch.html");
    let opened = watch.folder.path().join("opened");
    let end = Instant::now() + PATIENCE;
    while !opened.exists() {
        assert!(Instant::now() < end, "nothing was opened");
        thread::sleep(Duration::from_millis(20));
    }
    let page = fs::read_to_string(fs::read_to_string(opened).unwrap().trim()).unwrap();
    assert!(page.starts_with("<!doctype html>") || page.starts_with("<!DOCTYPE html>"), "{}", &page[..80]);
    // Nothing of what changed is shown any more.
    fs::write(watch.folder.path().join("a.scn"), "scenario {").unwrap();
    assert!(watch.line("watch: a.scn: ").ends_with("does not load"));
    watch.press("o");
    watch.line("there is no report");
    watch.press("q");
    assert!(watch.ended().ends_with("ended with 0"));
}

fn ctrl_c_and_signals_leave_the_terminal_as_it_was() {
    let mut watch = AtTerminal::begin();
    watch.line("h for help");
    watch.press("\x03");
    assert!(watch.ended().ends_with("ended with 105"));
    let mut watch = AtTerminal::begin();
    watch.line("h for help");
    // While a filter is typed the terminal has its own mode.
    watch.press("/scen");
    let id = fs::read_to_string(watch.folder.path().join("id")).unwrap();
    assert!(Command::new("kill").args(["-TERM", id.trim()]).status().unwrap().success());
    assert!(watch.ended().ends_with("ended with 105"));
}

fn has_script() -> bool {
    let version = Command::new("script").arg("--version").output();
    cfg!(target_os = "linux")
        && version.is_ok_and(|output| output.stdout.starts_with(b"script from util-linux"))
        && Path::new("/bin/sh").exists()
}

pub fn tests() -> Vec<Trial> {
    let ignored = !has_script();
    let tests: [(&str, fn()); 2] = [
        ("keys_do_what_the_help_says", keys_do_what_the_help_says),
        ("ctrl_c_and_signals_leave_the_terminal_as_it_was", ctrl_c_and_signals_leave_the_terminal_as_it_was),
    ];
    let trial = |(name, test): (&str, fn())| {
        Trial::test(format!("watch_keys::{name}"), move || {
            test();
            Ok(())
        })
        .with_ignored_flag(ignored)
    };
    tests.into_iter().map(trial).collect()
}
