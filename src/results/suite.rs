//! What became of a suite.

use std::borrow::Cow;
use std::path::Path;
use std::time::{Duration, SystemTime};

use serde::{Deserialize, Serialize};

use super::block::{BlockReport, BlockResult};
use super::controller::TestedController;
use super::gate::GateReport;
use super::rating::RatingReport;
use super::recorded::RecordedReport;
use super::skip::Skip;
use super::standing::Standing;
use super::summary::SuiteSummary;
use super::trial::TrialReport;
use files::escape::{shell_path, shell_word};
use numbers::json;
use scenario::{TestedInstead, TextDigest};

/// More seeds are counted, not named.
const MOST_SEEDS_NAMED: usize = 10;

/// Which suite was run, and how to run it again.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SuiteIdentity {
    /// As the suite calls itself.
    pub suite: String,
    /// The file that was run, as the user named it.
    pub file: String,
    /// The suite's seed.
    #[serde(with = "json::whole")]
    pub seed: u64,
    /// What was otherwise on the command line: `av.speed=40km/h`, `controller av=my_av`, `use controllers/my_av.scn`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Controllers in the place of those that its scenarios name.
    #[serde(default)]
    pub tested: Vec<TestedInstead>,
    /// Other seeds that were tried before, if some of them did not pass, in the order in which they first were. Who tries seeds until
    /// one passes has shown nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub earlier_seeds: Vec<TriedSeed>,
    /// What the suite was read from, by name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub texts: Vec<TextDigest>,
}

/// A seed that the same suite was run with before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TriedSeed {
    /// The suite's.
    #[serde(with = "json::whole")]
    pub seed: u64,
    /// Whether all of it passed when it was last run with it.
    pub passed: bool,
}

impl SuiteIdentity {
    /// `seed 1`, or `seed 1, with av.speed=40km/h, av: my_av instead of carla_behavior` where the runs are not those that the
    /// scenarios declare; with `(the 3rd seed tried, of those before 2 did not pass: 1, 2)` if others did not pass.
    pub fn seed_words(&self) -> String {
        let values = self.set.iter().filter(|one| is_value(one)).cloned();
        let otherwise: Vec<String> = values.chain(self.tested.iter().map(ToString::to_string)).collect();
        let seed = match self.tried_words() {
            Some(tried) => format!("seed {} ({tried})", self.seed),
            None => format!("seed {}", self.seed),
        };
        match &otherwise[..] {
            [] => seed,
            otherwise => format!("{seed}, with {}", otherwise.join(", ")),
        }
    }

    /// `the 3rd seed tried; of those before 2 did not pass: 1, 2`; `None` if none is known that did not.
    pub fn tried_words(&self) -> Option<String> {
        let failed: Vec<String> =
            self.earlier_seeds.iter().filter(|one| !one.passed).map(|one| one.seed.to_string()).collect();
        let number = self.earlier_seeds.len() + 1;
        let ending = match (number % 10, number % 100) {
            (_, 11..=13) => "th",
            (1, _) => "st",
            (2, _) => "nd",
            (3, _) => "rd",
            _ => "th",
        };
        let shown = match &failed[..] {
            [] => return None,
            few if few.len() <= MOST_SEEDS_NAMED => few.join(", "),
            many => format!("{}, …", many[..MOST_SEEDS_NAMED].join(", ")),
        };
        Some(format!(
            "the {number}{ending} seed tried; of those before {} did not pass: {shown}",
            failed.len()
        ))
    }

    /// What to type to see one run again.
    pub fn replay_command(&self, key: &str) -> String {
        self.command("replay ", &format!("{} {}", shell_word(key), shell_path(&self.file)), key, "")
    }

    /// What to type to run one block again, with whatever it builds on.
    pub fn block_command(&self, key: &str) -> String {
        self.command("", &format!("{} {}", shell_path(&self.file), shell_word(key)), key, " --exact")
    }

