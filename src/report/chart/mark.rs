//! Marks of an optimiser's evaluations, told apart by shape: what was tried first, tried later, refused and chosen.

use std::collections::BTreeSet;

use super::look::{LegendEntry, framed};
use super::svg::At;

/// What became of an evaluated point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PointMark {
    /// One of the points that an optimiser begins with.
    Initial,
    /// One that it proposed.
    Proposed,
    /// It violates a constraint, or has no value.
    Refused,
    /// The best one, or the one that was chosen.
    Best,
}

impl PointMark {
    pub const ALL: [Self; 4] = [Self::Initial, Self::Proposed, Self::Refused, Self::Best];

    /// The class by which the style sheet draws it.
    pub fn class(self) -> &'static str {
        match self {
            Self::Initial => "initial",
            Self::Proposed => "proposed",
            Self::Refused => "refused",
            Self::Best => "best",
        }
    }

    /// Marks at places in pixels as one path. A line without length has round ends: a disc in few letters.
    pub fn path(self, places: impl IntoIterator<Item = (f64, f64)>) -> String {
        let shape = match self {
            Self::Initial => "m-2.6 0a2.6 2.6 0 1 0 5.2 0a2.6 2.6 0 1 0-5.2 0",
            Self::Proposed => "h.01",
            Self::Refused => "m-2.6-2.6l5.2 5.2m0-5.2l-5.2 5.2",
            Self::Best => "m0-6l5 6l-5 6l-5-6z",
        };
        places.into_iter().map(|(x, y)| format!("M{} {}{shape}", At(x), At(y))).collect()
    }

    /// Lines of a legend for those that are `present`; `best` says what the best one is.
    pub fn legend(present: impl IntoIterator<Item = Self>, best: &str) -> Vec<LegendEntry> {
        let label = |mark| match mark {
            Self::Initial => "initial point",
            Self::Proposed => "proposed point",
            Self::Refused => "violates a constraint, or has no value (at the upper edge)",
            Self::Best => best,
        };
        let present: BTreeSet<Self> = present.into_iter().collect();
        present.into_iter().map(|mark| mark.entry(label(mark))).collect()
    }

    fn entry(self, label: &str) -> LegendEntry {
        let mut svg = framed();
        svg.empty("path", &[("class", &self.class()), ("d", &self.path([(14.0, 6.0)]))]);
        LegendEntry { swatch: svg.finish(), label: label.into() }
    }
}
