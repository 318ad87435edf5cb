//! The COMMOTIONS pedestrian as a registered model: its declaration, and what stands between the world and the agents.

use super::action::{ACTION_SIZES, ACTIONS, NO_ACTION};
use super::agent::{CommotionsAgent, ConflictState, Rules, Sight};
use super::following;
use super::parameters::{Parameters, SAFETY_DISTANCE, individual_ranges, parameters};
use super::prediction::{BEHAVIOUR_LIST, Behaviour};
use super::state::{AgentBody, Control, State};
use super::variant::{Accumulation, Variant, VariantError};
use crate::pedestrian::across::check_across;
use crate::pedestrian::{PedestrianContext, PedestrianModel};
use nalgebra::Vector2;
use numbers::random::Stream;
use scenario::{Conflict, ConflictArea, Declaration, Dimension, Road, Settings, Side, half_extent};
use sim::random::{self, Purpose};
use sim::sight::{sees_all_vehicles, sees_vehicle};
use sim::{
    Longitudinal, Mode, ModelError, ModelState, Motion, Pedestrian, PedestrianState, Scene, StateQuantity,
    Stated, StatedBy, VehicleState,
};

/// The registry entry.
pub fn commotions() -> PedestrianModel {
    let declaration = Declaration::new(
        "commotions",
        "A human-like pedestrian who perceives with noise, infers what the driver will \
         do and weighs when to go",
    )
    .source(
        "Markkula, Lin, Srinivasan, Billington, Leonetti, Kalantari, Yang, Lee, \
         Madigan and Merat, PNAS Nexus 2(6), 2023",
    )
    .parameters(parameters());
    PedestrianModel::new(declaration, build)
        .with_individuals()
        .ranging(individual_ranges)
        .in_legs()
        .keeping_off(keeps_off)
        .believing()
}

/// Passing second is impossible nearer than this to the conflict space (§6, point 6).
fn keeps_off(settings: &Settings) -> (&'static str, f64) {
    (SAFETY_DISTANCE, settings.number(SAFETY_DISTANCE))
}

fn build(context: &PedestrianContext) -> Result<Box<dyn Pedestrian>, ModelError> {
    check_across(context, "commotions")?;
    let person = Person::from_settings(context.settings, &context.world.road, context.world.step)?;
    let pedestrian = context.setup.shape.extents();
    let bodies = context.world.vehicles.iter().map(|vehicle| {
        let bodies = Bodies { pedestrian, vehicle: (vehicle.length, vehicle.width) };
        (bodies.pedestrian(), bodies.vehicle())
    });
    let meeting = |((own, other), path): ((AgentBody, AgentBody), usize)| Meeting {
        own,
        other,
        size: pedestrian,
        path,
        moved: false,
        crossing: None,
        seen: None,
        hidden: false,
    };
    let paths = context.world.vehicles.iter().map(|vehicle| vehicle.lane);
    let me = random::Agent::Pedestrian(context.rank);
    let agent = CommotionsAgent::among(
        &person.variant,
        &person.parameters,
        Control::Speed,
        person.dt,
        bodies.clone(),
    );
    Ok(Box::new(Walker {
        fresh: (!context.setup.stops.is_empty()).then(|| Box::new(agent.clone())),
        agent,
        sights: Vec::with_capacity(bodies.len()),
        meetings: bodies.zip(paths).map(meeting).collect(),
        draws: random::stream(context.seed, me, Purpose::Perception),
        free_speed: person.parameters.pedestrian_free_speed,
        action_duration: person.parameters.action_duration,
        steps_per_decision: person.steps_per_decision,
        entry_inhibited_until: context.settings.number("entry_inhibited_until"),
        obeys_signals: context.setup.obeys_signals,
        steps: 0,
        acceleration: 0.0,
        standing: true,
    }))
}

/// What the settings say of one commotions() road user.
pub struct Person {
    /// Its assumptions.
    pub variant: Variant,
    /// Its parameters.
    pub parameters: Parameters,
    /// Time step of its decisions (s).
    pub dt: f64,
    /// Simulation steps per decision.
    pub steps_per_decision: u64,
}

