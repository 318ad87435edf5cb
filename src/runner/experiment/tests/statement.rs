//! Statements over the results of their suite.

use super::*;
use results::{BlockResult, Conclusion, StatementResult};

#[test]
fn a_tune_that_chose_nothing_leaves_its_condition_empty() {
    let mut suite = evaluated_suite();
    suite.tunes[0].constraints = vec![condition("min_distance", Relation::Greater, 1e6)];
    suite.statements = vec![statement(
        vec![compares(measured(Aggregate::Mean(metric("pet")), of("tuned")), Relation::Greater, 0.0)],
        DeclaredStanding::Reproduced,
    )];
    let results = run_all(&suite);
    let tuned = &results.evaluate("final").unwrap().conditions[1];
    assert_eq!(tuned.missing.as_deref(), Some("tune `braking` chose nothing"));
    assert!(tuned.runs.is_empty() && tuned.measured == [None; 3] && tuned.differences == [None; 3]);
    assert!(results.blocks["braking"].failure().is_some());
    let failure = results.blocks["gaps_rise"].failure();
    assert_eq!(failure.as_deref(), Some("is not comparable: tune `braking` chose nothing"));
}

fn of(condition: &str) -> OutcomesOf {
    OutcomesOf::Condition { evaluate: "final".into(), condition: condition.into() }
}

fn measured(aggregate: Aggregate, of: OutcomesOf) -> Quantity {
    Quantity::Measured(Measured { aggregate, of, when: Vec::new() })
}

fn compares(left: Quantity, relation: Relation, right: f64) -> StatementClaimKind {
    StatementClaimKind::Compares { left, relation, right: Quantity::Number(right) }
}

fn statement(claims: Vec<StatementClaimKind>, standing: DeclaredStanding) -> Statement {
    let claim = |kind| StatementClaim { kind, text: "a claim".into(), origin: Origin::default() };
    Statement {
        name: "gaps_rise".into(),
        doc: None,
        source: None,
        reported: None,
        claims: claims.into_iter().map(claim).collect(),
        standing,
        origin: Origin::default(),
    }
}

/// What one statement comes to over the results of its suite.
fn conclude(claims: Vec<StatementClaimKind>, standing: DeclaredStanding) -> StatementResult {
    let mut suite = evaluated_suite();
    suite.statements = vec![statement(claims, standing)];
    let mut results = run_all(&suite);
    match results.blocks.remove("gaps_rise") {
        Some(BlockResult::Statement(result)) => result,
        other => panic!("not a statement: {other:?}"),
    }
}

#[test]
fn claims_hold_or_not_by_the_numbers() {
    let when =
        |relation, bound: f64| VariationCondition { variable: "tta".into(), relation, bound: bound.into() };
    let people = || OutcomesOf::Scenario("encounter".into());
    let pet = || Aggregate::Mean(metric("pet"));
    let late = Measured { aggregate: pet(), of: people(), when: vec![when(Relation::GreaterOrEqual, 9.0)] };
    let early = Measured { aggregate: pet(), of: people(), when: vec![when(Relation::Less, 9.0)] };
    let lows = Aggregate::Count(condition("pet", Relation::GreaterOrEqual, 0.0));
    let nobody = Measured {
        aggregate: lows.clone(),
        of: OutcomesOf::Search("low_pet".into()),
        when: vec![when(Relation::Greater, 18.0)],
    };
    let trend = |direction, aggregate| StatementClaimKind::Trend {
        measured: Measured { aggregate, of: people(), when: Vec::new() },
        direction,
        variable: "tta".into(),
    };
    let ratio = Quantity::Binary {
        operator: scenario::BinaryOperator::Divide,
        left: Box::new(Quantity::Measured(late.clone())),
        right: Box::new(Quantity::Measured(late.clone())),
    };
    let chosen = Quantity::Chosen { tune: "braking".into(), target: braking_distance() };
    let result = conclude(
        vec![
            StatementClaimKind::Compares {
                left: Quantity::Measured(late),
                relation: Relation::Greater,
                right: Quantity::Measured(early),
            },
            trend(TrendDirection::Rises, pet()),
            trend(TrendDirection::Falls, pet()),
            compares(measured(lows, OutcomesOf::Search("low_pet".into())), Relation::Equal, 3.0),
            compares(Quantity::Measured(nobody), Relation::Equal, 0.0),
            compares(ratio, Relation::Equal, 1.0),
            compares(chosen, Relation::GreaterOrEqual, 4.0),
        ],
        DeclaredStanding::Reproduced,
    );
    let holds: Vec<_> = result.claims.iter().map(|claim| claim.holds).collect();
    let rising = holds[1] == Some(true);
    assert_eq!(holds[0], Some(rising), "two values of tta: the trend is the comparison");
    assert_eq!(holds[2], Some(!rising));
    assert_eq!(holds[3..], [Some(true); 4]);
    let units: Vec<_> = result.claims.iter().map(|claim| claim.unit.as_str()).collect();
    assert_eq!(units, ["s", "s", "s", "", "", "", "m"]);
    assert_eq!(result.conclusion, Conclusion::NotReproduced, "one of the trends must be wrong");
    assert_eq!(result.surprise().as_deref(), Some("is not reproduced"));
}

#[test]
fn the_outcome_must_agree_with_the_declared_standing() {
    let all = || measured(Aggregate::Count(condition("pet", Relation::GreaterOrEqual, 0.0)), of("default"));
    let true_claim = || vec![compares(all(), Relation::Equal, 3.0)];
    let false_claim = || vec![compares(all(), Relation::Equal, 2.0)];
    let undefined = || {
        vec![compares(measured(Aggregate::Mean(metric("impact_speed")), of("default")), Relation::Less, 1.0)]
    };
    let differs = || DeclaredStanding::Differs("a reason".into());
    assert_eq!(conclude(true_claim(), DeclaredStanding::Reproduced).surprise(), None);
    assert_eq!(conclude(false_claim(), differs()).surprise(), None);
    let revise = conclude(true_claim(), differs()).surprise().unwrap();
    assert!(revise.contains("is reproduced, though declared to differ (a reason)"), "{revise}");
    let unknown = conclude(undefined(), DeclaredStanding::Reproduced);
    let reason = "`impact_speed` exists in too few of the 3 runs of `final.default`";
    assert_eq!(unknown.conclusion, Conclusion::NotComparable(reason.into()));
    assert!(unknown.surprise().is_some());
    // What is known to be false stays so, whatever else cannot be said.
    let both = conclude([false_claim(), undefined()].concat(), differs());
    assert_eq!((both.conclusion.clone(), both.surprise()), (Conclusion::NotReproduced, None));
    let incomparable = DeclaredStanding::NotComparable("no such thing here".into());
    assert_eq!(conclude(Vec::new(), incomparable).surprise(), None);
}
