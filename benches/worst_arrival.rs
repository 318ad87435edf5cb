//! The worst arrival time of 20 people, really simulated: our search beside scikit-optimize's `gp_minimize`.
//!
//!     cargo bench --bench worst_arrival --no-run          # says where the program is
//!     OMP_NUM_THREADS=1 target/reference/bin/python benches/gp_minimize.py --encounters PROGRAM --out target/worst_arrival.jsonl
//!     cargo bench --bench worst_arrival -- [--repetitions 3] [--fresh 400] [--reference target/worst_arrival.jsonl]
//!     cargo bench --bench worst_arrival -- curves         # mean PET and its spread over time to arrival, person by person
//!
//! The objective is one simulated run of `scenarios/zebra/commotions_carla.scn`: the post-encroachment time of one of 20
//! individuals who appears at a time to arrival in [6, 18] s. Both methods get 60 runs, 15 of them before the first model.
//! With `serve` the program answers each line `[individual, time_to_arrival, seed]` with the value, `null` if undefined.

use files::Disk;
use models::standard;
use numbers::random::derive_seed;
use optimise::{Definition, Evaluation, InitialDesign, Method, Optimiser, Proposal, SearchDimension, Space};
use rayon::prelude::*;
use results::Requests;
use runner::plan::{concrete_case, select_people};
use runner::run::{FreeFlows, Unwatched, run_case};
use scenario::{Assignment, Individual, MetricReference, PopulationShare, Scenario, Value};
use serde::Deserialize;
use std::io::{BufRead, Write};
use std::path::Path;

const PEOPLE: u32 = 20;
const EVALUATIONS: usize = 60;
const INITIAL: usize = 15;
const RANGE: (f64, f64) = (6.0, 18.0);
/// What `gp_minimize` is told where the time is undefined: the end of the scenario, towards worse.
const UNDEFINED: f64 = 60.0;

/// The encounter, with the people who may take part in it.
struct Encounters {
    scenario: Scenario,
    people: Vec<Vec<Individual>>,
    requests: Requests,
    free_flows: FreeFlows,
}

impl Encounters {
    fn load() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/zebra/commotions_carla.scn");
        let loaded = lang::load(&path, &standard(), &Disk)
            .unwrap_or_else(|failure| panic!("{}", failure.render(lang::Style { colour: false })));
        let mut scenario = loaded.suite.scenarios[0].clone();
        for pedestrian in &mut scenario.pedestrians {
            if let Some(individuals) = &mut pedestrian.individuals {
                individuals.selection = PopulationShare::Count(PEOPLE);
            }
        }
        let people = select_people(loaded.suite.seed, &scenario).expect("the population has enough people");
        let mut requests = Requests::defaults(&standard());
        requests.add(&pet());
        Encounters { scenario, people, requests, free_flows: FreeFlows::default() }
    }

    /// One run: the post-encroachment time in s.
    fn run(&self, individual: usize, time_to_arrival: f64, seed: u64) -> Option<f64> {
        let label = format!("{time_to_arrival}s");
        let variation = vec![Assignment { name: "tta".into(), label, value: Value::Number(time_to_arrival) }];
        let people = self.people[individual].clone();
        let case = concrete_case(&self.scenario, "worst_arrival".into(), variation, people, 1, seed)
            .expect("the scenario is sound");
        let outcome = run_case(&case, &self.requests, &self.free_flows, &mut Unwatched)
            .expect("the scenario can be run");
        outcome.metrics[self.requests.index(&pet()).expect("it was requested")]
    }

    /// Mean over seeds that no search has used, where it is defined.
    fn fresh(&self, individual: usize, time_to_arrival: f64, runs: usize) -> f64 {
        let seed = |run: usize| derive_seed(1, &format!("fresh/{individual}/{run}"));
        let values: Vec<f64> = (0..runs)
            .into_par_iter()
            .filter_map(|run| self.run(individual, time_to_arrival, seed(run)))
            .collect();
        values.iter().sum::<f64>() / values.len() as f64
    }
}

fn pet() -> MetricReference {
    MetricReference::plain(standard().metrics().get("pet").unwrap())
}

/// The seed of evaluation `id`: the same for every method.
fn run_seed(repetition: u64, individual: usize, id: u64) -> u64 {
    derive_seed(repetition, &format!("{individual}/{id}"))
}

/// One search: its points and what it was told.
#[derive(Deserialize)]
struct Search {
    individual: usize,
    repetition: u64,
    points: Vec<f64>,
    values: Vec<Option<f64>>,
    cpu_s: f64,
}

fn definition(method: Method, seed: u64) -> Definition {
    let space = Space::new(vec![SearchDimension::real("tta", RANGE.0, RANGE.1)]).expect("the range is sound");
    let initial_design = match method {
        Method::GpMinimizeLike { .. } => InitialDesign::Random,
        _ => InitialDesign::Stratified,
    };
    let base = Definition::new(space, seed);
    Definition { method, budget: EVALUATIONS, initial: INITIAL, initial_design, ..base }
}

