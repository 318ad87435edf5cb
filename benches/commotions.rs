//! How long a COMMOTIONS pedestrian takes to think: whole encounters of 20 s, 800 steps.
//!
//! `cargo bench --bench commotions`; instructions with callgrind as `docs/performance.md` says.

use std::hint::black_box;

use divan::Bencher;
use scenario_runner::pedestrian::commotions::meeting::{Driver, Meeting};
use scenario_runner::pedestrian::commotions::{Parameters, Variant};

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
fn zebra(time_to_arrival: f64, duration: f64, driver: Driver) -> Meeting {
    Meeting {
        pedestrian: (4.0, 0.0),
        vehicle: (time_to_arrival * 30.0 / 3.6, 30.0 / 3.6),
        driver,
        pedestrian_priority: true,
        entry_inhibited_until: 0.0,
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
    encounter(bencher, variant, &zebra(10.0, 20.0, Driver::Timetable(Vec::new())));
}

/// The same with the pedestrian kept from entering, so that every one of the 800 steps is a decision.
#[divan::bench(args = [STANDARD, LOOMING, EVERYTHING])]
fn undecided_20_s(bencher: Bencher, variant: &str) {
    let mut meeting = zebra(22.0, 20.0, Driver::Timetable(Vec::new()));
    meeting.entry_inhibited_until = 20.0;
    encounter(bencher, variant, &meeting);
}

/// A pedestrian and a driver, both COMMOTIONS: 800 steps.
#[divan::bench(args = [STANDARD, LOOMING])]
fn two_agents_20_s(bencher: Bencher, variant: &str) {
    encounter(bencher, variant, &zebra(10.0, 20.0, Driver::Commotions));
}

/// Cost grows linearly in steps: the same undecided pedestrian for so many seconds.
#[divan::bench(args = [5, 10, 20, 40])]
fn undecided_for_seconds(bencher: Bencher, seconds: u32) {
    let mut meeting = zebra(42.0, f64::from(seconds), Driver::Timetable(Vec::new()));
    meeting.entry_inhibited_until = 40.0;
    encounter(bencher, STANDARD, &meeting);
}
