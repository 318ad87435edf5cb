//! Criteria that say nothing, whatever the runs come to: those that cannot fail, and those that can never pass.

use std::collections::BTreeMap;

use super::budget::at;
use super::criteria::bounded_above;
use super::seen::{Seen, holds_undefined};
use crate::lang::{Code, Diagnostic, Sources};
use crate::metrics::Open;
use crate::plan;
use crate::scenario::{
    Absence, Aggregate, Claim, Comparison, Criterion, Expression, MetricKind, MetricRange, MetricReference,
    Relation, Scenario, Scope, Suite, Value, WhenUndefined, constant, significant,
};
use crate::sim;

/// What a criterion can come to.
#[derive(Debug, Clone, PartialEq)]
enum Power {
    /// Both ways, depending on the runs.
    Decides,
    /// It holds whatever happens: why.
    NeverFails(String),
    /// Every value holds, but a run in which the metric does not exist does not: why.
    OnlyAbsence(String),
    /// It holds whatever happens never: why.
    NeverHolds(String),
}

/// A warning for every criterion that cannot fail, and an error for every one that can never pass, in none of the trials that
/// it applies to. What cannot be planned is left to planning.
pub fn examine_bounds(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let mut found: Vec<Diagnostic> = Vec::new();
    for scenario in &suite.scenarios {
        for (criterion, power) in of_scenario(suite, scenario) {
            let Some(finding) = finding(criterion, power, sources) else { continue };
            // What a template or a suite says of several scenarios is said once.
            let same = |one: &Diagnostic| (one.span(), &one.message) == (finding.span(), &finding.message);
            if !found.iter().any(same) {
                found.push(finding);
            }
        }
    }
    found
}

/// Whether a criterion with constant bounds holds in any `runs` runs, whatever happens in them.
pub(super) fn cannot_fail(criterion: &Criterion, runs: usize) -> bool {
    matches!(power(criterion, runs), Power::NeverFails(_))
}

fn of_scenario<'s>(suite: &Suite, scenario: &'s Scenario) -> Vec<(&'s Criterion, Power)> {
    let people = plan::select_people(suite.seed, scenario).map_or(1, |people| people.len());
    let most = scenario.runs.as_ref().map(|budget| budget.most as usize);
    let runs = most.unwrap_or_else(|| people.saturating_mul(scenario.repeat as usize));
    let longest = sim::longest_run(scenario.horizon, scenario.step);
    let known = |criterion: &Criterion| {
        let mut criterion = criterion.clone();
        let reference = criterion.claim.metric();
        criterion.reach.limits =
            reference.known().and_then(|known| known.limits(&reference.settings, longest));
        for bound in criterion.claim.bounds_mut() {
            *bound = Expression::Constant(bound.evaluate(&BTreeMap::<String, Value>::new()).ok()?);
        }
        Some(criterion)
    };
    let depends = scenario.criteria.iter().any(|criterion| known(criterion).is_none());
    let trials = if depends { plan::outline(suite, scenario).unwrap_or_default() } else { Vec::new() };
    let of = |criterion: &'s Criterion| {
        if let Some(known) = known(criterion) {
            return Some((criterion, power(&known, runs)));
        }
        let applying = trials.iter().flat_map(|trial| &trial.criteria);
        let same = applying.filter(|one| (&one.origin, &one.text) == (&criterion.origin, &criterion.text));
        let mut powers = same.map(|known| power(known, runs));
        let first = powers.next()?;
        let agree = powers.all(|other| std::mem::discriminant(&other) == std::mem::discriminant(&first));
        Some((criterion, if agree { first } else { Power::Decides }))
    };
    scenario.criteria.iter().filter_map(of).collect()
}

