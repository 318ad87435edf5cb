//! The social force pedestrian of Helbing and Molnár 1995, with vehicles as obstacles that it keeps away from.
//!
//! It makes no decision to wait or go: it walks to its goal, slowed or sped up by the repulsion of vehicles and other people. Vehicles
//! move it along its way only; people also to the side, but not back.

use nalgebra::Vector2;

use super::sum::sum_in_any_order;
use super::{PedestrianContext, PedestrianModel};
use crate::pedestrian::across::check_on_foot;
use numbers::random::Stream;
use scenario::{Chance, Declaration, Dimension, Parameter};
use sim::random::{Agent, Purpose, stream};
use sim::sight::sees_vehicle;
use sim::{Mode, ModelError, Motion, Pedestrian, PedestrianState, Scene, VehicleState};

const PAPER: &str = "Helbing & Molnar 1995, Phys. Rev. E 51:4282";
const CHOICE: &str = "our choice; the paper has no vehicles";

pub fn social_force() -> PedestrianModel {
    let declaration = Declaration::new(
        "social_force",
        "Helbing-Molnar social force: walks to its goal and is repelled by vehicles and people, \
         without any decision.",
    )
    .source(
        "Helbing & Molnar 1995, Phys. Rev. E 51:4282; vehicles as obstacles by our \
         choice",
    )
    .parameters([
        Parameter::optional(
            "desired_speed",
            Dimension::SPEED,
            (0.1, 3.0),
            "Speed at which it wants to walk; without it, drawn once per run from the \
             normal distribution below.",
            PAPER,
        ),
        Parameter::number(
            "desired_speed_mean",
            Dimension::SPEED,
            1.34,
            (0.5, 3.0),
            "Mean of the drawn desired speed.",
            PAPER,
        ),
        Parameter::number(
            "desired_speed_deviation",
            Dimension::SPEED,
            0.26,
            (0.0, 1.0),
            "Standard deviation of the drawn desired speed; draws below 0.1 m/s are raised \
             to it.",
            PAPER,
        ),
        Parameter::number(
            "relaxation_time",
            Dimension::TIME,
            0.5,
            (0.07, 2.0),
            "Time in which it approaches its desired speed.",
            PAPER,
        ),
        Parameter::number(
            "max_speed_factor",
            Dimension::NUMBER,
            1.3,
            (1.0, 3.0),
            "Its speed never exceeds this many times its desired speed.",
            PAPER,
        ),
        Parameter::number(
            "start_delay",
            Dimension::TIME,
            0.0,
            (0.0, 600.0),
            "Time that it stands after it appeared; vary it up to the vehicle's arrival \
             time for conflicts.",
            CHOICE,
        ),
        Parameter::number(
            "vehicle_strength",
            Dimension::new(2, -2, 0),
            10.0,
            (0.0, 100.0),
            "Strength of a vehicle's repulsive potential; the paper's value for borders.",
            CHOICE,
        ),
        Parameter::number(
            "vehicle_range",
            Dimension::LENGTH,
            1.0,
            (0.3, 10.0),
            "Range of a vehicle's repulsive potential: a design choice, to be swept from \
             0.5 to 5 m.",
            CHOICE,
        ),
        Parameter::optional(
            "person_strength",
            Dimension::new(2, -2, 0),
            (0.0, 100.0),
            "Strength of another person's repulsive potential; without it, the paper's 2.1 m^2/s^2.",
            PAPER,
        ),
        Parameter::optional(
            "person_range",
            Dimension::LENGTH,
            (0.1, 10.0),
            "Range of another person's repulsive potential; without it, the paper's 0.3 m.",
            PAPER,
        ),
        Parameter::number(
            "look_ahead",
            Dimension::TIME,
            2.0,
            (0.0, 10.0),
            "Driving or walking time by which the potential of a vehicle or another person stretches ahead of it.",
            PAPER,
        ),
        Parameter::number(
            "view_angle",
            Dimension::ANGLE,
            200.0 * std::f64::consts::PI / 180.0,
            (0.0, 2.0 * std::f64::consts::PI),
            "Full angle of its view, around its way.",
            PAPER,
        ),
        Parameter::number(
            "unseen_weight",
            Dimension::NUMBER,
            0.5,
            (0.0, 1.0),
            "Weight of repulsion from outside its view.",
            PAPER,
        ),
        Parameter::number(
            "body_radius",
            Dimension::LENGTH,
            0.3,
            (0.2, 0.35),
            "Its body's radius, taken off its distance from vehicles together with half \
             their width.",
            CHOICE,
        ),
        Parameter::number(
            "noise",
            Dimension::SPEED,
            0.0,
            (0.0, 1.0),
            "Standard deviation of the fluctuation of its speed in free walking.",
            "form of the paper's fluctuations by our choice",
        ),
    ]);
    PedestrianModel::new(declaration, build).in_legs().chance(Chance::If(|settings| {
        let drawn_speed = settings.optional_number("desired_speed").is_none()
            && settings.number("desired_speed_deviation") > 0.0;
        drawn_speed || settings.number("noise") > 0.0
    }))
}

