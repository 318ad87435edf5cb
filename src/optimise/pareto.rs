//! Several objectives: the non-dominated set, and the scalarisation that lets one surrogate look for more of it.

use rand::RngExt;

use super::random::{Purpose, stream};

/// Weight of the sum beside the maximum in the augmented Tchebycheff function.
const AUGMENTATION: f64 = 0.05;

/// Does `a` dominate `b`: nowhere worse, somewhere better? All objectives to be minimised.
fn dominates(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b) && a.iter().zip(b).any(|(a, b)| a < b)
}

/// Indices of the vectors that no other dominates, in order. All objectives to be minimised.
pub fn non_dominated(vectors: &[Vec<f64>]) -> Vec<usize> {
    (0..vectors.len()).filter(|&i| !vectors.iter().any(|other| dominates(other, &vectors[i]))).collect()
}

/// Weights of a proposal's scalarisation: uniform over the simplex.
pub(super) fn weights(objectives: usize, seed: u64, proposal: u64) -> Vec<f64> {
    let mut generator = stream(seed, proposal, Purpose::Weights);
    let exponential: Vec<f64> =
        (0..objectives).map(|_| -libm::log(1.0 - generator.random::<f64>())).collect();
    let sum: f64 = exponential.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    exponential.into_iter().map(|weight| weight / sum).collect()
}

/// ParEGO's augmented Tchebycheff function (Knowles 2006, eq. 2): one number to minimise for each vector of objectives, these
/// scaled by their observed ranges.
pub(super) fn scalarised(vectors: &[Vec<f64>], weights: &[f64]) -> Vec<f64> {
    let range = |k: usize| {
        let column = vectors.iter().map(|vector| vector[k]);
        let low = column.clone().fold(f64::INFINITY, f64::min);
        let width = column.fold(f64::NEG_INFINITY, f64::max) - low;
        (low, if width > 0.0 { width } else { 1.0 })
    };
    let ranges: Vec<(f64, f64)> = (0..weights.len()).map(range).collect();
    let scalar = |vector: &Vec<f64>| {
        let terms = vector
            .iter()
            .zip(&ranges)
            .zip(weights)
            .map(|((value, (low, width)), w)| w * (value - low) / width);
        terms.clone().fold(f64::NEG_INFINITY, f64::max) + AUGMENTATION * terms.sum::<f64>()
    };
    vectors.iter().map(scalar).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dominated_vectors_leave_and_equal_ones_stay() {
        let vectors = [[1.0, 4.0], [2.0, 2.0], [3.0, 3.0], [4.0, 1.0], [2.0, 2.0], [4.0, 4.0]].map(Vec::from);
        assert_eq!(non_dominated(&vectors), [0, 1, 3, 4]);
    }

    #[test]
    fn extreme_weights_look_at_one_objective() {
        let vectors = [[0.0, 10.0], [10.0, 0.0]].map(Vec::from);
        let first = scalarised(&vectors, &[1.0, 0.0]);
        assert!(first[0] < first[1]);
        let second = scalarised(&vectors, &[0.0, 1.0]);
        assert!(second[1] < second[0]);
        let drawn = weights(2, 1, 7);
        assert!((drawn.iter().sum::<f64>() - 1.0).abs() < 1e-12 && drawn != weights(2, 1, 8));
    }
}
