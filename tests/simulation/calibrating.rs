//! Calibrations: what must not matter changes nothing, what is cut off goes on, and what cannot be says so.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use files::Memory;
use models::standard;
use results::{BlockResult, CalibrateResult};
use runner::experiment::{BlockProgress, Context, EarlierResults, ExperimentError, Silent, run_block};
use runner::run::{Executor, Shuffled, Stop, Threads};
use scenario::population::{Population, WEIGHTED_MEMBERS};
use scenario::{Block, Suite};

const HEADER: &str =
    "scenario, gap, share, trials, persons, persons_0, persons_1, persons_2, persons_3, persons_4\n";
const ROWS: [&str; 2] =
    ["crossing, 4 s, 0.1484, 128, 32, 25, 2, 0, 3, 2\n", "crossing, 6 s, 0.6719, 128, 32, 8, 2, 0, 4, 18\n"];

fn text(block: &str) -> String {
    format!(
        r#"
scenario crossing {{
  road {{ lanes forward; lane_width 3.65 m; speed_limit 50 km/h; crossing unmarked {{ width: 4 m }} }}
  vehicle av {{
    controller commotions {{ same_as: walker }}
    size 4.2 m x 1.8 m
    speed 50 km/h
    start 2.5 m + (gap - 1 s) * 50 km/h before crossing
  }}
  pedestrian walker {{ model commotions; size 0.8 m x 0.8 m; start 3.25 m from lane centre }}
  vary gap in [4 s, 6 s]
  horizon 20 s
  expect {{ no collision }}
}}
calibrate people {{
  in crossing
  repeat 2
  {block}
}}
"#
    )
}

const MATCHED: &str = "candidates 40 by latin_hypercube\n  match rate(gap_accepted) to \"people.csv\" undefined fails\n  folds 2";

fn load(block: &str, rows: &str) -> Suite {
    let files = Memory::default()
        .with("people.scn", text(block))
        .with("people.csv", format!("{HEADER}{rows}"))
        .with("them.csv", "T_delta, T, beta_V\n20, 0.2, 20\n40, 0.3, 10\n80, 0.1, 50\n15, 0.4, 100\n")
        .with("turned.csv", "beta_V, T_delta, T\n100, 15, 0.4\n20, 20, 0.2\n50, 80, 0.1\n10, 40, 0.3\n");
    let loaded = lang::load(Path::new("people.scn"), &standard(), &files);
    loaded.unwrap_or_else(|_| panic!("it is right")).suite
}

fn run(
    suite: &Suite,
    executor: &dyn Executor,
    journals: Option<&Path>,
    stop: &Stop,
    progress: &dyn BlockProgress,
) -> Result<CalibrateResult, ExperimentError> {
    let mut context = Context::new(suite, executor, &standard());
    context.journals = journals.map(Path::to_owned);
    context.stop = stop.clone();
    let block = Block::all(suite).into_iter().next().expect("a block");
    match run_block(&block, &context, &EarlierResults::default(), progress)? {
        BlockResult::Calibrate(result) => Ok(result),
        other => panic!("{other:?}"),
    }
}

fn calibrated(block: &str, rows: &str, executor: &dyn Executor) -> Result<CalibrateResult, ExperimentError> {
    let suite = load(block, rows);
    run(&suite, executor, None, &Stop::default(), &Silent)
}

#[test]
fn the_order_of_rows_and_of_runs_changes_nothing() {
    let usual = calibrated(MATCHED, &ROWS.concat(), &Threads::new(2)).unwrap();
    let turned = calibrated(MATCHED, &[ROWS[1], ROWS[0]].concat(), &Threads::new(2)).unwrap();
    let shuffled = calibrated(MATCHED, &ROWS.concat(), &Shuffled::seeded(3)).unwrap();
    assert_eq!(usual, shuffled);
    assert_eq!((&usual.weights, &usual.conditions), (&turned.weights, &turned.conditions));
    assert!((usual.weights.iter().sum::<f64>() - 1.0).abs() < 1e-6);
    // Of 40 candidates fewer than 50 decide, and that is said.
    let few =
        format!("the effective size is {:.0}: a few candidates decide everything", usual.effective_size);
    assert!(usual.warnings.iter().any(|one| one.starts_with(&few)), "{:?}", usual.warnings);
    let share = usual.conditions[1].share;
    assert!((share.fitted - share.observed).abs() < (share.equal - share.observed).abs(), "{share:?}");
    // The fit is told of runs that no weight has seen.
    assert!(usual.conditions.iter().any(|one| one.share.fresh != one.share.fitted));
}

