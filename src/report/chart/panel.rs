//! One plot: frame, axes, title, and the marks that every kind of chart is made of.

use super::look::Look;
use super::scale::{Scale, tick_label, ticks};
use super::svg::{At, Svg, through};

/// What an axis says: a quantity and its unit, which is empty for plain numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Quantity {
    pub name: String,
    pub unit: String,
}

impl Quantity {
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into() }
    }

    pub fn label(&self) -> String {
        if self.unit.is_empty() { self.name.clone() } else { format!("{} ({})", self.name, self.unit) }
    }

    /// A value with its unit.
    pub fn show(&self, value: f64) -> String {
        let number = crate::scenario::significant(value, 4);
        if self.unit.is_empty() { number } else { format!("{number} {}", self.unit) }
    }
}

/// A horizontal line to read values against, such as a criterion's bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    pub value: f64,
    pub label: String,
}

/// What lies along an axis.
#[derive(Debug, Clone, Copy)]
pub enum Axis<'a> {
    Numbers {
        range: (f64, f64),
    },
    /// Ticks exactly at these values.
    Values {
        range: (f64, f64),
        values: &'a [f64],
    },
    /// Equal places side by side.
    Names(&'a [String]),
}

/// A plot in the making.
pub struct Panel {
    svg: Svg,
    x: Scale,
    y: Scale,
    /// Pixels between two names of the horizontal axis.
    pub slot: f64,
}

/// Size in pixels; small enough to stand unscaled on a phone.
pub const WIDTH: f64 = 340.0;
const HEIGHT: f64 = 236.0;
const LEFT: f64 = 42.0;
const RIGHT: f64 = 10.0;
const TOP: f64 = 38.0;
const BOTTOM: f64 = 44.0;
/// Mean width of a letter at the chart's font size.
const LETTER: f64 = 6.2;
const LINE: f64 = 12.0;

impl Panel {
    /// An empty plot. `description` is for those who cannot see it.
    pub fn new(title: &str, description: &str, labels: (&str, &str), x: Axis, vertical: (f64, f64)) -> Self {
        let mut svg = Svg::default();
        let viewport = format!("0 0 {WIDTH} {HEIGHT}");
        let name = format!("{title}: {description}");
        svg.open(
            "svg",
            &[("class", &"chart"), ("viewBox", &viewport), ("role", &"img"), ("aria-label", &name)],
        );
        svg.label(
            &shortened(title, ((WIDTH - 8.0) / LETTER) as usize),
            &[("class", &"title"), ("x", &4), ("y", &13)],
        );
        svg.label(labels.1, &[("class", &"muted"), ("x", &4), ("y", &29)]);
        let middle = At((LEFT + WIDTH - RIGHT) / 2.0);
        svg.label(
            labels.0,
            &[("class", &"muted"), ("x", &middle), ("y", &At(HEIGHT - 4.0)), ("text-anchor", &"middle")],
        );
        let horizontal = match x {
            Axis::Numbers { range } | Axis::Values { range, .. } => range,
            Axis::Names(names) => (0.0, names.len().max(1) as f64),
        };
        let mut panel = Self {
            svg,
            x: Scale::new(horizontal, (LEFT, WIDTH - RIGHT)),
            y: Scale::new(vertical, (HEIGHT - BOTTOM, TOP)),
            slot: (WIDTH - LEFT - RIGHT) / horizontal.1.max(1.0),
        };
        panel.draw_axes(x, horizontal, vertical);
        panel
    }

