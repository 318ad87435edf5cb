//! The statements of suites, gates, searches, tunes, evaluates and statements.

use super::super::tree::Rule;
use super::world::{
    DOC, EVALUATE, EXPECT, INDIVIDUAL, INDIVIDUALS, REPEAT, SCENARIO, SEARCH, STATEMENT, TAGS, TUNE,
};
use super::{BlockEntry, BlockKind, StatementEntry, YamlShape, statement};

const SOURCE: StatementEntry =
    statement("source", Rule::source, "source \"Wang et al., Table 1\"", "Where reported numbers come from.")
        .key("source", YamlShape::Text);

const FRESH_SEEDS: StatementEntry = statement(
    "repeat",
    Rule::fresh_seeds,
    "repeat 20 with fresh seeds",
    "Runs every case this often, none with the seed it was found with.",
)
.key("repeat", YamlShape::Words);

const ON: StatementEntry = statement("on", Rule::on_cases, "on low_pet`, `on all of low_pet`, `on 50 of zebra_walk`, `on as many of zebra_walk as low_pet` or `on \"cases.json\"", "The cases: what a search kept, the best case of everybody, a scenario, some of its cases, or a saved set.").key("on", YamlShape::Cases);

const BUDGET: StatementEntry = statement(
    "budget",
    Rule::budget,
    "budget 60 evaluations, 15 random first",
    "How many evaluations, how many of them to begin with, and by which method.",
)
.key("budget", YamlShape::Words);

const OVER: StatementEntry = statement(
    "over",
    Rule::over,
    "over tta in 6 s .. 18 s",
    "What is searched: a variation, or a parameter such as `av.controller.braking_distance`.",
)
.key("over", YamlShape::Values);

const MAXIMISE: StatementEntry =
    statement("maximise", Rule::objective, "maximise rate(gap_accepted)", "What is to be large.")
        .key("maximise", YamlShape::Words);

const MINIMISE: StatementEntry =
    statement("minimise", Rule::objective, "minimise mean(time_lost)", "What is to be small.")
        .key("minimise", YamlShape::Words);

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
        EXPECT.repeats(),
        SCENARIO.repeats(),
        SEARCH.repeats(),
        TUNE.repeats(),
        EVALUATE.repeats(),
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
            "",
            Rule::gate_rule,
            "no metric worse by more than 5 % with 95 % confidence` or `pet not worse by more than 0.2 s",
            "What may not get worse.",
        )
        .key("rules", YamlShape::Statements)
        .repeats(),
    ],
};

pub static SEARCH_BLOCK: BlockEntry = BlockEntry {
    kind: BlockKind::Search,
    rule: Rule::search_block,
    name: "a `search`",
    heads: &[DOC],
    statements: &[
        statement("in", Rule::search_in, "in zebra_walk", "The scenario that is searched.")
            .key("in", YamlShape::Words)
            .needed("scenario", "in SCENARIO"),
        INDIVIDUALS,
        INDIVIDUAL,
        statement(
            "together",
            Rule::together,
            "together",
            "One search over all individuals instead of one for each.",
        )
        .key("together", YamlShape::Flag),
        MINIMISE.needed("objective", "minimise pet"),
        MAXIMISE,
        OVER.needed("range", "over tta in 6 s .. 18 s").repeats(),
        BUDGET.needed("budget", "budget 60 evaluations, 15 random first"),
        REPEAT,
        statement(
            "keep",
            Rule::keep,
            "keep pet < 1.5 s",
            "Which of the worst cases belong to the set that the search makes.",
        )
        .key("keep", YamlShape::Words),
    ],
};

pub static TUNE_BLOCK: BlockEntry = BlockEntry {
    kind: BlockKind::Tune,
    rule: Rule::tune_block,
    name: "a `tune`",
    heads: &[DOC],
    statements: &[
        ON.needed("cases", "on SCENARIO"),
        OVER.needed("range", "over tta in 6 s .. 18 s").repeats(),
        MINIMISE.needed("objective", "minimise mean(time_lost)").repeats(),
        MAXIMISE.repeats(),
        statement(
            "subject to",
            Rule::constraints,
            "subject to pet >= 1.5 s, no collision",
            "What must hold in every run.",
        )
        .key("subject_to", YamlShape::Commas)
        .repeats(),
        BUDGET.needed("budget", "budget 60 evaluations, 15 random first"),
        FRESH_SEEDS,
        statement(
            "stop early",
            Rule::stop_early,
            "stop early",
            "Gives a candidate up at its first violation.",
        )
        .key("stop_early", YamlShape::Flag),
        statement(
            "otherwise",
            Rule::otherwise,
            "otherwise fewest violations",
            "Where no candidate keeps every constraint, takes the one that breaks them in the fewest runs.",
        )
        .key("otherwise", YamlShape::Words),
        statement(
            "compare with default",
            Rule::compare,
            "compare with default",
            "Adds a table of before and after.",
        )
        .key("compare_with_default", YamlShape::Flag),
    ],
};

pub static EVALUATE_BLOCK: BlockEntry = BlockEntry { kind: BlockKind::Evaluate, rule: Rule::evaluate_block, name: "an `evaluate`", heads: &[DOC], statements: &[
ON.needed("cases", "on SCENARIO"),
statement("with", Rule::conditions, "with default, braking, \"tuned.json\" as saved, { av.controller.braking_distance: 10 m } as ten", "The conditions: what is declared, what a tune chose, another scenario, a saved set or parameters in place; \
                 the first is what the others are compared with.").key("with", YamlShape::Conditions).needed("conditions", "with default, TUNE"),
FRESH_SEEDS,
statement("measure", Rule::measures, "measure mean(pet), rate(collision)", "The columns of the table.").key("measure", YamlShape::Commas),
SOURCE,
statement("reported", Rule::reported_row, "reported default: 2.5 s, 3 %", "What a source has for a condition, a value for each measure.").key("reported", YamlShape::Rows).repeats(),
]};

pub static STATEMENT_BLOCK: BlockEntry = BlockEntry {
    kind: BlockKind::Statement,
    rule: Rule::statement_block,
    name: "a `statement`",
    heads: &[DOC],
    statements: &[
        SOURCE,
        statement(
            "reported",
            Rule::reported,
            "reported \"about 10 % at 6 s\"",
            "The numbers of the source, in words.",
        )
        .key("reported", YamlShape::Text),
        statement(
            "claim",
            Rule::claim,
            "claim mean(pet) of low_pet < 1.5 s`, `claim rate(gap_accepted) of zebra_walk rises with tta` or \
                 `claim mean(pet) of final.tuned > mean(pet) of final.default",
            "What must hold in the results for the statement to be reproduced.",
        )
        .key("claims", YamlShape::Lines)
        .repeats(),
        statement(
            "differs",
            Rule::differs,
            "differs \"the reason\"",
            "It is known not to be reproduced, for this reason.",
        )
        .key("differs", YamlShape::Text),
        statement(
            "not comparable",
            Rule::not_comparable,
            "not comparable \"the reason\"",
            "It cannot be compared, for this reason.",
        )
        .key("not_comparable", YamlShape::Text),
    ],
};
