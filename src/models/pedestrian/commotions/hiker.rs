//! The HIKER crossing experiment: a pedestrian at the kerb, a gap behind a first car, a second car that yields or does not.
//!
//! Human data: Lee et al. 2022. The model's reference: the published fits of Markkula et al. 2023, simulated with
//! the authors' program.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::meeting::{Meeting, MetDriver, PEDESTRIAN, VEHICLE, Waiting};
use super::parameters::Parameters;
use super::variant::{Variant, VariantError};
use numbers::random::derive_seed;
use numbers::summary::median;

/// When the first car has passed and the pedestrian may enter (s).
const FIRST_CAR_PASSES: f64 = 3.0;

/// The pedestrian waits for the first car as in the published simulations: entering is worth nothing until it has passed.
pub const AS_PUBLISHED: Waiting = Waiting::Inhibited(FIRST_CAR_PASSES);

/// The pedestrian stands and looks until the first car has passed.
pub const LOOKING: Waiting = Waiting::Looking(FIRST_CAR_PASSES);

/// The reference file, `hiker_reference.json`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HikerReference {
    /// What the file says about itself.
    #[serde(rename = "note")]
    pub _note: String,
    /// The levels of all quantiles.
    pub quantile_levels: Vec<f64>,
    /// The variant simulated.
    pub variant: String,
    /// Its individuals.
    pub parameters: HikerIndividuals,
    /// The scenarios by name: speed in mph, time gap in s, and `y` where the second car yields.
    pub scenarios: BTreeMap<String, HikerScenario>,
}

/// Parameter sets: names and rows of values.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HikerIndividuals {
    params: Vec<String>,
    rows: Vec<Vec<f64>>,
}

/// One scenario, what people did in it and what the reference program did.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HikerScenario {
    vehicle_speed: f64,
    #[serde(rename = "time_gap")]
    _time_gap: f64,
    #[serde(rename = "yielding")]
    _yielding: bool,
    #[serde(rename = "veh_initial_ttca")]
    _initial_time_to_arrival: f64,
    veh_d0: f64,
    ped_d0: f64,
    end_time: f64,
    profile: Vec<(f64, f64)>,
    /// What people did.
    pub human: HikerPeople,
    /// The reference program's runs.
    pub model: ReferenceRuns,
}

/// What people did in a scenario.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HikerPeople {
    /// How many trials.
    pub trials: u32,
    /// Share of them in which they crossed before the vehicle.
    pub crossed_before: f64,
    /// Quantiles of their initiation times (s after the first car passed); `None` where too few crossed.
    pub quantiles: Option<Vec<f64>>,
}

/// What came out of the reference program's runs.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceRuns {
    /// How many.
    pub runs: u32,
    /// Share of the runs in which the pedestrian crossed before the vehicle.
    pub crossed_before: f64,
    /// Quantiles of the start times of those (s after the first car passed); `None` where too few crossed.
    pub quantiles: Option<Vec<f64>>,
}

/// Why the reference cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum HikerError {
    /// The file cannot be read.
    #[error("cannot read {}: {error}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        error: files::ReadError,
    },
    /// The file is not of the format.
    #[error("{}: {error}", file.display())]
    Format {
        /// The file.
        file: PathBuf,
        /// Line, column and what was expected.
        error: serde_json::Error,
    },
    /// Its variant is none.
    #[error("{error}")]
    Variant {
        /// Why.
        #[from]
        error: VariantError,
    },
    /// It names a parameter that there is not.
    #[error("{}: `params` names `{name}`, which is no parameter of the model", file.display())]
    Parameter {
        /// The file.
        file: PathBuf,
        /// The name.
        name: String,
    },
    /// A row has too few or too many values.
    #[error("{}: row {row} of the parameters has {found} values, but there are {expected} names", file.display())]
    Row {
        /// The file.
        file: PathBuf,
        /// Counted from 1.
        row: usize,
        /// Values in the row.
        found: usize,
        /// Names.
        expected: usize,
    },
}

