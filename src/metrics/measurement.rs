//! All requested metrics of one run at once, the worst pair first.

use super::{FreeFlow, Meter, MetricContext, Scope, Worst, metric};
use crate::scenario::{MetricReference, World};
use crate::sim::{Ending, Observer, Step};

/// Meters for every request and every pair of road users that it concerns.
pub struct Measurement {
    requests: Vec<(Worst, Vec<Box<dyn Meter>>)>,
}

impl Measurement {
    /// `free_flows` has one entry per vehicle, `free_speeds` (m/s) one per pedestrian.
    pub fn new(
        world: &World,
        requests: &[MetricReference],
        free_flows: &[FreeFlow],
        _free_speeds: &[f64],
    ) -> Self {
        let meters = |reference: &MetricReference| {
            let metric = metric(&reference.name).expect("requests were checked against the registry");
            let settings = metric.declaration.resolve(&reference.settings).expect("settings were checked");
            let mut meters = Vec::new();
            for vehicle in 0..world.vehicles.len() {
                for pedestrian in 0..world.pedestrians.len() {
                    let wanted = reference.pair.as_ref().is_none_or(|(car, person)| {
                        *car == world.vehicles[vehicle].name && *person == world.pedestrians[pedestrian].name
                    });
                    let again = match metric.scope {
                        Scope::Pair => false,
                        Scope::Vehicle => pedestrian > 0,
                        Scope::Pedestrian => vehicle > 0,
                    };
                    if wanted && !again {
                        let free_flow = free_flows.get(vehicle).copied();
                        let context =
                            MetricContext { settings: &settings, world, vehicle, pedestrian, free_flow };
                        meters.push((metric.build)(&context));
                    }
                }
            }
            (metric.worst, meters)
        };
        Self { requests: requests.iter().map(meters).collect() }
    }

    /// The worst value of every request, in order.
    pub fn values(&self, ending: &Ending) -> Vec<Option<f64>> {
        self.requests
            .iter()
            .map(|(worst, meters)| {
                let values = meters.iter().filter_map(|meter| meter.value(ending));
                match worst {
                    Worst::Smallest => values.reduce(f64::min),
                    Worst::Largest => values.reduce(f64::max),
                }
            })
            .collect()
    }
}

impl Observer for Measurement {
    fn observe(&mut self, step: &Step) {
        for meter in self.requests.iter_mut().flat_map(|(_, meters)| meters) {
            meter.observe(step);
        }
    }
}
