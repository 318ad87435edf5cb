//! How long a COMMOTIONS pedestrian takes to think: whole encounters of 20 s, 800 steps, and what they allocate.
//!
//! `cargo bench --bench commotions`; instructions with callgrind as `docs/performance.md` says.

use std::hint::black_box;

use divan::{AllocProfiler, Bencher};
use models::pedestrian::commotions::meeting::{Meeting, MetDriver, PEDESTRIAN, VEHICLE, Waiting};
use models::pedestrian::commotions::{
    CommotionsAgent, ConflictState, Control, Parameters, Rules, Sight, State, Variant,
};
use numbers::random::Stream;

#[global_allocator]
static ALLOCATOR: AllocProfiler = AllocProfiler::system();

fn main() {
    divan::main();
}

/// The variant that pedestrians are by default.
const STANDARD: &str = "oVAoBEvoAIoEAoSNvoPF";
/// The same with looming.
const LOOMING: &str = "oVAoVAloBEvoAIoEAoSNvoPF";
/// Everything that costs time.
const EVERYTHING: &str = "oVAaoVAloBEooBEvoAIoEAoSNvoPF";

/// A pedestrian at the zebra, a vehicle at 30 km/h that needs `time_to_arrival` seconds.
fn zebra(time_to_arrival: f64, duration: f64, driver: MetDriver) -> Meeting {
    Meeting {
        pedestrian: (4.0, 0.0),
        vehicle: (time_to_arrival * 30.0 / 3.6, 30.0 / 3.6),
        driver,
        pedestrian_priority: true,
        waiting: Waiting::Inhibited(0.0),
        dt: 0.025,
        end_time: duration,
    }
}

fn encounter(bencher: Bencher, variant: &str, meeting: &Meeting) {
    let variant: Variant = variant.parse().unwrap();
    let individual = Parameters::default();
    let mut seed = 0;
    bencher.bench_local(|| {
        seed += 1;
        let mut last = 0.0;
        meeting.run(&variant, &individual, black_box(seed), |moment| {
            last = moment.pedestrian.distance;
            true
        });
        last
    });
}

/// One pedestrian against a vehicle at constant speed: 800 steps.
#[divan::bench(args = [STANDARD, LOOMING, EVERYTHING])]
fn zebra_20_s(bencher: Bencher, variant: &str) {
    encounter(bencher, variant, &zebra(10.0, 20.0, MetDriver::Timetable(Vec::new())));
}

/// The same with the pedestrian kept from entering, so that every one of the 800 steps is a decision.
#[divan::bench(args = [STANDARD, LOOMING, EVERYTHING])]
fn undecided_20_s(bencher: Bencher, variant: &str) {
    let mut meeting = zebra(22.0, 20.0, MetDriver::Timetable(Vec::new()));
    meeting.waiting = Waiting::Inhibited(20.0);
    encounter(bencher, variant, &meeting);
}

/// A pedestrian and a driver, both COMMOTIONS: 800 steps.
#[divan::bench(args = [STANDARD, LOOMING])]
fn two_agents_20_s(bencher: Bencher, variant: &str) {
    encounter(bencher, variant, &zebra(10.0, 20.0, MetDriver::Commotions));
}

/// Cost grows linearly in steps: the same undecided pedestrian for so many seconds.
#[divan::bench(args = [5, 10, 20, 40])]
fn undecided_for_seconds(bencher: Bencher, seconds: u32) {
    let mut meeting = zebra(42.0, f64::from(seconds), MetDriver::Timetable(Vec::new()));
    meeting.waiting = Waiting::Inhibited(40.0);
    encounter(bencher, STANDARD, &meeting);
}

/// A pedestrian who is kept from entering before so many cars on one lane, 2 s apart: 800 decisions.
#[divan::bench(args = [1, 2, 10, 40])]
fn among_cars_20_s(bencher: Bencher, cars: usize) {
    let variant: Variant = STANDARD.parse().unwrap();
    let rules = Rules { pedestrian_priority: true, entry_inhibited: true };
    let (dt, speed) = (0.025, 30.0 / 3.6);
    let mut seed = 0;
    bencher.bench_local(|| {
        seed += 1;
        let mut draws = Stream::seeded(black_box(seed));
        let bodies = (0..cars).map(|_| (PEDESTRIAN, VEHICLE));
        let mut agent = CommotionsAgent::among(&variant, &Parameters::default(), Control::Speed, dt, bodies);
        let mut own = State { distance: 4.0, ..State::default() };
        let mut sights = Vec::with_capacity(cars);
        for step in 0..800 {
            sights.clear();
            sights.extend((0..cars).map(|other| {
                let time = 22.0 + 2.0 * other as f64 - dt * f64::from(step);
                let state = State { distance: time * speed, speed, acceleration: 0.0 };
                Sight { other, path: 0, own, state, apart: None, conflict: ConflictState::Open }
            }));
            let decision = agent.step_among(&sights, &rules, &mut draws).unwrap();
            own.acceleration = decision.acceleration;
            own = own.step(dt);
        }
        own.distance
    });
}
