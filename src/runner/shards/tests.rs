//! Many machines come to what one comes to, or to nothing at all.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use tempfile::TempDir;

use super::*;
use crate::experiment::{EarlierResults, Silent};
use crate::project::Project;
use crate::run::{AbsentRuns, Executor, FromResults, Round, RunDigests, Shuffled, Stop, Threads, VerifyRuns};
use crate::session::{Runner, Selection, Session, Work, measured_trials, units};
use files::Disk;
use models::standard;
use results::{Results, Unheard, UnitReport};

mod sharing;

/// Trials of fixed and of open length, all of whose runs a gate compares.
const GATED: &str = r#"suite everything {
  seed 20261122
  scenario walker {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller carla_behavior; speed 30 km/h }
    pedestrian walker { model carla_walker; start 2 m from kerb; appears when time_to_arrival(av) = tta }
    vary tta in [3 s, 4 s, 5 s]
    repeat 12
    expect { max_deceleration <= 2 m/s^2; no collision }
  }
  OPEN
  gate braking { baseline "BASE"; no metric worse by more than 5 % with 95 % confidence }
}
"#;

/// What builds on trials and on each other.
const BLOCKS: &str = r#"search found {
  in walker
  minimise pet
  over tta in 3 s .. 9 s
  repeat 2
  budget 6 evaluations, 3 random first
}
tune good {
  on found
  over av.controller.braking_distance in 4 m .. 12 m
  minimise mean(time_lost)
  subject to max_deceleration <= 3 m/s^2
  stop early
  budget 5 evaluations, 3 random first
  compare with default
}
evaluate both {
  on walker
  with default, good
}
statement slower {
  claim mean(pet) of walker > 0 s
}
"#;

/// A trial that decides itself how many runs it is.
const OPEN: &str = r#"scenario open {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller carla_behavior; speed 30 km/h }
    pedestrian walker { model carla_walker; start 2 m from kerb; appears when time_to_arrival(av) = tta }
    vary tta in [3 s, 12 s]
    runs 20 .. 100
    expect { rate(pet > 0.1 s) >= 50 % with 95 % confidence; rate(pet > 2 s) <= 50 % with 95 % confidence }
  }
"#;

/// Such a trial in a suite without gates, and an estimate.
const UNGATED: &str = r#"suite open {
  seed 7
  OPEN
  scenario walk {
    road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
    vehicle av { controller constant_speed; size 4 m x 2 m; speed 10 m/s; start far before crossing }
    pedestrian walker { model scripted { speed: 1 m/s }; radius 0.3 m; start 3 m from kerb; appears at 0 s }
    draw far from normal(80.5 m, 4 m)
    horizon 15 s
    end on collision
    repeat 5
    expect { no collision }
  }
}
estimate rarely {
  of walk
  event collision
  score pet
  budget 1000 runs, by importance
}
"#;

struct Place {
    folder: TempDir,
    files: Vec<PathBuf>,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let base = folder.path().join("base.json");
        let gated = GATED.replace("OPEN", OPEN).replace("BASE", &base.display().to_string());
        let files = ["everything.suite", "open.suite"].map(|name| folder.path().join(name)).to_vec();
        fs::write(&files[0], gated + BLOCKS).unwrap();
        fs::write(&files[1], UNGATED.replace("OPEN", OPEN)).unwrap();
        let place = Self { folder, files };
        place.record(&base);
        place
    }

    /// The baseline of the gate.
    fn record(&self, base: &Path) {
        let (project, threads) = (self.project(), Threads::new(2));
        let runner = Runner::new(project.suites(), &threads, &standard());
        let units = units(project.suites());
        let reports: Vec<_> = units
            .iter()
            .filter(|unit| unit.suite == 0 && matches!(unit.work, Work::Trial(_)))
            .map(|unit| match runner.run_unit(&unit, &EarlierResults::default(), &Silent) {
                UnitReport::Trial(report) => report,
                _ => panic!("it is a trial"),
            })
            .collect();
        let measured = measured_trials(&runner, 0, &reports.iter().collect::<Vec<_>>()).unwrap();
        fs::write(base, measured.text()).unwrap();
    }

    fn project(&self) -> Project {
        Project::open_all(&self.files, &crate::project::ProjectOptions::default(), &standard(), &Disk)
            .unwrap_or_else(|error| panic!("{error}"))
    }

    fn manifest(&self) -> PathBuf {
        self.folder.path().join("manifest.jsonl")
    }

    fn results(&self) -> PathBuf {
        self.folder.path().join("results")
    }
}

