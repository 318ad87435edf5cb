//! What was never put to the test: a claim that passed although nothing that it is about was at stake in any run.

use std::sync::Arc;

use super::possible::cannot_fail;
use crate::{
    EvaluateResult, Finding, Outcome, PairPresence, Requests, Untested, UntestedMeasures, UntestedPair,
    Verdict,
};
use scenario::{
    Aggregate, Claim, Comparison, Criterion, Expression, MetricReference, Scope, Stake, TrafficStream,
    constant,
};
use sim::measure::{Closeness, MEETING_TIME, Presence};

/// Marks the findings that passed without being put to the test, and says of all in how many runs they were.
///
/// A pair that a claim is about counts as tested, too, where another claim about the same pair says which of the two goes first and
/// passed, and the vehicle passed the pedestrian in some run: that the pedestrian stays away is then what was expected.
pub(super) fn mark(
    findings: &mut [Finding],
    criteria: &[Criterion],
    outcomes: &[Outcome],
    requests: &Requests,
) {
    let runs: Vec<&Outcome> = outcomes.iter().collect();
    let stakes: Vec<AtStake> =
        criteria.iter().map(|criterion| AtStake::of_claim(&criterion.claim, &runs, requests)).collect();
    let declares = |((finding, criterion), stake): &((&Finding, &Criterion), &AtStake)| {
        finding.verdict == Verdict::Passed
            && stake.kind == Some(Stake::Order)
            && !cannot_fail(criterion, outcomes.len())
            && stake.untested(&[]).is_none()
    };
    let orders = findings.iter().zip(criteria).zip(&stakes).filter(declares);
    let orders: Vec<&MetricReference> = orders.map(|(_, stake)| stake.reference).collect();
    for ((finding, criterion), stake) in findings.iter_mut().zip(criteria).zip(&stakes) {
        let tested = stake.tested_runs();
        finding.tested = tested.filter(|runs| *runs > 0 && *runs < outcomes.len());
        if finding.verdict == Verdict::Passed {
            finding.untested = stake.untested(&orders).map(|why| named_instead(why, stake, criterion));
        }
    }
}

/// Why nothing that a metric is about was at stake in any of these runs; `None` where something was.
pub fn untested_by(
    reference: &MetricReference,
    outcomes: &[&Outcome],
    requests: &Requests,
) -> Option<Untested> {
    AtStake::new(reference, false, outcomes, requests).untested(&[])
}

/// Why nothing that a comparison is about was at stake in any of these runs; `None` where something was.
pub fn comparison_untested_by(
    comparison: &Comparison,
    outcomes: &[&Outcome],
    requests: &Requests,
) -> Option<Untested> {
    AtStake::new(&comparison.metric, is_far(&comparison.bound), outcomes, requests).untested(&[])
}

/// Whether anything that a metric is about was at stake in a run: for a metric of pairs, in one of them.
pub fn has_encounter(comparison: &Comparison, outcome: &Outcome, requests: &Requests) -> bool {
    let outcomes = [outcome];
    let stake = AtStake::new(&comparison.metric, is_far(&comparison.bound), &outcomes, requests);
    match &stake.needs {
        Needs::Pairs(pairs) => pairs.is_empty() || pairs.iter().any(|pair| stake.is_tested(pair, outcome)),
        _ => stake.untested(&[]).is_none(),
    }
}

impl EvaluateResult {
    /// The measures that are of runs in which nothing was at stake, condition by condition.
    pub fn untested(&self) -> Vec<UntestedMeasures> {
        let mut found: Vec<UntestedMeasures> = Vec::new();
        for condition in &self.conditions {
            let outcomes: Vec<&Outcome> = condition.runs.iter().map(|run| &run.outcome).collect();
            for measure in &self.measures {
                let metric = measure.aggregate.metric();
                let Some(reason) = untested_by(metric, &outcomes, &Requests::default()) else { continue };
                let is_it =
                    |one: &&mut UntestedMeasures| one.condition == condition.name && one.reason == reason;
                match found.iter_mut().find(is_it) {
                    Some(known) => known.measures.push(measure.text.clone()),
                    None => found.push(UntestedMeasures {
                        condition: condition.name.clone(),
                        measures: vec![measure.text.clone()],
                        reason,
                    }),
                }
            }
        }
        found
    }
}

