//! The surrogates of one run: one for the objective, one for each constraint margin, and one for being defined at all.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::Error;
use super::acquisition::SMALLEST_DEVIATION;
use super::definition::Definition;
use super::history::{Datum, EvaluatedPoint, merged};
use super::surrogate::{
    Dataset, FriedrichSurrogate, HyperParameters, Noise, Outliers, Posterior, Standardisation, Surrogate,
};
use numbers::distributions::{normal, normal_tail::log_cumulative};

/// The surrogate in use; the one place that names it.
pub(super) type Engine = FriedrichSurrogate;

/// Up to this many evaluations every model is fitted whenever one is told.
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

/// How hyper-parameters are found.
#[derive(Debug, Clone, PartialEq)]
enum Fitting {
    /// From the previous ones and from starts whose turn it is.
    Starts(Range<usize>),
    /// They are the previous ones.
    Reuse,
}

impl Remembered {
    /// What is due after `count` evaluations. Up to a hundred: a fit from the previous optimum and, for each evaluation that has come on
    /// top, from the start whose turn it is. From there on: from the previous optimum, whenever a twentieth has come on top. The same
    /// models again where nothing was told since.
    fn due(&self, count: usize) -> Fitting {
        if count == self.fitted_at {
            Fitting::Reuse
        } else if count <= FULL_FIT_LIMIT {
            Fitting::Starts(self.fitted_at..count)
        } else if count >= self.fitted_at + (count / 20).max(1) {
            Fitting::Starts(0..0)
        } else {
            Fitting::Reuse
        }
    }

    /// The same optima to start from, but the next fit is as thorough as fits of so much data ever are.
    pub fn due_again(self) -> Self {
        Remembered { fitted_at: 0, ..self }
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
        fitting: &Fitting,
    ) -> Result<Self, Error> {
        let values: Vec<f64> = data.iter().map(|datum| datum.value).collect();
        let map = Standardisation::of(&values, outliers);
        let dataset = dataset(data, categorical, map);
        let surrogate = match (fitting, previous) {
            (Fitting::Reuse, Some(hyper)) => Engine::with_hyper_parameters(dataset, hyper.clone())?,
            (Fitting::Reuse, None) => Engine::fit(dataset, None, 0..0)?,
            (Fitting::Starts(turns), previous) => Engine::fit(dataset, previous, turns.clone())?,
        };
        Ok(Scaled { surrogate, map, zero: map.apply(0.0) })
    }

    /// Adds what is believed at a place as if it had been seen there.
    fn believe(self, unit: &[f64]) -> Result<Self, Error> {
        let mean = self.surrogate.scan(&[unit.to_vec()])[0].mean;
        let surrogate = self.surrogate.condition(unit.to_vec(), mean, Noise { shared: 1.0, known: 0.0 })?;
        Ok(Scaled { surrogate, ..self })
    }

    /// ln Pr(margin ≥ 0) for beliefs of this model.
    fn log_feasibility(&self, posterior: Posterior) -> f64 {
        log_cumulative((posterior.mean - self.zero) / posterior.deviation().max(SMALLEST_DEVIATION))
    }

