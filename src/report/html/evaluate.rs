//! An `evaluate` on the page: conditions side by side, ours beside what a source reports, and what changed case by case.

use serde::Serialize;

use super::figure::HtmlFigure;
use super::space::{MeasuredQuantity, short_names};
use crate::chart::{Dot, First, Rows, Rule, Strip, Strips, first_legend};
use crate::evaluation::without_value;
use crate::format::in_written_unit;
use crate::wording::comparison_rule;
use numbers::inference::{Interval, mean_interval, wilson};
use numbers::summary::mean;
use results::judge::holds;
use results::{CaseRun, ConditionResult, Difference, EvaluateResult, ParameterValue, SuiteReport};
use scenario::{
    Aggregate, Block, CaseSet, Comparison, Evaluate, Measure, MetricKind, MetricReference, Notation,
    ParameterSet,
};

/// More conditions than this stand below each other.
const MOST_STRIPS: usize = 6;
/// Of the intervals of ours.
const CONFIDENCE: f64 = 0.95;
/// What the resampling behind intervals begins with; any number would do.
const SEED: u64 = 1;

#[derive(Debug, Serialize)]
pub struct EvaluateSection {
    sentences: Vec<String>,
    parameters: Vec<String>,
    measures: Vec<String>,
    groups: Vec<Group>,
    source: Option<String>,
    /// The condition that the others are compared with, if there are others.
    base: Option<String>,
    figures: Vec<HtmlFigure>,
}

/// The rows of one condition.
#[derive(Debug, Serialize)]
struct Group {
    name: String,
    /// Why it was not run, or what has to be known of it.
    remark: Option<String>,
    parameters: Vec<String>,
    ours: Vec<Cell>,
    reported: Vec<String>,
    /// Ours less what is reported.
    apart: Vec<Cell>,
    /// From the first condition.
    changes: Vec<Cell>,
}

#[derive(Debug, Default, Serialize)]
struct Cell {
    text: String,
    interval: String,
    /// Whether the interval says that there is a difference.
    sure: bool,
}

impl EvaluateSection {
    pub fn new(report: &SuiteReport, evaluate: &Evaluate, result: &EvaluateResult) -> Self {
        let measured: Vec<MeasuredQuantity> = result
            .measures
            .iter()
            .map(|one| MeasuredQuantity::new(&one.text, one.aggregate.unit()).written_in(one.notation))
            .collect();
        let table = Table { result, measured: &measured };
        let parameters = result.conditions.iter().map(|one| &one.parameters).find(|all| !all.is_empty());
        let targets: Vec<_> = parameters.into_iter().flatten().map(|one| one.target.clone()).collect();
        Self {
            sentences: sentences(result),
            parameters: short_names(&targets),
            measures: measured.iter().map(|one| one.name.clone()).collect(),
            groups: result.conditions.iter().map(|one| table.group(one)).collect(),
            source: result.source.clone(),
            base: result.conditions.get(1).map(|_| result.conditions[0].name.clone()),
            figures: Charts { report, evaluate, result }.figures(),
        }
    }

    /// What it came to, in a line.
    pub fn summary(result: &EvaluateResult) -> String {
        let conditions = result.conditions.len();
        let missing = result.conditions.iter().filter(|one| one.missing.is_some()).count();
        let missing = if missing == 0 { String::new() } else { format!(", {missing} of them not run") };
        let conditions =
            if conditions == 1 { "one condition".to_string() } else { format!("{conditions} conditions") };
        format!("{conditions} on {} cases{missing}", result.cases)
    }
}

fn sentences(result: &EvaluateResult) -> Vec<String> {
    let cases = if result.cases == 1 { "One case".into() } else { format!("{} cases", result.cases) };
    let runs = match result.fresh {
        0 => "each run once under its own seed".to_string(),
        1 => "each run once under a fresh seed".to_string(),
        runs => format!("each run {runs} times under fresh seeds"),
    };
    let mut sentences = vec![format!("{cases}, {runs}, the same under every condition.")];
    sentences.extend(without_value(result).into_iter().map(|said| format!("{said}.")));
    sentences
}

/// What makes up the rows of the table.
struct Table<'a> {
    result: &'a EvaluateResult,
    measured: &'a [MeasuredQuantity],
}