fn build() -> Build {
    Build { digest: "abc".into(), target: "here".into(), version: "0".into() }
}

fn digests() -> RunDigests {
    RunDigests::new(&build().identity(), Vec::new())
}

fn plan(place: &Place, project: &Project, chosen: impl Fn(&str) -> bool) -> ManifestReader {
    let (units, threads, digests) = (units(project.suites()), Threads::new(2), digests());
    let planner = Planner::new(project, &units, &threads, &digests);
    let marks: Vec<bool> = units.keys().map(|key| chosen(&key)).collect();
    let marks = crate::session::with_needs(&units, marks);
    let header = ManifestHeader::new(build(), canary(&standard()).unwrap());
    let written = write_manifest(&place.manifest(), header, planner.plan(&marks), &units).unwrap();
    let manifest = ManifestReader::open(&place.manifest()).unwrap();
    let batches: Vec<UnitBatch> = manifest.batches().unwrap().map(Result::unwrap).collect();
    assert_eq!(written.batches, batches.len());
    assert_eq!(written.units, batches.iter().map(|batch| batch.units.len()).sum::<usize>());
    manifest
}

fn execute(
    place: &Place,
    project: &Project,
    manifest: &ManifestReader,
    executor: &dyn Executor,
    mine: &(dyn Fn(usize, &str) -> bool + Sync),
) -> Result<Executed, ShardError> {
    execute_until(place, project, manifest, executor, mine, &Stop::default())
}

fn execute_until(
    place: &Place,
    project: &Project,
    manifest: &ManifestReader,
    executor: &dyn Executor,
    mine: &(dyn Fn(usize, &str) -> bool + Sync),
    stop: &Stop,
) -> Result<Executed, ShardError> {
    let worker = Worker { name: "here.1", mine, joins: false };
    worker.execute(place, project, manifest, executor, stop)
}

/// One of those at a manifest.
struct Worker<'w> {
    name: &'w str,
    mine: &'w (dyn Fn(usize, &str) -> bool + Sync),
    joins: bool,
}

impl Worker<'_> {
    fn execute(
        &self,
        place: &Place,
        project: &Project,
        manifest: &ManifestReader,
        executor: &dyn Executor,
        stop: &Stop,
    ) -> Result<Executed, ShardError> {
        let (units, digests) = (units(project.suites()), digests());
        let planner = Planner::new(project, &units, executor, &digests);
        let canary = manifest.header().canary.clone();
        let execution = Execution {
            planner: &planner,
            manifest,
            executor,
            verify: VerifyRuns::Some,
            folder: &place.results(),
            mine: self.mine,
            reuse: true,
            canary: &canary,
            worker: self.name,
            joins: &|| self.joins,
            stop,
        };
        execution.run(&|_, _| ())
    }
}

/// An executor for what must not be made.
struct Nobody(Threads);

impl Executor for Nobody {
    fn run(&self, round: &mut dyn Round) {
        if let Some(job) = round.next() {
            panic!("{} is asked for", job.case.key);
        }
    }

    fn parallelism(&self) -> usize {
        3
    }

    fn host(&self, work: &mut (dyn FnMut() + Send)) {
        self.0.host(work);
    }
}

fn merge(place: &Place, project: &Project, manifest: &ManifestReader) -> Result<String, String> {
    let results = ResultFiles::open(&place.results(), manifest, "exec").map_err(|error| error.to_string())?;
    let (digests, nobody) = (digests(), Nobody(Threads::new(1)));
    let chosen = chosen(manifest, &units(project.suites())).map_err(|error| error.to_string())?;
    let merged = |ahead: usize| {
        let stop = Stop::default();
        let executor = FromResults::new(&nobody, &digests, &results, AbsentRuns::Refused, &stop);
        let executor = executor.reading_ahead(ahead);
        let merged = session(project, &executor, Selection::marked(chosen.clone()), &stop);
        executor.troubles().into_iter().next().map_or(Ok(merged), Err)
    };
    let (one_by_one, ahead) = (merged(0), merged(3));
    assert_eq!(one_by_one, ahead, "whoever reads ahead asks for no more");
    one_by_one
}

