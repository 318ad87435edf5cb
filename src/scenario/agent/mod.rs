//! The seams for models: what a pedestrian and a controller see, and what they may do.

mod command;
mod controller_error;
mod mode;
mod model_error;
mod model_state;
mod schedule;
mod script_step;
mod state;
mod steered;

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::{Ground, Position, Road, RoadUserKind, SeenSignal, Shape};

pub use command::{Command, CommandKind};
pub use controller_error::ControllerError;
pub use mode::Mode;
pub use model_error::{ModelError, Stated, StatedBy};
pub use model_state::{ModelState, StateQuantity};
pub use schedule::Schedule;
pub use script_step::ScriptStep;
pub use state::{Longitudinal, PedestrianState, Snapshot, VehicleState, velocity_inside};
pub use steered::Steered;

/// A pedestrian model. It sees states as they are now, never the future or another's internals.
pub trait Pedestrian: Send {
    /// Decides what to do from now until the next step. Called at every step from the moment on from which it may go, which is that of its
    /// appearance unless the scenario says otherwise.
    fn act(&mut self, scene: &Scene) -> Motion;

    /// Called instead of [`Self::act`] at every step at which it is there and may not go yet: it stands, and what it sees may count
    /// later. Models that decide by what is there at the moment need nothing of that.
    fn look(&mut self, _scene: &Scene) {}

    /// Told before [`Self::act`] where a refuge is reached and another leg of the way begins; it stands there.
    fn begin_leg(&mut self, _scene: &Scene) {}

    /// What it is up to, such as `waiting`; shown in traces and timelines.
    fn mode(&self) -> Mode {
        Mode::NONE
    }

    /// The speed at which it would walk without traffic, m/s.
    fn free_speed(&self) -> f64;

    /// The quantities that [`Self::state`] has values of. None, unless a model says otherwise.
    fn state_quantities(&self) -> Vec<StateQuantity> {
        Vec::new()
    }

    /// What it makes of the situation since the last [`Self::act`]; `None` where it weighs nothing. Asked of runs that are drawn alone, and
    /// nobody in a run is told.
    fn state(&self) -> Option<ModelState> {
        None
    }

    /// The steps of its script that have not begun, in order and as they are written. None, unless it follows a script.
    fn waiting_steps(&self) -> Vec<ScriptStep> {
        Vec::new()
    }
}

/// What a pedestrian sees.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// s
    pub time: f64,
    /// Time until the next step, s.
    pub step: f64,
    /// With its crossings and what blocks the view.
    pub road: &'a Road,
    /// The number of the crossing that it uses, see [`Road::crossings`].
    pub crossing: usize,
    /// The pedestrian's own index in `pedestrians`.
    pub me: usize,
    /// Where it wants to go: on the way there the middle of the next refuge, if it waits on refuges.
    pub goal: Position,
    /// How many legs of its way are behind it, and how many come after the one to `goal`; none where it waits on no refuge.
    pub legs: (usize, usize),
    /// All of them, in the order of the world.
    pub vehicles: &'a [VehicleState],
    /// Look only at those that are `present`.
    pub pedestrians: &'a [PedestrianState],
    /// Whether it was kept from stepping onto the road in the step before, since its signal showed no green.
    pub held: bool,
}

impl<'a> Scene<'a> {
    /// The pedestrian itself.
    pub fn ego(&self) -> &'a PedestrianState {
        &self.pedestrians[self.me]
    }

    /// Whether another leg of its way comes after the one to `goal`.
    pub fn goes_on(&self) -> bool {
        self.legs.1 > 0
    }

    /// Whether it comes to the lane of a vehicle, or leaves it, on the leg to `goal`; of a way that has one leg, always.
    pub fn meets_on_this_leg(&self, vehicle: &VehicleState) -> bool {
        if self.legs == (0, 0) {
            return true;
        }
        let (here, goal) = (vehicle.path.beside(self.ego().position), vehicle.path.beside(self.goal.into()));
        here * goal <= 0.0 || here.abs() <= self.road.lane_width / 2.0
    }

    /// Whether pedestrians have priority now at the crossing that it uses.
    pub fn pedestrian_priority(&self) -> bool {
        self.road.numbered_crossing(self.crossing).1.pedestrian_priority(self.time)
    }
}

