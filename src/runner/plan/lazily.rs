//! The trials of a scenario and their runs by their indices: each is worked out when somebody asks for it.

use std::borrow::Cow;
use std::collections::HashSet;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use super::arrival::{check_arrivals, check_drawn_arrivals};
use super::drawable::{CutOffDraw, DrawnTrial};
use super::draws::{DrawAxis, DrawnRun, RunDraws, is_outermost};
use super::error::PlanError;
use super::individuals::{label, select};
use super::sampling::digest;
use super::setup;
use super::variables::{Variables, criteria, criteria_of_all, variables};
use super::variation::Combinations;
use numbers::random::derive_seed;
use scenario::{
    Assignment, Case, Criterion, DeclaredDraw, Individual, Rounds, RunBudget, Scenario, Suite, Trial, World,
};

/// More runs than this in one suite are taken for a mistake.
const MOST_RUNS: usize = 10_000_000;

/// More combinations than this are not tried out before a run.
const MOST_PROBES: usize = 10_000;

/// So many trials are looked at by one thread.
const SIDE_BY_SIDE: usize = 256;

/// Of drawn runs so many stand for all where worlds are looked at.
const WORLDS_OF_DRAWN: usize = 64;

/// Stands before the coordinates in the name of a run that is at a point of its own.
const AT_POINT: &str = "/u=";

/// Stands in the name of a run before the scenario of which it has the chance.
const CHANCE_OF: &str = "/chance=";

/// A trial before its runs are worked out: what it is called, how many runs it has, what is asked of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    pub key: String,
    pub variation: Vec<Assignment>,
    /// All that there may be.
    pub runs: usize,
    /// As [`Trial::rounds`].
    pub rounds: Option<Rounds>,
    /// As [`Trial::criteria`].
    pub criteria: Arc<[Criterion]>,
}

/// What is planned of a scenario: all that its trials have in common.
#[derive(Debug, Clone)]
pub struct ScenarioPlan(Arc<Common>);

#[derive(Debug)]
struct Common {
    suite: String,
    /// As [`Suite::apart`].
    apart: String,
    seed: u64,
    /// The groups of people that every trial is run with.
    people: Vec<Vec<Individual>>,
    /// What is drawn in every run, if anything is.
    draws: Option<RunDraws>,
    combinations: Combinations<'static>,
    rounds: Option<Rounds>,
    /// Of a trial.
    runs: usize,
    /// Of every trial, if they are the same.
    criteria: Option<Arc<[Criterion]>>,
}

/// A trial with its runs.
#[derive(Debug, Clone)]
pub struct PlannedTrial {
    /// What is judged.
    pub trial: Arc<Trial>,
    /// One per individual and repetition; never empty. Where runs are added until the criteria are decided, all that there
    /// may be, in that order.
    pub cases: Cases,
}

impl Deref for PlannedTrial {
    type Target = Trial;

    fn deref(&self) -> &Trial {
        &self.trial
    }
}

/// The runs of a trial, each made when somebody asks for it.
#[derive(Debug, Clone)]
pub struct Cases(Source);

#[derive(Debug, Clone)]
enum Source {
    Planned(Planned),
    /// As they are, of a trial that nobody planned.
    Listed(Vec<Case>),
}

#[derive(Debug, Clone)]
struct Planned {
    of: ScenarioPlan,
    trial: Arc<Trial>,
    /// How many groups of people walk, and how often each.
    people: usize,
    repetitions: usize,
    /// Whether everybody walks once before anybody walks again.
    in_rounds: bool,
    /// The scenario whose chance runs have, if that is another: their seeds are those of its runs.
    chance_of: Option<Arc<str>>,
    /// One per group of people, shared by all repetitions.
    worlds: Arc<[OnceLock<Arc<World>>]>,
}

