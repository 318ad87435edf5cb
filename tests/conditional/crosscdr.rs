//! People of CrossCDR: what is read of them, and a few people of `humans` beside them.
//!
//! `scenario-runner validate crosscdr` makes the full comparison.

use std::path::Path;

use libtest_mimic::Trial;
use results::{ALL_PEOPLE, GapChoices, GapMeasure, PeopleAtGaps};
use runner::gap_choice::{GapStudy, PopulationOrModel, read_people_at_gaps};
use runner::run::{Stop, Threads};

use super::{shared, with};

pub fn tests() -> Vec<Trial> {
    let file = shared("data/crosscdr_fit.json");
    with(
        file.as_deref(),
        &[
            ("crosscdr_says_what_people_did", crosscdr_says_what_people_did),
            ("crosscdr_beside_a_few_people", crosscdr_beside_a_few_people),
        ],
    )
}

fn people(file: &Path) -> PeopleAtGaps {
    let text = files::read_text(file).unwrap();
    read_people_at_gaps("crosscdr_fit.json", &text).unwrap_or_else(|error| panic!("{error}"))
}

/// The numbers of the specification, which were not read from the file.
fn crosscdr_says_what_people_did(file: &Path) {
    let people = people(file);
    let points = |value: f64| (1000.0 * value).round() / 10.0;
    let shares =
        |group: usize| people.conditions.iter().map(|one| points(one.share[group].value)).collect::<Vec<_>>();
    assert_eq!(shares(0), [7.1, 34.0, 68.1, 89.2, 94.4, 22.3, 79.6]);
    assert_eq!(shares(1)[5..], [8.0, 51.2]);
    assert_eq!(shares(ALL_PEOPLE), [4.1, 21.2, 48.9, 72.7, 84.6, 15.4, 65.9]);
    let pairs = |place: usize| points(people.conditions[place].pairs.unwrap()[ALL_PEOPLE].value);
    assert_eq!((pairs(5), pairs(6)), (9.1, 54.5));
    let measure = |measure: GapMeasure| {
        people.measures.iter().find(|(one, _)| *one == measure).unwrap().1[ALL_PEOPLE].value
    };
    assert!((measure(GapMeasure::EntryAfterPrevious(4.0)) - 1.38).abs() < 0.005);
    assert_eq!(points(measure(GapMeasure::LittleLeft(4.0))), 50.0);
    assert!((measure(GapMeasure::MeanSpeed) - 1.44).abs() < 0.005);
}

fn crosscdr_beside_a_few_people(file: &Path) {
    let people = people(file);
    let study = GapStudy {
        people: &people,
        street: include_str!("../../scenarios/people/crosscdr.scn"),
        registry: &models::standard(),
        files: &files::Disk,
        executor: &Threads::new(2),
        stop: &Stop::default(),
        members: 10,
        repetitions: 2,
        seed: 1,
    };
    let humans = PopulationOrModel::Population("humans".to_string());
    let planned = study.plan(&humans, "1 s").unwrap_or_else(|error| panic!("{error}"));
    let found = study.run(planned, |_, _| ()).unwrap_or_else(|error| panic!("{error}"));
    let choices = GapChoices { people: people.clone(), choosers: vec![found] };
    let text = report::render_gap_choices(&choices);
    assert!(
        text.contains("A  humans, looks for 1 s: held back: not fitted to these people; 10 persons"),
        "{text}"
    );
    assert!(text.contains("4 s after gaps of 3 s, with others"), "{text}");
    assert!(report::draw_gap_choices(&choices).contains("people in Germany"));
}
