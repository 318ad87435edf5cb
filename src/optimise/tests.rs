//! What a user of the optimiser relies on: the same bits again, no panic on any history, and sensible answers.

use std::fs;

use proptest::prelude::*;

use super::*;

fn line() -> Space {
    Space::new(vec![SearchDimension::real("x", 6.0, 18.0)]).unwrap()
}

fn mixed() -> Space {
    Space::new(vec![
        SearchDimension::real("time", 0.0, 1.0),
        SearchDimension::log("gain", 1e-2, 1e2),
        SearchDimension::integer("count", 0, 5),
        SearchDimension::categorical("kind", ["a", "b", "c"]),
    ])
    .unwrap()
}

/// A bumpy function with a repeatable error that looks like noise.
fn bumpy(point: &[Coordinate]) -> Evaluation {
    let x = point[0].number().unwrap();
    Evaluation::of((x - 11.0).powi(2) / 10.0 + (3.0 * x).sin() + 0.1 * (1e4 * x).sin())
}

fn finished(definition: &Definition, batch: usize) -> Optimiser {
    let mut optimiser = Optimiser::new(definition.clone()).unwrap();
    run(&mut optimiser, batch, None, |proposal| bumpy(&proposal.point)).unwrap();
    optimiser
}

fn text(optimiser: &Optimiser) -> String {
    serde_json::to_string(optimiser).unwrap()
}

fn methods() -> [Method; 6] {
    let penalised = Method::GpMinimizeLike { penalty: 1000.0 };
    [Method::Bayesian, penalised, Method::Random, Method::LatinHypercube, Method::Sobol, Method::Grid]
}

#[test]
fn every_method_repeats_to_the_bit_and_survives_a_round_trip_at_any_moment() {
    for method in methods() {
        let definition = Definition { method, budget: 24, initial: 6, ..Definition::new(line(), 5) };
        let expected = text(&finished(&definition, 3));
        let mut optimiser = Optimiser::new(definition).unwrap();
        while optimiser.stop_reason().is_none() {
            let mut proposals = optimiser.ask(3);
            // Told in another order, and through a round trip with proposals pending.
            proposals.reverse();
            for proposal in proposals {
                optimiser = serde_json::from_str(&text(&optimiser)).unwrap();
                optimiser.tell(proposal.id, bumpy(&proposal.point)).unwrap();
            }
        }
        assert_eq!(text(&optimiser), expected, "{method:?}");
    }
}

#[test]
fn another_seed_proposes_other_points() {
    let points = |seed| {
        let optimiser = finished(&Definition { budget: 16, initial: 15, ..Definition::new(line(), seed) }, 1);
        optimiser.trials().iter().map(|trial| trial.point.clone()).collect::<Vec<_>>()
    };
    let (a, b) = (points(1), points(2));
    assert!(a.iter().zip(&b).all(|(a, b)| a != b));
}

#[test]
fn the_number_of_workers_changes_nothing() {
    let definition = Definition { budget: 25, ..Definition::new(line(), 5) };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        text(&pool.install(|| finished(&definition, 5)))
    };
    assert_eq!(with(1), with(4));
}

#[test]
fn a_run_killed_anywhere_resumes_from_its_journal_and_ends_the_same() {
    let definition = Definition { budget: 22, initial: 10, ..Definition::new(line(), 9) };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.jsonl");
    let evaluate = |proposal: &Proposal| match proposal.id % 7 {
        3 => Evaluation::of(f64::NAN),
        _ => bumpy(&proposal.point),
    };
    let complete = || {
        let mut journal = Journal::open(&path, &definition, 4).unwrap();
        let mut optimiser = Optimiser::new(definition.clone()).unwrap();
        run(&mut optimiser, 4, Some(&mut journal), evaluate).unwrap();
        (text(&optimiser), journal.len())
    };
    let (expected, evaluations) = complete();
    assert_eq!(evaluations, 22);
    let bytes = fs::read(&path).unwrap();
    for cut in [0, 10, bytes.len() / 3, bytes.len() / 2, bytes.len() - 1, bytes.len()] {
        fs::write(&path, &bytes[..cut]).unwrap();
        assert_eq!(complete().0, expected, "cut at {cut} of {}", bytes.len());
        assert_eq!(Journal::open(&path, &definition, 4).unwrap().len(), 22);
    }
}