fn finding(criterion: &Criterion, power: Power, sources: &Sources) -> Option<Diagnostic> {
    let text = &criterion.text;
    let other_side = "bound it from the other side, claim more, or leave it out";
    Some(match power {
        Power::Decides => return None,
        Power::NeverFails(why) => {
            at(Code::CannotFail, &criterion.origin, format!("`{text}` cannot fail"), sources)
                .label("holds whatever happens")
                .note(why)
                .hint(other_side)
        }
        Power::OnlyAbsence(why) => {
            let metric = &criterion.claim.metric().name();
            let message = format!("no value of `{metric}` makes `{text}` fail");
            let Limits { always_there, can_be_open, .. } = Limits::of(criterion);
            let absent = format!("in which `{metric}` does not exist");
            let open = "that end before it is decided";
            let only_by = match (always_there, can_be_open) {
                (true, _) => open.to_string(),
                (false, false) => absent,
                (false, true) => format!("{absent}, or {open}"),
            };
            at(Code::CannotFail, &criterion.origin, message, sources)
                .label("holds for every value that there can be")
                .note(why)
                .note(format!("it fails only by runs {only_by}"))
                .hint(other_side)
        }
        Power::NeverHolds(why) => {
            at(Code::NeverHolds, &criterion.origin, format!("`{text}` can never pass"), sources)
                .label("fails whatever happens")
                .note(why)
                .hint("claim what a run can come to")
        }
    })
}

fn power(criterion: &Criterion, runs: usize) -> Power {
    let limits = Limits::of(criterion);
    match &criterion.claim {
        Claim::Runs { comparison, share: None, .. } => {
            let Truth { can_hold, can_fail, by_value, .. } = limits.truth(comparison, false);
            match (can_hold, can_fail) {
                (_, false) => Power::NeverFails(limits.in_words()),
                (false, _) => Power::NeverHolds(limits.in_words()),
                _ if !by_value => Power::OnlyAbsence(limits.in_words()),
                _ => Power::Decides,
            }
        }
        Claim::Runs { comparison, share: Some(share), .. } => {
            limits.of_share(comparison, Relation::GreaterOrEqual, *share, None)
        }
        Claim::Aggregate { aggregate, relation, bound, when_undefined, .. } => {
            let bound = constant(bound);
            match aggregate {
                Aggregate::Rate(comparison) => limits.of_share(comparison, *relation, bound, None),
                Aggregate::Count(comparison) => limits.of_share(comparison, *relation, bound, Some(runs)),
                _ => limits.of_values(aggregate, *relation, bound, *when_undefined),
            }
        }
    }
}

/// Whether a comparison can hold in a run and whether it can fail, and whether a value can make it do so.
struct Truth {
    can_hold: bool,
    can_fail: bool,
    held_by_value: bool,
    by_value: bool,
}

/// What values a criterion's metric can have.
struct Limits<'c> {
    metric: &'c MetricReference,
    low: f64,
    high: f64,
    /// Whether it exists in every run.
    always_there: bool,
    /// Whether the horizon can end a run before it is decided.
    can_be_open: bool,
    /// What it could have come to at most without a horizon.
    most_open: f64,
    /// SI unit, with the blank before it.
    unit: String,
}

impl<'c> Limits<'c> {
    fn of(criterion: &'c Criterion) -> Self {
        let reference = criterion.claim.metric();
        let metric = reference.known().expect("criteria are about registered metrics");
        let (low, high) = criterion.reach.limits.unwrap_or(match (&metric.range, &metric.kind) {
            (MetricRange::NotNegative, _) => (0.0, f64::INFINITY),
            (_, MetricKind::Category(words)) => (0.0, words.len() as f64 - 1.0),
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        });
        let of_one = matches!(metric.scope, Scope::Vehicle | Scope::Contact);
        let is_word = matches!(metric.kind, MetricKind::Category(_));
        let unit = match &metric.kind {
            MetricKind::Quantity(dimension) => format!(" {}", dimension.si_unit()),
            MetricKind::Flag | MetricKind::Category(_) => String::new(),
        };
        let is_time = metric.kind == MetricKind::Quantity(crate::scenario::Dimension::TIME);
        Self {
            metric: reference,
            low,
            high,
            always_there: metric.absence == Absence::Open && (of_one || is_word),
            can_be_open: is_time || is_word || metric.kind == MetricKind::Flag,
            most_open: if is_time { f64::INFINITY } else { high },
            unit,
        }
    }

    fn truth(&self, comparison: &Comparison, unknown: bool) -> Truth {
        let bound = comparison.constant_bound();
        let (hold, fail) = self.of_ends(comparison.relation, bound);
        let mut truth = Truth { can_hold: hold, can_fail: fail, held_by_value: hold, by_value: fail };
        if !self.always_there {
            let holds = holds_undefined(comparison, unknown);
            truth.can_hold |= holds;
            truth.can_fail |= !holds;
        }
        if self.can_be_open {
            for so_far in [self.low, self.high] {
                let range = Open { low: so_far, high: self.most_open };
                let holds = Seen::Open { so_far: None, range }.holds(comparison, unknown);
                truth.can_hold |= holds;
                truth.can_fail |= !holds;
                truth.held_by_value |= holds;
            }
        }
        truth
    }

