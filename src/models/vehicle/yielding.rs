//! A driver who yields: stops before a zebra for anybody at or near the kerb.

use super::hazard::{TIE, collision_course, keep_speed};
use super::idm::Idm;
use super::period::period;
use super::red_light::{self, RedLight};
use super::{CommandKind, ControllerContext, ControllerModel};
use scenario::{Attention, Chance, Declaration, Dimension, LooksAt, Parameter, SignalConduct};
use sim::{Command, Controller, ControllerError, Mode, ModelError, Observation, Schedule, SeenPedestrian};

const RULE: &str = "Vienna Convention on Road Traffic (1968), article 21: give way to pedestrians \
                    at crossings";
const FREE: &str = "free choice";

pub fn yielding() -> ControllerModel {
    let declaration = Declaration::new(
        "yielding",
        "Stops before the crossing for a pedestrian on it, at or near the kerb, if it \
         can brake in time, and waits; follows the vehicle ahead.",
    )
    .source(RULE)
    .parameters([
        Parameter::flag(
            "requires_priority",
            true,
            "Whether it yields only while pedestrians have priority (a zebra, or their \
             green).",
            RULE,
        ),
        Parameter::number(
            "kerb_distance",
            Dimension::LENGTH,
            1.5,
            (0.0, 20.0),
            "A pedestrian at most this far from a kerb is one to yield to.",
            FREE,
        ),
        Parameter::number(
            "along_margin",
            Dimension::LENGTH,
            1.0,
            (0.0, 20.0),
            "A pedestrian at most this far beside the crossing counts as being at it.",
            FREE,
        ),
        Parameter::flag(
            "far_kerb",
            true,
            "Whether it also yields to those at the kerb across the road.",
            RULE,
        ),
        Parameter::number(
            "stop_distance",
            Dimension::LENGTH,
            1.0,
            (0.0, 50.0),
            "Where the front stops, before the near edge of the crossing.",
            FREE,
        ),
        Parameter::number(
            "deceleration",
            Dimension::ACCELERATION,
            2.0,
            (0.1, 10.0),
            "Deceleration with which it likes to stop.",
            "below the 2.5 m/s² that counts as a sudden change",
        ),
        Parameter::number(
            "max_deceleration",
            Dimension::ACCELERATION,
            3.4,
            (0.1, 15.0),
            "Deceleration up to which it still yields; beyond it passes first.",
            "AASHTO Green Book, stopping sight distance: 3.4 m/s²",
        ),
        Parameter::number(
            "emergency_deceleration",
            Dimension::ACCELERATION,
            7.0,
            (0.1, 15.0),
            "Deceleration for somebody on a collision course who cannot be yielded to at \
             `max_deceleration`.",
            "dry road",
        ),
        Parameter::number(
            "margin",
            Dimension::LENGTH,
            0.25,
            (-1.0, 5.0),
            "Widens the swept strip in which somebody is on a collision course.",
            FREE,
        ),
        Parameter::optional(
            "patience",
            Dimension::TIME,
            (0.0, 3600.0),
            "Time standing after which it goes if nobody is on the road; without it, it \
             waits for ever.",
            FREE,
        ),
        Parameter::number(
            "acceleration",
            Dimension::ACCELERATION,
            1.5,
            (0.1, 10.0),
            "Acceleration back to the wanted speed.",
            FREE,
        ),
        period(),
    ]);
    ControllerModel::new(declaration, CommandKind::Acceleration, build)
        .driving("ideal")
        .chance(Chance::Never)
        .signals(SignalConduct::Obeys)
        .attention(Attention::Reacts(|_| LooksAt::OWN_LANE))
}

struct Yielding {
    period: f64,
    requires_priority: bool,
    kerb_distance: f64,
    along_margin: f64,
    far_kerb: bool,
    stop_distance: f64,
    deceleration: f64,
    max_deceleration: f64,
    emergency_deceleration: f64,
    margin: f64,
    patience: f64,
    acceleration: f64,
    /// Behind vehicles ahead.
    idm: Idm,
    /// How far each pedestrian has come, by identity.
    progress: Vec<Progress>,
    stopping: bool,
    /// Since when it stands, s.
    standing_since: Option<f64>,
    /// Whether its patience has run out with those who wait now.
    impatient: bool,
    /// `None`: it ignores signals.
    red_light: Option<RedLight>,
    mode: &'static str,
}

/// How far a pedestrian has come across the ego's lane.
#[derive(Clone, Copy, PartialEq)]
enum Progress {
    Before,
    InLane,
    Across,
}

