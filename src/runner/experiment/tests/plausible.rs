//! How usual the encounters of a search are, and what is kept for it.

use super::*;
use crate::experiment::plausible::{PartsCounted, PlausibleEncounters, front};
use crate::plan::plan_scenario;
use crate::run::{MeasuredMetrics, RunBatch, Stop, Wanted};
use numbers::distributions::normal::Normal;
use results::{Requests, SearchResult};
use scenario::population::{HUMANS, Plausibility};
use scenario::{Case, DeclaredDraw, Distribution, DrawSource};

fn draw(name: &str, distribution: Distribution, unit: &str) -> DeclaredDraw {
    DeclaredDraw {
        names: vec![name.into()],
        from: DrawSource::Distribution { distribution, unit: unit.into() },
        origin: Origin::default(),
    }
}

fn normal(mean: impl Into<Expression>, standard_deviation: f64) -> Distribution {
    Distribution::Normal { mean: mean.into(), standard_deviation: standard_deviation.into() }
}

/// The gap is drawn, whether the car is early, and how fast it is; who walks is somebody of `humans`.
fn drawn_scenario() -> Scenario {
    let mut drawn = scenario();
    drawn.variations.clear();
    let weighted = |name: &str| VariedValue {
        value: Value::Number(if name == "early" { 8.0 } else { 9.0 }),
        label: name.into(),
    };
    drawn.draws = vec![
        draw(
            "pace",
            Distribution::Weighted {
                options: vec![weighted("early"), weighted("late")],
                weights: vec![1.0, 3.0],
            },
            "m/s",
        ),
        draw("tta", normal(Expression::Variable("pace".into()), 1.5), "s"),
    ];
    drawn.vehicles[0].speed = Expression::Variable("pace".into());
    drawn.pedestrians[0].individuals.as_mut().unwrap().selection = PopulationShare::Drawn;
    drawn.pedestrians[0].individuals.as_mut().unwrap().population = HUMANS.into();
    drawn
}

/// The suite with a search over the gap of the drawn scenario.
fn drawn_suite(low: f64, high: f64) -> Suite {
    let mut suite = suite();
    suite.scenarios = vec![drawn_scenario()];
    suite.tunes.clear();
    suite.searches[0].over = vec![range(Target::Variation("tta".into()), low, high, "s")];
    suite.searches[0].budget.batch = 1;
    suite
}

fn searched(suite: &Suite) -> SearchResult {
    run_search(&Context::new(suite, threads(), &standard()), &suite.searches[0], &Silent).unwrap()
}

fn encounters(scenario: &Scenario, search: &Search) -> PlausibleEncounters {
    PlausibleEncounters::of(search, scenario, false).unwrap().unwrap()
}

fn with_value(case: &Case, name: &str, value: f64) -> Case {
    let mut other = case.clone();
    other.drawn.iter_mut().filter(|one| one.name == name).for_each(|one| one.value = Value::Number(value));
    other
}

/// Under what is declared, at most 5 % of encounters have a plausibility of at most 5 %, and nearly as many.
#[test]
fn of_drawn_encounters_a_share_is_at_most_as_plausible_as_that_share() {
    let mut suite = drawn_suite(4.0, 12.0);
    suite.scenarios[0].repeat = 1500;
    let planned = plan_scenario(&suite, &suite.scenarios[0]).unwrap();
    let cases: Vec<Case> =
        planned.trials().flat_map(|trial| trial.cases.iter().collect::<Vec<_>>()).collect();
    let known = encounters(&suite.scenarios[0], &suite.searches[0]);
    assert_eq!(known.parts(), ["pace", "tta", "walker"]);
    let shares: Vec<f64> =
        cases.iter().map(|case| known.of_case(case, PartsCounted::Whole).unwrap().share).collect();
    for share in [0.01, 0.05, 0.25, 0.5, 0.9] {
        let below = shares.iter().filter(|one| **one <= share).count() as f64 / shares.len() as f64;
        let error = (share * (1.0 - share) / shares.len() as f64).sqrt();
        assert!((below - share).abs() < 4.0 * error + 0.002, "{below} at or below {share}");
    }
}

