//! Everything that is to be said about a file before it is run, as findings at places in texts.

use std::path::Path;

use super::claims::examine_claims;
use crate::experiment::rehearse_searches;
use crate::run::{Departing, Obstacle, Rehearsal, Stage, rehearse};
use files::Files;
use lang::{self, Code, Diagnostic, Sources};
use scenario::registry::Registry;
use scenario::show;

/// Everything that is to be said about a file, which may be there only to be used by others.
pub fn examine(path: &Path, registry: &Registry, files: &dyn Files) -> (Vec<Diagnostic>, Sources) {
    whole(lang::examine(path, registry, files))
}

/// As [`examine`], of a text that is being edited and stands for the file at `path`.
pub fn examine_edited(
    path: &Path,
    text: &str,
    registry: &Registry,
    files: &dyn Files,
) -> (Vec<Diagnostic>, Sources) {
    whole(lang::examine_edited(path, text, registry, files))
}

fn whole(lang::Examined { suite, mut found, sources }: lang::Examined) -> (Vec<Diagnostic>, Sources) {
    if let Some(suite) = &suite {
        let (claims, rehearsal) = rayon::join(|| examine_claims(suite, &sources), || rehearse(suite));
        found.extend(claims);
        let Rehearsal { obstacles, departing } = rehearsal;
        let obstacles = obstacles.into_iter().chain(rehearse_searches(suite));
        found.extend(obstacles.filter_map(|obstacle| finding(obstacle, &sources)));
        found.extend(doubts(departing, &sources));
        found.sort_by_key(|diagnostic| (diagnostic.span().source, diagnostic.span().start));
    }
    (found, sources)
}

fn finding(obstacle: Obstacle, sources: &Sources) -> Option<Diagnostic> {
    let code = obstacle.code();
    let label = match obstacle.stage {
        Stage::Planning => "cannot be planned",
        Stage::Building => "cannot be run like this",
    };
    let mut finding = Diagnostic::new(code, sources.span(&obstacle.origin)?, &obstacle.message).label(label);
    finding.notes.extend(obstacle.note());
    let hint = obstacle.hint.unwrap_or_else(|| format!("`scenario-runner explain {code}` says more"));
    Some(finding.hint(hint))
}

/// Models that are others than were published, to be warned of.
pub fn doubts(departing: Vec<Departing>, sources: &Sources) -> impl Iterator<Item = Diagnostic> {
    departing.into_iter().filter_map(|Departing { departure, case, origin, .. }| {
        let published = show(departure.published, None, departure.dimension);
        let doubt = Diagnostic::new(Code::AnotherModel, sources.span(&origin)?, departure.to_string())
            .label("another model than was published")
            .hint(format!(
                "say `{}: {published}`; with another value, say whose behaviour it is",
                departure.parameter
            ));
        Some(Diagnostic { notes: vec![format!("in {case}")], ..doubt })
    })
}
