//! Rules that nobody has to write.

use crate::judge::baseline::{Baseline, Pairing};
use scenario::{GateRule, MetricReference, Reference, Tolerance};

/// The rule that a comparison has where no gate is named: no metric worse by more than this.
pub fn blanket_rule(tolerance: f64, confidence: f64) -> GateRule {
    let percent = |share: f64| scenario::significant(100.0 * share, 6);
    GateRule {
        metric: None,
        rate: None,
        tolerance: Tolerance::Relative(tolerance),
        primary: false,
        confidence,
        text: format!(
            "no metric worse by more than {} % with {} % confidence",
            percent(tolerance),
            percent(confidence)
        ),
        notation: None,
        origin: Default::default(),
    }
}

/// `collision not worse`, with the confidence of another rule.
pub fn collision_rule(confidence: f64) -> GateRule {
    let percent = scenario::significant(100.0 * confidence, 6);
    GateRule {
        tolerance: Tolerance::Relative(0.0),
        confidence,
        text: format!("{COLLISION} not worse with {percent} % confidence"),
        ..no_new_collision()
    }
}

/// The rule on collisions that holds unless a gate says otherwise: where the base has none, no run may have one.
fn no_new_collision() -> GateRule {
    let metric = MetricReference::plain(Reference::unresolved(COLLISION));
    GateRule {
        metric: Some(metric),
        rate: None,
        tolerance: Tolerance::NoneNew { where_none_was: true },
        primary: false,
        confidence: 1.0,
        text: "no new collision, where the baseline has none".to_string(),
        notation: None,
        origin: Default::default(),
    }
}

const COLLISION: &str = "collision";

/// The rules, and what holds unless they say otherwise.
pub fn with_default(rules: &[GateRule], pairing: &Pairing) -> Vec<GateRule> {
    let default = no_new_collision();
    // Whoever tolerates more collisions, or none at all, has said so.
    let says_otherwise = |rule: &GateRule| {
        let about = rule.metric == default.metric;
        about && !matches!(rule.tolerance, Tolerance::Relative(0.0) | Tolerance::Absolute(0.0))
    };
    let measured = |side: &Baseline| side.metrics.iter().any(|metric| metric.label == COLLISION);
    let applies = pairing.same_seeds && measured(pairing.base) && measured(pairing.candidate);
    let mut all = rules.to_vec();
    if applies && !rules.iter().any(says_otherwise) {
        all.push(default);
    }
    all
}
