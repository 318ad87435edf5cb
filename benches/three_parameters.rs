//! How many candidates a tune of three parameters under three constraints needs: ours, the paper's penalty method, and chance.
//!
//!     cargo bench --bench three_parameters -- [--seeds 10] [--random 300]
//!
//! The tune is `gentle` of `suites/gentle_braking.suite`: real simulations of 20 people at their worst arrival time. Every
//! candidate meets the same runs, so its objective and constraints are exact. `--random` candidates of each seed are drawn
//! uniformly; the Bayesian methods get the 100 that the suite gives them.

use files::Disk;
use models::standard;
use rayon::prelude::*;
use results::{BlockResult, Candidate};
use runner::experiment::{Context, EarlierResults, Silent, run_block};
use runner::run::Threads;
use scenario::{Block, SearchMethod, Tune};
use std::path::Path;

/// A feasible candidate that loses no more than this beyond the best known one has found the optimum, as a share of that one's.
const TOLERANCE: f64 = 0.1;

struct Arguments {
    seeds: u32,
    random: u32,
}

fn arguments() -> Arguments {
    let mut parsed = Arguments { seeds: 10, random: 300 };
    let mut given = std::env::args().skip(1);
    while let Some(argument) = given.next() {
        let mut number =
            || given.next().and_then(|text| text.parse().ok()).expect("a number after the option");
        match argument.as_str() {
            "--bench" => {}
            "--seeds" => parsed.seeds = number(),
            "--random" => parsed.random = number(),
            other => panic!("there is no option `{other}`"),
        }
    }
    parsed
}

/// The objective of a feasible candidate.
fn cost(candidate: &Candidate) -> Option<f64> {
    candidate.objectives[0].filter(|_| candidate.feasible)
}

/// Number of the first candidate, from 1, whose cost is at most `most`.
fn first(candidates: &[Candidate], most: f64) -> Option<usize> {
    candidates.iter().position(|one| cost(one).is_some_and(|cost| cost <= most)).map(|index| index + 1)
}

/// "41 (24 .. 66), 9 of 10": median (of two the smaller: candidates are whole), range and how many of the runs got there.
fn summary(counts: &[Option<usize>]) -> String {
    let mut reached: Vec<usize> = counts.iter().flatten().copied().collect();
    reached.sort_unstable();
    // A run that never got there needs more than any that did.
    let median = reached.get((counts.len() - 1) / 2).map_or("more".to_owned(), ToString::to_string);
    let range = match (reached.first(), reached.last()) {
        (Some(least), Some(most)) => format!(" ({least} .. {most})"),
        _ => String::new(),
    };
    format!("{median}{range}, {} of {}", reached.len(), counts.len())
}

fn main() {
    let arguments = arguments();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("suites/gentle_braking.suite");
    let loaded = lang::load(&path, &standard(), &Disk)
        .unwrap_or_else(|failure| panic!("{}", failure.render(lang::Style { colour: false })));
    let suite = loaded.suite;
    let threads = Threads::all();
    let context = Context::new(&suite, &threads, &standard());
    let mut results = EarlierResults::default();
    let search = Block::Search(suite.searches[0].clone());
    let found = run_block(&search, &context, &results, &Silent).expect("the search runs");
    results.blocks.insert(search.name().to_owned(), found);

    // Another name is another seed of the optimiser; the cases keep theirs.
    let run = |method: SearchMethod, evaluations: u32, seed: u32| -> Vec<Candidate> {
        let mut tune: Tune = suite.tunes[0].clone();
        tune.name = format!("{}{seed}", tune.name);
        tune.compare_with_default = false;
        tune.budget.method = method;
        tune.budget.evaluations = evaluations;
        match run_block(&Block::Tune(tune.clone()), &context, &results, &Silent).expect("the tune runs") {
            BlockResult::Tune(result) => result.evaluations,
            _ => unreachable!("a tune gives a tune's result"),
        }
    };
    let budget = suite.tunes[0].budget.evaluations;
    let methods = [
        ("bayesian", SearchMethod::Bayesian, budget),
        ("gp_minimize_like", SearchMethod::GpMinimizeLike, budget),
        ("random", SearchMethod::Random, arguments.random),
    ];
    let all: Vec<(&str, u32, Vec<Vec<Candidate>>)> = methods
        .into_iter()
        .map(|(name, method, evaluations)| {
            let seeds = (0..arguments.seeds).into_par_iter();
            (name, evaluations, seeds.map(|seed| run(method, evaluations, seed)).collect())
        })
        .collect();
    let candidates = all.iter().flat_map(|(_, _, runs)| runs).flatten();
    let best = candidates.filter_map(cost).fold(f64::INFINITY, f64::min);
    let good = (1.0 + TOLERANCE) * best;
    println!("Best known: {best:.4} s lost on average; an optimum loses at most {good:.4} s.\n");
    println!(
        "| method | candidates | feasible | first feasible one | optimum reached | best cost, median | worst |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (name, evaluations, runs) in &all {
        let feasible = runs.iter().flatten().filter(|one| one.feasible).count() as f64;
        let mut costs: Vec<f64> =
            runs.iter().map(|run| run.iter().filter_map(cost).fold(f64::INFINITY, f64::min)).collect();
        costs.sort_by(f64::total_cmp);
        println!(
            "| {name} | {} × {evaluations} | {:.1} % | {} | {} | {:.4} | {:.4} |",
            runs.len(),
            100.0 * feasible / (runs.len() as f64 * f64::from(*evaluations)),
            summary(&runs.iter().map(|run| first(run, f64::INFINITY)).collect::<Vec<_>>()),
            summary(&runs.iter().map(|run| first(run, good)).collect::<Vec<_>>()),
            costs[(costs.len() - 1) / 2],
            costs[costs.len() - 1],
        );
    }
    let chance = all.iter().filter(|(name, ..)| *name == "random").flat_map(|(_, _, runs)| runs).flatten();
    let (hits, drawn) = chance.fold((0usize, 0usize), |(hits, drawn), one| {
        (hits + usize::from(cost(one).is_some_and(|cost| cost <= good)), drawn + 1)
    });
    let share = hits as f64 / drawn as f64;
    println!(
        "\n{hits} of {drawn} random candidates are an optimum: an even chance of one takes {:.0} of them.",
        0.5f64.ln() / (1.0 - share).ln()
    );
}
