//! Suites and gates.

use super::super::entry::{BlockEntry, BlockKind, YamlShape, statement};
use super::{
    Block, Confidence, Doc, Expect, Expression, Metric, Name, Rate, Rating, Scenario, Seed, Settings, Tags,
    Text,
};
use super::{CALIBRATE, DOC, ESTIMATE, EVALUATE, EXPECT, RATING, SCENARIO, SEARCH, STATEMENT, TAGS, TUNE};
#[cfg(test)]
use super::{Holds, Made};
use super::{Node, Rule, View};

views! {
    /// `suite NAME { … }`
    Suite = suite { name: Name, block: SuiteBlock }
    SuiteBlock = suite_block {
        doc: (Doc),
        files: [SuiteFiles],
        tags: [Tags],
        seed: (Seed),
        time_limit: (TimeLimit),
        tests: [Tested],
        expects: [Expect],
        scenarios: [Scenario],
        blocks: [Block],
        gates: [Gate],
        ratings: [Rating],
    }
    /// `scenarios "pattern", …`
    SuiteFiles = suite_files { patterns: [Text] }
    /// `time_limit 10 s per case`
    TimeLimit = time_limit { value: Expression }
    /// `test my_av { gap: 5 m } as av` or `… as av where present`, and `av=my_av { gap: 5 m }` of the command line.
    Tested = tested | replacement {
        vehicle: TestedVehicle,
        name: Name,
        settings: (Settings),
        where_present: {kw_present},
    }
    TestedVehicle = tested_vehicle { name: Name }
    /// `gate NAME { … }`
    Gate = gate { name: Name, block: GateBlock }
    GateBlock = gate_block {
        doc: (Doc),
        baseline: (Baseline),
        sequential: (Sequential),
        rules: [GateRule],
    }
    /// `sequential`
    Sequential = sequential {}
    Baseline = baseline { path: Text }
    GateRule = gate_rule {
        primary: (Primary),
        none_new: (NoneNew),
        rate: (Rate),
        metric: (Metric),
        tolerance: (GateTolerance),
        confidence: (Confidence),
    }
    /// `primary collision not worse`
    Primary = primary {}
    /// `no new collision`
    NoneNew = none_new { metric: Metric }
    /// `by more than 5 %`
    GateTolerance = gate_tolerance { bound: Expression }
}

impl Tested<'_> {
    /// Whether it is what the command line says, and no statement of a suite.
    pub fn is_of_command_line(self) -> bool {
        self.rule() == Rule::replacement
    }
}

pub static SUITE: BlockEntry = BlockEntry {
    kind: BlockKind::Suite,
    rule: Rule::suite_block,
    name: "a `suite`",
    heads: &[DOC],
    statements: &[
        TAGS.repeats(),
        statement(
            "scenarios",
            Rule::suite_files,
            "scenarios \"../scenarios/zebra/*.scn\"",
            "Files whose scenarios belong to the suite.",
        )
        .key("files", YamlShape::Text)
        .repeats(),
        statement("seed", Rule::seed, "seed 20261121", "What all randomness is derived from.")
            .key("seed", YamlShape::Words),
        statement("time_limit", Rule::time_limit, "time_limit 10 s per case", "Wall-clock limit.")
            .key("time_limit", YamlShape::Words),
        statement(
            "test",
            Rule::tested,
            "test carla_behavior { braking_distance: 8 m } as av` or `test carla_behavior as av where present",
            "The controller of every vehicle of this name, instead of the one that its scenario names. Every scenario has such a vehicle unless it says `where present`.",
        )
        .key("test", YamlShape::Tested)
        .repeats(),
        EXPECT.repeats(),
        SCENARIO.repeats(),
        SEARCH.repeats(),
        TUNE.repeats(),
        EVALUATE.repeats(),
        CALIBRATE.repeats(),
        ESTIMATE.repeats(),
        STATEMENT.repeats(),
        statement(
            "gate",
            Rule::gate,
            "gate braking { baseline \"zebra.json\"; no metric worse by more than 5 % with 95 % confidence }",
            "What may not get worse than a baseline.",
        )
        .key("gates", YamlShape::Named)
        .opens(BlockKind::Gate)
        .repeats(),
        RATING.repeats(),
    ],
};

pub static GATE: BlockEntry = BlockEntry {
    kind: BlockKind::Gate,
    rule: Rule::gate_block,
    name: "a `gate`",
    heads: &[DOC],
    statements: &[
        statement("baseline", Rule::baseline, "baseline \"zebra.json\"", "The file to compare with.")
            .key("baseline", YamlShape::Text)
            .needed("baseline", "baseline \"zebra.json\""),
        statement(
            "sequential",
            Rule::sequential,
            "sequential",
            "Judged while runs come in, too: what got worse beyond doubt ends the suite.",
        )
        .key("sequential", YamlShape::Flag),
        statement(
            "",
            Rule::gate_rule,
            "no metric worse by more than 5 % with 95 % confidence` or `pet not worse by more than 0.2 s` or `rate(pet < 1.5 s) not worse by more than 2 %` or `primary collision not worse",
            "What may not get worse.",
        )
        .key("rules", YamlShape::Statements)
        .repeats(),
    ],
};
