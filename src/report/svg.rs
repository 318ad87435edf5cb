//! SVG as text: elements in order, attributes escaped, coordinates in a tenth of a pixel.

use std::fmt::{Display, Formatter, Result, Write};

use files::escape::html;

/// Breaks a text between words into lines of at most so many characters, where its words allow it; `indent` begins each line but the first.
pub fn wrapped(text: &str, characters: usize, indent: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_inclusive(' ') {
        let last = lines.last_mut().expect("there is one");
        if last.chars().count() + word.chars().count() > characters && !last.trim().is_empty() {
            lines.push(format!("{indent}{word}"));
        } else {
            last.push_str(word);
        }
    }
    lines
}

/// A growing piece of SVG.
#[derive(Debug, Default)]
pub struct Svg {
    text: String,
    open: Vec<&'static str>,
}

/// An attribute: its name and what it is set to.
pub type Attribute<'a> = (&'static str, &'a dyn Display);

impl Svg {
    /// The beginning of a file of this width and height in pixels, as wide as its page up to 960 pixels, on a background with the class
    /// `paper`. `label` is for readers that cannot see it.
    pub fn file((width, height): (f64, f64), label: &str, style: &str) -> Self {
        let mut svg = Self::default();
        let view = format!("0 0 {} {}", At(width), At(height));
        svg.open(
            "svg",
            &[
                ("xmlns", &"http://www.w3.org/2000/svg"),
                ("viewBox", &view),
                ("width", &"100%"),
                ("style", &"max-width:960px"),
                ("role", &"img"),
                ("aria-label", &label),
            ],
        );
        svg.verbatim("style", style);
        svg.empty("rect", &[("class", &"paper"), ("width", &At(width)), ("height", &At(height))]);
        svg
    }

    /// Begins an element; [`Self::close`] ends it.
    pub fn open(&mut self, name: &'static str, attributes: &[Attribute]) {
        self.tag(name, attributes);
        self.text.push_str(">\n");
        self.open.push(name);
    }

    pub fn close(&mut self) {
        let name = self.open.pop().expect("every close follows its open");
        self.push(format_args!("</{name}>\n"));
    }

    /// An element without content.
    pub fn empty(&mut self, name: &'static str, attributes: &[Attribute]) {
        self.tag(name, attributes);
        self.text.push_str("/>\n");
    }

    /// An element with text in it that is ours, such as a style sheet.
    pub fn verbatim(&mut self, name: &'static str, content: &str) {
        self.push(format_args!("<{name}>\n{content}</{name}>\n"));
    }

    /// A `text` element.
    pub fn label(&mut self, content: &str, attributes: &[Attribute]) {
        self.tag("text", attributes);
        self.push(format_args!(">{}</text>\n", Escaped(&content)));
    }

    /// An element that says `title` when pointed at.
    pub fn titled(&mut self, name: &'static str, title: &str, attributes: &[Attribute]) {
        if title.is_empty() {
            return self.empty(name, attributes);
        }
        self.tag(name, attributes);
        self.push(format_args!("><title>{}</title></{name}>\n", Escaped(&title)));
    }

    /// Another piece of SVG at a place, in a frame of a size.
    pub fn frame(&mut self, (x, y): (f64, f64), (width, height): (f64, f64), piece: &str) {
        let place = [("x", At(x)), ("y", At(y)), ("width", At(width)), ("height", At(height))];
        let place: Vec<Attribute> = place.iter().map(|(name, at)| (*name, at as &dyn Display)).collect();
        self.open("svg", &place);
        self.text.push_str(piece);
        self.close();
    }

    pub fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.text
    }

    fn tag(&mut self, name: &str, attributes: &[Attribute]) {
        self.push(format_args!("<{name}"));
        for (name, value) in attributes {
            self.push(format_args!(" {name}=\"{}\"", Escaped(value)));
        }
    }

    fn push(&mut self, text: std::fmt::Arguments) {
        self.text.write_fmt(text).expect("writing to a string cannot fail");
    }
}

/// Text that can stand in markup.
struct Escaped<'a>(&'a dyn Display);

impl Display for Escaped<'_> {
    fn fmt(&self, out: &mut Formatter<'_>) -> Result {
        out.write_str(&html(&self.0.to_string()))
    }
}

/// A coordinate in pixels, shown to a tenth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct At(pub f64);

impl Display for At {
    fn fmt(&self, out: &mut Formatter<'_>) -> Result {
        let tenths = (self.0 * 10.0).round() / 10.0;
        // Adding zero turns the negative zero into a plain one.
        write!(out, "{}", tenths + 0.0)
    }
}

/// The path through `points`, in pixels.
pub fn through(points: impl IntoIterator<Item = (f64, f64)>) -> String {
    let mut path = String::new();
    for (index, (x, y)) in points.into_iter().enumerate() {
        let step = if index == 0 { 'M' } else { 'L' };
        write!(path, "{step}{} {}", At(x), At(y)).expect("writing to a string cannot fail");
    }
    path
}

/// As few of `points`, in pixels, as make nearly the same line: Douglas and Peucker's choice, to a fifth of a pixel.
pub fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    const TOLERANCE: f64 = 0.2;
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Vec::new() };
    let mut kept = vec![*first];
    // Stretches that are still to be looked at, the next one last.
    let mut stretches = vec![(0, points.len() - 1)];
    while let Some((from, to)) = stretches.pop() {
        let far = |index: &usize| from_line(points[*index], points[from], points[to]);
        let farthest = (from + 1..to).max_by(|left, right| far(left).total_cmp(&far(right)));
        match farthest.filter(|index| far(index) > TOLERANCE) {
            Some(index) => stretches.extend([(index, to), (from, index)]),
            None if to > from => kept.push(points[to]),
            None => {}
        }
    }
    debug_assert_eq!(kept.last(), Some(last));
    kept
}

/// Distance of a point from the line between two others.
fn from_line(point: (f64, f64), from: (f64, f64), to: (f64, f64)) -> f64 {
    let (along, up) = (to.0 - from.0, to.1 - from.1);
    let (right, above) = (point.0 - from.0, point.1 - from.1);
    let length = libm::hypot(along, up);
    if length == 0.0 { libm::hypot(right, above) } else { (right * up - above * along).abs() / length }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_line_keeps_its_corners() {
        let corner: Vec<(f64, f64)> = (0..=20).map(f64::from).map(|x| (x, (x - 10.0).abs())).collect();
        assert_eq!(thinned(&corner), [(0.0, 10.0), (10.0, 0.0), (20.0, 10.0)]);
        assert_eq!(thinned(&corner[..1]), [(0.0, 10.0)]);
        assert_eq!(thinned(&[]), []);
    }

    #[test]
    fn markup_in_names_stays_text() {
        let mut svg = Svg::default();
        svg.open("g", &[("class", &"\"><script>")]);
        svg.label("a < b & c\u{7}", &[("x", &At(-0.04))]);
        let text = svg.finish();
        assert_eq!(
            text,
            "<g class=\"&quot;&gt;&lt;script&gt;\">\n<text x=\"0\">a &lt; b &amp; c\\u{7}</text>\n</g>\n"
        );
    }
}
