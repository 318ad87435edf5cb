//! What it takes one road user to pass first, and to pass second (§6).

use super::state::{AgentBody, Control};
use super::timing::{ConflictPassage, acceleration_to_be_at};

/// How long an acceleration-controlled road user takes to regain its free speed (s, §6).
const REGAIN_BY_ACCELERATION: f64 = 10.0;

/// What achieving an access order takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccessCourse {
    /// Acceleration now (m/s²).
    pub acceleration: f64,
    /// How long to keep it (s); may be infinite.
    pub duration: f64,
    /// How long to wait after that (s); may be infinite.
    pub wait: f64,
}

/// The courses for both access orders; `None` is impossible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccessOrders {
    /// To pass before the other.
    pub first: Option<AccessCourse>,
    /// To pass after the other.
    pub second: Option<AccessCourse>,
}

/// What one kind of road user wants and keeps: the constants of §6.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manner {
    /// Free speed (m/s), `k_g/(2 k_dv)`.
    pub free_speed: f64,
    /// Time assumed to regain free speed (s): the action duration if speed controlled, else 10 s.
    pub regain_time: f64,
    /// Safety distance (m).
    pub safety_distance: f64,
    /// Safety time (s).
    pub safety_time: f64,
}

impl Manner {
    /// The time to regain free speed for this kind of control (§6).
    pub fn regain_time(control: Control, action_duration: f64) -> f64 {
        match control {
            Control::Speed => action_duration,
            Control::Acceleration => REGAIN_BY_ACCELERATION,
        }
    }
}

/// A free move: towards the free speed, then at it (§6.2, §6.4).
#[derive(Clone, Copy)]
struct FreeMove {
    speed: f64,
    acceleration: f64,
    duration: f64,
    free_speed: f64,
}

impl FreeMove {
    #[inline]
    fn new(speed: f64, manner: &Manner) -> Self {
        let at_free_speed = speed == manner.free_speed;
        Self {
            speed,
            acceleration: (manner.free_speed - speed) / manner.regain_time,
            duration: if at_free_speed { 0.0 } else { manner.regain_time },
            free_speed: manner.free_speed,
        }
    }

    #[inline]
    fn distance_over(&self, t: f64) -> f64 {
        if t <= self.duration {
            self.speed * t + self.acceleration * (t * t) / 2.0
        } else {
            self.speed * self.duration
                + self.acceleration * (self.duration * self.duration) / 2.0
                + self.free_speed * (t - self.duration)
        }
    }

    #[inline]
    fn course(&self) -> AccessCourse {
        AccessCourse { acceleration: self.acceleration, duration: self.duration, wait: 0.0 }
    }
}

/// What passing first and passing second takes a road user at `distance` and `speed` against another whose
/// centre is at `other_distance` and whose passage is `other_passage` (§6).
///
/// Comparisons have no tolerance: where a road user must stop exactly at its safety distance the last bit
/// decides, as it does in the published results.
#[inline]
pub fn access_orders(
    body: &AgentBody,
    manner: &Manner,
    distance: f64,
    speed: f64,
    other: &AgentBody,
    other_distance: f64,
    other_passage: &ConflictPassage,
) -> AccessOrders {
    let other = (other, other_distance, other_passage);
    access_orders_that_count((true, true), body, manner, (distance, speed), other)
}

/// As [`access_orders`]; of passing first and passing second what does not count is `None`.
#[inline]
pub fn access_orders_that_count(
    (first, second): (bool, bool),
    body: &AgentBody,
    manner: &Manner,
    (distance, speed): (f64, f64),
    (other, other_distance, other_passage): (&AgentBody, f64, &ConflictPassage),
) -> AccessOrders {
    if body.occupies(distance) && other.occupies(other_distance) {
        return AccessOrders { first: None, second: None };
    }
    let free = FreeMove::new(speed, manner);
    if distance <= -body.half_extent - manner.safety_distance {
        let course = |counts: bool| counts.then(|| free.course());
        return AccessOrders { first: course(first), second: course(second) };
    }
    let pass_first = || pass_first(body, manner, distance, &free, other, other_distance, other_passage);
    let pass_second = || pass_second(body, manner, distance, &free, other, other_distance, other_passage);
    AccessOrders {
        first: if first { pass_first() } else { None },
        second: if second { pass_second() } else { None },
    }
}

