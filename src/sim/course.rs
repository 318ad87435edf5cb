//! One run from settled cruise to its end, step by step, which stops wherever somebody outside has to decide.

use std::sync::Arc;

use nalgebra::Vector2;
use thiserror::Error;

use super::abreast::Abreast;
use super::arrival::{Arrivals, has_crossed};
use super::change::{GivenCommand, Otherwise, Postponed, RunChange, TIME_TOLERANCE};
use super::contact::Contacts;
use super::control::Control;
use super::keep_clear::KeepClear;
use super::legs::Legs;
use super::observer::{Ending, Minds, Observer, Step, StopReason};
use super::order::SteeredOrder;
use super::perceived::Views;
use super::permission::Permissions;
use super::road_users::{Driver, RoadUsers};
use super::sighting::Sighting;
use super::solid::Solid;
use super::start::{PastArrival, meeting_place, occupied_by, past_arrival, placed, waiting_outside};
use super::wait_for_green::WaitForGreen;
use super::way::{Way, walked};
use scenario::agent::{
    Command, ControllerError, Mode, Motion, Observation, Pedestrian, PedestrianState, Scene, ScriptStep,
    Snapshot, VehicleState,
};
use scenario::{Appearance, PedestrianSetup, VehicleReference, World};

/// The time at which a run ends that nothing ends before its horizon, s: a whole number of steps.
pub fn longest_run(horizon: f64, step: f64) -> f64 {
    steps_within(horizon, step) as f64 * step
}

fn steps_within(horizon: f64, step: f64) -> u64 {
    (horizon / step - TIME_TOLERANCE).ceil().max(1.0) as u64
}

/// Runs `world` to its end. `users` must hold one mind per setup, and nobody outside.
///
/// A pure function of its arguments: no clock, no global state, and nothing is allocated after the first step.
///
/// # Errors
/// The first controller that cannot decide.
pub fn simulate(world: &Arc<World>, users: RoadUsers, observer: &mut dyn Observer) -> Result<Ending, Fault> {
    let mut course = Course::start(world.clone(), users);
    match course.next(observer)? {
        Progress::Ended(ending) => Ok(ending),
        Progress::Waits => {
            let waiting = course.asked().next().map_or(0, |(vehicle, _)| vehicle);
            Err(course.fault(waiting, ControllerError::new("nobody decides for it")))
        }
    }
}

/// Why a run cannot go on. It is neither a pass nor a failure.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Fault {
    /// A controller cannot decide.
    #[error("vehicle {vehicle} cannot decide at {time} s: {error}")]
    Controller {
        /// Index of its vehicle.
        vehicle: usize,
        /// s; negative while settling before the start.
        time: f64,
        /// In the controller's own words.
        error: ControllerError,
    },
    /// A pedestrian appears inside another body.
    #[error("pedestrian {pedestrian} appears inside another body at {time} s")]
    Occupied {
        /// Index into [`World::pedestrians`].
        pedestrian: usize,
        /// What the pedestrian is inside of.
        by: Solid,
        /// s
        time: f64,
    },
    /// The time to arrival that a pedestrian waits for is past when it begins to wait.
    #[error("pedestrian {} waits for a time to arrival that is past", .0.pedestrian)]
    PastArrival(PastArrival),
    /// The run ended before a pedestrian that was there, and that no vehicle touched, might go.
    #[error("pedestrian {pedestrian} may go at {may_go} s, and the run ends at {time} s")]
    NeverMayGo {
        /// Index into [`World::pedestrians`].
        pedestrian: usize,
        /// When it may go at the latest, s.
        may_go: f64,
        /// s
        time: f64,
    },
}

/// How far a run has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress {
    /// Somebody outside has to [decide](Course::decide) for each vehicle that is [asked](Course::asked).
    Waits,
    /// The run is over.
    Ended(Ending),
}

