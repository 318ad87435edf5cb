//! Where the crosswalk module wants the bumper to stop, and when it rather drives on (§1.5).

use super::braking::{BrakingLimits, stopping_distance};
use super::decision::STANDING;
use super::site::{Ego, Site};
use scenario::Settings;

/// Release jerk assumed in the module's braking distances, m/s³.
const RELEASE_JERK: f64 = 10.0;

/// Share of the old stop position that is kept per cycle.
const SMOOTHING: f64 = 0.9;

/// Below this speed the stop for a pedestrian stays where it is, m/s.
const FROZEN_BELOW: f64 = 1.0;

/// A new stop up to this much farther than the last one is not taken, m.
const KEPT_WITHIN: f64 = 1.0;

/// A standing ego between these distances from its stop does not creep up to it, m (restart suppression).
const NO_CREEP: (f64, f64) = (0.5, 1.0);

#[derive(Debug, Clone, Copy)]
pub struct StopConstants {
    from_crosswalk: f64,
    from_object: f64,
    from_crosswalk_limit: f64,
    preferred: BrakingLimits,
    no_stop: Option<BrakingLimits>,
}

/// The stop for the crosswalk, kept from cycle to cycle.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CrosswalkStop {
    /// Low-passed stop for the nearest pedestrian, s in m.
    for_object: Option<f64>,
    /// The stop of the cycle before, s in m.
    last: Option<f64>,
}

impl StopConstants {
    pub fn new(settings: &Settings) -> Self {
        let limits = |kind: &str| BrakingLimits {
            deceleration: settings.number(&format!("{kind}_deceleration")),
            negative_jerk: settings.number(&format!("{kind}_jerk")),
            positive_jerk: RELEASE_JERK,
        };
        Self {
            from_crosswalk: settings.number("stop_distance_from_crosswalk"),
            from_object: settings.number("stop_distance_from_object"),
            from_crosswalk_limit: settings.number("stop_distance_from_crosswalk_limit"),
            preferred: limits("preferred"),
            no_stop: settings.flag("no_stop_enabled").then(|| limits("no_stop")),
        }
    }

    /// s of the stop before the crosswalk, m.
    pub fn default_stop(&self, site: &Site) -> f64 {
        -site.half_width - self.from_crosswalk
    }
}

impl CrosswalkStop {
    /// Nobody to stop for in this cycle.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Where to stop (s in m) for the nearest collision point at `place` (s in m); `None` if it drives on.
    pub fn update(&mut self, place: f64, ego: &Ego, site: &Site, constants: &StopConstants) -> Option<f64> {
        let wanted = place - constants.from_object;
        let for_object = match self.for_object {
            Some(before) if wanted > before => {
                if ego.speed < FROZEN_BELOW {
                    before
                } else {
                    SMOOTHING * before + (1.0 - SMOOTHING) * wanted
                }
            }
            _ => wanted,
        };
        self.for_object = Some(for_object);
        let stop = constants.select(for_object, ego, site);
        let distance = stop - ego.front;
        let too_late = constants
            .no_stop
            .is_some_and(|limits| distance.max(0.1) < stopping_distance(ego.speed, ego.acceleration, limits));
        if too_late {
            self.last = None;
            return None;
        }
        let mut stop = match self.last {
            Some(last) if stop > last && stop <= last + KEPT_WITHIN => last,
            _ => stop,
        };
        let (near, far) = NO_CREEP;
        if ego.speed < STANDING && (near..far).contains(&(stop - ego.front)) {
            stop = ego.front;
        }
        self.last = Some(stop);
        self.last
    }
}

impl StopConstants {
    /// The preferred stop, or where weak braking ends, or the last acceptable stop; s in m.
    fn select(&self, for_object: f64, ego: &Ego, site: &Site) -> f64 {
        let preferred = self.default_stop(site).min(for_object);
        let limit = -site.half_width - self.from_crosswalk_limit;
        let weak = ego.front + stopping_distance(ego.speed, ego.acceleration, self.preferred);
        if weak < preferred {
            preferred
        } else if weak < limit {
            weak
        } else {
            limit
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::site::tests::{SITE, ego};
    use super::*;
    use crate::vehicle::autoware::autoware;

    const CRUISE: f64 = 30.0 / 3.6;

    fn constants() -> StopConstants {
        StopConstants::new(&autoware().declaration.resolve(&Settings::default()).unwrap())
    }

    /// The stop for somebody first seen when the bumper is this far from the near edge.
    fn first_seen_at(gap: f64) -> Option<f64> {
        CrosswalkStop::default().update(0.0, &ego(-2.0 - gap, CRUISE), &SITE, &constants())
    }

    #[test]
    fn stops_at_the_3_5_m_line_then_where_weak_braking_ends_then_at_the_limit_then_not_at_all() {
        assert_eq!(first_seen_at(60.0), Some(-5.5));
        // Weak braking needs 33.05 m.
        assert_eq!(first_seen_at(36.6), Some(-5.5));
        let between = first_seen_at(36.3).unwrap();
        assert!(between > -5.5 && between < -5.0, "{between}");
        assert_eq!(first_seen_at(35.0), Some(-5.0));
        // Strong braking needs 27.3 m up to the 3.0 m limit: 30.3 m.
        assert_eq!(first_seen_at(30.4), Some(-5.0));
        assert_eq!(first_seen_at(30.2), None);
        let latest =
            (0..4000).map(|k| f64::from(k) * 0.01).find(|&gap| first_seen_at(gap).is_some()).unwrap();
        assert!((latest - 30.3).abs() < 0.05, "{latest}");
        // About 3.9 s before the bumper is at the middle of the crossing.
        assert!(((latest + 2.0) / CRUISE - 3.9).abs() < 0.05);
    }

    #[test]
    fn a_pedestrian_before_the_crosswalk_moves_the_stop_and_leaves_it_slowly() {
        let mut stop = CrosswalkStop::default();
        let here = ego(-60.0, CRUISE);
        assert_eq!(stop.update(-3.5, &here, &SITE, &constants()), Some(-6.5));
        // The filter goes a tenth of the way to -3.0, but up to 1 m farther the old stop is kept.
        assert_eq!(stop.update(0.0, &here, &SITE, &constants()), Some(-6.5));
        assert!((stop.for_object.unwrap() - (-6.15)).abs() < 1e-12);
        assert_eq!(stop.update(-3.8, &here, &SITE, &constants()), Some(-6.8));
        let slow = ego(-8.0, 0.9);
        stop.update(0.0, &slow, &SITE, &constants());
        assert_eq!(stop.for_object, Some(-6.8));
    }

    #[test]
    fn a_standing_ego_does_not_creep() {
        let mut stop = CrosswalkStop::default();
        assert_eq!(stop.update(0.0, &ego(-6.2, 0.0), &SITE, &constants()), Some(-6.2));
        let mut stop = CrosswalkStop::default();
        assert_eq!(stop.update(0.0, &ego(-7.0, 0.0), &SITE, &constants()), Some(-5.5));
    }
}
