//! `calibrate`: candidates are put into the conditions in which people were observed, and weighed until they do what people did.
//!
//! Weights come from one half of the runs; how good they are is said of the other half, whose noise no weight has seen.

mod candidates;
mod compared;
mod observed;
mod record;
mod weigh;

use super::context::{BlockProgress, Context};
use super::error::ExperimentError;
use crate::plan;
use crate::run::MeasuredMetrics;
use candidates::{WeighedCandidates, weighed};
use compared::{ComparedPeople, compare};
use numbers::inference::effective_size;
use numbers::random::derive_seed;
use observed::Observed;
use record::{HeldRecord, HeldRuns};
use results::judge::Seen;
use results::{CalibrateResult, CalibratedCondition, CalibratedShare, Outcome, Requests};
use scenario::{Assignment, Calibrate, Case, Individual, ObservedRow, Scenario, WhenUndefined};
use std::sync::Arc;
use weigh::{Features, Weighing, mean, percent, rms};

/// WeighedCandidates of a round, after which they are written into the journal.
const AT_ONCE: usize = 20;
/// Fresh noise is for candidates of as much weight together; the others change nothing that could be seen.
const FRESH_WEIGHT: f64 = 0.99;
/// Below, a few candidates decide everything.
const LEAST_EFFECTIVE: f64 = 50.0;
/// More runs that cannot be judged than this are told.
const MOST_UNDEFINED: f64 = 0.05;

/// A condition that people were observed in.
struct Condition<'a> {
    scenario: Scenario,
    /// The pedestrian that the candidates are.
    who: String,
    variation: Vec<Assignment>,
    row: &'a ObservedRow,
}

impl Condition<'_> {
    fn label(&self) -> String {
        let values = self.variation.iter().map(|one| format!("{}={}", one.name, one.label));
        values.collect::<Vec<_>>().join("/")
    }
}

