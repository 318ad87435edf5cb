//! Imperfect perception, the same for every controller: what `sees { … }` leaves out, delays or blurs.

use std::sync::Arc;

use nalgebra::Vector2;

use super::{ControllerContext, PerceptionModel};
use numbers::random::Stream;
use scenario::{Chance, Declaration, Dimension, Parameter, Path, Settings};
use sim::geometry::Footprint;
use sim::random::{Agent, Purpose, stream};
use sim::sight::is_hidden;
use sim::{
    ModelError, Observation, Perception, RoadView, Schedule, SeenPedestrian, SeenVehicle, Snapshot, Solid,
};

const FREE: &str = "free choice";

/// The perception that ships. It draws where it loses or blurs what it sees.
pub fn perception() -> PerceptionModel {
    let draws = |settings: &Settings| {
        ["dropout", "position_noise", "velocity_noise"].iter().any(|name| settings.number(name) > 0.0)
    };
    PerceptionModel {
        declaration: declaration(),
        chance: Chance::If(draws),
        build: Arc::new(with_perception),
    }
}

/// What `sees { … }` takes. A vehicle without it sees everything at once and exactly, through boxes and others too.
fn declaration() -> Declaration {
    Declaration::new(
        "sees",
        "What a controller perceives of pedestrians and vehicles: field of view, \
         range, occlusion, latency, dropout, noise.",
    )
    .source("generic sensor and tracker; the ego's own state stays exact")
    .parameters([
        Parameter::optional(
            "range",
            Dimension::LENGTH,
            (0.0, 1000.0),
            "Distance from the sensor within which others are seen; without it, any.",
            FREE,
        ),
        Parameter::optional(
            "field_of_view",
            Dimension::ANGLE,
            (0.0, 2.0 * std::f64::consts::PI),
            "Opening angle around straight ahead within which others are seen; without it, \
             all around.",
            FREE,
        ),
        Parameter::flag(
            "occlusion",
            true,
            "Whether boxes hide those whose centre is behind them, and vehicles and people those of whom they cover \
             most.",
            "line of sight",
        ),
        Parameter::number(
            "sensor_setback",
            Dimension::LENGTH,
            0.0,
            (0.0, 20.0),
            "How far behind the front bumper's middle the sensor is.",
            FREE,
        ),
        Parameter::number(
            "latency",
            Dimension::TIME,
            0.0,
            (0.0, 5.0),
            "Age of what is seen; others are where they were, the ego's own motion is \
             accounted for. Rounded up to decisions.",
            FREE,
        ),
        Parameter::number(
            "dropout",
            Dimension::NUMBER,
            0.0,
            (0.0, 1.0),
            "Chance per decision that somebody in view is lost.",
            FREE,
        ),
        Parameter::number(
            "dropout_duration",
            Dimension::TIME,
            0.0,
            (0.0, 60.0),
            "Time that somebody lost stays lost; 0 is that decision only.",
            FREE,
        ),
        Parameter::number(
            "position_noise",
            Dimension::LENGTH,
            0.0,
            (0.0, 20.0),
            "Standard deviation of positions, each axis, independent per decision.",
            FREE,
        ),
        Parameter::number(
            "velocity_noise",
            Dimension::SPEED,
            0.0,
            (0.0, 20.0),
            "Standard deviation of velocities, each axis, independent per decision.",
            FREE,
        ),
    ])
}

