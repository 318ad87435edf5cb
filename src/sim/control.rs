//! The control loop of one vehicle: when it is due, what it sees, what it was told to do, and how it settles before the run.

use std::collections::VecDeque;

use nalgebra::Vector2;

use super::abreast::Abreast;
use super::change::{Otherwise, TIME_TOLERANCE};
use super::crossings_ahead::CrossingsAhead;
use super::curvature::CurvatureChanges;
use super::order::{Order, SpeedPlan, SteeredOrder};
use super::road_users::{Driven, Driver};
use super::sighting::Sighting;
use super::solid::Solid;
use super::steering::Steering;
use scenario::agent::{
    Command, ControllerError, EgoState, Longitudinal, Mode, Observation, RoadView, Schedule, SeenPedestrian,
    SeenVehicle, Snapshot, VehicleState,
};
use scenario::{CommandKind, Ground, Located, Road, RoadUserKind, VehicleSetup, World};

/// Where a settling vehicle believes to be: too far from the crossing for it to matter, m.
const FAR_AWAY: f64 = 1e6;

/// The state of one vehicle's control loop.
pub(super) struct Control {
    /// Of everybody who is no vehicle, in the order of the world.
    kinds: Vec<RoadUserKind>,
    observation: Observation,
    /// What perception leaves of it, if there is any.
    view: Option<Observation>,
    /// Whether it is told of anybody.
    sees_others: bool,
    /// Whether each of the others is in it, pedestrians first, at the last decision and now; empty where all are seen.
    in_view: Vec<(bool, bool)>,
    /// What the vehicle does until the next decision takes effect.
    held: Held,
    /// The curvature that it steers meanwhile, 1/m.
    curvature: Option<f64>,
    /// What was decided for later, with the moments (s) from which on it holds, in the order of the decisions.
    later: VecDeque<(f64, Held, Option<f64>)>,
    steering: Steering,
    may_steer: bool,
    schedule: Schedule,
    /// What it drives on, in its direction, where something is said of that.
    ground: Option<Ground>,
    /// How its lane bends.
    bends: CurvatureChanges,
    /// The crossings of its road.
    crossings: CrossingsAhead,
    /// What its controller is declared to give, where that is known.
    gives: Option<CommandKind>,
    decisions: u64,
    /// Moment of the next decision, s.
    next: f64,
    /// Whether somebody outside is to decide now.
    pub waits: bool,
    settling: Settling,
    /// What goes otherwise than decided; `None` in all runs but those of what would have been.
    pub otherwise: Option<Box<Otherwise>>,
}

/// What a vehicle does meanwhile.
#[derive(Debug, Clone)]
enum Held {
    Command(Command),
    /// Speeds from the moment `begun` (s) on.
    Plan {
        plan: Box<SpeedPlan>,
        begun: f64,
    },
}

/// A vehicle in free flow before time 0.
struct Settling {
    motion: Longitudinal,
    steps: u64,
    /// The step under way.
    index: u64,
    /// Whether those who are due at the beginning of that step were asked.
    begun: bool,
    /// How much of that step is driven, s.
    driven: f64,
}

