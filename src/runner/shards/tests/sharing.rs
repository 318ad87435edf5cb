//! Several workers at one unit come to what one comes to, and each makes a part of it.

use std::thread;
use std::time::Duration;

use super::*;
use crate::run::{Done, Job, JobPlace, RunDigest, RunResults, Sharing, StoredRun, Wanted};
use crate::shards::unit_journal::{Heard, HeardRun, JournalSubject, Resumed, UnitJournal};
use crate::shards::unit_runs::{NotEnded, SharedWith, UnitRuns};

/// Of each kind that decides itself which runs it makes, in rounds of some runs.
fn place() -> Place {
    let place = Place::new();
    let text = fs::read_to_string(&place.files[0]).unwrap();
    // Without the gate, which has all runs made.
    let gate = text.find("  gate braking").unwrap();
    let after = gate + text[gate..].find('\n').unwrap();
    let text = format!("{}{}", &text[..gate], &text[after..]);
    let text = text.replace("repeat 2\n  budget 6", "repeat 20\n  budget 6");
    fs::write(&place.files[0], text.replace("  stop early\n", "")).unwrap();
    place
}

/// Makes runs one after the other, each of which takes that long, and counts them.
struct Slow {
    threads: Threads,
    run: Duration,
    made: AtomicUsize,
    /// After so many it is stopped.
    most: usize,
    stop: Stop,
}

struct SlowRound<'r> {
    round: &'r mut dyn Round,
    of: &'r Slow,
}

impl Round for SlowRound<'_> {
    fn next(&mut self) -> Option<Job> {
        self.round.next()
    }

    fn done(&mut self, mut done: Done) {
        thread::sleep(self.of.run);
        if let Ok(ran) = &mut done.result {
            ran.outcome.wall_time = self.of.run;
        }
        if self.of.made.fetch_add(1, Ordering::Relaxed) + 1 >= self.of.most {
            self.of.stop.request();
        }
        self.round.done(done);
    }

    fn is_wanted(&mut self, place: JobPlace) -> bool {
        self.round.is_wanted(place)
    }
}

impl Slow {
    fn new(run: u64) -> Self {
        let (threads, made, most) = (Threads::new(1), AtomicUsize::new(0), usize::MAX);
        Self { threads, run: Duration::from_millis(run), made, most, stop: Stop::default() }
    }

    fn made(&self) -> usize {
        self.made.load(Ordering::Relaxed)
    }
}

impl Executor for Slow {
    fn run(&self, round: &mut dyn Round) {
        self.threads.run(&mut SlowRound { round, of: self });
    }

    fn parallelism(&self) -> usize {
        1
    }

    fn host(&self, work: &mut (dyn FnMut() + Send)) {
        self.threads.host(work);
    }
}

/// A unit with what one worker by itself makes of it.
struct Alone<'p> {
    place: &'p Place,
    project: Project,
    manifest: ManifestReader,
    runs: usize,
    files: BTreeMap<PathBuf, Vec<u8>>,
}

const UNITS: [&str; 5] = ["=found", "=good", "=both", "everything/open/tta=12s", "=rarely"];

impl<'p> Alone<'p> {
    fn new(place: &'p Place, unit: &str) -> Self {
        let project = place.project();
        let manifest = plan(place, &project, |key| key.ends_with(unit));
        let _ = fs::remove_dir_all(place.results());
        let executor = Slow::new(0);
        execute(place, &project, &manifest, &executor, &|_, _| true).unwrap();
        let files = files(place);
        let alone = Self { place, project, manifest, runs: executor.made(), files };
        alone.begin_anew();
        alone
    }

    fn begin_anew(&self) {
        fs::remove_dir_all(self.place.results()).unwrap();
    }

    /// A worker with all of it or nothing of it for its share.
    fn work(&self, name: &str, all: bool, executor: &Slow) -> Result<Executed, ShardError> {
        let worker = Worker { name, mine: &|_, _| all, joins: true };
        worker.execute(self.place, &self.project, &self.manifest, executor, &executor.stop)
    }

    fn journals(&self) -> Vec<PathBuf> {
        let found = fs::read_dir(self.place.results().join("journal")).into_iter().flatten();
        let mut found: Vec<PathBuf> = found.map(|file| file.unwrap().path()).collect();
        found.sort();
        found
    }

    /// Until a worker has made some runs.
    fn await_runs(&self, executor: &Slow, runs: usize) {
        while executor.made() < runs {
            thread::sleep(Duration::from_millis(1));
        }
    }

    fn assert_same(&self, what: &str) {
        assert_eq!(files(self.place), self.files, "{what}");
        assert!(self.journals().is_empty(), "{what}: {:?}", self.journals());
    }

