//! Runs with simple road users, whoever decides for them.

use super::*;
use crate::Order;
use crate::road_users::{Driven, Driver};
use crate::{SpeedPlan, fixture};
use scenario::agent::{Controller, Dynamics, Longitudinal, ModelError, Pedestrian, Schedule};
use scenario::{
    CommandKind, ControllerContext, ControllerModel, Declaration, Direction, TrafficStream, VehicleReference,
    VehicleSetup, VehicleStart,
};

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

    fn act(&mut self, _: &Observation) -> Result<Command, ControllerError> {
        Ok(Command::Acceleration(0.0))
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

fn users(controller: Box<dyn Controller>, walking: f64) -> RoadUsers {
    RoadUsers {
        vehicles: vec![Driven::new(controller, Box::new(Exact))],
        pedestrians: vec![Box::new(Stroller(walking))],
    }
}

fn run(world: &World, walking: f64) -> (Ending, Last) {
    let mut last = Last::default();
    let ending = simulate(&Arc::new(world.clone()), users(Box::new(Coasting), walking), &mut last).unwrap();
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

/// Which controller cannot decide, when and why.
fn undecided(fault: &Fault) -> (usize, f64, &ControllerError) {
    let Fault::Controller { vehicle, time, error } = fault else { panic!("{fault}") };
    (*vehicle, *time, error)
}

/// What keeps a run from its end.
fn fault(world: &World) -> Fault {
    let users = users(Box::new(Coasting), 1.0);
    simulate(&Arc::new(world.clone()), users, &mut Last::default()).expect_err("it cannot go on")
}

#[test]
fn a_time_to_arrival_that_is_past_at_the_start_is_a_fault() {
    // The centre is 5 s away, and a moment is known to a step of 25 ms.
    let world = |time: f64| {
        let appears = Appearance::TimeToArrival { vehicle: 0, reference: VehicleReference::Centre, time };
        world(10.0, VehicleStart::Distance(50.0), appears)
    };
    assert_eq!(run(&world(5.02), 1.0).1.appeared_at, Some(0.0));
    let Fault::PastArrival(past) = fault(&world(8.0)) else { panic!("it is past") };
    assert_eq!((past.pedestrian, past.vehicle, past.wanted, past.left), (0, 0, 8.0, 5.0));
    // The vehicle has passed the place.
    let mut behind = world(1.0);
    behind.vehicles[0].start = VehicleStart::Distance(-10.0);
    let Fault::PastArrival(past) = fault(&behind) else { panic!("it is past") };
    assert_eq!(past.left, -1.0);
}

#[test]
fn a_place_that_is_occupied_when_somebody_appears_is_a_fault() {
    // The car is on the crossing after 5 s; it ends in that, and not in a collision.
    let mut in_the_car = world(10.0, VehicleStart::Distance(50.0), Appearance::At(5.0));
    in_the_car.pedestrians[0].start.y = 0.0;
    let occupied = Fault::Occupied { pedestrian: 0, by: Solid::Vehicle(0), time: 5.0 };
    assert_eq!(fault(&in_the_car), occupied);
    // A second later it is gone.
    in_the_car.pedestrians[0].appears = Appearance::At(6.0);
    assert_eq!(run(&in_the_car, 1.0).0.reason, StopReason::Completed);

    // The first walks at 1 m/s and is 1 m on after 1 s, where the second appears; 2 s later the place is free.
    let mut crowded = world(10.0, VehicleStart::Distance(100.0), Appearance::At(0.0));
    let mut second = crowded.pedestrians[0].clone();
    (second.name, second.start.y, second.appears) = ("second".into(), -3.0, Appearance::At(1.0));
    crowded.pedestrians.push(second);
    let both = |world: &World| {
        let mut users = users(Box::new(Coasting), 1.0);
        users.pedestrians.push(Box::new(Stroller(1.0)));
        simulate(&Arc::new(world.clone()), users, &mut Last::default())
    };
    let occupied = Fault::Occupied { pedestrian: 1, by: Solid::Pedestrian(0), time: 1.0 };
    assert_eq!(both(&crowded), Err(occupied));
    crowded.pedestrians[1].appears = Appearance::At(3.0);
    assert_eq!(both(&crowded).map(|ending| ending.reason), Ok(StopReason::Completed));
    // Bodies that touch are beside each other.
    (crowded.pedestrians[1].appears, crowded.pedestrians[1].start.y) = (Appearance::At(1.0), -2.5);
    assert!(both(&crowded).is_ok());
}

/// Drives at once with what it is asked for.
struct Gently;

impl Controller for Gently {
    fn schedule(&self) -> Schedule {
        Schedule::every(0.025)
    }

    fn settling_time(&self) -> f64 {
        5.0
    }

    fn act(&mut self, seen: &Observation) -> Result<Command, ControllerError> {
        Ok(Command::Acceleration(if seen.ego.speed < seen.cruise_speed { 2.0 } else { 0.0 }))
    }
}

struct Following;

impl Dynamics for Following {
    fn advance(&mut self, motion: &mut Longitudinal, command: Command, step: f64) {
        let Command::Acceleration(acceleration) = command else { panic!("it is one") };
        motion.travelled += motion.speed * step + acceleration * step * step / 2.0;
        motion.speed += acceleration * step;
    }
}

#[test]
fn a_vehicle_may_start_with_another_speed_than_that_of_its_cruise() {
    let appears = Appearance::TimeToArrival { vehicle: 0, reference: VehicleReference::Centre, time: 4.0 };
    let start = VehicleStart::TimeToArrival { time: 4.0, reference: VehicleReference::Centre, x: 0.0 };
    let mut world = world(10.0, start, appears);
    world.vehicles[0].initial_speed = Some(0.0);
    let mut users = users(Box::new(Gently), 1.0);
    users.vehicles[0].dynamics = Box::new(Following);
    let mut last = Last::default();
    let mut course = Course::start(Arc::new(world.clone()), users);
    course.settle(&mut last).unwrap();
    let begun = course.now.vehicles[0].motion;
    // Placed by the speed of its cruise, it stands there at the start, and has not settled to anything else.
    assert_eq!((begun.travelled, begun.speed), (-40.0, 0.0));
    course.next(&mut last).unwrap();
    // At 2 m/s²: 40 - t² = 4 · 2 t, at 3.48 s.
    let appeared = last.appeared_at.unwrap();
    assert!((appeared - 3.48).abs() < 0.03, "{appeared}");
}

#[test]
fn a_backward_lane_mirrors_what_the_ego_sees() {
    let mut world = world(10.0, VehicleStart::Distance(50.0), Appearance::At(0.0));
    world.road.lanes[0].direction = Direction::Backward;
    let mut users = users(Box::new(Coasting), 1.0);
    users.vehicles[0].driver = outside(0.025, 0.0);
    let mut course = Course::start(Arc::new(world), users);
    assert_eq!(course.next(&mut Last::default()), Ok(Progress::Waits));
    let (_, seen) = course.asked().next().unwrap();
    assert_eq!(seen.pedestrians[0].position, Vector2::new(50.0, 4.0));
    assert_eq!(seen.ego.distance_to_crossing, 50.0);
    assert_eq!(course.now.vehicles[0].position(), Vector2::new(50.0, 0.0));
}

fn outside(period: f64, settling_time: f64) -> Driver {
    Driver::Outside { schedule: Schedule::every(period), settling_time }
}

/// Cannot decide from a moment on.
struct Failing(f64);

impl Controller for Failing {
    fn schedule(&self) -> Schedule {
        Schedule::every(0.07)
    }

    fn settling_time(&self) -> f64 {
        1.0
    }

    fn act(&mut self, seen: &Observation) -> Result<Command, ControllerError> {
        match seen.time < self.0 - 1e-9 {
            true => Ok(Command::Acceleration(0.0)),
            false => Err(ControllerError::new("lane is None")),
        }
    }
}

#[test]
fn a_controller_that_cannot_decide_ends_the_run_there() {
    let world = Arc::new(world(10.0, VehicleStart::Distance(50.0), Appearance::At(0.0)));
    // Its moments are multiples of 70 ms, counted from the start, and before it from 1 s before.
    for (from, at) in [(-9.0, -1.0), (-0.5, -0.44), (0.0, 0.0), (0.5, 0.56), (3.0, 3.01)] {
        let mut course = Course::start(world.clone(), users(Box::new(Failing(from)), 0.0));
        let fault = course.next(&mut Last::default()).unwrap_err();
        let (vehicle, time, error) = undecided(&fault);
        assert_eq!((vehicle, error.message.as_str()), (0, "lane is None"));
        assert!((time - at).abs() < 1e-9, "{time} instead of {at}");
        // It never ends in any other way.
        assert_eq!(course.next(&mut Last::default()), Err(fault));
    }
    assert!(simulate(&world, users(Box::new(Failing(99.0)), 0.0), &mut Last::default()).is_ok());
}

#[test]
fn a_command_that_no_vehicle_can_follow_is_a_fault() {
    let world = Arc::new(world(10.0, VehicleStart::Distance(50.0), Appearance::At(0.0)));
    let pedals = |throttle, brake| Command::Pedals { throttle, brake };
    for command in [
        Command::Acceleration(f64::NAN),
        Command::Acceleration(f64::NEG_INFINITY),
        pedals(f64::NAN, 0.0),
        pedals(0.0, f64::INFINITY),
    ] {
        let mut users = users(Box::new(Coasting), 0.0);
        users.vehicles[0].driver = outside(0.1, 0.0);
        let mut course = Course::start(world.clone(), users);
        let mut last = Last::default();
        assert_eq!(course.next(&mut last), Ok(Progress::Waits));
        course.decide(0, Command::Acceleration(0.0), Mode::NONE).unwrap();
        assert_eq!(course.next(&mut last), Ok(Progress::Waits));
        let fault = course.decide(0, command, Mode::NONE).unwrap_err();
        assert!((undecided(&fault).1 - 0.1).abs() < 1e-9, "{fault}");
        assert_eq!((course.asked().count(), course.next(&mut last)), (0, Err(fault)));
    }
}

/// Decides at moments that do not go on, or always at the same, as a period of `NaN` and of 0 s say.
struct Stuck(f64);

impl Controller for Stuck {
    fn schedule(&self) -> Schedule {
        Schedule::every(self.0)
    }

    fn act(&mut self, _: &Observation) -> Result<Command, ControllerError> {
        Ok(Command::Acceleration(0.0))
    }
}

#[test]
fn who_never_decides_again_is_a_fault_and_no_endless_run() {
    let world = Arc::new(world(10.0, VehicleStart::Distance(30.0), Appearance::At(0.0)));
    for period in [0.0, f64::NAN, -1.0] {
        let fault = simulate(&world, users(Box::new(Stuck(period)), 1.0), &mut Last::default()).unwrap_err();
        assert!(undecided(&fault).2.to_string().contains("as the last one"), "{period}: {fault:?}");
    }
}

#[test]
fn what_a_controller_gives_is_what_it_is_declared_to_give() {
    let build = |_: &ControllerContext| Err(ModelError::new("never built"));
    let declared = ControllerModel::new(Declaration::new("own", ""), CommandKind::Acceleration, build);
    let mut world = world(10.0, VehicleStart::Distance(50.0), Appearance::At(0.0));
    world.vehicles[0].controller.model = (&Arc::new(declared)).into();
    let given = |command| {
        let mut users = users(Box::new(Coasting), 0.0);
        users.vehicles[0].driver = outside(0.1, 0.0);
        let mut course = Course::start(Arc::new(world.clone()), users);
        assert_eq!(course.next(&mut Last::default()), Ok(Progress::Waits));
        course.decide(0, command, Mode::NONE)
    };
    assert!(given(Command::Acceleration(1.0)).is_ok());
    let fault = given(Command::Pedals { throttle: 0.2, brake: 0.0 }).unwrap_err();
    assert!(fault.to_string().contains("declared to give Acceleration"), "{fault}");
}

#[test]
fn without_anybody_outside_nobody_decides() {
    let world = Arc::new(world(10.0, VehicleStart::Distance(50.0), Appearance::At(0.0)));
    let mut users = users(Box::new(Coasting), 0.0);
    users.vehicles[0].driver = outside(0.1, 1.0);
    let fault = simulate(&world, users, &mut Last::default()).unwrap_err();
    let (_, time, error) = undecided(&fault);
    assert_eq!((time, error.message.as_str()), (-1.0, "nobody decides for it"));
}

#[test]
fn a_course_waits_until_all_who_are_asked_have_decided() {
    let mut world = world(10.0, VehicleStart::Distance(50.0), Appearance::At(0.0));
    let mut other = world.vehicles[0].clone();
    (other.name, other.start) = ("other".into(), VehicleStart::Distance(80.0));
    world.vehicles.push(other);
    let mut users = users(Box::new(Coasting), 0.0);
    users.vehicles.push(Driven::new(Box::new(Coasting), Box::new(Exact)));
    (users.vehicles[0].driver, users.vehicles[1].driver) = (outside(0.04, 0.0), outside(0.1, 0.05));
    let mut course = Course::start(Arc::new(world), users);
    let mut last = Last::default();
    let mut asked = Vec::new();
    while asked.len() < 8 {
        assert_eq!(course.next(&mut last), Ok(Progress::Waits));
        let now: Vec<_> = course.asked().map(|(who, seen)| (who, seen.time)).collect();
        asked.extend(now.iter().map(|(who, time)| (*who, (time * 1e3).round())));
        for (index, (who, _)) in now.iter().enumerate() {
            // As often as one likes: nothing goes on without all of them.
            assert_eq!(course.next(&mut last), Ok(Progress::Waits));
            assert_eq!(course.asked().count(), now.len() - index);
            course.decide(*who, Command::Acceleration(0.0), Mode::from("told".to_string())).unwrap();
        }
    }
    let expected = [(1, -50.0), (0, 0.0), (1, 0.0), (0, 40.0), (0, 80.0), (1, 100.0), (0, 120.0), (0, 160.0)];
    assert_eq!(asked, expected);
}

#[test]
fn a_course_may_go_from_thread_to_thread() {
    fn is_send<T: Send>() {}
    is_send::<Course>();
}

/// Does what it is told.
struct Obeying;

impl Dynamics for Obeying {
    fn advance(&mut self, motion: &mut Longitudinal, command: Command, step: f64) {
        let Command::Acceleration(acceleration) = command else {
            unreachable!("only accelerations are given")
        };
        motion.acceleration = acceleration;
        motion.speed += acceleration * step;
        motion.travelled += motion.speed * step;
    }
}

#[derive(Default)]
struct Accelerations(Vec<(f64, f64)>);

impl Observer for Accelerations {
    fn observe(&mut self, step: &Step) {
        let acceleration = (step.after.vehicles[0].motion.acceleration * 1e6).round() / 1e6;
        if self.0.last().is_none_or(|(_, last)| *last != acceleration) {
            self.0.push((step.time, acceleration));
        }
    }
}

/// The accelerations of a run, where they change, whose decisions (counted from 0) are `order` and take effect `delay` s later.
fn delayed(
    settling: f64,
    delay: impl Fn(usize) -> f64,
    order: impl Fn(usize) -> Order,
    decisions: usize,
) -> Vec<(f64, f64)> {
    let world = Arc::new(world(10.0, VehicleStart::Distance(50.0), Appearance::At(0.0)));
    let mut users = users(Box::new(Coasting), 0.0);
    users.vehicles[0] =
        Driven { driver: outside(0.1, settling), perception: None, dynamics: Box::new(Obeying) };
    let (mut course, mut seen) = (Course::start(world, users), Accelerations::default());
    for decision in 0..decisions {
        assert_eq!(course.next(&mut seen), Ok(Progress::Waits));
        course.decide_later(0, order(decision), delay(decision), Mode::NONE).unwrap();
    }
    course.next(&mut seen).unwrap();
    seen.0
}

fn accelerate(decision: usize) -> Order {
    Order::Command(Command::Acceleration((decision as f64 + 1.0) / 100.0))
}

#[test]
fn a_decision_takes_effect_after_its_delay_and_holds_until_the_next_one_does() {
    let rounded = |seen: Vec<(f64, f64)>| -> Vec<(f64, f64)> {
        seen.into_iter().map(|(time, value)| ((time * 1e3).round(), value)).collect()
    };
    let at_once = rounded(delayed(0.0, |_| 0.0, accelerate, 4));
    assert_eq!(at_once, [(0.0, 0.01), (100.0, 0.02), (200.0, 0.03), (300.0, 0.04)]);
    // Longer than the period: until the first takes effect, nothing was decided.
    let late = rounded(delayed(0.0, |_| 0.15, accelerate, 4));
    assert_eq!(late, [(0.0, 0.0), (150.0, 0.01), (250.0, 0.02), (350.0, 0.03)]);
    // What was decided while settling holds on until the first decision of the run takes effect.
    let settled = rounded(delayed(0.2, |_| 0.05, accelerate, 4));
    assert_eq!(settled, [(0.0, 0.02), (50.0, 0.03), (150.0, 0.04)]);
    // Of two the later decision counts, however long the earlier one still takes.
    let overtaken = |decision| if decision == 0 { 0.35 } else { 0.0 };
    assert_eq!(rounded(delayed(0.0, overtaken, accelerate, 4))[..2], [(0.0, 0.0), (100.0, 0.02)]);
}

#[test]
fn a_plan_is_followed_from_when_it_takes_effect() {
    let plan = |_| Order::Plan(Box::new(SpeedPlan::new(vec![(0.0, 10.0), (1.0, 9.0)]).unwrap()));
    let seen = delayed(0.0, |_| 0.05, plan, 1);
    assert_eq!((seen[0], seen[1].0), ((0.0, 0.0), 0.05));
    assert!((seen[1].1 + 1.0).abs() < 1e-9, "{seen:?}");
}

/// Cars at 10 m/s that are due at these moments (s), as one stream, and a stroller who is in their lane from 2 s to 6 s.
fn streamed(due: &[f64]) -> World {
    let start = |time: f64| VehicleStart::TimeToArrival { time, reference: VehicleReference::Centre, x: 0.0 };
    let mut world = world(10.0, start(0.0), Appearance::At(0.0));
    let cars = due.iter().map(|time| VehicleSetup { start: start(*time), ..world.vehicles[0].clone() });
    world.vehicles = cars.collect();
    let vehicles = (0..due.len()).collect();
    world.streams = vec![TrafficStream { name: "cars".into(), vehicles, arrivals: due.to_vec() }];
    world.end_on_collision = false;
    world
}

fn streamed_end(world: &World, walking: f64) -> (StopReason, f64) {
    let strollers = world.pedestrians.iter().map(|_| Box::new(Stroller(walking)) as Box<dyn Pedestrian>);
    let driven = world.vehicles.iter().map(|_| Driven::new(Box::new(Coasting), Box::new(Exact)));
    let users = RoadUsers { vehicles: driven.collect(), pedestrians: strollers.collect() };
    let ending = simulate(&Arc::new(world.clone()), users, &mut Last::default()).unwrap();
    (ending.reason, ending.time)
}

#[test]
fn of_a_stream_a_run_waits_for_who_closes_the_gap_that_was_taken() {
    let ends = |world: &World, walking: f64, expected: f64| {
        let (reason, time) = streamed_end(world, walking);
        assert_eq!(reason, StopReason::Completed);
        assert!((time - expected).abs() < 0.03, "{time} s and not {expected} s");
    };
    // It takes 2 s to the finish line.
    let due = [1.0, 9.0, 12.0, 15.0];
    ends(&streamed(&due), 1.0, 11.0);
    ends(&streamed(&[1.0, 5.9, 12.0, 15.0]), 1.0, 14.0);
    // Nobody comes after the gap, or it closes before the pedestrian is across.
    ends(&streamed(&[1.0, 2.0]), 1.0, 6.0);
    ends(&streamed(&[-9.0, 3.0, 4.0, 30.0, 31.0]), 0.5, 32.0);
    // Vehicles outside of streams are waited for, and a second stream by its own gap.
    let mut mixed = streamed(&due);
    mixed.streams[0].vehicles.pop();
    mixed.streams[0].arrivals.pop();
    ends(&mixed, 1.0, 17.0);
    mixed.streams.push(TrafficStream { name: "far".into(), vehicles: vec![3], arrivals: vec![15.0] });
    ends(&mixed, 1.0, 17.0);
    // Without pedestrians, and where nothing is said of streams, every vehicle is.
    let mut empty = streamed(&due);
    empty.pedestrians.clear();
    ends(&empty, 1.0, 17.0);
    let mut unsaid = streamed(&due);
    unsaid.streams.clear();
    ends(&unsaid, 1.0, 17.0);
    // Somebody never arrives.
    assert_eq!(streamed_end(&streamed(&due), 0.0), (StopReason::Horizon, 60.0));
}

#[test]
fn whoever_comes_back_into_the_lane_of_a_stream_takes_another_gap() {
    /// Out of the lane at 6 s, in it again from 8 s to 12 s.
    struct Returns;
    impl Pedestrian for Returns {
        fn act(&mut self, scene: &Scene) -> Motion {
            let back = (7.0..9.0).contains(&scene.time);
            Motion::Walk(Vector2::new(0.0, if back { -1.0 } else { 1.0 }))
        }

        fn free_speed(&self) -> f64 {
            1.0
        }
    }
    let world = streamed(&[1.0, 20.0, 30.0]);
    let mut early = streamed(&[1.0, 8.5, 20.0, 30.0]);
    early.finish = 5.0;
    for (world, expected) in [(world, 22.0), (early, 20.5)] {
        let driven = world.vehicles.iter().map(|_| Driven::new(Box::new(Coasting), Box::new(Exact)));
        let users = RoadUsers { vehicles: driven.collect(), pedestrians: vec![Box::new(Returns)] };
        let ending = simulate(&Arc::new(world.clone()), users, &mut Last::default()).unwrap();
        assert!((ending.time - expected).abs() < 0.03, "{ending:?} and not {expected} s");
    }
}
