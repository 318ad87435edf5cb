//! Dense lower-triangular algebra for the exact likelihood: the few operations whose speed the cost goals hang on.
//!
//! nalgebra's Cholesky solves against a full identity for an inverse (three times the work) and its general product picks
//! its instructions by processor, so that two machines may differ in the last bit. Everything here is one fixed order of
//! additions, row by row, in contiguous memory.

use super::widest::widest;

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

/// Vectors that are solved for at once.
pub(crate) const LANES: usize = 8;

/// A number of each of [`LANES`] vectors.
pub(crate) type Lanes = [f64; LANES];

/// A lower-triangular matrix L with L Lᵀ = the symmetric positive definite matrix it was made from.
///
/// Triangles are packed: row after row, each up to and including the diagonal. Every entry of L is one sum in the order of its
/// columns, however many rows are made at a time, so that rows added later have the same bits as those made with all others.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Factor {
    n: usize,
    rows: Vec<f64>,
}

/// Where row `i` of a packed triangle begins.
#[inline]
fn start(i: usize) -> usize {
    i * (i + 1) / 2
}

impl Factor {
    /// The Cholesky factor of a symmetric matrix of which the lower triangle is given; `None` when the matrix is not positive
    /// definite to working precision.
    pub fn new(triangle: Vec<f64>) -> Option<Factor> {
        Factor { n: 0, rows: triangle }.finished()
    }

    /// The factor of another matrix, whose first `keep` rows are those of this one's, and whose others follow up to the diagonal.
    /// The same bits as from all of it.
    pub fn grown(&self, keep: usize, others: &[f64]) -> Option<Factor> {
        Factor { n: keep, rows: [&self.rows[..start(keep)], others].concat() }.finished()
    }

    /// Makes all rows those of L.
    fn finished(mut self) -> Option<Factor> {
        // A triangle of n rows holds n (n + 1) / 2 numbers.
        let n = ((2 * self.rows.len()) as f64).sqrt() as usize;
        let mut lanes = vec![[0.0; LANES]; n];
        while self.n < n {
            self.factor_rows(LANES.min(n - self.n), &mut lanes)?;
        }
        Some(self)
    }

    /// Replaces the next `count` rows by those of L.
    fn factor_rows(&mut self, count: usize, lanes: &mut [Lanes]) -> Option<()> {
        let first = self.n;
        let lanes = &mut lanes[..first + count];
        lanes.fill([0.0; LANES]);
        for lane in 0..count {
            let row = &self.rows[start(first + lane)..start(first + lane + 1)];
            lanes.iter_mut().zip(row).for_each(|(lanes, entry)| lanes[lane] = *entry);
        }
        self.solve_lower_lanes(0, &mut lanes[..first]);
        if !factor_among(first, lanes) {
            return None;
        }
        for lane in 0..count {
            let row = &mut self.rows[start(first + lane)..start(first + lane + 1)];
            lanes.iter().zip(row).for_each(|(lanes, entry)| *entry = lanes[lane]);
        }
        self.n += count;
        Some(())
    }

    /// Like [`Factor::new`], adding ever more to the diagonal, from `scale` × 1e-8 to `scale` × 1e-2, until it succeeds.
    /// Returns what was added, too.
    pub fn with_jitter(triangle: &[f64], scale: f64) -> Option<(Factor, f64)> {
        let ladder = [0.0, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2];
        ladder.iter().find_map(|step| {
            let mut triangle = triangle.to_vec();
            let mut row = 0;
            while start(row) < triangle.len() {
                row += 1;
                triangle[start(row) - 1] += step * scale;
            }
            Some((Factor::new(triangle)?, step * scale))
        })
    }

