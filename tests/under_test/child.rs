//! A program under test: brakes for whoever is near, or does what a program must not.

use std::io::{self, BufRead, Read, Write};
use std::time::Duration;
use std::{env, process, thread};

use serde_json::{Value, json};

/// What the program is to do, and with which words on its command line.
pub struct Child {
    kind: String,
    encoding: String,
    at_once: u64,
    gives: String,
    /// Steps that it has answered.
    steps: u64,
    /// Whether it has answered once too often, and what it says next instead of what it is asked.
    repeats: bool,
    held: Option<String>,
    /// Parameters by slot.
    gaps: Vec<f64>,
    crashes: Vec<bool>,
}

fn argument(name: &str, default: &str) -> String {
    let wanted = format!("{name}=");
    env::args()
        .find_map(|one| one.strip_prefix(&wanted).map(str::to_string))
        .unwrap_or_else(|| default.into())
}

/// As it says of itself; another one where a file beside it has one.
fn version() -> String {
    std::fs::read_to_string("version").unwrap_or_else(|_| argument("version", "1.0"))
}

/// Rests for good.
fn hang() -> ! {
    loop {
        thread::sleep(Duration::from_secs(600));
    }
}

pub fn run() -> ! {
    let mut child = Child {
        kind: argument("kind", "good"),
        encoding: argument("encoding", "json"),
        at_once: argument("at_once", "1").parse().unwrap(),
        gives: argument("gives", "acceleration"),
        steps: 0,
        repeats: false,
        held: None,
        gaps: vec![0.0; 1024],
        crashes: vec![false; 1024],
    };
    let touched = argument("touch", "");
    if !touched.is_empty() {
        std::fs::write(touched, "I ran").unwrap();
    }
    match child.kind.as_str() {
        "silent" => hang(),
        "chatter" => (0..200).for_each(|line| println!("chatter {line}")),
        "prints_first" => (0..20).for_each(|line| println!("welcome {line}")),
        "ends_at_once" => {
            eprintln!("no such weights: v3.onnx");
            process::exit(3)
        }
        #[cfg(unix)]
        "ignores_sigterm" => {
            use std::os::unix::process::CommandExt;
            // What is ignored stays ignored.
            let own = env::current_exe().unwrap();
            let script = "trap '' TERM; exec \"$0\" kind=hang";
            let error = process::Command::new("sh").args(["-c", script]).arg(own).exec();
            panic!("{error}")
        }
        "flood" => (0..20_000).for_each(|line| eprintln!("{line} {}", "log ".repeat(20))),
        _ => {}
    }
    let input = &mut io::stdin().lock();
    let mut line = String::new();
    input.read_line(&mut line).unwrap();
    let protocol = if child.kind == "wrong_version" { 2 } else { 1 };
    let gap = json!({"name": "gap", "unit": "m", "default": 5, "low": 0, "high": 100});
    let mut parameters = vec![gap];
    if child.kind == "knows_more" {
        parameters.push(json!({"name": "horizon", "default": 20, "low": 5, "high": 80}));
    }
    if child.kind == "narrow" {
        parameters[0]["high"] = json!(20);
    }
    let hello = json!({"hello": {
        "protocol": protocol, "name": "tested", "version": version(), "encoding": child.encoding,
        "runs_at_once": child.at_once, "gives": [child.gives], "modes": ["cruise", "brake"], "parameters": parameters,
    }});
    // `hello` comes first, whatever the order of keys.
    if child.kind == "never_reads" {
        // Nor does it say of parameters, which would be told it.
        println!("{{\"hello\":{{\"protocol\":1,\"name\":\"tested\",\"version\":\"1.0\"}}}}");
        hang();
    }
    println!("{hello}");
    if child.encoding == "json" {
        for line in input.lines() {
            let request: Value = serde_json::from_str(&line.unwrap()).unwrap();
            if let Some(answer) = child.answer(&request) {
                let answer = child.in_turn(answer);
                // Lines that are said at once are there at once.
                say(format!("{answer}\n").as_bytes());
            }
        }
        if child.kind == "stays" {
            hang();
        }
    } else {
        loop {
            let frame = frame(input);
            let answer =
                if frame[0] == 0 { child.answer_text(&frame[4..]) } else { child.answer_rows(&frame) };
            answer.iter().for_each(|bytes| say(bytes));
        }
    }
    process::exit(0)
}

