//! A `tune` on the page: what was chosen, what it changes, and how the optimiser came to it.

use serde::Serialize;

use super::figure::HtmlFigure;
use super::space::{MeasuredQuantity, SpaceDimension, point_text};
use crate::chart::{AxisQuantity, Convergence, Front, PointMark, Rule, Slice, Tried};
use crate::experiment::{against_declared, tuned_parameters, untested_constraints};
use crate::format::{capitalised, share};
use crate::wording::comparison_text;
use optimise::OptimisationEnd;
use results::{BeforeAndAfter, Candidate, CandidateOrigin, MetricSummary, TuneResult, Violations};
use scenario::{MetricKind, MetricReference, ShownIn, Tune};

/// Charts of margins that are seen at once.
const OPEN_MARGINS: usize = 6;

#[derive(Debug, Serialize)]
pub struct TuneSection {
    sentences: Vec<String>,
    /// The chosen parameters as a scenario can use them.
    parameters: Option<String>,
    /// What is left of the constraints with fresh seeds; `None` without constraints.
    fresh: Option<FreshSeeds>,
    comparison: Option<Table>,
    candidates: Candidates,
    figures: Vec<HtmlFigure>,
}

#[derive(Debug, Serialize)]
struct FreshSeeds {
    passed: bool,
    text: String,
}

/// Before and after.
#[derive(Debug, Serialize)]
struct Table {
    /// What the tune is about.
    main: Vec<Line>,
    /// Every other metric.
    others: Vec<Line>,
}

/// A metric before and after, then on fresh seeds.
#[derive(Debug, Serialize)]
struct Line {
    metric: String,
    cells: Vec<SummaryCell>,
}

#[derive(Debug, Serialize)]
struct SummaryCell {
    mean: String,
    /// From the smallest to the largest, where they differ.
    range: String,
}

#[derive(Debug, Serialize)]
struct Candidates {
    headings: Vec<String>,
    rows: Vec<CandidateRow>,
}

#[derive(Debug, Serialize)]
struct CandidateRow {
    number: usize,
    cells: Vec<String>,
    state: String,
}

/// One tune with what its charts share.
struct Bench<'a> {
    tune: &'a Tune,
    result: &'a TuneResult,
    objectives: Vec<MeasuredQuantity>,
    constraints: Vec<MeasuredQuantity>,
    dimensions: Vec<SpaceDimension>,
}

impl TuneSection {
    pub fn new(tune: &Tune, result: &TuneResult) -> Self {
        let bench = Bench::new(tune, result);
        Self {
            sentences: bench.sentences(),
            parameters: result.chosen.as_ref().map(|_| tuned_parameters(result, tune)),
            fresh: bench.fresh(),
            comparison: result.comparison.as_ref().map(|comparison| bench.comparison(comparison)),
            candidates: bench.candidates(),
            figures: bench.figures(),
        }
    }

    /// What it came to, in a line.
    pub fn summary(tune: &Tune, result: &TuneResult) -> String {
        let bench = Bench::new(tune, result);
        match (&result.chosen, result.pareto.len()) {
            (Some(chosen), _) => match &result.violations {
                None if result.keeps_declared() => {
                    format!("nothing better than what is declared: {}", bench.told(chosen))
                }
                None => bench.told(chosen),
                Some(Violations { runs, of }) => {
                    format!("infeasible, violated in {runs} of {of} runs: {}", bench.told(chosen))
                }
            },
            (None, 0) => result.nothing_chosen().unwrap_or_default().to_string(),
            (None, _) => format!("{} on the front", bench.front_words()),
        }
    }
}

impl<'a> Bench<'a> {
    fn new(tune: &'a Tune, result: &'a TuneResult) -> Self {
        Self {
            tune,
            result,
            objectives: tune.objectives.iter().map(MeasuredQuantity::objective).collect(),
            constraints: tune
                .constraints
                .iter()
                .enumerate()
                .map(|(index, one)| {
                    MeasuredQuantity::metric(&one.metric).written_in(tune.constraint_in(index))
                })
                .collect(),
            dimensions: SpaceDimension::all(&tune.over),
        }
    }

    /// Such as `braking_distance 12 m gives mean(time_lost) 0.2 s`.
    fn told(&self, candidate: &Candidate) -> String {
        let values = self.objectives.iter().zip(&candidate.objectives);
        let values: Vec<_> =
            values.map(|(one, value)| format!("{} {}", one.name, one.text(*value))).collect();
        let point = match candidate.point.is_empty() {
            true => "what is declared".to_string(),
            false => point_text(&self.dimensions, &candidate.point),
        };
        format!("{point} gives {}", values.join(", "))
    }

