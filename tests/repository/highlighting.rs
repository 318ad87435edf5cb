//! The TextMate grammar of the VS Code extension, applied to the texts under `editors/vscode/tests`.
//!
//! Those are in the form of the tool vscode-tmgrammar-test, which reads them too: under a line, `# ^^^ scope` says what
//! the marked characters are (`# <-- scope` the first ones), and `- scope` what they are not.

use std::path::Path;

use fancy_regex::Regex;
use serde_json::Value;

/// A pattern of the grammar.
enum Pattern {
    Match {
        regex: Regex,
        name: Option<String>,
        captures: Vec<(usize, String)>,
    },
    /// Up to `end`, also over several lines.
    Region {
        begin: Regex,
        end: Regex,
        name: Option<String>,
        patterns: Vec<Pattern>,
    },
}

impl Pattern {
    fn regex(&self) -> &Regex {
        match self {
            Self::Match { regex, .. } => regex,
            Self::Region { begin, .. } => begin,
        }
    }
}

fn text(value: &Value) -> Option<String> {
    value.as_str().map(str::to_string)
}

fn regex(value: &Value) -> Regex {
    let pattern = value.as_str().expect("a pattern is a text");
    Regex::new(pattern).unwrap_or_else(|error| panic!("{pattern}: {error}"))
}

/// The patterns of a list, those that it includes in their place. What this tokeniser does not know is refused.
fn patterns(list: &Value, grammar: &Value) -> Vec<Pattern> {
    let Some(list) = list.as_array() else { return Vec::new() };
    let mut found = Vec::new();
    for entry in list {
        let known =
            ["include", "match", "name", "captures", "begin", "end", "patterns", "comment"].map(String::from);
        for key in entry.as_object().expect("a pattern is an object").keys() {
            assert!(known.contains(key), "this test does not know `{key}` of TextMate grammars");
        }
        if let Some(name) = entry["include"].as_str() {
            let included =
                &grammar["repository"][name.strip_prefix('#').expect("only the grammar's own parts")];
            assert!(included.is_object(), "`{name}` is not in the repository");
            found.extend(patterns(&Value::Array(vec![included.clone()]), grammar));
        } else if !entry["match"].is_null() {
            let captures = entry["captures"].as_object().into_iter().flatten();
            let captures = captures.map(|(index, scope)| {
                (index.parse().expect("a capture has a number"), text(&scope["name"]).expect("and a name"))
            });
            found.push(Pattern::Match {
                regex: regex(&entry["match"]),
                name: text(&entry["name"]),
                captures: captures.collect(),
            });
        } else {
            found.push(Pattern::Region {
                begin: regex(&entry["begin"]),
                end: regex(&entry["end"]),
                name: text(&entry["name"]),
                patterns: patterns(&entry["patterns"], grammar),
            });
        }
    }
    found
}

/// Per byte of a line, the scopes from the outermost on.
type Scopes = Vec<Vec<String>>;

/// Adds a scope to bytes.
fn paint(scopes: &mut Scopes, from: usize, to: usize, name: Option<&String>) {
    for byte in &mut scopes[from..to] {
        byte.extend(name.cloned());
    }
}

/// Scopes of a line; `open` are the regions that it begins in and, afterwards, ends in.
fn tokenise<'g>(line: &str, root: &'g [Pattern], open: &mut Vec<&'g Pattern>) -> Scopes {
    let mut scopes: Scopes = vec![Vec::new(); line.len()];
    let names = |open: &[&Pattern]| -> Vec<String> {
        let names = open.iter().filter_map(|pattern| match pattern {
            Pattern::Region { name, .. } => name.clone(),
            Pattern::Match { .. } => None,
        });
        names.collect()
    };
    let mut at = 0;
    loop {
        let (inner, end): (&[Pattern], Option<&Regex>) = match open.last() {
            Some(Pattern::Region { patterns, end, .. }) => (patterns, Some(end)),
            _ => (root, None),
        };
        let place =
            |regex: &Regex| regex.find_from_pos(line, at).unwrap().map(|found| (found.start(), found.end()));
        let closing = end.and_then(place);
        // The leftmost; of several, the first in the grammar. The end of a region comes before what is in it.
        let mut best: Option<(usize, Option<&'g Pattern>)> = closing.map(|(start, _)| (start, None));
        for pattern in inner {
            if let Some((start, _)) = place(pattern.regex())
                && best.is_none_or(|(first, _)| start < first)
            {
                best = Some((start, Some(pattern)));
            }
        }
        let surrounding = names(open);
        let until = best.map_or(line.len(), |(start, _)| start);
        surrounding.iter().for_each(|name| paint(&mut scopes, at, until, Some(name)));
        let Some((start, pattern)) = best else { return scopes };
        let next = match pattern {
            None => {
                let (_, stop) = closing.expect("a region ends where its end is");
                surrounding.iter().for_each(|name| paint(&mut scopes, start, stop, Some(name)));
                open.pop();
                stop
            }
            Some(found @ Pattern::Region { begin, name, .. }) => {
                let (_, stop) = place(begin).expect("it was just found");
                surrounding.iter().for_each(|name| paint(&mut scopes, start, stop, Some(name)));
                paint(&mut scopes, start, stop, name.as_ref());
                open.push(found);
                stop
            }
            Some(Pattern::Match { regex, name, captures }) => {
                let groups = regex.captures_from_pos(line, at).unwrap().expect("it was just found");
                let stop = groups.get(0).expect("the whole match").end();
                surrounding.iter().for_each(|name| paint(&mut scopes, start, stop, Some(name)));
                paint(&mut scopes, start, stop, name.as_ref());
                for (index, scope) in captures {
                    if let Some(group) = groups.get(*index) {
                        paint(&mut scopes, group.start(), group.end(), Some(scope));
                    }
                }
                stop
            }
        };
        if next == at && start == at && pattern.is_some() {
            panic!("a pattern of the grammar matches nothing at all in {line:?}");
        }
        at = next;
    }
}