impl Control {
    pub fn new(world: &World, setup: &VehicleSetup, driven: &Driven) -> Self {
        let (road, path) = (world.road_of(setup), world.path_of(setup));
        let (right_kerb, left_kerb) = path.kerbs(road);
        let ground = road.ground.towards(road.lanes[setup.lane].direction);
        let bends = CurvatureChanges::new(path.curvature_changes());
        let crossings = CrossingsAhead::new(world, setup);
        let observed = || Observation {
            time: 0.0,
            ego: EgoState {
                distance_to_crossing: FAR_AWAY,
                speed: setup.speed_at_start(),
                acceleration: 0.0,
                length: setup.length,
                width: setup.width,
                travelled: -FAR_AWAY,
                curvature: 0.0,
                lateral_offset: 0.0,
                heading_error: 0.0,
            },
            cruise_speed: setup.speed,
            road: RoadView {
                lane_width: road.lane_width,
                speed_limit: road.speed_limit,
                crossing_width: road.crossing.width,
                pedestrian_priority: road.crossing.pedestrian_priority(0.0),
                signal: road.crossing.seen_signal(0.0),
                right_kerb,
                left_kerb,
                gradient: ground.gradient,
                curvature_ahead: Vec::with_capacity(bends.most()),
                crossings: crossings.views(),
            },
            pedestrians: Vec::with_capacity(world.pedestrians.len()),
            vehicles: Vec::with_capacity(world.vehicles.len()),
        };
        Self {
            observation: observed(),
            in_view: match driven.perception {
                Some(_) => vec![(false, false); world.pedestrians.len() + world.vehicles.len()],
                None => Vec::new(),
            },
            view: driven.perception.is_some().then(observed),
            sees_others: driven.perception.is_some() || driven.driver.looks_at_others(),
            kinds: world.pedestrians.iter().map(|setup| setup.kind).collect(),
            held: Held::Command(Command::Acceleration(0.0)),
            curvature: None,
            later: VecDeque::new(),
            steering: Steering::new(setup, &ground),
            may_steer: setup.may_steer(),
            schedule: driven.driver.schedule(),
            ground: Some(ground).filter(|ground| !ground.is_unsaid()),
            bends,
            crossings,
            gives: setup.controller.model.entry().map(|controller| controller.gives),
            decisions: 0,
            next: 0.0,
            waits: false,
            settling: Settling {
                motion: Longitudinal { travelled: 0.0, speed: setup.speed_at_start(), acceleration: 0.0 },
                // A vehicle that starts at another speed does not cruise steadily, so that there is nothing to settle to.
                steps: match setup.initial_speed {
                    None => (driven.driver.settling_time() / world.step).ceil() as u64,
                    Some(_) => 0,
                },
                index: 0,
                begun: false,
                driven: 0.0,
            },
            otherwise: None,
        }
    }

    pub fn is_due(&self, time: f64) -> bool {
        time >= self.next - TIME_TOLERANCE
    }

    /// The moment of its next decision, or at which one takes effect, if it lies before `end` (s), which is where the next
    /// step asks by itself.
    pub fn due_before(&self, end: f64) -> Option<f64> {
        let mut next = self.next;
        if !self.later.is_empty() {
            next = self.later.iter().map(|(moment, ..)| *moment).fold(next, f64::min);
        }
        (next < end - TIME_TOLERANCE).then_some(next)
    }

    /// Lets what was decided for `time` (s) take effect. A later decision holds whatever an earlier one still had in store.
    pub fn take_effect(&mut self, time: f64) {
        if !self.later.is_empty() {
            self.take_effect_of_later(time);
        }
    }

    /// Only those outside decide for later: the others do not pay for them.
    #[cold]
    fn take_effect_of_later(&mut self, time: f64) {
        while let Some(last) = self.later.iter().rposition(|(moment, ..)| *moment <= time + TIME_TOLERANCE) {
            (_, self.held, self.curvature) =
                self.later.drain(..=last).next_back().expect("it has a last one");
        }
    }

    /// What a vehicle with that speed (m/s) is told at `time` (s).
    fn command_at(&self, time: f64, speed: f64) -> Command {
        match &self.held {
            Held::Command(command) => *command,
            Held::Plan { plan, begun } => Command::Acceleration(plan.acceleration(time - begun, speed)),
        }
    }

    /// What whoever decides is shown.
    pub fn shown(&self) -> &Observation {
        self.view.as_ref().unwrap_or(&self.observation)
    }

    /// What there was to be seen at the last decision, and what was told of it; `None` where that is the same.
    pub fn seen_and_told(&self) -> Option<(&Observation, &Observation)> {
        Some((&self.observation, self.view.as_ref()?))
    }

    /// Asks whoever drives what to do from now on; what it is up to then, unless it is outside and is waited for.
    fn ask(&mut self, driven: &mut Driven) -> Result<Option<Mode>, ControllerError> {
        if let (Some(perception), Some(view)) = (&mut driven.perception, &mut self.view) {
            perception.perceive(&self.observation, view);
        }
        match &mut driven.driver {
            Driver::Inside(controller) => {
                let command = controller.act(self.view.as_ref().unwrap_or(&self.observation))?;
                self.take(command, controller.curvature())?;
                Ok(Some(controller.mode()))
            }
            Driver::Outside { .. } => {
                self.waits = true;
                Ok(None)
            }
        }
    }

