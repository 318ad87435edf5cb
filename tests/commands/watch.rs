//! `scenario-runner watch`: what runs again when what changes, and that nothing old is shown for it.

use std::fs;
use std::io::{self, BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

/// No line is waited for longer.
const PATIENCE: Duration = Duration::from_secs(120);
/// Time to wait where nothing should happen: longer than the second between two looks for changes, and longer than the slowest reaction
/// so far by this factor.
const SILENCE: Duration = Duration::from_millis(1300);
const MARGIN: f64 = 1.5;

/// One run, which comes to 1.7 m: it passes if the limit (m) is small.
fn scenario(name: &str, limit: &str) -> String {
    format!(
        "scenario {name} {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
  vehicle av {{ controller constant_speed; speed 30 km/h; start 40 m before crossing }}
  pedestrian walker {{ model scripted; start 4 m from kerb; appears at 3 s }}
  expect {{ min_distance >= {limit} m }}
}}
"
    )
}

fn suite(name: &str, files: &[&str]) -> String {
    let uses: String = files.iter().map(|file| format!("use \"{file}\"\n")).collect();
    let included: String = files.iter().map(|file| format!("  scenarios \"{file}\"\n")).collect();
    format!("{uses}suite {name} {{\n{included}}}\n")
}

/// The program, watching, and the lines that it says.
struct Watch {
    child: Child,
    lines: Receiver<String>,
    said: Vec<String>,
    /// The longest time from a change to the line that names it.
    slowest: Duration,
}

impl Watch {
    fn begin(folder: &Path, arguments: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_scenario-runner"));
        command.arg("watch").args(arguments).current_dir(folder).env("NO_COLOR", "1").env("CI", "1");
        Self::of(command.stdin(Stdio::null()))
    }

    /// Both streams are one pipe, so that lines come in the order in which they are said.
    fn of(command: &mut Command) -> Self {
        let (reader, writer) = io::pipe().unwrap();
        let child = command.stdout(writer.try_clone().unwrap()).stderr(writer).spawn().unwrap();
        let (sender, lines) = mpsc::channel();
        thread::spawn(move || {
            BufReader::new(reader).lines().for_each(|line| _ = line.map(|line| sender.send(line)));
        });
        Self { child, lines, said: Vec::new(), slowest: Duration::ZERO }
    }

    /// The next line with these words, waited for; what is said before it is left behind.
    fn line(&mut self, words: &str) -> String {
        let end = Instant::now() + PATIENCE;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let line = self.lines.recv_timeout(left);
            let line = line.unwrap_or_else(|_| panic!("nobody said `{words}`:\n{}", self.said.join("\n")));
            self.said.push(line.clone());
            if line.contains(words) {
                return line;
            }
        }
    }

    /// What is known of each file, once it waits.
    fn states(&mut self) -> Vec<String> {
        let from = self.said.len();
        self.line("watch: waiting for changes");
        let said = self.said[from..].iter().rev().skip(1).take_while(|line| line.starts_with("watch: "));
        let mut states: Vec<String> = said.map(|line| line["watch: ".len()..].to_string()).collect();
        states.retain(|line| line.contains(": "));
        states.reverse();
        states
    }

    /// As [`Self::line`], just after the change that the line names.
    fn reaction(&mut self, words: &str) {
        let begun = Instant::now();
        self.line(words);
        self.slowest = self.slowest.max(begun.elapsed());
    }

    fn is_silent(&mut self) {
        if let Ok(line) = self.lines.recv_timeout(SILENCE.max(self.slowest.mul_f64(MARGIN))) {
            panic!("said `{line}`");
        }
    }

    #[cfg(unix)]
    fn terminated(mut self) -> ExitStatus {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
        self.child.wait().unwrap()
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_change_runs_it_again_and_the_old_verdict_is_gone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.scn");
    fs::write(&path, scenario("a", "0.1")).unwrap();
    let mut watch = Watch::begin(folder.path(), &["a.scn"]);
    assert_eq!(watch.states(), ["a.scn: passed, 1 unit"]);
    // A text that fails, saved in place.
    fs::write(&path, scenario("a", "9.1")).unwrap();
    watch.reaction("a.scn changed");
    assert_eq!(watch.states(), ["a.scn: failed, 1 unit"]);
    // One that is none.
    fs::write(&path, "scenario a {").unwrap();
    watch.reaction("error");
    assert_eq!(watch.states(), ["a.scn: does not load"]);
    // It is removed, and back under the name of another, as editors save.
    fs::remove_file(&path).unwrap();
    watch.reaction("a.scn changed");
    assert_eq!(watch.states(), ["a.scn: does not load"]);
    let new = folder.path().join(".a.scn.swp");
    fs::write(&new, scenario("a", "0.1")).unwrap();
    fs::rename(&new, &path).unwrap();
    watch.reaction("a.scn changed");
    assert_eq!(watch.states(), ["a.scn: passed, 1 unit"]);
    // The same size and time, with other content.
    let modified = fs::metadata(&path).unwrap().modified().unwrap();
    fs::write(&path, scenario("a", "9.1")).unwrap();
    fs::File::options().write(true).open(&path).unwrap().set_modified(modified).unwrap();
    watch.reaction("a.scn changed");
    assert_eq!(watch.states(), ["a.scn: failed, 1 unit"]);
    // Written, and nothing is otherwise.
    fs::write(&path, scenario("a", "9.1")).unwrap();
    watch.is_silent();
}

