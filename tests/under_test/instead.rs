//! `--controller av=own` and `test own as av`: the same scenarios against another system, all of it and nothing else.

use std::fs;
use std::path::Path;

use libtest_mimic::Failed;

use super::{Outcome, Said, expect, expect_all, run, scenario, written_fingerprints};

/// A scenario whose `av` says these, one that builds on it with its own, and one with another vehicle beside it.
fn scenarios(controller: &str, second: &str) -> String {
    format!(
        "define base {{
  road {{ lane_width 4 m; speed_limit 30 km/h; crossing zebra }}
  vehicle av {{ controller {controller}; speed 30 km/h; start 30 m before crossing }}
  pedestrian walker {{ model scripted; start 2 m from kerb; appears at later }}
  vary later in [0 s, 0.2 s]
  repeat 2
  finish 20 m
  expect {{ max_deceleration <= 12 m/s^2 }}
}}
scenario meet : base {{ }}
scenario again : base {{ vehicle av {{ speed 20 km/h; controller {second} }} }}
scenario two : base {{ vehicle other {{ controller constant_speed; speed 20 km/h; start 60 m before crossing }} }}
"
    )
}

const BRAKING: &str = "carla_behavior { braking_distance: 5 m }";

/// A folder with `own.scn`, in which `own` is declared, `meet.scn` and `all.suite` with that in it.
fn in_folder(meet: &str, in_suite: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let declared = scenario("", "period 100 ms");
    let declared = declared.split("\nscenario ").next().unwrap();
    fs::write(folder.path().join("own.scn"), declared).unwrap();
    fs::write(folder.path().join("meet.scn"), meet).unwrap();
    let suite = format!("use \"own.scn\"\nsuite all {{\n  scenarios \"meet.scn\"\n  {in_suite}\n}}\n");
    fs::write(folder.path().join("all.suite"), suite).unwrap();
    folder
}

fn results(folder: &Path, arguments: &[&str]) -> Result<serde_json::Value, Failed> {
    let said = run(folder, &[arguments, &["--allow-run", "--no-progress", "--json=out.json"]].concat());
    expect(said.code == Some(0), || format!("{arguments:?}: {}", said.text))?;
    Ok(serde_json::from_str(&fs::read_to_string(folder.join("out.json"))?)?)
}

fn fingerprints(folder: &Path, arguments: &[&str]) -> Result<Vec<(String, String)>, Failed> {
    results(folder, arguments)?;
    written_fingerprints(folder)
}

/// Whatever is put in its place is as if it stood there, in every scenario and template, by hand, by the suite and outside.
pub fn what_is_put_in_place_is_as_written_by_hand() -> Outcome {
    let mut seen = Vec::new();
    for controller in ["own", "own { gap: 12 m }", "carla_behavior", "idm_aeb", "constant_speed"] {
        let by_hand =
            scenarios(controller, controller).replace("define base", "use \"own.scn\"\ndefine base");
        let by_hand = fingerprints(in_folder(&by_hand, "").path(), &["all.suite"])?;
        let others = scenarios(BRAKING, "idm_aeb");
        let outside = in_folder(&others, "");
        let option = format!("av={controller}");
        let more = ["all.suite", "--controller", &option, "--use", "own.scn"];
        expect(fingerprints(outside.path(), &more)? == by_hand, || format!("{controller}: outside"))?;
        let statement = in_folder(&others, &format!("test {controller} as av"));
        expect(fingerprints(statement.path(), &["all.suite"])? == by_hand, || format!("{controller}: test"))?;
        // What is selected changes nothing of what drives.
        let some = fingerprints(statement.path(), &["all.suite", "later=0s"])?;
        let some: Vec<_> = some.iter().filter(|(key, _)| key.contains("rep=")).collect();
        expect(!some.is_empty() && some.iter().all(|one| by_hand.contains(one)), || format!("{some:#?}"))?;
        expect(!seen.contains(&by_hand), || format!("{controller} drives as another"))?;
        seen.push(by_hand);
    }
    let untouched = fingerprints(in_folder(&scenarios(BRAKING, "idm_aeb"), "").path(), &["all.suite"])?;
    expect(!seen.contains(&untouched), || "one replaces nothing".to_string())
}