/// A run under way. Whoever drives it calls [`Self::next`], and decides for those who are asked, until it has ended. What
/// comes of it does not depend on who decides, nor on what else goes on between two calls.
pub struct Course {
    world: Arc<World>,
    users: RoadUsers,
    now: Snapshot,
    next: Snapshot,
    /// Where everybody is at a decision inside a step.
    between: Snapshot,
    controls: Vec<Control>,
    /// How many of them wait for somebody outside.
    waiting: usize,
    ways: Vec<Way>,
    /// Which leg of their way they are on.
    legs: Vec<Legs>,
    arrivals: Arrivals,
    abreast: Abreast,
    /// The place at which each pedestrian meets the path of the vehicle that it waits for, m.
    meetings: Vec<f64>,
    motions: Vec<Motion>,
    /// Those of the step before, and for how long into a step (s) they go on: that of whom who has appeared within one.
    earlier: Vec<(Motion, f64)>,
    pedestrian_modes: Vec<Mode>,
    vehicle_modes: Vec<Mode>,
    /// `None` where nobody has anything to keep clear of.
    keep_clear: Option<KeepClear>,
    /// `None` where nobody waits for a signal.
    wait_for_green: Option<WaitForGreen>,
    /// `None` where all pedestrians may go at once.
    permissions: Option<Permissions>,
    contacts: Contacts,
    /// `None` in all runs but those of what would have been.
    postponed: Option<Postponed>,
    /// The vehicle that decelerates, and the pedestrian until whose leaving of the lane it does.
    decelerates: Option<(usize, usize)>,
    /// Of the step under way.
    sightings: Vec<Sighting>,
    /// The pedestrians that have appeared at the beginning of the present step.
    newcomers: Vec<usize>,
    steps: u64,
    /// The step under way.
    index: u64,
    stage: Stage,
}

/// What is to be done next.
enum Stage {
    /// Vehicles drive in free flow until time 0.
    Settle,
    /// A step begins: pedestrians appear, and vehicles that are due are asked.
    Ask,
    /// Pedestrians act.
    Act,
    /// Vehicles have driven so much (s) of the step.
    Drive(f64),
    Ended(Ending),
    Faulted(Fault),
}

impl Course {
    /// The run of `world` before its first decision. `users` must hold one mind per setup.
    pub fn start(world: Arc<World>, users: RoadUsers) -> Self {
        debug_assert_eq!(world.vehicles.len(), users.vehicles.len());
        debug_assert_eq!(world.pedestrians.len(), users.pedestrians.len());
        let ways: Vec<_> = world.pedestrians.iter().map(Way::new).collect();
        let pedestrians = world.pedestrians.iter().zip(&ways).map(waiting_outside).collect();
        let empty = || Snapshot { vehicles: Vec::new(), pedestrians: Vec::new() };
        let both = world.vehicles.iter().zip(&users.vehicles);
        Self {
            now: Snapshot { vehicles: Vec::new(), pedestrians },
            next: empty(),
            between: empty(),
            controls: both.map(|(setup, driven)| Control::new(&world, setup, driven)).collect(),
            waiting: 0,
            motions: vec![Motion::Walk(Vector2::zeros()); ways.len()],
            earlier: vec![(Motion::Walk(Vector2::zeros()), 0.0); ways.len()],
            ways,
            legs: world.pedestrians.iter().map(Legs::new).collect(),
            arrivals: Arrivals::new(&world),
            abreast: Abreast::new(&world),
            meetings: world.pedestrians.iter().map(|setup| meeting_place(&world, setup)).collect(),
            pedestrian_modes: vec![Mode::NONE; world.pedestrians.len()],
            vehicle_modes: vec![Mode::NONE; world.vehicles.len()],
            keep_clear: KeepClear::new(&world),
            wait_for_green: WaitForGreen::new(&world),
            permissions: Permissions::new(&world),
            contacts: Contacts::new(&world),
            postponed: None,
            decelerates: None,
            sightings: Vec::new(),
            newcomers: Vec::with_capacity(world.pedestrians.len()),
            steps: steps_within(world.horizon, world.step),
            index: 0,
            stage: Stage::Settle,
            world,
            users,
        }
    }

