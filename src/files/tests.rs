//! The writers and the reader: what stands after whatever goes wrong.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use proptest::prelude::*;
use serde_json::json;
use tempfile::TempDir;

use super::*;

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// The names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = files.collect();
    names.sort();
    names
}

#[test]
fn nobody_sees_a_file_before_it_is_whole() {
    let folder = folder();
    let path = folder.path().join("reports/of/today.json");
    write(&path, "old").unwrap();
    let mut file = WholeFile::create(&path).unwrap();
    file.write_all(b"ne").unwrap();
    file.flush().unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    file.write_all(b"w").unwrap();
    file.commit().unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    drop(WholeFile::create(&path).unwrap());
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    assert_eq!(names(path.parent().unwrap()), ["today.json"], "nothing else is left");
}

#[test]
fn what_a_killed_process_left_is_taken_over() {
    let folder = folder();
    let path = folder.path().join("a.json");
    fs::write(folder.path().join(".a.json.tmp"), "half").unwrap();
    write(&path, "whole").unwrap();
    assert_eq!(names(folder.path()), ["a.json"]);
    let long = "n".repeat(252);
    write(&folder.path().join(&long), "whole").unwrap();
    assert_eq!(names(folder.path()), ["a.json", &long]);
}

#[test]
fn the_second_of_two_writers_is_told() {
    let folder = folder();
    let path = folder.path().join("a.json");
    let first = WholeFile::create(&path).unwrap();
    let error = write(&path, "second").unwrap_err();
    assert_eq!(error.kind(), ErrorKind::ResourceBusy);
    assert!(error.to_string().contains("another process is writing it"), "{error}");
    first.commit().unwrap();
    write(&path, "second").unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "second");
}

#[test]
fn a_new_file_replaces_none() {
    let folder = folder();
    let path = folder.path().join("a.scn");
    create_new(&path, "mine").unwrap();
    assert_eq!(create_new(&path, "yours").unwrap_err().kind(), ErrorKind::AlreadyExists);
    // Also if it appears while the new one is being written.
    let other = folder.path().join("b.scn");
    let mut late = WholeFile::create(&other).unwrap();
    late.write_all(b"late").unwrap();
    fs::write(&other, "early").unwrap();
    assert_eq!(late.commit_new().unwrap_err().kind(), ErrorKind::AlreadyExists);
    assert_eq!(fs::read_to_string(&other).unwrap(), "early");
    assert_eq!(names(folder.path()), ["a.scn", "b.scn"]);
}

#[test]
fn in_place_keeps_a_copy_until_the_new_one_is_whole() {
    struct Failing(usize);
    impl std::io::Read for Failing {
        fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
            if self.0 == 0 {
                return Err(ErrorKind::StorageFull.into());
            }
            self.0 -= 1;
            out[0] = b'x';
            Ok(1)
        }
    }
    let folder = folder();
    let path = folder.path().join("a.scn");
    fs::write(&path, "the only copy").unwrap();
    for written in [0, 1, 5, 40] {
        let error = in_place::replace(&path, &mut Failing(written)).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::StorageFull);
        assert_eq!(fs::read_to_string(&path).unwrap(), "the only copy");
        assert_eq!(names(folder.path()), ["a.scn"]);
    }
    // A copy from one that was killed is never overwritten.
    fs::write(folder.path().join(".a.scn.old1"), "older").unwrap();
    in_place::replace(&path, &mut &b"new"[..]).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    assert_eq!(names(folder.path()), [".a.scn.old1", "a.scn"]);
}

