//! Gates that are judged while runs come in.

use super::*;
use proptest::prelude::*;

fn sequential(rules: Vec<GateRule>) -> Gate {
    Gate {
        name: "gate".into(),
        doc: None,
        baseline: "base.json".into(),
        sequential: true,
        rules,
        origin: Default::default(),
    }
}

/// A flag in every run of these trials, by trial and run.
fn flags(trials: &[Trial], flag: impl Fn(usize, usize) -> bool) -> Baseline {
    baseline(&["collision"], trials, |_, trial, run| Some(f64::from(flag(trial, run))))
}

fn collisions(primary: bool, tolerance: f64) -> Vec<GateRule> {
    vec![GateRule { primary, ..named("collision", Tolerance::Relative(tolerance)) }]
}

fn paired(gate: &Gate, base: &Baseline, candidate: &Baseline) -> GateVerdict {
    judge_gate(gate, base, candidate, false).unwrap()
}

/// Of other seeds, so that nothing is new.
fn reseeded(all: Baseline) -> Baseline {
    Baseline { seed: 2, ..all }
}

#[test]
fn one_looks_ever_more_seldom_and_before_the_end() {
    let all = flags(&[trial("a/x=1", 20), trial("a/x=2", 20)], |_, _| false);
    let looks: Vec<usize> = LookRounds::of(&all).looks().collect();
    assert_eq!(looks, [1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 15, 18]);
    let one = flags(&[trial("a", 1)], |_, _| false);
    assert_eq!((LookRounds::of(&one).len(), LookRounds::of(&one).looks().count()), (1, 0));
}

#[test]
fn what_got_worse_beyond_doubt_ends_it() {
    let trials = || [trial("a/x=1", 100), trial("a/x=2", 100)];
    let base = flags(&trials(), |_, run| run % 10 == 0);
    let worse = reseeded(flags(&trials(), |_, run| run % 10 < 9));
    let gate = sequential(collisions(false, 0.0));
    let verdict = paired(&gate, &base, &worse);
    assert_eq!(verdict.verdict, Verdict::Failed);
    let looks = verdict.looks.unwrap();
    assert_eq!(looks.ended_it_of, Some(200));
    assert!(verdict.runs < 60, "{}", verdict.runs);
    let [check] = &verdict.checks[..] else { panic!("{verdict:?}") };
    assert_eq!((check.outcome, check.runs), (CheckOutcome::Regressed, verdict.runs));
    assert!(check.adjusted_p_value.unwrap() <= check.level());
    // One that is not sequential sees the same at the end.
    let patient = paired(&Gate { sequential: false, ..gate.clone() }, &base, &worse);
    assert_eq!((patient.verdict, patient.runs, patient.looks), (Verdict::Failed, 200, None), "{patient:?}");
    // What got better, or did not change, is compared to the end.
    for same in [&base, &flags(&trials(), |_, _| false)] {
        let verdict = paired(&gate, &base, same);
        assert_ne!(verdict.verdict, Verdict::Failed);
        assert_eq!((verdict.runs, verdict.looks.unwrap().ended_it_of), (200, None));
    }
}

/// A new collision needs no statistics, and is found at the first look at which it is there.
#[test]
fn a_new_collision_ends_it_at_once() {
    let trials = || [trial("a/x=1", 50), trial("a/x=2", 50)];
    let base = flags(&trials(), |_, _| false);
    let hit = flags(&trials(), |trial, run| (trial, run) == (1, 2));
    let verdict = paired(&sequential(five_percent()), &base, &hit);
    assert_eq!((verdict.verdict, verdict.runs), (Verdict::Failed, 6));
    assert_eq!(verdict.checks[0].worse_runs.len(), 1);
    assert_eq!(verdict.looks, Some(Looks { made: 3, ended_it_of: Some(100) }));
}

/// By default none may be new where the baseline has none at all, wherever among its runs it has one.
#[test]
fn where_the_baseline_has_a_collision_later_none_is_new() {
    let trials = || [trial("a", 50)];
    let base = flags(&trials(), |_, run| run == 49);
    let hit = flags(&trials(), |_, run| run == 0);
    let verdict = paired(&sequential(five_percent()), &base, &hit);
    assert!(verdict.checks.iter().all(|check| check.subject != ComparedSubject::New), "{verdict:?}");
    assert_eq!(verdict.runs, 50);
}

/// Which trials got worse and which better is told at the end, however sure each of them is.
#[test]
fn trials_that_cancel_end_nothing() {
    let trials = || [trial("a/x=1", 200), trial("a/x=2", 200)];
    let base = flags(&trials(), |trial, _| trial == 0);
    let moved = reseeded(flags(&trials(), |trial, _| trial == 1));
    let verdict = paired(&sequential(collisions(true, 0.0)), &base, &moved);
    assert_eq!(verdict.looks.unwrap().ended_it_of, None);
    assert_eq!(verdict.runs, 400);
}

/// Where one trial has more runs than another no round has one of each.
#[test]
fn trials_of_other_sizes_are_compared_at_the_end() {
    let trials = || [trial("a/x=1", 100), trial("a/x=2", 20)];
    let base = flags(&trials(), |_, _| false);
    let hit = reseeded(flags(&trials(), |trial, _| trial == 1));
    let verdict = paired(&sequential(collisions(true, 0.0)), &base, &hit);
    assert_eq!((verdict.verdict, verdict.runs), (Verdict::Failed, 120));
}

