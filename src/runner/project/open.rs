//! A file to a suite that is ready to run: read, checked, planned, rehearsed, with what failed before.

use std::path::Path;
use std::sync::Arc;

use super::claims::examine_claims;
use super::examine::doubts;
use super::notice::{Notice, NoticeLevel};
use super::planned_suite::{PlannedSuite, ProjectOptions};
use crate::corpus::{corpus_path, is_unchecked, read_corpus};
use crate::experiment::rehearse_searches;
use crate::plan::{Plan, PlanError, PlannedTrial, plan};
use crate::run::{Obstacle, Rehearsal, rehearse_trials};
use files::Files;
use lang::{self, Code, Diagnostic, Severity, Sources};
use results::Recorded;
use scenario::Suite;
use scenario::registry::Registry;

/// `None` if it cannot be run, for what then stands in `notices`.
pub fn open(
    path: &Path,
    options: &ProjectOptions,
    registry: &Registry,
    files: &dyn Files,
    notices: &mut Vec<Notice>,
) -> Option<PlannedSuite> {
    let file = path.display().to_string();
    let (mut suite, sources, is_set_aside) =
        match lang::load_otherwise(path, &options.outside, registry, files) {
            Ok(lang::Loaded { suite, sources, warnings }) => {
                let is_set_aside = warnings.iter().any(|warning| warning.code == Code::SetAside);
                let sources = Arc::new(sources);
                notices.extend(findings(warnings, &sources));
                (suite, sources, is_set_aside)
            }
            Err(failure) => {
                notices.push(Notice::Failure(failure));
                return None;
            }
        };
    suite.seed = options.seed.unwrap_or(suite.seed);
    let claims = examine_claims(&suite, &sources);
    let is_hopeless = claims.iter().any(|found| found.severity == Severity::Error);
    notices.extend(findings(claims, &sources));
    if is_hopeless {
        return None;
    }
    let plan = match plan(&suite) {
        Ok(plan) => plan,
        Err(errors) => {
            notices.extend(plan_notices(errors));
            return None;
        }
    };
    // Road users are built once, so that what a model cannot do is said before anything runs.
    let Rehearsal { mut obstacles, departing } = rehearse_trials(&plan);
    obstacles.extend(rehearse_searches(&suite));
    if !obstacles.is_empty() {
        notices.extend(obstacles.into_iter().map(obstacle));
        return None;
    }
    notices.extend(findings(doubts(departing, &sources), &sources));
    if let Some(idle) = nothing_asked(&suite, &plan, is_set_aside) {
        notices.push(idle);
        return None;
    }
    let recorded = recorded(path, &suite, files, notices)?;
    Some(PlannedSuite { file, suite, plan, recorded })
}

fn findings(
    found: impl IntoIterator<Item = Diagnostic>,
    sources: &Arc<Sources>,
) -> impl Iterator<Item = Notice> {
    found.into_iter().map(|finding| Notice::Finding { finding, sources: sources.clone() })
}

/// Why a suite cannot be planned.
pub fn plan_notices(errors: Vec<PlanError>) -> impl Iterator<Item = Notice> {
    errors.into_iter().map(|PlanError { message, hint, case, origin }| Notice::Error {
        code: Code::CannotBePlanned,
        message,
        origin: *origin,
        notes: case.iter().map(|case| format!("in {case}")).collect(),
        help: hint,
    })
}

fn obstacle(obstacle: Obstacle) -> Notice {
    Notice::Error {
        code: obstacle.code(),
        notes: obstacle.note().into_iter().collect(),
        message: obstacle.message,
        origin: obstacle.origin,
        help: obstacle.hint,
    }
}

/// With the values that were set, a trial may be left without a criterion, and would pass whatever happens.
fn nothing_asked(suite: &Suite, plan: &Plan, is_set_aside: bool) -> Option<Notice> {
    if suite.set.is_empty() {
        return None;
    }
    let asks_something = |name: &str| {
        is_set_aside || suite.scenarios.iter().any(|one| one.name == name && !one.criteria.is_empty())
    };
    let idle = |trial: &PlannedTrial| trial.criteria.is_empty() && asks_something(&trial.scenario);
    let trial = plan.trials().find(idle)?;
    Some(Notice::Plain {
        level: NoticeLevel::Error,
        message: format!("with {} no criterion applies to {}", suite.set.join(", "), trial.key),
        help: Some("it would pass whatever happens; set a value that a criterion is about".to_string()),
    })
}

/// The runs that failed before; `None` if they cannot be read.
fn recorded(
    path: &Path,
    suite: &Suite,
    files: &dyn Files,
    notices: &mut Vec<Notice>,
) -> Option<Vec<Recorded>> {
    let corpus = corpus_path(path);
    let recorded = match read_corpus(&corpus, files) {
        Ok(recorded) => recorded,
        Err(error) => {
            let (message, help) = (error.to_string(), Some(error.help().to_string()));
            notices.push(Notice::Plain { level: NoticeLevel::Error, message, help });
            return None;
        }
    };
    let mut note =
        |message: String| notices.push(Notice::Plain { level: NoticeLevel::Note, message, help: None });
    if is_unchecked(&corpus, files) {
        note(format!(
            "{} has no checksums yet, so that a changed digit in it is not noticed; `--record-failures` adds them",
            corpus.display()
        ));
    }
    if suite.set.is_empty() || recorded.is_empty() {
        return Some(recorded);
    }
    note(format!(
        "recorded failures of {} are left out: they are runs of what the files say",
        path.display()
    ));
    Some(Vec::new())
}
