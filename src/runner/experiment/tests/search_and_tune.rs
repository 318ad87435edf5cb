//! Searches, tunes on what they found, and journals.

use std::time::Duration;

use super::*;
use crate::experiment::searched::with_individuals;
use crate::run::Shuffled;
use results::{BlockResult, MetricSummary, SearchResult, TuneResult, Violations};
use scenario::population::{HUMANS, Plausibility, Population};

fn run(suite: &Suite, journals: Option<std::path::PathBuf>) -> (SearchResult, TuneResult) {
    run_by(threads(), suite, journals)
}

fn run_by(
    executor: &dyn Executor,
    suite: &Suite,
    journals: Option<std::path::PathBuf>,
) -> (SearchResult, TuneResult) {
    let context = Context { journals, ..Context::new(suite, executor, &standard()) };
    let found = run_search(&context, &suite.searches[0], &Silent).unwrap();
    let mut results = EarlierResults::default();
    results.blocks.insert(found.name.clone(), BlockResult::Search(found.clone()));
    let tuned = run_tune(&context, &suite.tunes[0], &results, &Silent).unwrap();
    (found, tuned)
}

/// All but how long the runs took.
fn text(results: &(SearchResult, TuneResult)) -> String {
    let mut results = results.clone();
    for run in results.0.found.iter_mut().flat_map(|found| &mut found.runs) {
        run.outcome.wall_time = Duration::ZERO;
    }
    serde_json::to_string(&results).unwrap()
}

#[test]
fn a_search_and_a_tune_on_what_it_found() {
    let suite = suite();
    let (found, tuned) = run(&suite, None);
    assert_eq!(found.found.len(), 3);
    for one in &found.found {
        assert_eq!(one.evaluations.len(), 9);
        let values = one.evaluations.iter().filter_map(|(_, value)| *value);
        assert_eq!(one.observed, values.reduce(f64::min), "the best is the smallest that was seen");
        assert!(one.fresh.is_some() && one.predicted.is_some() && one.passed_first.is_some());
        // As the metric says of the same person.
        let model = standard().pedestrians().get("commotions").unwrap().declaration.clone();
        let humans = Population::parse(HUMANS, None, &model, None).unwrap();
        let person = model.resolve(&one.individuals[0].parameters).unwrap();
        assert_eq!(one.plausibility, Plausibility::of(&humans).unwrap().tail(&model, &person));
        assert!(one.plausibility.is_some_and(|tail| (0.0..=1.0).contains(&tail)));
    }
    assert_eq!(found.kept.cases.len(), 3);
    assert_eq!(tuned.cases, 3);
    // What is declared comes on top of the budget.
    assert_eq!(tuned.evaluations.len(), 1 + 8);
    let chosen = tuned.chosen.as_ref().unwrap();
    assert!(chosen.feasible && chosen.objectives[0].is_some());
    let comparison = tuned.comparison.unwrap();
    let pet = |table: &[MetricSummary]| table.iter().find(|row| row.metric == "pet").unwrap().mean.unwrap();
    // The table before is over the very runs that the search kept.
    let kept: Vec<f64> = found.kept.cases.iter().map(|case| case.value.unwrap()).collect();
    assert!((pet(&comparison.before) - kept.iter().sum::<f64>() / 3.0).abs() < 1e-12);
    assert_ne!(pet(&comparison.before), pet(&comparison.before_fresh));
}

#[test]
fn executors_change_nothing() {
    let suite = suite();
    let with = |executor: &dyn Executor| text(&run_by(executor, &suite, None));
    let alone = with(&Threads::new(1));
    assert_eq!(with(&Threads::new(3)), alone);
    assert_eq!(with(&Shuffled::seeded(1)), alone);
}

#[test]
fn a_run_that_was_cut_off_resumes_to_the_same_result() {
    let suite = suite();
    let folder = tempfile::tempdir().unwrap();
    let undisturbed = text(&run(&suite, None));
    let context =
        Context { journals: Some(folder.path().to_owned()), ..Context::new(&suite, threads(), &standard()) };
    // Dies in the middle of the search.
    struct Dies;
    impl BlockProgress for Dies {
        fn evaluated(&self, done: usize, _all: usize, _best: Option<f64>) {
            assert!(done < 13, "killed");
        }
    }
    let killed = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        run_search(&context, &suite.searches[0], &Dies)
    }));
    assert!(killed.is_err());
    assert!(std::fs::read_dir(folder.path()).unwrap().count() > 0, "journals are left behind");
    assert_eq!(text(&run(&suite, Some(folder.path().to_owned()))), undisturbed);
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        1,
        "and those of searches removed in the end"
    );
}

