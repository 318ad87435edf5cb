//! The surrogates of one run: one for the objective, one for each constraint margin, and one for being defined at all.

use super::Error;
use super::definition::Definition;
use super::history::{Datum, Trial, merged};
use super::normal::log_cumulative;
use super::surrogate::{
    Dataset, FriedrichSurrogate, HyperParameters, Noise, Outliers, Posterior, Standardisation, Surrogate,
};
use serde::{Deserialize, Serialize};

/// The surrogate in use; the one place that names it.
pub(super) type Engine = FriedrichSurrogate;

/// Up to this many evaluations every model is fitted anew, from all starts, at every ask.
const FULL_FIT_LIMIT: usize = 100;

/// A surrogate and the scale of what it models.
pub(super) struct Scaled {
    pub surrogate: Engine,
    pub map: Standardisation,
    /// Zero, on the surrogate's scale: where a margin turns feasible.
    zero: f64,
}

/// Everything believed after some evaluations.
pub(super) struct Models {
    /// `None` as long as no objective value is defined.
    pub objective: Option<Scaled>,
    /// Constraint margins, then definedness when something was undefined.
    pub constraints: Vec<Scaled>,
}

/// Hyper-parameters from one ask to the next: the objective's, then each constraint's, then definedness's.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Remembered {
    pub hyper: Vec<Option<HyperParameters>>,
    /// Number of evaluations at the last fit.
    pub fitted_at: usize,
}

#[derive(Clone, Copy, PartialEq)]
enum Fitting {
    MultiStart,
    Refine,
    Reuse,
}

impl Remembered {
    /// What is due after `count` evaluations: all starts up to a hundred, then a refinement every twentieth part more.
    fn due(&self, count: usize) -> Fitting {
        if count <= FULL_FIT_LIMIT {
            Fitting::MultiStart
        } else if count >= self.fitted_at + (count / 20).max(1) {
            Fitting::Refine
        } else {
            Fitting::Reuse
        }
    }

    fn get(&self, slot: usize) -> Option<&HyperParameters> {
        self.hyper.get(slot)?.as_ref()
    }

    fn set(&mut self, slot: usize, hyper: HyperParameters) {
        if self.hyper.len() <= slot {
            self.hyper.resize(slot + 1, None);
        }
        self.hyper[slot] = Some(hyper);
    }
}

impl Scaled {
    fn fit(
        data: &[Datum],
        categorical: &[bool],
        outliers: Outliers,
        previous: Option<&HyperParameters>,
        fitting: Fitting,
    ) -> Result<Self, Error> {
        let values: Vec<f64> = data.iter().map(|datum| datum.value).collect();
        let map = Standardisation::of(&values, outliers);
        let dataset = dataset(data, categorical, map);
        let surrogate = match (fitting, previous) {
            (Fitting::Reuse, Some(hyper)) => Engine::with_hyper_parameters(dataset, hyper.clone())?,
            _ => Engine::fit(dataset, previous, fitting != Fitting::MultiStart)?,
        };
        Ok(Scaled { surrogate, map, zero: map.apply(0.0) })
    }

    /// Adds what is believed at a place as if it had been seen there.
    fn believe(self, unit: &[f64]) -> Result<Self, Error> {
        let mean = self.surrogate.posterior(&[unit.to_vec()])[0].mean;
        let surrogate = self.surrogate.condition(unit.to_vec(), mean, Noise { shared: 1.0, known: 0.0 })?;
        Ok(Scaled { surrogate, ..self })
    }

    /// ln Pr(margin ≥ 0) for beliefs of this model.
    fn log_feasibility(&self, posterior: Posterior) -> f64 {
        log_cumulative((posterior.mean - self.zero) / posterior.deviation().max(1e-9))
    }
}

fn dataset(data: &[Datum], categorical: &[bool], map: Standardisation) -> Dataset {
    let square = map.scale * map.scale;
    let noise =
        |datum: &Datum| Noise { shared: datum.noise.shared, known: (datum.noise.known / square).min(1e6) };
    Dataset {
        points: data.iter().map(|datum| datum.unit.clone()).collect(),
        values: data.iter().map(|datum| map.apply(datum.value)).collect(),
        noise: data.iter().map(noise).collect(),
        categorical: categorical.to_vec(),
    }
}

