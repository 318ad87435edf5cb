//! Finding the best point of an acquisition function: many candidates first, then a pattern search from the best few.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;

use super::design::{grid_point, uniform};
use super::space::Space;

/// A space of so few points is searched completely.
const ENUMERATION_LIMIT: u64 = 1024;
/// Candidates on a line.
const LINE_CANDIDATES: usize = 512;
/// Uniform candidates in more dimensions.
const UNIFORM_CANDIDATES: usize = 800;
/// Candidates around each anchor.
const PERTURBATIONS: usize = 60;
/// Places the pattern search starts from.
const STARTS: usize = 4;
/// Halvings of the pattern search's step.
const ROUNDS: usize = 12;

/// The point of highest score found and that score. `anchors` are places worth looking around, best first.
///
/// `score` is called with many points at a time; a score that is NaN loses.
pub(super) fn maximise(
    space: &Space,
    anchors: &[Vec<f64>],
    generator: &mut ChaCha8Rng,
    score: impl Fn(&[Vec<f64>]) -> Vec<f64>,
) -> (Vec<f64>, f64) {
    let enumerable = space.size().filter(|&size| size <= ENUMERATION_LIMIT);
    let candidates = match enumerable {
        Some(size) => every_point(space, size as usize),
        None if space.dimensions().len() == 1 => line(space, generator),
        None => cloud(space, anchors, generator),
    };
    let scores = score(&candidates);
    let Some(best) = highest(&scores, |_| true) else {
        return (candidates[0].clone(), f64::NEG_INFINITY);
    };
    if enumerable.is_some() {
        return (candidates[best].clone(), scores[best]);
    }
    // Starts apart from each other, so that they do not all climb the same hill.
    let step = if space.dimensions().len() == 1 { 1.0 / LINE_CANDIDATES as f64 } else { 0.1 };
    let mut starts = vec![(candidates[best].clone(), scores[best])];
    while starts.len() < STARTS {
        let is_apart = |i: usize| {
            let differ =
                |place: &[f64]| candidates[i].iter().zip(place).any(|(a, b)| (a - b).abs() > 1.5 * step);
            starts.iter().all(|(place, _)| differ(place))
        };
        let Some(next) = highest(&scores, is_apart) else { break };
        starts.push((candidates[next].clone(), scores[next]));
    }
    pattern_search(space, &mut starts, step, score);
    let better = |a: &(Vec<f64>, f64), b: &(Vec<f64>, f64)| b.1 > a.1;
    starts.into_iter().reduce(|a, b| if better(&a, &b) { b } else { a }).expect("there is a start")
}

/// The first of the highest scores that are numbers and of which this holds.
fn highest(scores: &[f64], holds: impl Fn(usize) -> bool) -> Option<usize> {
    let mut best: Option<usize> = None;
    for (i, score) in scores.iter().enumerate() {
        let is_higher = best.is_none_or(|best| *score > scores[best]);
        if is_higher && !score.is_nan() && holds(i) {
            best = Some(i);
        }
    }
    best
}

fn every_point(space: &Space, size: usize) -> Vec<Vec<f64>> {
    let levels: Vec<usize> = space.dimensions().iter().map(|d| d.levels().unwrap_or(1) as usize).collect();
    (0..size).map(|index| grid_point(space, &levels, index)).collect()
}

fn line(space: &Space, generator: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let offset = generator.random::<f64>();
    let inner = (0..LINE_CANDIDATES).map(|i| (i as f64 + offset) / LINE_CANDIDATES as f64);
    [0.0, 1.0].into_iter().chain(inner).map(|unit| vec![space.dimensions()[0].snap(unit)]).collect()
}

fn cloud(space: &Space, anchors: &[Vec<f64>], generator: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let mut candidates = uniform(space, UNIFORM_CANDIDATES, generator);
    for anchor in anchors.iter().take(STARTS) {
        for i in 0..PERTURBATIONS {
            // Radii from a tenth of the range down to a thousandth, one coordinate in two moved.
            let radius = 0.1 * libm::exp(-4.6 * i as f64 / PERTURBATIONS as f64);
            let mut candidate = anchor.clone();
            for (coordinate, dimension) in candidate.iter_mut().zip(space.dimensions()) {
                let (moved, shift) = (generator.random::<bool>(), generator.random_range(-1.0..=1.0));
                if moved && dimension.is_categorical() {
                    *coordinate = generator.random::<f64>();
                } else if moved {
                    *coordinate += radius * shift;
                }
            }
            space.snap(&mut candidate);
            candidates.push(candidate);
        }
    }
    candidates
}

