//! `search`: the plausible case that is worst, per individual or over the whole population.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::context::{BlockProgress, Context};
use super::error::ExperimentError;
use super::journal::Record;
use super::overrides;
use super::plausible::{EncounterPlausibility, PartsCounted, PlausibleEncounters, front};
use super::rounds::{EvaluateRound, Optimisation, optimise};
use super::searched::{FRESH_RUNS, Searched, SearchedPeople, named_at};
use crate::run::RunError;
use numbers::random::derive_seed;
use numbers::summary::mean;
use optimise::{
    self, Coordinate, Definition, Evaluation, Fitted, Margin, Method, ObjectiveValue, Optimiser, Proposal,
    SlicePoint,
};
use results::judge::judge;
use results::{
    CaseRun, CoursePoint, Finding, Found, FrontPoint, JudgedRun, JudgedSearch, MetricCourse, Outcome,
    SavedCase, SavedSet, SearchResult, UsualEncounters, Verdict,
};
use scenario::{self, Budget, Case, Goal, Keep, Objective, Origin, Relation, Search, SearchRange, ShownIn};

/// What is rarer than this counts as this rare where a search looks among what is usual enough, and what is more by a factor than the
/// other as that.
const LEAST_SHARE: f64 = 1e-9;
const LEAST_FACTOR: f64 = 1e-3;

/// Points of a slice through the surrogate.
const SLICE_STEPS: usize = 101;

/// How many individuals get a [`MetricCourse`]: those that were kept, the worst first.
const MOST_COURSES: usize = 12;
/// Values of a dimension that a course is run at.
const COURSE_STEPS: usize = 25;
/// Runs at each of them.
const COURSE_RUNS: u32 = 10;

/// Groups that are searched for at a time, a round of each together: enough for many threads, and not more surrogates than
/// there is memory for.
const SIDE_BY_SIDE: usize = 64;

/// Runs one search to its end.
///
/// # Errors
/// Whatever keeps it from a result; evaluations without a value are not errors but count as undefined.
pub fn run_search(
    context: &Context,
    search: &Search,
    progress: &dyn BlockProgress,
) -> Result<SearchResult, ExperimentError> {
    run_groups(context, search, None, progress)
}

/// What is believed along each dimension through a point; an empty slice where no surrogate can be fitted.
pub fn slices(fitted: Option<&Fitted>, through: &[Coordinate]) -> Vec<Vec<SlicePoint>> {
    let along = |dimension| fitted?.surrogate_slice(dimension, through, SLICE_STEPS).ok();
    (0..through.len()).map(|dimension| along(dimension).unwrap_or_default()).collect()
}

/// The search for one of several groups of people alone: all runs that a search for all makes for it, and maybe more, since of all only the worst
/// are followed further.
///
/// # Errors
/// As [`run_search`].
pub fn search_group(
    context: &Context,
    search: &Search,
    group: usize,
    progress: &dyn BlockProgress,
) -> Result<SearchResult, ExperimentError> {
    run_groups(context, search, Some(group), progress)
}