/// The perception that `settings` (resolved against [`declaration`]) describe, for a controller that decides at the
/// moments of `schedule`.
fn with_perception(
    settings: &Settings,
    context: &ControllerContext,
    schedule: Schedule,
) -> Result<Box<dyn Perception>, ModelError> {
    let path = context.world.path_of(context.setup);
    let occlusion = settings.flag("occlusion");
    let boxes = if occlusion { context.world.road.boxes.as_slice() } else { &[] };
    let world_boxes: Vec<_> = boxes.iter().map(Footprint::from).collect();
    let boxes = boxes.iter().map(|body| {
        let outline = Footprint::from(body);
        if path.course().is_some() {
            return outline;
        }
        Footprint { centre: path.from_world(outline.centre), ..outline }
    });
    let boxes = boxes.collect();
    let latency = settings.number("latency");
    let interval = schedule.shortest();
    let frames = (latency / interval).ceil() as usize + 2;
    let (pedestrians, vehicles) = (context.world.pedestrians.len(), context.world.vehicles.len());
    let frame = || Frame {
        time: f64::NEG_INFINITY,
        pedestrians: Vec::with_capacity(pedestrians),
        vehicles: Vec::with_capacity(vehicles),
    };
    let setback = settings.number("sensor_setback");
    Ok(Box::new(Perceiving {
        hiding: occlusion.then(|| Hiding {
            setback,
            boxes: world_boxes,
            bodies: Vec::with_capacity(pedestrians + vehicles),
            pedestrians: vec![false; pedestrians],
            vehicles: vec![false; vehicles],
        }),
        sight: Sight {
            range: settings.optional_number("range").unwrap_or(f64::INFINITY),
            half_angle: settings.optional_number("field_of_view").map_or(f64::INFINITY, |angle| angle / 2.0),
            setback,
            boxes,
            path,
        },
        blur: Blur {
            dropout: settings.number("dropout"),
            dropout_duration: settings.number("dropout_duration"),
            position_noise: settings.number("position_noise"),
            velocity_noise: settings.number("velocity_noise"),
            stream: stream(context.seed, Agent::Vehicle(context.rank), Purpose::Sensing),
        },
        latency,
        lost_pedestrians: vec![f64::NEG_INFINITY; pedestrians],
        lost_vehicles: vec![f64::NEG_INFINITY; vehicles],
        frames: (0..frames).map(|_| frame()).collect(),
        newest: 0,
    }))
}

struct Perceiving {
    /// `None`: it looks through everything.
    hiding: Option<Hiding>,
    sight: Sight,
    blur: Blur,
    /// s
    latency: f64,
    /// When each one lost is found again, by identity, s.
    lost_pedestrians: Vec<f64>,
    lost_vehicles: Vec<f64>,
    /// A ring of what was perceived at the last decisions.
    frames: Vec<Frame>,
    newest: usize,
}

/// What was perceived at one decision, with positions relative to the crossing along the ego's lane.
struct Frame {
    /// s
    time: f64,
    pedestrians: Vec<SeenPedestrian>,
    vehicles: Vec<SeenVehicle>,
}

/// Who is in view.
struct Sight {
    range: f64,
    half_angle: f64,
    setback: f64,
    /// Relative to the crossing, along the ego's lane; in the world frame if that bends.
    boxes: Vec<Footprint>,
    path: Path,
}

/// Where the vehicle is with its sensor.
struct SensedFrom {
    /// As [`Observation`] says it, m.
    travelled: f64,
    /// m
    offset: f64,
    /// rad
    angle: f64,
}

/// Who is hidden by what moves.
struct Hiding {
    /// Of the sensor behind the front bumper, m.
    setback: f64,
    boxes: Vec<Footprint>,
    /// The outlines of the others that are there.
    bodies: Vec<(Solid, Footprint)>,
    /// Whether each of them is hidden now, by identity.
    pedestrians: Vec<bool>,
    vehicles: Vec<bool>,
}

/// What is lost or blurred of those in view.
struct Blur {
    dropout: f64,
    dropout_duration: f64,
    position_noise: f64,
    velocity_noise: f64,
    stream: Stream,
}

/// Absorbs the rounding of times, s.
const TIME_TOLERANCE: f64 = 1e-9;

impl Sight {
    /// Whether a place is in view of a sensor `ahead` m before the ego's centre; ego and place relative to the crossing.
    fn sees(&self, ego: &SensedFrom, ahead: f64, place: Vector2<f64>) -> bool {
        if ego.angle != 0.0 || ego.offset != 0.0 {
            return self.sees_from_beside(ego, ahead, place);
        }
        let ego = Vector2::new(ego.travelled, 0.0);
        if self.path.course().is_some() {
            return self.sees_in_a_bend(ego, ahead, place);
        }
        let sensor = ego + Vector2::new(ahead, 0.0);
        let line = place - sensor;
        line.norm() <= self.range
            && libm::atan2(line.y, line.x).abs() <= self.half_angle
            && !self.boxes.iter().any(|outline| outline.is_crossed(sensor, line))
    }

    /// The same from beside the lane, at an angle to it.
    fn sees_from_beside(&self, ego: &SensedFrom, ahead: f64, place: Vector2<f64>) -> bool {
        let bends = self.path.course().is_some();
        let lane = |ego: &SensedFrom| {
            let heading = Vector2::new(libm::cos(ego.angle), libm::sin(ego.angle));
            (Vector2::new(ego.travelled, ego.offset), heading)
        };
        let (centre, heading) = match bends {
            true => self.path.pose_beside(ego.travelled, ego.offset, ego.angle),
            false => lane(ego),
        };
        let sensor = centre + heading * ahead;
        let line = if bends { self.path.to_world(place) } else { place } - sensor;
        line.norm() <= self.range
            && libm::atan2(heading.perp(&line), heading.dot(&line)).abs() <= self.half_angle
            && !self.boxes.iter().any(|outline| outline.is_crossed(sensor, line))
    }

