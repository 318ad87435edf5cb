//! Each criterion of a trial against the trial's outcomes.

use super::confidence::{self, Bounds};
use super::horizon;
use super::nearest::nearest;
use super::not_as_declared::{left_road, never_began, outlasted};
use super::overlap;
use super::possible::bounded_above;
use super::seen::{Evidence, Seen};
use super::untested;
use crate::{Finding, FindingMeasure, Horizon, Outcome, Regarding, Requests, TrialVerdict, Verdict};
use scenario::{
    Absence, Aggregate, AggregateBounds, AggregateResponse, Claim, Comparison, Criterion, Individual, Metric,
    MetricReference, People, Relation, WhenUndefined, Worst, constant,
};

/// Judges one trial. `requests` says which metric is where in the outcomes.
pub fn judge(criteria: &[Criterion], outcomes: &[Outcome], requests: &Requests) -> TrialVerdict {
    let evidence = Evidence { outcomes, requests, bounds: Bounds::Fixed };
    let findings = criteria.iter().map(|criterion| find(criterion, &evidence)).collect();
    TrialVerdict::of(findings, criteria, &evidence)
}

impl TrialVerdict {
    /// Whether no criterion applied, so that nothing was claimed of its runs: they speak for nothing.
    pub fn claims_nothing(&self) -> bool {
        self.findings.is_empty()
    }

    /// Of a trial whose runs were fixed beforehand.
    pub(super) fn of(mut findings: Vec<Finding>, criteria: &[Criterion], evidence: &Evidence) -> Self {
        let Evidence { outcomes, requests, .. } = *evidence;
        untested::mark(&mut findings, criteria, outcomes, requests);
        overlap::mark(&mut findings, criteria, outcomes, requests);
        let horizon = Horizon::of(outcomes);
        horizon::mark(&mut findings, criteria, outcomes);
        mark_alike(&mut findings, outcomes);
        let verdict = findings.iter().map(|finding| finding.verdict).max().unwrap_or(Verdict::Passed);
        let never_began = never_began(outcomes);
        let left_road = left_road(criteria, outcomes);
        let outlasted = outlasted(outcomes);
        Self { verdict, findings, stopping: None, horizon, never_began, left_road, outlasted }
    }
}

/// So many runs are the same by chance in one of twenty experiments at most, where one in seven would be another.
const BEYOND_COINCIDENCE: usize = 20;

/// Marks the findings with confidence whose runs are all the same.
fn mark_alike(findings: &mut [Finding], outcomes: &[Outcome]) {
    let same = |pair: &[Outcome]| pair[0].fingerprint == pair[1].fingerprint;
    let alike = outcomes.len() >= BEYOND_COINCIDENCE && outcomes.windows(2).all(same);
    for finding in findings.iter_mut().filter(|finding| finding.confidence.is_some()) {
        finding.alike = alike;
    }
}

/// Whose run each is, by number in order of appearance; runs of nobody in particular are all of one.
fn whose(outcomes: &[Outcome]) -> Vec<usize> {
    let mut known: Vec<&[Individual]> = Vec::new();
    outcomes
        .iter()
        .map(|outcome| {
            let same = |people: &&[Individual]| {
                people.len() == outcome.individuals.len()
                    && people.iter().zip(&outcome.individuals).all(|(one, other)| {
                        (&one.pedestrian, &one.population, one.number)
                            == (&other.pedestrian, &other.population, other.number)
                    })
            };
            known.iter().position(same).unwrap_or_else(|| {
                known.push(&outcome.individuals);
                known.len() - 1
            })
        })
        .collect()
}

