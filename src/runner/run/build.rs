//! Road users from their setups: registered models brought to life.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::plan::{LOOKS_TOO_LONG, past_arrival_words};
use numbers::random::ranks;
use results::RunFault;
use scenario::registry::EntryKind;
use scenario::{
    ControllerContext, DeclaredProgram, Dimension, PedestrianContext, Reference, Scenario, World, show,
};
use sim::random::vehicle_ranks;
use sim::{ControllerError, Driven, Driver, Fault, ModelError, RoadUsers, Schedule, Solid, StatedBy};

/// Why a case cannot be run, or not to its end.
#[derive(Debug, Clone, PartialEq, Error, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum RunError {
    /// A world names a model that no registry has.
    #[error("there is no {kind} called `{name}`")]
    Unknown {
        /// What it should be.
        kind: EntryKind,
        /// What is named.
        name: String,
    },
    /// What was drawn for it is not possible.
    #[error("what was drawn for it cannot be run: {0}")]
    Impossible(String),
    /// It was not made: where it was to be made, its trial had taken longer than its `time_limit` by then.
    #[error("its trial was over its `time_limit` before it was made")]
    TimeLimit,
    /// A model refuses the case.
    #[error("`{who}`: {error}")]
    Model {
        /// The road user's name.
        who: String,
        /// Why, with numbers of the scenario.
        error: ModelError,
    },
    /// The encounter cannot be: a pedestrian appears inside another body, or would have to appear before the run begins.
    #[error("{message}")]
    NoEncounter {
        /// The pedestrian, the body and the moment; or the time to arrival, and how large it is at the start.
        message: String,
        /// What to write instead.
        hint: String,
        /// Whether the run had begun.
        begun: bool,
    },
    /// A controller cannot decide at some moment of the run.
    #[error("`{who}` cannot decide {}: {error}", moment(*time, *free_flow))]
    Controller {
        /// The vehicle's name.
        who: String,
        /// s; negative while settling before the start.
        time: f64,
        /// Whether it was alone on the road, to see how it drives in free flow.
        free_flow: bool,
        /// In the controller's own words.
        error: ControllerError,
    },
}

/// When somebody decides, in words.
fn moment(time: f64, free_flow: bool) -> String {
    let seconds = show(time.abs(), None, Dimension::TIME);
    let moment = if time < 0.0 { format!("{seconds} before the start") } else { format!("at {seconds}") };
    if free_flow { format!("in free flow, without pedestrians, {moment}") } else { moment }
}

impl RunError {
    /// What is wrong, numbers in the units that a scenario is written in.
    pub fn told(&self, scenario: &Scenario) -> String {
        let Self::Model { who, error } = self else { return self.to_string() };
        let notation = |name: String| scenario.written.get(&name).and_then(|written| written.notation);
        let written = |of: &StatedBy| match of {
            StatedBy::Setting(name) => {
                ["model", "controller"].into_iter().find_map(|part| notation(format!("{who}.{part}.{name}")))
            }
            StatedBy::Start => notation(format!("{who}.start")),
            StatedBy::Step => notation("step".to_string()),
        };
        format!("`{who}`: {}", error.told(&written))
    }

    /// What to write instead, if the model knows.
    pub fn hint(&self) -> Option<&str> {
        match self {
            Self::Unknown { .. } | Self::TimeLimit => None,
            Self::Impossible(_) => Some(
                "cut what is drawn where that begins: `truncated_normal(mean, standard deviation, low, high)`",
            ),
            Self::Model { error, .. } => error.hint.as_deref(),
            Self::NoEncounter { hint, .. } => Some(hint),
            Self::Controller { error, .. } => error.hint.as_deref(),
        }
    }

    /// The run of this key, if a program kept it from its end.
    pub fn run_fault(&self, key: &str) -> Option<RunFault> {
        match self {
            Self::Controller { who, time, error, .. } => {
                let fault = (**error.fault.as_ref()?).clone();
                Some(RunFault { run: key.to_string(), vehicle: who.clone(), time: *time, fault })
            }
            Self::Unknown { .. }
            | Self::Impossible(_)
            | Self::TimeLimit
            | Self::Model { .. }
            | Self::NoEncounter { .. } => None,
        }
    }

    /// Whether nothing is wrong but the place or time at which a pedestrian appears: searches and estimates leave such runs out.
    pub fn is_no_encounter(&self) -> bool {
        matches!(self, Self::NoEncounter { .. })
    }

    /// Whether the run had begun, so that it can be seen again; else no run of the case begins.
    pub fn had_begun(&self) -> bool {
        matches!(self, Self::Controller { .. } | Self::NoEncounter { begun: true, .. })
    }

