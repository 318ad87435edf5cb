//! What our surrogate does beyond `friedrich` by itself: how well each knows a function, what that is worth to a search, and its cost.
//!
//!     cargo bench --bench surrogate -- [--seeds 20] [problem …]
//!
//! All see the same noisy evaluations, standardised alike. In the search they share everything but the model: 15 Sobol points,
//! then expected improvement on the smallest observed value over 1000 Sobol points a step, 60 evaluations; the answer is the
//! evaluated point of lowest posterior mean.

#[path = "optimisation/cpu.rs"]
mod cpu;
#[path = "optimisation/medians.rs"]
mod medians;
#[path = "optimisation/problems.rs"]
#[expect(dead_code, reason = "margins are not modelled here")]
mod problems;

use std::panic::{AssertUnwindSafe, catch_unwind};

use friedrich::gaussian_process::{GaussianProcess, GaussianProcessBuilder};
use friedrich::kernel::{Kernel, Matern2, SquaredExp};
use friedrich::prior::{ConstantPrior, Prior};
use numbers::design::sobol_point;
use numbers::distributions::normal_tail::log_improvement;
use numbers::random::Stream;
use numbers::summary::{mean, std};
use optimise::surrogate::{
    Dataset, FriedrichSurrogate, Noise, Outliers, Posterior, Standardisation, Surrogate,
};
use rayon::prelude::*;

use cpu::thread_cpu_s;
use medians::{median_interval, quantile};
use problems::{PROBLEMS, Problem};

const INITIAL: usize = 15;
const EVALUATIONS: usize = 60;
const CANDIDATES: usize = 1000;
/// Where a model is asked what it knows.
const TESTS: usize = 1000;

type Believe = Box<dyn Fn(&[Vec<f64>]) -> Vec<Posterior>>;

/// A way to make a model of standardised values at points of the unit cube; `None` where it fails.
struct Contender {
    name: &'static str,
    fit: fn(&[Vec<f64>], &[f64]) -> Option<Believe>,
}

const CONTENDERS: [Contender; 3] = [
    Contender { name: "friedrich, as it comes", fit: as_it_comes },
    Contender { name: "friedrich, Matérn 5/2", fit: with_matern },
    Contender { name: "ours", fit: ours },
];

/// Squared-exponential kernel, fitted noise and constant prior: what `GaussianProcess::default` makes.
fn as_it_comes(points: &[Vec<f64>], values: &[f64]) -> Option<Believe> {
    by_friedrich(points, values, |builder| builder.set_kernel(SquaredExp::default()))
}

fn with_matern(points: &[Vec<f64>], values: &[f64]) -> Option<Believe> {
    by_friedrich(points, values, |builder| builder.set_kernel(Matern2::default()))
}

fn by_friedrich<K: Kernel + 'static, P: Prior + 'static>(
    points: &[Vec<f64>],
    values: &[f64],
    choose: impl FnOnce(GaussianProcessBuilder<SquaredExp, ConstantPrior>) -> GaussianProcessBuilder<K, P>,
) -> Option<Believe> {
    let builder = GaussianProcess::builder(points.to_vec(), values.to_vec());
    // The pivot that its documentation advises where rounding would make it panic.
    let builder = choose(builder).set_cholesky_epsilon(Some(1e-8)).fit_kernel().fit_prior();
    let process = catch_unwind(AssertUnwindSafe(|| builder.train())).ok()?;
    Some(Box::new(move |points| {
        let (means, variances) = process.predict_mean_variance(&points.to_vec());
        let both = means.into_iter().zip(variances);
        both.map(|(mean, variance)| Posterior { mean, variance: variance.max(0.0) }).collect()
    }))
}

fn ours(points: &[Vec<f64>], values: &[f64]) -> Option<Believe> {
    let data = Dataset {
        points: points.to_vec(),
        values: values.to_vec(),
        noise: vec![Noise { shared: 1.0, known: 0.0 }; values.len()],
        categorical: vec![false; points[0].len()],
    };
    let surrogate = FriedrichSurrogate::fit(data, None, 0..0).ok()?;
    Some(Box::new(move |points| surrogate.scan(points)))
}

/// A problem with its noise for one seed.
struct Trial<'a> {
    problem: &'a Problem,
    seed: u64,
}

