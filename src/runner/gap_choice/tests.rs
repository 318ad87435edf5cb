//! Few people in the real street, and what is refused.

use super::facts::tests::made_up;
use super::walk::{Walk, Went};
use super::*;
use crate::run::{Shuffled, Threads};
use files::Memory;
use models::standard;
use results::ChosenGap;

const STREET_FILE: &str = include_str!("../../../scenarios/people/crosscdr.scn");

const THREE: &str = "ped_free_speed\n1.4\n1.5\n1.6\n";

fn people() -> PeopleAtGaps {
    read_people_at_gaps("facts.json", &made_up().to_string()).unwrap()
}

fn with<T>(street: &str, of: impl FnOnce(&GapStudy) -> T) -> T {
    on(&Threads::new(2), street, of)
}

/// The same with another executor.
fn on<T>(executor: &dyn Executor, street: &str, of: impl FnOnce(&GapStudy) -> T) -> T {
    let files = Memory::default().with("some people.csv", THREE).with(
        "other.json",
        r#"{"model": "jaywalker", "source": "here", "parameters": ["speed"], "individuals": [[2]]}"#,
    );
    of(&GapStudy {
        people: &people(),
        street,
        registry: &standard(),
        files: &files,
        executor,
        stop: &Stop::default(),
        members: 3,
        repetitions: 2,
        seed: 7,
    })
}

/// Plans and makes the runs.
fn run(
    study: &GapStudy,
    subject: &PopulationOrModel,
    look: &str,
    progress: impl Fn(usize, usize) + Send + Sync,
) -> Result<GapChooser, GapChoiceError> {
    study.run(study.plan(subject, look)?, progress)
}

fn of(name: &str) -> PopulationOrModel {
    PopulationOrModel::Population(name.to_string())
}

fn model(name: &str) -> PopulationOrModel {
    PopulationOrModel::Model(name.to_string())
}

#[test]
fn a_few_people_cross_the_real_street() {
    let run_on = |executor: &dyn Executor| {
        on(executor, STREET_FILE, |study| {
            let told = std::sync::Mutex::new(Vec::new());
            let found =
                run(study, &of("some people.csv"), "1 s", |done, all| told.lock().unwrap().push((done, all)));
            (found.unwrap(), told.into_inner().unwrap())
        })
    };
    let (found, told) = run_on(&Threads::new(2));
    assert_eq!((found.name.as_str(), found.persons, found.runs), ("some people, looks for 1 s", 3, 2));
    assert_eq!((told.first(), told.last()), (Some(&(1, 42)), Some(&(42, 42))));
    let chosen = found.chosen.clone().unwrap();
    assert_eq!(chosen.conditions.len(), 7);
    for one in &chosen.conditions {
        let ChosenGap { runs, taken, share, .. } = *one;
        assert_eq!(runs, 6);
        assert_eq!(share, (one.there() > 0).then(|| taken as f64 / one.there() as f64));
    }
    // Longer gaps are taken by more.
    assert!(chosen.conditions[4].taken >= chosen.conditions[0].taken, "{chosen:?}");
    // On any number of threads, and whichever run ends first, bit for bit.
    assert_eq!(run_on(&Threads::new(1)).0, found);
    assert_eq!(run_on(&Shuffled::seeded(5)).0, found);
}

#[test]
fn a_person_that_walks_into_the_first_gap_meets_no_later_one() {
    // The interceptor is hit by the next car that comes.
    let found = with(STREET_FILE, |study| run(study, &model("interceptor"), "0 s", |_, _| ())).unwrap();
    let chosen = found.chosen.unwrap();
    for one in &chosen.conditions {
        assert_eq!((one.runs, one.there()), (3, 0), "{one:?}");
        // Not 0 %: nothing is known of them.
        assert_eq!((one.share, one.error, one.pairs), (None, None, None));
    }
}

/// What comes of walking after so many seconds at so many m/s, whatever comes, where the gap is 3.5 s: the fronts of the near cars pass at 1.742 s and every 2 s from then on, that of the last at 11.242 s.
fn walks(delay: f64, speed: f64) -> Walk {
    let street = STREET_FILE.replace("    looks for look\n", "");
    assert_ne!(street, STREET_FILE);
    let walker = Walker {
        block: format!("model scripted {{ delay: {delay} s, speed: {speed} m/s }}"),
        file: None,
        digest: None,
        fitted: FittedTo::Others,
        persons: 1,
        runs: 1,
        is_fixed: false,
    };
    with(&street, |study| {
        let project = study.project("somebody", &walker, "0 s").unwrap_or_else(|error| panic!("{error}"));
        let case = project.suites()[0].plan.trial(0).cases.first();
        let metrics = GapMetrics::of(study.registry).unwrap();
        let batch = RunBatch { executor: study.executor, measured: &metrics.measured, stop: study.stop };
        let ran = batch.one(&case, Wanted::Outcome).unwrap();
        metrics.walk(&case, &ran.outcome).unwrap()
    })
}

