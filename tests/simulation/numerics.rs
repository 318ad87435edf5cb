//! What is numerics shows in no result: neither the simulation step, nor the last bit.
//!
//! Every controller on every dynamics that takes its commands meets people who walk by a script. Each encounter runs at
//! a step and at half of it. A controller decides at moments of its own, so its commands can be compared one by one: where
//! they stay alike, every metric is within a stated multiple of the step; where one tips (a threshold is met one period
//! earlier or later, and from there on the runs part), it may not be, and such knife edges are counted apart and are few.

use scenario::MetricKind;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use models::standard;
use models::vehicle::{ControllerModel, DynamicsModel};
use numbers::random::Stream;
use proptest::prelude::*;
use results::Requests;
use runner::run::{FreeFlows, Unwatched, road_users, run_case};
use scenario::{
    Appearance, Case, Dimension, Direction, MayGo, ModelSetup, PedestrianSetup, Position, Road, Settings,
    Shape, Side, Value, VehicleReference, VehicleSetup, VehicleStart, World,
};
use sim::measure::Measurement;
use sim::{
    Command, Controller, ControllerError, Driver, Ending, Mode, Observation, Observer, Schedule, Snapshot,
    Step, StopReason, simulate,
};

/// What was commanded when, s.
type Commands = Arc<Mutex<Vec<(f64, Command)>>>;

/// Takes down what a controller commands.
struct Recorded {
    controller: Box<dyn Controller>,
    commands: Commands,
}

impl Controller for Recorded {
    fn schedule(&self) -> Schedule {
        self.controller.schedule()
    }

    fn settling_time(&self) -> f64 {
        self.controller.settling_time()
    }

    fn act(&mut self, observation: &Observation) -> Result<Command, ControllerError> {
        let command = self.controller.act(observation)?;
        if observation.time >= -1e-9 {
            self.commands.lock().unwrap().push((observation.time, command));
        }
        Ok(command)
    }

    fn curvature(&self) -> Option<f64> {
        self.controller.curvature()
    }

    fn mode(&self) -> Mode {
        self.controller.mode()
    }
}

fn number(value: f64) -> Value {
    Value::Number(value)
}

fn drawn(draws: &mut Stream, low: f64, high: f64) -> f64 {
    draws.uniform_in(low, high)
}

/// One of a few settings of a controller that make it do different things.
fn settings(controller: &str, draws: &mut Stream) -> Settings {
    let mut settings = Settings::default();
    match controller {
        "autoware" => {
            settings.set("crosswalk_mapped", Value::Flag(draws.index(2) == 0));
            settings.set("suppress_sudden_stop", Value::Flag(draws.index(2) == 0));
            settings.set("aeb", Value::Flag(draws.index(3) == 0));
        }
        "carla_behavior" => {
            settings.set("braking_distance", number(drawn(draws, 4.0, 25.0)));
            settings.set("obstacle_distance", Value::Word("extended".into()));
        }
        "idm_aeb" => settings.set("trigger", number(drawn(draws, 0.8, 2.5))),
        "constant_deceleration" => settings.set("distance", number(drawn(draws, 5.0, 30.0))),
        "timeline" => {
            settings
                .set("steps", Value::Word("when distance < d1 speed v1; at t1 stop; after t2 resume".into()));
            settings.set("d1", number(drawn(draws, 10.0, 30.0)));
            settings.set("v1", number(drawn(draws, 1.0, 6.0)));
            settings.set("t1", number(drawn(draws, 4.0, 9.0)));
            settings.set("t2", number(drawn(draws, 1.0, 4.0)));
        }
        _ => {}
    }
    settings
}

