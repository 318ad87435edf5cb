//! What later units build on.

use std::sync::Arc;

use super::unit::Work;
use crate::plan::PlannedTrial;

use crate::experiment::EarlierResults;
use results::{BlockResult, Outcome, TrialState, UnitReport};
use scenario::Case;

/// What others may need of a unit.
#[derive(Debug)]
pub enum Usable {
    /// The runs of a trial.
    Runs {
        /// The scenario's name.
        scenario: String,
        /// In the order of the trial.
        runs: Vec<(Case, Outcome)>,
    },
    /// A block with a result that others can build on.
    Block {
        /// As the suite calls it.
        name: String,
        /// What it came to.
        result: Box<BlockResult>,
    },
}

impl Usable {
    /// Of what became of a unit that is this work; `None` if there is nothing to build on.
    pub fn of(work: &Work, report: &UnitReport) -> Option<Self> {
        match report {
            UnitReport::Recorded(_) => None,
            UnitReport::Trial(report) => {
                let Work::Trial(PlannedTrial { cases, .. }) = work else { return None };
                matches!(report.state, TrialState::Judged(_)).then(|| Self::Runs {
                    scenario: report.trial.scenario.clone(),
                    runs: cases.iter().zip(report.outcomes.iter().cloned()).collect(),
                })
            }
            UnitReport::Block(report) => {
                let result = report.result().filter(|result| result.is_usable())?;
                Some(Self::Block { name: report.block.name().to_string(), result: Box::new(result.clone()) })
            }
        }
    }

    /// Several as a block reads them; runs of a scenario come in the order of its trials.
    pub fn gather(kept: impl IntoIterator<Item = Arc<Self>>) -> EarlierResults {
        let mut results = EarlierResults::default();
        for one in kept {
            match &*one {
                Self::Runs { scenario, runs } => {
                    results.scenarios.entry(scenario.clone()).or_default().extend(runs.iter().cloned());
                }
                Self::Block { name, result } => {
                    results.blocks.insert(name.clone(), (**result).clone());
                }
            }
        }
        results
    }
}
