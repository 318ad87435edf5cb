//! Gates that are judged while runs come in: how many runs they take, and that nothing else depends on it.

use std::sync::atomic::{AtomicUsize, Ordering};

use files::Memory;
use models::standard;
use results::{CutBy, Event, Overall, Reporter, Results, Standing, Stopping, SuiteReport, Unheard, Verdict};
use runner::project::{Project, ProjectOptions};
use runner::run::{Executor, Job, Round, Shuffled, Threads};
use runner::session::{OnDemand, Runner, Selection, Session, measured_trials, units};

fn suite(braking_distance: &str, more: &str, gate: &str) -> String {
    format!(
        "suite late {{
  scenario walker {{
    road {{ lane_width 4 m; speed_limit 30 km/h; crossing zebra }}
    vehicle av {{
      controller carla_behavior {{ braking_distance: {braking_distance} }}
      speed 30 km/h
    }}
    pedestrian walker {{
      model carla_walker
      start 4 m from lane centre, 2 m from kerb
      appears when time_to_arrival(av) = tta
    }}
    vary tta in [3 s, 4 s, 5 s]
    {more}
  }}
  {gate}
}}
"
    )
}

/// As many runs as a gate needs to see that braking later is worse, before it has all of them.
const PLENTY: &str = "repeat 60\n    expect { max_deceleration <= 100 m/s^2 }";

/// Fewer runs, which a gate judges in a fraction of the time.
const FEW: &str = "repeat 20\n    expect { max_deceleration <= 100 m/s^2 }";

const GATE: &str = "gate braking { baseline \"base.json\"; sequential; primary collision not worse; no metric worse by more than 5 % }";

/// Makes the runs of others, and counts those of trials.
struct Counting<'c, E> {
    executor: E,
    runs: &'c AtomicUsize,
}

struct Counted<'r> {
    round: &'r mut dyn Round,
    runs: &'r AtomicUsize,
}

impl Round for Counted<'_> {
    fn next(&mut self) -> Option<Job> {
        let next = self.round.next()?;
        self.runs.fetch_add(1, Ordering::Relaxed);
        Some(next)
    }

    fn done(&mut self, done: runner::run::Done) {
        self.round.done(done);
    }
}

impl<E: Executor> Executor for Counting<'_, E> {
    fn run(&self, round: &mut dyn Round) {
        self.executor.run(&mut Counted { round, runs: self.runs });
    }

    fn parallelism(&self) -> usize {
        self.executor.parallelism()
    }
}

/// Counts what is told of runs.
#[derive(Default)]
struct Told {
    runs: usize,
    stopping: Vec<Stopping>,
}

impl Reporter for Told {
    fn tell(&mut self, event: &Event) {
        match event {
            Event::RunDone { .. } => self.runs += 1,
            Event::Stopping(stopping) => self.stopping.push(*stopping),
            _ => {}
        }
    }
}

/// The baseline of a suite, as text.
fn recorded(text: &str) -> String {
    let files = Memory::default().with("late.suite", text);
    let project = Project::open("late.suite", &standard(), &files).unwrap_or_else(|error| panic!("{error}"));
    let results = Session::new(&project).courses(false).run(&Selection::all(), &mut Unheard).unwrap();
    let threads = Threads::all();
    let runner = Runner::new(project.suites(), &threads, &standard());
    let trials: Vec<_> = results.suites[0].trials.iter().collect();
    measured_trials(&runner, 0, &trials).unwrap().text()
}

fn files(text: &str, base: &str) -> Memory {
    Memory::default().with("late.suite", text).with("base.json", base)
}

/// What a session comes to, how many runs it made, and what it told.
fn run(files: &Memory, executor: impl Executor) -> (Results, usize, Told) {
    let project = Project::open("late.suite", &standard(), files).unwrap_or_else(|error| panic!("{error}"));
    let made = AtomicUsize::new(0);
    let mut told = Told::default();
    let session = Session::new(&project).executor(Counting { executor, runs: &made }).courses(false);
    let results = session.run(&Selection::all(), &mut told).unwrap();
    drop(session);
    (results, made.load(Ordering::Relaxed), told)
}

