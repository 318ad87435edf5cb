//! The part of the terminal that changes while units run: how far everything is, and what is under way.

use std::collections::BTreeMap;
use std::time::Duration;

use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::progress::{Running, Tally};
use super::status;
use super::time_left::TimeLeft;
use crate::chart::shortened;
use crate::console::takes_blocks;
use crate::format::count;
use files::escape::terminal_line;

/// Drawn on standard error, below everything that is written.
pub struct Live {
    bar: ProgressBar,
}

/// What is over sooner is not drawn at all.
const PATIENCE: Duration = Duration::from_millis(500);
/// Units under way that are shown one by one.
const MOST_SHOWN: usize = 8;
const WIDEST_KEY: usize = 60;
const BAR: usize = 24;

impl Live {
    /// Only for a terminal.
    pub fn new() -> Self {
        let target = ProgressDrawTarget::stderr_with_hz(10);
        let style = ProgressStyle::with_template("{msg}").expect("the template is valid");
        Self { bar: ProgressBar::with_draw_target(None, target).with_style(style) }
    }

    /// Writes something that stays, above the part that changes.
    pub fn aside(&self, write: impl FnMut()) {
        self.bar.suspend(write);
    }

    pub(super) fn draw(&self, elapsed: Duration, panel: impl FnOnce() -> String) {
        if elapsed >= PATIENCE {
            self.bar.set_message(panel());
        }
    }

    /// Says what is done once nothing is under way any more.
    pub(super) fn say(&self, what: &str) {
        self.bar.set_message(format!("{:>12} {} …", "Judging", shortened(&terminal_line(what), WIDEST_KEY)));
        self.bar.tick();
    }

    pub(super) fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Default for Live {
    fn default() -> Self {
        Self::new()
    }
}

/// A line for everything and one for each unit under way.
pub(super) fn panel(tally: &Tally, running: &BTreeMap<usize, Running>, elapsed: Duration) -> String {
    let outline = &tally.outline;
    let units = outline.recorded + outline.trials + outline.blocks;
    let share = match outline.runs {
        0 => tally.units_done as f64 / units.max(1) as f64,
        runs => tally.runs_done as f64 / runs as f64,
    };
    let filled = ((share * BAR as f64) as usize).min(BAR);
    let bar = format!("{}{}", "=".repeat(filled), " ".repeat(BAR - filled));
    let mut said = vec![format!("{} of {}", tally.units_done, count(units, "unit"))];
    if outline.runs > 0 {
        let (done, all) = (HumanCount(tally.runs_done as u64), HumanCount(outline.runs as u64));
        said.push(format!("{done} of {all} runs"));
    }
    if tally.failures > 0 {
        said.push(format!("{} failed", tally.failures));
    }
    let left = tally.left(running, elapsed).map_or_else(String::new, TimeLeft::in_words);
    let mut text =
        format!("{:>12} {} [{bar}] {}{left}", "Running", status::seconds(elapsed), said.join(", "));
    let mut more = 0;
    for (index, one) in running.values().enumerate() {
        if index < MOST_SHOWN {
            let key = shortened(&terminal_line(&one.key), WIDEST_KEY);
            let course = if takes_blocks() { one.course() } else { String::new() };
            let time = status::seconds(one.begun.elapsed());
            text += &format!("\n{:>12} {time} {key}{}{course}", "", one.progress());
        } else {
            more += 1;
        }
    }
    if more > 0 {
        text += &format!("\n{:>12} and {more} more", "");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use results::{Evaluations, Workload};

    #[test]
    fn shows_how_far_everything_is() {
        let outline = Workload {
            suites: 1,
            trials: 3,
            runs: 40,
            certain_runs: 40,
            blocks: 1,
            recorded: 0,
            left_out: 0,
        };
        let mut tally = Tally { outline, units_done: 1, failures: 1, ..Tally::default() };
        let mut search = Running::new("zebra/search=low_pet", 0);
        search.evaluations = Some(Evaluations { done: 12, all: 48, best: Some(1.25), within: None });
        let mut trial = Running::new("zebra/scripted/tta=6s", 20);
        tally.begun = 2;
        (1..=9).for_each(|run| tally.run_done(1, Some(&mut trial), Duration::from_millis(300 * run)));
        tally.run_done(7, None, Duration::from_millis(3000));
        let text = panel(&tally, &BTreeMap::from([(1, trial), (2, search)]), Duration::from_secs(3));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines[0],
            "     Running [   3.000s] [======                  ] 1 of 4 units, 10 of 40 runs, 1 failed, more than 3 seconds left"
        );
        assert!(lines[1].ends_with("zebra/scripted/tta=6s: 9 of 20 runs"), "{text}");
        assert!(lines[2].contains("zebra/search=low_pet: 12 of 48 evaluations, best 1.25"), "{text}");
    }
}
