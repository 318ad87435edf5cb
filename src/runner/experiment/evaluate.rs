//! `evaluate`: sets of parameters compared on the same cases.

use std::path::Path;

use super::context::{BlockProgress, Context};
use super::earlier::EarlierResults;
use super::error::ExperimentError;
use super::overrides;
use super::parameters::ParameterFile;
use numbers::inference::{paired_difference, rate_change};
use numbers::random::derive_seed;
use numbers::summary::mean;
use results::judge::{Seen, ValueSpan, aggregate, aggregate_against, span_of, undecided};
use results::{ConditionResult, Difference, EvaluateResult, Outcome, ParameterValue, Requests, SavedCase};
use scenario::{
    Aggregate, Case, Comparison, Condition, Evaluate, Measure, MetricKind, MetricReference, Notation,
    ParameterSet, Relation, Target, Value, WhenUndefined, Worst,
};

/// Confidence of the intervals of differences.
const CONFIDENCE: f64 = 0.95;

/// Runs one evaluation. `results` holds the searches and tunes that it names.
///
/// # Errors
/// Whatever keeps it from a result; a tune that chose nothing leaves its condition empty.
pub fn run_evaluate(
    context: &Context,
    evaluate: &Evaluate,
    results: &EarlierResults,
    progress: &dyn BlockProgress,
) -> Result<EvaluateResult, ExperimentError> {
    let cases = context.case_set(&evaluate.on, &evaluate.name, results)?;
    let measures =
        if evaluate.measures.is_empty() { context.all_measures() } else { evaluate.measures.clone() };
    let series = Series { context, evaluate, cases, measures };
    let all = evaluate.conditions.len();
    let mut conditions: Vec<ConditionResult> = Vec::with_capacity(all);
    let setups: Vec<Known> = evaluate
        .conditions
        .iter()
        .map(|condition| context.settings_of(condition, results))
        .collect::<Result<_, _>>()?;
    let targets = targets(&setups);
    for (condition, setup) in evaluate.conditions.iter().zip(setups) {
        let result = series.condition(condition, setup, &targets, conditions.first())?;
        conditions.push(result);
        progress.evaluated(conditions.len(), all, None);
    }
    Ok(EvaluateResult {
        name: evaluate.name.clone(),
        doc: evaluate.doc.clone(),
        source: evaluate.source.clone(),
        metrics: context.requests().iter().map(MetricReference::label).collect(),
        cases: series.cases.len(),
        measures: series.measures,
        fresh: evaluate.fresh,
        conditions,
    })
}

/// What a condition is, or why nobody knows.
type Known = Result<Setup, String>;

/// What a condition runs the cases with.
#[derive(Default)]
struct Setup {
    /// `None`: each case's own.
    scenario: Option<String>,
    settings: Vec<(Target, Value)>,
    caveat: Option<String>,
}

impl Setup {
    fn of(settings: Vec<(Target, Value)>) -> Self {
        Self { settings, ..Self::default() }
    }
}

/// Everything that any condition sets, each once.
fn targets(setups: &[Known]) -> Vec<Target> {
    let mut targets = Vec::new();
    for (target, _) in setups.iter().flatten().flat_map(|known| &known.settings) {
        if !targets.contains(target) {
            targets.push(target.clone());
        }
    }
    targets
}

/// One evaluation under way.
struct Series<'a> {
    context: &'a Context<'a>,
    evaluate: &'a Evaluate,
    cases: Vec<SavedCase>,
    measures: Vec<Measure>,
}

