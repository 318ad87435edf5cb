//! Where controllers were told that somebody is who is elsewhere: outlines beside the bodies, and the same in words.

use nalgebra::Vector2;

use super::pairs::outline;
use crate::perceived::perceived_words;
use results::Recording;
use sim::geometry::Footprint;
use sim::{PerceivedOther, PerceivedView};

/// An outline of somebody where a controller was told that they are.
pub struct Ghost {
    pub who: usize,
    pub body: Footprint,
    /// Whose controller, and of whom.
    pub title: String,
}

/// What controllers were told last until a recorded time.
fn views(recording: &Recording, index: usize) -> impl Iterator<Item = &PerceivedView> {
    let time = recording.times.get(index).copied().unwrap_or_default();
    let cars = recording.case.world.vehicles.len();
    (0..cars).filter_map(move |vehicle| recording.perceived(vehicle, time))
}

/// Those at a recorded time, in the attitude that they have then: controllers are told none.
pub fn ghosts(recording: &Recording, index: usize) -> Vec<Ghost> {
    let of = |view: &PerceivedView| {
        let others = view.others.iter().filter(|one| one.who < recording.users.len());
        let ghost = |other: &PerceivedOther| {
            let centre: Vector2<f64> = other.position;
            let body = Footprint { centre, ..outline(recording, other.who, index)? };
            let (car, who) = (recording.name(view.vehicle), recording.name(other.who));
            Some(Ghost { who: other.who, body, title: format!("{who} as perceived by {car}") })
        };
        others.filter_map(ghost).collect::<Vec<_>>()
    };
    views(recording, index).flat_map(of).collect()
}

/// The same in words.
pub fn ghost_words(recording: &Recording, index: usize) -> Vec<String> {
    views(recording, index).flat_map(|view| perceived_words(&recording.case.world, view)).collect()
}
