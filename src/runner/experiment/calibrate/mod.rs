//! `calibrate`: candidates are put into the conditions in which people were observed, and weighed until they do what people did.
//!
//! Weights come from one half of the runs; how good they are is said of the other half, whose noise no weight has seen.

mod candidates;
mod compared;
mod observed;
mod parameters;
mod record;
mod trial;
mod weigh;

use super::context::{BlockProgress, Context};
use super::error::ExperimentError;
use crate::run::MeasuredMetrics;
use candidates::WeighedCandidates;
use compared::{ComparedPeople, compare};
use numbers::inference::{WeightTarget, effective_size};
use numbers::random::derive_seed;
use observed::Observed;
use parameters::BoundedParameters;
use record::{HeldRecord, HeldRuns};
use results::{CalibrateResult, CalibratedCondition, CalibratedShare, CountedRuns, Requests};
use scenario::{Calibrate, MatchedRate, ObservedRow};
use trial::{CandidateTrial, ObservedCondition, conditions, failed};
use weigh::{Features, RESAMPLED, Weighing, percent, rms};

/// Fresh noise is for candidates of as much weight together; the others change nothing that could be seen.
const FRESH_WEIGHT: f64 = 0.99;
/// Below, a few candidates decide everything.
const LEAST_EFFECTIVE: f64 = 50.0;
/// More runs that cannot be judged than this are told.
const MOST_UNDEFINED: f64 = 0.05;

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
    let parameters = BoundedParameters::of(block, &candidates)?;
    // What decides what candidates do; how they are weighed can be said otherwise, and the same runs go on being known.
    let rate = |one: &MatchedRate| (one.condition.clone(), one.only_defined, one.counted_where.clone());
    let rates: Vec<_> = block.rates.iter().map(rate).collect();
    let asked = (rates, block.runs, &block.compared, seed);
    let people = (&candidates.names, &candidates.rows, &candidates.variant);
    let places: Vec<_> = conditions.iter().map(|one| (one.rate, &one.scenario, one.label())).collect();
    let inputs = (asked, people, places);
    let mut record = HeldRecord::open(context.journals.as_deref(), &block.name, &inputs, conditions.len())
        .map_err(|error| failed(format!("its journal: {error}"), None))?;
    context.tell(record.notice.as_deref());

    let called = format!("candidates of {}", block.name);
    let mut requests = Requests::default();
    block.rates.iter().flat_map(MatchedRate::metrics).for_each(|metric| requests.add(metric));
    let trial = CandidateTrial {
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
    trial.is_known(&done)?;
    trial.somebody_is_there(&done, "run of any candidate")?;
    let features = Features::predicted(&done, &trial.defined(&done), block.runs, &candidates);
    let rows: Vec<&ObservedRow> = conditions.iter().map(|one| one.row).collect();
    let observed: Vec<Observed> = rows.iter().map(|row| Observed::of(row)).collect();
    let spread_within: Vec<Option<f64>> =
        conditions.iter().map(|one| block.rates[one.rate].spread_within).collect();
    let weighing = Weighing {
        features: &features,
        observed: &observed,
        rows: &rows,
        parameters: &parameters,
        within: block.within,
        spread_within: &spread_within,
    };
    let missed = weighing.out_of_reach();
    if !missed.is_empty() {
        let hint = "take candidates over other ranges, or conditions that these people can be in";
        return Err(failed(
            format!("no mixture of the candidates does what people did: {}", missed.join("; ")),
            Some(hint),
        ));
    }
    let not_found = || {
        let reason = "no weights were found by which runs that count do what people did".to_string();
        failed(reason, Some("take more candidates, or conditions in which more of them are still there"))
    };
    let weights = rounded(&weighing.weights().ok_or_else(not_found)?.weights);
    if parameters.missed(&weights).next().is_some() {
        let reason = "no weights were found by which parameters are distributed as is matched".to_string();
        return Err(failed(reason, Some("take more candidates, or a wider `within`")));
    }

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
    trial.is_known(&fresh)?;
    trial.somebody_is_there(&fresh, "fresh run of candidates with weight")?;
    let fresh_defined = trial.defined(&fresh);
    let fresh = Features::counted(&fresh, &fresh_defined, block.runs);
    let heavy: Vec<f64> = heaviest.iter().map(|one| weights[*one]).collect();
    let heavy_sum: f64 = heavy.iter().sum();
    let heavy: Vec<f64> = heavy.iter().map(|one| one / heavy_sum).collect();

    let left_out = weighing.left_out();
    let equal = vec![1.0 / all as f64; all];
    let share_of_runs = |of: &dyn Fn(&HeldRuns) -> u32, index: usize| -> f64 {
        let share = |row: &Vec<HeldRuns>| f64::from(of(&row[index])) / f64::from(block.runs);
        done.iter().zip(&weights).map(|(row, weight)| weight * share(row)).sum()
    };
    let several = block.rates.iter().any(|rate| rate.text != block.rates[0].text);
    let mut found = Vec::new();
    for (index, condition) in conditions.iter().enumerate() {
        type Of = fn(&Features, &[f64], usize) -> Option<f64>;
        let of = |of: Of, target: WeightTarget| {
            Some(CalibratedShare {
                observed: target.value,
                error: target.error,
                // Predictions are linear, and may lie a little beyond what is possible.
                equal: of(&features, &equal, index)?.clamp(0.0, 1.0),
                fitted: of(&features, &weights, index)?.clamp(0.0, 1.0),
                fresh: of(&fresh, &heavy, index)?,
                left_out: None,
                matched: true,
            })
        };
        let nobody = |what: &str| {
            let place = condition.row.in_words();
            let reason = format!("too few runs of {place} count to tell {what} that was matched");
            failed(reason, Some("take more runs, or candidates of whom more are still there"))
        };
        let mut share = of(Features::share, observed[index].share).ok_or_else(|| nobody("the share"))?;
        let mut spread = observed[index].spread.and_then(|target| of(Features::spread, target));
        if spread_within[index].is_some() && observed[index].spread.is_some() && spread.is_none() {
            return Err(nobody("the spread between individuals"));
        }
        if let Some(left_out) = &left_out {
            share.left_out = left_out[index].0.map(|share| share.clamp(0.0, 1.0));
        }
        if let Some(spread) = &mut spread {
            spread.matched = spread_within[index].is_some();
            spread.left_out =
                left_out.as_ref().and_then(|left_out| left_out[index].1).map(|share| share.clamp(0.0, 1.0));
        }
        let counted = |condition: &ObservedCondition| {
            let some = block.rates[condition.rate].counts_some();
            rests_on(&fresh_defined, &heavy, index).filter(|_| some)
        };
        found.push(CalibratedCondition {
            scenario: condition.scenario.name.clone(),
            values: condition.label(),
            rate: several.then(|| block.rates[condition.rate].text.clone()),
            trials: condition.row.trials,
            persons: condition.row.persons,
            undefined: share_of_runs(&|one| one.undefined, index),
            counted: counted(condition).map(|(runs, candidates)| CountedRuns {
                share: (1.0 - share_of_runs(&|one| one.not_counted, index)).clamp(0.0, 1.0),
                runs,
                candidates,
            }),
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
        matched: joined(block, |rate| &rate.text),
        observations: joined(block, |rate| &rate.observations.file),
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
        matched_parameters: parameters.found(block, &weights),
        runs: block.runs,
        seed: context.suite.seed,
        vehicle_speeds: vehicle_speeds(&conditions),
        compared,
        resampled: weighing.resampled(seed).iter().map(|weights| rounded(weights)).collect(),
        warnings: Vec::new(),
        weights,
    };
    result.digest = result.population().digest();
    let only_defined: Vec<bool> = conditions.iter().map(|one| block.rates[one.rate].only_defined).collect();
    result.warnings = warnings(&result, &only_defined);
    record.remove();
    Ok(result)
}

/// On how many runs of equal weight a condition rests where not all of them count, and of how many candidates (Kish 1965); `None` where all
/// count.
fn rests_on(defined: &[Vec<u32>], weights: &[f64], condition: usize) -> Option<(f64, f64)> {
    let (mut all, mut runs, mut candidates) = (0.0, 0.0, 0.0);
    for (row, weight) in defined.iter().zip(weights) {
        let own = weight * f64::from(row[condition]);
        all += own;
        runs += weight * own;
        candidates += own * own;
    }
    (candidates > 0.0).then(|| (all * all / runs, all * all / candidates))
}

/// The different speeds (m/s) that vehicles have in the conditions from the start, in rising order.
fn vehicle_speeds(conditions: &[ObservedCondition]) -> Vec<f64> {
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

/// Of every rate, joined by words.
fn joined(block: &Calibrate, of: impl Fn(&MatchedRate) -> &String) -> String {
    let mut each: Vec<&str> = block.rates.iter().map(|rate| of(rate).as_str()).collect();
    each.dedup();
    each.join(" and ")
}

/// `only_defined` says of each condition whether undefined runs of it do not count.
fn warnings(result: &CalibrateResult, only_defined: &[bool]) -> Vec<String> {
    let mut warnings = Vec::new();
    if result.effective_size < LEAST_EFFECTIVE {
        warnings.push(format!(
            "the effective size is {:.0}: a few candidates decide everything; take more of them",
            result.effective_size
        ));
    }
    let matched = |one: &CalibratedCondition| one.rate.clone().unwrap_or_else(|| result.matched.clone());
    // Fewer than are weighed at all, by half.
    let few_candidates = result.effective_size.min(LEAST_EFFECTIVE) / 2.0;
    for one in &result.conditions {
        let few =
            |counted: &CountedRuns| counted.runs < LEAST_EFFECTIVE || counted.candidates < few_candidates;
        if let Some(counted) = one.counted.filter(few) {
            warnings.push(format!(
                "the share of {} rests on {:.0} runs of {:.0} candidates of equal weight that count for `{}`, {} of all; take more runs or candidates",
                one.place(),
                counted.runs,
                counted.candidates,
                matched(one),
                percent(counted.share)
            ));
        }
    }
    if result.resampled.len() < RESAMPLED {
        warnings.push(format!(
            "of {RESAMPLED} drawings of persons anew weights were found for {}",
            result.resampled.len()
        ));
    }
    // Those that do not count are told beside the shares.
    let of_counted =
        |one: &CalibratedCondition| one.undefined / one.counted.map_or(1.0, |counted| counted.share);
    let many = |(one, only_defined): &(&CalibratedCondition, &bool)| {
        !**only_defined && of_counted(one) > MOST_UNDEFINED
    };
    for (one, _) in result.conditions.iter().zip(only_defined).filter(many) {
        warnings.push(format!(
            "in {} of the runs of {} `{}` is undefined or was cut off, and counts as the block says",
            percent(of_counted(one)),
            one.place(),
            matched(one)
        ));
    }
    for one in &result.conditions {
        let spread = one.spread.iter().map(|spread| ("spread", spread));
        for (what, share) in std::iter::once(("share", &one.share)).chain(spread) {
            let apart = (share.fresh - share.observed) / share.error;
            if apart.abs() > 2.0 {
                warnings.push(format!(
                    "the {what} of {} is {} under fresh noise where people have {} ± {}{}",
                    one.in_words(),
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

/// To eight digits, as files say them, and of sum 1.
fn rounded(weights: &[f64]) -> Vec<f64> {
    let round = |weight: &f64| format!("{weight:.7e}").parse().unwrap_or(*weight);
    weights.iter().map(round).collect()
}
