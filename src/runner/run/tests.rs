//! Runs of a sequence and of many, by executors that differ in everything but what comes of it.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;
use std::{iter, thread};

use super::*;
use results::{Outcome, Requests};
use scenario::registry::EntryKind;
use scenario::{Case, Direction, Road, World};
use sim::{Ending, StopReason, Trace};

fn executors() -> Vec<Box<dyn Executor>> {
    let threads = [1, 2, 5].map(|threads| Box::new(Threads::new(threads)) as Box<dyn Executor>);
    let shuffled = (0..8).map(|seed| Box::new(Shuffled::seeded(seed)) as Box<dyn Executor>);
    threads.into_iter().chain(shuffled).collect()
}

fn case(number: usize) -> Case {
    let world = World {
        road: Road::zebra(&[Direction::Forward], 10.0),
        other_roads: Vec::new(),
        vehicles: Vec::new(),
        pedestrians: Vec::new(),
        streams: Vec::new(),
        step: 0.025,
        horizon: 1.0,
        finish: 1.0,
        end_on_collision: false,
    };
    Case {
        key: format!("a/b/rep={number}"),
        scenario: "b".into(),
        variation: Vec::new(),
        individuals: Vec::new(),
        drawn: Vec::new(),
        impossible: None,
        repetition: number as u32,
        seed: number as u64,
        world: Arc::new(world),
    }
}

fn keys(runs: usize) -> Vec<String> {
    (1..=runs).map(|number| case(number).key).collect()
}

/// Takes in runs until `enough` of them, or one that failed, or it is asked between them to stop.
struct Counted<'c> {
    runs: usize,
    enough: usize,
    made: &'c AtomicUsize,
    most: usize,
    taken: Vec<String>,
    failed: Option<String>,
}

impl<'c> Counted<'c> {
    fn new(runs: usize, enough: usize, made: &'c AtomicUsize) -> Self {
        Self { runs, enough, made, most: usize::MAX, taken: Vec::new(), failed: None }
    }
}

impl Sequence for Counted<'_> {
    fn runs(&self) -> usize {
        self.runs
    }

    fn job(&mut self, place: JobPlace) -> Job {
        self.made.fetch_add(1, Ordering::Relaxed);
        let measured = MeasuredMetrics::new(Requests::default());
        Job {
            place,
            case: case(place.run + 1),
            measured,
            wanted: Wanted::Outcome,
            alone: false,
            change: None,
        }
    }

    fn take(&mut self, done: Done) -> ControlFlow<()> {
        match done.result {
            Ok(ran) => self.taken.push(ran.outcome.key),
            Err(failure) => self.failed = Some(format!("{failure:?}")),
        }
        let over = self.failed.is_some() || self.taken.len() == self.enough;
        if over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn between(&mut self, taken: usize) -> ControlFlow<()> {
        if taken >= self.most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Sequences from a list, and what became of each.
struct Listed<'c>(Vec<Counted<'c>>, Vec<(Vec<String>, usize)>);

impl<'c> Sequences for Listed<'c> {
    type One = Counted<'c>;

    fn open(&mut self) -> Option<Counted<'c>> {
        self.0.pop()
    }

    fn close(&mut self, one: Counted<'c>, taken: usize) {
        self.1.push((one.taken, taken));
    }
}

#[test]
fn a_sequence_stops_where_it_has_enough() {
    for executor in executors() {
        let made = AtomicUsize::new(0);
        let mut sequences = Listed(vec![Counted::new(1000, 41, &made)], Vec::new());
        run_sequences(&*executor, &mut sequences, &Stop::default());
        assert_eq!(sequences.1, [(keys(41), 41)]);
        let made = made.into_inner();
        assert!((41..41 + 256).contains(&made), "{made}");
        if executor.parallelism() == 1 {
            assert_eq!(made, 41, "a thread by itself runs nothing in vain");
        }
    }
}

#[test]
fn sequences_take_in_their_own_runs_in_order() {
    for executor in executors() {
        let made = AtomicUsize::new(0);
        let lengths = [0, 300, 1, 700, 0, 2];
        let all = lengths.iter().map(|runs| Counted::new(*runs, usize::MAX, &made)).collect();
        let mut sequences = Listed(all, Vec::new());
        run_sequences(&*executor, &mut sequences, &Stop::default());
        let mut found: Vec<_> = sequences.1.into_iter().map(|(keys, _)| keys).collect();
        found.sort_by_key(Vec::len);
        assert_eq!(found, [0, 0, 1, 2, 300, 700].map(keys));
        assert_eq!(made.into_inner(), 1003, "each is made once");
    }
}

#[test]
fn whoever_is_asked_between_runs_may_end_it() {
    for executor in executors() {
        let made = AtomicUsize::new(0);
        let mut late = Counted::new(20, usize::MAX, &made);
        late.most = 0;
        let mut sequences = Listed(vec![late], Vec::new());
        run_sequences(&*executor, &mut sequences, &Stop::default());
        assert_eq!((sequences.1, made.into_inner()), (vec![(Vec::new(), 0)], 0));
    }
}

