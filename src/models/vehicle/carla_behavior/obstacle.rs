//! The agent's distance test: who counts as an obstacle, and how far away the agent believes it is.
//!
//! The stock code measures from the front bumper to the obstacle and then subtracts half the ego's length once
//! more, so an obstacle seems nearer than it is by that much.

use nalgebra::Vector2;

use scenario::{Settings, Shape};
use sim::{EgoState, Observation};

use super::declaration::KMH;

pub struct ObstacleTest {
    distances: Distances,
    lateral: Lateral,
    braking_distance: f64,
    /// m
    min_proximity_threshold: f64,
    /// Horizontal radius around the ego's centre within which walkers are looked at, m.
    walker_radius: f64,
    walker_cone: f64,
    /// Half size of walkers, m; `None`: of the one that is seen.
    walker_extent: Option<f64>,
    vehicle_radius: f64,
    vehicle_cone: f64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Distances {
    Stock,
    Extended,
    Clean,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Lateral {
    Lane,
    Polygon,
}

/// A vehicle in the way.
#[derive(Clone, Copy)]
pub struct Lead {
    /// As the agent believes, m.
    pub distance: f64,
    /// m/s
    pub speed: f64,
}

impl ObstacleTest {
    pub fn from_settings(settings: &Settings) -> Self {
        let radius = settings.number("walker_radius");
        let height = settings.number("walker_origin_height");
        Self {
            distances: match settings.word("obstacle_distance") {
                "stock" => Distances::Stock,
                "clean" => Distances::Clean,
                _ => Distances::Extended,
            },
            lateral: match settings.word("lateral") {
                "polygon" => Lateral::Polygon,
                _ => Lateral::Lane,
            },
            braking_distance: settings.number("braking_distance"),
            min_proximity_threshold: settings.number("min_proximity_threshold"),
            walker_radius: (radius * radius - height * height).max(0.0).sqrt(),
            walker_cone: settings.number("walker_cone"),
            walker_extent: settings.optional_number("walker_extent"),
            vehicle_radius: settings.number("vehicle_radius"),
            vehicle_cone: settings.number("vehicle_cone"),
        }
    }

    /// The distance at which the agent believes the walker that it reacts to; `None` when there is none.
    pub fn walker(&self, observation: &Observation) -> Option<f64> {
        let ego = &observation.ego;
        let half_length = ego.length / 2.0;
        let mut believed = observation.pedestrians.iter().filter_map(|walker| {
            let extent = self.walker_extent.unwrap_or_else(|| half_size(walker.shape));
            let (radius, reach) = match self.distances {
                Distances::Stock => (self.walker_radius, self.stock_reach(observation)),
                Distances::Extended => (
                    self.braking_distance + 2.0 * half_length + extent + 1.0,
                    self.braking_distance + half_length + extent + 1.0,
                ),
                Distances::Clean => (f64::INFINITY, f64::INFINITY),
            };
            if walker.position.norm() >= radius || !self.beside(observation, walker.position.y, extent) {
                return None;
            }
            let gap = gap_within(ego, walker.position, reach, self.walker_cone)?;
            Some(match self.distances {
                Distances::Clean => gap - extent,
                Distances::Stock | Distances::Extended => gap - half_length - extent,
            })
        });
        match self.distances {
            // Only the first hit of the list is ever looked at.
            Distances::Stock | Distances::Extended => believed.next(),
            Distances::Clean => believed.reduce(f64::min),
        }
    }

    /// The vehicle in the own lane that the agent keeps behind.
    pub fn vehicle(&self, observation: &Observation) -> Option<Lead> {
        let ego = &observation.ego;
        let half_length = ego.length / 2.0;
        let mut leads = observation.vehicles.iter().filter_map(|vehicle| {
            let extent = (vehicle.length / 2.0).max(vehicle.width / 2.0);
            let reach = match self.distances {
                Distances::Stock => self.stock_reach(observation),
                Distances::Extended => {
                    self.stock_reach(observation).max(self.braking_distance + half_length + extent + 1.0)
                }
                Distances::Clean => f64::INFINITY,
            };
            let in_lane = vehicle.position.y.abs() <= observation.road.lane_width / 2.0;
            if vehicle.position.norm() >= self.vehicle_radius || !in_lane {
                return None;
            }
            let backwards = if vehicle.velocity.x < 0.0 { 1.0 } else { -1.0 };
            let rear = vehicle.position + Vector2::new(backwards * vehicle.length / 2.0, 0.0);
            let gap = gap_within(ego, rear, reach, self.vehicle_cone)?;
            let distance = match self.distances {
                Distances::Clean => gap,
                Distances::Stock | Distances::Extended => gap - half_length - extent,
            };
            Some(Lead { distance, speed: vehicle.velocity.norm() })
        });
        match self.distances {
            Distances::Stock | Distances::Extended => leads.next(),
            Distances::Clean => {
                leads.reduce(|one, other| if other.distance < one.distance { other } else { one })
            }
        }
    }

    /// The stock code takes a third of the speed limit in km/h for metres.
    fn stock_reach(&self, observation: &Observation) -> f64 {
        self.min_proximity_threshold.max(observation.road.speed_limit * KMH / 3.0)
    }

    fn beside(&self, observation: &Observation, y: f64, extent: f64) -> bool {
        let half_width = match self.lateral {
            Lateral::Lane => observation.road.lane_width / 2.0,
            Lateral::Polygon => observation.ego.width / 2.0 + extent,
        };
        y.abs() <= half_width
    }
}

/// Distance from the front bumper's middle to a place if it is within reach (m) and the cone's half angle (rad).
fn gap_within(ego: &EgoState, place: Vector2<f64>, reach: f64, cone: f64) -> Option<f64> {
    let ahead = place.x - ego.length / 2.0;
    let gap = libm::hypot(ahead, place.y);
    if gap < 0.001 {
        return Some(gap);
    }
    (gap <= reach && libm::atan2(place.y.abs(), ahead) < cone).then_some(gap)
}

/// The larger half extent of a walker's box, m.
fn half_size(shape: Shape) -> f64 {
    match shape {
        Shape::Disc { radius } => radius,
        Shape::Rectangle { length, width } => length.max(width) / 2.0,
    }
}
