//! All runs of an estimate: what was told of them, what they weigh, and which they were.

use std::borrow::Cow;

use super::scored_run::ScoredEncounter;
use crate::experiment::error::ExperimentError;
use crate::plan::Cases;
use numbers::rare::{
    PairedEvent, PairedRareEstimate, RareEstimate, RareSampling, RareScale, RareSpace, ReplicateRuns,
    WeighedHit, leaving_out,
};
use results::EstimatedRun;

/// Of the interval and the bound that are always said.
pub const CONFIDENCE: f64 = 0.95;
/// Runs that are named.
pub const MOST_RUNS: usize = 10;
/// More runs that were not seen to their end, and nothing is claimed of what they would have come to.
const MOST_CUT_OFF: f64 = 0.5;

/// What was told of encounters.
#[derive(Debug, Default)]
pub struct Told {
    /// Which of two had the event, by the numbers of their runs.
    events: Vec<PairedEvent>,
    /// Which runs of both were not seen to their end, by the same numbers.
    not_seen: Vec<[bool; 2]>,
    /// The numbers of those that there are not, in order.
    pub left_out: Vec<usize>,
    pub pilot: usize,
    pub undecided: usize,
    pub cut_off: usize,
    pub undecided_others: usize,
    pub cut_off_others: usize,
    /// Runs in which anything was at stake.
    pub met: usize,
    pub met_others: usize,
}

impl Told {
    pub fn add(&mut self, is_pilot: bool, seen: &[ScoredEncounter]) {
        let first = self.encounters();
        let left_out = seen.iter().enumerate().filter(|(_, one)| one.own.left_out);
        self.left_out.extend(left_out.map(|(index, _)| first + index));
        self.events.extend(seen.iter().map(|one| one.event()));
        let other = |one: &ScoredEncounter| one.other.is_some_and(|other| other.cut_off);
        self.not_seen.extend(seen.iter().map(|one| [one.own.cut_off, other(one)]));
        if is_pilot {
            self.pilot += seen.len();
        } else {
            let others = || seen.iter().filter_map(|one| one.other);
            self.undecided += seen.iter().filter(|one| one.own.undecided).count();
            self.cut_off += seen.iter().filter(|one| one.own.cut_off).count();
            self.undecided_others += others().filter(|one| one.undecided).count();
            self.cut_off_others += others().filter(|one| one.cut_off).count();
            self.met += seen.iter().filter(|one| one.own.encounter).count();
            self.met_others += others().filter(|one| one.encounter).count();
        }
    }

    /// How many there were.
    pub fn encounters(&self) -> usize {
        self.events.len()
    }

    /// Those of them that do more than show where to look, and are left out.
    pub fn left_out_of_counted(&self) -> usize {
        self.left_out.iter().filter(|number| **number >= self.pilot).count()
    }

    /// Those that do more than show where to look, and are not left out.
    pub fn counted(&self) -> usize {
        self.encounters() - self.pilot - self.left_out_of_counted()
    }
}

/// All runs of an estimate.
pub struct Sampled<'a> {
    pub cases: &'a Cases,
    /// Of the scenario that it is compared with, in the same encounters.
    pub others: Option<&'a Cases>,
    pub space: &'a RareSpace,
    pub method: &'a dyn RareSampling,
    pub scale: RareScale,
    pub told: &'a Told,
}

