//! The grammar of the scenario language, and the parser that is made of it.

/// The scenario language, `scn.pest`.
#[allow(missing_docs, reason = "the grammar says what a rule is")]
pub mod scn {
    use pest_derive::Parser;

    /// The text of the grammar, for tests that compare tables with it.
    pub const TEXT: &str = include_str!("scn.pest");

    /// Reads a text by a [`Rule`].
    #[derive(Parser)]
    #[grammar = "scn.pest"]
    pub struct Grammar;
}
