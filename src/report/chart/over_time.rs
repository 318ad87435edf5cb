//! Quantities of one run over time, with bounds to read them against and a moment that is marked.

use super::look::Look;
use super::panel::{Axis, AxisQuantity, Panel, Rule};
use super::scale::nice_range;

/// A chart over time.
#[derive(Debug, Clone, PartialEq)]
pub struct OverTime {
    pub title: String,
    pub y: AxisQuantity,
    /// s
    pub from: f64,
    /// s
    pub to: f64,
    pub series: Vec<TimeSeries>,
    pub rules: Vec<Rule>,
    /// s; marked by an upright line.
    pub moment: Option<f64>,
}

/// One line of it.
#[derive(Debug, Clone, PartialEq)]
pub struct TimeSeries {
    pub look: Look,
    pub name: String,
    /// Time in s and value.
    pub points: Vec<(f64, f64)>,
}

impl OverTime {
    pub fn to_svg(&self) -> String {
        let values = self.series.iter().flat_map(|one| &one.points).map(|point| point.1);
        // A bound is in the picture, so that who looks sees whether it was kept.
        let y = nice_range(values.chain(self.rules.iter().map(|rule| rule.value)));
        let description = format!("{} over time in s, {}", self.y.label(), self.in_words());
        let axis = Axis::Numbers { range: (self.from, self.to) };
        let mut panel = Panel::new(&self.title, &description, ("time (s)", &self.y.label()), axis, y);
        self.rules.iter().for_each(|rule| panel.rule(rule));
        if let Some(moment) = self.moment.filter(|one| (self.from..=self.to).contains(one)) {
            panel.upright(moment, "", "rule");
        }
        for TimeSeries { look, name, points } in &self.series {
            panel.line(points.iter().copied(), *look, name);
        }
        panel.finish()
    }

    /// What a line spans, for who cannot see it.
    fn in_words(&self) -> String {
        let spans = self.series.iter().filter(|one| !one.points.is_empty()).map(|one| {
            let (low, high) =
                one.points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), point| {
                    (low.min(point.1), high.max(point.1))
                });
            format!("{} from {} to {}", one.name, self.y.show(low), self.y.show(high))
        });
        spans.collect::<Vec<_>>().join("; ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_and_the_moment_are_in_the_picture() {
        let chart = OverTime {
            title: "Accelerations".into(),
            y: AxisQuantity::new("acceleration", "m/s^2"),
            from: 0.0,
            to: 4.0,
            series: vec![TimeSeries {
                look: Look::series(0),
                name: "av <1>".into(),
                points: vec![(0.0, 0.0), (2.0, -1.5), (4.0, 0.0)],
            }],
            rules: vec![Rule { value: -2.5, label: "max_deceleration ≤ 2.5 m/s^2".into() }],
            moment: Some(2.0),
        };
        let svg = chart.to_svg();
        assert!(!svg.contains("<1>") && !svg.contains("NaN"), "{svg}");
        assert_eq!(svg.matches("class=\"rule\"").count(), 2, "{svg}");
        assert!(svg.contains("av &lt;1&gt; from -1.5 m/s^2 to 0 m/s^2"), "{svg}");
        // What is outside is not marked at the edge, and nothing to draw is no number that is none.
        let none = OverTime { moment: Some(9.0), series: Vec::new(), rules: Vec::new(), ..chart }.to_svg();
        assert!(!none.contains("class=\"rule\"") && !none.contains("NaN") && !none.contains("inf"), "{none}");
    }
}
