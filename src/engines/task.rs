//! What engines are given and what they tell: tasks, and how each ended.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::PathBuf;

use serde::Serialize;

use super::error::EngineError;

/// A task whose worker was lost this often is given up: it may be the task that ends its workers.
pub(super) const MOST_ATTEMPTS: usize = 4;

/// A command that some machine is to do.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Task {
    /// By which it is told of; of one call no two are the same.
    pub id: String,
    /// The program, by an absolute path that leads to it on every machine, and its arguments.
    pub argv: Vec<String>,
    /// The file, on a disk that all machines share, to which its standard output and error go. What was there is replaced.
    pub out: PathBuf,
    /// Processor cores that it takes.
    pub cpus: u32,
    /// What else it takes of a machine, such as `av_stack: 1`.
    pub resources: BTreeMap<String, f64>,
}

/// How a task ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TaskEnd {
    /// With this exit code. As shells say it: 126 and 127 for a program that cannot be started, 128 and the number of the signal for one that
    /// a signal ended.
    Exited(i32),
    /// It never came to an end: why not.
    Lost(String),
}

/// A task that is over.
#[derive(Debug, Clone, PartialEq)]
pub struct EndedTask {
    /// The task's.
    pub id: String,
    /// How.
    pub end: TaskEnd,
    /// The machine that did it; empty if none did.
    pub node: String,
    /// What that took there, wall time, s.
    pub seconds: f64,
}

/// What happens while tasks are done.
#[derive(Debug, Clone, PartialEq)]
pub enum EngineEvent {
    /// The engine is there: what it is.
    Ready(String),
    /// Something that a user should know, in a sentence.
    Notice(String),
    /// How many tasks the engine has yet to begin, and how many it says it is at.
    Standing {
        /// Not begun.
        waiting: usize,
        /// Begun.
        running: usize,
    },
    /// A task is over.
    Ended(EndedTask),
}

impl fmt::Display for EngineEvent {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Ready(what) | Self::Notice(what) => write!(f, "{what}"),
            Self::Standing { waiting, running } => write!(f, "{waiting} tasks wait, {running} run"),
            Self::Ended(EndedTask { id, end: TaskEnd::Exited(code), node, seconds }) => {
                write!(f, "{id} ended with exit code {code} after {seconds:.1} s on {node}")
            }
            Self::Ended(EndedTask { id, end: TaskEnd::Lost(why), .. }) => {
                write!(f, "{id} is given up: {why}")
            }
        }
    }
}

/// Has tasks done somewhere.
pub trait Engine {
    /// Has all of them done, says of each that it is over once that is so, and gives back how they ended, in the order of `tasks`. Once `stop`
    /// says so, what has not ended is ended, and nothing of it stays.
    ///
    /// # Errors
    /// If the engine is missing, refuses the tasks or fails, and [`EngineError::Stopped`] if it was stopped. Then nothing is known of tasks that
    /// were not told of.
    fn run(
        &self,
        tasks: &[Task],
        stop: &dyn Fn() -> bool,
        told: &mut dyn FnMut(EngineEvent),
    ) -> Result<Vec<EndedTask>, EngineError>;
}

/// The tasks of one call, and how those ended that have: each once.
#[derive(Debug)]
pub(super) struct Ledger<'a> {
    tasks: &'a [Task],
    ended: BTreeMap<&'a str, EndedTask>,
}

impl<'a> Ledger<'a> {
    /// # Errors
    /// If two tasks have one id, or one of them no program.
    pub fn new(tasks: &'a [Task]) -> Result<Self, EngineError> {
        let mut ids = BTreeSet::new();
        for task in tasks {
            if !ids.insert(task.id.as_str()) {
                return Err(EngineError::Refused(format!("two tasks are called `{}`", task.id)));
            }
            if task.argv.first().is_none_or(String::is_empty) {
                return Err(EngineError::Refused(format!("the task `{}` has no program", task.id)));
            }
        }
        Ok(Self { tasks, ended: BTreeMap::new() })
    }

    /// Notes that a task is over.
    ///
    /// # Errors
    /// If there is none of that id, or if it was over already.
    pub fn note(&mut self, ended: EndedTask) -> Result<&EndedTask, EngineError> {
        let Some(task) = self.tasks.iter().find(|task| task.id == ended.id) else {
            return Err(EngineError::Failed(format!(
                "it told of a task `{}`, which it was not given",
                ended.id
            )));
        };
        if self.ended.contains_key(task.id.as_str()) {
            return Err(EngineError::Failed(format!("it told twice that the task `{}` is over", task.id)));
        }
        Ok(self.ended.entry(&task.id).or_insert(ended))
    }

    pub fn is_complete(&self) -> bool {
        self.ended.len() == self.tasks.len()
    }

    /// How they ended, in the order of the tasks.
    ///
    /// # Errors
    /// If one has not.
    pub fn finish(mut self) -> Result<Vec<EndedTask>, EngineError> {
        let ended = |task: &Task| {
            let message = || EngineError::Failed(format!("it never told of the task `{}`", task.id));
            self.ended.remove(task.id.as_str()).ok_or_else(message)
        };
        self.tasks.iter().map(ended).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn task(id: &str) -> Task {
        let argv = vec!["/bin/true".to_string()];
        Task { id: id.to_string(), argv, out: PathBuf::from("out"), cpus: 1, resources: BTreeMap::new() }
    }

    fn ended(id: &str) -> EndedTask {
        EndedTask { id: id.to_string(), end: TaskEnd::Exited(0), node: "one".to_string(), seconds: 0.5 }
    }

    #[test]
    fn a_task_that_was_not_told_of_is_not_taken_for_done() {
        let tasks = [task("a"), task("b")];
        let mut ledger = Ledger::new(&tasks).unwrap();
        ledger.note(ended("b")).unwrap();
        assert!(!ledger.is_complete());
        let error = ledger.finish().unwrap_err();
        assert_eq!(error.to_string(), "the engine failed: it never told of the task `a`");
    }

    #[test]
    fn tasks_are_given_back_in_their_order_and_each_once() {
        let tasks = [task("a"), task("b")];
        let mut ledger = Ledger::new(&tasks).unwrap();
        ledger.note(ended("b")).unwrap();
        assert!(ledger.note(ended("b")).unwrap_err().to_string().contains("told twice"));
        assert!(ledger.note(ended("c")).unwrap_err().to_string().contains("was not given"));
        ledger.note(ended("a")).unwrap();
        assert_eq!(ledger.finish().unwrap(), [ended("a"), ended("b")]);
    }

    #[test]
    fn what_is_told_is_a_sentence_and_names_how_it_ended() {
        let lost = EndedTask { end: TaskEnd::Lost("its worker ended".to_string()), ..ended("a") };
        let said = [EngineEvent::Ended(ended("a")), EngineEvent::Ended(lost)].map(|event| event.to_string());
        assert_eq!(said, ["a ended with exit code 0 after 0.5 s on one", "a is given up: its worker ended"]);
    }

    #[test]
    fn tasks_that_cannot_be_told_apart_or_started_are_refused() {
        let nothing = Task { argv: vec![], ..task("a") };
        assert!(Ledger::new(&[task("a"), task("a")]).is_err());
        assert!(Ledger::new(&[nothing]).is_err());
    }
}