/// Searches, tunes and evaluates are about it as if it stood there; a parameter that it does not have is none to be tuned.
pub fn blocks_are_about_what_is_put_in_place() -> Outcome {
    let blocks = "search worst { in meet; minimise min_distance; over later in 0 s .. 1 s; budget 6 evaluations, 3 random first }
tune best {
  on worst
  over av.controller.gap in 5 m .. 20 m
  minimise mean(max_deceleration)
  budget 6 evaluations, 3 random first
}
evaluate final { on worst; with default, best, { av.controller.gap: 7 m } as seven; measure mean(max_deceleration) }
";
    let results = |folder: &Path, arguments: &[&str]| {
        let mut json = results(folder, arguments)?;
        forget_times(&mut json);
        let blocks = json["suites"][0]["blocks"].take();
        expect(blocks.as_array().is_some_and(|all| all.len() == 3), || blocks.to_string())?;
        Ok::<_, Failed>(blocks)
    };
    let by_hand = scenarios("own { gap: 9 m }", "own { gap: 9 m }")
        .replace("define base", "use \"own.scn\"\ndefine base");
    let by_hand = results(in_folder(&(by_hand + blocks), "").path(), &["all.suite"])?;
    let others = scenarios(BRAKING, "idm_aeb") + blocks;
    let statement = in_folder(&others, "test own { gap: 9 m } as av");
    expect(results(statement.path(), &["all.suite"])? == by_hand, || "test".into())?;
    // By itself the file names a controller without that parameter, and so does one that is put there.
    let alone = in_folder(&others, "");
    for more in [&[][..], &["--controller", "av=carla_behavior"]] {
        let said = run(alone.path(), &[&["all.suite"], more].concat());
        expect_all(&said, 3, &["E0307", "`carla_behavior` has no parameter `gap`"])?;
    }
    let outside = ["all.suite", "--controller", "av=own{gap:9m}", "--use", "own.scn"];
    expect(results(alone.path(), &outside)? == by_hand, || "outside".into())
}

/// Takes out what depends on the machine, and where something stands.
fn forget_times(value: &mut serde_json::Value) {
    if let Some(fields) = value.as_object_mut() {
        fields.retain(|name, _| !name.contains("wall_time") && name != "origin" && name != "record");
        fields.values_mut().for_each(forget_times);
    }
    value.as_array_mut().into_iter().flatten().for_each(forget_times);
}

/// A file of scenarios alone takes it, and so does every one of several files.
pub fn what_replaces_nothing_is_an_error() -> Outcome {
    let folder = in_folder(&scenarios(BRAKING, "idm_aeb"), "");
    let path = folder.path();
    let refused = |arguments: &[&str], words: &[&str]| {
        let said = run(path, &[&["meet.scn", "--allow-run", "--no-progress"], arguments].concat());
        expect_all(&said, 3, words)?;
        expect(!said.text.contains("Starting"), || format!("{arguments:?} ran: {}", said.text))
    };
    let own = ["--use", "own.scn"];
    let with = |option: &'static str| [&["--controller", option][..], &own].concat();
    refused(&with("ego=own"), &["E1111", "no scenario has a vehicle `ego`", "`av`", "`other`"])?;
    refused(&with("Av=own"), &["E1111", "no scenario has a vehicle `Av`"])?;
    refused(&with("walker=own"), &["E1111", "no scenario has a vehicle `walker`"])?;
    refused(&with("av=own { gpa: 3 m }"), &["E0307", "the command line:1:10"])?;
    refused(&with("av=own { gap: 3 s }"), &["E0402"])?;
    refused(&with("av=own { gap: later }"), &["E0302"])?;
    refused(&["--controller", "av=own"], &["E0304", "no controller `own`"])?;
    refused(&["--controller", "av=carla_behavior", "--use", "nowhere.scn"], &["E0201"])?;
    refused(
        &[&with("av=own")[..], &["--controller", "av=idm_aeb"]].concat(),
        &["E1111", "two controllers are to drive `av`"],
    )?;
    for set in ["av.controller.braking_distance=3m", "av.controller=idm_aeb"] {
        refused(&[&with("av=own")[..], &["--set", set]].concat(), &["E1111", "takes the place of"])?;
    }
    // Of two files one of which has no such vehicle, nothing is run.
    fs::write(path.join("ego.scn"), scenarios(BRAKING, "idm_aeb").replace("vehicle av", "vehicle ego"))?;
    refused(&[&["ego.scn"][..], &with("av=own")].concat(), &["E1111", "no scenario has a vehicle `av`"])?;
    for wrong in ["av", "av=", "av=own {", "av=own{gap 3}"] {
        let said = run(path, &["meet.scn", "--controller", wrong]);
        expect(said.code == Some(2), || said.text.clone())?;
    }
    // Nothing of it is run without permission.
    let said = run(path, &[&["meet.scn"][..], &with("av=own")].concat());
    expect_all(&said, 3, &["E1105", "own.scn"])
}

