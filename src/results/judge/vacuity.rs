//! Passes that mean nothing: criteria about an encounter that never came about.

use super::possible::cannot_fail;
use crate::{Finding, Outcome, Vacuity, Verdict};
use scenario::{
    Aggregate, Claim, Criterion, Dimension, Expression, MetricKind, MetricReference, Scope, constant,
};
use sim::measure::{self, Presence};

/// Metrics that say who goes: a criterion about one of them declares what is expected, staying at the kerb included.
const WHO_GOES: [&str; 2] = ["passed_first", "gap_accepted"];

/// Metrics of a pair that say how a pedestrian crosses, whoever comes.
const OF_CROSSING: [&str; 1] = ["crossing_duration"];

/// Marks the findings that passed without being put to the test. That nobody came into a lane, or met a vehicle there, is not
/// held against them where another criterion that passed says who goes: that is what was expected. One that cannot fail, or
/// whose pedestrian never appeared, says nothing of the kind. What a vehicle does by itself, such as braking, is tested by
/// everybody who appears.
pub(super) fn mark(findings: &mut [Finding], criteria: &[Criterion], outcomes: &[Outcome]) {
    let found: Vec<Option<Vacuity>> = findings
        .iter()
        .zip(criteria)
        .map(|(finding, criterion)| {
            (finding.verdict == Verdict::Passed).then(|| vacuity(criterion, outcomes)).flatten()
        })
        .collect();
    let says_who_goes = |((finding, criterion), vacuous): ((&Finding, &Criterion), &Option<Vacuity>)| {
        finding.verdict == Verdict::Passed
            && WHO_GOES.contains(&finding.metric.name())
            && *vacuous != Some(Vacuity::NobodyAppeared)
            && !cannot_fail(criterion, outcomes.len())
    };
    let declared = findings.iter().zip(criteria).zip(&found).any(says_who_goes);
    for (finding, vacuous) in findings.iter_mut().zip(found) {
        finding.vacuous = vacuous.filter(|why| !declared || *why == Vacuity::NobodyAppeared);
    }
}

fn vacuity(criterion: &Criterion, outcomes: &[Outcome]) -> Option<Vacuity> {
    let reference = criterion.claim.metric();
    let touches_anything = reference.pair.as_ref().is_some_and(|(_, other)| other.is_empty());
    let concerned = |name: &str| !touches_anything && reference.is_of(name);
    let presences = || {
        let all = outcomes.iter().flat_map(|outcome| &outcome.presences);
        all.filter(|(name, _)| concerned(name)).map(|(_, presence)| presence)
    };
    let nobody = |did: fn(&Presence) -> bool| presences().next().is_some() && !presences().any(did);
    let scope = reference.known().map(|metric| metric.scope);
    let needs_entry = scope.is_some_and(|scope| !matches!(scope, Scope::Vehicle | Scope::Vehicles));
    let needs_meeting = matches!(scope, Some(Scope::Pair | Scope::Contact))
        && !OF_CROSSING.contains(&reference.name())
        && !keeps_apart(&criterion.claim);
    if scope == Some(Scope::Vehicles) {
        // Of two vehicles the metrics themselves say that they do not exist where these never meet.
        None
    } else if nobody(|presence| presence.appeared) {
        Some(Vacuity::NobodyAppeared)
    } else if needs_entry && nobody(|presence| presence.entered) {
        Some(Vacuity::NobodyEntered)
    } else if needs_meeting && nobody(|presence| presence.met) {
        Some(Vacuity::NobodyMet)
    } else {
        None
    }
}

