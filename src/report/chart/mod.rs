//! Charts as SVG: the five kinds of the founding paper, generic over metric and variation, and those of optimisers.
//!
//! Plain data goes in, a `<svg>` element comes out. Colours come from the classes of [`STYLE`], so that one style sheet
//! serves light, dark and print.
//!
//! | figure of the paper | chart |
//! |---|---|
//! | rates against a variation | [`Rates`] |
//! | distributions per scenario and variation, or per condition | [`Strips`] |
//! | distance-distance trajectories | [`Paths`] |
//! | metric against the value found for each individual | [`IndividualsChart`] |
//!
//! An optimiser's course is a [`Convergence`] (of many: [`Convergences`]), its surrogate a [`Slice`], two objectives
//! against each other a [`Front`], how bad encounters are against how usual [`Danger`], a gate's differences a [`Forest`], numbers over two variations a [`Heat`], one run over time [`OverTime`] and, where it is about who is somewhere when, [`Spans`]. [`Rows`] are strips for many conditions or long names,
//! [`PeopleShares`] what people did beside what others do. [`standalone`] makes a picture of charts.

mod convergence;
mod danger;
mod forest;
mod front;
mod heat;
mod individuals;
mod look;
mod mark;
mod over_time;
mod panel;
mod paths;
mod rates;
mod rows;
mod scale;
mod shares;
mod slice;
mod spans;
mod standalone;
mod strips;

use crate::svg;

pub use convergence::{Convergence, Convergences};
pub use danger::{Danger, OnFront};
pub use forest::{Forest, ForestRow};
pub use front::Front;
pub use heat::{Heat, HeatCell};
pub use individuals::{COURSES_FROM, CourseLine, FoundDot, IndividualsChart};
pub use look::{First, LOOKS, LegendEntry, Look};
pub use mark::PointMark;
pub use over_time::{OverTime, TimeMark, TimeSeries};
pub use panel::{AxisQuantity, Rule, shortened};
pub use paths::{ChartPath, Paths};
pub use rates::{Rate, RateSeries, Rates};
pub use rows::Rows;
pub use scale::with_room;
pub use shares::{PeopleShares, SHARE_LINES, ShareLine, SharePoint, ShareSeries};
pub use slice::{Along, Belief, Slice, Tried};
pub use spans::{Gap, SpanRow, Spans, TimeSpan};
pub use standalone::standalone;
pub use strips::{Dot, Strip, Strips, is_drawn};

/// The rules that the classes in charts refer to; they rely on the custom properties of the page's own style sheet.
pub const STYLE: &str = include_str!("chart.css");

/// The legend of charts that are coloured by who passed first, without those that nobody is.
pub fn first_legend(present: impl IntoIterator<Item = First>, line: bool) -> Vec<LegendEntry> {
    let present: std::collections::BTreeSet<First> = present.into_iter().collect();
    let entry =
        |first: First| LegendEntry { swatch: first.look().swatch(line, !line), label: first.label().into() };
    First::ALL.into_iter().filter(|first| present.contains(first)).map(entry).collect()
}
