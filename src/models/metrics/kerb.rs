//! Whether a vehicle's wheels come to a kerb.

use super::contact::least_of;
use nalgebra::Vector2;
use scenario::{Absence, Declaration, Metric, MetricKind, MetricRange, REAR_AXLE, Scope, Worst};
use sim::measure::{Encounters, Meter, MetricContext, meters};
use sim::{Step, VehicleState};

pub fn kerb_contact() -> Metric {
    let declaration = Declaration::new(
        "kerb_contact",
        "Whether a wheel of the vehicle comes to the edge of its carriageway: a kerb (or the edge of a road that has none), or a median. It is no \
         collision, and the vehicle drives on over it.",
    )
    .source(
        "looked at within steps as well, between which a vehicle moves and turns evenly; wheels are at the corners of a rectangle as wide as the vehicle, whose axles are 0.3 of its length (or as far as \
         its rear axle is) behind its centre and ahead of it",
    );
    Metric {
        declaration,
        kind: MetricKind::Flag,
        scope: Scope::Vehicle,
        worst: Worst::Largest,
        absence: Absence::Open,
        range: MetricRange::YesOrNo,
        meters: meters(|context| Box::new(KerbContact::new(context))),
    }
}

struct KerbContact {
    vehicle: usize,
    /// From its centre to either axle, m.
    axle: f64,
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

impl KerbContact {
    fn new(context: &MetricContext) -> Self {
        let setup = &context.world.vehicles[context.vehicle];
        let axle = if setup.behind > 0.0 { setup.behind } else { REAR_AXLE * setup.length };
        let path = context.world.path_of(setup);
        let edges = path.kerbs(context.world.road_of(setup));
        let (right, left) = path.most_swept((2.0 * axle, setup.width));
        let always_clear = -right > edges.0 && left < edges.1;
        Self {
            vehicle: context.vehicle,
            axle,
            edges,
            always_clear,
            clear: false,
            observed: false,
            first: None,
        }
    }

    /// How far its wheels are from the nearest edge, m; negative where one is beyond it.
    fn margin(&self, car: &VehicleState) -> f64 {
        let (right, left) = self.edges;
        let half = car.width / 2.0;
        if car.keeps_straight() {
            return (-half - right).min(left - half);
        }
        let (centre, ahead) = car.pose();
        let side = Vector2::new(-ahead.y, ahead.x);
        let wheels = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let margins = wheels.into_iter().map(|(along, across)| {
            let wheel = centre + ahead * (along * self.axle) + side * (across * half);
            let beside = car.path.locate(wheel).left();
            (beside - right).min(left - beside)
        });
        margins.fold(f64::INFINITY, f64::min)
    }

    /// Whether it follows its lane so that a body longer than its wheels are apart does not come to an edge.
    fn sweeps_clear(&self, car: &VehicleState) -> bool {
        if car.keeps_straight() || car.steered.is_some() {
            return false;
        }
        if self.always_clear {
            return true;
        }
        let (right, left) = self.edges;
        let (to_the_right, to_the_left) = car.path.swept(car.motion.travelled, (2.0 * self.axle, car.width));
        -to_the_right >= right && to_the_left <= left
    }

    /// The share of a step after which a wheel first comes to an edge.
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
        let reach = libm::hypot(self.axle, after.width / 2.0);
        let moved = (other.0 - one.0).norm() + 2.0 * (other.1 - one.1).norm() * reach;
        // No wheel comes nearer than it moves, so most steps need no look inside.
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

impl Meter for KerbContact {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        self.observed = true;
        if self.first.is_some() {
            return;
        }
        let (before, after) = (&step.before.vehicles[self.vehicle], &step.after.vehicles[self.vehicle]);
        self.first = self.comes_to_an_edge(before, after).map(|part| step.time + part * step.duration);
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        self.observed.then(|| f64::from(self.first.is_some()))
    }

    fn instant(&self, _: &Encounters) -> Option<f64> {
        self.first
    }
}

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

    fn kerbs(left: f64) -> KerbContact {
        KerbContact {
            vehicle: 0,
            axle: 1.3,
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