fn build(context: &ControllerContext) -> Result<Box<dyn Controller>, ModelError> {
    let settings = context.settings;
    let (comfortable, most) = (settings.number("deceleration"), settings.number("max_deceleration"));
    if comfortable > most {
        return Err(ModelError::with_hint(
            "`deceleration` of `yielding` is larger than `max_deceleration`",
            "let `deceleration`, with which it plans, be at most `max_deceleration`, with \
             which it can brake",
        ));
    }
    Ok(Box::new(Yielding {
        period: settings.number("period"),
        requires_priority: settings.flag("requires_priority"),
        kerb_distance: settings.number("kerb_distance"),
        along_margin: settings.number("along_margin"),
        far_kerb: settings.flag("far_kerb"),
        stop_distance: settings.number("stop_distance"),
        deceleration: comfortable,
        max_deceleration: most,
        emergency_deceleration: settings.number("emergency_deceleration"),
        margin: settings.number("margin"),
        patience: settings.optional_number("patience").unwrap_or(f64::INFINITY),
        acceleration: settings.number("acceleration"),
        idm: Idm::behind_others(settings.number("acceleration"), comfortable),
        progress: vec![Progress::Before; context.world.pedestrians.len()],
        stopping: false,
        standing_since: None,
        impatient: false,
        // It decides about a signal as about people: at once, and with the deceleration up to which it yields.
        red_light: RedLight::new(context, 0.0, most),
        mode: "cruise",
    }))
}

/// What it keeps between its bumper and somebody in its way, m.
const ROOM: f64 = 1.0;

impl Yielding {
    /// Notes who has been in the lane and has left it.
    fn follow(&mut self, observation: &Observation) {
        let half_lane = observation.road.lane_width / 2.0;
        for seen in &observation.pedestrians {
            let progress = &mut self.progress[seen.id];
            let outside = seen.position.y.abs() - half_lane;
            *progress = match *progress {
                _ if outside <= TIE => Progress::InLane,
                Progress::InLane if seen.velocity.y * seen.position.y > 0.0 => Progress::Across,
                other => other,
            };
        }
    }

    fn on_the_road(&self, observation: &Observation, seen: &SeenPedestrian) -> bool {
        (observation.road.right_kerb - TIE..=observation.road.left_kerb + TIE).contains(&seen.position.y)
    }

    /// The crossing that it stops at: of those that it has not left behind the first at which somebody is whom it gives way to, else
    /// the next; and whether it gives way there.
    fn stops_at(&self, observation: &Observation) -> (Ahead, bool) {
        let next = Ahead::next(observation);
        let mut ahead = Ahead::all(observation).filter(|crossing| crossing.distance >= next.distance);
        let met = match observation.road.crossings.len() {
            0 | 1 => Some(next).filter(|crossing| self.must_yield(observation, crossing)),
            _ => ahead.find(|crossing| self.must_yield(observation, crossing)),
        };
        (met.unwrap_or(next), met.is_some())
    }

    /// How far before that crossing's edge its stop line is, if it obeys a signal there; it sees that of the next crossing.
    fn line_of(&self, observation: &Observation, crossing: &Ahead) -> Option<f64> {
        let is_next = crossing.distance == observation.ego.distance_to_crossing;
        self.red_light.as_ref()?;
        observation.road.signal.filter(|_| is_next).map(|signal| signal.stop_line)
    }

    /// Whether somebody is at a crossing whom it gives way to.
    fn must_yield(&self, observation: &Observation, crossing: &Ahead) -> bool {
        let road = &observation.road;
        let has_priority = !self.requires_priority || crossing.pedestrian_priority;
        // Who began at green may clear the crossing.
        if !has_priority && self.line_of(observation, crossing).is_none() {
            return false;
        }
        let everybody = observation.pedestrians.iter();
        everybody.filter(|seen| has_priority || self.on_the_road(observation, seen)).any(|seen| {
            let beside =
                (seen.position.x - crossing.distance).abs() - crossing.width / 2.0 - self.along_margin;
            let y = seen.position.y;
            let near_kerb = y >= road.right_kerb - self.kerb_distance - TIE;
            let far_kerb = y <= road.left_kerb + TIE + if self.far_kerb { self.kerb_distance } else { 0.0 };
            let waits_only = !self.on_the_road(observation, seen);
            beside <= TIE
                && near_kerb
                && far_kerb
                && self.progress[seen.id] != Progress::Across
                && !(self.impatient && waits_only)
        })
    }

