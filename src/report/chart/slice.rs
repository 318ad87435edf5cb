//! A slice through a surrogate: what it believes along one dimension, with the points that were evaluated.

use super::look::{LegendEntry, Look, framed};
use super::mark::PointMark;
use super::panel::{Axis, AxisQuantity, Panel, Rule};
use super::scale::nice_range;

/// A chart of an objective (or a constraint's margin) along one dimension of a search space.
#[derive(Debug, Clone, PartialEq)]
pub struct Slice {
    pub title: String,
    pub x: AxisQuantity,
    pub along: Along,
    pub y: AxisQuantity,
    /// In rising order; empty where there is no surrogate.
    pub beliefs: Vec<Belief>,
    pub tried: Vec<Tried>,
    pub rules: Vec<Rule>,
    /// Interval of the vertical axis, so that charts side by side compare; otherwise that of the data.
    pub range: Option<(f64, f64)>,
}

/// What a dimension's values are.
#[derive(Debug, Clone, PartialEq)]
pub enum Along {
    Numbers {
        low: f64,
        high: f64,
    },
    /// Both positive.
    Logarithmic {
        low: f64,
        high: f64,
    },
    /// A point's place is its word's index.
    Words(Vec<String>),
}

/// What the surrogate believes at a place: mean and 95 % band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belief {
    pub x: f64,
    pub mean: f64,
    pub lower: f64,
    pub upper: f64,
    /// Probability that every constraint holds; 1 without constraints.
    pub feasibility: f64,
}

/// An evaluated point; without a value it stands at the upper edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tried {
    pub x: f64,
    pub y: Option<f64>,
    pub mark: PointMark,
}

impl Slice {
    /// An interval of the vertical axis that suits all of `slices`: all points and means, and of the bands what is near.
    pub fn range<'a>(slices: impl IntoIterator<Item = &'a Self>) -> (f64, f64) {
        let (mut values, mut bands) = (Vec::new(), Vec::new());
        for slice in slices {
            values.extend(slice.tried.iter().filter_map(|tried| tried.y));
            values.extend(slice.rules.iter().map(|rule| rule.value));
            values.extend(slice.beliefs.iter().map(|belief| belief.mean));
            bands.extend(slice.beliefs.iter().flat_map(|belief| [belief.lower, belief.upper]));
        }
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let room = (high - low) / 4.0;
        values.extend(bands.into_iter().map(|edge| edge.clamp(low - room, (high + room).max(low - room))));
        nice_range(values)
    }

    /// What stands in any of `slices`; `best` says what the best point is.
    pub fn legend<'a>(slices: impl IntoIterator<Item = &'a Self> + Clone, best: &str) -> Vec<LegendEntry> {
        let slices = || slices.clone().into_iter();
        let beliefs = || slices().flat_map(|slice| &slice.beliefs);
        let mut entries = Vec::new();
        if beliefs().next().is_some() {
            let swatch = Look::series(0).belief_swatch();
            entries.push(LegendEntry { swatch, label: "surrogate: mean and 95 % band".into() });
        }
        if beliefs().any(|belief| belief.feasibility < LIKELY) {
            let label = "surrogate: a constraint is more likely violated than not".into();
            entries.push(LegendEntry { swatch: shade_swatch(), label });
        }
        entries
            .extend(PointMark::legend(slices().flat_map(|slice| &slice.tried).map(|tried| tried.mark), best));
        entries
    }

    pub fn to_svg(&self) -> String {
        let range = self.range.unwrap_or_else(|| Self::range([self]));
        let labels = (self.x.label(), self.y.label());
        let description = format!("{} along {}", labels.1, labels.0);
        let axis = match &self.along {
            Along::Numbers { low, high } => Axis::Numbers { range: (*low, *high) },
            Along::Logarithmic { low, high } => Axis::Logarithmic { range: (*low, *high) },
            Along::Words(words) => Axis::Names(words),
        };
        // The middle of a word's place.
        let aside = if matches!(self.along, Along::Words(_)) { 0.5 } else { 0.0 };
        let mut panel = Panel::new(&self.title, &description, (&labels.0, &labels.1), axis, range);
        panel.clip();
        self.shade(&mut panel, aside);
        let look = Look::series(0);
        if aside == 0.0 {
            let band: Vec<_> = self.beliefs.iter().map(|one| (one.x, one.lower, one.upper)).collect();
            if band.len() > 1 {
                panel.smooth_band(&band, look);
                panel.line(self.beliefs.iter().map(|one| (one.x, one.mean)), look, "");
            }
        } else {
            for one in &self.beliefs {
                panel.interval(one.x + aside, one.lower, one.upper, -9.0, look);
                panel.marker(one.x + aside, one.mean, -9.0, look, "");
            }
        }
        panel.unclip();
        for rule in &self.rules {
            panel.rule(rule);
        }
        for mark in PointMark::ALL {
            let tried = self.tried.iter().filter(|tried| tried.mark == mark);
            panel.marks(tried.map(|tried| (tried.x + aside, tried.y)), mark);
        }
        panel.finish()
    }

    /// Pale where a constraint is likely violated.
    fn shade(&self, panel: &mut Panel, aside: f64) {
        let unlikely = |belief: &Belief| belief.feasibility < LIKELY;
        let mut index = 0;
        while let Some(from) = self.beliefs[index..].iter().position(unlikely).map(|steps| index + steps) {
            let to = self.beliefs[from..].iter().position(|one| !unlikely(one));
            index = to.map_or(self.beliefs.len(), |steps| from + steps);
            let (from, to) = (self.beliefs[from].x, self.beliefs[index - 1].x);
            // A word's whole place; of numbers, half a step more would be invented.
            panel.shade(from, to + 2.0 * aside);
        }
    }
}