    /// The same in the plane: whoever is round the bend is not where the lane leads, but where they are.
    fn sees_in_a_bend(&self, ego: Vector2<f64>, ahead: f64, place: Vector2<f64>) -> bool {
        let sensor = self.path.point(ego.x) + self.path.heading(ego.x) * ahead;
        let line = self.path.to_world(place) - sensor;
        let seen = self.path.turned(ego.x, line);
        line.norm() <= self.range
            && libm::atan2(seen.y, seen.x).abs() <= self.half_angle
            && !self.boxes.iter().any(|outline| outline.is_crossed(sensor, line))
    }
}

impl Hiding {
    /// Takes down who is hidden from the vehicle `me`.
    fn look(&mut self, me: usize, now: &Snapshot) {
        let Self { setback, boxes, bodies, pedestrians, vehicles } = self;
        bodies.clear();
        let others = now.vehicles.iter().enumerate().filter(|(index, _)| *index != me);
        bodies.extend(others.map(|(index, car)| (Solid::Vehicle(index), car.into())));
        let people = now.pedestrians.iter().enumerate().filter(|(_, person)| person.present);
        bodies.extend(people.map(|(index, person)| (Solid::Pedestrian(index), person.into())));
        let ego = &now.vehicles[me];
        let eye = ego.position() + ego.heading() * (ego.length / 2.0 - *setback);
        for (who, body) in bodies.iter() {
            let others = bodies.iter().filter(|(other, _)| other != who).map(|(_, body)| *body);
            let hidden = is_hidden(eye, body, others, boxes.iter().copied());
            match who {
                Solid::Vehicle(index) => vehicles[*index] = hidden,
                Solid::Pedestrian(index) => pedestrians[*index] = hidden,
                Solid::Box(_) => {}
            }
        }
    }
}

impl Blur {
    /// Whether somebody in view is lost at `time`; `lost_until` is remembered.
    fn loses(&mut self, time: f64, lost_until: &mut f64) -> bool {
        if time < *lost_until - TIME_TOLERANCE {
            return true;
        }
        let lost = self.dropout > 0.0 && self.stream.uniform() < self.dropout;
        if lost {
            *lost_until = time + self.dropout_duration;
        }
        lost
    }

    fn noise(&mut self, deviation: f64) -> Vector2<f64> {
        if deviation == 0.0 {
            return Vector2::zeros();
        }
        let (x, y) = (self.stream.normal(), self.stream.normal());
        Vector2::new(x, y) * deviation
    }
}

impl Perceiving {
    /// Takes down what is perceived now.
    fn note(&mut self, observation: &Observation) {
        let own = observation.ego;
        let from =
            SensedFrom { travelled: own.travelled, offset: own.lateral_offset, angle: own.heading_error };
        let ego = Vector2::new(own.travelled, 0.0);
        let ahead = observation.ego.length / 2.0 - self.sight.setback;
        self.newest = (self.newest + 1) % self.frames.len();
        let frame = &mut self.frames[self.newest];
        frame.time = observation.time;
        frame.pedestrians.clear();
        for seen in &observation.pedestrians {
            let place = seen.position + ego;
            let lost = &mut self.lost_pedestrians[seen.id];
            let hidden = self.hiding.as_ref().is_some_and(|hiding| hiding.pedestrians[seen.id]);
            if !hidden && self.sight.sees(&from, ahead, place) && !self.blur.loses(observation.time, lost) {
                let position = place + self.blur.noise(self.blur.position_noise);
                let velocity = seen.velocity + self.blur.noise(self.blur.velocity_noise);
                frame.pedestrians.push(SeenPedestrian { position, velocity, ..*seen });
            }
        }
        frame.vehicles.clear();
        for seen in &observation.vehicles {
            let place = seen.position + ego;
            let lost = &mut self.lost_vehicles[seen.id];
            let hidden = self.hiding.as_ref().is_some_and(|hiding| hiding.vehicles[seen.id]);
            if !hidden && self.sight.sees(&from, ahead, place) && !self.blur.loses(observation.time, lost) {
                let position = place + self.blur.noise(self.blur.position_noise);
                let velocity = seen.velocity + self.blur.noise(self.blur.velocity_noise);
                frame.vehicles.push(SeenVehicle { position, velocity, ..*seen });
            }
        }
    }