    /// Gap to the nearest pedestrian on a collision course, less the room that it keeps, m.
    fn room(&self, observation: &Observation) -> f64 {
        let courses = observation.pedestrians.iter();
        let gaps = courses.filter_map(|seen| collision_course(&observation.ego, seen, self.margin));
        gaps.map(|hazard| (hazard.gap - ROOM).max(0.0)).fold(f64::INFINITY, f64::min)
    }

    fn update_patience(&mut self, observation: &Observation) {
        if observation.ego.speed > 0.0 {
            self.standing_since = None;
            return;
        }
        let since = *self.standing_since.get_or_insert(observation.time);
        self.impatient = self.impatient || observation.time - since >= self.patience - TIE;
    }
}

/// A crossing as it looks at it.
#[derive(Debug, Clone, Copy)]
struct Ahead {
    /// From the vehicle's centre to its middle, m.
    distance: f64,
    /// m
    width: f64,
    pedestrian_priority: bool,
}

impl Ahead {
    /// The first that is not left behind, or the last.
    fn next(observation: &Observation) -> Self {
        let road = &observation.road;
        Self {
            distance: observation.ego.distance_to_crossing,
            width: road.crossing_width,
            pedestrian_priority: road.pedestrian_priority,
        }
    }

    fn all(observation: &Observation) -> impl Iterator<Item = Self> {
        observation.road.crossings.iter().map(|view| Self {
            distance: view.distance,
            width: view.width,
            pedestrian_priority: view.pedestrian_priority,
        })
    }
}

impl Controller for Yielding {
    fn schedule(&self) -> Schedule {
        Schedule::every(self.period)
    }

    fn act(&mut self, observation: &Observation) -> Result<Command, ControllerError> {
        let mut acceleration = self.among_people(observation);
        if let Some(behind) = self.idm.bound(observation).filter(|behind| *behind < acceleration) {
            self.mode = "following";
            acceleration = behind;
        }
        let braking = self.red_light.as_mut().and_then(|rule| rule.braking(observation));
        if let Some(braking) = braking.filter(|braking| -braking <= acceleration) {
            self.mode = red_light::mode(red_light::stands(observation.ego.speed));
            return Ok(Command::Acceleration(-braking));
        }
        Ok(Command::Acceleration(acceleration))
    }

    fn mode(&self) -> Mode {
        Mode::new(self.mode)
    }
}