/// What has to be at stake for a claim, and the runs in which it may have been.
struct AtStake<'a> {
    reference: &'a MetricReference,
    /// `None`: the metric is only a name.
    kind: Option<Stake>,
    /// The claim demands so long a time that being in the way is enough.
    is_far: bool,
    needs: Needs,
    outcomes: &'a [&'a Outcome],
    /// The place of the metric in outcomes.
    index: Option<usize>,
}

/// The road users that have to be put to the test.
enum Needs {
    Nothing,
    /// Each of these.
    Pairs(Vec<Pair>),
    /// One of these vehicles, by moving together with a pedestrian.
    Motion(Vec<Arc<str>>),
    /// The metric has to have a value.
    Value,
}

/// Another road user, and the vehicles of which one has to be put to the test with it.
struct Pair {
    vehicles: Vec<Arc<str>>,
    other: Arc<str>,
}

impl<'a> AtStake<'a> {
    fn of_claim(claim: &'a Claim, outcomes: &'a [&'a Outcome], requests: &Requests) -> Self {
        let bound = match claim {
            Claim::Runs { comparison, .. } => &comparison.bound,
            Claim::Aggregate {
                aggregate: Aggregate::Rate(comparison) | Aggregate::Count(comparison),
                ..
            } => &comparison.bound,
            Claim::Aggregate { bound, .. } => bound,
        };
        Self::new(claim.metric(), is_far(bound), outcomes, requests)
    }

    fn new(
        reference: &'a MetricReference,
        is_far: bool,
        outcomes: &'a [&'a Outcome],
        requests: &Requests,
    ) -> Self {
        let (kind, index) = (reference.known().map(|metric| metric.stake), requests.index(reference));
        let needs = needs(reference, outcomes);
        Self { reference, kind, is_far, needs, outcomes, index }
    }

    /// Why nothing was at stake in any run; `orders` are claims that say which of a pair goes first.
    fn untested(&self, orders: &[&MetricReference]) -> Option<Untested> {
        let any = |did: &dyn Fn(&Outcome) -> bool| self.outcomes.iter().any(|one| did(one));
        match &self.needs {
            Needs::Nothing => None,
            Needs::Motion(vehicles) => {
                let moved = any(&|outcome| has_moved(vehicles, outcome));
                let vehicle = || self.reference.stream().map(Arc::from).or_else(|| only(vehicles));
                (!moved).then(|| Untested::NoMotion { vehicle: vehicle() })
            }
            Needs::Value => (!any(&|outcome| self.has_value(outcome))).then_some(Untested::NoValue),
            Needs::Pairs(pairs) => {
                let is_tested = |pair: &&Pair| {
                    any(&|outcome| self.is_tested(pair, outcome) || is_excused(pair, outcome, orders))
                };
                let open: Vec<_> = pairs.iter().filter(|pair| !is_tested(pair)).collect();
                let pairs: Vec<UntestedPair> = open.iter().map(|pair| self.untested_pair(pair)).collect();
                (!pairs.is_empty()).then_some(Untested::Pairs { pairs, instead: None })
            }
        }
    }

    /// The number of runs in which it was put to the test: of several pairs that which was so in the fewest.
    fn tested_runs(&self) -> Option<usize> {
        let count = |did: &dyn Fn(&Outcome) -> bool| self.outcomes.iter().filter(|one| did(one)).count();
        match &self.needs {
            Needs::Nothing => None,
            Needs::Motion(vehicles) => Some(count(&|outcome| has_moved(vehicles, outcome))),
            Needs::Value => Some(count(&|outcome| self.has_value(outcome))),
            Needs::Pairs(pairs) => {
                pairs.iter().map(|pair| count(&|outcome| self.is_tested(pair, outcome))).min()
            }
        }
    }

    fn has_value(&self, outcome: &Outcome) -> bool {
        self.index.is_none_or(|index| outcome.metrics.get(index).copied().flatten().is_some())
    }