fn gates(results: &Results) -> String {
    serde_json::to_string(&results.suites[0].gates).unwrap()
}

fn trials(report: &SuiteReport) -> Vec<(String, Vec<u64>, Option<Verdict>)> {
    let of_trial = |trial: &results::TrialReport| {
        let prints = trial.outcomes.iter().map(|one| one.fingerprint).collect();
        (trial.trial.key.to_string(), prints, trial.verdict())
    };
    report.trials.iter().map(of_trial).collect()
}

#[test]
fn a_gate_that_fails_ends_its_suite_and_executors_change_nothing() {
    let base = recorded(&suite("5 m", PLENTY, ""));
    let worse = files(&suite("2.5 m", PLENTY, GATE), &base);
    let (first, runs, told) = run(&worse, Threads::new(1));
    assert_eq!(first.overall(), Overall::Regressed);
    let verdict = match &first.suites[0].gates[0].state {
        results::GateState::Judged(verdict) => verdict,
        other => panic!("{other:?}"),
    };
    assert_eq!(verdict.verdict, Verdict::Failed);
    assert_eq!(verdict.looks.unwrap().ended_it_of, Some(180));
    assert_eq!((runs, told.runs), (verdict.runs, verdict.runs));
    assert!(runs <= 90, "{runs}");
    assert_eq!(told.stopping, [Stopping::GateFailed]);
    for trial in &first.suites[0].trials {
        assert_eq!(trial.standing(), Standing::NotFinished(CutBy::GateFailed));
        assert_eq!(trial.made(), trial.outcomes.len());
    }
    let made: usize = first.suites[0].trials.iter().map(|trial| trial.made()).sum();
    assert_eq!((made, first.suites[0].summary().runs()), (runs, runs));
    for threads in [2, 3] {
        let (again, ..) = run(&worse, Threads::new(threads));
        assert_eq!(gates(&again), gates(&first));
        assert_eq!(trials(&again.suites[0]), trials(&first.suites[0]));
    }
    for seed in [1, 2] {
        assert_eq!(gates(&run(&worse, Shuffled::seeded(seed)).0), gates(&first));
    }
    // Who has all runs comes to the same.
    let project = Project::open("late.suite", &standard(), &worse).unwrap_or_else(|error| panic!("{error}"));
    let threads = Threads::all();
    let on_demand = OnDemand::new(&project, &threads);
    let gate = &project.suites()[0].suite.gates[0];
    assert_eq!(serde_json::to_string(&[on_demand.gate(0, gate)]).unwrap(), gates(&first));
}

#[test]
fn a_gate_that_does_not_fail_changes_nothing_and_takes_no_run_twice() {
    // A rule about every metric takes most of the time.
    let gate = GATE.replace("no metric worse", "max_deceleration not worse");
    // Trials that are decided early are run to their end for the gate.
    for more in [FEW, "runs 5 .. 20\n    expect { rate(collision) <= 90 % with 95 % confidence }"] {
        let base = recorded(&suite("5 m", more, ""));
        let (plain, plain_runs, _) =
            run(&files(&suite("5 m", more, &gate.replace("sequential; ", "")), &base), Threads::new(2));
        let (looked, runs, told) = run(&files(&suite("5 m", more, &gate), &base), Threads::new(2));
        assert_eq!(trials(&looked.suites[0]), trials(&plain.suites[0]));
        assert_eq!(looked.overall(), plain.overall());
        assert!(runs == 60 && plain_runs >= 60, "{runs} {plain_runs}");
        assert!(told.stopping.is_empty());
        let made: usize = looked.suites[0].trials.iter().map(|trial| trial.outcomes.len()).sum();
        assert!(told.runs >= made && told.runs <= 60, "{} of {made}", told.runs);
    }
}

