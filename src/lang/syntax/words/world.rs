//! The statements of files, roads, scenarios and road users.

use super::super::tree::Rule;
use super::{BlockEntry, BlockKind, StatementEntry, YamlShape, statement};

/// What a block is about, in quotes at its beginning.
pub(super) const DOC: StatementEntry =
    statement("", Rule::doc, "\"What it is about.\"", "What it is about.").key("doc", YamlShape::Text);
const EXTENDS: StatementEntry = statement(
    "",
    Rule::base,
    ": BASE(delay: 2 s)",
    "The scenario or template that it builds on, with arguments: `base(delay: 2 s)`.",
)
.key("extends", YamlShape::Base);
const PARAMETERS: StatementEntry =
    statement("", Rule::parameters, "(delay = 2 s)", "The parameters of a template with their defaults.")
        .key("parameters", YamlShape::Parameters);
pub(super) const LET: StatementEntry =
    statement("let", Rule::binding, "let pace = 1.4 m/s", "Gives a value a name.")
        .key("let", YamlShape::Bindings)
        .names();
pub(super) const SCENARIO: StatementEntry = statement(
    "scenario",
    Rule::scenario,
    "scenario NAME { … }` or `scenario NAME : BASE { … }",
    "A situation to simulate, possibly built on another.",
)
.key("scenarios", YamlShape::Named)
.opens(BlockKind::Scenario)
.names();
pub(super) const SEARCH: StatementEntry = statement(
    "search",
    Rule::search,
    "search NAME { … }",
    "Looks for the values at which a metric is worst.",
)
.key("searches", YamlShape::Named)
.opens(BlockKind::Search)
.names();
pub(super) const TUNE: StatementEntry =
    statement("tune", Rule::tune, "tune NAME { … }", "Looks for the best controller parameters.")
        .key("tunes", YamlShape::Named)
        .opens(BlockKind::Tune)
        .names();
pub(super) const EVALUATE: StatementEntry = statement(
    "evaluate",
    Rule::evaluate,
    "evaluate NAME { … }",
    "Compares parameter sets on the same cases.",
)
.key("evaluates", YamlShape::Named)
.opens(BlockKind::Evaluate)
.names();
pub(super) const STATEMENT: StatementEntry = statement(
    "statement",
    Rule::statement,
    "statement NAME { … }",
    "What a source says, held against the results.",
)
.key("statements", YamlShape::Named)
.opens(BlockKind::Statement)
.names();
pub(super) const TAGS: StatementEntry =
    statement("tags", Rule::tags, "tags paper, zebra", "Words to select scenarios by.")
        .key("tags", YamlShape::Commas);
pub(super) const REPEAT: StatementEntry =
    statement("repeat", Rule::repeat, "repeat 4", "How often everything is run, with different seeds.")
        .key("repeat", YamlShape::Words);
pub(super) const EXPECT: StatementEntry =
    statement("expect", Rule::expect, "expect { no collision }", "Criteria that runs must meet.")
        .key("expect", YamlShape::Statements)
        .opens(BlockKind::Expect);
pub(super) const SIZE: StatementEntry =
    statement("size", Rule::size, "size 4.5 m x 1.8 m", "Length and width of the footprint.")
        .key("size", YamlShape::Words);
pub(super) const INDIVIDUALS: StatementEntry = statement(
    "individuals",
    Rule::individuals,
    "individuals 5 of standard",
    "Takes parameters from people of a population.",
)
.key("individuals", YamlShape::Words);
pub(super) const INDIVIDUAL: StatementEntry = statement(
    "individual",
    Rule::individual,
    "individual 17 of standard",
    "Takes the parameters of one person of a population.",
)
.key("individual", YamlShape::Words);

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
        STATEMENT.repeats(),
        statement("suite", Rule::suite, "suite NAME { … }", "Scenarios that are run together.")
            .key("suite", YamlShape::Named)
            .opens(BlockKind::Suite)
            .repeats(),
    ],
};

