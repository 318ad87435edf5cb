//! When a controller decides: at moments of its own, whatever the simulation step.

/// Absorbs the rounding of products and quotients of times, s.
const TOLERANCE: f64 = 1e-9;

/// The moments at which a controller is asked; its command is held in between.
///
/// They are counted from the start of the run (or of settling before it) and depend on no simulation step: a step
/// that is longer than the time between two of them is divided where they lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Schedule {
    /// s
    period: f64,
    /// s; 0 where any moment will do.
    tick: f64,
}

impl Schedule {
    /// Every `period` s.
    pub fn every(period: f64) -> Self {
        Self { period, tick: 0.0 }
    }

    /// Every `period` s, put off to the next tick of a vehicle that takes commands every `tick` s only.
    pub fn on_ticks(period: f64, tick: f64) -> Self {
        Self { period: period.max(tick), tick }
    }

    /// The moment of decision number `number`, counted from 0, s.
    pub fn moment(&self, number: u64) -> f64 {
        let wanted = number as f64 * self.period;
        if self.tick == 0.0 { wanted } else { ((wanted - TOLERANCE) / self.tick).ceil().max(0.0) * self.tick }
    }

    /// The shortest time between two moments, s.
    pub fn shortest(&self) -> f64 {
        if self.tick == 0.0 { self.period } else { self.tick }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_period_and_on_the_vehicles_ticks() {
        let moments = |schedule: Schedule| -> Vec<f64> { (0..6).map(|k| schedule.moment(k)).collect() };
        assert_eq!(moments(Schedule::every(0.5)), [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]);
        // 33 Hz on a vehicle of 40 Hz: 0, 30, 60, 90, 120, 150 ms.
        let in_ticks: Vec<_> =
            moments(Schedule::on_ticks(0.03, 0.025)).iter().map(|moment| (moment / 0.025).round()).collect();
        assert_eq!(in_ticks, [0.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        // Nobody is asked twice within a tick.
        assert_eq!(moments(Schedule::on_ticks(0.01, 0.5)), [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]);
    }

    #[test]
    fn moments_rise_and_are_never_closer_than_the_shortest() {
        for (period, tick) in [(0.03, 0.025), (0.05, 0.025), (0.0234, 0.01), (0.1, 0.1), (0.007, 0.0)] {
            let schedule =
                if tick == 0.0 { Schedule::every(period) } else { Schedule::on_ticks(period, tick) };
            for k in 0..10_000 {
                let gap = schedule.moment(k + 1) - schedule.moment(k);
                assert!(gap > schedule.shortest() - 1e-9, "{period} {tick} {k}: {gap}");
                assert!(schedule.moment(k) > k as f64 * period - 1e-8);
            }
        }
    }
}
