//! The authors' encounter: a driver of the same parameters as the person, and who goes first among people of `standard`.

use std::path::Path;
use std::sync::LazyLock;

use files::Disk;
use models::pedestrian::commotions::encounter::EncounterCondition;
use models::pedestrian::commotions::{Parameters, Variant};
use models::standard;
use rayon::prelude::*;
use results::Requests;
use runner::experiment::apply_settings;
use runner::plan::{self, Plan};
use runner::run::{FreeFlows, Unwatched, run_case};
use scenario::population::Population;
use scenario::{Case, Part, PopulationShare, Target, Value};

/// The encounter with so many people of `standard`.
fn encounter(people: u32) -> Plan {
    encounter_of("standard", people)
}

fn encounter_of(population: &str, people: u32) -> Plan {
    let loaded = lang::load(Path::new("scenarios/people/encounter.scn"), &standard(), &Disk);
    let mut suite = loaded.unwrap_or_else(|_| panic!("it is right")).suite;
    for person in suite.scenarios.iter_mut().flat_map(|scenario| &mut scenario.pedestrians) {
        let individuals = person.individuals.as_mut().expect("people");
        individuals.selection = PopulationShare::Count(people);
        individuals.population = population.to_string();
    }
    plan::plan(&suite).unwrap_or_else(|errors| panic!("{errors:?}"))
}

fn cases(plan: &Plan) -> Vec<Case> {
    plan.trials().flat_map(|trial| trial.cases.iter().collect::<Vec<_>>()).collect()
}

/// What a driver gets and a person does not.
const OF_DRIVERS: [&str; 2] = ["same_as", "follows_vehicles"];

#[test]
fn drivers_have_the_parameters_of_whom_they_meet() {
    let plan = encounter(5);
    for case in cases(&plan) {
        let (walker, car) = (&case.world.pedestrians[0].model, &case.world.vehicles[0].controller);
        let own: Vec<_> =
            car.settings.0.iter().filter(|(name, _)| !OF_DRIVERS.contains(&name.as_str())).collect();
        assert_eq!(own, walker.settings.0.iter().collect::<Vec<_>>(), "{}", case.key);
        assert_eq!(car.settings.get("same_as"), Some(&Value::Word("walker".into())));
        let start = case.world.vehicles[0].speed;
        assert!((start * 3.6 - 50.0).abs() < 1e-9);
    }
    let people: std::collections::BTreeSet<_> = cases(&plan)
        .iter()
        .map(|case| case.world.vehicles[0].controller.settings.number("T_delta").to_bits())
        .collect();
    assert_eq!(people.len(), 5, "every driver is as the person of the run");
}

/// Shares (%) of trials in which people of `standard` went first, at gaps of 3 s to 7 s, without and with a zebra: computed once
/// before and apart from this program, and known to 4 points.
const COMPUTED: [[f64; 5]; 2] = [[2.0, 8.0, 24.0, 43.0, 64.0], [34.0, 70.0, 92.0, 97.0, 96.0]];
const KNOWN_TO: f64 = 4.0;

/// Nobody who has not entered within 20 s counts as first.
fn shares(population: &str, people: u32) -> Vec<f64> {
    let requests = Requests::defaults(&standard());
    let index = requests.iter().position(|one| one.name() == "gap_accepted").expect("a default");
    let plan = encounter_of(population, people);
    let first = |case: &Case| {
        let outcome = run_case(case, &requests, &FreeFlows::default(), &mut Unwatched);
        outcome.expect("a run").metrics[index] == Some(1.0)
    };
    let share = |trial: plan::PlannedTrial| {
        let cases: Vec<Case> = trial.cases.iter().collect();
        let count = cases.par_iter().filter(|case| first(case)).count();
        (count, cases.len())
    };
    // A trial is a condition, or a person in one: those of a condition stand together.
    let each: Vec<_> = plan.trials().map(share).collect();
    let of_condition = each.len() / 10;
    let sums = each
        .chunks(of_condition)
        .map(|some| some.iter().fold((0, 0), |(count, all), (one, cases)| (count + one, all + cases)));
    sums.map(|(count, all)| 100.0 * count as f64 / all as f64).collect()
}

/// People of `humans` in most tests.
const HUMANS: u32 = 150;

/// The shares of [`HUMANS`] people of `humans`, of which several tests make the same runs.
static SHARES_OF_HUMANS: LazyLock<Vec<f64>> = LazyLock::new(|| shares("humans", HUMANS));

fn compare(people: u32) {
    held_against("standard", &shares("standard", people), people, &COMPUTED.concat(), KNOWN_TO);
}

