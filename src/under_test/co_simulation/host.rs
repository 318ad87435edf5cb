//! The process of a unit: it loads the library, speaks the protocol on its standard streams, and has an instance for each run.
//!
//! Time of an instance begins at 0 with its first decision. At each one inputs are set to what is seen, the instance steps on by the
//! period, and its outputs then are the answer.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::ExitCode;

use ::fmu::{FmuRefusal, Instance, Kind, Library};
use serde_json::{Value as Json, json};

use super::plan::FmuPlan;
use super::signals::{RunRows, signals};
use super::wired::Wired;
use crate::wire::{CURVATURE_AHEAD, KINDS, LANES, PEDESTRIANS, RUNS, VEHICLES, text_frame};

/// More than a request may have, bytes.
const LONGEST_REQUEST: usize = 1 << 30;

/// Of a plan, bytes.
const LARGEST_PLAN: u64 = 64 << 20;

/// By which the period may miss a multiple of the step, relative to it.
const TOLERANCE: f64 = 1e-9;

/// Is the process of the unit with this plan until it is told goodbye.
pub fn host(plan: &Path) -> ExitCode {
    match Streams::take().and_then(|mut streams| {
        serve(plan, &mut streams).inspect_err(|error| streams.note(&error.to_string()))
    }) {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => ExitCode::FAILURE,
    }
}

/// What is said and answered, apart from what the library prints.
struct Streams {
    requests: BufReader<File>,
    answers: File,
}

impl Streams {
    /// Takes the standard streams; what a library prints is log from then on.
    #[cfg(unix)]
    fn take() -> io::Result<Self> {
        use std::os::fd::AsFd;

        #[expect(clippy::disallowed_methods, reason = "a program under test answers on its standard streams")]
        let (stdin, stdout, stderr) = (io::stdin(), io::stdout(), io::stderr());
        let requests = File::from(stdin.as_fd().try_clone_to_owned()?);
        let answers = File::from(stdout.as_fd().try_clone_to_owned()?);
        rustix::stdio::dup2_stdout(stderr.as_fd())?;
        Ok(Self { requests: BufReader::new(requests), answers })
    }

    /// Takes the standard streams. What a library prints there is garbage, and said to be.
    #[cfg(windows)]
    fn take() -> io::Result<Self> {
        use std::os::windows::io::AsHandle;

        #[expect(clippy::disallowed_methods, reason = "a program under test answers on its standard streams")]
        let (stdin, stdout) = (io::stdin(), io::stdout());
        let requests = File::from(stdin.as_handle().try_clone_to_owned()?);
        let answers = File::from(stdout.as_handle().try_clone_to_owned()?);
        Ok(Self { requests: BufReader::new(requests), answers })
    }

    /// A line of the log.
    #[expect(clippy::unused_self, reason = "whoever has the streams may write")]
    fn note(&self, line: &str) {
        #[expect(
            clippy::disallowed_methods,
            reason = "the log of a program under test is its standard error"
        )]
        let mut stderr = io::stderr();
        // Nobody reads the log of a process whose runner is gone.
        let _ = writeln!(stderr, "{line}");
    }

    fn answer(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.answers.write_all(bytes)?;
        self.answers.flush()
    }

    fn answer_text(&mut self, text: &Json) -> io::Result<()> {
        let mut frame = Vec::new();
        text_frame(&text.to_string(), &mut frame);
        self.answer(&frame)
    }

    /// The next frame without its length; `None` if there is none any more.
    fn next(&mut self) -> io::Result<Option<Vec<u8>>> {
        let mut length = [0; 4];
        match self.requests.read_exact(&mut length) {
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
            other => other?,
        }
        let size = u32::from_le_bytes(length) as usize;
        if !(4..=LONGEST_REQUEST).contains(&size) {
            return Err(invalid(format!("a request of {size} bytes")));
        }
        let mut frame = vec![0; size];
        self.requests.read_exact(&mut frame)?;
        Ok(Some(frame))
    }
}

fn invalid(message: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message.into())
}