impl Sampled<'_> {
    /// What the replicates say so far of the encounters that there are.
    pub fn replicates(&self) -> Cow<'_, [ReplicateRuns]> {
        match &self.told.left_out[..] {
            [] => self.method.replicates().into(),
            left_out => leaving_out(self.method.replicates(), left_out).into(),
        }
    }

    /// The same of the estimate's own scenario.
    pub fn own_replicates(&self) -> Cow<'_, [ReplicateRuns]> {
        let replicates = self.replicates();
        if self.others.is_none() {
            return replicates;
        }
        replicates.iter().map(|one| one.only(|run| self.had(run).first)).collect()
    }

    /// The estimate of the replicates that there are, and where it lies at 95 %, once there are several.
    pub fn so_far(&self) -> Option<(f64, (f64, f64))> {
        if self.method.replicates().len() < 2 {
            return None;
        }
        let so_far = RareEstimate::of(self.space, &self.own_replicates(), self.scale);
        let interval = so_far.interval(CONFIDENCE);
        Some((so_far.value, (interval.low, interval.high)))
    }

    /// Why nothing that is claimed is shown, whatever the numbers are: most runs of a scenario (0: the estimate's own, 1: the other) were
    /// not seen to their end, of those that count or of those that are drawn as they are. A method makes most where the event is.
    pub fn nothing_seen(&self, which: usize, scenario: &str) -> Option<String> {
        if let Some(why) = self.mostly_left_out() {
            return Some(why);
        }
        let told = self.told;
        let counted = told.pilot..told.encounters();
        let nominal =
            self.method.replicates().iter().map(|one| one.first..one.first + one.nominal_runs as usize);
        let share = |runs: &mut dyn Iterator<Item = usize>| {
            let there_are = runs.filter(|run| told.left_out.binary_search(run).is_err());
            there_are
                .fold((0, 0), |(cut_off, of), run| (cut_off + usize::from(told.not_seen[run][which]), of + 1))
        };
        let kinds = [
            ("", share(&mut counted.into_iter())),
            (" that are drawn as they are", share(&mut nominal.flatten())),
        ];
        let most = kinds.into_iter().find(|(_, (cut_off, of))| *cut_off as f64 > MOST_CUT_OFF * *of as f64);
        most.map(|(kind, (cut_off, of))| {
            format!(
                "{cut_off} of {of} runs of `{scenario}`{kind} ended before the end of what the event is about was seen: raise its `horizon`"
            )
        })
    }

    /// Why nothing that is claimed is shown: in no run of a scenario (as in [`Self::nothing_seen`]) was anything at stake.
    pub fn nothing_met(&self, which: usize, scenario: &str) -> Option<String> {
        let met = if which == 0 { self.told.met } else { self.told.met_others };
        let counted = self.told.counted();
        (met == 0).then(|| {
            format!("none of {counted} runs of `{scenario}` had an encounter: nothing that the event is about was at stake")
        })
    }

    /// Why nothing is claimed where most of the encounters that are drawn as they are are left out: the scenario is of others.
    fn mostly_left_out(&self) -> Option<String> {
        let drawn: u64 = self.method.replicates().iter().map(|one| one.nominal_runs).sum();
        let kept: u64 = self.replicates().iter().map(|one| one.nominal_runs).sum();
        let left_out = drawn - kept;
        (left_out as f64 > MOST_CUT_OFF * drawn as f64).then(|| {
            format!("{left_out} of {drawn} encounters that are drawn as they are are left out: there are none such")
        })
    }

    /// Which of two had the event in the run of that number.
    pub fn had(&self, run: usize) -> PairedEvent {
        self.told.events[run]
    }

    pub fn paired(&self) -> PairedRareEstimate {
        PairedRareEstimate::of(self.space, &self.replicates(), self.scale, |run| self.had(run))
    }
}

/// Hits of replicates, each with what it weighs in their mean.
pub struct Hits<'a> {
    hits: Vec<(&'a WeighedHit, f64)>,
    sum: f64,
}

impl<'a> Hits<'a> {
    /// What the weights are shares of is what all of these weigh.
    pub fn of(replicates: &'a [ReplicateRuns]) -> Self {
        let of = |one: &'a ReplicateRuns| {
            one.hits.iter().map(move |hit| (hit, hit.weight / one.runs as f64)).collect::<Vec<_>>()
        };
        let hits: Vec<_> = replicates.iter().flat_map(of).collect();
        let sum = hits.iter().map(|one| one.1).sum();
        Self { hits, sum }
    }

    /// The indices of those that it holds for by the numbers of their runs, the heaviest first.
    pub fn heaviest(&self, holds: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut found: Vec<usize> =
            (0..self.hits.len()).filter(|index| holds(self.hits[*index].0.run)).collect();
        found.sort_by(|one, other| self.hits[*other].1.total_cmp(&self.hits[*one].1).then(one.cmp(other)));
        found
    }

    pub fn share(&self, index: usize) -> f64 {
        self.hits[index].1 / self.sum
    }

    /// The run that made it, of these cases.
    pub fn run(&self, index: usize, cases: &Cases) -> Result<EstimatedRun, ExperimentError> {
        let hit = self.hits[index].0;
        let case = cases.at(hit.chance, &hit.point)?;
        let drawn = case.drawn.into_iter().map(|one| (one.name, one.label)).collect();
        Ok(EstimatedRun { key: case.key, share: self.share(index), drawn })
    }
}
