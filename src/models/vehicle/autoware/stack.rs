//! The whole loop: what runs at which rate, and how its parts hand over to each other (§5.5, §5.6).

use super::crossing::{Crosser, CrossingConstants};
use super::decision::{DecisionConstants, Stance, YieldingConflict, YieldingDecision, YieldingStanding};
use super::emergency_brake::EmergencyBrake;
use super::lane_stop::{LaneConstants, StopObstacle};
use super::longitudinal::{DriveState, LongitudinalController, Situation};
use super::phase::{Phase, Signs};
use super::profile::{Profile, ProfileConstants, StopPoint};
use super::site::{Ego, Site};
use super::stop_position::{CrosswalkStop, StopConstants};
use super::tracker::Tracker;
use super::traffic_light::TrafficLight;
use crate::vehicle::hazard::vehicle_ahead;
use numbers::random::Stream;
use scenario::Settings;
use sim::{Command, Controller, ControllerError, Mode, Observation, Schedule};

/// Slower than this the ego is not under way yet, m/s.
const UNDER_WAY: f64 = 0.125;

/// Absorbs the rounding of sums of periods, s.
const TOLERANCE: f64 = 1e-6;

/// Time in free flow after which speed, feedback and vehicle have settled to another speed, s.
const SETTLING: f64 = 60.0;

pub struct Stack {
    constants: Constants,
    tracker: Tracker,
    /// By the pedestrian's number.
    minds: Vec<Mind>,
    standing: YieldingStanding,
    crosswalk: CrosswalkStop,
    /// `None`: its map has no signal.
    traffic_light: Option<TrafficLight>,
    emergency_brake: EmergencyBrake,
    profile: Profile,
    longitudinal: LongitudinalController,
    phase: Phase,
    signs: Signs,
    clock: Clock,
    /// s of the end of the plan, m.
    plan_end: Option<f64>,
}

struct Constants {
    mapped: bool,
    cruise: Option<f64>,
    settling: f64,
    planning_period: f64,
    control_period: f64,
    vehicle_period: f64,
    delay_compensation: f64,
    crossing: CrossingConstants,
    decision: DecisionConstants,
    stop: StopConstants,
    lane: LaneConstants,
    /// With which the vehicle ahead is taken to brake, m/s².
    lead_deceleration: f64,
    /// Factors on the normal limits.
    crosswalk_cap: f64,
    lane_cap: f64,
    suppress_sudden_stop: bool,
    mrm_deceleration: f64,
    mrm_jerk: f64,
}

/// What the stack remembers of one pedestrian.
#[derive(Default)]
struct Mind {
    crosser: Crosser,
    decision: YieldingDecision,
    obstacle: StopObstacle,
}

#[derive(Default)]
struct Clock {
    /// First planning tick and how many there were.
    origin: Option<f64>,
    ticks: u64,
    planned_at: f64,
    controlled_at: Option<f64>,
}

