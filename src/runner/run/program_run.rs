//! One run in which programs decide: its free flow first, unless that is known, then itself.

use std::collections::HashSet;
use std::time::Duration;

use super::build::RunError;
use super::case_run::RunningCase;
use super::free_flow::{Begun as BegunFlow, FreeFlowRun, SEED};
use super::job::{Done, Job, JobFailure, JobPlace, LoggedDecision, Ran, Wanted, Watcher};
use super::panic::{Panicked, in_case};
use scenario::{DeclaredProgram, Delay, SignalState, VehicleSetup, World};
use sim::random::{Agent, Purpose, stream, vehicle_ranks};
use sim::{Course, Fault, Progress, SteeredOrder, StopReason};
use under_test::{AcquiredProcesses, Answered, Decision, DueDecision, FaultKind, Opened, ProgramFault};

/// A run under way.
pub struct ProgramRun {
    job: Job,
    watcher: Watcher,
    /// Where they are wanted.
    decisions: Vec<LoggedDecision>,
    stage: Stage,
    drivers: Vec<Driver>,
    /// Whether programs have not heard of this stage of it yet.
    is_new: bool,
}

/// A vehicle that a program drives.
struct Driver {
    vehicle: usize,
    /// Index of its program.
    program: usize,
    slot: usize,
    seed: u64,
    /// s
    period: f64,
    delay: Delay,
    /// Whether it was not asked yet.
    is_first: bool,
}

enum Stage {
    Flow(Box<FreeFlowRun>),
    Run(Box<RunningCase>),
    /// It is over.
    Nothing,
}

/// What came of beginning a run.
pub enum Begun {
    Run(Box<ProgramRun>),
    /// It waits for a free flow that is under way.
    WaitsForFlow(Job),
    Done(Box<Done>),
}

/// A question to a program: which run, vehicle and slot it is about.
pub struct SlotRequest {
    pub run: usize,
    pub vehicle: usize,
    pub slot: usize,
    driver: usize,
}

/// Up to where a run has come: the time of what is decided next (s), if it was asked for, and whether it is the free flow.
#[derive(Debug, Clone, Copy, Default)]
pub struct AskedAt {
    time: Option<f64>,
    free_flow: bool,
}

/// How a stage of a run ended.
pub enum StageEnd {
    /// A free flow, after which the run itself begins.
    Flow,
    Ran(Box<Ran>),
    Failed(&'static str, JobFailure),
}

/// Runs that have ended, by their places.
#[derive(Default)]
pub struct StageEnds(Vec<(usize, StageEnd)>);

impl StageEnds {
    /// The first end of a run counts.
    pub fn add(&mut self, run: usize, end: StageEnd) {
        if self.0.iter().all(|(known, _)| *known != run) {
            self.0.push((run, end));
        }
    }

    /// All of them, the last place first.
    pub fn last_first(mut self) -> impl Iterator<Item = (usize, StageEnd)> {
        self.0.sort_by_key(|(run, _)| std::cmp::Reverse(*run));
        self.0.into_iter()
    }
}

impl StageEnd {
    /// What programs are told of it.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Flow => "completed",
            Self::Ran(ran) => match ran.outcome.ending.reason {
                StopReason::Completed => "completed",
                StopReason::Collision => "collision",
                StopReason::Horizon => "horizon",
            },
            Self::Failed(word, _) => word,
        }
    }

    pub fn is_finished(&self) -> bool {
        matches!(self, Self::Ran(_))
    }
}

/// A run as its job wants it.
fn otherwise(run: RunningCase, job: &Job) -> RunningCase {
    run.otherwise(job.change.as_deref(), job.wanted.has_commands())
}

