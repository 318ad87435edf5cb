//! The world: one run from settled cruise to its end, step by step.

use nalgebra::Vector2;

use super::contact::{Contacts, Solid};
use super::observer::{Ending, Observer, Step, StopReason};
use crate::scenario::agent::Schedule;
use crate::scenario::agent::{
    Command, Controller, Dynamics, EgoState, Motion, Observation, Pedestrian, RoadView, Scene,
    SeenPedestrian, SeenVehicle,
};
use crate::scenario::agent::{Longitudinal, PedestrianState, Snapshot, VehicleState};
use crate::scenario::{
    Appearance, Direction, PedestrianSetup, Road, Side, VehicleReference, VehicleSetup, VehicleStart, World,
};

/// The minds and bodies of a run, in the order of the world's setups.
pub struct RoadUsers {
    pub vehicles: Vec<Driven>,
    pub pedestrians: Vec<Box<dyn Pedestrian>>,
}

/// A vehicle's controller and the dynamics that it drives.
pub struct Driven {
    pub controller: Box<dyn Controller>,
    pub dynamics: Box<dyn Dynamics>,
}

/// Absorbs the rounding of sums and products when times are compared, s.
const TIME_TOLERANCE: f64 = 1e-9;

/// Where a settling vehicle believes to be: too far from the crossing for it to matter, m.
const FAR_AWAY: f64 = 1e6;

/// The time at which a run ends that nothing ends before its horizon, s: a whole number of steps.
pub fn longest_run(horizon: f64, step: f64) -> f64 {
    steps_within(horizon, step) as f64 * step
}

fn steps_within(horizon: f64, step: f64) -> u64 {
    (horizon / step - TIME_TOLERANCE).ceil().max(1.0) as u64
}

/// Runs `world` to its end. `users` must hold one mind per setup.
///
/// A pure function of its arguments: no clock, no global state, and nothing is allocated after the first step.
pub fn simulate(world: &World, users: &mut RoadUsers, observer: &mut dyn Observer) -> Ending {
    debug_assert_eq!(world.vehicles.len(), users.vehicles.len());
    debug_assert_eq!(world.pedestrians.len(), users.pedestrians.len());
    let mut run = Run::start(world, users);
    observer.begin(&run.now);
    let steps = steps_within(world.horizon, world.step);
    for index in 0..steps {
        let time = index as f64 * world.step;
        run.decide(time, users);
        run.advance(time, (index + 1) as f64 * world.step, users);
        let collision = run.contacts.collision().filter(|_| world.end_on_collision);
        if let Some(moment) = collision {
            run.contacts.end_at(moment);
        }
        let step = Step {
            time,
            duration: world.step,
            before: &run.now,
            after: &run.next,
            whole: &run.next,
            pedestrian_modes: &run.pedestrian_modes,
            vehicle_modes: &run.vehicle_modes,
            motions: &run.motions,
            contacts: run.contacts.found(),
        };
        if let Some(moment) = collision {
            // Once in a run, its last step; so it may allocate.
            let after = step.at(moment);
            observer.observe(&Step { duration: moment, after: &after, ..step });
            let ending = Ending { reason: StopReason::Collision, time: time + moment };
            observer.end(&ending, &after);
            return ending;
        }
        observer.observe(&step);
        std::mem::swap(&mut run.now, &mut run.next);
        if run.is_complete() {
            let ending = Ending { reason: StopReason::Completed, time: (index + 1) as f64 * world.step };
            observer.end(&ending, &run.now);
            return ending;
        }
    }
    let ending = Ending { reason: StopReason::Horizon, time: steps as f64 * world.step };
    observer.end(&ending, &run.now);
    ending
}

/// Whether a vehicle has passed the finish line, or a pedestrian every vehicle's lane. Boxes are where they are.
pub fn has_arrived(world: &World, state: &Snapshot, who: Solid) -> bool {
    match who {
        Solid::Vehicle(index) => state.vehicles[index].motion.travelled >= world.finish,
        Solid::Pedestrian(index) => {
            let (person, sign) = (&state.pedestrians[index], world.pedestrians[index].side.walking_sign());
            let half_lane = world.road.lane_width / 2.0;
            let beyond = |car: &VehicleState| sign * (person.position.y - car.lane_centre) >= half_lane;
            person.present && state.vehicles.iter().all(beyond)
        }
        Solid::Box(_) => true,
    }
}

struct Run<'a> {
    world: &'a World,
    now: Snapshot,
    next: Snapshot,
    /// Where everybody is at a decision inside a step.
    between: Snapshot,
    drivers: Vec<Driver>,
    /// Unit vectors from start to goal.
    ways: Vec<Vector2<f64>>,
    motions: Vec<Motion>,
    pedestrian_modes: Vec<&'static str>,
    vehicle_modes: Vec<&'static str>,
    contacts: Contacts,
}

