//! Emergency steering: where braking alone does not suffice, the vehicle brakes and swerves past a pedestrian, if there is room.

use std::borrow::Cow;

use super::hazard::{Ramp, TIE, half_size};
use super::idm_aeb::{IdmAeb, looks_at, parameters};
use super::{CommandKind, ControllerContext, ControllerModel};
use scenario::{
    Attention, Chance, ChoiceOption, Declaration, Dimension, GRAVITY, Parameter, REAR_AXLE, SignalConduct,
};
use sim::{Command, Controller, ControllerError, Mode, ModelError, Observation, Schedule, SeenPedestrian};

const ASSUMED: &str = "assumption";

pub fn idm_aes() -> ControllerModel {
    let declaration = Declaration::new(
        "idm_aes",
        "Brakes for pedestrians as `idm_aeb` does, and where that does not suffice swerves past them as well, within its carriageway and where \
         nobody else is.",
    )
    .source("`idm_aeb`, and emergency steering by the time that a swerve needs: Eckert et al., ESV 11-0111 (2011), as remembered")
    .parameters(parameters().into_iter().chain([
        Parameter::number(
            "lateral_acceleration",
            Dimension::ACCELERATION,
            0.5 * 0.9 * GRAVITY,
            (0.5, 10.0),
            "Acceleration to the side of a swerve.",
            "half of what dry tyres hold, up to which the vehicle's kinematic model is valid: Polack et al., IEEE IV (2017)",
        ),
        Parameter::number(
            "steering_rate",
            Dimension::FREQUENCY,
            0.4,
            (0.05, 5.0),
            "How fast its wheels turn, in rad, by which a swerve builds up.",
            "as its vehicle's do: CommonRoad's vehicle models (Althoff et al. 2017), as remembered",
        ),
        Parameter::number(
            "clearance",
            Dimension::LENGTH,
            0.5,
            (0.0, 3.0),
            "Gap to the pedestrian that it swerves for, to the side.",
            ASSUMED,
        ),
        Parameter::number(
            "kerb_margin",
            Dimension::LENGTH,
            0.2,
            (0.0, 2.0),
            "Gap to kerbs, parked cars and vehicles beside it.",
            ASSUMED,
        ),
        Parameter::choice(
            "room",
            "carriageway",
            [
                ChoiceOption::new("carriageway", "It may swerve onto other lanes, where nobody is or comes."),
                ChoiceOption::new("lane", "It stays within its lane."),
            ],
            "How far it may swerve.",
            ASSUMED,
        ),
        Parameter::number(
            "looks_ahead",
            Dimension::TIME,
            3.0,
            (0.0, 20.0),
            "How long the room beside it has to stay free.",
            "assumption: a swerve and the way back",
        ),
        Parameter::number(
            "assumed_friction",
            Dimension::NUMBER,
            0.9,
            (0.05, 2.0),
            "What it takes the road's friction for: while it steers it brakes by what Kamm's circle leaves.",
            "dry asphalt: Wong, Theory of Ground Vehicles, as remembered; no controller is told the friction",
        ),
        Parameter::number(
            "return_lookahead",
            Dimension::TIME,
            2.0,
            (0.5, 10.0),
            "How far ahead in the middle of its lane it aims on the way back: so long at its speed, and at least 6 m.",
            "pure pursuit: R. C. Coulter, CMU-RI-TR-92-01 (1992); the time is an assumption, by which 2 m beside the lane make 1 m/s^2 at any speed",
        ),
    ]));
    ControllerModel::new(declaration, CommandKind::Acceleration, build)
        .driving("ideal")
        .chance(Chance::Never)
        .signals(SignalConduct::Obeys)
        .attention(Attention::Reacts(looks_at))
        .steering()
}

struct IdmAes {
    aeb: IdmAeb,
    deceleration: f64,
    jerk: f64,
    lateral: f64,
    steering_rate: f64,
    axle: f64,
    clearance: f64,
    kerb_margin: f64,
    within_lane: bool,
    looks_ahead: f64,
    grip: f64,
    lookahead: f64,
    /// What stands on the road: from and to along the lane (m), and from right to left (m, to the left of its middle).
    boxes: Vec<[(f64, f64); 2]>,
    stage: Stage,
    curvature: Option<f64>,
    mode: &'static str,
}

/// How somebody is passed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Passage {
    /// Where its middle has to be, to the left of that of its lane, m.
    target: f64,
    /// When its front is there, s.
    arrives: f64,
    /// What it brakes by meanwhile, m/s².
    braking: f64,
}