/// Nearer to its goal than this it has arrived, m.
const ARRIVAL: f64 = 0.2;
/// Keeps the force finite on the vehicle's centre line, m.
const SMALLEST_AXIS: f64 = 0.1;
const TIME_TOLERANCE: f64 = 1e-9;
/// Slowest desired speed that is drawn, m/s.
const SLOWEST: f64 = 0.1;

struct SocialForce {
    desired_speed: f64,
    relaxation_time: f64,
    max_speed: f64,
    start_delay: f64,
    repulsion: Repulsion,
    noise: f64,
    fluctuations: Stream,
    /// When it appeared, s.
    appeared: Option<f64>,
    /// To which velocity other people have pushed it to the left of its way, m/s.
    aside: f64,
    mode: &'static str,
}

/// The paper's repulsive potential of another person, m²/s² and m.
const PERSON: (f64, f64) = (2.1, 0.3);

/// The repulsive potentials of vehicles and of other people.
struct Repulsion {
    /// m²/s²
    strength: f64,
    /// m
    range: f64,
    /// The same of people.
    person: (f64, f64),
    /// s
    look_ahead: f64,
    /// Cosine of half the view angle.
    view: f64,
    unseen_weight: f64,
    body_radius: f64,
}

fn build(context: &PedestrianContext) -> Result<Box<dyn Pedestrian>, ModelError> {
    check_on_foot(context, "social_force")?;
    let settings = context.settings;
    let me = Agent::Pedestrian(context.rank);
    let drawn = stream(context.seed, me, Purpose::Trait).normal();
    let desired_speed = settings.optional_number("desired_speed").unwrap_or_else(|| {
        let drawn =
            settings.number("desired_speed_mean") + settings.number("desired_speed_deviation") * drawn;
        drawn.max(SLOWEST)
    });
    Ok(Box::new(SocialForce {
        desired_speed,
        relaxation_time: settings.number("relaxation_time"),
        max_speed: settings.number("max_speed_factor") * desired_speed,
        start_delay: settings.number("start_delay"),
        repulsion: Repulsion {
            strength: settings.number("vehicle_strength"),
            range: settings.number("vehicle_range"),
            person: (
                settings.optional_number("person_strength").unwrap_or(PERSON.0),
                settings.optional_number("person_range").unwrap_or(PERSON.1),
            ),
            look_ahead: settings.number("look_ahead"),
            view: libm::cos(settings.number("view_angle") / 2.0),
            unseen_weight: settings.number("unseen_weight"),
            body_radius: settings.number("body_radius"),
        },
        noise: settings.number("noise"),
        fluctuations: stream(context.seed, me, Purpose::Motion),
        appeared: None,
        aside: 0.0,
        mode: "waiting",
    }))
}

impl Repulsion {
    /// On a pedestrian at `position` on its way along the unit vector `way`, m/s².
    fn force(&self, vehicle: &VehicleState, position: Vector2<f64>, way: Vector2<f64>) -> Vector2<f64> {
        let heading = vehicle.heading();
        let half_length = vehicle.length / 2.0;
        let along = (position - vehicle.position()).dot(&heading).clamp(-half_length, half_length);
        let from_now = position - (vehicle.position() + heading * along);
        let stride = heading * (vehicle.motion.speed * self.look_ahead);
        let solid = vehicle.width / 2.0 + self.body_radius;
        self.seen(gradient((self.strength, self.range), from_now, stride, solid), way)
    }

    /// Of another person: the paper's equation 3, with its distance between centres.
    fn force_of_person(
        &self,
        other: &PedestrianState,
        position: Vector2<f64>,
        way: Vector2<f64>,
    ) -> Vector2<f64> {
        let stride = other.velocity * self.look_ahead;
        self.seen(gradient(self.person, position - other.position, stride, 0.0), way)
    }

    /// What counts of a force on somebody who looks along the unit vector `way`.
    fn seen(&self, force: Vector2<f64>, way: Vector2<f64>) -> Vector2<f64> {
        let seen = -way.dot(&force) >= force.norm() * self.view;
        if seen { force } else { force * self.unseen_weight }
    }
}

