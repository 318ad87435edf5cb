//! The file of failures: text that people can read, sorted, so that it can be compared and merged.
//!
//! Every record ends with a checksum of its lines: another digit in a seed would be another run, which does not fail. Whole records
//! may be taken out, put in and moved by hand, their lines may not. A name with what a terminal would obey stands there as JSON.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use files::escape::{is_command, json_text};
use files::{self, Files, ReadError};
use results::Recorded;
use scenario::{Assignment, Value};

/// Why there are no records.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CorpusError {
    /// The file cannot be read, or is too large.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: ReadError,
    },
    /// The system refuses to write it.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A line is no record.
    #[error("{}:{line}: {reason}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong, in words.
        reason: String,
    },
}

impl CorpusError {
    /// What to do about it.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Content { .. } => {
                "restore the file from version control; a whole record may be deleted, and with it is forgotten what failed"
            }
            Self::Read { .. } | Self::Write { .. } => {
                "restore the file from version control, or delete it to forget these failures"
            }
        }
    }
}

const ENDING: &str = "failures";

/// Where the failures of a suite or scenario file are kept.
pub fn corpus_path(suite: &Path) -> PathBuf {
    suite.with_extension(ENDING)
}

/// The records in a file, sorted; none if there is no file.
///
/// # Errors
/// If it cannot be read or something in it cannot be understood.
pub fn read_corpus(path: &Path, files: &dyn Files) -> Result<Vec<Recorded>, CorpusError> {
    match files.read_text(path, &[ENDING]) {
        Ok(text) => parse(&text).map_err(|(line, reason)| CorpusError::Content {
            path: path.to_owned(),
            line,
            reason,
        }),
        Err(error) if error.is_missing() => Ok(Vec::new()),
        Err(source) => Err(CorpusError::Read { path: path.to_owned(), source }),
    }
}

/// Whether there are records in a file and none has a checksum: it is of an earlier version.
pub fn is_unchecked(path: &Path, files: &dyn Files) -> bool {
    let drafts = files.read_text(path, &[ENDING]).ok().and_then(|text| drafts(&text).ok());
    drafts.is_some_and(|drafts| !drafts.is_empty() && drafts.iter().all(|draft| draft.stated.is_none()))
}

/// Writes records, sorted, each once. Without any there is no file.
///
/// # Errors
/// If it cannot be written.
pub fn write_corpus(path: &Path, records: &[Recorded]) -> Result<(), CorpusError> {
    let result = files::check_target(path, &[ENDING]).and_then(|()| match records {
        [] => files::remove(path),
        records => files::write(path, text(records)),
    });
    result.map_err(|source| CorpusError::Write { path: path.to_owned(), source })
}

const HEADING: &str = "\
# Runs that failed. scenario-runner runs them first; commit this file.
# `--record-failures` adds to it, `--prune-failures` takes out what does not fail any more.
# Whole records may be deleted by hand; one that was changed is refused, as its `crc` says.
";

fn text(records: &[Recorded]) -> String {
    let mut sorted: Vec<&Recorded> = records.iter().collect();
    let name = |record: &Recorded| (record.key.clone(), record.seed);
    sorted.sort_by_key(|record| name(record));
    sorted.dedup_by_key(|record| name(record));
    let mut text = HEADING.to_string();
    for record in sorted {
        let record = lines(record);
        text += &format!("\n{record}{}", field_line(CHECKSUM, &checksum(&record)));
    }
    text
}

/// A record without its checksum.
fn lines(record: &Recorded) -> String {
    let mut text = format!("{}\n", visible_words(&record.key));
    let mut field = |name: &str, value: &str| text += &field_line(name, value);
    field("scenario", &record.scenario);
    field("seed", &record.seed.to_string());
    for one in &record.variation {
        let value = serde_json::to_string(&one.value).expect("plain data serialises");
        field("variation", &format!("{} = {value} as {}", one.name, one.label));
    }
    for (pedestrian, number, population) in &record.people {
        field("individual", &format!("{pedestrian} is {number} of {population}"));
    }
    field("case", &format!("{:016x}", record.case));
    field("run", &format!("{:016x}", record.fingerprint));
    record.against.iter().for_each(|one| field("against", one));
    text
}

fn field_line(name: &str, value: &str) -> String {
    format!("  {name:<10}  {}\n", visible_words(value))
}

