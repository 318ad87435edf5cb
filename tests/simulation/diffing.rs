//! Two runs side by side: a run parts nowhere from itself, exchanging the two exchanges everything, nothing depends on who makes them, and
//! before they part nothing differs.

use std::path::Path;
use std::sync::Arc;

use files::{Disk, Memory};
use models::standard;
use results::{InBoth, PartedIn, Parting, PartsBy, Requests, SharedMoment, TwoRuns};
use runner::diff::{NoCounterpart, counterpart, two_runs};
use runner::plan::plan;
use runner::run::{Executor, MeasuredMetrics, RunBatch, Serialised, Shuffled, Stop, Threads, Wanted};
use scenario::{Case, Suite};
use sim::Sample;

fn read(path: &str, text: &str, set: &[&str], controllers: &[&str]) -> Suite {
    let outside = lang::Outside {
        set: set.iter().map(|one| one.parse().unwrap()).collect(),
        controllers: controllers.iter().map(|one| one.parse().unwrap()).collect(),
        uses: Vec::new(),
    };
    let files = Memory::default().with(path, text);
    lang::load_otherwise(Path::new(path), &outside, &standard(), &files)
        .unwrap_or_else(|failure| panic!("{}", failure.render(lang::Style::default())))
        .suite
}

fn shipped(file: &str) -> Suite {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("suites").join(file);
    lang::load(&path, &standard(), &Disk).unwrap_or_else(|_| panic!("{file} is a suite")).suite
}

fn with<T>(executor: &dyn Executor, make: impl FnOnce(RunBatch) -> T) -> T {
    let measured: Arc<MeasuredMetrics> = MeasuredMetrics::new(Requests::defaults(&standard()));
    let stop = Stop::default();
    make(RunBatch { executor, measured: &measured, stop: &stop })
}

fn laid(a: &Case, b: &Case) -> TwoRuns {
    with(&Threads::new(1), |batch| two_runs(batch, a, b).unwrap())
}

fn timeless(mut two: TwoRuns) -> TwoRuns {
    for side in [&mut two.a, &mut two.b] {
        side.outcome.wall_time = Default::default();
    }
    two
}

const WALK: &str = "
scenario walk {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller carla_behavior; speed 36 km/h; start 60 m before crossing }
  pedestrian walker {
    model carla_walker
    start 1 m from kerb
    appears when time_to_arrival(av) = tta
  }
  vary tta in [2 s, 4 s]
  draw late from uniform(0 s, 2 s)
  pedestrian other { model carla_walker; along 1.5 m; start 1 m from kerb; appears at late }
  repeat 2
  expect { no collision; pet >= bound }
  let bound = 1.5 s
}
";

/// The first run of a file, as it is with other controllers and values.
fn pair(a: (&[&str], &[&str]), b: (&[&str], &[&str])) -> (Case, Case) {
    let as_it_is = plan(&read("a.scn", WALK, &[], &[])).unwrap().trial(0).cases.get(1);
    let one = |(set, controllers): (&[&str], &[&str])| {
        let names: Vec<&str> = set.iter().map(|one| one.split('=').next().unwrap()).collect();
        counterpart(&read("a.scn", WALK, set, controllers), &as_it_is, &names).unwrap().0
    };
    (one(a), one(b))
}

#[test]
fn a_run_parts_nowhere_from_itself() {
    for file in ["zebra.suite", "zebra_unsafe.suite", "streets.suite", "euro_ncap_vru.suite"] {
        let suite = shipped(file);
        for trial in plan(&suite).unwrap().trials().step_by(5).take(6) {
            let case = trial.cases.first();
            let two = laid(&case, &case);
            assert!(two.are_one() && two.apart.is_none() && two.differs.is_empty(), "{}: {two:?}", case.key);
            assert_eq!(two.a.outcome.metrics, two.b.outcome.metrics);
            // By the name of the run it is found again, bit for bit.
            let (again, _) = counterpart(&suite, &case, &[]).unwrap();
            assert!(laid(&case, &again).are_one(), "{}", case.key);
        }
    }
}

