//! Optimisers side by side, one of which fails.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::super::rounds::{EvaluateRound, Optimisation, optimise};
use super::*;
use crate::plan::plan_scenario;
use crate::run::Shuffled;
use optimise::{Definition, Evaluation, Method, Proposal, SearchDimension, Space};
use results::Outcome;
use scenario::Case;

/// Proposals of the optimisation with the first index fail from its round of the second one on.
struct Failing<'c> {
    case: &'c Case,
    fails: &'c [(usize, usize)],
    asked: Vec<AtomicUsize>,
}

impl EvaluateRound for Failing<'_> {
    fn cases(&self, optimisation: usize, _: &Proposal) -> Result<Vec<Case>, ExperimentError> {
        let round = self.asked[optimisation].fetch_add(1, Ordering::Relaxed);
        let fails = self.fails.iter().any(|(index, first)| *index == optimisation && round >= *first);
        if fails {
            Err(ExperimentError::NotRun(format!("{optimisation} in round {round}")))
        } else {
            Ok(vec![self.case.clone()])
        }
    }

    fn evaluation(&self, _: &[Case], _: &[Outcome], _: bool) -> Evaluation {
        Evaluation::of(1.0)
    }

    fn evaluated(&self, _: &Evaluation) {}
}

/// What comes of four optimisers with six evaluations each, and how many proposals of each were planned.
fn outcome(fails: &[(usize, usize)], executor: &dyn crate::run::Executor) -> (String, Vec<usize>) {
    let suite = suite();
    let case = plan_scenario(&suite, &suite.scenarios[0]).unwrap().trial(0).cases.first();
    let context = Context::new(&suite, executor, &standard());
    let space = Space::new(vec![SearchDimension::real("x", 0.0, 1.0)]).unwrap();
    let mut all: Vec<Optimisation> = (0..4)
        .map(|seed| {
            let definition =
                Definition { budget: 6, method: Method::Random, ..Definition::new(space.clone(), seed) };
            Optimisation::begin(&context, "rounds", &seed, definition, 1).unwrap()
        })
        .collect();
    let asked = (0..4).map(|_| AtomicUsize::new(0)).collect();
    let failing = Failing { case: &case, fails, asked };
    let said =
        optimise(&context, &mut all, &failing).map_or_else(|error| error.to_string(), |()| "done".into());
    (said, failing.asked.iter().map(|asked| asked.load(Ordering::Relaxed)).collect())
}

/// Whichever half is there sooner: the same error as where all of them go round by round.
#[test]
fn the_error_of_the_earliest_round_is_told() {
    for (fails, first) in [
        (&[(0, 4), (3, 1)][..], "`3 in round 1` has not been run"),
        (&[(0, 1), (3, 4)], "`0 in round 1` has not been run"),
        (&[(0, 2), (3, 2)], "`0 in round 2` has not been run"),
        (&[(2, 2), (3, 2)], "`2 in round 2` has not been run"),
        (&[], "done"),
    ] {
        for seed in 0..3 {
            for executor in [&Shuffled::seeded(seed) as &dyn crate::run::Executor, threads()] {
                let (said, asked) = outcome(fails, executor);
                assert!(said.starts_with(first), "{fails:?}: {said}");
                assert!(!fails.is_empty() || asked == [6; 4], "{asked:?}");
            }
        }
    }
}
