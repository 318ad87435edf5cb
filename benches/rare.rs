//! How often bounds and intervals of rare probabilities cover, on problems whose probability is known in closed form.
//!
//! `cargo bench --bench rare` takes some minutes and prints two tables; `-- pairs` prints the second alone.

#![allow(clippy::print_stdout, reason = "prints its table")]

use numbers::distributions::normal;
use numbers::random::derive_seed;
use numbers::rare::{
    ImportanceSampling, PairedEvent, PairedRareEstimate, RareAxis, RareEstimate, RareOutcome, RarePoint,
    RareSampling, RareScale, RareSpace, SplittingSampling,
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

/// Two events of a point of two axes: how far it is from each, and how probable they are.
struct Pair {
    name: &'static str,
    first: fn(&[f64]) -> f64,
    second: fn(&[f64]) -> f64,
    probabilities: (f64, f64),
}

fn pairs() -> Vec<Pair> {
    vec![
        Pair {
            name: "the same",
            first: |z| 3.5 - z[0],
            second: |z| 3.5 - z[0],
            probabilities: (tail(3.5), tail(3.5)),
        },
        Pair {
            name: "1.5 % rarer",
            first: |z| 3.504 - z[0],
            second: |z| 3.5 - z[0],
            probabilities: (tail(3.504), tail(3.5)),
        },
        Pair {
            name: "a quarter rarer",
            first: |z| 3.58 - z[0],
            second: |z| 3.5 - z[0],
            probabilities: (tail(3.58), tail(3.5)),
        },
        Pair {
            name: "a fifteenth, as rare as 1.6e-5",
            first: |z| 4.16 - z[0],
            second: |z| 3.5 - z[0],
            probabilities: (tail(4.16), tail(3.5)),
        },
        Pair {
            name: "as probable elsewhere",
            first: |z| 3.5 - z[0],
            second: |z| 3.5 + z[0],
            probabilities: (tail(3.5), tail(3.5)),
        },
        Pair {
            name: "and a region of its own",
            first: |z| (3.5 - z[0]).min(3.3 - z[1]),
            second: |z| 3.5 - z[0],
            probabilities: (either(tail(3.5), tail(3.3)), tail(3.5)),
        },
    ]
}

fn compared(method: Method, pair: &Pair, budget: usize, repetition: u64) -> PairedRareEstimate {
    let space = RareSpace::new(vec![RareAxis::Continuous; 2]);
    let mut method = method(space.clone(), budget, derive_seed(repetition, pair.name));
    let mut had = Vec::new();
    while let Some(round) = method.ask() {
        let mut outcome = |one: &RarePoint| {
            let z: Vec<f64> = one.point.iter().map(|share| normal::quantile(*share)).collect();
            let (first, second) = ((pair.first)(&z), (pair.second)(&z));
            had.push(PairedEvent { first: first <= 0.0, second: second <= 0.0 });
            RareOutcome { event: first.min(second) <= 0.0, score: first.min(second) }
        };
        let outcomes: Vec<_> = round.points.iter().map(&mut outcome).collect();
        method.tell(&outcomes);
    }
    PairedRareEstimate::of(&space, method.replicates(), RareScale::Logarithmic, |run| had[run])
}

/// How often differences and ratios are covered, of two in the same encounters.
fn print_pairs() {
    println!(
        "\n| two | by | encounters | refused | difference covers | ratio covers | ratio's upper bound holds | guaranteed covers | half width of the ratio |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for pair in pairs() {
        for (by, method, budget) in METHODS.iter().map(|(by, method, budgets)| (by, *method, budgets[0])) {
            let all: Vec<PairedRareEstimate> = (0..REPETITIONS)
                .into_par_iter()
                .map(|repetition| compared(method, &pair, budget, repetition))
                .collect();
            let (one, other) = pair.probabilities;
            let kept: Vec<_> = all.iter().filter(|one| one.ratio_refusals().is_empty()).collect();
            let count =
                |holds: &dyn Fn(&PairedRareEstimate) -> bool| kept.iter().filter(|one| holds(one)).count();
            let difference = count(&|found| found.difference_interval(0.95).contains(one - other));
            let ratio = count(&|found| found.ratio_interval(0.95).contains(one / other));
            let upper = count(&|found| one / other <= found.ratio_upper(0.95));
            let guaranteed =
                all.iter().filter(|found| found.guaranteed_difference(0.975).contains(one - other)).count();
            let widths =
                kept.iter().map(|found| found.ratio_interval(0.95)).map(|one| (one.high - one.low) / 2.0);
            println!(
                "| {} | {by} | {budget} | {} | {difference} of {n} | {ratio} of {n} | {upper} of {n} | {guaranteed} of {} | {:.3} |",
                pair.name,
                all.len() - kept.len(),
                all.len(),
                widths.sum::<f64>() / kept.len().max(1) as f64,
                n = kept.len()
            );
        }
    }
}

fn main() {
    // `-- pairs` prints the second table alone.
    if std::env::args().any(|one| one == "pairs") {
        return print_pairs();
    }
    print_problems();
    print_pairs();
}

fn print_problems() {
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
