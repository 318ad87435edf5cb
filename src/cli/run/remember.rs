//! What failed, for next time: in files beside the suites if that is wished, and in the folder that nobody commits.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io;
use std::path::Path;

use clap::Args;
use serde::{Deserialize, Serialize};

use crate::cli::store;
use files::{Disk, Files};
use report::console::stderr;
use report::{Terminal, count, with_worst};
use results::judge::{judge, per_run};
use results::{
    CutBy, Event, RatingReport, Recorded, Reporter, Requests, Skip, Standing, SuiteIdentity, SuiteReport,
    TrialReport, TrialState, UnitReport, Verdict,
};
use runner::corpus::{case_hash, corpus_path, is_unchecked, record, write_corpus};
use runner::plan::PlannedTrial;
use runner::project::PlannedSuite;
use runner::run::Stop;
use runner::session::{Units, Work, gate_key};

#[derive(Debug, Args)]
pub struct RememberArguments {
    /// Keep the runs that speak most against failed criteria in a file beside each suite (`zebra.failures` beside
    /// `zebra.suite`), to be committed; they are run first from then on.
    #[arg(long)]
    pub record_failures: bool,

    /// Take those out of these files that do not fail any more, or cannot be run any more.
    #[arg(long)]
    pub prune_failures: bool,
}

/// Brings the files of failures up to date as far as that is wished, and says what could be done. Returns what could not
/// be written.
pub fn failures(
    arguments: &RememberArguments,
    suites: &[PlannedSuite],
    reports: &[SuiteReport],
    requests: &Requests,
) -> Vec<String> {
    let mut complaints = Vec::new();
    for (suite, report) in suites.iter().zip(reports) {
        let path = corpus_path(Path::new(&suite.file));
        if !suite.suite.set.is_empty() {
            // Without the values that were set they could not be run again.
            if arguments.record_failures || arguments.prune_failures {
                let set = suite.suite.set.join(", ");
                complaints.push(format!("{} is left alone: these runs are with {set}", path.display()));
            }
            continue;
        }
        let obsolete: Vec<_> = report.recorded.iter().filter(|one| one.is_obsolete()).collect();
        let known =
            |new: &Recorded| suite.recorded.iter().any(|old| old.key == new.key && old.seed == new.seed);
        let new: Vec<_> =
            speaking_against(suite, report, requests).into_iter().filter(|one| !known(one)).collect();
        let mut kept: Vec<Recorded> = suite.recorded.clone();
        if arguments.prune_failures {
            let is_obsolete = |one: &Recorded| obsolete.iter().any(|gone| *gone.recorded == *one);
            kept.retain(|one| !is_obsolete(one));
        }
        if arguments.record_failures {
            kept.extend(new.iter().cloned());
        }
        // One of an earlier version gets its checksums.
        let is_asked = arguments.record_failures || arguments.prune_failures;
        if kept != suite.recorded || is_asked && is_unchecked(&path, &Disk) {
            match write_corpus(&path, &kept) {
                Ok(()) => {
                    writeln!(stderr(), "note: {} now holds {}", path.display(), count(kept.len(), "failure"))
                }
                Err(error) => complaints.push(error.to_string()),
            }
        }
        if !arguments.prune_failures && !obsolete.is_empty() {
            let number = obsolete.len();
            writeln!(
                stderr(),
                "note: {number} of the failures in {} can go; `--prune-failures` takes them out",
                path.display()
            );
        }
        if !arguments.record_failures && !new.is_empty() {
            let runs = count(new.len(), "failing run");
            writeln!(
                stderr(),
                "note: `--record-failures` keeps {runs} in {}, to be run first",
                path.display()
            );
        }
    }
    complaints
}

