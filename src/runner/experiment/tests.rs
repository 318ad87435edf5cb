//! Blocks over real simulations, small ones.

mod evaluate;
mod plausible;
mod rounds;
mod search_and_tune;
mod statement;
mod survivors;

use std::sync::LazyLock;

use super::evaluate::run_evaluate;
use super::tune::run_tune;
use super::*;
use crate::run::{Executor, Threads};
use models::standard;
use scenario::registry::Table;
use scenario::{
    self, Aggregate, Block, Budget, CaseSet, Comparison as Bound, DeclaredAppearance, DeclaredMayGo,
    DeclaredPedestrian, DeclaredStanding, DeclaredVehicleStart, Direction, Evaluate, Expression, Goal,
    Individuals, InitialDesign, Keep, Measure, Measured, Membership, MetricReference, Model, Objective,
    Origin, OutcomesOf, ParameterSet, Part, PopulationShare, Quantity, RangeValues, Registered, Relation,
    Road, SampleSize, Scenario, Search, SearchMethod, SearchRange, Side, Statement, StatementClaim,
    StatementClaimKind, Suite, Target, TrendDirection, Tune, Value, Variation, VariationCondition,
    VariedValue, Vehicle, VehicleReference, WhenUndefined,
};

fn threads() -> &'static Threads {
    static ALL: LazyLock<Threads> = LazyLock::new(Threads::all);
    &ALL
}

fn metric(name: &str) -> MetricReference {
    models::known::measured(name)
}

fn condition(name: &str, relation: Relation, bound: f64) -> Bound {
    Bound { metric: metric(name), relation, bound: bound.into(), when_undefined: WhenUndefined::Fails }
}

fn model<T: Registered>(all: &Table<T>, name: &str, settings: &[(&str, Value)]) -> Model<T> {
    let settings =
        settings.iter().map(|(name, value)| (name.to_string(), Expression::Constant(value.clone())));
    let first = all.get(name).expect("it is registered").into();
    let (varied, others) = (Vec::new(), Vec::new());
    Model { first, varied_by: None, varied, others, settings: settings.collect(), origin: Origin::default() }
}

fn scenario() -> Scenario {
    let label = |value: f64| VariedValue { value: Value::Number(value), label: format!("{value}s") };
    Scenario {
        name: "encounter".into(),
        doc: None,
        tags: Vec::new(),
        road: Road::zebra(&[Direction::Forward, Direction::Backward], 30.0 / 3.6),
        bend: None,
        ground: None,
        other_crossings: Vec::new(),
        other_roads: Vec::new(),
        signal: None,
        vehicles: vec![Vehicle {
            name: "av".into(),
            controller: model(
                standard().controllers(),
                "carla_behavior",
                &[("obstacle_distance", Value::Word("extended".into()))],
            ),
            dynamics: None,
            size: None,
            follows: Default::default(),
            speed: (30.0 / 3.6).into(),
            initial_speed: None,
            start: DeclaredVehicleStart::Automatic,
            road: None,
            lane: 0,
            sees: None,
            obeys_signals: None,
            ignores_vehicles: false,
            origin: Origin::default(),
        }],
        pedestrians: vec![DeclaredPedestrian {
            name: "walker".into(),
            kind: Default::default(),
            model: model(standard().pedestrians(), "commotions", &[]),
            shape: None,
            side: Side::Near,
            start_from_lane_centre: 4.0.into(),
            crosses: None,
            waits_on_refuges: false,
            along: 0.0.into(),
            goal_beyond_kerb: 2.0.into(),
            turned: 0.0.into(),
            walks: None,
            reference: 0.0.into(),
            obeys_signals: None,
            appears: DeclaredAppearance::TimeToArrival {
                vehicle: "av".into(),
                reference: VehicleReference::Centre,
                time: Expression::Variable("tta".into()),
            },
            may_go: DeclaredMayGo::AtOnce,
            may_start_inside: false,
            individuals: Some(Individuals {
                selection: PopulationShare::Count(3),
                population: "standard".into(),
                text: None,
                origin: Origin::default(),
            }),
            group: None,
            origin: Origin::default(),
        }],
        variations: vec![Variation::Grid {
            names: vec!["tta".into()],
            rows: vec![vec![label(6.0)], vec![label(9.0)]],
        }],
        repeat: 2,
        runs: None,
        seed: None,
        criteria: Vec::new(),
        step: 0.025,
        horizon: 60.0,
        finish: 60.0,
        end_on_collision: true,
        written: Default::default(),
        draws: Vec::new(),
        origin: Origin::default(),
    }
}

fn budget(evaluations: u32) -> Budget {
    Budget {
        evaluations,
        initial: 5,
        initial_design: InitialDesign::Random,
        method: SearchMethod::Bayesian,
        batch: 2,
    }
}

