//! How closely a vehicle follows somebody who is in its way.

use super::travel::standing;
use scenario::{Absence, Declaration, Dimension, Metric, MetricKind, MetricRange, Scope, Stake, Worst};
use sim::Step;
use sim::measure::{Encounters, InStep, Meter, half_extent, lerp, meters, part_within};

pub fn time_headway() -> Metric {
    let declaration = Declaration::new(
        "time_headway",
        "Smallest time that the vehicle's front needs to where the pedestrian is, while they are in the strip ahead of it; undefined \
         if they never are while the vehicle drives.",
    )
    .source("gap along the lane from the front to the footprint, divided by the vehicle's speed: g/v of car following (Vogel 2003), for whoever walks along the lane or across it")
    .parameters([standing("standing")]);
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Pair,
        worst: Worst::Smallest,
        absence: Absence::Good,
        range: MetricRange::NotNegative,
        stake: Stake::Meeting,
        meters: meters(|context| {
            Box::new(TimeHeadway {
                pair: (context.vehicle, context.pedestrian),
                standing: context.settings.number("standing"),
                smallest: None,
                latest: None,
            })
        }),
    }
}

struct TimeHeadway {
    pair: (usize, usize),
    /// m/s
    standing: f64,
    /// s, and when that was, s.
    smallest: Option<(f64, f64)>,
    /// In the last step, s.
    latest: Option<f64>,
}

/// Contact with the front closes the gap up to rounding, m.
const ROUNDING: f64 = 1e-9;

impl Meter for TimeHeadway {
    fn observe(&mut self, step: &Step, encounters: &Encounters) {
        self.latest = None;
        let encounter = encounters.pair(self.pair.0, self.pair.1);
        let Some((old, new)) = encounter.places else { return };
        if old.ambiguous || new.ambiguous {
            return;
        }
        let (before, car) = (&step.before.vehicles[self.pair.0], &step.after.vehicles[self.pair.0]);
        let reach = half_extent(&step.after.pedestrians[self.pair.1], &new);
        let (low, high) = encounter.strip;
        let inside = part_within(old.beside, new.beside, (low - reach.y, high + reach.y));
        let Some((enter, leave)) = inside else { return };
        // Gap and speed are linear within a step, so that their ratio is smallest at an end of the stay.
        for part in [enter, leave] {
            let front = lerp(before.motion.travelled, car.motion.travelled, part) + car.length / 2.0;
            let gap = lerp(old.along, new.along, part) - reach.x - front;
            let speed = lerp(before.motion.speed, car.motion.speed, part);
            if gap < -ROUNDING || speed <= self.standing {
                continue;
            }
            let headway = gap.max(0.0) / speed;
            self.latest = Some(self.latest.map_or(headway, |latest| latest.min(headway)));
            if self.smallest.is_none_or(|(smallest, _)| headway < smallest) {
                self.smallest = Some((headway, step.time + part * step.duration));
            }
        }
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        self.smallest.map(|(headway, _)| headway)
    }

    fn instant(&self, _: &Encounters) -> Option<f64> {
        self.smallest.map(|(_, instant)| instant)
    }

    fn in_step(&self, _: &Encounters) -> InStep {
        self.latest.into()
    }
}