#[test]
fn a_run_that_is_asked_to_stop_leaves_a_journal_without_the_evaluations_that_it_gave_up() {
    let suite = suite();
    let folder = tempfile::tempdir().unwrap();
    let undisturbed = text(&run(&suite, None));
    let context =
        Context { journals: Some(folder.path().to_owned()), ..Context::new(&suite, threads(), &standard()) };
    struct Stops<'a>(&'a crate::run::Stop);
    impl BlockProgress for Stops<'_> {
        fn evaluated(&self, done: usize, _all: usize, _value: Option<f64>) {
            if done == 13 {
                self.0.request();
            }
        }
    }
    let stopped = run_search(&context, &suite.searches[0], &Stops(&context.stop));
    assert!(matches!(stopped, Err(ExperimentError::Stopped)));
    let lines = |path: std::path::PathBuf| std::fs::read_to_string(path).unwrap().lines().count();
    let files = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
    // A line of each journal says what it belongs to.
    let recorded: usize = files.map(|path| lines(path) - 1).sum();
    assert!((13..27).contains(&recorded), "{recorded} of 27 evaluations are recorded");
    assert_eq!(text(&run(&suite, Some(folder.path().to_owned()))), undisturbed);
}

#[test]
fn sets_of_cases_round_trip_and_can_be_tuned_on() {
    let mut suite = suite();
    let (found, tuned) = run(&suite, None);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("low_pet.json");
    std::fs::write(&path, CaseFile::write(&found.kept)).unwrap();
    assert_eq!(CaseFile::read(&path, &files::Disk).unwrap(), found.kept);
    suite.tunes[0].on = CaseSet::Saved(path.to_string_lossy().into_owned());
    let context = Context::new(&suite, threads(), &standard());
    let again = run_tune(&context, &suite.tunes[0], &EarlierResults::default(), &Silent).unwrap();
    assert_eq!(serde_json::to_string(&again).unwrap(), serde_json::to_string(&tuned).unwrap());
}

#[test]
fn an_empty_set_and_an_unsatisfiable_constraint_are_said_plainly() {
    let mut suite = suite();
    suite.searches[0].keep = vec![keep("pet", Relation::Less, -1.0)];
    let context = Context::new(&suite, threads(), &standard());
    let early = run_tune(&context, &suite.tunes[0], &EarlierResults::default(), &Silent);
    assert_eq!(early.unwrap_err().to_string(), "`low_pet` has not been run, but is needed");
    let nothing = run_search(&context, &suite.searches[0], &Silent).unwrap();
    let mut results = EarlierResults::default();
    results.blocks.insert("low_pet".into(), BlockResult::Search(nothing));
    let empty = run_tune(&context, &suite.tunes[0], &results, &Silent);
    assert_eq!(empty.unwrap_err().to_string(), "the set of cases `low_pet` is empty");
    suite.tunes[0].on =
        CaseSet::Sample { scenario: "encounter".into(), count: SampleSize::Number(1_000_000) };
    let context = Context::new(&suite, threads(), &standard());
    let small = run_tune(&context, &suite.tunes[0], &EarlierResults::default(), &Silent).unwrap_err();
    assert!(small.to_string().ends_with("runs, and 1000000 are to be drawn of them"), "{small}");
    suite.tunes[0].on = CaseSet::Sample { scenario: "encounter".into(), count: SampleSize::Number(2) };
    suite.tunes[0].constraints = vec![condition("min_distance", Relation::Greater, 1e6)];
    let context = Context::new(&suite, threads(), &standard());
    let result = run_tune(&context, &suite.tunes[0], &EarlierResults::default(), &Silent).unwrap();
    assert!(result.chosen.is_none() && result.evaluations.iter().all(|one| !one.feasible));
}

#[test]
fn where_nothing_is_feasible_the_fewest_violations_can_be_chosen() {
    let mut suite = suite();
    let tune = &mut suite.tunes[0];
    tune.on = CaseSet::Scenario("encounter".into());
    tune.early_stop = false;
    tune.otherwise_fewest_violations = true;
    let tuned = |suite: &Suite| {
        let context = Context::new(suite, threads(), &standard());
        run_tune(&context, &suite.tunes[0], &EarlierResults::default(), &Silent).unwrap()
    };
    // What every run violates is broken equally by all: then the objective decides.
    suite.tunes[0].constraints = vec![condition("min_distance", Relation::Greater, 1e6)];
    let result = tuned(&suite);
    let chosen = result.chosen.unwrap();
    let Violations { runs, of } = result.violations.unwrap();
    assert!(!chosen.feasible && runs == of && of == result.cases);
    let least = result.evaluations.iter().filter_map(|one| one.objectives[0]).min_by(f64::total_cmp);
    assert_eq!(chosen.objectives[0], least);

    // Where something is feasible the clause changes nothing.
    suite.tunes[0].constraints = vec![condition("min_distance", Relation::GreaterOrEqual, 0.0)];
    let result = tuned(&suite);
    assert!(result.chosen.unwrap().feasible && result.violations.is_none());
}

