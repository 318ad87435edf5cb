//! Dense lower-triangular algebra for the exact likelihood: the few operations whose speed the cost goals hang on.
//!
//! nalgebra's Cholesky solves against a full identity for an inverse (three times the work) and its general product picks
//! its instructions by processor, so that two machines may differ in the last bit. Everything here is one fixed order of
//! additions, row by row, in contiguous memory.

/// Dot product with eight running sums, which the compiler can vectorise without changing the order of additions.
#[inline]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0f64; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f64 = a8.remainder().iter().zip(b8.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a8.zip(b8) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + b) + (c + d)) + ((e + f) + (g + h)) + tail
}

/// Right-hand sides that [`Factor::solve_lower_lanes`] takes at once.
pub(crate) const LANES: usize = 8;

/// A lower-triangular matrix L with L Lᵀ = the symmetric positive definite matrix it was made from. Row-major, n × n.
#[derive(Debug, Clone)]
pub(crate) struct Factor {
    n: usize,
    rows: Vec<f64>,
}

impl Factor {
    /// The Cholesky factor of a symmetric matrix of which the lower triangle is given row-major (n × n); `None` when the
    /// matrix is not positive definite to working precision.
    pub fn new(n: usize, mut rows: Vec<f64>) -> Option<Factor> {
        for i in 0..n {
            for j in 0..=i {
                let (above, current) = rows.split_at_mut(i * n);
                let row_j = if j == i { &current[..j] } else { &above[j * n..j * n + j] };
                let rest = current[j] - dot(&current[..j], row_j);
                if j < i {
                    current[j] = rest / above[j * n + j];
                } else if rest > 0.0 && rest.is_finite() {
                    current[i] = rest.sqrt();
                } else {
                    return None;
                }
            }
            rows[i * n + i + 1..(i + 1) * n].fill(0.0);
        }
        Some(Factor { n, rows })
    }

    /// Like [`Factor::new`], adding ever more to the diagonal, from `scale` × 1e-8 to `scale` × 1e-2, until it succeeds.
    /// Returns what was added, too.
    pub fn with_jitter(n: usize, rows: &[f64], scale: f64) -> Option<(Factor, f64)> {
        let ladder = [0.0, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2];
        ladder.iter().find_map(|step| {
            let mut rows = rows.to_vec();
            (0..n).for_each(|i| rows[i * n + i] += step * scale);
            Some((Factor::new(n, rows)?, step * scale))
        })
    }

