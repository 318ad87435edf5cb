//! Rules about shares of runs, and comparisons that are adjusted for each other.

use super::*;
use numbers::inference::holm;
use scenario::{GateRate, Relation, WhenUndefined};

fn rate(metric: &str, relation: Relation, bound: f64, bad: bool, tolerance: f64) -> GateRule {
    let text = format!("rate({metric})");
    let when_undefined = WhenUndefined::AsDeclared;
    let rate = GateRate { relation, bound, when_undefined, bad, text };
    GateRule { rate: Some(rate), ..named(metric, Tolerance::Relative(tolerance)) }
}

fn of_pet(tolerance: f64) -> GateRule {
    rate("pet", Relation::Less, 1.5, true, tolerance)
}

#[test]
fn a_rate_gets_worse_towards_the_side_of_its_metric() {
    let trials = [trial("walk/tta=6s", 200)];
    // Short in 10 and in 40 of 200; the mean does not change.
    let short = |many: usize| {
        baseline(&["pet"], &trials, move |_, _, run| {
            Some(if run < many { 1.0 } else { 3.0 + many as f64 * 2.0 / (200 - many) as f64 })
        })
    };
    let verdict = judge(&[of_pet(0.02)], &short(10), &short(40));
    let [check] = &verdict.checks[..] else { panic!("{:?}", verdict.checks) };
    assert_eq!((check.outcome, check.subject), (CheckOutcome::Regressed, ComparedSubject::Rate));
    assert_eq!((check.label.as_str(), check.base, check.candidate), ("rate(pet)", 0.05, 0.2));
    assert_eq!((check.worse_runs.len(), check.worse_runs[0].candidate), (30, Some(1.0)));
    assert_eq!(judge(&[of_pet(0.02)], &short(40), &short(10)).verdict, Verdict::Passed);
    // Twenty points are tolerated.
    assert_eq!(judge(&[of_pet(0.2)], &short(10), &short(40)).verdict, Verdict::Passed);
    // The other side of the same bound.
    let long = rate("pet", Relation::GreaterOrEqual, 1.5, false, 0.02);
    assert_eq!(judge(std::slice::from_ref(&long), &short(10), &short(40)).verdict, Verdict::Failed);
    assert_eq!(judge(&[long], &short(40), &short(10)).verdict, Verdict::Passed);
}

/// With other seeds runs get better by chance, too: a share of runs that only get worse says nothing of what would have been seen.
#[test]
fn what_a_rate_would_have_caught_is_not_said_of_other_seeds() {
    let trials = [trial("walk/tta=6s", 200)];
    let short =
        |many: usize| baseline(&["pet"], &trials, move |_, _, run| Some(if run < many { 1.0 } else { 3.0 }));
    let power = |candidate: &Baseline| judge(&[of_pet(0.02)], &short(10), candidate).checks[0].power;
    assert!(matches!(power(&short(12)), Power::Share(_)));
    assert_eq!(power(&Baseline { seed: 77, ..short(12) }), Power::OtherSeeds);
}

#[test]
fn an_outcome_that_does_not_follow_from_its_numbers_is_seen() {
    let trials = [trial("walk/tta=6s", 200)];
    let short =
        |many: usize| baseline(&["pet"], &trials, move |_, _, run| Some(if run < many { 1.0 } else { 3.0 }));
    let verdict = judge(&[of_pet(0.02)], &short(10), &short(40));
    let check = &verdict.checks[0];
    assert_eq!((check.outcome, check.contradicts_itself()), (CheckOutcome::Regressed, false));
    for outcome in [CheckOutcome::Same, CheckOutcome::Held, CheckOutcome::NotShown] {
        assert!(Check { outcome, ..check.clone() }.contradicts_itself(), "{outcome:?}");
    }
    for candidate in [short(10), short(9), short(11)] {
        assert!(!judge(&[of_pet(0.02)], &short(10), &candidate).checks[0].contradicts_itself());
    }
}

/// A mean may hide what its rate shows, and the rule about every metric goes on comparing it.
#[test]
fn a_rate_leaves_its_metric_to_the_rule_about_all() {
    let trials = [trial("walk/tta=6s", 40)];
    let base = baseline(&["pet"], &trials, |_, _, run| Some(around(run, 1)));
    let worse = baseline(&["pet"], &trials, |_, _, run| Some(around(run, 1) - 1.0));
    let rules = [five_percent().remove(0), rate("pet", Relation::Less, 0.1, true, 0.0)];
    let verdict = judge(&rules, &base, &worse);
    assert_eq!(outcome(&verdict, "pet", ComparedSubject::Mean).outcome, CheckOutcome::Regressed);
    assert_eq!(verdict.checks.len(), 2);
}