#[inline]
fn pass_first(
    body: &AgentBody,
    manner: &Manner,
    distance: f64,
    free: &FreeMove,
    other: &AgentBody,
    other_distance: f64,
    other_passage: &ConflictPassage,
) -> Option<AccessCourse> {
    let until = other_passage.entry - manner.safety_time;
    if other_distance < other.half_extent || until <= 0.0 {
        return None;
    }
    let clear = distance + body.half_extent + manner.safety_distance;
    if free.distance_over(until) > clear {
        return Some(free.course());
    }
    acceleration_to_be_at(free.speed, clear, until).map(|(acceleration, duration)| AccessCourse {
        acceleration,
        duration,
        wait: 0.0,
    })
}

#[inline]
fn pass_second(
    body: &AgentBody,
    manner: &Manner,
    distance: f64,
    free: &FreeMove,
    other: &AgentBody,
    other_distance: f64,
    other_passage: &ConflictPassage,
) -> Option<AccessCourse> {
    if other_distance <= -other.half_extent {
        return Some(free.course());
    }
    if distance < body.half_extent + manner.safety_distance {
        return None;
    }
    let short_of = (distance - body.half_extent) - manner.safety_distance;
    let until = other_passage.exit + manner.safety_time;
    if free.distance_over(until) < short_of {
        return Some(free.course());
    }
    acceleration_to_be_at(free.speed, short_of, until).map(|(acceleration, duration)| AccessCourse {
        acceleration,
        duration,
        wait: if other_passage.exit == f64::INFINITY {
            f64::INFINITY
        } else {
            (other_passage.exit - duration).max(0.0)
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pedestrian::commotions::State;

    const PEDESTRIAN: AgentBody =
        AgentBody { control: Control::Speed, half_extent: 1.3, cosine: 0.0, width: 0.8 };
    const VEHICLE: AgentBody =
        AgentBody { control: Control::Acceleration, half_extent: 2.5, cosine: 0.0, width: 1.8 };
    const WALK: Manner = Manner { free_speed: 1.3, regain_time: 0.5, safety_distance: 1.0, safety_time: 1.0 };

    fn against(distance: f64, speed: f64, other: State) -> AccessOrders {
        let passage = ConflictPassage::of(&other, VEHICLE.half_extent, false);
        access_orders(&PEDESTRIAN, &WALK, distance, speed, &VEHICLE, other.distance, &passage)
    }

    fn vehicle(distance: f64, speed: f64) -> State {
        State { distance, speed, acceleration: 0.0 }
    }

    #[test]
    fn both_inside_leaves_no_order() {
        let orders = against(0.5, 1.3, vehicle(1.0, 3.0));
        assert_eq!(orders.first, None);
        assert_eq!(orders.second, None);
    }

    #[test]
    fn a_far_vehicle_leaves_the_free_move() {
        let orders = against(4.0, 1.3, vehicle(500.0, 10.0));
        let free = orders.first.unwrap();
        assert_eq!((free.acceleration, free.duration, free.wait), (0.0, 0.0, 0.0));
    }

    #[test]
    fn inside_the_safety_margin_nobody_passes_second() {
        assert!(against(2.3, 1.0, vehicle(20.0, 10.0)).second.is_some());
        assert!(against(2.2999, 1.0, vehicle(20.0, 10.0)).second.is_none());
    }

    #[test]
    fn a_standing_vehicle_is_waited_for_for_ever() {
        let course = against(5.0, 1.0, vehicle(6.0, 0.0)).second.unwrap();
        assert_eq!(course.wait, f64::INFINITY);
    }

    #[test]
    fn once_the_vehicle_is_through_passing_second_is_free() {
        let orders = against(3.0, 1.0, vehicle(-2.5, 8.0));
        assert_eq!(orders.first, None);
        assert_eq!(orders.second.unwrap().duration, 0.5);
    }
}