    /// Row `i` up to and including the diagonal.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.rows[i * self.n..i * self.n + i + 1]
    }

    /// ln det of the factored matrix.
    pub fn log_determinant(&self) -> f64 {
        2.0 * (0..self.n).map(|i| libm::log(self.rows[i * self.n + i])).sum::<f64>()
    }

    /// Replaces b by L⁻¹ b.
    pub fn solve_lower(&self, b: &mut [f64]) {
        for i in 0..self.n {
            let row = self.row(i);
            b[i] = (b[i] - dot(&row[..i], &b[..i])) / row[i];
        }
    }

    /// Replaces each of [`LANES`] vectors b, which lie side by side, by L⁻¹ b.
    pub fn solve_lower_lanes(&self, b: &mut [[f64; LANES]]) {
        for i in 0..self.n {
            let (solved, rest) = b.split_at_mut(i);
            let row = self.row(i);
            let mut sums = [0.0; LANES];
            for (l, known) in row.iter().zip(solved.iter()) {
                for lane in 0..LANES {
                    sums[lane] += l * known[lane];
                }
            }
            for lane in 0..LANES {
                rest[0][lane] = (rest[0][lane] - sums[lane]) / row[i];
            }
        }
    }

    /// Replaces b by L⁻ᵀ b.
    pub fn solve_upper(&self, b: &mut [f64]) {
        for i in (0..self.n).rev() {
            let row = self.row(i);
            b[i] /= row[i];
            let scaled = b[i];
            b[..i].iter_mut().zip(row).for_each(|(b, l)| *b -= scaled * l);
        }
    }

    /// Replaces each of [`LANES`] vectors b, which lie side by side, by L⁻ᵀ b.
    pub fn solve_upper_lanes(&self, b: &mut [[f64; LANES]]) {
        for i in (0..self.n).rev() {
            let (rest, solved) = b.split_at_mut(i);
            let row = self.row(i);
            let solved = &mut solved[0];
            solved.iter_mut().for_each(|b| *b /= row[i]);
            for (l, unsolved) in row.iter().zip(rest) {
                for lane in 0..LANES {
                    unsolved[lane] -= l * solved[lane];
                }
            }
        }
    }

    /// The inverse of the factored matrix: its lower triangle, row-major n × n.
    pub fn inverse(&self) -> Vec<f64> {
        let n = self.n;
        // M = L⁻¹, stored by its columns as contiguous rows: column j of M holds entries j..n.
        let mut columns = vec![0.0; n * n];
        for j in 0..n {
            let column = &mut columns[j * n..(j + 1) * n];
            column[j] = 1.0 / self.rows[j * n + j];
            for i in j + 1..n {
                let row = self.row(i);
                column[i] = -dot(&row[j..i], &column[j..i]) / row[i];
            }
        }
        // A⁻¹ = Mᵀ M, entry (i, j) = Σ_{k ≥ i} M_ki M_kj
        let mut inverse = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                inverse[i * n + j] = dot(&columns[i * n + i..(i + 1) * n], &columns[j * n + i..(j + 1) * n]);
            }
        }
        inverse
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    fn positive_definite(n: usize) -> DMatrix<f64> {
        DMatrix::from_fn(n, n, |i, j| {
            (-0.3 * (i as f64 - j as f64).abs()).exp() + if i == j { 0.1 } else { 0.0 }
        })
    }

    #[test]
    fn agrees_with_nalgebra() {
        for n in [1, 2, 7, 16, 33] {
            let matrix = positive_definite(n);
            let factor = Factor::new(n, matrix.as_slice().to_vec()).unwrap();
            let reference = matrix.clone().cholesky().unwrap();
            assert!((factor.log_determinant() - reference.ln_determinant()).abs() < 1e-10);
            let b = DVector::from_fn(n, |i, _| (i as f64).sin());
            let mut x = b.as_slice().to_vec();
            factor.solve_lower(&mut x);
            let mut lanes: Vec<[f64; LANES]> = b.iter().map(|&b| [b, 0.0, 2.0 * b, b, b, b, b, -b]).collect();
            factor.solve_lower_lanes(&mut lanes);
            assert!(lanes.iter().zip(&x).all(|(l, x)| (l[0] - x).abs() < 1e-12 && (l[7] + x).abs() < 1e-12));
            factor.solve_upper(&mut x);
            factor.solve_upper_lanes(&mut lanes);
            assert!(lanes.iter().zip(&x).all(|(l, x)| (l[0] - x).abs() < 1e-11 && (l[7] + x).abs() < 1e-11));
            assert!((DVector::from_vec(x) - reference.solve(&b)).amax() < 1e-10);
            let (inverse, expected) = (factor.inverse(), reference.inverse());
            for i in 0..n {
                for j in 0..=i {
                    assert!((inverse[i * n + j] - expected[(i, j)]).abs() < 1e-10, "{n} {i} {j}");
                }
            }
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_is_refused_or_jittered() {
        assert!(Factor::new(2, vec![1.0, 0.0, 2.0, 1.0]).is_none());
        assert!(Factor::new(1, vec![f64::NAN]).is_none());
        assert!(Factor::new(2, vec![1.0, 0.0, 1.0, 1.0]).is_none());
        let (_, jitter) = Factor::with_jitter(2, &[1.0, 0.0, 1.0, 1.0], 1.0).unwrap();
        assert_eq!(jitter, 1e-8);
        assert!(Factor::with_jitter(2, &[1.0, 0.0, 9.0, 1.0], 1.0).is_none());
    }
}