#[test]
fn a_batch_is_there_once_it_is_finished() {
    let folder = folder();
    let batch = Batch::default();
    let path = |number: usize| folder.path().join(format!("{number}.csv"));
    for number in 0..20 {
        let mut file = WholeFile::create(&path(number)).unwrap();
        file.write_all(number.to_string().as_bytes()).unwrap();
        batch.add(file).unwrap();
    }
    assert!(!path(0).exists());
    fs::create_dir(path(7)).unwrap();
    let failures = batch.finish();
    assert_eq!(failures.iter().map(|(path, _)| path.clone()).collect::<Vec<_>>(), [path(7)]);
    assert!((0..20).filter(|number| *number != 7).all(|number| path(number).is_file()));
    assert_eq!(names(folder.path()).len(), 20);
    assert!(batch.finish().is_empty());
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};

    use super::*;

    #[test]
    fn permissions_stay_and_links_are_followed() {
        let folder = folder();
        let (real, link, circle) =
            (folder.path().join("real"), folder.path().join("link"), folder.path().join("o"));
        fs::write(&real, "old").unwrap();
        symlink("real", folder.path().join("middle")).unwrap();
        symlink(folder.path().join("middle"), &link).unwrap();
        for mode in [0o600, 0o640, 0o755] {
            fs::set_permissions(&real, fs::Permissions::from_mode(mode)).unwrap();
            write(&link, mode.to_string()).unwrap();
            assert_eq!(fs::read_to_string(&real).unwrap(), mode.to_string());
            assert_eq!(real.metadata().unwrap().mode() & 0o777, mode);
            assert!(link.symlink_metadata().unwrap().is_symlink());
        }
        symlink("nowhere", folder.path().join("dangling")).unwrap();
        write(&folder.path().join("dangling"), "new").unwrap();
        assert_eq!(fs::read_to_string(folder.path().join("nowhere")).unwrap(), "new");
        symlink("o", &circle).unwrap();
        assert!(write(&circle, "").unwrap_err().to_string().contains("circle"));
        assert_eq!(write(folder.path(), "").unwrap_err().kind(), ErrorKind::IsADirectory);
    }

    #[test]
    fn all_names_of_a_file_go_on_naming_it() {
        let folder = folder();
        let (one, other) = (folder.path().join("one"), folder.path().join("other"));
        fs::write(&one, "a rather long old text").unwrap();
        fs::hard_link(&one, &other).unwrap();
        write(&one, "new").unwrap();
        assert_eq!(fs::read_to_string(&other).unwrap(), "new");
        assert_eq!(names(folder.path()), ["one", "other"]);
    }

    fn pipe(folder: &Path) -> std::path::PathBuf {
        let path = folder.join("pipe");
        assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
        path
    }

    #[test]
    fn pipes_are_written_directly_and_never_read() {
        let folder = folder();
        let path = pipe(folder.path());
        let reader = Command::new("cat").arg(&path).stdout(Stdio::piped()).spawn().unwrap();
        write(&path, "through").unwrap();
        assert_eq!(reader.wait_with_output().unwrap().stdout, b"through");
        assert!(!path.metadata().unwrap().is_file(), "it is a pipe still");
        let reader = Command::new("cat").arg(&path).stdout(Stdio::piped()).spawn().unwrap();
        let mut log = Log::create(&path, RUNS, &json!({}), &[]).unwrap();
        log.append(&json!({ "run": 1 })).unwrap();
        drop(log);
        let said = String::from_utf8(reader.wait_with_output().unwrap().stdout).unwrap();
        assert!(said.lines().count() == 2 && said.contains("\"run\":1"), "{said}");

        assert!(read_text(&path).unwrap_err().to_string().contains("a named pipe"));
        assert!(Lines::open(&path, 10).unwrap_err().to_string().contains("a named pipe"));
        assert!(read_text(Path::new("/dev/zero")).unwrap_err().to_string().contains("a device"));
        assert!(read_text(folder.path()).unwrap_err().to_string().contains("a folder"));
        let error = Log::open(&path, RUNS, &json!({})).unwrap_err().to_string();
        assert!(error.contains("a named pipe"), "{error}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error_and_loses_nothing() {
        assert_eq!(write(Path::new("/dev/full"), "x").unwrap_err().kind(), ErrorKind::StorageFull);
        write(Path::new("/dev/null"), "x").unwrap();
        assert!(!Path::new("/dev/null").metadata().unwrap().is_file());
    }

    #[test]
    fn only_the_kinds_asked_for_are_read_also_behind_links() {
        let folder = folder();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("secret"), "root:x:0").unwrap();
        fs::write(at("people.csv"), "a\n1\n").unwrap();
        symlink(at("secret"), at("innocent.csv")).unwrap();
        symlink(at("people.csv"), at("link.csv")).unwrap();
        let kinds = ["csv", "json"];
        assert!(read_kind(&at("people.csv"), &kinds).is_ok() && read_kind(&at("link.csv"), &kinds).is_ok());
        for name in ["secret", "innocent.csv"] {
            let error = read_kind(&at(name), &kinds).unwrap_err();
            assert!(matches!(error, ReadError::OtherKind { .. }), "{error}");
            let said = error.to_string();
            assert!(said.contains(".csv or .json") && !said.contains("root"), "{said}");
        }
        assert!(read_kind(&at("none.csv"), &kinds).unwrap_err().is_missing());
    }
}