impl Models {
    /// Fits all models. `objective` gives a trial's value to minimise and, if known, its noise variance.
    ///
    /// # Errors
    /// [`Error::Surrogate`] when a model cannot be fitted.
    pub fn fit(
        definition: &Definition,
        trials: &[Trial],
        objective: impl Fn(&Trial) -> Option<(f64, Option<f64>)>,
        remembered: &mut Remembered,
    ) -> Result<Self, Error> {
        let fitting = remembered.due(trials.len());
        let categorical = categories(definition);
        let defined =
            merged(trials.iter().filter_map(|t| objective(t).map(|(value, variance)| (t, value, variance))));
        let mut fit = |slot: usize, data: &[Datum], outliers: Outliers| {
            let scaled = Scaled::fit(data, &categorical, outliers, remembered.get(slot), fitting)?;
            remembered.set(slot, scaled.surrogate.hyper_parameters().clone());
            Ok::<_, Error>(scaled)
        };
        let objective = match defined.as_slice() {
            [] => None,
            data => Some(fit(0, data, Outliers::CompressHigh)?),
        };
        let mut constraints = Vec::new();
        for c in 0..definition.constraints {
            let (seen, censored) = margins(trials, c);
            if seen.is_empty() && censored.is_empty() {
                continue;
            }
            let recorded: Vec<Datum> = seen.iter().chain(&censored).cloned().collect();
            let model = fit(1 + c, &recorded, Outliers::CompressBoth)?;
            constraints.push(impute(model, &seen, &censored, &categorical)?);
        }
        if trials.iter().any(Trial::is_undefined) {
            let definedness =
                merged(trials.iter().map(|t| (t, if t.is_undefined() { -1.0 } else { 1.0 }, None)));
            constraints.push(fit(1 + definition.constraints, &definedness, Outliers::Keep)?);
        }
        if fitting != Fitting::Reuse {
            remembered.fitted_at = trials.len();
        }
        Ok(Models { objective, constraints })
    }

    /// All models after believing their own means at a pending place.
    pub fn believe(self, unit: &[f64]) -> Result<Self, Error> {
        let objective = self.objective.map(|model| model.believe(unit)).transpose()?;
        let constraints =
            self.constraints.into_iter().map(|model| model.believe(unit)).collect::<Result<_, _>>()?;
        Ok(Models { objective, constraints })
    }

    /// ln Pr(feasible) at each point: the sum over constraints.
    pub fn log_feasibility(&self, points: &[Vec<f64>]) -> Vec<f64> {
        let mut total = vec![0.0; points.len()];
        for model in &self.constraints {
            let posteriors = model.surrogate.posterior(points);
            total
                .iter_mut()
                .zip(posteriors)
                .for_each(|(sum, posterior)| *sum += model.log_feasibility(posterior));
        }
        total
    }
}

/// Which dimensions of the space hold choices without order.
pub(super) fn categories(definition: &Definition) -> Vec<bool> {
    definition.space.dimensions().iter().map(|dimension| dimension.is_categorical()).collect()
}

/// A constraint's margins: those fully seen, and upper limits at places where it was only seen in part.
fn margins(trials: &[Trial], constraint: usize) -> (Vec<Datum>, Vec<Datum>) {
    let of = |censored: bool| {
        move |trial: &'_ Trial| {
            let margin = trial.evaluation.margins[constraint];
            margin.value.filter(|_| margin.censored == censored)
        }
    };
    let seen = merged(trials.iter().filter_map(|t| of(false)(t).map(|value| (t, value, None))));
    let mut limits: Vec<Datum> = Vec::new();
    for (trial, limit) in trials.iter().filter_map(|t| of(true)(t).map(|limit| (t, limit))) {
        if seen.iter().any(|datum| datum.unit == trial.unit) {
            continue;
        }
        match limits.iter_mut().find(|datum| datum.unit == trial.unit) {
            Some(datum) => datum.value = datum.value.min(limit),
            None => limits.extend(merged(std::iter::once((trial, limit, None)))),
        }
    }
    (seen, limits)
}

