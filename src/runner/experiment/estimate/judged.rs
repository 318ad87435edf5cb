//! Claims about probabilities, differences and ratios, and refusals, in words with their numbers.

use numbers::rare::{
    CONTRADICTION, LARGEST_DEVIATION, LARGEST_SHARE, LEAST_EFFECTIVE, RareEstimate, RareRefusal,
};
use results::{EstimatedClaim, Verdict};
use scenario::{EstimateClaim, EstimateClaimOf, Exposure, significant};

/// A probability or a difference: with three digits, and with a power of ten where it is small.
pub fn number(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-2 { format!("{value:.2e}") } else { significant(value, 3) }
}

pub fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 3))
}

pub fn in_words(refusal: &RareRefusal, estimate: &RareEstimate) -> String {
    let (runs, hits) = estimate.nominal;
    match refusal {
        RareRefusal::NoHits => "no run has the event".to_string(),
        RareRefusal::FewHits(size) => format!(
            "its {} hits say as much as {} of equal weight, and it takes {LEAST_EFFECTIVE}",
            estimate.hits,
            significant(*size, 3)
        ),
        RareRefusal::OneRun(share) => {
            format!(
                "one run, or those that were moved from one, has {} of all weight ({} or more)",
                percent(*share),
                percent(LARGEST_SHARE)
            )
        }
        RareRefusal::Contradicted(likely) => format!(
            "{hits} of {runs} runs that are drawn as they are have the event, which an estimate of {} gives by chance with {} \
             (at most {})",
            number(estimate.value),
            percent(*likely),
            percent(CONTRADICTION)
        ),
        RareRefusal::Spread(deviation) => format!(
            "its replicates differ by {} of their mean ({} or more)",
            percent(*deviation),
            percent(LARGEST_DEVIATION)
        ),
        RareRefusal::NewCluster(share) => format!(
            "the second half found hits away from all of the first, with {} of its weight: there may be more",
            percent(*share)
        ),
    }
}

/// A claim of which nothing is shown.
pub fn open(claim: &EstimateClaim, reason: String) -> EstimatedClaim {
    let EstimateClaim { guaranteed, text, .. } = claim;
    EstimatedClaim { text: text.clone(), guaranteed: *guaranteed, verdict: Verdict::Inconclusive, reason }
}

/// A claim holds where its one-sided bound shows it, is wrong where the bound from the other side shows that, and else open.
pub fn decide(
    claim: &EstimateClaim,
    exposure: Option<&Exposure>,
    estimate: &RareEstimate,
    refusals: &[String],
) -> EstimatedClaim {
    let level = percent(claim.confidence);
    let (verdict, reason) = if claim.guaranteed {
        let upper = estimate.guaranteed(claim.confidence);
        let (runs, hits) = estimate.nominal;
        let lower =
            if runs == 0 { 0.0 } else { numbers::inference::lower_bound(hits, runs, claim.confidence) };
        let of = format!("{hits} of {runs} runs that are drawn as they are have the event");
        judged(claim, exposure, (lower, upper), &format!("{of}; at {level} without assumptions"))
    } else if refusals.is_empty() {
        let (lower, upper) = (estimate.lower(claim.confidence), estimate.upper(claim.confidence));
        let of = format!("the estimate is {}; at {level} by it", number(estimate.value));
        judged(claim, exposure, (lower, upper), &of)
    } else {
        (Verdict::Inconclusive, format!("the estimate is refused: {}", refusals.join("; ")))
    };
    let EstimateClaim { guaranteed, text, .. } = claim;
    EstimatedClaim { text: text.clone(), guaranteed: *guaranteed, verdict, reason }
}

/// `of` says what the bounds are of, and by what.
pub fn judged(
    claim: &EstimateClaim,
    exposure: Option<&Exposure>,
    (lower, upper): (f64, f64),
    of: &str,
) -> (Verdict, String) {
    // Of events along a distance it holds with the most encounters that there may be, and is wrong only with the fewest; of fewer events
    // than elsewhere the other way round.
    let along = claim.per_1000_km.zip(exposure);
    let (low, high, bound) = match along {
        Some((events, Exposure { low, high, .. })) => (
            lower * if lower > 0.0 { low } else { high },
            upper * if upper > 0.0 { high } else { low },
            events,
        ),
        None => (lower, upper, claim.at_most),
    };
    let what = match (claim.of, along.is_some()) {
        (EstimateClaimOf::Probability, false) => "the probability is",
        (EstimateClaimOf::Probability, true) => "events in 1,000 km are",
        (EstimateClaimOf::Difference, false) => "the difference is",
        (EstimateClaimOf::Difference, true) => "events in 1,000 km are more by",
        (EstimateClaimOf::Ratio, _) => "the ratio is",
    };
    let verdict = if high <= bound {
        Verdict::Passed
    } else if low > bound {
        Verdict::Failed
    } else {
        Verdict::Inconclusive
    };
    let most = if high.is_finite() { number(high) } else { "anything".to_string() };
    let said = match verdict {
        Verdict::Passed => format!("{of} {what} at most {most}"),
        Verdict::Failed => format!("{of} {what} at least {}", number(low)),
        Verdict::Inconclusive => {
            format!("{of} {what} at least {}, and at most {most} by as much", number(low))
        }
    };
    (verdict, said)
}
