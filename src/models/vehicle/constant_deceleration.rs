//! A vehicle that brakes once, with a constant deceleration, to standstill.

use super::hazard::keep_speed;
use super::period::period;
use super::red_light::LOOKS_AT_NOTHING;
use super::{CommandKind, ControllerContext, ControllerModel};
use scenario::{Attention, Chance, Declaration, Dimension, Parameter};
use sim::{Command, Controller, ControllerError, Mode, ModelError, Observation, Schedule};

const FREE: &str = "free choice";

pub fn constant_deceleration() -> ControllerModel {
    let declaration = Declaration::new(
        "constant_deceleration",
        "Keeps its speed until a time or a distance before the crossing, then brakes \
         constantly to standstill.",
    )
    .source("uniformly decelerated motion")
    .parameters([
        Parameter::number("deceleration", Dimension::ACCELERATION, 3.0, (0.01, 15.0), "Deceleration.", FREE),
        Parameter::optional("time", Dimension::TIME, (0.0, 3600.0), "Brakes from this time on.", FREE),
        Parameter::optional(
            "distance",
            Dimension::LENGTH,
            (0.0, 10_000.0),
            "Brakes when the front is this far before the middle of the crossing.",
            FREE,
        ),
        period(),
    ]);
    ControllerModel::new(declaration, CommandKind::Acceleration, build)
        .driving("ideal")
        .chance(Chance::Never)
        .signals(LOOKS_AT_NOTHING)
        .attention(Attention::Scripted)
}

struct ConstantDeceleration {
    period: f64,
    deceleration: f64,
    time: f64,
    distance: f64,
    braking: bool,
}

fn build(context: &ControllerContext) -> Result<Box<dyn Controller>, ModelError> {
    let settings = context.settings;
    let (time, distance) = (settings.optional_number("time"), settings.optional_number("distance"));
    if time.is_none() && distance.is_none() {
        return Err(ModelError::with_hint(
            "nothing says when `constant_deceleration` brakes",
            "give it `time: 2 s`, `distance: 20 m`, or both for whichever comes first",
        ));
    }
    Ok(Box::new(ConstantDeceleration {
        period: settings.number("period"),
        deceleration: settings.number("deceleration"),
        time: time.unwrap_or(f64::INFINITY),
        distance: distance.unwrap_or(f64::NEG_INFINITY),
        braking: false,
    }))
}

impl Controller for ConstantDeceleration {
    fn schedule(&self) -> Schedule {
        Schedule::every(self.period)
    }

    fn act(&mut self, observation: &Observation) -> Result<Command, ControllerError> {
        let ego = &observation.ego;
        self.braking = self.braking
            || observation.time >= self.time - 1e-9
            || -ego.travelled - ego.length / 2.0 <= self.distance;
        Ok(Command::Acceleration(if self.braking {
            -self.deceleration
        } else {
            keep_speed(ego.speed, observation.cruise_speed, self.deceleration, self.deceleration)
        }))
    }

    fn mode(&self) -> Mode {
        Mode::new(if self.braking { "braking" } else { "cruise" })
    }

    fn looks_at_others(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::test_track::{CRUISE, Track};
    use scenario::{Settings, Value};

    #[test]
    fn stops_after_the_textbook_distance() {
        let brake = |name: &str, value: f64| {
            let settings = Settings::from([(name, Value::Number(value))]);
            let mut track = Track::new(&constant_deceleration(), settings, "ideal");
            track.crossing = 40.0;
            track.drive(20.0);
            (track.motion.travelled, track.motion.speed)
        };
        let (travelled, speed) = brake("time", 2.0);
        assert_eq!(speed, 0.0);
        assert!((travelled - 2.0 * CRUISE - CRUISE * CRUISE / 6.0).abs() < 1e-9);
        let (travelled, _) = brake("distance", 20.0);
        let expected = 40.0 - 20.0 - 2.25 + CRUISE * CRUISE / 6.0;
        // It decides once a step, 0.21 m.
        assert!((0.0..0.21).contains(&(travelled - expected)), "{travelled} {expected}");
    }

    #[test]
    fn a_trigger_is_needed() {
        let world = crate::vehicle::test_track::world(4.0, 2.0);
        let settings = constant_deceleration().declaration.resolve(&Settings::default()).unwrap();
        let context = ControllerContext {
            settings: &settings,
            setup: &world.vehicles[0],
            world: &world,
            rank: 0,
            seed: 0,
        };
        assert!(build(&context).err().unwrap().hint.is_some());
    }
}
