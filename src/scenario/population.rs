//! Populations: files of individuals, each a parameter set of a pedestrian model, and those that ship.
//!
//! JSON with provenance, JSON as the published fits come (several variants in one file), or CSV. The format is
//! documented in `docs/populations.md`.

mod mixture;
mod plausibility;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::{Declaration, Parameter, Settings, Value};
use files::{Files, hexadecimal};

pub use mixture::{MixtureError, MixturePart};
pub use plausibility::Plausibility;

/// Whoever meets the published criteria.
pub const STANDARD: &str = "standard";

/// Weights over such people, who do what people did in an experiment.
pub const HUMANS: &str = "humans";

/// Those who were [`HUMANS`] in version 1, for whoever has baselines of them.
pub const HUMANS_1: &str = "humans_1";

/// The populations that are part of the program: name, version, text.
const SHIPPED: [(&str, u32, &str); 3] = [
    (STANDARD, 1, include_str!("population/standard.json")),
    (HUMANS, 2, include_str!("population/humans.json")),
    (HUMANS_1, 1, include_str!("population/humans_1.json")),
];

/// Whose people they are.
pub const SHIPPED_MODEL: &str = "commotions";

/// Names of the populations that are part of the program, which need no file.
pub fn shipped() -> impl Iterator<Item = &'static str> {
    SHIPPED.iter().map(|(name, ..)| *name)
}

/// Which version of a population that ships this is, counted from 1: whoever is in it is said by its digest, and that they are others
/// than before by another version. `None` of every other name.
pub fn shipped_version(name: &str) -> Option<u32> {
    SHIPPED.iter().find(|(known, ..)| *known == name).map(|(_, version, _)| *version)
}

/// The name under which an older version of a population still ships; `None` of those that do not, and of the newest.
pub fn shipped_older(name: &str, version: u32) -> Option<&'static str> {
    let older = format!("{name}_{version}");
    shipped().find(|known| *known == older)
}

/// The parameter that names a model's variant.
pub const VARIANT: &str = "variant";

/// In the provenance of a population: the speeds (m/s) of vehicles that its people were observed with.
pub const VEHICLE_SPEEDS: &str = "vehicle_speeds";

/// A population: parameter sets of one model, numbered from 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Population {
    /// The model whose parameters these are.
    pub model: String,
    /// The variant of the model that they belong to, if it has variants.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub variant: Option<String>,
    /// Where the individuals come from, in words.
    pub source: String,
    /// How they were produced: seed, criteria, candidates, counts, version.
    #[serde(skip_serializing_if = "BTreeMap::is_empty", default)]
    pub provenance: BTreeMap<String, serde_json::Value>,
    /// The names of the columns: parameters of the model.
    pub parameters: Vec<String>,
    /// One row per individual, in SI units.
    pub individuals: Vec<Vec<f64>>,
    /// How often each stands for one of the [`WEIGHTED_MEMBERS`], of sum 1; empty where each is one.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub weights: Vec<f64>,
}

/// How many people a population with weights has: each row stands for its share of them, in the order of the rows.
pub const WEIGHTED_MEMBERS: usize = 10_000;

/// By how much weights may miss a sum of 1.
const ROUNDED_SUM: f64 = 1e-6;