    /// Takes a decision, which holds until the next.
    pub fn take(&mut self, command: Command, curvature: Option<f64>) -> Result<(), ControllerError> {
        self.check(command)?;
        self.check_curvature(curvature)?;
        self.waits = false;
        if !self.later.is_empty() {
            self.later.clear();
        }
        (self.held, self.curvature) = (Held::Command(command), curvature);
        self.count_from(self.decisions + 1)
    }

    /// Takes a decision that is taken at `time` (s) and holds from `delay` (s) later on until the next one does.
    pub fn take_later(&mut self, orders: SteeredOrder, time: f64, delay: f64) -> Result<(), ControllerError> {
        let SteeredOrder { along, curvature } = orders;
        self.check_curvature(curvature)?;
        let held = match along {
            Order::Command(command) if delay <= 0.0 => return self.take(command, curvature),
            Order::Command(command) => {
                self.check(command)?;
                Held::Command(command)
            }
            Order::Plan(plan) => Held::Plan { plan, begun: time + delay },
        };
        self.waits = false;
        self.later.push_back((time + delay, held, curvature));
        self.take_effect(time);
        self.count_from(self.decisions + 1)
    }

    /// The moment of the decision that is waited for, s; counted from the start of settling while it settles.
    pub fn moment(&self) -> f64 {
        self.next
    }

    /// Whether the vehicle can follow a command: a number, and of the kind that its dynamics were chosen for.
    fn check(&self, command: Command) -> Result<(), ControllerError> {
        if !command.is_finite() {
            return Err(ControllerError::new(format!("no vehicle can follow its command: {command:?}")));
        }
        match self.gives {
            Some(kind) if kind != command.kind() => {
                Err(ControllerError::new(format!("it is declared to give {kind:?}, and gives {command:?}")))
            }
            _ => Ok(()),
        }
    }

    /// Whether the vehicle can be steered by it, and its controller is one that does so.
    fn check_curvature(&self, curvature: Option<f64>) -> Result<(), ControllerError> {
        match curvature {
            None => Ok(()),
            Some(other) if !other.is_finite() => {
                Err(ControllerError::new(format!("no vehicle can follow a curvature of {other} 1/m")))
            }
            Some(_) if self.may_steer => Ok(()),
            Some(other) => Err(ControllerError::with_hint(
                format!("it answers a curvature of {other} 1/m, and is declared not to steer"),
                "declare it with `ControllerModel::steering`",
            )),
        }
    }

    /// Without an end nobody else would get a turn.
    fn count_from(&mut self, decisions: u64) -> Result<(), ControllerError> {
        let last = std::mem::replace(&mut self.next, self.schedule.moment(decisions));
        self.decisions = decisions;
        if self.next.is_nan() || decisions > 0 && last >= self.next {
            return Err(ControllerError::new(format!(
                "its next decision is at {} s, as the last one",
                self.next
            )));
        }
        Ok(())
    }

    /// Asks at `time` (s), everybody being where `now` says.
    pub fn decide(
        &mut self,
        driven: &mut Driven,
        time: f64,
        me: usize,
        (now, abreast): (&Snapshot, &mut Abreast),
        road: &Road,
    ) -> Result<Option<Mode>, ControllerError> {
        self.see(time, me, (now, abreast), road);
        if let Some(perception) = &mut driven.perception {
            perception.look(me, now);
        }
        self.ask(driven)
    }

    /// Drives on in free flow until time 0, or until somebody outside has to decide; the motion it has settled to, with
    /// `travelled` at 0.
    pub fn settle(
        &mut self,
        step: f64,
        driven: &mut Driven,
    ) -> Result<Option<Longitudinal>, ControllerError> {
        let steps = self.settling.steps;
        while !self.waits && self.settling.index < steps {
            let index = self.settling.index;
            let begin = index as f64 * step;
            if !self.settling.begun {
                self.settling.begun = true;
                self.take_effect(begin);
                if self.is_due(begin) {
                    self.decide_far_away((index as f64 - steps as f64) * step, driven)?;
                }
            } else if let Some(moment) = self.due_before((index + 1) as f64 * step) {
                self.settle_on(begin, moment - begin - self.settling.driven, driven);
                self.settling.driven = moment - begin;
                self.take_effect(moment);
                if self.is_due(moment) {
                    self.decide_far_away(moment - steps as f64 * step, driven)?;
                }
            } else {
                self.settle_on(begin, step - self.settling.driven, driven);
                (self.settling.index, self.settling.begun, self.settling.driven) = (index + 1, false, 0.0);
            }
        }
        if self.waits {
            return Ok(None);
        }
        self.count_from(0)?;
        // What was decided while settling holds on: its moments are counted from the start from now on.
        let settled = steps as f64 * step;
        self.later.iter_mut().for_each(|(moment, ..)| *moment -= settled);
        if let Held::Plan { begun, .. } = &mut self.held {
            *begun -= settled;
        }
        for (_, held, _) in &mut self.later {
            if let Held::Plan { begun, .. } = held {
                *begun -= settled;
            }
        }
        Ok(Some(Longitudinal { travelled: 0.0, ..self.settling.motion }))
    }

