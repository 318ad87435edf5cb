//! One plot: frame, axes, title, and the marks that every kind of chart is made of.

use super::look::Look;
use super::mark::PointMark;
use super::scale::{Scale, logarithmic_label, logarithmic_ticks, tick_label, ticks};
use super::svg::{At, Attribute, Svg, thinned, through};

/// What an axis says: a quantity and its unit, which is empty for plain numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AxisQuantity {
    pub name: String,
    pub unit: String,
}

impl AxisQuantity {
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into() }
    }

    pub fn label(&self) -> String {
        if self.unit.is_empty() { self.name.clone() } else { format!("{} ({})", self.name, self.unit) }
    }

    /// A value with its unit.
    pub fn show(&self, value: f64) -> String {
        let number = scenario::significant(value, 4);
        if self.unit.is_empty() { number } else { format!("{number} {}", self.unit) }
    }
}

/// A horizontal line to read values against, such as a criterion's bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    pub value: f64,
    pub label: String,
}

/// What lies along the horizontal axis.
#[derive(Debug, Clone, Copy)]
pub enum Axis<'a> {
    Numbers {
        range: (f64, f64),
    },
    /// Equal factors at equal distances; both ends positive.
    Logarithmic {
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
    left: f64,
    top: f64,
    height: f64,
    /// Pixels between two names of the horizontal axis.
    pub slot: f64,
    /// Names of rows with their heights in pixels: over whatever else is drawn, so that they can be read.
    rows: Vec<(String, f64)>,
}

/// Size in pixels; small enough to stand unscaled on a phone.
pub const WIDTH: f64 = 340.0;
const HEIGHT: f64 = 236.0;
const LEFT: f64 = 42.0;
const RIGHT: f64 = 10.0;
const TOP: f64 = 38.0;
const BOTTOM: f64 = 44.0;
/// Mean width of a letter at the chart's font size.
pub const LETTER: f64 = 6.2;
const LINE: f64 = 12.0;

impl Panel {
    /// An empty plot. `description` is for those who cannot see it.
    pub fn new(title: &str, description: &str, labels: (&str, &str), x: Axis, vertical: (f64, f64)) -> Self {
        Self::plot(title, (description, "img"), labels, x, vertical)
    }

    /// The same with [links](Self::link) in it, which who cannot see it gets to as well.
    pub fn with_links(
        title: &str,
        description: &str,
        labels: (&str, &str),
        x: Axis,
        vertical: (f64, f64),
    ) -> Self {
        Self::plot(title, (description, "group"), labels, x, vertical)
    }

    fn plot(
        title: &str,
        described: (&str, &str),
        labels: (&str, &str),
        x: Axis,
        vertical: (f64, f64),
    ) -> Self {
        let across = (LEFT, WIDTH - RIGHT);
        let (horizontal, x_scale) = match x {
            Axis::Numbers { range } | Axis::Values { range, .. } => (range, Scale::new(range, across)),
            Axis::Logarithmic { range } => (range, Scale::logarithmic(range, across)),
            Axis::Names(names) => {
                let range = (0.0, names.len().max(1) as f64);
                (range, Scale::new(range, across))
            }
        };
        let mut panel = Self {
            svg: Svg::default(),
            x: x_scale,
            y: Scale::new(vertical, (HEIGHT - BOTTOM, TOP)),
            left: LEFT,
            top: TOP,
            height: HEIGHT,
            slot: (WIDTH - LEFT - RIGHT) / horizontal.1.max(1.0),
            rows: Vec::new(),
        };
        panel.begin(title, described, labels);
        panel.draw_vertical_axis(vertical);
        match x {
            Axis::Names(names) => panel.draw_names(names),
            Axis::Values { values, .. } if values.len() <= 8 => panel.draw_ticks(values, tick_label),
            Axis::Numbers { .. } | Axis::Values { .. } => {
                panel.draw_ticks(&ticks(horizontal.0, horizontal.1, 7), tick_label)
            }
            Axis::Logarithmic { .. } => {
                panel.draw_ticks(&logarithmic_ticks(horizontal.0, horizontal.1), logarithmic_label)
            }
        }
        panel.draw_frame();
        panel
    }

    /// An empty plot of rows, one below the other and `row` pixels high, each under its name: the `index`th one from
    /// `index` to `index + 1` downwards.
    pub fn rows(
        title: &str,
        description: &str,
        label: &str,
        x: (f64, f64),
        names: &[String],
        row: f64,
    ) -> Self {
        // Without the line for the vertical axis's label.
        Self::rows_within(title, description, label, x, names, row, (8.0, TOP - LINE))
    }

    /// The same in the frame that plots over time have, so that what is said of one moment stands below each other.
    pub fn rows_over_time(title: &str, description: &str, x: (f64, f64), names: &[String], row: f64) -> Self {
        Self::rows_within(title, description, "time (s)", x, names, row, (LEFT, TOP))
    }

