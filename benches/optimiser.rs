//! What the optimiser itself takes, and whether a change to it finds worse places: regrets of the same seeds before and after.
//!
//!     cargo bench --bench optimiser -- cost [--seeds 50] [problem …]               # CPU time of searches of 50 evaluations
//!     cargo bench --bench optimiser -- regrets [--seeds 50] [--first-seed 0] [problem …] > after.jsonl
//!     cargo bench --bench optimiser -- compare before.jsonl after.jsonl
//!
//! A search has 15 initial evaluations, as those of the paper, and asks for one point at a time or for nine. Its regret is the true
//! one of its answer, the evaluated point of lowest posterior mean; an answer that is not feasible is worse than any that is.

#[path = "optimisation/cpu.rs"]
mod cpu;
#[path = "optimisation/medians.rs"]
mod medians;
#[path = "optimisation/problems.rs"]
mod problems;

use std::fs;
use std::hash::Hasher;

use numbers::distributions::binomial_at_most;
use numbers::distributions::normal;
use numbers::random::Stream;
use optimise::{Coordinate, Definition, Evaluation, Optimiser};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use cpu::thread_cpu_s;
use medians::{median_interval, quantile};
use problems::{PROBLEMS, Problem};

const EVALUATIONS: usize = 50;
const BATCHES: [usize; 2] = [1, 9];

/// One line of what `regrets` writes.
#[derive(Serialize, Deserialize)]
struct Search {
    problem: String,
    batch: usize,
    seed: u64,
    /// Of the point of lowest posterior mean; none where that is not feasible.
    predicted: Option<f64>,
    /// Of the smallest observed value, likewise.
    observed: Option<f64>,
    /// Of all points in order, to tell whether two searches went the same way.
    points: u64,
    cpu_ms: f64,
}

fn coordinates(point: &[Coordinate]) -> Vec<f64> {
    point.iter().map(|value| value.number().expect("the problems are real")).collect()
}

fn evaluate(problem: &Problem, seed: u64, id: u64, x: &[f64]) -> Evaluation {
    let mut noise = Stream::numbered(seed ^ 0x5eed, id);
    let (objective, margins) = (problem.truth)(x);
    let objective = objective + (problem.objective_noise)(x) * noise.normal();
    let margins: Vec<f64> =
        margins.iter().map(|margin| margin + problem.margin_noise * noise.normal()).collect();
    Evaluation::constrained(objective, &margins)
}

fn searched(problem: &Problem, batch: usize, seed: u64) -> Search {
    let definition = Definition {
        constraints: problem.constraints,
        budget: EVALUATIONS,
        ..Definition::new(problem.space(), seed)
    };
    let mut optimiser = Optimiser::new(definition).expect("the definition is sound");
    let mut cpu_s = 0.0;
    while optimiser.stop_reason().is_none() {
        let start = thread_cpu_s();
        let proposals = optimiser.ask(batch);
        cpu_s += thread_cpu_s() - start;
        for proposal in proposals {
            let evaluation = evaluate(problem, seed, proposal.id, &coordinates(&proposal.point));
            optimiser.tell(proposal.id, evaluation).expect("it was asked for");
        }
    }
    let regret = |point: &[Coordinate]| {
        let (objective, margins) = (problem.truth)(&coordinates(point));
        margins.iter().all(|margin| *margin >= 0.0).then_some(objective - problem.optimum)
    };
    let mut points = std::hash::DefaultHasher::new();
    for trial in optimiser.trials() {
        coordinates(&trial.point).iter().for_each(|x| points.write_u64(x.to_bits()));
    }
    let predicted = optimiser.best_predicted().expect("the history can be fitted");
    Search {
        problem: problem.name.to_owned(),
        batch,
        seed,
        predicted: predicted.and_then(|pick| regret(&pick.point)),
        observed: optimiser.best_observed().and_then(|trial| regret(&trial.point)),
        points: points.finish(),
        cpu_ms: 1e3 * cpu_s,
    }
}

fn cost(chosen: &[&Problem], seeds: std::ops::Range<u64>) {
    println!("| problem | points at a time | CPU of a search of {EVALUATIONS} evaluations, ms | fastest |");
    println!("|---|--:|--:|--:|");
    for problem in chosen {
        for batch in BATCHES {
            let all: Vec<f64> = seeds.clone().map(|seed| searched(problem, batch, seed).cpu_ms).collect();
            let fastest = all.iter().copied().fold(f64::INFINITY, f64::min);
            println!("| {} | {batch} | {} | {fastest:.2} |", problem.name, median_interval(&all));
        }
    }
}

fn regrets(chosen: &[&Problem], seeds: std::ops::Range<u64>) {
    for problem in chosen {
        for batch in BATCHES {
            let all: Vec<Search> =
                seeds.clone().into_par_iter().map(|seed| searched(problem, batch, seed)).collect();
            for one in all {
                println!("{}", serde_json::to_string(&one).expect("it is plain data"));
            }
        }
    }
}

