//! Files as the program leaves them, whatever happens: kills, full disks, links, pipes, files from somebody else.
//!
//! `KILLS=300 cargo test --test commands files::kills` kills more often than an ordinary run of the tests does.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use numbers::random::Stream;
use tempfile::TempDir;

use crate::support::program::{code, scenario_runner, stderr, stdout};

/// People who step before cars that do not care; some are passed too closely.
const ENCOUNTER: &str = "scenario pass {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed 30 km/h }
  pedestrian walker {
    model scripted { speed: 1.4 m/s }
    start 2 m from kerb
    appears when time_to_arrival(av) = tta
  }
  vary tta in [3 s, 8 s, 20 s]
  expect { pet >= 1.5 s }
}
";

const SUITE: &str = "suite small {\n  scenarios \"pass.scn\"\n}\n";

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "pass.scn", ENCOUNTER);
    write(folder.path(), "small.suite", SUITE);
    folder
}

fn write(folder: &Path, name: &str, text: &str) {
    fs::write(folder.join(name), text).unwrap();
}

fn read(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name)).unwrap()
}

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scenario-runner"));
    command.args(arguments).current_dir(folder).env("NO_COLOR", "1");
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// What a command says that must not hang.
fn promptly(mut command: Command) -> Output {
    let mut child = command.spawn().unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            panic!("it hangs");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().unwrap()
}

/// Size and time of every file, so that the first touch is seen.
fn look(folder: &Path) -> BTreeMap<PathBuf, (u64, i64, i64)> {
    let mut seen = BTreeMap::new();
    let Ok(entries) = fs::read_dir(folder) else { return seen };
    for entry in entries.flatten() {
        let Ok(metadata) = entry.metadata() else { continue };
        if metadata.is_dir() {
            seen.extend(look(&entry.path()));
        } else {
            seen.insert(entry.path(), (metadata.len(), metadata.mtime(), metadata.mtime_nsec()));
        }
    }
    seen
}

type IsWhole = fn(&str) -> bool;

/// A command, the files that it writes, and when one of them is whole.
struct Writing<'a> {
    arguments: &'a [&'a str],
    outputs: &'a [(&'a str, IsWhole)],
    /// Whether it always writes the same bytes.
    is_certain: bool,
}

const WRITING: &[Writing] = &[
    Writing {
        arguments: &[
            "small.suite",
            "--json",
            "r.json",
            "--junit",
            "r.xml",
            "--tap",
            "r.tap",
            "--html",
            "r.html",
            "--trace",
            "traces",
        ],
        outputs: &[
            ("r.json", |text| serde_json::from_str::<serde_json::Value>(text).is_ok()),
            ("r.xml", |text| text.trim_end().ends_with("</testsuites>")),
            ("r.tap", |text| text.contains("1..") && text.ends_with('\n')),
            ("r.html", |text| text.trim_end().ends_with("</html>")),
        ],
        is_certain: false,
    },
    Writing {
        arguments: &["small.suite", "--record-failures", "--trace", "traces"],
        outputs: &[
            ("small.failures", |_| true),
            ("traces/small__pass__tta=3s__rep=1.csv", |_| true),
            ("traces/small__pass__tta=20s__rep=1.csv", |_| true),
        ],
        is_certain: true,
    },
    Writing {
        arguments: &["baseline", "save", "small.suite", "--out", "b.json"],
        outputs: &[("b.json", |_| true)],
        is_certain: true,
    },
    Writing { arguments: &["fmt", "long.scn"], outputs: &[("long.scn", |_| true)], is_certain: true },
    Writing {
        arguments: &["shrink", "pass/pass/tta=3s/rep=1", "pass.scn", "-o", "s.scn", "--as-is", "--force"],
        outputs: &[("s.scn", |_| true)],
        is_certain: true,
    },
];

/// A scenario file that is not in the style, long enough that writing it takes a moment.
fn long() -> String {
    ENCOUNTER.replace("  ", "      ") + &"# what was thought about this scenario\n".repeat(20_000)
}

/// A folder in which a command has come to its end once.
struct Prepared {
    writing: &'static Writing<'static>,
    folder: TempDir,
    /// What it wrote, by its outputs.
    written: Vec<String>,
    needed: Duration,
}

