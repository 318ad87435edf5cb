//! Files, roads, scenarios and what they vary.

use super::super::entry::{BlockEntry, BlockKind, StatementEntry, YamlShape, statement};
use super::{
    DOC, Doc, EXPECT, Expect, Expression, Integer, List, Name, Pedestrian, REPEAT, Repeat, Seed, Settings,
    TAGS, Tags, Text, Vehicle,
};
#[cfg(test)]
use super::{Holds, Made};
use super::{Node, Rule, View};

views! {
    /// `let NAME = VALUE`
    Binding = binding { name: Name, value: Expression }
    /// `road NAME { … }`
    RoadDefinition = road_definition { name: Name, block: RoadBlock }
    RoadBlock = road_block {
        over: (LiesOver),
        path: (RoadPath),
        lanes: (Lanes),
        lane_width: (LaneWidth),
        speed_limit: (SpeedLimit),
        gradient: (Gradient),
        friction: (Friction),
        no_kerbs: (NoKerbs),
        medians: [RoadMedian],
        crossing: (Crossing),
        other_crossings: [OtherCrossing],
        obstacles: [Obstacle],
    }
    /// `over main { at: 20 m, angle: 90 deg }`
    LiesOver = lies_over { name: Name, settings: Settings }
    /// `lanes forward, backward` or `lanes 2`
    Lanes = lanes { directions: [Direction], number: (Expression) }
    Direction = direction { is_backward: {kw_backward} }
    LaneWidth = lane_width { value: Expression }
    SpeedLimit = speed_limit { value: Expression }
    Gradient = gradient { value: Expression }
    Friction = friction { value: Expression }
    /// `no kerbs`
    NoKerbs = no_kerbs {}
    /// `path { … }`
    RoadPath = path { block: PathBlock }
    PathBlock = path_block { straights: [Straight], clothoids: [Clothoid], arcs: [Arc], turns: [Turn] }
    /// `straight 100 m`
    Straight = straight { length: Expression }
    /// `clothoid 20 m to radius 30 m left` or `clothoid 20 m to straight`
    Clothoid = clothoid { length: Expression, is_to_straight: {kw_straight}, radius: (BendRadius) }
    /// `arc 60 deg` or `arc 60 deg radius 30 m left`
    Arc = arc { angle: Expression, radius: (BendRadius) }
    /// `turn left { radius: 9 m, clothoid: 20 deg, arc: 50 deg }`
    Turn = turn { is_left: {kw_left}, settings: Settings }
    /// `radius 30 m left`
    BendRadius = bend_radius { value: Expression, is_left: {kw_left} }
    /// `crossing zebra { … }`
    Crossing = crossing { is_zebra: {kw_zebra}, is_unmarked: {kw_unmarked}, settings: (Settings) }
    /// `crossing NAME zebra { … }`
    OtherCrossing = other_crossing { name: Name, is_zebra: {kw_zebra}, is_unmarked: {kw_unmarked}, settings: (Settings) }
    /// `median 2 m after lane 0 with refuge`
    RoadMedian = median { numbers: [Expression], is_refuge: {kw_refuge} }
    /// `box NAME { … }`, `parked NAME { … }`, `parked_row NAME { … }` or `bus NAME { … }`
    Obstacle = obstacle { is_row: {kw_parked_row}, is_bus: {kw_bus}, name: Name, settings: Settings }
    /// `scenario NAME : BASE { … }` or, with parameters, `define NAME(…) : BASE { … }`
    Scenario = scenario | define {
        name: Name,
        parameters: (Parameters),
        base: (Base),
        block: ScenarioBlock,
        is_template: {kw_define},
    }
    Parameters = parameters { each: [Parameter] }
    /// `NAME = DEFAULT`
    Parameter = parameter { name: Name, default: (Expression) }
    /// `: BASE(…)`
    Base = base { name: Name, arguments: (Arguments) }
    Arguments = arguments { each: [Argument] }
    /// `NAME: VALUE`
    Argument = argument { name: Name, value: Expression }
    ScenarioBlock = scenario_block {
        doc: (Doc),
        tags: [Tags],
        road: (RoadChoice),
        vehicles: [Vehicle],
        pedestrians: [Pedestrian],
        variations: [Variation],
        draws: [Draw],
        tables: [DrawTogether],
        run_count: (RunCount),
        repeat: (Repeat),
        runs: (Runs),
        seed: (Seed),
        step: (Step),
        horizon: (Horizon),
        finish: (Finish),
        end_on_collision: (EndOnCollision),
        expects: [Expect],
        bindings: [Binding],
    }
    /// `road NAME` or `road { … }`
    RoadChoice = road_choice { block: (RoadBlock), name: (Name) }
    /// `vary NAME in …`, or the line of a `vary together` that reads `NAME in …`
    Varied = vary | varied {
        is_alone: {kw_vary},
        name: Name,
        list: (List),
        range: (Range),
        distribution: (Distribution),
        sampling: (Sampling),
    }
    VaryTogether = vary_together { sampling: (Sampling), block: TogetherBlock }
    TogetherBlock = together_block { each: [Varied] }
    /// `draw NAME from normal(5 m, 1 m)` or `draw NAME from "gaps.csv"`
    Draw = draw { name: Name, distribution: (Distribution), file: (Text) }
    /// `draw together from "exposure.csv"` or `draw together from "exposure.csv" without id, date`
    DrawTogether = draw_together { file: Text, left_out: [Name] }
    /// `6 s .. 18 s step 4 s`
    Range = range { bounds: [Expression] }
    /// `uniform(6 s, 18 s)`
    Distribution = distribution { name: DistributionName, values: [Expression], weighted: [WeightedValue] }
    /// `child: 30 %`
    WeightedValue = weighted_value { parts: [Expression] }
    DistributionName = distribution_name {}
    /// `100 times by sobol`
    Sampling = sampling { count: Integer, by_latin_hypercube: {kw_latin_hypercube}, by_sobol: {kw_sobol} }
    /// `runs 50 .. 2000`
    Runs = runs { ends: [Integer] }
    Step = step { value: Expression }
    Horizon = horizon { value: Expression }
    Finish = finish { value: Expression }
    EndOnCollision = end_on_collision {}
}