fn session(project: &Project, executor: &dyn Executor, selection: Selection, stop: &Stop) -> String {
    let session = Session::new(project).executor(executor).courses(false).stopped_by(stop);
    timeless(&session.run(&selection, &mut Unheard).unwrap())
}

fn timeless(results: &Results) -> String {
    let mut json = Vec::new();
    report::write_json(results, &mut json).unwrap();
    let mut value = serde_json::from_slice(&json).unwrap();
    without_times(&mut value);
    value.to_string()
}

fn without_times(value: &mut serde_json::Value) {
    match value {
        serde_json::Value::Object(members) => {
            let is_time = |name: &str| {
                matches!(name, "wall_time" | "wall_time_s" | "started" | "duration_s" | "started_s")
            };
            members.retain(|name, _| !is_time(name));
            members.values_mut().for_each(without_times);
        }
        serde_json::Value::Array(items) => items.iter_mut().for_each(without_times),
        _ => {}
    }
}

/// The files of results by their names.
fn files(place: &Place) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for folder in fs::read_dir(place.results()).unwrap().map(Result::unwrap) {
        if folder.file_name().len() != 2 {
            continue;
        }
        for file in fs::read_dir(folder.path()).unwrap() {
            let path = file.unwrap().path();
            all.insert(path.strip_prefix(place.results()).unwrap().to_path_buf(), fs::read(&path).unwrap());
        }
    }
    all
}

#[test]
fn many_machines_come_to_what_one_comes_to() {
    let place = Place::new();
    let project = place.project();
    let local = session(&project, &Threads::new(2), Selection::all(), &Stop::default());
    for word in ["everything/walker/tta=3s", "rarely", "good", "gate", "slower"] {
        assert!(local.contains(word), "{word}");
    }
    let manifest = plan(&place, &project, |_| true);
    let mut known: Option<BTreeMap<PathBuf, Vec<u8>>> = None;
    // Of nine shares, two have nothing and four have batches that do not stand one after the other.
    for shards in [1, 9] {
        let _ = fs::remove_dir_all(place.results());
        // The last share first, each in an order of its own.
        for share in (0..shards).rev() {
            let (shuffled, threads) = (Shuffled::seeded(share as u64), Threads::new(3));
            let executor: &dyn Executor = if shards == 1 { &threads } else { &shuffled };
            let batches = shards.min(7);
            execute(&place, &project, &manifest, executor, &|number, _| number % batches == share).unwrap();
        }
        let made = files(&place);
        assert_eq!(*known.get_or_insert_with(|| made.clone()), made, "{shards} shares are other bytes");
        assert_eq!(merge(&place, &project, &manifest).unwrap(), local, "{shards} shares");
    }
}

#[test]
fn what_is_there_is_not_made_again_and_what_is_damaged_is() {
    let place = Place::new();
    let project = place.project();
    let manifest = plan(&place, &project, |key| key.contains("walker/"));
    let all = |_: usize, _: &str| true;
    let made = execute(&place, &project, &manifest, &Threads::new(2), &all).unwrap();
    assert!(made.made > 0 && made.runs >= 36 && made.skipped == 0, "{made:?}");
    let again = execute(&place, &project, &manifest, &Threads::new(2), &all).unwrap();
    assert_eq!((again.made, again.skipped), (0, made.made));
    let before = files(&place);
    let (name, bytes) = before.iter().next().unwrap();
    let path = place.results().join(name);
    let other = String::from_utf8(bytes.clone()).unwrap().replacen("\"run\":\"", "\"run\":\"0", 1);
    for damaged in [&bytes[..bytes.len() - 1], &bytes[..bytes.len() / 2], b"", other.as_bytes()] {
        fs::write(&path, damaged).unwrap();
        let refused = merge(&place, &project, &manifest).unwrap_err();
        assert!(refused.contains(&path.display().to_string()), "{refused}");
        let repaired = execute(&place, &project, &manifest, &Threads::new(2), &all).unwrap();
        assert_eq!(repaired.made, 1);
        assert_eq!(files(&place), before);
    }
    merge(&place, &project, &manifest).unwrap();
}