impl ScenarioPlan {
    pub(super) fn new(suite: &Suite, scenario: &Scenario) -> Result<Self, PlanError> {
        let people = select(suite.seed, scenario)?;
        let draws = RunDraws::of(scenario, &Variables::new(), &[])?;
        let owned = Cow::Owned(scenario.clone());
        let combinations = Combinations::new(suite.seed, owned, Variables::new())?;
        let budget = scenario.runs.as_ref();
        let rounds = budget.map(|budget| rounds(scenario, budget, people.len())).transpose()?;
        let repeated = people.len().saturating_mul(scenario.repeat as usize);
        let runs = rounds.map_or(repeated, |rounds| rounds.most);
        let all = combinations.count().saturating_mul(runs);
        if all > MOST_RUNS {
            let message = format!("scenario `{}` asks for {all} runs, more than {MOST_RUNS}", scenario.name);
            return Err(
                PlanError::new(&scenario.origin, message).with_hint("vary fewer values or repeat less often")
            );
        }
        let (apart, criteria) = (suite.apart.clone(), criteria_of_all(scenario));
        let (suite, seed) = (suite.name.clone(), suite.seed);
        Ok(Self(Arc::new(Common { suite, apart, seed, people, draws, combinations, rounds, runs, criteria })))
    }

    /// How many trials there are.
    pub fn len(&self) -> usize {
        self.0.combinations.count()
    }

    /// Whether there is no trial.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The scenario.
    pub fn scenario(&self) -> &Scenario {
        self.0.combinations.scenario()
    }

    /// How many runs a trial has, all that there may be.
    pub fn runs(&self) -> usize {
        self.0.runs
    }

    /// The name of the trial with this index below [`Self::len`].
    pub fn trial_key(&self, index: usize) -> String {
        self.key(&self.variation(index))
    }

    /// Its values.
    pub fn variation(&self, index: usize) -> Vec<Assignment> {
        self.0.combinations.get(index).expect("it was planned before")
    }

    /// How many runs a trial has for certain.
    pub fn certain_runs(&self) -> usize {
        self.0.rounds.map_or(self.0.runs, |rounds| rounds.least)
    }

    /// The name of a trial.
    fn key(&self, variation: &[Assignment]) -> String {
        self.key_of(&self.scenario().name, variation)
    }

    /// The same of a scenario of that name.
    fn key_of(&self, scenario: &str, variation: &[Assignment]) -> String {
        let mut key = format!("{}{}/{scenario}", self.0.apart, self.0.suite);
        for assignment in variation {
            key.extend(["/", &assignment.name, "=", &assignment.label]);
        }
        key
    }

    /// The trial with this index, without working out its worlds.
    fn outline(&self, index: usize) -> Result<Outline, PlanError> {
        let variation = self.0.combinations.get(index)?;
        self.outline_of(self.key(&variation), variation)
    }

    fn outline_of(&self, key: String, variation: Vec<Assignment>) -> Result<Outline, PlanError> {
        let (scenario, Common { rounds, runs, .. }) = (self.scenario(), &*self.0);
        let criteria = match &self.0.criteria {
            Some(all) => all.clone(),
            None => criteria(scenario, &variables(&variation)).map_err(|error| error.in_case(&key))?,
        };
        Ok(Outline { key, variation, runs: *runs, rounds: *rounds, criteria })
    }

    /// All of them, of which no two have one name.
    fn outlines(&self) -> impl Iterator<Item = Result<Outline, PlanError>> + use<> {
        let plan = self.clone();
        let mut keys: HashSet<[u8; 16]> = HashSet::new();
        (0..self.len()).map(move |index| {
            let variation = plan.0.combinations.get(index)?;
            let key = plan.key(&variation);
            if !keys.insert(digest([key.as_str()].into_iter())) {
                let scenario = plan.scenario();
                let message = format!("scenario `{}` has two trials named `{key}`", scenario.name);
                return Err(PlanError::new(&scenario.origin, message).with_hint("list every value once"));
            }
            plan.outline_of(key, variation)
        })
    }