    /// Drives on in free flow by `duration` (s) in the step that began at `begin` (s).
    fn settle_on(&mut self, begin: f64, duration: f64, driven: &mut Driven) {
        let mut motion = self.settling.motion;
        self.drive_on(begin + self.settling.driven, duration, &mut motion, driven);
        self.settling.motion = motion;
    }

    /// Lets the vehicle do for `duration` (s) what it is told at `time` (s), and steer if it is told to.
    #[inline]
    pub fn drive(&mut self, time: f64, duration: f64, car: &mut VehicleState, driven: &mut Driven) {
        if self.otherwise.is_some() {
            return self.drive_otherwise(time, duration, car, driven);
        }
        if self.curvature.is_none() && car.steered.is_none() {
            return self.drive_on(time, duration, &mut car.motion, driven);
        }
        let before = car.motion;
        self.drive_on(time, duration, &mut car.motion, driven);
        self.steering.follow(car, before, self.curvature, duration);
    }

    /// As [`Self::drive`], where something goes otherwise.
    #[cold]
    fn drive_otherwise(&mut self, time: f64, duration: f64, car: &mut VehicleState, driven: &mut Driven) {
        let before = car.motion;
        let decided = self.command_at(time, before.speed);
        let otherwise = self.otherwise.as_mut().map(|one| one.command(time, decided));
        self.follow(otherwise.unwrap_or(decided), duration, &mut car.motion, driven);
        if let Some(otherwise) = &self.otherwise {
            otherwise.decelerate(time, duration, &before, &mut car.motion);
        }
        if self.curvature.is_some() || car.steered.is_some() {
            self.steering.follow(car, before, self.curvature, duration);
        }
    }

    /// Lets the vehicle do along its way for `duration` (s) what it is told at `time` (s).
    fn drive_on(&self, time: f64, duration: f64, motion: &mut Longitudinal, driven: &mut Driven) {
        self.follow(self.command_at(time, motion.speed), duration, motion, driven);
    }

    /// Lets the vehicle do along its way for `duration` (s) what it is told.
    fn follow(&self, command: Command, duration: f64, motion: &mut Longitudinal, driven: &mut Driven) {
        match &self.ground {
            None => driven.dynamics.advance(motion, command, duration),
            Some(ground) => driven.dynamics.advance_on(ground, motion, command, duration),
        }
    }

    /// A decision in free flow, `time` (s) being negative: that much before the start.
    fn decide_far_away(&mut self, time: f64, driven: &mut Driven) -> Result<(), ControllerError> {
        self.observation.time = time;
        self.observation.ego.travelled = -FAR_AWAY;
        self.crossings.tell_far_away(FAR_AWAY, &mut self.observation);
        self.observation.ego.speed = self.settling.motion.speed;
        self.observation.ego.acceleration = self.settling.motion.acceleration;
        self.ask(driven).map(drop)
    }

    /// Whether it may be shown less than everything.
    #[inline]
    pub fn looks(&self) -> bool {
        self.view.is_some()
    }

    /// Tells of those who are in the view of the vehicle `me` now and were not at the decision before, and the other way round.
    pub fn tell_sightings(&mut self, me: usize, moment: f64, told: &mut Vec<Sighting>) {
        let Some(view) = &self.view else { return };
        let people = self.kinds.len();
        self.in_view.iter_mut().for_each(|(before, now)| (*before, *now) = (*now, false));
        view.pedestrians.iter().for_each(|seen| self.in_view[seen.id].1 = true);
        view.vehicles.iter().for_each(|seen| self.in_view[people + seen.id].1 = true);
        let changed = self.in_view.iter().enumerate().filter(|(_, (before, now))| before != now);
        told.extend(changed.map(|(index, (_, seen))| {
            let who = match index.checked_sub(people) {
                Some(vehicle) => Solid::Vehicle(vehicle),
                None => Solid::Pedestrian(index),
            };
            Sighting { vehicle: me, who, seen: *seen, moment }
        }));
    }

