//! Reads texts of the scenario language: finds the same matches as the parser of `grammar`, and collects nothing for error messages.
//! Filters are read here, too.
//!
//! The functions of the rules are generated from the grammar by `build.rs`. They are a package of their own since every file is read by
//! them, so that they are optimised; the parser of `grammar` reads only texts that they do not match, and is not.

use grammar::scn::Rule;

/// Filters of runs and trials, `filter.pest`.
#[allow(missing_docs, reason = "the grammar says what a rule is")]
pub mod filter {
    use pest_derive::Parser;

    /// Reads a text by a [`Rule`].
    #[derive(Parser)]
    #[grammar = "filter.pest"]
    pub struct Grammar;
}

/// The match of a rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RuleSpan {
    /// The rule that matched.
    pub rule: Rule,
    /// Place of the first byte.
    pub start: u32,
    /// Place behind the last byte, and behind white space that was skipped there.
    pub end: u32,
    /// Index of the first match that does not lie within this one.
    pub after: u32,
}

/// Matches the beginning of `text` with `rule`: gives the match of the rule itself and of all rules within it, in the order in which
/// they begin, without the end of the text. `None` where `rule` does not match; the parser of `grammar` says why. Silent rules have no
/// match of their own and give `None`.
///
/// # Panics
/// If the text has 4 GiB or more.
pub fn read(rule: Rule, text: &str) -> Option<Vec<RuleSpan>> {
    assert!(u32::try_from(text.len()).is_ok(), "a text has less than 4 GiB");
    let mut reader = Reader { text: text.as_bytes(), spans: Vec::with_capacity(text.len() / 8) };
    rules::begin(rule, &mut reader).map(|_| reader.spans)
}

struct Reader<'t> {
    text: &'t [u8],
    spans: Vec<RuleSpan>,
}

impl Reader<'_> {
    fn next(&self, at: usize) -> Option<u8> {
        self.text.get(at).copied()
    }

    fn one(&self, at: usize, belongs: impl Fn(u8) -> bool) -> Option<usize> {
        self.next(at).filter(|byte| belongs(*byte)).map(|_| at + 1)
    }

    fn exactly<const LENGTH: usize>(&self, at: usize, text: [u8; LENGTH]) -> Option<usize> {
        let found = self.text.get(at..)?.first_chunk::<LENGTH>()?;
        (*found == text).then_some(at + LENGTH)
    }

    fn in_any_case<const LENGTH: usize>(&self, at: usize, text: [u8; LENGTH]) -> Option<usize> {
        let found = self.text.get(at..)?.first_chunk::<LENGTH>()?;
        found.eq_ignore_ascii_case(&text).then_some(at + LENGTH)
    }

    /// A character.
    fn any(&self, at: usize) -> Option<usize> {
        let length = match self.next(at)? {
            0..0x80 => 1,
            0x80..0xe0 => 2,
            0xe0..0xf0 => 3,
            0xf0.. => 4,
        };
        Some(at + length)
    }

    fn newline(&self, at: usize) -> Option<usize> {
        match self.next(at)? {
            b'\n' => Some(at + 1),
            b'\r' if self.next(at + 1) == Some(b'\n') => Some(at + 2),
            b'\r' => Some(at + 1),
            _ => None,
        }
    }

    fn end(&self, at: usize) -> Option<usize> {
        (at == self.text.len()).then_some(at)
    }

    /// What `read` gives, told of as what `rule` describes unless nothing is to be told.
    #[inline(always)]
    fn rule<const QUIET: bool>(
        &mut self,
        rule: Rule,
        at: usize,
        read: impl FnOnce(&mut Self) -> Option<usize>,
    ) -> Option<usize> {
        if QUIET {
            return read(self);
        }
        let index = self.told();
        self.spans.push(RuleSpan { rule, start: at as u32, end: 0, after: 0 });
        let Some(end) = read(self) else {
            self.forget(index);
            return None;
        };
        let after = self.told() as u32;
        self.spans[index] = RuleSpan { rule, start: at as u32, end: end as u32, after };
        Some(end)
    }

    fn told(&self) -> usize {
        self.spans.len()
    }

    /// Takes back what was told since.
    fn forget(&mut self, told: usize) {
        self.spans.truncate(told);
    }
}

#[allow(unused, non_snake_case, clippy::all, reason = "made by `build.rs`")]
mod rules {
    use super::{Reader, Rule};

    include!(concat!(env!("OUT_DIR"), "/scn.rs"));
}
