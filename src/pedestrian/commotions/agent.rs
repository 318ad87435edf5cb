//! One road user that behaves like a person: stepped by what both publish, it answers with an acceleration (§2, §8).

use super::access::access_orders;
use super::action::{ACTIONS, ActionPlan, NO_ACTION};
pub use super::affordance::Rules;
use super::affordance::{Move, Orders, Party, Valuation};
use super::belief::{Beliefs, PerBehaviour};
use super::decision::Decider;
use super::draws::StandardNormals;
use super::parameters::Parameters;
use super::perception::{Percept, Perception};
use super::prediction::{
    BEHAVIOUR_LIST, BEHAVIOURS, BehaviourAccelerations, PredictedState, behaviours, predict_other,
};
use super::squash::tanh_in_place;
use super::state::{Body, Control, State};
use super::timing::Passage;
use super::variant::Variant;

/// Who meets whom, and how time goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encounter {
    /// The agent's own body.
    pub own: Body,
    /// The other's body.
    pub other: Body,
    /// Time step (s).
    pub dt: f64,
}

/// What an agent does at a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Acceleration from now to the next step (m/s²).
    pub acceleration: f64,
    /// The action taken, if any.
    pub action: Option<usize>,
}

/// What went on in an agent's mind at its last decision, for inspection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thoughts {
    /// The other as perceived.
    pub percept: Percept,
    /// P(b|j).
    pub probabilities: PerBehaviour,
    /// V̂ per action.
    pub estimates: [f64; ACTIONS],
}

/// A road user that perceives, believes, values and acts.
#[derive(Clone, Debug)]
pub struct Agent {
    estimates_behaviour: bool,
    anticipates_influence: bool,
    action_duration: f64,
    own: Party,
    other: Party,
    valuation: Valuation,
    plan: ActionPlan,
    perception: Perception,
    beliefs: Beliefs,
    decider: Decider,
    thoughts: Option<Thoughts>,
}

impl Agent {
    /// An individual of a variant at the start of an encounter.
    pub fn new(variant: &Variant, parameters: &Parameters, encounter: &Encounter) -> Self {
        let Encounter { own, other, dt } = *encounter;
        let valuation = Valuation::new(variant, parameters);
        let saturated_free_value = libm::tanh(valuation.discounting.free_value() / valuation.scale);
        let other_speed = Party::wanted_speed(other.control, parameters);
        Self {
            estimates_behaviour: variant.estimates_behaviour(),
            anticipates_influence: variant.anticipated_influence,
            action_duration: parameters.action_duration,
            own: Party::new(own, parameters),
            other: Party::new(other, parameters),
            valuation,
            plan: ActionPlan::new(own.control, parameters.action_duration, dt),
            perception: Perception::new(variant, parameters, dt, other_speed),
            beliefs: Beliefs::new(variant, parameters, dt),
            decider: Decider::new(variant, parameters, saturated_free_value, dt),
            thoughts: None,
        }
    }

    /// The free speed (m/s) the agent wants.
    pub fn free_speed(&self) -> f64 {
        self.own.manner.free_speed
    }

    /// What went on at the last decision; `None` when the last step needed none.
    pub fn thoughts(&self) -> Option<&Thoughts> {
        self.thoughts.as_ref()
    }

    /// One step: what to do, given what both publish.
    ///
    /// Once out of the conflict space the agent neither perceives (draws no noise) nor decides.
    pub fn step(
        &mut self,
        own: &State,
        other: &State,
        rules: &Rules,
        draws: &mut impl StandardNormals,
    ) -> Decision {
        if own.distance < -self.own.body.half_extent {
            self.thoughts = None;
            return Decision { acceleration: 0.0, action: None };
        }
        self.plan.begin_step(own.speed);
        let percept = self.perception.perceive(own.distance, other.distance, other.speed, draws);
        let accelerations = self.behaviours(own, &percept);
        let perceived =
            State { distance: percept.distance, speed: percept.speed, acceleration: other.acceleration };
        let (values, others_values) = self.values(own, &perceived, &accelerations, rules);
        let probabilities = self.beliefs.update(&percept, &accelerations, &others_values, draws);
        let mut expected = [0.0; ACTIONS];
        for b in 0..BEHAVIOURS {
            for j in 0..ACTIONS {
                expected[j] += probabilities[b][j] * values[b][j];
            }
        }
        let action = self.decider.decide(&expected, draws);
        if let Some(j) = action {
            self.plan.take(j);
            if self.decider.forgets_by_acting() {
                self.beliefs.forget_values();
            }
        }
        self.thoughts = Some(Thoughts { percept, probabilities, estimates: *self.decider.estimates() });
        Decision { acceleration: self.plan.end_step(), action }
    }

    /// What the other may do (§8.1).
    fn behaviours(&self, own: &State, percept: &Percept) -> BehaviourAccelerations {
        behaviours(self.estimates_behaviour, || {
            let with_acceleration =
                self.valuation.other_acceleration && self.own.body.control == Control::Acceleration;
            let passage = Passage::of(own, self.own.body.half_extent, with_acceleration);
            let Party { body, manner, .. } = &self.other;
            access_orders(
                body,
                manner,
                percept.distance,
                percept.speed,
                &self.own.body,
                own.distance,
                &passage,
            )
        })
    }

    /// V(j|b) and W(b|j), squashed (§8.3).
    fn values(
        &self,
        own: &State,
        other: &State,
        accelerations: &BehaviourAccelerations,
        rules: &Rules,
    ) -> (PerBehaviour, PerBehaviour) {
        let valuation = &self.valuation;
        let mut values = [[0.0; ACTIONS]; BEHAVIOURS];
        let mut others_values = [[0.0; ACTIONS]; BEHAVIOURS];
        let destinations = self.plan.destinations(own.distance, own.speed);
        let mut moves = [Move::default(); ACTIONS];
        for (j, own_move) in moves.iter_mut().enumerate() {
            let to = PredictedState::new(destinations.state(j), &self.own.body, valuation.other_acceleration);
            *own_move = valuation.move_to(&self.own, own, to);
        }
        for behaviour in BEHAVIOUR_LIST {
            let b = behaviour as usize;
            let Some(acceleration) = accelerations[b] else { continue };
            let to = predict_other(other, acceleration, self.action_duration);
            let to = PredictedState::new(to, &self.other.body, valuation.other_acceleration);
            let theirs = valuation.move_to(&self.other, other, to);
            for (j, mine) in moves.iter().enumerate() {
                if let Some(same) = (0..j).find(|&same| moves[same].to.state == mine.to.state) {
                    values[b][j] = values[b][same];
                    others_values[b][j] = others_values[b][same];
                    continue;
                }
                values[b][j] =
                    valuation.of_move(&self.own, mine, &self.other, &theirs, Orders::Better, rules);
                if self.anticipates_influence || j == NO_ACTION {
                    let counting = Orders::of(behaviour);
                    others_values[b][j] =
                        valuation.of_move(&self.other, &theirs, &self.own, mine, counting, rules);
                }
            }
            if !self.anticipates_influence {
                others_values[b] = [others_values[b][NO_ACTION]; ACTIONS];
            }
            for row in [&mut values[b], &mut others_values[b]] {
                for value in row.iter_mut() {
                    *value /= valuation.scale;
                }
                tanh_in_place(row);
            }
        }
        (values, others_values)
    }
}
