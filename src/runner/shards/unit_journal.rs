//! What came of the runs of a unit under way: of each worker that makes some of them a journal, which the others read as it grows, so that nobody need
//! make them again.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::run::Build;
use crate::run::{RunDigest, StoredRun};
use files::{Disk, Files, Log, LogError, LogFormat, LogTail, base64, from_base64};

const FORMAT: LogFormat = LogFormat { name: "scenario-runner journal of a unit", version: 2 };

/// In the folder of results.
const FOLDER: &str = "journal";

/// A journal that has not grown for so long is nobody's any more, unless runs take longer.
pub const LONGEST_PAUSE: Duration = Duration::from_secs(5);

/// What was recorded is brought to the disk after so long, where others on a network see it, and not more often than so many times what that takes.
const UNSYNCED: Duration = Duration::from_millis(100);
const SYNCING: u32 = 50;

/// Another file's name is tried so often where one is in use: by another worker of the same name.
const MOST_NAMES: usize = 16;

/// Whose runs they are: those of another build or machine are others.
#[derive(Clone, Copy, Serialize)]
pub struct JournalSubject<'s> {
    pub unit: &'s str,
    pub build: &'s Build,
    pub canary: &'s str,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Record {
    run: String,
    result: String,
}

/// One that is being written, or none where that cannot be.
pub struct UnitJournal {
    log: Option<Log>,
    synced: Instant,
    /// Until it is synced again.
    pause: Duration,
}

/// All journals of a unit, with what they held.
pub struct Resumed {
    /// This worker's.
    pub journal: UnitJournal,
    pub others: OtherJournals,
    pub held: Heard,
}

/// What journals say that was not read before.
#[derive(Default)]
pub struct Heard {
    pub runs: Vec<HeardRun>,
    /// Why journals are not read any further, or were begun anew.
    pub notices: Vec<String>,
}

pub struct HeardRun {
    pub run: RunDigest,
    pub stored: StoredRun,
    /// Who says so.
    pub journal: PathBuf,
}

impl UnitJournal {
    /// Opens that of a `worker` in a folder of results, and reads those of all others. What is damaged is left out, and one of this worker's name that is
    /// damaged or of others is begun anew.
    pub fn open(folder: &Path, of: JournalSubject, worker: &str) -> Resumed {
        let mut held = Heard::default();
        let opened = (1..=MOST_NAMES).find_map(|number| {
            let more = if number == 1 { String::new() } else { format!(".{number}") };
            let name = format!("{}.{worker}{more}.jsonl", of.unit);
            Some((Self::log(&folder.join(FOLDER).join(&name), of, &mut held)?, name))
        });
        let (log, own) = opened.map_or((None, None), |(log, name)| (log, Some(name)));
        let journal = Self { log, synced: Instant::now(), pause: UNSYNCED };
        let of_all = serde_json::to_value(of).expect("plain data serialises");
        let (folder, unit) = (folder.to_path_buf(), of.unit.to_string());
        let mut others = OtherJournals { folder, unit, of: of_all, own, all: BTreeMap::new() };
        let Heard { runs, notices } = others.read();
        held.runs.extend(runs);
        held.notices.extend(notices);
        // Who had written them may be gone by now.
        others.all.values_mut().for_each(|one| one.grew = None);
        Resumed { journal, others, held }
    }

    /// `None` if another worker writes it; nothing is written where that cannot be.
    fn log(path: &Path, of: JournalSubject, held: &mut Heard) -> Option<Option<Log>> {
        // Its name can be foretold, so that somebody could have it lead anywhere.
        if path.is_symlink() {
            return Some(None);
        }
        let anew = |why: String, held: &mut Heard| {
            held.notices.push(why);
            Some(Log::create(path, FORMAT, &of, &[]).ok())
        };
        match Log::open(path, FORMAT, &of) {
            Ok((log, contents)) => match recorded(path, &contents.records) {
                Some(runs) => {
                    held.runs.extend(runs);
                    Some(Some(log))
                }
                None => {
                    drop(log);
                    anew(means_nothing(path), held)
                }
            },
            Err(LogError::InUse { .. }) => None,
            Err(LogError::Io { .. }) => Some(None),
            Err(error) => anew(error.to_string(), held),
        }
    }

