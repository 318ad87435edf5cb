//! What happens while is watched, in the order in which it does, and what is done about it.

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::thread::{self, Scope};
use std::time::{Duration, Instant};

use super::happened::Happened;
use super::keys::{HELP, Key};
use super::one_run::{Ended, Wishes};
use super::{page, told};
use crate::cli::Exit;
use files::{Changes, RecordingDisk};
use lang::Style;
use lang::filter::Filters;
use report::console::{stderr, stdout};
use report::count;
use results::Results;
use runner::run::Stop;
use runner::watch::{Agenda, Extent, Quiet, SuiteState};

/// How often it is looked for changes where the system tells of them: it need not tell of all.
const LOOK: Duration = Duration::from_secs(1);
/// How often where it does not.
const POLL: Duration = Duration::from_millis(300);

/// A file that is watched.
struct Watched {
    file: String,
    /// What its last run read, or what the one under way has read so far.
    recording: RecordingDisk,
    /// What the run before read.
    before: RecordingDisk,
    /// Whether that is known to have changed, so that nobody need look any more.
    stale: bool,
}

/// Everything that is watched.
pub struct Watching<'w> {
    wishes: &'w Wishes<'w>,
    filters: Arc<Filters>,
    watched: Vec<Watched>,
    agenda: Agenda,
    quiet: Quiet,
    /// Since when times are counted.
    begun: Instant,
    looked: Instant,
    look_took: Duration,
    /// Whether something may have changed since.
    is_hinted: bool,
    /// `None` if nobody tells of changes.
    changes: Option<Changes>,
    sender: Sender<Happened>,
    /// Of the run under way, with how much of its suite it runs.
    running: Option<(Stop, Extent)>,
    /// Of the last run that came to its end, with whose it is.
    last: Option<(usize, Results)>,
    has_keys: bool,
    is_typing: bool,
    /// Whether it has been said that it waits.
    is_waiting: bool,
    exit: Option<Exit>,
}

impl<'w> Watching<'w> {
    pub fn new(
        wishes: &'w Wishes<'w>,
        filters: Arc<Filters>,
        files: Vec<String>,
        sender: Sender<Happened>,
        has_keys: bool,
    ) -> Self {
        let extent = if wishes.arguments.select.last_failed { Extent::Failed } else { Extent::Selected };
        let hints = sender.clone();
        let changes = (!wishes.arguments.poll).then(|| Changes::new(move || _ = hints.send(Happened::Hint)));
        let changes = changes.and_then(|changes| changes.map_err(|error| looked_for(&error)).ok());
        let watched = |file| Watched {
            file,
            recording: RecordingDisk::default(),
            before: RecordingDisk::default(),
            stale: false,
        };
        Self {
            wishes,
            filters,
            agenda: Agenda::new(files.len(), extent),
            watched: files.into_iter().map(watched).collect(),
            quiet: Quiet::default(),
            begun: Instant::now(),
            looked: Instant::now(),
            look_took: Duration::ZERO,
            is_hinted: false,
            changes,
            sender,
            running: None,
            last: None,
            has_keys,
            is_typing: false,
            is_waiting: false,
            exit: None,
        }
    }

    /// Until somebody wishes to end it.
    pub fn run(mut self, receiver: &Receiver<Happened>) -> Exit {
        thread::scope(|scope| {
            loop {
                if self.running.is_none() {
                    match self.exit {
                        Some(exit) => return exit,
                        None => self.go_on(scope),
                    }
                }
                match receiver.recv_timeout(self.pause()) {
                    Ok(happened) => self.happened(happened),
                    Err(RecvTimeoutError::Timeout) => {}
                    // There is always a sender: that of this one.
                    Err(RecvTimeoutError::Disconnected) => return Exit::Interrupted,
                }
                // Nobody reads what is said any more.
                if self.exit.is_none() && stdout().is_broken() {
                    self.end(Exit::Interrupted);
                }
                if (self.is_hinted || self.looked.elapsed() >= self.every())
                    && self.is_quiet()
                    && !self.look()
                {
                    self.quiet.settled();
                }
            }
        })
    }

