//! Files, which hold everything else.

use super::super::entry::{BlockEntry, BlockKind, YamlShape, statement};
use super::super::tree::Tree;
use super::{Binding, Block, ControllerDefinition, RoadDefinition, Scenario, Suite, Text};
use super::{CALIBRATE, ESTIMATE, EVALUATE, LET, SCENARIO, SEARCH, STATEMENT, TUNE};
#[cfg(test)]
use super::{Holds, Made};
use super::{Node, Rule, View};

views! {
    File = file {
        uses: [UseFile],
        bindings: [Binding],
        roads: [RoadDefinition],
        controllers: [ControllerDefinition],
        scenarios: [Scenario],
        blocks: [Block],
        suites: [Suite],
    }
    /// `use "path"`
    UseFile = use_file { path: Text }
}

impl Tree {
    /// The whole of it.
    pub fn file(&self) -> File<'_> {
        File(self.root())
    }
}

pub static FILE: BlockEntry = BlockEntry {
    kind: BlockKind::File,
    rule: Rule::file,
    name: "a file",
    heads: &[],
    statements: &[
        statement(
            "use",
            Rule::use_file,
            "use \"../roads/town01.scn\"",
            "Makes the names of another file known.",
        )
        .key("use", YamlShape::Text)
        .repeats(),
        LET.repeats(),
        statement("road", Rule::road_definition, "road NAME { … }", "A road that scenarios can name.")
            .key("roads", YamlShape::Named)
            .opens(BlockKind::Road)
            .names()
            .repeats(),
        statement(
            "controller",
            Rule::controller_definition,
            "controller NAME { … }",
            "A controller of one's own: a program that decides.",
        )
        .key("controllers", YamlShape::Named)
        .opens(BlockKind::Controller)
        .names()
        .repeats(),
        statement(
            "define",
            Rule::define,
            "define NAME(delay = 2 s) { … }` or `define NAME : BASE { … }",
            "A scenario with parameters to build others on.",
        )
        .key("templates", YamlShape::Named)
        .opens(BlockKind::Scenario)
        .names()
        .repeats(),
        SCENARIO.repeats(),
        SEARCH.repeats(),
        TUNE.repeats(),
        EVALUATE.repeats(),
        CALIBRATE.repeats(),
        ESTIMATE.repeats(),
        STATEMENT.repeats(),
        statement("suite", Rule::suite, "suite NAME { … }", "Scenarios that are run together.")
            .key("suite", YamlShape::Named)
            .opens(BlockKind::Suite)
            .repeats(),
    ],
};
