//! The ways of people who wait on refuges: one leg after the other, each to the middle of the next refuge and the last to their goal.

use nalgebra::Vector2;

use super::way::Way;
use scenario::agent::{Motion, PedestrianState};
use scenario::{PedestrianSetup, Position};

/// On a refuge, but for rounding, m.
const ON_IT: f64 = 1e-9;

/// Which leg of their way somebody is on.
#[derive(Debug, Clone)]
pub(super) struct Legs {
    start: Vector2<f64>,
    /// Unit vector from start to goal.
    way: Vector2<f64>,
    /// Where each leg ends; never empty.
    goals: Vec<Position>,
    /// The leg that they are on.
    current: usize,
}

impl Legs {
    pub fn new(setup: &PedestrianSetup) -> Self {
        let goals = setup.stops.iter().copied().chain([setup.goal]).collect();
        Self { start: setup.start.into(), way: Way::new(setup).ahead(setup.start.into()), goals, current: 0 }
    }

    /// Where the leg ends that they are on.
    pub fn goal(&self) -> Position {
        self.goals[self.current]
    }

    /// How many legs come after it.
    pub fn left(&self) -> usize {
        self.goals.len() - 1 - self.current
    }

    /// How many legs are behind them, and how many are to come after that which they are on.
    pub fn counts(&self) -> (usize, usize) {
        (self.current, self.left())
    }

    /// Whether they have come to a refuge, from where the next leg begins.
    pub fn reaches(&mut self, state: &PedestrianState) -> bool {
        let ends = self.left() > 0 && self.to_go(state) <= ON_IT;
        self.current += usize::from(ends);
        ends
    }

    /// Whether they stand on the refuge from where the leg begins that they are on.
    pub fn waits_on_refuge(&self, state: &PedestrianState) -> bool {
        let begins = self.current.checked_sub(1).map(|before| Vector2::from(self.goals[before]));
        begins.is_some_and(|begins| (state.position - begins).dot(&self.way) <= ON_IT)
    }

    /// The motion over a step that does not lead beyond the end of a leg: whoever comes there within the step stands there. `walk`
    /// moves them by the whole of the step.
    pub fn held(
        &self,
        now: &PedestrianState,
        motion: Motion,
        walk: impl Fn(&mut PedestrianState, Motion),
    ) -> Motion {
        if self.left() == 0 {
            return motion;
        }
        let mut then = *now;
        walk(&mut then, motion);
        let (to_go, beyond) = (self.to_go(now), -self.to_go(&then));
        if beyond < 0.0 {
            return motion;
        }
        let displacement = (then.position - now.position) * (to_go / (to_go + beyond));
        Motion::Pushed { velocity: Vector2::zeros(), displacement }
    }

    /// How far it is to the end of the leg, along the way from start to goal, m.
    fn to_go(&self, state: &PedestrianState) -> f64 {
        let goal = Vector2::from(self.goal());
        (goal - self.start).dot(&self.way) - (state.position - self.start).dot(&self.way)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use crate::start::waiting_outside;

    fn setup() -> PedestrianSetup {
        let mut setup = fixture::world().pedestrians.remove(0);
        (setup.start, setup.goal) = (Position { x: 0.0, y: -4.0 }, Position { x: 0.0, y: 12.0 });
        setup.stops = vec![Position { x: 0.0, y: 3.0 }, Position { x: 0.0, y: 7.0 }];
        setup
    }

    fn at(y: f64) -> PedestrianState {
        let setup = setup();
        let state = waiting_outside((&setup, &Way::Straight(Vector2::y())));
        PedestrianState { position: Vector2::new(0.0, y), ..state }
    }

    fn by_one_second(state: &mut PedestrianState, motion: Motion) {
        match motion {
            Motion::Walk(velocity) => {
                state.position += velocity;
                state.velocity = velocity;
            }
            Motion::Pushed { velocity, displacement } => {
                state.position += velocity + displacement;
                state.velocity = velocity;
            }
            Motion::Accelerate(_) => unreachable!(),
        }
    }

    #[test]
    fn one_leg_comes_after_the_other() {
        let mut legs = Legs::new(&setup());
        assert_eq!((legs.goal().y, legs.left()), (3.0, 2));
        assert!(!legs.waits_on_refuge(&at(-4.0)));
        assert!(!legs.reaches(&at(2.9)));
        assert!(legs.reaches(&at(3.0)));
        assert_eq!((legs.goal().y, legs.left()), (7.0, 1));
        assert!(!legs.reaches(&at(3.0)));
        assert!(legs.waits_on_refuge(&at(3.0)) && !legs.waits_on_refuge(&at(3.1)));
        assert!(legs.reaches(&at(7.0)));
        // The last ends nowhere.
        assert_eq!((legs.goal().y, legs.left()), (12.0, 0));
        assert!(!legs.reaches(&at(13.0)));
    }

    #[test]
    fn nobody_walks_past_the_end_of_a_leg() {
        let legs = Legs::new(&setup());
        let walk = Motion::Walk(Vector2::new(0.2, 1.5));
        assert_eq!(legs.held(&at(1.0), walk, by_one_second), walk);
        let held = legs.held(&at(2.0), walk, by_one_second);
        let mut state = at(2.0);
        by_one_second(&mut state, held);
        assert!((state.position.y - 3.0).abs() < 1e-12 && state.velocity == Vector2::zeros(), "{state:?}");
        assert!((state.position.x - 0.2 / 1.5).abs() < 1e-12);
        // Towards the goal, on the last leg, they go as they want.
        let mut legs = legs;
        assert!(legs.reaches(&at(3.0)) && legs.reaches(&at(7.0)));
        assert_eq!(legs.held(&at(11.9), walk, by_one_second), walk);
    }
}