impl Trial<'_> {
    /// Points of a Sobol sequence of its own, one for each `purpose`.
    fn points(&self, count: usize, purpose: u32) -> Vec<Vec<f64>> {
        let scramble = (self.seed as u32).wrapping_mul(1000).wrapping_add(purpose);
        (0..count).map(|index| sobol_point(index, self.problem.bounds.len(), scramble)).collect()
    }

    fn place(&self, unit: &[f64]) -> Vec<f64> {
        self.problem.bounds.iter().zip(unit).map(|((low, high), unit)| low + (high - low) * unit).collect()
    }

    fn truth(&self, unit: &[f64]) -> f64 {
        (self.problem.truth)(&self.place(unit)).0
    }

    fn evaluated(&self, unit: &[f64], number: usize) -> f64 {
        let noise = (self.problem.objective_noise)(&self.place(unit));
        self.truth(unit) + noise * Stream::numbered(self.seed, number as u64).normal()
    }

    /// Root mean square error in standard deviations of the function, and the mean logarithm of the density of the truth, from
    /// evaluations at Sobol points. With CPU seconds of the fit and of the predictions.
    fn knowledge(&self, contender: &Contender) -> Option<[f64; 4]> {
        let points = self.points(EVALUATIONS, 1);
        let values: Vec<f64> =
            points.iter().enumerate().map(|(number, point)| self.evaluated(point, number)).collect();
        let map = Standardisation::of(&values, Outliers::Keep);
        let scaled: Vec<f64> = values.iter().map(|value| map.apply(*value)).collect();
        let start = thread_cpu_s();
        let believe = (contender.fit)(&points, &scaled)?;
        let fitted = thread_cpu_s();
        let tests = self.points(TESTS, 2);
        let beliefs = believe(&tests);
        let predicted = thread_cpu_s();
        let truths: Vec<f64> = tests.iter().map(|point| self.truth(point)).collect();
        let errors: Vec<f64> = beliefs.iter().zip(&truths).map(|(b, t)| map.undo(b.mean) - t).collect();
        let squares: Vec<f64> = errors.iter().map(|error| error * error).collect();
        let densities: Vec<f64> = beliefs
            .iter()
            .zip(&errors)
            .map(|(belief, error)| {
                // No belief is surer than a thousandth of what was seen.
                let deviation = map.scale * belief.deviation().max(1e-3);
                let z = error / deviation;
                -0.5 * z * z - (deviation / map.scale).ln() - 0.5 * (2.0 * std::f64::consts::PI).ln()
            })
            .collect();
        let error = mean(&squares)?.sqrt() / std(&truths)?;
        Some([error, mean(&densities)?, 1e3 * (fitted - start), 1e3 * (predicted - fitted)])
    }

    /// True regret of the answer, CPU seconds, and how many fits failed.
    fn search(&self, contender: &Contender) -> (f64, f64, usize) {
        let mut points = self.points(INITIAL, 1);
        let mut values: Vec<f64> =
            points.iter().enumerate().map(|(number, point)| self.evaluated(point, number)).collect();
        let (start, mut failures) = (thread_cpu_s(), 0);
        let believe = |points: &[Vec<f64>], values: &[f64]| {
            let map = Standardisation::of(values, Outliers::Keep);
            let scaled: Vec<f64> = values.iter().map(|value| map.apply(*value)).collect();
            let lowest = scaled.iter().copied().fold(f64::INFINITY, f64::min);
            ((contender.fit)(points, &scaled), lowest)
        };
        while points.len() < EVALUATIONS {
            let mut candidates = self.points(CANDIDATES, 10 + points.len() as u32);
            candidates.retain(|candidate| !points.contains(candidate));
            let (model, lowest) = believe(&points, &values);
            failures += usize::from(model.is_none());
            let chosen = model.map_or(0, |believe| {
                let gains = believe(&candidates).into_iter().map(|belief| {
                    let deviation = belief.deviation().max(1e-9);
                    deviation.ln() + log_improvement((lowest - belief.mean) / deviation)
                });
                gains
                    .enumerate()
                    .filter(|(_, gain)| !gain.is_nan())
                    .max_by(|a, b| a.1.total_cmp(&b.1))
                    .map_or(0, |b| b.0)
            });
            let point = candidates[chosen].clone();
            values.push(self.evaluated(&point, points.len()));
            points.push(point);
        }
        let answer = believe(&points, &values).0.and_then(|believe| {
            let beliefs = believe(&points);
            (0..points.len()).min_by(|a, b| beliefs[*a].mean.total_cmp(&beliefs[*b].mean))
        });
        // Without a model the smallest value that was seen.
        let answer = answer.or_else(|| (0..values.len()).min_by(|a, b| values[*a].total_cmp(&values[*b])));
        let regret = self.truth(&points[answer.expect("there are points")]) - self.problem.optimum;
        (regret, thread_cpu_s() - start, failures)
    }
}