/// A text as it is; as JSON if it has what a reader's program would obey, or would be read as something else.
fn visible_words(text: &str) -> String {
    let is_plain = text == text.trim() && !text.starts_with(['"', '#']) && !text.contains(is_command);
    if is_plain { text.to_string() } else { json_text(text) }
}

/// The text of [`visible_words`].
fn read_words(text: &str) -> Option<String> {
    if text.starts_with('"') { serde_json::from_str(text).ok() } else { Some(text.to_string()) }
}

/// The last field of a record.
const CHECKSUM: &str = "crc";

/// Eight hexadecimal digits.
fn checksum(lines: &str) -> String {
    format!("{:08x}", crc32fast::hash(lines.as_bytes()))
}

/// The records, or the line (from 1) that cannot be understood and why.
fn parse(text: &str) -> Result<Vec<Recorded>, (usize, String)> {
    let drafts = drafts(text)?;
    // Files of version 0.1 have no checksums at all.
    let is_checked = drafts.iter().any(|draft| draft.stated.is_some());
    drafts.into_iter().map(|draft| draft.finish(is_checked)).collect()
}

fn drafts(text: &str) -> Result<Vec<Draft>, (usize, String)> {
    let mut records: Vec<Draft> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let number = index + 1;
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        if !line.starts_with(' ') {
            let wrong = || (number, "this is no key of a run".to_string());
            let (key, lines) = (read_words(line.trim_end()).ok_or_else(wrong)?, format!("{line}\n"));
            records.push(Draft { line: number, key, lines, ..Draft::default() });
            continue;
        }
        let record = records.last_mut().ok_or((number, "the key of a run was expected".to_string()))?;
        if record.stated.is_some() {
            return Err((number, "nothing of a record stands after its checksum".to_string()));
        }
        let (name, value) = line.trim().split_once(' ').unwrap_or((line.trim(), ""));
        let value = value.trim();
        let words = read_words(value).ok_or_else(|| (number, format!("`{value}` is no text")))?;
        record.read(name, &words).map_err(|reason| (number, reason))?;
        if name != CHECKSUM {
            record.lines += line;
            record.lines.push('\n');
        }
    }
    Ok(records)
}

/// A record that is being read.
#[derive(Default)]
struct Draft {
    line: usize,
    /// As they stand there, without the checksum.
    lines: String,
    stated: Option<String>,
    key: String,
    scenario: Option<String>,
    seed: Option<u64>,
    variation: Vec<Assignment>,
    people: Vec<(String, u32, String)>,
    case: Option<u64>,
    fingerprint: Option<u64>,
    against: Vec<String>,
}

impl Draft {
    fn read(&mut self, name: &str, value: &str) -> Result<(), String> {
        let wrong = || format!("`{value}` is no {name}");
        let hexadecimal = || u64::from_str_radix(value, 16).map_err(|_| wrong());
        let stands_twice = match name {
            "scenario" => self.scenario.replace(value.to_string()).is_some(),
            "seed" => self.seed.replace(value.parse().map_err(|_| wrong())?).is_some(),
            "case" => self.case.replace(hexadecimal()?).is_some(),
            "run" => self.fingerprint.replace(hexadecimal()?).is_some(),
            CHECKSUM => self.stated.replace(value.to_string()).is_some(),
            "variation" => {
                self.variation.push(assignment(value).ok_or_else(wrong)?);
                false
            }
            "individual" => {
                self.people.push(person(value).ok_or_else(wrong)?);
                false
            }
            "against" => {
                self.against.push(value.to_string());
                false
            }
            _ => return Err(format!("nothing is called `{name}` here")),
        };
        if stands_twice { Err(format!("`{}` has two of `{name}`", self.key)) } else { Ok(()) }
    }

    /// Where one record of a file has a checksum, each must.
    fn finish(self, is_checked: bool) -> Result<Recorded, (usize, String)> {
        let refused = |reason: &str| (self.line, format!("`{}` {reason}", self.key));
        let missing = |what: &str| refused(&format!("has no {what}"));
        let recorded = Recorded {
            scenario: self.scenario.clone().ok_or_else(|| missing("scenario"))?,
            seed: self.seed.ok_or_else(|| missing("seed"))?,
            case: self.case.ok_or_else(|| missing("case"))?,
            fingerprint: self.fingerprint.ok_or_else(|| missing("run"))?,
            key: self.key.clone(),
            variation: self.variation.clone(),
            people: self.people.clone(),
            against: self.against.clone(),
        };
        match &self.stated {
            Some(stated) if *stated != checksum(&self.lines) => {
                Err(refused("is not as it was written: its checksum is wrong"))
            }
            None if is_checked => Err(refused("has no checksum, and others have")),
            _ => Ok(recorded),
        }
    }
}

