//! Progress bars, and whether they are drawn.

use std::env;

use indicatif::{ProgressBar, ProgressStyle};

use report::console::stderr;

/// Whether to show what is under way: to people at a terminal, and not in CI, whose logs keep every redrawing.
pub fn shows_progress(unwanted: bool) -> bool {
    !unwanted && stderr().is_terminal() && env::var_os("CI").is_none()
}

/// A bar with this template of `indicatif` for `all` steps; hidden unless `shown`.
pub fn bar(shown: bool, template: &str, all: u64) -> ProgressBar {
    if !shown {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(template).expect("the template is valid");
    ProgressBar::new(all).with_style(style.progress_chars("=> "))
}
