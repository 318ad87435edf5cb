//! Why a unit could not be run to its end: in words, and with the runs that a program kept from their ends.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use super::outcome::Outcome;
use scenario::{Dimension, FaultKind, ProgramFault, show};

/// Faults whose logs are kept: there may be a million of them.
const MOST_LOGS: usize = 3;

/// Why a unit could not be run to its end.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct UnitError {
    /// Everything that there is to say, the gist in its first line.
    pub message: String,
    /// The runs that programs kept from their ends, in their order; empty for other errors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<RunFault>,
    /// The runs of a trial with faults that came to their ends. They are shown and nothing is judged by them, since they are not all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub finished: Vec<Outcome>,
}

/// A run that a program kept from its end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunFault {
    /// The run's key, which `scenario-runner replay` takes.
    pub run: String,
    /// The vehicle for which the program decides.
    pub vehicle: String,
    /// When it was asked, s; negative while settling before the start.
    pub time: f64,
    /// What the program did; of all but the first few of a trial without the end of its log.
    #[serde(flatten)]
    pub fault: ProgramFault,
}

impl UnitError {
    /// Of runs that programs kept from their ends; the message begins with how many of how many they are, unless there is one run only.
    /// `messages` has a text for each of the faults.
    pub fn of_faults(mut faults: Vec<RunFault>, messages: &[String], finished: Vec<Outcome>) -> Self {
        const MOST_SAID: usize = 10;
        let made = faults.len() + finished.len();
        let message = match (messages, made) {
            ([only], 1) => only.clone(),
            _ => {
                let mut kinds: Vec<FaultKind> = faults.iter().map(|one| one.fault.kind).collect();
                kinds.sort_unstable();
                kinds.dedup();
                let kinds: Vec<_> = kinds.into_iter().map(FaultKind::word).collect();
                let mut message =
                    format!("{} of {made} runs ended in a fault ({})", faults.len(), kinds.join(", "));
                let others = faults.iter().skip(1).map(RunFault::in_words).take(MOST_SAID);
                let said = messages.first().cloned().into_iter().chain(others);
                said.for_each(|one| message.extend(["\n", &one]));
                let left = faults.len().saturating_sub(1 + MOST_SAID);
                if left > 0 {
                    message.push_str(&format!("\nand {left} more"));
                }
                message
            }
        };
        faults.iter_mut().skip(MOST_LOGS).for_each(|one| one.fault.log_tail = Vec::new());
        Self { message, faults, finished }
    }

    /// How many runs were made, with those that did not come to their ends.
    pub fn made(&self) -> usize {
        self.faults.len() + self.finished.len()
    }

    /// What it is about, in a line.
    pub fn first_line(&self) -> &str {
        self.message.lines().next().unwrap_or_default()
    }
}

impl RunFault {
    /// In one line: run, controller, time and what happened.
    pub fn in_words(&self) -> String {
        let Self { run, time, fault, .. } = self;
        let seconds = show(time.abs(), None, Dimension::TIME);
        let moment =
            if *time < 0.0 { format!("{seconds} before the start") } else { format!("at {seconds}") };
        format!("{run}: `{}` {moment}: {}", fault.controller, fault.summary())
    }
}

impl From<String> for UnitError {
    fn from(message: String) -> Self {
        Self { message, ..Self::default() }
    }
}

impl Display for UnitError {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        out.write_str(&self.message)
    }
}