fn thread_cpu_s() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split_whitespace().next().and_then(|text| text.parse::<f64>().ok()).map_or(f64::NAN, |ns| ns * 1e-9)
}

fn search(encounters: &Encounters, method: Method, individual: usize, repetition: u64) -> Search {
    let seed = derive_seed(repetition, &format!("search/{individual}"));
    let mut optimiser = Optimiser::new(definition(method, seed)).expect("the definition is sound");
    let mut cpu_s = 0.0;
    let asked = |optimiser: &mut Optimiser, cpu_s: &mut f64| -> Vec<Proposal> {
        let start = thread_cpu_s();
        let proposals = optimiser.ask(1);
        *cpu_s += thread_cpu_s() - start;
        proposals
    };
    loop {
        let proposals = asked(&mut optimiser, &mut cpu_s);
        let Some(proposal) = proposals.first() else { break };
        let time = proposal.point[0].number().expect("the dimension is real");
        let value = encounters.run(individual, time, run_seed(repetition, individual, proposal.id));
        optimiser.tell(proposal.id, Evaluation::of(value.unwrap_or(f64::NAN))).expect("it was asked for");
    }
    let trials = optimiser.trials().iter();
    let (points, values) = trials
        .map(|trial| (trial.point[0].number().expect("it is real"), trial.evaluation.objectives[0].value))
        .unzip();
    Search { individual, repetition, points, values, cpu_s }
}

/// The places that a search may call the worst: smallest observed value, and lowest posterior mean of the one model that
/// judges every method's points.
fn picks(search: &Search) -> Option<(f64, f64, f64)> {
    let mut optimiser = Optimiser::new(definition(Method::Random, 0)).expect("the definition is sound");
    for (&point, value) in search.points.iter().zip(&search.values) {
        let point = [optimise::Coordinate::Real(point)];
        optimiser
            .observe(&point, Evaluation::of(value.unwrap_or(f64::NAN)))
            .expect("the point is in the space");
    }
    let observed = optimiser.best_observed()?;
    let predicted = optimiser.best_predicted().expect("the history can be fitted")?;
    let place = |point: &[optimise::Coordinate]| point[0].number();
    Some((place(&observed.point)?, observed.evaluation.objectives[0].value?, place(&predicted.point)?))
}

/// A search with what its answers are worth on fresh seeds.
struct Judged {
    individual: usize,
    repetition: u64,
    observed_value: f64,
    observed_fresh: f64,
    predicted_fresh: f64,
    undefined: usize,
    cpu_s: f64,
}

fn judged(encounters: &Encounters, search: &Search, fresh: usize) -> Option<Judged> {
    let (observed, observed_value, predicted) = picks(search)?;
    Some(Judged {
        individual: search.individual,
        repetition: search.repetition,
        observed_value,
        observed_fresh: encounters.fresh(search.individual, observed, fresh),
        predicted_fresh: encounters.fresh(search.individual, predicted, fresh),
        undefined: search.values.iter().filter(|value| value.is_none()).count(),
        cpu_s: search.cpu_s,
    })
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    values.iter().sum::<f64>() / values.len() as f64
}