    /// Opens a journal of another worker.
    fn journal(&self, worker: &str, canary: &str) -> Resumed {
        let batch = self.manifest.batches().unwrap().next().unwrap().unwrap();
        let subject = JournalSubject { unit: &batch.units[0].id, build: &build(), canary };
        UnitJournal::open(&self.place.results(), subject, worker)
    }
}

/// Asserts that some workers, each with all of a unit for its share, get the results of one worker, and that each makes a part of the runs.
/// A run takes `run` ms.
fn assert_made_together(place: &Place, unit: &str, run: u64, workers: usize) {
    let alone = Alone::new(place, unit);
    let executors: Vec<Slow> = (0..workers).map(|_| Slow::new(run)).collect();
    thread::scope(|scope| {
        for (number, executor) in executors.iter().enumerate() {
            let alone = &alone;
            scope.spawn(move || alone.work(&format!("here.{number}"), true, executor).unwrap());
        }
    });
    alone.assert_same(unit);
    let made: Vec<usize> = executors.iter().map(Slow::made).collect();
    let said = format!("{unit}: {made:?} of {}", alone.runs);
    assert!(made.iter().all(|made| *made * 15 * workers >= alone.runs), "{said}");
    // Workers make few runs twice.
    assert!(made.iter().sum::<usize>() < alone.runs * workers * 9 / 10 + 20, "{said}");
    assert_eq!(merge(place, &alone.project, &alone.manifest).map(|_| ()), Ok(()), "{unit}");
    alone.begin_anew();
}

#[test]
fn workers_with_the_same_share_make_its_runs_together() {
    let place = place();
    for unit in UNITS {
        let (run, workers) = match unit {
            "=rarely" => (2, 3),
            "everything/open/tta=12s" => (20, 2),
            "=found" => (5, 3),
            _ => (5, 2),
        };
        assert_made_together(&place, unit, run, workers);
    }
}

/// Rounds of many people: those of a search for all of them together, and candidates of whom a population is made.
const PEOPLE: &str = r#"suite persons {
  seed 7
  scenario crossing {
    road { lanes forward; lane_width 3.65 m; speed_limit 50 km/h; crossing unmarked { width: 4 m } }
    vehicle av {
      controller constant_speed
      size 4.2 m x 1.8 m
      speed 50 km/h
      start 2.5 m + (gap - 1 s) * 50 km/h before crossing
    }
    pedestrian walker { model commotions; size 0.8 m x 0.8 m; start 3.25 m from lane centre }
    vary gap in [4 s, 6 s]
    horizon 20 s
    expect { no collision }
  }
}
search worst {
  in crossing
  individuals 12 of standard
  together
  minimise pet
  over gap in 4 s .. 7 s
  budget 6 evaluations, 3 random first
}
calibrate people {
  in crossing
  repeat 2
  candidates 40 by latin_hypercube
  match rate(gap_accepted) to "people.csv" undefined fails
  folds 2
}
"#;

const OBSERVED: &str =
    "scenario, gap, share, trials, persons, persons_0, persons_1, persons_2, persons_3, persons_4
crossing, 4 s, 0.1484, 128, 32, 25, 2, 0, 3, 2
crossing, 6 s, 0.6719, 128, 32, 8, 2, 0, 4, 18
";

#[test]
fn rounds_of_many_people_are_made_together() {
    let folder = tempfile::tempdir().unwrap();
    let files = vec![folder.path().join("persons.suite")];
    fs::write(&files[0], PEOPLE).unwrap();
    fs::write(folder.path().join("people.csv"), OBSERVED).unwrap();
    let place = Place { folder, files };
    for unit in ["=worst", "=people"] {
        assert_made_together(&place, unit, 5, 2);
    }
}

/// Those of one unit, of which another worker has none in its share.
#[test]
fn a_worker_joins_what_another_one_is_at_and_a_worker_that_ends_is_made_up_for() {
    let place = place();
    for (unit, is_killed) in [("=found", false), ("=found", true), ("=both", false)] {
        let alone = Alone::new(&place, unit);
        let mut first = Slow::new(8);
        // It leaves a journal, as one that is killed does.
        first.most = if is_killed { alone.runs / 2 } else { usize::MAX };
        let (second, first) = (Slow::new(8), &first);
        let joined = thread::scope(|scope| {
            let begun = scope.spawn(|| alone.work("here.1", true, first));
            alone.await_runs(first, 5);
            let joined = alone.work("there.2", false, &second).unwrap();
            assert_eq!(begun.join().unwrap().is_err(), is_killed);
            joined
        });
        let said = format!("{unit}: {} and {} of {}: {joined:?}", first.made(), second.made(), alone.runs);
        assert!(joined.joined > 0 && joined.shared > 0 && joined.made == 0, "{said}");
        assert!(second.made() * 15 > alone.runs && first.made() * 15 > alone.runs, "{said}");
        assert!(first.made() + second.made() < alone.runs * 19 / 10, "{said}");
        alone.assert_same(&said);
    }
}

