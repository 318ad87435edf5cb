//! Vehicles and pedestrians.

use super::super::entry::{BlockEntry, BlockKind, StatementEntry, YamlShape, statement};
use super::{Distribution, Expression, Integer, Name, Settings, Text};
#[cfg(test)]
use super::{Holds, Made};
use super::{Node, Rule, View};

views! {
    /// `vehicle NAME { … }`, or of vehicles that come one after the other `stream NAME { … }`
    Vehicle = vehicle | stream { is_stream: {kw_stream}, name: Name, block: VehicleBlock }
    VehicleBlock = vehicle_block | stream_block {
        repeats: (Repeats),
        first: (FirstArrival),
        gaps: (Gaps),
        controller: (Controller),
        dynamics: (Dynamics),
        sees: (Sees),
        size: (Size),
        speed: (Speed),
        on: (OnRoad),
        lane: (Lane),
        start: (VehicleStart),
        follows: (Follows),
        signals: (SignalRule),
        obeys: (Obeys),
        ignores: (Ignores),
        ignores_vehicles: (IgnoresVehicles),
    }
    /// `repeats cars` or `repeats cars, 1.5 s later`
    Repeats = repeats { name: Name, later: (Later) }
    Later = later { time: Expression }
    /// `first 2 s before crossing`
    FirstArrival = first_arrival { time: Expression }
    /// `gaps 3 s, 3 s, 4 s, then 2.5 s`, `gaps from "gaps.csv"` or `gaps drawn from uniform(2 s, 8 s)`
    Gaps = gaps { file: (Text), listed: [Gap], then: (GapsThen), drawn: (GapsDrawn) }
    Gap = gap { time: Expression }
    GapsThen = gaps_then { drawn: (GapsDrawn), time: (Expression) }
    GapsDrawn = gaps_drawn { file: (Text), distribution: (Distribution) }
    Controller = controller { name: Name, settings: (Settings) }
    Dynamics = dynamics { name: Name, settings: (Settings) }
    Sees = sees { settings: Settings }
    /// `size LENGTH x WIDTH`
    Size = size { extents: [Expression] }
    /// `speed 36 km/h` or `speed 36 km/h from 0 km/h`
    Speed = speed { value: Expression, initial: (InitialSpeed) }
    InitialSpeed = initial_speed { value: Expression }
    /// `on side`
    OnRoad = on_road { name: Name }
    Lane = lane { value: Expression }
    /// `start 80 m before crossing` or `start 40 m before junction`
    VehicleStart = vehicle_start { value: Expression, is_before_junction: {kw_junction} }
    /// `follows by rear axle` or `follows by rear axle 1.3 m behind centre`
    Follows = follows { behind: (Expression) }
    /// `pedestrian NAME { … }`, `pedestrian NAME times 5 { … }`, and the same of a `cyclist` or an `escooter`
    Pedestrian = pedestrian { is_cyclist: {kw_cyclist}, is_escooter: {kw_escooter}, name: Name, group: (GroupSize), block: PedestrianBlock }
    /// `times 5`
    GroupSize = group_size { number: Integer }
    PedestrianBlock = pedestrian_block {
        model: (Model),
        people: [Individuals],
        shape: (Shape),
        size: (Size),
        radius: (Radius),
        start: (PedestrianStart),
        side: (Side),
        along: (Along),
        goal: (Goal),
        turned: (Turned),
        walks: (Walks),
        crosses: (Crosses),
        waits: (Waits),
        appearance: (Appearance),
        appears: (Appears),
        meets: (Meets),
        looks: (Looks),
        may_go: (MayGo),
        may_start_inside: (MayStartInside),
        permission: (Permission),
        reference: (ReferencePoint),
        signals: (SignalRule),
        obeys: (Obeys),
        ignores: (Ignores),
    }
    Model = model { name: Name, settings: (Settings) }
    /// `individuals 5 of standard`, `individuals all of standard`, `individuals drawn from standard` or `individual 17 of standard`
    Individuals = individuals | individual {
        is_one: {kw_individual},
        are_all: {kw_all},
        are_drawn: {kw_drawn},
        number: (Integer),
        population: Population,
    }
    Population = population { path: (Text), name: (Name) }
    Radius = radius { value: Expression }
    PedestrianStart = pedestrian_start { distances: [StartDistance] }
    /// `2 m from kerb`
    StartDistance = start_distance { value: Expression, is_from_kerb: {kw_kerb} }
    /// `from far side`
    Side = side { is_far: {kw_far} }
    Along = along { value: Expression }
    /// `goal 2 m beyond kerb`, or `goal 40 m further` of who walks along a lane
    Goal = goal { value: Expression, is_further: {kw_further} }
    /// `turned 12 deg left`
    Turned = turned { value: Expression, is_left: {kw_left} }
    /// `walks with traffic`
    Walks = walks { is_against: {kw_against} }
    /// `crosses school`
    Crosses = crosses { name: Name }
    /// `waits on refuge`
    Waits = waits {}
    Appears = appears { at: (AppearsAt), when: (AppearsWhen) }
    AppearsAt = appears_at { time: Expression }
    /// `when time_to_arrival(av.front) = 6 s`
    AppearsWhen = appears_when { vehicle: Name, part: (VehiclePart), time: Expression }
    VehiclePart = vehicle_part { is_front: {kw_front} }
    /// `meets av at 25 %`, or `meets av at 25 % after 11 m` of who walks along a lane
    Meets = meets { vehicle: Name, share: Expression, after: (MetAfter) }
    /// `after 11 m`
    MetAfter = met_after { way: Expression }
    /// `looks for 1 s`
    Looks = looks { time: Expression }
    /// `may go when time_to_arrival(av) = 3 s, or after 8 s`
    MayGo = may_go { when: AppearsWhen, or_after: OrAfter }
    OrAfter = or_after { time: Expression }
    /// `may start inside`
    MayStartInside = may_start_inside {}
    /// `obeys signals`
    Obeys = obeys {}
    /// `ignores signals`
    Ignores = ignores {}
    /// `ignores vehicles`
    IgnoresVehicles = ignores_vehicles {}
    /// `reference 0.06 m behind centre`
    ReferencePoint = reference_point { value: Expression, is_behind: {kw_behind} }
}

