//! What a scenario came to when it was last run, from files of results, and whether that is of the text as it is now.
//!
//! A result counts as of now only where every text that it was read from still has the digest that the results hold.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::SystemTime;

use serde::Deserialize;
use serde_json::Value;

use super::workspace::Workspace;
use files::{Disk, Files};
use report::console::stderr;
use scenario::{TextDigest, sha256};

/// Larger files of results are not read, bytes.
const LARGEST: u64 = 64 << 20;

/// Files of results that are kept in memory.
const MOST_KEPT: usize = 100;

/// The largest text that is compared, bytes.
const LARGEST_TEXT: u64 = 64 << 20;

/// Where the commands of code lenses write results: from a root, by the file that is run.
const FOLDER: &str = ".scenario-runner/results";

/// The kinds of files that scenarios are read from.
const ENDINGS: [&str; 6] = ["scn", "suite", "yaml", "yml", "csv", "json"];

#[derive(Debug, Deserialize)]
struct File {
    tool: Tool,
    suites: Vec<Suite>,
}

/// A file of results as it was at a time; `None` where it is none.
type Kept = (Stamp, Option<Rc<File>>);

#[derive(Debug, Deserialize)]
struct Tool {
    version: String,
}

#[derive(Debug, Deserialize)]
struct Suite {
    seed: Value,
    #[serde(default)]
    set: Vec<String>,
    #[serde(default)]
    texts: Vec<TextDigest>,
    record: SuiteRecord,
    trials: Vec<Trial>,
    #[serde(default)]
    recorded: Vec<Besides>,
    #[serde(default)]
    blocks: Vec<Besides>,
    #[serde(default)]
    gates: Vec<Besides>,
    #[serde(default)]
    ratings: Vec<Besides>,
}

/// What there is in a suite besides trials.
#[derive(Debug, Deserialize)]
struct Besides {
    key: String,
    /// Of a run that was recorded.
    #[serde(default)]
    scenario: Option<String>,
    /// `None` of what asks for nothing.
    verdict: Option<String>,
}

#[derive(Debug, Deserialize)]
struct SuiteRecord {
    started: SystemTime,
}

#[derive(Debug, Deserialize)]
struct Trial {
    scenario: String,
    verdict: String,
    #[serde(default)]
    message: Option<String>,
    #[serde(default)]
    findings: Vec<Finding>,
    record: TrialRecord,
}

#[derive(Debug, Deserialize)]
struct TrialRecord {
    trial: TrialPlace,
}

#[derive(Debug, Deserialize)]
struct TrialPlace {
    origin: PlaceThen,
}

/// Where something stood in its text then.
#[derive(Debug, Clone, Deserialize, PartialEq, Eq)]
pub struct PlaceThen {
    file: String,
    pub line: usize,
    pub source_line: String,
}

impl PlaceThen {
    /// Whether it is in a file, where results were made in the folder `root`.
    pub fn is_in(&self, root: &Path, path: &Path) -> bool {
        is_file(root, &self.file, path)
    }
}

#[derive(Debug, Deserialize)]
struct Finding {
    criterion: String,
    verdict: String,
    origin: PlaceThen,
    #[serde(default)]
    worst: Vec<Worst>,
}

#[derive(Debug, Deserialize)]
struct Worst {
    key: String,
}

/// A criterion that did not pass in some trials.
#[derive(Debug, Clone)]
pub struct Broken {
    pub criterion: String,
    /// `failed` or `inconclusive`.
    pub verdict: String,
    pub place: PlaceThen,
    pub trials: usize,
    /// The key of the run that speaks most against it.
    pub worst: Option<String>,
}