    /// Adds what came of a run.
    pub fn record(&mut self, run: &RunDigest, stored: &StoredRun) {
        let record = Record { run: run.to_string(), result: base64(&stored.to_bytes()) };
        let Some(log) = &mut self.log else { return };
        if log.append(&record).is_err() || !self.sync_in_time() {
            // Without it whoever goes on makes more runs, and that is all.
            self.log = None;
        }
    }

    /// False if it fails.
    fn sync_in_time(&mut self) -> bool {
        let Some(log) = self.log.as_ref().filter(|_| self.synced.elapsed() >= self.pause) else {
            return true;
        };
        let begun = Instant::now();
        let is_there = log.sync().is_ok();
        (self.synced, self.pause) = (Instant::now(), UNSYNCED.max(begun.elapsed() * SYNCING));
        is_there
    }
}

/// Those of the other workers at a unit.
pub struct OtherJournals {
    /// Of results.
    folder: PathBuf,
    unit: String,
    of: serde_json::Value,
    /// The name of this worker's own.
    own: Option<String>,
    all: BTreeMap<String, OtherJournal>,
}

struct OtherJournal {
    tail: LogTail,
    /// Whether it can be read.
    is_sound: bool,
    /// When it was last seen to have grown.
    grew: Option<Instant>,
}

impl OtherJournals {
    /// What they say since they were read last. One of another build or machine says nothing.
    pub fn read(&mut self) -> Heard {
        let mut heard = Heard::default();
        for name in names(&self.folder, &self.unit).filter(|name| Some(name) != self.own.as_ref()) {
            let path = self.folder.join(FOLDER).join(&name);
            let journal = self.all.entry(name).or_insert_with(|| OtherJournal {
                tail: LogTail::new(&path, FORMAT, &self.of),
                is_sound: !path.is_symlink(),
                grew: None,
            });
            if !journal.is_sound {
                continue;
            }
            let notice = match journal.tail.more().map(|records| recorded(&path, &records)) {
                Ok(Some(runs)) => {
                    if !runs.is_empty() {
                        journal.grew = Some(Instant::now());
                    }
                    heard.runs.extend(runs);
                    continue;
                }
                Ok(None) => Some(means_nothing(&path)),
                Err(LogError::OtherSubject { .. } | LogError::OtherVersion { .. }) => None,
                // It was removed just now, or a network does not show it.
                Err(LogError::Read { .. }) => continue,
                Err(error) => Some(error.to_string()),
            };
            journal.is_sound = false;
            heard.notices.extend(notice);
        }
        heard
    }

    /// How many workers make the unit at this time where a run takes so long, and which of them this one is.
    pub fn at_work(&self, run: Duration) -> (usize, usize) {
        let most = LONGEST_PAUSE.max(run * 3);
        let grows = |one: &OtherJournal| one.is_sound && one.grew.is_some_and(|grew| grew.elapsed() < most);
        let others = || self.all.iter().filter(|(_, one)| grows(one)).map(|(name, _)| Some(name));
        (1 + others().count(), others().filter(|name| *name < self.own.as_ref()).count())
    }
}

/// The names of all journals of a unit.
fn names(folder: &Path, unit: &str) -> impl Iterator<Item = String> {
    let begin = format!("{unit}.");
    Disk.names(&folder.join(FOLDER)).into_iter().filter(move |name| name.starts_with(&begin))
}

/// Removes all journals of a unit, whose results are where they belong.
pub fn remove_journals(folder: &Path, unit: &str) {
    for name in names(folder, unit) {
        // Left behind it costs only space.
        let _ = files::remove(&folder.join(FOLDER).join(name));
    }
}

/// How long all journals of each unit together are, and how many they are.
pub fn journal_lengths(folder: &Path) -> BTreeMap<String, (u64, usize)> {
    let folder = folder.join(FOLDER);
    let mut lengths: BTreeMap<String, (u64, usize)> = BTreeMap::new();
    for name in Disk.names(&folder) {
        let (Some((unit, _)), Ok(metadata)) = (name.split_once('.'), folder.join(&name).metadata()) else {
            continue;
        };
        let known = lengths.entry(unit.to_string()).or_default();
        *known = (known.0 + metadata.len(), known.1 + 1);
    }
    lengths
}

fn means_nothing(path: &Path) -> String {
    format!("{}: a record of it means nothing", path.display())
}

/// `None` if one of them means nothing.
fn recorded(path: &Path, records: &[String]) -> Option<Vec<HeardRun>> {
    records.iter().map(|record| heard_run(path, record)).collect()
}

