//! One moment of a recorded run from above, for a page that is read without JavaScript or printed: the script draws its moving picture in its place.

use std::fmt::Write;

use nalgebra::Vector2;

use super::ghosts::{Ghost, ghost_words, ghosts};
use super::pairs::{outline, user_look};
use crate::drawing::{view, world_marks};
use files::escape::html;
use results::Recording;
use scenario::Shape;
use sim::geometry::Footprint;

/// How far along a road marks are drawn, m from the crossing.
const REACH: f64 = 80.0;

/// The content of an `svg` in metres, and its `viewBox`.
pub struct Still {
    pub view_box: String,
    pub content: String,
    /// Who is drawn where a controller was told that they are, besides where they are, in words.
    pub perceived: Vec<String>,
}

/// Everybody at the recorded time that is nearest to `time` (s).
pub fn still(recording: &Recording, time: f64) -> Still {
    let world = &recording.case.world;
    let cars = world.vehicles.len();
    let away = |index: &usize| (recording.times[*index] - time).abs();
    let index =
        (0..recording.times.len()).min_by(|one, other| away(one).total_cmp(&away(other))).unwrap_or(0);
    let places = |from: usize, to: usize| -> Vec<Vector2<f64>> {
        let bodies = (from..to).filter_map(|who| outline(recording, who, index));
        bodies.map(|body| body.centre).collect()
    };
    let frame = match recording.times.is_empty() {
        true => view(world, Vec::new(), Vec::new()),
        false => view(world, places(0, cars), places(cars, recording.users.len())),
    };
    let flip = |point: Vector2<f64>| (point.x, frame.low.y + frame.high.y - point.y);
    let mut content = String::new();
    let through = |points: &[Vector2<f64>], closed: bool| {
        let mut path = String::new();
        for (index, point) in points.iter().enumerate() {
            let (x, y) = flip(*point);
            write!(path, "{}{x:.2} {y:.2}", if index == 0 { 'M' } else { 'L' }).expect(STRING);
        }
        if closed { path + "z" } else { path }
    };
    let (from, to) =
        world.road.bend.as_ref().map_or((-REACH, REACH), |bend| {
            (-bend.crossing - REACH, bend.line.length() - bend.crossing + REACH)
        });
    for mark in world_marks(world, from, to) {
        let path = through(&mark.points, mark.closed);
        writeln!(content, "<path class=\"{}\" d=\"{path}\"/>", mark.kind.class()).expect(STRING);
    }
    for who in 0..recording.users.len() {
        let Some(body) = recording.times.get(index).and_then(|_| outline(recording, who, index)) else {
            continue;
        };
        let kind = if who < cars { "vehicle" } else { "pedestrian" };
        let class = user_look(recording, who).map_or_else(|| kind.into(), |look| look.class(kind));
        draw(&mut content, &class, &body, flip(body.centre));
        let (x, y) = flip(body.centre);
        let name = html(recording.name(who));
        let y = y - half_height(&body) - 0.5;
        writeln!(
            content,
            "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"1\" text-anchor=\"middle\">{name}</text>"
        )
        .expect(STRING);
    }
    for Ghost { who, body, title } in ghosts(recording, index) {
        let kind = if who < cars { "ghost vehicle" } else { "ghost pedestrian" };
        let class = user_look(recording, who).map_or_else(|| kind.into(), |look| look.class(kind));
        writeln!(content, "<g><title>{}</title>", html(&title)).expect(STRING);
        draw(&mut content, "halo", &body, flip(body.centre));
        draw(&mut content, &class, &body, flip(body.centre));
        writeln!(content, "</g>").expect(STRING);
    }
    let size = frame.size();
    let view_box = format!("{:.2} {:.2} {:.2} {:.2}", frame.low.x, frame.low.y, size.x, size.y);
    Still { view_box, content, perceived: ghost_words(recording, index) }
}

/// How far a body reaches across the picture, m.
fn half_height(body: &Footprint) -> f64 {
    match body.shape {
        Shape::Disc { radius } => radius,
        Shape::Rectangle { length, width } => {
            (length * body.heading.y.abs() + width * body.heading.x.abs()) / 2.0
        }
    }
}

const STRING: &str = "writing to a string cannot fail";

fn draw(content: &mut String, class: &str, body: &Footprint, (x, y): (f64, f64)) {
    match body.shape {
        Shape::Disc { radius } => {
            writeln!(content, "<circle class=\"{class}\" cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.2}\"/>")
        }
        Shape::Rectangle { length, width } => {
            let turn = -libm::atan2(body.heading.y, body.heading.x).to_degrees() + 0.0;
            let (left, top) = (-length / 2.0, -width / 2.0);
            writeln!(
                content,
                "<rect class=\"{class}\" x=\"{left:.2}\" y=\"{top:.2}\" width=\"{length:.2}\" height=\"{width:.2}\" \
                 transform=\"translate({x:.2} {y:.2}) rotate({turn:.1})\"/>"
            )
        }
    }
    .expect(STRING);
}
