//! The controller under test, which speaks lines of JSON. Standard output belongs to the runner: print with `eprintln!`.

use std::collections::HashMap;
use std::io::{self, BufRead, Write};

use serde_json::{json, Value};

fn number(of: &Value, name: &str) -> f64 {
    of[name].as_f64().unwrap_or(f64::NAN)
}

/// x is ahead of the vehicle's centre, y to the left of the middle of its lane.
fn decide(seen: &Value, gap: f64) -> Value {
    let ego = &seen["ego"];
    let (speed, length) = (number(ego, "speed"), number(ego, "length"));
    let people = seen["pedestrians"].as_array().into_iter().flatten();
    let near = people.filter(|one| number(one, "x") > 0.0 && number(one, "y").abs() < 4.0);
    let braking = near.map(|one| speed * speed / (2.0 * (number(one, "x") - length / 2.0 - gap).max(0.1)));
    let needed = braking.fold(0.0, f64::max);
    if needed > 1.0 {
        json!({"acceleration": -needed.min(6.0), "mode": "brake"})
    } else {
        json!({"acceleration": 0.5 * (number(seen, "cruise_speed") - speed), "mode": "cruise"})
    }
}

fn main() -> io::Result<()> {
    // What is kept of a run stands under its slot.
    let mut gaps: HashMap<u64, f64> = HashMap::new();
    for line in io::stdin().lock().lines() {
        let said: Value = serde_json::from_str(&line?)?;
        let answer = if said.get("hello").is_some() {
            json!({"hello": {"protocol": 1, "name": "my_av", "version": "1", "runs_at_once": 64, "parameters": [
                {"name": "gap", "unit": "m", "default": 3.0, "low": 1.0, "high": 10.0},
            ]}})
        } else if let Some(runs) = said["open"].as_array() {
            for run in runs {
                gaps.insert(run["slot"].as_u64().unwrap_or(0), number(&run["parameters"], "gap"));
            }
            json!({"ready": runs.iter().map(|run| &run["slot"]).collect::<Vec<_>>()})
        } else if let Some(runs) = said["step"].as_array() {
            let decided = runs.iter().map(|seen| decide(seen, gaps[&seen["slot"].as_u64().unwrap_or(0)]));
            json!({"answer": decided.collect::<Vec<_>>()})
        } else {
            continue;
        };
        println!("{answer}");
        io::stdout().flush()?;
    }
    Ok(())
}