fn say(bytes: &[u8]) {
    let mut out = io::stdout().lock();
    out.write_all(bytes).and_then(|()| out.flush()).unwrap();
}

fn frame(input: &mut impl Read) -> Vec<u8> {
    let mut length = [0; 4];
    if input.read_exact(&mut length).is_err() {
        process::exit(0);
    }
    let mut frame = vec![0; u32::from_le_bytes(length) as usize];
    input.read_exact(&mut frame).unwrap();
    frame
}

/// What is seen of a run.
#[derive(Clone, Copy)]
struct Seen {
    slot: usize,
    time: f64,
    cruise: f64,
    speed: f64,
    near: bool,
}

fn is_near(x: f64, y: f64) -> bool {
    0.0 < x && x < 25.0 && y.abs() < 4.0
}

impl Child {
    /// Where it answers once too often, that is the answer to the next request, and each of its answers is to the request before.
    fn in_turn(&mut self, answer: String) -> String {
        match &mut self.held {
            Some(held) => std::mem::replace(held, answer),
            None => {
                self.held = self.repeats.then(|| answer.clone());
                answer
            }
        }
    }

    fn answer(&mut self, request: &Value) -> Option<String> {
        if let Some(opened) = request["open"].as_array() {
            for run in opened {
                let slot = run["slot"].as_u64().unwrap() as usize;
                self.gaps[slot] = run["parameters"]["gap"].as_f64().unwrap_or(5.0);
                // One seed in some, whatever else is under way.
                self.crashes[slot] = run["seed"].as_u64().unwrap() % 7 == 5;
            }
            let slots: Vec<&Value> = opened.iter().map(|run| &run["slot"]).collect();
            if self.kind == "refuses_to_open" {
                let failed: Vec<Value> =
                    slots.iter().map(|slot| json!({"slot": slot, "message": "no such weights"})).collect();
                return Some(json!({"ready": [], "failed": failed}).to_string());
            }
            return Some(json!({ "ready": slots }).to_string());
        }
        let asked = request["step"].as_array()?;
        let number = |value: &Value| value.as_f64().unwrap();
        let seen: Vec<Seen> = asked
            .iter()
            .map(|run| Seen {
                slot: run["slot"].as_u64().unwrap() as usize,
                time: number(&run["time"]),
                cruise: number(&run["cruise_speed"]),
                speed: number(&run["ego"]["speed"]),
                near: run["pedestrians"]
                    .as_array()
                    .unwrap()
                    .iter()
                    .any(|one| is_near(number(&one["x"]), number(&one["y"]))),
            })
            .collect();
        if let Some(broken) = self.misbehave(&seen) {
            return Some(broken);
        }
        let answers: Vec<Value> = seen
            .iter()
            .map(|one| {
                let values = self.decide(one);
                let mode = if one.near { "brake" } else { "cruise" };
                match self.gives.as_str() {
                    "pedals" => json!({"throttle": values[0], "brake": values[1], "mode": mode}),
                    "speed_plan" => json!({"speed_plan": [[0.0, values[1]], [1.0, values[3]]], "mode": mode}),
                    gives => json!({gives: values[0], "mode": mode}),
                }
            })
            .collect();
        let answers: Vec<Value> = answers
            .into_iter()
            .zip(&seen)
            .map(|(mut answer, one)| {
                if let Some(curvature) = self.curvature(one) {
                    answer["curvature"] = json!(curvature);
                }
                answer
            })
            .collect();
        Some(json!({ "answer": answers }).to_string())
    }

    fn answer_text(&mut self, text: &[u8]) -> Option<Vec<u8>> {
        let request: Value = serde_json::from_slice(text).unwrap();
        self.answer(&request).map(|answer| text_frame(&answer))
    }

