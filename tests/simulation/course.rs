//! Runs in which somebody outside decides: the same bits as if the controller were inside, whatever else goes on meanwhile.

use std::path::Path;
use std::sync::{Arc, LazyLock};

use files::Disk;
use models::standard;
use proptest::prelude::*;
use results::Requests;
use runner::plan::plan;
use runner::run::{FreeFlows, road_users};
use scenario::{Case, ModelSetup, Settings, Value, World};
use sim::measure::{Measurement, Reading};
use sim::{
    Controller, Course, Driver, Ending, Fingerprint, Observer, Progress, Snapshot, Step, Timeline,
    TimelineEvent, Trace,
};

/// The first case of every trial of a few suites, by whose controllers there are.
static CASES: LazyLock<Vec<Case>> = LazyLock::new(|| {
    let suites = ["suites/zebra.suite", "suites/matrix.suite", "suites/zebra_unsafe.suite"];
    let first = |path: &&str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
        let suite =
            lang::load(&path, &standard(), &Disk).unwrap_or_else(|_| panic!("{path:?} is a suite")).suite;
        plan(&suite).unwrap().trials().map(|trial| trial.cases.get(0)).collect::<Vec<_>>()
    };
    suites.iter().flat_map(first).collect()
});

/// Everything that can be told of a run.
struct Told {
    measurement: Measurement,
    fingerprint: Fingerprint,
    trace: Trace,
    timeline: Timeline,
    ended: Option<(Ending, Snapshot)>,
}

impl Told {
    fn new(world: &Arc<World>, requests: &Requests, speeds: &[f64]) -> Self {
        let flows = FreeFlows::default().of(world).unwrap();
        Self {
            measurement: Measurement::new(world, requests.as_slice(), &flows, speeds),
            fingerprint: Fingerprint::default(),
            trace: Trace::default(),
            timeline: Timeline::new(world),
            ended: None,
        }
    }

    #[allow(clippy::type_complexity, reason = "everything there is")]
    fn all(self) -> (Vec<Reading>, u64, Trace, Vec<TimelineEvent>, Option<(Ending, Snapshot)>) {
        let readings = self.measurement.readings();
        (readings, self.fingerprint.value(), self.trace, self.timeline.into_events(), self.ended)
    }
}

impl Observer for Told {
    fn begin(&mut self, start: &Snapshot) {
        self.measurement.begin(start);
        self.fingerprint.begin(start);
        self.trace.begin(start);
        self.timeline.begin(start);
    }

    fn observe(&mut self, step: &Step) {
        self.measurement.observe(step);
        self.fingerprint.observe(step);
        self.trace.observe(step);
        self.timeline.observe(step);
    }

    fn end(&mut self, ending: &Ending, last: &Snapshot) {
        self.measurement.end(ending, last);
        self.fingerprint.end(ending, last);
        self.trace.end(ending, last);
        self.timeline.end(ending, last);
        self.ended = Some((*ending, last.clone()));
    }
}

/// A run whose vehicles are driven from outside by the controllers that its case names.
struct Outside {
    course: Course,
    drivers: Vec<Option<Box<dyn Controller>>>,
    told: Told,
    decisions: usize,
}

impl Outside {
    /// `which` vehicles are driven from outside, bit by bit; `None` where the models do not take the case.
    fn new(world: &Arc<World>, seed: u64, requests: &Requests, which: u32) -> Option<Self> {
        let mut users = road_users(world, seed).ok()?;
        let speeds: Vec<f64> = users.pedestrians.iter().map(|one| one.free_speed()).collect();
        let take = |(index, driven): (usize, &mut sim::Driven)| {
            (which >> index & 1 == 1).then(|| {
                let (schedule, settling_time) = (driven.driver.schedule(), driven.driver.settling_time());
                let outside = Driver::Outside { schedule, settling_time };
                match std::mem::replace(&mut driven.driver, outside) {
                    Driver::Inside(controller) => controller,
                    Driver::Outside { .. } => unreachable!("built-in controllers are inside"),
                }
            })
        };
        let drivers = users.vehicles.iter_mut().enumerate().map(take).collect();
        let told = Told::new(world, requests, &speeds);
        Some(Self { course: Course::start(world.clone(), users), drivers, told, decisions: 0 })
    }

