//! How many of the published fit's candidates calibration retains; `scenario-runner validate retention` takes them all.

use std::path::Path;

use libtest_mimic::Trial;
use models::calibrate::{
    Calibration, PUBLISHED_SHARE, Request, calibrate, published_candidates, published_criteria,
};
use models::pedestrian::commotions::Variant;

use super::{shared, with};

pub fn tests() -> Vec<Trial> {
    let file = shared("data/commotions_individuals.json");
    let test = the_published_share_of_candidates_is_retained;
    with(file.as_deref(), &[("the_published_share_of_candidates_is_retained", test)])
}

fn the_published_share_of_candidates_is_retained(file: &Path) {
    let candidates = published_candidates(file, 400, 20_261_121).unwrap();
    assert_eq!(candidates.names, ["T_delta", "beta_V", "T", "DeltaV_th_rel", "tau_theta"]);
    assert_eq!(published_candidates(file, usize::MAX, 1).unwrap().rows.len(), 69 * 125);
    let calibration =
        Calibration { variant: Variant::STANDARD, criteria: published_criteria(), repetitions: 5, seed: 1 };
    let request = Request { calibration, candidates, design: String::new() };
    let report = calibrate(&request, None, || ()).unwrap();
    let share = report.retained.len() as f64 / 400.0;
    println!("{} of 400 retained, {share:.3}; failed {:?}", report.retained.len(), report.failed);
    let error = (PUBLISHED_SHARE * (1.0 - PUBLISHED_SHARE) * (1.0 / 400.0 + 1.0 / 5000.0)).sqrt();
    assert!((share - PUBLISHED_SHARE).abs() <= 3.0 * error, "{share}");
}
