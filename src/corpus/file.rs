//! The file of failures: text that people can read, sorted, so that it can be compared and merged.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::files::{self, ReadError};
use crate::results::Recorded;
use crate::scenario::{Assignment, Value};

/// Why there are no records.
#[derive(Debug, Error)]
pub enum CorpusError {
    #[error("cannot read {}: {source}", path.display())]
    Read { path: PathBuf, source: ReadError },
    #[error("cannot write {}: {source}", path.display())]
    Write { path: PathBuf, source: io::Error },
    #[error("{}:{line}: {reason}", path.display())]
    Content { path: PathBuf, line: usize, reason: String },
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
pub fn read_corpus(path: &Path) -> Result<Vec<Recorded>, CorpusError> {
    match files::read_kind(path, &[ENDING]) {
        Ok(text) => parse(&text).map_err(|(line, reason)| CorpusError::Content {
            path: path.to_owned(),
            line,
            reason,
        }),
        Err(error) if error.is_missing() => Ok(Vec::new()),
        Err(source) => Err(CorpusError::Read { path: path.to_owned(), source }),
    }
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
";

fn text(records: &[Recorded]) -> String {
    let mut sorted: Vec<&Recorded> = records.iter().collect();
    let name = |record: &Recorded| (record.key.clone(), record.seed);
    sorted.sort_by_key(|record| name(record));
    sorted.dedup_by_key(|record| name(record));
    let mut text = HEADING.to_string();
    for record in sorted {
        text += &format!("\n{}\n", record.key);
        let mut field = |name: &str, value: &str| text += &format!("  {name:<10}  {value}\n");
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
    }
    text
}

/// The records, or the line (from 1) that cannot be understood and why.
fn parse(text: &str) -> Result<Vec<Recorded>, (usize, String)> {
    let mut records: Vec<Draft> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let number = index + 1;
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        if !line.starts_with(' ') {
            records.push(Draft { line: number, key: line.trim_end().to_string(), ..Draft::default() });
            continue;
        }
        let record = records.last_mut().ok_or((number, "the key of a run was expected".to_string()))?;
        let (name, value) = line.trim().split_once(' ').unwrap_or((line.trim(), ""));
        record.read(name, value.trim()).map_err(|reason| (number, reason))?;
    }
    records.into_iter().map(Draft::finish).collect()
}

/// A record that is being read.
#[derive(Default)]
struct Draft {
    line: usize,
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
        match name {
            "scenario" => self.scenario = Some(value.to_string()),
            "seed" => self.seed = Some(value.parse().map_err(|_| wrong())?),
            "variation" => self.variation.push(assignment(value).ok_or_else(wrong)?),
            "individual" => self.people.push(person(value).ok_or_else(wrong)?),
            "case" => self.case = Some(hexadecimal()?),
            "run" => self.fingerprint = Some(hexadecimal()?),
            "against" => self.against.push(value.to_string()),
            _ => return Err(format!("nothing is called `{name}` here")),
        }
        Ok(())
    }

    fn finish(self) -> Result<Recorded, (usize, String)> {
        let missing = |what: &str| (self.line, format!("`{}` has no {what}", self.key));
        Ok(Recorded {
            scenario: self.scenario.clone().ok_or_else(|| missing("scenario"))?,
            seed: self.seed.ok_or_else(|| missing("seed"))?,
            case: self.case.ok_or_else(|| missing("case"))?,
            fingerprint: self.fingerprint.ok_or_else(|| missing("run"))?,
            key: self.key,
            variation: self.variation,
            people: self.people,
            against: self.against,
        })
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
        assert_eq!(read_corpus(&path).unwrap(), [a, b, c]);
        write_corpus(&path, &[]).unwrap();
        assert!(!path.exists());
        write_corpus(&path, &[]).unwrap();
        assert_eq!(read_corpus(&path).unwrap(), []);
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
        ] {
            let (found, reason) = parse(text).unwrap_err();
            assert!(found == line && reason.contains(said), "{text}: {found}: {reason}");
        }
    }
}
