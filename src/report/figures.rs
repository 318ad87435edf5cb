//! The charts of a suite's report: which there are, and their data out of trials and recorded runs.

mod drawn;
mod over_two;

use std::collections::{BTreeMap, BTreeSet};

use super::chart::{
    AxisQuantity, ChartPath, Dot, First, FoundDot, IndividualsChart, LegendEntry, Paths, Rate, RateSeries,
    Rates, Rows, Rule, Strip, Strips, first_legend, is_drawn, with_room,
};
use super::digest::written_unit;
use super::variable::Variable;
use super::wording::comparison_rule;
use results::{Outcome, Recording, Requests, SuiteReport, TrialReport};
use scenario::{Aggregate, Claim, Expression, MetricKind, MetricReference, Notation, Value, Worst};

/// Charts that belong together, one per panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    pub title: String,
    /// How to read it.
    pub note: String,
    pub legend: Vec<LegendEntry>,
    /// SVG elements.
    pub panels: Vec<String>,
}

/// Charted in every report that has them, with whatever the criteria are about.
const FLAGS: [&str; 3] = ["collision", "gap_accepted", "sudden_speed_change"];
const QUANTITIES: [&str; 1] = ["pet"];
/// With more trials than this, distributions per trial become a scatter over the variation.
const MOST_STRIPS: usize = 12;
/// More points in one chart cannot be told apart.
const MOST_POINTS: usize = 1000;
/// More scenarios than this stand below each other, where there is room for their names.
const MOST_BESIDE: usize = 6;
const STRIPS_NOTE: &str = "Boxes show median and quartiles; beyond 120 runs a violin stands for all, and marks for those \
                           outside the middle 90 %, at most 60 at each end. A fraction above a column counts the runs in which the value exists.";
/// More lines in one chart cannot be told apart.
const MOST_SERIES: usize = super::chart::LOOKS;

/// Every figure that the suite has data for.
pub fn figures(report: &SuiteReport, requests: &Requests, recordings: &[Recording]) -> Vec<Figure> {
    let data = Data { report, requests, variable: Variable::of(report), scenarios: report.scenarios() };
    let charted = data.charted();
    let mut figures = Vec::new();
    figures.extend(data.over_two(&charted));
    figures.extend(data.rates(&charted));
    for index in &charted {
        if matches!(data.kind(*index), Some(MetricKind::Quantity(_))) {
            figures.extend(data.distributions(*index));
            figures.extend(data.individuals(*index));
            figures.extend(data.drawn(*index));
            figures.extend(data.conditions(*index));
        }
    }
    figures.extend(data.courses(recordings));
    figures
}

/// A trial's name within its scenario: the values of its variations; empty without any.
pub fn short_name(trial: &TrialReport) -> String {
    let variation = trial.trial.variation.as_slice();
    match variation {
        [only] => only.label.clone(),
        several => {
            several.iter().map(|one| format!("{}={}", one.name, one.label)).collect::<Vec<_>>().join(" ")
        }
    }
}

struct Data<'a> {
    report: &'a SuiteReport,
    requests: &'a Requests,
    variable: Option<Variable>,
    scenarios: Vec<(&'a str, Vec<&'a TrialReport>)>,
}