#[test]
fn what_is_missing_foreign_or_of_others_is_refused_by_name() {
    let place = Place::new();
    let project = place.project();
    let manifest = plan(&place, &project, |key| key.contains("walker/"));
    let all = |_: usize, _: &str| true;
    execute(&place, &project, &manifest, &Threads::new(2), &all).unwrap();
    let before = files(&place);
    let (name, bytes) = before.iter().next().unwrap();
    let path = place.results().join(name);
    let refused = || merge(&place, &project, &manifest).unwrap_err();

    fs::remove_file(&path).unwrap();
    let missing = refused();
    assert!(missing.contains("everything/walker/tta=") && missing.contains("exec makes them"), "{missing}");
    fs::write(&path, bytes).unwrap();

    let foreign = path.parent().unwrap().join(format!("{}.jsonl", "0".repeat(64)));
    fs::write(&foreign, bytes).unwrap();
    assert!(refused().contains(&foreign.display().to_string()));
    fs::remove_file(&foreign).unwrap();
    // What a worker that was killed leaves half written is nobody's result.
    fs::write(path.parent().unwrap().join(".half.tmp"), "half").unwrap();
    merge(&place, &project, &manifest).unwrap();

    let resealed = |from: &str, to: &str| {
        let text = String::from_utf8(bytes.clone()).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let body: String = lines[..lines.len() - 1].iter().map(|line| format!("{line}\n")).collect();
        assert!(body.contains(from));
        let body = body.replacen(from, to, 1);
        fs::write(&path, format!("{body}{{\"sha256\":\"{}\"}}\n", scenario::sha256(body.as_bytes())))
            .unwrap();
        refused()
    };
    let said = resealed("\"digest\":\"abc\"", "\"digest\":\"abd\"");
    assert!(said.contains("it is of scenario-runner 0 for here (SHA-256 abd"), "{said}");
    let said = resealed("\"canary\":\"", "\"canary\":\"0");
    assert!(said.contains("canary") && said.contains(&path.display().to_string()), "{said}");
    let said = resealed("\"version\":1", "\"version\":2");
    assert!(said.contains("version 2"), "{said}");
    let said = resealed("\"unit\":\"", "\"unit\":\"0");
    assert!(said.contains("should be"), "{said}");
    // A worker with another canary or build does not even begin, and does not replace what is there.
    let said = execute(&place, &project, &manifest, &Threads::new(1), &all);
    assert_eq!(said.unwrap().made, 1, "what means nothing is made again");
    resealed("\"canary\":\"", "\"canary\":\"0");
    assert!(matches!(
        execute(&place, &project, &manifest, &Threads::new(1), &all),
        Err(ShardError::OtherCanary { .. })
    ));
}

#[test]
fn other_results_of_a_run_change_no_verdict_silently() {
    let place = Place::new();
    let project = place.project();
    let manifest = plan(&place, &project, |key| key.contains("walker/"));
    execute(&place, &project, &manifest, &Threads::new(2), &|_, _| true).unwrap();
    // A scenario that has changed since asks for runs of which there is no result.
    let text = fs::read_to_string(&place.files[0]).unwrap();
    fs::write(&place.files[0], text.replace("lane_width 4 m", "lane_width 3.9 m")).unwrap();
    let changed = place.project();
    let said = merge(&place, &changed, &manifest).unwrap_err();
    assert!(said.contains("there is no result of everything/walker/tta=3s"), "{said}");
    let said = execute(&place, &changed, &manifest, &Threads::new(2), &|_, _| true).map(|_| ());
    // All batches are there: nothing is made of them.
    assert!(said.is_ok());
    fs::remove_dir_all(place.results()).unwrap();
    let said = execute(&place, &changed, &manifest, &Threads::new(2), &|_, _| true).unwrap_err();
    assert!(said.to_string().contains("its files have changed since"), "{said}");
}

