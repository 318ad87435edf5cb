//! A progress bar on the terminal that keeps out of the way of the lines that report trials.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Counts runs. Drawn only while no trial has finished for a while, and never when stderr is not a terminal.
pub struct Progress {
    runs: u64,
    wanted: bool,
    begun: Instant,
    state: Mutex<State>,
}

struct State {
    done: u64,
    quiet_since: Instant,
    bar: Option<ProgressBar>,
}

/// How long nothing has to be reported before the bar shows.
const PATIENCE: Duration = Duration::from_millis(800);

const STYLE: &str = "{human_pos} of {human_len} runs [{wide_bar}] {per_sec}, {eta} left";

impl Progress {
    /// `runs` in all; nothing is ever drawn unless `wanted`.
    pub fn new(runs: u64, wanted: bool) -> Self {
        let begun = Instant::now();
        Self { runs, wanted, begun, state: Mutex::new(State { done: 0, quiet_since: begun, bar: None }) }
    }

    /// One more run is done.
    pub fn run_done(&self) {
        let mut state = self.lock();
        state.done += 1;
        if self.wanted && state.quiet_since.elapsed() > PATIENCE {
            let (done, begun) = (state.done, self.begun);
            let bar = state.bar.get_or_insert_with(|| {
                let bar =
                    ProgressBar::with_draw_target(Some(self.runs), ProgressDrawTarget::stderr_with_hz(5));
                let style = ProgressStyle::with_template(STYLE).expect("the template is valid");
                bar.with_style(style.progress_chars("=> ")).with_elapsed(begun.elapsed())
            });
            bar.set_position(done);
        }
    }

    /// A trial is about to be reported: its line needs the place.
    pub fn trial_done(&self) {
        let mut state = self.lock();
        state.quiet_since = Instant::now();
        if let Some(bar) = state.bar.take() {
            bar.finish_and_clear();
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
