//! Numbers over two variations: a cell each, the stronger its colour the worse, with the number in it.

use super::panel::{LETTER, WIDTH, shortened};
use super::svg::{At, Svg};

/// A heat map.
#[derive(Debug, Clone, PartialEq)]
pub struct Heat {
    pub title: String,
    /// What is in the cells, with its unit.
    pub quantity: String,
    /// The variation from left to right, and its values.
    pub x: (String, Vec<String>),
    /// The variation from top to bottom, and its values.
    pub y: (String, Vec<String>),
    pub cells: Vec<HeatCell>,
}

/// One place.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatCell {
    /// Indices of the values.
    pub column: usize,
    pub row: usize,
    /// 0, as good as the best, to 1, as bad as the worst; `None` without a value.
    pub badness: Option<f64>,
    /// The number.
    pub text: String,
    /// What is put before the number where it did not pass; empty where it did.
    pub mark: &'static str,
    /// All of it in words.
    pub title: String,
    /// Where on the page it stands: `#key`.
    pub target: String,
}

/// Pixels: above the cells, of a row and below the cells.
const TOP: f64 = 34.0;
const ROW: f64 = 24.0;
const BOTTOM: f64 = 34.0;
const RIGHT: f64 = 4.0;
/// The names on the left take no more than this.
const MOST_LEFT: f64 = 92.0;
/// In less than this no number can be read.
const NARROWEST: f64 = 27.0;

impl Heat {
    pub fn to_svg(&self) -> String {
        let letters = self.y.1.iter().map(|name| name.chars().count()).max().unwrap_or(0);
        let left = (8.0 + LETTER * letters as f64).clamp(30.0, MOST_LEFT);
        let wide = (WIDTH - RIGHT - left) / self.x.1.len().max(1) as f64;
        let height = TOP + ROW * self.y.1.len() as f64 + BOTTOM;
        let mut svg = Svg::default();
        let description = format!(
            "{}: {} over {} and {}; each cell leads to its trial",
            self.title, self.quantity, self.x.0, self.y.0
        );
        let frame = format!("0 0 {WIDTH} {}", At(height));
        svg.open(
            "svg",
            &[("class", &"chart"), ("viewBox", &frame), ("role", &"group"), ("aria-label", &description)],
        );
        let most = |room: f64| (room / LETTER) as usize;
        svg.label(&shortened(&self.title, most(WIDTH - 8.0)), &[("class", &"title"), ("x", &4), ("y", &13)]);
        let across = format!("{} down, {} across", self.y.0, self.x.0);
        svg.label(&shortened(&across, most(WIDTH - 8.0)), &[("class", &"muted"), ("x", &4), ("y", &27)]);
        for (row, name) in self.y.1.iter().enumerate() {
            let y = At(TOP + ROW * row as f64 + ROW / 2.0 + 4.0);
            svg.label(
                &shortened(name, most(left - 6.0)),
                &[("x", &At(left - 5.0)), ("y", &y), ("text-anchor", &"end")],
            );
        }
        // Where names would run into each other, only every so many are written.
        let longest = self.x.1.iter().map(|name| name.chars().count()).max().unwrap_or(1).min(12);
        let every = ((LETTER * (longest as f64 + 1.0)) / wide).ceil().max(1.0) as usize;
        for (column, name) in self.x.1.iter().enumerate().step_by(every) {
            let (x, y) = (At(left + wide * (column as f64 + 0.5)), At(height - BOTTOM + 14.0));
            let name = shortened(name, most(wide * every as f64).max(3));
            svg.label(&name, &[("x", &x), ("y", &y), ("text-anchor", &"middle")]);
        }
        for cell in &self.cells {
            let (x, y) = (left + wide * cell.column as f64, TOP + ROW * cell.row as f64);
            svg.open("a", &[("href", &cell.target), ("aria-label", &cell.title)]);
            let opacity = format!("{:.2}", cell.badness.map_or(0.0, |badness| 0.05 + 0.5 * badness));
            let class = if cell.mark == "✗" { "cell failed" } else { "cell" };
            let (at, up) = (At(x + 1.0), At(y + 1.0));
            let (across, down) = (At(wide - 2.0), At(ROW - 2.0));
            svg.titled(
                "rect",
                &cell.title,
                &[
                    ("class", &class),
                    ("x", &at),
                    ("y", &up),
                    ("width", &across),
                    ("height", &down),
                    ("fill-opacity", &opacity),
                ],
            );
            let text = match wide >= NARROWEST {
                true => shortened(format!("{} {}", cell.mark, cell.text).trim_start(), most(wide)),
                false => cell.mark.into(),
            };
            if !text.is_empty() {
                let (x, y) = (At(x + wide / 2.0), At(y + ROW / 2.0 + 4.0));
                svg.label(&text, &[("x", &x), ("y", &y), ("text-anchor", &"middle")]);
            }
            svg.close();
        }
        let foot = format!("in the cells: {}", self.quantity);
        svg.label(
            &shortened(&foot, most(WIDTH - 8.0)),
            &[("class", &"muted"), ("x", &4), ("y", &At(height - 4.0))],
        );
        svg.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(columns: usize) -> Heat {
        let names = |count: usize, unit: &str| (0..count).map(|one| format!("{one} {unit}")).collect();
        let cell = |column: usize, row: usize| HeatCell {
            column,
            row,
            badness: (column + row > 0).then(|| column as f64 / columns as f64),
            text: if column + row > 0 { format!("{column}.{row}") } else { "–".into() },
            mark: if column > 1 { "✗" } else { "" },
            title: format!("speed={column} tta={row}: <{column}.{row} s>"),
            target: format!("#late/speed={column}/tta={row}"),
        };
        Heat {
            title: "late".into(),
            quantity: "worst pet (s)".into(),
            x: ("speed".into(), names(columns, "km/h")),
            y: ("tta".into(), names(2, "s")),
            cells: (0..columns).flat_map(|column| [cell(column, 0), cell(column, 1)]).collect(),
        }
    }

    #[test]
    fn cells_have_numbers_links_and_marks() {
        insta::assert_snapshot!(chart(3).to_svg());
    }

    #[test]
    fn narrow_cells_have_marks_only() {
        let svg = chart(16).to_svg();
        assert_eq!(svg.matches(">✗</text>").count(), 28);
        assert!(!svg.contains(">✗ 2.0<") && svg.contains("<title>speed=2 tta=0: &lt;2.0 s&gt;</title>"));
    }
}
