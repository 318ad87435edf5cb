//! Whether a vehicle's wheels come to a kerb.

use scenario::{Absence, Declaration, Metric, MetricKind, MetricRange, REAR_AXLE, Scope, Stake, Worst};
use sim::Step;
use sim::measure::{EdgeContact, Encounters, Meter, MetricContext, meters};

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
        stake: Stake::Motion,
        meters: meters(|context| Box::new(KerbContact(edge_contact(context)))),
    }
}

/// Of the vehicle's wheels.
fn edge_contact(context: &MetricContext) -> EdgeContact {
    let setup = &context.world.vehicles[context.vehicle];
    let axle = if setup.behind > 0.0 { setup.behind } else { REAR_AXLE * setup.length };
    EdgeContact::new(context.world, context.vehicle, axle)
}

struct KerbContact(EdgeContact);

impl Meter for KerbContact {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        self.0.observe(step);
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        self.0.was_observed().then(|| f64::from(self.0.first().is_some()))
    }

    fn instant(&self, _: &Encounters) -> Option<f64> {
        self.0.first()
    }
}
