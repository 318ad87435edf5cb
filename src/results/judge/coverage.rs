//! How often each kind of bound holds where the truth is known: as often as stated, but for the errors of the simulation.
//! `cargo bench --bench coverage` does more of it.

use std::cell::RefCell;
use std::collections::BTreeMap;

use super::confidence::Bounds;
use numbers::inference::{Interval, MeanChange, mean_interval, rate_change};
use numbers::random::Stream;
use scenario::{Aggregate, MetricReference};

const CONFIDENCE: f64 = 0.95;
const EXPERIMENTS: u64 = 400;
/// Three standard errors of the share of wrong bounds among the experiments, where one in twenty is wrong.
const SLACK: f64 = 0.033;

/// The shares of experiments in which the lower and the upper bound are wrong; what is found at one of several looks counts
/// once. No interval is wrong nowhere.
fn wrong(truth: f64, find: impl Fn(&mut Stream) -> Vec<Option<Interval>>) -> (f64, f64) {
    let (mut low, mut high) = (0, 0);
    for seed in 0..EXPERIMENTS {
        let looks = find(&mut Stream::seeded(20_261_122 + seed));
        let found: Vec<Interval> = looks.into_iter().flatten().collect();
        low += u64::from(found.iter().any(|interval| interval.low > truth));
        high += u64::from(found.iter().any(|interval| interval.high < truth));
    }
    (low as f64 / EXPERIMENTS as f64, high as f64 / EXPERIMENTS as f64)
}

/// Each bound by itself at 95 %.
fn holds(what: &str, truth: f64, find: impl Fn(&mut Stream) -> Vec<Option<Interval>>) {
    let (low, high) = wrong(truth, find);
    assert!(low <= 0.05 + SLACK && high <= 0.05 + SLACK, "{what}: wrong below in {low}, above in {high}");
}

fn of(aggregate: fn(MetricReference) -> Aggregate) -> Aggregate {
    aggregate(models::known::measured("stopped_time"))
}

fn draws(count: usize, mut draw: impl FnMut() -> f64) -> Vec<Option<f64>> {
    (0..count).map(|_| Some(draw())).collect()
}

const LOOKS: [usize; 6] = [20, 40, 60, 90, 120, 160];

/// Nothing in nine of ten runs, else up to 20 s: 1 s on average.
fn mostly_nothing(stream: &mut Stream) -> f64 {
    if stream.uniform() < 0.9 { 0.0 } else { 20.0 * stream.uniform() }
}

/// As far apart as limits of 60 s allow: 1.8 s on average.
fn all_or_nothing(stream: &mut Stream) -> f64 {
    if stream.uniform() < 0.97 { 0.0 } else { 60.0 }
}

fn exponential(stream: &mut Stream) -> f64 {
    -libm::log(stream.uniform())
}

#[test]
fn bounds_on_shares() {
    for (share, runs) in [(0.393, 40), (0.97, 100)] {
        let happens = |stream: &mut Stream| stream.uniform() < share;
        holds("a share", share, |stream| {
            let held: Vec<bool> = (0..runs).map(|_| happens(stream)).collect();
            vec![Some(Bounds::Fixed.of_share(&held, CONFIDENCE))]
        });
        holds("a share, looked at again", share, |stream| {
            let held: Vec<bool> = (0..160).map(|_| happens(stream)).collect();
            LOOKS.iter().map(|runs| Some(Bounds::Sequential.of_share(&held[..*runs], CONFIDENCE))).collect()
        });
    }
}

#[test]
fn bounds_on_quantiles() {
    for (level, truth) in [(0.5, std::f64::consts::LN_2), (0.9, std::f64::consts::LN_10)] {
        let quantile = |metric| Aggregate::Quantile(level, metric);
        let name = models::known::measured("pet");
        let aggregate = quantile(name);
        holds("a quantile", truth, |stream| {
            let values = draws(60, || exponential(stream));
            vec![Bounds::Fixed.of_values(&aggregate, &values, None, CONFIDENCE, 1)]
        });
        holds("a quantile, looked at again", truth, |stream| {
            let values = draws(160, || exponential(stream));
            let at = |runs: &usize| {
                Bounds::Sequential.of_values(&aggregate, &values[..*runs], None, CONFIDENCE, 1)
            };
            LOOKS.iter().map(at).collect()
        });
    }
}