pub static ROAD: BlockEntry = BlockEntry {
    kind: BlockKind::Road,
    rule: Rule::road_block,
    name: "a `road`",
    heads: &[],
    statements: &[
        statement(
            "lanes",
            Rule::lanes,
            "lanes forward, backward",
            "The lanes from the near side to the far side, or their number.",
        )
        .key("lanes", YamlShape::Commas),
        statement("lane_width", Rule::lane_width, "lane_width 3.5 m", "Width of every lane.")
            .key("lane_width", YamlShape::Words)
            .needed("lane width", "lane_width 3.5 m"),
        statement("speed_limit", Rule::speed_limit, "speed_limit 30 km/h", "The speed limit.")
            .key("speed_limit", YamlShape::Words)
            .needed("speed limit", "speed_limit 30 km/h"),
        statement("no kerbs", Rule::no_kerbs, "no kerbs", "Carriageway and pavement are on one level.")
            .key("kerbs", YamlShape::NotFlag),
        statement(
            "crossing",
            Rule::crossing,
            "crossing zebra { width: 4 m }",
            "`zebra`, `unmarked` or `signalised`; its middle is the origin of all places.",
        )
        .key("crossing", YamlShape::Model)
        .needed("crossing", "crossing zebra { width: 4 m }"),
        statement(
            "box",
            Rule::obstacle,
            "box van { along: -12 m, across: -2.5 m, length: 5 m, width: 2 m }",
            "Something that blocks the view and the way.",
        )
        .key("boxes", YamlShape::NamedSettings)
        .repeats(),
        statement(
            "parked",
            Rule::obstacle,
            "parked car { along: -12 m, across: -2.5 m, length: 4.5 m, width: 1.8 m }",
            "A parked vehicle, which blocks the view and the way.",
        )
        .key("parked", YamlShape::NamedSettings)
        .repeats(),
    ],
};

pub static SCENARIO_BLOCK: BlockEntry = BlockEntry { kind: BlockKind::Scenario, rule: Rule::scenario_block, name: "a `scenario`", heads: &[DOC, EXTENDS, PARAMETERS], statements: &[
TAGS.repeats(),
statement("road", Rule::road_choice, "road NAME` or `road { … }", "Where it happens.").key("road", YamlShape::NameOrBlock).opens(BlockKind::Road).needed("road", "road NAME` or `road { … }"),
LET.repeats(),
statement("vehicle", Rule::vehicle, "vehicle NAME { … }", "A vehicle with its controller.").key("vehicles", YamlShape::Named).opens(BlockKind::Vehicle).names().repeats(),
statement("pedestrian", Rule::pedestrian, "pedestrian NAME { … }", "A pedestrian with its model.").key("pedestrians", YamlShape::Named).opens(BlockKind::Pedestrian).names().repeats(),
statement("vary", Rule::vary, "vary tta in [6 s, 10 s]`, `vary tta in 6 s .. 18 s step 4 s` or `vary tta in uniform(6 s, 18 s) 100 times", "A name that takes several values; every combination of all `vary` lines is run.").key("vary", YamlShape::Values).names().repeats(),
statement("vary together", Rule::vary_together, "vary together { a in [1 s, 2 s]; b in [3 m, 4 m] }", "Names whose values go together.").key("vary_together", YamlShape::Together).opens(BlockKind::Together).names().repeats(),
REPEAT.set_instead_of(Rule::runs, "repeat "),
statement("runs", Rule::runs, "runs 50 .. 2000", "Runs are added until every criterion with confidence is decided; at least and at most so many.").key("runs", YamlShape::Words),
statement("seed", Rule::seed, "seed 417", "The seed of the first run of each trial itself, whatever the suite's seed; others follow from it.").key("seed", YamlShape::Words).set("seed ", ""),
statement("step", Rule::step, "step 25 ms", "The simulation step.").key("step", YamlShape::Words).set("step ", ""),
statement("horizon", Rule::horizon, "horizon 60 s", "Simulated time after which a run ends.").key("horizon", YamlShape::Words).set("horizon ", ""),
statement("finish", Rule::finish, "finish 100 m", "Distance of the finish line behind the crossing.").key("finish", YamlShape::Words).set("finish ", ""),
statement("end on collision", Rule::end_on_collision, "end on collision", "Ends a run at a collision.").key("end_on_collision", YamlShape::Flag),
EXPECT.repeats(),
]};

