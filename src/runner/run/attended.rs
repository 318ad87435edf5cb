//! Many runs in lockstep: each goes on until a program decides, and programs are asked for all of them at once.
//!
//! What comes of a run depends neither on the others nor on how many there are. Where a program fails with many runs, each is made
//! again alone with a fresh process, so that only those are blamed that fail alone.

use std::collections::{HashSet, VecDeque};
use std::mem;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::attended_run::{AttendedRun, Begun, SlotRequest, StageEnds};
use super::job::{Done, Job, JobPlace};
use scenario::{DeclaredProgram, Delay};
use under_test::{FaultKind, ProgramFault, Team, Yard};

/// Between two looks at whether runs are still wanted.
const LOOK: Duration = Duration::from_millis(100);

/// Where runs come from, and where they go.
pub trait Desk {
    /// A run that may be made now.
    fn next(&mut self) -> Option<Job>;

    /// Takes what came of one.
    fn done(&mut self, done: Done);

    /// Whether somebody still waits for one.
    fn is_wanted(&mut self, place: JobPlace) -> bool;
}

/// Makes the run and others, as long as there are any, together with those that the same programs decide in.
pub fn attend(yard: &Yard, programs: Vec<Arc<DeclaredProgram>>, first: Job, desk: &mut dyn Desk) {
    let mut next = Some((programs, first));
    while let Some((programs, first)) = next.take() {
        match yard.team(&programs) {
            Ok(team) => next = Lockstep::new(team, desk).run(first),
            Err((index, fault)) => desk.done(refused(first, &programs[index], fault)),
        }
        if next.is_none() {
            next = desk.next().and_then(|job| alone_if_inside(job, desk));
        }
    }
}

/// A run in which no program decides is made at once; of others, with their programs.
fn alone_if_inside(job: Job, desk: &mut dyn Desk) -> Option<(Vec<Arc<DeclaredProgram>>, Job)> {
    let mut next = Some(job);
    while let Some(job) = next {
        let programs = job.programs();
        if !programs.is_empty() {
            return Some((programs, job));
        }
        desk.done(job.run());
        next = desk.next();
    }
    None
}

/// A run that never began, since a program is not there.
fn refused(job: Job, program: &DeclaredProgram, fault: ProgramFault) -> Done {
    AttendedRun::refused(job, program, fault)
}

/// Runs that go on together.
struct Lockstep<'y, 'd> {
    team: Team<'y>,
    desk: &'d mut dyn Desk,
    runs: Vec<AttendedRun>,
    /// Slots that are free, for each program.
    free: Vec<Vec<usize>>,
    /// Slots that are to be closed, for each program, with how their runs ended.
    closing: Vec<Vec<(usize, &'static str)>>,
    /// Runs that wait for a free flow that is under way.
    parked: VecDeque<Job>,
    flows: HashSet<[u8; 32]>,
    /// Runs that are made again alone, and what became of those that were.
    suspects: VecDeque<Suspect>,
    cleared: Vec<(Suspect, Done)>,
    looked: Instant,
}

/// A run that was under way when a program failed.
struct Suspect {
    job: Job,
    /// Whether it was asked for in the request that failed.
    was_asked: bool,
    fault: ProgramFault,
}

impl<'y, 'd> Lockstep<'y, 'd> {
    fn new(team: Team<'y>, desk: &'d mut dyn Desk) -> Self {
        let programs = team.len();
        Self {
            team,
            desk,
            runs: Vec::new(),
            free: vec![Vec::new(); programs],
            closing: vec![Vec::new(); programs],
            parked: VecDeque::new(),
            flows: HashSet::new(),
            suspects: VecDeque::new(),
            cleared: Vec::new(),
            looked: Instant::now(),
        }
    }

