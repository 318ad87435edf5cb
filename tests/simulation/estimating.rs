//! Probabilities of rare events in whole runs: known ones are found, what must not matter changes nothing, what is cut off goes on, and what
//! cannot be estimated says so.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use models::standard;
use numbers::distributions::normal::cumulative;
use results::{BlockResult, EstimateResult, Verdict};
use runner::experiment::{BlockProgress, Context, EarlierResults, ExperimentError, Silent, run_block};
use runner::plan::plan;
use runner::run::{Executor, Shuffled, Stop, Threads};
use scenario::Block;

use crate::support::text::{checked, loaded};

/// Where the centre of a car of 4 m x 2 m at 10 m/s starts before the crossing, m, with that mean and a standard deviation of 4 m; a person
/// of radius 0.3 m who walks at 1 m/s, 4.75 m from the middle of the lane. Both move evenly, so that long steps change nothing.
fn text(mean: f64, block: &str) -> String {
    format!(
        "scenario walk {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
  vehicle av {{ controller constant_speed; size 4 m x 2 m; speed 10 m/s; start far before crossing }}
  pedestrian walker {{ model scripted {{ speed: 1 m/s }}; radius 0.3 m; start 3 m from kerb; appears at 0 s }}
  draw far from normal({mean} m, 4 m)
  horizon 15 s
  step 0.1 s
  finish 20 m
  end on collision
  expect {{ no collision }}
}}
estimate hit {{
  of walk
  {block}
}}
"
    )
}

const BLOCK: &str = "event collision; score pet; budget 4000 runs, by importance";

/// In the car's frame the person moves along a straight line, which meets the rounded rectangle that their bodies make together if it is
/// no farther from its middle than that reaches across the line: |s - 47.5 m| < 2 m + 10 · 1 m + √101 · 0.3 m.
fn probability(mean: f64) -> f64 {
    let reach = 2.0 + 10.0 + 101.0_f64.sqrt() * 0.3;
    let below = |s: f64| cumulative((s - mean) / 4.0);
    below(47.5 + reach) - below(47.5 - reach)
}

fn run(
    text: &str,
    executor: &dyn Executor,
    journals: Option<&Path>,
    stop: &Stop,
    progress: &dyn BlockProgress,
) -> Result<EstimateResult, ExperimentError> {
    let suite = loaded(text);
    let mut context = Context::new(&suite, executor, &standard());
    context.journals = journals.map(Path::to_path_buf);
    context.stop = stop.clone();
    let block = Block::Estimate(suite.estimates[0].clone());
    run_block(&block, &context, &EarlierResults::default(), progress).map(|result| match result {
        BlockResult::Estimate(result) => result,
        other => panic!("{other:?}"),
    })
}

