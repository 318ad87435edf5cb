//! The goals of `docs/optimisation.md`, measured: our optimiser beside scikit-optimize's `gp_minimize` on the same functions.
//!
//!     cargo bench --bench optimisation_goals -- [--seeds 40] [--first-seed 0] [--reference FILE] [--quick] [problem …]
//!
//! `--quick` leaves out the cost and the replay.
//!
//! Both methods get 60 evaluations, 15 of them initial. `benches/gp_minimize.py` writes the reference's runs.

#[path = "optimisation/cpu.rs"]
mod cpu;
#[path = "optimisation/medians.rs"]
mod medians;
#[path = "optimisation/problems.rs"]
mod problems;

use std::sync::Mutex;

use optimise::{Coordinate, Definition, Evaluation, InitialDesign, Method, Optimiser, run};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use serde::Deserialize;

use cpu::thread_cpu_s;
use medians::{bootstrap_medians, median_interval, quantile};
use problems::{PROBLEMS, Problem};

const EVALUATIONS: usize = 60;
const PENALTY: f64 = 1000.0;
/// A run that ends further from the optimum than this has missed the right basin.
const LOST: f64 = 0.15;

/// What one run ended with.
struct Outcome {
    /// True regret of the point with the smallest observed value (the reference's answer).
    observed: f64,
    /// True regret of the point with the lowest posterior mean (our answer).
    predicted: f64,
    observed_feasible: bool,
    predicted_feasible: bool,
    /// Smallest observed value minus the truth there: the luck in a reported minimum.
    bias: f64,
    cpu_s: f64,
}

/// One line of the reference's file.
#[derive(Deserialize)]
struct ReferenceRun {
    problem: String,
    seed: u64,
    points: Vec<Vec<f64>>,
    values: Vec<f64>,
    cpu_s: f64,
}

struct Arguments {
    seeds: u64,
    first_seed: u64,
    reference: String,
    quick: bool,
    problems: Vec<String>,
}

fn arguments() -> Arguments {
    let mut parsed = Arguments {
        seeds: 40,
        first_seed: 0,
        reference: "target/gp_minimize.jsonl".to_owned(),
        quick: false,
        problems: Vec::new(),
    };
    let mut given = std::env::args().skip(1);
    while let Some(argument) = given.next() {
        let mut number =
            || given.next().and_then(|text| text.parse().ok()).expect("a number after the option");
        match argument.as_str() {
            "--bench" => {}
            "--seeds" => parsed.seeds = number(),
            "--first-seed" => parsed.first_seed = number(),
            "--reference" => parsed.reference = given.next().expect("a file after --reference"),
            "--quick" => parsed.quick = true,
            name => parsed.problems.push(name.to_owned()),
        }
    }
    parsed
}

fn coordinates(point: &[Coordinate]) -> Vec<f64> {
    point.iter().map(|value| value.number().expect("the problems are real")).collect()
}

fn normal(generator: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * (1.0 - generator.random::<f64>()).ln()).sqrt();
    radius * (2.0 * std::f64::consts::PI * generator.random::<f64>()).cos()
}

/// The noisy evaluation of proposal `id`.
fn evaluate(problem: &Problem, seed: u64, id: u64, x: &[f64]) -> Evaluation {
    let mut generator = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed);
    generator.set_stream(id);
    let (objective, margins) = (problem.truth)(x);
    let objective = objective + (problem.objective_noise)(x) * normal(&mut generator);
    let margins: Vec<f64> =
        margins.iter().map(|margin| margin + problem.margin_noise * normal(&mut generator)).collect();
    Evaluation::constrained(objective, &margins)
}

fn definition(problem: &Problem, seed: u64, method: Method) -> Definition {
    Definition {
        constraints: problem.constraints,
        method,
        budget: EVALUATIONS,
        ..Definition::new(problem.space(), seed)
    }
}

/// One way of ours to spend the evaluations.
struct Contender {
    name: &'static str,
    definition: fn(&Problem, u64) -> Definition,
    batch: usize,
}

fn bayesian(problem: &Problem, seed: u64) -> Definition {
    definition(problem, seed, Method::Bayesian)
}

fn like_the_reference(problem: &Problem, seed: u64) -> Definition {
    let method = Method::GpMinimizeLike { penalty: PENALTY };
    Definition { initial_design: InitialDesign::Random, ..definition(problem, seed, method) }
}

fn random(problem: &Problem, seed: u64) -> Definition {
    definition(problem, seed, Method::Random)
}

const CONTENDERS: [Contender; 4] = [
    Contender { name: "bayesian", definition: bayesian, batch: 1 },
    Contender { name: "bayesian, batches of 9", definition: bayesian, batch: 9 },
    Contender { name: "gp_minimize_like", definition: like_the_reference, batch: 1 },
    Contender { name: "random", definition: random, batch: 1 },
];

