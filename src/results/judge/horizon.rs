//! Runs that ended before everything was seen: how many, who had not arrived, who was about to touch, and which criteria
//! that leaves untested.

use crate::{CourseOfRun, Finding, Horizon, Outcome, Stranded, Untested, Verdict};
use scenario::{Claim, Criterion, MetricReference, Relation, Scope, WhenUndefined, Worst};
use sim::StopReason;

impl Horizon {
    /// `None` where the horizon ended no run.
    pub fn of(outcomes: &[Outcome]) -> Option<Self> {
        let all = || outcomes.iter().filter(|outcome| outcome.ending.reason == StopReason::Horizon);
        let cut_off = || all().filter_map(|outcome| Some((&outcome.key, outcome.cut_off.as_ref()?)));
        let stranded = cut_off()
            .filter(|(_, cut_off)| !cut_off.stranded.is_empty())
            .map(|(key, cut_off)| Stranded { key: key.clone(), who: cut_off.stranded.clone() });
        let on_course = cut_off().flat_map(|(key, cut_off)| {
            let courses = cut_off.on_course.iter();
            courses.map(|course| CourseOfRun { key: key.clone(), course: course.clone() })
        });
        let mut horizon = Self {
            runs: all().count(),
            of: outcomes.len(),
            stranded: stranded.collect(),
            on_course: on_course.collect(),
        };
        // There may be a trial for every run.
        horizon.stranded.shrink_to_fit();
        horizon.on_course.shrink_to_fit();
        (horizon.runs > 0).then_some(horizon)
    }
}

/// Metrics that are what was seen so far at any time, and that what comes later may make worse.
const EXTREMES: [&str; 13] = [
    "collision",
    "impact_speed",
    "min_distance",
    "min_ttc",
    "drac",
    "time_headway",
    "max_deceleration",
    "sudden_speed_change",
    "max_jerk",
    "rms_jerk",
    "lateral_acceleration",
    "vehicle_distance",
    "vehicle_ttc",
];

/// Says of each finding in how many runs the end of what it is about was not seen, because the horizon or somebody else's contact
/// ended them, and marks those that passed although there are any.
pub(super) fn mark(findings: &mut [Finding], criteria: &[Criterion], outcomes: &[Outcome]) {
    if outcomes.iter().all(|outcome| outcome.cut_off.is_none()) {
        return;
    }
    for (finding, criterion) in findings.iter_mut().zip(criteria) {
        if stays_so(&criterion.claim) {
            continue;
        }
        finding.unseen = cut_off_runs(criterion.claim.metric(), outcomes);
        if finding.unseen > 0 && finding.verdict == Verdict::Passed && finding.untested.is_none() {
            finding.untested = Some(Untested::CutOff);
        }
    }
}

/// In how many runs the end of what a metric measures was not seen.
pub fn cut_off_runs<'o>(
    reference: &MetricReference,
    outcomes: impl IntoIterator<Item = &'o Outcome>,
) -> usize {
    outcomes.into_iter().filter(|outcome| cut_off_of(reference, outcome)).count()
}

/// Whether the end of what a metric measures was not seen: somebody whom it is about was on a collision course, or could still
/// be met and it is an extreme of what was seen so far.
pub(super) fn cut_off_of(reference: &MetricReference, outcome: &Outcome) -> bool {
    let Some(cut_off) = &outcome.cut_off else { return false };
    let Some(metric) = reference.known() else { return false };
    let is_extreme = EXTREMES.contains(&reference.name());
    let of_vehicle = metric.scope == Scope::Vehicle;
    let meets = matches!(metric.scope, Scope::Pair | Scope::Stream | Scope::Contact | Scope::Vehicles)
        || (of_vehicle && is_extreme);
    let concerns = |one: &str, two: &str| {
        reference.pair.as_ref().is_none_or(|(_, other)| {
            let is_named = |name: &str| reference.is_of_vehicle(name);
            (is_named(one) && (of_vehicle || reference.is_of(two)))
                || (is_named(two) && (of_vehicle || (!other.is_empty() && reference.is_of(one))))
        })
    };
    let mut courses = cut_off.on_course.iter();
    let mut unfinished = cut_off.unfinished.iter();
    meets
        && (courses.any(|pair| concerns(&pair.vehicle, &pair.with))
            || (is_extreme && unfinished.any(|pair| concerns(&pair.vehicle, &pair.pedestrian))))
}

