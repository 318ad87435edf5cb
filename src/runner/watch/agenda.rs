//! What is to be run next, what has to be stopped, and what is known of each suite.

use results::Overall;

/// How much of a suite is to run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Extent {
    /// What did not pass when it was last run.
    Failed,
    /// All that is selected.
    Selected,
}

/// What is known of a suite as it stands in its files now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SuiteState {
    /// Nothing: it has not been run since it changed.
    Open,
    /// It cannot be loaded, or what decides in it cannot be started.
    DoesNotLoad,
    /// Nothing of it is selected.
    NothingSelected,
    /// It was run.
    Judged {
        /// What that came to.
        overall: Overall,
        /// Units that were run.
        units: usize,
        /// Units that there are.
        of: usize,
    },
}

impl SuiteState {
    /// Whether it is run before others.
    fn comes_first(self) -> bool {
        !matches!(self, Self::Judged { overall: Overall::Passed, .. } | Self::NothingSelected)
    }
}

/// Several suites, by their indices, of which one is run at a time.
///
/// Nothing is known of a suite from when it has changed until a run that began after that has come to its end: neither an earlier run nor one
/// that was under way then says anything about it.
#[derive(Debug, Clone)]
pub struct Agenda {
    entries: Vec<Entry>,
    running: Option<usize>,
}

#[derive(Debug, Clone)]
struct Entry {
    /// How much of it is to run, if it is.
    due: Option<Extent>,
    state: SuiteState,
    /// Whether it did not pass when it was last run, whatever has changed since.
    failed: bool,
}

impl Agenda {
    /// All of so many are to be run.
    pub fn new(suites: usize, extent: Extent) -> Self {
        let entry = Entry { due: Some(extent), state: SuiteState::Open, failed: false };
        Self { entries: vec![entry; suites], running: None }
    }

    /// What it reads has changed: all that is selected of it is to run. Whether it is under way, so that it has to be stopped.
    #[must_use]
    pub fn changed(&mut self, suite: usize) -> bool {
        self.entries[suite].state = SuiteState::Open;
        self.ask(suite, Extent::Selected)
    }

    /// Somebody wishes that it runs. Whether it is under way, so that it has to be stopped.
    #[must_use]
    pub fn ask(&mut self, suite: usize, extent: Extent) -> bool {
        let entry = &mut self.entries[suite];
        entry.due = entry.due.max(Some(extent));
        self.running == Some(suite)
    }

    /// The suite that is to run now, and how much of it; it is under way from then on. `None` while one is, or if nothing is to run. What did
    /// not pass last time comes first, then the order of the suites.
    pub fn begin(&mut self) -> Option<(usize, Extent)> {
        if self.running.is_some() {
            return None;
        }
        let due = |entry: &Entry| entry.due.map(|extent| (!entry.failed, extent));
        let all = self.entries.iter().enumerate();
        let next = all.filter_map(|(index, entry)| Some((due(entry)?, index)));
        let ((_, extent), index) = next.min_by_key(|((passed, _), index)| (*passed, *index))?;
        self.entries[index].due = None;
        self.entries[index].state = SuiteState::Open;
        self.running = Some(index);
        Some((index, extent))
    }

    /// The suite that is under way has come to its end, or was stopped: `None`. What it came to counts only if it need not run again.
    ///
    /// # Panics
    /// If none was under way.
    pub fn ended(&mut self, state: Option<SuiteState>) {
        let index = self.running.take().expect("a suite was under way");
        let entry = &mut self.entries[index];
        entry.failed = state.map_or(entry.failed, SuiteState::comes_first);
        entry.state = match entry.due {
            None => state.unwrap_or(SuiteState::Open),
            Some(_) => SuiteState::Open,
        };
    }

    /// The suite that is under way.
    pub fn running(&self) -> Option<usize> {
        self.running
    }

    /// Whether nothing is under way or to be run.
    pub fn is_idle(&self) -> bool {
        self.running.is_none() && self.entries.iter().all(|entry| entry.due.is_none())
    }