impl HikerReference {
    /// Reads the reference file.
    ///
    /// # Errors
    /// If it cannot be read or is not of the format.
    pub fn read(file: &Path) -> Result<Self, HikerError> {
        let text =
            files::read_text(file).map_err(|error| HikerError::Read { file: file.to_owned(), error })?;
        serde_json::from_str(&text).map_err(|error| HikerError::Format { file: file.to_owned(), error })
    }

    /// The individuals, of whom every `stride`-th is taken.
    fn individuals(&self, file: &Path, stride: usize) -> Result<Vec<Parameters>, HikerError> {
        let HikerIndividuals { params, rows } = &self.parameters;
        let mut people = Vec::with_capacity(rows.len());
        for (row, values) in rows.iter().enumerate().step_by(stride) {
            if values.len() != params.len() {
                return Err(HikerError::Row {
                    file: file.to_owned(),
                    row: row + 1,
                    found: values.len(),
                    expected: params.len(),
                });
            }
            let mut person = Parameters::default();
            for (name, value) in params.iter().zip(values) {
                let field = person
                    .get_mut(name)
                    .ok_or_else(|| HikerError::Parameter { file: file.to_owned(), name: name.clone() })?;
                *field = *value;
            }
            people.push(person);
        }
        Ok(people)
    }

    /// Runs every scenario with every `stride`-th individual, `repetitions` times each.
    ///
    /// # Errors
    /// If the reference names a variant or parameters that there are not.
    pub fn compare(
        &self,
        file: &Path,
        stride: usize,
        repetitions: u32,
        seed: u64,
    ) -> Result<Vec<HikerComparison>, HikerError> {
        let variant: Variant = self.variant.parse()?;
        let people = self.individuals(file, stride)?;
        let compare = |(name, scenario): (&String, &HikerScenario)| {
            let runs: Vec<Option<f64>> = (0..people.len() * repetitions as usize)
                .into_par_iter()
                .map(|run| {
                    let (person, repetition) = (run / repetitions as usize, run % repetitions as usize);
                    let seed = derive_seed(seed, &format!("hiker/{name}/{person}/{repetition}"));
                    scenario.start_of_crossing(&variant, &people[person], (seed, AS_PUBLISHED))
                })
                .collect();
            let mut starts: Vec<f64> = runs.iter().copied().flatten().collect();
            starts.sort_by(f64::total_cmp);
            HikerComparison {
                scenario: name.clone(),
                runs: runs.len(),
                crossed_before: starts.len() as f64 / runs.len() as f64,
                median_start: median(&starts),
                below_reference_median: self
                    .median_of(&scenario.model)
                    .filter(|_| !starts.is_empty())
                    .map(|reference| share_below(&starts, reference)),
                reference_runs: scenario.model.runs,
                reference_crossed_before: scenario.model.crossed_before,
                reference_median_start: self.median_of(&scenario.model),
            }
        };
        Ok(self.scenarios.iter().map(compare).collect())
    }

    fn median_of(&self, runs: &ReferenceRuns) -> Option<f64> {
        let middle = self.quantile_levels.iter().position(|&level| level == 0.5)?;
        runs.quantiles.as_ref()?.get(middle).copied()
    }
}

/// The share of values below `threshold`, those equal to it (but for rounding) counting half.
fn share_below(values: &[f64], threshold: f64) -> f64 {
    let weight = |value: &f64| match value - threshold {
        difference if difference.abs() < 1e-6 => 0.5,
        difference if difference < 0.0 => 1.0,
        _ => 0.0,
    };
    values.iter().map(weight).sum::<f64>() / values.len() as f64
}

impl HikerScenario {
    /// When the pedestrian starts to cross (s after the first car passed), if it crosses before the second.
    pub(super) fn start_of_crossing(
        &self,
        variant: &Variant,
        individual: &Parameters,
        (seed, waiting): (u64, Waiting),
    ) -> Option<f64> {
        let meeting = Meeting {
            pedestrian: (self.ped_d0, 0.0),
            vehicle: (self.veh_d0, self.vehicle_speed),
            driver: MetDriver::Timetable(self.profile.clone()),
            pedestrian_priority: false,
            waiting,
            dt: 0.025,
            end_time: self.end_time,
        };
        // Who has started when time is up, with the vehicle not yet there, enters before it.
        let (mut start, mut vehicle_enters_first) = (None, false);
        meeting.run(variant, individual, seed, |moment| {
            if start.is_none() && moment.pedestrian.speed > 0.0 {
                start = Some(moment.time - FIRST_CAR_PASSES);
            }
            let pedestrian_enters = moment.pedestrian.distance < PEDESTRIAN.half_extent;
            vehicle_enters_first = !pedestrian_enters && moment.vehicle.distance < VEHICLE.half_extent;
            !pedestrian_enters && !vehicle_enters_first
        });
        start.filter(|_| !vehicle_enters_first)
    }
}

