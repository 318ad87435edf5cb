//! Files, roads, scenarios and what they vary.

use super::super::tree::Tree;
use super::{
    Block, ControllerDefinition, Evaluate, Expect, Expression, Integer, List, Name, Pedestrian, Search,
    Settings, Statement, Suite, Text, Tune, Vehicle,
};
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
    /// `let NAME = VALUE`
    Binding = binding { name: Name, value: Expression }
    /// `road NAME { … }`
    RoadDefinition = road_definition { name: Name, block: RoadBlock }
    RoadBlock = road_block {
        lanes: (Lanes),
        lane_width: (LaneWidth),
        speed_limit: (SpeedLimit),
        no_kerbs: (NoKerbs),
        crossing: (Crossing),
        obstacles: [Obstacle],
    }
    /// `lanes forward, backward` or `lanes 2`
    Lanes = lanes { directions: [Direction], number: (Expression) }
    Direction = direction { is_backward: {kw_backward} }
    LaneWidth = lane_width { value: Expression }
    SpeedLimit = speed_limit { value: Expression }
    /// `no kerbs`
    NoKerbs = no_kerbs {}
    /// `crossing zebra { … }`
    Crossing = crossing { is_zebra: {kw_zebra}, is_unmarked: {kw_unmarked}, settings: (Settings) }
    /// `box NAME { … }` or `parked NAME { … }`
    Obstacle = obstacle { name: Name, settings: Settings }
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
    Doc = doc { quoted: Text }
    Tags = tags { each: [Tag] }
    Tag = tag {}
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
    /// `6 s .. 18 s step 4 s`
    Range = range { bounds: [Expression] }
    /// `uniform(6 s, 18 s)`
    Distribution = distribution { name: DistributionName, values: [Expression] }
    DistributionName = distribution_name {}
    /// `100 times by sobol`
    Sampling = sampling { count: Integer, by_latin_hypercube: {kw_latin_hypercube}, by_sobol: {kw_sobol} }
    Repeat = repeat { count: Integer }
    /// `runs 50 .. 2000`
    Runs = runs { ends: [Integer] }
    Seed = seed { number: Integer }
    Step = step { value: Expression }
    Horizon = horizon { value: Expression }
    Finish = finish { value: Expression }
    EndOnCollision = end_on_collision {}
}

choices! {
    /// What gives names to a whole file.
    Defining = Binding | RoadDefinition | ControllerDefinition | Scenario | Search | Tune | Evaluate | Statement;
    /// What gives a name that is known in a scenario only, or in its file.
    Local = Binding | Parameter | Pedestrian | Varied | Vehicle;
    /// What scenarios stand in, themselves included.
    HoldsScenarios = Scenario | Suite;
    Variation = Varied | VaryTogether;
    /// Two ways to say how many runs there are.
    RunCount = Repeat | Runs;
}

impl Tree {
    /// The whole of it.
    pub fn file(&self) -> File<'_> {
        File(self.root())
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