impl Stack {
    /// For a vehicle that cruises at `speed` (m/s) among `pedestrians`; `misses` draws detections that fail.
    ///
    /// `map_has_signal`: whether its map has the signal of the crossing.
    pub fn new(
        settings: &Settings,
        speed: f64,
        (pedestrians, misses): (usize, Stream),
        map_has_signal: bool,
    ) -> Self {
        let profile = ProfileConstants::new(settings);
        let cruise = settings.optional_number("max_speed");
        let delay_compensation = settings.number("delay_compensation");
        let suppress_sudden_stop = settings.flag("suppress_sudden_stop");
        let hardest = profile.cap(settings.number("command_deceleration_limit"));
        let settling = match cruise {
            Some(cruise) if cruise != speed => {
                let slowest =
                    settings.number("normal_acceleration").min(settings.number("normal_deceleration"));
                SETTLING + (cruise - speed).abs() / slowest
            }
            _ => 0.0,
        };
        let constants = Constants {
            mapped: settings.flag("crosswalk_mapped"),
            cruise,
            settling,
            planning_period: settings.number("planning_period"),
            control_period: settings.number("control_period"),
            vehicle_period: settings.number("vehicle_period"),
            delay_compensation,
            crossing: CrossingConstants::new(settings),
            decision: DecisionConstants::new(settings),
            stop: StopConstants::new(settings),
            lane: LaneConstants::new(settings),
            lead_deceleration: settings.number("limit_deceleration"),
            crosswalk_cap: hardest,
            lane_cap: if suppress_sudden_stop {
                profile.cap(settings.number("limit_deceleration"))
            } else {
                hardest
            },
            suppress_sudden_stop,
            mrm_deceleration: settings.number("mrm_deceleration"),
            mrm_jerk: settings.number("mrm_jerk"),
        };
        Self {
            tracker: Tracker::new(settings, pedestrians, misses),
            minds: (0..pedestrians).map(|_| Mind::default()).collect(),
            standing: YieldingStanding::new(settings),
            crosswalk: CrosswalkStop::default(),
            traffic_light: map_has_signal.then(TrafficLight::default),
            emergency_brake: EmergencyBrake::new(settings),
            // A controller may be called late by up to one period of its own or of its vehicle's.
            profile: Profile::new(
                profile,
                speed,
                delay_compensation + constants.control_period.max(constants.vehicle_period),
            ),
            longitudinal: LongitudinalController::new(settings),
            phase: Phase::default(),
            signs: Signs::default(),
            clock: Clock::default(),
            plan_end: None,
            constants,
        }
    }

    fn is_planning_due(&mut self, time: f64) -> bool {
        let origin = *self.clock.origin.get_or_insert(time);
        let due = time >= origin + self.clock.ticks as f64 * self.constants.planning_period - TOLERANCE;
        self.clock.ticks += u64::from(due);
        due
    }

    /// One planning tick.
    fn plan(&mut self, observation: &Observation, ego: &Ego) {
        let time = observation.time;
        let site = Site::of(observation);
        self.tracker.update(time);
        self.minds.resize_with(self.tracker.len(), Mind::default);
        // While people have red the module looks at none of them.
        let people_have_red = self.traffic_light.is_some()
            && observation.road.signal.is_some()
            && !observation.road.pedestrian_priority;
        let crosswalk = self.crosswalk_stop(time, ego, &site, people_have_red);
        let light = self.traffic_light.as_mut().and_then(|module| module.stop(observation, ego, &site));
        let lane = self.lane_stop(time, ego, crosswalk);
        let lane = lane.into_iter().chain(self.stop_behind(observation, ego)).reduce(f64::min);
        let around = (0..self.tracker.len()).filter_map(|index| self.tracker.unconfirmed(index));
        let emergency = self.emergency_brake.update(time, ego, around);
        let before = crosswalk.into_iter().chain(light).reduce(f64::min);
        let stop = self.nearest(ego, before, lane);
        if emergency {
            self.profile.follow(ego.speed, ego.acceleration);
            self.plan_end = None;
        } else {
            let cruise = self.constants.cruise.unwrap_or(observation.cruise_speed);
            self.profile.plan(ego.speed, cruise, stop);
            self.plan_end = self.profile.stop().map(|distance| ego.front + distance);
        }
        self.clock.planned_at = time;
        self.signs = Signs {
            emergency,
            lane_stop: lane.is_some_and(|lane| before.is_none_or(|before| lane < before)),
            crosswalk_stop: before.is_some(),
            braking: self.profile.brakes(),
            ..Signs::default()
        };
    }

    /// The stop for the crosswalk (s in m), if somebody is yielded to.
    fn crosswalk_stop(&mut self, time: f64, ego: &Ego, site: &Site, people_have_red: bool) -> Option<f64> {
        let constants = &self.constants;
        let default_stop = constants.stop.default_stop(site);
        let ego_yields = self.standing.is_yielding(time, ego.speed, default_stop - ego.front);
        let attention = constants.crossing.attention(site);
        let mut nearest: Option<f64> = None;
        for (index, mind) in self.minds.iter_mut().enumerate() {
            let Some(target) = self.tracker.target(index) else {
                *mind = Mind::default();
                continue;
            };
            let Some(point) = mind.crosser.collision_point(&target, time, ego, site, &constants.crossing)
            else {
                continue;
            };
            let conflict =
                YieldingConflict { time, ego, site, ego_yields, target: &target, point, attention };
            mind.decision.update(&conflict, &constants.decision);
            if mind.decision.stance == Stance::Yield {
                nearest = Some(nearest.map_or(point.place, |place| place.min(point.place)));
            }
        }
        let evaluated = constants.mapped && ego.front <= attention && !people_have_red;
        match nearest.filter(|_| evaluated) {
            Some(place) => self.crosswalk.update(place, ego, site, &constants.stop),
            None => {
                self.crosswalk.clear();
                None
            }
        }
    }

