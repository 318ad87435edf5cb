//! What is kept of a suite's trials while they run: each of them, or what a summary needs.

use std::collections::{BTreeMap, HashMap};
use std::mem;

use crate::plan::Plan;
use results::{
    MOST_SHOWN, PassedTrial, ScenarioSummary, Skip, Standing, SuiteSummary, TrialReport, Verdict,
};
use scenario::Assignment;

/// The trials of one suite.
pub struct KeptTrials<'a> {
    plan: &'a Plan,
    /// By their places in the suite.
    held: BTreeMap<usize, TrialReport>,
    /// `None` where every trial is held.
    counted: Option<Vec<Counted>>,
    /// The indices of scenarios among those that are counted, by name.
    names: HashMap<String, usize>,
}

/// A scenario of which not every trial is held.
#[derive(Default)]
struct Counted {
    summary: ScenarioSummary,
    /// Trials that passed, by their places, with the index of their criteria: those that are held as long as there are few…
    few: Vec<(usize, u32)>,
    /// …and those that are not.
    passed: Vec<(usize, u32)>,
}

impl<'a> KeptTrials<'a> {
    /// With `every` trial, or without those that passed of scenarios with many, and without those that are not run.
    pub fn new(plan: &'a Plan, every: bool) -> Self {
        let mut kept = Self { plan, held: BTreeMap::new(), counted: None, names: HashMap::new() };
        if !every {
            let mut counted = Vec::new();
            for scenario in plan.scenarios().iter().filter(|scenario| !scenario.is_empty()) {
                let name = &scenario.scenario().name;
                kept.names.entry(name.clone()).or_insert_with(|| {
                    counted.push(Counted { summary: ScenarioSummary::new(name), ..Counted::default() });
                    counted.len() - 1
                });
            }
            kept.counted = Some(counted);
        }
        kept
    }

    /// Takes in what became of the trial with this place in the suite.
    pub fn take(&mut self, place: usize, trial: TrialReport) {
        let Some(counted) = &mut self.counted else {
            self.held.insert(place, trial);
            return;
        };
        let of = &mut counted[self.names[&trial.trial.scenario]];
        let criteria = of.summary.add(place, &trial);
        let has_passed = trial.verdict() == Some(Verdict::Passed);
        if let Some(criteria) = criteria {
            if has_passed {
                of.few.push((place, criteria as u32));
            }
            self.held.insert(place, trial);
        }
        if of.summary.ran() > MOST_SHOWN {
            for (place, criteria) in of.few.drain(..) {
                self.held.remove(&place);
                of.passed.push((place, criteria));
            }
        }
    }

    /// How a trial stands that others needed in vain.
    pub fn standing(&self, place: usize) -> Standing {
        self.held.get(&place).map_or(Standing::Skipped, TrialReport::standing)
    }

    /// The trials that are held in the order of the suite, and where they are not all, what all come to. `skipped` is the report of
    /// one that was not selected.
    pub fn conclude(
        mut self,
        mut skipped: impl FnMut(usize) -> TrialReport,
    ) -> (Vec<TrialReport>, Option<SuiteSummary>) {
        let Some(mut counted) = self.counted else {
            let trials = (0..self.plan.len())
                .map(|place| self.held.remove(&place).unwrap_or_else(|| skipped(place)));
            return (trials.collect(), None);
        };
        let mut all = vec![0; counted.len()];
        let mut first = 0;
        for scenario in self.plan.scenarios().iter().filter(|scenario| !scenario.is_empty()) {
            let index = self.names[&scenario.scenario().name];
            let (of, places) = (&mut counted[index], first..first + scenario.len());
            all[index] += scenario.len();
            if of.summary.has_not_passed() {
                of.passed.sort_unstable();
                let passed = of.passed.iter().filter(|(place, _)| places.contains(place));
                of.summary.passed.extend(passed.map(|(place, criteria)| {
                    let value = |one: Assignment| (one.label.into_boxed_str(), one.value);
                    let values = scenario.variation(place - first).into_iter().map(value).collect();
                    PassedTrial { place: *place, criteria: *criteria, values }
                }));
            }
            first = places.end;
        }
        for (of, trials) in counted.iter_mut().zip(all) {
            let unselected = trials - of.summary.trials();
            of.summary.count(Standing::Skipped, Some(&Skip::NotSelected), unselected);
        }
        let scenarios = counted.iter_mut().map(|of| mem::take(&mut of.summary)).collect();
        let (held, trials) = self.held.into_iter().unzip();
        (trials, Some(SuiteSummary { held, scenarios }))
    }
}