fn read(file: &str) -> Vec<Search> {
    let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{file}: {error}"));
    text.lines().map(|line| serde_json::from_str(line).expect("a line of `regrets`")).collect()
}

/// How probable such a difference in signs is, or a larger one, where neither is better: exact and two-sided.
fn sign_test(worse: usize, better: usize) -> f64 {
    let (few, all) = (worse.min(better) as u64, (worse + better) as u64);
    if all == 0 { 1.0 } else { (2.0 * binomial_at_most(few, all, 0.5)).min(1.0) }
}

/// Wilcoxon's signed-rank test, two-sided, by the normal approximation with shared ranks; pairs that are equal are left out.
fn signed_rank_test(differences: &[f64]) -> f64 {
    let mut all: Vec<f64> = differences.iter().copied().filter(|difference| *difference != 0.0).collect();
    all.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let n = all.len() as f64;
    let (mut positive, mut ties, mut first) = (0.0, 0.0, 0);
    for equal in all.chunk_by(|a, b| a.abs() == b.abs()) {
        let count = equal.len() as f64;
        let rank = first as f64 + 0.5 * (count + 1.0);
        positive += rank * equal.iter().filter(|difference| **difference > 0.0).count() as f64;
        ties += count * (count * count - 1.0);
        first += equal.len();
    }
    let variance = n * (n + 1.0) * (2.0 * n + 1.0) / 24.0 - ties / 48.0;
    if variance <= 0.0 {
        return 1.0;
    }
    let z = (positive - 0.25 * n * (n + 1.0)) / variance.sqrt();
    2.0 * normal::cumulative(-z.abs())
}

fn compare(before: &[Search], after: &[Search]) {
    println!(
        "| problem | points at a time | regret before | regret after | difference: median (quartiles) | better / equal / worse | sign test | Wilcoxon | same points | not feasible, before / after |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    let regret = |search: &Search| search.predicted.unwrap_or(f64::INFINITY);
    let mut pooled = (0, 0);
    for problem in &PROBLEMS {
        for batch in BATCHES {
            let of = |all: &'_ [Search]| -> Vec<usize> {
                (0..all.len()).filter(|&i| all[i].problem == problem.name && all[i].batch == batch).collect()
            };
            let pairs: Vec<(&Search, &Search)> = of(before)
                .into_iter()
                .filter_map(|i| {
                    let other = of(after).into_iter().find(|&j| after[j].seed == before[i].seed)?;
                    Some((&before[i], &after[other]))
                })
                .collect();
            if pairs.is_empty() {
                continue;
            }
            let differences: Vec<f64> = pairs
                .iter()
                .map(|(a, b)| if regret(a) == regret(b) { 0.0 } else { regret(b) - regret(a) })
                .collect();
            let worse = differences.iter().filter(|difference| **difference > 0.0).count();
            let better = differences.iter().filter(|difference| **difference < 0.0).count();
            pooled = (pooled.0 + better, pooled.1 + worse);
            let (old, new): (Vec<f64>, Vec<f64>) = pairs.iter().map(|(a, b)| (regret(a), regret(b))).unzip();
            let broken = |all: &[f64]| all.iter().filter(|regret| regret.is_infinite()).count();
            println!(
                "| {} | {batch} | {} | {} | {:+.4} ({:+.4} .. {:+.4}) | {better} / {} / {worse} | {:.3} | {:.3} | {} of {} | {} / {} |",
                problem.name,
                median_interval(&old),
                median_interval(&new),
                quantile(&differences, 0.5),
                quantile(&differences, 0.25),
                quantile(&differences, 0.75),
                pairs.len() - better - worse,
                sign_test(worse, better),
                signed_rank_test(&differences),
                pairs.iter().filter(|(a, b)| a.points == b.points).count(),
                pairs.len(),
                broken(&old),
                broken(&new),
            );
        }
    }
    let (better, worse) = pooled;
    println!("\nOver all: {better} better, {worse} worse, sign test {:.3}", sign_test(worse, better));
}

fn main() {
    let (mut seeds, mut first, mut words) = (50, 0, Vec::new());
    let mut given = std::env::args().skip(1);
    while let Some(argument) = given.next() {
        let mut number = || given.next().and_then(|text| text.parse().ok()).expect("a number follows");
        match argument.as_str() {
            "--bench" => {}
            "--seeds" => seeds = number(),
            "--first-seed" => first = number(),
            word => words.push(word.to_owned()),
        }
    }
    let (mode, rest) = words.split_first().expect("cost, regrets or compare");
    let chosen: Vec<&Problem> = PROBLEMS
        .iter()
        .filter(|problem| rest.is_empty() || rest.iter().any(|name| name == problem.name))
        .collect();
    match (mode.as_str(), rest) {
        ("cost", _) => cost(&chosen, first..first + seeds),
        ("regrets", _) => regrets(&chosen, first..first + seeds),
        ("compare", [before, after]) => compare(&read(before), &read(after)),
        _ => panic!("there are cost, regrets and compare with two files"),
    }
}
