//! How often intervals with stated confidence cover the truth: a study over 10,000 synthetic experiments a row, too long
//! for the test suite. `cargo bench --bench coverage` prints the table.

use scenario_runner::judge::statistics::{
    Interval, clopper_pearson, mean_interval, paired_difference, quantile_interval, rate_change,
    std_interval, wilson,
};
use scenario_runner::sim::random::Stream;

const EXPERIMENTS: u64 = 10_000;
const CONFIDENCE: f64 = 0.95;

fn main() {
    println!("coverage of stated {CONFIDENCE} in {EXPERIMENTS} experiments; one standard error is 0.2 %");
    println!("{:<22} {:<14} {:>5} {:>10} {:>8}", "interval", "values", "runs", "covered %", "none %");
    for runs in [20, 50, 200] {
        for (name, truth, draw) in DISTRIBUTIONS {
            row("mean (bootstrap-t)", name, runs, *truth, *draw, |values, seed| {
                mean_interval(values, CONFIDENCE, seed)
            });
        }
        for (name, truth, draw) in SPREADS {
            row("std (bootstrap-t)", name, runs, *truth, *draw, |values, seed| {
                std_interval(values, CONFIDENCE, seed)
            });
        }
        row("paired difference", "exponential", runs, 0.0, exponential, |values, seed| {
            let base: Vec<f64> = values.iter().map(|value| value + 3.0).collect();
            let mut stream = Stream::seeded(seed.wrapping_mul(77).wrapping_add(1));
            let candidate: Vec<f64> =
                base.iter().map(|value| value + exponential(&mut stream) - 1.0).collect();
            paired_difference(&base, &candidate, CONFIDENCE, seed)
        });
        let median = std::f64::consts::LN_2;
        row("median (order stat.)", "exponential", runs, median, exponential, |values, _| {
            let mut sorted = values.to_vec();
            sorted.sort_by(f64::total_cmp);
            let (low, high) = quantile_interval(&sorted, 0.5, CONFIDENCE);
            Some(Interval { low: low?, high: high? })
        });
        let share = |values: &[f64]| values.iter().filter(|value| **value < 0.5).count() as u64;
        // P(X < 1/2) of an exponential.
        let truth = 1.0 - libm::exp(-0.5);
        row("share (Clopper-Pearson)", "39.3 %", runs, truth, exponential, |values, _| {
            Some(clopper_pearson(share(values), values.len() as u64, CONFIDENCE))
        });
        row("share (Wilson)", "39.3 %", runs, truth, exponential, |values, _| {
            Some(wilson(share(values), values.len() as u64, CONFIDENCE))
        });
        row("rate change (paired)", "5 % to 12 %", runs, 0.07, Stream::uniform, |values, _| {
            let only_base = values.iter().filter(|value| **value < 0.05).count() as u64;
            let only_candidate = values.iter().filter(|value| **value > 0.88).count() as u64;
            Some(rate_change(only_base, only_candidate, values.len() as u64, CONFIDENCE))
        });
    }
}

type Draw = fn(&mut Stream) -> f64;

/// Name, mean, draws.
const DISTRIBUTIONS: &[(&str, f64, Draw)] = &[
    ("normal", 0.0, Stream::normal),
    ("uniform", 0.5, Stream::uniform),
    ("exponential", 1.0, exponential),
    ("half zeros", 0.5, half_zeros),
];

/// Name, standard deviation, draws.
const SPREADS: &[(&str, f64, Draw)] = &[
    ("normal", 1.0, Stream::normal),
    ("uniform", 0.288_675_134_594_812_9, Stream::uniform),
    ("exponential", 1.0, exponential),
];

fn exponential(stream: &mut Stream) -> f64 {
    -libm::log(stream.uniform())
}

/// As time lost: nothing in half of the runs.
fn half_zeros(stream: &mut Stream) -> f64 {
    if stream.uniform() < 0.5 { 0.0 } else { exponential(stream) }
}

fn row(
    interval: &str,
    values: &str,
    runs: usize,
    truth: f64,
    draw: Draw,
    find: impl Fn(&[f64], u64) -> Option<Interval>,
) {
    let mut stream = Stream::seeded(20_261_121);
    let (mut covered, mut none) = (0, 0);
    for seed in 0..EXPERIMENTS {
        let sample: Vec<f64> = (0..runs).map(|_| draw(&mut stream)).collect();
        match find(&sample, seed) {
            Some(interval) => covered += u64::from(interval.contains(truth)),
            None => none += 1,
        }
    }
    let percent = |count: u64, of: u64| 100.0 * count as f64 / of.max(1) as f64;
    println!(
        "{interval:<22} {values:<14} {runs:>5} {:>10.2} {:>8.2}",
        percent(covered, EXPERIMENTS - none),
        percent(none, EXPERIMENTS)
    );
}
