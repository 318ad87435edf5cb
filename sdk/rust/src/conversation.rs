//! What is answered to the requests of the protocol, wherever they come from.

use std::io;

use serde::Deserialize;
use serde_json::{json, Value};

use crate::{wire, About, Controller, Run, Seen, PROTOCOL};

/// The program's side of a conversation.
pub struct Conversation<C> {
    about: About,
    tables: wire::Tables,
    slots: Vec<Option<Slot<C>>>,
    /// The frame that was answered last.
    pub answer: Vec<u8>,
}

/// What follows from a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reply {
    /// The answer stands ready.
    Answer,
    /// It is not answered.
    None,
    /// Nothing more will be asked.
    Bye,
}

#[derive(Deserialize)]
struct Opening {
    open: Option<Vec<Value>>,
    #[serde(default)]
    close: Vec<Closing>,
    bye: Option<Value>,
}

#[derive(Deserialize)]
struct Closing {
    slot: usize,
    #[serde(default)]
    reason: String,
}

/// A run, and what was decided last: beside a run that was refused, it is asked for again.
struct Slot<C> {
    controller: C,
    decided: Option<(f64, Vec<f64>)>,
}

impl<C: Controller> Conversation<C> {
    /// Begins with the runner's hello; what is answered to that as well.
    pub fn begin(about: &About, greeting: &Value) -> (Self, Value) {
        let hello = json!({"hello": {
            "protocol": PROTOCOL, "name": about.name, "version": about.version, "encoding": "f64", "tables": ["lanes", "kinds", "crossings"],
            "runs_at_once": about.runs_at_once, "gives": [about.gives], "modes": about.modes, "parameters": about.parameters,
        }});
        let slots = (0..about.runs_at_once).map(|_| None).collect();
        let tables = wire::Tables::of(&greeting["hello"]["columns"]);
        (Self { about: about.clone(), tables, slots, answer: Vec::new() }, hello)
    }

    /// Answers a frame, without its length.
    pub fn reply(&mut self, frame: &[u8]) -> io::Result<Reply> {
        if wire::word(frame, 0) == 0 {
            return self.text(frame.get(4..).unwrap_or_default());
        }
        let scenes = self.tables.scenes(frame)?;
        self.step(&scenes);
        Ok(Reply::Answer)
    }

    fn text(&mut self, text: &[u8]) -> io::Result<Reply> {
        let request: Opening = serde_json::from_slice(text)?;
        for Closing { slot, reason } in request.close {
            if let Some(mut slot) = self.slots.get_mut(slot).and_then(Option::take) {
                slot.controller.finish(&reason);
            }
        }
        if let Some(runs) = request.open {
            let (mut ready, mut failed) = (Vec::new(), Vec::new());
            for run in runs {
                let run: Run = serde_json::from_value(run)?;
                match C::start(&run) {
                    Ok(controller) if run.slot < self.slots.len() => {
                        self.slots[run.slot] = Some(Slot { controller, decided: None });
                        ready.push(run.slot);
                    }
                    Ok(_) => failed.push(json!({"slot": run.slot, "message": "there is no such slot"})),
                    Err(message) => failed.push(json!({"slot": run.slot, "message": message})),
                }
            }
            let answered = if failed.is_empty() {
                json!({ "ready": ready })
            } else {
                json!({"ready": ready, "failed": failed})
            };
            wire::text(&answered, &mut self.answer);
            return Ok(Reply::Answer);
        }
        Ok(if request.bye.is_some() { Reply::Bye } else { Reply::None })
    }

    fn step(&mut self, scenes: &[Seen]) {
        let mut refused = Vec::new();
        for seen in scenes {
            let Some(Some(slot)) = self.slots.get_mut(seen.slot) else {
                refused.push(json!({"slot": seen.slot, "message": "this run was never opened"}));
                continue;
            };
            if slot.decided.as_ref().is_some_and(|(time, _)| *time == seen.time) {
                continue;
            }
            match slot
                .controller
                .step(seen)
                .and_then(|answer| wire::row(&self.about, &answer, self.tables.steers))
            {
                Ok(row) => slot.decided = Some((seen.time, row)),
                Err(message) => refused.push(json!({"slot": seen.slot, "message": message})),
            }
        }
        if refused.is_empty() {
            let rows =
                scenes.iter().filter_map(|seen| Some(&self.slots[seen.slot].as_ref()?.decided.as_ref()?.1));
            wire::rows(rows, &mut self.answer);
        } else {
            wire::text(&json!({ "error": refused }), &mut self.answer);
        }
    }
}