    fn is_tested(&self, pair: &Pair, outcome: &Outcome) -> bool {
        let presences = pair.vehicles.iter().filter_map(|vehicle| outcome.presence(vehicle, &pair.other));
        presences.into_iter().any(|presence| self.is_enough(presence))
    }

    fn is_enough(&self, Presence { closest, moved, passed }: Presence) -> bool {
        match self.kind {
            None | Some(Stake::Value | Stake::Motion) => true,
            Some(Stake::Meeting) => closest >= Closeness::Met,
            Some(Stake::MeetingInTime) => {
                closest >= if self.is_far { Closeness::InTheWay } else { Closeness::Met }
            }
            Some(Stake::MeetingOrPassing) => closest >= Closeness::Met || passed,
            Some(Stake::Entry) => closest >= Closeness::InTheWay,
            Some(Stake::Order | Stake::Company) => closest >= Closeness::Together,
            Some(Stake::Appearance) => closest > Closeness::Absent,
            Some(Stake::Vehicles) => closest >= Closeness::Met && moved,
        }
    }

    fn untested_pair(&self, pair: &Pair) -> UntestedPair {
        let presences = self.outcomes.iter().flat_map(|outcome| {
            pair.vehicles.iter().filter_map(|vehicle| outcome.presence(vehicle, &pair.other))
        });
        let closest = presences.map(|presence| presence.closest).max().unwrap_or_default();
        let vehicle = self.reference.stream().map(Arc::from).or_else(|| only(&pair.vehicles));
        UntestedPair { vehicle, other: pair.other.clone(), closest }
    }
}

/// The road users of the runs that a metric is about.
fn needs(reference: &MetricReference, outcomes: &[&Outcome]) -> Needs {
    let Some(metric) = reference.known() else { return Needs::Nothing };
    if metric.stake == Stake::Value {
        return Needs::Value;
    }
    let (mut vehicles, mut people): (Vec<Arc<str>>, Vec<Arc<str>>) = Default::default();
    let pairs = || outcomes.iter().flat_map(|outcome| &outcome.presences);
    for pair in pairs().filter(|pair| !pair.of_vehicles) {
        for (name, known) in [(&pair.vehicle, &mut vehicles), (&pair.other, &mut people)] {
            if !known.contains(name) {
                known.push(name.clone());
            }
        }
    }
    let named = reference.pair.as_ref().map(|(vehicle, _)| vehicle.as_str());
    let covered = || vehicles.iter().filter(|name| reference.is_of_vehicle(name)).cloned();
    let of_each = |vehicles: Vec<Arc<str>>| {
        let meant = people.iter().filter(|name| reference.is_of(name));
        meant.map(|name| Pair { vehicles: vehicles.clone(), other: name.clone() }).collect()
    };
    let of_vehicles =
        |pair: &&PairPresence| pair.of_vehicles && named.is_some_and(|one| is_between(pair, one, reference));
    match metric.scope {
        Scope::Vehicle if people.is_empty() => Needs::Nothing,
        Scope::Vehicle => Needs::Motion(covered().collect()),
        Scope::Pedestrian => Needs::Pairs(of_each(vehicles)),
        // Of streams that it does not name, those of which vehicles have a number.
        Scope::Stream => {
            Needs::Pairs(of_each(covered().filter(|name| TrafficStream::of_member(name).is_some()).collect()))
        }
        Scope::Pair | Scope::Contact | Scope::Vehicles => match pairs().find(of_vehicles) {
            Some(pair) => {
                Needs::Pairs(vec![Pair { vehicles: vec![pair.vehicle.clone()], other: pair.other.clone() }])
            }
            None if metric.scope == Scope::Vehicles => Needs::Nothing,
            None => Needs::Pairs(of_each(covered().collect())),
        },
    }
}

/// Whether two vehicles are those that a reference names together, of which one is `named`.
fn is_between(pair: &PairPresence, named: &str, reference: &MetricReference) -> bool {
    let (one, other) = (&*pair.vehicle, &*pair.other);
    let is_named = |name: &str| reference.pair.as_ref().is_some_and(|(_, second)| second == name);
    (one == named && is_named(other)) || (other == named && is_named(one))
}