fn encounter(controller: &Arc<ControllerModel>, dynamics: &Arc<DynamicsModel>, draws: &mut Stream) -> World {
    let given = settings(&controller.declaration.name, draws);
    let walker = standard().pedestrians().get("scripted").unwrap().clone();
    // In whole tenths: every step below divides them, so that the people are the same at each.
    let tenths = |low: f64, high: f64, draws: &mut Stream| (drawn(draws, low, high) * 10.0).round() / 10.0;
    let mut script = Settings::from([
        ("speed", number(drawn(draws, 0.8, 2.5))),
        ("delay", number(tenths(0.0, 6.0, draws))),
    ]);
    if draws.index(2) == 0 {
        script.set("stop_after", number(drawn(draws, 0.5, 6.0)));
        script.set("stop_for", number(tenths(0.5, 6.0, draws)));
    }
    let (length, width) = dynamics.size;
    World {
        road: Road::zebra(&[Direction::Forward, Direction::Backward], 30.0 / 3.6),
        other_roads: Vec::new(),
        vehicles: vec![VehicleSetup {
            name: "av".into(),
            controller: ModelSetup::resolved(controller, &given).unwrap(),
            dynamics: ModelSetup::resolved(dynamics, &Settings::default()).unwrap(),
            length,
            width,
            road: 0,
            lane: 0,
            speed: 30.0 / 3.6,
            initial_speed: None,
            start: VehicleStart::TimeToArrival {
                time: drawn(draws, 3.0, 9.0),
                reference: VehicleReference::Centre,
                x: 0.0,
            },
            behind: 0.0,
            sees: None,
            obeys_signals: false,
        }],
        pedestrians: vec![PedestrianSetup {
            kind: Default::default(),
            name: "walker".into(),
            model: ModelSetup::resolved(&walker, &script).unwrap(),
            shape: Shape::Disc { radius: 0.25 },
            side: Side::Near,
            start: Position { x: 0.0, y: -4.0 },
            goal: Position { x: 0.0, y: 8.0 },
            follows: None,
            stops: Vec::new(),
            crossing: 0,
            appears: Appearance::At(0.0),
            may_go: MayGo::AtOnce,
            reference: 0.0,
            obeys_signals: false,
        }],
        streams: Vec::new(),
        step: 0.025,
        horizon: 30.0,
        finish: 40.0,
        end_on_collision: true,
    }
}

/// What a run came to.
struct Course {
    metrics: Vec<Option<f64>>,
    commands: Vec<(f64, Command)>,
    ending: Ending,
    slowest: f64,
}

/// Measures, and keeps how slow the vehicle was.
struct Watch {
    measurement: Measurement,
    slowest: f64,
}

impl Observer for Watch {
    fn begin(&mut self, start: &Snapshot) {
        self.measurement.begin(start);
    }

    fn observe(&mut self, step: &Step) {
        self.slowest = self.slowest.min(step.after.vehicles[0].motion.speed);
        self.measurement.observe(step);
    }
}

fn run(world: &World, step: f64, requests: &Requests) -> Course {
    let world = World { step, ..world.clone() };
    let flows = FreeFlows::default().of(&world).unwrap();
    let mut users = road_users(&world, 1).unwrap();
    let commands = Commands::default();
    users.vehicles = users
        .vehicles
        .into_iter()
        .map(|mut driven| {
            let Driver::Inside(controller) = driven.driver else { panic!("built-in controllers are inside") };
            driven.driver = Driver::Inside(Box::new(Recorded { controller, commands: commands.clone() }));
            driven
        })
        .collect();
    let speeds: Vec<f64> = users.pedestrians.iter().map(|person| person.free_speed()).collect();
    let measurement = Measurement::new(&world, requests.as_slice(), &flows, &speeds);
    let mut watch = Watch { measurement, slowest: f64::INFINITY };
    let ending = simulate(&Arc::new(world), users, &mut watch).unwrap();
    let commands = Arc::into_inner(commands).unwrap().into_inner().unwrap();
    Course { metrics: watch.measurement.values(), commands, ending, slowest: watch.slowest }
}

/// Whether both decided at the same moments, and alike.
fn alike(coarse: &Course, fine: &Course) -> bool {
    let near = |one: &Command, other: &Command| match (one, other) {
        (Command::Acceleration(one), Command::Acceleration(other)) => (one - other).abs() <= 0.5,
        (
            Command::Pedals { throttle: one, brake: first },
            Command::Pedals { throttle: other, brake: second },
        ) => (one - other).abs() <= 0.3 && (first - second).abs() <= 0.15,
        _ => false,
    };
    let both = coarse.commands.iter().zip(&fine.commands);
    for ((one, command), (other, counterpart)) in both {
        assert!((one - other).abs() < 1e-9, "decisions at {one} s and {other} s: the step decides when");
        if !near(command, counterpart) {
            return false;
        }
    }
    coarse.ending.reason == fine.ending.reason
}

/// How far a metric may be from that of half the step (s), for a controller that decides alike at both.
fn tolerance(name: &str, dimension: Dimension, step: f64) -> f64 {
    let per_second = match (name, dimension) {
        // Second differences over a window of 0.2 s: 25 times per 1/s^2 what a speed is off by.
        ("max_jerk" | "rms_jerk", _) => 120.0,
        // Near standstill a place is reached many steps earlier or later.
        (_, Dimension::TIME) => 12.0,
        // As far as the vehicle drives in a step.
        (_, Dimension::LENGTH) => 9.0,
        // As much as hard braking changes in a step.
        (_, Dimension::SPEED) => 12.0,
        (_, Dimension::ACCELERATION) => 10.0,
        // As many widths of a vehicle as somebody walks in the time by which it comes earlier or later.
        ("impact_point", _) => 10.0,
        _ => panic!("no tolerance for {name}"),
    };
    per_second * step
}

