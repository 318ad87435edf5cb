//! Whether a vehicle's wheels come to a kerb.

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
        "looked at after every step; wheels are at the corners of a rectangle as wide as the vehicle, whose axles are 0.3 of its length (or as far as \
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
    /// Whether there was a step.
    observed: bool,
    /// When it was first there, s.
    first: Option<f64>,
}

impl KerbContact {
    fn new(context: &MetricContext) -> Self {
        let setup = &context.world.vehicles[context.vehicle];
        let axle = if setup.behind > 0.0 { setup.behind } else { REAR_AXLE * setup.length };
        let edges = context.world.path_of(setup).kerbs(context.world.road_of(setup));
        Self { vehicle: context.vehicle, axle, edges, observed: false, first: None }
    }

    fn touches(&self, car: &VehicleState) -> bool {
        let (right, left) = self.edges;
        let half = car.width / 2.0;
        if car.keeps_straight() {
            return -half < right || half > left;
        }
        if car.steered.is_none() {
            // What a longer body sweeps about there is more than where the wheels are.
            let (to_the_right, to_the_left) =
                car.path.swept(car.motion.travelled, (2.0 * self.axle, car.width));
            if -to_the_right >= right && to_the_left <= left {
                return false;
            }
        }
        let (centre, ahead) = car.pose();
        let side = Vector2::new(-ahead.y, ahead.x);
        [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].into_iter().any(|(along, across)| {
            let wheel = centre + ahead * (along * self.axle) + side * (across * half);
            let beside = car.path.locate(wheel).left();
            beside < right || beside > left
        })
    }
}

impl Meter for KerbContact {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        self.observed = true;
        if self.first.is_none() && self.touches(&step.after.vehicles[self.vehicle]) {
            self.first = Some(step.time + step.duration);
        }
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        self.observed.then(|| f64::from(self.first.is_some()))
    }

    fn instant(&self, _: &Encounters) -> Option<f64> {
        self.first
    }
}