    /// The same run, in which something goes otherwise. To be said before it goes on.
    #[must_use]
    pub fn changed(mut self, change: RunChange) -> Self {
        self.postponed = Postponed::new(&change, self.world.pedestrians.len());
        if let RunChange::Decelerates { vehicle, until_gone: Some(pedestrian), .. } = change {
            self.decelerates = Some((vehicle, pedestrian));
        }
        if let RunChange::BrakesEarlier { vehicle, .. } | RunChange::Decelerates { vehicle, .. } = change {
            self.otherwise(vehicle).change = Some(change);
        }
        self
    }

    /// The same run, of which is noted what each vehicle is told from time 0 on. To be said before it goes on.
    #[must_use]
    pub fn noting_commands(mut self) -> Self {
        (0..self.controls.len()).for_each(|vehicle| self.otherwise(vehicle).given = Some(Vec::new()));
        self
    }

    /// The steps of scripts that have not begun, with whose they are.
    pub fn waiting_steps(&self) -> Vec<(Solid, ScriptStep)> {
        let drivers = self.users.vehicles.iter().enumerate().map(|(index, driven)| match &driven.driver {
            Driver::Inside(controller) => (Solid::Vehicle(index), controller.waiting_steps()),
            Driver::Outside { .. } => (Solid::Vehicle(index), Vec::new()),
        });
        let people = self.users.pedestrians.iter().enumerate();
        let people = people.map(|(index, one)| (Solid::Pedestrian(index), one.waiting_steps()));
        drivers.chain(people).flat_map(|(of, steps)| steps.into_iter().map(move |step| (of, step))).collect()
    }

    /// What each vehicle was told, where that was [noted](Self::noting_commands).
    pub fn into_commands(self) -> Vec<Vec<GivenCommand>> {
        let given =
            |control: Control| control.otherwise.and_then(|otherwise| otherwise.given).unwrap_or_default();
        self.controls.into_iter().map(given).collect()
    }

    fn otherwise(&mut self, vehicle: usize) -> &mut Otherwise {
        self.controls[vehicle].otherwise.get_or_insert_default()
    }

    /// Goes on until somebody outside has to decide, or to the end. `observer` is to be the same in every call.
    ///
    /// # Errors
    /// The first controller that cannot decide; from then on always the same.
    pub fn next(&mut self, observer: &mut dyn Observer) -> Result<Progress, Fault> {
        while self.waiting == 0 {
            let done = match &self.stage {
                Stage::Settle => self.settle(observer),
                Stage::Ask => self.ask(),
                Stage::Act => {
                    self.act();
                    Ok(())
                }
                Stage::Drive(driven) => self.drive(*driven, observer),
                Stage::Ended(ending) => return Ok(Progress::Ended(*ending)),
                Stage::Faulted(fault) => return Err(fault.clone()),
            };
            done.map_err(|fault| self.end_in(fault))?;
        }
        Ok(Progress::Waits)
    }

    /// The vehicles for which somebody outside has to decide, with what is seen from them.
    pub fn asked(&self) -> impl Iterator<Item = (usize, &Observation)> {
        let all = self.controls.iter().enumerate();
        all.filter(|(_, control)| control.waits).map(|(index, control)| (index, control.shown()))
    }

    /// Decides for a vehicle that is asked.
    ///
    /// # Errors
    /// If no vehicle can follow the command. The run has then ended in this fault.
    ///
    /// # Panics
    /// If the vehicle is not asked.
    pub fn decide(&mut self, vehicle: usize, command: Command, mode: Mode) -> Result<(), Fault> {
        assert!(self.controls[vehicle].waits, "vehicle {vehicle} is not asked");
        if let Err(error) = self.controls[vehicle].take(command, None) {
            return Err(self.fault(vehicle, error));
        }
        self.waiting -= 1;
        if !matches!(self.stage, Stage::Settle) {
            self.vehicle_modes[vehicle] = mode;
        }
        Ok(())
    }

