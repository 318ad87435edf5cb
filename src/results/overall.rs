//! What a session came to as a whole.

use serde::Serialize;

use super::Results;
use super::gate::{GateReport, GateState, NotJudged};
use super::rating::RatingReport;
use super::standing::Standing;
use super::suite::SuiteReport;
use super::verdict::Verdict;

/// The worst that became of anything. What failed by itself goes before what got worse than it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Overall {
    /// A trial, block or rating failed, could not be run or was cut off.
    Failed,
    /// A gate failed: something got worse than its baseline.
    Regressed,
    /// A gate's baseline cannot be compared with.
    NotComparable,
    /// Something could not be decided, or a gate or rating was not looked at.
    Inconclusive,
    /// No criterion applied to anything that was run.
    NothingJudged,
    /// Everything that was judged passed, and something was judged or found.
    Passed,
}

impl Results {
    /// The verdict on all units. A unit that was not judged has not passed, nor has one that was never put to the test where that is denied.
    pub fn overall(&self) -> Overall {
        match overall(&self.suites) {
            Overall::Passed if self.denies_untested && self.untested() > 0 => Overall::Inconclusive,
            overall => overall,
        }
    }

    /// In how many units something passed that was not put to the test.
    pub fn untested(&self) -> usize {
        self.suites.iter().map(SuiteReport::untested).sum()
    }

    /// The code with which a program that ran this ends.
    pub fn exit_code(&self) -> u8 {
        match self.suites.iter().any(|suite| suite.interrupted) {
            true => INTERRUPTED,
            false => self.overall().exit_code(),
        }
    }
}

/// The exit code of what was interrupted.
const INTERRUPTED: u8 = 105;

impl Overall {
    /// The exit code of it.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Passed => 0,
            Self::Failed => 100,
            Self::Inconclusive | Self::NothingJudged => 102,
            Self::NotComparable => 103,
            Self::Regressed => 104,
        }
    }
}

fn overall(suites: &[SuiteReport]) -> Overall {
    let gates = || suites.iter().flat_map(|suite| &suite.gates);
    let standings = || gates().map(GateReport::standing);
    let ratings = || suites.iter().flat_map(|suite| &suite.ratings);
    // What a rating expects is a verdict like that of a trial.
    let rated = || ratings().map(RatingReport::standing);
    let units = || suites.iter().flat_map(SuiteReport::standings).chain(rated());
    let broken = |gate: &GateReport| matches!(gate.state, GateState::NotJudged(NotJudged::Broken(_)));
    if units().any(Standing::is_failure) || gates().any(broken) {
        Overall::Failed
    } else if standings().any(|gate| gate == Standing::Judged(Verdict::Failed)) {
        Overall::Regressed
    } else if standings().any(|gate| gate == Standing::Errored) {
        Overall::NotComparable
    } else if !standings().chain(units()).any(|one| matches!(one, Standing::Judged(_) | Standing::Found)) {
        Overall::NothingJudged
    } else if gates().any(GateReport::is_open)
        || ratings().any(RatingReport::is_open)
        || standings().chain(units()).any(|one| one == Standing::Judged(Verdict::Inconclusive))
    {
        Overall::Inconclusive
    } else {
        Overall::Passed
    }
}
