//! What it costs to ask programs: decisions a second with one worker, by how runs are written and how many are asked for at once.
//!
//! `cargo bench --bench under_test` measures a built-in controller and a program in Rust, which is this one. `cargo bench --bench under_test --
//! --program WORD…` measures any command that speaks the protocol, as it is, and `--declared TEXT` a controller of which this text is what stands in its
//! declaration, as `wasm "brakes.wasm"`; paths are relative to this package. Numbers are of the machine and what else it does.

use std::env;
use std::io::{self, BufRead, Read, Write};
use std::sync::Arc;
use std::time::{Duration, Instant};

use files::Memory;
use models::standard;
use runner::project::Project;
use runner::run::{Threads, VerifyRuns};
use runner::session::{Selection, Session};
use under_test::{Permission, ProcessPool};

const ROLE: &str = "BENCH_UNDER_TEST";

/// Each is measured for about so long.
const LONG: Duration = Duration::from_secs(4);

fn main() {
    if let Ok(wire) = env::var(ROLE) {
        return child(&wire);
    }
    // Cargo says `--bench`.
    let words: Vec<String> = env::args().skip(1).filter(|word| word != "--bench").collect();
    if let Some(at) = words.iter().position(|word| word == "--program") {
        return row(&words[at + 1..].join(" "), Some(&command(&words[at + 1..])));
    }
    if let Some(at) = words.iter().position(|word| word == "--declared") {
        let declared = words[at + 1..].join(" ");
        return row(declared.lines().next().unwrap_or_default(), Some(&declared));
    }
    #[cfg(feature = "fmu")]
    if let [word, plan] = words.as_slice()
        && word == "fmu-host"
    {
        under_test::fmu_host(std::path::Path::new(plan));
        return;
    }
    let own = vec![env::current_exe().expect("it runs").display().to_string()];
    row("built-in constant_speed", None);
    for (name, wire) in [
        ("Rust, one run at once, f64", "f64 1"),
        ("Rust, one run at once, json", "json 1"),
        ("Rust, 16 at once, f64", "f64 16"),
        ("Rust, 64 at once, f64", "f64 64"),
        ("Rust, 64 at once, json", "json 64"),
        ("Rust, 256 at once, f64", "f64 256"),
        ("Rust, 1024 at once, f64", "f64 1024"),
    ] {
        row(name, Some(&format!("{}\n  environment \"{ROLE}={wire}\"", command(&own))));
    }
}

fn command(words: &[String]) -> String {
    let words: Vec<String> = words.iter().map(|word| format!("{word:?}")).collect();
    format!("command {}", words.join(", "))
}

/// Measures a declared controller, or without one a built-in one, and prints a line.
fn row(name: &str, declared: Option<&str>) {
    // As many runs as take long enough.
    let (mut runs, mut found) = (64, measured(declared, 64));
    while found.1 < LONG && runs < 1 << 18 {
        let more = (LONG.as_secs_f64() / found.1.as_secs_f64().max(1e-3)).clamp(1.5, 8.0);
        runs = (runs as f64 * more) as usize;
        found = measured(declared, runs);
    }
    let (decisions, time) = found;
    println!(
        "{name:<34} {:>12.0} decisions/s   ({runs} runs, {:.1} s)",
        decisions / time.as_secs_f64(),
        time.as_secs_f64()
    );
}

