//! A controller of one's own: declared, registered, run by scenarios that name it, tuned, and shown in a table.

mod own;

use std::error::Error;

use scenario_runner::models::standard;
use scenario_runner::registry::Registry;
use scenario_runner::scenario::{Chance, CommandKind, ControllerModel, Declaration, Dimension};
use scenario_runner::sim::{Command, Controller, ControllerError, Observation, Schedule};

/// Stops before the crossing as long as it sees anybody on the road.
struct Patient {
    comfort: f64,
    margin: f64,
}

impl Controller for Patient {
    fn schedule(&self) -> Schedule {
        Schedule::every(0.05)
    }

    fn act(&mut self, seen: &Observation) -> Result<Command, ControllerError> {
        let (ego, road) = (&seen.ego, &seen.road);
        let ahead = ego.distance_to_crossing - ego.length / 2.0 - self.margin;
        let on_road = |y: f64| road.right_kerb - 1.0 < y && y < road.left_kerb + 1.0;
        let waits = ahead > 0.0 && seen.pedestrians.iter().any(|one| on_road(one.position.y));
        let needed = ego.speed * ego.speed / (2.0 * ahead.max(0.1));
        Ok(Command::Acceleration(match waits {
            true if needed > 0.8 * self.comfort => -needed,
            _ => (seen.cruise_speed - ego.speed).clamp(-self.comfort, self.comfort),
        }))
    }
}

fn registry() -> Result<Registry, Box<dyn Error>> {
    let declaration = Declaration::new("patient", "Stops for whoever is on the road.")
        .source("an example")
        .number("comfort", Dimension::ACCELERATION, 2.0, (0.5, 8.0), "Deceleration that it likes.")
        .number("margin", Dimension::LENGTH, 4.0, (0.0, 10.0), "From its stop to the crossing.");
    let patient = ControllerModel::new(declaration, CommandKind::Acceleration, |context| {
        let number = |name| context.settings.number(name);
        Ok(Box::new(Patient { comfort: number("comfort"), margin: number("margin") }))
    });
    Ok(standard().with_controller(patient.chance(Chance::Never))?)
}

pub(crate) fn table() -> Result<String, Box<dyn Error>> {
    own::tables("examples/own_controller.scn", &registry()?)
}

#[allow(dead_code, reason = "tests ask for the table")]
fn main() -> Result<(), Box<dyn Error>> {
    println!("{}", table()?);
    Ok(())
}
