//! What is asked of a recorded run and drawn over time: bounds, and what its metrics came to, when and for whom. That is the metrics' own; what is
//! recorded of a run are samples, from which no metric is worked out.

use super::told::find;
use crate::chart::Rule;
use crate::digest::unit_for;
use crate::format::{in_notation, quantity};
use crate::wording::comparison_rule;
use results::judge::per_run;
use results::{Outcome, Recording, Requests, SuiteReport};
use scenario::{
    Aggregate, Claim, Comparison, Criterion, Dimension, Expression, MetricReference, Notation, Relation,
    Value,
};

/// What is asked of a run.
pub struct AskedOfRun<'r> {
    pub criteria: &'r [Criterion],
    readings: Vec<RunReading<'r>>,
}

/// What a metric that a criterion is about came to.
pub struct RunReading<'r> {
    pub metric: &'r MetricReference,
    /// SI units; `None` where it does not exist in the run.
    pub value: Option<f64>,
    /// Whether the run ended before it was decided.
    pub is_open: bool,
    /// When it took its value, s.
    pub time: Option<f64>,
    /// Whose it is, by their places in the world.
    pub vehicle: Option<usize>,
    pub pedestrian: Option<usize>,
    /// Whether the run speaks against a criterion about it.
    pub fails: bool,
}

impl<'r> AskedOfRun<'r> {
    pub fn new(reports: &'r [SuiteReport], requests: &'r Requests, recording: &Recording) -> Self {
        let Some((trial, outcome)) = find(reports, &recording.case.key) else {
            return Self { criteria: &[], readings: Vec::new() };
        };
        Self::of_run(&trial.trial.criteria, outcome, requests, recording)
    }

    /// What `criteria` ask of a run with that outcome.
    pub fn of_run(
        criteria: &'r [Criterion],
        outcome: &Outcome,
        requests: &Requests,
        recording: &Recording,
    ) -> Self {
        let mut readings: Vec<(usize, RunReading)> = Vec::new();
        for criterion in criteria {
            let Some(index) = requests.index(criterion.claim.metric()) else { continue };
            let Some(one) = per_run(criterion) else { continue };
            let fails = !one.standing(outcome, requests).holds;
            match readings.iter_mut().find(|(known, _)| *known == index) {
                Some((_, reading)) => reading.fails |= fails,
                None => readings.push((index, reading(criterion, outcome, index, recording, fails))),
            }
        }
        Self { criteria, readings: readings.into_iter().map(|(_, reading)| reading).collect() }
    }

    /// What the metrics of a name came to: of different pairs, or with different settings.
    pub fn of<'s>(&'s self, metric: &'s str) -> impl Iterator<Item = &'s RunReading<'r>> {
        self.readings.iter().filter(move |reading| reading.metric.name() == metric)
    }

    /// The last of a moment and all at which metrics took their values, s.
    pub fn last(&self, moment: f64) -> f64 {
        self.readings.iter().filter_map(|reading| reading.time).fold(moment, f64::max)
    }

    /// The unit that a criterion about a metric is written in, or else one about a quantity of its dimension.
    pub fn unit(&self, metric: &str, dimension: Dimension) -> Option<Notation> {
        let about = self.criteria.iter().filter(|criterion| criterion.claim.metric().name() == metric);
        unit_for(about, dimension).or_else(|| unit_for(self.criteria, dimension))
    }

    /// The pairs of vehicle and pedestrian that metrics took their values of, those that the run fails because of first.
    pub fn pairs(&self) -> Vec<(usize, usize)> {
        let (failed, others): (Vec<_>, Vec<_>) = self.readings.iter().partition(|reading| reading.fails);
        let pairs = failed.into_iter().chain(others);
        pairs.filter_map(|reading| reading.vehicle.zip(reading.pedestrian)).collect()
    }

    /// The bounds on a metric that single runs are held to, with the relations.
    pub fn comparisons<'s>(&'s self, metric: &'s str) -> impl Iterator<Item = &'r Comparison> + 's {
        self.criteria.iter().filter_map(comparison).filter(move |one| one.metric.name() == metric)
    }

    /// They as lines; `sign` turns the metric into what is drawn.
    pub fn rules(
        &self,
        metric: &str,
        sign: f64,
        unit: Option<Notation>,
        is_drawn: impl Fn(&MetricReference) -> bool,
    ) -> Vec<Rule> {
        let drawn = self.comparisons(metric).filter(|comparison| is_drawn(&comparison.metric));
        let rule = |comparison: &Comparison| {
            let Rule { value, label } = comparison_rule(comparison, unit);
            Rule { value: sign * value, label: format!("{} {label}", named(&comparison.metric)) }
        };
        drawn.map(rule).collect()
    }
}

