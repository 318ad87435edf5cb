//! A metric of one's own: declared, registered, measured for a criterion that names it, and shown in a table.

mod own;

use std::error::Error;

use scenario_runner::models::standard;
use scenario_runner::registry::Registry;
use scenario_runner::scenario::{
    Absence, Declaration, Dimension, Metric, MetricKind, MetricRange, Scope, Stake, Worst,
};
use scenario_runner::sim::Step;
use scenario_runner::sim::measure::{Encounters, Meter, meters};

/// For how long a vehicle was slower than it may be.
struct Slow {
    vehicle: usize,
    below: f64,
    time: f64,
}

impl Meter for Slow {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        if step.after.vehicles[self.vehicle].motion.speed < self.below {
            self.time += step.duration;
        }
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        Some(self.time)
    }
}

fn registry() -> Result<Registry, Box<dyn Error>> {
    let slow_time = Metric {
        declaration: Declaration::new("slow_time", "Time that the vehicle is slow.")
            .source("an example")
            .number("below", Dimension::SPEED, 5.0, (0.0, 50.0), "Slower than this is slow."),
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Vehicle,
        worst: Worst::Largest,
        absence: Absence::Open,
        range: MetricRange::WithinRun,
        stake: Stake::Motion,
        meters: meters(|context| {
            Box::new(Slow { vehicle: context.vehicle, below: context.settings.number("below"), time: 0.0 })
        }),
    };
    Ok(standard().with_metric(slow_time)?)
}

pub(crate) fn table() -> Result<String, Box<dyn Error>> {
    own::tables("examples/own_metric.scn", &registry()?)
}

#[allow(dead_code)] // Tests ask for the table.
fn main() -> Result<(), Box<dyn Error>> {
    println!("{}", table()?);
    Ok(())
}
