//! Calibrations: what must not matter changes nothing, what is cut off goes on, and what cannot be says so.

use std::path::Path;
use std::sync::LazyLock;
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

/// The calibration that most tests compare with another one.
static USUAL: LazyLock<CalibrateResult> =
    LazyLock::new(|| calibrated(MATCHED, &ROWS.concat(), &Threads::new(2)).unwrap());

#[test]
fn the_order_of_rows_and_of_runs_changes_nothing() {
    let usual = &*USUAL;
    let turned = calibrated(MATCHED, &[ROWS[1], ROWS[0]].concat(), &Threads::new(2)).unwrap();
    let shuffled = calibrated(MATCHED, &ROWS.concat(), &Shuffled::seeded(3)).unwrap();
    assert_eq!(*usual, shuffled);
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
         method maximum_entropy within 80 % of error\n  \
         match mean of walker.model.T_delta to 40 s within 20 s",
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
    let stop = Stop::default();
    let stops = StopsAt(stop.clone(), AtomicUsize::new(0));
    let cut = run(&suite, &Threads::new(2), Some(folder.path()), &stop, &stops);
    assert!(matches!(cut, Err(ExperimentError::Stopped)), "{cut:?}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    let resumed = run(&suite, &Threads::new(2), Some(folder.path()), &Stop::default(), &Silent).unwrap();
    assert_eq!(resumed, *USUAL);
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
    let result = &*USUAL;
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
        let apart = |one: &results::CalibratedCondition| {
            let spread = one.spread.expect("it is known of people");
            (spread.fitted - spread.observed).abs()
        };
        result.conditions.iter().map(apart).sum::<f64>()
    };
    let closer = with("", " within 30 % of error");
    assert!(missed(&closer) < missed(&usual), "{} and {}", missed(&closer), missed(&usual));
    assert!(closer.effective_size < usual.effective_size);
}

/// Mean and root mean square distance from `centre` of a parameter.
fn moments(result: &CalibrateResult, weights: &[f64], parameter: &str, centre: f64) -> (f64, f64) {
    let column = result.parameters.iter().position(|name| name == parameter).expect("they have it");
    let of = |power: &dyn Fn(f64) -> f64| -> f64 {
        result.individuals.iter().zip(weights).map(|(row, weight)| weight * power(row[column])).sum()
    };
    (of(&|value| value), of(&|value| (value - centre) * (value - centre)).sqrt())
}

const LIVES: &str = "match mean of walker.model.T_delta to 45 s within 0.5 s\n  \
                     match deviation of walker.model.T_delta to 18 s within 0.5 s";

#[test]
fn a_parameter_is_distributed_as_it_is_matched() {
    let usual = &*USUAL;
    let block = format!("{MATCHED}\n  {LIVES}\n  compare with \"them.csv\"");
    let suite = load(&block, &ROWS.concat());
    let result = run(&suite, &Threads::new(2), None, &Stop::default(), &Silent).unwrap();
    let equal = vec![1.0 / 40.0; 40];
    // It would not come out by itself.
    for weights in [&usual.weights, &equal] {
        let (mean, deviation) = moments(usual, weights, "T_delta", 45.0);
        assert!((mean - 45.0).abs() > 0.5 || (deviation - 18.0).abs() > 0.5, "{mean} {deviation}");
    }
    // As other persons might have been observed, it is distributed so as well.
    for weights in std::iter::once(&result.weights).chain(&result.resampled) {
        let (mean, deviation) = moments(&result, weights, "T_delta", 45.0);
        assert!((mean - 45.0).abs() <= 0.501 && (deviation - 18.0).abs() <= 0.501, "{mean} {deviation}");
    }
    // So it is among the members of the population that comes of it, whose number is what rounds them.
    let population = result.population();
    let members =
        (1..=WEIGHTED_MEMBERS).map(|number| population.individual(number).unwrap().number("T_delta"));
    let mean = members.sum::<f64>() / WEIGHTED_MEMBERS as f64;
    assert!((mean - 45.0).abs() < 0.55, "{mean}");
    // What is told is what is.
    let [mean, deviation] = &result.matched_parameters[..] else { panic!("{:?}", result.matched_parameters) };
    assert_eq!((mean.statistic.as_str(), deviation.statistic.as_str()), ("mean", "deviation"));
    assert_eq!(
        (mean.parameter.as_str(), mean.unit.as_str(), mean.wanted, mean.within),
        ("T_delta", "s", 45.0, 0.5)
    );
    let told = (mean.fitted, deviation.fitted);
    let found = moments(&result, &result.weights, "T_delta", 45.0);
    assert!((told.0 - found.0).abs() < 1e-9 && (told.1 - found.1).abs() < 1e-9, "{told:?} {found:?}");
    let found = moments(&result, &equal, "T_delta", 45.0);
    assert!((mean.equal - found.0).abs() < 1e-9 && (deviation.equal - found.1).abs() < 1e-9);
    // Of 20, 40, 80 and 15 s.
    assert_eq!(result.compared[0].parameters[0], Some(38.75));
    let text = report::render_calibrate(&result);
    assert!(text.contains("mean of T_delta       45 s ± 0.5 s"), "{text}");
    let json: serde_json::Value = serde_json::to_value(&result.population().provenance).unwrap();
    assert_eq!(json["matched_parameters"][1]["statistic"], "deviation");
    // Shares are matched beside it.
    let share = result.conditions[1].share;
    assert!((share.fitted - share.observed).abs() < (share.equal - share.observed).abs(), "{share:?}");
    // The method's tolerance is none of it.
    let closer = format!("{MATCHED}\n  {LIVES}\n  method maximum_entropy within 40 % of error");
    let closer = calibrated(&closer, &ROWS.concat(), &Threads::new(2)).unwrap();
    let (mean, deviation) = moments(&closer, &closer.weights, "T_delta", 45.0);
    assert!((mean - 45.0).abs() <= 0.501 && (deviation - 18.0).abs() <= 0.501, "{mean} {deviation}");
}