#[test]
fn the_gap_is_known_also_of_a_person_that_is_hit() {
    let near = |found: Option<f64>, expected: f64| found.is_some_and(|found| (found - expected).abs() < 0.01);
    // In the lane from 8.339 s to 9.946 s, between fronts at 7.742 s and 11.242 s.
    let takes = walks(7.5, 1.4);
    assert_eq!((takes.went, takes.was_hit, takes.stepped_back), (Went::InGap(4), false, Some(false)));
    assert!(
        near(takes.after_previous, 0.597) && near(takes.left, 1.296) && near(takes.speed, 1.4),
        "{takes:?}"
    );
    // In the middle of the lane when the car comes that closes the gap: taken, with nothing left.
    let hit = walks(9.8, 1.4);
    assert_eq!((hit.went, hit.was_hit, hit.left, hit.speed), (Went::InGap(4), true, Some(0.0), None));
    // Before the first car, across and hit.
    assert_eq!((walks(0.0, 3.0).went, walks(0.0, 3.0).was_hit), (Went::BeforeFirst, false));
    assert_eq!((walks(0.0, 1.4).went, walks(0.0, 1.4).was_hit), (Went::BeforeFirst, true));
    // Into the side of the second car, whose front has passed.
    let side = walks(3.75, 3.0);
    assert_eq!((side.went, side.was_hit), (Went::InGap(2), true));
    // Through the near lane behind the second car, and hit by the second one of the far lane.
    let far = walks(4.0, 3.0);
    assert_eq!((far.went, far.was_hit), (Went::InGap(2), true));
    assert!(near(far.speed, 3.0), "{far:?}");
    let never = walks(59.5, 1.4);
    assert_eq!((never.went, never.was_hit, never.left, never.speed), (Went::Never, false, None, None));
}

#[test]
fn a_model_that_ignores_cars_says_so() {
    let found =
        with(STREET_FILE, |study| run(study, &model("scripted"), "0 s", |_, _| panic!("no run is made")));
    let found = found.unwrap();
    assert_eq!((found.chosen, found.name.as_str()), (None, "scripted"));
}

#[test]
fn what_cannot_be_put_into_the_street_says_why() {
    let says = |subject: &PopulationOrModel, look: &str, what: &str| {
        let error = with(STREET_FILE, |study| study.plan(subject, look).map(|_| ())).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
    };
    says(&of("other.json"), "0 s", "a population of the model `jaywalker`");
    says(&of("nobody.json"), "0 s", "cannot read the population nobody.json");
    says(&of("nobody"), "0 s", "nobody");
    says(&model("jaywaker"), "0 s", "did you mean `jaywalker`?");
    says(&model("yielding_cyclist"), "0 s", "is about people on bicycles");
    says(&of("humans"), "soon", "look");
    says(&of("humans"), "1 m", "look");
    says(&of("humans"), "1 s; repeat 3", "`1 s; repeat 3` is no time to look");
}

#[test]
fn a_street_with_other_gaps_is_refused() {
    let of_street = |from: &str, to: &str| {
        let street = STREET_FILE.replace(from, to);
        assert_ne!(street, STREET_FILE);
        with(&street, |study| run(study, &of("standard"), "0 s", |_, _| ())).unwrap_err().to_string()
    };
    let said = of_street("gaps 3 s, 3 s, 3 s, 4 s", "gaps 3 s, 3 s, 4 s, 4 s");
    assert!(said.contains("no people were observed at gaps of [3.0, 3.0, 4.0, 4.0] s"), "{said}");
    let said = of_street("gap in [3.5 s, ", "gap in [");
    assert!(said.contains("has no gap of 3.5 s after gaps of 2 s"), "{said}");
}

#[test]
fn a_population_says_whether_it_was_fitted_to_these_people() {
    let population = |source: &str, provenance: serde_json::Value| Population {
        model: "commotions".into(),
        variant: None,
        source: source.into(),
        provenance: serde_json::from_value(provenance).unwrap(),
        parameters: Vec::new(),
        individuals: Vec::new(),
        weights: Vec::new(),
    };
    let none = serde_json::json!({});
    let fitted = |population: &Population| fitted_to(population, false);
    assert_eq!(fitted(&population("calibrated to CrossCDR", none.clone())), FittedTo::ThesePeople);
    let to =
        population("here", serde_json::json!({ "observations": "germans.csv", "conditions": ["crosscdr"] }));
    assert_eq!(fitted(&to), FittedTo::ThesePeople);
    let other = population("here", serde_json::json!({ "observations": "germans.csv" }));
    assert!(matches!(fitted(&other), FittedTo::Unknown(reason) if reason.contains("germans.csv")));
    assert!(matches!(fitted(&population("here", none)), FittedTo::Unknown(_)));
    let retained = population("here", serde_json::json!({ "criteria": [] }));
    assert!(matches!(fitted(&retained), FittedTo::Unknown(reason) if reason.contains("criteria")));
    for name in ["humans", "humans_1", "standard"] {
        let declaration = &standard().pedestrians().get("commotions").unwrap().declaration.clone();
        let known = Population::parse(name, None, declaration, None).unwrap();
        assert_eq!(fitted_to(&known, true), FittedTo::Others, "{name}");
    }
}