#[test]
fn a_journal_of_another_run_or_a_damaged_one_is_refused_and_left_alone() {
    let definition = Definition { budget: 5, initial: 5, ..Definition::new(line(), 9) };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.jsonl");
    let mut journal = Journal::open(&path, &definition, 1).unwrap();
    let mut optimiser = Optimiser::new(definition.clone()).unwrap();
    run(&mut optimiser, 1, Some(&mut journal), |proposal| bumpy(&proposal.point)).unwrap();
    let good = fs::read_to_string(&path).unwrap();

    let open =
        |definition: &Definition, batch| Journal::open(&path, definition, batch).unwrap_err().to_string();
    assert!(open(&definition, 1).contains("in use by another process"));
    drop(journal);
    assert!(open(&Definition { seed: 10, ..definition.clone() }, 1).contains("`definition` is another one"));
    assert!(open(&definition, 2).contains("`batch` is another one"));
    fs::write(&path, good.replacen("\"id\":2", "\"id\":1", 1)).unwrap();
    assert!(open(&definition, 1).contains("line 4: its checksum is wrong"));
    fs::write(&path, "someone's only copy of a poem").unwrap();
    assert!(open(&definition, 1).contains("is no scenario-runner journal"));
    assert_eq!(fs::read_to_string(&path).unwrap(), "someone's only copy of a poem");

    // A point that is not the one proposed.
    fs::write(&path, OLD_JOURNAL.replace("\"point\":[1", "\"point\":[9")).unwrap();
    let mut journal = Journal::open(&path, &definition, 1).unwrap();
    let mut optimiser = Optimiser::new(definition.clone()).unwrap();
    let error = run(&mut optimiser, 1, Some(&mut journal), |proposal| bumpy(&proposal.point)).unwrap_err();
    assert!(error.to_string().contains("another point"), "{error}");
}

#[test]
fn no_corruption_of_a_journal_gives_another_result() {
    let definition = Definition { budget: 22, initial: 10, ..Definition::new(line(), 9) };
    let expected = text(&finished(&definition, 4));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.jsonl");
    let resumed = || -> Result<String, Error> {
        let mut journal = Journal::open(&path, &definition, 4)?;
        let mut optimiser = Optimiser::new(definition.clone())?;
        run(&mut optimiser, 4, Some(&mut journal), |proposal| bumpy(&proposal.point))?;
        Ok(text(&optimiser))
    };
    assert_eq!(resumed().unwrap(), expected);
    let good = fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> = good.split_inclusive('\n').collect();
    let (mut refused, mut went_on) = (0, 0);
    for number in 0..68 {
        // Spread over the file, its header and its end among them.
        let (place, line) = ((number / 4) * (good.len() - 1) / 16, (number / 4) * (lines.len() - 1) / 16);
        let mut changed = lines.clone();
        let corrupted = match number % 4 {
            0 => {
                let mut bytes = good.clone().into_bytes();
                bytes[place] ^= 1;
                bytes
            }
            1 => good.as_bytes()[..place].to_vec(),
            2 => {
                changed.insert(line, lines[line]);
                changed.concat().into_bytes()
            }
            _ => {
                changed.swap(line, (line + 1) % lines.len());
                changed.concat().into_bytes()
            }
        };
        fs::write(&path, corrupted).unwrap();
        match resumed() {
            Ok(result) => {
                went_on += 1;
                assert_eq!(result, expected, "corruption {number}");
            }
            Err(_) => refused += 1,
        }
    }
    assert!(refused >= 30 && went_on >= 17, "{refused} were refused, {went_on} went on");
}

/// As version 0.1 left it when it was killed: five evaluations, the last one not whole.
const OLD_JOURNAL: &str = include_str!("../../tests/formats/search_0.1.jsonl");

#[test]
fn a_journal_of_version_0_1_is_taken_over_with_a_notice() {
    let definition = Definition { budget: 5, initial: 5, ..Definition::new(line(), 9) };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.jsonl");
    fs::write(&path, OLD_JOURNAL).unwrap();
    assert!(Journal::open(&path, &definition, 2).unwrap_err().to_string().contains("another one"));
    let mut journal = Journal::open(&path, &definition, 1).unwrap();
    assert!(journal.notice().unwrap().contains("version 0.1"), "{:?}", journal.notice());
    assert_eq!(journal.len(), 4);
    let mut optimiser = Optimiser::new(definition.clone()).unwrap();
    run(&mut optimiser, 1, Some(&mut journal), |proposal| bumpy(&proposal.point)).unwrap();
    drop(journal);
    assert_eq!(text(&optimiser), text(&finished(&definition, 1)));
    let journal = Journal::open(&path, &definition, 1).unwrap();
    assert_eq!((journal.len(), journal.notice()), (5, None));
}

