//! What to optimise and how: everything that, with the evaluations, determines every proposal.

use serde::{Deserialize, Serialize};

use super::Error;
use super::space::Space;

/// Which way an objective gets better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    /// Smaller values are better.
    Minimise,
    /// Larger values are better.
    Maximise,
}

impl Goal {
    /// A value as something to minimise, and back.
    pub fn minimised(self, value: f64) -> f64 {
        match self {
            Goal::Minimise => value,
            Goal::Maximise => -value,
        }
    }
}

/// How proposals are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Gaussian-process surrogates; a constraint has one of its own.
    Bayesian,
    /// scikit-optimize's `gp_minimize` as the paper used it: infeasible and undefined evaluations become one large value.
    GpMinimizeLike {
        /// That value, in the objective's unit, towards worse.
        penalty: f64,
    },
    /// Independent uniform points.
    Random,
    /// One Latin hypercube of the whole budget.
    LatinHypercube,
    /// A scrambled Sobol sequence.
    Sobol,
    /// A regular grid of as many points as the budget allows, at least two levels a dimension.
    Grid,
}

/// Where the evaluations before the first model are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InitialDesign {
    /// A Latin hypercube in one dimension, scrambled Sobol points from two.
    Stratified,
    /// Uniform random points ("random first"), as the paper has it.
    Random,
}

/// Stop when several proposals in a row promise almost nothing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ImprovementStop {
    /// Expected improvement below which a proposal promises nothing, in the objective's unit.
    pub below: f64,
    /// How many such proposals in a row end the run.
    pub patience: u32,
}

/// The definition of one optimisation run. Same definition and same evaluations: same proposals, to the bit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Definition {
    /// Where to search.
    pub space: Space,
    /// One goal per objective; with two or more the result is a Pareto front.
    pub objectives: Vec<Goal>,
    /// Number of constraint margins each evaluation brings; a point is feasible when every margin is ≥ 0.
    pub constraints: usize,
    /// How proposals are chosen.
    pub method: Method,
    /// Evaluations in all, initial ones included.
    pub budget: usize,
    /// Evaluations before the first model.
    pub initial: usize,
    /// Where those are.
    pub initial_design: InitialDesign,
    /// Seed of every random choice.
    pub seed: u64,
    /// Least probability of feasibility of the predicted best point: where the optimum lies on a constraint, about the share of
    /// runs whose answer keeps it.
    pub feasibility: f64,
    /// Stop early when nothing more is to be expected.
    pub improvement_stop: Option<ImprovementStop>,
}

impl Definition {
    /// Minimises one unconstrained objective with 60 evaluations, 15 of them initial (as the paper), feasibility 0.98.
    pub fn new(space: Space, seed: u64) -> Self {
        Definition {
            space,
            objectives: vec![Goal::Minimise],
            constraints: 0,
            method: Method::Bayesian,
            budget: 60,
            initial: 15,
            initial_design: InitialDesign::Stratified,
            seed,
            feasibility: 0.98,
            improvement_stop: None,
        }
    }

    /// # Errors
    /// [`Error::Definition`] naming the setting that makes no sense.
    pub(super) fn check(&self) -> Result<(), Error> {
        let refuse = |reason: String| Err(Error::Definition(reason));
        if self.objectives.is_empty() {
            return refuse("there is no objective".to_owned());
        }
        if self.budget == 0 {
            return refuse("the budget is 0 evaluations; give at least 1".to_owned());
        }
        if self.uses_model() && self.initial == 0 {
            return refuse("a model needs at least 1 initial evaluation".to_owned());
        }
        if !(self.feasibility > 0.0 && self.feasibility < 1.0) {
            return refuse(format!(
                "the feasibility to ask for lies between 0 and 1, not at {}",
                self.feasibility
            ));
        }
        if let Some(stop) = self.improvement_stop
            && !(stop.below > 0.0 && stop.below.is_finite() && stop.patience > 0)
        {
            return refuse(
                "stopping on small improvement needs a positive threshold and patience".to_owned(),
            );
        }
        if self.improvement_stop.is_some() && self.objectives.len() > 1 {
            return refuse(
                "stopping on small improvement needs one objective: of several there is no one improvement"
                    .to_owned(),
            );
        }
        if let Method::GpMinimizeLike { penalty } = self.method {
            if self.objectives.len() > 1 {
                return refuse(
                    "gp_minimize_like handles one objective only; use the Bayesian method".to_owned(),
                );
            }
            if !penalty.is_finite() {
                return refuse(format!("the penalty must be a finite number, not {penalty}"));
            }
        }
        Ok(())
    }

    /// The definition without its budget: it decides the same points, in the same order, for every budget. A design of the whole budget keeps
    /// its budget, and how many points come first stays, too.
    pub fn without_budget(&self) -> Self {
        let mut definition = self.clone();
        match self.method {
            Method::LatinHypercube | Method::Grid => {}
            Method::Random | Method::Sobol => (definition.budget, definition.initial) = (0, 0),
            Method::Bayesian | Method::GpMinimizeLike { .. } => definition.budget = 0,
        }
        definition
    }

    /// Does the method fit a surrogate?
    pub(super) fn uses_model(&self) -> bool {
        matches!(self.method, Method::Bayesian | Method::GpMinimizeLike { .. })
    }
}
