//! Estimates whose programs fail in the middle of the runs.

use std::fs;

use super::{Outcome, expect, expect_all, in_folder, run, scenario};

/// The program dies where `gap` is above 20 m: in one of 500 runs that are drawn. What came of the others is no probability.
pub fn a_program_that_dies_in_one_of_many_runs_leaves_no_number() -> Outcome {
    for method in ["crude", "importance"] {
        let text = scenario("kind=crash_wide", "")
            .replace("controller own; speed", "controller own { gap: wide }; speed")
            .replace("  vary later in [0 s, 0.2 s]\n", "  draw later from uniform(0 s, 0.2 s)\n")
            .replace("  expect {", "  draw wide from uniform(1 m, 20.04 m)\n  expect {");
        let block = format!(
            "estimate hit {{\n  of meet\n  event max_deceleration >= 1 m/s^2\n  score max_deceleration\n  budget 2000 runs, by {method}\n  claim <= 100 %\n}}\n"
        );
        let score = if method == "crude" { block.replace("  score max_deceleration\n", "") } else { block };
        let folder = in_folder(&(text + &score));
        let files = ["--allow-run", "--no-progress", "--junit=out.xml", "--html=out.html"];
        for command in [&["meet.scn", "hit", "--json=out.json"][..], &["estimate", "hit", "meet.scn"]] {
            let said = run(folder.path(), &[command, &files].concat());
            expect_all(&said, 100, &["exited: it ended with exit code 1"])?;
            expect(!said.text.contains("guaranteed: at most"), || said.text.clone())?;
            let junit = fs::read_to_string(folder.path().join("out.xml"))?;
            expect(
                junit.contains("type=\"controller-exited\"") && !junit.contains("guaranteed: at most"),
                || junit.clone(),
            )?;
            let html = fs::read_to_string(folder.path().join("out.html"))?;
            expect(!html.contains("guaranteed: at most"), || html.clone())?;
        }
        let json: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(folder.path().join("out.json"))?)?;
        let block = &json["suites"][0]["blocks"][0];
        expect(block["verdict"] == "error" && block["result"].is_null(), || block.to_string())?;
        // Hundreds of runs came to their ends before.
        let dead = block["faults"][0]["run"].as_str().unwrap_or_default();
        println!("{method}: {dead}");
        // Nothing of it is left that could be taken for a try that passed.
        expect(!folder.path().join(".scenario-runner/estimates.json").exists(), || "remembered".into())?;
        // Without the program's fault it is one.
        let whole = fs::read_to_string(folder.path().join("meet.scn"))?.replace("20.04 m", "19.9 m");
        fs::write(folder.path().join("meet.scn"), whole)?;
        let said = run(folder.path(), &["estimate", "hit", "meet.scn", "--allow-run", "--no-progress"]);
        expect(said.text.contains("guaranteed: at most"), || said.text.clone())?;
    }
    Ok(())
}
