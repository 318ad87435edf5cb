//! `search`: the plausible case that is worst, per individual or over the whole population.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::context::{BlockProgress, Context};
use super::error::ExperimentError;
use super::journal::Record;
use super::overrides;
use super::plausible::PlausiblePeople;
use super::rounds::{EvaluateRound, Optimisation, optimise};
use crate::plan;
use numbers::random::derive_seed;
use numbers::summary::mean;
use optimise::{self, Definition, Evaluation, Method, ObjectiveValue, Optimiser, Proposal};
use results::{CaseRun, CoursePoint, Found, MetricCourse, Outcome, SavedCase, SavedSet, SearchResult};
use scenario::{
    self, Assignment, Budget, Case, DeclaredPedestrian, Goal, Individual, Objective, Scenario, Search,
    SearchRange, ShownIn,
};

/// Runs with fresh seeds that tell how much of a best value was luck.
const FRESH_RUNS: u32 = 20;

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

/// People who are all in every evaluation, each of them one or several pedestrians.
type Group = Vec<Vec<Individual>>;

/// Runs one search to its end.
///
/// # Errors
/// Whatever keeps it from a result; evaluations without a value are not errors but count as undefined.
pub fn run_search(
    context: &Context,
    search: &Search,
    progress: &dyn BlockProgress,
) -> Result<SearchResult, ExperimentError> {
    let scenario = with_individuals(context.scenario(&search.scenario)?, search);
    let people = plan::select_people(context.suite.seed, &scenario)?;
    let groups: Vec<Group> =
        if search.together { vec![people] } else { people.into_iter().map(|group| vec![group]).collect() };
    let under = Under {
        context,
        search,
        scenario: &scenario,
        progress,
        done: AtomicUsize::new(0),
        all: groups.len() * search.budget.evaluations as usize,
    };
    let (mut found, mut over) = (Vec::with_capacity(groups.len()), Vec::with_capacity(groups.len()));
    for groups in groups.chunks(SIDE_BY_SIDE) {
        let begin = |group: &Group| under.begin(group);
        let mut all =
            context.executor.think(|| groups.par_iter().map(begin).collect::<Result<Vec<_>, _>>())?;
        optimise(context, &mut all, &Groups { under: &under, groups })?;
        found.extend(under.conclude(groups, &all)?);
        over.extend(all.into_iter().map(Optimisation::into_record));
    }
    under.follow(&groups, &mut found)?;
    // Only now: a search that is cut off repeats nobody.
    over.into_iter().for_each(Record::remove);
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
    })
}

/// The scenario with the people whom the search says.
pub(super) fn with_individuals(scenario: &Scenario, search: &Search) -> Scenario {
    let mut scenario = scenario.clone();
    if let Some(individuals) = &search.individuals {
        for pedestrian in scenario.pedestrians.iter_mut().filter(|one| one.individuals.is_some()) {
            pedestrian.individuals = Some(individuals.clone());
        }
        if scenario.pedestrians.iter().all(|one| one.individuals.is_none())
            && let Some(person) = likely_individual(&scenario.pedestrians)
        {
            let group = person.group.as_ref().map(|membership| membership.group.clone());
            let name = group.unwrap_or_else(|| person.name.clone());
            for one in scenario.pedestrians.iter_mut().filter(|one| one.is(&name)) {
                one.individuals = Some(individuals.clone());
            }
        }
    }
    scenario
}

/// The first pedestrian whose model takes individuals, or the first if none does.
fn likely_individual(people: &[DeclaredPedestrian]) -> Option<&DeclaredPedestrian> {
    let takes = |one: &&DeclaredPedestrian| {
        one.model.all().iter().all(|model| model.entry().is_some_and(|model| model.takes_individuals))
    };
    people.iter().find(takes).or(people.first())
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

/// What an infeasible evaluation counts as in the reference's method: larger than any time in s.
const PENALTY: f64 = 1000.0;

/// One search under way.
struct Under<'a> {
    context: &'a Context<'a>,
    search: &'a Search,
    scenario: &'a Scenario,
    progress: &'a dyn BlockProgress,
    done: AtomicUsize,
    all: usize,
}

/// Groups that are searched for side by side.
struct Groups<'a> {
    under: &'a Under<'a>,
    groups: &'a [Group],
}

impl EvaluateRound for Groups<'_> {
    fn cases(&self, group: usize, proposal: &Proposal) -> Result<Vec<Case>, ExperimentError> {
        let (under, group) = (self.under, &self.groups[group]);
        let key = format!("{}/evaluation={}", under.name(group), proposal.id);
        under.cases(&key, group, &proposal.point, under.search.runs)
    }

    fn values(&self, proposal: &Proposal) -> String {
        overrides::in_words(&self.under.search.over, &proposal.point)
    }

    fn evaluation(&self, outcomes: &[Outcome], _: bool) -> Evaluation {
        let (value, noise_variance) = self.under.objective(outcomes);
        Evaluation {
            objectives: vec![ObjectiveValue { value, noise_variance }],
            margins: Vec::new(),
            repetitions: self.under.search.runs,
        }
    }

    fn evaluated(&self, evaluation: &Evaluation) {
        let done = self.under.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.under.progress.evaluated(done, self.under.all, evaluation.objectives[0].value);
    }
}

