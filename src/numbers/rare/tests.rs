//! Methods held against probabilities that are known in closed form. `cargo bench --bench rare` does the same at length.

use super::*;
use crate::distributions::normal;
use crate::random::derive_seed;

/// A problem without a simulator: how far a point is from the event, which happens at 0 and below.
struct Problem {
    name: &'static str,
    dimensions: usize,
    probability: f64,
    score: fn(&[f64]) -> f64,
    /// Whether the pilot is not shown that there is an event.
    hidden: fn(&[f64]) -> bool,
}

fn tail(beta: f64) -> f64 {
    normal::cumulative(-beta)
}

fn space(dimensions: usize) -> RareSpace {
    RareSpace::new(vec![RareAxis::Continuous; dimensions])
}

/// Tells a method what becomes of its runs, the second argument being whether they are a pilot's; how many there were.
fn told(method: &mut dyn RareSampling, mut outcome: impl FnMut(&RarePoint, bool) -> RareOutcome) -> usize {
    let mut runs = 0;
    while let Some(round) = method.ask() {
        runs += round.points.len();
        let outcomes: Vec<_> = round.points.iter().map(|one| outcome(one, round.is_pilot)).collect();
        method.tell(&outcomes);
    }
    runs
}

fn run(method: &mut dyn RareSampling, problem: &Problem, space: &RareSpace) -> usize {
    told(method, |one, is_pilot| {
        let z = space.place(&one.point).z;
        let score = (problem.score)(&z);
        let hidden = is_pilot && (problem.hidden)(&z);
        RareOutcome { event: score <= 0.0 && !hidden, score: if hidden { 9.0 } else { score } }
    })
}

fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let mean = crate::summary::mean(values).unwrap();
    (mean, crate::summary::std(values).unwrap() / (values.len() as f64).sqrt())
}

/// Of runs that are drawn as they are it is as if those that are left out had not been made.
#[test]
fn what_is_left_out_is_no_part_of_what_a_probability_is_of() {
    let space = space(1);
    let estimate = |left_out: &[usize]| {
        let mut method = CrudeSampling::new(space.clone(), 2000, 7);
        told(&mut method, |one, _| RareOutcome { event: one.point[0] < 0.1, score: one.point[0] });
        RareEstimate::of(&space, &leaving_out(method.replicates(), left_out), RareScale::Exact)
    };
    let all = estimate(&[]);
    // The half that is left out has no event in it.
    let without: Vec<usize> = {
        let mut method = CrudeSampling::new(space.clone(), 2000, 7);
        let (mut number, mut found) = (0, Vec::new());
        told(&mut method, |one, _| {
            found.extend((one.point[0] >= 0.5).then_some(number));
            number += 1;
            RareOutcome { event: false, score: 1.0 }
        });
        found
    };
    let kept = estimate(&without);
    assert_eq!(kept.nominal, (2000 - without.len() as u64, all.nominal.1));
    assert!((kept.value - all.nominal.1 as f64 / kept.nominal.0 as f64).abs() < 1e-12, "{}", kept.value);
    let values = (all.value, kept.value);
    assert!((0.07..0.13).contains(&values.0) && (1.9..2.1).contains(&(values.1 / values.0)), "{values:?}");
}

/// The half-space below the median of one direction cannot be: what is beyond `BETA` in that direction is twice as likely among the rest.
#[test]
fn what_is_left_out_of_weighed_runs_leaves_the_probability_of_the_rest() {
    const BETA: f64 = 3.5;
    let (truth, repetitions) = (2.0 * tail(BETA), 40);
    for (by, budget) in [(IMPORTANCE, 4000), (SPLITTING, 90_000)] {
        let (mut values, mut covered, mut kept) = (Vec::new(), 0, 0);
        for repetition in 0..repetitions {
            let space = space(2);
            let mut method = (by.new)(space.clone(), budget, derive_seed(repetition, "left out"));
            let (mut number, mut left_out) = (0, Vec::new());
            told(method.as_mut(), |one, _| {
                let along = space.place(&one.point).z[0];
                left_out.extend((along < 0.0).then_some(number));
                number += 1;
                RareOutcome { event: along >= BETA, score: if along < 0.0 { 9.0 } else { BETA - along } }
            });
            let replicates = leaving_out(method.replicates(), &left_out);
            let estimate = RareEstimate::of(&space, &replicates, RareScale::Logarithmic);
            values.push(estimate.value);
            if estimate.refusals.is_empty() {
                kept += 1;
                covered += u64::from(estimate.interval(0.95).contains(truth));
            }
        }
        let (mean, error) = mean_and_error(&values);
        assert!((mean - truth).abs() < 4.0 * error && error < 0.05 * truth, "{mean} ± {error}, not {truth}");
        assert!(kept >= 30 && covered as f64 >= at_least(0.93, kept) * kept as f64, "{covered} of {kept}");
    }
}