/// Replaces upper limits by what is to be expected below them: mean and variance of the belief from the margins fully seen,
/// truncated at the limit. A limit far above that belief then says nothing, one far below it moves the model.
fn impute(model: Scaled, seen: &[Datum], censored: &[Datum], categorical: &[bool]) -> Result<Scaled, Error> {
    if censored.is_empty() || seen.is_empty() {
        return Ok(model);
    }
    let hyper = model.surrogate.hyper_parameters().clone();
    let mut data = dataset(seen, categorical, model.map);
    let believed = Engine::with_hyper_parameters(data.clone(), hyper.clone())?;
    let places: Vec<Vec<f64>> = censored.iter().map(|datum| datum.unit.clone()).collect();
    for (datum, posterior) in censored.iter().zip(believed.posterior(&places)) {
        let limit = model.map.apply(datum.value);
        let deviation = posterior.deviation().max(1e-6);
        let beta = (limit - posterior.mean) / deviation;
        // φ(β)/Φ(β) through logarithms: β may be far out on either side.
        let hazard = libm::exp(-0.5 * beta * beta - 0.918_938_533_204_672_8 - log_cumulative(beta));
        let mean = (posterior.mean - deviation * hazard).min(limit);
        let variance = deviation * deviation * (1.0 - beta * hazard - hazard * hazard).clamp(0.0, 1.0);
        data.points.push(datum.unit.clone());
        data.values.push(mean);
        data.noise.push(Noise { shared: datum.noise.shared, known: variance });
    }
    Ok(Scaled { surrogate: Engine::with_hyper_parameters(data, hyper)?, ..model })
}

#[cfg(test)]
mod tests {
    use super::super::history::{Evaluation, Margin};
    use super::super::space::{Dimension, Space};
    use super::*;

    fn trial(x: f64, margin: Margin) -> Trial {
        let evaluation = Evaluation { margins: vec![margin], ..Evaluation::of(x) };
        Trial { id: 0, unit: vec![x], point: vec![], evaluation }
    }

    fn feasibility_at(trials: &[Trial], x: f64) -> f64 {
        let space = Space::new(vec![Dimension::real("x", 0.0, 1.0)]).unwrap();
        let definition = Definition { constraints: 1, ..Definition::new(space, 0) };
        let objective = |t: &Trial| t.evaluation.objectives[0].value.map(|value| (value, None));
        let models = Models::fit(&definition, trials, objective, &mut Remembered::default()).unwrap();
        models.log_feasibility(&[vec![x]])[0].exp()
    }

    #[test]
    fn a_censored_margin_is_an_upper_limit() {
        // The true margin is 2 − 4 x. Abandoned candidates at x > 0.5 recorded far too good (but negative) values.
        let margin = |value, censored| Margin { value: Some(value), censored };
        let mut trials: Vec<Trial> =
            (0..10).map(|i| 0.06 * f64::from(i)).map(|x| trial(x, margin(2.0 - 4.0 * x, false))).collect();
        let without = feasibility_at(&trials, 0.7);
        trials.extend([0.62, 0.7, 0.83].map(|x| trial(x, margin(-0.05, true))));
        let censored = feasibility_at(&trials, 0.75);
        assert!(without < 0.5 && censored < 0.05, "{without} {censored}");
        // Taken at face value, the recorded −0.05 would look like being at the boundary.
        for trial in &mut trials {
            trial.evaluation.margins[0].censored = false;
        }
        assert!(feasibility_at(&trials, 0.75) > censored);
    }

    #[test]
    fn undefined_evaluations_count_as_infeasible_around_them() {
        let feasible = Margin { value: Some(1.0), censored: false };
        let mut trials: Vec<Trial> = (0..20).map(|i| trial(f64::from(i) / 19.0, feasible)).collect();
        for trial in trials.iter_mut().filter(|trial| trial.unit[0] > 0.6) {
            trial.evaluation.objectives[0].value = None;
        }
        assert!(feasibility_at(&trials, 0.9) < 0.1);
        assert!(feasibility_at(&trials, 0.2) > 0.9);
    }
}
