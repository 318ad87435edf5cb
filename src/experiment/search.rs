//! `search`: the plausible case that is worst, per individual or over the whole population.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::journal::Record;
use super::{ExperimentError, Laboratory, Progress, overrides};
use crate::numbers::random::derive_seed;
use crate::numbers::summary::mean;
use crate::optimise::{
    self, Definition, Evaluation, InitialDesign, Method, ObjectiveValue, Optimiser, Proposal,
};
use crate::plan;
use crate::results::{CaseRun, Course, CoursePoint, Found, Outcome, SavedCase, SavedSet, SearchResult};
use crate::scenario::{
    self, Assignment, Budget, Case, Goal, Individual, Objective, Range, Scenario, Search, ShownIn,
};

/// Runs with fresh seeds that tell how much of a best value was luck.
const FRESH_RUNS: u32 = 20;

/// Points of a slice through the surrogate.
const SLICE_STEPS: usize = 101;

/// How many individuals get a [`Course`]: those that were kept, the worst first.
const MOST_COURSES: usize = 12;
/// Values of a dimension that a course is run at.
const COURSE_STEPS: usize = 25;
/// Runs at each of them.
const COURSE_RUNS: u32 = 10;

/// Runs one search to its end.
///
/// # Errors
/// Whatever keeps it from a result; evaluations without a value are not errors but count as undefined.
pub fn run_search(
    laboratory: &Laboratory,
    search: &Search,
    progress: &dyn Progress,
) -> Result<SearchResult, ExperimentError> {
    let scenario = with_individuals(laboratory.scenario(&search.scenario)?, search);
    let people = plan::select_people(laboratory.suite.seed, &scenario)?;
    let groups: Vec<Vec<Vec<Individual>>> =
        if search.together { vec![people] } else { people.into_iter().map(|group| vec![group]).collect() };
    let hunt = Hunt {
        laboratory,
        search,
        scenario: &scenario,
        progress,
        done: AtomicUsize::new(0),
        all: groups.len() * search.budget.evaluations as usize,
    };
    let hunted: Vec<_> = groups.par_iter().map(|group| hunt.hunt(group)).collect::<Result<_, _>>()?;
    let (mut found, records): (Vec<Found>, Vec<Record>) = hunted.into_iter().unzip();
    hunt.follow(&groups, &mut found)?;
    // Only now: a search that is cut off repeats nobody.
    records.into_iter().for_each(Record::remove);
    let kept = found.iter().flat_map(Found::kept_cases).cloned().collect();
    Ok(SearchResult {
        name: search.name.clone(),
        objective: search.objective.text.clone(),
        direction: search.objective.direction,
        shown_in: search.over.iter().map(Range::shown_in).collect(),
        objective_in: ShownIn::new(search.objective.notation, &search.objective.aggregate.unit()),
        metrics: laboratory.requests.iter().map(|reference| reference.label()).collect(),
        kept: SavedSet {
            name: search.name.clone(),
            source: format!(
                "search {} of suite {}, seed {}, scenario-runner {}",
                search.name,
                laboratory.suite.name,
                laboratory.suite.seed,
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
            && let Some(first) = scenario.pedestrians.first_mut()
        {
            first.individuals = Some(individuals.clone());
        }
    }
    scenario
}

/// The optimiser's definition for a budget.
pub(super) fn definition(
    space: optimise::Space,
    budget: &Budget,
    goals: Vec<Goal>,
    constraints: usize,
    seed: u64,
) -> Definition {
    let objectives = goals
        .iter()
        .map(|goal| match goal {
            Goal::Minimise => optimise::Goal::Minimise,
            Goal::Maximise => optimise::Goal::Maximise,
        })
        .collect();
    Definition {
        objectives,
        constraints,
        budget: budget.evaluations as usize,
        initial: budget.initial as usize,
        initial_design: match budget.initial_design {
            scenario::InitialDesign::Random => InitialDesign::Random,
            scenario::InitialDesign::Stratified => InitialDesign::Stratified,
        },
        method: match budget.method {
            scenario::Method::Bayesian => Method::Bayesian,
            scenario::Method::GpMinimizeLike => Method::GpMinimizeLike { penalty: PENALTY },
            scenario::Method::Random => Method::Random,
            scenario::Method::LatinHypercube => Method::LatinHypercube,
            scenario::Method::Sobol => Method::Sobol,
            scenario::Method::Grid => Method::Grid,
        },
        ..Definition::new(space, seed)
    }
}

/// What an infeasible evaluation counts as in the reference's method: larger than any time in s.
const PENALTY: f64 = 1000.0;

/// One search under way.
struct Hunt<'a> {
    laboratory: &'a Laboratory<'a>,
    search: &'a Search,
    scenario: &'a Scenario,
    progress: &'a dyn Progress,
    done: AtomicUsize,
    all: usize,
}

impl Hunt<'_> {
    /// Searches for one group of people, who are all in every evaluation.
    fn hunt(&self, group: &[Vec<Individual>]) -> Result<(Found, Record), ExperimentError> {
        let suite = self.laboratory.suite;
        let name = self.name(group);
        let space = overrides::space(&self.search.over)?;
        let seed = derive_seed(suite.seed, &name);
        let goals = vec![self.search.objective.direction];
        let definition = definition(space, &self.search.budget, goals, 0, seed);
        let batch = self.search.budget.batch as usize;
        let inputs = (suite.seed, &name, self.scenario, self.search, group);
        let mut record =
            Record::open(self.laboratory.journals.as_deref(), &name, &inputs, &definition, batch)?;
        self.laboratory.tell(record.notice());
        let mut optimiser = Optimiser::new(definition)?;
        optimise::try_run(&mut optimiser, batch, record.journal(), |proposal| {
            self.evaluate(&name, group, proposal)
        })?;
        Ok((self.conclude(&name, group, &optimiser)?, record))
    }

    /// The beginning of the keys of a group's runs.
    fn name(&self, group: &[Vec<Individual>]) -> String {
        let label = if self.search.together { String::new() } else { plan::people_label(&group[0]) };
        format!("{}/{}{label}", self.laboratory.suite.name, self.search.name)
    }

    fn evaluate(
        &self,
        name: &str,
        group: &[Vec<Individual>],
        proposal: &Proposal,
    ) -> Result<Evaluation, ExperimentError> {
        let cases = self.cases(
            &format!("{name}/evaluation={}", proposal.id),
            group,
            &proposal.point,
            self.search.runs,
        )?;
        let outcomes = self.laboratory.run_all(&cases)?;
        let (value, noise_variance) = self.objective(&outcomes);
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.progress.evaluated(done, self.all, value);
        Ok(Evaluation {
            objectives: vec![ObjectiveValue { value, noise_variance }],
            margins: Vec::new(),
            repetitions: self.search.runs,
        })
    }

    /// The cases of one evaluation: everybody, in every variation that is not searched, `runs` times.
    fn cases(
        &self,
        key: &str,
        group: &[Vec<Individual>],
        point: &[optimise::Value],
        runs: u32,
    ) -> Result<Vec<Case>, ExperimentError> {
        let mut scenario = overrides::without_variations(self.scenario, &self.search.over);
        overrides::apply(&mut scenario, &overrides::settings(&self.search.over, point))?;
        let fixed = overrides::assignments(&self.search.over, point);
        let mut cases = Vec::new();
        let seed = self.laboratory.suite.seed;
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
                    let seed = derive_seed(self.laboratory.suite.seed, &key);
                    let people = people.clone();
                    cases.push(plan::concrete_case(&scenario, key, variation.clone(), people, run, seed)?);
                }
            }
        }
        Ok(cases)
    }

    fn conclude(
        &self,
        name: &str,
        group: &[Vec<Individual>],
        optimiser: &Optimiser,
    ) -> Result<Found, ExperimentError> {
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
            evaluations,
            stop: optimiser.stop_reason(),
            slices: Vec::new(),
            runs: Vec::new(),
            kept: Vec::new(),
            courses: Vec::new(),
        };
        let Some(best) = optimiser.best_observed() else { return Ok(found) };
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
        let evaluation_key = format!("{name}/evaluation={}", best.id);
        let cases = self.cases(&evaluation_key, group, &best.point, self.search.runs)?;
        let outcomes = self.laboratory.run_all(&cases)?;
        found.passed_first = outcomes.first().and_then(|outcome| self.laboratory.passed_first(outcome));
        found.kept = outcomes.iter().map(|outcome| self.keeps(outcome)).collect();
        found.runs = self.saved(&best.point, &cases, outcomes);
        let fresh = self.cases(&format!("{name}/fresh"), group, &best.point, FRESH_RUNS)?;
        let outcomes = self.laboratory.run_all(&fresh)?;
        found.fresh = self.objective(&outcomes).0;
        let metric = self.search.objective.aggregate.metric();
        let decided = self.laboratory.seen(metric, &outcomes);
        found.fresh_runs = decided.iter().filter(|one| one.is_value()).count() as u32;
        Ok(found)
    }

    fn objective(&self, outcomes: &[Outcome]) -> (Option<f64>, Option<f64>) {
        let Objective { aggregate, direction, .. } = &self.search.objective;
        self.laboratory.objective(aggregate, *direction, outcomes)
    }

    /// Whether a run at the best point is one that the search was to keep; without a condition all are.
    fn keeps(&self, outcome: &Outcome) -> bool {
        let Some(keep) = &self.search.keep else { return true };
        self.laboratory.seen(&keep.metric, std::slice::from_ref(outcome))[0].holds(keep, false)
    }

    /// Runs as cases to be used again, with what came of them.
    fn saved(&self, point: &[optimise::Value], cases: &[Case], outcomes: Vec<Outcome>) -> Vec<CaseRun> {
        let values = self.laboratory.values(self.search.objective.aggregate.metric(), &outcomes);
        let settings = overrides::settings(&self.search.over, point);
        let saved = cases.iter().zip(values).map(|(case, value)| SavedCase {
            key: case.key.clone(),
            scenario: case.scenario.clone(),
            variation: case.variation.clone(),
            settings: settings.clone(),
            individuals: case.individuals.clone(),
            seed: case.seed,
            value,
        });
        self.laboratory.case_runs(saved, outcomes)
    }

    /// Gives those who were kept, the worst first, their courses.
    fn follow(&self, groups: &[Vec<Vec<Individual>>], found: &mut [Found]) -> Result<(), ExperimentError> {
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
        let course = |(_, index): &(f64, usize)| Ok((*index, self.courses(&groups[*index], &found[*index])?));
        let courses: Vec<_> = kept.par_iter().map(course).collect::<Result<_, ExperimentError>>()?;
        for (index, courses) in courses {
            found[index].courses = courses;
        }
        Ok(())
    }

    fn courses(&self, group: &[Vec<Individual>], found: &Found) -> Result<Vec<Course>, ExperimentError> {
        let best: Vec<_> = found.best.iter().flatten().map(|(_, value)| value.clone()).collect();
        let mut courses = Vec::new();
        for (dimension, range) in self.search.over.iter().enumerate() {
            let dimension_values = overrides::dimension(range);
            if dimension_values.is_categorical() {
                continue;
            }
            let place = |step| dimension_values.value(step as f64 / (COURSE_STEPS - 1) as f64);
            let mut steps: Vec<optimise::Value> = (0..COURSE_STEPS).map(place).collect();
            steps.dedup();
            let over = range.target.to_string();
            let mut points = Vec::new();
            for step in steps {
                let Some(at) = step.number() else { continue };
                let mut point = best.clone();
                point[dimension] = step;
                let cases =
                    self.cases(&format!("{}/course={over}", self.name(group)), group, &point, COURSE_RUNS)?;
                let outcomes = self.laboratory.run_all(&cases)?;
                let metric = self.search.objective.aggregate.metric();
                let mut values: Vec<f64> =
                    self.laboratory.values(metric, &outcomes).into_iter().flatten().collect();
                values.sort_by(f64::total_cmp);
                if let (Some(smallest), Some(mean), Some(largest)) =
                    (values.first(), mean(&values), values.last())
                {
                    points.push(CoursePoint {
                        at,
                        smallest: *smallest,
                        mean,
                        largest: *largest,
                        runs: values.len(),
                    });
                }
            }
            courses.push(Course { over, points });
        }
        Ok(courses)
    }
}