    /// As [`Self::decide`], for `delay` s later on: what was decided before holds until then. Of two decisions the later one holds
    /// from its own moment on.
    ///
    /// # Errors
    /// As [`Self::decide`].
    ///
    /// # Panics
    /// As [`Self::decide`].
    pub fn decide_later(
        &mut self,
        vehicle: usize,
        orders: impl Into<SteeredOrder>,
        delay: f64,
        mode: Mode,
    ) -> Result<(), Fault> {
        assert!(self.controls[vehicle].waits, "vehicle {vehicle} is not asked");
        let control = &mut self.controls[vehicle];
        let moment = control.moment();
        if let Err(error) = control.take_later(orders.into(), moment, delay) {
            return Err(self.fault(vehicle, error));
        }
        self.waiting -= 1;
        if !matches!(self.stage, Stage::Settle) {
            self.vehicle_modes[vehicle] = mode;
        }
        Ok(())
    }

    /// Ends the run since whoever decides for a vehicle cannot.
    pub fn fault(&mut self, vehicle: usize, error: ControllerError) -> Fault {
        let time = self.controls[vehicle].shown().time;
        self.end_in(Fault::Controller { vehicle, time, error })
    }

    fn end_in(&mut self, fault: Fault) -> Fault {
        self.waiting = 0;
        self.controls.iter_mut().for_each(|control| control.waits = false);
        self.stage = Stage::Faulted(fault.clone());
        fault
    }

    /// Lets every vehicle drive until time 0; the run begins where all have.
    fn settle(&mut self, observer: &mut dyn Observer) -> Result<(), Fault> {
        self.now.vehicles.clear();
        let vehicles = self.world.vehicles.iter().zip(&mut self.users.vehicles);
        for (vehicle, ((setup, driven), control)) in vehicles.zip(&mut self.controls).enumerate() {
            match control.settle(self.world.step, driven) {
                Ok(Some(settled)) => self.now.vehicles.push(placed(&self.world, setup, settled)),
                Ok(None) => self.waiting += 1,
                Err(error) => {
                    return Err(Fault::Controller { vehicle, time: control.shown().time, error });
                }
            }
        }
        if self.waiting == 0 {
            // Moments are known to a step; what is wrong beyond that was found when the run was planned.
            if let Some(past) = past_arrival(&self.world, &self.now, self.world.step) {
                return Err(Fault::PastArrival(past));
            }
            self.next.clone_from(&self.now);
            self.between.clone_from(&self.now);
            observer.begin(&self.now);
            self.stage = Stage::Ask;
        }
        Ok(())
    }

    /// Lets pedestrians appear and asks every vehicle that is due what it does from now on.
    fn ask(&mut self) -> Result<(), Fault> {
        let time = self.time();
        self.newcomers.clear();
        let setups = self.world.pedestrians.iter().zip(&self.meetings).zip(&mut self.earlier);
        for (index, (state, ((setup, meeting), (_, late)))) in
            self.now.pedestrians.iter_mut().zip(setups).enumerate()
        {
            if state.present {
                continue;
            }
            let comes = match setup.appears {
                Appearance::At(start) => time >= start - TIME_TOLERANCE,
                Appearance::TimeToArrival { vehicle, reference, time: wanted } => {
                    let car = &self.now.vehicles[vehicle];
                    let left = car.time_to_arrival(*meeting, reference);
                    left <= wanted + TIME_TOLERANCE
                }
                Appearance::Meeting { vehicle, time: wanted, .. } => {
                    let left = self.now.vehicles[vehicle].time_to_arrival(*meeting, VehicleReference::Front);
                    let comes = left - wanted < self.world.step - TIME_TOLERANCE;
                    *late = if comes { (left - wanted).max(0.0) } else { 0.0 };
                    comes
                }
            };
            state.present = match &mut self.postponed {
                None => comes,
                Some(postponed) => postponed.appears(index, time, comes, late),
            };
            if state.present {
                self.newcomers.push(index);
            }
        }
        self.refuse_occupied_places(time)?;
        if let Some(permissions) = &mut self.permissions {
            // A pedestrian that appears later than in the run that it is compared with may go at once.
            let past = permissions.update(&self.world, &self.now, time);
            if let (Some(past), None) = (past, &self.postponed) {
                return Err(Fault::PastArrival(past));
            }
        }
        self.stage = Stage::Act;
        self.release();
        self.ask_vehicles(time, false)
    }

