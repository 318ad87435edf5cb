//! Gates: whether a candidate is worse than a base, beyond what is tolerated and beyond doubt.
//!
//! `docs/gates.md` says what the verdicts mean and gives the formulas.

mod changes;
mod check;
mod family;
mod looks;
mod measure;
mod power;
mod questions;
mod rules;
#[cfg(test)]
mod tests;

use super::baseline::{Baseline, Incompatible, Pairing, pair};
use crate::{BlindPlace, Check, GateVerdict, Looks, Power, Verdict};
use scenario::{Gate, GateRule, Tolerance};

use family::Families;
use measure::{Differences, differences};
use rules::with_default;

pub use changes::vehicle_changes;
pub use looks::{ALONG_THE_WAY, LookRounds, look_at};
pub use power::{OFTEN, share_of_one};
pub use rules::{blanket_rule, collision_rule};

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
    judge_paired(gate, &pair(base, candidate, lenient)?)
}

/// Judges what a gate says about two baselines that belong together. One that is sequential comes to what it came to at its first look that
/// left no doubt, whatever came of later runs.
///
/// # Errors
/// Names the metrics that a rule asks for and the base lacks.
pub fn judge_paired(gate: &Gate, pairing: &Pairing) -> Result<GateVerdict, Vec<Incompatible>> {
    if !gate.sequential {
        return judge_rules(&gate.name, &gate.rules, pairing, 1.0);
    }
    let rounds = LookRounds::of(pairing.candidate);
    for after in rounds.looks() {
        if let Some(failed) = looks::look(gate, pairing, &rounds, after)? {
            return Ok(failed);
        }
    }
    let verdict = judge_rules(&gate.name, &gate.rules, pairing, 1.0 - looks::ALONG_THE_WAY)?;
    Ok(GateVerdict { looks: Some(Looks { made: rounds.looks().count(), ended_it_of: None }), ..verdict })
}

/// What is left of a gate's error at the end is `left`, 0..1.
fn judge_rules(
    name: &str,
    rules: &[GateRule],
    pairing: &Pairing,
    left: f64,
) -> Result<GateVerdict, Vec<Incompatible>> {
    let rules = &with_default(rules, pairing);
    let questions::Questions { asked, without_values, new_metrics, unnamed_flags } =
        questions::ask(rules, pairing)?;
    let families = Families::of(&asked, rules, left);
    let measured: Vec<Differences> = asked.iter().map(differences).collect();
    let seed = pairing.candidate.seed;
    let (mut checks, exchanged): (Vec<Check>, Vec<Option<f64>>) = asked
        .iter()
        .zip(&measured)
        .map(|(question, measured)| {
            check::measure(question, measured, families.shares(rules[question.rule].primary), seed)
        })
        .unzip();
    let comparisons =
        family::Comparisons { asked: &asked, measured: &measured, exchanged: &exchanged, rules };
    families.adjust(&mut checks, &comparisons, seed);
    for (check, question) in checks.iter_mut().zip(&asked) {
        check.decide(question);
        // A share of runs that get worse while none gets better says nothing of pairs that differ by chance as well.
        if !pairing.same_seeds && !check.certain && matches!(check.power, Power::Share(_)) {
            check.power = Power::OtherSeeds;
        }
    }
    let nothing_changed = pairing.nothing_changed();
    let (blind_rules, blind_places) = blind(rules, &checks, pairing);
    let nondeterministic = changes::nondeterministic(pairing);
    let cut_off = pairing.trials.iter().map(|(_, trial)| trial.cut_off).sum();
    let judged = GateVerdict {
        gate: name.to_string(),
        verdict: Verdict::Inconclusive,
        checks,
        rules: rules.iter().map(|rule| rule.text.clone()).collect(),
        family: families.primary + families.others,
        primary: families.primary,
        blind_rules,
        blind_places,
        unnamed_flags,
        without_values,
        new_metrics,
        new_trials: pairing.new_trials.iter().map(|key| key.to_string()).collect(),
        runs: pairing.trials.iter().map(|(_, trial)| trial.runs.len()).sum(),
        same_seeds: pairing.same_seeds,
        same_people: pairing.same_people,
        nothing_changed,
        changes: changes::changes(pairing),
        nondeterministic,
        cut_off,
        looks: None,
    };
    Ok(GateVerdict { verdict: judged.worked_out(), ..judged })
}

/// What could not have failed, whatever had happened: rules everywhere, and rules in scenarios that changed. That another
/// scenario can be seen is no comfort.
fn blind(rules: &[GateRule], checks: &[Check], pairing: &Pairing) -> (Vec<String>, Vec<BlindPlace>) {
    let sees = |check: &Check| !matches!(check.power, Power::Blind { .. } | Power::None);
    let (mut everywhere, mut places) = (Vec::new(), Vec::new());
    for (index, rule) in rules.iter().enumerate() {
        let own = || checks.iter().filter(|check| check.rule == index);
        // What holds by default has nothing to say where it does not apply.
        if !own().any(sees) && !matches!(rule.tolerance, Tolerance::NoneNew { where_none_was: true }) {
            everywhere.push(rule.text.clone());
            continue;
        }
        for scenario in pairing.candidate.scenarios() {
            // Trials without chance stand by themselves and always see.
            let here = || own().filter(|check| !check.certain && check.place == scenario);
            if here().next().is_none() || here().any(sees) || !pairing.changed_in(scenario) {
                continue;
            }
            let needed = here().map(|check| (check.needed(), check.units)).max();
            let (needed, units) = needed.expect("there is a comparison here");
            places.push(BlindPlace {
                rule: rule.text.clone(),
                scenario: scenario.to_string(),
                units,
                needed,
            });
        }
    }
    (everywhere, places)
}
