//! The seeds that suites were run with since one of them did not pass, so that trying seeds until one passes shows.

use std::io;

use super::tries::{Tries, Try};
use results::{Standing, SuiteIdentity, SuiteReport, TriedSeed, Verdict};
use runner::project::PlannedSuite;

/// In the program's own folder.
const FILE: &str = "seeds.json";

impl Try for TriedSeed {
    fn is_like(&self, other: &Self) -> bool {
        self.seed == other.seed
    }

    fn passed(&self) -> bool {
        self.passed
    }
}

/// By suite.
#[derive(Debug, Default)]
pub struct TriedSeeds(Tries<TriedSeed>);

impl TriedSeeds {
    /// What is remembered, or a sentence on why that cannot be read.
    pub fn read() -> Result<Self, String> {
        Tries::read(FILE).map(Self)
    }

    /// Those of each suite, but for the one that it is run with now.
    pub fn earlier(&self, suites: &[PlannedSuite]) -> Vec<Vec<TriedSeed>> {
        let of = |suite: &PlannedSuite| {
            let now = TriedSeed { seed: suite.plan.seed, passed: true };
            self.0.earlier(&name(&suite.file, &suite.suite.name, &suite.suite.set), &now)
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
            let good = |one: Standing| {
                matches!(one, Standing::NotJudged | Standing::Found | Standing::Judged(Verdict::Passed))
            };
            let passed = match standings().filter(|one| *one != Standing::Skipped).all(good) {
                true if report.interrupted || standings().any(|one| one == Standing::Skipped) => continue,
                passed => passed,
            };
            // The file tells suites of one name apart.
            let suite = suite.rsplit('/').next().unwrap_or(suite);
            self.0.learn(name(file, suite, set), TriedSeed { seed: *seed, passed });
        }
    }

    /// Writes them, if there is or was anything to remember.
    pub fn write(&self) -> io::Result<()> {
        self.0.write(FILE)
    }
}

/// What is run but for its seed.
fn name(file: &str, suite: &str, set: &[String]) -> String {
    [file, suite].into_iter().chain(set.iter().map(String::as_str)).collect::<Vec<_>>().join(" | ")
}
