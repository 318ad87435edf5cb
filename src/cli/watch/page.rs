//! The HTML report that `o` opens: a file of ours, given to the program that the system opens such files with.

use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;

use crate::cli::store;
use report::console::{stderr, stdout};
use report::to_html;
use results::Results;

/// In the program's own folder.
const PAGE: &str = "watch.html";

/// Writes the report and has it opened.
pub fn open(results: &Results) {
    let path = Path::new(store::FOLDER).join(PAGE);
    if let Err(error) = store::write(PAGE, &to_html(results)) {
        return writeln!(stderr(), "error: cannot write {}: {error}", path.display());
    }
    writeln!(stdout(), "watch: wrote {}", path.display());
    let Ok(whole) = std::path::absolute(&path) else { return };
    let mut command = Command::new(opener());
    command.arg(whole).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    match command.spawn() {
        // Some of these programs end at once, some with the window.
        Ok(mut opened) => _ = thread::spawn(move || _ = opened.wait()),
        Err(error) => writeln!(stderr(), "note: `{}` does not open it: {error}", opener()),
    }
}

fn opener() -> &'static str {
    if cfg!(windows) {
        "explorer"
    } else if cfg!(target_os = "macos") {
        "open"
    } else {
        "xdg-open"
    }
}
