//! Sketches as SVG: pictures one below the other, with what there is to say of them.

use nalgebra::Vector2;

use super::outlook::Outlook;
use super::picture::{Label, Picture, Sketch, tag};
use super::plane::{Frame, Mark};
use super::road::world_marks;
use crate::svg::{At, Svg, through, wrapped};
use scenario::{RoadUserKind, Shape, World};
use sim::geometry::Footprint;

/// Pixels from edge to edge.
const WIDTH: f64 = 960.0;

/// No picture is higher, pixels.
const HIGHEST: f64 = 720.0;

/// Of a line of text, pixels.
const LINE: f64 = 18.0;

/// Characters of a line of text.
const CHARACTERS: usize = 128;

const STYLE: &str = include_str!("sketch.css");

/// A sketch as a whole file.
pub(crate) fn to_svg(sketch: &Sketch, world: &World) -> String {
    let size = sketch.frame.size();
    let scale = (WIDTH / size.x).min(HIGHEST / size.y);
    let high = size.y * scale;
    let facts: Vec<String> = sketch.facts.iter().flat_map(|fact| wrapped(fact, CHARACTERS, "    ")).collect();
    let pictures = sketch.pictures.len() as f64;
    let all = LINE * 2.0 + pictures * (high + LINE * 2.0) + facts.len() as f64 * LINE + LINE;
    let mut svg = Svg::file((WIDTH, all), &sketch.title, STYLE);
    svg.label(&sketch.title, &[("class", &"title"), ("x", &"8"), ("y", &At(LINE * 1.2))]);
    let mut top = LINE * 2.0;
    for picture in &sketch.pictures {
        draw(&mut svg, sketch, world, picture, (top, scale));
        top += high + LINE * 2.0;
    }
    for fact in &facts {
        svg.label(fact, &[("class", &"fact"), ("x", &"8"), ("y", &At(top)), ("xml:space", &"preserve")]);
        top += LINE;
    }
    svg.finish()
}

fn draw(svg: &mut Svg, sketch: &Sketch, world: &World, picture: &Picture, (top, scale): (f64, f64)) {
    let frame = sketch.frame;
    let size = frame.size() * scale;
    let left = (WIDTH - size.x) / 2.0;
    // The plane's y axis points up, SVG's down.
    let at = |point: Vector2<f64>| {
        (left + (point.x - frame.low.x) * scale, top + (frame.high.y - point.y) * scale)
    };
    let id = format!("p{}", At(top));
    svg.open("clipPath", &[("id", &id)]);
    let (x, y) = (At(left), At(top));
    svg.empty("rect", &[("x", &x), ("y", &y), ("width", &At(size.x)), ("height", &At(size.y))]);
    svg.close();
    let clip = format!("url(#{id})");
    svg.empty(
        "rect",
        &[("class", &"pavement"), ("x", &x), ("y", &y), ("width", &At(size.x)), ("height", &At(size.y))],
    );
    svg.open("g", &[("clip-path", &clip)]);
    let (from, to) = sketch.reach;
    for mark in world_marks(world, from, to) {
        path(svg, mark.kind.class(), &mark, at);
    }
    for (point, heading) in &sketch.arrows {
        let left = Vector2::new(-heading.y, heading.x);
        let tip = |along: f64, across: f64| point + heading * along + left * across;
        let arrow = through([tip(-0.8, 0.5), tip(0.2, 0.0), tip(-0.8, -0.5)].map(at));
        svg.empty("path", &[("class", &"arrow"), ("d", &arrow)]);
    }
    if let Some(outlook) = &picture.outlook {
        ways(svg, world, outlook, at);
    }
    for (who, body) in picture.bodies.iter().enumerate() {
        let Some(body) = body else { continue };
        let person = who.checked_sub(world.vehicles.len()).and_then(|index| world.pedestrians.get(index));
        let class = match person.map(|person| person.kind) {
            None => "vehicle",
            Some(RoadUserKind::Pedestrian) => "pedestrian",
            Some(RoadUserKind::Cyclist) => "pedestrian cyclist",
            Some(RoadUserKind::Escooter) => "pedestrian escooter",
        };
        if body.trail.len() > 1 {
            let d = through(body.trail.iter().map(|point| at(*point)));
            svg.empty("path", &[("class", &format!("trail {class}")), ("d", &d)]);
        }
        outline(svg, class, &body.outline, at, scale, body.ghost);
    }
    if let Some(outlook) = &picture.outlook {
        for met in &outlook.meetings {
            let (x, y) = at(met.point);
            let class = if met.touches() { "meeting touches" } else { "meeting" };
            let cross = format!("M{} {}l10 10m0 -10l-10 10", At(x - 5.0), At(y - 5.0));
            svg.empty("path", &[("class", &class), ("d", &cross)]);
        }
    }
    svg.close();
    svg.empty(
        "rect",
        &[("class", &"frame"), ("x", &x), ("y", &y), ("width", &At(size.x)), ("height", &At(size.y))],
    );
    for label in &picture.labels(world, &frame) {
        words(svg, label, at, &frame, scale);
    }
    let bar = At(left + size.x - 10.0 - 10.0 * scale);
    let line = format!("M{bar} {}v5h{}v-5", At(top + size.y - 14.0), At(10.0 * scale));
    svg.empty("path", &[("class", &"scale"), ("d", &line)]);
    let middle = At(left + size.x - 10.0 - 5.0 * scale);
    svg.label(
        "10 m",
        &[("class", &"quiet"), ("x", &middle), ("y", &At(top + size.y - 17.0)), ("text-anchor", &"middle")],
    );
    svg.label(
        &picture.caption,
        &[("class", &"quiet"), ("x", &At(left + 8.0)), ("y", &At(top + size.y + 15.0))],
    );
}