/// B in the place of A.
fn exchanged(two: TwoRuns) -> TwoRuns {
    let parts = |parting: Option<Parting>| {
        parting.map(|Parting { time, by }| Parting {
            time,
            by: by
                .into_iter()
                .map(|PartsBy { who, what }| {
                    let what = match what {
                        PartedIn::Presence { in_a } => PartedIn::Presence { in_a: !in_a },
                        PartedIn::Motion { apart, relative_speed, a, b } => {
                            PartedIn::Motion { apart, relative_speed, a: b, b: a }
                        }
                        PartedIn::Event { a, b } => PartedIn::Event { a: b, b: a },
                        PartedIn::Decision { a, b } => PartedIn::Decision { a: b, b: a },
                        PartedIn::Ending { a, b } => PartedIn::Ending { a: b, b: a },
                    };
                    PartsBy { who, what }
                })
                .collect(),
        })
    };
    let moments = two.moments.into_iter().map(|SharedMoment { time, each }| SharedMoment {
        time,
        each: each.into_iter().map(|InBoth { who, a, b }| InBoth { who, a: b, b: a }).collect(),
    });
    TwoRuns {
        a: two.b,
        b: two.a,
        differs: Vec::new(),
        first: parts(two.first),
        apart: parts(two.apart),
        moments: moments.collect(),
    }
}

type Otherwise = (&'static [&'static str], &'static [&'static str]);

const PAIRS: [(Otherwise, Otherwise); 5] = [
    ((&[], &["av=carla_behavior"]), (&[], &["av=idm_aeb"])),
    ((&["tta=2s"], &[]), (&["tta=4s"], &[])),
    ((&["walker.model.walking_speed=1.4m/s"], &[]), (&["walker.model.walking_speed=1.2m/s"], &[])),
    ((&["horizon=6s"], &[]), (&["horizon=9s"], &[])),
    ((&["late=1s"], &[]), (&["late=1.5s"], &[])),
];

#[test]
fn exchanging_the_two_exchanges_everything() {
    for (a, b) in PAIRS {
        let (a, b) = pair(a, b);
        let forth = laid(&a, &b);
        assert!(!forth.are_one() && forth.apart.is_some() && !forth.differs.is_empty(), "{a:?}");
        let differs = forth.differs.len();
        let back = laid(&b, &a);
        assert_eq!(back.differs.len(), differs);
        // What is there in one only is told in the order of who has it.
        let sorted = |mut two: TwoRuns| {
            for parting in [&mut two.first, &mut two.apart].into_iter().flatten() {
                parting.by.sort_by_key(|one| format!("{one:?}"));
            }
            timeless(two)
        };
        let back = TwoRuns { differs: Vec::new(), ..sorted(back) };
        assert_eq!(sorted(exchanged(forth)), back);
    }
}

#[test]
fn who_makes_the_runs_changes_nothing() {
    for (a, b) in PAIRS {
        let (a, b) = pair(a, b);
        let alone = timeless(laid(&a, &b));
        let threads = Threads::new(3);
        let serialised = Serialised::new(Threads::new(2), standard());
        let others: [&dyn Executor; 3] = [&threads, &Shuffled::seeded(7), &serialised];
        for executor in others {
            let two = with(executor, |batch| two_runs(batch, &a, &b).unwrap());
            assert_eq!(timeless(two), alone);
        }
    }
}