fn estimated(text: &str) -> EstimateResult {
    run(text, &Threads::new(2), None, &Stop::default(), &Silent).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn probabilities_in_closed_form_are_found() {
    for (mean, least) in [(75.0, 8e-4), (80.5, 3e-6), (82.0, 5e-7)] {
        let known = probability(mean);
        assert!(known > least && known < 2.0 * least, "{known}");
        let result = estimated(&text(mean, BLOCK));
        assert!(result.refusals.is_empty(), "{:?}", result.refusals);
        let (low, high) = (result.interval.low, result.interval.high);
        assert!(low < 1.05 * known && known < 1.05 * high && high < 1.3 * low, "{known}: {result:?}");
        assert!(result.guaranteed > known && result.runs == 4000, "{result:?}");
        assert_eq!((result.nominal_runs, result.verdict()), (300, Verdict::Passed));
        assert!((result.unseen - 3.0 / 300.0).abs() < 2e-4);
    }
}

#[test]
fn crude_runs_find_what_is_not_rare() {
    let known = probability(66.0);
    let block = "event collision; budget 2000 runs, by crude; claim <= 30 %; claim guaranteed <= 1 %";
    let result = estimated(&text(66.0, block));
    assert!(result.interval.contains(known) && result.value > 0.1, "{known}: {result:?}");
    let verdicts: Vec<_> = result.claims.iter().map(|one| one.verdict).collect();
    assert_eq!(verdicts, [Verdict::Passed, Verdict::Failed]);
    assert_eq!(result.verdict(), Verdict::Failed);
}

#[test]
fn splitting_finds_the_same() {
    let known = probability(70.0);
    let result = estimated(&text(70.0, "event collision; score pet; budget 24000 runs, by splitting"));
    assert!(result.refusals.is_empty(), "{:?}", result.refusals);
    assert!(known < 0.04 && result.interval.contains(known), "{known}: {result:?}");
    assert_eq!(result.nominal_runs, 1800, "a tenth of what the pilot leaves");
    assert!(result.runs <= 24_000 && result.hits > 100, "{result:?}");
}

#[test]
fn claims_are_decided_by_the_estimate_or_by_nominal_runs_alone() {
    let claims = "claim <= 1e-5; claim <= 1e-7; claim guaranteed <= 2 %";
    let result = estimated(&text(80.5, &format!("{BLOCK}; {claims}")));
    let verdicts: Vec<_> = result.claims.iter().map(|one| one.verdict).collect();
    assert_eq!(verdicts, [Verdict::Passed, Verdict::Failed, Verdict::Passed], "{:?}", result.claims);
    assert!(result.failure().unwrap().contains("`claim <= 1e-7`"));
}

/// Nothing leads to it: no estimate, and a claim is not passed by having found nothing.
#[test]
fn what_is_not_found_is_not_passed() {
    let block = "event collision; score arrival_time(av); budget 1000 runs; claim <= 1e-5";
    let result = estimated(&text(99.0, block).replace("arrival_time(av)", "min_distance"));
    assert_eq!(result.verdict(), Verdict::Inconclusive, "{result:?}");
    assert!(result.failure().unwrap().contains("refused"), "{result:?}");
}

/// Of what the horizon cut off nothing is claimed, however many runs had no collision until then.
#[test]
fn what_was_not_seen_to_its_end_is_not_passed() {
    for block in [BLOCK, "event collision; budget 2000 runs, by crude"] {
        let text = text(75.0, &format!("{block}; claim <= 10 %; claim guaranteed <= 10 %"));
        let whole = estimated(&text);
        assert_eq!((whole.cut_off, whole.verdict()), (0, Verdict::Passed), "{whole:?}");
        let result = estimated(&text.replace("horizon 15 s", "horizon 2 s"));
        assert_eq!(result.cut_off, result.runs - result.pilot_runs);
        assert!(result.claims.iter().all(|one| one.verdict == Verdict::Inconclusive), "{:?}", result.claims);
        assert!(result.failure().unwrap().contains("raise its `horizon`"), "{:?}", result.failure());
        let unclaimed = estimated(&self::text(75.0, block).replace("horizon 15 s", "horizon 2 s"));
        assert_eq!(unclaimed.verdict(), Verdict::Inconclusive);
        assert!(
            result.warnings.iter().any(|one| one.contains("ended before the end")),
            "{:?}",
            result.warnings
        );
    }
}

/// Where the event is most runs have it, and are over: what is drawn was still not seen to its end.
#[test]
fn what_is_drawn_and_was_not_seen_to_its_end_is_not_passed_either() {
    // By 6.2 s everybody who is hit was; the car that hits nobody has still to come.
    let cut = text(75.0, &format!("{BLOCK}; claim <= 10 %; claim guaranteed <= 10 %"))
        .replace("horizon 15 s", "horizon 6.2 s");
    let result = estimated(&cut);
    let counted = result.runs - result.pilot_runs;
    assert!(result.cut_off > 0 && 2 * result.cut_off < counted, "{} of {counted}", result.cut_off);
    assert!(result.claims.iter().all(|one| one.verdict == Verdict::Inconclusive), "{:?}", result.claims);
    assert!(result.failure().unwrap().contains("that are drawn as they are"), "{:?}", result.failure());
}

#[test]
fn who_makes_the_runs_changes_nothing() {
    for block in [BLOCK, "event collision; score pet; budget 2000 runs, by splitting"] {
        let text = text(78.0, block);
        let alone = run(&text, &Threads::new(1), None, &Stop::default(), &Silent).unwrap();
        for executor in [&Threads::new(3) as &dyn Executor, &Shuffled::seeded(7)] {
            let other = run(&text, executor, None, &Stop::default(), &Silent).unwrap();
            assert_eq!(alone, other);
            let results = [alone.clone(), other].map(BlockResult::Estimate);
            assert_eq!(results[0].fingerprint(), results[1].fingerprint());
        }
    }
}

struct StopAfter(AtomicUsize, Stop);

impl BlockProgress for StopAfter {
    fn evaluated(&self, _done: usize, _all: usize, _best: Option<f64>) {
        if self.0.fetch_sub(1, Ordering::Relaxed) == 1 {
            self.1.request();
        }
    }
}

#[test]
fn what_is_cut_off_goes_on() {
    let text = text(78.0, BLOCK);
    let whole = estimated(&text);
    let folder = tempfile::tempdir().unwrap();
    for rounds in [2, 7, 5] {
        let stop = Stop::default();
        let progress = StopAfter(AtomicUsize::new(rounds), stop.clone());
        let cut = run(&text, &Threads::new(2), Some(folder.path()), &stop, &progress);
        assert!(matches!(cut, Err(ExperimentError::Stopped)), "{cut:?}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
    let resumed = run(&text, &Threads::new(2), Some(folder.path()), &Stop::default(), &Silent).unwrap();
    assert_eq!(resumed, whole);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "its journal is gone");
}

/// The runs that carry it are found by their names, far beyond those that the scenario makes by itself.
#[test]
fn runs_are_found_again_by_their_names() {
    let text = text(80.5, BLOCK);
    let result = estimated(&text);
    let suite = loaded(&text);
    let plan = plan(&suite).unwrap();
    let cases = plan.trial(0).cases;
    assert_eq!(cases.len(), 1);
    assert!(
        !result.carrying.is_empty() && result.carrying.windows(2).all(|two| two[0].share >= two[1].share)
    );
    for run in &result.carrying {
        let case = cases.named(&run.key).unwrap_or_else(|| panic!("{} is a run", run.key));
        assert_eq!((&case.key, &case.drawn[0].label), (&run.key, &run.drawn[0].1));
        let far = case.drawn[0].value.as_number().unwrap();
        assert!(far < 47.5 + 15.1, "{far} m is no collision");
    }
}

#[test]
fn a_run_that_cannot_be_made_makes_it_an_error() {
    let text = text(60.0, BLOCK).replace("speed 10 m/s", "speed fast - slow").replace(
        "  draw far",
        "  draw fast from choice(2 m/s, 4 m/s, 6 m/s)\n  draw slow from choice(1 m/s, 3 m/s)\n  draw far",
    );
    let result = run(&text, &Threads::new(2), None, &Stop::default(), &Silent);
    assert!(result.is_err(), "{result:?}");
}

#[test]
fn what_cannot_be_estimated_is_said_before_any_run() {
    let with = |block: &str| text(80.0, block);
    let said = |text: &str, words: &[&str]| {
        let error = checked(text).expect_err("it is wrong");
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    said(
        &with(BLOCK).replace("draw far from normal(80 m, 4 m)", "let far = 80 m"),
        &["BadEstimate", "draws nothing"],
    );
    said(
        &with(BLOCK)
            .replace("draw far", "vary tall in [1, 2]\n  draw far")
            .replace("10 m/s", "10 m/s * tall"),
        &["BadEstimate", "varies `tall`"],
    );
    said(
        &with("event collision; score pet; budget 900 runs"),
        &["BudgetTooSmall", "20 independent replicates"],
    );
    said(
        &with(&format!("{BLOCK}; claim guaranteed <= 1e-5")),
        &["BudgetTooSmall", "299,572 runs for 1e-5 at 95 %", "the budget has 300"],
    );
    said(&with("event collision; budget 1000 runs, by crude; claim <= 1e-4"), &["BudgetTooSmall", "29,956"]);
    said(&with(&format!("{BLOCK}; claim >= 1e-5")), &["BadEstimate", "at most"]);
    said(&with("event collision; budget 1000 runs"), &["MissingStatement", "no score"]);
    said(&with("event collision; score collision; budget 1000 runs"), &["BadEstimate", "gets worse"]);
    assert!(checked(&with(&format!("{BLOCK}; claim <= 1e-9"))).is_ok(), "the estimate decides");
}

/// Between 20 and 50 encounters in 1,000 km.
#[test]
fn what_is_told_of_a_distance_is_the_probability_times_the_encounters() {
    let block = BLOCK.replace("4000 runs", "1000 runs");
    let with = |exposure: &str| estimated(&text(75.0, &format!("{block}; {exposure}")));
    let plain = estimated(&text(75.0, &block));
    assert_eq!(plain.per_1000_km, None, "there is no default");
    let result = with("exposure 20 .. 50 encounters per 1000 km source \"A count\"");
    let along = result.per_1000_km.clone().unwrap();
    assert_eq!((result.guaranteed, result.interval), (plain.guaranteed, plain.interval));
    assert_eq!((along.source.as_str(), along.confidence), ("A count", 0.95));
    let close =
        |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    let holds = |along: &results::EventsPerDistance| {
        close(along.guaranteed, 50.0 * plain.guaranteed);
        close(along.unseen, 50.0 * plain.unseen);
        close(along.interval.low, 20.0 * plain.interval.low);
        close(along.interval.high, 50.0 * plain.interval.high);
        close(along.value.low, 20.0 * plain.value);
    };
    holds(&along);
    // In whatever unit and along whatever distance it is given.
    for same in [
        "exposure 2 .. 5 encounters per 100 km source \"A\"",
        "exposure 0.02 .. 0.05 encounters per 1000 m source \"A\"",
    ] {
        holds(&with(same).per_1000_km.unwrap());
    }
    // A number is both ends; what the exposure may be wrong by is taken off.
    let one =
        with("exposure 30 encounters per 1000 km with 99 % confidence source \"A\"").per_1000_km.unwrap();
    close(one.value.low, one.value.high);
    close(one.confidence, 0.94);
}

#[test]
fn claims_along_a_distance_hold_with_the_most_encounters_and_fail_with_the_fewest() {
    let exposure = "exposure 20 .. 50 encounters per 1000 km source \"A count\"";
    // By the estimate there are 0.016 to 0.043 events in 1,000 km.
    let claims = [
        ("claim <= 0.06 per 1000 km", Verdict::Passed),
        ("claim <= 0.006 per 100 km", Verdict::Passed),
        ("claim <= 0.025 per 1000 km", Verdict::Inconclusive),
        ("claim <= 0.01 per 1000 km", Verdict::Failed),
        ("claim guaranteed <= 0.51 per 1000 km", Verdict::Passed),
    ];
    let all = claims.map(|(claim, _)| claim).join("; ");
    let result = estimated(&text(75.0, &format!("{BLOCK}; {exposure}; {all}")));
    assert!(result.refusals.is_empty(), "{:?}", result.refusals);
    assert_eq!(result.claims.len(), claims.len());
    for ((claim, expected), judged) in claims.iter().zip(&result.claims) {
        assert_eq!(judged.verdict, *expected, "{claim}: {}", judged.reason);
        assert!(judged.reason.contains("events in 1,000 km"), "{}", judged.reason);
    }
}
