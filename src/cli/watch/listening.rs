//! Keys, told as they are pressed.

use std::sync::mpsc::Sender;
use std::thread;

use super::happened::Happened;
use super::keys::Key;
use super::terminal_mode::TerminalMode;
use report::console::stdout;

/// Tells of keys, on a thread that lives as long as the program.
pub fn listen(mode: TerminalMode, sender: Sender<Happened>) {
    thread::spawn(move || {
        while let Some(typed) = mode.key() {
            let Some(key) = Key::of(typed) else { continue };
            let is_typing = key == Key::Typing;
            if sender.send(Happened::Key(key)).is_err() {
                return;
            }
            if is_typing {
                write!(stdout(), "filter: ");
                stdout().flush();
                let typed = mode.line().map_or(Key::Kept, |line| Key::Filter(line.trim().to_string()));
                if sender.send(Happened::Key(typed)).is_err() {
                    return;
                }
            }
        }
    });
}
