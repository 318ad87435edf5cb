//! Backslashes in the names of files and in commands: folders are separated by them on Windows alone.

use super::codes::Code;
use super::diagnostic::Diagnostic;
use super::syntax::Tree;
use super::syntax::ast::{self, View};

/// Refuses backslashes that would mean nothing on this system, or something else than they look like. On Windows they separate folders.
pub fn refuse(tree: &Tree, is_translated: bool, report: &mut Vec<Diagnostic>) {
    if !cfg!(windows) {
        report.extend(found(tree, is_translated));
    }
}

/// `is_translated` if line ends and tabs of a YAML file stand there as escapes.
fn found(tree: &Tree, is_translated: bool) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for node in tree.nodes().filter_map(ast::NamesFile::cast) {
        let is_command = matches!(node, ast::NamesFile::Command(_));
        for (index, text) in node.parts::<ast::Text>().enumerate() {
            let written = text.text();
            // The first word of a command is a path, whatever the others are.
            if is_command && index > 0 {
                if written.contains('\\') && !is_escaped(written, is_translated) {
                    found.push(
                        Diagnostic::new(
                            Code::Backslash,
                            text.span(),
                            format!("a backslash in {written} means nothing here"),
                        )
                        .label("separates folders on Windows alone")
                        .hint("write `/` in a path, and `\\\\` for a backslash"),
                    );
                }
            } else if written.replace("\\\"", "").contains('\\') {
                let written = written.trim_matches('"');
                found.push(
                    Diagnostic::new(
                        Code::Backslash,
                        text.span(),
                        format!("`{written}` names a file with a backslash"),
                    )
                    .label("separates folders on Windows alone")
                    .hint(format!("write `/`, which separates them everywhere: `{}`", with_slashes(written))),
                );
            }
        }
    }
    found
}

fn with_slashes(path: &str) -> String {
    path.replace("\\\\", "/").replace('\\', "/")
}

/// Whether every backslash stands before what it makes a quote, a backslash, or a line end or tab of YAML.
fn is_escaped(written: &str, is_translated: bool) -> bool {
    let mut letters = written.chars();
    while let Some(letter) = letters.next() {
        let is_known = match (letter, letters.as_str().chars().next()) {
            ('\\', Some('"' | '\\')) => true,
            ('\\', Some('n' | 't')) => is_translated,
            ('\\', _) => false,
            _ => continue,
        };
        if !is_known {
            return false;
        }
        letters.next();
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::SourceId;

    fn said(text: &str, is_translated: bool) -> Vec<String> {
        let (tree, wrong) = Tree::parse(SourceId(0), text.into());
        assert!(wrong.is_empty(), "{wrong:?}");
        found(&tree, is_translated).into_iter().flat_map(|one| one.hints).collect()
    }

    #[test]
    fn no_backslash_is_lost_in_the_name_of_a_file() {
        let hint = |path: &str| vec![format!("write `/`, which separates them everywhere: `{path}`")];
        assert_eq!(said(r#"use "sub\road.scn""#, false), hint("sub/road.scn"));
        // Of these an escape would make other letters, or a backslash in the name of a file.
        assert_eq!(said(r#"use "new\table.scn""#, false), hint("new/table.scn"));
        assert_eq!(said(r#"use "sub\\road.scn""#, true), hint("sub/road.scn"));
        assert_eq!(said(r#"suite s { scenarios "a.scn", "sub\*.scn" }"#, false), hint("sub/*.scn"));
        let draws = r#"scenario s { draw x from "a\b.csv"; draw together from "a\b.csv" }"#;
        assert_eq!(said(draws, false), [hint("a/b.csv"), hint("a/b.csv")].concat());
        let people = r#"scenario s { pedestrian p { individuals 3 of "my\people.csv" } }"#;
        assert_eq!(said(people, false), hint("my/people.csv"));
        for right in [r#"use "sub/road.scn""#, r#"scenario s { "a\b\n" }"#, r#"use "a\"b.scn""#] {
            assert_eq!(said(right, false), [""; 0], "{right}");
        }
    }

    #[test]
    fn a_command_has_paths_and_other_words() {
        let command = |words: &str| format!("controller own {{ command {words} }}");
        assert_eq!(said(&command(r#""tools\av.exe""#), false).len(), 1);
        assert_eq!(said(&command(r#""tools\\av.exe", "x""#), false).len(), 1);
        assert_eq!(said(&command(r#""av", "data\new.json", "\tidy""#), false).len(), 2);
        assert_eq!(said(&command(r#""sed", "s/\\./-/", "say \"so\"""#), false), [""; 0]);
        // A line end that YAML has in a word.
        let lines = command(r#""python3", "-c", "a\nb""#);
        assert_eq!((said(&lines, true).len(), said(&lines, false).len()), (0, 1));
    }
}