#[derive(Default, Debug)]
struct Counted {
    refused: u64,
    covered: u64,
    guaranteed: u64,
    values: Vec<f64>,
}

struct Method {
    new: fn(RareSpace, usize, u64) -> Box<dyn RareSampling>,
    /// Whether it makes all runs that it may.
    makes_all: bool,
}

const IMPORTANCE: Method = Method {
    new: |space, budget, seed| Box::new(ImportanceSampling::new(space, budget, seed)),
    makes_all: true,
};

const SPLITTING: Method = Method {
    new: |space, budget, seed| Box::new(SplittingSampling::new(space, budget, seed)),
    makes_all: false,
};

fn repeated(by: &Method, problem: &Problem, repetitions: u64, budget: usize) -> Counted {
    let mut counted = Counted::default();
    for repetition in 0..repetitions {
        let space = space(problem.dimensions);
        let mut method = (by.new)(space.clone(), budget, derive_seed(repetition, problem.name));
        let runs = run(method.as_mut(), problem, &space);
        assert!(runs <= method.budget() && method.budget() <= budget, "{runs} runs of {budget}");
        assert!(runs == method.budget() || !by.makes_all, "{runs} runs of {budget}");
        let estimate = RareEstimate::of(&space, method.replicates(), RareScale::Logarithmic);
        assert_eq!(estimate.nominal.0 as usize, method.nominal_runs());
        counted.guaranteed += u64::from(problem.probability <= estimate.guaranteed(0.95));
        counted.values.push(estimate.value);
        if estimate.refusals.is_empty() {
            counted.covered += u64::from(estimate.interval(0.95).contains(problem.probability));
        } else {
            counted.refused += 1;
        }
    }
    counted
}

/// Three standard errors of the check below a share.
fn at_least(share: f64, of: u64) -> f64 {
    share - 3.0 * (share * (1.0 - share) / of as f64).sqrt()
}

/// Of 40 repetitions at most so many are refused, and the error of their mean is less than so much of it.
fn assert_covers(by: &Method, problem: &Problem, budget: usize, (refused, error_of_mean): (u64, f64)) {
    let repetitions = 40;
    let counted = repeated(by, problem, repetitions, budget);
    let kept = repetitions - counted.refused;
    let name = problem.name;
    assert!(counted.refused <= refused, "{name}: {counted:?}");
    assert!(counted.covered as f64 >= at_least(0.93, kept) * kept as f64, "{name}: {counted:?}");
    let guaranteed = counted.guaranteed as f64;
    assert!(guaranteed >= at_least(0.95, repetitions) * repetitions as f64, "{name}: {counted:?}");
    let (mean, error) = mean_and_error(&counted.values);
    assert!((mean - problem.probability).abs() < 4.0 * error, "{name}: {mean} ± {error}");
    assert!(error / mean < error_of_mean, "{name}: it is no better than crude runs: {mean} ± {error}");
}

#[test]
fn known_probabilities_are_covered_without_bias() {
    let nothing = |_: &[f64]| false;
    let problems = [
        Problem {
            name: "linear, 1e-6",
            dimensions: 4,
            probability: tail(4.7534),
            score: |z| 4.7534 - 0.5 * z.iter().sum::<f64>(),
            hidden: nothing,
        },
        Problem {
            name: "two regions on opposite sides",
            dimensions: 2,
            probability: tail(4.0) + tail(4.3),
            score: |z| (4.0 - z[0]).min(4.3 + z[0]),
            hidden: nothing,
        },
    ];
    for problem in problems {
        assert_covers(&IMPORTANCE, &problem, 4000, (4, 0.02));
    }
}

