//! Differences with their intervals, one below the other, beside what is tolerated of each.

use super::look::Look;
use super::panel::Panel;
use super::svg::{At, through};

/// A forest plot: all its rows have the unit of its axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Forest {
    pub title: String,
    /// Of the horizontal axis, with its unit.
    pub axis: String,
    pub rows: Vec<ForestRow>,
}

/// A difference.
#[derive(Debug, Clone, PartialEq)]
pub struct ForestRow {
    pub name: String,
    pub difference: f64,
    /// Where it lies; an infinite end is open. None where there is no chance in it.
    pub interval: Option<(f64, f64)>,
    /// What is beyond this, seen from zero, is worse than tolerated.
    pub tolerated: f64,
    pub look: Look,
    /// All of it in words.
    pub title: String,
}

/// Pixels: of a row, its name included, and from its lower edge to its mark.
const ROW: f64 = 34.0;
const UP: f64 = 10.0;

impl Forest {
    pub fn to_svg(&self) -> String {
        let ends = |row: &ForestRow| {
            let (low, high) = row.interval.unwrap_or((row.difference, row.difference));
            [low, high, row.difference, row.tolerated]
        };
        let finite = self.rows.iter().flat_map(ends).filter(|end| end.is_finite());
        let (low, high) =
            finite.fold((0.0, 0.0), |(low, high): (f64, f64), end| (low.min(end), high.max(end)));
        let room = if low < high { 0.06 * (high - low) } else { 1.0 };
        let range = (low - room, high + room);
        let names: Vec<String> = self.rows.iter().map(|row| row.name.clone()).collect();
        let description = format!("{}; the tables have the numbers", self.axis);
        let mut panel = Panel::rows(&self.title, &description, &self.axis, range, &names, ROW);
        panel.upright(0.0, "", "hair");
        for (index, row) in self.rows.iter().enumerate() {
            let bottom = index as f64 + 1.0;
            let middle = panel.place(0.0, bottom).1 - UP;
            let at = |value: f64| panel.place(value.clamp(range.0, range.1), bottom).0;
            let (top, under) = (At(middle - 6.0), At(middle + 6.0));
            let tolerated = format!("M{} {top}V{under}", At(at(row.tolerated)));
            let whisker = row.interval.map(|(low, high)| {
                let (caps, floor) = (At(middle - 3.0), At(middle + 3.0));
                let cap = |end: f64| match end.is_finite() {
                    true => format!("M{} {caps}V{floor}", At(at(end))),
                    false => String::new(),
                };
                through([(at(low), middle), (at(high), middle)]) + &cap(low) + &cap(high)
            });
            let mark = row.look.marker(at(row.difference), middle);
            panel.shape("rule", &tolerated, "");
            if let Some(path) = whisker {
                panel.shape(&row.look.class("whisker"), &path, "");
            }
            panel.shape(&row.look.class("dot"), &mark, &row.title);
        }
        panel.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn open_ends_have_no_cap_and_nothing_is_no_number() {
        let row = |interval| ForestRow {
            name: "pet <1>".into(),
            difference: -10.0,
            interval,
            tolerated: -5.0,
            look: Look::series(1),
            title: "pet <1>: -10 %".into(),
        };
        let drawn = |rows| Forest { title: "means".into(), axis: "change (%)".into(), rows }.to_svg();
        let caps = |svg: &str| {
            let path = svg.split("class=\"whisker c1\"").nth(1).map(|rest| rest.split("/>").next().unwrap());
            path.map_or(0, |path| path.matches('M').count() - 1)
        };
        let svg = drawn(vec![row(Some((-15.0, -5.0)))]);
        assert_eq!(caps(&svg), 2, "{svg}");
        let svg = drawn(vec![row(Some((f64::NEG_INFINITY, -5.0)))]);
        assert_eq!(caps(&svg), 1, "{svg}");
        assert!(!svg.contains("<1>") && !svg.contains("inf") && !svg.contains("NaN"), "{svg}");
        assert!(!drawn(vec![row(None)]).contains("whisker"));
    }
}