/// What it is about.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stage {
    /// It has never steered.
    Follows,
    /// It swerves past somebody, and to their left if `left`.
    Swerves { id: usize, left: bool, passage: Passage },
    /// It is back in the middle of its lane, or on its way there.
    Keeps,
}

fn build(context: &ControllerContext) -> Result<Box<dyn Controller>, ModelError> {
    let (settings, road) = (context.settings, &context.world.road);
    let path = context.world.path_of(context.setup);
    let boxes = road.boxes.iter().map(|body| {
        let place = path.from_world([body.x, body.y].into());
        // As a rectangle along the lane that holds the box, however it is turned.
        let along = path.turned(place.x, body.along());
        let reach = |one: f64, other: f64| (body.length * one.abs() + body.width * other.abs()) / 2.0;
        let (ahead, aside) = (reach(along.x, along.y), reach(along.y, along.x));
        [(place.x - ahead, place.x + ahead), (place.y - aside, place.y + aside)]
    });
    Ok(Box::new(IdmAes {
        aeb: IdmAeb::new(context),
        deceleration: settings.number("deceleration"),
        jerk: settings.number("jerk"),
        lateral: settings.number("lateral_acceleration"),
        steering_rate: settings.number("steering_rate"),
        axle: match context.setup.behind {
            behind if behind > 0.0 => behind,
            _ => REAR_AXLE * context.setup.length,
        },
        clearance: settings.number("clearance"),
        kerb_margin: settings.number("kerb_margin"),
        within_lane: settings.word("room") == "lane",
        looks_ahead: settings.number("looks_ahead"),
        grip: settings.number("assumed_friction") * GRAVITY,
        lookahead: settings.number("return_lookahead"),
        boxes: boxes.collect(),
        stage: Stage::Follows,
        curvature: None,
        mode: "cruise",
    }))
}

/// What is seen, from where the vehicle is beside its lane: as `idm_aeb` expects it, which follows the middle of its lane.
fn beside(seen: &Observation) -> Cow<'_, Observation> {
    let (offset, drifts) = (seen.ego.lateral_offset, drift(seen));
    if offset == 0.0 && drifts == 0.0 {
        return Cow::Borrowed(seen);
    }
    let mut moved = seen.clone();
    for person in &mut moved.pedestrians {
        person.position.y -= offset;
        person.velocity.y -= drifts;
    }
    for vehicle in &mut moved.vehicles {
        vehicle.position.y -= offset;
    }
    Cow::Owned(moved)
}

/// How fast it moves to the left of its lane, m/s.
fn drift(seen: &Observation) -> f64 {
    seen.ego.speed * libm::sin(seen.ego.heading_error)
}

/// After which time (s) a vehicle has driven so far (m) that brakes from its acceleration on with this jerk (m/s³) up to a deceleration
/// (m/s²); `None` if it stops before.
fn arrives(seen: &Observation, way: f64, deceleration: f64, jerk: f64) -> Option<f64> {
    const STEP: f64 = 0.005;
    let (mut speed, mut driven, mut time) = (seen.ego.speed, 0.0, 0.0);
    let mut ramp = Ramp::from(seen.ego.acceleration.min(0.0));
    while driven < way - TIE {
        let after = speed + ramp.toward(-deceleration, jerk, STEP) * STEP;
        if after <= 0.0 {
            return None;
        }
        driven += (speed + after) / 2.0 * STEP;
        (speed, time) = (after, time + STEP);
    }
    Some(time)
}

impl IdmAes {
    /// What it may brake by while it steers, m/s².
    fn beside_steering(&self, lateral: f64) -> f64 {
        libm::sqrt((self.grip * self.grip - lateral * lateral).max(0.0)).min(self.deceleration)
    }

    /// How it passes somebody on their left or their right; `None` if it stops before them.
    fn past(&self, seen: &Observation, person: &SeenPedestrian, left: bool) -> Option<Passage> {
        let radius = half_size(person.shape);
        let gap = person.position.x - radius - seen.ego.length / 2.0;
        let beyond = seen.ego.length + 2.0 * radius;
        let passes = |braking: f64| {
            let first = arrives(seen, gap.max(0.0), braking, self.jerk)?;
            // How far it has to drive is a matter of where they go, too, if they walk along the lane.
            let meeting = (gap + person.velocity.x * first).max(0.0);
            let first = arrives(seen, meeting, braking, self.jerk)?;
            Some((first, arrives(seen, meeting + beyond, braking, self.jerk)?, braking))
        };
        // Who stopped beside them would be walked into.
        let (first, last, braking) = passes(self.beside_steering(self.lateral)).or_else(|| passes(0.0))?;
        let (one, other) =
            (person.position.y + person.velocity.y * first, person.position.y + person.velocity.y * last);
        let reach = radius + self.clearance + seen.ego.width / 2.0;
        let target = if left { one.max(other) + reach } else { one.min(other) - reach };
        Some(Passage { target, arrives: first, braking })
    }