    /// A command about a key, with what seed and values the suite was run with.
    fn command(&self, command: &str, words: &str, key: &str, option: &str) -> String {
        let options = format!("{option} --seed {}{}", self.seed, set_options(&self.set));
        // A key that begins like an option is none behind `--`.
        match key.starts_with('-') {
            true => format!("scenario-runner {command}{} -- {words}", options.trim_start()),
            false => format!("scenario-runner {command}{words}{options}"),
        }
    }
}

const CONTROLLER: &str = "controller ";
const USE: &str = "use ";

/// Whether what was otherwise on the command line is a value, and neither a controller nor where that is declared.
pub fn is_value(said: &str) -> bool {
    !said.starts_with(CONTROLLER) && !is_use(said)
}

/// Whether what was otherwise on the command line is a file that is read besides, on which no run depends.
pub fn is_use(said: &str) -> bool {
    said.starts_with(USE)
}

/// What to type to say the same otherwise again, with a space before each.
pub fn set_options(set: &[String]) -> String {
    let option =
        |one: &String| match (one.strip_prefix(CONTROLLER), one.strip_prefix(USE), one.split_once('=')) {
            (Some(controller), ..) => format!(" --controller {}", shell_word(controller)),
            (_, Some(file), _) => format!(" --use {}", shell_word(file)),
            (.., Some(("repeat", times))) => format!(" --repeat {times}"),
            _ => format!(" --set {}", shell_word(one)),
        };
    set.iter().map(option).collect()
}

/// What to type to record a suite's baseline.
pub fn record_command(file: &str, set: &[String], baseline: &Path) -> String {
    let (file, baseline) = (shell_path(file), shell_path(&baseline.to_string_lossy()));
    format!("scenario-runner baseline save {file}{} --out {baseline}", set_options(set))
}

/// The program that ran a suite.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    /// Of scenario-runner.
    pub version: String,
    /// Operating system and processor: `linux x86_64`.
    pub platform: String,
}

impl Program {
    /// The one that is running.
    pub fn this() -> Self {
        let platform = format!("{} {}", std::env::consts::OS, std::env::consts::ARCH);
        Self { version: env!("CARGO_PKG_VERSION").to_string(), platform }
    }

    /// The one that ran the first of these suites; without any, this one.
    pub fn of(reports: &[SuiteReport]) -> Self {
        reports.first().map_or_else(Self::this, |report| report.program.clone())
    }
}

/// What reports are made of: a suite's trials with what became of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SuiteReport {
    /// Which suite, and how to run it again.
    pub identity: SuiteIdentity,
    /// What ran it.
    pub program: Program,
    /// Wall-clock time when the suite began.
    pub started: SystemTime,
    /// How long the suite took.
    pub wall_time: Duration,
    /// Runs that failed in an earlier session, run again before everything else.
    pub recorded: Vec<RecordedReport>,
    /// All of them, unless `summary` is there: then those that did not pass, and those that were run of scenarios of which
    /// there are [few](super::MOST_SHOWN).
    pub trials: Vec<TrialReport>,
    /// What all trials come to in numbers, where they are not all held: reports of each trial refuse to be made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub summary: Option<SuiteSummary>,
    /// The suite's blocks, each after what it builds on.
    pub blocks: Vec<BlockReport>,
    /// Its controllers that are programs under test, in the order of their names.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub controllers: Vec<TestedController>,
    /// The populations that its people are of, in the order of their names.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub people: Vec<PeopleUsed>,
    /// The suite's gates; empty until all of its trials are judged.
    pub gates: Vec<GateReport>,
    /// The suite's ratings; empty until all of its trials are judged.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ratings: Vec<RatingReport>,
    /// Whether somebody interrupted it before all that was to be done was done.
    pub interrupted: bool,
}

/// A population that people of a suite are of.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PeopleUsed {
    /// Its name, or its file's.
    pub population: String,
    /// Of everybody in it, as baselines hold it.
    pub digest: String,
    /// Of a population that ships: which version of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<u32>,
    /// What has to be known of its use here, such as that people meet vehicles at speeds at which nobody was observed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warning: Option<String>,
}