    /// From one look to the next: looking takes 5 % of the time at most.
    fn every(&self) -> Duration {
        let every = if self.changes.is_some() { LOOK } else { POLL };
        every.max(20 * self.look_took)
    }

    fn is_quiet(&self) -> bool {
        self.quiet.left(self.begun.elapsed()).is_zero()
    }

    /// How long nothing has to be done.
    fn pause(&self) -> Duration {
        let left = self.quiet.left(self.begun.elapsed());
        if left.is_zero() { POLL } else { left.min(POLL) }
    }

    /// Looks what has changed. What is under way and concerned is stopped.
    fn look(&mut self) -> bool {
        let begun = Instant::now();
        self.is_hinted = false;
        let mut found = false;
        for index in 0..self.watched.len() {
            if self.watched[index].stale {
                continue;
            }
            let changed = self.watched[index].recording.changed();
            if !changed.is_empty() {
                found = true;
                self.changed(index, &changed);
            }
        }
        (self.looked, self.look_took) = (Instant::now(), begun.elapsed());
        found
    }

    fn changed(&mut self, index: usize, changed: &BTreeSet<PathBuf>) {
        self.watched[index].stale = true;
        self.quiet.disturbed(self.begun.elapsed());
        self.is_waiting = false;
        if self.last.as_ref().is_some_and(|(of, _)| *of == index) {
            self.last = None;
        }
        let is_running = self.agenda.changed(index) && self.running.is_some();
        let what = if is_running { "is stopped and runs" } else { "runs" };
        let file = &self.watched[index].file;
        writeln!(stdout(), "watch: {} changed: {file} {what} again", told::paths(changed));
        stdout().flush();
        if is_running {
            self.stop();
        }
    }

    fn stop(&self) {
        self.running.iter().for_each(|(stop, _)| stop.request());
    }

