//! Many runs in lockstep: each goes on until a program decides, and programs are asked for all of them at once.
//!
//! What comes of a run depends neither on the others nor on how many there are. Where a program fails with many runs, each is made
//! again alone with a fresh process, so that only those are blamed that fail alone. What comes of a run counts once its programs were seen
//! to have said nothing besides their answers.

use std::collections::{HashSet, VecDeque};
use std::mem;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::job::{Done, Job, JobPlace};
use super::program_run::{AskedAt, Begun, ProgramRun, SlotRequest, StageEnd, StageEnds};
use scenario::{DeclaredProgram, Delay};
use under_test::{AcquiredProcesses, FaultKind, Process, ProcessPool, ProgramFault};

/// Between two looks at whether runs are still wanted.
const CHECK_INTERVAL: Duration = Duration::from_millis(100);

/// Where runs come from, and where they go.
pub trait JobSource {
    /// A run that may be made now.
    fn next(&mut self) -> Option<Job>;

    /// Takes what came of one.
    fn done(&mut self, done: Done);

    /// Whether somebody still waits for one.
    fn is_wanted(&mut self, place: JobPlace) -> bool;
}

/// Makes the run and others, as long as there are any, together with those that the same programs decide in.
pub fn run_with_programs(
    pool: &ProcessPool,
    programs: Vec<Arc<DeclaredProgram>>,
    first: Job,
    jobs: &mut dyn JobSource,
) {
    let mut next = Some((programs, first));
    while let Some((programs, first)) = next.take() {
        match pool.acquire(&programs) {
            Ok(processes) => next = Lockstep::new(processes, jobs).run(first),
            Err((index, fault)) => jobs.done(refused(first, &programs[index], fault)),
        }
        if next.is_none() {
            next = jobs.next().and_then(|job| alone_if_inside(job, jobs));
        }
    }
}

/// A run in which no program decides is made at once; of others, with their programs.
fn alone_if_inside(job: Job, jobs: &mut dyn JobSource) -> Option<(Vec<Arc<DeclaredProgram>>, Job)> {
    let mut next = Some(job);
    while let Some(job) = next {
        let programs = job.programs();
        if !programs.is_empty() {
            return Some((programs, job));
        }
        jobs.done(job.run());
        next = jobs.next();
    }
    None
}

/// A run that never began, since a program is not there.
fn refused(job: Job, program: &DeclaredProgram, fault: ProgramFault) -> Done {
    ProgramRun::refused(job, program, fault)
}

/// Runs that go on together.
struct Lockstep<'y, 'd> {
    processes: AcquiredProcesses<'y>,
    jobs: &'d mut dyn JobSource,
    runs: Vec<ProgramRun>,
    /// Whether its runs are made one after the other, in processes that have made none of them.
    is_alone: bool,
    /// Slots that are free, for each program.
    free: Vec<Vec<usize>>,
    /// Slots that are to be closed, for each program, with how their runs ended.
    closing: Vec<Vec<(usize, &'static str)>>,
    /// What has ended, its programs not being seen yet to be in step: an answer too many makes all that follow it answers to something else.
    unconfirmed: Vec<(ProgramRun, StageEnd)>,
    /// Runs that wait for a free flow that is under way.
    waiting_for_flow: VecDeque<Job>,
    flows: HashSet<[u8; 32]>,
    /// Runs that are made again alone, and what became of those that were.
    retries: VecDeque<Retry>,
    retried: Vec<(Retry, Done)>,
    checked: Instant,
}

/// A run that was under way when a program failed.
struct Retry {
    job: Job,
    /// Whether it was asked for in the request that failed.
    was_asked: bool,
    /// Up to where it had come.
    reached: AskedAt,
    fault: ProgramFault,
}

impl<'y, 'd> Lockstep<'y, 'd> {
    fn new(processes: AcquiredProcesses<'y>, jobs: &'d mut dyn JobSource) -> Self {
        let programs = processes.len();
        Self {
            processes,
            jobs,
            runs: Vec::new(),
            is_alone: false,
            free: vec![Vec::new(); programs],
            closing: vec![Vec::new(); programs],
            unconfirmed: Vec::new(),
            waiting_for_flow: VecDeque::new(),
            flows: HashSet::new(),
            retries: VecDeque::new(),
            retried: Vec::new(),
            checked: Instant::now(),
        }
    }

