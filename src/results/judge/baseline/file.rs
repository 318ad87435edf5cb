//! Baselines as files: JSON with one line per trial and metric, sorted, the same bytes for the same runs.
//!
//! Every trial ends with a checksum of what stands in it, and the file with one of all: nobody edits a number unseen.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{Baseline, Parts, RecordedMetric, RecordedTrial, TestedVehicle};
use files::{Files, ReadError};

/// Version of the layout; raised when a reader would have to change.
const LAYOUT: u64 = 2;

/// That of version 0.1, without checksums, which is still read.
const UNCHECKED: u64 = 1;

/// Why a baseline cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BaselineError {
    /// There is no such file; record one first.
    #[error("there is no baseline {}", path.display())]
    Missing {
        /// Where it was looked for.
        path: PathBuf,
    },
    /// The system refuses to read it, or it is larger than may be read.
    #[error("cannot read the baseline {}: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What is wrong, in words.
        reason: String,
    },
    /// Its text is none of a baseline's.
    #[error("{} is not a baseline: {reason}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong, with its line if it has one.
        reason: String,
    },
    /// A later version of scenario-runner wrote it.
    #[error("the baseline {} has layout {found}, but this version of scenario-runner reads layout {LAYOUT}", path.display())]
    OtherLayout {
        /// The file.
        path: PathBuf,
        /// The number of its layout.
        found: u64,
    },
}

impl BaselineError {
    /// What to do about it; `record` is the command that records it anew.
    pub fn hint(&self, record: &str) -> String {
        match self {
            Self::Missing { .. } => format!("record it with `{record}`"),
            Self::OtherLayout { found, .. } if *found > LAYOUT => {
                format!("take the newer version that wrote it, or record it anew with `{record}`")
            }
            Self::Unreadable { .. } | Self::Malformed { .. } | Self::OtherLayout { .. } => {
                format!("restore it from version control, or record it anew with `{record}`")
            }
        }
    }
}

impl Baseline {
    /// Reads the baseline that a file from somebody names: one that ends in `.json`, also behind links.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_named(path: &Path, files: &dyn Files) -> Result<Self, BaselineError> {
        Self::of(path, files.read_text(path, &["json"]))
    }

    /// Whether the file is a baseline of version 0.1, which has no checksums.
    pub fn is_unchecked(path: &Path) -> bool {
        let layout = files::read_text(path).ok().and_then(|text| serde_json::from_str::<Layout>(&text).ok());
        layout.is_some_and(|layout| layout.baseline == UNCHECKED)
    }

    /// Reads a baseline.
    ///
    /// # Errors
    /// If there is none, or if it is not as it was written.
    pub fn read(path: &Path) -> Result<Self, BaselineError> {
        Self::of(path, files::read_text(path))
    }

    fn of(path: &Path, text: Result<String, ReadError>) -> Result<Self, BaselineError> {
        let text = text.map_err(|error| match error {
            error if error.is_missing() => BaselineError::Missing { path: path.to_owned() },
            error => BaselineError::Unreadable { path: path.to_owned(), reason: error.to_string() },
        })?;
        let malformed = |reason: String| BaselineError::Malformed { path: path.to_owned(), reason };
        let Layout { baseline: found } =
            serde_json::from_str(&text).map_err(|error| malformed(error.to_string()))?;
        if found != LAYOUT && found != UNCHECKED {
            return Err(BaselineError::OtherLayout { path: path.to_owned(), found });
        }
        let file: File = serde_json::from_str(&text).map_err(|error| malformed(error.to_string()))?;
        let (checksum, of_trials) = file.checksums();
        let baseline = file.baseline().map_err(malformed)?;
        if found == LAYOUT {
            baseline.check(checksum.as_deref(), &of_trials).map_err(malformed)?;
        }
        Ok(baseline)
    }

    /// Compares checksums, that of the file and those of its trials by key, with what they ought to be.
    fn check(&self, whole: Option<&str>, of_trials: &BTreeMap<String, Option<String>>) -> Result<(), String> {
        let wrong = |what: String| format!("the checksum of {what} is wrong: it is not as it was written");
        for trial in &self.trials {
            let stated = of_trials.get(&trial.key).and_then(Option::as_deref);
            if stated != Some(checksum(&trial_text(self, trial)).as_str()) {
                return Err(wrong(format!("trial `{}`", trial.key)));
            }
        }
        if whole == Some(checksum(&self.body()).as_str()) { Ok(()) } else { Err(wrong("the file".into())) }
    }

    /// The file's text, with a final line end.
    pub fn text(&self) -> String {
        let body = self.body();
        format!("{{\n{body}  \"crc\": {}\n}}\n", json(&checksum(&body)))
    }

    /// All but the braces and the checksum.
    fn body(&self) -> String {
        let mut text = String::new();
        let mut line = |depth: usize, content: &str| {
            writeln!(text, "{:1$}{content}", "", 2 * depth).expect("writing to a string cannot fail");
        };
        line(1, &format!("\"baseline\": {LAYOUT},"));
        line(1, &format!("\"suite\": {},", json(&self.suite)));
        line(1, &format!("\"seed\": {},", self.seed));
        if !self.set.is_empty() {
            line(1, &format!("\"set\": {},", json(&self.set)));
        }
        line(1, &format!("\"tool\": {},", json(&self.tool)));
        if !self.populations.is_empty() {
            line(1, &format!("\"populations\": {},", json(&self.populations)));
        }
        if !self.population_versions.is_empty() {
            line(1, &format!("\"population_versions\": {},", json(&self.population_versions)));
        }
        if !self.programs.is_empty() {
            line(1, &format!("\"programs\": {},", json(&self.programs)));
        }
        if !self.what_runs.is_empty() {
            line(1, &format!("\"what_runs\": {},", json(&self.what_runs)));
        }
        if !self.nondeterministic.is_empty() {
            line(1, &format!("\"nondeterministic\": {},", json(&self.nondeterministic)));
        }
        line(1, "\"metrics\": [");
        for (index, metric) in self.metrics.iter().enumerate() {
            line(2, &(json(metric) + comma(index, self.metrics.len())));
        }
        line(1, "],");
        line(1, "\"vehicles\": [");
        for (index, vehicles) in self.vehicles.iter().enumerate() {
            line(2, "[");
            for (place, vehicle) in vehicles.iter().enumerate() {
                write_vehicle(&mut line, vehicle, comma(place, vehicles.len()));
            }
            line(2, &format!("]{}", comma(index, self.vehicles.len())));
        }
        line(1, "],");
        line(1, "\"trials\": [");
        for (index, trial) in self.trials.iter().enumerate() {
            let content = trial_text(self, trial);
            let crc = json(&checksum(&content));
            line(2, &format!("{{\n{content}      \"crc\": {crc}\n    }}{}", comma(index, self.trials.len())));
        }
        line(1, "],");
        text
    }
}

