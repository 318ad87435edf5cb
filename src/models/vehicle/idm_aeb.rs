//! Intelligent-driver cruise with automatic emergency braking for pedestrians.

use super::hazard::{Hazard, Ramp, TIE, collision_course};
use super::idm::{CITY, IDM, Idm};
use super::period::period;
use super::red_light::{self, RedLight};
use super::{CommandKind, ControllerContext, ControllerModel};
use nalgebra::Vector2;
use scenario::{
    Attention, CROSSES, Chance, ChoiceOption, Declaration, Dimension, LooksAt, Parameter, Settings, Shape,
    SignalConduct, Value,
};
use sim::geometry::Footprint;
use sim::{
    Command, Controller, ControllerError, Mode, ModelError, Observation, Schedule, SeenPedestrian,
    SeenVehicle,
};

const ROSEN: &str = "Rosén et al., Accident Analysis & Prevention 42 (2010)";
const R157: &str = "UN R157 annex 3: 0.6 s to 0.85 g, derived from UN R152";
const ASSUMED: &str = "assumption";

pub fn idm_aeb() -> ControllerModel {
    let declaration = Declaration::new(
        "idm_aeb",
        "Cruises by the intelligent driver model; brakes for pedestrians only in an \
         emergency, by time to collision.",
    )
    .source(
        "IDM: Treiber, Hennecke & Helbing (2000); emergency braking after UN R152 and \
         Rosén et al. (2010)",
    )
    .parameters(parameters());
    ControllerModel::new(declaration, CommandKind::Acceleration, build)
        .driving("ideal")
        .chance(Chance::Never)
        .signals(SignalConduct::Obeys)
        .attention(Attention::Reacts(looks_at))
}

/// What it looks at, which is also what `idm_aes` does.
pub(super) fn looks_at(settings: &Settings) -> LooksAt {
    LooksAt { other_roads: settings.flag("crossing_vehicles"), ..LooksAt::OWN_LANE }
}

/// What is known of it, which is also what `idm_aes` knows.
pub(super) fn parameters() -> [Parameter; 16] {
    [
        Parameter::number(
            "time_headway",
            Dimension::TIME,
            CITY.0,
            (0.0, 10.0),
            "Wanted time gap to a vehicle ahead.",
            IDM,
        ),
        Parameter::number(
            "minimum_gap",
            Dimension::LENGTH,
            CITY.1,
            (0.0, 50.0),
            "Wanted gap to a vehicle ahead at standstill.",
            IDM,
        ),
        Parameter::number(
            "max_acceleration",
            Dimension::ACCELERATION,
            1.0,
            (0.1, 10.0),
            "Acceleration from standstill on a free road.",
            IDM,
        ),
        Parameter::number(
            "comfortable_deceleration",
            Dimension::ACCELERATION,
            1.5,
            (0.1, 10.0),
            "Deceleration behind a slower vehicle.",
            IDM,
        ),
        Parameter::number(
            "exponent",
            Dimension::NUMBER,
            4.0,
            (1.0, 20.0),
            "How late the acceleration fades as the wanted speed is reached.",
            IDM,
        ),
        Parameter::number(
            "trigger",
            Dimension::TIME,
            1.0,
            (0.0, 10.0),
            "Time to collision at which it brakes.",
            ROSEN,
        ),
        Parameter::number(
            "deceleration",
            Dimension::ACCELERATION,
            0.85 * 9.80665,
            (0.1, 15.0),
            "Deceleration of emergency braking.",
            R157,
        ),
        Parameter::number(
            "jerk",
            Dimension::JERK,
            0.85 * 9.80665 / 0.6,
            (0.1, 1000.0),
            "Rate at which that deceleration builds up.",
            R157,
        ),
        Parameter::number(
            "detection_delay",
            Dimension::TIME,
            0.2,
            (0.0, 5.0),
            "Time that a pedestrian must have been in view before it counts.",
            ASSUMED,
        ),
        Parameter::number(
            "field_of_view",
            Dimension::ANGLE,
            40.0 * std::f64::consts::PI / 180.0,
            (0.0, 2.0 * std::f64::consts::PI),
            "Opening angle of the sensor at the front bumper.",
            ROSEN,
        ),
        Parameter::number("range", Dimension::LENGTH, 60.0, (0.0, 500.0), "Range of the sensor.", ASSUMED),
        Parameter::number(
            "margin",
            Dimension::LENGTH,
            0.25,
            (-1.0, 5.0),
            "Widens the swept strip on each side.",
            ASSUMED,
        ),
        Parameter::choice(
            "release",
            "standstill",
            [
                ChoiceOption::new("standstill", "Once triggered it brakes to standstill."),
                ChoiceOption::new("clear", "It stops braking when nobody is on a collision course."),
            ],
            "When emergency braking ends.",
            ASSUMED,
        ),
        Parameter::number(
            "restart_delay",
            Dimension::TIME,
            1.0,
            (0.0, 60.0),
            "Time that it stands with a clear way before it drives on.",
            ASSUMED,
        ),
        Parameter::flag(
            "crossing_vehicles",
            false,
            "Whether it brakes for vehicles, too, whose way crosses its own, as they come into view; without it, it sees those \
             in its lane alone.",
            "Euro NCAP's car-to-car crossing scenarios since 2023 ask for it (remembered); off as the systems that UN R152 describes",
        )
        .was(Value::Flag(false)),
        period(),
    ]
}