    /// Begins what is due, once nothing changes any more.
    fn go_on<'s, 'e>(&mut self, threads: &'s Scope<'s, 'e>)
    where
        'w: 's,
    {
        // What has changed by now is run as a whole, and nothing is said of what stood there before.
        if self.is_waiting || self.is_typing || !self.is_quiet() || self.look() {
            return;
        }
        self.quiet.settled();
        let Some((index, extent)) = self.agenda.begin() else { return self.wait() };
        let stop = Stop::default();
        self.running = Some((stop.clone(), extent));
        let watched = &mut self.watched[index];
        watched.before = std::mem::take(&mut watched.recording);
        watched.stale = false;
        let (file, recording) = (watched.file.clone(), watched.recording.clone());
        if self.watched.len() > 1 {
            writeln!(stdout(), "watch: {file}");
        }
        let (wishes, filters, sender) = (self.wishes, self.filters.clone(), self.sender.clone());
        threads.spawn(move || {
            let run = || Box::new(wishes.run(&file, extent, &filters, &recording, &stop));
            _ = sender.send(Happened::Ended(catch_unwind(AssertUnwindSafe(run))));
        });
    }

    /// Says what is known of everything, and that nothing happens until something changes.
    fn wait(&mut self) {
        self.is_waiting = true;
        self.tell_folders();
        let colour = self.wishes.arguments.conduct.shown.color.wanted(stdout());
        for (index, one) in self.watched.iter().enumerate() {
            let state = told::state(&one.file, self.agenda.state(index), colour);
            stdout().styled(&format!("watch: {state}\n"));
        }
        let files = count(self.files().len(), "file");
        let keys = if self.has_keys { "; h for help, q to quit" } else { "" };
        writeln!(stdout(), "watch: waiting for changes of {files}{keys}");
        stdout().flush();
    }

    /// Has the system tell of changes where there could be some.
    fn tell_folders(&mut self) {
        let Some(changes) = &mut self.changes else { return };
        let folders = self.watched.iter().flat_map(|one| one.recording.folders()).collect();
        if let Err(error) = changes.of(folders) {
            looked_for(&error);
            self.changes = None;
        }
    }

    fn files(&self) -> BTreeSet<PathBuf> {
        self.watched.iter().flat_map(|one| one.recording.files()).collect()
    }

    fn happened(&mut self, happened: Happened) {
        match happened {
            Happened::Hint => {
                self.quiet.disturbed(self.begun.elapsed());
                self.is_hinted = true;
            }
            Happened::Ended(Ok(ended)) => self.ended(*ended),
            Happened::Ended(Err(panic)) => resume_unwind(panic),
            Happened::Interrupted => self.end(Exit::Interrupted),
            Happened::Key(key) => self.pressed(key),
        }
    }

    fn ended(&mut self, Ended { state, results }: Ended) {
        let extent = self.running.take().map(|(_, extent)| extent);
        let Some(index) = self.agenda.running() else { return };
        // Between what it read and now.
        self.look();
        let Watched { recording, before, .. } = &self.watched[index];
        if extent == Some(Extent::Failed) && !recording.agrees_with(before) {
            // A part was run of what is another whole.
            let _ = self.agenda.changed(index);
        }
        self.agenda.ended(state);
        let is_known = self.agenda.state(index) != SuiteState::Open;
        self.last = results.filter(|_| is_known).map(|results| (index, results)).or(self.last.take());
    }

    fn end(&mut self, exit: Exit) {
        self.exit = Some(exit);
        self.stop();
    }

    /// Has suites run again, from the beginning if one of them is under way.
    fn ask(&mut self, extent: Extent, is_asked: impl Fn(SuiteState) -> bool) {
        let running = self.agenda.running();
        let asked: Vec<usize> = (0..self.watched.len())
            .filter(|index| running == Some(*index) || is_asked(self.agenda.state(*index)))
            .collect();
        if asked.is_empty() {
            return writeln!(stdout(), "watch: nothing is known to have failed");
        }
        self.is_waiting = false;
        for index in asked {
            // One that was to run whole does so.
            if self.agenda.ask(index, if running == Some(index) { Extent::Selected } else { extent }) {
                self.stop();
            }
        }
    }

    fn pressed(&mut self, key: Key) {
        match key {
            Key::All => self.ask(Extent::Selected, |_| true),
            Key::Failed => self.ask(Extent::Failed, |state| {
                !matches!(state, SuiteState::Judged { overall: results::Overall::Passed, .. })
            }),
            Key::Typing => self.is_typing = true,
            Key::Filter(text) => self.filter(&text),
            Key::Kept => self.is_typing = false,
            Key::Report => match &self.last {
                Some((_, results)) => page::open(results),
                None => {
                    writeln!(stdout(), "watch: there is no report: nothing was run since the last change")
                }
            },
            Key::Watched => {
                let files = self.files();
                writeln!(stdout(), "watch: {}", count(files.len(), "file"));
                files.iter().for_each(|path| writeln!(stdout(), "  {}", told::shown(path)));
            }
            Key::Help => write!(stdout(), "{HELP}"),
            Key::Quit => self.end(Exit::Success),
        }
        stdout().flush();
    }

    /// Another filter expression; one that is wrong changes nothing.
    fn filter(&mut self, text: &str) {
        self.is_typing = false;
        let expressions: Vec<String> =
            Some(text.to_string()).filter(|text| !text.is_empty()).into_iter().collect();
        match Filters::parse(&expressions) {
            Ok(filters) => {
                self.filters = Arc::new(filters);
                self.ask(Extent::Selected, |_| true);
            }
            Err(failure) => {
                let colour = self.wishes.arguments.conduct.shown.color.wanted(stderr());
                stderr().styled(&failure.render(Style { colour }));
                writeln!(stderr(), "note: the filter stays as it was");
            }
        }
    }
}

/// Says that nobody tells of changes.
fn looked_for(error: &str) {
    writeln!(stderr(), "note: the system does not tell of changes, which are looked for instead: {error}");
}
