//! The COMMOTIONS model as a driver: a vehicle that negotiates with pedestrians as a person at the wheel would.

use super::hazard::keep_speed;
use super::idm::Idm;
use super::red_light::{self, RedLight};
use super::{CommandKind, ControllerContext, ControllerModel};
use crate::pedestrian::commotions::model::{Bodies, Person};
use crate::pedestrian::commotions::parameters::parameters;
use crate::pedestrian::commotions::state::{AgentBody, Control};
use crate::pedestrian::commotions::{CommotionsAgent, ConflictState, Rules, Sight, State};
use numbers::random::Stream;
use scenario::{
    Approach, Attention, Chance, Declaration, LooksAt, Parameter, PedestrianSetup, SignalConduct, Value,
};
use sim::random::{self, Purpose};
use sim::{
    Command, Controller, ControllerError, EgoState, Mode, ModelError, Observation, Schedule, SeenPedestrian,
};

/// The parameter that says whether it keeps behind vehicles ahead.
const FOLLOWS: &str = "follows_vehicles";

/// The registry entry.
pub fn commotions() -> ControllerModel {
    let declaration = Declaration::new(
        "commotions",
        "A human-like driver: the COMMOTIONS model with its acceleration controlled",
    )
    .source(
        "Markkula, Lin, Srinivasan, Billington, Leonetti, Kalantari, Yang, Lee, \
         Madigan and Merat, PNAS Nexus 2(6), 2023",
    )
    .parameters(parameters())
    .with(Parameter::pedestrian(
        "same_as",
        "The pedestrian whose parameters the driver has, as both agents of the published fits have the same; what else is \
         said here wins",
        "Markkula et al. 2023",
    ))
    .with(
        Parameter::flag(
            FOLLOWS,
            true,
            "Whether it keeps behind vehicles ahead in its lane, by the intelligent driver model as a second bound: the smaller acceleration \
             counts, and nothing is drawn for it",
            "ours; the model knows pedestrians alone",
        )
        .was(Value::Flag(false)),
    );
    ControllerModel::new(declaration, CommandKind::Acceleration, build)
        .driving("ideal")
        .chance(Chance::Always)
        .signals(SignalConduct::Obeys)
        .attention(Attention::Reacts(|settings| LooksAt {
            people_along: false,
            vehicles_ahead: settings.flag(FOLLOWS),
            ..LooksAt::OWN_LANE
        }))
}

fn build(context: &ControllerContext) -> Result<Box<dyn Controller>, ModelError> {
    let aslant = |person: &PedestrianSetup| (person.goal.x - person.start.x).abs() > 0.0;
    if let Some(rides) = context.world.pedestrians.iter().find(|person| !person.kind.is_pedestrian()) {
        return Err(ModelError::with_hint(
            format!(
                "`commotions` as a driver knows only people on foot, and `{}` is {}",
                rides.name,
                rides.kind.noun()
            ),
            "take `careful_human`, or another controller",
        ));
    }
    if context.world.road_of(context.setup).bend.is_some() || context.world.pedestrians.iter().any(aslant) {
        return Err(ModelError::with_hint(
            "`commotions` as a driver knows only people who cross a straight road at a right angle",
            "take `careful_human`, or another controller",
        ));
    }
    let person =
        Person::from_settings(context.settings, context.world.road_of(context.setup), context.world.step)?;
    let vehicle = (context.setup.length, context.setup.width);
    let bodies = context.world.pedestrians.iter().map(|pedestrian| {
        let bodies = Bodies { pedestrian: pedestrian.shape.extents(), vehicle };
        (bodies.vehicle(), bodies.pedestrian())
    });
    let agent = random::Agent::Vehicle(context.rank);
    Ok(Box::new(Driver {
        agent: CommotionsAgent::among(
            &person.variant,
            &person.parameters,
            Control::Acceleration,
            person.dt,
            bodies.clone(),
        ),
        sights: Vec::with_capacity(bodies.len()),
        meetings: bodies.map(|(own, other)| Meeting { own, other, seen: None }).collect(),
        draws: random::stream(context.seed, agent, Purpose::Perception),
        acceleration: 0.0,
        red_light: RedLight::new(context, red_light::REACTION, red_light::DECELERATION),
        idm: context.settings.flag(FOLLOWS).then(|| Idm::behind_others(BACK_TO_SPEED.0, BACK_TO_SPEED.1)),
        slowed: false,
        for_red: None,
        follows: false,
        period: person.dt,
        entry_inhibited_until: context.settings.number("entry_inhibited_until"),
    }))
}

/// Above this speed (m/s) somebody walks; below, what is seen may be noise.
const WALKING: f64 = 0.5;

/// What a driver knows of one pedestrian.
struct Meeting {
    own: AgentBody,
    other: AgentBody,
    seen: Option<Seen>,
}

/// What was seen of a pedestrian.
#[derive(Clone, Copy)]
struct Seen {
    /// Which way it crosses: +1 to the left, −1 to the right.
    direction: f64,
    /// Where its way crosses the lane, from the middle of the crossing on (m).
    line: f64,
    /// From the vehicle's centre to there (m), also while it is out of sight.
    ahead: f64,
    /// Its state when it was last in sight.
    state: State,
    /// Whether it is in sight now.
    now: bool,
    /// Whether it walks, and not towards the lane.
    elsewhere: bool,
}

