//! CARLA's BehaviorAgent: binary emergency braking by distance, otherwise a nearly bang-bang speed controller.
//!
//! On a straight road without turns. For a red light it brakes as for an obstacle. It never slows down for a pedestrian: either its distance
//! test says emergency brake, or it drives on.

mod declaration;
mod light;
mod obstacle;
mod speed_controller;

use super::red_light;
use super::{CommandKind, ControllerContext, ControllerModel};
use declaration::KMH;
use light::LightTest;
use obstacle::ObstacleTest;
use scenario::{Attention, Chance, LooksAt, Settings, SignalConduct};
use sim::{Command, Controller, ControllerError, Mode, ModelError, Observation, Schedule};
use speed_controller::SpeedController;

pub fn carla_behavior() -> ControllerModel {
    let declaration = declaration::declaration();
    ControllerModel::new(declaration, CommandKind::Pedals, build)
        .driving("generic")
        .chance(Chance::Never)
        .signals(SignalConduct::Obeys)
        .attention(Attention::Reacts(|_| LooksAt::OWN_LANE))
}

struct CarlaBehavior {
    period: f64,
    settling_time: f64,
    target: Target,
    braking_distance: f64,
    emergency_brake: f64,
    following: Following,
    obstacle: ObstacleTest,
    /// `None`: it ignores signals.
    light: Option<LightTest>,
    speed_controller: SpeedController,
    mode: &'static str,
}

/// What it takes as its wanted speed.
enum Target {
    Cruise,
    /// min(`max_speed`, speed limit - `below_limit`), m/s.
    Stock {
        max_speed: f64,
        below_limit: f64,
    },
}

/// How it keeps behind a slower vehicle; speeds in m/s.
struct Following {
    safety_time: f64,
    speed_decrease: f64,
    min_speed: f64,
}

fn build(context: &ControllerContext) -> Result<Box<dyn Controller>, ModelError> {
    let settings = context.settings;
    let target = match settings.word("target_speed") {
        "stock" => Target::Stock {
            max_speed: settings.number("max_speed"),
            below_limit: settings.number("speed_limit_distance"),
        },
        _ => Target::Cruise,
    };
    Ok(Box::new(CarlaBehavior {
        period: settings.number("period"),
        settling_time: settings.number("settling_time"),
        target,
        braking_distance: settings.number("braking_distance"),
        emergency_brake: settings.number("emergency_brake"),
        following: Following {
            safety_time: settings.number("safety_time"),
            speed_decrease: settings.number("speed_decrease"),
            min_speed: settings.number("min_following_speed"),
        },
        obstacle: ObstacleTest::from_settings(settings),
        light: context.setup.obeys_signals.then(|| LightTest::from_settings(settings)),
        speed_controller: speed_controller(settings),
        mode: "cruise",
    }))
}

fn speed_controller(settings: &Settings) -> SpeedController {
    SpeedController::new(
        [settings.number("proportional"), settings.number("integral"), settings.number("derivative")],
        settings.number("buffer") as usize,
        settings.number("period"),
        settings.number("max_throttle"),
        settings.number("max_brake"),
    )
}

impl CarlaBehavior {
    fn wanted_speed(&self, observation: &Observation) -> f64 {
        match self.target {
            Target::Cruise => observation.cruise_speed,
            Target::Stock { max_speed, below_limit } => {
                max_speed.min(observation.road.speed_limit - below_limit).max(0.0)
            }
        }
    }

    /// The speed to keep behind a vehicle at `speed`, `distance` m away; m/s.
    fn following_speed(&self, own: f64, speed: f64, distance: f64, wanted: f64) -> f64 {
        let closing = (own - speed).max(1.0);
        let time_to_collision = distance / closing;
        if time_to_collision < self.following.safety_time {
            (speed - self.following.speed_decrease).max(0.0).min(wanted)
        } else if time_to_collision < 2.0 * self.following.safety_time {
            speed.max(self.following.min_speed).min(wanted)
        } else {
            wanted
        }
    }
}

impl Controller for CarlaBehavior {
    fn schedule(&self) -> Schedule {
        Schedule::every(self.period)
    }

    fn settling_time(&self) -> f64 {
        self.settling_time
    }

    fn act(&mut self, observation: &Observation) -> Result<Command, ControllerError> {
        if self.light.as_mut().is_some_and(|light| light.stops(observation)) {
            self.mode = red_light::mode(red_light::stands(observation.ego.speed));
            return Ok(Command::Pedals { throttle: 0.0, brake: self.emergency_brake });
        }
        let mut wanted = self.wanted_speed(observation);
        let walker = self.obstacle.walker(observation);
        let vehicle = self.obstacle.vehicle(observation);
        let too_near = |distance: f64| distance < self.braking_distance;
        if walker.is_some_and(too_near) || vehicle.is_some_and(|lead| too_near(lead.distance)) {
            // The speed controller is not asked, so its memory stays as it is.
            self.mode = "emergency_stop";
            return Ok(Command::Pedals { throttle: 0.0, brake: self.emergency_brake });
        }
        self.mode = "cruise";
        if let Some(lead) = vehicle {
            self.mode = "following";
            wanted = self.following_speed(observation.ego.speed, lead.speed, lead.distance, wanted);
        }
        Ok(self.speed_controller.pedals((wanted - observation.ego.speed) * KMH))
    }

    fn mode(&self) -> Mode {
        Mode::new(self.mode)
    }
}

#[cfg(test)]
mod tests;
