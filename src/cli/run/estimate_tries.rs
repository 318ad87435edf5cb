//! Estimates that were made before with another seed or budget, so that trying until one passes shows.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use super::tries::{Tries, Try};
use numbers::json;
use report::console::stderr;
use results::{BlockResult, BlockState, SuiteIdentity, SuiteReport, Verdict, is_use};
use scenario::{Block, EstimateMethod};

/// In the program's own folder.
const FILE: &str = "estimates.json";

/// More tries are counted, not named.
const MOST_NAMED: usize = 10;

/// An estimate that came to a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TriedEstimate {
    /// The suite's.
    #[serde(with = "json::whole")]
    seed: u64,
    /// Runs.
    budget: u32,
    method: EstimateMethod,
    /// Whether it was neither refused nor one of its claims not shown when it was last made so.
    passed: bool,
}

impl Try for TriedEstimate {
    fn is_like(&self, other: &Self) -> bool {
        (self.seed, self.budget, self.method) == (other.seed, other.budget, other.method)
    }

    fn passed(&self) -> bool {
        self.passed
    }
}

impl Display for TriedEstimate {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "seed {} with {} runs by {}", self.seed, self.budget, self.method.word())
    }
}

/// Has the estimates in `reports` say with what else they were tried before where some of that did not pass, and remembers them.
/// What was said is returned, a sentence each. It changes no verdict.
pub fn note(reports: &mut [SuiteReport]) -> Vec<String> {
    let mut tries: Tries<TriedEstimate> = Tries::read(FILE).unwrap_or_else(|error| {
        writeln!(
            stderr(),
            "warning: which estimates were made before cannot be read, and is forgotten: {error}"
        );
        Tries::default()
    });
    let mut said = Vec::new();
    let mut any = false;
    for report in reports {
        let SuiteReport { identity, blocks, .. } = report;
        for block in blocks {
            let (Block::Estimate(asked), BlockState::Finished(result)) = (&*block.block, &mut block.state)
            else {
                continue;
            };
            let BlockResult::Estimate(result) = &mut **result else { continue };
            any = true;
            let passed = result.verdict() == Verdict::Passed;
            let now =
                TriedEstimate { seed: identity.seed, budget: asked.budget, method: asked.method, passed };
            let name = name(identity, &asked.name);
            let told = in_words(&tries.earlier(&name, &now));
            tries.learn(name, now);
            result.warnings.extend(told.clone());
            said.extend(told.map(|told| format!("{}: {told}", block.key)));
        }
    }
    if any && let Err(error) = tries.write(FILE) {
        writeln!(stderr(), "warning: cannot remember which estimates were made: {error}");
    }
    said
}

/// What is estimated but for what is tried: of what was otherwise on the command line, neither files that are read besides nor `--repeat`
/// change a run of it.
fn name(identity: &SuiteIdentity, estimate: &str) -> String {
    let otherwise = identity.set.iter().filter(|one| !is_use(one) && !one.starts_with("repeat="));
    let parts = [&*identity.file, "estimate", estimate].into_iter();
    parts.chain(otherwise.map(String::as_str)).collect::<Vec<_>>().join(" | ")
}

/// `None` if none is known that did not pass.
fn in_words(earlier: &[TriedEstimate]) -> Option<String> {
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
