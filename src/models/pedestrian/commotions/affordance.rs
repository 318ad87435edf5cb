//! Affordance-based values: what the access orders are worth to a road user, seen from its present state (§7).

use super::access::{AccessCourse, Manner, access_orders_that_count};
use super::looming::{LoomingCost, OtherTrack, OwnTrack};
use super::parameters::Parameters;
use super::prediction::{Behaviour, PredictedState};
use super::state::{AgentBody, Control, State};
use super::value::{ActionPhase, AfterAction, Discounting, Gains};
use super::variant::Variant;

/// What holds at a step besides the states of the two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rules {
    /// Whether pedestrians have priority, as on a zebra.
    pub pedestrian_priority: bool,
    /// Whether pedestrians must not enter yet, as while another car is still passing.
    pub entry_inhibited: bool,
}

/// One of the two road users: its body, and how it is assumed to move and to value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Party {
    /// Its body.
    pub body: AgentBody,
    /// What it keeps to.
    pub manner: Manner,
    /// What moving is worth to it.
    pub gains: Gains,
}

impl Party {
    /// A road user of this body with these parameters.
    pub fn new(body: AgentBody, parameters: &Parameters) -> Self {
        let wanted = Self::wanted_speed(body.control, parameters);
        let gains = Gains::for_free_speed(wanted, parameters.acceleration_discomfort);
        let manner = Manner {
            free_speed: gains.free_speed(),
            regain_time: Manner::regain_time(body.control, parameters.action_duration),
            safety_distance: parameters.safety_distance,
            safety_time: parameters.safety_time,
        };
        Self { body, manner, gains }
    }

    /// The free speed (m/s) that this kind of road user wants. [`Manner::free_speed`] is what comes of it in the gains.
    pub fn wanted_speed(control: Control, parameters: &Parameters) -> f64 {
        match control {
            Control::Speed => parameters.pedestrian_free_speed,
            Control::Acceleration => parameters.vehicle_free_speed,
        }
    }

    /// How it moves during an action that takes it from `here` to `to` in `duration` seconds.
    #[inline]
    pub fn action_phase(&self, here: &State, to: &State, duration: f64) -> ActionPhase {
        match self.body.control {
            Control::Speed => {
                ActionPhase { speed: here.speed, acceleration: (to.speed - here.speed) / duration, jerk: 0.0 }
            }
            Control::Acceleration => ActionPhase {
                speed: here.speed,
                acceleration: here.acceleration,
                jerk: (to.acceleration - here.acceleration) / duration,
            },
        }
    }

    /// Whether being at `distance` is entering before one may. Only pedestrians are ever held back.
    #[inline]
    fn enters_early(&self, distance: f64, rules: &Rules) -> bool {
        rules.entry_inhibited
            && self.body.control == Control::Speed
            && distance < self.body.half_extent + self.manner.safety_distance
    }
}

/// A road user about to act: where it is, how the action goes, and where it leads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AgentMove {
    /// State now.
    pub here: State,
    /// The action.
    pub phase: ActionPhase,
    /// What the action is worth and ends with.
    pub action: AfterAction,
    /// Predicted state.
    pub to: PredictedState,
    /// The acceleration that the one who looks at it anticipates for the first sample (m/s², §7.1).
    pub first_acceleration: f64,
    /// The acceleration anticipated for every later sample (m/s²).
    pub later_acceleration: f64,
}

/// Which access orders count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AgentOrders {
    /// The better of the two.
    Better,
    /// Only passing first.
    First,
    /// Only passing second.
    Second,
}

impl AgentOrders {
    /// The orders that a behaviour stands for (§8.3).
    pub fn of(behaviour: Behaviour) -> Self {
        match behaviour {
            Behaviour::Constant => Self::Better,
            Behaviour::PassFirst => Self::First,
            Behaviour::PassSecond => Self::Second,
        }
    }
}

