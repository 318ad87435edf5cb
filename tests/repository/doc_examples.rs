//! Examples in documentation run as tests: only in packages that have some, since each package without costs a start of rustdoc.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use pulldown_cmark::{CodeBlockKind, Event, Parser, Tag};

use super::house::{PACKAGES, complain, manifest, sources};

/// The texts of comments that rustdoc reads, each run of lines as one text.
fn documentation(source: &str) -> Vec<String> {
    let mut texts = vec![String::new()];
    for line in source.lines().map(str::trim_start) {
        match line.strip_prefix("//!").or_else(|| line.strip_prefix("///")) {
            Some(text) => {
                *texts.last_mut().unwrap() += &format!("{}\n", text.strip_prefix(' ').unwrap_or(text))
            }
            None => texts.push(String::new()),
        }
    }
    texts.retain(|text| !text.is_empty());
    texts
}

/// Whether rustdoc takes a block for Rust, and runs or at least compiles it.
fn is_rust(kind: &CodeBlockKind) -> bool {
    let CodeBlockKind::Fenced(language) = kind else { return true };
    let is_attribute = |word: &str| {
        ["rust", "no_run", "should_panic", "compile_fail", "test_harness"].contains(&word)
            || word.starts_with("ignore")
            || word.starts_with("edition")
    };
    let mut words = language.split([',', ' ']).filter(|word| !word.is_empty()).peekable();
    words.peek().is_none() || words.any(is_attribute)
}

fn examples(source: &str) -> usize {
    let blocks = |text: String| {
        let is_example = |event: &Event| matches!(event, Event::Start(Tag::CodeBlock(kind)) if is_rust(kind));
        Parser::new(&text).filter(is_example).count()
    };
    documentation(source).into_iter().map(blocks).sum()
}

#[test]
fn packages_with_examples_run_them_and_others_start_no_rustdoc() {
    let grammar = Path::new(env!("CARGO_MANIFEST_DIR")).join("grammar/lib.rs");
    let mut with_examples = BTreeSet::new();
    if examples(&fs::read_to_string(grammar).unwrap()) > 0 {
        with_examples.insert("grammar".to_string());
    }
    with_examples.extend(sources().into_iter().filter(|one| examples(&one.text) > 0).map(|one| one.package));
    assert!(with_examples.len() > 1, "no package has examples: {with_examples:?}");
    let mut broken = Vec::new();
    for (package, _) in PACKAGES {
        let is_off = manifest(package).lines().any(|line| line == "doctest = false");
        match (with_examples.contains(package), is_off) {
            (true, true) => {
                broken.push(format!("`{package}` has examples, which `doctest = false` leaves out"))
            }
            (false, false) => broken.push(format!("`{package}` has no example and lacks `doctest = false`")),
            _ => {}
        }
    }
    complain(broken);
}

#[test]
fn blocks_are_examples_as_rustdoc_takes_them() {
    let count =
        |block: &str| examples(&block.lines().map(|line| format!("    /// {line}\n")).collect::<String>());
    for block in ["```\na\n```", "```no_run\na\n```", "~~~rust,ignore\na\n~~~", "A\n\n    indented"] {
        assert_eq!(count(block), 1, "{block}");
    }
    for block in ["```text\na\n```", "```toml\na\n```", "`a`", "- a\n  - b"] {
        assert_eq!(count(block), 0, "{block}");
    }
    assert_eq!(examples("//! ```\n//! a\n//! ```\nfn f() {}\n// ```\n// b\n// ```\n"), 1);
}
