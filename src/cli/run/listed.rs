//! `--list`: the names of what is selected, to be read or for other programs.

use clap::ValueEnum;
use serde_json::{Value, json};

use crate::cli::Exit;
use files::escape::terminal_line;
use report::console::stdout;
use runner::project::PlannedSuite;
use runner::session::{Unit, Units, Work};

/// Of the list in JSON; another number is another meaning of what was there before. `docs/running.md` describes it.
const LAYOUT: u32 = 1;

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ListFormat {
    /// A name a line.
    Text,
    /// One object with a unit a line.
    Json,
}

/// Writes the units that are chosen.
pub fn list(format: ListFormat, suites: &[PlannedSuite], units: &Units, chosen: &[bool]) -> Exit {
    let chosen = chosen.iter().enumerate().filter(|(_, chosen)| **chosen).map(|(index, _)| index);
    match format {
        ListFormat::Text => {
            chosen.for_each(|index| writeln!(stdout(), "{}", terminal_line(&units.key(index))));
        }
        ListFormat::Json => {
            stdout().verbatim(&format!("{{\"layout\":{LAYOUT},\"units\":["));
            for (place, index) in chosen.enumerate() {
                let unit = described(suites, &units.get(index), units.runs(index));
                stdout().verbatim(&format!("{}{unit}", if place == 0 { "\n" } else { ",\n" }));
            }
            stdout().verbatim("\n]}\n");
        }
    }
    Exit::Success
}

fn described(suites: &[PlannedSuite], unit: &Unit, runs: usize) -> Value {
    let planned = &suites[unit.suite];
    let mut value = json!({ "key": unit.key, "suite": planned.suite.name, "of": planned.file });
    let (kind, origin) = match &unit.work {
        Work::Recorded(recorded) => {
            value["scenario"] = recorded.scenario.clone().into();
            ("recorded", planned.suite.scenario(&recorded.scenario).map(|scenario| &scenario.origin))
        }
        Work::Trial(trial) => {
            let scenario = planned.suite.scenario(&trial.scenario);
            value["scenario"] = trial.scenario.clone().into();
            value["tags"] = json!(scenario.map_or(&[][..], |scenario| &scenario.tags));
            value["runs"] = runs.into();
            ("trial", scenario.map(|scenario| &scenario.origin))
        }
        Work::Block(block) => (block.kind(), Some(block.origin())),
    };
    value["kind"] = kind.into();
    if let Some(origin) = origin {
        value["file"] = json!(origin.file);
        value["line"] = origin.line.into();
    }
    value
}
