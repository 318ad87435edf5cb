//! The page of two runs side by side.

use serde_json::Value;

use super::diff_to_html;
use super::tests::{assert_runs_our_script_alone, assert_well_formed, part};
use crate::fixture::Session;

const COMMAND: &str = "scenario-runner diff 'zebra/tta=6s/rep=1' --controller 'av=carla_behavior,idm_<aeb>'";

fn page() -> String {
    Session::new().with_diff("controller av=idm_<aeb>", |run| diff_to_html(run, COMMAND))
}

#[test]
fn both_stand_beside_each_other_with_all_that_the_terminal_says() {
    let page = page();
    let place = |text: &str| page.find(text).unwrap_or_else(|| panic!("no {text}"));
    let order = [
        "class=\"verdict ",
        "id=\"command\"",
        "<h2>Side by side</h2>",
        "id=\"sentence\"",
        "id=\"view\"",
        "id=\"second\"",
        "id=\"sentence2\"",
        "id=\"view2\"",
        "id=\"player\"",
        "<h3>Where they part",
        "<h3>Over time</h3>",
        "<h3>What happens</h3>",
        "<h2>What they do, moment by moment</h2>",
        "<h2>What both came to</h2>",
        "<h3>Metrics</h3>",
        "<h2>About these runs</h2>",
    ];
    assert!(order.windows(2).all(|pair| place(pair[0]) < place(pair[1])));
    for said in ["contact in B: av with walker", "idm_&lt;aeb&gt;", "pet &gt;= 1.5 s", "Speed of walker"] {
        assert!(page.contains(said), "no {said}");
    }
    assert!(!page.contains("idm_<aeb>"));
}

#[test]
fn browsers_run_our_script_and_no_other() {
    let page = page();
    assert_runs_our_script_alone(&page);
    assert_well_formed(&page);
    assert!(page == self::page(), "equal runs give equal bytes");
}

/// What the script looks up by a name finds one side, though both have the same key.
#[test]
fn sides_of_one_key_have_a_name_each() {
    let page = page();
    let data = part(&page, "id=\"data\">", "</script>").trim_start_matches("id=\"data\">");
    let runs: Vec<Value> = serde_json::from_str(data).unwrap();
    assert_eq!(runs[0]["key"], runs[1]["key"]);
    assert_eq!((&runs[0]["side"], &runs[1]["side"]), (&"A".into(), &"B".into()));
    assert_ne!(runs[0]["users"], runs[1]["users"]);
    assert_ne!(runs[0]["sentence"], runs[1]["sentence"]);
    // Each event is of one side, or of both.
    let events: Vec<&str> =
        runs[0]["events"].as_array().unwrap().iter().map(|event| event[1].as_str().unwrap()).collect();
    assert_eq!(events, ["A and B: walker", "A and B: av", "B: walker"]);
}

/// A page that begins in green says that nothing fails on either side.
#[test]
fn a_side_that_fails_is_not_green() {
    let page = page();
    let verdict = part(&page, "<p class=\"verdict ", "</p>");
    assert!(!verdict.starts_with("<p class=\"verdict passed"), "{verdict}");
    assert!(verdict.contains("they part at 1.02 s"), "{verdict}");
}