/// The runs that failed criteria name as their worst, each with all that it speaks against.
fn speaking_against(suite: &PlannedSuite, report: &SuiteReport, requests: &Requests) -> Vec<Recorded> {
    let failed = report.placed_trials().filter(|(_, trial)| {
        trial.verdict() == Some(Verdict::Failed)
            || trial.standing() == Standing::NotFinished(CutBy::GateFailed)
    });
    let against = failed.flat_map(|(place, trial)| runs_against(&suite.plan.trial(place), trial, requests));
    // The file lies beside the suite: its names do not depend on what else was run.
    against.map(|one| Recorded { key: suite.suite.own_key(&one.key).to_string(), ..one }).collect()
}

fn runs_against(planned: &PlannedTrial, trial: &TrialReport, requests: &Requests) -> Vec<Recorded> {
    let per_run = || trial.trial.criteria.iter().filter_map(per_run);
    let findings = match &trial.state {
        TrialState::Judged(judged) => judged.findings.clone(),
        // What its runs together came to is not known; what one alone breaks is.
        TrialState::NotFinished(_) => {
            let decisive: Vec<_> = per_run().filter(|one| one.decisive).map(|one| one.criterion).collect();
            judge(&decisive, &trial.outcomes, requests).findings
        }
        TrialState::Errored(_) | TrialState::Skipped(_) => return Vec::new(),
    };
    let failed = findings.iter().filter(|finding| finding.verdict == Verdict::Failed);
    let worst: BTreeSet<&str> =
        failed.flat_map(|finding| &finding.worst).map(|run| run.key.as_str()).collect();
    let criteria: Vec<_> = per_run().map(|one| one.criterion).collect();
    let mut records: Vec<Recorded> = Vec::new();
    for (case, outcome) in planned.cases.iter().zip(&trial.outcomes) {
        // Seeds need not make a difference: one of several runs that are the same says it all.
        let is_known = records.iter().any(|known| known.fingerprint == outcome.fingerprint);
        if !worst.contains(case.key.as_str()) || is_known {
            continue;
        }
        let findings = judge(&criteria, std::slice::from_ref(outcome), requests).findings;
        let against = findings.iter().filter(|finding| finding.verdict != Verdict::Passed);
        let against: Vec<_> = against.map(with_worst).collect();
        // The worst run for an aggregate may be on the right side of its bound.
        if !against.is_empty() {
            records.push(record(&case, outcome, against));
        }
    }
    records
}

/// Tells the terminal what happens, and remembers what became of each unit.
pub struct Learning<'l, 'a> {
    pub terminal: Terminal,
    pub units: &'l Units<'a>,
    pub last: &'l mut LastRun,
    /// Who stops what is then run again from the beginning, or refused: nobody has to be told of that, and what was stopped has not failed.
    pub repeated: Option<&'l Stop>,
    /// Who hears all of it as well.
    pub besides: Option<&'l mut dyn Reporter>,
}

impl Reporter for Learning<'_, '_> {
    fn tell(&mut self, event: &Event) {
        if self.repeated.is_some_and(Stop::is_requested) {
            self.terminal.give_up();
            return;
        }
        self.terminal.tell(event);
        if let Some(besides) = &mut self.besides {
            besides.tell(event);
        }
        if let Event::Finished { unit, suite, report, .. } = event {
            let planned = || match self.units.get(*unit).work {
                Work::Trial(planned) => planned,
                Work::Recorded(_) | Work::Block(_) => unreachable!("its report is a trial's"),
            };
            self.last.learn(suite, report, planned);
        }
    }

    fn flush(&mut self) {
        if self.repeated.is_some_and(Stop::is_requested) {
            return;
        }
        self.terminal.flush();
    }
}

/// In the program's own folder.
const LAST_RUN: &str = "last-run.json";

/// What the last sessions left to be run again, with the fingerprints of failing runs.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LastRun {
    /// Of each suite, by its file: suites in two folders may have one name.
    suites: BTreeMap<String, SuiteMemory>,
    /// Of all of it, where it was written: a changed name would be a failure forgotten.
    #[serde(default)]
    crc: Option<String>,
    /// Whether there is something that cannot be understood.
    #[serde(skip)]
    pub is_damaged: bool,
    /// Files as users named them, and as they are called in `suites`.
    #[serde(skip)]
    names: HashMap<String, String>,
}