    /// Whether it comes to a place beside its lane within a time (s): while its wheels turn its acceleration to the side grows, and then stays.
    fn reaches(&self, seen: &Observation, target: f64, time: f64) -> bool {
        let way = target - seen.ego.lateral_offset;
        let jerk = self.steering_rate * seen.ego.speed * seen.ego.speed / (2.0 * self.axle);
        let turning = (self.lateral / jerk).min(time);
        let left = time - turning;
        let comes =
            jerk * turning * turning * (turning / 6.0 + left / 2.0) + self.lateral * left * left / 2.0;
        way.abs() <= way.signum() * drift(seen) * time + comes
    }

    /// Whether nobody and nothing but `past` is or comes between where it is and a place beside its lane, for as long as it looks ahead.
    fn is_free(&self, seen: &Observation, target: f64, past: Option<usize>) -> bool {
        let (ego, road) = (&seen.ego, &seen.road);
        let half = ego.width / 2.0 + self.kerb_margin;
        let (low, high) = (ego.lateral_offset.min(target) - half, ego.lateral_offset.max(target) + half);
        let (mut right, mut left) = (road.right_kerb, road.left_kerb);
        if self.within_lane {
            (right, left) = (right.max(-road.lane_width / 2.0), left.min(road.lane_width / 2.0));
        }
        // Where it is already it may stay.
        if target - half < right.min(ego.lateral_offset - half) - TIE
            || target + half > left.max(ego.lateral_offset + half) + TIE
        {
            return false;
        }
        let reach = self.looks_ahead * ego.speed;
        let stands = |[(from, to), (rightmost, leftmost)]: &[(f64, f64); 2]| {
            let (from, to) = (from - ego.travelled, to - ego.travelled);
            *leftmost > low && *rightmost < high && to > -ego.length / 2.0 && from < ego.length / 2.0 + reach
        };
        let comes = |place: f64, speed: f64, apart: f64| {
            let later = place + (speed - ego.speed) * self.looks_ahead;
            place.min(later) < apart && place.max(later) > -apart
        };
        let vehicle = |other: &sim::SeenVehicle| {
            let aside = (other.position.y + other.width / 2.0, other.position.y - other.width / 2.0);
            let in_its_way = aside.0 > low && aside.1 < high;
            in_its_way && comes(other.position.x, other.velocity.x, (ego.length + other.length) / 2.0 + 1.0)
        };
        let walker = |person: &SeenPedestrian| {
            let (radius, x) = (half_size(person.shape), person.position.x);
            if past == Some(person.id) || x + radius < -ego.length / 2.0 || x > reach + ego.length / 2.0 {
                return false;
            }
            let time = (x / ego.speed.max(1.0)).clamp(0.0, self.looks_ahead);
            let (now, then) = (person.position.y, person.position.y + person.velocity.y * time);
            now.max(then) + radius > low && now.min(then) - radius < high
        };
        !self.boxes.iter().any(stands)
            && !seen.vehicles.iter().any(vehicle)
            && !seen.pedestrians.iter().any(walker)
    }

    /// The swerve past somebody for whom braking does not suffice: the shorter one, of those for which there are time and room.
    fn swerve(&self, seen: &Observation, person: &SeenPedestrian) -> Option<Stage> {
        let swerve = |left: bool| {
            let passage = self.past(seen, person, left)?;
            let fits = self.reaches(seen, passage.target, passage.arrives)
                && self.is_free(seen, passage.target, Some(person.id));
            fits.then_some((left, passage))
        };
        let way = |(_, passage): &(bool, Passage)| (passage.target - seen.ego.lateral_offset).abs();
        let found =
            [true, false].into_iter().filter_map(swerve).min_by(|one, other| way(one).total_cmp(&way(other)));
        found.map(|(left, passage)| Stage::Swerves { id: person.id, left, passage })
    }

