//! The command line of scenario-runner; everything it does is in the library.

#![warn(clippy::disallowed_methods)]

/// Trials and their runs are many small things that one thread makes and another one drops: the C library takes a tenth more time for them.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> std::process::ExitCode {
    scenario_runner::cli::main(&scenario_runner::models::standard())
}