    /// The nearest in-lane stop (s in m).
    fn lane_stop(&mut self, time: f64, ego: &Ego, crosswalk: Option<f64>) -> Option<f64> {
        let (tracker, lane) = (&self.tracker, &self.constants.lane);
        self.minds
            .iter_mut()
            .enumerate()
            .filter_map(|(index, mind)| {
                mind.obstacle.stop(&tracker.target(index)?, time, ego, crosswalk, lane)
            })
            .reduce(f64::min)
    }

    /// The stop behind the vehicle ahead (s in m), where that vehicle would stop if it braked now.
    fn stop_behind(&self, observation: &Observation, ego: &Ego) -> Option<f64> {
        let constants = &self.constants;
        let leads = observation.vehicles.iter().filter_map(|seen| vehicle_ahead(&observation.ego, seen));
        let way = leads.map(|ahead| {
            let speed = ahead.speed.max(0.0);
            ahead.gap + speed * speed / (2.0 * constants.lead_deceleration)
        });
        way.reduce(f64::min).map(|way| ego.front + way - constants.lane.margin())
    }

    fn nearest(&self, ego: &Ego, crosswalk: Option<f64>, lane: Option<f64>) -> Option<StopPoint> {
        let constants = &self.constants;
        let for_crosswalk = crosswalk.map(|place| StopPoint {
            distance: place - ego.front,
            cap: constants.crosswalk_cap,
            gives_way: false,
        });
        let in_lane = lane.map(|place| StopPoint {
            distance: place - ego.front,
            cap: constants.lane_cap,
            gives_way: constants.suppress_sudden_stop,
        });
        for_crosswalk
            .into_iter()
            .chain(in_lane)
            .min_by(|left, right| left.distance.total_cmp(&right.distance))
    }

    /// One control step.
    fn control(&mut self, time: f64, ego: &Ego) -> f64 {
        let elapsed = self.clock.controlled_at.map_or(self.constants.control_period, |last| time - last);
        self.clock.controlled_at = Some(time);
        if self.signs.emergency {
            let floor = -self.constants.mrm_deceleration;
            let change = self.constants.mrm_jerk * elapsed;
            let last = self.longitudinal.command();
            let command = floor.clamp(last - change, last + change);
            self.longitudinal.overridden(command);
            return command;
        }
        let ahead = time - self.clock.planned_at + self.constants.delay_compensation;
        self.longitudinal.step(&Situation {
            time,
            elapsed,
            speed: ego.speed,
            acceleration: ego.acceleration,
            reference: self.profile.at(ahead),
            stop_distance: self.plan_end.map_or(f64::INFINITY, |end| end - ego.front),
        })
    }
}

impl Controller for Stack {
    fn schedule(&self) -> Schedule {
        Schedule::on_ticks(self.constants.control_period, self.constants.vehicle_period)
    }

    fn settling_time(&self) -> f64 {
        self.constants.settling
    }

    fn act(&mut self, observation: &Observation) -> Result<Command, ControllerError> {
        let ego = Ego::of(observation);
        self.tracker.sense(observation);
        if self.is_planning_due(observation.time) {
            self.plan(observation, &ego);
        }
        let command = self.control(observation.time, &ego);
        let state = self.longitudinal.state();
        self.signs.stopping = state == DriveState::Stopping;
        self.signs.stopped = state == DriveState::Stopped;
        self.signs.slow = ego.speed < UNDER_WAY;
        self.phase = self.phase.next(&self.signs);
        Ok(Command::Acceleration(command))
    }

    fn mode(&self) -> Mode {
        Mode::new(self.phase.name())
    }
}