#[test]
fn a_manifest_is_the_same_each_time_and_whole_or_refused() {
    let place = Place::new();
    let project = place.project();
    plan(&place, &project, |_| true);
    let first = fs::read(place.manifest()).unwrap();
    let manifest = plan(&place, &project, |_| true);
    assert_eq!(fs::read(place.manifest()).unwrap(), first);
    assert!(manifest.check_build(&build()).is_ok());
    let other = Build { target: "there".into(), ..build() };
    let said = manifest.check_build(&other).unwrap_err().to_string();
    assert!(
        said.contains("manifest.jsonl: it is of scenario-runner 0 for here") && said.contains("there"),
        "{said}"
    );
    let ids: Vec<String> =
        manifest.batches().unwrap().flat_map(|batch| batch.unwrap().units).map(|unit| unit.id).collect();
    assert!(ids.is_sorted() && ids.len() == manifest.header().units);
    let text = String::from_utf8(first.clone()).unwrap();
    let other = text.replacen("\"version\":1", "\"version\":9", 1);
    let lost = text.lines().enumerate().filter(|(number, _)| *number != 2);
    let lost: String = lost.map(|(_, line)| format!("{line}\n")).collect();
    for (changed, why) in [
        (&first[..first.len() / 2], "it is cut off"),
        (&first[..first.len() - 1], "it is cut off"),
        (other.as_bytes(), "version 9"),
        (lost.as_bytes(), "damaged or was changed"),
        (b"{}\n", "no manifest"),
        (b"", "cut off"),
    ] {
        fs::write(place.manifest(), changed).unwrap();
        let said = ManifestReader::open(&place.manifest()).unwrap_err().to_string();
        assert!(said.contains(why) && said.contains("manifest.jsonl"), "{said}");
    }
    assert!(ManifestReader::open(Path::new("/nowhere/manifest.jsonl")).is_err());
}

#[test]
fn two_workers_in_one_folder_leave_one_result_each() {
    let place = Place::new();
    let project = place.project();
    let manifest = plan(&place, &project, |key| key.starts_with("everything/"));
    let failed = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                let done = execute(&place, &project, &manifest, &Threads::new(2), &|_, _| true);
                failed.fetch_add(usize::from(done.is_err()), Ordering::Relaxed);
            });
        }
    });
    assert_eq!(failed.into_inner(), 0);
    merge(&place, &project, &manifest).unwrap();
}

/// The same result for every run, as somebody might put it there.
struct OneForAll<'r> {
    results: &'r ResultFiles,
    first: std::sync::OnceLock<crate::run::StoredRun>,
}

impl crate::run::RunResults for OneForAll<'_> {
    fn find(&self, run: &crate::run::RunDigest) -> Result<Option<crate::run::StoredRun>, String> {
        let own = self.results.find(run)?;
        Ok(own.map(|own| self.first.get_or_init(|| own).clone()))
    }

    fn keep(&self, _: crate::run::RunDigest, _: crate::run::StoredRun) {}
}

#[test]
fn a_result_of_another_run_is_not_taken() {
    let place = Place::new();
    let project = place.project();
    let manifest = plan(&place, &project, |key| key.starts_with("everything/walker/"));
    execute(&place, &project, &manifest, &Threads::new(2), &|_, _| true).unwrap();
    let results = ResultFiles::open(&place.results(), &manifest, "exec").unwrap();
    let (stop, digests, nobody) = (Stop::default(), digests(), Nobody(Threads::new(1)));
    let swapped = OneForAll { results: &results, first: std::sync::OnceLock::new() };
    let executor = FromResults::new(&nobody, &digests, &swapped, AbsentRuns::Refused, &stop);
    let chosen = chosen(&manifest, &units(project.suites())).unwrap();
    session(&project, &executor, Selection::marked(chosen), &stop);
    let troubles = executor.troubles();
    assert!(troubles.iter().any(|one| one.contains("is of another run")), "{troubles:?}");
}

/// Counts the runs that it makes, and is stopped after some.
struct Counting {
    threads: Threads,
    made: AtomicUsize,
    most: usize,
    stop: Stop,
}

struct CountedRound<'r> {
    round: &'r mut dyn Round,
    of: &'r Counting,
}

impl Round for CountedRound<'_> {
    fn next(&mut self) -> Option<crate::run::Job> {
        let job = self.round.next()?;
        if self.of.made.fetch_add(1, Ordering::Relaxed) + 1 >= self.of.most {
            self.of.stop.request();
        }
        Some(job)
    }

    fn done(&mut self, done: crate::run::Done) {
        self.round.done(done);
    }

    fn is_wanted(&mut self, place: crate::run::JobPlace) -> bool {
        self.round.is_wanted(place)
    }
}

