//! People who obey a signal do not step onto the road without green, from the pavement or from a refuge on which they wait, whatever their
//! models want. Who is on it goes on.

use super::geometry::Footprint;
use super::legs::Legs;
use scenario::agent::{Mode, Motion, PedestrianState};
use scenario::{Road, Side, World};

/// Places that differ by less are the same, m.
const ROUNDING: f64 = 1e-9;

/// Those of a world who wait for green.
pub(super) struct WaitForGreen {
    /// The crossing that each of them uses; `None` of who does not wait.
    who: Vec<Option<usize>>,
    /// Who was kept on the pavement in the last step.
    held: Vec<bool>,
}

impl WaitForGreen {
    /// `None` where nobody does.
    pub fn new(world: &World) -> Option<Self> {
        let people = world.pedestrians.iter();
        let who: Vec<_> = people.map(|setup| setup.obeys_signals.then_some(setup.crossing)).collect();
        who.iter().any(Option::is_some).then(|| Self { held: vec![false; who.len()], who })
    }

    /// Whether somebody was kept on the pavement in the last step.
    pub fn is_held(&self, index: usize) -> bool {
        self.held[index]
    }

    /// Keeps those where they are who would step onto the road in the step from `time` (s) on. `walk` moves somebody by the whole of it.
    pub fn hold(
        &mut self,
        (road, time): (&Road, f64),
        (people, legs): (&[PedestrianState], &[Legs]),
        motions: &mut [Motion],
        modes: &mut [Mode],
        walk: impl Fn(usize, &mut PedestrianState, Motion),
    ) {
        for (index, now) in people.iter().enumerate() {
            self.held[index] = false;
            let Some(crossing) = self.who[index].filter(|_| now.present) else { continue };
            if road.numbered_crossing(crossing).1.pedestrian_priority(time) {
                continue;
            }
            let mut then = *now;
            walk(index, &mut then, motions[index]);
            let sets_off = then.position != now.position && legs[index].waits_on_refuge(now);
            if sets_off || steps_onto_road(road, now, &then) {
                motions[index] = Motion::Walk(nalgebra::Vector2::zeros());
                modes[index] = Mode::new("waiting_at_red");
                self.held[index] = true;
            }
        }
    }
}

/// Whether somebody whose centre is beside the carriageway comes nearer to it, with the body over the kerb then.
fn steps_onto_road(road: &Road, now: &PedestrianState, then: &PedestrianState) -> bool {
    let reach = |state: &PedestrianState| {
        Footprint::from(state).reach(road.crossing_velocity(state.position, Side::Near, 1.0))
    };
    // How far a place is before the kerb of that side, m; negative on the road.
    let before = |side: Side, state: &PedestrianState| {
        (road.kerb(side) - road.across(state.position)) * side.walking_sign()
    };
    [Side::Near, Side::Far].into_iter().any(|side| {
        let (was, is) = (before(side, now), before(side, then));
        was >= -ROUNDING && is < was - ROUNDING && is < reach(then) - ROUNDING
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use nalgebra::Vector2;
    use scenario::{CrossingKind, Direction, Shape, TrafficSignal};

    const STEP: f64 = 0.1;

    fn person(y: f64) -> PedestrianState {
        PedestrianState {
            position: Vector2::new(0.0, y),
            velocity: Vector2::zeros(),
            acceleration: Vector2::zeros(),
            heading: Vector2::y(),
            shape: Shape::Disc { radius: 0.25 },
            present: true,
        }
    }

    /// Where somebody is after so many steps at `speed` (m/s) towards the far side; people have green from 2 s on.
    fn after(steps: usize, start: f64, speed: f64) -> f64 {
        let mut road = Road::zebra(&[Direction::Forward], 10.0);
        road.crossing.kind = CrossingKind::Signalised(TrafficSignal::new(60.0, 2.0, 10.0));
        let mut rule = WaitForGreen { who: vec![Some(0)], held: vec![false] };
        let (mut people, mut modes) = (vec![person(start)], vec![Mode::NONE]);
        let legs = [Legs::new(&fixture::world().pedestrians[0])];
        for step in 0..steps {
            let mut motions = vec![Motion::Walk(Vector2::new(0.0, speed))];
            let walk = |_: usize, state: &mut PedestrianState, motion: Motion| {
                let Motion::Walk(velocity) = motion else { unreachable!("they walk") };
                state.position += velocity * STEP;
            };
            rule.hold((&road, step as f64 * STEP), (&people, &legs), &mut motions, &mut modes, walk);
            walk(0, &mut people[0], motions[0]);
        }
        people[0].position.y
    }

    #[test]
    fn people_wait_with_their_toes_at_the_kerb_and_go_at_green() {
        // The near kerb is at -2 m, the body 0.25 m wide to each side.
        assert!((after(20, -3.0, 1.0) + 2.3).abs() < 0.06, "{}", after(20, -3.0, 1.0));
        assert!((after(30, -3.0, 1.0) + 1.3).abs() < 0.16, "{}", after(30, -3.0, 1.0));
        // From the far side, whose kerb is at 2 m.
        assert!((after(20, 3.0, -1.0) - 2.3).abs() < 0.06, "{}", after(20, 3.0, -1.0));
    }

    #[test]
    fn who_stands_over_the_kerb_stays_and_who_is_on_the_road_goes_on() {
        assert_eq!(after(20, -2.1, 1.0), -2.1);
        assert_eq!(after(20, -2.0, 1.0), -2.0);
        assert!((after(20, -1.9, 1.0) - 0.1).abs() < 1e-9);
        // Away from the road everybody may walk.
        assert!((after(20, -2.1, -1.0) + 4.1).abs() < 1e-9);
    }
}