impl ProgramRun {
    /// Begins a run, or its free flow; one that another run drives already is waited for.
    pub fn begin(job: Job, processes: &AcquiredProcesses, flows: &HashSet<[u8; 32]>) -> Begun {
        let begun = Panicked::catch(|| {
            in_case(&job.case.key, || match job.measured.free_flows.begin(&job.case.world)? {
                BegunFlow::Run(run) if flows.contains(&run.hash()) => Ok(None),
                BegunFlow::Run(run) => Ok(Some(Stage::Flow(run))),
                BegunFlow::Known(flows) => RunningCase::start(&job.case, &job.measured.requests, &flows)
                    .map(|run| Some(Stage::Run(Box::new(otherwise(run, &job))))),
            })
        });
        let stage = match begun {
            Ok(Ok(Some(stage))) => stage,
            Ok(Ok(None)) => return Begun::WaitsForFlow(job),
            Ok(Err(error)) => return Begun::Done(Box::new(failed(job, JobFailure::Error(error)))),
            Err(panicked) => return Begun::Done(Box::new(failed(job, JobFailure::Panicked(panicked)))),
        };
        let watcher = Watcher::new(job.wanted, &job.case, &job.measured.requests);
        let mut run = Self { watcher, decisions: Vec::new(), stage, drivers: Vec::new(), is_new: true, job };
        run.drivers = run.drivers_of(processes);
        Begun::Run(Box::new(run))
    }

    fn drivers_of(&self, processes: &AcquiredProcesses) -> Vec<Driver> {
        let world = &self.job.case.world;
        let seed = self.seed();
        let ranks = vehicle_ranks(world);
        let driver = |(vehicle, rank): (usize, usize)| {
            let program = world.vehicles[vehicle].controller.model.known()?.program.as_ref()?;
            Some(Driver {
                vehicle,
                program: (0..processes.len()).find(|index| processes.program(*index) == program)?,
                slot: 0,
                // Of nothing that tells which run it is, and a whole number in JSON.
                seed: stream(seed, Agent::Vehicle(rank), Purpose::Trait).bits() >> 11,
                period: program.period.unwrap_or(world.step),
                delay: program.delay,
                is_first: true,
            })
        };
        ranks.into_iter().enumerate().filter_map(driver).collect()
    }

    fn seed(&self) -> u64 {
        if matches!(self.stage, Stage::Flow(_)) { SEED } else { self.job.case.seed }
    }

    /// Takes a slot for each of its vehicles; whether there were enough.
    pub fn take_slots(&mut self, free: &mut [Vec<usize>]) -> bool {
        let needed = |program: usize| self.drivers.iter().filter(|one| one.program == program).count();
        if (0..free.len()).any(|program| free[program].len() < needed(program)) {
            return false;
        }
        for driver in &mut self.drivers {
            driver.slot = free[driver.program].pop().expect("there are enough");
        }
        true
    }

    pub fn free_slots(&self, free: &mut [Vec<usize>]) {
        self.drivers.iter().for_each(|driver| free[driver.program].push(driver.slot));
    }

