//! Whether a vehicle reaches an edge of its carriageway: a kerb, the edge of a road that has none, or a median.

use nalgebra::Vector2;

use super::events::least_of;
use crate::{Step, VehicleState};
use scenario::World;

/// Follows whether the corners of a rectangle that moves with a vehicle reach an edge of its carriageway.
#[derive(Debug, Clone)]
pub struct EdgeContact {
    vehicle: usize,
    /// From its centre to the ends of the rectangle, m: to the axles, or half its length.
    ahead: f64,
    /// How far (m) the edges of the carriageway are to the left of the middle of its lane: that on the right, negative, and the other.
    edges: (f64, f64),
    /// Whether it sweeps clear of the edges in every bend of its lane, if it follows that.
    always_clear: bool,
    /// Whether it swept clear of the edges at the end of the last step.
    clear: bool,
    /// Whether there was a step.
    observed: bool,
    /// When it was first there, s.
    first: Option<f64>,
}

impl EdgeContact {
    /// Of a vehicle of a world, and of corners that are `ahead` m before and behind its centre and as wide apart as it is.
    pub fn new(world: &World, vehicle: usize, ahead: f64) -> Self {
        let setup = &world.vehicles[vehicle];
        let path = world.path_of(setup);
        let edges = path.kerbs(world.road_of(setup));
        let (right, left) = path.most_swept((2.0 * ahead, setup.width));
        let always_clear = -right > edges.0 && left < edges.1;
        Self { vehicle, ahead, edges, always_clear, clear: false, observed: false, first: None }
    }

    /// The vehicle's index in the world.
    pub fn vehicle(&self) -> usize {
        self.vehicle
    }

    /// Whether there was a step.
    pub fn was_observed(&self) -> bool {
        self.observed
    }

    /// When a corner first came to an edge, s.
    pub fn first(&self) -> Option<f64> {
        self.first
    }

    /// Takes a step.
    pub fn observe(&mut self, step: &Step) {
        self.observed = true;
        if self.first.is_some() {
            return;
        }
        let (before, after) = (&step.before.vehicles[self.vehicle], &step.after.vehicles[self.vehicle]);
        self.first = self.comes_to_an_edge(before, after).map(|part| step.time + part * step.duration);
    }

    /// How far its corners are from the nearest edge, m; negative where one is beyond it.
    fn margin(&self, car: &VehicleState) -> f64 {
        let (right, left) = self.edges;
        let half = car.width / 2.0;
        if car.keeps_straight() {
            return (-half - right).min(left - half);
        }
        let (centre, heading) = car.pose();
        let side = Vector2::new(-heading.y, heading.x);
        let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let margins = corners.into_iter().map(|(along, across)| {
            let corner = centre + heading * (along * self.ahead) + side * (across * half);
            let beside = car.path.locate(corner).left();
            (beside - right).min(left - beside)
        });
        margins.fold(f64::INFINITY, f64::min)
    }

    /// Whether it follows its lane so that the rectangle does not reach an edge.
    fn sweeps_clear(&self, car: &VehicleState) -> bool {
        if car.keeps_straight() || car.steered.is_some() {
            return false;
        }
        if self.always_clear {
            return true;
        }
        let (right, left) = self.edges;
        let (to_the_right, to_the_left) = car.path.swept(car.motion.travelled, (2.0 * self.ahead, car.width));
        -to_the_right >= right && to_the_left <= left
    }

    /// The share of a step after which a corner is first beyond an edge.
    fn comes_to_an_edge(&mut self, before: &VehicleState, after: &VehicleState) -> Option<f64> {
        if after.keeps_straight() && before.keeps_straight() {
            return (self.margin(after) < 0.0).then_some(1.0);
        }
        // Where a step ends the next one begins.
        let was_clear = self.clear;
        self.clear = self.sweeps_clear(after);
        if self.clear && (was_clear || self.sweeps_clear(before)) {
            return None;
        }
        let mut at = |part: f64| self.margin(&before.between(after, part));
        let (first, last) = (self.margin(before), at(1.0));
        if first < 0.0 {
            return Some(0.0);
        }
        let (one, other) = (before.pose(), after.pose());
        let reach = libm::hypot(self.ahead, after.width / 2.0);
        let moved = (other.0 - one.0).norm() + 2.0 * (other.1 - one.1).norm() * reach;
        // No corner moves farther than this, so most steps need no look inside.
        let (least, part) = match last < 0.0 {
            true => (last, 1.0),
            false if (first + last - moved) / 2.0 > 0.0 => return None,
            false => least_of(&mut at),
        };
        if least >= 0.0 {
            return None;
        }
        let (mut inside, mut beyond) = (0.0, part);
        while beyond - inside > CLOSE {
            let middle = (inside + beyond) / 2.0;
            if at(middle) < 0.0 { beyond = middle } else { inside = middle }
        }
        Some(beyond)
    }
}

/// A moment within a step is found to this share of it.
const CLOSE: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use scenario::agent::{Longitudinal, Steered};
    use scenario::{Direction, Path};

    use super::*;

    /// On a straight road, its wheels 1.3 m before and behind its centre and 0.9 m beside it, turned by `angle` rad at (`x`, `y`) m.
    fn steered(x: f64, y: f64, angle: f64) -> VehicleState {
        let heading = Vector2::new(libm::cos(angle), libm::sin(angle));
        let steered = Steered {
            centre: Vector2::new(x, y),
            heading,
            axle: 1.3,
            steering_angle: 0.0,
            curvature: 0.0,
            offset: y,
            heading_error: angle,
        };
        let mut state = VehicleState::new(
            Path::straight(0.0, Direction::Forward),
            Longitudinal { travelled: x, speed: 5.0, acceleration: 0.0 },
            (4.4, 1.8),
        );
        state.steered = Some(steered);
        state
    }

    fn kerbs(left: f64) -> EdgeContact {
        EdgeContact {
            vehicle: 0,
            ahead: 1.3,
            edges: (-10.0, left),
            always_clear: false,
            clear: false,
            observed: false,
            first: None,
        }
    }

    #[test]
    fn a_wheel_that_swings_over_an_edge_within_a_step_is_found_then() {
        // A wheel that is carried round the centre is farthest to the left in the middle of such a step, by the angle's rise.
        let top = libm::atan2(1.3, 0.9);
        let (before, after) = (steered(0.0, 0.0, top - 0.05), steered(0.0, 0.0, top + 0.05));
        let reach = libm::hypot(1.3, 0.9);
        let at_ends = reach * libm::cos(0.05);
        for (left, expected) in
            [(at_ends - 1e-6, true), (at_ends + 1e-6, true), (reach - 1e-6, true), (reach + 1e-6, false)]
        {
            let found = kerbs(left).comes_to_an_edge(&before, &after);
            assert_eq!(found.is_some(), expected, "an edge {left} m to the left: {found:?}");
            if let Some(part) = found.filter(|part| *part > 0.0) {
                let margin = |part: f64| kerbs(left).margin(&before.between(&after, part));
                assert!(margin(part) < 0.0 && margin(part - 1e-6) >= 0.0, "not at {part}");
                let looked = (0..=1000).map(|look| f64::from(look) / 1000.0).find(|part| margin(*part) < 0.0);
                assert!(looked.is_none_or(|looked| (looked - part).abs() <= 1e-3), "{looked:?}, not {part}");
            }
        }
        // Far from any edge nothing is looked for, and one that was beyond it from the beginning is found there.
        assert_eq!(kerbs(9.0).comes_to_an_edge(&before, &after), None);
        assert_eq!(kerbs(1.0).comes_to_an_edge(&before, &after), Some(0.0));
    }
}
