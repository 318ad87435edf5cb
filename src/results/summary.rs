//! What the trials of a suite come to in numbers: all that is known of those which are not held one by one.

use serde::{Deserialize, Serialize};

use super::finding::Finding;
use super::skip::Skip;
use super::standing::Standing;
use super::trial::{TrialReport, TrialState};
use super::written_counts::is_zero;
use crate::Verdict;
use scenario::{Criterion, Value};

/// Of a scenario of which more trials were run than this, a table shows only those that did not pass.
pub const MOST_SHOWN: usize = 24;

/// A suite's trials in numbers.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SuiteSummary {
    /// Those that are held, by their places in the suite, counted from 0.
    pub held: Vec<usize>,
    /// Every scenario of which there is a trial, in the order of the suite.
    pub scenarios: Vec<ScenarioSummary>,
}

/// A scenario's trials in numbers: all of them, whether they are held or not.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ScenarioSummary {
    /// Its name.
    pub scenario: String,
    /// How many trials stand how. They are all that there are.
    pub standings: Vec<StandingCount>,
    /// How many runs were made and judged.
    pub runs: usize,
    /// Of them, those that the horizon ended.
    pub cut_off: usize,
    /// Trials with criteria that passed without being put to the test.
    pub untested: usize,
    /// Trials in which a vehicle left its carriageway, and no criterion is about that.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub left_road: usize,
    /// Criteria with a confidence that were judged, in all trials.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub claims: usize,
    /// The names of what varies, known once a trial was run.
    pub varied: Vec<String>,
    /// The criteria of the trials that were run: each list that there is, with the first trial that has it.
    pub criteria: Vec<AppliedCriteria>,
    /// Of each criterion the run that came nearest to speaking against it.
    pub nearest: Vec<NearestRun>,
    /// Trials that were judged, passed and are not held, in the order of the suite; only where some trial of the scenario did
    /// not pass, to tell by what it differs from them.
    pub passed: Vec<PassedTrial>,
}

/// How many trials stand so.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StandingCount {
    /// How they stand.
    pub standing: Standing,
    /// Why they were skipped, if they were.
    pub skip: Option<Skip>,
    /// How many there are.
    pub trials: usize,
}

/// Criteria that apply to one and the same trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AppliedCriteria {
    /// The first trial that has them, by its place in the suite; their bounds are its own.
    pub first: usize,
    /// In the order in which they are declared.
    pub criteria: Vec<Criterion>,
}

/// The run that came nearest to speaking against a criterion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NearestRun {
    /// In canonical words.
    pub criterion: String,
    /// Where the criterion is found first: the trial's place in the suite, and the finding's in the trial.
    pub first: (usize, usize),
    /// The finding that names it, and where that is; `None` where a run of some trial speaks against the criterion, or has no
    /// distance from that.
    pub finding: Option<((usize, usize), Box<Finding>)>,
}

/// A trial of which no more is known than that it passed, and with what.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PassedTrial {
    /// Its place in the suite.
    pub place: usize,
    /// The index of its criteria among those of the scenario.
    pub criteria: u32,
    /// The label and the value of each of what varies.
    pub values: Box<[(Box<str>, Value)]>,
}

impl SuiteSummary {
    /// Of trials that are all held.
    pub fn of(trials: &[TrialReport]) -> Self {
        let mut scenarios: Vec<ScenarioSummary> = Vec::new();
        for (place, trial) in trials.iter().enumerate() {
            let name = trial.trial.scenario.as_str();
            // From the end: trials of a scenario stand together.
            let known = scenarios.iter().rposition(|known| known.scenario == name);
            let index = known.unwrap_or_else(|| {
                scenarios.push(ScenarioSummary::new(name));
                scenarios.len() - 1
            });
            scenarios[index].add(place, trial);
        }
        Self { held: (0..trials.len()).collect(), scenarios }
    }

    /// How every trial stands, and why those were skipped that were.
    pub fn standings(&self) -> impl Iterator<Item = &StandingCount> {
        self.scenarios.iter().flat_map(|scenario| &scenario.standings)
    }

    /// How many trials were begun.
    pub fn ran(&self) -> usize {
        self.scenarios.iter().map(ScenarioSummary::ran).sum()
    }

    /// How many runs were made and judged.
    pub fn runs(&self) -> usize {
        self.scenarios.iter().map(|scenario| scenario.runs).sum()
    }

    /// In how many trials criteria passed without being put to the test.
    pub fn untested(&self) -> usize {
        self.scenarios.iter().map(|scenario| scenario.untested).sum()
    }
}

impl ScenarioSummary {
    /// Without any trials.
    pub fn new(scenario: &str) -> Self {
        Self { scenario: scenario.to_string(), ..Self::default() }
    }

