//! The planned speed profile: jerk-limited cruise, and one factor that exceeds the limits where a stop needs it (§5.4).
//!
//! It stands in for a quadratic programme with soft limits. One factor on acceleration and jerk keeps the two
//! properties that matter: the normal limits when they suffice, a gradual joint overrun when they do not.

use super::braking::{BrakingLimits, stopping_distance};
use scenario::Settings;

/// Below this share of the engage speed the ego starts from standstill (engage_exit_ratio).
const ENGAGE_EXIT_RATIO: f64 = 0.5;

/// Nearer to a stop than this a standing ego does not start, m (stop_dist_to_prohibit_engage).
const NO_ENGAGE_WITHIN: f64 = 0.5;

/// Halvings in the search for the smallest factor.
const BISECTIONS: usize = 30;

#[derive(Debug, Clone, Copy)]
pub struct ProfileConstants {
    period: f64,
    acceleration: f64,
    braking: BrakingLimits,
    engage: ProfileReference,
}

/// A planned speed (m/s) and acceleration (m/s²).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ProfileReference {
    pub speed: f64,
    pub acceleration: f64,
}

/// A stop that the profile is to end at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopPoint {
    /// From the bumper, m; negative once past it.
    pub distance: f64,
    /// Greatest factor on the normal limits.
    pub cap: f64,
    /// Whether the stop moves away from an ego that the cap keeps from reaching it.
    pub gives_way: bool,
}

/// The plan of the last tick.
pub struct Profile {
    constants: ProfileConstants,
    /// One reference per planning period, from the time of the plan on; never empty.
    states: Vec<ProfileReference>,
    /// From the bumper at the time of the plan to the end of the profile, m.
    stop: Option<f64>,
}

impl ProfileConstants {
    pub fn new(settings: &Settings) -> Self {
        Self {
            period: settings.number("planning_period"),
            acceleration: settings.number("normal_acceleration"),
            braking: BrakingLimits {
                deceleration: settings.number("normal_deceleration"),
                negative_jerk: settings.number("normal_negative_jerk"),
                positive_jerk: settings.number("normal_positive_jerk"),
            },
            engage: ProfileReference {
                speed: settings.number("engage_speed"),
                acceleration: settings.number("engage_acceleration"),
            },
        }
    }

    /// The factor that planned decelerations of up to `deceleration` m/s² allow.
    pub fn cap(&self, deceleration: f64) -> f64 {
        (deceleration / self.braking.deceleration).max(1.0)
    }
}

impl Profile {
    /// Starts from steady cruise. `ahead`: how far beyond one period the plan is read, s.
    pub fn new(constants: ProfileConstants, speed: f64, ahead: f64) -> Self {
        let ticks = (1.0 + ahead / constants.period).ceil() as usize + 1;
        let cruise = ProfileReference { speed, acceleration: 0.0 };
        Self { constants, states: vec![cruise; ticks + 1], stop: None }
    }

    /// Follows a motion that others command.
    pub fn follow(&mut self, speed: f64, acceleration: f64) {
        self.states.fill(ProfileReference { speed, acceleration });
        self.stop = None;
    }

    /// One tick: takes up the last plan and plans on, to `cruise` m/s or to a stop. `speed` is what the ego drives.
    pub fn plan(&mut self, speed: f64, cruise: f64, stop: Option<StopPoint>) {
        let mut state = self.states[1];
        let free = stop.is_none_or(|stop| stop.distance > NO_ENGAGE_WITHIN);
        if free && speed < ENGAGE_EXIT_RATIO * self.constants.engage.speed {
            state = self.constants.engage;
        }
        let stop = stop.map(|stop| stop.reachable(state, self.constants.braking));
        self.stop = stop.map(|stop| stop.distance);
        let mut left = stop;
        for planned in &mut self.states {
            *planned = state;
            state = self.constants.advance(state, cruise, left);
            if let Some(stop) = &mut left {
                stop.distance -= (planned.speed + state.speed) / 2.0 * self.constants.period;
            }
        }
    }

    /// What is planned `time` s after the plan was made.
    pub fn at(&self, time: f64) -> ProfileReference {
        let place = (time / self.constants.period).clamp(0.0, (self.states.len() - 1) as f64);
        let index = (place as usize).min(self.states.len() - 2);
        let (from, to, share) = (self.states[index], self.states[index + 1], place - index as f64);
        ProfileReference {
            speed: from.speed + (to.speed - from.speed) * share,
            acceleration: from.acceleration + (to.acceleration - from.acceleration) * share,
        }
    }