#[test]
fn the_order_of_candidates_and_of_their_parameters_changes_nothing() {
    let of = |file: &str| {
        let block = MATCHED.replace("40 by latin_hypercube", &format!("all of \"{file}\""));
        // Two persons, of whom little is known.
        let rows = "crossing, 4 s, 0.125, 8, 2, 1, 1, 0, 0, 0\ncrossing, 6 s, 0.5, 8, 2, 1, 0, 0, 0, 1\n";
        calibrated(&block, rows, &Threads::new(2)).unwrap()
    };
    let (usual, turned) = (of("them.csv"), of("turned.csv"));
    for (one, other) in [(0, 1), (1, 3), (2, 2), (3, 0)] {
        assert!((usual.weights[one] - turned.weights[other]).abs() < 1e-7);
    }
    for (one, other) in usual.conditions.iter().zip(&turned.conditions) {
        assert!((one.share.fitted - other.share.fitted).abs() < 1e-7);
        assert!((one.share.fresh - other.share.fresh).abs() < 1e-7);
    }
}

/// Which counts it was told.
#[derive(Default)]
struct Told(std::sync::Mutex<Vec<usize>>);

impl BlockProgress for Told {
    fn evaluated(&self, done: usize, _: usize, _: Option<f64>) {
        self.0.lock().unwrap().push(done);
    }
}

#[test]
fn other_tolerances_weigh_the_runs_that_are_known() {
    let folder = tempfile::tempdir().unwrap();
    // Two persons, of whom little is known: there are mixtures that are consistent enough.
    let rows = ["crossing, 4 s, 0.125, 8, 2, 1, 1, 0, 0, 0\n", "crossing, 6 s, 0.5, 8, 2, 1, 0, 0, 0, 1\n"];
    let stop = Stop::default();
    let stops = StopsAt(stop.clone(), AtomicUsize::new(0));
    let suite = load(MATCHED, &rows.concat());
    let cut = run(&suite, &Threads::new(2), Some(folder.path()), &stop, &stops);
    assert!(matches!(cut, Err(ExperimentError::Stopped)), "{cut:?}");
    // With words in between, other folds and another method: the same candidates in the same conditions.
    let closer = format!(
        "\n  {}\n  match spread between individuals of rate(gap_accepted) within 100 % of error\n  \
         method maximum_entropy within 80 % of error",
        MATCHED.replace("folds 2", "")
    );
    let suite = load(&closer, &rows.concat());
    let told = Told::default();
    let resumed = run(&suite, &Threads::new(2), Some(folder.path()), &Stop::default(), &told).unwrap();
    assert_eq!(told.0.lock().unwrap()[0], 20, "those that are known are not asked again");
    assert_eq!(resumed, run(&suite, &Threads::new(2), None, &Stop::default(), &Silent).unwrap());
    // In other conditions nothing is known of them.
    let stop = Stop::default();
    let stops = StopsAt(stop.clone(), AtomicUsize::new(0));
    let suite = load(MATCHED, &rows.concat());
    assert!(run(&suite, &Threads::new(2), Some(folder.path()), &stop, &stops).is_err());
    let told = Told::default();
    let fewer = load(&MATCHED.replace("\n  folds 2", ""), rows[0]);
    let _ = run(&fewer, &Threads::new(2), Some(folder.path()), &Stop::default(), &told);
    assert_eq!(told.0.lock().unwrap()[0], 0);
}

/// Stops once somebody was weighed.
struct StopsAt(Stop, AtomicUsize);

impl BlockProgress for StopsAt {
    fn evaluated(&self, done: usize, _: usize, _: Option<f64>) {
        if done >= 20 {
            self.1.fetch_add(1, Ordering::Relaxed);
            self.0.request();
        }
    }
}

#[test]
fn what_is_cut_off_goes_on_to_the_same_weights() {
    let folder = tempfile::tempdir().unwrap();
    let suite = load(MATCHED, &ROWS.concat());
    let whole = run(&suite, &Threads::new(2), None, &Stop::default(), &Silent).unwrap();
    let stop = Stop::default();
    let stops = StopsAt(stop.clone(), AtomicUsize::new(0));
    let cut = run(&suite, &Threads::new(2), Some(folder.path()), &stop, &stops);
    assert!(matches!(cut, Err(ExperimentError::Stopped)), "{cut:?}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    let resumed = run(&suite, &Threads::new(2), Some(folder.path()), &Stop::default(), &Silent).unwrap();
    assert_eq!(resumed, whole);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "the journal is removed");
}

#[test]
fn what_cannot_be_says_so() {
    let said = |block: &str, rows: &str| {
        let error = calibrated(block, rows, &Threads::new(2)).unwrap_err();
        format!("{error} ({})", error.hint().unwrap_or_default())
    };
    // Runs in which nobody crosses do not count silently as anything.
    let silent = MATCHED.replace(" undefined fails", "");
    let undefined = said(&silent, &ROWS.concat());
    assert!(undefined.contains("is undefined or was cut off, and nothing says what that is"), "{undefined}");
    let everybody = "crossing, 4 s, 1.0, 128, 32, 0, 0, 0, 0, 32\n";
    let reached = said(&MATCHED.replace("\n  folds 2", ""), everybody);
    assert!(
        reached.contains(
            "no mixture of the candidates does what people did: the share of crossing, gap 4 s is 100.0 %"
        ),
        "{reached}"
    );
    assert!(reached.contains("the nearest mixture has"), "{reached}");
    let few = MATCHED.replace("40 by latin_hypercube", "1 of standard");
    assert!(said(&few, &ROWS.concat()).contains("1 candidates are fewer than the 2 targets"));
    let many = MATCHED.replace("40 by latin_hypercube", "5 of \"them.csv\"");
    assert!(said(&many, &ROWS.concat()).contains("5 candidates of"));
}