#[test]
fn nobody_joins_what_nobody_is_at_or_waits_for_it() {
    let place = place();
    let alone = Alone::new(&place, "=good");
    let second = Slow::new(0);
    fs::create_dir_all(place.results()).unwrap();
    assert_eq!(alone.work("there.2", false, &second).unwrap(), Executed::default());
    // A journal that does not grow is left behind by somebody.
    let first = Slow { most: alone.runs / 2, ..Slow::new(0) };
    assert!(alone.work("here.1", true, &first).is_err());
    assert_eq!(alone.work("there.2", false, &second).unwrap(), Executed::default());
    // Who is not to join does not.
    let own = Worker { name: "there.2", mine: &|_, _| false, joins: false };
    let stop = Stop::default();
    let executed = own.execute(&place, &alone.project, &alone.manifest, &second, &stop).unwrap();
    assert_eq!((executed, second.made()), (Executed::default(), 0));
    assert_eq!(alone.journals().len(), 1);
    // Whose share it is goes on from the journal of another name, and removes it.
    assert!(alone.work("elsewhere.3", true, &second).unwrap().resumed > 0);
    assert_eq!(first.made() + second.made(), alone.runs);
    alone.assert_same("resumed");
}

#[test]
fn a_search_point_by_point_is_left_to_one() {
    let place = place();
    let text = fs::read_to_string(&place.files[0]).unwrap();
    let text = text.replace(
        "repeat 20\n  budget 6 evaluations, 3 random first",
        "budget 200 evaluations, 200 random first",
    );
    fs::write(&place.files[0], text).unwrap();
    let alone = Alone::new(&place, "=found");
    // Whoever is faster is a help.
    let (first, second) = (Slow::new(8), Slow::new(24));
    let joined = thread::scope(|scope| {
        let begun = scope.spawn(|| alone.work("here.1", true, &first).unwrap());
        alone.await_runs(&first, 5);
        let joined = alone.work("there.2", false, &second).unwrap();
        begun.join().unwrap();
        joined
    });
    assert_eq!((joined.joined, joined.made), (1, 0));
    assert!(second.made() * 4 < alone.runs * 3, "it goes on with what is no help: {}", second.made());
    alone.assert_same("left");
}

#[test]
fn journals_that_are_damaged_cut_or_of_others_change_no_result() {
    let place = place();
    let alone = Alone::new(&place, "=found");
    let canary = alone.manifest.header().canary.clone();
    let half = || {
        let first = Slow { most: alone.runs / 2, ..Slow::new(0) };
        assert!(alone.work("here.1", true, &first).is_err());
        let [journal] = &alone.journals()[..] else { panic!("a journal is left") };
        (journal.clone(), first.made())
    };
    let rest = |what: &str| {
        let executor = Slow::new(0);
        alone.work("there.2", true, &executor).unwrap();
        alone.assert_same(what);
        alone.begin_anew();
        executor.made()
    };
    let (_, made) = half();
    assert_eq!(rest("as it was left"), alone.runs - made);
    let (journal, made) = half();
    let bytes = fs::read(&journal).unwrap();
    fs::write(&journal, &bytes[..bytes.len() - 7]).unwrap();
    assert_eq!(rest("cut within a line"), alone.runs - made + 1);
    let (journal, _) = half();
    let mut changed = bytes.clone();
    changed[bytes.len() / 2] ^= 1;
    fs::write(&journal, changed).unwrap();
    assert_eq!(rest("damaged"), alone.runs);
    let (journal, _) = half();
    fs::write(&journal, "somebody's poem\n").unwrap();
    assert_eq!(rest("no journal"), alone.runs);
    #[cfg(unix)]
    {
        let (journal, _) = half();
        let elsewhere = place.folder.path().join("elsewhere.jsonl");
        fs::rename(&journal, &elsewhere).unwrap();
        std::os::unix::fs::symlink(&elsewhere, &journal).unwrap();
        assert_eq!(rest("a link"), alone.runs);
        assert!(elsewhere.exists());
    }

    // The same runs in a journal of another machine, which says nothing, though it is whole.
    let held = |worker: &str| alone.journal(worker, &canary).held.runs;
    let (journal, _) = half();
    let runs = held("reader");
    alone.journals().iter().for_each(|path| fs::remove_file(path).unwrap());
    let mut other = alone.journal("other.3", "of another machine").journal;
    runs.iter().for_each(|one| other.record(&one.run, &one.stored));
    drop(other);
    assert!(!journal.exists());
    assert_eq!(rest("of another machine"), alone.runs);
    // Every run has the result of the next one.
    let mut swapped = alone.journal("other.3", &canary).journal;
    let next = runs.iter().skip(1).chain(&runs[..1]);
    runs.iter().zip(next).for_each(|(one, next)| swapped.record(&one.run, &next.stored));
    drop(swapped);
    assert_eq!(rest("with foreign runs"), alone.runs);
    // A run that nobody asks for is in no result.
    let mut unasked = alone.journal("other.3", &canary).journal;
    unasked.record(&RunDigest([7; 32]), &runs[0].stored);
    drop(unasked);
    assert_eq!(rest("with a run of something else"), alone.runs);
}