pub(super) struct IdmAeb {
    period: f64,
    idm: Idm,
    trigger: f64,
    deceleration: f64,
    jerk: f64,
    detection_delay: f64,
    half_view: f64,
    range: f64,
    margin: f64,
    crossing_vehicles: bool,
    until_standstill: bool,
    restart_delay: f64,
    /// Since when each pedestrian has been in view, by identity, s.
    in_view_since: Vec<Option<f64>>,
    /// Since when each vehicle has been.
    vehicle_since: Vec<Option<f64>>,
    braking: Option<Ramp>,
    /// Since when it has stood with a clear way, s.
    clear_since: Option<f64>,
    last_time: Option<f64>,
    /// `None`: it ignores signals.
    red_light: Option<RedLight>,
    mode: &'static str,
    /// Whom it brakes for.
    emergency: Option<usize>,
}

fn build(context: &ControllerContext) -> Result<Box<dyn Controller>, ModelError> {
    Ok(Box::new(IdmAeb::new(context)))
}

impl IdmAeb {
    pub(super) fn new(context: &ControllerContext) -> Self {
        let settings = context.settings;
        Self {
            period: settings.number("period"),
            idm: Idm {
                headway: settings.number("time_headway"),
                minimum_gap: settings.number("minimum_gap"),
                acceleration: settings.number("max_acceleration"),
                deceleration: settings.number("comfortable_deceleration"),
                exponent: settings.number("exponent"),
            },
            trigger: settings.number("trigger"),
            deceleration: settings.number("deceleration"),
            jerk: settings.number("jerk"),
            detection_delay: settings.number("detection_delay"),
            half_view: settings.number("field_of_view") / 2.0,
            range: settings.number("range"),
            margin: settings.number("margin"),
            crossing_vehicles: settings.flag("crossing_vehicles"),
            until_standstill: settings.word("release") == "standstill",
            restart_delay: settings.number("restart_delay"),
            in_view_since: vec![None; context.world.pedestrians.len()],
            vehicle_since: vec![None; context.world.vehicles.len()],
            braking: None,
            clear_since: None,
            last_time: None,
            red_light: RedLight::new(context, red_light::REACTION, red_light::DECELERATION),
            mode: "cruise",
            emergency: None,
        }
    }

    /// Whom it brakes for in an emergency now, by their number, if they are still in its way.
    pub(super) fn emergency(&self) -> Option<usize> {
        self.emergency
    }