    /// Distance from the bumper at the time of the plan to where it ends, m.
    pub fn stop(&self) -> Option<f64> {
        self.stop
    }

    /// Whether it brakes for its stop at present.
    pub fn brakes(&self) -> bool {
        self.stop.is_some() && self.states[1].acceleration < 0.0
    }
}

impl StopPoint {
    /// Moved out to where the cap lets the ego stop, if it gives way.
    fn reachable(self, state: ProfileReference, braking: BrakingLimits) -> Self {
        if !self.gives_way {
            return self;
        }
        let shortest = stopping_distance(state.speed, state.acceleration, braking.scaled(self.cap));
        Self { distance: self.distance.max(shortest), ..self }
    }
}

impl ProfileConstants {
    /// The planned state one period later.
    fn advance(&self, state: ProfileReference, cruise: f64, stop: Option<StopPoint>) -> ProfileReference {
        let Some(stop) = stop else { return self.approach(state, cruise) };
        if state.speed <= 0.0 && stop.distance < NO_ENGAGE_WITHIN {
            return ProfileReference::default();
        }
        let needed =
            |factor: f64| stopping_distance(state.speed, state.acceleration, self.braking.scaled(factor));
        if needed(1.0) < stop.distance - state.speed * self.period {
            return self.approach(state, cruise);
        }
        self.brake(state, smallest_factor(stop.cap, |factor| needed(factor) <= stop.distance))
    }

    /// Towards a speed to cruise at, so that the acceleration ends at zero when it is reached.
    fn approach(&self, state: ProfileReference, cruise: f64) -> ProfileReference {
        let ProfileReference { speed, acceleration } = state;
        let dt = self.period;
        let BrakingLimits { deceleration, negative_jerk, positive_jerk } = self.braking;
        // The acceleration after this period from which a release ends just at the speed to cruise at.
        let missing = cruise - speed - acceleration * dt / 2.0;
        let release = if missing > 0.0 { negative_jerk } else { positive_jerk };
        let ramp = release * dt / 2.0;
        let wanted = ((ramp * ramp + 2.0 * release * missing.abs()).sqrt() - ramp).copysign(missing);
        let next = wanted
            .clamp(-deceleration, self.acceleration)
            .clamp(acceleration - negative_jerk * dt, acceleration + positive_jerk * dt);
        ProfileReference { speed: (speed + (acceleration + next) / 2.0 * dt).max(0.0), acceleration: next }
    }

    /// Towards a stop with the normal limits times `factor`.
    fn brake(&self, state: ProfileReference, factor: f64) -> ProfileReference {
        let ProfileReference { speed, acceleration } = state;
        let dt = self.period;
        let limits = self.braking.scaled(factor);
        if acceleration < 0.0 && speed <= acceleration * acceleration / (2.0 * limits.positive_jerk) {
            // Release so that speed and acceleration vanish together.
            if 2.0 * speed <= -acceleration * dt {
                return ProfileReference::default();
            }
            let jerk = acceleration * acceleration / (2.0 * speed);
            return ProfileReference {
                speed: speed + dt * (acceleration + dt * jerk / 2.0),
                acceleration: acceleration + jerk * dt,
            };
        }
        let next = (-limits.deceleration)
            .clamp(acceleration - limits.negative_jerk * dt, acceleration + limits.positive_jerk * dt);
        let after = speed + (acceleration + next) / 2.0 * dt;
        if after <= 0.0 {
            ProfileReference::default()
        } else {
            ProfileReference { speed: after, acceleration: next }
        }
    }
}