/// The state of one vehicle's control loop.
struct Driver {
    observation: Observation,
    command: Command,
    schedule: Schedule,
    decisions: u64,
    /// Moment of the next decision, s.
    next: f64,
}

impl Driver {
    fn is_due(&self, time: f64) -> bool {
        time >= self.next - TIME_TOLERANCE
    }

    /// The moment of its next decision if it lies before `end` (s), which is where the next step asks by itself.
    fn due_before(&self, end: f64) -> Option<f64> {
        (self.next < end - TIME_TOLERANCE).then_some(self.next)
    }

    fn decide(&mut self, controller: &mut dyn Controller) {
        self.command = controller.act(&self.observation);
        self.count_from(self.decisions + 1);
    }

    fn count_from(&mut self, decisions: u64) {
        self.decisions = decisions;
        self.next = self.schedule.moment(decisions);
    }
}

impl<'a> Run<'a> {
    fn start(world: &'a World, users: &mut RoadUsers) -> Self {
        let ways: Vec<_> = world.pedestrians.iter().map(way).collect();
        let pedestrians: Vec<_> = world.pedestrians.iter().zip(&ways).map(waiting_outside).collect();
        let drivers: Vec<_> = world.vehicles.iter().map(|setup| Driver::new(world, setup)).collect();
        let mut run = Self {
            world,
            now: Snapshot { vehicles: Vec::new(), pedestrians },
            next: Snapshot { vehicles: Vec::new(), pedestrians: Vec::new() },
            between: Snapshot { vehicles: Vec::new(), pedestrians: Vec::new() },
            drivers,
            motions: vec![Motion::Walk(Vector2::zeros()); ways.len()],
            ways,
            pedestrian_modes: vec![""; world.pedestrians.len()],
            vehicle_modes: vec![""; world.vehicles.len()],
            contacts: Contacts::new(world),
        };
        for ((setup, driver), driven) in world.vehicles.iter().zip(&mut run.drivers).zip(&mut users.vehicles)
        {
            let settled = driver.settle(world, setup, driven);
            run.now.vehicles.push(placed(world, setup, settled));
        }
        run.next.clone_from(&run.now);
        run.between.clone_from(&run.now);
        run
    }

    /// Lets pedestrians appear and asks every road user that is due what it does from now on.
    fn decide(&mut self, time: f64, users: &mut RoadUsers) {
        for (state, setup) in self.now.pedestrians.iter_mut().zip(&self.world.pedestrians) {
            state.present = state.present
                || match setup.appears {
                    Appearance::At(start) => time >= start - TIME_TOLERANCE,
                    Appearance::TimeToArrival { vehicle, reference, time: wanted } => {
                        let left = self.now.vehicles[vehicle].time_to_arrival(setup.start.x, reference);
                        left <= wanted + TIME_TOLERANCE
                    }
                };
        }
        let road = &self.world.road;
        ask_drivers(&mut self.drivers, &mut self.vehicle_modes, users, time, &self.now, road);
        for (index, pedestrian) in users.pedestrians.iter_mut().enumerate() {
            if self.now.pedestrians[index].present {
                self.motions[index] = pedestrian.act(&Scene {
                    time,
                    step: self.world.step,
                    road: &self.world.road,
                    me: index,
                    goal: self.world.pedestrians[index].goal,
                    vehicles: &self.now.vehicles,
                    pedestrians: &self.now.pedestrians,
                });
                self.pedestrian_modes[index] = pedestrian.mode();
            }
        }
    }

    /// Moves everything by one step, from `time` to `end` (s), into `next` and finds who touches whom on the way.
    fn advance(&mut self, time: f64, end: f64, users: &mut RoadUsers) {
        let step = self.world.step;
        // Field by field, as the derived `clone_from` of the whole would allocate anew.
        self.next.vehicles.clone_from(&self.now.vehicles);
        self.drive(time, end, users);
        self.walk(step);
        self.contacts.find(&self.now, &self.next, step);
    }

