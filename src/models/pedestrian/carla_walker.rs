//! CARLA's AI walker: walks to the kerb, looks once for a near vehicle, and crosses without looking again.
//!
//! A reduction of WalkerAIController and its Detour crowd: walkers drive each other off as vehicles do, but there is no navigation mesh
//! and no velocity-obstacle sampling, by which CARLA's also choose a way around others.

use nalgebra::Vector2;

use super::sum::sum_in_any_order;
use super::{PedestrianContext, PedestrianModel};
use crate::pedestrian::across::check_across;
use numbers::random::Stream;
use scenario::{
    ChoiceOption, Declaration, Dimension, Parameter, Preset, PresetFamily, Road, Settings, Side, Value,
};
use sim::random::{Agent, Purpose, stream};
use sim::sight::sees_vehicle;
use sim::{Mode, ModelError, Motion, Pedestrian, Scene, VehicleState, geometry};

const WALKER: &str = "CARLA LibCarla/source/carla/nav";
const EVENT: &str = "CARLA nav/WalkerEvent.cpp, nav/WalkerManager.cpp";
const LIGHTS: &str = "derived from CARLA's default signal timing (issue 7684); the share is free to \
                      calibrate";

pub fn carla_walker() -> PedestrianModel {
    let declaration = Declaration::new(
        "carla_walker",
        "CARLA's AI walker: pauses near the kerb, looks once for a vehicle within 6 m, \
         then crosses blindly.",
    )
    .source("CARLA WalkerAIController on a Detour crowd, 0.9.14 and 0.9.15, reduced")
    .parameters([
        Parameter::number(
            "walking_speed",
            Dimension::SPEED,
            1.4,
            (0.0, 12.0),
            "Speed of walking; CARLA's navigation default is 1.47 m/s.",
            WALKER,
        ),
        Parameter::number(
            "arrival_distance",
            Dimension::LENGTH,
            0.6,
            (0.01, 10.0),
            "Distance from the goal below which it slows down in proportion.",
            WALKER,
        ),
        Parameter::number(
            "start_delay",
            Dimension::TIME,
            0.0,
            (0.0, 600.0),
            "Time that it stands after it appeared.",
            "one or two ticks in CARLA",
        ),
        Parameter::flag("checks", true, "Whether it pauses and looks for vehicles before the kerb.", EVENT),
        Parameter::number(
            "check_distance",
            Dimension::LENGTH,
            1.0,
            (0.0, 10.0),
            "Distance from the kerb at which it pauses.",
            EVENT,
        ),
        Parameter::number(
            "check_timeout",
            Dimension::TIME,
            60.0,
            (0.0, 3600.0),
            "Pause after which it gives up crossing and walks away along the road.",
            EVENT,
        ),
        Parameter::number(
            "look_distance",
            Dimension::LENGTH,
            6.0,
            (0.0, 200.0),
            "It waits for vehicles whose centre is at most this far away.",
            EVENT,
        ),
        Parameter::number(
            "look_cosine",
            Dimension::NUMBER,
            0.34,
            (-1.0, 1.0),
            "Cosine of the angle to its way across within which it sees vehicles (0.34 is \
             70 degrees).",
            EVENT,
        ),
        Parameter::optional(
            "kerb_wait",
            Dimension::TIME,
            (0.0, 600.0),
            "Shortest pause before the kerb; without it, it is drawn anew in every run \
             from the mixture below.",
            LIGHTS,
        ),
        Parameter::number(
            "kerb_wait_share",
            Dimension::NUMBER,
            0.3,
            (0.0, 1.0),
            "Share of runs with a pause (the nearest traffic light happens to be green for \
             vehicles); the others have none.",
            LIGHTS,
        ),
        Parameter::number(
            "kerb_wait_min",
            Dimension::TIME,
            0.0,
            (0.0, 600.0),
            "Shortest such pause.",
            LIGHTS,
        ),
        Parameter::number(
            "kerb_wait_max",
            Dimension::TIME,
            13.0,
            (0.0, 600.0),
            "Longest such pause; uniform in between.",
            LIGHTS,
        ),
        Parameter::choice(
            "vehicles_nearby",
            "push",
            [
                ChoiceOption::new(
                    "push",
                    "Is driven off by vehicles within `separation_range` and pushed out of their \
                     margin.",
                ),
                ChoiceOption::new(
                    "static",
                    "Stands while a vehicle's margin overlaps it; otherwise walks straight.",
                ),
            ],
            "What vehicles do to it while it walks.",
            WALKER,
        ),
        Parameter::number("margin", Dimension::LENGTH, 0.8, (0.0, 10.0), "Margin around vehicles.", WALKER),
        Parameter::number(
            "front_margin",
            Dimension::LENGTH,
            0.2,
            (0.0, 10.0),
            "Additional margin in front of vehicles.",
            WALKER,
        ),
        Parameter::number(
            "radius",
            Dimension::LENGTH,
            0.3,
            (0.0, 2.0),
            "Its radius in the crowd: that of other walkers as well, and with `vehicles_nearby: static` what must not touch a vehicle's margin.",
            WALKER,
        ),
        Parameter::number(
            "separation_weight",
            Dimension::NUMBER,
            0.5,
            (0.0, 100.0),
            "Weight of being driven off by vehicles and other people.",
            WALKER,
        ),
        Parameter::number(
            "separation_range",
            Dimension::LENGTH,
            10.0,
            (0.1, 200.0),
            "Distance from a vehicle's margin, or between two people, within which it is driven off.",
            WALKER,
        ),
        Parameter::number(
            "push_speed",
            Dimension::SPEED,
            1.4,
            (0.0, 100.0),
            "Fastest that a vehicle's margin pushes it; a faster vehicle makes contact.",
            "assumption: the limit in CARLA is not known",
        ),
        Parameter::number(
            "stuck_time",
            Dimension::TIME,
            4.0,
            (0.0, 3600.0),
            "Walking less than `stuck_distance` within this time, it turns to a new place \
             on either pavement, up to 20 m along the road (assumption); 0: never.",
            EVENT,
        ),
        Parameter::number("stuck_distance", Dimension::LENGTH, 0.5, (0.0, 100.0), "See `stuck_time`.", EVENT),
        Parameter::number(
            "snap_min",
            Dimension::LENGTH,
            0.0,
            (-5.0, 5.0),
            "Least distance that it starts farther from the road than declared; CARLA's \
             spawning snaps by about -0.5 .. 1 m.",
            "observed offsets of CARLA spawns",
        ),
        Parameter::number(
            "snap_max",
            Dimension::LENGTH,
            0.0,
            (-5.0, 5.0),
            "Largest such distance; uniform in between.",
            "observed offsets of CARLA spawns",
        ),
    ])
    .presets(PresetFamily::new(
        "release",
        "recent",
        [
            Preset::new("recent", "CARLA 0.9.15 and later: also waits for the nearest traffic light.", []),
            Preset::new(
                "old",
                "CARLA up to 0.9.14: pauses farther from the kerb, gives up after 5 s, knows \
                 no traffic lights.",
                [
                    ("check_distance", Value::Number(2.0)),
                    ("check_timeout", Value::Number(5.0)),
                    ("kerb_wait_share", Value::Number(0.0)),
                ],
            ),
        ],
    ));
    PedestrianModel::new(declaration, build)
}