    /// Whether some value between the limits holds, and whether some does not.
    fn of_ends(&self, relation: Relation, bound: f64) -> (bool, bool) {
        possible(relation, bound, (self.low, self.high))
    }

    /// The share of runs in which a comparison holds, or the number of them of `counted`.
    fn of_share(
        &self,
        comparison: &Comparison,
        relation: Relation,
        bound: f64,
        counted: Option<usize>,
    ) -> Power {
        let truth = self.truth(comparison, bounded_above(relation));
        let all = counted.map_or(1.0, |runs| runs as f64);
        let least = if truth.can_fail { 0.0 } else { all };
        let most = if truth.can_hold { all } else { 0.0 };
        let why = match counted {
            _ if !(truth.can_fail && truth.can_hold) => self.in_words(),
            None => "a share of runs lies between 0 % and 100 %".to_string(),
            Some(runs) => format!("a number of runs lies between 0 and all, which are {runs}"),
        };
        match possible(relation, bound, (least, most)) {
            // That few runs are without a value is not what a bound on those with one is for.
            (true, true) if bounded_above(relation) && !truth.held_by_value && relation.holds(0.0, bound) => {
                Power::OnlyAbsence(self.in_words())
            }
            (true, true) => Power::Decides,
            (true, false) => Power::NeverFails(why),
            (false, _) => Power::NeverHolds(why),
        }
    }

    fn of_values(
        &self,
        aggregate: &Aggregate,
        relation: Relation,
        bound: f64,
        when_undefined: WhenUndefined,
    ) -> Power {
        if let Aggregate::Std(_) = aggregate {
            let why = "a spread is never below 0".to_string();
            return match possible(relation, bound, (0.0, f64::INFINITY)) {
                (true, true) => Power::Decides,
                (true, false) => Power::OnlyAbsence(why),
                (false, _) => Power::NeverHolds(why),
            };
        }
        let (mut hold, mut fail) = self.of_ends(relation, bound);
        let fails =
            |seen: Seen| seen.worst(self.metric, relation).is_some_and(|worst| !relation.holds(worst, bound));
        let open = |low| Seen::Open { so_far: None, range: Open { low, high: self.most_open } };
        let only_open = self.can_be_open && [self.low, self.high].into_iter().any(|low| fails(open(low)));
        if !self.always_there {
            fail |= fails(Seen::Undefined);
            hold |= when_undefined == WhenUndefined::Passes;
        }
        match (hold, fail) {
            (false, _) => Power::NeverHolds(self.in_words()),
            (true, true) => Power::Decides,
            (true, false) if only_open => Power::OnlyAbsence(self.in_words()),
            // Where no run has a value there is nothing to compare.
            (true, false) if self.always_there || when_undefined == WhenUndefined::Passes => {
                Power::NeverFails(self.in_words())
            }
            (true, false) => Power::OnlyAbsence(self.in_words()),
        }
    }

    fn in_words(&self) -> String {
        let Self { metric, low, high, unit, .. } = self;
        let show = |value: f64| format!("{}{unit}", significant(value, 6));
        match (low.is_finite(), high.is_finite()) {
            (true, true) => format!("`{}` lies between {} and {}", metric.name(), show(*low), show(*high)),
            (true, false) => format!("`{}` is never below {}", metric.name(), show(*low)),
            _ => format!("`{}` can be anything", metric.name()),
        }
    }
}