/// One criterion against the evidence.
pub(super) fn find(criterion: &Criterion, evidence: &Evidence) -> Finding {
    if criterion.claim.confidence().is_none() {
        return found(criterion, evidence);
    }
    if criterion.reach.drawn_people {
        // Each run is of somebody else, drawn with replacement: of all people, and independent of the others.
        let regarding = Regarding { whom: People::All, people: evidence.outcomes.len(), drawn: true };
        return Finding { people: Some(regarding), ..found(criterion, evidence) };
    }
    let whose = whose(evidence.outcomes);
    let people = whose.iter().max().map_or(0, |last| last + 1);
    let named = evidence.outcomes.iter().any(|outcome| !outcome.individuals.is_empty());
    let whom = criterion.reach.people.unwrap_or(People::These);
    let bounds = if whom == People::All { Bounds::People(&whose) } else { evidence.bounds };
    Finding {
        people: named.then_some(Regarding { whom, people, drawn: false }),
        ..found(criterion, &Evidence { bounds, ..*evidence })
    }
}

fn found(criterion: &Criterion, evidence: &Evidence) -> Finding {
    let Evidence { outcomes, bounds, .. } = *evidence;
    match &criterion.claim {
        Claim::Runs { comparison, share, confidence } => {
            runs(criterion, comparison, *share, *confidence, evidence)
        }
        Claim::Aggregate { aggregate, relation, bound, when_undefined, confidence } => {
            let bound = constant(bound);
            match aggregate {
                Aggregate::Rate(comparison) => {
                    let held = holding(comparison, bounded_above(*relation), evidence);
                    let rate = held.count as f64 / outcomes.len() as f64;
                    let finding =
                        against(criterion, FindingMeasure::Share, *relation, bound, Some(rate), &held);
                    let finding = with_confidence_in_share(finding, *relation, *confidence, &held, bounds);
                    let finding = exactly(finding, *relation, outcomes.len() as f64, comparison, evidence);
                    with_worst_of_rate(finding, comparison, *relation, &held, evidence)
                }
                Aggregate::Count(comparison) => {
                    let held = holding(comparison, bounded_above(*relation), evidence);
                    let count = held.count as f64;
                    let finding =
                        against(criterion, FindingMeasure::Count, *relation, bound, Some(count), &held);
                    let finding = exactly(finding, *relation, 1.0, comparison, evidence);
                    with_worst_of_rate(finding, comparison, *relation, &held, evidence)
                }
                of_each => {
                    of_values(criterion, of_each, (*relation, bound), *confidence, *when_undefined, evidence)
                }
            }
        }
    }
}

/// An aggregate of the metric's values against a bound.
///
/// Runs without a value, and those that the horizon cut off, count as what speaks most against the criterion, which ranks
/// take exactly; where nothing bounds that, a mean or a spread is not known.
fn of_values(
    criterion: &Criterion,
    aggregate: &Aggregate,
    (relation, bound): (Relation, f64),
    confidence: Option<f64>,
    when_undefined: WhenUndefined,
    evidence: &Evidence,
) -> Finding {
    let metric = aggregate.metric();
    let seen = seen(metric, evidence);
    let counted: Vec<Option<f64>> = seen.iter().map(|one| one.worst(metric, relation)).collect();
    let worst: Vec<f64> = counted.iter().copied().flatten().collect();
    let held = Held { count: seen.iter().filter(|one| one.is_value()).count(), against: Vec::new(), seen };
    let response = aggregate.response();
    let known = response == AggregateResponse::Ranked || worst.iter().all(|value| value.is_finite());
    // Which of the values that are possible is the worst for a spread, nobody knows.
    let undecided = held.cut_off() > 0
        && (matches!(relation, Relation::Equal | Relation::NotEqual)
            || response == AggregateResponse::Spread);
    let observed = if known {
        aggregate_of(aggregate, worst)
    } else {
        aggregate_of(aggregate, held.seen.iter().filter_map(|one| one.value()).collect())
    };
    let mut finding = against(criterion, FindingMeasure::Value, relation, bound, observed, &held);
    if let (Some(confidence), Some(_)) = (confidence, observed) {
        let seed = evidence.outcomes.first().map_or(0, |outcome| outcome.seed);
        let limits = criterion.reach.limits;
        let interval =
            known.then(|| evidence.bounds.of_values(aggregate, &counted, limits, confidence, seed)).flatten();
        finding.approximate = aggregate.bounds() == AggregateBounds::Mean && limits.is_none();
        finding.interval = interval.map(|interval| (interval.low, interval.high));
        finding.verdict =
            interval.map_or(Verdict::Inconclusive, |interval| confidence::decide(relation, interval, bound));
    }
    if undecided || !known {
        let best: Option<Vec<f64>> = held.seen.iter().map(|one| one.best(relation)).collect();
        let best = best
            .filter(|_| !undecided && confidence.is_none())
            .and_then(|best| aggregate_of(aggregate, best));
        // Where even the best that is possible is not good enough, nothing is open.
        let failed = best.is_some_and(|best| !relation.holds(best, bound));
        finding.verdict = if failed { Verdict::Failed } else { Verdict::Inconclusive };
        finding.margin = None;
    }
    if observed.is_none() && when_undefined == WhenUndefined::Passes && held.cut_off() == 0 {
        finding.verdict = Verdict::Passed;
    }
    let values = held.values();
    let cut_off = |index: usize| held.seen[index].is_open();
    // A run that is left out speaks against nothing, unless none is left.
    let counts = |index: usize| observed.is_none() || counted[index].is_some();
    finding.worst = nearest(metric, (relation, bound), &values, evidence, cut_off, counts).0;
    finding
}