/// Names of trials that say another controller than the one that drove, and scenarios without the vehicle.
pub fn what_replaces_only_some_is_said() -> Outcome {
    let varied =
        scenarios("sut", "sut").replace("  repeat 2", "  vary sut in [carla_behavior, idm_aeb]\n  repeat 2");
    let folder = in_folder(&varied, "");
    let said = run(folder.path(), &["meet.scn", "--controller", "av=constant_speed"]);
    expect_all(
        &said,
        3,
        &["E1111", "the variation `sut` chooses the controller of `av`", "--set sut=constant_speed"],
    )?;

    let lone = "scenario lone {
  road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
  vehicle ego { controller constant_speed; speed 30 km/h; start 30 m before crossing }
  pedestrian walker { model scripted; start 2 m from kerb; appears at 0 s }
  expect { max_deceleration <= 12 m/s^2 }
}
";
    let folder = in_folder(&(scenarios(BRAKING, "idm_aeb") + lone), "");
    let said = run(folder.path(), &["meet.scn", "--controller", "av=constant_speed", "--no-progress"]);
    let told = ["W1103", "scenario `lone` has no vehicle `av`"];
    expect(told.iter().all(|words| said.text.contains(words)), || said.text.clone())?;
    // Nor does a filter hide it.
    let said =
        run(folder.path(), &["meet.scn", "lone", "--controller", "av=constant_speed", "--no-progress"]);
    expect(told.iter().all(|words| said.text.contains(words)), || said.text.clone())?;

    // Pedals do not go into dynamics that take accelerations, which follow the controller where they are not said.
    let named =
        scenarios(BRAKING, "idm_aeb").replace("speed 30 km/h; start", "dynamics ideal; speed 30 km/h; start");
    let folder = in_folder(&named, "");
    let pedals = fs::read_to_string(folder.path().join("own.scn"))?.replace("period", "gives pedals; period");
    fs::write(folder.path().join("pedals.scn"), pedals)?;
    let said = run(folder.path(), &["meet.scn", "--controller", "av=own", "--use", "pedals.scn"]);
    expect_all(
        &said,
        3,
        &["E0510", "dynamics `ideal` do not take pedals, which is what controller `own` gives"],
    )
}

/// Every report says it, and results that are read again.
pub fn every_report_says_what_was_replaced() -> Outcome {
    let folder = in_folder(&scenarios(BRAKING, "idm_aeb"), "test own { gap: 12 m } as av");
    let reports = ["--junit=o.xml", "--tap=o.tap", "--html=o.html"];
    let arguments = [&["all.suite", "--allow-run", "--no-progress", "--json=o.json"][..], &reports].concat();
    let said = run(folder.path(), &arguments);
    let words = "av: own { gap: 12 m } instead of carla_behavior, idm_aeb";
    expect_all(&said, 0, &[words])?;
    for file in ["o.xml", "o.tap", "o.html"] {
        let text = fs::read_to_string(folder.path().join(file))?;
        expect(text.contains(words), || format!("{file}: {text}"))?;
    }
    let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(folder.path().join("o.json"))?)?;
    let tested = &json["suites"][0]["tested"][0];
    expect(
        tested["vehicle"] == "av"
            && tested["controller"] == "own { gap: 12 m }"
            && tested["instead_of"][1] == "idm_aeb",
        || json["suites"][0]["tested"].to_string(),
    )?;
    expect_all(&run(folder.path(), &["report", "o.json"]), 0, &[words])?;
    let yaml = run(folder.path(), &["convert", "--to=yaml", "all.suite"]);
    expect_all(&yaml, 0, &["test:", "av: { own: { gap: \"12 m\" } }"])
}