impl Table<'_> {
    fn group(&self, condition: &ConditionResult) -> Group {
        let ours = condition.measured.iter().enumerate().map(|(index, value)| {
            let interval = self.interval(condition, &self.result.measures[index]);
            Cell {
                text: self.measured[index].text(*value),
                interval: self.ends(index, interval),
                sure: false,
            }
        });
        let reported = condition.reported.iter().flatten().zip(self.measured);
        let change = |(index, difference): (usize, &Option<Difference>)| {
            let Some(Difference { value, interval, .. }) = difference else { return Cell::none() };
            Cell {
                text: self.measured[index].change(*value),
                interval: self.ends(index, *interval),
                sure: interval.is_some_and(|interval| !interval.contains(0.0)),
            }
        };
        Group {
            name: condition.name.clone(),
            remark: condition.missing.clone().or_else(|| condition.caveat.clone()),
            parameters: condition.parameters.iter().map(parameter).collect(),
            ours: ours.collect(),
            reported: reported.map(|(value, one)| one.text(Some(*value))).collect(),
            apart: self.apart(condition),
            changes: match condition.differences.iter().all(Option::is_none) {
                true => Vec::new(),
                false => condition.differences.iter().enumerate().map(change).collect(),
            },
        }
    }

    /// Ours less what is reported, sure where that lies outside our interval.
    fn apart(&self, condition: &ConditionResult) -> Vec<Cell> {
        let Some(reported) = condition.reported.as_ref().filter(|_| condition.missing.is_none()) else {
            return Vec::new();
        };
        let cell = |(index, (ours, theirs)): (usize, (&Option<f64>, &f64))| {
            let Some(ours) = ours else { return Cell::none() };
            let interval = self.interval(condition, &self.result.measures[index]);
            Cell {
                text: self.measured[index].change(ours - theirs),
                interval: String::new(),
                sure: interval.is_some_and(|interval| !interval.contains(*theirs)),
            }
        };
        condition.measured.iter().zip(reported).enumerate().map(cell).collect()
    }

    /// Where the mean or rate over all cases like these lies; of other aggregates nothing is said. The runs of one case
    /// are alike, so that a case counts once.
    fn interval(&self, condition: &ConditionResult, measure: &Measure) -> Option<Interval> {
        let index = self.index(measure)?;
        let each = self.result.fresh.max(1) as usize;
        let per_case = |of: &dyn Fn(&CaseRun) -> Option<f64>| -> Vec<f64> {
            let cases = condition.runs.chunks(each);
            cases.filter_map(|runs| mean(&runs.iter().filter_map(of).collect::<Vec<_>>())).collect()
        };
        match &measure.aggregate {
            Aggregate::Mean(_) => {
                mean_interval(&per_case(&|run| run.outcome.metrics[index]), CONFIDENCE, SEED)
            }
            Aggregate::Rate(comparison) => {
                let held = |run: &CaseRun| holds(comparison, run.outcome.metrics[index]);
                if each > 1 {
                    return mean_interval(&per_case(&|run| Some(f64::from(held(run)))), CONFIDENCE, SEED);
                }
                let holding = condition.runs.iter().filter(|run| held(run)).count() as u64;
                let runs = condition.runs.len() as u64;
                (runs > 0).then(|| wilson(holding, runs, CONFIDENCE))
            }
            _ => None,
        }
    }

    fn index(&self, measure: &Measure) -> Option<usize> {
        position(self.result, measure.aggregate.metric())
    }

    /// Such as `2.1 to 2.9`, without the unit.
    fn ends(&self, index: usize, interval: Option<Interval>) -> String {
        let number = |value| self.measured[index].rough(value, 3);
        interval.map_or_else(String::new, |one| format!("{} to {}", number(one.low), number(one.high)))
    }
}

impl Cell {
    fn none() -> Self {
        Self { text: "–".into(), ..Self::default() }
    }
}

/// Where the runs of a result have a metric.
fn position(result: &EvaluateResult, metric: &MetricReference) -> Option<usize> {
    let label = metric.label();
    result.metrics.iter().position(|known| *known == label)
}

fn parameter(parameter: &ParameterValue) -> String {
    match &parameter.value {
        None => if parameter.varies { "varies" } else { "not set" }.to_string(),
        Some(value) => match value.as_number() {
            Some(number) => in_written_unit(number, parameter.notation, &parameter.unit),
            None => value.to_string(),
        },
    }
}

/// What the charts are drawn from.
struct Charts<'a> {
    report: &'a SuiteReport,
    evaluate: &'a Evaluate,
    result: &'a EvaluateResult,
}

