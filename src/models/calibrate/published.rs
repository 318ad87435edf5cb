//! The candidates of the published fit of the default variant, as far as the published individuals show them.

use super::candidates::Candidates;
use crate::pedestrian::commotions::model::commotions;
use crate::pedestrian::commotions::{Variant, VariantError};
use files::Disk;
use numbers::random::Stream;
use numbers::random::derive_seed;
use scenario::population::{Population, PopulationError};
use std::path::Path;

/// The deterministic variant whose retained sets the stochastic fits started from.
const DETERMINISTIC: &str = "oVAoBEvoAI";

/// What the published fit of the default variant retained: 1,091 of 5,000.
pub const PUBLISHED_SHARE: f64 = 1091.0 / 5000.0;

/// Why there are no published candidates.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PublishedError {
    /// The file of individuals.
    #[error(transparent)]
    Population(#[from] Box<PopulationError>),
    /// Its individuals lack a parameter.
    #[error("the published individuals give no `{0}`")]
    Missing(String),
    /// A variant's name.
    #[error(transparent)]
    Variant(#[from] VariantError),
}

/// `count` of the candidates of the published fit of the default variant, drawn at random by `seed`; all if `count` is
/// not below their number.
///
/// They are not published, but the individuals in `file` show what they were: every (T_delta, beta_V) is one of the
/// sets retained for the deterministic variant, crossed with the combinations of (T, DeltaV_th_rel, tau_theta), of
/// which the individuals of all variants together take 125 of 1,000. A combination of which nobody was retained cannot
/// be seen.
///
/// # Errors
/// If the file cannot be read or is another one.
pub fn published_candidates(file: &Path, count: usize, seed: u64) -> Result<Candidates, PublishedError> {
    let read = |variant: &str| {
        Population::read(file, &commotions().declaration, Some(variant), &Disk).map_err(Box::new)
    };
    let base = read(DETERMINISTIC)?;
    let retained = read(&Variant::STANDARD.to_string())?;
    let noise: Vec<&String> =
        retained.parameters.iter().filter(|name| !base.parameters.contains(name)).collect();
    let columns = noise.iter().map(|name| {
        let column = retained.parameters.iter().position(|found| found == *name);
        column.ok_or_else(|| PublishedError::Missing((*name).clone()))
    });
    let columns = columns.collect::<Result<Vec<usize>, _>>()?;
    let mut combinations: Vec<Vec<f64>> =
        retained.individuals.iter().map(|row| columns.iter().map(|&c| row[c]).collect()).collect();
    combinations.sort_by(|a, b| a.iter().map(|x| x.to_bits()).cmp(b.iter().map(|x| x.to_bits())));
    combinations.dedup();
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(base.len() * combinations.len());
    for set in &base.individuals {
        rows.extend(combinations.iter().map(|combination| [set.as_slice(), combination].concat()));
    }
    if count < rows.len() {
        let mut stream = Stream::seeded(derive_seed(seed, "published candidates"));
        stream.draw(&mut rows, count);
    }
    let names = base.parameters.iter().chain(noise).cloned().collect();
    Ok(Candidates { names, rows })
}
