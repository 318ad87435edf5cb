//! Estimates that were made before with another seed or budget, so that trying until one passes shows.

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use crate::cli::store;
use numbers::json;
use report::console::stderr;
use results::{BlockResult, BlockState, EstimateResult, SuiteIdentity, SuiteReport, Verdict, is_use};
use scenario::{Block, EstimateMethod};

/// In the program's own folder.
const FILE: &str = "estimates.json";

/// What is remembered of an estimate at most; the oldest that passed are forgotten first.
const MOST: usize = 1000;

/// More tries are counted, not named.
const MOST_NAMED: usize = 10;

/// By estimate: nothing of one of which every try passed that is known.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct EstimateTries(BTreeMap<String, Vec<Try>>);

/// An estimate that came to a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Try {
    /// The suite's.
    #[serde(with = "json::whole")]
    seed: u64,
    /// Runs.
    budget: u32,
    method: EstimateMethod,
    /// Whether it was neither refused nor one of its claims not shown when it was last made so.
    passed: bool,
}

impl Try {
    fn is_like(&self, other: &Self) -> bool {
        (self.seed, self.budget, self.method) == (other.seed, other.budget, other.method)
    }
}

impl Display for Try {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "seed {} with {} runs by {}", self.seed, self.budget, self.method.word())
    }
}

impl EstimateTries {
    /// Has the estimates in `reports` say with what else they were tried before where some of that did not pass, and remembers them.
    /// What was said is returned, a sentence each. It changes no verdict.
    pub fn note(reports: &mut [SuiteReport]) -> Vec<String> {
        let mut tries = Self::read().unwrap_or_else(|error| {
            writeln!(
                stderr(),
                "warning: which estimates were made before cannot be read, and is forgotten: {error}"
            );
            Self::default()
        });
        let mut said = Vec::new();
        let mut any = false;
        for report in reports {
            let SuiteReport { identity, blocks, .. } = report;
            for block in blocks {
                let (Block::Estimate(asked), BlockState::Finished(result)) =
                    (&*block.block, &mut block.state)
                else {
                    continue;
                };
                let BlockResult::Estimate(result) = &mut **result else { continue };
                any = true;
                let passed = result.verdict() == Verdict::Passed;
                let now = Try { seed: identity.seed, budget: asked.budget, method: asked.method, passed };
                if let Some(told) = tries.learn(name(identity, &asked.name), now, result) {
                    said.push(format!("{}: {told}", block.key));
                }
            }
        }
        if any && let Err(error) = tries.write() {
            writeln!(stderr(), "warning: cannot remember which estimates were made: {error}");
        }
        said
    }

    fn learn(&mut self, name: String, now: Try, result: &mut EstimateResult) -> Option<String> {
        let tried = self.0.entry(name.clone()).or_default();
        let earlier: Vec<Try> = tried.iter().filter(|one| !one.is_like(&now)).copied().collect();
        let told = in_words(&earlier);
        result.warnings.extend(told.clone());
        match tried.iter_mut().find(|one| one.is_like(&now)) {
            Some(known) => known.passed = now.passed,
            None => tried.push(now),
        }
        if tried.len() > MOST {
            let place = tried.iter().position(|one| one.passed).unwrap_or(0);
            tried.remove(place);
        }
        if tried.iter().all(|one| one.passed) {
            self.0.remove(&name);
        }
        told
    }

    fn read() -> Result<Self, String> {
        let text = match store::read(FILE) {
            Ok(text) => text,
            Err(error) if error.is_missing() => return Ok(Self::default()),
            Err(error) => return Err(error.to_string()),
        };
        serde_json::from_str(&text).map_err(|error| error.to_string())
    }

    fn write(&self) -> std::io::Result<()> {
        if self.0.is_empty() {
            return store::remove(FILE);
        }
        store::write(FILE, &(serde_json::to_string_pretty(self).expect("plain data serialises") + "\n"))
    }
}

/// What is estimated but for what is tried: of what was otherwise on the command line, neither files that are read besides nor `--repeat`
/// change a run of it.
fn name(identity: &SuiteIdentity, estimate: &str) -> String {
    let otherwise = identity.set.iter().filter(|one| !is_use(one) && !one.starts_with("repeat="));
    let parts = [&*identity.file, "estimate", estimate].into_iter();
    parts.chain(otherwise.map(String::as_str)).collect::<Vec<_>>().join(" | ")
}

/// `None` if none is known that did not pass.
fn in_words(earlier: &[Try]) -> Option<String> {
    let failed: Vec<String> = earlier.iter().filter(|one| !one.passed).map(ToString::to_string).collect();
    let shown = match &failed[..] {
        [] => return None,
        few if few.len() <= MOST_NAMED => few.join(", "),
        many => format!("{}, …", many[..MOST_NAMED].join(", ")),
    };
    Some(format!(
        "other seeds or budgets were tried before: {}, of which {} did not pass: {shown}",
        earlier.len(),
        failed.len()
    ))
}
