//! Findings that only follow from others: names that are not known because what defines them could not be read, and what a
//! block lacks because nobody knows where it ends.

use std::collections::HashSet;

use super::codes::{Code, Severity};
use super::diagnostic::Diagnostic;
use super::source::Span;
use super::syntax::ast::{self, View};
use super::syntax::{Node, words as table};
use super::texts::Texts;

/// Codes about names that are not there.
const UNKNOWN: [Code; 10] = [
    Code::UnknownController,
    Code::UnknownName,
    Code::UnknownRoad,
    Code::UnknownVehicle,
    Code::UnknownPedestrian,
    Code::UnknownVariation,
    Code::UnknownTemplate,
    Code::UnknownScenario,
    Code::UnknownBlock,
    Code::UnknownCondition,
];

/// Codes of files of which nothing is known, besides those that are found where a file is used.
const UNREAD: [Code; 8] = [
    Code::UnclosedBracket,
    Code::MismatchedBracket,
    Code::UnopenedBracket,
    Code::UnclosedString,
    Code::NestedTooDeeply,
    Code::BadYaml,
    Code::WrongShape,
    Code::UnknownKey,
];

/// Codes about what a block lacks.
const LACKING: [Code; 3] = [Code::MissingStatement, Code::NoStart, Code::NobodyThere];

/// Removes findings about names that statements or files would define if they could be read, and about what blocks lack that
/// are not closed.
pub fn remove(files: &Texts, report: &mut Vec<Diagnostic>) {
    let unclosed: Vec<Span> = report
        .iter()
        .filter(|found| found.code == Code::UnclosedBracket)
        .flat_map(|found| heads(files, found.span()))
        .collect();
    report.retain(|found| {
        let (span, lacks) = (found.span(), LACKING.contains(&found.code));
        let is_in =
            |head: &Span| head.source == span.source && head.start <= span.start && span.end <= head.end;
        !(lacks && unclosed.iter().any(is_in))
    });
    if !report.iter().any(|found| UNKNOWN.contains(&found.code)) {
        return;
    }
    let uses: Vec<Span> =
        files.ids().flat_map(|file| files.tree(file).file().uses()).map(|used| used.path().span()).collect();
    if report.iter().any(|found| UNREAD.contains(&found.code) || uses.contains(&found.span())) {
        report.retain(|found| !UNKNOWN.contains(&found.code));
        return;
    }
    let mut names: HashSet<&str> = HashSet::new();
    for file in files.ids() {
        for block in files.tree(file).nodes() {
            names.extend(block.children().filter(|child| child.is_bad()).filter_map(|bad| named(block, bad)));
        }
    }
    // Controllers that are declared wrongly. Of one that is known, it is no consequence of anything that a file does not see it.
    let controllers = files.ids().flat_map(|file| files.tree(file).file().controllers());
    let controllers = controllers.map(|own| own.name().text());
    names.extend(controllers.filter(|name| files.registry.controllers().get(name).is_none()));
    let is_cause = |found: &Diagnostic| {
        found.severity == Severity::Error
            && !(UNKNOWN.contains(&found.code) && names.contains(files.sources.text(found.span())))
    };
    // Without a cause there is no consequence: what is left out silently would pass.
    if report.iter().any(is_cause) {
        report.retain(|found| {
            !UNKNOWN.contains(&found.code) || !names.contains(files.sources.text(found.span()))
        });
    }
}

/// What stands before the braces of the blocks that a brace opens or is in.
fn heads(files: &Texts, brace: Span) -> Vec<Span> {
    let Some(file) = files.ids().find(|file| files.tree(*file).source == brace.source) else {
        return Vec::new();
    };
    let around = files
        .tree(file)
        .nodes()
        .skip(1)
        .filter(|node| node.span().start <= brace.start && brace.start < node.span().end);
    let head = |node: Node| {
        let (span, before) = (node.span(), node.text().find('{')?);
        Some(Span::new(span.source, span.start, span.start + before))
    };
    around.filter_map(head).collect()
}

/// The name that a statement would give if it could be read.
fn named<'t>(block: Node<'t>, bad: Node<'t>) -> Option<&'t str> {
    let mut words = bad.text().split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    let first = words.next()?;
    if ast::TogetherBlock::cast(block).is_some() {
        return Some(first);
    }
    let names = table::all().any(|statement| statement.names && statement.word() == first);
    words.find(|word| !word.is_empty()).filter(|_| names)
}

#[cfg(test)]
mod tests {
    use super::*;
    use files::Memory;
    use models::standard;
    use std::path::Path;

    /// Such a scenario would be left out of its suite, and all others would pass.
    #[test]
    fn a_controller_that_a_file_does_not_see_is_an_error_though_another_file_declares_it() {
        let scenario = |name: &str, controller: &str| {
            format!(
                "scenario {name} {{
  road {{ lane_width 4 m; speed_limit 30 km/h; crossing zebra }}
  vehicle av {{ controller {controller}; speed 30 km/h; start 30 m before crossing }}
  pedestrian walker {{ model scripted; start 2 m from kerb; appears at 1 s }}
  expect {{ no collision }}
}}
"
            )
        };
        let declared = format!("controller own {{\n  command \"a\"\n}}\n{}", scenario("a", "own"));
        let files =
            Memory::default().with("a.scn", declared.as_str()).with("b.scn", scenario("b", "own").as_str());
        let files = files.with("c.scn", scenario("c", "idm_aeb").as_str());
        let loaded = |suite: &str| {
            let files = files.clone().with("s.suite", suite);
            match crate::load(Path::new("s.suite"), &standard(), &files) {
                Ok(loaded) => format!("{} scenarios", loaded.suite.scenarios.len()),
                Err(failure) => failure.diagnostics.iter().map(|found| found.message.clone()).collect(),
            }
        };
        let unknown = "this file knows no controller `own`";
        assert_eq!(loaded("suite s {\n  scenarios \"[ac].scn\"\n}\n"), "2 scenarios");
        assert_eq!(loaded("suite s {\n  scenarios \"*.scn\"\n}\n"), unknown);
        assert_eq!(loaded("suite s {\n  scenarios \"[ac].scn\"\n  test own as av\n}\n"), unknown);
        let uses = "use \"a.scn\"\nsuite s {\n  scenarios \"[ac].scn\"\n  test own as av\n}\n";
        assert_eq!(loaded(uses), "2 scenarios");
        // One that is declared wrongly is the cause, and those who name it are not told besides.
        let files = Memory::default().with("a.scn", declared.replace("command", "comand").as_str());
        let Err(failure) = crate::load(Path::new("a.scn"), &standard(), &files) else {
            panic!("it is wrong")
        };
        assert!(failure.diagnostics.iter().all(|found| found.code != Code::UnknownController));
    }
}
