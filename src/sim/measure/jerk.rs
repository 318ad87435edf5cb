//! How smoothly a vehicle drives: the jerk of its realised speed.

use super::sliding::Sliding;
use crate::Step;

/// The jerk of one vehicle: how the mean acceleration changes from one window to the next.
#[derive(Debug, Clone)]
pub struct Jerk {
    vehicle: usize,
    window: f64,
    speeds: Sliding<2>,
    /// m/s³
    last: f64,
    /// In either direction, m/s³.
    pub largest: f64,
    /// When that was, s.
    pub instant: f64,
    /// The largest in the last step, m/s³.
    pub latest: f64,
    /// Of the jerk's square over time, m²/s⁵.
    square_integral: f64,
    /// s
    duration: f64,
}

impl Jerk {
    /// Over windows of so many seconds; steps are mostly `step` s.
    pub(super) fn new(vehicle: usize, window: f64, step: f64) -> Self {
        Self {
            vehicle,
            window,
            speeds: Sliding::new([window, 2.0 * window], step),
            last: 0.0,
            largest: 0.0,
            latest: 0.0,
            instant: 0.0,
            square_integral: 0.0,
            duration: 0.0,
        }
    }

    pub(super) fn is(&self, vehicle: usize, window: f64) -> bool {
        (self.vehicle, self.window) == (vehicle, window)
    }

    pub(super) fn observe(&mut self, step: &Step) {
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

    /// Whether any time was observed.
    pub fn is_known(&self) -> bool {
        self.duration > 0.0
    }

    /// Root mean square, m/s³.
    pub fn root_mean_square(&self) -> f64 {
        (self.square_integral / self.duration).sqrt()
    }
}