/// Eight hexadecimal digits.
fn checksum(text: &str) -> String {
    format!("{:08x}", crc32fast::hash(text.as_bytes()))
}

/// One line per parameter, so that a changed one is seen in a difference of two files.
fn write_vehicle(line: &mut impl FnMut(usize, &str), vehicle: &TestedVehicle, end: &str) {
    line(3, "{");
    line(4, &format!("\"name\": {},", json(&vehicle.name)));
    for (part, setup) in [
        ("controller", Some((vehicle.controller.model.name(), &vehicle.controller.settings))),
        ("dynamics", Some((vehicle.dynamics.model.name(), &vehicle.dynamics.settings))),
        ("sees", vehicle.sees.as_ref().map(|sees| (sees.model.name(), &sees.settings))),
    ] {
        let Some((name, settings)) = setup else { continue };
        let settings = &settings.0;
        line(4, &format!("\"{part}\": {{"));
        line(5, &format!("\"name\": {},", json(&name)));
        line(5, "\"settings\": {");
        for (index, (name, value)) in settings.iter().enumerate() {
            line(6, &format!("{}: {}{}", json(name), json(value), comma(index, settings.len())));
        }
        line(5, "}");
        line(4, "},");
    }
    line(4, &format!("\"length\": {},", json(&vehicle.length)));
    let obeys = if vehicle.obeys_signals { "," } else { "" };
    line(4, &format!("\"width\": {}{obeys}", json(&vehicle.width)));
    if vehicle.obeys_signals {
        line(4, "\"obeys_signals\": true");
    }
    line(3, &format!("}}{end}"));
}

/// A trial's lines, without braces and checksum.
fn trial_text(baseline: &Baseline, trial: &RecordedTrial) -> String {
    let mut text = String::new();
    let mut line = |depth: usize, content: &str| {
        writeln!(text, "{:1$}{content}", "", 2 * depth).expect("writing to a string cannot fail");
    };
    line(3, &format!("\"key\": {},", json(&trial.key)));
    line(3, &format!("\"scenario\": {},", json(&trial.scenario)));
    line(3, &format!("\"certain\": {},", trial.certain));
    line(3, &format!("\"fingerprint\": {},", json(&trial.fingerprint)));
    if let Some(seeds) = &trial.seeds {
        line(3, &format!("\"seeds\": {},", json(seeds)));
    }
    if trial.cut_off > 0 {
        line(3, &format!("\"cut_off\": {},", trial.cut_off));
    }
    if !trial.warnings.is_empty() {
        line(3, &format!("\"warnings\": {},", json(&trial.warnings)));
    }
    line(3, &format!("\"parts\": {},", json(&trial.parts)));
    line(3, &format!("\"vehicles\": {},", trial.vehicles));
    let runs = if *trial.runs == repetitions(trial.runs.len()) {
        trial.runs.len().to_string()
    } else {
        json(&trial.runs)
    };
    line(3, &format!("\"runs\": {runs},"));
    line(3, "\"values\": {");
    for (index, (metric, row)) in baseline.metrics.iter().zip(&trial.values).enumerate() {
        let row = match &row[..] {
            [first, rest @ ..] if rest.iter().all(|value| value == first) => json(&compact(*first)),
            row => json(&row.iter().map(|value| compact(*value)).collect::<Vec<_>>()),
        };
        line(4, &format!("{}: {row}{}", json(&metric.label), comma(index, baseline.metrics.len())));
    }
    line(3, "},");
    text
}

