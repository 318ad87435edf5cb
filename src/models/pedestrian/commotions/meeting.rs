//! A pedestrian and a vehicle meeting on crossing paths, without a world around them (§1, §2): what calibration and
//! the comparison with experiments run by the thousand.

use super::agent::{AgentEncounter, CommotionsAgent, Rules};
use super::parameters::Parameters;
use super::state::{AgentBody, Control, State};
use super::variant::Variant;
use sim::random::{self, Purpose};

/// The pedestrian of the reference sizes: 0.8 m × 0.8 m, against a vehicle 4.2 m long and 1.8 m wide.
pub const PEDESTRIAN: AgentBody =
    AgentBody { control: Control::Speed, half_extent: 1.3, cosine: 0.0, width: 0.8 };

/// The vehicle of the reference sizes.
pub const VEHICLE: AgentBody =
    AgentBody { control: Control::Acceleration, half_extent: 2.5, cosine: 0.0, width: 1.8 };

/// Who drives.
#[derive(Clone, Debug, PartialEq)]
pub enum MetDriver {
    /// A COMMOTIONS agent with the pedestrian's parameters.
    Commotions,
    /// Nobody: the acceleration (m/s²) follows a timetable of (from time in s, acceleration), 0 before the first.
    Timetable(Vec<(f64, f64)>),
}

/// What keeps a pedestrian from entering until a moment (s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Waiting {
    /// Entering is worth nothing, as published (§7).
    Inhibited(f64),
    /// It stands and looks: it takes no action, and none gathers evidence.
    Looking(f64),
}

/// What happens between whom.
#[derive(Clone, Debug, PartialEq)]
pub struct Meeting {
    /// The pedestrian's distance to the conflict point (m) and speed (m/s) at the start.
    pub pedestrian: (f64, f64),
    /// The vehicle's.
    pub vehicle: (f64, f64),
    /// Who drives it.
    pub driver: MetDriver,
    /// Whether the pedestrian has priority.
    pub pedestrian_priority: bool,
    /// What keeps the pedestrian from entering at first.
    pub waiting: Waiting,
    /// Time step (s).
    pub dt: f64,
    /// When it ends (s).
    pub end_time: f64,
}

/// The two at one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// s.
    pub time: f64,
    /// The pedestrian.
    pub pedestrian: State,
    /// The vehicle.
    pub vehicle: State,
}

impl Moment {
    /// Whether both are in the conflict space.
    pub fn collides(&self) -> bool {
        PEDESTRIAN.occupies(self.pedestrian.distance) && VEHICLE.occupies(self.vehicle.distance)
    }
}

impl Meeting {
    /// Lets an individual of a variant go through the meeting, showing every step to `observe` until it has seen
    /// enough and says `false`. The noise is decided by `seed`.
    pub fn run(
        &self,
        variant: &Variant,
        individual: &Parameters,
        seed: u64,
        mut observe: impl FnMut(&Moment) -> bool,
    ) {
        let dt = self.dt;
        let mut walker = CommotionsAgent::new(
            variant,
            individual,
            &AgentEncounter { own: PEDESTRIAN, other: VEHICLE, dt },
        );
        let mut walkers_draws = random::stream(seed, random::Agent::Pedestrian(0), Purpose::Perception);
        let mut driver = (self.driver == MetDriver::Commotions).then(|| {
            CommotionsAgent::new(variant, individual, &AgentEncounter { own: VEHICLE, other: PEDESTRIAN, dt })
        });
        let mut drivers_draws = random::stream(seed, random::Agent::Vehicle(0), Purpose::Perception);
        let start = |(distance, speed)| State { distance, speed, acceleration: 0.0 };
        let (mut pedestrian, mut vehicle) = (start(self.pedestrian), start(self.vehicle));
        for k in 0..(self.end_time / dt - 1e-9).ceil() as usize {
            let time = k as f64 * dt;
            if k > 0 {
                pedestrian = pedestrian.step(dt);
                vehicle = vehicle.step(dt);
            }
            if !observe(&Moment { time, pedestrian, vehicle }) {
                return;
            }
            let (inhibited, looks) = match self.waiting {
                Waiting::Inhibited(until) => (time < until, false),
                Waiting::Looking(until) => (false, time < until),
            };
            let rules = Rules { pedestrian_priority: self.pedestrian_priority, entry_inhibited: inhibited };
            let walks = if looks {
                walker.look(&pedestrian, &vehicle, &rules, &mut walkers_draws);
                0.0
            } else {
                walker.step(&pedestrian, &vehicle, &rules, &mut walkers_draws).acceleration
            };
            vehicle.acceleration = match &mut driver {
                Some(driver) => driver.step(&vehicle, &pedestrian, &rules, &mut drivers_draws).acceleration,
                None => self.timetabled(time),
            };
            pedestrian.acceleration = walks;
        }
    }

    fn timetabled(&self, time: f64) -> f64 {
        match &self.driver {
            MetDriver::Commotions => 0.0,
            // A step that falls on an entry but for rounding has reached it.
            MetDriver::Timetable(entries) => entries
                .iter()
                .rev()
                .find(|&&(from, _)| from <= time + 1e-9)
                .map_or(0.0, |&(_, acceleration)| acceleration),
        }
    }
}
