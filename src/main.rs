//! The command line of scenario-runner; everything it does is in the library.

#![warn(clippy::disallowed_methods)]

fn main() -> std::process::ExitCode {
    scenario_runner::cli::main(&scenario_runner::models::standard())
}
