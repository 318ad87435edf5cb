//! How smoothly the vehicle drives: largest and root mean square jerk.

use scenario::{Absence, Metric, MetricKind, MetricRange, Scope, Stake, Worst};
use scenario::{Declaration, Dimension, Parameter};
use sim::measure::{Encounters, FollowedJerk, InStep, Meter, MetricContext, meters};

fn window() -> Parameter {
    Parameter::number(
        "window",
        Dimension::TIME,
        0.2,
        (0.001, 10.0),
        "Time over which speeds and then accelerations are compared.",
        "as for max_deceleration; without one, a step of the acceleration would have \
         as much jerk as the simulation has steps",
    )
}

const SOURCE: &str = "(v(t) - 2 v(t - w) + v(t - 2 w)) / w^2 of the realised speed v over a window \
                      w: the change of the mean acceleration from one window to the next";

pub fn max_jerk() -> Metric {
    let declaration = Declaration::new(
        "max_jerk",
        "Largest jerk of the vehicle in either direction, of the realised acceleration.",
    )
    .source(SOURCE)
    .parameters([window()]);
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::JERK),
        scope: Scope::Vehicle,
        worst: Worst::Largest,
        absence: Absence::Open,
        range: MetricRange::NotNegative,
        stake: Stake::Motion,
        meters: meters(|context| Box::new(MaxJerk(jerk(context)))),
    }
}

fn jerk(context: &MetricContext) -> FollowedJerk {
    let window = context.settings.number("window");
    context.followed.borrow_mut().jerk(context.vehicle, window, context.world.step)
}

struct MaxJerk(FollowedJerk);

impl Meter for MaxJerk {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        let jerk = encounters.jerk(self.0);
        jerk.is_known().then_some(jerk.largest)
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        let jerk = encounters.jerk(self.0);
        (jerk.largest > 0.0).then_some(jerk.instant)
    }

    fn in_step(&self, encounters: &Encounters) -> InStep {
        let jerk = encounters.jerk(self.0);
        jerk.is_known().then_some(jerk.latest).into()
    }
}

pub fn rms_jerk() -> Metric {
    let declaration = Declaration::new(
        "rms_jerk",
        "Root mean square of the vehicle's jerk over the run, of the realised \
         acceleration.",
    )
    .source(SOURCE)
    .parameters([window()]);
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::JERK),
        scope: Scope::Vehicle,
        worst: Worst::Largest,
        absence: Absence::Open,
        range: MetricRange::NotNegative,
        stake: Stake::Motion,
        meters: meters(|context| Box::new(RmsJerk(jerk(context)))),
    }
}

struct RmsJerk(FollowedJerk);

impl Meter for RmsJerk {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        let jerk = encounters.jerk(self.0);
        jerk.is_known().then(|| jerk.root_mean_square())
    }
}
