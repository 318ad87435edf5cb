//! What an estimate comes to, in numbers and words.

use super::scored_run::ScoredRun;
use crate::experiment::context::Context;
use crate::experiment::error::ExperimentError;
use crate::plan::Cases;
use numbers::rare::{
    CONTRADICTION, LARGEST_DEVIATION, LARGEST_SHARE, LEAST_EFFECTIVE, RareEstimate, RareRefusal,
    RareSampling, RareScale, RareSpace, WeighedHit,
};
use results::{EstimateResult, EstimatedClaim, EstimatedCluster, EstimatedRun, EventsPerDistance, Verdict};
use scenario::{Estimate, EstimateClaim, EstimateMethod, Exposure, significant};

/// Of the interval and the bound that are always said.
const CONFIDENCE: f64 = 0.95;
/// Weights of the tail that are kept.
const MOST_SHARES: usize = 100;
/// Runs that are named.
const MOST_RUNS: usize = 10;
/// Less of the estimate is no group of hits.
const LEAST_CLUSTER: f64 = 1e-4;
/// More runs as far from the event as another, and the score does not slope.
const MOST_EQUAL: f64 = 0.5;

/// What was told of runs.
#[derive(Debug, Default)]
pub struct Told {
    pub runs: usize,
    pilot: usize,
    undecided: usize,
}

impl Told {
    pub fn add(&mut self, is_pilot: bool, seen: &[ScoredRun]) {
        self.runs += seen.len();
        if is_pilot {
            self.pilot += seen.len();
        } else {
            self.undecided += seen.iter().filter(|one| one.undecided).count();
        }
    }
}

pub fn conclude(
    context: &Context,
    block: &Estimate,
    cases: &Cases,
    space: &RareSpace,
    method: &dyn RareSampling,
    scale: RareScale,
    told: &Told,
) -> Result<EstimateResult, ExperimentError> {
    let estimate = context.executor.think(|| RareEstimate::of(space, method.replicates(), scale));
    let hits: Vec<(&WeighedHit, f64)> = method
        .replicates()
        .iter()
        .flat_map(|one| one.hits.iter().map(|hit| (hit, hit.weight / one.runs as f64)))
        .collect();
    let sum: f64 = hits.iter().map(|one| one.1).sum();
    let run = |index: usize| -> Result<EstimatedRun, ExperimentError> {
        let (hit, weight) = hits[index];
        let case = cases.at(hit.chance, &hit.point)?;
        let drawn = case.drawn.into_iter().map(|one| (one.name, one.label)).collect();
        Ok(EstimatedRun { key: case.key, share: weight / sum, drawn })
    };
    let mut heaviest: Vec<usize> = (0..hits.len()).collect();
    heaviest.sort_by(|one, other| hits[*other].1.total_cmp(&hits[*one].1).then(one.cmp(other)));
    let carrying = heaviest.iter().take(MOST_RUNS).map(|index| run(*index)).collect::<Result<Vec<_>, _>>()?;
    let seen = estimate.clusters.iter().filter(|one| one.0 >= LEAST_CLUSTER);
    let cluster = |(share, index): &(f64, usize)| Ok(EstimatedCluster { share: *share, run: run(*index)? });
    let clusters: Vec<EstimatedCluster> =
        seen.take(MOST_RUNS).map(cluster).collect::<Result<_, ExperimentError>>()?;
    let refusals: Vec<String> = estimate.refusals.iter().map(|one| in_words(one, &estimate)).collect();
    let exposure = block.exposure.as_ref();
    let claims = block.claims.iter().map(|claim| decide(claim, exposure, &estimate, &refusals)).collect();
    let (guaranteed, unseen) = (estimate.guaranteed(CONFIDENCE), estimate.unseen(CONFIDENCE));
    let interval = estimate.interval(CONFIDENCE);
    Ok(EstimateResult {
        per_1000_km: exposure.map(|exposure| {
            EventsPerDistance::new(exposure, (guaranteed, unseen), (estimate.value, interval), CONFIDENCE)
        }),
        name: block.name.clone(),
        doc: block.doc.clone(),
        scenario: block.scenario.clone(),
        event: block.event_text.clone(),
        score: block.score.as_ref().map(|score| score.label()),
        method: block.method,
        seed: context.suite.seed,
        runs: told.runs,
        pilot_runs: told.pilot,
        replicates: method.replicates().iter().map(|one| one.probability).collect(),
        value: estimate.value,
        confidence: CONFIDENCE,
        interval,
        assumption: assumption(block.method).to_string(),
        relative_deviation: estimate.relative_deviation,
        guaranteed,
        unseen,
        nominal_runs: estimate.nominal.0,
        nominal_hits: estimate.nominal.1,
        hits: estimate.hits,
        undecided: told.undecided,
        effective_size: estimate.effective_size,
        largest_share: estimate.largest_share,
        contradiction: estimate.contradiction,
        refusals,
        warnings: warnings(block, method, told),
        shares: heaviest.iter().take(MOST_SHARES).map(|index| hits[*index].1 / sum).collect(),
        clusters,
        carrying,
        claims,
    })
}