/// Weighs the candidates of a calibration.
///
/// # Errors
/// Where candidates cannot be had or run, where runs say nothing and the block does not say what that means, and where no mixture does
/// what people did.
pub fn run_calibrate(
    context: &Context,
    block: &Calibrate,
    progress: &dyn BlockProgress,
) -> Result<CalibrateResult, ExperimentError> {
    let seed = derive_seed(context.suite.seed, &format!("calibrate/{}", block.name));
    let conditions = conditions(context, block)?;
    let candidates = WeighedCandidates::of(block, context.scenario(&block.scenarios[0])?, seed)?;
    let scenarios: Vec<&Scenario> = conditions.iter().map(|one| &one.scenario).collect();
    let inputs = (block, seed, &candidates.names, &candidates.rows, &candidates.variant, scenarios);
    let mut record = HeldRecord::open(context.journals.as_deref(), &block.name, &inputs, conditions.len())
        .map_err(|error| failed(format!("its journal: {error}"), None))?;
    context.tell(record.notice.as_deref());

    let called = format!("candidates of {}", block.name);
    let mut requests = Requests::default();
    requests.add(&block.condition.metric);
    let trial = Trial {
        context,
        block,
        conditions: &conditions,
        candidates: &candidates,
        called: &called,
        runs: block.runs,
        measured: MeasuredMetrics::new(requests),
        seed,
    };
    let others = ComparedPeople::of(&trial)?;
    let everybody: Vec<usize> = (0..candidates.rows.len()).collect();
    let all = everybody.len();
    let whole = 2 * all + others.iter().map(ComparedPeople::len).sum::<usize>();
    let done = trial.make(&mut record, 0, &everybody, |count| progress.evaluated(count, whole, None))?;
    let features = Features::predicted(&done, block.runs, &candidates);
    let rows: Vec<&ObservedRow> = conditions.iter().map(|one| one.row).collect();
    let observed: Vec<Observed> = rows.iter().map(|row| Observed::of(row)).collect();
    let weighing = Weighing {
        features: &features,
        observed: &observed,
        rows: &rows,
        spread: block.spread,
        within: block.within,
    };
    let undefined = trial.undefined(&done)?;
    let missed = weighing.out_of_reach();
    if !missed.is_empty() {
        let hint = "take candidates over other ranges, or conditions that these people can be in";
        return Err(failed(
            format!("no mixture of the candidates does what people did: {}", missed.join("; ")),
            Some(hint),
        ));
    }
    let weights = rounded(&weighing.weights().weights);

    // Those of no weight are not asked again.
    let mut heaviest = everybody.clone();
    heaviest.sort_by(|one, other| weights[*other].total_cmp(&weights[*one]).then(one.cmp(other)));
    let mut sum = 0.0;
    heaviest.retain(|one| {
        let asked = sum < FRESH_WEIGHT;
        sum += weights[*one];
        asked
    });
    let fresh = trial.make(&mut record, 1, &heaviest, |count| {
        progress.evaluated(if count == heaviest.len() { 2 * all } else { all + count }, whole, None);
    })?;
    let compared =
        compare(&others, &trial, &mut record, |count| progress.evaluated(2 * all + count, whole, None))?;
    let fresh = Features::counted(&fresh, block.runs);
    let heavy: Vec<f64> = heaviest.iter().map(|one| weights[*one]).collect();
    let heavy_sum: f64 = heavy.iter().sum();
    let heavy: Vec<f64> = heavy.iter().map(|one| one / heavy_sum).collect();

    let left_out = weighing.left_out();
    let equal = vec![1.0 / all as f64; all];
    let mut found = Vec::new();
    for (index, condition) in conditions.iter().enumerate() {
        let of = |own: &[Vec<f64>], fresh: &[Vec<f64>], target: numbers::inference::WeightTarget| {
            CalibratedShare {
                observed: target.value,
                error: target.error,
                equal: mean(own, &equal, index),
                fitted: mean(own, &weights, index),
                fresh: mean(fresh, &heavy, index),
                left_out: None,
                matched: true,
            }
        };
        let mut share = of(&features.shares, &fresh.shares, observed[index].share);
        let mut spread = of(&features.spreads, &fresh.spreads, observed[index].spread);
        spread.matched = block.spread;
        if let Some(left_out) = &left_out {
            (share.left_out, spread.left_out) = (Some(left_out[index].0), Some(left_out[index].1));
        }
        found.push(CalibratedCondition {
            scenario: condition.scenario.name.clone(),
            values: condition.label(),
            trials: condition.row.trials,
            persons: condition.row.persons,
            undefined: undefined.iter().zip(&weights).map(|(row, weight)| weight * row[index]).sum(),
            share,
            spread,
        });
    }
    let error = |predicted: &dyn Fn(&CalibratedShare) -> Option<f64>| {
        let errors: Option<Vec<f64>> =
            found.iter().map(|one| Some(predicted(&one.share)? - one.share.observed)).collect();
        errors.map(|errors| rms(errors.into_iter()))
    };
    let effective = effective_size(&weights);
    let mut result = CalibrateResult {
        name: block.name.clone(),
        doc: block.doc.clone(),
        matched: block.text.clone(),
        observations: block.observations.file.clone(),
        candidates: candidates.words.clone(),
        model: candidates.model.clone(),
        variant: candidates.variant.clone(),
        parameters: candidates.names.clone(),
        individuals: candidates.rows.clone(),
        digest: String::new(),
        effective_size: effective,
        folds: block.folds,
        folds_rms: weighing.folds(block.folds, seed),
        left_out_rms: error(&|share| share.left_out),
        fresh_rms: error(&|share| Some(share.fresh)).unwrap_or(0.0),
        conditions: found,
        runs: block.runs,
        seed: context.suite.seed,
        vehicle_speeds: vehicle_speeds(&conditions),
        compared,
        resampled: weighing.resampled(seed).iter().map(|weights| rounded(weights)).collect(),
        warnings: Vec::new(),
        weights,
    };
    result.digest = result.population().digest();
    result.warnings = warnings(&result);
    record.remove();
    Ok(result)
}

