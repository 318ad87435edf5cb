//! Runs that are made a second time, wherever runs are made: what is compared, evaluated or recorded says where programs decide by chance.

use super::*;

const GATE: &str = "  gate same { baseline \"base.json\"; max_deceleration not worse by more than 1 m/s^2 with 95 % confidence }\n";

/// A suite with a gate around the scenario.
fn gated(text: &str) -> tempfile::TempDir {
    let folder = in_folder(text);
    fs::write(
        folder.path().join("gated.suite"),
        format!("suite gated {{\n  scenarios \"meet.scn\"\n{GATE}}}\n"),
    )
    .unwrap();
    folder
}

/// By the clock, but so little that a gate has nothing to say against it.
fn by_chance(more: &str) -> String {
    scenario("kind=clock_a_bit", &format!("period 100 ms\n  {more}"))
        .replace("  expect {", "  repeat 8\n  expect {")
}

const SAVE: [&str; 6] = ["baseline", "save", "gated.suite", "--out", "base.json", "--allow-run"];

fn save<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&SAVE[..], more].concat()
}

/// It must not pass for one of which every run would come again.
pub fn a_baseline_by_chance_says_so() -> Outcome {
    let folder = gated(&by_chance(""));
    let path = folder.path();
    let said = run(path, &save(&[]));
    expect_all(
        &said,
        0,
        &["warning: W1102: `own` is not deterministic: at 0 s -", "1 of 1 runs that were made twice"],
    )?;
    let written = fs::read_to_string(path.join("base.json"))?;
    expect(written.contains("\"nondeterministic\": {\"own\":\"at 0 s -"), || written.clone())?;
    expect_all(
        &run(path, &["baseline", "show", "base.json"]),
        0,
        &["warning: W1102: `own` is not deterministic: at 0 s"],
    )?;
    expect_all(
        &run(path, &["baseline", "diff", "base.json", "base.json"]),
        0,
        &["warning: W1102: `own` is not deterministic: at 0 s"],
    )?;
    // A gate says it of both sides, in every report that shows gates.
    let files = ["json", "html", "junit"].map(|kind| format!("--{kind}=report.{kind}"));
    let mut arguments = vec!["gated.suite", "--allow-run", "--no-progress"];
    arguments.extend(files.iter().map(String::as_str));
    let said = run(path, &arguments);
    let both = [
        "W1102: `own` of the base is not deterministic: at 0 s",
        "W1102: `own` of the candidate is not deterministic: at 0 s",
    ];
    expect_all(&said, 0, &both)?;
    expect_all(&said, 0, &["pairs differ by chance too"])?;
    expect(!said.text.contains("pairs differ by what is tested only"), || said.text.clone())?;
    let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(path.join("report.json"))?)?;
    let known = json["suites"][0]["gates"][0]["result"]["nondeterministic"].as_array().map(Vec::len);
    expect(known == Some(2), || json["suites"][0]["gates"].to_string())?;
    let page = fs::read_to_string(path.join("report.html"))?;
    expect(page.contains("of the base is not deterministic"), || "the page does not say so".to_string())?;
    // So does a comparison, of what it runs and of what it reads.
    for arguments in [["compare", "base.json", "gated.suite"], ["compare", "gated.suite", "gated.suite"]] {
        let said = run(path, &[&arguments[..], &["--allow-run"]].concat());
        expect_all(&said, 0, &both)?;
        let said = run(path, &[&arguments[..], &["--allow-run", "--format", "markdown"]].concat());
        expect_all(&said, 0, &["of the candidate is not deterministic"])?;
    }
    // Nobody looked.
    let said = run(path, &save(&["--verify-runs=none"]));
    expect(said.code == Some(0) && !said.text.contains("W1102"), || said.text.clone())?;
    let said = run(path, &["compare", "base.json", "gated.suite", "--allow-run", "--verify-runs=none"]);
    expect(said.code == Some(0) && !said.text.contains("W1102"), || said.text.clone())?;
    let said = run(path, &save(&["--verify-runs=all"]));
    expect_all(&said, 0, &["16 of 16 runs that were made twice"])?;
    // What is known to its author is no finding, but no less so.
    let folder = gated(&by_chance("nondeterministic"));
    let said = run(folder.path(), &save(&[]));
    expect(said.code == Some(0) && !said.text.contains("W1102"), || said.text.clone())?;
    let shown = run(folder.path(), &["baseline", "show", "base.json"]);
    expect_all(&shown, 0, &["`own` is not deterministic: its declaration says so"])
}

