//! What became of a gate, and its comparisons.

use super::standing::Standing;
use super::written_counts::is_zero;
use crate::Verdict;
use numbers::json;
use scenario::{Dimension, Gate, Metric, Notation, Reference, Suite, show_apart};
use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What became of a gate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GateReport {
    /// What the suite declares.
    pub gate: Arc<Gate>,
    /// Such as `zebra/gate=braking`.
    pub key: String,
    /// What it came to.
    pub state: GateState,
}

/// Whether a gate was judged, or why not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GateState {
    /// It was compared with its baseline.
    Judged(Box<GateVerdict>),
    /// There is no baseline, or it may not be compared with.
    Refused(Refusal),
    /// The runs to judge are not all there.
    NotJudged(NotJudged),
}

/// Why nobody looked at a gate: not all runs of its suite are there.
#[derive(Debug, Clone, PartialEq, Eq, Error, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NotJudged {
    /// Nothing of its suite was to be run.
    #[error("nothing of its suite was selected")]
    NotSelected,
    /// A filter, a share of several machines, or an early end left some out.
    #[error("{left_out} of {trials} trials were not run, and part of a suite says nothing about the whole")]
    Part {
        /// Trials that were not run.
        left_out: usize,
        /// Trials that the suite has.
        trials: usize,
    },
    /// Another gate of the suite, of that name, had failed before all runs were made.
    #[error("gate {0} failed before all runs were made")]
    Ended(String),
    /// A trial that came to nothing: which, and what happened.
    #[error("{0}")]
    Incomplete(String),
    /// The runs that a trial did not need for its own verdict could not be run.
    #[error("{0}")]
    Broken(String),
}

/// Why a gate cannot be judged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Refusal {
    /// Why, in a sentence without a full stop.
    pub message: String,
    /// Every reason not to compare, if there is a baseline.
    pub reasons: Vec<String>,
    /// What to do.
    pub help: String,
}

impl GateReport {
    /// Whether nobody looked at it.
    pub fn skipped(&self) -> bool {
        matches!(self.state, GateState::NotJudged(_))
    }

    /// Whether nobody looked at it though something of its suite was run: it may be that it would have failed.
    pub fn is_open(&self) -> bool {
        matches!(&self.state, GateState::NotJudged(why) if *why != NotJudged::NotSelected)
    }

    /// What its comparisons came to; `None` where nothing was compared, [`Self::standing`] says why.
    pub fn verdict(&self) -> Option<Verdict> {
        match &self.state {
            GateState::Judged(verdict) => Some(verdict.verdict),
            GateState::Refused(_) | GateState::NotJudged(_) => None,
        }
    }

    /// How it stands, for counts and exit codes.
    pub fn standing(&self) -> Standing {
        match &self.state {
            GateState::NotJudged(NotJudged::Broken(_)) => Standing::Errored,
            _ => Standing::of(self.skipped(), self.verdict()),
        }
    }
}

/// What became of a gate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GateVerdict {
    /// As the suite calls it.
    pub gate: String,
    /// Failed where a check regressed, inconclusive where a rule could not have failed and something changed, passed otherwise.
    pub verdict: Verdict,
    /// In the order of rules, metrics and scenarios.
    pub checks: Vec<Check>,
    /// What each rule says; [`Check::rule`] is an index into them.
    #[serde(default)]
    pub rules: Vec<String>,
    /// How many comparisons share the error, because chance plays a part in them.
    pub family: usize,
    /// How many of them are of primary rules, which have half of the error for themselves; the others share the other half.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub primary: usize,
    /// Rules none of whose comparisons could have failed anywhere, whatever had happened.
    pub blind_rules: Vec<String>,
    /// Scenarios in which a rule that sees elsewhere could not have failed, though something changed there.
    pub blind_places: Vec<BlindPlace>,
    /// Metrics that are true or false, about which no rule says anything.
    pub unnamed_flags: Vec<String>,
    /// Metrics that no run on either side has.
    pub without_values: Vec<String>,
    /// Metrics that are not compared, because the base lacks them.
    pub new_metrics: Vec<String>,
    /// Trials that are not compared, because the base lacks them.
    pub new_trials: Vec<String>,
    /// Runs on each side.
    pub runs: usize,
    /// Whether runs of the same key have the same seed on both sides.
    pub same_seeds: bool,
    /// Whether runs of the same key are of the same people on both sides.
    pub same_people: bool,
    /// Every run went exactly as before.
    pub nothing_changed: bool,
    /// What is tested and differs.
    pub changes: Vec<Change>,
    /// Programs under test on either side that do not decide the same each time, a sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nondeterministic: Vec<String>,
    /// Runs of the candidate that ended before all had met, see [`crate::judge::baseline::RecordedTrial::cut_off`]: of those nobody knows
    /// what they would have come to, so that nothing passes for them.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub cut_off: usize,
    /// Of a sequential gate: how it was looked at before all runs were there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub looks: Option<Looks>,
}

