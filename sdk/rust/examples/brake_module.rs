//! The controller of `brake.rs` as a WebAssembly module: `cargo build --release --target wasm32-unknown-unknown --example brake_module`.

#[path = "brake.rs"]
#[allow(dead_code)] // it has a `main` of its own
mod brake;

scenario_runner_av::module!(brake::Brake, brake::about());