/// A rule that could not have failed passes where nothing changed; with chance, that it did not is chance.
pub fn what_is_deterministic_is_compared_as_ever() -> Outcome {
    let folder =
        gated(&scenario("at_once=16", "period 100 ms").replace("  expect {", "  repeat 8\n  expect {"));
    let path = folder.path();
    let said = run(path, &save(&["--verify-runs=all"]));
    expect(said.code == Some(0) && !said.text.contains("W1102"), || said.text.clone())?;
    let written = fs::read_to_string(path.join("base.json"))?;
    expect(!written.contains("nondeterministic"), || written.clone())?;
    for arguments in [&["compare", "base.json", "gated.suite"][..], &["gated.suite", "--no-progress"]] {
        let said = run(path, &[arguments, &["--allow-run", "--verify-runs=all"]].concat());
        expect_all(&said, 0, &["every run went exactly as before"])?;
        expect(!said.text.contains("W1102"), || said.text.clone())?;
    }
    Ok(())
}

/// Runs that only a gate asks for are made twice like all others.
pub fn what_is_made_up_for_a_gate_is_made_twice() -> Outcome {
    // Few runs decide the trial, and the gate wants the others.
    let decided = "max_deceleration <= 9 m/s^2 in 50 % of runs with 90 % confidence";
    let text =
        scenario("kind=clock_a_bit", "period 100 ms").replace("later in [0 s, 0.2 s]", "later in [0 s]");
    let text = text.replace("max_deceleration <= 9 m/s^2", decided);
    let folder = gated(&text.replace("  expect {", "  runs 5 .. 40\n  expect {"));
    let path = folder.path();
    expect_all(&run(path, &save(&["--verify-runs=none"])), 0, &[])?;
    let said =
        run(path, &["gated.suite", "--allow-run", "--no-progress", "--verify-runs=all", "--json=out.json"]);
    let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(path.join("out.json"))?)?;
    let suite = &json["suites"][0];
    let (runs, second) =
        (suite["trials"][0]["runs"].as_array().unwrap().len(), &suite["controllers"][0]["second_runs"]);
    expect(runs < 40 && *second == 40, || format!("{runs} runs, {second} second ones: {said:?}"))
}

/// A condition of an `evaluate` and what a search or tune comes to are runs like others.
pub fn blocks_by_chance_are_warned_of() -> Outcome {
    let evaluate = "evaluate both {\n  on meet\n  with default, { av.controller.gap: 20 m } as wide\n  measure mean(time_lost)\n}\n";
    let text = scenario("kind=clock_a_bit", "period 100 ms").replace("<= 9 m/s^2", "<= 30 m/s^2") + evaluate;
    let folder = in_folder(&text);
    let made = |option: &str, words: &[&str]| {
        let said = run(
            folder.path(),
            &["meet.scn", "--exact", "meet/evaluate=both", "--allow-run", "--no-progress", option],
        );
        expect_all(&said, 0, words)
    };
    made("--verify-runs=some", &["W1102", "2 of 2 runs that were made twice"])?;
    made("--verify-runs=all", &["W1102", "4 of 4 runs that were made twice"])?;
    let tune = "tune best {\n  on meet\n  over av.controller.gap in 5 m .. 20 m\n  minimise mean(max_deceleration)\n  budget 4 evaluations, 3 random first\n}\n";
    let folder = in_folder(&(scenario("kind=clock_a_bit", "period 100 ms") + tune));
    let tuned = |option: &str| {
        run(folder.path(), &["tune", "best", "meet.scn", "--allow-run", "--no-progress", option])
    };
    expect_all(&tuned("--verify-runs=some"), 0, &["W1102", "1 of 1 runs"])?;
    expect(!tuned("--verify-runs=none").text.contains("W1102"), || "nobody looked".to_string())
}