impl Charts<'_> {
    fn figures(&self) -> Vec<HtmlFigure> {
        let mut quantities: Vec<&MetricReference> = Vec::new();
        for reference in self.result.measures.iter().map(|measure| measure.aggregate.metric()) {
            let kind = reference.known().map(|metric| &metric.kind);
            if matches!(kind, Some(MetricKind::Quantity(_))) && !quantities.contains(&reference) {
                quantities.push(reference);
            }
        }
        let mut figures: Vec<HtmlFigure> = Vec::new();
        for reference in quantities {
            if let Some(index) = position(self.result, reference) {
                figures.extend(self.distributions(reference, index));
                figures.extend(self.changes(reference, index));
            }
        }
        figures
    }

    /// The unit in which the evaluation compares a metric, or else what is behind it.
    fn notation(&self, reference: &MetricReference) -> Option<Notation> {
        let of_values =
            |aggregate: &Aggregate| !matches!(aggregate, Aggregate::Rate(_) | Aggregate::Count(_));
        let measures = self.result.measures.iter().filter(|measure| of_values(&measure.aggregate));
        let measures = measures.map(|measure| (measure.aggregate.metric(), measure.notation));
        let comparisons = self.comparisons().into_iter().map(|(one, unit)| (&one.metric, unit));
        measures.chain(comparisons).filter(|(metric, _)| *metric == reference).find_map(|(_, unit)| unit)
    }

    fn measured(&self, reference: &MetricReference) -> MeasuredQuantity {
        MeasuredQuantity::metric(reference).written_in(self.notation(reference))
    }

    /// Figure (e) of the founding paper.
    fn distributions(&self, reference: &MetricReference, index: usize) -> Option<HtmlFigure> {
        let measured = self.measured(reference);
        let strip = |condition: &ConditionResult| {
            let dot = |run: &CaseRun| {
                let (first, name) = (First::of(run.passed_first.as_deref()), run.case.key.clone());
                run.outcome.metrics[index].map(|value| Dot {
                    value: measured.charted(value),
                    first,
                    name,
                    is_run: false,
                })
            };
            let dots: Vec<Dot> = condition.runs.iter().filter_map(dot).collect();
            Strip { name: condition.name.clone(), undefined: condition.runs.len() - dots.len(), dots }
        };
        let rules = self.rules(reference);
        let note = "Every run under each condition. Boxes show median and quartiles; beyond 120 runs a violin stands \
                    for the middle 90 %.";
        let title = format!("{} per condition", reference.label());
        self.strips(title, note, reference, self.result.conditions.iter().map(strip).collect(), rules)
    }

    /// What every case has more than under the first condition.
    fn changes(&self, reference: &MetricReference, index: usize) -> Option<HtmlFigure> {
        let (first, others) = self.result.conditions.split_first()?;
        let measured = self.measured(reference);
        let strip = |condition: &ConditionResult| {
            let pairs = first.runs.iter().zip(&condition.runs);
            let dot = |(before, after): (&CaseRun, &CaseRun)| {
                let value = after.outcome.metrics[index]? - before.outcome.metrics[index]?;
                Some(Dot {
                    value: measured.charted(value),
                    first: First::of(after.passed_first.as_deref()),
                    name: after.case.key.clone(),
                    is_run: false,
                })
            };
            let dots: Vec<Dot> = pairs.filter_map(dot).collect();
            Strip { name: condition.name.clone(), undefined: condition.runs.len() - dots.len(), dots }
        };
        let rule = Rule { value: 0.0, label: "no change".into() };
        let note = format!("The same case under each condition, less under {}.", first.name);
        let title = format!("Change in {} from {}", reference.label(), first.name);
        self.strips(title, &note, reference, others.iter().map(strip).collect(), vec![rule])
    }

    fn strips(
        &self,
        title: String,
        note: &str,
        reference: &MetricReference,
        strips: Vec<Strip>,
        rules: Vec<Rule>,
    ) -> Option<HtmlFigure> {
        let firsts: Vec<First> = strips.iter().flat_map(|strip| &strip.dots).map(|dot| dot.first).collect();
        if firsts.is_empty() {
            return None;
        }
        let (quantity, name) = (self.measured(reference).quantity(), self.result.name.clone());
        let svg = if strips.len() > MOST_STRIPS {
            let range = Strips::range(&strips, &rules);
            Rows { title: name, x: quantity, strips, rules, range }.to_svg()
        } else {
            Strips { title: name, x: String::new(), y: quantity, strips, rules, range: None }.to_svg()
        };
        Some(HtmlFigure::new(title, note, vec![svg]).with_legend(first_legend(firsts, false)))
    }

    /// What the tunes and the search behind it compare to a bound, with the unit of that.
    fn comparisons(&self) -> Vec<(&Comparison, Option<Notation>)> {
        let block = |name: &str| {
            self.report.blocks.iter().map(|report| &*report.block).find(|one| one.name() == name)
        };
        let mut comparisons: Vec<(&Comparison, Option<Notation>)> = Vec::new();
        for condition in &self.evaluate.conditions {
            if let ParameterSet::Tuned(name) = &condition.parameters
                && let Some(Block::Tune(tune)) = block(name)
            {
                let constraints = tune.constraints.iter().enumerate();
                comparisons.extend(constraints.map(|(index, one)| (one, tune.constraint_in(index))));
            }
        }
        if let CaseSet::Search(name) | CaseSet::Bests(name) = &self.evaluate.on
            && let Some(Block::Search(search)) = block(name)
        {
            comparisons.extend(search.kept_metrics());
        }
        comparisons
    }

    /// The bounds of those comparisons that are of the metric.
    fn rules(&self, reference: &MetricReference) -> Vec<Rule> {
        let unit = self.notation(reference);
        let mut rules: Vec<(f64, Rule)> = Vec::new();
        for (comparison, _) in self.comparisons().into_iter().filter(|(one, _)| one.metric == *reference) {
            if !rules.iter().any(|(bound, _)| *bound == comparison.constant_bound()) {
                rules.push((comparison.constant_bound(), comparison_rule(comparison, unit)));
            }
        }
        rules.into_iter().map(|(_, rule)| rule).collect()
    }
}
