//! The suites that ship, trial by trial: what a Rust project that keeps scenarios beside its code writes.

fn main() -> std::process::ExitCode {
    scenario_runner::testing::run(&[
        "suites/zebra.suite",
        "suites/worst_arrival.suite",
        "suites/zebra_gate.suite",
        "suites/paper.suite",
    ])
}