impl Person {
    /// Reads and checks resolved settings for a road and a simulation step (s).
    ///
    /// # Errors
    /// For a name that is no variant, and for times that do not fit each other.
    pub fn from_settings(settings: &Settings, road: &Road, step: f64) -> Result<Self, ModelError> {
        let variant: Variant = settings
            .word("variant")
            .parse()
            .map_err(|error: VariantError| ModelError::with_hint(error.message(), error.hint()))?;
        let mut parameters = Parameters::from_settings(settings);
        if settings.optional_number("veh_free_speed").is_none() {
            parameters.vehicle_free_speed = parameters.vehicle_free_speed.min(road.speed_limit);
        }
        let dt = settings.number("dt");
        let time = |value, of| Stated { value, dimension: Dimension::TIME, of };
        let steps = (dt / step).round();
        if steps < 1.0 || (steps * step / dt - 1.0).abs() > 1e-6 {
            return Err(ModelError::stating(
                "`commotions` decides every {}, which is no multiple of the simulation step of {}",
                [time(dt, StatedBy::Setting("dt".into())), time(step, StatedBy::Step)],
                "let `dt` be a multiple of the simulation step",
            ));
        }
        for (name, value, uses) in [
            ("T", parameters.evidence_time, variant.accumulation == Accumulation::Evidence),
            ("T_Of", parameters.observation_forgetting_time, variant.observation_beliefs),
            ("DeltaT", parameters.action_duration, true),
        ] {
            if uses && value < dt {
                return Err(ModelError::stating(
                    &format!("`{name}` of `commotions` is {{}}, shorter than its time step `dt` of {{}}"),
                    [time(value, StatedBy::Setting(name.into())), time(dt, StatedBy::Setting("dt".into()))],
                    format!("let `{name}` be at least as long as `dt`"),
                ));
            }
        }
        if variant.looming && parameters.looming_full <= parameters.looming_onset {
            let rate = |value, name: &'static str| Stated {
                value,
                dimension: Dimension::ANGULAR_SPEED,
                of: StatedBy::Setting(name.into()),
            };
            return Err(ModelError::stating(
                "`thetaDot_1` of `commotions` is {}, not above `thetaDot_0` of {}",
                [rate(parameters.looming_full, "thetaDot_1"), rate(parameters.looming_onset, "thetaDot_0")],
                "let `thetaDot_1` be larger than `thetaDot_0`",
            ));
        }
        Ok(Self { variant, parameters, dt, steps_per_decision: steps as u64 })
    }
}

/// Length and width (m) of the two who meet.
pub struct Bodies {
    /// Of the pedestrian.
    pub pedestrian: (f64, f64),
    /// Of the vehicle.
    pub vehicle: (f64, f64),
}

impl Bodies {
    /// The pedestrian's body in the conflict space (§1).
    pub fn pedestrian(&self) -> AgentBody {
        AgentBody {
            control: Control::Speed,
            half_extent: half_extent(self.pedestrian, self.vehicle),
            cosine: 0.0,
            width: self.pedestrian.1,
        }
    }

    /// The vehicle's body in the conflict space (§1).
    pub fn vehicle(&self) -> AgentBody {
        AgentBody {
            control: Control::Acceleration,
            half_extent: half_extent(self.vehicle, self.pedestrian),
            cosine: 0.0,
            width: self.vehicle.1,
        }
    }
}

/// What a pedestrian knows of one vehicle besides its state.
struct Meeting {
    own: AgentBody,
    other: AgentBody,
    /// The pedestrian's length and width, m.
    size: (f64, f64),
    /// Its lane.
    path: usize,
    /// Whether it was ever seen to move. One that was not is parked.
    moved: bool,
    /// Where the ways of the two cross, on a path that bends.
    crossing: Option<BendCrossing>,
    /// When it was in sight last (s), and how it moved.
    seen: Option<(f64, Longitudinal)>,
    /// Whether it was in sight and is not now.
    hidden: bool,
}

/// Where the way of a pedestrian crosses a path that bends: it stays while the pedestrian does not turn and the vehicle has not left it.
struct BendCrossing {
    from: Vector2<f64>,
    way: Vector2<f64>,
    area: Option<ConflictArea>,
    /// Whether the vehicle had left it already, and so any other.
    is_last: bool,
}

/// A direction that is normalised anew at every step differs by so much for rounding alone.
const SAME_WAY: f64 = 1e-9;

/// How two come to their conflict.
struct Approaches {
    own: State,
    other: State,
    /// True distance, m, unless they meet at a right angle.
    apart: Option<f64>,
    /// Whether their extents in the conflict space are others than at the step before.
    changed: bool,
}

impl Meeting {
    /// The vehicle is in sight at `time` (s).
    fn sees(&mut self, time: f64, motion: Longitudinal) {
        self.seen = Some((time, motion));
        if std::mem::take(&mut self.hidden) {
            // It may be before a place at which it was thought to be past.
            self.crossing = None;
        }
    }