#[test]
fn a_distribution_that_the_candidates_cannot_have_is_told_before_any_run() {
    let said = |lives: &str| {
        let told = Told::default();
        let suite = load(&format!("{MATCHED}\n  {lives}"), &ROWS.concat());
        let error = run(&suite, &Threads::new(2), None, &Stop::default(), &told).unwrap_err();
        assert!(told.0.lock().unwrap().is_empty(), "nobody was run");
        format!("{error} ({})", error.hint().unwrap_or_default())
    };
    let far = said("match mean of walker.model.T_delta to 250 s within 5 s");
    assert!(
        far.contains(
            "no mixture of the candidates is as people are: the mean of `T_delta` is to be 250 s ± 5 s"
        ) && far.contains("and the nearest mixture has 9"),
        "{far}"
    );
    // A mean at one end, and a deviation that only both ends have.
    let wide = "match mean of walker.model.T_delta to 90 s within 1 s\n  \
                match deviation of walker.model.T_delta to 40 s within 1 s";
    assert!(said(wide).contains("the nearest mixture has"), "{}", said(wide));
    let alike = said("match mean of walker.model.ped_free_speed to 1.34 m/s within 0.03 m/s");
    assert!(
        alike
            .contains("the mean of `ped_free_speed` is to be matched, in which the candidates do not differ")
            && alike.contains("--draw \"ped_free_speed=normal(MEAN, DEVIATION)\""),
        "{alike}"
    );
}

#[test]
fn closer_is_closer_and_what_is_compared_changes_no_weight() {
    let usual = &*USUAL;
    let block = format!("{MATCHED}\n  method maximum_entropy within 30 % of error");
    let closer = calibrated(&block, &ROWS.concat(), &Threads::new(2)).unwrap();
    let missed = |result: &CalibrateResult| {
        let apart = |one: &results::CalibratedCondition| (one.share.fitted - one.share.observed).abs();
        result.conditions.iter().map(apart).sum::<f64>()
    };
    assert!(missed(&closer) < 0.8 * missed(usual), "{} and {}", missed(&closer), missed(usual));
    assert!(closer.effective_size < usual.effective_size);
    let same = assert_same_beside("\"them.csv\"", usual);
    let [compared] = &same.compared[..] else { panic!("{:?}", same.compared) };
    assert_eq!((compared.name.as_str(), compared.individuals, compared.shares.len()), ("them.csv", 4, 2));
    // With more time more people go first.
    assert!(compared.shares[0].0 < compared.shares[1].0, "{compared:?}");
    let both = |(share, spread): &(Option<f64>, Option<f64>)| share.zip(*spread);
    let known: Vec<(f64, f64)> = compared.shares.iter().filter_map(both).collect();
    assert!(known.len() == 2 && known.iter().all(|(share, spread)| (0.0..=*share).contains(spread)));
}

#[test]
#[ignore = "it has everybody of a population that ships walk"]
fn a_population_that_ships_changes_no_weight_either() {
    let usual = &*USUAL;
    let same = assert_same_beside("standard", usual);
    assert_eq!(same.compared[0].individuals, 1123);
}

