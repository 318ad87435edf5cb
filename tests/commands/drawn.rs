//! Drawn runs on the command line: replayed, replayed at other points, recorded, shrunk, shared out and told.

use std::fs;
use std::path::Path;

use crate::support::program::{scenario_runner, stderr, stdout};
use serde_json::Value;

/// People of their own kind meet a car that does not care, each run another one.
const ENCOUNTER: &str = "scenario encounter {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed cruise }
  pedestrian walker {
    model commotions
    individuals drawn from standard
    start back from kerb
    appears when time_to_arrival(av) = gap * often
  }
  vary often in [1, 1.5]
  draw together from \"exposure.csv\"
  draw back from truncated_normal(1.5 m, 0.5 m, 0.5 m, 3 m)
  repeat 40
  expect { pet(av, walker) >= 4 s undefined passes; rate(collision) <= 50 % with 95 % confidence }
}
";

const EXPOSURE: &str = "gap [s],cruise [km/h],weight\n3,30,1\n4,36,2\n5,50,0\n6,40,1\n";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("encounter.scn"), ENCOUNTER).unwrap();
    fs::write(folder.path().join("exposure.csv"), EXPOSURE).unwrap();
    folder
}

fn results(folder: &Path, arguments: &[&str]) -> Value {
    let all = [&["encounter.scn", "--json", "results.json", "--no-progress"], arguments].concat();
    scenario_runner(folder, &all);
    let text = fs::read_to_string(folder.join("results.json")).expect("results are written");
    serde_json::from_str::<Value>(&text).expect("they are JSON")["suites"][0].clone()
}

fn runs(results: &Value) -> Vec<Value> {
    let trials = results["trials"].as_array().unwrap().iter();
    trials.flat_map(|trial| trial["runs"].as_array().cloned().unwrap_or_default()).collect()
}