#[test]
fn a_change_concerns_those_who_read_the_file() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a", "b", "c"] {
        fs::write(folder.path().join(format!("{name}.scn")), scenario(name, "0.1")).unwrap();
    }
    fs::write(folder.path().join("one.suite"), suite("one", &["a.scn", "b.scn"])).unwrap();
    fs::write(folder.path().join("two.suite"), suite("two", &["c.scn"])).unwrap();
    let mut watch = Watch::begin(folder.path(), &["--poll", "--test-threads", "1"]);
    assert_eq!(watch.states(), ["one.suite: passed, 2 units", "two.suite: passed, 1 unit"]);
    fs::write(folder.path().join("b.scn"), scenario("b", "9.1")).unwrap();
    assert!(watch.line("b.scn changed").ends_with("one.suite runs again"));
    let from = watch.said.len();
    assert_eq!(watch.states(), ["one.suite: failed, 2 units", "two.suite: passed, 1 unit"]);
    assert!(!watch.said[from..].iter().any(|line| line.contains("two/c")), "{:?}", watch.said);
    // Both, and what failed comes first, of suites and within one.
    fs::write(folder.path().join("c.scn"), scenario("c", "0.2")).unwrap();
    fs::write(folder.path().join("b.scn"), scenario("b", "9.2")).unwrap();
    let from = watch.said.len();
    assert_eq!(watch.states(), ["one.suite: failed, 2 units", "two.suite: passed, 1 unit"]);
    let at = |words: &str| {
        let found = watch.said[from..].iter().position(|line| line.contains(words));
        found.unwrap_or_else(|| panic!("{words}: {:?}", watch.said))
    };
    assert!(at("FAIL") < at("PASS") && at("one/a") < at("two/c"), "{:?}", watch.said);
}

/// A hundred runs of a model with chance take long enough to be stopped.
#[test]
fn a_change_while_it_runs_stops_it_and_is_not_lost() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.scn");
    let long = |limit: &str| {
        let text = scenario("a", limit).replace("model scripted", "model commotions");
        text.replace("  expect", "  repeat 20000\n  expect")
    };
    fs::write(&path, long("0.1")).unwrap();
    let mut watch = Watch::begin(folder.path(), &["a.scn"]);
    watch.line("Starting");
    thread::sleep(Duration::from_millis(50));
    fs::write(&path, scenario("a", "9.1")).unwrap();
    watch.line("a.scn is stopped and runs again");
    let from = watch.said.len();
    assert_eq!(watch.states(), ["a.scn: failed, 1 unit"]);
    assert!(!watch.said[from..].iter().any(|line| line.contains("PASS")), "{:?}", watch.said);
}