/// For all groups, or only one.
fn run_groups(
    context: &Context,
    search: &Search,
    only: Option<usize>,
    progress: &dyn BlockProgress,
) -> Result<SearchResult, ExperimentError> {
    let searched = Searched::new(context.suite, search, context.scenario(&search.scenario)?);
    let mut groups = searched.groups()?;
    let together = groups.iter().any(|group| group.len() > 1);
    if let Some(only) = only {
        groups = groups.into_iter().skip(only).take(1).collect();
    }
    let under = Under {
        context,
        search,
        encounters: PlausibleEncounters::of(search, &searched.scenario, together)?,
        searched,
        progress,
        evaluating: context.reading_only([search.objective.aggregate.metric()]),
        done: AtomicUsize::new(0),
        all: groups.len() * search.budget.evaluations as usize,
    };
    let (mut found, mut over) = (Vec::with_capacity(groups.len()), Vec::with_capacity(groups.len()));
    let mut left = Vec::with_capacity(groups.len());
    let mut left_out = 0;
    for groups in groups.chunks(SIDE_BY_SIDE) {
        let begin = |group: &SearchedPeople| under.begin(group);
        let mut all =
            context.executor.think(|| groups.par_iter().map(begin).collect::<Result<Vec<_>, _>>())?;
        optimise(&under.evaluating, &mut all, &Groups { under: &under, groups })?;
        for (one, of_it) in under.conclude(groups, &all)? {
            found.push(one);
            left.push(of_it);
        }
        let evaluated = all.iter().flat_map(|one| one.optimiser.trials());
        left_out += evaluated.map(|one| one.evaluation.left_out as usize).sum::<usize>();
        over.extend(all.into_iter().map(Optimisation::into_record));
    }
    under.follow(&groups, &mut found)?;
    let usual = under.usual(&groups, &mut found)?;
    // Only now: a search that is cut off repeats nobody.
    over.into_iter().for_each(Record::remove);
    let judged = under.judge(&found, &left);
    let kept = found.iter().flat_map(Found::kept_cases).cloned().collect();
    Ok(SearchResult {
        name: search.name.clone(),
        objective: search.objective.text.clone(),
        direction: search.objective.direction,
        shown_in: search.over.iter().map(SearchRange::shown_in).collect(),
        objective_in: ShownIn::new(search.objective.notation, &search.objective.aggregate.unit()),
        metrics: context.requests().iter().map(|reference| reference.label()).collect(),
        kept: SavedSet {
            name: search.name.clone(),
            source: format!(
                "search {} of suite {}, seed {}, scenario-runner {}",
                search.name,
                context.suite.name,
                context.suite.seed,
                env!("CARGO_PKG_VERSION")
            ),
            cases: kept,
        },
        found,
        usual,
        judged,
        left_out,
    })
}

/// The optimiser's definition for a budget.
pub(super) fn definition(
    space: optimise::Space,
    budget: &Budget,
    goals: Vec<Goal>,
    constraints: usize,
    seed: u64,
) -> Definition {
    Definition {
        objectives: goals,
        constraints,
        budget: budget.evaluations as usize,
        initial: budget.initial as usize,
        initial_design: budget.initial_design,
        method: match budget.method {
            scenario::SearchMethod::Bayesian => Method::Bayesian,
            scenario::SearchMethod::GpMinimizeLike => Method::GpMinimizeLike { penalty: PENALTY },
            scenario::SearchMethod::Random => Method::Random,
            scenario::SearchMethod::LatinHypercube => Method::LatinHypercube,
            scenario::SearchMethod::Sobol => Method::Sobol,
            scenario::SearchMethod::Grid => Method::Grid,
        },
        ..Definition::new(space, seed)
    }
}

/// A budget without what the optimiser's definition says of it already.
pub(super) fn undecisive(budget: &Budget) -> Budget {
    Budget { evaluations: 0, initial: 0, ..budget.clone() }
}

/// What an infeasible evaluation counts as in the reference's method: larger than any time in s.
const PENALTY: f64 = 1000.0;

/// One search under way.
struct Under<'a> {
    context: &'a Context<'a>,
    /// For the evaluations, of which nothing but the objective is kept: best points are run again.
    evaluating: Context<'a>,
    search: &'a Search,
    searched: Searched<'a>,
    /// `None` where nothing says how usual any encounter is.
    encounters: Option<PlausibleEncounters>,
    progress: &'a dyn BlockProgress,
    done: AtomicUsize,
    all: usize,
}

/// Runs with fresh seeds at the best point of a group.
#[derive(Debug, Clone, Copy, Default)]
struct LeftWithFreshSeeds {
    /// Those that meet every expectation.
    holding: usize,
    runs: usize,
}

/// Groups that are searched for side by side.
struct Groups<'a> {
    under: &'a Under<'a>,
    groups: &'a [SearchedPeople],
}