impl Series<'_> {
    fn condition(
        &self,
        condition: &Condition,
        setup: Known,
        targets: &[Target],
        first: Option<&ConditionResult>,
    ) -> Result<ConditionResult, ExperimentError> {
        let reported = self.evaluate.reported.iter().find(|(name, _)| *name == condition.name);
        let mut result = ConditionResult {
            name: condition.name.clone(),
            parameters: Vec::new(),
            missing: None,
            caveat: None,
            measured: vec![None; self.measures.len()],
            undecided: vec![0; self.measures.len()],
            reported: reported.map(|(_, values)| values.clone()),
            differences: Vec::new(),
            runs: Vec::new(),
        };
        let setup = match setup {
            Ok(setup) => setup,
            Err(reason) => {
                result.differences = vec![None; if first.is_some() { self.measures.len() } else { 0 }];
                result.missing = Some(reason);
                return Ok(result);
            }
        };
        result.caveat = setup.caveat.clone();
        let (saved, cases) = self.cases(condition, &setup)?;
        let given_in = &self.evaluate.given_in;
        let scenarios = saved.iter().map(|case| self.context.scenario(&case.scenario));
        let scenarios = scenarios.collect::<Result<Vec<_>, _>>()?;
        let parameter = |target: &Target| {
            let values = scenarios
                .iter()
                .zip(&cases)
                .flat_map(|(scenario, case)| overrides::resolved(target, scenario, case));
            parameter(target, values, given_in)
        };
        result.parameters = targets.iter().map(parameter).collect();
        let outcomes = self.context.run_all(0, &cases)?;
        let requests = self.context.requests();
        let measures = self.measures.iter().map(|measure| &measure.aggregate);
        result.undecided =
            measures.clone().map(|measure| undecided(measure.metric(), &outcomes, requests)).collect();
        result.measured = measures.map(|measure| measured(measure, &outcomes, requests)).collect();
        if let Some(first) = first {
            let base: Vec<Outcome> = first.runs.iter().map(|run| run.outcome.clone()).collect();
            result.differences = self
                .measures
                .iter()
                .map(|measure| self.difference(measure, &condition.name, &base, &outcomes))
                .collect();
        }
        result.runs = self.context.case_runs(saved, outcomes);
        Ok(result)
    }

    /// The cases under a condition: once with their own seeds, or several times with fresh ones, which are the same
    /// under every condition.
    fn cases(
        &self,
        condition: &Condition,
        setup: &Setup,
    ) -> Result<(Vec<SavedCase>, Vec<Case>), ExperimentError> {
        let (suite, name) = (self.context.suite, &self.evaluate.name);
        let mut saved = Vec::new();
        let mut cases = Vec::new();
        for (index, case) in self.cases.iter().enumerate() {
            let scenario = setup.scenario.as_ref().unwrap_or(&case.scenario).clone();
            let case = SavedCase { scenario, value: None, ..case.clone() };
            for fresh in 0..self.evaluate.fresh.max(1) {
                let within = match self.evaluate.fresh {
                    0 => format!("case={}", index + 1),
                    _ => format!("case={}/fresh={}", index + 1, fresh + 1),
                };
                let key = format!("{}/{name}/{}/{within}", suite.key_name(), condition.name);
                let seed = (self.evaluate.fresh > 0)
                    .then(|| derive_seed(suite.seed, &format!("{}/{name}/{within}", suite.name)));
                cases.push(self.context.revive(&case, &setup.settings, key.clone(), seed)?);
                let settings = case.settings.iter().chain(&setup.settings).cloned().collect();
                let seed = seed.unwrap_or(case.seed);
                saved.push(SavedCase { key, settings, seed, ..case.clone() });
            }
        }
        Ok((saved, cases))
    }

    /// `None` where one of both does not exist.
    fn difference(
        &self,
        measure: &Measure,
        condition: &str,
        base: &[Outcome],
        outcomes: &[Outcome],
    ) -> Option<Difference> {
        let requests = self.context.requests();
        let per_case = self.evaluate.fresh.max(1) as usize;
        let seed = || {
            let key =
                format!("{}/{}/{condition}/{}", self.context.suite.name, self.evaluate.name, measure.text);
            derive_seed(self.context.suite.seed, &key)
        };
        // The runs of one case are alike, so that a case counts once, by its mean.
        let paired = |of: &dyn Fn(&Outcome) -> Option<f64>| {
            let case_mean = |runs: &[Outcome]| mean(&runs.iter().filter_map(of).collect::<Vec<_>>());
            let both = base.chunks(per_case).zip(outcomes.chunks(per_case));
            let both = both.filter_map(|(base, ours)| Some((case_mean(base)?, case_mean(ours)?)));
            let (base, ours): (Vec<f64>, Vec<f64>) = both.unzip();
            let differences: Vec<f64> = base.iter().zip(&ours).map(|(base, ours)| ours - base).collect();
            Some(Difference {
                value: mean(&differences)?,
                interval: paired_difference(&base, &ours, CONFIDENCE, seed()),
                pairs: base.len(),
            })
        };
        let index = requests.index(measure.aggregate.metric())?;
        match &measure.aggregate {
            Aggregate::Mean(reference) => {
                let counted = |outcome: &Outcome| Seen::of(outcome, index).worst(reference, side(reference));
                let known = |outcomes: &[Outcome]| outcomes.iter().filter_map(counted).all(f64::is_finite);
                if !known(base) || !known(outcomes) {
                    return None;
                }
                paired(&counted)
            }
            Aggregate::Rate(comparison) if per_case > 1 => {
                paired(&|outcome| Some(f64::from(Seen::of(outcome, index).holds(comparison, false))))
            }
            Aggregate::Rate(comparison) => {
                let held = |outcome: &Outcome| Seen::of(outcome, index).holds(comparison, false);
                let both = || base.iter().zip(outcomes).map(|(base, ours)| (held(base), held(ours)));
                let only_base = both().filter(|(base, ours)| *base && !ours).count() as u64;
                let only_ours = both().filter(|(base, ours)| !base && *ours).count() as u64;
                let pairs = both().count();
                (pairs > 0).then(|| Difference {
                    value: (only_ours as f64 - only_base as f64) / pairs as f64,
                    interval: Some(rate_change(only_base, only_ours, pairs as u64, CONFIDENCE)),
                    pairs,
                })
            }
            other => {
                let value = measured(other, outcomes, requests)? - measured(other, base, requests)?;
                let defined = |(base, ours): &(&Outcome, &Outcome)| {
                    Seen::of(base, index).is_value() && Seen::of(ours, index).is_value()
                };
                let pairs = base.iter().zip(outcomes).filter(defined).count();
                Some(Difference { value, interval: None, pairs })
            }
        }
    }
}

