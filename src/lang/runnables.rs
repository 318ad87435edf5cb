//! What of a text can be run by its name.

use std::ops::Range;

use super::source::Sources;
use super::syntax::Tree;

/// A scenario or suite that can be run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Runnable {
    /// As it is written.
    pub name: String,
    /// Whether it is a suite.
    pub is_suite: bool,
    /// Bytes of the name.
    pub at: Range<usize>,
}

/// The suites and scenarios of a text in the language, templates left out, in order.
pub fn runnables(text: &str) -> Vec<Runnable> {
    let (tree, _) = Tree::parse(Sources::default().add("", ""), text.into());
    let file = tree.file();
    let inner = file.suites().flat_map(|suite| suite.block().scenarios());
    let scenarios = file.scenarios().chain(inner).filter(|one| !one.is_template());
    let names = scenarios.map(|one| (one.name(), false)).chain(file.suites().map(|one| (one.name(), true)));
    let mut found: Vec<Runnable> = names
        .map(|(name, is_suite)| {
            let span = name.span();
            Runnable { name: name.text().to_string(), is_suite, at: span.start..span.end }
        })
        .collect();
    found.sort_by_key(|one| one.at.start);
    found
}
