//! Parameters that a tune chose, as a file for later evaluations.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::error::ExperimentError;
use super::overrides;
use files::Files;
use results::TuneResult;
use scenario::{Suite, Target, Tune, Value};

/// What a tune chose, in its order; JSON.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParameterFile {
    /// The tune's name.
    pub name: String,
    /// What made it: suite, seed, version of the tool.
    pub source: String,
    /// What has to be known of them, such as that they keep no constraint everywhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub caveat: Option<String>,
    /// What was tuned, with the chosen values in SI units.
    pub parameters: Vec<(Target, Value)>,
}

impl ParameterFile {
    /// `None` if nothing was chosen.
    pub fn of(suite: &Suite, tune: &Tune, result: &TuneResult) -> Option<Self> {
        let chosen = result.chosen.as_ref()?;
        Some(Self {
            name: tune.name.clone(),
            source: format!(
                "tune {} of suite {}, seed {}, scenario-runner {}",
                tune.name,
                suite.name,
                suite.seed,
                env!("CARGO_PKG_VERSION")
            ),
            caveat: result.caveat(),
            parameters: overrides::settings(&tune.over, &chosen.point),
        })
    }

    /// As JSON, which [`Self::read`] takes.
    pub fn write(&self) -> String {
        serde_json::to_string_pretty(self).expect("plain data serialises") + "\n"
    }

    /// What was written before. [`ExperimentError::ParameterFile`] if the file cannot be read or is none.
    pub fn read(path: &Path, files: &dyn Files) -> Result<Self, ExperimentError> {
        let failed = |reason: String| ExperimentError::ParameterFile { path: path.to_owned(), reason };
        let text = files.read_text(path, &["json"]).map_err(|error| failed(error.to_string()))?;
        serde_json::from_str(&text).map_err(|error| failed(error.to_string()))
    }
}
