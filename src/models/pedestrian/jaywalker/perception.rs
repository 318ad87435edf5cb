//! What the jaywalker makes of the vehicles around it: time gaps and the vehicle that matters.

use scenario::{Settings, Side};
use sim::sight::sees_vehicle;
use sim::{PedestrianState, Scene, VehicleState};

/// Below this a vehicle does not come nearer, m/s.
const ONCOMING_SPEED: f64 = 1e-4;
/// Below this a vehicle stands, m/s.
const STANDING_SPEED: f64 = 1e-3;

/// How it judges distances.
#[derive(Debug, Clone, Copy)]
pub struct JaywalkerPerception {
    multiplier: f64,
    /// `None`: half the vehicle's diagonal, m.
    margin: Option<f64>,
}

/// One vehicle in relation to the pedestrian. Lengths in m, times in s, speeds in m/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JaywalkerEncounter {
    /// How far the pedestrian is beyond the centre of the vehicle's lane, along its crossing direction.
    pub beyond_lane_centre: f64,
    /// From the vehicle's centre to the pedestrian along the road; negative once the centre has passed.
    pub ahead: f64,
    pub speed: f64,
    /// Half the vehicle's diagonal.
    pub half_diagonal: f64,
    /// Gap between vehicle and pedestrian along the road, at least 0.
    pub gap: f64,
    /// `None` unless the vehicle comes nearer.
    pub time_gap: Option<f64>,
}

impl JaywalkerEncounter {
    pub fn has_passed(&self) -> bool {
        self.ahead <= 0.0
    }

    pub fn is_oncoming(&self) -> bool {
        !self.has_passed() && self.speed > ONCOMING_SPEED
    }

    /// Whether it stands before the pedestrian.
    pub fn stands(&self) -> bool {
        !self.has_passed() && self.speed < STANDING_SPEED
    }
}

impl JaywalkerPerception {
    pub fn new(settings: &Settings) -> Self {
        Self {
            multiplier: settings.number("time_gap_multiplier"),
            margin: settings.optional_number("time_gap_margin"),
        }
    }

    /// How `vehicle` and a pedestrian that crosses from `side` stand to each other.
    pub fn encounter(&self, vehicle: &VehicleState, ego: &PedestrianState, side: Side) -> JaywalkerEncounter {
        let ahead = vehicle.path.along(ego.position) - vehicle.motion.travelled;
        let speed = vehicle.motion.speed;
        let half_diagonal = libm::hypot(vehicle.length, vehicle.width) / 2.0;
        let gap = (ahead - self.margin.unwrap_or(half_diagonal) - vehicle.length / 2.0).max(0.0);
        let mut encounter = JaywalkerEncounter {
            beyond_lane_centre: vehicle.path.beyond(ego.position, side),
            ahead,
            speed,
            half_diagonal,
            gap,
            time_gap: None,
        };
        if encounter.is_oncoming() && !encounter.stands() {
            encounter.time_gap = Some(self.multiplier * gap / speed);
        }
        encounter
    }

    /// The encounter that matters most; `None` without vehicles in sight.
    ///
    /// A moving vehicle whose lane it has yet to leave comes before other moving ones, these before standing ones and
    /// these before those that passed; among equals the one that arrives first, then the nearest.
    pub fn focus(&self, scene: &Scene, side: Side) -> Option<JaywalkerEncounter> {
        let half_lane = scene.road.lane_width / 2.0;
        let urgency = |encounter: &JaywalkerEncounter| {
            let left_behind = encounter.beyond_lane_centre > half_lane;
            if encounter.has_passed() {
                (3, -encounter.ahead)
            } else if encounter.stands() {
                (2, encounter.ahead)
            } else {
                (u8::from(left_behind), encounter.ahead / encounter.speed)
            }
        };
        // Whoever is equally urgent is told apart by lane and place, not by the order in which they come.
        let order = |one: &JaywalkerEncounter, other: &JaywalkerEncounter| {
            let (urgent, less) = (urgency(one), urgency(other));
            urgent
                .0
                .cmp(&less.0)
                .then(urgent.1.total_cmp(&less.1))
                .then(other.beyond_lane_centre.total_cmp(&one.beyond_lane_centre))
                .then(one.ahead.total_cmp(&other.ahead))
        };
        let met = |(index, vehicle): &(usize, &VehicleState)| {
            sees_vehicle(scene, *index) && scene.meets_on_this_leg(vehicle)
        };
        let met = scene.vehicles.iter().enumerate().filter(met);
        let encounters = met.map(|(_, vehicle)| self.encounter(vehicle, scene.ego(), side));
        encounters.min_by(order)
    }
}
