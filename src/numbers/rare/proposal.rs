//! Densities that points are proposed by: normal in the continuous coordinates, shares of the categories, and mixtures of such.

use super::space::{RarePlace, RareSpace, category};
use crate::random::Stream;

/// A density beside the one that is drawn from.
#[derive(Debug, Clone)]
pub struct Component {
    pub mean: Vec<f64>,
    /// Lower triangle of the covariance's Cholesky factor, by rows.
    factor: Vec<Vec<f64>>,
    log_determinant: f64,
    /// Of each axis of categories.
    categories: Vec<Vec<f64>>,
    /// ln of each category's share here and where it is drawn from, one less the other.
    log_shares: Vec<Vec<f64>>,
}

impl Component {
    /// `None` of a covariance that is not positive.
    pub fn new(
        space: &RareSpace,
        mean: Vec<f64>,
        covariance: &[Vec<f64>],
        categories: Vec<Vec<f64>>,
    ) -> Option<Self> {
        let factor = cholesky(covariance)?;
        let log_determinant = factor.iter().enumerate().map(|(row, own)| libm::log(own[row])).sum();
        let logs = |(own, shares): (&Vec<f64>, &Vec<f64>)| {
            own.iter().zip(shares).map(|(own, share)| libm::log(*own) - libm::log(*share)).collect()
        };
        let log_shares = categories.iter().zip(space.shares()).map(logs).collect();
        Some(Self { mean, factor, log_determinant, categories, log_shares })
    }

    /// As it is drawn.
    pub fn nominal(space: &RareSpace) -> Self {
        Self::around_nothing(space, 1.0, space.shares().to_vec())
    }

    /// Farther out than it is drawn, in all directions, and categories that are rare half the time.
    pub fn wide(space: &RareSpace) -> Self {
        let mixed = |shares: &Vec<f64>| {
            let possible = shares.iter().filter(|share| **share > 0.0).count() as f64;
            let mixed = |share: &f64| if *share > 0.0 { 0.5 * share + 0.5 / possible } else { 0.0 };
            shares.iter().map(mixed).collect()
        };
        Self::around_nothing(space, WIDTH, space.shares().iter().map(mixed).collect())
    }

    fn around_nothing(space: &RareSpace, width: f64, categories: Vec<Vec<f64>>) -> Self {
        let dimensions = space.continuous();
        let covariance = diagonal(dimensions, width * width);
        Self::new(space, vec![0.0; dimensions], &covariance, categories).expect("a positive covariance")
    }

    pub fn draw(&self, stream: &mut Stream) -> RarePlace {
        let deviates: Vec<f64> = self.mean.iter().map(|_| stream.normal()).collect();
        let coordinate = |(mean, row): (&f64, &Vec<f64>)| {
            mean + row.iter().zip(&deviates).map(|(factor, deviate)| factor * deviate).sum::<f64>()
        };
        let z = self.mean.iter().zip(&self.factor).map(coordinate).collect();
        let categories = self.categories.iter().map(|shares| category(shares, stream.uniform())).collect();
        RarePlace { z, categories }
    }

    /// ln of the density here over the one that is drawn from.
    pub fn log_ratio(&self, place: &RarePlace) -> f64 {
        let mut log = 0.5 * place.z.iter().map(|z| z * z).sum::<f64>()
            - 0.5 * self.squared_distance(&place.z)
            - self.log_determinant;
        for (logs, category) in self.log_shares.iter().zip(&place.categories) {
            log += logs[*category];
        }
        log
    }

    /// From the mean, in standard deviations of this density.
    pub fn squared_distance(&self, z: &[f64]) -> f64 {
        let mut solved: Vec<f64> = Vec::with_capacity(z.len());
        for (row, (z, mean)) in self.factor.iter().zip(z.iter().zip(&self.mean)) {
            let known: f64 = row.iter().zip(&solved).map(|(factor, one)| factor * one).sum();
            solved.push((z - mean - known) / row[solved.len()]);
        }
        solved.iter().map(|one| one * one).sum()
    }
}

/// Of the wide component, standard deviations of what is drawn.
const WIDTH: f64 = 2.0;

/// ln of a mixture's density over the one that is drawn from; parts that are 0 are left out.
///
/// With parts that are the shares of runs drawn from each component, one less that is what a run weighs by the balance heuristic.
///
/// Source: E. Veach & L. Guibas, SIGGRAPH 1995; A. Owen & Y. Zhou, J. Am. Stat. Assoc. 95, 2000.
pub fn log_mixture<'a>(parts: impl Iterator<Item = (f64, &'a Component)>, place: &RarePlace) -> f64 {
    let logs = parts
        .filter(|(part, _)| *part > 0.0)
        .map(|(part, component)| libm::log(part) + component.log_ratio(place));
    log_sum(&logs.collect::<Vec<_>>())
}

/// ln of the sum of what these are ln of; negative infinity of none.
pub fn log_sum(logs: &[f64]) -> f64 {
    let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if most == f64::NEG_INFINITY {
        return most;
    }
    most + libm::log(logs.iter().map(|log| libm::exp(log - most)).sum::<f64>())
}

/// A square matrix with this on its diagonal.
pub fn diagonal(dimensions: usize, value: f64) -> Vec<Vec<f64>> {
    (0..dimensions)
        .map(|row| (0..dimensions).map(|column| if row == column { value } else { 0.0 }).collect())
        .collect()
}

/// The lower triangle whose product with its transpose the matrix is; `None` where there is none.
fn cholesky(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let mut factor: Vec<Vec<f64>> = Vec::with_capacity(matrix.len());
    for (row, values) in matrix.iter().enumerate() {
        let mut own: Vec<f64> = Vec::with_capacity(row + 1);
        for column in 0..row {
            let known: f64 = own.iter().zip(&factor[column]).map(|(a, b)| a * b).sum();
            own.push((values[column] - known) / factor[column][column]);
        }
        let rest = values[row] - own.iter().map(|one| one * one).sum::<f64>();
        if rest.is_nan() || rest <= 0.0 {
            return None;
        }
        own.push(rest.sqrt());
        factor.push(own);
    }
    Some(factor)
}
