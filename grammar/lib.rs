//! The grammars of scenarios and of filters, and the parsers that are made of them.

/// The scenario language, `scn.pest`.
#[allow(missing_docs, reason = "the grammar says what a rule is")]
pub mod scn {
    use pest_derive::Parser;

    /// What the parser is made of, for tests that hold tables against it.
    pub const TEXT: &str = include_str!("scn.pest");

    /// Reads a text by a [`Rule`].
    #[derive(Parser)]
    #[grammar = "scn.pest"]
    pub struct Grammar;

    pub use reader::{RuleSpan, read};

    mod reader;
}

/// Filters of runs and trials, `filter.pest`.
#[allow(missing_docs, reason = "the grammar says what a rule is")]
pub mod filter {
    use pest_derive::Parser;

    /// Reads a text by a [`Rule`].
    #[derive(Parser)]
    #[grammar = "filter.pest"]
    pub struct Grammar;
}
