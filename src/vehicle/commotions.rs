//! The COMMOTIONS model as a driver: a vehicle that negotiates with pedestrians as a person at the wheel would.

use super::{CommandKind, ControllerContext, ControllerModel};
use crate::pedestrian::commotions::model::{Bodies, Person, extent, seed_of_meeting};
use crate::pedestrian::commotions::parameters::PARAMETERS;
use crate::pedestrian::commotions::{Agent, Encounter, Rules, State};
use crate::scenario::Declaration;
use crate::sim::random::{self, Purpose, Stream};
use crate::sim::{Command, Controller, ModelError, Observation, SeenPedestrian};

/// The registry entry.
pub static COMMOTIONS: ControllerModel = ControllerModel {
    declaration: Declaration {
        name: "commotions",
        summary: "A human-like driver: the COMMOTIONS model with its acceleration controlled",
        source: "Markkula, Lin, Srinivasan, Billington, Leonetti, Kalantari, Yang, Lee, Madigan and Merat, PNAS Nexus 2(6), 2023",
        parameters: PARAMETERS,
        presets: None,
    },
    default_dynamics: "ideal",
    gives: CommandKind::Acceleration,
    build,
};

fn build(context: &ControllerContext) -> Result<Box<dyn Controller>, ModelError> {
    let person = Person::from_settings(context.settings, &context.world.road, context.world.step)?;
    let meetings = context
        .world
        .pedestrians
        .iter()
        .enumerate()
        .map(|(index, pedestrian)| {
            let bodies = Bodies {
                pedestrian: extent(pedestrian.shape),
                vehicle: (context.setup.length, context.setup.width),
            };
            let encounter = Encounter { own: bodies.vehicle(), other: bodies.pedestrian(), dt: person.dt };
            let agent = random::Agent::Vehicle(context.index);
            Meeting {
                agent: Agent::new(&person.variant, &person.parameters, &encounter),
                draws: random::stream(seed_of_meeting(context.seed, index), agent, Purpose::Perception),
                half_extent: encounter.own.half_extent,
                direction: None,
                acceleration: 0.0,
                passed: false,
            }
        })
        .collect();
    Ok(Box::new(Driver {
        meetings,
        period: person.dt,
        entry_inhibited_until: context.settings.number("entry_inhibited_until"),
    }))
}

/// The driver's encounter with one pedestrian.
struct Meeting {
    agent: Agent,
    draws: Stream,
    half_extent: f64,
    /// Which way the pedestrian crosses: +1 to the left, −1 to the right.
    direction: Option<f64>,
    /// What this encounter asks for (m/s²).
    acceleration: f64,
    passed: bool,
}

impl Meeting {
    fn step(&mut self, seen: &SeenPedestrian, observation: &Observation, rules: &Rules) {
        // Who stands beside the lane means to cross it.
        let direction = *self.direction.get_or_insert_with(|| {
            let towards_the_lane = if seen.position.y > 0.0 { -1.0 } else { 1.0 };
            if seen.velocity.y == 0.0 { towards_the_lane } else { seen.velocity.y.signum() }
        });
        let ego = &observation.ego;
        let own = State { distance: seen.position.x, speed: ego.speed, acceleration: ego.acceleration };
        let other = State {
            distance: -direction * seen.position.y,
            speed: (direction * seen.velocity.y).max(0.0),
            acceleration: direction * seen.acceleration.y,
        };
        self.acceleration = self.agent.step(&own, &other, rules, &mut self.draws).acceleration;
        self.passed = own.distance < -self.half_extent;
    }
}

/// A driver among pedestrians. The model is one of two road users; with more pedestrians the most cautious of the
/// answers counts. With nobody in sight the speed is kept.
struct Driver {
    meetings: Vec<Meeting>,
    period: f64,
    entry_inhibited_until: f64,
}

impl Controller for Driver {
    fn period(&self) -> Option<f64> {
        Some(self.period)
    }

    fn act(&mut self, observation: &Observation) -> Command {
        let rules = Rules {
            pedestrian_priority: observation.road.pedestrian_priority,
            entry_inhibited: observation.time < self.entry_inhibited_until,
        };
        for seen in &observation.pedestrians {
            if let Some(meeting) = self.meetings.get_mut(seen.id) {
                meeting.step(seen, observation, &rules);
            }
        }
        let met = self.meetings.iter().filter(|meeting| meeting.direction.is_some() && !meeting.passed);
        Command::Acceleration(met.map(|meeting| meeting.acceleration).reduce(f64::min).unwrap_or(0.0))
    }

    fn mode(&self) -> &'static str {
        if self.meetings.iter().any(|meeting| meeting.direction.is_some() && !meeting.passed) {
            "negotiating"
        } else {
            ""
        }
    }
}
