//! What a criterion can come to, whatever happens: where it cannot fail or can never pass.

use super::seen::{Seen, holds_undefined};
use scenario::{
    Absence, Aggregate, AggregateResponse, Claim, Comparison, Criterion, MetricKind, MetricRange,
    MetricReference, Relation, Scope, WhenUndefined, constant, significant,
};
use sim::measure::Open;

/// What a criterion can come to.
#[derive(Debug, Clone, PartialEq)]
pub enum Possible {
    /// Both ways, depending on the runs.
    Both,
    /// It holds whatever happens: why.
    NeverFails(String),
    /// Every value holds, but a run in which the metric does not exist does not: why.
    OnlyAbsence {
        /// What makes every value hold, in words.
        why: String,
        /// Such as `in which \`pet\` does not exist`.
        fails_by: String,
    },
    /// It holds whatever happens never: why.
    NeverHolds(String),
}

/// Whether a criterion with constant bounds holds in any `runs` runs, whatever happens in them.
pub(super) fn cannot_fail(criterion: &Criterion, runs: usize) -> bool {
    matches!(possible(criterion, runs), Possible::NeverFails(_))
}

/// What a criterion with constant bounds can come to in `runs` runs, whatever happens in them.
pub fn possible(criterion: &Criterion, runs: usize) -> Possible {
    let limits = Limits::of(criterion);
    match &criterion.claim {
        Claim::Runs { comparison, share: None, .. } => {
            let Truth { can_hold, can_fail, by_value, .. } = limits.truth(comparison, false);
            match (can_hold, can_fail) {
                (_, false) => Possible::NeverFails(limits.in_words()),
                (false, _) => Possible::NeverHolds(limits.in_words()),
                _ if !by_value => limits.only_absence(),
                _ => Possible::Both,
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
        let of_one = matches!(metric.scope, Scope::Vehicle | Scope::Vehicles | Scope::Contact);
        let is_word = matches!(metric.kind, MetricKind::Category(_));
        let unit = match &metric.kind {
            MetricKind::Quantity(scenario::Dimension::NUMBER) => String::new(),
            MetricKind::Quantity(dimension) => format!(" {}", dimension.si_unit()),
            MetricKind::Flag | MetricKind::Category(_) => String::new(),
        };
        let is_time = metric.kind == MetricKind::Quantity(scenario::Dimension::TIME);
        Self {
            metric: reference,
            low,
            high,
            always_there: metric.absence == Absence::Open && (of_one || is_word),
            can_be_open: is_time
                || is_word
                || metric.kind == MetricKind::Flag
                || metric.scope == Scope::Stream,
            most_open: match metric.limits(&reference.settings, f64::INFINITY) {
                Some((_, most)) if is_time => most,
                None if is_time => f64::INFINITY,
                _ => high,
            },
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
        between(relation, bound, (self.low, self.high))
    }

    /// The share of runs in which a comparison holds, or the number of them of `counted`.
    fn of_share(
        &self,
        comparison: &Comparison,
        relation: Relation,
        bound: f64,
        counted: Option<usize>,
    ) -> Possible {
        let truth = self.truth(comparison, bounded_above(relation));
        let all = counted.map_or(1.0, |runs| runs as f64);
        let least = if truth.can_fail { 0.0 } else { all };
        let most = if truth.can_hold { all } else { 0.0 };
        let why = match counted {
            _ if !(truth.can_fail && truth.can_hold) => self.in_words(),
            None => "a share of runs lies between 0 % and 100 %".to_string(),
            Some(runs) => format!("a number of runs lies between 0 and all, which are {runs}"),
        };
        match between(relation, bound, (least, most)) {
            // That few runs are without a value is not what a bound on those with one is for.
            (true, true) if bounded_above(relation) && !truth.held_by_value && relation.holds(0.0, bound) => {
                self.only_absence()
            }
            (true, true) => Possible::Both,
            (true, false) => Possible::NeverFails(why),
            (false, _) => Possible::NeverHolds(why),
        }
    }

    fn of_values(
        &self,
        aggregate: &Aggregate,
        relation: Relation,
        bound: f64,
        when_undefined: WhenUndefined,
    ) -> Possible {
        if aggregate.response() == AggregateResponse::Spread {
            let why = "a spread is never below 0".to_string();
            return match between(relation, bound, (0.0, f64::INFINITY)) {
                (true, true) => Possible::Both,
                (true, false) => Possible::OnlyAbsence { why, fails_by: self.fails_by() },
                (false, _) => Possible::NeverHolds(why),
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
            (false, _) => Possible::NeverHolds(self.in_words()),
            (true, true) => Possible::Both,
            (true, false) if only_open => self.only_absence(),
            // Where no run has a value there is nothing to compare.
            (true, false) if self.always_there || when_undefined == WhenUndefined::Passes => {
                Possible::NeverFails(self.in_words())
            }
            (true, false) => self.only_absence(),
        }
    }

    fn only_absence(&self) -> Possible {
        Possible::OnlyAbsence { why: self.in_words(), fails_by: self.fails_by() }
    }

    /// Which runs a criterion can fail by that every value holds.
    fn fails_by(&self) -> String {
        let absent = format!("in which `{}` does not exist", self.metric.name());
        let open = "that end before it is decided";
        match (self.always_there, self.can_be_open) {
            (true, _) => open.to_string(),
            (false, false) => absent,
            (false, true) => format!("{absent}, or {open}"),
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
fn between(relation: Relation, bound: f64, (low, high): (f64, f64)) -> (bool, bool) {
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

/// Whether a claim would rather have a comparison not hold.
pub(super) fn bounded_above(relation: Relation) -> bool {
    matches!(relation, Relation::Less | Relation::LessOrEqual)
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::metrics::metrics;
    use scenario::{Origin, Reach};
    use scenario::{Settings, Value};

    const LONGEST: f64 = 60.0;

    fn of(claim: Claim) -> Criterion {
        let reference = claim.metric();
        let limits = reference.known().and_then(|known| known.limits(&reference.settings, LONGEST));
        let reach = Reach { limits, ..Reach::default() };
        Criterion { claim, when: Vec::new(), text: String::new(), reach, origin: Origin::default() }
    }

    fn comparison(name: &str, relation: Relation, bound: f64, when_undefined: WhenUndefined) -> Comparison {
        let metric = models::known::measured(name);
        Comparison { metric, relation, bound: bound.into(), when_undefined }
    }

    fn runs(name: &str, relation: Relation, bound: f64) -> Possible {
        let comparison = comparison(name, relation, bound, WhenUndefined::AsDeclared);
        possible(&of(Claim::Runs { comparison, share: None, confidence: None }), 10)
    }

    fn summed_up(aggregate: Aggregate, relation: Relation, bound: f64) -> Possible {
        let (bound, when_undefined) = (bound.into(), WhenUndefined::AsDeclared);
        possible(&of(Claim::Aggregate { aggregate, relation, bound, when_undefined, confidence: None }), 10)
    }

    fn never_fails(found: Possible) -> bool {
        matches!(found, Possible::NeverFails(_))
    }

    fn never_holds(found: Possible) -> bool {
        matches!(found, Possible::NeverHolds(_))
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
            assert_eq!(rate(relation, bound), Possible::Both, "{relation:?} {bound}");
        }
        let count = |relation, bound| summed_up(Aggregate::Count(collision()), relation, bound);
        assert!(never_fails(count(GreaterOrEqual, 0.0)) && never_fails(count(LessOrEqual, 10.0)));
        assert!(never_holds(count(Greater, 10.0)) && never_fails(count(Less, 11.0)));
        assert_eq!(count(LessOrEqual, 9.0), Possible::Both);
    }

    #[test]
    fn what_absence_and_the_horizon_can_do_counts() {
        assert!(never_fails(runs("stopped_time", GreaterOrEqual, 0.0)));
        assert_eq!(runs("stopped_time", Greater, 0.0), Possible::Both);
        // Whoever has not arrived when time is up has stopped for nobody knows how long.
        for bound in [LONGEST, 100.0] {
            let found = runs("stopped_time", LessOrEqual, bound);
            assert!(matches!(found, Possible::OnlyAbsence { .. }), "{bound}: {found:?}");
        }
        assert_eq!(runs("stopped_time", LessOrEqual, LONGEST - 0.001), Possible::Both);
        assert!(matches!(runs("pet", LessOrEqual, LONGEST), Possible::OnlyAbsence { .. }));
        assert!(never_holds(runs("stopped_time", Greater, 100.0)));
        // Who never arrives is worse than any bound.
        assert!(matches!(runs("time_lost", LessOrEqual, 100.0), Possible::OnlyAbsence { .. }));
        assert_eq!(runs("time_lost", GreaterOrEqual, 100.0), Possible::Both);
        assert!(
            never_holds(runs("time_lost", Less, 0.0)) && never_fails(runs("time_lost", GreaterOrEqual, 0.0))
        );
        // Where there was no danger is better than any.
        assert!(never_fails(runs("drac", LessOrEqual, 25.0)) && never_holds(runs("drac", Greater, 25.0)));
        assert!(never_fails(runs("min_ttc", GreaterOrEqual, 0.0)) && never_holds(runs("min_ttc", Less, 0.0)));
        // Neither is sure, so that the claim says at least that there is a value.
        assert!(matches!(runs("pet", GreaterOrEqual, 0.0), Possible::OnlyAbsence { .. }));
        assert!(never_holds(runs("pet", Less, 0.0)));
        let there = comparison("pet", GreaterOrEqual, 0.0, WhenUndefined::AsDeclared);
        assert_eq!(summed_up(Aggregate::Rate(there), GreaterOrEqual, 0.8), Possible::Both);
        // A share of runs with a value that there cannot be is bounded by nothing but absence.
        for bound in [0.0, -1.0] {
            let never = comparison("pet", Less, bound, WhenUndefined::AsDeclared);
            let found = summed_up(Aggregate::Rate(never), LessOrEqual, 0.0);
            assert!(matches!(found, Possible::OnlyAbsence { .. }), "{bound}: {found:?}");
        }
        let seldom = comparison("pet", Less, 0.5, WhenUndefined::AsDeclared);
        assert_eq!(summed_up(Aggregate::Rate(seldom), LessOrEqual, 0.0), Possible::Both);
        let excused = comparison("pet", GreaterOrEqual, 0.0, WhenUndefined::Passes);
        assert!(never_fails(possible(
            &of(Claim::Runs { comparison: excused, share: None, confidence: None }),
            10
        )));
        assert_eq!(runs("pedestrian_delay", GreaterOrEqual, 0.0), Possible::Both);
    }

    #[test]
    fn what_parameters_make_a_metric_blind_to_cannot_fail() {
        let of_braking = |name: &str, settings: Settings, relation, bound: f64| {
            let mut comparison = comparison(name, relation, bound, WhenUndefined::AsDeclared);
            comparison.metric.settings = settings;
            possible(&of(Claim::Runs { comparison, share: None, confidence: None }), 10)
        };
        let standstill = |speed| Settings::from([("standstill", Value::Number(speed))]);
        for (name, relation, bound) in
            [("max_deceleration", LessOrEqual, 3.0), ("sudden_speed_change", Equal, 0.0)]
        {
            assert!(never_fails(of_braking(name, standstill(100.0), relation, bound)), "{name}");
            assert_eq!(of_braking(name, standstill(1.0), relation, bound), Possible::Both, "{name}");
        }
        assert!(never_holds(of_braking("sudden_speed_change", standstill(100.0), Equal, 1.0)));
    }

    #[test]
    fn sums_of_values_lie_where_the_values_do() {
        let metric = |name: &str| models::known::measured(name);
        let mean = |name, relation, bound| summed_up(Aggregate::Mean(metric(name)), relation, bound);
        assert!(never_fails(mean("stopped_time", GreaterOrEqual, 0.0)));
        assert!(never_holds(mean("stopped_time", Less, 0.0)));
        assert!(matches!(mean("min_distance", GreaterOrEqual, 0.0), Possible::OnlyAbsence { .. }));
        assert_eq!(mean("drac", LessOrEqual, 19.0), Possible::Both);
        assert!(matches!(mean("drac", LessOrEqual, 20.0), Possible::OnlyAbsence { .. }));
        // Runs without danger count as less than any value here.
        assert_eq!(mean("drac", GreaterOrEqual, 0.0), Possible::Both);
        assert!(matches!(
            summed_up(Aggregate::Std(metric("pet")), GreaterOrEqual, 0.0),
            Possible::OnlyAbsence { .. }
        ));
    }

    #[test]
    fn ordinary_criteria_of_every_metric_can_do_both() {
        for metric in metrics() {
            let name = &*metric.declaration.name;
            match &metric.kind {
                MetricKind::Quantity(_) => {
                    let ordinary = if metric.range == MetricRange::Share { 0.5 } else { 1.5 };
                    for relation in [Less, LessOrEqual, Greater, GreaterOrEqual] {
                        assert_eq!(runs(name, relation, ordinary), Possible::Both, "{name} {relation:?}");
                    }
                }
                MetricKind::Flag => {
                    for (relation, bound) in [(Equal, 0.0), (Equal, 1.0), (NotEqual, 0.0)] {
                        assert_eq!(runs(name, relation, bound), Possible::Both, "{name} {bound}");
                    }
                }
                MetricKind::Category(words) => {
                    for bound in 0..words.len() {
                        assert_eq!(runs(name, Equal, bound as f64), Possible::Both, "{name} {bound}");
                        assert_eq!(runs(name, NotEqual, bound as f64), Possible::Both, "{name} {bound}");
                    }
                }
            }
        }
    }
}