fn heard_run(path: &Path, text: &str) -> Option<HeardRun> {
    let record: Record = serde_json::from_str(text).ok()?;
    let stored = StoredRun::from_bytes(&from_base64(&record.result)?).ok()?;
    Some(HeardRun { run: record.run.parse().ok()?, stored, journal: path.to_path_buf() })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn build() -> Build {
        Build { digest: "abc".into(), target: "here".into(), version: "0".into() }
    }

    const CANARY: &str = "c";

    fn open(folder: &Path, canary: &str, worker: &str) -> Resumed {
        UnitJournal::open(folder, JournalSubject { unit: "unit", build: &build(), canary }, worker)
    }

    fn known(heard: &Heard) -> Vec<RunDigest> {
        heard.runs.iter().map(|one| one.run).collect()
    }

    fn write(journal: &mut UnitJournal, runs: impl IntoIterator<Item = u8>) {
        runs.into_iter().for_each(|run| journal.record(&RunDigest([run; 32]), &StoredRun::over_time_limit()));
    }

    fn digests(runs: impl IntoIterator<Item = u8>) -> Vec<RunDigest> {
        runs.into_iter().map(|run| RunDigest([run; 32])).collect()
    }

    #[test]
    fn what_was_recorded_is_there_again_and_nothing_else_is_believed() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let mut first = open(folder, CANARY, "one");
        write(&mut first.journal, 1..3);
        drop(first);
        let again = open(folder, CANARY, "one");
        assert_eq!(known(&again.held), digests(1..3));
        assert!(again.held.notices.is_empty());
        drop(again);
        let path = folder.join("journal/unit.one.jsonl");
        let whole = fs::read(&path).unwrap();
        // A letter in the middle is another.
        let mut changed = whole.clone();
        let place = whole.iter().rposition(|byte| *byte == b'\n').unwrap();
        let place = whole[..place].iter().rposition(|byte| *byte == b'\n').unwrap() - 60;
        changed[place] = if changed[place] == b'A' { b'B' } else { b'A' };
        for (worker, elsewhere) in [("two", "three"), ("one", "one")] {
            // What a killed worker was writing is cut off, and what was before it holds, for others, too.
            fs::write(&path, &whole[..whole.len() - 5]).unwrap();
            assert_eq!(known(&open(folder, CANARY, worker).held), digests(1..2));
            fs::write(&path, &changed).unwrap();
            let damaged = open(folder, CANARY, worker).held;
            assert!(damaged.runs.is_empty() && damaged.notices.len() == 1, "{:?}", damaged.notices);
            assert!(damaged.notices[0].contains("unit.one.jsonl"), "{:?}", damaged.notices);
            // Of another machine nothing is taken over. Somebody else's is left alone.
            fs::write(&path, &whole).unwrap();
            let other = open(folder, "d", elsewhere).held;
            assert!(other.runs.is_empty() && other.notices.is_empty() == (worker == "two"));
        }
        remove_journals(folder, "uni");
        assert!(path.exists());
        remove_journals(folder, "unit");
        assert!(journal_lengths(folder).is_empty());
    }

    #[test]
    fn workers_hear_of_each_other_and_have_journals_of_their_own() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let mut left = open(folder, CANARY, "0");
        write(&mut left.journal, 0..2);
        drop(left);
        let run = Duration::ZERO;
        let mut one = open(folder, CANARY, "same");
        assert_eq!(known(&one.held), digests(0..2));
        assert_eq!(one.others.at_work(run), (1, 0), "whoever wrote that may be gone");
        let mut other = open(folder, CANARY, "same");
        assert_eq!(journal_lengths(folder)["unit"].1, 3);
        write(&mut one.journal, 2..4);
        let heard = other.others.read();
        assert_eq!(known(&heard), digests(2..4));
        assert!(heard.runs[0].journal.ends_with("unit.same.jsonl"));
        assert!(known(&other.others.read()).is_empty(), "each is heard once");
        write(&mut other.journal, 4..5);
        assert_eq!(known(&one.others.read()), digests(4..5));
        // Each has another place, and both say the same of it.
        let mut places = [one.others.at_work(run), other.others.at_work(run)];
        places.sort_unstable();
        assert_eq!(places, [(2, 0), (2, 1)]);
        // Removed under them, nothing happens.
        remove_journals(folder, "unit");
        write(&mut one.journal, 5..6);
        assert!(known(&other.others.read()).is_empty());
    }
}
