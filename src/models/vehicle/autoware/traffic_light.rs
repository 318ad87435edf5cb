//! The traffic light module: whether there is a stop for the signal, decided anew in every cycle until it stops.
//!
//! Read in the pages of `autoware_behavior_velocity_traffic_light_module` (algorithm) and its tests (lamp period, stop speed); the limits of
//! the stop and the delay are those of `behavior_velocity_planner.param.yaml`, remembered.

use super::braking::{BrakingLimits, stopping_distance};
use super::site::{Ego, Site};
use scenario::SignalState;
use sim::Observation;

/// `yellow_lamp_period`, s: who is at the line within it passes where it cannot stop.
const LAMP_PERIOD: f64 = 2.75;

/// `yellow_light_stop_velocity`, m/s: who is slower stops.
const SLOW: f64 = 1.0;

/// `stop_time_hysteresis`, s: a signal to stop counts once it has been seen for so long.
const HYSTERESIS: f64 = 0.1;

/// `delay_response_time`, s.
const DELAY: f64 = 0.5;

/// From the line back to where the front is to stop, m. The module's `stop_margin` is 0 unless a configuration says more; the gentle stop
/// then ends some centimetres before or beyond the line. Free choice, that of the other controllers.
const STOP_MARGIN: f64 = 0.5;

/// `max_accel` and `max_jerk` of stops; the release ends without a jerk limit of its own.
const LIMITS: BrakingLimits = BrakingLimits { deceleration: 2.8, negative_jerk: 5.0, positive_jerk: 5.0 };

/// Absorbs the rounding of summed times, s.
const TIME_TOLERANCE: f64 = 1e-6;

/// What the module remembers.
#[derive(Debug, Clone, Copy, Default)]
pub struct TrafficLight {
    /// Since when it has seen no green, s.
    since: Option<f64>,
    stops: bool,
}

impl TrafficLight {
    /// s of the stop, m, if it stops for the signal.
    pub fn stop(&mut self, observation: &Observation, ego: &Ego, site: &Site) -> Option<f64> {
        let signal = observation.road.signal.filter(|signal| signal.state != SignalState::Green);
        let Some(signal) = signal else {
            *self = Self::default();
            return None;
        };
        let since = *self.since.get_or_insert(observation.time);
        if observation.time - since < HYSTERESIS - TIME_TOLERANCE {
            return None;
        }
        let line = -site.half_width - signal.stop_line;
        let distance = line - ego.front;
        if !self.stops {
            let needed = ego.speed * DELAY + stopping_distance(ego.speed, ego.acceleration, LIMITS);
            let can_stop = needed < distance || ego.speed < SLOW;
            let passes = !can_stop && distance < ego.speed * LAMP_PERIOD;
            // Past the line it clears the crossing, unless it crawls before it or stands there.
            self.stops = !passes && (distance > 0.0 || ego.speed < SLOW && ego.front < -site.half_width);
        }
        self.stops.then_some(line - STOP_MARGIN)
    }
}