choices! {
    RoadUser = Vehicle | Pedestrian;
    Shape = Size | Radius;
    /// What says when a pedestrian enters the world.
    Appearance = Appears | Meets;
    /// What says when a pedestrian that is there may go.
    Permission = Looks | MayGo;
    /// What somebody does about the signal of the crossing.
    SignalRule = Obeys | Ignores;
}

impl VehicleBlock<'_> {
    /// Whether it is that of a stream.
    pub fn is_of_stream(self) -> bool {
        self.rule() == Rule::stream_block
    }
}

impl SignalRule<'_> {
    pub fn is_obeyed(self) -> bool {
        matches!(self, Self::Obeys(_))
    }
}

impl<'t> RoadUser<'t> {
    pub fn name(self) -> Name<'t> {
        match self {
            Self::Vehicle(vehicle) => vehicle.name(),
            Self::Pedestrian(pedestrian) => pedestrian.name(),
        }
    }
}

pub(super) const SIZE: StatementEntry =
    statement("size", Rule::size, "size 4.5 m x 1.8 m", "Length and width of the footprint.")
        .key("size", YamlShape::Words);

pub(super) const INDIVIDUALS: StatementEntry = statement(
    "individuals",
    Rule::individuals,
    "individuals 5 of standard` or `individuals drawn from standard",
    "Takes parameters from people of a population: each of so many in runs of their own, or somebody else in every run.",
)
.key("individuals", YamlShape::Words);

pub(super) const INDIVIDUAL: StatementEntry = statement(
    "individual",
    Rule::individual,
    "individual 17 of standard",
    "Takes the parameters of one person of a population.",
)
.key("individual", YamlShape::Words);

const OBEYS: StatementEntry = statement(
    "obeys",
    Rule::obeys,
    "obeys signals",
    "Stops for the red of a crossing with a signal; most models do where nothing is said.",
)
.key("obeys", YamlShape::Words);

