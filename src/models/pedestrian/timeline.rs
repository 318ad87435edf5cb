//! A pedestrian that walks by a scripted timeline.

use nalgebra::Vector2;

use super::{PedestrianContext, PedestrianModel};
use scenario::agent::ScriptStep;
use scenario::{
    Chance, Declaration, Dimension, Parameter, Settings, Side, SignalConduct, TextError, VehicleReference,
};
use sim::script::{Action, Script, ScriptQuantity, parameters};
use sim::{Mode, ModelError, Motion, Pedestrian, Scene, geometry};

pub fn timeline() -> PedestrianModel {
    let declaration = Declaration::new("timeline", "Walks by scripted steps; `when` compares distance, time_to_arrival, vehicle_speed, walked, distance_to_kerb or speed.").source("conditions and actions after ASAM OpenSCENARIO").parameters(parameters(check)).parameters([
                Parameter::number(
                    "walking_speed",
                    Dimension::SPEED,
                    1.4,
                    (0.0, 12.0),
                    "Speed at first and after `resume`.",
                    "free choice",
                ),
                Parameter::flag(
                    "walks_at_once",
                    true,
                    "Whether it walks from the beginning; otherwise it stands until a step says more.",
                    "free choice",
                ),
            ]);
    PedestrianModel::new(declaration, build).chance(Chance::Never).fixed(is_fixed).told_where_to_go().signals(
        SignalConduct::Never { cure: "let `appears at` or a step say when it walks, or take `scripted`" },
    )
}

/// Whether no step compares what depends on a vehicle, and nobody else is minded.
fn is_fixed(settings: &Settings) -> bool {
    if settings.optional_number("keeps_clear").is_some() {
        return false;
    }
    const OWN: [&str; 3] = ["walked", "distance_to_kerb", "speed"];
    let script = Script::from_settings(settings, "timeline", QUANTITIES);
    script.is_ok_and(|script| script.compares().all(|index| OWN.contains(&QUANTITIES[index].0)))
}

/// `distance`: to the nearest vehicle's footprint; `time_to_arrival`: of the front of the next vehicle at the
/// pedestrian's place along the road; `vehicle_speed`: of the nearest vehicle; `walked`: since it appeared;
/// `distance_to_kerb`: to the kerb that it starts from, negative on the road. Times count from its appearance.
const QUANTITIES: &[ScriptQuantity] = &[
    ("distance", Dimension::LENGTH),
    ("time_to_arrival", Dimension::TIME),
    ("vehicle_speed", Dimension::SPEED),
    ("walked", Dimension::LENGTH),
    ("distance_to_kerb", Dimension::LENGTH),
    ("speed", Dimension::SPEED),
];

fn check(steps: &str, given: &dyn Fn(&str) -> bool) -> Vec<TextError> {
    Script::check(steps, "timeline", QUANTITIES, given)
}

struct ByTimeline {
    script: Script,
    walking_speed: f64,
    action: Action,
    side: Side,
    /// Place and time at which it appeared.
    origin: Option<(Vector2<f64>, f64)>,
}

fn build(context: &PedestrianContext) -> Result<Box<dyn Pedestrian>, ModelError> {
    let settings = context.settings;
    Ok(Box::new(ByTimeline {
        script: Script::from_settings(settings, "timeline", QUANTITIES)?,
        walking_speed: settings.number("walking_speed"),
        action: if settings.flag("walks_at_once") { Action::Resume } else { Action::Stop },
        side: context.setup.side,
        origin: None,
    }))
}

fn quantity(scene: &Scene, side: Side, origin: Vector2<f64>, index: usize) -> f64 {
    let ego = scene.ego();
    let nearest = scene
        .vehicles
        .iter()
        .map(|vehicle| (geometry::distance(vehicle, ego), vehicle.motion.speed))
        // Of equally near ones the fastest, in whatever order they come.
        .min_by(|one, other| one.0.total_cmp(&other.0).then(other.1.total_cmp(&one.1)));
    match QUANTITIES[index].0 {
        "distance" => nearest.map_or(f64::INFINITY, |(distance, _)| distance),
        "vehicle_speed" => nearest.map_or(0.0, |(_, speed)| speed),
        "time_to_arrival" => scene
            .vehicles
            .iter()
            .map(|vehicle| vehicle.time_to_arrival(vehicle.path.along(ego.position), VehicleReference::Front))
            .filter(|time| *time >= 0.0)
            .fold(f64::INFINITY, f64::min),
        "walked" => (ego.position - origin).norm(),
        "distance_to_kerb" => side.walking_sign() * (scene.road.kerb(side) - scene.road.across(ego.position)),
        _ => ego.velocity.norm(),
    }
}