    fn answer_rows(&mut self, frame: &[u8]) -> Option<Vec<u8>> {
        let word = |at: usize| u32::from_le_bytes(frame[4 * at..4 * at + 4].try_into().unwrap()) as usize;
        let (runs, people) = (word(1), word(2));
        let double = |at: usize| f64::from_le_bytes(frame[28 + 8 * at..36 + 8 * at].try_into().unwrap());
        let near = |row: usize| {
            (0..people)
                .map(|one| 16 * runs + 10 * one)
                .any(|at| double(at) as usize == row && is_near(double(at + 2), double(at + 3)))
        };
        let seen: Vec<Seen> = (0..runs)
            .map(|row| Seen {
                slot: double(16 * row) as usize,
                time: double(16 * row + 1),
                cruise: double(16 * row + 3),
                speed: double(16 * row + 5),
                near: near(row),
            })
            .collect();
        if let Some(broken) = self.misbehave(&seen) {
            return Some(text_frame(&broken));
        }
        let rows: Vec<Vec<f64>> = seen
            .iter()
            .map(|one| {
                let mut values = self.decide(one);
                if self.gives == "speed_plan" {
                    values.resize(32, f64::NAN);
                }
                values.push(f64::from(u8::from(one.near)));
                if self.kind.starts_with("steers") {
                    values.push(self.curvature(one).unwrap_or(f64::NAN));
                }
                values
            })
            .collect();
        let mut answer = Vec::new();
        let columns = rows[0].len();
        let length = 12 + 8 * runs * columns;
        for number in [length, 2, runs, columns] {
            answer.extend((number as u32).to_le_bytes());
        }
        rows.iter().flatten().for_each(|value| answer.extend(value.to_le_bytes()));
        Some(answer)
    }

    /// What it steers, if it does.
    fn curvature(&self, seen: &Seen) -> Option<f64> {
        match self.kind.as_str() {
            "steers" => (0.3..1.5).contains(&seen.time).then(|| if seen.time < 0.9 { 0.02 } else { -0.02 }),
            "steers_sharply" => Some(10.5),
            _ => None,
        }
    }

    fn decide(&self, seen: &Seen) -> Vec<f64> {
        let wanted = if seen.near { 0.0 } else { seen.cruise };
        let brakes = if seen.speed > 0.0 { -3.0 - self.gaps[seen.slot] / 100.0 } else { 0.0 };
        match self.gives.as_str() {
            "pedals" => vec![if seen.near { 0.0 } else { 0.3 }, if seen.near { 0.6 } else { 0.0 }],
            "speed" => vec![wanted],
            "speed_plan" => vec![0.0, seen.speed, 1.0, wanted],
            _ if self.kind == "nan" => vec![f64::NAN],
            _ if self.kind == "huge" => vec![51.0],
            _ if self.kind == "clock" => vec![clock()],
            _ if self.kind == "clock_a_bit" => vec![clock() / 1e3],
            _ if self.kind == "sometimes" && std::path::Path::new("worse").exists() => vec![-2.5],
            _ if self.kind == "sometimes" || self.kind == "gentle" => vec![-0.5],
            _ if self.kind == "counts" => vec![-1e-6 * self.steps as f64],
            _ if self.kind == "by_slot" => vec![-(seen.slot as f64) / 100.0],
            _ if self.kind == "harder" && seen.near && seen.time >= 0.5 => vec![-3.5],
            // The farther from 12.5 m, the less.
            _ if self.kind == "tuned" => vec![-((self.gaps[seen.slot] - 12.5) / 10.0).powi(2) / 10.0],
            _ => vec![if seen.near { brakes } else { 0.5 * (seen.cruise - seen.speed) }],
        }
    }