impl Data<'_> {
    fn reference(&self, index: usize) -> &MetricReference {
        &self.requests.as_slice()[index]
    }

    fn kind(&self, index: usize) -> Option<&MetricKind> {
        self.reference(index).known().map(|metric| &metric.kind)
    }

    /// Indices of the metrics to chart: the usual ones and those of criteria.
    fn charted(&self) -> Vec<usize> {
        let usual = |reference: &MetricReference| {
            let name = reference.name();
            let plain = reference.settings.0.is_empty() && reference.pair.is_none();
            plain && (FLAGS.contains(&name) || QUANTITIES.contains(&name))
        };
        let wanted = |reference: &MetricReference| {
            let mut criteria = self.report.trials.iter().flat_map(|trial| trial.trial.criteria.iter());
            usual(reference) || criteria.any(|criterion| criterion.claim.metric() == reference)
        };
        let all = self.requests.iter().enumerate();
        all.filter(|(_, reference)| wanted(reference)).map(|(index, _)| index).collect()
    }

    fn quantity(&self, index: usize) -> AxisQuantity {
        let reference = self.reference(index);
        let unit = match self.notation(index) {
            Some(written) => written.symbol.to_string(),
            None => reference.unit(),
        };
        AxisQuantity::new(reference.label(), unit)
    }

    /// The unit that the first of the criteria about a metric is written in: what its charts are drawn in.
    fn notation(&self, index: usize) -> Option<Notation> {
        let reference = self.reference(index);
        let criteria = self.report.trials.iter().flat_map(|trial| trial.trial.criteria.iter());
        written_unit(criteria, reference, reference.known()?)
    }

    fn first(&self, outcome: &Outcome) -> First {
        let is_it = |reference: &MetricReference| {
            reference.name() == "passed_first" && reference.settings.0.is_empty() && reference.pair.is_none()
        };
        let Some(index) = self.requests.iter().position(is_it) else { return First::of(None) };
        let word = match (outcome.metrics[index], self.kind(index)) {
            (Some(value), Some(MetricKind::Category(words))) => words.get(value as usize),
            _ => None,
        };
        First::of(word.map(|word| &**word))
    }

    fn strip(&self, name: String, trials: &[&TrialReport], index: usize) -> Strip {
        let outcomes = || trials.iter().flat_map(|trial| &trial.outcomes);
        let unit = self.notation(index);
        let mut values: Vec<f64> = outcomes().filter_map(|outcome| charted(outcome, index, unit)).collect();
        values.sort_by(f64::total_cmp);
        let dot = |outcome: &Outcome| {
            let value = charted(outcome, index, unit)?;
            // Only what is drawn is pointed at.
            let name = if is_drawn(&values, value) { outcome.key.clone() } else { String::new() };
            Some(Dot { value, first: self.first(outcome), name, is_run: true })
        };
        let dots: Vec<Dot> = outcomes().filter_map(dot).collect();
        Strip { name, undefined: outcomes().count() - dots.len(), dots }
    }

    /// The bounds that the criteria of `trials` compare single runs to.
    fn rules(&self, trials: &[&TrialReport], index: usize) -> Vec<Rule> {
        let unit = self.notation(index);
        let mut rules: Vec<(f64, Rule)> = Vec::new();
        for criterion in trials.iter().flat_map(|trial| trial.trial.criteria.iter()) {
            let comparison = match &criterion.claim {
                Claim::Runs { comparison, .. } => comparison,
                Claim::Aggregate {
                    aggregate: Aggregate::Rate(comparison) | Aggregate::Count(comparison),
                    ..
                } => comparison,
                Claim::Aggregate { .. } => continue,
            };
            if let Expression::Constant(Value::Number(bound)) = &comparison.bound
                && comparison.metric == *self.reference(index)
                && !rules.iter().any(|(known, _)| known == bound)
            {
                rules.push((*bound, comparison_rule(comparison, unit)));
            }
        }
        // Bounds that change from trial to trial would only clutter the chart.
        if rules.len() > 3 { Vec::new() } else { rules.into_iter().map(|(_, rule)| rule).collect() }
    }

    /// Figure (a): rates against the variation, one line per scenario.
    fn rates(&self, charted: &[usize]) -> Option<Figure> {
        let variable = self.variable.as_ref()?;
        let chart = |index: &usize| {
            let mut lines: BTreeMap<(usize, String), Vec<Rate>> = BTreeMap::new();
            for (place, (_, trials)) in self.scenarios.iter().enumerate() {
                for trial in trials.iter().filter(|trial| !trial.outcomes.is_empty()) {
                    let variation = &trial.trial.variation;
                    let Some(x) = variable.value(variation) else { continue };
                    let values: Vec<f64> =
                        trial.outcomes.iter().filter_map(|outcome| outcome.metrics[*index]).collect();
                    let holding = values.iter().filter(|value| **value != 0.0).count();
                    let line = lines.entry((place, variable.others(variation))).or_default();
                    line.push(Rate { x, holding, runs: values.len() });
                }
            }
            let name = |(place, others): (usize, String)| {
                format!("{} {others}", self.scenarios[place].0).trim_end().to_string()
            };
            let mut series: Vec<RateSeries> = Vec::new();
            // A sampled variation has no rates: every value is another one.
            for (key, mut rates) in lines.into_iter().filter(|(_, rates)| rates.len() <= MOST_STRIPS) {
                rates.sort_by(|left, right| left.x.total_cmp(&right.x));
                series.push(RateSeries { name: name(key), rates });
            }
            Rates { title: self.reference(*index).label(), x: variable.quantity.clone(), series, rule: None }
        };
        let flags = charted.iter().filter(|index| self.kind(**index) == Some(&MetricKind::Flag));
        let charts: Vec<Rates> = flags.map(chart).collect();
        let series = &charts.first()?.series;
        if series.is_empty() || series.len() > MOST_SERIES {
            return None;
        }
        Some(Figure {
            title: format!("Rates against {}", variable.quantity.name),
            note: "Share of the runs in which it happened, with 95 % intervals after Clopper and Pearson. Overlapping lines are moved apart \
                   sideways."
                .into(),
            legend: charts[0].legend(),
            panels: charts.iter().map(Rates::to_svg).collect(),
        })
    }

    /// Figure (b): the distribution of a metric per scenario and variation, with its criterion's line.
    fn distributions(&self, index: usize) -> Option<Figure> {
        let quantity = self.quantity(index);
        let mut charts = Vec::new();
        for (name, trials) in &self.scenarios {
            let ran: Vec<_> = trials.iter().copied().filter(|trial| !trial.outcomes.is_empty()).collect();
            if ran.is_empty() || ran.len() > MOST_STRIPS {
                continue;
            }
            // A single strip stands beside those of the other scenarios.
            if trials.len() == 1 && self.scenarios.len() > 1 {
                continue;
            }
            let strip = |trial: &&TrialReport| {
                let name = short_name(trial);
                self.strip(if name.is_empty() { "all runs".into() } else { name }, &[*trial], index)
            };
            let variation = &ran[0].trial.variation;
            let names: Vec<_> = variation.iter().map(|one| one.name.as_str()).collect();
            charts.push(Strips {
                title: name.to_string(),
                x: names.join(", "),
                y: quantity.clone(),
                strips: ran.iter().map(strip).collect(),
                rules: self.rules(&ran, index),
                range: None,
            });
        }
        strips_figure(format!("{} per scenario and variation", quantity.name), charts)
    }

    /// Figure (e): the distribution of a metric per condition, every scenario being one.
    fn conditions(&self, index: usize) -> Option<Figure> {
        if self.scenarios.len() < 2 {
            return None;
        }
        let strips: Vec<Strip> =
            self.scenarios.iter().map(|(name, trials)| self.strip(name.to_string(), trials, index)).collect();
        let all: Vec<_> = self.report.trials.iter().collect();
        let (title, rules) = ("all runs of each scenario".to_string(), self.rules(&all, index));
        let quantity = self.quantity(index);
        let name = format!("{} per scenario", quantity.name);
        if strips.len() <= MOST_BESIDE {
            let y = quantity;
            return strips_figure(
                name,
                vec![Strips { title, x: String::new(), y, strips, rules, range: None }],
            );
        }
        let firsts: Vec<First> = strips.iter().flat_map(|strip| &strip.dots).map(|dot| dot.first).collect();
        if firsts.is_empty() {
            return None;
        }
        let range = Strips::range(&strips, &rules);
        let each = strips.len().div_ceil(strips.len().div_ceil(MOST_STRIPS));
        let chart = |part: &[Strip]| Rows {
            title: title.clone(),
            x: quantity.clone(),
            strips: part.to_vec(),
            rules: rules.clone(),
            range,
        };
        let panels = strips.chunks(each).map(|part| chart(part).to_svg()).collect();
        Some(Figure { title: name, note: STRIPS_NOTE.into(), legend: legend(firsts), panels })
    }

    /// Figure (d): each individual's worst value against the variation's value that it was found at; where a variation
    /// is sampled, every run.
    fn individuals(&self, index: usize) -> Option<Figure> {
        let variable = self.variable.as_ref()?;
        let metric = self.reference(index).known()?;
        let unit = self.notation(index);
        let mut charts = Vec::new();
        let (mut tied, mut left_out) = (0, 0);
        for (name, trials) in &self.scenarios {
            let mut found: Vec<FoundDot> = Vec::new();
            let mut people: BTreeMap<String, Vec<FoundDot>> = BTreeMap::new();
            let runs = trials
                .iter()
                .flat_map(|trial| trial.outcomes.iter().map(|outcome| (&trial.trial.variation, outcome)));
            for (variation, outcome) in runs {
                let (Some(x), Some(y)) = (variable.value(variation), charted(outcome, index, unit)) else {
                    continue;
                };
                let (first, name) = (self.first(outcome), outcome.key.clone());
                let point = FoundDot { x, y, first, name, is_run: true };
                match person(outcome) {
                    nobody if nobody.is_empty() => found.push(point),
                    person => people.entry(person).or_default().push(point),
                }
            }
            if people.is_empty() && trials.len() <= MOST_STRIPS {
                continue;
            }
            for runs in people.into_values() {
                match worst(runs, metric.worst) {
                    Some(point) => found.push(point),
                    None => tied += 1,
                }
            }
            if found.is_empty() {
                continue;
            }
            left_out += thin_out(&mut found, metric.worst);
            charts.push(IndividualsChart {
                title: name.to_string(),
                x: variable.quantity.clone(),
                y: self.quantity(index),
                points: found,
                courses: Vec::new(),
                rules: self.rules(trials, index),
                ranges: None,
                logarithmic: false,
            });
        }
        // Seen against all values of the variation, not only those that are worst for somebody.
        let trials = self.report.trials.iter();
        let taken: Vec<f64> = trials.filter_map(|trial| variable.value(&trial.trial.variation)).collect();
        let ranges = (with_room(&taken), IndividualsChart::ranges(&charts).1);
        charts.iter_mut().for_each(|chart| chart.ranges = Some(ranges));
        let firsts = charts.iter().flat_map(|chart| &chart.points).map(|point| point.first).collect();
        let x = &variable.quantity.name;
        let mut note = format!(
            "One mark per individual: its worst run and the {x} that it was found at. Without individuals, one per run."
        );
        if tied > 0 {
            note +=
                &format!(" {tied} individuals have none: theirs is equally bad at several values of {x}.");
        }
        if left_out > 0 {
            note += &format!(
                " {left_out} more are not drawn: of every scenario there are the worst {} and others evenly.",
                MOST_POINTS / 2
            );
        }
        (!charts.is_empty()).then(|| Figure {
            title: format!("{} against {x}", self.quantity(index).name),
            note,
            legend: legend(firsts),
            panels: charts.iter().map(IndividualsChart::to_svg).collect(),
        })
    }

    /// Figure (c): trajectories in the distance-distance plane, one panel per scenario.
    fn courses(&self, recordings: &[Recording]) -> Option<Figure> {
        let drawn: BTreeSet<&str> = recordings.iter().map(|one| one.case.key.as_str()).collect();
        let outcomes: BTreeMap<&str, &Outcome> = self
            .report
            .trials
            .iter()
            .flat_map(|trial| &trial.outcomes)
            .filter(|outcome| drawn.contains(outcome.key.as_str()))
            .map(|outcome| (outcome.key.as_str(), outcome))
            .collect();
        let mut charts = Vec::new();
        for (name, _) in &self.scenarios {
            let mut paths = Vec::new();
            for recording in recordings.iter().filter(|one| one.case.scenario == *name) {
                let Some(outcome) = outcomes.get(recording.case.key.as_str()) else { continue };
                let first = self.first(outcome);
                paths.extend(recording.pairs().into_iter().map(|pair| ChartPath {
                    points: pair.points,
                    first,
                    name: recording.case.key.clone(),
                }));
            }
            if !paths.is_empty() {
                charts.push(Paths { title: name.to_string(), paths, ranges: None });
            }
        }
        let all: Vec<&ChartPath> = charts.iter().flat_map(|chart| &chart.paths).collect();
        let ranges = Paths::ranges(all.iter().copied());
        let entries = Paths::legend(all);
        for chart in &mut charts {
            chart.ranges = Some(ranges);
        }
        (!charts.is_empty()).then(|| Figure {
            title: "Trajectories".into(),
            note: "Each line is a run: where the pedestrian is while the vehicle is there, both in metres from the \
                   conflict point and negative before it. Lines above the cross are runs in which the pedestrian passes \
                   first; through the cross, both are there at once."
                .into(),
            legend: entries,
            panels: charts.iter().map(Paths::to_svg).collect(),
        })
    }
}

