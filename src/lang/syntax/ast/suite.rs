//! Suites and gates.

use super::{Block, Confidence, Doc, Expect, Expression, Metric, Name, Scenario, Seed, Tags, Text};
#[cfg(test)]
use super::{Holds, Made};
use super::{Node, Rule, View};

views! {
    /// `suite NAME { … }`
    Suite = suite { name: Name, block: SuiteBlock }
    SuiteBlock = suite_block {
        doc: (Doc),
        files: [SuiteFiles],
        tags: [Tags],
        seed: (Seed),
        time_limit: (TimeLimit),
        expects: [Expect],
        scenarios: [Scenario],
        blocks: [Block],
        gates: [Gate],
    }
    /// `scenarios "pattern", …`
    SuiteFiles = suite_files { patterns: [Text] }
    /// `time_limit 10 s per case`
    TimeLimit = time_limit { value: Expression }
    /// `gate NAME { … }`
    Gate = gate { name: Name, block: GateBlock }
    GateBlock = gate_block { doc: (Doc), baseline: (Baseline), rules: [GateRule] }
    Baseline = baseline { path: Text }
    GateRule = gate_rule {
        none_new: (NoneNew),
        metric: (Metric),
        tolerance: (GateTolerance),
        confidence: (Confidence),
    }
    /// `no new collision`
    NoneNew = none_new { metric: Metric }
    /// `by more than 5 %`
    GateTolerance = gate_tolerance { bound: Expression }
}
