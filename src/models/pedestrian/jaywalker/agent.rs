//! The jaywalker's state machine and how it moves in each state.

use nalgebra::Vector2;

use super::declaration::{Triggers, Walking};
use super::forces::{Retreat, StopForce, Yang, clipped, destination};
use super::gap::{GapModel, Opportunity};
use super::perception::{JaywalkerEncounter, JaywalkerPerception};
use crate::pedestrian::sum::sum_in_any_order;
use numbers::random::Stream;
use scenario::{Settings, Side};
use sim::sight::sees_vehicle;
use sim::{Mode, Motion, Pedestrian, Scene, VehicleState};

/// Nearer to its goal than this it has arrived, m.
const ARRIVAL: f64 = 0.2;
/// A vehicle that stood for this long has stopped for it, s.
const STANDSTILL: f64 = 0.5;
/// Below this speed it faces its goal, m/s.
const RESTING_SPEED: f64 = 0.01;
/// A retreat is over this near to its end with the reference's quirks, m.
const QUIRK_ARRIVAL: f64 = 1e-3;
/// Absorbs the rounding of summed times, s.
const TIME_TOLERANCE: f64 = 1e-9;

/// What it does about an oncoming vehicle while it crosses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tactic {
    Dash,
    Freeze,
    Rewind,
}

/// What is drawn once per run.
#[derive(Debug, Clone, Copy)]
pub struct Individuality {
    pub tactic: Tactic,
    pub timing_error: f64,
    /// s
    pub stop_time: f64,
}

#[derive(Debug, Clone, Copy)]
enum Oncoming {
    Off,
    /// Constant push towards the goal, m/s².
    SpeedUp(f64),
    Yang(Yang),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    Initialising,
    Waiting,
    Crossing,
    Frozen(StopForce),
    Survival(Retreat),
    Finished,
}

/// Since when (s) something has been so, `None` while it is not.
#[derive(Debug, Clone, Copy, Default)]
struct Since(Option<f64>);

impl Since {
    fn watch(&mut self, holds: bool, time: f64) {
        self.0 = holds.then(|| self.0.unwrap_or(time));
    }

    /// For how long it has been so, s.
    fn duration(self, time: f64) -> f64 {
        self.0.map_or(0.0, |since| time - since)
    }
}

pub struct Jaywalker {
    initialising_time: f64,
    gap_model: GapModel,
    oncoming: Oncoming,
    retreats: bool,
    stops: bool,
    stop_time: f64,
    retreat_distance: f64,
    walking: Walking,
    triggers: Triggers,
    perception: JaywalkerPerception,
    side: Side,
    decisions: Stream,
    /// When it appeared, s.
    appeared: Option<f64>,
    /// No time gap.
    undisturbed: Since,
    /// The vehicle that matters stands before it.
    blocked: Since,
    state: State,
}

impl Jaywalker {
    pub fn new(settings: &Settings, drawn: Individuality, side: Side, decisions: Stream) -> Self {
        let walking = Walking::new(settings);
        let timing_error = settings.optional_number("timing_error").unwrap_or(drawn.timing_error);
        let tactic = match settings.word("tactic") {
            "dash" => Tactic::Dash,
            "freeze" => Tactic::Freeze,
            "rewind" => Tactic::Rewind,
            _ => drawn.tactic,
        };
        let switch = |name, by_tactic| match settings.word(name) {
            "by_tactic" => by_tactic,
            word => word == "on",
        };
        let speed_up = Oncoming::SpeedUp(settings.number("speedup_push"));
        Self {
            initialising_time: settings.number("initialising_time"),
            gap_model: GapModel::new(settings, &walking, timing_error),
            oncoming: match (settings.word("oncoming"), tactic) {
                ("yang", _) => Oncoming::Yang(Yang::new(settings)),
                ("off", _) | ("by_tactic", Tactic::Freeze) => Oncoming::Off,
                _ => speed_up,
            },
            retreats: switch("retreat", tactic == Tactic::Rewind),
            stops: switch("stop", tactic == Tactic::Freeze),
            stop_time: settings.optional_number("stop_time").unwrap_or(drawn.stop_time),
            retreat_distance: settings.number("retreat_distance"),
            triggers: Triggers::new(settings),
            perception: JaywalkerPerception::new(settings),
            walking,
            side,
            decisions,
            appeared: None,
            undisturbed: Since::default(),
            blocked: Since::default(),
            state: State::Initialising,
        }
    }