#[test]
fn where_all_runs_count_nothing_changes_to_the_last_bit() {
    let usual = &*USUAL;
    let with = MATCHED.replace("undefined fails", "where min_distance >= 0 m undefined fails");
    let same = calibrated(&with, &ROWS.concat(), &Threads::new(2)).unwrap();
    assert_eq!((&same.weights, &same.resampled), (&usual.weights, &usual.resampled));
    for (one, other) in same.conditions.iter().zip(&usual.conditions) {
        let counted = one.counted.expect("it is told which runs count");
        assert!((counted.share - 1.0).abs() < 1e-6, "{counted:?}");
        assert_eq!((one.share, one.spread, one.undefined), (other.share, other.spread, other.undefined));
    }
    assert_eq!(same.matched, "rate(gap_accepted) where min_distance >= 0 m");
    assert!(report::render_calibrate(&same).contains("counted (runs)"));
}

/// Of the version before runs could be left uncounted.
const DIGEST_BEFORE: &str = "332e24fa65e6dc6e";

#[test]
fn the_people_that_ship_are_weighed_as_they_were() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/people");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let block = "calibrate humans {
  candidates 100 of \"candidates.json\"
  in crossing_plain
  match rate(gap_accepted) to \"plain.csv\" undefined fails
  match spread between individuals of rate(gap_accepted)
  match mean of walker.model.ped_free_speed to 1.34 m/s within 0.05 m/s
  folds 2
  repeat 4
}
";
    let rows = read("human_crossing.csv");
    let rows: Vec<&str> = rows.lines().filter(|line| !line.starts_with("crossing_zebra")).collect();
    let files = Memory::default()
        .with("people.scn", format!("{}\n{block}", read("encounter.scn")))
        .with("encounter_street.scn", read("encounter_street.scn"))
        .with("candidates.json", read("candidates.json"))
        .with("plain.csv", rows.join("\n"));
    let loaded = lang::load(Path::new("people.scn"), &standard(), &files);
    let suite = loaded.unwrap_or_else(|_| panic!("it is right")).suite;
    let result = run(&suite, &Threads::new(2), None, &Stop::default(), &Silent).unwrap();
    assert_eq!(result.digest, DIGEST_BEFORE);
}

/// Who is nearer than 3 m to the vehicle at some time is asked; the others do not count.
const NEAR: &str = "candidates 40 by latin_hypercube\n  \
                    match rate(gap_accepted) to \"people.csv\" where min_distance < 3 m undefined fails";
const FEW_ROWS: [&str; 2] =
    ["crossing, 4 s, 0.125, 8, 2, 1, 1, 0, 0, 0\n", "crossing, 6 s, 0.5, 8, 2, 1, 0, 0, 0, 1\n"];

#[test]
fn only_runs_that_count_are_weighed_in_whatever_order() {
    let usual = calibrated(NEAR, &FEW_ROWS.concat(), &Threads::new(2)).unwrap();
    assert!(usual.conditions.iter().any(|one| one.counted.unwrap().share < 0.95), "{:?}", usual.conditions);
    let shuffled = calibrated(NEAR, &FEW_ROWS.concat(), &Shuffled::seeded(4)).unwrap();
    assert_eq!(usual, shuffled);
    let turned = calibrated(NEAR, &[FEW_ROWS[1], FEW_ROWS[0]].concat(), &Threads::new(1)).unwrap();
    assert_eq!((&usual.weights, &usual.conditions), (&turned.weights, &turned.conditions));
    // On so few runs nothing should rest, and that is said.
    assert!(
        usual.warnings.iter().any(|one| one.contains("of equal weight that count for")),
        "{:?}",
        usual.warnings
    );
    let text = serde_json::to_string(&usual.population().provenance).unwrap();
    assert!(text.contains("\"counted\":{"), "{text}");
}