/// Our runs of one scenario beside the reference's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HikerComparison {
    /// The scenario's name.
    pub scenario: String,
    /// How many runs.
    pub runs: usize,
    /// Share of them in which the pedestrian crossed first.
    pub crossed_before: f64,
    /// Median start time of those (s after the first car passed).
    pub median_start: Option<f64>,
    /// Share of our start times below the reference's median: one half but for chance.
    pub below_reference_median: Option<f64>,
    /// How many runs the reference has.
    pub reference_runs: u32,
    /// Its share.
    pub reference_crossed_before: f64,
    /// Its median.
    pub reference_median_start: Option<f64>,
}

impl HikerComparison {
    /// How many standard errors (of the difference of two shares) lie between the two shares.
    ///
    /// With the share of both together, so that a share of 0 has an error too.
    pub fn standard_errors(&self) -> f64 {
        let (n, m) = (self.runs as f64, f64::from(self.reference_runs));
        let together = (n * self.crossed_before + m * self.reference_crossed_before) / (n + m);
        let error = (together * (1.0 - together) * (1.0 / n + 1.0 / m)).sqrt();
        let difference = (self.crossed_before - self.reference_crossed_before).abs();
        if difference == 0.0 { 0.0 } else { difference / error }
    }

    /// Our median start time less the reference's (s), where both are defined.
    pub fn median_difference(&self) -> Option<f64> {
        Some(self.median_start? - self.reference_median_start?)
    }

    /// Whether the shares agree: within three standard errors.
    pub fn shares_agree(&self) -> bool {
        self.standard_errors() <= 3.0
    }

    /// Whether the medians are within 0.1 s, or one of them is undefined.
    pub fn medians_are_close(&self) -> bool {
        self.median_difference().is_none_or(|difference| difference.abs() <= 0.1 + 1e-9)
    }

    /// Whether the medians agree: close, or not told apart by three standard errors.
    pub fn medians_agree(&self) -> bool {
        self.medians_are_close() || self.median_standard_errors().is_none_or(|errors| errors <= 3.0)
    }

    /// How many standard errors lie between one half and the share of our start times below the reference's median.
    ///
    /// Where start times fall into two groups of about the same size, as before a car that yields late, the median
    /// lies anywhere in the gap between them; this share is still one half.
    pub fn median_standard_errors(&self) -> Option<f64> {
        let (ours, theirs) = (
            self.runs as f64 * self.crossed_before,
            f64::from(self.reference_runs) * self.reference_crossed_before,
        );
        let error = (0.25 * (1.0 / ours + 1.0 / theirs)).sqrt();
        Some((self.below_reference_median? - 0.5).abs() / error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_shares() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[1.0, 2.0, 9.0]), Some(2.0));
        assert_eq!(median(&[1.0, 2.0]), Some(1.5));
        assert_eq!(share_below(&[1.0, 2.0, 3.0, 4.0], 2.0), 0.375);
    }

    #[test]
    fn standard_errors_are_those_of_a_difference_of_shares() {
        let comparison = HikerComparison {
            scenario: String::new(),
            runs: 100,
            crossed_before: 0.6,
            median_start: Some(1.0),
            below_reference_median: Some(0.5),
            reference_runs: 100,
            reference_crossed_before: 0.4,
            reference_median_start: Some(1.2),
        };
        assert!((comparison.standard_errors() - 0.2 / (0.25f64 / 50.0).sqrt()).abs() < 1e-12);
        assert_eq!(comparison.median_standard_errors(), Some(0.0));
    }
}
