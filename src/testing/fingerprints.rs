//! Fingerprints of a suite as a committed file: a line a run, a line a block, a line a metric; a bit that changes is seen.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use numbers::random::digest_bits;
use results::{Requests, UnitReport};
use scenario::Suite;
use scenario::registry::Registry;
use sha2::{Digest, Sha256};

/// Set to `overwrite`, it records the files anew.
const VARIABLE: &str = "FINGERPRINTS";

/// How many differing lines a failure names.
const NAMED: usize = 8;

/// Whether the files are to be recorded.
pub fn recording() -> bool {
    std::env::var(VARIABLE).is_ok_and(|value| value == "overwrite")
}

/// Where the fingerprints of a suite are kept under `folder`: other targets may have other bits.
pub fn path(folder: &Path, file: &str) -> PathBuf {
    let target = format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS);
    folder.join(target).join(format!("{}.txt", file.replace(['/', '\\'], "-")))
}

/// The fingerprints of everything that was run of a suite, in the order of its units, with the keys that the suite has alone.
///
/// # Errors
/// The first unit that was not run to its end.
pub fn lines<'a>(
    suite: &Suite,
    reports: impl IntoIterator<Item = &'a UnitReport>,
    requests: &Requests,
    registry: &Registry,
) -> Result<String, String> {
    let mut text = String::new();
    // What somebody else's criteria ask for besides is no concern of this suite.
    let own = Requests::defaults(registry).iter().count();
    let mut metrics: Vec<_> =
        requests.iter().take(own).map(|request| (request.label(), Sha256::new())).collect();
    for report in reports {
        match report {
            UnitReport::Recorded(_) => {}
            UnitReport::Trial(trial) => {
                if trial.verdict().is_none() {
                    return Err(format!("{} was not run to its end", trial.trial.key));
                }
                for outcome in &trial.outcomes {
                    line(&mut text, suite.own_key(&outcome.key), outcome.fingerprint);
                    for ((_, digest), value) in metrics.iter_mut().zip(&outcome.metrics) {
                        digest.update(value.map_or([0xff; 8], f64::to_le_bytes));
                    }
                }
            }
            UnitReport::Block(block) => {
                let result = block.result().ok_or_else(|| format!("{} came to no result", block.key))?;
                line(&mut text, suite.own_key(&block.key), result.fingerprint());
            }
        }
    }
    for (label, digest) in metrics {
        line(&mut text, &format!("metric {label}"), digest_bits(digest));
    }
    Ok(text)
}

fn line(text: &mut String, key: &str, fingerprint: u64) {
    writeln!(text, "{fingerprint:016x} {key}").expect("writing to a string cannot fail");
}

/// Compares what was found with the file, or records it where `FINGERPRINTS=overwrite` is set.
///
/// # Errors
/// What differs, or why it cannot be said.
pub fn compare(path: &Path, found: &str) -> Result<(), String> {
    if recording() {
        return files::write(path, found)
            .map_err(|error| format!("cannot write {}: {error}", path.display()));
    }
    let kept = files::read_text(path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    let differences = differences(&kept, found);
    if differences.is_empty() {
        return Ok(());
    }
    let count = differences.len();
    let mut text = format!("{count} fingerprints differ from {}:\n", path.display());
    for difference in differences.iter().take(NAMED) {
        writeln!(text, "  {difference}").expect("writing to a string cannot fail");
    }
    if count > NAMED {
        writeln!(text, "  and {} more", count - NAMED).expect("writing to a string cannot fail");
    }
    text += "Nobody changes a bit unseen: find out why. If a defect was mended, name it in the changelog and record them \
             anew with FINGERPRINTS=overwrite.";
    Err(text)
}

/// What is not the same, by key.
fn differences(kept: &str, found: &str) -> Vec<String> {
    let by_key = |text: &str| -> BTreeMap<String, String> {
        let split = |line: &str| line.split_once(' ').map(|(bits, key)| (key.to_string(), bits.to_string()));
        text.lines().filter_map(split).collect()
    };
    let (kept, found) = (by_key(kept), by_key(found));
    let mut all: Vec<_> = kept
        .iter()
        .filter_map(|(key, bits)| match found.get(key) {
            None => Some(format!("{key}: not run any more")),
            Some(now) if now != bits => Some(format!("{key}: {bits} became {now}")),
            Some(_) => None,
        })
        .collect();
    all.extend(found.keys().filter(|key| !kept.contains_key(*key)).map(|key| format!("{key}: new")));
    all
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn whatever_differs_is_named() {
        let kept = "01 a/b/rep=1\n02 a/b/rep=2\n";
        assert!(differences(kept, kept).is_empty());
        assert_eq!(differences(kept, "01 a/b/rep=1\n"), ["a/b/rep=2: not run any more"]);
        assert_eq!(differences(kept, "01 a/b/rep=1\n03 a/b/rep=2\n"), ["a/b/rep=2: 02 became 03"]);
        assert_eq!(differences(kept, &format!("{kept}04 metric pet\n")), ["metric pet: new"]);
        assert_eq!(differences("", "").len(), 0);
    }

    #[test]
    fn a_missing_file_is_no_agreement() {
        let folder = tempfile::tempdir().unwrap();
        let missing = compare(&folder.path().join("none.txt"), "01 a\n").unwrap_err();
        assert!(missing.contains("cannot read"), "{missing}");
        fs::write(folder.path().join("one.txt"), "02 a\n").unwrap();
        let other = compare(&folder.path().join("one.txt"), "01 a\n").unwrap_err();
        assert!(other.contains("a: 02 became 01"), "{other}");
    }
}