    fn fresh(&self) -> Option<FreshSeeds> {
        let result = self.result;
        if result.fresh_violations.is_empty() {
            return None;
        }
        Some(match result.broken_on_fresh_words() {
            None => {
                let which = match result.chosen {
                    Some(_) => "The chosen candidate",
                    None => "Every candidate on the front",
                };
                FreshSeeds {
                    passed: true,
                    text: format!("✓ {which} keeps every constraint on the fresh seeds, too."),
                }
            }
            Some(broken) => FreshSeeds { passed: false, text: format!("✗ {}.", capitalised(&broken)) },
        })
    }

    fn sentences(&self) -> Vec<String> {
        let Self { tune, result, .. } = self;
        let objectives: Vec<_> = tune.objectives.iter().map(|one| one.text.as_str()).collect();
        let ranges: Vec<_> = self.dimensions.iter().map(SpaceDimension::range).collect();
        let cases = if result.cases == 1 { "one case".into() } else { format!("{} cases", result.cases) };
        let mut first = format!("Over {cases}: {}, for {}", objectives.join(" and "), ranges.join(", "));
        if !tune.constraints.is_empty() {
            first += &format!(", subject to {} in every run", self.constraints_in_words().join(", "));
        }
        let evaluations = result.evaluations.len();
        let ended = match result.stop {
            Some(OptimisationEnd::NoExpectedImprovement { .. }) => {
                ", after which nothing better was expected"
            }
            Some(OptimisationEnd::GridComplete { .. }) => ", the whole grid",
            Some(OptimisationEnd::Budget { .. }) | None => "",
        };
        let mut sentences = vec![first + "."];
        let feasible = result.evaluations.iter().filter(|candidate| candidate.feasible).count();
        sentences.push(match tune.constraints.is_empty() {
            true => format!("{evaluations} candidates were evaluated{ended}."),
            false => format!("{feasible} of {evaluations} candidates are feasible{ended}."),
        });
        if let Some(violations) = &result.violations {
            sentences.push(format!("The chosen candidate is {violations}."));
        }
        sentences.push(match &result.chosen {
            Some(chosen) => {
                let margins = self.constraints.iter().zip(&chosen.margins);
                let margins: Vec<_> =
                    margins.map(|(one, value)| format!("{} {}", one.name, one.text(*value))).collect();
                let margins = match margins.as_slice() {
                    [] => String::new(),
                    all => format!("; the smallest margins are {}", all.join(", ")),
                };
                format!("Chosen: {}{margins}.", self.told(chosen))
            }
            None => match result.nothing_chosen() {
                Some(why) => capitalised(why) + ".",
                None => format!("The front: {}.", self.front_words()),
            },
        });
        if result.chosen.is_some() {
            sentences.push(capitalised(&against_declared(result)) + ".");
        }
        sentences.extend(untested_constraints(result).iter().map(|why| format!("⚠ {why}.")));
        sentences
    }

    /// Candidates that give the same are one point of the front.
    fn front_words(&self) -> String {
        let mut points: Vec<&[Option<f64>]> = Vec::new();
        for candidate in &self.result.pareto {
            if !points.contains(&candidate.objectives.as_slice()) {
                points.push(&candidate.objectives);
            }
        }
        match (self.result.pareto.len(), points.len()) {
            (1, _) => "one candidate".to_string(),
            (candidates, points) if points < candidates => {
                format!("{candidates} candidates at {points} points")
            }
            (candidates, _) => format!("{candidates} candidates"),
        }
    }

    fn comparison(&self, comparison: &BeforeAndAfter) -> Table {
        let about = self.tune.objectives.iter().map(|one| one.aggregate.metric());
        let about = about.chain(self.tune.constraints.iter().map(|one| &one.metric));
        let about: Vec<String> = about.map(MetricReference::label).collect();
        let tables =
            [&comparison.before, &comparison.after, &comparison.before_fresh, &comparison.after_fresh];
        let line = |(index, summary): (usize, &MetricSummary)| Line {
            metric: summary.metric.clone(),
            cells: tables.map(|table| SummaryCell::new(&table[index], comparison.shown_in.get(index))).into(),
        };
        let lines = comparison.before.iter().enumerate().map(line);
        let (main, others) = lines.partition(|line: &Line| about.contains(&line.metric));
        Table { main, others }
    }

    fn constraints_in_words(&self) -> Vec<String> {
        let constraints = self.tune.constraints.iter().enumerate();
        constraints.map(|(index, one)| comparison_text(one, self.tune.constraint_in(index))).collect()
    }