impl EvaluateRound for Groups<'_> {
    fn cases(&self, group: usize, proposal: &Proposal) -> Result<Vec<Case>, ExperimentError> {
        let (under, group) = (self.under, &self.groups[group]);
        let key = format!("{}/evaluation={}", under.searched.name(group), proposal.id);
        under.searched.cases(&key, group, &proposal.point, under.search.runs)
    }

    fn values(&self, proposal: &Proposal) -> String {
        overrides::in_words(&self.under.search.over, &proposal.point)
    }

    fn leaves_out(&self, error: &RunError) -> bool {
        error.is_no_encounter()
    }

    fn evaluation(&self, cases: &[Case], outcomes: &[Outcome], _: bool) -> Evaluation {
        let (value, noise_variance) = match outcomes {
            // All of its runs were left out.
            [] => (None, None),
            outcomes => self.under.objective(&self.under.evaluating, outcomes),
        };
        Evaluation {
            objectives: vec![ObjectiveValue { value, noise_variance }],
            margins: self.under.margins(cases),
            repetitions: self.under.search.runs,
            left_out: 0,
        }
    }

    fn evaluated(&self, evaluation: &Evaluation) {
        let done = self.under.done.fetch_add(1, Ordering::Relaxed) + 1;
        let is_looked_for = evaluation.keeps_constraints();
        let value = evaluation.objectives[0].value.filter(|_| is_looked_for);
        self.under.progress.evaluated(done, self.under.all, value);
    }
}

