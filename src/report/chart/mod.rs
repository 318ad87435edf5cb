//! Charts as SVG: the five kinds of the founding paper, generic over metric and variation.
//!
//! Plain data goes in, a `<svg>` element comes out. Colours come from the classes of [`STYLE`], so that one style sheet
//! serves light, dark and print.
//!
//! | figure of the paper | chart |
//! |---|---|
//! | rates against a variation | [`Rates`] |
//! | distributions per scenario and variation, or per condition | [`Strips`] |
//! | distance-distance trajectories | [`Paths`] |
//! | metric against the value found for each individual | [`Individuals`] |

mod individuals;
mod look;
mod panel;
mod paths;
mod rates;
mod scale;
mod strips;
mod svg;

pub use individuals::{Course, Found, Individuals, Ranges};
pub use look::{Entry, First, LOOKS, Look};
pub use panel::{Quantity, Rule, shortened};
pub use paths::{Path, Paths};
pub use rates::{Rate, RateSeries, Rates};
pub use scale::nice_range;
pub use strips::{Dot, Strip, Strips};

/// The rules that the classes in charts refer to; they rely on the custom properties of the page's own style sheet.
pub const STYLE: &str = include_str!("chart.css");

/// The legend of charts that are coloured by who passed first, without those that nobody is.
pub fn first_legend(present: impl IntoIterator<Item = First>, line: bool) -> Vec<Entry> {
    let present: std::collections::BTreeSet<First> = present.into_iter().collect();
    let entry =
        |first: First| Entry { swatch: first.look().swatch(line, !line), label: first.label().into() };
    First::ALL.into_iter().filter(|first| present.contains(first)).map(entry).collect()
}