/// Not smooth in the course of a run, so that no multiple of the step bounds them: looked at after every step and only
/// where there is a collision course, or divided by a speed that may be next to nothing.
const KNIFE_EDGED: [&str; 4] = ["drac", "min_ttc", "time_headway", "tta_at_entry"];

#[test]
fn half_the_step_changes_no_metric_by_more_than_a_step_can() {
    let registry = standard();
    let requests = Requests::defaults(&registry);
    let (mut all, mut edges) = (0, 0);
    let mut told: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    let mut failures = Vec::new();
    for model in registry.controllers() {
        for dynamics in registry.dynamics().iter().filter(|dynamics| dynamics.takes.contains(&model.gives)) {
            let name = &*model.declaration.name;
            // COMMOTIONS refuses steps that do not divide its own.
            // Short steps take longest, so fewer encounters run with them.
            let steps: &[(f64, usize)] =
                if name == "commotions" { &[(0.025, 12)] } else { &[(0.05, 12), (0.025, 12), (0.01, 4)] };
            for &(step, encounters) in steps {
                let mut draws = Stream::seeded(7);
                for number in 0..encounters {
                    let world = encounter(model, dynamics, &mut draws);
                    let (coarse, fine) = (run(&world, step, &requests), run(&world, step / 2.0, &requests));
                    let count = told.entry(name).or_default();
                    count.0 += 1;
                    all += 1;
                    if !alike(&coarse, &fine) {
                        count.1 += 1;
                        edges += 1;
                        continue;
                    }
                    for (index, metric) in requests.iter().filter_map(|one| one.known()).enumerate() {
                        let metric_name = &*metric.declaration.name;
                        let (one, other) = (coarse.metrics[index], fine.metrics[index]);
                        let within = match metric.kind {
                            _ if KNIFE_EDGED.contains(&metric_name) => true,
                            MetricKind::Quantity(dimension) => match (one, other) {
                                (Some(one), Some(other)) => {
                                    (one - other).abs() <= tolerance(metric_name, dimension, step)
                                }
                                (one, other) => one == other,
                            },
                            // What is true or false tips by itself where its quantity is at its threshold.
                            _ => true,
                        };
                        if !within {
                            failures.push(format!(
                                "{name} on {} at {step} s, encounter {number} (slowest {:.3}): {metric_name} {one:?} and {other:?}",
                                dynamics.declaration.name, coarse.slowest
                            ));
                        }
                    }
                }
            }
        }
    }
    println!("knife edges: {edges} of {all}; {told:?}");
    assert!(failures.is_empty(), "{} of {all}:\n{}", failures.len(), failures.join("\n"));
    assert!(edges * 10 <= all, "{edges} of {all} decisions tip: {told:?}");
    for (name, (encounters, tipped)) in &told {
        // COMMOTIONS weighs noisy percepts against thresholds all the time: where dynamics integrate differently, one of
        // hundreds of decisions in about half of the encounters tips.
        let share = if *name == "commotions" { 0.6 } else { 0.15 };
        assert!(*tipped as f64 <= share * *encounters as f64, "{name}: {tipped} of {encounters}");
    }
    assert!(all > 1000 && told.len() == registry.controllers().iter().count());
}

/// A controller that brakes at once when somebody is in its way, asked how often and when at steps that do not divide its
/// period.
#[test]
fn controllers_decide_at_moments_of_their_own() {
    let requests = Requests::defaults(&standard());
    for (name, moments) in
        [("idm_aeb", [0.0, 0.025, 0.05, 0.075, 0.1]), ("autoware", [0.0, 0.05, 0.075, 0.1, 0.125])]
    {
        let model = standard().controllers().get(name).unwrap().clone();
        let world = encounter(&model, standard().dynamics().get("ideal").unwrap(), &mut Stream::seeded(1));
        for step in [0.1, 0.04, 0.025, 0.01, 0.007] {
            let course = run(&world, step, &requests);
            for (found, expected) in course.commands.iter().zip(moments) {
                assert!((found.0 - expected).abs() < 1e-9, "{name} at {step} s: {} for {expected}", found.0);
            }
        }
    }
}