/// A command that repeats a run says the same again; another system is not remembered or recorded as this one.
pub fn what_is_repeated_is_driven_by_the_same() -> Outcome {
    let meet = scenarios(BRAKING, "idm_aeb").replace("<= 12 m/s^2", "<= 1 m/s^2");
    let folder = in_folder(&meet, "");
    let path = folder.path();
    let other =
        ["meet.scn", "--controller", "av=own{gap:12m}", "--use", "own.scn", "--allow-run", "--no-progress"];
    let said = run(path, &other);
    expect(said.code == Some(100), || said.text.clone())?;
    let command = said.text.split("replay: scenario-runner ").nth(1).and_then(|rest| rest.lines().next());
    let command = command.ok_or("no replay is named")?.to_string();
    expect(command.ends_with("--controller 'av=own { gap: 12 m }' --use 'own.scn'"), || command.clone())?;
    let words: Vec<&str> = command
        .split('\'')
        .enumerate()
        .flat_map(|(index, part)| match index % 2 {
            0 => part.split_whitespace().collect::<Vec<_>>(),
            _ => vec![part],
        })
        .collect();
    let said = run(path, &[&words[..], &["--allow-run"]].concat());
    expect_all(&said, 0, &["controller av=own { gap: 12 m }", "max_deceleration"])?;

    let said = run(path, &[&other[..], &["--record-failures"]].concat());
    expect(said.text.contains("is left alone: these runs are with controller av=own { gap: 12 m }"), || {
        said.text.clone()
    })?;
    expect(!path.join("meet.scn.failures").exists() && !path.join("meet.failures").exists(), || {
        "it was recorded".into()
    })?;
    let said = run(path, &["meet.scn", "--last-failed", "--no-progress"]);
    expect(said.text.contains("nothing of this is known to have failed"), || said.text.clone())?;

    let key = "meet/meet/later=0s/rep=1";
    let shrink = [
        "shrink",
        key,
        "meet.scn",
        "--controller",
        "av=own{gap:12m}",
        "--use",
        "own.scn",
        "--allow-run",
        "--no-progress",
    ];
    expect_all(&run(path, &shrink), 0, &["wrote"])?;
    let small = fs::read_to_string(path.join("meet_shrunk.scn"))?;
    expect(small.contains("controller own { gap: 12 m }") && small.contains("use \"own.scn\""), || {
        small.clone()
    })
}

/// A gate judges only against a baseline of the same, whichever of the two has another system; `compare` is asked for two.
pub fn a_gate_compares_no_other_system() -> Outcome {
    let folder = in_folder(
        &scenarios(BRAKING, "idm_aeb"),
        "gate same { baseline \"base.json\"; no metric worse by more than 50 % with 95 % confidence }",
    );
    let path = folder.path();
    let with = |controller: &'static str| ["--controller", controller, "--use", "own.scn"];
    let said =
        |first: &[&str], more: &[&str]| -> Said { run(path, &[first, more, &["--allow-run"]].concat()) };
    let save = |to: &'static str| ["baseline", "save", "all.suite", "--force", "--out", to];
    let judge = ["all.suite", "--no-progress"];
    expect_all(&said(&save("base.json"), &[]), 0, &[])?;
    expect_all(&said(&judge, &[]), 0, &[])?;
    let refused = ["these are not the runs that the baseline is of"];
    expect_all(&said(&judge, &with("av=own")), 103, &["with controller av=own these are not the runs"])?;
    expect_all(&said(&judge, &["--controller", "av=constant_speed"]), 103, &refused)?;
    expect_all(&said(&save("base.json"), &with("av=own")), 0, &[])?;
    expect_all(&said(&judge, &[]), 103, &["which were run with controller av=own"])?;
    expect_all(&said(&judge, &with("av=own{gap:12m}")), 103, &refused)?;
    expect_all(&said(&judge, &with("av=own")), 0, &[])?;
    // Where it is declared makes no other runs, and a path may be written in several ways.
    expect_all(&said(&judge, &["--controller", " av = own ", "--use", "./own.scn"]), 0, &[])?;
    expect_all(&run(path, &["baseline", "show", "base.json"]), 0, &["controller av=own"])?;

    expect_all(&said(&save("other.json"), &[]), 0, &[])?;
    let compared = run(path, &["compare", "other.json", "base.json", "--tolerance", "50%"]);
    expect(compared.text.contains("av.controller: carla_behavior -> own"), || compared.text.clone())?;

    // What the suite says itself is an edit of what is tested: compared, and told.
    fs::write(path.join("base.json"), fs::read_to_string(path.join("other.json"))?)?;
    let suite = fs::read_to_string(path.join("all.suite"))?.replace("  gate", "  test own as av\n  gate");
    fs::write(path.join("all.suite"), suite)?;
    let said = said(&judge, &[]);
    expect(said.text.contains("av.controller: carla_behavior -> own"), || said.text.clone())
}