#[test]
fn bounds_on_means_with_limits() {
    let limits = Some((0.0, 60.0));
    let mean = of(Aggregate::Mean);
    let of_group = |stream: &mut Stream, run: usize| {
        // Five people who take turns, each with a level of its own: 12 s on average.
        6.0 * (run % 5) as f64 * 2.0 * stream.uniform()
    };
    for (what, truth, draw) in [
        ("mostly nothing", 1.0, mostly_nothing as fn(&mut Stream) -> f64),
        ("all or nothing", 1.8, all_or_nothing),
        ("uniform", 30.0, |stream| 60.0 * stream.uniform()),
    ] {
        for runs in [20, 100] {
            holds(what, truth, |stream| {
                let values = draws(runs, || draw(stream));
                vec![Bounds::Fixed.of_values(&mean, &values, limits, CONFIDENCE, 1)]
            });
        }
        holds(what, truth, |stream| {
            let values = draws(160, || draw(stream));
            let at =
                |runs: &usize| Bounds::Sequential.of_values(&mean, &values[..*runs], limits, CONFIDENCE, 1);
            LOOKS.iter().map(at).collect()
        });
    }
    holds("of people who take turns", 12.0, |stream| {
        let mut run = 0;
        let values = draws(100, || {
            run += 1;
            of_group(stream, run)
        });
        vec![Bounds::Fixed.of_values(&mean, &values, limits, CONFIDENCE, 1)]
    });
    holds("where some have no value", 30.0, |stream| {
        let values: Vec<_> =
            (0..60).map(|_| (stream.uniform() < 0.6).then(|| 60.0 * stream.uniform())).collect();
        vec![Bounds::Fixed.of_values(&mean, &values, limits, CONFIDENCE, 1)]
    });
}

/// Two kinds of people: one in which it happens in every tenth run, one in seven of ten. Four in ten on average.
fn of_a_kind(stream: &mut Stream) -> f64 {
    if stream.uniform() < 0.5 { 0.1 } else { 0.7 }
}

#[test]
fn bounds_on_all_people() {
    const PEOPLE: usize = 24;
    for each in [1, 10] {
        let whose: Vec<usize> = (0..PEOPLE * each).map(|run| run / each).collect();
        let by_people = Bounds::People(&whose);
        // Everybody's runs around a level of its own.
        let runs = |stream: &mut Stream| -> Vec<Option<f64>> {
            (0..PEOPLE)
                .flat_map(|_| {
                    let level = stream.uniform();
                    (0..each).map(|_| Some(level + stream.uniform())).collect::<Vec<_>>()
                })
                .collect()
        };
        holds("a share of people", 0.4, |stream| {
            let held: Vec<bool> = (0..PEOPLE)
                .flat_map(|_| {
                    let share = of_a_kind(stream);
                    (0..each).map(|_| stream.uniform() < share).collect::<Vec<_>>()
                })
                .collect();
            vec![Some(by_people.of_share(&held, CONFIDENCE))]
        });
        holds("a mean of people", 1.0, |stream| {
            let values = runs(stream);
            vec![by_people.of_values(&of(Aggregate::Mean), &values, Some((0.0, 2.0)), CONFIDENCE, 1)]
        });
        holds("a median of people", 1.0, |stream| {
            let values = runs(stream);
            vec![by_people.of_values(&of(Aggregate::Median), &values, None, CONFIDENCE, 1)]
        });
    }
    // Runs taken for independent are wrong far more often: that is what people are counted for.
    let (low, high) = wrong(0.4, |stream| {
        let held: Vec<bool> = (0..5)
            .flat_map(|_| {
                let share = of_a_kind(stream);
                (0..100).map(|_| stream.uniform() < share).collect::<Vec<_>>()
            })
            .collect();
        vec![Some(Bounds::Fixed.of_share(&held, CONFIDENCE))]
    });
    assert!(low > 0.15 && high > 0.15, "{low} {high}");
}

#[test]
fn intervals_of_changes() {
    for (base, candidate) in [(0.05, 0.12), (0.0, 0.02), (0.0, 0.31)] {
        let truth = candidate - base;
        // The same counts come again and again.
        let known: RefCell<BTreeMap<(u64, u64), Interval>> = RefCell::default();
        let (low, high) = wrong(truth, |stream| {
            let draws: Vec<f64> = (0..100).map(|_| stream.uniform()).collect();
            let only_base = draws.iter().filter(|draw| **draw < base).count() as u64;
            let only_candidate = draws.iter().filter(|draw| **draw > 1.0 - candidate).count() as u64;
            let find = || rate_change(only_base, only_candidate, 100, CONFIDENCE);
            vec![Some(*known.borrow_mut().entry((only_base, only_candidate)).or_insert_with(find))]
        });
        assert!(low + high <= 0.05 + SLACK, "{base} to {candidate}: {low} {high}");
    }
}

#[test]
fn approximate_intervals_hold_about_as_often() {
    // Two-sided at 95 %. Without limits nothing better is known, and the tail that was not seen costs some of it.
    for (what, truth, most, draw) in [
        ("normal", 0.0, 0.05 + SLACK, Stream::normal as fn(&mut Stream) -> f64),
        ("exponential", 1.0, 0.10, exponential),
    ] {
        let (low, high) = wrong(truth, |stream| {
            let values: Vec<f64> = (0..50).map(|_| draw(stream)).collect();
            vec![mean_interval(&values, CONFIDENCE, stream.bits())]
        });
        assert!(low + high <= most, "{what}: {low} {high}");
        let (low, high) = wrong(truth, |stream| {
            let values: Vec<f64> = (0..50).map(|_| draw(stream)).collect();
            vec![Some(MeanChange::new(values, stream.bits()).unwrap().interval(CONFIDENCE))]
        });
        assert!(low + high <= most, "change of {what}: {low} {high}");
    }
}
