//! Distributions side by side: every run a dot, or a violin where there are too many, with quartiles.

use super::look::First;
use super::panel::{Axis, AxisQuantity, Panel, Rule};
use super::scale::nice_range;
use numbers::summary::quantile;

/// A chart of distributions: one strip per variation value or condition.
#[derive(Debug, Clone, PartialEq)]
pub struct Strips {
    pub title: String,
    /// What the strips are, such as `tta`; may be empty.
    pub x: String,
    pub y: AxisQuantity,
    pub strips: Vec<Strip>,
    pub rules: Vec<Rule>,
    /// Interval of the vertical axis, so that charts side by side compare; otherwise that of the data.
    pub range: Option<(f64, f64)>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    pub name: String,
    pub dots: Vec<Dot>,
    /// Runs in which the metric does not exist.
    pub undefined: usize,
}

/// One run.
#[derive(Debug, Clone, PartialEq)]
pub struct Dot {
    pub value: f64,
    pub first: First,
    /// Names it.
    pub name: String,
    /// Whether its name is the key of a run of the suite.
    pub is_run: bool,
}

impl Dot {
    /// The key of its run.
    pub fn run(&self) -> Option<&str> {
        (self.is_run && !self.name.is_empty()).then_some(&self.name)
    }
}

/// With more dots than this a strip is a violin, and of the dots beyond the 5 % and 95 % quantiles those farthest out are
/// drawn, half as many at each end.
const MOST_DOTS: usize = 120;
/// Places at which a violin's width is found.
const VIOLIN_LEVELS: usize = 40;

/// Whether a dot with this value may be drawn among dots with these values, sorted.
pub fn is_drawn(sorted: &[f64], value: f64) -> bool {
    let end = MOST_DOTS / 2;
    sorted.len() <= MOST_DOTS || value <= sorted[end - 1] || value >= sorted[sorted.len() - end]
}

impl Strips {
    /// An interval of the vertical axis that suits all of `strips` and `rules`.
    pub fn range<'a>(
        strips: impl IntoIterator<Item = &'a Strip>,
        rules: impl IntoIterator<Item = &'a Rule>,
    ) -> (f64, f64) {
        let values = strips.into_iter().flat_map(|strip| &strip.dots).map(|dot| dot.value);
        nice_range(values.chain(rules.into_iter().map(|rule| rule.value)))
    }

    pub fn to_svg(&self) -> String {
        let names: Vec<String> = self.strips.iter().map(|strip| strip.name.clone()).collect();
        let range = self.range.unwrap_or_else(|| Self::range(&self.strips, &self.rules));
        let description = format!("distribution of {}", self.y.label());
        let labels = (self.x.as_str(), self.y.label());
        let mut panel =
            Panel::new(&self.title, &description, (labels.0, &labels.1), Axis::Names(&names), range);
        for (index, strip) in self.strips.iter().enumerate() {
            self.draw(&mut panel, index as f64 + 0.5, strip);
        }
        for rule in &self.rules {
            panel.rule(rule);
        }
        panel.finish()
    }

    fn draw(&self, panel: &mut Panel, x: f64, strip: &Strip) {
        let runs = strip.dots.len() + strip.undefined;
        if strip.undefined > 0 && panel.slot > 26.0 {
            panel.remark(x, &format!("{}/{runs}", strip.dots.len()));
        }
        let width = (panel.slot * 0.7).min(44.0);
        let Some(Spread { dots, drawn, quartiles, violin }) = strip.spread(width / 2.0) else { return };
        let many = violin.is_some();
        if let Some(outline) = violin {
            panel.violin(x, &outline);
        }
        for (order, dot) in dots.iter().enumerate().filter(|(order, _)| drawn(*order)) {
            let aside = (spread(order) - 0.5) * width * 0.8;
            let title = format!("{} {}", self.y.show(dot.value), dot.name);
            panel.run_marker((x, dot.value), aside, dot.first.look(), title.trim_end(), dot.run());
        }
        if let Some(quartiles) = quartiles {
            let title = strip.quartile_title(&self.y, quartiles);
            panel.quartiles(x, quartiles, if many { width * 0.3 } else { width }, &title);
        }
    }

    /// Who passed first in any of the runs drawn.
    pub fn firsts(&self) -> impl Iterator<Item = First> {
        self.strips.iter().flat_map(|strip| &strip.dots).map(|dot| dot.first)
    }
}

/// What is drawn of a strip.
pub struct Spread<'a> {
    /// By rising value.
    pub dots: Vec<&'a Dot>,
    /// Whether the dot of this index is drawn.
    pub drawn: Box<dyn Fn(usize) -> bool>,
    /// Lower quartile, median and upper quartile, if there are enough dots.
    pub quartiles: Option<(f64, f64, f64)>,
    /// Values with half widths, where there are too many dots to draw them all.
    pub violin: Option<Vec<(f64, f64)>>,
}