fn serve(plan: &Path, streams: &mut Streams) -> io::Result<()> {
    let bytes = files::read_bytes(plan, LARGEST_PLAN).map_err(|error| invalid(error.to_string()))?;
    let plan: FmuPlan = serde_json::from_slice(&bytes)?;
    let library = load(&plan)?;
    let mut greeting = String::new();
    (&mut streams.requests).take(LONGEST_REQUEST as u64).read_line(&mut greeting)?;
    streams.answer(format!("{}\n", plan.hello).as_bytes())?;
    let mut host = Host { library: Some(library), slots: HashMap::new(), plan: &plan };
    while let Some(frame) = streams.next()? {
        match word(&frame, 0) {
            Some(1) => host.step(&frame, streams)?,
            Some(0) => {
                let request: Json = serde_json::from_slice(&frame[4..])?;
                if let Some(runs) = request.get("open").and_then(Json::as_array) {
                    host.open(runs, streams)?;
                } else if let Some(runs) = request.get("close").and_then(Json::as_array) {
                    runs.iter().filter_map(slot).for_each(|slot| _ = host.slots.remove(&slot));
                } else if request.get("bye").is_some() {
                    break;
                }
            }
            _ => return Err(invalid("a request of no known kind")),
        }
    }
    host.slots.clear();
    // Not every library can be taken out of a process; this one is about to end.
    std::mem::forget(host.library.take());
    Ok(())
}

fn load(plan: &FmuPlan) -> io::Result<Library> {
    Library::load(plan.place.clone()).map_err(|error| invalid(error.to_string()))
}

fn slot(run: &Json) -> Option<usize> {
    usize::try_from(run.get("slot")?.as_u64()?).ok()
}

fn word(frame: &[u8], index: usize) -> Option<u32> {
    frame.get(4 * index..)?.first_chunk().map(|bytes| u32::from_le_bytes(*bytes))
}

struct Host<'p> {
    /// Taken only to be loaded anew.
    library: Option<Library>,
    slots: HashMap<usize, HostedRun>,
    plan: &'p FmuPlan,
}

/// A run that is open.
struct HostedRun {
    instance: Instance,
    /// s
    period: f64,
    /// Decisions so far.
    decisions: u32,
    /// The time of a decision and what was decided, where it has to be said again: that another run of the same request failed
    /// must not make this one step twice.
    kept: Option<(f64, Vec<f64>)>,
}

impl Host<'_> {
    fn open(&mut self, runs: &[Json], streams: &mut Streams) -> io::Result<()> {
        let (mut ready, mut failed, mut is_last) = (Vec::new(), Vec::new(), false);
        for run in runs {
            let slot = slot(run).ok_or_else(|| invalid("a run without slot"))?;
            match self.begin(run, streams)? {
                Ok(run) => {
                    self.slots.insert(slot, run);
                    ready.push(slot);
                }
                Err(refusal) => {
                    is_last |= refusal.is_fatal;
                    failed.push(json!({"slot": slot, "message": refusal.message}));
                }
            }
        }
        streams.answer_text(&json!({"ready": ready, "failed": failed, "last": is_last}))
    }

    /// An instance with the parameters of a run.
    fn begin(&mut self, run: &Json, streams: &Streams) -> io::Result<Result<HostedRun, FmuRefusal>> {
        let step = run.get("step").and_then(Json::as_f64).ok_or_else(|| invalid("a run without step"))?;
        let period = self.plan.period.unwrap_or(step);
        let steps = (period / step).round();
        if steps < 1.0 || (period - steps * step).abs() > TOLERANCE * period {
            // Decisions would fall at other times than those that the instance is told.
            let message = format!("a period of {period} s is no multiple of the simulation step of {step} s");
            return Ok(Err(FmuRefusal { message, is_fatal: false }));
        }
        if self.plan.is_once_per_process && self.slots.is_empty() {
            // Nothing of the run before is left in it.
            drop(self.library.take());
            self.library = Some(load(self.plan)?);
        }
        let library = self.library.as_ref().expect("it was loaded");
        // All have one name: which slot a run is in decides nothing.
        let name = "scenario-runner";
        let instance = library.instance(name).and_then(|mut instance| {
            let given = run.get("parameters");
            let set =
                self.plan.parameters.iter().try_for_each(|one| {
                    set(&mut instance, one, given.and_then(|given| given.get(&one.name)))
                });
            instance.take_log().iter().for_each(|line| streams.note(line));
            set.map(|()| instance)
        });
        Ok(instance.map(|instance| HostedRun { instance, period, decisions: 0, kept: None }))
    }

    /// Decides in the runs of a request.
    fn step(&mut self, frame: &[u8], streams: &mut Streams) -> io::Result<()> {
        let count = |index: usize| word(frame, index).map(|count| count as usize);
        let (Some(runs), Some(pedestrians), Some(vehicles), Some(changes)) =
            (count(1), count(2), count(3), count(4))
        else {
            return Err(invalid("a step without counts"));
        };
        let doubles: Vec<f64> = frame[28.min(frame.len())..]
            .chunks_exact(8)
            .map(|bytes| f64::from_le_bytes(bytes.try_into().expect("eight of them")))
            .collect();
        let columns = RUNS.len() + LANES.len();
        let (first, second) = (runs * columns, pedestrians * (PEDESTRIANS.len() + KINDS.len()));
        let third = vehicles * VEHICLES.len();
        // How lanes bend ahead is no number: no unit is told of it.
        if doubles.len() != first + second + third + changes * CURVATURE_AHEAD.len() {
            return Err(invalid("a step with other rows than it says"));
        }
        let (rows, others) = doubles.split_at(first);
        let (pedestrians, vehicles) = others[..second + third].split_at(second);
        let (mut answers, mut failed, mut is_last) = (Vec::with_capacity(runs), Vec::new(), false);
        for (index, run) in rows.chunks_exact(columns).enumerate() {
            let slot = run[0] as usize;
            let hosted =
                self.slots.get_mut(&slot).ok_or_else(|| invalid("a step of a run that is not open"))?;
            let decided = hosted.decide(self.plan, &RunRows { run, pedestrians, vehicles, index });
            hosted.instance.take_log().iter().for_each(|line| streams.note(line));
            match decided {
                Ok(answer) => answers.push((slot, run[1], answer)),
                Err(refusal) => {
                    is_last |= refusal.is_fatal;
                    failed.push(json!({"slot": slot, "message": refusal.message}));
                }
            }
        }
        if !failed.is_empty() {
            for (slot, time, answer) in answers {
                if let Some(hosted) = self.slots.get_mut(&slot) {
                    hosted.kept = Some((time, answer));
                }
            }
            return streams.answer_text(&json!({"error": failed, "last": is_last}));
        }
        let columns = self.plan.outputs.len() + 1;
        let mut said = Vec::with_capacity(16 + 8 * runs * columns);
        for number in [12 + 8 * runs * columns, 2, runs, columns] {
            said.extend_from_slice(&(number as u32).to_le_bytes());
        }
        for (.., answer) in answers {
            let (own, curvature) = answer.split_at(answer.len() - usize::from(self.plan.steers()));
            // No mode.
            let row = own.iter().chain([&-1.0]).chain(curvature);
            row.for_each(|value| said.extend_from_slice(&value.to_le_bytes()));
        }
        streams.answer(&said)
    }
}