/// How many decisions were made, and in which time.
fn measured(declared: Option<&str>, runs: usize) -> (f64, Duration) {
    let (declared, controller) = match declared {
        None => (String::new(), "constant_speed"),
        Some(declared) => (format!("controller own {{\n  {declared}\n}}\n"), "own"),
    };
    let text = format!(
        "{declared}scenario meet {{
  road {{ lane_width 4 m; speed_limit 30 km/h; crossing zebra }}
  vehicle av {{ controller {controller}; speed 30 km/h; start 60 m before crossing }}
  pedestrian walker {{ model scripted; start 2 m from kerb; appears at 1 s }}
  horizon 20 s
  repeat {runs}
}}
"
    );
    let files = Memory::default().with("meet.scn", text.as_str());
    let project = Project::open("meet.scn", &standard(), &files).unwrap_or_else(|error| panic!("{error}"));
    let pool = ProcessPool::new(Permission::default().all(), 1);
    let pool = Arc::new(pool.fmu_host(env::current_exe().expect("it runs")));
    let program = project.suites()[0].suite.scenarios[0].vehicles[0].controller.first.known();
    if let Some(program) = program.and_then(|model| model.program.as_ref()) {
        // Starting it is not what is measured.
        pool.prepare(program).unwrap_or_else(|error| panic!("{error}"));
    }
    let threads = Threads::new(1).with_processes(pool.clone());
    let session = Session::new(&project).executor(threads).courses(false).verify_runs(VerifyRuns::None);
    let begun = Instant::now();
    let results =
        session.run(&Selection::all(), &mut results::Unheard).unwrap_or_else(|error| panic!("{error}"));
    let time = begun.elapsed();
    let trial = &results.suites[0].trials[0];
    if let Some(error) = trial.error() {
        panic!("{error}");
    }
    let asked: u64 = pool.uses().iter().map(|one| one.answers.answers()).sum();
    let steps: f64 = trial.outcomes.iter().map(|one| one.ending.time / 0.025).sum();
    (if asked > 0 { asked as f64 } else { steps }, time)
}

/// Answers that nothing is to be done.
fn child(wire: &str) {
    let (encoding, at_once) = wire.split_once(' ').expect("two words");
    let (mut input, mut out) = (io::stdin().lock(), io::stdout().lock());
    let mut line = String::new();
    input.read_line(&mut line).expect("there is a hello");
    let mut say = |bytes: &[u8]| out.write_all(bytes).and_then(|()| out.flush()).is_ok();
    say(format!("{{\"hello\":{{\"protocol\":1,\"encoding\":\"{encoding}\",\"runs_at_once\":{at_once}}}}}\n")
        .as_bytes());
    if encoding == "json" {
        for line in input.lines().map_while(Result::ok) {
            let request: serde_json::Value = serde_json::from_str(&line).expect("it is JSON");
            if let Some(opened) = request["open"].as_array() {
                let slots: Vec<_> = opened.iter().map(|run| &run["slot"]).collect();
                say(format!("{}\n", serde_json::json!({ "ready": slots })).as_bytes());
            } else if let Some(asked) = request["step"].as_array() {
                let answers = vec![r#"{"acceleration":0}"#; asked.len()].join(",");
                say(format!("{{\"answer\":[{answers}]}}\n").as_bytes());
            }
        }
        return;
    }
    let (mut length, mut frame, mut answer) = ([0; 4], Vec::new(), Vec::new());
    while input.read_exact(&mut length).is_ok() {
        frame.resize(u32::from_le_bytes(length) as usize, 0);
        input.read_exact(&mut frame).expect("a frame is whole");
        answer.clear();
        if frame[0] == 0 {
            let request: serde_json::Value = serde_json::from_slice(&frame[4..]).expect("it is JSON");
            let Some(opened) = request["open"].as_array() else { continue };
            let slots: Vec<_> = opened.iter().map(|run| &run["slot"]).collect();
            let text = serde_json::json!({ "ready": slots }).to_string();
            answer.extend((text.len() as u32 + 4).to_le_bytes());
            answer.extend([0; 4]);
            answer.extend(text.as_bytes());
        } else {
            let runs = u32::from_le_bytes([frame[4], frame[5], frame[6], frame[7]]);
            for word in [12 + 8 * runs, 2, runs, 1] {
                answer.extend(word.to_le_bytes());
            }
            answer.resize(16 + 8 * runs as usize, 0);
        }
        say(&answer);
    }
}