impl Prepared {
    fn new(writing: &'static Writing<'static>) -> Self {
        let folder = folder();
        write(folder.path(), "long.scn", &long());
        let begun = Instant::now();
        let output = command(folder.path(), writing.arguments).output().unwrap();
        let needed = begun.elapsed();
        assert!([0, 100].contains(&code(&output)), "{}", stderr(&output));
        let written = writing.outputs.iter().map(|(name, _)| read(folder.path(), name)).collect();
        Self { writing, folder, written, needed }
    }
}

#[test]
fn kills_at_any_moment_damage_no_file() {
    let kills = std::env::var("KILLS").ok().and_then(|kills| kills.parse().ok()).unwrap_or(20);
    let mut stream = Stream::seeded(8);
    let (mut killed, mut touched, mut tries) = (0, 0, 0);
    let prepared: Vec<Prepared> = WRITING.iter().map(Prepared::new).collect();
    while killed < kills {
        let Prepared { writing, folder, written: new, needed } = &prepared[tries % prepared.len()];
        let folder = folder.path();
        tries += 1;
        assert!(tries < 20 * kills + 100, "it ends too fast to be killed: {killed} of {tries}");
        write(folder, "long.scn", &long());
        let old: Vec<String> = writing.outputs.iter().map(|(name, _)| read(folder, name)).collect();
        let before = look(folder);
        let mut child = command(folder, writing.arguments).spawn().unwrap();
        if tries % 2 == 0 {
            std::thread::sleep(needed.mul_f64(1.1 * stream.uniform()));
        } else {
            while look(folder) == before && child.try_wait().unwrap().is_none() {}
            std::thread::sleep(Duration::from_micros((3000.0 * stream.uniform() * stream.uniform()) as u64));
        }
        child.kill().unwrap();
        let was_killed = child.wait_with_output().unwrap().status.signal() == Some(9);
        killed += usize::from(was_killed);
        touched += usize::from(was_killed && look(folder) != before);
        for (index, (name, is_whole)) in writing.outputs.iter().enumerate() {
            let text = read(folder, name);
            let as_expected =
                text == old[index] || if writing.is_certain { text == new[index] } else { is_whole(&text) };
            assert!(as_expected, "{name} is damaged after {killed} kills: {} bytes", text.len());
        }
        // The next one finds nothing in its way, and leaves nothing but its results.
        let again = command(folder, writing.arguments).output().unwrap();
        assert!([0, 100].contains(&code(&again)), "{}", stderr(&again));
        for (index, (name, is_whole)) in writing.outputs.iter().enumerate() {
            let text = read(folder, name);
            assert!(if writing.is_certain { text == new[index] } else { is_whole(&text) }, "{name}");
        }
    }
    println!("{killed} kills, {touched} of them after a file was touched, 0 damaged files");
    assert!(touched > 0, "no kill came while something was written");
}

#[test]
fn a_full_disk_is_said_and_loses_nothing() {
    let folder = folder();
    let folder = folder.path();
    write(folder, "long.scn", &long());
    scenario_runner(folder, &["small.suite", "--json", "r.json", "--html", "r.html"]);
    let (json, html) = (read(folder, "r.json"), read(folder, "r.html"));
    let full = |arguments: &str| {
        // No file may get longer than so many blocks: what is written beyond is refused, as on a full disk.
        let script = format!("trap '' XFSZ; ulimit -f 2; exec \"$0\" {arguments}");
        let program = env!("CARGO_BIN_EXE_scenario-runner");
        Command::new("sh").args(["-c", &script, program]).current_dir(folder).output().unwrap()
    };
    let output = full("fmt long.scn");
    assert_eq!(code(&output), 110, "{}", stderr(&output));
    assert!(stderr(&output).contains("cannot write `long.scn`"), "{}", stderr(&output));
    assert_eq!(read(folder, "long.scn"), long());
    let output = full("small.suite --json r.json --html r.html --trace traces");
    assert_eq!(code(&output), 110, "{}", stderr(&output));
    for named in ["r.json", "r.html", "traces/"] {
        assert!(stderr(&output).contains(&format!("cannot write {named}")), "{}", stderr(&output));
    }
    assert_eq!((read(folder, "r.json"), read(folder, "r.html")), (json, html));
    let hidden = |name: &str| name.starts_with('.') && name != ".scenario-runner";
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    assert_eq!(names.filter(|name| hidden(name)).collect::<Vec<_>>(), Vec::<String>::new());
}