/// Whether a claim is itself that there are more seconds between them than where they meet.
fn keeps_apart(claim: &Claim) -> bool {
    let is_time = |reference: &MetricReference| {
        reference.known().is_some_and(|metric| metric.kind == MetricKind::Quantity(Dimension::TIME))
    };
    let is_far = |bound: &Expression| constant(bound) >= measure::MEETING_TIME;
    match claim {
        Claim::Runs { comparison, .. } => is_time(&comparison.metric) && is_far(&comparison.bound),
        Claim::Aggregate { aggregate, bound, .. } => match aggregate {
            Aggregate::Rate(comparison) | Aggregate::Count(comparison) => {
                is_time(&comparison.metric) && is_far(&comparison.bound)
            }
            of_values => is_time(of_values.metric()) && is_far(bound),
        },
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::Requests;
    use crate::judge::judge;
    use scenario::Comparison;
    use scenario::Origin;
    use scenario::Reach;
    use scenario::Relation;
    use scenario::WhenUndefined;
    use sim::{Ending, StopReason};

    /// `name > 0.5` or, of flags and words, `name = 2`; of one pedestrian if `whom` says so. What is undefined passes.
    fn criterion(name: &str, whom: Option<&str>) -> Criterion {
        let (relation, bound) =
            if name == "passed_first" { (Relation::Equal, 2.0) } else { (Relation::Greater, 0.5) };
        let pair = whom.map(|whom| ("av".to_string(), whom.to_string()));
        let metric = MetricReference { pair, ..models::known::measured(name) };
        let when_undefined = WhenUndefined::Passes;
        let comparison = Comparison { metric, relation, bound: bound.into(), when_undefined };
        let claim = Claim::Runs { comparison, share: None, confidence: None };
        Criterion {
            claim,
            when: Vec::new(),
            text: name.into(),
            reach: Reach::default(),
            origin: Origin::default(),
        }
    }

    /// One run in which every metric is `value`.
    fn outcome(requests: &Requests, value: Option<f64>, presences: &[Who]) -> Outcome {
        let presence = |(name, presence): &Who| ((*name).into(), *presence);
        Outcome {
            key: "a/b/rep=1".into(),
            seed: 1,
            individuals: Vec::new(),
            drawn: Vec::new(),
            ending: Ending { reason: StopReason::Completed, time: 10.0 },
            metrics: requests.iter().map(|_| value).collect(),
            critical: Default::default(),
            presences: presences.iter().map(presence).collect(),
            cut_off: Default::default(),
            fingerprint: 0,
            wall_time: Duration::ZERO,
        }
    }

    fn found(criteria: &[Criterion], value: Option<f64>, runs: &[&[Who]]) -> Vec<Option<Vacuity>> {
        let mut requests = Requests::default();
        requests.include(criteria);
        let outcomes: Vec<_> = runs.iter().map(|run| outcome(&requests, value, run)).collect();
        judge(criteria, &outcomes, &requests).findings.iter().map(|finding| finding.vacuous).collect()
    }

    type Who = (&'static str, Presence);

    const ABSENT: Who = ("walker", Presence { appeared: false, entered: false, met: false });
    const STAYS: Who = ("walker", Presence { appeared: true, entered: false, met: false });
    const ALONE: Who = ("walker", Presence { appeared: true, entered: true, met: false });
    const GOES: Who = ("walker", Presence { appeared: true, entered: true, met: true });

    #[test]
    fn one_who_stays_tests_only_what_the_car_does_by_itself() {
        let criteria = [criterion("pet", None), criterion("max_deceleration", None)];
        let one = |run| found(&criteria, Some(1.0), &[&[run]]);
        assert_eq!(one(STAYS), [Some(Vacuity::NobodyEntered), None]);
        assert_eq!(one(ABSENT), [Some(Vacuity::NobodyAppeared); 2]);
        assert_eq!(one(GOES), [None, None]);
        // One run of several is enough.
        assert_eq!(found(&criteria, Some(1.0), &[&[STAYS], &[GOES], &[ABSENT]]), [None, None]);
        // And where the metric does not exist for that reason.
        assert_eq!(found(&criteria, None, &[&[STAYS]]), [Some(Vacuity::NobodyEntered), None]);
    }

    #[test]
    fn what_failed_is_no_pass_and_a_declared_expectation_no_accident() {
        let pet = criterion("pet", None);
        assert_eq!(found(std::slice::from_ref(&pet), Some(0.1), &[&[STAYS]]), [None]);
        let declared = [pet, criterion("passed_first", None)];
        // The vehicle passed first, as was expected.
        assert_eq!(found(&declared, Some(2.0), &[&[STAYS]]), [None, None]);
        // It did not: then that is no declaration of what happened.
        assert_eq!(found(&declared, Some(1.0), &[&[STAYS]]), [Some(Vacuity::NobodyEntered), None]);
    }

    #[test]
    fn it_is_about_the_pedestrian_whom_the_criterion_names() {
        let criteria = [criterion("pet", Some("walker")), criterion("pet", Some("child"))];
        let run = [STAYS, ("child", GOES.1)];
        assert_eq!(found(&criteria, Some(1.0), &[&run]), [Some(Vacuity::NobodyEntered), None]);
        // Nothing is known of those who are not there.
        assert_eq!(found(&criteria, Some(1.0), &[&[]]), [None, None]);
    }

    #[test]
    fn who_goes_while_every_vehicle_is_far_away_meets_nobody() {
        let names = ["collision", "pet", "max_deceleration", "crossing_duration", "crossing_initiation_time"];
        let criteria = names.map(|name| criterion(name, None));
        let met = Some(Vacuity::NobodyMet);
        assert_eq!(found(&criteria, Some(1.0), &[&[ALONE]]), [met, met, None, None, None]);
        assert_eq!(found(&criteria, Some(1.0), &[&[ALONE], &[GOES]]), [None; 5]);
        // To keep as far apart as that is what such a claim asks for.
        let mut far = criterion("pet", None);
        far.claim.bounds_mut().into_iter().for_each(|bound| *bound = measure::MEETING_TIME.into());
        assert_eq!(found(&[far], Some(6.0), &[&[ALONE]]), [None]);
    }

    #[test]
    fn what_cannot_fail_or_was_about_nobody_declares_nothing() {
        let mut idle = criterion("gap_accepted", None);
        let Claim::Runs { comparison, .. } = idle.claim.clone() else { unreachable!() };
        idle.claim = Claim::Aggregate {
            aggregate: Aggregate::Rate(comparison),
            relation: Relation::GreaterOrEqual,
            bound: 0.0.into(),
            when_undefined: WhenUndefined::AsDeclared,
            confidence: None,
        };
        let entered = Some(Vacuity::NobodyEntered);
        assert_eq!(
            found(&[criterion("pet", None), idle], Some(2.0), &[&[STAYS]]),
            [entered, entered],
            "a rate of at least 0 % expects nothing"
        );
        let declared = [criterion("pet", None), criterion("passed_first", None)];
        assert_eq!(found(&declared, Some(2.0), &[&[ABSENT]]), [Some(Vacuity::NobodyAppeared); 2]);
    }
}
