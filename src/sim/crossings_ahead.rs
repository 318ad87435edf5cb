//! What a vehicle is told of the crossings of its road.

use scenario::agent::{CrossingView, Observation};
use scenario::{Road, VehicleSetup, World};

/// The crossings of a road in the order in which a vehicle comes to them.
pub(super) struct CrossingsAhead {
    /// Never empty.
    crossings: Vec<MetCrossing>,
    /// Of the vehicle, m.
    half_length: f64,
    /// y of where people may wait on its right and on its left, m.
    edges: (f64, f64),
}

/// A crossing on the path of a vehicle.
#[derive(Debug, Clone, Copy)]
struct MetCrossing {
    /// See [`Road::crossings`].
    number: usize,
    /// The place of its middle on the path, m.
    place: f64,
    /// m
    width: f64,
}

impl CrossingsAhead {
    pub fn new(world: &World, setup: &VehicleSetup) -> Self {
        let (road, path) = (world.road_of(setup), world.path_of(setup));
        let met = |(number, (along, crossing)): (usize, (f64, &scenario::Crossing))| MetCrossing {
            number,
            // The first is the origin, to the bit.
            place: if number == 0 { 0.0 } else { path.at_line(along) },
            width: crossing.width,
        };
        let mut crossings: Vec<_> = road.crossings().enumerate().map(met).collect();
        crossings.sort_by(|one, other| one.place.total_cmp(&other.place));
        Self { crossings, half_length: setup.length / 2.0, edges: path.waiting_places(road) }
    }

    /// As many views as there are crossings.
    pub fn views(&self) -> Vec<CrossingView> {
        let (right_edge, left_edge) = self.edges;
        let view = |met: &MetCrossing| CrossingView {
            distance: met.place,
            width: met.width,
            pedestrian_priority: false,
            right_edge,
            left_edge,
        };
        self.crossings.iter().map(view).collect()
    }

    /// Tells a vehicle that is at a place (m) of its path.
    pub fn tell(&self, time: f64, travelled: f64, road: &Road, seen: &mut Observation) {
        for (view, met) in seen.road.crossings.iter_mut().zip(&self.crossings) {
            view.distance = if met.number == 0 { -travelled } else { met.place - travelled };
            view.pedestrian_priority = road.numbered_crossing(met.number).1.pedestrian_priority(time);
        }
        let is_left = |met: &&MetCrossing| travelled - self.half_length > met.place + met.width / 2.0;
        let current = self.crossings.iter().take_while(is_left).count().min(self.crossings.len() - 1);
        let view = seen.road.crossings[current];
        seen.ego.distance_to_crossing = view.distance;
        seen.road.crossing_width = view.width;
        seen.road.pedestrian_priority = view.pedestrian_priority;
        seen.road.signal = road.numbered_crossing(self.crossings[current].number).1.seen_signal(time);
    }

    /// Tells a vehicle that is so far (m) before the origin that it knows nothing of any crossing.
    pub fn tell_far_away(&self, distance: f64, seen: &mut Observation) {
        seen.ego.distance_to_crossing = distance;
        for (view, met) in seen.road.crossings.iter_mut().zip(&self.crossings) {
            view.distance = distance + met.place;
        }
    }
}
