//! How far a run was from the bounds that criteria hold single runs to, over time, and what is measured where nothing else draws it: of metrics that
//! have a value during a run, being the worst over time of something. What is known at the end alone is never drawn as if it were known before.

use super::asked::{comparison, named};
use super::minds::Picture;
use super::told::find;
use crate::chart::{AxisQuantity, LOOKS, Look, OverTime, Rule, TimeMark, TimeSeries};
use crate::digest::unit_for;
use crate::format::{in_notation, with_unit};
use results::judge::per_run;
use results::{Outcome, Recording, Requests, SuiteReport};
use scenario::{
    Comparison, Criterion, Dimension, Metric, MetricKind, MetricReference, Notation, Relation, Worst,
};
use sim::measure::StepReadings;

/// A criterion's distance from its bound.
struct Margin<'r> {
    criterion: &'r Criterion,
    dimension: Dimension,
    /// SI units.
    bound: f64,
    /// Whether the run speaks against it.
    fails: bool,
    /// Time in s and what was left of all until then, SI units.
    points: Vec<(f64, Option<f64>)>,
    /// What was left of the whole run, and when it took that value, s.
    least: f64,
    time: Option<f64>,
}

/// A picture for each dimension of what criteria are about.
pub fn pictures(
    reports: &[SuiteReport],
    requests: &Requests,
    recording: &Recording,
    (from, to): (f64, f64),
    moment: Option<f64>,
) -> Vec<Picture> {
    let Some((trial, outcome)) = find(reports, &recording.case.key) else { return Vec::new() };
    let criteria = &trial.trial.criteria[..];
    let (mut drawn, mut at_the_end): (Vec<Margin>, Vec<&str>) = Default::default();
    for criterion in criteria {
        match margin(criterion, outcome, requests, recording) {
            Some(Some(margin)) => drawn.push(margin),
            Some(None) => at_the_end.push(&criterion.text),
            None => {}
        }
    }
    let mut pictures: Vec<Picture> = Vec::new();
    while let Some(dimension) = drawn.first().map(|margin| margin.dimension) {
        let (group, others) = drawn.into_iter().partition(|margin| margin.dimension == dimension);
        drawn = others;
        let unit = unit_for(criteria, dimension);
        pictures.push(picture(group, (dimension, unit), (from, to), moment));
    }
    if let Some(first) = pictures.first_mut().filter(|_| !at_the_end.is_empty()) {
        first.words += &format!(" Not drawn, since not known before the end: {}.", at_the_end.join("; "));
        first.words = first.words.trim_start().to_string();
    }
    pictures
}

/// How far a run was from the bound of a criterion over time; an inner `None` where that is no matter of time, the outer one where the criterion has
/// no bound for single runs, or its metric does not exist.
fn margin<'r>(
    criterion: &'r Criterion,
    outcome: &Outcome,
    requests: &Requests,
    recording: &Recording,
) -> Option<Option<Margin<'r>>> {
    let wanted = per_run(criterion)?;
    let comparison = comparison(&wanted.criterion)?;
    let index = requests.index(&comparison.metric)?;
    let value = outcome.metrics[index]?;
    let (metric, dimension) = quantity_of(&comparison.metric)?;
    let Some(readings) = readings(recording, index, value).filter(|_| gets_worse(comparison, metric)) else {
        return Some(None);
    };
    let left = |value: f64| comparison.relation.margin(value, comparison.constant_bound());
    let times = recording.times.iter().copied();
    let points = times.zip(readings.worst_so_far().map(|worst| left(worst?))).collect();
    Some(Some(Margin {
        criterion,
        dimension,
        bound: comparison.constant_bound(),
        fails: !wanted.standing(outcome, requests).holds,
        points,
        least: left(value)?,
        time: outcome.critical.get(index).and_then(|critical| critical.time),
    }))
}

/// Its readings over time, if they come to what the metric came to: to the last bit, or they are those of something else.
fn readings(recording: &Recording, index: usize, value: f64) -> Option<&StepReadings> {
    let readings = recording.readings.iter().find(|readings| readings.metric == index)?;
    let is_whole = readings.worst.len() == recording.times.len();
    (is_whole && readings.worst_so_far().last()? == Some(value)).then_some(readings)
}