    /// Has programs told that a stage of it is over, if they were told that it began.
    pub fn close(&mut self, word: &'static str, closing: &mut [Vec<(usize, &'static str)>]) {
        if !self.is_new {
            self.drivers.iter().for_each(|driver| closing[driver.program].push((driver.slot, word)));
        }
    }

    /// The key of its run, also while it is its free flow.
    pub fn key(&self) -> &str {
        &self.job.case.key
    }

    /// What a vehicle of it is called.
    pub fn vehicle_name(&self, vehicle: usize) -> &str {
        &self.job.case.world.vehicles[vehicle].name
    }

    pub fn place(&self) -> JobPlace {
        self.job.place
    }

    /// Up to where it has come.
    pub fn reached(&self) -> AskedAt {
        let (course, free_flow) = match &self.stage {
            Stage::Flow(flow) => (flow.seen(), true),
            Stage::Run(run) => (run.seen_course(), false),
            Stage::Nothing => return AskedAt::default(),
        };
        AskedAt { time: course.asked().next().map(|(_, seen)| seen.time), free_flow }
    }

    pub fn into_job(self) -> Job {
        self.job
    }

    /// The free flow that it drives, if it does.
    pub fn flow(&self) -> Option<[u8; 32]> {
        match &self.stage {
            Stage::Flow(flow) => Some(flow.hash()),
            _ => None,
        }
    }

    pub fn is_new(&self) -> bool {
        self.is_new
    }

    /// Programs are ready for it.
    pub fn is_open(&mut self) {
        self.is_new = false;
    }

    fn world(&self) -> &World {
        &self.job.case.world
    }

    fn course(&mut self) -> Option<&mut Course> {
        match &mut self.stage {
            Stage::Flow(flow) => Some(flow.course()),
            Stage::Run(run) => Some(run.course()),
            Stage::Nothing => None,
        }
    }

    /// What a program has to prepare for it, its own place being `run`.
    pub fn opening(&self, run: usize, program: usize) -> impl Iterator<Item = SlotRequest> {
        let drivers = self.drivers.iter().enumerate().filter(move |(_, driver)| driver.program == program);
        drivers.map(move |(index, driver)| SlotRequest {
            run,
            vehicle: driver.vehicle,
            slot: driver.slot,
            driver: index,
        })
    }

    pub fn opened(&self, request: &SlotRequest) -> Opened<'_> {
        let world = self.world();
        let seed = self.drivers[request.driver].seed;
        Opened { slot: request.slot, seed, setup: &world.vehicles[request.vehicle], world }
    }

    /// What a program is asked for it.
    pub fn asking(&self, run: usize, program: usize) -> Vec<SlotRequest> {
        let course = match &self.stage {
            Stage::Flow(flow) => flow.seen(),
            Stage::Run(one) => one.seen_course(),
            Stage::Nothing => return Vec::new(),
        };
        let driver_of = |vehicle: usize| {
            self.drivers
                .iter()
                .enumerate()
                .find(|(_, driver)| driver.vehicle == vehicle && driver.program == program)
        };
        course
            .asked()
            .filter_map(|(vehicle, _)| {
                let (index, driver) = driver_of(vehicle)?;
                Some(SlotRequest { run, vehicle, slot: driver.slot, driver: index })
            })
            .collect()
    }

    /// Time between two decisions of the vehicle that is asked about, s.
    pub fn period(&self, request: &SlotRequest) -> f64 {
        self.drivers[request.driver].period
    }

    /// # Panics
    /// If the vehicle is not asked.
    pub fn asked(&self, request: &SlotRequest) -> DueDecision<'_> {
        let course = match &self.stage {
            Stage::Flow(flow) => flow.seen(),
            Stage::Run(one) => one.seen_course(),
            Stage::Nothing => unreachable!("what is over is not asked for"),
        };
        let mut asked = course.asked();
        let (_, seen) = asked.find(|(vehicle, _)| *vehicle == request.vehicle).expect("it is asked");
        let driver = &self.drivers[request.driver];
        DueDecision {
            slot: request.slot,
            is_new: driver.is_first,
            seen,
            period: driver.period,
            signal: seen.road.signal.map(|signal| signal.state == SignalState::Green),
        }
    }

    /// Goes on until programs have to decide; how it ended if it did.
    pub fn go_on(&mut self) -> Option<StageEnd> {
        let key = &self.job.case.key;
        let (stage, watcher) = (&mut self.stage, &mut self.watcher);
        let progress = Panicked::catch(|| {
            in_case(key, || match stage {
                Stage::Flow(flow) => flow.go_on(),
                Stage::Run(run) => {
                    run.go_on(watcher).map_err(|fault| RunError::of_fault(&self.job.case.world, fault, false))
                }
                Stage::Nothing => Ok(Progress::Waits),
            })
        });
        match progress {
            Ok(Ok(Progress::Waits)) => None,
            Ok(Ok(Progress::Ended(_))) => Some(self.ended()),
            Ok(Err(error)) => Some(StageEnd::Failed("abandoned", JobFailure::Error(error))),
            Err(panicked) => Some(StageEnd::Failed("abandoned", JobFailure::Panicked(panicked))),
        }
    }

    fn ended(&mut self) -> StageEnd {
        match std::mem::replace(&mut self.stage, Stage::Nothing) {
            Stage::Flow(flow) => {
                self.stage = Stage::Flow(flow);
                StageEnd::Flow
            }
            Stage::Run(run) => {
                let Job { wanted, case, measured, .. } = &self.job;
                let next = Watcher::new(*wanted, case, &measured.requests);
                let watcher = std::mem::replace(&mut self.watcher, next);
                let outcome = Panicked::catch(|| in_case(&self.job.case.key, || run.outcome(&self.job.case)));
                match outcome {
                    Ok((outcome, commands)) => {
                        let decisions = std::mem::take(&mut self.decisions);
                        StageEnd::Ran(Box::new(Ran { decisions, commands, ..watcher.ran(outcome) }))
                    }
                    Err(panicked) => StageEnd::Failed("abandoned", JobFailure::Panicked(panicked)),
                }
            }
            Stage::Nothing => unreachable!("what is over does not end again"),
        }
    }

    /// Its free flow being driven, begins the run itself; what became of it if it does not begin.
    pub fn begin_run(&mut self) -> Option<Done> {
        let Stage::Flow(flow) = std::mem::replace(&mut self.stage, Stage::Nothing) else {
            unreachable!("a free flow has ended")
        };
        let flows = self.job.measured.free_flows.keep(*flow);
        let started = Panicked::catch(|| {
            in_case(&self.job.case.key, || {
                RunningCase::start(&self.job.case, &self.job.measured.requests, &flows)
            })
        });
        let failure = match started {
            Ok(Ok(run)) => {
                self.stage = Stage::Run(Box::new(otherwise(run, &self.job)));
                self.is_new = true;
                let seed = self.job.case.seed;
                let ranks = vehicle_ranks(&self.job.case.world);
                for driver in &mut self.drivers {
                    driver.is_first = true;
                    driver.seed =
                        stream(seed, Agent::Vehicle(ranks[driver.vehicle]), Purpose::Trait).bits() >> 11;
                }
                return None;
            }
            Ok(Err(error)) => JobFailure::Error(error),
            Err(panicked) => JobFailure::Panicked(panicked),
        };
        Some(failed(self.job.clone(), failure))
    }

    /// Takes a program's answer, which took `time`; how the run ended if it did.
    pub fn decide(&mut self, request: &SlotRequest, answer: Answered, time: Duration) -> Option<StageEnd> {
        let Decision { order, mode, curvature, speed: _ } = match answer {
            Ok(decision) => decision,
            Err(fault) => return Some(self.fault(request.vehicle, fault)),
        };
        let step = self.world().step;
        let driver = &mut self.drivers[request.driver];
        driver.is_first = false;
        let delay = match driver.delay {
            Delay::Fixed(delay) => delay,
            Delay::Measured => (time.as_secs_f64() / step).ceil() * step,
        };
        let (vehicle, orders) = (request.vehicle, SteeredOrder { along: order, curvature });
        if self.job.wanted != Wanted::Outcome && matches!(self.stage, Stage::Run(_)) {
            let time = self.asked(request).seen.time;
            self.decisions.push(LoggedDecision { vehicle, time, values: orders.values() });
        }
        let decided = self.course()?.decide_later(vehicle, orders, delay, mode);
        decided.err().map(|fault| self.faulted(fault))
    }

    fn faulted(&self, fault: Fault) -> StageEnd {
        let is_flow = matches!(self.stage, Stage::Flow(_));
        StageEnd::Failed("abandoned", JobFailure::Error(RunError::of_fault(self.world(), fault, is_flow)))
    }

    /// Ends it since the program of a vehicle did not do its part.
    pub fn fault(&mut self, vehicle: usize, fault: ProgramFault) -> StageEnd {
        let model = self.world().vehicles[vehicle].controller.model.known();
        let fault = match model.and_then(|model| model.program.as_deref()) {
            Some(program) => fault.of(program),
            None => fault,
        };
        match self.course().map(|course| course.fault(vehicle, fault.into_error())) {
            Some(fault) => self.faulted(fault),
            None => unreachable!("what is over does not fail"),
        }
    }

    /// As [`Self::fault`], of the first vehicle that a program drives.
    pub fn fault_of(&mut self, program: usize, fault: ProgramFault) -> StageEnd {
        let waiting = match &self.stage {
            Stage::Flow(flow) => flow.seen().asked().map(|(vehicle, _)| vehicle).collect(),
            Stage::Run(run) => run.seen_course().asked().map(|(vehicle, _)| vehicle).collect(),
            Stage::Nothing => Vec::new(),
        };
        let own = || self.drivers.iter().filter(|driver| driver.program == program);
        let first = own().find(|driver| waiting.contains(&driver.vehicle)).or_else(|| own().next());
        let vehicle = first.map_or(0, |driver| driver.vehicle);
        self.fault(vehicle, fault)
    }

    /// Ends a run that has not begun.
    pub fn fault_all(mut self, fault: ProgramFault) -> Done {
        let end = self.fault_of(0, fault);
        self.done(end)
    }

    /// Up to where it has come when it ended like that.
    pub fn ended_at(&self, end: &StageEnd) -> AskedAt {
        match end {
            StageEnd::Ran(ran) => AskedAt { time: Some(ran.outcome.ending.time), free_flow: false },
            _ => self.reached(),
        }
    }

    /// That it ended counts for nothing, since a program was not in step.
    pub fn unconfirmed(
        &mut self,
        end: &StageEnd,
        (index, program): (usize, &DeclaredProgram),
        fault: ProgramFault,
    ) -> StageEnd {
        match self.stage {
            Stage::Nothing => {
                let error = failure(self.world(), program, fault, self.ended_at(end));
                StageEnd::Failed("abandoned", JobFailure::Error(error))
            }
            Stage::Flow(_) | Stage::Run(_) => self.fault_of(index, fault),
        }
    }

    /// What became of it.
    pub fn done(self, end: StageEnd) -> Done {
        match end {
            StageEnd::Ran(ran) => Done { place: self.job.place, case: self.job.case, result: Ok(*ran) },
            StageEnd::Failed(_, failure) => failed(self.job, failure),
            StageEnd::Flow => unreachable!("after a free flow the run itself begins"),
        }
    }

    /// A run that never began, since a program is not there.
    pub fn refused(job: Job, program: &DeclaredProgram, fault: ProgramFault) -> Done {
        Self::refused_at(job, program, fault, AskedAt::default())
    }

    fn refused_at(job: Job, program: &DeclaredProgram, fault: ProgramFault, reached: AskedAt) -> Done {
        let error = failure(&job.case.world, program, fault, reached);
        failed(job, JobFailure::Error(error))
    }

    /// A run that failed with others and not alone.
    pub fn failed_together(job: Job, fault: ProgramFault, reached: AskedAt) -> Done {
        debug_assert_eq!(fault.kind, FaultKind::OnlyTogether);
        let programs = job.programs();
        match programs.first() {
            Some(program) => Self::refused_at(job, program, fault, reached),
            None => unreachable!("a program failed in it"),
        }
    }
}

/// That a program failed, as an error of the vehicle that it decides for.
fn failure(world: &World, program: &DeclaredProgram, fault: ProgramFault, reached: AskedAt) -> RunError {
    let own = |car: &&VehicleSetup| {
        let model = car.controller.model.known();
        model.and_then(|model| model.program.as_ref()).is_some_and(|one| **one == *program)
    };
    let who = world.vehicles.iter().find(own).or(world.vehicles.first()).map_or("", |car| car.name.as_str());
    RunError::Controller {
        who: who.to_string(),
        time: reached.time.unwrap_or(0.0 - program.settles),
        free_flow: reached.free_flow,
        error: fault.of(program).into_error(),
    }
}

fn failed(job: Job, failure: JobFailure) -> Done {
    Done { place: job.place, case: job.case, result: Err(failure) }
}