    /// The trial with this index, with all that it may have, or with some of it.
    fn planned(&self, index: usize, part: Part) -> Result<PlannedTrial, PlanError> {
        Ok(self.planned_of(self.outline(index)?, part))
    }

    fn planned_of(&self, outline: Outline, part: Part) -> PlannedTrial {
        let Outline { key, variation, runs, rounds, criteria } = outline;
        let all = self.0.people.len();
        let (people, repetitions) = match part {
            Part::Whole => (all, runs / all),
            Part::Everybody => (all, 1),
            Part::First => (1, 1),
        };
        let scenario = self.scenario();
        let trial = Arc::new(Trial {
            scenario: scenario.name.clone(),
            doc: scenario.doc.clone(),
            tags: scenario.tags.clone(),
            runs: people * repetitions,
            first_run: format!("{key}{}/rep=1", label(&self.0.people[0])),
            rounds: rounds.filter(|_| part == Part::Whole),
            criteria,
            declared: scenario.criteria.len(),
            key,
            variation,
            origin: scenario.origin.clone(),
        });
        let worlds = (0..people).map(|_| OnceLock::new()).collect();
        let in_rounds = rounds.is_some();
        let planned = Planned {
            of: self.clone(),
            trial: trial.clone(),
            people,
            repetitions,
            in_rounds,
            chance_of: None,
            worlds,
        };
        PlannedTrial { trial, cases: Cases(Source::Planned(planned)) }
    }

    /// The trial with this index below [`Self::len`].
    pub fn trial(&self, index: usize) -> PlannedTrial {
        self.planned(index, Part::Whole).expect("it was planned before")
    }

    /// Checks that all pedestrians of a scenario that draws appear at the times that are written.
    fn check_drawn(&self) -> Result<(), PlanError> {
        let each = self.runs();
        let case = |run: usize| self.trial(run / each).cases.get(run % each);
        check_drawn_arrivals(self.scenario(), self.len().saturating_mul(each), case)
    }

    /// Every trial.
    pub fn trials(&self) -> impl Iterator<Item = PlannedTrial> {
        (0..self.len()).map(|index| self.trial(index))
    }
}

/// How much of a trial is planned.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Whole,
    /// Nothing repeated.
    Everybody,
    /// The first of them only.
    First,
}

impl From<Vec<Case>> for Cases {
    fn from(listed: Vec<Case>) -> Self {
        Self(Source::Listed(listed))
    }
}

impl Cases {
    /// How many runs there may be.
    pub fn len(&self) -> usize {
        match &self.0 {
            Source::Planned(planned) => planned.people * planned.repetitions,
            Source::Listed(listed) => listed.len(),
        }
    }

    /// Whether there are none; a trial that was planned has at least one.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The run with this index below [`Self::len`].
    pub fn get(&self, index: usize) -> Case {
        match &self.0 {
            Source::Planned(planned) => planned.case(index),
            Source::Listed(listed) => listed[index].clone(),
        }
    }

