//! Candidates in the conditions in which people were observed, run by run.

use std::sync::Arc;

use super::super::context::Context;
use super::super::error::ExperimentError;
use super::candidates::{WeighedCandidates, weighed};
use super::record::{HeldRecord, HeldRuns};
use crate::plan;
use crate::run::MeasuredMetrics;
use numbers::random::derive_seed;
use results::Outcome;
use results::judge::Seen;
use scenario::{
    Assignment, Calibrate, Case, Comparison, Individual, MatchedRate, ObservedRow, Scenario, WhenUndefined,
};

/// Candidates of a round, after which they are written into the journal.
const AT_ONCE: usize = 20;

/// A condition that people were observed in.
pub struct ObservedCondition<'a> {
    pub scenario: Scenario,
    /// The pedestrian that the candidates are.
    who: String,
    variation: Vec<Assignment>,
    pub row: &'a ObservedRow,
    /// The place among the rates of the block.
    pub rate: usize,
    /// Which runs say it: several rates may be observed in the same ones.
    place: usize,
}

impl ObservedCondition<'_> {
    pub fn label(&self) -> String {
        let values = self.variation.iter().map(|one| format!("{}={}", one.name, one.label));
        values.collect::<Vec<_>>().join("/")
    }
}

/// Why nothing was calibrated.
pub fn failed(reason: String, hint: Option<&str>) -> ExperimentError {
    ExperimentError::Calibration { reason, hint: hint.map(str::to_string) }
}

/// The conditions that people were observed in: of every rate in the order of the scenarios and of what they vary.
pub fn conditions<'a>(
    context: &Context,
    block: &'a Calibrate,
) -> Result<Vec<ObservedCondition<'a>>, ExperimentError> {
    let mut found = Vec::new();
    for name in &block.scenarios {
        let mut scenario = context.scenario(name)?.clone();
        let nobody = || failed(format!("nobody of `{name}` takes individuals"), None);
        let who = weighed(&scenario).ok_or_else(nobody)?.name.clone();
        for person in &mut scenario.pedestrians {
            if person.name == who {
                person.individuals = None;
            }
        }
        for variation in plan::combinations(context.suite.seed, &scenario, plan::Variables::new())? {
            let of = |row: &ObservedRow| {
                row.scenario == *name && variation.iter().all(|one| row.is_at(&one.name, &one.label))
            };
            let rates = block.rates.iter().enumerate();
            let rows = rates.flat_map(|(rate, one)| one.observations.rows.iter().map(move |row| (rate, row)));
            let place = found.last().map_or(0, |one: &ObservedCondition| one.place + 1);
            for (rate, row) in rows.filter(|(_, row)| of(row)) {
                found.push(ObservedCondition {
                    scenario: scenario.clone(),
                    who: who.clone(),
                    variation: variation.clone(),
                    row,
                    rate,
                    place,
                });
            }
        }
    }
    if found.len() != block.conditions() {
        let reason = format!("{} of {} rows are about a condition", found.len(), block.conditions());
        return Err(failed(reason, Some("every row names a scenario and values of what it varies")));
    }
    found.sort_by_key(|one| one.rate);
    Ok(found)
}

/// Candidates in conditions.
#[derive(Clone)]
pub struct CandidateTrial<'a> {
    pub context: &'a Context<'a>,
    pub block: &'a Calibrate,
    pub conditions: &'a [ObservedCondition<'a>],
    pub candidates: &'a WeighedCandidates,
    /// What they are called beside their number.
    pub called: &'a str,
    /// Of each in every condition.
    pub runs: u32,
    /// What is matched and, if that is said, by what runs count: nothing else is asked of these runs.
    pub measured: Arc<MeasuredMetrics>,
    pub seed: u64,
}

