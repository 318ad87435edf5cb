//! Two scenarios in the same encounters: known differences are found, the same differs by nothing, and what cannot be said counts for nobody.

use models::standard;
use numbers::distributions::normal::cumulative;
use results::{BlockResult, ComparedEstimate, EstimateResult, Verdict};
use runner::experiment::{Context, EarlierResults, Silent, run_block};
use runner::plan::plan;
use runner::run::{Executor, Shuffled, Threads};
use scenario::Block;

use crate::support::text::{checked, loaded};

/// A car at 10 m/s and a person who walks at 1 m/s, evenly, so that long steps change nothing. `changed` is what the scenario that it is
/// compared with has otherwise.
fn text(changed: &str, block: &str) -> String {
    format!(
        "scenario walk {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
  vehicle av {{ controller constant_speed; size 4 m x 2 m; speed 10 m/s; start far before crossing }}
  pedestrian walker {{ model scripted {{ speed: 1 m/s }}; radius 0.3 m; start 3 m from kerb; appears at 0 s }}
  draw far from normal(75 m, 4 m)
  horizon 15 s
  step 0.1 s
  finish 20 m
  end on collision
  expect {{ no collision }}
}}
scenario before : walk {{ {changed} }}
estimate hit {{
  of walk
  compare with before
  {block}
}}
"
    )
}

const BLOCK: &str = "event collision; score pet; budget 8000 runs, by importance";

/// The closed form of `estimating.rs`, of a car so much longer than 4 m.
fn probability(longer: f64) -> f64 {
    let reach = 2.0 + longer / 2.0 + 10.0 + 101.0_f64.sqrt() * 0.3;
    let below = |s: f64| cumulative((s - 75.0) / 4.0);
    below(47.5 + reach) - below(47.5 - reach)
}

fn run(text: &str, executor: &dyn Executor) -> EstimateResult {
    let suite = loaded(text);
    let context = Context::new(&suite, executor, &standard());
    let block = Block::Estimate(suite.estimates[0].clone());
    match run_block(&block, &context, &EarlierResults::default(), &Silent) {
        Ok(BlockResult::Estimate(result)) => result,
        other => panic!("{other:?}"),
    }
}

fn compared(text: &str) -> (EstimateResult, ComparedEstimate) {
    let result = run(text, &Threads::new(2));
    let compared = result.compared.clone().expect("it is compared");
    (result, compared)
}

fn verdicts(result: &EstimateResult) -> Vec<Verdict> {
    result.claims.iter().map(|one| one.verdict).collect()
}

#[test]
fn known_differences_and_ratios_are_found() {
    // The centre is where it starts: a longer car reaches farther to both sides.
    for longer in [0.4, 3.0, -1.0] {
        let changed = format!("vehicle av {{ size {} m x 2 m }}", 4.0 + longer);
        let (one, other) = (probability(0.0), probability(longer));
        let (result, compared) = compared(&text(&changed, BLOCK));
        assert!(compared.ratio_refusals.is_empty(), "{longer}: {:?}", compared.ratio_refusals);
        let ratio = compared.ratio_interval;
        let high = ratio.high.expect("the other happens, too");
        // One of 20 intervals does not cover; a tenth of its width beyond is given.
        let beyond = 0.1 * (high - ratio.low);
        let known = one / other;
        assert!(ratio.low - beyond < known && known < high + beyond, "{longer}: {known}, {ratio:?}");
        let difference = compared.difference_interval;
        let beyond = 0.1 * (difference.high - difference.low);
        assert!(
            difference.low - beyond < one - other && one - other < difference.high + beyond,
            "{compared:?}"
        );
        assert!(compared.guaranteed_difference.contains(one - other));
        assert_eq!((result.runs, result.nominal_runs), (8000, 300), "half of the runs of each");
        assert_eq!(compared.differs.len(), 1, "{:?}", compared.differs);
        // A car that is longer hits whoever a shorter one hits.
        let (here, there) = (compared.only_here, compared.only_there);
        assert!(if longer > 0.0 { here == 0 && there > 0 } else { here > 0 && there == 0 }, "{compared:?}");
    }
}