impl Yielding {
    /// Its acceleration for people alone, m/s².
    fn among_people(&mut self, observation: &Observation) -> f64 {
        self.follow(observation);
        self.update_patience(observation);
        let ego = &observation.ego;
        let (crossing, yields) = self.stops_at(observation);
        let stop_distance = self
            .line_of(observation, &crossing)
            .map_or(self.stop_distance, |stop_line| self.stop_distance.max(stop_line));
        let line = crossing.distance - ego.length / 2.0 - crossing.width / 2.0 - stop_distance;
        // Once the front is past the line by more than rounding, stopping before it is over.
        let needed = if line > 0.0 {
            ego.speed * ego.speed / (2.0 * line)
        } else if ego.speed == 0.0 && line > -0.5 {
            0.0
        } else {
            f64::INFINITY
        };
        let limit = if self.stopping { self.emergency_deceleration } else { self.max_deceleration };
        if yields && needed <= limit + TIE {
            self.stopping = self.stopping || needed >= self.deceleration - TIE || ego.speed == 0.0;
        } else if !(yields && self.stopping && line > -0.5) {
            self.stopping = false;
        }
        let room = self.room(observation);
        if ego.speed * ego.speed > 2.0 * self.max_deceleration * room + TIE {
            self.mode = "emergency_braking";
            return -self.emergency_deceleration;
        }
        if self.stopping {
            self.mode = if ego.speed == 0.0 { "waiting" } else { "yielding" };
            return -needed.clamp(self.deceleration, self.emergency_deceleration);
        }
        self.mode = "cruise";
        let wanted = observation.cruise_speed.min((2.0 * self.deceleration * room).sqrt());
        keep_speed(ego.speed, wanted, self.acceleration, self.max_deceleration)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::vehicle::test_track::{CRUISE, Sample, Track};
    use scenario::{Settings, Value};

    fn track(pairs: &[(&str, Value)]) -> Track {
        let mut track = Track::new(&yielding(), Settings::from(pairs), "ideal");
        track.crossing = 60.0;
        track
    }

    fn at(samples: &[Sample], time: f64) -> Sample {
        samples[(time / 0.025) as usize].clone()
    }

    #[test]
    fn stops_at_its_line_for_somebody_at_the_kerb() {
        for y in [-2.5, -3.5, 6.5, 7.5] {
            let mut track = track(&[]);
            track.place_pedestrian(60.0, y);
            let samples = track.drive(20.0);
            assert_eq!(track.motion.speed, 0.0);
            // One metre before the crossing's edge at 58 m.
            assert!((track.front() - 57.0).abs() < 0.25, "{}", track.front());
            let hardest = samples.iter().map(|sample| match sample.command {
                Command::Acceleration(acceleration) => acceleration,
                Command::Pedals { .. } => unreachable!(),
            });
            let hardest = hardest.fold(0.0, f64::min);
            assert!((-2.2..=-2.0).contains(&hardest), "{hardest}");
        }
    }

    #[test]
    fn goes_on_once_they_have_crossed_its_lane() {
        let mut track = track(&[]);
        track.script_pedestrian(|time| {
            let walked = (time - 10.0).max(0.0);
            let speed = if time > 10.0 { 1.4 } else { 0.0 };
            Some((Vector2::new(60.0, -2.5 + 1.4 * walked), Vector2::new(0.0, speed)))
        });
        let samples = track.drive(25.0);
        // Leaves the lane at 10 + 4.5 / 1.4 = 13.2 s.
        assert_eq!(at(&samples, 13.1).speed, 0.0);
        assert!(at(&samples, 13.4).speed > 0.0);
        assert!((samples.last().unwrap().speed - CRUISE).abs() < 0.01);
    }

    #[test]
    fn ignores_those_away_from_the_crossing_or_the_kerb() {
        for (x, y) in [(60.0, -4.0), (64.0, -2.5), (60.0, 8.0)] {
            let mut track = track(&[]);
            track.place_pedestrian(x, y);
            assert!(track.drive(10.0).iter().all(|sample| sample.mode == "cruise"), "{x} {y}");
        }
        let mut near_only = track(&[("far_kerb", Value::Flag(false))]);
        near_only.place_pedestrian(60.0, 6.5);
        assert!(near_only.drive(10.0).iter().all(|sample| sample.mode == "cruise"));
    }

    #[test]
    fn yields_only_where_pedestrians_have_priority() {
        let mut unmarked = track(&[]);
        unmarked.observation.road.pedestrian_priority = false;
        unmarked.place_pedestrian(60.0, -2.5);
        assert!(unmarked.drive(10.0).iter().all(|sample| sample.mode == "cruise"));
        let mut always = track(&[("requires_priority", Value::Flag(false))]);
        always.observation.road.pedestrian_priority = false;
        always.place_pedestrian(60.0, -2.5);
        always.drive(20.0);
        assert_eq!(always.motion.speed, 0.0);
    }

    #[test]
    fn passes_first_when_stopping_would_be_too_hard() {
        // Stopping at 3.4 m/s² takes 10.2 m.
        let appearing = |before_line: f64| {
            let mut track = track(&[]);
            let start = 57.0 - before_line - 2.25;
            track.script_pedestrian(move |time| {
                (time * CRUISE >= start).then(|| (Vector2::new(60.0, -2.5), Vector2::zeros()))
            });
            track.drive(15.0);
            track.motion.speed
        };
        assert_eq!(appearing(10.6), 0.0);
        assert_eq!(appearing(9.8), CRUISE);
    }

    #[test]
    fn brakes_hard_for_somebody_on_a_collision_course() {
        let mut track = track(&[]);
        track.script_pedestrian(|time| {
            let y = if time * CRUISE < 49.6 { -6.0 } else { 0.0 };
            Some((Vector2::new(60.0, y), Vector2::zeros()))
        });
        let samples = track.drive(15.0);
        assert!(samples.iter().any(|sample| sample.mode == "emergency_braking"));
        assert!(track.motion.speed == 0.0 && track.front() < 60.0 - 0.1875);
    }

    #[test]
    fn stops_behind_a_vehicle_that_stands_before_its_line() {
        let mut track = track(&[]);
        track.place_pedestrian(60.0, -2.5);
        let mut follows = false;
        for _ in 0..1600 {
            track.see_vehicle(40.0 - track.motion.travelled, 0.0);
            follows |= track.advance().mode == "following";
        }
        let gap = 40.0 - 2.25 - track.front();
        assert!((1.7..2.3).contains(&gap) && track.motion.speed < 0.05, "{gap}");
        assert!(follows);
    }

    #[test]
    fn patience_runs_out() {
        let mut track = track(&[("patience", Value::Number(5.0))]);
        track.place_pedestrian(60.0, -2.5);
        let samples = track.drive(30.0);
        assert!(samples.iter().any(|sample| sample.mode == "waiting"));
        assert!((samples.last().unwrap().speed - CRUISE).abs() < 0.01);
    }
}
