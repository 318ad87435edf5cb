//! Ask and tell: which points to evaluate next, given the evaluations so far. Knows nothing of simulations or workers.

use serde::{Deserialize, Serialize};

use super::Error;
use super::acquisition::{Acquisition, log_expected_improvement};
use super::definition::{Definition, InitialDesign, Method};
use super::design;
use super::history::{EvaluatedPoint, Evaluation};
use super::knowledge_gradient::KnowledgeGradient;
use super::maximise::maximise;
use super::models::{Models, Remembered};
use super::pareto;
use super::random::{Purpose, stream};
use super::reference::Hedge;
use super::space::{Coordinate, Point};
use super::surrogate::Surrogate;

/// Most visited places that the search for the acquisition's maximum looks around.
const ANCHORS: usize = 4;

/// A point to evaluate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Proposal {
    /// Its number, from 0 in the order of asking; [`Optimiser::tell`] wants it back.
    pub id: u64,
    /// Where to evaluate.
    pub point: Point,
    /// Why there.
    pub origin: ProposalOrigin,
}

/// Why a point was proposed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProposalOrigin {
    /// Part of the initial or the whole design.
    Design,
    /// The model's choice.
    Model(Acquisition),
    /// Random, because there was nothing yet to fit a model to, or it could not be fitted.
    Fallback,
}

/// Why no more points are proposed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OptimisationEnd {
    /// The budget is spent.
    Budget {
        /// How many it allowed.
        evaluations: usize,
    },
    /// Several proposals in a row promised less than the threshold; the last promised this much.
    NoExpectedImprovement {
        /// Expected improvement of the best point, in the unit of the objective.
        largest: f64,
    },
    /// Every point of the grid is evaluated.
    GridComplete {
        /// Points of the grid.
        points: usize,
    },
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Pending {
    id: u64,
    unit: Vec<f64>,
    point: Point,
    origin: ProposalOrigin,
}

/// The optimiser's whole state: plain data, serialisable, the same bits after a round trip.
///
/// What it proposes is a function of its definition, the sequence of asks and what was told before each of them; the order of
/// tells between two asks does not matter. So the size of a batch belongs to the definition of a run, the number of workers
/// that evaluate it does not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Optimiser {
    definition: Definition,
    /// In order of id.
    trials: Vec<EvaluatedPoint>,
    pending: Vec<Pending>,
    next_id: u64,
    /// Points of the caller's own choice before the first proposal: design and budget begin after them.
    given: u64,
    remembered: Remembered,
    hedge: Hedge,
    /// Proposals in a row that promised too little.
    quiet: u32,
    promised: f64,
}

impl Optimiser {
    /// An optimiser that has seen nothing.
    ///
    /// # Errors
    /// [`Error::Definition`] naming the setting that makes no sense.
    pub fn new(definition: Definition) -> Result<Self, Error> {
        definition.check()?;
        if definition.method == Method::Grid {
            let size = grid_size(&definition);
            if size > definition.budget {
                return Err(Error::Definition(format!(
                    "a grid of two levels a dimension has {size} points, more than the budget of {}; \
                     raise the budget or use sobol",
                    definition.budget
                )));
            }
        }
        Ok(Optimiser {
            definition,
            trials: Vec::new(),
            pending: Vec::new(),
            next_id: 0,
            given: 0,
            remembered: Remembered::default(),
            hedge: Hedge::default(),
            quiet: 0,
            promised: 0.0,
        })
    }

    /// What it was made from.
    pub fn definition(&self) -> &Definition {
        &self.definition
    }

    /// All evaluations, in order of asking.
    pub fn trials(&self) -> &[EvaluatedPoint] {
        &self.trials
    }

    /// Number of points asked for and not told yet.
    pub fn pending(&self) -> usize {
        self.pending.len()
    }

