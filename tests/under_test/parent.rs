//! Parent mode: whoever starts the runner decides, on its standard streams. The parent is played by the program under test, whose streams
//! are joined to the runner's.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use super::{
    Outcome, ROLE, Said, expect, expect_all, in_folder, many, run, runner, scenario, written_fingerprints,
};

const SERVED: [&str; 4] = ["meet.scn", "--serve-by-parent", "own", "--no-progress"];

/// A program that behaves as `words` say, where `folder` is.
fn decider(folder: &Path, words: &str) -> Child {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(words.split_whitespace()).env(ROLE, "child").current_dir(folder);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap()
}

/// The runner with these arguments, its standard streams joined to those of a program.
fn joined(folder: &Path, arguments: &[&str], decider: &mut Child) -> Child {
    let (to, from) = (decider.stdin.take().unwrap(), decider.stdout.take().unwrap());
    runner(folder, arguments).stdin(from).stdout(to).stderr(Stdio::piped()).spawn().unwrap()
}

/// What the runner says, asked by a program that behaves as `words` say.
fn served(folder: &Path, words: &str, arguments: &[&str]) -> Said {
    let mut decider = decider(folder, words);
    let runner = joined(folder, arguments, &mut decider);
    let output = runner.wait_with_output().unwrap();
    // Some stay for good.
    let _ = decider.kill();
    decider.wait().unwrap();
    Said { code: output.status.code(), text: String::from_utf8_lossy(&output.stderr).into_owned() }
}

/// The same as a child, whatever it speaks; without permission, and without starting what is declared.
pub fn a_parent_decides_as_a_child() -> Outcome {
    let text = many("touch=started", "period 100 ms");
    let folder = in_folder(&text);
    let path = folder.path();
    expect_all(&run(path, &["meet.scn", "--allow-run", "--json=out.json", "--no-progress"]), 0, &[])?;
    let known = written_fingerprints(path)?;
    fs::remove_file(path.join("started"))?;
    for (words, threads) in
        [("", "-j3"), ("at_once=64", "-j1"), ("at_once=5 encoding=f64", "-j3"), ("encoding=f64", "-j1")]
    {
        fs::remove_file(path.join("out.json"))?;
        let said = served(path, words, &[&SERVED[..], &["--json=out.json", threads]].concat());
        expect_all(&said, 0, &["Summary", "controller `own` is tested 1.0", "1 run made twice"])?;
        expect(written_fingerprints(path)? == known, || format!("{words} {threads}"))?;
        expect(!path.join("started").exists(), || "the declared program was started".into())?;
    }
    // Put in the place of another, and beside a program that still needs permission.
    let declared = text.split("\nscenario ").next().unwrap();
    fs::write(path.join("own.scn"), declared)?;
    let other = declared.replace("controller own", "controller second")
        + &text[declared.len()..].replace(
            "controller own { gap: own_gap }",
            "controller carla_behavior { braking_distance: own_gap }",
        );
    fs::write(path.join("meet.scn"), &other)?;
    let instead = ["--controller", "av=own{gap:12m}", "--use", "own.scn", "--json=out.json"];
    expect_all(
        &served(path, "", &[&SERVED[..], &instead].concat()),
        0,
        &["av: own { gap: 12 m } instead of carla_behavior"],
    )?;
    let by_parent = written_fingerprints(path)?;
    expect_all(&run(path, &[&["meet.scn", "--allow-run", "--no-progress"][..], &instead].concat()), 0, &[])?;
    expect(by_parent == written_fingerprints(path)?, || "another with --controller".into())?;
    let two = other.replace(
        "  pedestrian walker",
        "  vehicle two { controller second; speed 20 km/h; start 80 m before crossing }\n  pedestrian walker",
    );
    fs::write(path.join("meet.scn"), two)?;
    expect_all(&served(path, "", &[&SERVED[..], &instead].concat()), 3, &["E1105", "`second` wants to run"])
}

