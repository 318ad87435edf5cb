//! What a program writes besides its answers: the end of its log in memory, all of it in a file.

use std::collections::VecDeque;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

/// Kept in memory, bytes.
const TAIL: usize = 64 << 10;

/// LogState to the file, bytes.
const MOST: usize = 16 << 20;

/// Lines that a fault quotes.
const LAST: usize = 20;

/// The log of one process.
#[derive(Debug)]
pub struct ProgramLog {
    path: Option<PathBuf>,
    state: Mutex<LogState>,
    ended: Condvar,
}

#[derive(Debug, Default)]
struct LogState {
    tail: VecDeque<u8>,
    written: usize,
    has_ended: bool,
}

impl ProgramLog {
    /// One whose text goes to the file, too; what stood there is replaced.
    pub fn new(path: Option<PathBuf>) -> Self {
        let path = path.filter(|path| files::write(path, "").is_ok());
        Self { path, state: Mutex::default(), ended: Condvar::new() }
    }

    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    pub fn add(&self, bytes: &[u8]) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.tail.extend(bytes);
        let too_much = state.tail.len().saturating_sub(TAIL);
        state.tail.drain(..too_much);
        let room = MOST.saturating_sub(state.written).min(bytes.len());
        if let Some(path) = self.path.as_ref().filter(|_| room > 0) {
            // A log that cannot be written is no reason to end a run; what is quoted is in memory.
            let _ = files::append_text(path, &String::from_utf8_lossy(&bytes[..room]));
            state.written += room;
        }
    }

    /// Takes in all that there is to read.
    pub fn drain(&self, mut from: impl Read) {
        let mut buffer = [0; 8192];
        while let Ok(read @ 1..) = from.read(&mut buffer) {
            self.add(&buffer[..read]);
        }
        self.state.lock().unwrap_or_else(PoisonError::into_inner).has_ended = true;
        self.ended.notify_all();
    }

    /// The last lines; of a process that has ended, all that it wrote comes first.
    pub fn last_lines(&self, has_ended: bool) -> Vec<String> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if has_ended && !state.has_ended {
            let wait = self.ended.wait_timeout_while(state, Duration::from_secs(1), |state| !state.has_ended);
            state = wait.unwrap_or_else(PoisonError::into_inner).0;
        }
        let text = String::from_utf8_lossy(state.tail.make_contiguous()).into_owned();
        let lines: Vec<&str> = text.lines().collect();
        lines[lines.len().saturating_sub(LAST)..].iter().map(ToString::to_string).collect()
    }
}