    /// Goes on to the next decisions, and takes them; whether it has ended.
    fn go_on(&mut self) -> bool {
        match self.course.next(&mut self.told).unwrap() {
            Progress::Ended(_) => true,
            Progress::Waits => {
                let asked: Vec<_> = self.course.asked().map(|(who, seen)| (who, seen.clone())).collect();
                // In another order than they were asked.
                for (who, seen) in asked.into_iter().rev() {
                    let driver = self.drivers[who].as_mut().unwrap();
                    let command = driver.act(&seen).unwrap();
                    let mode = driver.mode().to_string();
                    self.course.decide(who, command, mode.into()).unwrap();
                    self.decisions += 1;
                }
                false
            }
        }
    }
}

/// A case with other steps, and with eyes that are not perfect.
fn changed(case: &Case, step: f64, blurred: bool) -> Arc<World> {
    let mut world = World { step, ..(*case.world).clone() };
    if blurred {
        let given = Settings::from([
            ("latency", Value::Number(0.12)),
            ("dropout", Value::Number(0.1)),
            ("position_noise", Value::Number(0.3)),
        ]);
        let sees = ModelSetup::resolved(standard().perception(), &given).unwrap();
        world.vehicles.iter_mut().for_each(|car| car.sees = Some(sees.clone()));
    }
    Arc::new(world)
}

const STEPS: [f64; 4] = [0.025, 0.01, 0.04, 0.07];

fn compare(case: &Case, step: f64, blurred: bool, seed: u64) -> Option<usize> {
    let requests = Requests::defaults(&standard());
    let world = changed(case, step, blurred);
    let mut inside = Outside::new(&world, seed, &requests, 0)?;
    assert!(inside.go_on(), "nobody outside is waited for");
    let mut outside = Outside::new(&world, seed, &requests, u32::MAX).unwrap();
    while !outside.go_on() {}
    let decisions = outside.decisions;
    let (inside, outside) = (inside.told.all(), outside.told.all());
    assert!(inside.4.is_some());
    assert_eq!(format!("{inside:?}"), format!("{outside:?}"), "{} at {step} s", case.key);
    Some(decisions)
}

#[test]
fn every_controller_of_the_suites_drives_from_outside_as_inside() {
    let mut controllers: Vec<_> = Vec::new();
    for (index, case) in CASES.iter().enumerate() {
        let name = case.world.vehicles[0].controller.model.to_string();
        let known = controllers.iter().filter(|known| **known == name).count();
        if known < 3 {
            let compared = compare(case, STEPS[index % STEPS.len()], index % 2 == 1, case.seed);
            controllers.extend(compared.map(|_| name));
        }
    }
    controllers.sort();
    controllers.dedup();
    // The first and the last settle, and their periods are no multiples of some of the steps.
    assert!(
        ["autoware", "careful_human", "carla_behavior"]
            .iter()
            .all(|name| controllers.iter().any(|one| one == name)),
        "{controllers:?}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn whoever_decides_it_is_the_same_run(
        index: prop::sample::Index, step in prop::sample::select(&STEPS[..]), blurred: bool, seed: u64,
    ) {
        compare(&CASES[index.index(CASES.len())], step, blurred, seed);
    }

    #[test]
    fn many_runs_side_by_side_are_each_as_if_alone(
        chosen in prop::collection::vec((any::<prop::sample::Index>(), 0..8_u64), 2..6),
        turns in prop::collection::vec(any::<prop::sample::Index>(), 64),
    ) {
        let requests = Requests::defaults(&standard());
        let worlds: Vec<_> = chosen
            .iter()
            .map(|(index, seed)| (CASES[index.index(CASES.len())].world.clone(), *seed))
            .collect();
        let start = |which: u32| -> Vec<_> {
            worlds.iter().map(|(world, seed)| Outside::new(world, *seed, &requests, which).unwrap()).collect()
        };
        let alone = start(0).into_iter().map(|mut run| {
            run.go_on();
            format!("{:?}", run.told.all())
        });
        let alone: Vec<_> = alone.collect();
        let mut runs: Vec<_> = start(u32::MAX).into_iter().enumerate().collect();
        let mut ended: Vec<Option<String>> = vec![None; runs.len()];
        for turn in turns.iter().cycle() {
            if runs.is_empty() {
                break;
            }
            let turn = turn.index(runs.len());
            if runs[turn].1.go_on() {
                let (index, run) = runs.swap_remove(turn);
                ended[index] = Some(format!("{:?}", run.told.all()));
            }
        }
        let ended: Vec<_> = ended.into_iter().flatten().collect();
        prop_assert_eq!(ended, alone);
    }
}
