//! Gates over made-up baselines: what regresses, what holds, what cannot be told.

use std::collections::BTreeMap;

mod looks;
mod rates;

use super::*;
use crate::judge::baseline::{Parts, RecordedMetric, RecordedTrial, WorldPart};
use crate::{CheckOutcome, ComparedSubject};
use numbers::random::Stream;
use scenario::Settings;

/// One trial: key, scenario, whether it is certain, labels of its runs.
struct Trial {
    key: &'static str,
    certain: bool,
    runs: Vec<String>,
    people: &'static str,
}

fn trial(key: &'static str, runs: usize) -> Trial {
    let runs = (1..=runs).map(|run| format!("rep={run}")).collect();
    Trial { key, certain: false, runs, people: "nobody" }
}

/// A suite in which every metric's value is given per trial and run.
fn baseline(
    metrics: &[&str],
    trials: &[Trial],
    value: impl Fn(&str, usize, usize) -> Option<f64>,
) -> Baseline {
    let recorded = |(index, trial): (usize, &Trial)| RecordedTrial {
        key: trial.key.to_string(),
        scenario: trial.key.split('/').next().unwrap().to_string(),
        certain: trial.certain,
        fingerprint: String::new(),
        seeds: None,
        cut_off: 0,
        warnings: Vec::new(),
        parts: Parts {
            road: "road".into(),
            pedestrians: "pedestrians".into(),
            people: trial.people.into(),
            traffic: "traffic".into(),
            simulation: "simulation".into(),
        },
        vehicles: 0,
        runs: trial.runs.clone(),
        values: metrics
            .iter()
            .map(|metric| (0..trial.runs.len()).map(|run| value(metric, index, run)).collect())
            .collect(),
    };
    Baseline {
        suite: "suite".into(),
        apart: String::new(),
        seed: 1,
        set: Vec::new(),
        tool: "0".into(),
        populations: BTreeMap::new(),
        population_versions: BTreeMap::new(),
        programs: BTreeMap::new(),
        what_runs: BTreeMap::new(),
        nondeterministic: BTreeMap::new(),
        metrics: metrics
            .iter()
            .map(|name| RecordedMetric {
                label: name.to_string(),
                name: models::known::metric(name),
                unit: if *name == "collision" { "yes or no".into() } else { "s".into() },
                settings: Settings::default(),
                pair: None,
            })
            .collect(),
        vehicles: vec![Vec::new()],
        trials: trials.iter().enumerate().map(recorded).collect(),
    }
}

fn five_percent() -> Vec<GateRule> {
    vec![blanket_rule(0.05, 0.95)]
}

fn named(metric: &str, tolerance: Tolerance) -> GateRule {
    let metric = models::known::measured(metric);
    GateRule { metric: Some(metric), tolerance, ..blanket_rule(0.0, 0.95) }
}

fn judge(rules: &[GateRule], base: &Baseline, candidate: &Baseline) -> GateVerdict {
    judge_rules("gate", rules, &pair(base, candidate, false).unwrap(), 1.0).unwrap()
}

fn outcome<'a>(verdict: &'a GateVerdict, label: &str, subject: ComparedSubject) -> &'a Check {
    verdict.checks.iter().find(|check| check.label == label && check.subject == subject).unwrap()
}

/// Values around 3 s that differ from run to run.
fn around(run: usize, seed: u64) -> f64 {
    3.0 + 0.5 * Stream::seeded(seed * 1000 + run as u64).normal()
}

/// That few runs came out the same says nothing about the next, if what is tested decides by chance.
#[test]
fn what_is_the_same_by_chance_is_not_passed_by_a_rule_that_sees_nothing() {
    let base = baseline(&["pet"], &[trial("walk/tta=6s", 2)], |_, _, run| Some(1.0 + run as f64));
    let same = judge(&five_percent(), &base, &base);
    assert_eq!((same.verdict, same.blind_rules.len()), (Verdict::Passed, 1));
    let chance = || Baseline { nondeterministic: [("own".into(), "at 1 s".into())].into(), ..base.clone() };
    for (before, after) in [(chance(), base.clone()), (base.clone(), chance())] {
        let by_chance = judge(&five_percent(), &before, &after);
        assert!(by_chance.nothing_changed);
        assert_eq!((by_chance.verdict, by_chance.nondeterministic.len()), (Verdict::Inconclusive, 1));
    }
}

