//! Passes that mean nothing: criteria about an encounter that never came about.

use serde::Serialize;

use super::criteria::Finding;
use super::verdict::Verdict;
use crate::metrics::{self, Presence, Scope};
use crate::run::Outcome;
use crate::scenario::Criterion;

/// Why a criterion that passed was never put to the test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Vacuity {
    /// In no run did a pedestrian whom it is about appear.
    NobodyAppeared,
    /// In no run did one of them come into a vehicle's lane.
    NobodyEntered,
    /// In some run time was up with somebody on a collision course: what would have come was not seen.
    CutOff,
}

/// Metrics that say who goes: a criterion about one of them declares what is expected, staying at the kerb included.
const WHO_GOES: [&str; 2] = ["passed_first", "gap_accepted"];

/// Marks the findings that passed without being put to the test. None are, where another criterion that passed says who
/// goes. What a vehicle does by itself, such as braking, is tested by everybody who appears.
pub(super) fn mark(findings: &mut [Finding], criteria: &[Criterion], outcomes: &[Outcome]) {
    let passed = |finding: &&mut Finding| finding.verdict == Verdict::Passed;
    if findings.iter_mut().filter(passed).any(|finding| WHO_GOES.contains(&finding.metric.as_str())) {
        return;
    }
    for (finding, criterion) in findings.iter_mut().zip(criteria).filter(|(finding, _)| passed(finding)) {
        finding.vacuous = vacuity(criterion, outcomes);
    }
}

fn vacuity(criterion: &Criterion, outcomes: &[Outcome]) -> Option<Vacuity> {
    let reference = criterion.claim.metric();
    let whom = reference.pair.as_ref().map(|(_, pedestrian)| pedestrian.as_str());
    let concerned = |name: &str| whom.is_none_or(|whom| whom == name);
    let presences = || {
        let all = outcomes.iter().flat_map(|outcome| &outcome.presences);
        all.filter(|(name, _)| concerned(name)).map(|(_, presence)| presence)
    };
    let nobody = |did: fn(&Presence) -> bool| presences().next().is_some() && !presences().any(did);
    let needs_entry = metrics::metric(&reference.name).is_some_and(|metric| metric.scope != Scope::Vehicle);
    if nobody(|presence| presence.appeared) {
        Some(Vacuity::NobodyAppeared)
    } else if needs_entry && nobody(|presence| presence.entered) {
        Some(Vacuity::NobodyEntered)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::judge;
    use crate::run::Requests;
    use crate::scenario::{
        Claim, Comparison, MetricReference, Origin, Reach, Relation, Settings, WhenUndefined,
    };
    use crate::sim::{Ending, StopReason};
    use std::time::Duration;

    /// `name > 0.5` or, of flags and words, `name = 2`; of one pedestrian if `whom` says so. What is undefined passes.
    fn criterion(name: &str, whom: Option<&str>) -> Criterion {
        let (relation, bound) =
            if name == "passed_first" { (Relation::Equal, 2.0) } else { (Relation::Greater, 0.5) };
        let pair = whom.map(|whom| ("av".to_string(), whom.to_string()));
        let metric = MetricReference { name: name.into(), settings: Settings::default(), pair };
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
    fn outcome(requests: &Requests, value: Option<f64>, presences: &[(&str, bool, bool)]) -> Outcome {
        let presence =
            |&(name, appeared, entered): &(&str, bool, bool)| (name.into(), Presence { appeared, entered });
        Outcome {
            key: "a/b/rep=1".into(),
            seed: 1,
            individuals: Vec::new(),
            ending: Ending { reason: StopReason::Completed, time: 10.0 },
            metrics: requests.iter().map(|_| value).collect(),
            critical: Default::default(),
            presences: presences.iter().map(presence).collect(),
            cut_off: Default::default(),
            fingerprint: 0,
            wall_time: Duration::ZERO,
        }
    }

    fn found(
        criteria: &[Criterion],
        value: Option<f64>,
        runs: &[&[(&str, bool, bool)]],
    ) -> Vec<Option<Vacuity>> {
        let mut requests = Requests::default();
        requests.include(criteria);
        let outcomes: Vec<_> = runs.iter().map(|run| outcome(&requests, value, run)).collect();
        judge(criteria, &outcomes, &requests).findings.iter().map(|finding| finding.vacuous).collect()
    }

    const STAYS: (&str, bool, bool) = ("walker", true, false);
    const GOES: (&str, bool, bool) = ("walker", true, true);
    const ABSENT: (&str, bool, bool) = ("walker", false, false);

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
        let run = [STAYS, ("child", true, true)];
        assert_eq!(found(&criteria, Some(1.0), &[&run]), [Some(Vacuity::NobodyEntered), None]);
        // Nothing is known of those who are not there.
        assert_eq!(found(&criteria, Some(1.0), &[&[]]), [None, None]);
    }
}
