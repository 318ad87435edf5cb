//! One run of a project: its units run, its ratings and gates judged, and of the runs that reports draw the courses kept.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use thiserror::Error;

use super::coordinator::Orders;
use super::courses::courses;
use super::gates::judge_gates;
use super::ratings::judge_ratings;
use super::selection::Selection;
use super::shared::{RunWatch, Runner};
use super::tested_programs::{note_uses, verify};
use super::unit::{UnitKind, Units, units};
use crate::project::Project;
use crate::run::{Executor, Remembered, Stop, Threads, VerifyRuns};
use results::{Reporter, Results, TriedSeed};

/// What is to be run and how. Results depend on the project alone.
pub struct Session<'a> {
    project: &'a Project,
    executor: Option<Box<dyn Executor + 'a>>,
    journals: Option<PathBuf>,
    stop: Stop,
    watch: Option<&'a RunWatch<'a>>,
    lenient: bool,
    courses: bool,
    every_trial: bool,
    every_metric: bool,
    timeless: bool,
    pilot: bool,
    earlier_seeds: Vec<Vec<TriedSeed>>,
    verify: VerifyRuns,
    notices: Mutex<Vec<String>>,
}

/// Why there are no results, or not all of them.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SessionError {
    /// What was not run has not passed.
    #[error("nothing is selected of {units} trials and blocks")]
    NothingSelected {
        /// How many there are.
        units: usize,
    },
    /// A run that is drawn could not be repeated, or went differently.
    #[error("{reason}")]
    NotRepeated {
        /// Which run, and what became of it.
        reason: String,
        /// All there is besides the courses of runs.
        results: Box<Results>,
    },
}

impl SessionError {
    /// What results there are all the same.
    pub fn results(self) -> Results {
        match self {
            Self::NothingSelected { .. } => Results::default(),
            Self::NotRepeated { results, .. } => *results,
        }
    }
}

impl<'a> Session<'a> {
    /// One that uses all cores.
    pub fn new(project: &'a Project) -> Self {
        Self {
            project,
            executor: None,
            journals: None,
            stop: Stop::default(),
            watch: None,
            lenient: false,
            courses: true,
            every_trial: true,
            every_metric: false,
            timeless: false,
            pilot: false,
            earlier_seeds: Vec::new(),
            verify: VerifyRuns::default(),
            notices: Mutex::default(),
        }
    }

    /// With runs made by `executor`, such as fewer [`Threads`].
    pub fn executor(self, executor: impl Executor + 'a) -> Self {
        Self { executor: Some(Box::new(executor)), ..self }
    }

    /// With a folder where searches and tunes keep what they have evaluated, so that one that is cut off goes on.
    pub fn journals(self, folder: impl Into<PathBuf>) -> Self {
        Self { journals: Some(folder.into()), ..self }
    }

    /// With somebody who may wish that no more runs begin.
    pub fn stopped_by(self, stop: &Stop) -> Self {
        Self { stop: stop.clone(), ..self }
    }

    /// With somebody who is given the course of every run of a trial.
    pub fn watched_by(self, watch: &'a RunWatch<'a>) -> Self {
        Self { watch: Some(watch), ..self }
    }

    /// Whether gates leave out trials that their baseline lacks, instead of refusing to compare.
    pub fn lenient_gates(self, lenient: bool) -> Self {
        Self { lenient, ..self }
    }

    /// Whether the results hold the courses of the runs that reports draw. They do unless this says no.
    pub fn courses(self, courses: bool) -> Self {
        Self { courses, ..self }
    }

    /// Whether the results hold every trial. They do unless this says no: then they hold what did not pass, and the rest [in
    /// numbers](results::SuiteSummary), which needs little memory for millions of runs. The terminal's report says the same,
    /// reports of each trial refuse to be made. Courses of runs, ratings and gates need every trial and get it. Where trials alone are run
    /// and each is judged, no metric is measured then that nothing in the project asks for, unless [`Self::every_metric`] says otherwise.
    pub fn every_trial(self, every: bool) -> Self {
        Self { every_trial: every, ..self }
    }

    /// Whether every metric that has a default is measured though nobody sees it: so were runs that an executor has from elsewhere.
    pub fn every_metric(self, every: bool) -> Self {
        Self { every_metric: every, ..self }
    }

