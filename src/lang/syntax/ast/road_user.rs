//! Vehicles and pedestrians.

use super::{
    Argument, Binding, Crossing, Expression, Integer, Name, Obstacle, Parameter, Scenario, Settings, Text,
    Varied, VaryTogether,
};
#[cfg(test)]
use super::{Holds, Made};
use super::{Node, Rule, View};

views! {
    /// `vehicle NAME { … }`
    Vehicle = vehicle { name: Name, block: VehicleBlock }
    VehicleBlock = vehicle_block {
        controller: (Controller),
        dynamics: (Dynamics),
        sees: (Sees),
        size: (Size),
        speed: (Speed),
        lane: (Lane),
        start: (VehicleStart),
    }
    Controller = controller { name: Name, settings: (Settings) }
    Dynamics = dynamics { name: Name, settings: (Settings) }
    Sees = sees { settings: Settings }
    /// `size LENGTH x WIDTH`
    Size = size { extents: [Expression] }
    Speed = speed { value: Expression }
    Lane = lane { value: Expression }
    /// `start 80 m before crossing`
    VehicleStart = vehicle_start { value: Expression }
    /// `pedestrian NAME { … }`
    Pedestrian = pedestrian { name: Name, block: PedestrianBlock }
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
        appears: (Appears),
    }
    Model = model { name: Name, settings: (Settings) }
    /// `individuals 5 of standard`, `individuals all of standard` or `individual 17 of standard`
    Individuals = individuals | individual {
        is_one: {kw_individual},
        are_all: {kw_all},
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
    Goal = goal { value: Expression }
    Appears = appears { at: (AppearsAt), when: (AppearsWhen) }
    AppearsAt = appears_at { time: Expression }
    /// `when time_to_arrival(av.front) = 6 s`
    AppearsWhen = appears_when { vehicle: Name, part: (VehiclePart), time: Expression }
    VehiclePart = vehicle_part { is_front: {kw_front} }
}

choices! {
    RoadUser = Vehicle | Pedestrian;
    Shape = Size | Radius;
    /// A statement that names a registered thing.
    Named = Controller | Dynamics | Model;
    /// A statement of a road user with settings.
    Settled = Named | Sees;
    /// A statement with settings.
    HasSettings = Settled | Crossing | Obstacle;
    /// What takes values from outside.
    Settable = Argument | Binding | Parameter | Pedestrian | Scenario | Varied | VaryTogether | Vehicle;
}

impl<'t> RoadUser<'t> {
    pub fn name(self) -> Name<'t> {
        match self {
            Self::Vehicle(vehicle) => vehicle.name(),
            Self::Pedestrian(pedestrian) => pedestrian.name(),
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
        }
    }

    pub fn settings(self) -> Option<Settings<'t>> {
        match self {
            Self::Controller(controller) => controller.settings(),
            Self::Dynamics(dynamics) => dynamics.settings(),
            Self::Model(model) => model.settings(),
        }
    }
}