fn measured(world: &World, seed: u64) -> impl Fn(&str) -> Option<f64> + use<> {
    let case = Case {
        key: "numerics".into(),
        scenario: "numerics".into(),
        variation: Vec::new(),
        individuals: Vec::new(),
        drawn: Vec::new(),
        impossible: None,
        repetition: 1,
        seed,
        world: Arc::new(world.clone()),
    };
    let requests = Requests::defaults(&standard());
    let outcome = run_case(&case, &requests, &FreeFlows::default(), &mut Unwatched).unwrap();
    move |name| {
        let index = requests.iter().position(|request| request.name() == name).expect("a metric");
        outcome.metrics[index]
    }
}

/// Somebody who walks by a script, and a vehicle far away that keeps its speed.
fn undisturbed(speed: f64, start: f64, along: f64, appears: f64, step: f64) -> World {
    let model = standard().controllers().get("constant_speed").unwrap().clone();
    let mut world = encounter(&model, standard().dynamics().get("ideal").unwrap(), &mut Stream::seeded(1));
    let walker = standard().pedestrians().get("scripted").unwrap().clone();
    world.vehicles[0].start = VehicleStart::Distance(400.0);
    world.pedestrians[0].model.settings =
        walker.declaration.resolve(&Settings::from([("speed", number(speed))])).unwrap();
    world.pedestrians[0].start = Position { x: 0.0, y: -start };
    world.pedestrians[0].goal = Position { x: along, y: 8.0 };
    world.pedestrians[0].appears = Appearance::At(appears);
    (world.step, world.horizon) = (step, 90.0);
    world
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Who walks as if nobody were there is late by nothing, and so is a vehicle that nobody held up.
    #[test]
    fn what_is_equal_differs_by_exactly_nothing(
        speed in 0.5..3.0, start in 2.5..6.0, along in -3.0..3.0, appears in 0usize..200, step in 0usize..4,
    ) {
        let step = [0.1, 0.05, 0.025, 0.01][step];
        let world = undisturbed(speed, start, along, appears as f64 * step, step);
        let metric = measured(&world, 1);
        for name in ["pedestrian_delay", "time_lost", "crossing_initiation_time"] {
            prop_assert_eq!(metric(name), Some(0.0), "{}", name);
        }
    }
}

/// At 300 km/h people of the COMMOTIONS model hurry across before the vehicle: what they save is a negative delay, and
/// never more than their highest speed lets them.
#[test]
fn a_negative_delay_is_the_time_that_hurrying_saved() {
    struct Fastest(f64);
    impl Observer for Fastest {
        fn observe(&mut self, step: &Step) {
            self.0 = self.0.max(step.after.pedestrians[0].velocity.norm());
        }
    }
    let requests = Requests::defaults(&standard());
    let delay = requests.iter().position(|request| request.name() == "pedestrian_delay").unwrap();
    let model = standard().pedestrians().get("commotions").unwrap().clone();
    let (mut hurried, mut waited) = (0, 0);
    for (seed, arrival) in (0..12).flat_map(|seed| [(seed, 3.0), (seed, 4.5), (seed, 6.0)]) {
        let mut world = undisturbed(1.0, 4.0, 0.0, 0.0, 0.025);
        world.road.speed_limit = 300.0 / 3.6;
        world.vehicles[0].speed = 300.0 / 3.6;
        world.vehicles[0].start =
            VehicleStart::TimeToArrival { time: arrival, reference: VehicleReference::Centre, x: 0.0 };
        let settings = model.declaration.resolve(&Settings::default()).unwrap();
        let free = settings.number("ped_free_speed");
        world.pedestrians[0].model = ModelSetup { model: (&model).into(), settings };
        world.finish = 2000.0;
        let case = Case {
            key: "fast".into(),
            scenario: "fast".into(),
            variation: Vec::new(),
            individuals: Vec::new(),
            drawn: Vec::new(),
            impossible: None,
            repetition: 1,
            seed,
            world: Arc::new(world),
        };
        let mut fastest = Fastest(0.0);
        let outcome = run_case(&case, &requests, &FreeFlows::default(), &mut fastest).unwrap();
        let Some(late) = outcome.metrics[delay] else { continue };
        let way = 6.0;
        let saved_at_most = way / free - way / fastest.0;
        assert!(late >= -saved_at_most - 1e-9, "{late} s at up to {} m/s", fastest.0);
        assert!(late >= 0.0 || fastest.0 > free, "{late} s at up to {} m/s", fastest.0);
        hurried += usize::from(late < 0.0);
        waited += usize::from(late > 0.0);
        assert_ne!(outcome.ending.reason, StopReason::Horizon);
    }
    assert!(hurried >= 5 && waited >= 5, "{hurried} hurried, {waited} waited");
}