    /// What kept a run of `world` from its end.
    pub fn of_fault(world: &World, fault: Fault, free_flow: bool) -> Self {
        match fault {
            Fault::Controller { vehicle, time, error } => {
                Self::Controller { who: world.vehicles[vehicle].name.clone(), time, free_flow, error }
            }
            Fault::Occupied { pedestrian, by, time } => Self::NoEncounter {
                message: occupied(world, pedestrian, by, time),
                hint: "let it appear at another place or time: `start`, `along`, `appears`".to_string(),
                begun: true,
            },
            Fault::PastArrival(past) => {
                let (message, hint) = past_arrival_words(world, &past, None);
                Self::NoEncounter { message, hint, begun: past.to_go }
            }
            Fault::NeverMayGo { pedestrian, may_go, time } => {
                let person = &world.pedestrians[pedestrian];
                let time_of = |moment| show(moment, None, Dimension::TIME);
                Self::NoEncounter {
                    message: format!(
                        "{} `{}` may go at {} at the latest, and the run ends at {} before it did",
                        person.kind.word(),
                        person.name,
                        time_of(may_go),
                        time_of(time)
                    ),
                    hint: LOOKS_TOO_LONG.to_string(),
                    begun: true,
                }
            }
        }
    }
}

/// Names the pedestrian, the body that it appears inside of, and the moment.
fn occupied(world: &World, pedestrian: usize, by: Solid, time: f64) -> String {
    let person = &world.pedestrians[pedestrian];
    let what = match by {
        Solid::Vehicle(_) => "vehicle",
        Solid::Pedestrian(other) => world.pedestrians[other].kind.word(),
        Solid::Box(_) => "box",
    };
    let (name, kind, moment) = (&person.name, person.kind.word(), show(time, None, Dimension::TIME));
    format!("at {moment} {kind} `{name}` appears inside {what} `{}`", by.name(world))
}

/// What a reference stands for.
fn resolved<T>(reference: &Reference<T>, kind: EntryKind) -> Result<&T, RunError> {
    let unknown = || RunError::Unknown { kind, name: reference.to_string() };
    reference.known().ok_or_else(unknown)
}

/// A program decides at moments of its own, or at every step.
fn outside(program: &DeclaredProgram, world: &World) -> Driver {
    let schedule = Schedule::every(program.period.unwrap_or(world.step));
    Driver::Outside { schedule, settling_time: program.settles }
}

/// Builds every road user of `world` for the run with seed `seed`.
pub fn road_users(world: &World, seed: u64) -> Result<RoadUsers, RunError> {
    let named = |who: &str| {
        let who = who.to_string();
        move |error| RunError::Model { who, error }
    };
    let vehicles = world
        .vehicles
        .iter()
        .zip(vehicle_ranks(world))
        .map(|(setup, rank)| {
            let model = resolved(&setup.controller.model, EntryKind::Controller)?;
            let dynamics = resolved(&setup.dynamics.model, EntryKind::VehicleDynamics)?;
            let context =
                ControllerContext { settings: &setup.controller.settings, setup, world, rank, seed };
            let driver = match &model.program {
                Some(program) => outside(program, world),
                None => Driver::Inside((model.build)(&context).map_err(named(&setup.name))?),
            };
            let perception = setup.sees.as_ref().map(|sees| {
                let perception = resolved(&sees.model, EntryKind::Perception)?;
                (perception.build)(&sees.settings, &context, driver.schedule()).map_err(named(&setup.name))
            });
            Ok(Driven {
                driver,
                perception: perception.transpose()?,
                dynamics: (dynamics.build)(&setup.dynamics.settings).map_err(named(&setup.name))?,
            })
        })
        .collect::<Result<_, _>>()?;
    let names: Vec<&str> = world.pedestrians.iter().map(|setup| setup.name.as_str()).collect();
    let pedestrians = world
        .pedestrians
        .iter()
        .zip(ranks(&names))
        .map(|(setup, rank)| {
            let model = resolved(&setup.model.model, EntryKind::PedestrianModel)?;
            let context = PedestrianContext { settings: &setup.model.settings, setup, world, rank, seed };
            (model.build)(&context).map_err(named(&setup.name))
        })
        .collect::<Result<_, _>>()?;
    Ok(RoadUsers { vehicles, pedestrians })
}

/// Of a vehicle that a program drives, where no program may be started.
pub(super) fn nobody_asked() -> ControllerError {
    ControllerError::with_hint(
        "its controller is a program, and nobody here starts one",
        "make its runs with `Threads::with_processes` and a pool of programs",
    )
}
