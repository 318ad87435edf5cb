//! What came of the runs of a unit under way, so that a worker that goes on with it need not make them again.

use std::collections::HashMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::build::Build;
use crate::run::{RunDigest, StoredRun};
use files::{Log, LogError, LogFormat, base64, from_base64};

const FORMAT: LogFormat = LogFormat { name: "scenario-runner journal of a unit", version: 1 };

/// In the folder of results.
const FOLDER: &str = "journal";

/// Whose runs they are: those of another build or machine are others.
#[derive(Serialize)]
struct Subject<'s> {
    unit: &'s str,
    build: &'s Build,
    canary: &'s str,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Record {
    run: String,
    result: String,
}

/// One that is being written, or none where that cannot be.
#[derive(Default)]
pub struct UnitJournal(Option<Log>);

/// One with what it held.
#[derive(Default)]
pub struct Resumed {
    pub journal: UnitJournal,
    pub runs: HashMap<RunDigest, StoredRun>,
    /// Why it was begun anew, if it was.
    pub notice: Option<String>,
}

impl UnitJournal {
    /// That of a unit in a folder of results. One that is damaged or of others is begun anew; while another worker writes it there is none.
    pub fn open(folder: &Path, unit: &str, build: &Build, canary: &str) -> Resumed {
        let path = folder.join(FOLDER).join(format!("{unit}.jsonl"));
        // Its name can be foretold, so that somebody could have it lead anywhere.
        if path.is_symlink() {
            return Resumed::default();
        }
        let of = Subject { unit, build, canary };
        let anew = |why: String| {
            let journal = Self(Log::create(&path, FORMAT, &of, &[]).ok());
            Resumed { journal, runs: HashMap::new(), notice: Some(why) }
        };
        match Log::open(&path, FORMAT, &of) {
            Ok((log, held)) => match held.records.iter().map(|record| recorded(record)).collect() {
                Some(runs) => Resumed { journal: Self(Some(log)), runs, notice: None },
                None => {
                    drop(log);
                    anew(format!("{}: a record of it means nothing", path.display()))
                }
            },
            Err(LogError::InUse { .. } | LogError::Io { .. }) => Resumed::default(),
            Err(error) => anew(error.to_string()),
        }
    }

    /// Adds what came of a run.
    pub fn record(&mut self, run: &RunDigest, stored: &StoredRun) {
        let record = Record { run: run.to_string(), result: base64(&stored.to_bytes()) };
        if self.0.as_mut().is_some_and(|log| log.append(&record).is_err()) {
            // Without it whoever goes on makes more runs, and that is all.
            self.0 = None;
        }
    }

    /// The results are where they belong.
    pub fn remove(self) {
        // Left behind it costs only space: nobody opens it again.
        let _ = self.0.map(Log::remove);
    }
}

fn recorded(text: &str) -> Option<(RunDigest, StoredRun)> {
    let record: Record = serde_json::from_str(text).ok()?;
    Some((record.run.parse().ok()?, StoredRun::from_bytes(&from_base64(&record.result)?).ok()?))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn build() -> Build {
        Build { digest: "abc".into(), target: "here".into(), version: "0".into() }
    }

    fn known(resumed: &Resumed) -> Vec<RunDigest> {
        let mut runs: Vec<_> = resumed.runs.keys().copied().collect();
        runs.sort();
        runs
    }

    #[test]
    fn what_was_recorded_is_there_again_and_nothing_else_is_believed() {
        let folder = tempfile::tempdir().unwrap();
        let open = |canary: &str| UnitJournal::open(folder.path(), "unit", &build(), canary);
        let runs = [RunDigest([1; 32]), RunDigest([2; 32])];
        let mut first = open("c");
        runs.iter().for_each(|run| first.journal.record(run, &StoredRun::over_time_limit()));
        assert!(open("c").journal.0.is_none(), "another one has it");
        drop(first);
        let again = open("c");
        assert_eq!((known(&again), &again.notice), (runs.to_vec(), &None));
        drop(again);
        let path = folder.path().join("journal/unit.jsonl");
        let whole = fs::read(&path).unwrap();
        // What a killed worker was writing is cut off, and what was before it holds.
        fs::write(&path, &whole[..whole.len() - 5]).unwrap();
        assert_eq!(known(&open("c")), runs[..1]);
        // A letter in the middle is another.
        let mut changed = whole.clone();
        let place = whole.iter().rposition(|byte| *byte == b'\n').unwrap();
        let place = whole[..place].iter().rposition(|byte| *byte == b'\n').unwrap() - 60;
        changed[place] = if changed[place] == b'A' { b'B' } else { b'A' };
        fs::write(&path, &changed).unwrap();
        let damaged = open("c");
        assert!(damaged.runs.is_empty() && damaged.notice.is_some(), "{:?}", damaged.notice);
        drop(damaged);
        // Of another machine nothing is taken over.
        fs::write(&path, &whole).unwrap();
        let other = open("d");
        assert!(other.runs.is_empty() && other.notice.is_some());
        other.journal.remove();
        assert!(!path.exists());
    }
}