/// A whole number without its `.0`.
fn compact(value: Option<f64>) -> serde_json::Value {
    match value {
        None => serde_json::Value::Null,
        Some(value) if value.fract() == 0.0 && value.abs() < 1e15 => (value as i64).into(),
        Some(value) => value.into(),
    }
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("plain data serialises")
}

fn comma(index: usize, count: usize) -> &'static str {
    if index + 1 < count { "," } else { "" }
}

/// How runs without individuals are called.
fn repetitions(count: usize) -> Vec<String> {
    (1..=count).map(|repetition| format!("rep={repetition}")).collect()
}

/// What says how to read the rest.
#[derive(Deserialize)]
struct Layout {
    baseline: u64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "baseline")]
    _layout: u64,
    suite: String,
    seed: u64,
    #[serde(default)]
    set: Vec<String>,
    tool: String,
    /// Of files from before it was noted: none.
    #[serde(default)]
    populations: BTreeMap<String, String>,
    #[serde(default)]
    population_versions: BTreeMap<String, u32>,
    #[serde(default)]
    programs: BTreeMap<String, String>,
    #[serde(default)]
    what_runs: BTreeMap<String, String>,
    #[serde(default)]
    nondeterministic: BTreeMap<String, String>,
    metrics: Vec<RecordedMetric>,
    vehicles: Vec<Vec<TestedVehicle>>,
    trials: Vec<TrialInFile>,
    #[serde(default)]
    crc: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TrialInFile {
    key: String,
    scenario: String,
    certain: bool,
    fingerprint: String,
    #[serde(default)]
    seeds: Option<String>,
    // What it was called as long as it counted those on a collision course only.
    #[serde(default, alias = "on_course")]
    cut_off: usize,
    #[serde(default)]
    warnings: Vec<String>,
    parts: Parts,
    vehicles: usize,
    runs: RunsInFile,
    values: BTreeMap<String, RowInFile>,
    #[serde(default)]
    crc: Option<String>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum RunsInFile {
    Repetitions(usize),
    Named(Vec<String>),
}

#[derive(Deserialize)]
#[serde(untagged)]
enum RowInFile {
    Each(Vec<Option<f64>>),
    All(Option<f64>),
}

impl File {
    /// What it states: the checksum of all, and that of each trial by key.
    fn checksums(&self) -> (Option<String>, BTreeMap<String, Option<String>>) {
        let trials = self.trials.iter().map(|trial| (trial.key.clone(), trial.crc.clone()));
        (self.crc.clone(), trials.collect())
    }

    fn baseline(self) -> Result<Baseline, String> {
        let Self {
            suite,
            seed,
            set,
            tool,
            populations,
            population_versions,
            programs,
            what_runs,
            nondeterministic,
            metrics,
            vehicles,
            trials: written,
            ..
        } = self;
        let mut trials = Vec::with_capacity(written.len());
        for trial in written {
            let key = trial.key.clone();
            let recorded = trial.recorded(&metrics).map_err(|reason| format!("trial `{key}`: {reason}"))?;
            if recorded.vehicles >= vehicles.len() {
                return Err(format!("trial `{key}`: there are no vehicles {}", recorded.vehicles));
            }
            trials.push(recorded);
        }
        trials.sort_by(|left, right| left.key.cmp(&right.key));
        if let Some(twice) = trials.windows(2).find(|pair| pair[0].key == pair[1].key) {
            return Err(format!("trial `{}` stands twice", twice[0].key));
        }
        Ok(Baseline {
            suite,
            apart: String::new(),
            seed,
            set,
            tool,
            populations,
            population_versions,
            programs,
            what_runs,
            nondeterministic,
            metrics,
            vehicles,
            trials,
        })
    }
}

impl TrialInFile {
    fn recorded(mut self, metrics: &[RecordedMetric]) -> Result<RecordedTrial, String> {
        let runs = match self.runs {
            RunsInFile::Repetitions(count) => repetitions(count),
            RunsInFile::Named(names) => names,
        };
        if runs.is_empty() {
            return Err("it has no runs".to_string());
        }
        let mut values = Vec::with_capacity(metrics.len());
        for metric in metrics {
            let row = match self.values.remove(&metric.label) {
                None => return Err(format!("`{}` has no values", metric.label)),
                Some(RowInFile::All(value)) => vec![value; runs.len()],
                Some(RowInFile::Each(row)) => row,
            };
            if row.len() != runs.len() {
                let (found, wanted) = (row.len(), runs.len());
                return Err(format!("`{}` has {found} values for {wanted} runs", metric.label));
            }
            values.push(row);
        }
        if let Some(label) = self.values.keys().next() {
            return Err(format!("there is no metric `{label}`"));
        }
        Ok(RecordedTrial {
            key: self.key,
            scenario: self.scenario,
            certain: self.certain,
            fingerprint: self.fingerprint,
            seeds: self.seeds,
            cut_off: self.cut_off,
            warnings: self.warnings,
            parts: self.parts,
            vehicles: self.vehicles,
            runs,
            values,
        })
    }
}