    fn candidates(&self) -> Candidates {
        let headings = self.dimensions.iter().map(|one| one.quantity().label());
        let headings = headings.chain(self.objectives.iter().map(MeasuredQuantity::heading));
        let constraints = self.constraints_in_words().into_iter();
        let margins = constraints.map(|constraint| format!("margin of {constraint}"));
        let row = |(index, candidate): (usize, &Candidate)| {
            let point = self.dimensions.iter().enumerate().map(|(index, one)| {
                candidate.point.get(index).map_or_else(|| "declared".to_string(), |value| one.number(value))
            });
            let values = self.objectives.iter().zip(&candidate.objectives);
            let margins = self.constraints.iter().zip(&candidate.margins);
            let numbers = values.chain(margins).map(|(one, value)| one.number(*value));
            CandidateRow {
                number: index + 1,
                cells: point.chain(numbers).collect(),
                state: self.state(index, candidate),
            }
        };
        Candidates {
            headings: headings.chain(margins).collect(),
            rows: self.result.evaluations.iter().enumerate().map(row).collect(),
        }
    }

    /// The state of a candidate, and its source unless that is the method.
    fn state(&self, index: usize, candidate: &Candidate) -> String {
        let state = match self.mark(index, candidate) {
            PointMark::Best if !candidate.feasible => "chosen, infeasible",
            PointMark::Best if self.result.chosen.is_some() => "chosen",
            PointMark::Best => "on the front",
            PointMark::Refused => "infeasible",
            PointMark::Initial | PointMark::Proposed => "feasible",
        };
        match candidate.origin {
            CandidateOrigin::Declared => format!("{state}, declared"),
            CandidateOrigin::Tried => format!("{state}, tried"),
            CandidateOrigin::Method => state.to_string(),
        }
    }

    /// Candidates before the first one that the method chose: those that were given, and its initial points.
    fn initial(&self) -> usize {
        let given =
            self.result.evaluations.iter().filter(|one| one.origin != CandidateOrigin::Method).count();
        given + self.tune.budget.initial as usize
    }

    fn mark(&self, index: usize, candidate: &Candidate) -> PointMark {
        let best = self.result.chosen.iter().chain(&self.result.pareto);
        match candidate {
            _ if best.into_iter().any(|best| best == candidate) => PointMark::Best,
            _ if !candidate.feasible => PointMark::Refused,
            _ if index < self.initial() => PointMark::Initial,
            _ => PointMark::Proposed,
        }
    }

