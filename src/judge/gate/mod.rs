//! Gates: whether a candidate is worse than a base, beyond what is tolerated and beyond doubt.
//!
//! `docs/gates.md` says what the verdicts mean and gives the formulas.

mod check;
mod measure;
mod power;
mod questions;
#[cfg(test)]
mod tests;

use serde::Serialize;

use super::baseline::{Baseline, Incompatible, Pairing, pair};
use super::statistics::holm;
use super::verdict::Verdict;
use crate::scenario::{Gate, GateRule, Tolerance};

pub use check::{ChangedRun, Check, CheckOutcome, Subject};
pub use measure::vehicle_changes;
pub use power::Power;

/// What became of a gate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GateVerdict {
    pub gate: String,
    pub verdict: Verdict,
    /// In the order of rules, metrics and scenarios.
    pub checks: Vec<Check>,
    /// What each rule says; [`Check::rule`] is an index into them.
    #[serde(skip)]
    pub rules: Vec<String>,
    /// How many comparisons share the error, because chance plays a part in them.
    pub family: usize,
    /// Rules none of whose comparisons could have failed, whatever had happened.
    pub blind_rules: Vec<String>,
    /// Metrics that no run on either side has.
    pub without_values: Vec<String>,
    /// Metrics that are not compared, because the base lacks them.
    pub new_metrics: Vec<String>,
    /// Trials that are not compared, because the base lacks them.
    pub new_trials: Vec<String>,
    /// Runs on each side.
    pub runs: usize,
    pub same_seeds: bool,
    pub same_people: bool,
    /// Every run went exactly as before.
    pub nothing_changed: bool,
    /// What is tested and differs, such as `av.controller.braking_distance: 5 -> 4.75`.
    pub changes: Vec<String>,
}

/// The rule that a comparison has where no gate is named: no metric worse by more than this.
pub fn blanket_rule(tolerance: f64, confidence: f64) -> GateRule {
    let percent = |share: f64| crate::scenario::significant(100.0 * share, 6);
    GateRule {
        metric: None,
        tolerance: Tolerance::Relative(tolerance),
        confidence,
        text: format!(
            "no metric worse by more than {} % with {} % confidence",
            percent(tolerance),
            percent(confidence)
        ),
        origin: Default::default(),
    }
}

impl GateVerdict {
    pub fn count(&self, outcome: CheckOutcome) -> usize {
        self.checks.iter().filter(|check| check.outcome == outcome).count()
    }
}

/// Judges what a gate says about a suite and a baseline of the same suite. With `lenient`, trials that the base lacks are left out instead of being a reason not to
/// compare.
///
/// # Errors
/// Every reason why the two may not be compared.
pub fn judge_gate(
    gate: &Gate,
    base: &Baseline,
    candidate: &Baseline,
    lenient: bool,
) -> Result<GateVerdict, Vec<Incompatible>> {
    if base.suite != candidate.suite {
        let (base, candidate) = (base.suite.clone(), candidate.suite.clone());
        return Err(vec![Incompatible::OtherSuite { base, candidate }]);
    }
    judge_rules(&gate.name, &gate.rules, &pair(base, candidate, lenient)?)
}

/// Judges rules over two baselines that belong together.
///
/// # Errors
/// Names the metrics that a rule asks for and the base lacks.
pub fn judge_rules(
    name: &str,
    rules: &[GateRule],
    pairing: &Pairing,
) -> Result<GateVerdict, Vec<Incompatible>> {
    let questions::Questions { asked, without_values, new_metrics } = questions::ask(rules, pairing)?;
    let family = asked.iter().filter(|question| question.shares_the_error()).count();
    let seed = pairing.candidate.seed;
    let mut checks: Vec<Check> =
        asked.iter().map(|question| check::measure(question, family, seed)).collect();
    let p_values: Vec<f64> = checks.iter().filter_map(|check| check.p_value).collect();
    let mut adjusted = holm(&p_values).into_iter();
    for check in checks.iter_mut().filter(|check| check.p_value.is_some()) {
        check.adjusted_p_value = adjusted.next();
    }
    for (check, question) in checks.iter_mut().zip(&asked) {
        check.decide(question);
    }
    let nothing_changed = pairing.nothing_changed();
    let sees = |check: &Check| !matches!(check.power, Power::Blind { .. } | Power::None);
    let can_fail = |rule: usize| checks.iter().any(|check| check.rule == rule && sees(check));
    let blind = rules.iter().enumerate().filter(|(index, _)| !can_fail(*index));
    let blind_rules: Vec<String> = blind.map(|(_, rule)| rule.text.clone()).collect();
    let regressed = checks.iter().any(|check| check.outcome == CheckOutcome::Regressed);
    let verdict = if regressed {
        Verdict::Failed
    } else if blind_rules.is_empty() || nothing_changed {
        Verdict::Passed
    } else {
        Verdict::Inconclusive
    };
    Ok(GateVerdict {
        gate: name.to_string(),
        verdict,
        checks,
        rules: rules.iter().map(|rule| rule.text.clone()).collect(),
        family,
        blind_rules,
        without_values,
        new_metrics,
        new_trials: pairing.new_trials.iter().map(|key| key.to_string()).collect(),
        runs: pairing.trials.iter().map(|(_, trial)| trial.runs.len()).sum(),
        same_seeds: pairing.same_seeds,
        same_people: pairing.same_people,
        nothing_changed,
        changes: changes(pairing),
    })
}

/// What is tested and differs, once each.
fn changes(pairing: &Pairing) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for (base, candidate) in &pairing.trials {
        let before = &pairing.base.vehicles[base.vehicles];
        let after = &pairing.candidate.vehicles[candidate.vehicles];
        for (before, after) in before.iter().zip(after) {
            for change in measure::vehicle_changes(before, after) {
                if !found.contains(&change) {
                    found.push(change);
                }
            }
        }
    }
    found
}
