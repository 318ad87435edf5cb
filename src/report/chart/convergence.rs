//! How fast an optimiser came to its best: the best value so far against the number of evaluations.

use super::look::{LegendEntry, Look};
use super::mark::PointMark;
use super::panel::{Axis, AxisQuantity, Panel};
use super::scale::nice_range;
use super::slice::Tried;
use numbers::summary::quantile;
use scenario::Goal;

/// One course: every evaluation, and the best so far as a staircase.
#[derive(Debug, Clone, PartialEq)]
pub struct Convergence {
    pub title: String,
    pub y: AxisQuantity,
    pub goal: Goal,
    /// `x` is the number of the evaluation, from 1. [`PointMark::Refused`] ones are never the best.
    pub tried: Vec<Tried>,
    /// The first so many are those that the optimiser begins with.
    pub initial: usize,
}

/// Many courses at once: median and bands of the best so far.
#[derive(Debug, Clone, PartialEq)]
pub struct Convergences {
    pub title: String,
    pub y: AxisQuantity,
    pub goal: Goal,
    /// Values in the order of evaluation, `None` where there is none; they may end early.
    pub courses: Vec<Vec<Option<f64>>>,
    pub initial: usize,
}

impl Convergence {
    /// `best` says what the best point is.
    pub fn legend(&self, best: &str) -> Vec<LegendEntry> {
        let swatch = Look::series(0).swatch(true, false);
        let mut entries = vec![LegendEntry { swatch, label: "best so far".into() }];
        entries.extend(PointMark::legend(self.tried.iter().map(|tried| tried.mark), best));
        entries
    }

    pub fn to_svg(&self) -> String {
        let values: Vec<Option<f64>> =
            self.tried.iter().map(|tried| tried.y.filter(|_| tried.mark != PointMark::Refused)).collect();
        let best = so_far(&values, self.goal);
        let range = nice_range(self.tried.iter().filter_map(|tried| tried.y));
        let mut panel = plot(&self.title, &self.y, self.tried.len(), self.initial, range);
        let known: Vec<(f64, f64)> = numbered(&best).collect();
        panel.line(stairs(&known), Look::series(0), "best so far");
        for mark in PointMark::ALL {
            let tried = self.tried.iter().filter(|tried| tried.mark == mark);
            panel.marks(tried.map(|tried| (tried.x, tried.y)), mark);
        }
        panel.finish()
    }
}

impl Convergences {
    pub fn legend() -> Vec<LegendEntry> {
        let look = Look::series(0);
        vec![
            LegendEntry { swatch: look.swatch(true, false), label: "median of the best so far".into() },
            LegendEntry { swatch: look.band_swatch(2), label: "middle half".into() },
            LegendEntry { swatch: look.band_swatch(1), label: "middle 90 %".into() },
        ]
    }

    pub fn to_svg(&self) -> String {
        let courses: Vec<Vec<Option<f64>>> =
            self.courses.iter().map(|course| so_far(course, self.goal)).collect();
        let longest = courses.iter().map(Vec::len).max().unwrap_or(0);
        // Evaluation number and the levels of [`LEVELS`] over the courses that have a value by then.
        let mut spread: Vec<(f64, Vec<f64>)> = Vec::new();
        for index in 0..longest {
            let best = |course: &Vec<Option<f64>>| course.get(index).or(course.last()).copied().flatten();
            let mut values: Vec<f64> = courses.iter().filter_map(best).collect();
            values.sort_by(f64::total_cmp);
            let levels: Vec<f64> = LEVELS.iter().filter_map(|level| quantile(&values, *level)).collect();
            if levels.len() == LEVELS.len() {
                spread.push(((index + 1) as f64, levels));
            }
        }
        let range = nice_range(spread.iter().flat_map(|(_, levels)| levels.iter().copied()));
        let mut panel = plot(&self.title, &self.y, longest, self.initial, range);
        let look = Look::series(0);
        let level = |which: usize| {
            let points: Vec<(f64, f64)> = spread.iter().map(|(x, levels)| (*x, levels[which])).collect();
            stairs(&points)
        };
        for (low, high) in [(0, 4), (1, 3)] {
            // Both edges change at places of their own, so that each is a staircase of its own.
            panel.area(&level(low), &level(high), look);
        }
        panel.line(level(2), look, "median of the best so far");
        panel.finish()
    }
}