    /// The curvature that brings it to a place beside its lane at once: it drifts there no faster than it can stop drifting, and at no larger
    /// angle than a lane change needs.
    fn swerving(&self, seen: &Observation, target: f64) -> f64 {
        /// How fast what is left of the way shrinks at its end, 1/s.
        const ENDS: f64 = 2.0;
        /// How fast a wrong drift is mended, 1/s.
        const MENDS: f64 = 6.0;
        /// To the lane, rad.
        const ANGLE: f64 = 0.35;
        let speed = seen.ego.speed;
        if speed < 0.1 {
            return own(seen);
        }
        let left = target - seen.ego.lateral_offset;
        let stops = libm::sqrt(1.2 * self.lateral * left.abs());
        let wanted = left.signum() * stops.min(ENDS * left.abs()).min(ANGLE * speed);
        let lateral = (MENDS * (wanted - drift(seen))).clamp(-self.lateral, self.lateral);
        own(seen) + (lateral / (speed * speed)).clamp(-TIGHTEST, TIGHTEST)
    }

    /// The curvature of the arc that leads its rear axle to a point of its lane, or beside it, that lies ahead.
    fn pursuing(&self, seen: &Observation, target: f64) -> f64 {
        let ahead = (self.lookahead * seen.ego.speed).max(NEAREST);
        let rear = seen.ego.lateral_offset - self.axle * libm::sin(seen.ego.heading_error);
        let aim = libm::asin(((target - rear) / ahead).clamp(-0.5, 0.5)) - seen.ego.heading_error;
        own(seen) + (2.0 * libm::sin(aim) / ahead).clamp(-TIGHTEST, TIGHTEST)
    }
}

/// It steers no tighter than this, 1/m: less than what the wheels of a passenger car make.
const TIGHTEST: f64 = 0.15;

/// Nor does it aim nearer than this, m.
const NEAREST: f64 = 6.0;

/// The curvature of its lane beside it, 1/m.
fn own(seen: &Observation) -> f64 {
    seen.ego.curvature / (1.0 - seen.ego.curvature * seen.ego.lateral_offset).max(0.1)
}

impl Controller for IdmAes {
    fn schedule(&self) -> Schedule {
        self.aeb.schedule()
    }

    fn act(&mut self, seen: &Observation) -> Result<Command, ControllerError> {
        let Command::Acceleration(along) = self.aeb.act(&beside(seen))? else {
            unreachable!("it gives accelerations");
        };
        self.mode = self.aeb.word();
        let hazard = self.aeb.emergency();
        if let (Some(id), false) = (hazard, matches!(self.stage, Stage::Swerves { .. }))
            && let Some(person) = seen.pedestrians.iter().find(|one| one.id == id)
        {
            let gap = person.position.x - half_size(person.shape) - seen.ego.length / 2.0;
            if gap > 0.0 && arrives(seen, gap, self.deceleration, self.jerk).is_some() {
                self.stage = self.swerve(seen, person).unwrap_or(self.stage);
            }
        }
        if let Stage::Swerves { id, left, passage } = self.stage {
            let person = seen.pedestrians.iter().find(|one| one.id == id);
            let ahead = person.filter(|one| one.position.x + half_size(one.shape) > -seen.ego.length / 2.0);
            self.stage = match ahead {
                None => Stage::Keeps,
                // They may walk on otherwise than they did.
                Some(person) => {
                    let again = self.past(seen, person, left);
                    let again = again.filter(|again| self.is_free(seen, again.target, Some(id)));
                    Stage::Swerves { id, left, passage: again.unwrap_or(passage) }
                }
            };
        }
        self.curvature = match self.stage {
            Stage::Follows => None,
            Stage::Swerves { passage, .. } => Some(self.swerving(seen, passage.target)),
            // Back as soon as there is room.
            Stage::Keeps if self.is_free(seen, 0.0, None) => Some(self.pursuing(seen, 0.0)),
            Stage::Keeps => Some(self.pursuing(seen, seen.ego.lateral_offset)),
        };
        let braking = match self.stage {
            Stage::Swerves { passage, .. } => {
                self.mode = "emergency_steering";
                passage.braking
            }
            _ => self.deceleration,
        };
        if seen.ego.lateral_offset.abs() > 0.05 && self.mode == "cruise" {
            self.mode = "returning";
        }
        Ok(Command::Acceleration(along.max(-braking)))
    }

    fn curvature(&self) -> Option<f64> {
        self.curvature
    }

    fn mode(&self) -> Mode {
        Mode::new(self.mode)
    }
}