    /// Whether the wall time of trials says nothing, since their runs were made before: then whoever made them has kept their `time_limit`.
    pub fn timeless(self, timeless: bool) -> Self {
        Self { timeless, ..self }
    }

    /// Whether a few runs of each trial are made before all others, for whoever tells how long everything takes. It changes no result.
    pub fn pilot_runs(self, pilot: bool) -> Self {
        Self { pilot, ..self }
    }

    /// With the other seeds that each suite of the project was run with before, in its order: reports say which of them did not pass.
    pub fn after_seeds(self, earlier_seeds: Vec<Vec<TriedSeed>>) -> Self {
        Self { earlier_seeds, ..self }
    }

    /// Which of the runs in which programs decide are made a second time, to see whether they come out the same: the first of each
    /// scenario and every 200th unless this says otherwise.
    pub fn verify_runs(self, verify: VerifyRuns) -> Self {
        Self { verify, ..self }
    }

    /// Runs what is selected, and tells `reporter` what happens.
    ///
    /// # Errors
    /// If nothing is selected, or a run that is drawn went differently when it was repeated.
    pub fn run(&self, selection: &Selection, reporter: &mut dyn Reporter) -> Result<Results, SessionError> {
        self.run_units(&units(self.project.suites()), selection, reporter)
    }

