//! What the gate of `suites/zebra_gate.suite` catches, and how often it raises a false alarm: braking that is worse by
//! some percent, and 200 reruns with other seeds in which nothing changed. `cargo bench --bench gates` prints the tables of
//! `docs/gates.md`.

use std::path::Path;

use files::{Disk, Memory};
use models::standard;
use numbers::random::Stream;
use results::judge::baseline::Baseline;
use results::judge::gate::{blanket_rule, judge_gate};
use results::{Check, CheckOutcome, ComparedSubject, GateVerdict, Requests, Verdict};
use runner::baseline::record;
use runner::plan::plan;
use runner::run::{MeasuredMetrics, RunBatch, Stop, Threads};
use scenario::{Expression, Gate, Suite, Value};

const RERUNS: u64 = 200;

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let wanted = |part: &str| asked.is_empty() || asked.iter().any(|one| one == part);
    if wanted("braking") || wanted("reruns") {
        zebra_gate(wanted("braking"), wanted("reruns"));
    }
    if wanted("zebra") {
        zebra();
    }
    if wanted("chance") {
        by_chance();
    }
}

/// A suite of 1,000 runs in which nobody is hit.
const THOUSAND: &str = "suite thousand {
  scenario late_walker {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av {
      controller carla_behavior { profile: normal, obstacle_distance: extended }
      speed 30 km/h
    }
    pedestrian walker {
      model carla_walker
      size 0.375 m x 0.375 m
      start 4 m from lane centre, 2 m from kerb
      appears when time_to_arrival(av) = tta
    }
    vary tta in [4 s, 4.5 s, 5 s, 5.5 s, 6 s]
    repeat 200
    expect { rate(collision) <= 5 % }
  }
  gate careful {
    baseline \"thousand.json\"
    no metric worse by more than 5 % with 95 % confidence
    primary collision not worse
    rate(pet < 1.5 s) not worse by more than 2 %
  }
  gate strict {
    baseline \"thousand.json\"
    no metric worse
    collision not worse
    rate(pet < 1.5 s) not worse
  }
}
";

/// How often gates fail by chance, and how often for a rise of collisions from 0 to 1 %: pairs of that suite on different seeds.
/// Collisions are flags that are set by lot in 1 % of the candidate's runs, whatever else happened in them.
fn by_chance() {
    const PAIRS: u64 = 400;
    let files = Memory::default().with("thousand.suite", THOUSAND);
    let found = lang::load(Path::new("thousand.suite"), &standard(), &files);
    let suite = found.unwrap_or_else(|_| panic!("it is a suite")).suite;
    let seeded = |seed| runs(&Suite { seed, ..suite.clone() });
    println!("\n{PAIRS} pairs of other seeds of a suite of {} runs:", seeded(1).runs());
    let mut counts = vec![[0; 3]; suite.gates.len()];
    let mut collisions = 0.0;
    for pair in 0..PAIRS {
        let (base, candidate) = (seeded(2 * pair + 1), seeded(2 * pair + 2));
        let column = base.metrics.iter().position(|one| one.label == "collision").expect("it is measured");
        let flags = |side: &Baseline| {
            side.trials.iter().flat_map(|trial| trial.values[column].clone()).flatten().sum::<f64>()
        };
        collisions += flags(&base) + flags(&candidate);
        let mut hit = candidate.clone();
        let mut lot = Stream::seeded(pair);
        for value in hit.trials.iter_mut().flat_map(|trial| &mut trial.values[column]) {
            if lot.uniform() < 0.01 {
                *value = Some(1.0);
            }
        }
        for (gate, counts) in suite.gates.iter().zip(&mut counts) {
            let verdict = judge(gate, &base, &candidate);
            counts[0] += u64::from(verdict.verdict == Verdict::Failed);
            if verdict.verdict == Verdict::Failed {
                println!("  pair {pair}, nothing changed, gate {}: {}", gate.name, in_words(&verdict));
            }
            let of_collisions =
                |check: &Check| check.label == "collision" && check.outcome == CheckOutcome::Regressed;
            counts[1] += u64::from(judge(gate, &base, &hit).checks.iter().any(of_collisions));
            // As Holm's correction would have it.
            let holm = |verdict: &GateVerdict| {
                let shared: Vec<f64> = verdict.checks.iter().filter_map(|check| check.p_value).collect();
                verdict.primary == 0 && numbers::inference::holm(&shared).iter().any(|p| *p <= 0.025)
            };
            counts[2] += u64::from(holm(&verdict));
        }
    }
    println!("  collisions in those runs: {collisions}");
    for (gate, [alarms, seen, by_holm]) in suite.gates.iter().zip(counts) {
        let percent = |count: u64| 100.0 * count as f64 / PAIRS as f64;
        println!(
            "  gate {}: {:.2} % false alarms, a rise of collisions from 0 to 1 % seen in {:.1} %",
            gate.name,
            percent(alarms),
            percent(seen)
        );
        if gate.rules.iter().all(|rule| !rule.primary) {
            println!("    false alarms by Holm's correction: {:.2} %", percent(by_holm));
        }
    }
}

/// `suites/zebra_gate.suite` with its own gate: braking that is worse, and reruns in which nothing is.
fn zebra_gate(braking: bool, reruns: bool) {
    let suite = suite("suites/zebra_gate.suite");
    let gate = &suite.gates[0];
    let base = runs(&suite);
    println!("suites/zebra_gate.suite, {} runs, seed {}", base.runs(), suite.seed);
    if braking {
        worse_braking(&suite, gate, &base);
    }
    if reruns {
        other_seeds(&suite, gate, &base);
    }
}

fn worse_braking(suite: &Suite, gate: &Gate, base: &Baseline) {
    println!("\nbraking worse by some percent, same seeds:");
    for (what, parameter, declared, worse) in [
        ("brakes later", "braking_distance", 5.0, later as fn(f64, f64) -> f64),
        ("brakes more weakly", "emergency_brake", 0.5, longer),
    ] {
        for percent in [0.5, 1.0, 2.0, 3.0, 5.0, 10.0] {
            let value = worse(declared, percent);
            let verdict = judge(gate, base, &runs(&with(suite, parameter, value)));
            println!("  {what:<20} by {percent:>4} % ({parameter} {value:.4}): {}", in_words(&verdict));
        }
    }
}

fn other_seeds(suite: &Suite, gate: &Gate, base: &Baseline) {
    println!("\n{RERUNS} reruns with other seeds, nothing changed:");
    let mut alarms = 0;
    let mut not_shown = 0;
    let mut comparisons = 0;
    for seed in 1..=RERUNS {
        let verdict = judge(gate, base, &runs(&Suite { seed, ..suite.clone() }));
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