#[cfg(unix)]
#[test]
fn it_ends_by_a_signal_while_it_waits_and_while_it_runs() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.scn"), scenario("a", "0.1")).unwrap();
    let mut watch = Watch::begin(folder.path(), &["a.scn"]);
    watch.states();
    assert_eq!(watch.terminated().code(), Some(105));
    let text = scenario("a", "0.1").replace("model scripted", "model commotions");
    fs::write(folder.path().join("a.scn"), text.replace("  expect", "  repeat 20000\n  expect")).unwrap();
    let mut watch = Watch::begin(folder.path(), &["a.scn"]);
    watch.line("Starting");
    assert_eq!(watch.terminated().code(), Some(105));
}

#[test]
fn what_is_wrong_from_the_beginning_is_said_and_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let mut watch = Watch::begin(folder.path(), &["later.scn"]);
    assert_eq!(watch.states(), ["later.scn: does not load"]);
    fs::write(folder.path().join("later.scn"), scenario("a", "0.1")).unwrap();
    assert_eq!(watch.states(), ["later.scn: passed, 1 unit"]);
    let once = |arguments: &[&str]| {
        let empty = tempfile::tempdir().unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_scenario-runner"));
        let output = command.arg("watch").args(arguments).current_dir(empty.path()).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, said) = once(&[]);
    assert!(code == Some(2) && said.contains("no suite or scenario is named"), "{said}");
    let (code, said) = once(&["a.scn", "one", "two"]);
    assert!(code == Some(2) && said.contains("more than one filter"), "{said}");
    let (code, said) = once(&["a.scn", "-E", "tag("]);
    assert!(code == Some(2) && said.contains("tag("), "{said}");
}

#[test]
fn a_part_is_said_to_be_one() {
    let folder = tempfile::tempdir().unwrap();
    let text = scenario("a", "0.1") + &scenario("b", "9.1");
    fs::write(folder.path().join("a.scn"), text).unwrap();
    let mut watch = Watch::begin(folder.path(), &["a.scn", "-E", "scenario(a)"]);
    assert_eq!(watch.states(), ["a.scn: passed, 1 of 2 units"]);
}

/// Its program never runs without leave, and what it consists of is watched.
#[cfg(unix)]
#[test]
fn a_program_runs_with_leave_alone_and_again_when_it_changes() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("av.sh");
    fs::write(&program, "#!/bin/sh\ntouch started\nexit 3\n").unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    let text = "controller mine {\n  command \"./av.sh\"\n  gives acceleration\n}\n".to_string()
        + &scenario("a", "0.1").replace("constant_speed", "mine");
    fs::write(folder.path().join("a.scn"), text).unwrap();
    let begin = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_scenario-runner"));
        command.args(["watch", "a.scn"]).args(arguments).current_dir(folder.path());
        command.env("CI", "1").env("NO_COLOR", "1").env("XDG_CONFIG_HOME", folder.path().join("config"));
        command.env("HOME", folder.path()).env_remove("SCENARIO_RUNNER_ALLOW_RUN");
        Watch::of(command.stdin(Stdio::null()))
    };
    let mut watch = begin(&[]);
    assert_eq!(watch.states(), ["a.scn: does not load"]);
    assert!(!folder.path().join("started").exists(), "{:?}", watch.said);
    drop(watch);
    let mut watch = begin(&["--allow-run"]);
    assert_eq!(watch.states(), ["a.scn: does not load"]);
    assert!(folder.path().join("started").exists(), "{:?}", watch.said);
    fs::write(&program, "#!/bin/sh\nexit 4\n").unwrap();
    watch.line("av.sh changed");
    assert_eq!(watch.states(), ["a.scn: does not load"]);
}