    /// As [`Self::run`], where the [units](super::units) of the project are known already.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn run_units(
        &self,
        units: &Units<'a>,
        selection: &Selection,
        reporter: &mut dyn Reporter,
    ) -> Result<Results, SessionError> {
        let chosen = selection.chosen(units);
        if !chosen.contains(&true) {
            return Err(SessionError::NothingSelected { units: units.len() });
        }
        let threads;
        let executor = match &self.executor {
            Some(executor) => &**executor,
            None => {
                threads = Threads::all();
                &threads
            }
        };
        let memory = Remembered::new(executor).watched(self.watch.is_some());
        let is_sequential =
            self.project.suites().iter().flat_map(|one| &one.suite.gates).any(|gate| gate.sequential);
        // Whoever is given the courses of runs gets them as they come.
        let pilot = self.pilot && self.watch.is_none();
        let is_memorising = is_sequential || pilot;
        let executor: &dyn Executor = if is_memorising { &memory } else { executor };
        let mut runner = Runner::new(self.project.suites(), executor, self.project.registry())
            .verifying(self.verify)
            .reading(self.project.files())
            .stopped_by(&self.stop)
            .after_seeds(self.earlier_seeds.clone());
        if self.shows_asked_metrics_only(units, &chosen) {
            runner = runner.measuring_what_is_asked();
        }
        if self.timeless {
            runner = runner.timeless();
        }
        if let Some(folder) = &self.journals {
            runner = runner.journals(folder.clone());
        }
        if let Some(watch) = self.watch {
            runner = runner.watched_by(watch);
        }
        let orders = Orders {
            chosen: &chosen,
            first: &selection.first,
            max_failures: selection.max_failures,
            every_trial: self.every_trial || self.courses,
            memory: is_memorising.then_some(&memory),
            lenient: self.lenient,
            pilot,
        };
        let mut suites = runner.run(units, &orders, reporter);
        // Before runs are repeated, which other runs need not wait for.
        note_uses(executor, &mut suites);
        verify(&runner, &mut suites);
        judge_ratings(&runner, &mut suites);
        judge_gates(&runner, &mut suites, self.lenient, reporter);
        self.lock().extend(runner.notices());
        self.lock().extend(suites.iter().flat_map(|one| &one.people).filter_map(|one| one.warning.clone()));
        let mut results = Results { requests: runner.requests().clone(), suites, ..Results::default() };
        if self.courses {
            match courses(&runner, &results.suites, &mut self.lock()) {
                Ok(recordings) => results.recordings = recordings,
                Err(reason) => {
                    return Err(SessionError::NotRepeated { reason, results: Box::new(results) });
                }
            }
        }
        Ok(results)
    }

    /// Whether nobody can see a metric that nothing in the suites asks for: no more is said of any run than the terminal's report says of
    /// trials, blocks and gates look at none, and every table has criteria for its columns.
    fn shows_asked_metrics_only(&self, units: &Units, chosen: &[bool]) -> bool {
        if self.every_trial || self.every_metric || self.courses || self.watch.is_some() {
            return false;
        }
        let mut suites = self.project.suites().iter().map(|one| &one.suite);
        let is_judged_by_itself = |unit: usize| match units.kind(unit) {
            UnitKind::Trial { scenario, .. } => {
                scenario.scenario().criteria.iter().any(|one| one.when.is_empty())
            }
            UnitKind::Recorded | UnitKind::Block(_) => false,
        };
        suites.all(|suite| suite.gates.is_empty() && suite.ratings.is_empty())
            && (0..units.len()).filter(|unit| chosen[*unit]).all(is_judged_by_itself)
    }

    /// What there is to tell besides the results, such as that the end of a journal was cut off.
    pub fn notices(&self) -> Vec<String> {
        std::mem::take(&mut self.lock())
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<String>> {
        self.notices.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use files::Memory;
    use models::standard;
    use results::{Overall, Unheard};

    const SCENARIO: &str = "\
scenario walk {
  road { lanes forward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra { width: 4 m } }
  vehicle av { start 60 m before crossing; speed 40 km/h; controller constant_speed }
  pedestrian walker { model scripted; start 2 m from kerb; appears at START }
  expect { no collision }
}
";

    fn run(start: &str, selection: &Selection) -> Result<Results, SessionError> {
        let files = Memory::default().with("a.scn", SCENARIO.replace("START", start).as_str());
        let project = Project::open("a.scn", &standard(), &files).unwrap_or_else(|error| panic!("{error}"));
        Session::new(&project).executor(Threads::new(1)).run(selection, &mut Unheard)
    }

    #[test]
    fn a_session_needs_a_project_and_nothing_else() {
        let late = run("15 s", &Selection::all()).unwrap();
        assert_eq!(late.overall(), Overall::Passed);
        assert_eq!(late.recordings.len(), 1);
        // He steps out when the vehicle is there.
        let hit =
            (0..60).map(|tenth| run(&format!("{} s", f64::from(tenth) / 10.0), &Selection::all()).unwrap());
        assert!(hit.into_iter().any(|results| results.overall() == Overall::Failed));
    }

    #[test]
    fn what_was_not_run_has_not_passed() {
        let nothing = run("15 s", &Selection::containing("wlak"));
        assert!(matches!(nothing, Err(SessionError::NothingSelected { units: 1 })));
        assert_eq!(Results::default().overall(), Overall::NothingJudged);
        assert_eq!(run("15 s", &Selection::named("a/walk")).unwrap().overall(), Overall::Passed);
        assert!(run("15 s", &Selection::named("a/wal")).is_err());
        assert!(run("15 s", &Selection::marked(vec![])).is_err());
    }

    /// The disk has none of these files, so that reading one there would be an error.
    #[test]
    fn what_blocks_and_gates_refer_to_comes_from_where_the_project_comes_from() {
        let suite = "\
use \"a.scn\"
suite walks {
  scenarios \"a.scn\"
  evaluate both { on walk; with default, \"tuned.json\" as tuned; measure mean(time_lost) }
  gate unchanged { baseline \"base.json\"; no metric worse by more than 1 % with 95 % confidence }
}
";
        let files = Memory::default().with("a.scn", SCENARIO.replace("START", "15 s").as_str());
        let files = files.with("a.suite", suite);
        let said = |files: &Memory| {
            let project =
                Project::open("a.suite", &standard(), files).unwrap_or_else(|error| panic!("{error}"));
            let session = Session::new(&project).executor(Threads::new(1));
            let results = session.run(&Selection::all(), &mut Unheard).unwrap();
            assert_ne!(results.overall(), Overall::Passed);
            let report = &results.suites[0];
            format!("{:?} {:?}", report.blocks[0].state, report.gates[0].state)
        };
        let files = files.with("tuned.json", "{");
        let missing = said(&files);
        assert!(
            missing.contains("EOF while parsing") && missing.contains("there is no baseline"),
            "{missing}"
        );
        let malformed = said(&files.with("base.json", "{}"));
        assert!(malformed.contains("missing field `baseline`"), "{malformed}");
    }
}
