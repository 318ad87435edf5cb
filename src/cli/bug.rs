//! A panic outside of all runs: said to be a bug of ours, with an exit code of its own.

use super::Exit;
use report::console::stderr;
use runner::run::Panicked;

/// What `work` comes to. A panic that nobody caught is reported on standard error as a bug, with the run in which it
/// happened, if it was one.
pub fn guarded(work: impl FnOnce() -> Exit) -> Exit {
    Panicked::catch(work).unwrap_or_else(|panicked| {
        writeln!(
            stderr(),
            "error: {panicked}\nhelp: nothing is wrong with your files because of this; say what you called, with the \
             files and this message. What was to be done is not done."
        );
        Exit::Bug
    })
}
