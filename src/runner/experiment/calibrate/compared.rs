//! Populations that are put into the conditions of a calibration, to be shown beside people and candidates.

use super::super::error::ExperimentError;
use super::candidates::{WeighedCandidates, unsaid};
use super::record::HeldRecord;
use super::trial::CandidateTrial;
use super::weigh::Features;
use numbers::inference::effective_size;
use results::ComparedPopulation;
use scenario::MatchedParameter;

/// Runs of all individuals of equal weight together, in a condition: a share is known to about a point.
const RUNS_OF_ALL: f64 = 4000.0;
/// The passes before are those of the candidates.
const FIRST_PASS: u32 = 2;

/// A population to be compared with.
pub struct ComparedPeople {
    name: String,
    digest: String,
    people: WeighedCandidates,
    /// One per individual, of sum 1.
    weights: Vec<f64>,
    runs: u32,
}

impl ComparedPeople {
    /// Those of the block of a trial; whoever has no weight is left out.
    pub fn of(trial: &CandidateTrial) -> Result<Vec<Self>, ExperimentError> {
        let scenario = &trial.conditions[0].scenario;
        trial.block.compared.iter().map(|people| Self::read(people, scenario)).collect()
    }

    fn read(people: &scenario::Individuals, scenario: &scenario::Scenario) -> Result<Self, ExperimentError> {
        let (read, variant) = WeighedCandidates::population(people, scenario)?;
        let digest = read.digest();
        let equal = vec![1.0 / read.individuals.len() as f64; read.individuals.len()];
        let weights = if read.weights.is_empty() { equal } else { read.weights };
        let (rows, weights): (Vec<_>, Vec<_>) =
            read.individuals.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0).unzip();
        let runs = (RUNS_OF_ALL / effective_size(&weights)).ceil().clamp(2.0, 100.0) as u32;
        let name = super::candidates::file_name(&people.population);
        let people = WeighedCandidates {
            model: read.model,
            variant,
            names: read.parameters,
            rows,
            words: String::new(),
        };
        Ok(Self { name, digest, people, weights, runs })
    }

    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// What a statistic of a parameter is among them; `None` where nobody says it.
    fn statistic(&self, matched: &MatchedParameter, trial: &CandidateTrial) -> Option<f64> {
        let same = || {
            let value = unsaid(&trial.conditions[0].scenario, &matched.parameter)?;
            Some(vec![value; self.len()])
        };
        let values = self.people.values(&matched.parameter).or_else(same)?;
        let feature = |(value, weight): (&f64, &f64)| weight * matched.statistic.feature(*value);
        Some(matched.statistic.of_mean(values.iter().zip(&self.weights).map(feature).sum()))
    }
}

/// What each does in the conditions of the trial; `progress` is told how many of all are done.
pub fn compare(
    others: &[ComparedPeople],
    trial: &CandidateTrial,
    record: &mut HeldRecord,
    progress: impl Fn(usize),
) -> Result<Vec<ComparedPopulation>, ExperimentError> {
    let mut before = 0;
    let mut found = Vec::new();
    for (other, pass) in others.iter().zip(FIRST_PASS..) {
        let everybody: Vec<usize> = (0..other.len()).collect();
        let own = CandidateTrial {
            candidates: &other.people,
            called: &other.name,
            runs: other.runs,
            ..trial.clone()
        };
        let done = own.make(record, pass, &everybody, |count| progress(before + count))?;
        own.is_known(&done)?;
        let features = Features::counted(&done, &own.defined(&done), other.runs);
        before += other.len();
        found.push(ComparedPopulation {
            name: other.name.clone(),
            digest: other.digest.clone(),
            individuals: other.len(),
            runs: other.runs,
            shares: (0..trial.conditions.len())
                .map(|condition| {
                    (features.share(&other.weights, condition), features.spread(&other.weights, condition))
                })
                .collect(),
            parameters: trial.block.parameters.iter().map(|one| other.statistic(one, trial)).collect(),
        });
    }
    Ok(found)
}