#[test]
fn an_encounter_is_as_usual_as_its_parts_say() {
    let suite = drawn_suite(4.0, 12.0);
    let case = plan_scenario(&suite, &suite.scenarios[0]).unwrap().trial(0).cases.first();
    let known = encounters(&suite.scenarios[0], &suite.searches[0]);
    let case = with_value(&with_value(&case, "pace", 8.0), "tta", 11.0);
    let found = known.of_case(&case, PartsCounted::Whole).unwrap();
    let model = &case.world.pedestrians[0].model;
    let declaration = &model.model.known().unwrap().declaration;
    let person =
        Plausibility::of_shipped(HUMANS, declaration).unwrap().tail(declaration, &model.settings).unwrap();
    let gap = Normal { mean: 8.0, standard_deviation: 1.5 }.tail(11.0);
    assert_eq!(found.parts, [("pace".into(), 0.25), ("tta".into(), gap), ("walker".into(), person)]);
    // Summed over both speeds by hand.
    let product = 0.25 * gap * person;
    let two = |w: f64| if w >= 1.0 { 1.0 } else { w * (1.0 - w.ln()) };
    let expected = 0.25 * two(product / 0.25) + 0.75 * two(product);
    assert!((found.share - expected).abs() < 1e-12, "{} {expected}", found.share);
    // In whatever order it is declared.
    let mut turned = suite.scenarios[0].clone();
    turned.draws.reverse();
    let share = encounters(&turned, &suite.searches[0]).of_case(&case, PartsCounted::Whole).unwrap().share;
    assert_eq!(share.to_bits(), found.share.to_bits());
    // What is never drawn.
    let never = with_value(&case, "pace", 8.5);
    assert_eq!(known.of_case(&never, PartsCounted::Whole).unwrap().share, 0.0);
}

#[test]
fn what_the_runs_of_an_evaluation_do_not_share_is_left_out_or_unknown() {
    let mut suite = drawn_suite(4.0, 12.0);
    let case = plan_scenario(&suite, &suite.scenarios[0]).unwrap().trial(0).cases.first();
    let tta = scenario::Assignment { name: "tta".into(), label: "7s".into(), value: Value::Number(7.0) };
    let searched = Case { variation: vec![tta], ..case };
    // The gap hangs on a speed that is another in every run.
    let known = encounters(&suite.scenarios[0], &suite.searches[0]);
    assert_eq!(known.of_case(&searched, PartsCounted::Shared), None);
    suite.scenarios[0].draws[1] = draw("tta", normal(9.0, 1.5), "s");
    let known = encounters(&suite.scenarios[0], &suite.searches[0]);
    let shared = known.of_case(&searched, PartsCounted::Shared).unwrap();
    assert_eq!(shared.parts, [("tta".to_string(), Normal { mean: 9.0, standard_deviation: 1.5 }.tail(7.0))]);
    // A person of whom the population says nothing.
    let mut search = suite.searches[0].clone();
    let target = Target::Setting { road_user: "walker".into(), part: Part::Model, parameter: "dt".into() };
    search.over.push(range(target, 0.01, 0.1, "s"));
    let mut odd = searched.clone();
    let world = std::sync::Arc::make_mut(&mut odd.world);
    world.pedestrians[0].model.settings.set("dt", Value::Number(0.0421));
    assert_eq!(encounters(&suite.scenarios[0], &search).of_case(&odd, PartsCounted::Whole), None);
    // A scenario that says nothing.
    let mut nothing = scenario();
    nothing.pedestrians[0].individuals = None;
    assert!(PlausibleEncounters::of(&suite.searches[0], &nothing, false).unwrap().is_none());
    let mut people = scenario();
    people.pedestrians[0].individuals.as_mut().unwrap().selection = PopulationShare::Count(2);
    assert_eq!(encounters(&people, &suite.searches[0]).undeclared(), ["tta"]);
}

#[test]
fn the_front_has_none_that_is_at_least_as_usual_and_worse() {
    let points =
        [(3.0, 0.01), (1.0, 0.5), (2.0, 0.2), (2.0, 0.1), (0.5, 0.5), (3.0, 0.02), (0.2, 0.9), (3.0, 0.02)];
    assert_eq!(front(&points), [5, 2, 1, 6]);
    assert!(front(&[]).is_empty());
    for (index, (bad, usual)) in points.iter().enumerate() {
        let beaten = points.iter().any(|(other_bad, other_usual)| {
            other_bad >= bad && other_usual >= usual && (other_bad > bad || other_usual > usual)
        });
        let is_first = points.iter().position(|one| one == &(*bad, *usual)) == Some(index);
        assert_eq!(front(&points).contains(&index), !beaten && is_first, "{index}");
    }
}