    /// Up to `count` more points to evaluate; none once a stop rule holds.
    ///
    /// Later points of a batch take into account that the earlier ones, and all others still pending, will be evaluated: the
    /// models believe their own means there (kriging believer).
    pub fn ask(&mut self, count: usize) -> Vec<Proposal> {
        let count =
            if self.stops().is_some() { 0 } else { count.min(self.last_id() - self.next_id as usize) };
        let mut proposals = Vec::with_capacity(count);
        for _ in 0..count {
            let id = self.next_id;
            let (unit, origin) = self.next_point(id);
            let point = self.definition.space.point(&unit);
            self.pending.push(Pending { id, unit, point: point.clone(), origin });
            self.next_id += 1;
            proposals.push(Proposal { id, point, origin });
        }
        proposals
    }

    /// Takes in the evaluation of a proposed point.
    ///
    /// # Errors
    /// [`Error::Unasked`] when no such proposal is pending; [`Error::Evaluation`] when it does not fit the definition.
    pub fn tell(&mut self, id: u64, evaluation: Evaluation) -> Result<(), Error> {
        let index = self.pending.iter().position(|pending| pending.id == id).ok_or(Error::Unasked(id))?;
        let evaluation = evaluation.checked(&self.definition)?;
        let Pending { id, unit, point, .. } = self.pending.remove(index);
        self.insert(EvaluatedPoint { id, unit, point, evaluation });
        Ok(())
    }

    /// Takes in the evaluation of a point of the caller's own choice. It counts towards the budget, unless it comes before the first
    /// proposal.
    ///
    /// # Errors
    /// [`Error::Value`] for a point outside the space; [`Error::Evaluation`] when it does not fit the definition.
    pub fn observe(&mut self, point: &[Coordinate], evaluation: Evaluation) -> Result<u64, Error> {
        let unit = self.definition.space.unit(point)?;
        let evaluation = evaluation.checked(&self.definition)?;
        let id = self.next_id;
        self.given += u64::from(self.given == id);
        self.next_id += 1;
        self.insert(EvaluatedPoint { id, unit, point: point.to_vec(), evaluation });
        Ok(id)
    }

    fn insert(&mut self, trial: EvaluatedPoint) {
        let place = self.trials.partition_point(|other| other.id < trial.id);
        self.trials.insert(place, trial);
    }

    /// Why the run is over; `None` while points may still be asked for or are pending.
    pub fn stop_reason(&self) -> Option<OptimisationEnd> {
        self.stops().filter(|_| self.pending.is_empty())
    }

    /// The stop rule that keeps `ask` from proposing more.
    fn stops(&self) -> Option<OptimisationEnd> {
        if self.next_id as usize >= self.last_id() {
            let proposed = (self.next_id - self.given) as usize;
            return Some(match self.definition.method {
                Method::Grid if proposed < self.definition.budget => {
                    OptimisationEnd::GridComplete { points: proposed }
                }
                _ => OptimisationEnd::Budget { evaluations: proposed },
            });
        }
        let stop = self.definition.improvement_stop?;
        (self.quiet >= stop.patience)
            .then_some(OptimisationEnd::NoExpectedImprovement { largest: self.promised })
    }

    /// The number of the first proposal there will never be.
    fn last_id(&self) -> usize {
        let proposals = match self.definition.method {
            Method::Grid => grid_size(&self.definition).min(self.definition.budget),
            _ => self.definition.budget,
        };
        proposals + self.given as usize
    }

    fn next_point(&mut self, id: u64) -> (Vec<f64>, ProposalOrigin) {
        if let Some(unit) = self.designed((id - self.given) as usize) {
            return (unit, ProposalOrigin::Design);
        }
        let chosen = match self.definition.method {
            _ if self.trials.is_empty() => None,
            Method::GpMinimizeLike { penalty } => {
                let pending: Vec<Vec<f64>> =
                    self.pending.iter().map(|pending| pending.unit.clone()).collect();
                self.hedge.propose(&self.definition, penalty, &self.trials, &pending, id).ok()
            }
            _ => self.model_choice(id),
        };
        match chosen {
            Some((unit, acquisition)) => (unit, ProposalOrigin::Model(acquisition)),
            None => {
                let mut generator = stream(self.definition.seed, id, Purpose::Candidates);
                (
                    design::uniform(&self.definition.space, 1, &mut generator).remove(0),
                    ProposalOrigin::Fallback,
                )
            }
        }
    }

