//! Designs in a search space: random, Latin hypercube, scrambled Sobol and grid, each value at its dimension's nearest.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;

use super::random::{Purpose, stream};
use super::space::Space;
use numbers::design;

fn snapped(space: &Space, mut points: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    points.iter_mut().for_each(|point| space.snap(point));
    points
}

/// `count` independent uniform points.
pub(super) fn uniform(space: &Space, count: usize, generator: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    snapped(space, design::uniform(count, space.dimensions().len(), generator))
}

/// The whole random design of a run; its first points do not depend on `count`.
pub(super) fn random(space: &Space, count: usize, seed: u64) -> Vec<Vec<f64>> {
    uniform(space, count, &mut stream(seed, 0, Purpose::Design))
}

/// A Latin hypercube of `count` points.
pub(super) fn latin_hypercube(space: &Space, count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut generator = stream(seed, 0, Purpose::Design);
    snapped(space, design::latin_hypercube(count, space.dimensions().len(), &mut generator))
}

/// The first `count` points of a scrambled Sobol sequence.
pub(super) fn sobol(space: &Space, count: usize, seed: u64) -> Vec<Vec<f64>> {
    let scramble: u32 = stream(seed, 0, Purpose::Design).random();
    let point = |index| design::sobol_point(index, space.dimensions().len(), scramble);
    snapped(space, (0..count).map(point).collect())
}

/// Levels of each dimension of a grid of at most `budget` points (but at least two each, or all of a smaller discrete one).
///
/// Dimensions get the same number of levels as far as their own number of values allows.
pub(super) fn grid_levels(space: &Space, budget: usize) -> Vec<usize> {
    let most: Vec<usize> = space
        .dimensions()
        .iter()
        .map(|d| d.levels().map_or(usize::MAX, |levels| usize::try_from(levels).unwrap_or(usize::MAX)))
        .collect();
    let levels_at = |level: usize| most.iter().map(|&most| level.min(most)).collect::<Vec<_>>();
    let size = |levels: &[usize]| levels.iter().fold(1usize, |size, &l| size.saturating_mul(l));
    let mut level = 2;
    while level < budget && size(&levels_at(level + 1)) <= budget {
        level += 1;
    }
    levels_at(level)
}

/// Point number `index` of the grid with these levels, the last dimension running fastest. Bounds are grid points.
pub(super) fn grid_point(space: &Space, levels: &[usize], index: usize) -> Vec<f64> {
    let mut rest = index;
    let mut point = vec![0.0; levels.len()];
    for (i, dimension) in space.dimensions().iter().enumerate().rev() {
        let (step, last) = (rest % levels[i], levels[i] - 1);
        rest /= levels[i];
        point[i] = dimension.snap(step as f64 / last as f64);
    }
    point
}

#[cfg(test)]
mod tests {
    use super::super::space::SearchDimension;
    use super::*;

    fn plane() -> Space {
        Space::new(vec![SearchDimension::real("x", 0.0, 1.0), SearchDimension::real("y", -1.0, 1.0)]).unwrap()
    }

    #[test]
    fn stratified_designs_put_one_point_in_each_slice() {
        let in_each_slice = |points: &[Vec<f64>]| {
            (0..2).all(|i| {
                let mut slices: Vec<usize> =
                    points.iter().map(|point| (point[i] * points.len() as f64) as usize).collect();
                slices.sort_unstable();
                slices == (0..points.len()).collect::<Vec<_>>()
            })
        };
        assert!(in_each_slice(&latin_hypercube(&plane(), 15, 1)));
        assert!(in_each_slice(&sobol(&plane(), 16, 1)));
        assert!(!in_each_slice(&random(&plane(), 16, 1)));
        assert_ne!(sobol(&plane(), 16, 1), sobol(&plane(), 16, 2));
    }

    #[test]
    fn the_grid_holds_the_corners_and_every_choice() {
        let space = Space::new(vec![
            SearchDimension::real("x", 0.0, 1.0),
            SearchDimension::categorical("kind", ["a", "b", "c"]),
            SearchDimension::integer("n", 1, 9),
        ])
        .unwrap();
        let levels = grid_levels(&space, 60);
        assert_eq!(levels, [4, 3, 4]);
        let mut points: Vec<_> = (0..48).map(|i| grid_point(&space, &levels, i)).collect();
        assert_eq!(space.point(&points[0]), space.point(&[0.0, 0.0, 0.0]));
        assert_eq!(space.point(&points[47]), space.point(&[1.0, 1.0, 1.0]));
        points.dedup();
        assert_eq!(points.len(), 48);
        assert_eq!(grid_levels(&plane(), 1), [2, 2]);
    }
}