/// The wrong green that matters most: a region that nothing led to.
#[test]
fn a_region_that_the_pilot_did_not_see_is_found_or_refused() {
    let problem = Problem {
        name: "a corner that nothing leads to",
        dimensions: 3,
        probability: {
            let (one, other) = (tail(3.5), tail(2.3) * tail(2.3));
            one + other - one * other
        },
        score: |z| if z[1] > 2.3 && z[2] > 2.3 { 0.0 } else { 3.5 - z[0] },
        hidden: |z| z[1] > 2.3 && z[2] > 2.3,
    };
    assert!(tail(2.3) * tail(2.3) < tail(3.5), "it is the rarer of the two");
    let repetitions = 30;
    let counted = repeated(&IMPORTANCE, &problem, repetitions, 20_000);
    let right = (counted.covered + counted.refused) as f64;
    assert!(right >= at_least(0.93, repetitions) * repetitions as f64, "{counted:?}");
}

#[test]
fn nothing_but_nominal_runs_decides_the_guarantee() {
    let space = space(2);
    let problem = Problem {
        name: "everywhere",
        dimensions: 2,
        probability: 0.3,
        score: |z| -0.5244 - z[0],
        hidden: |_| false,
    };
    let mut method = ImportanceSampling::new(space.clone(), 4000, 3);
    run(&mut method, &problem, &space);
    let estimate = RareEstimate::of(&space, method.replicates(), RareScale::Logarithmic);
    let (runs, hits) = estimate.nominal;
    assert_eq!((runs, method.nominal_runs()), (300, 300), "a tenth of what the pilot leaves");
    assert_eq!(estimate.guaranteed(0.95), crate::inference::upper_bound(hits, runs, 0.95));
    assert!((estimate.unseen(0.95) - 3.0 / 300.0).abs() < 1e-4);
    let mut others = method.replicates().to_vec();
    others.iter_mut().for_each(|one| one.probability *= 1e-3);
    let other = RareEstimate::of(&space, &others, RareScale::Logarithmic);
    assert_eq!(other.guaranteed(0.95), estimate.guaranteed(0.95));
    assert!(
        other.refusals.iter().any(|one| matches!(one, RareRefusal::Contradicted(_))),
        "nominal runs see a thousand times more: {:?}",
        other.refusals
    );
}

#[test]
fn nothing_found_is_refused_and_bounded_by_nominal_runs_alone() {
    let space = space(2);
    let never = Problem {
        name: "never",
        dimensions: 2,
        probability: 0.0,
        score: |_| f64::INFINITY,
        hidden: |_| false,
    };
    let mut method = ImportanceSampling::new(space.clone(), 2000, 3);
    run(&mut method, &never, &space);
    let estimate = RareEstimate::of(&space, method.replicates(), RareScale::Logarithmic);
    assert_eq!(estimate.refusals, [RareRefusal::NoHits]);
    assert_eq!((estimate.value, estimate.upper(0.95)), (0.0, 1.0), "no hit is no proof");
    assert_eq!(method.plateau(), 1.0, "all runs are equally far");
}

#[test]
fn weights_are_finite_however_far_out_a_point_is() {
    let space = RareSpace::new(vec![RareAxis::Continuous, RareAxis::Categories(vec![1e-12, 0.0, 1.0])]);
    let (nominal, wide) = (proposal::Component::nominal(&space), proposal::Component::wide(&space));
    for z in [-37.0, -8.3, 0.0, 8.3, 37.0] {
        for category in [0, 2] {
            let place = space::RarePlace { z: vec![z], categories: vec![category] };
            let log = proposal::log_mixture([(0.1, &nominal), (0.9, &wide)].into_iter(), &place);
            assert!(log.is_finite() && -log <= libm::log(10.0) + 1e-9, "{z}: {log}");
            let point = space.point(&place);
            assert!(point.iter().all(|share| *share > 0.0 && *share < 1.0), "{point:?}");
            assert_eq!(space.place(&point).categories, [category]);
        }
    }
}