    /// Makes runs until there is none in which these programs decide; the next one in which others do.
    fn run(mut self, first: Job) -> Option<(Vec<Arc<DeclaredProgram>>, Job)> {
        let programs: Vec<Arc<DeclaredProgram>> =
            (0..self.processes.len()).map(|index| self.processes.program(index).clone()).collect();
        let mut other = None;
        let is_measured = programs.iter().any(|program| program.delay == Delay::Measured);
        self.is_alone = first.alone;
        if self.is_alone {
            (0..self.processes.len()).for_each(|index| _ = self.processes.replace(index));
        }
        let mut waiting = VecDeque::from([first]);
        let most = if is_measured || self.is_alone { 1 } else { self.processes.runs_at_once() };
        for (index, free) in self.free.iter_mut().enumerate() {
            let known = self.processes.process(index).map_or(1, |process| process.hello().runs_at_once);
            *free = (0..known).rev().collect();
        }
        loop {
            self.admit(most, &programs, &mut waiting, &mut other);
            if self.runs.is_empty() {
                if self.is_idle() && waiting.is_empty() {
                    break;
                }
                continue;
            }
            self.close();
            self.open();
            self.go_on();
            self.close();
            self.confirm();
            self.check_wanted();
        }
        self.close();
        other
    }

    fn is_idle(&self) -> bool {
        self.retries.is_empty() && self.retried.is_empty() && self.waiting_for_flow.is_empty()
    }

    /// Begins runs as long as there is room.
    fn admit(
        &mut self,
        most: usize,
        programs: &[Arc<DeclaredProgram>],
        waiting: &mut VecDeque<Job>,
        other: &mut Option<(Vec<Arc<DeclaredProgram>>, Job)>,
    ) {
        if !self.retries.is_empty() || !self.retried.is_empty() {
            if self.runs.is_empty() {
                self.admit_retry();
            }
            return;
        }
        while self.runs.len() < most.max(1) {
            let flow_is_known = if self.flows.is_empty() { self.waiting_for_flow.pop_front() } else { None };
            let Some(job) = flow_is_known.or_else(|| waiting.pop_front()) else {
                if other.is_some() || self.waiting_for_flow.len() >= most {
                    return;
                }
                let Some(job) = self.jobs.next() else { return };
                let own = job.programs();
                match own.is_empty() {
                    true => self.jobs.done(job.run()),
                    false if own == programs && job.alone == self.is_alone => waiting.push_back(job),
                    false => {
                        *other = Some((own, job));
                        return;
                    }
                }
                continue;
            };
            if let Some(job) = self.begin(job) {
                waiting.push_front(job);
                return;
            }
        }
    }

    /// Begins a run; gives it back if there are no slots for it now.
    fn begin(&mut self, job: Job) -> Option<Job> {
        match ProgramRun::begin(job, &self.processes, &self.flows) {
            Begun::Run(mut run) => {
                if !run.take_slots(&mut self.free) {
                    // With nobody else there, there will never be more.
                    if self.runs.is_empty() {
                        let fault = "more of its vehicles are in one run than it takes runs at once";
                        let done = run.fault_all(ProgramFault::new(FaultKind::Refused, fault));
                        self.done(done);
                        return None;
                    }
                    return Some(run.into_job());
                }
                self.flows.extend(run.flow());
                self.runs.push(*run);
                None
            }
            Begun::WaitsForFlow(job) => {
                self.waiting_for_flow.push_back(job);
                None
            }
            Begun::Done(done) => {
                self.done(*done);
                None
            }
        }
    }

    /// Begins the next run that is made again alone; if there are no more, tells what became of them.
    fn admit_retry(&mut self) {
        if let Some(retry) = self.retries.front() {
            let job = retry.job.clone();
            if !self.jobs.is_wanted(job.place) {
                self.retries.pop_front();
                return;
            }
            for (index, closing) in self.closing.iter_mut().enumerate() {
                if self.processes.replace(index) {
                    closing.clear();
                }
            }
            // Alone, it waits for nobody's free flow.
            self.flows.clear();
            let left = self.begin(job);
            debug_assert!(left.is_none(), "alone, a run has all slots");
            return;
        }
        let retried = mem::take(&mut self.retried);
        let any_alone = retried.iter().any(|(_, done)| done.result.is_err());
        for (Retry { job, was_asked, reached, fault }, done) in retried {
            let together = !any_alone && was_asked;
            self.jobs.done(if together {
                let message =
                    format!("with many runs at once it failed ({}), with each alone it did not", fault.kind);
                let fault = ProgramFault { kind: FaultKind::OnlyTogether, message, ..fault };
                ProgramRun::failed_together(job, fault, reached)
            } else {
                done
            });
        }
    }

