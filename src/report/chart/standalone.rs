//! Charts side by side as one picture that stands alone, with its own colours for light and dark, a legend and remarks.

use super::STYLE;
use super::look::LegendEntry;
use super::panel::WIDTH;
use super::svg::{At, Svg};

const COLOURS: &str = include_str!("standalone.css");

/// Of a chart, px.
const HEIGHT: f64 = 236.0;
const EDGE: f64 = 10.0;
const LINE: f64 = 17.0;
const TITLE: f64 = 26.0;

/// `charts` are those of this room, at least one; each is [`WIDTH`] wide and of the usual height.
pub fn standalone(title: &str, charts: &[String], legend: &[LegendEntry], remarks: &[String]) -> String {
    let width = 2.0 * EDGE + charts.len() as f64 * WIDTH;
    // Two entries of the legend side by side for every chart but one.
    let across = charts.len().max(1);
    let rows = legend.len().div_ceil(across);
    let height = TITLE + HEIGHT + LINE * (rows + remarks.len()) as f64 + 2.0 * EDGE;
    let mut svg = Svg::file((width, height), title, &format!("{COLOURS}{STYLE}"));
    svg.label(title, &[("class", &"said name-of-all"), ("x", &At(EDGE)), ("y", &At(18.0))]);
    for (index, chart) in charts.iter().enumerate() {
        svg.frame((EDGE + index as f64 * WIDTH, TITLE), (WIDTH, HEIGHT), chart);
    }
    let top = TITLE + HEIGHT + EDGE;
    for (index, entry) in legend.iter().enumerate() {
        let (column, row) = (index / rows.max(1), index % rows.max(1));
        let (left, at) = (EDGE + column as f64 * WIDTH, top + row as f64 * LINE);
        svg.frame((left, at), (28.0, 12.0), &entry.swatch);
        svg.label(&entry.label, &[("class", &"said"), ("x", &At(left + 36.0)), ("y", &At(at + 10.0))]);
    }
    for (index, remark) in remarks.iter().enumerate() {
        let at = top + (rows + index) as f64 * LINE + 10.0;
        svg.label(remark, &[("class", &"said quiet"), ("x", &At(EDGE)), ("y", &At(at))]);
    }
    svg.finish()
}