impl Counting {
    fn new(most: usize) -> Self {
        Self { threads: Threads::new(1), made: AtomicUsize::new(0), most, stop: Stop::default() }
    }

    /// Makes all of a manifest that is not there; how many runs it made.
    fn execute(&self, place: &Place, project: &Project, manifest: &ManifestReader) -> usize {
        let done = execute_until(place, project, manifest, self, &|_, _| true, &self.stop);
        assert_eq!(done.is_err(), self.stop.is_requested(), "{done:?}");
        self.made.load(Ordering::Relaxed)
    }
}

impl Executor for Counting {
    fn run(&self, round: &mut dyn Round) {
        self.threads.run(&mut CountedRound { round, of: self });
    }

    fn parallelism(&self) -> usize {
        1
    }

    fn host(&self, work: &mut (dyn FnMut() + Send)) {
        self.threads.host(work);
    }
}

/// Of each kind that decides itself which runs it makes.
#[test]
fn what_was_made_of_a_unit_is_not_made_again_and_what_is_damaged_is() {
    for unit in ["found", "everything/open/tta=12s", "rarely"] {
        let place = Place::new();
        // Without the gate, which has all runs made.
        let text = fs::read_to_string(&place.files[0]).unwrap();
        let gate = text.find("  gate braking").unwrap();
        let after = gate + text[gate..].find('\n').unwrap();
        fs::write(&place.files[0], format!("{}{}", &text[..gate], &text[after..])).unwrap();
        let project = place.project();
        let manifest = plan(&place, &project, |key| key.ends_with(unit));
        let all = Counting::new(usize::MAX).execute(&place, &project, &manifest);
        let made = files(&place);
        let half = all / 2;
        let journals = || -> Vec<PathBuf> {
            let found = fs::read_dir(place.results().join("journal")).unwrap();
            found.map(|file| file.unwrap().path()).collect()
        };
        assert!(half > 2 && journals().is_empty(), "{unit}: {all}");
        for damage in [false, true] {
            fs::remove_dir_all(place.results()).unwrap();
            let before = Counting::new(half).execute(&place, &project, &manifest);
            let [journal] = &journals()[..] else { panic!("{unit}: a journal is left") };
            assert!(files(&place).is_empty() && before >= half);
            if damage {
                let mut bytes = fs::read(journal).unwrap();
                let middle = bytes.len() / 2;
                bytes[middle] ^= 1;
                fs::write(journal, bytes).unwrap();
            }
            let rest = Counting::new(usize::MAX).execute(&place, &project, &manifest);
            assert_eq!(before + rest, if damage { before + all } else { all }, "{unit}");
            assert_eq!(files(&place), made, "{unit}");
            assert!(journals().is_empty());
        }
    }
}

#[test]
fn what_others_have_made_is_built_on() {
    let place = Place::new();
    let project = place.project();
    let count = |chosen: &str| {
        let manifest = plan(&place, &project, |key| key.ends_with(chosen));
        Counting::new(usize::MAX).execute(&place, &project, &manifest)
    };
    let search = count("found");
    fs::remove_dir_all(place.results()).unwrap();
    // The tune, with the search before it.
    let both = count("good");
    let made = files(&place);
    let manifest = plan(&place, &project, |key| key.ends_with("good"));
    let batches: Vec<UnitBatch> = manifest.batches().unwrap().map(Result::unwrap).collect();
    let tune = batches.iter().find(|batch| batch.units[0].name.ends_with("good")).unwrap();
    fs::remove_file(tune.path(&place.results())).unwrap();
    let again = count("good");
    assert!(search > 0 && again > 0);
    assert_eq!(again + search, both);
    assert_eq!(files(&place), made);
    // Where the search is not there, it is made for the tune alone, which comes to the same.
    assert_eq!(batches.len(), 2);
    for batch in &batches {
        fs::remove_dir_all(place.results()).unwrap();
        execute(&place, &project, &manifest, &Threads::new(2), &|_, id| id == batch.id).unwrap();
        let alone = files(&place);
        assert!(alone.len() == 1 && alone.iter().all(|(name, bytes)| made[name] == *bytes));
    }
}