choices! {
    /// What a path is made of.
    PathPiece = Straight | Clothoid | Arc | Turn;
    Variation = Varied | VaryTogether;
    /// Two ways to say how many runs there are.
    RunCount = Repeat | Runs;
}

impl<'t> PathBlock<'t> {
    /// What the path is made of, in order.
    pub fn pieces(self) -> impl Iterator<Item = PathPiece<'t>> {
        self.parts()
    }
}

impl<'t> Variation<'t> {
    /// The names that it varies.
    pub fn names(self) -> impl Iterator<Item = Name<'t>> {
        let (alone, together) = match self {
            Self::Varied(varied) => (Some(varied), None),
            Self::VaryTogether(several) => (None, Some(several.block().each())),
        };
        alone.into_iter().chain(together.into_iter().flatten()).map(|varied| varied.name())
    }
}

pub(super) const EXTENDS: StatementEntry = statement(
    "",
    Rule::base,
    ": BASE(delay: 2 s)",
    "The scenario or template that it builds on, with arguments: `base(delay: 2 s)`.",
)
.key("extends", YamlShape::Base);

pub(super) const PARAMETERS: StatementEntry =
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

pub static ROAD: BlockEntry = BlockEntry {
    kind: BlockKind::Road,
    rule: Rule::road_block,
    name: "a `road`",
    heads: &[],
    statements: &[
        statement(
            "over",
            Rule::lies_over,
            "over main { at: 20 m, angle: 90 deg }",
            "The road that it lies over, and where and at which angle their lanes 0 meet; vehicles say `on` to drive on it.",
        )
        .key("over", YamlShape::NamedSettings),
        statement(
            "path",
            Rule::path,
            "path { … }",
            "How the centre line of lane 0 runs, piece by piece; a road without it is straight and endless.",
        )
        .key("path", YamlShape::Statements)
        .opens(BlockKind::Path),
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
        statement(
            "gradient",
            Rule::gradient,
            "gradient 5 %",
            "How much the road rises per metre along lane 0, where it rises; level if not said.",
        )
        .key("gradient", YamlShape::Words),
        statement(
            "friction",
            Rule::friction,
            "friction 0.5",
            "The coefficient of friction between tyres and road: no vehicle accelerates or brakes by more than that times g.",
        )
        .key("friction", YamlShape::Words),
        statement("no kerbs", Rule::no_kerbs, "no kerbs", "Carriageway and pavement are on one level.")
            .key("kerbs", YamlShape::NotFlag),
        statement(
            "crossing",
            Rule::crossing,
            "crossing zebra { width: 4 m }",
            "`zebra`, `unmarked` or `signalised`; its middle is the origin of all places, on a `path` so far `at` behind its beginning.",
        )
        .key("crossing", YamlShape::Model)
        .needed("crossing", "crossing zebra { width: 4 m }"),
        statement(
            "crossing",
            Rule::other_crossing,
            "crossing school zebra { width: 3 m, at: 40 m }",
            "Another crossing, so far `at` along the road from the middle of the first, on a `path` from its beginning.",
        )
        .key("crossings", YamlShape::NamedModels)
        .repeats(),
        statement(
            "median",
            Rule::median,
            "median 2 m after lane 0` or `median 2 m after lane 0 with refuge",
            "A strip between two lanes where nobody drives; on a refuge people may wait.",
        )
        .key("medians", YamlShape::Words)
        .repeats(),
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
        statement(
            "parked_row",
            Rule::obstacle,
            "parked_row vans { to: -6 m, cars: 5, gap: 1 m, across: -2.8 m, length: 4.5 m, width: 1.8 m }",
            "Parked vehicles one behind the other, called `vans_1`, `vans_2`, … from the one that ends at `to` backwards.",
        )
        .key("parked_rows", YamlShape::NamedSettings)
        .repeats(),
        statement(
            "bus",
            Rule::obstacle,
            "bus stopped { along: -8 m, across: -3 m }",
            "A bus that stands, which blocks the view and the way; 12 m x 2.55 m if not said.",
        )
        .key("buses", YamlShape::NamedSettings)
        .repeats(),
    ],
};