/// The one of this name, if there is only one.
fn only(names: &[Arc<str>]) -> Option<Arc<str>> {
    match names {
        [name] => Some(name.clone()),
        _ => None,
    }
}

fn has_moved(vehicles: &[Arc<str>], outcome: &Outcome) -> bool {
    let mut presences = outcome.presences.iter().filter(|pair| vehicles.contains(&pair.vehicle));
    presences.any(|pair| pair.presence.moved)
}

/// Whether the vehicle passed the pedestrian in a run, and a claim about the pair says which of them goes first.
fn is_excused(pair: &Pair, outcome: &Outcome, orders: &[&MetricReference]) -> bool {
    let is_about =
        |order: &&&MetricReference, vehicle: &str| order.is_of_vehicle(vehicle) && order.is_of(&pair.other);
    pair.vehicles.iter().any(|vehicle| {
        let passed = outcome.presence(vehicle, &pair.other).is_some_and(|presence| presence.passed);
        passed && orders.iter().any(|order| is_about(&order, vehicle))
    })
}

fn is_far(bound: &Expression) -> bool {
    constant(bound) >= MEETING_TIME
}

/// The same with the claim about a pair that was put to the test, where another that it is about was not.
fn named_instead(why: Untested, stake: &AtStake, criterion: &Criterion) -> Untested {
    let (Untested::Pairs { pairs, .. }, Needs::Pairs(all)) = (&why, &stake.needs) else { return why };
    let is_open = |pair: &Pair| pairs.iter().any(|open| open.other == pair.other);
    let find = |pair: &Pair| {
        let vehicle = pair.vehicles.iter().find(|vehicle| {
            let alone = Pair { vehicles: vec![(*vehicle).clone()], other: pair.other.clone() };
            stake.outcomes.iter().any(|outcome| stake.is_tested(&alone, outcome))
        })?;
        // What is said of a stream stays said of it.
        let stream = match stake.reference.known().map(|metric| metric.scope) {
            Some(Scope::Stream) => TrafficStream::of_member(vehicle).map(|(stream, _)| stream),
            _ => stake.reference.stream(),
        };
        Some((stream.unwrap_or(vehicle).to_string(), pair.other.to_string()))
    };
    let tested = all.iter().filter(|pair| !is_open(pair)).find_map(find);
    let instead = tested.map(|pair| {
        let named = MetricReference { pair: Some(pair), several: Vec::new(), ..stake.reference.clone() };
        criterion.text.replacen(&stake.reference.label(), &named.label(), 1)
    });
    Untested::Pairs { pairs: pairs.clone(), instead: instead.filter(|text| *text != criterion.text) }
}

#[cfg(test)]
mod tests {
    use std::slice;
    use std::time::Duration;

    use super::*;
    use crate::judge::judge;
    use scenario::{Origin, Reach, Relation, WhenUndefined};
    use sim::{Ending, StopReason};

    /// `name > 0.5` or, of words, `name = 2`; of `av` and a pedestrian, of `av` alone, or of all. What is undefined passes.
    fn criterion(name: &str, pair: Option<(&str, &str)>) -> Criterion {
        let (relation, bound) =
            if name == "passed_first" { (Relation::Equal, 2.0) } else { (Relation::Greater, 0.5) };
        let pair = pair.map(|(vehicle, other)| (vehicle.to_string(), other.to_string()));
        let metric = MetricReference { pair, ..models::known::measured(name) };
        let text = format!("{} > 0.5", metric.label());
        let when_undefined = WhenUndefined::Passes;
        let comparison = Comparison { metric, relation, bound: bound.into(), when_undefined };
        let claim = Claim::Runs { comparison, share: None, confidence: None };
        Criterion { claim, when: Vec::new(), text, reach: Reach::default(), origin: Origin::default() }
    }

    /// A vehicle, another road user, how close they came; whether the vehicle moved, and passed the other.
    type Seen = (&'static str, &'static str, Closeness, bool, bool);

