//! Trajectories in the distance-distance plane: where the pedestrian is while the vehicle is there.

use super::look::{First, LegendEntry};
use super::panel::{Axis, Panel};
use super::{first_legend, scale::nice_range};

/// A chart of trajectories. Distances are along each one's way, in m: negative before the conflict point, positive
/// behind it. A path through the origin is a collision.
#[derive(Debug, Clone, PartialEq)]
pub struct Paths {
    pub title: String,
    pub paths: Vec<ChartPath>,
    /// Intervals of the axes (vehicle, pedestrian), so that charts side by side compare.
    pub ranges: Option<((f64, f64), (f64, f64))>,
}

/// One run's course: `(vehicle, pedestrian)` in m.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartPath {
    pub points: Vec<(f64, f64)>,
    pub first: First,
    /// The run's key.
    pub name: String,
}

/// What is farther from the conflict point than this is not looked at, m.
const VEHICLE_NEIGHBOURHOOD: (f64, f64) = (-200.0, 20.0);
const PEDESTRIAN_NEIGHBOURHOOD: (f64, f64) = (-10.0, 10.0);

impl Paths {
    /// Intervals that show the neighbourhood of the conflict point for all of `paths`.
    pub fn ranges<'a>(paths: impl IntoIterator<Item = &'a ChartPath> + Clone) -> ((f64, f64), (f64, f64)) {
        let points = || paths.clone().into_iter().flat_map(|path| path.points.iter().copied());
        let within = |(low, high): (f64, f64)| move |value: f64| value.clamp(low, high);
        let vehicles = points().map(|(car, _)| car).map(within(VEHICLE_NEIGHBOURHOOD));
        let pedestrians = points().map(|(_, person)| person).map(within(PEDESTRIAN_NEIGHBOURHOOD));
        (nice_range(vehicles), nice_range(pedestrians))
    }

    pub fn legend<'a>(paths: impl IntoIterator<Item = &'a ChartPath>) -> Vec<LegendEntry> {
        first_legend(paths.into_iter().map(|path| path.first), true)
    }

    pub fn to_svg(&self) -> String {
        let (x, y) = self.ranges.unwrap_or_else(|| Self::ranges(&self.paths));
        let labels = ("vehicle, m from the conflict point", "pedestrian, m from the conflict point");
        let description = "positions of pedestrian against vehicle";
        let mut panel = Panel::new(&self.title, description, labels, Axis::Numbers { range: x }, y);
        panel.cross_hair(0.0, 0.0);
        panel.clip();
        for path in &self.paths {
            panel.run_line(path.points.iter().copied(), path.first.look(), &path.name);
        }
        panel.unclip();
        panel.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_courses_and_the_conflict_point() {
        let path = |first, name: &str, points: &[(f64, f64)]| ChartPath {
            points: points.to_vec(),
            first,
            name: name.into(),
        };
        let chart = Paths {
            title: "jaywalker".into(),
            paths: vec![
                path(First::Pedestrian, "a/rep=1", &[(-80.0, -4.0), (-40.0, 0.0), (-10.0, 4.0)]),
                path(First::Vehicle, "a/rep=2", &[(-80.0, -4.0), (0.0, -3.5), (10.0, 0.0)]),
            ],
            ranges: None,
        };
        insta::assert_snapshot!(chart.to_svg());
    }
}
