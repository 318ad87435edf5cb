//! What is to be known of scenarios whose runs are drawn: what is cut off, and claims that say nothing beyond the runs that are made.

use super::budget::at;
use super::single::is_about_many;
use crate::plan;
use lang::{Code, Diagnostic, Sources};
use scenario::{Scenario, Suite};

/// A warning for every draw that reaches, by next to nothing, beyond what can be run, and for every claim about a share, mean or quantile
/// of drawn runs that states no confidence. What cannot be planned is left to planning.
pub(super) fn examine_drawn(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let drawn = suite.scenarios.iter().filter(|scenario| scenario.is_drawn());
    drawn.flat_map(|scenario| of_scenario(suite, scenario, sources)).collect()
}

fn of_scenario(suite: &Suite, scenario: &Scenario, sources: &Sources) -> Vec<Diagnostic> {
    let mut found: Vec<Diagnostic> = Vec::new();
    for cut in plan::cut_off_draws(suite, scenario).unwrap_or_default() {
        let message = format!("{:.1e} of all draws of `{}` are cut off: {}", cut.share, cut.name, cut.why);
        found.push(
            at(Code::CutOff, &cut.origin, message, sources)
                .label("reaches a little too far")
                .hint("`truncated_normal(mean, standard deviation, low, high)` says where it ends"),
        );
    }
    for criterion in &scenario.criteria {
        if criterion.claim.confidence().is_some() || !is_about_many(criterion) {
            continue;
        }
        let message = format!(
            "`{}` speaks of the drawn runs alone, and other draws would say something else",
            criterion.text
        );
        found.push(
            at(Code::OnlyTheseRuns, &criterion.origin, message, sources)
                .label("states no confidence")
                .hint("say how sure to be of all that may be drawn: `with 95 % confidence`"),
        );
    }
    found
}