fn assumption(method: EstimateMethod) -> &'static str {
    match method {
        EstimateMethod::Importance => {
            "the runs reached every region that matters, and the 20 replicates' mean, on a logarithmic scale, behaves as that of a \
             normal distribution (Student)"
        }
        EstimateMethod::Splitting => {
            "from the runs of each level every region of the next that matters was reached, and the 20 replicates' mean, on a logarithmic \
             scale, behaves as that of a normal distribution (Student)"
        }
        EstimateMethod::Crude => "none: all runs are drawn as they are (Clopper–Pearson)",
    }
}

/// A probability: with three digits, and with a power of ten where it is small.
fn number(value: f64) -> String {
    if value > 0.0 && value < 1e-2 { format!("{value:.2e}") } else { significant(value, 3) }
}

fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 3))
}

fn in_words(refusal: &RareRefusal, estimate: &RareEstimate) -> String {
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

fn warnings(block: &Estimate, method: &dyn RareSampling, told: &Told) -> Vec<String> {
    let mut warnings = Vec::new();
    let plateau = method.plateau();
    if let Some(score) = block.score.as_ref().filter(|_| plateau > MOST_EQUAL) {
        warnings.push(format!(
            "`{}` is the same in {} of the first runs: it does not slope towards the event, and what nothing leads to is found by luck",
            score.label(),
            percent(plateau)
        ));
    }
    if told.undecided > 0 {
        warnings.push(format!(
            "{} runs say neither that `{}` nor the opposite, or ended before; they count as if it were so",
            told.undecided, block.event_text
        ));
    }
    warnings
}

/// A claim holds where its one-sided bound shows it, is wrong where the bound from the other side shows that, and else open.
fn decide(
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

fn judged(
    claim: &EstimateClaim,
    exposure: Option<&Exposure>,
    (lower, upper): (f64, f64),
    of: &str,
) -> (Verdict, String) {
    // Of events along a distance it holds with the most encounters that there may be, and is wrong only with the fewest.
    let along = claim.per_1000_km.zip(exposure);
    let (low, high, bound, what) = match along {
        Some((events, exposure)) => {
            (lower * exposure.low, upper * exposure.high, events, "events in 1,000 km are")
        }
        None => (lower, upper, claim.at_most, "the probability is"),
    };
    let verdict = if high <= bound {
        Verdict::Passed
    } else if low > bound {
        Verdict::Failed
    } else {
        Verdict::Inconclusive
    };
    let said = match verdict {
        Verdict::Passed => format!("{of} {what} at most {}", number(high)),
        Verdict::Failed => format!("{of} {what} at least {}", number(low)),
        Verdict::Inconclusive => {
            format!("{of} {what} at least {}, and at most {} by as much", number(low), number(high))
        }
    };
    (verdict, said)
}