    /// The newest of the frames that are old enough.
    fn known(&self, time: f64) -> Option<&Frame> {
        let count = self.frames.len();
        let backwards = (0..count).map(|age| &self.frames[(self.newest + count - age) % count]);
        backwards.into_iter().find(|frame| frame.time <= time - self.latency + TIME_TOLERANCE)
    }
}

impl Perception for Perceiving {
    fn look(&mut self, me: usize, now: &Snapshot) {
        if let Some(hiding) = &mut self.hiding {
            hiding.look(me, now);
        }
    }

    fn age(&self, time: f64) -> Option<f64> {
        self.known(time).map(|frame| time - frame.time)
    }

    fn perceive(&mut self, seen: &Observation, view: &mut Observation) {
        self.note(seen);
        view.time = seen.time;
        view.ego = seen.ego;
        view.cruise_speed = seen.cruise_speed;
        let mut curvature_ahead = std::mem::take(&mut view.road.curvature_ahead);
        curvature_ahead.clone_from(&seen.road.curvature_ahead);
        let mut crossings = std::mem::take(&mut view.road.crossings);
        crossings.clone_from(&seen.road.crossings);
        view.road = RoadView { curvature_ahead, crossings, ..seen.road };
        view.pedestrians.clear();
        view.vehicles.clear();
        if let Some(frame) = self.known(seen.time) {
            let ego = Vector2::new(seen.ego.travelled, 0.0);
            let pedestrians = frame.pedestrians.iter();
            view.pedestrians
                .extend(pedestrians.map(|seen| SeenPedestrian { position: seen.position - ego, ..*seen }));
            let vehicles = frame.vehicles.iter();
            view.vehicles.extend(vehicles.map(|seen| SeenVehicle { position: seen.position - ego, ..*seen }));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::test_track::{CRUISE, walker, world};
    use scenario::{Body, Value, World};

    fn populated(boxes: Vec<Body>) -> World {
        let mut world = world(4.0, 2.0);
        world.road.boxes = boxes;
        world.pedestrians.push(walker());
        world
    }

    /// What is shown at 0.1 s decisions of a pedestrian walking at 1 m/s from (0, -4) while the ego drives on from
    /// 40 m before the crossing: position and velocity in the ego's frame.
    fn shown(
        pairs: &[(&str, f64)],
        boxes: Vec<Body>,
        decisions: usize,
        seed: u64,
    ) -> Vec<Option<(Vector2<f64>, Vector2<f64>)>> {
        let world = populated(boxes);
        let given =
            Settings(pairs.iter().map(|(name, value)| (name.to_string(), Value::Number(*value))).collect());
        let settings = declaration().resolve(&given).unwrap();
        let context = ControllerContext {
            settings: &Settings::default(),
            setup: &world.vehicles[0],
            world: &world,
            rank: 0,
            seed,
        };
        let mut perception = with_perception(&settings, &context, Schedule::every(0.1)).unwrap();
        let mut track = crate::vehicle::test_track::Track::new(
            &crate::vehicle::constant_speed::constant_speed(),
            Settings::default(),
            "ideal",
        );
        track.observation.ego.length = 4.0;
        track.crossing = 40.0;
        track.script_pedestrian(|time| Some((Vector2::new(40.0, -4.0 + time), Vector2::new(0.0, 1.0))));
        track.step = 0.1;
        let mut shown = Vec::with_capacity(decisions);
        let mut view = track.observation.clone();
        for _ in 0..decisions {
            perception.perceive(track.observe(), &mut view);
            shown.push(view.pedestrians.first().map(|one| (one.position, one.velocity)));
            track.advance();
        }
        shown
    }

    fn truth(decision: usize) -> Vector2<f64> {
        let time = decision as f64 * 0.1;
        Vector2::new(40.0 - CRUISE * time, -4.0 + time)
    }

    #[test]
    fn by_default_it_sees_everything_exactly() {
        for (k, seen) in shown(&[], Vec::new(), 20, 1).into_iter().enumerate() {
            let (position, velocity) = seen.unwrap();
            assert!((position - truth(k)).norm() < 1e-9 && velocity == Vector2::new(0.0, 1.0));
        }
    }

    #[test]
    fn range_and_field_of_view_are_measured_from_the_sensor() {
        let first = |pairs: &[(&str, f64)]| shown(pairs, Vec::new(), 50, 1).iter().position(Option::is_some);
        let sensor = |k: usize| truth(k) - Vector2::new(2.0, 0.0);
        let expected = (0..50).find(|&k| sensor(k).norm() <= 20.0);
        assert_eq!(first(&[("range", 20.0)]), expected);
        let behind = |k: usize| truth(k) - Vector2::new(0.5, 0.0);
        let expected = (0..50).find(|&k| behind(k).norm() <= 20.0);
        assert_eq!(first(&[("range", 20.0), ("sensor_setback", 1.5)]), expected);
        let seen = shown(&[("field_of_view", 0.4)], Vec::new(), 45, 1);
        for (k, seen) in seen.iter().enumerate() {
            let angle = sensor(k).y.atan2(sensor(k).x).abs();
            assert_eq!(seen.is_some(), angle <= 0.2, "{k} {angle}");
        }
        assert!(seen.iter().any(Option::is_none) && seen.iter().any(Option::is_some));
    }

    #[test]
    fn a_parked_van_hides() {
        let van = Body { name: "van".into(), x: -5.0, y: -3.0, length: 6.0, width: 2.0, heading: 0.0 };
        let seen = shown(&[], vec![van], 40, 1);
        // Seen from afar the line of sight passes the van's corner at (-2, -2) once the pedestrian is beyond it.
        for (k, seen) in seen.iter().enumerate() {
            let (place, sensor) = (-4.0 + k as f64 * 0.1, -38.0 + CRUISE * k as f64 * 0.1);
            let height_at = |x: f64| place * (x - sensor) / (0.0 - sensor);
            let hidden = height_at(-2.0) < -2.0 - 1e-9 && sensor < -8.0;
            assert_eq!(seen.is_none(), hidden, "{k} {place} {sensor}");
        }
        assert!(seen.iter().any(Option::is_none) && seen.iter().any(Option::is_some));
    }

    #[test]
    fn latency_shows_where_they_were() {
        let seen = shown(&[("latency", 0.25)], Vec::new(), 20, 1);
        for (k, seen) in seen.into_iter().enumerate() {
            // 0.25 s is rounded up to three decisions.
            let expected = (k >= 3).then(|| Vector2::new(truth(k).x, truth(k - 3).y));
            assert_eq!(seen.is_some(), expected.is_some());
            if let (Some((position, _)), Some(expected)) = (seen, expected) {
                assert!((position - expected).norm() < 1e-9, "{k}");
            }
        }
    }

    #[test]
    fn dropout_loses_the_stated_share() {
        let seen = shown(&[("dropout", 0.3)], Vec::new(), 4000, 1);
        let lost = seen.iter().filter(|seen| seen.is_none()).count() as f64 / 4000.0;
        assert!((lost - 0.3).abs() < 0.03, "{lost}");
        let long = shown(&[("dropout", 0.1), ("dropout_duration", 0.5)], Vec::new(), 4000, 1);
        let runs: Vec<usize> =
            long.split(Option::is_some).map(<[_]>::len).filter(|length| *length > 0).collect();
        assert!(runs.iter().all(|length| length % 5 == 0), "{runs:?}");
    }

    #[test]
    fn noise_has_the_stated_deviation_and_is_the_same_for_a_seed() {
        let pairs = [("position_noise", 0.4), ("velocity_noise", 0.2)];
        let seen = shown(&pairs, Vec::new(), 4000, 1);
        let errors: Vec<_> = seen.iter().enumerate().map(|(k, seen)| seen.unwrap().0 - truth(k)).collect();
        let deviation = (errors.iter().map(|error| error.x * error.x).sum::<f64>() / 4000.0).sqrt();
        assert!((deviation - 0.4).abs() < 0.02, "{deviation}");
        assert_eq!(seen, shown(&pairs, Vec::new(), 4000, 1));
        assert_ne!(seen, shown(&pairs, Vec::new(), 4000, 2));
    }

    #[test]
    fn the_noise_of_sensors_is_not_the_noise_of_whoever_drives() {
        let seen = shown(&[("position_noise", 0.4)], Vec::new(), 100, 1);
        let mut driver = stream(1, Agent::Vehicle(0), Purpose::Perception);
        let alike = seen.iter().enumerate().filter(|(k, seen)| {
            let error = seen.unwrap().0 - truth(*k);
            (error - Vector2::new(driver.normal(), driver.normal()) * 0.4).norm() < 1e-6
        });
        assert_eq!(alike.count(), 0);
    }
}