    /// Refuses pedestrians that appear inside another body, unless the run is one in which a pedestrian appears later than in the run that it
    /// is compared with: that pedestrian may appear where a vehicle is, which is a collision.
    ///
    /// # Errors
    /// The first of them.
    fn refuse_occupied_places(&self, time: f64) -> Result<(), Fault> {
        if self.postponed.is_some() {
            return Ok(());
        }
        let occupied = |pedestrian: &usize| {
            let by = occupied_by(&self.world, &self.now, *pedestrian)?;
            Some(Fault::Occupied { pedestrian: *pedestrian, by, time })
        };
        self.newcomers.iter().find_map(occupied).map_or(Ok(()), Err)
    }

    /// Lets a vehicle decide for itself again once the pedestrian that it decelerates for has left its lane.
    fn release(&mut self) {
        let Some((vehicle, pedestrian)) = self.decelerates else { return };
        let car = (&self.now.vehicles[vehicle], &self.world.vehicles[vehicle]);
        if self.now.pedestrians[pedestrian].present && has_crossed(&self.world, &self.now, pedestrian, car) {
            self.otherwise(vehicle).change = None;
            self.decelerates = None;
        }
    }

    /// Asks every vehicle whose moment is `time` (s), everybody being where they are now or between two steps.
    fn ask_vehicles(&mut self, time: f64, between: bool) -> Result<(), Fault> {
        let state = if between { &self.between } else { &self.now };
        for (vehicle, control) in self.controls.iter_mut().enumerate() {
            control.take_effect(time);
            if control.is_due(time) {
                let driven = &mut self.users.vehicles[vehicle];
                let road = self.world.road_of(&self.world.vehicles[vehicle]);
                let done = control.decide(driven, time, vehicle, (state, &mut self.abreast), road);
                if control.looks() {
                    let moment = time - self.index as f64 * self.world.step;
                    control.tell_sightings(vehicle, moment, &mut self.sightings);
                }
                match done {
                    Ok(Some(mode)) => self.vehicle_modes[vehicle] = mode,
                    Ok(None) => self.waiting += 1,
                    Err(error) => return Err(Fault::Controller { vehicle, time, error }),
                }
            }
        }
        Ok(())
    }

    /// Asks every pedestrian what it does from now on.
    fn act(&mut self) {
        let time = self.time();
        for (index, pedestrian) in self.users.pedestrians.iter_mut().enumerate() {
            if self.now.pedestrians[index].present {
                self.earlier[index].0 = self.motions[index];
                let now = &mut self.now.pedestrians[index];
                let shown = self.keep_clear.as_ref().and_then(|rule| rule.shown(index, now));
                let real = shown.map(|shown| std::mem::replace(now, shown));
                let (legs, step) = (&mut self.legs[index], self.world.step);
                let another = legs.reaches(&self.now.pedestrians[index]);
                let scene = Scene {
                    time,
                    step,
                    road: &self.world.road,
                    crossing: self.world.pedestrians[index].crossing,
                    me: index,
                    goal: self.ways[index].goal(self.now.pedestrians[index].position, legs.goal()),
                    legs: legs.counts(),
                    vehicles: &self.now.vehicles,
                    pedestrians: &self.now.pedestrians,
                    held: self.wait_for_green.as_ref().is_some_and(|rule| rule.is_held(index)),
                };
                if another {
                    pedestrian.begin_leg(&scene);
                }
                if self.permissions.as_ref().is_none_or(|permissions| permissions.may_go()[index]) {
                    let motion = pedestrian.act(&scene);
                    self.motions[index] = legs.held(scene.ego(), motion, |state, motion| {
                        self.ways[index].walk(state, motion, step, step);
                    });
                    self.pedestrian_modes[index] = pedestrian.mode();
                } else {
                    pedestrian.look(&scene);
                    self.motions[index] = Motion::Walk(Vector2::zeros());
                    self.pedestrian_modes[index] = Mode::new("looking");
                }
                if let Some(real) = real {
                    self.now.pedestrians[index] = real;
                }
            }
        }
        if let Some(rule) = &mut self.keep_clear {
            let (ways, step) = (&self.ways, self.world.step);
            rule.bend(&self.now.pedestrians, &mut self.motions, step, |index, state, motion| {
                ways[index].walk(state, motion, step, step);
            });
        }
        if let Some(rule) = &mut self.wait_for_green {
            let (ways, step, now) = (&self.ways, self.world.step, (&self.world.road, time));
            let modes = &mut self.pedestrian_modes;
            let people = (&self.now.pedestrians[..], &self.legs[..]);
            rule.hold(now, people, &mut self.motions, modes, |index, state, motion| {
                ways[index].walk(state, motion, step, step);
            });
        }
        put(&mut self.next.vehicles, &self.now.vehicles);
        self.stage = Stage::Drive(0.0);
    }