    /// What it is up to.
    pub(super) fn word(&self) -> &'static str {
        self.mode
    }

    /// The nearest hazard among the pedestrians that have been detected, and whose it is.
    fn hazard(&mut self, observation: &Observation) -> Option<(usize, Hazard)> {
        let now = observation.time;
        let mut seen_before = std::mem::take(&mut self.in_view_since);
        for (id, since) in seen_before.iter_mut().enumerate() {
            let visible = observation
                .pedestrians
                .iter()
                .any(|seen| seen.id == id && self.in_view(observation.ego.length, seen));
            *since = visible.then(|| since.unwrap_or(now));
        }
        let nearest = observation
            .pedestrians
            .iter()
            .filter(|seen| {
                seen_before[seen.id].is_some_and(|since| now - since >= self.detection_delay - 1e-9)
            })
            .filter_map(|seen| Some((seen.id, collision_course(&observation.ego, seen, self.margin)?)))
            .min_by(|(_, one), (_, other)| one.time_to_collision.total_cmp(&other.time_to_collision));
        self.in_view_since = seen_before;
        nearest
    }

    /// After which time it touches one of the vehicles that cross its way and have been detected, if both keep their velocities, s.
    fn crossed_after(&mut self, observation: &Observation) -> Option<f64> {
        if !self.crossing_vehicles {
            return None;
        }
        let (now, ego) = (observation.time, &observation.ego);
        let mut since = std::mem::take(&mut self.vehicle_since);
        for (id, since) in since.iter_mut().enumerate() {
            let mut seen = observation.vehicles.iter().filter(|seen| seen.id == id);
            let visible = seen.any(|seen| self.is_visible(ego.length, seen.position));
            *since = visible.then(|| since.unwrap_or(now));
        }
        let detected = |seen: &&SeenVehicle| {
            since[seen.id].is_some_and(|since| now - since >= self.detection_delay - 1e-9)
        };
        let own = Footprint {
            centre: Vector2::zeros(),
            heading: Vector2::x(),
            shape: Shape::Rectangle { length: ego.length, width: ego.width + 2.0 * self.margin },
        };
        let times = observation.vehicles.iter().filter(detected).filter_map(|seen| {
            // Who stands or drives along the lane is followed.
            let heading = seen.velocity.try_normalize(1e-3).filter(|way| way.y.abs() >= CROSSES)?;
            let shape = Shape::Rectangle { length: seen.length, width: seen.width };
            let other = Footprint { centre: seen.position, heading, shape };
            own.first_contact(&other, seen.velocity - Vector2::new(ego.speed, 0.0))
        });
        let nearest = times.reduce(f64::min);
        self.vehicle_since = since;
        nearest
    }

    fn in_view(&self, length: f64, seen: &SeenPedestrian) -> bool {
        self.is_visible(length, seen.position)
    }

    fn is_visible(&self, length: f64, position: Vector2<f64>) -> bool {
        let ahead = position.x - length / 2.0;
        libm::hypot(ahead, position.y) <= self.range + TIE
            && libm::atan2(position.y, ahead).abs() <= self.half_view
    }
}

impl Controller for IdmAeb {
    fn schedule(&self) -> Schedule {
        Schedule::every(self.period)
    }

    fn act(&mut self, observation: &Observation) -> Result<Command, ControllerError> {
        let duration =
            observation.time - self.last_time.replace(observation.time).unwrap_or(observation.time);
        let mut cruise = self.idm.cruise(observation);
        let speed = observation.ego.speed;
        let line = self.red_light.as_mut().and_then(|rule| rule.gap(observation));
        let for_red = line.map(|gap| self.idm.behind_line(speed, gap)).filter(|found| *found <= cruise);
        cruise = for_red.unwrap_or(cruise);
        let nearest = self.hazard(observation);
        let hazard = nearest.map(|(_, hazard)| hazard.time_to_collision);
        let hazard = [hazard, self.crossed_after(observation)].into_iter().flatten().reduce(f64::min);
        let standing = observation.ego.speed == 0.0;
        if self.braking.is_none() && hazard.is_some_and(|time| time <= self.trigger + TIE) {
            self.braking = Some(Ramp::from(observation.ego.acceleration.min(0.0)));
            self.clear_since = None;
        } else if self.braking.is_some() && hazard.is_none() && (standing || !self.until_standstill) {
            let since = *self.clear_since.get_or_insert(observation.time);
            if !standing || observation.time - since >= self.restart_delay {
                self.braking = None;
            }
        } else {
            self.clear_since = None;
        }
        self.emergency = nearest.filter(|_| self.braking.is_some()).map(|(id, _)| id);
        let Some(ramp) = &mut self.braking else {
            self.mode = match for_red {
                Some(acceleration) if acceleration < 0.0 || red_light::stands(speed) => {
                    red_light::mode(red_light::stands(speed))
                }
                _ => "cruise",
            };
            return Ok(Command::Acceleration(cruise));
        };
        self.mode = "emergency_braking";
        Ok(Command::Acceleration(ramp.toward(-self.deceleration, self.jerk, duration).min(cruise)))
    }