impl Pedestrian for ByTimeline {
    fn act(&mut self, scene: &Scene) -> Motion {
        let ego = scene.ego();
        let (origin, appeared) = *self.origin.get_or_insert((ego.position, scene.time));
        let side = self.side;
        let quantity = |index| quantity(scene, side, origin, index);
        if let Some(action) = self.script.due(scene.time - appeared, quantity) {
            self.action = action;
        }
        let to_goal = Vector2::new(scene.goal.x, scene.goal.y) - ego.position;
        let Some(way) = to_goal.try_normalize(1e-9) else {
            return Motion::Walk(Vector2::zeros());
        };
        let walk = |speed: f64| Motion::Walk(way * speed.min(to_goal.norm() / scene.step));
        match self.action {
            Action::Speed(speed) => walk(speed),
            Action::Accelerate(_) if way.dot(&ego.heading) < 0.0 => Motion::Walk(Vector2::zeros()),
            Action::Accelerate(acceleration) => Motion::Accelerate(acceleration),
            Action::Stop => Motion::Walk(Vector2::zeros()),
            Action::Resume => walk(self.walking_speed),
        }
    }

    fn waiting_steps(&self) -> Vec<ScriptStep> {
        self.script.waiting_steps()
    }

    fn mode(&self) -> Mode {
        Mode::new(match self.action {
            Action::Speed(_) => "speed",
            Action::Accelerate(_) => "accelerate",
            Action::Stop => "standing",
            Action::Resume => "walking",
        })
    }

    fn free_speed(&self) -> f64 {
        self.walking_speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pedestrian::test_walk::Walk;
    use scenario::Value;

    fn walk(steps: &str, numbers: &[(&str, f64)]) -> Walk {
        let mut settings = Settings::from([("steps", Value::Word(steps.into()))]);
        for (name, value) in numbers {
            settings.set(*name, Value::Number(*value));
        }
        Walk::new(&timeline(), settings)
    }

    #[test]
    fn stops_on_the_road_for_a_near_car_and_goes_on() {
        let mut walk =
            walk("when distance < d1 stop; after t1 speed v1", &[("d1", 10.0), ("t1", 2.0), ("v1", 3.0)]);
        walk.add_car(-40.0, 10.0);
        walk.go(3.0);
        assert_eq!(walk.pedestrian.mode(), "standing");
        let place = walk.position().y;
        walk.go(1.0);
        assert_eq!(walk.position().y, place);
        walk.go(2.0);
        assert!(walk.position().y - place > 1.5);
    }

    #[test]
    fn stops_before_the_kerb() {
        let mut walk = walk("when distance_to_kerb < d1 stop", &[("d1", 0.5)]);
        walk.go(10.0);
        assert!((walk.position().y + 2.5).abs() < 0.04, "{}", walk.position().y);
    }

    #[test]
    fn triggers_on_walked_distance_speed_and_arrival() {
        let mut by_way = walk(
            "when walked > d1 accelerate a1; when speed > v1 stop",
            &[("d1", 1.0), ("a1", 1.0), ("v1", 2.0)],
        );
        by_way.go(3.0);
        assert_eq!(by_way.pedestrian.mode(), "standing");
        let mut by_arrival = walk("when time_to_arrival < t1 stop", &[("t1", 3.0)]);
        by_arrival.add_car(-50.0 - 2.257, 10.0);
        by_arrival.go(1.9);
        assert_eq!(by_arrival.pedestrian.mode(), "walking");
        by_arrival.go(0.2);
        assert_eq!(by_arrival.pedestrian.mode(), "standing");
    }

    #[test]
    fn stays_at_its_goal_even_when_accelerating() {
        let mut walk = walk("at t1 accelerate a1", &[("t1", 0.0), ("a1", 1.0)]);
        walk.go(20.0);
        let place = walk.position().y;
        assert!((6.0..6.2).contains(&place), "{place}");
        walk.go(5.0);
        assert_eq!(walk.position().y, place);
    }
}