    /// Every run.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Case> {
        self.from(0)
    }

    /// Every run from this index on.
    pub fn from(&self, first: usize) -> impl ExactSizeIterator<Item = Case> {
        (first..self.len()).map(|index| self.get(index))
    }

    /// The name of the run with this index.
    pub fn key(&self, index: usize) -> String {
        match &self.0 {
            Source::Planned(planned) => planned.key(index).0,
            Source::Listed(listed) => listed[index].key.clone(),
        }
    }

    /// What is drawn in every run: the axes of the points that runs are at. None where nothing is.
    pub fn axes(&self) -> Vec<DrawAxis> {
        match &self.0 {
            Source::Planned(Planned { of, .. }) => {
                of.0.draws.as_ref().map_or_else(Vec::new, |draws| draws.axes(of.scenario()))
            }
            Source::Listed(_) => Vec::new(),
        }
    }

    /// Of each axis what its rows or people weigh, each of which has a part of 0..1 in proportion, in their order; `None` of a number.
    pub fn axis_weights(&self) -> Vec<Option<Vec<f64>>> {
        let Source::Planned(Planned { of, .. }) = &self.0 else { return Vec::new() };
        let Some(draws) = &of.0.draws else { return Vec::new() };
        (0..draws.len()).map(|axis| draws.weights(of.scenario(), axis)).collect()
    }

    /// Whether every run draws something.
    pub fn are_drawn(&self) -> bool {
        !self.axes().is_empty()
    }

    /// The point of the run with this index: one coordinate an axis, each uniform between 0 and 1 whatever is drawn with it, and
    /// independent of the others. [`Self::at`] that point is the run.
    ///
    /// # Errors
    /// If what is drawn is not possible.
    pub fn point(&self, index: usize) -> Result<Vec<f64>, PlanError> {
        match &self.0 {
            Source::Planned(planned) => match planned.drawn(index) {
                Some(drawn) => drawn.map(|(point, _)| point),
                None => Ok(Vec::new()),
            },
            Source::Listed(_) => Ok(Vec::new()),
        }
    }

    /// The run with this index, drawn as at `point`: with that run's seed, so that at its own point it is the same bit for bit, and named
    /// after the point, so that it can be made again. Points that are drawn with another density than 1 weigh 1 / density.
    ///
    /// # Errors
    /// If there is no such run.
    ///
    /// # Panics
    /// If the point does not have one coordinate an axis, each between 0 and 1.
    pub fn at(&self, index: usize, point: &[f64]) -> Result<Case, PlanError> {
        assert_eq!(point.len(), self.axes().len(), "a point has one coordinate an axis");
        assert!(point.iter().all(|share| *share > 0.0 && *share < 1.0), "{point:?} is not between 0 and 1");
        let Source::Planned(planned) = &self.0 else { return Ok(self.get(index)) };
        let Some(draws) = &planned.of.0.draws else { return Ok(self.get(index)) };
        let (run, seed) = planned.key(index);
        let coordinates: Vec<_> = point.iter().map(f64::to_string).collect();
        let key = format!("{run}{AT_POINT}{}", coordinates.join(","));
        let variables = variables(&planned.trial.variation);
        let drawn = draws.at(planned.of.scenario(), &variables, planned.fixed(index), point);
        let drawn = drawn.map_err(|error| error.in_case(&key))?;
        Ok(planned.drawn_case(key, seed, index, drawn))
    }

    /// As [`Self::at`]; `None` of a point that is not possible and lies so far out that no run is at it: one that would be is drawn again.
    ///
    /// # Errors
    /// If there is no such run, and it is not far out.
    ///
    /// # Panics
    /// As [`Self::at`].
    pub fn at_drawn(&self, index: usize, point: &[f64]) -> Result<Option<Case>, PlanError> {
        match self.at(index, point) {
            Ok(case) => Ok(Some(case)),
            Err(_) if is_outermost(point) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The same runs with the seeds that those of another scenario of the suite have, and named after it: what both draw, and what happens
    /// by chance beyond that, is the same in runs of one number, provided that the scenarios have one `seed` and vary the same.
    pub fn with_chance_of(&self, scenario: &str) -> Self {
        Self(match &self.0 {
            Source::Planned(planned) => {
                Source::Planned(Planned { chance_of: Some(scenario.into()), ..planned.clone() })
            }
            listed @ Source::Listed(_) => listed.clone(),
        })
    }

    /// The run of that name, be it [at a point](Self::at) of its own.
    pub fn named(&self, key: &str) -> Option<Case> {
        let (run, point) = key.split_once(AT_POINT).map_or((key, None), |(run, point)| (run, Some(point)));
        let Some(point) = point else {
            let index = (0..self.len()).find(|index| self.key(*index) == run)?;
            return Some(self.get(index));
        };
        // An estimate makes more runs of a trial than it has by itself, at points of their own, and may compare two in the same chance.
        match run.split_once(CHANCE_OF) {
            None => self.with_repetition(run)?.named_at(run, point),
            Some((_, scenario)) if scenario.contains(['/', '=']) => None,
            Some((own, scenario)) => self.with_repetition(own)?.with_chance_of(scenario).named_at(run, point),
        }
    }

    /// The run of that name as it is with another seed: all that is drawn is drawn anew from that. `None` if there is none, or it is at a
    /// point of its own.
    pub fn named_with_seed(&self, key: &str, seed: u64) -> Option<Result<Case, PlanError>> {
        let index = (0..self.len()).find(|index| self.key(*index) == key)?;
        let planned = match &self.0 {
            Source::Planned(planned) => planned,
            Source::Listed(listed) => return Some(Ok(Case { seed, ..listed[index].clone() })),
        };
        let run = match &planned.of.0.draws {
            None => {
                let (individuals, world) =
                    (planned.fixed(index).to_vec(), planned.world(planned.place(index).0));
                DrawnRun { drawn: Vec::new(), individuals, world }
            }
            Some(draws) => {
                let (scenario, variables) = (planned.of.scenario(), variables(&planned.trial.variation));
                match draws.run(scenario, &variables, planned.fixed(index), seed) {
                    Ok((_, run)) => run,
                    Err(error) => return Some(Err(error.in_case(key))),
                }
            }
        };
        Some(Ok(planned.drawn_case(key.to_string(), seed, index, run)))
    }

    fn named_at(&self, run: &str, point: &str) -> Option<Case> {
        let index = (0..self.len()).rev().find(|index| self.key(*index) == run)?;
        let point: Vec<f64> = point.split(',').map(|share| share.parse().ok()).collect::<Option<_>>()?;
        let is_point =
            point.len() == self.axes().len() && point.iter().all(|share| *share > 0.0 && *share < 1.0);
        if is_point { self.at(index, &point).ok() } else { None }
    }

    /// With as many repetitions as a run of that name takes.
    fn with_repetition(&self, run: &str) -> Option<Self> {
        let (_, repetition) = run.rsplit_once("/rep=")?;
        let repetition: usize = repetition.parse().ok().filter(|one| (1..=MOST_RUNS).contains(one))?;
        Some(match &self.0 {
            Source::Planned(planned) => {
                let repetitions = planned.repetitions.max(repetition);
                Self(Source::Planned(Planned { repetitions, ..planned.clone() }))
            }
            Source::Listed(_) => self.clone(),
        })
    }

    /// The run in the middle of all that is drawn, by the name and seed of the first; `None` where nothing is drawn.
    pub fn middle(&self) -> Option<Case> {
        let Source::Planned(planned) = &self.0 else { return None };
        planned.of.0.draws.as_ref()?;
        let DrawnRun { drawn, individuals, world } = planned.middle(0);
        Some(Case { drawn, individuals, world, impossible: None, ..self.get(0) })
    }

    /// What is declared to be drawn in every run, without people.
    pub fn declared_draws(&self) -> &[DeclaredDraw] {
        match &self.0 {
            Source::Planned(planned) => &planned.of.scenario().draws,
            Source::Listed(_) => &[],
        }
    }

    /// The first run.
    pub fn first(&self) -> Case {
        self.get(0)
    }

    /// The world of each group of people: those of all runs, each once. Where runs are drawn each has its own, and those of the first
    /// stand for all.
    pub fn worlds(&self) -> Vec<Arc<World>> {
        match &self.0 {
            Source::Planned(_) if self.are_drawn() => {
                (0..self.len().min(WORLDS_OF_DRAWN)).map(|run| self.get(run).world).collect()
            }
            Source::Planned(planned) => (0..planned.people).map(|who| planned.world(who)).collect(),
            Source::Listed(listed) => {
                let mut worlds: Vec<Arc<World>> = Vec::new();
                for case in listed {
                    if !worlds.iter().any(|known| Arc::ptr_eq(known, &case.world)) {
                        worlds.push(case.world.clone());
                    }
                }
                worlds
            }
        }
    }

    /// Works out all worlds, to `keep` them or to see that they are possible.
    fn check(&self, keep: bool, everybody: bool) -> Result<(), PlanError> {
        let Source::Planned(planned) = &self.0 else { return Ok(()) };
        for who in 0..planned.people {
            let people = &planned.of.0.people[who];
            if let Some(draws) = &planned.of.0.draws {
                let (scenario, variables) = (planned.of.scenario(), variables(&planned.trial.variation));
                let trial = DrawnTrial { draws, scenario, variables: &variables, fixed: people };
                trial.check(everybody && who == 0).map_err(|error| error.in_case(&planned.trial.key))?;
                continue;
            }
            let world = planned.resolve(who, world_to_begin)?;
            if keep {
                planned.worlds[who].get_or_init(|| world);
            }
        }
        Ok(())
    }
}

impl Planned {
    /// Who walks in a run, and which of their runs it is, from 1.
    fn place(&self, index: usize) -> (usize, u32) {
        let (who, repetition) = if self.in_rounds {
            (index % self.people, index / self.people)
        } else {
            (index / self.repetitions, index % self.repetitions)
        };
        (who, repetition as u32 + 1)
    }

    /// The name of a run, and its seed.
    fn key(&self, index: usize) -> (String, u64) {
        let (scenario, Common { seed, people, apart, .. }) = (self.of.scenario(), &*self.of.0);
        let (who, repetition) = self.place(index);
        let rest = format!("{}/rep={repetition}", label(&people[who]));
        let seeded = |key: &str| match scenario.seed {
            Some(seed) if repetition == 1 => seed,
            own => derive_seed(own.unwrap_or(*seed), key.strip_prefix(apart.as_str()).unwrap_or(key)),
        };
        let key = format!("{}{rest}", self.trial.key);
        let Some(other) = &self.chance_of else {
            let seed = seeded(&key);
            return (key, seed);
        };
        let theirs = self.of.key_of(other, &self.trial.variation);
        (format!("{key}{CHANCE_OF}{other}"), seeded(&format!("{theirs}{rest}")))
    }

    /// Those of a run who are the same in others.
    fn fixed(&self, index: usize) -> &[Individual] {
        &self.of.0.people[self.place(index).0]
    }

    /// What a run draws, with its point; `None` where nothing is drawn.
    fn drawn(&self, index: usize) -> Option<Result<(Vec<f64>, DrawnRun), PlanError>> {
        let draws = self.of.0.draws.as_ref()?;
        let (scenario, variables) = (self.of.scenario(), variables(&self.trial.variation));
        Some(draws.run(scenario, &variables, self.fixed(index), self.key(index).1))
    }

    fn case(&self, index: usize) -> Case {
        let who = self.place(index).0;
        let (key, seed) = self.key(index);
        let (impossible, run) = match self.drawn(index) {
            None => {
                let (individuals, world) = (self.fixed(index).to_vec(), self.world(who));
                (None, DrawnRun { drawn: Vec::new(), individuals, world })
            }
            Some(Ok((_, run))) => (None, run),
            // Whoever is to make it says so: it must not be missing among the others, which would then be others.
            Some(Err(error)) => (Some(error.message), self.middle(who)),
        };
        Case { impossible, ..self.drawn_case(key, seed, index, run) }
    }

    fn drawn_case(&self, key: String, seed: u64, index: usize, run: DrawnRun) -> Case {
        let (scenario, variation) = (self.of.scenario().name.clone(), self.trial.variation.clone());
        let repetition = self.place(index).1;
        let DrawnRun { drawn, individuals, world } = run;
        Case { key, scenario, variation, drawn, impossible: None, individuals, repetition, seed, world }
    }

    /// A run in the middle of all that is drawn.
    fn middle(&self, who: usize) -> DrawnRun {
        let (common, variables) = (&*self.of.0, variables(&self.trial.variation));
        let draws = common.draws.as_ref().expect("something is drawn");
        let run = draws.at(self.of.scenario(), &variables, &common.people[who], &draws.middle());
        run.expect("it was planned before")
    }

    fn world(&self, who: usize) -> Arc<World> {
        let planned = || self.resolve(who, setup::unchecked).expect("it was planned before");
        self.worlds[who].get_or_init(planned).clone()
    }

    fn resolve(&self, who: usize, resolve: Resolve) -> Result<Arc<World>, PlanError> {
        let (scenario, people) = (self.of.scenario(), &self.of.0.people);
        let world = resolve(scenario, &variables(&self.trial.variation), &people[who]);
        let in_case = |error: PlanError| error.in_case(&format!("{}{}", self.trial.key, label(&people[who])));
        world.map(Arc::new).map_err(in_case)
    }
}

/// A world of a scenario where the variations have these values, with these people in it.
type Resolve = fn(&Scenario, &Variables, &[Individual]) -> Result<World, PlanError>;

/// As [`setup::world`], for a world whose pedestrians appear at the times that are written.
fn world_to_begin(
    scenario: &Scenario,
    variables: &Variables,
    people: &[Individual],
) -> Result<World, PlanError> {
    let world = setup::world(scenario, variables, people)?;
    check_arrivals(scenario, &world)?;
    Ok(world)
}

/// The trials of one scenario in a suite, each worked out when it is asked for, without its worlds.
///
/// # Errors
/// If it cannot be planned at all. What is wrong with a trial comes in its place.
pub fn outline(
    suite: &Suite,
    scenario: &Scenario,
) -> Result<impl Iterator<Item = Result<Outline, PlanError>> + use<>, PlanError> {
    Ok(ScenarioPlan::new(suite, scenario)?.outlines())
}

/// The trials of one scenario in a suite, each of which is possible.
///
/// # Errors
/// The first thing that is not.
pub fn plan_scenario(suite: &Suite, scenario: &Scenario) -> Result<ScenarioPlan, PlanError> {
    let plan = ScenarioPlan::new(suite, scenario)?;
    plan.outlines().try_for_each(|outline| outline.map(|_| ()))?;
    let check = |index| plan.planned(index, Part::Everybody)?.cases.check(false, index == 0);
    if plan.0.combinations.are_independent() {
        let all = (0..plan.len()).into_par_iter().with_min_len(SIDE_BY_SIDE);
        all.find_map_first(|index| check(index).err()).map_or(Ok(()), Err)?;
    } else {
        (0..plan.len()).try_for_each(check)?;
    }
    plan.check_drawn()?;
    Ok(plan)
}

/// What of the draws of a scenario is left out since it cannot be run, as the first trial shows.
///
/// # Errors
/// If the scenario cannot be planned.
pub fn cut_off_draws(suite: &Suite, scenario: &Scenario) -> Result<Vec<CutOffDraw>, PlanError> {
    let plan = ScenarioPlan::new(suite, scenario)?;
    let Some(draws) = &plan.0.draws else { return Ok(Vec::new()) };
    let variables = variables(&plan.0.combinations.get(0)?);
    let trial = DrawnTrial { draws, scenario, variables: &variables, fixed: &plan.0.people[0] };
    trial.check(false)?;
    Ok(trial.cut_off())
}

/// A few runs of a scenario that show what can be wrong with all of them: the first person in every combination of
/// variations (or the first 10,000), everybody in the first combination, nothing repeated.
///
/// # Errors
/// The first thing that is not possible.
pub fn probe_scenario(suite: &Suite, scenario: &Scenario) -> Result<Vec<PlannedTrial>, PlanError> {
    let plan = ScenarioPlan::new(suite, scenario)?;
    let mut outlines = plan.outlines();
    let probed: Vec<Outline> = outlines.by_ref().take(MOST_PROBES).collect::<Result<_, _>>()?;
    outlines.try_for_each(|outline| outline.map(|_| ()))?;
    let probe = |(index, outline)| {
        let part = if index == 0 { Part::Everybody } else { Part::First };
        let trial = plan.planned_of(outline, part);
        trial.cases.check(true, index == 0)?;
        Ok(trial)
    };
    let probed = probed.into_iter().enumerate().map(probe).collect::<Result<Vec<_>, _>>()?;
    plan.check_drawn()?;
    Ok(probed)
}

/// Whole rounds: at least as many runs as asked for, and not more than may be.
fn rounds(scenario: &Scenario, budget: &RunBudget, people: usize) -> Result<Rounds, PlanError> {
    let (least, most) = (budget.least as usize, budget.most as usize);
    let most = most / people * people;
    let least = least.div_ceil(people) * people;
    if most < least {
        let message = format!(
            "`runs {} .. {}` hold no whole round of the {people} individuals of scenario `{}`",
            budget.least, budget.most, scenario.name
        );
        let enough = (budget.least as usize).div_ceil(people) * people;
        return Err(PlanError::new(&budget.origin, message).with_hint(format!(
            "everybody walks once a round: say at least `runs {} .. {enough}`",
            budget.least
        )));
    }
    Ok(Rounds { size: people, least, most })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use files::Disk;
    use models::standard;

    fn planned(file: &str) -> ScenarioPlan {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(file);
        let suite =
            lang::load(&path, &standard(), &Disk).unwrap_or_else(|_| panic!("{file} is a scenario")).suite;
        plan_scenario(&suite, &suite.scenarios[0]).expect("it can be planned")
    }

    fn known_worlds(trial: &PlannedTrial) -> usize {
        match &trial.cases.0 {
            Source::Planned(planned) => planned.worlds.iter().filter(|world| world.get().is_some()).count(),
            Source::Listed(listed) => listed.len(),
        }
    }

    #[test]
    fn criteria_that_trials_share_are_those_that_each_has_by_itself() {
        // Those of the first are the same everywhere, those of the second apply to some trials only.
        for (file, shares) in
            [("scenarios/zebra/scripted.scn", true), ("scenarios/zebra/commotions_carla.scn", false)]
        {
            let planned = planned(file);
            assert_eq!(planned.0.criteria.is_some(), shares, "{file}");
            for trial in planned.trials() {
                let own = criteria(planned.scenario(), &variables(&trial.variation)).unwrap();
                assert_eq!(trial.criteria, own, "{}", trial.key);
                assert!(!own.is_empty());
            }
        }
    }

    /// There may be a million: what is planned grows with neither trials nor runs, and what a trial holds not with its runs.
    #[test]
    fn no_world_and_no_run_is_there_before_somebody_asks() {
        let planned = planned("scenarios/zebra/commotions_carla.scn");
        let trial = planned.trial(2);
        assert_eq!((trial.cases.len(), known_worlds(&trial)), (20, 0));
        let last = trial.cases.get(19);
        assert_eq!(known_worlds(&trial), 1, "the world of one person");
        assert!(Arc::ptr_eq(&last.world, &trial.cases.get(16).world), "which all of their runs share");
        assert_eq!(trial.cases.iter().count(), 20);
        assert_eq!(known_worlds(&trial), 5);
        assert_eq!(known_worlds(&planned.trial(2)), 0, "and which the plan itself does not keep");
    }

    #[test]
    fn runs_have_their_places_whoever_asks_first() {
        for file in ["scenarios/zebra/commotions_carla.scn", "scenarios/zebra/carla_walker.scn"] {
            let planned = planned(file);
            for (index, trial) in planned.trials().enumerate() {
                let listed: Vec<Case> = trial.cases.iter().collect();
                let again = planned.trial(index);
                let backwards: Vec<Case> =
                    (0..again.cases.len()).rev().map(|run| again.cases.get(run)).collect();
                assert!(listed.iter().eq(backwards.iter().rev()), "{}", trial.key);
                assert_eq!(trial.first_run, listed[0].key);
                assert!(listed.iter().all(|case| case.key.starts_with(&trial.key)));
            }
        }
    }
}