    /// The state after this moment's transition, if any; arrival comes before it.
    fn transition(
        &mut self,
        scene: &Scene,
        encounter: Option<&JaywalkerEncounter>,
        way: Vector2<f64>,
    ) -> State {
        let passed = encounter.is_some_and(JaywalkerEncounter::has_passed);
        let stopped = self.blocked.duration(scene.time) >= STANDSTILL - TIME_TOLERANCE;
        let time_gap = encounter.and_then(|encounter| encounter.time_gap);
        match self.state {
            State::Waiting => {
                let opportunity = Opportunity {
                    time_gap,
                    undisturbed: self.undisturbed.duration(scene.time),
                    passed,
                    step: scene.step,
                };
                let accepts = self.gap_model.accepts(&opportunity, &mut self.decisions);
                if accepts { State::Crossing } else { State::Waiting }
            }
            State::Crossing => {
                encounter.and_then(|encounter| self.tactic(scene, encounter, way)).unwrap_or(State::Crossing)
            }
            State::Survival(retreat) => {
                let at_end = (retreat.point - scene.ego().position).norm() < QUIRK_ARRIVAL;
                let quirk =
                    self.triggers.reference_quirks && (at_end || time_gap.is_none_or(|gap| gap == 0.0));
                if passed || stopped || quirk { State::Crossing } else { self.state }
            }
            State::Frozen(stop) => {
                let recovered = encounter.is_some_and(|encounter| {
                    encounter.gap >= self.triggers.unfreeze_gap
                        && time_gap.is_some_and(|gap| gap >= self.triggers.unfreeze_time_gap)
                        && stop.has_finished(scene.time)
                });
                if passed || stopped || recovered { State::Crossing } else { self.state }
            }
            State::Initialising | State::Finished => self.state,
        }
    }

    /// Whether it turns back or stops now; turning back comes first.
    fn tactic(&self, scene: &Scene, encounter: &JaywalkerEncounter, way: Vector2<f64>) -> Option<State> {
        let ego = scene.ego();
        let sign = self.side.walking_sign();
        let time_gap = encounter.time_gap?;
        let half_lane = scene.road.lane_width / 2.0;
        let off_centre = encounter.beyond_lane_centre.abs();
        if self.retreats {
            let road = scene.road;
            let on_carriageway = sign * (road.across(ego.position) - road.kerb(self.side)) >= 0.0;
            let facing = walking_direction(ego.velocity, way);
            let paths_meet = encounter.is_oncoming()
                && sign * road.speed_across(ego.position, facing) > 0.0
                && encounter.beyond_lane_centre <= 0.0
                && encounter.ahead >= encounter.half_diagonal;
            let time_to_cross = (off_centre + half_lane) / self.walking.desired_speed;
            let advantage = time_gap - time_to_cross;
            let in_danger = (0.0..self.triggers.survival_band).contains(&advantage)
                || advantage < self.triggers.far_late_bound;
            if on_carriageway && paths_meet && in_danger {
                let back = road.crossing_velocity(ego.position, self.side.opposite(), 1.0);
                let retreat = Retreat::new(ego.position, back, self.retreat_distance, off_centre);
                return Some(State::Survival(retreat));
            }
        }
        let in_lane = off_centre <= half_lane;
        if self.stops && encounter.is_oncoming() && time_gap < self.triggers.freeze_time_gap && in_lane {
            let stop = StopForce { since: scene.time, velocity: ego.velocity, duration: self.stop_time };
            return Some(State::Frozen(stop));
        }
        None
    }