    /// Moves the vehicles of `next` from `time` to `end` (s), asking controllers whose moment lies in between.
    fn drive(&mut self, time: f64, end: f64, users: &mut RoadUsers) {
        let step = self.world.step;
        let mut driven = 0.0;
        while let Some(moment) =
            self.drivers.iter().filter_map(|driver| driver.due_before(end)).reduce(f64::min)
        {
            self.drive_on(moment - time - driven, users);
            driven = moment - time;
            self.walk(driven);
            self.between.vehicles.clone_from(&self.next.vehicles);
            self.between.pedestrians.clone_from(&self.next.pedestrians);
            let (drivers, modes) = (&mut self.drivers, &mut self.vehicle_modes);
            ask_drivers(drivers, modes, users, moment, &self.between, &self.world.road);
        }
        self.drive_on(step - driven, users);
        if driven > 0.0 {
            for (before, after) in self.now.vehicles.iter().zip(&mut self.next.vehicles) {
                after.motion.acceleration = (after.motion.speed - before.motion.speed) / step;
            }
        }
    }

    fn drive_on(&mut self, duration: f64, users: &mut RoadUsers) {
        for ((state, driver), driven) in
            self.next.vehicles.iter_mut().zip(&self.drivers).zip(&mut users.vehicles)
        {
            driven.dynamics.advance(&mut state.motion, driver.command, duration);
        }
    }

    /// Puts the pedestrians of `next` where they are `duration` s after those of `now`.
    fn walk(&mut self, duration: f64) {
        self.next.pedestrians.clone_from(&self.now.pedestrians);
        for (index, state) in self.next.pedestrians.iter_mut().enumerate() {
            if state.present {
                walk(state, self.motions[index], self.ways[index], duration, self.world.step);
            }
        }
    }

    /// Whether every vehicle has passed the finish line and every pedestrian every vehicle's lane.
    fn is_complete(&self) -> bool {
        let vehicles = (0..self.now.vehicles.len()).map(Solid::Vehicle);
        let mut everybody = vehicles.chain((0..self.now.pedestrians.len()).map(Solid::Pedestrian));
        everybody.all(|who| has_arrived(self.world, &self.now, who))
    }
}

impl Driver {
    fn new(world: &World, setup: &VehicleSetup) -> Self {
        let road = &world.road;
        let direction = road.lanes[setup.lane].direction;
        let centre = road.lane_centre(setup.lane);
        let (near, far) = (road.kerb(Side::Near) - centre, road.kerb(Side::Far) - centre);
        let (right_kerb, left_kerb) = match direction {
            Direction::Forward => (near, far),
            Direction::Backward => (-far, -near),
        };
        let observation = Observation {
            time: 0.0,
            ego: EgoState {
                distance_to_crossing: FAR_AWAY,
                speed: setup.speed,
                acceleration: 0.0,
                length: setup.length,
                width: setup.width,
            },
            cruise_speed: setup.speed,
            road: RoadView {
                lane_width: road.lane_width,
                speed_limit: road.speed_limit,
                crossing_width: road.crossing.width,
                pedestrian_priority: road.pedestrian_priority(0.0),
                right_kerb,
                left_kerb,
            },
            pedestrians: Vec::with_capacity(world.pedestrians.len()),
            vehicles: Vec::with_capacity(world.vehicles.len()),
        };
        let schedule = Schedule::every(world.step);
        Self { observation, command: Command::Acceleration(0.0), schedule, decisions: 0, next: 0.0 }
    }

    /// Drives in free flow until time 0; the motion it has settled to, with `travelled` at 0.
    fn settle(&mut self, world: &World, setup: &VehicleSetup, driven: &mut Driven) -> Longitudinal {
        let mut motion = Longitudinal { travelled: 0.0, speed: setup.speed, acceleration: 0.0 };
        self.schedule = driven.controller.schedule();
        let steps = (driven.controller.settling_time() / world.step).ceil() as u64;
        for index in 0..steps {
            let begin = index as f64 * world.step;
            if self.is_due(begin) {
                self.decide_far_away((index as f64 - steps as f64) * world.step, &motion, driven);
            }
            let mut done = 0.0;
            while let Some(moment) = self.due_before((index + 1) as f64 * world.step) {
                driven.dynamics.advance(&mut motion, self.command, moment - begin - done);
                done = moment - begin;
                self.decide_far_away(moment - steps as f64 * world.step, &motion, driven);
            }
            driven.dynamics.advance(&mut motion, self.command, world.step - done);
        }
        self.count_from(0);
        motion.travelled = 0.0;
        motion
    }

    /// A decision in free flow, `time` (s) being negative: that much before the start.
    fn decide_far_away(&mut self, time: f64, motion: &Longitudinal, driven: &mut Driven) {
        self.observation.time = time;
        self.observation.ego.distance_to_crossing = FAR_AWAY;
        self.observation.ego.speed = motion.speed;
        self.observation.ego.acceleration = motion.acceleration;
        self.decide(&mut *driven.controller);
    }