impl GateVerdict {
    /// The verdict of its comparisons: failed where one regressed, inconclusive where a rule could not have failed and something changed, or
    /// runs were cut off, and passed otherwise.
    pub fn worked_out(&self) -> Verdict {
        // What came out the same by chance need not do so the next time.
        let certainly_same = self.nothing_changed && self.nondeterministic.is_empty();
        if self.checks.iter().any(|check| check.outcome == CheckOutcome::Regressed) {
            Verdict::Failed
        } else if self.cut_off == 0
            && self.blind_places.is_empty()
            && (self.blind_rules.is_empty() || certainly_same)
        {
            Verdict::Passed
        } else {
            Verdict::Inconclusive
        }
    }
}

/// Looks at a sequential gate along the way.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Looks {
    /// How many there were before all runs were there.
    pub made: usize,
    /// Of how many runs [`GateVerdict::runs`] were there when the last of them left no doubt that something had regressed; `None` where
    /// none did, and all were compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ended_it_of: Option<usize>,
}

impl GateVerdict {
    /// How many checks came out so.
    pub fn count(&self, outcome: CheckOutcome) -> usize {
        self.checks.iter().filter(|check| check.outcome == outcome).count()
    }

    /// Shows what is compared and what was changed in the units that a suite writes them in. A rule that says its tolerance
    /// itself comes first.
    pub fn written_as(mut self, suite: &Suite) -> Self {
        for check in &mut self.checks {
            check.notation = check.notation.or_else(|| suite.notation(&check.label));
        }
        for change in &mut self.changes {
            if let Change::Number { what, notation, .. } = change {
                let written = || suite.scenarios.iter().filter_map(|scenario| scenario.written.get(what));
                *notation = notation.or_else(|| written().find_map(|written| written.notation));
            }
        }
        self
    }
}

/// Something of a tested vehicle that is not what it was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Change {
    /// A number that is another one.
    Number {
        /// Such as `av.controller.braking_distance`.
        what: String,
        /// SI units.
        before: f64,
        /// SI units.
        after: f64,
        /// Of both.
        dimension: Dimension,
        /// The unit that people are shown it in, if that is another one than the SI unit.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        notation: Option<Notation>,
    },
    /// In words, such as `av.controller: yielding -> idm_aeb`.
    Other(String),
}

impl fmt::Display for Change {
    /// Such as `av.controller.braking_distance: 5 m -> 4.75 m`.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number { what, before, after, dimension, notation } => {
                let shown = show_apart(&[*before, *after].map(|value| (value, *dimension, *notation)));
                write!(out, "{what}: {}", shown.join(" -> "))
            }
            Self::Other(text) => text.fmt(out),
        }
    }
}

/// A scenario that a rule does not see.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct BlindPlace {
    /// What the rule says.
    pub rule: String,
    /// The scenario's name.
    pub scenario: String,
    /// Independent pairs of runs there are, and how many it takes.
    pub units: usize,
    /// Pairs that it takes.
    pub needed: usize,
}