    fn best_label(&self) -> &'static str {
        if self.result.chosen.is_some() { "chosen" } else { "on the front" }
    }

    fn figures(&self) -> Vec<HtmlFigure> {
        let mut figures = Vec::new();
        figures.extend(self.front());
        figures.extend(self.convergence());
        figures.extend(self.slices());
        figures.extend(self.margins());
        figures
    }

    /// Every candidate along a dimension, or by its number, with one of its values.
    fn tried(&self, along: Option<usize>, value: impl Fn(&Candidate) -> Option<f64>) -> Vec<Tried> {
        let tried = |(index, candidate): (usize, &Candidate)| {
            let x = match along {
                Some(dimension) => {
                    self.dimensions[dimension].place_within(candidate.point.get(dimension)?)?
                }
                None => (index + 1) as f64,
            };
            Some(Tried { x, y: value(candidate), mark: self.mark(index, candidate) })
        };
        self.result.evaluations.iter().enumerate().filter_map(tried).collect()
    }

    fn charted(&self, objective: usize) -> impl Fn(&Candidate) -> Option<f64> {
        let of = self.objectives[objective].clone();
        move |candidate| candidate.objectives[objective].map(|value| of.charted(value))
    }

    fn front(&self) -> Option<HtmlFigure> {
        let [x, y, ..] = self.objectives.as_slice() else { return None };
        let (along, up) = (self.charted(0), self.charted(1));
        let candidates = self.result.evaluations.iter().enumerate();
        let tried = |(index, one): (usize, &Candidate)| Some((along(one)?, up(one)?, self.mark(index, one)));
        let chart = Front {
            title: self.tune.name.clone(),
            x: x.quantity(),
            y: y.quantity(),
            goals: (self.tune.objectives[0].direction, self.tune.objectives[1].direction),
            tried: candidates.filter_map(tried).collect(),
        };
        let goals: Vec<_> = self.tune.objectives.iter().map(|one| one.text.as_str()).collect();
        let note = format!("Both objectives of every candidate: {}.", goals.join(" and "));
        Some(HtmlFigure::new("Front", note, vec![chart.to_svg()]).with_legend(chart.legend()))
    }

    fn convergence(&self) -> Option<HtmlFigure> {
        if self.result.evaluations.is_empty() || self.objectives.len() > 1 {
            return None;
        }
        let initial = self.initial();
        let mut tried = self.tried(None, self.charted(0));
        if self.result.violations.is_some() {
            // Nothing is the best so far where nothing is feasible.
            tried.iter_mut().for_each(|one| one.mark = PointMark::Refused);
        }
        let chart = Convergence {
            title: self.tune.name.clone(),
            y: self.objectives[0].quantity(),
            goal: self.tune.objectives[0].direction,
            tried,
            initial,
        };
        let note = format!("The dotted line stands after the {initial} points that come first.");
        let legend = chart.legend(self.best_label());
        Some(HtmlFigure::new("Convergence", note, vec![chart.to_svg()]).with_legend(legend))
    }

    fn slices(&self) -> Option<HtmlFigure> {
        let mut slices = Vec::new();
        for (objective, measured) in self.objectives.iter().enumerate() {
            for (index, dimension) in self.dimensions.iter().enumerate() {
                // There are surrogate slices of a single objective only.
                let slice = self.result.slices.get(index).filter(|_| self.objectives.len() == 1);
                slices.push(Slice {
                    title: measured.name.clone(),
                    x: dimension.quantity(),
                    along: dimension.along.clone(),
                    y: measured.quantity(),
                    beliefs: slice.map(|slice| dimension.beliefs(slice, measured)).unwrap_or_default(),
                    tried: self.tried(Some(index), self.charted(objective)),
                    rules: Vec::new(),
                    range: None,
                });
            }
        }
        if self.result.evaluations.is_empty() {
            return None;
        }
        let mut note = if slices.iter().any(|slice| !slice.beliefs.is_empty()) {
            "What the surrogate believes after the last evaluation, with every candidate.".to_string()
        } else {
            "Every candidate.".to_string()
        };
        if self.dimensions.len() > 1 {
            note += " Each chart is a slice through the chosen point: points whose other values differ lie off it.";
        }
        let legend = Slice::legend(&slices, self.best_label());
        let panels = slices.iter().map(Slice::to_svg).collect();
        Some(HtmlFigure::new("Surrogate", note, panels).with_legend(legend))
    }

    fn margins(&self) -> Option<HtmlFigure> {
        let mut slices = Vec::new();
        for (which, constraint) in self.constraints_in_words().iter().enumerate() {
            let measured = &self.constraints[which];
            let margin =
                |candidate: &Candidate| candidate.margins[which].map(|value| measured.charted(value));
            let y = AxisQuantity::new("margin", measured.quantity().unit);
            for (index, dimension) in self.dimensions.iter().enumerate() {
                slices.push(Slice {
                    title: constraint.clone(),
                    x: dimension.quantity(),
                    along: dimension.along.clone(),
                    y: y.clone(),
                    beliefs: Vec::new(),
                    tried: self.tried(Some(index), margin),
                    rules: vec![Rule { value: 0.0, label: "violated below".into() }],
                    range: None,
                });
            }
        }
        if slices.is_empty() || self.result.evaluations.is_empty() {
            return None;
        }
        let mut note = "How far the worst run of every candidate is from violating a constraint.".to_string();
        if self.tune.early_stop {
            note += " A candidate ends at its first violation, so that its margin is that of the runs until then.";
        }
        let legend = Slice::legend(&slices, self.best_label());
        let panels = slices.iter().map(Slice::to_svg).collect();
        let figure = HtmlFigure::new("Margins of the constraints", note, panels).with_legend(legend);
        Some(figure.folded(OPEN_MARGINS, |count| format!("{count} more")))
    }
}

impl SummaryCell {
    /// Of results that do not say how it is shown, in the SI unit.
    fn new(summary: &MetricSummary, shown_in: Option<&ShownIn>) -> Self {
        if let Some(MetricKind::Flag) = &summary.kind {
            let mean = summary.mean.map_or("–".to_string(), share);
            return Self { mean, range: String::new() };
        }
        let unit = match &summary.kind {
            Some(MetricKind::Quantity(dimension)) => dimension.si_unit(),
            _ => String::new(),
        };
        let shown_in = shown_in.cloned().unwrap_or_else(|| ShownIn::new(None, &unit));
        let Some(mean) = summary.mean else { return Self { mean: "–".into(), range: String::new() } };
        let mut range = match (summary.min, summary.max) {
            (Some(min), Some(max)) if min < max => {
                format!("{} to {}", shown_in.rounded(min, 3), shown_in.rounded(max, 3))
            }
            _ => String::new(),
        };
        if summary.defined < summary.runs {
            range += &format!(" in {} of {} runs", summary.defined, summary.runs);
        }
        Self { mean: shown_in.show(mean), range: range.trim_start().to_string() }
    }
}
