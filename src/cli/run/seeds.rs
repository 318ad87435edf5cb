//! The seeds that suites were run with since one of them did not pass, so that trying seeds until one passes shows.

use std::collections::BTreeMap;
use std::io;

use serde::{Deserialize, Serialize};

use crate::cli::store;
use results::{Standing, SuiteIdentity, SuiteReport, TriedSeed, Verdict};
use runner::project::PlannedSuite;

/// In the program's own folder.
const FILE: &str = "seeds.json";

/// What is remembered of a suite at most; the oldest that passed are forgotten first.
const MOST: usize = 1000;

/// By suite: nothing of one of which every seed passed that is known.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct TriedSeeds(BTreeMap<String, Vec<TriedSeed>>);

impl TriedSeeds {
    /// What is remembered, or a sentence on why that cannot be read.
    pub fn read() -> Result<Self, String> {
        let text = match store::read(FILE) {
            Ok(text) => text,
            Err(error) if error.is_missing() => return Ok(Self::default()),
            Err(error) => return Err(error.to_string()),
        };
        serde_json::from_str(&text).map_err(|error| error.to_string())
    }

    /// Those of each suite, but for the one that it is run with now.
    pub fn earlier(&self, suites: &[PlannedSuite]) -> Vec<Vec<TriedSeed>> {
        let of = |suite: &PlannedSuite| {
            let known = self.0.get(&name(&suite.file, &suite.plan.suite, &suite.suite.set));
            known.into_iter().flatten().filter(|one| one.seed != suite.plan.seed).copied().collect()
        };
        suites.iter().map(of).collect()
    }

    /// Takes over what suites came to. A part of one that passed says nothing about the whole.
    pub fn learn(&mut self, reports: &[SuiteReport]) {
        for report in reports {
            let SuiteIdentity { suite, file, seed, set, .. } = &report.identity;
            let standings = || {
                let rated = report.ratings.iter().map(|rating| rating.standing());
                let compared = report.gates.iter().map(|gate| gate.standing());
                report.standings().chain(rated).chain(compared)
            };
            let good = |one: Standing| matches!(one, Standing::NotJudged | Standing::Judged(Verdict::Passed));
            let passed = match standings().filter(|one| *one != Standing::Skipped).all(good) {
                true if report.interrupted || standings().any(|one| one == Standing::Skipped) => continue,
                passed => passed,
            };
            let name = name(file, suite, set);
            let tried = self.0.entry(name.clone()).or_default();
            match tried.iter_mut().find(|one| one.seed == *seed) {
                Some(known) => known.passed = passed,
                None => tried.push(TriedSeed { seed: *seed, passed }),
            }
            if tried.len() > MOST {
                let place = tried.iter().position(|one| one.passed).unwrap_or(0);
                tried.remove(place);
            }
            if tried.iter().all(|one| one.passed) {
                self.0.remove(&name);
            }
        }
    }

    /// Writes them, if there is or was anything to remember.
    pub fn write(&self) -> io::Result<()> {
        if self.0.is_empty() {
            return store::remove(FILE);
        }
        store::write(FILE, &(serde_json::to_string_pretty(self).expect("plain data serialises") + "\n"))
    }
}

/// What is run but for its seed.
fn name(file: &str, suite: &str, set: &[String]) -> String {
    [file, suite].into_iter().chain(set.iter().map(String::as_str)).collect::<Vec<_>>().join(" | ")
}
