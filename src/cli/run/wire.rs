//! `--record-wire FILE`: what a program was asked and what it said in one run.

use std::path::Path;

use crate::cli::Exit;
use report::console::stderr;
use runner::run::programs;
use runner::session::{Units, Work};
use under_test::{ProcessPool, WireRecord};

/// A record of the first chosen run in which a program decides.
pub fn record(units: &Units, chosen: &[bool]) -> Result<WireRecord, Exit> {
    let first =
        units.iter().zip(chosen).filter(|(_, chosen)| **chosen).find_map(|(unit, _)| match &unit.work {
            Work::Trial(trial) if !trial.cases.is_empty() => {
                let case = trial.cases.get(0);
                (!programs(&case).is_empty()).then_some(case.key)
            }
            _ => None,
        });
    first.map(WireRecord::of).ok_or_else(|| {
        writeln!(stderr(), "error: `--record-wire`: no program decides in any trial that is selected");
        writeln!(
            stderr(),
            "help: searches and other blocks are not written down; select a trial of a declared controller"
        );
        Exit::Usage
    })
}

/// Writes it; what is wrong, in words.
pub fn write(path: Option<&Path>, processes: Option<&ProcessPool>) -> Option<String> {
    let (path, record) = (path?, processes?.record()?);
    let Some(text) = record.text() else {
        return Some(format!(
            "{} was not run, so that there is nothing to write into {}",
            record.run(),
            path.display()
        ));
    };
    files::write(path, text).err().map(|error| format!("cannot write {}: {error}", path.display()))
}