    const ABSENT: Seen = ("av", "walker", Closeness::Absent, false, false);
    const STAYS: Seen = ("av", "walker", Closeness::Abreast, true, true);
    const STANDS: Seen = ("av", "walker", Closeness::Apart, false, false);
    const ALONE: Seen = ("av", "walker", Closeness::InTheWay, true, true);
    const GOES: Seen = ("av", "walker", Closeness::Met, true, false);

    fn outcome(requests: &Requests, value: Option<f64>, pairs: &[Seen]) -> Outcome {
        let presence = |(vehicle, other, closest, moved, passed): &Seen| PairPresence {
            vehicle: (*vehicle).into(),
            other: (*other).into(),
            of_vehicles: *other == "bus",
            presence: Presence { closest: *closest, moved: *moved, passed: *passed },
        };
        Outcome {
            key: "a/b/rep=1".into(),
            seed: 1,
            individuals: Vec::new(),
            drawn: Vec::new(),
            ending: Ending { reason: StopReason::Completed, time: 10.0 },
            metrics: requests.iter().map(|_| value).collect(),
            critical: Default::default(),
            presences: pairs.iter().map(presence).collect(),
            waiting_steps: Vec::new(),
            left_road: Vec::new(),
            outlasted: Vec::new(),
            cut_off: Default::default(),
            fingerprint: 0,
            wall_time: Duration::ZERO,
        }
    }

    fn judged(criteria: &[Criterion], value: Option<f64>, runs: &[&[Seen]]) -> Vec<Finding> {
        let mut requests = Requests::default();
        requests.include(criteria);
        let outcomes: Vec<_> = runs.iter().map(|run| outcome(&requests, value, run)).collect();
        judge(criteria, &outcomes, &requests).findings
    }

    /// Which of these criteria were put to the test in runs in which every metric is `value`.
    fn tested(criteria: &[Criterion], value: Option<f64>, runs: &[&[Seen]]) -> Vec<bool> {
        judged(criteria, value, runs).iter().map(|finding| finding.untested.is_none()).collect()
    }

    #[test]
    fn each_metric_needs_its_own_stake() {
        let of = |name: &str| {
            [ABSENT, STANDS, STAYS, ALONE, GOES].map(|seen| {
                let value = if name == "passed_first" { 2.0 } else { 1.0 };
                tested(&[criterion(name, None)], Some(value), &[&[seen]])[0]
            })
        };
        for name in ["collision", "impact_speed", "min_ttc", "drac", "time_headway", "pet", "pet_area"] {
            assert_eq!(of(name), [false, false, false, false, true], "{name}");
        }
        for name in ["crossing_duration", "tta_at_entry"] {
            assert_eq!(of(name), [false, false, false, true, true], "{name}");
        }
        // It takes a pedestrian that the vehicle passed, or one that was there together with a vehicle that moved.
        for name in ["min_distance", "passed_first", "crossing_initiation_time", "pedestrian_delay"] {
            assert_eq!(of(name), [false, false, true, true, true], "{name}");
        }
        for name in ["max_deceleration", "max_jerk", "kerb_contact", "time_lost", "travel_time"] {
            assert_eq!(of(name), [false, false, true, true, true], "{name}");
        }
        assert_eq!(of("plausibility"), [false, true, true, true, true]);
        // To keep as far apart as that is what such a claim asks for.
        let mut far = criterion("pet", None);
        far.claim.bounds_mut().into_iter().for_each(|bound| *bound = MEETING_TIME.into());
        assert_eq!(tested(&[far], Some(6.0), &[&[ALONE]]), [true]);
    }

    #[test]
    fn one_run_of_a_trial_is_enough_and_it_is_said_in_how_many_runs() {
        let mut pet = criterion("pet", None);
        let runs: [&[Seen]; 3] = [&[STAYS], &[GOES], &[ABSENT]];
        let finding = &judged(std::slice::from_ref(&pet), Some(1.0), &runs)[0];
        assert_eq!((finding.untested.clone(), finding.tested), (None, Some(1)));
        let always = &judged(std::slice::from_ref(&pet), Some(1.0), &[&[GOES], &[GOES]])[0];
        assert_eq!(always.tested, None);
        // A criterion that failed is not untested; one whose metric does not exist for that reason is.
        assert_eq!(tested(std::slice::from_ref(&pet), Some(0.1), &[&[STAYS]]), [true]);
        assert_eq!(tested(std::slice::from_ref(&pet), None, &[&[STAYS]]), [false]);
        // The runs say nothing of a pedestrian that they do not have.
        pet.claim.metric_mut().pair = Some(("av".into(), "child".into()));
        assert_eq!(tested(&[pet], Some(1.0), &[&[]]), [true]);
    }