    /// ln Pr(one more evaluation leaves a mean at least `deviations` standard deviations above the margin's zero), where that
    /// evaluation has noise variance `noise`. Without noise that is the probability of feasibility.
    fn log_certifiability(&self, posterior: Posterior, noise: f64, deviations: f64) -> f64 {
        let variance = posterior.variance.max(SMALLEST_DEVIATION * SMALLEST_DEVIATION);
        // One evaluation leaves s²σ²/(s² + σ²) of the variance s²; by the rest the mean moves.
        let left = variance * noise / (variance + noise);
        let moves = variance * variance / (variance + noise);
        log_cumulative((posterior.mean - self.zero - deviations * left.sqrt()) / moves.sqrt())
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
        trials: &[EvaluatedPoint],
        objective: impl Fn(&EvaluatedPoint) -> Option<(f64, Option<f64>)>,
        remembered: &mut Remembered,
    ) -> Result<Self, Error> {
        let fitting = match remembered.due(trials.len()) {
            // Each proposal combines several objectives otherwise.
            Fitting::Reuse if definition.objectives.len() > 1 && trials.len() <= FULL_FIT_LIMIT => {
                Fitting::Starts(0..0)
            }
            fitting => fitting,
        };
        let categorical = categories(definition);
        let defined =
            merged(trials.iter().filter_map(|t| objective(t).map(|(value, variance)| (t, value, variance))));
        let mut fit = |slot: usize, data: &[Datum], outliers: Outliers| {
            let scaled = Scaled::fit(data, &categorical, outliers, remembered.get(slot), &fitting)?;
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
        if trials.iter().any(EvaluatedPoint::is_undefined) {
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
            let posteriors = model.surrogate.scan(points);
            total
                .iter_mut()
                .zip(posteriors)
                .for_each(|(sum, posterior)| *sum += model.log_feasibility(posterior));
        }
        total
    }

    /// ln Pr(one more evaluation makes the place feasible with probability `feasibility`) at each point: what a place is worth
    /// that can only be the answer when it is safe to say that it is feasible.
    pub fn log_certifiability(&self, points: &[Vec<f64>], feasibility: f64) -> Vec<f64> {
        let mut total = vec![0.0; points.len()];
        // Each constraint's share, so that all of them together reach the probability.
        let share = libm::pow(feasibility, 1.0 / self.constraints.len().max(1) as f64);
        let deviations = normal::quantile(share);
        for model in &self.constraints {
            let noise = model.surrogate.data().noise_of_another(model.surrogate.hyper_parameters().noise);
            let posteriors = model.surrogate.scan(points);
            total.iter_mut().zip(posteriors).for_each(|(sum, posterior)| {
                *sum += model.log_certifiability(posterior, noise, deviations);
            });
        }
        total
    }
}

/// Which dimensions of the space hold choices without order.
pub(super) fn categories(definition: &Definition) -> Vec<bool> {
    definition.space.dimensions().iter().map(|dimension| dimension.is_categorical()).collect()
}

/// A constraint's margins: those fully seen, and upper limits at places where it was only seen in part.
fn margins(trials: &[EvaluatedPoint], constraint: usize) -> (Vec<Datum>, Vec<Datum>) {
    let of = |censored: bool| {
        move |trial: &'_ EvaluatedPoint| {
            let margin = trial.evaluation.margins[constraint];
            margin.value.filter(|_| margin.censored == censored)
        }
    };
    let largest = trials.iter().filter_map(of(false)).fold(f64::NEG_INFINITY, f64::max);
    // By how much it is kept where nothing says so: as much as anywhere, for want of more.
    let kept = if largest > 0.0 { largest } else { 1.0 };
    let value = |trial: &EvaluatedPoint| {
        if trial.evaluation.margins[constraint].kept { Some(kept) } else { of(false)(trial) }
    };
    let seen = merged(trials.iter().filter_map(|t| value(t).map(|value| (t, value, None))));
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
    use proptest::prelude::*;

    use super::super::history::{Evaluation, Margin};
    use super::super::space::{SearchDimension, Space};
    use super::*;

    fn trial(x: f64, margin: Margin) -> EvaluatedPoint {
        let evaluation = Evaluation { margins: vec![margin], ..Evaluation::of(x) };
        EvaluatedPoint { id: 0, unit: vec![x], point: vec![], evaluation }
    }

    fn feasibility_at(trials: &[EvaluatedPoint], x: f64) -> f64 {
        let space = Space::new(vec![SearchDimension::real("x", 0.0, 1.0)]).unwrap();
        let definition = Definition { constraints: 1, ..Definition::new(space, 0) };
        let objective = |t: &EvaluatedPoint| t.evaluation.objectives[0].value.map(|value| (value, None));
        let models = Models::fit(&definition, trials, objective, &mut Remembered::default()).unwrap();
        models.log_feasibility(&[vec![x]])[0].exp()
    }