fn shade_swatch() -> String {
    let mut svg = framed();
    svg.empty("path", &[("class", &"unlikely"), ("d", &"M0 0H28V12H0z")]);
    svg.finish()
}

/// What is less feasible than this is shaded.
const LIKELY: f64 = 0.5;

#[cfg(test)]
mod tests {
    use super::*;

    fn belief(x: f64, feasibility: f64) -> Belief {
        let mean = (x - 10.0).abs() / 2.0;
        Belief { x, mean, lower: mean - 1.0, upper: mean + 1.0, feasibility }
    }

    fn slice(along: Along, beliefs: Vec<Belief>) -> Slice {
        let tried = |x: f64, y, mark| Tried { x, y, mark };
        Slice {
            title: "individual 17".into(),
            x: AxisQuantity::new("tta", "s"),
            along,
            y: AxisQuantity::new("pet", "s"),
            beliefs,
            tried: vec![
                tried(0.0, Some(4.0), PointMark::Initial),
                tried(2.0, None, PointMark::Refused),
                tried(1.0, Some(2.5), PointMark::Proposed),
                tried(1.0, Some(0.5), PointMark::Best),
            ],
            rules: vec![Rule { value: 1.5, label: "< 1.5 s".into() }],
            range: None,
        }
    }

    #[test]
    fn draws_the_belief_under_the_points() {
        let beliefs = (0..=100).map(|step| belief(0.2 * f64::from(step), 1.0)).collect();
        let chart = slice(Along::Numbers { low: 0.0, high: 20.0 }, beliefs);
        insta::assert_snapshot!(chart.to_svg());
    }

    #[test]
    fn shades_what_is_likely_infeasible() {
        let beliefs: Vec<Belief> = (0..=10)
            .map(|step| belief(f64::from(step), if (3..=8).contains(&step) { 0.9 } else { 0.2 }))
            .collect();
        let chart = slice(Along::Numbers { low: 0.0, high: 10.0 }, beliefs);
        assert_eq!(chart.to_svg().matches("class=\"unlikely\"").count(), 2);
        assert_eq!(Slice::legend([&chart], "best").len(), 6);
    }

    #[test]
    fn words_and_decades_have_axes_of_their_own() {
        let words: Vec<String> = ["calm", "hurried", "late"].map(String::from).to_vec();
        let svg =
            slice(Along::Words(words), vec![belief(0.0, 1.0), belief(1.0, 0.1), belief(2.0, 1.0)]).to_svg();
        assert!(svg.contains(">hurried<") && svg.contains("whisker"), "{svg}");
        let svg = slice(Along::Logarithmic { low: 0.1, high: 10.0 }, Vec::new());
        let svg = Slice { tried: svg.tried[2..].to_vec(), ..svg }.to_svg();
        assert!(svg.contains(">0.1<") && svg.contains(">10<") && !svg.contains("NaN"), "{svg}");
    }

    #[test]
    fn a_wide_band_does_not_squeeze_the_rest() {
        let wide = Belief { x: 5.0, mean: 1.0, lower: -1e6, upper: 1e6, feasibility: 1.0 };
        let chart = slice(Along::Numbers { low: 0.0, high: 10.0 }, vec![wide]);
        let (low, high) = Slice::range([&chart]);
        assert!(low >= -2.0 && high <= 6.0, "{low} .. {high}");
    }
}