#[test]
fn stop_rules_are_reported() {
    let spent = finished(&Definition { budget: 20, ..Definition::new(line(), 1) }, 4);
    assert_eq!(spent.stop_reason(), Some(OptimisationEnd::Budget { evaluations: 20 }));
    let stop = ImprovementStop { below: 1e-3, patience: 3 };
    let definition = Definition { budget: 60, improvement_stop: Some(stop), ..Definition::new(line(), 1) };
    let mut flat = Optimiser::new(definition).unwrap();
    run(&mut flat, 1, None, |_| Evaluation::of(2.5)).unwrap();
    assert!(
        matches!(flat.stop_reason(), Some(OptimisationEnd::NoExpectedImprovement { largest }) if largest < 1e-3)
    );
    assert!(flat.trials().len() < 60 && flat.clone().ask(1).is_empty());

    let space =
        Space::new(vec![SearchDimension::integer("n", 1, 3), SearchDimension::categorical("k", ["a", "b"])])
            .unwrap();
    let definition = Definition { method: Method::Grid, ..Definition::new(space, 1) };
    let mut grid = Optimiser::new(definition).unwrap();
    run(&mut grid, 4, None, |proposal| Evaluation::of(proposal.point[0].number().unwrap())).unwrap();
    assert_eq!(grid.stop_reason(), Some(OptimisationEnd::GridComplete { points: 6 }));

    let mut pending =
        Optimiser::new(Definition { budget: 1, initial: 1, ..Definition::new(line(), 1) }).unwrap();
    assert_eq!(pending.ask(5).len(), 1);
    assert_eq!(pending.stop_reason(), None);
}

#[test]
fn senseless_definitions_and_tells_are_errors() {
    let good = Definition::new(line(), 0);
    let grid_of_1024 = (0..10).map(|i| SearchDimension::real(&i.to_string(), 0.0, 1.0)).collect();
    for bad in [
        Definition { objectives: vec![], ..good.clone() },
        Definition { budget: 0, ..good.clone() },
        Definition { initial: 0, ..good.clone() },
        Definition { feasibility: 1.0, ..good.clone() },
        Definition { method: Method::GpMinimizeLike { penalty: f64::NAN }, ..good.clone() },
        Definition { improvement_stop: Some(ImprovementStop { below: 0.0, patience: 1 }), ..good.clone() },
        Definition {
            improvement_stop: Some(ImprovementStop { below: 0.1, patience: 1 }),
            objectives: vec![Goal::Minimise, Goal::Minimise],
            ..good.clone()
        },
        Definition { method: Method::Grid, ..Definition::new(Space::new(grid_of_1024).unwrap(), 0) },
    ] {
        assert!(matches!(Optimiser::new(bad), Err(Error::Definition(_))));
    }
    let mut optimiser = Optimiser::new(good).unwrap();
    let proposal = optimiser.ask(1).remove(0);
    assert!(matches!(optimiser.tell(7, Evaluation::of(1.0)), Err(Error::Unasked(7))));
    assert!(matches!(optimiser.tell(0, Evaluation::constrained(1.0, &[1.0])), Err(Error::Evaluation(_))));
    optimiser.tell(proposal.id, Evaluation::of(1.0)).unwrap();
    assert!(matches!(optimiser.tell(0, Evaluation::of(1.0)), Err(Error::Unasked(0))));
    assert!(matches!(
        optimiser.observe(&[Coordinate::Real(5.0)], Evaluation::of(1.0)),
        Err(Error::Value { .. })
    ));
}

#[test]
fn finds_the_best_of_a_mixed_space_and_maximises_when_told_to() {
    let definition =
        Definition { objectives: vec![Goal::Maximise], budget: 50, ..Definition::new(mixed(), 3) };
    let mut optimiser = Optimiser::new(definition).unwrap();
    let height = |point: &[Coordinate]| {
        let [time, gain, count] = [0, 1, 2].map(|i| point[i].number().unwrap());
        let kind = if point[3] == Coordinate::Category("b".into()) { 1.0 } else { 0.0 };
        kind - (time - 0.3).powi(2) - 0.2 * (gain.log10() - 1.0).powi(2) - 0.03 * (count - 4.0).powi(2)
    };
    run(&mut optimiser, 5, None, |proposal| Evaluation::of(height(&proposal.point))).unwrap();
    let best = optimiser.best_predicted().unwrap().unwrap();
    assert!(height(&best.point) > 0.9, "{best:?}");
    assert!((best.mean - height(&best.point)).abs() < 0.1, "{best:?}");
    let slice = optimiser.surrogate_slice(2, &best.point, 100).unwrap();
    assert_eq!(slice.len(), 6);
    let top = slice.iter().max_by(|a, b| a.mean.total_cmp(&b.mean)).unwrap();
    assert_eq!(top.value, Coordinate::Integer(4));
    assert!(slice.iter().all(|point| point.lower <= point.mean && point.mean <= point.upper));
}

