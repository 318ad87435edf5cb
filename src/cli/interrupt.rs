//! Ctrl-C: once, and no more runs begin; twice, and the program ends at once.

use super::Exit;
use report::console::stderr;
use runner::run::Stop;

/// The wish of whoever presses Ctrl-C (or ends the program by a signal, as CI servers do when a job is cancelled).
pub fn stop_on_interrupt() -> Stop {
    let stop = Stop::default();
    let wish = stop.clone();
    let heard = ctrlc::set_handler(move || {
        if wish.is_requested() {
            std::process::exit(i32::from(Exit::Interrupted as u8));
        }
        wish.request();
    });
    if let Err(error) = heard {
        writeln!(stderr(), "warning: Ctrl-C will end the program without a report: {error}");
    }
    stop
}
