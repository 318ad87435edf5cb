//! One run of a suite that is watched, from its file to what it came to.

use std::collections::BTreeSet;

use super::arguments::WatchArguments;
use crate::cli::program_files::program_files;
use crate::cli::run::conduct::{ConductOrders, Conducted};
use crate::cli::run::{LastRun, select};
use crate::cli::{filter, load, programs};
use files::RecordingDisk;
use lang::filter::{Filters, Show};
use report::console::stderr;
use results::{Overall, Results};
use runner::project::{Project, ProjectOptions};
use runner::run::Stop;
use runner::session::{self, Selection};
use runner::watch::{Extent, SuiteState};
use scenario::DeclaredProgram;
use scenario::registry::Registry;
use under_test::Allowed;

/// What holds as long as is watched.
pub struct Wishes<'w> {
    pub arguments: &'w WatchArguments,
    /// What is otherwise than in the files.
    pub options: ProjectOptions,
    /// In the name of what is selected.
    pub word: Option<&'w str>,
    pub registry: &'w Registry,
}

/// What a run came to.
pub struct Ended {
    /// `None` if it was stopped.
    pub state: Option<SuiteState>,
    /// If it was run.
    pub results: Option<Results>,
}

impl Ended {
    fn without(state: SuiteState) -> Self {
        Self { state: Some(state), results: None }
    }
}

impl Wishes<'_> {
    /// Reads a file through `recording`, runs what is selected of it, and says how that goes.
    pub fn run(
        &self,
        file: &str,
        extent: Extent,
        filters: &Filters,
        recording: &RecordingDisk,
        stop: &Stop,
    ) -> Ended {
        let WatchArguments { select: arguments, conduct, .. } = self.arguments;
        let colour = conduct.shown.color.wanted(stderr());
        let project = match Project::open_all([file], &self.options, self.registry, recording) {
            Ok(project) => project,
            Err(problems) => {
                load::show(problems.0, colour);
                return Ended::without(SuiteState::DoesNotLoad);
            }
        };
        load::show(project.notices().iter().cloned(), colour);
        let suites = project.suites();
        note_programs(suites.iter().flat_map(|one| programs::declared(&one.suite)), recording);
        let units = session::units(suites);
        let each = |show: &mut Show| {
            units.iter().for_each(|unit| select::with_subject(suites, &unit, &mut *show));
        };
        filter::warn(filters, &each, colour);
        let mut last = LastRun::read();
        let failed = last.failed_units(suites, &units);
        let select = |failed: Option<&BTreeSet<String>>| {
            let subjects = (&arguments.subjects, arguments.partition);
            select::select(suites, &units, filters, self.word, subjects, failed)
        };
        let mut asked = select((extent == Extent::Failed).then_some(&failed));
        if !asked.contains(&true) && extent == Extent::Failed {
            asked = select(None);
        }
        let chosen = session::with_needs(&units, asked);
        if !chosen.contains(&true) {
            writeln!(stderr(), "warning: no trial of {file} is selected");
            return Ended::without(SuiteState::NothingSelected);
        }
        let own = suites.iter().map(|one| &one.suite);
        let Ok(threads) = conduct.programs.threads(conduct.test_threads, own) else {
            return Ended::without(SuiteState::DoesNotLoad);
        };
        let (number, of) = (chosen.iter().filter(|chosen| **chosen).count(), units.len());
        let selection = Selection::marked(chosen).until_failures(conduct.max_failures());
        let selection = match failed.is_empty() {
            true => selection,
            false => selection.first(units.keys().map(|key| failed.contains(&key)).collect()),
        };
        let orders = ConductOrders {
            project: &project,
            units: &units,
            selection,
            executor: &threads,
            stop,
            watch: None,
            courses: true,
            every_trial: true,
            besides: None,
            is_repeated: true,
            is_merged: false,
        };
        let Conducted { results, complaints, notices } = conduct.conduct(orders, &mut last);
        notices.iter().for_each(|notice| writeln!(stderr(), "note: {notice}"));
        complaints.iter().for_each(|complaint| writeln!(stderr(), "error: {complaint}"));
        if stop.is_requested() {
            return Ended { state: None, results: None };
        }
        // Nothing that could not be done whole has passed.
        let overall = match results.overall() {
            Overall::Passed if !complaints.is_empty() => Overall::Failed,
            overall => overall,
        };
        Ended { state: Some(SuiteState::Judged { overall, units: number, of }), results: Some(results) }
    }
}

/// Remembers the files of programs that decide, which nobody reads through `recording`, and where it stands what is allowed.
fn note_programs<'p>(programs: impl Iterator<Item = &'p DeclaredProgram>, recording: &RecordingDisk) {
    let mut any = false;
    for program in programs {
        any = true;
        program_files(program, recording).iter().for_each(|path| recording.besides(path));
    }
    if any && let Ok(place) = Allowed::place() {
        recording.besides(&place);
    }
}