fn judged(problem: &Problem, optimiser: &Optimiser, cpu_s: f64) -> Outcome {
    let truth = |point: &[Coordinate]| {
        let (objective, margins) = (problem.truth)(&coordinates(point));
        (objective - problem.optimum, margins.iter().all(|margin| *margin >= 0.0))
    };
    let nothing = (f64::INFINITY, false);
    let observed = optimiser.best_observed();
    let (observed_regret, observed_feasible) = observed.map_or(nothing, |trial| truth(&trial.point));
    let predicted = optimiser.best_predicted().expect("the history can be fitted");
    let (predicted_regret, predicted_feasible) = predicted.map_or(nothing, |pick| truth(&pick.point));
    let bias = observed.map_or(f64::NAN, |trial| {
        trial.evaluation.objectives[0].value.unwrap_or(f64::NAN)
            - (problem.truth)(&coordinates(&trial.point)).0
    });
    Outcome {
        observed: observed_regret,
        predicted: predicted_regret,
        observed_feasible,
        predicted_feasible,
        bias,
        cpu_s,
    }
}

fn ours(problem: &Problem, seed: u64, definition: Definition, batch: usize) -> Outcome {
    let mut optimiser = Optimiser::new(definition).expect("the definition is sound");
    let start = thread_cpu_s();
    while optimiser.stop_reason().is_none() {
        for proposal in optimiser.ask(batch) {
            let evaluation = evaluate(problem, seed, proposal.id, &coordinates(&proposal.point));
            optimiser.tell(proposal.id, evaluation).expect("it was asked for");
        }
    }
    let cpu_s = thread_cpu_s() - start;
    judged(problem, &optimiser, cpu_s)
}

/// The reference's points through the same judgement: for its posterior-mean pick both methods share one model.
fn theirs(problem: &Problem, reference: &ReferenceRun) -> Outcome {
    // It never saw margins: an infeasible evaluation told it the penalty only.
    let unconstrained = Definition { constraints: 0, ..definition(problem, reference.seed, Method::Random) };
    let mut optimiser = Optimiser::new(unconstrained).expect("the definition is sound");
    for (point, &value) in reference.points.iter().zip(&reference.values) {
        let point: Vec<Coordinate> = point.iter().map(|&x| Coordinate::Real(x)).collect();
        optimiser.observe(&point, Evaluation::of(value)).expect("the points are in the space");
    }
    judged(problem, &optimiser, reference.cpu_s)
}

/// How much larger the median of `a` is than that of `b`, with the central 90 % of its bootstrap distribution.
fn difference_interval(a: &[f64], b: &[f64]) -> String {
    let medians = bootstrap_medians(a, 1).into_iter().zip(bootstrap_medians(b, 2));
    let differences: Vec<f64> = medians.map(|(a, b)| a - b).collect();
    let difference = quantile(a, 0.5) - quantile(b, 0.5);
    format!("{difference:+.4} [{:+.4}, {:+.4}]", quantile(&differences, 0.05), quantile(&differences, 0.95))
}

/// Regrets of the picks that are truly feasible.
fn feasible_regrets(
    outcomes: &[Outcome],
    feasible: fn(&Outcome) -> bool,
    regret: fn(&Outcome) -> f64,
) -> Vec<f64> {
    outcomes.iter().filter(|outcome| feasible(outcome)).map(regret).collect()
}

fn predicted_regrets(outcomes: &[Outcome]) -> Vec<f64> {
    feasible_regrets(outcomes, |o| o.predicted_feasible, |o| o.predicted)
}

fn row(problem: &Problem, method: &str, outcomes: &[Outcome]) {
    if outcomes.is_empty() {
        return;
    }
    let count = outcomes.len();
    let of = |field: fn(&Outcome) -> f64| outcomes.iter().map(field).collect::<Vec<f64>>();
    let predicted = predicted_regrets(outcomes);
    let observed = feasible_regrets(outcomes, |o| o.observed_feasible, |o| o.observed);
    let interval = |values: &[f64]| if values.is_empty() { "-".to_owned() } else { median_interval(values) };
    println!(
        "| {} | {method} | {count} | {} | {} | {:.3} | {} / {} | {:+.3} | {:.3} |",
        problem.name,
        interval(&predicted),
        interval(&observed),
        outcomes.iter().filter(|o| o.predicted > LOST).count() as f64 / count as f64,
        outcomes.iter().filter(|o| !o.predicted_feasible).count(),
        outcomes.iter().filter(|o| !o.observed_feasible).count(),
        quantile(&of(|o| o.bias), 0.5),
        quantile(&of(|o| o.cpu_s), 0.5),
    );
}