/// Compass search from all starts at once; the step halves where no neighbour is better.
fn pattern_search(
    space: &Space,
    places: &mut [(Vec<f64>, f64)],
    step: f64,
    score: impl Fn(&[Vec<f64>]) -> Vec<f64>,
) {
    let mut steps = vec![0.5 * step; places.len()];
    for _ in 0..ROUNDS {
        let mut neighbours = Vec::new();
        let mut owners = Vec::new();
        for (owner, (place, _)) in places.iter().enumerate() {
            for (i, dimension) in space.dimensions().iter().enumerate() {
                // A discrete dimension moves by at least one value.
                let stride =
                    dimension.levels().map_or(steps[owner], |levels| steps[owner].max(1.0 / levels as f64));
                for sign in [-1.0, 1.0] {
                    let mut neighbour = place.clone();
                    neighbour[i] = dimension.snap(neighbour[i] + sign * stride);
                    if neighbour[i] != place[i] {
                        neighbours.push(neighbour);
                        owners.push(owner);
                    }
                }
            }
        }
        let scores = score(&neighbours);
        let mut moved = vec![false; places.len()];
        for ((neighbour, owner), score) in neighbours.into_iter().zip(owners).zip(scores) {
            if score > places[owner].1 {
                places[owner] = (neighbour, score);
                moved[owner] = true;
            }
        }
        for (step, moved) in steps.iter_mut().zip(moved) {
            if !moved {
                *step *= 0.4;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::{Purpose, stream};
    use super::super::space::SearchDimension;
    use super::*;

    fn found(space: &Space, score: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        let anchors = [vec![0.5; space.dimensions().len()]];
        let mut generator = stream(5, 0, Purpose::Candidates);
        maximise(space, &anchors, &mut generator, |points| points.iter().map(|p| score(p)).collect()).0
    }

    #[test]
    fn the_highest_is_the_first_of_equal_ones_and_a_number() {
        let scores = [f64::NAN, f64::NEG_INFINITY, 2.0, f64::NAN, 3.0, 3.0];
        assert_eq!(highest(&scores, |_| true), Some(4));
        assert_eq!(highest(&scores, |i| i < 4), Some(2));
        assert_eq!(highest(&scores, |i| i == 1), Some(1));
        assert_eq!(highest(&scores, |i| i == 3), None);
    }

    #[test]
    fn finds_narrow_peaks_on_a_line_and_corners() {
        let line = Space::new(vec![SearchDimension::real("x", 6.0, 18.0)]).unwrap();
        let peak = found(&line, |p| -(p[0] - 0.123_456).abs());
        assert!((peak[0] - 0.123_456).abs() < 1e-4, "{peak:?}");
        assert_eq!(found(&line, |p| p[0]), [1.0]);
        assert_eq!(found(&line, |_| f64::NAN).len(), 1);
    }

    #[test]
    fn finds_the_peak_in_six_dimensions_and_over_mixed_ones() {
        let six =
            Space::new((0..6).map(|i| SearchDimension::real(&i.to_string(), 0.0, 1.0)).collect()).unwrap();
        let peak = found(&six, |p| -p.iter().map(|x| (x - 0.3).powi(2)).sum::<f64>());
        assert!(peak.iter().all(|x| (x - 0.3).abs() < 0.1), "{peak:?}");
        let mixed = Space::new(vec![
            SearchDimension::real("x", 0.0, 1.0),
            SearchDimension::integer("n", 0, 9),
            SearchDimension::categorical("kind", ["a", "b", "c"]),
        ])
        .unwrap();
        let peak = found(&mixed, |p| -(p[0] - 0.7).powi(2) - (p[1] - 0.35).abs() - (p[2] - 0.5).abs());
        assert_eq!(mixed.point(&peak)[1..], mixed.point(&[0.7, 0.35, 0.5])[1..]);
    }

    #[test]
    fn a_small_discrete_space_is_searched_completely() {
        let space =
            Space::new(vec![SearchDimension::integer("n", 0, 9), SearchDimension::integer("m", 0, 9)])
                .unwrap();
        let target = space.unit(&space.point(&[0.75, 0.25])).unwrap();
        assert_eq!(found(&space, |p| if p == target { 1.0 } else { 0.0 }), target);
    }
}