#[test]
fn what_did_not_change_holds() {
    let base = baseline(&["pet", "collision"], &[trial("walk/tta=6s", 40)], |_, _, run| {
        Some(if run == 3 { 0.0 } else { 1.0 })
    });
    let verdict = judge(&five_percent(), &base, &base.clone());
    assert_eq!(verdict.verdict, Verdict::Passed);
    assert!(
        verdict.nothing_changed && verdict.checks.iter().all(|check| check.outcome == CheckOutcome::Same)
    );
    assert_eq!((verdict.family, verdict.blind_rules.len()), (1, 0));
    assert_eq!(verdict.unnamed_flags, ["collision"]);
}

/// A rule on safety need not wait until as many collide as it takes to be told from luck in dozens of other comparisons.
#[test]
fn a_primary_rule_shares_its_error_with_no_other() {
    let names =
        ["collision", "pet", "time_lost", "max_jerk", "rms_jerk", "drac", "max_deceleration", "travel_time"];
    let trials = [trial("walk/tta=6s", 320), trial("run/tta=6s", 320)];
    let suite = |collisions: usize| {
        baseline(&names, &trials, move |metric, trial, run| {
            let collides = trial == 0 && run < collisions;
            Some(if metric == "collision" { f64::from(collides) } else { around(run, 7) })
        })
    };
    // Beside a tolerance, however small, what is new is not asked for by default: it would tell at once.
    let rules = |primary: bool| {
        let collisions = named("collision", Tolerance::Relative(1e-12));
        vec![GateRule { primary, ..collisions }, five_percent().remove(0)]
    };
    let judged = |primary: bool, collisions: usize| judge(&rules(primary), &suite(0), &suite(collisions));
    // Of 16 comparisons it takes 10, of two that share half of the error 8.
    for (collisions, alone, among_all) in
        [(7, false, false), (8, true, false), (9, true, false), (10, true, true)]
    {
        let failed = |primary: bool| judged(primary, collisions).verdict == Verdict::Failed;
        assert_eq!((failed(true), failed(false)), (alone, among_all), "{collisions} collisions");
    }
    let (with, without) = (judged(true, 8), judged(false, 8));
    assert_eq!(((with.family, with.primary), (without.family, without.primary)), ((16, 2), (16, 0)));
    // 2^-8 twice for two comparisons, twice for the two kinds.
    let check = outcome(&with, "collision", ComparedSubject::Rate);
    assert!((check.adjusted_p_value.unwrap() - 4.0 / 256.0).abs() < 1e-4, "{check:?}");
    // Where all rules are primary or none is, nobody shares with anybody else.
    let alone = judge(&rules(true)[..1], &suite(0), &suite(8));
    let plain = judge(&rules(false)[..1], &suite(0), &suite(8));
    let adjusted =
        |verdict: &GateVerdict| outcome(verdict, "collision", ComparedSubject::Rate).adjusted_p_value;
    assert_eq!(adjusted(&alone), adjusted(&plain));
    let powers = |verdict: &GateVerdict| verdict.checks.iter().map(|check| check.power).collect::<Vec<_>>();
    assert_eq!(powers(&alone), powers(&plain));
}

#[test]
fn a_shift_counts_in_the_direction_that_is_worse() {
    let metrics = ["pet", "time_lost"];
    let trials = [trial("walk/tta=6s", 40)];
    // By about as much in every run.
    let shifted = |shift: f64| {
        baseline(&metrics, &trials, move |_, _, run| {
            Some(around(run, 1) + shift * (1.0 + 0.1 * (around(run, 2) - 3.0)))
        })
    };
    let base = shifted(0.0);
    // Half a second less: worse for the post-encroachment time, better for the time lost.
    let verdict = judge(&five_percent(), &base, &shifted(-0.5));
    assert_eq!(verdict.verdict, Verdict::Failed);
    assert_eq!(outcome(&verdict, "pet", ComparedSubject::Mean).outcome, CheckOutcome::Regressed);
    assert_eq!(outcome(&verdict, "time_lost", ComparedSubject::Mean).outcome, CheckOutcome::Held);
    assert_eq!(outcome(&verdict, "pet", ComparedSubject::Mean).worse_runs.len(), 40);
    // 0.1 s is less than 5 % of 3 s.
    let verdict = judge(&five_percent(), &base, &shifted(-0.1));
    assert_eq!(verdict.verdict, Verdict::Passed);
    assert_eq!(outcome(&verdict, "pet", ComparedSubject::Mean).outcome, CheckOutcome::Held);
}