/// Mean of `a − b` over pairs and its standard error.
fn difference(a: &[f64], b: &[f64]) -> (f64, f64) {
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    let n = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / n;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

fn table(encounters: &Encounters, arguments: &Arguments) {
    let text = std::fs::read_to_string(&arguments.reference).unwrap_or_default();
    let reference: Vec<Search> = text
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok())
        .filter(|search: &Search| search.repetition < arguments.repetitions)
        .collect();
    if reference.is_empty() {
        eprintln!(
            "no reference runs in {}: run benches/gp_minimize.py --encounters first",
            arguments.reference
        );
    }
    let pairs: Vec<(usize, u64)> =
        (0..arguments.repetitions).flat_map(|r| (0..encounters.people.len()).map(move |i| (i, r))).collect();
    let ours = |method: Method| -> Vec<Search> {
        pairs
            .par_iter()
            .map(|&(individual, repetition)| search(encounters, method, individual, repetition))
            .collect()
    };
    let methods = [
        ("gp_minimize 0.10.2", reference),
        ("bayesian", ours(Method::Bayesian)),
        ("gp_minimize_like", ours(Method::GpMinimizeLike { penalty: UNDEFINED })),
        ("random", ours(Method::Random)),
    ];
    println!(
        "| method | searches | fresh mean at the smallest observed | fresh mean at the lowest posterior mean | smallest observed | best of a person found | undefined | CPU s |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let all: Vec<(&str, Vec<Judged>)> = methods
        .iter()
        .map(|(name, searches)| {
            let judged = searches.iter().filter_map(|search| judged(encounters, search, arguments.fresh));
            (*name, judged.collect())
        })
        .collect();
    // The lowest fresh mean that any search of any method has come upon, person by person.
    let lowest = |individual: usize| {
        let everything = all.iter().flat_map(|(_, judged)| judged).filter(|one| one.individual == individual);
        everything.map(|one| one.observed_fresh.min(one.predicted_fresh)).fold(f64::INFINITY, f64::min)
    };
    for (name, judged) in all.iter().filter(|(_, judged)| !judged.is_empty()) {
        let found = judged.iter().filter(|one| one.predicted_fresh <= lowest(one.individual) + 0.15).count();
        println!(
            "| {name} | {} | {:.3} | {:.3} | {:.3} | {:.0} % | {:.1} % | {:.3} |",
            judged.len(),
            mean(judged.iter().map(|one| one.observed_fresh)),
            mean(judged.iter().map(|one| one.predicted_fresh)),
            mean(judged.iter().map(|one| one.observed_value)),
            100.0 * found as f64 / judged.len() as f64,
            100.0 * judged.iter().map(|one| one.undefined).sum::<usize>() as f64
                / (judged.len() * EVALUATIONS) as f64,
            mean(judged.iter().map(|one| one.cpu_s)),
        );
    }
    println!(
        "\nDifference to gp_minimize over the same people and repetitions (negative: lower time found):"
    );
    let (_, reference) = &all[0];
    for (name, judged) in &all[1..] {
        let pair = |one: &&Judged| {
            reference
                .iter()
                .find(|other| other.individual == one.individual && other.repetition == one.repetition)
        };
        let both: Vec<(&Judged, &Judged)> =
            judged.iter().filter_map(|one| Some((one, pair(&one)?))).collect();
        if both.len() < 2 {
            continue;
        }
        let of = |ours: fn(&Judged) -> f64| {
            let (a, b): (Vec<f64>, Vec<f64>) = both.iter().map(|(a, b)| (ours(a), ours(b))).unzip();
            difference(&a, &b)
        };
        let (observed, observed_error) = of(|one| one.observed_fresh);
        let (predicted, predicted_error) = of(|one| one.predicted_fresh);
        println!(
            "{name}: smallest observed {observed:+.3} ± {observed_error:.3} s, lowest posterior mean {predicted:+.3} ± {predicted_error:.3} s"
        );
    }
}

/// Mean, standard deviation and share of undefined runs over a grid of times to arrival.
fn curves(encounters: &Encounters, runs: usize) {
    for individual in 0..encounters.people.len() {
        println!("individual {}", encounters.people[individual][0].number);
        for step in 0..=48 {
            let time = RANGE.0 + (RANGE.1 - RANGE.0) * f64::from(step) / 48.0;
            let seed = |run: usize| derive_seed(2, &format!("{individual}/{run}"));
            let values: Vec<f64> = (0..runs)
                .into_par_iter()
                .filter_map(|run| encounters.run(individual, time, seed(run)))
                .collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let variance =
                values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64;
            let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
            println!(
                "  {time:6.2}  {mean:6.3} ± {:5.3}  lowest {lowest:6.3}  undefined {}",
                variance.sqrt(),
                runs - values.len()
            );
        }
    }
}

/// Answers a line of standard input with a line of standard output.
#[allow(clippy::disallowed_methods, reason = "a benchmark talks to its script")]
fn serve(encounters: &Encounters) {
    let mut out = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        let (individual, time, repetition, id): (usize, f64, u64, u64) = serde_json::from_str(&line)
            .expect("a line is [individual, time to arrival, repetition, evaluation]");
        let value = encounters.run(individual, time, run_seed(repetition, individual, id));
        let text = serde_json::to_string(&value).expect("a number can be written");
        writeln!(out, "{text}").and_then(|()| out.flush()).expect("somebody reads the answers");
    }
}

struct Arguments {
    mode: String,
    repetitions: u64,
    fresh: usize,
    reference: String,
}

fn arguments() -> Arguments {
    let mut parsed = Arguments {
        mode: "table".to_owned(),
        repetitions: 3,
        fresh: 400,
        reference: "target/worst_arrival.jsonl".to_owned(),
    };
    let mut given = std::env::args().skip(1);
    while let Some(argument) = given.next() {
        let mut next = || given.next().expect("a value after the option");
        match argument.as_str() {
            "--bench" => {}
            "--repetitions" => parsed.repetitions = next().parse().expect("a number"),
            "--fresh" => parsed.fresh = next().parse().expect("a number"),
            "--reference" => parsed.reference = next(),
            mode => parsed.mode = mode.to_owned(),
        }
    }
    parsed
}

fn main() {
    let arguments = arguments();
    let encounters = Encounters::load();
    match arguments.mode.as_str() {
        "table" => table(&encounters, &arguments),
        "curves" => curves(&encounters, arguments.fresh),
        "serve" => serve(&encounters),
        other => panic!("there is no mode `{other}`; there are table, curves and serve"),
    }
}
