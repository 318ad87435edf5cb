//! One run of a suite that is watched, from its file to what it came to.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::arguments::WatchArguments;
use crate::cli::run::conduct::{ConductOrders, Conducted};
use crate::cli::run::{LastRun, select};
use crate::cli::{filter, load, programs};
use files::{Files, RecordingDisk};
use lang::filter::{Filters, Show};
use report::console::stderr;
use results::{Overall, Results};
use runner::project::{Project, ProjectOptions};
use runner::run::Stop;
use runner::session::{self, Selection};
use runner::watch::{Extent, SuiteState};
use scenario::registry::Registry;
use scenario::{DeclaredProgram, ProgramKind};
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
        let colour = conduct.color.wanted(stderr());
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
            select::select(suites, &units, filters, self.word, arguments, failed)
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
            threads,
            stop,
            watch: None,
            courses: true,
            every_trial: true,
            is_repeated: true,
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
        let beside = Path::new(&program.file).parent().unwrap_or(Path::new(""));
        match &program.kind {
            ProgramKind::Wasm(file) => recording.besides(&beside.join(file)),
            ProgramKind::Fmu(fmu) => recording.besides(&beside.join(&fmu.file)),
            ProgramKind::Command(words) => {
                files_of(words, &beside.join(&program.folder), recording)
                    .iter()
                    .for_each(|path| recording.besides(path));
            }
        }
    }
    if any && let Ok(place) = Allowed::place() {
        recording.besides(&place);
    }
}

/// The files that a command names in its folder, such as a script and what it is told to read, and those beside them of the same kind, in
/// their folder and in the folders of that: what it imports. What is found on PATH is the system's.
fn files_of(words: &[String], folder: &Path, recording: &RecordingDisk) -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    for word in words {
        for part in [Some(word.as_str()), word.split_once('=').map(|(_, value)| value)].into_iter().flatten()
        {
            let path = folder.join(part);
            if part.is_empty() || !recording.is_file(&path) {
                continue;
            }
            if let (Some(parent), Some(ending)) = (path.parent(), path.extension()) {
                let parent = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
                let ending = glob::Pattern::escape(&ending.to_string_lossy());
                let parent = glob::Pattern::escape(&parent.to_string_lossy());
                for stem in ["*", "*/*"] {
                    let paths = recording.matching(&format!("{parent}/{stem}.{ending}"));
                    found.extend(paths.into_iter().flatten());
                }
            }
            found.insert(path);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn what_a_command_is_made_of_is_found() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("parts")).unwrap();
        for file in ["av.py", "helper.py", "parts/more.py", "log.txt", "calm.json", "other.json"] {
            fs::write(folder.path().join(file), file).unwrap();
        }
        let words = ["python3", "av.py", "--with=calm.json", "--fast"].map(str::to_string);
        let recording = RecordingDisk::default();
        let found = files_of(&words, folder.path(), &recording);
        let names: Vec<String> = found
            .iter()
            .map(|path| path.strip_prefix(folder.path()).unwrap().display().to_string().replace('\\', "/"))
            .collect();
        assert_eq!(names, ["av.py", "calm.json", "helper.py", "other.json", "parts/more.py"]);
        assert!(recording.changed().is_empty());
        fs::write(folder.path().join("second.py"), "").unwrap();
        assert!(!recording.changed().is_empty(), "a file that could be imported");
    }
}