    fn rows_within(
        title: &str,
        description: &str,
        label: &str,
        x: (f64, f64),
        names: &[String],
        row: f64,
        (left, top): (f64, f64),
    ) -> Self {
        let height = top + names.len().max(1) as f64 * row + BOTTOM;
        let mut panel = Self {
            svg: Svg::default(),
            x: Scale::new(x, (left, WIDTH - RIGHT)),
            y: Scale::new((0.0, names.len().max(1) as f64), (top, height - BOTTOM)),
            left,
            top,
            height,
            slot: row,
            rows: Vec::new(),
        };
        panel.begin(title, (description, "img"), (label, ""));
        let places = ticks(x.0, x.1, 6);
        for tick in &places {
            let x = At(panel.x.at(*tick));
            let (top, bottom) = (At(top), At(height - BOTTOM));
            panel
                .svg
                .empty("line", &[("class", &"grid"), ("x1", &x), ("x2", &x), ("y1", &top), ("y2", &bottom)]);
        }
        panel.draw_ticks(&places, tick_label);
        let letters = ((WIDTH - left - RIGHT) / LETTER) as usize;
        for (index, name) in names.iter().enumerate() {
            panel.rows.push((shortened(name, letters), panel.y.at(index as f64) + LINE));
        }
        panel.draw_frame();
        panel
    }

    fn begin(&mut self, title: &str, (description, role): (&str, &str), labels: (&str, &str)) {
        let viewport = format!("0 0 {WIDTH} {}", self.height);
        let name = format!("{title}: {description}");
        self.svg.open(
            "svg",
            &[("class", &"chart"), ("viewBox", &viewport), ("role", &role), ("aria-label", &name)],
        );
        self.svg.label(
            &shortened(title, ((WIDTH - 8.0) / LETTER) as usize),
            &[("class", &"title"), ("x", &4), ("y", &13)],
        );
        if !labels.1.is_empty() {
            self.svg.label(labels.1, &[("class", &"muted"), ("x", &4), ("y", &28)]);
        }
        let middle = At((self.left + WIDTH - RIGHT) / 2.0);
        self.svg.label(
            labels.0,
            &[("class", &"muted"), ("x", &middle), ("y", &At(self.height - 4.0)), ("text-anchor", &"middle")],
        );
    }

    fn draw_vertical_axis(&mut self, vertical: (f64, f64)) {
        let (left, right) = (At(self.left), At(WIDTH - RIGHT));
        for tick in ticks(vertical.0, vertical.1, 5) {
            let y = self.y.at(tick);
            self.svg.empty(
                "line",
                &[("class", &"grid"), ("x1", &left), ("x2", &right), ("y1", &At(y)), ("y2", &At(y))],
            );
            self.svg.label(
                &tick_label(tick),
                &[("x", &At(self.left - 5.0)), ("y", &At(y + 4.0)), ("text-anchor", &"end")],
            );
        }
    }

    /// Where the labels of the horizontal axis stand.
    fn under(&self) -> f64 {
        self.height - BOTTOM + 14.0
    }

    fn draw_names(&mut self, names: &[String]) {
        let letters = ((self.slot - 4.0) / LETTER).max(1.0) as usize;
        // Where names would run into each other, only every so many are written.
        let every = if letters < 3 { (3.0 * LETTER / self.slot).ceil() as usize } else { 1 };
        for (index, name) in names.iter().enumerate().step_by(every) {
            let x = At(self.x.at(index as f64 + 0.5));
            for (row, part) in wrapped(name, letters * every).iter().enumerate() {
                let y = At(self.under() + row as f64 * (LINE - 1.0));
                self.svg.label(part, &[("x", &x), ("y", &y), ("text-anchor", &"middle")]);
            }
        }
    }

    fn draw_ticks(&mut self, places: &[f64], label: fn(f64) -> String) {
        let (bottom, under) = (At(self.height - BOTTOM), self.under());
        for tick in places {
            let x = At(self.x.at(*tick));
            self.svg.empty(
                "line",
                &[("class", &"tick"), ("x1", &x), ("x2", &x), ("y1", &bottom), ("y2", &At(under - 10.0))],
            );
            self.svg.label(&label(*tick), &[("x", &x), ("y", &At(under)), ("text-anchor", &"middle")]);
        }
    }

