//! How often sequential tests are wrong, and how many runs they take: a study over 10,000 synthetic experiments a row, too
//! long for the test suite. `cargo bench --bench sequential` prints the table; docs/statistics.md has what it found.

use numbers::inference::{ConfidenceSequence, ShareDecision, Sprt, clopper_pearson};
use numbers::random::Stream;

const EXPERIMENTS: u64 = 10_000;
const CONFIDENCE: f64 = 0.95;

/// The most runs of an experiment whose runs are added until it is decided.
const MOST_RUNS: u64 = 1000;

/// Where the true share is just the one that is claimed, each wrong verdict is as likely as it can be.
fn main() {
    println!(
        "sequential tests at stated {CONFIDENCE} in {EXPERIMENTS} experiments of up to {MOST_RUNS} runs,"
    );
    println!("looked at after every run, or after whole rounds; one standard error is 0.2 %");
    println!(
        "{:<36} {:>8} {:>8} {:>10} {:>10} {:>8} {:>6}",
        "test", "claimed", "true", "passed %", "failed %", "open %", "runs"
    );
    let sequence = ConfidenceSequence { confidence: CONFIDENCE };
    for share in [0.5, 0.8, 0.9, 0.95, 0.99] {
        test("confidence sequence, on the border", share, &[share], |holding, runs| {
            sequence.decide(holding, runs, share)
        });
    }
    // Four people with shares of their own, of which the mean is 90 %.
    test("confidence sequence, rounds of 4", 0.9, &[1.0, 0.6, 1.0, 1.0], |holding, runs| {
        if runs.is_multiple_of(4) { sequence.decide(holding, runs, 0.9) } else { ShareDecision::Open }
    });
    for (claimed, truth) in [(0.9, 1.0), (0.9, 0.97), (0.95, 0.98), (0.95, 0.9), (0.9, 0.5)] {
        test("confidence sequence, off the border", claimed, &[truth], |holding, runs| {
            sequence.decide(holding, runs, claimed)
        });
    }
    let sprt = Sprt { bad: 0.93, good: 0.97, alpha: 1.0 - CONFIDENCE, beta: 1.0 - CONFIDENCE };
    for truth in [sprt.bad, sprt.good] {
        test("SPRT of 93 % against 97 %", 0.95, &[truth], |holding, runs| sprt.decide(holding, runs));
    }
    // What all this is there to prevent.
    test("peeking (Clopper-Pearson, 200 runs)", 0.95, &[0.95], |holding, runs| {
        let could_pass = runs <= 200 && holding as f64 > 0.95 * runs as f64;
        let passes = || clopper_pearson(holding, runs, 2.0 * CONFIDENCE - 1.0).low >= 0.95;
        if could_pass && passes() { ShareDecision::Holds } else { ShareDecision::Open }
    });
}

/// One row: how often the claim passes and fails while those with `truth` take turns.
fn test(name: &str, claimed: f64, truth: &[f64], decide: impl Fn(u64, u64) -> ShareDecision) {
    let mut stream = Stream::seeded(20_261_121);
    let (mut passed, mut failed, mut all_runs) = (0, 0, 0);
    for _ in 0..EXPERIMENTS {
        let mut holding = 0;
        let mut runs = 0;
        while runs < MOST_RUNS {
            holding += u64::from(stream.uniform() < truth[runs as usize % truth.len()]);
            runs += 1;
            match decide(holding, runs) {
                ShareDecision::Holds => passed += 1,
                ShareDecision::Fails => failed += 1,
                ShareDecision::Open => continue,
            }
            break;
        }
        all_runs += runs;
    }
    let percent = |count: u64| 100.0 * count as f64 / EXPERIMENTS as f64;
    let mean_truth = truth.iter().sum::<f64>() / truth.len() as f64;
    println!(
        "{name:<36} {:>6} % {:>6.1} % {:>10.2} {:>10.2} {:>8.2} {:>6.0}",
        100.0 * claimed,
        100.0 * mean_truth,
        percent(passed),
        percent(failed),
        percent(EXPERIMENTS - passed - failed),
        all_runs as f64 / EXPERIMENTS as f64
    );
}
