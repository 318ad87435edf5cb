//! What a program was asked and what it said in one run, as a file of lines that can be read and asked again.
//!
//! For each vehicle that a program drives: a line that says what it is, then the messages of the protocol in JSON, in slot 0, whichever
//! encoding and slot they went through.

use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde_json::{Value as Json, json};
use thiserror::Error;

use super::conversation::{AskedDecision, Conversation};
use super::wire::{self, Answered, DueDecision, Opened};
use scenario::ProgramFault;

/// Of the layout of these files.
const LAYOUT: u64 = 1;

/// The most that a line of such a file may hold, bytes.
const LONGEST: u64 = 16 << 20;

/// Writes down one run.
#[derive(Debug, Default)]
pub struct WireRecord {
    /// The key of the run.
    run: String,
    vehicles: Mutex<Vec<RecordedVehicle>>,
}

/// What was said about one vehicle.
#[derive(Debug)]
struct RecordedVehicle {
    index: usize,
    lines: Vec<Json>,
    is_over: bool,
}

/// Why such a file cannot be read.
#[derive(Debug, Error)]
pub enum WireRecordError {
    /// It is not there, or too long.
    #[error("{0}")]
    Unreadable(#[from] files::ReadError),
    /// In that line there is something else.
    #[error("line {0} is {1}")]
    Other(usize, String),
}

impl WireRecord {
    /// One of the run with that key.
    pub fn of(run: impl Into<String>) -> Self {
        Self { run: run.into(), vehicles: Mutex::default() }
    }

    /// The key of the run.
    pub fn run(&self) -> &str {
        &self.run
    }

    fn lock(&self) -> MutexGuard<'_, Vec<RecordedVehicle>> {
        self.vehicles.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(&self, vehicle: usize, lines: impl IntoIterator<Item = Json>) {
        let mut vehicles = self.lock();
        if let Some(known) = vehicles.iter_mut().find(|one| one.index == vehicle && !one.is_over) {
            known.lines.extend(lines);
        }
    }

    /// The run begins. If it is made once more because it did not come to its end, what was said before is forgotten.
    ///
    /// A free flow that it begins with is forgotten, too, unless the program fails in it.
    pub fn opened(&self, vehicle: usize, name: &str, run: &Opened, refused: Option<&ProgramFault>) {
        let mut vehicles = self.lock();
        if vehicles.iter().any(|one| one.index == vehicle && one.is_over) {
            return;
        }
        vehicles.retain(|one| one.index != vehicle);
        let mut open = wire::opened(run);
        open["slot"] = json!(0);
        let controller = run.setup.controller.model.name();
        let ready = match refused {
            None => json!({"ready": [0]}),
            Some(fault) => json!({"ready": [], "failed": [{"slot": 0, "message": fault.message}]}),
        };
        let head = json!({"wire": LAYOUT, "runner": env!("CARGO_PKG_VERSION"), "run": self.run, "vehicle": name,
            "controller": controller});
        vehicles.push(RecordedVehicle {
            index: vehicle,
            lines: vec![head, json!({"open": [open]}), ready],
            is_over: false,
        });
    }

    /// A decision was taken, or the program failed in it.
    pub fn decided(&self, vehicle: usize, asked: &DueDecision, answer: Result<&Answered, &ProgramFault>) {
        let scene = wire::scene(&DueDecision { slot: 0, ..*asked });
        let answer = match answer {
            Ok(Ok(decision)) => json!({"answer": [wire::said(decision)]}),
            Ok(Err(fault)) => json!({"error": [{"slot": 0, "message": fault.message}]}),
            Err(fault) => json!({"fault": {"kind": fault.kind.word(), "message": fault.message}}),
        };
        self.add(vehicle, [json!({"step": [scene]}), answer]);
    }

    /// The run has come to its end.
    pub fn closed(&self, reason: &str) {
        for vehicle in self.lock().iter_mut().filter(|one| !one.is_over) {
            vehicle.lines.push(json!({"close": [{"slot": 0, "reason": reason}]}));
            vehicle.is_over = true;
        }
    }

    /// All that was written down; nothing if no program decided in the run.
    pub fn text(&self) -> Option<String> {
        let mut vehicles = self.lock();
        vehicles.sort_by_key(|one| one.index);
        let lines: Vec<String> =
            vehicles.iter().flat_map(|one| &one.lines).map(|line| format!("{line}\n")).collect();
        (!lines.is_empty()).then(|| lines.concat())
    }
}

/// The conversations of a file.
///
/// # Errors
/// If it cannot be read, or is something else.
pub fn read_conversations(path: &Path) -> Result<Vec<Conversation>, WireRecordError> {
    let mut lines = files::Lines::open(path, LONGEST)?;
    let mut found: Vec<Conversation> = Vec::new();
    let mut number = 0;
    while let Some(line) = lines.next_line()? {
        number += 1;
        let other = |what: &str| WireRecordError::Other(number, what.to_string());
        let value: Json = serde_json::from_slice(line).map_err(|_| other("no JSON"))?;
        if let Some(layout) = value.get("wire") {
            if layout.as_u64() != Some(LAYOUT) {
                return Err(other(&format!("of layout {layout}, and this program reads {LAYOUT}")));
            }
            let text = |name: &str| value[name].as_str().unwrap_or_default().to_string();
            let name = format!("{} of {}", text("vehicle"), text("run"));
            let controller = text("controller");
            found.push(Conversation { name, controller, open: Json::Null, turns: Vec::new(), refused: None });
            continue;
        }
        let one = found.last_mut().ok_or_else(|| other("no beginning of what `--record-wire` writes"))?;
        if let Some(open) = value.get("open") {
            one.open = open[0].clone();
        } else if let Some(failed) = value.get("ready").and_then(|_| value.get("failed")) {
            one.refused = Some(failed[0]["message"].as_str().unwrap_or_default().to_string());
        } else if let Some(step) = value.get("step") {
            let (seen, is_new, signal) =
                wire::read_scene(&step[0]).ok_or_else(|| other("no scene of this protocol"))?;
            one.turns.push(AskedDecision { seen, is_new, signal, said: None });
        } else if let Some(answer) = value.get("answer") {
            let turn = one.turns.last_mut().ok_or_else(|| other("an answer to nothing"))?;
            turn.said = Some(answer[0].clone());
        }
    }
    if found.iter().any(|one| one.open.is_null()) {
        return Err(WireRecordError::Other(number, "the end, before a run is opened".to_string()));
    }
    Ok(found)
}
