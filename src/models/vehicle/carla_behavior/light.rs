//! The agent's test for a red light: one that it is near enough to stops it until it shows something else.

use scenario::{Settings, SignalState};
use sim::Observation;

/// From the vehicle's centre to the light's trigger, m (`_base_tlight_threshold` of basic_agent.py).
const THRESHOLD: f64 = 5.0;

/// Deceleration (m/s²) for which the trigger is put before the line, unless it is stock; free choice, less than its emergency brake gives
/// the measured cars.
const DECELERATION: f64 = 2.0;

/// Whether a light affects the agent.
pub struct LightTest {
    /// The trigger is at the stop line, however long it takes to stop.
    is_stock: bool,
    affected: bool,
    /// From the front to the stop line at the decision before, m.
    before: Option<f64>,
}

impl LightTest {
    pub fn from_settings(settings: &Settings) -> Self {
        Self { is_stock: settings.word("obstacle_distance") == "stock", affected: false, before: None }
    }

    /// Whether it stands on its brake for the light. It looks at red alone, not at amber, and at no light whose trigger it has passed.
    pub fn stops(&mut self, observation: &Observation) -> bool {
        let ego = &observation.ego;
        let edge = ego.distance_to_crossing - ego.length / 2.0 - observation.road.crossing_width / 2.0;
        let signal = observation.road.signal;
        let gap = edge - signal.map_or(0.0, |signal| signal.stop_line);
        // A vehicle that drives towards the trigger is at it within a decision.
        let driven = self.before.replace(gap).map_or(0.0, |before| (before - gap).max(0.0));
        if signal.is_none_or(|signal| signal.state != SignalState::Red) {
            self.affected = false;
            return false;
        }
        let affects = if self.is_stock {
            let to_trigger = gap + ego.length / 2.0;
            (0.0..THRESHOLD).contains(&to_trigger)
        } else {
            // It brakes one decision early rather than late.
            let needed = ego.speed * ego.speed / (2.0 * DECELERATION);
            gap >= needed && gap <= needed + 2.0 * driven || gap > 0.0 && ego.speed <= STANDS
        };
        self.affected |= affects;
        self.affected
    }
}

/// Who stands before the line stays there, m/s.
const STANDS: f64 = 0.1;