#[test]
fn claims_about_both_are_decided() {
    let longer = "vehicle av { size 5 m x 2 m }";
    let claims = "claim ratio <= 1; claim ratio <= 0.5; claim difference <= 0; claim difference <= -2 %; claim guaranteed difference <= 5 %";
    let (result, _) = compared(&text(longer, &format!("{BLOCK}; {claims}")));
    let expected = [Verdict::Passed, Verdict::Failed, Verdict::Passed, Verdict::Failed, Verdict::Passed];
    assert_eq!(verdicts(&result), expected, "{:?}", result.claims);
    // 8.1e-4 less 1.3e-3 is -5e-4 an encounter, and there are 100 to 200 of them.
    let exposure = "exposure 100 .. 200 encounters per 1000 km source \"A count\"";
    let claims = "claim difference <= -0.03 per 1000 km; claim difference <= -0.2 per 1000 km";
    let (result, _) = compared(&text(longer, &format!("{BLOCK}; {exposure}; {claims}")));
    assert_eq!(verdicts(&result), [Verdict::Passed, Verdict::Failed], "{:?}", result.claims);
}

/// What happens by chance beyond what is drawn is the same in both, or what is the same would differ.
#[test]
fn the_same_differs_by_nothing_whatever_happens_by_chance() {
    let text = "scenario walk {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed 40 km/h; start 60 m before crossing }
  pedestrian walker { model commotions; individuals drawn from standard; start 2 m from kerb; appears when time_to_arrival(av) = tta }
  draw tta from uniform(2 s, 5 s)
  horizon 20 s
  expect { no collision }
}
scenario before : walk { tags other }
estimate near {
  of walk
  compare with before
  event pet < 3 s undefined passes
  budget 2000 runs, by crude
  claim ratio <= 1
  claim guaranteed ratio <= 1.3
}
";
    let (result, compared) = compared(text);
    assert!(compared.hits > 20 && compared.hits < 900, "something happens: {compared:?}");
    assert_eq!((compared.only_here, compared.only_there, compared.ratio), (0, 0, Some(1.0)));
    assert_eq!((result.hits, &result.replicates), (compared.hits, &compared.replicates));
    assert!(result.warnings.iter().any(|one| one.contains("nothing that is simulated differs")));
    assert_eq!(result.claims[0].verdict, Verdict::Inconclusive, "that nothing differs was not shown");
}

#[test]
fn what_cannot_be_said_of_the_other_favours_no_claim() {
    let claims = "claim difference <= 0; claim ratio <= 1; claim guaranteed difference <= 50 %";
    // Nobody gets to the lane in 2 s.
    let (result, cut) = compared(&text("horizon 2 s", &format!("{BLOCK}; {claims}")));
    assert_eq!((cut.hits, cut.ratio, cut.cut_off, result.cut_off), (0, None, 3000, 0));
    assert_eq!(verdicts(&result), [Verdict::Inconclusive; 3], "{:?}", result.claims);
    let warned = |result: &EstimateResult, word: &str| result.warnings.iter().any(|one| one.contains(word));
    assert!(warned(&result, "`before` ended before the end"), "{:?}", result.warnings);
    // How much time a car loses is not known before it has arrived.
    let event = BLOCK.replace("event collision", "event time_lost > 0.01 s");
    let late = text("horizon 2 s", &format!("{event}; {claims}")).replace("finish 20 m", "finish 100 m");
    let (result, open) = compared(&late);
    assert!(open.undecided > 1000 && open.hits == 0, "{open:?}");
    assert!(verdicts(&result).iter().all(|one| *one != Verdict::Passed), "{:?}", result.claims);
    assert!(warned(&result, "as if it were not so"), "{:?}", result.warnings);
}