/// Whether something between two ends, both included, is in `relation` to `bound`, and whether something is not.
fn possible(relation: Relation, bound: f64, (low, high): (f64, f64)) -> (bool, bool) {
    let inside = low <= bound && bound <= high;
    let point = low == high && inside;
    match relation {
        Relation::Equal => (inside, !point),
        Relation::NotEqual => (!point, inside),
        _ => {
            let (one, other) = (relation.holds(low, bound), relation.holds(high, bound));
            (one || other, !(one && other))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::metrics;
    use crate::scenario::Settings;
    use crate::scenario::{Origin, Reach};

    const LONGEST: f64 = 60.0;

    fn of(claim: Claim) -> Criterion {
        let reference = claim.metric();
        let limits = reference.known().and_then(|known| known.limits(&reference.settings, LONGEST));
        let reach = Reach { people: None, limits };
        Criterion { claim, when: Vec::new(), text: String::new(), reach, origin: Origin::default() }
    }

    fn comparison(name: &str, relation: Relation, bound: f64, when_undefined: WhenUndefined) -> Comparison {
        let metric = crate::models::known::measured(name);
        Comparison { metric, relation, bound: bound.into(), when_undefined }
    }

    fn runs(name: &str, relation: Relation, bound: f64) -> Power {
        let comparison = comparison(name, relation, bound, WhenUndefined::AsDeclared);
        power(&of(Claim::Runs { comparison, share: None, confidence: None }), 10)
    }

    fn summed_up(aggregate: Aggregate, relation: Relation, bound: f64) -> Power {
        let (bound, when_undefined) = (bound.into(), WhenUndefined::AsDeclared);
        power(&of(Claim::Aggregate { aggregate, relation, bound, when_undefined, confidence: None }), 10)
    }

    fn never_fails(power: Power) -> bool {
        matches!(power, Power::NeverFails(_))
    }

    fn never_holds(power: Power) -> bool {
        matches!(power, Power::NeverHolds(_))
    }

    use Relation::{Equal, Greater, GreaterOrEqual, Less, LessOrEqual, NotEqual};

    #[test]
    fn shares_and_counts_have_ends() {
        let collision = || comparison("collision", Equal, 1.0, WhenUndefined::AsDeclared);
        let rate = |relation, bound| summed_up(Aggregate::Rate(collision()), relation, bound);
        assert!(never_fails(rate(GreaterOrEqual, 0.0)) && never_fails(rate(LessOrEqual, 1.0)));
        assert!(never_holds(rate(Less, 0.0)) && never_holds(rate(Greater, 1.0)));
        for (relation, bound) in [
            (Greater, 0.0),
            (LessOrEqual, 0.0),
            (GreaterOrEqual, 1.0),
            (Less, 1.0),
            (LessOrEqual, 0.05),
            (Equal, 0.0),
            (NotEqual, 1.0),
        ] {
            assert_eq!(rate(relation, bound), Power::Decides, "{relation:?} {bound}");
        }
        let count = |relation, bound| summed_up(Aggregate::Count(collision()), relation, bound);
        assert!(never_fails(count(GreaterOrEqual, 0.0)) && never_fails(count(LessOrEqual, 10.0)));
        assert!(never_holds(count(Greater, 10.0)) && never_fails(count(Less, 11.0)));
        assert_eq!(count(LessOrEqual, 9.0), Power::Decides);
    }

    #[test]
    fn what_absence_and_the_horizon_can_do_counts() {
        assert!(never_fails(runs("stopped_time", GreaterOrEqual, 0.0)));
        assert_eq!(runs("stopped_time", Greater, 0.0), Power::Decides);
        // Whoever has not arrived when time is up has stopped for nobody knows how long.
        for bound in [LONGEST, 100.0] {
            let power = runs("stopped_time", LessOrEqual, bound);
            assert!(matches!(power, Power::OnlyAbsence(_)), "{bound}: {power:?}");
        }
        assert_eq!(runs("stopped_time", LessOrEqual, LONGEST - 0.001), Power::Decides);
        assert!(matches!(runs("pet", LessOrEqual, LONGEST), Power::OnlyAbsence(_)));
        assert!(never_holds(runs("stopped_time", Greater, 100.0)));
        // Who never arrives is worse than any bound.
        assert!(matches!(runs("time_lost", LessOrEqual, 100.0), Power::OnlyAbsence(_)));
        assert_eq!(runs("time_lost", GreaterOrEqual, 100.0), Power::Decides);
        assert!(
            never_holds(runs("time_lost", Less, 0.0)) && never_fails(runs("time_lost", GreaterOrEqual, 0.0))
        );
        // Where there was no danger is better than any.
        assert!(never_fails(runs("drac", LessOrEqual, 25.0)) && never_holds(runs("drac", Greater, 25.0)));
        assert!(never_fails(runs("min_ttc", GreaterOrEqual, 0.0)) && never_holds(runs("min_ttc", Less, 0.0)));
        // Neither is sure, so that the claim says at least that there is a value.
        assert!(matches!(runs("pet", GreaterOrEqual, 0.0), Power::OnlyAbsence(_)));
        assert!(never_holds(runs("pet", Less, 0.0)));
        let there = comparison("pet", GreaterOrEqual, 0.0, WhenUndefined::AsDeclared);
        assert_eq!(summed_up(Aggregate::Rate(there), GreaterOrEqual, 0.8), Power::Decides);
        // A share of runs with a value that there cannot be is bounded by nothing but absence.
        for bound in [0.0, -1.0] {
            let never = comparison("pet", Less, bound, WhenUndefined::AsDeclared);
            let power = summed_up(Aggregate::Rate(never), LessOrEqual, 0.0);
            assert!(matches!(power, Power::OnlyAbsence(_)), "{bound}: {power:?}");
        }
        let seldom = comparison("pet", Less, 0.5, WhenUndefined::AsDeclared);
        assert_eq!(summed_up(Aggregate::Rate(seldom), LessOrEqual, 0.0), Power::Decides);
        let excused = comparison("pet", GreaterOrEqual, 0.0, WhenUndefined::Passes);
        assert!(never_fails(power(
            &of(Claim::Runs { comparison: excused, share: None, confidence: None }),
            10
        )));
        assert_eq!(runs("pedestrian_delay", GreaterOrEqual, 0.0), Power::Decides);
    }

    #[test]
    fn what_parameters_make_a_metric_blind_to_cannot_fail() {
        let of_braking = |name: &str, settings: Settings, relation, bound: f64| {
            let mut comparison = comparison(name, relation, bound, WhenUndefined::AsDeclared);
            comparison.metric.settings = settings;
            power(&of(Claim::Runs { comparison, share: None, confidence: None }), 10)
        };
        let standstill = |speed| Settings::from([("standstill", Value::Number(speed))]);
        for (name, relation, bound) in
            [("max_deceleration", LessOrEqual, 3.0), ("sudden_speed_change", Equal, 0.0)]
        {
            assert!(never_fails(of_braking(name, standstill(100.0), relation, bound)), "{name}");
            assert_eq!(of_braking(name, standstill(1.0), relation, bound), Power::Decides, "{name}");
        }
        assert!(never_holds(of_braking("sudden_speed_change", standstill(100.0), Equal, 1.0)));
    }

    #[test]
    fn sums_of_values_lie_where_the_values_do() {
        let metric = |name: &str| crate::models::known::measured(name);
        let mean = |name, relation, bound| summed_up(Aggregate::Mean(metric(name)), relation, bound);
        assert!(never_fails(mean("stopped_time", GreaterOrEqual, 0.0)));
        assert!(never_holds(mean("stopped_time", Less, 0.0)));
        assert!(matches!(mean("min_distance", GreaterOrEqual, 0.0), Power::OnlyAbsence(_)));
        assert_eq!(mean("drac", LessOrEqual, 19.0), Power::Decides);
        assert!(matches!(mean("drac", LessOrEqual, 20.0), Power::OnlyAbsence(_)));
        // Runs without danger count as less than any value here.
        assert_eq!(mean("drac", GreaterOrEqual, 0.0), Power::Decides);
        assert!(matches!(
            summed_up(Aggregate::Std(metric("pet")), GreaterOrEqual, 0.0),
            Power::OnlyAbsence(_)
        ));
    }

    #[test]
    fn ordinary_criteria_of_every_metric_can_do_both() {
        for metric in metrics() {
            let name = &*metric.declaration.name;
            match &metric.kind {
                MetricKind::Quantity(_) => {
                    for relation in [Less, LessOrEqual, Greater, GreaterOrEqual] {
                        assert_eq!(runs(name, relation, 1.5), Power::Decides, "{name} {relation:?}");
                    }
                }
                MetricKind::Flag => {
                    for (relation, bound) in [(Equal, 0.0), (Equal, 1.0), (NotEqual, 0.0)] {
                        assert_eq!(runs(name, relation, bound), Power::Decides, "{name} {bound}");
                    }
                }
                MetricKind::Category(words) => {
                    for bound in 0..words.len() {
                        assert_eq!(runs(name, Equal, bound as f64), Power::Decides, "{name} {bound}");
                        assert_eq!(runs(name, NotEqual, bound as f64), Power::Decides, "{name} {bound}");
                    }
                }
            }
        }
    }
}