/// The system counts CPU time in ticks: right on average, not one by one.
fn average(values: &[f64]) -> f64 {
    mean(values).unwrap_or(f64::NAN)
}

/// How long 1000 beliefs take by friedrich and by our own solver, from the same hyper-parameters.
fn cost_of_beliefs() {
    println!("\n| evaluations | 1000 beliefs by friedrich | by our solver |");
    println!("|---|---|---|");
    let branin = PROBLEMS.iter().find(|problem| problem.name == "branin").expect("it exists");
    let trial = Trial { problem: branin, seed: 0 };
    for count in [60, 100, 200] {
        let points = trial.points(count, 1);
        let values: Vec<f64> =
            points.iter().enumerate().map(|(number, point)| trial.evaluated(point, number)).collect();
        let map = Standardisation::of(&values, Outliers::Keep);
        let data = Dataset {
            values: values.iter().map(|value| map.apply(*value)).collect(),
            noise: vec![Noise { shared: 1.0, known: 0.0 }; count],
            categorical: vec![false; 2],
            points,
        };
        let surrogate = FriedrichSurrogate::fit(data, None, 0..0).expect("the data are sound");
        let candidates = trial.points(CANDIDATES, 2);
        // friedrich's process is made at the first question.
        surrogate.posterior(&candidates[..1]);
        let timed = |believe: &dyn Fn() -> Vec<Posterior>| {
            let start = thread_cpu_s();
            (0..100).for_each(|_| drop(std::hint::black_box(believe())));
            10.0 * (thread_cpu_s() - start)
        };
        let (theirs, own) =
            (timed(&|| surrogate.posterior(&candidates)), timed(&|| surrogate.scan(&candidates)));
        println!("| {count} | {theirs:.2} ms | {own:.2} ms |");
    }
}

fn main() {
    let (mut seeds, mut names) = (20_u64, Vec::new());
    let mut given = std::env::args().skip(1);
    while let Some(argument) = given.next() {
        match argument.as_str() {
            "--bench" => {}
            "--seeds" => {
                seeds = given.next().and_then(|text| text.parse().ok()).expect("a number after --seeds")
            }
            name => names.push(name.to_owned()),
        }
    }
    // What panics is counted, not told.
    std::panic::set_hook(Box::new(|_| {}));
    println!(
        "| problem | model | error (of the function's deviation) | mean log density of the truth | fit | 1000 beliefs | regret of a search | its CPU | failed fits |"
    );
    println!("|---|---|--:|--:|--:|--:|--:|--:|--:|");
    let chosen = |problem: &&Problem| {
        problem.constraints == 0 && (names.is_empty() || names.iter().any(|name| name == problem.name))
    };
    for problem in PROBLEMS.iter().filter(chosen) {
        for contender in &CONTENDERS {
            let trials = (0..seeds).into_par_iter().map(|seed| Trial { problem, seed });
            let both = trials.map(|trial| (trial.knowledge(contender), trial.search(contender)));
            let (known, searched): (Vec<_>, Vec<_>) = both.unzip();
            let column = |index: usize| -> Vec<f64> {
                known.iter().flatten().map(|row: &[f64; 4]| row[index]).collect()
            };
            let failures = known.iter().filter(|row| row.is_none()).count()
                + searched.iter().map(|(_, _, failures)| failures).sum::<usize>();
            println!(
                "| {} | {} | {:.3} | {:+.2} | {:.1} ms | {:.1} ms | {} | {:.2} s | {failures} |",
                problem.name,
                contender.name,
                quantile(&column(0), 0.5),
                quantile(&column(1), 0.5),
                average(&column(2)),
                average(&column(3)),
                median_interval(&searched.iter().map(|(regret, _, _)| *regret).collect::<Vec<_>>()),
                average(&searched.iter().map(|(_, cpu, _)| *cpu).collect::<Vec<_>>()),
            );
        }
    }
    cost_of_beliefs();
}