    /// Row `i` up to and including the diagonal.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.rows[start(i)..start(i + 1)]
    }

    /// ln det of the factored matrix.
    pub fn log_determinant(&self) -> f64 {
        2.0 * (0..self.n).map(|i| libm::log(self.row(i)[i])).sum::<f64>()
    }

    /// Replaces b by L⁻¹ b.
    pub fn solve_lower(&self, b: &mut [f64]) {
        for i in 0..b.len() {
            b[i] = self.solved(i, b[i], &b[..i]);
        }
    }

    /// Entry `i` of L⁻¹ b from that of b and the entries of L⁻¹ b before it.
    pub fn solved(&self, i: usize, b: f64, before: &[f64]) -> f64 {
        let row = self.row(i);
        (b - dot(&row[..i], before)) / row[i]
    }

    /// Replaces each of [`LANES`] vectors b, which lie side by side, by L⁻¹ b. They begin at row `first`, before which they are
    /// zero, and may be shorter than L.
    pub fn solve_lower_lanes(&self, first: usize, b: &mut [Lanes]) {
        solve_lower_lanes(&self.rows, first, b);
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

    /// The lower triangle of the inverse of the factored matrix.
    pub fn inverse(&self) -> Vec<f64> {
        let n = self.n;
        let mut inverse = vec![0.0; self.rows.len()];
        // Columns of L⁻¹, each block from its first row on: above it they are zero.
        let columns: Vec<Vec<Lanes>> = (0..n)
            .step_by(LANES)
            .map(|first| self.columns_of_inverse(&(first..n.min(first + LANES)).collect::<Vec<_>>()))
            .collect();
        // A⁻¹ = L⁻ᵀ L⁻¹: entry (i, j) is the sum of the products of columns i and j.
        for (block, left) in columns.iter().enumerate() {
            for (other, right) in columns[..=block].iter().enumerate() {
                let count = LANES.min(n - block * LANES);
                let products = products(left, count, &right[(block - other) * LANES..]);
                for (lane, sums) in products[..count].iter().enumerate() {
                    let (i, j) = (block * LANES + lane, other * LANES);
                    let count = LANES.min(i + 1 - j);
                    inverse[start(i) + j..][..count].copy_from_slice(&sums[..count]);
                }
            }
        }
        inverse
    }

    /// Up to [`LANES`] columns of L⁻¹ in ascending order, from the row on whose number is that of the first.
    pub fn columns_of_inverse(&self, columns: &[usize]) -> Vec<Lanes> {
        let first = columns[0];
        let mut lanes = vec![[0.0; LANES]; self.n - first];
        columns.iter().enumerate().for_each(|(lane, column)| lanes[column - first][lane] = 1.0);
        self.solve_lower_lanes(first, &mut lanes);
        lanes
    }
}