    /// Tells what became of a run; of one that is made again alone, once all of them are.
    fn done(&mut self, done: Done) {
        match self.retries.pop_front() {
            Some(retry) => self.retried.push((retry, done)),
            None => self.jobs.done(done),
        }
    }

    /// Tells programs of runs that are over.
    fn close(&mut self) {
        for index in 0..self.processes.len() {
            let closing = mem::take(&mut self.closing[index]);
            if closing.is_empty() || !self.processes.is_there(index) {
                continue;
            }
            let told = self.processes.process(index).and_then(|process| process.close(&closing));
            if let Err(fault) = told {
                self.fail(index, &[], fault);
            }
        }
    }

    /// Has programs prepare the runs that are new.
    fn open(&mut self) {
        for index in 0..self.processes.len() {
            let new: Vec<usize> = (0..self.runs.len()).filter(|run| self.runs[*run].is_new()).collect();
            let requests: Vec<SlotRequest> =
                new.iter().flat_map(|run| self.runs[*run].opening(*run, index)).collect();
            if requests.is_empty() {
                continue;
            }
            let opened: Vec<_> =
                requests.iter().map(|request| self.runs[request.run].opened(request)).collect();
            let answer = self.processes.process(index).and_then(|process| process.open(&opened));
            match answer {
                Ok(refused) => {
                    for (request, opened) in requests.iter().zip(&opened) {
                        let run = &self.runs[request.run];
                        if let Some(record) = self.processes.record_of(run.key()) {
                            let refused = refused.iter().find(|(slot, _)| *slot == request.slot);
                            let name = run.vehicle_name(request.vehicle);
                            record.opened(request.vehicle, name, opened, refused.map(|(_, fault)| fault));
                        }
                    }
                    let mut ended = StageEnds::default();
                    for (slot, fault) in refused {
                        if let Some(request) = requests.iter().find(|request| request.slot == slot) {
                            ended.add(request.run, self.runs[request.run].fault(request.vehicle, fault));
                        }
                    }
                    self.end(ended);
                }
                Err(fault) => {
                    let asked: Vec<usize> = requests.iter().map(|request| request.run).collect();
                    self.fail(index, &asked, fault);
                }
            }
        }
        self.runs.iter_mut().for_each(ProgramRun::is_open);
    }

    /// Has every run go on to where programs decide, and asks them.
    fn go_on(&mut self) {
        let mut ended = StageEnds::default();
        for (index, run) in self.runs.iter_mut().enumerate().filter(|(_, run)| !run.is_new()) {
            if let Some(end) = run.go_on() {
                ended.add(index, end);
            }
        }
        self.end(ended);
        for index in 0..self.processes.len() {
            let runs = self.runs.iter().enumerate().filter(|(_, run)| !run.is_new());
            let requests: Vec<SlotRequest> = runs.flat_map(|(run, one)| one.asking(run, index)).collect();
            if requests.is_empty() {
                continue;
            }
            let asked: Vec<_> =
                requests.iter().map(|request| self.runs[request.run].asked(request)).collect();
            let answer = self.processes.process(index).and_then(|process| process.decide(&asked));
            match answer {
                Ok((answers, time)) => {
                    let each = time.as_secs_f64() / requests.len() as f64;
                    let is_late = |one: &&SlotRequest| each > self.runs[one.run].period(one);
                    let late = requests.iter().filter(is_late).count();
                    self.processes.note_answer(index, time, requests.len(), late);
                    for (request, (asked, answer)) in requests.iter().zip(asked.iter().zip(&answers)) {
                        if let Some(record) = self.processes.record_of(self.runs[request.run].key()) {
                            record.decided(request.vehicle, asked, Ok(answer));
                        }
                    }
                    let mut ended = StageEnds::default();
                    for (request, answer) in requests.iter().zip(answers) {
                        if let Some(end) = self.runs[request.run].decide(request, answer, time) {
                            ended.add(request.run, end);
                        }
                    }
                    self.end(ended);
                }
                Err(fault) => {
                    for (request, asked) in requests.iter().zip(&asked) {
                        if let Some(record) = self.processes.record_of(self.runs[request.run].key()) {
                            record.decided(request.vehicle, asked, Err(&fault));
                        }
                    }
                    let asked: Vec<usize> = requests.iter().map(|request| request.run).collect();
                    self.fail(index, &asked, fault);
                }
            }
        }
    }