#[derive(Clone, Copy, PartialEq)]
enum State {
    /// Until its start delay is over.
    Wait,
    /// On the pavement, on its way to the pause.
    Approach,
    /// Paused before the kerb since a time (s).
    Check(f64),
    Walk,
    /// Gave up; walks away in this direction.
    WalkAway(Vector2<f64>),
    Dead,
}

struct CarlaWalker {
    speed: f64,
    arrival_distance: f64,
    start_delay: f64,
    /// `None`: does not check.
    check: Option<Check>,
    vehicles: Vehicles,
    /// Start to goal.
    way: Vector2<f64>,
    /// How much farther from the road it starts than declared, m.
    snap: f64,
    /// Whether it turns left along the road when it gives up.
    turns_left: bool,
    /// Of the road from which it comes.
    side: Side,
    since: Option<f64>,
    /// Whether it waits for a real signal.
    obeys_signals: bool,
    state: State,
    /// Where it came from and where it was going; a new destination is on one of these pavements.
    ends: [Vector2<f64>; 2],
    goal: Vector2<f64>,
    /// Whether `goal` is the pavement that it started from.
    goes_back: bool,
    /// Whether it stands at `goal`.
    arrived: bool,
    unstuck: Unstuck,
    /// Of new destinations and the pauses on the way to them.
    draws: Stream,
}

/// The test for being stuck.
struct Unstuck {
    time: f64,
    distance: f64,
    /// Time (s) and place of the last test; `None` while it does not walk.
    last: Option<(f64, Vector2<f64>)>,
}

/// The pause before the kerb.
struct Check {
    /// Where its way enters the road.
    entry: Vector2<f64>,
    distance: f64,
    timeout: f64,
    wait: f64,
    waits: Waits,
    look_distance: f64,
    look_cosine: f64,
}