/// The form of the published files: parameter sets of several variants.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PublishedFits {
    source: String,
    variants: BTreeMap<String, PublishedFit>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PublishedFit {
    params: Vec<String>,
    #[serde(rename = "ranges")]
    _ranges: Vec<(f64, f64)>,
    #[serde(rename = "published")]
    _published: u64,
    rows: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum JsonForm {
    Published {
        #[serde(rename = "variants")]
        _variants: serde::de::IgnoredAny,
    },
    Own(serde::de::IgnoredAny),
}

/// What is wrong with a population, and where.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PopulationError {
    /// The file cannot be read.
    #[error("cannot read the population {}: {error}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        error: String,
    },
    /// The name ends neither in `.json` nor in `.csv`.
    #[error("the population `{}` is neither `{STANDARD}` nor `{HUMANS}` nor a .json or .csv file", file.display())]
    UnknownFormat {
        /// The file.
        file: PathBuf,
    },
    /// The file is no JSON of one of the two forms.
    #[error("{}: {error}", file.display())]
    Json {
        /// The file.
        file: PathBuf,
        /// Line, column and what was expected.
        error: serde_json::Error,
    },
    /// The file is no CSV.
    #[error("{}: {error}", file.display())]
    Csv {
        /// The file.
        file: PathBuf,
        /// Line and what is wrong with it.
        error: csv::Error,
    },
    /// The individuals are those of another model.
    #[error("{}: a population of the model `{found}`, but the pedestrian's model is `{expected}`", file.display())]
    OtherModel {
        /// The file.
        file: PathBuf,
        /// The population's.
        found: String,
        /// The pedestrian's.
        expected: String,
    },
    /// The individuals are those of another variant.
    #[error("{}: a population of the variant `{found}`, but the pedestrian's variant is `{expected}`", file.display())]
    OtherVariant {
        /// The file.
        file: PathBuf,
        /// The population's.
        found: String,
        /// The pedestrian's.
        expected: String,
    },
    /// None of the variants in the file is the one asked for.
    #[error("{}: no individuals of the variant `{variant}`; the file has {}", file.display(), listed(variants))]
    NoSuchVariant {
        /// The file.
        file: PathBuf,
        /// The one asked for.
        variant: String,
        /// Those in the file, nearest first.
        variants: Vec<String>,
    },
    /// A column names no parameter.
    #[error("{}, column {column}: `{found}` is no parameter of `{model}`{}", file.display(), did_you_mean(nearest))]
    UnknownParameter {
        /// The file.
        file: PathBuf,
        /// Counted from 1.
        column: usize,
        /// The name.
        found: String,
        /// The model.
        model: String,
        /// The nearest name there is.
        nearest: Option<String>,
    },
    /// Two columns name the same parameter.
    #[error("{}, column {column}: `{name}` stands there a second time", file.display())]
    RepeatedParameter {
        /// The file.
        file: PathBuf,
        /// Counted from 1.
        column: usize,
        /// The name.
        name: String,
    },
    /// A row has too few or too many values.
    #[error("{}, row {row}: {found} values for {expected} parameters", file.display())]
    RowLength {
        /// The file.
        file: PathBuf,
        /// Counted from 1, without the header.
        row: usize,
        /// Values in the row.
        found: usize,
        /// Parameters.
        expected: usize,
    },
    /// A value is no number.
    #[error("{}, row {row}, column `{column}`: `{found}` is no number", file.display())]
    NotANumber {
        /// The file.
        file: PathBuf,
        /// Counted from 1, without the header.
        row: usize,
        /// The parameter.
        column: String,
        /// What stands there.
        found: String,
    },
    /// A value is outside the parameter's range.
    #[error("{}, row {row}, column `{column}`: {problem}", file.display())]
    OutOfRange {
        /// The file.
        file: PathBuf,
        /// Counted from 1, without the header.
        row: usize,
        /// The parameter.
        column: String,
        /// Value, allowed range and unit.
        problem: Box<crate::SettingError>,
    },
    /// There are more or fewer weights than rows.
    #[error("{}: {found} weights for {expected} individuals", file.display())]
    WeightCount {
        /// The file.
        file: PathBuf,
        /// Weights.
        found: usize,
        /// Individuals.
        expected: usize,
    },
    /// A weight is no share.
    #[error("{}, weight {row}: {found} is no share between 0 and 1", file.display())]
    Weight {
        /// The file.
        file: PathBuf,
        /// Counted from 1.
        row: usize,
        /// What stands there.
        found: f64,
    },
    /// Weights do not add up to 1.
    #[error("{}: the weights add up to {sum:.6}, not to 1; divide each by that", file.display())]
    WeightSum {
        /// The file.
        file: PathBuf,
        /// Their sum.
        sum: f64,
    },
    /// There is nobody in it.
    #[error("{}: a population without individuals", file.display())]
    Empty {
        /// The file.
        file: PathBuf,
    },
}

