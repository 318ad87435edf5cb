//! `scenario-runner watch FILES`: runs suites, and again whatever a change of what they read concerns.

mod arguments;
mod happened;
mod keys;
mod listening;
mod one_run;
mod page;
mod terminal_mode;
mod told;
mod watching;

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc;

pub use self::arguments::WatchArguments;
use self::happened::Happened;
use self::listening::listen;
use self::one_run::Wishes;
use self::terminal_mode::TerminalMode;
use self::watching::Watching;
use super::run::hints;
use super::{Exit, load, store};
use report::console::stderr;
use scenario::registry::Registry;

pub fn watch(arguments: &WatchArguments, registry: &Registry) -> Exit {
    let (named, filters): (Vec<&String>, Vec<&String>) =
        arguments.words.iter().partition(|word| load::names_a_file(word));
    if let Err(exit) = hints::one_filter(&filters) {
        return exit;
    }
    let mut files: Vec<String> = Vec::new();
    for file in named {
        if !files.contains(file) {
            files.push(file.clone());
        }
    }
    if files.is_empty() {
        files = hints::found_here().iter().map(|path| path.display().to_string()).collect();
    }
    if files.is_empty() {
        return hints::project();
    }
    let colour = arguments.conduct.shown.color.wanted(stderr());
    let expressions = match arguments.select.subjects.expressions.read(colour) {
        Ok(expressions) => Arc::new(expressions),
        Err(exit) => return exit,
    };
    let options = match load::options(arguments.conduct.seed, &arguments.conduct.set) {
        Ok(options) => options,
        Err(exit) => return exit,
    };
    for folder in [&*arguments.conduct.journal, Path::new(store::FOLDER)] {
        if let Err(exit) = store::prepare(folder) {
            return exit;
        }
    }
    let (sender, receiver) = mpsc::channel();
    let mode = TerminalMode::take();
    // Whatever happens from here on, the terminal is as it was afterwards.
    let _restored = mode.as_ref().map(TerminalMode::restored);
    end_on_interrupt(sender.clone(), mode.clone());
    let has_keys = mode.is_some();
    if let Some(mode) = mode {
        listen(mode, sender.clone());
    }
    let wishes = Wishes { arguments, options, word: filters.first().map(|word| word.as_str()), registry };
    Watching::new(&wishes, expressions, files, sender, has_keys).run(&receiver)
}

/// Tells of Ctrl-C and of signals that end programs; the second one ends this at once.
fn end_on_interrupt(sender: mpsc::Sender<Happened>, mode: Option<TerminalMode>) {
    let mut is_heard = false;
    let heard = ctrlc::set_handler(move || {
        if is_heard || sender.send(Happened::Interrupted).is_err() {
            mode.iter().for_each(TerminalMode::restore);
            std::process::exit(i32::from(Exit::Interrupted as u8));
        }
        is_heard = true;
    });
    if let Err(error) = heard {
        writeln!(stderr(), "warning: Ctrl-C will end the program at once: {error}");
    }
}