/// Whether what is left of it can only become less in a run.
fn gets_worse(comparison: &Comparison, metric: &Metric) -> bool {
    match comparison.relation {
        Relation::Greater | Relation::GreaterOrEqual => metric.worst == Worst::Smallest,
        Relation::Less | Relation::LessOrEqual => metric.worst == Worst::Largest,
        Relation::Equal | Relation::NotEqual => false,
    }
}

fn quantity_of(reference: &MetricReference) -> Option<(&Metric, Dimension)> {
    let metric = reference.known()?;
    match &metric.kind {
        MetricKind::Quantity(dimension) => Some((metric, *dimension)),
        MetricKind::Flag | MetricKind::Category(_) => None,
    }
}

/// The margins of one dimension.
fn picture(
    mut margins: Vec<Margin>,
    (dimension, unit): (Dimension, Option<Notation>),
    (from, to): (f64, f64),
    moment: Option<f64>,
) -> Picture {
    // Those that fail are never among what is left out.
    margins.sort_by_key(|margin| !margin.fails);
    let left_out = margins.len().saturating_sub(LOOKS);
    margins.truncate(LOOKS);
    let in_unit = |value: f64| unit.map_or(value, |unit| unit.of_si(value));
    let said = |value: f64| {
        let words = unit.map_or_else(|| with_unit(value, dimension), |unit| in_notation(value, unit));
        if value > 0.0 { format!("+{words}") } else { words }
    };
    let symbol = unit.map_or_else(|| dimension.si_unit(), |unit| unit.symbol.as_str().to_string());
    let series = margins.iter().enumerate().map(|(index, margin)| TimeSeries {
        look: Look::series(index),
        name: margin.criterion.text.clone(),
        points: margin.points.iter().map(|(time, left)| (*time, left.map(in_unit))).collect(),
    });
    let marks = margins.iter().enumerate().filter_map(|(index, margin)| {
        let (look, value) = (Look::series(index), in_unit(margin.least));
        Some(TimeMark { look, time: margin.time?, value, label: said(margin.least) })
    });
    // What is left while nothing is near would press together what matters.
    let high = margins.iter().map(|margin| margin.bound.abs().max(1.2 * margin.least)).fold(0.0, f64::max);
    let plot = OverTime {
        title: format!("Margins of criteria ({symbol})"),
        y: AxisQuantity::new("what was left to the bound, worst so far", symbol),
        from,
        to,
        series: series.collect(),
        rules: vec![Rule { value: 0.0, label: "the bound".into() }],
        moment,
        marks: marks.collect(),
        ceiling: (high > 0.0).then(|| in_unit(high)),
    };
    let legend = margins.iter().enumerate().map(|(index, margin)| {
        let verb = if margin.fails { "✗" } else { "✓" };
        (Look::series(index).swatch(true, true), format!("{verb} {}", margin.criterion.text))
    });
    let words = match left_out {
        0 => String::new(),
        more => format!("{more} more criteria are not drawn."),
    };
    Picture { svg: plot.to_svg(), legend: legend.collect(), words }
}

/// A metric that has no other picture over time.
pub struct MeasuredOverTime<'r> {
    pub metric: &'r MetricReference,
    pub title: String,
    pub dimension: Dimension,
    pub points: Vec<(f64, Option<f64>)>,
}

/// Those of what criteria are about, without the metrics that are `shown` elsewhere.
pub fn measured<'r>(
    criteria: &'r [Criterion],
    outcome: Option<&Outcome>,
    requests: &Requests,
    recording: &Recording,
    shown: &[&str],
) -> Vec<MeasuredOverTime<'r>> {
    let mut all: Vec<MeasuredOverTime> = Vec::new();
    for metric in criteria.iter().map(|criterion| criterion.claim.metric()) {
        if shown.contains(&metric.name()) || all.iter().any(|one| one.metric.is_same(metric)) {
            continue;
        }
        let one = || {
            let index = requests.index(metric)?;
            let readings = readings(recording, index, outcome?.metrics[index]?)?;
            let (_, dimension) = quantity_of(metric)?;
            let points = recording.times.iter().copied().zip(readings.worst.iter().copied()).collect();
            Some(MeasuredOverTime { metric, title: named(metric), dimension, points })
        };
        all.extend(one());
    }
    all
}