/// What a scenario, or everything in a file that was run, came to.
#[derive(Debug)]
pub struct LastResult {
    started: SystemTime,
    /// Of the suite, as a user gives it.
    pub seed: String,
    /// What the command line said otherwise.
    pub set: Vec<String>,
    /// Why the result may not be that of the text as it is now.
    pub stale: Option<String>,
    /// Of trials, in the order of their first.
    pub verdicts: Vec<(String, usize)>,
    /// The keys of what did not pass besides trials: runs that were recorded and, of a suite, blocks, gates and ratings.
    pub besides: Vec<String>,
    /// Why some trials were not judged.
    pub message: Option<String>,
    pub broken: Vec<Broken>,
}

impl LastResult {
    fn count(&self, verdict: &str) -> usize {
        self.verdicts.iter().find(|(word, _)| word == verdict).map_or(0, |(_, count)| *count)
    }

    /// In a few words. It passed only if each of its trials did, and whatever else there is.
    pub fn words(&self) -> String {
        let all: usize = self.verdicts.iter().map(|(_, count)| count).sum();
        let trials = if all == 1 { "1 trial".to_string() } else { format!("{all} trials") };
        let result = match self.count("failed") {
            0 if self.count("passed") == all => format!("passed: {trials}"),
            0 => {
                let others = self.verdicts.iter().filter(|(word, _)| word != "passed");
                let others = others.map(|(word, count)| format!("{count} {}", word.replace('_', " ")));
                format!("not passed: {} of {trials}", others.collect::<Vec<_>>().join(", "))
            }
            failed => format!("failed: {failed} of {trials}"),
        };
        let result = match &self.besides[..] {
            [] => result,
            [first, more @ ..] => {
                let more = if more.is_empty() { String::new() } else { format!(" and {} more", more.len()) };
                format!("not passed: {first}{more}; trials {result}")
            }
        };
        let set = if self.set.is_empty() { String::new() } else { format!(", with {}", self.set.join(", ")) };
        match &self.stale {
            None => format!("last run {result}{set}"),
            Some(why) => format!("stale ({why}): last run {result}{set}"),
        }
    }

    /// The run that speaks most against it.
    pub fn worst(&self) -> Option<&str> {
        let failed = self.broken.iter().find(|one| one.verdict == "failed" && one.worst.is_some());
        failed.or(self.broken.iter().find(|one| one.worst.is_some()))?.worst.as_deref()
    }
}

/// The texts as they are while a request is answered: each is read once, however many results it is compared with.
pub struct TextsNow<'f> {
    files: &'f dyn Files,
    digests: RefCell<HashMap<PathBuf, Option<String>>>,
}

impl<'f> TextsNow<'f> {
    pub fn new(files: &'f dyn Files) -> Self {
        Self { files, digests: RefCell::default() }
    }

    /// `None` of what cannot be read.
    fn digest(&self, place: PathBuf) -> Option<String> {
        let read = |place: &Path| Some(sha256(&self.files.read(place, &ENDINGS, LARGEST_TEXT).ok()?));
        let mut digests = self.digests.borrow_mut();
        digests.get(&place).cloned().unwrap_or_else(|| {
            let digest = read(&place);
            digests.insert(place, digest.clone());
            digest
        })
    }
}

/// Of a file, when it was read.
type Stamp = (Option<SystemTime>, u64);

/// Files of results, each read once as long as it does not change.
#[derive(Debug, Default)]
pub struct LastResults {
    kept: RefCell<HashMap<PathBuf, Kept>>,
}

/// The file of results that a run of a file writes, from a root: of one scenario, or of all.
pub fn results_of(below: &Path, scenario: Option<&str>) -> PathBuf {
    let folder = Path::new(FOLDER).join(below);
    match scenario {
        Some(name) => folder.join("scenario").join(format!("{name}.json")),
        None => folder.join("all.json"),
    }
}