    /// Adds a trial, which has this place in the suite; in what order they come makes no difference. Gives the index of its
    /// criteria if it was begun.
    pub fn add(&mut self, place: usize, trial: &TrialReport) -> Option<usize> {
        self.count(trial.standing(), trial.skip(), 1);
        if trial.skipped() {
            return None;
        }
        self.runs += trial.made();
        if self.varied.is_empty() {
            self.varied = trial.trial.variation.iter().map(|one| one.name.clone()).collect();
        }
        if let TrialState::Judged(judged) = &trial.state {
            self.cut_off += judged.horizon.as_ref().map_or(0, |horizon| horizon.runs);
            self.claims += judged.findings.iter().filter(|finding| finding.confidence.is_some()).count();
            self.untested += usize::from(judged.is_untested());
            self.left_road += usize::from(!judged.left_road.is_empty());
            for (index, finding) in judged.findings.iter().enumerate() {
                self.nearest((place, index), finding);
            }
        }
        Some(self.applied(place, &trial.trial.criteria))
    }

    /// So many trials more stand so.
    pub fn count(&mut self, standing: Standing, skip: Option<&Skip>, trials: usize) {
        let known =
            self.standings.iter_mut().find(|known| known.standing == standing && known.skip.as_ref() == skip);
        match known {
            Some(known) => known.trials += trials,
            None if trials > 0 => {
                self.standings.push(StandingCount { standing, skip: skip.cloned(), trials });
            }
            None => {}
        }
    }

    fn applied(&mut self, place: usize, criteria: &[Criterion]) -> usize {
        let same = |known: &Criterion, new: &Criterion| {
            known.text == new.text && known.claim.metric() == new.claim.metric()
        };
        let known = self.criteria.iter().position(|known| {
            known.criteria.len() == criteria.len()
                && known.criteria.iter().zip(criteria).all(|(known, new)| same(known, new))
        });
        let Some(index) = known else {
            self.criteria.push(AppliedCriteria { first: place, criteria: criteria.to_vec() });
            return self.criteria.len() - 1;
        };
        let known = &mut self.criteria[index];
        if place < known.first {
            *known = AppliedCriteria { first: place, criteria: criteria.to_vec() };
        }
        index
    }

    fn nearest(&mut self, place: (usize, usize), finding: &Finding) {
        let new = finding.closest.is_some().then_some((place, finding));
        let Some(known) = self.nearest.iter_mut().find(|known| known.criterion == finding.criterion) else {
            let finding_of = new.map(|(place, finding)| (place, Box::new(finding.clone())));
            let criterion = finding.criterion.clone();
            self.nearest.push(NearestRun { criterion, first: place, finding: finding_of });
            return;
        };
        known.first = known.first.min(place);
        known.finding = match (known.finding.take(), new) {
            (Some((at, old)), Some((place, new))) if nearer((place, new), (at, &old)) => {
                Some((place, Box::new(new.clone())))
            }
            (known, Some(_)) => known,
            (_, None) => None,
        };
    }

    /// How many trials there are.
    pub fn trials(&self) -> usize {
        self.standings.iter().map(|one| one.trials).sum()
    }

    /// How many trials were begun.
    pub fn ran(&self) -> usize {
        self.standings.iter().filter(|one| one.standing != Standing::Skipped).map(|one| one.trials).sum()
    }

    /// How many trials stand so.
    pub fn standing(&self, standing: Standing) -> usize {
        self.standings.iter().filter(|one| one.standing == standing).map(|one| one.trials).sum()
    }

    /// Whether some trial was judged and did not pass.
    pub fn has_not_passed(&self) -> bool {
        let not_passed = |one: &StandingCount| matches!(one.standing, Standing::Judged(verdict) if verdict != Verdict::Passed);
        self.standings.iter().any(not_passed)
    }
}

impl NearestRun {
    /// Of the trials of both.
    pub fn join(&mut self, other: Self) {
        self.first = self.first.min(other.first);
        self.finding = match (self.finding.take(), other.finding) {
            (Some((at, old)), Some((place, new))) if nearer((place, &new), (at, &old)) => Some((place, new)),
            (known, Some(_)) => known,
            (_, None) => None,
        };
    }
}

/// Whether the first finding's run is nearer to speaking against its criterion than the second's; of equals, that which comes first.
fn nearer(new: ((usize, usize), &Finding), known: ((usize, usize), &Finding)) -> bool {
    let margin =
        |finding: &Finding| finding.closest.as_ref().and_then(|run| run.margin).unwrap_or(f64::INFINITY);
    let (left, right) = (margin(new.1), margin(known.1));
    left < right || left == right && new.0 < known.0
}