impl Seen {
    fn new(pedestrian: &SeenPedestrian, ego: &EgoState, before: Option<Self>) -> Self {
        let SeenPedestrian { position, velocity, .. } = pedestrian;
        let direction = before.map_or_else(
            || {
                // Who stands beside the lane means to cross it.
                let towards_the_lane = if position.y > 0.0 { -1.0 } else { 1.0 };
                if velocity.y == 0.0 { towards_the_lane } else { velocity.y.signum() }
            },
            |before| before.direction,
        );
        let approach = Approach::seen(pedestrian, direction);
        Self {
            direction,
            line: position.x + ego.travelled,
            ahead: position.x,
            state: approach.into(),
            now: true,
            elsewhere: approach.speed <= 0.0 && velocity.norm() > WALKING,
        }
    }
}

impl Meeting {
    /// How the conflict with a pedestrian that was seen stands; `None` for one who is out of sight and was not coming.
    fn conflict(&self, seen: &Seen) -> Option<ConflictState> {
        if self.is_past(seen) || seen.state.distance <= -self.other.half_extent {
            Some(ConflictState::Over)
        } else if seen.elsewhere && !self.other.occupies(seen.state.distance) {
            seen.now.then_some(ConflictState::Dormant)
        } else if seen.now {
            Some(ConflictState::Open)
        } else {
            Some(ConflictState::Remembered)
        }
    }

    /// Whether the vehicle has left the conflict space.
    fn is_past(&self, seen: &Seen) -> bool {
        seen.ahead < -self.own.half_extent
    }
}

/// A driver among pedestrians. With nobody in sight the speed is kept.
struct Driver {
    agent: CommotionsAgent,
    meetings: Vec<Meeting>,
    /// Those of this step.
    sights: Vec<Sight>,
    draws: Stream,
    /// What was decided last (m/s²).
    acceleration: f64,
    /// `None`: it ignores signals.
    red_light: Option<RedLight>,
    /// `None`: it is blind to vehicles.
    idm: Option<Idm>,
    /// Whether a signal or a vehicle ahead has slowed it, so that its speed is no longer the one to keep.
    slowed: bool,
    /// While it brakes for a signal, whether it stands.
    for_red: Option<bool>,
    /// Whether a vehicle ahead decides its acceleration.
    follows: bool,
    period: f64,
    entry_inhibited_until: f64,
}

/// Acceleration back to the wanted speed with nobody in sight, and deceleration to it, m/s²: those of `yielding`.
const BACK_TO_SPEED: (f64, f64) = (1.5, 2.0);

impl Driver {
    /// Whether it has seen somebody whom it has not passed.
    fn meets_anybody(&self) -> bool {
        let met = |meeting: &Meeting| meeting.seen.is_some_and(|seen| !meeting.is_past(&seen));
        self.meetings.iter().any(met)
    }

    /// Takes down who is in sight now, and how far ahead those are who are not.
    fn look(&mut self, observation: &Observation) {
        let ego = &observation.ego;
        for seen in self.meetings.iter_mut().filter_map(|meeting| meeting.seen.as_mut()) {
            seen.ahead = seen.line - ego.travelled;
            seen.now = false;
        }
        for pedestrian in &observation.pedestrians {
            if let Some(meeting) = self.meetings.get_mut(pedestrian.id) {
                meeting.seen = Some(Seen::new(pedestrian, ego, meeting.seen));
            }
        }
        self.sights.clear();
        for (other, meeting) in self.meetings.iter().enumerate() {
            if let Some(seen) = &meeting.seen
                && let Some(conflict) = meeting.conflict(seen)
            {
                let own = State { distance: seen.ahead, speed: ego.speed, acceleration: ego.acceleration };
                let state = seen.state;
                // People walk in no lanes and overtake each other: everybody is the next on a path of their own.
                self.sights.push(Sight { other, path: other, own, state, apart: None, conflict });
            }
        }
    }
}

impl Controller for Driver {
    fn schedule(&self) -> Schedule {
        Schedule::every(self.period)
    }

    fn act(&mut self, observation: &Observation) -> Result<Command, ControllerError> {
        let rules = Rules {
            pedestrian_priority: observation.road.pedestrian_priority,
            entry_inhibited: observation.time < self.entry_inhibited_until,
        };
        self.look(observation);
        // With nobody to decide about, what was decided last goes on.
        let speed = observation.ego.speed;
        let decision = self.agent.step_among(&self.sights, &rules, &mut self.draws);
        if let Some(decision) = decision {
            self.acceleration = decision.acceleration;
        }
        if self.slowed && !self.meets_anybody() {
            let (up, down) = BACK_TO_SPEED;
            self.acceleration = keep_speed(speed, observation.cruise_speed, up, down);
        }
        let behind = self.idm.as_ref().and_then(|idm| idm.bound(observation));
        let behind = behind.filter(|behind| *behind < self.acceleration);
        self.follows = behind.is_some();
        let braking = self.red_light.as_mut().and_then(|rule| rule.braking(observation));
        self.for_red = braking.map(|_| red_light::stands(speed));
        self.slowed |= self.follows || braking.is_some();
        let bounds = behind.into_iter().chain(braking.map(|braking| -braking));
        Ok(Command::Acceleration(bounds.fold(self.acceleration, f64::min)))
    }

    fn mode(&self) -> Mode {
        if let Some(stands) = self.for_red {
            return Mode::new(red_light::mode(stands));
        }
        Mode::new(match self.follows {
            true => "following",
            false if self.meets_anybody() => "negotiating",
            false => "",
        })
    }
}