impl LastResults {
    /// What a scenario of a file, or without one everything that was run of it, last came to.
    pub fn of(
        &self,
        path: &Path,
        scenario: Option<&str>,
        workspace: &Workspace,
        texts: &TextsNow,
    ) -> Option<LastResult> {
        let (root, below) = workspace.place(path)?;
        let own =
            [results_of(&below, None)].into_iter().chain(scenario.map(|name| results_of(&below, Some(name))));
        let all = own.chain(workspace.results.iter().cloned());
        let found = all.filter_map(|results| {
            let file = self.read(&root.join(results), root)?;
            // Of a suite, what its own file of results holds; of a scenario, what is of this very file.
            let is_of = |trial: &Trial| match scenario {
                Some(name) => trial.scenario == name && is_file(root, &trial.record.trial.origin.file, path),
                None => true,
            };
            let runs = file.suites.iter().filter_map(|suite| last_run(suite, scenario, is_of));
            let newest = runs.max_by_key(|(_, run)| run.started)?;
            let (suite, run) = newest;
            let stale = stale(&file.tool.version, suite, path, root, workspace, texts);
            Some(LastResult { stale, ..run })
        });
        found.max_by_key(|run| run.started)
    }

    /// A file of results below a root; what is none is said once and ignored.
    fn read(&self, path: &Path, root: &Path) -> Option<Rc<File>> {
        if !Disk.is_file(path) || !Disk.identity(path).starts_with(root) {
            return None;
        }
        let metadata = path.metadata().ok()?;
        let stamp = (metadata.modified().ok(), metadata.len());
        if let Some((known, file)) = self.kept.borrow().get(path)
            && *known == stamp
        {
            return file.clone();
        }
        let read = Disk.read(path, &["json"], LARGEST).map_err(|error| error.to_string());
        let file =
            read.and_then(|bytes| serde_json::from_slice::<File>(&bytes).map_err(|error| error.to_string()));
        let file =
            file.map_err(|error| writeln!(stderr(), "{} are no results: {error}", path.display())).ok();
        let mut kept = self.kept.borrow_mut();
        if kept.len() >= MOST_KEPT {
            kept.clear();
        }
        let file = file.map(Rc::new);
        kept.insert(path.to_path_buf(), (stamp, file.clone()));
        file
    }
}

/// Whether results that were made in a folder mean a file by a name.
fn is_file(root: &Path, name: &str, path: &Path) -> bool {
    Disk.identity(&root.join(name)) == Disk.identity(path)
}

/// What came of those trials of a suite, and of what else there is of the scenario, or of all of it.
fn last_run<'s>(
    suite: &'s Suite,
    scenario: Option<&str>,
    is_of: impl Fn(&Trial) -> bool,
) -> Option<(&'s Suite, LastResult)> {
    let trials: Vec<&Trial> = suite.trials.iter().filter(|trial| is_of(trial)).collect();
    // Results name every trial, those too that were not selected: a run of others is no run of these.
    trials.iter().find(|trial| trial.verdict != "skipped")?;
    let (mut verdicts, mut broken): (Vec<(String, usize)>, Vec<Broken>) = (Vec::new(), Vec::new());
    for trial in &trials {
        match verdicts.iter_mut().find(|(word, _)| *word == trial.verdict) {
            Some((_, count)) => *count += 1,
            None => verdicts.push((trial.verdict.clone(), 1)),
        }
        for finding in trial.findings.iter().filter(|one| one.verdict != "passed") {
            let same = |one: &&mut Broken| one.criterion == finding.criterion && one.place == finding.origin;
            match broken.iter_mut().find(same) {
                Some(one) => {
                    one.trials += 1;
                    if finding.verdict == "failed" && one.verdict != "failed" {
                        one.verdict.clone_from(&finding.verdict);
                        one.worst = finding.worst.first().map(|worst| worst.key.clone());
                    }
                }
                None => broken.push(Broken {
                    criterion: finding.criterion.clone(),
                    verdict: finding.verdict.clone(),
                    place: finding.origin.clone(),
                    trials: 1,
                    worst: finding.worst.first().map(|worst| worst.key.clone()),
                }),
            }
        }
    }
    let others = suite.blocks.iter().chain(&suite.gates).chain(&suite.ratings);
    let recorded =
        suite.recorded.iter().filter(|one| scenario.is_none() || one.scenario.as_deref() == scenario);
    let besides = recorded.chain(others.filter(|_| scenario.is_none()));
    let is_open = |one: &&Besides| {
        one.verdict.as_ref().is_some_and(|verdict| !["passed", "found"].contains(&verdict.as_str()))
    };
    let besides = besides.filter(is_open).map(|one| one.key.clone()).collect();
    let seed = suite.seed.as_str().map_or_else(|| suite.seed.to_string(), str::to_string);
    let run = LastResult {
        started: suite.record.started,
        seed,
        set: suite.set.clone(),
        stale: None,
        verdicts,
        besides,
        message: trials.iter().find_map(|trial| trial.message.clone()),
        broken,
    };
    Some((suite, run))
}