    /// Makes runs until there is none in which these programs decide; the next one in which others do.
    fn run(mut self, first: Job) -> Option<(Vec<Arc<DeclaredProgram>>, Job)> {
        let programs: Vec<Arc<DeclaredProgram>> =
            (0..self.team.len()).map(|index| self.team.program(index).clone()).collect();
        let mut other = None;
        let mut waiting = VecDeque::from([first]);
        let is_measured = programs.iter().any(|program| program.delay == Delay::Measured);
        let most = if is_measured { 1 } else { self.team.runs_at_once() };
        for (index, free) in self.free.iter_mut().enumerate() {
            let known = self.team.process(index).map_or(1, |process| process.hello().runs_at_once);
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
            self.look();
        }
        self.close();
        other
    }

    fn is_idle(&self) -> bool {
        self.suspects.is_empty() && self.cleared.is_empty() && self.parked.is_empty()
    }

    /// Begins runs as long as there is room.
    fn admit(
        &mut self,
        most: usize,
        programs: &[Arc<DeclaredProgram>],
        waiting: &mut VecDeque<Job>,
        other: &mut Option<(Vec<Arc<DeclaredProgram>>, Job)>,
    ) {
        if !self.suspects.is_empty() || !self.cleared.is_empty() {
            if self.runs.is_empty() {
                self.admit_suspect();
            }
            return;
        }
        while self.runs.len() < most.max(1) {
            let unparked = if self.flows.is_empty() { self.parked.pop_front() } else { None };
            let Some(job) = unparked.or_else(|| waiting.pop_front()) else {
                if other.is_some() || self.parked.len() >= most {
                    return;
                }
                let Some(job) = self.desk.next() else { return };
                let own = job.programs();
                match own.is_empty() {
                    true => self.desk.done(job.run()),
                    false if own == programs => waiting.push_back(job),
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
        match AttendedRun::begin(job, &self.team, &self.flows) {
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
            Begun::Parked(job) => {
                self.parked.push_back(job);
                None
            }
            Begun::Done(done) => {
                self.done(*done);
                None
            }
        }
    }

    /// Begins the next run that is made again alone; if there are no more, tells what became of them.
    fn admit_suspect(&mut self) {
        if let Some(suspect) = self.suspects.front() {
            let job = suspect.job.clone();
            if !self.desk.is_wanted(job.place) {
                self.suspects.pop_front();
                return;
            }
            (0..self.team.len()).for_each(|index| self.team.renew(index));
            self.closing.iter_mut().for_each(Vec::clear);
            // Alone, it waits for nobody's free flow.
            self.flows.clear();
            let left = self.begin(job);
            debug_assert!(left.is_none(), "alone, a run has all slots");
            return;
        }
        let cleared = mem::take(&mut self.cleared);
        let somebody = cleared.iter().any(|(_, done)| done.result.is_err());
        for (Suspect { job, was_asked, fault }, done) in cleared {
            let together = !somebody && was_asked;
            self.desk.done(if together {
                let message =
                    format!("with many runs at once it failed ({}), with each alone it did not", fault.kind);
                AttendedRun::failed_together(
                    job,
                    ProgramFault { kind: FaultKind::OnlyTogether, message, ..fault },
                )
            } else {
                done
            });
        }
    }

    /// Tells what became of a run; of one that is made again alone, once all of them are.
    fn done(&mut self, done: Done) {
        match self.suspects.pop_front() {
            Some(suspect) => self.cleared.push((suspect, done)),
            None => self.desk.done(done),
        }
    }

    /// Tells programs of runs that are over.
    fn close(&mut self) {
        for index in 0..self.team.len() {
            let closing = mem::take(&mut self.closing[index]);
            if closing.is_empty() || !self.team.is_there(index) {
                continue;
            }
            let told = self.team.process(index).and_then(|process| process.close(&closing));
            if let Err(fault) = told {
                self.fail(index, &[], fault);
            }
        }
    }

    /// Has programs prepare the runs that are new.
    fn open(&mut self) {
        for index in 0..self.team.len() {
            let new: Vec<usize> = (0..self.runs.len()).filter(|run| self.runs[*run].is_new()).collect();
            let requests: Vec<SlotRequest> =
                new.iter().flat_map(|run| self.runs[*run].opening(*run, index)).collect();
            if requests.is_empty() {
                continue;
            }
            let opened: Vec<_> =
                requests.iter().map(|request| self.runs[request.run].opened(request)).collect();
            let answer = self.team.process(index).and_then(|process| process.open(&opened));
            match answer {
                Ok(refused) => {
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
        self.runs.iter_mut().for_each(AttendedRun::is_open);
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
        for index in 0..self.team.len() {
            let runs = self.runs.iter().enumerate().filter(|(_, run)| !run.is_new());
            let requests: Vec<SlotRequest> = runs.flat_map(|(run, one)| one.asking(run, index)).collect();
            if requests.is_empty() {
                continue;
            }
            let asked: Vec<_> =
                requests.iter().map(|request| self.runs[request.run].asked(request)).collect();
            let answer = self.team.process(index).and_then(|process| process.decide(&asked));
            match answer {
                Ok((answers, time)) => {
                    let mut ended = StageEnds::default();
                    for (request, answer) in requests.iter().zip(answers) {
                        if let Some(end) = self.runs[request.run].decide(request, answer, time) {
                            ended.add(request.run, end);
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
    }

    /// Takes out what has ended. A run whose free flow has ended goes on.
    fn end(&mut self, ended: StageEnds) {
        // From behind, so that the places of the others stay.
        for (index, end) in ended.last_first() {
            if let Some(flow) = self.runs[index].flow() {
                self.flows.remove(&flow);
            }
            self.runs[index].close(end.word(), &mut self.closing);
            match end.next_stage() {
                Ok(()) => match self.runs[index].begin_run() {
                    Some(done) => {
                        let run = self.runs.swap_remove(index);
                        run.free_slots(&mut self.free);
                        self.done(done);
                    }
                    None => continue,
                },
                Err(end) => {
                    let run = self.runs.swap_remove(index);
                    run.free_slots(&mut self.free);
                    if end.is_finished() {
                        self.team.finished();
                    }
                    let done = run.done(end);
                    self.done(done);
                }
            }
        }
    }

    /// A process is gone: the run that it was asked for alone has that fault, of several each is made again alone.
    fn fail(&mut self, program: usize, asked: &[usize], fault: ProgramFault) {
        self.closing[program].clear();
        if let ([_], true) = (self.runs.as_slice(), asked.contains(&0) || !self.suspects.is_empty()) {
            let mut ended = StageEnds::default();
            ended.add(0, self.runs[0].fault_of(program, fault));
            return self.end(ended);
        }
        // The same programs decide in all of them.
        for (index, mut run) in mem::take(&mut self.runs).into_iter().enumerate() {
            run.close("abandoned", &mut self.closing);
            run.free_slots(&mut self.free);
            let was_asked = asked.contains(&index);
            self.suspects.push_back(Suspect { job: run.into_job(), was_asked, fault: fault.clone() });
        }
        self.closing[program].clear();
        self.flows.clear();
    }

    /// Now and then, leaves off what nobody waits for any more.
    fn look(&mut self) {
        if self.looked.elapsed() < LOOK {
            return;
        }
        self.looked = Instant::now();
        let desk = &mut *self.desk;
        let unwanted: Vec<usize> =
            (0..self.runs.len()).filter(|run| !desk.is_wanted(self.runs[*run].place())).collect();
        for index in unwanted.into_iter().rev() {
            let mut run = self.runs.swap_remove(index);
            run.close("abandoned", &mut self.closing);
            if let Some(flow) = run.flow() {
                self.flows.remove(&flow);
            }
            run.free_slots(&mut self.free);
            self.suspects.pop_front();
        }
    }
}