/// What nobody can compare with, or nobody wants to know, is not looked at.
#[test]
fn without_a_baseline_or_for_a_part_nothing_is_looked_at() {
    let worse = suite("2.5 m", PLENTY, GATE);
    let (results, runs, _) = run(&Memory::default().with("late.suite", worse.as_str()), Threads::new(2));
    assert_eq!((results.overall(), runs), (Overall::NotComparable, 180));
    let base = recorded(&suite("5 m", PLENTY, ""));
    let files = files(&worse, &base);
    let project = Project::open("late.suite", &standard(), &files).unwrap_or_else(|error| panic!("{error}"));
    let session = Session::new(&project).courses(false);
    let part = session.run(&Selection::containing("tta=3s"), &mut Unheard).unwrap();
    assert_eq!(part.overall(), Overall::Inconclusive);
    // A time limit is measured while a trial is run.
    let limited = worse.replacen("suite late {", "suite late {\n  time_limit 600 s per case", 1);
    let (results, runs, told) = run(&self::files(&limited, &base), Threads::new(2));
    assert_eq!((results.overall(), runs), (Overall::Regressed, 180));
    assert!(told.stopping.is_empty());
}

/// A trial that has all its runs by then has failed by itself, which goes before what got worse.
#[test]
fn what_has_all_its_runs_is_judged() {
    let base = recorded(&suite("5 m", PLENTY, ""));
    let alone = "scenario alone {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller constant_speed; speed 30 km/h; start 40 m before crossing }
    pedestrian walker { model scripted; start 2 m from kerb; appears at 20 s }
    expect { max_deceleration > 1 m/s^2 }
  }";
    let both = format!("{alone}\n  {GATE}");
    let base_of_both = recorded(&suite("5 m", PLENTY, alone));
    let (results, ..) = run(&files(&suite("2.5 m", PLENTY, &both), &base_of_both), Threads::new(2));
    let standing: Vec<_> = results.suites[0].trials.iter().map(|trial| trial.verdict()).collect();
    assert_eq!(standing, [None, None, None, Some(Verdict::Failed)]);
    assert_eq!(results.overall(), Overall::Failed);
    // Who stops at the first failure begins nothing more, in other suites either.
    let free = suite("5 m", "repeat 4\n    expect { max_deceleration <= 100 m/s^2 }", "");
    let free = free.replace("suite late", "suite free");
    let files = files(&suite("2.5 m", PLENTY, GATE), &base).with("free.suite", free.as_str());
    let both = ["late.suite", "free.suite"];
    let project = Project::open_all(both, &ProjectOptions::default(), &standard(), &files);
    let project = project.unwrap_or_else(|error| panic!("{error}"));
    let first = Selection::all().until_failures(Some(1));
    let results = Session::new(&project).courses(false).run(&first, &mut Unheard).unwrap();
    let cut = Standing::NotFinished(CutBy::GateFailed);
    assert!(results.suites[0].trials.iter().all(|trial| trial.standing() == cut));
    assert!(results.suites[1].trials.iter().all(|trial| trial.skipped()));
    assert_eq!(results.overall(), Overall::Regressed);
}

/// The horizon ends every run before anybody can be hit: that nobody was is no pass.
#[test]
fn runs_that_the_horizon_ends_before_the_crash_pass_no_gate() {
    let cut = |at: &str, distance: &str, gate: &str| {
        let rest = format!("horizon {at}\n    repeat 10\n    expect {{ max_deceleration <= 100 m/s^2 }}");
        suite(distance, &rest, gate)
    };
    let short = |distance: &str, gate: &str| cut("2.4 s", distance, gate);
    let gate = "gate braking { baseline \"base.json\"; collision not worse by more than 50 % }";
    let sequential = gate.replace("base.json\";", "base.json\"; sequential;");
    // On a collision course, and before anybody has appeared.
    for (gate, at) in [(gate, "2.4 s"), (&sequential, "2.4 s"), (gate, "0.5 s"), (&sequential, "0.5 s")] {
        let base = recorded(&cut(at, "5 m", ""));
        let (results, ..) = run(&files(&cut(at, "1 m", gate), &base), Threads::new(2));
        let results::GateState::Judged(verdict) = &results.suites[0].gates[0].state else { panic!() };
        assert_eq!((verdict.verdict, results.overall()), (Verdict::Inconclusive, Overall::Inconclusive));
        assert!(verdict.cut_off > 5, "{}", verdict.cut_off);
    }
    // A baseline says so, too, and is read again.
    let base = recorded(&short("1 m", ""));
    assert!(base.contains("\"cut_off\": "), "{base}");
}