/// Columns and what is said of them, if a line is an assertion.
fn assertion(line: &str) -> Option<(std::ops::Range<usize>, Vec<&str>, Vec<&str>)> {
    let marked = line.strip_prefix('#')?;
    let mark = marked.trim_start();
    let begin = line.len() - mark.len();
    let (columns, said) = if let Some(rest) = mark.strip_prefix('<') {
        let tildes = rest.chars().take_while(|c| *c == '~').count();
        let dashes = rest[tildes..].chars().take_while(|c| *c == '-').count();
        (tildes..tildes + dashes, &rest[tildes + dashes..])
    } else {
        let carets = mark.chars().take_while(|c| *c == '^').count();
        (begin..begin + carets, &mark[carets..])
    };
    if columns.is_empty() {
        return None;
    }
    let mut parts = said.split(" - ");
    let wanted = parts.next().unwrap_or_default().split_whitespace().collect();
    Some((columns, wanted, parts.flat_map(str::split_whitespace).collect()))
}

#[test]
fn everything_is_highlighted_as_the_tests_say() {
    let grammar = std::fs::read_to_string("editors/vscode/syntaxes/scn.tmLanguage.json").unwrap();
    let grammar: Value = serde_json::from_str(&grammar).unwrap();
    let root = patterns(&grammar["patterns"], &grammar);
    let mut files: Vec<_> = std::fs::read_dir("editors/vscode/tests")
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "scn"))
        .collect();
    files.sort();
    let (mut complaints, mut said) = (Vec::new(), 0);
    for path in &files {
        let text = std::fs::read_to_string(path).unwrap();
        assert!(text.starts_with("# SYNTAX TEST \"source.scn\" \""), "{}", path.display());
        let mut open = Vec::new();
        let mut last: Scopes = Vec::new();
        for (index, line) in text.lines().enumerate().skip(1) {
            let Some((columns, wanted, unwanted)) = assertion(line) else {
                last = tokenise(line, &root, &mut open);
                continue;
            };
            said += 1;
            for column in columns {
                let place = format!("{}:{}, column {}", path.display(), index + 1, column + 1);
                let Some(found) = last.get(column) else {
                    complaints.push(format!("{place}: the line above ends before it"));
                    continue;
                };
                let mut rest = found.iter();
                let has_all = wanted.iter().all(|wanted| rest.any(|scope| scope == wanted));
                if !has_all || unwanted.iter().any(|unwanted| found.iter().any(|scope| scope == unwanted)) {
                    complaints.push(format!("{place}: {found:?}"));
                }
            }
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
    assert!(files.len() >= 5 && said >= 100, "{said} assertions in {} files", files.len());
}

/// What ships has no word that is highlighted as nothing at all, but for names.
#[test]
fn first_words_of_statements_are_keywords_in_what_ships() {
    let grammar = std::fs::read_to_string("editors/vscode/syntaxes/scn.tmLanguage.json").unwrap();
    let grammar: Value = serde_json::from_str(&grammar).unwrap();
    let root = patterns(&grammar["patterns"], &grammar);
    let mut complaints = Vec::new();
    for pattern in ["scenarios/**/*.scn", "suites/*.suite", "templates/**/*.scn", "templates/**/*.suite"] {
        for path in glob::glob(pattern).unwrap().map(Result::unwrap) {
            for (name, line) in keyword_lines(&path) {
                let scopes = tokenise(&line, &root, &mut Vec::new());
                let at = line.len() - line.trim_start().len();
                if !scopes[at]
                    .iter()
                    .any(|scope| scope.starts_with("keyword.") || scope.starts_with("support."))
                {
                    complaints.push(format!("{}: {line}: {name}", path.display()));
                }
            }
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// The lines that begin with a keyword of the language, with the keyword.
fn keyword_lines(path: &Path) -> Vec<(String, String)> {
    let grammar = std::fs::read_to_string("grammar/scn.pest").unwrap();
    let keywords: Vec<&str> = grammar
        .lines()
        .filter_map(|line| line.strip_prefix("kw_"))
        .filter_map(|line| line.split('"').nth(1))
        .collect();
    let text = std::fs::read_to_string(path).unwrap();
    let lines = text.lines().filter_map(|line| {
        let word: String =
            line.trim_start().chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
        let is_setting = line.trim_start()[word.len()..].trim_start().starts_with(':');
        (keywords.contains(&word.as_str()) && !is_setting).then(|| (word, line.to_string()))
    });
    lines.collect()
}
