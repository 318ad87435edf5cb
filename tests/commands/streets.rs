//! The streets that ship: something is at stake in each, and what is hidden makes the difference that they say.

use std::collections::BTreeMap;
use std::path::Path;

use crate::support::program::{scenario_runner, stderr};

/// The verdicts of the trials of each scenario of the suite.
fn verdicts(arguments: &[&str]) -> BTreeMap<String, Vec<String>> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("results.json");
    let suite = ["suites/streets.suite", "--no-progress", "--json", file.to_str().unwrap()];
    let ran = scenario_runner(Path::new(env!("CARGO_MANIFEST_DIR")), &[&suite, arguments].concat());
    let text = std::fs::read_to_string(&file).unwrap_or_else(|_| panic!("{}", stderr(&ran)));
    let results: serde_json::Value = serde_json::from_str(&text).unwrap();
    let mut found = BTreeMap::<String, Vec<String>>::new();
    for trial in results["suites"][0]["trials"].as_array().unwrap() {
        let text = |key: &str| trial[key].as_str().unwrap_or_else(|| panic!("{key} of {trial}")).to_string();
        let scenario = text("scenario");
        found.entry(scenario).or_default().push(text("verdict"));
    }
    found
}

fn failing(verdicts: &[String]) -> usize {
    verdicts.iter().filter(|verdict| *verdict == "failed").count()
}

#[test]
fn all_pass_and_none_does_with_a_car_that_keeps_its_speed() {
    let (shipped, blind) = (verdicts(&[]), verdicts(&["--controller", "av=constant_speed"]));
    assert!(shipped.len() >= 15, "{:?}", shipped.keys());
    for (scenario, verdicts) in &shipped {
        assert!(verdicts.iter().all(|verdict| verdict == "passed"), "{scenario}: {verdicts:?}");
        assert!(failing(&blind[scenario]) > 0, "{scenario}");
    }
}

/// In pairs of one encounter, seen and not seen, the criteria of the one say that somebody is hit and those of the other that nobody is.
#[test]
fn what_a_bus_a_van_and_a_queue_hide_makes_the_difference() {
    let pairs = ["double_threat", "oncoming_queue", "bus_stop"];
    let selected = pairs.map(|scenario| format!("scenario({scenario})"));
    let seeing = |occlusion: &str| {
        let set = format!("av.sees.occlusion={occlusion}");
        let filters = selected.iter().flat_map(|one| ["-E", one]);
        verdicts(&filters.chain(["--set", &set]).collect::<Vec<_>>())
    };
    let (through, hidden) = (seeing("false"), seeing("true"));
    for scenario in pairs {
        assert!(failing(&through[scenario]) > 0, "{scenario}");
        let seen_through = format!("{scenario}_seen_through");
        assert!(failing(&hidden[&seen_through]) > 0, "{seen_through}");
        assert_eq!((failing(&through[&seen_through]), failing(&hidden[scenario])), (0, 0));
    }
}