fn listed(variants: &[String]) -> String {
    const SHOWN: usize = 5;
    let shown: Vec<_> = variants.iter().take(SHOWN).map(|name| format!("`{name}`")).collect();
    match variants.len().saturating_sub(SHOWN) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

fn did_you_mean(nearest: &Option<String>) -> String {
    nearest.as_ref().map(|name| format!("; did you mean `{name}`?")).unwrap_or_default()
}

impl Population {
    /// Reads the population in a file for a model, as [`Self::parse`].
    ///
    /// # Errors
    /// Whatever is wrong with the file, with row, column and allowed range.
    pub fn read(
        file: &Path,
        model: &Declaration,
        variant: Option<&str>,
        files: &dyn Files,
    ) -> Result<Self, PopulationError> {
        let text = files.read_text(file, &["csv", "json"]).map_err(|error| error.to_string());
        let text = text.as_deref().map_err(String::as_str);
        Self::parse(&file.to_string_lossy(), Some(text), model, variant)
    }

    /// The population `name` for a model: one that [ships](shipped), or a file, of which `text` is what stands in it or why it cannot be
    /// read.
    ///
    /// `variant` is the model's variant if the pedestrian says one. A file with several variants gives that one's
    /// individuals, or those of the model's default variant; in a population of one variant it must agree.
    ///
    /// # Errors
    /// Whatever is wrong with the file, with row, column and allowed range.
    pub fn parse(
        name: &str,
        text: Option<Result<&str, &str>>,
        model: &Declaration,
        variant: Option<&str>,
    ) -> Result<Self, PopulationError> {
        if let Some((name, _, text)) = SHIPPED.iter().find(|(known, ..)| *known == name) {
            return Self::from_json(Path::new(name), text, model, variant);
        }
        let file = Path::new(name);
        let text = || {
            text.unwrap_or(Err("nobody has read it"))
                .map_err(|error| PopulationError::Read { file: file.to_owned(), error: error.to_string() })
        };
        match file.extension().and_then(|extension| extension.to_str()) {
            Some("json") => Self::from_json(file, text()?, model, variant),
            Some("csv") => Self::from_csv(file, text()?, model, variant),
            _ => Err(PopulationError::UnknownFormat { file: file.to_owned() }),
        }
    }

    /// Reads either JSON form; `file` is named in errors.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_json(
        file: &Path,
        text: &str,
        model: &Declaration,
        variant: Option<&str>,
    ) -> Result<Self, PopulationError> {
        let malformed = |error| PopulationError::Json { file: file.to_owned(), error };
        let population = match serde_json::from_str(text).map_err(malformed)? {
            JsonForm::Published { .. } => {
                let fits: PublishedFits = serde_json::from_str(text).map_err(malformed)?;
                let wanted = variant.or_else(|| default_variant(model)).unwrap_or_default();
                fits.choose(file, model, wanted)?
            }
            JsonForm::Own(_) => serde_json::from_str(text).map_err(malformed)?,
        };
        population.check(file, model, variant)?;
        Ok(population)
    }

    /// Reads CSV: a header of parameter names, one row per individual, `#` before comments.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_csv(
        file: &Path,
        text: &str,
        model: &Declaration,
        variant: Option<&str>,
    ) -> Result<Self, PopulationError> {
        let malformed = |error| PopulationError::Csv { file: file.to_owned(), error };
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(text.as_bytes());
        let parameters: Vec<String> =
            reader.headers().map_err(malformed)?.iter().map(str::to_owned).collect();
        let mut individuals = Vec::new();
        for (index, record) in reader.records().enumerate() {
            let record = record.map_err(malformed)?;
            if record.len() != parameters.len() {
                return Err(PopulationError::RowLength {
                    file: file.to_owned(),
                    row: index + 1,
                    found: record.len(),
                    expected: parameters.len(),
                });
            }
            let number = |(field, column): (&str, &String)| {
                field.parse::<f64>().map_err(|_| PopulationError::NotANumber {
                    file: file.to_owned(),
                    row: index + 1,
                    column: column.clone(),
                    found: field.to_owned(),
                })
            };
            individuals.push(record.iter().zip(&parameters).map(number).collect::<Result<_, _>>()?);
        }
        let population = Self {
            model: model.name.to_string(),
            variant: variant.map(str::to_owned),
            source: file.display().to_string(),
            provenance: BTreeMap::new(),
            parameters,
            individuals,
            weights: Vec::new(),
        };
        population.check(file, model, variant)?;
        Ok(population)
    }

    /// The population as JSON, one individual a line.
    ///
    /// # Errors
    /// If a number is not finite, which JSON cannot say.
    pub fn to_json(&self) -> serde_json::Result<String> {
        let bare = Self { individuals: Vec::new(), weights: Vec::new(), ..self.clone() };
        let head = serde_json::to_string_pretty(&bare)?;
        let rows = self.individuals.iter().map(serde_json::to_string).collect::<Result<Vec<_>, _>>()?;
        let open = head.trim_end_matches(['}', '\n', ']']);
        let weights = self.weights.iter().map(serde_json::to_string).collect::<Result<Vec<_>, _>>()?;
        let weights = if weights.is_empty() {
            String::new()
        } else {
            format!(",\n  \"weights\": [\n{}\n  ]", weights.join(",\n"))
        };
        Ok(format!("{open}\n{}\n  ]{weights}\n}}\n", rows.join(",\n")))
    }

    /// How many there are: of rows with weights [`WEIGHTED_MEMBERS`].
    pub fn len(&self) -> usize {
        if self.weights.is_empty() { self.individuals.len() } else { WEIGHTED_MEMBERS }
    }

    /// The row of the individual `number`, counted from 1.
    fn row(&self, number: usize) -> Option<&Vec<f64>> {
        let index = number.checked_sub(1)?;
        if self.weights.is_empty() {
            return self.individuals.get(index);
        }
        if index >= WEIGHTED_MEMBERS {
            return None;
        }
        // Where so much of the population is before; but for rounding the last row is never passed.
        let before = (index as f64 + 0.5) / WEIGHTED_MEMBERS as f64;
        let mut sum = 0.0;
        let found = self.weights.iter().position(|weight| {
            sum += weight;
            sum >= before
        });
        self.individuals.get(found.unwrap_or(self.weights.len() - 1))
    }

    /// The first 16 hexadecimal digits of SHA-256 over model, variant, parameters and weights: whatever the file is called.
    pub fn digest(&self) -> String {
        let content = (&self.model, &self.variant, &self.parameters, &self.individuals, &self.weights);
        let text = serde_json::to_vec(&content).unwrap_or_default();
        hexadecimal(&Sha256::digest(text)[..8])
    }

    /// The lowest and the highest speed (m/s) of vehicles that its people were observed with, as its provenance says; `None` where it does
    /// not.
    pub fn observed_speeds(&self) -> Option<(f64, f64)> {
        let speeds = self.provenance.get(VEHICLE_SPEEDS)?.as_array()?;
        let speeds: Vec<f64> = speeds.iter().filter_map(serde_json::Value::as_f64).collect();
        let low = speeds.iter().copied().reduce(f64::min)?;
        Some((low, speeds.iter().copied().fold(low, f64::max)))
    }

    /// Whether nobody is in it.
    pub fn is_empty(&self) -> bool {
        self.individuals.is_empty()
    }

    /// The parameters of the individual `number`, counted from 1; `None` if there is none of that number.
    pub fn individual(&self, number: usize) -> Option<Settings> {
        let row = self.row(number)?;
        let mut settings = Settings::default();
        if let Some(variant) = &self.variant {
            settings.set(VARIANT, Value::Word(variant.clone()));
        }
        for (name, value) in self.parameters.iter().zip(row) {
            settings.set(name.clone(), Value::Number(*value));
        }
        Some(settings)
    }

    fn check(&self, file: &Path, model: &Declaration, variant: Option<&str>) -> Result<(), PopulationError> {
        let file = || file.to_owned();
        if self.model != model.name {
            return Err(PopulationError::OtherModel {
                file: file(),
                found: self.model.clone(),
                expected: model.name.to_string(),
            });
        }
        if let (Some(found), Some(expected)) = (&self.variant, variant)
            && found != expected
        {
            return Err(PopulationError::OtherVariant {
                file: file(),
                found: found.clone(),
                expected: expected.to_owned(),
            });
        }
        let mut columns: Vec<&Parameter> = Vec::with_capacity(self.parameters.len());
        for (index, name) in self.parameters.iter().enumerate() {
            let parameter = model.parameter(name).ok_or_else(|| PopulationError::UnknownParameter {
                file: file(),
                column: index + 1,
                found: name.clone(),
                model: model.name.to_string(),
                nearest: nearest(name, model),
            })?;
            if columns.iter().any(|earlier| earlier.name == name.as_str()) {
                return Err(PopulationError::RepeatedParameter {
                    file: file(),
                    column: index + 1,
                    name: name.clone(),
                });
            }
            columns.push(parameter);
        }
        for (index, values) in self.individuals.iter().enumerate() {
            let row = index + 1;
            if values.len() != columns.len() {
                return Err(PopulationError::RowLength {
                    file: file(),
                    row,
                    found: values.len(),
                    expected: columns.len(),
                });
            }
            for (value, parameter) in values.iter().zip(&columns) {
                parameter.check(&model.name, &Value::Number(*value)).map_err(|problem| {
                    PopulationError::OutOfRange {
                        file: file(),
                        row,
                        column: parameter.name.to_string(),
                        problem: Box::new(problem),
                    }
                })?;
            }
        }
        if self.is_empty() {
            return Err(PopulationError::Empty { file: file() });
        }
        if !self.weights.is_empty() {
            let (found, expected) = (self.weights.len(), self.individuals.len());
            if found != expected {
                return Err(PopulationError::WeightCount { file: file(), found, expected });
            }
            if let Some(index) = self.weights.iter().position(|weight| !(0.0..=1.0).contains(weight)) {
                return Err(PopulationError::Weight {
                    file: file(),
                    row: index + 1,
                    found: self.weights[index],
                });
            }
            let sum: f64 = self.weights.iter().sum();
            if (sum - 1.0).abs() > ROUNDED_SUM {
                return Err(PopulationError::WeightSum { file: file(), sum });
            }
        }
        Ok(())
    }
}