#[test]
fn a_strict_constraint_is_violated_at_its_bound() {
    let suite = suite();
    let context = Context::new(&suite, threads(), &standard());
    let cases = context.cases_of("encounter").unwrap();
    let case = context.revive(&cases[0], &[], "key".into(), None).unwrap();
    let outcomes = context.run_all(0, &[case]).unwrap();
    // Nobody is hit, so that `collision` is 0.
    let margin = |relation| context.margin(&condition("collision", relation, 0.0), &outcomes).value.unwrap();
    assert!(margin(Relation::Less) < 0.0 && margin(Relation::Greater) < 0.0);
    assert!(margin(Relation::LessOrEqual) >= 0.0 && margin(Relation::Equal) > 0.0);
}

#[test]
fn stopping_early_costs_no_accuracy() {
    let mut suite = suite();
    suite.tunes[0].on = CaseSet::Scenario("encounter".into());
    let tuned = |early_stop, most_lost| {
        let mut suite = suite.clone();
        suite.tunes[0].early_stop = early_stop;
        suite.tunes[0].constraints = vec![condition("time_lost", Relation::LessOrEqual, most_lost)];
        let context = Context::new(&suite, threads(), &standard());
        run_tune(&context, &suite.tunes[0], &EarlierResults::default(), &Silent).unwrap()
    };
    // A bound that some of the random first candidates keep and others do not; they are the same for every bound.
    let mut lost: Vec<f64> =
        tuned(false, 0.0).evaluations[1..6].iter().map(|one| -one.margins[0].unwrap()).collect();
    lost.sort_by(f64::total_cmp);
    assert!(lost[0] < lost[4], "{lost:?}");
    let bound = (lost[0] + lost[4]) / 2.0;
    let (early, late) = (tuned(true, bound), tuned(false, bound));
    let pairs = || early.evaluations.iter().zip(&late.evaluations).skip(1).take(5);
    assert!(pairs().any(|(_, late)| late.feasible) && pairs().any(|(_, late)| !late.feasible));
    for (early, late) in pairs() {
        assert_eq!((&early.point, early.feasible), (&late.point, late.feasible));
        match late.feasible {
            true => assert_eq!(early, late),
            false => {
                assert!(early.margins[0].unwrap() >= late.margins[0].unwrap());
                assert!(early.objectives[0].is_none_or(|value| Some(value) == late.objectives[0]));
            }
        }
    }
}

#[test]
fn courses_follow_those_who_were_kept() {
    let suite = suite();
    let (found, _) = run(&suite, None);
    for one in &found.found {
        let [course] = one.courses.as_slice() else { panic!("one dimension") };
        assert_eq!((course.over.as_str(), course.points.len()), ("tta", 25));
        assert!(
            course.points.iter().all(|point| point.smallest <= point.mean && point.mean <= point.largest)
        );
        assert!(course.points.windows(2).all(|pair| pair[0].at < pair[1].at));
    }
}

/// Where the scenario takes nobody from a population, a search's people are whoever can be: all of a group, or nobody of it.
#[test]
fn a_search_takes_other_people_for_every_member_of_a_group() {
    let suite = suite();
    let (mut scenario, mut search) = (suite.scenarios[0].clone(), suite.searches[0].clone());
    let one = scenario.pedestrians.remove(0);
    let individuals =
        Individuals { selection: PopulationShare::Count(2), ..one.individuals.clone().unwrap() };
    let one = DeclaredPedestrian { individuals: None, ..one };
    let dummy = DeclaredPedestrian {
        name: "dummy".into(),
        model: model(standard().pedestrians(), "scripted", &[]),
        ..one.clone()
    };
    let group = |index| Some(Membership { group: "walkers".into(), index, size: 3 });
    let member = |index| DeclaredPedestrian {
        name: format!("walkers_{}", index + 1),
        group: group(index),
        ..one.clone()
    };
    scenario.pedestrians = std::iter::once(dummy).chain((0..3).map(member)).collect();
    search.individuals = Some(individuals);
    let people = crate::plan::select_people(1, &with_individuals(&scenario, &search)).unwrap();
    let who: Vec<Vec<&str>> =
        people.iter().map(|group| group.iter().map(|one| one.pedestrian.as_str()).collect()).collect();
    assert_eq!(who, [["walkers_1", "walkers_2", "walkers_3"]; 2]);
    let mut numbers: Vec<u32> = people.iter().flatten().map(|one| one.number).collect();
    numbers.sort_unstable();
    numbers.dedup();
    assert_eq!(numbers.len(), 6, "{people:?}");
}