widest! {
    fn solve_lower_lanes(rows: &[f64], first: usize, b: &mut [Lanes]) {
        for i in 0..b.len() {
            let (solved, rest) = b.split_at_mut(i);
            let row = &rows[start(first + i)..start(first + i + 1)][first..];
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
}

widest! {
    /// Makes the rows of L from `first` on, side by side, from their entries before, which are made, and the rest of the matrix.
    fn factor_among(first: usize, lanes: &mut [Lanes]) -> bool {
        for j in 0..lanes.len() - first {
            let (known, rest) = lanes.split_at_mut(first + j);
            let mut sums = [0.0; LANES];
            for solved in known.iter() {
                let own = solved[j];
                for lane in 0..LANES {
                    sums[lane] += own * solved[lane];
                }
            }
            let column = &mut rest[0];
            let pivot = column[j] - sums[j];
            if !(pivot > 0.0 && pivot.is_finite()) {
                return false;
            }
            let root = pivot.sqrt();
            column[j] = root;
            for lane in j + 1..LANES {
                column[lane] = (column[lane] - sums[lane]) / root;
            }
        }
        true
    }
}

widest! {
    /// The sums of the products of each of the first `count` vectors that lie side by side with each of the others.
    pub(super) fn products(some: &[Lanes], count: usize, others: &[Lanes]) -> [Lanes; LANES] {
        let mut all = [[0.0; LANES]; LANES];
        for (lane, all) in all[..count].iter_mut().enumerate() {
            let mut sums = [0.0; LANES];
            for (some, others) in some.iter().zip(others) {
                let factor = some[lane];
                for other in 0..LANES {
                    sums[other] += factor * others[other];
                }
            }
            *all = sums;
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    use super::*;

    fn positive_definite(n: usize) -> DMatrix<f64> {
        DMatrix::from_fn(n, n, |i, j| {
            (-0.3 * (i as f64 - j as f64).abs()).exp() + if i == j { 0.1 } else { 0.0 }
        })
    }

    fn triangle(matrix: &DMatrix<f64>) -> Vec<f64> {
        (0..matrix.nrows()).flat_map(|i| (0..=i).map(move |j| matrix[(i, j)])).collect()
    }

    #[test]
    fn agrees_with_nalgebra() {
        for n in [1, 2, 7, 8, 9, 16, 33] {
            let matrix = positive_definite(n);
            let factor = Factor::new(triangle(&matrix)).unwrap();
            let reference = matrix.clone().cholesky().unwrap();
            assert!((factor.log_determinant() - reference.ln_determinant()).abs() < 1e-10);
            for i in 0..n {
                for (j, entry) in factor.row(i).iter().enumerate() {
                    assert!((entry - reference.l()[(i, j)]).abs() < 1e-12, "{n} {i} {j}");
                }
            }
            let b = DVector::from_fn(n, |i, _| (i as f64).sin());
            let mut x = b.as_slice().to_vec();
            factor.solve_lower(&mut x);
            let mut lanes: Vec<Lanes> = b.iter().map(|&b| [b, 0.0, 2.0 * b, b, b, b, b, -b]).collect();
            factor.solve_lower_lanes(0, &mut lanes);
            assert!(lanes.iter().zip(&x).all(|(l, x)| (l[0] - x).abs() < 1e-12 && (l[7] + x).abs() < 1e-12));
            factor.solve_upper(&mut x);
            assert!((DVector::from_vec(x) - reference.solve(&b)).amax() < 1e-10);
            let (inverse, expected) = (factor.inverse(), reference.inverse());
            for i in 0..n {
                for j in 0..=i {
                    assert!((inverse[start(i) + j] - expected[(i, j)]).abs() < 1e-10, "{n} {i} {j}");
                }
            }
            let columns = factor.columns_of_inverse(&(n / 2..n.min(n / 2 + LANES)).collect::<Vec<_>>());
            let l_inverse = reference.l().try_inverse().unwrap();
            for (i, lanes) in columns.iter().enumerate() {
                for lane in 0..LANES.min(n - n / 2) {
                    assert!((lanes[lane] - l_inverse[(n / 2 + i, n / 2 + lane)]).abs() < 1e-10);
                }
            }
        }
    }

    proptest! {
        #[test]
        fn rows_added_later_have_the_same_bits(
            n in 1..40_usize, seed in 0..u64::MAX, length in 0.01..3.0f64, noise in 1e-9..0.5f64,
        ) {
            // Points on a line, some of them as good as equal.
            let mut stream = numbers::random::Stream::numbered(seed, 0);
            let points: Vec<f64> = (0..n)
                .map(|i| if i % 5 == 4 { 0.5 + 1e-9 * i as f64 } else { stream.uniform() })
                .collect();
            let matrix = DMatrix::from_fn(n, n, |i, j| {
                (-(points[i] - points[j]).abs() / length).exp() + if i == j { noise } else { 0.0 }
            });
            let whole = Factor::new(triangle(&matrix));
            let mut grown = Factor::new(Vec::new());
            for i in 0..n {
                let row: Vec<f64> = (0..=i).map(|j| matrix[(i, j)]).collect();
                grown = grown.and_then(|factor| factor.grown(i, &row));
            }
            prop_assert_eq!(&whole, &grown);
            if let Some(factor) = &whole {
                let keep = n / 3;
                let again = factor.grown(keep, &triangle(&matrix)[start(keep)..]);
                prop_assert_eq!(again.as_ref(), Some(factor));
            }
            // A second derivation of what the rows are of.
            if let Some(factor) = whole {
                for i in 0..n {
                    for j in 0..=i {
                        let back: f64 = (0..=j).map(|k| factor.row(i)[k] * factor.row(j)[k]).sum();
                        prop_assert!((back - matrix[(i, j)]).abs() < 1e-13 * (1.0 + noise), "{} {}", i, j);
                    }
                }
            }
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_is_refused_or_jittered() {
        assert!(Factor::new(vec![1.0, 2.0, 1.0]).is_none());
        assert!(Factor::new(vec![f64::NAN]).is_none());
        let singular = [1.0, 1.0, 1.0];
        assert!(Factor::new(singular.to_vec()).is_none());
        assert!(Factor::new(vec![1.0]).unwrap().grown(1, &[1.0, 1.0]).is_none());
        let (_, jitter) = Factor::with_jitter(&singular, 1.0).unwrap();
        assert_eq!(jitter, 1e-8);
        assert!(Factor::with_jitter(&[1.0, 9.0, 1.0], 1.0).is_none());
    }
}