/// Suites as tests of a project: by the same rules, and a warning fails no test.
pub fn tests_of_a_project_are_warned() -> Outcome {
    let tested = |folder: &Path, verify: &str| {
        let output = Command::new(std::env::current_exe().unwrap())
            .current_dir(folder)
            .env(ROLE, "tests")
            .env("TESTS_VERIFY", verify)
            .env("XDG_CONFIG_HOME", folder.join("config"))
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        Said { code: output.status.code(), text }
    };
    let folder = gated(&by_chance(""));
    expect_all(&run(folder.path(), &save(&["--verify-runs=none"])), 0, &[])?;
    let said = tested(folder.path(), "some");
    expect_all(&said, 0, &["warning: gated.suite: W1102: `own` is not deterministic: at 0 s -", "3 passed"])?;
    expect(said.text.matches("W1102").count() == 1, || said.text.clone())?;
    let said = tested(folder.path(), "none");
    expect(said.code == Some(0) && !said.text.contains("W1102"), || said.text.clone())?;
    // Whoever looks at a failure finds it there.
    let folder = gated(&by_chance("").replace("<= 9 m/s^2", "<= 0.0000001 m/s^2"));
    expect_all(&run(folder.path(), &save(&["--verify-runs=none"])), 0, &[])?;
    let said = tested(folder.path(), "all");
    expect_all(&said, 101, &["max_deceleration", "warning: gated.suite: W1102"])?;
    let folder = gated(&scenario("", "period 100 ms"));
    expect_all(&run(folder.path(), &save(&[])), 0, &[])?;
    let said = tested(folder.path(), "all");
    expect(said.code == Some(0) && !said.text.contains("W1102"), || said.text.clone())
}

/// The tests of [`tests_of_a_project_are_warned`].
pub fn project() -> ExitCode {
    use scenario_runner::run::VerifyRuns;
    use scenario_runner::testing::{Suites, conclude};
    let verify = match std::env::var("TESTS_VERIFY").as_deref() {
        Ok("none") => VerifyRuns::None,
        Ok("all") => VerifyRuns::All,
        _ => VerifyRuns::Some,
    };
    let suites = Suites::load_allowing(&["gated.suite"], &standard(), &["own"]);
    conclude(suites.and_then(|suites| suites.verify_runs(verify).tests(&["gated.suite"])))
}

/// A program that seeds itself by the clock is warned of in every report, and its runs are no others for that.
pub fn what_goes_by_the_clock_is_not_deterministic() -> Outcome {
    let failing = |more: &str| {
        scenario("kind=clock", &format!("period 100 ms\n  {more}")).replace("<= 9 m/s^2", "<= 0.001 m/s^2")
    };
    let folder = in_folder(&failing(""));
    let warned = ["W1102", "`own` is not deterministic", "at 0 s -"];
    let files = ["junit", "json", "tap", "html"];
    let options: Vec<_> = files.iter().map(|kind| format!("--{kind}=report.{kind}")).collect();
    let mut arguments = vec!["meet.scn", "--allow-run", "--no-progress", "--github"];
    arguments.extend(options.iter().map(String::as_str));
    let said = run(folder.path(), &arguments);
    // The failure is what it is by the runs that count; another run is not drawn for one of them.
    expect_all(&said, 100, &warned)?;
    expect_all(&said, 100, &["::warning file=meet.scn,line=1", "is not drawn: it came out differently"])?;
    for kind in files {
        let report = fs::read_to_string(folder.path().join(format!("report.{kind}")))?;
        for word in ["W1102", "is not deterministic"].iter().filter(|_| kind != "json") {
            expect(report.contains(word), || format!("{kind} does not say {word}:\n{report}"))?;
        }
    }
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("report.json"))?)?;
    let own = &json["suites"][0]["controllers"][0];
    expect(own["second_runs"] == 1 && own["differing"].as_array().is_some_and(|all| all.len() == 1), || {
        own.to_string()
    })?;
    expect(own["program"] == "tested 1.0" && own["answers"]["answers"].as_u64() > Some(10), || {
        own.to_string()
    })?;
    let runs = json["suites"][0]["trials"].as_array().unwrap().iter();
    let runs: usize = runs.map(|one| one["runs"].as_array().unwrap().len()).sum();
    expect(runs == 2, || format!("{runs} runs count"))?;
    let key = "meet/meet/later=0s/rep=1";
    let said = run(folder.path(), &["replay", key, "meet.scn", "--allow-run"]);
    expect_all(&said, 0, &["warning: W1102", "may not come out the same again"])?;
    let said =
        run(folder.path(), &["replay", key, "meet.scn", "--allow-run", "--fingerprint=0123456789abcdef"]);
    expect(said.code == Some(100), || format!("{said:?}"))?;
    for (more, option, second) in [
        ("nondeterministic", "--verify-runs=all", false),
        ("", "--verify-runs=none", false),
        ("", "--verify-runs=all", true),
    ] {
        let folder = in_folder(&failing(more));
        let said = run(folder.path(), &["meet.scn", "--allow-run", "--no-progress", option]);
        expect_all(&said, 100, &["FAIL"])?;
        expect(said.text.contains("W1102") == second, || format!("{more} {option}: {}", said.text))?;
        expect(said.text.contains("2 runs made twice") == second, || {
            format!("{more} {option}: {}", said.text)
        })?;
    }
    // What is tuned by itself is warned of as well.
    let tune = "tune best {\n  on meet\n  over av.controller.gap in 5 m .. 20 m\n  minimise mean(max_deceleration)\n  budget 4 evaluations, 3 random first\n}\n";
    let folder = in_folder(&(scenario("kind=clock", "period 100 ms") + tune));
    let said = run(folder.path(), &["tune", "best", "meet.scn", "--allow-run", "--no-progress"]);
    expect_all(&said, 0, &["W1102", "1 of 1 runs"])?;
    let folder = in_folder(&failing("nondeterministic"));
    let said = run(folder.path(), &["meet.scn", "--allow-run", "--no-progress", "--html=page.html"]);
    expect_all(&said, 100, &["as its controller says of itself"])?;
    let said = run(folder.path(), &["replay", key, "meet.scn", "--allow-run"]);
    expect_all(&said, 0, &["may not come out the same again"])
}