/// How long the pause before the kerb is at least: fixed, or drawn from a mixture.
struct Waits {
    fixed: Option<f64>,
    share: f64,
    shortest: f64,
    longest: f64,
}

/// What vehicles do to a walking pedestrian.
struct Vehicles {
    pushes: bool,
    margin: f64,
    front_margin: f64,
    radius: f64,
    weight: f64,
    range: f64,
    push_speed: f64,
}

/// Below this speed a vehicle does no harm, m/s.
const HARMLESS_SPEED: f64 = 0.1;

/// Clearance below which separation grows no more, m. The formula diverges at the margin itself, where a pushed
/// walker ends up but for rounding.
const LEAST_CLEARANCE: f64 = 0.01;

/// How far along the road a new destination may be, m.
const DETOUR: f64 = 20.0;

/// It slows down in proportion to the way that is left and never quite gets there; nearer than this it is there, m.
const THERE: f64 = 0.05;

/// Absorbs the rounding of summed times, s.
const TIME_TOLERANCE: f64 = 1e-9;

fn build(context: &PedestrianContext) -> Result<Box<dyn Pedestrian>, ModelError> {
    check_across(context, "carla_walker")?;
    let settings = context.settings;
    for (low, high) in [("kerb_wait_min", "kerb_wait_max"), ("snap_min", "snap_max")] {
        if settings.number(low) > settings.number(high) {
            return Err(ModelError::with_hint(
                format!("`{low}` of `carla_walker` is larger than `{high}`"),
                format!("let `{low}` be at most `{high}`; each has its own default"),
            ));
        }
    }
    let (start, goal) = (Vector2::from(context.setup.start), Vector2::from(context.setup.goal));
    let (road, kerb_side) = (&context.world.road, context.setup.side);
    let across = road.crossing_velocity(start, kerb_side, 1.0);
    let way = (goal - start).try_normalize(1e-9).unwrap_or(across);
    // Draws always happen, and in this order, so that no setting shifts another's.
    let mut draws = stream(context.seed, Agent::Pedestrian(context.rank), Purpose::Trait);
    let (waits, wait, snap, side) = (draws.uniform(), draws.uniform(), draws.uniform(), draws.uniform());
    // A real signal in its way replaces what stands for one.
    let has_signal = context.setup.meets_signal(road);
    let lengths = Waits {
        fixed: settings.optional_number("kerb_wait").or(has_signal.then_some(0.0)),
        share: settings.number("kerb_wait_share"),
        shortest: settings.number("kerb_wait_min"),
        longest: settings.number("kerb_wait_max"),
    };
    let (nearest, farthest) = (settings.number("snap_min"), settings.number("snap_max"));
    let snap = nearest + (farthest - nearest) * snap;
    let before_kerb = (road.kerb(kerb_side) - road.across(start)) * kerb_side.walking_sign() + snap;
    let entry = match road.bend {
        None => Some(start + way * ((before_kerb - snap) / way.dot(&across))),
        // It sets out so far behind its start.
        Some(_) => road.kerb_ahead(kerb_side, start - way * snap, way),
    };
    let enters = settings.flag("checks") && way.dot(&across) > 0.0 && before_kerb > 0.0;
    let check = entry.filter(|_| enters).map(|entry| Check {
        entry,
        distance: settings.number("check_distance"),
        timeout: settings.number("check_timeout"),
        wait: lengths.length(waits, wait),
        waits: lengths,
        look_distance: settings.number("look_distance"),
        look_cosine: settings.number("look_cosine"),
    });
    Ok(Box::new(CarlaWalker {
        speed: settings.number("walking_speed"),
        arrival_distance: settings.number("arrival_distance"),
        start_delay: settings.number("start_delay"),
        check,
        vehicles: Vehicles::from_settings(settings),
        way,
        snap,
        turns_left: side < 0.5,
        side: kerb_side,
        since: None,
        obeys_signals: context.setup.obeys_signals,
        state: State::Wait,
        ends: [start, goal],
        goal,
        goes_back: false,
        arrived: false,
        unstuck: Unstuck {
            time: settings.number("stuck_time"),
            distance: settings.number("stuck_distance"),
            last: None,
        },
        draws: stream(context.seed, Agent::Pedestrian(context.rank), Purpose::Decision),
    }))
}

impl Vehicles {
    fn from_settings(settings: &Settings) -> Self {
        Self {
            pushes: settings.word("vehicles_nearby") == "push",
            margin: settings.number("margin"),
            front_margin: settings.number("front_margin"),
            radius: settings.number("radius"),
            weight: settings.number("separation_weight"),
            range: settings.number("separation_range"),
            push_speed: settings.number("push_speed"),
        }
    }