pub static VEHICLE: BlockEntry = BlockEntry {
    kind: BlockKind::Vehicle,
    rule: Rule::vehicle_block,
    name: "a `vehicle`",
    heads: &[],
    statements: &[
        statement(
            "controller",
            Rule::controller,
            "controller carla_behavior { profile: normal }",
            "What drives it, with settings.",
        )
        .key("controller", YamlShape::Model)
        .needed("controller", "controller carla_behavior")
        .set_where_said(),
        statement(
            "dynamics",
            Rule::dynamics,
            "dynamics prius",
            "How it answers to the controller's commands.",
        )
        .key("dynamics", YamlShape::Model)
        .set_where_said(),
        statement(
            "sees",
            Rule::sees,
            "sees { range: 60 m }",
            "What its controller perceives; without it, everything.",
        )
        .key("sees", YamlShape::Settings),
        SIZE.set("size ", ""),
        statement("speed", Rule::speed, "speed 30 km/h", "The steady cruise that it starts in.")
            .key("speed", YamlShape::Words)
            .needed("speed", "speed 30 km/h")
            .set("speed ", ""),
        statement("lane", Rule::lane, "lane 0", "Its lane, counted from the near side.")
            .key("lane", YamlShape::Words)
            .set("lane ", ""),
        statement(
            "start",
            Rule::vehicle_start,
            "start 80 m before crossing` or `start 6 s before crossing",
            "Where it starts; without it, as far out as pedestrians need it.",
        )
        .key("start", YamlShape::Words)
        .set("start ", " before crossing"),
    ],
};

pub static PEDESTRIAN: BlockEntry = BlockEntry {
    kind: BlockKind::Pedestrian,
    rule: Rule::pedestrian_block,
    name: "a `pedestrian`",
    heads: &[],
    statements: &[
        statement(
            "model",
            Rule::model,
            "model scripted { speed: 1.4 m/s }",
            "How it behaves, with settings.",
        )
        .key("model", YamlShape::Model)
        .needed("model", "model carla_walker")
        .set_where_said(),
        INDIVIDUALS,
        INDIVIDUAL,
        SIZE.set_instead_of(Rule::radius, "size "),
        statement("radius", Rule::radius, "radius 0.25 m", "Radius of a round footprint.")
            .key("radius", YamlShape::Words)
            .set_instead_of(Rule::size, "radius "),
        statement("from", Rule::side, "from far side", "The side of the road that it comes from.")
            .key("from", YamlShape::Words),
        statement(
            "start",
            Rule::pedestrian_start,
            "start 2 m from kerb` or `start 4 m from lane centre",
            "Where it stands at first.",
        )
        .key("start", YamlShape::Words)
        .needed("start", "start 2 m from kerb")
        .set_where_said(),
        statement(
            "along",
            Rule::along,
            "along 1 m",
            "Its place along the road; 0 is the middle of the crossing.",
        )
        .key("along", YamlShape::Words)
        .set("along ", ""),
        statement(
            "goal",
            Rule::goal,
            "goal 2 m beyond kerb",
            "Where it wants to go, beyond the opposite kerb.",
        )
        .key("goal", YamlShape::Words)
        .set("goal ", " beyond kerb"),
        statement(
            "appears",
            Rule::appears,
            "appears at 2 s` or `appears when time_to_arrival(av) = 6 s",
            "When it enters the world.",
        )
        .key("appears", YamlShape::Words)
        .set_where_said(),
    ],
};

pub static EXPECT_BLOCK: BlockEntry = BlockEntry {
    kind: BlockKind::Expect,
    rule: Rule::expect_block,
    name: "`expect`",
    heads: &[],
    statements: &[statement(
        "",
        Rule::criterion,
        "no collision`, `pet >= 1.5 s in 80 % of runs` or `mean(time_lost) <= 3 s",
        "A criterion.",
    )
    .repeats()],
};

pub static TOGETHER: BlockEntry = BlockEntry {
    kind: BlockKind::Together,
    rule: Rule::together_block,
    name: "`vary together`",
    heads: &[],
    statements: &[
        statement("", Rule::varied, "tta in [6 s, 10 s]", "One of the names that vary together.").repeats()
    ],
};