#[test]
fn a_rule_of_its_own_replaces_the_blanket_one() {
    let trials = [trial("walk/tta=6s", 40)];
    let metrics = ["pet", "time_lost", "passed_first"];
    let shifted = |shift: f64| baseline(&metrics, &trials, move |_, _, run| Some(around(run, 1) + shift));
    let rules = [five_percent().remove(0), named("pet", Tolerance::Absolute(0.05))];
    let verdict = judge(&rules, &shifted(0.0), &shifted(-0.1));
    assert_eq!(outcome(&verdict, "pet", ComparedSubject::Mean).outcome, CheckOutcome::Regressed);
    let about: Vec<_> = verdict.checks.iter().map(|check| (check.rule, check.label.as_str())).collect();
    // Who passed first has no order.
    assert_eq!(about, [(0, "time_lost"), (1, "pet")]);
    let missing = judge_rules(
        "gate",
        &[named("drac", Tolerance::Relative(0.05))],
        &pair(&shifted(0.0), &shifted(0.0), false).unwrap(),
        1.0,
    );
    assert_eq!(missing.unwrap_err(), [Incompatible::MetricMissing("drac".into())]);
}

#[test]
fn chance_alone_is_no_regression() {
    let metrics = ["pet", "time_lost", "min_distance", "drac", "collision"];
    let trials = [trial("walk/tta=6s", 25), trial("walk/tta=9s", 25)];
    let mut stream = Stream::seeded(4);
    let mut draw = || {
        let drawn: Vec<f64> = (0..5 * 50).map(|_| stream.uniform()).collect();
        baseline(&metrics, &trials, move |metric, trial, run| {
            let place = metrics.iter().position(|one| *one == metric).unwrap();
            let uniform = drawn[50 * place + 25 * trial + run];
            Some(match metric {
                "collision" => f64::from(uniform < 0.1),
                // Skewed.
                _ => -libm::log(uniform),
            })
        })
    };
    let experiments = 150;
    let rules = [blanket_rule(0.0, 0.95)];
    let alarms =
        (0..experiments).filter(|_| judge(&rules, &draw(), &draw()).verdict == Verdict::Failed).count();
    // One side of 95 % leaves 2.5 %: 3.75, and three standard errors are 5.7 more.
    assert!(alarms <= 9, "{alarms} of {experiments}");
}

#[test]
fn few_runs_are_not_taken_for_a_pass() {
    let trials = [trial("walk/tta=6s", 4)];
    let shifted = |shift: f64| baseline(&["pet"], &trials, move |_, _, run| Some(around(run, 1) + shift));
    let verdict = judge(&five_percent(), &shifted(0.0), &shifted(-2.0));
    assert_eq!(verdict.verdict, Verdict::Inconclusive);
    assert_eq!(verdict.blind_rules, ["no metric worse by more than 5 % with 95 % confidence"]);
    assert_eq!(verdict.checks[0].power, Power::Blind { needed: 6 });
    // Where nothing changed at all there is nothing to be seen.
    assert_eq!(judge(&five_percent(), &shifted(0.0), &shifted(0.0)).verdict, Verdict::Passed);
}

#[test]
fn what_is_certain_needs_no_statistics() {
    let trials = [Trial { certain: true, ..trial("walk/tta=6s", 1) }];
    let shifted = |shift: f64| baseline(&["pet"], &trials, move |_, _, _| Some(3.0 + shift));
    let verdict = judge(&five_percent(), &shifted(0.0), &shifted(-0.16));
    assert_eq!((verdict.verdict, verdict.family), (Verdict::Failed, 0));
    assert_eq!((verdict.checks[0].certain, verdict.checks[0].place.as_str()), (true, "walk/tta=6s"));
    assert_eq!(judge(&five_percent(), &shifted(0.0), &shifted(-0.15)).verdict, Verdict::Passed);
    // A value that is not there any more: nobody can say whether that is worse; but a car that never arrives is.
    let gone = |metric| baseline(&[metric], &trials, |_, _, _| None);
    let there = |metric| baseline(&[metric], &trials, |_, _, _| Some(3.0));
    assert_eq!(judge(&five_percent(), &there("pet"), &gone("pet")).checks[0].outcome, CheckOutcome::NotShown);
    assert_eq!(judge(&five_percent(), &there("time_lost"), &gone("time_lost")).verdict, Verdict::Failed);
    assert_eq!(judge(&five_percent(), &there("drac"), &gone("drac")).verdict, Verdict::Passed);
}

