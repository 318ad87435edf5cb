//! Named sets of cases: what a search kept, as a file that people can read, compare and use again.

use std::path::Path;

use serde::Serialize;

use super::context::Context;
use super::earlier::EarlierResults;
use super::error::ExperimentError;
use super::overrides;
use crate::plan;
use files::Files;
use numbers::random::Stream;
use numbers::random::derive_seed;
use results::{SavedCase, SavedSet};
use scenario::{Case, CaseSet, SampleSize, Target, Value};

/// A [`SavedSet`] as a file: JSON with one case a line, in the order of the set.
pub struct CaseFile;

impl CaseFile {
    /// A set as text, one case a line.
    pub fn write(set: &SavedSet) -> String {
        let name = json(&set.name);
        let source = json(&set.source);
        let cases: Vec<_> = set.cases.iter().map(|case| format!("    {}", json(case))).collect();
        let cases = cases.join(",\n");
        format!("{{\n  \"name\": {name},\n  \"source\": {source},\n  \"cases\": [\n{cases}\n  ]\n}}\n")
    }

    /// A set that was written before. [`ExperimentError::CaseFile`] if the file cannot be read or is none.
    pub fn read(path: &Path, files: &dyn Files) -> Result<SavedSet, ExperimentError> {
        let failed = |reason: String| ExperimentError::CaseFile { path: path.to_owned(), reason };
        let text = files.read_text(path, &["json"]).map_err(|error| failed(error.to_string()))?;
        serde_json::from_str(&text).map_err(|error| failed(error.to_string()))
    }
}

impl Context<'_> {
    /// The case to run again with `settings` over its own, under another seed if one is given.
    pub(super) fn revive(
        &self,
        saved: &SavedCase,
        settings: &[(Target, Value)],
        key: String,
        fresh_seed: Option<u64>,
    ) -> Result<Case, ExperimentError> {
        let mut scenario = self.scenario(&saved.scenario)?.clone();
        overrides::apply(&mut scenario, &saved.settings)?;
        overrides::apply(&mut scenario, settings)?;
        let seed = fresh_seed.unwrap_or(saved.seed);
        let (variation, people) = (saved.variation.clone(), saved.individuals.clone());
        Ok(plan::concrete_case(&scenario, key, variation, people, 1, seed)?)
    }

    /// Every case of a scenario as the suite plans it.
    pub(super) fn cases_of(&self, scenario: &str) -> Result<Vec<SavedCase>, ExperimentError> {
        let planned = plan::plan_scenario(self.suite, self.scenario(scenario)?)?;
        let certain =
            |trial: plan::PlannedTrial| trial.cases.iter().take(trial.certain_runs()).collect::<Vec<_>>();
        let cases = planned.trials().flat_map(certain);
        let saved = cases.map(|case| SavedCase {
            // With what was drawn, which is part of the case: other seeds are other noise.
            variation: case.variation.iter().cloned().chain(case.drawn_values()).collect(),
            key: case.key,
            scenario: case.scenario,
            settings: Vec::new(),
            individuals: case.individuals,
            seed: case.seed,
            value: None,
            plausibility: None,
        });
        Ok(saved.collect())
    }
}

impl Context<'_> {
    /// The cases that the block called `name` is about; never empty.
    pub(super) fn case_set(
        &self,
        set: &CaseSet,
        name: &str,
        results: &EarlierResults,
    ) -> Result<Vec<SavedCase>, ExperimentError> {
        let (from, cases) = match set {
            CaseSet::Search(search) => (search, results.search(search)?.kept.cases.clone()),
            CaseSet::Bests(search) => {
                let found = &results.search(search)?.found;
                (search, found.iter().flat_map(|one| &one.runs).map(|run| run.case.clone()).collect())
            }
            CaseSet::Scenario(scenario) => (scenario, self.cases_of(scenario)?),
            CaseSet::Sample { scenario, count } => {
                let count = match count {
                    SampleSize::Number(count) => *count as usize,
                    SampleSize::AsManyAs(search) => results.search(search)?.kept.cases.len(),
                };
                let mut cases = self.cases_of(scenario)?;
                if !cases.is_empty() && cases.len() < count {
                    return Err(ExperimentError::TooFewCases(scenario.clone(), cases.len(), count));
                }
                let mut stream = Stream::seeded(derive_seed(self.suite.seed, &format!("{name} sample")));
                stream.draw(&mut cases, count);
                (scenario, cases)
            }
            CaseSet::Saved(path) => (path, CaseFile::read(Path::new(path), &*self.files)?.cases),
        };
        if cases.is_empty() { Err(ExperimentError::EmptySet(from.clone())) } else { Ok(cases) }
    }
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("plain data serialises")
}
