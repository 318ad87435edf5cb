//! The terminal that keys come from: each of them at once and not shown, and afterwards as it was.

#[cfg(unix)]
pub(crate) use unix::TerminalMode;
#[cfg(windows)]
pub(crate) use windows::TerminalMode;

/// Puts a terminal back when it is dropped.
pub(crate) struct Restored(TerminalMode);

impl Drop for Restored {
    fn drop(&mut self) {
        self.0.restore();
    }
}

impl TerminalMode {
    /// Puts it back once what is returned is dropped.
    pub(crate) fn restored(&self) -> Restored {
        Restored(self.clone())
    }
}

#[cfg(unix)]
mod unix {
    use std::sync::Arc;

    use rustix::io::{Errno, read};
    use rustix::process::getpgrp;
    use rustix::stdio::stdin;
    use rustix::termios::{
        LocalModes, OptionalActions, SpecialCodeIndex, Termios, isatty, tcgetattr, tcgetpgrp, tcsetattr,
    };

    /// Standard input, where that is a terminal.
    #[derive(Clone)]
    pub(crate) struct TerminalMode(Arc<Termios>);

    impl TerminalMode {
        /// Takes each key at once from now on. Signals of keys stay, such as that of Ctrl-C. `None` where there is no terminal, or another
        /// program has it.
        pub fn take() -> Option<Self> {
            let original = isatty(stdin()).then(|| tcgetattr(stdin()).ok()).flatten()?;
            let mode = Self(Arc::new(original));
            (mode.is_ours() && mode.single()).then_some(mode)
        }

        /// One that is asked for by who is in the background would stop it.
        fn is_ours(&self) -> bool {
            tcgetpgrp(stdin()).is_ok_and(|group| group == getpgrp())
        }

        fn single(&self) -> bool {
            let mut single = Termios::clone(&self.0);
            single.local_modes.remove(LocalModes::ICANON | LocalModes::ECHO);
            single.special_codes[SpecialCodeIndex::VMIN] = 1;
            single.special_codes[SpecialCodeIndex::VTIME] = 0;
            tcsetattr(stdin(), OptionalActions::Now, &single).is_ok()
        }

        /// As it was.
        pub fn restore(&self) {
            if self.is_ours() {
                // If it is gone there is nothing to put back.
                let _ = tcsetattr(stdin(), OptionalActions::Now, &self.0);
            }
        }

        /// The next key, waited for; `None` once there are no more.
        pub fn key(&self) -> Option<char> {
            byte().map(char::from)
        }

        /// A line that is typed and shown as usual; `None` once there are no more.
        pub fn line(&self) -> Option<String> {
            self.restore();
            let mut bytes = Vec::new();
            let is_whole = loop {
                match byte() {
                    Some(b'\n') => break true,
                    Some(byte) => bytes.push(byte),
                    None => break false,
                }
            };
            self.single();
            is_whole.then(|| String::from_utf8_lossy(&bytes).into_owned())
        }
    }

    fn byte() -> Option<u8> {
        let mut byte = [0];
        loop {
            match read(stdin(), &mut byte[..]) {
                Ok(1) => return Some(byte[0]),
                Err(Errno::INTR) => {}
                Ok(_) | Err(_) => return None,
            }
        }
    }
}

#[cfg(windows)]
mod windows {
    use console::{Key, Term};

    /// The console, where there is one.
    #[derive(Clone)]
    pub(crate) struct TerminalMode(Term);

    impl TerminalMode {
        /// Takes each key at once from now on. `None` where there is no console.
        pub fn take() -> Option<Self> {
            let term = Term::stdout();
            (console::user_attended() && term.features().is_attended()).then_some(Self(term))
        }

        /// Nothing was changed: events of keys are read.
        pub fn restore(&self) {}

        /// The next key, waited for; `None` once there are no more.
        pub fn key(&self) -> Option<char> {
            match self.0.read_key().ok()? {
                Key::Enter => Some('\n'),
                Key::Char(key) => Some(key),
                _ => Some('\0'),
            }
        }

        /// A line that is typed and shown as usual; `None` once there are no more.
        pub fn line(&self) -> Option<String> {
            self.0.read_line().ok()
        }
    }
}
