//! How hard a vehicle brakes: the drop of its realised speed over a sliding window.

use super::events::lerp;
use super::sliding::Sliding;
use crate::Step;

/// The drops of one vehicle's speed over a window; those below standstill do not count.
#[derive(Debug, Clone)]
pub struct SpeedDrop {
    vehicle: usize,
    window: f64,
    standstill: f64,
    speeds: Sliding<1>,
    /// m/s over one window; `None` before the first step.
    largest: Option<f64>,
    /// The same in the last step.
    latest: Option<f64>,
    /// At the end of the window in which that was, s; `None` if the vehicle never slowed down.
    pub instant: Option<f64>,
}

impl SpeedDrop {
    /// Over windows of so many seconds, where speeds below `standstill` (m/s) count as that; steps are mostly `step` s.
    pub(super) fn new(vehicle: usize, (window, standstill): (f64, f64), step: f64) -> Self {
        let speeds = Sliding::new([window], step);
        Self { vehicle, window, standstill, speeds, largest: None, latest: None, instant: None }
    }

    pub(super) fn is(&self, vehicle: usize, of: (f64, f64)) -> bool {
        self.vehicle == vehicle && (self.window, self.standstill) == of
    }

    pub(super) fn observe(&mut self, step: &Step) {
        let from = (step.time, step.before.vehicles[self.vehicle].motion.speed);
        let to = (step.time + step.duration, step.after.vehicles[self.vehicle].motion.speed);
        // Speeds below standstill count as standstill, which bends the signal where it gets there.
        let floor = self.standstill;
        let counted = |(time, speed): (f64, f64)| (time, speed.max(floor));
        self.latest = None;
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
        let mut largest = self.largest.unwrap_or(0.0);
        let mut latest = self.latest.unwrap_or(0.0);
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
        self.largest = Some(largest);
        self.latest = Some(latest);
    }

    /// The largest deceleration, m/s².
    pub fn largest(&self) -> Option<f64> {
        self.rate(self.largest)
    }

    /// The largest in the last step, m/s².
    pub fn latest(&self) -> Option<f64> {
        self.rate(self.latest)
    }

    /// A drop (m/s) over the window, m/s².
    fn rate(&self, drop: Option<f64>) -> Option<f64> {
        drop.map(|drop| (drop / self.window * 1e9).round() / 1e9)
    }
}