/// What needs a trial of a suite that ended is not run; other suites and searches are.
#[test]
fn only_what_belongs_to_the_suite_is_called_off() {
    let base = recorded(&suite("5 m", PLENTY, ""));
    let search = "search worst { in walker; over tta in 3 s .. 5 s; minimise min_distance; budget 6 evaluations, 4 random first }";
    let text = suite("2.5 m", PLENTY, &format!("{GATE}\n  {search}"));
    let free = suite("5 m", "repeat 4\n    expect { max_deceleration <= 100 m/s^2 }", "");
    let free = free.replace("suite late", "suite free");
    let files = files(&text, &base).with("free.suite", free.as_str());
    let both = ["late.suite", "free.suite"];
    let project = Project::open_all(both, &ProjectOptions::default(), &standard(), &files);
    let project = project.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(units(project.suites()).len(), 7);
    let results = Session::new(&project).courses(false).run(&Selection::all(), &mut Unheard).unwrap();
    assert!(results.suites[0].blocks[0].skip().is_none());
    assert!(results.suites[1].trials.iter().all(|trial| trial.verdict() == Some(Verdict::Passed)));
    assert_eq!(results.overall(), Overall::Regressed);
}

/// Stops the session after so many runs.
struct Stopper {
    after: usize,
    stop: runner::run::Stop,
}

impl Reporter for Stopper {
    fn tell(&mut self, event: &Event) {
        if matches!(event, Event::RunDone { .. }) {
            self.after = self.after.saturating_sub(1);
        }
        if self.after == 0 {
            self.stop.request();
        }
    }
}

/// What was made before is told, and is no result.
#[test]
fn whoever_interrupts_looks_is_told_what_had_begun() {
    let base = recorded(&suite("5 m", PLENTY, ""));
    let files = files(&suite("5 m", PLENTY, GATE), &base);
    let project = Project::open("late.suite", &standard(), &files).unwrap_or_else(|error| panic!("{error}"));
    let stop = runner::run::Stop::default();
    let session = Session::new(&project).executor(Threads::new(1)).stopped_by(&stop).courses(false);
    let results = session.run(&Selection::all(), &mut Stopper { after: 20, stop: stop.clone() }).unwrap();
    let report = &results.suites[0];
    assert!(report.interrupted);
    let cut = Standing::NotFinished(CutBy::Interrupted);
    assert!(report.trials.iter().all(|trial| trial.standing() == cut && trial.outcomes.is_empty()));
    let made: usize = report.trials.iter().map(|trial| trial.made()).sum();
    assert!((20..180).contains(&made), "{made}");
    assert_ne!(results.overall(), Overall::Passed);
}

/// Each course is given once, whether its gate ends the suite or not.
#[test]
fn courses_of_runs_that_were_looked_at_are_given_once() {
    let gate = GATE.replace("no metric worse", "max_deceleration not worse");
    for (distance, trials, runs, all) in [("2.5 m", PLENTY, 180, false), ("5 m", FEW, 60, true)] {
        let base = recorded(&suite("5 m", trials, ""));
        let files = files(&suite(distance, trials, &gate), &base);
        let project =
            Project::open("late.suite", &standard(), &files).unwrap_or_else(|error| panic!("{error}"));
        let seen = std::sync::Mutex::new(Vec::new());
        let watch = |case: &scenario::Case, trace: &sim::Trace| {
            assert!(!trace.samples.is_empty());
            seen.lock().unwrap().push(case.key.clone());
        };
        let session = Session::new(&project).executor(Threads::new(2)).courses(false).watched_by(&watch);
        let results = session.run(&Selection::all(), &mut Unheard).unwrap();
        let mut seen = seen.lock().unwrap().clone();
        seen.sort();
        let mut made: Vec<String> = results.suites[0]
            .trials
            .iter()
            .flat_map(|one| &one.outcomes)
            .map(|one| one.key.clone())
            .collect();
        made.sort();
        assert_eq!(seen, made);
        assert_eq!(made.len() == runs, all, "{}", made.len());
    }
}