/// The force (m/s²) of a potential with this strength (m²/s²) and range (m) at a place `from_now` (m) away from what goes `stride` (m) within
/// the time that is looked ahead, and of which so much (m) is solid. The lines of equal potential are ellipses along the stride.
fn gradient(
    (strength, range): (f64, f64),
    from_now: Vector2<f64>,
    stride: Vector2<f64>,
    solid: f64,
) -> Vector2<f64> {
    let from_then = from_now - stride;
    let sum = from_now.norm() + from_then.norm();
    let axis = libm::sqrt((sum * sum - stride.norm_squared()).max(0.0)) / 2.0;
    let free = (axis - solid).max(0.0);
    let unit = |vector: Vector2<f64>| vector.try_normalize(0.0).unwrap_or_else(Vector2::zeros);
    (unit(from_now) + unit(from_then))
        * (strength / range * libm::exp(-free / range) * sum / (4.0 * axis.max(SMALLEST_AXIS)))
}

impl Pedestrian for SocialForce {
    fn act(&mut self, scene: &Scene) -> Motion {
        let still = Motion::Walk(Vector2::zeros());
        let appeared = *self.appeared.get_or_insert(scene.time);
        if scene.time - appeared < self.start_delay - TIME_TOLERANCE || self.mode == "finished" {
            return still;
        }
        let ego = scene.ego();
        let to_goal = Vector2::new(scene.goal.x, scene.goal.y) - ego.position;
        // A leg ends on the refuge itself.
        let arrival = if scene.goes_on() { 0.0 } else { ARRIVAL };
        let Some(way) = to_goal.try_normalize(arrival) else {
            self.mode = "finished";
            return still;
        };
        self.mode = "walking";
        let speed = ego.velocity.dot(&way);
        let seen = scene.vehicles.iter().enumerate().filter(|(index, _)| sees_vehicle(scene, *index));
        let forces = seen.map(|(_, vehicle)| self.repulsion.force(vehicle, ego.position, way));
        let others = scene.pedestrians.iter().enumerate();
        let others = others.filter(|(index, other)| *index != scene.me && other.present);
        let people = others.map(|(_, other)| self.repulsion.force_of_person(other, ego.position, way));
        let (from_vehicles, from_people) = (sum_in_any_order(forces), sum_in_any_order(people));
        let mut faster = speed
            + ((self.desired_speed - speed) / self.relaxation_time + from_vehicles.dot(&way)) * scene.step;
        // At most people stop it: a group that comes head on would else walk it backwards all the way.
        faster = (faster + from_people.dot(&way) * scene.step).max(faster.min(0.0));
        if self.noise > 0.0 {
            // White noise of acceleration whose effect on the relaxing speed has this standard deviation.
            faster +=
                self.noise * libm::sqrt(2.0 * scene.step / self.relaxation_time) * self.fluctuations.normal();
        }
        let left = Vector2::new(-way.y, way.x);
        self.aside += (from_people.dot(&left) - self.aside / self.relaxation_time) * scene.step;
        let ahead = way * faster.clamp(-self.max_speed, self.max_speed);
        // Who is alone has no side to go to, not even one of 0.
        Motion::Walk(match self.aside == 0.0 {
            true => ahead,
            false => (ahead + left * self.aside).cap_magnitude(self.max_speed),
        })
    }

    fn mode(&self) -> Mode {
        Mode::new(self.mode)
    }