/// Of 40 people three are hit when they come late, and one group of rows is a hundredth of all.
#[test]
fn categories_are_found_and_weighed() {
    let weights = vec![0.5, 0.49, 0.01];
    let space = RareSpace::new(vec![
        RareAxis::Categories(vec![1.0; 40]),
        RareAxis::Continuous,
        RareAxis::Categories(weights),
    ]);
    let truth = tail(2.5) * 0.01 * 3.0 / 40.0;
    let mut values = Vec::new();
    for seed in 0..20 {
        let mut method = ImportanceSampling::new(space.clone(), 8000, seed);
        told(&mut method, |one, _| {
            let place = space.place(&one.point);
            let wrong = f64::from(u8::from(place.categories[0] >= 3));
            let row = f64::from(u8::from(place.categories[1] != 2));
            let score = (2.5 - place.z[0]).max(0.0) + wrong + row;
            RareOutcome { event: score <= 0.0, score }
        });
        values.push(RareEstimate::of(&space, method.replicates(), RareScale::Logarithmic).value);
    }
    let (mean, error) = mean_and_error(&values);
    assert!((mean - truth).abs() < 4.0 * error, "{mean} ± {error}, and it is {truth}");
    assert!(error < 0.1 * truth, "{mean} ± {error}");
}

#[test]
fn crude_runs_have_the_exact_interval() {
    let space = space(1);
    let problem = Problem {
        name: "crude",
        dimensions: 1,
        probability: 0.01,
        score: |z| 2.3263 - z[0],
        hidden: |_| false,
    };
    let mut method = CrudeSampling::new(space.clone(), 10_001, 5);
    assert_eq!(run(&mut method, &problem, &space), 10_001);
    let estimate = RareEstimate::of(&space, method.replicates(), RareScale::Exact);
    let (runs, hits) = estimate.nominal;
    assert_eq!(runs, 10_001);
    assert_eq!(estimate.interval(0.95), crate::inference::clopper_pearson(hits, runs, 0.95));
    assert!(estimate.refusals.is_empty());
    assert!(estimate.interval(0.999).contains(0.01), "{estimate:?}");
}

/// Where importance sampling fails: in many directions at once, and where only the runs themselves say where it goes on.
#[test]
fn splitting_is_unbiased_and_covers() {
    let nothing = |_: &[f64]| false;
    let problems = [
        Problem {
            name: "linear, 1e-4, of ten",
            dimensions: 10,
            probability: tail(3.719),
            score: |z| 3.719 - z.iter().sum::<f64>() / 10.0_f64.sqrt(),
            hidden: nothing,
        },
        Problem {
            name: "two regions on opposite sides",
            dimensions: 2,
            probability: tail(3.5) + tail(3.8),
            score: |z| (3.5 - z[0]).min(3.8 + z[0]),
            hidden: nothing,
        },
        Problem {
            name: "steps, of which the first holds nine tenths of all runs",
            dimensions: 3,
            probability: tail(3.5),
            score: |z| ((3.5 - z[0]) * 4.0).ceil().clamp(0.0, 9.0),
            hidden: nothing,
        },
    ];
    for problem in problems {
        assert_covers(&SPLITTING, &problem, 90_000, (10, 0.05));
    }
}

/// Few runs that all come from a few say little, however many have the event in the end.
#[test]
fn hits_of_one_lineage_are_no_many_hits() {
    let space = space(2);
    let hit = |run: usize, lineage: usize| WeighedHit {
        run,
        lineage,
        chance: run,
        point: vec![0.5, 0.5],
        weight: 1e-4,
        place: space.place(&[0.5, 0.5]),
    };
    let replicates: Vec<ReplicateRuns> = (0..REPLICATES)
        .map(|replicate| ReplicateRuns {
            probability: if replicate < 3 { 50.0 * 1e-4 / 1000.0 } else { 0.0 },
            runs: 1000,
            first: 0,
            nominal_runs: 200,
            nominal_hits: Vec::new(),
            hits: if replicate < 3 { (0..50).map(|run| hit(run, 7)).collect() } else { Vec::new() },
            surplus: 0.0,
        })
        .collect();
    let estimate = RareEstimate::of(&space, &replicates, RareScale::Logarithmic);
    assert_eq!(estimate.hits, 150);
    assert!(estimate.effective_size < 4.0, "{estimate:?}");
    assert!((estimate.largest_share - 1.0 / 3.0).abs() < 1e-9, "{estimate:?}");
    let of = |wanted: fn(&RareRefusal) -> bool| estimate.refusals.iter().any(wanted);
    assert!(
        of(|one| matches!(one, RareRefusal::FewHits(_))) && of(|one| matches!(one, RareRefusal::OneRun(_)))
    );
    assert!(of(|one| matches!(one, RareRefusal::Spread(_))));
}

