//! Sketches as text: a cell of the terminal is twice as high as it is wide.

use nalgebra::Vector2;

use super::picture::{Picture, Sketch};
use super::plane::{Frame, MarkKind, corners};
use super::road::{crossing_areas, world_marks};
use files::escape::terminal_line;
use scenario::World;

/// A picture is at least so large, columns and rows.
const LEAST: (usize, usize) = (40, 8);

/// Text that is no wider than so many columns, and no higher than so many rows where that is possible.
pub(crate) fn to_text(sketch: &Sketch, world: &World, columns: usize, rows: usize) -> String {
    let columns = columns.max(LEAST.0);
    let facts: Vec<String> =
        sketch.facts.iter().flat_map(|fact| wrapped(&terminal_line(fact), columns)).collect();
    let beside = 3 + facts.len() + 3 * sketch.pictures.len();
    let each = rows.saturating_sub(beside) / sketch.pictures.len().max(1);
    let mut text = format!("{}\n", terminal_line(&sketch.title));
    for picture in &sketch.pictures {
        let canvas = draw(sketch, world, picture, columns, each.max(LEAST.1));
        text.push_str(&canvas.to_text());
        for line in wrapped(&terminal_line(&picture.caption), columns) {
            text.push_str(&format!("{line}\n"));
        }
        for line in wrapped(&legend(world, picture, &sketch.frame), columns) {
            text.push_str(&format!("{line}\n"));
        }
    }
    for fact in facts {
        text.push_str(&format!("{fact}\n"));
    }
    text
}

/// The only picture of a sketch and who is who, without empty rows around it.
pub(super) fn moment(sketch: &Sketch, world: &World, columns: usize, rows: usize) -> Vec<String> {
    let picture = &sketch.pictures[0];
    let text = draw(sketch, world, picture, columns, rows).to_text();
    let mut lines: Vec<String> = text.lines().map(str::to_string).collect();
    let is_drawn = |line: &String| !line.is_empty();
    lines.truncate(lines.iter().rposition(is_drawn).map_or(0, |last| last + 1));
    lines.drain(..lines.iter().position(is_drawn).unwrap_or(0));
    lines.extend(wrapped(&legend(world, picture, &sketch.frame), columns));
    lines
}

/// As many words of a line as fit, and the rest below.
fn wrapped(line: &str, columns: usize) -> Vec<String> {
    let indent: String = line.chars().take_while(|one| *one == ' ').collect();
    let mut lines = vec![String::new()];
    for word in line.split_inclusive(' ') {
        let last = lines.last_mut().expect("there is one");
        if last.chars().count() + word.trim_end().chars().count() > columns && !last.trim().is_empty() {
            lines.push(format!("{indent}    {word}"));
        } else {
            last.push_str(word);
        }
    }
    lines.into_iter().map(|line| line.trim_end().to_string()).collect()
}

/// Which character stands for whom.
fn letter(world: &World, who: usize) -> char {
    let cars = world.vehicles.len();
    let (first, index) = if who < cars { (b'A', who) } else { (b'1', who - cars) };
    let last = if who < cars { 26 } else { 9 };
    if index < last { (first + index as u8) as char } else { '#' }
}

fn legend(world: &World, picture: &Picture, frame: &Frame) -> String {
    let mut parts: Vec<String> = Vec::new();
    for label in picture.labels(world, frame) {
        let who = letter(world, label.who);
        let name = terminal_line(&label.name);
        parts.push(match label.outside {
            true => format!("{who} {name} ({} {:.0} m beyond the edge)", label.arrow, label.beyond),
            false => format!("{who} {name}"),
        });
    }
    if !world.road.boxes.is_empty() {
        parts.push("█ box".to_string());
    }
    if let Some(outlook) = &picture.outlook {
        parts.push("o goal".to_string());
        if !outlook.meetings.is_empty() {
            parts.push("× courses meet".to_string());
        }
        if outlook.sights.iter().any(|sight| !sight.hidden_by.is_empty()) {
            parts.push(": hidden".to_string());
        }
    }
    parts.join("   ")
}

struct Canvas {
    columns: usize,
    cells: Vec<char>,
    frame: Frame,
    /// Of a cell, m.
    width: f64,
}

impl Canvas {
    fn new(frame: Frame, columns: usize, rows: usize) -> Self {
        let size = frame.size();
        let width = (size.x / columns as f64).max(size.y / (2.0 * rows as f64));
        let (columns, rows) =
            ((size.x / width).ceil().max(1.0) as usize, (size.y / (2.0 * width)).ceil().max(1.0) as usize);
        Self { columns, cells: vec![' '; columns * rows], frame, width }
    }

    fn rows(&self) -> usize {
        self.cells.len() / self.columns
    }

    fn cell(&self, point: Vector2<f64>) -> Option<usize> {
        if !self.frame.holds(point) {
            return None;
        }
        let column = (((point.x - self.frame.low.x) / self.width) as usize).min(self.columns - 1);
        let row = (((self.frame.high.y - point.y) / (2.0 * self.width)) as usize).min(self.rows() - 1);
        Some(row * self.columns + column)
    }

    /// In the middle of a cell, m.
    fn middle(&self, cell: usize) -> Vector2<f64> {
        let (row, column) = (cell / self.columns, cell % self.columns);
        Vector2::new(
            self.frame.low.x + (column as f64 + 0.5) * self.width,
            self.frame.high.y - (row as f64 + 0.5) * 2.0 * self.width,
        )
    }

