//! Parent mode: whoever started this process decides, and is asked on this process's own standard streams.

use std::fs::File;
use std::io::{self, Read, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use super::hello::Encoding;
use super::quote::quoted;
use super::wire::{self, MOST_LINES_BEFORE_HELLO, garbage};
use scenario::{FaultKind, ProgramFault};

/// Of what it says, read at once, bytes; so many of these are kept until somebody wants them.
const CHUNK: usize = 1 << 16;
const MOST_CHUNKS: usize = 4;

/// The streams to whoever started this process. It cannot be ended or started anew: once it has failed, it is not asked again.
pub struct Parent {
    /// What is to be written. A thread writes it, because a parent that does not read must not hold us.
    requests: Sender<Vec<u8>>,
    written: Receiver<io::Result<()>>,
    /// What it says; nothing at its end. A thread reads it, because a pipe has no deadline.
    said: Receiver<io::Result<Vec<u8>>>,
    /// What was read and is not used yet.
    left: Vec<u8>,
}

impl Parent {
    /// Asks on one stream and hears the answers on the other.
    ///
    /// # Errors
    /// If no threads can be started.
    pub fn new(answers: File, requests: File) -> io::Result<Self> {
        let (to_write, write) = channel();
        let (done, written) = channel();
        thread::Builder::new()
            .name("requests to the parent".into())
            .spawn(move || send(requests, &write, &done))?;
        let (heard, said) = sync_channel(MOST_CHUNKS);
        thread::Builder::new().name("answers of the parent".into()).spawn(move || hear(answers, &heard))?;
        Ok(Self { requests: to_write, written, said, left: Vec::new() })
    }

    /// Says hello, and gives what it says.
    ///
    /// # Errors
    /// If it does not say hello within that time.
    pub fn greet(&mut self, greeting: &str, limit: Duration) -> Result<String, ProgramFault> {
        let until = Instant::now() + limit;
        let mut said = Vec::new();
        self.send(format!("{greeting}\n").as_bytes(), until, limit)?;
        for _ in 0..=MOST_LINES_BEFORE_HELLO {
            self.line(&mut said, until, limit)?;
            if said.starts_with(b"{\"hello\"") {
                return Ok(String::from_utf8_lossy(&said).into_owned());
            }
        }
        let last = quoted(&said);
        Err(garbage(format!("it said more than {MOST_LINES_BEFORE_HELLO} lines, the last of them {last}")))
    }

    /// Sends a request, and reads what is answered into `answer`: a line, or a frame without its length.
    ///
    /// # Errors
    /// If there is no answer within that time, or none that could be one.
    pub fn exchange(
        &mut self,
        request: &[u8],
        encoding: Encoding,
        limit: Duration,
        answer: &mut Vec<u8>,
    ) -> Result<(), ProgramFault> {
        self.has_said_nothing()?;
        let until = Instant::now() + limit;
        self.send(request, until, limit)?;
        match encoding {
            Encoding::Json => self.line(answer, until, limit),
            Encoding::F64 => self.frame(answer, until, limit),
        }
    }

    /// Sends what is not answered.
    ///
    /// # Errors
    /// If it does not take it within that time.
    pub fn tell(&mut self, request: &[u8], limit: Duration) -> Result<(), ProgramFault> {
        self.send(request, Instant::now() + limit, limit)
    }

    /// Refuses what it says unasked.
    fn has_said_nothing(&mut self) -> Result<(), ProgramFault> {
        if let Ok(said) = self.said.try_recv() {
            self.left.extend(said.map_err(|error| unreachable(&error))?);
            if self.left.is_empty() {
                return Err(ended());
            }
        }
        if self.left.is_empty() {
            return Ok(());
        }
        Err(wire::unasked(&self.left))
    }

    fn send(&mut self, bytes: &[u8], until: Instant, limit: Duration) -> Result<(), ProgramFault> {
        self.requests.send(bytes.to_vec()).map_err(|_| ended())?;
        match self.written.recv_timeout(until.saturating_duration_since(Instant::now())) {
            Ok(Ok(())) => Ok(()),
            Ok(Err(error)) if error.kind() == io::ErrorKind::BrokenPipe => Err(ended()),
            Ok(Err(error)) => Err(unreachable(&error)),
            Err(RecvTimeoutError::Timeout) => Err(wire::late(limit)),
            Err(RecvTimeoutError::Disconnected) => Err(ended()),
        }
    }

    /// Reads more of what it says.
    fn more(&mut self, until: Instant, limit: Duration) -> Result<(), ProgramFault> {
        match self.said.recv_timeout(until.saturating_duration_since(Instant::now())) {
            Ok(Ok(said)) if said.is_empty() => Err(ended()),
            Ok(Ok(said)) => {
                self.left.extend(said);
                Ok(())
            }
            Ok(Err(error)) => Err(unreachable(&error)),
            Err(RecvTimeoutError::Timeout) => Err(wire::late(limit)),
            Err(RecvTimeoutError::Disconnected) => Err(ended()),
        }
    }

    /// The next line, with its end.
    fn line(&mut self, line: &mut Vec<u8>, until: Instant, limit: Duration) -> Result<(), ProgramFault> {
        let mut looked = 0;
        loop {
            if let Some(at) = self.left[looked..].iter().position(|byte| *byte == b'\n') {
                self.take(looked + at + 1, line);
                return Ok(());
            }
            looked = self.left.len();
            if looked > wire::LONGEST {
                return Err(garbage(wire::too_long(&self.left)));
            }
            self.more(until, limit)?;
        }
    }

    /// The next frame without its length.
    fn frame(&mut self, frame: &mut Vec<u8>, until: Instant, limit: Duration) -> Result<(), ProgramFault> {
        while self.left.len() < 4 {
            self.more(until, limit)?;
        }
        let mut length = [0; 4];
        length.copy_from_slice(&self.left[..4]);
        let size = wire::frame_size(length).map_err(garbage)?;
        while self.left.len() < 4 + size {
            self.more(until, limit)?;
        }
        self.left.drain(..4);
        self.take(size, frame);
        Ok(())
    }

    fn take(&mut self, size: usize, to: &mut Vec<u8>) {
        to.clear();
        to.extend(self.left.drain(..size));
    }
}

/// Writes each request and says what came of it, until nobody asks any more.
fn send(mut to: File, requests: &Receiver<Vec<u8>>, done: &Sender<io::Result<()>>) {
    for request in requests {
        let written = to.write_all(&request).and_then(|()| to.flush());
        let is_over = written.is_err();
        if done.send(written).is_err() || is_over {
            return;
        }
    }
}

/// Reads what it says until it says nothing more.
fn hear(mut from: File, heard: &SyncSender<io::Result<Vec<u8>>>) {
    let mut chunk = vec![0; CHUNK];
    loop {
        let read = match from.read(&mut chunk) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            read => read.map(|size| chunk[..size].to_vec()),
        };
        let is_over = read.as_ref().map_or(true, Vec::is_empty);
        if heard.send(read).is_err() || is_over {
            return;
        }
    }
}

fn ended() -> ProgramFault {
    ProgramFault::new(FaultKind::Exited, "the parent closed its streams".to_string())
}

fn unreachable(error: &io::Error) -> ProgramFault {
    ProgramFault::new(FaultKind::Exited, format!("the parent cannot be reached: {error}"))
}