fn path(svg: &mut Svg, class: &str, mark: &Mark, at: impl Fn(Vector2<f64>) -> (f64, f64)) {
    let mut d = through(mark.points.iter().map(|point| at(*point)));
    if mark.closed {
        d.push('z');
    }
    svg.empty("path", &[("class", &class), ("d", &d)]);
}

/// Where everybody is to go, and what they see.
fn ways(svg: &mut Svg, world: &World, outlook: &Outlook, at: impl Fn(Vector2<f64>) -> (f64, f64) + Copy) {
    for (car, setup) in outlook.cars.iter().zip(&world.vehicles) {
        let steps = 200;
        let from = car.motion.travelled;
        let to = world.finish.max(from);
        let place = |step: i32| from + (to - from) * f64::from(step) / f64::from(steps);
        let points =
            crate::svg::thinned(&(0..=steps).map(|step| at(car.path.point(place(step)))).collect::<Vec<_>>());
        let way = format!("way of {}", setup.name);
        svg.titled("path", &way, &[("class", &"way vehicle"), ("d", &through(points))]);
    }
    for (person, setup) in outlook.people.iter().zip(&world.pedestrians) {
        let points: Vec<_> = person.points().into_iter().map(at).collect();
        let d = through(crate::svg::thinned(&points));
        let way = format!("way of {}", setup.name);
        svg.titled("path", &way, &[("class", &"way pedestrian"), ("d", &d)]);
        let (x, y) = at(person.goal);
        svg.empty("circle", &[("class", &"goal"), ("cx", &At(x)), ("cy", &At(y)), ("r", &"4")]);
    }
    for sight in &outlook.sights {
        let class = if sight.hidden_by.is_empty() { "sight" } else { "sight hidden" };
        let d = through([sight.from, sight.to].map(at));
        let (car, person) = (&world.vehicles[sight.vehicle].name, &world.pedestrians[sight.pedestrian].name);
        let title = format!("{car} and {person} at {:.2} s", sight.time);
        svg.titled("path", &title, &[("class", &class), ("d", &d)]);
    }
}

fn outline(
    svg: &mut Svg,
    class: &str,
    outline: &Footprint,
    at: impl Fn(Vector2<f64>) -> (f64, f64),
    scale: f64,
    ghost: bool,
) {
    let class = if ghost { format!("{class} ghost") } else { class.to_string() };
    match outline.shape {
        Shape::Disc { radius } => {
            let (x, y) = at(outline.centre);
            let r = At((radius * scale).max(2.0));
            svg.empty("circle", &[("class", &class), ("cx", &At(x)), ("cy", &At(y)), ("r", &r)]);
        }
        Shape::Rectangle { length, .. } => {
            let mut d = through(super::plane::corners(outline).into_iter().map(&at));
            d.push('z');
            svg.empty("path", &[("class", &class), ("d", &d)]);
            if class.starts_with("vehicle") {
                let across = Vector2::new(-outline.heading.y, outline.heading.x);
                let nose = |side: f64| {
                    outline.centre + outline.heading * (length * 0.3) + across * (side * length * 0.15)
                };
                svg.empty("path", &[("class", &"nose"), ("d", &through([nose(1.0), nose(-1.0)].map(at)))]);
            }
        }
    }
}

fn words(svg: &mut Svg, label: &Label, at: impl Fn(Vector2<f64>) -> (f64, f64), frame: &Frame, scale: f64) {
    let (x, y) = at(label.point);
    let (left, _) = at(frame.low);
    let (right, _) = at(frame.high);
    let text = tag(label);
    let wide = 7.0 * text.chars().count() as f64 / 2.0;
    let x = x.clamp(left + wide + 4.0, (right - wide - 4.0).max(left + wide + 4.0));
    let up = if label.outside { 0.0 } else { 1.4 * scale + 4.0 };
    let (_, top) = at(frame.high);
    let y = (y - up).max(top + 14.0);
    svg.label(&text, &[("class", &"name"), ("x", &At(x)), ("y", &At(y)), ("text-anchor", &"middle")]);
}