    /// What is answered in place of an answer, if it does not do worse.
    fn misbehave(&mut self, seen: &[Seen]) -> Option<String> {
        self.steps += 1;
        let first = seen[0];
        let late = first.time >= 0.5;
        let bad = seen.iter().find(|one| self.crashes[one.slot] && one.time >= 0.5);
        match self.kind.as_str() {
            "crash" if late => {
                eprintln!(
                    "Traceback (most recent call last):\n  File \"av.py\", line 3, in step\n    lane.width\nTraceback: lane is None"
                );
                process::exit(1)
            }
            "abort" if late => process::abort(),
            "exit_0" if late => process::exit(0),
            "hang" if late => hang(),
            "garbage" if late => Some("what is this?".to_string()),
            "fills_stdout" if late => {
                let answer = json!({"answer": [{"acceleration": 0.0}]}).to_string() + "\n";
                let many = answer.repeat(100);
                while io::stdout().write_all(many.as_bytes()).is_ok() {}
                hang()
            }
            "fills_stderr" if late => {
                // So much goes into a pipe as a whole, and so is there as a whole, whenever it is ended.
                let lines = "I think, and think again: what is it that I see? Who knows that?\n".repeat(63);
                while io::stderr().write_all(&lines.as_bytes()[..63 * 65]).is_ok() {}
                hang()
            }
            "answers_twice" if late => {
                let answer = json!({"answer": [{"acceleration": 0.0}]});
                Some(format!("{answer}\n{answer}"))
            }
            "answers_again" if late => {
                self.repeats = true;
                None
            }
            "too_few" if late => Some(json!({"answer": []}).to_string()),
            "endless" if late => {
                let line = vec![b'a'; 1 << 20];
                while io::stdout().write_all(&line).is_ok() {}
                hang()
            }
            "segfault" if late => {
                // The first one is taken for an overflow of the stack, which it is not.
                let script = "kill -SEGV $0; sleep 0.05; kill -SEGV $0";
                let own = process::id().to_string();
                process::Command::new("sh").args(["-c", script, &own]).status().unwrap();
                hang()
            }
            "forks" if late => {
                for number in 1_u32.. {
                    let own = env::current_exe().unwrap();
                    let mut more = process::Command::new(own);
                    more.args(["kind=silent"]).env("TESTS_UNDER_TEST", "child").stdin(process::Stdio::null());
                    // Without end, but not without pause: others use this machine.
                    std::mem::forget(more.spawn());
                    if number == 10 {
                        eprintln!("{number} processes and still forking");
                    }
                    thread::sleep(Duration::from_millis(50));
                }
                hang()
            }
            "slow" => {
                thread::sleep(Duration::from_millis(200));
                None
            }
            "grandchild" if late => {
                // It keeps the pipes, and does not end.
                let own = env::current_exe().unwrap();
                process::Command::new(own)
                    .args(["kind=silent"])
                    .env("TESTS_UNDER_TEST", "child")
                    .spawn()
                    .unwrap();
                process::exit(5)
            }
            "refuses" if late => {
                let errors: Vec<Value> =
                    seen.iter().map(|one| json!({"slot": one.slot, "message": "lane is None"})).collect();
                Some(json!({ "error": errors }).to_string())
            }
            "refuses_some" if bad.is_some() => {
                let bad = seen.iter().filter(|one| self.crashes[one.slot] && one.time >= 0.5);
                let errors: Vec<Value> =
                    bad.map(|one| json!({"slot": one.slot, "message": "lane is None"})).collect();
                Some(json!({ "error": errors }).to_string())
            }
            "crash_some" if bad.is_some() => process::exit(1),
            "crash_wide" if seen.iter().any(|one| self.gaps[one.slot] > 20.0) => process::exit(1),
            "crash_together" if seen.len() > 1 && late => process::exit(1),
            "flood" => {
                eprintln!("{}", "thinking ".repeat(2000));
                None
            }
            _ => None,
        }
    }
}

fn text_frame(text: &str) -> Vec<u8> {
    let mut frame = (text.len() as u32 + 4).to_le_bytes().to_vec();
    frame.extend([0; 4]);
    frame.extend(text.as_bytes());
    frame
}

/// An acceleration that no two processes share.
fn clock() -> f64 {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap();
    -f64::from(now.subsec_nanos()) / 1e9
}