const IGNORES: StatementEntry =
    statement("ignores", Rule::ignores, "ignores signals", "Goes though a signal shows red.")
        .key("ignores", YamlShape::Words);

const CONTROLLER: StatementEntry = statement(
    "controller",
    Rule::controller,
    "controller carla_behavior { profile: normal }",
    "What drives it, with settings.",
)
.key("controller", YamlShape::Model)
.needed("controller", "controller carla_behavior")
.set_where_said();

const DYNAMICS: StatementEntry =
    statement("dynamics", Rule::dynamics, "dynamics prius", "How it answers to the controller's commands.")
        .key("dynamics", YamlShape::Model)
        .set_where_said();

const SEES: StatementEntry = statement(
    "sees",
    Rule::sees,
    "sees { range: 60 m }",
    "What its controller perceives; without it, everything.",
)
.key("sees", YamlShape::Settings);

const SPEED: StatementEntry = statement(
    "speed",
    Rule::speed,
    "speed 30 km/h` or `speed 36 km/h from 0 km/h",
    "The steady cruise, in which it starts unless another speed is said.",
)
.key("speed", YamlShape::Words)
.needed("speed", "speed 30 km/h")
.set("speed ", "");

const LANE: StatementEntry = statement("lane", Rule::lane, "lane 0", "Its lane, counted from the near side.")
    .key("lane", YamlShape::Words)
    .set("lane ", "");

const FOLLOWS: StatementEntry = statement(
    "follows",
    Rule::follows,
    "follows by rear axle` or `follows by rear axle 1.349 m behind centre",
    "Which point of it follows the lane, whose direction it has; its centre if not said, and an axle 0.3 of its length behind that.",
)
.key("follows", YamlShape::Words);

const IGNORES_VEHICLES: StatementEntry = statement(
    "ignores vehicles",
    Rule::ignores_vehicles,
    "ignores vehicles",
    "Says that its controller is meant to look at no vehicles that it is blind to, so that `check` does not warn of it; changes no run.",
)
.key("ignores_vehicles", YamlShape::Flag);

pub static VEHICLE: BlockEntry = BlockEntry {
    kind: BlockKind::Vehicle,
    rule: Rule::vehicle_block,
    name: "a `vehicle`",
    heads: &[],
    statements: &[
        CONTROLLER,
        DYNAMICS,
        SEES,
        SIZE.set("size ", ""),
        SPEED,
        statement(
            "on",
            Rule::on_road,
            "on side",
            "The road that it drives on, which lies over the scenario's; without it, that one.",
        )
        .key("on", YamlShape::Words),
        LANE,
        statement(
            "start",
            Rule::vehicle_start,
            "start 80 m before crossing`, `start 6 s before crossing` or `start 40 m before junction",
            "Where it starts; without it, as far out as pedestrians need it.",
        )
        .key("start", YamlShape::Words)
        .set("start ", " before crossing"),
        FOLLOWS,
        OBEYS,
        IGNORES,
        IGNORES_VEHICLES,
    ],
};

pub static STREAM: BlockEntry = BlockEntry {
    kind: BlockKind::Stream,
    rule: Rule::stream_block,
    name: "a `stream`",
    heads: &[],
    statements: &[
        statement(
            "repeats",
            Rule::repeats,
            "repeats cars` or `repeats cars, 1.5 s later",
            "It is as another stream in all that it does not say itself, and comes so much later.",
        )
        .key("repeats", YamlShape::Words),
        CONTROLLER,
        DYNAMICS,
        SEES,
        SIZE.set("size ", ""),
        SPEED,
        LANE,
        statement(
            "first",
            Rule::first_arrival,
            "first 2 s before crossing",
            "How far its first vehicle is from the middle of the crossing at the start.",
        )
        .key("first", YamlShape::Words)
        .needed("first vehicle", "first 2 s before crossing")
        .set("first ", " before crossing"),
        statement(
            "gaps",
            Rule::gaps,
            "gaps 3 s, 3 s, 4 s, then 2.5 s`, `gaps 2 s, 2 s, then drawn from choice(2.5 s, 3.5 s, 4.5 s)`, `gaps drawn from \"gaps.csv\"` or `gaps from \"gaps.csv\"",
            "The times from front to front of vehicles that follow each other; after `then` until the horizon, drawn anew in every run or all alike, else the stream ends. Of a CSV, its column `gap`: `from` takes its rows in order, `drawn from` any of them.",
        )
        .key("gaps", YamlShape::Words)
        .needed("gaps", "gaps 3 s, 3 s, then 4 s"),
        FOLLOWS,
        OBEYS,
        IGNORES,
        IGNORES_VEHICLES,
    ],
};