/// The different speeds (m/s) that vehicles have in the conditions from the start, in rising order.
fn vehicle_speeds(conditions: &[Condition]) -> Vec<f64> {
    let cars = conditions.iter().flat_map(|one| &one.scenario.vehicles);
    let mut speeds: Vec<f64> = cars
        .filter_map(|car| match &car.speed {
            scenario::Expression::Constant(scenario::Value::Number(speed)) => Some(*speed),
            _ => None,
        })
        .collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    speeds
}

fn warnings(result: &CalibrateResult) -> Vec<String> {
    let mut warnings = Vec::new();
    if result.effective_size < LEAST_EFFECTIVE {
        warnings.push(format!(
            "the effective size is {:.0}: a few candidates decide everything; take more of them",
            result.effective_size
        ));
    }
    for one in result.conditions.iter().filter(|one| one.undefined > MOST_UNDEFINED) {
        warnings.push(format!(
            "in {} of the runs of {} {} `{}` is undefined or was cut off, and counts as the block says",
            percent(one.undefined),
            one.scenario,
            one.values,
            result.matched
        ));
    }
    for one in &result.conditions {
        for (what, share) in [("share", &one.share), ("spread", &one.spread)] {
            let apart = (share.fresh - share.observed) / share.error;
            if apart.abs() > 2.0 {
                warnings.push(format!(
                    "the {what} of {} {} is {} under fresh noise where people have {} ± {}{}",
                    one.scenario,
                    one.values,
                    percent(share.fresh),
                    percent(share.observed),
                    percent(share.error),
                    if share.matched { "" } else { ", and was not matched" }
                ));
            }
        }
    }
    if !result.vehicle_speeds.is_empty() {
        let speeds: Vec<String> =
            result.vehicle_speeds.iter().map(|speed| scenario::significant(speed * 3.6, 3)).collect();
        warnings.push(format!(
            "people were observed before vehicles at {} km/h: what they do before others is not known",
            speeds.join(" and ")
        ));
    }
    warnings
}

fn failed(reason: String, hint: Option<&str>) -> ExperimentError {
    ExperimentError::Calibration { reason, hint: hint.map(str::to_string) }
}

/// To eight digits, as files say them, and of sum 1.
fn rounded(weights: &[f64]) -> Vec<f64> {
    let round = |weight: &f64| format!("{weight:.7e}").parse().unwrap_or(*weight);
    weights.iter().map(round).collect()
}

/// The conditions that people were observed in, in the order of the scenarios and of what they vary.
fn conditions<'a>(context: &Context, block: &'a Calibrate) -> Result<Vec<Condition<'a>>, ExperimentError> {
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
            let of = |row: &&ObservedRow| {
                row.scenario == *name && variation.iter().all(|one| row.is_at(&one.name, &one.label))
            };
            if let Some(row) = block.observations.rows.iter().find(of) {
                found.push(Condition { scenario: scenario.clone(), who: who.clone(), variation, row });
            }
        }
    }
    if found.len() != block.observations.rows.len() {
        let reason =
            format!("{} of {} rows are about a condition", found.len(), block.observations.rows.len());
        return Err(failed(reason, Some("every row names a scenario and values of what it varies")));
    }
    Ok(found)
}

/// Candidates in conditions.
#[derive(Clone)]
struct Trial<'a> {
    context: &'a Context<'a>,
    block: &'a Calibrate,
    conditions: &'a [Condition<'a>],
    candidates: &'a WeighedCandidates,
    /// What they are called beside their number.
    called: &'a str,
    /// Of each in every condition.
    runs: u32,
    /// Only what is matched: nothing else is asked of these runs.
    measured: Arc<MeasuredMetrics>,
    seed: u64,
}

