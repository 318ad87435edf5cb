//! What the numbers of a scenario may be; the checker and the plan both read these.

use super::Dimension;

/// Bounds of a number in SI units, both included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// What kind of quantity it is.
    pub dimension: Dimension,
    /// The smallest and the largest value.
    pub range: (f64, f64),
}

const fn limit(dimension: Dimension, low: f64, high: f64) -> Limit {
    Limit { dimension, range: (low, high) }
}

/// Time from one step of a run to the next.
pub const STEP: Limit = limit(Dimension::TIME, 0.000_1, 1.0);
/// Time after which a run ends at the latest.
pub const HORIZON: Limit = limit(Dimension::TIME, 0.1, 3600.0);
/// Distance from the middle of the crossing to the finish line.
pub const FINISH: Limit = limit(Dimension::LENGTH, 0.0, 10_000.0);
/// Of each lane.
pub const LANE_WIDTH: Limit = limit(Dimension::LENGTH, 1.0, 20.0);
/// Of a road.
pub const SPEED_LIMIT: Limit = limit(Dimension::SPEED, 0.0, 100.0);
/// Rise of a road per metre. Ours: the steepest public streets rise by a little more.
pub const GRADIENT: Limit = limit(Dimension::NUMBER, -0.3, 0.3);
/// Coefficient of friction between tyres and road. Ours: below it is wet ice, above it no road tyre.
pub const FRICTION: Limit = limit(Dimension::NUMBER, 0.05, 1.5);
/// Time after which a signal repeats.
pub const CYCLE: Limit = limit(Dimension::TIME, 1.0, 600.0);
/// How long people have green, and when in the cycle they get it.
pub const PEDESTRIAN_GREEN: Limit = limit(Dimension::TIME, 0.0, 600.0);
/// How long vehicles have amber.
pub const AMBER: Limit = limit(Dimension::TIME, 0.0, 20.0);
/// How long vehicles keep red when people's green has ended.
pub const CLEARANCE: Limit = limit(Dimension::TIME, 0.0, 120.0);
/// From the edge of a crossing back to the line before which vehicles stop.
pub const LINE: Limit = limit(Dimension::LENGTH, 0.0, 50.0);

/// Of the number of a [`TrafficSignal`](super::TrafficSignal) that has this name.
pub fn of_signal(name: &str) -> Limit {
    match name {
        "cycle" => CYCLE,
        "amber" => AMBER,
        "clearance" => CLEARANCE,
        "stop_line" => LINE,
        _ => PEDESTRIAN_GREEN,
    }
}

/// Length of a piece of a path.
pub const PIECE: Limit = limit(Dimension::LENGTH, 0.01, 10_000.0);
/// Of a piece of a path.
pub const BEND_RADIUS: Limit = limit(Dimension::LENGTH, 1.0, 100_000.0);
/// That a piece of a path turns.
pub const BEND_ANGLE: Limit = limit(Dimension::ANGLE, 0.001, 2.0 * std::f64::consts::PI);
/// From the beginning of a path to the middle of its crossing.
pub const STATION: Limit = limit(Dimension::LENGTH, 0.0, 100_000.0);
/// From the middle of the first crossing of a straight road to that of another.
pub const CROSSING_PLACE: Limit = limit(Dimension::LENGTH, -1000.0, 1000.0);
/// From the direction of a road to that of one that lies over it.
pub const JUNCTION_ANGLE: Limit = limit(Dimension::ANGLE, -std::f64::consts::PI, std::f64::consts::PI);
/// Of a strip between two lanes.
pub const MEDIAN: Limit = limit(Dimension::LENGTH, 0.1, 100.0);
/// Length and width of road users.
pub const SIZE: Limit = limit(Dimension::LENGTH, 0.1, 30.0);
/// Of pedestrians that are discs.
pub const RADIUS: Limit = limit(Dimension::LENGTH, 0.01, 5.0);
/// From a vehicle's centre back to the point that follows its lane.
pub const BEHIND: Limit = limit(Dimension::LENGTH, 0.0, 15.0);
/// Of the steady cruise at the start.
pub const VEHICLE_SPEED: Limit = limit(Dimension::SPEED, 0.0, 100.0);
/// Distance before the crossing.
pub const VEHICLE_START: Limit = limit(Dimension::LENGTH, 0.0, 10_000.0);
/// Time to arrival at time 0.
pub const VEHICLE_ARRIVAL: Limit = limit(Dimension::TIME, 0.0, 600.0);
/// From the front of a vehicle of a stream to that of the next.
pub const GAP: Limit = limit(Dimension::TIME, 0.1, 600.0);
/// From one stream to another that repeats it.
pub const LATER: Limit = limit(Dimension::TIME, 0.0, 600.0);
/// From kerb or lane centre, as it is written.
pub const PEDESTRIAN_START: Limit = limit(Dimension::LENGTH, -100.0, 100.0);
/// Of pedestrians along the road, from the middle of the crossing.
pub const ALONG: Limit = limit(Dimension::LENGTH, -100.0, 100.0);
/// Of a goal beyond the opposite kerb.
pub const GOAL: Limit = limit(Dimension::LENGTH, -10.0, 100.0);
/// Of a pedestrian's way against straight across the road, either way.
pub const TURNED: Limit = limit(Dimension::ANGLE, -1.25, 1.25);
/// From the start to the goal of a pedestrian who walks along a lane, and what they have walked of that.
pub const FURTHER: Limit = limit(Dimension::LENGTH, 0.01, 1000.0);
/// Time at which a pedestrian appears.
pub const APPEARS_AT: Limit = limit(Dimension::TIME, 0.0, 3600.0);
/// Time to arrival of a vehicle at which a pedestrian appears.
pub const APPEARS_WHEN: Limit = limit(Dimension::TIME, 0.0, 600.0);
/// Time to arrival of a vehicle at which a pedestrian may go.
pub const MAY_GO_WHEN: Limit = limit(Dimension::TIME, 0.0, 600.0);
/// For how long a pedestrian that is there may not go at most.
pub const LOOKS: Limit = limit(Dimension::TIME, 0.0, 600.0);
/// Share of a vehicle's width at which a pedestrian meets it.
pub const MEETS: Limit = limit(Dimension::NUMBER, 0.0, 1.0);
/// From the centre of a pedestrian to the point that they are measured by.
pub const REFERENCE: Limit = limit(Dimension::LENGTH, -5.0, 5.0);

/// Between two decisions of a program.
pub const PERIOD: Limit = limit(Dimension::TIME, 0.001, 60.0);
/// From what a program sees to what is done about it.
pub const DELAY: Limit = limit(Dimension::TIME, 0.0, 60.0);
/// Free driving of a program before the start.
pub const SETTLES: Limit = limit(Dimension::TIME, 0.0, 600.0);
/// In which a program must have started or answered.
pub const WALL_TIME: Limit = limit(Dimension::TIME, 0.001, 3600.0);