    /// Fills the observation with the states of `now` as the ego sees them.
    fn see(&mut self, time: f64, me: usize, now: &Snapshot, road: &Road) {
        let ego = &now.vehicles[me];
        let sign = ego.direction.sign();
        let seen = &mut self.observation;
        seen.time = time;
        seen.ego.distance_to_crossing = -ego.motion.travelled;
        seen.ego.speed = ego.motion.speed;
        seen.ego.acceleration = ego.motion.acceleration;
        seen.road.pedestrian_priority = road.pedestrian_priority(time);
        seen.pedestrians.clear();
        seen.pedestrians.extend(now.pedestrians.iter().enumerate().filter(|(_, state)| state.present).map(
            |(id, state)| SeenPedestrian {
                id,
                position: (state.position - ego.position()) * sign,
                velocity: state.velocity * sign,
                acceleration: state.acceleration * sign,
                shape: state.shape,
            },
        ));
        seen.vehicles.clear();
        seen.vehicles.extend(now.vehicles.iter().enumerate().filter(|(id, _)| *id != me).map(
            |(id, state)| SeenVehicle {
                id,
                position: (state.position() - ego.position()) * sign,
                velocity: state.velocity() * sign,
                length: state.length,
                width: state.width,
            },
        ));
    }
}

/// Asks every controller whose moment is `time` (s) what it does from now on, everybody being where `now` says.
fn ask_drivers(
    drivers: &mut [Driver],
    modes: &mut [&'static str],
    users: &mut RoadUsers,
    time: f64,
    now: &Snapshot,
    road: &Road,
) {
    for (index, driver) in drivers.iter_mut().enumerate() {
        if driver.is_due(time) {
            let controller = &mut *users.vehicles[index].controller;
            driver.see(time, index, now, road);
            driver.decide(controller);
            modes[index] = controller.mode();
        }
    }
}

pub(super) fn way(setup: &PedestrianSetup) -> Vector2<f64> {
    let way = Vector2::new(setup.goal.x - setup.start.x, setup.goal.y - setup.start.y);
    way.try_normalize(0.0).unwrap_or_else(|| Vector2::new(0.0, setup.side.walking_sign()))
}

pub(super) fn waiting_outside((setup, way): (&PedestrianSetup, &Vector2<f64>)) -> PedestrianState {
    PedestrianState {
        position: Vector2::new(setup.start.x, setup.start.y),
        velocity: Vector2::zeros(),
        acceleration: Vector2::zeros(),
        heading: *way,
        shape: setup.shape,
        present: false,
    }
}

/// Puts a settled vehicle where its setup wants it at time 0.
pub(super) fn placed(world: &World, setup: &VehicleSetup, settled: Longitudinal) -> VehicleState {
    let direction = world.road.lanes[setup.lane].direction;
    let travelled = match setup.start {
        VehicleStart::Distance(distance) => -distance,
        VehicleStart::TimeToArrival { time, reference, x } => {
            let ahead = match reference {
                VehicleReference::Centre => 0.0,
                VehicleReference::Front => setup.length / 2.0,
            };
            direction.sign() * x - time * settled.speed - ahead
        }
    };
    VehicleState {
        motion: Longitudinal { travelled, ..settled },
        lane_centre: world.road.lane_centre(setup.lane),
        direction,
        length: setup.length,
        width: setup.width,
    }
}

/// Moves a pedestrian by the first `duration` s of a step.
fn walk(state: &mut PedestrianState, motion: Motion, way: Vector2<f64>, duration: f64, step: f64) {
    match motion {
        Motion::Accelerate(acceleration) => {
            let speed = state.velocity.dot(&way).max(0.0);
            let distance = (duration * speed + acceleration * (duration * duration) / 2.0).max(0.0);
            state.position += way * distance;
            state.velocity = way * (speed + acceleration * duration).max(0.0);
            state.acceleration = way * acceleration;
        }
        Motion::Walk(velocity) => {
            state.position += velocity * duration;
            state.acceleration = (velocity - state.velocity) / step;
            state.velocity = velocity;
        }
        Motion::Pushed { velocity, displacement } => {
            state.position += velocity * duration + displacement * (duration / step);
            state.acceleration = (velocity - state.velocity) / step;
            state.velocity = velocity;
        }
    }
    if let Some(heading) = state.velocity.try_normalize(1e-6) {
        state.heading = heading;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::fixture;

    struct Stroller(f64);

    impl Pedestrian for Stroller {
        fn act(&mut self, scene: &Scene) -> Motion {
            let way = scene.ego().heading;
            Motion::Walk(way * self.0)
        }

        fn free_speed(&self) -> f64 {
            self.0
        }
    }

    struct Coasting;

    impl Controller for Coasting {
        fn schedule(&self) -> Schedule {
            Schedule::every(0.025)
        }

        fn act(&mut self, _: &Observation) -> Command {
            Command::Acceleration(0.0)
        }
    }

    struct Exact;

    impl Dynamics for Exact {
        fn advance(&mut self, motion: &mut Longitudinal, _: Command, step: f64) {
            motion.travelled += motion.speed * step;
        }
    }

    #[derive(Default)]
    struct Last {
        steps: usize,
        after: Option<Snapshot>,
        appeared_at: Option<f64>,
    }

    impl Observer for Last {
        fn observe(&mut self, step: &Step) {
            self.steps += 1;
            self.after = Some(step.after.clone());
            if self.appeared_at.is_none() && step.before.pedestrians.first().is_some_and(|p| p.present) {
                self.appeared_at = Some(step.time);
            }
        }
    }

    fn world(speed: f64, start: VehicleStart, appears: Appearance) -> World {
        let mut world = fixture::world();
        (world.vehicles[0].speed, world.vehicles[0].start) = (speed, start);
        world.pedestrians[0].appears = appears;
        world
    }

    fn run(world: &World, walking: f64) -> (Ending, Last) {
        let mut users = RoadUsers {
            vehicles: vec![Driven { controller: Box::new(Coasting), dynamics: Box::new(Exact) }],
            pedestrians: vec![Box::new(Stroller(walking))],
        };
        let mut last = Last::default();
        let ending = simulate(world, &mut users, &mut last);
        (ending, last)
    }

    #[test]
    fn ends_when_everybody_has_passed() {
        let world = world(10.0, VehicleStart::Distance(100.0), Appearance::At(0.0));
        let (ending, last) = run(&world, 1.0);
        assert_eq!(ending.reason, StopReason::Completed);
        // The vehicle needs 12 s to the finish line, the pedestrian 6 s to leave the lane.
        assert!((ending.time - 12.0).abs() < 0.03, "{ending:?}");
        assert_eq!(last.steps as f64 * world.step, ending.time);
    }

    #[test]
    fn collision_time_is_exact_inside_a_step() {
        // The front is at the pedestrian's disc after (50 - 2 - 0.25) / 10 s; he stands in the lane from 4 s on.
        let mut world = world(10.0, VehicleStart::Distance(50.0), Appearance::At(0.0));
        world.pedestrians[0].start.y = 0.0;
        let (ending, _) = run(&world, 0.0);
        assert_eq!(ending.reason, StopReason::Collision);
        assert!((ending.time - 4.775).abs() < 1e-9, "{ending:?}");
    }

    #[test]
    fn a_standing_pedestrian_beside_the_road_lasts_until_the_horizon() {
        let world = world(10.0, VehicleStart::Distance(50.0), Appearance::At(0.0));
        let (ending, last) = run(&world, 0.0);
        assert_eq!((ending.reason, ending.time), (StopReason::Horizon, 60.0));
        assert_eq!(last.steps, 2400);
    }

    #[test]
    fn appears_at_the_time_to_arrival_of_the_part_that_is_meant() {
        let start = VehicleStart::TimeToArrival { time: 8.0, reference: VehicleReference::Centre, x: 0.0 };
        for (reference, expected) in [(VehicleReference::Centre, 2.0), (VehicleReference::Front, 1.8)] {
            let appears = Appearance::TimeToArrival { vehicle: 0, reference, time: 6.0 };
            let (_, last) = run(&world(10.0, start, appears), 1.0);
            let appeared = last.appeared_at.unwrap();
            assert!((appeared - expected).abs() < 1e-9, "{appeared} instead of {expected}");
        }
    }

    #[test]
    fn a_backward_lane_mirrors_what_the_ego_sees() {
        let mut world = world(10.0, VehicleStart::Distance(50.0), Appearance::At(0.0));
        world.road.lanes[0].direction = Direction::Backward;
        let mut driver = Driver::new(&world, &world.vehicles[0]);
        let mut users = RoadUsers {
            vehicles: vec![Driven { controller: Box::new(Coasting), dynamics: Box::new(Exact) }],
            pedestrians: vec![Box::new(Stroller(1.0))],
        };
        let mut run = Run::start(&world, &mut users);
        run.decide(0.0, &mut users);
        driver.see(0.0, 0, &run.now, &world.road);
        assert_eq!(driver.observation.pedestrians[0].position, Vector2::new(50.0, 4.0));
        assert_eq!(driver.observation.ego.distance_to_crossing, 50.0);
        assert_eq!(run.now.vehicles[0].position(), Vector2::new(50.0, 0.0));
    }
}
