//! How often intervals with stated confidence cover the truth, and how often comparisons raise false alarms: a study over
//! 10,000 synthetic experiments a row, too long for the test suite. `cargo bench --bench coverage` prints the tables, and
//! `cargo bench --bench coverage -- 50` their rows for 50 runs.

use numbers::distributions::student_above;
use numbers::inference::{
    ConfidenceSequence, IndependentUnit, Interval, MeanChange, clopper_pearson, holm, mean_interval,
    mean_of_bounded, quantile_interval, rate_change, rate_rise, wilson,
};
use numbers::random::Stream;
use numbers::summary::{mean, std};
use rayon::prelude::*;

const EXPERIMENTS: u64 = 10_000;
const CONFIDENCE: f64 = 0.95;
const RUNS: [usize; 3] = [20, 50, 200];

fn main() {
    println!("coverage of stated {CONFIDENCE} in {EXPERIMENTS} experiments; one standard error is 0.2 %");
    println!("{:<24} {:<14} {:>5} {:>10} {:>8}", "interval", "values", "runs", "covered %", "none %");
    let asked: Vec<usize> = std::env::args().filter_map(|word| word.parse().ok()).collect();
    let runs = if asked.is_empty() { RUNS.to_vec() } else { asked };
    runs.iter().copied().for_each(intervals);
    println!();
    println!("family-wise false alarms of 20 comparisons in {EXPERIMENTS} experiments");
    println!("at 95 % confidence, one side: 2.5 % are stated, one standard error is 0.16 %");
    println!("{:<38} {:<14} {:>5} {:>10}", "what is true", "differences", "runs", "alarms %");
    runs.into_iter().for_each(families);
}