impl Strip {
    /// `None` without any dot. `half_width` is the violin's largest.
    pub fn spread(&self, half_width: f64) -> Option<Spread<'_>> {
        let mut dots: Vec<&Dot> = self.dots.iter().collect();
        dots.sort_by(|left, right| left.value.total_cmp(&right.value));
        let sorted: Vec<f64> = dots.iter().map(|dot| dot.value).collect();
        let level = |level| quantile(&sorted, level);
        let (low, high) = (level(0.05)?, level(0.95)?);
        let quartiles = (level(0.25)?, level(0.5)?, level(0.75)?);
        let many = dots.len() > MOST_DOTS;
        let violin = many.then(|| violin(&sorted, half_width));
        let (least, most) = (MOST_DOTS / 2, sorted.len().saturating_sub(MOST_DOTS / 2));
        let drawn = move |index: usize| {
            !many || (index < least || index >= most) && !(low..=high).contains(&sorted[index])
        };
        let quartiles = (dots.len() >= 4).then_some(quartiles);
        Some(Spread { dots, drawn: Box::new(drawn), quartiles, violin })
    }

    /// The quartiles in words.
    pub fn quartile_title(&self, quantity: &AxisQuantity, (lower, middle, upper): (f64, f64, f64)) -> String {
        let show = |value| quantity.show(value);
        let (dots, runs) = (self.dots.len(), self.dots.len() + self.undefined);
        let quartiles = format!("median {}, quartiles {} and {}", show(middle), show(lower), show(upper));
        format!("{}: {quartiles}, {dots} of {runs} runs", self.name)
    }
}

/// A sequence in 0..1 that fills the interval evenly from the start: van der Corput's, base 2.
pub fn spread(index: usize) -> f64 {
    f64::from((index as u32).reverse_bits()) / 4_294_967_296.0
}

/// Heights and half widths of a violin: a Gaussian kernel density with Silverman's bandwidth, cut at the extremes.
fn violin(sorted: &[f64], half_width: f64) -> Vec<(f64, f64)> {
    let (first, last) = (sorted[0], sorted[sorted.len() - 1]);
    let count = sorted.len() as f64;
    let mean = sorted.iter().sum::<f64>() / count;
    let deviation = (sorted.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / count).sqrt();
    let bandwidth = 0.9 * deviation * libm::pow(count, -0.2);
    if bandwidth <= 0.0 {
        return vec![(first, half_width), (last, half_width)];
    }
    let heights: Vec<f64> = (0..=VIOLIN_LEVELS)
        .map(|level| first + (last - first) * level as f64 / VIOLIN_LEVELS as f64)
        .collect();
    let density = |height: f64| -> f64 {
        let kernel = |value: &f64| {
            let distance = (height - value) / bandwidth;
            libm::exp(-0.5 * distance * distance)
        };
        sorted.iter().map(kernel).sum()
    };
    let densities: Vec<f64> = heights.iter().map(|height| density(*height)).collect();
    let most = densities.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    heights
        .into_iter()
        .zip(densities)
        .map(|(height, density)| (height, density / most * half_width))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip(name: &str, values: &[f64], undefined: usize) -> Strip {
        let dot = |(index, value): (usize, &f64)| Dot {
            value: *value,
            first: First::ALL[index % 2],
            name: format!("{name}/rep={index}"),
            is_run: index % 2 == 0,
        };
        Strip { name: name.into(), dots: values.iter().enumerate().map(dot).collect(), undefined }
    }

    fn chart(strips: Vec<Strip>) -> Strips {
        let rule = Rule { value: 1.5, label: ">= 1.5 s".into() };
        Strips {
            title: "commotions_carla".into(),
            x: "tta".into(),
            y: AxisQuantity::new("pet", "s"),
            strips,
            rules: vec![rule],
            range: None,
        }
    }

    #[test]
    fn few_runs_are_dots() {
        let strips = vec![
            strip("6 s", &[1.2, 2.0, 2.2, 3.1, 2.4], 0),
            strip("10 s", &[2.0, 4.0], 3),
            strip("14 s", &[], 5),
        ];
        insta::assert_snapshot!(chart(strips).to_svg());
    }

    #[test]
    fn many_runs_are_a_violin_with_their_extremes() {
        let values: Vec<f64> = (0..1000).map(|index| 2.0 + f64::from(index) / 1000.0).collect();
        let svg = chart(vec![strip("6 s", &values, 0)]).to_svg();
        assert_eq!(svg.matches("class=\"violin\"").count(), 1);
        assert_eq!(svg.matches("class=\"dot").count(), 100);
    }

    #[test]
    fn equal_values_make_a_chart() {
        let svg = chart(vec![strip("6 s", &[2.0; 200], 0)]).to_svg();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