/// How a pedestrian moves over one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// Accelerate along the way to the goal, m/s². The speed stops at zero: no walking backwards.
    Accelerate(f64),
    /// Take this velocity (m/s) at once and keep it over the step.
    Walk(Vector2<f64>),
    /// Take this velocity (m/s) at once, keep it, and be displaced (m) besides, as when pushed aside.
    Pushed {
        /// m/s, in the world frame.
        velocity: Vector2<f64>,
        /// m, in the world frame, over this step.
        displacement: Vector2<f64>,
    },
}

/// An automated vehicle's controller. What goes in and out is plain data, so that it may live in another process.
pub trait Controller: Send {
    /// When it decides; the command is held in between.
    fn schedule(&self) -> Schedule;

    /// Time that it needs in free flow until its filters and the vehicle are in steady cruise, s.
    fn settling_time(&self) -> f64 {
        0.0
    }

    /// Decides what to do until the next moment of its schedule.
    ///
    /// # Errors
    /// Whatever keeps it from deciding. The run ends there, and is neither a pass nor a failure.
    fn act(&mut self, observation: &Observation) -> Result<Command, ControllerError>;

    /// Asked after each decision: the curvature (1/m, to the left) of the way that its vehicle's rear axle is to take until the next
    /// one. `None`: it does not steer.
    ///
    /// Who never steers follows the lane exactly. From the first curvature on the vehicle is where it was steered to; without one it
    /// then goes on beside its lane, at the angle to it that it has.
    fn curvature(&self) -> Option<f64> {
        None
    }

    /// What it is up to, such as `emergency_stop`; shown in traces and timelines.
    fn mode(&self) -> Mode {
        Mode::NONE
    }

    /// Whether it may look at pedestrians or other vehicles. One that never does, and has no perception, is told of none: to tell each of
    /// many vehicles of all others takes most of the time of a run.
    fn looks_at_others(&self) -> bool {
        true
    }

    /// The steps of its script that have not begun, in order and as they are written. None, unless it follows a script.
    fn waiting_steps(&self) -> Vec<ScriptStep> {
        Vec::new()
    }
}

/// What stands between the world and a controller.
pub trait Perception: Send {
    /// Puts into `view` what is known of `seen`. Called once before each decision; `view` is that of the decision before.
    fn perceive(&mut self, seen: &Observation, view: &mut Observation);

    /// Where everybody is, the vehicle itself by its index `me`. Called before each [`Self::perceive`] from the start of the run on, for whoever
    /// minds who stands before whom.
    fn look(&mut self, _me: usize, _now: &Snapshot) {}

    /// How old it is at `time`, that of a decision, what was put into the view for it, s; `None` where there is no one age of it. Asked of runs that
    /// are drawn alone, and nobody in a run is told.
    fn age(&self, _time: f64) -> Option<f64> {
        None
    }
}

/// What a controller receives. Ego frame: x ahead along the lane from the ego's centre, y to the left of its lane's
/// centre line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Observation {
    /// s; negative while settling before the start.
    pub time: f64,
    /// The vehicle that it drives.
    pub ego: EgoState,
    /// The speed it is wanted to cruise at, m/s.
    pub cruise_speed: f64,
    /// As it is now, with who has priority.
    pub road: RoadView,
    /// Those it knows of, in any order; nobody before they appear.
    pub pedestrians: Vec<SeenPedestrian>,
    /// The others that it knows of; the ego is not among them.
    pub vehicles: Vec<SeenVehicle>,
}

/// The vehicle that a controller drives, as it knows it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EgoState {
    /// From the ego's centre to the middle of the crossing in m; negative once past it. Of several crossings it is the first that the
    /// ego has not left behind, or the last.
    pub distance_to_crossing: f64,
    /// m/s
    pub speed: f64,
    /// m/s²
    pub acceleration: f64,
    /// m
    pub length: f64,
    /// m
    pub width: f64,
    /// Along its lane, 0 at the middle of the crossing, m; negative before it.
    #[serde(default)]
    pub travelled: f64,
    /// Of its lane at the point of it that follows that, to the left, 1/m.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub curvature: f64,
    /// How far the point of it that follows its lane is to the left of it, m: 0 where nobody has steered.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub lateral_offset: f64,
    /// From the direction of its lane there to its own, to the left, rad: 0 where nobody has steered.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub heading_error: f64,
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

