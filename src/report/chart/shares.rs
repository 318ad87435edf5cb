//! Shares that people have with their errors, and what others do in the same places as lines.

use super::look::{LegendEntry, Look};
use super::panel::{Axis, AxisQuantity, Panel};
use super::scale::with_room;

/// A chart of shares in per cent.
#[derive(Debug, Clone, PartialEq)]
pub struct PeopleShares {
    pub title: String,
    pub x: AxisQuantity,
    /// At most three, drawn as markers.
    pub people: Vec<ShareSeries>,
    /// Drawn up to [`SHARE_LINES`].
    pub lines: Vec<ShareLine>,
}

/// A group of people.
#[derive(Debug, Clone, PartialEq)]
pub struct ShareSeries {
    pub name: String,
    pub points: Vec<SharePoint>,
}

/// A share from 0 to 1, and between what it lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SharePoint {
    pub x: f64,
    pub share: f64,
    pub within: (f64, f64),
}

/// What is compared with people: places and shares from 0 to 1; no place where the share is not known.
#[derive(Debug, Clone, PartialEq)]
pub struct ShareLine {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// How many lines can be told apart.
pub const SHARE_LINES: usize = super::look::LOOKS;

/// Pixels between the markers of groups of people at one place.
const APART: f64 = 8.0;

/// The looks of groups of people: the shapes of markers, all of the colour of text.
const SHAPES: [usize; 3] = [0, 1, 4];

impl PeopleShares {
    pub fn legend(&self) -> Vec<LegendEntry> {
        let people = self.people.iter().zip(SHAPES).map(|(one, shape)| LegendEntry {
            swatch: Look::series(shape).people_swatch(),
            label: one.name.clone(),
        });
        let lines = self.lines.iter().take(SHARE_LINES).enumerate().map(|(index, one)| LegendEntry {
            swatch: Look::series(index).swatch(true, false),
            label: one.name.clone(),
        });
        people.chain(lines).collect()
    }

    pub fn to_svg(&self) -> String {
        let mut values: Vec<f64> =
            self.people.iter().flat_map(|series| &series.points).map(|point| point.x).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        let axis = Axis::Values { range: with_room(&values), values: &values };
        let description = format!("shares against {}", self.x.label());
        let labels = (self.x.label(), "%");
        let mut panel = Panel::new(&self.title, &description, (&labels.0, labels.1), axis, (0.0, 100.0));
        for (index, line) in self.lines.iter().take(SHARE_LINES).enumerate() {
            let look = Look::series(index);
            match line.points[..] {
                [] => {}
                [(x, share)] => panel.dash(x, 100.0 * share, look, &line.name),
                _ => panel.line(line.points.iter().map(|(x, share)| (*x, 100.0 * share)), look, &line.name),
            }
        }
        let middle = (self.people.len() as f64 - 1.0) / 2.0;
        // All people in the middle, whatever their place in the legend.
        let places = [1.0, 0.0, 2.0];
        for ((series, shape), place) in self.people.iter().zip(SHAPES).zip(places) {
            let (look, aside) = (Look::series(shape), (place - middle) * APART);
            for point in &series.points {
                let (low, high) = point.within;
                let title = format!(
                    "{}, {}: {:.1} %, {:.1} % to {:.1} %",
                    series.name,
                    self.x.show(point.x),
                    100.0 * point.share,
                    100.0 * low,
                    100.0 * high
                );
                panel.people(point.x, [100.0 * low, 100.0 * point.share, 100.0 * high], aside, look, &title);
            }
        }
        panel.finish()
    }
}
