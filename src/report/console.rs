//! Standard output and standard error: whatever the program says goes through here, and is either said or noted as lost.

use std::fmt;
use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use files::escape::{terminal, terminal_styled, without_commands};

/// One of the two standard streams. Writing to it never fails: when its reader has gone the rest is dropped, for that is the
/// reader's choice; any other [trouble](Self::trouble) is kept until the program ends, which then says so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Output {
    /// What was asked for: results and lists.
    Standard,
    /// What is to be known besides: progress and errors.
    Error,
}

/// For results.
pub fn stdout() -> Output {
    Output::Standard
}

/// For what is to be said about them.
pub fn stderr() -> Output {
    Output::Error
}

/// Whether standard output is somebody else's, so that what is said goes to standard error.
static IS_GIVEN: AtomicBool = AtomicBool::new(false);

/// Gives standard input and output, in this order, to who talks to another program on them: from now on all that is said goes to standard
/// error.
///
/// # Errors
/// If there are no such streams.
pub fn give_streams() -> io::Result<(File, File)> {
    stdout().flush();
    let streams = own_streams()?;
    IS_GIVEN.store(true, Ordering::Release);
    Ok(streams)
}

#[cfg(unix)]
#[allow(clippy::disallowed_methods, reason = "this is the one place that has them")]
fn own_streams() -> io::Result<(File, File)> {
    use std::os::fd::AsFd;
    let (input, output) = (io::stdin(), io::stdout());
    Ok((input.as_fd().try_clone_to_owned()?.into(), output.as_fd().try_clone_to_owned()?.into()))
}

#[cfg(windows)]
#[allow(clippy::disallowed_methods, reason = "this is the one place that has them")]
fn own_streams() -> io::Result<(File, File)> {
    use std::os::windows::io::AsHandle;
    let (input, output) = (io::stdin(), io::stdout());
    Ok((input.as_handle().try_clone_to_owned()?.into(), output.as_handle().try_clone_to_owned()?.into()))
}

/// Whether a terminal shows more than ASCII, as far as the language of this user tells; what is left out otherwise is only to be looked at.
pub fn takes_blocks() -> bool {
    let said = ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().filter_map(std::env::var_os);
    let locale =
        said.map(|value| value.to_string_lossy().to_ascii_lowercase()).find(|value| !value.is_empty());
    cfg!(windows) || locale.is_some_and(|locale| locale.contains("utf-8") || locale.contains("utf8"))
}

/// Why a stream takes nothing more.
#[derive(Debug)]
struct Broken(io::Error);

static BROKEN: [Mutex<Option<Broken>>; 2] = [Mutex::new(None), Mutex::new(None)];

impl Output {
    /// For `write!` and `writeln!`. Nothing in the text but line ends and tabs is obeyed by a terminal, and nothing by GitHub.
    pub fn write_fmt(self, arguments: fmt::Arguments) {
        self.put(&without_commands(&terminal(&arguments.to_string())));
    }

    /// Writes text that may be coloured; see [`terminal_styled`].
    pub fn styled(self, text: &str) {
        self.put(&without_commands(&terminal_styled(text)));
    }

    /// Writes what is not for people but for a file or another program, byte for byte unless people would see it.
    pub fn verbatim(self, text: &str) {
        if self.is_terminal() { self.put(&terminal(text)) } else { self.put(text) }
    }

    /// Whether people read it, as far as one can tell.
    pub fn is_terminal(self) -> bool {
        match self.taken() {
            Self::Standard => standard_output().is_terminal(),
            Self::Error => standard_error().is_terminal(),
        }
    }

    /// Whether to colour what is written if nobody says otherwise.
    pub fn takes_colour(self) -> bool {
        self.is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
    }

    /// Makes sure that everything was handed over.
    pub fn flush(self) {
        self.with(|stream| stream.flush());
    }

    /// What kept something from being written, unless it was that nobody reads it any more.
    pub fn trouble(self) -> Option<String> {
        let broken = BROKEN[self.taken() as usize].lock().unwrap_or_else(PoisonError::into_inner);
        let Broken(error) = broken.as_ref()?;
        (error.kind() != io::ErrorKind::BrokenPipe).then(|| error.to_string())
    }

    /// Whether it takes nothing more, for whatever reason.
    pub fn is_broken(self) -> bool {
        BROKEN[self.taken() as usize].lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// The stream that takes what is said.
    fn taken(self) -> Self {
        if IS_GIVEN.load(Ordering::Acquire) { Self::Error } else { self }
    }

    fn put(self, text: &str) {
        if !text.is_empty() {
            self.with(|stream| write_all(stream, text.as_bytes()));
        }
    }

    /// Does something with the stream unless it is broken, and notes if it breaks.
    fn with(self, work: impl FnOnce(&mut dyn Write) -> io::Result<()>) {
        let own = self.taken();
        let mut broken = BROKEN[own as usize].lock().unwrap_or_else(PoisonError::into_inner);
        if broken.is_some() {
            return;
        }
        let done = match own {
            Self::Standard => work(&mut standard_output().lock()),
            Self::Error => work(&mut standard_error().lock()),
        };
        *broken = done.err().map(Broken);
    }
}

/// As [`Write::write_all`], but waits for streams that somebody else has made non-blocking.
fn write_all(stream: &mut dyn Write, mut bytes: &[u8]) -> io::Result<()> {
    while !bytes.is_empty() {
        match stream.write(bytes) {
            Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
            Ok(written) => bytes = &bytes[written..],
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                thread::sleep(Duration::from_millis(1))
            }
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

#[allow(clippy::disallowed_methods, reason = "this is the one place that has it")]
fn standard_output() -> io::Stdout {
    io::stdout()
}

#[allow(clippy::disallowed_methods, reason = "this is the one place that has it")]
fn standard_error() -> io::Stderr {
    io::stderr()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes two bytes, then says once that it is busy, then two more, and so on.
    struct Slow(Vec<u8>, bool);

    impl Write for Slow {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.1 = !self.1;
            if self.1 {
                return Err(io::ErrorKind::WouldBlock.into());
            }
            let taken = bytes.len().min(2);
            self.0.extend(&bytes[..taken]);
            Ok(taken)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_slow_reader_gets_everything() {
        let mut slow = Slow(Vec::new(), false);
        write_all(&mut slow, b"twelve bytes").unwrap();
        assert_eq!(slow.0, b"twelve bytes");
    }
}