impl Trial<'_> {
    /// What these candidates do in every condition, in their order; `progress` is told how many are done.
    fn make(
        &self,
        record: &mut HeldRecord,
        pass: u32,
        who: &[usize],
        progress: impl Fn(usize),
    ) -> Result<Vec<Vec<HeldRuns>>, ExperimentError> {
        let unknown: Vec<usize> =
            who.iter().copied().filter(|one| record.known(pass, *one).is_none()).collect();
        let known = who.len() - unknown.len();
        for (round, some) in unknown.chunks(AT_ONCE).enumerate() {
            progress(known + round * AT_ONCE);
            let mut cases = Vec::new();
            for candidate in some {
                for condition in self.conditions {
                    cases.extend(self.cases(pass, *candidate, condition)?);
                }
            }
            // The first run of the block is made twice.
            let number = usize::from(pass > 0 || round > 0 || known > 0);
            let outcomes = self.context.run_reading(&self.measured, number, &cases)?;
            let of_candidate = self.conditions.len() * self.runs as usize;
            for (candidate, outcomes) in some.iter().zip(outcomes.chunks(of_candidate)) {
                let done = outcomes.chunks(self.runs as usize).map(|some| self.done(some)).collect();
                let written = record.add(pass, *candidate, done);
                written.map_err(|error| failed(format!("its journal: {error}"), None))?;
            }
        }
        progress(who.len());
        let known = |one: &usize| record.known(pass, *one).cloned().unwrap_or_default();
        Ok(who.iter().map(known).collect())
    }

    /// The runs of a candidate in a condition.
    fn cases(
        &self,
        pass: u32,
        candidate: usize,
        condition: &Condition,
    ) -> Result<Vec<Case>, ExperimentError> {
        let person = Individual {
            pedestrian: condition.who.clone(),
            population: self.called.to_string(),
            number: candidate as u32 + 1,
            parameters: self.candidates.settings(candidate),
        };
        let (suite, block) = (&self.context.suite.name, &self.block.name);
        let key = format!(
            "{suite}/calibrate={block}/{}/{}/{}={}{}",
            condition.scenario.name,
            condition.label(),
            if pass > 1 { "individual" } else { "candidate" },
            candidate + 1,
            if pass == 1 { "/fresh" } else { "" }
        );
        let first = plan::concrete_case(
            &condition.scenario,
            key.clone(),
            condition.variation.clone(),
            vec![person],
            1,
            0,
        )?;
        let noise = self.candidates.noise(candidate);
        let case = |run: u32| Case {
            key: format!("{key}/rep={run}"),
            repetition: run,
            seed: derive_seed(
                self.seed,
                &format!("{}/{}/{noise}/{pass}/{run}", condition.scenario.name, condition.label()),
            ),
            ..first.clone()
        };
        Ok((1..=self.runs).map(case).collect())
    }

    fn done(&self, outcomes: &[Outcome]) -> HeldRuns {
        let condition = &self.block.condition;
        let mut done = HeldRuns::default();
        for seen in outcomes.iter().map(|outcome| Seen::of(outcome, 0)) {
            match seen {
                Seen::Value(_) => done.held += u32::from(seen.holds(condition, false)),
                Seen::Undefined | Seen::Open { .. } => {
                    done.undefined += 1;
                    done.held += u32::from(condition.when_undefined == WhenUndefined::Passes);
                }
            }
        }
        done
    }

    /// The share of runs of each candidate in each condition that say nothing; an error where the block does not say what they are.
    fn undefined(&self, done: &[Vec<HeldRuns>]) -> Result<Vec<Vec<f64>>, ExperimentError> {
        let runs = f64::from(self.block.runs);
        if self.block.condition.when_undefined == WhenUndefined::AsDeclared {
            for (index, condition) in self.conditions.iter().enumerate() {
                let count: u64 = done.iter().map(|row| u64::from(row[index].undefined)).sum();
                if count > 0 {
                    let all = done.len() as u64 * u64::from(self.block.runs);
                    let reason = format!(
                        "in {count} of {all} runs of {} `{}` is undefined or was cut off, and nothing says what that is",
                        condition.row.in_words(),
                        self.block.text
                    );
                    return Err(failed(
                        reason,
                        Some(
                            "say `undefined fails` behind the file, or give the scenario a longer `horizon`",
                        ),
                    ));
                }
            }
        }
        Ok(done.iter().map(|row| row.iter().map(|one| f64::from(one.undefined) / runs).collect()).collect())
    }
}