impl CandidateTrial<'_> {
    /// What these candidates do in every condition, in their order; `progress` is told how many are done.
    pub fn make(
        &self,
        record: &mut HeldRecord,
        pass: u32,
        who: &[usize],
        progress: impl Fn(usize),
    ) -> Result<Vec<Vec<HeldRuns>>, ExperimentError> {
        let unknown: Vec<usize> =
            who.iter().copied().filter(|one| record.known(pass, *one).is_none()).collect();
        let known = who.len() - unknown.len();
        let places = self.places();
        for (round, some) in unknown.chunks(AT_ONCE).enumerate() {
            progress(known + round * AT_ONCE);
            let mut cases = Vec::new();
            for candidate in some {
                for condition in &places {
                    cases.extend(self.cases(pass, *candidate, condition)?);
                }
            }
            // The first run of the block is made twice.
            let number = usize::from(pass > 0 || round > 0 || known > 0);
            let outcomes = self.context.run_reading(&self.measured, number, &cases)?;
            let runs = self.runs as usize;
            for (candidate, outcomes) in some.iter().zip(outcomes.chunks(places.len() * runs)) {
                let of = |one: &ObservedCondition| self.done(one, &outcomes[one.place * runs..][..runs]);
                let done = self.conditions.iter().map(of).collect();
                let written = record.add(pass, *candidate, done);
                written.map_err(|error| failed(format!("its journal: {error}"), None))?;
            }
        }
        progress(who.len());
        let known = |one: &usize| record.known(pass, *one).cloned().unwrap_or_default();
        Ok(who.iter().map(known).collect())
    }

    /// A condition of every place, in their order.
    fn places(&self) -> Vec<&ObservedCondition<'_>> {
        let mut places: Vec<_> = self.conditions.iter().collect();
        places.sort_by_key(|one| one.place);
        places.dedup_by_key(|one| one.place);
        places
    }

    /// The runs of a candidate in a condition.
    fn cases(
        &self,
        pass: u32,
        candidate: usize,
        condition: &ObservedCondition,
    ) -> Result<Vec<Case>, ExperimentError> {
        let person = Individual {
            pedestrian: condition.who.clone(),
            population: self.called.to_string(),
            number: candidate as u32 + 1,
            parameters: self.candidates.settings(candidate),
        };
        let (suite, block) = (self.context.suite.key_name(), &self.block.name);
        let key = format!(
            "{suite}/calibrate={block}/{}/{}/{}={}{}",
            condition.scenario.name,
            condition.label(),
            if pass > 1 { "individual" } else { "candidate" },
            candidate + 1,
            if pass == 1 { "/fresh" } else { "" }
        );
        let noise = self.candidates.noise(candidate);
        let seed = |run: u32| {
            let (scenario, label) = (&condition.scenario.name, condition.label());
            derive_seed(self.seed, &format!("{scenario}/{label}/{noise}/{pass}/{run}"))
        };
        if condition.scenario.is_drawn() {
            // Every run draws what the candidate does not bring.
            let drawn = |run: u32| {
                let (key, variation) = (format!("{key}/rep={run}"), condition.variation.clone());
                plan::concrete_case(&condition.scenario, key, variation, vec![person.clone()], run, seed(run))
            };
            return Ok((1..=self.runs).map(drawn).collect::<Result<_, _>>()?);
        }
        let first = plan::concrete_case(
            &condition.scenario,
            key.clone(),
            condition.variation.clone(),
            vec![person],
            1,
            0,
        )?;
        let case = |run: u32| Case {
            key: format!("{key}/rep={run}"),
            repetition: run,
            seed: seed(run),
            ..first.clone()
        };
        Ok((1..=self.runs).map(case).collect())
    }

    fn rate(&self, condition: &ObservedCondition) -> &MatchedRate {
        &self.block.rates[condition.rate]
    }

    /// What the runs of a candidate in a condition say.
    fn done(&self, condition: &ObservedCondition, outcomes: &[Outcome]) -> HeldRuns {
        let MatchedRate { condition, only_defined, counted_where, .. } = self.rate(condition);
        let index = |counts: &Comparison| self.measured.requests.index(&counts.metric);
        let place = index(condition).expect("every rate is asked of these runs");
        let counted_where = counted_where.as_ref().and_then(|counts| Some((counts, index(counts)?)));
        let mut done = HeldRuns::default();
        for outcome in outcomes {
            if let Some((counts, index)) = counted_where {
                let seen = Seen::of(outcome, index);
                let (at_least, at_most) = (seen.holds(counts, false), seen.holds(counts, true));
                if !at_least {
                    done.not_counted += 1;
                    done.unknown += u32::from(at_most);
                    continue;
                }
            }
            let seen = Seen::of(outcome, place);
            match seen {
                Seen::Value(_) => done.held += u32::from(seen.holds(condition, false)),
                Seen::Undefined | Seen::Open { .. } if *only_defined => {
                    done.undefined += 1;
                    done.not_counted += 1;
                    done.unknown += u32::from(seen.is_open());
                }
                Seen::Undefined | Seen::Open { .. } => {
                    done.undefined += 1;
                    done.held += u32::from(condition.when_undefined == WhenUndefined::Passes);
                }
            }
        }
        done
    }

    /// An error where runs say nothing and the block does not say what those are, and where nobody knows whether runs count.
    pub fn is_known(&self, done: &[Vec<HeldRuns>]) -> Result<(), ExperimentError> {
        let all = done.len() as u64 * u64::from(self.runs);
        for (index, condition) in self.conditions.iter().enumerate() {
            let sum = |of: &dyn Fn(&HeldRuns) -> u32| -> u64 {
                done.iter().map(|row| u64::from(of(&row[index]))).sum()
            };
            let rate = self.rate(condition);
            let is_said = rate.only_defined || rate.condition.when_undefined != WhenUndefined::AsDeclared;
            let (place, text) = (condition.row.in_words(), &rate.text);
            let unknown = sum(&|one| one.unknown);
            if unknown > 0 {
                let reason = format!(
                    "in {unknown} of {all} runs of {place} nobody knows whether they count for `{text}`: \
                     they were cut off by the horizon, or what they count by is undefined"
                );
                let hint = "give the scenario a longer `horizon`, or count by a metric that every run has";
                return Err(failed(reason, Some(hint)));
            }
            let undefined = sum(&|one| one.undefined);
            if undefined > 0 && !is_said {
                let reason = format!(
                    "in {undefined} of {all} runs of {place} `{text}` is undefined or was cut off, and nothing says what that is"
                );
                let hint = "say `undefined fails` behind the file, or give the scenario a longer `horizon`";
                return Err(failed(reason, Some(hint)));
            }
        }
        Ok(())
    }

    /// An error where in some condition no run counts, so that any weights would do. The runs are called `what`.
    pub fn somebody_is_there(&self, done: &[Vec<HeldRuns>], what: &str) -> Result<(), ExperimentError> {
        for (index, condition) in self.conditions.iter().enumerate() {
            if done.iter().all(|row| row[index].not_counted == self.runs) {
                let (place, text) = (condition.row.in_words(), &self.rate(condition).text);
                let reason = format!("no {what} of {place} counts for `{text}`: nobody was left to do it");
                let hint = "take candidates of whom some are still there, or more runs, or leave the row out";
                return Err(failed(reason, Some(hint)));
            }
        }
        Ok(())
    }

    /// In how many runs of each candidate it can be said whether it held, a number for each condition; no rows where all runs count.
    pub fn defined(&self, done: &[Vec<HeldRuns>]) -> Vec<Vec<u32>> {
        if !self.block.rates.iter().any(MatchedRate::counts_some) {
            return Vec::new();
        }
        done.iter().map(|row| row.iter().map(|one| self.runs - one.not_counted).collect()).collect()
    }
}