/// How one individual values courses of action.
#[derive(Clone, Debug)]
pub struct Valuation {
    /// Its discounting.
    pub discounting: Discounting,
    /// What looming costs it, if it does.
    pub looming: Option<LoomingCost>,
    /// V_ny: the value for a driver of passing first where pedestrians have priority.
    pub not_yielding_value: f64,
    /// V_0: the scale on which values saturate.
    pub scale: f64,
    /// Whether the other's acceleration is taken into account.
    pub other_acceleration: bool,
    action_duration: f64,
}

impl Valuation {
    /// The valuation of an individual of a variant.
    pub fn new(variant: &Variant, parameters: &Parameters) -> Self {
        let discounting = Discounting::new(parameters.discount_half_life, parameters.action_duration);
        let free_value = discounting.free_value();
        Self {
            looming: variant
                .looming
                .then_some(LoomingCost { onset: parameters.looming_onset, full: parameters.looming_full }),
            not_yielding_value: parameters.not_yielding_value * free_value,
            scale: parameters.value_scale * free_value,
            other_acceleration: variant.other_acceleration,
            action_duration: parameters.action_duration,
            discounting,
        }
    }

    /// The value, not yet squashed, of one party's move against the other's: −∞ if nothing is possible.
    #[inline]
    pub fn of_move(
        &self,
        party: &Party,
        own: &AgentMove,
        other: &Party,
        theirs: &AgentMove,
        counting: AgentOrders,
        rules: &Rules,
    ) -> f64 {
        let to = &own.to.state;
        if party.enters_early(to.distance, rules) {
            return f64::NEG_INFINITY;
        }
        let orders = access_orders_that_count(
            (counting != AgentOrders::Second, counting != AgentOrders::First),
            &party.body,
            &party.manner,
            (to.distance, to.speed),
            (&other.body, theirs.to.state.distance, &theirs.to.passage),
        );
        let mut best = f64::NEG_INFINITY;
        if let Some(course) = &orders.first {
            best = self.of_course(party, own, course, true, other, theirs, rules);
        }
        if let Some(course) = &orders.second {
            let second = self.of_course(party, own, course, false, other, theirs, rules);
            if second > best {
                best = second;
            }
        }
        best
    }

    /// The value of following one course: kinematic, continue, priority and looming parts.
    #[allow(clippy::too_many_arguments, reason = "two road users, and what one of them does")]
    #[inline]
    pub fn of_course(
        &self,
        party: &Party,
        own: &AgentMove,
        course: &AccessCourse,
        passes_first: bool,
        other: &Party,
        theirs: &AgentMove,
        rules: &Rules,
    ) -> f64 {
        let regain_time = party.manner.regain_time;
        let phases = self.discounting.phases(course, regain_time);
        let mut value =
            self.discounting.after_action(&party.gains, own.action.speed, course, regain_time, &phases);
        if phases.integrated > 0 {
            value += own.action.value;
        }
        if passes_first && party.body.control == Control::Acceleration && rules.pedestrian_priority {
            value += self.not_yielding_value;
        }
        if let Some(cost) = &self.looming {
            let own = OwnTrack {
                distance: own.here.distance,
                body: &party.body,
                action: &own.phase,
                achieve: course.acceleration,
                phases: &phases,
                free_speed: party.manner.free_speed,
                regain_time,
            };
            let other = OtherTrack {
                distance: theirs.here.distance,
                speed: theirs.here.speed,
                body: &other.body,
                first_acceleration: theirs.first_acceleration,
                later_acceleration: theirs.later_acceleration,
            };
            value += self.discounting.looming(cost, &own, &other);
        }
        value
    }

    /// The move of a party from `here` to where it is predicted to be.
    #[inline]
    pub fn move_to(&self, party: &Party, here: &State, to: PredictedState) -> AgentMove {
        let phase = party.action_phase(here, &to.state, self.action_duration);
        AgentMove {
            here: *here,
            action: self.discounting.action(&party.gains, &phase),
            phase,
            first_acceleration: (to.state.speed - here.speed) / self.action_duration,
            later_acceleration: if self.other_acceleration { to.state.acceleration } else { 0.0 },
            to,
        }
    }
}
