//! Statements of different blocks that have something in common: what names, what is named, what has settings.

use super::{
    Argument, Baseline, Binding, Calibrate, Command, Constraint, Controller, ControllerDefinition, Crossing,
    Direction, Draw, DrawTogether, Dynamics, Estimate, Evaluate, Evaluated, Expression, Fmu, Folder, Matched,
    Measure, Metric, Model, Name, Obstacle, OnCases, OtherCrossing, Parameter, Pedestrian, Population,
    RoadDefinition, Scenario, Search, Sees, Settings, Statement, Suite, SuiteFiles, Tag, Tested, Tune, Turn,
    UseFile, Varied, VaryTogether, Vehicle, Wasm,
};
use super::{Node, Rule, View};

choices! {
    /// What gives names to a whole file.
    Defining = Binding | RoadDefinition | ControllerDefinition | Scenario | Search | Tune | Evaluate | Calibrate | Estimate | Statement;
    /// What scenarios stand in, themselves included.
    HoldsScenarios = Scenario | Suite;
    /// What gives a name that is known in a scenario only, or in its file.
    Local = Binding | Draw | Parameter | Pedestrian | Varied | Vehicle;
    /// A statement that names a registered thing.
    Named = Controller | Dynamics | Model | Tested;
    /// A statement of a road user with settings.
    Settled = Named | Sees;
    /// A statement with settings.
    HasSettings = Settled | AnyCrossing | Obstacle | Turn;
    /// The first crossing of a road or another.
    AnyCrossing = Crossing | OtherCrossing;
    /// What takes values from outside.
    Settable = Argument | Binding | Draw | Parameter | Pedestrian | Scenario | Varied | VaryTogether | Vehicle;
    /// What names a registered thing.
    NamesRegistered = Named | Metric;
    /// What names files of the system, in texts.
    NamesFile = Baseline | Command | Draw | DrawTogether | Evaluated | Fmu | Folder | Matched | OnCases | Population | SuiteFiles | UseFile | Wasm;
    /// What stands between the commas of a statement.
    Listed = Tag | Direction | Constraint | Expression | Measure;
}

impl<'t> AnyCrossing<'t> {
    pub fn is_zebra(self) -> bool {
        match self {
            Self::Crossing(crossing) => crossing.is_zebra(),
            Self::OtherCrossing(crossing) => crossing.is_zebra(),
        }
    }

    pub fn is_unmarked(self) -> bool {
        match self {
            Self::Crossing(crossing) => crossing.is_unmarked(),
            Self::OtherCrossing(crossing) => crossing.is_unmarked(),
        }
    }

    pub fn settings(self) -> Option<Settings<'t>> {
        match self {
            Self::Crossing(crossing) => crossing.settings(),
            Self::OtherCrossing(crossing) => crossing.settings(),
        }
    }
}

impl<'t> Settled<'t> {
    pub fn settings(self) -> Option<Settings<'t>> {
        match self {
            Self::Named(named) => named.settings(),
            Self::Sees(sees) => Some(sees.settings()),
        }
    }
}

impl<'t> Named<'t> {
    pub fn name(self) -> Name<'t> {
        match self {
            Self::Controller(controller) => controller.name(),
            Self::Dynamics(dynamics) => dynamics.name(),
            Self::Model(model) => model.name(),
            Self::Tested(tested) => tested.name(),
        }
    }

    pub fn settings(self) -> Option<Settings<'t>> {
        match self {
            Self::Controller(controller) => controller.settings(),
            Self::Dynamics(dynamics) => dynamics.settings(),
            Self::Model(model) => model.settings(),
            Self::Tested(tested) => tested.settings(),
        }
    }
}