/// Every way of going wrong is an error, in time, and the parent is not asked again.
pub fn what_a_parent_must_not_is_an_error() -> Outcome {
    for (kind, words) in [
        ("crash", "exited: the parent closed its streams"),
        ("hang", "timeout: no answer within 1 s"),
        ("garbage", "garbage: `what is this?` is no"),
        ("too_few", "garbage: it answered for 0 runs, asked for 1"),
        ("answers_twice", "garbage: it said more than it was asked for"),
        ("answers_again", "garbage: it said more than it was asked for"),
        ("endless", "garbage: a line of more than 1 MiB"),
        ("nan", "bad_value: "),
        ("refuses", "refused: lane is None"),
    ] {
        let folder = in_folder(&scenario("", "answers within 1 s"));
        let words_of = format!("kind={kind}");
        let said = served(folder.path(), &words_of, &[&SERVED[..], &["--json=out.json", "-j1"]].concat());
        let goes_on = ["nan", "refuses"].contains(&kind);
        expect_all(&said, 100, &[words, "2 could not be run"])?;
        let again = said.text.contains("the parent is not asked any more");
        expect(again != goes_on, || format!("{kind}: {}", said.text))?;
        let json: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(folder.path().join("out.json"))?)?;
        for trial in json["suites"][0]["trials"].as_array().unwrap() {
            let fault = words.split(':').next().unwrap();
            let kinds = trial["faults"]
                .as_array()
                .map(|all| all.iter().map(|one| one["fault"]["kind"].clone()).collect::<Vec<_>>());
            expect(trial["verdict"] == "error" && kinds.as_deref() == Some(&[fault.into()]), || {
                format!("{kind}: {trial}")
            })?;
        }
    }
    // With many at once nobody can be asked alone, so all of them are errors.
    let folder =
        in_folder(&scenario("", "answers within 1 s").replace("[0 s, 0.2 s]", "0 s .. 1 s step 0.1 s"));
    let said = served(folder.path(), "kind=hang at_once=8", &SERVED);
    expect_all(
        &said,
        100,
        &["timeout: the parent is not asked any more: no answer within", "11 could not be run"],
    )?;
    // What never says hello, or goes at once.
    let folder = in_folder(&scenario("", "starts within 0.2 s"));
    expect_all(&served(folder.path(), "kind=silent", &SERVED), 3, &["E1107", "no answer within 0.2 s"])?;
    let folder = in_folder(&scenario("", ""));
    expect_all(&served(folder.path(), "kind=ends_at_once", &SERVED), 3, &["E1107", "closed its streams"])?;
    expect_all(&served(folder.path(), "kind=wrong_version", &SERVED), 3, &["E1107", "protocol"])?;
    let folder =
        in_folder(&scenario("", "").replace("gap = 5 m in 1 m .. 30 m", "gap = 5 m in 1 m .. 200 m"));
    expect_all(&served(folder.path(), "", &SERVED), 3, &["E1108", "`gap`"])
}

/// A clock in it shows when the same parent is asked the same again.
pub fn a_parent_that_draws_is_told_of() -> Outcome {
    let folder = in_folder(&scenario("", "period 100 ms"));
    expect_all(&served(folder.path(), "kind=clock", &SERVED), 0, &["W1102", "`own` is not deterministic"])?;
    let folder = in_folder(&scenario("", "period 100 ms\n  nondeterministic"));
    let said = served(folder.path(), "kind=clock", &SERVED);
    expect(said.code == Some(0) && !said.text.contains("W1102"), || said.text.clone())
}

/// Nothing is green that the parent did not drive, and nothing stands between the requests.
pub fn a_parent_serves_what_is_driven_by_it() -> Outcome {
    let folder = in_folder(&scenario("", ""));
    let path = folder.path();
    let with = |more: &[&str]| served(path, "", &[&SERVED[..], more].concat());
    expect_all(
        &with(&["--controller", "av=carla_behavior"]),
        2,
        &["no vehicle is driven by a declared controller `own`"],
    )?;
    let said = served(path, "", &["meet.scn", "--serve-by-parent", "carla_behavior"]);
    expect_all(&said, 2, &["no vehicle is driven by a declared controller `carla_behavior`"])?;
    for file in ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"] {
        if cfg!(target_os = "linux") {
            let said = with(&[&format!("--json={file}")]);
            expect_all(&said, 2, &["standard output belongs to the requests", file])?;
        }
    }
    expect_all(&with(&["--list"]), 2, &["cannot be used with"])?;
    // A selection in which it does not drive.
    let text = scenario("", "");
    let second = text.split("\nscenario ").nth(1).unwrap();
    let second = second.replacen("meet", "builtin", 1).replace("controller own", "controller carla_behavior");
    fs::write(path.join("meet.scn"), format!("{text}\nscenario {second}"))?;
    expect_all(&with(&["builtin"]), 4, &["the parent was not asked once"])?;
    expect_all(&with(&["meet/meet"]), 0, &[])?;
    // Two declarations of that name.
    fs::create_dir(path.join("more"))?;
    fs::write(path.join("more/other.scn"), &text)?;
    expect_all(&with(&["more/other.scn"]), 2, &["there are two controllers `own`"])?;
    let module = text
        .replace("command", "wasm")
        .lines()
        .filter(|line| !line.contains("environment"))
        .collect::<Vec<_>>()
        .join("\n");
    let module = module
        .lines()
        .map(|line| if line.contains("wasm") { "  wasm \"a.wasm\"" } else { line })
        .collect::<Vec<_>>()
        .join("\n");
    fs::write(path.join("meet.scn"), module)?;
    expect_all(&with(&[]), 2, &["`own` is no `command`"])
}

