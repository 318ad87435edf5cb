//! What is wrong with what a suite claims, found before anything runs.

mod attention;
mod budget;
mod drawn;
mod first_sight;
mod lanes;
mod room;
mod sampled;
mod signals;
mod single;
mod trials;
mod trivial;

use lang::{Diagnostic, Sources};
use scenario::Suite;

/// Everything that is wrong with what a suite claims, before anything runs: criteria that can never pass, cannot fail, apply to
/// nothing or ask too few runs, lanes that are blocked, pedestrians that cannot wait where they start or decide at first sight, and
/// controllers that are blind to what is in their way. What cannot be planned is left to planning.
pub fn examine_claims(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let mut found = budget::examine_criteria(suite, sources);
    found.extend(trivial::examine_bounds(suite, sources));
    found.extend(single::examine_single_runs(suite, sources));
    found.extend(drawn::examine_drawn(suite, sources));
    found.extend(lanes::examine_lanes(suite, sources));
    found.extend(signals::examine_signals(suite, sources));
    let sampled = sampled::sample(suite);
    found.extend(room::examine_room(suite, &sampled, sources));
    found.extend(first_sight::examine_first_sight(suite, &sampled, sources));
    found.extend(first_sight::examine_long_looks(&sampled, sources));
    found.extend(attention::examine_attention(suite, sources));
    found
}