#[test]
fn links_permissions_and_pipes_stay_what_they_are() {
    let folder = folder();
    let folder = folder.path();
    fs::create_dir(folder.join("kept")).unwrap();
    write(&folder.join("kept"), "real.scn", &ENCOUNTER.replace("  ", "    "));
    fs::set_permissions(folder.join("kept/real.scn"), fs::Permissions::from_mode(0o640)).unwrap();
    symlink("kept/real.scn", folder.join("link.scn")).unwrap();
    let output = scenario_runner(folder, &["fmt", "link.scn"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(folder.join("link.scn").is_symlink());
    assert_eq!(read(folder, "kept/real.scn"), ENCOUNTER);
    assert_eq!(folder.join("kept/real.scn").metadata().unwrap().mode() & 0o777, 0o640);

    assert!(Command::new("mkfifo").arg(folder.join("pipe")).status().unwrap().success());
    let reader = Command::new("cat").arg(folder.join("pipe")).stdout(Stdio::piped()).spawn().unwrap();
    let output = promptly(command(folder, &["small.suite", "--json", "pipe"]));
    assert_eq!(code(&output), 100, "{}", stderr(&output));
    let said = reader.wait_with_output().unwrap().stdout;
    assert!(serde_json::from_slice::<serde_json::Value>(&said).unwrap()["suites"][0].is_object());
    assert!(!folder.join("pipe").metadata().unwrap().is_file(), "it is a pipe still");

    for name in ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"] {
        if !Path::new(name).exists() {
            continue;
        }
        // Into a file, after what stands there already and before what comes later.
        let out = fs::File::create(folder.join("out.txt")).unwrap();
        let status = command(folder, &["small.suite", "--tap", name]).stdout(out).status().unwrap();
        assert_eq!(status.code(), Some(100));
        let text = read(folder, "out.txt");
        assert!(text.contains("TAP version 14") && text.contains("Summary"), "{name}: {text}");
    }
}

/// A command as somebody who may not write everywhere: as it is, or for root as nobody, with the program at a place that
/// nobody gets to.
fn unprivileged(folder: &Path, arguments: &[&str]) -> Command {
    let own = command(folder, arguments);
    if folder.metadata().unwrap().uid() != 0 {
        return own;
    }
    let program = folder.join("program");
    if !program.exists() {
        // By another process: what this one starts meanwhile would hold the copy open for writing.
        let copied = Command::new("cp").arg(env!("CARGO_BIN_EXE_scenario-runner")).arg(&program).status();
        assert!(copied.unwrap().success());
    }
    let mut command = Command::new(program);
    command.args(arguments).current_dir(folder).uid(65_534).gid(65_534);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

#[test]
fn what_lies_in_a_folder_that_takes_no_files_is_written_in_place() {
    let folder = folder();
    let folder = folder.path();
    fs::set_permissions(folder, fs::Permissions::from_mode(0o777)).unwrap();
    let closed = folder.join("closed");
    fs::create_dir(&closed).unwrap();
    for name in ["old.scn", "readonly.scn"] {
        write(&closed, name, &ENCOUNTER.replace("  ", "    "));
    }
    fs::set_permissions(closed.join("old.scn"), fs::Permissions::from_mode(0o666)).unwrap();
    fs::set_permissions(closed.join("readonly.scn"), fs::Permissions::from_mode(0o444)).unwrap();
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).unwrap();
    let run = |arguments: &[&str]| promptly(unprivileged(folder, arguments));
    let output = run(&["fmt", "closed/old.scn"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(read(&closed, "old.scn"), ENCOUNTER);
    for (arguments, exit) in
        [(&["fmt", "closed/readonly.scn"][..], 110), (&["pass.scn", "--json", "closed/new.json"][..], 110)]
    {
        let output = run(arguments);
        assert_eq!(code(&output), exit, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).to_lowercase().contains("permission denied"), "{}", stderr(&output));
    }
    assert_eq!(read(&closed, "readonly.scn"), ENCOUNTER.replace("  ", "    "));
    let names = fs::read_dir(&closed).unwrap().count();
    assert_eq!(names, 2, "nothing is left beside them");
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn what_never_ends_is_an_error_and_no_hang() {
    let folder = folder();
    let folder = folder.path();
    assert!(Command::new("mkfifo").arg(folder.join("pipe.csv")).status().unwrap().success());
    symlink("pipe.csv", folder.join("pipe.json")).unwrap();
    symlink("/dev/zero", folder.join("zero.csv")).unwrap();
    for population in ["pipe.csv", "zero.csv"] {
        let people = format!("model commotions; individuals 2 of \"{population}\"");
        write(folder, "people.scn", &ENCOUNTER.replace("model scripted { speed: 1.4 m/s }", &people));
        let output = promptly(command(folder, &["people.scn"]));
        assert_eq!(code(&output), 3, "{}", stderr(&output));
        assert!(stderr(&output).contains("cannot read the population"), "{}", stderr(&output));
    }
    for baseline in ["pipe.csv", "pipe.json", "/dev/zero"] {
        let output = promptly(command(folder, &["compare", baseline, "small.suite"]));
        assert_eq!(code(&output), 103, "{baseline}: {}", stderr(&output));
        assert!(stderr(&output).contains("a regular file was expected"), "{}", stderr(&output));
    }
    for file in ["pipe.csv", "/dev/zero"] {
        let output = promptly(command(folder, &["fmt", file]));
        assert_eq!(code(&output), 2, "{}", stderr(&output));
        assert!(stderr(&output).contains("a regular file was expected"), "{}", stderr(&output));
    }
    let output = promptly(command(folder, &["calibrate", "--out", "o.json", "--criteria", "/dev/zero"]));
    assert_eq!(code(&output), 2, "{}", stderr(&output));
    let mut endless = command(folder, &["fmt", "-"]);
    endless.stdin(fs::File::open("/dev/zero").unwrap());
    let output = promptly(endless);
    assert_eq!(code(&output), 2, "{}", stderr(&output));
    assert!(stderr(&output).contains("more than 64 MiB"), "{}", stderr(&output));
}

const SECRET: &str = "root:x:0:0:hidden:/root:/bin/sh\nvary hidden in [1, 2]\n";

#[test]
fn files_from_others_reach_nothing_that_they_should_not_read() {
    let folder = folder();
    let folder = folder.path();
    write(folder, "secret", SECRET);
    for name in ["a.scn", "a.yaml", "a.csv", "a.json", "small.failures"] {
        symlink("secret", folder.join(name)).unwrap();
    }
    let people = |file: &str| {
        let people = format!("model commotions; individuals 2 of \"{file}\"");
        ENCOUNTER.replace("model scripted { speed: 1.4 m/s }", &people)
    };
    let gate = |file: &str| {
        format!(
            "suite gated {{\n  scenarios \"pass.scn\"\n  gate g {{ baseline \"{file}\"; no metric worse by more than 5 % with 95 % confidence }}\n}}\n"
        )
    };
    let evaluate = "evaluate e { on \"a.json\"; condition declared { }; report rate(collision) }\n";
    for (name, text) in [
        ("use.scn", format!("use \"secret\"\n{ENCOUNTER}")),
        ("use_link.scn", format!("use \"a.scn\"\n{ENCOUNTER}")),
        ("use_yaml.scn", format!("use \"a.yaml\"\n{ENCOUNTER}")),
        ("use_far.scn", format!("use \"/etc/passwd\"\n{ENCOUNTER}")),
        ("all.suite", "suite all { scenarios \"secret\" }\n".to_string()),
        ("link.suite", "suite link { scenarios \"a.*\" }\n".to_string()),
        ("people.scn", people("secret")),
        ("people_link.scn", people("a.csv")),
        ("people_json.scn", people("a.json")),
        ("gated.suite", gate("secret")),
        ("gated_link.suite", gate("a.json")),
        ("cases.scn", format!("{ENCOUNTER}{evaluate}")),
        ("small.suite", SUITE.to_string()),
        ("a.scn", String::new()),
    ] {
        if !text.is_empty() {
            write(folder, name, &text);
        }
        for arguments in [&["check", name][..], &[name]] {
            let output = promptly(command(folder, arguments));
            let said = stdout(&output) + &stderr(&output);
            assert!(!said.contains("hidden") && !said.contains("root:"), "{name}: {said}");
        }
        let output = promptly(command(folder, &[name]));
        let said = stdout(&output) + &stderr(&output);
        // The runs of a suite are judged whatever its baseline is.
        let is_refused = if name.starts_with("gated") {
            said.contains("cannot be judged: cannot read the baseline")
        } else {
            ![0, 100].contains(&code(&output))
        };
        assert!(is_refused, "{name}: {said}");
    }
}

#[test]
fn files_from_others_have_nothing_written_elsewhere() {
    let outside = tempfile::tempdir().unwrap();
    let (folder, outside) = (folder(), outside.path());
    let folder = folder.path();
    let far = outside.join("far.json");
    let suite = format!(
        "suite gated {{\n  scenarios \"pass.scn\"\n  gate g {{ baseline \"{}\"; no metric worse by more than 5 % with 95 % confidence }}\n}}\n",
        far.display()
    );
    write(folder, "gated.suite", &suite);
    let output = scenario_runner(folder, &["baseline", "save", "gated.suite"]);
    assert_eq!(code(&output), 110, "{}", stderr(&output));
    assert!(stderr(&output).contains("in its project") && !far.exists(), "{}", stderr(&output));
    // As the command line says it, it may be.
    let output =
        scenario_runner(folder, &["baseline", "save", "gated.suite", "--out", far.to_str().unwrap()]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    // A link in the project leads out of it.
    write(folder, "gated.suite", &suite.replace(far.to_str().unwrap(), "inside.json"));
    symlink(outside.join("other.json"), folder.join("inside.json")).unwrap();
    let output = scenario_runner(folder, &["baseline", "save", "gated.suite"]);
    assert_eq!(code(&output), 110, "{}", stderr(&output));

    symlink(outside.join("profile"), folder.join("small.failures")).unwrap();
    let output = scenario_runner(folder, &["small.suite", "--record-failures"]);
    assert_eq!(code(&output), 110, "{}", stderr(&output));
    assert!(stderr(&output).contains("small.failures"), "{}", stderr(&output));
    fs::remove_file(folder.join("small.failures")).unwrap();

    fs::remove_dir_all(folder.join(".scenario-runner")).unwrap();
    fs::create_dir(folder.join(".scenario-runner")).unwrap();
    symlink(outside.join("profile"), folder.join(".scenario-runner/last-run.json")).unwrap();
    let output = scenario_runner(folder, &["small.suite"]);
    assert!(stderr(&output).contains("is a link"), "{}", stderr(&output));
    fs::remove_dir_all(folder.join(".scenario-runner")).unwrap();
    symlink(outside, folder.join(".scenario-runner")).unwrap();
    let output = scenario_runner(folder, &["small.suite"]);
    assert!(stderr(&output).contains("is a link"), "{}", stderr(&output));

    let left = fs::read_dir(outside).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    assert_eq!(left.collect::<Vec<_>>(), ["far.json"]);
}

#[test]
fn a_baseline_replaces_nothing_but_its_own() {
    let folder = folder();
    let folder = folder.path();
    write(folder, "other.suite", &SUITE.replace("small", "other"));
    let save = |suite: &str, more: &[&str]| {
        scenario_runner(folder, &[&["baseline", "save", suite, "--out", "b.json"], more].concat())
    };
    assert_eq!(code(&save("small.suite", &[])), 0);
    let saved = read(folder, "b.json");
    assert_eq!(code(&save("small.suite", &[])), 0, "its own");
    assert_eq!(read(folder, "b.json"), saved);
    let kept = |text: &str, words: &str| {
        write(folder, "b.json", text);
        let output = save("other.suite", &[]);
        assert_eq!(code(&output), 110, "{}", stderr(&output));
        assert!(
            stderr(&output).contains(words) && stderr(&output).contains("--force"),
            "{}",
            stderr(&output)
        );
        assert_eq!(read(folder, "b.json"), text);
    };
    kept(&saved, "is the baseline of the suite `small`, not of `other`");
    kept("{\"people\": [1, 2, 3]}", "is no baseline");
    kept("a poem", "is no baseline");
    kept(&saved.replace("\"baseline\": 2", "\"baseline\": 3"), "another layout, 3");
    kept(&saved.replace("\"seed\": 1,", "\"seed\": 2,"), "is no baseline, or a damaged one");
    assert_eq!(code(&save("other.suite", &["--force"])), 0);
    assert!(read(folder, "b.json").contains("\"suite\": \"other\""));
}

#[test]
fn reports_replace_nothing_that_is_read_and_no_other_report() {
    let folder = folder();
    let folder = folder.path();
    std::os::unix::fs::symlink("small.suite", folder.join("link.json")).unwrap();
    let refused = |arguments: &[&str], words: &str| {
        let output = scenario_runner(folder, &[&["small.suite"], arguments].concat());
        assert_eq!(code(&output), 2, "{}", stderr(&output));
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
    };
    for option in ["--json", "--junit", "--csv", "--runs", "--html", "--tap"] {
        refused(&[option, "small.suite"], "would replace a scenario or suite");
        refused(&[option, "pass.scn"], "would replace a scenario or suite");
        refused(&[option, "link.json"], "would replace a scenario or suite");
    }
    refused(&["--json", "same.out", "--csv", "./same.out"], "`--json` and `--csv` would both be written to");
    assert!(!folder.join("same.out").exists());
    assert_eq!((read(folder, "small.suite").as_str(), read(folder, "pass.scn").as_str()), (SUITE, ENCOUNTER));
    // Pipes and devices take what comes.
    let output = scenario_runner(folder, &["small.suite", "--json", "/dev/null", "--csv", "/dev/null"]);
    assert_eq!(code(&output), code(&scenario_runner(folder, &["small.suite"])));
}

#[test]
fn a_baseline_that_was_changed_is_refused() {
    let folder = folder();
    let folder = folder.path();
    assert_eq!(code(&scenario_runner(folder, &["baseline", "save", "small.suite", "--out", "b.json"])), 0);
    let saved = read(folder, "b.json");
    for (what, named) in [("seeds", "seeds"), ("controller", "constant_speed"), ("seed", "\"seed\": 1")] {
        assert!(saved.contains(named), "a baseline names its {what}");
    }
    let mut stream = Stream::seeded(4);
    let mut refused = 0;
    let digits: Vec<usize> = saved.match_indices(|c: char| c.is_ascii_digit()).map(|(at, _)| at).collect();
    for _ in 0..40 {
        let at = digits[(stream.uniform() * digits.len() as f64) as usize];
        let mut bytes = saved.clone().into_bytes();
        bytes[at] = if bytes[at] == b'9' { b'1' } else { bytes[at] + 1 };
        fs::write(folder.join("b.json"), &bytes).unwrap();
        let output = scenario_runner(folder, &["baseline", "show", "b.json"]);
        assert_eq!(code(&output), 103, "changed at {at}: {}", stdout(&output));
        refused += 1;
    }
    assert_eq!(refused, 40);
    // However it is laid out, as long as it says the same.
    let value: serde_json::Value = serde_json::from_str(&saved).unwrap();
    write(folder, "b.json", &value.to_string());
    let output = scenario_runner(folder, &["compare", "b.json", "small.suite"]);
    assert_eq!(code(&output), 0, "{}{}", stdout(&output), stderr(&output));
}

#[test]
fn a_baseline_of_version_0_1_is_read_with_a_notice() {
    let fixture = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/formats/baseline_0.1.json");
    let output = scenario_runner(Path::new("."), &["baseline", "show", fixture]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stderr(&output).contains("is from version 0.1 and has no checksums"), "{}", stderr(&output));
    assert!(stdout(&output).contains("suite zebra_gate"), "{}", stdout(&output));
}

#[test]
fn two_processes_do_not_share_a_journal() {
    let folder = folder();
    let folder = folder.path();
    let searching = format!(
        "{ENCOUNTER}search low_pet {{\n  in pass\n  minimise pet\n  over tta in 2 s .. 18 s\n  budget 300 evaluations, 5 random first\n}}\n"
    );
    write(
        folder,
        "searching.scn",
        &searching.replace("  vary tta in [3 s, 8 s, 20 s]\n", "  vary tta in [3 s]\n"),
    );
    let journals = folder.join(".scenario-runner/journal");
    let mut first = command(folder, &["search", "low_pet", "searching.scn"]).spawn().unwrap();
    while !fs::read_dir(&journals).is_ok_and(|mut files| files.next().is_some()) {
        assert!(first.try_wait().unwrap().is_none(), "it ends too fast");
    }
    let second = promptly(command(folder, &["search", "low_pet", "searching.scn"]));
    let said = stdout(&second) + &stderr(&second);
    first.kill().unwrap();
    first.wait().unwrap();
    assert!(code(&second) != 0 && said.contains("in use by another process"), "{said}");
}
