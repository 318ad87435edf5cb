//! How controllers stop before a signal: one rule for whether, from which each brakes by its own law.
//!
//! A driver who sees amber or red goes on for a reaction time and then stops if that takes at most a deceleration, else drives through. That
//! is what signals are timed for: a yellow of t + v / (2 a) lets everybody pass who cannot stop with a after t.

use super::ControllerContext;
use super::hazard::TIE;
use scenario::{SignalConduct, SignalState};
use sim::Observation;

/// Reaction and deceleration that yellow is timed for: ITE, Determining Vehicle Signal Change and Clearance Intervals (1994), 1 s and
/// 10 ft/s² (remembered).
pub const REACTION: f64 = 1.0;
pub const DECELERATION: f64 = 3.048;

/// Deceleration from which on whoever stops brakes, m/s²: that of `yielding`.
pub const COMFORTABLE: f64 = 2.0;

/// Hardest braking for a signal, m/s²: a dry road.
pub const HARDEST: f64 = 7.0;

/// How far before the stop line it comes to stand, m; free choice.
const BEFORE_THE_LINE: f64 = 0.5;

/// A vehicle this slow (m/s) stops wherever it is before the crossing.
const CRAWLING: f64 = 0.5;

/// Absorbs the rounding of summed times, s.
const TIME_TOLERANCE: f64 = 1e-9;

/// Of controllers that look at nothing but their own speed or script.
pub const LOOKS_AT_NOTHING: SignalConduct = SignalConduct::Never {
    cure: "take a controller that does, such as `idm_aeb` or `yielding`, or leave `obeys signals` out",
};

/// Whether a vehicle stops for its signal.
pub struct RedLight {
    /// s
    reaction: f64,
    /// m/s²
    deceleration: f64,
    /// Since when it has seen no green, s.
    since: Option<f64>,
    stops: bool,
    brakes: bool,
}

impl RedLight {
    /// Who reacts after `reaction` s and stops where that takes at most `deceleration` m/s²; `None` of who ignores signals.
    pub fn new(context: &ControllerContext, reaction: f64, deceleration: f64) -> Option<Self> {
        context.setup.obeys_signals.then_some(Self {
            reaction,
            deceleration,
            since: None,
            stops: false,
            brakes: false,
        })
    }

    /// From the front to the stop line, m, if the vehicle is to stop before it now.
    pub fn gap(&mut self, observation: &Observation) -> Option<f64> {
        let signal = observation.road.signal.filter(|signal| signal.state != SignalState::Green);
        let Some(signal) = signal else {
            (self.since, self.stops, self.brakes) = (None, false, false);
            return None;
        };
        let ego = &observation.ego;
        let edge = ego.distance_to_crossing - ego.length / 2.0 - observation.road.crossing_width / 2.0;
        let gap = edge - signal.stop_line;
        let seen_for = observation.time - *self.since.get_or_insert(observation.time);
        if !self.stops && seen_for >= self.reaction - TIME_TOLERANCE {
            let in_time = gap > 0.0 && ego.speed * ego.speed <= 2.0 * self.deceleration * gap + TIE;
            // Past the line it clears the crossing, unless it crawls before it or stands there.
            self.stops = in_time || ego.speed <= CRAWLING && edge > 0.0;
        }
        self.stops.then_some(gap)
    }

    /// The deceleration (m/s²) with which it stops now, evenly from where it takes [`COMFORTABLE`] on; `None` while it need not brake.
    pub fn braking(&mut self, observation: &Observation) -> Option<f64> {
        let gap = self.gap(observation)?;
        let needed = needed(observation.ego.speed, gap);
        self.brakes |= needed >= COMFORTABLE - TIE;
        self.brakes.then(|| needed.clamp(COMFORTABLE, HARDEST))
    }
}

/// The even deceleration that stops a vehicle a little before the line, m/s²; infinite beyond it.
pub fn needed(speed: f64, gap: f64) -> f64 {
    if speed == 0.0 {
        return 0.0;
    }
    if gap <= 0.0 {
        return f64::INFINITY;
    }
    speed * speed / (2.0 * (gap - BEFORE_THE_LINE).max(gap / 2.0))
}

/// Whether a vehicle with this speed (m/s) stands.
pub fn stands(speed: f64) -> bool {
    /// As metrics take it, m/s.
    const STANDING: f64 = 0.1;
    speed <= STANDING
}

/// What a vehicle that stops for its signal is up to.
pub fn mode(stands: bool) -> &'static str {
    if stands { "waiting_at_red" } else { "stopping_at_red" }
}
