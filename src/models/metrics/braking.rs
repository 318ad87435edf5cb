//! How hard the vehicle brakes: largest deceleration over a sliding window, and sudden changes of speed.

use scenario::{Absence, Metric, MetricKind, MetricRange, Scope, Stake, Worst};
use scenario::{Declaration, Dimension, Parameter};
use sim::measure::{Encounters, FollowedDrop, InStep, Meter, MetricContext, meters};

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
        stake: Stake::Motion,
        meters: meters(|context| Box::new(MaxDeceleration(speed_drop(context)))),
    }
}

fn speed_drop(context: &MetricContext) -> FollowedDrop {
    let of = (context.settings.number("window"), context.settings.number("standstill"));
    context.followed.borrow_mut().speed_drop(context.vehicle, of, context.world.step)
}

struct MaxDeceleration(FollowedDrop);

impl Meter for MaxDeceleration {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        encounters.speed_drop(self.0).largest()
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        encounters.speed_drop(self.0).instant
    }

    fn in_step(&self, encounters: &Encounters) -> InStep {
        encounters.speed_drop(self.0).latest().into()
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
        stake: Stake::Motion,
        meters: meters(|context| {
            let threshold = context.settings.number("threshold");
            Box::new(SuddenSpeedChange { threshold, drop: speed_drop(context) })
        }),
    }
}

struct SuddenSpeedChange {
    threshold: f64,
    drop: FollowedDrop,
}

impl Meter for SuddenSpeedChange {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        let largest = encounters.speed_drop(self.drop).largest();
        largest.map(|largest| f64::from(largest > self.threshold))
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        encounters.speed_drop(self.drop).instant
    }
}
