//! Brakes for whoever is near.

use scenario_runner_av::{serve, About, Answer, Command, Controller, Gives, Parameter, Run, Seen};

/// The controller.
pub struct Brake {
    braking_distance: f64,
}

impl Controller for Brake {
    fn start(run: &Run) -> Result<Self, String> {
        Ok(Self { braking_distance: run.number("braking_distance")? })
    }

    fn step(&mut self, seen: &Seen) -> Result<Answer, String> {
        let near = seen
            .pedestrians
            .iter()
            .any(|one| 0.0 < one.x && one.x < self.braking_distance && one.y.abs() < 4.0);
        let brakes = near && seen.speed > 0.0;
        let acceleration = if brakes { -3.0 } else { 0.5 * (seen.cruise_speed - seen.speed) };
        Ok(Answer {
            command: Command::Acceleration(acceleration),
            mode: Some(usize::from(brakes)),
            curvature: None,
        })
    }
}

/// What the runner is told of it.
pub fn about() -> About {
    About {
        name: "brake".into(),
        version: "1".into(),
        gives: Gives::Acceleration,
        runs_at_once: 64,
        modes: vec!["cruise".into(), "brake".into()],
        parameters: vec![Parameter::number("braking_distance", "m", 25.0, (1.0, 60.0))],
    }
}

fn main() -> std::io::Result<()> {
    serve::<Brake>(&about())
}