fn intervals(runs: usize) {
    for (name, truth, draw) in DISTRIBUTIONS {
        row("mean", name, runs, *truth, *draw, |values, seed| mean_interval(values, CONFIDENCE, seed));
    }
    for (name, truth, draw) in DISTRIBUTIONS {
        // The other direction mirrors it.
        row("paired difference", name, runs, *truth, *draw, |values, seed| {
            Some(MeanChange::new(values.to_vec(), seed)?.interval(CONFIDENCE))
                .filter(|interval| interval.low.is_finite() || interval.high.is_finite())
        });
    }
    for (name, truth, draw) in DISTRIBUTIONS {
        // Five trials whose means are 0, 2, … 8 above that of the distribution.
        row("the same, five trials", name, runs, *truth, *draw, |values, seed| {
            in_trials(&[values.len() / 5; 5], values, seed)
        });
    }
    for (name, truth, draw) in SPARSE {
        row("the same, one trial", name, runs, *truth, *draw, |values, seed| {
            in_trials(&[values.len()], values, seed)
        });
        row("the same, five trials", name, runs, *truth, *draw, |values, seed| {
            in_trials(&[values.len() / 5; 5], values, seed)
        });
        let half = values_of_unequal(runs);
        row("the same, unequal trials", name, runs, *truth, *draw, move |values, seed| {
            in_trials(&half, values, seed)
        });
    }
    row("paired difference", "of exponentials", runs, 0.0, of_exponentials, |values, seed| {
        Some(MeanChange::new(values.to_vec(), seed)?.interval(CONFIDENCE))
    });
    for (name, truth, draw) in WITH_LIMITS {
        row("mean (betting)", name, runs, *truth, *draw, |values, _| by_betting(values));
        row("the same, ten looks", name, runs, *truth, *draw, |values, _| {
            // What holds at all looks.
            let looks = (1..=10).map(|look| by_betting(&values[..values.len() * look / 10]));
            looks
                .collect::<Option<Vec<_>>>()?
                .into_iter()
                .reduce(|all, one| Interval { low: all.low.max(one.low), high: all.high.min(one.high) })
        });
    }
    row("share of people", "5 runs each", runs, 0.4, Stream::uniform, |values, seed| {
        let mut stream = Stream::seeded(seed + 1);
        let units: Vec<IndependentUnit> = values
            .iter()
            .map(|kind| {
                let share = if *kind < 0.5 { 0.1 } else { 0.7 };
                IndependentUnit::of_runs(
                    (0..5).map(|_| Some(f64::from(stream.uniform() < share))).collect::<Vec<_>>(),
                )
            })
            .collect();
        mean_of_bounded(&units, (0.0, 1.0), EACH)
    });
    row("share, ten looks", "39.3 %", runs, 1.0 - libm::exp(-0.5), exponential, |values, _| {
        let sequence = ConfidenceSequence { confidence: EACH };
        let looks = (1..=10).map(|look| &values[..values.len() * look / 10]);
        looks
            .map(|seen| {
                let held = seen.iter().filter(|value| **value < 0.5).count() as u64;
                sequence.interval(held, seen.len() as u64)
            })
            .reduce(|all, one| Interval { low: all.low.max(one.low), high: all.high.min(one.high) })
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
    for (name, base, candidate) in [("5 % to 12 %", 0.05, 0.12), ("0 % to 2 %", 0.0, 0.02)] {
        row("rate change (paired)", name, runs, candidate - base, Stream::uniform, |values, _| {
            let only_base = values.iter().filter(|value| **value < base).count() as u64;
            let only_candidate = values.iter().filter(|value| **value > 1.0 - candidate).count() as u64;
            Some(rate_change(only_base, only_candidate, values.len() as u64, CONFIDENCE))
        });
    }
}

/// Half of the runs in one trial, a quarter in the next, and so on.
fn values_of_unequal(runs: usize) -> Vec<usize> {
    let mut left = runs;
    let mut sizes = Vec::new();
    for trial in 0..5 {
        let own = if trial == 4 { left } else { left / 2 };
        sizes.push(own);
        left -= own;
    }
    sizes
}

/// Of the mean over trials of so many runs each, of which the second is 2 above the first and so on; without that again.
fn in_trials(sizes: &[usize], values: &[f64], seed: u64) -> Option<Interval> {
    let mut rest = values;
    let mut raised = 0.0;
    let trials = sizes.iter().enumerate().map(|(trial, size)| {
        let own;
        (own, rest) = rest.split_at(*size);
        raised += 2.0 * (trial * own.len()) as f64 / values.len() as f64;
        own.iter().map(|one| 2.0 * trial as f64 + one).collect()
    });
    let trials = trials.collect();
    let found = MeanChange::stratified(trials, seed)?.interval(CONFIDENCE);
    Some(Interval { low: found.low - raised, high: found.high - raised })
}

/// As differences of runs on equal seeds: mostly none.
const SPARSE: &[(&str, f64, Draw)] = &[
    ("one in five", 0.2, |stream| if stream.uniform() < 0.8 { 0.0 } else { exponential(stream) }),
    ("one in twenty", 0.05, |stream| if stream.uniform() < 0.95 { 0.0 } else { exponential(stream) }),
    ("four in five", 0.8, |stream| f64::from(stream.uniform() < 0.8)),
];

type Draw = fn(&mut Stream) -> f64;

/// What each end has to hold for both to hold as stated.
const EACH: f64 = 0.5 + CONFIDENCE / 2.0;

/// Of values between 0 and 60.
fn by_betting(values: &[f64]) -> Option<Interval> {
    let units: Vec<IndependentUnit> =
        values.iter().map(|value| IndependentUnit::of_run(Some(*value))).collect();
    mean_of_bounded(&units, (0.0, 60.0), EACH)
}

/// Values between 0 and 60: name, mean, draws.
const WITH_LIMITS: &[(&str, f64, Draw)] = &[
    ("mostly nothing", 1.0, mostly_nothing),
    ("all or nothing", 1.8, all_or_nothing),
    ("up to 60", 30.0, up_to_sixty),
];

/// Nothing in nine of ten runs, else up to 20.
fn mostly_nothing(stream: &mut Stream) -> f64 {
    if stream.uniform() < 0.9 { 0.0 } else { 20.0 * stream.uniform() }
}

fn all_or_nothing(stream: &mut Stream) -> f64 {
    if stream.uniform() < 0.97 { 0.0 } else { 60.0 }
}

fn up_to_sixty(stream: &mut Stream) -> f64 {
    60.0 * stream.uniform()
}

/// Name, mean, draws.
const DISTRIBUTIONS: &[(&str, f64, Draw)] = &[
    ("normal", 0.0, Stream::normal),
    ("uniform", 0.5, Stream::uniform),
    ("exponential", 1.0, exponential),
    ("half zeros", 0.5, half_zeros),
    ("squared normal", 1.0, squared_normal),
];

fn exponential(stream: &mut Stream) -> f64 {
    -libm::log(stream.uniform())
}

/// Symmetric with heavier tails than a normal one.
fn of_exponentials(stream: &mut Stream) -> f64 {
    exponential(stream) - exponential(stream)
}

/// As time lost: nothing in half of the runs.
fn half_zeros(stream: &mut Stream) -> f64 {
    if stream.uniform() < 0.5 { 0.0 } else { exponential(stream) }
}

/// More skewed than an exponential.
fn squared_normal(stream: &mut Stream) -> f64 {
    let normal = stream.normal();
    normal * normal
}

/// Whether rows of this name are asked for: all unless some are named.
fn wanted(interval: &str) -> bool {
    let mut words =
        std::env::args().skip(1).filter(|word| !word.starts_with('-') && word.parse::<usize>().is_err());
    let asked: Vec<String> = words.by_ref().collect();
    asked.is_empty() || asked.iter().any(|word| interval.contains(&**word))
}

fn row(
    interval: &str,
    values: &str,
    runs: usize,
    truth: f64,
    draw: Draw,
    find: impl Fn(&[f64], u64) -> Option<Interval> + Sync,
) {
    if !wanted(interval) {
        return;
    }
    let found = |seed: u64| {
        let mut stream = Stream::seeded(20_261_121 + seed);
        let sample: Vec<f64> = (0..runs).map(|_| draw(&mut stream)).collect();
        find(&sample, seed)
    };
    let found: Vec<Option<Interval>> = (0..EXPERIMENTS).into_par_iter().map(found).collect();
    let none = found.iter().filter(|found| found.is_none()).count();
    let covered = found.iter().flatten().filter(|found| found.contains(truth)).count();
    let percent = |count: usize, of: usize| 100.0 * count as f64 / of.max(1) as f64;
    println!(
        "{interval:<24} {values:<14} {runs:>5} {:>10.2} {:>8.2}",
        percent(covered, found.len() - none),
        percent(none, found.len())
    );
}

/// How many comparisons share the error.
const FAMILY: usize = 20;
/// What may go wrong at the side that a gate looks at.
const ALPHA: f64 = (1.0 - CONFIDENCE) / 2.0;

fn families(runs: usize) {
    let mean_change = |margin: f64, draw: Draw, sign: f64| {
        move |stream: &mut Stream| {
            let truth = DISTRIBUTIONS
                .iter()
                .find(|(_, _, known)| std::ptr::fn_addr_eq(*known, draw))
                .map_or(0.0, |row| row.1);
            // Worse by exactly the margin.
            let differences: Vec<f64> = (0..runs).map(|_| margin + sign * (draw(stream) - truth)).collect();
            let seed = stream.bits();
            // No p-value is below Student's, and one above the level raises no alarm: most need no resampling.
            if student(&differences, margin) > ALPHA {
                return 1.0;
            }
            let change = MeanChange::new(differences, seed).expect("there are pairs");
            let level = ALPHA / FAMILY as f64;
            let beyond = change.above(margin, level);
            if beyond < 1.0 { beyond.max(change.exchange(level)) } else { 1.0 }
        }
    };
    family("no change", "of exponentials", runs, mean_change(0.0, of_exponentials, 1.0));
    family("worse by exactly what is tolerated", "normal", runs, mean_change(0.2, Stream::normal, 1.0));
    family("worse by exactly what is tolerated", "exponential", runs, mean_change(0.2, exponential, 1.0));
    family("worse by exactly what is tolerated", "-exponential", runs, mean_change(0.2, exponential, -1.0));
    for (base, margin) in [(0.1, 0.0), (0.05, 0.05)] {
        let rates = move |stream: &mut Stream| {
            let draws: Vec<f64> = (0..runs).map(|_| stream.uniform()).collect();
            let only_base = draws.iter().filter(|draw| **draw < base).count() as u64;
            let only_candidate = draws.iter().filter(|draw| **draw > 1.0 - base - margin).count() as u64;
            rate_rise(only_base, only_candidate, runs as u64, margin)
        };
        let what = if margin == 0.0 { "no change" } else { "worse by exactly what is tolerated" };
        family(what, "flags", runs, rates);
    }
}

/// Student's p-value of "the mean is at most `bound`".
fn student(values: &[f64], bound: f64) -> f64 {
    let (mean, std) = (mean(values).expect("there are values"), std(values).expect("there are several"));
    student_above((mean - bound) * (values.len() as f64).sqrt() / std, (values.len() - 1) as f64)
}

fn family(truth: &str, differences: &str, runs: usize, p_value: impl Fn(&mut Stream) -> f64 + Sync) {
    if !wanted(truth) {
        return;
    }
    let alarm = |seed: u64| {
        let mut stream = Stream::seeded(77_000_000 + seed);
        let p_values: Vec<f64> = (0..FAMILY).map(|_| p_value(&mut stream)).collect();
        holm(&p_values).into_iter().any(|adjusted| adjusted <= ALPHA)
    };
    let alarms = (0..EXPERIMENTS).into_par_iter().filter(|seed| alarm(*seed)).count();
    println!("{truth:<38} {differences:<14} {runs:>5} {:>10.2}", 100.0 * alarms as f64 / EXPERIMENTS as f64);
}