#[test]
fn what_was_wished_to_stop_comes_back_with_the_runs_it_has() {
    let stop = Stop::default();
    for executor in executors() {
        let measured = MeasuredMetrics::new(Requests::default());
        let stop = Stop::default();
        let batch = RunBatch { executor: &*executor, measured: &measured, stop: &stop };
        let mut taken = Vec::new();
        let result = batch.each(
            1000,
            Wanted::Outcome,
            |index| case(index + 1),
            |case, _| {
                taken.push(case.key);
                if taken.len() == 3 {
                    stop.request();
                }
            },
        );
        assert!(matches!(result, Err(BatchError::Stopped)));
        assert!((3..300).contains(&taken.len()) && taken == keys(taken.len()), "{}", taken.len());
    }
    assert!(!stop.is_requested());
}

/// An executor whose runs are what a function says instead of a simulation: on threads of its own, in an order of its own.
struct Played<'p> {
    by: &'p dyn Executor,
    run: &'p (dyn Fn(usize) -> Result<(), JobFailure> + Sync),
}

struct PlayedRound<'r> {
    round: &'r mut dyn Round,
    run: &'r (dyn Fn(usize) -> Result<(), JobFailure> + Sync),
}

impl Executor for Played<'_> {
    fn run(&self, round: &mut dyn Round) {
        self.by.run(&mut PlayedRound { round, run: self.run });
    }

    fn parallelism(&self) -> usize {
        self.by.parallelism()
    }
}

impl Round for PlayedRound<'_> {
    fn next(&mut self) -> Option<Job> {
        self.round.next()
    }

    fn done(&mut self, done: Done) {
        let result = (self.run)(done.case.repetition as usize).map(|()| Ran {
            outcome: outcome(&done.case),
            trace: Trace::default(),
            events: Vec::new(),
            decisions: Vec::new(),
            commands: Vec::new(),
            details: None,
        });
        self.round.done(Done { result, ..done });
    }
}

fn outcome(case: &Case) -> Outcome {
    Outcome {
        key: case.key.clone(),
        seed: case.seed,
        individuals: Vec::new(),
        drawn: Vec::new(),
        ending: Ending { reason: StopReason::Completed, time: 1.0 },
        metrics: Vec::new(),
        critical: Default::default(),
        presences: Vec::new(),
        waiting_steps: Vec::new(),
        left_road: Vec::new(),
        outlasted: Vec::new(),
        cut_off: Default::default(),
        fingerprint: 0,
        wall_time: Duration::ZERO,
    }
}

fn unknown(name: usize) -> JobFailure {
    JobFailure::Error(RunError::Unknown { kind: EntryKind::Controller, name: name.to_string() })
}

/// The keys of 100 runs that were taken in, and how that ended.
fn played(
    executor: &dyn Executor,
    run: &(dyn Fn(usize) -> Result<(), JobFailure> + Sync),
) -> (Vec<String>, thread::Result<Result<(), BatchError>>) {
    let measured = MeasuredMetrics::new(Requests::default());
    let stop = Stop::default();
    let batch = RunBatch { executor: &Played { by: executor, run }, measured: &measured, stop: &stop };
    let mut taken = Vec::new();
    let each = || batch.each(100, Wanted::Outcome, |run| case(run + 1), |case, _| taken.push(case.key));
    let ended = catch_unwind(AssertUnwindSafe(each));
    (taken, ended)
}

#[test]
fn the_first_error_in_order_ends_it_and_names_its_run() {
    for executor in executors() {
        let (taken, ended) = played(&*executor, &|run| if run < 5 { Ok(()) } else { Err(unknown(run)) });
        let error = ended.expect("nothing panicked").expect_err("runs fail").to_string();
        assert_eq!((error.as_str(), taken), ("a/b/rep=5: there is no controller called `5`", keys(4)));
    }
}

#[test]
fn a_panic_is_that_of_the_first_run_in_order() {
    for executor in executors() {
        let panics = |run: usize| {
            let said = Panicked { case: Some(run.to_string()), message: "no".into(), place: None };
            if run < 5 { Ok(()) } else { Err(JobFailure::Panicked(said)) }
        };
        let (taken, ended) = played(&*executor, &panics);
        let panicked = Panicked::of(ended.expect_err("a run panicked"));
        assert_eq!((panicked.case.as_deref(), taken), (Some("5"), keys(4)));
    }
}

#[test]
fn rounds_share_the_threads_there_are() {
    let threads = Threads::new(3);
    let (now, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let busy = || {
        most.fetch_max(1 + now.fetch_add(1, Ordering::SeqCst), Ordering::SeqCst);
        thread::sleep(Duration::from_millis(1));
        now.fetch_sub(1, Ordering::SeqCst);
    };
    thread::scope(|scope| {
        for driver in 0..4 {
            let (threads, busy) = (&threads, &busy);
            scope.spawn(move || match driver {
                0 => threads.host(&mut || iter::repeat_n((), 20).for_each(|()| busy())),
                _ => {
                    let (_, ended) = played(threads, &|_| {
                        busy();
                        Ok(())
                    });
                    ended.expect("nothing panicked").expect("all are made");
                }
            });
        }
    });
    assert!(most.into_inner() <= 3);
}
