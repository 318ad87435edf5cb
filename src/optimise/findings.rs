//! What a run found: the best point as observed and as predicted, the Pareto front, and slices through the surrogate for reports.

use serde::{Deserialize, Serialize};

use super::Error;
use super::models::{Models, Scaled};
use super::optimiser::Optimiser;
use super::pareto;
use super::space::{Coordinate, Point};
use super::surrogate::{Posterior, Surrogate};
use super::{Definition, EvaluatedPoint};

/// Half-width of a 95 % band, in standard deviations.
const BAND: f64 = 1.959_963_984_540_054;

/// The surrogate's belief about an evaluated point, in the objective's own unit and direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Prediction {
    /// The first trial there.
    pub id: u64,
    /// Where.
    pub point: Point,
    /// Posterior mean of the noise-free objective.
    pub mean: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// Probability that every constraint holds; 1 without constraints.
    pub feasibility: f64,
}

/// The surrogate at one place of a slice, in the objective's own unit and direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SlicePoint {
    /// Value of the dimension that varies.
    pub value: Coordinate,
    /// Posterior mean of the noise-free objective.
    pub mean: f64,
    /// Lower end of its 95 % band.
    pub lower: f64,
    /// Upper end of its 95 % band.
    pub upper: f64,
    /// Probability that every constraint holds; 1 without constraints.
    pub feasibility: f64,
}

impl Optimiser {
    /// The feasible trial with the best observed objective: the paper's answer. Biased by the luck of the draw on noisy problems.
    ///
    /// `None` when nothing feasible was seen, or with several objectives (see [`Optimiser::pareto_front`]).
    pub fn best_observed(&self) -> Option<&EvaluatedPoint> {
        let single = self.definition().objectives.len() == 1;
        let feasible = self.trials().iter().filter(|trial| single && trial.is_feasible());
        let ranked = feasible.filter_map(|trial| Some((trial, self.minimised(trial)?[0])));
        ranked.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(trial, _)| trial)
    }

    /// What is believed after all evaluations: for several questions at once, where each of the functions below fits models of its own.
    ///
    /// # Errors
    /// [`Error::Surrogate`] when no model can be fitted.
    pub fn fitted(&self) -> Result<Fitted<'_>, Error> {
        Ok(Fitted { optimiser: self, models: self.models()? })
    }

    /// The evaluated point with the best posterior mean among those whose probability of feasibility reaches the definition's.
    ///
    /// `None` when no point reaches it (see [`Optimiser::most_feasible`]), when nothing is defined, or with several objectives.
    ///
    /// # Errors
    /// [`Error::Surrogate`] when no model can be fitted.
    pub fn best_predicted(&self) -> Result<Option<Prediction>, Error> {
        Ok(self.fitted()?.best_predicted())
    }

    /// The evaluated point with the highest probability of feasibility.
    ///
    /// # Errors
    /// [`Error::Surrogate`] when no model can be fitted.
    pub fn most_feasible(&self) -> Result<Option<Prediction>, Error> {
        Ok(self.predictions()?.into_iter().max_by(|a, b| a.feasibility.total_cmp(&b.feasibility)))
    }

    /// The belief about every distinct evaluated point; empty when no objective value is defined or with several objectives.
    ///
    /// # Errors
    /// [`Error::Surrogate`] when no model can be fitted.
    pub fn predictions(&self) -> Result<Vec<Prediction>, Error> {
        Ok(self.fitted()?.predictions())
    }

    /// The surrogate along one dimension: see [`Fitted::surrogate_slice`].
    ///
    /// # Errors
    /// [`Error::Surrogate`] when no model can be fitted, and those of [`Fitted::surrogate_slice`].
    pub fn surrogate_slice(
        &self,
        dimension: usize,
        through: &[Coordinate],
        steps: usize,
    ) -> Result<Vec<SlicePoint>, Error> {
        self.fitted()?.surrogate_slice(dimension, through, steps)
    }

    /// The feasible trials that no other feasible one beats in every objective, by observed values, in order of id.
    pub fn pareto_front(&self) -> Vec<&EvaluatedPoint> {
        let feasible = self.trials().iter().filter(|trial| trial.is_feasible());
        let (trials, vectors): (Vec<&EvaluatedPoint>, Vec<Vec<f64>>) =
            feasible.filter_map(|trial| Some((trial, self.minimised(trial)?))).unzip();
        pareto::non_dominated(&vectors).into_iter().map(|i| trials[i]).collect()
    }

    fn sign(&self) -> f64 {
        self.definition().objectives[0].minimised(1.0)
    }

    /// Models of a single objective from all trials.
    fn models(&self) -> Result<Option<Models>, Error> {
        if self.trials().is_empty() || self.definition().objectives.len() > 1 {
            return Ok(None);
        }
        let models = self.fit(&mut self.remembered().due_again(), None)?;
        Ok(models.objective.is_some().then_some(models))
    }
}