    fn draw_frame(&mut self) {
        let (left, right) = (At(self.left), At(WIDTH - RIGHT));
        let (top, bottom) = (At(self.top), At(self.height - BOTTOM));
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

    /// A run's line, under its key.
    pub fn run_line(&mut self, points: impl IntoIterator<Item = (f64, f64)>, look: Look, key: &str) {
        let places: Vec<_> = points.into_iter().map(|(x, y)| self.place(x, y)).collect();
        let (class, path) = (look.class("line"), through(thinned(&places)));
        let line: [Attribute; 3] = [("class", &class), ("d", &path), ("stroke-dasharray", &look.dash())];
        self.svg.titled("path", key, &[&line[..], &[("data-run", &key)]].concat());
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
        let path = through(thinned(&moved.collect::<Vec<_>>()));
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
        self.run_marker((x, y), aside, look, title, None);
    }

    /// The marker of a run with its key, if it is one's.
    pub fn run_marker(&mut self, (x, y): (f64, f64), aside: f64, look: Look, title: &str, run: Option<&str>) {
        let (x, y) = self.place(x, y);
        self.dot(&look.marker(x + aside, y), look, title, run);
    }

    /// A marker at its place in pixels.
    pub fn dot(&mut self, path: &str, look: Look, title: &str, run: Option<&str>) {
        let class = look.class("dot");
        let dot: [Attribute; 2] = [("class", &class), ("d", &path)];
        match &run {
            Some(key) => self.svg.titled("path", title, &[&dot[..], &[("data-run", key)]].concat()),
            None => self.svg.titled("path", title, &dot),
        }
    }

    /// A mark that leads to another place of the page, and says `title` when pointed at.
    pub fn link(&mut self, (x, y): (f64, f64), mark: PointMark, title: &str, target: &str) {
        let path = mark.path([self.place(x, y)]);
        self.svg.open("a", &[("href", &target), ("aria-label", &title)]);
        self.svg.titled("path", title, &[("class", &mark.class()), ("d", &path)]);
        self.svg.close();
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

    /// The marker of people in the colour of text, with a bar from `low` to `high`.
    pub fn people(&mut self, x: f64, [low, middle, high]: [f64; 3], aside: f64, look: Look, title: &str) {
        let (x, top) = self.place(x, high);
        let (_, bottom) = self.place(0.0, low);
        let (_, at) = self.place(0.0, middle);
        let bar = format!("M{} {}V{}", At(x + aside), At(top), At(bottom));
        self.svg.empty("path", &[("class", &"people-bar"), ("d", &bar)]);
        self.svg.titled("path", title, &[("class", &"people"), ("d", &look.marker(x + aside, at))]);
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
        if !(self.top - 0.5..=self.height - BOTTOM + 0.5).contains(&y) {
            return;
        }
        let path = format!("M{} {}H{}", At(self.left), At(y), At(WIDTH - RIGHT));
        self.svg.empty("path", &[("class", &"rule"), ("d", &path)]);
        // Above the line, unless that is outside of the plot.
        let beside = if y < self.top + LINE { LINE - 2.0 } else { -3.0 };
        self.svg.label(
            &rule.label,
            &[
                ("class", &"rule-label"),
                ("x", &At(WIDTH - RIGHT)),
                ("y", &At(y + beside)),
                ("text-anchor", &"end"),
            ],
        );
    }

    /// A vertical line across the plot with its label above it.
    pub fn upright(&mut self, x: f64, label: &str, class: &str) {
        let (x, _) = self.place(x, 0.0);
        let path = format!("M{} {}V{}", At(x), At(self.top), At(self.height - BOTTOM));
        self.svg.empty("path", &[("class", &class), ("d", &path)]);
        if !label.is_empty() {
            let class = format!("{class}-label");
            // Labels near an edge grow away from it.
            let anchor = match x {
                _ if x < 50.0 => "start",
                _ if x > WIDTH - 50.0 => "end",
                _ => "middle",
            };
            self.svg.label(
                label,
                &[("class", &class), ("x", &At(x)), ("y", &At(self.top - 3.0)), ("text-anchor", &anchor)],
            );
        }
    }

    /// A pale area over the whole height between two places.
    pub fn shade(&mut self, from: f64, to: f64) {
        let (from, to) = (At(self.place(from, 0.0).0), At(self.place(to, 0.0).0));
        let path = format!("M{from} {}H{to}V{}H{from}z", At(self.top), At(self.height - BOTTOM));
        self.svg.empty("path", &[("class", &"unlikely"), ("d", &path)]);
    }

    /// Many marks of one kind in one element; what has no value stands at the upper edge.
    pub fn marks(&mut self, points: impl IntoIterator<Item = (f64, Option<f64>)>, mark: PointMark) {
        let edge = self.top + 5.0;
        let places: Vec<(f64, f64)> =
            points.into_iter().map(|(x, y)| (self.x.at(x), y.map_or(edge, |y| self.y.at(y)))).collect();
        if !places.is_empty() {
            self.svg.empty("path", &[("class", &mark.class()), ("d", &mark.path(places))]);
        }
    }

    /// A [band](Self::band) whose edges have so many points that some can be left out.
    pub fn smooth_band(&mut self, points: &[(f64, f64, f64)], look: Look) {
        let low: Vec<_> = points.iter().map(|(x, low, _)| self.place(*x, *low)).collect();
        let high: Vec<_> = points.iter().rev().map(|(x, _, high)| self.place(*x, *high)).collect();
        let path = through(thinned(&low).into_iter().chain(thinned(&high))) + "z";
        self.svg.empty("path", &[("class", &look.class("band")), ("d", &path)]);
    }

    /// The area between two lines that may have their points at different places.
    pub fn area(&mut self, low: &[(f64, f64)], high: &[(f64, f64)], look: Look) {
        let there = low.iter().map(|(x, y)| self.place(*x, *y));
        let back = high.iter().rev().map(|(x, y)| self.place(*x, *y));
        let path = through(there.chain(back)) + "z";
        self.svg.empty("path", &[("class", &look.class("band")), ("d", &path)]);
    }

    /// A value that has no neighbours to draw a line to.
    pub fn dash(&mut self, x: f64, y: f64, look: Look, title: &str) {
        let (x, y) = self.place(x, y);
        let path = format!("M{} {}H{}", At(x - 1.5), At(y), At(x + 1.5));
        self.svg.titled("path", title, &[("class", &look.class("line")), ("d", &path)]);
    }

    /// A few words above a place, to its left where there is room, and clear of the labels of lines across.
    pub fn note(&mut self, x: f64, y: f64, content: &str, look: Look, rules: &[Rule]) {
        let (x, y) = self.place(x, y);
        let width = content.chars().count() as f64 * LETTER;
        let (x, anchor) = if x - width > self.left {
            (x - 6.0, "end")
        } else if x + width < WIDTH - RIGHT {
            (x + 6.0, "start")
        } else {
            (WIDTH - RIGHT, "end")
        };
        // Where it covers neither a rule nor its label, if there is such a place.
        let is_free = |at: &f64| {
            let covers = |rule: &Rule| (-LINE - 2.0..LINE).contains(&(at - self.y.at(rule.value)));
            *at >= self.top + LINE && *at < self.height - BOTTOM && !rules.iter().any(covers)
        };
        let places = [-6.0, -18.0, 14.0, -30.0, 26.0].map(|away| y + away);
        let y = places.into_iter().find(is_free).unwrap_or_else(|| (y - 6.0).max(self.top + LINE));
        self.svg.label(
            content,
            &[("class", &look.class("name")), ("x", &At(x)), ("y", &At(y)), ("text-anchor", &anchor)],
        );
    }

    /// A small name left of a place.
    pub fn name(&mut self, x: f64, y: f64, content: &str, look: Look) {
        let (x, y) = self.place(x, y);
        self.svg.label(
            content,
            &[
                ("class", &look.class("name")),
                ("x", &At(x - 3.0)),
                ("y", &At(y + 3.5)),
                ("text-anchor", &"end"),
            ],
        );
    }

    /// A path of its own in pixels.
    pub fn shape(&mut self, class: &str, path: &str, title: &str) {
        self.svg.titled("path", title, &[("class", &class), ("d", &path)]);
    }

    /// A thin cross hair through a place, such as the conflict point.
    pub fn cross_hair(&mut self, x: f64, y: f64) {
        let (x, y) = self.place(x, y);
        let path = format!(
            "M{} {}H{}M{} {}V{}",
            At(self.left),
            At(y),
            At(WIDTH - RIGHT),
            At(x),
            At(self.top),
            At(self.height - BOTTOM)
        );
        self.svg.empty("path", &[("class", &"hair"), ("d", &path)]);
    }

    /// A small remark above the plot, centred at `x`.
    pub fn remark(&mut self, x: f64, content: &str) {
        let (x, _) = self.place(x, 0.0);
        self.svg.label(
            content,
            &[("class", &"remark"), ("x", &At(x)), ("y", &At(self.top - 3.0)), ("text-anchor", &"middle")],
        );
    }

    /// What is drawn from here on is cut off at the frame until [`Self::unclip`].
    pub fn clip(&mut self) {
        let (left, top) = (At(self.left), At(self.top));
        let (width, height) = (At(WIDTH - self.left - RIGHT), At(self.height - self.top - BOTTOM));
        let viewport = format!("{left} {top} {width} {height}");
        self.svg.open(
            "svg",
            &[
                ("x", &left),
                ("y", &top),
                ("width", &width),
                ("height", &height),
                ("viewBox", &viewport),
                ("overflow", &"hidden"),
            ],
        );
    }

    pub fn unclip(&mut self) {
        self.svg.close();
    }

    pub fn finish(mut self) -> String {
        let x = At(self.left + 2.0);
        for (name, y) in &self.rows {
            self.svg.label(name, &[("class", &"row"), ("x", &x), ("y", &At(*y))]);
        }
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
