//! Texts that stand for a part of a file.

use pest::Parser;

use super::tree::{Grammar, Rule, Tree};

/// What a text can stand for in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Given {
    /// `4 s`
    Value,
    /// What a variation takes its values from: `[4 s, 6 s]`
    Values,
    /// `4.5 m x 1.8 m`
    Size,
}

/// What the text stands for, all by itself and whatever stands around it.
pub fn given(text: &str) -> Option<Given> {
    let whole = |rule: Rule, statement: &str| {
        !text.contains(['\n', '\r', '#'])
            && Grammar::parse(rule, statement).is_ok_and(|mut pairs| {
                pairs.next().is_some_and(|pair| statement[pair.as_span().end()..].trim().is_empty())
            })
    };
    if whole(Rule::whole_setting, &format!("x: {text}")) {
        Some(Given::Value)
    } else if whole(Rule::vary, &format!("vary x in {text}")) {
        Some(Given::Values)
    } else if whole(Rule::size, &format!("size {text}")) {
        Some(Given::Size)
    } else {
        None
    }
}

/// A criterion by itself; its root is that criterion.
pub fn criterion(text: &str) -> Option<Tree> {
    Tree::of(Rule::criterion, text)
}

/// What a `claim` says, with the word; its root is that claim.
pub fn claim(text: &str) -> Option<Tree> {
    Tree::of(Rule::claim, &format!("claim {text}"))
}

/// A controller for vehicles of a name, as the command line says it; its root is that replacement.
pub fn replacement(text: &str) -> Option<Tree> {
    if text.contains(['\n', '\r', '#']) {
        return None;
    }
    Tree::of(Rule::replacement, text)
}