/// Any weights would match what nobody is left to do: no result, and never a good one.
#[test]
fn two_files_about_scenarios_of_their_own_are_one_file_about_both() {
    let rows = ROWS.concat();
    let again = rows
        .replace("crossing", "again")
        .replace("0.6719, 128, 32, 8, 2, 0, 4, 18", "0.5, 64, 16, 8, 0, 0, 0, 8");
    let of = |block: &str| {
        let text = text(block)
            .replace("in crossing", "in crossing, again")
            .replace("calibrate people {", "scenario again : crossing { }\ncalibrate people {");
        let files = Memory::default()
            .with("people.scn", text)
            .with("people.csv", format!("{HEADER}{rows}"))
            .with("again.csv", format!("{HEADER}{again}"))
            .with("both.csv", format!("{HEADER}{rows}{again}"));
        let suite = lang::load(Path::new("people.scn"), &standard(), &files);
        let suite = suite.unwrap_or_else(|_| panic!("it is right")).suite;
        run(&suite, &Threads::new(2), None, &Stop::default(), &Silent).unwrap()
    };
    let block = |matched: &str| format!("candidates 40 by latin_hypercube\n  {matched}\n  folds 2");
    let one = of(&block("match rate(gap_accepted) to \"both.csv\" undefined fails"));
    let first = "match rate(gap_accepted) to \"people.csv\" undefined fails";
    let two = of(&block(&format!("{first}\n  match rate(gap_accepted) to \"again.csv\" undefined fails")));
    assert_eq!(
        (&one.weights, &one.conditions, one.folds_rms),
        (&two.weights, &two.conditions, two.folds_rms)
    );
    assert_eq!(two.observations, "people.csv and again.csv");
    // What counts in the one is not what counts in the other.
    let other = of(&block(&format!(
        "{first}\n  match rate(pet <= 2 s) to \"again.csv\" where no collision undefined fails"
    )));
    let [.., of_other] = &other.conditions[..] else { panic!("{:?}", other.conditions) };
    assert_eq!(other.conditions[..2].iter().map(|one| one.counted).collect::<Vec<_>>(), [None, None]);
    assert!(of_other.counted.is_some(), "{of_other:?}");
    for (one, other) in one.conditions[..2].iter().zip(&other.conditions) {
        assert_eq!((one.share.equal, one.undefined > 0.0), (other.share.equal, other.undefined > 0.0));
    }
    assert_ne!(one.conditions[2].share.equal, other.conditions[2].share.equal);
}

#[test]
fn two_rates_of_one_scenario_are_of_the_same_runs() {
    let usual = &*USUAL;
    let second = "match rate(collision) to \"hit.csv\" undefined fails";
    let text = text(&format!("{MATCHED}\n  {second}"));
    let rows =
        "crossing, 6 s, 0.0078, 128, 32, 31, 1, 0, 0, 0\ncrossing, 4 s, 0.0156, 128, 32, 30, 2, 0, 0, 0\n";
    let files = Memory::default()
        .with("people.scn", text)
        .with("people.csv", format!("{HEADER}{}", ROWS.concat()))
        .with("hit.csv", format!("{HEADER}{rows}"));
    let suite = lang::load(Path::new("people.scn"), &standard(), &files);
    let suite = suite.unwrap_or_else(|_| panic!("it is right")).suite;
    let both = run(&suite, &Threads::new(2), None, &Stop::default(), &Silent).unwrap();
    let subjects: Vec<_> = both.conditions.iter().map(|one| one.in_words()).collect();
    let expected = [
        ("4s", "rate(gap_accepted)"),
        ("6s", "rate(gap_accepted)"),
        ("4s", "rate(collision)"),
        ("6s", "rate(collision)"),
    ];
    assert_eq!(subjects, expected.map(|(gap, rate)| format!("crossing gap={gap}: {rate}")));
    for (one, other) in usual.conditions.iter().zip(&both.conditions) {
        assert_eq!((one.share.equal, one.undefined > 0.0), (other.share.equal, other.undefined > 0.0));
    }
}

#[test]
fn a_condition_in_which_nobody_is_left_is_an_error() {
    let said = |block: &str| {
        let error = calibrated(block, &FEW_ROWS.concat(), &Threads::new(2)).unwrap_err();
        format!("{error} ({})", error.hint().unwrap_or_default())
    };
    let nobody = said(&NEAR.replace("< 3 m", "< 0 m"));
    assert!(nobody.contains("no run of any candidate of crossing, gap 4 s counts for"), "{nobody}");
    assert!(nobody.contains("nobody was left to do it"), "{nobody}");
    // Runs that the horizon cut off may count or not.
    let cut_off = said(&MATCHED.replace("undefined fails", "undefined not counted"));
    assert!(cut_off.contains("nobody knows whether they count"), "{cut_off}");
    assert!(cut_off.contains("a longer `horizon`"), "{cut_off}");
    // What runs count by is defined in all of them, or it is an error.
    let unknown = said(&NEAR.replace("min_distance < 3 m", "tta_at_entry >= 0 s"));
    assert!(unknown.contains("nobody knows whether they count"), "{unknown}");
}