/// Whether a claim that every run has an extreme beyond a bound stays true whatever comes: extremes only grow.
fn stays_so(claim: &Claim) -> bool {
    let Claim::Runs { comparison, .. } = claim else { return false };
    let name = comparison.metric.name();
    // A mean over the run may go either way.
    if !EXTREMES.contains(&name) || name == "rms_jerk" {
        return false;
    }
    let upwards = match comparison.relation {
        Relation::Greater | Relation::GreaterOrEqual => true,
        Relation::Less | Relation::LessOrEqual => false,
        Relation::Equal => return name == "collision" && comparison.constant_bound() == 1.0,
        Relation::NotEqual => return name == "collision" && comparison.constant_bound() == 0.0,
    };
    comparison.metric.known().is_some_and(|metric| upwards == (metric.worst == Worst::Largest))
        && comparison.when_undefined != WhenUndefined::Passes
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::judge::judge;
    use crate::{CutOff, Requests};
    use scenario::{Aggregate, Comparison, Origin};
    use sim::Ending;
    use sim::measure::Open;

    /// The only metric was not decided.
    fn cut_off(open: Open) -> Box<CutOff> {
        Box::new(CutOff { open: [Some(open)].into_iter().collect(), ..CutOff::default() })
    }

    fn metric() -> MetricReference {
        models::known::measured("time_lost")
    }

    /// An aggregate of the time lost, compared to 10 s or a share.
    fn criterion(aggregate: Aggregate, relation: Relation, bound: f64, confidence: Option<f64>) -> Criterion {
        let bound = bound.into();
        let when_undefined = WhenUndefined::AsDeclared;
        let claim = Claim::Aggregate { aggregate, relation, bound, when_undefined, confidence };
        Criterion {
            claim,
            when: Vec::new(),
            text: String::new(),
            reach: Default::default(),
            origin: Origin::default(),
        }
    }

    /// What of `arrived` of 40 runs that lost 2 s, and of the others, which the horizon ended or which never arrived, is
    /// found.
    fn found(criterion: &Criterion, arrived: usize, late: Option<f64>) -> Finding {
        let mut requests = Requests::default();
        requests.include(std::slice::from_ref(criterion));
        let outcome = |run: usize| {
            let is_late = run >= arrived;
            let open = late.filter(|_| is_late).map(Open::at_least);
            let reason = if open.is_some() { StopReason::Horizon } else { StopReason::Completed };
            Outcome {
                key: format!("a/b/rep={run}"),
                seed: 1,
                individuals: Vec::new(),
                drawn: Vec::new(),
                ending: Ending { reason, time: 24.0 },
                metrics: vec![(!is_late).then_some(2.0 + 0.001 * run as f64)],
                critical: Default::default(),
                presences: Vec::new(),
                waiting_steps: Vec::new(),
                left_road: Vec::new(),
                outlasted: Vec::new(),
                cut_off: open.map(cut_off),
                fingerprint: 0,
                wall_time: Duration::ZERO,
            }
        };
        let outcomes: Vec<_> = (0..40).map(outcome).collect();
        judge(std::slice::from_ref(criterion), &outcomes, &requests).findings.remove(0)
    }

    const DOWN: Relation = Relation::LessOrEqual;

    #[test]
    fn those_who_never_arrive_are_not_left_out() {
        let rate = || {
            let comparison = Comparison {
                metric: metric(),
                relation: Relation::Greater,
                bound: 10.0.into(),
                when_undefined: WhenUndefined::AsDeclared,
            };
            Aggregate::Rate(comparison)
        };
        let cases = [
            (criterion(Aggregate::Mean(metric()), DOWN, 10.0, None), Verdict::Inconclusive),
            (criterion(Aggregate::Mean(metric()), DOWN, 10.0, Some(0.95)), Verdict::Inconclusive),
            (criterion(Aggregate::Std(metric()), DOWN, 10.0, None), Verdict::Inconclusive),
            (criterion(Aggregate::Quantile(0.9, metric()), DOWN, 10.0, None), Verdict::Failed),
            (criterion(Aggregate::Quantile(0.9, metric()), DOWN, 10.0, Some(0.8)), Verdict::Inconclusive),
            (criterion(Aggregate::Quantile(0.5, metric()), DOWN, 10.0, Some(0.95)), Verdict::Passed),
            (criterion(Aggregate::Median(metric()), DOWN, 10.0, None), Verdict::Passed),
            (criterion(Aggregate::Max(metric()), DOWN, 10.0, None), Verdict::Failed),
            (criterion(rate(), DOWN, 0.05, None), Verdict::Failed),
            (criterion(rate(), DOWN, 0.12, None), Verdict::Passed),
            (criterion(rate(), Relation::Equal, 0.0, None), Verdict::Inconclusive),
        ];
        for (index, (criterion, verdict)) in cases.iter().enumerate() {
            // 4 of 40 runs: a tenth.
            let late = found(criterion, 36, Some(4.0));
            assert_eq!((late.cut_off, late.undefined), (4, 0));
            assert_eq!(late.verdict, *verdict, "case {index}: {late:?}");
            // With everybody there nothing of this shows.
            let all = found(criterion, 40, None);
            assert_eq!((all.verdict, all.cut_off), (Verdict::Passed, 0), "case {index}: {all:?}");
        }
        // Worse than any value is worse than late.
        for (index, (criterion, verdict)) in cases.iter().enumerate().take(10) {
            let lost = found(criterion, 36, None);
            assert_eq!((lost.cut_off, lost.undefined), (0, 4));
            assert_eq!(lost.verdict, *verdict, "case {index}: {lost:?}");
        }
    }

    #[test]
    fn what_is_too_late_already_fails_whatever_would_come() {
        let mean = criterion(Aggregate::Mean(metric()), DOWN, 3.0, None);
        assert_eq!(found(&mean, 36, Some(4.0)).verdict, Verdict::Inconclusive);
        assert_eq!(found(&mean, 36, Some(40.0)).verdict, Verdict::Failed);
        // A claim from below is the easier the later they come.
        let above = criterion(Aggregate::Mean(metric()), Relation::GreaterOrEqual, 2.1, None);
        assert_eq!(found(&above, 36, Some(4.0)).verdict, Verdict::Passed);
    }

    proptest::proptest! {
        /// A horizon only hides: whatever would have come, what passes with it passes without it.
        #[test]
        fn nothing_passes_that_would_fail(
            values in proptest::collection::vec(0.0..20.0_f64, 1..12), horizon in 0.0..20.0_f64, bound in 0.0..20.0_f64,
            which in 0_usize..6, up: bool,
        ) {
            let relation = if up { Relation::GreaterOrEqual } else { DOWN };
            let over = Comparison {
                metric: metric(), relation: Relation::Greater, bound: bound.into(),
                when_undefined: WhenUndefined::AsDeclared,
            };
            let (aggregate, bound) = match which {
                0 => (Aggregate::Mean(metric()), bound),
                1 => (Aggregate::Median(metric()), bound),
                2 => (Aggregate::Quantile(0.8, metric()), bound),
                3 => (Aggregate::Max(metric()), bound),
                4 => (Aggregate::Min(metric()), bound),
                _ => (Aggregate::Rate(over), 0.3),
            };
            let criterion = criterion(aggregate, relation, bound, None);
            let mut requests = Requests::default();
            requests.include(std::slice::from_ref(&criterion));
            let outcome = |value: &f64, cut: bool| {
                let late = cut && *value > horizon;
                Outcome {
                    key: String::new(),
                    seed: 1,
                    individuals: Vec::new(),
                    drawn: Vec::new(),
                    ending: Ending { reason: StopReason::Completed, time: 24.0 },
                    metrics: vec![(!late).then_some(*value)],
                    critical: Default::default(),
                    presences: Vec::new(),
                    waiting_steps: Vec::new(),
                    left_road: Vec::new(),
                    outlasted: Vec::new(),
                    cut_off: late.then(|| cut_off(Open::at_least(horizon))),
                    fingerprint: 0,
                    wall_time: Duration::ZERO,
                }
            };
            let verdict = |cut: bool| {
                let outcomes: Vec<_> = values.iter().map(|value| outcome(value, cut)).collect();
                judge(std::slice::from_ref(&criterion), &outcomes, &requests).verdict
            };
            if verdict(true) == Verdict::Passed {
                proptest::prop_assert_eq!(verdict(false), Verdict::Passed);
            }
        }
    }
}
