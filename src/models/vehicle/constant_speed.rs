//! A vehicle that keeps its speed, whatever happens.

use super::period::period;
use super::red_light::LOOKS_AT_NOTHING;
use super::{CommandKind, ControllerContext, ControllerModel};
use scenario::{Attention, Chance, Declaration, Dimension, Parameter};
use sim::{Command, Controller, ControllerError, Mode, ModelError, Observation, Schedule};

pub fn constant_speed() -> ControllerModel {
    let declaration = Declaration::new(
        "constant_speed",
        "Keeps its speed whatever happens; the vehicle that only a pedestrian can \
         avoid.",
    )
    .source("none needed")
    .parameters([
        Parameter::number(
            "gain",
            Dimension::FREQUENCY,
            1.0,
            (0.0, 100.0),
            "Acceleration per speed error, for dynamics that drift off the wanted speed.",
            "free choice",
        ),
        period(),
    ]);
    ControllerModel::new(declaration, CommandKind::Acceleration, build)
        .driving("ideal")
        .chance(Chance::Never)
        .signals(LOOKS_AT_NOTHING)
        .attention(Attention::Scripted)
}

struct ConstantSpeed {
    period: f64,
    gain: f64,
}

fn build(context: &ControllerContext) -> Result<Box<dyn Controller>, ModelError> {
    let settings = context.settings;
    Ok(Box::new(ConstantSpeed { period: settings.number("period"), gain: settings.number("gain") }))
}

impl Controller for ConstantSpeed {
    fn schedule(&self) -> Schedule {
        Schedule::every(self.period)
    }

    fn act(&mut self, observation: &Observation) -> Result<Command, ControllerError> {
        Ok(Command::Acceleration(self.gain * (observation.cruise_speed - observation.ego.speed)))
    }

    fn mode(&self) -> Mode {
        Mode::new("cruise")
    }

    fn looks_at_others(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::test_track::Track;
    use scenario::Settings;

    #[test]
    fn nothing_changes_its_speed() {
        for dynamics in ["ideal", "delay_lag"] {
            let mut track = Track::new(&constant_speed(), Settings::default(), dynamics);
            track.place_pedestrian(30.0, 0.0);
            for sample in track.drive(10.0) {
                assert_eq!(sample.speed, 30.0 / 3.6, "{dynamics}");
            }
        }
    }
}
