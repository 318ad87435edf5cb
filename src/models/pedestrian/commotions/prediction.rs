//! What the other may do — keep its speed, pass first, pass second — and where that takes it (§8.1, §8.2).

use super::access::AccessOrders;
use super::state::{AgentBody, State};
use super::timing::ConflictPassage;

/// How many behaviours there are.
pub const BEHAVIOURS: usize = 3;

/// A behaviour of the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Behaviour {
    /// It keeps its speed.
    Constant = 0,
    /// It passes first.
    PassFirst = 1,
    /// It passes second.
    PassSecond = 2,
}

/// All behaviours, in the order of their indices.
pub const BEHAVIOUR_LIST: [Behaviour; BEHAVIOURS] =
    [Behaviour::Constant, Behaviour::PassFirst, Behaviour::PassSecond];

/// The acceleration (m/s²) each behaviour needs now, by [`Behaviour`]; `None` is invalid.
pub type BehaviourAccelerations = [Option<f64>; BEHAVIOURS];

/// The accelerations of the behaviours that are possible (§8.1): passing first or second where behaviour is
/// estimated and either is possible, else keeping the speed.
#[inline]
pub fn behaviours(estimated: bool, orders: impl FnOnce() -> AccessOrders) -> BehaviourAccelerations {
    if estimated {
        let orders = orders();
        let first = orders.first.map(|course| course.acceleration);
        let second = orders.second.map(|course| course.acceleration);
        if first.is_some() || second.is_some() {
            return [None, first, second];
        }
    }
    [Some(0.0), None, None]
}

/// A state predicted one prediction time ahead, and the passage from there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PredictedState {
    /// The state.
    pub state: State,
    /// Its passage through the conflict space.
    pub passage: ConflictPassage,
}

impl PredictedState {
    /// The predicted state of a road user, whose acceleration counts for its passage or does not.
    #[inline]
    pub fn new(state: State, body: &AgentBody, with_acceleration: bool) -> Self {
        Self { state, passage: ConflictPassage::of(&state, body.half_extent, with_acceleration) }
    }
}

/// The other after `duration` seconds of `acceleration` from where it is perceived; it stops rather than reverse (§8.2).
///
/// The order of the operations decides the last bit (§6, knife edge).
#[inline]
pub fn predict_other(here: &State, acceleration: f64, duration: f64) -> State {
    let mut speed = here.speed + acceleration * duration;
    let mut moving = duration;
    if speed < 0.0 {
        speed = 0.0;
        moving = here.speed / -acceleration;
    }
    let distance = (here.distance - here.speed * moving) - (acceleration * (moving * moving)) / 2.0;
    State { distance, speed, acceleration }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pedestrian::commotions::access::AccessCourse;

    fn orders(first: Option<f64>, second: Option<f64>) -> AccessOrders {
        let course = |acceleration| AccessCourse { acceleration, duration: 1.0, wait: 0.0 };
        AccessOrders { first: first.map(course), second: second.map(course) }
    }

    #[test]
    fn keeping_the_speed_is_only_for_want_of_anything_better() {
        assert_eq!(behaviours(false, || unreachable!()), [Some(0.0), None, None]);
        assert_eq!(behaviours(true, || orders(None, None)), [Some(0.0), None, None]);
        assert_eq!(behaviours(true, || orders(None, Some(-1.0))), [None, None, Some(-1.0)]);
    }

    #[test]
    fn the_other_stops_rather_than_reverse() {
        let here = State { distance: 10.0, speed: 1.0, acceleration: 0.0 };
        let predicted = predict_other(&here, -4.0, 0.5);
        assert_eq!(predicted.speed, 0.0);
        assert_eq!(predicted.distance, 9.875);
    }
}
