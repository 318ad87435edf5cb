//! Projects: suites read from files, checked, planned and found possible, or everything that is wrong with them.

mod apart;
mod claims;
mod examine;
mod notice;
mod open;
mod planned_suite;

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use apart::key_prefixes;
pub use claims::examine_claims;
pub use examine::{examine, examine_edited};
pub use notice::{Notice, NoticeLevel, Problems};
pub use open::plan_notices;
pub use planned_suite::{PlannedSuite, ProjectOptions};

use crate::plan::{PlanError, plan};
use files::Files;
use scenario::registry::Registry;

/// Suites that are ready to run, in the order of their files.
#[derive(Debug)]
pub struct Project {
    suites: Vec<PlannedSuite>,
    registry: Registry,
    files: Arc<dyn Files>,
    notices: Vec<Notice>,
}

impl Project {
    /// Reads, checks and plans the suite (`.suite`) or scenarios (`.scn`, `.yaml`) in a file and all it uses, which may name
    /// what is in `registry`.
    ///
    /// # Errors
    /// Everything that is wrong, with the place of each in its file.
    pub fn open(
        path: impl AsRef<Path>,
        registry: &Registry,
        files: &(impl Files + Clone + 'static),
    ) -> Result<Self, Problems> {
        Self::open_all([path], &ProjectOptions::default(), registry, files)
    }

    /// As [`Self::open`], of several files; a file that is wrong does not hide what is wrong with the others.
    ///
    /// # Errors
    /// Everything that is wrong, file by file.
    pub fn open_all<P: AsRef<Path>>(
        paths: impl IntoIterator<Item = P>,
        options: &ProjectOptions,
        registry: &Registry,
        files: &(impl Files + Clone + 'static),
    ) -> Result<Self, Problems> {
        let mut notices = Vec::new();
        let mut known: HashSet<PathBuf> = HashSet::new();
        let mut opened = |path: P| {
            let path = path.as_ref();
            if !known.insert(files.identity(path)) {
                let message = format!("{} is named twice: it is run once", path.display());
                notices.push(Notice::Plain { level: NoticeLevel::Note, message, help: None });
                return None;
            }
            Some(open::open(path, options, registry, files, &mut notices))
        };
        let suites: Vec<Option<PlannedSuite>> = paths.into_iter().filter_map(&mut opened).collect();
        let suites = suites.into_iter().collect::<Option<Vec<_>>>().map(told_apart);
        match suites {
            Some(Ok(suites)) => {
                Ok(Self { suites, registry: registry.clone(), files: Arc::new(files.clone()), notices })
            }
            Some(Err(errors)) => Err(Problems(notices.into_iter().chain(plan_notices(errors)).collect())),
            None => Err(Problems(notices)),
        }
    }

    /// Its suites.
    pub fn suites(&self) -> &[PlannedSuite] {
        &self.suites
    }

    /// What they may name.
    pub fn registry(&self) -> &Registry {
        &self.registry
    }

    /// Where its files are: what blocks and gates refer to is read when they are run.
    pub fn files(&self) -> &Arc<dyn Files> {
        &self.files
    }

    /// Warnings and notes: what there is to say, though it can be run.
    pub fn notices(&self) -> &[Notice] {
        &self.notices
    }
}

/// The same suites, of which no two have one name in their keys.
fn told_apart(mut suites: Vec<PlannedSuite>) -> Result<Vec<PlannedSuite>, Vec<PlanError>> {
    let names: Vec<_> = suites.iter().map(|one| (one.file.as_str(), one.suite.name.as_str())).collect();
    let prefixes = key_prefixes(&names);
    for (suite, apart) in suites.iter_mut().zip(prefixes) {
        if !apart.is_empty() {
            suite.suite.apart = apart;
            suite.plan = plan(&suite.suite)?;
        }
    }
    Ok(suites)
}

#[cfg(test)]
mod tests {
    use super::*;
    use files::Memory;
    use models::standard;

    const SCENARIO: &str = "\
scenario walk {
  road { lanes forward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra { width: 4 m } }
  vehicle av { start 60 m before crossing; speed 40 km/h; controller constant_speed }
  pedestrian walker { model scripted; start 2 m from kerb; appears at 0 s }
  expect { no collision }
}
";

    #[test]
    fn a_project_needs_no_disk() {
        let files = Memory::default().with("a.scn", SCENARIO);
        let project = Project::open("a.scn", &standard(), &files).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(project.suites()[0].plan.len(), 1);
        let people =
            SCENARIO.replace("model scripted", "model commotions; individuals all of \"people.csv\"");
        let files = Memory::default().with("a.scn", people.as_str());
        let missing = Project::open("a.scn", &standard(), &files).unwrap_err().to_string();
        assert!(
            missing.contains("cannot read the population people.csv: there is no such text"),
            "{missing}"
        );
        let files = files.with("people.csv", "T_delta\n10\n20\n");
        let project = Project::open("a.scn", &standard(), &files).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(project.suites()[0].plan.trial(0).runs, 2);
    }

    #[test]
    fn what_is_wrong_is_said_of_every_file() {
        let files =
            Memory::default().with("a.scn", "scenario").with("b.scn", "scenario b {").with("c.scn", SCENARIO);
        let options = ProjectOptions::default();
        let opened = Project::open_all(["a.scn", "c.scn", "b.scn", "d.scn"], &options, &standard(), &files);
        let said = opened.unwrap_err().to_string();
        let places: Vec<usize> =
            ["a.scn:1", "b.scn:1", "d.scn"].map(|place| said.find(place).expect(place)).to_vec();
        assert!(places.is_sorted(), "{said}");
        assert!(!said.contains("c.scn"), "{said}");
    }
}