    #[test]
    fn every_person_has_to_be_met_by_a_vehicle_that_the_criterion_covers() {
        let both = [GOES, ("av", "child", Closeness::Together, true, false)];
        let named = [Some(("av", "walker")), Some(("av", "child")), Some(("av", "")), None];
        let criteria = named.map(|pair| criterion("collision", pair));
        assert_eq!(tested(&criteria, Some(1.0), &[&both]), [true, false, false, false]);
        let finding = &judged(&criteria, Some(1.0), &[&both])[3];
        let Some(Untested::Pairs { pairs, instead }) = &finding.untested else { panic!("{finding:?}") };
        assert_eq!((&*pairs[0].other, pairs[0].closest), ("child", Closeness::Together));
        assert_eq!(instead.as_deref(), Some("collision(av, walker) > 0.5"));
        // Another car meets the child: that is enough for what is said of all cars, and not of `av`.
        let another = [
            ("av", "walker", Closeness::Met, true, false),
            ("av", "child", Closeness::Together, true, false),
            ("van", "walker", Closeness::Together, true, false),
            ("van", "child", Closeness::Met, true, false),
        ];
        assert_eq!(tested(&criteria, Some(1.0), &[&another]), [true, false, false, true]);
        // Each in a run of its own.
        let first = [GOES, ("av", "child", Closeness::Absent, false, false)];
        let second = [ABSENT, ("av", "child", Closeness::Met, true, false)];
        assert_eq!(tested(&criteria, Some(1.0), &[&first, &second]), [true; 4]);
        // What the vehicle does alone takes one person.
        assert_eq!(tested(&[criterion("max_deceleration", None)], Some(1.0), &[&first]), [true]);
    }

    #[test]
    fn a_declared_order_excuses_its_own_pairs_where_the_vehicle_passed() {
        let order = |pair| criterion("passed_first", pair);
        let pets = [Some(("av", "walker")), Some(("av", "child"))].map(|pair| criterion("pet", pair));
        let [walker, child] = pets;
        let both = [STAYS, ("av", "child", Closeness::Abreast, true, true)];
        let of = |order: Criterion, runs: &[&[Seen]]| {
            tested(&[walker.clone(), child.clone(), order], Some(2.0), runs)
        };
        assert_eq!(of(order(None), &[&both]), [true, true, true]);
        assert_eq!(of(order(Some(("av", "walker"))), &[&both]), [true, false, true]);
        // A car that never arrives excuses nothing, and neither does an order that was not as declared.
        let never = [("av", "walker", Closeness::Together, true, false)];
        assert_eq!(tested(&[walker.clone(), order(None)], Some(2.0), &[&never]), [false, true]);
        assert_eq!(tested(&[walker.clone(), order(None)], Some(1.0), &[&both]), [false, true]);
        assert_eq!(tested(&[walker.clone(), order(None)], Some(2.0), &[&[ABSENT]]), [false, false]);
        // A rate of at least 0 % expects nothing.
        let mut idle = criterion("gap_accepted", None);
        let Claim::Runs { comparison, .. } = idle.claim.clone() else { unreachable!() };
        idle.claim = Claim::Aggregate {
            aggregate: Aggregate::Rate(comparison),
            relation: Relation::GreaterOrEqual,
            bound: 0.0.into(),
            when_undefined: WhenUndefined::AsDeclared,
            confidence: None,
        };
        assert_eq!(tested(&[walker, idle], Some(2.0), &[&[STAYS]]), [false, true]);
    }