#[test]
fn what_is_not_rare_takes_no_levels_and_what_never_happens_is_refused() {
    let space = space(2);
    let often = Problem {
        name: "often",
        dimensions: 2,
        probability: 0.7,
        score: |z| -0.5244 - z[0],
        hidden: |_| false,
    };
    let mut method = SplittingSampling::new(space.clone(), 4000, 3);
    let runs = run(&mut method, &often, &space);
    let estimate = RareEstimate::of(&space, method.replicates(), RareScale::Logarithmic);
    assert_eq!((estimate.nominal.0, runs), (3000, 3000 + 4000 / 48), "one batch of the pilot was enough");
    assert!(estimate.refusals.is_empty() && estimate.interval(0.999).contains(0.7), "{estimate:?}");
    let never = Problem { name: "never", probability: 0.0, score: |_| f64::INFINITY, ..often };
    let mut method = SplittingSampling::new(space.clone(), 4000, 3);
    run(&mut method, &never, &space);
    let estimate = RareEstimate::of(&space, method.replicates(), RareScale::Logarithmic);
    assert_eq!(estimate.refusals, [RareRefusal::NoHits]);
    assert_eq!((estimate.upper(0.95), method.plateau()), (1.0, 1.0), "no hit is no proof");
}

/// Rare noise rather than rare points: nothing that is drawn leads to the event, and chance that is moved does.
#[test]
fn splitting_goes_on_from_chance_too() {
    let space = space(1);
    let mut values = Vec::new();
    for seed in 0..20 {
        let mut method = SplittingSampling::new(space.clone(), 20_000, seed);
        told(&mut method, |one, _| {
            let noise = crate::random::Stream::numbered(seed, one.chance as u64).normal();
            let score = 4.0 - (space.place(&one.point).z[0] + noise) / 2.0_f64.sqrt();
            RareOutcome { event: score <= 0.0, score }
        });
        values.push(RareEstimate::of(&space, method.replicates(), RareScale::Logarithmic).value);
    }
    let (mean, error) = mean_and_error(&values);
    assert!((mean - tail(4.0)).abs() < 4.0 * error && error < 0.2 * mean, "{mean} ± {error}");
}

/// Whatever the budget and however many levels, no run is asked for that may not be made, and none by the number of another.
#[test]
fn splitting_keeps_to_its_budget() {
    let space = space(2);
    for budget in (FEWEST_RUNS..3000).step_by(67) {
        for beta in [-1.0, 2.0, 5.0, 30.0] {
            for step in [1e-3, 0.2, 100.0] {
                let mut method = SplittingSampling::new(space.clone(), budget, 7);
                let most = method.budget();
                let runs = told(&mut method, |one, _| {
                    assert!(one.chance < most, "{budget}: {}", one.chance);
                    let score = ((beta - space.place(&one.point).z[0]) / step).ceil();
                    RareOutcome { event: score <= 0.0, score }
                });
                assert!(runs <= most && most <= budget, "{runs} of {most} of {budget}");
                let estimate = RareEstimate::of(&space, method.replicates(), RareScale::Logarithmic);
                let least = SplittingSampling::nominal_runs_of(budget);
                assert!(estimate.nominal.0 as usize >= least && least > 0, "{:?}", estimate.nominal);
                assert!((0.0..=1.0).contains(&estimate.value), "{estimate:?}");
                let weights = method.replicates().iter().map(|one| {
                    let sum: f64 = one.hits.iter().map(|hit| hit.weight).sum();
                    (sum / one.runs as f64 - one.probability).abs()
                });
                assert!(weights.fold(0.0, f64::max) < 1e-9);
            }
        }
    }
}
