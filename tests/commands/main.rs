//! The program as its users meet it at the command line and in editors.

mod appearing;
mod bugs;
mod cli;
mod contacts;
mod crosscdr;
mod diff;
mod drawn;
mod edited_results;
mod estimates;
mod expecting_searches;
#[cfg(unix)]
mod files;
mod gates;
mod groups;
mod help_page;
mod horizon;
mod init;
mod last_run;
mod lsp;
mod lsp_names;
mod mixtures;
mod names;
mod numbers;
mod outputs;
#[cfg(target_os = "linux")]
mod pipes;
#[cfg(unix)]
mod printed;
mod ratings;
mod reports;
#[cfg(unix)]
mod resume;
mod roads_vary;
mod run;
mod set;
mod shards;
mod sharing;
mod shrink;
mod sketch;
mod streets;
mod summary;
#[path = "../support/mod.rs"]
mod support;
mod tunes;
mod units;
mod untested;
mod verdicts;
mod watch;
mod why;