#[test]
fn runs_that_lose_a_value_are_not_dropped() {
    let trials = [trial("walk/tta=6s", 40)];
    let metrics = ["pet", "time_lost", "min_ttc"];
    let losing =
        |lost: usize| baseline(&metrics, &trials, move |_, _, run| (run >= lost).then(|| around(run, 1)));
    let verdict = judge(&five_percent(), &losing(0), &losing(15));
    let existence = |label| outcome(&verdict, label, ComparedSubject::Existence).outcome;
    assert_eq!(existence("pet"), CheckOutcome::NotShown);
    assert_eq!(existence("time_lost"), CheckOutcome::Regressed);
    assert_eq!(existence("min_ttc"), CheckOutcome::Held);
    // The values themselves are compared where there are two.
    assert_eq!(outcome(&verdict, "pet", ComparedSubject::Mean).runs, 25);
    let verdict = judge(&five_percent(), &losing(15), &losing(0));
    assert_eq!(outcome(&verdict, "min_ttc", ComparedSubject::Existence).outcome, CheckOutcome::Regressed);
    assert_eq!(outcome(&verdict, "time_lost", ComparedSubject::Existence).outcome, CheckOutcome::Held);
}

#[test]
fn flags_that_flip_are_named() {
    let trials = [trial("walk/tta=6s", 40)];
    let colliding = |runs: &'static [usize]| {
        baseline(&["collision"], &trials, move |_, _, run| Some(f64::from(runs.contains(&run))))
    };
    let verdict = judge(&[collision_rule(0.95)], &colliding(&[9]), &colliding(&[0, 1, 2, 3, 4, 5, 6, 7]));
    let check = &verdict.checks[0];
    assert_eq!(check.outcome, CheckOutcome::Regressed);
    assert_eq!((check.worse_runs.len(), check.better_runs.len()), (8, 1));
    assert_eq!(check.better_runs[0].key, "suite/walk/tta=6s/rep=10");
    assert_eq!((check.base, check.candidate), (1.0 / 40.0, 8.0 / 40.0));
}

#[test]
fn other_people_are_compared_as_people() {
    let people = |names: [u32; 3], hash| {
        let runs =
            names.iter().flat_map(|name| (1..=10).map(move |rep| format!("individual={name}/rep={rep}")));
        vec![Trial { key: "walk/tta=6s", certain: false, runs: runs.collect(), people: hash }]
    };
    let value = |_: &str, _: usize, run: usize| Some(around(run, 1));
    let base = baseline(&["pet"], &people([1, 2, 3], "one"), value);
    let other = Baseline { seed: 2, ..baseline(&["pet"], &people([4, 5, 6], "two"), value) };
    let verdict = judge(&five_percent(), &base, &other);
    assert!(!verdict.same_people && !verdict.same_seeds);
    assert_eq!((verdict.checks[0].runs, verdict.checks[0].units), (30, 3));
    // Under the same seed it cannot be other people.
    let reasons = pair(&base, &Baseline { seed: 1, ..other }, false).unwrap_err();
    assert_eq!(
        reasons,
        [Incompatible::Part { part: WorldPart::People, trials: vec!["walk/tta=6s".to_string()] }]
    );
}

#[test]
fn what_may_not_be_compared_says_why() {
    let value = |_: &str, _: usize, run: usize| Some(around(run, 1));
    let base = baseline(&["pet"], &[trial("walk/tta=6s", 4), trial("walk/tta=9s", 4)], value);
    let mut candidate = baseline(&["pet"], &[trial("walk/tta=6s", 4), trial("walk/tta=12s", 4)], value);
    candidate.trials[0].parts.road = "another".into();
    candidate.metrics[0].settings.set("zero_on_collision", scenario::Value::Flag(false));
    let keys = |key: &str| vec![key.to_string()];
    assert_eq!(
        pair(&base, &candidate, false).unwrap_err(),
        [
            Incompatible::Vanished(keys("walk/tta=9s")),
            Incompatible::New(keys("walk/tta=12s")),
            Incompatible::MetricDiffers("pet".into()),
            Incompatible::Part { part: WorldPart::Road, trials: keys("walk/tta=6s") },
        ]
    );
    let grown =
        baseline(&["pet"], &[trial("walk/tta=6s", 4), trial("walk/tta=9s", 4), trial("walk/x", 1)], value);
    assert!(pair(&base, &grown, false).is_err());
    assert_eq!(pair(&base, &grown, true).unwrap().new_trials, ["walk/x"]);
    let elsewhere = baseline(&["pet"], &[trial("run/fast", 4)], value);
    assert!(matches!(pair(&base, &elsewhere, true).unwrap_err()[..], [Incompatible::NothingInCommon { .. }]));
}

