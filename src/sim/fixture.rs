//! A small world for tests.

use scenario::{
    Appearance, Direction, MayGo, ModelSetup, PedestrianSetup, Position, Reference, Road, Settings, Shape,
    Side, VehicleSetup, VehicleStart, World,
};

/// A 4 m lane, a car of 4 m by 2 m and a person of 0.25 m radius who walks from y = -4 m to 4 m.
pub fn world() -> World {
    World {
        road: Road::zebra(&[Direction::Forward], 10.0),
        other_roads: Vec::new(),
        vehicles: vec![VehicleSetup {
            name: "av".into(),
            controller: nobody(),
            dynamics: nobody(),
            length: 4.0,
            width: 2.0,
            road: 0,
            lane: 0,
            speed: 10.0,
            initial_speed: None,
            start: VehicleStart::Distance(100.0),
            behind: 0.0,
            sees: None,
            obeys_signals: false,
        }],
        pedestrians: vec![PedestrianSetup {
            kind: Default::default(),
            name: "walker".into(),
            model: nobody(),
            shape: Shape::Disc { radius: 0.25 },
            side: Side::Near,
            start: Position { x: 0.0, y: -4.0 },
            goal: Position { x: 0.0, y: 4.0 },
            follows: None,
            stops: Vec::new(),
            crossing: 0,
            appears: Appearance::At(0.0),
            may_go: MayGo::AtOnce,
            reference: 0.0,
            obeys_signals: false,
        }],
        streams: Vec::new(),
        step: 0.025,
        horizon: 60.0,
        finish: 20.0,
        end_on_collision: true,
    }
}

/// A model that stands for nothing: worlds of tests are simulated with road users of their own.
pub fn nobody<T>() -> ModelSetup<T> {
    ModelSetup { model: Reference::unresolved(""), settings: Settings::default() }
}