fn range(target: Target, low: f64, high: f64, unit: &str) -> SearchRange {
    SearchRange {
        target,
        values: RangeValues::Real { low, high },
        unit: unit.into(),
        notation: None,
        origin: Origin::default(),
    }
}

fn braking_distance() -> Target {
    Target::Setting { road_user: "av".into(), part: Part::Controller, parameter: "braking_distance".into() }
}

fn keep(name: &str, relation: Relation, bound: f64) -> Keep {
    Keep::Metric { comparison: condition(name, relation, bound), written_in: None }
}

fn suite() -> Suite {
    let search = Search {
        name: "low_pet".into(),
        doc: None,
        scenario: "encounter".into(),
        individuals: None,
        together: false,
        objective: Objective {
            direction: Goal::Minimise,
            aggregate: Aggregate::Mean(metric("pet")),
            text: "minimise pet".into(),
            notation: None,
        },
        over: vec![range(Target::Variation("tta".into()), 6.0, 18.0, "s")],
        budget: budget(9),
        runs: 1,
        keep: vec![keep("pet", Relation::Less, 100.0)],
        expect: Vec::new(),
        origin: Origin::default(),
    };
    let tune = Tune {
        name: "braking".into(),
        doc: None,
        on: CaseSet::Search("low_pet".into()),
        over: vec![range(braking_distance(), 4.0, 25.0, "m")],
        objectives: vec![Objective {
            direction: Goal::Minimise,
            aggregate: Aggregate::Mean(metric("time_lost")),
            text: "minimise mean(time_lost)".into(),
            notation: None,
        }],
        constraints: vec![condition("min_distance", Relation::Greater, 0.0)],
        constraints_in: Vec::new(),
        budget: budget(8),
        fresh: 0,
        early_stop: true,
        otherwise_fewest_violations: false,
        tries: Vec::new(),
        compare_with_default: true,
        origin: Origin::default(),
    };
    Suite {
        name: "paper".into(),
        apart: String::new(),
        doc: None,
        seed: 11,
        set: Vec::new(),
        tested: Vec::new(),
        time_limit: None,
        scenarios: vec![scenario()],
        supporting: Vec::new(),
        searches: vec![search],
        tunes: vec![tune],
        evaluates: Vec::new(),
        calibrates: Vec::new(),
        estimates: Vec::new(),
        statements: Vec::new(),
        gates: Vec::new(),
        ratings: Vec::new(),
        controllers: Vec::new(),
        notations: Vec::new(),
        texts: Vec::new(),
        origin: Origin::default(),
    }
}

fn aggregate(aggregate: Aggregate, text: &str) -> Measure {
    Measure { aggregate, text: text.into(), unit: String::new(), notation: None }
}

/// The suite with an evaluation of its search and tune.
fn evaluated_suite() -> Suite {
    let condition = |name: &str, parameters| scenario::Condition {
        name: name.into(),
        parameters,
        origin: Origin::default(),
    };
    let mut suite = suite();
    suite.evaluates = vec![Evaluate {
        name: "final".into(),
        doc: None,
        on: CaseSet::Bests("low_pet".into()),
        conditions: vec![
            condition("default", ParameterSet::Declared),
            condition("tuned", ParameterSet::Tuned("braking".into())),
            condition("far", ParameterSet::Given(vec![(braking_distance(), Value::Number(25.0))])),
        ],
        fresh: 0,
        measures: vec![
            aggregate(Aggregate::Mean(metric("pet")), "mean(pet)"),
            aggregate(Aggregate::Min(metric("pet")), "min(pet)"),
            aggregate(
                Aggregate::Rate(self::condition("sudden_speed_change", Relation::Equal, 1.0)),
                "rate(sudden_speed_change)",
            ),
        ],
        source: Some("a paper".into()),
        reported: vec![("default".into(), vec![2.48, 1.05, 0.83])],
        given_in: Vec::new(),
        origin: Origin::default(),
    }];
    suite
}

/// Every block of a suite in order, with the runs of its scenario.
fn run_all(suite: &Suite) -> EarlierResults {
    let context = Context::new(suite, threads(), &standard());
    let mut results = EarlierResults::default();
    let cases: Vec<_> = crate::plan::plan_scenario(suite, &suite.scenarios[0])
        .unwrap()
        .trials()
        .flat_map(|trial| trial.cases.iter().collect::<Vec<_>>())
        .collect();
    let outcomes = context.run_all(0, &cases).unwrap();
    results.scenarios.insert("encounter".into(), cases.into_iter().zip(outcomes).collect());
    for block in Block::all(suite) {
        for need in needs(&block) {
            match need {
                Need::Block(name) => assert!(results.blocks.contains_key(&name), "{name} comes first"),
                Need::Scenario(name) => assert!(results.scenarios.contains_key(&name)),
            }
        }
        let result = run_block(&block, &context, &results, &Silent).unwrap();
        results.blocks.insert(block.name().into(), result);
    }
    results
}