    /// From the vehicle's margin to a place, m; negative inside: minus the shortest way out.
    fn clearance(&self, vehicle: &VehicleState, place: Vector2<f64>) -> f64 {
        let offset = place - vehicle.position();
        let offset = vehicle.turned(offset);
        let ahead = offset.x;
        let half_length = vehicle.length / 2.0 + self.margin;
        let half_width = vehicle.width / 2.0 + self.margin;
        let beyond = Vector2::new(
            (ahead - half_length - self.front_margin).max(-half_length - ahead),
            offset.y.abs() - half_width,
        );
        if beyond.x <= 0.0 && beyond.y <= 0.0 {
            beyond.x.max(beyond.y)
        } else {
            libm::hypot(beyond.x.max(0.0), beyond.y.max(0.0))
        }
    }

    /// How it moves if it wants to walk at `speed` (m/s) in direction `way`.
    fn motion(&self, scene: &Scene, way: Vector2<f64>, speed: f64) -> Motion {
        let place = scene.ego().position;
        if !self.pushes {
            let blocked = scene.vehicles.iter().any(|vehicle| self.clearance(vehicle, place) < self.radius);
            return Motion::Walk(if blocked { Vector2::zeros() } else { way * speed });
        }
        let near =
            scene.vehicles.iter().map(|vehicle| (self.clearance(vehicle, place), place - vehicle.position()));
        // Of several the one whose margin it is deepest in, in whatever order they come.
        let order = |one: &(f64, Vector2<f64>), other: &(f64, Vector2<f64>)| {
            let by_place = one.1.x.total_cmp(&other.1.x).then(one.1.y.total_cmp(&other.1.y));
            one.0.total_cmp(&other.0).then(by_place)
        };
        if let Some((clearance, away)) = near.clone().min_by(order)
            && clearance <= 0.0
        {
            let out = away.try_normalize(1e-9).unwrap_or(way);
            let push = (-clearance).min(self.push_speed * scene.step);
            return Motion::Pushed { velocity: Vector2::zeros(), displacement: out * push };
        }
        let others = scene.pedestrians.iter().enumerate();
        let others = others.filter(|(index, other)| *index != scene.me && other.present).map(|(_, other)| {
            let away = place - other.position;
            (away.norm() - 2.0 * self.radius, away)
        });
        let neighbours = near.chain(others).filter(|(clearance, _)| *clearance < self.range);
        let drives = neighbours.clone().map(|(clearance, away)| {
            let share = clearance / self.range;
            away * (self.weight * (1.0 - share * share) / clearance.max(LEAST_CLEARANCE))
        });
        let mut velocity = way * speed;
        let count = neighbours.count();
        if count > 0 {
            velocity += sum_in_any_order(drives) / count as f64;
            let squared = velocity.norm_squared();
            if squared > speed * speed {
                velocity *= speed * speed / squared;
            }
        }
        Motion::Walk(velocity)
    }
}

impl Waits {
    /// The pause (s) that two uniform draws come to.
    fn length(&self, waits: f64, share: f64) -> f64 {
        let drawn =
            if waits < self.share { self.shortest + (self.longest - self.shortest) * share } else { 0.0 };
        self.fixed.unwrap_or(drawn)
    }
}

impl Check {
    /// Whether a vehicle in sight is near enough, and far enough ahead on the way across, to wait for.
    fn waits_for_vehicle(&self, scene: &Scene, way: Vector2<f64>) -> bool {
        scene.vehicles.iter().enumerate().any(|(index, vehicle)| {
            let to_vehicle = vehicle.position() - scene.ego().position;
            let distance = to_vehicle.norm();
            distance <= self.look_distance
                && to_vehicle.dot(&way) >= self.look_cosine * distance
                && sees_vehicle(scene, index)
        })
    }
}

impl CarlaWalker {
    /// Whether a signal that it obeys shows it no green.
    fn has_red(&self, scene: &Scene) -> bool {
        self.obeys_signals && !scene.pedestrian_priority()
    }