impl Under<'_> {
    /// The search for one group of people.
    fn begin(&self, group: &Group) -> Result<Optimisation, ExperimentError> {
        let suite = self.context.suite;
        let name = self.name(group);
        let space = overrides::space(&self.search.over)?;
        let seed = derive_seed(suite.seed, &name);
        let goals = vec![self.search.objective.direction];
        let definition = definition(space, &self.search.budget, goals, 0, seed);
        let inputs = (suite.seed, &name, self.scenario, self.search, group);
        Optimisation::begin(self.context, &name, &inputs, definition, self.search.budget.batch as usize)
    }

    /// The beginning of the keys of a group's runs.
    fn name(&self, group: &[Vec<Individual>]) -> String {
        let label = if self.search.together { String::new() } else { plan::people_label(&group[0]) };
        format!("{}/{}{label}", self.context.suite.name, self.search.name)
    }

    /// The cases of one evaluation: everybody, in every variation that is not searched, `runs` times.
    fn cases(
        &self,
        key: &str,
        group: &[Vec<Individual>],
        point: &[optimise::Coordinate],
        runs: u32,
    ) -> Result<Vec<Case>, ExperimentError> {
        let mut scenario = overrides::without_variations(self.scenario, &self.search.over);
        overrides::apply(&mut scenario, &overrides::settings(&self.search.over, point))?;
        let fixed = overrides::assignments(&self.search.over, point);
        let mut cases = Vec::new();
        let seed = self.context.suite.seed;
        for combination in plan::combinations(seed, &scenario, plan::variables(&fixed))? {
            let variation: Vec<Assignment> = [fixed.clone(), combination].concat();
            let labels: String = variation
                .iter()
                .map(|assignment| format!("/{}={}", assignment.name, assignment.label))
                .collect();
            for people in group {
                let people_label =
                    if self.search.together { plan::people_label(people) } else { String::new() };
                for run in 1..=runs {
                    let key = format!("{key}{labels}{people_label}/rep={run}");
                    let seed = derive_seed(self.context.suite.seed, &key);
                    let people = people.clone();
                    cases.push(plan::concrete_case(&scenario, key, variation.clone(), people, run, seed)?);
                }
            }
        }
        Ok(cases)
    }

    /// What was found for each of the groups, whose best points are run again and with fresh seeds.
    fn conclude(&self, groups: &[Group], all: &[Optimisation]) -> Result<Vec<Found>, ExperimentError> {
        let context = self.context;
        let each = |(group, one): (&Group, &Optimisation)| self.conclude_one(group, &one.optimiser);
        let mut found = context.executor.think(|| groups.par_iter().zip(all).map(each).collect::<Vec<_>>());
        let once_more = |(group, one): (&Group, &Optimisation)| {
            let Some(best) = one.optimiser.best_observed() else { return Ok(Vec::new()) };
            let name = self.name(group);
            let again = format!("{name}/evaluation={}", best.id);
            let again = self.cases(&again, group, &best.point, self.search.runs)?;
            Ok(vec![again, self.cases(&format!("{name}/fresh"), group, &best.point, FRESH_RUNS)?])
        };
        let cases = context.executor.think(|| groups.par_iter().zip(all).map(once_more).collect::<Vec<_>>());
        let cases = cases.into_iter().collect::<Result<Vec<_>, ExperimentError>>()?.concat();
        let mut outcomes = context.run_all(1, &cases.concat())?.into_iter();
        let mut cases = cases.iter();
        let known = PlausiblePeople::of(self.search, self.scenario);
        for (one, found) in all.iter().zip(&mut found) {
            let Some(best) = one.optimiser.best_observed() else { continue };
            let mut next = || {
                let cases = cases.next().expect("there are two of each that has a best point");
                (cases, outcomes.by_ref().take(cases.len()).collect::<Vec<_>>())
            };
            let ((again, runs), (_, fresh)) = (next(), next());
            found.passed_first = runs.first().and_then(|outcome| context.passed_first(outcome));
            found.plausibility = again.first().and_then(|case| known.of_case(case));
            found.kept = runs.iter().map(|outcome| self.keeps(outcome)).collect();
            found.runs = self.saved(&best.point, again, runs);
            found.fresh = self.objective(&fresh).0;
            let decided = context.seen(self.search.objective.aggregate.metric(), &fresh);
            found.fresh_runs = decided.iter().filter(|one| one.is_value()).count() as u32;
        }
        Ok(found)
    }

    /// What the optimiser found, of which nothing is run yet.
    fn conclude_one(&self, group: &Group, optimiser: &Optimiser) -> Found {
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
        let predictions = optimiser.predictions().unwrap_or_default();
        found.predicted =
            predictions.iter().find(|one| one.point == best.point).map(|one| (one.mean, one.deviation));
        for dimension in 0..self.search.over.len() {
            found
                .slices
                .push(optimiser.surrogate_slice(dimension, &best.point, SLICE_STEPS).unwrap_or_default());
        }
        found
    }

    fn objective(&self, outcomes: &[Outcome]) -> (Option<f64>, Option<f64>) {
        let Objective { aggregate, direction, .. } = &self.search.objective;
        self.context.objective(aggregate, *direction, outcomes)
    }

    /// Whether a run at the best point is one that the search was to keep; without a condition all are.
    fn keeps(&self, outcome: &Outcome) -> bool {
        let Some(keep) = &self.search.keep else { return true };
        self.context.seen(&keep.metric, std::slice::from_ref(outcome))[0].holds(keep, false)
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
        });
        self.context.case_runs(saved, outcomes)
    }

    /// Gives those who were kept, the worst first, their courses.
    fn follow(&self, groups: &[Group], found: &mut [Found]) -> Result<(), ExperimentError> {
        if self.search.keep.is_none() || self.search.together {
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
        let mut outcomes = self.context.run_all(1, &cases)?.into_iter();
        for AskedPoint { group, over, at, cases } in asked {
            let outcomes: Vec<_> = outcomes.by_ref().take(cases.len()).collect();
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
        group: &Group,
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
                let key = format!("{}/course={over}", self.name(group));
                let cases = self.cases(&key, group, &point, COURSE_RUNS)?;
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
