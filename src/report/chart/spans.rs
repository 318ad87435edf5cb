//! Who is somewhere when in one run, a row each, and how much time is between them, with how much there should have been.

use super::look::Look;
use super::panel::Panel;
use super::svg::At;

/// Rows of bars over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Spans {
    pub title: String,
    /// s
    pub from: f64,
    /// s
    pub to: f64,
    pub rows: Vec<SpanRow>,
    /// s; marked by an upright line.
    pub moment: Option<f64>,
}

/// A row, under its name.
#[derive(Debug, Clone, PartialEq)]
pub struct SpanRow {
    pub name: String,
    pub look: Look,
    pub spans: Vec<TimeSpan>,
    /// Moments that are marked, s.
    pub ticks: Vec<f64>,
    pub gap: Option<Gap>,
}

/// From when to when something is so, s; `None` where it was so before the run, or is after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeSpan {
    pub from: Option<f64>,
    pub to: Option<f64>,
}

/// The time between two moments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// s
    pub from: f64,
    /// s
    pub to: f64,
    /// How long it should have been at least, s.
    pub needed: Option<f64>,
    /// Whether that is asked for and not so.
    pub fails: bool,
}

/// Pixels: of a row with its name, and from its top to the middle of its bars, and half their height.
const ROW: f64 = 30.0;
const MIDDLE: f64 = 22.0;
const HALF: f64 = 4.5;

impl TimeSpan {
    fn words(self) -> String {
        match (self.from, self.to) {
            (Some(from), Some(to)) => format!("{from:.2} s to {to:.2} s"),
            (Some(from), None) => format!("{from:.2} s to the end of the run"),
            (None, Some(to)) => format!("the beginning of the run to {to:.2} s"),
            (None, None) => "the beginning of the run to its end".into(),
        }
    }
}

impl Spans {
    pub fn to_svg(&self) -> String {
        let names: Vec<String> = self.rows.iter().map(|row| row.name.clone()).collect();
        let description = self.rows.iter().map(SpanRow::words).collect::<Vec<_>>().join("; ");
        let range = (self.from, self.to);
        let mut panel = Panel::rows_over_time(&self.title, &description, range, &names, ROW);
        if let Some(moment) = self.moment.filter(|one| (self.from..=self.to).contains(one)) {
            panel.upright(moment, "", "rule");
        }
        for (index, row) in self.rows.iter().enumerate() {
            self.draw(&mut panel, index, row);
        }
        panel.finish()
    }

    fn draw(&self, panel: &mut Panel, index: usize, row: &SpanRow) {
        let at = |time: f64| {
            let (x, top) = panel.place(time.clamp(self.from, self.to), index as f64);
            (x, top + MIDDLE)
        };
        let mut shapes: Vec<(String, String, String)> = Vec::new();
        for span in &row.spans {
            let (left, y) = at(span.from.unwrap_or(self.from));
            let (right, _) = at(span.to.unwrap_or(self.to));
            let (right, top, bottom) = (right.max(left + 1.0), At(y - HALF), At(y + HALF));
            let path = format!("M{} {top}H{}V{bottom}H{}z", At(left), At(right), At(left));
            shapes.push((row.look.class("span"), path, format!("{}: {}", row.name, span.words())));
        }
        for tick in &row.ticks {
            let (x, y) = at(*tick);
            let path = format!("M{} {}V{}", At(x), At(y - HALF - 2.0), At(y + HALF + 2.0));
            shapes.push(("pass".into(), path, format!("{tick:.2} s")));
        }
        if let Some(gap) = &row.gap {
            let ((left, y), (right, _)) = (at(gap.from), at(gap.to));
            if let Some(needed) = gap.needed {
                let (end, _) = at(gap.from + needed);
                // Where it goes on beyond the run, nothing closes it.
                let cap = match gap.from + needed <= self.to {
                    true => format!("M{} {}V{}", At(end), At(y - HALF), At(y + HALF)),
                    false => String::new(),
                };
                let path = format!("M{} {}H{}{cap}", At(left), At(y), At(end));
                shapes.push(("needed".into(), path, format!("{needed:.2} s would have been needed")));
            }
            let (low, high) = (At(y - HALF), At(y + HALF));
            let path = format!(
                "M{} {low}V{high}M{} {low}V{high}M{} {}H{}",
                At(left),
                At(right),
                At(left),
                At(y),
                At(right)
            );
            let class = if gap.fails { "gap short" } else { "gap" };
            shapes.push((class.into(), path, row.name.clone()));
        }
        for (class, path, title) in shapes {
            panel.shape(&class, &path, &title);
        }
    }
}

impl SpanRow {
    /// What it shows, for who cannot see it.
    fn words(&self) -> String {
        let spans: Vec<String> = self.spans.iter().map(|span| span.words()).collect();
        let gap = self.gap.map(|gap| format!("from {:.2} s to {:.2} s", gap.from, gap.to));
        let ticks = self.ticks.iter().map(|tick| format!("passing at {tick:.2} s"));
        let all: Vec<String> = spans.into_iter().chain(gap).chain(ticks).collect();
        if all.is_empty() { self.name.clone() } else { format!("{}: {}", self.name, all.join(", ")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_short_is_seen_to_be_short_and_what_is_cut_off_is_not_closed() {
        let row = |name: &str, spans: Vec<TimeSpan>, ticks: Vec<f64>, gap: Option<Gap>| SpanRow {
            name: name.into(),
            look: Look::series(0),
            spans,
            ticks,
            gap,
        };
        let chart = Spans {
            title: "Who is in the shared area".into(),
            from: 0.0,
            to: 8.0,
            rows: vec![
                row("walker <1>", vec![TimeSpan { from: Some(2.0), to: Some(3.0) }], vec![2.5], None),
                row("av", vec![TimeSpan { from: Some(3.5), to: None }], vec![3.75], None),
                row(
                    "pet 1.25 s",
                    vec![],
                    vec![],
                    Some(Gap { from: 2.5, to: 3.75, needed: Some(9.0), fails: true }),
                ),
            ],
            moment: Some(3.75),
        };
        let svg = chart.to_svg();
        assert!(!svg.contains("<1>") && !svg.contains("NaN"), "{svg}");
        assert!(svg.contains("av: 3.50 s to the end of the run, passing at 3.75 s"), "{svg}");
        assert!(
            svg.contains("class=\"gap short\"") && svg.contains("9.00 s would have been needed"),
            "{svg}"
        );
        // From 42 to 330 of the width, as plots over time: 2.5 s of 8 s is at 132.
        assert!(svg.contains("M132 ") && svg.contains("H330\""), "{svg}");
        // A height that the page's script takes its lines from.
        assert!(svg.contains(&format!("viewBox=\"0 0 340 {}\"", 38.0 + 3.0 * ROW + 44.0)), "{svg}");
    }
}