/// Of several people whoever has walked all of his runs is one unit.
#[test]
fn people_are_looked_at_one_after_the_other() {
    let people = |repetitions: usize| {
        let runs =
            (1..=40).flat_map(|one| (1..=repetitions).map(move |rep| format!("individual={one}/rep={rep}")));
        [Trial { key: "a", certain: false, runs: runs.collect(), people: "forty" }]
    };
    let base = flags(&people(5), |_, _| false);
    let hit = reseeded(flags(&people(5), |_, run| run % 5 < 4));
    let verdict = paired(&sequential(collisions(true, 0.0)), &base, &hit);
    let [check] = &verdict.checks[..] else { panic!("{verdict:?}") };
    assert_eq!(check.runs, 5 * check.units);
    assert!(verdict.runs < 200 && check.units >= 8, "{verdict:?}");
    // A hundred runs of two people are two units.
    let base = flags(
        &[Trial { runs: people(100)[0].runs[..200].to_vec(), ..people(1).into_iter().next().unwrap() }],
        |_, _| false,
    );
    let hit = reseeded(Baseline {
        trials: vec![RecordedTrial { values: vec![vec![Some(1.0); 200]], ..base.trials[0].clone() }],
        ..base.clone()
    });
    assert_ne!(paired(&sequential(collisions(true, 0.0)), &base, &hit).verdict, Verdict::Failed);
}

/// What is spent along the way is not there at the end.
#[test]
fn nine_tenths_of_the_error_are_left_for_the_end() {
    let trials = || [trial("a", 60)];
    let base = flags(&trials(), |_, run| run % 3 == 0);
    let other = reseeded(flags(&trials(), |_, run| run % 3 == 0 || run % 12 == 1));
    let gate = sequential(collisions(false, 0.0));
    let (looked, patient) =
        (paired(&gate, &base, &other), paired(&Gate { sequential: false, ..gate.clone() }, &base, &other));
    let adjusted = |verdict: &GateVerdict| verdict.checks[0].adjusted_p_value.unwrap();
    assert!((adjusted(&looked) * (1.0 - ALONG_THE_WAY) - adjusted(&patient)).abs() < 1e-12);
    assert_eq!(looked.checks[0].p_value, patient.checks[0].p_value);
}

/// 2.5 % are stated, of which a tenth is spent along the way.
#[test]
fn without_a_change_few_gates_fail_along_the_way() {
    let trials = || [trial("a/x=1", 40), trial("a/x=2", 40), trial("b", 80)];
    let gate = sequential(collisions(false, 0.0));
    const PAIRS: u64 = 1000;
    let fails = |pair: &u64| {
        let mut stream = Stream::seeded(*pair);
        let mut draw = || {
            let lots: Vec<Vec<bool>> =
                (0..3).map(|_| (0..80).map(|_| stream.uniform() < 0.3).collect()).collect();
            flags(&trials(), |trial, run| lots[trial][run])
        };
        let (base, candidate) = (draw(), reseeded(draw()));
        let mut looks = LookRounds::of(&candidate).looks();
        looks.any(|after| look_at(&gate, &base, &candidate, false, after).unwrap().is_some())
    };
    // Three standard errors beyond 0.25 % of 1,000.
    let failed = (0..PAIRS).filter(fails).count();
    assert!(failed <= 7, "{failed}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// What comes later changes nothing of what was seen, nor does it matter whether it is there.
    #[test]
    fn a_look_sees_only_what_was_made(
        base in proptest::collection::vec(any::<bool>(), 60),
        candidate in proptest::collection::vec(any::<bool>(), 60),
        later in proptest::collection::vec(proptest::option::of(any::<bool>()), 60),
        after in 1_usize..30,
        same_seeds: bool,
    ) {
        let trials = || [trial("a/x=1", 30), trial("a/x=2", 30)];
        let base = flags(&trials(), |trial, run| base[30 * trial + run]);
        let seeded = |all: Baseline| if same_seeds { all } else { reseeded(all) };
        let whole = seeded(flags(&trials(), |trial, run| candidate[30 * trial + run]));
        let so_far = seeded(baseline(&["collision"], &trials(), |_, trial, run| {
            if run < after { Some(f64::from(candidate[30 * trial + run])) } else { later[30 * trial + run].map(f64::from) }
        }));
        for primary in [true, false] {
            let gate = sequential(collisions(primary, 0.02));
            let seen = |all: &Baseline| look_at(&gate, &base, all, false, after).unwrap();
            prop_assert_eq!(seen(&whole), seen(&so_far));
            // And what a look says is what the gate comes to if it is the first that does.
            let mut looks = LookRounds::of(&whole).looks();
            let first = looks.find_map(|after| look_at(&gate, &base, &whole, false, after).unwrap());
            if let Some(first) = first {
                let verdict = paired(&gate, &base, &whole);
                prop_assert!(verdict.looks.unwrap().ended_it_of.is_some());
                prop_assert_eq!(first.checks, verdict.checks);
                prop_assert_eq!(first.runs, verdict.runs);
            }
        }
    }
}
