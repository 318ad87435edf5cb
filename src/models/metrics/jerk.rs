//! How smoothly the vehicle drives: largest and root mean square jerk.

use super::sliding::Sliding;
use scenario::{Absence, Metric, MetricKind, MetricRange, Scope, Worst};
use scenario::{Declaration, Dimension, Parameter};
use sim::Step;
use sim::measure::{Encounters, InStep, Meter, MetricContext, meters};

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
        meters: meters(|context| Box::new(MaxJerk(Jerk::new(context)))),
    }
}

struct MaxJerk(Jerk);

impl Meter for MaxJerk {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        self.0.observe(step);
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        (self.0.duration > 0.0).then_some(self.0.largest)
    }

    fn instant(&self, _: &Encounters) -> Option<f64> {
        (self.0.largest > 0.0).then_some(self.0.instant)
    }

    fn in_step(&self, _: &Encounters) -> InStep {
        (self.0.duration > 0.0).then_some(self.0.latest).into()
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
        meters: meters(|context| Box::new(RmsJerk(Jerk::new(context)))),
    }
}

struct RmsJerk(Jerk);

impl Meter for RmsJerk {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        self.0.observe(step);
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        (self.0.duration > 0.0).then(|| (self.0.square_integral / self.0.duration).sqrt())
    }
}

struct Jerk {
    vehicle: usize,
    window: f64,
    speeds: Sliding<2>,
    /// m/s³
    last: f64,
    largest: f64,
    /// When that was, s.
    instant: f64,
    /// The same in the last step, m/s³.
    latest: f64,
    /// Of the jerk's square over time, m²/s⁵.
    square_integral: f64,
    /// s
    duration: f64,
}

impl Jerk {
    fn new(context: &MetricContext) -> Self {
        let window = context.settings.number("window");
        Self {
            vehicle: context.vehicle,
            window,
            speeds: Sliding::new([window, 2.0 * window], context.world.step),
            last: 0.0,
            largest: 0.0,
            latest: 0.0,
            instant: 0.0,
            square_integral: 0.0,
            duration: 0.0,
        }
    }

    fn observe(&mut self, step: &Step) {
        let from = (step.time, step.before.vehicles[self.vehicle].motion.speed);
        let to = (step.time + step.duration, step.after.vehicles[self.vehicle].motion.speed);
        let Self { window, speeds, last, largest, instant, latest, square_integral, .. } = self;
        *latest = 0.0;
        let mut since = from.0;
        speeds.advance(from, to, |time, speed, [earlier, earliest]| {
            let jerk = (speed - 2.0 * earlier + earliest) / (*window * *window);
            *latest = latest.max(jerk.abs());
            if jerk.abs() > *largest {
                (*largest, *instant) = (jerk.abs(), time);
            }
            // The square of a straight line, integrated.
            *square_integral += (time - since) * (*last * *last + *last * jerk + jerk * jerk) / 3.0;
            (since, *last) = (time, jerk);
        });
        self.duration += step.duration;
    }
}