    /// Fills the observation with the states of `now` as the ego sees them.
    fn see(&mut self, time: f64, me: usize, (now, abreast): (&Snapshot, &mut Abreast), road: &Road) {
        let ego = &now.vehicles[me];
        let (seen, kinds) = (&mut self.observation, &self.kinds);
        seen.time = time;
        seen.ego.speed = ego.motion.speed;
        seen.ego.acceleration = ego.motion.acceleration;
        seen.ego.travelled = ego.motion.travelled;
        if let Some(steered) = &ego.steered {
            seen.ego.lateral_offset = steered.offset;
            seen.ego.heading_error = steered.heading_error;
        }
        if ego.path.course().is_some() {
            seen.ego.curvature = ego.path.curvature(ego.motion.travelled);
            self.bends.tell(ego.motion.travelled, seen.ego.curvature, &mut seen.road.curvature_ahead);
        }
        self.crossings.tell(time, ego.motion.travelled, road, seen);
        if !self.sees_others {
            return;
        }
        let here = match ego.path.course() {
            None => ego.path.point(ego.motion.travelled),
            Some(_) => Vector2::zeros(),
        };
        seen.pedestrians.clear();
        seen.pedestrians.extend(now.pedestrians.iter().enumerate().filter(|(_, state)| state.present).map(
            |(id, state)| {
                let seen = match ego.path.course() {
                    None => Seen::new((ego, here), state.position),
                    Some(_) => Seen::abreast(ego, abreast.locate(me, &ego.path, id, state.position)),
                };
                SeenPedestrian {
                    id,
                    kind: kinds[id],
                    position: seen.position,
                    velocity: seen.velocity(state.velocity),
                    acceleration: seen.turned(state.acceleration),
                    shape: state.shape,
                }
            },
        ));
        seen.vehicles.clear();
        seen.vehicles.extend(now.vehicles.iter().enumerate().filter(|(id, _)| *id != me).map(
            |(id, state)| {
                let seen = Seen::new((ego, here), state.position());
                SeenVehicle {
                    id,
                    position: seen.position,
                    velocity: seen.velocity(state.velocity()),
                    length: state.length,
                    width: state.width,
                }
            },
        ));
    }
}

/// Where somebody is, seen from a vehicle: so far ahead along its path, so far to the left of it.
struct Seen<'a> {
    ego: &'a VehicleState,
    position: Vector2<f64>,
    /// On a path that bends.
    abreast: Option<Located>,
}

impl<'a> Seen<'a> {
    /// `here` is the place of its lane (world frame, m) that the vehicle is at, if that is straight.
    fn new((ego, here): (&'a VehicleState, Vector2<f64>), place: Vector2<f64>) -> Self {
        if ego.path.course().is_none() {
            // Seen from its lane, also where it is beside that.
            let position = ego.path.turned(ego.motion.travelled, place - here);
            return Self { ego, position, abreast: None };
        }
        Self::abreast(ego, ego.path.locate(place))
    }

    fn abreast(ego: &'a VehicleState, abreast: Located) -> Self {
        let position = Vector2::new(abreast.along - ego.motion.travelled, abreast.left());
        Self { ego, position, abreast: Some(abreast) }
    }

    /// A vector along the path and to the left of it, where they are.
    fn turned(&self, vector: Vector2<f64>) -> Vector2<f64> {
        match &self.abreast {
            None => self.ego.path.turned(self.ego.motion.travelled, vector),
            Some(abreast) => abreast.turned(vector),
        }
    }

    /// How fast the place abreast of them moves along the path, and they to the left of it, m/s.
    fn velocity(&self, velocity: Vector2<f64>) -> Vector2<f64> {
        match &self.abreast {
            None => self.turned(velocity),
            Some(abreast) => Vector2::new(abreast.speeds(velocity).0, abreast.turned(velocity).y),
        }
    }
}
