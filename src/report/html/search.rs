//! A `search` on the page: what it found for whom, how it got there, and what its surrogates believe.

use serde::Serialize;

use super::figure::HtmlFigure;
use super::space::{MeasuredQuantity, SpaceDimension, point_text, sign};
use super::usual::UsualSection;
use crate::chart::{
    self, Along, Convergence, Convergences, CourseLine, Dot, First, IndividualsChart, LegendEntry, Look,
    PointMark, Slice, Strip, Strips, Tried, first_legend, with_room,
};
use crate::format::capitalised;
use crate::found::{left_out_words, said};
use crate::usual::tail_text;
use crate::wording::{keep_text, verdict_mark};
use numbers::summary::mean;
use optimise::{Coordinate, OptimisationEnd};
use results::{Found, JudgedRun, JudgedSearch, SearchResult, SuiteReport, Verdict};
use scenario::Search;

/// Charts of surrogates that are seen at once, and all that are drawn.
const OPEN_SLICES: usize = 6;
const MOST_SLICES: usize = 120;
/// Charts of where the worst lies: one per dimension.
const MOST_PLACES: usize = 6;
/// A longer table scrolls.
const LONG_TABLE: usize = 30;
/// Judged runs that are listed.
const MOST_JUDGED: usize = 50;

#[derive(Debug, Serialize)]
pub struct SearchSection {
    /// How bad encounters are against how usual; what people look at first.
    usual: Option<UsualSection>,
    sentences: Vec<String>,
    dimensions: Vec<String>,
    objective: String,
    /// Whether there is a condition to be kept.
    keeps: bool,
    /// Whether of somebody it is known how usual they are.
    plausible: bool,
    /// What the search expects of the runs that it kept.
    judged: Option<Judged>,
    rows: Vec<Row>,
    long: bool,
    figures: Vec<HtmlFigure>,
}

/// Runs that a search judges, those that did not pass first.
#[derive(Debug, Serialize)]
struct Judged {
    heading: String,
    runs: Vec<JudgedRow>,
    more: usize,
}

#[derive(Debug, Serialize)]
struct JudgedRow {
    mark: &'static str,
    criteria: Vec<String>,
    /// In how many runs with fresh seeds all of it holds.
    fresh: String,
    replay: String,
}

impl Judged {
    fn new(report: &SuiteReport, judged: &JudgedSearch) -> Self {
        let mut runs: Vec<&JudgedRun> = judged.runs.iter().collect();
        runs.sort_by_key(|run| std::cmp::Reverse(run.verdict()));
        let row = |run: &&JudgedRun| JudgedRow {
            mark: verdict_mark(run.verdict()),
            criteria: run.findings.iter().map(said).collect(),
            fresh: format!("{} of {}", run.fresh_holding, run.fresh_runs),
            replay: report.identity.replay_command(&run.key),
        };
        Self {
            heading: match (runs.is_empty(), judged.of_kept) {
                (true, _) => format!("{}.", capitalised(judged.nothing())),
                (_, true) => "Expected of every run that was kept:".to_string(),
                (_, false) => "Nothing was kept. Expected of the best observed runs:".to_string(),
            },
            runs: runs.iter().take(MOST_JUDGED).map(row).collect(),
            more: runs.len().saturating_sub(MOST_JUDGED),
        }
    }
}

/// What was found for one person, or for all of them.
#[derive(Debug, Serialize)]
struct Row {
    who: String,
    kept: bool,
    place: Vec<String>,
    observed: String,
    predicted: String,
    fresh: String,
    first: String,
    plausibility: String,
    evaluations: usize,
    stop: &'static str,
}

/// One search with what its charts share.
struct Hunt<'a> {
    search: &'a Search,
    objective: MeasuredQuantity,
    dimensions: Vec<SpaceDimension>,
    /// The worst first.
    found: Vec<&'a Found>,
}

impl SearchSection {
    pub fn new(report: &SuiteReport, search: &Search, result: &SearchResult) -> Self {
        let sign = sign(search.objective.direction);
        let mut found: Vec<&Found> = result.found.iter().collect();
        let rank = |one: &Found| one.observed.map_or(f64::INFINITY, |value| sign * value);
        found.sort_by(|left, right| rank(left).total_cmp(&rank(right)));
        let hunt = Hunt {
            search,
            objective: MeasuredQuantity::objective(&search.objective),
            dimensions: SpaceDimension::all(&search.over),
            found,
        };
        Self {
            usual: UsualSection::new(report, search, result),
            sentences: hunt.sentences().into_iter().chain(left_out_words(result)).collect(),
            dimensions: hunt.dimensions.iter().map(|one| one.quantity().label()).collect(),
            objective: hunt.objective.heading(),
            keeps: !search.keep.is_empty(),
            judged: result.judged.as_ref().map(|judged| Judged::new(report, judged)),
            plausible: result.found.iter().any(|found| found.plausibility.is_some()),
            rows: hunt.found.iter().map(|found| hunt.row(found)).collect(),
            long: hunt.found.len() > LONG_TABLE,
            figures: hunt.figures(),
        }
    }

