//! How a vehicle's lane bends ahead of it, as whoever drives it is told.

use scenario::agent::CURVATURE_REACH;

/// Rounding makes no change of curvature, 1/m.
const SAME: f64 = 1e-12;

/// The places (m) at which the curvature that a vehicle follows changes, and what it is there (1/m).
#[derive(Debug)]
pub(super) struct CurvatureChanges(Vec<(f64, f64)>);

impl CurvatureChanges {
    /// As [`scenario::Path::curvature_changes`] has them.
    pub fn new(changes: Vec<(f64, f64)>) -> Self {
        Self(changes)
    }

    /// The most that is told of them at once.
    pub fn most(&self) -> usize {
        self.0.len() + 1
    }

    /// Those ahead of a place (m) at which the curvature is `now` (1/m), by how far ahead they are, and what it comes to at the end.
    pub fn tell(&self, place: f64, now: f64, into: &mut Vec<(f64, f64)>) {
        into.clear();
        let end = place + CURVATURE_REACH;
        let ahead =
            self.0.partition_point(|(at, _)| *at < place)..self.0.partition_point(|(at, _)| *at <= end);
        into.extend(self.0[ahead].iter().map(|(at, curvature)| (at - place, *curvature)));
        let (last, at_end) = (into.last().map_or(now, |(_, curvature)| *curvature), self.at(end));
        if (at_end - last).abs() > SAME {
            into.push((CURVATURE_REACH, at_end));
        }
    }

    /// The curvature (1/m) at a place (m); where it jumps, that behind it.
    fn at(&self, place: f64) -> f64 {
        let next = self.0.partition_point(|(at, _)| *at <= place);
        let (Some(before), Some(after)) = (next.checked_sub(1).map(|last| self.0[last]), self.0.get(next))
        else {
            return 0.0;
        };
        before.1 + (after.1 - before.1) * (place - before.0) / (after.0 - before.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(changes: &[(f64, f64)], place: f64, now: f64) -> Vec<(f64, f64)> {
        let mut into = vec![(1.0, 1.0)];
        CurvatureChanges::new(changes.to_vec()).tell(place, now, &mut into);
        into
    }

    #[test]
    fn what_is_ahead_is_told_and_what_it_comes_to() {
        // A clothoid of 20 m, an arc, and straight on at once.
        let bend = [(100.0, 0.0), (120.0, 0.02), (300.0, 0.02), (300.0, 0.0)];
        assert_eq!(told(&bend, -60.0, 0.0), []);
        assert_eq!(told(&bend, -50.0, 0.0), [(150.0, 0.0)]);
        assert_eq!(told(&bend, -40.0, 0.0), [(140.0, 0.0), (150.0, 0.01)]);
        assert_eq!(told(&bend, 0.0, 0.0), [(100.0, 0.0), (120.0, 0.02)]);
        assert_eq!(told(&bend, 105.0, 0.005), [(15.0, 0.02)]);
        assert_eq!(told(&bend, 130.0, 0.02), []);
        assert_eq!(told(&bend, 200.0, 0.02), [(100.0, 0.02), (100.0, 0.0)]);
        // At the jump itself both are told.
        assert_eq!(told(&bend, 300.0, 0.02), [(0.0, 0.02), (0.0, 0.0)]);
        assert_eq!(told(&bend, 301.0, 0.0), []);
        assert_eq!(told(&[], 0.0, 0.0), []);
    }

    #[test]
    fn a_change_that_is_longer_than_what_is_told_is_told() {
        assert_eq!(told(&[(0.0, 0.0), (400.0, 0.04), (400.0, 0.0)], 100.0, 0.01), [(150.0, 0.025)]);
    }
}