/// What the bands show.
const LEVELS: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

fn plot(title: &str, y: &AxisQuantity, evaluations: usize, initial: usize, range: (f64, f64)) -> Panel {
    let axis = Axis::Numbers { range: (0.0, (evaluations as f64 + 0.5).max(1.0)) };
    let label = y.label();
    let description = format!("best {label} against the number of evaluations");
    let mut panel = Panel::new(title, &description, ("evaluations", &label), axis, range);
    if 0 < initial && initial < evaluations {
        panel.upright(initial as f64 + 0.5, "", "hair");
    }
    panel
}

/// The best value by every evaluation.
fn so_far(values: &[Option<f64>], goal: Goal) -> Vec<Option<f64>> {
    let better = |left: f64, right: f64| match goal {
        Goal::Minimise => left.min(right),
        Goal::Maximise => left.max(right),
    };
    let mut best: Option<f64> = None;
    let step = |value: &Option<f64>| {
        if let Some(value) = value {
            best = Some(best.map_or(*value, |best| better(best, *value)));
        }
        best
    };
    values.iter().map(step).collect()
}

fn numbered(best: &[Option<f64>]) -> impl Iterator<Item = (f64, f64)> {
    best.iter().enumerate().filter_map(|(index, value)| Some(((index + 1) as f64, (*value)?)))
}

/// A staircase through points in rising order, only its corners.
fn stairs(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut corners: Vec<(f64, f64)> = Vec::new();
    let mut height = None;
    for (x, y) in points {
        if height == Some(*y) {
            continue;
        }
        corners.extend(height.map(|height| (*x, height)));
        corners.push((*x, *y));
        height = Some(*y);
    }
    if let (Some((x, _)), Some(height)) = (points.last(), height)
        && corners.last().is_some_and(|corner| corner.0 < *x)
    {
        corners.push((*x, height));
    }
    corners
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_best_so_far_is_a_staircase() {
        let tried = |number: u32, y: Option<f64>, mark| Tried { x: f64::from(number), y, mark };
        let chart = Convergence {
            title: "braking_distance".into(),
            y: AxisQuantity::new("mean(time_lost)", "s"),
            goal: Goal::Minimise,
            tried: vec![
                tried(1, Some(4.0), PointMark::Initial),
                tried(2, Some(0.5), PointMark::Refused),
                tried(3, None, PointMark::Refused),
                tried(4, Some(3.0), PointMark::Proposed),
                tried(5, Some(3.5), PointMark::Proposed),
                tried(6, Some(2.0), PointMark::Best),
            ],
            initial: 3,
        };
        insta::assert_snapshot!(chart.to_svg());
        assert_eq!(chart.legend("best").len(), 5);
    }

    #[test]
    fn nothing_feasible_draws_no_line() {
        let tried = Tried { x: 1.0, y: None, mark: PointMark::Refused };
        let chart = Convergence {
            title: "nothing".into(),
            y: AxisQuantity::default(),
            goal: Goal::Minimise,
            tried: vec![tried],
            initial: 1,
        };
        assert!(!chart.to_svg().contains("NaN"));
        let none = Convergences {
            title: "nobody".into(),
            y: AxisQuantity::default(),
            goal: Goal::Maximise,
            courses: vec![vec![None], Vec::new()],
            initial: 0,
        };
        assert!(!none.to_svg().contains("NaN"));
    }

    #[test]
    fn corners_only() {
        let points = [(1.0, 3.0), (2.0, 3.0), (3.0, 1.0), (4.0, 1.0)];
        assert_eq!(stairs(&points), [(1.0, 3.0), (3.0, 3.0), (3.0, 1.0), (4.0, 1.0)]);
        assert_eq!(stairs(&[]), []);
    }

    proptest! {
        #[test]
        fn the_best_so_far_never_gets_worse(values in prop::collection::vec(prop::option::of(-1e3..1e3f64), 0..40)) {
            let best = so_far(&values, Goal::Minimise);
            prop_assert_eq!(best.len(), values.len());
            let known: Vec<f64> = best.into_iter().flatten().collect();
            prop_assert!(known.windows(2).all(|pair| pair[1] <= pair[0]));
            let smallest = values.iter().flatten().copied().fold(f64::INFINITY, f64::min);
            prop_assert_eq!(known.last().copied().unwrap_or(f64::INFINITY), smallest);
        }
    }
}