/// How far ahead vehicles are told how their lanes bend, m.
pub const CURVATURE_REACH: f64 = 150.0;

/// The road as the ego sees it from its lane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RoadView {
    /// m
    pub lane_width: f64,
    /// m/s
    pub speed_limit: f64,
    /// Extent of that crossing along the road, m.
    pub crossing_width: f64,
    /// Whether pedestrians have priority at that crossing now.
    pub pedestrian_priority: bool,
    /// What the signal of that crossing shows to vehicles; `None`: there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signal: Option<SeenSignal>,
    /// y of the edge of the carriageway on the ego's right, a kerb or a median, m (negative).
    pub right_kerb: f64,
    /// y of the edge of the carriageway on the ego's left, m.
    pub left_kerb: f64,
    /// Rise per metre ahead, positive uphill; `None` on a road that says none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gradient: Option<f64>,
    /// How the lane bends within [`CURVATURE_REACH`]: how far ahead of the point of the ego that follows it (m, ascending), and its
    /// curvature there (1/m, to the left).
    ///
    /// From [`EgoState::curvature`] on it changes evenly from each to the next, and not at all behind the last; two of one place are a
    /// jump. Beside the middle of lane 0 a clothoid is told in parts, to 0.001 1/m. Empty where the curvature does not change.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub curvature_ahead: Vec<(f64, f64)>,
    /// Every crossing of the road, in the order in which the ego comes to them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub crossings: Vec<CrossingView>,
}

/// A crossing as the ego sees it from its lane.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CrossingView {
    /// From the ego's centre to its middle, m; negative once past it.
    pub distance: f64,
    /// Its extent along the road, m.
    pub width: f64,
    /// Whether pedestrians have priority on it now.
    pub pedestrian_priority: bool,
    /// y of where people may wait on the ego's right, beyond a kerb or on a refuge, m (negative).
    pub right_edge: f64,
    /// y of where people may wait on the ego's left, m.
    pub left_edge: f64,
}

/// A pedestrian as a controller knows it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SeenPedestrian {
    /// The same person keeps the same number.
    pub id: usize,
    /// Whether they walk or ride.
    #[serde(default, skip_serializing_if = "RoadUserKind::is_pedestrian")]
    pub kind: RoadUserKind,
    /// Centre in the ego frame, m.
    pub position: Vector2<f64>,
    /// Over ground, along the ego frame's axes, m/s.
    pub velocity: Vector2<f64>,
    /// Over ground, m/s².
    pub acceleration: Vector2<f64>,
    /// In the pedestrian's own frame.
    pub shape: Shape,
}

/// Another vehicle as a controller knows it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SeenVehicle {
    /// The same vehicle keeps the same number.
    pub id: usize,
    /// Centre in the ego frame, m.
    pub position: Vector2<f64>,
    /// Over ground, along the ego frame's axes, m/s.
    pub velocity: Vector2<f64>,
    /// m
    pub length: f64,
    /// m
    pub width: f64,
}

/// How a vehicle answers its controller.
pub trait Dynamics: Send {
    /// Moves on by `step` s. Speeds never fall below zero.
    fn advance(&mut self, motion: &mut Longitudinal, command: Command, step: f64);

    /// As [`Self::advance`], on a road whose ground is said; `ground` is as it is in the vehicle's direction.
    ///
    /// If not said otherwise, the vehicle is accelerated evenly over the step, by what the ground leaves of the acceleration at which
    /// it would move on level, dry ground.
    fn advance_on(&mut self, ground: &Ground, motion: &mut Longitudinal, command: Command, step: f64) {
        let mut level = Longitudinal { travelled: 0.0, ..*motion };
        self.advance(&mut level, command, step);
        let before = motion.speed;
        let stops_within = level.speed == 0.0 && level.travelled > 0.0;
        let acceleration = match stops_within {
            true => -before * before / (2.0 * level.travelled),
            false => (level.speed - before) / step,
        };
        ground.accelerate(motion, acceleration, step);
    }
}