/// That the number of runs that hold, by `unit`, is exactly something or not is only decided where no run is left of which
/// nobody can know.
fn exactly(
    finding: Finding,
    relation: Relation,
    unit: f64,
    comparison: &Comparison,
    evidence: &Evidence,
) -> Finding {
    if !matches!(relation, Relation::Equal | Relation::NotEqual) {
        return finding;
    }
    let number = |unknown| holding(comparison, unknown, evidence).count as f64 / unit;
    let (least, most) = (number(false), number(true));
    let possible = least <= finding.bound && finding.bound <= most;
    if least == most || !possible {
        return finding;
    }
    Finding { verdict: Verdict::Inconclusive, ..finding }
}

/// Where a confidence is stated, the verdict rests on the bounds of the share and not on the share that was seen.
fn with_confidence_in_share(
    finding: Finding,
    relation: Relation,
    confidence: Option<f64>,
    held: &Held,
    bounds: Bounds,
) -> Finding {
    let Some(confidence) = confidence else { return finding };
    let interval = bounds.of_share(&held.against, confidence);
    Finding {
        verdict: confidence::decide(relation, interval, finding.bound),
        interval: Some((interval.low, interval.high)),
        ..finding
    }
}

/// An aggregate over runs; `None` where it does not exist. For rates and counts a run whose metric does not exist counts
/// as its comparison says.
pub fn aggregate(aggregate: &Aggregate, outcomes: &[Outcome], requests: &Requests) -> Option<f64> {
    let evidence = Evidence { outcomes, requests, bounds: Bounds::Fixed };
    match aggregate {
        Aggregate::Rate(comparison) => {
            let held = holding(comparison, false, &evidence).count;
            (!outcomes.is_empty()).then(|| held as f64 / outcomes.len() as f64)
        }
        Aggregate::Count(comparison) => Some(holding(comparison, false, &evidence).count as f64),
        _ => aggregate_of(
            aggregate,
            values(aggregate.metric(), outcomes, requests).into_iter().flatten().collect(),
        ),
    }
}

/// What every run counts as for a claim that an aggregate of a metric's values is in `relation` to a bound, one per run; `None`
/// for a run that is left out.
fn counted(
    metric: &MetricReference,
    relation: Relation,
    outcomes: &[Outcome],
    requests: &Requests,
) -> Vec<Option<f64>> {
    let seen = seen(metric, &Evidence { outcomes, requests, bounds: Bounds::Fixed });
    seen.into_iter().map(|one| one.worst(metric, relation)).collect()
}