/// Two cars, one after the other.
const SECOND_GAP: &str = r#"
scenario second_gap {
  road { lane_width 2.25 m; speed_limit 30 km/h; crossing unmarked }
  vary gap in [4 s, 6 s]
  vehicle car_1 { controller constant_speed; speed 30 km/h; start 3 s before crossing }
  vehicle car_2 { controller constant_speed; speed 30 km/h; start 3 s + gap before crossing }
  pedestrian walker { model commotions; individuals 20 of standard; start 2.5 m from lane centre }
  horizon 60 s
  expect { no collision }
}
calibrate people {
  in second_gap
  candidates 60 of standard
  repeat 4
  MATCH
}
"#;

#[test]
fn undefined_runs_that_are_not_counted_are_no_runs_in_which_nothing_held() {
    let rows = "scenario, gap, share, trials, persons, error\n\
                second_gap, 4 s, 0.4, 400, 30, 0.1\nsecond_gap, 6 s, 0.4, 400, 30, 0.1\n";
    let of = |matched: &str| {
        let text = SECOND_GAP.replace("MATCH", matched);
        let files = Memory::default().with("people.scn", text).with("people.csv", rows);
        let loaded = lang::load(Path::new("people.scn"), &standard(), &files);
        let suite = loaded.unwrap_or_else(|_| panic!("it is right")).suite;
        run(&suite, &Threads::new(2), None, &Stop::default(), &Silent)
    };
    // Only who goes before the first car has a time to its arrival.
    let before = "match rate(tta_at_entry(car_1, walker) >= 1 s) to \"people.csv\"";
    let result = of(&format!("{before} undefined not counted")).unwrap();
    for one in &result.conditions {
        let counted = one.counted.expect("it is told which runs count");
        assert!((counted.share + one.undefined - 1.0).abs() < 1e-6 && counted.share < 0.3, "{one:?}");
        // Of those who go, not of everybody.
        assert!(one.share.equal > 0.3, "{one:?}");
    }
    // What rests on so few runs is luck, and is told.
    let warned = |what: &str| result.warnings.iter().any(|one| one.contains(what));
    assert!(warned("of equal weight that count for") && warned("under fresh noise"), "{:?}", result.warnings);
    // As runs in which nothing held, they would make it seldom.
    let fails = of(&format!("{before} undefined fails")).unwrap();
    assert!(fails.conditions.iter().all(|one| one.counted.is_none() && one.share.equal < 0.2));
    // Who goes before the first car goes before the second, too, unless only those count who are still there.
    let second = "match rate(gap_accepted(car_2, walker)) to \"people.csv\"";
    let equal = |where_: &str| {
        let result = of(&format!("{second}{where_} undefined fails")).unwrap();
        result.conditions.iter().map(|one| one.share.equal).sum::<f64>()
    };
    assert!(equal("") > equal(" where no gap_accepted(car_1, walker)") + 0.02);
}

#[test]
fn errors_may_stand_for_counts_and_spreads_of_some_conditions_be_unknown() {
    let rows = "scenario, gap, share, trials, persons, error, pair_share, pair_error\n\
                crossing, 4 s, 0.125, 30, 8, 0.1, 0.05, 0.06\ncrossing, 6 s, 0.5, 31, 8, 0.15, , \n";
    let block = format!("{MATCHED}\n  match spread between individuals of rate(gap_accepted)");
    let files = Memory::default().with("people.scn", text(&block)).with("people.csv", rows);
    let loaded = lang::load(Path::new("people.scn"), &standard(), &files);
    let suite = loaded.unwrap_or_else(|_| panic!("it is right")).suite;
    let result = run(&suite, &Threads::new(2), None, &Stop::default(), &Silent).unwrap();
    let [known, unknown] = &result.conditions[..] else { panic!("{:?}", result.conditions) };
    assert_eq!((known.share.observed, known.share.error), (0.125, 0.1));
    assert_eq!(known.spread.map(|spread| (spread.observed, spread.error)), Some((0.05, 0.06)));
    assert_eq!(unknown.spread, None);
    assert_eq!(result.resampled.len(), 20);
    let table = report::render_calibrate(&result);
    assert_eq!(table.matches("crossing gap=6s").count(), 1, "{table}");
}

/// What is compared besides changes nothing of what comes of people.
fn assert_same_beside(others: &str, usual: &CalibrateResult) -> CalibrateResult {
    let block = format!("{MATCHED}\n  method maximum_entropy within 100 % of error\n  compare with {others}");
    let same = calibrated(&block, &ROWS.concat(), &Threads::new(2)).unwrap();
    assert_eq!((&same.weights, &same.conditions), (&usual.weights, &usual.conditions));
    same
}