/// Ctrl-C ends the runner as ever: what was made is reported, and the parent is told goodbye.
#[cfg(unix)]
pub fn an_interrupted_runner_says_goodbye() -> Outcome {
    let folder = in_folder(&scenario("", "").replace("[0 s, 0.2 s]", "0 s .. 9 s step 0.1 s"));
    let mut decider = decider(folder.path(), "kind=slow");
    let arguments = [&SERVED[..], &["--json=out.json", "-j1"]].concat();
    let mut runner = joined(folder.path(), &arguments, &mut decider);
    let mut said = BufReader::new(runner.stderr.take().unwrap()).lines();
    said.find(|line| line.as_ref().is_ok_and(|line| line.contains("Starting"))).expect("it starts").unwrap();
    Command::new("kill").args(["-INT", &runner.id().to_string()]).status().unwrap();
    let rest: Vec<String> = said.map_while(Result::ok).collect();
    let (code, left) = (runner.wait().unwrap().code(), decider.wait().unwrap().code());
    // The program ends by itself once it is told, or hears nothing any more.
    expect((code, left) == (Some(105), Some(0)), || format!("{code:?} {left:?} {rest:#?}"))?;
    let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(folder.path().join("out.json"))?)?;
    expect(json["suites"][0]["interrupted"] == true, || rest.join("\n"))
}

/// Its parent gone, the runner ends, though somebody else holds its streams open and never answers.
#[cfg(target_os = "linux")]
pub fn a_runner_ends_with_its_parent() -> Outcome {
    let folder = in_folder(&scenario("", "answers within 600 s"));
    let path = folder.path();
    let mut middle = Command::new(std::env::current_exe()?);
    let middle = middle.env(ROLE, "middle").current_dir(path).stdin(Stdio::null()).stdout(Stdio::null());
    let mut middle = middle.stderr(Stdio::null()).spawn()?;
    let there = || super::processes_in(&path.canonicalize().unwrap()).len();
    let wait = |until: &dyn Fn(usize) -> bool| {
        let begun = Instant::now();
        while !until(there()) && begun.elapsed() < Duration::from_secs(30) {
            thread::sleep(Duration::from_millis(20));
        }
        until(there())
    };
    // It, the runner and the program.
    let began = wait(&|all| all == 3 && path.join("began").exists());
    middle.kill()?;
    middle.wait()?;
    let ended = wait(&|all| all <= 1);
    let left = super::processes_in(&path.canonicalize()?);
    left.iter().for_each(|id| _ = Command::new("kill").args(["-9", &id.to_string()]).status());
    expect(began && ended, || format!("began: {began}, left: {left:?}"))
}

/// A parent that joins the runner to a program that never answers, and waits.
pub fn middle() -> ! {
    let folder = std::env::current_dir().unwrap();
    let mut decider = decider(&folder, "kind=hang");
    let mut runner = joined(&folder, &SERVED, &mut decider);
    let mut said = BufReader::new(runner.stderr.take().unwrap()).lines();
    said.find(|line| line.as_ref().unwrap().contains("Starting")).unwrap().unwrap();
    fs::write("began", "").unwrap();
    runner.wait().unwrap();
    decider.wait().unwrap();
    std::process::exit(0)
}