    #[test]
    fn two_vehicles_have_to_do_with_each_other_only_where_both_are_named() {
        let pair = |closest| [GOES, ("av", "bus", closest, true, false)];
        let named = |name| criterion(name, Some(("av", "bus")));
        for name in ["collision", "vehicle_ttc", "vehicle_pet", "entered_first", "vehicle_distance"] {
            assert_eq!(tested(&[named(name)], Some(1.0), &[&pair(Closeness::Met)]), [true], "{name}");
            assert_eq!(tested(&[named(name)], Some(1.0), &[&pair(Closeness::Together)]), [false], "{name}");
            let reversed = criterion(name, Some(("bus", "av")));
            assert_eq!(tested(&[reversed], Some(1.0), &[&pair(Closeness::Together)]), [false], "{name}");
        }
        assert_eq!(tested(&[criterion("vehicle_ttc", None)], Some(1.0), &[&[STAYS]]), [true]);
        // People are still what a claim about all is about.
        let criteria = [criterion("collision", None), criterion("collision", Some(("av", "")))];
        assert_eq!(tested(&criteria, Some(1.0), &[&pair(Closeness::Together)]), [true, true]);
        // Boxes never count.
        assert_eq!(tested(&[criterion("collision", Some(("av", "parked")))], Some(1.0), &[&[STAYS]]), [true]);
    }

    /// A metric of a stream, or of any of its vehicles, and the walker.
    fn of_stream(name: &str, stream: &str) -> Criterion {
        let mut criterion = criterion(name, Some((stream, "walker")));
        criterion.claim.metric_mut().of_stream = true;
        criterion
    }

    #[test]
    fn a_stream_is_put_to_the_test_by_any_of_its_vehicles_and_by_no_other() {
        let apart = ("cars_1", "walker", Closeness::Apart, true, false);
        let together = ("cars_12", "walker", Closeness::Together, true, false);
        let met = ("cars_3", "walker", Closeness::Met, true, false);
        let other = ("vans_1", "walker", Closeness::Met, true, false);
        let gap = of_stream("gap_taken", "cars");
        assert_eq!(tested(slice::from_ref(&gap), Some(3.0), &[&[apart, other]]), [false]);
        assert_eq!(tested(slice::from_ref(&gap), Some(3.0), &[&[apart, together, other]]), [true]);
        // In one run there are more vehicles than in another.
        assert_eq!(tested(slice::from_ref(&gap), Some(3.0), &[&[apart], &[apart, together]]), [true]);
        let finding = &judged(&[gap], Some(3.0), &[&[apart, other]])[0];
        let Some(Untested::Pairs { pairs, .. }) = &finding.untested else { panic!("{finding:?}") };
        assert_eq!(pairs[0].vehicle.as_deref(), Some("cars"));
        // A contact with any of its vehicles.
        let contact = of_stream("collision", "cars");
        assert_eq!(tested(slice::from_ref(&contact), Some(1.0), &[&[apart, together, other]]), [false]);
        assert_eq!(tested(&[contact], Some(1.0), &[&[apart, met]]), [true]);
        // A vehicle of this name has nothing to do with those that are numbered.
        let car = criterion("collision", Some(("cars", "walker")));
        assert_eq!(
            tested(&[car], Some(1.0), &[&[("cars", "walker", Closeness::Apart, true, false), met]]),
            [false]
        );
        // Where no stream is named, only vehicles with a number count.
        let any = criterion("gap_taken", None);
        let single = ("av", "walker", Closeness::Met, true, false);
        assert_eq!(tested(slice::from_ref(&any), Some(3.0), &[&[single, apart]]), [false]);
        assert_eq!(tested(slice::from_ref(&any), Some(3.0), &[&[single, other]]), [true]);
        // What to write instead is about the stream.
        let both = [together, ("cars_12", "child", Closeness::Apart, true, false)];
        let finding = &judged(&[any], Some(3.0), &[&both])[0];
        let Some(Untested::Pairs { instead, .. }) = &finding.untested else { panic!("{finding:?}") };
        assert_eq!(instead.as_deref(), Some("gap_taken(cars, walker) > 0.5"));
    }