/// Runs with a collision, by trial; nothing else is measured.
fn colliding(trials: &[Trial], hit: &'static [(usize, usize)]) -> Baseline {
    baseline(&["collision", "pet"], trials, move |metric, trial, run| {
        Some(match metric {
            "collision" => f64::from(hit.contains(&(trial, run))),
            // Something differs in every trial, so that nobody can say that nothing changed.
            _ => 3.0 + if hit.is_empty() { 0.0 } else { 0.001 },
        })
    })
}

#[test]
fn a_scenario_that_is_not_seen_is_not_passed_because_another_is() {
    // Five runs show nothing among two comparisons; forty do.
    let trials = [trial("few/tta=6s", 5), trial("many/tta=6s", 40)];
    let shifted = |few: f64| {
        baseline(&["pet", "time_lost"], &trials, move |_, trial, run| {
            Some(around(run, 1) + if trial == 0 { few } else { 0.001 })
        })
    };
    let verdict = judge(&five_percent(), &shifted(0.0), &shifted(-2.9));
    assert_eq!(verdict.verdict, Verdict::Inconclusive);
    assert!(verdict.blind_rules.is_empty());
    let [place] = &verdict.blind_places[..] else { panic!("{:?}", verdict.blind_places) };
    assert_eq!((place.scenario.as_str(), place.units), ("few", 5));
    assert!(place.needed > 5, "{place:?}");
    // Where nothing changed there is nothing to be seen.
    let same = judge(&five_percent(), &shifted(0.0), &shifted(0.0));
    assert_eq!((same.verdict, same.blind_places.len()), (Verdict::Passed, 0));
}

#[test]
fn a_new_collision_needs_no_statistics() {
    let trials = [trial("few/tta=6s", 5), trial("many/tta=6s", 40)];
    let rules = [five_percent().remove(0), collision_rule(0.95)];
    // One run of forty-five is nothing that statistics could show.
    let verdict = judge(&rules, &colliding(&trials, &[]), &colliding(&trials, &[(1, 7)]));
    assert_eq!(verdict.verdict, Verdict::Failed);
    let new: Vec<_> = verdict.checks.iter().filter(|check| check.subject == ComparedSubject::New).collect();
    let outcomes: Vec<_> = new.iter().map(|check| (check.place.as_str(), check.outcome)).collect();
    assert_eq!(outcomes, [("few", CheckOutcome::Same), ("many", CheckOutcome::Regressed)]);
    assert_eq!(new[1].worse_runs[0].key, "suite/many/tta=6s/rep=8");
    assert_eq!(verdict.rules[new[1].rule], "no new collision, where the baseline has none");
    // One that is not new is none.
    let same = judge(&rules, &colliding(&trials, &[(1, 7)]), &colliding(&trials, &[(1, 7)]));
    assert_eq!(same.verdict, Verdict::Passed);
}

