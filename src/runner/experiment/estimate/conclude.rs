//! What an estimate comes to, in numbers and words.

use std::borrow::Cow;

use super::compared::Comparison;
use super::scored_run::ScoredEncounter;
use crate::experiment::context::Context;
use crate::experiment::error::ExperimentError;
use crate::plan::Cases;
use numbers::rare::{
    CONTRADICTION, LARGEST_DEVIATION, LARGEST_SHARE, LEAST_EFFECTIVE, PairedEvent, PairedRareEstimate,
    RareEstimate, RareRefusal, RareSampling, RareScale, RareSpace, ReplicateRuns, WeighedHit,
};
use results::{
    ComparedEstimate, EstimateResult, EstimatedClaim, EstimatedCluster, EstimatedRun, EventsPerDistance,
    Verdict,
};
use scenario::{Estimate, EstimateClaim, EstimateClaimOf, EstimateMethod, Exposure, significant};

/// Of the interval and the bound that are always said.
pub(super) const CONFIDENCE: f64 = 0.95;
/// Weights of the tail that are kept.
const MOST_SHARES: usize = 100;
/// Runs that are named.
pub(super) const MOST_RUNS: usize = 10;
/// Less of the estimate is no group of hits.
const LEAST_CLUSTER: f64 = 1e-4;
/// More runs that were not seen to their end, and nothing is claimed of what they would have come to.
const MOST_CUT_OFF: f64 = 0.5;
/// More runs as far from the event as another, and the score does not slope.
const MOST_EQUAL: f64 = 0.5;

/// What was told of encounters.
#[derive(Debug, Default)]
pub struct Told {
    /// Which of two had the event, by the numbers of their runs.
    events: Vec<PairedEvent>,
    pilot: usize,
    undecided: usize,
    cut_off: usize,
    undecided_others: usize,
    cut_off_others: usize,
}

impl Told {
    pub fn add(&mut self, is_pilot: bool, seen: &[ScoredEncounter]) {
        self.events.extend(seen.iter().map(|one| one.event()));
        if is_pilot {
            self.pilot += seen.len();
        } else {
            let others = || seen.iter().filter_map(|one| one.other);
            self.undecided += seen.iter().filter(|one| one.own.undecided).count();
            self.cut_off += seen.iter().filter(|one| one.own.cut_off).count();
            self.undecided_others += others().filter(|one| one.undecided).count();
            self.cut_off_others += others().filter(|one| one.cut_off).count();
        }
    }

    /// How many there were.
    pub fn encounters(&self) -> usize {
        self.events.len()
    }

    /// Of the scenario that is compared with: runs of which it cannot be said, and such as were not seen to their end.
    pub fn open_others(&self) -> (usize, usize) {
        (self.undecided_others, self.cut_off_others)
    }

    /// Why nothing that is claimed is shown, whatever the numbers are: most runs of the scenario were not seen to their end.
    fn nothing_seen(&self, cut_off: usize, scenario: &str) -> Option<String> {
        let counted = self.encounters() - self.pilot;
        (cut_off as f64 > MOST_CUT_OFF * counted as f64).then(|| {
            format!(
                "{cut_off} of {counted} runs of `{scenario}` ended before the end of what the event is about was seen: raise its `horizon`"
            )
        })
    }
}

/// All runs of an estimate.
pub struct Sampled<'a> {
    pub cases: &'a Cases,
    /// Of the scenario that it is compared with, in the same encounters.
    pub others: Option<&'a Cases>,
    pub space: &'a RareSpace,
    pub method: &'a dyn RareSampling,
    pub scale: RareScale,
    pub told: &'a Told,
}