#[test]
fn runs_without_the_metric_count_as_it_says_or_not_at_all() {
    let trials = [trial("walk/tta=6s", 100)];
    let with = |metric: &'static str, many: usize, value: f64| {
        baseline(&[metric], &trials, move |_, _, run| (run < many).then_some(value))
    };
    // Danger that never arose: better than any value, so not above the bound.
    let hard = || rate("drac", Relation::Greater, 3.0, true, 0.0);
    let verdict = judge(&[hard()], &with("drac", 0, 5.0), &with("drac", 30, 5.0));
    let [check] = &verdict.checks[..] else { panic!("{:?}", verdict.checks) };
    assert_eq!((check.base, check.candidate, check.runs), (0.0, 0.3, 100));
    assert_eq!(verdict.verdict, Verdict::Failed);
    assert_eq!(judge(&[hard()], &with("drac", 0, 2.0), &with("drac", 30, 2.0)).verdict, Verdict::Passed);
    // Who never arrived lost more than any time.
    let late = || rate("time_lost", Relation::Greater, 5.0, true, 0.0);
    let verdict = judge(&[late()], &with("time_lost", 100, 1.0), &with("time_lost", 60, 1.0));
    assert_eq!((verdict.verdict, verdict.checks[0].candidate), (Verdict::Failed, 0.4));
    // Of who came so near nobody can say: pairs of two values are compared, and what lost its value never holds.
    let verdict = judge(&[of_pet(0.5)], &with("pet", 100, 3.0), &with("pet", 60, 3.0));
    assert_eq!(outcome(&verdict, "rate(pet)", ComparedSubject::Rate).runs, 60);
    assert_eq!(outcome(&verdict, "pet", ComparedSubject::Existence).outcome, CheckOutcome::NotShown);
    // Unless the rule says what they are.
    let mut said = of_pet(0.0);
    said.rate.as_mut().unwrap().when_undefined = WhenUndefined::Passes;
    let verdict = judge(&[said], &with("pet", 100, 3.0), &with("pet", 60, 3.0));
    assert_eq!((verdict.verdict, verdict.checks.len()), (Verdict::Failed, 1));
    // Nothing at all on either side is nothing compared, where nobody can say, and said.
    let verdict = judge(&[of_pet(0.0)], &with("pet", 0, 3.0), &with("pet", 0, 3.0));
    assert_eq!((verdict.checks.len(), &verdict.without_values[..]), (0, &["pet".to_string()][..]));
    assert_eq!(verdict.blind_rules.len(), 1);
}

const ALIKE: [&str; 6] = ["drac", "time_lost", "min_ttc", "pet", "impact_speed", "max_jerk"];

/// Six metrics that are nearly the same number; nothing may get worse.
fn alike(change: impl Fn(usize) -> f64) -> GateVerdict {
    let trials = [trial("walk/tta=6s", 30)];
    let values = |shift: bool| {
        let change = &change;
        baseline(&ALIKE, &trials, move |metric, _, run| {
            let larger_is_worse = !matches!(metric, "pet" | "min_ttc");
            let sign = if larger_is_worse { 1.0 } else { -1.0 };
            Some(10.0 + around(run, 7) + if shift { sign * change(run) } else { 0.0 })
        })
    };
    judge(&[blanket_rule(0.0, 0.95)], &values(false), &values(true))
}

#[test]
fn what_changes_together_shares_less_of_the_error() {
    // A change of which one comparison is sure at 1 %, and six are not by Holm's correction.
    let verdict = alike(|run| 0.45 + Stream::seeded(run as u64 + 500).normal());
    let raw: Vec<f64> = verdict.checks.iter().filter_map(|check| check.p_value).collect();
    let adjusted: Vec<f64> = verdict.checks.iter().filter_map(|check| check.adjusted_p_value).collect();
    assert_eq!(raw.len(), 6);
    for ((raw, adjusted), by_holm) in raw.iter().zip(&adjusted).zip(holm(&raw)) {
        assert!(adjusted >= raw && *adjusted < 0.5 * by_holm, "{raw} {adjusted} {by_holm}");
    }
}

/// The same pairs that change by chance only, in all metrics alike: as seldom as stated.
#[test]
fn metrics_that_depend_on_each_other_raise_no_more_false_alarms_than_stated() {
    let alarms = (0..200_u64).filter(|experiment| {
        let change = |run: usize| Stream::seeded(experiment * 1000 + run as u64).normal();
        alike(change).verdict == Verdict::Failed
    });
    // 5 are stated, three standard errors are 6.6; and not all of them are left unused.
    let alarms = alarms.count();
    assert!((1..=11).contains(&alarms), "{alarms}");
}

/// Changed runs that are all worse are a regression from some number of them on, however many they are, alone and beside others that are
/// adjusted with them.
#[test]
fn the_more_runs_got_worse_the_surer_it_is() {
    let trials = [trial("walk/tta=6s", 200)];
    let metrics = ["collision", "pet", "min_distance"];
    let hit = |many: usize, seed: u64| Baseline {
        seed,
        ..baseline(&metrics, &trials, move |metric, _, run| {
            Some(if metric == "collision" { f64::from(run < many) } else { around(run, 3) })
        })
    };
    let alone = vec![named("collision", Tolerance::Relative(0.0))];
    let primary = vec![GateRule { primary: true, ..alone[0].clone() }, blanket_rule(0.0, 0.95)];
    let beside = vec![alone[0].clone(), blanket_rule(0.0, 0.95)];
    for rules in [alone, primary, beside] {
        let adjusted = |many: usize| {
            let verdict = judge(&rules, &hit(0, 1), &hit(many, 2));
            let check = outcome(&verdict, "collision", ComparedSubject::Rate);
            assert_eq!(check.outcome == CheckOutcome::Regressed, verdict.verdict == Verdict::Failed);
            check.adjusted_p_value.unwrap()
        };
        let all: Vec<f64> = [4, 8, 12, 24, 80, 200].map(adjusted).to_vec();
        assert!(all.windows(2).all(|two| two[1] <= two[0].max(0.001)), "{all:?}");
        assert!(all[2..].iter().all(|p| *p <= 0.025), "{all:?}");
    }
}
