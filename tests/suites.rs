//! The suites that ship, trial by trial, as a Rust project that keeps scenarios beside its code writes it; and every bit of
//! what they run.
//!
//! `tests/fingerprints` holds a line a run, a block and a metric. The three parts of the paper's suite run the same cases
//! as that does (a test says so). What takes long, as that suite does, is ignored here and run by `.ci/run --all`.

use std::collections::HashMap;
use std::path::Path;
use std::process::ExitCode;

use files::Disk;
use libtest_mimic::{Failed, Trial};
use models::standard;
use runner::corpus::case_hash;
use runner::plan::plan;
use scenario_runner::testing::{Suites, TestingError, conclude};

/// Expected to pass, trial by trial.
const PASSING: &[&str] = &[
    "suites/zebra.suite",
    "suites/worst_arrival.suite",
    "suites/zebra_gate.suite",
    "suites/un_r152.suite",
    "suites/fmvss_127.suite",
    "suites/un_r157.suite",
    "suites/euro_ncap_vru.suite",
    "suites/euro_ncap_robustness.suite",
    "suites/euro_ncap_vru_people.suite",
    "suites/streets.suite",
];

/// Run for their bits alone: they fail, or are tables to look at.
const OTHERS: &[&str] = &[
    "suites/zebra_unsafe.suite",
    "suites/nhtsa_precrash.suite",
    "suites/matrix.suite",
    "suites/gentle_braking.suite",
    // Every setting of `suites/paper/sensitivity.suite`, which takes as long as all the others.
    "tests/commands/settings.suite",
];

/// As the others, and takes minutes. The paper's tunes break their constraints, as they do in the paper, and so fail.
const LONG: &[&str] = &[
    "suites/paper.suite",
    "suites/paper/sensitivity.suite",
    "suites/paper/beyond.suite",
    "suites/paper/people.suite",
    "suites/rare.suite",
];

/// Needs controllers of others, which `examples/controllers/check` installs and runs.
const OF_PROGRAMS: &[&str] = &["suites/own_controllers.suite"];

const PARTS: &[&str] =
    &["suites/paper/behaviour.suite", "suites/paper/search.suite", "suites/paper/tune.suite"];

fn main() -> ExitCode {
    conclude(trials())
}

fn trials() -> Result<Vec<Trial>, TestingError> {
    let folder = Path::new("tests/fingerprints");
    let suites = Suites::load(&[LONG, PASSING, OTHERS].concat(), &standard())?;
    let long = suites.fingerprints(LONG, folder)?.into_iter();
    let mut trials: Vec<Trial> = long.map(|test| test.with_ignored_flag(true)).collect();
    trials.extend(suites.tests(PASSING)?);
    trials.extend(suites.fingerprints(&[PASSING, OTHERS].concat(), folder)?);
    trials.push(Trial::test("every shipped suite is held", every_suite_is_held));
    trials.push(Trial::test("the parts of the paper's suite are parts of it", parts_are_parts));
    Ok(trials)
}

fn every_suite_is_held() -> Result<(), Failed> {
    let held: Vec<&str> = [PASSING, OTHERS, LONG, PARTS, OF_PROGRAMS].concat();
    for pattern in ["suites/*.suite", "suites/*/*.suite"] {
        for path in glob::glob(pattern).expect("a pattern") {
            let path = path?.to_string_lossy().into_owned();
            if !held.contains(&path.as_str()) {
                return Err(format!("nobody holds the fingerprints of {path}").into());
            }
        }
    }
    Ok(())
}

/// Every case of a part is a case of the whole: same key, same world, same seed.
fn parts_are_parts() -> Result<(), Failed> {
    let whole = cases("suites/paper.suite")?;
    for part in PARTS {
        for (key, hash) in cases(part)? {
            if whole.get(&key) != Some(&hash) {
                return Err(format!("{part}: {key} is another case than in suites/paper.suite").into());
            }
        }
    }
    Ok(())
}

fn cases(file: &str) -> Result<HashMap<String, u64>, Failed> {
    let suite =
        lang::load(Path::new(file), &standard(), &Disk).map_err(|_| format!("{file} has errors"))?.suite;
    let plan = plan(&suite).map_err(|errors| errors[0].message.clone())?;
    let cases = plan.trials().flat_map(|trial| trial.cases.iter().collect::<Vec<_>>());
    Ok(cases.map(|case| (case.key.clone(), case_hash(&case))).collect())
}