    /// Moves the vehicles, of which `driven` s of the step are done, to the next moment at which one of them decides, or to
    /// the end of the step.
    fn drive(&mut self, driven: f64, observer: &mut dyn Observer) -> Result<(), Fault> {
        let (time, step) = (self.time(), self.world.step);
        let end = (self.index + 1) as f64 * step;
        let next = self.controls.iter().filter_map(|control| control.due_before(end)).reduce(f64::min);
        if let Some(moment) = next {
            self.drive_on(time + driven, moment - time - driven);
            let driven = moment - time;
            self.walk(driven);
            put(&mut self.between.vehicles, &self.next.vehicles);
            self.between.pedestrians.clone_from(&self.next.pedestrians);
            self.stage = Stage::Drive(driven);
            return self.ask_vehicles(moment, true);
        }
        self.drive_on(time + driven, step - driven);
        if driven > 0.0 {
            for (before, after) in self.now.vehicles.iter().zip(&mut self.next.vehicles) {
                after.motion.acceleration = (after.motion.speed - before.motion.speed) / step;
            }
        }
        self.walk(step);
        self.next.vehicles.iter_mut().for_each(VehicleState::know_pose);
        let touches = self.contacts.find(&self.now, &self.next, step);
        if let Some(permissions) = &mut self.permissions {
            permissions.note_touches(touches);
        }
        let ending = self.observe(time, observer);
        if let Some(Ending { reason: StopReason::Horizon, time }) = ending
            && let Some((pedestrian, may_go)) =
                self.permissions.as_ref().and_then(|permissions| permissions.never(&self.world))
        {
            return Err(Fault::NeverMayGo { pedestrian, may_go, time });
        }
        self.stage = ending.map_or(Stage::Ask, Stage::Ended);
        Ok(())
    }

    /// Tells of the step that was moved by, and goes over to the next one; how the run ended, if it did.
    fn observe(&mut self, time: f64, observer: &mut dyn Observer) -> Option<Ending> {
        let collision = self.contacts.collision().filter(|_| self.world.end_on_collision);
        if let Some(moment) = collision {
            self.contacts.end_at(moment);
        }
        self.locate();
        let step = Step {
            time,
            duration: self.world.step,
            before: &self.now,
            after: &self.next,
            whole: &self.next,
            pedestrian_modes: &self.pedestrian_modes,
            vehicle_modes: &self.vehicle_modes,
            motions: &self.motions,
            contacts: self.contacts.found(),
            sightings: &self.sightings,
            abreast: &self.abreast,
            may_go: self.permissions.as_ref().map(Permissions::may_go),
            minds: Minds::new(&self.users.pedestrians),
            views: Views::new(&self.controls, &self.users.vehicles),
        };
        if let Some(moment) = collision {
            // Once in a run, its last step; so it may allocate.
            let after = step.at(moment);
            observer.observe(&Step { duration: moment, after: &after, ..step });
            let ending = Ending { reason: StopReason::Collision, time: time + moment };
            observer.end(&ending, &after);
            return Some(ending);
        }
        observer.observe(&step);
        if !self.sightings.is_empty() {
            self.sightings.clear();
        }
        std::mem::swap(&mut self.now, &mut self.next);
        self.index += 1;
        let reason = if self.is_complete() {
            StopReason::Completed
        } else if self.index == self.steps {
            StopReason::Horizon
        } else {
            return None;
        };
        let ending = Ending { reason, time: self.time() };
        observer.end(&ending, &self.now);
        Some(ending)
    }

