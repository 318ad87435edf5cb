//! Where rules describe a text.

use reader::RuleSpan;

use super::lexer::{self, Token, TokenKind};
use super::tree::Rule;

/// What the beginning of `text` is by `rule`. The brackets of the text are balanced, or lie within each other no deeper than
/// [`lexer::DEEPEST_NESTING`]: what is nested deeper is read until the stack ends.
pub fn read(rule: Rule, text: &str) -> Option<Vec<RuleSpan>> {
    let found = reader::read(rule, text);
    // Whatever a test reads is read both ways.
    #[cfg(test)]
    assert_eq!(found, tests::read_by_pest(rule, text), "{rule:?} of {text:?}");
    found
}

/// Whether brackets lie within each other no deeper than they may, and none can follow a quote without its partner.
pub fn is_shallow(tokens: &[Token]) -> bool {
    let mut open = 0_usize;
    tokens.iter().all(|token| {
        match token.kind {
            TokenKind::Open => open += 1,
            TokenKind::Close => open = open.saturating_sub(1),
            _ => {}
        }
        token.kind != TokenKind::OpenString && open <= lexer::DEEPEST_NESTING
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use files::{Disk, Files};
    use pest::Parser;
    use pest::iterators::Pair;
    use proptest::prelude::*;

    use super::super::tree::Grammar;
    use super::*;

    pub fn read_by_pest(rule: Rule, text: &str) -> Option<Vec<RuleSpan>> {
        fn add(pair: Pair<Rule>, spans: &mut Vec<RuleSpan>) {
            let (index, rule, span) = (spans.len(), pair.as_rule(), pair.as_span());
            let (start, end) = (span.start() as u32, span.end() as u32);
            spans.push(RuleSpan { rule, start, end, after: 0 });
            pair.into_inner()
                .filter(|inner| inner.as_rule() != Rule::EOI)
                .for_each(|inner| add(inner, spans));
            spans[index].after = spans.len() as u32;
        }
        let mut spans = Vec::new();
        add(Grammar::parse(rule, text).ok()?.next()?, &mut spans);
        Some(spans)
    }

    /// Every scenario file and suite that is in the repository.
    fn shipped() -> Vec<String> {
        let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
        let patterns =
            ["{}/scenarios/**/*.scn", "{}/suites/**/*.suite", "{}/templates/**/*.scn", "{}/tests/**/*.s*"];
        let paths = patterns.iter().flat_map(|pattern| {
            Disk.matching(&pattern.replace("{}", &root.display().to_string()))
                .expect("it is a pattern")
                .collect::<Vec<_>>()
        });
        paths.filter_map(|path| Disk.read_text(&path, &["scn", "suite"]).ok()).collect()
    }

    /// Every rule, and each at every place at which it describes something, where white space and comments go as they do alone.
    #[test]
    fn all_that_is_shipped_is_read_as_pest_reads_it() {
        let texts = shipped();
        assert!(texts.len() > 100, "{}", texts.len());
        let mut rules = std::collections::HashSet::new();
        for text in texts {
            let Some(whole) = read(Rule::file, &text) else { continue };
            for span in whole.iter().skip(1) {
                rules.insert(span.rule);
                read(span.rule, &text[span.start as usize..span.end as usize]);
            }
        }
        assert!(rules.len() > 250, "{}", rules.len());
    }

    /// What reads a text, piece after piece, is nowhere confused by what is missing, doubled or not there at all.
    fn mutilated() -> impl Strategy<Value = String> {
        let texts = shipped();
        let one = (
            prop::sample::select(texts),
            any::<prop::sample::Index>(),
            any::<prop::sample::Index>(),
            0..5_u8,
        );
        one.prop_map(|(text, one, other, how)| {
            let tokens = lexer::tokens(&text);
            let (from, to) = (one.index(tokens.len().max(1)), other.index(tokens.len().max(1)));
            let piece = |index: usize| tokens.get(index).map_or("", |token| &text[token.start..token.end]);
            let mut pieces: Vec<&str> = (0..tokens.len()).map(piece).collect();
            match how {
                0 => _ = pieces.drain(from.min(to)..from.max(to)),
                1 if !pieces.is_empty() => _ = pieces.remove(from),
                2 if !pieces.is_empty() => pieces.insert(from, piece(to)),
                3 if !pieces.is_empty() => pieces.swap(from, to),
                _ => pieces.insert(from, ["\u{feff}", "\r\n", "# é\n", "\t", "}", "\"", "²"][to % 7]),
            }
            pieces.concat()
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn mutilated_texts_are_read_as_pest_reads_them(text in mutilated()) {
            // Brackets need not be balanced: the depth is that of a file.
            read(Rule::file, &text);
        }

        #[test]
        fn every_rule_reads_a_piece_of_a_text_as_pest_reads_it(text in mutilated(), at in any::<prop::sample::Index>()) {
            let lines: Vec<&str> = text.split_inclusive('\n').collect();
            if !lines.is_empty() {
                let from = at.index(lines.len());
                let piece: String = lines[from..lines.len().min(from + 6)].concat();
                for rule in Rule::all_rules() {
                    // What begins with another rule is by one that is not told of, and cannot be asked for.
                    let is_told = |spans: &Vec<RuleSpan>| spans.first().is_some_and(|first| first.rule == *rule);
                    for piece in [piece.as_str(), piece.trim_start()] {
                        if read_by_pest(*rule, piece).as_ref().is_none_or(is_told) {
                            read(*rule, piece);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn the_deepest_nesting_leaves_most_of_a_small_stack() {
        let deepest = |open: &str, close: &str| {
            let depth = lexer::DEEPEST_NESTING;
            [open.repeat(depth), "1".to_string(), close.repeat(depth)].concat()
        };
        let texts = ["(", "[", "{", "(-", "each(", "x {", "road { "].map(|open| {
            let close = if open.contains('(') {
                ")"
            } else if open.contains('[') {
                "]"
            } else {
                "}"
            };
            ["let a = ", "", "scenario a { "].map(|before| {
                let end = if before.contains('{') { " }" } else { "" };
                format!("{before}{}{end}", deepest(open, close))
            })
        });
        let read_all = move || {
            for text in texts.as_flattened() {
                assert!(reader::read(Rule::file, text).is_some(), "{text}");
            }
        };
        let thread =
            std::thread::Builder::new().stack_size(256 << 10).spawn(read_all).expect("a thread begins");
        thread.join().expect("the stack is enough");
    }

    #[test]
    fn what_is_nested_deeper_than_a_file_may_be_is_told_before_it_is_read() {
        let shallow = |text: &str| is_shallow(&lexer::tokens(text));
        assert!(shallow(&"(".repeat(64)) && !shallow(&"(".repeat(65)));
        assert!(shallow(&"()".repeat(1000)) && shallow("\"((\" # (("));
        assert!(!shallow("x = y { \"(("), "what follows may be read as brackets");
    }
}