impl HostedRun {
    fn decide(&mut self, plan: &FmuPlan, rows: &RunRows) -> Result<Vec<f64>, FmuRefusal> {
        let now = rows.run[1];
        if let Some((_, answer)) = self.kept.take().filter(|(time, _)| *time == now) {
            return Ok(answer);
        }
        let seen = signals(rows);
        if self.decisions == 0 {
            self.instance.enter_initialisation()?;
            self.tell(plan, &seen)?;
            self.instance.exit_initialisation()?;
        }
        self.tell(plan, &seen)?;
        // The sum of all periods would drift.
        self.instance.step(f64::from(self.decisions) * self.period, self.period)?;
        self.decisions += 1;
        let said = plan.outputs.iter().map(|one| Ok(one.to_si(self.instance.get(one.kind, one.reference)?)));
        said.collect()
    }

    /// Sets the inputs, those of a kind together.
    fn tell(&mut self, plan: &FmuPlan, seen: &[f64]) -> Result<(), FmuRefusal> {
        for of_a_kind in plan.inputs.chunk_by(|(_, one), (_, next)| one.kind == next.kind) {
            let references: Vec<u32> = of_a_kind.iter().map(|(_, one)| one.reference).collect();
            let values: Vec<f64> = of_a_kind.iter().map(|(place, one)| one.of_si(seen[*place])).collect();
            self.instance.set(of_a_kind[0].1.kind, &references, &values)?;
        }
        Ok(())
    }
}

/// Sets a parameter to what a run has for it.
fn set(instance: &mut Instance, one: &Wired, value: Option<&Json>) -> Result<(), FmuRefusal> {
    let refused = |message: String| FmuRefusal { message, is_fatal: false };
    let number = match (value, one.kind) {
        (Some(Json::String(text)), Kind::Text) => return instance.set_text(one.reference, text),
        (Some(Json::String(word)), _) => {
            one.items.iter().find(|(item, _)| item == word).map(|(_, number)| *number as f64)
        }
        (Some(Json::Bool(flag)), _) => Some(f64::from(u8::from(*flag))),
        (Some(Json::Number(number)), _) => number.as_f64().map(|si| one.of_si(si)),
        _ => None,
    };
    let number = number.filter(|_| one.kind != Kind::Text).ok_or_else(|| {
        let value = value.map_or_else(|| "nothing".to_string(), ToString::to_string);
        refused(format!("its variable `{}` cannot be {value}", one.variable))
    })?;
    instance.set(one.kind, &[one.reference], &[number])
}
