//! The reference method: scikit-optimize 0.10's `gp_minimize` with `gp_hedge`, for comparison with the paper.
//!
//! Expected improvement, lower confidence bound and probability of improvement each propose a point; a softmax over their gains
//! picks one. ξ = 0.01 and the gains are in the objective's raw unit, as there; infeasible and undefined evaluations count as
//! one large constant. The kernel, its bounds and maximum likelihood without priors are the reference's; the starting points
//! of the fit and the search for the acquisition's maximum are ours.

use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::Error;
use super::acquisition::{Acquisition, log_expected_improvement, log_probability_of_improvement};
use super::definition::{Definition, Goal};
use super::history::{EvaluatedPoint, merged};
use super::maximise::maximise;
use super::models::categories;
use super::random::{Purpose, stream};
use super::surrogate::{
    Dataset, FriedrichSurrogate, HyperParameters, Noise, Outliers, Posterior, Standardisation, Surrogate,
};

const XI: f64 = 0.01;
const KAPPA: f64 = 1.96;
const ARMS: [Acquisition; 3] = [
    Acquisition::ExpectedImprovement,
    Acquisition::LowerConfidenceBound,
    Acquisition::ProbabilityOfImprovement,
];

/// The portfolio's state between proposals.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Hedge {
    gains: [f64; 3],
    /// What each arm proposed last.
    proposed: Vec<Vec<f64>>,
    hyper: Option<HyperParameters>,
}

impl Hedge {
    /// The next point after `trials`, with pending points believed to give what the model expects there.
    pub fn propose(
        &mut self,
        definition: &Definition,
        penalty: f64,
        trials: &[EvaluatedPoint],
        pending: &[Vec<f64>],
        proposal: u64,
    ) -> Result<(Vec<f64>, Acquisition), Error> {
        let (seed, space) = (definition.seed, &definition.space);
        let data = merged(trials.iter().map(|t| (t, penalised(definition, penalty, t), None)));
        let values: Vec<f64> = data.iter().map(|datum| datum.value).collect();
        let map = Standardisation::of(&values, Outliers::Keep);
        let dataset = Dataset {
            points: data.iter().map(|datum| datum.unit.clone()).collect(),
            values: values.iter().map(|&value| map.apply(value)).collect(),
            noise: data.iter().map(|datum| datum.noise).collect(),
            categorical: categories(definition),
        };
        let mut model = FriedrichSurrogate::fit_without_priors(dataset, self.hyper.as_ref())?;
        self.hyper = Some(model.hyper_parameters().clone());
        for point in pending {
            let mean = model.posterior(std::slice::from_ref(point))[0].mean;
            model = model.condition(point.clone(), mean, Noise { shared: 1.0, known: 0.0 })?;
        }
        let proposed = std::mem::take(&mut self.proposed);
        for (gain, posterior) in self.gains.iter_mut().zip(model.posterior(&proposed)) {
            *gain -= map.undo(posterior.mean);
        }

        let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
        let best = map.apply(lowest - XI);
        let anchor = data.iter().find(|datum| datum.value == lowest).map(|datum| datum.unit.clone());
        let anchors: Vec<Vec<f64>> = anchor.into_iter().collect();
        for (arm, acquisition) in ARMS.into_iter().enumerate() {
            let mut generator = stream(seed, proposal * ARMS.len() as u64 + arm as u64, Purpose::Candidates);
            let score = |points: &[Vec<f64>]| score(acquisition, &model.scan(points), best);
            self.proposed.push(maximise(space, &anchors, &mut generator, score).0);
        }
        let highest = self.gains.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weights = self.gains.map(|gain| libm::exp(gain - highest));
        let mut left = stream(seed, proposal, Purpose::Hedge).random::<f64>() * weights.iter().sum::<f64>();
        let chosen = weights.iter().position(|weight| {
            left -= weight;
            left < 0.0
        });
        let chosen = chosen.unwrap_or(ARMS.len() - 1);
        Ok((self.proposed[chosen].clone(), ARMS[chosen]))
    }
}

fn score(acquisition: Acquisition, posteriors: &[Posterior], best: f64) -> Vec<f64> {
    match acquisition {
        Acquisition::LowerConfidenceBound => {
            posteriors.iter().map(|p| KAPPA * p.deviation() - p.mean).collect()
        }
        Acquisition::ProbabilityOfImprovement => log_probability_of_improvement(posteriors, best),
        _ => log_expected_improvement(posteriors, best),
    }
}

/// What the reference is told: the objective to minimise, or the penalty.
pub(super) fn penalised(definition: &Definition, penalty: f64, trial: &EvaluatedPoint) -> f64 {
    let goal: Goal = definition.objectives[0];
    match trial.evaluation.objectives[0].value {
        Some(value) if trial.is_feasible() => goal.minimised(value),
        _ => goal.minimised(penalty),
    }
}