#[test]
fn new_collisions_are_looked_for_by_default_only_where_there_were_none_on_the_same_seeds() {
    let trials = [trial("quiet/tta=6s", 40), trial("wild/tta=6s", 40)];
    let base = || colliding(&trials, &[(1, 3)]);
    let places = |rules: &[GateRule], candidate: &Baseline| -> Vec<String> {
        let verdict = judge(rules, &base(), candidate);
        let new = verdict.checks.iter().filter(|check| check.subject == ComparedSubject::New);
        new.map(|check| check.place.clone()).collect()
    };
    let candidate = || colliding(&trials, &[(1, 4)]);
    assert_eq!(places(&five_percent(), &candidate()), ["quiet"]);
    assert_eq!(places(&[collision_rule(0.95)], &candidate()), ["quiet"]);
    // Who says so wants it everywhere, and another run that collides is new though there are no more.
    let asked = [named("collision", Tolerance::NoneNew { where_none_was: false })];
    assert_eq!(places(&asked, &candidate()), ["quiet", "wild"]);
    assert_eq!(judge(&asked, &base(), &candidate()).verdict, Verdict::Failed);
    // Who tolerates some has said so.
    let tolerant = [named("collision", Tolerance::Absolute(0.02))];
    assert_eq!(places(&tolerant, &candidate()), [""; 0]);
    // Under other seeds no run is the same run.
    let other = Baseline { seed: 2, ..candidate() };
    assert_eq!(places(&five_percent(), &other), [""; 0]);
    let verdict = judge(&asked, &base(), &other);
    assert_eq!((verdict.verdict, verdict.blind_rules.len()), (Verdict::Inconclusive, 1));
}

#[test]
fn five_percent_of_what_is_true_or_false_is_not_five_points() {
    let trials = [trial("walk/tta=6s", 400)];
    // From 10 % to 13.75 % on the same seeds.
    let before = baseline(&["collision"], &trials, |_, _, run| Some(f64::from(run < 40)));
    let now = baseline(&["collision"], &trials, |_, _, run| Some(f64::from(run < 55)));
    let blanket = judge(&five_percent(), &before, &now);
    assert_eq!((blanket.checks.len(), &blanket.unnamed_flags[..]), (0, &["collision".to_string()][..]));
    assert_eq!(blanket.verdict, Verdict::Inconclusive, "a rule that compares nothing has not passed");
    assert_eq!(judge(&[collision_rule(0.95)], &before, &now).verdict, Verdict::Failed);
    // Nor is 5 % of a mean a reason to lose the value in 5 % of the runs.
    let all = baseline(&["time_lost"], &trials, |_, _, run| Some(around(run, 1)));
    let lost = baseline(&["time_lost"], &trials, |_, _, run| (run >= 16).then(|| around(run, 1)));
    let verdict = judge(&five_percent(), &all, &lost);
    assert_eq!(outcome(&verdict, "time_lost", ComparedSubject::Existence).outcome, CheckOutcome::Regressed);
}

#[test]
fn a_trial_that_got_worse_is_named_though_another_hides_it() {
    let trials = [trial("walk/tta=6s", 40), trial("walk/tta=9s", 40)];
    let shifted = |shift: f64| {
        baseline(&["pet"], &trials, move |_, trial, run| {
            Some(around(run, 1) + if trial == 0 { -shift } else { shift })
        })
    };
    let verdict = judge(&five_percent(), &shifted(0.0), &shifted(1.0));
    let check = outcome(&verdict, "pet", ComparedSubject::Mean);
    assert!(check.outcome != CheckOutcome::Regressed && check.worse_by().abs() < 1e-9);
    let worst = check.worst_trial.as_ref().unwrap();
    assert_eq!(worst.key, "walk/tta=6s");
    assert!((worst.worse_by - 1.0).abs() < 1e-9, "{worst:?}");
}

#[test]
fn another_population_is_refused_whatever_the_seed() {
    let value = |_: &str, _: usize, run: usize| Some(around(run, 1));
    let of = |seed, digests: &[(&str, &str)]| Baseline {
        seed,
        populations: digests.iter().map(|(name, digest)| (name.to_string(), digest.to_string())).collect(),
        ..baseline(&["pet"], &[trial("walk/tta=6s", 4)], value)
    };
    let base = of(1, &[("people.csv", "a")]);
    for seed in [1, 2] {
        assert!(pair(&base, &of(seed, &[("people.csv", "a")]), false).is_ok());
        // Its file moved, but the people did not change.
        assert!(pair(&base, &of(seed, &[("folk.csv", "a")]), false).is_ok());
        let changed = pair(&base, &of(seed, &[("people.csv", "b")]), false).unwrap_err();
        assert_eq!(changed, [Incompatible::Populations(vec!["people.csv".to_string()])]);
        assert!(pair(&base, &of(seed, &[("folk.csv", "b")]), false).is_err());
    }
    // Of one that ships it is said which version each is.
    let shipped = |version, digest| Baseline {
        population_versions: BTreeMap::from([("humans".to_string(), version)]),
        ..of(1, &[("humans", digest)])
    };
    let changed = pair(&shipped(1, "a"), &shipped(2, "b"), false).unwrap_err();
    let said = |text: &str| [Incompatible::Populations(vec![text.to_string()])];
    assert_eq!(changed, said("humans (version 1 there, 2 here; `humans_1` is version 1)"));
    // A base of a newer program: that version is not here.
    let changed = pair(&shipped(3, "a"), &shipped(2, "b"), false).unwrap_err();
    assert_eq!(changed, said("humans (version 3 there, 2 here)"));
    // What is in it decides, not what it is called.
    assert!(pair(&shipped(1, "a"), &shipped(2, "a"), false).is_ok());
    // A baseline from before populations were noted: on the same seeds their people are compared one by one.
    let old = of(1, &[]);
    assert!(pair(&old, &of(1, &[("people.csv", "a")]), false).is_ok());
    let reasons = pair(&old, &of(2, &[("people.csv", "a")]), false).unwrap_err();
    assert_eq!(reasons, [Incompatible::PopulationsUnknown]);
}