    /// The velocity over the coming step in the present state, m/s.
    fn velocity(
        &mut self,
        scene: &Scene,
        encounter: Option<&JaywalkerEncounter>,
        way: Vector2<f64>,
    ) -> Vector2<f64> {
        let (position, velocity, step) = (scene.ego().position, scene.ego().velocity, scene.step);
        let force = match &mut self.state {
            State::Initialising | State::Waiting | State::Finished => return Vector2::zeros(),
            State::Frozen(stop) => stop.force(scene.time, velocity, step),
            State::Survival(retreat) => retreat.force(&self.walking, position, velocity, step),
            State::Crossing => {
                destination(&self.walking, way, velocity, step) + self.push(scene, encounter, way)
            }
        };
        let faster = velocity + clipped(force, self.walking.max_acceleration) * step;
        clipped(faster, self.walking.max_speed)
    }

    /// The force of oncoming vehicles, m/s².
    fn push(&self, scene: &Scene, encounter: Option<&JaywalkerEncounter>, way: Vector2<f64>) -> Vector2<f64> {
        match self.oncoming {
            Oncoming::SpeedUp(push) if encounter.is_some_and(JaywalkerEncounter::is_oncoming) => way * push,
            Oncoming::Off | Oncoming::SpeedUp(_) => Vector2::zeros(),
            Oncoming::Yang(yang) => {
                let ego = scene.ego();
                let walking = walking_direction(ego.velocity, way);
                let side = self.side;
                let oncoming =
                    |vehicle: &VehicleState| self.perception.encounter(vehicle, ego, side).is_oncoming();
                let vehicles = scene.vehicles.iter().enumerate();
                let forces =
                    vehicles.filter(|(index, vehicle)| oncoming(vehicle) && sees_vehicle(scene, *index));
                sum_in_any_order(forces.map(|(_, vehicle)| yang.force(vehicle, ego, walking)))
            }
        }
    }
}

/// The way it walks, or that to its goal when it rests.
fn walking_direction(velocity: Vector2<f64>, way: Vector2<f64>) -> Vector2<f64> {
    velocity.try_normalize(RESTING_SPEED).unwrap_or(way)
}

impl Pedestrian for Jaywalker {
    fn begin_leg(&mut self, _scene: &Scene) {
        // It waits there for its next gap as it did at the kerb.
        (self.undisturbed, self.blocked, self.state) = (Since::default(), Since::default(), State::Waiting);
    }

    fn act(&mut self, scene: &Scene) -> Motion {
        let sign = self.side.walking_sign();
        let encounter = self.perception.focus(scene, self.side);
        let encounter = encounter.as_ref();
        let no_time_gap = encounter.is_none_or(|encounter| encounter.time_gap.is_none());
        self.undisturbed.watch(no_time_gap, scene.time);
        self.blocked.watch(encounter.is_some_and(JaywalkerEncounter::stands), scene.time);

        let appeared = *self.appeared.get_or_insert(scene.time);
        if self.state == State::Initialising {
            if scene.time - appeared < self.initialising_time - TIME_TOLERANCE {
                return Motion::Walk(Vector2::zeros());
            }
            self.state = State::Waiting;
        }
        let to_goal = Vector2::new(scene.goal.x, scene.goal.y) - scene.ego().position;
        let here = scene.ego().position;
        let way =
            to_goal.try_normalize(0.0).unwrap_or_else(|| scene.road.crossing_velocity(here, self.side, 1.0));
        let left = scene.road.across(scene.goal.into()) - scene.road.across(here);
        // A leg ends on the refuge itself.
        let arrived = !scene.goes_on() && (to_goal.norm() < ARRIVAL || sign * left <= 0.0);
        if arrived {
            self.state = State::Finished;
        }
        self.state = self.transition(scene, encounter, way);
        Motion::Walk(self.velocity(scene, encounter, way))
    }

    fn mode(&self) -> Mode {
        Mode::new(match self.state {
            State::Initialising => "initialising",
            State::Waiting => "waiting",
            State::Crossing => "crossing",
            State::Frozen(_) => "frozen",
            State::Survival(_) => "survival",
            State::Finished => "finished",
        })
    }

    fn free_speed(&self) -> f64 {
        self.walking.desired_speed
    }
}
