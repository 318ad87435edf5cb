//! A pedestrian of one's own: declared, registered, run by scenarios that name it, and shown in a table.

mod own;

use std::error::Error;

use scenario_runner::models::standard;
use scenario_runner::registry::Registry;
use scenario_runner::scenario::{Chance, Declaration, Dimension, PedestrianModel};
use scenario_runner::sim::{Motion, Pedestrian, Scene};

/// Walks once every vehicle is farther away than it dares.
struct Shy {
    speed: f64,
    distance: f64,
    walks: bool,
}

impl Pedestrian for Shy {
    fn act(&mut self, scene: &Scene) -> Motion {
        let me = scene.ego();
        let far = |car: f64| car < 0.0 || car > self.distance;
        let mut cars = scene.vehicles.iter().map(|car| car.distance_to(me.position.x, Default::default()));
        self.walks |= cars.all(far);
        let speed = if self.walks { self.speed } else { 0.0 };
        Motion::Walk(me.heading * speed)
    }

    fn free_speed(&self) -> f64 {
        self.speed
    }
}

fn registry() -> Result<Registry, Box<dyn Error>> {
    let declaration = Declaration::new("shy", "Walks once every vehicle is far away or has passed.")
        .source("an example")
        .number("speed", Dimension::SPEED, 1.4, (0.1, 5.0), "Speed of walking.")
        .number("distance", Dimension::LENGTH, 30.0, (0.0, 200.0), "How far away it wants vehicles to be.");
    let shy = PedestrianModel::new(declaration, |context| {
        let number = |name| context.settings.number(name);
        Ok(Box::new(Shy { speed: number("speed"), distance: number("distance"), walks: false }))
    });
    Ok(standard().with_pedestrian(shy.chance(Chance::Never))?)
}

pub(crate) fn table() -> Result<String, Box<dyn Error>> {
    own::tables("examples/own_pedestrian.scn", &registry()?)
}

#[allow(dead_code, reason = "tests ask for the table")]
fn main() -> Result<(), Box<dyn Error>> {
    println!("{}", table()?);
    Ok(())
}