/// How many people a block describes: between a pedestrian's name and its braces.
const GROUP_SIZE: StatementEntry = statement(
    "times",
    Rule::group_size,
    "times 5",
    "So many people who are alike but for what `each(…)` gives them.",
)
.key("times", YamlShape::GroupSize);

pub static PEDESTRIAN: BlockEntry = BlockEntry {
    kind: BlockKind::Pedestrian,
    rule: Rule::pedestrian_block,
    name: "a `pedestrian`",
    heads: &[GROUP_SIZE],
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
            "goal 2 m beyond kerb` or `goal 40 m further",
            "Where it wants to go, beyond the opposite kerb; along a lane, how far from its start.",
        )
        .key("goal", YamlShape::Words)
        .set("goal ", " beyond kerb"),
        statement(
            "turned",
            Rule::turned,
            "turned 12 deg left",
            "Its way against straight across the road, about the point where it meets the centre of the first lane.",
        )
        .key("turned", YamlShape::Words)
        .set_where_said(),
        statement(
            "walks",
            Rule::walks,
            "walks with traffic` or `walks against traffic",
            "Along the lane that is outermost on its side, not across the road.",
        )
        .key("walks", YamlShape::Words),
        statement(
            "crosses",
            Rule::crosses,
            "crosses school",
            "The crossing that it uses, from which `along` is measured; the first if not said.",
        )
        .key("crosses", YamlShape::Words),
        statement(
            "waits",
            Rule::waits,
            "waits on refuge",
            "It crosses leg by leg and waits on every refuge of its way; without it, in one go.",
        )
        .key("waits", YamlShape::Words),
        statement(
            "appears",
            Rule::appears,
            "appears at 2 s` or `appears when time_to_arrival(av) = 6 s",
            "When it enters the world.",
        )
        .key("appears", YamlShape::Words)
        .set_where_said(),
        statement(
            "meets",
            Rule::meets,
            "meets av at 25 %` or `meets av at 25 % after 11 m",
            "Appears in time to be hit there, as a share of the vehicle's width from the side that it comes from, if the vehicle keeps its speed; along a lane, after that way.",
        )
        .key("meets", YamlShape::Words)
        .set_where_said(),
        statement(
            "looks",
            Rule::looks,
            "looks for 1 s",
            "It stands and looks for 1 s where it appears, before its first decision; without it, it decides at first sight.",
        )
        .key("looks", YamlShape::Words)
        .set("looks for ", ""),
        statement(
            "may go",
            Rule::may_go,
            "may go when time_to_arrival(av) = 3 s, or after 8 s",
            "It stands and looks until the time to arrival of a vehicle falls to 3 s, for 8 s at most, since a vehicle that stops for it never arrives.",
        )
        .key("may_go", YamlShape::Words),
        statement(
            "may start inside",
            Rule::may_start_inside,
            "may start inside",
            "Says that it may start so near to a lane that its model cannot wait there: a line of the report instead of an error.",
        )
        .key("may_start_inside", YamlShape::Flag),
        statement(
            "reference",
            Rule::reference_point,
            "reference 0.06 m behind centre",
            "The point that it is measured by, seen from the centre of its footprint.",
        )
        .key("reference", YamlShape::Words)
        .set_where_said(),
        OBEYS,
        IGNORES,
    ],
};