/// What is remembered of a suite. Keys are without its name, which is longer where others have the same.
#[derive(Debug, Default, Serialize, Deserialize)]
struct SuiteMemory {
    /// Keys of units.
    failed: BTreeSet<String>,
    /// Failing runs by key and seed.
    #[serde(default)]
    runs: BTreeMap<String, SeenRun>,
}

/// A run as the last session saw it, in hexadecimal digits.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SeenRun {
    pub case: String,
    pub fingerprint: String,
}

/// A file by one name, however it was named: from here where it is within this folder.
fn named(file: &str) -> String {
    let identity = Disk.identity(Path::new(file));
    let here = std::env::current_dir().ok().and_then(|here| here.canonicalize().ok());
    let within = here.and_then(|here| identity.strip_prefix(here).ok().map(Path::to_path_buf));
    within.unwrap_or(identity).to_string_lossy().into_owned()
}

/// A key without the name of its suite before it.
fn without_suite<'k>(key: &'k str, suite: &str) -> &'k str {
    key.strip_prefix(suite).unwrap_or(key)
}

/// The name of a run: a key alone says nothing about the seed.
fn run_name(key: &str, seed: u64) -> String {
    format!("{key} {seed}")
}

impl LastRun {
    /// What is remembered; nothing if there is no such file or it is damaged.
    pub fn read() -> Self {
        let damaged = || Self { is_damaged: true, ..Self::default() };
        let text = match store::read(LAST_RUN) {
            Ok(text) => text,
            Err(error) if error.is_missing() => return Self::default(),
            Err(_) => return damaged(),
        };
        let read: Option<Self> = serde_json::from_str(&text).ok();
        let is_whole = |read: &Self| read.crc.as_ref().is_none_or(|crc| *crc == read.checksum());
        read.filter(is_whole).unwrap_or_else(damaged)
    }

    fn checksum(&self) -> String {
        let content = serde_json::to_vec(&self.suites).expect("plain data serialises");
        format!("{:08x}", crc32fast::hash(&content))
    }

    fn memory_of(&mut self, file: &str) -> &mut SuiteMemory {
        if !self.names.contains_key(file) {
            let name = named(file);
            self.suites.entry(name.clone()).or_default();
            self.names.insert(file.to_string(), name);
        }
        self.suites.get_mut(&self.names[file]).expect("it was entered with its name")
    }

    /// A failing run of a suite, if it is remembered.
    pub fn seen(&self, suite: &PlannedSuite, key: &str, seed: u64) -> Option<&SeenRun> {
        let name = run_name(without_suite(key, &suite.suite.key_name()), seed);
        self.suites.get(&named(&suite.file))?.runs.get(&name)
    }

    /// The units that did not pass; where a gate or rating did not, all units of its suite, since it takes all to judge it.
    pub fn failed_units(&self, suites: &[PlannedSuite], units: &Units) -> BTreeSet<String> {
        let known: Vec<_> = suites.iter().map(|one| self.suites.get(&named(&one.file))).collect();
        let gate_failed = |(suite, known): (&PlannedSuite, &Option<&SuiteMemory>)| {
            let failed = |key: String| known.is_some_and(|known| known.failed.contains(&key));
            let mut gates = suite.suite.gates.iter();
            let mut ratings = suite.suite.ratings.iter();
            gates.any(|gate| failed(gate_key("", gate)))
                || ratings.any(|rating| failed(RatingReport::key_of("", rating)))
        };
        let gates: Vec<bool> = suites.iter().zip(&known).map(gate_failed).collect();
        let names: Vec<String> = suites.iter().map(|one| one.suite.key_name()).collect();
        let failed = units.keys().enumerate().filter(|(unit, key)| {
            let suite = units.suite(*unit);
            let own = without_suite(key, &names[suite]);
            gates[suite] || known[suite].is_some_and(|known| known.failed.contains(own))
        });
        failed.map(|(_, key)| key).collect()
    }