/// A run's value of a metric in a unit, or in the SI unit.
fn charted(outcome: &Outcome, index: usize, unit: Option<Notation>) -> Option<f64> {
    outcome.metrics[index].map(|value| unit.map_or(value, |unit| unit.of_si(value)))
}

/// Leaves as many points as a person can tell apart: the worst, and of the others every so-manieth. Returns how many went.
fn thin_out(points: &mut Vec<FoundDot>, worst: Worst) -> usize {
    let all = points.len();
    if all <= MOST_POINTS {
        return 0;
    }
    let badness = |index: &usize| {
        let y = points[*index].y;
        if worst == Worst::Smallest { y } else { -y }
    };
    let mut order: Vec<usize> = (0..all).collect();
    order.sort_by(|left, right| badness(left).total_cmp(&badness(right)));
    let mut rest = order.split_off(MOST_POINTS / 2);
    // In the order of the runs, which is that of the variations.
    rest.sort_unstable();
    let wanted = MOST_POINTS - order.len();
    order.extend((0..wanted).map(|place| rest[place * rest.len() / wanted]));
    let kept: BTreeSet<usize> = order.into_iter().collect();
    let mut index = 0;
    points.retain(|_| {
        index += 1;
        kept.contains(&(index - 1))
    });
    all - points.len()
}