impl PublishedFits {
    fn choose(
        mut self,
        file: &Path,
        model: &Declaration,
        wanted: &str,
    ) -> Result<Population, PopulationError> {
        let Some(fit) = self.variants.remove(wanted) else {
            let mut variants: Vec<String> = self.variants.into_keys().collect();
            variants.sort_by_key(|name| strsim::levenshtein(name, wanted));
            return Err(PopulationError::NoSuchVariant {
                file: file.to_owned(),
                variant: wanted.to_owned(),
                variants,
            });
        };
        Ok(Population {
            model: model.name.to_string(),
            variant: Some(wanted.to_owned()),
            source: self.source,
            provenance: BTreeMap::new(),
            parameters: fit.params,
            individuals: fit.rows,
            weights: Vec::new(),
        })
    }
}

fn default_variant(model: &Declaration) -> Option<&str> {
    match &model.parameter(VARIANT)?.kind {
        crate::ParameterKind::Text { default, .. } => Some(default),
        _ => None,
    }
}

fn nearest(name: &str, model: &Declaration) -> Option<String> {
    let candidates = model.parameters.iter().map(|parameter| &*parameter.name);
    candidates
        .map(|candidate| (strsim::damerau_levenshtein(candidate, name), candidate))
        .filter(|&(distance, candidate)| distance * 2 <= candidate.len().max(2))
        .min()
        .map(|(_, candidate)| candidate.to_string())
}