    /// Point `id` of the design, counted from the first proposal, while there is one.
    fn designed(&self, id: usize) -> Option<Vec<f64>> {
        let Definition { space, budget, initial, initial_design, seed, .. } = &self.definition;
        let points = match (self.definition.method, initial_design) {
            (Method::Bayesian | Method::GpMinimizeLike { .. }, _) if id >= *initial => return None,
            (Method::Grid, _) => {
                let levels = design::grid_levels(space, *budget);
                return Some(design::grid_point(space, &levels, id));
            }
            (Method::Random, _) => design::random(space, id + 1, *seed),
            (Method::LatinHypercube, _) => design::latin_hypercube(space, *budget, *seed),
            (Method::Sobol, _) => design::sobol(space, id + 1, *seed),
            (_, InitialDesign::Random) => design::random(space, *initial, *seed),
            (_, InitialDesign::Stratified) if space.dimensions().len() == 1 => {
                design::latin_hypercube(space, *initial, *seed)
            }
            (_, InitialDesign::Stratified) => design::sobol(space, *initial, *seed),
        };
        points.into_iter().nth(id)
    }

    /// The point the surrogates think best, for the objective or a scalarisation of several; `None` when no model can be fitted.
    fn model_choice(&mut self, id: u64) -> Option<(Vec<f64>, Acquisition)> {
        let mut remembered = std::mem::take(&mut self.remembered);
        let models = self.fit(&mut remembered, Some(id));
        self.remembered = remembered;
        let mut models = models.ok()?;
        for pending in &self.pending {
            models = models.believe(&pending.unit).ok()?;
        }
        let acquisition = self.acquisition(id, &models);
        let (unit, log) = self.best_point(id, acquisition, &models)?;
        self.note_promise(acquisition, &models, log);
        Some((unit, acquisition))
    }

    /// Distinct places evaluated or pending.
    fn places(&self) -> Vec<Vec<f64>> {
        let mut places: Vec<Vec<f64>> = Vec::new();
        let all = self
            .trials
            .iter()
            .map(|trial| &trial.unit)
            .chain(self.pending.iter().map(|pending| &pending.unit));
        for unit in all {
            if !places.contains(unit) {
                places.push(unit.clone());
            }
        }
        places
    }

    /// Which acquisition's turn it is.
    ///
    /// Expected improvement never has two points pending: the second would have to improve on a value that the first was
    /// believed not to reach, and ends where little is known rather than where much is promised.
    fn acquisition(&self, id: u64, models: &Models) -> Acquisition {
        let feasible = self.trials.iter().any(EvaluatedPoint::is_feasible);
        let is_improving =
            |pending: &Pending| pending.origin == ProposalOrigin::Model(Acquisition::ExpectedImprovement);
        let proposed = (id - self.given) as usize;
        let is_turn = proposed.saturating_sub(self.definition.initial).is_multiple_of(2);
        if models.objective.is_none() || (!models.constraints.is_empty() && !feasible) {
            Acquisition::Feasibility
        } else if is_turn && !self.pending.iter().any(is_improving) {
            Acquisition::ExpectedImprovement
        } else {
            Acquisition::KnowledgeGradient
        }
    }

    /// The point that the acquisition likes best, and the logarithm of what it promises there.
    fn best_point(&self, id: u64, acquisition: Acquisition, models: &Models) -> Option<(Vec<f64>, f64)> {
        let Definition { space, seed, feasibility, .. } = &self.definition;
        let anchors = anchors(models, &self.places());
        let generator = || stream(*seed, id, Purpose::Candidates);
        if acquisition == Acquisition::Feasibility {
            return Some(maximise(space, &anchors, &mut generator(), |points| {
                models.log_feasibility(points)
            }));
        }
        let objective = models.objective.as_ref()?;
        let search = |score: &dyn Fn(&[Vec<f64>]) -> Vec<f64>| {
            maximise(space, &anchors, &mut generator(), |points| {
                let certifiability = models.log_certifiability(points, *feasibility);
                score(points).iter().zip(certifiability).map(|(score, log)| score + log).collect()
            })
        };
        if acquisition == Acquisition::ExpectedImprovement {
            let lowest = self.lowest_observed(objective.surrogate.data())?;
            return Some(search(&|points| {
                log_expected_improvement(&objective.surrogate.scan(points), lowest)
            }));
        }
        let gradient = KnowledgeGradient::new(objective, models, *feasibility)?;
        let within_reach = gradient.within_reach();
        let found = search(&|points| within_reach.log(points));
        Some(if KnowledgeGradient::is_exact(found.1) {
            found
        } else {
            search(&|points| gradient.log(points))
        })
    }