impl Under<'_> {
    /// The search for one group of people.
    fn begin(&self, group: &SearchedPeople) -> Result<Optimisation, ExperimentError> {
        let suite = self.context.suite;
        let name = self.searched.name(group);
        let space = overrides::space(&self.search.over)?;
        let seed = derive_seed(suite.seed, suite.own_key(&name));
        let goals = vec![self.search.objective.direction];
        let constraints = self.bounds().count();
        let definition = definition(space, &self.search.budget, goals, constraints, seed);
        let inputs = (suite.seed, suite.own_key(&name), &self.searched.scenario, self.decisive(), group);
        Optimisation::begin(self.context, &name, &inputs, definition, self.search.budget.batch as usize)
    }

    /// What of the search decides its evaluations, besides the definition of its optimiser.
    fn decisive(&self) -> Search {
        Search {
            doc: None,
            over: overrides::without_origins(&self.search.over),
            budget: undecisive(&self.search.budget),
            expect: Vec::new(),
            origin: Origin::default(),
            ..self.search.clone()
        }
    }

    /// What was found for each of the groups, whose best points are run again; with what of it is left with fresh seeds.
    fn conclude(
        &self,
        groups: &[SearchedPeople],
        all: &[Optimisation],
    ) -> Result<Vec<(Found, LeftWithFreshSeeds)>, ExperimentError> {
        let context = self.context;
        let each = |(group, one): (&SearchedPeople, &Optimisation)| self.conclude_one(group, &one.optimiser);
        let mut found = context.executor.think(|| groups.par_iter().zip(all).map(each).collect::<Vec<_>>());
        let once_more = |(group, one): (&SearchedPeople, &Optimisation)| {
            let Some(best) = one.optimiser.best_observed() else { return Ok(Vec::new()) };
            let name = self.searched.name(group);
            let again = format!("{name}/evaluation={}", best.id);
            let again = self.searched.cases(&again, group, &best.point, self.search.runs)?;
            Ok(vec![again, self.searched.cases(&format!("{name}/fresh"), group, &best.point, FRESH_RUNS)?])
        };
        let cases = context.executor.think(|| groups.par_iter().zip(all).map(once_more).collect::<Vec<_>>());
        let cases = cases.into_iter().collect::<Result<Vec<_>, ExperimentError>>()?.concat();
        let mut outcomes = self.run_leaving_out(&cases.concat())?.into_iter();
        let mut cases = cases.iter();
        let mut all_left = vec![LeftWithFreshSeeds::default(); found.len()];
        for ((one, found), left) in all.iter().zip(&mut found).zip(&mut all_left) {
            let Some(best) = one.optimiser.best_observed() else { continue };
            let mut next = || {
                let cases = cases.next().expect("there are two of each that has a best point");
                let each = cases.iter().zip(outcomes.by_ref());
                let made = each.filter_map(|(case, outcome)| Some((case.clone(), outcome?)));
                made.unzip::<Case, Outcome, Vec<_>, Vec<_>>()
            };
            let ((again, runs), (_, fresh)) = (next(), next());
            found.passed_first = runs.first().and_then(|outcome| context.passed_first(outcome));
            found.plausibility = self.plausibility(&again).map(|one| one.share);
            found.runs = self.saved(&best.point, &again, runs);
            found.kept = found.runs.iter().map(|run| self.keeps(run)).collect();
            found.fresh = if fresh.is_empty() { None } else { self.objective(context, &fresh).0 };
            let decided = context.seen(self.search.objective.aggregate.metric(), &fresh);
            found.fresh_runs = decided.iter().filter(|one| one.is_value()).count() as u32;
            let holding = fresh.iter().filter(|run| self.meets_expectations(run)).count();
            *left = LeftWithFreshSeeds { holding, runs: fresh.len() };
        }
        Ok(found.into_iter().zip(all_left).collect())
    }

    /// What every criterion says of a run by itself.
    fn findings(&self, run: &Outcome) -> Vec<Finding> {
        judge(&self.search.expect, std::slice::from_ref(run), self.context.requests()).findings
    }

    fn meets_expectations(&self, run: &Outcome) -> bool {
        self.findings(run).iter().all(|finding| finding.verdict == Verdict::Passed)
    }

    /// The runs that are kept against what is expected of them, each by itself; the best observed ones where nothing is kept. What is left
    /// with fresh seeds stands beside it and decides nothing.
    fn judge(&self, found: &[Found], left: &[LeftWithFreshSeeds]) -> Option<JudgedSearch> {
        if self.search.expect.is_empty() {
            return None;
        }
        let of_kept = found.iter().any(|one| one.kept.contains(&true));
        let mut runs = Vec::new();
        for (index, (one, left)) in found.iter().zip(left).enumerate() {
            let point: Vec<Coordinate> = one.best.iter().flatten().map(|(_, value)| value.clone()).collect();
            let judged = one.runs.iter().zip(&one.kept).filter(|(_, kept)| **kept || !of_kept);
            runs.extend(judged.map(|(run, _)| JudgedRun {
                key: named_at(&run.case.key, &point),
                found: index,
                findings: self.findings(&run.outcome),
                fresh_holding: left.holding,
                fresh_runs: left.runs,
            }));
        }
        Some(JudgedSearch { of_kept, runs })
    }

    /// What the optimiser found, of which nothing is run yet.
    fn conclude_one(&self, group: &SearchedPeople, optimiser: &Optimiser) -> Found {
        let evaluations = optimiser
            .trials()
            .iter()
            .map(|trial| (trial.point.clone(), trial.evaluation.objectives[0].value))
            .collect();
        let mut found = Found {
            individuals: group.concat(),
            best: None,
            observed: None,
            predicted: None,
            fresh: None,
            fresh_runs: 0,
            passed_first: None,
            plausibility: None,
            evaluations,
            plausibilities: Vec::new(),
            stop: optimiser.stop_reason(),
            slices: Vec::new(),
            runs: Vec::new(),
            kept: Vec::new(),
            courses: Vec::new(),
        };
        let Some(best) = optimiser.best_observed() else { return found };
        let names = self.search.over.iter().map(|range| range.target.to_string());
        found.best = Some(names.zip(best.point.iter().cloned()).collect());
        found.observed = best.evaluation.objectives[0].value;
        // A surrogate that cannot be fitted leaves these parts of the report empty, not the search without a result.
        let fitted = optimiser.fitted().ok();
        let predictions = fitted.as_ref().map(Fitted::predictions).unwrap_or_default();
        found.predicted =
            predictions.iter().find(|one| one.point == best.point).map(|one| (one.mean, one.deviation));
        found.slices = slices(fitted.as_ref(), &best.point);
        found
    }

    /// The outcomes of cases, without those whose encounter cannot be.
    fn run_leaving_out(&self, cases: &[Case]) -> Result<Vec<Option<Outcome>>, ExperimentError> {
        self.context.run_leaving_out(&self.context.measured, 1, cases)
    }

    fn objective(&self, context: &Context, outcomes: &[Outcome]) -> (Option<f64>, Option<f64>) {
        let Objective { aggregate, direction, .. } = &self.search.objective;
        context.objective(aggregate, *direction, outcomes)
    }

    /// Whether a run at the best point is all that the search was to keep; without a condition all are.
    fn keeps(&self, run: &CaseRun) -> bool {
        self.search.keep.iter().all(|keep| match keep {
            Keep::Metric { comparison, .. } => {
                let seen = self.context.seen(&comparison.metric, std::slice::from_ref(&run.outcome));
                seen[0].holds(comparison, false)
            }
            Keep::Plausibility { relation, bound } => {
                run.case.plausibility.is_some_and(|share| relation.holds(share, *bound))
            }
        })
    }

    /// How usual the encounters are that the search looks among: those that it keeps.
    fn bounds(&self) -> impl Iterator<Item = (Relation, f64)> {
        self.search.keep.iter().filter_map(|keep| match keep {
            Keep::Plausibility { relation, bound } => Some((*relation, *bound)),
            Keep::Metric { .. } => None,
        })
    }

    /// How far an evaluation is within what it looks among, by factors, which range over more than differences do.
    fn margins(&self, cases: &[Case]) -> Vec<Margin> {
        if self.bounds().next().is_none() {
            return Vec::new();
        }
        let share = self.plausibility(cases).map(|one| one.share);
        let margin = |(relation, bound): (Relation, f64)| {
            let bound = bound.max(LEAST_SHARE);
            let factor = |share: f64| libm::log(share.max(bound * LEAST_FACTOR) / bound);
            let value = share.map(|share| match relation {
                Relation::Less | Relation::LessOrEqual => -factor(share),
                _ => factor(share),
            });
            Margin::of(value)
        };
        self.bounds().map(margin).collect()
    }

    /// How usual the encounter of an evaluation is: of its only run, or as far as its runs share it. Where they share less with some of their
    /// other variations, the least usual.
    fn plausibility(&self, cases: &[Case]) -> Option<EncounterPlausibility> {
        let encounters = self.encounters.as_ref()?;
        if let [case] = cases {
            return encounters.of_case(case, PartsCounted::Whole);
        }
        let each = cases.iter().filter(|case| case.repetition == 1);
        let each: Option<Vec<_>> = each.map(|case| encounters.of_case(case, PartsCounted::Shared)).collect();
        each?.into_iter().min_by(|one, other| one.share.total_cmp(&other.share))
    }

    /// Runs as cases to be used again, with what came of them.
    fn saved(&self, point: &[optimise::Coordinate], cases: &[Case], outcomes: Vec<Outcome>) -> Vec<CaseRun> {
        let values = self.context.values(self.search.objective.aggregate.metric(), &outcomes);
        let settings = overrides::settings(&self.search.over, point);
        let saved = cases.iter().zip(values).map(|(case, value)| SavedCase {
            key: case.key.clone(),
            scenario: case.scenario.clone(),
            variation: case.variation.iter().cloned().chain(case.drawn_values()).collect(),
            settings: settings.clone(),
            individuals: case.individuals.clone(),
            seed: case.seed,
            value,
            plausibility: self
                .encounters
                .as_ref()
                .and_then(|encounters| encounters.of_case(case, PartsCounted::Whole))
                .map(|one| one.share),
        });
        self.context.case_runs(saved, outcomes)
    }

    /// How usual all evaluated encounters are, and the front of how bad they are against that; the encounters on it are run again with fresh
    /// seeds.
    fn usual(
        &self,
        groups: &[SearchedPeople],
        found: &mut [Found],
    ) -> Result<Option<UsualEncounters>, ExperimentError> {
        let Some(encounters) = &self.encounters else { return Ok(None) };
        let of_group = |(group, found): (&SearchedPeople, &mut Found)| -> Result<Vec<_>, ExperimentError> {
            let name = self.searched.name(group);
            let one = |(id, (point, _)): (usize, &(Vec<optimise::Coordinate>, Option<f64>))| {
                let key = format!("{name}/evaluation={id}");
                Ok(self.plausibility(&self.searched.cases(&key, group, point, self.search.runs)?))
            };
            let each = found.evaluations.iter().enumerate().map(one);
            let each = each.collect::<Result<Vec<_>, ExperimentError>>()?;
            found.plausibilities = each.iter().map(|one| one.as_ref().map(|one| one.share)).collect();
            Ok(each)
        };
        let known = self.context.executor.think(|| {
            groups.par_iter().zip(found.par_iter_mut()).map(of_group).collect::<Vec<Result<_, _>>>()
        });
        let known = known.into_iter().collect::<Result<Vec<_>, ExperimentError>>()?;
        let (mut points, mut places) = (Vec::new(), Vec::new());
        let mut usual = UsualEncounters {
            of: encounters.parts(),
            undeclared: encounters.undeclared().to_vec(),
            possible: 0,
            impossible: 0,
            unknown: 0,
            wanted: None,
            front: Vec::new(),
        };
        if self.search.asks_for_plausibility() {
            let is_wanted =
                |share: &f64| self.bounds().all(|(relation, bound)| relation.holds(*share, bound));
            let shares = found.iter().flat_map(|one| &one.plausibilities).flatten();
            usual.wanted = Some(shares.filter(|share| is_wanted(share)).count());
        }
        let sign = if self.search.objective.direction == Goal::Minimise { -1.0 } else { 1.0 };
        for (index, (known, found)) in known.iter().zip(&*found).enumerate() {
            for (evaluation, (known, (_, value))) in known.iter().zip(&found.evaluations).enumerate() {
                match (known, value) {
                    (None, _) => usual.unknown += 1,
                    (Some(one), _) if one.share <= 0.0 => usual.impossible += 1,
                    // Reports say how many evaluations have no value.
                    (Some(_), None) => {}
                    (Some(one), Some(value)) => {
                        usual.possible += 1;
                        points.push((sign * value, one.share));
                        places.push((index, evaluation, one));
                    }
                }
            }
        }
        let on_front = front(&points);
        let mut fresh = Vec::with_capacity(on_front.len());
        for (index, evaluation, one) in on_front.into_iter().map(|at| places[at]) {
            let (point, value) = &found[index].evaluations[evaluation];
            let key = format!("{}/evaluation={evaluation}", self.searched.name(&groups[index]));
            let cases = self.searched.cases(&key, &groups[index], point, self.search.runs)?;
            usual.front.push(FrontPoint {
                found: index,
                evaluation,
                value: value.expect("what is on the front has a value"),
                plausibility: one.share,
                parts: one.parts.clone(),
                fresh: None,
                fresh_runs: 0,
                key: named_at(&cases[0].key, point),
            });
            fresh.push(self.searched.same_encounter(&key, &groups[index], point, &cases)?);
        }
        let mut outcomes = self.run_leaving_out(&fresh.concat())?.into_iter();
        for (one, cases) in usual.front.iter_mut().zip(&fresh) {
            let outcomes: Vec<Outcome> = outcomes.by_ref().take(cases.len()).flatten().collect();
            one.fresh = if outcomes.is_empty() { None } else { self.objective(self.context, &outcomes).0 };
            let decided = self.context.seen(self.search.objective.aggregate.metric(), &outcomes);
            one.fresh_runs = decided.iter().filter(|one| one.is_value()).count() as u32;
        }
        Ok(Some(usual))
    }

    /// Gives those who were kept, the worst first, their courses.
    fn follow(&self, groups: &[SearchedPeople], found: &mut [Found]) -> Result<(), ExperimentError> {
        if self.search.keep.is_empty() || self.search.together {
            return Ok(());
        }
        let sign = if self.search.objective.direction == Goal::Minimise { 1.0 } else { -1.0 };
        let mut kept: Vec<(f64, usize)> = found
            .iter()
            .enumerate()
            .filter(|(_, one)| one.kept.contains(&true))
            .filter_map(|(index, one)| Some((sign * one.observed?, index)))
            .collect();
        kept.sort_by(|left, right| left.0.total_cmp(&right.0).then(left.1.cmp(&right.1)));
        kept.truncate(MOST_COURSES);
        let points = |(_, index): &(f64, usize)| self.courses(*index, &groups[*index], &found[*index]);
        let asked = self.context.executor.think(|| kept.par_iter().map(points).collect::<Vec<_>>());
        let asked = asked.into_iter().collect::<Result<Vec<_>, _>>()?.concat();
        let cases: Vec<Case> = asked.iter().flat_map(|one| &one.cases).cloned().collect();
        let mut outcomes = self.run_leaving_out(&cases)?.into_iter();
        for AskedPoint { group, over, at, cases } in asked {
            let outcomes: Vec<_> = outcomes.by_ref().take(cases.len()).flatten().collect();
            let courses = &mut found[group].courses;
            if courses.last().is_none_or(|course| course.over != over) {
                courses.push(MetricCourse { over, points: Vec::new() });
            }
            let points = courses.last_mut().map(|course| &mut course.points);
            points.into_iter().for_each(|points| points.extend(self.course_point(at, &outcomes)));
        }
        Ok(())
    }

    /// The runs of the courses of a group, along each of the ranges that has an order.
    fn courses(
        &self,
        index: usize,
        group: &SearchedPeople,
        found: &Found,
    ) -> Result<Vec<AskedPoint>, ExperimentError> {
        let best: Vec<_> = found.best.iter().flatten().map(|(_, value)| value.clone()).collect();
        let mut asked = Vec::new();
        for (dimension, range) in self.search.over.iter().enumerate() {
            let dimension_values = overrides::dimension(range);
            if dimension_values.is_categorical() {
                continue;
            }
            let place = |step| dimension_values.value(step as f64 / (COURSE_STEPS - 1) as f64);
            let mut steps: Vec<optimise::Coordinate> = (0..COURSE_STEPS).map(place).collect();
            steps.dedup();
            let over = range.target.to_string();
            for step in steps {
                let Some(at) = step.number() else { continue };
                let mut point = best.clone();
                point[dimension] = step;
                let key = format!("{}/course={over}", self.searched.name(group));
                let cases = self.searched.cases(&key, group, &point, COURSE_RUNS)?;
                asked.push(AskedPoint { group: index, over: over.clone(), at, cases });
            }
        }
        Ok(asked)
    }

    /// What the runs at a point of a course came to; `None` where the metric exists in none.
    fn course_point(&self, at: f64, outcomes: &[Outcome]) -> Option<CoursePoint> {
        let metric = self.search.objective.aggregate.metric();
        let mut values: Vec<f64> = self.context.values(metric, outcomes).into_iter().flatten().collect();
        values.sort_by(f64::total_cmp);
        Some(CoursePoint {
            at,
            smallest: *values.first()?,
            mean: mean(&values)?,
            largest: *values.last()?,
            runs: values.len(),
        })
    }
}

/// A point of a course, before it is run.
#[derive(Clone)]
struct AskedPoint {
    /// Index of the group.
    group: usize,
    over: String,
    at: f64,
    cases: Vec<Case>,
}
