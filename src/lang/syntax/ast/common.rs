//! Statements of blocks of several kinds: docs, tags, seeds and repetitions.

use super::super::entry::{StatementEntry, YamlShape, statement};
#[cfg(test)]
use super::{Holds, Made};
use super::{Integer, Text};
use super::{Node, Rule, View};

views! {
    Doc = doc { quoted: Text }
    Tags = tags { each: [Tag] }
    Tag = tag {}
    Repeat = repeat { count: Integer }
    Seed = seed { number: Integer }
}

/// What a block is about, in quotes at its beginning.
pub(super) const DOC: StatementEntry =
    statement("", Rule::doc, "\"What it is about.\"", "What it is about.").key("doc", YamlShape::Text);

pub(super) const TAGS: StatementEntry =
    statement("tags", Rule::tags, "tags paper, zebra", "Words to select scenarios by.")
        .key("tags", YamlShape::Commas);

pub(super) const REPEAT: StatementEntry =
    statement("repeat", Rule::repeat, "repeat 4", "How often everything is run, with different seeds.")
        .key("repeat", YamlShape::Words);
