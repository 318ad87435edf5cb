//! Results for people and machines: one file a format.

// What `clippy.toml` bans is banned from what is shipped; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

mod baseline;
mod calibration;
mod chart;
mod columns;
pub mod console;
mod controllers;
mod csv;
#[cfg(test)]
mod cut_off_tests;
mod diff;
mod digest;
mod drawing;
mod estimation;
mod evaluation;
mod experiment;
mod failure;
mod figures;
pub mod findings;
#[cfg(test)]
mod fixture;
mod format;
mod found;
mod gap_choice;
mod gate;
mod gate_markdown;
mod github;
mod groups;
#[cfg(test)]
mod hostile;
#[cfg(test)]
#[path = "../files/escape/hostile.rs"]
mod hostile_texts;
mod html;
mod json;
mod junit;
mod models;
mod pages;
mod perceived;
mod rating;
mod replay;
mod repository;
mod rows;
mod runs;
#[cfg(test)]
mod schema;
mod shown_value;
mod statement;
mod svg;
mod table;
mod tap;
mod terminal;
mod trace;
mod usual;
mod variable;
mod why;
mod wording;

pub use baseline::{Form, render_baseline, render_difference, render_sight};
pub use calibration::{draw_calibration, render_calibrate};
pub use controllers::render_controllers;
pub use csv::write_csv;
pub use diff::{
    BaselineDiff, DiffSide, RunDiff, baseline_diff_json, diff_json, render_baseline_diff, render_diff,
};
pub use drawing::{AfterTheEnd, Sketch};
pub use estimation::{draw_estimate, render_estimate};
pub use evaluation::render_evaluate;
pub use experiment::{render_block, render_tune, tuned_parameters};
pub use failure::{explain, with_worst};
pub(crate) use figures::figures;
pub use format::{count, quantity, share, with_unit};
pub use found::render_search;
pub use gap_choice::{draw_gap_choices, render_gap_choices};
pub use gate::{Replay, render_gate, render_gate_report, render_gates};
pub use gate_markdown::gate_markdown;
pub use github::{annotations, step_summary};
pub use html::{diff_to_html, to_html};
pub use json::{ResultsError, read_results, write_json};
pub use junit::write_junit;
pub use models::{render_declared, render_model, render_models};
pub use pages::{ModelPage, model_pages};
pub use rating::{render_rating, render_ratings};
pub use replay::{ReplayIntroduction, case_values, render_replay, replay_reasons};
pub use repository::Repository;
pub use runs::{RunLines, write_runs};
pub use table::render_tables;
pub use tap::write_tap;
pub use terminal::{Live, StatusLevel, Terminal};
pub use trace::{TraceColumns, write_trace, write_trace_with};
pub use why::{WhyRun, render_moment, render_why, why_json};
pub use wording::run_words;

use std::io;

use results::{Results, SuiteReport};
use wording::verdict_word;

/// Refuses where the results do not hold every trial: a report of each would lack those that passed.
fn need_every_trial(results: &Results) -> io::Result<()> {
    let incomplete = results.suites.iter().find_map(SuiteReport::incomplete);
    incomplete.map_or(Ok(()), |why| Err(io::Error::new(io::ErrorKind::InvalidInput, why)))
}

/// As [`need_every_trial`], for reports that are no files.
fn expect_every_trial(results: &Results) {
    if let Err(why) = need_every_trial(results) {
        panic!("{why}");
    }
}