#[test]
fn what_was_drawn_is_told_replayed_recorded_and_shrunk() {
    let folder = folder();
    let path = folder.path();
    let before = results(path, &["--record-failures", "--csv", "runs.csv", "--html", "page.html"]);
    let all = runs(&before);
    assert_eq!(all.len(), 80);
    let failing: Vec<_> =
        all.iter().filter(|run| run["criteria"][0]["holds"] == Value::Bool(false)).collect();
    assert!(failing.len() > 4 && failing.len() < 76, "{}", failing.len());
    let run = failing[0];
    let (key, fingerprint) = (run["key"].as_str().unwrap(), run["fingerprint"].as_str().unwrap());
    let names: Vec<_> =
        run["drawn"].as_array().unwrap().iter().map(|one| one["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["gap", "cruise", "back", "walker.individual"]);
    // The row without weight is never drawn.
    assert!(all.iter().all(|run| run["drawn"][0]["value"] != 5.0));
    let csv = fs::read_to_string(path.join("runs.csv")).unwrap();
    assert!(
        csv.lines().next().unwrap().contains("drawn gap,drawn cruise,drawn back,drawn walker.individual,"),
        "{csv}"
    );
    let page = fs::read_to_string(path.join("page.html")).unwrap();
    assert!(page.contains("pet(av, walker) against what was drawn"));

    let replayed = scenario_runner(path, &["replay", key, "encounter.scn", "--fingerprint", fingerprint]);
    let said = stdout(&replayed);
    assert!(replayed.status.success(), "{said}{}", stderr(&replayed));
    assert!(said.contains("  back  ") && said.contains("  gap  ") && said.contains(" individual "), "{said}");
    // At its own point it is the same run, at another point another one.
    let shares: Vec<_> =
        [0, 2, 3].map(|place| run["drawn"][place]["share"].as_f64().unwrap().to_string()).to_vec();
    let at = format!("{key}/u={}", shares.join(","));
    let again = scenario_runner(path, &["replay", &at, "encounter.scn", "--fingerprint", fingerprint]);
    assert!(again.status.success(), "{}{}", stdout(&again), stderr(&again));
    let other = format!("{key}/u={},0.5,0.5", shares[0]);
    assert!(!stdout(&scenario_runner(path, &["replay", &other, "encounter.scn"])).contains(fingerprint));

    // What failed is run first from then on, though the table may say something else by now.
    let recorded = fs::read_to_string(path.join("encounter.failures")).unwrap();
    assert!(
        recorded.contains("variation   back = ") && recorded.contains("variation   gap = "),
        "{recorded}"
    );
    fs::write(path.join("exposure.csv"), EXPOSURE.replace("5,50,0", "5,50,7")).unwrap();
    let later = results(path, &[]);
    let kept = later["recorded"].as_array().unwrap();
    assert!(!kept.is_empty() && kept.iter().all(|one| one["verdict"] == "failed"), "{kept:?}");
    fs::write(path.join("exposure.csv"), EXPOSURE).unwrap();

    let shrunk =
        scenario_runner(path, &["shrink", key, "encounter.scn", "--output", "small.scn", "--no-progress"]);
    assert!(shrunk.status.success(), "{}{}", stdout(&shrunk), stderr(&shrunk));
    let small = fs::read_to_string(path.join("small.scn")).unwrap();
    assert!(!small.contains("draw") && small.contains("seed "), "{small}");
    let again = scenario_runner(path, &["small.scn", "--no-progress"]);
    assert!(!again.status.success(), "it fails alike: {}", stdout(&again));
}

#[test]
fn shares_and_threads_and_settings_change_no_draw() {
    let folder = folder();
    let path = folder.path();
    fs::write(path.join("encounter.scn"), ENCOUNTER.replace("repeat 40", "repeat 10")).unwrap();
    let whole = runs(&results(path, &["--test-threads", "1"]));
    let halves =
        ["slice:1/2", "slice:2/2"].map(|part| runs(&results(path, &["--partition", part, "-j", "3"])));
    let bits = |run: &Value| (run["key"].clone(), run["fingerprint"].clone(), run["drawn"].clone());
    let of = |runs: &[Value]| -> Vec<_> { runs.iter().map(bits).collect() };
    assert_eq!(of(&halves.concat()), of(&whole));
    // What is set is not drawn, and the others stay.
    let set = runs(&results(path, &["--set", "back=1m"]));
    for (run, other) in whole.iter().zip(&set) {
        assert_eq!(run["drawn"].as_array().unwrap().len(), 4);
        assert_eq!(other["drawn"].as_array().unwrap().len(), 3, "{other}");
    }
    // A baseline of drawn runs stands beside the same runs, and tells when something else is drawn.
    let saved = scenario_runner(path, &["baseline", "save", "encounter.scn", "--out", "base.json"]);
    assert!(saved.status.success(), "{}{}", stdout(&saved), stderr(&saved));
    let compared = scenario_runner(path, &["compare", "base.json", "encounter.scn"]);
    let said = stdout(&compared) + &stderr(&compared);
    assert!(compared.status.success() && said.contains("same"), "{said}");
    fs::write(path.join("exposure.csv"), EXPOSURE.replace("4,36,2", "4,36,3")).unwrap();
    let other = scenario_runner(path, &["compare", "base.json", "encounter.scn"]);
    let said = stdout(&other) + &stderr(&other);
    assert!(!other.status.success() && said.contains("what runs draw differs"), "{said}");
}

/// The shipped example: the front in all reports, and an encounter on it made again.
#[test]
fn a_search_shows_how_bad_encounters_are_against_how_usual() {
    let (root, folder) = (Path::new(env!("CARGO_MANIFEST_DIR")), tempfile::tempdir().unwrap());
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (json, html, shipped) = (file("r.json"), file("r.html"), "scenarios/drawn/usual.scn");
    let output = scenario_runner(root, &[shipped, "--no-progress", "--json", &json, "--html", &html]);
    assert_eq!(output.status.code(), Some(0), "{}{}", stdout(&output), stderr(&output));
    let results: Value = serde_json::from_str(&fs::read_to_string(&json).unwrap()).unwrap();
    let search = &results["suites"][0]["blocks"][0]["result"]["search"];
    let front = search["usual"]["front"].as_array().unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    assert!(front.len() >= 3, "{front:?}");
    // The rarer the worse.
    assert!(front.windows(2).all(|pair| number(&pair[0]["value"]) < number(&pair[1]["value"])));
    assert!(front.windows(2).all(|pair| number(&pair[0]["plausibility"]) < number(&pair[1]["plausibility"])));
    // What was kept is no rarer than was asked, and not the worst of all.
    let kept = search["kept"]["cases"].as_array().unwrap();
    assert!(!kept.is_empty() && kept.iter().all(|case| number(&case["plausibility"]) >= 0.05), "{kept:?}");
    assert!(number(&front[0]["value"]) < number(&search["found"][0]["observed"]));
    let page = fs::read_to_string(&html).unwrap();
    let (chart, table) =
        (page.find("Danger against plausibility").unwrap(), page.find("Convergence").unwrap());
    assert!(chart < table, "people look at it first");
    for place in 1..=front.len() {
        let id = format!("front-usual-close_and_usual-{place}\"");
        assert!(page.contains(&format!("href=\"#{id}")) && page.contains(&format!("id=\"{id}")), "{id}");
    }
    let replayed = scenario_runner(root, &["replay", front[1]["key"].as_str().unwrap(), shipped]);
    let text = stdout(&replayed);
    assert_eq!(replayed.status.code(), Some(0), "{text}{}", stderr(&replayed));
    let pet = text.lines().find_map(|line| line.trim().strip_prefix("pet  ")).unwrap().trim().to_string();
    let value: f64 = pet.trim_end_matches(" s").parse().unwrap();
    assert!((value - number(&front[1]["value"])).abs() < 1e-3, "{pet}");
}
