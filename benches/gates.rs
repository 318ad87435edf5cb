//! What the gate of `suites/zebra_gate.suite` catches, and how often it raises a false alarm: braking that is worse by
//! some percent, and 200 reruns with other seeds in which nothing changed. `cargo bench --bench gates` prints the tables of
//! `docs/gates.md`.

use std::path::Path;

use files::Disk;
use models::standard;
use results::judge::baseline::Baseline;
use results::judge::gate::{blanket_rule, judge_gate};
use results::{Check, CheckOutcome, ComparedSubject, GateVerdict, Requests, Verdict};
use runner::baseline::record;
use runner::plan::plan;
use runner::run::{MeasuredMetrics, RunBatch, Stop, Threads};
use scenario::{Expression, Gate, Suite, Value};

const RERUNS: u64 = 200;

fn main() {
    let suite = suite("suites/zebra_gate.suite");
    let gate = &suite.gates[0];
    let base = runs(&suite);
    println!("suites/zebra_gate.suite, {} runs, seed {}", base.runs(), suite.seed);
    println!("\nbraking worse by some percent, same seeds:");
    for (what, parameter, declared, worse) in [
        ("brakes later", "braking_distance", 5.0, later as fn(f64, f64) -> f64),
        ("brakes more weakly", "emergency_brake", 0.5, longer),
    ] {
        for percent in [0.5, 1.0, 2.0, 3.0, 5.0, 10.0] {
            let value = worse(declared, percent);
            let verdict = judge(gate, &base, &runs(&with(&suite, parameter, value)));
            println!("  {what:<20} by {percent:>4} % ({parameter} {value:.4}): {}", in_words(&verdict));
        }
    }
    println!("\n{RERUNS} reruns with other seeds, nothing changed:");
    let mut alarms = 0;
    let mut not_shown = 0;
    let mut comparisons = 0;
    for seed in 1..=RERUNS {
        let verdict = judge(gate, &base, &runs(&Suite { seed, ..suite.clone() }));
        if verdict.verdict != Verdict::Passed {
            alarms += 1;
            println!("  seed {seed}: {}", in_words(&verdict));
        }
        not_shown += verdict.count(CheckOutcome::NotShown);
        comparisons += verdict.checks.len();
    }
    println!("  {} passed, {alarms} did not", RERUNS - alarms);
    println!(
        "  {:.0} % of the comparisons were not shown either way",
        100.0 * not_shown as f64 / comparisons as f64
    );
    zebra();
}

/// `suites/zebra.suite` as it ships, and with more runs: nobody needs to brake in most of them.
fn zebra() {
    println!(
        "\nsuites/zebra.suite by `no metric worse by more than 5 % with 95 % confidence`, braking 5 % later:"
    );
    let suite = suite("suites/zebra.suite");
    let gate = Gate { rules: vec![blanket_rule(0.05, 0.95)], ..empty_gate() };
    for times in [1, 2, 5, 10, 20] {
        let mut suite = suite.clone();
        suite.scenarios.iter_mut().for_each(|scenario| scenario.repeat *= times);
        let base = runs(&suite);
        let verdict = judge(&gate, &base, &runs(&with(&suite, "braking_distance", later(5.0, 5.0))));
        println!("  repeat x {times:<3} {:>5} runs: {}", base.runs(), in_words(&verdict));
    }
}

/// A distance at which to brake that is shorter.
fn later(distance: f64, percent: f64) -> f64 {
    distance * (1.0 - percent / 100.0)
}

/// A pedal with which the way to stop is longer.
fn longer(pedal: f64, percent: f64) -> f64 {
    pedal / (1.0 + percent / 100.0)
}

fn suite(path: &str) -> Suite {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    lang::load(&path, &standard(), &Disk).unwrap_or_else(|_| panic!("{} is a suite", path.display())).suite
}

fn with(suite: &Suite, parameter: &str, value: f64) -> Suite {
    let mut suite = suite.clone();
    for vehicle in suite.scenarios.iter_mut().flat_map(|scenario| &mut scenario.vehicles) {
        vehicle.controller.settings.push((parameter.to_string(), Expression::Constant(Value::Number(value))));
    }
    suite
}

fn runs(suite: &Suite) -> Baseline {
    let plan = plan(suite).expect("the suite can be planned");
    let requests = Requests::defaults(&standard());
    let (threads, measured) = (Threads::all(), MeasuredMetrics::new(requests.clone()));
    let batch = RunBatch { executor: &threads, measured: &measured, stop: &Stop::default() };
    let trials: Vec<_> = plan
        .trials()
        .map(|trial| {
            let outcomes = batch.outcomes(trial.cases.iter(), || {}).expect("every case can be run");
            (trial, outcomes)
        })
        .collect();
    let trials: Vec<_> = trials.iter().map(|(trial, outcomes)| (trial, &outcomes[..])).collect();
    record(&plan, &trials, &requests)
}

fn judge(gate: &Gate, base: &Baseline, candidate: &Baseline) -> GateVerdict {
    judge_gate(gate, base, candidate, false).expect("they may be compared")
}

fn empty_gate() -> Gate {
    Gate {
        name: String::new(),
        doc: None,
        baseline: String::new(),
        rules: Vec::new(),
        origin: Default::default(),
    }
}

fn in_words(verdict: &GateVerdict) -> String {
    let regressed = verdict.checks.iter().filter(|check| check.outcome == CheckOutcome::Regressed);
    let name = |check: &Check| {
        let by = match (check.subject, check.base) {
            (ComparedSubject::Mean, base) if base != 0.0 => {
                format!("{:.1} %", 100.0 * check.worse_by() / base.abs())
            }
            (ComparedSubject::Mean, _) => format!("{:.3}", check.worse_by()),
            (ComparedSubject::Rate | ComparedSubject::Existence | ComparedSubject::New, _) => {
                format!("{:.1} points", 100.0 * check.worse_by())
            }
        };
        format!("{} in {} by {by}", check.label, check.place)
    };
    let names: Vec<_> = regressed.map(name).collect();
    match verdict.verdict {
        Verdict::Failed => format!("caught: {}", names.join(", ")),
        Verdict::Inconclusive => "inconclusive".to_string(),
        Verdict::Passed => format!("passed, {} not shown", verdict.count(CheckOutcome::NotShown)),
    }
}