/// Strips side by side on one scale.
fn strips_figure(title: String, mut charts: Vec<Strips>) -> Option<Figure> {
    charts.retain(|chart| chart.strips.iter().any(|strip| !strip.dots.is_empty()));
    let strips = charts.iter().flat_map(|chart| &chart.strips);
    let range = Strips::range(strips, charts.iter().flat_map(|chart| &chart.rules));
    let firsts: Vec<First> = charts.iter().flat_map(Strips::firsts).collect();
    charts.iter_mut().for_each(|chart| chart.range = Some(range));
    (!charts.is_empty()).then(|| Figure {
        title,
        note: STRIPS_NOTE.into(),
        legend: legend(firsts),
        panels: charts.iter().map(Strips::to_svg).collect(),
    })
}

/// Nothing where all look the same because nobody asked who passed first.
fn legend(firsts: Vec<First>) -> Vec<LegendEntry> {
    if firsts.iter().all(|first| *first == First::Neither) {
        return Vec::new();
    }
    first_legend(firsts, false)
}

fn person(outcome: &Outcome) -> String {
    let people =
        outcome.individuals.iter().map(|one| format!("{}={}:{}", one.pedestrian, one.population, one.number));
    people.collect::<Vec<_>>().join("+")
}

/// The worst of somebody's runs; `None` where runs at different places are equally bad.
fn worst(runs: Vec<FoundDot>, worst: Worst) -> Option<FoundDot> {
    let badness = |run: &FoundDot| if worst == Worst::Smallest { -run.y } else { run.y };
    let most = runs.iter().map(badness).max_by(f64::total_cmp)?;
    let mut worst = runs.into_iter().filter(|run| badness(run) == most);
    let first = worst.next()?;
    worst.all(|other| other.x == first.x).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinned_points_keep_the_worst_and_say_how_many_go() {
        let point = |index: usize| FoundDot {
            x: index as f64,
            y: ((index * 7919) % 10_007) as f64,
            first: First::Neither,
            name: String::new(),
            is_run: false,
        };
        let mut points: Vec<FoundDot> = (0..10_000).map(point).collect();
        let worst = |points: &[FoundDot]| points.iter().map(|one| one.y).fold(f64::INFINITY, f64::min);
        let least = worst(&points);
        assert_eq!(thin_out(&mut points, Worst::Smallest), 10_000 - MOST_POINTS);
        assert_eq!((points.len(), worst(&points)), (MOST_POINTS, least));
        assert!(points.is_sorted_by(|left, right| left.x < right.x), "in their order");
        assert_eq!(thin_out(&mut points, Worst::Largest), 0);
    }
}