/// Why results are not of the texts as they are.
fn stale(
    version: &str,
    suite: &Suite,
    path: &Path,
    root: &Path,
    workspace: &Workspace,
    texts: &TextsNow,
) -> Option<String> {
    if version != env!("CARGO_PKG_VERSION") {
        return Some(format!("made by version {version}"));
    }
    if !suite.texts.iter().any(|text| is_file(root, &text.file, path)) {
        return Some("the results do not say of which text".to_string());
    }
    suite.texts.iter().find_map(|text| {
        let place = root.join(&text.file);
        if workspace.place(&place).is_none() {
            return Some(format!("{} lies outside of the workspace", text.file));
        }
        match texts.digest(place) {
            Some(digest) => (digest != text.sha256).then(|| format!("{} has changed", text.file)),
            None => Some(format!("{} cannot be read", text.file)),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn words(change: impl FnOnce(&mut Value), scenario: Option<&str>) -> String {
        let origin = json!({ "file": "a.suite", "line": 2, "source_line": "scenario late {" });
        let mut suite = json!({
            "seed": 1,
            "record": { "started": { "secs_since_epoch": 0, "nanos_since_epoch": 0 } },
            "trials": [{ "scenario": "late", "verdict": "passed", "record": { "trial": { "origin": origin } } }],
            "recorded": [], "blocks": [], "gates": [],
        });
        change(&mut suite);
        let suite: Suite = serde_json::from_value(suite).unwrap();
        last_run(&suite, scenario, |_| true).unwrap().1.words()
    }

    #[test]
    fn a_suite_whose_gate_failed_did_not_pass_though_its_trials_did() {
        assert_eq!(words(|_| (), None), "last run passed: 1 trial");
        let failed = |kind: &'static str| {
            move |suite: &mut Value| {
                suite[kind] = json!([{ "key": "a/that", "scenario": "late", "verdict": "failed" }])
            }
        };
        for kind in ["gates", "blocks", "ratings", "recorded"] {
            assert_eq!(
                words(failed(kind), None),
                "last run not passed: a/that; trials passed: 1 trial",
                "{kind}"
            );
        }
        // A scenario has no gate; what was recorded is of one.
        assert_eq!(words(failed("gates"), Some("late")), "last run passed: 1 trial");
        assert!(words(failed("recorded"), Some("late")).starts_with("last run not passed: a/that"));
        assert_eq!(words(failed("recorded"), Some("early")), "last run passed: 1 trial");
        // One that asks for nothing fails nothing; several are counted.
        let rating = |suite: &mut Value| suite["ratings"] = json!([{ "key": "a/points", "verdict": null }]);
        assert_eq!(words(rating, None), "last run passed: 1 trial");
        let two = |suite: &mut Value| {
            suite["gates"] =
                json!([{ "key": "a/g", "verdict": "failed" }, { "key": "a/h", "verdict": "skipped" }]);
        };
        assert!(words(two, None).starts_with("last run not passed: a/g and 1 more;"));
    }
}