/// Of `tta = 6.5 as 6.5s`.
fn assignment(text: &str) -> Option<Assignment> {
    let (name, rest) = text.split_once(" = ")?;
    // The value ends where JSON says: a word may have anything in it.
    let mut values = serde_json::Deserializer::from_str(rest).into_iter::<Value>();
    let value = values.next()?.ok()?;
    let label = rest[values.byte_offset()..].strip_prefix(" as ")?;
    Some(Assignment { name: name.to_string(), label: label.to_string(), value })
}

/// Of `walker is 17 of standard`.
fn person(text: &str) -> Option<(String, u32, String)> {
    let (pedestrian, rest) = text.split_once(" is ")?;
    let (number, population) = rest.split_once(" of ")?;
    Some((pedestrian.to_string(), number.parse().ok()?, population.to_string()))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use files::Disk;

    fn record(key: &str, seed: u64) -> Recorded {
        let assignment =
            |name: &str, label: &str, value| Assignment { name: name.into(), label: label.into(), value };
        Recorded {
            key: key.into(),
            scenario: "walk".into(),
            seed,
            variation: vec![
                assignment("tta", "6.1235s#2", Value::Number(6.123_456_789_012_345)),
                assignment("kind", "as is", Value::Word("as is".into())),
                assignment("wet", "true", Value::Flag(true)),
            ],
            people: vec![("walker".into(), 17, "my people.json".into())],
            case: 0xfedc_ba98_7654_3210,
            fingerprint: 0x0123_4567_89ab_cdef,
            against: vec!["no collision: collision yes".into(), "pet >= 1.5 s: pet 0.83 s".into()],
        }
    }

    #[test]
    fn reads_what_it_writes_sorted_and_each_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("zebra.failures");
        let (a, b, c) =
            (record("zebra/walk/rep=1", 7), record("zebra/walk/rep=1", 8), record("zebra/walk/rep=2", 7));
        write_corpus(&path, &[c.clone(), b.clone(), a.clone(), a.clone()]).unwrap();
        insta::assert_snapshot!(fs::read_to_string(&path).unwrap());
        assert_eq!(read_corpus(&path, &Disk).unwrap(), [a, b, c]);
        write_corpus(&path, &[]).unwrap();
        assert!(!path.exists());
        write_corpus(&path, &[]).unwrap();
        assert_eq!(read_corpus(&path, &Disk).unwrap(), []);
    }

    #[test]
    fn what_cannot_be_understood_is_said_with_its_line() {
        for (text, line, said) in [
            ("  seed 7\n", 1, "the key of a run was expected"),
            ("# x\na/b\n  sead 7\n", 3, "nothing is called `sead` here"),
            ("a/b\n  seed seven\n", 2, "`seven` is no seed"),
            ("a/b\n  scenario b\n  seed 7\n  case 1\n", 1, "`a/b` has no run"),
            ("a/b\n  variation tta 6\n", 2, "`tta 6` is no variation"),
            ("a/b\n  individual walker\n", 2, "is no individual"),
            ("a/b\n  seed 7\n  seed 8\n", 3, "has two of `seed`"),
            ("a/b\n  crc 7\n  seed 8\n", 3, "after its checksum"),
        ] {
            let (found, reason) = parse(text).unwrap_err();
            assert!(found == line && reason.contains(said), "{text}: {found}: {reason}");
        }
    }

    #[test]
    fn another_digit_is_refused_with_its_line_and_whole_records_may_go() {
        let (a, b) = (record("zebra/walk/rep=1", 7), record("zebra/walk/rep=2", 8));
        let text = text(&[a.clone(), b.clone()]);
        let line = text.lines().position(|line| line == b.key).unwrap() + 1;
        let (found, reason) = parse(&text.replace("seed        8", "seed        9")).unwrap_err();
        assert!(found == line && reason.contains("not as it was written"), "{found}: {reason}");
        let second = text.find(&b.key).unwrap();
        assert_eq!(parse(&text[..second]).unwrap(), std::slice::from_ref(&a));
        let first = text.find(&a.key).unwrap();
        assert_eq!(parse(&text[second..]).unwrap(), std::slice::from_ref(&b));
        let exchanged = format!("{}\n{}", &text[second..], &text[first..second]);
        assert_eq!(parse(&exchanged).unwrap(), [b, a], "in any order");
    }

    #[test]
    fn files_without_checksums_are_read_and_one_record_without_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("zebra.failures");
        let records = [record("zebra/walk/rep=1", 7), record("zebra/walk/rep=2", 8)];
        let text = text(&records);
        let has_none = |line: &&str| !line.starts_with("  crc");
        let old: String = text.lines().filter(has_none).map(|line| format!("{line}\n")).collect();
        fs::write(&path, &old).unwrap();
        assert!(is_unchecked(&path, &Disk));
        assert_eq!(read_corpus(&path, &Disk).unwrap(), records);
        let second = (text.find(&records[1].key).unwrap(), old.find(&records[1].key).unwrap());
        fs::write(&path, format!("{}{}", &text[..second.0], &old[second.1..])).unwrap();
        let said = read_corpus(&path, &Disk).unwrap_err().to_string();
        assert!(said.contains("`zebra/walk/rep=2` has no checksum"), "{said}");
        write_corpus(&path, &records).unwrap();
        assert!(!is_unchecked(&path, &Disk) && !is_unchecked(&folder.path().join("other.failures"), &Disk));
    }

    /// What decides which run it is.
    fn run(record: Recorded) -> Recorded {
        Recorded { against: Vec::new(), ..record }
    }

    #[test]
    fn every_flipped_bit_is_refused_or_changes_nothing_that_is_run() {
        let person = |key: &str, seed| Recorded { variation: Vec::new(), ..record(key, seed) };
        let nobody =
            |key: &str, seed| Recorded { people: Vec::new(), against: Vec::new(), ..record(key, seed) };
        for records in [
            vec![record("carla/walk/rep=1", 7)],
            vec![nobody("carla/walk/rep=1", u64::MAX)],
            vec![
                record("carla/J*M-/rep=10", 7),
                person("carla/walk/rep=2", 8),
                nobody("zebra/walk/rep=3", 9),
            ],
        ] {
            let mut bytes = text(&records).into_bytes();
            let wanted: Vec<_> = records.into_iter().map(run).collect();
            let mut refused = 0;
            for place in 0..8 * bytes.len() {
                bytes[place / 8] ^= 1 << (place % 8);
                match std::str::from_utf8(&bytes).ok().map(parse) {
                    None | Some(Err(_)) => refused += 1,
                    Some(Ok(read)) => {
                        let read: Vec<_> = read.into_iter().map(run).collect();
                        assert_eq!(read, wanted, "bit {place}: {}", String::from_utf8_lossy(&bytes));
                    }
                }
                bytes[place / 8] ^= 1 << (place % 8);
            }
            assert!(refused > 4 * bytes.len(), "{refused} of {}", 8 * bytes.len());
        }
    }

    proptest::proptest! {
        #![proptest_config(proptest::test_runner::Config { failure_persistence: None, ..Default::default() })]
        #[test]
        fn a_changed_byte_is_refused_or_changes_nothing_that_is_run(
            seeds in proptest::collection::vec(0u64.., 1..4),
            value in -1e6..1e6f64,
            label in "[!-~]{1,12}",
            place: proptest::sample::Index,
            byte: u8,
        ) {
            let records: Vec<Recorded> = seeds
                .iter()
                .enumerate()
                .map(|(index, seed)| {
                    let value = Value::Number(value);
                    let one = Assignment { name: "tta".into(), label: label.clone(), value };
                    Recorded { variation: vec![one], ..record(&format!("zebra/walk/rep={index}"), *seed) }
                })
                .collect();
            let mut bytes = text(&records).into_bytes();
            proptest::prop_assert_eq!(&parse(std::str::from_utf8(&bytes).unwrap()).unwrap(), &records);
            let place = place.index(bytes.len());
            bytes[place] = byte;
            if let Some(Ok(read)) = std::str::from_utf8(&bytes).ok().map(parse) {
                let (read, wanted) = (read.into_iter().map(run), records.into_iter().map(run));
                proptest::prop_assert_eq!(read.collect::<Vec<_>>(), wanted.collect::<Vec<_>>());
            }
        }
    }
}