/// One metric compared in one place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// Index of the gate's rule.
    pub rule: usize,
    /// The metric's name and label.
    pub metric: Reference<Metric>,
    /// As reports call it, such as `max_deceleration(window=0.5)`.
    pub label: String,
    /// The unit that people are shown its values in, if that is another one than the SI unit, in which they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub notation: Option<Notation>,
    /// What of it is compared.
    pub subject: ComparedSubject,
    /// The scenario, or the trial where `certain`.
    pub place: String,
    /// There is no chance in it: what differs, differs.
    pub certain: bool,
    /// What the comparison shows.
    pub outcome: CheckOutcome,
    /// Pairs of runs that are compared.
    pub runs: usize,
    /// Independent ones among them: runs, or people where there are several.
    pub units: usize,
    /// The mean over the compared runs, or the share of them.
    pub base: f64,
    /// The same of the candidate.
    pub candidate: f64,
    /// Where `candidate - base` lies at the stated confidence; ends may be infinite (`null` in JSON).
    #[serde(with = "json::interval")]
    pub interval: Option<(f64, f64)>,
    /// Of the interval, 0..1.
    pub confidence: f64,
    /// How much worse is tolerated, in the metric's unit or as a share of runs.
    pub tolerance: f64,
    /// Whether larger is worse.
    pub larger_is_worse: bool,
    /// Of "it is not worse by more than the tolerance".
    pub p_value: Option<f64>,
    /// The same corrected for all comparisons of the gate of its kind, and doubled where there are primary ones and others.
    pub adjusted_p_value: Option<f64>,
    /// What it would have caught.
    pub power: Power,
    /// Of several trials the one that got worse by most: over all of them, changes may cancel.
    pub worst_trial: Option<TrialChange>,
    /// The runs that got worse, the worst first; for flags those that flipped.
    pub worse_runs: Vec<ChangedRun>,
    /// The runs that got better, as above.
    pub better_runs: Vec<ChangedRun>,
}

/// What of the metric is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ComparedSubject {
    /// Its mean.
    Mean,
    /// The share of runs with a yes.
    Rate,
    /// The share of runs in which it exists.
    Existence,
    /// The runs with a yes that had a no on the same seed.
    New,
}

/// What a comparison shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CheckOutcome {
    /// No run changed.
    Same,
    /// Shown not to be worse by more than the tolerance.
    Held,
    /// Neither that nor the opposite is shown.
    NotShown,
    /// Shown to be worse by more than the tolerance.
    Regressed,
}

impl CheckOutcome {
    /// Nothing that one has to look at.
    pub fn is_fine(self) -> bool {
        matches!(self, Self::Same | Self::Held)
    }
}

/// A run whose value is not what it was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChangedRun {
    /// The run's key.
    pub key: String,
    /// Its value in the base, SI units; `None` where the metric does not exist.
    pub base: Option<f64>,
    /// Its value in the candidate, SI units; `None` where the metric does not exist.
    pub candidate: Option<f64>,
}

/// What one trial of several came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialChange {
    /// Without the suite's name.
    pub key: String,
    /// The mean over its runs, or the share of them.
    pub base: f64,
    /// The same of the candidate.
    pub candidate: f64,
    /// Negative if it got better.
    pub worse_by: f64,
}

/// What would have been caught, at least four times in five.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Power {
    /// Any change beyond the tolerance: there is no chance in it.
    Everything,
    /// Every run worse by this much, in the metric's unit.
    Shift(f64),
    /// A change for the worse in this share of runs, if none gets better.
    Share(f64),
    /// Nothing at all: so few runs cannot show anything among so many comparisons. `needed` can.
    Blind {
        /// Pairs of runs that it takes.
        needed: usize,
    },
    /// Not known: with other seeds runs get better and worse by chance, too, and how many do has not been seen.
    OtherSeeds,
    /// Not a comparison that can fail.
    None,
}
