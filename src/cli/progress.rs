//! Whether what is under way is drawn.

use std::env;

use report::console::stderr;

/// Whether to show what is under way: to people at a terminal, and not in CI, whose logs keep every redrawing.
pub fn shows_progress(unwanted: bool) -> bool {
    !unwanted && stderr().is_terminal() && env::var_os("CI").is_none()
}