/// As [`aggregate`], for somebody who would like it to be in `relation` to something: runs that the horizon cut off, or in
/// which the metric does not exist, count as what speaks most against that. `None` where nothing bounds it.
pub fn aggregate_against(
    wanted: &Aggregate,
    relation: Relation,
    outcomes: &[Outcome],
    requests: &Requests,
) -> Option<f64> {
    aggregate_of_counted(wanted, relation, outcomes, requests, || {
        counted(wanted.metric(), relation, outcomes, requests)
    })
}

/// As [`aggregate_against`], of an objective: what is best where it does not exist, and else the worse the larger it is, such as the speed of
/// an impact, counts as 0 where it is to be small. With what every run counts as.
pub fn objective_against(
    wanted: &Aggregate,
    relation: Relation,
    outcomes: &[Outcome],
    requests: &Requests,
) -> (Option<f64>, Vec<Option<f64>>) {
    let mut counted = counted(wanted.metric(), relation, outcomes, requests);
    if bounded_above(relation) && wanted.metric().known().is_some_and(counts_as_none) {
        counted.iter_mut().for_each(|one| *one = one.or(Some(0.0)));
    }
    let value = aggregate_of_counted(wanted, relation, outcomes, requests, || counted.clone());
    (value, counted)
}

/// Whether a metric that does not exist in a run is as good as 0.
pub(super) fn counts_as_none(metric: &Metric) -> bool {
    metric.absence == Absence::Good && metric.worst == Worst::Largest
}

fn aggregate_of_counted(
    wanted: &Aggregate,
    relation: Relation,
    outcomes: &[Outcome],
    requests: &Requests,
    counted: impl FnOnce() -> Vec<Option<f64>>,
) -> Option<f64> {
    let evidence = Evidence { outcomes, requests, bounds: Bounds::Fixed };
    let holds = |comparison| holding(comparison, bounded_above(relation), &evidence).count as f64;
    let value = match wanted {
        Aggregate::Rate(_) if outcomes.is_empty() => None,
        Aggregate::Rate(comparison) => Some(holds(comparison) / outcomes.len() as f64),
        Aggregate::Count(comparison) => Some(holds(comparison)),
        of_values
            if of_values.response() == AggregateResponse::Spread
                && seen(of_values.metric(), &evidence).iter().any(|one| one.is_open()) =>
        {
            None
        }
        of_values => aggregate_of(of_values, counted().into_iter().flatten().collect()),
    };
    value.filter(|value| value.is_finite())
}

/// Runs without a value of a metric that is decided: it does not exist, or the horizon ended them before.
pub fn undecided(metric: &MetricReference, outcomes: &[Outcome], requests: &Requests) -> usize {
    let seen = seen(metric, &Evidence { outcomes, requests, bounds: Bounds::Fixed });
    seen.iter().filter(|one| !one.is_value()).count()
}

/// What every run says of a metric, and in how many runs a comparison over it holds.
struct Held {
    count: usize,
    /// Whether the comparison holds, run by run; empty where there is none.
    against: Vec<bool>,
    seen: Vec<Seen>,
}

impl Held {
    fn undefined(&self) -> usize {
        self.seen.iter().filter(|one| matches!(one, Seen::Undefined)).count()
    }

    fn cut_off(&self) -> usize {
        self.seen.iter().filter(|one| one.is_open()).count()
    }

    fn values(&self) -> Vec<Option<f64>> {
        self.seen.iter().map(|one| one.so_far()).collect()
    }
}