/// What everybody does is alike, so that only people count: with runs as units, no change at all looks like one too often.
#[test]
fn people_as_units_raise_no_more_false_alarms_than_stated() {
    // Of a difference between two runs a fifth of the variance is the person's, who takes the same to every run.
    const PEOPLE: usize = 10;
    const RUNS: usize = 10;
    let alarms = |experiments: u64, by_people: bool| {
        let runs = |run: usize| match by_people {
            true => format!("individual={}/rep={}", run / RUNS + 1, run % RUNS + 1),
            false => format!("rep={}", run + 1),
        };
        let trials = [Trial {
            key: "walk/tta=6s",
            certain: false,
            runs: (0..PEOPLE * RUNS).map(runs).collect(),
            people: "these",
        }];
        let rules = [blanket_rule(0.0, 0.95)];
        let base = baseline(&["time_lost"], &trials, |_, _, run| Some(around(run, 1)));
        let failed = |experiment: &u64| {
            let mut stream = Stream::seeded(20_261_122 + experiment);
            let people: Vec<f64> = (0..PEOPLE).map(|_| stream.normal()).collect();
            let own: Vec<f64> = (0..PEOPLE * RUNS).map(|_| stream.normal()).collect();
            let change = |run: usize| libm::sqrt(0.2) * people[run / RUNS] + libm::sqrt(0.8) * own[run];
            let candidate = baseline(&["time_lost"], &trials, |_, _, run| Some(around(run, 1) + change(run)));
            judge(&rules, &base, &candidate).verdict == Verdict::Failed
        };
        (0..experiments).filter(failed).count() as f64 / experiments as f64
    };
    // Half of 5 %, and three standard errors of 400 experiments.
    let people = alarms(400, true);
    assert!(people <= 0.025 + 0.0235, "{people}");
    // Were they taken for a hundred independent runs, there would be four times as many.
    let runs = alarms(200, false);
    assert!(runs > 0.0625, "{runs}");
}

#[test]
fn a_change_that_is_the_same_in_every_run_is_not_known_to_be_the_whole() {
    let trials = [trial("walk/tta=6s", 40)];
    let shifted = |shift: f64| {
        baseline(&["min_ttc", "drac"], &trials, move |_, _, run| Some(3.0 + shift + (run % 7) as f64))
    };
    let rules = [named("min_ttc", Tolerance::Absolute(0.5)), named("drac", Tolerance::Absolute(5.0))];
    // Less than is tolerated in all forty: nothing says what the next run does, unless limits do.
    let verdict = judge(&rules, &shifted(0.0), &shifted(-0.25));
    let ttc = outcome(&verdict, "min_ttc", ComparedSubject::Mean);
    assert_eq!(
        (ttc.outcome, ttc.interval),
        (CheckOutcome::NotShown, Some((f64::NEG_INFINITY, f64::INFINITY)))
    );
    let drac = outcome(&verdict, "drac", ComparedSubject::Mean);
    let (low, high) = drac.interval.unwrap();
    assert!(drac.outcome == CheckOutcome::Held && low < -1.0 && high > 0.5 && high < 5.0, "{drac:?}");
    // More than is tolerated in all forty is no chance.
    let verdict = judge(&rules, &shifted(0.0), &shifted(-0.75));
    assert_eq!(outcome(&verdict, "min_ttc", ComparedSubject::Mean).outcome, CheckOutcome::Regressed);
}