/// Looked at by another way: row by row of what both recorded.
#[test]
fn before_they_part_nothing_differs_and_then_something_does() {
    for (a, b) in PAIRS {
        let (a, b) = pair(a, b);
        let two = laid(&a, &b);
        let [in_a, in_b] =
            [&a, &b].map(|case| with(&Threads::new(1), |batch| batch.one(case, Wanted::Commands).unwrap()));
        let (first, apart) = (two.first.unwrap().time, two.apart.unwrap().time);
        assert!(first <= apart, "{first} {apart}");
        let far = |time: f64, least: f64| {
            let rows = |all: &[Sample]| -> Vec<Sample> {
                all.iter().filter(|one| (one.time - time).abs() < 1e-9).cloned().collect()
            };
            let (a, b) = (rows(&in_a.trace.samples), rows(&in_b.trace.samples));
            if a.is_empty() || b.is_empty() {
                return false;
            }
            let differ = |(a, b): (&Sample, &Sample)| {
                let away = (a.position - b.position).norm().max((a.velocity - b.velocity).norm());
                a.who != b.who || away > least
            };
            a.len() != b.len() || a.iter().zip(&b).any(differ)
        };
        let times: Vec<f64> = in_a.trace.samples.iter().map(|one| one.time).collect();
        assert!(times.iter().filter(|time| **time < first - 1e-9).all(|time| !far(*time, 0.0)));
        assert!(times.iter().filter(|time| **time < apart - 1e-9).all(|time| !far(*time, 0.1)));
        let ends = [&in_a, &in_b].map(|ran| ran.outcome.ending.time);
        assert!(far(apart, 0.1) || (apart - ends[0].min(ends[1])).abs() < 1e-9, "{apart}");
        let commands = [&in_a, &in_b].map(|ran| {
            let given = ran.commands[0].iter();
            given.take_while(|one| one.time < first - 1e-9).cloned().collect::<Vec<_>>()
        });
        assert_eq!(commands[0], commands[1], "nothing else was told before");
    }
}

/// With another value a run has another name, and would have another seed: then both would differ by chance.
#[test]
fn both_are_on_the_same_noise() {
    let (a, b) = pair((&["tta=2s"], &[]), (&["tta=4s"], &[]));
    assert_ne!(a.key, b.key);
    assert_eq!(a.seed, b.seed);
    assert_eq!(a.drawn, b.drawn, "what is drawn is drawn alike");
    let planned = plan(&read("a.scn", WALK, &[], &[])).unwrap().trial(1).cases.get(1);
    assert!(planned.key == b.key && planned.seed != b.seed);
    // Where a draw is given a value, what else is drawn stays.
    let (a, b) = pair((&["late=1s"], &[]), (&["late=1s"], &[]));
    assert!(a.drawn.is_empty() && laid(&a, &b).are_one());
}

#[test]
#[should_panic(expected = "on the same noise")]
fn runs_with_other_seeds_are_not_laid_side_by_side() {
    let (a, b) = pair((&[], &[]), (&[], &[]));
    laid(&a, &Case { seed: b.seed + 1, ..b });
}

/// A name that is set but that nothing of the run depends on is told, and does not look like two runs that came out alike.
#[test]
fn what_changes_nothing_is_told_apart_from_what_is_not_used() {
    let (a, b) = pair((&["bound=1s"], &[]), (&["bound=9s"], &[]));
    let two = laid(&a, &b);
    assert!(two.are_one() && two.differs.is_empty());
    // A bound that no step of this run reaches.
    let (a, b) = pair((&["horizon=50s"], &[]), (&["horizon=55s"], &[]));
    let two = laid(&a, &b);
    assert_eq!(two.are_one(), two.a.outcome.ending == two.b.outcome.ending);
    assert!(!two.differs.is_empty());
}

#[test]
fn there_is_no_counterpart_of_what_is_gone() {
    let as_it_is = plan(&read("a.scn", WALK, &[], &[])).unwrap().trial(0).cases.get(1);
    let other = WALK.replace("scenario walk", "scenario run");
    let gone = counterpart(&read("a.scn", &other, &[], &[]), &as_it_is, &[]);
    assert!(matches!(gone, Err(NoCounterpart::Scenario(name)) if name == "walk"));
    let several = counterpart(&read("a.scn", WALK, &[], &[]), &as_it_is, &["tta"]);
    assert!(matches!(several, Err(NoCounterpart::Several(2))));
    let changed = read("a.scn", &WALK.replace("[2 s, 4 s]", "[3 s]"), &[], &[]);
    let values = counterpart(&changed, &as_it_is, &[]).unwrap_err();
    assert!(values.to_string().contains("has tta = 2s"), "{values}");
}