fn runs(
    criterion: &Criterion,
    comparison: &Comparison,
    share: Option<f64>,
    confidence: Option<f64>,
    evidence: &Evidence,
) -> Finding {
    let Evidence { outcomes, bounds, .. } = *evidence;
    let held = holding(comparison, false, evidence);
    let bound = comparison.constant_bound();
    let rate = held.count as f64 / outcomes.len() as f64;
    let mut finding = match share {
        Some(share) => {
            let finding =
                against(criterion, FindingMeasure::Share, Relation::GreaterOrEqual, share, Some(rate), &held);
            with_confidence_in_share(finding, Relation::GreaterOrEqual, confidence, &held, bounds)
        }
        None => {
            against(criterion, FindingMeasure::EveryRun, Relation::GreaterOrEqual, 1.0, Some(rate), &held)
        }
    };
    if share.is_none() {
        // The run nearest to failing says more than the share of runs.
        let margins = held.seen.iter().filter_map(|one| {
            comparison.relation.margin(one.worst(&comparison.metric, comparison.relation)?, bound)
        });
        let margins = margins.filter(|margin| margin.is_finite());
        finding.margin = margins.reduce(f64::min);
    }
    let wanted = (comparison.relation, bound);
    let cut_off = |index: usize| held.seen[index].is_open();
    let (worst, closest) =
        nearest(&comparison.metric, wanted, &held.values(), evidence, cut_off, |index| !held.against[index]);
    Finding { worst, closest, ..finding }
}

/// Names the runs that a rate or count has too many of: those that hold where it is bounded above, else the others.
fn with_worst_of_rate(
    finding: Finding,
    comparison: &Comparison,
    relation: Relation,
    held: &Held,
    evidence: &Evidence,
) -> Finding {
    let bound = comparison.constant_bound();
    let too_many_hold = bounded_above(relation);
    let against = |index: usize| held.against[index] == too_many_hold;
    let cut_off = |index: usize| held.seen[index].is_open();
    let direction = if too_many_hold { comparison.relation.opposite() } else { comparison.relation };
    let (worst, closest) =
        nearest(&comparison.metric, (direction, bound), &held.values(), evidence, cut_off, against);
    Finding { worst, closest, ..finding }
}

/// A finding that compares `observed` to `bound`.
fn against(
    criterion: &Criterion,
    measure: FindingMeasure,
    relation: Relation,
    bound: f64,
    observed: Option<f64>,
    held: &Held,
) -> Finding {
    let holds = observed.is_some_and(|value| relation.holds(value, bound));
    Finding {
        criterion: criterion.text.clone(),
        origin: criterion.origin.clone(),
        verdict: if holds { Verdict::Passed } else { Verdict::Failed },
        metric: criterion.claim.metric().metric.clone(),
        measure,
        runs: held.seen.len(),
        holding: held.count,
        undefined: held.undefined(),
        cut_off: held.cut_off(),
        unseen: 0,
        observed,
        bound,
        margin: observed.and_then(|value| relation.margin(value, bound)),
        interval: None,
        confidence: criterion.claim.confidence(),
        alike: false,
        approximate: false,
        people: None,
        worst: Vec::new(),
        closest: None,
        overlapping: 0,
        tested: None,
        untested: None,
    }
}

/// `unknown` says whether the comparison counts as holding where nobody can know.
fn holding(comparison: &Comparison, unknown: bool, evidence: &Evidence) -> Held {
    let seen = seen(&comparison.metric, evidence);
    let against: Vec<bool> = seen.iter().map(|one| one.holds(comparison, unknown)).collect();
    Held { count: against.iter().filter(|holds| **holds).count(), against, seen }
}

fn seen(metric: &MetricReference, evidence: &Evidence) -> Vec<Seen> {
    let index = index_of(metric, evidence.requests);
    evidence.outcomes.iter().map(|outcome| Seen::of(outcome, index)).collect()
}

fn index_of(metric: &MetricReference, requests: &Requests) -> usize {
    requests.index(metric).expect("every criterion's metric was requested before the runs")
}

fn values(metric: &MetricReference, outcomes: &[Outcome], requests: &Requests) -> Vec<Option<f64>> {
    let index = index_of(metric, requests);
    outcomes.iter().map(|outcome| outcome.metrics[index]).collect()
}

/// `None` where the aggregate does not exist: of no values, or the spread of one.
pub(super) fn aggregate_of(aggregate: &Aggregate, mut values: Vec<f64>) -> Option<f64> {
    // Sorted, so that sums do not depend on the order of the runs.
    values.sort_by(f64::total_cmp);
    aggregate.of_sorted(&values)
}