    fn draw_axes(&mut self, x: Axis, horizontal: (f64, f64), vertical: (f64, f64)) {
        let (left, right, top, bottom) = (At(LEFT), At(WIDTH - RIGHT), At(TOP), At(HEIGHT - BOTTOM));
        for tick in ticks(vertical.0, vertical.1, 5) {
            let y = self.y.at(tick);
            self.svg.empty(
                "line",
                &[("class", &"grid"), ("x1", &left), ("x2", &right), ("y1", &At(y)), ("y2", &At(y))],
            );
            self.svg.label(
                &tick_label(tick),
                &[("x", &At(LEFT - 5.0)), ("y", &At(y + 4.0)), ("text-anchor", &"end")],
            );
        }
        let under = HEIGHT - BOTTOM + 14.0;
        match x {
            Axis::Names(names) => {
                let letters = ((self.slot - 4.0) / LETTER).max(1.0) as usize;
                // Where names would run into each other, only every so many are written.
                let every = if letters < 3 { (3.0 * LETTER / self.slot).ceil() as usize } else { 1 };
                for (index, name) in names.iter().enumerate().step_by(every) {
                    let x = At(self.x.at(index as f64 + 0.5));
                    for (row, part) in wrapped(name, letters * every).iter().enumerate() {
                        let y = At(under + row as f64 * (LINE - 1.0));
                        self.svg.label(part, &[("x", &x), ("y", &y), ("text-anchor", &"middle")]);
                    }
                }
            }
            Axis::Numbers { .. } | Axis::Values { .. } => {
                let places = match x {
                    Axis::Values { values, .. } if values.len() <= 8 => values.to_vec(),
                    _ => ticks(horizontal.0, horizontal.1, 6),
                };
                for tick in places {
                    let x = At(self.x.at(tick));
                    self.svg.empty(
                        "line",
                        &[
                            ("class", &"tick"),
                            ("x1", &x),
                            ("x2", &x),
                            ("y1", &bottom),
                            ("y2", &At(under - 10.0)),
                        ],
                    );
                    self.svg.label(
                        &tick_label(tick),
                        &[("x", &x), ("y", &At(under)), ("text-anchor", &"middle")],
                    );
                }
            }
        }
        self.svg.empty("path", &[("class", &"axis"), ("d", &format!("M{left} {top}V{bottom}H{right}"))]);
    }

    /// Where data lies, in pixels.
    pub fn place(&self, x: f64, y: f64) -> (f64, f64) {
        (self.x.at(x), self.y.at(y))
    }

    /// A line through data points.
    pub fn line(&mut self, points: impl IntoIterator<Item = (f64, f64)>, look: Look, title: &str) {
        self.line_aside(points, 0.0, look, title);
    }

    /// A line through data points, moved sideways by `aside` pixels.
    pub fn line_aside(
        &mut self,
        points: impl IntoIterator<Item = (f64, f64)>,
        aside: f64,
        look: Look,
        title: &str,
    ) {
        let moved = points.into_iter().map(|(x, y)| self.place(x, y)).map(|(x, y)| (x + aside, y));
        let path = through(moved);
        let class = look.class("line");
        self.svg.titled(
            "path",
            title,
            &[("class", &class), ("d", &path), ("stroke-dasharray", &look.dash())],
        );
    }

    /// The area between two lines over the same places: `(x, low, high)`.
    pub fn band(&mut self, points: &[(f64, f64, f64)], look: Look) {
        let there = points.iter().map(|(x, low, _)| self.place(*x, *low));
        let back = points.iter().rev().map(|(x, _, high)| self.place(*x, *high));
        let path = through(there.chain(back)) + "z";
        self.svg.empty("path", &[("class", &look.class("band")), ("d", &path)]);
    }

    /// A marker, moved sideways by `aside` pixels.
    pub fn marker(&mut self, x: f64, y: f64, aside: f64, look: Look, title: &str) {
        let (x, y) = self.place(x, y);
        let path = look.marker(x + aside, y);
        self.svg.titled("path", title, &[("class", &look.class("dot")), ("d", &path)]);
    }

    /// A vertical bar from `low` to `high` with caps.
    pub fn interval(&mut self, x: f64, low: f64, high: f64, aside: f64, look: Look) {
        let (x, top) = self.place(x, high);
        let (_, bottom) = self.place(x, low);
        let (x, top, bottom) = (x + aside, At(top), At(bottom));
        let (left, right) = (At(x - 3.0), At(x + 3.0));
        let path = format!("M{left} {top}H{right}M{left} {bottom}H{right}M{} {bottom}V{top}", At(x));
        self.svg.empty("path", &[("class", &look.class("whisker")), ("d", &path)]);
    }

    /// A box from `low` to `high` of a width in pixels, with a line at `middle`.
    pub fn quartiles(&mut self, x: f64, (low, middle, high): (f64, f64, f64), width: f64, title: &str) {
        let (x, top) = self.place(x, high);
        let (_, bottom) = self.place(0.0, low);
        let (_, line) = self.place(0.0, middle);
        let (left, right) = (At(x - width / 2.0), At(x + width / 2.0));
        let (top, bottom, line) = (At(top), At(bottom), At(line));
        let path = format!("M{left} {top}H{right}V{bottom}H{left}zM{left} {line}H{right}");
        self.svg.titled("path", title, &[("class", &"box"), ("d", &path)]);
    }