    /// How the two come to their conflict; `None` if the pedestrian, who walks along `way`, does not cross the vehicle's path.
    fn approaches(
        &mut self,
        me: &PedestrianState,
        way: Vector2<f64>,
        vehicle: &VehicleState,
    ) -> Option<Approaches> {
        // At a right angle, with the bits that this always had.
        if vehicle.path.course().is_none() && way.x == 0.0 {
            let conflict = vehicle.path.conflict(me.position, way)?;
            let own = conflict.approach_on_foot(me, way).into();
            return Some(Approaches {
                own,
                other: conflict.approach(vehicle).into(),
                apart: None,
                changed: false,
            });
        }
        let travelled = vehicle.motion.travelled;
        let is_left = |area: &ConflictArea| area.vehicle.to < travelled;
        let known = self.crossing.take().filter(|known| {
            let goes_on = known.is_last || !known.area.as_ref().is_some_and(is_left);
            (known.way - way).norm() < SAME_WAY && goes_on
        });
        let changed = known.is_none();
        let crossing = known.unwrap_or_else(|| {
            let vehicle_is = (travelled, (vehicle.length, vehicle.width));
            let area = vehicle.path.conflict_area(vehicle_is, (me.position, way), self.size);
            BendCrossing { from: me.position, way, is_last: area.as_ref().is_some_and(is_left), area }
        });
        let BendCrossing { from, area, .. } = self.crossing.insert(crossing);
        let area = area.as_ref()?;
        if changed {
            let body =
                |body: AgentBody, half_extent: f64| AgentBody { half_extent, cosine: area.cosine, ..body };
            self.own = body(self.own, area.pedestrian.half());
            self.other = body(self.other, area.vehicle.half());
        }
        let walked = (me.position - *from).dot(&way);
        let own = Conflict { place: area.vehicle.middle(), distance: area.pedestrian.middle() - walked };
        let apart = (vehicle.position() - me.position).norm();
        Some(Approaches {
            own: own.approach_on_foot(me, way).into(),
            other: own.approach(vehicle).into(),
            apart: Some(apart),
            changed,
        })
    }

    /// As [`Self::approaches`], with a vehicle that is hidden at `time` (s): it is taken to have kept the speed at which it was seen last. `None`
    /// of one that was never seen, too.
    #[cold]
    fn approaches_as_believed(
        &mut self,
        me: &PedestrianState,
        way: Vector2<f64>,
        vehicle: &VehicleState,
        time: f64,
    ) -> Option<Approaches> {
        let (last, seen) = self.seen?;
        self.hidden = true;
        let travelled = seen.travelled + seen.speed * (time - last);
        let motion = Longitudinal { travelled, acceleration: 0.0, ..seen };
        self.approaches(me, way, &vehicle.in_motion(motion))
    }

    /// How the conflict stands at these distances (m) to the conflict point.
    fn conflict(&self, own: f64, other: f64) -> ConflictState {
        if own < -self.own.half_extent || other <= -self.other.half_extent {
            ConflictState::Over
        } else if !self.moved && !self.other.occupies(other) {
            ConflictState::Dormant
        } else {
            ConflictState::Open
        }
    }
}

/// A pedestrian among vehicles.
struct Walker {
    agent: CommotionsAgent,
    /// As it was at the start, with which each leg of a way begins; `None` where the way has one.
    fresh: Option<Box<CommotionsAgent>>,
    meetings: Vec<Meeting>,
    /// Those of this step.
    sights: Vec<Sight>,
    draws: Stream,
    free_speed: f64,
    action_duration: f64,
    steps_per_decision: u64,
    entry_inhibited_until: f64,
    /// Whether it waits for green.
    obeys_signals: bool,
    steps: u64,
    acceleration: f64,
    standing: bool,
}

impl Pedestrian for Walker {
    fn begin_leg(&mut self, _scene: &Scene) {
        if let Some(fresh) = &self.fresh {
            self.agent.clone_from(fresh);
        }
        // Another encounter: where ways meet is told to it anew.
        self.meetings.iter_mut().for_each(|meeting| meeting.crossing = None);
        self.acceleration = 0.0;
    }

    fn act(&mut self, scene: &Scene) -> Motion {
        if self.steps.is_multiple_of(self.steps_per_decision) {
            self.acceleration = self.decide(scene);
        }
        self.steps += 1;
        self.standing = scene.ego().velocity.norm() == 0.0;
        let limit = following::limit(scene);
        Motion::Accelerate(limit.map_or(self.acceleration, |limit| self.acceleration.min(limit)))
    }

    fn look(&mut self, scene: &Scene) {
        if self.steps.is_multiple_of(self.steps_per_decision) {
            let rules = self.sight(scene);
            self.agent.look_among(&self.sights, &rules, &mut self.draws);
        }
        self.steps += 1;
    }

