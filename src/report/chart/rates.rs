//! Shares of runs against a numeric variation, with confidence bars: one line per series.

use super::look::{LegendEntry, Look};
use super::panel::{Axis, AxisQuantity, Panel, Rule};
use super::scale::with_room;
use numbers::inference::{Interval, clopper_pearson};

/// A chart of rates in per cent.
#[derive(Debug, Clone, PartialEq)]
pub struct Rates {
    pub title: String,
    pub x: AxisQuantity,
    pub series: Vec<RateSeries>,
    /// A bound in 0..1 to read the rates against.
    pub rule: Option<Rule>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct RateSeries {
    pub name: String,
    /// In order of the variation.
    pub rates: Vec<Rate>,
}

/// A share of runs at one value of the variation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rate {
    pub x: f64,
    pub holding: usize,
    pub runs: usize,
}

/// Pixels between the markers of series that have a point at the same place.
const APART: f64 = 5.0;

impl Rates {
    pub fn legend(&self) -> Vec<LegendEntry> {
        let entry = |(index, series): (usize, &RateSeries)| LegendEntry {
            swatch: Look::series(index).swatch(true, true),
            label: series.name.clone(),
        };
        self.series.iter().enumerate().map(entry).collect()
    }

    /// The chart with 95 % intervals after Clopper and Pearson, as verdicts on shares have.
    pub fn to_svg(&self) -> String {
        let mut values: Vec<f64> =
            self.series.iter().flat_map(|series| &series.rates).map(|rate| rate.x).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        let axis = Axis::Values { range: with_room(&values), values: &values };
        let description = format!("shares of runs against {}", self.x.label());
        let mut panel =
            Panel::new(&self.title, &description, (&self.x.label(), "% of runs"), axis, (0.0, 100.0));
        if let Some(rule) = &self.rule {
            panel.rule(&Rule { value: rule.value * 100.0, label: rule.label.clone() });
        }
        let middle = (self.series.len() as f64 - 1.0) / 2.0;
        for (index, series) in self.series.iter().enumerate() {
            let (look, aside) = (Look::series(index), (index as f64 - middle) * APART);
            let counted = || series.rates.iter().filter(|rate| rate.runs > 0);
            let points = counted().map(|rate| (rate.x, percent(rate)));
            panel.line_aside(points, aside, look, &series.name);
            for rate in counted() {
                let Interval { low, high } = clopper_pearson(rate.holding as u64, rate.runs as u64, 0.95);
                panel.interval(rate.x, low * 100.0, high * 100.0, aside, look);
                let title = format!(
                    "{}, {}: {} of {} runs (95 % interval {:.0}–{:.0} %)",
                    series.name,
                    self.x.show(rate.x),
                    rate.holding,
                    rate.runs,
                    low * 100.0,
                    high * 100.0
                );
                panel.marker(rate.x, percent(rate), aside, look, &title);
            }
        }
        panel.finish()
    }
}

fn percent(rate: &Rate) -> f64 {
    rate.holding as f64 / rate.runs as f64 * 100.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_lines_bars_and_markers() {
        let series = |name: &str, holding: [usize; 3]| RateSeries {
            name: name.into(),
            rates: [6.0, 10.0, 14.0]
                .into_iter()
                .zip(holding)
                .map(|(x, holding)| Rate { x, holding, runs: 20 })
                .collect(),
        };
        let chart = Rates {
            title: "gap_accepted".into(),
            x: AxisQuantity::new("tta", "s"),
            series: vec![series("commotions", [2, 11, 20]), series("carla_walker", [12, 12, 11])],
            rule: None,
        };
        insta::assert_snapshot!(chart.to_svg());
    }

    #[test]
    fn a_value_without_runs_is_left_out() {
        let rates = vec![Rate { x: 6.0, holding: 0, runs: 0 }];
        let series = vec![RateSeries { name: "empty".into(), rates }];
        let chart = Rates { title: "x".into(), x: AxisQuantity::default(), series, rule: None };
        assert!(!chart.to_svg().contains("NaN"));
    }
}