    /// Takes out what has ended.
    fn end(&mut self, ended: StageEnds) {
        // From behind, so that the places of the others stay.
        for (index, end) in ended.last_first() {
            let mut run = self.runs.swap_remove(index);
            if end.is_finished()
                && let Some(record) = self.processes.record_of(run.key())
            {
                record.closed(end.word());
            }
            run.close(end.word(), &mut self.closing);
            match end {
                StageEnd::Failed(..) => self.settle(run, end),
                _ => self.unconfirmed.push((run, end)),
            }
        }
    }

    /// Sees that the programs of what has ended are in step, and tells what became of it.
    fn confirm(&mut self) {
        if self.unconfirmed.is_empty() {
            return;
        }
        for index in 0..self.processes.len() {
            if let Err(fault) = self.processes.process(index).and_then(Process::confirm) {
                return self.fail(index, &[], fault);
            }
        }
        for (run, end) in mem::take(&mut self.unconfirmed) {
            self.settle(run, end);
        }
    }

    /// Tells what became of a run; one whose free flow has ended goes on.
    fn settle(&mut self, mut run: ProgramRun, end: StageEnd) {
        if let Some(flow) = run.flow() {
            self.flows.remove(&flow);
        }
        let done = match end {
            StageEnd::Flow => match run.begin_run() {
                Some(done) => {
                    run.free_slots(&mut self.free);
                    done
                }
                None => return self.runs.push(run),
            },
            end => {
                run.free_slots(&mut self.free);
                if end.is_finished() {
                    self.processes.finished();
                }
                run.done(end)
            }
        };
        self.done(done);
    }

    /// A process is gone: the run that it was asked for alone has that fault, of several each is made again alone. Where it was asked for
    /// none, it was about what has ended.
    fn fail(&mut self, program: usize, asked: &[usize], fault: ProgramFault) {
        self.closing[program].clear();
        let is_one = self.runs.len() + self.unconfirmed.len() == 1;
        if is_one && (asked.contains(&0) || !self.retries.is_empty() || self.runs.is_empty()) {
            match self.unconfirmed.pop() {
                Some((mut run, end)) => {
                    let named = (program, &**self.processes.program(program));
                    let end = run.unconfirmed(&end, named, fault);
                    self.settle(run, end);
                }
                None => {
                    let mut ended = StageEnds::default();
                    ended.add(0, self.runs[0].fault_of(program, fault));
                    self.end(ended);
                }
            }
            return;
        }
        let ended = mem::take(&mut self.unconfirmed).into_iter().map(|(run, end)| {
            let reached = run.ended_at(&end);
            (run, reached, asked.is_empty())
        });
        // The same programs decide in all of them.
        let under_way = mem::take(&mut self.runs).into_iter().enumerate().map(|(index, run)| {
            let reached = run.reached();
            (run, reached, asked.contains(&index))
        });
        for (mut run, reached, was_asked) in ended.chain(under_way) {
            run.close("abandoned", &mut self.closing);
            run.free_slots(&mut self.free);
            self.retries.push_back(Retry { job: run.into_job(), was_asked, reached, fault: fault.clone() });
        }
        self.closing[program].clear();
        self.flows.clear();
    }

    /// Now and then, leaves off what nobody waits for any more.
    fn check_wanted(&mut self) {
        if self.checked.elapsed() < CHECK_INTERVAL {
            return;
        }
        self.checked = Instant::now();
        let jobs = &mut *self.jobs;
        let unwanted: Vec<usize> =
            (0..self.runs.len()).filter(|run| !jobs.is_wanted(self.runs[*run].place())).collect();
        for index in unwanted.into_iter().rev() {
            let mut run = self.runs.swap_remove(index);
            run.close("abandoned", &mut self.closing);
            if let Some(flow) = run.flow() {
                self.flows.remove(&flow);
            }
            run.free_slots(&mut self.free);
            self.retries.pop_front();
        }
    }
}