impl Sampled<'_> {
    /// What the replicates say so far of the estimate's own scenario.
    pub fn own_replicates(&self) -> Cow<'_, [ReplicateRuns]> {
        let replicates = self.method.replicates();
        if self.others.is_none() {
            return replicates.into();
        }
        replicates.iter().map(|one| one.only(|run| self.had(run).first)).collect()
    }

    /// The estimate of the replicates that there are, and where it lies at 95 %, once there are several.
    pub fn so_far(&self) -> Option<(f64, (f64, f64))> {
        if self.method.replicates().len() < 2 {
            return None;
        }
        let so_far = RareEstimate::of(self.space, &self.own_replicates(), self.scale);
        let interval = so_far.interval(CONFIDENCE);
        Some((so_far.value, (interval.low, interval.high)))
    }

    /// Which of two had the event in the run of that number.
    pub fn had(&self, run: usize) -> PairedEvent {
        self.told.events[run]
    }

    fn paired(&self) -> PairedRareEstimate {
        PairedRareEstimate::of(self.space, self.method.replicates(), self.scale, |run| self.had(run))
    }
}

/// Hits of replicates, each with what it weighs in their mean.
pub struct Hits<'a> {
    hits: Vec<(&'a WeighedHit, f64)>,
    sum: f64,
}

impl<'a> Hits<'a> {
    /// What the weights are shares of is what all of these weigh.
    pub fn of(replicates: &'a [ReplicateRuns]) -> Self {
        let of = |one: &'a ReplicateRuns| {
            one.hits.iter().map(move |hit| (hit, hit.weight / one.runs as f64)).collect::<Vec<_>>()
        };
        let hits: Vec<_> = replicates.iter().flat_map(of).collect();
        let sum = hits.iter().map(|one| one.1).sum();
        Self { hits, sum }
    }

    /// The indices of those that it holds for by the numbers of their runs, the heaviest first.
    pub fn heaviest(&self, holds: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut found: Vec<usize> =
            (0..self.hits.len()).filter(|index| holds(self.hits[*index].0.run)).collect();
        found.sort_by(|one, other| self.hits[*other].1.total_cmp(&self.hits[*one].1).then(one.cmp(other)));
        found
    }

    fn share(&self, index: usize) -> f64 {
        self.hits[index].1 / self.sum
    }

    /// The run that made it, of these cases.
    pub fn run(&self, index: usize, cases: &Cases) -> Result<EstimatedRun, ExperimentError> {
        let hit = self.hits[index].0;
        let case = cases.at(hit.chance, &hit.point)?;
        let drawn = case.drawn.into_iter().map(|one| (one.name, one.label)).collect();
        Ok(EstimatedRun { key: case.key, share: self.share(index), drawn })
    }
}

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
    let nothing_seen = told.nothing_seen(told.cut_off, &block.scenario);
    let nothing_seen_there =
        block.compared_with.as_ref().and_then(|with| told.nothing_seen(told.cut_off_others, with));
    let refusals = estimate.refusals.iter().map(|one| in_words(one, &estimate));
    let refusals: Vec<String> = refusals.chain(nothing_seen.clone()).collect();
    let exposure = block.exposure.as_ref();
    let cut_off: Vec<String> = nothing_seen.iter().chain(&nothing_seen_there).cloned().collect();
    let comparison = paired.as_ref().map(|(others, paired)| Comparison::new(block, others, paired, &cut_off));
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

/// A probability or a difference: with three digits, and with a power of ten where it is small.
pub(super) fn number(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-2 { format!("{value:.2e}") } else { significant(value, 3) }
}

pub(super) fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 3))
}

pub(super) fn in_words(refusal: &RareRefusal, estimate: &RareEstimate) -> String {
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
    if told.undecided > 0 {
        warnings.push(format!(
            "{} runs say neither that `{}` nor the opposite, or ended before; they count as if it were so",
            told.undecided, block.event_text
        ));
    }
    let counted = told.encounters() - told.pilot;
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

/// A claim of which nothing is shown.
fn open(claim: &EstimateClaim, reason: String) -> EstimatedClaim {
    let EstimateClaim { guaranteed, text, .. } = claim;
    EstimatedClaim { text: text.clone(), guaranteed: *guaranteed, verdict: Verdict::Inconclusive, reason }
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

/// `of` says what the bounds are of, and by what.
pub(super) fn judged(
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
