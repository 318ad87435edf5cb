//! Every format with names, files, words and messages of people who wish us ill: their readers read what was said and obey
//! nothing.

use std::collections::BTreeSet;
use std::path::Path;

use html5gum::{Token, Tokenizer};
use proptest::prelude::*;
use pulldown_cmark::{Event as Markdown, Options, Parser, Tag};
use quick_xml::events::Event as Xml;

use super::fixture::Session;
use super::hostile_texts as texts;
use super::junit::tests::junit;
use super::tap::tests::tap;
use super::{
    Repository, annotations, diff_to_html, explain, render_gates, render_ratings, render_tables,
    step_summary, to_html,
};
use files::escape::{terminal, terminal_styled, xml_line};
use results::{Results, SuiteReport, TrialReport, UnitReport, choose_runs};

fn is_safe(letter: char) -> bool {
    matches!(letter, '\n' | '\t') || terminal(letter.encode_utf8(&mut [0; 4])).chars().eq([letter])
}

/// Without the colours that this program uses.
fn without_colours(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some(start) = rest.find("\u{1b}[") {
        plain += &rest[..start];
        rest = &rest[start + rest[start..].find('m').map_or(rest.len() - start, |end| end + 1)..];
    }
    plain + rest
}

fn repository() -> Repository {
    Repository::around(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")))
}

/// Whatever a terminal shows of a session.
fn shown(report: &SuiteReport, session: &Session, colour: bool) -> String {
    let mut text = render_tables(report, &session.requests, colour);
    let suite = std::slice::from_ref(report);
    text += &render_gates(suite, colour);
    text += &render_ratings(suite, colour);
    for trial in &report.trials {
        let unit = UnitReport::Trial(TrialReport {
            departures: Vec::new(),
            trial: trial.trial.clone(),
            outcomes: trial.outcomes.clone(),
            state: trial.state.clone(),
            wall_time: trial.wall_time,
        });
        text += &explain(&report.identity, &unit, colour);
    }
    text
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn terminals_show_names_and_obey_only_our_colours(name in texts::text()) {
        let session = Session::with_names(&name);
        let report = session.report();
        let plain = shown(&report, &session, false);
        prop_assert!(plain.chars().all(is_safe), "{:?}", plain.chars().find(|letter| !is_safe(*letter)));
        let coloured = shown(&report, &session, true);
        prop_assert_eq!(terminal_styled(&coloured), coloured.clone());
        prop_assert_eq!(without_colours(&coloured), plain);
    }

    #[test]
    fn junit_is_xml_with_the_names_in_it(name in texts::text()) {
        let session = Session::with_names(&name);
        let report = session.report();
        let text = junit(&session.unrecorded(session.report()));
        let is_xml = |letter: char| is_safe(letter) && (!letter.is_control() || matches!(letter, '\n' | '\t'));
        prop_assert!(text.chars().all(is_xml));
        let mut reader = quick_xml::Reader::from_str(&text);
        let mut names = BTreeSet::new();
        loop {
            match reader.read_event() {
                Ok(Xml::Eof) => break,
                Ok(Xml::Start(tag) | Xml::Empty(tag)) => {
                    for attribute in tag.attributes() {
                        let attribute = attribute.expect("attributes are well-formed");
                        #[allow(deprecated, reason = "the decoded value is all that is asked for")]
                        let value = attribute.unescape_value().expect("references are known").into_owned();
                        if tag.name().as_ref() == b"testcase" && attribute.key.as_ref() == b"name" {
                            names.insert(value);
                        }
                    }
                }
                Ok(_) => {}
                Err(error) => prop_assert!(false, "{error}"),
            }
        }
        for trial in &report.trials {
            let key = xml_line(&trial.trial.key);
            prop_assert!(names.contains(&key), "{key:?} in {names:?}");
        }
    }

    #[test]
    fn tap_has_its_points_and_no_others(name in texts::text()) {
        let (calm, hostile) = (Session::new(), Session::with_names(&name));
        let marks = |session: &Session| -> Vec<String> {
            let text = tap(&session.unrecorded(session.report()));
            let points = text.lines().filter(|line| !line.starts_with(' '));
            points.map(|line| line.split(" - ").next().unwrap_or_default().split('#').next().unwrap_or_default().to_string()).collect()
        };
        prop_assert_eq!(marks(&calm), marks(&hostile));
        let text = tap(&hostile.unrecorded(hostile.report()));
        prop_assert!(text.chars().all(is_safe));
        // A block begins with a line of its own; a text may end in its mark.
        for part in text.split("\n  ---\n").skip(1) {
            let yaml = part.split("\n  ...\n").next().expect("a split has a first part");
            let value: Result<serde_yaml::Value, _> = serde_yaml::from_str(yaml);
            prop_assert!(value.is_ok(), "{:?} in {yaml:?}", value);
        }
    }

    #[test]
    fn annotations_are_as_many_lines_as_without(name in texts::text()) {
        let lines = |session: &Session| annotations(&session.unrecorded(session.report()), &repository()).lines().count();
        let hostile = Session::with_names(&name);
        prop_assert_eq!(lines(&hostile), lines(&Session::new()));
        let text = annotations(&hostile.unrecorded(hostile.report()), &repository());
        prop_assert!(text.chars().all(is_safe));
        for line in text.lines() {
            prop_assert!(line.starts_with("::error file=") || line.starts_with("::warning file="), "{line}");
        }
    }

    #[test]
    fn the_summary_of_a_step_has_only_our_markup(name in texts::text()) {
        let session = Session::with_names(&name);
        let text = step_summary(&session.unrecorded(session.report()));
        prop_assert!(text.chars().all(is_safe));
        let github = Options::ENABLE_GFM | Options::ENABLE_TABLES | Options::ENABLE_STRIKETHROUGH;
        for event in Parser::new_ext(&text, github) {
            match event {
                Markdown::Html(tag) | Markdown::InlineHtml(tag) => {
                    let ours = ["<details>", "</details>", "<br>", "<sub>", "</sub>"];
                    let tag = tag.trim();
                    prop_assert!(ours.contains(&tag) || tag.starts_with("<details><summary>") && tag.matches('<').count() == 3, "{tag}");
                }
                Markdown::Start(Tag::Link { .. } | Tag::Image { .. }) => prop_assert!(false, "a link in {text}"),
                _ => {}
            }
        }
    }
}

/// The elements of a page, each with the names of its attributes.
fn elements_of(page: &str) -> BTreeSet<(Vec<u8>, Vec<Vec<u8>>)> {
    assert!(page.chars().all(is_safe));
    let mut names = BTreeSet::new();
    for token in Tokenizer::new(page) {
        if let Token::StartTag(tag) = token.expect("reading a string cannot fail") {
            let attributes: Vec<_> = tag.attributes.keys().map(|name| name.to_vec()).collect();
            names.insert((tag.name.to_vec(), attributes));
        }
    }
    names
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn a_page_of_two_runs_has_the_elements_that_it_has_without(name in texts::text()) {
        let elements = |text: &str| {
            let page = Session::with_names(text).with_diff(text, |run| diff_to_html(run, &format!("diff '{text}'")));
            elements_of(&page)
        };
        prop_assert_eq!(elements(&name), elements("x"));
    }

    #[test]
    fn a_page_has_the_elements_that_it_has_without(name in texts::text()) {
        let elements = |session: &Session| {
            let report = session.report();
            let recordings = session.record(choose_runs(&report));
            let page = to_html(&Results { recordings, ..session.unrecorded(report) });
            elements_of(&page)
        };
        prop_assert_eq!(elements(&Session::with_names(&name)), elements(&Session::with_names("x")));
    }
}