/// Who makes the runs, and which of the two is named first.
#[test]
fn what_must_not_matter_changes_nothing() {
    let longer = text("vehicle av { size 4.6 m x 2 m }", "event collision; score pet; budget 4000 runs");
    let alone = run(&longer, &Threads::new(1));
    for executor in [&Threads::new(3) as &dyn Executor, &Shuffled::seeded(7)] {
        let other = run(&longer, executor);
        assert_eq!(alone, other);
        let results = [alone.clone(), other].map(BlockResult::Estimate);
        assert_eq!(results[0].fingerprint(), results[1].fingerprint());
    }
    let turned = longer.replace("of walk\n  compare with before", "of before\n  compare with walk");
    let turned = run(&turned, &Threads::new(2));
    let (one, other) = (alone.compared.clone().unwrap(), turned.compared.clone().unwrap());
    assert_eq!((one.only_here, one.only_there), (other.only_there, other.only_here));
    assert!((one.difference + other.difference).abs() < 1e-15);
    assert!((alone.value - other.value).abs() < 1e-15 && (one.value - turned.value).abs() < 1e-15);
    // What is estimated of one scenario is no other number for being compared, but by what else was looked for.
    assert!(alone.interval.contains(probability(0.0)), "{:?}", alone.interval);
}

#[test]
fn runs_of_both_are_found_again_by_their_names() {
    let longer = text("vehicle av { size 5 m x 2 m }", BLOCK);
    let (result, compared) = compared(&longer);
    let suite = loaded(&longer);
    let trials: Vec<_> = plan(&suite).unwrap().trials().collect();
    let found = |key: &str| trials.iter().find_map(|trial| trial.cases.named(key));
    assert!(!compared.there.is_empty() && !result.carrying.is_empty());
    for (run, scenario) in compared
        .there
        .iter()
        .map(|run| (run, "before"))
        .chain(result.carrying.iter().map(|run| (run, "walk")))
    {
        let case = found(&run.key).unwrap_or_else(|| panic!("{} is a run", run.key));
        assert_eq!((&case.key, case.scenario.as_str()), (&run.key, scenario));
        assert_eq!(case.drawn[0].label, run.drawn[0].1);
    }
    // The run that it is compared with has the same chance.
    let key = &compared.there[0].key;
    let own = found(&key.replace("/before/", "/walk/").replace("/chance=walk", "")).unwrap();
    assert_eq!(own.seed, found(key).unwrap().seed);
    assert!(found(&key.replace("/chance=walk", "/chance=before/chance=walk")).is_none());
}

#[test]
fn what_cannot_be_compared_is_said_before_any_run() {
    let said = |text: &str, words: &[&str]| {
        let error = checked(text).expect_err("it is wrong");
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    let plain = text("", BLOCK);
    said(&text("draw far from normal(75 m, 5 m)", BLOCK), &["BadEstimate", "draws other values than `walk`"]);
    said(&text("seed 7", BLOCK), &["BadEstimate", "has another seed than `walk`"]);
    said(
        &text(
            "draw pace from normal(1 m/s, 0.1 m/s); pedestrian walker { model scripted { speed: pace } }",
            BLOCK,
        ),
        &["draws other values"],
    );
    said(&plain.replace("compare with before", "compare with walk"), &["BadEstimate", "with itself"]);
    said(&plain.replace("compare with before", "compare with befor"), &["UnknownScenario", "befor"]);
    said(&plain.replace("8000 runs", "1800 runs"), &["BudgetTooSmall", "half of them of each"]);
    let exposure = "exposure 1 .. 2 encounters per 1000 km source \"A\"";
    said(
        &text("", &format!("{BLOCK}; {exposure}; claim ratio <= 1 per 1000 km")),
        &["the same along any distance"],
    );
    for (claim, word) in [
        ("ratio <= 0", "not above 0"),
        ("difference <= 1", "not between -1 and 1"),
        ("ratio >= 1", "at most"),
    ] {
        said(&text("", &format!("{BLOCK}; claim {claim}")), &["BadEstimate", word]);
    }
    let alone = text("", &format!("{BLOCK}; claim ratio <= 1")).replace("  compare with before\n", "");
    said(&alone, &["BadEstimate", "nothing is compared"]);
    // A guarantee is of half of the runs.
    said(&text("", &format!("{BLOCK}; claim guaranteed <= 0.9 %")), &["BudgetTooSmall", "has 300"]);
    // What is measured is there in both.
    let other = "vehicle av { size 4 m x 2 m }; vehicle lead { controller constant_speed; speed 10 m/s; start 200 m before crossing }";
    let event = BLOCK.replace("event collision", "event collision(av, walker)");
    assert!(checked(&text(other, &event)).is_ok());
}