    fn mode(&self) -> Mode {
        Mode::new(if self.standing { "waiting" } else { "walking" })
    }

    fn free_speed(&self) -> f64 {
        self.free_speed
    }

    fn state_quantities(&self) -> Vec<StateQuantity> {
        let quantity = |group: &str, name: String, range| StateQuantity { group: group.into(), name, range };
        let action = |j: usize| match j {
            NO_ACTION => "no new action".to_string(),
            _ => format!("{:+} m/s", ACTION_SIZES[j]),
        };
        let values = (0..ACTIONS).map(|j| quantity("value of each action", action(j), (-1.0, 1.0)));
        let names = new_actions().map(action).chain(["threshold".to_string()]);
        let evidence = names.map(|name| quantity("evidence for each action", name, (-1.0, 1.0)));
        let behaviours = BEHAVIOUR_LIST.iter().map(|behaviour| {
            let name = match behaviour {
                Behaviour::Constant => "keeps its speed",
                Behaviour::PassFirst => "passes first",
                Behaviour::PassSecond => "passes second",
            };
            quantity("what the vehicle does, if no new action", name.into(), (0.0, 1.0))
        });
        values.chain(evidence).chain(behaviours).collect()
    }

    /// V̂ per action and what speaks for each (§8.5, §8.6), and P(b|j) of no new action (§8.4), of the last decision.
    fn state(&self) -> Option<ModelState> {
        let thoughts = self.agent.thoughts()?;
        let (evidence, threshold) = self.agent.evidence();
        let evidence = new_actions().map(|j| evidence[j]).chain([threshold]);
        let beliefs = thoughts.probabilities.iter().map(|of_behaviour| of_behaviour[NO_ACTION]);
        Some(ModelState {
            about: Some(thoughts.other),
            values: thoughts.estimates.iter().copied().chain(evidence).chain(beliefs).collect(),
        })
    }
}

fn new_actions() -> impl Iterator<Item = usize> {
    (0..ACTIONS).filter(|j| *j != NO_ACTION)
}

/// Whether somebody beside the road, or kept on a refuge, has no green. Who is on the road goes on.
fn has_red(scene: &Scene) -> bool {
    let (road, y) = (scene.road, scene.road.across(scene.ego().position));
    let beside = y <= road.kerb(Side::Near) || y >= road.kerb(Side::Far);
    (beside || scene.held) && !scene.pedestrian_priority()
}

impl Walker {
    fn decide(&mut self, scene: &Scene) -> f64 {
        let rules = self.sight(scene);
        let me = scene.ego();
        let speed = me.velocity.dot(&me.heading);
        let decision = self.agent.step_among(&self.sights, &rules, &mut self.draws);
        // With nobody to meet, as on an empty road.
        decision.map_or((self.free_speed - speed) / self.action_duration, |decision| decision.acceleration)
    }

    /// Finds the vehicles that it meets; the rules of the moment.
    fn sight(&mut self, scene: &Scene) -> Rules {
        let me = scene.ego();
        let rules = Rules {
            pedestrian_priority: scene.pedestrian_priority(),
            entry_inhibited: scene.time < self.entry_inhibited_until || self.obeys_signals && has_red(scene),
        };
        let way = me.heading;
        let might_be_hidden = scene.vehicles.len() > 1 || !scene.road.boxes.is_empty();
        // Whom it meets beyond a refuge on which it waits is another leg's matter.
        let leg = match scene.goes_on() {
            false => f64::INFINITY,
            true => (Vector2::from(scene.goal) - me.position).dot(&way),
        };
        let sees_all = sees_all_vehicles(scene);
        self.sights.clear();
        for (other, (meeting, vehicle)) in self.meetings.iter_mut().zip(scene.vehicles).enumerate() {
            let seen = sees_all || sees_vehicle(scene, other);
            let approaches = if seen {
                if might_be_hidden {
                    meeting.sees(scene.time, vehicle.motion);
                }
                meeting.approaches(me, way, vehicle)
            } else {
                meeting.approaches_as_believed(me, way, vehicle, scene.time)
            };
            let Some(Approaches { own, other: state, apart, changed }) = approaches else { continue };
            if own.distance > leg {
                // Where their ways meet has not been told yet.
                meeting.crossing = None;
                continue;
            }
            if changed {
                self.agent.meet(other, meeting.own, meeting.other);
            }
            meeting.moved |= seen && vehicle.motion.speed > 0.0;
            let conflict = meeting.conflict(own.distance, state.distance);
            self.sights.push(Sight { other, path: meeting.path, own, state, apart, conflict });
        }
        rules
    }
}
