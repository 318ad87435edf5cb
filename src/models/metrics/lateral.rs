//! How hard a vehicle takes the bends of its lane, and of its way where it is steered.

use scenario::{Absence, Declaration, Dimension, Metric, MetricKind, MetricRange, Scope, Stake, Worst};
use sim::Step;
use sim::measure::{Encounters, InStep, Meter, meters};

pub fn lateral_acceleration() -> Metric {
    let declaration = Declaration::new(
        "lateral_acceleration",
        "Largest acceleration of the vehicle to its side, as the bends of its lane, or where it is steered those of its way, and its speed make it; 0 where it goes straight on.",
    )
    .source("|k| v^2 of the tightest bend k that the point which follows the lane (the centre, or what the vehicle says) passes in a step, and the larger of the speeds at both ends; of a vehicle that is steered the larger curvature at both ends, of the way of its rear axle");
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::ACCELERATION),
        scope: Scope::Vehicle,
        worst: Worst::Largest,
        absence: Absence::Open,
        range: MetricRange::NotNegative,
        stake: Stake::Motion,
        meters: meters(|context| {
            Box::new(LateralAcceleration {
                vehicle: context.vehicle,
                largest: None,
                latest: None,
                instant: None,
            })
        }),
    }
}

struct LateralAcceleration {
    vehicle: usize,
    /// m/s²; `None` before the first step.
    largest: Option<f64>,
    /// In the last step, m/s².
    latest: Option<f64>,
    /// When that was, s; `None` where it never went round a bend.
    instant: Option<f64>,
}

impl Meter for LateralAcceleration {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        let largest = self.largest.get_or_insert(0.0);
        let car = &step.after.vehicles[self.vehicle];
        let before = step.before.vehicles[self.vehicle].motion;
        // A bend may begin and end within a step.
        let bend = match &car.steered {
            None => car.path.tightest_followed((before.travelled, car.motion.travelled)),
            Some(steered) => {
                let first = step.before.vehicles[self.vehicle].steered.map_or(0.0, |first| first.curvature);
                first.abs().max(steered.curvature.abs())
            }
        };
        let speed = before.speed.max(car.motion.speed);
        let acceleration = bend * speed * speed;
        self.latest = Some(acceleration);
        if acceleration > *largest {
            *largest = acceleration;
            self.instant = Some(step.time + step.duration);
        }
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        self.largest
    }

    fn instant(&self, _: &Encounters) -> Option<f64> {
        self.instant
    }

    fn in_step(&self, _: &Encounters) -> InStep {
        self.latest.into()
    }
}
