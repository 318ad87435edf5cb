//! The statements of the language: one entry for each, and all that is known of it. The grammar's tests, checker, YAML, completion,
//! hover, JSON Schema and the page of reference take it from here. An entry stands beside the views of its block, in `ast`.

#[cfg(test)]
mod tests;

use super::ast::{self, View};
use super::entry::statement;
pub use super::entry::{BlockEntry, BlockKind, StatementEntry, YamlShape};
use super::tree::{Node, Rule};

impl BlockKind {
    pub fn block(self) -> &'static BlockEntry {
        match self {
            Self::File => &ast::FILE,
            Self::Road => &ast::ROAD,
            Self::Path => &ast::PATH,
            Self::Controller => &ast::CONTROLLER,
            Self::Scenario => &ast::SCENARIO_BLOCK,
            Self::Vehicle => &ast::VEHICLE,
            Self::Stream => &ast::STREAM,
            Self::Pedestrian => &ast::PEDESTRIAN,
            Self::Expect => &ast::EXPECT_BLOCK,
            Self::Together => &ast::TOGETHER,
            Self::Suite => &ast::SUITE,
            Self::Gate => &ast::GATE,
            Self::Rating => &ast::RATING_BLOCK,
            Self::ExpectPoints => &ast::EXPECT_POINTS,
            Self::Search => &ast::SEARCH_BLOCK,
            Self::Tune => &ast::TUNE_BLOCK,
            Self::Evaluate => &ast::EVALUATE_BLOCK,
            Self::Calibrate => &ast::CALIBRATE_BLOCK,
            Self::Estimate => &ast::ESTIMATE_BLOCK,
            Self::Statement => &ast::STATEMENT_BLOCK,
        }
    }

    fn of(rule: Rule) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.block().rule == rule)
    }
}

impl StatementEntry {
    /// The block that is the node, which is this statement, opens.
    pub fn opened<'t>(&self, node: Node<'t>) -> Option<Node<'t>> {
        let rule = self.opens?.block().rule;
        node.children().find(|child| child.rule() == rule)
    }
}

impl<'t> Node<'t> {
    /// The kind of block that it is.
    pub fn block(self) -> Option<&'static BlockEntry> {
        BlockKind::of(self.rule()).map(BlockKind::block)
    }

    /// The statement that a node of this block is.
    pub fn statement_of(self, block: &BlockEntry) -> Option<&'static StatementEntry> {
        block.heads.iter().chain(block.statements).find(|statement| statement.is(self))
    }
}

/// The statement of the block that is seen as `V`.
pub fn viewed<'t, V: View<'t>>(block: Node<'t>) -> Option<&'static StatementEntry> {
    let statements = block.block()?.statements.iter();
    statements.filter(|statement| V::is(statement.rule)).min_by_key(|statement| statement.missing.is_none())
}

/// Every statement of every block.
pub fn all() -> impl Iterator<Item = &'static StatementEntry> {
    BlockKind::ALL.into_iter().flat_map(|kind| kind.block().statements)
}

/// The blocks that have a statement beginning with the word.
pub fn homes(word: &str) -> Vec<&'static str> {
    let has = |block: &&BlockEntry| block.statements.iter().any(|statement| statement.word() == word);
    BlockKind::ALL.into_iter().map(BlockKind::block).filter(has).map(|block| block.name).collect()
}

/// A setting in braces.
pub static SETTING: StatementEntry = statement(
    "",
    Rule::whole_setting,
    "{ profile: normal, braking_distance: 5 m }",
    "A parameter with its value.",
);

/// A parameter of a road user in braces.
pub static GIVEN: StatementEntry = statement(
    "",
    Rule::whole_given,
    "{ av.controller.braking_distance: 10 m }",
    "A parameter of a road user with its value.",
);

/// What a value is worth, in braces.
pub static WEIGHT: StatementEntry = statement(
    "",
    Rule::whole_weight,
    "{ 0 km/h: 1, below 10 km/h: 0.25 }",
    "Values with what they are worth.",
);