impl PeopleUsed {
    /// Such as `humans, version 2, digest 0123456789abcdef`.
    pub fn in_words(&self) -> String {
        let version = self.version.map_or_else(String::new, |version| format!(", version {version}"));
        format!("{}{version}, digest {}", self.population, self.digest)
    }
}

impl SuiteReport {
    /// The trials of every scenario, in the order of the suite.
    pub fn scenarios(&self) -> Vec<(&str, Vec<&TrialReport>)> {
        let mut scenarios: Vec<(&str, Vec<&TrialReport>)> = Vec::new();
        for trial in &self.trials {
            let name = trial.trial.scenario.as_str();
            match scenarios.iter_mut().find(|(known, _)| *known == name) {
                Some((_, trials)) => trials.push(trial),
                None => scenarios.push((name, vec![trial])),
            }
        }
        scenarios
    }

    /// How every unit of the suite stands.
    pub fn standings(&self) -> impl Iterator<Item = Standing> {
        let recorded = self.recorded.iter().map(RecordedReport::standing);
        let held = self.trials.iter().filter(|_| self.summary.is_none()).map(TrialReport::standing);
        let counted = self.summary.iter().flat_map(SuiteSummary::standings);
        let counted = counted.flat_map(|one| std::iter::repeat_n(one.standing, one.trials));
        let trials = held.chain(counted);
        recorded.chain(trials).chain(self.blocks.iter().map(BlockReport::standing))
    }

    /// Why units were not run, each reason at least once.
    pub fn skips(&self) -> impl Iterator<Item = &Skip> {
        let held = self.trials.iter().filter_map(TrialReport::skip);
        let counted =
            self.summary.iter().flat_map(SuiteSummary::standings).filter_map(|one| one.skip.as_ref());
        let blocks = self.blocks.iter().filter_map(BlockReport::skip);
        held.chain(counted).chain(blocks).chain(self.recorded.iter().filter_map(RecordedReport::skip))
    }

    /// What stands in the way of a report of each trial: that only some of them are held.
    pub fn incomplete(&self) -> Option<String> {
        let summary = self.summary.as_ref()?;
        let (held, trials) = (self.trials.len(), summary.standings().map(|one| one.trials).sum::<usize>());
        Some(format!(
            "the results of {} hold {held} of {trials} trials and the rest in numbers",
            self.identity.suite
        ))
    }

    /// What its trials come to in numbers.
    pub fn summary(&self) -> Cow<'_, SuiteSummary> {
        match &self.summary {
            Some(summary) => Cow::Borrowed(summary),
            None => Cow::Owned(SuiteSummary::of(&self.trials)),
        }
    }

    /// In how many trials something passed, and in how many evaluations something was measured, that was not put to the test.
    pub fn untested(&self) -> usize {
        let blocks = self.blocks.iter().filter_map(BlockReport::result);
        self.summary().untested() + blocks.filter(|result| result.is_untested()).count()
    }

    /// How many claims with a confidence were judged: of trials and of estimates.
    pub fn claims_with_confidence(&self) -> usize {
        let of_trials: usize = self.summary().scenarios.iter().map(|scenario| scenario.claims).sum();
        let of_block = |block: &BlockReport| match block.result() {
            Some(BlockResult::Estimate(estimate)) => estimate.claims.len(),
            _ => 0,
        };
        of_trials + self.blocks.iter().map(of_block).sum::<usize>()
    }

    /// How many evaluations its searches and tunes made.
    pub fn evaluations(&self) -> usize {
        self.blocks.iter().filter_map(BlockReport::result).map(BlockResult::evaluations).sum()
    }

    /// The trials that are held, each with its place among all trials of the suite.
    pub fn placed_trials(&self) -> impl Iterator<Item = (usize, &TrialReport)> {
        let place = |index: usize| self.summary.as_ref().map_or(index, |summary| summary.held[index]);
        self.trials.iter().enumerate().map(move |(index, trial)| (place(index), trial))
    }
}