    /// Where everybody is at the end of the step, seen from vehicles whose paths bend.
    fn locate(&mut self) {
        if self.abreast.is_empty() {
            return;
        }
        for (vehicle, car) in self.next.vehicles.iter().enumerate() {
            for (pedestrian, person) in self.next.pedestrians.iter().enumerate() {
                if person.present && car.path.course().is_some() {
                    self.abreast.locate(vehicle, &car.path, pedestrian, person.position);
                }
            }
        }
    }

    /// At which the step under way begins, s.
    fn time(&self) -> f64 {
        self.index as f64 * self.world.step
    }

    /// Moves the vehicles on by `duration` (s) from `time` (s).
    fn drive_on(&mut self, time: f64, duration: f64) {
        let controlled = self.controls.iter_mut().zip(&mut self.users.vehicles);
        for (state, (control, driven)) in self.next.vehicles.iter_mut().zip(controlled) {
            control.drive(time, duration, state, driven);
        }
    }

    /// Puts the pedestrians of `next` where they are `duration` s after those of `now`.
    fn walk(&mut self, duration: f64) {
        self.next.pedestrians.clone_from(&self.now.pedestrians);
        for (index, state) in self.next.pedestrians.iter_mut().enumerate() {
            if state.present {
                let (way, step) = (&self.ways[index], self.world.step);
                let (earlier, late) = self.earlier[index];
                let before = late.min(duration);
                if before > 0.0 {
                    way.walk(state, earlier, before, step);
                }
                if duration > before {
                    way.walk(state, self.motions[index], duration - before, step);
                }
            }
        }
    }

    /// Whether everybody whom the run waits for has arrived.
    fn is_complete(&mut self) -> bool {
        let (postponed, time) = (&self.postponed, self.time());
        let comes = |index: usize| postponed.as_ref().is_none_or(|one| !one.never(index));
        self.arrivals.are_complete(&self.world, &self.now, time, comes)
    }
}

/// Puts vehicles where the same ones are in another state: how they move and where they are steered is all that changes in a run.
fn put(vehicles: &mut [VehicleState], others: &[VehicleState]) {
    for (vehicle, other) in vehicles.iter_mut().zip(others) {
        vehicle.motion = other.motion;
        vehicle.steered = other.steered;
    }
}

/// How long a pedestrian takes from its appearance until it has gone so far (m), with nobody else in the world; `None` if it does not
/// within `longest` s.
pub fn walking_time(
    mind: &mut dyn Pedestrian,
    setup: &PedestrianSetup,
    world: &World,
    distance: f64,
    longest: f64,
) -> Option<f64> {
    let way = Way::new(setup);
    let mut state = PedestrianState { present: true, ..waiting_outside((setup, &way)) };
    let gone = |state: &PedestrianState| walked(setup, state.position);
    let mut legs = Legs::new(setup);
    for index in 0..steps_within(longest, world.step) {
        let another = legs.reaches(&state);
        let scene = Scene {
            time: index as f64 * world.step,
            step: world.step,
            road: &world.road,
            crossing: setup.crossing,
            me: 0,
            goal: way.goal(state.position, legs.goal()),
            legs: legs.counts(),
            vehicles: &[],
            pedestrians: &[state],
            held: false,
        };
        if another {
            mind.begin_leg(&scene);
        }
        let (time, motion) = (scene.time, mind.act(&scene));
        let motion = legs.held(scene.ego(), motion, |state, motion| {
            way.walk(state, motion, world.step, world.step);
        });
        let before = gone(&state);
        way.walk(&mut state, motion, world.step, world.step);
        let after = gone(&state);
        if after >= distance {
            let part = if after > before { (distance - before) / (after - before) } else { 0.0 };
            return Some(time + part.max(0.0) * world.step);
        }
    }
    None
}

#[cfg(test)]
mod tests;
