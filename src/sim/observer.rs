//! What is told of a run while it happens, to metrics and recorders.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::abreast::Abreast;
use super::contact::Touch;
use super::perceived::{PerceivedView, Views};
use super::sighting::Sighting;
use scenario::agent::{Mode, ModelState, Motion, Pedestrian, Snapshot, StateQuantity, velocity_inside};

/// Follows a run. Nothing it does can change the run.
pub trait Observer {
    /// Called once, with the state at time 0.
    fn begin(&mut self, _start: &Snapshot) {}

    /// Called after every step.
    fn observe(&mut self, step: &Step);

    /// Called once, with the state in which the run ends.
    fn end(&mut self, _ending: &Ending, _last: &Snapshot) {}
}

/// One step: between the two states positions change smoothly; event times inside are interpolated linearly.
#[derive(Debug, Clone, Copy)]
pub struct Step<'a> {
    /// At its beginning, s.
    pub time: f64,
    /// s
    pub duration: f64,
    /// Everybody at its beginning.
    pub before: &'a Snapshot,
    /// Everybody at its end.
    pub after: &'a Snapshot,
    /// The state at the end of the simulation's own step: `after`, but for the last step of a run that ends inside it.
    pub whole: &'a Snapshot,
    /// What each pedestrian's model was up to during the step.
    pub pedestrian_modes: &'a [Mode],
    /// What each vehicle's controller was up to during the step.
    pub vehicle_modes: &'a [Mode],
    /// How each pedestrian that is present moves.
    pub motions: &'a [Motion],
    /// Who touches whom during the step.
    pub contacts: &'a [Touch],
    /// Who comes into the sight of a vehicle that does not see everything, and who is lost from it, during the step.
    pub sightings: &'a [Sighting],
    /// Where everybody is at its end, seen from vehicles whose paths bend.
    pub abreast: &'a Abreast,
    /// Which pedestrians may go, once they are there; `None` where all may.
    pub may_go: Option<&'a [bool]>,
    /// The models of all pedestrians, which tell what they make of the situation.
    pub minds: Minds<'a>,
    /// What the controllers of all vehicles are told.
    pub views: Views<'a>,
}

/// The models of pedestrians, to whoever looks on: they can be asked, and not told.
#[derive(Clone, Copy, Default)]
pub struct Minds<'a>(&'a [Box<dyn Pedestrian>]);

impl<'a> Minds<'a> {
    /// Of these models, in the order of the world.
    pub fn new(pedestrians: &'a [Box<dyn Pedestrian>]) -> Self {
        Self(pedestrians)
    }

    /// Of the pedestrian of this index.
    pub fn quantities(self, pedestrian: usize) -> Vec<StateQuantity> {
        self.0.get(pedestrian).map(|model| model.state_quantities()).unwrap_or_default()
    }

    /// Of the pedestrian of this index, if it is there and weighs anything.
    pub fn state(self, pedestrian: usize) -> Option<ModelState> {
        self.0.get(pedestrian)?.state()
    }
}

impl fmt::Debug for Minds<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "Minds({})", self.0.len())
    }
}

impl Step<'_> {
    /// Whether a pedestrian that is there may go.
    pub fn may_go(&self, pedestrian: usize) -> bool {
        self.may_go.is_none_or(|all| all[pedestrian])
    }

    /// What the controller of a vehicle that does not see everything was told and was not so, at its last decision in this step; `None` where it sees
    /// everything or decided nothing.
    pub fn perceived(&self, vehicle: usize) -> Option<PerceivedView> {
        let cars = &self.before.vehicles;
        self.views.view((vehicle, cars.len()), &cars[vehicle].path, self.time..=self.time + self.duration)
    }

    /// The state `moment` s after the beginning of the step.
    pub fn at(&self, moment: f64) -> Snapshot {
        let part = moment / self.duration;
        let mut state = self.after.clone();
        for (car, before) in state.vehicles.iter_mut().zip(&self.before.vehicles) {
            *car = before.between(car, part);
        }
        for (person, before) in state.pedestrians.iter_mut().zip(&self.before.pedestrians) {
            let velocity = velocity_inside(self.duration, before, person, part);
            person.position = before.position.lerp(&person.position, part);
            person.velocity = velocity;
        }
        state
    }
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ending {
    /// What ended it.
    pub reason: StopReason,
    /// s
    pub time: f64,
}

/// What ends runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// Every pedestrian is across and every vehicle passed the finish line; of a stream those up to the one that closes the gap that the last
    /// pedestrian took.
    Completed,
    /// A vehicle touched something and the scenario ends on collision.
    Collision,
    /// Time was up.
    Horizon,
}
