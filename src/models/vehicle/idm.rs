//! The intelligent driver model: cruising at a wanted speed, and keeping behind vehicles ahead in the lane.

use super::red_light;
use sim::Observation;

/// Where its constants come from.
pub(super) const IDM: &str = "Treiber & Kesting, Traffic Flow Dynamics (2013), table 11.2, city traffic";

/// Wanted time gap (s) and wanted gap at standstill (m) of that table.
pub(super) const CITY: (f64, f64) = (1.0, 2.0);

/// The model with its constants, SI units.
pub(super) struct Idm {
    /// Wanted time gap, s.
    pub headway: f64,
    /// Wanted gap at standstill, m.
    pub minimum_gap: f64,
    /// From standstill on a free road, m/s².
    pub acceleration: f64,
    /// Comfortable deceleration, m/s².
    pub deceleration: f64,
    /// How late the acceleration fades as the wanted speed is reached.
    pub exponent: f64,
}

impl Idm {
    /// One that keeps the gaps of city traffic, for controllers that cruise by a law of their own.
    pub fn behind_others(acceleration: f64, deceleration: f64) -> Self {
        let (headway, minimum_gap) = CITY;
        Self { headway, minimum_gap, acceleration, deceleration, exponent: 4.0 }
    }

    /// The model's acceleration, m/s².
    pub fn cruise(&self, observation: &Observation) -> f64 {
        let ego = &observation.ego;
        let wanted = observation.cruise_speed;
        let free = if wanted > 0.0 { libm::pow(ego.speed / wanted, self.exponent) } else { 1.0 };
        self.acceleration * (1.0 - free - self.interactions(observation).fold(0.0, f64::max))
    }

    /// The largest acceleration (m/s²) that vehicles ahead in the lane leave a controller that cruises by its own law; `None` with none
    /// ahead.
    ///
    /// The controller's law takes the place of the model's free road, and the smaller of both counts, as in IDM+ (Schakel, van Arem &
    /// Netten 2010).
    pub fn bound(&self, observation: &Observation) -> Option<f64> {
        let most = self.interactions(observation).reduce(f64::max)?;
        Some((self.acceleration * (1.0 - most)).max(-red_light::HARDEST))
    }

    /// What each vehicle ahead in the lane takes from the acceleration, as a share of the largest.
    fn interactions(&self, observation: &Observation) -> impl Iterator<Item = f64> {
        let ego = &observation.ego;
        let in_lane = observation
            .vehicles
            .iter()
            .filter(|other| other.position.y.abs() < (ego.width + other.width) / 2.0);
        in_lane.filter(|other| other.position.x > 0.0).map(|other| {
            let gap = other.position.x - (ego.length + other.length) / 2.0;
            self.interaction(ego.speed, other.velocity.x, gap)
        })
    }

    /// What a vehicle at speed `other` (m/s), `gap` m ahead, takes from the acceleration, as a share of the largest.
    fn interaction(&self, own: f64, other: f64, gap: f64) -> f64 {
        let approach = own * (own - other) / (2.0 * (self.acceleration * self.deceleration).sqrt());
        let wish = self.minimum_gap + (own * self.headway + approach).max(0.0);
        let ratio = wish / gap.max(0.1);
        ratio * ratio
    }

    /// The acceleration behind a vehicle that stands at the stop line, `gap` m ahead (m/s²), but never harder than it takes to stop there
    /// or than is comfortable: the model itself brakes too hard for what stands up at once before it.
    pub fn behind_line(&self, speed: f64, gap: f64) -> f64 {
        let hardest = red_light::needed(speed, gap).clamp(self.deceleration, red_light::HARDEST);
        (self.acceleration * (1.0 - self.interaction(speed, 0.0, gap))).max(-hardest)
    }
}