pub fn what_is_deterministic_is_not_warned_of() -> Outcome {
    for words in ["", "at_once=16 encoding=f64"] {
        let folder = in_folder(&many(words, "period 100 ms"));
        let said = run(folder.path(), &["meet.scn", "--allow-run", "--no-progress", "--verify-runs=all"]);
        expect(!said.text.contains("W1102"), || said.text.clone())?;
        expect_all(&said, 0, &["18 runs made twice", "6 trials, 18 runs"])?;
    }
    // What depends on the other runs of a process is found, though each process does the same every time.
    let folder = in_folder(&many("kind=counts at_once=4", "period 100 ms"));
    let said = run(folder.path(), &["meet.scn", "--allow-run", "--no-progress", "--verify-runs=all", "-j1"]);
    expect_all(&said, 0, &["W1102"])
}

/// A failure of chance is not forgotten since it did not come again.
pub fn a_recorded_failure_of_chance_is_kept() -> Outcome {
    let folder = in_folder(&scenario("kind=sometimes", "").replace("<= 9 m/s^2", "<= 2 m/s^2"));
    fs::write(folder.path().join("worse"), "")?;
    let all = ["meet.scn", "--allow-run", "--no-progress", "--verify-runs=none"];
    let said = run(folder.path(), &[&all[..], &["--record-failures"]].concat());
    expect(said.code == Some(100), || format!("{said:?}"))?;
    fs::remove_file(folder.path().join("worse"))?;
    let recorded = || -> usize {
        let files = fs::read_dir(folder.path()).unwrap().filter_map(|entry| entry.ok());
        let failures = files.filter(|entry| entry.path().extension().is_some_and(|one| one == "failures"));
        failures.map(|entry| fs::read_to_string(entry.path()).unwrap().lines().count()).sum()
    };
    let before = recorded();
    expect(before > 0, || "nothing is recorded".to_string())?;
    // With a clock in it each second run differs.
    let clock = scenario("kind=clock_a_bit", "period 100 ms").replace("<= 9 m/s^2", "<= 2 m/s^2");
    fs::write(folder.path().join("meet.scn"), clock)?;
    let said = run(
        folder.path(),
        &["meet.scn", "--allow-run", "--no-progress", "--prune-failures", "--junit=out.xml"],
    );
    expect_all(&said, 0, &["W1102"])?;
    let junit = fs::read_to_string(folder.path().join("out.xml"))?;
    expect(junit.contains("its controller is not deterministic"), || junit.clone())?;
    expect(recorded() == before, || format!("{} of {before} are left", recorded()))?;
    // The same, mended for good, is forgotten.
    fs::write(
        folder.path().join("meet.scn"),
        scenario("kind=gentle", "").replace("<= 9 m/s^2", "<= 2 m/s^2"),
    )?;
    let said = run(folder.path(), &["meet.scn", "--allow-run", "--no-progress", "--prune-failures"]);
    expect(said.code == Some(0) && recorded() < before, || format!("{said:?}"))
}
