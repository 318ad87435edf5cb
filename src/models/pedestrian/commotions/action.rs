//! Actions and the plan they add up to: the buffer of accelerations still to come (§2).

use super::state::{Control, State, at_least_zero, step};

/// How many actions there are to choose from.
pub const ACTIONS: usize = 5;

/// Sizes of the actions: m/s if speed controlled, m/s² if acceleration controlled.
pub const ACTION_SIZES: [f64; ACTIONS] = [-1.0, -0.5, 0.0, 0.5, 1.0];

/// The index of doing nothing new.
pub const NO_ACTION: usize = 2;

/// The accelerations an agent has planned: those of the coming action duration, and the one held after it.
#[derive(Clone, Debug)]
pub struct ActionPlan {
    dt: f64,
    /// Planned accelerations from this step on, one per step of the action duration.
    planned: Vec<f64>,
    /// The planned acceleration of every later step.
    held: f64,
    /// What each action adds to `planned`.
    additions: Vec<[f64; ACTIONS]>,
    /// What each action adds to `held`.
    held_additions: [f64; ACTIONS],
}

/// Where each action leads in one action duration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Destinations {
    /// Distances to the conflict point (m).
    pub distance: [f64; ACTIONS],
    /// Speeds (m/s).
    pub speed: [f64; ACTIONS],
    /// Accelerations (m/s²).
    pub acceleration: [f64; ACTIONS],
}

impl Destinations {
    /// The state that action `j` leads to.
    #[inline]
    pub fn state(&self, j: usize) -> State {
        State { distance: self.distance[j], speed: self.speed[j], acceleration: self.acceleration[j] }
    }
}

impl ActionPlan {
    /// Nothing planned yet. Actions take `duration` (s) in steps of `dt` (s).
    pub fn new(control: Control, duration: f64, dt: f64) -> Self {
        let steps = ((duration / dt).ceil() as usize).max(1);
        let addition = |i: usize, size: f64| match control {
            Control::Speed => size / duration,
            Control::Acceleration if steps == 1 => size,
            Control::Acceleration => size * i as f64 / (steps - 1) as f64,
        };
        Self {
            dt,
            planned: vec![0.0; steps],
            held: 0.0,
            additions: (0..steps).map(|i| ACTION_SIZES.map(|size| addition(i, size))).collect(),
            held_additions: match control {
                Control::Speed => [0.0; ACTIONS],
                Control::Acceleration => ACTION_SIZES,
            },
        }
    }

    /// Nothing is planned any more.
    pub fn clear(&mut self) {
        self.planned.fill(0.0);
        self.held = 0.0;
    }

    /// Begins a decision step: someone who stands does not plan to slow down.
    pub fn begin_step(&mut self, speed: f64) {
        if speed == 0.0 {
            for a in &mut self.planned {
                *a = at_least_zero(*a);
            }
            self.held = at_least_zero(self.held);
        }
    }

    /// Where each action would lead from `distance` and `speed` (§8.2).
    pub fn destinations(&self, distance: f64, speed: f64) -> Destinations {
        let mut d = [distance; ACTIONS];
        let mut v = [speed; ACTIONS];
        for (planned, additions) in self.planned.iter().zip(&self.additions) {
            for j in 0..ACTIONS {
                (d[j], v[j]) = step(d[j], v[j], planned + additions[j], self.dt);
            }
        }
        Destinations {
            distance: d,
            speed: v,
            acceleration: self.held_additions.map(|addition| self.held + addition),
        }
    }

    /// How far each action would have led from `distance` (m) and `speed` (m/s) after so many `steps`, at most those of
    /// the action duration.
    pub fn distances_after(&self, steps: usize, distance: f64, speed: f64) -> [f64; ACTIONS] {
        let mut d = [distance; ACTIONS];
        let mut v = [speed; ACTIONS];
        for (planned, additions) in self.planned.iter().zip(&self.additions).take(steps) {
            for j in 0..ACTIONS {
                (d[j], v[j]) = step(d[j], v[j], planned + additions[j], self.dt);
            }
        }
        d
    }

    /// How many steps `duration` (s) takes, at most those of the action duration.
    pub fn steps_of(&self, duration: f64) -> usize {
        ((duration / self.dt).ceil() as usize).min(self.planned.len())
    }

    /// Takes action `j` at this step.
    pub fn take(&mut self, j: usize) {
        for (planned, additions) in self.planned.iter_mut().zip(&self.additions) {
            *planned += additions[j];
        }
        self.held += self.held_additions[j];
    }

    /// Ends the step: the acceleration of now, while the plan moves on.
    pub fn end_step(&mut self) -> f64 {
        let now = self.planned[0];
        self.planned.copy_within(1.., 0);
        if let Some(last) = self.planned.last_mut() {
            *last = self.held;
        }
        now
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pedestrian_changes_speed_over_the_action() {
        let mut plan = ActionPlan::new(Control::Speed, 0.5, 0.1);
        let destinations = plan.destinations(4.0, 0.0);
        assert_eq!(destinations.speed, [0.0, 0.0, 0.0, 0.5, 1.0]);
        assert_eq!(destinations.acceleration, [0.0; 5]);
        plan.take(4);
        let accelerations: Vec<f64> = (0..7).map(|_| plan.end_step()).collect();
        assert_eq!(accelerations, [2.0, 2.0, 2.0, 2.0, 2.0, 0.0, 0.0]);
    }

    #[test]
    fn a_driver_ramps_to_an_acceleration_and_holds_it() {
        let mut plan = ActionPlan::new(Control::Acceleration, 0.5, 0.1);
        plan.take(0);
        assert_eq!(plan.destinations(50.0, 10.0).acceleration, [-2.0, -1.5, -1.0, -0.5, 0.0]);
        let first = plan.end_step();
        plan.take(3);
        let then: Vec<f64> = (0..7).map(|_| plan.end_step()).collect();
        assert_eq!(first, 0.0);
        assert_eq!(then, [-0.25, -0.375, -0.5, -0.625, -0.5, -0.5, -0.5]);
    }

    #[test]
    fn after_its_duration_an_action_has_led_to_its_destination() {
        let mut plan = ActionPlan::new(Control::Speed, 0.5, 0.1);
        plan.take(4);
        assert_eq!(plan.distances_after(0, 4.0, 0.0), [4.0; 5]);
        // At 2 m/s² and at 4 m/s² for 0.2 s.
        let after = plan.distances_after(plan.steps_of(0.15), 4.0, 0.0);
        assert!((after[NO_ACTION] - 3.96).abs() < 1e-12 && (after[4] - 3.92).abs() < 1e-12, "{after:?}");
        assert_eq!((plan.steps_of(9.0), plan.steps_of(f64::INFINITY)), (5, 5));
        assert_eq!(plan.distances_after(5, 4.0, 0.0), plan.destinations(4.0, 0.0).distance);
    }

    #[test]
    fn someone_standing_forgets_planned_braking() {
        let mut plan = ActionPlan::new(Control::Acceleration, 0.5, 0.1);
        plan.take(0);
        plan.begin_step(0.0);
        assert_eq!(plan.destinations(5.0, 0.0).state(NO_ACTION), State { distance: 5.0, ..State::default() });
    }
}
