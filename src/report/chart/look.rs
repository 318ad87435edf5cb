//! How one series is told from another: colour, dash and shape at once, so that colour is never needed.
//!
//! The colours are those of Okabe & Ito, "Color Universal Design" (2008), without the yellow that vanishes on white;
//! the page's style sheet has a lighter set for dark backgrounds.

use super::svg::{Attribute, Svg};

/// The look of one series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Look(usize);

/// Who passed the conflict point first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum First {
    Pedestrian,
    Vehicle,
    /// Not both of them passed it, or nobody asked.
    Neither,
}

impl First {
    pub const ALL: [Self; 3] = [Self::Pedestrian, Self::Vehicle, Self::Neither];

    /// From the word of the metric `passed_first`.
    pub fn of(word: Option<&str>) -> Self {
        match word {
            Some("pedestrian") => Self::Pedestrian,
            Some("vehicle") => Self::Vehicle,
            _ => Self::Neither,
        }
    }

    pub fn look(self) -> Look {
        match self {
            Self::Pedestrian => Look(0),
            Self::Vehicle => Look(1),
            Self::Neither => Look(NEUTRAL),
        }
    }

    pub fn label(self) -> &'static str {
        match self {
            Self::Pedestrian => "pedestrian first",
            Self::Vehicle => "vehicle first",
            Self::Neither => "neither or unknown",
        }
    }
}

/// How many series can be told apart.
pub const LOOKS: usize = 6;
const NEUTRAL: usize = LOOKS;

const DASHES: [&str; LOOKS + 1] = ["none", "7 3", "2 3", "9 3 2 3", "4 2", "12 4", "1 2"];

/// Around the origin, about as large as a disc of radius 3.5.
const SHAPES: [&str; LOOKS + 1] = [
    "m-3.5 0a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0 -7 0z",
    "m0 -4.4l4.2 7.4h-8.4z",
    "m-3.2 -3.2h6.4v6.4h-6.4z",
    "m0 -4.6l4.6 4.6l-4.6 4.6l-4.6 -4.6z",
    "m0 4.4l4.2 -7.4h-8.4z",
    "m-1.3 -4h2.6v2.7h2.7v2.6h-2.7v2.7h-2.6v-2.7h-2.7v-2.6h2.7z",
    "m-3.4 -2.4l1 -1l2.4 2.4l2.4 -2.4l1 1l-2.4 2.4l2.4 2.4l-1 1l-2.4 -2.4l-2.4 2.4l-1 -1l2.4 -2.4z",
];

impl Look {
    /// The look of the series with this index; after [`LOOKS`] series they repeat.
    pub fn series(index: usize) -> Self {
        Self(index % LOOKS)
    }

    /// The class by which the style sheet gives it its colour.
    pub fn class(self, element: &str) -> String {
        format!("{element} c{}", self.0)
    }

    pub fn dash(self) -> &'static str {
        DASHES[self.0]
    }

    /// The path of its marker at a place in pixels.
    pub fn marker(self, x: f64, y: f64) -> String {
        format!("{}{}", super::svg::through([(x, y)]), SHAPES[self.0])
    }

    /// A small picture of it for a legend, with its line, its marker or both.
    pub fn swatch(self, line: bool, marker: bool) -> String {
        let mut svg = framed();
        if line {
            let class = self.class("line");
            svg.empty("path", &[("class", &class), ("d", &"M0 6H28"), ("stroke-dasharray", &self.dash())]);
        }
        if marker {
            svg.empty("path", &[("class", &self.class("dot")), ("d", &self.marker(14.0, 6.0))]);
        }
        svg.finish()
    }

    /// A small picture of the marker of people.
    pub fn people_swatch(self) -> String {
        let mut svg = framed();
        svg.empty("path", &[("class", &"people"), ("d", &self.marker(14.0, 6.0))]);
        svg.finish()
    }

    /// A small picture of its band, as dark as so many bands on each other.
    pub fn band_swatch(self, layers: usize) -> String {
        self.area_swatch(layers, false)
    }

    /// A small picture of its line within its band.
    pub fn belief_swatch(self) -> String {
        self.area_swatch(1, true)
    }

    fn area_swatch(self, layers: usize, line: bool) -> String {
        let mut svg = framed();
        for _ in 0..layers {
            svg.empty("path", &[("class", &self.class("band")), ("d", &"M0 0H28V12H0z")]);
        }
        if line {
            svg.empty("path", &[("class", &self.class("line")), ("d", &"M0 6H28")]);
        }
        svg.finish()
    }
}

/// The frame of a small picture for a legend.
pub fn framed() -> Svg {
    let mut svg = Svg::default();
    let frame: [Attribute; 4] =
        [("class", &"chart swatch"), ("viewBox", &"0 0 28 12"), ("width", &"28"), ("height", &"12")];
    svg.open("svg", &frame);
    svg
}

/// A line of a legend.
#[derive(Debug, Clone, PartialEq)]
pub struct LegendEntry {
    /// SVG.
    pub swatch: String,
    pub label: String,
}