    fn next_state(&self, scene: &Scene, since: f64) -> State {
        let ego = scene.ego();
        let hit = |vehicle: &VehicleState| {
            vehicle.motion.speed > HARMLESS_SPEED && geometry::distance(vehicle, ego) == 0.0
        };
        if scene.vehicles.iter().any(hit) {
            return State::Dead;
        }
        let mut state = self.state;
        if state == State::Wait && scene.time - since >= self.start_delay - TIME_TOLERANCE {
            state = State::Approach;
        }
        if state == State::Approach {
            state = match &self.check {
                Some(check) if (check.entry - ego.position).norm() > check.distance + 1e-9 => State::Approach,
                Some(_) => State::Check(scene.time),
                None => State::Walk,
            };
        }
        match (&self.check, state) {
            (Some(check), State::Check(from)) => {
                let paused = scene.time - from + TIME_TOLERANCE;
                if paused >= check.timeout && check.timeout > 0.0 {
                    State::WalkAway(Vector2::new(if self.turns_left { -1.0 } else { 1.0 }, 0.0))
                } else if paused < check.wait
                    || self.has_red(scene)
                    || check.waits_for_vehicle(scene, self.way)
                {
                    state
                } else {
                    State::Walk
                }
            }
            _ => state,
        }
    }
}

impl CarlaWalker {
    /// Every `stuck_time`, turns to a new destination if it hardly moved and is not there yet.
    fn turn_if_stuck(&mut self, scene: &Scene) {
        let place = scene.ego().position;
        let stuck = &mut self.unstuck;
        let (since, before) = *stuck.last.get_or_insert((scene.time, place));
        if stuck.time == 0.0 || scene.time - since < stuck.time - TIME_TOLERANCE {
            return;
        }
        stuck.last = Some((scene.time, place));
        let arrived = (self.goal - place).norm() < self.arrival_distance;
        if !arrived && (place - before).norm() < stuck.distance {
            self.turn(place, scene.road);
        }
    }

    /// Takes a new destination on either pavement; where its way there enters the road, it pauses before the kerb.
    fn turn(&mut self, place: Vector2<f64>, road: &Road) {
        let end = self.draws.index(2);
        self.goes_back = end == 0;
        self.goal = self.ends[end] + road.way_along(self.ends[end]) * self.draws.uniform_in(-DETOUR, DETOUR);
        self.state = State::Walk;
        let Some(check) = self.check.as_mut().filter(|_| !self.goes_back) else { return };
        let way = self.goal - place;
        let entry = match road.bend {
            None => {
                // Every way in leads over the kerb line of the first.
                let part = (check.entry.y - place.y) / way.y;
                (part > 0.0).then(|| place + way * part)
            }
            Some(_) => road.kerb_ahead(self.side, place, way),
        };
        if let Some(entry) = entry {
            check.entry = entry;
            check.wait = check.waits.length(self.draws.uniform(), self.draws.uniform());
            self.way = way.normalize();
            self.state = State::Approach;
        }
    }
}

impl Pedestrian for CarlaWalker {
    fn act(&mut self, scene: &Scene) -> Motion {
        let Some(since) = self.since else {
            self.since = Some(scene.time);
            if self.snap != 0.0 {
                return Motion::Pushed { velocity: Vector2::zeros(), displacement: self.way * -self.snap };
            }
            return self.act(scene);
        };
        self.state = self.next_state(scene, since);
        match self.state {
            State::Wait | State::Check(_) | State::Dead => {
                self.unstuck.last = None;
                self.arrived = false;
                Motion::Walk(Vector2::zeros())
            }
            State::WalkAway(direction) => self.vehicles.motion(scene, direction, self.speed),
            State::Approach | State::Walk => {
                if scene.held {
                    // Whoever waits at red is not stuck.
                    self.unstuck.last = None;
                }
                self.turn_if_stuck(scene);
                let place = scene.ego().position;
                if self.goes_back && (self.goal - place).norm() < self.arrival_distance {
                    // Back on the pavement that it came from it sets out again, as CARLA's do wherever they arrive.
                    self.turn(place, scene.road);
                    self.unstuck.last = None;
                }
                let to_goal = self.goal - place;
                let distance = to_goal.norm();
                self.arrived = distance < THERE;
                let way = to_goal.try_normalize(1e-9).unwrap_or_else(Vector2::zeros);
                let speed = self.speed * (distance / self.arrival_distance).min(1.0);
                self.vehicles.motion(scene, way, speed)
            }
        }
    }

    fn mode(&self) -> Mode {
        Mode::new(match self.state {
            State::Wait => "waiting",
            State::Approach | State::Walk if self.arrived => "arrived",
            State::Approach => "approaching",
            State::Check(_) => "checking",
            State::Walk => "walking",
            State::WalkAway(_) => "walking_away",
            State::Dead => "hit",
        })
    }

    fn free_speed(&self) -> f64 {
        self.speed
    }
}

#[cfg(test)]
mod tests;