#[test]
fn a_constraint_is_learnt_from_abandoned_candidates() {
    // Minimise x where x ≥ 10 is needed; a violating candidate is abandoned with a part of its violation and no objective.
    let definition = Definition { constraints: 1, budget: 35, ..Definition::new(line(), 4) };
    let mut optimiser = Optimiser::new(definition).unwrap();
    run(&mut optimiser, 1, None, |proposal| {
        let x = proposal.point[0].number().unwrap();
        let margin = x - 10.0;
        let mut evaluation = Evaluation::constrained(x, &[margin]);
        if margin < 0.0 {
            evaluation.objectives[0].value = None;
            evaluation.margins[0] = Margin { censored: true, ..Margin::of(Some(0.3 * margin)) };
        }
        evaluation
    })
    .unwrap();
    for point in
        [optimiser.best_predicted().unwrap().unwrap().point, optimiser.best_observed().unwrap().point.clone()]
    {
        let x = point[0].number().unwrap();
        assert!((10.0..10.2).contains(&x), "{x}");
    }
}

/// Minimises x where the noisy margin x − 10 is to stay positive: the optimum is on the constraint.
fn on_the_edge(seed: u64, batch: usize) -> Optimiser {
    let definition = Definition { constraints: 1, budget: 40, ..Definition::new(line(), seed) };
    let mut optimiser = Optimiser::new(definition).unwrap();
    run(&mut optimiser, batch, None, |proposal| {
        let x = proposal.point[0].number().unwrap();
        // Errors of ±0.3 that repeat for a proposal but not for a place.
        let error = |turns: f64| 0.3 * (turns * (proposal.id + 17 * seed) as f64).sin();
        Evaluation::constrained(x + error(2.4), &[x - 10.0 + error(1.7)])
    })
    .unwrap();
    optimiser
}

#[test]
fn an_answer_on_a_constraint_keeps_it() {
    for seed in 0..8 {
        let best = on_the_edge(seed, 1).best_predicted().unwrap().unwrap();
        let x = best.point[0].number().unwrap();
        assert!((10.0..10.8).contains(&x), "seed {seed}: {x}");
        assert!(best.feasibility >= 0.98);
    }
}

#[test]
fn a_constrained_run_repeats_to_the_bit_on_any_number_of_workers() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        text(&pool.install(|| on_the_edge(3, 4)))
    };
    let state = with(1);
    assert_eq!(state, with(3));
    assert_eq!(text(&serde_json::from_str(&state).unwrap()), state);
}

#[test]
fn nothing_feasible_is_said_and_undefined_regions_are_left() {
    let definition = Definition { constraints: 1, budget: 25, ..Definition::new(line(), 4) };
    let mut hopeless = Optimiser::new(definition).unwrap();
    run(&mut hopeless, 1, None, |_| Evaluation::constrained(1.0, &[-2.0])).unwrap();
    assert!(hopeless.best_observed().is_none());
    assert!(hopeless.best_predicted().unwrap().is_none());
    assert!(hopeless.most_feasible().unwrap().unwrap().feasibility < 0.5);
    assert!(hopeless.pareto_front().is_empty());

    // Undefined below 12: the best is at that edge, or well inside, where the undefined side deserves less than half of the looks.
    for (target, expected, tolerated) in [(6.0, 12.0..12.3, 25), (14.0, 13.9..14.1, 12)] {
        let mut half = Optimiser::new(Definition { budget: 40, ..Definition::new(line(), 4) }).unwrap();
        run(&mut half, 1, None, |proposal| {
            let x = proposal.point[0].number().unwrap();
            Evaluation::of(if x < 12.0 { f64::NAN } else { (x - target).powi(2) })
        })
        .unwrap();
        let best = half.best_predicted().unwrap().unwrap().point[0].number().unwrap();
        assert!(expected.contains(&best), "{best}");
        let undefined = half.trials()[15..].iter().filter(|trial| trial.is_undefined()).count();
        assert!(undefined <= tolerated, "{undefined} of 25 model-based evaluations were undefined");
    }
}

