//! A density over weighted points by kernels, and how much of the population is less dense.

use crate::inference::effective_size;

/// A density over weighted points: a normal kernel on each, of the shape of their covariance and as wide as is best for normal points
/// (Silverman 1986, §4.3.2, with the effective size for the number of points). Points that differ in nothing are one.
#[derive(Debug, Clone)]
pub struct KernelDensity {
    /// In directions in which the covariance is that of the kernel, one point after the other.
    places: Vec<f64>,
    weights: Vec<f64>,
    /// Lower triangle of Cholesky's decomposition of the kernel's covariance.
    scale: Vec<Vec<f64>>,
    centre: Vec<f64>,
    /// Densities of the points, each without itself, rising, with the weight up to each.
    tail: Vec<(f64, f64)>,
}

/// A direction of less of the variance of its column than this is none.
const FLAT: f64 = 1e-10;
/// In which two places are the same.
const SAME: f64 = 1e-9;

impl KernelDensity {
    /// Over `points`, each of a weight of at least 0. `None` where they lie on a line, a plane or the like, or in one place, and have no
    /// density.
    ///
    /// # Panics
    /// If points differ in their number of coordinates, or in number from weights.
    pub fn new(points: &[Vec<f64>], weights: &[f64]) -> Option<Self> {
        assert_eq!(points.len(), weights.len(), "a weight for each point");
        let mut members: Vec<(&Vec<f64>, f64)> =
            points.iter().zip(weights.iter().copied()).filter(|(_, weight)| *weight > 0.0).collect();
        let by_place = |one: &Vec<f64>, other: &Vec<f64>| {
            one.iter().zip(other).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne())
        };
        members.sort_by(|one, other| by_place(one.0, other.0).unwrap_or(std::cmp::Ordering::Equal));
        // Who differ in nothing are one, so that it does not matter how a population is written down.
        members.dedup_by(|later, kept| {
            let same = by_place(later.0, kept.0).is_none();
            kept.1 += if same { later.1 } else { 0.0 };
            same
        });
        let count = members.first()?.0.len();
        let sum: f64 = members.iter().map(|(_, weight)| weight).sum();
        let weights: Vec<f64> = members.iter().map(|(_, weight)| weight / sum).collect();
        let mut centre = vec![0.0; count];
        for ((point, _), weight) in members.iter().zip(&weights) {
            assert_eq!(point.len(), count, "points have the same coordinates");
            centre.iter_mut().zip(*point).for_each(|(mean, value)| *mean += weight * value);
        }
        let mut covariance = vec![vec![0.0; count]; count];
        for ((point, _), weight) in members.iter().zip(&weights) {
            for row in 0..count {
                for column in 0..=row {
                    covariance[row][column] +=
                        weight * (point[row] - centre[row]) * (point[column] - centre[column]);
                }
            }
        }
        let dimensions = count as f64;
        let width =
            libm::pow(4.0 / ((dimensions + 2.0) * effective_size(&weights)), 1.0 / (dimensions + 4.0));
        let mut scale = decomposed(covariance)?;
        scale.iter_mut().flatten().for_each(|one| *one *= width);
        let mut density = Self { places: Vec::new(), weights, scale, centre, tail: Vec::new() };
        density.places = members.iter().flat_map(|(point, _)| density.place(point)).collect();
        let each = density.places.chunks_exact(count).zip(&density.weights);
        let mut tail: Vec<(f64, f64)> =
            each.map(|(place, weight)| (density.without_itself(place), *weight)).collect();
        tail.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mut sum = 0.0;
        for (_, weight) in &mut tail {
            sum += *weight;
            *weight = sum;
        }
        Some(Self { tail, ..density })
    }

    /// The share of the population, by weight, that is where it is no denser than at `point`: 0 where nobody is, and as often below any
    /// share as that says for others of the same population. Whoever is a member is not counted where they stand, as the members are
    /// that they are held against.
    ///
    /// # Panics
    /// For a point of another number of coordinates.
    pub fn tail(&self, point: &[f64]) -> f64 {
        assert_eq!(point.len(), self.centre.len(), "points have the same coordinates");
        let found = self.without_itself(&self.place(point));
        // A member's own density comes to the same with the same places, but the place of a point of the same numbers is the same, too.
        let up_to = self.tail.partition_point(|(density, _)| *density <= found);
        if up_to == 0 { 0.0 } else { self.tail[up_to - 1].1.min(1.0) }
    }

    /// In directions in which the kernel is round and of width 1.
    fn place(&self, point: &[f64]) -> Vec<f64> {
        let mut place = vec![0.0; point.len()];
        for row in 0..point.len() {
            let known: f64 = (0..row).map(|at| self.scale[row][at] * place[at]).sum();
            place[row] = (point[row] - self.centre[row] - known) / self.scale[row][row];
        }
        place
    }

    /// Up to a factor that is the same everywhere; of a member, over the others.
    fn without_itself(&self, place: &[f64]) -> f64 {
        let (mut sum, mut own) = (0.0, 0.0);
        for (other, weight) in self.places.chunks_exact(place.len()).zip(&self.weights) {
            let apart: f64 = place.iter().zip(other).map(|(one, other)| (one - other) * (one - other)).sum();
            if apart <= SAME * SAME {
                own += weight;
            } else {
                sum += weight * libm::exp(-0.5 * apart);
            }
        }
        if own >= 1.0 { 0.0 } else { sum / (1.0 - own) }
    }
}