    #[test]
    fn a_censored_margin_is_an_upper_limit() {
        // The true margin is 2 − 4 x. Abandoned candidates at x > 0.5 recorded far too good (but negative) values.
        let margin = |value, censored| Margin { censored, ..Margin::of(Some(value)) };
        let mut trials: Vec<EvaluatedPoint> =
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

    fn margin_model() -> Scaled {
        let data = Dataset {
            points: vec![vec![0.2], vec![0.8]],
            values: vec![-1.0, 1.0],
            noise: vec![Noise { shared: 1.0, known: 0.0 }; 2],
            categorical: vec![false],
        };
        let hyper = HyperParameters { length_scales: vec![0.3], amplitude: 1.0, noise: 0.1 };
        let surrogate = Engine::with_hyper_parameters(data, hyper).unwrap();
        Scaled { surrogate, map: Standardisation::of(&[-1.0, 1.0], Outliers::Keep), zero: 0.0 }
    }

    proptest! {
        #[test]
        fn certifiability_is_the_chance_of_a_certain_margin_after_one_evaluation(
            mean in -1.0..1.0f64,
            deviation in 0.05..1.0f64,
            noise in 0.01..1.0f64,
            asked in 0.5..2.5f64,
        ) {
            let (variance, noise) = (deviation * deviation, noise * noise);
            let got = libm::exp(margin_model().log_certifiability(Posterior { mean, variance }, noise, asked));
            // Bayes' rule for every value that may be seen, by the midpoint rule.
            let spread = (variance + noise).sqrt();
            let left = (variance * noise / (variance + noise)).sqrt();
            let steps = 20_000;
            let expected: f64 = (0..steps)
                .map(|step| -9.0 + 18.0 * (f64::from(step) + 0.5) / f64::from(steps))
                .filter(|z| mean + variance / (variance + noise) * z * spread >= asked * left)
                .map(|z| normal::density(z) * 18.0 / f64::from(steps))
                .sum();
            prop_assert!((got - expected).abs() < 1e-3, "{} {}", got, expected);
        }
    }

    #[test]
    fn without_noise_certifiability_is_feasibility_and_with_it_an_edge_is_no_place_to_be() {
        let model = margin_model();
        let inside = Posterior { mean: 0.1, variance: 0.04 };
        assert_eq!(model.log_certifiability(inside, 0.0, 2.0), model.log_feasibility(inside));
        let edge = Posterior { mean: 0.0, variance: 1e-6 };
        assert!(model.log_certifiability(edge, 0.1, 2.0) < model.log_feasibility(edge) - 10.0);
        let never_seen = Posterior { mean: 0.0, variance: 0.0 };
        assert!(model.log_certifiability(never_seen, 0.0, 2.0).is_finite());
    }

    #[test]
    fn each_evaluation_gives_one_start_its_turn_up_to_a_hundred() {
        let mut remembered = Remembered::default();
        assert_eq!(remembered.due(15), Fitting::Starts(0..15));
        remembered.fitted_at = 15;
        assert_eq!(remembered.due(15), Fitting::Reuse);
        assert_eq!(remembered.due(16), Fitting::Starts(15..16));
        assert_eq!(remembered.due(24), Fitting::Starts(15..24));
        assert_eq!(remembered.clone().due_again().due(60), Fitting::Starts(0..60));
        remembered.fitted_at = 100;
        let mut fits = Vec::new();
        for count in 101..=130 {
            if remembered.due(count) == Fitting::Starts(0..0) {
                remembered.fitted_at = count;
                fits.push(count);
            }
        }
        assert_eq!(fits, [105, 110, 115, 121, 127]);
        assert_eq!(remembered.due_again().due(130), Fitting::Starts(0..0));
    }

    #[test]
    fn undefined_evaluations_count_as_infeasible_around_them() {
        let feasible = Margin::of(Some(1.0));
        let mut trials: Vec<EvaluatedPoint> = (0..20).map(|i| trial(f64::from(i) / 19.0, feasible)).collect();
        for trial in trials.iter_mut().filter(|trial| trial.unit[0] > 0.6) {
            trial.evaluation.objectives[0].value = None;
        }
        assert!(feasibility_at(&trials, 0.9) < 0.1);
        assert!(feasibility_at(&trials, 0.2) > 0.9);
    }
}