/// A run, what came of it, and the same with another number.
fn results_of_a_run(place: &Place) -> (StoredRun, StoredRun, StoredRun) {
    let project = place.project();
    let (units, threads, digests) = (units(project.suites()), Threads::new(1), digests());
    let planner = Planner::new(&project, &units, &threads, &digests);
    let trial = units.iter().find_map(|unit| unit.trial()).unwrap();
    let result = |run: usize| planner.job(trial.cases.get(run), Wanted::Outcome).run().result;
    let mut other = result(0);
    other.as_mut().unwrap().outcome.metrics[0] = Some(0.123);
    let stored = |result| StoredRun::of(Wanted::Outcome, &result);
    (stored(result(0)), stored(other), stored(result(1)))
}

fn heard(runs: impl IntoIterator<Item = (RunDigest, StoredRun)>) -> Heard {
    let journal = PathBuf::from("there.jsonl");
    let run = |(run, stored)| HeardRun { run, stored, journal: journal.clone() };
    Heard { runs: runs.into_iter().map(run).collect(), notices: Vec::new() }
}

#[test]
fn machines_that_disagree_on_a_run_are_an_error_and_a_foreign_run_is_not() {
    let place = place();
    let (own, other, foreign) = results_of_a_run(&place);
    let run = RunDigest([3; 32]);
    let folder = place.folder.path().join("disagreeing");
    let subject = JournalSubject { unit: "unit", build: &build(), canary: "c" };
    let begun = |held: Heard| {
        let resumed = UnitJournal::open(&folder, subject, "one");
        let with = SharedWith { results: None, is_joined: false, is_idle: &|| true };
        UnitRuns::new(Some(Resumed { held, ..resumed }), None, Some(with), Stop::default())
    };
    for (said, is_error) in [(&own, false), (&other, true), (&foreign, false)] {
        let all = begun(heard([(run, own.clone()), (run, said.clone())]));
        let is_told = matches!(all.ended(), Some(NotEnded::Disagreed(why)) if why.contains("there.jsonl"));
        assert_eq!((is_told, all.stop().is_requested()), (is_error, is_error));
        // And where it is heard while it is made here.
        let all = begun(heard([(run, said.clone())]));
        all.keep(run, own.clone());
        assert_eq!(all.ended().is_some(), is_error);
        assert_eq!(all.known(&run).unwrap().against(&own), None, "what was made here is what counts");
        fs::remove_dir_all(&folder).unwrap();
    }
    // Where another one has written the results, this one ends.
    let results = folder.join("results.jsonl");
    let with = SharedWith { results: Some(results.clone()), is_joined: false, is_idle: &|| true };
    let resumed = UnitJournal::open(&folder, subject, "one");
    let all = UnitRuns::new(Some(resumed), None, Some(with), Stop::default());
    let look = || {
        thread::sleep(Duration::from_millis(5));
        all.sharing(Duration::ZERO, true)
    };
    assert_eq!(look(), Sharing { may_wait: true, ..Sharing::ALONE });
    assert!(!all.stop().is_requested());
    fs::write(&results, "there").unwrap();
    look();
    assert_eq!(all.ended(), Some(NotEnded::Elsewhere));
    assert!(all.stop().is_requested());
    // The first look is due at once.
    let with = SharedWith { results: Some(results), is_joined: false, is_idle: &|| true };
    let resumed = UnitJournal::open(&folder, subject, "one");
    let all = UnitRuns::new(Some(resumed), None, Some(with), Stop::default());
    all.sharing(Duration::ZERO, false);
    assert_eq!(all.ended(), Some(NotEnded::Elsewhere));
}
