//! Populations in each of their formats, of a model that ships.

use std::path::Path;

use files::Disk;
use models::pedestrian::commotions::model::commotions;
use scenario_runner_scenario::population::{Population, PopulationError, STANDARD};

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
