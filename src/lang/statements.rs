//! The statements of every block: what errors, completion and hover say about them.

use super::tree::Rule;

/// A statement by its first word.
#[derive(Debug, Clone, Copy)]
pub struct Statement {
    /// Empty for statements that begin with any name.
    pub word: &'static str,
    pub rule: Rule,
    /// An example.
    pub usage: &'static str,
    /// One line.
    pub doc: &'static str,
}

/// A kind of block with its statements.
#[derive(Debug, Clone, Copy)]
pub struct Block {
    pub rule: Rule,
    /// With an article: "a `vehicle`".
    pub name: &'static str,
    pub statements: &'static [Statement],
}

const fn statement(word: &'static str, rule: Rule, usage: &'static str, doc: &'static str) -> Statement {
    Statement { word, rule, usage, doc }
}

const TAGS: Statement = statement("tags", Rule::tags, "tags paper, zebra", "Words to select scenarios by.");
const EXPECT: Statement =
    statement("expect", Rule::expect, "expect { no collision }", "Criteria that runs must meet.");
const LET: Statement = statement("let", Rule::binding, "let pace = 1.4 m/s", "Gives a value a name.");
const SCENARIO: Statement = statement(
    "scenario",
    Rule::scenario,
    "scenario NAME { … }` or `scenario NAME : BASE { … }",
    "A situation to simulate, possibly built on another.",
);
const SEARCH: Statement = statement(
    "search",
    Rule::search,
    "search NAME { … }",
    "Looks for the values at which a metric is worst.",
);
const TUNE: Statement =
    statement("tune", Rule::tune, "tune NAME { … }", "Looks for the best controller parameters.");
const EVALUATE: Statement = statement(
    "evaluate",
    Rule::evaluate,
    "evaluate NAME { … }",
    "Compares parameter sets on the same cases.",
);
const STATEMENT: Statement = statement(
    "statement",
    Rule::statement,
    "statement NAME { … }",
    "What a source says, held against the results.",
);
const ON: Statement = statement(
    "on",
    Rule::on_cases,
    "on low_pet`, `on all of low_pet`, `on 50 of zebra_walk`, `on as many of zebra_walk as low_pet` or `on \"cases.json\"",
    "The cases: what a search kept, the best case of everybody, a scenario, some of its cases, or a saved set.",
);
const FRESH_SEEDS: Statement = statement(
    "repeat",
    Rule::fresh_seeds,
    "repeat 20 with fresh seeds",
    "Runs every case this often, none with the seed it was found with.",
);
const SOURCE: Statement =
    statement("source", Rule::source, "source \"Wang et al., Table 1\"", "Where reported numbers come from.");
const OVER: Statement = statement(
    "over",
    Rule::over,
    "over tta in 6 s .. 18 s",
    "What is searched: a variation, or a parameter such as `av.controller.braking_distance`.",
);
const BUDGET: Statement = statement(
    "budget",
    Rule::budget,
    "budget 60 evaluations, 15 random first",
    "How many evaluations, how many of them to begin with, and by which method.",
);
const INDIVIDUALS: Statement = statement(
    "individuals",
    Rule::individuals,
    "individuals 5 of standard",
    "Takes parameters from people of a population.",
);
const INDIVIDUAL: Statement = statement(
    "individual",
    Rule::individual,
    "individual 17 of standard",
    "Takes the parameters of one person of a population.",
);
const SIZE: Statement =
    statement("size", Rule::size, "size 4.5 m x 1.8 m", "Length and width of the footprint.");
const MINIMISE: Statement =
    statement("minimise", Rule::objective, "minimise mean(time_lost)", "What is to be small.");
const MAXIMISE: Statement =
    statement("maximise", Rule::objective, "maximise rate(gap_accepted)", "What is to be large.");
const REPEAT: Statement =
    statement("repeat", Rule::repeat, "repeat 4", "How often everything is run, with different seeds.");