    /// What it came to, in a line.
    pub fn summary(search: &Search, result: &SearchResult) -> String {
        let hunted = result.found.len();
        let kept = result.found.iter().filter(|found| found.kept.contains(&true)).count();
        let with_value = result.found.iter().filter_map(|found| found.observed);
        let sign = sign(search.objective.direction);
        let worst = with_value.min_by(|left, right| (sign * left).total_cmp(&(sign * right)));
        let worst = MeasuredQuantity::objective(&search.objective).text(worst);
        let judged = result.judged.as_ref().filter(|judged| !judged.runs.is_empty());
        let judged = judged.map_or_else(String::new, |judged| {
            let passed = judged.count(Verdict::Passed);
            format!("; {passed} of {} as expected", judged.runs.len())
        });
        match search.keep.is_empty() {
            false => format!("{kept} of {hunted} kept ({}); worst {worst}{judged}", keep_text(search)),
            true => format!("{hunted} found; worst {worst}{judged}"),
        }
    }
}

impl Hunt<'_> {
    fn sentences(&self) -> Vec<String> {
        let Self { search, found, .. } = self;
        let budget = &search.budget;
        let ranges: Vec<_> = self.dimensions.iter().map(SpaceDimension::range).collect();
        let whom = match found.len() {
            _ if search.together => "for everybody together".to_string(),
            1 => "for one individual".to_string(),
            count => format!("for each of {count} individuals"),
        };
        let mut sentences = vec![format!(
            "In {}, {whom}: {} over {}, with {} evaluations of {}, the first {} of them initial points.",
            search.scenario,
            search.objective.text,
            ranges.join(", "),
            budget.evaluations,
            runs(search.runs),
            budget.initial,
        )];
        if !search.keep.is_empty() {
            let kept = found.iter().filter(|one| one.kept.contains(&true)).count();
            sentences.push(format!("{kept} of {} are kept: {}.", found.len(), keep_text(search)));
        }
        if let Some((worst, point)) = found.first().and_then(|worst| Some((worst, worst.best.as_ref()?))) {
            let point: Vec<Coordinate> = point.iter().map(|(_, value)| value.clone()).collect();
            sentences.push(format!(
                "The worst is {} at {}{}.",
                self.objective.text(worst.observed),
                point_text(&self.dimensions, &point),
                if found.len() > 1 { format!(", {}", self.name(worst)) } else { String::new() }
            ));
        }
        sentences.extend(self.luck());
        sentences
    }

    /// How much of the observed values was luck.
    fn luck(&self) -> Option<String> {
        let both = self.found.iter().filter_map(|one| Some((one.observed?, one.fresh?)));
        let (observed, fresh): (Vec<f64>, Vec<f64>) = both.unzip();
        let (observed, fresh, count) = (mean(&observed)?, mean(&fresh)?, observed.len());
        let flattered = sign(self.search.objective.direction) * (fresh - observed);
        let told = if flattered > 0.0 { "less bad" } else { "worse" };
        let over = if count == 1 { String::new() } else { format!(", on average over {count}") };
        Some(format!(
            "What was observed at the worst points is {}; fresh runs there give {}{over}: {} {told}.",
            self.objective.text(Some(observed)),
            self.objective.text(Some(fresh)),
            self.objective.text(Some(flattered.abs())),
        ))
    }

    /// Such as `individual 17`.
    fn name(&self, found: &Found) -> String {
        match found.individuals.as_slice() {
            _ if self.search.together => "everybody".to_string(),
            [] => "all runs".to_string(),
            [one] => format!("individual {}", one.number),
            several => {
                let each: Vec<_> =
                    several.iter().map(|one| format!("{} {}", one.pedestrian, one.number)).collect();
                each.join(", ")
            }
        }
    }

    fn row(&self, found: &Found) -> Row {
        let place = match &found.best {
            Some(best) => {
                best.iter().zip(&self.dimensions).map(|((_, value), one)| one.number(value)).collect()
            }
            None => vec!["–".to_string(); self.dimensions.len()],
        };
        let number = |value| self.objective.number(value);
        Row {
            who: self.name(found).trim_start_matches("individual ").to_string(),
            kept: found.kept.contains(&true),
            place,
            observed: number(found.observed),
            predicted: found.predicted.map_or("–".into(), |(mean, deviation)| {
                format!("{} ± {}", self.objective.rough(mean, 3), self.objective.rough(deviation, 2))
            }),
            fresh: match found.fresh {
                Some(fresh) => format!("{} ({})", self.objective.rough(fresh, 3), found.fresh_runs),
                None => "–".into(),
            },
            first: found.passed_first.clone().unwrap_or_else(|| "–".into()),
            plausibility: found.plausibility.map_or_else(|| "–".into(), tail_text),
            evaluations: found.evaluations.len(),
            stop: match found.stop {
                Some(OptimisationEnd::Budget { .. }) => "budget spent",
                Some(OptimisationEnd::NoExpectedImprovement { .. }) => "nothing better expected",
                Some(OptimisationEnd::GridComplete { .. }) => "grid complete",
                None => "–",
            },
        }
    }

    fn figures(&self) -> Vec<HtmlFigure> {
        let mut figures = Vec::new();
        figures.extend(self.places());
        figures.extend(self.convergence());
        figures.extend(self.slices());
        figures
    }

    /// Each individual's worst value against where it was found: figure (d) of the founding paper.
    fn places(&self) -> Option<HtmlFigure> {
        if self.found.len() < 2 {
            return None;
        }
        let shown = self.dimensions.iter().enumerate().take(MOST_PLACES);
        let panels = shown.map(|(index, dimension)| match &dimension.along {
            Along::Words(words) => self.words(index, words).to_svg(),
            Along::Numbers { .. } | Along::Logarithmic { .. } => self.individuals(index).to_svg(),
        });
        let panels: Vec<String> = panels.collect();
        let courses = self.found.iter().filter(|one| !one.courses.is_empty()).count();
        let mut note =
            "One mark per individual: the worst value that was observed, and where it was found.".to_string();
        let mut legend = first_legend(self.found.iter().map(|one| first(one)), false);
        if courses > 0 {
            let runs = self.found.iter().flat_map(|one| &one.courses).flat_map(|course| &course.points);
            let runs = runs.map(|point| point.runs).max().unwrap_or(0);
            note += &format!(
                " Lines and bands: mean and range of {runs} fresh runs per value, for {courses} of those that are \
                 kept; the number names the individual."
            );
            let swatch = Look::series(chart::COURSES_FROM).belief_swatch();
            legend.push(LegendEntry { swatch, label: "a kept individual: mean and range".into() });
        }
        Some(HtmlFigure::new("Where it is worst", note, panels).with_legend(legend))
    }

    fn individuals(&self, index: usize) -> IndividualsChart {
        let dimension = &self.dimensions[index];
        let point = |found: &&Found| {
            Some(chart::FoundDot {
                x: dimension.place(&found.best.as_ref()?.get(index)?.1)?,
                y: self.objective.charted(found.observed?),
                first: first(found),
                name: self.name(found),
                is_run: false,
            })
        };
        let course = |found: &&Found| {
            let course = found.courses.iter().find(|course| course.over == dimension.full_name)?;
            let points =
                course.points.iter().map(|point| (point.at, point.smallest, point.mean, point.largest));
            let name = self.name(found).trim_start_matches("individual ").to_string();
            Some(CourseLine { name, points: points.collect() })
        };
        let mut chart = IndividualsChart {
            title: dimension.name.clone(),
            x: dimension.quantity(),
            y: self.objective.quantity(),
            points: self.found.iter().filter_map(point).collect(),
            courses: self.found.iter().filter_map(course).collect(),
            rules: self.objective.kept(self.search),
            ranges: None,
            logarithmic: matches!(dimension.along, Along::Logarithmic { .. }),
        };
        let across = match dimension.along {
            Along::Numbers { low, high } => with_room(&[low, high]),
            Along::Logarithmic { low, high } => (low / 1.1, high * 1.1),
            Along::Words(_) => (0.0, 1.0),
        };
        chart.ranges = Some((across, IndividualsChart::ranges([&chart]).1));
        chart
    }

    /// The worst values among those who were found at each word.
    fn words(&self, index: usize, words: &[String]) -> Strips {
        let at = |found: &Found| {
            let best = found.best.as_ref()?;
            self.dimensions[index].place(&best.get(index)?.1)
        };
        let strip = |(place, word): (usize, &String)| {
            let here = self.found.iter().filter(|found| at(found) == Some(place as f64));
            let dot = |found: &&Found| {
                let value = self.objective.charted(found.observed?);
                Some(Dot { value, first: first(found), name: self.name(found), is_run: false })
            };
            Strip { name: word.clone(), dots: here.filter_map(dot).collect(), undefined: 0 }
        };
        Strips {
            title: self.dimensions[index].name.clone(),
            x: String::new(),
            y: self.objective.quantity(),
            strips: words.iter().enumerate().map(strip).collect(),
            rules: self.objective.kept(self.search),
            range: None,
        }
    }

    fn convergence(&self) -> Option<HtmlFigure> {
        let (title, goal) = (self.search.name.clone(), self.search.objective.direction);
        let (y, initial) = (self.objective.quantity(), self.search.budget.initial as usize);
        let dotted = format!("The dotted line stands after the {initial} initial points.");
        if let [found] = self.found.as_slice() {
            let tried = self.tried(found, None);
            let chart = Convergence { title, y, goal, tried, initial };
            return Some(
                HtmlFigure::new("Convergence", dotted, vec![chart.to_svg()])
                    .with_legend(chart.legend("best")),
            );
        }
        let course = |found: &&Found| {
            found
                .evaluations
                .iter()
                .map(|(_, value)| value.map(|value| self.objective.charted(value)))
                .collect()
        };
        let courses: Vec<Vec<Option<f64>>> = self.found.iter().map(course).collect();
        if courses.is_empty() {
            return None;
        }
        let chart = Convergences { title, y, goal, courses, initial };
        let note = format!("The best value so far over {} individuals. {dotted}", self.found.len());
        Some(HtmlFigure::new("Convergence", note, vec![chart.to_svg()]).with_legend(Convergences::legend()))
    }

    /// Every evaluation: along a dimension, or by its number.
    fn tried(&self, found: &Found, along: Option<usize>) -> Vec<Tried> {
        let best = found.best.as_ref();
        let is_best = |point: &[Coordinate], value: &Option<f64>| {
            let same = |best: &Vec<(String, Coordinate)>| best.iter().map(|(_, value)| value).eq(point);
            *value == found.observed && best.is_some_and(same)
        };
        let initial = self.search.budget.initial as usize;
        let mut had_best = false;
        let mut tried = Vec::new();
        for (index, (point, value)) in found.evaluations.iter().enumerate() {
            let x = match along {
                Some(dimension) => self.dimensions[dimension].place(&point[dimension]),
                None => Some((index + 1) as f64),
            };
            let mark = match value {
                None => PointMark::Refused,
                Some(_) if !had_best && is_best(point, value) => PointMark::Best,
                Some(_) if index < initial => PointMark::Initial,
                Some(_) => PointMark::Proposed,
            };
            had_best |= mark == PointMark::Best;
            tried.extend(x.map(|x| Tried { x, y: value.map(|value| self.objective.charted(value)), mark }));
        }
        tried
    }

    fn slices(&self) -> Option<HtmlFigure> {
        // Those who were kept first, and the worst of them.
        let mut order: Vec<&&Found> = self.found.iter().collect();
        order.sort_by_key(|found| !found.kept.contains(&true));
        let drawn = (MOST_SLICES / self.dimensions.len().max(1)).max(1);
        let slice = |found: &&&Found, index: usize| {
            let dimension = &self.dimensions[index];
            let empty = Vec::new();
            let slice = found.slices.get(index).unwrap_or(&empty);
            Slice {
                title: match self.dimensions.len() {
                    1 => self.name(found),
                    _ => format!("{}: {}", self.name(found), dimension.name),
                },
                x: dimension.quantity(),
                along: dimension.along.clone(),
                y: self.objective.quantity(),
                beliefs: dimension.beliefs(slice, &self.objective),
                tried: self.tried(found, Some(index)),
                rules: self.objective.kept(self.search),
                range: None,
            }
        };
        let with_points = order.iter().filter(|found| !found.evaluations.is_empty());
        let mut slices: Vec<Slice> = with_points
            .take(drawn)
            .flat_map(|found| (0..self.dimensions.len()).map(move |index| (found, index)))
            .map(|(found, index)| slice(found, index))
            .collect();
        let range = Slice::range(&slices);
        slices.iter_mut().for_each(|slice| slice.range = Some(range));
        if slices.is_empty() {
            return None;
        }
        let mut note =
            "What the surrogate believes after the last evaluation, with every evaluated point.".to_string();
        if self.dimensions.len() > 1 {
            note +=
                " Each chart is a slice through the best point: points whose other values differ lie off it.";
        }
        if order.len() > 1 {
            note += " Kept individuals first, the worst of them in front.";
        }
        if order.len() > drawn {
            note += &format!(" {} more individuals are not drawn.", order.len() - drawn);
        }
        let legend = Slice::legend(&slices, "best");
        let panels = slices.iter().map(Slice::to_svg).collect();
        let open = OPEN_SLICES.div_ceil(self.dimensions.len().max(1)) * self.dimensions.len();
        let figure = HtmlFigure::new("Surrogates", note, panels).with_legend(legend);
        Some(figure.folded(open, |count| format!("{count} more")))
    }
}

/// `1 run each`, `5 runs each`.
fn runs(count: u32) -> String {
    if count == 1 { "1 run each".into() } else { format!("{count} runs each") }
}

fn first(found: &Found) -> First {
    First::of(found.passed_first.as_deref())
}
