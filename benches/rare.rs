//! How often bounds and intervals of rare probabilities cover, on problems whose probability is known in closed form.
//!
//! `cargo bench --bench rare` takes some minutes and prints a table.

#![allow(clippy::print_stdout, reason = "prints its table")]

use numbers::distributions::normal;
use numbers::random::derive_seed;
use numbers::rare::{
    ImportanceSampling, RareAxis, RareEstimate, RareOutcome, RarePoint, RareSampling, RareScale, RareSpace,
    SplittingSampling,
};
use rayon::prelude::*;

const REPETITIONS: u64 = 200;

struct Problem {
    name: &'static str,
    dimensions: usize,
    probability: f64,
    /// How far from the event, which happens at 0 and below.
    score: fn(&[f64]) -> f64,
    /// What the pilot is not shown.
    hidden: fn(&[f64]) -> bool,
}

fn tail(beta: f64) -> f64 {
    normal::cumulative(-beta)
}

fn either(one: f64, other: f64) -> f64 {
    one + other - one * other
}

fn corner(z: &[f64]) -> bool {
    z[1] > 2.3 && z[2] > 2.3
}

fn problems() -> Vec<Problem> {
    let nothing = |_: &[f64]| false;
    vec![
        Problem {
            name: "linear, 2 axes",
            dimensions: 2,
            probability: tail(3.0902),
            score: |z| 3.0902 - z[0],
            hidden: nothing,
        },
        Problem {
            name: "linear, 4 axes",
            dimensions: 4,
            probability: tail(4.7534),
            score: |z| 4.7534 - 0.5 * z.iter().sum::<f64>(),
            hidden: nothing,
        },
        Problem {
            name: "linear, 10 axes",
            dimensions: 10,
            probability: tail(4.2649),
            score: |z| 4.2649 - z.iter().sum::<f64>() / 10.0_f64.sqrt(),
            hidden: nothing,
        },
        Problem {
            name: "two regions, opposite",
            dimensions: 2,
            probability: tail(4.0) + tail(4.3),
            score: |z| (4.0 - z[0]).min(4.3 + z[0]),
            hidden: nothing,
        },
        Problem {
            name: "two regions, beside",
            dimensions: 3,
            probability: either(tail(3.5), tail(3.7)),
            score: |z| (3.5 - 0.5_f64.sqrt() * (z[0] + z[1])).min(3.7 + z[2]),
            hidden: nothing,
        },
        Problem {
            name: "and a corner that the pilot is not shown",
            dimensions: 3,
            probability: either(tail(3.5), tail(2.3) * tail(2.3)),
            score: |z| if corner(z) { 0.0 } else { 3.5 - z[0] },
            hidden: corner,
        },
    ]
}

type Method = fn(RareSpace, usize, u64) -> Box<dyn RareSampling>;

const METHODS: [(&str, Method, [usize; 2]); 2] = [
    (
        "importance",
        |space, budget, seed| Box::new(ImportanceSampling::new(space, budget, seed)),
        [4000, 20_000],
    ),
    (
        "splitting",
        |space, budget, seed| Box::new(SplittingSampling::new(space, budget, seed)),
        [50_000, 200_000],
    ),
];

fn estimated(method: Method, problem: &Problem, budget: usize, repetition: u64) -> RareEstimate {
    let space = RareSpace::new(vec![RareAxis::Continuous; problem.dimensions]);
    let mut method = method(space.clone(), budget, derive_seed(repetition, problem.name));
    while let Some(round) = method.ask() {
        let outcome = |one: &RarePoint| {
            let z: Vec<f64> = one.point.iter().map(|share| normal::quantile(*share)).collect();
            if round.is_pilot && (problem.hidden)(&z) {
                return RareOutcome { event: false, score: 9.0 };
            }
            let score = (problem.score)(&z);
            RareOutcome { event: score <= 0.0, score }
        };
        let outcomes: Vec<_> = round.points.iter().map(outcome).collect();
        method.tell(&outcomes);
    }
    RareEstimate::of(&space, method.replicates(), RareScale::Logarithmic)
}

fn main() {
    println!("{REPETITIONS} repetitions at 95 %; bias in its standard errors\n");
    println!(
        "| problem | p | by | runs | refused | interval covers | right or refused | bound covers | bias | deviation |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for problem in problems() {
        for (by, method, budget) in
            METHODS.iter().flat_map(|(by, method, budgets)| budgets.map(|budget| (by, *method, budget)))
        {
            let all: Vec<RareEstimate> = (0..REPETITIONS)
                .into_par_iter()
                .map(|repetition| estimated(method, &problem, budget, repetition))
                .collect();
            let known = problem.probability;
            let kept: Vec<_> = all.iter().filter(|one| one.refusals.is_empty()).collect();
            let covered = kept.iter().filter(|one| one.interval(0.95).contains(known)).count();
            let bound = all.iter().filter(|one| known <= one.guaranteed(0.95)).count();
            let refused = all.len() - kept.len();
            let mean = all.iter().map(|one| one.value).sum::<f64>() / all.len() as f64;
            let squares: f64 = all.iter().map(|one| (one.value - mean) * (one.value - mean)).sum();
            let deviation = (squares / (all.len() - 1) as f64).sqrt();
            println!(
                "| {} | {known:.2e} | {by} | {budget} | {refused} | {covered} of {} | {} of {} | {bound} of {} | {:+.1} | {:.1} % |",
                problem.name,
                kept.len(),
                covered + refused,
                all.len(),
                all.len(),
                (mean - known) / (deviation / (all.len() as f64).sqrt()),
                100.0 * deviation / mean
            );
        }
    }
}