    #[test]
    fn who_never_goes_has_not_missed_few_gaps() {
        let missed = |aggregate: Option<fn(MetricReference) -> Aggregate>, relation, bound: f64| {
            let mut criterion = of_stream("gaps_missed", "cars");
            let metric = criterion.claim.metric().clone();
            let (bound, when_undefined) = (bound.into(), WhenUndefined::AsDeclared);
            criterion.claim = match aggregate {
                None => Claim::Runs {
                    comparison: Comparison { metric, relation, bound, when_undefined },
                    share: None,
                    confidence: None,
                },
                Some(aggregate) => Claim::Aggregate {
                    aggregate: aggregate(metric),
                    relation,
                    bound,
                    when_undefined,
                    confidence: None,
                },
            };
            criterion
        };
        let seen = [("cars_2", "walker", Closeness::Together, true, true)];
        let criteria = [
            missed(None, Relation::LessOrEqual, 3.0),
            missed(None, Relation::GreaterOrEqual, 1.0),
            missed(None, Relation::GreaterOrEqual, 5.0),
            missed(Some(Aggregate::Mean), Relation::LessOrEqual, 3.0),
            missed(Some(Aggregate::Max), Relation::LessOrEqual, 3.0),
        ];
        let mut requests = Requests::default();
        requests.include(&criteria);
        let verdicts = |changed: &dyn Fn(&mut Outcome)| {
            let mut outcomes = [1.0, 2.0].map(|value| outcome(&requests, Some(value), &seen));
            changed(&mut outcomes[1]);
            judge(&criteria, &outcomes, &requests).findings.iter().map(|one| one.verdict).collect::<Vec<_>>()
        };
        use Verdict::{Failed, Passed};
        assert_eq!(verdicts(&|_| ()), [Passed, Passed, Failed, Passed, Passed]);
        // It waited when time was up, and two gaps had gone by: it has missed at least these.
        let waits = |outcome: &mut Outcome| {
            outcome.metrics = vec![None];
            outcome.ending.reason = StopReason::Horizon;
            let open = [Some(sim::measure::Open::at_least(2.0))].into_iter().collect();
            outcome.cut_off = Some(Box::new(crate::CutOff { open, ..Default::default() }));
        };
        let found = verdicts(&waits);
        assert_eq!(found[..3], [Failed, Passed, Failed]);
        assert!(found[3..].iter().all(|verdict| *verdict != Passed), "{found:?}");
        // Hit, or after the last vehicle: neither few nor many.
        assert_eq!(verdicts(&|outcome| outcome.metrics = vec![None])[..3], [Failed, Failed, Failed]);
    }

    #[test]
    fn a_flag_that_needs_a_red_light_is_untested_where_none_was_met() {
        let red = |aggregate: fn(Comparison) -> Aggregate, bound: f64| {
            let mut criterion = criterion("ran_red", None);
            let Claim::Runs { comparison, .. } = criterion.claim.clone() else { unreachable!() };
            let comparison = Comparison {
                relation: Relation::Equal,
                bound: 1.0.into(),
                when_undefined: WhenUndefined::AsDeclared,
                ..comparison
            };
            criterion.claim = Claim::Aggregate {
                aggregate: aggregate(comparison),
                relation: Relation::LessOrEqual,
                bound: bound.into(),
                when_undefined: WhenUndefined::AsDeclared,
                confidence: None,
            };
            criterion
        };
        let mut never = criterion("ran_red", None);
        if let Claim::Runs { comparison, .. } = &mut never.claim {
            comparison.relation = Relation::Equal;
            comparison.bound = 0.0.into();
            comparison.when_undefined = WhenUndefined::AsDeclared;
        }
        let criteria = [never, red(Aggregate::Rate, 0.0), red(Aggregate::Count, 0.0)];
        let of = |value| {
            let findings = judged(&criteria, value, &[&[GOES]]);
            findings.into_iter().map(|one| (one.verdict, one.untested)).collect::<Vec<_>>()
        };
        assert!(
            of(None).iter().all(|one| *one == (Verdict::Passed, Some(Untested::NoValue))),
            "{:?}",
            of(None)
        );
        assert!(of(Some(0.0)).iter().all(|one| *one == (Verdict::Passed, None)));
        assert!(of(Some(1.0)).iter().all(|one| *one == (Verdict::Failed, None)));
    }
}
