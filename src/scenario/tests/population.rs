//! Populations in each of their formats, of a model that ships.

use std::path::Path;

use files::Disk;
use models::pedestrian::commotions::model::commotions;
use scenario_runner_scenario::population::{
    HUMANS, HUMANS_1, Plausibility, Population, PopulationError, STANDARD, shipped_older, shipped_version,
};
use scenario_runner_scenario::{Settings, Value};

fn csv(text: &str) -> Result<Population, PopulationError> {
    Population::from_csv(Path::new("people.csv"), text, &commotions().declaration, None)
}

fn json(text: &str, variant: Option<&str>) -> Result<Population, PopulationError> {
    Population::from_json(Path::new("people.json"), text, &commotions().declaration, variant)
}

#[test]
fn the_shipped_population_has_a_thousand_individuals_and_its_provenance() {
    let standard = Population::parse(STANDARD, None, &commotions().declaration, None).unwrap();
    assert!(standard.len() >= 1000, "{}", standard.len());
    assert_eq!(standard.variant.as_deref(), Some("oVAoBEvoAIoEAoSNvoPF"));
    for what in ["tool", "design", "seed", "repetitions", "candidates", "retained", "criteria"] {
        assert!(standard.provenance.contains_key(what), "{what}");
    }
    let first = standard.individual(1).unwrap();
    assert_eq!(first.number("T_delta"), standard.individuals[0][0]);
    assert!(standard.individual(0).is_none() && standard.individual(standard.len() + 1).is_none());
}

fn shipped(name: &str) -> Population {
    Population::parse(name, None, &commotions().declaration, None).unwrap()
}

/// Pages and reports name them by that.
#[test]
fn humans_are_those_that_pages_speak_of() {
    let humans = shipped(HUMANS);
    assert_eq!(humans.digest(), "db7927e59bbc1ad1");
    assert_eq!((humans.individuals.len(), humans.len()), (2467, 10_000));
    assert_eq!(humans.observed_speeds(), Some((50.0 / 3.6, 50.0 / 3.6)));
    assert!(humans.source.contains("CC BY-NC-SA 4.0") && humans.source.contains("less consistent"));
    for what in [
        "tool",
        "matched",
        "matched_parameters",
        "observations",
        "candidates",
        "effective_size",
        "conditions",
        "warnings",
    ] {
        assert!(humans.provenance.contains_key(what), "{what}");
    }
    let candidates = "../../scenarios/people/candidates.json";
    let candidates = Population::read(Path::new(candidates), &commotions().declaration, None, &Disk).unwrap();
    assert_eq!(humans.parameters, candidates.parameters);
    assert_eq!(humans.individuals, candidates.individuals);
    // Whoever waits for ever beside an empty road was none of them.
    let asked = candidates.provenance["criteria"].as_array().unwrap();
    assert_eq!(asked.len(), 1);
    assert_eq!(asked[0]["criterion"]["demand"]["reaches_within"].as_f64(), Some(12.0));
}

#[test]
fn an_older_version_ships_under_a_name_of_its_own() {
    assert_eq!((shipped_version(HUMANS), shipped_version(HUMANS_1)), (Some(2), Some(1)));
    assert_eq!((shipped_older(HUMANS, 1), shipped_older(HUMANS, 2)), (Some(HUMANS_1), None));
    assert_eq!(shipped_older(STANDARD, 1), None);
    // As baselines of before have it.
    assert_eq!(shipped(HUMANS_1).digest(), "bc9872f195ce1122");
}

#[test]
fn a_person_is_as_plausible_as_so_many_of_the_population_are_unusual() {
    let model = commotions().declaration;
    let resolved = |person: &Settings| model.resolve(person).unwrap();
    for name in [STANDARD, HUMANS] {
        let people = shipped(name);
        let plausibility = Plausibility::of(&people).unwrap();
        let tails: Vec<f64> = (1..=people.len())
            .step_by(people.len() / 500)
            .map(|number| plausibility.tail(&model, &resolved(&people.individual(number).unwrap())).unwrap())
            .collect();
        for share in [0.05, 0.25, 0.5, 0.75] {
            let below = tails.iter().filter(|tail| **tail <= share).count() as f64 / tails.len() as f64;
            assert!((below - share).abs() < 0.06, "{name}: {below} of its members are below {share}");
        }
    }
}