pub static SCENARIO_BLOCK: BlockEntry = BlockEntry { kind: BlockKind::Scenario, rule: Rule::scenario_block, name: "a `scenario`", heads: &[DOC, EXTENDS, PARAMETERS], statements: &[
TAGS.repeats(),
statement("road", Rule::road_choice, "road NAME` or `road { … }", "Where it happens.").key("road", YamlShape::NameOrBlock).opens(BlockKind::Road).needed("road", "road NAME` or `road { … }"),
LET.repeats(),
statement("vehicle", Rule::vehicle, "vehicle NAME { … }", "A vehicle with its controller.").key("vehicles", YamlShape::Named).opens(BlockKind::Vehicle).names().repeats(),
statement("stream", Rule::stream, "stream NAME { … }", "Vehicles of one lane that come one after the other, with gaps between them.").key("streams", YamlShape::Named).opens(BlockKind::Stream).names().repeats(),
statement("pedestrian", Rule::pedestrian, "pedestrian NAME { … }", "A pedestrian with its model.").key("pedestrians", YamlShape::Named).opens(BlockKind::Pedestrian).names().repeats(),
statement("cyclist", Rule::pedestrian, "cyclist NAME { … }", "Somebody on a bicycle, 1.89 m x 0.5 m if not said, who says what a pedestrian says.").key("cyclists", YamlShape::Named).opens(BlockKind::Pedestrian).names().repeats(),
statement("escooter", Rule::pedestrian, "escooter NAME { … }", "Somebody on an electric scooter, 1.2 m x 0.6 m if not said, who says what a pedestrian says.").key("escooters", YamlShape::Named).opens(BlockKind::Pedestrian).names().repeats(),
statement("vary", Rule::vary, "vary tta in [6 s, 10 s]`, `vary tta in 6 s .. 18 s step 4 s` or `vary tta in uniform(6 s, 18 s) 100 times", "A name that takes several values; every combination of all `vary` lines is run.").key("vary", YamlShape::Values).names().repeats(),
statement("vary together", Rule::vary_together, "vary together { a in [1 s, 2 s]; b in [3 m, 4 m] }", "Names whose values go together.").key("vary_together", YamlShape::Together).opens(BlockKind::Together).names().repeats(),
statement("draw", Rule::draw, "draw NAME from uniform(3 s, 18 s)` or `draw NAME from \"gaps.csv\"", "A name that has another value in every run of a trial, drawn from a distribution or from a column of a file.").key("draw", YamlShape::Drawn).names().repeats(),
statement("draw together from", Rule::draw_together, "draw together from \"exposure.csv\"` or `draw together from \"exposure.csv\" without id, date", "Names that have a row of a file in every run: a column each, with units in its header, and perhaps a column `weight`; all are used but those that are left out.").key("draw_together", YamlShape::Table).repeats(),
REPEAT.set_instead_of(Rule::runs, "repeat "),
statement("runs", Rule::runs, "runs 50 .. 2000", "Runs are added until every criterion with confidence is decided; at least and at most so many.").key("runs", YamlShape::Words),
statement("seed", Rule::seed, "seed 417", "The seed of the first run of each trial itself, whatever the suite's seed; others follow from it.").key("seed", YamlShape::Words).set("seed ", ""),
statement("step", Rule::step, "step 25 ms", "The simulation step.").key("step", YamlShape::Words).set("step ", ""),
statement("horizon", Rule::horizon, "horizon 60 s", "Simulated time after which a run ends.").key("horizon", YamlShape::Words).set("horizon ", ""),
statement("finish", Rule::finish, "finish 100 m", "Distance of the finish line behind the crossing.").key("finish", YamlShape::Words).set("finish ", ""),
statement("end on collision", Rule::end_on_collision, "end on collision", "Ends a run at a collision.").key("end_on_collision", YamlShape::Flag),
EXPECT.repeats(),
]};

pub static PATH: BlockEntry = BlockEntry {
    kind: BlockKind::Path,
    rule: Rule::path_block,
    name: "a `path`",
    heads: &[],
    statements: &[
        statement("straight", Rule::straight, "straight 100 m", "A straight line.").repeats(),
        statement(
            "clothoid",
            Rule::clothoid,
            "clothoid 20 m to radius 30 m left` or `clothoid 20 m to straight",
            "A line whose curvature changes evenly, from that of the piece before it.",
        )
        .repeats(),
        statement(
            "arc",
            Rule::arc,
            "arc 60 deg` or `arc 60 deg radius 30 m left",
            "A part of a circle, about the radius at which the piece before it ends if none is said.",
        )
        .repeats(),
        statement(
            "turn",
            Rule::turn,
            "turn left { radius: 9 m, clothoid: 20.62 deg, arc: 48.76 deg }",
            "A clothoid from a radius of 1500 m, an arc and the clothoid back, as Euro NCAP writes its turns.",
        )
        .repeats(),
    ],
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
