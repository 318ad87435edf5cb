//! What an estimate comes to, in numbers and words.

use super::compared::Compared;
use super::judged::{decide, in_words, open, percent};
use super::sampled::{CONFIDENCE, Hits, MOST_RUNS, Sampled, Told};
use crate::experiment::context::Context;
use crate::experiment::error::ExperimentError;
use numbers::rare::{RareEstimate, RareSampling};
use results::{ComparedEstimate, EstimateResult, EstimatedCluster, EventsPerDistance, NO_ENCOUNTER};
use scenario::{Estimate, EstimateClaimOf, EstimateMethod};

/// Weights of the tail that are kept.
const MOST_SHARES: usize = 100;
/// Less of the estimate is no group of hits.
const LEAST_CLUSTER: f64 = 1e-4;
/// More runs as far from the event as another, and the score does not slope.
const MOST_EQUAL: f64 = 0.5;

pub fn conclude(
    context: &Context,
    block: &Estimate,
    sampled: &Sampled,
) -> Result<EstimateResult, ExperimentError> {
    let Sampled { cases, others, space, method, scale, told } = *sampled;
    let replicates = sampled.own_replicates();
    let paired = others.map(|others| (others, context.executor.think(|| sampled.paired())));
    let estimate = match &paired {
        Some((_, paired)) => paired.first.clone(),
        None => context.executor.think(|| RareEstimate::of(space, &replicates, scale)),
    };
    let hits = Hits::of(&replicates);
    let heaviest = hits.heaviest(|_| true);
    let carrying = heaviest.iter().take(MOST_RUNS).map(|index| hits.run(*index, cases));
    let carrying = carrying.collect::<Result<Vec<_>, _>>()?;
    let seen = estimate.clusters.iter().filter(|one| one.0 >= LEAST_CLUSTER);
    let cluster =
        |(share, index): &(f64, usize)| Ok(EstimatedCluster { share: *share, run: hits.run(*index, cases)? });
    let clusters: Vec<EstimatedCluster> =
        seen.take(MOST_RUNS).map(cluster).collect::<Result<_, ExperimentError>>()?;
    let of_nothing = |which: usize, scenario: &str| {
        sampled.nothing_seen(which, scenario).or_else(|| sampled.nothing_met(which, scenario))
    };
    let nothing_seen = of_nothing(0, &block.scenario);
    let nothing_seen_there = block.compared_with.as_ref().and_then(|with| of_nothing(1, with));
    let refusals = estimate.refusals.iter().map(|one| in_words(one, &estimate));
    let refusals: Vec<String> = refusals.chain(nothing_seen.clone()).collect();
    let exposure = block.exposure.as_ref();
    let cut_off: Vec<String> = nothing_seen.iter().chain(&nothing_seen_there).cloned().collect();
    let comparison = paired.as_ref().map(|(others, paired)| Compared::new(block, others, paired, &cut_off));
    let claims = block.claims.iter().map(|claim| match (claim.of, &comparison) {
        (EstimateClaimOf::Probability, _) | (_, None) => match &nothing_seen {
            Some(why) => open(claim, why.clone()),
            None => decide(claim, exposure, &estimate, &refusals),
        },
        (_, Some(comparison)) => match cut_off.first() {
            Some(why) => open(claim, why.clone()),
            None => comparison.decide(claim, exposure),
        },
    });
    let claims = claims.collect();
    let compared = comparison.map(|comparison| comparison.result(sampled)).transpose()?;
    let (guaranteed, unseen) = (estimate.guaranteed(CONFIDENCE), estimate.unseen(CONFIDENCE));
    let interval = estimate.interval(CONFIDENCE);
    let of_each = if others.is_some() { 2 } else { 1 };
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
        runs: of_each * told.encounters(),
        pilot_runs: of_each * told.pilot,
        replicates: replicates.iter().map(|one| one.probability).collect(),
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
        cut_off: told.cut_off,
        encounters: told.met,
        left_out: told.left_out_of_counted(),
        effective_size: estimate.effective_size,
        largest_share: estimate.largest_share,
        contradiction: estimate.contradiction,
        refusals,
        warnings: warnings(block, method, told, compared.as_ref()),
        shares: heaviest.iter().take(MOST_SHARES).map(|index| hits.share(*index)).collect(),
        clusters,
        carrying,
        claims,
        compared,
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

fn warnings(
    block: &Estimate,
    method: &dyn RareSampling,
    told: &Told,
    compared: Option<&ComparedEstimate>,
) -> Vec<String> {
    let mut warnings = Vec::new();
    let plateau = method.plateau();
    if let Some(score) = block.score.as_ref().filter(|_| plateau > MOST_EQUAL) {
        warnings.push(format!(
            "`{}` is the same in {} of the first runs: it does not slope towards the event, and what nothing leads to is found by luck",
            score.label(),
            percent(plateau)
        ));
    }
    if !told.left_out.is_empty() {
        warnings.push(format!(
            "{} of {} encounters are left out, since they cannot be: {NO_ENCOUNTER}; the probability is of the others",
            told.left_out.len(),
            told.encounters()
        ));
    }
    if told.undecided > 0 {
        warnings.push(format!(
            "{} runs say neither that `{}` nor the opposite, or ended before; they count as if it were so",
            told.undecided, block.event_text
        ));
    }
    let counted = told.counted();
    let cut_off = |runs: usize, scenario: &str| {
        format!(
            "{runs} of {counted} runs of `{scenario}` ended before the end of what `{}` is about was seen; they count as if it were not so",
            block.event_text
        )
    };
    if told.cut_off > 0 {
        warnings.push(cut_off(told.cut_off, &block.scenario));
    }
    let Some(compared) = compared else { return warnings };
    if compared.undecided > 0 {
        warnings.push(format!(
            "{} runs of `{}` say neither that `{}` nor the opposite, or ended before; they count as if it were not so",
            compared.undecided, compared.scenario, block.event_text
        ));
    }
    if told.cut_off_others > 0 {
        warnings.push(cut_off(told.cut_off_others, &compared.scenario));
    }
    if compared.differs.is_empty() {
        warnings.push(format!(
            "nothing that is simulated differs between `{}` and `{}`",
            block.scenario, compared.scenario
        ));
    }
    warnings
}
