//! Retention: every candidate through every meeting, and who meets all the criteria.

use rayon::prelude::*;
use serde_json::json;
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::candidates::{CandidateError, Candidates};
use super::criteria::{RetentionCriterion, RetentionVerdict, Showing};
use super::journal::{CalibrationJournal, JournalError};
use crate::pedestrian::commotions::model::commotions;
use crate::pedestrian::commotions::{Parameters, Variant};
use files::hexadecimal;
use numbers::random::derive_seed;
use scenario::population::Population;

/// What candidates are put through.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The variant calibrated.
    pub variant: Variant,
    /// What has to be met.
    pub criteria: Vec<RetentionCriterion>,
    /// Runs of each meeting.
    pub repetitions: u32,
    /// Decides the noise: a candidate's result depends on this and its number, not on order or threads.
    pub seed: u64,
}

impl Calibration {
    /// Puts one candidate through the criteria, in order, until one fails.
    pub fn judge(&self, number: usize, candidate: &Parameters) -> RetentionVerdict {
        let mut runs: Vec<(usize, Vec<Showing>)> = Vec::new();
        for (index, criterion) in self.criteria.iter().enumerate() {
            let known = runs.iter().position(|(first, _)| self.criteria[*first].shares_runs_with(criterion));
            let known = known.unwrap_or_else(|| {
                runs.push((index, self.run(number, index, candidate)));
                runs.len() - 1
            });
            let showings = &runs[known].1;
            let met = showings
                .iter()
                .filter(|showing| showing.meets(criterion.demand, candidate.pedestrian_free_speed))
                .count();
            if met < criterion.in_at_least.map_or(showings.len(), |least| least as usize) {
                return RetentionVerdict::Failed(index);
            }
        }
        RetentionVerdict::Retained
    }

    fn run(&self, number: usize, index: usize, candidate: &Parameters) -> Vec<Showing> {
        let meeting = self.criteria[index].meeting(candidate);
        let run = |repetition| {
            let key = format!("calibrate/{number}/{index}/{repetition}");
            let mut showing = Showing::default();
            meeting.run(&self.variant, candidate, derive_seed(self.seed, &key), |moment| {
                showing.see(moment.time, &moment.pedestrian, moment.collides());
                true
            });
            showing
        };
        (0..self.repetitions).map(run).collect()
    }
}

/// A calibration to be done, and in words where its candidates come from.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// What the candidates are put through.
    pub calibration: Calibration,
    /// The candidates.
    pub candidates: Candidates,
    /// Where they come from.
    pub design: String,
}

impl Request {
    /// Identifies the calibration: the same text for the same results.
    pub fn fingerprint(&self) -> String {
        let Calibration { variant, criteria, repetitions, seed } = &self.calibration;
        let mut hash = Sha256::new();
        hash.update(format!("{variant} {criteria:?} {repetitions} {seed} {:?}", self.candidates.names));
        for value in self.candidates.rows.iter().flatten() {
            hash.update(value.to_bits().to_le_bytes());
        }
        format!("calibration {}", hexadecimal(&hash.finalize()))
    }
}

/// What came of a calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// The numbers of the candidates that met all criteria, counted from 1.
    pub retained: Vec<usize>,
    /// How many failed each criterion first.
    pub failed: Vec<usize>,
}

/// Judges every candidate that the journal does not know, in parallel. `judged` is told of each.
///
/// The result depends on the request alone: not on threads, order or interruptions.
///
/// # Errors
/// If a candidate's parameters are none, or the journal cannot be written.
pub fn calibrate(
    request: &Request,
    journal: Option<&CalibrationJournal>,
    judged: impl Fn() + Sync,
) -> Result<Report, CalibrateError> {
    let judge = |(number, candidate): (usize, Parameters)| -> Result<RetentionVerdict, CalibrateError> {
        let known = journal.and_then(|journal| journal.verdict(number));
        let verdict = match known {
            Some(verdict) => verdict,
            None => {
                let verdict = request.calibration.judge(number, &candidate);
                if let Some(journal) = journal {
                    journal.add(number, verdict)?;
                }
                verdict
            }
        };
        judged();
        Ok(verdict)
    };
    let candidates = request.candidates.parameters()?;
    let verdicts = candidates.into_par_iter().map(judge).collect::<Result<Vec<_>, _>>()?;
    let mut report = Report { retained: Vec::new(), failed: vec![0; request.calibration.criteria.len()] };
    for (index, verdict) in verdicts.into_iter().enumerate() {
        match verdict {
            RetentionVerdict::Retained => report.retained.push(index + 1),
            RetentionVerdict::Failed(criterion) => {
                if let Some(count) = report.failed.get_mut(criterion) {
                    *count += 1;
                }
            }
        }
    }
    Ok(report)
}

/// Why a calibration stopped.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CalibrateError {
    /// The candidates.
    #[error(transparent)]
    Candidates(#[from] CandidateError),
    /// The journal.
    #[error(transparent)]
    Journal(#[from] JournalError),
}

impl Report {
    /// The retained individuals as a population with its provenance.
    pub fn population(&self, request: &Request) -> Population {
        let Calibration { variant, criteria, repetitions, seed } = &request.calibration;
        let failed: Vec<_> = criteria
            .iter()
            .zip(&self.failed)
            .map(|(criterion, failed)| json!({ "criterion": criterion, "failed": failed }))
            .collect();
        let provenance = [
            ("tool", json!(format!("scenario-runner {} calibrate", env!("CARGO_PKG_VERSION")))),
            ("design", json!(request.design)),
            ("seed", json!(seed)),
            ("repetitions", json!(repetitions)),
            ("candidates", json!(request.candidates.rows.len())),
            ("retained", json!(self.retained.len())),
            ("criteria", json!(failed)),
        ];
        let source = if criteria.is_empty() {
            "candidates by parameters of Markkula et al., PNAS Nexus 2(6), 2023 (facts of a data set under CC BY-NC-SA 4.0); no criterion was asked of them"
        } else {
            "retained by the procedure of Markkula et al., PNAS Nexus 2(6), 2023, out of candidates within ranges of its parameters (facts of a data set under CC BY-NC-SA 4.0)"
        };
        Population {
            model: commotions().declaration.name.to_string(),
            variant: Some(variant.to_string()),
            source: source.to_owned(),
            provenance: provenance.map(|(name, value)| (name.to_owned(), value)).into(),
            weights: Vec::new(),
            parameters: request.candidates.names.clone(),
            individuals: self
                .retained
                .iter()
                .filter_map(|number| request.candidates.rows.get(number - 1).cloned())
                .collect(),
        }
    }
}
