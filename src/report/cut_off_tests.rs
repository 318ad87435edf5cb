//! What was cut off, in every report.

use crate::fixture::Session;
use crate::junit::tests::junit;
use crate::schema::violations;
use crate::tap::tests::tap;
use crate::{Repository, annotations, html, render_tables, step_summary, write_json};

fn repository() -> Repository {
    Repository::around(std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")))
}

/// How often `part` is in `text`.
fn count(text: &str, part: &str) -> usize {
    text.matches(part).count()
}

const LIMIT: &str = "time limit of 10 s exceeded after 3 of 6 runs";
const CUT: &str = "interrupted after 5 of 6 runs";
const SUITE: &str = "interrupted: 1 finished, 3 not finished, 6 not run";

#[test]
fn junit_has_an_error_for_each_and_one_for_the_suite() {
    let session = Session::new();
    let xml = junit(&session.unrecorded(session.interrupted()));
    assert_eq!(count(&xml, "type=\"interrupted\""), 3, "{xml}");
    assert_eq!(count(&xml, "type=\"time_limit\""), 1, "{xml}");
    assert_eq!(count(&xml, "<skipped message=\"interrupted\"/>"), 6, "{xml}");
    assert!(xml.contains(LIMIT) && xml.contains(CUT) && xml.contains(SUITE), "{xml}");
    assert_eq!(count(&xml, "<failure "), 1, "{xml}");
    // Should the interruption have come between two trials, it is an error all the same.
    let mut report = session.interrupted();
    report.trials.drain(1..3);
    report.blocks.clear();
    let xml = junit(&session.unrecorded(report));
    assert_eq!(count(&xml, "<error "), 1, "{xml}");
}

#[test]
fn json_names_who_cut_it_off() {
    let session = Session::new();
    let mut text = Vec::new();
    write_json(&session.results(session.interrupted()), &mut text).unwrap();
    let value: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let schema = serde_json::from_str(include_str!("../../docs/results.schema.json")).unwrap();
    assert_eq!(violations(&schema, &value), [""; 0]);
    let suite = &value["suites"][0];
    assert_eq!(suite["interrupted"], true);
    for (index, by, message) in [(1, "time_limit", LIMIT), (2, "interrupted", CUT)] {
        let trial = &suite["trials"][index];
        assert_eq!((&trial["verdict"], &trial["cut_by"]), (&"not_finished".into(), &by.into()));
        assert_eq!(trial["message"], message);
        assert_eq!(trial["runs"].as_array().map(Vec::len), Some(0));
        assert!(trial.get("findings").is_none());
    }
    assert_eq!(suite["blocks"][0]["verdict"], "not_finished");
    assert_eq!(suite["trials"][3]["verdict"], "skipped");
}

#[test]
fn tap_bails_out() {
    let session = Session::new();
    let text = tap(&session.unrecorded(session.interrupted()));
    assert_eq!(count(&text, "\nnot ok "), 4, "{text}");
    assert_eq!(count(&text, "  severity: not finished\n"), 3, "{text}");
    assert_eq!(count(&text, "# SKIP interrupted\n"), 6, "{text}");
    assert!(text.ends_with(&format!("Bail out! suite zebra {SUITE}\n")), "{text}");
    assert!(!tap(&session.unrecorded(session.report())).contains("Bail out!"));
}

#[test]
fn github_tells_once() {
    let session = Session::new();
    let text = annotations(&session.unrecorded(session.interrupted()), &repository());
    assert_eq!(count(&text, "not finished::"), 1, "{text}");
    assert_eq!(count(&text, " interrupted::"), 1, "{text}");
    assert!(text.contains("title=not finished::") && text.contains(LIMIT), "{text}");
    assert!(text.contains(&format!("title=suite zebra interrupted::{SUITE}\n")), "{text}");
    let summary = step_summary(&session.unrecorded(session.interrupted()));
    assert!(
        summary.starts_with(&format!("## zebra: 1 ❌ failed, 3 ⏹ not finished, ⏹ {SUITE}\n")),
        "{summary}"
    );
    assert_eq!(count(&summary, "| ⏹ not finished |"), 2, "{summary}");
}

#[test]
fn people_see_it_in_tables_and_pages() {
    let session = Session::new();
    let table = render_tables(&session.interrupted(), &session.requests, false);
    assert_eq!(count(&table, "■ not finished"), 2, "{table}");
    assert!(!table.contains("error"), "{table}");
    let mut report = session.interrupted();
    report.trials.remove(0);
    let page = html::to_html(&session.unrecorded(report));
    assert!(
        page.contains("<p class=\"verdict failed\">\n\u{25a0} interrupted: 3 not finished, 6 not run"),
        "{page}"
    );
    assert!(!page.contains("could not run"), "{page}");
}