/// The lower triangle of Cholesky's decomposition of a symmetric matrix, of which the lower half is given; `None` where it is flat.
fn decomposed(mut matrix: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    for row in 0..matrix.len() {
        let variance = matrix[row][row];
        for column in 0..=row {
            let known: f64 = (0..column).map(|at| matrix[row][at] * matrix[column][at]).sum();
            let rest = matrix[row][column] - known;
            if row == column {
                if rest <= FLAT * variance || rest <= 0.0 {
                    return None;
                }
                matrix[row][column] = libm::sqrt(rest);
            } else {
                matrix[row][column] = rest / matrix[column][column];
            }
        }
    }
    Some(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    fn people(seed: u64, number: usize) -> Vec<Vec<f64>> {
        let mut stream = Stream::seeded(seed);
        let mut one = || {
            let (a, b) = (stream.normal(), stream.normal());
            vec![5.0 + a, -2.0 + 0.1 * (0.6 * a + 0.8 * b)]
        };
        (0..number).map(|_| one()).collect()
    }

    fn equal(number: usize) -> Vec<f64> {
        vec![1.0; number]
    }

    #[test]
    fn others_of_the_same_population_are_as_often_below_any_share_as_it_says() {
        let density = KernelDensity::new(&people(1, 1500), &equal(1500)).unwrap();
        let others: Vec<f64> = people(2, 1500).iter().map(|one| density.tail(one)).collect();
        for share in [0.02, 0.1, 0.5, 0.9] {
            let below = others.iter().filter(|tail| **tail <= share).count() as f64 / 1500.0;
            assert!((below - share).abs() < 0.04, "{below} of others are below {share}");
        }
    }

    #[test]
    fn it_is_what_the_normal_distribution_says() {
        let density = KernelDensity::new(&people(3, 3000), &equal(3000)).unwrap();
        // Of two dimensions, the share at least so many deviations out.
        for deviations in [0.5, 1.0, 1.5, 2.0f64] {
            let expected = (-0.5 * deviations * deviations).exp();
            let around = (0..24).map(|step| {
                let (sine, cosine) = (f64::from(step) * std::f64::consts::TAU / 24.0).sin_cos();
                let (a, b) = (deviations * cosine, deviations * sine);
                density.tail(&[5.0 + a, -2.0 + 0.1 * (0.6 * a + 0.8 * b)])
            });
            let found = around.sum::<f64>() / 24.0;
            assert!((found - expected).abs() < 0.03, "{found} at {deviations} where {expected} is expected");
        }
        assert_eq!(density.tail(&[50.0, 7.0]), 0.0);
    }

    #[test]
    fn order_units_and_how_members_are_written_down_do_not_matter() {
        let members = people(4, 200);
        let weights: Vec<f64> = (0..200).map(|index| 1.0 + f64::from(index % 3)).collect();
        let usual = KernelDensity::new(&members, &weights).unwrap();
        let turned: Vec<Vec<f64>> =
            members.iter().rev().map(|one| vec![1000.0 * one[1] + 3.0, one[0]]).collect();
        let back: Vec<f64> = weights.iter().rev().copied().collect();
        let turned = KernelDensity::new(&turned, &back).unwrap();
        let twice: Vec<Vec<f64>> = members.iter().chain(&members).cloned().collect();
        let halves: Vec<f64> = weights.iter().chain(&weights).map(|one| one / 2.0).collect();
        let twice = KernelDensity::new(&twice, &halves).unwrap();
        let with_nobody: Vec<Vec<f64>> = members.iter().cloned().chain([vec![500.0, 500.0]]).collect();
        let none: Vec<f64> = weights.iter().copied().chain([0.0]).collect();
        let with_nobody = KernelDensity::new(&with_nobody, &none).unwrap();
        for one in members.iter().chain(&people(5, 50)) {
            let tail = usual.tail(one);
            for other in
                [turned.tail(&[1000.0 * one[1] + 3.0, one[0]]), twice.tail(one), with_nobody.tail(one)]
            {
                assert!((tail - other).abs() < 0.011, "{tail} and {other}");
            }
        }
    }

    #[test]
    fn who_lie_on_a_line_have_no_density() {
        assert!(KernelDensity::new(&[vec![1.0, 2.0], vec![2.0, 4.0], vec![3.0, 6.0]], &equal(3)).is_none());
        assert!(KernelDensity::new(&[vec![1.0], vec![1.0]], &equal(2)).is_none());
        assert!(KernelDensity::new(&[], &[]).is_none());
        // A single member of all the weight is nobody's neighbour.
        let alone = KernelDensity::new(&[vec![1.0], vec![2.0]], &[1.0, 0.0]);
        assert!(alone.is_none());
    }
}