#[test]
fn what_is_too_large_or_no_text_is_not_read() {
    let folder = folder();
    let path = folder.path().join("large");
    fs::File::create(&path).unwrap().set_len(LARGEST + 1).unwrap();
    assert!(read_text(&path).unwrap_err().to_string().contains("more than 64 MiB"));
    fs::write(&path, b"abc\xff").unwrap();
    assert!(read_text(&path).unwrap_err().to_string().contains("byte 3 is 0xff"));
    assert_eq!(read_bytes(&path, 4).unwrap(), b"abc\xff");
    assert!(matches!(read_bytes(&path, 3), Err(ReadError::TooLarge { most: 3 })));
    fs::write(&path, "one\ntwo and more\nlast").unwrap();
    let mut lines = Lines::open(&path, 14).unwrap();
    assert_eq!(lines.next_line().unwrap().unwrap(), b"one\n");
    assert_eq!(lines.next_line().unwrap().unwrap(), b"two and more\n");
    assert_eq!(lines.next_line().unwrap().unwrap(), b"last");
    assert!(lines.next_line().unwrap().is_none());
    let mut lines = Lines::open(&path, 8).unwrap();
    lines.next_line().unwrap();
    assert!(matches!(lines.next_line(), Err(ReadError::TooLarge { .. })));
}

const RUNS: LogFormat = LogFormat { name: "log of tests", version: 3 };

/// A log of ten records, closed.
fn log(path: &Path) -> Vec<String> {
    let (mut log, found) = Log::open(path, RUNS, &json!({ "seed": 1, "suite": "a" })).unwrap();
    assert_eq!(found, LogContents::default());
    for number in 0..10 {
        log.append(&json!({ "run": number, "value": 0.1 * f64::from(number) })).unwrap();
    }
    log.sync().unwrap();
    assert_eq!(log.records(), 10);
    drop(log);
    read(path).unwrap().0
}

fn read(path: &Path) -> Result<(Vec<String>, Option<String>), LogError> {
    let mut reader = LogReader::open(path, RUNS)?;
    let mut records = Vec::new();
    while let Some(record) = reader.next_record()? {
        records.push(record);
    }
    Ok((records, reader.notice()))
}

#[test]
fn a_log_goes_on_where_it_ended_and_every_line_is_json() {
    let folder = folder();
    let path = folder.path().join("journals/a.jsonl");
    let records = log(&path);
    assert_eq!(records.len(), 10);
    let (mut again, found) = Log::open(&path, RUNS, &json!({ "seed": 1, "suite": "a" })).unwrap();
    assert_eq!(found, LogContents { records, notice: None });
    again.append(&json!({ "run": 10 })).unwrap();
    drop(again);
    assert_eq!(read(&path).unwrap().0.len(), 11);
    for line in fs::read_to_string(&path).unwrap().lines() {
        let line: serde_json::Value = serde_json::from_str(line).unwrap();
        assert_eq!(line["crc"].as_str().unwrap().len(), 8);
    }
}

#[test]
fn a_log_belongs_to_one_thing_and_one_process() {
    let folder = folder();
    let path = folder.path().join("a.jsonl");
    log(&path);
    let before = fs::read(&path).unwrap();
    let error = |format, of| Log::open(&path, format, &of).unwrap_err().to_string();
    assert!(error(RUNS, json!({ "seed": 2, "suite": "a" })).contains("`seed` is another one"));
    let version = LogFormat { version: 4, ..RUNS };
    assert!(error(version, json!({})).contains("version 3, but this version of scenario-runner reads 4"));
    assert!(error(LogFormat { name: "other", ..RUNS }, json!({})).contains("is no other"));
    let held = Log::open(&path, RUNS, &json!({ "seed": 1, "suite": "a" })).unwrap();
    assert!(error(RUNS, json!({ "seed": 1, "suite": "a" })).contains("in use by another process"));
    let create = Log::create(&path, RUNS, &json!({}), &[]);
    assert!(create.unwrap_err().to_string().contains("in use by another process"));
    drop(held);
    assert_eq!(fs::read(&path).unwrap(), before);
    fs::write(&path, "someone's only copy of a poem").unwrap();
    assert!(error(RUNS, json!({})).contains("is no log of tests"));
    assert_eq!(fs::read_to_string(&path).unwrap(), "someone's only copy of a poem");
}

