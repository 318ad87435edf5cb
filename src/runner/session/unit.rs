//! The units of suites: what is selected, run and reported, and what each needs.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use crate::experiment::{Need, needs as needs_of};
use crate::plan::PlannedTrial;
use crate::project::PlannedSuite;
use results::Recorded;
use scenario::Block;

/// One trial or block, or a run that failed before.
#[derive(Debug)]
pub struct Unit<'a> {
    /// Index of its suite.
    pub suite: usize,
    /// Its name in every report.
    pub key: Cow<'a, str>,
    pub work: Work<'a>,
    /// Indices of the units whose results it reads; all of them come before it.
    pub needs: Vec<usize>,
}

#[derive(Debug, Clone)]
pub enum Work<'a> {
    /// A run that failed in an earlier session.
    Recorded(&'a Recorded),
    Trial(PlannedTrial),
    Block(Arc<Block>),
}

impl Unit<'_> {
    /// How many runs it is; those of a block cannot be counted beforehand.
    pub fn runs(&self) -> usize {
        match &self.work {
            Work::Trial(trial) => trial.cases.len(),
            Work::Recorded(_) => 1,
            Work::Block(_) => 0,
        }
    }
}

/// Every unit of the suites, suite after suite: what failed before, the trials, the blocks.
pub fn units(suites: &[PlannedSuite]) -> Vec<Unit<'_>> {
    let mut units = Vec::new();
    for (suite, prepared) in suites.iter().enumerate() {
        let mut known = HashSet::new();
        for recorded in &prepared.recorded {
            let mut key = recorded.unit_key();
            if !known.insert(key.clone()) {
                // The same run of the suite failed under another seed, too.
                key += &format!("/seed={}", recorded.seed);
            }
            units.push(Unit { suite, key: key.into(), work: Work::Recorded(recorded), needs: Vec::new() });
        }
        let mut scenarios: HashMap<String, Vec<usize>> = HashMap::new();
        for trial in prepared.plan.trials() {
            scenarios.entry(trial.scenario.clone()).or_default().push(units.len());
            let key = Cow::Owned(trial.key.clone());
            units.push(Unit { suite, key, work: Work::Trial(trial), needs: Vec::new() });
        }
        let mut blocks: HashMap<&str, usize> = HashMap::new();
        let all = Block::all(&prepared.suite);
        for block in &all {
            let mut needs = Vec::new();
            for need in needs_of(block) {
                // What is not there was reported by the checker, or is by the block itself.
                match need {
                    Need::Block(name) => needs.extend(blocks.get(name.as_str())),
                    Need::Scenario(name) => needs.extend(scenarios.get(name.as_str()).into_iter().flatten()),
                }
            }
            blocks.insert(block.name(), units.len());
            let key = Cow::Owned(block.key(&prepared.suite.name));
            units.push(Unit { suite, key, work: Work::Block(block.clone()), needs });
        }
    }
    units
}

/// Whether each unit is to run: those that are wanted, and all that they need.
pub fn with_needs(units: &[Unit], mut wanted: Vec<bool>) -> Vec<bool> {
    // Needs come before those who need them.
    for (index, unit) in units.iter().enumerate().rev() {
        if wanted[index] {
            unit.needs.iter().for_each(|need| wanted[*need] = true);
        }
    }
    wanted
}
