//! A vehicle that takes acceleration commands exactly, at most clamped.

use crate::vehicle::{CommandKind, DynamicsModel};
use scenario::{Declaration, Dimension, Ground, Parameter, Settings};
use sim::{Command, Dynamics, Longitudinal, ModelError};

pub fn ideal() -> DynamicsModel {
    let declaration = Declaration::new(
        "ideal",
        "Takes acceleration commands exactly and at once, clamped to optional limits.",
    )
    .source("point mass")
    .parameters([
        Parameter::optional(
            "max_acceleration",
            Dimension::ACCELERATION,
            (0.0, 50.0),
            "Largest acceleration; without it there is no limit.",
            "free choice",
        ),
        Parameter::optional(
            "max_deceleration",
            Dimension::ACCELERATION,
            (0.0, 50.0),
            "Largest deceleration, as a positive number; without it there is no limit.",
            "free choice",
        ),
    ]);
    DynamicsModel::new(declaration, &[CommandKind::Acceleration], (4.5, 1.8), build)
}

struct Ideal {
    lowest: f64,
    highest: f64,
}

fn build(settings: &Settings) -> Result<Box<dyn Dynamics>, ModelError> {
    Ok(Box::new(Ideal {
        lowest: -settings.optional_number("max_deceleration").unwrap_or(f64::INFINITY),
        highest: settings.optional_number("max_acceleration").unwrap_or(f64::INFINITY),
    }))
}

impl Ideal {
    /// m/s²
    fn acceleration(&self, command: Command) -> f64 {
        let Command::Acceleration(wanted) = command else {
            panic!("`ideal` takes accelerations, not pedals");
        };
        wanted.clamp(self.lowest, self.highest)
    }
}

impl Dynamics for Ideal {
    fn advance(&mut self, motion: &mut Longitudinal, command: Command, step: f64) {
        motion.accelerate(self.acceleration(command), step);
    }

    fn advance_on(&mut self, ground: &Ground, motion: &mut Longitudinal, command: Command, step: f64) {
        ground.accelerate(motion, self.acceleration(command), step);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::dynamics::tests::{built, cruising, stop};
    use scenario::Value;

    #[test]
    fn stops_where_the_textbook_says() {
        for step in [0.025, 0.04, 0.05] {
            let (distance, _) =
                stop(&mut *built(&ideal(), Settings::default()), Command::Acceleration(-4.0), step);
            assert!((distance - (30.0f64 / 3.6).powi(2) / 8.0).abs() < 1e-12, "{distance}");
        }
    }

    #[test]
    fn limits_clamp() {
        let settings = Settings::from([
            ("max_acceleration", Value::Number(1.0)),
            ("max_deceleration", Value::Number(2.0)),
        ]);
        let mut car = built(&ideal(), settings);
        let mut motion = cruising();
        car.advance(&mut motion, Command::Acceleration(-9.0), 0.1);
        assert!((motion.acceleration + 2.0).abs() < 1e-12);
        car.advance(&mut motion, Command::Acceleration(9.0), 0.1);
        assert!((motion.acceleration - 1.0).abs() < 1e-12);
    }
}
