//! How hard the vehicle brakes: largest deceleration over a sliding window, and sudden changes of speed.

use super::sliding::Sliding;
use scenario::{Absence, Metric, MetricKind, MetricRange, Scope, Worst};
use scenario::{Declaration, Dimension, Parameter};
use sim::Step;
use sim::measure::lerp;
use sim::measure::{Encounters, InStep, Meter, MetricContext, meters};

fn window() -> Parameter {
    Parameter::number(
        "window",
        Dimension::TIME,
        0.2,
        (0.001, 10.0),
        "Time over which the drop of speed is taken.",
        "several control periods of 0.05 s, so that no single jump of a simulator \
         decides",
    )
}

fn standstill() -> Parameter {
    Parameter::number(
        "standstill",
        Dimension::SPEED,
        1.0,
        (0.0, 100.0),
        "Drops below this speed do not count: simulators stop cars abruptly at the end.",
        "CARLA zeroes speeds below about 1 m/s at once, with spikes of 10 to 20 m/s^2 \
         (issue 3906)",
    )
}

pub fn max_deceleration() -> Metric {
    let declaration = Declaration::new(
        "max_deceleration",
        "Largest deceleration of the vehicle: drop of speed over a sliding window, \
         divided by the window; 0 if it never slows down.",
    )
    .source(
        "exact for speeds that are linear inside a step; to 1e-9 m/s^2, so that \
         rounding breaks no limit that is kept exactly",
    )
    .parameters([window(), standstill()]);
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::ACCELERATION),
        scope: Scope::Vehicle,
        worst: Worst::Largest,
        absence: Absence::Open,
        range: MetricRange::DropWithin { window: "window".into(), floor: "standstill".into() },
        meters: meters(|context| Box::new(MaxDeceleration(Deceleration::new(context)))),
    }
}

struct MaxDeceleration(Deceleration);

impl Meter for MaxDeceleration {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        self.0.observe(step);
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        self.0.largest()
    }

    fn instant(&self, _: &Encounters) -> Option<f64> {
        self.0.instant
    }

    fn in_step(&self, _: &Encounters) -> InStep {
        self.0.rate(self.0.latest_drop).into()
    }
}

pub fn sudden_speed_change() -> Metric {
    let declaration =
        Declaration::new("sudden_speed_change", "Whether max_deceleration exceeds a threshold.")
            .source("Carlowitz 2024")
            .parameters([
                Parameter::number(
                    "threshold",
                    Dimension::ACCELERATION,
                    2.5,
                    (0.0, 100.0),
                    "Decelerations above this are sudden.",
                    "Carlowitz 2024",
                ),
                window(),
                standstill(),
            ]);
    Metric {
        declaration,
        kind: MetricKind::Flag,
        scope: Scope::Vehicle,
        worst: Worst::Largest,
        absence: Absence::Open,
        range: MetricRange::DropAbove {
            threshold: "threshold".into(),
            window: "window".into(),
            floor: "standstill".into(),
        },
        meters: meters(|context| {
            let threshold = context.settings.number("threshold");
            Box::new(SuddenSpeedChange { threshold, deceleration: Deceleration::new(context) })
        }),
    }
}

struct SuddenSpeedChange {
    threshold: f64,
    deceleration: Deceleration,
}

impl Meter for SuddenSpeedChange {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        self.deceleration.observe(step);
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        self.deceleration.largest().map(|largest| f64::from(largest > self.threshold))
    }

    fn instant(&self, _: &Encounters) -> Option<f64> {
        self.deceleration.instant
    }
}

struct Deceleration {
    vehicle: usize,
    window: f64,
    standstill: f64,
    speeds: Sliding<1>,
    /// m/s over one window; `None` before the first step.
    largest_drop: Option<f64>,
    /// The same in the last step.
    latest_drop: Option<f64>,
    /// At the end of the window in which that was, s; `None` if the vehicle never slowed down.
    instant: Option<f64>,
}

impl Deceleration {
    fn new(context: &MetricContext) -> Self {
        let window = context.settings.number("window");
        Self {
            vehicle: context.vehicle,
            window,
            standstill: context.settings.number("standstill"),
            speeds: Sliding::new([window], context.world.step),
            largest_drop: None,
            latest_drop: None,
            instant: None,
        }
    }

    fn observe(&mut self, step: &Step) {
        let from = (step.time, step.before.vehicles[self.vehicle].motion.speed);
        let to = (step.time + step.duration, step.after.vehicles[self.vehicle].motion.speed);
        // Speeds below standstill count as standstill, which bends the signal where it gets there.
        let floor = self.standstill;
        let counted = |(time, speed): (f64, f64)| (time, speed.max(floor));
        self.latest_drop = None;
        if (from.1 - floor) * (to.1 - floor) < 0.0 {
            let part = (floor - from.1) / (to.1 - from.1);
            let bend = (lerp(from.0, to.0, part), floor);
            self.go(counted(from), bend);
            self.go(bend, counted(to));
        } else {
            self.go(counted(from), counted(to));
        }
    }

    fn go(&mut self, from: (f64, f64), to: (f64, f64)) {
        let mut largest = self.largest_drop.unwrap_or(0.0);
        let mut latest = self.latest_drop.unwrap_or(0.0);
        let instant = &mut self.instant;
        self.speeds.advance(from, to, |time, speed, [earlier]| {
            let drop = earlier - speed;
            // What is larger by rounding only is no later extreme.
            if drop > largest + 1e-9 {
                *instant = Some(time);
            }
            largest = largest.max(drop);
            latest = latest.max(drop);
        });
        self.largest_drop = Some(largest);
        self.latest_drop = Some(latest);
    }

    /// m/s²
    fn largest(&self) -> Option<f64> {
        self.rate(self.largest_drop)
    }

    /// A drop (m/s) over the window, m/s².
    fn rate(&self, drop: Option<f64>) -> Option<f64> {
        drop.map(|drop| (drop / self.window * 1e9).round() / 1e9)
    }
}