/// The smallest factor in 1..=cap that suffices; `cap` if none does.
fn smallest_factor(cap: f64, suffices: impl Fn(f64) -> bool) -> f64 {
    if suffices(1.0) {
        return 1.0;
    }
    if !suffices(cap) {
        return cap;
    }
    let (mut low, mut high) = (1.0, cap);
    for _ in 0..BISECTIONS {
        let middle = (low + high) / 2.0;
        if suffices(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::autoware::autoware;

    const CRUISE: f64 = 30.0 / 3.6;

    fn profile(speed: f64) -> Profile {
        let settings = autoware().declaration.resolve(&Settings::default()).unwrap();
        Profile::new(ProfileConstants::new(&settings), speed, 0.1)
    }

    /// Drives exactly as planned: (travelled, reference) per tick.
    fn driven(
        profile: &mut Profile,
        ticks: usize,
        stop: impl Fn(f64) -> Option<StopPoint>,
    ) -> Vec<(f64, ProfileReference)> {
        let mut travelled = 0.0;
        let mut now = profile.at(0.1);
        (0..ticks)
            .map(|_| {
                profile.plan(now.speed, CRUISE, stop(travelled));
                let (from, to) = (profile.at(0.0), profile.at(0.1));
                travelled += (from.speed + to.speed) / 2.0 * 0.1;
                now = to;
                (travelled, to)
            })
            .collect()
    }

    fn stop_at(place: f64, cap: f64) -> impl Fn(f64) -> Option<StopPoint> {
        move |travelled| Some(StopPoint { distance: place - travelled, cap, gives_way: false })
    }

    #[test]
    fn cruise_is_steady() {
        assert!(driven(&mut profile(CRUISE), 50, |_| None).iter().all(|(_, state)| state.speed == CRUISE));
    }

    #[test]
    fn accelerates_within_limits_and_arrives_smoothly() {
        let states = driven(&mut profile(0.0), 200, |_| None);
        let mut before = ProfileReference { speed: 0.25, acceleration: 0.5 };
        for (_, state) in &states {
            // The last release of less than a period overshoots by at most jerk * period² / 8.
            assert!(state.acceleration <= 1.0 + 1e-12 && state.speed <= CRUISE + 0.00125, "{state:?}");
            assert!((state.acceleration - before.acceleration).abs() <= 0.1 + 1e-9);
            before = *state;
        }
        assert!((before.speed - CRUISE).abs() < 1e-3 && before.acceleration.abs() < 1e-3);
    }

    #[test]
    fn a_far_stop_is_made_with_the_normal_limits() {
        let states = driven(&mut profile(CRUISE), 300, stop_at(60.0, 5.0));
        let strongest = states.iter().map(|(_, state)| state.acceleration).fold(0.0, f64::min);
        let (end, last) = states[states.len() - 1];
        assert_eq!(last.speed, 0.0);
        assert!((end - 60.0).abs() < 0.3, "{end}");
        assert!((-1.05..=-0.95).contains(&strongest), "{strongest}");
    }

    #[test]
    fn a_near_stop_takes_the_factor_it_needs_and_no_more_than_the_cap() {
        // k = 2 stops in v/2 (v/2 + 1) = 21.5 m.
        let needed = CRUISE / 2.0 * (CRUISE / 2.0 + 1.0);
        let states = driven(&mut profile(CRUISE), 100, stop_at(needed, 5.0));
        let strongest = states.iter().map(|(_, state)| state.acceleration).fold(0.0, f64::min);
        assert!((strongest + 2.0).abs() < 0.1, "{strongest}");
        assert!((states[99].0 - needed).abs() < 0.3, "{}", states[99].0);

        let states = driven(&mut profile(CRUISE), 100, stop_at(10.0, 2.5));
        let strongest = states.iter().map(|(_, state)| state.acceleration).fold(0.0, f64::min);
        assert_eq!(strongest, -2.5);
        assert!(states[99].0 > 15.0 && states[99].1.speed == 0.0);
    }

    #[test]
    fn a_stop_that_gives_way_lies_where_the_cap_ends() {
        let mut profile = profile(CRUISE);
        profile.plan(CRUISE, CRUISE, Some(StopPoint { distance: 10.0, cap: 2.5, gives_way: true }));
        let expected = CRUISE / 2.0 * (CRUISE / 2.5 + 1.0);
        assert!((profile.stop().unwrap() - expected).abs() < 1e-9);
    }

    #[test]
    fn stands_within_half_a_metre_of_the_stop_and_starts_beyond() {
        let near = driven(&mut profile(0.0), 50, stop_at(0.45, 5.0));
        assert_eq!(near[49].0, 0.0);
        let far = driven(&mut profile(0.0), 100, stop_at(3.0, 5.0));
        assert!((far[99].0 - 3.0).abs() < 0.55, "{}", far[99].0);
        assert_eq!(far[99].1.speed, 0.0);
    }
}
