//! Designs: points that fill the open unit cube, at random, in a Latin hypercube or along a scrambled Sobol sequence.
//!
//! A design is part of what a seed means, so each is generic over [how its numbers are drawn](Draws).

use super::random::Draws;

/// Points of a Sobol sequence that keep its balance: the generator's own limit.
const SOBOL_POINTS: usize = 1 << 16;
const SOBOL_DIMENSIONS: usize = sobol_burley::NUM_DIMENSIONS as usize;
/// Width of the cells that points of a Sobol sequence are told apart by.
pub const SOBOL_CELL: f64 = 1.0 / (1 << 24) as f64;

/// `count` independent uniform points; a smaller design is the beginning of a larger one.
pub fn uniform(count: usize, dimensions: usize, draws: &mut impl Draws) -> Vec<Vec<f64>> {
    (0..count).map(|_| (0..dimensions).map(|_| draws.uniform()).collect()).collect()
}

/// One dimension of a Latin hypercube: equal slices in random order, each of which holds one point.
#[derive(Debug, Clone)]
pub struct Slices(Vec<usize>);

impl Slices {
    /// As many as there are points.
    pub fn drawn(count: usize, draws: &mut impl Draws) -> Self {
        Self(draws.shuffled(count))
    }

    /// Where point `index` lies: anywhere in its slice.
    pub fn place(&self, index: usize, draws: &mut impl Draws) -> f64 {
        (self.0[index] as f64 + draws.uniform()) / self.0.len() as f64
    }
}

/// A Latin hypercube: each of `count` equal slices of each dimension holds one point.
///
/// Source: M. D. McKay, R. J. Beckman & W. J. Conover, Technometrics 21, 1979.
pub fn latin_hypercube(count: usize, dimensions: usize, draws: &mut impl Draws) -> Vec<Vec<f64>> {
    let mut points = vec![vec![0.0; dimensions]; count];
    for dimension in 0..dimensions {
        let slices = Slices::drawn(count, draws);
        for (index, point) in points.iter_mut().enumerate() {
            point[dimension] = slices.place(index, draws);
        }
    }
    points
}

/// Point `index` of a Sobol sequence with Owen scrambling: the low corner of its [cell](SOBOL_CELL). Sequences of other
/// scrambles are independent of each other. Past 2^16 points a sequence starts anew with another scramble, and so do its
/// dimensions past 256.
///
/// Source: B. Burley, J. Comput. Graph. Tech. 9(4), 2020.
pub fn sobol_point(index: usize, dimensions: usize, scramble: u32) -> Vec<f64> {
    let scramble = scramble.wrapping_add((index / SOBOL_POINTS) as u32);
    let coordinate = |dimension: usize| {
        let further = ((dimension / SOBOL_DIMENSIONS) as u32).wrapping_mul(0x9e37_79b9);
        let (index, dimension) = (index % SOBOL_POINTS, dimension % SOBOL_DIMENSIONS);
        f64::from(sobol_burley::sample(index as u32, dimension as u32, scramble ^ further))
    };
    (0..dimensions).map(coordinate).collect()
}

#[cfg(test)]
mod tests {
    use super::super::random::{Stream, generator};
    use super::*;

    /// Whether each of as many equal slices of each dimension as there are points holds one of them.
    fn in_each_slice(points: &[Vec<f64>]) -> bool {
        (0..points[0].len()).all(|dimension| {
            let slice = |point: &Vec<f64>| (point[dimension] * points.len() as f64) as usize;
            let mut slices: Vec<usize> = points.iter().map(slice).collect();
            slices.sort_unstable();
            slices == (0..points.len()).collect::<Vec<_>>()
        })
    }

    fn sobol(count: usize, dimensions: usize, scramble: u32) -> Vec<Vec<f64>> {
        (0..count).map(|index| sobol_point(index, dimensions, scramble)).collect()
    }

    #[test]
    fn stratified_designs_put_one_point_in_each_slice() {
        assert!(in_each_slice(&latin_hypercube(15, 3, &mut Stream::seeded(1))));
        assert!(in_each_slice(&latin_hypercube(15, 3, &mut generator(1, 0))));
        assert!(in_each_slice(&sobol(64, 5, 9)));
        assert!(!in_each_slice(&uniform(64, 2, &mut Stream::seeded(1))));
        assert_ne!(sobol(16, 2, 1), sobol(16, 2, 2));
    }

    #[test]
    fn points_of_a_hypercube_are_anywhere_in_their_slices_and_in_any_order() {
        // Of two points in two dimensions: which diagonal is as likely as the other, and where in the slice is uniform.
        let mut stream = Stream::seeded(8);
        let (mut rising, mut sum) = (0, 0.0);
        for _ in 0..4000 {
            let points = latin_hypercube(2, 2, &mut stream);
            rising += i32::from((points[0][0] < 0.5) == (points[0][1] < 0.5));
            sum += points.iter().flatten().map(|x| (2.0 * x).fract()).sum::<f64>();
        }
        // Standard deviations of 32 and of 0.0023.
        assert!((1850..2150).contains(&rising), "{rising}");
        assert!((sum / 16_000.0 - 0.5).abs() < 0.012, "{sum}");
    }

    #[test]
    fn every_elementary_interval_of_a_sobol_sequence_holds_one_point() {
        // A (0, m, 2)-net: of 2^6 points every rectangle of sides 2^-k and 2^-(6-k) holds one.
        let points = sobol(64, 2, 77);
        for wide in 0..=6 {
            let (across, up) = (f64::from(1 << wide), f64::from(1 << (6 - wide)));
            let mut cells: Vec<_> =
                points.iter().map(|point| ((point[0] * across) as u32, (point[1] * up) as u32)).collect();
            cells.sort_unstable();
            cells.dedup();
            assert_eq!(cells.len(), 64, "{wide}");
        }
    }

    #[test]
    fn cells_of_a_sobol_sequence_end_below_1() {
        let points = sobol(4096, 2, 5);
        assert!(points.iter().flatten().all(|x| *x >= 0.0 && x + SOBOL_CELL <= 1.0));
        // In whole cells.
        assert!(points.iter().flatten().all(|x| (x / SOBOL_CELL).fract() == 0.0));
    }

    #[test]
    fn a_sequence_goes_on_past_its_limit() {
        let (first, again) = (sobol_point(0, 2, 3), sobol_point(SOBOL_POINTS, 2, 3));
        assert_ne!(first, again);
        assert_eq!(again, sobol_point(0, 2, 4));
        let wide = sobol(32, 600, 3);
        assert!(in_each_slice(&wide));
        assert!(wide.iter().all(|point| point[0] != point[256] && point[1] != point[513]));
    }
}