fn regret_table(arguments: &Arguments, reference: &[ReferenceRun]) {
    println!(
        "| problem | method | runs | regret, posterior-mean pick | regret, smallest observed | lost | infeasible picks (posterior / observed) | bias of smallest | CPU s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let chosen = |problem: &&Problem| {
        arguments.problems.is_empty() || arguments.problems.iter().any(|name| name == problem.name)
    };
    let seeds: Vec<u64> = (arguments.first_seed..arguments.first_seed + arguments.seeds).collect();
    let mut batches = Vec::new();
    for problem in PROBLEMS.iter().filter(chosen) {
        let runs: Vec<&ReferenceRun> = reference.iter().filter(|run| run.problem == problem.name).collect();
        row(
            problem,
            "gp_minimize 0.10.2",
            &runs.par_iter().map(|run| theirs(problem, run)).collect::<Vec<_>>(),
        );
        let outcomes = |contender: &Contender| {
            let one =
                |&seed: &u64| ours(problem, seed, (contender.definition)(problem, seed), contender.batch);
            let outcomes: Vec<Outcome> = seeds.par_iter().map(one).collect();
            row(problem, contender.name, &outcomes);
            predicted_regrets(&outcomes)
        };
        let [one_at_a_time, nine_at_once, ..] = CONTENDERS.each_ref().map(outcomes);
        batches.push((problem.name, difference_interval(&nine_at_once, &one_at_a_time)));
    }
    println!("\n| problem | regret in batches of 9, minus one at a time |");
    println!("|---|---|");
    for (problem, difference) in batches {
        println!("| {problem} | {difference} |");
    }
}

/// CPU per proposal as the history grows to 200, and of a hundred individuals in parallel.
fn cost_table() {
    println!("\n| cost | CPU |");
    println!("|---|---|");
    for name in ["gramacy", "hartmann6", "toy2"] {
        let problem = PROBLEMS.iter().find(|problem| problem.name == name).expect("it exists");
        let wide = Definition { budget: 210, ..definition(problem, 3, Method::Bayesian) };
        let mut optimiser = Optimiser::new(wide).expect("the definition is sound");
        let mut steps_ms = Vec::new();
        while optimiser.stop_reason().is_none() {
            let start = thread_cpu_s();
            let proposals = optimiser.ask(1);
            steps_ms.push(1e3 * (thread_cpu_s() - start));
            for proposal in proposals {
                let evaluation = evaluate(problem, 3, proposal.id, &coordinates(&proposal.point));
                optimiser.tell(proposal.id, evaluation).expect("it was asked for");
            }
        }
        for (from, to) in [(50, 60), (90, 100), (190, 210)] {
            let window = &steps_ms[from..to];
            println!(
                "| {name}: one proposal at n = {from}…{to} | mean {:.1} ms, largest {:.1} ms |",
                window.iter().sum::<f64>() / window.len() as f64,
                window.iter().copied().fold(0.0, f64::max)
            );
        }
    }
    let total = Mutex::new(0.0);
    (0..100u64).into_par_iter().for_each(|individual| {
        let problem = &PROBLEMS[individual as usize % 3];
        let cpu_s =
            ours(problem, 5000 + individual, definition(problem, individual, Method::Bayesian), 1).cpu_s;
        *total.lock().expect("nothing panics while holding it") += cpu_s;
    });
    println!(
        "| 100 individuals × 60 evaluations | {:.1} s |",
        total.into_inner().expect("nothing panics while holding it")
    );
}

/// The same bits from one worker and from four.
fn replay_check() {
    let problem = &PROBLEMS[2];
    let final_state = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can be made");
        let mut optimiser =
            Optimiser::new(definition(problem, 11, Method::Bayesian)).expect("the definition is sound");
        pool.install(|| {
            run(&mut optimiser, 5, None, |proposal| {
                evaluate(problem, 11, proposal.id, &coordinates(&proposal.point))
            })
        })
        .expect("nothing can fail without a journal");
        serde_json::to_string(&optimiser).expect("the state is plain data")
    };
    let same = final_state(1) == final_state(4);
    println!("| final state with 1 and with 4 workers | {} |", if same { "same bits" } else { "DIFFERENT" });
}

fn main() {
    let arguments = arguments();
    let text = std::fs::read_to_string(&arguments.reference).unwrap_or_default();
    let reference: Vec<ReferenceRun> =
        text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    if reference.is_empty() {
        eprintln!("no reference runs in {}: run benches/gp_minimize.py first", arguments.reference);
    }
    regret_table(&arguments, &reference);
    if !arguments.quick {
        cost_table();
        replay_check();
    }
}