    /// An outline whose half width in pixels is given at data heights: `(y, half width)`.
    pub fn violin(&mut self, x: f64, outline: &[(f64, f64)]) {
        let there = outline.iter().map(|(y, half)| (self.place(x, *y), half));
        let right = there.clone().map(|((x, y), half)| (x + half, y));
        let left = there.rev().map(|((x, y), half)| (x - half, y));
        let path = through(right.chain(left)) + "z";
        self.svg.empty("path", &[("class", &"violin"), ("d", &path)]);
    }

    /// A horizontal line across the plot with its label at the right end.
    pub fn rule(&mut self, rule: &Rule) {
        let y = self.y.at(rule.value);
        if !(TOP - 0.5..=HEIGHT - BOTTOM + 0.5).contains(&y) {
            return;
        }
        let path = format!("M{} {}H{}", At(LEFT), At(y), At(WIDTH - RIGHT));
        self.svg.empty("path", &[("class", &"rule"), ("d", &path)]);
        self.svg.label(
            &rule.label,
            &[
                ("class", &"rule-label"),
                ("x", &At(WIDTH - RIGHT)),
                ("y", &At(y - 3.0)),
                ("text-anchor", &"end"),
            ],
        );
    }

    /// A thin cross hair through a place, such as the conflict point.
    pub fn cross_hair(&mut self, x: f64, y: f64) {
        let (x, y) = self.place(x, y);
        let path = format!(
            "M{} {}H{}M{} {}V{}",
            At(LEFT),
            At(y),
            At(WIDTH - RIGHT),
            At(x),
            At(TOP),
            At(HEIGHT - BOTTOM)
        );
        self.svg.empty("path", &[("class", &"hair"), ("d", &path)]);
    }

    /// A small remark above the plot, centred at `x`.
    pub fn remark(&mut self, x: f64, content: &str) {
        let (x, _) = self.place(x, 0.0);
        self.svg.label(
            content,
            &[("class", &"remark"), ("x", &At(x)), ("y", &At(TOP - 3.0)), ("text-anchor", &"middle")],
        );
    }

    /// What is drawn from here on is cut off at the frame until [`Self::unclip`].
    pub fn clip(&mut self) {
        let (width, height) = (WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM);
        let viewport = format!("{LEFT} {TOP} {width} {height}");
        self.svg.open(
            "svg",
            &[
                ("x", &At(LEFT)),
                ("y", &At(TOP)),
                ("width", &At(width)),
                ("height", &At(height)),
                ("viewBox", &viewport),
                ("overflow", &"hidden"),
            ],
        );
    }

    pub fn unclip(&mut self) {
        self.svg.close();
    }

    pub fn finish(self) -> String {
        self.svg.finish()
    }
}

/// At most `letters` letters, the last an ellipsis where something is missing.
pub fn shortened(text: &str, letters: usize) -> String {
    if text.chars().count() <= letters {
        return text.to_string();
    }
    let mut short: String = text.chars().take(letters.saturating_sub(1)).collect();
    short.push('…');
    short
}

/// Up to two lines, broken at spaces and underscores.
fn wrapped(text: &str, letters: usize) -> Vec<String> {
    if text.chars().count() <= letters {
        return vec![text.to_string()];
    }
    let breaks = text.char_indices().filter(|(_, letter)| matches!(letter, ' ' | '_' | ',' | '-' | '/'));
    let mut fitting = breaks.filter(|(index, _)| text[..=*index].chars().count() <= letters);
    match fitting.next_back() {
        Some((index, _)) => {
            vec![text[..=index].trim().to_string(), shortened(text[index + 1..].trim(), letters)]
        }
        None => vec![shortened(text, letters)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_broken_or_cut() {
        assert_eq!(wrapped("6 s", 8), ["6 s"]);
        assert_eq!(wrapped("tuned on low-PET", 9), ["tuned on", "low-PET"]);
        assert_eq!(wrapped("commotions_carla", 11), ["commotions_", "carla"]);
        assert_eq!(wrapped("incomprehensible", 6), ["incom…"]);
    }
}
