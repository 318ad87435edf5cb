//! The statements are those of the grammar, and every example is one.

use std::collections::BTreeSet;

use pest::Parser;

use super::super::grammar::Grammar;
use super::super::tree;
use super::{BlockKind, GIVEN, SETTING, WEIGHT};

#[test]
fn every_block_has_the_statements_that_the_grammar_gives_it() {
    let grammar = Grammar::read();
    for block in BlockKind::ALL.into_iter().map(BlockKind::block) {
        let known =
            block.heads.iter().chain(block.statements).map(|statement| format!("{:?}", statement.rule));
        // These stand before the braces.
        let heads = ["base", "parameters", "group_size"];
        let known: BTreeSet<String> = known.filter(|rule| !heads.contains(&rule.as_str())).collect();
        let mut possible = grammar.possible(&format!("{:?}", block.rule));
        possible.retain(|rule| !["bad", "byte_order_mark"].contains(&rule.as_str()));
        assert_eq!(known, possible, "{}", block.name);
    }
}

#[test]
fn every_example_is_the_statement() {
    let all =
        BlockKind::ALL.into_iter().flat_map(|kind| kind.block().heads.iter().chain(kind.block().statements));
    for statement in all {
        assert!(!statement.doc.is_empty() && statement.usages().count() > 0, "{}", statement.words);
        for usage in statement.usages() {
            let usage = usage.replace('…', "");
            let parsed = tree::Grammar::parse(statement.rule, &usage);
            let read = parsed.unwrap_or_else(|error| panic!("{usage}: {error}")).as_str().trim_end().len();
            assert_eq!(read, usage.trim_end().len(), "{usage}");
            assert!(usage.starts_with(statement.words), "{usage}");
        }
    }
    for settings in [&SETTING, &GIVEN, &WEIGHT] {
        assert!(settings.usage.starts_with('{'), "they stand in braces");
    }
}

#[test]
fn keys_are_unique() {
    for block in BlockKind::ALL.into_iter().map(BlockKind::block) {
        let keys: Vec<&str> = block.keys().map(|statement| statement.key).collect();
        assert_eq!(keys.iter().collect::<BTreeSet<_>>().len(), keys.len(), "{}", block.name);
    }
}
