//! How people get from their start to their goal: straight on, or along the lane of a road that bends.
//!
//! Who follows a lane decides as on a straight road: they are told that what is left of their way lies straight ahead, and where that
//! would lead them is counted along the lane instead.

use nalgebra::Vector2;

use scenario::agent::{Motion, PedestrianState};
use scenario::{Path, PedestrianSetup, Position};

/// The way of one pedestrian.
#[derive(Debug, Clone)]
pub(super) enum Way {
    /// A unit vector from start to goal.
    Straight(Vector2<f64>),
    /// A path that is followed to a place of it, m.
    Along(Path, f64),
}

impl Way {
    pub fn new(setup: &PedestrianSetup) -> Self {
        if let Some(path) = &setup.follows {
            return Self::Along(path.clone(), path.along(setup.goal.into()));
        }
        let way = Vector2::new(setup.goal.x - setup.start.x, setup.goal.y - setup.start.y);
        Self::Straight(way.try_normalize(0.0).unwrap_or_else(|| Vector2::new(0.0, setup.side.walking_sign())))
    }

    /// Unit vector in which it leads from a place of it.
    pub fn ahead(&self, at: Vector2<f64>) -> Vector2<f64> {
        match self {
            Self::Straight(way) => *way,
            Self::Along(path, _) => path.heading(path.along(at)),
        }
    }

    /// The goal (`end` of who goes straight on) as whoever is at a place of it is told.
    pub fn goal(&self, at: Vector2<f64>, end: Position) -> Position {
        let Self::Along(path, to) = self else { return end };
        let place = path.along(at);
        let goal = at + path.heading(place) * (to - place);
        Position { x: goal.x, y: goal.y }
    }

    /// Moves a pedestrian by the first `duration` s of a step.
    pub fn walk(&self, state: &mut PedestrianState, motion: Motion, duration: f64, step: f64) {
        let path = match self {
            Self::Straight(way) => return straight_on(state, motion, *way, duration, step),
            Self::Along(path, _) => path,
        };
        let (from, place) = (state.position, path.along(state.position));
        let ahead = path.heading(place);
        straight_on(state, motion, ahead, duration, step);
        let along = |vector: Vector2<f64>| vector.dot(&ahead);
        let (centre, heading) = path.pose(place + along(state.position - from));
        *state = PedestrianState {
            position: centre,
            velocity: heading * along(state.velocity),
            acceleration: heading * along(state.acceleration),
            heading,
            ..*state
        };
    }
}

/// How far somebody has come who is at a place, on the way from their start, m.
pub(super) fn walked(setup: &PedestrianSetup, place: Vector2<f64>) -> f64 {
    match &setup.follows {
        Some(path) => path.along(place) - path.along(setup.start.into()),
        None => (place - Vector2::from(setup.start)).dot(&Way::new(setup).ahead(place)),
    }
}

/// Moves a pedestrian by the first `duration` s of a step.
fn straight_on(state: &mut PedestrianState, motion: Motion, way: Vector2<f64>, duration: f64, step: f64) {
    match motion {
        Motion::Accelerate(acceleration) => {
            let speed = state.velocity.dot(&way).max(0.0);
            let distance = (duration * speed + acceleration * (duration * duration) / 2.0).max(0.0);
            state.position += way * distance;
            state.velocity = way * (speed + acceleration * duration).max(0.0);
            state.acceleration = way * acceleration;
        }
        Motion::Walk(velocity) => {
            state.position += velocity * duration;
            state.acceleration = (velocity - state.velocity) / step;
            state.velocity = velocity;
        }
        Motion::Pushed { velocity, displacement } => {
            state.position += velocity * duration + displacement * (duration / step);
            state.acceleration = (velocity - state.velocity) / step;
            state.velocity = velocity;
        }
    }
    if let Some(heading) = state.velocity.try_normalize(1e-6) {
        state.heading = heading;
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use scenario::Direction;
    use scenario::geometry::{CurvedPath, Piece, Pose, ReferenceLine};

    use super::*;
    use crate::fixture;
    use crate::start::waiting_outside;

    /// Along a circle about (0, `radius`), from its lowest point, `further` m against the clock.
    fn follower(radius: f64, further: f64) -> PedestrianSetup {
        let line = ReferenceLine::new(Pose::origin(), &[Piece::arc(radius, 5.0)]).unwrap();
        let path = Path::curved(CurvedPath::new(Arc::new(line), 0.0, Direction::Forward, 0.0).unwrap());
        let mut setup = fixture::world().pedestrians.remove(0);
        let goal = path.point(further);
        (setup.start, setup.goal) = (Position { x: 0.0, y: 0.0 }, Position { x: goal.x, y: goal.y });
        setup.follows = Some(path);
        setup
    }

    #[test]
    fn who_follows_a_circle_stays_on_it_and_walks_its_length() {
        let setup = follower(9.0, 20.0);
        let way = Way::new(&setup);
        let mut state = waiting_outside((&setup, &way));
        for step in 0..400 {
            let gone = f64::from(step) * 0.05;
            assert!((walked(&setup, state.position) - gone).abs() < 1e-9, "{gone} m");
            let angle = gone / 9.0;
            let place = Vector2::new(9.0 * angle.sin(), 9.0 - 9.0 * angle.cos());
            assert!((state.position - place).norm() < 1e-9, "{:?}, not {place:?}", state.position);
            assert!((state.heading - Vector2::new(angle.cos(), angle.sin())).norm() < 1e-9);
            // Told that what is left lies straight ahead.
            let goal = Vector2::from(way.goal(state.position, setup.goal)) - state.position;
            assert!((goal - state.heading * (20.0 - gone)).norm() < 1e-9);
            let ahead = way.ahead(state.position);
            way.walk(&mut state, Motion::Walk(ahead * 2.0), 0.025, 0.025);
            assert!((state.velocity.norm() - 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn every_motion_leads_as_far_as_straight_on() {
        let (setup, mut straight) = (follower(15.0, 40.0), fixture::world().pedestrians.remove(0));
        (straight.start, straight.goal) = (Position { x: 0.0, y: 0.0 }, Position { x: 40.0, y: 0.0 });
        let ways = [Way::new(&setup), Way::new(&straight)];
        let mut states = [&setup, &straight].map(|setup| waiting_outside((setup, &Way::new(setup))));
        for step in 0..200 {
            for (state, way) in states.iter_mut().zip(&ways) {
                let ahead = way.ahead(state.position);
                let motion = match step % 3 {
                    0 => Motion::Accelerate(0.4),
                    1 => Motion::Walk(ahead * 1.3),
                    _ => Motion::Pushed { velocity: ahead * 0.7, displacement: ahead * 0.01 },
                };
                way.walk(state, motion, 0.02, 0.025);
            }
            let [bend, line] = &states;
            assert!((walked(&setup, bend.position) - line.position.x).abs() < 1e-9);
            assert!((bend.velocity.norm() - line.velocity.norm()).abs() < 1e-9);
            assert!((bend.acceleration.norm() - line.acceleration.norm()).abs() < 1e-9);
        }
    }
}