    fn mode(&self) -> Mode {
        Mode::new(self.mode)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::vehicle::test_track::{CRUISE, Track};
    use scenario::{Settings, Value};

    fn track(pairs: &[(&str, Value)]) -> Track {
        Track::new(&idm_aeb(), Settings::from(pairs), "ideal")
    }

    /// Gap (bumper to the pedestrian's near edge, m) at which it first brakes, and what is left at standstill.
    fn brakes_at(track: &mut Track, place: f64) -> (f64, f64) {
        let edge = place - 0.1875;
        loop {
            let gap = edge - track.front();
            let sample = track.advance();
            if sample.mode == "emergency_braking" {
                while track.motion.speed > 0.0 {
                    track.advance();
                }
                return (gap, edge - track.front());
            }
            assert!(gap > -10.0, "never brakes");
        }
    }

    #[test]
    fn brakes_one_second_before_a_standing_pedestrian() {
        let mut track = track(&[]);
        track.place_pedestrian(100.0, 0.0);
        let (gap, left) = brakes_at(&mut track, 100.0);
        assert!((CRUISE - 0.3..=CRUISE).contains(&gap), "{gap}");
        // Jerk 13.9 m/s³ for 0.6 s, then 8.34 m/s²: 4.50 m and 2.03 m.
        let jerk = 0.85 * 9.80665 / 0.6;
        let speed = CRUISE - jerk * 0.36 / 2.0;
        let needed = CRUISE * 0.6 - jerk * 0.216 / 6.0 + speed * speed / (2.0 * 0.85 * 9.80665);
        assert!((gap - left - needed).abs() < 0.15, "{gap} {left} {needed}");
        assert!(left > 0.0);
    }

    #[test]
    fn sees_only_its_field_of_view_and_after_its_delay() {
        let hazard_after = |x: f64, y: f64, vy: f64, steps: usize| {
            let mut track = track(&[("trigger", Value::Number(10.0))]);
            track
                .script_pedestrian(move |time| Some((Vector2::new(x, y + vy * time), Vector2::new(0.0, vy))));
            track.drive(steps as f64 * 0.025);
            track.advance().mode
        };
        // 20 degrees to either side: at 10 m before the bumper 3.6 m.
        assert_eq!(hazard_after(2.25 + 10.0, -4.5, 3.0, 6), "cruise");
        assert_eq!(hazard_after(60.0, -4.0, 0.55, 6), "cruise");
        assert_eq!(hazard_after(60.0, -4.0, 0.55, 8), "emergency_braking");
        assert_eq!(hazard_after(80.0, 0.0, 0.0, 9), "cruise");
    }

    #[test]
    fn ignores_those_who_will_have_left() {
        let mut track = track(&[]);
        track.script_pedestrian(|time| Some((Vector2::new(60.0, -3.0 + 1.4 * time), Vector2::new(0.0, 1.4))));
        assert!(track.drive(10.0).iter().all(|sample| sample.mode == "cruise"));
    }

    #[test]
    fn stands_until_the_way_is_clear_and_a_second_more() {
        let mut track = track(&[]);
        track.script_pedestrian(|time| {
            let y = if time < 20.0 { 0.0 } else { 3.0 };
            Some((Vector2::new(50.0, y), Vector2::zeros()))
        });
        let samples = track.drive(40.0);
        assert_eq!(samples[(20.9 / 0.025) as usize].speed, 0.0);
        assert!(samples[(21.2 / 0.025) as usize].speed > 0.0);
        assert!(samples.last().unwrap().speed > 8.0);
    }

    #[test]
    fn releases_early_when_told() {
        let drive = |release: &str| {
            let pairs = [("trigger", Value::Number(2.0)), ("release", Value::Word(release.into()))];
            let mut track = track(&pairs);
            track.script_pedestrian(|time| {
                let y = if time < 3.0 { 0.0 } else { 5.0 };
                Some((Vector2::new(40.0, y), Vector2::zeros()))
            });
            track.drive(12.0).iter().map(|sample| sample.speed).fold(f64::INFINITY, f64::min)
        };
        assert_eq!(drive("standstill"), 0.0);
        assert!(drive("clear") > 0.5);
    }

    #[test]
    fn keeps_the_models_gap_behind_a_vehicle() {
        // Equilibrium at equal speeds: gap = (s0 + v T) / sqrt(1 - (v / v0)^4).
        let mut track = track(&[]);
        let lead = |time: f64| 40.0 + 5.0 * time;
        for k in 0..8000 {
            track.see_vehicle(lead(f64::from(k) * 0.025) - track.motion.travelled, 5.0);
            track.advance();
        }
        let gap = lead(200.0) - track.motion.travelled - 4.5;
        let expected = (2.0 + 5.0) / (1.0 - (5.0 / CRUISE).powi(4)).sqrt();
        assert!((gap - expected).abs() < 0.15, "{gap} {expected}");
        assert!((track.motion.speed - 5.0).abs() < 1e-3);
    }
}