impl RunReading<'_> {
    /// Such as `min_ttc 0.83 s`.
    pub fn words(&self, unit: Option<Notation>) -> String {
        if self.is_open && self.value.is_none() {
            return format!("{} undecided when the run ended", named(self.metric));
        }
        let value = match (self.value, unit, self.metric.known()) {
            (Some(value), Some(unit), _) => in_notation(value, unit),
            (value, _, Some(metric)) => quantity(metric, value),
            _ => "–".into(),
        };
        let open = if self.is_open { " when the run ended" } else { "" };
        format!("{} {value}{open}", named(self.metric))
    }

    /// The most that criteria ask of single runs as a least value of the same metric, in SI units and in words.
    pub fn least(&self, asked: &AskedOfRun, unit: Option<Notation>) -> Option<(f64, String)> {
        let same = asked.criteria.iter().filter(|criterion| criterion.claim.metric().is_same(self.metric));
        // What is counted where it is so, is wanted not to be so.
        let wanted = same.filter(|criterion| comparison(criterion).is_some()).filter_map(per_run);
        let least = wanted.filter_map(|one| {
            let comparison = comparison(&one.criterion)?;
            let is_least = matches!(comparison.relation, Relation::Greater | Relation::GreaterOrEqual);
            let label = || comparison_rule(comparison, unit).label;
            is_least.then(|| (comparison.constant_bound(), label()))
        });
        least.reduce(|one, other| if other.0 > one.0 { other } else { one })
    }
}

fn reading<'r>(
    criterion: &'r Criterion,
    outcome: &Outcome,
    index: usize,
    recording: &Recording,
    fails: bool,
) -> RunReading<'r> {
    let world = &recording.case.world;
    let critical = outcome.critical.get(index).cloned().unwrap_or_default();
    let vehicle = critical.vehicle.and_then(|name| world.vehicles.iter().position(|one| *one.name == *name));
    let pedestrian =
        critical.pedestrian.and_then(|name| world.pedestrians.iter().position(|one| *one.name == *name));
    RunReading {
        metric: criterion.claim.metric(),
        value: outcome.metrics[index],
        is_open: outcome.open(index).is_some(),
        time: critical.time,
        vehicle,
        pedestrian,
        fails,
    }
}

/// The name of a metric, and of whom it is if it is not everybody's.
pub fn named(metric: &MetricReference) -> String {
    match &metric.pair {
        Some((one, other)) if !other.is_empty() => format!("{} of {one} and {other}", metric.name()),
        Some((one, _)) => format!("{} of {one}", metric.name()),
        None => metric.name().to_string(),
    }
}

/// What a criterion holds single runs to, if it has a number for that.
pub fn comparison(criterion: &Criterion) -> Option<&Comparison> {
    let (Claim::Runs { comparison, .. }
    | Claim::Aggregate { aggregate: Aggregate::Rate(comparison) | Aggregate::Count(comparison), .. }) =
        &criterion.claim
    else {
        return None;
    };
    let Expression::Constant(Value::Number(_)) = &comparison.bound else { return None };
    Some(comparison)
}