#[test]
fn only_encounters_that_are_usual_enough_are_kept() {
    let mut suite = drawn_suite(4.0, 12.0);
    suite.searches[0].budget.evaluations = 20;
    for (relation, bound) in [(Relation::GreaterOrEqual, 0.3), (Relation::LessOrEqual, 0.1)] {
        let usual = Keep::Plausibility { relation, bound };
        suite.searches[0].keep = vec![keep("pet", Relation::Less, 100.0), usual.clone()];
        let result = searched(&suite);
        let found = &result.found[0];
        // The worst of those that are as usual as is asked.
        let all = found.evaluations.iter().map(|one| one.1).zip(&found.plausibilities);
        let wanted = all.filter(|(_, share)| share.is_some_and(|share| relation.holds(share, bound)));
        let worst = wanted.filter_map(|(value, _)| value).reduce(f64::min);
        assert!(worst.is_some() && found.observed == worst, "{worst:?} {:?}", found.observed);
        assert!(relation.holds(found.plausibility.unwrap(), bound));
        assert_eq!((&found.kept[..], found.runs[0].case.plausibility), (&[true][..], found.plausibility));
        // Both have to hold.
        suite.searches[0].keep = vec![keep("pet", Relation::Less, -1.0), usual];
        assert_eq!(searched(&suite).found[0].kept, [false]);
    }
    // None is so usual: nothing is found, and it is said.
    suite.searches[0].keep = vec![Keep::Plausibility { relation: Relation::Greater, bound: 1.0 }];
    let result = searched(&suite);
    assert_eq!((result.found[0].observed, result.kept.cases.len()), (None, 0));
    assert_eq!(result.usual.as_ref().unwrap().wanted, Some(0));
    let text = report::render_search(&result);
    assert!(text.contains("No evaluated encounter is as plausible as is asked"), "{text}");
    // Nobody knows how usual somebody of no population is.
    suite.scenarios[0] = scenario();
    suite.scenarios[0].pedestrians[0].individuals = None;
    suite.searches[0].keep = vec![Keep::Plausibility { relation: Relation::GreaterOrEqual, bound: 0.0 }];
    let found = searched(&suite);
    assert_eq!((found.found[0].kept.contains(&true), found.usual), (false, None));
}

#[test]
fn the_front_is_of_what_was_evaluated_and_its_runs_can_be_made_again() {
    let suite = drawn_suite(4.0, 12.0);
    let found = searched(&suite);
    let usual = found.usual.as_ref().unwrap();
    let one = &found.found[0];
    assert_eq!(usual.of, ["pace", "tta", "walker"]);
    assert_eq!(
        (usual.possible + usual.impossible + usual.unknown, usual.unknown),
        (one.evaluations.iter().filter(|one| one.1.is_some()).count(), 0)
    );
    assert!(!usual.front.is_empty() && one.plausibilities.len() == one.evaluations.len());
    for point in &usual.front {
        assert_eq!(one.evaluations[point.evaluation].1, Some(point.value));
        assert_eq!(one.plausibilities[point.evaluation], Some(point.plausibility));
        let beats = |(value, share): (Option<f64>, Option<f64>)| {
            value.is_some_and(|value| value < point.value) && share >= Some(point.plausibility)
        };
        let all = one.evaluations.iter().map(|one| one.1).zip(one.plausibilities.iter().copied());
        assert!(!all.clone().any(beats));
        let case = searched_case(&suite, &point.key).unwrap();
        let (requests, stop) =
            (Context::new(&suite, threads(), &standard()).measured.requests.clone(), Stop::default());
        let measured = MeasuredMetrics::new(requests);
        let batch = RunBatch { executor: threads(), measured: &measured, stop: &stop };
        let outcome = batch.one(&case, Wanted::Outcome).unwrap().outcome;
        let pet = Requests::index(&measured.requests, &metric("pet")).unwrap();
        assert_eq!(outcome.metrics[pet], Some(point.value), "{}", point.key);
        // The same encounter under other noise.
        assert!(point.fresh_runs > 0 && point.fresh.is_some());
    }
    for wrong in ["/at=99", "/at=6,7", "/at=x", ""] {
        let (key, _) = usual.front[0].key.rsplit_once("/at=").unwrap();
        assert!(searched_case(&suite, &format!("{key}{wrong}")).is_none(), "{wrong}");
    }
}

#[test]
fn what_is_never_drawn_is_not_on_the_front_however_bad() {
    let mut suite = drawn_suite(4.0, 12.0);
    suite.scenarios[0].draws[1] =
        draw("tta", Distribution::Uniform { low: 7.0.into(), high: 12.0.into() }, "s");
    let found = searched(&suite);
    let usual = found.usual.as_ref().unwrap();
    assert!(usual.impossible > 0 && usual.possible > 0, "{usual:?}");
    let one = &found.found[0];
    for point in &usual.front {
        let tta = one.evaluations[point.evaluation].0[0].number().unwrap();
        assert!((7.0..=12.0).contains(&tta) && point.plausibility > 0.0);
    }
    // Nothing of what was evaluated is possible: no front, and it is said.
    suite.scenarios[0].draws[1] =
        draw("tta", Distribution::Uniform { low: 50.0.into(), high: 52.0.into() }, "s");
    suite.searches[0].keep = vec![Keep::Plausibility { relation: Relation::Greater, bound: 0.0 }];
    let found = searched(&suite);
    let usual = found.usual.as_ref().unwrap();
    assert_eq!((usual.possible, usual.front.len(), usual.impossible), (0, 0, 9));
    assert!(!found.found[0].kept.contains(&true));
    let text = report::render_search(&found);
    assert!(
        text.contains("There is no front") && text.contains("9 evaluated encounters have plausibility 0"),
        "{text}"
    );
}