/// A setting in braces.
pub const SETTING: Statement = statement(
    "",
    Rule::whole_setting,
    "{ profile: normal, braking_distance: 5 m }",
    "A parameter with its value.",
);

/// A parameter of a road user in braces.
pub const GIVEN: Statement = statement(
    "",
    Rule::whole_given,
    "{ av.controller.braking_distance: 10 m }",
    "A parameter of a road user with its value.",
);

/// Every kind of block there is; the file first.
pub static BLOCKS: &[Block] = &[
    Block {
        rule: Rule::file,
        name: "a file",
        statements: &[
            statement(
                "use",
                Rule::use_file,
                "use \"../roads/town01.scn\"",
                "Makes the names of another file known.",
            ),
            LET,
            statement("road", Rule::road_definition, "road NAME { … }", "A road that scenarios can name."),
            statement(
                "define",
                Rule::define,
                "define NAME(delay = 2 s) { … }` or `define NAME : BASE { … }",
                "A scenario with parameters to build others on.",
            ),
            SCENARIO,
            SEARCH,
            TUNE,
            EVALUATE,
            STATEMENT,
            statement("suite", Rule::suite, "suite NAME { … }", "Scenarios that are run together."),
        ],
    },
    Block {
        rule: Rule::road_block,
        name: "a `road`",
        statements: &[
            statement(
                "lanes",
                Rule::lanes,
                "lanes forward, backward",
                "The lanes from the near side to the far side, or their number.",
            ),
            statement("lane_width", Rule::lane_width, "lane_width 3.5 m", "Width of every lane."),
            statement("speed_limit", Rule::speed_limit, "speed_limit 30 km/h", "The speed limit."),
            statement("no", Rule::no_kerbs, "no kerbs", "Carriageway and pavement are on one level."),
            statement(
                "crossing",
                Rule::crossing,
                "crossing zebra { width: 4 m }",
                "`zebra`, `unmarked` or `signalised`; its middle is the origin of all places.",
            ),
            statement(
                "box",
                Rule::obstacle,
                "box van { along: -12 m, across: -2.5 m, length: 5 m, width: 2 m }",
                "Something that blocks the view and the way.",
            ),
            statement(
                "parked",
                Rule::obstacle,
                "parked car { along: -12 m, across: -2.5 m, length: 4.5 m, width: 1.8 m }",
                "A parked vehicle, which blocks the view and the way.",
            ),
        ],
    },
    Block {
        rule: Rule::scenario_block,
        name: "a `scenario`",
        statements: &[
            TAGS,
            statement("road", Rule::road_choice, "road NAME` or `road { … }", "Where it happens."),
            statement("vehicle", Rule::vehicle, "vehicle NAME { … }", "A vehicle with its controller."),
            statement(
                "pedestrian",
                Rule::pedestrian,
                "pedestrian NAME { … }",
                "A pedestrian with its model.",
            ),
            statement(
                "vary",
                Rule::vary,
                "vary tta in [6 s, 10 s]`, `vary tta in 6 s .. 18 s step 4 s` or `vary tta in uniform(6 s, 18 s) 100 times",
                "A name that takes several values; every combination of all `vary` lines is run.",
            ),
            statement(
                "vary",
                Rule::vary_together,
                "vary together { a in [1 s, 2 s]; b in [3 m, 4 m] }",
                "Names whose values go together.",
            ),
            REPEAT,
            statement(
                "runs",
                Rule::runs,
                "runs 50 .. 2000",
                "Runs are added until every criterion with confidence is decided; at least and at most so many.",
            ),
            statement(
                "seed",
                Rule::seed,
                "seed 417",
                "The seed of the first run of each trial itself, whatever the suite's seed; others follow from it.",
            ),
            statement("step", Rule::step, "step 25 ms", "The simulation step."),
            statement("horizon", Rule::horizon, "horizon 60 s", "Simulated time after which a run ends."),
            statement(
                "finish",
                Rule::finish,
                "finish 100 m",
                "Distance of the finish line behind the crossing.",
            ),
            statement("end", Rule::end_on_collision, "end on collision", "Ends a run at a collision."),
            EXPECT,
            LET,
        ],
    },
    Block {
        rule: Rule::vehicle_block,
        name: "a `vehicle`",
        statements: &[
            statement(
                "controller",
                Rule::controller,
                "controller carla_behavior { profile: normal }",
                "What drives it, with settings.",
            ),
            statement(
                "dynamics",
                Rule::dynamics,
                "dynamics prius",
                "How it answers to the controller's commands.",
            ),
            statement(
                "sees",
                Rule::sees,
                "sees { range: 60 m }",
                "What its controller perceives; without it, everything.",
            ),
            SIZE,
            statement("speed", Rule::speed, "speed 30 km/h", "The steady cruise that it starts in."),
            statement("lane", Rule::lane, "lane 0", "Its lane, counted from the near side."),
            statement(
                "start",
                Rule::vehicle_start,
                "start 80 m before crossing` or `start 6 s before crossing",
                "Where it starts; without it, as far out as pedestrians need it.",
            ),
        ],
    },
    Block {
        rule: Rule::pedestrian_block,
        name: "a `pedestrian`",
        statements: &[
            statement(
                "model",
                Rule::model,
                "model scripted { speed: 1.4 m/s }",
                "How it behaves, with settings.",
            ),
            INDIVIDUALS,
            INDIVIDUAL,
            SIZE,
            statement("radius", Rule::radius, "radius 0.25 m", "Radius of a round footprint."),
            statement(
                "start",
                Rule::pedestrian_start,
                "start 2 m from kerb` or `start 4 m from lane centre",
                "Where it stands at first.",
            ),
            statement("from", Rule::side, "from far side", "The side of the road that it comes from."),
            statement(
                "along",
                Rule::along,
                "along 1 m",
                "Its place along the road; 0 is the middle of the crossing.",
            ),
            statement(
                "goal",
                Rule::goal,
                "goal 2 m beyond kerb",
                "Where it wants to go, beyond the opposite kerb.",
            ),
            statement(
                "appears",
                Rule::appears,
                "appears at 2 s` or `appears when time_to_arrival(av) = 6 s",
                "When it enters the world.",
            ),
        ],
    },
    Block {
        rule: Rule::expect_block,
        name: "`expect`",
        statements: &[statement(
            "",
            Rule::criterion,
            "no collision`, `pet >= 1.5 s in 80 % of runs` or `mean(time_lost) <= 3 s",
            "A criterion.",
        )],
    },
    Block {
        rule: Rule::together_block,
        name: "`vary together`",
        statements: &[statement(
            "",
            Rule::varied,
            "tta in [6 s, 10 s]",
            "One of the names that vary together.",
        )],
    },
    Block {
        rule: Rule::suite_block,
        name: "a `suite`",
        statements: &[
            statement(
                "scenarios",
                Rule::suite_files,
                "scenarios \"../scenarios/zebra/*.scn\"",
                "Files whose scenarios belong to the suite.",
            ),
            TAGS,
            statement("seed", Rule::seed, "seed 20261121", "What all randomness is derived from."),
            statement("time_limit", Rule::time_limit, "time_limit 10 s per case", "Wall-clock limit."),
            EXPECT,
            SCENARIO,
            SEARCH,
            TUNE,
            EVALUATE,
            STATEMENT,
            statement(
                "gate",
                Rule::gate,
                "gate braking { baseline \"zebra.json\"; no metric worse by more than 5 % with 95 % confidence }",
                "What may not get worse than a baseline.",
            ),
        ],
    },
    Block {
        rule: Rule::gate_block,
        name: "a `gate`",
        statements: &[
            statement("baseline", Rule::baseline, "baseline \"zebra.json\"", "The file to compare with."),
            statement(
                "",
                Rule::gate_rule,
                "no metric worse by more than 5 % with 95 % confidence` or `pet not worse by more than 0.2 s",
                "What may not get worse.",
            ),
        ],
    },
    Block {
        rule: Rule::search_block,
        name: "a `search`",
        statements: &[
            statement("in", Rule::search_in, "in zebra_walk", "The scenario that is searched."),
            INDIVIDUALS,
            INDIVIDUAL,
            statement(
                "together",
                Rule::together,
                "together",
                "One search over all individuals instead of one for each.",
            ),
            MINIMISE,
            MAXIMISE,
            OVER,
            BUDGET,
            REPEAT,
            statement(
                "keep",
                Rule::keep,
                "keep pet < 1.5 s",
                "Which of the worst cases belong to the set that the search makes.",
            ),
        ],
    },
    Block {
        rule: Rule::tune_block,
        name: "a `tune`",
        statements: &[
            ON,
            OVER,
            MINIMISE,
            MAXIMISE,
            statement(
                "subject",
                Rule::constraints,
                "subject to pet >= 1.5 s, no collision",
                "What must hold in every run.",
            ),
            BUDGET,
            FRESH_SEEDS,
            statement("stop", Rule::stop_early, "stop early", "Gives a candidate up at its first violation."),
            statement(
                "otherwise",
                Rule::otherwise,
                "otherwise fewest violations",
                "Where no candidate keeps every constraint, takes the one that breaks them in the fewest runs.",
            ),
            statement("compare", Rule::compare, "compare with default", "Adds a table of before and after."),
        ],
    },
    Block {
        rule: Rule::evaluate_block,
        name: "an `evaluate`",
        statements: &[
            ON,
            statement(
                "with",
                Rule::conditions,
                "with default, braking, \"tuned.json\" as saved, { av.controller.braking_distance: 10 m } as ten",
                "The conditions: what is declared, what a tune chose, another scenario, a saved set or parameters in place; \
                 the first is what the others are compared with.",
            ),
            FRESH_SEEDS,
            statement(
                "measure",
                Rule::measures,
                "measure mean(pet), rate(collision)",
                "The columns of the table.",
            ),
            SOURCE,
            statement(
                "reported",
                Rule::reported_row,
                "reported default: 2.5 s, 3 %",
                "What a source has for a condition, a value for each measure.",
            ),
        ],
    },
    Block {
        rule: Rule::statement_block,
        name: "a `statement`",
        statements: &[
            SOURCE,
            statement(
                "reported",
                Rule::reported,
                "reported \"about 10 % at 6 s\"",
                "The numbers of the source, in words.",
            ),
            statement(
                "claim",
                Rule::claim,
                "claim mean(pet) of low_pet < 1.5 s`, `claim rate(gap_accepted) of zebra_walk rises with tta` or \
                 `claim mean(pet) of final.tuned > mean(pet) of final.default",
                "What must hold in the results for the statement to be reproduced.",
            ),
            statement(
                "differs",
                Rule::differs,
                "differs \"the reason\"",
                "It is known not to be reproduced, for this reason.",
            ),
            statement(
                "not",
                Rule::not_comparable,
                "not comparable \"the reason\"",
                "It cannot be compared, for this reason.",
            ),
        ],
    },
];

/// The block of that rule.
pub fn block(rule: Rule) -> &'static Block {
    BLOCKS.iter().find(|block| block.rule == rule).unwrap_or(&BLOCKS[0])
}

/// The blocks that have a statement beginning with the word.
pub fn homes(word: &str) -> Vec<&'static str> {
    let has = |block: &&Block| block.statements.iter().any(|statement| statement.word == word);
    BLOCKS.iter().filter(has).map(|block| block.name).collect()
}

/// The second word of a statement.
pub fn second_word(text: &str) -> &str {
    let rest =
        text.trim_start().trim_start_matches(|c: char| c.is_ascii_alphanumeric() || c == '_').trim_start();
    let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
    &rest[..end]
}
