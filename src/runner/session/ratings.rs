//! Ratings, once all trials are judged: what the cells of each suite would earn.

use std::sync::Arc;

use super::shared::Runner;
use results::judge::judge_rating;
use results::{RatingReport, SuiteReport, TrialReport};
use scenario::Rating;

/// Judges every rating of every suite and puts what it came to into the suite's report.
pub fn judge_ratings(runner: &Runner, reports: &mut [SuiteReport]) {
    for (suite, report) in reports.iter_mut().enumerate() {
        let ratings = &runner.suites()[suite].suite.ratings;
        assert!(ratings.is_empty() || report.summary.is_none(), "a suite with ratings has every trial");
        let judged = ratings.iter().map(|rating| judge_one_rating(runner, suite, rating, &report.trials));
        report.ratings = judged.collect();
    }
}

/// Judges one rating of the suite with index `suite` on all of its trials.
pub fn judge_one_rating(
    runner: &Runner,
    suite: usize,
    rating: &Rating,
    trials: &[TrialReport],
) -> RatingReport {
    let identity = runner.identity(suite);
    judge_rating(&Arc::new(rating.clone()), &identity.suite, trials, &identity.set, runner.requests())
}
