//! Properties that hold for every text.

mod editors;
mod statements;

use std::path::Path;
use std::sync::Arc;

use proptest::prelude::*;

use super::syntax::{Token, TokenKind};
use super::*;
use files::Memory;
use models::standard;

/// Pieces that scenario files are made of, so that random texts get past the first token.
const PIECES: &[&str] = &[
    "scenario a {",
    "}",
    "{",
    "(",
    ")",
    "[",
    "]",
    "\n",
    "\r\n",
    ";",
    ",",
    ":",
    " ",
    "  ",
    "# words\n",
    "\"text\"",
    "\"",
    "vehicle av {",
    "pedestrian walker {",
    "road street {",
    "expect {",
    "suite s {",
    "vary tta in [6 s, 10 s]",
    "vary together {",
    "controller carla_behavior",
    "{ profile: normal }",
    "speed 30 km/h",
    "start 2 m from kerb",
    "start 60 m before crossing",
    "model scripted",
    "appears when time_to_arrival(av) = tta",
    "appears at",
    "no collision",
    "pet >= 1.5 s",
    "rate(",
    "mean(pet)",
    "in 80 % of runs",
    "with 95 % confidence",
    "when tta > 3 s",
    "let x =",
    "x",
    "tta",
    "1",
    "2.5e3",
    "0x1f",
    "30 kmh",
    "m/s^2",
    "µ",
    "²",
    "\u{feff}",
    "-",
    "+",
    "*",
    "/",
    "..",
    "step",
    "100 times",
    "by sobol",
    "uniform(1 s, 2 s)",
    "define t(a = 1 s, b) {",
    ": t(a: 2 s)",
    "use \"x.scn\"",
    "scenarios \"*.scn\"",
    "seed 5",
    "tags a-b, c",
    "lanes forward, backward",
    "crossing zebra",
    "lane_width 4 m",
    "speed_limit 5 m/s",
    "box b { along: 1 m }",
    "é",
    "\\",
    "\t",
];

fn text() -> impl Strategy<Value = String> {
    let pieces =
        prop::collection::vec(prop::sample::select(PIECES), 0..60).prop_map(|pieces| pieces.concat());
    let spaced =
        prop::collection::vec(prop::sample::select(PIECES), 0..60).prop_map(|pieces| pieces.join(" "));
    prop_oneof![pieces, spaced, any::<String>()]
}

/// Everything but white space, separators and comparisons, comments included.
fn words(text: &str) -> Vec<String> {
    let (tree, _) = Tree::parse(source(), Arc::from(text));
    let kept = |token: &&Token| !matches!(token.kind, TokenKind::Space | TokenKind::Newline);
    let words =
        tree.tokens().iter().filter(kept).map(|token| text[token.start..token.end].trim_end().to_string());
    words.filter(|word| !word.chars().all(|c| ";,=<>!≤≥≠".contains(c))).collect()
}

fn source() -> SourceId {
    Sources::default().add("test.scn", "")
}

proptest! {
    #[test]
    fn tokens_put_together_are_the_text(text in text()) {
        let (tree, _) = Tree::parse(source(), Arc::from(text.as_str()));
        let mut at = 0;
        for token in tree.tokens() {
            prop_assert_eq!(token.start, at);
            prop_assert!(token.end > token.start && text.is_char_boundary(token.end));
            at = token.end;
        }
        prop_assert_eq!(at, text.len());
    }

    #[test]
    fn nodes_lie_in_their_parents_in_order(text in text()) {
        let (tree, _) = Tree::parse(source(), Arc::from(text.as_str()));
        for node in tree.nodes() {
            let mut at = node.span().start;
            for child in node.children() {
                prop_assert!(at <= child.span().start && child.span().end <= node.span().end);
                at = child.span().end;
            }
        }
    }

    #[test]
    fn formatting_keeps_words_and_comments_and_twice_is_once(text in text()) {
        if let Ok(once) = format(source(), &text) {
            prop_assert_eq!(words(&text), words(&once), "{}", once);
            prop_assert_eq!(&format(source(), &once).unwrap(), &once);
        }
    }

    #[test]
    fn no_text_makes_the_checker_panic(text in text(), is_suite: bool) {
        let name = if is_suite { "nowhere/test.suite" } else { "nowhere/test.scn" };
        if let Err(failure) = load(Path::new(name), &standard(), &Memory::default().with(name, text.as_str())) {
            prop_assert!(!failure.diagnostics.is_empty());
            let _ = failure.render(Style { colour: is_suite });
        }
    }
}

#[test]
fn long_texts_without_structure_end() {
    let nested = format!("let a = {}1{}", "(".repeat(100_000), ")".repeat(100_000));
    let chained = format!("let a = 1{}", " + 1".repeat(100_000));
    let negated = format!("let a = {}1", "-".repeat(100_000));
    let words = "foo bar ".repeat(100_000);
    for text in [nested, chained, negated, words] {
        assert!(
            load(Path::new("test.scn"), &standard(), &Memory::default().with("test.scn", text.as_str()))
                .is_err()
        );
    }
}

#[test]
fn codes_are_unique_and_explained() {
    for (index, code) in Code::ALL.iter().enumerate() {
        assert_eq!(Code::ALL.iter().position(|other| other.name() == code.name()), Some(index));
        assert!(!code.title().is_empty() && code.explanation().len() > 20, "{code}");
        assert_eq!(Code::find(code.name()), Some(*code));
    }
}