#[test]
fn two_objectives_give_a_front() {
    // Distance to 8 against distance to 14: everything between is optimal.
    let goals = vec![Goal::Minimise, Goal::Minimise];
    let mut optimiser =
        Optimiser::new(Definition { objectives: goals, budget: 40, ..Definition::new(line(), 2) }).unwrap();
    run(&mut optimiser, 1, None, |proposal| {
        let x = proposal.point[0].number().unwrap();
        let measurement =
            |target: f64| ObjectiveValue { value: Some((x - target).abs()), noise_variance: None };
        Evaluation {
            objectives: vec![measurement(8.0), measurement(14.0)],
            margins: vec![],
            repetitions: 1,
            left_out: 0,
        }
    })
    .unwrap();
    let front: Vec<f64> =
        optimiser.pareto_front().iter().map(|trial| trial.point[0].number().unwrap()).collect();
    assert!(front.iter().all(|x| (7.9..14.1).contains(x)), "{front:?}");
    let model_based = optimiser.trials()[15..].iter().map(|trial| trial.point[0].number().unwrap());
    assert!(model_based.filter(|x| (7.9..14.1).contains(x)).count() >= 20, "{front:?}");
    assert!(optimiser.best_observed().is_none() && optimiser.best_predicted().unwrap().is_none());
}

#[test]
fn a_batch_spreads_and_only_one_of_it_hopes_for_improvement() {
    let mut optimiser = Optimiser::new(Definition { budget: 40, ..Definition::new(line(), 6) }).unwrap();
    for proposal in optimiser.ask(15) {
        optimiser.tell(proposal.id, bumpy(&proposal.point)).unwrap();
    }
    let batch = optimiser.ask(9);
    let mut points: Vec<f64> = batch.iter().map(|proposal| proposal.point[0].number().unwrap()).collect();
    points.sort_by(f64::total_cmp);
    assert!(points.windows(2).filter(|pair| pair[1] - pair[0] > 0.05).count() >= 4, "{points:?}");
    assert!(batch.iter().all(|proposal| matches!(proposal.origin, ProposalOrigin::Model(_))));
    let improves =
        |proposal: &&Proposal| proposal.origin == ProposalOrigin::Model(Acquisition::ExpectedImprovement);
    assert_eq!(batch.iter().filter(improves).count(), 1);
    // The two take turns as soon as it is told.
    for proposal in batch {
        optimiser.tell(proposal.id, bumpy(&proposal.point)).unwrap();
    }
    let mut turns = Vec::new();
    for _ in 0..4 {
        let proposal = optimiser.ask(1).remove(0);
        optimiser.tell(proposal.id, bumpy(&proposal.point)).unwrap();
        turns.push(improves(&&proposal));
    }
    assert_eq!(turns.iter().filter(|improves| **improves).count(), 2, "{turns:?}");
    assert!(turns.windows(2).all(|pair| pair[0] != pair[1]), "{turns:?}");
}

/// Numbers an evaluation may bring.
fn anything() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -2.0..2.0f64,
        1 => Just(0.0),
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, 1e6, -1e6, 1e-300, 1e149, -1e300, 5.0]),
    ]
}

fn told() -> impl Strategy<Value = (usize, f64, f64, bool, u32)> {
    (0usize..5, anything(), anything(), any::<bool>(), 1u32..4)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]
    #[test]
    fn no_history_makes_it_panic(
        told in prop::collection::vec(told(), 1..14),
        method in prop::sample::select(vec![Method::Bayesian, Method::GpMinimizeLike { penalty: 1e6 }]),
        flat in any::<bool>(),
        two in any::<bool>(),
    ) {
        let space = if two { line() } else { mixed() };
        // Few places, so that duplicates are common.
        let places: Vec<Point> = [0.0, 0.3, 0.300_000_1, 0.7, 1.0]
            .iter()
            .map(|&unit| space.point(&vec![unit; space.dimensions().len()]))
            .collect();
        let definition = Definition { constraints: 1, method, initial: 1, budget: 40, ..Definition::new(space.clone(), 8) };
        let mut optimiser = Optimiser::new(definition).unwrap();
        for (place, value, margin, censored, repetitions) in told {
            let value = if flat { 3.0 } else { value };
            let mut evaluation = Evaluation { repetitions, ..Evaluation::constrained(value, &[margin]) };
            evaluation.margins[0].censored = censored;
            optimiser.observe(&places[place], evaluation).unwrap();
        }
        for proposal in optimiser.ask(3) {
            prop_assert!(space.unit(&proposal.point).is_ok());
        }
        let predicted = optimiser.predictions().unwrap();
        prop_assert!(predicted.iter().all(|p| p.mean.is_finite() && p.deviation >= 0.0 && p.feasibility <= 1.0));
        optimiser.best_observed();
        optimiser.best_predicted().unwrap();
        optimiser.surrogate_slice(0, &places[1], 5).unwrap();
        let state = text(&optimiser);
        prop_assert_eq!(&serde_json::from_str::<Optimiser>(&state).unwrap(), &optimiser);
    }
}
