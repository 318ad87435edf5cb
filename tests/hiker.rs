//! The HIKER crossing experiment: our runs against the reference's 3,000 per scenario.

mod support;

use scenario_runner::pedestrian::commotions::hiker::Reference;

#[test]
fn crossing_shares_and_start_times() {
    let Some(file) = support::shared("data/hiker_reference.json") else { return };
    let reference = Reference::read(&file).unwrap();
    let stride = std::env::var("HIKER_STRIDE").map_or(2, |s| s.parse().unwrap());
    let reps = std::env::var("HIKER_REPS").map_or(1, |s| s.parse().unwrap());
    let comparisons = reference.compare(&file, stride, reps, 20_261_121).unwrap();
    assert_eq!(comparisons.len(), 24);
    for c in &comparisons {
        println!(
            "{:7} {:5} runs: crossed {:.4}, reference {:.4}: {:.1} standard errors; start {:?}, reference {:?}",
            c.scenario,
            c.runs,
            c.crossed_before,
            c.reference_crossed_before,
            c.standard_errors(),
            c.median_start,
            c.reference_median_start,
        );
    }
}
