//! Estimates whose programs fail in the middle of the runs.

use std::fs;

use super::{Outcome, expect, expect_all, in_folder, run, scenario};

/// The program dies where `gap` is above 20 m: in one of 500 runs that are drawn. What came of the others is no probability.
pub fn a_program_that_dies_in_one_of_many_runs_leaves_no_number() -> Outcome {
    let block = "estimate hit {\n  of meet\n  event max_deceleration >= 1 m/s^2\n  budget 1000 runs, by crude\n  claim <= 99 %\n}\n";
    let text = scenario("kind=crash_wide", "period 500 ms")
        .replace("controller own; speed", "controller own { gap: wide }; speed")
        .replace("  vary later in [0 s, 0.2 s]\n", "  draw later from uniform(0 s, 0.2 s)\n")
        .replace("  expect {", "  draw wide from uniform(1 m, 20.04 m)\n  expect {");
    let folder = in_folder(&(text + block));
    let files = ["--allow-run", "--no-progress", "--junit=out.xml", "--html=out.html"];
    for command in [&["meet.scn", "hit", "--json=out.json"][..], &["estimate", "hit", "meet.scn"]] {
        let said = run(folder.path(), &[command, &files].concat());
        expect_all(&said, 100, &["exited: it ended with exit code 1"])?;
        let junit = fs::read_to_string(folder.path().join("out.xml"))?;
        expect(junit.contains("type=\"controller-exited\""), || junit.clone())?;
        for told in [said.text, junit, fs::read_to_string(folder.path().join("out.html"))?] {
            expect(!told.contains("guaranteed: at most"), || told.clone())?;
        }
    }
    let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(folder.path().join("out.json"))?)?;
    let block = &json["suites"][0]["blocks"][0];
    expect(block["verdict"] == "error" && block["result"].is_null(), || block.to_string())?;
    // In the middle of them, not in the first.
    let dead = block["faults"][0]["run"].as_str().unwrap_or_default();
    let number = dead.split("rep=").nth(1).and_then(|rest| rest.split('/').next()?.parse::<u32>().ok());
    expect(number.is_some_and(|number| number > 100), || dead.to_string())?;
    // It is no try, and so none that passed.
    expect(!folder.path().join(".scenario-runner/estimates.json").exists(), || "remembered".into())
}