#[test]
fn of_whom_a_population_says_nothing_nothing_is_said() {
    let model = commotions().declaration;
    let humans = shipped(HUMANS);
    let plausibility = Plausibility::of(&humans).unwrap();
    let usual = model.resolve(&humans.individual(5000).unwrap()).unwrap();
    let with = |name: &str, value: Value| {
        let mut person = usual.clone();
        person.set(name.to_string(), value);
        plausibility.tail(&model, &person)
    };
    assert!(plausibility.tail(&model, &usual).unwrap() > 0.0);
    // Not one in a thousand is as unusual as that.
    for (name, value) in [("T_delta", 1.0), ("ped_free_speed", 5.0), ("T_s", 20.0), ("beta_V", 0.0)] {
        let tail = with(name, Value::Number(value)).unwrap();
        assert!(tail < 1e-3, "{name}: {tail}");
    }
    // Not a person of whom they tell: however usual the rest is, that is no reason to call it plausible.
    assert_eq!(with("D_s", Value::Number(3.0)), None);
    assert_eq!(with("dt", Value::Number(0.1)), None);
    assert_eq!(with("variant", Value::Word("oVAoBEvoAI".into())), None);
    // What is not of the population cannot be known to it; nor without one of its parameters.
    let nobody = Settings::default();
    assert_eq!(plausibility.tail(&model, &nobody), None);
    let alike = csv("T_delta,beta_V\n10,20\n30,20\n50,20\n70,20\n35,20\n").unwrap();
    let alike = Plausibility::of(&alike).unwrap();
    let person = |beta: f64| {
        let mut person = Settings::default();
        person.set("T_delta", Value::Number(32.0));
        person.set("beta_V", Value::Number(beta));
        alike.tail(&model, &person)
    };
    assert!(person(20.0).unwrap() > 0.5);
    assert_eq!(person(21.0), Some(0.0));
}

#[test]
fn json_survives_the_round_trip() {
    let population = csv("T_delta,beta_V\n10,20\n30.5,40\n").unwrap();
    let text = population.to_json().unwrap();
    assert_eq!(json(&text, None).unwrap(), population);
    insta::assert_snapshot!(text);
}

#[test]
fn published_files_give_the_variant_asked_for() {
    let text = r#"{"source": "fits", "variants": {
        "oVA": {"params": ["T_delta"], "ranges": [[10, 100]], "published": 1, "rows": [[11]]},
        "oVAoBEvoAIoEAoSNvoPF": {"params": ["T"], "ranges": [[0.1, 0.5]], "published": 1, "rows": [[0.2]]}}}"#;
    assert_eq!(json(text, Some("oVA")).unwrap().individuals, [[11.0]]);
    assert_eq!(json(text, None).unwrap().individuals, [[0.2]]);
}

#[test]
fn errors_name_file_row_column_and_range() {
    let published = r#"{"source": "fits", "variants": {
        "oVA": {"params": ["T_delta"], "ranges": [[10, 100]], "published": 1, "rows": [[11]]}}}"#;
    let own = |individuals: &str| {
        format!(
            r#"{{"model": "commotions", "variant": "oVA", "source": "-", "parameters": ["T_delta"], "individuals": {individuals}}}"#
        )
    };
    let said: Vec<String> = [
        csv("T_delta,betaV\n10,20\n"),
        csv("T_delta,T_delta\n10,20\n"),
        csv("T_delta,beta_V\n10,20\n10\n"),
        csv("# comment\nT_delta,beta_V\n10,2O\n"),
        csv("T_delta,beta_V\n10,20\n0.5,20\n"),
        csv("T_delta,beta_V\n10,NaN\n"),
        csv("T_delta,beta_V\n"),
        json("[1, 2]", None),
        json(&own("[[10], [10, 20]]"), None),
        json(&own("[[10], [\"x\"]]"), None),
        json(&own("[[1e300]]"), None),
        json(&own("[[10]]"), Some("oVAoAI")),
        json(&own("[[10]]").replace("commotions", "carla_walker"), None),
        json(published, None),
        Population::read(Path::new("people.txt"), &commotions().declaration, None, &Disk),
        Population::read(Path::new("/nowhere/people.csv"), &commotions().declaration, None, &Disk),
    ]
    .into_iter()
    .map(|result| result.unwrap_err().to_string())
    .collect();
    insta::assert_snapshot!(said.join("\n"));
}