/// A measure over the outcomes, as evaluations and statements see it. It claims nothing; runs without a value of a quantity count as that metric gets worse, so that
/// no condition looks better by runs that come to nothing. Rates count runs as their comparison says.
pub(super) fn measured(measure: &Aggregate, outcomes: &[Outcome], requests: &Requests) -> Option<f64> {
    match measure {
        Aggregate::Rate(_) | Aggregate::Count(_) => aggregate(measure, outcomes, requests),
        of_values => aggregate_against(of_values, side(of_values.metric()), outcomes, requests),
    }
}

/// As [`measured`], between what the runs that were cut off could still have made of it.
pub(super) fn measured_between(
    measure: &Aggregate,
    outcomes: &[Outcome],
    requests: &Requests,
) -> Option<ValueSpan> {
    span_of(measure, side(measure.metric()), outcomes, requests)
}

/// What somebody would claim of a metric's values who says that they are good.
fn side(reference: &MetricReference) -> Relation {
    match reference.known().map(|metric| metric.worst) {
        Some(Worst::Smallest) => Relation::GreaterOrEqual,
        _ => Relation::LessOrEqual,
    }
}

impl Context<'_> {
    fn settings_of(&self, condition: &Condition, results: &EarlierResults) -> Result<Known, ExperimentError> {
        match &condition.parameters {
            ParameterSet::Declared => Ok(Ok(Setup::default())),
            ParameterSet::Given(settings) => Ok(Ok(Setup::of(settings.clone()))),
            ParameterSet::Scenario(name) => {
                Ok(Ok(Setup { scenario: Some(name.clone()), ..Setup::default() }))
            }
            ParameterSet::Tuned(name) => {
                let tune = self.suite.tunes.iter().find(|tune| tune.name == *name);
                let tune = tune.ok_or_else(|| ExperimentError::NotRun(name.clone()))?;
                let result = results.tune(name)?;
                Ok(match &result.chosen {
                    Some(chosen) => Ok(Setup {
                        caveat: result.caveat(),
                        ..Setup::of(overrides::settings(&tune.over, &chosen.point))
                    }),
                    None => Err(format!("tune `{name}` chose nothing")),
                })
            }
            ParameterSet::Saved(path) => {
                let saved = ParameterFile::read(Path::new(path), &*self.files)?;
                Ok(Ok(Setup { caveat: saved.caveat, ..Setup::of(saved.parameters) }))
            }
        }
    }

    /// Every metric that the suite measures: flags as rates, quantities as means. Categories have neither.
    fn all_measures(&self) -> Vec<Measure> {
        let measure = |reference: &MetricReference| {
            let label = reference.label();
            match reference.known()?.kind {
                MetricKind::Category(_) => None,
                MetricKind::Flag => Some(Measure {
                    aggregate: Aggregate::Rate(Comparison {
                        metric: reference.clone(),
                        relation: Relation::Equal,
                        bound: 1.0.into(),
                        when_undefined: WhenUndefined::AsDeclared,
                    }),
                    text: format!("rate({label})"),
                    unit: "%".into(),
                    notation: None,
                }),
                MetricKind::Quantity(dimension) => Some(Measure {
                    aggregate: Aggregate::Mean(reference.clone()),
                    text: format!("mean({label})"),
                    unit: dimension.si_unit(),
                    notation: None,
                }),
            }
        };
        self.requests().iter().filter_map(measure).collect()
    }
}

/// The value that a parameter has wherever it is set, in all of the cases, as the models resolved it.
fn parameter(
    target: &Target,
    mut values: impl Iterator<Item = Option<(Value, String)>>,
    given_in: &[(Target, Notation)],
) -> ParameterValue {
    let notation = given_in.iter().find(|(known, _)| known == target).map(|(_, notation)| *notation);
    let first = values.next().flatten();
    let agreed =
        values.all(|other| other.as_ref().map(|(value, _)| value) == first.as_ref().map(|(value, _)| value));
    let (value, unit) = first.map_or((None, String::new()), |(value, unit)| (Some(value), unit));
    let value = value.filter(|_| agreed);
    ParameterValue { target: target.clone(), value, varies: !agreed, unit, notation }
}