#[test]
fn a_new_log_takes_the_place_of_an_old_file_at_once() {
    let folder = folder();
    let path = folder.path().join("runs.jsonl");
    log(&path);
    let mut new = Log::create(&path, RUNS, &json!({ "seed": 2 }), &["{\"run\":0}".to_string()]).unwrap();
    let error = Log::open(&path, RUNS, &json!({ "seed": 2 })).unwrap_err();
    assert!(matches!(error, LogError::InUse { .. }), "locked since it has its name: {error}");
    new.append(&json!({ "run": 1 })).unwrap();
    drop(new);
    assert_eq!(read(&path).unwrap().0, ["{\"run\":0}", "{\"run\":1}"]);
    assert_eq!(names(folder.path()), ["runs.jsonl"]);
}

#[test]
fn cut_anywhere_a_log_gives_its_whole_records() {
    let folder = folder();
    let path = folder.path().join("a.jsonl");
    let records = log(&path);
    let bytes = fs::read(&path).unwrap();
    let header = bytes.iter().position(|&byte| byte == b'\n').unwrap() + 1;
    for cut in 0..bytes.len() {
        fs::write(&path, &bytes[..cut]).unwrap();
        let whole = bytes[..cut].iter().filter(|&&byte| byte == b'\n').count().saturating_sub(1);
        let (mut log, found) = Log::open(&path, RUNS, &json!({ "seed": 1, "suite": "a" })).unwrap();
        assert_eq!(found.records, records[..whole], "cut at {cut}");
        assert_eq!(found.notice.is_some(), cut > header && bytes[cut - 1] != b'\n', "cut at {cut}");
        log.append(&json!({ "run": "new" })).unwrap();
        drop(log);
        assert_eq!(read(&path).unwrap().0.len(), whole + 1, "cut at {cut}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Whatever happens to a log, it gives the records that were written, or fewer at its end and says so, or none at all.
    #[test]
    fn a_damaged_log_never_gives_another_record(
        kind in 0..6, at in any::<prop::sample::Index>(), to in any::<prop::sample::Index>(), bit in 0..8u32,
    ) {
        let folder = folder();
        let path = folder.path().join("a.jsonl");
        let records = log(&path);
        let good = fs::read(&path).unwrap();
        let mut bytes = good.clone();
        let lines: Vec<&[u8]> = good.split_inclusive(|&byte| byte == b'\n').collect();
        let (first, second) = (at.index(lines.len()), to.index(lines.len()));
        let mut changed = lines.clone();
        match kind {
            0 => bytes[at.index(good.len())] ^= 1 << bit,
            1 => bytes.truncate(at.index(good.len())),
            2 => changed.insert(second, lines[first]),
            3 => changed.swap(first, second),
            4 => { changed.remove(first); }
            _ => bytes.splice(at.index(good.len()).., vec![0; to.index(64)]).for_each(drop),
        }
        if (2..5).contains(&kind) {
            bytes = changed.concat();
        }
        fs::write(&path, &bytes).unwrap();
        match read(&path) {
            Err(LogError::Damaged { .. } | LogError::NotALog { .. } | LogError::OtherVersion { .. }) => {}
            Err(error) => panic!("{error}"),
            Ok((found, notice)) => {
                prop_assert!(records.starts_with(&found), "{found:?}");
                // A log that ends between two records is one that had not come further.
                let ends_whole = good.starts_with(&bytes) && bytes.ends_with(b"\n");
                prop_assert!(notice.is_some() || ends_whole, "{} of 10 without a word", found.len());
            }
        }
    }
}

#[test]
fn a_record_that_cannot_be_written_leaves_no_half() {
    let folder = folder();
    let path = folder.path().join("a.jsonl");
    let (mut log, _) = Log::open(&path, RUNS, &json!({})).unwrap();
    log.append(&json!({ "run": 1 })).unwrap();
    let long = json!({ "run": "x".repeat(LARGEST_RECORD as usize) });
    assert!(matches!(log.append(&long), Err(LogError::RecordTooLong { .. })));
    log.append(&json!({ "run": 2 })).unwrap();
    drop(log);
    assert_eq!(read(&path).unwrap().0, ["{\"run\":1}", "{\"run\":2}"]);
}
