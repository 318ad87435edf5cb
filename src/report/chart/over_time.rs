//! Quantities of one run over time, with bounds to read them against and a moment that is marked.

use super::look::Look;
use super::panel::{Axis, AxisQuantity, Panel, Rule};
use super::scale::nice_range;

/// A chart over time.
#[derive(Debug, Clone, PartialEq)]
pub struct OverTime {
    pub title: String,
    pub y: AxisQuantity,
    /// s; what lies outside is not drawn.
    pub from: f64,
    /// s
    pub to: f64,
    pub series: Vec<TimeSeries>,
    pub rules: Vec<Rule>,
    /// s; marked by an upright line.
    pub moment: Option<f64>,
    /// Single values, such as what a metric came to.
    pub marks: Vec<TimeMark>,
    /// Lines are not drawn above this, unless a bound or a mark is there.
    pub ceiling: Option<f64>,
}

/// One line of it.
#[derive(Debug, Clone, PartialEq)]
pub struct TimeSeries {
    pub look: Look,
    pub name: String,
    /// Time in s and value; without one the line has a gap.
    pub points: Vec<(f64, Option<f64>)>,
}

/// A single value at a moment.
#[derive(Debug, Clone, PartialEq)]
pub struct TimeMark {
    pub look: Look,
    /// s
    pub time: f64,
    pub value: f64,
    /// What stands beside it.
    pub label: String,
}

impl TimeSeries {
    fn values(&self) -> impl Iterator<Item = f64> {
        self.points.iter().filter_map(|point| point.1)
    }

    /// What of it is from one time to another.
    fn between(&self, from: f64, to: f64) -> Self {
        let points = self.points.iter().filter(|point| (from..=to).contains(&point.0));
        Self { points: points.copied().collect(), name: self.name.clone(), look: self.look }
    }

    /// The stretches without gaps.
    fn stretches(&self) -> impl Iterator<Item = Vec<(f64, f64)>> {
        let stretches = self.points.split(|point| point.1.is_none()).filter(|stretch| !stretch.is_empty());
        stretches.map(|stretch| stretch.iter().filter_map(|(time, value)| Some((*time, (*value)?))).collect())
    }
}

impl OverTime {
    pub fn to_svg(&self) -> String {
        let series: Vec<TimeSeries> = self.series.iter().map(|one| one.between(self.from, self.to)).collect();
        let high = self.ceiling.unwrap_or(f64::INFINITY);
        let values = series.iter().flat_map(TimeSeries::values).filter(|value| *value <= high);
        // A bound is in the picture, so that who looks sees whether it was kept; so is whatever is marked.
        let rules = self.rules.iter().map(|rule| rule.value);
        let y = nice_range(values.chain(rules).chain(self.marks.iter().map(|mark| mark.value)));
        let description = format!("{} over time in s, {}", self.y.label(), self.in_words(&series));
        let axis = Axis::Numbers { range: (self.from, self.to) };
        let mut panel = Panel::new(&self.title, &description, ("time (s)", &self.y.label()), axis, y);
        self.rules.iter().for_each(|rule| panel.rule(rule));
        if let Some(moment) = self.moment.filter(|one| (self.from..=self.to).contains(one)) {
            panel.upright(moment, "", "rule");
        }
        let is_cut = series.iter().flat_map(TimeSeries::values).any(|value| value > y.1);
        if is_cut {
            panel.clip();
        }
        for series in &series {
            for stretch in series.stretches() {
                match stretch[..] {
                    [(time, value)] => panel.dash(time, value, series.look, &series.name),
                    _ => panel.line(stretch.iter().copied(), series.look, &series.name),
                }
            }
        }
        if is_cut {
            panel.unclip();
        }
        for TimeMark { look, time, value, label } in &self.marks {
            panel.marker(*time, *value, 0.0, *look, &format!("{label} at {time:.2} s"));
            panel.note(*time, *value, label, *look, &self.rules);
        }
        panel.finish()
    }

    /// What a line spans and what is marked, for who cannot see it.
    fn in_words(&self, series: &[TimeSeries]) -> String {
        let spans = series.iter().filter(|one| one.values().next().is_some()).map(|one| {
            let (low, high) = one.values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
            format!("{} from {} to {}", one.name, self.y.show(low), self.y.show(high))
        });
        let marks = self.marks.iter().map(|mark| format!("{} at {:.2} s", mark.label, mark.time));
        spans.chain(marks).collect::<Vec<_>>().join("; ")
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
                points: vec![(0.0, Some(0.0)), (2.0, Some(-1.5)), (4.0, Some(0.0))],
            }],
            rules: vec![Rule { value: -2.5, label: "max_deceleration ≤ 2.5 m/s^2".into() }],
            moment: Some(2.0),
            marks: Vec::new(),
            ceiling: None,
        };
        let svg = chart.to_svg();
        assert!(!svg.contains("<1>") && !svg.contains("NaN"), "{svg}");
        assert_eq!(svg.matches("class=\"rule\"").count(), 2, "{svg}");
        assert!(svg.contains("av &lt;1&gt; from -1.5 m/s^2 to 0 m/s^2"), "{svg}");
        // What is outside is not marked at the edge, and nothing to draw is no number that is none.
        let none = OverTime { moment: Some(9.0), series: Vec::new(), rules: Vec::new(), ..chart }.to_svg();
        assert!(!none.contains("class=\"rule\"") && !none.contains("NaN") && !none.contains("inf"), "{none}");
    }

    #[test]
    fn lines_have_gaps_and_marks_are_in_the_picture() {
        let points = [Some(30.0), Some(9.0), None, Some(4.0), None, Some(2.0), Some(2.5)];
        let chart = OverTime {
            title: "Time to collision".into(),
            y: AxisQuantity::new("time to collision", "s"),
            from: 0.0,
            to: 6.0,
            series: vec![TimeSeries {
                look: Look::series(0),
                name: "av and walker".into(),
                points: points.into_iter().enumerate().map(|(time, value)| (time as f64, value)).collect(),
            }],
            rules: Vec::new(),
            moment: None,
            marks: vec![TimeMark {
                look: Look::series(0),
                time: 5.1,
                value: 1.9,
                label: "min_ttc 1.9 s".into(),
            }],
            ceiling: Some(10.0),
        };
        let svg = chart.to_svg();
        // Two stretches, and what has no neighbour is seen all the same.
        assert_eq!(svg.matches("class=\"line c0\"").count(), 3, "{svg}");
        assert!(svg.contains("from 2 s to 30 s; min_ttc 1.9 s at 5.10 s"), "{svg}");
        assert!(svg.contains("overflow=\"hidden\"") && svg.contains(">10</text>"), "{svg}");
        assert!(!svg.contains(">30</text>") && svg.contains("class=\"dot c0\""), "{svg}");
        // A mark that is above what is drawn is in the picture.
        let marks = vec![TimeMark { value: 14.0, ..chart.marks[0].clone() }];
        assert!(OverTime { marks, ..chart }.to_svg().contains(">15</text>"));
    }
}
