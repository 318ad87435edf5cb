//! Distributions one below the other, each under its full name: for more conditions than stand side by side.

use super::panel::{AxisQuantity, Panel, Rule};
use super::strips::{Spread, Strip, spread};
use super::svg::{At, through};

/// A chart of distributions along a horizontal axis: one row per condition.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    pub title: String,
    pub x: AxisQuantity,
    pub strips: Vec<Strip>,
    pub rules: Vec<Rule>,
    /// Interval of the horizontal axis, which charts side by side share.
    pub range: (f64, f64),
}

/// Pixels: of a row, its name included, and of the part that its dots take.
const ROW: f64 = 38.0;
const DOTS: f64 = 20.0;

impl Rows {
    pub fn to_svg(&self) -> String {
        let named = |strip: &Strip| {
            let runs = strip.dots.len() + strip.undefined;
            if strip.undefined == 0 {
                return strip.name.clone();
            }
            format!("{} ({} of {runs} runs)", strip.name, strip.dots.len())
        };
        let names: Vec<String> = self.strips.iter().map(named).collect();
        let label = self.x.label();
        let description = format!("distribution of {label}");
        let mut panel = Panel::rows(&self.title, &description, &label, self.range, &names, ROW);
        for rule in &self.rules {
            panel.upright(rule.value, &rule.label, "rule");
        }
        for (index, strip) in self.strips.iter().enumerate() {
            self.draw(&mut panel, index as f64 + 1.0, strip);
        }
        panel.finish()
    }

    fn draw(&self, panel: &mut Panel, bottom: f64, strip: &Strip) {
        let Some(Spread { dots, drawn, quartiles, violin }) = strip.spread(DOTS / 2.0) else { return };
        let middle = panel.place(0.0, bottom).1 - DOTS / 2.0 - 3.0;
        let at = |value: f64, panel: &Panel| panel.place(value, bottom).0;
        if let Some(outline) = violin {
            let upper = outline.iter().map(|(value, half)| (at(*value, panel), middle - half));
            let lower = outline.iter().rev().map(|(value, half)| (at(*value, panel), middle + half));
            let path = through(upper.chain(lower)) + "z";
            panel.shape("violin", &path, "");
        }
        for (order, dot) in dots.iter().enumerate().filter(|(order, _)| drawn(*order)) {
            let aside = (spread(order) - 0.5) * DOTS * 0.8;
            let look = dot.first.look();
            let title = format!("{} {}", self.x.show(dot.value), dot.name);
            let path = look.marker(at(dot.value, panel), middle + aside);
            panel.dot(&path, look, title.trim_end(), dot.run());
        }
        if let Some((lower, median, upper)) = quartiles {
            let (left, line, right) = (at(lower, panel), at(median, panel), at(upper, panel));
            let (top, bottom) = (At(middle - DOTS / 2.0), At(middle + DOTS / 2.0));
            let (left, line, right) = (At(left), At(line), At(right));
            let path = format!("M{left} {top}H{right}V{bottom}H{left}zM{line} {top}V{bottom}");
            panel.shape("box", &path, &strip.quartile_title(&self.x, (lower, median, upper)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::{Dot, First};

    #[test]
    fn every_condition_has_a_row() {
        let strip = |name: &str, values: &[f64]| Strip {
            name: name.into(),
            dots: values
                .iter()
                .map(|value| Dot { value: *value, first: First::Vehicle, name: String::new(), is_run: false })
                .collect(),
            undefined: 1,
        };
        let chart = Rows {
            title: "all runs of each scenario".into(),
            x: AxisQuantity::new("pet", "s"),
            strips: vec![
                strip("a_rather_long_name_of_a_scenario", &[1.0, 2.0, 2.5, 4.0]),
                strip("none", &[]),
            ],
            rules: vec![Rule { value: 1.5, label: "≥ 1.5 s".into() }],
            range: (0.0, 5.0),
        };
        insta::assert_snapshot!(chart.to_svg());
    }
}