#[test]
fn a_calibrated_population_is_walked_with() {
    let result = calibrated(MATCHED, &ROWS.concat(), &Threads::new(2)).unwrap();
    let population = result.population();
    let written = population.to_json().unwrap();
    let walker = standard().pedestrians().get("commotions").unwrap().declaration.clone();
    let read = Population::parse("people.json", Some(Ok(&written)), &walker, None).unwrap();
    assert_eq!((&read, read.digest()), (&population, result.digest.clone()));
    assert_eq!(read.len(), WEIGHTED_MEMBERS);
    // Members are as many of each candidate as its weight says.
    let first = |number| read.individual(number).unwrap();
    for (row, weight) in read.individuals.iter().zip(&read.weights) {
        let is = |number: &usize| first(*number).number("T_delta") == row[0];
        let members = (1..=WEIGHTED_MEMBERS).filter(is).count() as f64;
        assert!((members - weight * WEIGHTED_MEMBERS as f64).abs() <= 1.0, "{members} for {weight}");
    }
    assert!(read.individual(0).is_none() && read.individual(WEIGHTED_MEMBERS + 1).is_none());
    let refused = |weights: Vec<f64>| {
        let text = Population { weights, ..population.clone() }.to_json().unwrap();
        Population::parse("people.json", Some(Ok(&text)), &walker, None).unwrap_err().to_string()
    };
    let halved = refused(population.weights.iter().map(|weight| weight / 2.0).collect());
    assert!(halved.contains("the weights add up to 0.5"), "{halved}");
    assert!(refused(vec![0.5, 0.5]).contains("2 weights for 40 individuals"));
    let mut negative = population.weights.clone();
    negative[3] = -0.1;
    assert!(refused(negative).contains("weight 4: -0.1 is no share"));
    // Other weights are other people: baselines hold the digest.
    let mut others = population.clone();
    others.weights.rotate_left(1);
    assert_ne!(others.digest(), population.digest());
}

#[test]
fn the_spread_may_have_a_tolerance_of_its_own() {
    // Two persons, of whom little is known: within two errors there are mixtures.
    let rows = "crossing, 4 s, 0.125, 8, 2, 1, 1, 0, 0, 0\ncrossing, 6 s, 0.5, 8, 2, 1, 0, 0, 0, 1\n";
    let with = |method: &str, spread: &str| {
        let spread = format!("match spread between individuals of rate(gap_accepted){spread}");
        calibrated(&format!("{MATCHED}\n  {spread}\n  {method}"), rows, &Threads::new(2)).unwrap()
    };
    let usual = with("", "");
    // As the method has it, said or not.
    assert_eq!(with("", " within 100 % of error").weights, usual.weights);
    let half = "method maximum_entropy within 50 % of error";
    assert_eq!(with(half, " within 50 % of error").weights, with(half, "").weights);
    let missed = |result: &CalibrateResult| {
        let apart = |one: &results::CalibratedCondition| (one.spread.fitted - one.spread.observed).abs();
        result.conditions.iter().map(apart).sum::<f64>()
    };
    let closer = with("", " within 30 % of error");
    assert!(missed(&closer) < missed(&usual), "{} and {}", missed(&closer), missed(&usual));
    assert!(closer.effective_size < usual.effective_size);
}

#[test]
fn closer_is_closer_and_what_is_compared_changes_no_weight() {
    let usual = calibrated(MATCHED, &ROWS.concat(), &Threads::new(2)).unwrap();
    let block =
        format!("{MATCHED}\n  method maximum_entropy within 30 % of error\n  compare with \"them.csv\"");
    let closer = calibrated(&block, &ROWS.concat(), &Threads::new(2)).unwrap();
    let missed = |result: &CalibrateResult| {
        let apart = |one: &results::CalibratedCondition| (one.share.fitted - one.share.observed).abs();
        result.conditions.iter().map(apart).sum::<f64>()
    };
    assert!(missed(&closer) < 0.8 * missed(&usual), "{} and {}", missed(&closer), missed(&usual));
    assert!(closer.effective_size < usual.effective_size);
    let [compared] = &closer.compared[..] else { panic!("{:?}", closer.compared) };
    assert_eq!((compared.name.as_str(), compared.individuals, compared.shares.len()), ("them.csv", 4, 2));
    // With more time more people go first.
    assert!(compared.shares[0].0 < compared.shares[1].0, "{compared:?}");
    assert!(compared.shares.iter().all(|(share, spread)| (0.0..=*share).contains(spread)));
    let same = calibrated(
        &format!("{MATCHED}\n  method maximum_entropy within 100 % of error\n  compare with standard"),
        &ROWS.concat(),
        &Threads::new(2),
    )
    .unwrap();
    assert_eq!((same.weights, same.conditions), (usual.weights, usual.conditions));
}