    fn put(&mut self, point: Vector2<f64>, what: char) {
        if let Some(cell) = self.cell(point) {
            self.cells[cell] = what;
        }
    }

    /// Every cell whose middle is inside, and that of the area's own middle.
    fn fill(&mut self, points: &[Vector2<f64>], what: char) {
        for cell in 0..self.cells.len() {
            if inside(points, self.middle(cell)) {
                self.cells[cell] = what;
            }
        }
        let middle = points.iter().sum::<Vector2<f64>>() / points.len().max(1) as f64;
        self.put(middle, what);
    }

    /// Along a chain of chords; `what` says how a cell looks that a line of this direction passes.
    fn line(&mut self, points: &[Vector2<f64>], what: impl Fn(Vector2<f64>, usize) -> Option<char>) {
        for pair in points.windows(2) {
            let way = pair[1] - pair[0];
            let steps = (way.norm() / (self.width / 2.0)).ceil().clamp(1.0, 1e5) as usize;
            for step in 0..=steps {
                let point = pair[0] + way * (step as f64 / steps as f64);
                if let Some(cell) = self.cell(point)
                    && let Some(what) = what(way, cell)
                {
                    self.cells[cell] = what;
                }
            }
        }
    }

    fn to_text(&self) -> String {
        let mut text = String::new();
        for row in self.cells.chunks(self.columns) {
            let line: String = row.iter().collect();
            text.push_str(line.trim_end());
            text.push('\n');
        }
        text
    }
}

/// Whether a point is inside an area: by how often a ray from it crosses the border.
fn inside(points: &[Vector2<f64>], point: Vector2<f64>) -> bool {
    let mut inside = false;
    for (index, one) in points.iter().enumerate() {
        let other = points[(index + 1) % points.len()];
        if (one.y > point.y) != (other.y > point.y)
            && point.x < one.x + (point.y - one.y) / (other.y - one.y) * (other.x - one.x)
        {
            inside = !inside;
        }
    }
    inside
}

/// A line in this direction.
fn stroke(way: Vector2<f64>) -> char {
    match (way.x.abs(), way.y.abs()) {
        (x, y) if y < 0.4 * x => '─',
        (x, y) if x < 0.4 * y => '│',
        _ if way.x * way.y > 0.0 => '╱',
        _ => '╲',
    }
}

/// Where a lane's traffic goes.
fn arrow(heading: Vector2<f64>) -> char {
    let eighth = (libm::atan2(heading.y, heading.x) / std::f64::consts::FRAC_PI_4).round() as i32;
    ['→', '↗', '↑', '↖', '←', '↙', '↓', '↘'][eighth.rem_euclid(8) as usize]
}

fn draw(sketch: &Sketch, world: &World, picture: &Picture, columns: usize, rows: usize) -> Canvas {
    let mut canvas = Canvas::new(sketch.frame, columns, rows);
    let marks = world_marks(world, sketch.reach.0, sketch.reach.1);
    for crossing in crossing_areas(&world.road) {
        canvas.fill(&crossing, '░');
    }
    let of = |kind: MarkKind| marks.iter().filter(move |mark| mark.kind == kind);
    for lane in of(MarkKind::Lane) {
        let columns = canvas.columns;
        let crossing = canvas.cells.clone();
        canvas.line(&lane.points, |way, cell| {
            let dash = !(cell / columns + cell % columns).is_multiple_of(3);
            (dash && crossing[cell] == ' ').then(|| stroke(way))
        });
    }
    for median in of(MarkKind::Median) {
        let (one, other) = median.points.split_at(median.points.len() / 2);
        [one, other].iter().for_each(|edge| canvas.line(edge, |way, _| Some(stroke(way))));
    }
    for kerb in of(MarkKind::Kerb) {
        canvas.line(&kerb.points, |way, _| Some(stroke(way)));
    }
    for (point, heading) in &sketch.arrows {
        canvas.put(*point, arrow(*heading));
    }
    for line in of(MarkKind::StopLine) {
        canvas.line(&line.points, |_, _| Some('|'));
    }
    for block in of(MarkKind::Block) {
        canvas.fill(&block.points, '█');
    }
    if let Some(outlook) = &picture.outlook {
        for person in &outlook.people {
            canvas.line(&[person.outline.centre, person.goal], |_, _| Some('·'));
            canvas.put(person.goal, 'o');
        }
        for sight in outlook.sights.iter().filter(|sight| !sight.hidden_by.is_empty()) {
            canvas.line(&[sight.from, sight.to], |_, _| Some(':'));
        }
        for met in &outlook.meetings {
            canvas.put(met.point, '×');
        }
    }
    for body in picture.bodies.iter().flatten() {
        canvas.line(&body.trail, |_, _| Some('·'));
    }
    for (who, body) in picture.bodies.iter().enumerate() {
        if let Some(body) = body {
            let who = letter(world, who);
            // Whoever is outside is not drawn at its edge.
            if sketch.frame.holds(body.outline.centre) {
                canvas.fill(&corners(&body.outline), who);
            }
        }
    }
    for label in picture.labels(world, &sketch.frame).into_iter().filter(|label| label.outside) {
        canvas.put(label.point, label.arrow);
    }
    canvas
}
