//! What a criterion over many runs says of a single one.

use scenario::{
    Absence, Aggregate, AggregateResponse, Claim, Comparison, Criterion, Relation, WhenUndefined,
};

/// A criterion as it bears on one run.
#[derive(Debug, Clone, PartialEq)]
pub struct PerRun {
    /// That this run, and every other, fulfils what the criterion is about.
    pub criterion: Criterion,
    /// Whether one run that does not is enough for the criterion to fail. Where it is not, a share, a count or an
    /// aggregate over the runs decides.
    pub decisive: bool,
}

/// What the criterion wants of each run; `None` where it says nothing of single runs, such as of a spread.
pub fn per_run(criterion: &Criterion) -> Option<PerRun> {
    let (comparison, decisive) = match &criterion.claim {
        Claim::Runs { comparison, share, .. } => (comparison.clone(), share.is_none()),
        Claim::Aggregate { aggregate, relation, bound, .. } => {
            let upward = match relation {
                Relation::Greater | Relation::GreaterOrEqual => true,
                Relation::Less | Relation::LessOrEqual => false,
                Relation::Equal | Relation::NotEqual => return None,
            };
            match aggregate {
                Aggregate::Rate(comparison) | Aggregate::Count(comparison) if upward => {
                    (comparison.clone(), false)
                }
                Aggregate::Rate(comparison) | Aggregate::Count(comparison) => (negated(comparison), false),
                of_values if of_values.response() == AggregateResponse::Spread => return None,
                of_values => {
                    let metric = of_values.metric();
                    let comparison = Comparison {
                        metric: metric.clone(),
                        relation: *relation,
                        bound: bound.clone(),
                        // An aggregate leaves out the runs in which its metric does not exist, unless that is worse than
                        // any value.
                        when_undefined: match metric.known().map(|metric| metric.absence) {
                            Some(Absence::Bad) => WhenUndefined::AsDeclared,
                            _ => WhenUndefined::Passes,
                        },
                    };
                    (comparison, of_values.is_broken_by_one(upward))
                }
            }
        }
    };
    let claim = Claim::Runs { comparison, share: None, confidence: None };
    Some(PerRun { criterion: Criterion { claim, ..criterion.clone() }, decisive })
}

/// The comparison that holds exactly where this one does not.
fn negated(comparison: &Comparison) -> Comparison {
    Comparison {
        metric: comparison.metric.clone(),
        relation: comparison.relation.opposite(),
        bound: comparison.bound.clone(),
        when_undefined: match comparison.when_undefined {
            WhenUndefined::Passes => WhenUndefined::Fails,
            WhenUndefined::Fails => WhenUndefined::Passes,
            WhenUndefined::AsDeclared => WhenUndefined::AsDeclared,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::{Expression, MetricReference, Origin, Reach, Value};

    fn metric(name: &str) -> MetricReference {
        models::known::measured(name)
    }

    fn comparison(relation: Relation, bound: f64, when_undefined: WhenUndefined) -> Comparison {
        Comparison { metric: metric("pet"), relation, bound: bound.into(), when_undefined }
    }

    fn wanted(claim: Claim) -> Option<(Comparison, bool)> {
        let criterion = Criterion {
            claim,
            when: Vec::new(),
            text: String::new(),
            reach: Reach::default(),
            origin: Origin::default(),
        };
        let PerRun { criterion, decisive } = per_run(&criterion)?;
        match criterion.claim {
            Claim::Runs { comparison, share: None, confidence: None } => Some((comparison, decisive)),
            other => panic!("{other:?} is no claim on every run"),
        }
    }

    fn aggregate(aggregate: Aggregate, relation: Relation) -> Claim {
        Claim::Aggregate {
            aggregate,
            relation,
            bound: Expression::Constant(Value::Number(2.0)),
            when_undefined: WhenUndefined::Fails,
            confidence: None,
        }
    }

    #[test]
    fn only_what_has_to_hold_in_every_run_is_decided_by_one() {
        let one = comparison(Relation::Less, 1.5, WhenUndefined::Fails);
        let runs = |share| Claim::Runs { comparison: one.clone(), share, confidence: None };
        assert_eq!(wanted(runs(None)), Some((one.clone(), true)));
        assert_eq!(wanted(runs(Some(0.8))), Some((one.clone(), false)));
        let upward = wanted(aggregate(Aggregate::Rate(one.clone()), Relation::GreaterOrEqual));
        assert_eq!(upward, Some((one.clone(), false)));
        let not = comparison(Relation::GreaterOrEqual, 1.5, WhenUndefined::Passes);
        assert_eq!(wanted(aggregate(Aggregate::Count(one), Relation::LessOrEqual)), Some((not, false)));
    }

    #[test]
    fn aggregates_of_values_want_each_value_on_the_right_side() {
        let at_least = comparison(Relation::GreaterOrEqual, 2.0, WhenUndefined::Passes);
        let relation = Relation::GreaterOrEqual;
        for (one, decisive) in [
            (Aggregate::Min(metric("pet")), true),
            (Aggregate::Max(metric("pet")), false),
            (Aggregate::Mean(metric("pet")), false),
            (Aggregate::Quantile(0.05, metric("pet")), false),
        ] {
            assert_eq!(wanted(aggregate(one, relation)), Some((at_least.clone(), decisive)));
        }
        assert_eq!(wanted(aggregate(Aggregate::Std(metric("pet")), Relation::Less)), None);
        assert_eq!(wanted(aggregate(Aggregate::Mean(metric("pet")), Relation::Equal)), None);
    }
}