    /// The smallest value on the surrogate's scale observed where no constraint was seen violated; what is only believed of
    /// pending points does not count.
    fn lowest_observed(&self, data: &super::surrogate::Dataset) -> Option<f64> {
        let observed =
            |unit: &Vec<f64>| self.trials.iter().any(|trial| trial.unit == *unit && trial.is_feasible());
        let values = data.points.iter().zip(&data.values).filter(|(unit, _)| observed(unit));
        values.map(|(_, value)| *value).min_by(f64::total_cmp)
    }

    /// Keeps count of proposals in a row that promise less than the stop rule wants.
    fn note_promise(&mut self, acquisition: Acquisition, models: &Models, log: f64) {
        let (Some(stop), Some(objective)) = (self.definition.improvement_stop, &models.objective) else {
            return;
        };
        self.promised = (libm::exp(log) * objective.map.scale).min(f64::MAX);
        let is_small = acquisition != Acquisition::Feasibility && self.promised < stop.below;
        self.quiet = if is_small { self.quiet + 1 } else { 0 };
    }

    /// Fits the models; with several objectives the one of proposal `id`'s scalarisation.
    pub(super) fn fit(&self, remembered: &mut Remembered, id: Option<u64>) -> Result<Models, Error> {
        let definition = &self.definition;
        if definition.objectives.len() == 1 {
            let goal = definition.objectives[0];
            let value = |trial: &EvaluatedPoint| {
                let measurement = trial.evaluation.objectives[0];
                Some((goal.minimised(measurement.value?), measurement.noise_variance))
            };
            return Models::fit(definition, &self.trials, value, remembered);
        }
        let weights = pareto::weights(definition.objectives.len(), definition.seed, id.unwrap_or(0));
        let (ids, vectors): (Vec<u64>, Vec<Vec<f64>>) =
            self.trials.iter().filter_map(|trial| Some((trial.id, self.minimised(trial)?))).unzip();
        let scalars = pareto::scalarised(&vectors, &weights);
        let value = |trial: &EvaluatedPoint| Some((scalars[ids.binary_search(&trial.id).ok()?], None));
        Models::fit(definition, &self.trials, value, remembered)
    }

    /// A trial's objectives as numbers to minimise, when all are defined.
    pub(super) fn minimised(&self, trial: &EvaluatedPoint) -> Option<Vec<f64>> {
        let goals = self.definition.objectives.iter();
        goals.zip(&trial.evaluation.objectives).map(|(goal, m)| Some(goal.minimised(m.value?))).collect()
    }

    /// A copy of what is remembered between asks, for reports that fit models without changing the state.
    pub(super) fn remembered(&self) -> Remembered {
        self.remembered.clone()
    }
}

fn grid_size(definition: &Definition) -> usize {
    let levels = design::grid_levels(&definition.space, definition.budget);
    levels.iter().fold(1usize, |size, &level| size.saturating_mul(level))
}

/// The places with the lowest posterior mean among those likely to be feasible, or else the likeliest to be feasible.
fn anchors(models: &Models, places: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let feasibility = models.log_feasibility(places);
    let means: Vec<f64> = match &models.objective {
        Some(objective) => objective.surrogate.scan(places).iter().map(|p| p.mean).collect(),
        None => vec![0.0; places.len()],
    };
    let unlikely = |i: usize| (-feasibility[i] - std::f64::consts::LN_2).max(0.0);
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| unlikely(a).total_cmp(&unlikely(b)).then(means[a].total_cmp(&means[b])));
    order.into_iter().take(ANCHORS).map(|i| places[i].clone()).collect()
}