    fn free_speed(&self) -> f64 {
        self.desired_speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pedestrian::test_walk::Walk;
    use scenario::{Direction, Path, Settings, Value};
    use sim::Longitudinal;

    fn standing_car() -> VehicleState {
        VehicleState::new(
            Path::straight(0.0, Direction::Forward),
            Longitudinal { travelled: 0.0, speed: 0.0, acceleration: 0.0 },
            (4.9, 2.1),
        )
    }

    fn repulsion() -> Repulsion {
        let view = libm::cos(100.0_f64.to_radians());
        Repulsion {
            strength: 10.0,
            range: 1.0,
            look_ahead: 2.0,
            view,
            unseen_weight: 0.5,
            body_radius: 0.3,
            person: PERSON,
        }
    }

    /// Beside a standing car the ellipse is a circle: V / sigma * exp(-(|r| - w/2 - R) / sigma), away from it.
    #[test]
    fn a_standing_car_repels_like_a_wall() {
        let at = |y: f64, way: f64| {
            repulsion().force(&standing_car(), Vector2::new(0.0, y), Vector2::new(0.0, way)).y
        };
        let expected = -10.0 * libm::exp(-(3.0 - 1.05 - 0.3));
        assert!((at(-3.0, 1.0) - expected).abs() < 1e-12);
        // Behind its back it counts half.
        assert!((at(-3.0, -1.0) - expected / 2.0).abs() < 1e-12);
        assert_eq!(at(0.0, 1.0), 0.0);
    }

    #[test]
    fn the_force_is_the_gradient_of_the_potential() {
        let car = standing_car().in_motion(Longitudinal { speed: 8.0, ..standing_car().motion });
        // V exp(-b*/sigma) with b from the paper's equation 4; all of it seen.
        let potential = |p: Vector2<f64>| {
            let r = p - Vector2::new(2.45, 0.0);
            let s = 16.0;
            let sum = r.norm() + (r - Vector2::new(s, 0.0)).norm();
            10.0 * libm::exp(-(0.5 * libm::sqrt(sum * sum - s * s) - 1.35))
        };
        let place = Vector2::new(9.0, -2.5);
        let seeing = Repulsion { unseen_weight: 1.0, ..repulsion() };
        let force = seeing.force(&car, place, Vector2::y());
        let h = 1e-5;
        let slope = |way: Vector2<f64>| (potential(place + way * h) - potential(place - way * h)) / (2.0 * h);
        let gradient = Vector2::new(slope(Vector2::x()), slope(Vector2::y()));
        assert!((force + gradient).norm() < 1e-6, "{force} {gradient}");
    }

    /// The paper's V = 2.1 m^2/s^2 exp(-b / 0.3 m); of somebody who stands b is the distance.
    #[test]
    fn a_standing_person_repels_as_published() {
        let other = PedestrianState {
            position: Vector2::zeros(),
            velocity: Vector2::zeros(),
            acceleration: Vector2::zeros(),
            heading: Vector2::y(),
            shape: scenario::Shape::Disc { radius: 0.25 },
            present: true,
        };
        let at = |y: f64, way: f64| {
            repulsion().force_of_person(&other, Vector2::new(0.0, y), Vector2::new(0.0, way)).y
        };
        let expected = -2.1 / 0.3 * libm::exp(-0.9 / 0.3);
        assert!((at(-0.9, 1.0) - expected).abs() < 1e-12);
        assert!((at(-0.9, -1.0) - expected / 2.0).abs() < 1e-12);
        // Who comes nearer reaches farther ahead.
        let coming = PedestrianState { velocity: Vector2::new(0.0, -1.0), ..other };
        let force = repulsion().force_of_person(&coming, Vector2::new(0.0, -3.0), Vector2::y());
        assert!(force.y < 3.0 * at(-3.0, 1.0), "{force}");
    }

    /// The slope of the paper's potential in one step, across the way as well; and who is rushed at stands.
    #[test]
    fn people_push_to_the_side_and_never_back() {
        let given = || Settings::from([("desired_speed", Value::Number(1.4))]);
        let mut walk = Walk::new(&social_force(), given());
        let offset = Vector2::new(-0.3, 0.6);
        walk.add_person(walk.position() + offset, Vector2::zeros());
        let Motion::Walk(first) = walk.step() else { panic!("it walks") };
        let away = -offset.normalize() * (2.1 / 0.3 * libm::exp(-offset.norm() / 0.3));
        assert!((first.x - away.x * 0.025).abs() < 1e-12 && away.x > 0.0, "{first}");
        assert!((first.y - (1.4 / 0.5 + away.y) * 0.025).abs() < 1e-12, "{first}");

        let mut walk = Walk::new(&social_force(), given());
        walk.add_person(walk.position() + Vector2::new(0.0, 0.55), Vector2::new(0.0, -0.25));
        for _ in 0..40 {
            walk.step();
            assert!(walk.state().velocity.y >= 0.0);
        }
    }

    #[test]
    fn fluctuations_have_the_declared_deviation() {
        let given = Settings::from([
            ("noise", Value::Number(0.2)),
            ("desired_speed", Value::Number(1.3)),
            ("max_speed_factor", Value::Number(3.0)),
        ]);
        let mut walk = Walk::new(&social_force(), given);
        walk.world.pedestrians[0].goal.y = 1e6;
        let speeds: Vec<_> = (0..40_000)
            .map(|_| {
                walk.step();
                walk.state().velocity.y
            })
            .skip(1000)
            .collect();
        let mean = speeds.iter().sum::<f64>() / speeds.len() as f64;
        let deviation = (speeds.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / speeds.len() as f64).sqrt();
        assert!((mean - 1.3).abs() < 0.03 && (deviation - 0.2).abs() < 0.015, "{mean} {deviation}");
    }

    #[test]
    fn walks_to_its_goal_at_its_drawn_speed_and_stays() {
        let mut speeds = Vec::new();
        for seed in 0..50 {
            let mut walk = Walk::seeded(&social_force(), Settings::default(), seed).unwrap();
            speeds.push(walk.pedestrian.free_speed());
            walk.go(40.0);
            assert!((walk.position().y - 6.0).abs() < 0.2 && walk.state().velocity.norm() == 0.0);
        }
        let mean = speeds.iter().sum::<f64>() / 50.0;
        assert!((mean - 1.34).abs() < 0.12, "{mean}");
    }
}
