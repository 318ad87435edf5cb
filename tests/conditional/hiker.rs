//! The HIKER crossing experiment: our runs against the reference's 3,000 per scenario.
//!
//! `scenario-runner validate hiker` makes the full comparison.

use std::path::Path;

use libtest_mimic::Trial;
use models::pedestrian::commotions::hiker::HikerReference;

use super::{shared, with};

pub fn tests() -> Vec<Trial> {
    let file = shared("data/hiker_reference.json");
    with(file.as_deref(), &[("crossing_shares_and_start_times", crossing_shares_and_start_times)])
}

fn crossing_shares_and_start_times(file: &Path) {
    let reference = HikerReference::read(file).unwrap();
    // Every second individual once: 250 runs per scenario.
    let comparisons = reference.compare(file, 2, 1, 20_261_121).unwrap();
    assert_eq!(comparisons.len(), 24);
    for c in &comparisons {
        println!(
            "{:7} {} runs: {:.3} crossed, reference {:.4}: {:.1} standard errors; starts {:?} s, reference {:?} s",
            c.scenario,
            c.runs,
            c.crossed_before,
            c.reference_crossed_before,
            c.standard_errors(),
            c.median_start,
            c.reference_median_start,
        );
        assert!(c.shares_agree(), "{c:?}");
        assert!(c.median_standard_errors().is_none_or(|errors| errors <= 3.0), "{c:?}");
    }
}