/// What is believed after all evaluations of an optimiser.
pub struct Fitted<'a> {
    optimiser: &'a Optimiser,
    /// `None` when no objective value is defined or with several objectives.
    models: Option<Models>,
}

impl Fitted<'_> {
    /// See [`Optimiser::best_predicted`].
    pub fn best_predicted(&self) -> Option<Prediction> {
        let (sign, least) = (self.optimiser.sign(), self.optimiser.definition().feasibility);
        let likely = self.predictions().into_iter().filter(|p| p.feasibility >= least);
        likely.min_by(|a, b| (sign * a.mean).total_cmp(&(sign * b.mean)))
    }

    /// See [`Optimiser::predictions`].
    pub fn predictions(&self) -> Vec<Prediction> {
        let mut distinct: Vec<&EvaluatedPoint> = Vec::new();
        for trial in self.optimiser.trials() {
            if !distinct.iter().any(|other| other.unit == trial.unit) {
                distinct.push(trial);
            }
        }
        let places: Vec<Vec<f64>> = distinct.iter().map(|trial| trial.unit.clone()).collect();
        let prediction = |(belief, trial): (Belief, &EvaluatedPoint)| Prediction {
            id: trial.id,
            point: trial.point.clone(),
            mean: belief.mean,
            deviation: 0.5 * (belief.at_plus_one - belief.at_minus_one).abs(),
            feasibility: belief.feasibility,
        };
        self.beliefs(&places).into_iter().zip(distinct).map(prediction).collect()
    }

    /// The surrogate along one dimension, the others held as in `through` (which may be any point in one dimension).
    ///
    /// At most `steps` places, both ends included; every value of a discrete dimension with fewer. Empty as for
    /// [`Optimiser::predictions`].
    ///
    /// # Errors
    /// [`Error::Dimensions`] for a dimension that does not exist, and the errors of a point outside the space.
    pub fn surrogate_slice(
        &self,
        dimension: usize,
        through: &[Coordinate],
        steps: usize,
    ) -> Result<Vec<SlicePoint>, Error> {
        let Definition { space, .. } = self.optimiser.definition();
        let unit = space.unit(through)?;
        let count = space.dimensions().len();
        let Some(axis) = space.dimensions().get(dimension) else {
            return Err(Error::Dimensions(format!(
                "there is no dimension {dimension}; the space has {count}"
            )));
        };
        let last = steps.max(2) - 1;
        let mut places: Vec<Vec<f64>> = (0..=last)
            .map(|step| {
                let mut place = unit.clone();
                place[dimension] = axis.snap(step as f64 / last as f64);
                place
            })
            .collect();
        places.dedup();
        let point = |(belief, place): (Belief, &Vec<f64>)| SlicePoint {
            value: axis.value(place[dimension]),
            mean: belief.mean,
            lower: belief.at_lower.min(belief.at_upper),
            upper: belief.at_lower.max(belief.at_upper),
            feasibility: belief.feasibility,
        };
        Ok(self.beliefs(&places).into_iter().zip(&places).map(point).collect())
    }

    fn beliefs(&self, places: &[Vec<f64>]) -> Vec<Belief> {
        let Some(models) = &self.models else { return Vec::new() };
        let Some(objective) = &models.objective else { return Vec::new() };
        let (posteriors, sign) = (objective.surrogate.posterior(places), self.optimiser.sign());
        let both = posteriors.into_iter().zip(models.log_feasibility(places));
        both.map(|(posterior, log)| Belief::of(objective, posterior, sign, libm::exp(log))).collect()
    }
}

/// A posterior in the objective's own unit and direction.
struct Belief {
    mean: f64,
    at_minus_one: f64,
    at_plus_one: f64,
    at_lower: f64,
    at_upper: f64,
    feasibility: f64,
}

impl Belief {
    fn of(objective: &Scaled, posterior: Posterior, sign: f64, feasibility: f64) -> Self {
        let at =
            |deviations: f64| sign * objective.map.undo(posterior.mean + deviations * posterior.deviation());
        Belief {
            mean: at(0.0),
            at_minus_one: at(-1.0),
            at_plus_one: at(1.0),
            at_lower: at(-BAND),
            at_upper: at(BAND),
            feasibility,
        }
    }
}