/// Asserts that the shares of so many people of a population are as expected.
fn held_against(population: &str, shares: &[f64], people: u32, expected: &[f64], known_to: f64) {
    for (share, computed) in shares.iter().zip(expected) {
        let known = (computed / 100.0).clamp(0.01, 0.99);
        let chance = 100.0 * (known * (1.0 - known) / f64::from(people)).sqrt();
        let apart = (share - computed).abs();
        assert!(
            apart <= known_to + 3.0 * chance,
            "{population}: {share} where {computed} is expected, by chance {chance}"
        );
    }
}

#[test]
fn people_of_standard_go_first_as_often_as_was_computed_before() {
    compare(100);
}

/// What people did, in %.
fn observed() -> Vec<f64> {
    let text = std::fs::read_to_string("scenarios/people/human_crossing.csv").expect("it is there");
    let rows = scenario::Observations::parse("human_crossing.csv", &text).expect("it is right").rows;
    rows.iter().map(|row| 100.0 * row.share).collect()
}

#[test]
fn people_of_humans_go_first_as_often_as_people_did() {
    held_against("humans", &SHARES_OF_HUMANS, HUMANS, &observed(), 5.0);
}

/// What `validate encounter` and `validate laboratories` take for the encounter, and other noise than weights were judged under.
#[test]
fn without_a_world_around_it_the_encounter_is_the_same_and_so_it_is_under_other_seeds() {
    let people = members("humans", (0..200).map(|index| 50 * index + 25));
    let observed = observed();
    for (index, (expected, observed)) in SHARES_OF_HUMANS.iter().zip(&observed).enumerate() {
        let condition = EncounterCondition { zebra: index >= 5, gap: 3.0 + (index % 5) as f64 };
        let seed = 1 + index as u64 % 2;
        let found = 100.0 * condition.shares(&Variant::STANDARD, &people, 2, seed).share;
        // Of other members, too: by how much that may differ of 150 and of 200 times two.
        let known = (found / 100.0).clamp(0.01, 0.99);
        let chance = 100.0 * (known * (1.0 - known) * (1.0 / 150.0 + 1.0 / 200.0)).sqrt();
        let name = condition.name();
        assert!((found - expected).abs() <= 1.0 + 3.5 * chance, "{name}: {found} where runs say {expected}");
        let chance = 100.0 * (known * (1.0 - known) / 200.0).sqrt();
        assert!((found - observed).abs() <= 5.0 + 3.5 * chance, "{name}: {found}, people {observed}");
    }
}

/// Members of a population that ships.
fn members(population: &str, numbers: impl Iterator<Item = usize>) -> Vec<Parameters> {
    let declaration = &standard().pedestrians().get("commotions").expect("it ships").declaration.clone();
    let people = Population::parse(population, None, declaration, None).expect("it ships");
    let member = |number| Parameters::from_settings(&people.individual(number).expect("so many there are"));
    numbers.map(member).collect()
}

#[test]
#[ignore = "takes a minute"]
fn many_of_humans_go_first_as_often_as_people_did() {
    held_against("humans", &shares("humans", 3000), 3000, &observed(), 3.5);
}

#[test]
#[ignore = "takes a minute"]
fn everybody_of_standard_goes_first_as_often_as_was_computed_before() {
    compare(1123);
}

#[test]
fn what_is_set_or_searched_of_the_person_is_so_of_the_driver() {
    let loaded = lang::load(Path::new("scenarios/people/encounter.scn"), &standard(), &Disk);
    let mut suite = loaded.unwrap_or_else(|_| panic!("it is right")).suite;
    let of = |road_user: &str, part, name: &str| Target::Setting {
        road_user: road_user.into(),
        part,
        parameter: name.into(),
    };
    let settings = [
        (of("walker", Part::Model, "T_delta"), Value::Number(17.0)),
        (of("walker", Part::Model, "variant"), Value::Word("oVAoAI".into())),
        (of("walker", Part::Model, "dt"), Value::Number(0.1)),
        (of("av", Part::Controller, "T_s"), Value::Number(2.0)),
    ];
    for scenario in &mut suite.scenarios {
        apply_settings(scenario, &settings).expect("all are there");
        scenario.pedestrians[0].individuals = None;
    }
    for case in cases(&plan::plan(&suite).unwrap_or_else(|errors| panic!("{errors:?}"))) {
        let car = &case.world.vehicles[0].controller.settings;
        assert_eq!((car.number("T_delta"), car.number("dt"), car.word("variant")), (17.0, 0.1, "oVAoAI"));
        // What is said of the driver wins, and the person knows nothing of it.
        assert_eq!((car.number("T_s"), case.world.pedestrians[0].model.settings.number("T_s")), (2.0, 1.0));
    }
}