    /// Takes over what became of a unit: one that passed is forgotten, one that was not asked for stays as it was. What was to be
    /// run and was not, or not to its end, has not passed. `planned` is the trial that it is, if it is one.
    fn learn(&mut self, suite: &SuiteIdentity, report: &UnitReport, planned: impl FnOnce() -> PlannedTrial) {
        let known = self.memory_of(&suite.file);
        // What was set makes other runs of the same names.
        if suite.set.is_empty() {
            let was_to_be_run = |skip: &Skip| matches!(skip, Skip::Stopped(_) | Skip::Needs { .. });
            let key = without_suite(report.key(), &suite.suite);
            known.learn_standing(key, report.standing());
            let is_recorded = matches!(report, UnitReport::Recorded(_));
            if !is_recorded && report.skip().is_some_and(was_to_be_run) {
                known.failed.insert(key.to_string());
            }
        }
        if let UnitReport::Trial(trial) = report
            && !trial.skipped()
        {
            known.learn_runs(&suite.suite, planned, trial);
        }
    }

    /// As [`Self::learn`], what became of gates and ratings.
    pub fn learn_gates(&mut self, reports: &[SuiteReport]) {
        for report in reports.iter().filter(|one| one.identity.set.is_empty()) {
            let SuiteIdentity { suite, file, .. } = &report.identity;
            let known = self.memory_of(file);
            let gates = report.gates.iter().map(|gate| (&gate.key, gate.standing()));
            let ratings = report.ratings.iter().map(|rating| (&rating.key, rating.standing()));
            for (key, standing) in gates.chain(ratings) {
                known.learn_standing(without_suite(key, suite), standing);
            }
        }
    }

    /// Writes it, if there is or was anything to remember.
    pub fn write(&mut self) -> io::Result<()> {
        self.suites.retain(|_, known| !known.failed.is_empty() || !known.runs.is_empty());
        self.names.clear();
        if self.suites.is_empty() {
            return store::remove(LAST_RUN);
        }
        self.crc = Some(self.checksum());
        store::write(LAST_RUN, &(serde_json::to_string_pretty(self).expect("plain data serialises") + "\n"))
    }
}

impl SuiteMemory {
    fn learn_standing(&mut self, key: &str, standing: Standing) {
        match standing {
            Standing::Skipped => {}
            Standing::NotJudged | Standing::Found | Standing::Judged(Verdict::Passed) => {
                self.failed.remove(key);
            }
            Standing::Judged(_) | Standing::NotFinished(_) | Standing::Errored => {
                self.failed.insert(key.to_string());
            }
        }
    }

    fn learn_runs(&mut self, suite: &str, planned: impl FnOnce() -> PlannedTrial, trial: &TrialReport) {
        let worst: BTreeSet<&str> = match &trial.state {
            TrialState::Judged(judged) => {
                let bad = judged.findings.iter().filter(|finding| finding.verdict != Verdict::Passed);
                bad.flat_map(|finding| &finding.worst).map(|run| run.key.as_str()).collect()
            }
            _ => return,
        };
        if worst.is_empty() && self.runs.is_empty() {
            return;
        }
        let planned = planned();
        for (index, outcome) in trial.outcomes.iter().enumerate() {
            let name = run_name(without_suite(&outcome.key, suite), outcome.seed);
            if worst.contains(outcome.key.as_str()) {
                let hexadecimal = |number: u64| format!("{number:016x}");
                let case = hexadecimal(case_hash(&planned.cases.get(index)));
                let fingerprint = hexadecimal(outcome.fingerprint);
                self.runs.insert(name, SeenRun { case, fingerprint });
            } else {
                self.runs.remove(&name);
            }
        }
    }
}
