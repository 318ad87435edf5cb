//! What the encounter costs the vehicle: time lost, time taken and time stopped.

use scenario::{Absence, Metric, MetricKind, MetricRange, Scope, Stake, Worst};
use scenario::{Declaration, Dimension, Parameter};
use sim::Step;
use sim::measure::{Encounters, End, FreeFlow, Meter, MetricContext, Open, difference, meters};
use sim::measure::{lerp, rising};

pub fn time_lost() -> Metric {
    let declaration = Declaration::new(
        "time_lost",
        "Travel time to the finish line beyond that of the same vehicle without \
         pedestrian, at least 0; undefined if it does not get there or is not back at \
         its free speed there.",
    )
    .source("max(0, T_int - T_free), by the vehicle's centre")
    .parameters([Parameter::number(
        "speed_tolerance",
        Dimension::SPEED,
        0.5,
        (0.0, 100.0),
        "How far the speed at the finish line may be from that in free flow; else the \
         line is too near to tell.",
        "regaining 0.5 m/s at 1 m/s^2 and 30 km/h costs another 0.015 s",
    )]);
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Vehicle,
        worst: Worst::Largest,
        absence: Absence::Bad,
        range: MetricRange::WithinRun,
        stake: Stake::Motion,
        meters: meters(|context| Box::new(TimeLost::new(context))),
    }
}

struct TimeLost {
    vehicle: usize,
    line: f64,
    tolerance: f64,
    free_flow: Option<FreeFlow>,
    /// Time (s) and speed (m/s) at the line.
    finish: Option<(f64, f64)>,
}

impl TimeLost {
    fn new(context: &MetricContext) -> Self {
        Self {
            vehicle: context.vehicle,
            line: context.world.finish,
            tolerance: context.settings.number("speed_tolerance"),
            free_flow: context.free_flow,
            finish: None,
        }
    }
}

impl Meter for TimeLost {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        self.finish = self.finish.or_else(|| crosses(step, self.vehicle, self.line));
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        let free = self.free_flow?;
        let (time, speed) = self.finish?;
        let lost = difference(time, free.finish_time?).max(0.0);
        ((speed - free.finish_speed).abs() <= self.tolerance).then_some(lost)
    }

    fn open(&self, _: &Encounters, end: &End) -> Option<Open> {
        let free = self.free_flow.and_then(|free| free.finish_time);
        self.finish.is_none().then(|| Open::at_least(free.map_or(0.0, |free| (end.time - free).max(0.0))))
    }
}

/// Time (s) and speed (m/s) at which a vehicle's centre crosses the line, if it does so in this step.
fn crosses(step: &Step, vehicle: usize, line: f64) -> Option<(f64, f64)> {
    let (before, after) = (step.before.vehicles[vehicle].motion, step.after.vehicles[vehicle].motion);
    let part = rising(before.travelled, after.travelled, line)?;
    Some((step.time + part * step.duration, lerp(before.speed, after.speed, part)))
}

pub fn travel_time() -> Metric {
    let declaration = Declaration::new(
        "travel_time",
        "Time from the start to the finish line; undefined if the vehicle does not get \
         there. What tunes of the cruise speed minimise: driving slower loses no time \
         against itself.",
    )
    .source("by the vehicle's centre");
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Vehicle,
        worst: Worst::Largest,
        absence: Absence::Bad,
        range: MetricRange::WithinRun,
        stake: Stake::Motion,
        meters: meters(|context| {
            Box::new(TravelTime { vehicle: context.vehicle, line: context.world.finish, finish: None })
        }),
    }
}

struct TravelTime {
    vehicle: usize,
    line: f64,
    finish: Option<f64>,
}

impl Meter for TravelTime {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        self.finish = self.finish.or_else(|| crosses(step, self.vehicle, self.line).map(|(time, _)| time));
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        self.finish
    }

    fn open(&self, _: &Encounters, end: &End) -> Option<Open> {
        self.finish.is_none().then(|| Open::at_least(end.time))
    }
}

/// At or below which speed a vehicle stands, a parameter of this name.
pub fn standing(name: &'static str) -> Parameter {
    Parameter::number(
        name,
        Dimension::SPEED,
        0.1,
        (0.0, 10.0),
        "At or below this speed the vehicle stands.",
        "controllers approach a standstill without quite reaching it",
    )
}

pub fn stopped_time() -> Metric {
    let declaration = Declaration::new("stopped_time", "How long the vehicle stands during the run.")
        .source("time with a speed below the parameter, interpolated inside a step")
        .parameters([standing("speed")]);
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Vehicle,
        worst: Worst::Largest,
        absence: Absence::Open,
        range: MetricRange::WithinRun,
        stake: Stake::Motion,
        meters: meters(|context| {
            let speed = context.settings.number("speed");
            Box::new(StoppedTime { vehicle: context.vehicle, line: context.world.finish, speed, total: 0.0 })
        }),
    }
}

struct StoppedTime {
    vehicle: usize,
    line: f64,
    speed: f64,
    total: f64,
}

impl Meter for StoppedTime {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        let before = step.before.vehicles[self.vehicle].motion.speed - self.speed;
        let after = step.after.vehicles[self.vehicle].motion.speed - self.speed;
        let part = match (before <= 0.0, after <= 0.0) {
            (true, true) => 1.0,
            (false, false) => 0.0,
            (true, false) => -before / (after - before),
            (false, true) => -after / (before - after),
        };
        self.total += part * step.duration;
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        Some(self.total)
    }

    fn open(&self, _: &Encounters, end: &End) -> Option<Open> {
        let under_way = end.state.vehicles[self.vehicle].motion.travelled < self.line;
        under_way.then(|| Open::at_least(self.total))
    }
}
