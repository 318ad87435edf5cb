//! What the gate of `suites/zebra_gate.suite` catches, and how often it raises a false alarm: braking that is worse by
//! some percent, and 200 reruns with other seeds in which nothing changed. `cargo bench --bench gates` prints the tables of
//! `docs/gates.md`.

use std::ops::Range;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use files::{Disk, Memory};
use models::standard;
use numbers::random::Stream;
use results::judge::baseline::Baseline;
use results::judge::gate::{ALONG_THE_WAY, LookRounds, blanket_rule, judge_gate, look_at};
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
        let pairs = asked.iter().find_map(|one| range(one)).unwrap_or(0..PAIRS);
        by_chance(pairs, !asked.iter().any(|one| one == "ends"));
    }
}

/// `100..400`: which pairs.
fn range(text: &str) -> Option<Range<u64>> {
    let (first, end) = text.split_once("..")?;
    Some(first.parse().ok()?..end.parse().ok()?)
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

/// Pairs of runs on different seeds. 12 s of one core each: `chance 100..400` is a part of them, `chance ends` leaves out the sequential gates.
const PAIRS: u64 = 400;

/// What pairs of such runs came to at a gate.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    alarms: u64,
    seen: u64,
    /// As Holm's correction would have it.
    by_holm: u64,
    /// Of the gate as a sequential one.
    sequential_alarms: u64,
    sequential_seen: u64,
    /// Pairs in which a rise to 5 % ended it before its end, and how many runs those took.
    ended: u64,
    runs: usize,
}

/// How often gates fail by chance, and how often for a rise of collisions from 0 to 1 %: pairs of that suite on different seeds.
/// Collisions are flags that are set by lot in 1 % of the candidate's runs, or in 5 %, whatever else happened in them.
fn by_chance(pairs: Range<u64>, looks: bool) {
    let files = Memory::default().with("thousand.suite", THOUSAND);
    let found = lang::load(Path::new("thousand.suite"), &standard(), &files);
    let suite = found.unwrap_or_else(|_| panic!("it is a suite")).suite;
    let next = AtomicU64::new(pairs.start);
    let counts = Mutex::new((0, vec![Counts::default(); suite.gates.len()]));
    println!("\nPairs {pairs:?} of other seeds of a suite of 1,000 runs:");
    let work = || {
        loop {
            let pair = next.fetch_add(1, Ordering::Relaxed);
            if pair >= pairs.end {
                return;
            }
            let own: Vec<Counts> = one_pair(&suite, pair, looks);
            let (done, counts) = &mut *counts.lock().expect("no thread panics");
            *done += 1;
            for (all, own) in counts.iter_mut().zip(own) {
                all.add(own);
            }
            if *done % 20 == 0 {
                println!("  after {done} pairs:");
                suite.gates.iter().zip(&*counts).for_each(|(gate, counts)| counts.print(gate, *done, looks));
            }
        }
    };
    std::thread::scope(|scope| {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        (0..threads).for_each(|_| _ = scope.spawn(work));
    });
}

fn one_pair(suite: &Suite, pair: u64, with_looks: bool) -> Vec<Counts> {
    let seeded = |seed| runs_on(&Suite { seed, ..suite.clone() }, &Threads::new(1));
    let (base, candidate) = (seeded(2 * pair + 1), seeded(2 * pair + 2));
    let column = base.metrics.iter().position(|one| one.label == "collision").expect("it is measured");
    let hit_in = |share: f64| {
        let mut hit = candidate.clone();
        let mut lot = Stream::seeded(pair);
        for value in hit.trials.iter_mut().flat_map(|trial| &mut trial.values[column]) {
            if lot.uniform() < share {
                *value = Some(1.0);
            }
        }
        hit
    };
    let (few, many) = (hit_in(0.01), hit_in(0.05));
    let own = |gate: &Gate| {
        let sequential = Gate { sequential: true, ..gate.clone() };
        let of_collisions =
            |check: &Check| check.label == "collision" && check.outcome == CheckOutcome::Regressed;
        let failed = |verdict: &GateVerdict| u64::from(verdict.verdict == Verdict::Failed);
        let verdict = judge(gate, &base, &candidate);
        if verdict.verdict == Verdict::Failed {
            println!("  pair {pair}, nothing changed, gate {}: {}", gate.name, in_words(&verdict));
        }
        let shared: Vec<f64> = verdict.checks.iter().filter_map(|check| check.p_value).collect();
        let is_alarm = verdict.primary == 0 && numbers::inference::holm(&shared).iter().any(|p| *p <= 0.025);
        // What is left of the error at the end is nine tenths of it, as adjusted p-values say.
        let at_the_end = |verdict: &GateVerdict, counts: &dyn Fn(&Check) -> bool| {
            let least = 0.025 * (1.0 - ALONG_THE_WAY);
            verdict
                .checks
                .iter()
                .any(|check| counts(check) && check.adjusted_p_value.is_some_and(|p| p <= least))
        };
        let ended = |candidate: &Baseline| {
            if !with_looks {
                return None;
            }
            let mut looks = LookRounds::of(candidate).looks();
            looks.find_map(|after| {
                look_at(&sequential, &base, candidate, false, after).expect("they may be compared")
            })
        };
        let with_few = judge(gate, &base, &few);
        let ended_by_many = ended(&many);
        Counts {
            alarms: failed(&verdict),
            seen: u64::from(with_few.checks.iter().any(of_collisions)),
            by_holm: u64::from(is_alarm),
            sequential_alarms: u64::from(ended(&candidate).is_some() || at_the_end(&verdict, &|_| true)),
            sequential_seen: u64::from(
                ended(&few).is_some() || at_the_end(&with_few, &|check| check.label == "collision"),
            ),
            ended: u64::from(ended_by_many.is_some()),
            runs: ended_by_many.map_or(0, |verdict| verdict.runs),
        }
    };
    suite.gates.iter().map(own).collect()
}

impl Counts {
    fn add(&mut self, other: Self) {
        self.alarms += other.alarms;
        self.seen += other.seen;
        self.by_holm += other.by_holm;
        self.sequential_alarms += other.sequential_alarms;
        self.sequential_seen += other.sequential_seen;
        self.ended += other.ended;
        self.runs += other.runs;
    }

    fn print(&self, gate: &Gate, pairs: u64, looks: bool) {
        let percent = |count: u64| 100.0 * count as f64 / pairs as f64;
        println!(
            "    gate {}: {} false alarms ({:.2} %; {} by Holm's correction), a rise of collisions from 0 to 1 % seen in {:.1} %",
            gate.name,
            self.alarms,
            percent(self.alarms),
            self.by_holm,
            percent(self.seen),
        );
        if !looks {
            return;
        }
        println!(
            "      as a sequential one: {} false alarms ({:.2} %), seen in {:.1} %; a rise to 5 % ended it in {:.1} %, after {:.0} runs on average",
            self.sequential_alarms,
            percent(self.sequential_alarms),
            percent(self.sequential_seen),
            percent(self.ended),
            self.runs as f64 / self.ended.max(1) as f64,
        );
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
    runs_on(suite, &Threads::all())
}

fn runs_on(suite: &Suite, threads: &Threads) -> Baseline {
    let plan = plan(suite).expect("the suite can be planned");
    let requests = Requests::defaults(&standard());
    let measured = MeasuredMetrics::new(requests.clone());
    let batch = RunBatch { executor: threads, measured: &measured, stop: &Stop::default() };
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
        sequential: false,
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
