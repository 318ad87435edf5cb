//! The candidates of a tune: what the scenarios declare, those of the user, and then those of the method.

use super::under_way::TuneUnderWay;
use crate::experiment::error::ExperimentError;
use crate::experiment::overrides;
use optimise::{Evaluation, Optimiser, Point};
use results::{Candidate, CandidateOrigin};
use scenario::{Case, SearchRange, Target, Value};

/// A candidate that comes before those of the method.
pub struct FirstCandidate {
    origin: CandidateOrigin,
    /// `None` where what is set is not one value for all cases.
    point: Option<Point>,
    settings: Vec<(Target, Value)>,
    evaluation: Evaluation,
}

/// A candidate that was evaluated.
pub struct Evaluated {
    origin: CandidateOrigin,
    point: Point,
    /// What is set for it: nothing for the values that are declared.
    pub settings: Vec<(Target, Value)>,
    pub evaluation: Evaluation,
    /// Its number for the optimiser, if that knows of it.
    pub id: Option<u64>,
}

impl Evaluated {
    /// As results have it.
    pub fn candidate(&self) -> Candidate {
        Candidate {
            origin: self.origin,
            point: self.point.clone(),
            objectives: self.evaluation.objectives.iter().map(|one| one.value).collect(),
            margins: self.evaluation.margins.iter().map(|one| one.value).collect(),
            keeps_constraints: self.evaluation.keeps_constraints(),
            feasible: self.evaluation.is_feasible(),
        }
    }

    pub fn is_declared(&self) -> bool {
        self.origin == CandidateOrigin::Declared
    }
}

impl TuneUnderWay<'_> {
    /// Evaluates what the scenarios declare, and then the candidates of `try`.
    pub fn evaluate_first(&self) -> Result<Vec<FirstCandidate>, ExperimentError> {
        let declared = std::iter::once((CandidateOrigin::Declared, Vec::new()));
        let tried = self.tune.tries.iter().map(|settings| (CandidateOrigin::Tried, settings.clone()));
        let mut all = Vec::new();
        for (origin, settings) in declared.chain(tried) {
            let cases = self.runs_with(&settings, false)?;
            let outcomes = self
                .evaluating
                .run_all(all.len(), &cases)
                .map_err(|error| error.evaluating(|| self.tried_in_words(&settings)))?;
            let evaluation = self.evaluation_of(&outcomes, false);
            self.note(&evaluation);
            let point = self.point(&cases)?;
            if point.is_none() && origin == CandidateOrigin::Tried {
                return Err(ExperimentError::PartialTry(self.tried_in_words(&settings)));
            }
            all.push(FirstCandidate { origin, point, settings, evaluation });
        }
        Ok(all)
    }

    /// What a first candidate is, for an error.
    fn tried_in_words(&self, settings: &[(Target, Value)]) -> String {
        if settings.is_empty() {
            return "what the scenarios declare".to_string();
        }
        let each = settings.iter().map(|(target, value)| format!("{target} = {value}"));
        each.collect::<Vec<_>>().join(", ")
    }

    /// Where these cases are in the space; `None` where a parameter has no value, or not the same one in all of them.
    fn point(&self, cases: &[Case]) -> Result<Option<Point>, ExperimentError> {
        let coordinate = |range: &SearchRange| -> Result<_, ExperimentError> {
            let mut only = None;
            for case in cases {
                let scenario = self.context.scenario(&case.scenario)?;
                for value in overrides::resolved(&range.target, scenario, case) {
                    let Some((value, _)) = value else { return Ok(None) };
                    if only.get_or_insert_with(|| value.clone()) != &value {
                        return Ok(None);
                    }
                }
            }
            Ok(only.and_then(|value| overrides::coordinate(range, &value)))
        };
        self.tune.over.iter().map(coordinate).collect()
    }

    /// All that were evaluated: the first ones, and then the others in the order of asking. `told` says by which number the optimiser knows
    /// a first one.
    pub fn candidates(
        &self,
        first: Vec<FirstCandidate>,
        told: &[Option<u64>],
        optimiser: &Optimiser,
    ) -> Vec<Evaluated> {
        let given = told.iter().flatten().count() as u64;
        let first = first.into_iter().zip(told).map(|(one, id)| Evaluated {
            origin: one.origin,
            point: one.point.unwrap_or_default(),
            settings: one.settings,
            evaluation: one.evaluation,
            id: *id,
        });
        let others = optimiser.trials().iter().filter(|trial| trial.id >= given).map(|trial| Evaluated {
            origin: CandidateOrigin::Method,
            point: trial.point.clone(),
            settings: overrides::settings(&self.tune.over, &trial.point),
            evaluation: trial.evaluation.clone(),
            id: Some(trial.id),
        });
        first.chain(others).collect()
    }
}

impl FirstCandidate {
    /// The point at which a space of these ranges holds it; `None` outside of them.
    pub fn within(&self, space: &optimise::Space) -> Option<&Point> {
        self.point.as_ref().filter(|point| space.unit(point).is_ok())
    }

    pub fn evaluation(&self) -> &Evaluation {
        &self.evaluation
    }
}
