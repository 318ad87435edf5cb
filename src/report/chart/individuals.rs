//! A metric against a variation: one marker per individual, and the courses of some with mean and range.

use super::look::{First, LOOKS, Look};
use super::panel::{Axis, AxisQuantity, Panel, Rule};
use super::scale::{nice_range, with_room};

/// A scatter chart, such as each individual's smallest post-encroachment time against the time to arrival that it was
/// found at.
#[derive(Debug, Clone, PartialEq)]
pub struct IndividualsChart {
    pub title: String,
    pub x: AxisQuantity,
    pub y: AxisQuantity,
    pub points: Vec<FoundDot>,
    /// Drawn below the points.
    pub courses: Vec<CourseLine>,
    pub rules: Vec<Rule>,
    /// Intervals of the axes, so that charts side by side compare; otherwise those of the data.
    pub ranges: Option<Ranges>,
    /// Equal factors of x at equal distances.
    pub logarithmic: bool,
}

/// Intervals of the horizontal and the vertical axis.
pub type Ranges = ((f64, f64), (f64, f64));

/// One individual (or run) and the variation's value that it was found at.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundDot {
    pub x: f64,
    pub y: f64,
    pub first: First,
    pub name: String,
    /// Whether its name is the key of a run of the suite.
    pub is_run: bool,
}

/// A metric over a variation: its mean and range over repetitions.
#[derive(Debug, Clone, PartialEq)]
pub struct CourseLine {
    /// Short: it stands in the chart, where the course ends.
    pub name: String,
    /// `(x, smallest, mean, largest)` in order of x.
    pub points: Vec<(f64, f64, f64, f64)>,
}

impl IndividualsChart {
    /// Intervals of the axes that suit all of `charts`.
    pub fn ranges<'a>(charts: impl IntoIterator<Item = &'a Self>) -> Ranges {
        let (mut places, mut values) = (Vec::new(), Vec::new());
        for chart in charts {
            places.extend(chart.points.iter().map(|point| point.x));
            places.extend(chart.courses.iter().flat_map(|course| &course.points).map(|point| point.0));
            values.extend(chart.points.iter().map(|point| point.y));
            values.extend(chart.rules.iter().map(|rule| rule.value));
            values.extend(chart.courses.iter().flat_map(|course| &course.points).flat_map(|p| [p.1, p.3]));
        }
        (with_room(&places), nice_range(values))
    }

    pub fn to_svg(&self) -> String {
        let (x, y) = self.ranges.unwrap_or_else(|| Self::ranges([self]));
        let labels = (self.x.label(), self.y.label());
        let description = format!("{} against {}", labels.1, labels.0);
        let axis = if self.logarithmic { Axis::Logarithmic { range: x } } else { Axis::Numbers { range: x } };
        let mut panel = Panel::new(&self.title, &description, (&labels.0, &labels.1), axis, y);
        let look = |index: usize| Look::series(COURSES_FROM + index % (LOOKS - COURSES_FROM));
        for (index, course) in self.courses.iter().enumerate() {
            let band: Vec<_> = course.points.iter().map(|(x, low, _, high)| (*x, *low, *high)).collect();
            panel.band(&band, look(index));
        }
        for (index, course) in self.courses.iter().enumerate() {
            panel.line(course.points.iter().map(|(x, _, mean, _)| (*x, *mean)), look(index), &course.name);
        }
        for point in &self.points {
            let title = format!("{} at {} {}", self.y.show(point.y), self.x.show(point.x), point.name);
            let run = point.is_run.then_some(point.name.as_str());
            panel.run_marker((point.x, point.y), 0.0, point.first.look(), title.trim_end(), run);
        }
        for rule in &self.rules {
            panel.rule(rule);
        }
        for (index, (x, y)) in self.name_places(y).into_iter().enumerate() {
            panel.name(x, y, &self.courses[index].name, look(index));
        }
        panel.finish()
    }

    /// Where the names of the courses stand: where each course ends, moved apart where they would cover each other.
    fn name_places(&self, (low, high): (f64, f64)) -> Vec<(f64, f64)> {
        let end = |course: &CourseLine| course.points.last().map_or((0.0, low), |point| (point.0, point.2));
        let mut places: Vec<(f64, f64)> = self.courses.iter().map(end).collect();
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.sort_by(|left, right| places[*left].1.total_cmp(&places[*right].1));
        let apart = (high - low) * NAME_HEIGHT;
        let mut free = low;
        for index in &order {
            places[*index].1 = places[*index].1.max(free);
            free = places[*index].1 + apart;
        }
        let mut free = high - apart / 2.0;
        for index in order.iter().rev() {
            places[*index].1 = places[*index].1.min(free);
            free = places[*index].1 - apart;
        }
        places
    }
}

/// The look of the first course: those before it say who passed first.
pub const COURSES_FROM: usize = 2;
/// Height of a name as a share of the plot's.
const NAME_HEIGHT: f64 = 0.065;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_points_over_courses() {
        let chart = IndividualsChart {
            title: "low_pet".into(),
            x: AxisQuantity::new("tta", "s"),
            y: AxisQuantity::new("pet", "s"),
            points: vec![
                FoundDot {
                    x: 7.5,
                    y: 1.2,
                    first: First::Pedestrian,
                    name: "individual 3".into(),
                    is_run: false,
                },
                FoundDot {
                    x: 16.0,
                    y: 4.1,
                    first: First::Vehicle,
                    name: "late/tta=16s/rep=1".into(),
                    is_run: true,
                },
            ],
            courses: vec![CourseLine {
                name: "individual 3".into(),
                points: vec![(6.0, 1.0, 1.4, 1.9), (10.0, 1.2, 1.9, 2.5), (18.0, 3.0, 3.5, 4.0)],
            }],
            rules: vec![Rule { value: 1.5, label: "1.5 s".into() }],
            ranges: None,
            logarithmic: false,
        };
        insta::assert_snapshot!(chart.to_svg());
    }
}