    /// What is known of a suite.
    pub fn state(&self, suite: usize) -> SuiteState {
        self.entries[suite].state
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const PASSED: SuiteState = SuiteState::Judged { overall: Overall::Passed, units: 3, of: 3 };
    const FAILED: SuiteState = SuiteState::Judged { overall: Overall::Failed, units: 3, of: 3 };

    #[test]
    fn all_are_run_once_and_again_when_they_change() {
        let mut agenda = Agenda::new(2, Extent::Selected);
        assert_eq!(agenda.begin(), Some((0, Extent::Selected)));
        assert_eq!(agenda.begin(), None, "one at a time");
        agenda.ended(Some(PASSED));
        assert_eq!(agenda.begin(), Some((1, Extent::Selected)));
        agenda.ended(Some(PASSED));
        assert!(agenda.is_idle() && agenda.begin().is_none());
        assert!(!agenda.changed(0), "nothing has to be stopped");
        assert_eq!((agenda.state(0), agenda.state(1)), (SuiteState::Open, PASSED));
        assert_eq!(agenda.begin(), Some((0, Extent::Selected)));
    }

    #[test]
    fn a_change_while_it_runs_is_not_lost() {
        let mut agenda = Agenda::new(1, Extent::Selected);
        agenda.begin();
        assert!(agenda.changed(0), "it has to be stopped");
        agenda.ended(Some(PASSED));
        assert_eq!(agenda.state(0), SuiteState::Open, "what it came to is of the old text");
        assert_eq!(agenda.begin(), Some((0, Extent::Selected)));
        agenda.ended(None);
        assert_eq!(agenda.state(0), SuiteState::Open, "it was stopped");
    }

    #[test]
    fn what_failed_comes_first() {
        let mut agenda = Agenda::new(3, Extent::Selected);
        for state in [PASSED, FAILED, SuiteState::DoesNotLoad] {
            agenda.begin();
            agenda.ended(Some(state));
        }
        assert!((0..3).all(|suite| !agenda.changed(suite)));
        let mut order = Vec::new();
        while let Some((suite, _)) = agenda.begin() {
            order.push(suite);
            agenda.ended(Some(PASSED));
        }
        assert_eq!(order, [1, 2, 0]);
    }

    #[test]
    fn what_changed_is_run_whole_whatever_else_was_wished() {
        let mut agenda = Agenda::new(1, Extent::Selected);
        agenda.begin();
        agenda.ended(Some(FAILED));
        assert!(!agenda.ask(0, Extent::Failed));
        assert_eq!(agenda.state(0), FAILED, "a wish changes nothing yet");
        assert!(!agenda.changed(0) && !agenda.ask(0, Extent::Failed));
        assert_eq!(agenda.begin(), Some((0, Extent::Selected)));
    }

    /// What may happen, in any order.
    #[derive(Debug, Clone)]
    enum Happens {
        /// A file is written.
        Written(usize),
        /// Somebody looks at what changed.
        Looked,
        Asked(usize, Extent),
        /// What is to run begins, if anything is.
        Begun,
        /// What is under way reads one file.
        Read(usize),
        /// It ends, by itself or because it was stopped.
        Ended,
    }

    /// Suites read file 0, and one of their own.
    const SUITES: usize = 3;

    fn happens() -> impl Strategy<Value = Happens> {
        prop_oneof![
            3 => (0..=SUITES).prop_map(Happens::Written),
            3 => Just(Happens::Looked),
            1 => (0..SUITES, prop_oneof![Just(Extent::Failed), Just(Extent::Selected)])
                .prop_map(|(suite, extent)| Happens::Asked(suite, extent)),
            3 => Just(Happens::Begun),
            4 => (0..2usize).prop_map(Happens::Read),
            3 => Just(Happens::Ended),
        ]
    }

    /// Files with versions, and who runs the suites as a watch does: it looks before anything begins and after anything ends.
    struct World {
        agenda: Agenda,
        files: [u32; SUITES + 1],
        /// What each suite's last run read of its two files, `None` for what it did not read yet.
        read: [[Option<u32>; 2]; SUITES],
        stopped: bool,
    }

    impl World {
        fn file(suite: usize, which: usize) -> usize {
            if which == 0 { 0 } else { 1 + suite }
        }

        fn looked(&mut self) {
            for suite in 0..SUITES {
                let differs = |which: usize| {
                    self.read[suite][which].is_some_and(|read| read != self.files[Self::file(suite, which)])
                };
                if (0..2).any(differs) {
                    self.stopped |= self.agenda.changed(suite);
                    if self.agenda.running() != Some(suite) {
                        // Told once.
                        self.read[suite] = [None; 2];
                    }
                }
            }
        }

        fn begun(&mut self) {
            self.looked();
            if let Some((suite, _)) = self.agenda.begin() {
                (self.read[suite], self.stopped) = ([None; 2], false);
            }
        }

        fn read(&mut self, which: usize) {
            let Some(suite) = self.agenda.running() else { return };
            self.read[suite][which].get_or_insert(self.files[Self::file(suite, which)]);
        }

        fn ended(&mut self) {
            let Some(suite) = self.agenda.running() else { return };
            (0..2).for_each(|which| self.read(which));
            self.looked();
            self.agenda.ended((!self.stopped).then_some(PASSED));
            if self.agenda.state(suite) != SuiteState::Open {
                self.is_honest();
            }
        }

        /// Nothing counts that was read otherwise than it stands there, as far as somebody has looked.
        fn is_honest(&self) {
            for suite in 0..SUITES {
                if self.agenda.state(suite) != SuiteState::Open {
                    for which in 0..2 {
                        assert_eq!(self.read[suite][which], Some(self.files[Self::file(suite, which)]));
                    }
                }
            }
        }
    }

    proptest! {
        /// Whatever changes whenever: once nothing changes any more, all that is known is of the last content of every file.
        #[test]
        fn in_the_end_the_last_content_is_judged(events in prop::collection::vec(happens(), 0..200)) {
            let mut world = World {
                agenda: Agenda::new(SUITES, Extent::Selected),
                files: [0; SUITES + 1],
                read: [[None; 2]; SUITES],
                stopped: false,
            };
            for event in events {
                match event {
                    Happens::Written(file) => world.files[file] += 1,
                    Happens::Looked => {
                        world.looked();
                        world.is_honest();
                    }
                    Happens::Asked(suite, extent) => world.stopped |= world.agenda.ask(suite, extent),
                    Happens::Begun => world.begun(),
                    Happens::Read(which) => world.read(which),
                    Happens::Ended => world.ended(),
                }
            }
            for _ in 0..4 * SUITES {
                world.ended();
                world.begun();
            }
            prop_assert!(world.agenda.is_idle());
            prop_assert!((0..SUITES).all(|suite| world.agenda.state(suite) == PASSED));
            world.is_honest();
        }
    }
}
