//! What is drawn of a case, as data: the same for every target.

use std::sync::Arc;

use nalgebra::Vector2;

use super::outlook::Outlook;
use super::plane::Frame;
use scenario::World;
use sim::geometry::Footprint;

/// What is drawn of a case: the road from above with everybody, before its run or at moments of it.
pub struct Sketch {
    pub(crate) title: String,
    pub(crate) world: Arc<World>,
    /// The part of the plane that every picture shows.
    pub(crate) frame: Frame,
    /// How much of the road is drawn, m along it from the middle of the crossing.
    pub(crate) reach: (f64, f64),
    /// Where each lane's traffic goes, now and then: points and unit vectors.
    pub(crate) arrows: Vec<(Vector2<f64>, Vector2<f64>)>,
    pub(crate) pictures: Vec<Picture>,
    pub(crate) facts: Vec<String>,
}

/// One picture of it.
pub(crate) struct Picture {
    pub(crate) caption: String,
    /// Vehicles first, then pedestrians.
    pub(crate) bodies: Vec<Option<Body>>,
    /// What is known before the run, in a picture of that.
    pub(crate) outlook: Option<Outlook>,
}

/// Somebody in a picture.
pub(crate) struct Body {
    pub(crate) outline: Footprint,
    pub(crate) trail: Vec<Vector2<f64>>,
    /// Whether it is not there yet.
    pub(crate) ghost: bool,
}

/// A name beside somebody, or at the edge beyond which they are.
pub(crate) struct Label {
    pub(crate) who: usize,
    pub(crate) name: String,
    /// Where it stands, m.
    pub(crate) point: Vector2<f64>,
    /// Whether they are outside the picture; then the arrow that points to them, and how far beyond its edge they are, m.
    pub(crate) outside: bool,
    pub(crate) arrow: char,
    pub(crate) beyond: f64,
}

/// Vehicles first.
pub(crate) fn names(world: &World) -> impl Iterator<Item = &str> {
    let cars = world.vehicles.iter().map(|car| car.name.as_str());
    cars.chain(world.pedestrians.iter().map(|person| person.name.as_str()))
}

impl Picture {
    /// Everybody's name where they are, or where they are to be looked for.
    pub(crate) fn labels(&self, world: &World, frame: &Frame) -> Vec<Label> {
        let all = self.bodies.iter().zip(names(world)).enumerate();
        let label = |(who, (body, name)): (usize, (&Option<Body>, &str))| {
            let place = body.as_ref()?.outline.centre;
            let point = frame.nearest(place);
            let away = place - point;
            let outside = away.norm() > 0.0;
            let arrow = match (away.x.abs() >= away.y.abs(), away.x < 0.0, away.y < 0.0) {
                (true, true, _) => '◀',
                (true, false, _) => '▶',
                (false, _, true) => '▼',
                (false, _, false) => '▲',
            };
            Some(Label { who, name: name.to_string(), point, outside, arrow, beyond: away.norm() })
        };
        let labels: Vec<Label> = all.filter_map(label).collect();
        // Beyond an edge the nearest vehicle of a stream stands for those behind it.
        let stream = |label: &Label| world.streams.iter().position(|one| one.vehicles.contains(&label.who));
        let is_hidden: Vec<bool> = labels
            .iter()
            .map(|label| {
                let own = stream(label).filter(|_| label.outside);
                own.is_some()
                    && labels.iter().any(|other| {
                        let nearer = other.outside && other.beyond < label.beyond;
                        nearer && other.arrow == label.arrow && stream(other) == own
                    })
            })
            .collect();
        labels
            .into_iter()
            .zip(is_hidden)
            .filter(|(_, is_hidden)| !is_hidden)
            .map(|(label, _)| label)
            .collect()
    }
}

/// A label in words.
pub(crate) fn tag(label: &Label) -> String {
    if label.outside {
        format!("{} {} {:.0} m beyond", label.arrow, label.name, label.beyond)
    } else {
        label.name.clone()
    }
}
