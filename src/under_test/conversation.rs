//! What a program is told of one run and what it said, to be had with it again.

use serde_json::{Value as Json, json};

use super::process::{Failed, Process};
use super::wire::{self, Answered, DueDecision};
use scenario::ProgramFault;
use sim::Observation;

use std::time::Duration;

/// What a program is told of one run, whatever it answers.
#[derive(Debug, Clone)]
pub struct Conversation {
    /// Of which scene or run, in words.
    pub name: String,
    /// The controller that it was had with.
    pub controller: String,
    /// What is said of the run before it begins, without its slot.
    pub open: Json,
    /// In their order.
    pub turns: Vec<AskedDecision>,
    /// Why the program refused the run, where it did.
    pub refused: Option<String>,
}

/// A decision that is asked for.
#[derive(Debug, Clone)]
pub struct AskedDecision {
    /// What is seen from the vehicle.
    pub seen: Observation,
    /// Whether it is the first of its run.
    pub is_new: bool,
    /// At a signal: whether vehicles have green.
    pub signal: Option<bool>,
    /// What was said, where that was written down; nothing where the program failed instead.
    pub said: Option<Json>,
}

/// Where two conversations part.
#[derive(Debug, Clone, PartialEq)]
pub struct AnswerDifference {
    /// Of which scene or run.
    pub name: String,
    /// Of the decision, s; nothing where the run is opened.
    pub time: Option<f64>,
    /// What was said before.
    pub before: String,
    /// What was said now.
    pub now: String,
}

/// What a program said in a conversation, up to where it failed.
#[derive(Debug, Default)]
pub struct Spoken {
    /// For each turn.
    pub said: Vec<Result<Json, ProgramFault>>,
    /// Why it could not be opened.
    pub refused: Option<ProgramFault>,
    /// Wall time of each answer.
    pub times: Vec<Duration>,
}

impl Conversation {
    /// Its opening in a slot.
    pub(super) fn opening(&self, slot: usize) -> Json {
        let mut open = self.open.clone();
        open["slot"] = json!(slot);
        open
    }

    /// A decision that it asks for in a slot; the period (s) is that of the program.
    pub(super) fn due(&self, turn: usize, slot: usize, period: f64) -> DueDecision<'_> {
        let AskedDecision { seen, is_new, signal, .. } = &self.turns[turn];
        DueDecision { slot, is_new: *is_new, seen, period, signal: *signal }
    }

    /// That a process was gone in it; nothing if it was so before.
    pub(super) fn failed(&self, fault: &ProgramFault) -> Option<AnswerDifference> {
        let failed_before = self.turns.last().is_some_and(|turn| turn.said.is_none());
        let before = if self.turns.is_empty() { "no answer" } else { "an answer to every request" };
        let (name, before, now) = (self.name.clone(), before.to_string(), first_line(fault));
        (!failed_before).then_some(AnswerDifference { name, time: None, before, now })
    }

    /// What was said otherwise than in this conversation, if anything was.
    pub fn difference(&self, spoken: &Spoken) -> Option<AnswerDifference> {
        let differs = |time, before: String, now: String| AnswerDifference {
            name: self.name.clone(),
            time,
            before,
            now,
        };
        let now = spoken.refused.as_ref().map(|fault| fault.message.clone());
        if now != self.refused {
            let shown = |refused: Option<String>| {
                refused.map_or("ready".to_string(), |why| format!("refused: {why}"))
            };
            return Some(differs(None, shown(self.refused.clone()), shown(now)));
        }
        let shown = |said: Option<&Json>| said.map_or("no answer".to_string(), Json::to_string);
        self.turns.iter().zip(&spoken.said).find_map(|(turn, now)| match now {
            Ok(now) if turn.said.as_ref() == Some(now) => None,
            Ok(now) => Some(differs(Some(turn.seen.time), shown(turn.said.as_ref()), now.to_string())),
            Err(_) if turn.said.is_none() => None,
            Err(fault) => Some(differs(Some(turn.seen.time), shown(turn.said.as_ref()), first_line(fault))),
        })
    }
}

/// A fault without its last words.
pub fn first_line(fault: &ProgramFault) -> String {
    fault.to_string().lines().next().unwrap_or_default().to_string()
}

/// Has conversations with a process side by side, each in its slot, a turn of each in every request.
///
/// # Errors
/// If it does not do its part. The process is then gone.
pub fn converse(
    process: &mut Process,
    conversations: &[(&Conversation, usize)],
    period: f64,
) -> Result<Vec<Spoken>, Failed> {
    let mut spoken: Vec<Spoken> = conversations.iter().map(|_| Spoken::default()).collect();
    let openings: Vec<Json> = conversations.iter().map(|(one, slot)| one.opening(*slot)).collect();
    let slots: Vec<usize> = conversations.iter().map(|(_, slot)| *slot).collect();
    for (slot, fault) in process.open_as(&json!({ "open": openings }), &slots)? {
        if let Some(index) = slots.iter().position(|one| *one == slot) {
            spoken[index].refused = Some(fault);
        }
    }
    let longest = conversations.iter().map(|(one, _)| one.turns.len()).max().unwrap_or(0);
    for turn in 0..longest {
        let goes_on = |index: &usize| {
            let has_failed =
                spoken[*index].refused.is_some() || spoken[*index].said.last().is_some_and(Result::is_err);
            !has_failed && turn < conversations[*index].0.turns.len()
        };
        let going: Vec<usize> = (0..conversations.len()).filter(goes_on).collect();
        let asked: Vec<DueDecision> =
            going.iter().map(|index| conversations[*index].0.due(turn, slots[*index], period)).collect();
        if asked.is_empty() {
            break;
        }
        let (answers, time) = process.decide(&asked)?;
        for (index, answer) in going.into_iter().zip(answers) {
            let said: Answered = answer;
            spoken[index].said.push(said.map(|decision| wire::said(&decision)));
            spoken[index].times.push(time);
        }
    }
    let closing: Vec<(usize, &str)> = slots.iter().map(|slot| (*slot, "completed")).collect();
    process.close(&closing)?;
    process.confirm()?;
    Ok(spoken)
}
